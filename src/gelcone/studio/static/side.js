// A side of the cone's picture: what is drawn of a look at the time shown.
import { format, typeset } from "./controls.js";
import { extent } from "./plot.js";
import * as profiles from "./profiles.js";
import { heightAt } from "./scene.js";

const UNSEEN = 1e-6; // share of the rim's radius below which a height is shown as 0
const TRAIL = 24; // earlier heights of the disc in its trail
const ENDED = { x: NaN, v: 0, films: [0, 0], thin: [], field: [] }; // the state after the end of a run

/** @param {any} look @param {string} name @param {import("./clock.js").Clock} clock */
export function sideOf(look, name, clock) {
  const { about } = look, scene = clock.scene(look), now = clock.state(look) ?? ENDED;
  if (look.spanOf !== scene.x) { look.spanOf = scene.x; look.span = extent(scene.x); look.volts = extent(scene.v, [0]); }
  const [low, high] = look.span, height = Number.isFinite(now.x) ? now.x : high;
  const second = about.second ?? 0, [first, other] = about.membrane ?? [];
  const shapes = [profiles.profile(first, height, now.v), profiles.profile(other, second - height, now.v)];
  const rounded = Math.abs(height) < UNSEEN * about.rim ? 0 : height;
  return { about, shapes, name, height, films: now.films, thin: now.thin, field: now.field, trail: trailOf(look, scene, clock.at), low, high, volts: look.volts, voltage: now.v,
    heightText: typeset(`${format(rounded, 3)}${about.si ? " mm" : ""}`), voltageText: typeset(voltageText(now.v, about.si)) };
}

function voltageText(v, si) {
  if (!si) return v.toFixed(2);
  return Math.abs(v) >= 1000 ? `${(v / 1000).toFixed(2)} kV` : `${v.toFixed(0)} V`;
}

// The heights over the drive period before a time, the latest first.
function trailOf(look, scene, time) {
  const found = [], step = look.words.period / TRAIL;
  for (let k = 1; k <= TRAIL && time - k * step >= 0; k++) found.push(heightAt(scene, time - k * step));
  return found.filter(Number.isFinite);
}
