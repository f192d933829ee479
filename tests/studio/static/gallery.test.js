// The gallery: what it asks for, draws and chooses.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, made, page } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { Gallery } = await from("gallery");

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
  assert.equal(page.timers.at(-1).wait, 50); // twenty pictures a second
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
});

test("of two films each is shown in its own state and field", () => {
  const { own } = gallery(), drawn = [], films = { film1: Uint8Array.of(1, 1, 1), film2: Uint8Array.of(2, 2, 2), field1: Float32Array.of(0.2, 0.2, 0.2), field2: Float32Array.of(0.5, 0.5, 0.5) };
  own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, { ...arrays(), ...films });
  own.tiles[0].cone.draw = ([side]) => drawn.push([side.films, side.field.map((value) => value.toFixed(1))]);
  own.turn();
  assert.deepEqual(drawn, [[[1, 2], ["0.2", "0.5"]]]);
});

test("a tile has the room of its whole motion, also below the plane of the film", () => {
  const { own } = gallery(), drawn = [];
  own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, { ...arrays(), x: Float32Array.of(-3, 5, -2) });
  own.tiles[0].cone.draw = ([side]) => drawn.push([side.low, side.high, side.about]);
  own.turn();
  assert.deepEqual(drawn, [[-3, 5, ABOUT]]);
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

test("the gallery has a heading, a tile with picture, name and purpose for each device and set, and a way out", () => {
  browser();
  const { dialog } = gallery(), tile = (name, note = "") => `button.tile [canvas ‹${name}, moving› role=img, b "${name}", span${note && ` "${note}"`}]`;
  assert.deepEqual(dialog.parts.map(made), ['h2 "Devices and parameter sets"', `div.tiles [${tile("pump")}, ${tile("cone")}, ${tile("base", "the base set")}]`, 'div.row [button "Close"]']);
});

test("only the tiles in sight are drawn: those that are at least partly within the gallery", () => {
  browser();
  const { own, dialog } = gallery(), [tile] = own.tiles;
  let drawn = 0;
  own.message({ kind: "glance", id: 1, words: { period: 5 }, about: ABOUT }, arrays());
  tile.cone.draw = () => { drawn += 1; };
  dialog.getBoundingClientRect = () => ({ top: 100, height: 400 });
  for (const [top, seen] of [[-20, false], [-1, false], [1, true], [300, true], [499, true], [501, false]]) {
    tile.box.getBoundingClientRect = () => ({ top, height: 100 });
    drawn = 0; own.turn();
    assert.equal(drawn, seen ? 1 : 0, `${top}`);
  }
});
