// The player: the time shown, and the speed.
import { format, icon, say } from "./controls.js";
import { placeAt, sceneOf } from "./scene.js";

const PLAY = "M4 3v12l9-6z", PAUSE = "M5 3v12M11 3v12";
const TEXT_EVERY = 120; // ms between updates of slider and text while playing: each lays out the page
const SECONDS = [8, 4, 2, 1, 0.5];

export class Clock {
  /** @type {HTMLElement} */ play; /** @type {HTMLInputElement} */ scrub; /** @type {HTMLElement} */ output; /** @type {HTMLSelectElement} */ speed;
  /** @type {any} */ looks; /** @type {() => void} */ wakes; moved = false; /** @type {string | undefined} */ key;

  constructor({ play, scrub, output, speed }, looks) {
    Object.assign(this, { play, scrub, output, speed, looks, wakes: () => {} }); // wakes(): asks for a new picture
    this.at = 0; this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches; this.before = null; this.written = 0;
    play.onclick = () => { this.playing = !this.playing; if (this.playing && this.at >= this.length()) this.at = 0; this.button(); this.wakes(); };
    scrub.oninput = () => { this.playing = false; this.button(); this.at = (scrub.value / 1000) * this.length(); this.moved = true; this.wakes(); };
    this.button();
  }

  button() {
    this.play.replaceChildren(icon(this.playing ? PAUSE : PLAY, 16));
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  // Goes back to the begin of the run.
  restart(playing) { this.at = 0; this.playing = playing; this.button(); }

  // Pauses at a time of the run.
  goTo(time) {
    this.playing = false; this.button();
    this.at = Math.min(Math.max(time, 0), this.length()); this.moved = true; this.wakes();
  }

  // The look that gives period, units and end: of two settings that which is changed, as soon as it is there.
  look() { return [this.looks[this.looks.active], this.looks.a, this.looks.b].find((look) => look?.t); }

  scene(look) { return sceneOf(look, this.looks.motion); }

  length() { return Math.max(0, ...["a", "b"].map((side) => this.looks[side]).map((look) => (look?.t ? this.scene(look).t.at(-1) : 0))); }

  // Offers the speeds for a period in ms; with SI units as factors of real time.
  speeds(period, si) {
    const key = `${format(period, 3)} ${si}`;
    if (key === this.key) return;
    this.key = key;
    const chosen = this.speed.value || "2";
    const slower = (seconds) => format(seconds / (period / 1000), 2);
    /** @type {[number, string][]} */
    const names = SECONDS.map((s) => [s, si ? (s > period / 1000 ? `${slower(s)}× slower` : `${format((period / 1000) / s, 2)}× faster`) : `${s} s a period`]);
    if (si) names.push([period / 1000, "real time"]);
    this.speed.replaceChildren(...names.map(([s, text]) => new Option(text, s === period / 1000 ? "real" : String(s))));
    this.speed.value = [...this.speed.options].some((o) => o.value === chosen) ? chosen : "2";
  }

  tick(now) {
    const look = this.look();
    if (!look) { this.before = now; return; }
    const length = this.length(), period = look.words.period;
    if (this.playing && this.before !== null) {
      const seconds = this.speed.value === "real" ? period / 1000 : Number(this.speed.value) || 2;
      this.at += (Math.min(now - this.before, 100) / 1000) * (period / seconds);
      this.moved = true;
    }
    this.before = now;
    if (this.at <= length) return;
    if (look.words.ended) { this.at = length; this.playing = false; this.button(); } // a run that ended plays once
    else this.at %= length || 1;
  }

  // Updates slider and text.
  write(now) {
    const length = this.length();
    if (this.playing && now - this.written < TEXT_EVERY) return;
    this.written = now;
    this.scrub.value = String((1000 * this.at) / (length || 1));
    this.scrub.style.setProperty("--fill", `${this.scrub.value / 10}%`);
    const text = this.look().about.si ? (length >= 2000 ? `${(this.at / 1000).toFixed(2)} s` : `${this.at.toFixed(0)} ms`) : `time ${format(this.at, 3)}`;
    say(this.output, text);
    this.scrub.setAttribute("aria-valuetext", text);
  }

  time() { return this.look() ? this.at : null; }

  // The state of a look at the time shown, interpolated, with state, thickness and field of each film; null after the end
  // of the run.
  state(look) {
    if (!look.t) return null;
    const scene = this.scene(look), [k, f] = placeAt(scene, this.at), next = Math.min(k + 1, scene.t.length - 1);
    const between = (values) => values[k] + (values[next] - values[k]) * f;
    const films = [1, 2].map((number) => (scene[`film${number}`] ?? scene.film)[f < 0.5 ? k : next]);
    const of = (name) => [1, 2].map((number) => scene[`${name}${number}`] ?? scene[name]).map((values) => (values ? between(values) : NaN));
    const state = { x: between(scene.x), u: between(scene.u), v: between(scene.v), films, thin: of("thin"), field: of("field") };
    return Number.isFinite(state.x) ? state : null;
  }
}
