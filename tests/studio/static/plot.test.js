// Axes, scales, ticks, ranges, lines: each at its pixel.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, browser, forget, near, page, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { ticks, extent, broken, Range, Plot } = await from("plot"), { colours } = await from("colours"), { plain } = await from("controls");

function plot(options = {}) {
  const host = document.createElement("div");
  return new Plot(host, options);
}

test("a place on the screen and its value belong together both ways", () => {
  const p = plot({ top: 10 });
  for (const part of [{}, { from: 0.5 }, { to: 0.4 }, { from: 0.25, to: 0.75 }]) {
    p.axes([-3, 7], [100, 400], part);
    const inner = 480 - 34 - 10, top = 10 + (part.from ?? 0) * inner, bottom = 10 + (part.to ?? 1) * inner;
    assert.deepEqual([p.left, p.right, p.top, p.bottom], [56, 620, top, bottom]);
    assert.ok(near(p.X(-3), 56) && near(p.X(7), 620));
    assert.ok(near(p.Y(100), bottom) && near(p.Y(400), top));
    for (const v of [-3, 0, 2.5, 7]) assert.ok(near(p.toX(p.X(v)), v));
    for (const v of [100, 217, 400]) assert.ok(near(p.toY(p.Y(v)), v));
  }
});

test("ticks are round numbers within the range, with the digits that tell them apart", () => {
  assert.deepEqual(ticks(0, 10, 5).map(([v, text]) => [v + 0, text]), [[0, "0"], [2, "2"], [4, "4"], [6, "6"], [8, "8"], [10, "10"]]);
  assert.deepEqual(ticks(-0.25, 0.25, 5).map(([, text]) => text), ["−0.2", "−0.1", "0.0", "0.1", "0.2"]);
  assert.deepEqual(ticks(0, 0.004, 4).map(([, text]) => text), ["0.000", "0.001", "0.002", "0.003", "0.004"]);
  for (const [low, high, most] of [[-3, 17, 6], [0.001, 0.0017, 4], [1e5, 9e5, 8], [-1e-9, 1e-9, 3]]) {
    const found = ticks(low, high, most).map(([v]) => v);
    assert.ok(found.length >= 2 && found.length <= most + 2);
    for (const v of found) assert.ok(v >= low - 1e-9 * (high - low) && v <= high + 1e-9 * (high - low));
    const steps = found.slice(1).map((v, k) => v - found[k]);
    for (const step of steps) assert.ok(near(step / steps[0], 1));
    assert.ok([1, 2, 5, 10].some((f) => near(steps[0] / 10 ** Math.floor(Math.log10(steps[0] * 1.0001)), f, 1e-6)));
  }
});

test("every tick stands at its value, and the axes are named", () => {
  const p = plot();
  p.axes([0, 10], [0, 4], { xLabel: "time (ms)", yLabel: "height (mm)" });
  const g = p.context, written = g.calls.filter((c) => c.name === "fillText");
  for (const [v, text] of ticks(0, 10, (p.right - p.left) / 76)) {
    const found = written.find((c) => c.args[0] === text && c.args[2] === p.bottom + 4);
    assert.equal(found.args[1], Math.round(p.X(v)) + 0.5);
  }
  for (const [v, text] of ticks(0, 4, (p.bottom - p.top) / 38)) {
    const found = written.find((c) => c.args[0] === text && c.args[1] === p.left - 5);
    assert.equal(found.args[2], Math.round(p.Y(v)) + 0.5);
  }
  assert.equal(written.find((c) => c.args[0] === "time (ms)").args[1], (p.left + p.right) / 2);
  assert.deepEqual(written.find((c) => c.args[0] === "height (mm)").shift, [7, (p.top + p.bottom) / 2]);
  forget(g);
  p.axes([0, 10], [0, 4], { xTicks: false, yText: (v) => `v${v}` });
  assert.ok(texts(g).every((text) => /^v/.test(text)));
});

test("the extent leaves out what is not a number", () => {
  assert.deepEqual(extent(Float32Array.of(3, NaN, -1), [7]), [-1, 7]);
  assert.deepEqual(extent([]), [Infinity, -Infinity]);
  assert.deepEqual([extent([3, 2, 1]), extent([-3, -2]), extent([5]), extent([4], [], [9, -9])], [[1, 3], [-3, -2], [5, 5], [-9, 9]]);
});

test("a range holds what is shown and moves only when it must", () => {
  const range = new Range(), first = [...range.fit([0, 10])];
  assert.ok(near(first[0], -0.8) && near(first[1], 10.8));
  assert.deepEqual(range.fit([1, 9.5]), first);
  const wider = [...range.fit([0, 12])];
  assert.ok(wider[0] < 0 && wider[1] > 12 && !near(wider[1], first[1]));
  const smaller = [...range.fit([0, 2])];
  assert.ok(smaller[1] < 3 && smaller[1] > 2 && smaller[0] < 0);
  const flat = new Range().fit([5, 5]);
  assert.ok(flat[0] < 5 && flat[1] > 5 && near((flat[0] + flat[1]) / 2, 5));
  const zero = new Range().fit([-1e-30, 2e-36]); // rest: no axis of rounding errors
  assert.ok(zero[0] < -0.4 && zero[1] > 0.4);
  const nearly = new Range().fit([100, 100.001]); // a change of 1e-5 is not magnified
  assert.ok(nearly[1] - nearly[0] >= 2 && nearly[0] < 100 && nearly[1] > 100.001);
  const none = new Range().fit([Infinity, -Infinity]);
  assert.ok(none[0] < 0 && none[1] > 1);
});

test("a line goes through its values and is broken where there is none", () => {
  const p = plot();
  p.axes([0, 4], [0, 4]);
  forget(p.context);
  p.line([0, 1, NaN, 3, 4], [0, 1, 2, 3, 2], { colour: "#111111", width: 2, dash: [3, 4], alpha: 0.5 });
  const moves = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name));
  assert.deepEqual(moves.map((c) => c.name), ["moveTo", "lineTo", "moveTo", "lineTo"]);
  assert.deepEqual(moves.map((c) => c.args), [[0, 0], [1, 1], [3, 3], [4, 2]].map(([x, y]) => [p.X(x), p.Y(y)]));
  const stroke = p.context.calls.find((c) => c.name === "stroke");
  assert.deepEqual([stroke.strokeStyle, stroke.lineWidth, stroke.globalAlpha, stroke.dash], ["#111111", 2, 0.5, [3, 4]]);
  const clip = p.context.calls.find((c) => c.name === "rect");
  assert.deepEqual(clip.args, [p.left, p.top - 1, p.right - p.left, p.bottom - p.top + 2]);
});

test("of a line with many samples as many are drawn as are asked for", () => {
  const p = plot();
  p.axes([0, 9], [0, 9]); forget(p.context);
  p.line([0, 1, 2, 3, 4], [0, 1, 2, 3, 4], { colour: "#111111", most: 3 });
  assert.deepEqual(p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args[0]), [0, 1, 2].map((v) => p.X(v)));
});

test("a dense line fills, column by column, what its samples span", () => {
  const p = plot(), n = 4000, x = Float64Array.from({ length: n }, (_, i) => i / (n - 1)), y = x.map((v, i) => (i % 2 ? 1 : -1) * v);
  p.axes([0, 1], [-2, 2]);
  forget(p.context);
  p.line(x, y, { colour: "#111111", sorted: true });
  const columns = p.context.calls.filter((c) => c.name === "fillRect");
  assert.ok(columns.length > 500 && columns.length < 600);
  for (const { args: [px, py, w, h], fillStyle } of columns.slice(5)) {
    const v = p.toX(px + 0.5);
    assert.ok(near(w, 1) && fillStyle === "#111111");
    assert.ok(Math.abs(py - p.Y(v)) < 3 && Math.abs(py + h - p.Y(-v)) < 3);
  }
  assert.ok(columns.slice(1).every((c, k) => near(c.args[0] - columns[k].args[0], 1)));
});

test("a plot that is given another size has it at once, on every screen", () => {
  for (const d of [1, 2]) {
    globalThis.devicePixelRatio = d;
    const p = plot({ draw: (own) => own.axes([0, 1], [0, 1]) }), resized = page.observers.at(-1);
    for (const [w, h] of [[300, 200], [900, 700]]) {
      Object.assign(p.box, { clientWidth: w, clientHeight: h });
      forget(p.context); resized();
      assert.deepEqual([p.canvas.width, p.canvas.height, p.context.calls.find((c) => c.name === "fillRect").args], [w * d, h * d, [0, 0, w, h]]);
      assert.deepEqual([p.X(1), p.Y(0)], [w - p.margin.right, h - p.margin.bottom]);
    }
  }
  globalThis.devicePixelRatio = 1;
});

test("points are centred on their values", () => {
  const p = plot();
  p.axes([0, 4], [0, 4]);
  forget(p.context);
  p.points([1, 2], [3, 1], { colour: "#222222", size: 4, alpha: 0.3 });
  const small = p.context.calls.filter((c) => c.name === "fillRect");
  assert.deepEqual(small.map((c) => c.args), [[1, 3], [2, 1]].map(([x, y]) => [p.X(x) - 2, p.Y(y) - 2, 4, 4]));
  assert.ok(small.every((c) => c.fillStyle === "#222222" && c.globalAlpha === 0.3));
  p.points([1], [3], { colour: "#222222", size: 8 });
  assert.deepEqual(p.context.calls.find((c) => c.name === "arc").args.slice(0, 3), [p.X(1), p.Y(3), 4]);
});

test("marks move without anything being drawn, and are hidden without a place", () => {
  const p = plot();
  p.axes([0, 4], [0, 4]);
  forget(p.context);
  p.upright(100);
  const line = p.marks.get("line");
  assert.deepEqual([line.hidden, line.style.transform, line.style.height, line.className], [false, `translate(100.0px, ${p.top.toFixed(1)}px)`, `${p.bottom - p.top}px`, "mark line"]);
  p.mark("dot", [3.14, 2.72], "a"); p.mark("dot", [1, 1], "b");
  assert.equal(p.marks.get("a").style.transform, "translate(3.1px, 2.7px)");
  p.upright(null);
  assert.ok(line.hidden);
  assert.equal(p.context.calls.length, 0);
});

test("a plot is drawn on its own ground, sharp on every screen", () => {
  globalThis.devicePixelRatio = 2;
  let drawn = 0, over = 0;
  const p = plot({ draw: (own) => { drawn++; own.axes([0, 1], [0, 1]); }, over: () => over++ });
  p.redraw();
  assert.deepEqual([drawn, over, p.canvas.width, p.canvas.height], [1, 1, 1280, 960]);
  assert.deepEqual(p.context.calls.slice(0, 2).map((c) => [c.name, c.args]), [["setTransform", [2, 0, 0, 2, 0, 0]], ["fillRect", [0, 0, 640, 480]]]);
  assert.equal(p.context.calls[1].fillStyle, LIGHT.panel);
  p.w = 0;
  p.redraw();
  assert.equal(drawn, 1);
  globalThis.devicePixelRatio = 1;
});

test("the name of an axis has the room between the ends of the plot about its own middle", () => {
  const p = plot();
  for (const [from, to] of [[0, 1], [0, 0.5], [0.75, 1]]) {
    forget(p.context); p.axes([0, 1], [0, 1], { xLabel: "along", yLabel: "up", from, to });
    const [along, up] = ["along", "up"].map((name) => p.context.calls.find((c) => c.name === "fillText" && c.args[0] === name)), middle = up.shift[1];
    assert.ok(near(middle, (p.top + p.bottom) / 2) && near(along.args[1], (p.left + p.right) / 2));
    assert.ok(near(up.args[3], 2 * Math.min(middle, 480 - middle)) && near(along.args[3], 2 * Math.min(along.args[1], 640 - along.args[1])));
  }
});

test("a text breaks into lines that fit, a long word stands alone", () => {
  const g = { measureText: (text) => ({ width: 6 * text.length }) };
  assert.deepEqual(broken(g, "one two three", 48), ["one two", "three"]);
  assert.deepEqual(broken(g, "one two three", 42), ["one two", "three"]); // a line may be as wide as there is room
  assert.deepEqual(broken(g, "incomprehensibilities no", 48), ["incomprehensibilities", "no"]);
});

test("a paragraph breaks between words and is centred", () => {
  const p = plot();
  p.paragraph("one two three four", 100, 50, 60);
  const lines = p.context.calls.filter((c) => c.name === "fillText");
  assert.deepEqual(lines.map((c) => c.args), [["one two", 100, 42.5], ["three four", 100, 57.5]]);
  assert.ok(lines.every((c) => c.fillStyle === colours().soft));
});

test("the place under the pointer is read in the units of the axes, also of a logarithmic one", () => {
  const p = plot(), at = (x, y) => { p.read({ clientX: 10 + p.X(x), clientY: 20 + p.Y(y) }); return p.reading.textContent; };
  p.axes([0, 10], [-4, 2]);
  assert.equal(at(2.5, 1.5), "2.5, 1.5");
  p.axes([0, 10], [-4, 2], { yText: (v) => `10^${v}` });
  assert.equal(at(2.5, 2), "2.5, 100");
});

test("ticks are multiples of 1, 2 or 5 within their range, few enough, with the digits that they need", () => {
  for (const [low, high, most, found] of [
    [0, 10, 5, ["0", "2", "4", "6", "8", "10"]], [0, 1, 4, ["0.0", "0.5", "1.0"]], [-1, 1, 4, ["−1.0", "−0.5", "0.0", "0.5", "1.0"]], [0, 100, 10, ["0", "10", "20", "30", "40", "50", "60", "70", "80", "90", "100"]],
    [3, 3.05, 2, ["3.00", "3.05"]], [0, 0.0002, 2, ["0", "1e−4", "2e−4"]], [0, 300000, 3, ["0", "1.0e+5", "2.0e+5", "3.0e+5"]],
  ]) assert.deepEqual(ticks(low, high, most).map(([, text]) => text), found, `${low} ${high}`);
  for (const [v, text] of ticks(-3.3, 7.1, 6)) assert.ok(v >= -3.3 && v <= 7.1 && near(Number(plain(text)), v, 1e-9));
  assert.deepEqual([extent([3, NaN, 1], [], [7]), extent([])], [[1, 7], [Infinity, -Infinity]]);
});

test("what is drawn on a plot is inside it, in its own style", () => {
  browser();
  const host = document.createElement("div"), plot = new Plot(host, {}), g = plot.context;
  plot.axes([0, 10], [0, 5], { xLabel: "time", yLabel: "height" });
  assert.deepEqual([plot.X(0), plot.X(10), plot.Y(0), plot.Y(5)], [56, 620, 446, 8]);
  assert.deepEqual([plot.toX(56), plot.toX(620), plot.toY(446), plot.toY(8)], [0, 10, 0, 5]);
  assert.ok(texts(g).includes("time") && texts(g).includes("height"));
  g.calls.length = 0;
  plot.line([0, 5, NaN, 10], [0, 5, 1, 0], { colour: "#123456", width: 2, alpha: 0.5, dash: [3, 1] });
  const drawn = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name));
  assert.deepEqual(drawn.map((c) => [c.name, ...c.args]), [["moveTo", 56, 446], ["lineTo", 338, 8], ["moveTo", 620, 446]]);
  assert.deepEqual([drawn[0].strokeStyle, drawn[0].lineWidth, drawn[0].globalAlpha, drawn[0].dash], ["#123456", 2, 0.5, [3, 1]]);
  assert.deepEqual(g.calls.filter((c) => c.name === "rect").map((c) => c.args), [[56, 7, 564, 440]]);
  g.calls.length = 0;
  plot.label("word", 5, 6, { colour: "#654321", align: "right", bold: true });
  const [word] = g.calls.filter((c) => c.name === "fillText");
  assert.deepEqual([word.args, word.fillStyle, word.textAlign ?? g.textAlign, word.font.startsWith("600 ")], [["word", 5, 6], "#654321", "right", true]);
});

test("a plate of the panel's colour lies under a text, wherever the text begins", () => {
  const p = plot(), g = p.context, wide = 6 * "pull-in".length;
  for (const [align, start] of [["left", 100], ["center", 100 - wide / 2], ["right", 100 - wide]]) {
    forget(g);
    p.label("pull-in", 100, 50, { align, plate: true });
    const [plate, fill, text] = ["roundRect", "fill", "fillText"].map((name) => g.calls.findIndex((c) => c.name === name));
    assert.deepEqual(g.calls[plate].args, [start - 5, 42, wide + 10, 16, 4]);
    assert.ok(g.calls[fill].fillStyle === LIGHT.panel && g.calls[fill].globalAlpha < 1 && plate < fill && fill < text);
    assert.deepEqual([g.calls[text].globalAlpha, g.calls[text].textAlign], [1, align]);
  }
  forget(g);
  p.label("pull-in", 100, 50);
  assert.ok(!g.calls.some((c) => c.name === "roundRect"));
});

test("before it has axes a plot reads no place and moves no marks", () => {
  let over = 0;
  const p = plot({ over: () => over++ });
  p.redrawOver(); p.read({ clientX: 300, clientY: 200 });
  assert.deepEqual([over, p.reading.hidden], [0, true]);
  p.axes([0, 1], [0, 1]); p.redrawOver();
  assert.equal(over, 1);
});

test("a dense dashed line has its dashes along the picture, as sharp as the screen", () => {
  for (const d of [1, 2]) {
    globalThis.devicePixelRatio = d;
    const p = plot(), n = 6000, x = Float64Array.from({ length: n }, (_, i) => i / (n - 1));
    p.axes([0, 1], [-2, 2]); forget(p.context);
    p.line(x, x, { colour: "#111111", sorted: true, dash: [12, 2] });
    const columns = p.context.calls.filter((c) => c.name === "fillRect").map((c) => c.args[0] * d);
    for (let column = 56 * d; column < 620 * d; column++) assert.equal(columns.includes(column), column % (14 * d) < 12 * d, `${column}`);
    assert.ok(p.context.calls.filter((c) => c.name === "fillRect").every((c) => near(c.args[2], 1 / d) && c.args[3] >= 1.3));
  }
  globalThis.devicePixelRatio = 1;
});

test("a dense line has no part where it has no value, and joins its columns where it jumps", () => {
  const p = plot(), n = 2000, x = Float64Array.from({ length: n }, (_, i) => i / (n - 1));
  p.axes([0, 1], [-2, 2]); forget(p.context);
  p.line(x, x.map((v) => (v < 0.25 ? NaN : v < 0.5 ? -1 : 1)), { colour: "#111111", sorted: true });
  const columns = p.context.calls.filter((c) => c.name === "fillRect").map((c) => c.args);
  assert.ok(near(columns[0][0], p.X(0.25), 0.01) && near(columns.at(-1)[0], 619, 0.01));
  assert.deepEqual(columns.filter(([, , , h]) => h > 10).map(([px, py, , h]) => [Math.abs(px - p.X(0.5)) < 1.5, near(py, p.Y(1) - 0.65), near(h, p.Y(-1) - p.Y(1) + 1.3)]), [[true, true, true]]);
});
