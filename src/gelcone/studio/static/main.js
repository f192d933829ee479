// The page: its state, its requests, and the answers to them.
import * as address from "./address.js";
import { Badge } from "./badge.js";
import { Clock } from "./clock.js";
import { colours } from "./colours.js";
import { Cone } from "./cone.js";
import { Controls, make, say, typeset } from "./controls.js";
import { Gallery } from "./gallery.js";
import { GridPanels } from "./grids.js";
import { Link, newAddress, tokenOf } from "./link.js";
import { judged, missing, numbered, renewed } from "./looks.js";
import { LARGEST, readMeasured, withMeasured } from "./measured.js";
import { Notices } from "./notices.js";
import { portraitPanel, spectrumPanel, staticsPanel, timePanel } from "./panels.js";
import * as profiles from "./profiles.js";
import { Saver } from "./save.js";
import { sceneOf } from "./scene.js";
import { sideOf } from "./side.js";
import { marked, turned } from "./tabs.js";
import { themed } from "./theme.js";

/** @type {(id: string) => any} */
const $ = (id) => document.getElementById(id);
/** @type {(selector: string, within?: any) => any[]} */
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const ASKED_AGAIN = 500;
const SLOW = 400; // ms after which an unanswered look is announced and the picture fades
const LARGEST_FILE = 30000, MOST_OPENED = 6;
const FRAME = 22; // ms between pictures of the cone: every second frame of most screens
const BUSY = 38; // the same while a map is computed, which needs the processor: every third frame
const HELD = 150; // longest wait in ms for an answer, during which the cone is not animated
const AGED = 150; // ms after which an outdated settled motion fades
const FAILURES = 3; // failed attempts to connect after which the page asks for the address of a restarted studio
const RESTED = 300; // ms after the last move of a slider at which the address is updated

// --- state ---------------------------------------------------------------------------------------------------------

const looks = { active: "a" };
let hello = null, state = null;
const asked = { a: null, b: null };
const asks = { a: [], b: [] }; // unanswered looks of each side: number, setting, and step as in look()
const good = { a: null, b: null }; // the last accepted setting of each side, for links and after errors
const unknown = { a: true, b: true }; // whether the controls of a side have not arrived
const ageing = {}; // timers that fade the settled motion of an older setting
let held = 0; // end of the wait for an answer
/** @type {Record<string, any>} */
const timers = {}, last = {}; // timers by purpose; the address of the last step, none if it was wrong, and the last legend
const studio = (/** @type {any} */ (window).studio = { looks, painted: 0 });

const setting = (side = state.side) => state[side];
const sides = () => (!state ? [] : state.b ? ["a", "b"] : ["a"]);

// --- the pieces ----------------------------------------------------------------------------------------------------

themed($("theme"), () => repaint());
const notices = new Notices($("notices"), $("toast"));
const clock = new Clock({ play: $("play"), scrub: $("scrub"), output: $("clock"), speed: $("speed") }, looks);
const cone = new Cone($("cone"));
const badge = new Badge($("badges"), (share) => lower(share));
const controls = new Controls({
  drive: $("drive"), groups: $("groups"), group: $("group"), general: $("general"),
  changed: (name, text, settled) => change({ [name]: text }, settled),
  relocked: () => { state.locked = [...controls.locked]; keep(true); },
});
const plots = {
  time: timePanel($("time"), looks, clock),
  portrait: portraitPanel($("portrait"), looks, clock),
  spectrum: spectrumPanel($("spectrum"), looks),
  statics: staticsPanel($("statics"), looks, clock),
};
const grids = new GridPanels({
  hosts: { map: $("map"), strip: $("strip"), envelope: $("envelope") }, share: $("grid-share"),
  page: { ask: (kind, content) => link.ask(kind, content), setting, state: () => state, legend: () => hello, controls: () => controls, look: () => looks[state.side], go: change, keep },
});
const saver = new Saver($("saver"), { ask: (kind, content) => link.ask(kind, content), state: () => state, setting, grids,
  shown: () => ({ name: nameOf(state.side), look: looks[state.side], values: setting().values }),
  pictures: () => [$("cone"), ...document.querySelectorAll(".view.shown .plot canvas")],
  play: () => { clock.playing = true; clock.button(); moved(); },
});
const gallery = new Gallery($("gallery"), { ask: (kind, content) => link.ask(kind, content), choose });
const link = new Link(tokenOf(location.search, () => sessionStorage), {
  opened: () => { $("lost").hidden = true; link.ask("hello"); },
  lost: () => { $("lost").hidden = false; $("anew").hidden = link.failures < FAILURES; grids.lost(); saver.lost(); faded(true); },
  message,
});

// Dragging the disc sets the start: at that height, at rest. Dragging the gauge scales all voltages of the drive.
cone.hands = {
  disc(height, settled) {
    const [place, speed] = controls.list.some((c) => c.name === "release_height") ? ["release_height", "release_velocity"] : ["displacement", "velocity"];
    const control = controls.list.find((c) => c.name === place), zero = controls.list.find((c) => c.name === speed);
    if (!control || !zero) return;
    if (state.motion !== "start") { state.motion = "start"; motionShown(); }
    const own = looks[state.side]?.about?.si ? height / 10 ** (control.powers[control.unit] - control.powers.mm) : height;
    clock.restart(settled);
    change({ [place]: controls.text(control, own), [speed]: controls.text(zero, 0) }, settled);
    moved();
  },
  volts(share, settled) {
    cone.hands.base ??= voltages();
    change(Object.fromEntries(cone.hands.base.map(([c, value]) => [c.name, controls.text(c, share * value)])), settled);
    if (settled) cone.hands.base = null;
  },
};

// --- changes -------------------------------------------------------------------------------------------------------

const isChoice = (name) => controls.list.find((c) => c.name === name)?.kind === "choice";

// Sets values by name, null for the default; settled: adds a step to the browser's history once the server accepts.
function change(values, settled = true) {
  const own = setting();
  for (const [name, text] of Object.entries(values)) {
    if (controls.locked.has(name)) continue;
    if (text === null) delete own.values[name]; else own.values[name] = text;
  }
  const structure = Object.keys(values).some(isChoice);
  look(state.side, structure, settled);
  controls.values(own.values);
  grids.changed();
}

// The nonzero voltages of the drive, with their controls.
/** @returns {[import("./controls.js").Control, number][]} */
function voltages() {
  const volts = controls.list.filter((c) => c.kind === "number" && /^voltage/.test(c.name));
  return volts.map((c) => /** @type {[typeof c, number]} */ ([c, controls.value(c.name, setting().values)])).filter(([, value]) => value);
}

// Scales all voltages of the drive.
function lower(share) {
  change(Object.fromEntries(voltages().map(([c, value]) => [c.name, controls.text(c, share * value)])));
  clock.restart(true); moved();
}

// Writes the state into the address: at once for a step of the history, else once the slider rests, as it costs the
// browser more than a picture.
function keep(step) {
  clearTimeout(timers.keep);
  if (step) written(true); else timers.keep = setTimeout(written, RESTED, false);
}

function written(step) {
  const text = `#${address.write({ ...state, a: good.a ?? state.a, b: state.b && (good.b ?? state.b) })}`;
  if (!step || text === last.address) history.replaceState(null, "", text);
  else {
    if (last.address !== undefined) history.replaceState(null, "", last.address); // which a slider that rested has overwritten
    history.pushState(null, "", text);
  }
  if (step) last.address = text;
}

// The server has accepted a look: its setting becomes the last good one and is written into the address.
function taken(side, id) {
  const at = asks[side].findIndex((ask) => ask.id === id);
  if (at < 0) return;
  const done = asks[side].slice(0, at + 1);
  good[side] = done.at(-1).setting;
  if (done.some((ask) => ask.step !== null)) keep(done.some((ask) => ask.step));
  for (const ask of done) ask.step = null;
}

function panelsWanted() {
  return [state.top === "spectrum" && "spectrum", state.left === "statics" && "statics"].filter(Boolean);
}

// Requests the pictures of a side; step: whether to add a step to the history, null if the setting is not new.
function look(side, withControls = false, step = null) {
  held = performance.now() + HELD;
  unknown[side] ||= withControls;
  asked[side] = link.ask("look", { side, setting: state[side], periods: Number(state.periods), controls: unknown[side], panels: panelsWanted() });
  asks[side].push({ id: asked[side], setting: structuredClone(state[side]), step });
  timers.doing ??= setTimeout(doing, SLOW);
}

// Announces the computation while the picture is older than the controls.
function doing() {
  const side = sides().find((own) => asks[own].length);
  faded(Boolean(side));
  clearTimeout(timers.doing);
  timers.doing = null;
  if (!side) return say($("doing"), "");
  const drive = [...controls.rows.values()].filter(({ control }) => /frequency$/.test(control.name)).map(({ control, number }) => `${control.label.toLowerCase()} ${number.value}`);
  say($("doing"), unknown[side] ? "Reading the device and finding its rest position …" : `Computing the run: ${state.periods} periods${drive.length ? ` at ${drive[0]}` : ""} …`);
}

function faded(on) { document.body.classList.toggle("old", on); }

// Shows a state read from an address.
function apply(next) {
  state = next;
  if (!state.b) forget("b");
  $("periods").value = state.periods;
  envelopeTab(!setting().preset);
  for (const place of ["top", "left", "right"]) tab(place, state[place]);
  sidesShown();
  subjectShown();
  controls.lockAll(state.locked);
  for (const side of sides()) look(side, side === state.side);
}

// Forgets the contents of a side.
function forget(side) { delete looks[side]; asks[side] = []; good[side] = null; }

// Only a device has an envelope.
function envelopeTab(shown) { $("envelope-tab").hidden = !shown; }

function sidesShown() {
  looks.active = state.side;
  $("sides").hidden = !state.b;
  $("compare").setAttribute("aria-pressed", Boolean(state.b));
  $("side-a").setAttribute("aria-pressed", state.side === "a");
  $("side-b").setAttribute("aria-pressed", state.side === "b");
  document.body.classList.toggle("b", state.side === "b");
  badge.keep(sides());
  motionShown();
}

// Marks the part of the motion shown: settled, or from the start, which is also shown if no settled motion was found.
function motionShown() {
  if (state.motion !== "start") state.motion = "settled";
  looks.motion = state.motion;
  const { late = "" } = looks[state.side] ?? {}, shown = late ? "start" : state.motion;
  for (const button of all("#motion button")) button.setAttribute("aria-pressed", button.dataset.motion === shown);
  Object.assign($("motion").querySelector('[data-motion="settled"]'), { disabled: Boolean(late), title: late });
}

function subjectShown() {
  const own = setting(), select = $("subject");
  const groups = [["Devices", hello.devices.map((name) => [`device:${name}`, name])], ["Parameter sets of the paper", Object.keys(hello.presets).map((name) => [`preset:${name}`, name])]];
  if (own.file) groups.unshift(["Opened", [["file:", looks[state.side]?.about?.name || "device file"]]]);
  select.replaceChildren(...groups.map(([label, options]) => make("optgroup", { label }, ...options.map(([value, text]) => new Option(text, value)))));
  select.value = own.file ? "file:" : own.preset ? `preset:${own.preset}` : `device:${own.device}`;
}

// Replaces the device or preset of the active side.
function choose(next) {
  state[state.side] = { device: null, preset: null, file: null, values: {}, ...next };
  subjectShown();
  look(state.side, true, true);
}

function subjectChosen() {
  const [kind, name] = $("subject").value.split(/:(.*)/s);
  if (kind !== "file") choose({ [kind]: name });
}

// Opens files: a device file replaces the device, a measured curve is drawn over the computed ones.
async function opened(files) {
  for (const file of files.slice(0, MOST_OPENED)) {
    if (!/\.toml$/i.test(file.name)) {
      try {
        if (file.size > LARGEST) throw new Error(`${file.name}: has more than ${LARGEST} characters; export fewer rows`);
        looks.measured = withMeasured(looks.measured, readMeasured(file.name, await file.text()));
      } catch (error) { notices.add(error.message); }
      measuredShown();
    } else if (file.size > LARGEST_FILE) notices.add(`${file.name}: has more than ${LARGEST_FILE} characters; a device file has at most that many.`);
    else choose({ file: await file.text() });
  }
}

function measuredShown() {
  $("unmeasure").hidden = !looks.measured?.length;
  if (looks.measured?.length) {
    const place = looks.measured.at(-1).over === "time" ? ["top", "time"] : ["left", "statics"];
    if (state[place[0]] !== place[1]) { tab(place[0], place[1]); keep(true); everySide(); }
  }
  repaint();
}

// Sets a second setting next to the first, or keeps the one that is shown.
function compare() {
  if (state.b) { state.a = setting(); good.a = good[state.side]; state.b = null; forget("b"); state.side = "a"; look("a", true); }
  else { state.b = structuredClone(state.a); good.b = structuredClone(good.a); state.side = "b"; looks.b = { ...looks.a }; look("b", true); }
  keep(true);
  sidesShown();
  repaint();
}

function chooseSide(side) { state.side = side; keep(true); sidesShown(); subjectShown(); look(side, true); }

function chooseMotion(motion) { state.motion = motion; motionShown(); keep(true); repaint(); }

async function share() {
  try { await navigator.clipboard.writeText(location.href); notices.pass("The address is copied; it works while the studio runs."); } catch { notices.pass("Copy the address from the address bar."); }
}

// Takes the address of a restarted studio, and keeps the state of the page.
function addressGiven() {
  const found = newAddress($("address").value, location);
  $("address").value = "";
  if (!found) return notices.pass("That is not an address that gelcone studio printed on this machine.");
  if (found.elsewhere) location.href = `${found.elsewhere}#${location.hash.slice(1)}`;
  else { tokenOf(`?token=${encodeURIComponent(found.token)}`, () => sessionStorage); link.renew(found.token); }
}

// --- tabs ----------------------------------------------------------------------------------------------------------

function tab(place, name) {
  const [panel] = all(`.panel[data-place="${place}"]`), tabs = all('[role="tab"]', panel);
  if (!tabs.some((t) => t.dataset.tab === name && !t.hidden)) name = tabs[0].dataset.tab;
  state[place] = name;
  marked(tabs, tabs.find((t) => t.dataset.tab === name));
  for (const view of all(".view", panel)) view.classList.toggle("shown", view.dataset.view === name);
  for (const part of all("[data-for]", panel)) part.hidden = part.dataset.for !== name;
}

function openTab(place, name) { tab(place, name); keep(true); if (place === "right") grids.opened(); else everySide(); }

function everySide() { for (const side of sides()) look(side); }

// --- answers -------------------------------------------------------------------------------------------------------

function message(head, arrays) {
  if (head.kind === "hello") return begin(head);
  if (head.kind === "error") return failed(head);
  if (grids.message(head, arrays) || saver.message(head, arrays) || gallery.message(head, arrays)) return;
  if (head.id < (asked[head.side] ?? 0) - ASKED_AGAIN || !state[head.side]) return;
  if (!["subject", "response"].includes(head.kind) && !looks[head.side]) return; // evidence of a side that is no longer shown
  ANSWERS[head.kind](head, arrays);
  show(head.side, head.kind);
}

const ANSWERS = {
  subject(head) {
    const before = good[head.side], ask = asks[head.side].find((own) => own.id === head.id);
    if (before && ask?.step && subjectOf(before) !== subjectOf(ask.setting)) { // another subject has other axes, and a preset has no envelope
      Object.assign(state, { x: null, y: null, over: null });
      if (state.right === "envelope" && setting(head.side).preset) tab("right", "map");
    }
    taken(head.side, head.id);
    if (head.id !== asked[head.side]) return;
    unknown[head.side] = false;
    if (head.side !== state.side) return;
    controls.show(head.controls, setting().values);
    grids.controlsChanged();
    if ($("doing").textContent) doing();
  },
  response(head, arrays) {
    const before = looks[head.side] ?? {}, look = renewed(before, head, arrays);
    clearTimeout(ageing[head.side]);
    ageing[head.side] = setTimeout(() => { look.old = true; plots.portrait.redraw(); plots.time.redraw(); moved(); }, AGED);
    looks[head.side] = look;
    taken(head.side, head.id);
    asks[head.side] = asks[head.side].filter((ask) => ask.id > head.id);
    if (sides().some((side) => asks[side].length)) { clearTimeout(timers.doing); timers.doing = setTimeout(doing, SLOW); } else doing();
    if (head.side === state.side) {
      controls.settle();
      controls.values(setting().values);
      if (setting().file && before.about?.name !== head.about.name) subjectShown();
      say($("subject-note"), typeset(head.about.doubts.join("; ")), true);
      clock.speeds(head.words.period, head.about.si);
      envelopeTab(head.about.si);
    }
  },
  kind(head, arrays) {
    clearTimeout(ageing[head.side]);
    judged(looks[head.side], head, arrays, Number(state.periods));
    if (head.id >= asked[head.side]) held = 0;
    if (head.side === state.side) grids.moved();
  },
  numbers(head) { numbered(looks[head.side], head.words); },
  late(head) { missing(looks[head.side], head); },
  section(head, arrays) { Object.assign(looks[head.side], arrays); },
  spectrum(head, arrays) { looks[head.side].spectrum = { ...arrays, ...head.words }; },
  statics(head, arrays) { looks[head.side].statics = { ...arrays, ...head.words }; },
  profiles(head, arrays) { profiles.add(head.words, arrays); moved(); },
};

function begin(head) {
  hello = head;
  for (const side of ["a", "b"]) { asks[side] = []; good[side] = null; unknown[side] = true; }
  const next = address.read(location.hash, hello.devices[0]), empty = !location.hash.slice(1);
  for (const own of [next.a, next.b]) if (own && !own.file && !(own.preset ? Object.hasOwn(hello.presets, own.preset) : hello.devices.includes(own.device))) {
    next.odd.push(`There is no ${own.preset ? "preset" : "device"} ${(own.preset ?? own.device).slice(0, 40)}; ${hello.devices[0]} is shown.`);
    Object.assign(own, { device: hello.devices[0], preset: null, values: {} });
  }
  if (next.odd.length) notices.add(next.odd.join(" "));
  apply(next);
  if (next.odd.length) for (const side of sides()) asks[side].at(-1).step = false; // rewrites the address
  last.address = next.odd.length ? undefined : location.hash;
  if (empty) gallery.show(hello);
}

const subjectOf = (own) => JSON.stringify([own.device, own.preset, own.file]);

// Handles an error. If the newest look of a side failed, the side returns to its last good setting; a wrong value stays
// in its entry, with the reason next to it, and the subject shown stays.
function failed(head) {
  if (saver.failed(head) || grids.failed(head) || gallery.failed(head)) return;
  const { side } = head, ask = side && asks[side].find((own) => own.id === head.id);
  if (!ask) return side ? undefined : notices.add(head.message);
  asks[side] = asks[side].filter((own) => own.id > head.id);
  if (asks[side].length || !state[side]) return;
  if (!good[side]) return fallBack(side, ask.setting, head);
  const same = subjectOf(ask.setting) === subjectOf(good[side]), names = [...new Set([...Object.keys(ask.setting.values), ...Object.keys(good[side].values)])];
  const differ = names.filter((name) => ask.setting.values[name] !== good[side].values[name]);
  // a value that only the old choice had is dropped
  if (same && differ.length === 1 && isChoice(differ[0]) && head.control !== differ[0] && Object.hasOwn(ask.setting.values, head.control)) {
    state[side] = structuredClone(ask.setting);
    delete state[side].values[head.control];
    return look(side, true, true);
  }
  state[side] = structuredClone(good[side]);
  unknown[side] = false;
  doing();
  if (!same) { subjectShown(); notices.add(head.message); }
  else if (side === state.side) {
    const own = differ.length === 1 ? differ[0] : head.control;
    if (controls.fail(own, head.message)) faded(true); else controls.values(state[side].values);
  }
}

// Falls back from an address that cannot be shown: drops the wrong value, or shows the first device.
function fallBack(side, { values, ...subject }, { control, message }) {
  const own = state[side], left = Object.hasOwn(values, control) ? [control] : Object.keys(values);
  for (const name of left) delete own.values[name];
  if (left.length) notices.add(`${message} (left out: ${left.map((name) => name.slice(0, 40)).join(", ")})`);
  else if (subject.device !== hello.devices[0]) {
    state[side] = { device: hello.devices[0], preset: null, file: null, values: {} };
    notices.add(`${message} (${hello.devices[0]} is shown instead)`);
    subjectShown();
  } else return notices.add(message);
  last.address = undefined;
  look(side, true, false);
}

// --- painting ------------------------------------------------------------------------------------------------------

const DRAWN = { subject: [], late: ["time", "portrait", "spectrum", "statics"], numbers: [], profiles: [], response: ["time", "portrait", "spectrum", "statics"], kind: ["time", "portrait", "statics"], section: ["portrait"], spectrum: ["spectrum"], statics: ["statics"] };

// Draws the changes of an answer at once, so that the next frame shows them.
function show(side, kind) {
  const open = [state.top, state.left];
  const same = kind === "response" && looks[side] && sceneOf(looks[side], looks.motion) !== looks[side]; // until the new kind arrives
  for (const name of DRAWN[kind]) if (open.includes(name) && !(name === "time" && same)) plots[name].redraw();
  if (!looks[side]) return;
  badge.keep(sides());
  badge.show(side, looks[side], hello, side === "b" ? looks.a : null);
  if (state.b && side === "a" && looks.b?.words) badge.show("b", looks.b, hello, looks.a);
  if (["response", "kind", "late"].includes(kind)) { filmLegend(); moved(); motionShown(); }
  studio.painted++;
}

function filmLegend() {
  const names = looks[state?.side]?.about?.film; // before the server has greeted the page there is no state
  const codes = [...new Set(sides().flatMap((side) => (looks[side]?.words ? sharesShown(looks[side]).map(({ code }) => code) : [])))].sort();
  if (!names) return;
  const key = codes.join() + names + document.documentElement.dataset.theme;
  if (key === last.legend) return;
  last.legend = key;
  $("film-legend").replaceChildren(...codes.map((code) => {
    const swatch = make("i");
    swatch.style.background = colours().film[code];
    return make("li", {}, swatch, `film ${names[code]}`);
  }));
}

const sharesShown = (look) => (sceneOf(look, looks.motion) !== look && look.shares) || look.words.shares;

function repaint() {
  for (const plot of Object.values(plots)) plot.redraw();
  badge.keep(sides());
  for (const side of sides()) if (looks[side]?.words) badge.show(side, looks[side], hello, side === "b" ? looks.a : null);
  filmLegend();
  grids.redraw();
  moved();
}

// The name of a side's subject.
const nameOf = (side) => state[side]?.device || state[side]?.preset || looks[side]?.about?.name || "";

// Pictures of the cone, drawn only while something moves, and not while an answer is awaited.
let asking = null, waiting = null;

function moved() { clock.moved = true; next(); }

function next() { clearTimeout(waiting); asking ??= requestAnimationFrame(frame); }

function frame(now) {
  asking = null;
  clock.tick(now);
  if ((clock.moved || cone.changed) && sides().some((side) => looks[side]?.t)) {
    cone.draw(sides().filter((side) => looks[side]?.t).map((side) => sideOf(looks[side], nameOf(side), clock)));
    if (state.top === "time") plots.time.redrawOver();
    plots[state.left].redrawOver();
    clock.write(now);
    clock.moved = cone.changed = false;
  }
  if (clock.playing) later();
}

function later() { waiting = setTimeout(() => (held > performance.now() ? later() : next()), grids.open?.running ? BUSY : FRAME); }
clock.wakes = cone.wakes = next;

// --- what the page's elements do ------------------------------------------------------------------------------------

const WIRING = {
  address: { onchange: addressGiven },
  browse: { onclick: () => hello && gallery.show(hello) },
  compare: { onclick: compare },
  file: { onchange: () => { const files = [...$("file").files]; $("file").value = ""; opened(files); } },
  open: { onclick: () => $("file").click() },
  periods: { onchange: () => { state.periods = $("periods").value; keep(true); everySide(); } },
  "reset-all": { onclick: () => change(Object.fromEntries(Object.keys(setting().values).map((name) => [name, null]))) },
  save: { onclick: () => saver.show() },
  share: { onclick: share },
  "side-a": { onclick: () => chooseSide("a") },
  "side-b": { onclick: () => chooseSide("b") },
  subject: { onchange: subjectChosen },
  unmeasure: { onclick: () => { looks.measured = []; measuredShown(); } },
};
for (const [id, does] of Object.entries(WIRING)) Object.assign($(id), does);
for (const button of all("#motion button")) button.onclick = () => chooseMotion(button.dataset.motion);
for (const panel of all(".panel[data-place]")) {
  const tabs = all('[role="tab"]', panel);
  for (const t of tabs) Object.assign(t, { type: "button", onclick: () => openTab(panel.dataset.place, t.dataset.tab), onkeydown: (event) => turned(event.key, t, tabs) });
}
addEventListener("popstate", () => { clearTimeout(timers.keep); last.address = location.hash; apply(address.read(location.hash, hello.devices[0])); });
const withFiles = (/** @type {any} */ event) => [...event.dataTransfer.types].includes("Files"); // not a text that is dropped into a field
addEventListener("dragover", (event) => { if (withFiles(event)) event.preventDefault(); });
addEventListener("drop", (event) => { if (withFiles(event)) { event.preventDefault(); opened([.../** @type {any} */ (event).dataTransfer.files]); } });

// The subject in the address is shown until the server sends its lists.
const first = address.read(location.hash, "").a;
$("subject").replaceChildren(new Option(first.preset ?? first.device ?? "device file"));
