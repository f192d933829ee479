// Tables over what is written, read, asked for and said: each row a case, each with its opposite.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, Memory, browser, near, texts, wait } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const [{ read, write }, { Clock }, { format, plain, typeset }, { extent, ticks, Plot }] = [await from("address"), await from("clock"), await from("controls"), await from("plot")];
const { LARGEST, readMeasured } = await from("measured"), { newAddress, tokenOf } = await from("link"), { GridPanels } = await from("grids"), { placeAt, heightAt } = await from("scene");
const { Badge } = await from("badge"), { Saver } = await from("save"), { arranged, caption } = await from("film"), { kindOf, labelled, fill, holding, PULLED_IN, IMPOSSIBLE, Panel } = await from("work"), { add, profile } = await from("profiles");
const $ = (id) => document.getElementById(id);

test("every part of the address has its usual value and its others, and is written only where it is another", () => {
  const parts = { periods: ["20", "5", "60", "200"], top: ["time", "spectrum"], left: ["portrait", "statics"], right: ["map", "strip", "envelope"], view: ["kind", "exponent", "stroke"], motion: ["settled", "start"] };
  for (const [name, values] of Object.entries(parts)) for (const value of values) {
    const state = read(`#device=pump&${name}=${value}`, "first"), usual = value === values[0];
    assert.deepEqual([state[name], state.odd, write(state)], [value, [], usual ? "device=pump" : `device=pump&${name}=${value}`]);
    for (const other of Object.keys(parts)) if (other !== name) assert.equal(state[other], parts[other][0]);
    const odd = read(`#device=pump&${name}=${value}x`, "first");
    assert.deepEqual([odd[name], odd.odd.length], [values[0], 1]);
    assert.match(odd.odd[0], new RegExp(`^${name} = ${value}x: is not one of ${values.join(", ")}; ${values[0]} is shown.$`));
  }
});

test("subjects, values, sides, axes and locks of an address", () => {
  const rows = [
    ["device=pump&film=taut&b.preset=base&b.voltage=2&side=b", { a: ["pump", null, { film: "taut" }], b: [null, "base", { voltage: "2" }], side: "b" }],
    ["preset=base&device=pump", { a: ["pump", null, {}], b: null, side: "a" }],
    ["device=pump&preset=base", { a: [null, "base", {}], b: null, side: "a" }],
    ["side=b", { a: ["first", null, {}], b: null, side: "a" }],
    ["b.voltage=3", { a: ["first", null, {}], b: ["first", null, { voltage: "3" }], side: "a" }],
    ["b.device=pump&side=c", { a: ["first", null, {}], b: ["pump", null, {}], side: "a" }],
  ];
  for (const [text, { a, b, side }] of rows) {
    const state = read(text, "first"), own = (s) => s && [s.device, s.preset, s.values];
    assert.deepEqual([own(state.a), own(state.b), state.side], [a, b, side], text);
    assert.deepEqual(read(write(state), "first"), state, text);
  }
  for (const name of ["x", "y", "over"]) {
    for (const [text, found] of [["voltage,0,2", ["voltage", 0, 2]], ["voltage,-1,2.5", ["voltage", -1, 2.5]], ["voltage,2,2", null], ["voltage,2,1", null], ["voltage,1", null], ["voltage,a,2", null], ["voltage,0,Infinity", null], ["voltage,,2", null]]) {
      const state = read(`${name}=${text}`, "first");
      assert.deepEqual([state[name], state.odd.length], [found, found ? 0 : 1], `${name}=${text}`);
      for (const other of ["x", "y", "over"]) if (other !== name) assert.equal(state[other], null);
    }
  }
  const many = Array.from({ length: 70 }, (_, k) => `p${k}`);
  assert.deepEqual(read(`locked=${many.join()}`, "").locked, many.slice(0, 60));
  assert.deepEqual(read("locked=a,,b,a", "").locked, ["a", "b"]);
});

test("numbers as they are written", () => {
  for (const [value, digits, text] of [[1234.56, 4, "1235"], [0.00012345, 3, "0.000123"], [0.00009, 2, "9e-5"], [999999, 6, "999999"], [1e6, 4, "1e+6"], [-1e6, 4, "-1e+6"], [0, 4, "0"], [NaN, 4, ""], [Infinity, 4, ""], [-0.5, 4, "-0.5"], [0.0001, 4, "0.0001"]]) assert.equal(format(value, digits), text, value);
  assert.equal(format(1.23456), "1.235");
  for (const [text, shown] of [["-5 um", "−5 µm"], ["3 N/m^3", "3 N/m³"], ["2 m/s^2", "2 m/s²"], ["quasi-periodic", "quasi-periodic"], ["1.5uC", "1.5µC"]]) {
    assert.equal(typeset(text), shown);
    assert.equal(plain(shown), text);
  }
  assert.equal(plain("1\u00a0V –2"), "1 V -2");
});

test("ticks are multiples of 1, 2 or 5 within their range, few enough, with the digits that they need", () => {
  for (const [low, high, most, found] of [
    [0, 10, 5, ["0", "2", "4", "6", "8", "10"]], [0, 1, 4, ["0.0", "0.5", "1.0"]], [-1, 1, 4, ["−1.0", "−0.5", "0.0", "0.5", "1.0"]], [0, 100, 10, ["0", "10", "20", "30", "40", "50", "60", "70", "80", "90", "100"]],
    [3, 3.05, 2, ["3.00", "3.05"]], [0, 0.0002, 2, ["0", "1e−4", "2e−4"]], [0, 300000, 3, ["0", "1.0e+5", "2.0e+5", "3.0e+5"]],
  ]) assert.deepEqual(ticks(low, high, most).map(([, text]) => text), found, `${low} ${high}`);
  for (const [v, text] of ticks(-3.3, 7.1, 6)) assert.ok(v >= -3.3 && v <= 7.1 && near(Number(plain(text)), v, 1e-9));
  assert.deepEqual([extent([3, NaN, 1], [], [7]), extent([])], [[1, 7], [Infinity, -Infinity]]);
});

// --- the player ------------------------------------------------------------------------------------------------------

const run = (end, more = {}) => ({ t: Float32Array.of(0, end / 2, end), x: Float32Array.of(0, 2, 4), u: Float32Array.of(0, 1, 0), v: Float32Array.of(0, 5, 9), film: Uint8Array.of(0, 1, 2), words: { period: 20, ended: "" }, about: { si: true }, ...more });
function clockOf(looks) { browser(); return new Clock({ play: $("play"), scrub: $("scrub"), output: $("clock"), speed: $("speed") }, looks); }

test("the time is in milliseconds up to two seconds, then in seconds, and a number without units", () => {
  for (const [end, at, si, text] of [[40, 30, true, "30 ms"], [1999, 1000, true, "1000 ms"], [2000, 1500, true, "1.50 s"], [9000, 4321, true, "4.32 s"], [40, 12.345, false, "time 12.3"], [9000, 4321, false, "time 4320"]]) {
    const own = clockOf({ a: run(end, { about: { si } }) });
    own.at = at; own.playing = false; own.write(1e6);
    assert.deepEqual([own.output.textContent, own.scrub.getAttribute("aria-valuetext"), Number(own.scrub.value)], [text, text, (1000 * at) / end]);
  }
});

test("while it plays the text changes at most every 120 ms, while it stands always", () => {
  const own = clockOf({ a: run(40) });
  own.playing = true; own.at = 10; own.write(1000);
  own.at = 20; own.write(1119);
  assert.equal(own.output.textContent, "10 ms");
  own.write(1120);
  assert.equal(own.output.textContent, "20 ms");
  own.playing = false; own.at = 30; own.write(1121);
  assert.equal(own.output.textContent, "30 ms");
});

test("a run that ends is held at its end, another begins anew; the longer of two settings counts", () => {
  for (const [ended, at, playing] of [["pulled in", 40, false], ["", 5, true]]) {
    const own = clockOf({ a: run(40, { words: { period: 20, ended } }) });
    own.speeds(20, true); own.speed.value = "real"; own.tick(0);
    own.at = 40; own.tick(5);
    assert.deepEqual([own.at, own.playing], [at, playing]);
  }
  assert.deepEqual([clockOf({ a: run(40), b: run(60) }).length(), clockOf({ b: run(60) }).length(), clockOf({}).length()], [60, 60, 0]);
  const scene = { t: Float32Array.of(0, 10, 20), x: Float32Array.of(0, 2, 6) };
  for (const [time, k, f, x] of [[-1, 0, 0, 0], [0, 0, 0, 0], [5, 0, 0.5, 1], [10, 1, 0, 2], [15, 1, 0.5, 4], [20, 1, 1, 6], [99, 1, 1, 6]]) {
    assert.deepEqual(placeAt(scene, time), [k, f], `${time}`);
    assert.equal(heightAt(scene, time), x);
  }
});

// --- files -----------------------------------------------------------------------------------------------------------

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

// --- what is asked for -----------------------------------------------------------------------------------------------

test("a file is asked for with what it is of, in every format", () => {
  browser();
  const asked = [], state = { top: "time", periods: "60", x: ["frequency", 1, 2], y: ["voltage", 3, 4], over: ["voltage", 5, 6] };
  const page = { ask: (kind, content) => asked.push([kind, content]), state: () => state, setting: () => ({ device: "pump", preset: null }), shown: () => ({ look: null }) };
  const saver = new Saver(document.createElement("dialog"), page);
  const more = { map: { x: state.x, y: state.y }, bifurcation: { over: state.over } };
  assert.deepEqual(saver.what.options.map((o) => o.value), ["simulate", "section", "spectrum", "regime", "static", "map", "bifurcation", "envelope"]);
  for (const { value } of saver.what.options) {
    saver.what.value = value;
    const content = { setting: { device: "pump", preset: null }, what: value, options: value === "simulate" ? { periods: 60 } : {}, ...(more[value] ?? {}) };
    saver.ask();
    assert.deepEqual(asked.pop(), ["code", content]);
    for (const button of saver.buttons) { button.click(); assert.deepEqual(asked.pop(), ["export", { ...content, format: button.getAttribute("data-format") }]); }
  }
  assert.deepEqual(saver.buttons.map((b) => [b.textContent, b.getAttribute("data-format"), b.disabled]), [["netCDF", "nc", true], ["PNG", "png", true], ["SVG", "svg", true]]);
  for (const [top, what] of [["time", "simulate"], ["spectrum", "spectrum"]]) { state.top = top; saver.show(); assert.equal(saver.what.value, what); }
  for (const preset of [null, "base"]) { page.setting = () => ({ device: null, preset }); saver.show(); assert.deepEqual([saver.device.disabled, saver.what.querySelector('[value="envelope"]').hidden], [Boolean(preset), Boolean(preset)]); }
  saver.id = 4; saver.codeId = 5;
  assert.deepEqual([saver.failed({ id: 3, message: "no" }), saver.failed({ id: 5, message: "odd" }), saver.status.textContent], [false, true, "odd"]);
});

test("each copy button copies the lines below it, and says whether the browser let it", async () => {
  browser();
  const saver = new Saver(document.createElement("dialog"), { ask: () => 1 }), copied = [];
  saver.message({ kind: "code", command: "gelcone simulate", python: "import gelcone" }, {});
  const parts = saver.dialog.parts, lines = parts.filter((e) => e.tagName === "pre");
  for (const [allowed, said] of [[true, "Copied."], [false, "Select the text and copy it."]]) for (const own of lines) {
    navigator.clipboard.writeText = async (text) => { if (!allowed) throw new Error("no"); copied.push(text); };
    await parts[parts.indexOf(own) - 1].querySelector("button").onclick();
    assert.equal(saver.status.textContent, said);
  }
  assert.deepEqual([copied, lines.map((own) => own.textContent)], [["gelcone simulate", "import gelcone"], ["gelcone simulate", "import gelcone"]]);
});

test("pictures and films of the page: the film's button waits for its film, and what cannot be had is said", async () => {
  browser();
  const looks = { words: { ended: "", seems: "seems to repeat" } }, picture = Object.assign(document.createElement("canvas"), { width: 300, height: 200 }), played = [], given = [];
  const page = { ask: () => 1, shown: () => ({ name: "pump", look: page.look, values: {} }), pictures: () => [picture, picture], play: () => played.push(1) };
  const saver = new Saver(document.createElement("dialog"), page), make = document.createElement;
  saver.give = (name, data) => { given.push([name, data]); saver.done(`${name} is saved.`); };
  for (const button of [saver.picture, saver.film]) { await button.onclick(); assert.equal(saver.status.textContent, "There is nothing to show yet."); }
  page.look = looks;
  await saver.film.onclick();
  assert.deepEqual([saver.status.textContent, Boolean(saver.film.disabled), played.length], ["This browser records no films.", false, 1]);
  const films = [];
  globalThis.MediaRecorder = class { static isTypeSupported() { return true; } constructor() { films.push(this); } start() {} };
  document.createElement = (tag) => Object.assign(make(tag), tag === "canvas" && { captureStream: () => ({}), toBlob: (does) => does(page.blob) });
  for (const ends of ["stop", "error"]) {
    const done = saver.film.onclick();
    assert.equal(saver.film.disabled, true);
    films.at(-1)[`on${ends}`]();
    await done;
    assert.deepEqual([saver.film.disabled, saver.status.textContent], [false, ends === "stop" ? "gelcone.webm is saved." : "the browser could not record the film"]);
  }
  for (const [blob, text] of [[new Blob(["x"]), "gelcone.png is saved."], [null, "The browser made no picture."]]) { page.blob = blob; saver.picture.onclick(); assert.equal(saver.status.textContent, text); }
  assert.deepEqual(given.map(([name]) => name), ["gelcone.webm", "gelcone.png"]);
  delete globalThis.MediaRecorder;
});

test("a file is handed over under its name, with the type of its ending", async () => {
  browser();
  const saver = new Saver(document.createElement("dialog"), { ask: () => 3, state: () => ({}), setting: () => ({}) }), given = [];
  saver.give = (name, data) => given.push([name, data]);
  for (const name of ["pump.nc", "map.2.png", "map.svg", "pump.toml"]) assert.equal(saver.message({ kind: "file", name }, { data: Uint8Array.of(1, 2, 3) }), true);
  assert.deepEqual(given.map(([name, data]) => [name, data.type]), [["pump.nc", "application/x-netcdf"], ["map.2.png", "image/png"], ["map.svg", "image/svg+xml"], ["pump.toml", "application/toml"]]);
  assert.deepEqual([...new Uint8Array(await given[0][1].arrayBuffer())], [1, 2, 3]);
  assert.equal(saver.message({ kind: "look" }, {}), false);
  const { createObjectURL, revokeObjectURL } = URL, urls = [], links = [], make = document.createElement;
  URL.createObjectURL = (data) => { urls.push(data); return `blob:${urls.length}`; }; URL.revokeObjectURL = (url) => urls.push(url);
  document.createElement = (tag) => Object.assign(make(tag), { onclick() { links.push([this.href, this.download, urls.length]); } });
  Saver.prototype.give.call(saver, "pump.nc", "data");
  Object.assign(document, { createElement: make });
  assert.deepEqual([links, urls, saver.status.textContent, document.body.querySelectorAll("a").length], [[["blob:1", "pump.nc", 1]], ["data"], "pump.nc is saved.", 0]);
  wait(10000); // a browser reads the address after the click
  assert.deepEqual(urls, ["data", "blob:1"]);
  Object.assign(URL, { createObjectURL, revokeObjectURL });
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
  grids.applied(false);
  assert.deepEqual(Object.values(grids.panels).map((p) => p.stale), [false, false, false]);
  grids.applied(true);
  assert.deepEqual(Object.values(grids.panels).map((p) => p.stale), [true, true, true]);
  grids.lost();
  assert.deepEqual(Object.values(grids.panels).map((p) => [p.running, p.stale]), [[false, true], [false, true], [false, true]]);
});

test("kinds, labels and choices of panels", () => {
  const legend = { regimes: [{ name: "rest", colour: "#111111" }, { name: "periodic", colour: "#222222" }], pulled_in: { name: "pulled in", colour: "#333333" } };
  assert.deepEqual([kindOf(legend, 1).name, kindOf(legend, PULLED_IN).name, kindOf(legend, IMPOSSIBLE).colour, kindOf(legend, 9).name], ["periodic", "pulled in", LIGHT.line, undefined]);
  assert.deepEqual([labelled({ label: "Film Radius", unit: "mm" }), labelled({ label: "Ratio", unit: "" }), labelled(undefined)], ["film radius (mm)", "ratio", ""]);
  const select = document.createElement("select");
  fill(select, [{ kind: "choice", name: "film", label: "Film" }, { kind: "number", name: "a", label: "A" }, { kind: "number", name: "b", label: "B" }], "b");
  assert.deepEqual([select.options.map((o) => [o.value, o.textContent]), select.value], [[["a", "A"], ["b", "B"]], "b"]);
  const canvas = document.createElement("canvas"), seen = [];
  holding(canvas, (event, settled) => seen.push([event.at, settled]));
  for (const [name, event] of [["move", { at: 0 }], ["down", { at: 1, button: 2 }], ["move", { at: 2 }], ["down", { at: 3, button: 0, isPrimary: false }], ["down", { at: 4, button: 0 }], ["move", { at: 5 }], ["move", { at: 6, isPrimary: false }], ["up", { at: 7 }], ["move", { at: 8 }], ["up", { at: 9 }], ["down", { at: 10, button: 0 }], ["cancel", { at: 11 }]]) canvas[`onpointer${name}`](event);
  assert.deepEqual(seen, [[4, false], [5, false], [7, true], [10, false], [10, true]]);
  const said = [], own = new Panel({ say: (text) => said.push(text), page: { controls: () => ({ list: [{ name: "a", unit: "mm" }, { name: "b", unit: "" }], value: () => 3 }), setting: () => ({ values: {} }) } }, "map");
  for (const share of [0, 0.256, 0.999, 1]) own.progress(share);
  assert.deepEqual([said, own.text("a", 1.23456), own.text("b", 2), own.value("a")], [["0 %", "26 %", "100 %", ""], "1.235 mm", "2", 3]);
});

// --- the connection, words, pictures ---------------------------------------------------------------------------------

test("tokens and addresses of a studio", () => {
  const memory = new Memory();
  assert.deepEqual([tokenOf("", () => memory), tokenOf("?token=one", () => memory), tokenOf("", () => memory), tokenOf("?token=two", () => { throw new Error("none"); }), tokenOf("", () => { throw new Error("none"); })], ["", "one", "one", "two", ""]);
  const here = { host: "127.0.0.1:8000", hostname: "127.0.0.1" };
  for (const [text, found] of [
    [" http://127.0.0.1:8000/?token=abc ", { token: "abc", elsewhere: null }], ["http://localhost:8001/?token=a%26b", { token: "a&b", elsewhere: "http://localhost:8001/?token=a%26b" }], ["http://[::1]:9/?token=x", { token: "x", elsewhere: "http://[::1]:9/?token=x" }],
    ["https://127.0.0.1:8000/?token=abc", null], ["http://127.0.0.1:8000/", null], ["http://evil.example/?token=abc", null], ["http://me@127.0.0.1:8000/?token=abc", null], ["nonsense", null],
  ]) assert.deepEqual(newAddress(text, here), found, text);
});

test("shares of the time in the badge, and differences between two settings", () => {
  browser();
  const film = ["taut", "hoop slack", "meridian slack", "slack in both directions", "above breakdown", "near its stretch limit"], own = new Badge($("badges"));
  const look = (more, about = {}) => ({ words: { shares: [], seems: "seems to repeat", ended: "", ...more }, about: { film, wrinkles: true, si: true, strength: true, ...about } });
  for (const [share, text] of [[0.004, "< 1 %"], [0.01, "1 %"], [0.344, "34 %"], [0.99, "99 %"], [0.9996, "all"]]) {
    own.show("a", look({ shares: [{ code: 2, share }] }), { regimes: [] });
    assert.equal(own.rows.get("a").valid.textContent, `the model holds: film meridian slack ${text} of the time (allowed for this film)`);
  }
  for (const code of [0, 1, 2, 3, 4, 5]) for (const wrinkles of [true, false]) {
    own.show("a", look({ shares: [{ code, share: 0.5 }] }, { wrinkles }), { regimes: [] });
    assert.equal(own.rows.get("a").valid.classList.has("yes"), code === 0 || (wrinkles && code < 4), `${code} ${wrinkles}`);
  }
  const numbers = (value) => new Map([["stroke", { name: "stroke", text: `${value} mm`, value, place: 1 }], ["lag", { name: "lag", text: "5°", value, place: 0 }]]);
  for (const [one, other, text] of [[6, 5, "+20 %"], [4, 5, "-20 %"], [5, 5, "+0 %"], [5.6, 5, "+12 %"], [-6, -5, "-20 %"], [5.05, 5, "+1 %"]]) {
    own.show("a", { ...look({}), numbers: numbers(one) }, { regimes: [] }, { about: { si: true }, words: {}, numbers: numbers(other) });
    assert.equal(plain(own.rows.get("a").numbers.textContent).split("seems")[0].split("the settled")[0].trim(), `lag 5°stroke ${one} mm (${text})`, `${one} ${other}`);
  }
  own.show("a", { ...look({}), numbers: numbers(6) }, { regimes: [] }, { about: { si: false }, words: {}, numbers: numbers(5) });
  assert.ok(!own.rows.get("a").numbers.textContent.includes("%"));
});

test("captions, and pictures in their places", () => {
  const numbers = new Map([["b", { name: "lag", text: "5°", place: 2 }], ["a", { name: "stroke", text: "3 mm", place: 1 }]]);
  for (const [words, lines, kind] of [[{ ended: "pulled in", seems: "s" }, ["chaotic"], "pulled in"], [{ ended: "", seems: "seems to repeat" }, ["periodic, period 2", "more"], "periodic, period 2"], [{ ended: "", seems: "seems to repeat" }, null, "seems to repeat"]]) {
    assert.deepEqual(caption("pump", { words, lines, numbers }, { film_thickness: "0.3 mm", film: "taut" }), [`pump: ${kind}`, "stroke 3 mm, lag 5°", "with film thickness 0.3 mm, film taut", "gelcone studio"]);
    assert.deepEqual(caption("pump", { words, lines }, {}), [`pump: ${kind}`, "gelcone studio"]);
  }
  assert.deepEqual(arranged([[100, 50], [200, 80], [60, 40]]), { places: [[0, 0], [116, 0], [0, 96]], size: [316, 152] });
});

test("profiles between heights and voltages, by hand", () => {
  const flat = (values) => Float32Array.from(values);
  add({ name: "made", shares: [0, 1], rings: 2 }, { height: flat([0, 10]), top: flat([100, 200]), radius: flat([1, 2, 3, 4, 5, 6, 7, 8]), rise: flat([0, 0, 0, 0, 1, 1, 1, 1]), stretch: flat([1, 1, 2, 2, 3, 3, 4, 4]), wrinkled: flat([0, 1, 0, 1, 1, 1, 1, 1]) });
  for (const [height, voltage, radius, rise, stretch, wrinkled] of [[0, 0, 1, 0, 1, false], [0, 100, 3, 0, 2, false], [10, 0, 5, 1, 3, true], [10, 200, 7, 1, 4, true], [5, 0, 3, 0.5, 2, false], [10, 100, 5.5, 1, 3.25, true], [-10, 0, 5, 1, 3, true]]) {
    const [first] = profile("made", height, voltage);
    assert.deepEqual([first.radius, first.rise, first.stretch, first.wrinkled], [radius, rise, stretch, wrinkled], `${height} ${voltage}`);
  }
  assert.deepEqual([profile("made", 0, 101), profile("other", 0, 0), profile("made", NaN, 0)], [null, null, null]);
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
