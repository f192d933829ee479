// The theme: chosen, remembered, or that of the system.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, page } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { themed } = await from("theme");
const SYSTEM = "(prefers-color-scheme: dark)", theme = () => document.documentElement.dataset.theme;

test("a page without storage takes the theme of the system and of its button, and draws all anew at each change", () => {
  browser();
  const button = document.createElement("button"), drawn = [], no = () => { throw new Error("no storage"); };
  Object.assign(globalThis.localStorage, { getItem: no, setItem: no });
  themed(button, () => drawn.push(theme()));
  assert.deepEqual([theme(), button.title, drawn], ["light", "Dark", []]);
  for (const matches of [true, false, true]) { Object.assign(page.media[SYSTEM], { matches }).onchange(); assert.equal(theme(), matches ? "dark" : "light"); }
  button.click();
  assert.deepEqual([theme(), button.title, drawn], ["light", "Dark", ["dark", "light", "dark", "light"]]);
  page.media[SYSTEM].onchange();
  assert.deepEqual([theme(), drawn.length], ["light", 4]); // the chosen one stays
});
