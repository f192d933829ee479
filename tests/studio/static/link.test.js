// The connection: tokens, addresses, numbered requests.
import assert from "node:assert/strict";
import test from "node:test";
import { Memory, Socket, browser, page, wait } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { tokenOf, newAddress, Link } = await from("link");

test("the token is that of the address, or the one that the tab remembers", () => {
  const memory = new Memory();
  assert.equal(tokenOf("?ticket=spent", () => memory), "");
  assert.equal(tokenOf("?token=mine", () => memory), "mine");
  assert.equal(tokenOf("?ticket=spent", () => memory), "mine");
  assert.equal(tokenOf("?token=mine", () => { throw new Error("no storage"); }), "mine");
  assert.equal(tokenOf("", () => { throw new Error("no storage"); }), "");
});

test("a connection numbers its requests, and comes back ever later when it is lost", () => {
  browser();
  const received = [], link = new Link("a b", { opened: () => received.push("opened"), lost: () => received.push("lost"), message: (...given) => received.push(given) });
  const [socket] = Socket.all;
  assert.equal(socket.url, "ws://127.0.0.1:9/ws?token=a%20b");
  assert.equal(link.ask("hello"), null);
  socket.open();
  assert.deepEqual([link.ask("hello"), link.ask("look", { side: "a" }), received], [1, 2, ["opened"]]);
  assert.deepEqual(socket.sent, [{ kind: "hello", id: 1 }, { kind: "look", id: 2, side: "a" }]);
  socket.give({ kind: "response" }, { x: Float32Array.of(1) });
  assert.deepEqual([received[1][0].kind, [...received[1][1].x]], ["response", [1]]);
  socket.close();
  assert.equal(received.at(-1), "lost");
  const waits = [];
  for (let k = 0; k < 6; k++) { waits.push(page.timers.at(-1).wait); wait(1e9); Socket.all.at(-1).close(); }
  assert.deepEqual(waits, [300, 600, 1200, 2400, 3000, 3000]);
  wait(1e9); Socket.all.at(-1).open(); Socket.all.at(-1).close();
  assert.equal(page.timers.at(-1).wait, 300);
});

test("of a studio that was started anew the page takes the printed address, of this machine alone", () => {
  const here = { host: "127.0.0.1:9", hostname: "127.0.0.1" };
  assert.deepEqual(newAddress(" http://127.0.0.1:9/?token=abc#device=x ", here), { token: "abc", elsewhere: null });
  assert.deepEqual(newAddress("http://localhost:81/?token=a%26b", here), { token: "a&b", elsewhere: "http://localhost:81/?token=a%26b" });
  for (const text of ["", "abc", "http://127.0.0.1:9/", "https://127.0.0.1:9/?token=a", "http://evil.example/?token=a", "http://127.0.0.1@evil.example/?token=a", "http://me@127.0.0.1:9/?token=a", "javascript:alert(1)//?token=a"]) assert.equal(newAddress(text, here), null, text);
});

test("a connection that was renewed forgets the one before", () => {
  browser();
  const lost = [], own = new Link("old", { opened: () => {}, lost: () => lost.push(own.failures), message: () => {} });
  const [before] = Socket.all;
  before.close(); wait(300);
  Socket.all[1].close();
  assert.deepEqual(lost, [1, 2]);
  own.renew("new");
  assert.equal(new URL(Socket.all.at(-1).url).searchParams.get("token"), "new");
  const count = Socket.all.length;
  before.onclose(); wait(9999);
  assert.deepEqual([lost.length, Socket.all.length], [2, count]);
  Socket.all.at(-1).open();
  assert.equal(own.failures, 0);
});

test("tokens and addresses of a studio", () => {
  const memory = new Memory();
  assert.deepEqual([tokenOf("", () => memory), tokenOf("?token=one", () => memory), tokenOf("", () => memory), tokenOf("?token=two", () => { throw new Error("none"); }), tokenOf("", () => { throw new Error("none"); })], ["", "one", "one", "two", ""]);
  const here = { host: "127.0.0.1:8000", hostname: "127.0.0.1" };
  for (const [text, found] of [
    [" http://127.0.0.1:8000/?token=abc ", { token: "abc", elsewhere: null }], ["http://localhost:8001/?token=a%26b", { token: "a&b", elsewhere: "http://localhost:8001/?token=a%26b" }], ["http://[::1]:9/?token=x", { token: "x", elsewhere: "http://[::1]:9/?token=x" }],
    ["https://127.0.0.1:8000/?token=abc", null], ["http://127.0.0.1:8000/", null], ["http://evil.example/?token=abc", null], ["http://me@127.0.0.1:8000/?token=abc", null], ["nonsense", null],
  ]) assert.deepEqual(newAddress(text, here), found, text);
});
