// The whole page with a server that the tests play: what it asks for, and where the answers go.
import assert from "node:assert/strict";
import test, { afterEach } from "node:test";
import { LIGHT, Socket, browser, draw, faults, forget, near, page, strokes, texts, wait } from "./page.js";

browser("#device=biased-pump&frequency=9+Hz");
let moment = 0;
globalThis.performance.now = () => moment;
await import("../../../src/gelcone/studio/static/main.js");
const [socket] = Socket.all, $ = (id) => document.getElementById(id);

const HERTZ = { Hz: 0, kHz: 3 }, VOLTS = { V: 0, kV: 3 };
const CONTROLS = [
  { name: "frequency", label: "Frequency", group: "Drive", kind: "number", value: 10, unit: "Hz", low: 0.1, high: 20, powers: HERTZ, about: "", choices: [] },
  { name: "voltage_amplitude", label: "Voltage amplitude", group: "Drive", kind: "number", value: 800, unit: "V", low: 0, high: 1600, powers: VOLTS, about: "", choices: [] },
  { name: "film", label: "Film", group: "Gel", kind: "choice", value: "taut", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["taut", "wrinkling"] },
];
const FILM = ["taut", "hoop slack", "meridian slack", "slack in both directions", "above breakdown", "near its stretch limit", "above membrane pull-in"];
const AXES = { time: "time (ms)", displacement: "height (mm)", velocity: "velocity (m/s)", voltage: "voltage (V)", constant: "constant voltage (V)", frequency: "frequency (Hz)", amplitude: "amplitude (mm)" };
const ABOUT = { axes: AXES, si: true, disc: 8, rim: 30, second: null, bias: "spring", film: FILM, wrinkles: false, film_of: "cone", name: "biased pump", strength: true, doubts: [] };
const HELLO = { kind: "hello", id: 1, version: "0", devices: ["biased-pump", "soft-film"], presets: { base: "the base set" }, regimes: [{ name: "rest", colour: "#777777" }, { name: "periodic", colour: "#0072b2" }, { name: "quasi-periodic", colour: "#009e73" }, { name: "chaotic", colour: "#d55e00" }] };
const RUN = () => ({ t: Float32Array.of(0, 50, 100), x: Float32Array.of(10, 20, 10), u: Float32Array.of(0, 1, 0), v: Float32Array.of(200, 1234, 200), film: Uint8Array.of(0, 4, 1) });
const asked = (kind) => socket.sent.filter((sent) => sent.kind === kind);
const last = (kind) => asked(kind).at(-1);

function answer(more = {}, arrays = RUN(), words = {}, list = CONTROLS) {
  const { id, side, controls } = last("look");
  if (controls) socket.give({ kind: "subject", id, side, controls: list, words: {} });
  socket.give({ kind: "response", id, side, about: ABOUT, words: { seems: "seems to repeat", ended: "", period: 100, shares: [{ code: 0, share: 0.4 }, { code: 1, share: 0.3 }, { code: 4, share: 0.3 }], ...words }, ...more }, arrays);
}

afterEach(() => assert.deepEqual(faults(), []));

test("the page says hello, and asks for what its address says", () => {
  socket.open();
  assert.deepEqual(socket.sent, [{ kind: "hello", id: 1 }]);
  assert.ok($("lost").hidden);
  socket.give(HELLO);
  const { id, ...look } = last("look");
  assert.deepEqual(look, { kind: "look", side: "a", setting: { device: "biased-pump", preset: null, file: null, values: { frequency: "9 Hz" } }, periods: 20, controls: true, panels: [] });
  assert.deepEqual($("subject").querySelectorAll("option").map((o) => o.value), ["device:biased-pump", "device:soft-film", "preset:base"]);
  assert.equal($("subject").value, "device:biased-pump");
});

test("an answer is drawn at once: curves, the cone, its number, the voltage in kilovolts, the badge", () => {
  answer();
  const time = $("time").querySelector("canvas").getContext(), portrait = $("portrait").querySelector("canvas").getContext();
  assert.ok(texts(time).includes("time (ms)") && texts(portrait).includes("velocity (m/s)"));
  draw(0);
  assert.ok(texts($("cone").getContext()).includes("10 mm") && texts($("cone").getContext()).includes("200 V"));
  $("scrub").value = "500"; $("scrub").oninput(); // in the middle of the run
  forget($("cone").getContext()); draw();
  assert.ok(texts($("cone").getContext()).includes("20 mm") && texts($("cone").getContext()).includes("1.23 kV"));
  assert.equal($("badges").querySelector(".kind").textContent, "Seems to repeat …");
  assert.equal(studio.painted, 1);
  assert.equal(document.querySelector('[data-name="frequency"] input').value, "9 Hz");
});

test("the legend of the film names the states that occur, each in the colour of the strip below the curve", () => {
  const items = $("film-legend").querySelectorAll("li").map((li) => [li.textContent, li.querySelector("i").style.background]);
  assert.deepEqual(items, [["film taut", LIGHT.taut], ["film hoop slack", LIGHT.around], ["film above breakdown", LIGHT.breakdown]]);
  const strip = $("time").querySelector("canvas").getContext().calls.filter((c) => c.name === "fillRect" && c.args[3] === 4).map((c) => c.fillStyle);
  assert.deepEqual([...new Set(strip)], [LIGHT.taut, LIGHT.breakdown, LIGHT.around]);
});

test("the legend has the states in their order, and a voltage below zero its unit", () => {
  answer({}, { ...RUN(), v: Float32Array.of(-200, -1234, -200) }, { shares: [{ code: 4, share: 0.5 }, { code: 0, share: 0.5 }] });
  assert.deepEqual($("film-legend").querySelectorAll("li").map((li) => li.textContent), ["film taut", "film above breakdown"]);
  forget($("cone").getContext()); draw();
  assert.ok(texts($("cone").getContext()).includes("−1.23 kV"));
  answer();
});

test("the evidence follows, with the section, and belongs to its look alone", () => {
  const { id } = last("look");
  socket.give({ kind: "kind", id, side: "a", words: { regime: 3, lines: ["chaotic", "by its exponent"], extent: [9, 21] } }, { px: Float32Array.of(12), pu: Float32Array.of(0.5) });
  assert.deepEqual([$("badges").querySelector(".kind").textContent, $("badges").querySelector(".kind").style.background, $("badges").querySelector(".evidence").textContent], ["Chaotic", "#d55e00", "by its exponent"]);
  assert.deepEqual([studio.looks.a.wanders, studio.looks.a.extent, [...studio.looks.a.px]], [true, [9, 21], [12]]);
  socket.give({ kind: "section", id, side: "a", words: {} }, { px: Float32Array.of(1, 2, 3), pu: Float32Array.of(4, 5, 6) });
  assert.deepEqual([[...studio.looks.a.px], [...studio.looks.a.pu]], [[1, 2, 3], [4, 5, 6]]);
  socket.give({ kind: "kind", id, side: "a", words: { regime: 1, lines: ["periodic, period 1"], extent: [9, 21] } }, {});
  assert.equal(studio.looks.a.wanders, false);
  socket.give({ kind: "kind", id, side: "b", words: { regime: 3, lines: ["chaotic"] } }, {}); // of a side that is not shown
  assert.equal(studio.looks.b, undefined);
});

test("each kind of motion has its name and colour, and all but rest and periodic ones wander", () => {
  const { id } = last("look"), badge = () => $("badges").querySelector(".kind");
  for (const [regime, { name, colour }] of HELLO.regimes.entries()) {
    socket.give({ kind: "kind", id, side: "a", words: { regime, lines: [name], extent: [9, 21] } }, {});
    assert.deepEqual([badge().textContent.toLowerCase(), badge().style.background, studio.looks.a.wanders], [name, colour, regime > 1]);
  }
  socket.give({ kind: "kind", id, side: "a", words: { regime: 1, lines: ["periodic, period 1"], extent: [9, 21] } }, {});
});

test("what is shown, the settled motion or the run, is pressed, is drawn, and stands in the address", () => {
  const { id } = last("look"), buttons = document.querySelectorAll("#motion button"), cone = $("cone").getContext();
  const settled = { ot: Float32Array.of(0, 50, 100), ox: Float32Array.of(33, 44, 33), ou: Float32Array.of(0, 0, 0), ov: Float32Array.of(1, 2, 1), ofilm: Uint8Array.of(0, 0, 0), px: Float32Array.of(33), pu: Float32Array.of(0) };
  socket.give({ kind: "kind", id, side: "a", words: { regime: 1, lines: ["periodic, period 1"], extent: [33, 44] } }, settled);
  for (const [motion, height] of [["start", "20 mm"], ["settled", "44 mm"]]) {
    buttons.find((b) => b.dataset.motion === motion).click();
    assert.deepEqual(buttons.map((b) => b.getAttribute("aria-pressed")), buttons.map((b) => String(b.dataset.motion === motion)));
    $("scrub").value = motion === "start" ? "500" : String(1000 * (50 / (20 * 100))); $("scrub").oninput();
    forget(cone); draw(); wait(300);
    assert.ok(texts(cone).includes(height), `${motion}: ${texts(cone)}`);
    assert.equal(/motion=start/.test(location.hash), motion === "start");
  }
  $("scrub").value = "500"; $("scrub").oninput();
});

test("of the tabs of a panel one can be reached by the keyboard: the selected one, whose view is shown", () => {
  for (const panel of document.querySelectorAll(".panel[data-place]")) {
    const tabs = panel.querySelectorAll('[role="tab"]'), first = tabs.find((t) => t.getAttribute("aria-selected") === "true");
    for (const chosen of [...tabs.filter((t) => !t.hidden), first]) {
      chosen.click();
      assert.deepEqual(tabs.map((t) => [t.getAttribute("aria-selected"), t.tabIndex]), tabs.map((t) => [String(t === chosen), t === chosen ? 0 : -1]));
      assert.deepEqual(panel.querySelectorAll(".view").filter((v) => v.classList.has("shown")).map((v) => v.dataset.view), [chosen.dataset.tab]);
    }
  }
  answer();
});

test("tabs ask for what they show, and its answer is drawn there", () => {
  document.querySelector('[data-tab="spectrum"]').click();
  assert.deepEqual(last("look").panels, ["spectrum"]);
  answer();
  const spectrum = $("spectrum").querySelector("canvas").getContext();
  forget(spectrum);
  socket.give({ kind: "spectrum", id: last("look").id, side: "a", words: { top: 72 } }, { frequency: Float32Array.of(0, 9, 18), amplitude: Float32Array.of(1, 5, 0.1), line: Float32Array.of(9), height: Float32Array.of(5) });
  assert.ok(texts(spectrum).includes("frequency (Hz)"));
  assert.deepEqual([[...studio.looks.a.spectrum.amplitude].slice(0, 2), studio.looks.a.spectrum.top], [[1, 5], 72]);
  document.querySelector('[data-tab="statics"]').click();
  assert.deepEqual(last("look").panels, ["spectrum", "statics"]);
  answer();
  const statics = $("statics").querySelector("canvas").getContext();
  forget(statics);
  socket.give({ kind: "statics", id: last("look").id, side: "a", words: { marks: { pull_in: 900 }, swing: [0, 800] } }, { voltage: Float32Array.of(0, 900), x: Float32Array.of(10, 20), stable: Uint8Array.of(1, 0) });
  assert.ok(texts(statics).includes("pull-in of the cone"));
  assert.match(location.hash, /top=spectrum&left=statics/);
  document.querySelector('[data-tab="time"]').click(); document.querySelector('[data-tab="portrait"]').click();
  assert.deepEqual(last("look").panels, []);
  assert.ok(!/top=|left=/.test(location.hash));
});

test("a slider asks at once, the address follows once the hand rests, and a released one is a step of the history", () => {
  answer();
  const slider = document.querySelector('[data-name="voltage_amplitude"] input[type="range"]') ?? document.querySelector('[data-name="voltage_amplitude"]').querySelectorAll("input")[1];
  const steps = page.steps.length;
  slider.value = "250"; slider.oninput();
  assert.deepEqual([last("look").setting.values, last("look").controls], [{ frequency: "9 Hz", voltage_amplitude: "400 V" }, false]);
  wait(300);
  assert.ok(!location.hash.includes("&voltage_amplitude=")); // it is not known yet whether the server takes it
  answer();
  assert.ok(!location.hash.includes("&voltage_amplitude="));
  wait(300);
  assert.ok(location.hash.includes("&voltage_amplitude=400+V"));
  assert.equal(page.steps.length, steps);
  slider.value = "500"; slider.onchange();
  assert.equal(page.steps.length, steps);
  answer();
  assert.equal(page.steps.length, steps + 1);
  assert.ok(page.steps.at(-1).includes("voltage_amplitude=800+V"));
});

test("a choice asks for the controls too, and reset takes all back", () => {
  const film = document.querySelector('[data-name="film"] select') ?? document.querySelector("select#c-film");
  film.value = "wrinkling"; film.onchange();
  assert.deepEqual([last("look").controls, last("look").setting.values.film], [true, "wrinkling"]);
  answer();
  $("reset-all").click();
  assert.deepEqual(last("look").setting.values, {});
  assert.equal(last("look").controls, true);
});

test("what only another choice has goes with it", () => {
  answer();
  const film = document.querySelector('[data-name="film"] select') ?? document.querySelector("select#c-film");
  const field = document.querySelector('[data-name="frequency"]').querySelectorAll("input")[0];
  field.value = "9"; field.onchange(); answer();
  film.value = "wrinkling"; film.onchange();
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "frequency", message: "'frequency': is not a control of this subject" });
  assert.deepEqual(last("look").setting.values, { film: "wrinkling" });
  $("reset-all").click(); answer();
});

test("a wrong entry stands next to its reason, the picture is faded, and neither history nor link nor later looks have it", () => {
  answer();
  const before = studio.looks.a.x, steps = page.steps.length, field = document.querySelector('[data-name="frequency"]').querySelectorAll("input")[0];
  const error = document.querySelector('[data-name="frequency"] .error'), old = () => document.body.classList.contains("old");
  field.value = "-9"; field.onchange();
  const { id } = last("look");
  assert.equal(last("look").setting.values.frequency, "-9 Hz");
  socket.give({ kind: "error", id, side: "a", control: "frequency", message: "frequency = -9 Hz: must be positive" });
  assert.deepEqual([error.hidden, error.firstChild.textContent, studio.looks.a.x, field.value, old()], [false, "frequency = −9 Hz: must be positive", before, "−9 Hz", true]);
  wait(300);
  assert.ok(page.steps.length === steps && !location.hash.includes("-9"));
  const slider = document.querySelector('[data-name="voltage_amplitude"]').querySelectorAll("input")[1];
  slider.value = "250"; slider.oninput();
  assert.deepEqual(last("look").setting.values, { voltage_amplitude: "400 V" });
  answer();
  assert.deepEqual([error.hidden, field.value, old()], [true, "10 Hz", false]);
  $("reset-all").click(); answer();
});

test("a cleared entry comes back, also a wrong one that still has the cursor", () => {
  const field = document.querySelector('[data-name="frequency"]').querySelectorAll("input")[0];
  field.focus(); field.value = "nonsense"; field.onchange();
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "frequency", message: "frequency = 'nonsense': must be one number, with its unit" });
  field.value = " "; field.onchange();
  assert.equal(field.value, "10 Hz");
  answer();
  assert.ok(document.querySelector('[data-name="frequency"] .error').hidden);
});

test("an error of two numbers stands at the one that was changed", () => {
  const field = document.querySelector('[data-name="voltage_amplitude"]').querySelectorAll("input")[0];
  field.value = "9 kV"; field.onchange();
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "frequency", message: "frequency: is too high for this amplitude" });
  assert.ok(!document.querySelector('[data-name="voltage_amplitude"] .error').hidden && document.querySelector('[data-name="frequency"] .error').hidden);
  $("reset-all").click(); answer();
});

test("what is computed is said once it takes a while, with the picture faded until its answer", () => {
  const slider = document.querySelector('[data-name="frequency"]').querySelectorAll("input")[1];
  slider.value = "100"; slider.oninput();
  assert.equal($("doing").textContent, "");
  wait(400);
  assert.match($("doing").textContent, /^Computing the run: 20 periods at frequency 2.09 Hz/);
  assert.ok(document.body.classList.contains("old"));
  answer();
  assert.deepEqual([$("doing").textContent, document.body.classList.contains("old")], ["", false]);
  $("reset-all").click(); answer();
});

test("numbers come with the kind, others once the hand rests, and those of an older setting are pale", () => {
  answer();
  const { id } = last("look"), stroke = { name: "stroke", place: 0, text: "14.7 mm", value: 14.7 }, current = { name: "current", place: 3, text: "79 uA", value: 0.079 };
  const shown = () => $("badges").querySelectorAll(".number").map((own) => [own.textContent, own.className]);
  socket.give({ kind: "kind", id, side: "a", words: { regime: 1, lines: ["periodic, period 1"], extent: [9, 21], numbers: [stroke] } }, {});
  socket.give({ kind: "numbers", id, side: "a", words: { numbers: [current] } });
  assert.deepEqual(shown(), [["stroke 14.7 mm", "number"], ["current 79 µA", "number"]]);
  answer();
  assert.deepEqual(shown().map(([, name]) => name), ["number old", "number old"]);
  socket.give({ kind: "kind", id, side: "a", words: { regime: 0, lines: ["rest"], extent: [9, 9], numbers: [{ ...stroke, text: "0 mm" }] } }, {});
  assert.deepEqual(shown(), [["stroke 0 mm", "number"], ["current 79 µA", "number old"]]);
});

test("a cone that stands for a membrane says so, and the pull-in of one film takes the place of the other's", () => {
  const said = () => $("badges").querySelector(".valid").textContent, shown = () => $("badges").querySelectorAll(".number").map((own) => own.textContent);
  const pullIn = (film, text) => socket.give({ kind: "numbers", id: last("look").id, side: "a", words: { numbers: [{ name: `static pull-in of the ${film}`, place: 6, text, value: 600, peak: 0.5 }] } });
  answer();
  pullIn("cone", "2.49 kV");
  answer({ about: { ...ABOUT, stands: true } }, RUN(), { shares: [{ code: 0, share: 1 }] });
  assert.equal(said(), "a cone is shown until the membrane is computed: the model holds: film taut throughout");
  assert.equal($("badges").querySelector(".valid").className.includes("no"), true);
  socket.give({ kind: "late", id: last("look").id, side: "a", stage: "film", message: "too close" });
  assert.match(said(), /^too close: /);
  answer({ about: { ...ABOUT, film_of: "membrane" } }, RUN(), { shares: [{ code: 0, share: 1 }] });
  assert.equal(said(), "the model holds: film taut throughout");
  pullIn("membrane", "2.14 kV");
  assert.deepEqual(shown().filter((text) => text.includes("pull-in")), ["static pull-in of the membrane 2.14 kV"]);
});

test("a motion that pulls in plays once, holds at its end, and offers a lower voltage", () => {
  answer({}, { ...RUN(), x: Float32Array.of(10, 5, 1) }, { ended: "pulled in", seems: "the film pulls in after 100 ms" });
  socket.give({ kind: "numbers", id: last("look").id, side: "a", words: { numbers: [{ name: "static pull-in of the cone", place: 6, text: "600 V", value: 600, peak: 1.25 }] } });
  $("scrub").value = "0"; $("scrub").oninput();
  $("play").click();
  for (let k = 0; k < 60; k++) { draw(); wait(50); }
  assert.deepEqual([$("scrub").value, $("play").getAttribute("aria-label")], ["1000", "Play"]);
  const offer = $("badges").querySelectorAll(".numbers button").find((own) => own.textContent === "lower the voltage");
  offer.click();
  assert.deepEqual(last("look").setting.values, { voltage_amplitude: "544 V" }); // 0.85 of what pulls in: 0.85/1.25 of 800 V
  answer();
  assert.equal($("badges").querySelectorAll(".numbers button").length, 0);
  $("reset-all").click(); answer();
  $("scrub").value = "500"; $("scrub").oninput();
});

test("where a motion ends though its peak is below pull-in, the voltage is lowered by itself", () => {
  answer({}, { ...RUN(), x: Float32Array.of(10, 5, 1) }, { ended: "pulled in", seems: "the film pulls in after 100 ms" });
  socket.give({ kind: "numbers", id: last("look").id, side: "a", words: { numbers: [{ name: "static pull-in of the cone", place: 6, text: "2 kV", value: 2000, peak: 0.4 }] } });
  $("badges").querySelectorAll(".numbers button").find((own) => own.textContent === "lower the voltage").click();
  assert.deepEqual(last("look").setting.values, { voltage_amplitude: "680 V" }); // 0.85 of its own 800 V
  answer();
  $("reset-all").click(); answer();
  $("scrub").value = "500"; $("scrub").oninput();
});

test("evidence that takes too long is given up in words, and the first impression stays", () => {
  answer();
  studio.looks.a.numbers.set("stroke", { name: "stroke", place: 0, text: "9 mm", value: 9, old: true }); // of the setting before
  socket.give({ kind: "late", id: last("look").id, side: "a", stage: "kind", message: "the evidence takes more than 30 s" });
  assert.match($("badges").querySelector(".evidence").textContent, /first impression: the evidence takes more than 30 s/);
  assert.ok(!studio.looks.a.numbers.has("stroke"));
});

test("where no settled motion is found its button says why, and the run from the start is lit until one is", () => {
  const [settled, start] = ["settled", "start"].map((name) => $("motion").querySelector(`[data-motion="${name}"]`));
  const lit = () => [settled, start].map((button) => button.getAttribute("aria-pressed"));
  answer();
  assert.deepEqual([lit(), settled.disabled, settled.title], [["true", "false"], false, ""]);
  socket.give({ kind: "late", id: last("look").id, side: "a", stage: "kind", message: "the drive does not repeat" });
  assert.deepEqual([lit(), settled.disabled, settled.title], [["false", "true"], true, "the drive does not repeat"]);
  answer();
  assert.deepEqual([lit(), settled.disabled, settled.title], [["true", "false"], false, ""]);
});

test("the length of a run is asked for as a number", () => {
  $("periods").value = "60"; $("periods").onchange();
  assert.equal(last("look").periods, 60);
  assert.ok(location.hash.includes("periods=60"));
  $("periods").value = "20"; $("periods").onchange();
});

// --- a device with more to set ---------------------------------------------------------------------------------------

const MORE = [
  ...CONTROLS,
  { name: "voltage_offset", label: "Voltage offset", group: "Drive", kind: "number", value: -200, unit: "V", low: -1600, high: 1600, powers: VOLTS, about: "", choices: [] },
  { name: "release_height", label: "Release height", group: "Start", kind: "number", value: null, unit: "cm", low: 0, high: 4, powers: { m: 0, cm: -2, mm: -3 }, about: "", choices: [] },
  { name: "release_velocity", label: "Release velocity", group: "Start", kind: "number", value: 0, unit: "m/s", low: -1, high: 1, powers: { "m/s": 0 }, about: "", choices: [] },
];
const numbers = (...own) => socket.give({ kind: "numbers", id: last("look").id, side: "a", words: { numbers: own } });
const input = (name) => document.querySelector(`[data-name="${name}"]`).querySelectorAll("input")[0];
const at = (x, y) => ({ clientX: 10 + x, clientY: 20 + y, pointerId: 1, type: "pointermove" });

test("the voltage is lowered in all its parts, but for one that is locked", () => {
  $("subject").value = "device:soft-film"; $("subject").onchange();
  answer({}, { ...RUN(), x: Float32Array.of(10, 5, 1) }, { ended: "pulled in", seems: "the film pulls in after 100 ms" }, MORE);
  numbers({ name: "static pull-in of the cone", place: 6, text: "800 V", value: 800, peak: 1.25 });
  const offer = () => $("badges").querySelectorAll(".numbers button").find((own) => own.textContent === "lower the voltage");
  $("scrub").value = "500"; $("scrub").oninput();
  offer().click();
  assert.deepEqual(last("look").setting.values, { voltage_amplitude: "544 V", voltage_offset: "-136 V" });
  draw(); // the run is played from its start
  assert.deepEqual([Number($("scrub").value) < 100, $("play").getAttribute("aria-label")], [true, "Pause"]);
  $("reset-all").click();
  const lock = document.querySelector('[data-name="voltage_offset"] .lock');
  lock.click();
  offer().click();
  assert.deepEqual(last("look").setting.values, { voltage_amplitude: "544 V" });
  lock.click();
  $("reset-all").click(); answer();
});

test("a hand that takes the disc starts the run where it lets it go, at rest, in the unit of the control", () => {
  const canvas = $("cone"), x = 640 / 4;
  $("scrub").value = "500"; $("scrub").oninput(); draw(); // the disc is at 20 mm
  const place = Array.from({ length: 480 }, (_, y) => y).find((y) => { canvas.onpointermove(at(x, y)); return canvas.style.cursor === "ns-resize"; });
  const pulled = (pixels) => {
    canvas.onpointerdown(at(x, place + 12)); canvas.onpointermove(at(x, place + 12 - pixels));
    const { values } = last("look").setting;
    assert.deepEqual([Object.keys(values), values.release_velocity], [["release_height", "release_velocity"], "0 m/s"]);
    assert.match(values.release_height, / cm$/);
    assert.equal($("play").getAttribute("aria-label"), "Play"); // it stands while the hand holds it, and starts when it lets go
    return Number.parseFloat(values.release_height);
  };
  const [one, two] = [pulled(20), pulled(40)];
  assert.ok(near(2 * one - two, 2, 1e-3) && two > one); // without a pull 2 cm
  canvas.onpointerup({ ...at(x, place + 12 - 40), type: "pointerup" });
  assert.equal($("play").getAttribute("aria-label"), "Pause");
  $("play").click();
  assert.ok(document.querySelectorAll("#motion button").some((b) => b.dataset.motion === "start" && b.getAttribute("aria-pressed") === "true"));
  document.querySelectorAll("#motion button").find((b) => b.dataset.motion === "settled").click();
  $("reset-all").click(); answer();
});

test("behind the disc are the heights of the period before, as far as there are any", () => {
  const trail = (scrub) => { $("scrub").value = scrub; $("scrub").oninput(); forget($("cone").getContext()); draw(); return $("cone").getContext().calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.accent && c.args[3] === 2); };
  assert.equal(trail("0").length, 0);
  const half = trail("500"); // in the middle of a run of one period: it rose from 10 to 20 mm
  assert.equal(half.length, 12);
  const heights = half.map((c) => c.args[1]), steps = heights.slice(1).map((y, k) => y - heights[k]);
  assert.ok(steps.every((step) => step > 0 && near(step, steps[0])));
  assert.equal(trail("1000").length, 24);
  const falling = trail("750").map((c) => c.args[1]); // falls through 15 mm: just before, the disc was higher
  assert.ok(falling[1] < falling[0]);
  $("scrub").value = "500"; $("scrub").oninput();
});

// The gauge stands in the middle of a page 640 px wide, between its margins.
const GAUGE = { x: (640 - 46) / 2 + 46 / 2, top: 22, bottom: 480 - 24 };

test("the gauge reaches from zero to the highest voltage of the motion, where all are above it", () => {
  for (const [scrub, volts] of [["0", 200], ["500", 1234]]) {
    $("scrub").value = scrub; $("scrub").oninput(); forget($("cone").getContext()); draw();
    const [, y, , high] = $("cone").getContext().calls.find((c) => c.name === "roundRect" && c.fillStyle === LIGHT.accent).args;
    assert.ok(near(y + high, GAUGE.bottom) && near(high, ((GAUGE.bottom - GAUGE.top) * volts) / 1234, 1e-4), `${volts} V`);
  }
});

test("a hand on the gauge scales the voltages that were set when it took hold, however often it moves", () => {
  const canvas = $("cone"), go = (type, share) => canvas[`on${type}`]({ ...at(GAUGE.x, GAUGE.bottom - share * (GAUGE.bottom - GAUGE.top)), type });
  for (const [amplitude, offset] of [[800, -200], [400, -100]]) {
    go("pointerdown", 1);
    for (const [type, share] of [["pointermove", 0.9], ["pointermove", 0.75], ["pointermove", 0.5], ["pointerup", 0.5]]) {
      go(type, share);
      assert.deepEqual(last("look").setting.values, { voltage_amplitude: `${share * amplitude} V`, voltage_offset: `${share * offset} V` });
    }
    answer();
  }
  $("reset-all").click(); answer();
});

test("a hand on the disc or on the gauge is one step of the history, where it lets go", () => {
  const canvas = $("cone"), go = (type, x, y) => canvas[`on${type}`]({ ...at(x, y), type });
  answer({}, RUN(), {}, MORE);
  $("scrub").value = "500"; $("scrub").oninput(); draw();
  const disc = Array.from({ length: 480 }, (_, y) => y).find((y) => { canvas.onpointermove(at(640 / 4, y)); return canvas.style.cursor === "ns-resize"; });
  for (const [x, y] of [[640 / 4, disc + 12], [GAUGE.x, GAUGE.top]]) {
    const steps = page.steps.length;
    go("pointerdown", x, y);
    for (const [type, moved, more] of [["pointermove", 20, 0], ["pointermove", 40, 0], ["pointerup", 60, 1]]) {
      const before = asked("look").length;
      go(type, x, y + moved); answer({}, RUN(), {}, MORE); wait(300);
      assert.deepEqual([asked("look").length, page.steps.length], [before + 1, steps + more], `${x} ${type}`);
    }
  }
  document.querySelectorAll("#motion button").find((b) => b.dataset.motion === "settled").click();
  $("reset-all").click(); answer({}, RUN(), {}, MORE);
});

test("what stands over a picture moves with the time, in the panel that is open", () => {
  for (const [tab, place] of [["portrait", (p) => [p.X(studio.looks.a.x[1]), p.Y(1)]], ["statics", null]]) {
    document.querySelector(`[data-tab="${tab}"]`).click(); answer();
    if (tab === "statics") socket.give({ kind: "statics", id: last("look").id, side: "a", words: { marks: {}, swing: [0, 1300] } }, { voltage: Float32Array.of(0, 1400), x: Float32Array.of(10, 20), stable: Uint8Array.of(1, 1) });
    const places = ["0", "250", "500"].map((scrub) => { $("scrub").value = scrub; $("scrub").oninput(); draw(); return $(tab).querySelector(".dot").style.transform.match(/-?[\d.]+/g).map(Number); });
    // from 10 mm and 200 V through the middle to 20 mm and 1234 V
    assert.ok(places[2][0] > places[0][0] + 50 && [0, 1].every((k) => near(places[1][k], (places[0][k] + places[2][k]) / 2, 2e-3)), tab);
  }
  document.querySelector('[data-tab="portrait"]').click(); answer();
});

test("pictures follow each other as fast as a map that is computed leaves room for", () => {
  const paces = (running) => {
    const panel = document.querySelector('.panel[data-place="right"]').querySelectorAll('[role="tab"]').find((t) => t.dataset.tab === "map");
    panel.click();
    if (!running) { socket.give({ kind: "done", id: last("map").id }); socket.give({ kind: "followed", id: last("map").id }); }
    $("scrub").value = "0"; $("scrub").oninput(); $("play").click();
    moment += 1000; draw();
    const { wait: pace } = page.timers.findLast((timer) => timer);
    $("play").click();
    return pace;
  };
  const film = document.querySelector("select#c-film");
  film.value = "wrinkling"; film.onchange(); answer(); wait(500); // a map of another film
  assert.deepEqual([paces(true), paces(false)], [38, 22]);
  $("reset-all").click(); answer();
  $("scrub").value = "500"; $("scrub").oninput();
});

test("a height that is nothing but rounding is said to be none", () => {
  answer({}, { ...RUN(), x: Float32Array.of(-1e-6, 1e-6, -1e-6) });
  forget($("cone").getContext()); draw();
  assert.ok(texts($("cone").getContext()).includes("0 mm"));
  answer();
});

test("two films have states of their own, and after them one film none", () => {
  answer({ about: { ...ABOUT, second: 30 } }, { ...RUN(), film1: Uint8Array.of(0, 0, 0), film2: Uint8Array.of(1, 1, 1) });
  assert.deepEqual([[...studio.looks.a.film1], [...studio.looks.a.film2]], [[0, 0, 0], [1, 1, 1]]);
  answer();
  assert.deepEqual([studio.looks.a.film1, studio.looks.a.film2], [undefined, undefined]);
});

test("of the numbers of an older setting the kind of motion leaves none that it has itself", () => {
  const { id } = last("look"), names = () => [...studio.looks.a.numbers.keys()].filter((name) => !name.includes("pull-in")).sort();
  const all = ["stroke", "mean height", "lag", "field", "power"].map((name, place) => ({ name, place, text: "1", value: 1 }));
  socket.give({ kind: "kind", id, side: "a", words: { regime: 1, lines: ["periodic, period 1"], extent: [9, 21], numbers: all } }, {});
  answer();
  socket.give({ kind: "kind", id: last("look").id, side: "a", words: { regime: 0, lines: ["rest"], extent: [9, 9], numbers: [all[0]] } }, {});
  assert.deepEqual(names(), ["power", "stroke"]);
});

test("why a part of what follows is missing stands where that part would, and not that of an older setting", () => {
  for (const [tab, stage] of [["spectrum", "spectrum"], ["statics", "statics"]]) {
    document.querySelector(`[data-tab="${tab}"]`).click(); answer();
    const own = $(tab).querySelector("canvas").getContext();
    forget(own);
    socket.give({ kind: "late", id: last("look").id, side: "a", stage, message: `no ${stage} here` });
    assert.ok(texts(own).includes(`no ${stage} here`), tab);
    forget(own); answer();
    assert.ok(!texts(own).includes(`no ${stage} here`), tab);
  }
  document.querySelector('[data-tab="time"]').click(); document.querySelector('[data-tab="portrait"]').click();
  answer();
});

test("a choice that is refused itself is taken back, with the reason next to it", () => {
  const film = document.querySelector('[data-name="film"] select') ?? document.querySelector("select#c-film");
  film.value = "wrinkling"; film.onchange();
  const before = asked("look").length;
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "film", message: "film: needs a gel with a law" });
  assert.equal(asked("look").length, before);
  assert.deepEqual([document.querySelector('[data-name="film"] .error').hidden, document.querySelector('[data-name="film"] .error').firstChild.textContent], [false, "film: needs a gel with a law"]);
  $("reset-all").click(); answer();
});

test("the newest three sentences stay until they are put away", async () => {
  $("notices").replaceChildren();
  $("file").files = ["a", "b", "c", "d"].map((name) => ({ name: `${name}.toml`, size: 30001, text: async () => "" }));
  await $("file").onchange();
  assert.deepEqual($("notices").parts.map((line) => line.textContent.slice(0, 6)), ["b.toml", "c.toml", "d.toml"]);
  $("notices").parts[1].querySelectorAll("button").at(-1).click();
  assert.equal($("notices").parts.length, 2);
  $("notices").replaceChildren();
});

test("of two settings the one that is shown is kept", () => {
  $("compare").click(); answer();
  input("frequency").value = "7"; input("frequency").onchange(); answer();
  assert.deepEqual([last("look").side, last("look").setting.values], ["b", { frequency: "7 Hz" }]);
  $("compare").click();
  assert.deepEqual([last("look").side, last("look").setting.values], ["a", { frequency: "7 Hz" }]);
  answer(); wait(300);
  assert.ok(location.hash.includes("&frequency=7+Hz") && !location.hash.includes("b."));
  $("subject").value = "device:biased-pump"; $("subject").onchange(); answer();
});

test("two settings are asked for and shown each on its side, and one is kept", () => {
  answer();
  $("compare").click();
  assert.deepEqual([last("look").side, $("sides").hidden, $("side-b").getAttribute("aria-pressed")], ["b", false, "true"]);
  assert.deepEqual([...studio.looks.b.x], [10, 20, 10]); // at first that of the other side
  answer({}, { ...RUN(), x: Float32Array.of(1, 2, 1) });
  assert.deepEqual([[...studio.looks.a.x], [...studio.looks.b.x]], [[10, 20, 10], [1, 2, 1]]);
  assert.equal($("badges").querySelectorAll(".badge").length, 2);
  forget($("cone").getContext()); draw();
  assert.ok(texts($("cone").getContext()).some((text) => text.startsWith("2 mm, ")));
  document.querySelector('[data-name="frequency"]').querySelectorAll("input")[1].value = "1000";
  document.querySelector('[data-name="frequency"]').querySelectorAll("input")[1].onchange();
  answer();
  assert.deepEqual([last("look").side, last("look").setting.values.frequency], ["b", "20 Hz"]);
  assert.ok(location.hash.includes("b.frequency=20+Hz"));
  $("side-a").click();
  assert.deepEqual([last("look").side, last("look").setting.values], ["a", {}]);
  $("compare").click();
  assert.deepEqual([studio.looks.b, $("sides").hidden, $("badges").querySelectorAll(".badge").length], [undefined, true, 1]);
});

test("of two settings the cone says which is which, their differences stay with another theme, and the page knows the one that is changed", () => {
  const stroke = (value) => ({ kind: "kind", id: last("look").id, side: last("look").side, words: { regime: 1, lines: ["periodic, period 1"], extent: [9, 21], numbers: [{ name: "stroke", place: 0, text: `${value} mm`, value }] } });
  $("subject").value = "device:soft-film"; $("subject").onchange(); answer(); studio.looks.a.numbers.clear();
  $("subject").value = "device:biased-pump"; $("subject").onchange(); answer(); socket.give(stroke(10), {});
  $("compare").click(); answer(); socket.give(stroke(12), {});
  const numbers = () => $("badges").querySelectorAll(".numbers").map((own) => own.textContent), shown = ["stroke 10 mm", "stroke 12 mm (+20 %)"];
  assert.deepEqual(numbers(), shown);
  page.media["(prefers-color-scheme: dark)"].onchange(); // draws all anew
  assert.deepEqual(numbers(), shown);
  $("subject").value = "device:soft-film"; $("subject").onchange(); answer();
  forget($("cone").getContext()); draw();
  for (const text of ["A biased-pump, in its own scale", "B soft-film, in its own scale"]) assert.ok(texts($("cone").getContext()).includes(text), text);
  for (const side of ["a", "b", "a"]) {
    $(`side-${side}`).click();
    assert.deepEqual([document.body.classList.contains("b"), ...["a", "b"].map((own) => $(`side-${own}`).getAttribute("aria-pressed"))], [side === "b", String(side === "a"), String(side === "b")]);
  }
  $("compare").click(); answer();
  assert.equal(document.body.classList.contains("b"), false);
});

test("a way taken again after going back is a step again", () => {
  const tabs = ["spectrum", "time"].map((name) => document.querySelector(`[data-tab="${name}"]`)), before = location.hash, begun = page.steps.length;
  tabs[0].click(); answer();
  location.hash = before; page.listeners.popstate(); answer();
  tabs[0].click(); answer();
  assert.equal(page.steps.length - begun, 2);
  tabs[1].click(); answer();
});

test("what a map shows is a step of the history and part of the link", () => {
  const view = $("map").querySelectorAll("select").find((own) => own.options.some((o) => o.value === "exponent")), begun = page.steps.length;
  for (const [name, written] of [["exponent", true], ["stroke", true], ["kind", false]]) {
    view.value = name; view.onchange();
    assert.equal(new URLSearchParams(location.hash.slice(1)).get("view"), written ? name : null);
  }
  assert.equal(page.steps.length - begun, 3);
});

test("a step of the history is one change of what is shown: none is added for what stands there already", () => {
  const tabs = ["spectrum", "time"].map((name) => document.querySelector(`[data-tab="${name}"]`)), begun = page.steps.length;
  const clicked = (k) => { tabs[k].click(); answer(); return page.steps.length - begun; };
  assert.deepEqual([0, 0, 1, 1, 0].map(clicked), [1, 1, 2, 2, 3]);
  assert.equal(new Set(page.steps.slice(begun)).size, 2);
  $("periods").onchange(); // the same again
  assert.equal(page.steps.length - begun, 3);
  clicked(1);
});

test("the arrow keys go round the tabs that are there, and other keys stay with the page", () => {
  const panel = document.querySelector('.panel[data-place="right"]'), tabs = panel.querySelectorAll('[role="tab"]'), chosen = () => tabs.find((t) => t.getAttribute("aria-selected") === "true");
  for (const [subject, open] of [["preset:base", ["map", "strip"]], ["device:biased-pump", ["map", "strip", "envelope"]]]) {
    $("subject").value = subject; $("subject").onchange(); answer({ about: { ...ABOUT, si: !subject.startsWith("preset") } });
    tabs[0].click();
    for (const [key, step] of [["ArrowRight", 1], ["ArrowLeft", -1], ["Enter", 0]]) for (let k = 0, place = open.indexOf(chosen().dataset.tab); k < 4; k++) {
      chosen().onkeydown({ key });
      place = (place + step + open.length) % open.length;
      assert.deepEqual([chosen().dataset.tab, !step || document.activeElement === chosen()], [open[place], true], `${subject} ${key}`);
    }
    tabs[0].click();
  }
});

test("another subject starts anew, and only a device has an envelope", () => {
  const tab = document.querySelector('[data-tab="envelope"]'), selected = () => document.querySelector('.panel[data-place="right"]').querySelectorAll('[role="tab"]').find((t) => t.getAttribute("aria-selected") === "true").dataset.tab;
  assert.equal(tab.hidden, false);
  tab.click();
  assert.equal(selected(), "envelope");
  $("subject").value = "preset:base"; $("subject").onchange();
  assert.deepEqual(last("look").setting, { device: null, preset: "base", file: null, values: {} });
  answer({ about: { ...ABOUT, si: false, axes: { ...AXES, time: "time", displacement: "displacement" } } }, { ...RUN(), v: Float32Array.of(0, 0.5, 0) });
  assert.deepEqual([tab.hidden, selected()], [true, "map"]);
  forget($("cone").getContext()); draw();
  assert.ok(texts($("cone").getContext()).includes("0.50"));
  $("subject").value = "device:soft-film"; $("subject").onchange();
  assert.deepEqual(last("look").setting.device, "soft-film");
  answer();
  assert.equal(tab.hidden, false);
});

test("what is computed is said with the frequency of the drive, of a device and of a preset", () => {
  const preset = CONTROLS.map((c) => (c.name === "frequency" ? { ...c, name: "drive_frequency", label: "Drive frequency", unit: "", value: 0.5, powers: { "": 0 } } : c));
  for (const [subject, list, text] of [["preset:base", preset, "at drive frequency 0.5 …"], ["device:soft-film", CONTROLS, "at frequency 10 Hz …"]]) {
    $("subject").value = subject; $("subject").onchange();
    wait(400);
    assert.match($("doing").textContent, /^Reading the device/);
    answer({}, RUN(), {}, list);
    $("periods").value = "60"; $("periods").onchange();
    wait(400);
    assert.equal($("doing").textContent, `Computing the run: 60 periods ${text}`);
    $("periods").value = "20"; $("periods").onchange(); answer();
  }
});

test("of many files the first six are read", async () => {
  const read = [];
  $("file").files = Array.from({ length: 9 }, (_, k) => ({ name: `${k}.csv`, size: 30, text: async () => { read.push(k); return "time (ms),height (mm)\n0,5\n1,6\n"; } }));
  await $("file").onchange();
  for (let k = 0; k < 9; k++) await new Promise((done) => setImmediate(done));
  assert.deepEqual([read, studio.looks.measured.map((own) => own.name)], [[0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 5].map((k) => `${k}.csv`)]);
  $("unmeasure").click();
});

test("a file is opened and sent as text; one that is too large is not", async () => {
  $("file").files = [{ name: "mine.toml", size: 20, text: async () => "disc_radius = 1" }];
  await $("file").onchange();
  assert.deepEqual(last("look").setting, { device: null, preset: null, file: "disc_radius = 1", values: {} });
  answer({ about: { ...ABOUT, name: "my own pump" } });
  assert.equal($("subject").value, "file:");
  assert.equal($("subject").querySelectorAll("option").find((o) => o.value === "file:").textContent, "my own pump");
  const before = asked("look").length;
  $("file").files = [{ name: "huge.toml", size: 30001, text: async () => "" }];
  await $("file").onchange();
  assert.equal(asked("look").length, before);
  assert.match($("notices").textContent, /huge.toml: has more than 30000 characters/);
});

test("a measured curve opens the tab over which it is drawn", async () => {
  const selected = (place) => document.querySelector(`.panel[data-place="${place}"]`).querySelectorAll('[role="tab"]').find((t) => t.getAttribute("aria-selected") === "true").dataset.tab;
  for (const [over, place, other, own] of [["time (ms)", "top", "spectrum", "time"], ["voltage (V)", "left", "portrait", "statics"]]) {
    document.querySelector(`[data-tab="${other}"]`).click(); answer();
    $("file").files = [{ name: "m.csv", size: 40, text: async () => `${over},height (mm)\n0,5\n1,6\n` }];
    await $("file").onchange();
    await new Promise((done) => setImmediate(done));
    assert.equal(selected(place), own);
    answer();
  }
  assert.equal($("unmeasure").hidden, false);
  $("unmeasure").click();
  assert.equal($("unmeasure").hidden, true);
  document.querySelector('[data-tab="portrait"]').click(); answer();
});

test("a file that is no device leaves what is shown, and says why", async () => {
  const hash = location.hash;
  $("file").files = [{ name: "bad.toml", size: 20, text: async () => "disc_radius = 1" }];
  $("subject").value = "device:soft-film"; $("subject").onchange(); answer();
  await $("file").onchange();
  socket.give({ kind: "error", id: last("look").id, side: "a", control: "file", message: "the device file, line 1: disc_radius = 1: needs a unit" });
  assert.match($("notices").textContent, /line 1: disc_radius = 1: needs a unit/);
  assert.equal($("subject").value, "device:soft-film");
  assert.ok(!location.hash.includes("file=") && location.hash !== hash);
  $("periods").value = "60"; $("periods").onchange();
  assert.deepEqual(last("look").setting, { device: "soft-film", preset: null, file: null, values: {} });
  $("periods").value = "20"; $("periods").onchange(); answer();
});

test("files are asked for with what is shown, and saved under the server's name", () => {
  $("subject").value = "device:biased-pump"; $("subject").onchange();
  answer();
  $("save").click();
  const { id, ...code } = last("code");
  assert.deepEqual(code, { kind: "code", setting: { device: "biased-pump", preset: null, file: null, values: {} }, what: "simulate", options: { periods: 20 } });
  socket.give({ kind: "code", id, command: "gelcone simulate", python: "import gelcone" });
  assert.deepEqual($("saver").querySelectorAll("pre").map((e) => e.textContent), ["gelcone simulate", "import gelcone"]);
  const button = (form) => $("saver").querySelector(`[data-format="${form}"]`);
  button("png").click();
  assert.deepEqual([last("export").format, last("export").what, button("nc").disabled], ["png", "simulate", true]);
  globalThis.URL.createObjectURL = () => "blob:1"; globalThis.URL.revokeObjectURL = () => {};
  socket.give({ kind: "file", id: last("export").id, name: "simulate.png" }, { data: Uint8Array.of(1, 2) });
  assert.deepEqual([button("nc").disabled, $("saver").querySelector('[role="status"]').textContent], [false, "simulate.png is saved."]);
  button("toml").click();
  assert.deepEqual(last("device").setting.device, "biased-pump");
  socket.give({ kind: "error", id: last("device").id, message: "no" });
  assert.equal($("saver").querySelector('[role="status"]').textContent, "no");
  const what = $("saver").querySelector("select");
  what.value = "map"; what.onchange();
  assert.deepEqual([last("code").x, last("code").y, last("code").options], [["frequency", 0.1, 20], ["voltage_amplitude", 0, 1600], {}]);
});

test("going back in the history shows the older state", () => {
  location.hash = "#device=soft-film&frequency=12+Hz&left=statics";
  page.listeners.popstate();
  assert.deepEqual([last("look").setting.device, last("look").setting.values, last("look").panels], ["soft-film", { frequency: "12 Hz" }, ["statics"]]);
});

test("the page follows the theme of the system until one is chosen", () => {
  const system = page.media["(prefers-color-scheme: dark)"], theme = () => document.documentElement.dataset.theme;
  for (const matches of [true, false]) { Object.assign(system, { matches }).onchange(); assert.equal(theme(), matches ? "dark" : "light"); }
  $("theme").click();
  for (const matches of [false, true, false]) { Object.assign(system, { matches }).onchange(); assert.equal(theme(), "dark"); }
  $("theme").click();
  answer();
});

test("the theme changes, is remembered, and all is drawn anew", () => {
  answer();
  const time = $("time").querySelector("canvas").getContext();
  forget(time);
  $("theme").click();
  assert.deepEqual([document.documentElement.dataset.theme, localStorage.getItem("gelcone-theme")], ["dark", "dark"]);
  assert.notEqual(time.calls.find((c) => c.name === "fillRect").fillStyle, LIGHT.panel);
  $("theme").click();
  assert.equal(document.documentElement.dataset.theme, "light");
});

test("the button of the theme shows and names the one that a click brings: the sun with its rays, or the moon", () => {
  for (const [theme, other, parts] of [["light", "Dark", 1], ["dark", "Light", 9], ["light", "Dark", 1]]) {
    assert.deepEqual([document.documentElement.dataset.theme, $("theme").title, strokes($("theme")).length], [theme, other, parts]);
    $("theme").click();
  }
  $("theme").click();
});

test("a link is copied, a lost connection is said, and comes back", async () => {
  await $("share").onclick();
  assert.deepEqual(page.copied, [location.href]);
  socket.close();
  assert.equal($("lost").hidden, false);
  wait(300);
  Socket.all.at(-1).open();
  assert.ok($("lost").hidden);
  assert.equal(Socket.all.at(-1).sent[0].kind, "hello");
});

test("after three attempts the page asks for the address of a studio that was started anew, and no more once it has come back", () => {
  for (const round of [1, 2]) {
    for (const [k, asks] of [false, false, true, true].entries()) {
      Socket.all.at(-1).close();
      assert.deepEqual([$("lost").hidden, !$("anew").hidden], [false, asks], `${round}: ${k + 1}`);
      wait(3000);
    }
    Socket.all.at(-1).open();
    assert.ok($("lost").hidden);
  }
});

test("a short message stays its own time, whatever was said before it", async () => {
  await $("share").onclick();
  $("address").value = "nonsense"; $("address").onchange();
  assert.deepEqual([$("toast").hidden, page.timers.filter((timer) => timer?.wait === 2500).length], [false, 1]);
  wait(2500);
  assert.ok($("toast").hidden);
  page.copied.pop();
});

test("the address of a studio that was started anew is taken where it is one, and what is shown stays", () => {
  const hash = location.hash, count = Socket.all.length;
  const give = (text) => { $("address").value = text; $("address").onchange(); };
  give("nonsense");
  assert.equal(Socket.all.length, count);
  assert.match($("toast").textContent, /not an address/);
  give("http://127.0.0.1:9/?token=other");
  wait(300);
  assert.match(Socket.all.at(-1).url, /token=other/);
  assert.deepEqual([location.hash, $("address").value], [hash, ""]);
  Socket.all.at(-1).open();
});

test("an address that cannot be shown falls back, with a sentence for each part of it", () => {
  const own = Socket.all.at(-1), looks = () => own.sent.filter((sent) => sent.kind === "look");
  const fail = (control, message) => own.give({ kind: "error", id: looks().at(-1).id, side: "a", control, message });
  $("notices").replaceChildren();
  location.hash = "#device=nope&frequency=-1&evil%3Dx=1&periods=abc&top=nope&x=frequency,2,1";
  own.give(HELLO);
  const said = $("notices").textContent;
  for (const text of ["periods = abc: is not one of 20, 5, 60, 200; 20 is shown.", "top = nope: is not", "There is no device nope; biased-pump is shown."]) assert.ok(said.includes(text), text);
  assert.equal(looks().at(-1).periods, 20);
  assert.deepEqual(looks().at(-1).setting, { device: "biased-pump", preset: null, file: null, values: {} });
  own.give({ kind: "subject", id: looks().at(-1).id, side: "a", controls: CONTROLS, words: {} });
  own.give({ kind: "response", id: looks().at(-1).id, side: "a", about: ABOUT, words: { seems: "seems to repeat", ended: "", period: 100, shares: [] } }, RUN());
  wait(300);
  assert.ok(location.hash.startsWith("#device=biased-pump&x=frequency%2C0.1%2C20&") && !/evil|abc|nope/.test(location.hash));
  location.hash = "#device=biased-pump&frequency=12+Hz&evil%3Dx=1";
  own.give(HELLO);
  fail("evil=x", "'evil=x': is not a control of this subject");
  assert.deepEqual(looks().at(-1).setting.values, { frequency: "12 Hz" }); // what is right in it stays
  location.hash = "#file=nonsense&frequency=1+Hz";
  own.give(HELLO);
  for (const name of ["file", "file"]) fail(name, "the device file, line 1: is not TOML");
  assert.deepEqual(looks().at(-1).setting, { device: "biased-pump", preset: null, file: null, values: {} });
});

test("an address that names nothing opens the gallery, another does not", () => {
  const own = Socket.all.at(-1);
  for (const [hash, open] of [["#device=soft-film", false], ["", true]]) {
    $("gallery").close();
    location.hash = hash;
    own.give(HELLO);
    assert.equal(Boolean($("gallery").open), open);
  }
});
