// Measured curves from CSV files, drawn over the computed ones; they are read here and never sent to the server.
import { colours } from "./colours.js";

export const LARGEST = 2_000_000; // most characters of a file
const MOST_ROWS = 20000, MOST_COLUMNS = 32, MOST_FILES = 6, LONGEST = 60;
const MM = { m: 1e3, cm: 10, mm: 1, um: 1e-3, "µm": 1e-3, "μm": 1e-3 };
/** @type {Record<string, [string, Record<string, number>]>} what a column holds by its name, and factors from its units to those of the axes */
const COLUMNS = {
  time: ["time", { s: 1e3, ms: 1, us: 1e-3, "µs": 1e-3, "μs": 1e-3 }], t: ["time", { s: 1e3, ms: 1, us: 1e-3, "µs": 1e-3, "μs": 1e-3 }],
  voltage: ["voltage", { V: 1, kV: 1e3 }], u: ["voltage", { V: 1, kV: 1e3 }],
  height: ["height", MM], displacement: ["height", MM], position: ["height", MM], stroke: ["stroke", MM],
};
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;

/** @typedef {{name: string, over: "time" | "voltage", from: "height" | "stroke", along: Float64Array, values: Float64Array, volts: Float64Array | null, low: Float64Array | null, high: Float64Array | null}} Measured */

// A curve of heights or strokes over time or voltage; throws an error of one line with the remedy.
/** @param {string} name @param {string} text @returns {Measured} */
export function readMeasured(name, text) {
  name = name.replace(/[^\x20-\x7e\u00a0-\uffff]/g, " ").slice(0, LONGEST);
  const no = (reason) => { throw new Error(`${name}: ${reason}`); };
  if (text.length > LARGEST) no(`has more than ${LARGEST} characters; export fewer rows`);
  if (text.includes("\0")) no("is not a text; export CSV");
  const lines = text.replace(/^\ufeff/, "").split(/\r\n|\n|\r/).map((line, k) => /** @type {[number, string]} */ ([k + 1, line])).filter(([, line]) => line.trim() && !line.startsWith("#"));
  if (lines.length < 3) no("needs a line of names with units, such as time (ms),height (mm), and two rows of numbers");
  if (lines.length > MOST_ROWS + 2) no(`has more than ${MOST_ROWS} rows; export fewer`);
  const head = String(lines[0][1]), mark = [";", "\t", ","].find((own) => head.includes(own));
  if (!mark) no("line 1 names one column; give two, such as time (ms),height (mm)");
  const cells = (line) => String(line).split(mark).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1").trim());
  const names = cells(head), places = {};
  if (names.length > MOST_COLUMNS) no(`has ${names.length} columns; give at most ${MOST_COLUMNS}`);
  const second = cells(lines[1][1]), inSecond = !second.some((cell) => NUMBER.test(cell.replace(",", ".")));
  names.forEach((cell, k) => {
    const [, own, unit] = cell.match(/^([^([/]*?)\s*(?:[([/]\s*([^)\]]*?)\s*[)\]]?)?$/) ?? ["", cell, ""];
    const [, base, end] = own.toLowerCase().trim().match(/^(.*?)(?:[ _](low|high))?$/);
    if (!Object.hasOwn(COLUMNS, base)) return;
    const [kind, units] = COLUMNS[base], stated = unit || (inSecond ? (second[k] ?? "").replace(/[()[\]]/g, "") : ""), key = end ?? kind;
    if (!Object.hasOwn(units, stated)) no(`line 1: column "${cell.slice(0, LONGEST)}": ${stated ? `"${stated.slice(0, 20)}" is not its unit` : "has no unit"}; write ${own} (${Object.keys(units).slice(0, 3).join(", ")})`);
    if (key in places) no(`line 1: two columns hold ${key}; leave one out`);
    places[key] = [k, units[stated]];
  });
  const from = places.height ? "height" : "stroke", over = places.time ? "time" : "voltage";
  if (!places[from] || !places[over]) no("needs a column time (ms) or voltage (V), and one height (mm) or stroke (mm)");
  const rows = lines.slice(inSecond ? 2 : 1), found = Object.fromEntries(Object.keys(places).map((key) => [key, new Float64Array(rows.length)]));
  rows.forEach(([number, line], i) => {
    const own = cells(line);
    if (own.length !== names.length) no(`line ${number}: has ${own.length} values, the first line ${names.length}${mark === "," ? "; with decimal commas separate columns by semicolons" : ""}`);
    for (const [key, [k, factor]] of Object.entries(places)) {
      const cell = mark === "," ? own[k] : own[k].replace(",", ".");
      if (!NUMBER.test(cell)) no(`line ${number}: ${JSON.stringify(own[k].slice(0, 20))} is not a number`);
      found[key][i] = Number(cell) * factor;
      if (!Number.isFinite(Math.fround(found[key][i]))) no(`line ${number}: ${own[k].slice(0, 20)} is too large`);
    }
  });
  if (over === "time" && found.time.some((t, i) => i && t < found.time[i - 1])) no("its times go back; sort its rows");
  if (Boolean(found.low) !== Boolean(found.high)) no("a band needs two columns, such as height low (mm) and height high (mm)");
  return { name, over, from, along: found[over], values: found[from], volts: over === "time" ? found.voltage ?? null : null, low: found.low ?? null, high: found.high ?? null };
}

// The curves with one more; drops the oldest beyond MOST_FILES.
/** @param {Measured[] | undefined} known @param {Measured} more */
export const withMeasured = (known, more) => [...(known ?? []).filter((own) => own.name !== more.name), more].slice(-MOST_FILES);

// The curve in the plot's coordinates: strokes start at the computed rest, times at the first sample.
/** @param {Measured} own @param {number} rest */
function placed(own, rest) {
  const shift = own.from === "stroke" ? rest : 0, begin = own.over === "time" ? own.along[0] : 0;
  const moved = (values) => values && Float64Array.from(values, (v) => v + shift);
  return { ...own, along: Float64Array.from(own.along, (v) => (own.over === "time" ? v - begin : Math.abs(v))), values: moved(own.values), low: moved(own.low), high: moved(own.high) };
}

// The measured curves over time or voltage, if the results have units; `rest` is the computed height without voltage.
export function shownOver(looks, over, rest) {
  if (!looks[looks.active]?.about?.si || !Number.isFinite(rest)) return [];
  return (looks.measured ?? []).filter((own) => own.over === over).map((own) => placed(own, rest));
}

export const rangesOf = (curves) => curves.flatMap((own) => [own.values, own.low ?? [], own.high ?? []]);

// Draws bands, points and names of curves.
export function drawMeasured(p, curves) {
  const colour = colours().ink;
  curves.forEach((own, row) => {
    if (own.low) p.inside((g) => {
      g.globalAlpha = 0.22; g.fillStyle = colour; g.beginPath();
      own.along.forEach((v, i) => g[i ? "lineTo" : "moveTo"](p.X(v), p.Y(own.high[i])));
      for (let i = own.along.length - 1; i >= 0; i--) g.lineTo(p.X(own.along[i]), p.Y(own.low[i]));
      g.closePath(); g.fill();
    });
    if (own.low) p.line(own.along, own.values, { colour, dash: [1, 2] }); else p.points(own.along, own.values, { colour, size: own.along.length > 200 ? 2 : 4 });
    p.label(own.name, p.right - 6, p.bottom - 8 - 14 * row, { colour, align: "right" });
  });
}
