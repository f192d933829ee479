// A map over two parameters: kinds of motion cell by cell, thresholds and the curves of bifurcations.
import { colours, mix } from "./colours.js";
import { format, make } from "./controls.js";
import { FONT } from "./plot.js";
import { DRIVE, IMPOSSIBLE, Panel, fill, hatch, kindOf, labelled, picker, regimeColour, sample } from "./work.js";

const CELLS = [65, 49], NEAR = 6;
const VIEWS = { kind: "kind of motion", exponent: "largest exponent", stroke: "stroke" };
const NAMED_AT = [0.6, 0.3, 0.85, 0.1, 0.99]; // shares of a line at which its name may be placed, the best first

export class MapPanel extends Panel {
  /** @type {Uint8Array} */ codes; /** @type {Float32Array} */ exponent; /** @type {Float32Array} */ low; /** @type {Float32Array} */ high;
  /** @type {any[]} */ lines; /** @type {Int32Array | null} */ sources; /** @type {number[] | null} */ from = null; /** @type {number[] | null} */ to = null; dirty = true;

  constructor(host, grids) {
    super(grids, "map");
    this.x = picker("Parameter along the map", () => this.axes()); this.y = picker("Parameter up the map", () => this.axes());
    this.view = make("select", { "aria-label": "What the map shows", onchange: () => { this.page.state().view = this.view.value; this.page.keep(true); this.plot.redraw(); } },
      ...Object.entries(VIEWS).map(([name, text]) => new Option(text, name)));
    this.out = make("button", { type: "button", textContent: "Full range", title: "Show the full range of both parameters", onclick: () => this.whole() });
    this.names = make("ul", { className: "legend" });
    host.append(make("div", { className: "bar" }, this.x, make("span", { textContent: "×" }), this.y, this.view, this.out));
    const c = this.plotIn(host, "Map over two parameters");
    host.append(this.names);
    this.canvas = document.createElement("canvas");
    [this.canvas.width, this.canvas.height] = CELLS;
    c.onpointerdown = (event) => this.down(event);
    c.onpointermove = (event) => this.move(event);
    c.onpointerup = (event) => this.up(event);
    c.onpointercancel = () => { this.from = this.to = null; this.plot.redrawOver(); };
    c.onkeydown = (event) => this.pressed(event);
    this.blank();
  }

  blank() {
    const n = CELLS[0] * CELLS[1];
    Object.assign(this, { codes: new Uint8Array(n).fill(255), exponent: new Float32Array(n), low: new Float32Array(n), high: new Float32Array(n), lines: [], sources: null, dirty: true });
  }

  // Sets the axes from the page's state, or the defaults.
  prepare() {
    const state = this.page.state(), { list } = this.page.controls();
    const known = (axis) => axis && list.some((c) => c.name === axis[0] && c.kind === "number");
    const usual = (c) => [c.name, c.low, c.high];
    const numbers = list.filter((c) => c.kind === "number");
    if (!known(state.x)) state.x = usual(numbers.find((c) => DRIVE.includes(c.name)) ?? numbers[0]);
    if (!known(state.y) || state.y[0] === state.x[0]) state.y = usual(["frequency", "prestretch", "drive_frequency"].map((name) => numbers.find((c) => c.name === name && name !== state.x[0])).find(Boolean) ?? numbers.find((c) => c.name !== state.x[0]));
    fill(this.x, list, state.x[0]); fill(this.y, list, state.y[0]);
    this.view.value = state.view;
    if (this.compare()) this.plot.redraw();
  }

  axes() {
    const state = this.page.state(), pick = (select, axis) => (select.value === axis[0] ? axis : [select.value, this.control(select.value).low, this.control(select.value).high]);
    state.x = pick(this.x, state.x); state.y = pick(this.y, state.y);
    this.zoomed();
  }

  whole() { const state = this.page.state(); for (const axis of ["x", "y"]) { const c = this.control(state[axis][0]); state[axis] = [c.name, c.low, c.high]; } this.zoomed(); }

  zoomed() { this.page.keep(true); this.blank(); this.prepare(); this.grids.opened(); }

  request() { const { x, y } = this.page.state(); return x && y ? { x, y } : null; }

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

  on_done() { super.on_done(); this.running = true; this.grids.say("following bifurcations …"); }

  on_loci(head, { x, y }) { this.lines.push({ name: head.name, x, y }); this.later(); }

  on_followed() { this.running = false; this.grids.say(""); }

  // For each cell the nearest known one, which the picture shows until the cell is computed.
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

  // The kinds of all cells that can be drawn, with their places: [kind, along, up].
  kinds() {
    const ny = CELLS[1], found = [];
    this.sources?.forEach((source, k) => { if (source >= 0) found.push([this.codes[source], Math.floor(k / ny), k % ny]); });
    return found;
  }

  paint() {
    this.dirty = false;
    const [nx, ny] = CELLS, from = (this.sources = this.nearest()), g = this.canvas.getContext("2d"), image = g.createImageData(nx, ny);
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
    if (!x || !y) return;
    p.axes(x.slice(1), y.slice(1), { xLabel: labelled(this.control(x[0])), yLabel: labelled(this.control(y[0])) });
    const c = this.control(x[0]), d = this.control(y[0]);
    this.out.disabled = x[1] === c?.low && x[2] === c?.high && y[1] === d?.low && y[2] === d?.high;
    p.canvas.setAttribute("aria-label", `Map over ${c?.label} and ${d?.label}. Arrow keys move the point, plus and minus zoom.`);
    if (!this.codes.some((code) => code !== 255)) { this.names.replaceChildren(); this.names.dataset.key = ""; return this.nothing(p, this.running ? "computing …" : ""); }
    if (this.dirty || this.painted !== document.documentElement.dataset.theme + this.view.value) this.paint();
    p.inside((g) => {
      g.imageSmoothingEnabled = false;
      g.globalAlpha = this.stale ? 0.45 : 1;
      // cells are centred on their values: the outer half of a border cell lies outside
      const w = (p.right - p.left) / (CELLS[0] - 1), h = (p.bottom - p.top) / (CELLS[1] - 1);
      g.drawImage(this.canvas, p.left - w / 2, p.top - h / 2, p.right - p.left + w, p.bottom - p.top + h);
      if (this.view.value === "kind") hatch(g, this.kinds().map(([code, i, j]) => [code, p.left + (i - 0.5) * w, p.bottom - (j + 0.5) * h]), w, h);
    });
    this.thresholds(p);
    this.writeLegend();
  }

  // Draws the lines, each with its name where it does not overlap others.
  thresholds(p) {
    const c = colours(), g = p.context, taken = [];
    for (const { x: xs, y: ys } of this.lines) {
      p.line(xs, ys, { colour: c.panel, width: 4 });
      p.line(xs, ys, { colour: c.ink, width: 1.6, dash: [6, 4] });
    }
    g.font = `600 ${FONT}`;
    for (const { name, x: xs, y: ys } of this.lines) {
      const inside = [...xs.keys()].filter((i) => xs[i] > p.x[0] && xs[i] < p.x[1] && ys[i] > p.y[0] && ys[i] < p.y[1]);
      if (!inside.length) continue;
      const wide = g.measureText(name).width;
      const places = NAMED_AT.map((share) => inside[Math.floor(inside.length * share)]).map((k) => [Math.min(Math.max(p.X(xs[k]) - wide / 2, p.left + 6), p.right - wide - 6), Math.max(p.Y(ys[k]) - 12, p.top + 9)]);
      const free = places.find(([px, py]) => taken.every(([qx, qy, other]) => Math.abs(py - qy) > 17 || px > qx + other + 10 || qx > px + wide + 10));
      if (!free) continue;
      const [px, py] = free;
      taken.push([px, py, wide]);
      p.label(name, px, py, { colour: c.ink, bold: true, plate: true });
    }
  }

  writeLegend() {
    const legend = this.legend(), items = [];
    if (this.view.value === "kind") {
      for (const code of [...new Set(this.codes)].filter((code) => code !== 255).sort((p, q) => p - q)) items.push([regimeColour(legend, code), code === IMPOSSIBLE ? "not a valid actuator" : kindOf(legend, code).name, code]);
    } else if (this.view.value === "exponent") items.push(["#0072b2", `attracting, to ${format(-this.most, 2)}`], ["#d55e00", `chaotic, to +${format(this.most, 2)}`]);
    else {
      const unit = this.page.look()?.about?.si ? " mm" : "";
      items.push(["#0b2a52", `0${unit}`], ["#1f9e89", `${format(this.most / 2, 2)}${unit}`], ["#f6e64b", `${format(this.most, 2)}${unit} or more`]);
    }
    const key = JSON.stringify(items);
    if (this.names.dataset.key === key) return;
    this.names.dataset.key = key;
    this.names.replaceChildren(...items.map(([colour, text, code]) => make("li", {}, sample(colour, code), text)));
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

  down(event) { if (!this.plot.x || event.button > 0 || event.isPrimary === false) return; this.from = this.place(event); this.to = null; this.plot.canvas.setPointerCapture(event.pointerId); }

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
