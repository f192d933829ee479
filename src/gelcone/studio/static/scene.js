// The part of a motion shown over time and as a cone (scene): the settled motion, or the run from the start.
/**
 * Arrays along a motion: times, heights, velocities, voltages, and of the films their states, thickness and field.
 * @typedef {{t: Float32Array, x: Float32Array, u: Float32Array, v: Float32Array, film: Uint8Array, [more: string]: any}} Scene
 */
const MOST = 200000; // most samples of a repeated settled motion
const OWN = /^o(t|x|u|v|film|thin|field)(\d?)$/; // names of the settled motion's arrays

// The settled motion as a scene, with the array names of a run; a periodic one is repeated over some drive periods.
/** @param {Record<string, any>} arrays @param {{periodic: boolean, periods: number, period: number}} how @returns {Scene | null} */
export function settledOf(arrays, { periodic, periods, period }) {
  /** @type {any} */ const found = {};
  for (const [name, values] of Object.entries(arrays)) { const own = OWN.exec(name); if (own) found[own[1] + own[2]] = values; }
  if (!found.t?.length) return null;
  const n = found.t.length - 1, turn = found.t[n];
  const times = periodic && turn > 0 && n > 0 ? Math.max(1, Math.min(Math.round((periods * period) / turn), Math.floor(MOST / n))) : 1;
  if (times > 1) for (const [name, values] of Object.entries(found)) {
    const own = new values.constructor(times * n + 1);
    for (let k = 0; k < times; k++) own.set(values.subarray(0, n), k * n);
    own[times * n] = values[n];
    if (name === "t") for (let i = 0; i <= times * n; i++) own[i] += turn * Math.min(Math.floor(i / n), times - 1);
    found[name] = own;
  }
  return found;
}

// The scene of a look: its settled motion, or the run if that is chosen or the settled motion is missing or outdated.
/** @param {any} look @param {string} motion @returns {Scene} */
export function sceneOf(look, motion) {
  return motion !== "start" && look.settled && !look.old ? look.settled : look;
}

// The sample before a time of a scene, and the fraction of the way to the next.
/** @param {{t: Float32Array}} scene @param {number} time @returns {[number, number]} */
export function placeAt({ t }, time) {
  const n = t.length - 1, place = Math.min((Math.max(time, 0) / t[n]) * n || 0, n), k = Math.min(Math.floor(place), Math.max(n - 1, 0));
  return [k, place - k];
}

// The height at a time of a scene, interpolated.
/** @param {Scene} scene @param {number} time @returns {number} */
export function heightAt(scene, time) {
  const [k, f] = placeAt(scene, time), { x } = scene;
  return x[k] + (x[Math.min(k + 1, x.length - 1)] - x[k]) * f;
}
