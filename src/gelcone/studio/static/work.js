// What panels of long work share: they are asked for once they are looked at and out of date, and cancelled otherwise.
import { colours } from "./colours.js";
import { format, make } from "./controls.js";

const PAUSE = 500; // ms without a change after which an outdated panel is computed again
export const PULLED_IN = 98, IMPOSSIBLE = 99; // kinds of cells besides those of motion
export const DRIVE = ["voltage_amplitude", "voltage", "voltage_offset", "voltage_bias", "frequency", "drive_frequency"];

// Name and colour of a kind of cell; those without a name are drawn as what cannot be.
export const kindOf = (legend, code) => (code === PULLED_IN ? legend.pulled_in : legend.regimes[code]) ?? { colour: colours().line };
export const regimeColour = (legend, code) => kindOf(legend, code).colour;
export const labelled = (control) => (control ? `${control.label.toLowerCase()}${control.unit ? ` (${control.unit})` : ""}` : "");

// A choice of parameters that are numbers.
export function picker(label, onchange) {
  return make("select", { "aria-label": label, title: label, onchange });
}

export function fill(select, list, chosen) {
  const numbers = list.filter((c) => c.kind === "number");
  if (select.dataset.key !== JSON.stringify(numbers.map((c) => c.name))) {
    select.dataset.key = JSON.stringify(numbers.map((c) => c.name));
    select.replaceChildren(...numbers.map((c) => new Option(c.label, c.name)));
  }
  if (chosen) select.value = chosen;
}

export class Panel {
  constructor(grids, kind) { Object.assign(this, { grids, kind, id: null, stale: "now", running: false, filled: false, problem: "" }); }
  get page() { return this.grids.page; }
  control(name) { return this.page.controls().list.find((c) => c.name === name); }
  value(name) { return this.page.controls().value(name, this.page.setting().values); }
  text(name, value) { const c = this.control(name); return `${format(value)} ${c.unit}`.trim(); }
  legend() { return this.page.legend(); }

  show() {
    this.plot.redraw();
    if (this.stale) this.start();
  }

  start() {
    clearTimeout(this.timer);
    const content = this.request();
    if (!content) return;
    this.problem = "";
    this.stale = null; this.filled = false;
    this.id = this.page.ask(this.kind, { setting: this.page.setting(), ...content });
    this.running = this.id !== null;
    if (!this.running) this.stale = "now";
    this.grids.say(this.running ? "0 %" : "");
  }

  // Something that it rests on has changed: what is drawn is faded, and computed again once the hand rests.
  outdated() {
    if (this.running) { this.page.ask("cancel", { grid: this.kind }); this.running = false; this.id = null; }
    const before = this.stale;
    this.stale = "later";
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
    Object.assign(this, { running: false, id: null, stale: this.filled ? this.stale : "now" }); // without what was followed
  }

  progress(share) { this.grids.say(share < 1 ? `${Math.round(100 * share)} %` : ""); }
  redrawOver() { if (this.grids.open === this) this.plot.redrawOver(); }
  nothing(p, text) { p.paragraph(this.problem || text, p.w / 2, p.h / 3, 0.7 * p.w); } // clear of the mark in the middle
  on_done() { this.running = false; this.filled = true; this.progress(1); }
}
