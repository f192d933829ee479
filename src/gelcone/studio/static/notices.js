// Sentences to the user: those that stay until they are put away, and those of a moment.
import { make, opener, short, typeset } from "./controls.js";

const MOST = 3, MOMENT = 2500; // ms

export class Notices {
  constructor(list, passing) { this.list = list; this.passing = passing; }

  // Shows a sentence until it is put away; the newest few are listed.
  add(text) {
    const sentence = make("span", { textContent: typeset(text) }), line = make("p", {}, sentence), more = opener(line);
    line.append(more, make("button", { type: "button", className: "tiny", "aria-label": "Put away", textContent: "×", onclick: () => line.remove() }));
    this.list.append(line);
    more.hidden = !short(sentence);
    while (this.list.children.length > MOST) this.list.firstChild.remove();
  }

  // Shows a text for a moment.
  pass(text) {
    this.passing.textContent = text; this.passing.hidden = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => { this.passing.hidden = true; }, MOMENT);
  }
}
