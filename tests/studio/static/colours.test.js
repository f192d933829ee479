// Colours: those of the style sheet, and those mixed of them.
import assert from "node:assert/strict";
import test from "node:test";
import { DARK, LIGHT, browser } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const palette = await from("colours");

test("colours are those of the style sheet, by theme, and those of the film in the order of its states", () => {
  for (const [theme, own] of [["light", LIGHT], ["dark", DARK]]) {
    palette.setTheme(theme);
    const c = palette.colours();
    assert.deepEqual(c.film, [own.taut, own.around, own.meridian, own.both, own.breakdown, own.limit, own.beyond]);
    for (const name of ["a", "b", "accent", "panel", "ink", "soft", "line", "edge", "steel"]) assert.equal(c[name], own[name], name);
    assert.equal(c.dark, theme === "dark");
    assert.equal(new Set(c.film).size, 7);
  }
  palette.setTheme("light");
});

test("colours are mixed and written on so that they can be read", () => {
  assert.deepEqual(palette.rgb("#010fff"), [1, 15, 255]);
  assert.equal(palette.mix("#000000", "#ffffff", 0.5), "rgb(128,128,128)");
  assert.equal(palette.mix("#102030", "#405060", 0), "rgb(16,32,48)");
  assert.equal(palette.mix("#102030", "#405060", 1), "rgb(64,80,96)");
  const light = (hex) => { const [r, g, b] = palette.rgb(hex); return 0.299 * r + 0.587 * g + 0.114 * b; }; // as television weighs the colours
  for (const hex of ["#000000", "#ff0000", "#00ff00", "#0000ff", "#96a0ff", "#8090ff", "#ff9000", "#ff7000", "#60b8a0", "#a0a0a0", "#909090"]) assert.equal(palette.onto(hex) === "#10151b", light(hex) > 150, hex);
  assert.deepEqual(["#ffffff", "#f6e64b", "#000000", "#0072b2"].map(palette.onto), ["#10151b", "#10151b", "#ffffff", "#ffffff"]);
});
