// The whole state of the page as the part of its address behind the #.
const KEYS = ["device", "preset", "file"];
const PAGE = { periods: "20", top: "time", left: "portrait", right: "map", view: "kind", motion: "settled" };

export function read(text, start) {
  const given = new URLSearchParams(text.replace(/^#/, ""));
  const state = { a: setting(), b: null, side: "a", ...PAGE, x: null, y: null, over: null };
  for (const [name, value] of given) {
    if (name in PAGE) state[name] = value;
    else if (name === "side") state.side = value === "b" ? "b" : "a";
    else if (name === "x" || name === "y" || name === "over") state[name] = axis(value);
    else if (name.startsWith("b.")) put((state.b ??= setting()), name.slice(2), value);
    else put(state.a, name, value);
  }
  for (const own of [state.a, state.b]) if (own && !KEYS.some((key) => own[key])) own.device = start;
  if (!state.b) state.side = "a";
  return state;
}

const setting = () => ({ device: null, preset: null, file: null, values: {} });

function put(own, name, value) {
  if (KEYS.includes(name)) own[name] = value; else own.values[name] = value;
}

function axis(text) {
  const [name, low, high] = text.split(",");
  return Number.isFinite(Number(low)) && Number.isFinite(Number(high)) && high !== undefined ? [name, Number(low), Number(high)] : null;
}

export function write(state) {
  const out = new URLSearchParams();
  const add = (own, before) => {
    for (const key of KEYS) if (own[key]) out.set(before + key, own[key]);
    for (const [name, value] of Object.entries(own.values)) out.set(before + name, value);
  };
  add(state.a, "");
  if (state.b) { add(state.b, "b."); out.set("side", state.side); }
  for (const [name, usual] of Object.entries(PAGE)) if (state[name] !== usual) out.set(name, state[name]);
  for (const name of ["x", "y", "over"]) if (state[name]) out.set(name, state[name].join(","));
  return out.toString();
}
