"""The voltages at which the membrane pulls in that a wrinkling cone stands for, computed once and stored."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import gelcone.membrane
from gelcone import disk_cache
from gelcone.errors import InputError
from gelcone.membrane.gel import Gel
from gelcone.membrane.pull_in import PullInCurve, pull_in_curve
from gelcone.physics.component import to_record
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS

if TYPE_CHECKING:
    from gelcone.physics.model import ConeModel

KIND = "pull-in"
DEFAULT_RADIUS_RATIO = 0.2


def membrane_pull_in(model: ConeModel, radius_ratio: float | None = None) -> PullInCurve | None:
    """The curve of one actuator; None where it does not apply: for another film than the wrinkling cone, or with a
    second one, and for a film that is in tension at no displacement. ``radius_ratio`` is a/b, default 0.2.

    Raises `InputError` for a ratio outside 0 to 1.
    """
    film, ratio = model.film, DEFAULT_RADIUS_RATIO if radius_ratio is None else float(radius_ratio)
    if not 0.0 < ratio < 1.0:
        raise InputError(f"radius_ratio = {ratio:g}: must lie between 0 and 1; the disc is smaller than its ring")
    if not isinstance(film, WrinklingCone) or film.pull_in != "first" or len(model.system.films) > 1 or model.shape:
        return None
    numbers, law = model.own_numbers, film.law.numbers(model.values)
    squares = float(numbers["A"]), float(numbers["B"])
    own = {name: float(value) for name, value in law.items()}

    def make() -> bytes:
        found = pull_in_curve(Gel(film.law, own, *squares), ratio)
        return json.dumps([found.displacements, found.voltages, found.error]).encode()

    parts = (to_record(film.law, LAWS), own, squares, ratio)
    try:
        stored = disk_cache.made(KIND, parts, make, (Path(gelcone.membrane.__file__).parent, type(film.law)))
    except InputError:
        return None
    x, voltages, error = json.loads(stored)
    return PullInCurve(tuple(x), tuple(voltages), float(error))
