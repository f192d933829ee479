"""Pictures of docs/wrinkling.md: the states of the film on the cone, and where they lie over height and voltage.

python docs/wrinkling.py      (writes docs/wrinkling-states.png and docs/wrinkling-plane.png)
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from PIL import Image

from gelcone import ConeModel
from gelcone.physics.film.wrinkling import STATES, WrinklingCone
from gelcone.plots.style import styled

FOLDER = Path(__file__).parent
COLOURS = ("#bfd7ea", "#f2c57c", "#9bc59d", "#d98880", "#444444")
"""Of the four states, and of a film that has pulled in."""
WAVES, RINGS, DEPTH = 28, 9, 0.055


def surface(state: str) -> tuple[np.ndarray, ...]:
    """A raised cone with the wrinkles of a state; their number and depth are for show."""
    radius, angle = np.meshgrid(np.linspace(0.2, 1.0, 90), np.linspace(0.0, 2.0 * np.pi, 360), indexing="ij")
    height = 0.55 * (1.0 - radius) / 0.8
    share = (radius - 0.2) / 0.8
    held = np.sin(np.pi * share)  # flat at disc and clamp
    if state in ("hoop_slack", "crumpled"):
        height = height + DEPTH * held * np.cos(WAVES * angle)
    if state in ("meridional_slack", "crumpled"):
        height = height + DEPTH * held * np.cos(2.0 * np.pi * RINGS * share)
    if state == "crumpled":
        height = height - 0.22 * held
    return radius * np.cos(angle), radius * np.sin(angle), height


def draw_states(figure: Figure) -> None:
    for k, (state, colour) in enumerate(zip(STATES, COLOURS, strict=False)):
        axes = figure.add_subplot(1, 4, k + 1, projection="3d")
        axes.plot_surface(*surface(state), color=colour, rcount=90, ccount=180, linewidth=0.0, antialiased=False)
        turn = np.linspace(0.0, 2.0 * np.pi, 60)
        disc = (0.2 * np.cos(turn), 0.2 * np.sin(turn), np.full(60, 0.55))
        axes.plot(*disc, color="black", lw=1.2, zorder=10)
        front = np.radians(np.linspace(-150.0, 30.0, 60))
        axes.plot(np.cos(front), np.sin(front), 0.0 * front, color="black", lw=1.2)
        axes.set_box_aspect((1.0, 1.0, 0.42), zoom=1.5)
        axes.view_init(28, -60)
        axes.set_axis_off()
        axes.set_title(state.replace("_", " "), y=-0.12, fontsize=9)


def state_of(film: WrinklingCone, x: np.ndarray, v: np.ndarray, **parameters: float) -> np.ndarray:
    """The place of the state in `STATES` at each height and voltage; 4 where the film has pulled in."""
    n = film.numbers(film.complete(parameters))
    return np.where(v * v >= film.highest_squared(x, n), len(STATES), film.kind(x, v * v, n))


def draw_plane(figure: Figure) -> None:
    film = ConeModel(film="wrinkling").film
    x, v = np.meshgrid(np.linspace(0.0, 1.6, 321), np.linspace(0.0, 1.6, 321))
    cases = {"pre-stretch 1": {}, "hoop 1.5": {"hoop_prestretch": 1.5}, "both 1.5": {"prestretch": 1.5}}
    both = WrinklingCone(prestretch_mode="equibiaxial")
    for axes, (title, parameters) in zip(figure.subplots(1, 3, sharey=True), cases.items(), strict=True):
        found = state_of(both if title.startswith("both") else film, x, v, **parameters)
        axes.pcolormesh(x, v, found, cmap=ListedColormap(COLOURS), vmin=0, vmax=4, rasterized=True)
        axes.set_title(title)
        axes.set_xlabel("displacement")
    figure.axes[0].set_ylabel("voltage on the film")
    for colour, state in zip(COLOURS, (*STATES, "pulled_in"), strict=True):
        figure.axes[-1].plot([], [], "s", color=colour, label=state.replace("_", " "))
    figure.axes[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def save(figure: Figure, path: Path) -> None:
    """With a palette: a third of the bytes, and no difference to the eye."""
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=120)
    Image.open(memory).convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    save(styled(9.0, 2.4, draw_states), FOLDER / "wrinkling-states.png")
    save(styled(9.0, 2.8, draw_plane), FOLDER / "wrinkling-plane.png")


if __name__ == "__main__":
    main()
