// The devices and presets as small moving cones to choose from, requested one after the other.
import { Cone } from "./cone.js";
import { make, say } from "./controls.js";
import { extent } from "./plot.js";
import { heightAt, placeAt } from "./scene.js";

const FRAME = 50; // ms between pictures
const SECONDS = 2; // duration of a drive period

export class Gallery {
  /** @type {any} */ dialog; /** @type {any} */ page;

  // page: ask(kind, content), choose({device or preset: name}).
  constructor(dialog, page) {
    Object.assign(this, { dialog, page, tiles: [], waiting: null, id: null, asked: null });
    this.list = make("div", { className: "tiles" });
    dialog.append(make("h2", { textContent: "Devices and parameter sets" }), this.list, make("div", { className: "row" }, make("button", { type: "button", textContent: "Close", onclick: () => dialog.close() })));
  }

  // hello: the server's lists of devices and presets.
  show(hello) {
    if (!this.tiles.length) {
      const named = [...hello.devices.map((name) => ["device", name, ""]), ...Object.entries(hello.presets).map(([name, purpose]) => ["preset", name, purpose])];
      this.tiles = named.map(([kind, name, about]) => this.tile(kind, name, about));
      this.list.replaceChildren(...this.tiles.map(({ box }) => box));
    }
    this.dialog.showModal();
    this.next();
    this.turn();
  }

  tile(kind, name, about) {
    const canvas = make("canvas", { role: "img", "aria-label": `${name}, moving` }), note = make("span", { textContent: about });
    const box = make("button", { type: "button", className: "tile", onclick: () => { this.dialog.close(); this.page.choose({ [kind]: name }); } }, canvas, make("b", { textContent: name }), note);
    return { kind, name, box, note, cone: new Cone(canvas, true), look: null, failed: false };
  }

  // Requests the next missing picture.
  next() {
    this.asked = this.tiles.find((tile) => !tile.look && !tile.failed) ?? null;
    this.id = this.asked ? this.page.ask("glance", { setting: { [this.asked.kind]: this.asked.name } }) : null;
  }

  message(head, arrays) {
    if (head.kind !== "glance") return false;
    if (head.id !== this.id) return true;
    const [low, high] = extent(arrays.x), { asked } = this;
    asked.look = { ...arrays, words: head.words, about: head.about, low, high };
    if (head.about.name) say(asked.note, head.about.name);
    this.follow();
    return true;
  }

  failed(head) {
    if (head.id !== this.id || this.id === null) return false;
    this.asked.failed = true;
    say(this.asked.note, head.message);
    this.follow();
    return true;
  }

  follow() { this.id = null; if (this.dialog.open) this.next(); }

  // Draws the tiles in sight, while the gallery is open.
  turn() {
    clearTimeout(this.waiting);
    if (!this.dialog.open) return;
    const now = performance.now() / 1000, seen = this.dialog.getBoundingClientRect();
    for (const { cone, look, box } of this.tiles) {
      const own = box.getBoundingClientRect();
      if (!look || own.top > seen.top + seen.height || own.top + own.height < seen.top) continue;
      const time = ((now / SECONDS) * look.words.period) % (look.t.at(-1) || 1), [k] = placeAt(look, time);
      cone.draw([{ about: look.about, height: heightAt(look, time), films: [look.film1 ?? look.film, look.film2 ?? look.film].map((own) => own[k]), field: [look.field1 ?? look.field, look.field2 ?? look.field].map((own) => own?.[k]), low: look.low, high: look.high, volts: [0, 1], voltage: 0, heightText: "", voltageText: "" }]);
    }
    this.waiting = setTimeout(() => this.turn(), FRAME);
  }
}
