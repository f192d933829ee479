// Tabs: the one that is open, and the keys that go round them.
import assert from "node:assert/strict";
import test from "node:test";
import { browser } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { marked, turned } = await from("tabs");

test("the keyboard reaches the open tab alone, its arrows go round those that are there, and the next one has the cursor", () => {
  for (const hidden of [[], [1], [3], [0, 2]]) {
    const tabs = [0, 1, 2, 3].map((k) => Object.assign(document.createElement("button"), { hidden: hidden.includes(k), onclick() { marked(tabs, this); } })), there = tabs.filter((t) => !t.hidden);
    let at = 0;
    there[0].click();
    for (const [key, step] of [...Array(5).fill(["ArrowRight", 1]), ...Array(7).fill(["ArrowLeft", -1]), ["ArrowUp", 0], ["Tab", 0]]) {
      document.activeElement = null;
      turned(key, there[at], tabs);
      at = (at + step + there.length) % there.length;
      assert.deepEqual(tabs.map((t) => [t.getAttribute("aria-selected"), t.tabIndex]), tabs.map((t) => [String(t === there[at]), t === there[at] ? 0 : -1]), `${hidden} ${key}`);
      assert.equal(document.activeElement, step ? there[at] : null);
    }
  }
});
