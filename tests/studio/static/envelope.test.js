// The envelope: window, limits, and the drive in them.
import assert from "node:assert/strict";
import test from "node:test";
import { HEAD, LIST, envelope, placed, pointer, setUp } from "./grid_panels.js";
import { LIGHT, browser, drawn, forget, near, texts, wait } from "./page.js";

browser();

test("an envelope grows: limits without a motion first, then a window as far as it is known", () => {
  const { first, half } = envelope();
  assert.deepEqual(first, [true, false, "drive: 10 Hz, peak 1800 V …"]);
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
  const plates = p.context.calls.filter((c) => c.name === "roundRect").length, names = texts(p.context).filter((text) => /^(static )?(pull-in|dielectric)/.test(text)).length;
  assert.ok(plates === names && names >= 2); // the curves end under the names
  assert.ok(near(p.toX(p.right), 15) && near(p.toY(p.top), 1.15 * 2500) && near(p.toY(p.bottom), 0));
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

test("a hand over the envelope moves the drive: frequency, and both voltages in their proportion", () => {
  const { canvas, p, gone, grids, asked } = envelope();
  canvas.onpointerdown(pointer(p, p.X(7), p.Y(900))); canvas.onpointerup(pointer(p, p.X(7), p.Y(900)));
  assert.deepEqual(gone.at(-1), [{ frequency: "7 Hz", voltage_amplitude: "400 V", voltage_offset: "500 V" }, true]);
  const before = asked.length;
  grids.changed();
  assert.equal(asked.length, before); // the envelope of this proportion is known
});

test("an envelope of another proportion, or another body, is computed again", () => {
  const { grids, panel, setting, controls, asked } = envelope();
  setting.values = { voltage_amplitude: "1.6 kV" }; controls.values(setting.values);
  grids.changed();
  wait(500);
  assert.equal(asked.at(-1)[0], "envelope");
  setting.values = { voltage_amplitude: "1.6 kV", film_thickness: "0.3 mm" }; controls.values(setting.values);
  grids.changed();
  wait(500);
  assert.deepEqual(asked.slice(-2).map(([kind]) => kind), ["cancel", "envelope"]);
  assert.equal(panel.si("voltage_amplitude", "V"), 1600);
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

test("an envelope is drawn from its window behind to its limits and names, each limit in a colour of its own", () => {
  const { panel, p } = envelope();
  for (const [stale, area, line] of [[false, " at 0.25", ""], [true, " at 0.1", " at 0.4"]]) {
    panel.stale = stale; forget(p.context); p.redraw();
    assert.deepEqual(drawn(p.context).slice(2), ["drive frequency (Hz) | soft 11px center bottom", "peak voltage (V) | soft 11px center middle", `area taut${area}`, `line taut 2${line}`, `line breakdown 1.6${line}`, `box breakdown${line}`, "area panel at 0.85", "pull-in of the membrane | breakdown 600 11px right middle", "line edge 1 dashed 3,4", "area panel at 0.85", "static pull-in of the membrane | soft 11px left middle", "recommended | taut 600 11px left middle"]);
  }
  const own = setUp("envelope"), limits = ["one", "two", "three", "four_five", "six", "seven"];
  own.grids.message({ ...HEAD, id: own.id(), limits, static: {} }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(2000, 1000), ...Object.fromEntries(limits.map((name, k) => [`limit ${name}`, Float32Array.of(2400 - 100 * k, 1200)])) });
  assert.deepEqual(drawn(own.p.context).flatMap((one) => one.match(/^(.*) \| (\w+) 600 11px right/)?.slice(1) ?? []), ["one", "breakdown", "two", "around", "three", "meridian", "four five", "both", "six", "a", "seven", "edge"]);
});

test("while an envelope is computed that is said in its place, and why there is none", () => {
  const own = setUp("envelope"), said = () => { forget(own.p.context); own.p.redraw(); return texts(own.p.context).join(" "); };
  assert.equal(said(), "computing the envelope, which takes some seconds …");
  own.grids.lost();
  assert.equal(said(), "");
  own.grids.opened(); own.grids.failed({ id: own.id(), message: "no drive" });
  assert.equal(said(), "no drive");
});

test("each name in an envelope stands at its place: limits in the corner one below the other, static ones over their lines", () => {
  const own = setUp("envelope"), { p } = own, at = () => p.context.calls.filter((c) => c.name === "fillText" && /^(static|one|two|recommended)/.test(c.args[0])).map((c) => [c.args[0], c.args[1], c.args[2], c.textAlign]);
  forget(p.context);
  own.grids.message({ ...HEAD, id: own.id(), limits: ["one", "two", "two that is never met"], static: { low: 1000, high: 2480 } }, { frequency: Float32Array.of(5, 15), window: Float32Array.of(900, 1000), "limit one": Float32Array.of(2400, 1200), "limit two": Float32Array.of(2300, 1100), "limit two that is never met": Float32Array.of(NaN, NaN) });
  assert.deepEqual(at(), [["one", 614, 18, "right"], ["two", 614, 32, "right"], ["static low", 62, p.Y(1000) - 9, "left"], ["static high", 62, p.Y(2480) - 9, "left"], ["recommended", 64, p.bottom - 10, "left"]]);
});
