// As much of a browser as the page's modules need: elements, canvases that record what is drawn, a socket.
import { readFileSync } from "node:fs";

export const STATIC = new URL("../../../src/gelcone/studio/static/", import.meta.url);
const CSS = readFileSync(new URL("studio.css", STATIC), "utf8");
export const LIGHT = variables(CSS.slice(0, CSS.indexOf("}")));
export const DARK = variables(CSS.slice(CSS.indexOf('[data-theme="dark"]'), CSS.indexOf("* {")));
export const SIZE = [640, 480]; // of everything, in pixels

function variables(css) { return Object.fromEntries([...css.matchAll(/--(\w+):\s*([^;]+);/g)].map(([, name, value]) => [name, value])); }

// A canvas context: each call with its arguments and the style in which it was made.
export function recorder() {
  const calls = [], style = { globalAlpha: 1, lineWidth: 1, fillStyle: "", strokeStyle: "", font: "" }, stack = [];
  let dash = [], shift = [0, 0];
  return new Proxy(calls, {
    get(target, name) {
      if (name === "calls") return calls;
      if (name in style) return style[name];
      return (...args) => {
        if (name === "save") stack.push([{ ...style }, dash, shift]);
        if (name === "restore") { const [own, ownDash, ownShift] = stack.pop(); Object.assign(style, own); dash = ownDash; shift = ownShift; }
        if (name === "setLineDash") [dash] = args;
        if (name === "translate") shift = [shift[0] + args[0], shift[1] + args[1]];
        calls.push({ name, args, ...style, dash, shift });
        if (name === "measureText") return { width: 6 * args[0].length };
        if (name === "createImageData") return { data: new Uint8ClampedArray(4 * args[0] * args[1]) };
      };
    },
    set(target, name, value) { style[name] = value; return true; },
  });
}

export const texts = (g) => g.calls.filter((c) => c.name === "fillText").map((c) => c.args[0]);
export const path = (g, colour) => g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === colour).map((c) => c.args);
// The rectangles [text, left, top, right, bottom] of level texts, with letters 6 px wide and 11 px high.
export function boxes(g) {
  return g.calls.filter((c) => c.name === "fillText" && (c.args[1] || c.args[2])).map(({ args: [text, x, y], shift, textAlign, textBaseline }) => {
    const wide = 6 * text.length, left = x + shift[0] - wide * ({ center: 0.5, right: 1 }[textAlign] ?? 0), top = y + shift[1] - 11 * ({ top: 0, middle: 0.5 }[textBaseline] ?? 1);
    return [text, left, top, left + wide, top + 11];
  });
}
// The pairs of these rectangles that lie over each other.
export const overlapping = (all) => all.flatMap((one, k) => all.slice(k + 1).filter((other) => one[1] < other[3] && other[1] < one[3] && one[2] < other[4] && other[2] < one[4]).map((other) => [one[0], other[0]]));
export const forget = (g) => { g.calls.length = 0; };

// --- elements --------------------------------------------------------------------------------------------------------

class Style {
  setProperty(name, value) { this[name] = value; }
}

class Element {
  constructor(tag) {
    Object.assign(this, { tagName: tag, children: [], attributes: {}, style: new Style(), dataset: {}, parent: null, hidden: false, own: "", listeners: {} });
    this.classList = {
      has: (name) => this.className.split(" ").includes(name),
      contains: (name) => this.classList.has(name),
      toggle: (name, on) => { const all = new Set(this.className.split(" ").filter(Boolean)); all[on ?? !all.has(name) ? "add" : "delete"](name); this.className = [...all].join(" "); return all.has(name); },
      add: (name) => this.classList.toggle(name, true),
      remove: (name) => this.classList.toggle(name, false),
    };
    this.className = "";
    [this.clientWidth, this.clientHeight] = SIZE;
  }

  get textContent() { return this.children.length ? this.children.map((c) => (typeof c === "string" ? c : c.textContent)).join("") : this.own; }
  set textContent(text) { this.children = []; this.own = String(text); }
  append(...parts) { for (const part of parts) { if (part?.parent) part.remove(); if (part instanceof Element) part.parent = this; this.children.push(part); } }
  replaceChildren(...parts) { for (const c of this.children) if (c instanceof Element) c.parent = null; this.children = []; this.own = ""; this.append(...parts); }
  remove() { if (this.parent) this.parent.children = this.parent.children.filter((c) => c !== this); this.parent = null; }
  setAttribute(name, value) {
    this.attributes[name] = String(value);
    if (name === "id") this.id = String(value);
    if (name === "class") this.className = String(value);
    if (name === "hidden") this.hidden = true;
    if (name.startsWith("data-")) this.dataset[name.slice(5)] = String(value);
    if (["value", "type", "min", "max", "title"].includes(name)) this[name] = String(value);
  }
  getAttribute(name) { return name === "id" ? this.id ?? null : this.attributes[name] ?? null; }
  removeAttribute(name) { delete this.attributes[name]; }
  get options() { return this.all().filter((e) => e.tagName === "option"); }
  get selectedOptions() { return this.options.filter((o) => o.value === this.value); }
  get value() { return this.chosen ?? (this.tagName === "select" ? this.options[0]?.value ?? "" : ""); }
  set value(value) { this.chosen = this.tagName === "select" && !this.options.some((o) => o.value === String(value)) ? "" : String(value); }
  get firstChild() { return this.children[0] ?? null; }
  get parts() { return this.children.filter((c) => c instanceof Element); }
  all() { return this.parts.flatMap((c) => [c, ...c.all()]); }
  matches(selector) {
    return selector.split(",").some((one) => {
      const steps = one.trim().split(/\s+/), own = steps.pop();
      const fits = (e, step) => [...step.matchAll(/\[([\w-]+)(?:="?([^\]"]*)"?)?\]|([#.]?)([\w-]+)/g)].every(([, attribute, value, kind, name]) => {
        if (attribute) return value === undefined ? e.getAttribute(attribute) !== null : e.getAttribute(attribute) === value;
        return kind === "#" ? e.id === name : kind === "." ? e.classList.has(name) : e.tagName === name;
      });
      if (!fits(this, own)) return false;
      let above = this.parent;
      while (steps.length && above) { if (fits(above, steps.at(-1))) steps.pop(); above = above.parent; }
      return !steps.length;
    });
  }
  querySelectorAll(selector) { return this.all().filter((e) => e.matches(selector)); }
  querySelector(selector) { return this.querySelectorAll(selector)[0] ?? null; }
  getContext() { return (this.context ??= recorder()); }
  getBoundingClientRect() { return { left: 10, top: 20, width: SIZE[0], height: SIZE[1] }; }
  addEventListener(name, does) { (this.listeners[name] ??= []).push(does); }
  setPointerCapture() {}
  focus() { document.activeElement = this; this.onfocus?.(); }
  click() { this.onclick?.({ target: this }); }
  showModal() { this.open = true; }
  close() { this.open = false; }
}

function parse(html, root) {
  const stack = [root], empty = ["meta", "link", "input", "img"];
  for (const [, comment, close, tag, attributes, text] of html.matchAll(/(<!.*?>)|<\/(\w+)>|<(\w+)((?:\s+[\w-]+(?:="[^"]*")?)*)\s*>|([^<]+)/g)) {
    if (comment) continue;
    if (close) { stack.pop(); continue; }
    if (text) { if (text.trim()) stack.at(-1).append(text.trim()); continue; }
    const element = new Element(tag);
    for (const [, name, value] of attributes.matchAll(/([\w-]+)(?:="([^"]*)")?/g)) element.setAttribute(name, value ?? "");
    stack.at(-1).append(element);
    if (!empty.includes(tag)) stack.push(element);
  }
}

export class Memory { setItem(name, value) { (this.own ??= {})[name] = value; } getItem(name) { return this.own?.[name] ?? null; } }

export class Socket {
  static OPEN = 1;
  static all = [];
  constructor(url) { Object.assign(this, { url, readyState: 0, sent: [] }); Socket.all.push(this); }
  send(text) { this.sent.push(JSON.parse(text)); }
  open() { this.readyState = 1; this.onopen(); }
  close() { this.readyState = 3; this.onclose(); }
  get last() { return this.sent.at(-1); }
  give(head, arrays = {}) { this.onmessage({ data: this.binaryType === "arraybuffer" ? frame(head, arrays) : new Blob([frame(head, arrays)]) }); } // as a browser does
}

// A frame as the server packs it.
export function frame(head, arrays) {
  const index = [], parts = [];
  let at = 0;
  for (const [name, values] of Object.entries(arrays)) {
    index.push([name, values instanceof Uint8Array ? "u1" : "f4", at, values.length]);
    parts.push([at, new Uint8Array(values.buffer, values.byteOffset, values.byteLength)]);
    at += 8 * Math.ceil(values.byteLength / 8);
  }
  let text = JSON.stringify({ ...head, arrays: index });
  text += " ".repeat((8 - ((4 + text.length) % 8)) % 8);
  const buffer = new ArrayBuffer(4 + text.length + at), bytes = new Uint8Array(buffer);
  new DataView(buffer).setUint32(0, text.length, true);
  bytes.set(new TextEncoder().encode(text), 4);
  for (const [from, part] of parts) bytes.set(part, 4 + text.length + from);
  return buffer;
}

export const page = { frames: [], observers: [], steps: [], copied: [], moment: 0, timers: [] };

// Puts a browser into the place of node's globals.
export function browser(hash = "", search = "?token=secret") {
  const root = new Element("html");
  const document = {
    documentElement: root, activeElement: null,
    createElement: (tag) => new Element(tag), createElementNS: (space, tag) => new Element(tag),
    getElementById: (id) => root.all().find((e) => e.id === id) ?? null,
    querySelector: (selector) => root.querySelector(selector), querySelectorAll: (selector) => root.querySelectorAll(selector),
    get body() { return root.querySelector("body"); },
  };
  parse(readFileSync(new URL("index.html", STATIC), "utf8").replace(/<!doctype html>/, "").replace(/<\/?html[^>]*>/g, ""), root);
  const put = (name, value) => Object.defineProperty(globalThis, name, { value, writable: true, configurable: true });
  put("document", document); put("window", globalThis); put("devicePixelRatio", 1);
  put("location", { host: "127.0.0.1:9", hash, search, href: `http://127.0.0.1:9/${search}${hash}` });
  put("history", {
    pushState: (a, b, text) => { page.steps.push(text); location.hash = text; },
    replaceState: (a, b, text) => { location.hash = text; },
  });
  put("localStorage", new Memory()); put("sessionStorage", new Memory());
  put("WebSocket", Socket);
  page.media = {};
  put("matchMedia", (query) => (page.media[query] ??= { matches: false }));
  put("getComputedStyle", () => ({ getPropertyValue: (name) => ({ ...LIGHT, ...(root.dataset.theme === "dark" ? DARK : {}) })[name.slice(2)] ?? "" }));
  put("ResizeObserver", class { constructor(does) { page.observers.push(does); } observe() {} });
  put("requestAnimationFrame", (does) => { page.frames.push(does); return page.frames.length; });
  put("addEventListener", (name, does) => { (page.listeners ??= {})[name] = does; });
  put("Option", class extends Element { constructor(text, value) { super("option"); this.textContent = text; this.setAttribute("value", value); } });
  put("navigator", { clipboard: { writeText: async (text) => { page.copied.push(text); } } });
  page.timers = []; page.frames = []; page.steps = []; Socket.all = [];
  put("setTimeout", (does, wait, ...args) => page.timers.push({ does: () => does(...args), wait }));
  put("clearTimeout", (number) => { if (number) page.timers[number - 1] = null; });
  return root;
}

// Runs what was put off: pictures, or timers of at most the given milliseconds.
export function draw(now = (page.moment += 100)) { for (const does of page.frames.splice(0)) does(now); }
export function wait(most) { for (const [k, timer] of [...page.timers.entries()]) if (timer && timer.wait <= most) { page.timers[k] = null; timer.does(); } }

// The strokes of an icon: the subpaths of its outline.
export const strokes = (button) => button.querySelector("path").getAttribute("d").split(/(?=M)/);

export const near = (one, other, within = 1e-6) => Math.abs(one - other) <= within * Math.max(1, Math.abs(other));
