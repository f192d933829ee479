// The page's colours, read from the style sheet once per theme.
const NAMES = ["bg", "panel", "ink", "soft", "line", "field", "edge", "a", "b", "accent", "taut", "around", "meridian", "both", "breakdown", "limit", "beyond", "steel"];
/** @type {any} Colours by name, those of the film's states in ``film``, and whether it is ``dark``. */
let palette = null;

export function colours() {
  if (!palette) {
    const style = getComputedStyle(document.documentElement);
    palette = /** @type {any} */ (Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()])));
    palette.film = [palette.taut, palette.around, palette.meridian, palette.both, palette.breakdown, palette.limit, palette.beyond];
    palette.dark = document.documentElement.dataset.theme === "dark";
  }
  return palette;
}

export function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  palette = null;
}

/** @param {string} hex @returns {number[]} */
export function rgb(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

// The text colour, black or white, that reads better on a colour.
/** @param {string} hex @returns {string} */
export function onto(hex) {
  const [r, g, b] = rgb(hex);
  return 0.299 * r + 0.587 * g + 0.114 * b > 150 ? "#10151b" : "#ffffff";
}

// A mixture of two colours, as a CSS colour.
/** @param {string} one @param {string} other @param {number} share of the other @returns {string} */
export function mix(one, other, share) {
  const p = rgb(one), q = rgb(other);
  return `rgb(${p.map((v, i) => Math.round(v + (q[i] - v) * share)).join(",")})`;
}
