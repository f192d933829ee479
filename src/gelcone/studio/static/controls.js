// The controls of a setting, from the server's list: slider, number with unit, reset and lock, or a choice.
import { marked, turned } from "./tabs.js";

/**
 * A control as the server describes it.
 * @typedef {{name: string, label: string, group: string, kind: string, value: number | string | null, about: string, unit: string,
 *   low: number, high: number, choices: string[], powers: Record<string, number>}} Control
 */
const STEPS = 1000;
const NONE = "none"; // choice for a part that the device does not have
const SHAPES = {
  reset: "M4 4v4h4M4.6 8A6 6 0 1 1 4 11",
  lock: "M5 9V6.5a3 3 0 0 1 6 0V9M3.5 9h9v6h-9z",
  open: "M5 9V6.5a3 3 0 0 1 5.8-1M3.5 9h9v6h-9z",
};

export function icon(path, size = 14) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  for (const [name, value] of Object.entries({ viewBox: "0 0 16 18", width: size, height: size, fill: "none", stroke: "currentColor", "stroke-width": 1.6, "aria-hidden": "true" })) svg.setAttribute(name, String(value));
  const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
  line.setAttribute("d", path);
  svg.append(line);
  return svg;
}

/** @returns {any} an element with properties and children */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("aria") || name === "role" || name.startsWith("data-")) element.setAttribute(name, value); else element[name] = value;
  }
  element.append(...children);
  return element;
}

// A button that opens a sentence that has no room in its box, and closes it.
export function opener(box) {
  return make("button", { type: "button", className: "more", textContent: "more", "aria-expanded": "false", onclick() { this.setAttribute("aria-expanded", box.classList.toggle("whole")); } });
}

// Whether a text is cut short, having no room.
export const short = (text) => text.scrollWidth > text.clientWidth;

// Writes a text, optionally also as the title, only if it has changed: each write lays out the page.
export function say(element, text, titled = false) {
  if (element.textContent === text) return;
  element.textContent = text;
  if (titled) element.title = text;
}

// A number with the given significant digits, without trailing zeros, with an exponent only if very large or small.
/** @param {number} value @param {number} digits @returns {string} */
export function format(value, digits = 4) {
  if (!Number.isFinite(value)) return "";
  const text = Number(value.toPrecision(digits));
  return Math.abs(text) >= 1e6 || (text !== 0 && Math.abs(text) < 1e-4) ? text.toExponential() : String(text);
}

// A text for display, with proper signs for minus, micro and powers.
/** @type {(text: string) => string} */
export const typeset = (text) => text.replace(/-(?=[\d.])/g, "−").replace(/(?<=\d ?)u(?=[A-Za-z])/g, "µ").replace(/\^([23])/g, (_, n) => (n === "2" ? "²" : "³"));

// The inverse of typeset: typed or copied text in the form that the server reads.
/** @type {(text: string) => string} */
export const plain = (text) => text.replace(/[−–]/g, "-").replace(/[µμ]/g, "u").replace(/²/g, "^2").replace(/³/g, "^3").replace(/\u00a0/g, " ");

export class Controls {
  /** @type {HTMLElement} */ drive; /** @type {HTMLElement} */ groups; /** @type {HTMLElement} */ group; /** @type {HTMLElement} */ general;
  /** @type {(name: string, text: string | null, settled: boolean) => void} */ changed; /** @type {() => void} */ relocked;
  /** @type {Control[]} */ list; /** @type {Map<string, any>} */ rows; /** @type {Set<string>} */ locked;

  // changed(name, text or null for the default, settled): a value was set; settled once the slider is released.
  // relocked(): a lock was set or removed.
  constructor({ drive, groups, group, general, changed, relocked = () => {} }) {
    Object.assign(this, { drive, groups, group, general, changed, relocked });
    this.list = []; this.rows = new Map(); this.shown = new Map(); this.locked = new Set(); this.open = null;
  }

  // Shows a list of controls with their values; rebuilds the rows only if the list is new.
  show(list, values) {
    const key = JSON.stringify(list);
    if (key !== this.key) { this.key = key; this.list = list; this.build(); }
    this.shown = new Map();
    this.values(values);
  }

  // Shows the values; unchanged ones cost nothing.
  values(values) {
    for (const control of this.list) {
      const text = values[control.name];
      if (this.shown.has(control.name) && this.shown.get(control.name) === text) continue;
      this.set(control, text);
    }
  }

  build() {
    const names = [...new Set(this.list.map((c) => c.group))].filter((name) => name !== "Drive");
    this.rows.clear();
    this.drive.replaceChildren(...this.list.filter((c) => c.group === "Drive").map((c) => this.row(c)));
    if (!names.includes(this.open)) this.open = names[0];
    this.groups.replaceChildren(...names.map((name) => make("button", {
      type: "button", role: "tab", textContent: name, id: `tab-${name}`, "aria-controls": "group",
      onclick: () => this.choose(name),
      onkeydown: (event) => { const tabs = [...this.groups.children]; turned(event.key, tabs.find((tab) => tab.textContent === name), tabs); },
    })));
    this.pages = Object.fromEntries(names.map((name) => [name, this.list.filter((c) => c.group === name).map((c) => this.row(c))]));
    this.choose(this.open);
  }

  choose(name) {
    this.open = name;
    const tabs = [...this.groups.children];
    marked(tabs, tabs.find((tab) => tab.textContent === name));
    this.group.setAttribute("aria-labelledby", `tab-${name}`);
    this.group.replaceChildren(...this.pages[name]);
  }

  row(control) {
    const id = `c-${control.name}`, error = make("p", { className: "error", hidden: true, id: `${id}-error`, role: "alert" }, make("span"));
    error.append(opener(error));
    const label = make("label", { htmlFor: id, textContent: control.label, title: control.about });
    const reset = make("button", { type: "button", className: "tiny reset", title: "Reset", "aria-label": `Reset ${control.label}`, onclick: () => this.give(control, null, true) }, icon(SHAPES.reset));
    const lock = make("button", { type: "button", className: "tiny lock", title: "Lock", "aria-label": `Lock ${control.label}`, "aria-pressed": "false", onclick: () => this.toggle(control) }, icon(SHAPES.open));
    const row = make("div", { className: `control ${control.kind}`, "data-name": control.name });
    let number, slider = null;
    if (control.kind === "choice") {
      number = make("select", { id, onchange: () => this.give(control, number.value === NONE ? null : number.value, true) }, ...control.choices.map((c) => make("option", { value: c, textContent: c })));
    } else {
      number = make("input", { type: "text", id, autocomplete: "off", spellcheck: false, onchange: () => this.typed(control, number.value) });
      slider = make("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": control.label,
        oninput: () => this.give(control, this.text(control, this.fromSlider(control, slider.value)), false),
        onchange: () => this.give(control, this.text(control, this.fromSlider(control, slider.value)), true) });
    }
    number.setAttribute("aria-describedby", `${id}-error`);
    row.append(label, make("span", { className: "number" }, number), reset, lock, ...(slider ? [slider] : []), error);
    this.rows.set(control.name, { control, row, number, slider, error, lock });
    if (this.locked.has(control.name)) this.locks(control.name, true);
    return row;
  }

  /** @param {Control} control @param {number} place @returns {number} */
  fromSlider(control, place) { return control.low + (control.high - control.low) * (place / STEPS); }

  /** @param {Control} control @param {number} value @returns {string} */
  text(control, value) { return `${format(value)} ${control.unit}`.trim(); }

  // Takes typed text; a bare number is in the control's unit.
  typed(control, text) {
    const own = plain(text.trim());
    if (!own) return this.give(control, null, true);
    const bare = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/.test(own);
    this.give(control, bare ? `${own} ${control.unit}`.trim() : own, true);
  }

  give(control, text, settled) {
    if (this.locked.has(control.name)) return;
    this.changed(control.name, text, settled); // sent first: the answer takes longest
    this.set(control, text ?? undefined);
  }

  // The value of a control in its unit; null for a value that is not one number.
  /** @param {string} name @param {Record<string, string | undefined>} values @returns {number | null} */
  value(name, values) {
    const control = this.list.find((c) => c.name === name), text = values[name];
    if (!control) return null;
    if (text === undefined) return typeof control.value === "number" ? control.value : null;
    const found = /^([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*)$/.exec(text.trim()), number = Number(found?.[1]);
    if (!found || !Number.isFinite(number)) return null;
    if (found[2] === control.unit) return number;
    const power = (unit) => control.powers[unit];
    return power(found[2]) === undefined ? null : Number((number * 10 ** (power(found[2]) - power(control.unit))).toPrecision(12));
  }

  set(control, text) {
    this.shown.set(control.name, text);
    const { row, number, slider } = this.rows.get(control.name), usual = control.value;
    row.classList.toggle("changed", text !== undefined);
    if (control.kind === "choice") { number.value = text ?? usual ?? ""; return; }
    const shown = text ?? (usual === null ? "" : this.text(control, usual));
    number.value = typeset(shown);
    number.classList.toggle("long", shown.length > 8);
    number.placeholder = usual === null ? "automatic" : "";
    const value = this.value(control.name, { [control.name]: text });
    const share = value === null ? 0 : (value - control.low) / (control.high - control.low);
    slider.value = Math.round(STEPS * Math.min(1, Math.max(0, share)));
    slider.style.setProperty("--fill", `${(100 * slider.value) / STEPS}%`);
    slider.setAttribute("aria-valuetext", typeset(shown) || "automatic");
  }

  toggle(control) {
    const on = !this.locked.has(control.name);
    this.locked[on ? "add" : "delete"](control.name);
    this.locks(control.name, on);
    this.relocked();
  }

  // Locks the controls of these names, and no others.
  lockAll(names) {
    const before = this.locked;
    this.locked = new Set(names);
    for (const name of this.rows.keys()) if (before.has(name) !== this.locked.has(name)) this.locks(name, this.locked.has(name));
  }

  locks(name, on) {
    const { row, number, slider, lock } = this.rows.get(name);
    row.classList.toggle("locked", on); number.disabled = on;
    if (slider) slider.disabled = on;
    lock.setAttribute("aria-pressed", on);
    lock.replaceChildren(icon(on ? SHAPES.lock : SHAPES.open));
  }

  // Shows an error at its control and returns true, or below all controls and returns false.
  fail(name, message) {
    this.settle();
    const entry = this.rows.get(name) ?? this.ending(`.${name}`) ?? this.ending(`_${name}`);
    if (!entry) { this.general.textContent = typeset(message); this.general.hidden = false; return false; }
    if (entry.control.group !== "Drive" && entry.control.group !== this.open) this.choose(entry.control.group);
    entry.row.classList.add("wrong"); entry.number.setAttribute("aria-invalid", "true");
    const [text, more] = entry.error.children;
    text.textContent = text.title = typeset(message); entry.error.hidden = false; entry.error.classList.toggle("whole", false);
    more.hidden = !short(text); more.setAttribute("aria-expanded", "false");
    return true;
  }

  // The row of a control whose name ends in a text, a changed one first: hoop_prestretch for prestretch.
  ending(text) {
    const found = [...this.rows.values()].filter(({ control }) => control.name.endsWith(text));
    return found.find(({ row }) => row.classList.contains("changed")) ?? found[0];
  }

  settle() {
    this.general.hidden = true;
    for (const { row, number, error } of this.rows.values()) {
      if (error.hidden) continue;
      row.classList.remove("wrong"); number.removeAttribute("aria-invalid"); error.hidden = true;
    }
  }
}
