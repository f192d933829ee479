// The state of the page, as the part of its address after the #.
const KEYS = ["device", "preset", "file"];
// The views that each part of the page may show, the default first.
const PAGE = { periods: ["20", "5", "60", "200"], top: ["time", "spectrum"], left: ["portrait", "statics"], right: ["map", "strip", "envelope"], view: ["kind", "exponent", "stroke"], motion: ["settled", "start"] };
const USUAL = Object.fromEntries(Object.entries(PAGE).map(([name, [usual]]) => [name, usual]));
const MOST_LOCKS = 60; // the server accepts this many values
const SHOWN = 24; // most characters of a value in a message

/**
 * What is shown: a device or preset by its name, or the text of a device file; and values by the names of controls.
 * @typedef {{device: string | null, preset: string | null, file: string | null, values: Record<string, string>}} Setting
 * A parameter with its two ends.
 * @typedef {[string, number, number]} Axis
 * The whole state of the page.
 * @typedef {{a: Setting, b: Setting | null, side: "a" | "b", x: Axis | null, y: Axis | null, over: Axis | null,
 *   locked: string[], odd: string[], periods: string, top: string, left: string, right: string, view: string, motion: string}} State
 */

// The state in an address; ``odd`` holds a sentence for each part that was not understood.
/** @param {string} text @param {string} start a device for an address without one @returns {State} */
export function read(text, start) {
  const given = new URLSearchParams(text.replace(/^#/, ""));
  const state = /** @type {State} */ ({ a: setting(), b: null, side: "a", ...USUAL, x: null, y: null, over: null, locked: [], odd: [] });
  for (const [name, value] of given) {
    if (Object.hasOwn(PAGE, name)) {
      if (PAGE[name].includes(value)) state[name] = value; else state.odd.push(`${name} = ${value.slice(0, SHOWN)}: is not one of ${PAGE[name].join(", ")}; ${state[name]} is shown.`);
    } else if (name === "side") state.side = value === "b" ? "b" : "a";
    else if (name === "locked") state.locked = [...new Set(value.split(",").filter(Boolean))].slice(0, MOST_LOCKS);
    else if (name === "x" || name === "y" || name === "over") {
      state[name] = axis(value);
      if (!state[name]) state.odd.push(`${name} = ${value.slice(0, SHOWN)}: is not a parameter with its two ends; the usual ones are shown.`);
    } else if (name.startsWith("b.")) put((state.b ??= setting()), name.slice(2), value);
    else put(state.a, name, value);
  }
  for (const own of [state.a, state.b]) if (own && !KEYS.some((key) => own[key])) own.device = start;
  if (!state.b) state.side = "a";
  return state;
}

/** @returns {Setting} */
const setting = () => ({ device: null, preset: null, file: null, values: {} });

function put(own, name, value) {
  if (!KEYS.includes(name)) { own.values[name] = value; return; }
  for (const key of KEYS) own[key] = null;
  own[name] = value;
}

/** @param {string} text @returns {Axis | null} */
function axis(text) {
  const [name, low, high] = text.split(",");
  return low && high && Number.isFinite(Number(low)) && Number(high) > Number(low) && Number.isFinite(Number(high)) ? [name, Number(low), Number(high)] : null;
}

/** @param {State} state @returns {string} */
export function write(state) {
  const out = new URLSearchParams();
  const add = (own, before) => {
    for (const key of KEYS) if (own[key]) out.set(before + key, own[key]);
    for (const [name, value] of Object.entries(own.values)) out.set(before + name, value);
  };
  add(state.a, "");
  if (state.b) { add(state.b, "b."); out.set("side", state.side); }
  for (const [name, usual] of Object.entries(USUAL)) if (state[name] !== usual) out.set(name, state[name]);
  for (const name of ["x", "y", "over"]) if (state[name]) out.set(name, state[name].join(","));
  if (state.locked?.length) out.set("locked", state.locked.join(","));
  return out.toString();
}
