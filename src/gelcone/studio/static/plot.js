// Two-dimensional plots on a canvas: axes with round numbers, lines, points; dense lines are filled column by column.
import { colours } from "./colours.js";
import { format, make, typeset } from "./controls.js";

export const FONT = "11px system-ui, 'Segoe UI', Roboto, sans-serif";

/** @param {number} low @param {number} high @param {number} most @returns {[number, string][]} places and texts */
export function ticks(low, high, most) {
  const rough = (high - low) / Math.max(most, 1), power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((f) => f * power >= rough * 0.999) * power, found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step + 0);
  const digits = Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  const text = (v) => (digits > 3 && v ? Number(v.toPrecision(3)).toExponential() : Math.abs(v) < 1e5 || v === 0 ? v.toFixed(digits > 3 ? 0 : digits) : v.toPrecision(2));
  return found.map((v) => [v, typeset(text(v))]);
}

/** @param {...ArrayLike<number>} arrays @returns {[number, number]} */
export function extent(...arrays) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays) for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return [low, high];
}

// A text broken into lines of at most a number of pixels.
/** @param {{measureText: (text: string) => {width: number}}} g @param {string} text @param {number} most @returns {string[]} */
export function broken(g, text, most) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (lines.at(-1) && g.measureText(longer).width > most) lines.push(word); else lines[lines.length - 1] = longer;
  }
  return lines;
}

const NOTHING = 1e-9, LEAST = 1e-6; // values up to this are rounding; the least size of a range

// An axis range that contains the data and changes only if necessary, so that plots stay steady under a slider.
export class Range {
  low = NaN; high = NaN;

  /** @param {[number, number]} range @returns {[number, number]} */
  fit([low, high]) {
    if (!(high >= low)) { low = 0; high = 1; }
    const flat = Math.max(Math.abs(low), Math.abs(high)) < NOTHING;
    const size = Math.max(high - low, flat ? 1 : LEAST, 0.02 * Math.max(Math.abs(low), Math.abs(high)));
    const middle = (low + high) / 2, half = Math.max(high - low, size) / 2;
    low = middle - half; high = middle + half;
    const own = this.high - this.low;
    if (!(low >= this.low && high <= this.high && high - low > 0.6 * own)) {
      this.low = low - 0.08 * size; this.high = high + 0.08 * size;
    }
    return [this.low, this.high];
  }
}

export class Plot {
  /** @type {HTMLDivElement} */ box; /** @type {HTMLCanvasElement} */ canvas; /** @type {CanvasRenderingContext2D} */ context;
  /** @type {{left: number, bottom: number, top: number, right: number}} */ margin; /** @type {Map<string, HTMLElement>} */ marks;
  /** @type {(plot: Plot) => void} */ draw; /** @type {((plot: Plot) => void) | null} */ over;
  w = 0; h = 0; d = 1; left = 0; right = 0; top = 0; bottom = 0;
  /** @type {[number, number] | undefined} */ x; /** @type {[number, number] | undefined} */ y;
  /** @type {(v: number) => number} */ X; /** @type {(v: number) => number} */ Y; /** @type {(px: number) => number} */ toX; /** @type {(py: number) => number} */ toY;
  logarithmic = false;

  // host: an element; draw(plot) draws the data; over(plot) moves the marks above them.
  constructor(host, { draw = () => {}, over = null, top = 8 } = {}) {
    this.box = Object.assign(document.createElement("div"), { className: "plot" });
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.box.append(this.canvas);
    this.reading = make("output", { className: "reading", hidden: true });
    this.box.append(this.reading);
    this.box.addEventListener("pointermove", (event) => this.read(event));
    this.box.addEventListener("pointerleave", () => { this.reading.hidden = true; });
    host.append(this.box);
    Object.assign(this, { draw, over, margin: { left: 56, bottom: 34, top, right: 20 }, marks: new Map() });
    new ResizeObserver(() => { this.fit(); this.redraw(); }).observe(this.box);
    this.fit();
  }

  fit() {
    const d = devicePixelRatio, w = this.box.clientWidth, h = this.box.clientHeight;
    Object.assign(this, { w, h, d });
    this.canvas.width = Math.round(w * d); this.canvas.height = Math.round(h * d);
  }

  redraw() {
    if (!this.w || !this.h) return;
    this.context.setTransform(this.d, 0, 0, this.d, 0, 0);
    this.context.fillStyle = colours().panel;
    this.context.fillRect(0, 0, this.w, this.h);
    this.x = undefined; // a plot that says why it is empty has no axes
    this.draw(this);
    if (!this.x) for (const own of [this.reading, ...this.marks.values()]) own.hidden = true;
    this.redrawOver();
  }

  // Shows the coordinates under the pointer.
  read(event) {
    const r = this.canvas.getBoundingClientRect(), px = event.clientX - r.left, py = event.clientY - r.top;
    const inside = this.x && px >= this.left && px <= this.right && py >= this.top && py <= this.bottom;
    this.reading.hidden = !inside;
    if (inside) this.reading.textContent = typeset(`${format(this.toX(px), 3)}, ${format(this.logarithmic ? 10 ** this.toY(py) : this.toY(py), 3)}`);
  }

  redrawOver() {
    if (this.over && this.w && this.x) this.over(this);
  }

  // Moves a mark (line, dot, ring or box) above the plot to a place in pixels, without redrawing; hides it without a
  // place.
  mark(kind, at, name = kind) {
    let own = this.marks.get(name);
    if (!own) {
      own = Object.assign(document.createElement("i"), { className: `mark ${kind}` });
      this.marks.set(name, own);
      this.box.append(own);
    }
    own.hidden = !at;
    if (at) own.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px)`;
    return own;
  }

  // Moves the vertical line to a place along the plot.
  upright(px, top = this.top, bottom = this.bottom) {
    this.mark("line", px === null ? null : [px, top]).style.height = `${bottom - top}px`;
  }

  // Draws axes for the ranges x and y between the shares ``from`` and ``to`` of the height; sets the scales X and Y.
  axes(x, y, { xLabel = "", yLabel = "", from = 0, to = 1, xTicks = true, yText = null } = {}) {
    const g = this.context, c = colours(), m = this.margin;
    const inner = this.h - m.top - m.bottom, top = m.top + from * inner, bottom = m.top + to * inner;
    const left = m.left, right = this.w - m.right;
    const sx = (right - left) / (x[1] - x[0]), sy = (bottom - top) / (y[1] - y[0]);
    Object.assign(this, { x, y, left, right, top, bottom, X: (v) => left + (v - x[0]) * sx, Y: (v) => bottom - (v - y[0]) * sy });
    this.logarithmic = Boolean(yText);
    this.toX = (px) => x[0] + (px - left) / sx;
    this.toY = (py) => y[0] + (bottom - py) / sy;
    g.font = FONT; g.lineWidth = 1; g.strokeStyle = c.line; g.fillStyle = c.soft; g.beginPath();
    g.textAlign = "center"; g.textBaseline = "top";
    for (const [v, text] of ticks(x[0], x[1], (right - left) / 76)) {
      const p = Math.round(this.X(v)) + 0.5;
      g.moveTo(p, top); g.lineTo(p, bottom);
      if (xTicks) g.fillText(text, p, bottom + 4);
    }
    g.textAlign = "right"; g.textBaseline = "middle";
    for (const [v, text] of ticks(y[0], y[1], Math.max(3, (bottom - top) / 38))) {
      const p = Math.round(this.Y(v)) + 0.5;
      g.moveTo(left, p); g.lineTo(right, p);
      g.fillText(yText ? yText(v) : text, left - 5, p);
    }
    g.stroke();
    g.textAlign = "center";
    const across = (left + right) / 2, up = (top + bottom) / 2, room = (middle, size) => 2 * Math.min(middle, size - middle); // a longer name is written narrower
    if (xLabel) { g.textBaseline = "bottom"; g.fillText(xLabel, across, this.h - 1, room(across, this.w)); }
    if (yLabel) {
      g.save(); g.translate(7, up); g.rotate(-Math.PI / 2);
      g.textBaseline = "middle"; g.fillText(yLabel, 0, 0, room(up, this.h)); g.restore();
    }
  }

  // Clips drawing to the axes.
  inside(draw) {
    const g = this.context;
    g.save(); g.beginPath(); g.rect(this.left, this.top - 1, this.right - this.left, this.bottom - this.top + 2); g.clip();
    draw(g); g.restore();
  }

  line(x, y, { colour, width = 1.3, alpha = 1, sorted = false, dash = [], most = Infinity }) {
    this.inside((g) => {
      g.globalAlpha = alpha; g.strokeStyle = g.fillStyle = colour; g.lineWidth = width; g.lineJoin = "bevel"; g.setLineDash(dash);
      if (sorted && x.length > 1.5 * (this.right - this.left) * this.d) return this.columns(g, x, y, dash);
      g.beginPath();
      let down = false;
      for (let i = 0, end = Math.min(x.length, most); i < end; i++) {
        if (!Number.isFinite(y[i]) || !Number.isFinite(x[i])) { down = false; continue; } // a gap, not a line across it
        if (down) g.lineTo(this.X(x[i]), this.Y(y[i])); else g.moveTo(this.X(x[i]), this.Y(y[i]));
        down = true;
      }
      g.stroke();
    });
  }

  // Fills the span of the samples in each column of pixels; stroking that many samples is slow.
  columns(g, x, y, dash = []) {
    const d = this.d, [on = 1, off = 0] = dash;
    let column = -1, low = 0, high = 0, last = NaN;
    const put = () => { if (column % ((on + off) * d) < on * d) g.fillRect(column / d, low - 0.65, 1 / d, high - low + 1.3); };
    for (let i = 0; i < x.length; i++) {
      if (y[i] !== y[i]) continue;
      const at = (this.X(x[i]) * d) | 0, py = this.Y(y[i]);
      if (at !== column) {
        if (column >= 0) put();
        low = high = last === last ? last : py;
        column = at;
      }
      if (py < low) low = py;
      if (py > high) high = py;
      last = py;
    }
    if (column >= 0) put();
  }

  points(x, y, { colour, size = 3, alpha = 1, square = false }) {
    this.inside((g) => {
      g.globalAlpha = alpha; g.fillStyle = colour;
      if (size > 5 && !square) {
        for (let i = 0; i < x.length; i++) { g.beginPath(); g.arc(this.X(x[i]), this.Y(y[i]), size / 2, 0, 7); g.fill(); }
      } else for (let i = 0; i < x.length; i++) g.fillRect(this.X(x[i]) - size / 2, this.Y(y[i]) - size / 2, size, size);
    });
  }

  // Writes a centred text in lines of at most a number of pixels.
  paragraph(text, px, py, most) {
    const g = this.context;
    g.font = FONT;
    const lines = broken(g, text, most);
    lines.forEach((line, k) => this.label(line, px, py + 15 * (k - (lines.length - 1) / 2), { align: "center" }));
  }

  /**
   * Writes a text; `plate` lays a plate of the panel's colour under it, which hides the lines that it crosses.
   * @param {string} text @param {number} px @param {number} py
   * @param {{colour?: string, align?: CanvasTextAlign, base?: CanvasTextBaseline, bold?: boolean, plate?: boolean}} how
   */
  label(text, px, py, { colour = colours().soft, align = "left", base = "middle", bold = false, plate = false } = {}) {
    const g = this.context;
    g.font = bold ? `600 ${FONT}` : FONT;
    if (plate) {
      const wide = g.measureText(text).width, start = px - wide * { left: 0, center: 0.5, right: 1 }[align];
      g.fillStyle = colours().panel; g.globalAlpha = 0.85;
      g.beginPath(); g.roundRect(start - 5, py - 8, wide + 10, 16, 4); g.fill(); g.globalAlpha = 1;
    }
    g.fillStyle = colour; g.textAlign = align; g.textBaseline = base;
    g.fillText(text, px, py);
  }
}
