"""The README's picture: a pumping cone that ships with gelcone, in cross-section and in motion.

python docs/picture.py      (writes docs/cone.png)
"""

from __future__ import annotations

import io
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

import gelcone
from gelcone.plots.response import phase_portrait, time_response
from gelcone.plots.style import BLUE, GREY, VERMILION, styled

PATH = Path(__file__).with_name("cone.png")
NAME = "biased-pump"
PERIODS = 24


def cross_section(response: xr.Dataset, device: gelcone.Device, axes: Axes) -> None:
    """Disc and film at twelve instants of the last period, the highest and the lowest drawn out."""
    a, b = 1e3 * device.disc_radius, 1e3 * device.film_radius
    last = response.displacement.values[-101:]
    for h in last[:: len(last) // 12]:
        axes.plot([-b, -a, a, b], [0, h, h, 0], color=GREY, lw=0.5, alpha=0.6)
    for h, colour in ((last.min(), VERMILION), (last.max(), BLUE)):
        axes.plot([-b, -a, a, b], [0, h, h, 0], color=colour, lw=1.2)
        axes.plot([-a, a], [h, h], color=colour, lw=3.0, solid_capstyle="butt")
    for side in (-b, b):
        axes.plot([side, side], [-2.5, 2.5], color="black", lw=4.0, solid_capstyle="butt")
    axes.set_aspect("equal")
    axes.set_xlabel("radius (mm)")
    axes.set_ylabel("height (mm)")


def in_few_colours(figure: Figure) -> Image.Image:
    """The figure with a palette: a third of the bytes, and no difference to the eye."""
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=150)
    return Image.open(memory).convert("RGB").quantize(128, dither=Image.Dither.NONE)


def main() -> None:
    device = gelcone.find_device(NAME)
    response = gelcone.to_si(gelcone.simulate(device.to_model(), device.initial_state(), periods=PERIODS), device)

    def draw(figure: Figure) -> None:
        section, time, phase = figure.subplots(1, 3, width_ratios=[1.5, 1.9, 1.0])
        cross_section(response, device, section)
        time_response(response, time)
        phase_portrait(response, phase)

    in_few_colours(styled(9.0, 2.4, draw)).save(PATH, optimize=True)
    print(f"{PATH}: {PATH.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
