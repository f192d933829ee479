// The map: cells in their places, its axes, legend and lines.
import assert from "node:assert/strict";
import test from "node:test";
import { LIST, cells, placed, pointer, setUp } from "./grid_panels.js";
import { LIGHT, boxes, browser, draw, drawn, forget, near, overlapping, texts, wait } from "./page.js";

browser();
const { setTheme } = await import("../../../src/gelcone/studio/static/colours.js");

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
  const put = panel.canvas.getContext("2d").calls.findLast((c) => c.name === "putImageData").args;
  image = put[0].data;
  assert.deepEqual(put.slice(1), [0, 0]);
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
  for (const [x, y] of [[[400, 1200], [5, 15]], [[90, 1000], [0.9, 10]], [[80, 90], [9, 10]]]) for (const [a, b] of [[0, 1], [1, 0]]) for (const [c, d] of [[0, 1], [1, 0]]) {
    const own = setUp(), at = (k, l) => pointer(own.p, own.p.X(x[k]), own.p.Y(y[l]));
    own.canvas.onpointerdown(at(a, c)); own.canvas.onpointermove(at(b, d)); own.canvas.onpointerup(at(b, d));
    assert.deepEqual([own.state.x, own.state.y], [["voltage_amplitude", ...x], ["frequency", ...y]]);
  }
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
  const { canvas, gone, state, asked, page } = setUp(), steps = [], key = (name) => canvas.onkeydown({ key: name, preventDefault() {} });
  page.keep = (step) => steps.push(step);
  key("ArrowRight");
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "825 V", frequency: "10 Hz" });
  key("ArrowDown");
  assert.equal(gone.at(-1)[0].frequency, `${Number((10 - 19.9 / 48).toPrecision(4))} Hz`);
  key("ArrowLeft"); key("ArrowUp");
  assert.equal(gone.at(-1)[0].voltage_amplitude, "800 V");
  key("+");
  assert.deepEqual(state.x, ["voltage_amplitude", 400, 1200]);
  assert.deepEqual([asked.at(-1)[0], asked.at(-1)[1].x, steps], ["map", state.x, [true]]); // as a drag does
  key("-"); key("-");
  assert.deepEqual(state.x, ["voltage_amplitude", 0, 3200]);
  Object.assign(state, { x: ["voltage_amplitude", 700, 900], y: ["frequency", 9, 11] }); // about 800 V and 10 Hz
  key("-");
  assert.deepEqual([state.x, state.y], [["voltage_amplitude", 600, 1000], ["frequency", 8, 12]]);
});

test("another parameter along an axis is asked for, never the same on both", () => {
  const { panel, state, asked } = setUp();
  panel.x.value = "film_thickness"; panel.x.onchange();
  assert.deepEqual([state.x, asked.at(-1)[1].x], [["film_thickness", 0.01, 0.4], ["film_thickness", 0.01, 0.4]]);
  panel.y.value = "film_thickness"; panel.y.onchange();
  assert.notEqual(state.x[0], state.y[0]);
});

test("a change of something else makes a map outdated, computed again once the hand rests; one of its axes does not", () => {
  const { grids, panel, asked, said, p, id, setting } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  setting.values.frequency = "3 Hz"; grids.changed(); setting.values.voltage_amplitude = "9 V"; grids.changed();
  assert.equal(asked.length, 1);
  forget(p.context);
  setting.values.film_thickness = "0.3 mm"; grids.changed();
  assert.deepEqual([asked.at(-1), said(), panel.running], [["cancel", { grid: "map" }], "settings changed", false]);
  assert.equal(p.context.calls.find((c) => c.name === "drawImage").globalAlpha, 0.45);
  wait(400);
  assert.equal(asked.length, 2);
  wait(500);
  assert.equal(asked.at(-1)[0], "map");
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

test("a zoom ends where the hand was, by a drag or by keys, to a ten-thousandth of its range", () => {
  for (const [x, y] of [[[123.456, 1234.56], [3.14159, 17.7777]], [[1000.11, 1000.99], [9.99911, 10.0012]]]) {
    const { canvas, p, state } = setUp(), to = pointer(p, p.X(x[1]), p.Y(y[1]) - 7), hand = [x, [y[0], p.toY(p.Y(y[1]) - 7)]]; // 7 pixels are a drag
    canvas.onpointerdown(pointer(p, p.X(x[0]), p.Y(y[0])));
    canvas.onpointermove(to); canvas.onpointerup(to);
    for (const [k, axis] of [state.x, state.y].entries()) axis.slice(1).forEach((v, end) => assert.ok(near(v, hand[k][end], 1e-4), `${axis}`));
  }
  const { canvas, panel, state } = setUp();
  panel.page.go({ voltage_amplitude: "777.7 V", frequency: "7.777 Hz" });
  canvas.onkeydown({ key: "+", preventDefault() {} });
  for (const [axis, [low, high]] of [[state.x, [377.7, 1177.7]], [state.y, [7.777 - 4.975, 7.777 + 4.975]]]) assert.ok(near(axis[1], low, 1e-4) && near(axis[2], high, 1e-4), `${axis}`);
});

test("the ground of a name over a map is measured in the letters in which the name is written", () => {
  const { grids, p, id } = setUp(), widths = new Map();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  grids.message({ kind: "thresholds", id: id(), names: ["onset", "pull-in"], upright: false }, { at: Float32Array.of(400, 800, 1200), onset: Float32Array.of(5, 5, 5), "pull-in": Float32Array.of(15, 15, 15) });
  forget(p.context); p.redraw();
  for (const c of p.context.calls) if (c.name === "measureText") widths.set(c.args[0], c.font);
  const written = p.context.calls.filter((c) => c.name === "fillText" && widths.has(c.args[0]));
  assert.equal(written.length, 2);
  const grounds = p.context.calls.filter((c) => c.name === "roundRect").map((c) => c.args);
  for (const [k, c] of written.entries()) {
    const [, left, top, right, bottom] = boxes(p.context).find(([text]) => text === c.args[0]), [x, y, w, h] = grounds[k];
    assert.equal(c.font, widths.get(c.args[0]), c.args[0]);
    assert.ok(near(left - x, 5) && near(x + w - right, 5) && top - y > 1 && near(top - y, y + h - bottom), c.args[0]); // the same room on both sides
  }
});

test("what is over other ranges or parameters shows nothing of the cells before", () => {
  const { grids, panel, id, p } = setUp(), drag = () => { panel.down(pointer(p, 200, 100)); panel.move(pointer(p, 400, 300)); panel.up(pointer(p, 400, 300)); };
  for (const act of [drag, () => panel.out.onclick(), () => panel.pressed({ key: "+", preventDefault() {} }), () => { panel.x.value = "film_thickness"; panel.x.onchange(); }]) {
    grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1)); draw();
    assert.equal(panel.names.parts.length, 1);
    forget(p.context); act();
    assert.deepEqual([p.context.calls.findLastIndex((c) => c.name === "drawImage") < p.context.calls.findLastIndex((c) => c.name === "fillRect"), texts(p.context).includes("computing …"), panel.names.parts.length], [true, true, 0]);
  }
});

test("the full range is asked for anew", () => {
  const { panel, page, state, asked } = setUp(), steps = [];
  page.keep = (step) => steps.push(step);
  Object.assign(state, { x: ["film_thickness", 0.1, 0.2], y: ["voltage_offset", 1, 1.5] });
  panel.out.click();
  assert.deepEqual([asked.at(-1)[0], asked.at(-1)[1].x, asked.at(-1)[1].y, steps], ["map", ["film_thickness", 0.01, 0.4], ["voltage_offset", 0, 2], [true]]);
});

test("an exponent of zero has nearly the colour of the ground, in both themes", () => {
  for (const [theme, bright] of [["light", true], ["dark", false]]) {
    const { grids, panel, id } = setUp(), own = cells(() => 1);
    setTheme(theme);
    own.exponent[0] = 0;
    grids.message({ kind: "cells", id: id(), share: 1 }, own);
    panel.view.value = "exponent"; panel.view.onchange();
    assert.ok(panel.shader(panel.nearest())(0).match(/\d+/g).every((v) => (bright ? v > 200 : v < 60)), theme);
  }
  setTheme("light");
});

test("over the cells of a map are their stripes, then lines with their ground, then names with theirs", () => {
  const { grids, panel, id, p } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells((i) => (i > 40 ? 3 : 1)));
  grids.message({ kind: "thresholds", id: id(), upright: true, names: ["pull-in"] }, { at: Float32Array.of(5, 10, 15), "pull-in": Float32Array.of(800, 800, 800) });
  for (const [stale, share] of [[false, ""], [true, " at 0.45"]]) {
    panel.stale = stale; forget(p.context); p.redraw();
    assert.deepEqual(drawn(p.context), ["box panel", "line line 1", "voltage_amplitude (V) | soft 11px center bottom", "frequency (Hz) | soft 11px center middle", `picture${share}`, `line rgba(255, 255, 255, 0.45) 1${share}`, "line panel 4", "line ink 1.6 dashed 6,4", "area panel at 0.85", "pull-in | ink 600 11px left middle"]);
  }
});

test("the name of a line at an edge of a map stands inside of it, each at the first free place along its line", () => {
  const { grids, id, p } = setUp();
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  const at = Float32Array.of(...Array.from({ length: 20 }, (_, k) => 0.2 + k)), line = (volts) => at.map(() => volts);
  for (const [volts, side] of [[1, "left"], [1599, "right"]]) {
    grids.message({ kind: "thresholds", id: id(), upright: true, names: ["some long name"] }, { at, "some long name": line(volts) });
    forget(p.context); p.redraw();
    const [, left, top, right, bottom] = boxes(p.context).find(([text]) => text === "some long name");
    assert.ok(near(side === "left" ? left - p.left : p.right - right, 6, 1e-6) && near((top + bottom) / 2, p.Y(at[12]) - 12, 1e-2), side); // six tenths up the line
  }
  grids.message({ kind: "thresholds", id: id(), upright: false, names: ["high"] }, { at: Float32Array.of(400, 800, 1200), high: Float32Array.of(19.95, 19.95, 19.95) });
  forget(p.context); p.redraw();
  assert.ok(boxes(p.context).find(([text]) => text === "high")[2] >= p.top);
});

test("the cells of a map are painted once for each view, theme and answer, however often it is drawn", () => {
  const { grids, panel, id, p } = setUp(), painted = () => panel.canvas.getContext("2d").calls.filter((c) => c.name === "putImageData").length;
  grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 1));
  const again = (change = () => {}) => { const before = painted(); change(); p.redraw(); p.redraw(); return painted() - before; };
  assert.deepEqual([again(), again(), again(() => { panel.view.value = "stroke"; }), again(), again(() => setTheme("dark")), again(() => setTheme("light")), again(() => grids.message({ kind: "cells", id: id(), share: 1 }, cells(() => 0)))], [1, 0, 1, 0, 1, 1, 1]);
});

test("a few cells far beyond the others do not stretch the scale of a map, many do", () => {
  for (const [kind, few, many] of [["exponent", "chaotic, to +0.5", "chaotic, to +90"], ["stroke", "2 mm or more", "99 mm or more"]]) for (const [count, text] of [[20, few], [160, many]]) {
    const { grids, panel, id } = setUp(), own = cells(() => 1);
    own.exponent.fill(0.5); own.exponent.fill(-0.5, 1600); own.exponent.fill(90, 0, count); own.low.fill(0); own.high.fill(2); own.high.fill(99, 0, count);
    grids.message({ kind: "cells", id: id(), share: 1 }, own);
    panel.view.value = kind; panel.view.onchange();
    assert.ok(panel.names.textContent.endsWith(text), `${kind} ${count}: ${panel.names.textContent}`);
  }
});

test("the box of a drag follows the hand, also back to where it began", () => {
  const { canvas, p } = setUp(), box = () => { const own = p.marks.get("box"); return [placed(p, "box"), parseFloat(own.style.width), parseFloat(own.style.height)]; };
  canvas.onpointerdown(pointer(p, 200, 200));
  for (const [x, y] of [[300, 260], [150, 120], [203, 202]]) {
    canvas.onpointermove(pointer(p, x, y));
    assert.deepEqual(box(), [[Math.min(x, 200), Math.min(y, 200)], Math.abs(x - 200), Math.abs(y - 200)]);
  }
});
