// The connection to the server: says when it is lost, and comes back by itself.
import { unpack } from "./frames.js";

const KEY = "gelcone-token";
const SOONEST = 300, LATEST = 3000;

// The token in the address, or that of the last one: the frame of a notebook is loaded again with an address without.
export function tokenOf(search, memory) {
  const given = new URLSearchParams(search).get("token");
  try {
    if (given) memory().setItem(KEY, given);
    return given ?? memory().getItem(KEY) ?? "";
  } catch { return given ?? ""; } // a frame without storage
}

export class Link {
  constructor(token, { opened, lost, message }) {
    this.token = token; this.opened = opened; this.lost = lost; this.message = message;
    this.number = 0; this.wait = SOONEST;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/ws?token=${encodeURIComponent(this.token)}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { this.wait = SOONEST; this.opened(); };
    socket.onmessage = (event) => this.message(...unpack(event.data));
    socket.onclose = () => {
      this.lost();
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LATEST);
    };
    this.socket = socket;
  }

  // Sends a request; its number, or null while there is no connection.
  ask(kind, content = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return null;
    const id = ++this.number;
    this.socket.send(JSON.stringify({ kind, id, ...content }));
    return id;
  }
}
