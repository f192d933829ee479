// What the cone draws of a look at the time shown.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, near } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { sideOf } = await from("side"), { add } = await from("profiles");
const LOOK = (about = {}) => ({ about: { si: true, rim: 30, second: null, ...about }, words: { period: 24 }, t: Float32Array.of(0, 48), x: Float32Array.of(0, 96), v: Float32Array.of(-300, 500) });
const at = (time, state) => ({ at: time, scene: (look) => look, state: () => state && { x: 0, v: 0, films: [0, 1], thin: [1, 2], field: [3, 4], ...state } });

test("height and voltage are read in the units of the look, kilovolts from 1000 V, and what is only rounding is 0", () => {
  for (const [state, si, height, voltage] of [[{ x: 12.346, v: 999.4 }, true, "12.3 mm", "999 V"], [{ x: -1.5, v: -1000 }, true, "−1.5 mm", "−1.00 kV"], [{ x: 2.9e-5, v: 1234.6 }, true, "0 mm", "1.23 kV"], [{ x: 3.1e-5, v: 0 }, true, "3.1e−5 mm", "0 V"], [{ x: 0.5, v: 1200 }, false, "0.5", "1200.00"], [{ x: 0.5, v: -0.126 }, false, "0.5", "−0.13"]]) {
    const side = sideOf(LOOK({ si }), "pump", at(0, state));
    assert.deepEqual([side.heightText, side.voltageText], [height, voltage]);
  }
});

test("a side has the state of its films, room for its motion, voltages from zero, and a disc at the top once the run has ended", () => {
  const look = LOOK(), now = sideOf(look, "pump", at(0, { x: 5, v: 70 }));
  assert.deepEqual([now.name, now.height, now.voltage, now.films, now.thin, now.field, now.low, now.high, now.volts], ["pump", 5, 70, [0, 1], [1, 2], [3, 4], 0, 96, [-300, 500]]);
  assert.deepEqual(sideOf({ ...look, v: Float32Array.of(200, 500), spanOf: null }, "pump", at(0, {})).volts, [0, 500]);
  const ended = sideOf(look, "pump", at(99, null));
  assert.deepEqual([ended.height, ended.voltage, ended.films], [96, 0, [0, 0]]);
});

test("the trail goes back over one drive period, the latest height first, and not before the run", () => {
  const look = LOOK();
  for (const time of [0, 7, 48]) {
    const { trail } = sideOf(look, "pump", at(time, {}));
    assert.equal(trail.length, Math.min(24, time));
    trail.forEach((height, k) => assert.ok(near(height, 2 * (time - k - 1), 1e-5), `${time} ${k}`));
  }
});

test("each film of a membrane has its own profile: the first at the height of the disc, the second at what is left below its plane", () => {
  const flat = (...values) => Float32Array.from(values);
  for (const [name, factor] of [["lower", 1], ["upper", 10]]) add({ name, shares: [0, 1], rings: 1 }, { height: flat(0, 100), top: flat(900, 900), radius: flat(0, 0, 100 * factor, 100 * factor), rise: flat(1, 1, 1, 1), stretch: flat(1, 1, 1, 1), wrinkled: flat(0, 0, 0, 0) });
  const { shapes } = sideOf(LOOK({ second: 50, membrane: ["lower", "upper"] }), "pump", at(0, { x: 20 }));
  assert.deepEqual(shapes.map((shape) => Math.round(shape[0].radius)), [20, 300]);
  assert.deepEqual(sideOf(LOOK(), "pump", at(0, {})).shapes, [null, null]);
});
