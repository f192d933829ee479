// The kind of motion in words, its evidence, and how far the model held.
import { colours, onto } from "./colours.js";
import { make, say } from "./controls.js";

const BREAKDOWN = 4;
const percent = (share) => (share >= 0.9995 ? "all" : share < 0.01 ? "under 1 %" : `${Math.round(100 * share)} %`);

export class Badge {
  constructor(host) { this.host = host; this.rows = new Map(); }

  row(side) {
    if (!this.rows.has(side)) {
      const parts = { side: make("span", { className: "side" }), kind: make("span", { className: "kind" }), evidence: make("span", { className: "evidence" }), valid: make("span", { className: "valid" }) };
      this.rows.set(side, { box: make("div", { className: "badge" }, parts.side, parts.kind, make("div", { className: "words" }, parts.evidence, parts.valid)), ...parts });
      this.host.append(this.rows.get(side).box);
    }
    return this.rows.get(side);
  }

  keep(sides) {
    for (const [side, { box }] of this.rows) if (!sides.includes(side)) { box.remove(); this.rows.delete(side); }
    for (const [side, row] of this.rows) {
      say(row.side, sides.length > 1 ? side.toUpperCase() : "");
      row.side.style.color = colours()[side];
      row.side.hidden = sides.length < 2;
    }
  }

  show(side, look, legend) {
    const row = this.row(side), sure = look.lines && !look.words.ended;
    const kind = sure ? look.lines[0] : look.words.ended || look.words.seems;
    const colour = sure ? legend.regimes[look.regime].colour : null;
    say(row.kind, kind[0].toUpperCase() + kind.slice(1) + (sure || look.words.ended ? "" : " …"));
    row.kind.style.background = colour ?? ""; row.kind.style.color = colour ? onto(colour) : "";
    const evidence = look.words.ended ? look.words.seems : sure ? look.lines.slice(1).join(" · ") : look.late ? `first impression: the evidence ${look.late}` : "first impression; the evidence is under way";
    say(row.evidence, evidence, true);
    const [text, holds] = validity(look);
    say(row.valid, text, true);
    row.valid.classList.toggle("no", !holds); row.valid.classList.toggle("yes", holds);
  }
}

// Whether the model holds, and what the film does: one that wrinkles may be slack, one that is taut by assumption not.
function validity(look) {
  const { shares, ended } = look.words, { about } = look;
  const named = (some) => `film ${some.map(({ code, share }) => `${about.film[code]} ${percent(share)}`).join(", ")} of the time`;
  const broken = shares.filter(({ code }) => code >= BREAKDOWN || (code > 0 && !about.wrinkles));
  if (broken.length) return [`the model does not hold: ${named(broken)}${ended ? " until then" : ""}`, false];
  const strength = about.strength || !about.si ? "" : "; dielectric strength unknown";
  const wrinkled = shares.filter(({ code }) => code > 0), film = wrinkled.length ? `${named(wrinkled)}, as it may be` : "film taut throughout";
  return ended ? [`the model holds until then only: ${film}${strength}`, false] : [`the model holds: ${film}${strength}`, true];
}
