// The kind of motion with its evidence, the performance numbers, and the share of time in which the model holds.
import { colours, onto } from "./colours.js";
import { make, say, typeset } from "./controls.js";

const BREAKDOWN = 4, SAFE = 0.85; // share of the pull-in voltage that the button sets
const percent = (share) => (share >= 0.9995 ? "all" : share < 0.01 ? "< 1 %" : `${Math.round(100 * share)} %`);

export class Badge {
  constructor(host, lower = null) { this.host = host; this.lower = lower; this.rows = new Map(); this.open = false; }

  row(side) {
    if (!this.rows.has(side)) {
      const evidence = make("p", { className: "evidence", hidden: !this.open });
      const why = make("button", { type: "button", className: "more why", textContent: "evidence", "aria-expanded": String(this.open), onclick: () => this.toggle() });
      const parts = { side: make("span", { className: "side" }), kind: make("span", { className: "kind" }), numbers: make("p", { className: "numbers" }), valid: make("span", { className: "valid" }), evidence, why };
      this.rows.set(side, { box: make("div", { className: "badge" }, parts.side, parts.kind, make("div", { className: "words" }, parts.numbers, make("p", { className: "line" }, parts.valid, why), evidence)), ...parts });
      this.host.append(this.rows.get(side).box);
    }
    return this.rows.get(side);
  }

  // Shows or hides the evidence.
  toggle() {
    this.open = !this.open;
    for (const { evidence, why } of this.rows.values()) { evidence.hidden = !this.open; why.setAttribute("aria-expanded", this.open); }
  }

  keep(sides) {
    for (const [side, { box }] of this.rows) if (!sides.includes(side)) { box.remove(); this.rows.delete(side); }
    for (const [side, row] of this.rows) {
      say(row.side, sides.length > 1 ? side.toUpperCase() : "");
      row.side.style.color = colours()[side];
      row.side.hidden = sides.length < 2;
    }
  }

  // other: the look to compare the numbers with, if any.
  show(side, look, legend, other = null) {
    const row = this.row(side), sure = look.lines && !look.words.ended;
    const kind = sure ? look.lines[0] : look.words.ended || look.words.seems;
    const colour = sure ? legend.regimes[look.regime].colour : null;
    say(row.kind, kind[0].toUpperCase() + kind.slice(1) + (sure || look.words.ended ? "" : " …"));
    row.kind.style.background = colour ?? ""; row.kind.style.color = colour ? onto(colour) : "";
    writeNumbers(row.numbers, look, other, this.lower);
    const evidence = look.words.ended ? look.words.seems : sure ? look.lines.slice(1).join(" · ") : look.late ? `first impression: ${look.late}` : "first impression; the evidence is being computed";
    say(row.evidence, evidence, true);
    const [text, holds] = standing(look, ...validity(look));
    say(row.valid, text, true);
    row.valid.classList.toggle("no", !holds); row.valid.classList.toggle("yes", holds);
  }
}

// Writes the numbers of the settled motion, outdated ones pale; without numbers, or if the motion ends, a sentence.
function writeNumbers(host, { numbers, words, lines, late, about }, other, lower) {
  const shown = words.ended ? [] : [...(numbers?.values() ?? [])].sort((p, q) => p.place - q.place);
  const sentence = words.ended ? words.seems : late ? `first impression only: ${late}` : lines ? lines.slice(1).join(" · ") : "computing the settled motion …";
  const compared = other && other.about?.si === about.si && !other.words?.ended ? other.numbers : null;
  const parts = shown.map(({ name, text, value, old }) => [name, `${text}${difference(name, value, compared?.get(name)?.value)}`, Boolean(old)]);
  const peak = words.ended ? [...(numbers?.values() ?? [])].find((own) => own.peak)?.peak ?? 1 : 0;
  const needed = !shown.length || late || (lines && !numbers.has("stroke"));
  const key = `${parts.join()} ${needed ? sentence : ""} ${peak}`;
  if (host.dataset.key === key) return;
  host.dataset.key = key;
  host.replaceChildren(...parts.map(([name, text, old]) => make("span", { className: old ? "number old" : "number" }, `${name} `, make("b", { textContent: typeset(text) }))), ...(needed ? [sentence] : []));
  if (words.ended && lower) host.append(make("button", { type: "button", className: "more", textContent: "lower the voltage", onclick: () => lower(SAFE * Math.min(1, 1 / Math.max(peak, 1e-9))) }));
}

// The relative difference between two numbers in percent; none for an angle.
function difference(name, value, other) {
  if (!other || name === "lag") return "";
  const share = Math.abs((100 * (value - other)) / other);
  return ` (${value >= other ? "+" : "-"}${share < 9.95 ? Number(share.toPrecision(2)) : share.toFixed(0)} %)`;
}

// Prefixes the statement while a cone stands for a membrane that is not made yet, or cannot be made.
function standing({ about, unmade }, text, holds) {
  return about.stands ? [`${unmade ?? "a cone is shown until the membrane is computed"}: ${text}`, false] : [text, holds];
}

// Whether the model holds, and the states of the film: in the settled motion, and on the way there if that differs. Only
// a film that wrinkles may be slack.
function validity(look) {
  const { shares, ended } = look.words, { about } = look, settled = !ended && look.shares;
  const named = (some) => `film ${some.map(({ code, share }) => `${about.film[code]} ${percent(share)}`).join(", ")} of the time`;
  const broken = (some) => some.filter(({ code }) => code >= BREAKDOWN || (code > 0 && !about.wrinkles));
  const now = settled || shares, failing = broken(now), before = settled ? broken(shares) : [];
  if (failing.length) return [`the model does not hold: ${named(failing)}${ended ? " until then" : ""}`, false];
  const strength = about.strength || !about.si ? "" : "; dielectric strength unknown";
  const wrinkled = now.filter(({ code }) => code > 0), film = wrinkled.length ? `${named(wrinkled)} (allowed for this film)` : "film taut throughout";
  if (ended) return [`the model holds until then only: ${film}${strength}`, false];
  if (before.length) return [`the model holds once the motion has settled: ${film}${strength}; on the way there ${named(before)}`, false];
  return [`the model holds: ${film}${strength}`, true];
}
