// What the panels of long work share: kinds, stripes, choices, holding.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, browser, recorder } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { PULLED_IN, kindOf, sample, labelled, hatch, holding, fill, Panel, IMPOSSIBLE } = await from("work");

test("the stripes of a kind in a legend run as the lines across its cells", () => {
  for (const code of [2, 3, 4, 6, 98]) {
    const g = recorder(), angles = [...sample("#000000", code).style.background.matchAll(/gradient\((\d+)deg/g)].map(([, angle]) => (Number(angle) * Math.PI) / 180);
    hatch(g, [[code, 0, 0]], 1, 1);
    const ends = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args);
    const lines = ends.filter((_, k) => k % 2 === 0).map(([x, y], k) => [ends[2 * k + 1][0] - x, ends[2 * k + 1][1] - y]);
    assert.equal(angles.length, lines.length);
    assert.ok(lines.every(([dx, dy]) => Math.hypot(dx, dy) >= 1)); // across the whole cell
    for (const [dx, dy] of lines) assert.ok(angles.some((a) => Math.abs(dx * Math.sin(a) - dy * Math.cos(a)) < 1e-9), `kind ${code}`); // a stripe stands across its gradient
  }
});

test("kinds, labels and choices of panels", () => {
  const legend = { regimes: [{ name: "rest", colour: "#111111" }, { name: "periodic", colour: "#222222" }], pulled_in: { name: "pulled in", colour: "#333333" } };
  assert.deepEqual([kindOf(legend, 1).name, kindOf(legend, PULLED_IN).name, kindOf(legend, IMPOSSIBLE).colour, kindOf(legend, 9).name], ["periodic", "pulled in", LIGHT.line, undefined]);
  assert.deepEqual([labelled({ label: "Film Radius", unit: "mm" }), labelled({ label: "Ratio", unit: "" }), labelled(undefined)], ["film radius (mm)", "ratio", ""]);
  const select = document.createElement("select");
  fill(select, [{ kind: "choice", name: "film", label: "Film" }, { kind: "number", name: "a", label: "A" }, { kind: "number", name: "b", label: "B" }], "b");
  assert.deepEqual([select.options.map((o) => [o.value, o.textContent]), select.value], [[["a", "A"], ["b", "B"]], "b"]);
  const canvas = document.createElement("canvas"), seen = [];
  holding(canvas, (event, settled) => seen.push([event.at, settled]));
  for (const [name, event] of [["move", { at: 0 }], ["down", { at: 1, button: 2 }], ["move", { at: 2 }], ["down", { at: 3, button: 0, isPrimary: false }], ["down", { at: 4, button: 0 }], ["move", { at: 5 }], ["move", { at: 6, isPrimary: false }], ["up", { at: 7 }], ["move", { at: 8 }], ["up", { at: 9 }], ["down", { at: 10, button: 0 }], ["cancel", { at: 11 }]]) canvas[`onpointer${name}`](event);
  assert.deepEqual(seen, [[4, false], [5, false], [7, true], [10, false], [10, true]]);
  const said = [], own = new Panel({ say: (text) => said.push(text), page: { controls: () => ({ list: [{ name: "a", unit: "mm" }, { name: "b", unit: "" }], value: () => 3 }), setting: () => ({ values: {} }) } }, "map");
  for (const share of [0, 0.256, 0.999, 1]) own.progress(share);
  assert.deepEqual([said, own.text("a", 1.23456), own.text("b", 2), own.value("a")], [["0 %", "26 %", "100 %", ""], "1.235 mm", "2", 3]);
});

test("a drag that the system takes away settles where the hand was last", () => {
  const canvas = document.createElement("canvas"), seen = [];
  holding(canvas, (event, settled) => seen.push([event.at, settled]));
  for (const [name, at] of [["down", 1], ["move", 2], ["move", 3], ["cancel", 0], ["move", 4], ["cancel", 5]]) canvas[`onpointer${name}`]({ at, button: 0 });
  assert.deepEqual(seen, [[1, false], [2, false], [3, false], [3, true]]);
});

test("a choice of parameters has the names of the subject that is shown, also where only these change", () => {
  const select = document.createElement("select");
  for (const label of ["Voltage", "Voltage ratio", "Voltage"]) { fill(select, [{ kind: "number", name: "a", label }], "a"); assert.deepEqual(select.options.map((o) => o.textContent), [label]); }
  const [before] = select.options;
  fill(select, [{ kind: "number", name: "a", label: "Voltage" }], "a");
  assert.equal(select.options[0], before); // an open list stays open
});
