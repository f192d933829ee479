// The whole page, opened anew for each test: what every answer and every hand changes, and what stays.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test, { afterEach } from "node:test";
import { DARK, LIGHT, SELECTORS, SIZE, STATIC, Socket, browser, draw, drawn, everything, faults, forget, made, near, page, texts, wait } from "./page.js";

const { colours } = await import("../../../src/gelcone/studio/static/colours.js");
const HERTZ = { Hz: 0, kHz: 3 }, VOLTS = { V: 0, kV: 3 };
const CONTROLS = [
  { name: "frequency", label: "Frequency", group: "Drive", kind: "number", value: 10, unit: "Hz", low: 0.1, high: 20, powers: HERTZ, about: "", choices: [] },
  { name: "voltage_amplitude", label: "Voltage amplitude", group: "Drive", kind: "number", value: 800, unit: "V", low: 0, high: 1600, powers: VOLTS, about: "", choices: [] },
  { name: "disc_radius", label: "Disc radius", group: "Body", kind: "number", value: 8, unit: "mm", low: 1, high: 16, powers: { m: 0, mm: -3 }, about: "", choices: [] },
];
const AXES = { time: "time (ms)", displacement: "height (mm)", velocity: "velocity (m/s)", voltage: "voltage (V)", constant: "constant voltage (V)", frequency: "frequency (Hz)", amplitude: "amplitude (mm)" };
const ABOUT = { axes: AXES, si: true, disc: 8, rim: 30, second: null, bias: "none", film: ["taut", "hoop slack"], wrinkles: false, film_of: "cone", name: "biased pump", strength: true, doubts: [] };
const HELLO = { kind: "hello", id: 1, devices: ["biased-pump", "soft-film"], presets: { base: "the base set", other: "another set" }, regimes: [{ name: "rest", colour: "#777777" }, { name: "periodic", colour: "#0072b2" }], pulled_in: { name: "pulled in", colour: "#5b5b5b" } };
const RUN = (more = {}) => ({ t: Float32Array.of(0, 50, 100), x: Float32Array.of(10, 20, 10), u: Float32Array.of(0, 1, 0), v: Float32Array.of(200, 1234, 200), film: Uint8Array.of(0, 0, 0), ...more });
let moment = 0, opened = 0;
globalThis.performance.now = () => moment;

afterEach(() => assert.deepEqual(faults(), []));

// A page at an address, greeted by its server.
async function open(hash = "#device=biased-pump", greeted = true) {
  browser(hash);
  await import(`../../../src/gelcone/studio/static/main.js?${++opened}`);
  const [socket] = Socket.all, asked = (kind) => socket.sent.filter((sent) => sent.kind === kind), last = (kind) => asked(kind).at(-1);
  socket.open();
  if (greeted) socket.give(HELLO);
  const answer = (arrays = RUN(), about = {}, words = {}) => {
    const { id, side, controls } = last("look");
    if (controls) socket.give({ kind: "subject", id, side, controls: CONTROLS, words: {} });
    socket.give({ kind: "response", id, side, about: { ...ABOUT, ...about }, words: { seems: "seems to repeat", ended: "", period: 100, shares: [{ code: 0, share: 1 }], ...words } }, arrays);
  };
  const give = (kind, words = {}, arrays = {}, side = last("look").side) => socket.give({ kind, id: last("look").id, side, words }, arrays);
  return { $: (id) => document.getElementById(id), socket, asked, last, answer, give, studio: globalThis.studio };
}
const go = (scrub) => { const own = document.getElementById("scrub"); own.value = String(scrub); own.oninput(); };
const selected = (place) => document.querySelector(`.panel[data-place="${place}"]`).querySelectorAll('[role="tab"]').find((t) => t.getAttribute("aria-selected") === "true").dataset.tab;
const file = (name, text) => ({ name, size: text.length, text: async () => text });
const passed = () => new Promise((done) => setImmediate(done));

test("the list of subjects names what is shown from the first: what is opened, the devices, and the sets of the paper", async () => {
  for (const [hash, name] of [["#device=soft-film", "soft-film"], ["#preset=base", "base"], ["#file=a", "device file"]]) {
    const { $ } = await open(hash, false);
    assert.deepEqual($("subject").options.map((o) => o.textContent), [name]);
  }
  const groups = ($) => $("subject").querySelectorAll("optgroup").map((own) => [own.label, own.options.map((o) => [o.value, o.textContent])]);
  const shipped = [["Devices", [["device:biased-pump", "biased-pump"], ["device:soft-film", "soft-film"]]], ["Parameter sets of the paper", [["preset:base", "base"], ["preset:other", "other"]]]];
  for (const [hash, value, first] of [["#device=soft-film", "device:soft-film", []], ["#preset=other", "preset:other", []], ["#file=a", "file:", [["Opened", [["file:", "my pump"]]]]]]) {
    const { $, answer } = await open(hash);
    answer(RUN(), { name: "my pump" });
    assert.deepEqual([groups($), $("subject").value], [[...first, ...shipped], value]);
  }
});

test("files come by the button or are dropped, and a browser that is given a file does not leave the page", async () => {
  const { $, last } = await open(), prevented = [];
  let clicked = 0;
  $("file").onclick = () => { clicked += 1; };
  $("open").click();
  assert.equal(clicked, 1);
  const event = (types, files = []) => ({ dataTransfer: { types, files }, preventDefault: () => prevented.push(types[0]) });
  for (const types of [["Files"], ["text/plain"]]) page.listeners.dragover(event(types));
  assert.deepEqual(prevented, ["Files"]);
  page.listeners.drop(event(["Files"], [file("my.toml", "disc_radius = '1 mm'")]));
  await passed();
  assert.deepEqual([prevented, last("look").setting.file], [["Files", "Files"], "disc_radius = '1 mm'"]);
  page.listeners.drop(event(["text/plain"])); // a text goes into the field it is dropped on
  assert.equal(prevented.length, 2);
});

test("of several measured curves the last one opens its tab", async () => {
  const curves = { time: file("t.csv", "time (ms),height (mm)\n0,5\n1,6\n"), voltage: file("v.csv", "voltage (V),height (mm)\n0,5\n1,6\n") };
  for (const [order, top, left] of [[["time", "voltage"], "spectrum", "statics"], [["voltage", "time"], "time", "portrait"]]) {
    const { $, answer, studio } = await open("#device=biased-pump&top=spectrum");
    answer();
    studio.looks.measured = [];
    for (const over of order) {
      for (const tab of ["spectrum", "portrait"]) document.querySelector(`[data-tab="${tab}"]`).click(); // neither panel shows the curve
      $("file").files = [curves[over]];
      await $("file").onchange();
      await passed();
    }
    assert.deepEqual([selected("top"), selected("left")], [top, left]);
  }
});

test("a tab that a subject does not have gives way to the first, and what belongs to a tab is shown with it", async () => {
  for (const [hash, right] of [["#preset=base&right=envelope", "map"], ["#device=biased-pump&right=envelope", "envelope"], ["#preset=base&right=strip", "strip"]]) {
    const { answer } = await open(hash);
    answer();
    assert.equal(selected("right"), right, hash);
  }
  const { answer } = await open();
  answer();
  for (const tab of ["time", "spectrum", "time"]) {
    document.querySelector(`[data-tab="${tab}"]`).click();
    for (const part of document.querySelectorAll("[data-for]")) assert.equal(part.hidden, part.dataset.for !== tab, tab);
  }
});

test("doubts about a device stand below its controls, whole under the pointer, and go with it", async () => {
  const { $, answer } = await open();
  answer(RUN(), { doubts: ["film_thickness = 0.2 um: is thin", "1 m^2 is large"] });
  const text = "film_thickness = 0.2 µm: is thin; 1 m² is large";
  assert.deepEqual([$("subject-note").textContent, $("subject-note").title], [text, text]);
  document.querySelector('[data-tab="statics"]').click();
  answer();
  assert.deepEqual([$("subject-note").textContent, $("subject-note").title], ["", ""]);
});

test("speeds are factors of real time for a device, and seconds a period for a set without units", async () => {
  for (const [hash, si, some] of [["#device=biased-pump", true, ["20× slower", "real time"]], ["#preset=base", false, ["2 s a period"]]]) {
    const { $, answer } = await open(hash);
    answer(RUN(), { si });
    const names = $("speed").options.map((o) => o.textContent);
    assert.ok(some.every((name) => names.includes(name)) && names.includes("real time") === si, names.join());
  }
});

test("while an answer is awaited the cone stands, but not for evidence of an older setting", async () => {
  const { $, answer, give, last, socket } = await open(), kind = { regime: 1, lines: ["periodic, period 1"], extent: [9, 21] };
  answer();
  if ($("play").getAttribute("aria-label") === "Play") $("play").click();
  draw();
  const older = last("look").id;
  const moves = () => { wait(38); return page.frames.length > 0; };
  const slider = document.querySelector('[data-name="frequency"]').querySelectorAll("input")[1];
  slider.value = "300"; slider.oninput();
  draw(); // what was asked for before
  socket.give({ kind: "kind", id: older, side: "a", words: kind });
  draw();
  assert.equal(moves(), false);
  answer(); give("kind", kind); draw();
  assert.equal(moves(), true);
});

test("a page at rest asks for no pictures", async () => {
  const { $, answer } = await open();
  answer();
  moment += 1000; // nothing is awaited any more
  if ($("play").getAttribute("aria-label") === "Pause") $("play").click();
  for (let k = 0; k < 3; k++) { draw(); wait(500); }
  assert.equal(page.frames.length, 0);
  $("play").click();
  for (let k = 0; k < 3; k++) { draw(); wait(500); }
  assert.equal(page.frames.length, 1);
});

test("another parameter of the sweep or of the map is a step of the history and part of the link", async () => {
  const { answer, last } = await open("#device=biased-pump&right=strip"), begun = page.steps.length, written = (name) => new URLSearchParams(location.hash.slice(1)).get(name);
  answer();
  const [over] = document.getElementById("strip").querySelectorAll("select");
  over.value = "disc_radius"; over.onchange();
  assert.deepEqual([written("over"), page.steps.length - begun, last("strip").over], ["disc_radius,1,16", 1, ["disc_radius", 1, 16]]);
  document.querySelector('[data-tab="map"]').click();
  const [x] = document.getElementById("map").querySelectorAll("select");
  x.value = "disc_radius"; x.onchange();
  assert.deepEqual([written("x"), page.steps.length - begun, last("map").x], ["disc_radius,1,16", 3, ["disc_radius", 1, 16]]);
});

test("a slider that rested before it was released is one step of the history, to where it began", async () => {
  const { answer } = await open(), begun = page.steps.length, slider = () => document.querySelector('[data-name="frequency"]').querySelectorAll("input")[1];
  answer(); wait(300);
  slider().value = "300"; slider().oninput(); answer(); wait(300);
  assert.deepEqual([page.steps.length - begun, location.hash.includes("frequency=")], [0, true]);
  slider().onchange(); answer(); wait(300);
  assert.equal(page.steps.length - begun, 1);
  slider().value = "400"; slider().onchange(); slide("voltage_amplitude", 100); answer(); wait(300); // both are answered at once
  assert.equal(page.steps.length - begun, 2);
});

test("an address gives the length of the run and the locks, and going back takes back all that is not in it", async () => {
  const { $, answer, asked, studio } = await open("#device=biased-pump&periods=60&locked=frequency&b.device=soft-film");
  const locked = () => [...document.querySelectorAll("[data-name]")].filter((row) => row.classList.has("locked")).map((row) => row.dataset.name);
  for (const side of ["a", "b"]) { $(`side-${side}`).click(); answer(); }
  $("side-a").click(); answer();
  assert.deepEqual([$("periods").value, locked(), $("badges").querySelectorAll(".badge").length], ["60", ["frequency"], 2]);
  const maps = asked("map").length;
  location.hash = "#device=soft-film&periods=5&locked=voltage_amplitude"; page.listeners.popstate(); answer();
  assert.deepEqual([$("periods").value, locked(), $("badges").querySelectorAll(".badge").length, studio.looks.b, $("sides").hidden], ["5", ["voltage_amplitude"], 1, undefined, true]);
  assert.deepEqual([asked("map").length > maps, asked("map").at(-1).setting.device], [true, "soft-film"]); // that of the other device
});

test("controls that were asked for are asked for until they are there", async () => {
  const { $, answer, last } = await open();
  answer();
  $("subject").value = "device:soft-film"; $("subject").onchange();
  document.querySelector('[data-tab="statics"]').click(); // before its answer
  assert.deepEqual([last("look").setting.device, last("look").controls], ["soft-film", true]);
  answer();
  document.querySelector('[data-tab="portrait"]').click();
  assert.equal(last("look").controls, false);
});

test("a lock is a step of the history and part of the link, and so is its end", async () => {
  const { answer } = await open(), begun = page.steps.length, locked = () => new URLSearchParams(location.hash.slice(1)).get("locked");
  answer();
  const lock = (name) => document.querySelector(`[data-name="${name}"] .lock`).click();
  for (const [name, all] of [["frequency", "frequency"], ["disc_radius", "frequency,disc_radius"], ["frequency", "disc_radius"], ["disc_radius", null]]) {
    if (name === "disc_radius") document.querySelector("#tab-Body").click();
    lock(name);
    assert.equal(locked(), all);
  }
  assert.equal(page.steps.length - begun, 4);
});

test("profiles of membranes are drawn as soon as they are there, each film at its own height and the voltage now", async () => {
  const { $, answer, give } = await open(), flat = (values) => Float32Array.from(values);
  answer(RUN({ v: flat([500, 1000, 500]) }), { second: 30, membrane: ["one", "two"] });
  go(0); draw();
  assert.equal(page.frames.length, 0);
  // rings at 8, a radius that grows from 15 to 25 with the squared voltage, and 30 mm; the middle one as far up as the height over 40
  const table = { height: flat([0, 40]), top: flat([1000, 1000]), radius: flat([8, 15, 30, 8, 25, 30, 8, 15, 30, 8, 25, 30]), rise: flat([1, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1, 0]), stretch: flat(Array(12).fill(1)), wrinkled: new Uint8Array(12) };
  for (const name of ["one", "two"]) give("profiles", { name, shares: [0, 1], rings: 3 }, table);
  assert.equal(page.frames.length, 1);
  const g = $("cone").getContext();
  forget(g); draw();
  const lines = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === LIGHT.taut && c.lineWidth > 2).map((c) => c.args).slice(0, 16);
  // four lines (the second film's, then the first's, on either side) of two parts each: disc, middle, middle, rim
  for (const [k, height] of [[0, 20], [2, 10]]) for (const own of [lines.slice(4 * k, 4 * k + 4), lines.slice(4 * k + 4, 4 * k + 8)]) {
    const [disc, middle, again, rim] = own;
    assert.deepEqual(middle, again);
    assert.ok(near((middle[0] - disc[0]) / (rim[0] - disc[0]), (17.5 - 8) / (30 - 8), 1e-5), `radius at ${height}`);
    assert.ok(near((middle[1] - rim[1]) / (disc[1] - rim[1]), height / 40, 1e-5), `height ${height}`);
  }
});

test("each answer belongs to its side, whichever is the one that is changed", async () => {
  const { $, answer, give, socket, last, studio } = await open(), a = last("look").id;
  answer();
  $("compare").click(); answer();
  for (const [side, id] of [["a", a], ["b", last("look").id]]) {
    const own = side === "a" ? 1 : 2, number = { name: "stroke", place: 0, text: `${own} mm`, value: own };
    socket.give({ kind: "kind", id, side, words: { regime: own - 1, lines: [`lines of ${side}`], extent: [own, own], numbers: [number] } }, {});
    socket.give({ kind: "section", id, side, words: {} }, { px: Float32Array.of(own), pu: Float32Array.of(own) });
    socket.give({ kind: "spectrum", id, side, words: { top: own } }, { frequency: Float32Array.of(own), amplitude: Float32Array.of(own), line: Float32Array.of(), height: Float32Array.of() });
    socket.give({ kind: "statics", id, side, words: { marks: {}, swing: [own, own] } }, { voltage: Float32Array.of(own), x: Float32Array.of(own), stable: Uint8Array.of(1) });
    socket.give({ kind: "late", id, side, stage: "film", message: `why of ${side}` });
  }
  for (const [side, own] of [["a", 1], ["b", 2]]) {
    const look = studio.looks[side];
    assert.deepEqual([[...look.px], look.regime, look.lines[0], look.numbers.get("stroke").value, look.spectrum.top, [...look.statics.x], look.unmade], [[own], own - 1, `lines of ${side}`, own, own, [own], `why of ${side}`]);
  }
  give("section", {}, { px: Float32Array.of(9), pu: Float32Array.of(9) }, "a");
  assert.deepEqual([[...studio.looks.a.px], [...studio.looks.b.px]], [[9], [2]]);
});

test("a long sentence is shortened, and opened by a click that says so; one with room is whole", async () => {
  const { $ } = await open(), [wide, room] = [300, 200];
  const make = document.createElement;
  for (const long of [true, false]) {
    document.createElement = (tag) => Object.assign(make(tag), tag === "span" && { scrollWidth: long ? wide : room, clientWidth: room });
    $("file").files = [{ name: "huge.toml", size: 30001 }];
    await $("file").onchange();
    const [text, more] = $("notices").parts.at(-1).parts;
    assert.deepEqual([more.hidden, more.getAttribute("aria-expanded"), text.textContent.startsWith("huge.toml: has more than")], [!long, "false", true]);
    for (const whole of [true, false]) { more.click(); assert.deepEqual([more.getAttribute("aria-expanded"), $("notices").parts.at(-1).classList.has("whole")], [String(whole), whole]); }
  }
  document.createElement = make;
});

test("the picture of the cone has the room of the motion that is shown, and its gauge the voltages", async () => {
  const { $, answer, give } = await open(), g = $("cone").getContext();
  for (const [high, volts] of [[20, 1234], [60, 400], [15, 2000]]) {
    document.querySelector('[data-tab="statics"]').click();
    answer(RUN({ x: Float32Array.of(10, high, 10), v: Float32Array.of(0, volts, 0) }));
    go(500); forget(g); draw();
    const [, top, , tall] = g.calls.find((c) => c.name === "roundRect" && c.fillStyle === LIGHT.accent).args;
    assert.ok(near(top, 22) && near(tall, 480 - 24 - 22), `${volts} V`); // full at the highest voltage
    const disc = g.calls.find((c) => c.name === "fillText" && c.args[0] === `${high} mm`).args[2];
    assert.ok(disc >= 14 && disc < 480, `${high} mm`);
  }
  give("kind", { regime: 1, lines: ["periodic, period 1"], extent: [4, 5] }, { ot: Float32Array.of(0, 50, 100), ox: Float32Array.of(4, 5, 4), ou: Float32Array.of(0, 0, 0), ov: Float32Array.of(0, 90, 0), ofilm: Uint8Array.of(0, 0, 0), px: Float32Array.of(4), pu: Float32Array.of(0) });
  go((1000 * 50) / (20 * 100)); forget(g); draw();
  assert.ok(near(g.calls.find((c) => c.name === "roundRect" && c.fillStyle === LIGHT.accent).args[3], 480 - 24 - 22)); // of the settled motion
});

test("the cursor over time goes with the time", async () => {
  const { $, answer } = await open();
  answer();
  const places = [0, 500, 1000].map((scrub) => { go(scrub); draw(); return $("time").querySelector(".line").style.transform.match(/-?[\d.]+/g).map(Number)[0]; });
  assert.ok(places[2] > places[0] + 100 && near(places[1], (places[0] + places[2]) / 2, 1e-3));
});

test("the address of a studio at another port leads there with what is shown, one at this port stays", async () => {
  const { $ } = await open("#device=soft-film&frequency=12+Hz"), { hash, href } = location;
  for (const [text, to] of [["http://127.0.0.1:9/?token=new", href], ["http://127.0.0.1:8/?token=new", `http://127.0.0.1:8/?token=new${hash}`]]) {
    $("address").value = text; $("address").onchange();
    assert.equal(location.href, to);
  }
});

test("the theme is the one chosen before, else the system's, and a click takes the other one", async () => {
  const theme = () => document.documentElement.dataset.theme;
  for (const system of [false, true]) for (const chosen of [null, "dark", "light"]) {
    const before = globalThis.matchMedia;
    const own = async () => {
      browser("#device=biased-pump");
      globalThis.matchMedia = (query) => ({ matches: system && query.includes("dark") });
      if (chosen) localStorage.setItem("gelcone-theme", chosen);
      await import(`../../../src/gelcone/studio/static/main.js?${++opened}`);
    };
    await own();
    const first = chosen ?? (system ? "dark" : "light"), other = first === "dark" ? "light" : "dark";
    assert.equal(theme(), first, `${system} ${chosen}`);
    for (const next of [other, first]) { document.getElementById("theme").click(); assert.deepEqual([theme(), localStorage.getItem("gelcone-theme")], [next, next]); }
    globalThis.matchMedia = before;
  }
  assert.notEqual(LIGHT.panel, DARK.panel);
});

test("what is said for a moment is seen, and says whether the browser copied", async () => {
  for (const copies of [true, false]) {
    const { $ } = await open();
    navigator.clipboard.writeText = async () => { if (!copies) throw new Error("no"); };
    assert.ok($("toast").hidden);
    await $("share").onclick();
    assert.deepEqual([$("toast").hidden, $("toast").textContent], [false, copies ? "The address is copied; it works while the studio runs." : "Copy the address from the address bar."]);
    wait(2500);
    assert.ok($("toast").hidden);
  }
});

test("going back to another subject asks for its controls, and for both of two settings", async () => {
  const { asked, answer } = await open();
  answer();
  const back = (hash) => { const before = asked("look").length; location.hash = hash; page.listeners.popstate(); return asked("look").slice(before).map(({ side, setting, controls }) => [side, setting.device ?? setting.preset, controls]); };
  assert.deepEqual(back("#device=soft-film"), [["a", "soft-film", true]]);
  answer();
  assert.deepEqual(back("#preset=base"), [["a", "base", true]]);
  answer();
  assert.deepEqual(back("#device=soft-film&b.preset=base&side=b"), [["a", "soft-film", false], ["b", "base", true]]);
});

test("an address of two settings asks for both, and for the controls of the one that is changed", async () => {
  for (const side of ["a", "b"]) {
    const { asked, $ } = await open(`#device=biased-pump&frequency=9+Hz&b.device=soft-film&side=${side}`);
    const looks = asked("look").map(({ side: own, setting, controls }) => [own, setting.device, controls]);
    // the controls of a side that has never been asked for come with its first look
    assert.deepEqual(looks.map(([own, device]) => [own, device]), [["a", "biased-pump"], ["b", "soft-film"]]);
    assert.ok(looks.find(([own]) => own === side)[2]);
    assert.deepEqual([$("sides").hidden, $(`side-${side}`).getAttribute("aria-pressed"), $("subject").value], [false, "true", side === "a" ? "device:biased-pump" : "device:soft-film"]);
  }
});

test("the colours of the film are named as before once a lost connection has come back", async () => {
  const { $, answer } = await open(), names = () => $("film-legend").querySelectorAll("li").map((li) => li.textContent);
  answer();
  const before = names(), [socket] = Socket.all;
  assert.deepEqual(before, ["film taut"]);
  socket.close(); wait(300);
  const again = Socket.all.at(-1);
  again.open(); again.give(HELLO);
  const { id, side } = again.last;
  again.give({ kind: "response", id, side, about: ABOUT, words: { seems: "seems to repeat", ended: "", period: 100, shares: [{ code: 0, share: 1 }] } }, RUN());
  assert.deepEqual(names(), before);
});

test("the list of subjects shows what was chosen, in the gallery, as a file or by the address, before it is answered", async () => {
  const { $, answer } = await open();
  answer();
  $("browse").click();
  $("gallery").querySelectorAll(".tile").find((tile) => tile.textContent.startsWith("soft-film")).click();
  assert.equal($("subject").value, "device:soft-film");
  $("file").files = [file("mine.toml", "disc_radius = 1")];
  await $("file").onchange();
  assert.equal($("subject").value, "file:");
  const given = await open("#file=disc_radius+%3D+1");
  assert.deepEqual([given.$("subject").value, given.$("subject").selectedOptions.map((o) => o.textContent)], ["file:", ["device file"]]);
});

test("an address that falls back is no step of the history", async () => {
  const { socket, last, answer } = await open("#device=biased-pump&frequency=-1+Hz"), steps = page.steps.length;
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "frequency", message: "frequency = -1 Hz: must be positive" });
  answer(); wait(300);
  assert.deepEqual([page.steps.length - steps, location.hash.includes("frequency=-1")], [0, false]);
  field("frequency").value = "7"; field("frequency").onchange(); answer();
  assert.deepEqual(page.entries.map((text) => new URLSearchParams(text.slice(1)).get("frequency")), [null, "7 Hz"]);
});

test("the colours of the film in the legend are those of the theme, and its states those of the motion that is shown", async () => {
  const { $, answer, give } = await open(), items = () => $("film-legend").querySelectorAll("li").map((li) => [li.textContent, li.querySelector("i").style.background]);
  answer(RUN(), {}, { shares: [{ code: 0, share: 0.5 }, { code: 1, share: 0.5 }] });
  give("kind", { regime: 1, lines: ["periodic, period 1"], extent: [4, 5], shares: [{ code: 0, share: 1 }] }, { ot: Float32Array.of(0, 50, 100), ox: Float32Array.of(4, 5, 4), ou: Float32Array.of(0, 0, 0), ov: Float32Array.of(0, 90, 0), ofilm: Uint8Array.of(0, 0, 0), px: Float32Array.of(4), pu: Float32Array.of(0) });
  for (const [theme, colours] of [["light", LIGHT], ["dark", DARK], ["light", LIGHT]]) {
    if (document.documentElement.dataset.theme !== theme) $("theme").click();
    for (const [motion, states] of [["start", [["film taut", colours.taut], ["film hoop slack", colours.around]]], ["settled", [["film taut", colours.taut]]]]) {
      document.querySelectorAll("#motion button").find((b) => b.dataset.motion === motion).click();
      assert.deepEqual(items(), states, `${theme} ${motion}`);
    }
    $("theme").click(); $("theme").click();
    assert.deepEqual(items(), [["film taut", colours.taut]]);
  }
});

test("each dialog opens by its button and closes by its own", async () => {
  const { $, answer } = await open();
  answer();
  for (const [button, dialog] of [["browse", "gallery"], ["save", "saver"]]) for (const round of [1, 2]) {
    $(button).click();
    assert.equal($(dialog).open, true, `${dialog} ${round}`);
    $(dialog).querySelectorAll("button").find((own) => own.textContent === "Close").click();
    assert.equal($(dialog).open, false, `${dialog} ${round}`);
  }
});

test("pictures follow each other in one row, however often something else asks for one", async () => {
  const { $, answer } = await open(), waiting = () => page.timers.filter((timer) => [22, 38].includes(timer?.wait)).length;
  answer();
  if ($("play").getAttribute("aria-label") === "Play") $("play").click();
  for (let k = 0; k < 5; k++) { draw(); $("theme").click(); draw(); assert.equal(waiting(), 1, `${k}`); }
});

test("what is shown is made of what a browser knows, is named, and is styled: each rule of the style sheet is of something on the page", async () => {
  const seen = new Set(), look = () => { for (const one of SELECTORS) if (!seen.has(one) && everything().some((e) => e.matches(one))) seen.add(one); assert.deepEqual(faults(), []); };
  const film = { name: "film", label: "Film", group: "Body", kind: "choice", value: "taut", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["taut", "wrinkling"] };
  const { $, answer, give, socket, last } = await open(), number = { name: "stroke", place: 0, text: "1 mm", value: 1 };
  CONTROLS.push(film); answer(RUN(), { wrinkles: true }); CONTROLS.pop();
  give("kind", { regime: 1, lines: ["periodic, period 1", "one"], extent: [4, 5], numbers: [number] }); draw(); look();
  $("badges").querySelector(".why").click(); look();
  const field = (name) => document.querySelector(`[data-name="${name}"]`).querySelector("select,input"), refuse = (name) => socket.give({ kind: "error", id: last("look").id, side: "a", control: name, message: `${name}: is wrong` });
  field("frequency").value = "12.3456789 Hz"; field("frequency").onchange(); wait(400); look();
  for (const name of ["frequency", "film"]) { field(name).value = "wrinkling"; field(name).onchange(); refuse(name); look(); }
  document.querySelector('[data-name="frequency"] .more').click(); look();
  document.querySelector('[data-name="voltage_amplitude"] .lock').click(); look();
  answer(RUN(), {}, { shares: [{ code: 1, share: 1 }] }); look();
  $("file").files = [{ name: "huge.toml", size: 30001 }]; await $("file").onchange(); look();
  $("compare").click(); answer(); look();
  $("browse").click(); $("save").click(); $("share").click(); $("theme").click(); look();
  assert.deepEqual(SELECTORS.filter((one) => !seen.has(one)), []);
});

const pale = (panel) => { const own = document.getElementById(panel).querySelector("canvas").getContext(); return own.calls.findLast((c) => c.name === "stroke" && c.strokeStyle === LIGHT.a)?.globalAlpha < 0.5; };
const ORBIT = { ot: Float32Array.of(0, 50, 100), ox: Float32Array.of(4, 5, 4), ou: Float32Array.of(0, 1, 0), ov: Float32Array.of(0, 90, 0), ofilm: Uint8Array.of(0, 0, 0), px: Float32Array.of(4), pu: Float32Array.of(0) };
const KIND = { regime: 1, lines: ["periodic, period 1"], extent: [4, 5] };
const field = (name) => document.querySelector(`[data-name="${name}"]`).querySelectorAll("input")[0];
const slide = (name, place, end = "oninput") => { const own = document.querySelector(`[data-name="${name}"]`).querySelectorAll("input")[1]; own.value = String(place); own[end](); };

test("what waits, waits as long as it says: the address for a hand at rest, words for a slow answer, an outdated motion to fade", async () => {
  const { $, answer, give } = await open(), old = () => document.body.classList.contains("old");
  answer(); give("kind", KIND, ORBIT); wait(300);
  const address = location.hash;
  slide("frequency", 300);
  wait(399);
  assert.deepEqual([$("doing").textContent, old()], ["", false]);
  wait(400);
  assert.deepEqual([$("doing").textContent.startsWith("Computing"), old()], [true, true]);
  answer();
  wait(149);
  assert.deepEqual([pale("portrait"), location.hash], [false, address]);
  wait(150);
  assert.equal(pale("portrait"), true);
  wait(299);
  assert.equal(location.hash, address);
  wait(300);
  assert.notEqual(location.hash, address);
  slide("frequency", 310); wait(400); slide("frequency", 320); // the next one is waited for anew, but what is said stays
  assert.ok(old() && $("doing").textContent.startsWith("Computing"));
  answer();
  assert.deepEqual([old(), $("doing").textContent], [false, ""]);
});

test("an answer is awaited for 150 ms with a cone that stands, then it moves on", async () => {
  const { $, answer } = await open();
  answer();
  if ($("play").getAttribute("aria-label") === "Play") $("play").click();
  for (const [passed, moves] of [[149, false], [151, true]]) {
    moment += 1000; draw(); page.timers.length = 0;
    slide("frequency", 300 + passed); page.frames.length = 0; draw(); $("theme").click(); draw();
    moment += passed; wait(38);
    assert.equal(page.frames.length > 0, moves, `${passed} ms`);
    answer();
  }
});

test("what a hand sets anywhere stands in the controls at once, and in the plots over parameters", async () => {
  const { $, answer } = await open("#device=biased-pump&y=frequency,0.1,20&x=voltage_amplitude,0,1600"), canvas = $("map").querySelector("canvas");
  answer();
  const ring = () => $("map").querySelector(".ring").style.transform, before = ring();
  for (const event of ["down", "up"]) canvas[`onpointer${event}`]({ clientX: 400, clientY: 100, pointerId: 1 });
  assert.ok(field("voltage_amplitude").value !== "800 V" && field("frequency").value !== "10 Hz" && ring() !== before);
  slide("frequency", 0);
  assert.equal(field("frequency").value, "0.1 Hz");
});

test("what is zoomed stays so while a choice brings other controls, and goes with another subject", async () => {
  const film = { name: "film", label: "Film", group: "Body", kind: "choice", value: "taut", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["taut", "wrinkling"] };
  CONTROLS.push(film);
  const { $, answer, last, asked } = await open("#device=biased-pump&x=voltage_amplitude,400,500&y=frequency,5,6&over=frequency,3,4");
  answer();
  const select = document.querySelector('[data-name="film"] select'), zoomed = [["voltage_amplitude", 400, 500], ["frequency", 5, 6]], maps = asked("map").length;
  select.value = "wrinkling"; select.onchange(); answer(); wait(500);
  assert.deepEqual([[last("map").x, last("map").y], asked("map").length], [zoomed, maps + 1]);
  document.querySelector('[data-tab="strip"]').click();
  assert.deepEqual(last("strip").over, ["frequency", 3, 4]);
  $("subject").value = "device:soft-film"; $("subject").onchange(); answer();
  assert.notDeepEqual(last("strip").over, ["frequency", 3, 4]);
  document.querySelector('[data-tab="map"]').click();
  assert.notDeepEqual([last("map").x, last("map").y], zoomed);
  CONTROLS.pop();
});

test("an error that belongs to no side is said above the page, one of a map in the map alone, and one of an older question nowhere", async () => {
  const { $, answer, socket, last } = await open(), said = () => $("notices").textContent;
  answer();
  slide("frequency", 300);
  const older = last("look").id;
  slide("frequency", 310);
  socket.give({ kind: "error", id: older, side: "a", control: "frequency", message: "older" });
  assert.deepEqual([said(), document.querySelector('[data-name="frequency"] .error').hidden], ["", true]);
  answer();
  socket.give({ kind: "error", id: older, side: "a", message: "answered long ago" });
  const map = $("map").querySelector("canvas").getContext();
  socket.give({ kind: "error", id: last("map").id, message: "no such map" });
  assert.deepEqual([said(), texts(map).includes("no such map")], ["", true]);
  for (const [id, message] of [[9999, "of no one"], [null, "of nothing that could be read"]]) { socket.give({ kind: "error", id, side: null, control: null, message }); assert.ok(said().includes(message)); }
});

test("a lost connection fades the picture until it is back with an answer", async () => {
  const { answer, socket } = await open(), old = () => document.body.classList.contains("old");
  answer();
  socket.close();
  assert.equal(old(), true);
  wait(300);
  const again = Socket.all.at(-1);
  again.open(); again.give(HELLO);
  const { id, side } = again.last;
  again.give({ kind: "response", id, side, about: ABOUT, words: { seems: "seems to repeat", ended: "", period: 100, shares: [] } }, RUN());
  assert.equal(old(), false);
});

test("of a set without units the disc sets displacement and velocity, as they are", async () => {
  const plain = (name, value) => ({ name, label: name, group: "Start", kind: "number", value, unit: "", low: -2, high: 2, powers: { "": 0 }, about: "", choices: [] });
  CONTROLS.push(plain("displacement", 0.3), plain("velocity", 0));
  const { $, answer, last } = await open("#preset=base"), canvas = $("cone"), x = 640 / 4;
  answer(RUN({ x: Float32Array.of(0, 1, 0) }), { si: false, disc: 0.2, rim: 1 });
  if ($("play").getAttribute("aria-label") === "Pause") $("play").click();
  go(500); draw();
  const at = (y, type) => ({ clientX: 10 + x, clientY: 20 + y, pointerId: 1, type });
  const place = Array.from({ length: 480 }, (_, y) => y).find((y) => { canvas.onpointermove(at(y, "pointermove")); return canvas.style.cursor === "ns-resize"; });
  const pulled = [20, 40].map((pixels) => {
    canvas.onpointerdown(at(place + 12, "pointerdown")); canvas.onpointermove(at(place + 12 - pixels, "pointermove"));
    assert.deepEqual([Object.keys(last("look").setting.values), last("look").setting.values.velocity], [["displacement", "velocity"], "0"]);
    return Number(last("look").setting.values.displacement);
  });
  assert.ok(near(2 * pulled[0] - pulled[1], 1, 2e-3) && pulled[1] > pulled[0]);
  assert.deepEqual(document.querySelectorAll("#motion button").map((b) => b.getAttribute("aria-pressed")), ["false", "true"]);
  CONTROLS.splice(3);
});

test("files are told apart by their ending, and a curve that is too large or cannot be read says why", async () => {
  const { $, last, studio } = await open();
  const give = async (...files) => { $("file").files = files; await $("file").onchange(); await passed(); };
  await give(file("MINE.TOML", "name = 'a'"));
  assert.equal(last("look").setting.file, "name = 'a'");
  await give({ name: "big.csv", size: 2_000_001, text: async () => "" }, file("odd.txt", "a"), file("toml.csv", "time (ms),height (mm)\n0,5\n1,6\n"));
  assert.deepEqual($("notices").parts.map((line) => line.parts[0].textContent), ["big.csv: has more than 2000000 characters; export fewer rows", "odd.txt: needs a line of names with units, such as time (ms),height (mm), and two rows of numbers"]);
  assert.deepEqual([studio.looks.measured.map((own) => own.name), $("unmeasure").hidden, $("file").value], [["toml.csv"], false, ""]);
});

test("what is saved as a picture has the subject's name, its values and the pictures that are open", async () => {
  const { $, answer } = await open("#device=soft-film&frequency=12+Hz"), drawn = [], make = document.createElement;
  answer();
  document.createElement = (tag) => { const own = make(tag); if (tag === "canvas") { own.toBlob = (does) => does(null); drawn.push(own); } return own; };
  $("save").click();
  $("saver").querySelectorAll("button").find((own) => own.textContent === "Picture").click();
  document.createElement = make;
  const g = drawn.at(-1).getContext(), pictures = g.calls.filter((c) => c.name === "drawImage").map((c) => c.args[0]);
  assert.deepEqual(texts(g), ["soft-film: seems to repeat", "with frequency 12 Hz", "gelcone studio"]);
  assert.deepEqual(pictures, [$("cone"), ...["time", "portrait", "map"].map((name) => $(name).querySelector("canvas"))]);
  assert.equal($("saver").querySelector('[role="status"]').textContent, "The browser made no picture.");
});

// --- a server that answers everything, and what is seen ---------------------------------------------------------------

const number = (own) => [...JSON.stringify(own)].reduce((sum, letter) => (7 * sum + letter.charCodeAt(0)) % 97, 1); // of what an answer depends on
const some = (...values) => Float32Array.from(values);
const OPTION = { name: "film", label: "Film", group: "Body", kind: "choice", value: "taut", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["taut", "wrinkling"] };
const NAMES = ["taut", "hoop slack", "meridian slack", "slack in both directions", "above breakdown", "near its stretch limit", "above membrane pull-in"];

// The answers to what was asked: [head, arrays] of each.
function answered({ kind, id, ...asked }) {
  if (!asked.setting?.values) return [];
  const along = kind === "envelope" ? ["frequency", "voltage_amplitude"] : [asked.x, asked.y, asked.over].flatMap((axis) => axis?.[0] ?? []); // the same for all their values
  const values = Object.entries(asked.setting.values).filter(([name]) => !along.includes(name)).sort(), n = number({ ...asked.setting, values }), { side } = asked, own = (name, words = {}, arrays = {}) => [{ kind: name, id, side, words }, arrays];
  if (kind === "look") {
    const si = !asked.setting.preset, text = si ? `${n} mm` : `${n}`, label = (name, unit) => (si ? `${name} (${unit})` : name), film = n % 7;
    const axes = { time: label("time", "ms"), displacement: label("height", "mm"), velocity: label("velocity", "m/s"), voltage: label("voltage", "V"), constant: label("constant voltage", "V"), frequency: label("frequency", "Hz"), amplitude: label("amplitude", "mm") };
    const about = { ...ABOUT, axes, si, film: NAMES, name: `name ${n}`, doubts: [`doubt ${n}`], film_of: n % 2 ? "cone" : "membrane" }, list = [...CONTROLS, OPTION].map((c) => (si ? c : { ...c, label: `${c.label} of the set` }));
    return [
      ...(asked.controls ? [[{ kind: "subject", id, side, controls: list, words: {} }, {}]] : []),
      [{ kind: "response", id, side, about, words: { seems: `seems ${n}`, ended: "", period: asked.periods * 5 + n, shares: [{ code: film, share: 1 }] } }, RUN({ x: some(10, 10 + n, 10), film: Uint8Array.of(film, film, film) })],
      own("kind", { regime: n % 4, lines: [`kind ${n}`, `evidence ${n}`], extent: [4, 5], shares: [{ code: film, share: 1 }], numbers: [{ name: "stroke", place: 0, text, value: n }] }, { ...ORBIT, ofilm: Uint8Array.of(film, film, film) }),
      own("numbers", { numbers: [{ name: "current", place: 3, text, value: n }] }), own("section", {}, { px: some(4, n), pu: some(0, 0) }),
      ...(asked.panels.includes("spectrum") ? [own("spectrum", { top: 100 + n }, { frequency: some(0, n), amplitude: some(1, 2), line: some(n), height: some(2) })] : []),
      ...(asked.panels.includes("statics") ? [own("statics", { marks: { [`limit ${n}`]: 900 }, swing: [0, 800] }, { voltage: some(0, 900), x: some(10, 20), stable: Uint8Array.of(1, 0) })] : []),
    ];
  }
  if (kind === "map") return [[{ kind: "grid", id, grid: kind, cells: [65, 49] }, {}], [{ kind: "cells", id, share: 1 }, { places: some(0, 900), regime: Uint8Array.of(n % 4, 1), exponent: some(-1, 1), low: some(0, 0), high: some(1, n) }], [{ kind: "thresholds", id, upright: true, names: [`limit ${n}`] }, { at: some(1, 3, 5), [`limit ${n}`]: some(2, 2, 2) }], [{ kind: "done", id, grid: kind }, {}], [{ kind: "followed", id }, {}]];
  if (kind === "strip") return [[{ kind: "grid", id, grid: kind, cells: [5] }, {}], [{ kind: "cells", id, share: 1 }, { places: some(0, 3), regime: Uint8Array.of(n % 4, 1), section: some(1, n), low: some(0, 0), high: some(2, n + 1) }], [{ kind: "done", id, grid: kind }, {}], [{ kind: "branches", id, kinds: [`event ${n}`] }, { value: some(1, 2), section: some(1, 2), stable: Uint8Array.of(1, 1), event_value: some(2), event_section: some(2), event_kind: Uint8Array.of(0) }]];
  if (kind === "envelope") return [[{ kind, id, limits: [`limit ${n}`], static: {}, highest: 3000, least: 1, most: 20, share: 1, pull_in_of: "cone", shape: { voltage_amplitude: 1 } }, { frequency: some(1, 20), window: some(1000, 2000), [`limit limit ${n}`]: some(1500, 2500) }], [{ kind: "done", id, grid: kind }, {}]];
  return [];
}

// A page that stands, with such a server: act() does something, lets all be answered and all timers pass, and gives what
// was asked, with the number of steps of the history.
async function attended(hash, refused = () => null) {
  browser(hash);
  page.media["(prefers-reduced-motion: reduce)"] = { matches: true };
  await import(`../../../src/gelcone/studio/static/main.js?${++opened}`);
  const [first] = Socket.all, done = new Map();
  const answers = (asked) => (refused(asked) ? [[{ kind: "error", id: asked.id, side: asked.side ?? null, control: null, message: "is refused", ...refused(asked) }, {}]] : answered(asked));
  const all = async () => {
    for (let k = 0; k < 4; k++) {
      const socket = Socket.all.at(-1), next = () => { const at = done.get(socket) ?? 0; done.set(socket, at + 1); return socket.sent[at]; };
      while ((done.get(socket) ?? 0) < socket.sent.length) for (const [head, arrays] of answers(next())) socket.give(head, arrays);
      moment += 1000; wait(600); draw(); await passed();
    }
  };
  const greet = (socket = Socket.all.at(-1)) => { socket.open(); socket.give({ ...HELLO, regimes: ["rest", "periodic", "quasi-periodic", "chaotic"].map((name, k) => ({ name, colour: `#${k}0${k}0${k}0` })) }); };
  const act = async (does) => {
    const socket = Socket.all.at(-1), from = socket.sent.length, steps = page.steps.length;
    await does(); await all();
    return [socket.sent.slice(from).map((own) => [own.kind, own.side ?? own.grid, ...(own.controls ? ["with controls"] : []), ...(own.panels ?? [])].filter(Boolean).join(" ")), page.steps.length - steps];
  };
  await act(() => greet(first));
  document.getElementById("gallery").close();
  return { act, greet, socket: first, $: (id) => document.getElementById(id) };
}

// What was drawn last on a canvas, and where: ranges of plots over data depend on what they have shown before.
function lastCalls(canvas) {
  const { calls } = canvas.getContext(), from = calls.findLastIndex((c) => c.name === "fillRect" && c.fillStyle === colours().panel && c.args[2] === SIZE[0]);
  return calls.slice(from);
}
const seenLast = (canvas) => drawn({ calls: lastCalls(canvas) });
const placedLast = (canvas) => lastCalls(canvas).filter(({ args }) => args.every((own) => typeof own !== "object")).map(({ name, args }) => `${name} ${args.join()}`);

// What is seen: the address, elements, marks over parameters, and of each picture in sight what was drawn last.
function seen() {
  const canvases = [document.getElementById("cone"), ...document.querySelectorAll(".view.shown .plot canvas")];
  return {
    address: location.hash, body: ["header", "aside", "#badges", "#film-legend", "#motion"].map((one) => made(document.querySelector(one)).replace(/-p\.error role=alert( "[^"]*"| \[[^\]]*\])?/g, "no error")), views: document.querySelectorAll(".view.shown").map(made), classes: document.body.className, styles: ["#badges", "#film-legend", ".grid.shown"].flatMap((one) => document.querySelector(one).all()).filter((e) => !e.hidden && (e.style.color || e.style.background)).map((e) => [e.className, e.textContent, e.style.color, e.style.background]),
    marks: document.querySelectorAll(".grid.shown .mark").map((own) => [own.className, own.hidden || own.style.transform]), pictures: canvases.map(seenLast), places: [document.getElementById("cone"), ...document.querySelectorAll("#map.shown canvas, #envelope.shown canvas")].map(placedLast),
  };
}
const click = (selector) => document.querySelector(selector).click();
const choose = (selector, value) => { const own = document.querySelector(selector); own.value = value; own.onchange(); };

test("after anything that is done the page is as one opened at its address, and asked the server for no more than it needs", async () => {
  const event = (x, y) => ({ clientX: 10 + x, clientY: 20 + y, pointerId: 1 }), drag = (view, ...places) => { const canvas = document.querySelector(`#${view} canvas`); places.forEach((at, k) => { canvas[k ? "onpointermove" : "onpointerdown"](event(...at)); }); canvas.onpointerup(event(...places.at(-1))); };
  const rows = [ // what is done, with a full stop where the page is compared; what is asked; how many steps of the history
    ["a slider moves", () => slide("disc_radius", 300), ["look a", "map"], 0], ["it is let go", () => slide("disc_radius", 320, "onchange"), ["look a", "map"], 1],
    ["a value is typed", () => { field("frequency").value = "7"; field("frequency").onchange(); }, ["look a"], 1], ["a choice", () => choose('[data-name="film"] select', "wrinkling"), ["look a with controls", "map"], 1],
    ["a lock", () => click('[data-name="frequency"] .lock'), [], 1], ["the lock again", () => click('[data-name="frequency"] .lock'), [], 1],
    ["a reset.", () => click('[data-name="frequency"] .reset'), ["look a"], 1], ["another length", () => choose("#periods", "60"), ["look a"], 1],
    ["the spectrum", () => click('[data-tab="spectrum"]'), ["look a spectrum"], 1], ["the statics.", () => click('[data-tab="statics"]'), ["look a spectrum statics"], 1], ["again", () => click('[data-tab="statics"]'), ["look a spectrum statics"], 0],
    ["from the start", () => click('[data-motion="start"]'), [], 1], ["a click on the map", () => drag("map", [300, 200]), ["look a spectrum statics"], 1], ["a zoom.", () => drag("map", [200, 100], [400, 300]), ["map"], 1],
    ["another view", () => { const view = document.querySelectorAll("#map select").at(-1); view.value = "stroke"; view.onchange(); }, [], 1], ["the full range", () => document.querySelectorAll("#map button").at(-1).click(), ["map"], 1],
    ["another parameter.", () => choose("#map select", "disc_radius"), ["map"], 1], ["the sweep", () => click('[data-tab="strip"]'), ["strip"], 1], ["a drag along it.", () => drag("strip", [300, 200], [350, 200]), ["look a spectrum statics", "look a spectrum statics", "look a spectrum statics"], 1],
    ["its other parameter", () => choose("#strip select", "disc_radius"), ["strip"], 1], ["the envelope", () => click('[data-tab="envelope"]'), ["envelope"], 1], ["a click in it.", () => drag("envelope", [300, 200]), ["look a spectrum statics", "look a spectrum statics"], 1],
    ["all tabs back", () => { for (const name of ["time", "portrait", "map"]) click(`[data-tab="${name}"]`); }, ["look a statics", "look a", "map"], 3], ["the settled motion.", () => click('[data-motion="settled"]'), [], 1],
    ["another theme", () => click("#theme"), [], 0], ["and back", () => click("#theme"), [], 0],
    ["two settings", () => click("#compare"), ["look b with controls"], 1], ["the second differs.", () => choose('[data-name="film"] select', "taut"), ["look b with controls", "map"], 1], ["the first.", () => click("#side-a"), ["look a with controls", "map"], 1], ["in the dark", () => click("#theme"), [], 0], ["the second", () => click("#side-b"), ["look b with controls", "map"], 1], ["and in the light.", () => click("#theme"), [], 0],
    ["its subject", () => choose("#subject", "device:soft-film"), ["look b with controls", "map"], 1], ["one without units.", () => choose("#subject", "preset:base"), ["look b with controls", "map"], 1], ["the first one's equilibria", () => { click("#side-a"); click('[data-tab="statics"]'); }, ["look a with controls", "look a with controls statics", "look b statics", "map"], 2],
    ["the second is left.", () => { click("#side-b"); click("#compare"); }, ["look b with controls statics", "look a with controls statics", "map"], 2],
    ["all is reset.", () => { slide("disc_radius", 100, "onchange"); click("#reset-all"); }, ["look a statics", "look a statics", "map"], 2],
  ];
  const own = await attended("#device=biased-pump"), results = [];
  for (const [what, does, ...found] of rows) { assert.deepEqual(await own.act(does), found, what); if (what.endsWith(".")) results.push([what, seen()]); }
  for (const [what, before] of results) { await attended(before.address); assert.deepEqual(before, seen(), what); }
});

test("after what is refused, a lost connection or a closed dialog the page is as one opened at its address", async () => {
  const refused = ({ setting }) => (setting?.values?.disc_radius === "16 mm" ? { control: "frequency" } : setting?.device === "soft-film" || setting?.file === "bad" ? { control: "law" } : null), compared = async (what) => { const before = seen(); await attended(before.address, refused); assert.deepEqual(before, seen(), what); };
  const open = (name, text) => page.listeners.drop({ dataTransfer: { types: ["Files"], files: [file(name, text)] }, preventDefault() {} });
  const rows = [
    ["a value", () => slide("disc_radius", 1000, "onchange"), () => slide("disc_radius", 300, "onchange")], ["a device", () => choose("#subject", "device:soft-film")], ["a file", () => open("bad.toml", "bad")], ["another file", () => open("good.toml", "good"), () => slide("frequency", 200, "onchange")],
    ["a value of a file, and back", () => open("good.toml", "good"), () => slide("disc_radius", 1000, "onchange"), () => page.back()], ["a set, then a device", () => choose("#subject", "preset:base"), () => choose("#subject", "device:soft-film")],
    ["the device of a second setting", () => click("#compare"), () => choose("#subject", "device:soft-film")], ["a value of a second setting", () => click("#compare"), () => slide("frequency", 100, "onchange"), () => slide("disc_radius", 1000, "onchange"), () => click("#side-a"), () => click("#side-b")],
    ["a connection", (own) => { Socket.all.at(-1).close(); wait(3000); own.greet(); }], ["a change without it", () => Socket.all.at(-1).close(), () => click('[data-tab="statics"]'), (own) => { wait(3000); own.greet(); }],
    ["dialogs", () => click("#browse"), () => document.getElementById("gallery").close(), () => click("#save"), () => document.getElementById("saver").close()],
  ];
  for (const [what, ...acts] of rows) {
    const own = await attended("#device=biased-pump", refused);
    for (const act of acts) await own.act(() => act(own));
    await compared(what);
  }
});

test("of two settings what is of one alone is of the one that is changed", async () => {
  const rows = [["device=soft-film&disc_radius=5+mm", "preset=base&frequency=7"], ["preset=base&frequency=7", "device=soft-film&disc_radius=5+mm"], ["device=soft-film&frequency=3+Hz", "device=biased-pump&film=wrinkling&frequency=9+Hz"]], second = (text) => text.split("&").map((part) => `b.${part}`).join("&");
  const own = (socket) => {
    click("#save");
    const code = socket.sent.findLast(({ kind }) => kind === "code"), grid = document.querySelector(".grid.shown"), names = ["time", "portrait"].map((view) => seenLast(document.querySelector(`#${view} canvas`)).filter((one) => /soft 11px center (bottom|middle)$/.test(one)));
    return { code: [code.setting, code.options], aside: made(document.querySelector("aside")), subject: document.getElementById("subject").value, speeds: document.getElementById("speed").options.map((o) => o.textContent), tab: document.getElementById("envelope-tab").hidden, grid: made(grid), picture: seenLast(grid.querySelector("canvas")), names };
  };
  for (const [one, other] of rows) for (const more of ["right=map&view=stroke", "right=strip"]) {
    const found = [];
    for (const hash of [`${one}&${more}`, `${other}&${second(one)}&side=b&${more}`, `${one}&${second(other)}&side=a&${more}`]) { const { socket } = await attended(`#${hash}`); found.push(own(socket)); }
    for (const pair of found.slice(1)) assert.deepEqual(pair, found[0], `${one} ${other} ${more}`);
  }
});

test("evidence of an older question is shown until its own comes, but not of one that is long past", async () => {
  const { $, answer, last, socket } = await open(), kind = () => $("badges").querySelector(".kind").textContent, give = (id) => socket.give({ kind: "kind", id, side: "a", words: KIND }, ORBIT);
  answer();
  const { id } = last("look");
  slide("frequency", 300); slide("frequency", 310);
  give(id);
  assert.equal(kind(), "Periodic, period 1");
  for (let k = 0; k < 501; k++) slide("frequency", k);
  answer();
  assert.equal(kind(), "Seems to repeat …");
  give(id);
  assert.equal(kind(), "Seems to repeat …");
});

test("evidence of a second setting that was left and is there again waits for its run", async () => {
  const { answer, last, socket, studio } = await open("#device=biased-pump&b.device=soft-film&side=b"), both = location.hash, back = (hash) => { location.hash = hash; page.listeners.popstate(); };
  answer();
  const { id } = last("look");
  back("#device=biased-pump"); back(both);
  for (const kind of ["kind", "numbers", "section", "spectrum", "statics", "late"]) socket.give({ kind, id, side: "b", stage: "kind", words: KIND });
  assert.equal(studio.looks.b, undefined);
  answer();
  assert.equal(studio.looks.b.lines, undefined);
});

test("a page at rest draws its cone and plots anew when they are given another size", async () => {
  const from = page.observers.length, { $ } = await attended("#device=biased-pump"), canvases = [$("cone"), $("time").querySelector("canvas")];
  for (const canvas of canvases) forget(canvas.getContext());
  for (const resized of page.observers.slice(from)) resized();
  draw();
  for (const canvas of canvases) assert.ok(texts(canvas.getContext()).length > 0, canvas.id);
});

test("what is said of a computation goes with its error", async () => {
  const { $, answer, socket, last } = await open();
  answer();
  slide("frequency", 300); wait(400);
  assert.match($("doing").textContent, /^Computing/);
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "frequency", message: "no" });
  assert.deepEqual([$("doing").textContent, field("frequency").value], ["", "6.07 Hz"]); // what is wrong stays
  slide("frequency", 310); answer();
  assert.ok(!document.body.classList.contains("old"));
});

test("a device file has at most 30000 characters", async () => {
  const { $, asked } = await open(), count = asked("look").length;
  for (const [size, more, notices] of [[30000, 1, 0], [30001, 1, 1]]) {
    $("file").files = [{ name: "a.toml", size, text: async () => "a" }];
    await $("file").onchange(); await passed();
    assert.deepEqual([asked("look").length - count, $("notices").parts.length], [more, notices]);
  }
});

test("where the settled motion is late its button says so at once, on the side that is changed", async () => {
  const { $, answer, socket, last } = await open(), settled = () => { const own = document.querySelector('[data-motion="settled"]'); return [own.getAttribute("aria-pressed"), Boolean(own.disabled), own.title]; };
  answer();
  socket.give({ kind: "late", id: last("look").id, side: "a", stage: "kind", message: "too long" });
  assert.deepEqual(settled(), ["false", true, "too long"]);
  socket.give({ kind: "kind", id: last("look").id, side: "a", words: KIND }, ORBIT);
  draw();
  assert.ok(texts($("cone").getContext()).length > 0);
});

test("going back leads through all that was done, each time to the page as it was", async () => {
  const own = await attended("#device=biased-pump&y=frequency,0.1,20&x=voltage_amplitude,0,1600&over=voltage_amplitude,0,1600"), done = [], note = (what) => done.push([what, seen()]);
  const axis = (view, name) => { const select = document.querySelector(`#${view} select`); select.value = name; select.onchange(); };
  note("at first");
  for (const [what, ...acts] of [
    ["a slider that rested on its way", () => slide("frequency", 300), () => slide("frequency", 500), () => slide("frequency", 500, "onchange")], ["a lock", () => click('[data-name="voltage_amplitude"] .lock')], ["the map over another parameter", () => axis("map", "disc_radius")], ["the sweep", () => click('[data-tab="strip"]')],
    ["over another parameter", () => axis("strip", "disc_radius")], ["another device", () => choose("#subject", "device:soft-film")], ["its map over another parameter", () => { click('[data-tab="map"]'); }, () => axis("map", "disc_radius")], ["a set", () => choose("#subject", "preset:base")],
    ["two settings", () => click("#compare")], ["a value of the second", () => slide("frequency", 100, "onchange")], ["the first", () => click("#side-a")], ["its device", () => choose("#subject", "device:biased-pump")], ["the envelope", () => click('[data-tab="envelope"]')], ["its set", () => choose("#subject", "preset:other")],
  ]) {
    const steps = page.steps.length;
    for (const act of acts) await own.act(act);
    if (page.steps.length > steps + 1) done.push([`${what}, on the way`, null]);
    note(what);
  }
  for (const [what, before] of done.reverse()) {
    if (before) assert.deepEqual(seen(), before, what);
    await own.act(() => page.back());
  }
});

test("a studio that comes back with other devices offers those, and shows the first of them", async () => {
  const { $, answer, socket } = await open();
  answer();
  socket.close(); wait(300);
  const again = Socket.all.at(-1);
  again.open(); again.give({ ...HELLO, devices: ["new-pump"], presets: { newer: "a newer set" } });
  assert.deepEqual([$("subject").options.map((o) => o.value), $("subject").value, again.last.setting.device], [["device:new-pump", "preset:newer"], "device:new-pump", "new-pump"]);
});

test("a second setting is drawn as soon as it is there, and no more once it is left, before any answer", async () => {
  const { $, answer } = await open(), g = $("time").querySelector("canvas").getContext();
  answer();
  for (const there of [true, false]) {
    forget(g); $("compare").click();
    assert.deepEqual([g.calls.some((c) => c.strokeStyle === LIGHT.a), g.calls.some((c) => c.strokeStyle === LIGHT.b)], [true, there]);
  }
});

test("a file that was asked for before the connection was lost can be asked for again", async () => {
  const { $, answer, socket } = await open(), png = () => $("saver").querySelector('[data-format="png"]');
  answer(); $("save").click(); png().click();
  assert.equal(png().disabled, true);
  socket.close();
  assert.equal(png().disabled, false);
});

test("the error of a change stands at what was changed: set, set again, or reset", async () => {
  const { answer, socket, last } = await open(), wrong = () => document.querySelectorAll(".control").filter((row) => row.classList.has("wrong")).map((row) => row.dataset.name);
  answer();
  for (const act of [() => slide("frequency", 300, "onchange"), () => slide("frequency", 310, "onchange"), () => click('[data-name="frequency"] .reset')]) {
    act();
    socket.give({ kind: "error", id: last("look").id, side: "a", control: "voltage_amplitude", message: "voltage_amplitude: too high for that" });
    assert.deepEqual(wrong(), ["frequency"]);
    slide("frequency", 320, "onchange"); answer();
    assert.deepEqual(wrong(), []);
  }
});

test("an opened device has the name in its file, whichever side it is on", async () => {
  const { $, answer, socket } = await open("#file=first&b.file=second"), give = (side, name) => { $(`side-${side}`).click(); answer(RUN(), { name }); };
  give("a", "one"); give("b", "another");
  forget($("cone").getContext()); go(500); draw();
  assert.deepEqual(texts($("cone").getContext()).filter((text) => text.includes("scale")), ["A one, in its own scale", "B another, in its own scale"]);
});

test("whatever can be pressed, set or read has its own name", async () => {
  await open("#device=biased-pump", false);
  assert.match(readFileSync(new URL("index.html", STATIC), "utf8"), /<html lang="en">/); // the language in which it is read out
  const name = (e) => e.getAttribute("aria-label") ?? (document.querySelectorAll("label").find((own) => own.all().includes(e))?.querySelector("span")?.textContent || e.textContent);
  const names = (selector) => document.querySelectorAll(selector).filter((e) => e.id && e.id !== "address").map((e) => `${e.id}: ${name(e)}`);
  assert.deepEqual(names("header button, header select, header input"), ["subject: Device or preset", "browse: Gallery", "open: Open…", "file: Device file or measured curve", "unmeasure: Measured ×", "side-a: A", "side-b: B", "compare: Compare", "share: Copy link", "save: Save…", "theme: Light or dark"]);
  assert.deepEqual(names("main select, main input, main canvas, #play"), ["cone: The cone in cross-section and in perspective", "play: Pause", "scrub: Time in the run", "speed: Speed", "periods: Length of the run"]);
  assert.deepEqual(document.querySelectorAll("[role=\"tablist\"], [role=\"group\"], #film-legend").map((e) => e.getAttribute("aria-label")), ["Which setting the controls change", "Groups of parameters", "Colours of the film", "Part of the motion, here and in all plots", "Over time", "States", "Over parameters"]);
  assert.deepEqual(document.querySelectorAll('[role="status"], [role="alert"]').map((e) => e.id).filter(Boolean), ["notices", "lost", "general", "badges", "grid-share", "toast"]);
});

test("what is of the other of two settings leaves the controls and their errors as they are", async () => {
  const { socket, answer, last } = await open("#device=biased-pump&b.device=soft-film&side=b"), shown = () => [document.querySelectorAll(".wrong").map((row) => row.dataset.name), document.getElementById("speed").options.map((o) => o.textContent)];
  answer();
  const { id } = socket.sent.find(({ side }) => side === "a");
  slide("frequency", 300);
  socket.give({ kind: "error", id: last("look").id, side: "b", control: "frequency", message: "b is wrong" });
  const before = shown();
  assert.deepEqual(before[0], ["frequency"]);
  socket.give({ kind: "response", id, side: "a", about: ABOUT, words: { seems: "seems", ended: "", period: 7, shares: [{ code: 0, share: 1 }] } }, RUN());
  assert.deepEqual(shown(), before);
  document.querySelector('[data-tab="statics"]').click(); // asks for both
  const [a] = socket.sent.filter(({ side }) => side === "a").slice(-1);
  slide("frequency", 320); answer();
  socket.give({ kind: "error", id: a.id, side: "a", control: "voltage_amplitude", message: "a is wrong" });
  assert.deepEqual(shown()[0], []);
});

test("a drag over any picture goes on beyond its edge", async () => {
  const { act } = await attended("#device=biased-pump"), press = (canvas) => { for (const event of ["down", "up"]) canvas[`onpointer${event}`]({ clientX: 330, clientY: 220, pointerId: 5 }); return canvas.captured; };
  assert.equal(press(document.getElementById("cone")), 5); // on its gauge
  for (const view of ["time", "map", "strip", "envelope"]) {
    if (view !== "time") await act(() => click(`[data-tab="${view}"]`));
    assert.equal(press(document.querySelector(`#${view} canvas`)), 5, view);
  }
});

test("each part of the page has a name of its own, which its tabs share, and each tab its view", async () => {
  await open("#device=biased-pump", false);
  const label = (e) => e.getAttribute("aria-label"), panels = document.querySelectorAll(".panel[data-place]");
  for (const panel of panels) {
    const [list] = panel.querySelectorAll('[role="tablist"]'), tabs = panel.querySelectorAll('[role="tab"]'), views = panel.querySelectorAll(".view");
    assert.equal(label(list), label(panel));
    assert.deepEqual(views.map((view) => [view.dataset.view, view.id, view.getAttribute("role")]), tabs.map((tab) => [tab.dataset.tab, tab.dataset.tab, "tabpanel"]));
  }
  const names = ["section", "aside", "dialog", "canvas", "ul", "div", "span", "select", "input"].flatMap((tag) => document.querySelectorAll(tag)).filter((e) => label(e) && e.getAttribute("role") !== "tablist").map(label);
  assert.deepEqual(names.toSorted(), [...new Set(names)].sort());
});
