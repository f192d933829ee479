// The plots of a look: over time, phase portrait, spectrum, statics.
import { colours } from "./colours.js";
import { format } from "./controls.js";
import { drawMeasured, rangesOf, shownOver } from "./measured.js";
import { Plot, Range, extent } from "./plot.js";
import { sceneOf } from "./scene.js";

const VOLTAGE_SHARE = 0.27;
const DASHES = { a: [], b: [7, 3] }, LONG_DASHES = { a: [], b: [12, 2] }; // the second setting has a second cue besides colour
const PALE = 0.3; // opacity of the run behind the settled motion
const ROOM = 0.4; // most room around the settled motion, as a share of its size
const MOST_BEHIND = 6000, MOST_DRAWN = 20000; // samples of a run in the portrait, behind the settled motion and alone

// The looks to draw, each with colour and side. Two settings are drawn together only if they have the same units.
function sidesOf(looks) {
  const sides = ["a", "b"].filter((side) => looks[side]?.about), si = looks[looks.active]?.about?.si;
  return sides.filter((side) => looks[side].about.si === si).map((side) => [looks[side], colours()[side], side]);
}

export function timePanel(host, looks, clock) {
  const height = new Range(), volts = new Range();
  const plot = new Plot(host, {
    top: 6,
    draw(p) {
      const sides = sidesOf(looks).filter(([look]) => look.t), shown = sides.map(([look, ...rest]) => [sceneOf(look, looks.motion), ...rest]);
      if (!shown.length) return;
      const [look] = sides[0], { axes } = look.about, end = Math.max(...shown.map(([own]) => own.t.at(-1)));
      const measured = shownOver(looks, "time", look.x[0]);
      const x = [0, end], y = height.fit(extent(...shown.map(([own]) => own.x), ...rangesOf(measured)));
      p.axes(x, volts.fit(extent(...shown.map(([own]) => own.v))), { from: 1 - VOLTAGE_SHARE, xLabel: shown[0][0] === look ? axes.time : `${axes.time} of the settled motion`, yLabel: axes.voltage });
      for (const [own, colour, side] of shown) p.line(own.t, own.v, { colour, width: 1, sorted: true, alpha: 0.85, dash: LONG_DASHES[side] });
      for (const own of measured) if (own.volts) p.points(own.along, own.volts, { colour: colours().ink, size: 1.5 });
      p.axes(x, y, { to: 1 - VOLTAGE_SHARE - 0.06, xTicks: false, yLabel: axes.displacement });
      for (const [own, colour, side] of shown) p.line(own.t, own.x, { colour, sorted: true, alpha: shown.length > 1 ? 0.8 : 1, dash: LONG_DASHES[side] });
      drawMeasured(p, measured);
      states(p, shown[0][0]);
      for (const [own] of sides) if (sceneOf(own, looks.motion) === own) ended(p, own, own.t);
      const { shown: periods, cut } = look.words;
      if (cut && shown[0][0] === look) p.label(`only the first ${format(periods, 2)} periods: more would not resolve the oscillations`, p.left + 6, p.top + 9);
    },
    over(p) {
      const t = clock.time();
      p.upright(t === null ? null : p.X(t), p.margin.top, p.h - p.margin.bottom);
    },
  });
  // A click jumps to its time, a drag scrubs through the run.
  const c = plot.canvas;
  let held = false;
  const go = (event) => { if (plot.x) clock.goTo(plot.toX(event.clientX - c.getBoundingClientRect().left)); };
  c.onpointerdown = (event) => { held = true; c.setPointerCapture(event.pointerId); go(event); };
  c.onpointermove = (event) => { if (held) go(event); };
  c.onpointerup = c.onpointercancel = () => { held = false; };
  return plot;
}

// Draws a cross, with the reason, where a run ended early.
function ended(p, { words, x }, across, up = x) {
  if (!words.ended) return;
  const px = p.X(across.at(-1)), py = p.Y(up.at(-1)), c = colours();
  p.inside((g) => {
    g.strokeStyle = c.breakdown; g.lineWidth = 2.5; g.beginPath();
    for (const s of [-1, 1]) { g.moveTo(px - 6, py - 6 * s); g.lineTo(px + 6, py + 6 * s); }
    g.stroke();
  });
  const left = px > (p.left + p.right) / 2;
  p.label(words.ended, px + (left ? -10 : 10), Math.min(Math.max(py, p.top + 8), p.bottom - 8), { colour: c.breakdown, bold: true, align: left ? "right" : "left" });
}

// Draws the film's state as a coloured strip below the curve.
function states(p, look) {
  const g = p.context, film = look.film, n = film.length - 1, c = colours().film;
  const width = p.X(look.t[n]) - p.left, y = p.bottom + 3;
  let from = 0;
  for (let px = 1; px <= width; px++) {
    const now = film[Math.min(n, Math.round((px / width) * n))], before = film[Math.min(n, Math.round((from / width) * n))];
    if (now !== before || px + 1 > width) {
      g.fillStyle = c[before];
      g.fillRect(p.left + from, y, px - from, 4);
      from = px;
    }
  }
}

// The settled motion on top of the run that led to it, or that run alone.
export function portraitPanel(host, looks, clock) {
  const xs = new Range(), us = new Range();
  return new Plot(host, {
    draw(p) {
      const shown = sidesOf(looks).filter(([look]) => look.t);
      if (!shown.length) return;
      const { axes } = shown[0][0].about, settled = (/** @type {any[]} */ [look]) => looks.motion !== "start" && look.ox;
      const drawn = shown.filter(settled), runs = shown.filter((side) => !settled(side));
      const all = (own) => within(extent(...shown.map(([look]) => look[own])), drawn.map(([look]) => [look[`o${own}`], look[`p${own}`]]), runs.map(([look]) => look[own]));
      p.axes(xs.fit(all("x")), us.fit(all("u")), { xLabel: axes.displacement, yLabel: axes.velocity });
      for (const [look, colour] of drawn) p.line(look.x, look.u, { colour, width: 0.8, alpha: PALE, most: MOST_BEHIND });
      for (const [look, colour] of runs) p.line(look.x, look.u, { colour, width: 0.8, alpha: look.x.length > 3000 ? 0.4 : 0.6, most: MOST_DRAWN });
      for (const [look, colour, side] of drawn) p.line(look.ox, look.ou, { dash: DASHES[side], colour, width: look.wanders ? 0.8 : 1.8, alpha: (look.wanders ? 0.6 : 1) * (look.old ? 0.4 : 1) });
      for (const [look, colour, side] of drawn) p.points(look.px, look.pu, { colour: shown.length > 1 ? colour : colours().b, square: side === "b", size: look.wanders ? 2.4 : 7, alpha: look.old ? 0.4 : 1 });
      for (const [look] of shown) ended(p, look, look.x, look.u);
      if (runs.some(([look]) => look.x.length > MOST_DRAWN)) p.label("only the beginning of the run", p.left + 6, p.top + 9);
    },
    over(p) {
      dots(p, looks, clock, (state) => [p.X(state.x), p.Y(state.u)]);
    },
  });
}

// The range of the settled motions with limited room for the runs that led there, and of the whole run without one.
function within(whole, settled, runs) {
  if (!settled.length) return extent(...runs);
  const [low, high] = extent(...settled.flat()), more = ROOM * (high - low);
  const seen = more > 0 ? [Math.max(whole[0], low - more), Math.min(whole[1], high + more)] : whole;
  return extent([low, high], seen, ...runs);
}

// Draws a dot at the present state of each look.
function dots(p, looks, clock, place) {
  const shown = sidesOf(looks);
  for (const side of ["a", "b"]) {
    const [look] = shown.find(([, , name]) => name === side) ?? [null], state = look && clock.state(look);
    const at = state ? place(state, look) : null;
    p.mark("dot", at && at[0] >= p.left && at[0] <= p.right && at[1] >= p.top && at[1] <= p.bottom ? at : null, side);
  }
}

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const power = (v) => (Number.isInteger(v) ? `10${[...String(v)].map((digit) => RAISED[digit]).join("")}` : "");

export function spectrumPanel(host, looks) {
  const decades = new Range();
  return new Plot(host, {
    draw(p) {
      const sides = sidesOf(looks), shown = sides.filter(([look]) => look.spectrum?.amplitude?.some(Number.isFinite));
      if (!shown.length) {
        const ended = sides.some(([look]) => look.words.ended);
        const text = ended ? "A motion that ends has no spectrum." : looks[looks.active]?.unmeasured ?? "No spectrum yet: it is being computed, or the actuator stands still.";
        return p.paragraph(text, p.w / 2, p.h / 2, 0.7 * p.w);
      }
      const { axes } = shown[0][0].about, top = Math.max(...shown.map(([look]) => look.spectrum.top));
      const most = Math.max(...shown.flatMap(([look]) => [...look.spectrum.amplitude.subarray(1)]), 1e-12);
      const log = (v) => Math.log10(Math.max(v, 1e-30)), y = decades.fit([log(most) - 6, log(most)]);
      p.axes([0, top], y, { xLabel: axes.frequency, yLabel: axes.amplitude, yText: power });
      for (const [look, colour, side] of shown) {
        const { frequency, amplitude, line, height } = look.spectrum;
        const own = Float32Array.from(amplitude, log);
        p.inside((g) => {
          g.globalAlpha = 0.35; g.fillStyle = colour; g.beginPath(); g.moveTo(p.X(0), p.bottom);
          for (let i = 0; i < own.length; i++) g.lineTo(p.X(frequency[i]), Math.min(p.Y(own[i]), p.bottom));
          g.lineTo(p.X(frequency.at(-1)), p.bottom); g.fill();
        });
        p.line(frequency, own, { colour, width: 1 });
        p.points(line, Float32Array.from(height, log), { colour, size: side === "b" ? 4 : 7, square: side === "b" }); // both show at one place
      }
    },
  });
}

export function staticsPanel(host, looks, clock) {
  const volts = new Range(), heights = new Range();
  return new Plot(host, {
    draw(p) {
      const shown = sidesOf(looks).filter(([look]) => look.statics);
      if (!shown.length) return p.paragraph(looks[looks.active]?.problem ?? "Computing the equilibria …", p.w / 2, p.h / 2, 0.7 * p.w);
      const { axes } = shown[0][0].about, c = colours();
      const most = Math.max(...shown.map(([look]) => Math.max(...look.statics.swing.map(Math.abs), ...Object.values(look.statics.marks)))) * 1.15;
      const near = shown.flatMap(([look]) => [...look.statics.x].filter((_, i) => look.statics.voltage[i] <= most));
      const measured = shownOver(looks, "voltage", restOf(shown[0][0].statics));
      const top = Math.max(most, ...measured.map((own) => extent(own.along)[1]));
      p.axes(volts.fit([0, top]), heights.fit(extent(near, ...shown.map(([look]) => look.x ?? []), ...rangesOf(measured))), { xLabel: axes.constant, yLabel: axes.displacement });
      let row = 0;
      for (const [look, colour] of shown) {
        const { voltage, x, stable, marks, swing } = look.statics;
        if (look.extent) {
          const [low, high] = [Math.min(...swing.map(Math.abs)), Math.max(...swing.map(Math.abs))];
          const from = swing[0] * swing[1] < 0 ? 0 : low;
          p.inside((g) => {
            g.globalAlpha = 0.12; g.fillStyle = colour;
            g.fillRect(p.X(from), p.Y(look.extent[1]), p.X(high) - p.X(from), p.Y(look.extent[0]) - p.Y(look.extent[1]));
          });
          if (look === shown[0][0]) p.label("the settled motion", p.X(from) + 5, Math.max(p.Y(look.extent[1]) + 9, p.top + 9));
        }
        for (const kind of [0, 1]) {
          const own = Float32Array.from(x, (v, i) => (stable[i] === kind ? v : NaN));
          p.line(voltage, own, { colour, width: kind ? 2 : 1.4, dash: kind ? [] : [5, 4] });
        }
        for (const [name, v] of Object.entries(marks)) {
          p.inside((g) => { g.strokeStyle = c.edge; g.setLineDash([2, 3]); g.beginPath(); g.moveTo(p.X(v), p.top); g.lineTo(p.X(v), p.bottom); g.stroke(); });
          p.label(name === "pull_in" ? `pull-in of the ${look.about.film_of}` : name, p.X(v) - 4, p.top + 9 + 14 * row++, { align: "right" });
        }
      }
      drawMeasured(p, measured);
    },
    over(p) {
      dots(p, looks, clock, (state, look) => (look.statics ? [p.X(Math.abs(state.v)), p.Y(state.x)] : null));
    },
  });
}

// The stable height at the lowest voltage.
function restOf({ voltage, x, stable }) {
  let best = -1;
  for (let i = 0; i < x.length; i++) if (stable[i] && Number.isFinite(x[i]) && (best < 0 || voltage[i] < voltage[best])) best = i;
  return best < 0 ? NaN : x[best];
}
