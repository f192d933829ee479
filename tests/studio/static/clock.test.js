// The player: the time shown, its speed, and the state at that time.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, near, strokes } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { Clock } = await from("clock"), { placeAt, heightAt } = await from("scene");
const RUN = () => ({ t: Float32Array.of(0, 10, 20, 30, 40), x: Float32Array.of(0, 2, 4, 2, 0), u: Float32Array.of(1, 1, -1, -1, 1), v: Float32Array.of(0, 100, 0, -100, 0), film: Uint8Array.of(0, 1, 2, 3, 4), words: { period: 20, shares: [] }, about: { si: true } });

function clock(looks) {
  browser();
  const $ = (id) => document.getElementById(id);
  return new Clock({ play: document.getElementById("play"), scrub: document.getElementById("scrub"), output: document.getElementById("clock"), speed: document.getElementById("speed") }, looks);
}

const run = (end, more = {}) => ({ t: Float32Array.of(0, end / 2, end), x: Float32Array.of(0, 2, 4), u: Float32Array.of(0, 1, 0), v: Float32Array.of(0, 5, 9), film: Uint8Array.of(0, 1, 2), words: { period: 20, ended: "" }, about: { si: true }, ...more });

test("the state at a time lies between its samples, and the film's is that of the nearest", () => {
  const look = RUN(), own = clock({ a: look });
  for (const [at, x, v, film] of [[0, 0, 0, 0], [5, 1, 50, 1], [12, 2.4, 80, 1], [16, 3.2, 40, 2], [40, 0, 0, 4], [99, 0, 0, 4]]) {
    own.at = at;
    const state = own.state(look);
    assert.ok(near(state.x, x, 1e-5) && near(state.v, v, 1e-5), `${at}`);
    assert.deepEqual(state.films, [film, film]);
  }
  own.at = 15;
  assert.ok(near(own.state(look).u, 0));
  assert.deepEqual(own.state({ ...look, film1: Uint8Array.of(0, 0, 0, 0, 0), film2: Uint8Array.of(5, 5, 5, 5, 5) }).films, [0, 5]);
  own.at = 25;
  assert.equal(own.state({ ...look, x: Float32Array.of(0, 1, NaN, NaN, NaN) }), null);
  assert.equal(own.state({}), null);
});

test("time passes at the chosen speed, at most a tenth of a second a picture, and begins anew at the end", () => {
  const own = clock({ a: RUN() });
  own.speeds(20, true);
  own.tick(0);
  own.tick(50); // 2 s a period of 20 ms
  assert.ok(near(own.at, 0.5));
  own.tick(5050);
  assert.ok(near(own.at, 1.5));
  own.at = 39.9; own.tick(5100); own.tick(5150); own.tick(5200);
  assert.ok(own.at < 2);
  own.play.click();
  const before = own.at;
  own.tick(6000);
  assert.equal(own.at, before);
  own.play.click();
  own.speed.value = "real"; own.tick(6000);
  own.at = 10; own.tick(6008);
  assert.ok(near(own.at, 18));
});

test("the speeds say how much slower than real they are", () => {
  const own = clock({ a: RUN() }), names = () => own.speed.options.map((o) => [o.value, o.textContent]);
  own.speeds(100, true);
  assert.deepEqual(names(), [["8", "80× slower"], ["4", "40× slower"], ["2", "20× slower"], ["1", "10× slower"], ["0.5", "5× slower"], ["real", "real time"]]);
  assert.equal(own.speed.value, "2");
  own.speed.value = "0.5"; own.speeds(1000, true);
  assert.deepEqual([names()[4], own.speed.value], [["0.5", "2× faster"], "0.5"]);
  own.speeds(7, true);
  assert.deepEqual(names().slice(0, 2).map(([, text]) => text), ["1100× slower", "570× slower"]);
  own.speeds(30000, true);
  assert.deepEqual(names().slice(0, 2).map(([, text]) => text), ["3.8× faster", "7.5× faster"]);
  own.speeds(6.28, false);
  assert.deepEqual(names()[0], ["8", "8 s a period"]);
});

test("the slider goes through the whole run and holds it", () => {
  const own = clock({ a: RUN() });
  own.scrub.value = "250"; own.scrub.oninput();
  assert.deepEqual([own.at, own.playing, own.time()], [10, false, 10]);
  own.at = 30; own.write(1e6);
  assert.deepEqual([own.scrub.value, own.output.textContent], ["750", "30 ms"]);
  assert.equal(clock({}).time(), null);
});

test("the button of the player shows and says what a click does: two bars pause, a closed triangle plays", () => {
  const own = clock({ a: RUN() });
  for (let k = 0; k < 3; k++, own.play.click()) {
    const [first, ...more] = strokes(own.play), playing = k % 2 === 0;
    assert.deepEqual([own.playing, own.play.getAttribute("aria-label"), more.length, /z$/.test(first)], [playing, playing ? "Pause" : "Play", playing ? 1 : 0, !playing]);
  }
});

test("the slider of the player is filled up to its place, and read out as the time next to it", () => {
  const own = clock({ a: RUN() });
  for (const at of [0, 10, 30, 40]) {
    own.at = at; own.playing = false; own.write(0);
    assert.deepEqual([own.scrub.style["--fill"], own.scrub.getAttribute("aria-valuetext"), own.output.textContent], [`${(100 * at) / 40}%`, `${at} ms`, `${at} ms`]);
  }
});

test("a place of the run is gone to and held, none before its begin or after its end", () => {
  let woken = 0;
  const own = clock({ a: RUN() });
  own.wakes = () => { woken += 1; };
  for (const [to, at] of [[25, 25], [-3, 0], [400, 40]]) {
    own.playing = true; own.goTo(to);
    assert.deepEqual([own.at, own.playing, own.play.getAttribute("aria-label")], [at, false, "Play"]);
  }
  assert.equal(woken, 3);
  own.play.click(); // from its end it begins anew
  assert.deepEqual([own.at, own.playing, own.play.getAttribute("aria-label")], [0, true, "Pause"]);
});

test("the time is in milliseconds up to two seconds, then in seconds, and a number without units", () => {
  for (const [end, at, si, text] of [[40, 30, true, "30 ms"], [1999, 1000, true, "1000 ms"], [2000, 1500, true, "1.50 s"], [9000, 4321, true, "4.32 s"], [40, 12.345, false, "time 12.3"], [9000, 4321, false, "time 4320"]]) {
    const own = clock({ a: run(end, { about: { si } }) });
    own.at = at; own.playing = false; own.write(1e6);
    assert.deepEqual([own.output.textContent, own.scrub.getAttribute("aria-valuetext"), Number(own.scrub.value)], [text, text, (1000 * at) / end]);
  }
});

test("while it plays the text changes at most every 120 ms, while it stands always", () => {
  const own = clock({ a: run(40) });
  own.playing = true; own.at = 10; own.write(1000);
  own.at = 20; own.write(1119);
  assert.equal(own.output.textContent, "10 ms");
  own.write(1120);
  assert.equal(own.output.textContent, "20 ms");
  own.playing = false; own.at = 30; own.write(1121);
  assert.equal(own.output.textContent, "30 ms");
});

test("a run that ends is held at its end, another begins anew; the longer of two settings counts", () => {
  for (const [ended, at, playing] of [["pulled in", 40, false], ["", 5, true]]) {
    const own = clock({ a: run(40, { words: { period: 20, ended } }) });
    own.speeds(20, true); own.speed.value = "real"; own.tick(0);
    own.at = 40; own.tick(5);
    assert.deepEqual([own.at, own.playing], [at, playing]);
  }
  assert.deepEqual([clock({ a: run(40), b: run(60) }).length(), clock({ b: run(60) }).length(), clock({}).length()], [60, 60, 0]);
  const scene = { t: Float32Array.of(0, 10, 20), x: Float32Array.of(0, 2, 6) };
  for (const [time, k, f, x] of [[-1, 0, 0, 0], [0, 0, 0, 0], [5, 0, 0.5, 1], [10, 1, 0, 2], [15, 1, 0.5, 4], [20, 1, 1, 6], [99, 1, 1, 6]]) {
    assert.deepEqual(placeAt(scene, time), [k, f], `${time}`);
    assert.equal(heightAt(scene, time), x);
  }
});

test("a run of the second setting alone is played, too", () => {
  const own = clock({ b: run(40) });
  own.speeds(20, true); own.speed.value = "real"; own.tick(0); own.tick(8);
  assert.deepEqual([own.time(), own.look().t.length], [8, 3]);
  own.playing = false; own.write(0);
  assert.equal(own.output.textContent, "8 ms");
});

test("of two settings the longer run is played to its end, and speeds have the units of what is shown", () => {
  const own = clock({ a: run(40), b: run(60) });
  own.speeds(20, true); own.speed.value = "real"; own.tick(0);
  own.at = 50; own.tick(5);
  assert.equal(own.at, 55);
  const names = (si) => { own.speeds(20, si); return own.speed.options.map((o) => o.textContent); };
  assert.deepEqual([names(true).at(-1), names(false).at(-1), names(true).at(-1)], ["real time", "0.5 s a period", "real time"]);
});

test("of two settings period, units and end are those of the one that is changed, as soon as it is there", () => {
  const looks = { active: "b", a: run(40, { words: { period: 20, ended: "" } }), b: { about: { si: false } } }, own = clock(looks);
  own.speeds(20, true); own.speed.value = "2"; own.tick(0); own.tick(100);
  assert.ok(near(own.at, 1)); // a twentieth of a period of 20 ms
  looks.b = run(400, { words: { period: 200, ended: "" }, about: { si: false } });
  own.at = 0; own.tick(200);
  assert.ok(near(own.at, 10)); // of 200 ms
  own.playing = false; own.write(0);
  assert.equal(own.output.textContent, "time 10");
  looks.active = "a"; own.playing = true; own.at = 0; own.tick(300); own.playing = false; own.write(0);
  assert.deepEqual([near(own.at, 1), own.output.textContent], [true, "1 ms"]);
});
