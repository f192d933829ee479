// The gallery, captions and films.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, browser, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { arranged, broken, caption, composed, filmed } = await from("film"), { Gallery } = await from("gallery");

test("a caption names what is shown, its kind, its numbers in order and what was changed", () => {
  const numbers = new Map([["lag", { name: "lag", place: 2, text: "7°" }], ["stroke", { name: "stroke", place: 0, text: "-15 um" }]]);
  assert.deepEqual(caption("pump", { words: { ended: "", seems: "?" }, lines: ["periodic, period 1"], numbers }, { spring_rate: "9 N/m" }), ["pump: periodic, period 1", "stroke −15 µm, lag 7°", "with spring rate 9 N/m", "gelcone studio"]);
  assert.deepEqual(caption("pump", { words: { ended: "pulled in", seems: "?" } }, {}), ["pump: pulled in", "gelcone studio"]);
});

test("a text breaks into lines that fit, a long word stands alone", () => {
  const g = { measureText: (text) => ({ width: 6 * text.length }) };
  assert.deepEqual(broken(g, "one two three", 48), ["one two", "three"]);
  assert.deepEqual(broken(g, "one two three", 42), ["one two", "three"]); // a line may be as wide as there is room
  assert.deepEqual(broken(g, "incomprehensibilities no", 48), ["incomprehensibilities", "no"]);
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

// --- the gallery -----------------------------------------------------------------------------------------------------

function gallery() {
  const asked = [], chosen = [], dialog = document.getElementById("gallery");
  const own = new Gallery(dialog, { ask: (kind, content) => asked.push([kind, content]), choose: (what) => chosen.push(what) });
  own.show({ devices: ["pump", "cone"], presets: { base: "the base set" } });
  return { own, asked, chosen, dialog };
}
const ABOUT = { disc: 8, rim: 30, second: null, bias: "spring", name: "a pump" };
const arrays = () => ({ t: Float32Array.of(0, 10, 20), x: Float32Array.of(0, 5, 0), film: Uint8Array.of(0, 0, 0) });

test("pictures are asked for one after the other, and what fails says so", () => {
  const { own, asked } = gallery();
  assert.deepEqual(asked, [["glance", { setting: { device: "pump" } }]]);
  assert.equal(own.message({ kind: "glance", id: 99, words: {}, about: ABOUT }, arrays()), true); // of no one
  assert.equal(asked.length, 1);
  assert.equal(own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, arrays()), true);
  assert.equal(own.failed({ id: 7, message: "elsewhere" }), false);
  assert.equal(own.failed({ id: 2, message: "no such cone" }), true);
  assert.deepEqual(asked.slice(1), [["glance", { setting: { device: "cone" } }], ["glance", { setting: { preset: "base" } }]]);
  assert.deepEqual(own.tiles.map(({ note }) => note.textContent), ["a pump", "no such cone", "the base set"]);
  assert.deepEqual([own.tiles[0].look.low, own.tiles[0].look.high], [0, 5]);
  assert.deepEqual(own.tiles.map(({ box }) => [box.querySelector("canvas").getAttribute("aria-label"), box.querySelector("b").textContent]), ["pump", "cone", "base"].map((name) => [`${name}, moving`, name]));
  own.turn();
  assert.ok(own.tiles[0].cone.context.calls.some((c) => c.name === "ellipse"));
  assert.ok(!own.tiles[1].cone.context.calls.some((c) => c.name === "ellipse"));
  assert.equal(own.message({ kind: "response", id: 3 }, {}), false);
});

test("a drive period lasts two seconds in the gallery, and its pictures begin anew at their end", () => {
  const { own } = gallery(), drawn = [];
  own.message({ kind: "glance", id: 1, words: { period: 10 }, about: ABOUT }, { ...arrays(), x: Float32Array.of(0, 5, 1) });
  own.tiles[0].cone.draw = ([side]) => drawn.push(side.height);
  for (const [seconds, height] of [[0, 0], [1, 2.5], [2, 5], [3, 3], [4, 0], [5, 2.5]]) {
    globalThis.performance.now = () => 1000 * seconds;
    own.turn();
    assert.ok(Math.abs(drawn.at(-1) - height) < 1e-6, `${seconds} s`);
  }
  own.stop();
});

test("of two films each is shown in its own state and field", () => {
  const { own } = gallery(), drawn = [], films = { film1: Uint8Array.of(1, 1, 1), film2: Uint8Array.of(2, 2, 2), field1: Float32Array.of(0.2, 0.2, 0.2), field2: Float32Array.of(0.5, 0.5, 0.5) };
  own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, { ...arrays(), ...films });
  own.tiles[0].cone.draw = ([side]) => drawn.push([side.films, side.field.map((value) => value.toFixed(1))]);
  own.turn();
  own.stop();
  assert.deepEqual(drawn, [[[1, 2], ["0.2", "0.5"]]]);
});

test("a click chooses and closes, and a closed gallery asks and draws no more", () => {
  const { own, asked, chosen, dialog } = gallery();
  own.tiles[2].box.onclick();
  assert.deepEqual([chosen, dialog.open], [[{ preset: "base" }], false]);
  own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, arrays());
  assert.equal(asked.length, 1);
  const before = own.tiles[0].cone.context.calls.length;
  own.turn();
  assert.equal(own.tiles[0].cone.context.calls.length, before);
});

test("a film draws its pictures until its time has passed, and ends as one file; without a recorder there is none", async () => {
  const made = [], said = [], steps = [], drawn = [0];
  let now = 5000;
  globalThis.performance.now = () => now;
  const own = globalThis.setInterval, clear = globalThis.clearInterval;
  globalThis.setInterval = (does) => steps.push(does);
  globalThis.clearInterval = (number) => { steps[number - 1] = null; };
  const pictures = { canvas: { captureStream: (rate) => ({ rate }) }, draw: () => { drawn[0] += 1; } };
  assert.equal(filmed(pictures, 2, () => {}), null);
  globalThis.MediaRecorder = class {
    constructor(stream, options) { Object.assign(this, { stream, options, state: "inactive" }); made.push(this); }
    static isTypeSupported(type) { return type.endsWith("vp8"); }
    start() { this.state = "recording"; }
    stop() { this.state = "inactive"; this.ondataavailable({ data: "end" }); this.onstop(); }
  };
  const film = filmed(pictures, 2, (passed) => said.push(passed));
  made[0].ondataavailable({ data: "begin" });
  for (; now <= 7100 && steps[0]; now += 100) steps[0]();
  assert.equal(await (await film).text(), "beginend");
  assert.deepEqual([said[0], said.at(-1), drawn[0], steps[0]], [0, 2, 21, null]);
  assert.match(made[0].options.mimeType, /vp8/);
  assert.ok(made[0].stream.rate >= 20 && made[0].options.videoBitsPerSecond / made[0].stream.rate >= 1e5); // lines a pixel wide stay sharp
  const failing = filmed(pictures, 2, () => {});
  made[1].onerror();
  await assert.rejects(failing, /could not record/);
  Object.assign(globalThis, { setInterval: own, clearInterval: clear });
  delete globalThis.MediaRecorder;
});
