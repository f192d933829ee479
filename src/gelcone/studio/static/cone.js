// The cone in cross-section and in perspective. Colours show the film's state, brightness its field, line width its
// thickness, and a trail the recent heights. The disc and the voltage gauge can be dragged.
import { colours, mix, rgb } from "./colours.js";

const SECTORS = 64, RINGS = 5, TILT = 0.4;
const GAUGE = 46;
const SEEN_THROUGH = 0.7; // opacity of the upper of two films
const AROUND = 1, MERIDIAN = 2, BOTH = 3;
const GRIP = 12; // px around disc and gauge within which a drag takes hold of them
const THICK = 5, THINNEST = 1.5; // line width in px of an unstretched film in cross-section, and the least
const NAMES = 40; // px for the names below two cones

export class Cone {
  /** @type {HTMLCanvasElement} */ canvas; /** @type {CanvasRenderingContext2D} */ context; /** @type {() => void} */ wakes;
  /** @type {any} */ hands; /** @type {any[]} */ grips; /** @type {any} */ held;
  foot = 0; small = false; w = 0; h = 0; d = 1; changed = false;

  // small: a picture of the cone alone, without section, gauge and texts.
  constructor(canvas, small = false) {
    // during a drag: hands.disc(height, settled) and hands.volts(share of the highest voltage, settled)
    Object.assign(this, { canvas, wakes: () => {}, hands: null, grips: [], held: null, foot: 0, small });
    this.context = canvas.getContext("2d", { alpha: false });
    new ResizeObserver(() => { this.fit(); this.changed = true; this.wakes(); }).observe(canvas);
    canvas.onpointerdown = (event) => this.take(event);
    canvas.onpointermove = (event) => this.pull(event, false);
    canvas.onpointerup = canvas.onpointercancel = (event) => this.pull(event, true);
    this.fit();
  }

  // The part that can be dragged at a place (disc or voltage gauge), and the height of the place.
  grip(event) {
    const r = this.canvas.getBoundingClientRect(), x = event.clientX - r.left, y = event.clientY - r.top;
    return [this.grips.find(({ box: [x0, y0, x1, y1] }) => x >= x0 - GRIP && x <= x1 + GRIP && y >= y0 - GRIP && y <= y1 + GRIP), y];
  }

  take(event) {
    if (!this.hands || event.button > 0 || event.isPrimary === false) return;
    const [grip, y] = this.grip(event);
    if (!grip) return;
    this.held = { ...grip, from: y, began: grip.value(y) };
    this.canvas.setPointerCapture(event.pointerId);
  }

  pull(event, settled) {
    if (event.isPrimary === false) return;
    const [grip, y] = this.grip(event), own = this.held;
    this.canvas.style.cursor = own || grip ? "ns-resize" : "";
    if (!own) return;
    if (settled) this.held = null;
    if (event.type === "pointercancel") return this.hands[own.kind](own.last ?? own.start, true);
    own.last = own.kind === "disc" ? own.start + own.value(y) - own.began : Math.max(own.value(y), 0);
    if (own.moved || Math.abs(y - own.from) > 2) { own.moved = true; this.hands[own.kind](own.last, settled); }
  }

  fit() {
    const d = devicePixelRatio, w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    Object.assign(this, { w, h, d });
    this.canvas.width = Math.round(w * d); this.canvas.height = Math.round(h * d);
    this.context.fillStyle = colours().panel; // an opaque canvas is black until it is drawn on
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
  }

  // sides: {about, height, voltage, films, low, high, volts} of each setting; heights in the unit of about.rim.
  draw(sides) {
    const g = this.context, { w, h } = this;
    if (w <= GAUGE || !h) return;
    if (this.held) sides = sides.map((side) => ({ ...side, low: this.held.low, high: this.held.high, volts: this.held.volts }));
    this.grips = []; this.foot = sides.length > 1 ? NAMES : 0;
    g.setTransform(this.d, 0, 0, this.d, 0, 0);
    g.fillStyle = colours().panel;
    g.fillRect(0, 0, w, h);
    if (this.small) return this.perspective(sides[0], w, h, this.scale(sides[0]), "");
    const halves = sides.length > 1 ? sides.map((side) => ["perspective", side]) : [["section", sides[0]], ["perspective", sides[0]]];
    const common = Math.min(...halves.map(([, side]) => this.scale(side)));
    const apart = sides.length > 1 && sides[0].name !== sides[1].name; // two subjects, each at its own scale
    const two = sides.length > 1, half = two ? w / 2 : (w - GAUGE) / 2;
    halves.forEach(([kind, side], k) => {
      g.save();
      g.translate(k * (w - half), 0);
      const scale = apart ? this.scale(side) : common;
      if (kind === "section") this.section(side, half, h, scale); else this.perspective(side, half, h, scale, two ? "AB"[k] : "", apart);
      g.restore();
    });
    if (!two) this.gauge(sides[0], half + GAUGE / 2 - 4, h);
  }

  // The highest and lowest height in the picture: of the disc and of the films' planes.
  reach(side) { return [Math.max(side.high, side.about.second ?? 0, 0.15 * side.about.rim), Math.min(side.low, side.about.second ?? 0, 0)]; }

  scale(side) {
    const [most, least] = this.reach(side);
    const wide = (this.small ? this.w : 0.5 * (this.w - GAUGE)) / (2.28 * side.about.rim), tall = (this.h - (this.small ? 26 : 54) - this.foot) / (most - least + (this.small ? 1 : 0.75) * side.about.rim);
    return Math.max(Math.min(wide, tall), 0);
  }

  ground(side, h, scale) {
    const [most, least] = this.reach(side);
    return (h - this.foot) / 2 + ((most + least) / 2) * scale + (this.small ? 0 : 8);
  }

  section(side, w, h, scale) {
    const g = this.context, c = colours(), { about, height, films: [film], trail = [] } = side;
    const a = about.disc * scale, b = about.rim * scale, cx = w / 2, y0 = this.ground(side, h, scale), y = y0 - height * scale;
    g.strokeStyle = c.line; g.lineWidth = 1; g.setLineDash([3, 4]);
    g.beginPath(); g.moveTo(cx - b - 16, y0); g.lineTo(cx + b + 16, y0); g.stroke(); g.setLineDash([]);
    const base = Math.min(h - 8, y0 + Math.max(0.42 * b, -side.low * scale + 26));
    trail.forEach((own, k) => { // earlier heights of the disc, paler with time
      g.globalAlpha = 0.3 * (1 - k / trail.length); g.fillStyle = c.accent;
      g.fillRect(cx - a, y0 - own * scale - 1, 2 * a, 2);
    });
    g.globalAlpha = 1;
    this.bias(side, cx, y0, base, y, a, b, scale);
    for (const sign of [-1, 1]) this.filmLine(cx + sign * b, y0, cx + sign * a, y, film, side.thin?.[0], side.field?.[0], side.shapes?.[0]);
    this.grips.push({ kind: "disc", box: [cx - a, y - 4, cx + a, y + 4], start: height, value: (py) => (y0 - py) / scale, low: side.low, high: side.high, volts: side.volts });
    g.fillStyle = c.steel;
    for (const sign of [-1, 1]) this.block(cx + sign * b + (sign > 0 ? -2 : -10), y0 - 9, 12, 18);
    this.block(cx - a - 2, y - 3.5, 2 * a + 4, 7);
    g.fillStyle = c.ink; g.font = "600 12px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "bottom";
    const wide = g.measureText(side.heightText).width, up = Math.max(y - 8, 14);
    g.save(); g.globalAlpha = 0.8; g.fillStyle = c.panel; g.fillRect(cx - wide / 2 - 3, up - 14, wide + 6, 15); g.restore();
    g.fillText(side.heightText, cx, up);
  }

  block(x, y, w, h) { const g = this.context; g.beginPath(); g.roundRect(x, y, w, h, 2.5); g.fill(); }

  // Outlines of the biases that act on the disc: spring, weight, force, beam, second film.
  bias(side, cx, y0, base, y, a, b, scale) {
    const g = this.context, c = colours(), kinds = side.about.bias;
    g.strokeStyle = g.fillStyle = c.edge; g.lineWidth = 1.6;
    if (side.about.second !== null) { // the second film's plane is at this height
      const flat = y0 - side.about.second * scale;
      for (const sign of [-1, 1]) { this.filmLine(cx + sign * b, flat, cx + sign * a, y, side.films[1], side.thin?.[1], side.field?.[1], side.shapes?.[1]); this.block(cx + sign * b - 6, flat - 7, 12, 14); }
      g.strokeStyle = g.fillStyle = c.edge; g.lineWidth = 1.6;
    }
    if (/weight/.test(kinds)) { g.beginPath(); g.moveTo(cx, y); g.lineTo(cx, y + 16); g.stroke(); this.block(cx - 0.5 * a, y + 16, a, 14); }
    if (/force/.test(kinds)) {
      g.beginPath(); g.moveTo(cx, y + 34); g.lineTo(cx, y + 8); g.moveTo(cx - 5, y + 15); g.lineTo(cx, y + 8); g.lineTo(cx + 5, y + 15); g.stroke();
    }
    if (/beam/.test(kinds)) {
      g.beginPath();
      for (let i = -20; i <= 20; i++) g.lineTo(cx + (b * i) / 20, base + ((y - base) * (1 + Math.cos((Math.PI * i) / 20))) / 2);
      g.stroke();
    }
    if (!/spring/.test(kinds)) return;
    const turns = 9, width = Math.min(9, 0.5 * a);
    g.beginPath(); g.moveTo(cx - 0.5 * a, base); g.lineTo(cx + 0.5 * a, base); g.moveTo(cx, base);
    for (let i = 1; i < 2 * turns; i++) g.lineTo(cx + (i % 2 ? width : -width), base + ((y - base) * i) / (2 * turns));
    g.lineTo(cx, y); g.stroke();
  }

  filmLine(x0, y0, x1, y1, film, thin, field, shape) {
    const g = this.context, c = colours();
    if (shape && film !== MERIDIAN && film !== BOTH) return this.meridian(x0, y0, x1, y1, film, thin, field, shape);
    const waves = film === MERIDIAN || film === BOTH ? 3 : 0;
    const nx = y1 - y0, ny = x0 - x1, length = Math.hypot(nx, ny) || 1, n = 48;
    g.strokeStyle = lit(c.film[film], field); g.lineWidth = Math.min(Math.max(THICK * (thin > 0 ? thin : 1), THINNEST), 2 * THICK); g.lineCap = "round"; g.lineJoin = "round";
    g.setLineDash(film === AROUND || film === BOTH ? [10, 8] : []); // a second cue besides colour
    g.beginPath();
    for (let i = 0; i <= n; i++) {
      const s = i / n, sway = waves ? 3.2 * Math.sin(2 * Math.PI * waves * s) * Math.sin(Math.PI * s) : 0;
      g.lineTo(x0 + (x1 - x0) * s + (nx / length) * sway, y0 + (y1 - y0) * s + (ny / length) * sway);
    }
    g.stroke(); g.setLineDash([]);
    g.lineCap = "butt";
  }

  // A membrane with its own profile: each ring with its thickness, field and wrinkles.
  meridian(x0, y0, x1, y1, film, thin, field, shape) {
    const g = this.context, c = colours(), [disc] = shape, rim = shape.at(-1), most = Math.max(...shape.map((ring) => ring.stretch));
    const at = ({ radius, rise }) => [x1 + ((radius - disc.radius) / (rim.radius - disc.radius)) * (x0 - x1), y0 + rise * (y1 - y0)];
    g.lineCap = "round";
    for (let k = 0; k + 1 < shape.length; k++) {
      const one = shape[k], next = shape[k + 1], stretch = 0.5 * (one.stretch + next.stretch), wrinkled = one.wrinkled && next.wrinkled;
      g.strokeStyle = lit(c.film[ringState(film, wrinkled)], field * (stretch / most));
      g.lineWidth = Math.min(Math.max(THICK * (thin > 0 ? thin : 1) * (disc.stretch / stretch), THINNEST), 2 * THICK);
      g.setLineDash(wrinkled ? [3, 5] : []); // a second cue besides colour
      g.beginPath(); g.moveTo(...at(one)); g.lineTo(...at(next)); g.stroke();
    }
    g.setLineDash([]); g.lineCap = "butt";
  }

  gauge(side, x, h) {
    const g = this.context, c = colours(), top = 22, bottom = h - 24, [low, high] = side.volts;
    const Y = (v) => bottom - ((v - low) / (high - low || 1)) * (bottom - top), zero = Y(Math.min(Math.max(0, low), high));
    g.fillStyle = c.field; g.beginPath(); g.roundRect(x, top, 8, bottom - top, 4); g.fill();
    g.fillStyle = c.accent; const y = Y(side.voltage);
    g.beginPath(); g.roundRect(x, Math.min(y, zero), 8, Math.max(Math.abs(y - zero), 2), 3); g.fill();
    g.fillStyle = c.soft; g.font = "11px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle";
    g.fillText(side.voltageText, x + 4, bottom + 13);
    g.fillText("voltage", x + 4, top - 11);
    const most = Math.max(Math.abs(low), Math.abs(high)) || 1;
    this.grips.push({ kind: "volts", box: [x, top, x + 8, bottom], start: 1, value: (py) => (low + ((bottom - py) / (bottom - top)) * (high - low)) / most, low: side.low, high: side.high, volts: side.volts });
  }

  perspective(side, w, h, scale, name, apart = false) {
    const g = this.context, c = colours(), { about, height, films } = side;
    const up = Math.sqrt(1 - TILT * TILT), cx = w / 2, a = about.disc, b = about.rim, y0 = this.ground(side, h, scale);
    const at = (r, f, z) => [cx + r * scale * Math.cos(f), y0 + r * scale * Math.sin(f) * TILT - z * scale * up];
    const ring = (r, z, from = 0, to = 2 * Math.PI) => {
      g.beginPath(); g.ellipse(cx, y0 - z * scale * up, r * scale, r * scale * TILT, 0, from, to);
    };
    g.fillStyle = c.dark ? "rgba(0,0,0,0.35)" : "rgba(20,30,45,0.08)";
    g.beginPath(); g.ellipse(cx, y0 + 9, b * scale * 1.06, b * scale * TILT * 1.06, 0, 0, 7); g.fill();
    const rim = (z, from, to) => { g.lineWidth = Math.min(7, 0.06 * w); g.strokeStyle = c.steel; ring(b * 1.02, z, from, to); g.stroke(); };
    // the front or back half of a film between its rim at the height ``flat`` and the disc
    const quads = (film, flat, front, field, shape) => {
      const slack = film >= MERIDIAN && film <= BOTH, own = slack || !shape ? null : shape.filter((_, k) => k % 2 === 0).reverse();
      const rings = own ? own.length - 1 : slack ? RINGS : 1, rise = height - flat, slope = Math.atan2(rise, b - a);
      const radius = (k) => b + (a - b) * (own ? (own[0].radius - own[k].radius) / (own[0].radius - own[rings].radius) : k / rings), level = (k) => flat + rise * (own ? own[k].rise : k / rings);
      const most = own && Math.max(...own.map((ring) => ring.stretch));
      for (let i = 0; i < SECTORS; i++) {
        const f = (2 * Math.PI * i) / SECTORS, f2 = (2 * Math.PI * (i + 1.02)) / SECTORS, middle = (f + f2) / 2;
        if (Math.sin(middle) > 0 !== front) continue;
        for (let k = 0; k < rings; k++) {
          const r = radius(k), r2 = radius(k + 1), z = level(k), z2 = level(k + 1);
          g.beginPath(); g.moveTo(...at(r, f, z)); g.lineTo(...at(r, f2, z)); g.lineTo(...at(r2, f2, z2)); g.lineTo(...at(r2, f, z2)); g.closePath();
          g.fillStyle = own
            ? this.shade(ringState(film, own[k].wrinkled && own[k + 1].wrinkled), middle, Math.atan2(z2 - z, r - r2), i, k, front, (field * own[k + 1].stretch) / most)
            : this.shade(film, middle, slope, i, k, front, field);
          g.fill();
          g.strokeStyle = g.fillStyle; g.lineWidth = 0.7; g.stroke(); // closes the seams
        }
      }
    };
    const disc = () => {
      g.fillStyle = mix(c.steel, "#000000", 0.35);
      ring(a, height - 0.03 * b); g.fill();
      g.fillStyle = c.steel; ring(a, height); g.fill();
    };
    const whole = (film, flat, field, shape) => {
      rim(flat, Math.PI, 2 * Math.PI);
      quads(film, flat, false, field, shape);
      if (height < flat) disc();
      quads(film, flat, true, field, shape);
      if (height >= flat) disc();
      rim(flat, 0, Math.PI);
    };
    const planes = (about.second === null ? [0] : [0, about.second]).map((flat, k) => [films[k], flat, side.field?.[k], side.shapes?.[k]]);
    planes.sort((one, other) => one[1] - other[1]);
    planes.forEach((plane, k) => {
      g.globalAlpha = k ? SEEN_THROUGH : 1;
      whole(...plane);
    });
    g.globalAlpha = 1;
    if (name) {
      g.fillStyle = name === "A" ? c.a : c.b; g.font = "700 13px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "bottom";
      g.fillText(apart ? `${name} ${side.name}, in its own scale` : name, cx, h - 18, w - 12);
      g.fillStyle = c.ink; g.font = "600 12px system-ui, sans-serif"; g.fillText(`${side.heightText}, ${side.voltageText}`, cx, h - 3);
    }
  }

  // The colour of a facet, lit from the upper left. Slack film is pleated: radially under hoop slack, in rings under
  // meridian slack.
  shade(film, angle, slope, sector, ring, front, field) {
    const c = colours(), light = 0.5 + 0.5 * Math.cos(angle + 2.3) * Math.sin(slope + 0.5);
    let share = (front ? 0 : 0.12) + 0.5 * (1 - light);
    if ((film === AROUND || film === BOTH) && sector % 2) share += 0.2;
    if ((film === MERIDIAN || film === BOTH) && ring % 2) share += 0.2;
    return mix(lit(c.film[film], field), c.dark ? "#06090d" : "#12202c", Math.min(share, 0.8));
  }
}

// The state of a ring of a membrane: wrinkled or taut, unless the whole film is above breakdown or near its limit.
function ringState(film, wrinkled) { return film > BOTH ? film : wrinkled ? AROUND : 0; }

// A colour, brightened with the field's share of breakdown (of the motion's largest field where that is unknown).
function lit(colour, field) {
  const share = Math.min(Math.max(field || 0, 0), 1), [r, g, b] = rgb(colour);
  return `#${[r, g, b].map((v) => Math.round(v + (255 - v) * 0.55 * share * share).toString(16).padStart(2, "0")).join("")}`;
}
