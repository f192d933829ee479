// The state of the page in its address: read, written, and what is not understood.
import assert from "node:assert/strict";
import test from "node:test";
import { browser } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const address = await from("address"), { read, write } = address;

test("an address read and written is the same", () => {
  const text = "device=biased-pump&frequency=9+Hz&material.law=yeoh&b.preset=base&b.voltage=1.04&side=b&periods=60&top=spectrum&left=statics&right=strip&view=stroke&x=frequency%2C1%2C20&y=voltage_amplitude%2C0%2C2&over=voltage%2C-1%2C2";
  const state = address.read(`#${text}`, "other");
  assert.deepEqual(state.a, { device: "biased-pump", preset: null, file: null, values: { frequency: "9 Hz", "material.law": "yeoh" } });
  assert.deepEqual(state.b, { device: null, preset: "base", file: null, values: { voltage: "1.04" } });
  assert.deepEqual([state.side, state.periods, state.top, state.left, state.right, state.view], ["b", "60", "spectrum", "statics", "strip", "stroke"]);
  assert.deepEqual([state.x, state.y, state.over], [["frequency", 1, 20], ["voltage_amplitude", 0, 2], ["voltage", -1, 2]]);
  assert.deepEqual(address.read(`#${address.write(state)}`, "other"), state);
  assert.deepEqual([...new URLSearchParams(address.write(state))].sort(), [...new URLSearchParams(text)].sort());
});

test("an address without a device takes the first, and usual values are not written", () => {
  const state = address.read("", "first");
  assert.deepEqual([state.a.device, state.b, state.side, state.periods, state.top, state.left, state.right, state.view], ["first", null, "a", "20", "time", "portrait", "map", "kind"]);
  assert.equal(address.write(state), "device=first");
  assert.equal(address.read("#side=b", "first").side, "a");
  assert.equal(address.read("#b.frequency=1+Hz", "first").b.device, "first");
  assert.equal(address.read("#device=other&b.frequency=1+Hz", "first").b.device, "first");
});

test("an axis in an address needs a name and two numbers", () => {
  for (const bad of ["x=frequency", "x=frequency,1", "x=frequency,a,2", "x=frequency,1,b", "x="]) assert.equal(address.read(bad, "d").x, null, bad);
});

test("locks are part of the link, as many as there can be controls, each once", () => {
  const state = address.read("#device=biased-pump&locked=frequency,spring_rate,frequency,", "");
  assert.deepEqual(state.locked, ["frequency", "spring_rate"]);
  assert.deepEqual(address.read(`#${address.write(state)}`, "").locked, state.locked);
  assert.equal(address.write({ ...state, locked: [] }).includes("locked"), false);
  assert.equal(address.read(`#locked=${[...Array(999).keys()].join(",")}`, "pump").locked.length, 60);
});

test("every part of the address has its usual value and its others, and is written only where it is another", () => {
  const parts = { periods: ["20", "5", "60", "200"], top: ["time", "spectrum"], left: ["portrait", "statics"], right: ["map", "strip", "envelope"], view: ["kind", "exponent", "stroke"], motion: ["settled", "start"] };
  for (const [name, values] of Object.entries(parts)) for (const value of values) {
    const state = read(`#device=pump&${name}=${value}`, "first"), usual = value === values[0];
    assert.deepEqual([state[name], state.odd, write(state)], [value, [], usual ? "device=pump" : `device=pump&${name}=${value}`]);
    for (const other of Object.keys(parts)) if (other !== name) assert.equal(state[other], parts[other][0]);
    const odd = read(`#device=pump&${name}=${value}x`, "first");
    assert.deepEqual([odd[name], odd.odd.length], [values[0], 1]);
    assert.match(odd.odd[0], new RegExp(`^${name} = ${value}x: is not one of ${values.join(", ")}; ${values[0]} is shown.$`));
  }
});

test("subjects, values, sides, axes and locks of an address", () => {
  const rows = [
    ["device=pump&film=taut&b.preset=base&b.voltage=2&side=b", { a: ["pump", null, { film: "taut" }], b: [null, "base", { voltage: "2" }], side: "b" }],
    ["preset=base&device=pump", { a: ["pump", null, {}], b: null, side: "a" }],
    ["device=pump&preset=base", { a: [null, "base", {}], b: null, side: "a" }],
    ["side=b", { a: ["first", null, {}], b: null, side: "a" }],
    ["b.voltage=3", { a: ["first", null, {}], b: ["first", null, { voltage: "3" }], side: "a" }],
    ["b.device=pump&side=c", { a: ["first", null, {}], b: ["pump", null, {}], side: "a" }],
  ];
  for (const [text, { a, b, side }] of rows) {
    const state = read(text, "first"), own = (s) => s && [s.device, s.preset, s.values];
    assert.deepEqual([own(state.a), own(state.b), state.side], [a, b, side], text);
    assert.deepEqual(read(write(state), "first"), state, text);
  }
  for (const name of ["x", "y", "over"]) {
    for (const [text, found] of [["voltage,0,2", ["voltage", 0, 2]], ["voltage,-1,2.5", ["voltage", -1, 2.5]], ["voltage,2,2", null], ["voltage,2,1", null], ["voltage,1", null], ["voltage,a,2", null], ["voltage,0,Infinity", null], ["voltage,,2", null]]) {
      const state = read(`${name}=${text}`, "first");
      assert.deepEqual([state[name], state.odd.length], [found, found ? 0 : 1], `${name}=${text}`);
      for (const other of ["x", "y", "over"]) if (other !== name) assert.equal(state[other], null);
    }
  }
  const many = Array.from({ length: 70 }, (_, k) => `p${k}`);
  assert.deepEqual(read(`locked=${many.join()}`, "").locked, many.slice(0, 60));
  assert.deepEqual(read("locked=a,,b,a", "").locked, ["a", "b"]);
});

test("of a long part that is not understood its beginning is said", () => {
  for (const name of ["periods", "x"]) {
    const [said] = read(`${name}=${"z".repeat(50)}`, "first").odd;
    assert.ok(said.startsWith(`${name} = ${"z".repeat(24)}: is not `), said);
  }
  assert.match(read("over=1", "first").odd[0], /^over = 1: is not a parameter with its two ends; the usual ones are shown\.$/);
});
