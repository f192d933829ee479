// The connection to the server: reports when it is lost, and reconnects by itself.
import { unpack } from "./frames.js";

const KEY = "gelcone-token";
const SOONEST = 300, LATEST = 3000;

// The token in the address, or the last one: a reloaded notebook frame has an address without a token.
export function tokenOf(search, memory) {
  const given = new URLSearchParams(search).get("token");
  try {
    if (given) memory().setItem(KEY, given);
    return given ?? memory().getItem(KEY) ?? "";
  } catch { return given ?? ""; } // a frame without storage
}

// The pasted address of a restarted studio: its token, and the address to open if the port differs; null for anything
// else, such as an address on another machine.
/** @param {string} text @param {{host: string, hostname: string}} here @returns {{token: string, elsewhere: string | null} | null} */
export function newAddress(text, here) {
  try {
    const url = new URL(text.trim()), token = url.searchParams.get("token"), near = [here.hostname, "127.0.0.1", "localhost", "[::1]"];
    if (!token || url.protocol !== "http:" || url.username || !near.includes(url.hostname)) return null;
    return { token, elsewhere: url.host === here.host ? null : `${url.origin}/?token=${encodeURIComponent(token)}` };
  } catch { return null; }
}

export class Link {
  constructor(token, { opened, lost, message }) {
    this.token = token; this.opened = opened; this.lost = lost; this.message = message;
    this.number = 0; this.wait = SOONEST; this.failures = 0;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/ws?token=${encodeURIComponent(this.token)}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { this.wait = SOONEST; this.failures = 0; this.opened(); };
    socket.onmessage = (event) => this.message(...unpack(event.data));
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.failures++;
      this.lost();
      this.timer = setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LATEST);
    };
    this.socket = socket;
  }

  // Reconnects at once with another token.
  renew(token) {
    this.token = token; this.wait = SOONEST;
    clearTimeout(this.timer);
    this.connect();
  }

  // Sends a request and returns its number; null without a connection.
  ask(kind, content = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return null;
    const id = ++this.number;
    this.socket.send(JSON.stringify({ kind, id, ...content }));
    return id;
  }
}
