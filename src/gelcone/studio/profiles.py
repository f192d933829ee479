"""Profiles of a membrane over height and voltage: a small table from which the page interpolates each picture."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.profile import held, profile
from gelcone.physics.component import to_record
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import PlacedFilm
from gelcone.studio.look import Parts, scales

HEIGHTS, RINGS = 12, 13
"""Heights, and rings from disc to rim, in a table."""
SHARES = (0.0, 0.35, 0.65, 0.85, 0.95, 0.99)
"""Squared voltages in a table, over the one at which the film falls slack or localises."""
CURVED = 1.6
"""Exponent of the spacing of heights, which are densest near the flat film."""
MOST = 64
"""Tables held in memory."""


def names(model: ConeModel) -> list[str]:
    """The name of each film's table, equal for films of equal profiles; empty for films that are not membranes, and for
    a second film with a voltage of its own."""
    return [_name(model, placed) if _drawn(placed) else "" for placed in model.system.films]


def _drawn(placed: PlacedFilm) -> bool:
    return isinstance(placed.film, MembraneFilm) and placed.drive in (None, "same")


def _name(model: ConeModel, placed: PlacedFilm) -> str:
    film = placed.film
    assert isinstance(film, MembraneFilm)
    numbers = {name: np.ravel(value)[0] for name, value in placed.own(model.values).items()}
    parts = (to_record(film.law, LAWS), film.stretches(numbers), film.law.numbers(numbers), numbers["radius_ratio"])
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def table(subject: Subject, film: int) -> Parts:
    """The profiles of one film of a single actuator, in the units of the page.

    ``height`` (heights,); ``top`` (heights,), the voltage at which the film falls slack or localises; and, flattened
    from (heights, shares of the squared top voltage, rings from disc to rim), ``radius``, ``rise`` (height over the
    disc's), ``stretch`` (area over the mounted one) and ``wrinkled`` (1 where the ring's hoop is).
    """
    model, placed = subject.model, subject.model.system.films[film]
    by = scales(subject)
    x, top, radius, rise, stretch, wrinkled = _made(_name(model, placed), model, film)
    arrays: dict[str, Any] = {
        "height": x * by["length"],
        "top": top * by["voltage"],
        "radius": radius.ravel() * by["length"],
        "rise": rise.ravel(),
        "stretch": stretch.ravel(),
        "wrinkled": wrinkled.ravel().astype(np.uint8),
    }
    return Parts(arrays, {"name": _name(model, placed), "shares": list(SHARES), "rings": RINGS})


_tables: dict[str, tuple[Any, ...]] = {}


def _made(name: str, model: ConeModel, film: int) -> tuple[Any, ...]:
    """Heights, top voltages and profiles, dimensionless; cached by the name of the table."""
    if name not in _tables:
        if len(_tables) >= MOST:
            _tables.clear()
        placed = model.system.films[film]
        ratio = float(np.ravel(model.values[placed.prefix + "radius_ratio"])[0])
        _tables[name] = _profiles(placed.film, dict(placed.own(model.members().numbers_at(0))), ratio)
    return _tables[name]


def _profiles(film: Any, n: dict[str, Any], ratio: float) -> tuple[Any, ...]:
    x = film.reach(n)[1] * np.linspace(0.0, 1.0, HEIGHTS) ** CURVED
    top = np.minimum(film.balancing(x, 0.0, n), film.highest_squared(x, n))
    V = np.maximum(top, 0.0)[:, None] * np.array(SHARES)
    elements = Elements(Gel(film.law, n, n["A"], n["B"]), ratio)
    high = np.repeat(x, len(SHARES))
    computed = profile(elements, held(elements, high, V.ravel()))
    rings = np.linspace(0, computed.radius.size - 1, RINGS).round().astype(int)
    shape = (HEIGHTS, len(SHARES), RINGS)
    with np.errstate(all="ignore"):
        rise = computed.z[:, rings] / computed.z[:, :1]
    straight = 1.0 - (computed.radius[rings] - elements.disc)
    parts = [computed.r[:, rings], np.where(np.isfinite(rise), rise, straight), 1.0 / computed.thickness[:, rings]]
    parts.append(computed.excess[:, rings] > 0.0)
    values = [np.array(part, dtype=float).reshape(shape) for part in parts]
    has_state = np.isfinite(values[0][:, :, 0])
    for values_of in values:  # missing states: those of the voltage below, else an unstretched straight cone
        for k in range(1, len(SHARES)):
            values_of[:, k][~has_state[:, k]] = values_of[:, k - 1][~has_state[:, k]]
    lost = ~np.isfinite(values[0])
    plain = (
        np.broadcast_to(computed.radius[rings], shape),
        np.broadcast_to(straight, shape),
        np.ones(shape),
        np.zeros(shape),
    )
    return (
        x,
        np.sqrt(np.maximum(top, 0.0)),
        *(np.where(lost, other, array) for array, other in zip(values, plain, strict=True)),
    )
