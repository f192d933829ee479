// A look as the answers add to it: what each puts in, and what of an older setting goes.
import assert from "node:assert/strict";
import test from "node:test";
import { browser } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { judged, missing, numbered, renewed } = await from("looks");
const HEAD = { id: 7, words: { ended: "", period: 10 }, about: { si: true } };
const number = (name, more = {}) => ({ name, text: name, ...more });
const older = () => ({ lines: ["rest"], late: "l", problem: "p", unmade: "u", unmeasured: "m", film1: [1], film2: [2], ox: [1], px: [1], settled: {}, shares: [], extent: [1, 2], statics: { top: 1 }, spectrum: { top: 2 }, numbers: new Map([["stroke", number("stroke")], ["pull-in", number("pull-in", { peak: 2 })]]) });

test("a response takes the words and reasons of an older setting away, and leaves its pictures and numbers, marked as old", () => {
  const look = renewed(older(), HEAD, { t: [0, 1], film1: [5] });
  for (const name of ["lines", "late", "problem", "unmade", "unmeasured"]) assert.ok(!(name in look), name);
  assert.deepEqual([look.id, look.t, look.film1, look.film2, look.words, look.about], [7, [0, 1], [5], undefined, HEAD.words, HEAD.about]);
  assert.deepEqual([look.statics, look.spectrum, look.ox, [...look.numbers.values()].map(({ old }) => old)], [{ top: 1, old: true }, { top: 2, old: true }, [1], [true, true]]);
  const ended = renewed(older(), { ...HEAD, words: { ended: "pulled in" } }, {});
  assert.deepEqual([ended.ox, ended.px, ended.settled, ended.shares, ended.extent], Array(5).fill(undefined));
  assert.equal(renewed({}, HEAD, {}).numbers.size, 0);
});

test("the kind of motion brings the settled motion over as many periods, and its own numbers for the older ones", () => {
  const orbit = { ot: Float32Array.of(0, 5, 10), ox: Float32Array.of(1, 2, 1), ou: Float32Array.of(0, 0, 0), px: Float32Array.of(1), pu: Float32Array.of(0) };
  for (const [regime, wanders, samples] of [[0, false, 7], [1, false, 7], [2, true, 3], [3, true, 3]]) {
    const look = { ...renewed(older(), HEAD, {}), old: true };
    judged(look, { words: { regime, lines: ["kind"], shares: [{ code: 0, share: 1 }], extent: [1, 2], numbers: [number("lag")] } }, orbit, 3);
    assert.deepEqual([look.wanders, look.settled.t.length, look.old, look.regime, look.lines, look.extent, look.ox, look.shares.length], [wanders, samples, false, regime, ["kind"], [1, 2], orbit.ox, 1]);
    assert.deepEqual([...look.numbers.keys()], ["pull-in", "lag"]);
  }
  const look = renewed(older(), { ...HEAD, words: { ended: "pulled in", period: 10 } }, {});
  judged(look, { words: { regime: 1, lines: [] } }, orbit, 3);
  assert.equal(look.settled, null);
  judged(look, { words: { regime: 1, lines: [] } }, { px: orbit.px }, 3);
  assert.deepEqual([look.ox, look.px], [undefined, orbit.px]);
});

test("a number takes the place of one of its name, and a pull-in also that of the other film", () => {
  const look = { numbers: older().numbers };
  numbered(look, { numbers: [number("stroke", { text: "new" }), number("charge")] });
  assert.deepEqual([...look.numbers.values()].map(({ text }) => text), ["new", "pull-in", "charge"]);
  numbered(look, { numbers: [number("pull-in of the second", { peak: 3 })] });
  assert.deepEqual([...look.numbers.keys()], ["stroke", "charge", "pull-in of the second"]);
  numbered(look, {});
  assert.equal(look.numbers.size, 3);
});

test("the reason of a missing answer stands where that is shown, in place of what an older setting had there", () => {
  for (const [stage, name] of [["statics", "problem"], ["spectrum", "unmeasured"], ["film", "unmade"], ["kind", "late"]]) {
    const look = renewed(older(), HEAD, {});
    look.numbers.set("charge", number("charge"));
    missing(look, { stage, message: "too long" });
    assert.deepEqual(["problem", "unmeasured", "unmade", "late"].map((own) => look[own]), ["problem", "unmeasured", "unmade", "late"].map((own) => (own === name ? "too long" : undefined)));
    assert.deepEqual([Boolean(look.statics), Boolean(look.spectrum)], [stage !== "statics", stage !== "spectrum"]);
    assert.deepEqual([look.numbers.size, Boolean(look.ox), Boolean(look.settled), Boolean(look.extent)], stage === "kind" ? [1, false, false, false] : [3, true, true, true]);
  }
});
