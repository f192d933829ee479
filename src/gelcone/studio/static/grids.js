// The panels over parameters: map, sweep and envelope.
import { say } from "./controls.js";
import { EnvelopePanel } from "./envelope.js";
import { MapPanel } from "./map.js";
import { StripPanel } from "./sweep.js";

export class GridPanels {
  constructor({ hosts, share, page }) {
    this.page = page; this.share = share;
    this.panels = { map: new MapPanel(hosts.map, this), strip: new StripPanel(hosts.strip, this), envelope: new EnvelopePanel(hosts.envelope, this) };
  }

  get open() { return this.panels[this.page.state()?.right]; }

  // The server has sent the controls: only now are the parameters to sweep known.
  controlsChanged() { for (const panel of Object.values(this.panels)) panel.prepare(); this.opened(); }

  // The active setting was changed.
  changed() { for (const panel of Object.values(this.panels)) { panel.redrawOver(); panel.changed(); } }

  opened() {
    const panel = this.open;
    for (const other of Object.values(this.panels)) if (other !== panel) other.pause();
    if (!panel?.running) this.say("");
    if (panel && this.page.controls().list.length) panel.show();
  }

  moved() { for (const panel of Object.values(this.panels)) panel.redrawOver(); }
  redraw() { for (const panel of Object.values(this.panels)) panel.plot.redraw(); }
  lost() { for (const panel of Object.values(this.panels)) { panel.running = false; panel.stale = true; } }
  say(text) { say(this.share, text); }

  message(head, arrays) {
    const panel = Object.values(this.panels).find((p) => p.id !== null && p.id === head.id);
    if (!panel) return ["grid", "cells", "done", "thresholds", "loci", "followed", "branches", "progress", "envelope"].includes(head.kind);
    panel[`on_${head.kind}`]?.(head, arrays);
    return true;
  }

  failed(head) {
    const panel = Object.values(this.panels).find((p) => p.id !== null && p.id === head.id);
    if (!panel) return false;
    panel.running = false; panel.problem = head.message; panel.id = null;
    panel.plot.redraw();
    this.say("");
    return true;
  }
}
