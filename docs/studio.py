"""The README's first picture: the studio while its voltage is turned up, filmed in Chromium.

python docs/studio.py       (writes docs/studio.webp)
"""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from browser import Browser, Tab

PATH = Path(__file__).with_name("studio.webp")
SIZE = (1200, 750)
SHOWN = (960, 600)
STATE = "device=biased-pump&periods=5&view=stroke"
FRAMES, TURNED = 60, (12, 44)
"""Frames in all, and those between which the voltage is turned up."""
VOLTS = (340.0, 960.0)
MILLISECONDS = 80
QUALITY = 58
MOVE = """
([volts, place]) => new Promise((done) => {
  const slider = document.querySelector('[data-name="voltage_amplitude"] input[type=range]');
  const scrub = document.getElementById("scrub");
  const before = studio.looks.a.id, step = String(Math.round(volts / 2));
  const moved = slider.value !== step;
  if (moved) { slider.value = step; slider.dispatchEvent(new Event("input", { bubbles: true })); }
  const look = () => {
    if (moved && !(studio.looks.a.id > before && studio.looks.a.lines)) return setTimeout(look, 20);
    scrub.value = place; scrub.dispatchEvent(new Event("input", { bubbles: true }));
    requestAnimationFrame(() => requestAnimationFrame(done));
  };
  look();
})"""


def film(tab: Tab) -> list[Image.Image]:
    """The frames: the cone goes through its run while the voltage goes up."""
    frames = []
    for number in range(FRAMES):
        share = min(max((number - TURNED[0]) / (TURNED[1] - TURNED[0]), 0.0), 1.0)
        volts = VOLTS[0] + (VOLTS[1] - VOLTS[0]) * share
        tab.js(f"({MOVE})([{volts}, {1000 * number / FRAMES}])")
        picture = Image.open(io.BytesIO(tab.picture())).convert("RGB")
        frames.append(picture.resize(SHOWN, Image.Resampling.LANCZOS))
    return frames


def main() -> None:
    command = [sys.executable, "-m", "gelcone", "studio", "--no-browser", "biased-pump"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as studio, Browser(*SIZE) as browser:
        try:
            assert studio.stdout is not None
            address = studio.stdout.readline().partition(": ")[2].partition("#")[0]
            tab = browser.page
            tab.go(f"{address}#{STATE}&voltage_amplitude={VOLTS[0]:g}+V")
            tab.wait("window.studio && studio.looks.a && studio.looks.a.lines && true", 120)
            tab.js("document.getElementById('play').click()")
            tab.wait(
                "document.querySelector('#map .legend li') && !document.getElementById('grid-share').textContent", 500
            )
            frames = film(tab)
        finally:
            studio.terminate()
    options = {"duration": MILLISECONDS, "loop": 0, "quality": QUALITY, "method": 4, "minimize_size": True}
    frames[0].save(PATH, save_all=True, append_images=frames[1:], **options)
    print(f"{PATH}: {PATH.stat().st_size / 1e3:.0f} kB, {len(frames)} frames")


if __name__ == "__main__":
    main()
