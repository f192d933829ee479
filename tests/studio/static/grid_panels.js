// The panels over parameters with controls, and a page that notes what they ask for.
import { browser, forget, texts } from "./page.js";

browser();
const { GridPanels } = await import("../../../src/gelcone/studio/static/grids.js");
const { Controls } = await import("../../../src/gelcone/studio/static/controls.js");

export const number = (name, value, low, high, unit = "", powers = { "": 0 }) => ({ name, label: name, group: "Drive", kind: "number", value, unit, low, high, powers, about: "", choices: [] });
const VOLTS = { V: 0, kV: 3, mV: -3, MV: 6 }, HERTZ = { Hz: 0, kHz: 3, mHz: -3 };

export const LIST = [
  { ...number("waveform", "sine", 0, 1), kind: "choice", choices: ["sine", "triangle"] },
  number("voltage_amplitude", 800, 0, 1600, "V", VOLTS), number("voltage_offset", 1, 0, 2, "kV", VOLTS), number("frequency", 10, 0.1, 20, "Hz", HERTZ), { ...number("film_thickness", 0.2, 0.01, 0.4, "mm", { m: 0, mm: -3 }), group: "Body" },
];
export const LEGEND = { regimes: [{ name: "rest", colour: "#777777" }, { name: "periodic", colour: "#0072b2" }, { name: "quasi-periodic", colour: "#009e73" }, { name: "chaotic", colour: "#d55e00" }], pulled_in: { name: "pulled in", colour: "#5b5b5b" } };

export function setUp(right = "map") {
  browser();
  const $ = (id) => document.getElementById(id), asked = [], gone = [];
  const state = { x: null, y: null, over: null, right, view: "kind" }, setting = { device: "pump", preset: null, file: null, values: {} };
  const controls = new Controls({ drive: $("drive"), groups: $("groups"), group: $("group"), general: $("general"), changed() {} });
  controls.show(LIST, {});
  const page = {
    ask: (kind, content) => { asked.push([kind, content]); return asked.length; }, setting: () => setting, state: () => state, legend: () => LEGEND, controls: () => controls,
    look: () => ({ about: { si: true, axes: { displacement: "height (mm)" } } }), go: (values, settled) => { gone.push([values, settled]); Object.assign(setting.values, values); controls.values(setting.values); }, keep() {},
  };
  const grids = new GridPanels({ hosts: { map: $("map"), strip: $("strip"), envelope: $("envelope") }, share: $("grid-share"), page });
  grids.controlsChanged();
  const panel = grids.open;
  return { grids, panel, asked, gone, state, setting, controls, page, said: () => $("grid-share").textContent, p: panel.plot, canvas: panel.plot.canvas, id: () => panel.id };
}

export const pointer = (p, x, y) => ({ clientX: 10 + x, clientY: 20 + y, pointerId: 1 });
export const placed = (p, name) => p.marks.get(name).hidden ? null : p.marks.get(name).style.transform.match(/-?[\d.]+/g).map(Number);

// All cells of a map, as the server sends them: of a kind by their place.
export function cells(kind) {
  const places = [], regime = [];
  for (let i = 0; i < 65; i++) for (let j = 0; j < 49; j++) { places.push(i * 49 + j); regime.push(kind(i, j)); }
  const own = Float32Array.from(places);
  return { places: own, regime: Uint8Array.from(regime), exponent: own.map((k) => (k % 49) / 48 - 0.5), low: own.map(() => 1), high: own.map((k) => 1 + Math.floor(k / 49) / 64) };
}

export const HEAD = { kind: "envelope", limits: ["pull-in"], static: { "pull-in": 1900 }, highest: 2500, least: 5, most: 15, share: 0, pull_in_of: "membrane", shape: { voltage_amplitude: 800 / 1800, voltage_offset: 1000 / 1800 } };

export function envelope() {
  const own = setUp("envelope");
  own.grids.message({ ...HEAD, id: own.id() }, { frequency: Float32Array.of(), window: Float32Array.of(), "limit pull-in": Float32Array.of() });
  own.panel.redrawOver();
  const first = [...["static pull-in of the membrane", "recommended"].map((text) => texts(own.p.context).includes(text)), own.panel.words.textContent];
  forget(own.p.context);
  own.grids.message({ ...HEAD, id: own.id(), static: { "pull-in": 1900, none: null }, share: 0.42 }, { frequency: Float32Array.of(5, 10, 15), window: Float32Array.of(2000, 1000, 2000), "limit pull-in": Float32Array.of(2400, 1200, NaN) });
  const half = [own.said(), own.panel.running, own.panel.verdict(7.5, 1234)];
  forget(own.p.context);
  own.grids.message({ kind: "done", id: own.id(), grid: "envelope" }, {});
  return { ...own, first, half };
}
