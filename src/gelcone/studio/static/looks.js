// A look: what is known of a setting, as the answers of the server add to it.
import { settledOf } from "./scene.js";

// The look of a response; what was found of an older setting stays in it, marked as old, until its own answers come.
export function renewed(before, head, arrays) {
  const look = { ...before, film1: undefined, film2: undefined, ...arrays, words: head.words, about: head.about, id: head.id };
  delete look.lines; delete look.late; delete look.problem; delete look.unmade; delete look.unmeasured;
  look.numbers = new Map([...(before.numbers ?? [])].map(([name, own]) => [name, { ...own, old: true }]));
  for (const name of ["spectrum", "statics"]) if (look[name]) look[name] = { ...look[name], old: true };
  if (head.words.ended) look.ox = look.px = look.settled = look.shares = look.extent = undefined;
  return look;
}

// Adds the kind of motion with the settled motion, shown over some drive periods.
export function judged(look, { words }, arrays, periods) {
  const wanders = ![0, 1].includes(words.regime), settled = settledOf(arrays, { periodic: !wanders, periods, period: look.words.period });
  Object.assign(look, { ox: undefined, ou: undefined, old: false, px: arrays.px, pu: arrays.pu, ...(settled && { ox: arrays.ox, ou: arrays.ou }), settled: look.words.ended ? null : settled, shares: words.shares }, { lines: words.lines, regime: words.regime, extent: words.extent, wanders });
  for (const name of ["stroke", "mean height", "lag", "field"]) look.numbers.delete(name);
  numbered(look, words);
}

// Replaces numbers of the same names; a pull-in also replaces that of another film.
export function numbered(look, words) {
  for (const own of words.numbers ?? []) {
    if (own.peak) for (const [name, { peak }] of look.numbers) if (peak) look.numbers.delete(name);
    look.numbers.set(own.name, own);
  }
}

const REASONS = { statics: "problem", spectrum: "unmeasured", film: "unmade", kind: "late" }; // where the reason of a missing answer stands

// Notes why an answer is missing; that of an older setting must not be taken for it.
export function missing(look, { stage, message }) {
  look[REASONS[stage]] = message;
  if (look[stage]?.old) delete look[stage];
  if (stage !== "kind") return;
  for (const [name, { old }] of look.numbers) if (old) look.numbers.delete(name);
  Object.assign(look, { ox: undefined, px: undefined, settled: null, shares: undefined, extent: undefined });
}
