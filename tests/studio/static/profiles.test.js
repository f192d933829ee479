// Profiles between the entries of a table.
import assert from "node:assert/strict";
import test from "node:test";

const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { add, profile } = await from("profiles");

// two heights, shares 0 and .5, rings disc, middle, rim
const flat = (value) => Array(2).fill(value).flat();
add({ name: "one", shares: [0, 0.5], rings: 3 }, {
  height: [0, 10], top: [100, 200], radius: [...flat([5, 12, 20]), ...flat([5, 10, 20])], rise: [...flat([1, 0.5, 0]), ...flat([1, 0.3, 0])],
  stretch: [1, 1, 1, 1, 1, 1, 2, 1.4, 1.2, 4, 2.4, 2.2], wrinkled: [0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1],
});

test("an entry is given as it is", () => {
  assert.deepStrictEqual(profile("one", 10, 0).map((ring) => ring.stretch), [2, 1.4, 1.2]);
  assert.deepStrictEqual(profile("one", 0, 0).map((ring) => ring.radius), [5, 12, 20]);
});

test("between entries it is linear in the height and in the squared voltage", () => {
  const found = profile("one", 5, 0);
  assert.ok(Math.abs(found[1].radius - 11) < 1e-12 && Math.abs(found[1].rise - 0.4) < 1e-12);
  const quarter = profile("one", 10, 100); // a quarter of the squared top voltage 200
  assert.ok(Math.abs(quarter[0].stretch - 3) < 1e-12);
});

test("a depressed disc is the mirror image, a higher one keeps the last shape", () => {
  assert.deepStrictEqual(profile("one", -10, 0), profile("one", 10, 0));
  assert.deepStrictEqual(profile("one", 14, 0), profile("one", 10, 0));
});

test("wrinkles are those of the nearer entry", () => {
  assert.deepStrictEqual(profile("one", 10, 141).map((ring) => ring.wrinkled), [false, true, true]);
  assert.deepStrictEqual(profile("one", 10, 60).map((ring) => ring.wrinkled), [false, false, false]);
});

test("without a table, beyond the top voltage and without a height there is none", () => {
  assert.strictEqual(profile("other", 5, 0), null);
  assert.strictEqual(profile("", 5, 0), null);
  assert.strictEqual(profile(undefined, 5, 0), null);
  assert.strictEqual(profile("one", 10, 201), null);
  assert.strictEqual(profile("one", NaN, 0), null);
});

test("tables are held until there are too many, and then the oldest goes", () => {
  const table = { height: [0, 10], top: [100, 200], radius: [5, 5], rise: [1, 1], stretch: [1, 1], wrinkled: [0, 0] };
  for (let k = 0; k < 33; k++) add({ name: `more ${k}`, shares: [0], rings: 1 }, table);
  assert.deepStrictEqual([0, 1, 31, 32].map((k) => profile(`more ${k}`, 5, 0) !== null), [false, true, true, true]);
});

test("profiles between heights and voltages, by hand", () => {
  const flat = (values) => Float32Array.from(values);
  add({ name: "made", shares: [0, 1], rings: 2 }, { height: flat([0, 10]), top: flat([100, 200]), radius: flat([1, 2, 3, 4, 5, 6, 7, 8]), rise: flat([0, 0, 0, 0, 1, 1, 1, 1]), stretch: flat([1, 1, 2, 2, 3, 3, 4, 4]), wrinkled: flat([0, 1, 0, 1, 1, 1, 1, 1]) });
  for (const [height, voltage, radius, rise, stretch, wrinkled] of [[0, 0, 1, 0, 1, false], [0, 100, 3, 0, 2, false], [10, 0, 5, 1, 3, true], [10, 200, 7, 1, 4, true], [5, 0, 3, 0.5, 2, false], [10, 100, 5.5, 1, 3.25, true], [-10, 0, 5, 1, 3, true]]) {
    const [first] = profile("made", height, voltage);
    assert.deepEqual([first.radius, first.rise, first.stretch, first.wrinkled], [radius, rise, stretch, wrinkled], `${height} ${voltage}`);
  }
  assert.deepEqual([profile("made", 0, 101), profile("other", 0, 0), profile("made", NaN, 0)], [null, null, null]);
});

test("each entry of a table is found by its own height, share and ring, however many there are of each", () => {
  for (const [heights, shares, rings] of [[4, 2, 3], [2, 4, 3], [3, 5, 2], [2, 3, 6]]) {
    const at = (i, j, k) => 100 * i + 10 * j + k, all = Array.from({ length: heights }, (_, i) => Array.from({ length: shares }, (_, j) => Array.from({ length: rings }, (_, k) => at(i, j, k)))).flat(2), none = all.map(() => 0);
    add({ name: "counted", shares: Array.from({ length: shares }, (_, j) => j / (shares - 1)), rings }, { height: Array.from({ length: heights }, (_, i) => 5 * i), top: Array(heights).fill(1000), radius: all, rise: none, stretch: all, wrinkled: none });
    for (let i = 0; i < heights; i++) for (let j = 0; j < shares; j++) {
      const found = profile("counted", 5 * i, 1000 * Math.sqrt(j / (shares - 1)));
      assert.equal(found.length, rings);
      found.forEach((ring, k) => assert.ok(Math.abs(ring.radius - at(i, j, k)) < 1e-9 && ring.stretch === ring.radius, `${i} ${j} ${k}`));
    }
  }
});
