// The dialog that saves files, and shows the command and Python lines that give the same numbers.
import { make } from "./controls.js";
import { caption, composed, filmed } from "./film.js";

const WHAT = { simulate: "Time response", section: "Phase portrait: section", spectrum: "Spectrum", regime: "Kind of motion, with its evidence", static: "Statics", map: "Map", bifurcation: "Sweep of a parameter", envelope: "Envelope" };
const FORMATS = { nc: "netCDF", png: "PNG", svg: "SVG" };
const KINDS = { nc: "application/x-netcdf", png: "image/png", svg: "image/svg+xml", toml: "application/toml" };
const FILM_SECONDS = 8;
const LOST = "The connection is lost; save again once it is back.";
const TAB = { time: "simulate", spectrum: "spectrum" };

export class Saver {
  /** @type {any} */ dialog; /** @type {any} */ page; /** @type {number | null} */ id; /** @type {number | null} */ codeId;

  constructor(dialog, page) {
    Object.assign(this, { dialog, page, id: null, codeId: null });
    this.what = make("select", { "aria-label": "What to save", onchange: () => this.ask() }, ...Object.entries(WHAT).map(([name, text]) => new Option(text, name)));
    this.command = make("pre", { tabIndex: 0 }); this.python = make("pre", { tabIndex: 0 });
    this.device = make("button", { type: "button", textContent: "Device file", "data-format": "toml", title: "The device with its current values, as a file for the command line", onclick: () => this.request("device", { setting: this.page.setting() }) });
    this.status = make("span", { role: "status" });
    this.buttons = Object.entries(FORMATS).map(([format, text]) => make("button", { type: "button", textContent: text, "data-format": format, onclick: () => this.get(format) }));
    this.picture = make("button", { type: "button", textContent: "Picture", title: "Cone and plots as they are on the page, with a caption", onclick: () => this.takePicture() });
    this.film = make("button", { type: "button", textContent: "Film", title: `The cone as it moves, with a caption: ${FILM_SECONDS} seconds as WebM`, onclick: () => this.takeFilm() });
    const copy = (from) => make("button", { type: "button", textContent: "Copy", onclick: async () => { try { await navigator.clipboard.writeText(from.textContent); this.status.textContent = "Copied."; } catch { this.status.textContent = "Select the text and copy it."; } } });
    dialog.append(
      make("h2", { textContent: "Save and repeat" }),
      make("div", { className: "row" }, this.what, ...this.buttons, this.device, this.status),
      make("div", { className: "row" }, make("span", { textContent: "The page as it looks, with a caption:" }), this.picture, this.film),
      make("h3", { textContent: "The same on the command line " }, copy(this.command)), this.command,
      make("h3", { textContent: "The same in Python " }, copy(this.python)), this.python,
      make("div", { className: "row" }, make("button", { type: "button", textContent: "Close", onclick: () => dialog.close() })),
    );
  }

  show() {
    const state = this.page.state();
    this.what.value = TAB[state.top] ?? "simulate";
    this.what.querySelector('[value="envelope"]').hidden = Boolean(this.page.setting().preset);
    this.device.disabled = Boolean(this.page.setting().preset);
    this.status.textContent = "";
    this.ask();
    this.dialog.showModal();
  }

  content() {
    const state = this.page.state(), what = this.what.value;
    const axes = what === "map" ? { x: state.x, y: state.y } : what === "bifurcation" ? { over: state.over } : {};
    return { setting: this.page.setting(), what, options: what === "simulate" ? { periods: Number(state.periods) } : {}, ...axes };
  }

  ask() { this.codeId = this.page.ask("code", this.content()); }

  get(format) {
    this.status.textContent = "computing …";
    for (const button of this.buttons) button.disabled = true;
    this.request("export", { ...this.content(), format });
  }

  request(kind, content) {
    this.id = this.page.ask(kind, content);
    if (this.id === null) this.done(LOST);
  }

  // Gives up the file that was asked for: after a lost connection it does not come.
  lost() { if (this.id !== null) this.done(LOST); }

  done(text) {
    this.id = null; this.status.textContent = text;
    for (const button of this.buttons) button.disabled = false;
  }

  message(head, { data }) {
    if (head.kind === "code") { this.command.textContent = head.command; this.python.textContent = head.python; return true; }
    if (head.kind !== "file") return false;
    this.give(head.name, new Blob([data], { type: KINDS[head.name.split(".").at(-1)] }));
    return true;
  }

  // Hands a file to the browser.
  give(name, data) {
    const url = URL.createObjectURL(data), link = make("a", { href: url, download: name });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
    this.done(`${name} is saved.`);
  }

  // The caption of the page.
  caption() { const { name, look, values } = this.page.shown(); return caption(name, look, values); }

  takePicture() {
    if (!this.page.shown().look?.words) return this.done("There is nothing to show yet.");
    composed(this.page.pictures(), this.caption()).canvas.toBlob((data) => (data ? this.give("gelcone.png", data) : this.done("The browser made no picture.")), "image/png");
  }

  async takeFilm() {
    if (!this.page.shown().look?.words) return this.done("There is nothing to show yet.");
    this.page.play();
    const film = filmed(composed(this.page.pictures().slice(0, 1), this.caption()), FILM_SECONDS, (passed) => { this.status.textContent = `recording, ${Math.min(Math.floor(passed), FILM_SECONDS)} of ${FILM_SECONDS} s …`; });
    if (!film) return this.done("This browser records no films.");
    this.film.disabled = true;
    try { this.give("gelcone.webm", await film); } catch (error) { this.done(error.message); }
    this.film.disabled = false;
  }

  failed(head) {
    if (head.id === null || (head.id !== this.id && head.id !== this.codeId)) return false;
    this.done(head.message);
    return true;
  }
}
