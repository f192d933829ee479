// A device's operating envelope: limits and the recommended window over drive frequency.
import { colours } from "./colours.js";
import { format, make, say } from "./controls.js";
import { Panel, holding } from "./work.js";

const HEADROOM = 1.15; // the axis above the highest voltage, at which limits often lie: room for their names

export class EnvelopePanel extends Panel {
  constructor(host, grids) {
    super(grids, "envelope");
    this.words = make("span", {});
    host.append(make("div", { className: "bar" }, this.words));
    const c = this.plotIn(host, "Operating envelope: drive frequency and peak voltage. Arrow keys move the device's drive.");
    holding(c, (event, settled) => this.goTo(event, settled));
    c.onkeydown = (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step || !this.current) return;
      event.preventDefault();
      const [f, v] = this.own();
      this.drive(f + (step[0] * (this.plot.x[1] - this.plot.x[0])) / 60, v + (step[1] * (this.plot.y[1] - this.plot.y[0])) / 60, true);
    };
  }

  prepare() { this.compare(); }

  // A key of everything that the envelope depends on: not the frequency, and of the voltages only their ratio.
  basis() {
    const own = this.page.setting(), { frequency, voltage_amplitude, voltage_offset, ...rest } = own.values;
    return JSON.stringify([own.device, own.file, rest, this.ratio()]);
  }

  // Offset over amplitude, the same while it changes by less than a thousandth, as by the rounding of both.
  ratio() {
    const ratio = this.si("voltage_offset", "V") / this.si("voltage_amplitude", "V");
    if (!(Math.abs(ratio - this.known) <= 1e-3 * Math.abs(this.known))) this.known = ratio;
    return String(this.known);
  }

  // The value of a parameter in a unit, 0 for one that the device does not have.
  si(name, unit) { const c = this.control(name), v = this.value(name); return c && v !== null ? v * 10 ** (c.powers[c.unit] - c.powers[unit]) : 0; }

  // Whether the envelope is of what is set now: its drive has the same shape, which alone gives the peak.
  get current() { return this.found?.key === this.basis(); }

  // Drive frequency in hertz and peak voltage in volts. The server sends both voltages of the drive whose peak is 1 V.
  own() {
    const [[name, share]] = Object.entries(this.found.shape).sort(([, p], [, q]) => Math.abs(q) - Math.abs(p));
    return [this.si("frequency", "Hz"), this.si(name, "V") / share];
  }

  // Sent again whenever more of the envelope is known.
  on_envelope(head, arrays) {
    this.found = { ...head, arrays, key: this.key };
    this.progress(head.share);
    if (this.grids.open === this) this.plot.redraw();
  }

  on_done() { super.on_done(); this.plot.redraw(); }

  draw(p) {
    const found = this.found, c = colours();
    if (!found) return this.nothing(p, this.running ? "computing the envelope, which takes some seconds …" : "");
    const { frequency, window } = found.arrays;
    p.axes([0, found.most], [0, HEADROOM * found.highest], { xLabel: "drive frequency (Hz)", yLabel: `peak voltage${found.in_proportion ? ", bias in proportion" : ""} (V)` });
    const faded = this.stale ? 0.4 : 1;
    if (frequency.length) p.inside((g) => {
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
    for (const [name, , colour] of shown) p.label(named(name), p.right - 6, p.top + 10 + 14 * row++, { align: "right", colour, bold: true, plate: true });
    for (const [name, v] of Object.entries(found.static)) {
      if (!Number.isFinite(v) || v === null || v > found.highest) continue;
      p.inside((g) => { g.strokeStyle = c.edge; g.setLineDash([3, 4]); g.beginPath(); g.moveTo(p.left, p.Y(v)); g.lineTo(p.right, p.Y(v)); g.stroke(); });
      p.label(`${found.in_proportion ? "drive held at its peak:" : "static"} ${named(name)}`, p.left + 6, p.Y(v) - 9, { plate: true });
    }
    if (frequency.length) p.label("recommended", p.left + 8, p.bottom - 10, { colour: c.taut, bold: true });
  }

  drawOver(p) {
    if (!this.found) return;
    if (!this.current) {
      p.mark("ring", null);
      say(this.words, "drive: not compared, since the envelope is of other settings");
      return;
    }
    const [f, v] = this.own();
    p.mark("ring", [Math.min(p.X(f), p.right), Math.max(p.Y(v), p.top)]);
    say(this.words, this.verdict(f, v));
  }

  verdict(f, v) {
    const { frequency, window } = this.found.arrays, k = frequency.findIndex((own) => own >= f);
    const at = `drive: ${format(f, 3)} Hz, peak ${format(v, 4)} V`;
    if (f < this.found.least) return `${at}: below the frequencies examined`;
    if (f > this.found.most) return `${at}: above the frequencies examined`;
    if (k < 0 || (k === 0 && f < frequency[0])) return `${at} …`;
    const share = k ? (f - frequency[k - 1]) / (frequency[k] - frequency[k - 1]) : 1;
    const most = share < 1 ? window[k - 1] + (window[k] - window[k - 1]) * share : window[k];
    if (this.running) return `${at}; so far the window ends at ${format(most, 3)} V`;
    const volts = `${format(most, 3)} V${share < 1 ? ", interpolated" : ""}`;
    return v <= most ? `${at}: inside the window (up to ${volts})` : `${at}: above the window (${volts})`;
  }

  goTo(event, settled) {
    const r = this.plot.canvas.getBoundingClientRect();
    if (this.current) this.drive(this.plot.toX(event.clientX - r.left), this.plot.toY(event.clientY - r.top), settled);
  }

  // Moves the drive: sets the frequency, and scales amplitude and offset together.
  drive(f, v, settled) {
    const p = this.plot, freq = Math.min(Math.max(f, p.x[1] / 500), p.x[1]), volts = Math.min(Math.max(v, p.y[1] / 500), p.y[1]);
    const scaled = Object.entries(this.found.shape).filter(([, share]) => share).map(([name, share]) => [name, `${format(share * volts, 6)} V`]);
    this.page.go({ frequency: `${format(freq)} Hz`, ...Object.fromEntries(scaled) }, settled);
  }
}
