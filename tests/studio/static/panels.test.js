// The panels that follow every look, and the cone: curves, colours and marks at their places.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, boxes, browser, forget, near, overlapping, page, path, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { portraitPanel, spectrumPanel, staticsPanel, timePanel } = await from("panels"), { Cone } = await from("cone");
const AXES = { time: "time (ms)", displacement: "height (mm)", velocity: "velocity (m/s)", voltage: "voltage (V)", constant: "constant voltage (V)", frequency: "frequency (Hz)", amplitude: "amplitude (mm)" };
const ABOUT = { axes: AXES, si: true, film_of: "cone", disc: 8, rim: 30, second: null, bias: "spring", film: [], wrinkles: false };
const FILM = [LIGHT.taut, LIGHT.around, LIGHT.meridian, LIGHT.both, LIGHT.breakdown, LIGHT.limit, LIGHT.beyond];

const look = (more = {}) => ({ about: ABOUT, words: { ended: "", period: 20, shares: [] }, t: Float32Array.of(0, 10, 20, 30, 40), x: Float32Array.of(0, 2, 4, 2, 0), u: Float32Array.of(1, 1, -1, -1, 1), v: Float32Array.of(0, 100, 0, -100, 0), film: Uint8Array.of(0, 0, 0, 0, 0), ...more });
const at = (time, state) => ({ time: () => time, state: () => state });
const NOW = { x: 3, u: -0.5, v: 50, films: [0, 0] };

function panel(make, looks, clock = at(10, NOW)) {
  const p = make(document.createElement("div"), { active: "a", ...looks }, clock);
  p.redraw();
  return p;
}
const placed = (p, name) => p.marks.get(name).hidden ? null : p.marks.get(name).style.transform.match(/-?[\d.]+/g).map(Number);
const drawn = (p, colour) => p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === colour).map((c) => c.args);
const close = (one, other) => one.length === other.length && one.every((pair, k) => near(pair[0], other[k][0], 1e-4) && near(pair[1], other[k][1], 1e-4));

test("over time, height and voltage stand above each other over the same time", () => {
  const own = look(), p = panel(timePanel, { a: own }), lines = drawn(p, LIGHT.a);
  const heights = [...own.t].map((t, k) => [p.X(t), p.Y(own.x[k])]);
  assert.ok(close(lines.slice(5), heights));
  assert.ok(close(lines.slice(0, 5).map(([x]) => [x, 0]), heights.map(([x]) => [x, 0])));
  const volts = lines.slice(0, 5).map(([, y]) => y);
  assert.ok(volts[1] < volts[0] && volts[3] > volts[0] && near(volts[0] - volts[1], volts[3] - volts[0], 1e-4));
  assert.ok(Math.min(...volts) > p.bottom && Math.max(...volts) < 480 - 34);
  assert.ok(p.X(0) === p.left && near(p.X(40), p.right));
  for (const text of ["time (ms)", "height (mm)", "voltage (V)"]) assert.ok(texts(p.context).includes(text), text);
});

test("over time the settled motion is shown where the portrait shows it, and says so", () => {
  const scene = { t: Float32Array.of(0, 20), x: Float32Array.of(7, 9), u: Float32Array.of(0, 0), v: Float32Array.of(1, 1), film: Uint8Array.of(0, 0) };
  const own = look({ settled: scene }), p = panel(timePanel, { a: own, motion: "settled" });
  assert.ok(near(p.toX(p.right), 20) && texts(p.context).includes("time (ms) of the settled motion"));
  assert.ok(close(drawn(p, LIGHT.a).slice(2), [[p.X(0), p.Y(7)], [p.X(20), p.Y(9)]]));
  for (const looks of [{ a: own, motion: "start" }, { a: { ...own, old: true }, motion: "settled" }]) {
    const start = panel(timePanel, looks);
    assert.deepEqual([Math.round(start.toX(start.right)), texts(start.context).includes("time (ms) of the settled motion")], [40, false]);
  }
});

test("the cursor over time stands at its time, and goes where there is none", () => {
  let time = 10;
  const p = panel(timePanel, { a: look() }, { time: () => time, state: () => NOW });
  for (time of [0, 10, 37]) { p.redrawOver(); assert.ok(near(placed(p, "line")[0], p.X(time), 0.05)); }
  assert.ok(near(placed(p, "line")[1], 6, 0.05) && p.marks.get("line").style.height === `${480 - 34 - 6}px`);
  time = null; p.redrawOver();
  assert.equal(placed(p, "line"), null);
});

test("the film's states stand below the curve in their colours and at their times", () => {
  for (const film of [[0, 0, 1, 1, 1], [2, 3, 3, 4, 5], [5, 5, 5, 5, 5], [1, 0, 1, 0, 1]]) {
    const p = panel(timePanel, { a: look({ film: Uint8Array.from(film) }) }), wide = p.right - p.left;
    const bars = p.context.calls.filter((c) => c.name === "fillRect" && c.args[3] === 4 && FILM.includes(c.fillStyle));
    for (let k = 0; k < 5; k++) {
      const px = Math.min(Math.max(p.X(10 * k), p.left + 2), p.right - 2);
      const bar = bars.find(({ args: [x, , w] }) => px >= x && px < x + w);
      assert.equal(bar?.fillStyle, FILM[film[k]], `${film} at ${k}`);
      assert.equal(bar.args[1], p.bottom + 3);
    }
    assert.ok(near(bars.reduce((sum, { args }) => sum + args[2], 0), wide, 0.01));
  }
});

test("two settings share their axes, each in its colour; of other units only the active one is drawn", () => {
  const b = look({ t: Float32Array.of(0, 20, 40, 60, 80), x: Float32Array.of(0, 8, 0, 8, 0) }), p = panel(timePanel, { a: look(), b });
  assert.ok(near(p.X(80), p.right));
  assert.ok(close(drawn(p, LIGHT.b).slice(5), [...b.t].map((t, k) => [p.X(t), p.Y(b.x[k])])));
  const other = look({ about: { ...ABOUT, si: false } });
  const mixed = panel(timePanel, { a: look(), b: other });
  assert.deepEqual([drawn(mixed, LIGHT.a).length, drawn(mixed, LIGHT.b).length], [10, 0]);
});

const ORBIT = { ox: Float32Array.of(1, 2, 1, 0, 1), ou: Float32Array.of(0.5, 0, -0.5, 0, 0.5), px: Float32Array.of(1), pu: Float32Array.of(0.5), wanders: false };
const strokes = (p, faint) => p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.a && (c.globalAlpha < 0.5) === faint).map((c) => c.args);

test("the phase portrait has the height along and the velocity up: the settled orbit, its section points, and pale the run", () => {
  const own = look(ORBIT), p = panel(portraitPanel, { a: own });
  assert.ok(close(strokes(p, false), [...own.ox].map((x, k) => [p.X(x), p.Y(own.ou[k])])));
  assert.ok(close(strokes(p, true), [...own.x].map((x, k) => [p.X(x), p.Y(own.u[k])])));
  const [point] = p.context.calls.filter((c) => c.name === "arc");
  assert.deepEqual([point.args.slice(0, 3), point.fillStyle], [[p.X(1), p.Y(0.5), 3.5], LIGHT.b]);
  assert.ok(close([placed(p, "a")], [[p.X(3), p.Y(-0.5)].map((v) => Number(v.toFixed(1)))]));
  assert.equal(p.marks.get("b").hidden, true);
  assert.deepEqual(["height (mm)", "velocity (m/s)"].filter((text) => texts(p.context).includes(text)).length, 2);
  const wild = panel(portraitPanel, { a: { ...own, wanders: true } });
  assert.equal(wild.context.calls.filter((c) => c.name === "arc").length, 0);
  const both = panel(portraitPanel, { a: own, b: { ...own } });
  assert.deepEqual(both.context.calls.filter((c) => c.name === "arc").map((c) => c.fillStyle), [LIGHT.a]);
  assert.deepEqual(both.context.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.b).map((c) => c.args), [[p.X(1) - 3.5, p.Y(0.5) - 3.5, 7, 7]]);
  assert.deepEqual(both.context.calls.filter((c) => c.name === "lineTo" && c.lineWidth === 1.8).map((c) => [c.strokeStyle, c.dash.length > 0]).filter((own, k) => k % 4 === 0), [[LIGHT.a, false], [LIGHT.b, true]]);
});

test("from the start the run alone is drawn, in its own range; so is one without a settled motion", () => {
  for (const [own, motion] of [[look({ ...ORBIT, ox: Float32Array.of(40, 41) }), "start"], [look(), "settled"]]) {
    const p = panel(portraitPanel, { a: own, motion });
    assert.ok(close(strokes(p, false), [...own.x].map((x, k) => [p.X(x), p.Y(own.u[k])])));
    assert.ok(strokes(p, true).length === 0 && !p.context.calls.some((c) => c.name === "arc") && p.X(10) > p.right);
  }
});

test("every line of the second setting is dashed, and none of the first, whichever are shown", () => {
  for (const [make, lines] of [[timePanel, 2], [portraitPanel, 1]]) for (const sides of [["a"], ["b"], ["a", "b"]]) {
    const p = panel(make, { active: sides[0], ...Object.fromEntries(sides.map((side) => [side, look(make === portraitPanel ? ORBIT : {})])) });
    for (const side of sides) {
      const begun = p.context.calls.filter((c) => c.name === "moveTo" && c.strokeStyle === LIGHT[side] && c.lineWidth >= 1).map((c) => c.dash.length > 0);
      assert.deepEqual(begun, Array(lines).fill(side === "b"), `${make.name} ${sides} ${side}`);
    }
  }
});

test("of a run with more samples than are drawn the portrait says so where it is drawn alone, not behind its settled motion", () => {
  const long = { x: new Float32Array(20001).fill(2), u: new Float32Array(20001).fill(1) };
  const said = (more, motion) => texts(panel(portraitPanel, { a: look({ ...long, ...more }), motion }).context).includes("only the beginning of the run");
  assert.deepEqual([said({}), said(ORBIT, "start"), said(ORBIT)], [true, true, false]);
});

test("the settled orbit has the room: a run far outside is cut, a wide one inside shown, one of an older setting faded", () => {
  const far = panel(portraitPanel, { a: look({ ...ORBIT, x: Float32Array.of(0, 200, -200, 0, 0) }) });
  assert.ok(far.X(200) > far.right && far.X(0) > far.left && far.X(2) < far.right && far.X(2) - far.X(0) > 0.4 * (far.right - far.left));
  const old = panel(portraitPanel, { a: look({ ...ORBIT, old: true }) });
  assert.equal(strokes(old, false).length, 0);
  const standing = panel(portraitPanel, { a: look({ ...ORBIT, ox: Float32Array.of(1, 1), ou: Float32Array.of(0, 0), px: Float32Array.of(1), pu: Float32Array.of(0) }) });
  assert.ok(standing.X(4) < standing.right && standing.Y(1) > standing.top);
});

test("a click over time goes to its time, a drag through the run, and a drag that the system takes away ends", () => {
  const asked = [], p = panel(timePanel, { a: look() }, { ...at(10, NOW), goTo: (t) => asked.push(t) }), c = p.canvas;
  const event = (t) => ({ pointerId: 1, clientX: p.X(t) + 10, clientY: 50 }); // the canvas stands 10 pixels from the left
  c.onpointermove(event(5)); c.onpointerdown(event(20)); c.onpointermove(event(30)); c.onpointercancel(); c.onpointermove(event(40));
  assert.ok(asked.length === 2 && near(asked[0], 20) && near(asked[1], 30));
});

test("the place under the pointer is read in the units of the axes, and none outside them", () => {
  const p = panel(portraitPanel, { a: look(ORBIT) });
  p.read({ clientX: p.X(1.5) + 10, clientY: p.Y(-0.25) + 20 });
  assert.deepEqual([p.reading.hidden, p.reading.textContent], [false, "1.5, −0.25"]);
  p.read({ clientX: 11, clientY: 50 });
  assert.ok(p.reading.hidden);
  for (const [event, hidden] of [["pointermove", false], ["pointerleave", true]]) {
    for (const does of p.box.listeners[event]) does({ clientX: p.X(1.5) + 10, clientY: p.Y(-0.25) + 20 });
    assert.equal(p.reading.hidden, hidden, event);
  }
});

test("a dot outside the axes is not drawn", () => {
  const p = panel(portraitPanel, { a: look(ORBIT) }, at(0, { ...NOW, x: 400 }));
  assert.equal(placed(p, "a"), null);
});

test("where a run ends before its time there is a cross, and why", () => {
  const own = look({ words: { ended: "pulled in", period: 20, shares: [] } });
  for (const [make, at] of [[timePanel, (p) => [p.X(40), p.Y(0)]], [portraitPanel, (p) => [p.X(0), p.Y(1)]]]) {
    const p = panel(make, { a: own }), [x, y] = at(p), cross = drawn(p, LIGHT.breakdown);
    assert.ok(close(cross, [[x - 6, y + 6], [x + 6, y - 6], [x - 6, y - 6], [x + 6, y + 6]]) && texts(p.context).includes("pulled in"));
    assert.equal(drawn(panel(make, { a: look() }), LIGHT.breakdown).length, 0);
  }
});

test("the reason stands on the side of its cross where it has room, and texts lie neither over each other nor outside", () => {
  const measured = ["one.csv", "two.csv", "three.csv"].map((name) => ({ name, over: "time", from: "height", along: Float64Array.of(0, 20), values: Float64Array.of(1, 2), volts: null, low: null, high: null }));
  const statics = { voltage: Float32Array.of(0, 900), x: Float32Array.of(0, 4), stable: Uint8Array.of(1, 1), marks: { pitchfork: 880, pull_in: 900 }, swing: [0, 100] };
  const reason = "the film reaches its stretch limit";
  for (const [place, x] of [[0, 0], [4, 4]]) for (const make of [timePanel, portraitPanel, staticsPanel]) {
    const own = look({ words: { ended: reason, period: 20, shares: [] }, statics, x: Float32Array.of(2, 0, 4, 2, x), u: Float32Array.of(1, 1, -1, -1, 1) });
    const b = look({ t: Float32Array.of(0, 50, 100, 150, place ? 40 : 400), x: Float32Array.of(2, 0, 4, 2, 2) }); // makes room on the right of the other's end
    const p = panel(make, { a: own, b: make === timePanel && !place ? b : undefined, measured: measured.map((one) => ({ ...one, over: make === staticsPanel ? "voltage" : "time" })) }), all = boxes(p.context);
    assert.deepEqual(overlapping(all), [], `${make.name} ${place}`);
    for (const [text, left, top, right, bottom] of all) assert.ok(left >= 0 && top >= 0 && right <= 640 && bottom <= 480, `${make.name} ${place}: ${text}`);
    for (const name of make === portraitPanel ? [] : ["one.csv", "two.csv", "three.csv"]) assert.equal(all.filter(([text]) => text === name).length, 1, name);
    if (make !== staticsPanel) assert.equal(all.filter(([text, left, , right]) => text === reason && left >= p.left && right <= p.right).length, 1, `${make.name} ${place}`);
  }
});

test("the reason is read whole also where a run ends at the edge of its axes, which stay as they are", () => {
  for (const make of [timePanel, portraitPanel]) for (const k of [0, 1]) {
    const looks = { active: "a", a: look() }, p = make(document.createElement("div"), looks, at(10, NOW));
    p.redraw();
    const edge = p.y[k] + (k ? -1e-4 : 1e-4), own = make === timePanel ? "x" : "u";
    looks.a = look({ words: { ended: "pulled in", period: 20, shares: [] }, [own]: Float32Array.of(...[...look()[own]].slice(0, 4), edge) });
    forget(p.context); p.redraw();
    const [[, , top, , bottom]] = boxes(p.context).filter(([text]) => text === "pulled in");
    assert.ok(near(p.y[k], edge, 1e-3) && top >= p.top && bottom <= p.bottom, `${make.name} ${k}`);
  }
});

test("a run that had to be cut says so", () => {
  const said = (words) => texts(panel(timePanel, { a: look({ words: { ended: "", period: 20, shares: [], ...words } }) }).context);
  assert.ok(said({ shown: 3.512, cut: true }).some((text) => text.startsWith("only the first 3.5 periods")));
  assert.ok(!said({ shown: 20, cut: false }).some((text) => text.startsWith("only the first")));
});

test("the spectrum is that of its frequencies on a logarithmic axis, with its lines", () => {
  const spectrum = { frequency: Float32Array.of(0, 5, 10, 15), amplitude: Float32Array.of(1, 0.01, 1, 0.0001), line: Float32Array.of(10), height: Float32Array.of(1), top: 80 };
  const p = panel(spectrumPanel, { a: look({ spectrum }) });
  assert.ok(close(drawn(p, LIGHT.a), [[p.X(0), p.Y(0)], [p.X(5), p.Y(-2)], [p.X(10), p.Y(0)], [p.X(15), p.Y(-4)]]));
  assert.ok(near(p.X(0), p.left) && near(p.X(80), p.right));
  const [dot] = p.context.calls.filter((c) => c.name === "arc");
  assert.ok(close([dot.args.slice(0, 2)], [[p.X(10), p.Y(0)]]) && dot.fillStyle === LIGHT.a);
  for (const text of ["10⁰", "10⁻⁴", "frequency (Hz)", "amplitude (mm)"]) assert.ok(texts(p.context).includes(text), text);
});

test("the lines of two settings at one place both show: a dot below a smaller square", () => {
  const spectrum = { frequency: Float32Array.of(0, 10), amplitude: Float32Array.of(1, 1), line: Float32Array.of(10), height: Float32Array.of(1), top: 80 };
  const p = panel(spectrumPanel, { a: look({ spectrum }), b: look({ spectrum }) }), { calls } = p.context;
  const dot = calls.findIndex((c) => c.name === "arc" && c.fillStyle === LIGHT.a), square = calls.findIndex((c) => c.name === "fillRect" && c.fillStyle === LIGHT.b);
  assert.ok(dot >= 0 && square > dot && calls[square].args[2] < 2 * calls[dot].args[2]);
});

test("a motion without a spectrum says why", () => {
  const said = (own) => texts(panel(spectrumPanel, { a: own }).context).at(-1);
  assert.equal(said(look({ words: { ended: "pulled in" } })), "A motion that ends has no spectrum.");
  assert.match(said(look()), /stands still|being computed/);
  assert.match(said(look({ spectrum: { amplitude: Float32Array.of(NaN) } })), /stands still|being computed/);
});

test("statics: stable and unstable equilibria, marks, the settled motion, and a dot at the voltage now", () => {
  const statics = { voltage: Float32Array.of(0, 500, 1000, 900), x: Float32Array.of(4, 3, 2, 1), stable: Uint8Array.of(1, 1, 0, 0), marks: { pull_in: 1000 }, swing: [-300, 700] };
  const p = panel(staticsPanel, { a: look({ statics, extent: [1, 3] }) }, at(0, { ...NOW, v: -250 }));
  const strokes = p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.a);
  const of = (dashed) => strokes.filter((c) => (c.dash.length > 0) === dashed).map((c) => c.args);
  assert.ok(close(of(false), [[p.X(0), p.Y(4)], [p.X(500), p.Y(3)]]));
  assert.ok(close(of(true), [[p.X(1000), p.Y(2)], [p.X(900), p.Y(1)]]));
  const mark = p.context.calls.filter((c) => c.strokeStyle === LIGHT.edge && ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args[0]);
  assert.ok(mark.length === 2 && mark.every((x) => near(x, p.X(1000))));
  assert.ok(texts(p.context).includes("pull-in of the cone") && texts(p.context).includes("constant voltage (V)"));
  const area = p.context.calls.find((c) => c.name === "fillRect" && near(c.globalAlpha, 0.12));
  assert.ok(close([area.args.slice(0, 2), area.args.slice(2)], [[p.X(0), p.Y(3)], [p.X(700) - p.X(0), p.Y(1) - p.Y(3)]]));
  assert.ok(near(placed(p, "a")[0], p.X(250), 0.1) && near(placed(p, "a")[1], p.Y(3), 0.1));
  const one = panel(staticsPanel, { a: look({ statics: { ...statics, swing: [200, 700] }, extent: [1, 3] }) });
  assert.ok(near(one.context.calls.find((c) => c.name === "fillRect" && near(c.globalAlpha, 0.12)).args[0], one.X(200)));
  const below = panel(staticsPanel, { a: look({ statics: { ...statics, swing: [-700, -200] }, extent: [1, 3] }) });
  assert.ok(near(below.context.calls.find((c) => c.name === "fillRect" && near(c.globalAlpha, 0.12)).args[0], below.X(200)));
  assert.match(texts(panel(staticsPanel, { a: look() }).context).at(-1), /Computing the equilibria/);
});

test("pull-in is that of the film which pulls in, and a drive below zero has its room, too", () => {
  const statics = { voltage: Float32Array.of(0, 100), x: Float32Array.of(4, 3), stable: Uint8Array.of(1, 1), marks: { pull_in: 100 }, swing: [-900, 50] };
  const p = panel(staticsPanel, { a: look({ statics, about: { ...ABOUT, film_of: "membrane" } }) });
  assert.ok(texts(p.context).includes("pull-in of the membrane") && !texts(p.context).includes("pull-in of the cone"));
  assert.ok(p.toX(p.right) >= 900); // its size counts, as the force does
});

test("each axis of the phase portrait and of the spectrum has the name and unit of what it shows", () => {
  const upright = (p) => p.context.calls.filter((c) => c.name === "fillText" && c.args[1] === 0 && c.args[2] === 0).map((c) => c.args[0]);
  const portrait = panel(portraitPanel, { a: look() });
  assert.deepEqual([upright(portrait), texts(portrait.context).includes("height (mm)")], [["velocity (m/s)"], true]);
  const spectrum = { frequency: Float32Array.of(0, 5, 10), amplitude: Float32Array.of(1, 0.01, 1), line: new Float32Array(0), height: new Float32Array(0), top: 80 };
  assert.deepEqual(upright(panel(spectrumPanel, { a: look({ spectrum }) })), ["amplitude (mm)"]);
  const statics = { voltage: Float32Array.of(0, 500), x: Float32Array.of(4, 3), stable: Uint8Array.of(1, 1), marks: {}, swing: [0, 50] };
  assert.deepEqual(upright(panel(staticsPanel, { a: look({ statics }) })), ["height (mm)"]);
});

test("spectra of two settings have room for both", () => {
  const spectrum = (top) => ({ frequency: Float32Array.of(0, 5, 10), amplitude: Float32Array.of(1, 0.01, 1), line: new Float32Array(0), height: new Float32Array(0), top });
  for (const [a, b] of [[80, 200], [200, 80]]) assert.ok(near(panel(spectrumPanel, { a: look({ spectrum: spectrum(a) }), b: look({ spectrum: spectrum(b) }) }).x[1], 200));
});

test("the mean of a motion does not push its spectrum out of the picture", () => {
  const spectrum = { frequency: Float32Array.of(0, 5, 10), amplitude: Float32Array.of(1e6, 0.01, 0.1), line: new Float32Array(0), height: new Float32Array(0), top: 80 };
  const p = panel(spectrumPanel, { a: look({ spectrum }) });
  assert.ok(p.y[1] < 0 && p.y[0] > -9 && p.Y(-1) < p.Y(-2)); // decades about the largest amplitude, 0.1
});

// --- the cone --------------------------------------------------------------------------------------------------------

function cone(sides) {
  const canvas = document.createElement("canvas"), own = new Cone(canvas);
  own.draw(sides.map((side) => ({ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [-1000, 2000], voltage: 500, heightText: "10 mm", voltageText: "500 V", ...side })));
  return { own, g: canvas.getContext() };
}
const shifted = (calls, name) => calls.filter((c) => c.name === name).map((c) => [c.args[0] + c.shift[0], c.args[1] + c.shift[1], ...c.args.slice(2)]);

test("the cone in section: film from rim to disc at its height and in the colour of its state", () => {
  for (const [height, film] of [[10, 0], [20, 1], [0, 4], [5, 5]]) {
    const { own, g } = cone([{ height, films: [film, 0] }]), side = { about: ABOUT, low: 0, high: 20 };
    const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
    const lines = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[film] && c.lineWidth > 2).map((c) => c.args);
    const ends = [[-1, 30, 0], [-1, 8, height], [1, 30, 0], [1, 8, height]].map(([sign, r, z]) => [middle + sign * r * scale, ground - z * scale]);
    for (const end of ends) assert.ok(lines.some((at) => close([at], [end])), `${height}`);
    assert.ok(texts(g).includes("10 mm") && texts(g).includes("500 V") && texts(g).includes("voltage"));
  }
});

test("a cone that is given another size asks to be drawn in it, and is", () => {
  const { own } = cone([{}]), resized = page.observers.at(-1);
  let woken = 0;
  own.wakes = () => { woken += 1; };
  for (const [w, h] of [[900, 300], [300, 700]]) {
    Object.assign(own.canvas, { clientWidth: w, clientHeight: h });
    own.changed = false; resized();
    assert.deepEqual([own.canvas.width, own.canvas.height, own.changed], [w, h, true]);
    forget(own.context);
    own.draw([{ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [0, 100], voltage: 50, heightText: "10 mm", voltageText: "50 V" }]);
    const rims = own.context.calls.filter((c) => c.name === "ellipse").map((c) => c.args[2]);
    assert.ok(Math.max(...rims) < w / 4 && Math.max(...rims) > 30);
  }
  assert.equal(woken, 2);
});

test("a cone is as large as its canvas allows, whichever side is the narrow one", () => {
  for (const [low, high, rim] of [[0, 20, 30], [0, 400, 30], [-300, 100, 30], [0, 5, 300], [0, 0, 30]]) {
    const about = { ...ABOUT, rim, disc: rim / 4 }, side = { about, low, high };
    for (const [height, other] of [[high, 0], [low, 0], [high, high || null]]) {
      const { own, g } = cone([{ about: { ...about, second: other || null }, low, high, height }]);
      const shown = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[0] && c.lineWidth > 2).map((c) => [c.args[0] + c.shift[0], c.args[1] + c.shift[1]]);
      assert.ok(shown.length > 0 && shown.every(([x, y]) => x >= 0 && x <= 640 && y >= 0 && y <= 480), `${low} ${high} ${rim}`);
    }
    const { own } = cone([side]), [most, least] = own.reach(side), scale = own.scale(side);
    assert.ok(near(Math.max((2.28 * rim * scale) / (0.5 * (640 - 46)), ((most - least + 0.75 * rim) * scale) / (480 - 54)), 1, 1e-9));
  }
});

test("a membrane is drawn along its own profile, wrinkled rings dashed and in their colour; a slack one as it was", () => {
  const shape = [{ radius: 8, rise: 1, stretch: 2, wrinkled: false }, { radius: 15, rise: 0.3, stretch: 1.5, wrinkled: true }, { radius: 30, rise: 0, stretch: 1, wrinkled: true }];
  const { own, g } = cone([{ films: [1, 0], shapes: [shape, null], thin: [0.5, NaN], field: [0, 0] }]), side = { about: ABOUT, low: 0, high: 20 };
  const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
  const place = (sign, k) => [middle + sign * shape[k].radius * scale, ground - 10 * shape[k].rise * scale];
  const [taut, wrinkled] = [0, 1].map((film) => g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[film] && c.lineWidth > 1).slice(0, 4));
  assert.ok(close(taut.map((c) => c.args), [place(-1, 0), place(-1, 1), place(1, 0), place(1, 1)]));
  assert.ok(close(wrinkled.map((c) => c.args), [place(-1, 1), place(-1, 2), place(1, 1), place(1, 2)]));
  assert.ok(taut.every((c) => !c.dash.length) && wrinkled.every((c) => c.dash.length));
  assert.ok(near(taut[0].lineWidth, 5 * 0.5 * (2 / 1.75)) && near(wrinkled[0].lineWidth, 5 * 0.5 * (2 / 1.25)));
  const slack = cone([{ films: [2, 0], shapes: [shape, null] }]).g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === FILM[2] && c.lineWidth > 2);
  assert.equal(slack.length, 2 * 49);
});

test("slack films wave and are pleated: around, from rim to disc, or both", () => {
  const { own } = cone([{}]);
  const shade = (film, sector, ring) => own.shade(film, 1, 0.3, sector, ring, true);
  const light = (...facet) => shade(...facet).match(/\d+/g).reduce((sum, v) => sum + Number(v), 0);
  assert.equal(shade(0, 1, 0), shade(0, 2, 0));
  assert.ok(light(1, 1, 0) < light(1, 2, 0)); // the inside of a pleat is darker
  assert.equal(shade(1, 1, 0), shade(1, 1, 1));
  assert.ok(light(2, 1, 1) < light(2, 1, 0));
  assert.equal(shade(2, 1, 0), shade(2, 2, 0));
  assert.ok(light(3, 1, 0) < light(3, 2, 0) && light(3, 1, 1) < light(3, 1, 0));
  const straight = (film) => {
    const { g } = cone([{ films: [film, 0] }]), points = g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === FILM[film] && c.lineWidth > 2).map((c) => c.args).slice(0, 49);
    const [x0, y0] = points[0], [x1, y1] = points[48];
    return Math.max(...points.map(([x, y]) => Math.abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) / Math.hypot(x1 - x0, y1 - y0))) < 0.01;
  };
  assert.deepEqual([0, 1, 2, 3, 4].map(straight), [true, true, false, false, true]);
});

test("the gauge is filled from zero to the voltage", () => {
  const bar = (voltage, volts) => cone([{ voltage, volts }]).g.calls.filter((c) => c.name === "roundRect" && c.fillStyle === LIGHT.accent)[0].args;
  const Y = (v) => 480 - 24 - ((v + 1000) / 3000) * (480 - 24 - 22);
  assert.ok(near(bar(500, [-1000, 2000])[1], Y(500)) && near(bar(500, [-1000, 2000])[3], Y(0) - Y(500)));
  assert.ok(near(bar(-500, [-1000, 2000])[1], Y(0)) && near(bar(-500, [-1000, 2000])[3], Y(-500) - Y(0)));
  const above = bar(1000, [500, 2000]); // of voltages that are all above zero from the least of them
  assert.ok(near(above[1] + above[3], 480 - 24) && near(above[3], (480 - 24 - 22) / 3));
});

test("all that moves stays in the picture, whatever the sizes", () => {
  for (const side of [{ low: 0, high: 80 }, { low: -60, high: 5 }, { low: 0, high: 1 }]) {
    const { own } = cone([side]), whole = { about: ABOUT, ...side }, scale = own.scale(whole), ground = own.ground(whole, 480, scale);
    for (const z of [side.low, side.high]) assert.ok(ground - z * scale > 0 && ground - z * scale < 480, `${z}`);
    assert.ok(2 * 30 * scale < 320);
  }
});

// The quadrilaterals of a film in perspective: their corners, as they are filled one after the other; and when the disc is.
function faces(side) {
  const { own, g } = cone([side, {}]), calls = g.calls.slice(0, g.calls.findIndex((c) => c.name === "restore")), found = []; // the first of two
  let corners = [], disc = -1;
  for (const c of calls) {
    if (c.name === "moveTo" || (c.name === "lineTo" && corners.length)) corners.push(c.args);
    if (c.name === "closePath" && corners.length === 4) found.push(corners);
    if (["closePath", "beginPath"].includes(c.name)) corners = [];
    if (c.name === "fill" && c.fillStyle === LIGHT.steel) disc = found.length;
  }
  const whole = { about: ABOUT, low: 0, high: 20 }, scale = own.scale(whole);
  return { found, disc, scale, ground: own.ground(whole, 480, scale) };
}

test("in perspective the far half of a film is drawn first, the near half last, and the disc over what it covers", () => {
  for (const height of [10, -10]) {
    const { found, disc } = faces({ height, low: -20 }), half = found.length / 2, up = (part) => part.flat().reduce((sum, [, y]) => sum + y, 0) / part.length;
    assert.ok(half > 10 && up(found.slice(0, half)) < up(found.slice(half)), `${height}`);
    assert.equal(disc, height < 0 ? half : found.length);
  }
});

test("in perspective the rings of a membrane are at their radii and heights", () => {
  const shape = [8, 11, 14, 20, 30].map((radius, k) => ({ radius, rise: [1, 0.7, 0.4, 0.1, 0][k], stretch: 1 + 0.1 * k, wrinkled: false }));
  const { found, scale, ground } = faces({ height: 10, shapes: [shape, null], thin: [1, NaN], field: [0, 0] });
  const near = found.slice(found.length / 2, found.length / 2 + 2), middle = near[0][0][0] - 30 * scale, drawn = near.map(([[x, y]]) => [x, y]);
  const up = (ground - drawn[1][1]) / (10 * 0.4 * scale); // how much of a height is seen
  assert.ok(up > 0.5 && up < 1);
  assert.ok(close(drawn, [[middle + 30 * scale, ground], [middle + 14 * scale, ground - 4 * scale * up]]));
  assert.ok(close([near[1][3]], [[middle + 8 * scale, ground - 10 * scale * up]]));
});

test("the plane of a second film stays in the picture, wherever it is", () => {
  for (const second of [80, 15, -15, -80]) {
    const { own } = cone([{ about: { ...ABOUT, second } }]), whole = { about: { ...ABOUT, second }, low: 0, high: 20 }, scale = own.scale(whole), ground = own.ground(whole, 480, scale);
    for (const z of [0, 20, second]) assert.ok(ground - z * scale > 0 && ground - z * scale < 480, `${second}: ${z}`);
  }
});

test("what acts on the disc is drawn, and nothing else", () => {
  const count = (bias) => cone([{ about: { ...ABOUT, bias } }]).g.calls.filter((c) => c.strokeStyle === LIGHT.edge && c.name === "lineTo").length;
  const none = count("none");
  assert.deepEqual(["spring", "weight", "force", "beam"].map((bias) => count(bias) - none), [19, 1, 3, 41]);
  assert.equal(count("spring+weight") - none, 20);
});

test("what acts on the disc is where it acts: a weight hangs from it, a force pushes it up, a beam is clamped at the sides and holds its middle", () => {
  for (const height of [10, 20]) {
    const acting = (bias) => {
      const { own, g } = cone([{ about: { ...ABOUT, bias }, height }]), side = { about: ABOUT, low: 0, high: 20 }, scale = own.scale(side);
      const calls = g.calls.filter((c) => c.strokeStyle === LIGHT.edge && c.fillStyle === LIGHT.edge);
      return { points: calls.filter((c) => ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args), blocks: calls.filter((c) => c.name === "roundRect").map((c) => c.args), disc: own.ground(side, 480, scale) - height * scale, wide: 30 * scale };
    };
    const weight = acting("weight"), force = acting("force"), beam = acting("beam"), spring = acting("spring"), middle = (640 - 46) / 4;
    const [[x, y, w]] = weight.blocks, ends = weight.points.map(([, py]) => py);
    assert.ok(near(x + w / 2, middle) && near(Math.min(...ends), weight.disc) && near(Math.max(...ends), y) && y > weight.disc);
    const [tail, tip, left, again, right] = force.points; // the barbs are on the side of the tail
    assert.ok(tip[1] < tail[1] && tip[1] > force.disc && close([tip], [again]) && near(tip[0], middle));
    assert.ok(left[0] < tip[0] && right[0] > tip[0] && [left, right].every(([, py]) => py > tip[1] && py < tail[1]));
    const base = Math.max(...spring.points.map(([, py]) => py)), shape = beam.points;
    assert.ok(near(Math.min(...spring.points.map(([, py]) => py)), spring.disc) && base > spring.disc);
    assert.ok(close([shape[0], shape[20], shape[40]], [[middle - beam.wide, base], [middle, beam.disc], [middle + beam.wide, base]]));
    assert.ok(near(shape[1][1] - shape[0][1], 0, 1) && near(shape[19][1], shape[20][1], 0.01)); // flat where it is clamped and held
  }
});

test("texts of the cone stay in the picture, also while the disc is pulled beyond it", () => {
  for (const height of [-400, -20, 0, 20, 400]) {
    const all = boxes(cone([{ height, heightText: `${height} mm`, bias: "spring" }]).g);
    assert.deepEqual([all.length, all.filter(([, left, top, right]) => left < 0 || top < 0 || right > 640)], [3, []], `${height}`);
  }
});

test("the rims are held at the films' planes, and the disc is as wide as the film leaves it", () => {
  for (const second of [null, 15]) {
    const about = { ...ABOUT, second, bias: "none" }, { own, g } = cone([{ about, height: 10 }]), side = { about, low: 0, high: 20 };
    const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
    const blocks = g.calls.filter((c) => c.name === "roundRect" && [LIGHT.steel, LIGHT.edge].includes(c.fillStyle)).map(({ args: [x, y, w, h] }) => [x, x + w, y + h / 2]);
    const held = [[-1, 0], [1, 0], ...(second === null ? [] : [[-1, second], [1, second]])];
    for (const [sign, z] of held) assert.equal(blocks.filter(([left, right, y]) => left <= middle + sign * 30 * scale && right >= middle + sign * 30 * scale && near(y, ground - z * scale)).length, 1, `${sign} ${z}`);
    const [disc] = blocks.filter(([left, right]) => left < middle && right > middle);
    assert.ok(near((disc[0] + disc[1]) / 2, middle) && Math.abs(disc[1] - disc[0] - 2 * 8 * scale) < 8 && near(disc[2], ground - 10 * scale));
    assert.equal(blocks.length, held.length + 1);
  }
});

test("the trail fades with age", () => {
  const ages = cone([{ trail: [9, 8, 7, 6] }]).g.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.accent && c.args[3] === 2).map((c) => c.globalAlpha);
  assert.ok(ages.length === 4 && ages.every((alpha, k) => alpha > 0 && alpha < 1 && (!k || alpha < ages[k - 1])));
});

test("two settings stand side by side, named and in their colours", () => {
  const { g } = cone([{ heightText: "one" }, { heightText: "two", films: [4, 0] }]);
  const names = g.calls.filter((c) => c.name === "fillText" && ["A", "B"].includes(c.args[0]));
  assert.deepEqual(names.map((c) => [c.args[0], c.fillStyle]), [["A", LIGHT.a], ["B", LIGHT.b]]);
  const [[ax], [bx]] = names.map((c) => [c.args[1] + c.shift[0]]);
  assert.deepEqual([ax, bx], [160, 480]);
  const apart = texts(cone([{ name: "pump" }, { name: "soft film" }]).g);
  assert.ok(apart.includes("A pump, in its own scale") && apart.includes("B soft film, in its own scale"));
  assert.ok(texts(g).includes("one, 500 V") && texts(g).includes("two, 500 V"));
});

test("in perspective the upper of two films is seen through, and the lower is not, whichever is the second", () => {
  for (const second of [15, -15]) {
    const { g } = cone([{ about: { ...ABOUT, second }, films: [0, 4], height: second / 2 }, {}]), calls = g.calls.slice(0, g.calls.findIndex((c) => c.name === "restore"));
    const order = calls.filter((c) => c.name === "fill" && c.lineWidth === 0.7).map((c) => c.globalAlpha);
    assert.ok(order[0] === 1 && order.at(-1) < 1 && order.at(-1) > 0.4, `${second}: ${order.at(-1)}`);
  }
});

test("a second film is flat where its plane is, in its own colour", () => {
  const { own, g } = cone([{ about: { ...ABOUT, second: 15 }, films: [0, 4], height: 10 }]), side = { about: { ...ABOUT, second: 15 }, low: 0, high: 20 };
  const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
  const lines = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[4] && c.lineWidth > 2).map((c) => c.args);
  assert.ok(lines.some((at) => close([at], [[middle + 30 * scale, ground - 15 * scale]])));
  assert.ok(lines.some((at) => close([at], [[middle + 8 * scale, ground - 10 * scale]])));
});

test("a film is drawn thinner where it is thinner, and brighter the stronger its field", () => {
  const line = (more) => cone([{ films: [0, 0], ...more }]).g.calls.find((c) => c.name === "lineTo" && c.lineCap === "round");
  const [usual, thin, dull, bright] = [line({}), line({ thin: [0.5], field: [0] }), line({ thin: [1], field: [0] }), line({ thin: [1], field: [1] })];
  assert.ok(near(thin.lineWidth, 0.5 * usual.lineWidth) && near(dull.lineWidth, usual.lineWidth));
  const light = ({ strokeStyle }) => [1, 3, 5].reduce((sum, k) => sum + parseInt(strokeStyle.slice(k, k + 2), 16), 0);
  assert.equal(dull.strokeStyle, LIGHT.taut);
  assert.ok(light(bright) > light(dull) + 100);
  assert.ok(near(line({ thin: [NaN], field: [NaN] }).lineWidth, usual.lineWidth));
});

test("a hand takes the disc and lets it go at its place, and the gauge; a frame of no size draws nothing wrong", () => {
  const done = [], { own } = cone([{ height: 10, trail: [9, 8] }]), { canvas } = own;
  own.hands = { disc: (height, settled) => done.push(["disc", height, settled]), volts: (share, settled) => done.push(["volts", share, settled]) };
  const [disc, gauge] = ["disc", "volts"].map((kind) => own.grips.find((grip) => grip.kind === kind));
  const put = (event, x, y, more = {}) => canvas[`on${event}`]({ type: event, clientX: x + 10, clientY: y + 20, pointerId: 1, ...more });
  const [x, y] = [(disc.box[0] + disc.box[2]) / 2, (disc.box[1] + disc.box[3]) / 2], scale = Math.abs(1 / (disc.value(1) - disc.value(0)));
  put("pointerdown", x, y + 3); put("pointermove", x, y + 4); put("pointermove", x, y + 3 - 5 * scale); put("pointerup", x, y + 3 - 6 * scale);
  assert.deepEqual(done.map(([kind, , settled]) => [kind, settled]), [["disc", false], ["disc", true]]); // not for a trembling hand
  assert.ok(near(done[0][1], 15, 1e-4) && near(done[1][1], 16, 1e-4));
  done.length = 0;
  put("pointerdown", x, y, { button: 2 }); put("pointermove", x, y - 50); put("pointerdown", 3, 3); put("pointermove", 3, 50); put("pointerup", 3, 50);
  assert.deepEqual(done, []);
  const quarter = 0.75 * gauge.box[1] + 0.25 * gauge.box[3]; // from the top of -1000 to 2000 V: 1250 V
  put("pointerdown", gauge.box[0] + 1, gauge.box[3]); put("pointermove", gauge.box[0], quarter); put("pointercancel", 0, 0);
  assert.deepEqual(done.map(([kind, share, settled]) => [kind, Number(share.toFixed(6)), settled]), [["volts", 0.625, false], ["volts", 0.625, true]]);
  done.length = 0; // below zero volts no voltage changes its sign
  put("pointerdown", gauge.box[0] + 1, quarter); put("pointermove", gauge.box[0], gauge.box[3]); put("pointerup", gauge.box[0], gauge.box[3]);
  assert.deepEqual(done, [["volts", 0, false], ["volts", 0, true]]);
  assert.ok(own.held === null);
  own.w = 20;
  own.draw([{ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [0, 100], voltage: 50, heightText: "", voltageText: "" }]);
  assert.ok(own.context.calls.filter((c) => c.name === "ellipse").every(({ args: [, , across, up] }) => across >= 0 && up >= 0));
});
