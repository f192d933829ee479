// What is saved: files, commands, pictures and films.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, made, wait } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { Saver } = await from("save");

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
  assert.equal(saver.failed({ id: null, message: "of no question" }), false);
});

test("the dialog opens without what was said before", () => {
  browser();
  const saver = new Saver(document.createElement("dialog"), { ask: () => 1, state: () => ({ top: "time", periods: "5" }), setting: () => ({ preset: null }) });
  saver.done("a.png is saved."); saver.show();
  assert.deepEqual([saver.status.textContent, saver.status.getAttribute("role")], ["", "status"]);
});

test("what does not come as the connection is lost can be asked for again, and nothing else is said to be lost", () => {
  browser();
  let number = 7;
  const asked = [], saver = new Saver(document.createElement("dialog"), { ask: (kind) => { asked.push(kind); return number; }, state: () => ({ top: "time", periods: "5" }), setting: () => ({ preset: null }) });
  const now = () => [saver.status.textContent, saver.buttons.every((button) => !button.disabled)], lost = ["The connection is lost; save again once it is back.", true];
  saver.lost();
  assert.deepEqual(now(), ["", true]);
  for (const [button, waits] of [[saver.buttons[1], ["computing …", false]], [saver.device, ["", true]]]) {
    saver.status.textContent = ""; number = 7; button.click();
    assert.deepEqual(now(), waits);
    saver.lost();
    assert.deepEqual(now(), lost);
    saver.status.textContent = ""; number = null; button.click();
    assert.deepEqual(now(), lost);
  }
  assert.deepEqual(asked, ["export", "export", "device", "device"]);
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

test("everything that is saved has the values that are set", () => {
  browser();
  const asked = [], setting = { device: "pump", preset: null, file: null, values: { frequency: "9 Hz", spring_rate: "3 N/m" } };
  const saver = new Saver(document.createElement("dialog"), { ask: (kind, content) => asked.push([kind, content]), state: () => ({ top: "time", periods: "20" }), setting: () => setting });
  saver.show();
  for (const button of [saver.device, ...saver.buttons]) button.click();
  assert.deepEqual(asked.map(([kind, content]) => [kind, content.setting]), ["code", "device", "export", "export", "export"].map((kind) => [kind, setting]));
});

test("the dialog offers what can be saved, in which forms, and the lines that give the same", () => {
  browser();
  const saver = new Saver(document.createElement("dialog"), { ask: () => 1 });
  saver.message({ kind: "code", command: "gelcone map", python: "import gelcone" }, {});
  const what = { simulate: "Time response", section: "Phase portrait: section", spectrum: "Spectrum", regime: "Kind of motion, with its evidence", static: "Statics", map: "Map", bifurcation: "Sweep of a parameter", envelope: "Envelope" };
  const options = Object.entries(what).map(([value, text]) => `option "${text}" =${value}`).join(", "), button = (text, title = "") => `button "${text}"${title && ` (${title})`}`, device = "The device with its current values, as a file for the command line";
  assert.deepEqual(saver.dialog.parts.map(made), [
    'h2 "Save and repeat"', `div.row [select ‹What to save› [${options}], ${["netCDF", "PNG", "SVG"].map((text) => button(text)).join(", ")}, ${button("Device file", device)}, span role=status]`,
    `div.row [span "The page as it looks, with a caption:", ${button("Picture", "Cone and plots as they are on the page, with a caption")}, ${button("Film", "The cone as it moves, with a caption: 8 seconds as WebM")}]`,
    'h3 "The same on the command line " [button "Copy"]', 'pre "gelcone map"', 'h3 "The same in Python " [button "Copy"]', 'pre "import gelcone"', 'div.row [button "Close"]',
  ]);
  assert.deepEqual(saver.dialog.parts.filter((e) => e.tagName === "pre").map((e) => e.tabIndex), [0, 0]); // long lines are scrolled by the keyboard, too
});

test("while a film is recorded it is said how much of it there is, and then its end", async () => {
  browser();
  const { setInterval: before } = globalThis, { now: clock } = performance, steps = [], films = [], make = document.createElement;
  let now = 0;
  globalThis.performance.now = () => now;
  globalThis.setInterval = (does) => steps.push(does);
  globalThis.MediaRecorder = class { static isTypeSupported() { return true; } constructor() { films.push(this); } start() { this.state = "recording"; } stop() { assert.equal(this.state, "recording"); this.state = "inactive"; this.ended = true; } };
  document.createElement = (tag) => Object.assign(make(tag), tag === "canvas" && { captureStream: () => ({}) });
  const page = { shown: () => ({ name: "pump", look: { words: { ended: "", seems: "seems to repeat" } }, values: {} }), pictures: () => [Object.assign(make("canvas"), { width: 300, height: 200 })], play() {} };
  const saver = new Saver(document.createElement("dialog"), page);
  saver.give = (name) => saver.done(`${name} is saved.`);
  const done = saver.film.onclick();
  for (const [passed, text, ended] of [[0, "0", undefined], [3700, "3", undefined], [7999, "7", undefined], [8050, "8", true], [9000, "8", true]]) {
    now = passed; steps[0]();
    assert.deepEqual([saver.status.textContent, films[0].ended], [`recording, ${text} of 8 s …`, ended]);
  }
  films[0].onstop(); await done;
  assert.equal(saver.status.textContent, "gelcone.webm is saved.");
  Object.assign(globalThis, { setInterval: before }); performance.now = clock; document.createElement = make;
  delete globalThis.MediaRecorder;
});
