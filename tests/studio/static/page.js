// As much of a browser as the page's modules need: elements, canvases that record what is drawn, a socket.
import { readFileSync } from "node:fs";

export const STATIC = new URL("../../../src/gelcone/studio/static/", import.meta.url);
const CSS = readFileSync(new URL("studio.css", STATIC), "utf8");
export const LIGHT = variables(CSS.slice(0, CSS.indexOf("}")));
export const DARK = variables(CSS.slice(CSS.indexOf('[data-theme="dark"]'), CSS.indexOf("* {")));
export const SIZE = [640, 480]; // of everything, in pixels

function variables(css) { return Object.fromEntries([...css.matchAll(/--(\w+):\s*([^;]+);/g)].map(([, name, value]) => [name, value])); }

// What a canvas takes; a browser ignores the rest without a word, or ends the script.
const COLOUR = /^(#[0-9a-f]{6}|rgba?\((\d+, ?){2}\d+(, ?[\d.]+)?\))$/, SHARE = (v) => v >= 0 && v <= 1, oneOf = (...names) => (v) => names.includes(v);
const STYLES = {
  fillStyle: (v) => COLOUR.test(v), strokeStyle: (v) => COLOUR.test(v), globalAlpha: SHARE, lineWidth: (v) => v > 0 && v < 20, font: (v) => /^([67]00 )?\d+px system-ui, /.test(v),
  textAlign: oneOf("left", "center", "right"), textBaseline: oneOf("top", "middle", "bottom"), lineCap: oneOf("butt", "round"), lineJoin: oneOf("round", "bevel"), imageSmoothingEnabled: oneOf(false),
};
const METHODS = {
  save: 0, restore: 0, beginPath: 0, closePath: 0, fill: 0, stroke: 0, clip: 0, moveTo: 2, lineTo: 2, translate: 2, rotate: 1, rect: 4, roundRect: 5, fillRect: 4, clearRect: 4, arc: 5, ellipse: 7,
  setTransform: 6, setLineDash: 1, measureText: 1, fillText: 3, drawImage: 3, createImageData: 2, putImageData: 3,
};
const GAPS = ["fillRect"]; // points without a value are left out

// Whether a text can be read: without the names that JavaScript has for what is missing.
const readable = (text) => !/undefined|NaN|null|Infinity|\[object|=>/.test(text);

function checked(name, args, style) {
  const wrong = `${name}(${args.map(String).join(", ")})`;
  if (!(args.length >= METHODS[name])) throw new TypeError(wrong);
  const numbers = args.flat().slice(["fillText", "measureText", "drawImage", "putImageData"].includes(name) ? 1 : 0);
  if (!GAPS.includes(name) && !numbers.every(Number.isFinite)) throw new Error(wrong);
  if (name === "fillText" && !(style.font && style.textAlign && style.textBaseline && style.fillStyle && typeof args[0] === "string" && readable(args[0]))) throw new Error(`${wrong} ${JSON.stringify(style)}`);
  if (/arc|ellipse/.test(name) && args[2] < 0) throw new RangeError(wrong);
}

// A canvas context: each call with its arguments and the style in which it was made.
export function recorder() {
  let begun = false; // whether a path may go on: after it was drawn only a new one
  const calls = [], style = { globalAlpha: 1, lineWidth: 1, fillStyle: "", strokeStyle: "", font: "" }, stack = [];
  let dash = [], shift = [0, 0];
  return new Proxy(calls, {
    get(target, name) {
      if (name === "calls") return calls;
      if (name in style) return style[name];
      if (!(name in METHODS)) return undefined;
      return (...args) => {
        checked(name, args, style);
        if (/^(moveTo|lineTo|arc|ellipse|rect|roundRect)$/.test(name) && !begun) throw new Error(`${name} adds to a path that was drawn`);
        begun = name === "beginPath" || (begun && !/^(fill|stroke|clip)$/.test(name));
        if (name === "save") stack.push([{ ...style }, dash, shift]);
        if (name === "restore") { const [own, ownDash, ownShift] = stack.pop(); Object.assign(style, own); dash = ownDash; shift = ownShift; }
        if (name === "setLineDash") [dash] = args;
        if (name === "setTransform") shift = [0, 0];
        if (name === "translate") shift = [shift[0] + args[0], shift[1] + args[1]];
        calls.push({ name, args, ...style, dash, shift });
        if (name === "measureText") return { width: 6 * args[0].length };
        if (name === "createImageData") return { data: new Uint8ClampedArray(4 * args[0] * args[1]) };
      };
    },
    set(target, name, value) {
      if (!STYLES[name]?.(value)) throw new Error(`${name} = ${value}`);
      style[name] = value;
      return true;
    },
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
// Each kind of line, area and text that is drawn, from back to front, with how it looks: once while the same is repeated.
export function drawn(g) {
  const found = [], share = (v) => (v === 1 ? "" : ` at ${Number(v.toFixed(3))}`);
  for (const c of g.calls) {
    const own = { stroke: () => `line ${c.strokeStyle} ${c.lineWidth}${c.dash.length ? ` dashed ${c.dash.join()}` : ""}${share(c.globalAlpha)}`, fill: () => `area ${c.fillStyle}${share(c.globalAlpha)}`, fillRect: () => `box ${c.fillStyle}${share(c.globalAlpha)}`, drawImage: () => `picture${share(c.globalAlpha)}`, fillText: () => `${c.args[0]} | ${c.fillStyle} ${c.font.match(/^.*px/)[0]} ${c.textAlign} ${c.textBaseline}${share(c.globalAlpha)}` }[c.name]?.();
    if (own && own !== found.at(-1)) found.push(own);
  }
  const named = Object.entries(LIGHT);
  const ticks = /^[-−\d.e+⁰¹²³⁴-⁹⁻]+ \| soft 11px (center top|right middle)$/;
  return found.map((one) => one.replace(/#[0-9a-f]{6}/g, (colour) => named.find(([, value]) => value === colour)?.[0] ?? colour)).filter((one) => !ticks.test(one));
}
export const forget = (g) => { g.calls.length = 0; };

// --- elements --------------------------------------------------------------------------------------------------------

class Style {
  setProperty(name, value) { this[name] = value; }
}

// Names that elements, their attributes and properties may have: of others a browser makes nothing.
const TAGS = "html head body meta title link script header h1 h2 h3 img label span select option optgroup button input div aside p main section canvas ul li i b output dialog pre svg path a".split(" ");
const ATTRIBUTES = "id class hidden style title role lang charset name content rel href src alt width height type accept multiple autocomplete spellcheck placeholder min max value selected for viewBox fill stroke stroke-width d".split(" ");
const ARIA = "controls describedby expanded hidden invalid label labelledby live pressed selected valuetext".split(" ").map((name) => `aria-${name}`);
const ROLES = "alert application group img status tab tablist tabpanel".split(" ");
const PROPERTIES = {
  "*": "className hidden id style tabIndex textContent title onclick onkeydown", a: "download href", button: "disabled type", canvas: "height width onpointerdown onpointermove onpointerup onpointercancel", label: "htmlFor", optgroup: "label", option: "value",
  input: "autocomplete disabled files max min onchange oninput placeholder spellcheck step type value", select: "disabled onchange value", link: "href type", script: "src type", meta: "name", output: "value",
};
const OWN = "tagName children attributes style dataset parent own listeners classList clientWidth clientHeight scrollWidth chosen context open captured captureStream toBlob".split(" "); // of this file and of tests
const known = (tag, name) => OWN.includes(name) || `${PROPERTIES["*"]} ${PROPERTIES[tag] ?? ""}`.split(" ").includes(name);
const valid = (name, value) => (name === "role" ? ROLES.includes(value) : /^aria-(pressed|expanded|selected|invalid|hidden)$/.test(name) ? /^(true|false)$/.test(value) : /^aria-/.test(name) ? ARIA.includes(name) && readable(value) : /^data-/.test(name) || ATTRIBUTES.includes(name));

class Element {
  constructor(tag) {
    if (!TAGS.includes(tag)) throw new Error(`<${tag}>`);
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
  set textContent(text) { if (!readable(String(text))) throw new Error(`<${this.tagName}> ${text}`); this.children = []; this.own = String(text); }
  append(...parts) { for (const part of parts) { if (part?.parent) part.remove(); if (part instanceof Element) part.parent = this; this.children.push(part); } }
  replaceChildren(...parts) { for (const c of this.children) if (c instanceof Element) c.parent = null; this.children = []; this.own = ""; this.append(...parts); }
  remove() { if (this.parent) this.parent.children = this.parent.children.filter((c) => c !== this); this.parent = null; }
  setAttribute(name, value) {
    if (!valid(name, String(value))) throw new Error(`<${this.tagName} ${name}="${value}">`);
    this.attributes[name] = String(value);
    if (name === "id") this.id = String(value);
    if (name === "class") this.className = String(value);
    if (name === "hidden") this.hidden = true;
    if (name.startsWith("data-")) this.dataset[name.slice(5)] = String(value);
    if (["value", "type", "min", "max", "title"].includes(name)) this[name] = String(value);
  }
  getAttribute(name) {
    const own = { id: this.id, type: this.type, title: this.title, tabindex: this.tabIndex, hidden: this.hidden ? "" : undefined }[name];
    return own ?? (name.startsWith("data-") ? this.dataset[name.slice(5)] : this.attributes[name]) ?? null;
  }
  removeAttribute(name) { delete this.attributes[name]; }
  get options() { return this.all().filter((e) => e.tagName === "option"); }
  get selectedOptions() { return this.options.filter((o) => o.value === this.value); }
  get value() { return this.chosen ?? (this.tagName === "select" ? this.options[0]?.value ?? "" : ""); }
  set value(value) { this.chosen = this.tagName === "select" && !this.options.some((o) => o.value === String(value)) ? "" : String(value); }
  get firstChild() { return this.children[0] ?? null; }
  get parts() { return this.children.filter((c) => c instanceof Element); }
  all() { return this.parts.flatMap((c) => [c, ...c.all()]); }
  // Whether a selector of the style sheet or of a module fits; what a hand does (:hover, :focus) fits always.
  matches(selector) {
    return selector.split(/,(?![^(]*\))/).some((one) => {
      const steps = one.trim().replace(/::[\w-]+|:(hover|focus(-visible)?)\b/g, "").split(/\s+(?=[^>\s])(?<!>\s)/);
      const fits = (e, own) => [...own.matchAll(/:not\(([^)]*)\)|\[([\w-]+)(?:="?([^\]"]*)"?)?\]|:([\w-]+)|([#.]?)([\w-]+)/g)].every(([, not, attribute, value, state, kind, name]) => {
        if (not) return !fits(e, not);
        if (attribute) return value === undefined ? e.getAttribute(attribute) !== null : e.getAttribute(attribute) === value;
        if (state) return { disabled: e.disabled, empty: !e.textContent, root: !e.parent, "first-child": e.parent?.parts[0] === e, "last-child": e.parent?.parts.at(-1) === e }[state];
        return kind === "#" ? e.id === name : kind === "." ? e.classList.has(name) : e.tagName === name;
      });
      const chain = (e, own) => { // parts of a step that are joined by >
        const [last, ...above] = own.split(/\s*>\s*/).reverse();
        return fits(e, last) && (!above.length || (Boolean(e.parent) && chain(e.parent, above.reverse().join(" > ")))) ;
      };
      if (!chain(this, steps.pop())) return false;
      let above = this.parent;
      while (steps.length && above) { if (chain(above, steps.at(-1))) steps.pop(); above = above.parent; }
      return !steps.length;
    });
  }
  querySelectorAll(selector) { return this.all().filter((e) => e.matches(selector)); }
  querySelector(selector) { return this.querySelectorAll(selector)[0] ?? null; }
  getContext(kind = "2d") { return kind === "2d" ? (this.context ??= recorder()) : null; }
  getBoundingClientRect() { return { left: 10, top: 20, width: SIZE[0], height: SIZE[1] }; }
  addEventListener(name, does) { (this.listeners[name] ??= []).push(does); }
  setPointerCapture(number) { this.captured = number; }
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

export const page = { frames: [], observers: [], steps: [], entries: [], copied: [], moment: 0, timers: [] };

// Goes back by a step of the history.
page.back = () => { page.entries.pop(); location.hash = page.entries.at(-1) ?? ""; page.listeners.popstate(); };

// Puts a browser into the place of node's globals.
export function browser(hash = "", search = "?token=secret") {
  const root = new Element("html");
  const document = {
    documentElement: root, activeElement: null,
    createElement: (tag) => new Element(tag), createElementNS: (space, tag) => { if (space !== "http://www.w3.org/2000/svg") throw new Error(space); return new Element(tag); },
    getElementById: (id) => root.all().find((e) => e.id === id) ?? null,
    querySelector: (selector) => root.querySelector(selector), querySelectorAll: (selector) => root.querySelectorAll(selector),
    get body() { return root.querySelector("body"); },
  };
  parse(readFileSync(new URL("index.html", STATIC), "utf8").replace(/<!doctype html>/, "").replace(/<\/?html[^>]*>/g, ""), root);
  const put = (name, value) => Object.defineProperty(globalThis, name, { value, writable: true, configurable: true });
  put("document", document); put("window", globalThis); put("devicePixelRatio", 1);
  put("location", { host: "127.0.0.1:9", hash, search, href: `http://127.0.0.1:9/${search}${hash}` });
  put("history", {
    pushState: (a, b, text) => { page.steps.push(text); page.entries.push(text); location.hash = text; },
    replaceState: (a, b, text) => { page.entries[page.entries.length - 1] = text; location.hash = text; },
  });
  put("localStorage", new Memory()); put("sessionStorage", new Memory());
  put("WebSocket", Socket);
  page.media = {};
  put("matchMedia", (query) => (page.media[query] ??= { matches: false }));
  put("getComputedStyle", () => ({ getPropertyValue: (name) => ` ${({ ...LIGHT, ...(root.dataset.theme === "dark" ? DARK : {}) })[name.slice(2)] ?? ""}` })); // with its space, as in older browsers
  put("ResizeObserver", class { constructor(does) { page.observers.push(does); } observe() {} });
  put("requestAnimationFrame", (does) => { page.frames.push(does); return page.frames.length; });
  put("addEventListener", (name, does) => { (page.listeners ??= {})[name] = does; });
  put("Option", class extends Element { constructor(text, value) { super("option"); this.textContent = text; this.setAttribute("value", value); } });
  put("navigator", { clipboard: { writeText: async (text) => { page.copied.push(text); } } });
  page.timers = []; page.frames = []; page.steps = []; page.entries = [hash]; Socket.all = [];
  put("setTimeout", (does, wait, ...args) => page.timers.push({ does: () => does(...args), wait }));
  put("clearTimeout", (number) => { if (number) page.timers[number - 1] = null; });
  return root;
}

// The selectors of the style sheet, and what is wrong about the elements of the page: names that mean nothing, texts that
// are not read, names that are missing, references that lead nowhere, and classes without a style.
export const SELECTORS = [...new Set([...CSS.replace(/\/\*.*?\*\/|@media[^{]*\{/g, "").matchAll(/([^{}]+)\{[^}]*\}/g)].flatMap(([, list]) => list.split(/,(?![^(]*\))/)).map((one) => one.trim()))];
const SCRIPTED = ["plot", "valid"];
const STYLED = new Set(SELECTORS.flatMap((one) => [...one.matchAll(/\.([\w-]+)/g)].map(([, name]) => name)));
export const everything = () => [document.documentElement, ...document.documentElement.all()];
export function faults() {
  const all = everything(), ids = all.map((e) => e.id).filter(Boolean), found = [];
  const wrong = (e, what) => found.push(`<${e.tagName}${e.id ? ` id="${e.id}"` : ""} class="${e.className}">: ${what}`);
  for (const e of all) {
    const label = all.find((own) => own.tagName === "label" && (own.htmlFor === e.id && e.id || own.all().includes(e)));
    for (const name of Object.keys(e)) if (!known(e.tagName, name)) wrong(e, `property ${name}`);
    for (const name of e.className.split(" ").filter(Boolean)) if (!STYLED.has(name) && !SCRIPTED.includes(name)) wrong(e, `class ${name}`);
    for (const text of [e.title, e.own]) if (text && !readable(text)) wrong(e, text);
    for (const id of [e.htmlFor, ...["controls", "describedby", "labelledby"].map((name) => e.getAttribute(`aria-${name}`))]) if (id && ids.filter((own) => own === id).length !== 1) wrong(e, `refers to ${id}`);
    if (["canvas", "div", "span"].includes(e.tagName) && e.getAttribute("aria-label") && !e.getAttribute("role")) wrong(e, "has a name that is not read, for want of a role");
    if (e.tagName === "button" && e.type !== "button") wrong(e, `type ${e.type}`);
    if (e.tagName === "input" && !["text", "range", "file"].includes(e.type)) wrong(e, `type ${e.type}`);
    if (["button", "select", "input"].includes(e.tagName) || ["img", "application", "tab", "tablist", "group"].includes(e.getAttribute("role"))) if (![e.getAttribute("aria-label"), e.textContent.trim(), e.title, label?.textContent.trim()].some(Boolean)) wrong(e, "has no name");
  }
  return found;
}

// What a part of the page is made of, as it is read: tags with classes, names, states, titles, values; what is hidden is crossed out.
export function made(e) {
  if (typeof e === "string") return `"${e}"`;
  const classes = e.className.split(" ").filter(Boolean).sort().map((name) => `.${name}`).join(""), kind = e.type && e.tagName === "input" ? `:${e.type}` : "";
  const states = ["pressed", "expanded", "selected", "invalid", "valuetext"].flatMap((name) => e.getAttribute(`aria-${name}`) ? [`${name}=${e.getAttribute(`aria-${name}`)}`] : []);
  const words = [e.getAttribute("aria-label") && `‹${e.getAttribute("aria-label")}›`, e.own && `"${e.own}"`, e.title && `(${e.title})`, e.chosen !== undefined && `=${e.value}`, e.disabled && "disabled", e.getAttribute("role") && `role=${e.getAttribute("role")}`, ...states].filter(Boolean);
  const parts = e.tagName === "svg" ? [] : e.children.map(made);
  return `${e.hidden ? "-" : ""}${e.tagName}${kind}${classes}${words.length ? ` ${words.join(" ")}` : ""}${parts.length ? ` [${parts.join(", ")}]` : ""}`;
}

// Runs what was put off: pictures, or timers of at most the given milliseconds.
export function draw(now = (page.moment += 100)) { for (const does of page.frames.splice(0)) does(now); }
export function wait(most) { for (const [k, timer] of [...page.timers.entries()]) if (timer && timer.wait <= most) { page.timers[k] = null; timer.does(); } }

// The strokes of an icon: the subpaths of its outline.
export const strokes = (button) => button.querySelector("path").getAttribute("d").split(/(?=M)/);

export const near = (one, other, within = 1e-6) => Math.abs(one - other) <= within * Math.max(1, Math.abs(other));
