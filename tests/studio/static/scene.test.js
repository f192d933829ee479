// Scenes: the settled motion over the run, and heights between samples.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, near } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { settledOf, sceneOf, heightAt } = await from("scene");

test("a periodic motion is repeated over the run, one that wanders is shown as it came, and one that is awaited not", () => {
  const orbit = { ot: Float32Array.of(0, 5, 10), ox: Float32Array.of(1, 2, 1), ou: Float32Array.of(0, 0, 0), ov: Float32Array.of(3, 4, 3), ofilm: Uint8Array.of(0, 4, 0), othin: Float32Array.of(0.5, 0.4, 0.5), px: Float32Array.of(7) };
  const own = settledOf(orbit, { periodic: true, periods: 4, period: 5 });
  assert.deepEqual([...own.t], [0, 5, 10, 15, 20]);
  assert.deepEqual([[...own.x], [...own.film], own.thin.length, "px" in own], [[1, 2, 1, 2, 1], [0, 4, 0, 4, 0], 5, false]);
  assert.deepEqual([...settledOf(orbit, { periodic: false, periods: 400, period: 5 }).t], [0, 5, 10]);
  const names = ["t", "x", "u", "v", "film", "film1", "film2", "thin", "thin1", "thin2", "field", "field1", "field2"], whole = settledOf(Object.fromEntries(names.map((name) => [`o${name}`, orbit.ot])), { periodic: true, periods: 4, period: 5 });
  assert.deepEqual([Object.keys(whole), names.filter((name) => whole[name].length !== 5)], [names, []]); // of two films each
  assert.equal(settledOf({ px: orbit.px }, { periodic: true, periods: 4, period: 5 }), null);
  assert.equal(settledOf(orbit, { periodic: true, periods: 1e9, period: 5 }).t.length, 200001);
  const look = { settled: own, x: [] };
  assert.deepEqual([sceneOf(look, "settled") === own, sceneOf(look, "start") === look, sceneOf({ ...look, old: true }, "settled").settled === own], [true, true, true]);
  assert.equal(sceneOf({ ...look, old: true }, "settled").x.length, 0);
  for (const [time, height] of [[0, 1], [2.5, 1.5], [5, 2], [17.5, 1.5], [20, 1], [99, 1], [-1, 1]]) assert.ok(near(heightAt(own, time), height, 1e-6), time);
});
