// The sweep: sections, ranges and branches at their values.
import assert from "node:assert/strict";
import test from "node:test";
import { placed, pointer, setUp } from "./grid_panels.js";
import { LIGHT, browser, draw, drawn, forget, made, near, texts } from "./page.js";

browser();

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
  assert.deepEqual([panel.note.textContent, panel.note.title, panel.names.parts.map((e) => e.textContent)], ["no branches here", "at rest", ["periodic"]]);
  grids.message({ kind: "branches", id: own, kinds: [] }, { value: new Float32Array(0), section: new Float32Array(0), stable: new Uint8Array(0), event_value: new Float32Array(0), event_section: new Float32Array(0), event_kind: new Uint8Array(0) });
  assert.deepEqual([panel.note.textContent, panel.note.title], ["each value from the same start", ""]);
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

test("a sweep is outdated by all but its own parameter", () => {
  const { grids, panel, id, asked, setting } = setUp("strip");
  grids.message({ kind: "cells", id: id(), share: 1 }, { places: Float32Array.of(0), regime: Uint8Array.of(1), section: Float32Array.of(1) });
  setting.values.voltage_amplitude = "9 V"; grids.changed();
  assert.equal(panel.stale, false);
  setting.values.frequency = "3 Hz"; grids.changed();
  assert.deepEqual([panel.stale, asked.at(-1)], [true, ["cancel", { grid: "strip" }]]);
});

test("what is computed already is not asked for again, and answers of an outdated question count no more", () => {
  const { grids, panel, id, asked, setting } = setUp("strip"), own = id();
  grids.message({ kind: "grid", id: own, grid: "strip", cells: [5] }, {});
  grids.opened();
  assert.equal(asked.length, 1);
  setting.values.frequency = "3 Hz"; grids.changed();
  grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0), regime: Uint8Array.of(1), section: Float32Array.of(1) });
  assert.equal(panel.cells.size, 0);
});

test("a sweep is drawn from its ranges behind to its events in front, paler where it is outdated", () => {
  const { grids, panel, id, p } = setUp("strip"), own = id();
  grids.message({ kind: "grid", id: own, cells: [5] }, {});
  grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0, 2, 4), regime: Uint8Array.of(1, 3, 98), section: Float32Array.of(0, 1, 4), low: Float32Array.of(0, 0, NaN), high: Float32Array.of(2, 2, NaN) });
  grids.message({ kind: "done", id: own }, {});
  grids.message({ kind: "branches", id: own, kinds: ["fold", "slip"] }, { value: Float32Array.of(100, 200, 300, NaN), section: Float32Array.of(1, 2, 3, NaN), stable: Uint8Array.of(1, 1, 0, 0), event_value: Float32Array.of(250), event_section: Float32Array.of(2.5), event_kind: Uint8Array.of(1) });
  for (const [stale, [range, grey, points, chaos, dashed, whole]] of [[false, [" at 0.16", " at 0.45", "", " at 0.75", " at 0.7", " at 0.95"]], [true, [" at 0.08", " at 0.225", " at 0.35", " at 0.262", " at 0.3", " at 0.3"]]]) {
    panel.stale = stale; forget(p.context); p.redraw();
    assert.deepEqual(drawn(p.context).slice(4), [`box a${range}`, `box #d55e00${range}`, `box #5b5b5b${grey}`, `box a${points}`, `box #d55e00${chaos}`, `box #5b5b5b${points}`, `line ink 1 dashed 4,3${dashed}`, `line ink 1.5${whole}`, "area panel", "line ink 1.4"]);
  }
  assert.equal(made(panel.names), 'ul.legend [li ["— stable orbits"], li ["┄ unstable"], li ["□ fold"], li ["◇ slip"], li [i, "periodic"], li [i, "chaotic"], li [i, "pulled in"]]');
  assert.deepEqual(panel.names.parts.slice(4).map((item) => item.parts[0].style.background), ["#0072b2", "#d55e00", "#5b5b5b"]);
});

test("a key moves a parameter that is not set from the lowest value of the sweep", () => {
  const { canvas, gone, state, controls } = setUp("strip");
  controls.list = controls.list.map((c) => (c.name === "voltage_amplitude" ? { ...c, value: null } : c));
  state.over = ["voltage_amplitude", 240, 480];
  canvas.onkeydown({ key: "ArrowRight", preventDefault() {} });
  assert.deepEqual(gone.at(-1)[0], { voltage_amplitude: "241 V" });
});

test("a sweep over another parameter or range shows nothing of the one before", () => {
  for (const over of [["frequency", 1, 2], ["voltage_amplitude", 0, 800]]) {
    const { grids, panel, id, state, p } = setUp("strip"), own = id();
    grids.message({ kind: "grid", id: own, cells: [5] }, {});
    grids.message({ kind: "cells", id: own, share: 1 }, { places: Float32Array.of(0, 4), regime: Uint8Array.of(1, 1), section: Float32Array.of(0, 4) });
    grids.controlsChanged(); p.redraw();
    assert.equal(panel.cells.size, 2); // the same one stays
    state.over = over; forget(p.context);
    grids.controlsChanged();
    assert.deepEqual([panel.cells.size, panel.branches, texts(p.context).includes("computing …")], [0, null, true]);
  }
});
