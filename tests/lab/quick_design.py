"""A small real design: springs and drives for the film of `biased-pump`, few draws and generations."""

import functools
from unittest.mock import patch

import gelcone
from gelcone.lab import design as designs
from gelcone.lab import front as fronts
from gelcone.lab.wish import FIRST_WISH

PUMP = {
    "disc_radius": "8 mm",
    "film_thickness": "0.2 mm",
    "meridional_prestretch": 1.1,
    "hoop_prestretch": 1.4,
}
FEW = {"DRAWS": 32, "GENERATIONS": 25, "AGAIN": 8, "SHORT": 2, "NEW_DRAWS": 1024}


def quick_wish() -> str:
    """A wish in which only spring and drive are free."""
    lines = FIRST_WISH.format(file="wish.toml").replace(">= 5 mm", ">= 2 mm").splitlines()
    head, free = lines[: lines.index("[free]")], lines[lines.index("[free]") :]
    fixed = [f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value}" for name, value in PUMP.items()]
    bounds = [line for line in free if line.partition(" ")[0] not in PUMP or "%" in line]
    return "\n".join([*head, *fixed, *bounds]).replace(', "peak_voltage"]', "]")


@functools.cache
def quick_design(folder):
    """The wish as read from a folder, and its design."""
    path = folder / "quick.toml"
    path.write_text(quick_wish(), encoding="utf-8")
    own = gelcone.read_wish(path)
    with patch.multiple(fronts, **FEW), patch.multiple(designs, AGAIN=8, TRAP=25, ATTEMPTS=2):
        return own, gelcone.design(own)
