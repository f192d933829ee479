// The base of the panels of long work: computed once visible and outdated, cancelled when hidden.
import { colours } from "./colours.js";
import { format, make } from "./controls.js";
import { Plot } from "./plot.js";

// Hatching of cells by kind, as lines in shares of a cell: a second cue besides colour.
const HATCHES = { 2: [[0.5, 0, 0.5, 1]], 3: [[0, 1, 1, 0]], 6: [[0, 0, 1, 1]], 4: [[0, 1, 1, 0], [0, 0, 1, 1]], [98]: [[0, 0.5, 1, 0.5]] };
const ANGLES = { 2: [90], 3: [135], 6: [45], 4: [45, 135], [98]: [0] }; // the same as stripes in a legend
const HATCH = "rgba(255, 255, 255, 0.45)";
const PAUSE = 500; // ms after the last change at which an outdated panel is computed again
export const PULLED_IN = 98, IMPOSSIBLE = 99; // kinds of cells in addition to the regimes
export const DRIVE = ["voltage_amplitude", "voltage", "voltage_offset", "voltage_bias", "frequency", "drive_frequency"];

// Name and colour of a kind of cell; unnamed kinds have the colour of invalid actuators.
export const kindOf = (legend, code) => (code === PULLED_IN ? legend.pulled_in : legend.regimes[code]) ?? { colour: colours().line };
export const regimeColour = (legend, code) => kindOf(legend, code).colour;
export const labelled = (control) => (control ? `${control.label.toLowerCase()}${control.unit ? ` (${control.unit})` : ""}` : "");

// A legend swatch with colour and stripes.
export function sample(colour, code = null) {
  const i = make("i");
  i.style.background = [...(ANGLES[code] ?? []).map((angle) => `repeating-linear-gradient(${angle}deg, ${HATCH} 0 1.5px, transparent 1.5px 5px)`), colour].join(", ");
  return i;
}

// Hatches cells [kind, left, top] of this width and height.
export function hatch(g, cells, w, h) {
  g.strokeStyle = HATCH; g.lineWidth = 1; g.beginPath();
  for (const [code, x, y] of cells) for (const [x0, y0, x1, y1] of HATCHES[code] ?? []) { g.moveTo(x + x0 * w, y + y0 * h); g.lineTo(x + x1 * w, y + y1 * h); }
  g.stroke();
}

// Calls go(event, settled) during a drag on a canvas, and settled when it ends or is interrupted.
export function holding(canvas, go) {
  let held = null;
  canvas.onpointerdown = (event) => {
    if (event.button > 0 || event.isPrimary === false) return;
    held = event;
    canvas.setPointerCapture(event.pointerId);
    go(event, false);
  };
  canvas.onpointermove = (event) => { if (held && event.isPrimary !== false) { held = event; go(event, false); } };
  canvas.onpointerup = (event) => { if (held) { held = null; go(event, true); } };
  canvas.onpointercancel = () => { const last = held; held = null; if (last) go(last, true); };
}

// A selection of numeric parameters.
export function picker(label, onchange) {
  return make("select", { "aria-label": label, title: label, onchange });
}

export function fill(select, list, chosen) {
  const numbers = list.filter((c) => c.kind === "number");
  const key = JSON.stringify(numbers.map((c) => [c.name, c.label]));
  if (select.dataset.key !== key) {
    select.dataset.key = key;
    select.replaceChildren(...numbers.map((c) => new Option(c.label, c.name)));
  }
  if (chosen) select.value = chosen;
}

export class Panel {
  /** @type {any} */ grids; kind = ""; /** @type {import("./plot.js").Plot} */ plot;
  /** @type {number | null} */ id = null; stale = true; running = false; filled = false; problem = "";
  /** @type {any} */ timer; /** @type {string | undefined} */ key;

  constructor(grids, kind) { Object.assign(this, { grids, kind }); }
  get page() { return this.grids.page; }
  control(name) { return this.page.controls().list.find((c) => c.name === name); }
  value(name) { return this.page.controls().value(name, this.page.setting().values); }
  text(name, value) { const c = this.control(name); return `${format(value)} ${c.unit}`.trim(); }
  legend() { return this.page.legend(); }

  /** @param {Plot} p */ draw(p) {} // the data
  /** @param {Plot} p */ drawOver(p) {} // the marks above them
  /** @returns {Record<string, any> | null} what is asked for besides the setting */
  request() { return {}; }

  // A key of everything that the panel depends on: what it is over, and the setting but for the values of these parameters.
  basis() {
    const { values, ...subject } = this.page.setting(), request = this.request(), over = Object.values(request ?? {}).map(([name]) => name);
    return JSON.stringify([subject, request, Object.entries(values).filter(([name]) => !over.includes(name)).sort()]);
  }

  // Marks the panel as outdated if it is of another setting.
  compare() {
    if (this.basis() === this.key) return false;
    this.key = this.basis(); this.stale = true;
    return true;
  }

  show() {
    this.plot.redraw();
    if (this.stale) this.start();
  }

  start() {
    clearTimeout(this.timer);
    const content = this.request();
    if (!content) return;
    const wrong = this.problem;
    this.problem = ""; this.key = this.basis();
    this.stale = false; this.filled = false;
    this.id = this.page.ask(this.kind, { setting: this.page.setting(), ...content });
    this.running = this.id !== null;
    if (!this.running) this.stale = true;
    if (wrong) this.plot.redraw();
    this.grids.say(this.running ? "0 %" : "");
  }

  // The setting was changed: fades the panel if it depends on that, and computes it again once the settings rest.
  changed() {
    const before = this.stale;
    if (!this.compare()) return;
    if (this.running) { this.page.ask("cancel", { grid: this.kind }); this.running = false; this.id = null; }
    clearTimeout(this.timer);
    if (this.grids.open === this) {
      this.grids.say("settings changed");
      if (!before) this.plot.redraw();
      this.timer = setTimeout(() => this.start(), PAUSE);
    }
  }

  pause() {
    clearTimeout(this.timer);
    if (!this.running) return;
    this.page.ask("cancel", { grid: this.kind });
    Object.assign(this, { running: false, id: null, stale: !this.filled || this.stale }); // without branches and curves the panel counts as filled
  }

  // Puts the plot into the page, with a name, within reach of the keyboard.
  plotIn(host, name) {
    this.plot = new Plot(host, { draw: (p) => this.draw(p), over: (p) => this.drawOver(p) });
    const { canvas } = this.plot;
    canvas.tabIndex = 0; canvas.setAttribute("role", "application"); canvas.setAttribute("aria-label", name);
    return canvas;
  }

  progress(share) { this.grids.say(share < 1 ? `${Math.round(100 * share)} %` : ""); }
  later() { this.waiting ??= requestAnimationFrame(() => { this.waiting = null; if (this.grids.open === this) this.plot.redraw(); }); }
  redrawOver() { if (this.grids.open === this) this.plot.redrawOver(); }
  nothing(p, text) { p.paragraph(this.problem || text, p.w / 2, p.h / 3, 0.7 * p.w); } // above the mark in the middle
  on_done() { this.running = false; this.filled = true; this.progress(1); }
}
