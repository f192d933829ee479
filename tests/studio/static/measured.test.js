// Measured curves: what is read of a file, what is refused in one line, and where it is drawn.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, browser, near, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { LARGEST, readMeasured, withMeasured, shownOver } = await from("measured"), { timePanel, staticsPanel } = await from("panels");
const AXES = { time: "time (ms)", displacement: "height (mm)", velocity: "velocity (m/s)", voltage: "voltage (V)", constant: "constant voltage (V)" };
const ABOUT = { axes: AXES, si: true, film_of: "cone" };

const LOOK = { about: ABOUT, words: { ended: "", period: 20, shares: [] }, t: Float32Array.of(0, 10, 20), x: Float32Array.of(12, 14, 12), u: Float32Array.of(0, 0, 0), v: Float32Array.of(0, 100, 0), film: Uint8Array.of(0, 0, 0),
  statics: { voltage: Float32Array.of(0, 500, 1000), x: Float32Array.of(12, 13, 15), stable: Uint8Array.of(1, 1, 1), marks: {}, swing: [0, 500] } };

const panel = (make, looks) => { const p = make(document.createElement("div"), { active: "a", a: LOOK, ...looks }, { time: () => null, state: () => null }); p.redraw(); return p; };

test("separators, decimal commas, a byte order mark and units in either line are read", () => {
  const texts = ["time (s),height (mm)\n0.001,5\n0.002,6e0\n", "\ufefftime (s);height (mm)\n0,001;5\n0,002;6\n", "Time [ms]\tdisplacement / m\r\n1\t0.005\r\n2\t0.006\r\n", "time (s)\theight (mm)\n0,001\t5\n0,002\t6,0\n", "# note\n\"time\",\"height\"\n(ms),(um)\n1,5000\n2,6000\n"];
  for (const text of texts) {
    const own = readMeasured("a.csv", text);
    assert.ok(own.over === "time" && near(own.along[0], 1, 1e-12) && near(own.along[1], 2, 1e-12) && near(own.values[1], 6, 1e-12), text);
  }
  const both = readMeasured("b.csv", "t (ms),U (kV),stroke (mm),temperature\n0,1,2,x\n1,1.5,3,\n");
  assert.deepEqual([both.from, [...both.volts], [...both.values]], ["stroke", [1000, 1500], [2, 3]]);
});

test("a curve may have two heights at one time or voltage, as at a jump", () => {
  for (const name of ["time (ms)", "voltage (V)"]) assert.deepEqual([...readMeasured("a.csv", `${name},height (mm)\n1,5\n1,6\n2,6\n`).along], [1, 1, 2]);
  assert.deepEqual([...readMeasured("a.csv", "voltage (V),height (mm)\n1,5\n2,6\n1,5.5\n").along], [1, 2, 1]); // up and down again
});

test("what is wrong is refused in one line that names the file", () => {
  const cases = [
    ["", "needs a line of names"], ["time (ms)\n1\n2\n", "names one column"], ["time,height (mm)\n1,2\n3,4\n", "has no unit; write time (s, ms, us)"], ["time (V),height (mm)\n1,2\n3,4\n", '"V" is not its unit'],
    ["a,b\n1,2\n3,4\n", "needs a column time"], ["time (ms),height (mm)\n1,2,3\n3,4\n", "line 2: has 3 values, the first line 2; with decimal commas"], ["time (ms),height (mm)\n1,2\n3,x\n", 'line 3: "x" is not a number'],
    ["time (ms),height (mm)\n2,2\n1,4\n", "its times go back"], ["time (ms),height (mm),height low (mm)\n1,2,3\n2,4,5\n", "a band needs two columns, such as height low (mm) and height high (mm)"], ["time (ms),height (mm),stroke (mm),height (mm)\n1,2,3,4\n2,4,5,6\n", "two columns hold height"],
    ["time (ms),height (mm)\n1,1e99\n2,3\n", "1e99 is too large"], ["a\0b", "is not a text"], ["x".repeat(LARGEST + 1), "has more than"], [`time (ms),height (mm)\n${"1,2\n".repeat(20010)}`, "more than 20000 rows"], [`${"a,".repeat(40)}\n1\n2\n`, "give at most 32"],
    ["time (ms),height (mm)\nNaN,1\n1,2\n2,3\n", "line 2"], ...["x5", "5x", "1e", "--1", "1.2.3", ".", "", "0x1", "1 2"].map((cell) => [`time (ms),height (mm)\n1,2\n3,${cell}\n`, `line 3: "${cell}" is not a number`]), ["__proto__ (ms),constructor (mm)\n1,2\n2,3\n", "needs a column time"],
  ];
  for (const [text, words] of cases) assert.throws(() => readMeasured("a.csv", text), (error) => error.message.startsWith("a.csv: ") && error.message.includes(words) && !error.message.includes("\n") && error.message.length < 300, words);
});

test("200 damaged files are read or refused in one line", () => {
  const good = "time (ms);voltage (kV);height (mm);height low (mm);height high (mm)\n0;0;1,5;1;2\n1;0,5;2;1,5;3\n2;1;3;2,5;4\n", odd = "\0;,\"\n\r\t()[]/e-+.#é\ufeff9 <";
  let seed = 7, refused = 0;
  const next = (n) => { seed = (seed * 1103515245 + 12345) % 2147483648; return seed % n; };
  for (let k = 0; k < 200; k++) {
    let text = good;
    for (let c = 0; c <= k % 5; c++) { const at = next(text.length); text = text.slice(0, at) + odd[next(odd.length)] + text.slice(at + next(3)); }
    try {
      const own = readMeasured("f.csv", text);
      assert.ok(own.values.every(Number.isFinite) && own.values.length === own.along.length);
    } catch (error) { refused++; assert.match(error.message, /^f\.csv: [^\n\r]{5,240}$/); }
  }
  assert.ok(refused > 60);
});

test("strokes stand on the computed rest, a band between its ends, and nothing without units", () => {
  const stroke = readMeasured("s.csv", "voltage (kV),stroke (mm),stroke low (mm),stroke high (mm)\n0,0,0,0\n0.5,1,0.5,1.5\n"), heights = readMeasured("h.csv", "time (s),height (mm)\n7,12\n7.01,13.5\n");
  const p = panel(staticsPanel, { measured: [stroke, heights] }), band = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.fillStyle === LIGHT.ink && c.globalAlpha === 0.22).map((c) => c.args);
  assert.ok(band.length === 4 && near(band[1][0], p.X(500), 1e-3) && near(band[1][1], p.Y(13.5), 1e-3) && near(band[2][1], p.Y(12.5), 1e-3));
  assert.deepEqual(p.context.calls.filter((c) => c.name === "stroke" && c.strokeStyle === LIGHT.ink).map((c) => c.dash), [[1, 2]]); // the curve within its band
  assert.ok(texts(p.context).includes("s.csv") && !texts(p.context).includes("h.csv"));
  const time = panel(timePanel, { measured: [stroke, heights] });
  const points = time.context.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.ink).map(({ args: [x, y, w] }) => [x + w / 2, y + w / 2]);
  assert.ok(near(points[1][0], time.X(10), 1e-3) && near(points[1][1], time.Y(13.5), 1e-3) && texts(time.context).includes("h.csv"));
  assert.deepEqual(shownOver({ active: "a", a: { about: { si: false } }, measured: [stroke] }, "voltage", 1), []);
  for (const [rest, count] of [[1, 1], [NaN, 0]]) assert.equal(shownOver({ active: "a", a: { about: { si: true } }, measured: [stroke] }, "voltage", rest).length, count); // of no rest strokes have no place
});

test("the points of a curve with many samples are smaller, so that it shows its course", () => {
  const sizes = [3, 500].map((n) => {
    const rows = Array.from({ length: n }, (_, k) => `${(20 * k) / n},${12 + (2 * k) / n}`).join("\n"), p = panel(timePanel, { measured: [readMeasured("h.csv", `time (ms),height (mm)\n${rows}\n`)] });
    const points = p.context.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.ink).map((c) => c.args[2]);
    assert.equal(points.length, n);
    return points[0];
  });
  assert.ok(sizes[1] < sizes[0] && sizes[1] > 0);
});

test("a curve over a negative voltage stands where that of the positive one would, as the force does", () => {
  const stroke = readMeasured("s.csv", "voltage (V),stroke (mm)\n-500,1\n0,0\n"), p = panel(staticsPanel, { measured: [stroke] });
  const points = p.context.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.ink).map(({ args: [x, , w] }) => x + w / 2);
  for (const [k, volts] of [500, 0].entries()) assert.ok(near(points[k], p.X(volts), 1e-3));
});

test("strokes over time stand on the height at which the computed run begins", () => {
  const stroke = readMeasured("s.csv", "time (ms),stroke (mm)\n0,0\n10,1.5\n"), p = panel(timePanel, { measured: [stroke] });
  const points = p.context.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.ink).map(({ args: [x, y, w] }) => [x + w / 2, y + w / 2]);
  for (const [k, height] of [12, 13.5].entries()) assert.ok(near(points[k][1], p.Y(height), 1e-3));
});

test("a file takes the place of one of its name, and the oldest goes", () => {
  let all;
  for (let k = 0; k < 8; k++) all = withMeasured(all, { name: `${k}` });
  assert.deepEqual(all.map((own) => own.name), ["2", "3", "4", "5", "6", "7"]);
  assert.equal(withMeasured(all, { name: "4" }).at(-1).name, "4");
});

test("every column of a measured file is read in every one of its units", () => {
  const length = { m: 1e3, cm: 10, mm: 1, um: 1e-3, "µm": 1e-3, "μm": 1e-3 }, time = { s: 1e3, ms: 1, us: 1e-3, "µs": 1e-3 }, volt = { V: 1, kV: 1e3 };
  const rows = { time: [time, "along"], t: [time, "along"], voltage: [volt, "along"], u: [volt, "along"], height: [length, "values"], displacement: [length, "values"], position: [length, "values"], stroke: [length, "values"] };
  for (const [name, [units, part]] of Object.entries(rows)) for (const [unit, factor] of Object.entries(units)) {
    const text = part === "along" ? `${name} (${unit}),height (mm)\n1,5\n2,6\n` : `time (ms),${name} (${unit})\n5,1\n6,2\n`, own = readMeasured("a", text);
    assert.ok(near(own[part][0], factor, 1e-9 * factor) && near(own[part][1], 2 * factor, 1e-9 * factor), `${name} (${unit})`);
    assert.deepEqual([own.over, own.from], [part === "along" && units === volt ? "voltage" : "time", name === "stroke" ? "stroke" : "height"]);
  }
  const band = readMeasured("b", "voltage (V),height (mm),height low (mm),height high (um)\n1,5,4,6000\n2,6,5,7000\n");
  assert.deepEqual([[...band.low], [...band.high], band.volts, band.name], [[4, 5], [6, 7], null, "b"]);
  for (const [mark, note] of [[";", "a, b"], ["\t", "a, b"], [",", "a"]]) assert.deepEqual([...readMeasured("c", ["time (ms)", "height (mm)", note].join(mark) + `\n1${mark}5${mark}x\n2${mark}6${mark}y\n`).values], [5, 6], mark);
  for (const [text, word] of [
    ["time (ms),height (mm)\n2,5\n1,6\n", "times go back"], ["time (V),height (mm)\n1,5\n2,6\n", "is not its unit"], ["time,height (mm)\n1,5\n2,6\n", "has no unit"], ["time (ms),time (ms)\n1,5\n2,6\n", "two columns hold time"],
    ["time (ms),height (mm),height low (mm)\n1,5,4\n2,6,5\n", "a band needs two columns"], ["time (ms),height (mm)\n1,5\n2\n", "line 3: has 1 values, the first line 2"], ["time (ms),height (mm)\n1,5\n2,x\n", 'line 3: "x" is not a number'],
    ["time (ms),height (mm)\n1,5\n2,1e99\n", "is too large"], ["height (mm),stroke (mm)\n1,5\n2,6\n", "needs a column time (ms) or voltage (V)"], ["time (ms)\n1\n2\n", "names one column"], ["time (ms),height (mm)\n1,5\n", "needs a line of names"], ["a\0b\n1\n2\n", "is not a text"], [" ".repeat(LARGEST + 1), "has more than 2000000 characters"],
  ]) assert.throws(() => readMeasured("a.csv", text), (error) => error.message.startsWith("a.csv: ") && error.message.includes(word), word);
});

test("a curve is called by its file, in letters that can be read and no more than there is room for", () => {
  const text = "time (ms),height (mm)\n0,5\n1,6\n", named = (name) => readMeasured(name, text).name;
  assert.deepEqual([named("Höhe 3.csv"), named("a\n\u0007b.csv"), named("n".repeat(90))], ["Höhe 3.csv", "a  b.csv", "n".repeat(60)]);
  assert.throws(() => readMeasured("a\nb", ""), (error) => error.message.startsWith("a b: needs"));
});

test("a measured voltage over time stands on the computed one where they are the same", () => {
  const curve = readMeasured("u.csv", "time (ms),height (mm),voltage (V)\n0,12,0\n10,13,100\n20,12,0\n"), p = panel(timePanel, { measured: [curve] }), calls = p.context.calls;
  const line = calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.a && c.lineWidth === 1).map((c) => c.args);
  const points = calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.ink && c.args[2] === 1.5).map(({ args: [x, y, w] }) => [x + w / 2, y + w / 2]);
  assert.equal(points.length, 3);
  points.forEach((at, k) => assert.ok(near(at[0], line[k][0], 1e-6) && near(at[1], line[k][1], 1e-6)));
});

test("a curve that goes up and down again is whole in its picture", () => {
  const own = readMeasured("loop.csv", "voltage (V),height (mm)\n0,12\n3000,40\n0,12.5\n"), p = panel(staticsPanel, { measured: [own] });
  assert.ok(p.x[1] >= 3000 && p.y[1] >= 40, `${p.x} ${p.y}`);
});
