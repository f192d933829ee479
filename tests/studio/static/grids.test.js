// Map, sweep and envelope: cells in their places, clicks at their values, what is asked and when.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, boxes, browser, draw, forget, near, overlapping, recorder, texts, wait } from "./page.js";

browser();
const { GridPanels } = await import("../../../src/gelcone/studio/static/grids.js");
const { Controls } = await import("../../../src/gelcone/studio/static/controls.js");
const { hatch, sample } = await import("../../../src/gelcone/studio/static/work.js");

const number = (name, value, low, high, unit = "", powers = { "": 0 }) => ({ name, label: name, group: "Drive", kind: "number", value, unit, low, high, powers, about: "", choices: [] });
const VOLTS = { V: 0, kV: 3, mV: -3, MV: 6 }, HERTZ = { Hz: 0, kHz: 3, mHz: -3 };
const LIST = [
  { ...number("waveform", "sine", 0, 1), kind: "choice", choices: ["sine", "triangle"] },
  number("voltage_amplitude", 800, 0, 1600, "V", VOLTS), number("voltage_offset", 1, 0, 2, "kV", VOLTS), number("frequency", 10, 0.1, 20, "Hz", HERTZ), number("film_thickness", 0.2, 0.01, 0.4, "mm", { m: 0, mm: -3 }),
];
const LEGEND = { regimes: [{ name: "rest", colour: "#777777" }, { name: "periodic", colour: "#0072b2" }, { name: "quasi-periodic", colour: "#009e73" }, { name: "chaotic", colour: "#d55e00" }], pulled_in: { name: "pulled in", colour: "#5b5b5b" } };

function setUp(right = "map") {
  browser();
  const $ = (id) => document.getElementById(id), asked = [], gone = [];
  const state = { x: null, y: null, over: null, right, view: "kind" }, setting = { device: "pump", preset: null, file: null, values: {} };
  const controls = new Controls({ drive: $("drive"), groups: $("groups"), group: $("group"), general: $("general"), changed() {} });
  controls.show(LIST, {});
  const page = {
    ask: (kind, content) => { asked.push([kind, content]); return asked.length; }, setting: () => setting, state: () => state, legend: () => LEGEND, controls: () => controls,
    look: () => ({ about: { si: true, axes: { displacement: "height (mm)" } } }), go: (values, settled) => { gone.push([values, settled]); Object.assign(setting.values, values); controls.values(setting.values); }, keep() {},
  };
  const grids = new GridPanels({ hosts: { map: $("map"), strip: $("strip"), envelope: $("envelope") }, share: $("grid-share"), page });
  grids.controlsChanged();
  const panel = grids.open;
  return { grids, panel, asked, gone, state, setting, controls, page, said: () => $("grid-share").textContent, p: panel.plot, canvas: panel.plot.canvas, id: () => panel.id };
}
const pointer = (p, x, y) => ({ clientX: 10 + x, clientY: 20 + y, pointerId: 1 });
const placed = (p, name) => p.marks.get(name).hidden ? null : p.marks.get(name).style.transform.match(/-?[\d.]+/g).map(Number);

// All cells of a map, as the server sends them: of a kind by their place.
function cells(kind) {
  const places = [], regime = [];
  for (let i = 0; i < 65; i++) for (let j = 0; j < 49; j++) { places.push(i * 49 + j); regime.push(kind(i, j)); }
  const own = Float32Array.from(places);
  return { places: own, regime: Uint8Array.from(regime), exponent: own.map((k) => (k % 49) / 48 - 0.5), low: own.map(() => 1), high: own.map((k) => 1 + Math.floor(k / 49) / 64) };
}

test("a map is asked for over the drive, once it is looked at", () => {
  const { asked, said, state } = setUp();
  assert.deepEqual(asked, [["map", { setting: { device: "pump", preset: null, file: null, values: {} }, x: ["voltage_amplitude", 0, 1600], y: ["frequency", 0.1, 20] }]]);
  assert.deepEqual([said(), state.x[0], state.y[0]], ["0 %", "voltage_amplitude", "frequency"]);
});

test("every cell is painted in its place and in the colour of its kind", () => {
  const { grids, panel, id, p, said } = setUp();
  let image = null;
  panel.canvas.getContext("2d");
  const found = cells((i, j) => (i > 40 ? 3 : j > 30 ? 1 : 0));
  found.regime[0] = 99;
  grids.message({ kind: "grid", id: id(), grid: "map", cells: [65, 49] }, {});
  grids.message({ kind: "cells", id: id(), share: 0.5 }, found);
  draw();
  assert.equal(said(), "50 %");
  image = panel.canvas.getContext("2d").calls.findLast((c) => c.name === "putImageData").args[0].data;
  const colour = (i, j) => `#${[...image.slice(4 * ((48 - j) * 65 + i), 4 * ((48 - j) * 65 + i) + 3)].map((v) => v.toString(16).padStart(2, "0")).join("")}`;
  assert.deepEqual([colour(1, 0), colour(0, 48), colour(64, 0), colour(41, 48), colour(40, 30), colour(0, 0)], ["#777777", "#0072b2", "#d55e00", "#d55e00", "#777777", LIGHT.line]);
  const { args } = p.context.calls.findLast((c) => c.name === "drawImage"), wide = (p.right - p.left) / 64, tall = (p.bottom - p.top) / 48;
  [p.left - wide / 2, p.top - tall / 2, p.right - p.left + wide, p.bottom - p.top + tall].forEach((v, k) => assert.ok(near(args[k + 1], v)));
  assert.deepEqual(panel.names.parts.map((e) => [e.textContent, e.parts[0].style.background.split(", ").at(-1)]), [["rest", "#777777"], ["periodic", "#0072b2"], ["chaotic", "#d55e00"], ["not a valid actuator", LIGHT.line]]);
  assert.deepEqual(panel.names.parts.map((e) => e.parts[0].style.background.includes("gradient")), [false, false, true, false]);
  const hatches = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle.startsWith("rgba(255"));
  assert.equal(hatches.length, 2 * 24 * 49); // the chaotic cells, and no others: from corner to corner
  assert.ok(hatches.every(({ args: [x] }) => x >= p.X(800 * 2 * (40.4 / 64))));
  const heights = hatches.map(({ args: [, y] }) => y); // of cells that are centred on their values, from the lowest to the highest
  assert.ok(near(Math.max(...heights), p.bottom + tall / 2) && near(Math.min(...heights), p.top - tall / 2));
  panel.view.value = "exponent"; forget(p.context); p.redraw();
  assert.ok(!p.context.calls.some((c) => c.strokeStyle.startsWith?.("rgba(255")));
  panel.view.value = "kind";
});

test("what is not known yet has the colour of the nearest that is, a little paler", () => {
  const { grids, panel, id } = setUp();
  const one = { places: Float32Array.of(0, 64 * 49 + 48), regime: Uint8Array.of(1, 3), exponent: Float32Array.of(0, 0), low: Float32Array.of(0, 0), high: Float32Array.of(0, 0) };
  grids.message({ kind: "cells", id: id(), share: 0.01 }, one);
  const from = panel.nearest();
  assert.deepEqual([from[0], from[1], from[49], from[64 * 49 + 47], from[63 * 49 + 48]], [0, 0, 0, 64 * 49 + 48, 64 * 49 + 48]);
  draw();
  const image = panel.canvas.getContext("2d").calls.findLast((c) => c.name === "putImageData").args[0].data;
  assert.deepEqual([image[4 * 48 * 65 + 3], image[4 * (48 * 65 + 1) + 3]], [255, 215]);
});

test("exponents and strokes have their scales, and the legend their ends", () => {
  const { grids, panel, id, state } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  panel.view.value = "exponent"; panel.view.onchange();
  assert.equal(state.view, "exponent");
  const shade = panel.shader(panel.nearest());
  const [cold, hot] = [shade(0), shade(48)].map((css) => css.match(/\d+/g).map(Number));
  assert.ok(cold[2] > 150 && cold[0] < 60 && hot[0] > 180 && hot[2] < 60); // blue attracts, red is chaotic
  assert.deepEqual(panel.names.parts.map((e) => e.textContent), ["attracting, to -0.5", "chaotic, to +0.5"]);
  panel.view.value = "stroke"; panel.view.onchange();
  assert.deepEqual(panel.names.parts.map((e) => e.textContent), ["0 mm", "0.5 mm", "1 mm or more"]);
  const stroke = panel.shader(panel.nearest());
  assert.deepEqual([stroke(0), stroke(64 * 49)], ["rgb(11,42,82)", "rgb(246,230,75)"]);
});

test("each colour in the legend of a map is the one in which its cells are painted", () => {
  const { grids, panel, id } = setUp(), values = (css) => (css.startsWith("#") ? [1, 3, 5].map((k) => parseInt(css.slice(k, k + 2), 16)) : css.match(/\d+/g).map(Number));
  grids.message({ kind: "cells", id: id(), share: 1 }, cells((i) => (i > 40 ? 3 : 1)));
  const painted = (i, j) => [...panel.canvas.getContext("2d").calls.findLast((c) => c.name === "putImageData").args[0].data.slice(4 * ((48 - j) * 65 + i), 4 * ((48 - j) * 65 + i) + 3)];
  // kinds: left of a border and right of it; exponents: the lowest below, the highest above; strokes: from left to right
  for (const [view, places] of [["kind", [[0, 0], [64, 0]]], ["exponent", [[0, 0], [0, 48]]], ["stroke", [[0, 0], [32, 0], [64, 0]]]]) {
    panel.view.value = view; panel.view.onchange();
    const swatches = panel.names.parts.map((item) => values(item.parts[0].style.background.split(/, (?=[^,]*$)/).at(-1)));
    assert.deepEqual(swatches, places.map(([i, j]) => painted(i, j)), view);
  }
});

test("thresholds and bifurcations are lines over the map, either way round, with their names", () => {
  const { grids, panel, id, p } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  for (const upright of [false, true]) {
    const volts = Float32Array.of(400, 800, 1200), at = Float32Array.of(5, 10, 15);
    grids.message({ kind: "thresholds", id: id(), upright, names: ["pull-in"] }, { at, "pull-in": volts });
    assert.deepEqual([panel.lines[0].x, panel.lines[0].y].map((v) => [...v]), upright ? [[400, 800, 1200], [5, 10, 15]] : [[5, 10, 15], [400, 800, 1200]]);
  }
  grids.message({ kind: "loci", id: id(), name: "fold" }, { x: Float32Array.of(100, 200), y: Float32Array.of(3, 4) });
  forget(p.context); draw();
  const dashed = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.ink).map((c) => c.args);
  [[400, 5], [800, 10], [1200, 15], [100, 3], [200, 4]].forEach(([x, y], k) => assert.ok(near(dashed[k][0], p.X(x)) && near(dashed[k][1], p.Y(y))));
  assert.ok(texts(p.context).includes("pull-in") && texts(p.context).includes("fold"));
});

test("names of lines over a map stand apart and inside, at their lines, and one without room is left out", () => {
  const { grids, panel, id, p } = setUp(), at = Float32Array.from({ length: 40 }, (_, k) => 0.5 + k / 2);
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  const names = ["rest becomes unstable", "pull-in of the cone at the peak", "flat film loses its stability at the peak"];
  for (const [apart, count] of [[400, 3], [4, 3], [0.01, 3]]) {
    grids.message({ kind: "thresholds", id: id(), upright: true, names }, { at, ...Object.fromEntries(names.map((name, k) => [name, at.map(() => 400 + k * apart)])) });
    forget(p.context); panel.dirty = true; p.redraw();
    const all = boxes(p.context), named = all.filter(([text]) => names.includes(text));
    assert.equal(named.length, count, apart);
    assert.deepEqual(overlapping(all), [], apart);
    for (const [text, left, top, right, bottom] of named) {
      const line = p.X(400 + names.indexOf(text) * apart);
      assert.ok(left >= p.left && right <= p.right && top >= p.top && bottom <= p.bottom && near((left + right) / 2, line, 1e-3), `${text} ${apart}`);
    }
  }
  // seven lines in one place have room for as many names as there are places along them
  const many = Array.from({ length: 7 }, (_, k) => `line ${k}`);
  grids.message({ kind: "thresholds", id: id(), upright: true, names: many }, { at, ...Object.fromEntries(many.map((name) => [name, at.map(() => 800)])) });
  forget(p.context); p.redraw();
  assert.deepEqual([overlapping(boxes(p.context)), boxes(p.context).filter(([text]) => many.includes(text)).length], [[], 5]);
});

test("a map is done once its thresholds are followed", () => {
  const { grids, panel, id, said } = setUp(), own = id();
  grids.message({ kind: "done", id: own, grid: "map" }, {});
  assert.deepEqual([panel.running, panel.filled, said()], [true, true, "following bifurcations …"]);
  grids.message({ kind: "followed", id: own }, {});
  assert.deepEqual([panel.running, said()], [false, ""]);
  assert.equal(grids.message({ kind: "cells", id: 999 }, {}), true); // of an older map: nothing happens
  assert.equal(grids.message({ kind: "response", id: 999 }, {}), false);
});

test("a click on the map goes to its values, and the ring stands at the setting", () => {
  const { panel, p, canvas, gone } = setUp();
  canvas.onpointerdown(pointer(p, p.X(1234), p.Y(7.5))); canvas.onpointermove(pointer(p, p.X(1234) + 2, p.Y(7.5))); canvas.onpointerup(pointer(p, p.X(1234) + 2, p.Y(7.5)));
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "1234 V", frequency: "7.5 Hz" });
  panel.redrawOver();
  const ring = placed(p, "ring");
  assert.ok(near(ring[0], p.X(1234), 0.01) && near(ring[1], p.Y(7.5), 0.01));
  canvas.onpointerdown(pointer(p, 0, 479)); canvas.onpointerup(pointer(p, 0, 479)); // outside: the nearest inside
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "0 V", frequency: "0.1 Hz" });
});

test("a drag over the map zooms to it, and Whole goes back", () => {
  const { panel, p, canvas, state, asked } = setUp();
  const [from, to] = [[p.X(400), p.Y(15)], [p.X(1200), p.Y(5)]];
  canvas.onpointerdown(pointer(p, ...to)); canvas.onpointermove(pointer(p, ...from));
  const box = p.marks.get("box");
  assert.ok(!box.hidden && near(parseFloat(box.style.width), to[0] - from[0], 1e-3) && near(parseFloat(box.style.height), to[1] - from[1], 1e-3));
  canvas.onpointerup(pointer(p, ...from));
  assert.deepEqual([state.x, state.y], [["voltage_amplitude", 400, 1200], ["frequency", 5, 15]]);
  assert.deepEqual([asked.at(-1)[0], asked.at(-1)[1].x, asked.at(-1)[1].y], ["map", state.x, state.y]);
  assert.equal(panel.out.disabled, false);
  panel.out.click();
  assert.deepEqual([state.x, state.y, panel.out.disabled], [["voltage_amplitude", 0, 1600], ["frequency", 0.1, 20], true]);
});

test("a drag without breadth or height, one outside, and one that the system takes away leave the map as it is", () => {
  const { p, canvas, state, asked, gone } = setUp(), before = JSON.stringify([state.x, state.y]), drag = (from, to, end = "up") => {
    canvas.onpointerdown(pointer(p, ...from)); canvas.onpointermove(pointer(p, ...to));
    const shown = placed(p, "box");
    canvas[`onpointer${end}`](pointer(p, ...to));
    assert.deepEqual([JSON.stringify([state.x, state.y]), asked.length, gone.length, Boolean(shown), placed(p, "box")], [before, 1, 0, true, null]);
  };
  drag([100, 100], [300, 100]); drag([100, 100], [100, 300]); // along an axis
  drag([5, 100], [30, 300]); drag([100, 460], [300, 475]); // beside and below the axes
  drag([100, 100], [300, 300], "cancel");
  canvas.onpointerup(pointer(p, 300, 300)); // of no drag
  assert.deepEqual([asked.length, gone.length], [1, 0]);
});

test("pictures over parameters are named by what they are over, in the order along and up", () => {
  for (const [right, name] of [["map", "Map over voltage_amplitude and frequency. "], ["strip", "Sweep of voltage_amplitude: "]]) assert.ok(setUp(right).canvas.getAttribute("aria-label").startsWith(name), right);
  const { panel, state, canvas } = setUp();
  panel.x.value = "film_thickness"; panel.x.onchange();
  assert.ok(canvas.getAttribute("aria-label").startsWith(`Map over film_thickness and ${state.y[0]}. `));
});

test("what a picture waits for, or lacks, is said beside the mark of a setting in its middle", () => {
  for (const problem of [null, "no such range: ".repeat(20)]) {
    const { grids, panel, id, p } = setUp();
    forget(p.context);
    if (problem) grids.failed({ id: id(), message: problem }); else p.redraw();
    panel.page.go({ voltage_amplitude: "800 V", frequency: "10.05 Hz" }); panel.redrawOver();
    const [x, y] = placed(p, "ring"), said = boxes(p.context).filter(([text]) => /computing|no such/.test(text));
    assert.ok(said.length > 0 && said.every(([, left, top, right, bottom]) => x < left - 6 || x > right + 6 || y < top - 6 || y > bottom + 6), `${problem}`);
  }
});

test("a setting beyond a picture is marked at its nearest edge", () => {
  const { panel, state, p } = setUp();
  Object.assign(state, { x: ["voltage_amplitude", 400, 1200], y: ["frequency", 5, 15] });
  p.redraw();
  for (const [volts, hertz, x, y] of [[200, 10, "left", null], [1500, 10, "right", null], [800, 1, null, "bottom"], [800, 19, null, "top"], [1500, 1, "right", "bottom"]]) {
    panel.page.go({ voltage_amplitude: `${volts} V`, frequency: `${hertz} Hz` }); panel.redrawOver();
    const ring = placed(p, "ring");
    assert.ok(near(ring[0], x ? p[x] : p.X(volts), 0.01) && near(ring[1], y ? p[y] : p.Y(hertz), 0.01), `${volts} V, ${hertz} Hz`);
  }
  const own = envelope();
  for (const [hertz, volts, x, y] of [[14, 800, null, null], [19, 800, "right", null], [10, 8000, null, "top"]]) {
    own.panel.page.go({ frequency: `${hertz} Hz`, voltage_amplitude: `${volts} V`, voltage_offset: `${volts * 1.25} V` }); own.panel.redrawOver();
    const ring = placed(own.p, "ring");
    assert.ok(near(ring[0], x ? own.p[x] : own.p.X(hertz), 0.01) && near(ring[1], y ? own.p[y] : own.p.Y(volts * 2.25), 0.01), `${hertz} Hz, ${volts} V`);
  }
});

test("Full range is offered wherever an axis shows less, and then both show all", () => {
  const whole = { x: ["voltage_amplitude", 0, 1600], y: ["frequency", 0.1, 20] };
  for (const part of [{ x: ["voltage_amplitude", 1, 1600] }, { x: ["voltage_amplitude", 0, 1599] }, { y: ["frequency", 1, 20] }, { y: ["frequency", 0.1, 19] }]) {
    const { panel, state, p } = setUp();
    Object.assign(state, structuredClone(whole), part);
    p.redraw();
    assert.equal(panel.out.disabled, false, JSON.stringify(part));
    panel.out.click();
    assert.deepEqual([state.x, state.y, panel.out.disabled], [whole.x, whole.y, true], JSON.stringify(part));
  }
});

test("keys move the setting by a cell and zoom about it", () => {
  const { canvas, gone, state } = setUp(), key = (name) => canvas.onkeydown({ key: name, preventDefault() {} });
  key("ArrowRight");
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "825 V", frequency: "10 Hz" });
  key("ArrowDown");
  assert.equal(gone.at(-1)[0].frequency, `${Number((10 - 19.9 / 48).toPrecision(4))} Hz`);
  key("ArrowLeft"); key("ArrowUp");
  assert.equal(gone.at(-1)[0].voltage_amplitude, "800 V");
  key("+");
  assert.deepEqual(state.x, ["voltage_amplitude", 400, 1200]);
  key("-"); key("-");
  assert.deepEqual(state.x, ["voltage_amplitude", 0, 3200].map((v) => v));
});

test("another parameter along an axis is asked for, never the same on both", () => {
  const { panel, state, asked } = setUp();
  panel.x.value = "film_thickness"; panel.x.onchange();
  assert.deepEqual([state.x, asked.at(-1)[1].x], [["film_thickness", 0.01, 0.4], ["film_thickness", 0.01, 0.4]]);
  panel.y.value = "film_thickness"; panel.y.onchange();
  assert.notEqual(state.x[0], state.y[0]);
});

test("a change of something else makes a map outdated, computed again once the hand rests; one of its axes does not", () => {
  const { grids, panel, asked, said, p, id } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  grids.changed(["frequency"]); grids.changed(["voltage_amplitude"]);
  assert.equal(asked.length, 1);
  forget(p.context);
  grids.changed(["film_thickness"]);
  assert.deepEqual([asked.at(-1), said(), panel.running], [["cancel", { grid: "map" }], "settings changed", false]);
  assert.equal(p.context.calls.find((c) => c.name === "drawImage").globalAlpha, 0.45);
  wait(400);
  assert.equal(asked.length, 2);
  wait(500);
  assert.equal(asked.at(-1)[0], "map");
});

test("what nobody looks at is cancelled, and begun again when it is", () => {
  const { grids, state, asked } = setUp();
  state.right = "strip"; grids.opened("strip");
  assert.deepEqual(asked.slice(1).map(([kind, content]) => [kind, content.grid ?? content.over]), [["cancel", "map"], ["strip", ["voltage_amplitude", 0, 1600]]]);
  state.right = "map"; grids.opened("map");
  assert.deepEqual(asked.slice(3).map(([kind]) => kind), ["cancel", "map"]);
});

test("what is asked for without a connection is asked again with one", () => {
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, panel, asked, said, page } = setUp(kind), { ask } = page;
    grids.lost();
    page.ask = () => null;
    grids.opened();
    assert.deepEqual([panel.running, panel.stale, said()], [false, true, ""], kind);
    page.ask = ask;
    grids.opened();
    assert.deepEqual([panel.running, panel.stale, asked.length], [true, false, 2], kind);
  }
});

test("what went wrong is said in the panel, and after a lost connection all is asked anew", () => {
  const { grids, panel, id, p, asked, said } = setUp();
  assert.equal(grids.failed({ id: 77, message: "elsewhere" }), false);
  const own = id();
  assert.equal(grids.failed({ id: own, message: "no such range" }), true);
  assert.equal(grids.failed({ id: own, message: "once more" }), false); // a question has one answer
  assert.ok(texts(p.context).some((text) => text.startsWith("no such")));
  assert.deepEqual([panel.running, said()], [false, ""]);
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, panel, asked } = setUp(kind), again = () => asked.filter(([own]) => own === kind).length;
    grids.opened();
    assert.deepEqual([again(), panel.stale], [1, false]);
    grids.lost(); grids.opened();
    assert.deepEqual([again(), panel.stale], [2, false], kind);
  }
});

// --- the sweep -------------------------------------------------------------------------------------------------------

test("a sweep has each value's section in its place and colour", () => {
  const { grids, p, id, panel } = setUp("strip");
  grids.message({ kind: "grid", id: id(), grid: "strip", cells: [5] }, {});
  grids.message({ kind: "cells", id: id(), share: 0.4 }, { places: Float32Array.of(0, 3), regime: Uint8Array.of(1, 3), section: Float32Array.of(1, 1, 2, 4) });
  forget(p.context); draw();
  const marks = p.context.calls.filter((c) => c.name === "fillRect" && c.args[3] === 1.8);
  assert.deepEqual(marks.map((c) => c.fillStyle), ["#0072b2", "#0072b2", "#d55e00", "#d55e00"]);
  [[0, 1], [0, 1], [1200, 2], [1200, 4]].forEach(([x, y], k) => { const [px, py, w] = marks[k].args; assert.ok(near(px + w / 2, p.X(x)) && near(py + 0.9, p.Y(y))); });
  assert.deepEqual(panel.names.parts.map((e) => e.textContent), ["periodic", "chaotic"]);
  assert.ok(texts(p.context).includes("height (mm): once per period; shaded: range") && texts(p.context).includes("voltage_amplitude (V)"));
});

test("the legend of a sweep names kinds of motion alone, and no values of which no actuator can be made", () => {
  const { grids, id, panel } = setUp("strip");
  grids.message({ kind: "grid", id: id(), grid: "strip", cells: [5] }, {});
  grids.message({ kind: "cells", id: id(), share: 0.4 }, { places: Float32Array.of(0, 3), regime: Uint8Array.of(1, 99), section: Float32Array.of(1, 1, NaN, NaN) });
  draw();
  assert.deepEqual(panel.names.parts.map((e) => e.textContent), ["periodic"]);
});

test("a sweep has the range of each value behind its section, and is grey where the film pulls in", () => {
  const { grids, p, id, panel } = setUp("strip");
  grids.message({ kind: "grid", id: id(), grid: "strip", cells: [5] }, {});
  grids.message({ kind: "cells", id: id(), share: 0.4 }, { places: Float32Array.of(0, 3), regime: Uint8Array.of(1, 98), section: Float32Array.of(1, 1, NaN, NaN), low: Float32Array.of(-7, NaN), high: Float32Array.of(9, NaN) });
  forget(p.context); draw();
  const bars = p.context.calls.filter((c) => c.name === "fillRect" && c.args[3] > 5 && c.globalAlpha < 0.5);
  const [band, grey] = bars;
  assert.deepEqual([bars.length, band.fillStyle, grey.fillStyle], [2, "#0072b2", "#5b5b5b"]);
  assert.ok(near(band.args[1], p.Y(9)) && near(band.args[3], p.Y(-7) - p.Y(9)) && near(band.args[0] + band.args[2] / 2, p.X(0)));
  assert.ok(near(grey.args[1], p.top) && near(grey.args[3], p.bottom - p.top) && near(grey.args[0] + grey.args[2] / 2, p.X(1200)));
  assert.ok(p.Y(9) > p.top && p.Y(-7) < p.bottom);
  assert.deepEqual(panel.names.parts.map((e) => e.textContent), ["periodic", "pulled in"]);
});

test("branches over a sweep: stable whole, unstable dashed, events with the signs of the legend", () => {
  const { grids, p, id, panel } = setUp("strip"), own = id();
  grids.message({ kind: "grid", id: own, cells: [5] }, {});
  grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0, 4), regime: Uint8Array.of(1, 1), section: Float32Array.of(0, 4) });
  grids.message({ kind: "done", id: own }, {});
  forget(p.context);
  grids.message({ kind: "branches", id: own, kinds: ["fold", "period doubling"] }, { value: Float32Array.of(100, 200, 300, NaN), section: Float32Array.of(1, 2, 3, NaN), stable: Uint8Array.of(1, 1, 0, 0), event_value: Float32Array.of(250), event_section: Float32Array.of(2.5), event_kind: Uint8Array.of(1) });
  const ink = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.ink);
  const whole = ink.filter((c) => !c.dash.length && c.lineWidth === 1.5).map((c) => c.args), dashed = ink.filter((c) => c.dash.length).map((c) => c.args);
  assert.ok(near(whole[0][0], p.X(100)) && near(whole[1][1], p.Y(2)) && whole.length === 2);
  assert.ok(near(dashed[0][0], p.X(300)) && near(dashed[0][1], p.Y(3)) && dashed.length === 1);
  const sign = ink.filter((c) => !c.dash.length && c.lineWidth === 1.4).map((c) => c.args);
  assert.equal(sign.length, 4); // a diamond, the second sign
  const middle = [0, 1].map((k) => (Math.min(...sign.map((at) => at[k])) + Math.max(...sign.map((at) => at[k]))) / 2);
  assert.ok(near(middle[0], p.X(250)) && near(middle[1], p.Y(2.5)));
  assert.deepEqual(panel.names.parts.slice(0, 4).map((e) => e.textContent), ["— stable orbits", "┄ unstable", "□ fold", "◇ period doubling"]);
  assert.equal(panel.running, false);
  grids.message({ kind: "branches", id: own, kinds: [], none: "at rest" }, {});
  assert.deepEqual([panel.note.textContent, panel.note.title], ["no branches here", "at rest"]);
});

test("each event over a sweep has the sign that the legend gives its kind", () => {
  const { grids, p, id, panel } = setUp("strip"), own = id(), kinds = ["fold", "period doubling", "symmetry breaking", "torus", "slip"];
  grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0, 4), regime: Uint8Array.of(1, 1), section: Float32Array.of(0, 4) });
  grids.message({ kind: "done", id: own }, {});
  forget(p.context);
  const order = [3, 0, 4, 1, 2, 0], nothing = new Float32Array(0);
  grids.message({ kind: "branches", id: own, kinds }, { value: nothing, section: nothing, stable: new Uint8Array(0), event_value: Float32Array.from(order, (_, k) => 200 + 200 * k), event_section: Float32Array.from(order, () => 2), event_kind: Uint8Array.from(order) });
  // how far a sign reaches to the left, the right, up and down along its axes: a corner there, or none
  const corners = { "□": "", "◇": "lrud", "△": "u", "▽": "d" }, legend = panel.names.parts.slice(2, 7).map((e) => e.textContent.split(/ (.*)/));
  assert.deepEqual(legend.map(([, name]) => name), kinds);
  for (const [k, kind] of order.entries()) {
    const x = p.X(200 + 200 * k), y = p.Y(2), beside = p.context.calls.filter((c) => ["moveTo", "lineTo", "arc"].includes(c.name) && c.lineWidth === 1.4 && Math.hypot(c.args[0] - x, c.args[1] - y) < 8);
    assert.ok(beside.every((c) => c.strokeStyle === LIGHT.ink && c.fillStyle === LIGHT.panel)); // open, as in the legend
    if (legend[kind][0] === "○") { assert.ok(beside.length === 1 && beside[0].name === "arc"); continue; }
    const found = beside.map(({ args: [px, py] }) => (near(px, x) ? (py < y ? "u" : "d") : near(py, y) ? (px < x ? "l" : "r") : "")).sort().join("");
    assert.deepEqual([found, beside.length], [[...corners[legend[kind][0]]].sort().join(""), "□◇".includes(legend[kind][0]) ? 4 : 3], `${legend[kind]}`);
  }
});

test("a hand over a sweep moves its parameter, and the line stands at the setting", () => {
  const { panel, p, canvas, gone } = setUp("strip");
  canvas.onpointerdown(pointer(p, p.X(400), 50)); canvas.onpointermove(pointer(p, p.X(1000), 60)); canvas.onpointerup(pointer(p, p.X(5000), 60));
  assert.deepEqual(gone, [[{ voltage_amplitude: "400 V" }, false], [{ voltage_amplitude: "1000 V" }, false], [{ voltage_amplitude: "1600 V" }, true]]);
  canvas.onpointermove(pointer(p, p.X(100), 60));
  assert.equal(gone.length, 3);
  panel.page.go({ voltage_amplitude: "1.2 kV" }); panel.redrawOver();
  assert.ok(near(placed(p, "line")[0], p.X(1200), 0.01));
  canvas.onkeydown({ key: "ArrowLeft", preventDefault() {} });
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "1193 V" });
});

test("a value whose motions leave the domain is grey from top to bottom, and other kinds are not", () => {
  for (const [code, whole] of [[4, false], [5, true], [98, true], [6, false]]) {
    const { grids, p, id } = setUp("strip");
    grids.message({ kind: "grid", id: id(), grid: "strip", cells: [5] }, {});
    grids.message({ kind: "cells", id: id(), share: 1 }, { places: Float32Array.of(2), regime: Uint8Array.of(code), section: Float32Array.of(1, 2), low: Float32Array.of(0), high: Float32Array.of(3) });
    forget(p.context); draw();
    assert.equal(p.context.calls.some((c) => c.name === "fillRect" && near(c.args[3], p.bottom - p.top) && near(c.globalAlpha, 0.45)), whole, code);
  }
});

test("a key moves a sweep by a part of its own range, and beyond that there is no line", () => {
  const { panel, canvas, gone, state, p } = setUp("strip");
  state.over = ["voltage_amplitude", 400, 880]; panel.prepare(); p.redraw();
  panel.page.go({ voltage_amplitude: "500 V" }); panel.redrawOver();
  assert.ok(near(placed(p, "line")[0], p.X(500), 0.01));
  canvas.onkeydown({ key: "ArrowRight", preventDefault() {} });
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "502 V" });
  for (const outside of ["900 V", "399 V"]) { panel.page.go({ voltage_amplitude: outside }); panel.redrawOver(); assert.equal(placed(p, "line"), null, outside); }
});

test("what has all its cells is not begun again for the branches and bifurcations that were still followed", () => {
  for (const [kind, other] of [["strip", "map"], ["map", "strip"]]) {
    const { grids, panel, state, asked, id } = setUp(kind), again = () => asked.filter(([own]) => own === kind).length;
    grids.message({ kind: "done", id: id(), grid: kind }, {});
    assert.ok(panel.running);
    state.right = other; grids.opened();
    assert.ok(asked.some(([own, content]) => own === "cancel" && content.grid === kind));
    state.right = kind; grids.opened();
    assert.deepEqual([again(), panel.running, panel.stale], [1, false, false]);
  }
});

test("a sweep is outdated by all but its own parameter", () => {
  const { grids, panel, id, asked } = setUp("strip");
  grids.message({ kind: "cells", id: id(), share: 1 }, { places: Float32Array.of(0), regime: Uint8Array.of(1), section: Float32Array.of(1) });
  grids.changed(["voltage_amplitude"]);
  assert.equal(panel.stale, false);
  grids.changed(["frequency"]);
  assert.deepEqual([panel.stale, asked.at(-1)], [true, ["cancel", { grid: "strip" }]]);
});

test("what is computed already is not asked for again, and answers of an outdated question count no more", () => {
  const { grids, panel, id, asked } = setUp("strip"), own = id();
  grids.message({ kind: "grid", id: own, grid: "strip", cells: [5] }, {});
  grids.opened();
  assert.equal(asked.length, 1);
  grids.changed(["frequency"]);
  grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0), regime: Uint8Array.of(1), section: Float32Array.of(1) });
  assert.equal(panel.cells.size, 0);
});

// --- the envelope ----------------------------------------------------------------------------------------------------

const HEAD = { kind: "envelope", limits: ["pull-in"], static: { "pull-in": 1900 }, highest: 2500, least: 5, most: 15, share: 0, pull_in_of: "membrane", shape: { voltage_amplitude: 800 / 1800, voltage_offset: 1000 / 1800 } };

function envelope() {
  const own = setUp("envelope");
  own.grids.message({ ...HEAD, id: own.id() }, { frequency: Float32Array.of(), window: Float32Array.of(), "limit pull-in": Float32Array.of() });
  own.panel.redrawOver();
  const first = [texts(own.p.context).includes("static pull-in of the membrane"), own.panel.words.textContent];
  forget(own.p.context);
  own.grids.message({ ...HEAD, id: own.id(), static: { "pull-in": 1900, none: null }, share: 0.42 }, { frequency: Float32Array.of(5, 10, 15), window: Float32Array.of(2000, 1000, 2000), "limit pull-in": Float32Array.of(2400, 1200, NaN) });
  const half = [own.said(), own.panel.running, own.panel.verdict(7.5, 1234)];
  forget(own.p.context);
  own.grids.message({ kind: "done", id: own.id(), grid: "envelope" }, {});
  return { ...own, first, half };
}

test("an envelope grows: limits without a motion first, then a window as far as it is known", () => {
  const { first, half } = envelope();
  assert.deepEqual(first, [true, "drive: 10 Hz, peak 1800 V …"]);
  assert.deepEqual(half, ["42 %", true, "drive: 7.5 Hz, peak 1234 V; so far the window ends at 1500 V"]);
});

test("an envelope shows its window and limits at their frequencies and voltages, and says what they are", () => {
  const { said, p, panel } = envelope();
  assert.deepEqual([said(), panel.running], ["", false]);
  const line = (colour) => p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === colour).map((c) => c.args);
  [[5, 2000], [10, 1000], [15, 2000]].forEach(([f, v], k) => assert.ok(near(line(LIGHT.taut)[k][0], p.X(f)) && near(line(LIGHT.taut)[k][1], p.Y(v))));
  [[5, 2400], [10, 1200]].forEach(([f, v], k) => assert.ok(near(line(LIGHT.breakdown)[k][0], p.X(f)) && near(line(LIGHT.breakdown)[k][1], p.Y(v))));
  assert.ok(line(LIGHT.edge).every(([, y]) => near(y, p.Y(1900))) && line(LIGHT.edge).length === 2);
  const strokes = (g) => g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === LIGHT.taut).map((c) => c.globalAlpha), area = p.context.calls.filter((c) => c.fillStyle === LIGHT.taut && c.strokeStyle !== LIGHT.taut && near(c.globalAlpha, 0.25));
  [[5, 0], [5, 2000], [10, 1000], [15, 2000], [15, 0]].forEach(([f, v], k) => { const { args: [x, y] } = area.filter((c) => ["moveTo", "lineTo"].includes(c.name))[k]; assert.ok(near(x, p.X(f)) && near(y, p.Y(v))); });
  assert.ok(area.some((c) => c.name === "fill") && strokes(p.context).every((alpha) => alpha === 1));
  forget(p.context); panel.stale = true; p.redraw(); // an outdated one is pale
  assert.ok(strokes(p.context).length > 0 && strokes(p.context).every((alpha) => alpha === 0.4));
  for (const text of ["drive frequency (Hz)", "peak voltage (V)", "pull-in of the membrane", "static pull-in of the membrane", "recommended"]) assert.ok(texts(p.context).includes(text), text);
  assert.ok(near(p.toX(p.right), 15) && near(p.toY(p.top), 2500) && near(p.toY(p.bottom), 0));
});

test("a limit that is not met at a frequency leaves a gap there", () => {
  const own = setUp("envelope");
  own.grids.message({ ...HEAD, id: own.id() }, { frequency: [5, 10, 15, 20], window: [2000, 1000, 2000, 2000], "limit pull-in": [2400, Infinity, 2200, 2100] });
  const calls = own.p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.breakdown);
  assert.deepEqual(calls.map((c) => c.name), ["moveTo", "moveTo", "lineTo"]);
  assert.ok(calls.every((c) => c.args.every(Number.isFinite)));
});

test("the device's own drive is where its peak is, and is said to be inside or above", () => {
  const { panel, p } = envelope();
  panel.redrawOver();
  assert.ok(near(placed(p, "ring")[0], p.X(10), 0.01) && near(placed(p, "ring")[1], p.Y(1800), 0.01));
  assert.equal(panel.words.textContent, "drive: 10 Hz, peak 1800 V: above the window (1000 V)");
  assert.match(panel.verdict(7.5, 1499), /inside the window \(up to 1500 V, interpolated\)/);
  assert.match(panel.verdict(7.5, 1501), /above the window \(1500 V, interpolated\)/);
  assert.match(panel.verdict(5, 1999), /inside the window \(up to 2000 V\)/);
  assert.match(panel.verdict(15, 1999), /inside the window \(up to 2000 V\)/);
  assert.match(panel.verdict(4.9, 1), /below the frequencies examined/);
  assert.match(panel.verdict(16, 1), /above the frequencies examined/);
});

test("the device's own drive is in volts and hertz, whatever its units and those of its controls", () => {
  const { panel, setting, controls } = envelope();
  for (const offset of ["1 kV", "1000 V"]) {
    setting.values = { voltage_amplitude: "0.8 kV", voltage_offset: offset, frequency: "0.012 kHz" };
    assert.ok(near(panel.own()[0], 12) && near(panel.own()[1], 1800));
  }
  setting.values = {};
  for (const [frequency, hertz] of [[{ unit: "kHz", value: 0.012 }, 12], [{ unit: "mHz", value: 700 }, 0.7]]) {
    const other = { voltage_amplitude: { unit: "mV", value: 8e5 }, voltage_offset: { unit: "V", value: 1000 }, frequency };
    controls.list = LIST.map((control) => ({ ...control, ...other[control.name] }));
    assert.ok(panel.current && near(panel.own()[0], hertz) && near(panel.own()[1], 1800));
  }
});

test("the peak of the drive is that of its waveform, as the server has found it", () => {
  for (const [amplitude, offset, peak] of [[1500, -300, 1200], [0, 900, 900], [0, -900, 900], [700, 0, 350]]) { // half waves, none, and samples up to 0.5
    const { grids, panel, setting, id, gone } = setUp("envelope");
    setting.values = { voltage_amplitude: `${amplitude} V`, voltage_offset: `${offset} V` };
    panel.start();
    grids.message({ ...HEAD, id: id(), shape: { voltage_amplitude: amplitude / peak, voltage_offset: offset / peak } }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(2000, 2000), "limit pull-in": Float32Array.of(NaN, NaN) });
    assert.ok(near(panel.own()[1], peak), `${peak}`);
    panel.drive(7, peak / 2, true);
    const moved = { frequency: "7 Hz", ...(amplitude ? { voltage_amplitude: `${amplitude / 2} V` } : {}), ...(offset ? { voltage_offset: `${offset / 2} V` } : {}) };
    assert.deepEqual(gone.at(-1)[0], moved);
    assert.ok(panel.current && near(panel.own()[1], peak / 2));
  }
});

test("a drive of another proportion is not compared with an envelope, nor moved in it, until its own is known", () => {
  const { panel, p, setting, canvas, gone, grids, id } = envelope(), said = () => (panel.redrawOver(), panel.words.textContent);
  setting.values = { voltage_amplitude: "400 V", voltage_offset: "-1 kV" };
  assert.equal(said(), "drive: not compared, since the envelope is of other settings");
  assert.equal(placed(p, "ring"), null);
  canvas.onpointerdown(pointer(p, p.X(7), p.Y(900))); canvas.onpointerup(pointer(p, p.X(7), p.Y(900)));
  canvas.onkeydown({ key: "ArrowUp", preventDefault() {} });
  assert.equal(gone.length, 0);
  panel.start();
  assert.match(said(), /not compared/);
  grids.message({ ...HEAD, id: id(), shape: { voltage_amplitude: 2 / 3, voltage_offset: -5 / 3 } }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(2000, 2000), "limit pull-in": Float32Array.of(NaN, NaN) });
  assert.match(said(), /^drive: 10 Hz, peak 600 V; so far/);
});

test("a proportion that rounding changes is the same, one that changes more is not", () => {
  const { panel, setting } = envelope();
  setting.values = { voltage_amplitude: "1234.57 V", voltage_offset: "1543.21 V" };
  assert.ok(panel.current);
  setting.values = { voltage_amplitude: "800 V", voltage_offset: "1010 V" };
  assert.ok(!panel.current);
});

test("the stripes of a kind in a legend run as the lines across its cells", () => {
  for (const code of [2, 3, 4, 6, 98]) {
    const g = recorder(), angles = [...sample("#000000", code).style.background.matchAll(/gradient\((\d+)deg/g)].map(([, angle]) => (Number(angle) * Math.PI) / 180);
    hatch(g, [[code, 0, 0]], 1, 1);
    const ends = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args);
    const lines = ends.filter((_, k) => k % 2 === 0).map(([x, y], k) => [ends[2 * k + 1][0] - x, ends[2 * k + 1][1] - y]);
    assert.equal(angles.length, lines.length);
    for (const [dx, dy] of lines) assert.ok(angles.some((a) => Math.abs(dx * Math.sin(a) - dy * Math.cos(a)) < 1e-9), `kind ${code}`); // a stripe stands across its gradient
  }
});

test("a hand over the envelope moves the drive: frequency, and both voltages in their proportion", () => {
  const { canvas, p, gone, grids, asked } = envelope();
  canvas.onpointerdown(pointer(p, p.X(7), p.Y(900))); canvas.onpointerup(pointer(p, p.X(7), p.Y(900)));
  assert.deepEqual(gone.at(-1), [{ frequency: "7 Hz", voltage_amplitude: "400 V", voltage_offset: "500 V" }, true]);
  const before = asked.length;
  grids.changed(["frequency", "voltage_amplitude", "voltage_offset"]);
  assert.equal(asked.length, before); // the envelope of this proportion is known
  grids.changed(["film_thickness"]);
  assert.equal(asked.length, before);
});

test("an envelope of another proportion, or another body, is computed again", () => {
  const { grids, panel, setting, controls, asked } = envelope();
  setting.values = { voltage_amplitude: "1.6 kV" }; controls.values(setting.values);
  grids.changed(["voltage_amplitude"]);
  wait(500);
  assert.equal(asked.at(-1)[0], "envelope");
  setting.values = { voltage_amplitude: "1.6 kV", film_thickness: "0.3 mm" }; controls.values(setting.values);
  grids.changed(["film_thickness"]);
  wait(500);
  assert.deepEqual(asked.slice(-2).map(([kind]) => kind), ["cancel", "envelope"]);
  assert.equal(panel.si("voltage_amplitude", "V"), 1600);
});

test("an arrow key moves the setting along its axis, the opposite one back, and others leave the page's keys alone", () => {
  for (const [kind, { canvas, gone, controls, setting }] of [["map", setUp("map")], ["strip", setUp("strip")], ["envelope", envelope()]]) {
    const now = (name) => controls.value(name, setting.values), names = ["voltage_amplitude", "frequency"];
    const key = (name) => { let held = false; canvas.onkeydown({ key: name, preventDefault() { held = true; } }); return held; };
    const across = kind === "envelope" ? "frequency" : "voltage_amplitude", up = names.find((name) => name !== across);
    for (const [more, less, name, other] of [["ArrowRight", "ArrowLeft", across, up], ...(kind === "strip" ? [] : [["ArrowUp", "ArrowDown", up, across]])]) {
      const before = [now(name), now(other)];
      assert.ok(key(more) && now(name) > before[0] && near(now(other), before[1], 1e-3), `${kind} ${more}`);
      assert.ok(key(less) && near(now(name), before[0], 1e-3), `${kind} ${less}`);
      const step = now(name) - (key(less), now(name));
      assert.ok(step > 0.0 && key(more) && near(now(name), before[0], 1e-3), `${kind} ${less}`);
    }
    const count = gone.length;
    assert.ok(!key("Tab") && gone.length === count, kind);
  }
});

test("beyond the ends of a scale a cell has the colour of its end, and one without a number none", () => {
  for (const [kind, low, high] of [["exponent", "rgb(0,114,178)", "rgb(213,94,0)"], ["stroke", "rgb(11,42,82)", "rgb(246,230,75)"]]) {
    const { grids, panel, id } = setUp(), own = cells(() => 1);
    own.exponent.set([-90, 80, NaN], 0); own.low.set([1, 1, NaN], 0); own.high.set([1, 99, NaN], 0);
    grids.message({ kind: "cells", id: id(), share: 1 }, own);
    panel.view.value = kind; panel.view.onchange();
    const shade = panel.shader(panel.nearest());
    assert.deepEqual([shade(0), shade(1), shade(2)], [low, high, LIGHT.line], kind);
    for (let k = 3; k < 65 * 49; k++) assert.ok(shade(k).match(/\d+/g).every((v) => v >= 0 && v <= 255), `${kind} ${k}`);
  }
});

test("the axes of a map are two numbers of the device, whatever its address says", () => {
  const names = LIST.filter((c) => c.kind === "number").map((c) => c.name);
  for (const [x, y] of [["frequency", "frequency"], ["voltage_amplitude", "voltage_amplitude"], ["none", "film_thickness"], ["waveform", "waveform"], ["film_thickness", "none"]]) {
    const { grids, panel, state, asked } = setUp();
    state.x = [x, 1, 2]; state.y = [y, 3, 4];
    grids.controlsChanged();
    assert.ok(names.includes(state.x[0]) && names.includes(state.y[0]) && state.x[0] !== state.y[0], `${x} ${y}`);
    assert.deepEqual([panel.x.value, panel.y.value, asked.at(-1)[1].x, asked.at(-1)[1].y], [state.x[0], state.y[0], state.x, state.y]);
    if (names.includes(x)) assert.deepEqual(state.x, [x, 1, 2]);
  }
});

test("a hand or a key beyond the ends of a picture moves the setting to its end", () => {
  const ends = { map: [{ voltage_amplitude: 1600, frequency: 20 }, { voltage_amplitude: 0, frequency: 0.1 }], strip: [{ voltage_amplitude: 1600 }, { voltage_amplitude: 0 }], envelope: [{ frequency: 15, peak: 2500 }, { frequency: 15 / 500, peak: 2500 / 500 }] };
  for (const [kind, { canvas, p, panel, gone, controls, setting }] of [["map", setUp("map")], ["strip", setUp("strip")], ["envelope", envelope()]]) {
    const now = (name) => (name === "peak" ? panel.own()[1] : controls.value(name, setting.values));
    const there = (x, y) => { canvas.onpointerdown(pointer(p, x, y)); canvas.onpointerup(pointer(p, x, y)); };
    for (const [k, [x, y, keys]] of [[p.right + 300, p.top - 300, ["ArrowRight", "ArrowUp"]], [p.left - 300, p.bottom + 300, ["ArrowLeft", "ArrowDown"]]].entries()) {
      const right = () => { for (const [name, value] of Object.entries(ends[kind][k])) assert.ok(near(now(name), value, 2e-3), `${kind} ${name} ${now(name)}`); };
      there(x, y);
      right();
      for (const key of keys) canvas.onkeydown({ key, preventDefault() {} });
      if (kind !== "map") right();
    }
    assert.ok(gone.length > 0);
  }
});

test("names in an envelope stand apart and inside of it, with limits beyond its voltages neither drawn nor named", () => {
  const own = setUp("envelope"), limits = ["pull-in", "hoop slack", "onset of rest"], { p } = own;
  const found = Object.fromEntries(limits.map((name, k) => [`limit ${name}`, Float32Array.of(2400 - 300 * k, 1200)]));
  own.grids.message({ ...HEAD, id: own.id(), limits, static: { "pull-in": 1900, pitchfork: 2600, "hoop slack": 2499, none: null }, pull_in_of: "cone" }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(2000, 1000), ...found });
  forget(p.context);
  own.grids.message({ kind: "done", id: own.id(), grid: "envelope" }, {});
  const names = p.context.calls.filter((c) => c.name === "fillText" && /pull-in|slack|onset|pitchfork/.test(c.args[0])).map((c) => c.args);
  assert.deepEqual(names.map(([text]) => text), ["pull-in of the cone", "hoop slack", "onset of rest", "static pull-in of the cone", "static hoop slack"]);
  for (const [text, x, y] of names) assert.ok(x >= p.left && x <= p.right && y >= p.top + 6 && y <= p.bottom, text);
  names.forEach(([text, x, y], k) => { for (const [other, u, v] of names.slice(0, k)) assert.ok(Math.abs(y - v) > 10 || x !== u, `${text}, ${other}`); });
  assert.equal(p.context.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === LIGHT.edge && c.dash.length).length, 2);
});

test("static limits of films in opposite phase are named as those of the drive held at its peak", () => {
  const own = setUp("envelope"), { p } = own;
  own.grids.message({ ...HEAD, id: own.id(), limits: [], in_proportion: true }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(2000, 1000) });
  for (const text of ["drive held at its peak: pull-in of the membrane", "peak voltage, bias in proportion (V)"]) assert.ok(texts(p.context).includes(text), text);
});

test("a parameter is on one axis of a map: where both are the same, the second takes another", () => {
  const { panel, state, asked } = setUp();
  panel.x.value = "frequency"; panel.x.onchange();
  assert.deepEqual([state.x, state.y], [["frequency", 0.1, 20], ["voltage_amplitude", 0, 1600]]);
  panel.y.value = "film_thickness"; panel.y.onchange();
  assert.deepEqual([state.x, state.y], [["frequency", 0.1, 20], ["film_thickness", 0.01, 0.4]]);
  state.x = ["frequency", 5, 9]; panel.prepare(); // what is zoomed stays so while the other axis changes
  panel.y.value = "voltage_offset"; panel.y.onchange();
  assert.deepEqual([state.x, state.y], [["frequency", 5, 9], ["voltage_offset", 0, 2]]);
  assert.deepEqual([asked.at(-1)[0], asked.at(-1)[1].x, asked.at(-1)[1].y], ["map", state.x, state.y]);
});
