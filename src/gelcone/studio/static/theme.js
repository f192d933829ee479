// The theme: the one that was chosen, else that of the system.
import { setTheme } from "./colours.js";
import { icon } from "./controls.js";

const KEY = "gelcone-theme";
const SUN = "M8 6a3 3 0 1 0 .01 0M8 1v2M8 15v2M1 9h2M13 9h2M3 4l1.5 1.5M11.5 12.5L13 14M3 14l1.5-1.5M11.5 5.5L13 4", MOON = "M13 11A6 6 0 1 1 7 3a5 5 0 0 0 6 8z";

// Shows the theme; a click on the button takes the other one. changed(): the page is to be drawn anew.
export function themed(button, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  try { chosen = localStorage.getItem(KEY); } catch { /* a frame without storage */ }
  const name = () => chosen ?? (system.matches ? "dark" : "light"), other = () => (name() === "dark" ? "light" : "dark");
  const show = () => {
    setTheme(name());
    button.replaceChildren(icon(name() === "dark" ? SUN : MOON, 16));
    button.title = name() === "dark" ? "Light" : "Dark";
  };
  show();
  system.onchange = () => { if (!chosen) { show(); changed(); } };
  button.onclick = () => {
    chosen = other();
    try { localStorage.setItem(KEY, chosen); } catch { /* a frame without storage */ }
    show(); changed();
  };
}
