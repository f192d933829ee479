// What is computed over parameters while one works: a map, a sweep of one parameter, a device's envelope.
import { colours, mix } from "./colours.js";
import { format, make, say } from "./controls.js";
import { Plot, Range, extent } from "./plot.js";

const CELLS = [65, 49], PULLED_IN = 98, IMPOSSIBLE = 99, PAUSE = 500, NEAR = 6;
const DRIVE = ["voltage_amplitude", "voltage", "voltage_offset", "voltage_bias", "frequency", "drive_frequency"];
const LEFT = 5; // the kind of motions that leave the model's domain
const VIEWS = { kind: "kind of motion", exponent: "largest exponent", stroke: "stroke" };

// Name and colour of a kind of cell; those without a name are drawn as what cannot be.
const kindOf = (legend, code) => (code === PULLED_IN ? legend.pulled_in : legend.regimes[code]) ?? { colour: colours().line };
const regimeColour = (legend, code) => kindOf(legend, code).colour;
const labelled = (control) => (control ? `${control.label.toLowerCase()}${control.unit ? ` (${control.unit})` : ""}` : "");

// A choice of parameters that are numbers.
function picker(label, onchange) {
  return make("select", { "aria-label": label, title: label, onchange });
}

function fill(select, list, chosen) {
  const numbers = list.filter((c) => c.kind === "number");
  if (select.dataset.key !== JSON.stringify(numbers.map((c) => c.name))) {
    select.dataset.key = JSON.stringify(numbers.map((c) => c.name));
    select.replaceChildren(...numbers.map((c) => new Option(c.label, c.name)));
  }
  if (chosen) select.value = chosen;
}

export class GridPanels {
  constructor({ hosts, share, page }) {
    this.page = page; this.share = share;
    this.panels = { map: new MapPanel(hosts.map, this), strip: new StripPanel(hosts.strip, this), envelope: new EnvelopePanel(hosts.envelope, this) };
  }

  get open() { return this.panels[this.page.state()?.right]; }

  // Another device or preset, or one read from the address.
  applied(other) { for (const panel of Object.values(this.panels)) panel.stale = panel.stale || other ? "now" : panel.stale; }

  // The server has said which controls there are: only now is it known what there is to sweep.
  controlsChanged() { for (const panel of Object.values(this.panels)) panel.prepare(); this.opened(); }

  changed(names) {
    for (const panel of Object.values(this.panels)) {
      panel.redrawOver();
      if (panel.dependsOn(names)) panel.outdated();
    }
  }

  opened() {
    const panel = this.open;
    for (const other of Object.values(this.panels)) if (other !== panel) other.pause();
    this.say("");
    if (panel && this.page.controls().list.length) panel.show();
  }

  moved() { for (const panel of Object.values(this.panels)) panel.redrawOver(); }
  redraw() { for (const panel of Object.values(this.panels)) panel.plot.redraw(); }
  lost() { for (const panel of Object.values(this.panels)) { panel.running = false; panel.stale = "now"; } }
  say(text) { say(this.share, text); }

  message(head, arrays) {
    const panel = Object.values(this.panels).find((p) => p.id !== null && p.id === head.id);
    if (!panel) return ["grid", "cells", "done", "thresholds", "loci", "followed", "branches", "progress", "envelope"].includes(head.kind);
    panel[`on_${head.kind}`]?.(head, arrays);
    return true;
  }

  failed(head) {
    const panel = Object.values(this.panels).find((p) => p.id !== null && p.id === head.id);
    if (!panel) return false;
    panel.running = false; panel.problem = head.message; panel.id = null;
    panel.plot.redraw();
    this.say("");
    return true;
  }
}

// What the three have in common: they are asked for once they are looked at and out of date, and cancelled otherwise.
class Panel {
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

const NAMED_AT = [0.6, 0.3, 0.85, 0.1, 0.99]; // shares of a line at which its name may stand, the best first

class MapPanel extends Panel {
  constructor(host, grids) {
    super(grids, "map");
    this.x = picker("Parameter along the map", () => this.axes()); this.y = picker("Parameter up the map", () => this.axes());
    this.view = make("select", { "aria-label": "What the map shows", onchange: () => { this.page.state().view = this.view.value; this.page.keep(true); this.plot.redraw(); } },
      ...Object.entries(VIEWS).map(([name, text]) => new Option(text, name)));
    this.out = make("button", { type: "button", textContent: "Whole", title: "Back to the whole range", onclick: () => this.whole() });
    this.names = make("ul", { className: "legend" });
    host.append(make("div", { className: "bar" }, this.x, make("span", { textContent: "×" }), this.y, this.view, this.out));
    this.plot = new Plot(host, { draw: (p) => this.draw(p), over: (p) => this.drawOver(p) });
    host.append(this.names);
    this.canvas = document.createElement("canvas");
    [this.canvas.width, this.canvas.height] = CELLS;
    const c = this.plot.canvas;
    c.tabIndex = 0; c.setAttribute("role", "application"); c.setAttribute("aria-label", "Map over two parameters");
    c.onpointerdown = (event) => this.down(event);
    c.onpointermove = (event) => this.move(event);
    c.onpointerup = (event) => this.up(event);
    c.onpointercancel = () => { this.from = this.to = null; this.plot.redrawOver(); };
    c.onkeydown = (event) => this.pressed(event);
    c.onfocus = c.onblur = () => this.plot.redrawOver();
    this.blank();
  }

  blank() {
    const n = CELLS[0] * CELLS[1];
    Object.assign(this, { codes: new Uint8Array(n).fill(255), exponent: new Float32Array(n), low: new Float32Array(n), high: new Float32Array(n), lines: [], dirty: true });
  }

  // The axes of the page's state, or the usual ones.
  prepare() {
    const state = this.page.state(), { list } = this.page.controls();
    const known = (axis) => axis && list.some((c) => c.name === axis[0] && c.kind === "number");
    const usual = (c) => [c.name, c.low, c.high];
    const numbers = list.filter((c) => c.kind === "number");
    if (!known(state.x)) state.x = usual(numbers.find((c) => DRIVE.includes(c.name)) ?? numbers[0]);
    if (!known(state.y) || state.y[0] === state.x[0]) state.y = usual(["frequency", "prestretch", "drive_frequency"].map((name) => numbers.find((c) => c.name === name && name !== state.x[0])).find(Boolean) ?? numbers.find((c) => c.name !== state.x[0]));
    fill(this.x, list, state.x[0]); fill(this.y, list, state.y[0]);
    this.view.value = state.view;
    const key = JSON.stringify([state.x, state.y]);
    if (key !== this.key) { this.key = key; this.stale = "now"; this.plot.redraw(); }
  }

  axes() {
    const state = this.page.state(), pick = (select, axis) => (select.value === axis[0] ? axis : [select.value, this.control(select.value).low, this.control(select.value).high]);
    state.x = pick(this.x, state.x); state.y = pick(this.y, state.y);
    if (state.x[0] === state.y[0]) { const other = [...this.y.options].find((o) => o.value !== state.x[0]).value; state.y = [other, this.control(other).low, this.control(other).high]; }
    this.zoomed();
  }

  whole() { const state = this.page.state(); for (const axis of ["x", "y"]) { const c = this.control(state[axis][0]); state[axis] = [c.name, c.low, c.high]; } this.zoomed(); }

  zoomed() { this.page.keep(true); this.blank(); this.prepare(); this.grids.opened(); }

  dependsOn(names) { const state = this.page.state(); return names.some((name) => name !== state.x?.[0] && name !== state.y?.[0]); }

  request() { const { x, y } = this.page.state(); if (!x || !y) return null; this.fresh = true; return { x, y }; }

  on_grid() { this.blank(); }

  on_cells(head, { places, regime, exponent, low, high }) {
    for (let i = 0; i < places.length; i++) {
      const k = places[i];
      this.codes[k] = regime[i]; this.exponent[k] = exponent[i]; this.low[k] = low[i]; this.high[k] = high[i];
    }
    this.progress(head.share);
    this.dirty = true;
    this.later();
  }

  on_thresholds(head, arrays) {
    this.lines = head.names.map((name) => ({ name, x: head.upright ? arrays[name] : arrays.at, y: head.upright ? arrays.at : arrays[name] }));
    this.later();
  }

  on_done() { super.on_done(); this.running = true; this.grids.say("following thresholds …"); }

  on_loci(head, { x, y }) { this.lines.push({ name: head.name, x, y }); this.later(); }

  on_followed() { this.running = false; this.grids.say(""); }

  later() { this.waiting ??= requestAnimationFrame(() => { this.waiting = null; if (this.grids.open === this) this.plot.redraw(); }); }

  // For each cell the nearest one that is known: what the picture shows until its own turn comes.
  nearest() {
    const [nx, ny] = CELLS, from = new Int32Array(nx * ny).fill(-1), queue = [];
    this.codes.forEach((code, k) => { if (code !== 255) { from[k] = k; queue.push(k); } });
    for (let at = 0; at < queue.length; at++) {
      const k = queue[at], i = Math.floor(k / ny), j = k % ny;
      for (const [di, dj] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        const a = i + di, b = j + dj, other = a * ny + b;
        if (a >= 0 && b >= 0 && a < nx && b < ny && from[other] < 0) { from[other] = from[k]; queue.push(other); }
      }
    }
    return from;
  }

  paint() {
    this.dirty = false;
    const [nx, ny] = CELLS, from = this.nearest(), g = this.canvas.getContext("2d"), image = g.createImageData(nx, ny), c = colours();
    const shade = this.shader(from), cache = new Map();
    for (let k = 0; k < nx * ny; k++) {
      const source = from[k];
      if (source < 0) continue;
      const css = shade(source);
      if (!cache.has(css)) { const found = /^#/.test(css) ? [1, 3, 5].map((n) => parseInt(css.slice(n, n + 2), 16)) : css.match(/\d+/g).map(Number); cache.set(css, found); }
      const [red, green, blue] = cache.get(css), at = 4 * ((ny - 1 - (k % ny)) * nx + Math.floor(k / ny));
      image.data.set([red, green, blue, source === k ? 255 : 215], at);
    }
    g.clearRect(0, 0, nx, ny);
    g.putImageData(image, 0, 0);
    this.painted = document.documentElement.dataset.theme + this.view.value;
  }

  shader(from) {
    const c = colours(), legend = this.legend(), kind = this.view.value;
    if (kind === "kind") return (k) => regimeColour(legend, this.codes[k]);
    const values = kind === "exponent" ? this.exponent : this.high.map((v, k) => v - this.low[k]);
    const known = [...new Set(from)].filter((k) => k >= 0 && Number.isFinite(values[k])).map((k) => values[k]).sort((p, q) => p - q);
    const most = kind === "exponent" ? Math.max(Math.abs(known[Math.floor(0.02 * known.length)] ?? 1), Math.abs(known[Math.floor(0.98 * (known.length - 1))] ?? 1), 1e-12) : Math.max(known[Math.floor(0.99 * (known.length - 1))] ?? 1, 1e-12);
    this.most = most;
    const ground = c.dark ? "#1d242d" : "#f7f7f2";
    return (k) => {
      const v = values[k];
      if (!Number.isFinite(v)) return c.line;
      const share = Math.min(1, Math.abs(v) / most);
      if (kind === "exponent") return mix(ground, v > 0 ? "#d55e00" : "#0072b2", share);
      return share < 0.5 ? mix("#0b2a52", "#1f9e89", 2 * share) : mix("#1f9e89", "#f6e64b", 2 * share - 1);
    };
  }

  draw(p) {
    const { x, y } = this.page.state() ?? {};
    if (!x || !y || !this.legend()) return;
    p.axes(x.slice(1), y.slice(1), { xLabel: labelled(this.control(x[0])), yLabel: labelled(this.control(y[0])) });
    const c = this.control(x[0]), d = this.control(y[0]);
    this.out.disabled = x[1] === c?.low && x[2] === c?.high && y[1] === d?.low && y[2] === d?.high;
    p.canvas.setAttribute("aria-label", `Map over ${c?.label} and ${d?.label}. Arrow keys move the point, plus and minus zoom.`);
    if (!this.codes.some((code) => code !== 255)) { this.names.replaceChildren(); return this.nothing(p, this.running ? "computing …" : ""); }
    if (this.dirty || this.painted !== document.documentElement.dataset.theme + this.view.value) this.paint();
    p.inside((g) => {
      g.imageSmoothingEnabled = false;
      g.globalAlpha = this.stale ? 0.45 : 1;
      // cells are centred on their values: half of the outermost ones lies outside
      const w = (p.right - p.left) / (CELLS[0] - 1), h = (p.bottom - p.top) / (CELLS[1] - 1);
      g.drawImage(this.canvas, p.left - w / 2, p.top - h / 2, p.right - p.left + w, p.bottom - p.top + h);
    });
    this.thresholds(p);
    this.writeLegend();
  }

  // Lines over the map, each with its name where no other name is.
  thresholds(p) {
    const c = colours(), g = p.context, taken = [];
    for (const { x: xs, y: ys } of this.lines) {
      p.line(xs, ys, { colour: c.panel, width: 4 });
      p.line(xs, ys, { colour: c.ink, width: 1.6, dash: [6, 4] });
    }
    g.font = "600 11px system-ui, sans-serif";
    for (const { name, x: xs, y: ys } of this.lines) {
      const inside = [...xs.keys()].filter((i) => xs[i] > p.x[0] && xs[i] < p.x[1] && ys[i] > p.y[0] && ys[i] < p.y[1]);
      if (!inside.length) continue;
      const wide = g.measureText(name).width;
      const places = NAMED_AT.map((share) => inside[Math.floor(inside.length * share)]).map((k) => [Math.min(Math.max(p.X(xs[k]) - wide / 2, p.left + 6), p.right - wide - 6), Math.max(p.Y(ys[k]) - 12, p.top + 9)]);
      const free = places.find(([px, py]) => taken.every(([qx, qy, other]) => Math.abs(py - qy) > 17 || px > qx + other + 10 || qx > px + wide + 10));
      if (!free) continue;
      const [px, py] = free;
      taken.push([px, py, wide]);
      g.fillStyle = c.panel; g.globalAlpha = 0.85; g.beginPath(); g.roundRect(px - 5, py - 8, wide + 10, 16, 4); g.fill(); g.globalAlpha = 1;
      p.label(name, px, py, { colour: c.ink, bold: true });
    }
  }

  writeLegend() {
    const legend = this.legend(), items = [];
    if (this.view.value === "kind") {
      for (const code of [...new Set(this.codes)].filter((code) => code !== 255).sort((p, q) => p - q)) items.push([regimeColour(legend, code), code === IMPOSSIBLE ? "no such actuator" : kindOf(legend, code).name]);
    } else if (this.view.value === "exponent") items.push(["#0072b2", `attracting, to ${format(-this.most, 2)}`], ["#d55e00", `chaotic, to +${format(this.most, 2)}`]);
    else {
      const unit = this.page.look()?.about?.si ? " mm" : "";
      items.push(["#0b2a52", `0${unit}`], ["#1f9e89", `${format(this.most / 2, 2)}${unit}`], ["#f6e64b", `${format(this.most, 2)}${unit} or more`]);
    }
    const key = JSON.stringify(items);
    if (this.names.dataset.key === key) return;
    this.names.dataset.key = key;
    this.names.replaceChildren(...items.map(([colour, text]) => { const i = make("i"); i.style.background = colour; return make("li", {}, i, text); }));
  }

  drawOver(p) {
    const { x, y } = this.page.state() ?? {};
    if (!x || !y) return;
    const [x0, y0] = this.from ?? [0, 0], [x1, y1] = this.to ?? [0, 0];
    const { style } = p.mark("box", this.from && this.to ? [Math.min(x0, x1), Math.min(y0, y1)] : null);
    style.width = `${Math.abs(x1 - x0)}px`; style.height = `${Math.abs(y1 - y0)}px`;
    const vx = this.value(x[0]), vy = this.value(y[0]);
    p.mark("ring", vx === null || vy === null ? null : [Math.min(Math.max(p.X(vx), p.left), p.right), Math.min(Math.max(p.Y(vy), p.top), p.bottom)]);
  }

  place(event) { const r = this.plot.canvas.getBoundingClientRect(); return [event.clientX - r.left, event.clientY - r.top]; }

  down(event) { if (!this.plot.x) return; this.from = this.place(event); this.to = null; this.plot.canvas.setPointerCapture(event.pointerId); }

  move(event) {
    if (!this.from) return;
    const to = this.place(event);
    if (this.to || Math.hypot(to[0] - this.from[0], to[1] - this.from[1]) > NEAR) { this.to = to; this.plot.redrawOver(); }
  }

  up(event) {
    if (!this.from) return;
    const p = this.plot, [x0, y0] = this.from, to = this.to;
    this.from = this.to = null;
    if (!to) return this.goTo(p.toX(x0), p.toY(y0));
    const inside = (v, low, high) => Math.min(Math.max(v, low), high);
    const xs = [x0, to[0]].map((v) => p.toX(inside(v, p.left, p.right))).sort((a, b) => a - b), ys = [y0, to[1]].map((v) => p.toY(inside(v, p.top, p.bottom))).sort((a, b) => a - b);
    if (!(xs[1] > xs[0] && ys[1] > ys[0])) return p.redrawOver();
    const state = this.page.state(), short = (v) => Number(v.toPrecision(5));
    state.x = [state.x[0], ...xs.map(short)]; state.y = [state.y[0], ...ys.map(short)];
    this.zoomed();
  }

  goTo(vx, vy) {
    const { x, y } = this.page.state();
    const inside = (v, [, low, high]) => Math.min(Math.max(v, low), high);
    this.page.go({ [x[0]]: this.text(x[0], inside(vx, x)), [y[0]]: this.text(y[0], inside(vy, y)) });
  }

  pressed(event) {
    const { x, y } = this.page.state(), step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const vx = this.value(x[0]) ?? (x[1] + x[2]) / 2, vy = this.value(y[0]) ?? (y[1] + y[2]) / 2;
    if (step) this.goTo(vx + (step[0] * (x[2] - x[1])) / (CELLS[0] - 1), vy + (step[1] * (y[2] - y[1])) / (CELLS[1] - 1));
    else if (event.key === "+" || event.key === "-") {
      const f = event.key === "+" ? 0.5 : 2, state = this.page.state();
      for (const [axis, v, own] of [["x", vx, x], ["y", vy, y]]) {
        const half = ((own[2] - own[1]) * f) / 2, low = this.control(own[0]).low;
        const from = Math.max(low, v - half);
        state[axis] = [own[0], Number(from.toPrecision(5)), Number((from + 2 * half).toPrecision(5))];
      }
      this.zoomed();
    } else return;
    event.preventDefault();
  }
}

const MARKS = ["□", "◇", "△", "○", "▽"];

// A sign for an event, of the shape that the legend shows.
function mark(g, shape, x, y) {
  const r = 3.6, points = { "□": [[-1, -1], [1, -1], [1, 1], [-1, 1]], "◇": [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]], "△": [[0, -1.2], [1.1, 0.8], [-1.1, 0.8]], "▽": [[0, 1.2], [1.1, -0.8], [-1.1, -0.8]] }[shape];
  g.beginPath();
  if (points) points.forEach(([dx, dy], k) => g[k ? "lineTo" : "moveTo"](x + r * dx, y + r * dy)); else g.arc(x, y, r, 0, 7);
  g.closePath(); g.fill(); g.stroke();
}

class StripPanel extends Panel {
  constructor(host, grids) {
    super(grids, "strip");
    this.over = picker("Parameter of the sweep", () => { const c = this.control(this.over.value); this.page.state().over = [c.name, c.low, c.high]; this.page.keep(true); this.blank(); this.stale = "now"; this.grids.opened(); });
    this.names = make("ul", { className: "legend" });
    host.append(make("div", { className: "bar" }, this.over, this.said = make("span", { textContent: "each value from the same start", className: "right" })));
    this.plot = new Plot(host, { draw: (p) => this.draw(p), over: (p) => this.drawOver(p) });
    host.append(this.names);
    this.range = new Range();
    const c = this.plot.canvas;
    c.tabIndex = 0; c.setAttribute("role", "application"); c.setAttribute("aria-label", "Sweep of a parameter");
    c.onpointerdown = (event) => { this.held = true; c.setPointerCapture(event.pointerId); this.goTo(event, false); };
    c.onpointermove = (event) => { if (this.held) this.goTo(event, false); };
    c.onpointerup = (event) => { if (this.held) { this.held = false; this.goTo(event, true); } };
    c.onpointercancel = () => { this.held = false; };
    c.onkeydown = (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], { over } = this.page.state();
      if (!step) return;
      event.preventDefault();
      const v = this.value(over[0]) ?? over[1];
      this.page.go({ [over[0]]: this.text(over[0], Math.min(Math.max(v + (step * (over[2] - over[1])) / 240, over[1]), over[2])) });
    };
    this.blank();
  }

  blank() { this.cells = new Map(); this.branches = null; }

  // Branches of periodic orbits are followed once brute force has been everywhere.
  on_done() { super.on_done(); this.running = true; this.grids.say("following branches …"); }

  on_branches(head, arrays) {
    this.running = false;
    this.branches = { ...head, ...arrays };
    this.grids.say("");
    this.said.textContent = head.none ? "no branches here" : "each value from the same start";
    this.said.title = head.none ?? "";
    this.names.dataset.key = "";
    this.plot.redraw();
  }

  drawBranches(p) {
    const { value, section, stable, event_value: at, event_section: where, event_kind: kind } = this.branches, ink = colours().ink;
    for (const own of [0, 1]) {
      const line = Float32Array.from(section, (v, i) => (stable[i] === own ? v : NaN));
      p.line(value, line, { colour: ink, width: own ? 1.5 : 1, dash: own ? [] : [4, 3], alpha: this.stale ? 0.3 : own ? 0.95 : 0.7 });
    }
    p.inside((g) => {
      g.strokeStyle = ink; g.fillStyle = colours().panel; g.lineWidth = 1.4;
      for (let i = 0; i < at.length; i++) mark(g, MARKS[kind[i] % MARKS.length], p.X(at[i]), p.Y(where[i]));
    });
  }

  prepare() {
    const state = this.page.state(), { list } = this.page.controls();
    if (!state.over || !list.some((c) => c.name === state.over[0])) { const c = list.find((d) => DRIVE.includes(d.name)) ?? list.find((d) => d.kind === "number"); state.over = [c.name, c.low, c.high]; }
    fill(this.over, list, state.over[0]);
    const key = JSON.stringify(state.over);
    if (key !== this.key) { this.key = key; this.stale = "now"; this.blank(); }
  }

  dependsOn(names) { const { over } = this.page.state(); return names.some((name) => name !== over?.[0]); }
  request() { const { over } = this.page.state(); return over ? { over } : null; }
  on_grid(head) { this.count = head.cells[0]; this.blank(); }

  on_cells(head, { places, regime, section, low, high }) {
    const n = section.length / places.length;
    for (let i = 0; i < places.length; i++) this.cells.set(places[i], [regime[i], section.subarray(i * n, (i + 1) * n), low?.[i], high?.[i]]);
    this.progress(head.share);
    this.waiting ??= requestAnimationFrame(() => { this.waiting = null; if (this.grids.open === this) this.plot.redraw(); });
  }

  draw(p) {
    const { over } = this.page.state() ?? {};
    if (!over || !this.legend()) return;
    const axes = this.page.look()?.about?.axes;
    const cells = [...this.cells.values()], ends = cells.flatMap(([, , low, high]) => [low, high]).filter(Number.isFinite);
    p.axes(over.slice(1), this.range.fit(extent(ends, this.branches?.section ?? [], ...cells.map(([, points]) => points))), { xLabel: labelled(this.control(over[0])), yLabel: axes ? `${axes.displacement}: once a period, and its range` : "" });
    p.canvas.setAttribute("aria-label", `Sweep of ${this.control(over[0])?.label}: the section at each value. Left and right move.`);
    if (!this.cells.size) return this.nothing(p, this.running ? "computing …" : "");
    const legend = this.legend(), used = new Set();
    p.inside((g) => {
      const wide = Math.max(1.5, ((p.right - p.left) / this.count) * 0.8);
      const full = Math.max(1, (p.right - p.left) / this.count) + 0.5;
      for (const [place, [code, , low, high]] of this.cells) { // the stroke behind the section; grey where there is none
        const px = p.X(over[1] + ((over[2] - over[1]) * place) / (this.count - 1)) - full / 2, ended = code === PULLED_IN || code === LEFT;
        if (!ended && !(high > low)) continue;
        g.fillStyle = regimeColour(legend, code); g.globalAlpha = (this.stale ? 0.5 : 1) * (ended ? 0.45 : 0.16);
        if (ended) g.fillRect(px, p.top, full, p.bottom - p.top); else g.fillRect(px, p.Y(high), full, p.Y(low) - p.Y(high));
      }
      for (const [place, [code, points]] of this.cells) {
        const px = p.X(over[1] + ((over[2] - over[1]) * place) / (this.count - 1)) - wide / 2;
        used.add(code);
        g.fillStyle = regimeColour(legend, code);
        g.globalAlpha = (this.stale ? 0.35 : 1) * (code === 3 ? 0.75 : 1);
        for (let i = 0; i < points.length; i++) g.fillRect(px, p.Y(points[i]) - 0.9, wide, 1.8);
      }
    });
    if (this.branches?.value) this.drawBranches(p);
    const key = [...used].sort().join();
    if (this.names.dataset.key === key) return;
    this.names.dataset.key = key;
    const lines = !this.branches?.value ? [] : ["— stable orbits", "┄ unstable", ...this.branches.kinds.map((name, k) => `${MARKS[k % MARKS.length]} ${name}`)];
    this.names.replaceChildren(...lines.map((text) => make("li", {}, text)), ...[...used].sort((a, b) => a - b).filter((code) => code !== IMPOSSIBLE).map((code) => { const i = make("i"); i.style.background = regimeColour(legend, code); return make("li", {}, i, kindOf(legend, code).name); }));
  }

  drawOver(p) {
    const { over } = this.page.state() ?? {}, v = over ? this.value(over[0]) : null;
    p.upright(v !== null && v >= over[1] && v <= over[2] ? p.X(v) : null);
  }

  goTo(event, settled) {
    const { over } = this.page.state(), r = this.plot.canvas.getBoundingClientRect();
    if (!this.plot.x) return;
    const v = Math.min(Math.max(this.plot.toX(event.clientX - r.left), over[1]), over[2]);
    this.page.go({ [over[0]]: this.text(over[0], v) }, settled);
  }
}

class EnvelopePanel extends Panel {
  constructor(host, grids) {
    super(grids, "envelope");
    this.words = make("span", {});
    host.append(make("div", { className: "bar" }, this.words));
    this.plot = new Plot(host, { draw: (p) => this.draw(p), over: (p) => this.drawOver(p) });
    const c = this.plot.canvas;
    c.tabIndex = 0; c.setAttribute("role", "application");
    c.setAttribute("aria-label", "Operating envelope: drive frequency and peak voltage. Arrow keys move the device's own drive.");
    c.onpointerdown = (event) => { this.held = true; c.setPointerCapture(event.pointerId); this.goTo(event, false); };
    c.onpointermove = (event) => { if (this.held) this.goTo(event, false); };
    c.onpointerup = (event) => { if (this.held) { this.held = false; this.goTo(event, true); } };
    c.onpointercancel = () => { this.held = false; };
    c.onkeydown = (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step || !this.plot.x) return;
      event.preventDefault();
      const [f, v] = this.own();
      this.drive(f + (step[0] * (this.plot.x[1] - this.plot.x[0])) / 60, v + (step[1] * (this.plot.y[1] - this.plot.y[0])) / 60, true);
    };
  }

  prepare() { const key = this.basis(); if (key !== this.key) { this.key = key; this.stale = "now"; } }

  // All that the envelope depends on: not the frequency, and of the voltages only their proportion.
  basis() {
    const own = this.page.setting(), { frequency, voltage_amplitude, voltage_offset, ...rest } = own.values;
    const [a, o] = [this.volts("voltage_amplitude"), this.volts("voltage_offset")];
    return JSON.stringify([own.device, own.file, rest, a ? Number((o / a).toPrecision(3)) : null]);
  }

  dependsOn() { return this.basis() !== this.key; }
  outdated() { this.key = this.basis(); super.outdated(); }
  request() { this.key = this.basis(); return {}; }
  volts(name) { const c = this.control(name), v = this.value(name); return c && v !== null ? v * (c.unit === "kV" ? 1000 : c.unit === "mV" ? 0.001 : 1) : 0; }
  hertz() { const c = this.control("frequency"), v = this.value("frequency"); return c && v !== null ? v * (c.unit === "kHz" ? 1000 : c.unit === "mHz" ? 0.001 : 1) : 0; }
  own() { return [this.hertz(), this.volts("voltage_amplitude") + Math.abs(this.volts("voltage_offset"))]; }

  on_progress(head) { this.progress(Math.min(head.share, 0.99)); }

  on_envelope(head, arrays) {
    this.found = { ...head, arrays };
    this.on_done();
    this.plot.redraw();
  }

  draw(p) {
    const found = this.found, c = colours();
    if (!found) return this.nothing(p, this.running ? "computing the envelope; some seconds …" : "");
    const { frequency, window } = found.arrays;
    p.axes([0, frequency.at(-1)], [0, found.highest], { xLabel: "drive frequency (Hz)", yLabel: "peak voltage (V)" });
    const faded = this.stale ? 0.4 : 1;
    p.inside((g) => {
      g.globalAlpha = 0.25 * faded; g.fillStyle = c.taut;
      g.beginPath(); g.moveTo(p.X(frequency[0]), p.bottom);
      for (let i = 0; i < frequency.length; i++) g.lineTo(p.X(frequency[i]), p.Y(window[i]));
      g.lineTo(p.X(frequency.at(-1)), p.bottom); g.closePath(); g.fill();
    });
    p.line(frequency, window, { colour: c.taut, width: 2, alpha: faded });
    const inks = [c.breakdown, c.around, c.meridian, c.both, c.a, c.edge];
    const shown = found.limits.map((name, k) => [name, found.arrays[`limit ${name}`], inks[k % inks.length]]).filter(([, values]) => values.some((v) => Number.isFinite(v)));
    for (const [, values, colour] of shown) {
      p.line(frequency, values, { colour, width: 1.6, alpha: faded });
      p.points(frequency, values, { colour, size: 4, alpha: faded });
    }
    let row = 0;
    const named = (name) => (/^pull.in$/.test(name) ? `pull-in of the ${found.pull_in_of}` : name.replaceAll("_", " "));
    for (const [name, , colour] of shown) p.label(named(name), p.right - 6, p.top + 10 + 14 * row++, { align: "right", colour, bold: true });
    for (const [name, v] of Object.entries(found.static)) {
      if (!Number.isFinite(v) || v === null || v > found.highest) continue;
      p.inside((g) => { g.strokeStyle = c.edge; g.setLineDash([3, 4]); g.beginPath(); g.moveTo(p.left, p.Y(v)); g.lineTo(p.right, p.Y(v)); g.stroke(); });
      p.label(`${named(name)}, slowly`, p.left + 6, p.Y(v) - 7);
    }
    p.label("recommended", p.left + 8, p.bottom - 10, { colour: c.taut, bold: true });
  }

  drawOver(p) {
    if (!this.found) return;
    const [f, v] = this.own();
    p.mark("ring", [Math.min(p.X(f), p.right), Math.max(p.Y(v), p.top)]);
    say(this.words, this.verdict(f, v));
  }

  verdict(f, v) {
    const { frequency, window } = this.found.arrays, k = frequency.findIndex((own) => own >= f);
    const at = `own drive: ${format(f, 3)} Hz, peak ${format(v, 4)} V`;
    if (k < 0) return `${at}, beyond what was examined`;
    const j = Math.max(k - 1, 0), share = k === j ? 0 : (f - frequency[j]) / (frequency[k] - frequency[j]);
    const most = window[j] + (window[k] - window[j]) * Math.min(Math.max(share, 0), 1);
    return v <= most ? `${at}: inside the window (up to ${format(most, 3)} V)` : `${at}: above the window (${format(most, 3)} V)`;
  }

  goTo(event, settled) {
    const r = this.plot.canvas.getBoundingClientRect();
    if (this.plot.x && this.found) this.drive(this.plot.toX(event.clientX - r.left), this.plot.toY(event.clientY - r.top), settled);
  }

  // Moves the own drive: the frequency, and amplitude and offset in their proportion.
  drive(f, v, settled) {
    const p = this.plot, a = this.volts("voltage_amplitude"), o = this.volts("voltage_offset"), peak = a + Math.abs(o);
    const freq = Math.min(Math.max(f, p.x[1] / 500), p.x[1]), volts = Math.min(Math.max(v, p.y[1] / 500), p.y[1]);
    const scaled = peak ? volts / peak : 0;
    this.page.go({ frequency: `${format(freq)} Hz`, voltage_amplitude: `${format(peak ? a * scaled : volts, 6)} V`, ...(o ? { voltage_offset: `${format(o * scaled, 6)} V` } : {}) }, settled);
  }
}
