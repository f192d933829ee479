// Sentences to the user: how long they stay.
import assert from "node:assert/strict";
import test from "node:test";
import { browser, made, wait } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { Notices } = await from("notices");

test("the newest three sentences stay until each is put away, a text of a moment goes by itself", () => {
  browser();
  const $ = (id) => document.getElementById(id), own = new Notices($("notices"), $("toast")), lines = () => $("notices").parts.map((line) => line.parts[0].textContent);
  for (const text of ["one", "two", "-3 um", "four"]) own.add(text);
  assert.deepEqual(lines(), ["two", "−3 µm", "four"]);
  assert.equal(made($("notices").parts[0]), 'p [span "two", -button.more "more" expanded=false, button.tiny ‹Put away› "×"]');
  $("notices").parts[1].parts.at(-1).click();
  own.pass("done");
  assert.deepEqual([lines(), $("toast").hidden, $("toast").textContent], [["two", "four"], false, "done"]);
  wait(2499);
  assert.equal($("toast").hidden, false);
  wait(2500);
  assert.deepEqual([lines(), $("toast").hidden], [["two", "four"], true]);
});
