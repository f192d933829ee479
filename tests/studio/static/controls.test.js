// Controls: values, locks, errors and groups; numbers and texts as they are written.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, made, near, strokes } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { format, icon, typeset, plain, Controls } = await from("controls");

const LIST = [
  { name: "voltage_amplitude", label: "Voltage amplitude", group: "Drive", kind: "number", value: 800, unit: "V", low: 0, high: 2000, powers: { V: 0, kV: 3, mV: -3 }, about: "", choices: [] },
  { name: "waveform", label: "Waveform", group: "Drive", kind: "choice", value: "sine", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["sine", "triangle"] },
  { name: "disc_radius", label: "Disc radius", group: "Body", kind: "number", value: 8, unit: "mm", low: 1, high: 16, powers: { m: 0, mm: -3 }, about: "", choices: [] },
  { name: "hoop_prestretch", label: "Hoop prestretch", group: "Gel", kind: "number", value: 1.4, unit: "", low: 0, high: 4, powers: { "": 0 }, about: "", choices: [] },
  { name: "release_height", label: "Release height", group: "Start", kind: "number", value: null, unit: "mm", low: 0, high: 40, powers: { m: 0, mm: -3 }, about: "", choices: [] },
];

function controls(list = LIST) {
  const root = browser(), $ = (id) => document.getElementById(id), changes = [];
  const own = new Controls({ drive: $("drive"), groups: $("groups"), group: $("group"), general: $("general"), changed: (...change) => changes.push(change) });
  own.show(list, {});
  return { own, changes, root, row: (name) => own.rows.get(name) };
}

const tree = (e) => [e.tagName, e.className, e.hidden, e.id ?? "", e.title ?? "", e.value ?? "", e.placeholder ?? "", e.own, e.attributes, e.parts.map(tree)];
const OTHER = { label: "Other", group: "Start", kind: "choice", value: 9, unit: "kV", low: 2, high: 12, powers: { kV: 3 }, about: "other words", choices: ["one", "two"] };

test("numbers are written short", () => {
  const cases = [[0, "0"], [1.23456, "1.235"], [1e6, "1e+6"], [999999, "1e+6"], [123456, "123500"], [0.0001, "0.0001"], [0.00001, "1e-5"], [-2.5, "-2.5"], [NaN, ""], [Infinity, ""]];
  for (const [value, text] of cases) assert.equal(format(value), text);
  assert.equal(format(1.23456, 2), "1.2");
});

test("a slider's place is its value, both ways, and the number stands next to it", () => {
  const { own, row, changes } = controls(), { slider, number } = row("voltage_amplitude");
  assert.deepEqual([slider.value, number.value], ["400", "800 V"]);
  slider.value = "750"; slider.oninput();
  assert.deepEqual(changes, [["voltage_amplitude", "1500 V", false]]);
  assert.deepEqual([number.value, slider.value], ["1500 V", "750"]);
  slider.onchange();
  assert.equal(changes.at(-1)[2], true);
  own.values({ voltage_amplitude: "1 kV" });
  assert.deepEqual([slider.value, number.value, slider.style["--fill"]], ["500", "1 kV", "50%"]);
  own.values({ voltage_amplitude: "9 kV" });
  assert.equal(slider.value, "1000");
  own.values({});
  assert.deepEqual([number.value, row("voltage_amplitude").row.classList.has("changed")], ["800 V", false]);
});

test("a slider of which the lowest value is not zero begins there", () => {
  const { row, changes } = controls(), { slider } = row("disc_radius");
  assert.equal(slider.value, String(Math.round((1000 * 7) / 15)));
  slider.value = "0"; slider.oninput();
  assert.equal(changes.at(-1)[1], "1 mm");
  slider.value = "1000"; slider.oninput();
  assert.equal(changes.at(-1)[1], "16 mm");
});

test("the value of a control is in its own unit", () => {
  const { own } = controls(), value = (text) => own.value("voltage_amplitude", { voltage_amplitude: text });
  assert.deepEqual([value("1.5 kV"), value("20 V"), value("3 mV"), value("2e2V"), value("-1 kV")], [1500, 20, 0.003, 200, -1000]);
  assert.deepEqual([value("1 mm"), value("many"), value("1.2.3 V"), value("5")], [null, null, null, null]);
  assert.deepEqual([own.value("voltage_amplitude", {}), own.value("release_height", {}), own.value("none", {})], [800, null, null]);
});

test("the same list of controls leaves each entry as it is, with the cursor in it", () => {
  const { own } = controls(), before = [...own.rows.values()].map(({ number }) => number);
  own.show(structuredClone(own.list), { voltage_amplitude: "5 V" });
  assert.ok([...own.rows.values()].every(({ number }, k) => number === before[k]));
  assert.equal(own.rows.get("voltage_amplitude").number.value, "5 V");
});

test("a value in the unit of its control is read, also where no other unit is known", () => {
  for (const unit of ["", "turns"]) {
    const { own } = controls([{ ...LIST[3], unit, powers: {} }]), [{ name }] = own.list;
    assert.equal(own.value(name, { [name]: `3 ${unit}`.trim() }), 3);
  }
});

test("a number without a unit is sent as it is, typed or moved", () => {
  const { row, changes } = controls(), { number, slider } = row("hoop_prestretch");
  number.value = " 1.5 "; number.onchange();
  slider.value = "500"; slider.onchange();
  assert.deepEqual(changes.map(([, text]) => text), ["1.5", "2"]);
});

test("each number that a control writes it reads, however large or small", () => {
  const { own } = controls(), [control] = own.list.filter((c) => c.name === "voltage_amplitude");
  for (let power = -12; power <= 12; power++) for (const value of [1.234 * 10 ** power, -5 * 10 ** power]) assert.ok(near(own.value(control.name, { [control.name]: own.text(control, value) }) / value, 1, 1e-9), own.text(control, value));
});

test("a bare number is in the unit next to it, an empty field is the default, and other texts are sent as typed", () => {
  const { row, changes } = controls(), { number } = row("voltage_amplitude");
  for (const [typed, sent] of [["900", "900 V"], [" 1e3 ", "1e3 V"], [".5", ".5 V"], ["1.2 kV", "1.2 kV"], ["", null], ["1,2 kV", "1,2 kV"]]) {
    number.value = typed; number.onchange();
    assert.deepEqual(changes.at(-1), ["voltage_amplitude", sent, true]);
  }
  row("waveform").number.value = "triangle"; row("waveform").number.onchange();
  assert.deepEqual(changes.at(-1), ["waveform", "triangle", true]);
});

test("a control that is not set says so, and can be reset", () => {
  const { own, row, changes } = controls();
  assert.deepEqual([row("release_height").number.value, row("release_height").number.placeholder, row("release_height").slider.value], ["", "automatic", "0"]);
  own.values({ waveform: "triangle" });
  assert.equal(row("waveform").number.value, "triangle");
  row("waveform").row.querySelector(".reset").click();
  assert.deepEqual(changes.at(-1), ["waveform", null, true]);
  assert.equal(row("waveform").number.value, "sine");
});

test("a lock keeps a value until it is opened", () => {
  const { row, changes } = controls(), { slider, number, lock } = row("voltage_amplitude");
  lock.click();
  assert.deepEqual([number.disabled, slider.disabled, lock.getAttribute("aria-pressed")], [true, true, "true"]);
  slider.value = "10"; slider.oninput();
  assert.equal(changes.length, 0);
  lock.click();
  slider.oninput();
  assert.deepEqual([changes.length, number.disabled], [1, false]);
});

test("an error stands next to its control, opens its group, and goes when all is well", () => {
  const { own, row } = controls();
  own.fail("disc_radius", "too large");
  assert.deepEqual([row("disc_radius").error.hidden, row("disc_radius").error.firstChild.textContent, row("disc_radius").number.getAttribute("aria-invalid")], [false, "too large", "true"]);
  own.fail("prestretch", "beyond its limit");
  assert.deepEqual([row("hoop_prestretch").error.firstChild.textContent, own.open, row("disc_radius").error.hidden], ["beyond its limit", "Gel", true]);
  own.fail("elsewhere", "what is wrong");
  assert.deepEqual([own.general.hidden, own.general.textContent, row("hoop_prestretch").error.hidden], [false, "what is wrong", true]);
  own.settle();
  assert.deepEqual([own.general.hidden, ...LIST.map(({ name }) => [row(name).number.getAttribute("aria-invalid"), row(name).row.classList.has("wrong")])], [true, ...LIST.map(() => [null, false])]);
});

test("an error that has no room is opened by a click, and offers none where it has", () => {
  const { own, row } = controls(), { error } = row("disc_radius"), [text, more] = error.parts;
  for (const [wide, room] of [[300, 200], [200, 200]]) {
    Object.assign(text, { scrollWidth: wide, clientWidth: room });
    own.fail("disc_radius", "too large");
    assert.deepEqual([more.hidden, more.getAttribute("aria-expanded"), error.classList.has("whole"), text.title], [wide <= room, "false", false, "too large"]);
    more.click();
    assert.deepEqual([more.getAttribute("aria-expanded"), error.classList.has("whole")], ["true", true]);
  }
});

test("a choice of what the device does not have is its default, and is not sent", () => {
  const { own, row, changes } = controls();
  own.show([...LIST, { name: "second_film", label: "Second film", group: "Body", kind: "choice", value: "none", unit: "", low: 0, high: 1, powers: {}, about: "", choices: ["none", "taut"] }], {});
  const { number } = row("second_film");
  for (const [chosen, sent] of [["taut", "taut"], ["none", null]]) {
    number.value = chosen; number.onchange();
    assert.deepEqual(changes.at(-1), ["second_film", sent, true]);
  }
  assert.equal(number.value, "none");
});

test("what is set is marked, also where it is the default, and what is not is read out as automatic", () => {
  const { own, row } = controls();
  own.values({ hoop_prestretch: "1.4", release_height: "2 mm" });
  assert.deepEqual(["hoop_prestretch", "disc_radius"].map((name) => row(name).row.classList.has("changed")), [true, false]);
  assert.equal(row("release_height").slider.getAttribute("aria-valuetext"), "2 mm");
  own.values({});
  assert.deepEqual(["hoop_prestretch", "release_height"].map((name) => row(name).slider.getAttribute("aria-valuetext")), ["1.4", "automatic"]);
});

test("an error of a field in a part stands at that part's control, and of several that end alike at the one that is set", () => {
  const { own, row } = controls(), more = (name, group) => ({ ...LIST[3], name, label: name, group });
  own.show([...LIST, more("material.shear_modulus", "Gel"), more("meridional_prestretch", "Gel")], { meridional_prestretch: "1.2" });
  const wrong = () => [...own.rows].filter(([, { error }]) => !error.hidden).map(([name]) => name);
  assert.ok(own.fail("shear_modulus", "too small"));
  assert.deepEqual(wrong(), ["material.shear_modulus"]);
  own.fail("prestretch", "too large");
  assert.deepEqual(wrong(), ["meridional_prestretch"]);
  own.values({});
  own.fail("prestretch", "too large");
  assert.deepEqual(wrong(), ["hoop_prestretch"]);
  assert.equal(row("hoop_prestretch").row.classList.has("wrong"), true);
});

test("the shackle of a lock is closed on both sides where it locks, and its name, like that of the reset, is the control's", () => {
  const { row } = controls(), { lock, row: whole } = row("voltage_amplitude"), down = () => strokes(lock)[0].match(/[Vv]/g).length;
  for (const [legs, pressed] of [[1, "false"], [2, "true"], [1, "false"]]) {
    assert.deepEqual([down(), lock.getAttribute("aria-pressed")], [legs, pressed]);
    lock.click();
  }
  assert.deepEqual([lock.getAttribute("aria-label"), whole.querySelector(".reset").getAttribute("aria-label")], ["Lock Voltage amplitude", "Reset Voltage amplitude"]);
});

test("the name of a control says what it is about, belongs to its entry, and the entry to its error", () => {
  const { own, row } = controls();
  own.show(LIST.map((c) => ({ ...c, about: `about ${c.name}` })), {});
  for (const { name, label } of LIST) {
    const { row: whole, number, error } = row(name), own = whole.querySelector("label");
    assert.deepEqual([own.textContent, own.title, own.htmlFor, number.getAttribute("aria-describedby")], [label, `about ${name}`, number.id, error.id]);
  }
});

test("locks are those of the address, and no others", () => {
  const { own, row } = controls(), locked = () => LIST.map((c) => c.name).filter((name) => row(name).number.disabled);
  own.lockAll(["disc_radius", "waveform"]);
  assert.deepEqual(locked(), ["waveform", "disc_radius"]);
  own.lockAll(["disc_radius"]);
  assert.deepEqual([locked(), row("waveform").lock.getAttribute("aria-pressed"), row("disc_radius").lock.getAttribute("aria-pressed")], [["disc_radius"], "false", "true"]);
  own.lockAll([]);
  assert.deepEqual(locked(), []);
});

test("controls stand in their groups, of which one is open", () => {
  const { own } = controls(), names = () => own.group.parts.map((e) => e.dataset.name);
  assert.deepEqual(own.drive.parts.map((e) => e.dataset.name), ["voltage_amplitude", "waveform"]);
  assert.deepEqual([own.groups.parts.map((e) => e.textContent), names()], [["Body", "Gel", "Start"], ["disc_radius"]]);
  own.groups.parts[1].onkeydown({ key: "ArrowLeft" });
  assert.deepEqual([own.open, names()], ["Body", ["disc_radius"]]);
  own.groups.parts[0].onkeydown({ key: "ArrowLeft" });
  assert.deepEqual([own.open, names(), own.groups.parts.map((e) => e.getAttribute("aria-selected"))], ["Start", ["release_height"], ["false", "false", "true"]]);
});

test("after any change of their list controls are those of a page that shows the new list first", () => {
  for (const [name, value] of Object.entries(OTHER)) {
    for (const k of [0, 2]) {
      const list = LIST.map((c, at) => (at === k ? { ...c, [name]: value, ...(name === "kind" && { value: "one", choices: OTHER.choices }) } : c));
      const { own, root } = controls(), open = own.open;
      own.show(list, {});
      const again = tree(root), fresh = controls(list);
      if (fresh.own.pages[open]) fresh.own.choose(open);
      assert.deepEqual(again, tree(fresh.root), name);
    }
  }
});

test("the open group stays open where the new list has it, and else the first is", () => {
  const { own } = controls();
  own.choose("Gel");
  for (const [list, open] of [[LIST.filter((c) => c.name !== "disc_radius"), "Gel"], [LIST, "Gel"], [LIST.filter((c) => c.group !== "Gel"), "Body"]]) {
    own.show(list, {});
    assert.deepEqual([own.open, own.group.parts.map((e) => e.dataset.name)], [open, list.filter((c) => c.group === open).map((c) => c.name)]);
  }
});

test("a long value has smaller letters, a short one has not, as they change", () => {
  const { own, row } = controls();
  for (const [text, long] of [["1500 V", false], ["1234.567 V", true], ["2 kV", false], ["12345678", false], ["123456789", true]]) {
    own.values({ voltage_amplitude: text });
    assert.equal(row("voltage_amplitude").number.classList.has("long"), long, text);
  }
});

test("of the tabs one can be reached by the keyboard, the selected one, and it names what is open", () => {
  const { own } = controls(), tabs = () => own.groups.parts.map((e) => [e.textContent, e.getAttribute("aria-selected"), e.tabIndex]);
  for (const name of ["Gel", "Start", "Body"]) {
    own.groups.parts.find((e) => e.textContent === name).click();
    assert.deepEqual(tabs(), ["Body", "Gel", "Start"].map((one) => [one, String(one === name), one === name ? 0 : -1]));
    assert.equal(document.getElementById(own.group.getAttribute("aria-labelledby")).textContent, name);
  }
});

test("texts are set with true minus signs, micro and powers, and read back as the server takes them", () => {
  for (const [text, set] of [["-9 Hz", "−9 Hz"], ["200 um", "200 µm"], ["1.5e-5 uF", "1.5e−5 µF"], ["100 kN/m^3", "100 kN/m³"], ["biased-pump", "biased-pump"], ["pull-in at 3 V", "pull-in at 3 V"]]) {
    assert.equal(typeset(text), set);
    if (text !== "1.5e-5 uF") assert.equal(plain(set), text);
  }
  assert.equal(plain("200 \u03bcm"), "200 um"); // the Greek letter as well as the sign
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

test("a control is made of its name, value, reset, lock, slider and error, in this order and as it stands", () => {
  const { own, row } = controls(LIST.map((c) => ({ ...c, about: "what it is" })));
  const error = (text = "", shown = false) => `${shown ? "" : "-"}p.error role=alert [span${text && ` "${text}" (${text})`}, ${shown ? "-" : ""}button.more "more" expanded=false]`;
  const buttons = (label, pressed = false) => `button.reset.tiny ‹Reset ${label}› (Reset) [svg], button.lock.tiny ‹Lock ${label}› (Lock) pressed=${pressed} [svg]`;
  const choice = (classes, more = "") => `div${classes} [label "Waveform" (what it is), span.number [select =sine${more} [option "sine" =sine, option "triangle" =triangle]], ${buttons("Waveform", Boolean(more))}, ${error()}]`;
  const radius = (classes, value, place, text, more = error()) => `div${classes} [label "Disc radius" (what it is), span.number [input:text =${value}${more === error() ? "" : " invalid=true"}], ${buttons("Disc radius")}, input:range ‹Disc radius› =${place} valuetext=${text}, ${more}]`;
  assert.deepEqual(["waveform", "disc_radius"].map((name) => made(row(name).row)), [choice(".choice.control"), radius(".control.number", "8 mm", 467, "8 mm")]);
  own.values({ disc_radius: "-4 um" }); own.fail("disc_radius", "-4 um: is wrong"); row("waveform").lock.click();
  assert.deepEqual(["waveform", "disc_radius"].map((name) => made(row(name).row)), [choice(".choice.control.locked", " disabled"), radius(".changed.control.number.wrong", "−4 µm", 0, "−4 µm", error("−4 µm: is wrong", true))]);
  assert.equal(made(own.groups), 'div.tabs ‹Groups of parameters› role=tablist [button "Body" role=tab selected=true, button "Gel" role=tab selected=false, button "Start" role=tab selected=false]');
});

test("an icon is drawn in the colour of its text, and is not read out", () => {
  for (const size of [undefined, 16]) {
    const own = icon("M0 0h9", size), [line] = own.parts, wide = String(size ?? 14);
    assert.deepEqual([own.tagName, own.attributes, line.tagName, line.attributes], ["svg", { viewBox: "0 0 16 18", width: wide, height: wide, fill: "none", stroke: "currentColor", "stroke-width": "1.6", "aria-hidden": "true" }, "path", { d: "M0 0h9" }]);
  }
});

test("the arrow of a reset goes round against the hands of a clock, most of the way", () => {
  const { row } = controls(), [head, arc] = strokes(row("disc_radius").row.querySelector(".reset")), [large, sweep, x, y] = arc.match(/A6 6 0 (\d) (\d) ([\d.]+) ([\d.]+)/).slice(1).map(Number), [, from] = arc.match(/M[\d.]+ ([\d.]+)/);
  assert.deepEqual([head, large, sweep], ["M4 4v4h4", 1, 1]);
  assert.ok(y > Number(from) && x < 8); // from the head over the top to below it
});
