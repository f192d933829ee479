// Files of what is shown, and the command and Python lines that give the same numbers.
import { make } from "./controls.js";

const WHAT = { simulate: "Time response", section: "Phase portrait: section", spectrum: "Spectrum", regime: "Kind of motion, with its evidence", static: "Statics", map: "Map", bifurcation: "Sweep of a parameter", envelope: "Envelope" };
const FORMATS = { nc: "netCDF", png: "PNG", svg: "SVG" };
const KINDS = { nc: "application/x-netcdf", png: "image/png", svg: "image/svg+xml", toml: "application/toml" };
const TAB = { time: "simulate", spectrum: "spectrum" };

export class Saver {
  constructor(dialog, page) {
    Object.assign(this, { dialog, page, id: null, codeId: null });
    this.what = make("select", { "aria-label": "What to save", onchange: () => this.ask() }, ...Object.entries(WHAT).map(([name, text]) => new Option(text, name)));
    this.command = make("pre", { tabIndex: 0 }); this.python = make("pre", { tabIndex: 0 });
    this.device = make("button", { type: "button", textContent: "Device file", "data-format": "toml", title: "The device as it is set, as a file for the command line", onclick: () => { this.id = this.page.ask("device", { setting: this.page.setting() }); } });
    this.said = make("span", { role: "status" });
    this.buttons = Object.entries(FORMATS).map(([format, text]) => make("button", { type: "button", textContent: text, "data-format": format, onclick: () => this.get(format) }));
    const copy = (from) => make("button", { type: "button", textContent: "Copy", onclick: async () => { try { await navigator.clipboard.writeText(from.textContent); this.said.textContent = "Copied."; } catch { this.said.textContent = "Select the text and copy it."; } } });
    dialog.append(
      make("h2", { textContent: "Save and repeat" }),
      make("div", { className: "row" }, this.what, ...this.buttons, this.device, this.said),
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
    this.said.textContent = "";
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
    this.id = this.page.ask("export", { ...this.content(), format });
    this.said.textContent = "computing …";
    for (const button of this.buttons) button.disabled = true;
  }

  done(text) {
    this.id = null; this.said.textContent = text;
    for (const button of this.buttons) button.disabled = false;
  }

  message(head, { data }) {
    if (head.kind === "code") { this.command.textContent = head.command; this.python.textContent = head.python; return true; }
    if (head.kind !== "file") return false;
    const url = URL.createObjectURL(new Blob([data], { type: KINDS[head.name.split(".").at(-1)] }));
    const link = make("a", { href: url, download: head.name });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
    this.done(`${head.name} is saved.`);
    return true;
  }

  failed(head) {
    if (head.id !== this.id && head.id !== this.codeId) return false;
    this.done(head.message);
    return true;
  }
}
