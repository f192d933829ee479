// A sweep of one parameter: the section at each value with its range, and branches of periodic orbits.
import { colours } from "./colours.js";
import { make } from "./controls.js";
import { Range, extent } from "./plot.js";
import { DRIVE, IMPOSSIBLE, PULLED_IN, Panel, fill, holding, kindOf, labelled, picker, regimeColour, sample } from "./work.js";

const LEFT = 5; // the regime of motions that leave the model's domain
const MARKS = ["□", "◇", "△", "○", "▽"];

// Draws an event's marker in the shape that the legend shows.
function mark(g, shape, x, y) {
  const r = 3.6, points = { "□": [[-1, -1], [1, -1], [1, 1], [-1, 1]], "◇": [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]], "△": [[0, -1.2], [1.1, 0.8], [-1.1, 0.8]], "▽": [[0, 1.2], [1.1, -0.8], [-1.1, -0.8]] }[shape];
  g.beginPath();
  if (points) points.forEach(([dx, dy], k) => g[k ? "lineTo" : "moveTo"](x + r * dx, y + r * dy)); else g.arc(x, y, r, 0, 7);
  g.closePath(); g.fill(); g.stroke();
}

export class StripPanel extends Panel {
  constructor(host, grids) {
    super(grids, "strip");
    this.over = picker("Parameter of the sweep", () => { const c = this.control(this.over.value); this.page.state().over = [c.name, c.low, c.high]; this.page.keep(true); this.blank(); this.stale = true; this.grids.opened(); });
    this.names = make("ul", { className: "legend" });
    host.append(make("div", { className: "bar" }, this.over, this.note = make("span", { textContent: "each value from the same start", className: "right" })));
    const c = this.plotIn(host, "Sweep of a parameter");
    host.append(this.names);
    this.range = new Range();
    holding(c, (event, settled) => this.goTo(event, settled));
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

  // The branches are followed after the last cell.
  on_done() { super.on_done(); this.running = true; this.grids.say("following branches …"); }

  on_branches(head, arrays) {
    this.running = false;
    this.branches = { ...head, ...arrays };
    this.grids.say("");
    this.note.textContent = head.none ? "no branches here" : "each value from the same start";
    this.note.title = head.none ?? "";
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
    if (this.along !== JSON.stringify(state.over)) { this.along = JSON.stringify(state.over); this.blank(); }
    this.compare();
  }

  request() { const { over } = this.page.state(); return over ? { over } : null; }
  on_grid(head) { this.count = head.cells[0]; this.blank(); }

  on_cells(head, { places, regime, section, low, high }) {
    const n = section.length / places.length;
    for (let i = 0; i < places.length; i++) this.cells.set(places[i], [regime[i], section.subarray(i * n, (i + 1) * n), low?.[i], high?.[i]]);
    this.progress(head.share);
    this.later();
  }

  draw(p) {
    const { over } = this.page.state() ?? {};
    if (!over) return;
    const axes = this.page.look()?.about?.axes;
    const cells = [...this.cells.values()], ends = cells.flatMap(([, , low, high]) => [low, high]).filter(Number.isFinite);
    p.axes(over.slice(1), this.range.fit(extent(ends, this.branches?.section ?? [], ...cells.map(([, points]) => points))), { xLabel: labelled(this.control(over[0])), yLabel: axes ? `${axes.displacement}: once per period; shaded: range` : "" });
    p.canvas.setAttribute("aria-label", `Sweep of ${this.control(over[0])?.label}: the section at each value. Left and right move.`);
    if (!this.cells.size) return this.nothing(p, this.running ? "computing …" : "");
    const legend = this.legend(), used = new Set();
    p.inside((g) => {
      const wide = Math.max(1.5, ((p.right - p.left) / this.count) * 0.8);
      const full = Math.max(1, (p.right - p.left) / this.count) + 0.5;
      for (const [place, [code, , low, high]] of this.cells) { // the range behind the section; grey where the motion ended
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
    const lines = !this.branches?.value ? [] : ["— stable orbits", "┄ unstable", ...this.branches.kinds.map((name, k) => `${MARKS[k % MARKS.length]} ${name}`)];
    const key = JSON.stringify([lines, [...used].sort()]);
    if (this.names.dataset.key === key) return;
    this.names.dataset.key = key;
    this.names.replaceChildren(...lines.map((text) => make("li", {}, text)), ...[...used].sort((a, b) => a - b).filter((code) => code !== IMPOSSIBLE).map((code) => make("li", {}, sample(regimeColour(legend, code)), kindOf(legend, code).name)));
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
