// What map, sweep and envelope have in common: what is asked and when, keys, hands and marks.
import assert from "node:assert/strict";
import test from "node:test";
import { LIST, envelope, placed, pointer, setUp } from "./grid_panels.js";
import { browser, forget, made, near, texts, wait } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { GridPanels } = await from("grids");
const $ = (id) => document.getElementById(id);

test("pictures over parameters are named by what they are over, in the order along and up", () => {
  for (const [right, name] of [["map", "Map over voltage_amplitude and frequency. "], ["strip", "Sweep of voltage_amplitude: "]]) assert.ok(setUp(right).canvas.getAttribute("aria-label").startsWith(name), right);
  const { panel, state, canvas } = setUp();
  panel.x.value = "film_thickness"; panel.x.onchange();
  assert.ok(canvas.getAttribute("aria-label").startsWith(`Map over film_thickness and ${state.y[0]}. `));
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

test("what is begun anew and left before it is whole is begun again, however whole it was before", () => {
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, id, state, setting, asked } = setUp(kind), count = () => asked.filter(([own]) => own === kind).length;
    grids.message({ kind: "done", id: id() }, {}); grids.message({ kind: kind === "map" ? "followed" : "branches", id: id() }, {});
    setting.values = { film_thickness: "0.3 mm" }; grids.changed(); wait(500);
    for (const open of [kind === "map" ? "strip" : "map", kind]) { state.right = open; grids.opened(); }
    assert.equal(count(), 3, kind);
  }
});

test("what is of another setting and left by a step back is computed anew, also where only its branches were missing", () => {
  for (const [kind, other] of [["strip", "map"], ["map", "strip"]]) {
    const { grids, id, state, setting, asked } = setUp(kind), count = () => asked.filter(([own]) => own === kind).length;
    grids.message({ kind: "done", id: id() }, {});
    setting.values = { film_thickness: "0.3 mm" }; state.right = other; grids.controlsChanged();
    state.right = kind; grids.opened();
    assert.equal(count(), 2, kind);
  }
});

test("what went wrong is said no more once it is asked for again, by another setting or by another look", () => {
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, panel, id, p, state, setting } = setUp(kind), read = () => texts(p.context).join(" "), fail = () => { forget(p.context); grids.failed({ id: id(), message: "no such range" }); };
    fail();
    assert.match(read(), /no such range$/);
    setting.values = { film_thickness: "0.3 mm" }; grids.changed(); wait(500);
    assert.match(read(), /computing[^.]* …$/, kind);
    fail(); panel.stale = true;
    state.right = kind === "map" ? "strip" : "map"; grids.opened();
    state.right = kind; grids.opened();
    assert.match(read(), /computing[^.]* …$/, kind);
  }
});

test("how far a panel is, is said while it is open alone", () => {
  for (const [kind, other] of [["map", "strip"], ["strip", "envelope"], ["envelope", "map"]]) {
    const { grids, id, state, said } = setUp(kind);
    grids.message({ kind: "done", id: id() }, {}); grids.message({ kind: kind === "map" ? "followed" : "branches", id: id() }, {});
    state.right = other; grids.opened();
    assert.equal(said(), "0 %");
    state.right = kind; grids.opened();
    assert.equal(said(), "", kind);
  }
});

test("an open panel is computed anew where another setting is taken", () => {
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, setting, asked } = setUp(kind), count = () => asked.filter(([own]) => own === kind).length;
    setting.values = { film_thickness: "0.3 mm" }; grids.controlsChanged();
    assert.equal(count(), 2, kind);
  }
});

test("how far an open panel is stays said where the other of two equal settings is taken", () => {
  for (const kind of ["map", "strip", "envelope"]) {
    const { grids, panel, said } = setUp(kind);
    panel.progress(0.42); grids.controlsChanged();
    assert.equal(said(), "42 %", kind);
  }
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

test("a hand or a key beyond the ends of a picture moves the setting to its end", () => {
  const ends = { map: [{ voltage_amplitude: 1600, frequency: 20 }, { voltage_amplitude: 0, frequency: 0.1 }], strip: [{ voltage_amplitude: 1600 }, { voltage_amplitude: 0 }], envelope: [{ frequency: 15, peak: 1.15 * 2500 }, { frequency: 15 / 500, peak: (1.15 * 2500) / 500 }] };
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

test("answers of long work that nobody waits for any more are taken and dropped, others are left to others", () => {
  browser();
  const state = { right: "map" }, page = { ask: () => 7, state: () => state, setting: () => ({ values: {} }), legend: () => null, controls: () => ({ list: [], value: () => null }), look: () => null, keep() {}, go() {} };
  const grids = new GridPanels({ hosts: { map: $("map"), strip: $("strip"), envelope: $("envelope") }, share: $("grid-share"), page });
  for (const kind of ["grid", "cells", "done", "thresholds", "loci", "followed", "branches", "progress", "envelope"]) assert.equal(grids.message({ kind, id: 99 }, {}), true, kind);
  for (const kind of ["look", "response", "file", "code", "glance"]) assert.equal(grids.message({ kind, id: 99 }, {}), false, kind);
  assert.equal(grids.failed({ id: 99, message: "no" }), false);
  for (const right of ["map", "strip", "envelope"]) { state.right = right; assert.equal(grids.open, grids.panels[right]); }
  for (const panel of Object.values(grids.panels)) { panel.running = true; panel.stale = false; }
  grids.lost();
  assert.deepEqual(Object.values(grids.panels).map((p) => [p.running, p.stale]), [[false, true], [false, true], [false, true]]);
});

test("parameters are read by their labels, never by their names", () => {
  for (const right of ["map", "strip", "envelope"]) {
    const { grids, controls, canvas, p } = setUp(right), labels = new Map(controls.list.map(({ name }) => [name, `The ${name.replace("_", " ")}`]));
    controls.list = controls.list.map((c) => ({ ...c, label: labels.get(c.name) }));
    for (const select of document.querySelectorAll("select")) delete select.dataset.key; // the choices are built anew
    forget(p.context); grids.controlsChanged(); p.redraw();
    const read = [canvas.getAttribute("aria-label"), ...texts(p.context), ...document.querySelectorAll(`#${right} option`).map((o) => o.textContent)];
    for (const text of read) assert.ok(!/voltage_|film_/.test(text), text);
    const over = { map: ["voltage_amplitude", "frequency"], strip: ["voltage_amplitude"], envelope: [] }[right];
    for (const name of over) assert.ok(read[0].includes(labels.get(name)) && read.slice(1).some((text) => text.startsWith(labels.get(name).toLowerCase())), name);
  }
});

test("a panel that is outdated and then left is not computed until it is opened again", () => {
  for (const right of ["map", "strip", "envelope"]) {
    const { grids, state, setting, asked } = setUp(right), count = () => asked.filter(([kind]) => kind === right).length;
    setting.values = { film_thickness: "0.3 mm" }; grids.changed();
    state.right = right === "map" ? "strip" : "map"; grids.opened();
    wait(500);
    assert.equal(count(), 1, right);
    state.right = right; grids.opened();
    assert.equal(count(), 2, right);
  }
});

test("only the first button of a mouse and the first finger move a setting or a range", () => {
  for (const right of ["map", "strip", "envelope"]) for (const other of [{ button: 2 }, { button: 1 }, { isPrimary: false }]) {
    const { canvas, p, gone, state } = right === "envelope" ? envelope() : setUp(right), before = JSON.stringify([state.x, state.y]);
    canvas.onpointerdown({ ...pointer(p, 200, 200), ...other });
    for (const type of ["move", "up"]) canvas[`onpointer${type}`]({ ...pointer(p, 300, 300), ...other });
    assert.deepEqual([gone.length, JSON.stringify([state.x, state.y])], [0, before], `${right} ${JSON.stringify(other)}`);
  }
});

test("each panel over parameters has its choices, its picture with a name, and what is read of it, in this order", () => {
  const options = (names, chosen) => `=${chosen} [${names.map(([value, text]) => `option "${text}" =${value}`).join(", ")}]`, numbers = ["voltage_amplitude", "voltage_offset", "frequency", "film_thickness"].map((name) => [name, name]);
  const picked = (label, chosen) => `select ‹${label}› (${label}) ${options(numbers, chosen)}`, plot = (name, marks) => `div.plot [canvas ‹${name}› role=application, -output.reading, ${marks}]`, views = [["kind", "kind of motion"], ["exponent", "largest exponent"], ["stroke", "stroke"]];
  const rows = {
    map: `div.bar [${picked("Parameter along the map", "voltage_amplitude")}, span "×", ${picked("Parameter up the map", "frequency")}, select ‹What the map shows› ${options(views, "kind")}, button "Full range" (Show the full range of both parameters) disabled], ${plot("Map over voltage_amplitude and frequency. Arrow keys move the point, plus and minus zoom.", "-i.box.mark, i.mark.ring")}, ul.legend`,
    strip: `div.bar [${picked("Parameter of the sweep", "voltage_amplitude")}, span.right "each value from the same start"], ${plot("Sweep of voltage_amplitude: the section at each value. Left and right move.", "i.line.mark")}, ul.legend`,
    envelope: `div.bar [span "drive: 10 Hz, peak 1800 V: above the window (1000 V)"], ${plot("Operating envelope: drive frequency and peak voltage. Arrow keys move the device's drive.", "i.mark.ring")}`,
  };
  for (const [kind, text] of Object.entries(rows)) {
    if (kind === "envelope") envelope(); else setUp(kind);
    assert.equal(made($(kind)), `div.grid.view role=tabpanel [${text}]`);
  }
});

test("without the parameters that it is over nothing is computed", () => {
  for (const kind of ["map", "strip"]) {
    const { panel, state, asked } = setUp(kind);
    Object.assign(state, { x: null, y: null, over: null });
    panel.start();
    assert.equal(asked.length, 1, kind);
  }
});

test("each panel is of the setting that is active: of another device, side or step of the history it is computed anew, once", () => {
  for (const right of ["map", "strip", "envelope"]) {
    const { grids, panel, setting, asked } = setUp(right), count = () => asked.filter(([kind]) => kind === right).length, changes = [{ device: "cone" }, { preset: "base", device: null }, { file: "a" }, { values: { film_thickness: "0.3 mm" } }, { values: {} }];
    for (const [k, change] of changes.entries()) for (let again = 0; again < 2; again++) {
      Object.assign(setting, change);
      grids.controlsChanged(); // as they come with another setting
      assert.deepEqual([count(), asked.at(-1)[1].setting === setting, panel.stale], [k + 2, true, false], `${right} ${JSON.stringify(change)}`);
    }
    for (const values of [{ film_thickness: "0.3 mm", waveform: "triangle" }, { waveform: "triangle", film_thickness: "0.3 mm" }, {}]) { setting.values = values; grids.controlsChanged(); } // in whatever order
    assert.equal(count(), changes.length + (right === "envelope" ? 4 : 3), right);
    setting.values = { frequency: "3 Hz", voltage_amplitude: "100 V", voltage_offset: "0.125 kV" }; // along the panels
    if (right === "strip") delete setting.values.frequency;
    if (right === "envelope") { grids.controlsChanged(); assert.equal(count(), changes.length + 4, right); }
  }
});

test("panels are over the drive at first, wherever it stands among the parameters, and without one over the first ones", () => {
  for (const [order, x, y] of [[[4, 3, 1, 0, 2], "frequency", "film_thickness"], [[4, 0, 1, 2, 3], "voltage_amplitude", "frequency"], [[0, 4], "film_thickness", undefined]]) {
    const { grids, state, controls } = setUp();
    controls.list = order.map((k) => LIST[k]); Object.assign(state, { x: null, y: null, over: null });
    if (y) grids.controlsChanged(); else grids.panels.strip.prepare(); // a map needs two
    assert.deepEqual([state.x?.[0] ?? x, state.y?.[0], state.over[0]], [x, y, x]);
  }
});
