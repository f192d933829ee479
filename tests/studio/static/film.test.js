// Captions, composed pictures and films.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, browser, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { caption, arranged, composed, filmed } = await from("film");

test("a caption names what is shown, its kind, its numbers in order and what was changed", () => {
  const numbers = new Map([["lag", { name: "lag", place: 2, text: "7°" }], ["stroke", { name: "stroke", place: 0, text: "-15 um" }]]);
  assert.deepEqual(caption("pump", { words: { ended: "", seems: "?" }, lines: ["periodic, period 1"], numbers }, { spring_rate: "9 N/m" }), ["pump: periodic, period 1", "stroke −15 µm, lag 7°", "with spring rate 9 N/m", "gelcone studio"]);
  assert.deepEqual(caption("pump", { words: { ended: "pulled in", seems: "?" } }, {}), ["pump: pulled in", "gelcone studio"]);
});

test("pictures stand two a row, none over another", () => {
  const sizes = [[400, 300], [380, 310], [500, 200], [90, 90], [10, 10]], { places, size } = arranged(sizes);
  sizes.forEach(([w, h], k) => {
    const [x, y] = places[k];
    assert.ok(x >= 0 && y >= 0 && x + w <= size[0] && y + h <= size[1]);
    sizes.slice(0, k).forEach(([v, u], j) => assert.ok(x >= places[j][0] + v || y >= places[j][1] + u));
  });
});

test("a composed picture holds all pictures and its caption", () => {
  const pictures = [0, 1].map(() => Object.assign(document.createElement("canvas"), { width: 300, height: 200 }));
  const { canvas } = composed(pictures, ["one", "two"]), g = canvas.getContext();
  assert.deepEqual(g.calls.filter((c) => c.name === "drawImage").map((c) => c.args[0]), pictures);
  assert.deepEqual(texts(g), ["one", "two"]);
  const ground = g.calls.find((c) => c.name === "fillRect"), inks = g.calls.filter((c) => c.name === "fillText").map((c) => c.fillStyle);
  assert.deepEqual([ground.args, ground.fillStyle, inks], [[0, 0, canvas.width, canvas.height], LIGHT.panel, [LIGHT.ink, LIGHT.ink]]);
  const places = g.calls.filter((c) => c.name === "drawImage").map((c) => c.args.slice(1)), lines = g.calls.filter((c) => c.name === "fillText").map((c) => c.args.slice(1));
  assert.deepEqual(places, [[16, 16], [332, 16]]); // with the same margin on all sides
  assert.ok(canvas.width === 332 + 300 + 16 && lines.every(([x]) => x === 16) && lines[0][1] >= 16 + 200 + 16 && canvas.height >= lines[1][1] + 14 + 16);
  assert.ok(canvas.width >= 616 && canvas.height > 240);
  assert.equal(filmed({ canvas, draw() {} }, 1, () => {}), null); // no recorder here
});

test("a film draws its pictures until its time has passed, and ends as one file; without a recorder there is none", async () => {
  const made = [], said = [], steps = [], paces = [], drawn = [0];
  let now = 5000;
  globalThis.performance.now = () => now;
  const own = globalThis.setInterval, clear = globalThis.clearInterval;
  globalThis.setInterval = (does, wait) => { paces.push(wait); return steps.push(does); };
  globalThis.clearInterval = (number) => { steps[number - 1] = null; };
  const pictures = { canvas: { captureStream: (rate) => ({ rate }) }, draw: () => { drawn[0] += 1; } };
  assert.equal(filmed(pictures, 2, () => {}), null);
  globalThis.MediaRecorder = class {
    constructor(stream, options) { Object.assign(this, { stream, options, state: "inactive" }); made.push(this); }
    static isTypeSupported(type) { return type.endsWith("vp8"); }
    start() { this.state = "recording"; }
    stop() { assert.equal(this.state, "recording"); this.state = "inactive"; this.ondataavailable({ data: "end" }); this.onstop(); }
  };
  const film = filmed(pictures, 2, (passed) => said.push(passed));
  made[0].ondataavailable({ data: "begin" });
  for (; now <= 7100 && steps[0]; now += 100) steps[0]();
  assert.equal(await (await film).text(), "beginend");
  assert.deepEqual([said[0], said.at(-1), drawn[0], steps[0]], [0, 2, 21, null]);
  assert.match(made[0].options.mimeType, /vp8/);
  assert.deepEqual([paces[0], made[0].stream.rate], [40, 25]); // each picture is drawn anew, and none twice
  assert.ok(made[0].stream.rate >= 20 && made[0].options.videoBitsPerSecond / made[0].stream.rate >= 1e5); // lines a pixel wide stay sharp
  const failing = filmed(pictures, 2, () => {});
  made[1].onerror();
  await assert.rejects(failing, /could not record/);
  Object.assign(globalThis, { setInterval: own, clearInterval: clear });
  delete globalThis.MediaRecorder;
});

test("captions, and pictures in their places", () => {
  const numbers = new Map([["b", { name: "lag", text: "5°", place: 2 }], ["a", { name: "stroke", text: "3 mm", place: 1 }]]);
  for (const [words, lines, kind] of [[{ ended: "pulled in", seems: "s" }, ["chaotic"], "pulled in"], [{ ended: "", seems: "seems to repeat" }, ["periodic, period 2", "more"], "periodic, period 2"], [{ ended: "", seems: "seems to repeat" }, null, "seems to repeat"]]) {
    assert.deepEqual(caption("pump", { words, lines, numbers }, { film_thickness: "0.3 mm", film: "taut" }), [`pump: ${kind}`, "stroke 3 mm, lag 5°", "with film thickness 0.3 mm, film taut", "gelcone studio"]);
    assert.deepEqual(caption("pump", { words, lines }, {}), [`pump: ${kind}`, "gelcone studio"]);
  }
  assert.deepEqual(arranged([[100, 50], [200, 80], [60, 40]]), { places: [[0, 0], [116, 0], [0, 96]], size: [316, 152] });
});

test("a composed picture is as sharp as the screen, its pictures whole and every line of its caption below them", () => {
  const lines = ["pump: periodic, period 1", "stroke 3 mm, lag 5°", "with film thickness 0.3 mm", "gelcone studio"];
  for (const d of [1, 2, 3]) {
    globalThis.devicePixelRatio = d;
    const { canvas } = composed([0, 1].map(() => Object.assign(document.createElement("canvas"), { width: 300 * d, height: 200 * d })), lines), { calls } = canvas.getContext();
    assert.deepEqual([texts(canvas.getContext()), canvas.width], [lines, (16 + 300 + 16 + 300 + 16) * d]);
    assert.deepEqual(calls.filter((c) => c.name === "drawImage").map((c) => c.args.slice(1)), [[16 * d, 16 * d], [332 * d, 16 * d]]);
    assert.deepEqual(calls.findLast((c) => c.name === "setTransform").args, [d, 0, 0, d, 0, 0]); // of the letters
    for (const { args: [, , y] } of calls.filter((c) => c.name === "fillText")) assert.ok(y >= 16 + 200 && d * (y + 14) <= canvas.height);
  }
  globalThis.devicePixelRatio = 1;
});

test("a film has the best of the forms that the browser can record", () => {
  const all = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"], made = [], { setInterval: own } = globalThis;
  globalThis.setInterval = () => 0;
  for (const [k, best] of all.entries()) {
    globalThis.MediaRecorder = class { static isTypeSupported(type) { return all.slice(k).includes(type); } constructor(stream, options) { made.push(options.mimeType); } start() {} };
    filmed({ canvas: { captureStream: () => ({}) }, draw() {} }, 1, () => {});
    assert.equal(made.at(-1), best);
  }
  globalThis.setInterval = own;
  delete globalThis.MediaRecorder;
});
