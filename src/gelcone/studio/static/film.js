// Pictures and films of the page, with a caption.
import { colours } from "./colours.js";
import { typeset } from "./controls.js";
import { broken } from "./plot.js";

const LINE = 20, EDGE = 16, FONT = "14px system-ui, 'Segoe UI', Roboto, sans-serif";
const RATE = 25; // pictures a second
const TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

// The lines of a caption: name, kind of motion, numbers, and the changed values.
export function caption(name, look, values) {
  const kind = look.words.ended || (look.lines ? look.lines[0] : look.words.seems);
  const numbers = [...(look.numbers?.values() ?? [])].sort((p, q) => p.place - q.place).map((own) => `${own.name} ${own.text}`);
  const changed = Object.entries(values).map(([parameter, text]) => `${parameter.replaceAll("_", " ")} ${text}`);
  return [`${name}: ${kind}`, numbers.join(", "), changed.length ? `with ${changed.join(", ")}` : "", "gelcone studio"].filter(Boolean).map(typeset);
}

// A layout of pictures of these sizes, two per row: their places, and the size of the whole.
/** @param {number[][]} sizes widths and heights @returns {{places: number[][], size: number[]}} */
export function arranged(sizes) {
  const places = [];
  let y = 0, wide = 0;
  for (let k = 0; k < sizes.length; k += 2) {
    const row = sizes.slice(k, k + 2);
    let x = 0;
    for (const [w] of row) { places.push([x, y]); x += w + EDGE; }
    wide = Math.max(wide, x - EDGE);
    y += Math.max(...row.map(([, h]) => h)) + EDGE;
  }
  return { places, size: [wide, y] };
}

// A canvas with pictures above a caption, and a function that redraws it.
export function composed(pictures, lines) {
  const canvas = document.createElement("canvas"), g = canvas.getContext("2d", { alpha: false }), d = devicePixelRatio;
  const { places, size: [wide, tall] } = arranged(pictures.map((own) => [own.width / d, own.height / d]));
  g.font = FONT;
  const text = lines.flatMap((line) => broken(g, line, wide));
  canvas.width = Math.ceil((wide + 2 * EDGE) * d); canvas.height = Math.ceil((tall + EDGE + LINE * text.length + EDGE) * d);
  const draw = () => {
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.fillStyle = colours().panel; g.fillRect(0, 0, canvas.width, canvas.height);
    pictures.forEach((own, k) => g.drawImage(own, (places[k][0] + EDGE) * d, (places[k][1] + EDGE) * d));
    g.setTransform(d, 0, 0, d, 0, 0);
    g.font = FONT; g.fillStyle = colours().ink; g.textAlign = "left"; g.textBaseline = "top";
    text.forEach((line, k) => g.fillText(line, EDGE, tall + EDGE + LINE * k));
  };
  draw();
  return { canvas, draw };
}

// The data of a film of some seconds; null if the browser cannot record one.
export function filmed({ canvas, draw }, seconds, report) {
  const type = globalThis.MediaRecorder && canvas.captureStream && TYPES.find((own) => MediaRecorder.isTypeSupported(own));
  if (!type) return null;
  return new Promise((done, fail) => {
    const recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: type, videoBitsPerSecond: 4e6 }), parts = [], began = performance.now();
    const timer = setInterval(() => {
      draw();
      const passed = (performance.now() - began) / 1000;
      report(passed);
      if (passed >= seconds && recorder.state === "recording") recorder.stop();
    }, 1000 / RATE);
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => { clearInterval(timer); done(new Blob(parts, { type: "video/webm" })); };
    recorder.onerror = () => { clearInterval(timer); fail(new Error("the browser could not record the film")); };
    recorder.start();
  });
}
