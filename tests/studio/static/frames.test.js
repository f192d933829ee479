// Frames of the server.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, frame } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { unpack } = await from("frames");

test("a frame holds its head and arrays", () => {
  const [head, arrays] = unpack(frame({ kind: "response", text: "é" === "é" ? "e" : "" }, { x: Float32Array.of(1.5, -2, 3), code: Uint8Array.of(1, 255), none: new Float32Array(0), y: Float32Array.of(7) }));
  assert.equal(head.kind, "response");
  assert.deepEqual([[...arrays.x], [...arrays.code], [...arrays.none], [...arrays.y]], [[1.5, -2, 3], [1, 255], [], [7]]);
  assert.ok(arrays.x instanceof Float32Array && arrays.code instanceof Uint8Array);
});
