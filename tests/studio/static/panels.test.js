// The plots of a look: each quantity at its place, in its colour.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, boxes, browser, drawn as styled, forget, near, overlapping, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { timePanel, portraitPanel, spectrumPanel, staticsPanel } = await from("panels");
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
const ORBIT = { ox: Float32Array.of(1, 2, 1, 0, 1), ou: Float32Array.of(0.5, 0, -0.5, 0, 0.5), px: Float32Array.of(1), pu: Float32Array.of(0.5), wanders: false };
const strokes = (p, faint) => p.context.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.a && (c.globalAlpha < 0.5) === faint).map((c) => c.args);

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
  assert.ok(near(below.context.calls.find((c) => c.name === "fillRect" && near(c.globalAlpha, 0.12)).args[2], below.X(700) - below.X(200)));
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

const STATICS = { voltage: Float32Array.of(0, 900), x: Float32Array.of(0, 4), stable: Uint8Array.of(1, 0), marks: { pitchfork: 880, pull_in: 900 }, swing: [0, 100] };
const SPECTRUM = { frequency: Float32Array.of(0, 5, 10, 15), amplitude: Float32Array.of(1, 0.01, 1, 0.0001), line: Float32Array.of(10), height: Float32Array.of(1), top: 80 };
const FULL = { ...ORBIT, statics: STATICS, spectrum: SPECTRUM };

test("of two settings each line, area and sign has its own look, one over the other in this order", () => {
  const a = look({ ...FULL, extent: [1, 3], words: { ended: "pulled in", period: 20, shares: [] } }), b = look({ ...FULL, wanders: true });
  const rows = [
    [timePanel, ["box panel", "line line 1", "time (ms) | soft 11px center bottom", "voltage (V) | soft 11px center middle", "line a 1 at 0.85", "line b 1 dashed 12,2 at 0.85", "line line 1", "height (mm) | soft 11px center middle", "line a 1.3 at 0.8", "line b 1.3 dashed 12,2 at 0.8", "box taut", "line breakdown 2.5", "pulled in | breakdown 600 11px right middle"]],
    [portraitPanel, ["box panel", "line line 1", "height (mm) | soft 11px center bottom", "velocity (m/s) | soft 11px center middle", "line a 0.8 at 0.3", "line b 0.8 at 0.3", "line a 1.8", "line b 0.8 dashed 7,3 at 0.6", "area a", "box b", "line breakdown 2.5", "pulled in | breakdown 600 11px left middle"]],
    [spectrumPanel, ["box panel", "line line 1", "frequency (Hz) | soft 11px center bottom", "amplitude (mm) | soft 11px center middle", "area a at 0.35", "line a 1", "area a", "area b at 0.35", "line b 1", "box b"]],
    [staticsPanel, ["box panel", "line line 1", "constant voltage (V) | soft 11px center bottom", "height (mm) | soft 11px center middle", "box a at 0.12", "the settled motion | soft 11px left middle", "line a 1.4 dashed 5,4", "line a 2",
      ...["a", "b"].flatMap((side) => [...(side === "b" ? ["line b 1.4 dashed 5,4", "line b 2"] : []), "line edge 1 dashed 2,3", "pitchfork | soft 11px right middle", "line edge 1 dashed 2,3", "pull-in of the cone | soft 11px right middle"])]],
  ];
  for (const [make, found] of rows) assert.deepEqual(styled(panel(make, { a, b }).context), found, make.name);
});

test("one setting alone has whole lines in full colour, and its points in that of the other; what is of an older one is pale", () => {
  assert.deepEqual(styled(panel(timePanel, { a: look(FULL) }).context).filter((one) => one.startsWith("line a")), ["line a 1 at 0.85", "line a 1.3"]);
  for (const [more, motion, found] of [[{}, "settled", ["line a 0.8 at 0.3", "line a 1.8", "area b"]], [{ wanders: true }, "settled", ["line a 0.8 at 0.3", "line a 0.8 at 0.6", "box b"]], [{ old: true }, "settled", ["line a 0.8 at 0.3", "line a 1.8 at 0.4", "area b at 0.4"]], [{}, "start", ["line a 0.8 at 0.6"]]]) {
    assert.deepEqual(styled(panel(portraitPanel, { a: look({ ...FULL, ...more }), motion }).context).filter((one) => /^(line|box|area) [ab]\b/.test(one)), found);
  }
  const long = look({ x: new Float32Array(3001).fill(1), u: new Float32Array(3001).fill(1) });
  assert.ok(styled(panel(portraitPanel, { a: long }).context).includes("line a 0.8 at 0.4")); // a long run is paler
});

test("the texts over two settings' equilibria lie side by side, however alike these are", () => {
  const p = panel(staticsPanel, { a: look({ ...FULL, extent: [1, 3] }), b: look({ ...FULL, extent: [1, 3] }) }), all = boxes(p.context);
  assert.deepEqual(overlapping(all), []);
  assert.deepEqual(["pull-in of the cone", "pitchfork", "the settled motion"].map((text) => all.filter(([own]) => own === text).length), [2, 2, 1]);
});

test("each axis has the room that its plot says: six decades, limits with 15 %, four tenths about a settled motion", () => {
  const range = (low, high) => [low - 0.08 * (high - low), high + 0.08 * (high - low)], same = (own, [low, high]) => assert.ok(near(own[0], low, 1e-6) && near(own[1], high, 1e-6), `${own} ${low} ${high}`);
  same(panel(spectrumPanel, { a: look({ spectrum: SPECTRUM }) }).y, range(-6, 0));
  const statics = panel(staticsPanel, { a: look({ statics: { ...STATICS, swing: [0, -1000] } }) });
  same(statics.x, range(0, 1150)); same(statics.y, range(0, 4));
  const p = panel(portraitPanel, { a: look({ ...ORBIT, x: Float32Array.of(0, 200, -200, 0, 0), u: Float32Array.of(0, 9, -9, 0, 0) }) });
  same(p.x, range(-0.8, 2.8)); same(p.y, range(-0.9, 0.9));
  const time = panel(timePanel, { a: look() });
  assert.ok(near(time.top, 6) && near(time.bottom, 6 + (1 - 0.27 - 0.06) * 440));
});

test("of a long run the portrait draws 20000 samples alone, and 6000 behind its settled motion", () => {
  const long = { x: new Float32Array(20001).fill(2), u: new Float32Array(20001).fill(1) }, count = (more, faint) => strokes(panel(portraitPanel, { a: look({ ...long, ...more }) }), faint).length;
  assert.deepEqual([count({}, true), count(ORBIT, true)], [20000, 6000]);
});

test("where one of two settings ends and neither has a spectrum, it is said why, and of one that is not there that it is awaited", () => {
  const ended = look({ words: { ended: "pulled in", period: 20, shares: [] } }), said = (looks) => texts(panel(spectrumPanel, looks).context).join(" ");
  for (const looks of [{ a: ended, b: look() }, { a: look(), b: ended }, { a: ended }]) assert.equal(said(looks), "A motion that ends has no spectrum.");
  assert.equal(said({ a: look() }), "No spectrum yet: it is being computed, or the actuator stands still.");
});

test("each text over a plot stands at its place: names at the lines and curves that they are of, remarks in the corner", () => {
  const at = (p, text) => p.context.calls.filter((c) => c.name === "fillText" && c.args[0].startsWith(text)).map((c) => [c.args[1], c.args[2], c.textAlign]), measured = ["one.csv", "two.csv"].map((name) => ({ name, over: "time", from: "height", along: Float64Array.of(0, 20), values: Float64Array.of(1, 2), volts: null, low: null, high: null }));
  const time = panel(timePanel, { a: look({ words: { ended: "", period: 20, shares: [], cut: true, shown: 3 } }), measured });
  assert.deepEqual([at(time, "only the first"), at(time, "one.csv"), at(time, "two.csv")], [[[56 + 6, 6 + 9, "left"]], [[620 - 6, time.bottom - 8, "right"]], [[620 - 6, time.bottom - 22, "right"]]]);
  const statics = panel(staticsPanel, { a: look({ ...FULL, extent: [1, 3] }) });
  assert.deepEqual([at(statics, "the settled"), at(statics, "pitchfork"), at(statics, "pull-in")], [[[statics.X(0) + 5, statics.Y(3) + 9, "left"]], [[statics.X(880) - 4, 8 + 9, "right"]], [[statics.X(900) - 4, 8 + 23, "right"]]]);
  const long = panel(portraitPanel, { a: look({ x: new Float32Array(20001).fill(2), u: new Float32Array(20001).fill(1) }) });
  assert.deepEqual(at(long, "only the beginning"), [[62, 17, "left"]]);
  for (const [own, by, align] of [[0, 10, "left"], [4, -10, "right"]]) { const p = panel(portraitPanel, { a: look({ words: { ended: "pulled in", period: 20, shares: [] }, x: Float32Array.of(0, 2, 4, 2, own) }) }); assert.deepEqual(at(p, "pulled in"), [[p.X(own) + by, p.Y(1), align]]); }
  for (const [make, more] of [[spectrumPanel, {}], [staticsPanel, {}]]) { const p = panel(make, { a: look(more) }), said = p.context.calls.filter((c) => c.name === "fillText"); assert.ok(said.every((c) => c.args[1] === 320 && c.textAlign === "center") && near(said.reduce((sum, c) => sum + c.args[2], 0) / said.length, 240)); }
});

test("of two settings each is drawn as soon as it has what is shown, whether or not the other has", () => {
  for (const [make, name] of [[spectrumPanel, "spectrum"], [staticsPanel, "statics"]]) for (const [one, other] of [["a", "b"], ["b", "a"]]) {
    const p = panel(make, { [one]: look(FULL), [other]: look({ ...FULL, [name]: undefined }) });
    assert.ok(drawn(p, LIGHT[one]).length > 0 && drawn(p, LIGHT[other]).length === 0, `${make.name} ${one}`);
  }
});

test("a plot has the lines, texts and marks of what it is given, whatever it has drawn before", () => {
  const scene = { t: Float32Array.of(0, 20), x: Float32Array.of(7, 9), u: Float32Array.of(0, 0), v: Float32Array.of(1, 1), film: Uint8Array.of(0, 0) }, ended = { ended: "pulled in", period: 20, shares: [] };
  const curve = { name: "m.csv", over: "time", from: "height", along: Float64Array.of(0, 9), values: Float64Array.of(1, 2), volts: null, low: null, high: null };
  const states = [{ a: look() }, { a: look({ ...FULL, settled: scene }), motion: "settled" }, { a: look({ ...FULL, settled: scene }), motion: "start" }, { a: look(FULL), b: look({ ...FULL, wanders: true }), active: "b" }, { a: look({ words: ended }) }, { a: look({ problem: "no equilibria", unmeasured: "no spectrum" }) }, { a: look({ ...FULL, old: true }) }, { b: look(FULL), active: "b" }, { a: look(FULL), measured: [curve, { ...curve, over: "voltage" }] }];
  for (const make of [timePanel, portraitPanel, spectrumPanel, staticsPanel]) {
    const looks = { active: "a", a: look(FULL) }, own = make(document.createElement("div"), looks, at(10, NOW)), seen = (p) => [styled(p.context), [...p.marks].filter(([, mark]) => !mark.hidden).map(([name]) => name).sort(), Boolean(p.x) && p.logarithmic];
    for (const state of [...states, ...states.toReversed()]) {
      for (const name of ["a", "b", "motion", "measured"]) delete looks[name];
      Object.assign(looks, { active: "a" }, state);
      forget(own.context); own.redraw();
      assert.deepEqual(seen(own), seen(panel(make, state)), `${make.name} ${JSON.stringify(Object.keys(state))}`);
    }
  }
});

test("where a plot says why it is empty, no place is read and none is marked", () => {
  const looks = { active: "a", a: look(FULL) }, pointer = { clientX: 300, clientY: 200 };
  for (const make of [spectrumPanel, staticsPanel]) {
    const p = panel(make, looks), read = () => { p.read(pointer); return !p.reading.hidden; };
    assert.equal(read(), true);
    Object.assign(looks.a, { spectrum: undefined, statics: undefined }); p.redraw();
    assert.deepEqual([p.reading.hidden, read(), [...p.marks.values()].every((mark) => mark.hidden)], [true, false, true], make.name);
    Object.assign(looks.a, FULL); p.redraw();
    assert.equal(read(), true);
  }
});
