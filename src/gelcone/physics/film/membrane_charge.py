"""The charge of the membrane as a formula for programs, fitted to -2 dE/dV of its energy.

The energy is the integral of the force over the height, and has no closed form. In each piece of
`gelcone.membrane.force` with its u, q, ``rim`` and ``whole``

    capacitance = (1 + s) [P(u, q) + rim^2 P1(u, q) + whole^2 P2(u, q)]

since the second derivative of the charge, too, has a kink where a hoop falls slack. ``capacitance_error`` is the stated
relative error, that of states by finite elements times a margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from gelcone import disk_cache
from gelcone.membrane import force as formulas
from gelcone.membrane import made
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.least_squares import chebyshev_to_powers, products, solved
from gelcone.membrane.profile import held
from gelcone.membrane.table import ELEMENT_ERROR
from gelcone.physics.component import Numbers
from gelcone.physics.laws import StrainEnergyLaw
from gelcone.quantity import Array

KIND = disk_cache.CHARGES
PARTS = {"main": (10, 8), "rim": (5, 4), "whole": (5, 4)}
"""Degrees in u and q."""
HEIGHTS, VOLTAGES = 40, 32
"""Places of the fit in each piece."""
PLACES = 4001
TOP = 1.0 - 1e-9
"""Share of the pull-in voltage up to which the charge is fitted."""
BORDER = 10.0
"""Weight of the places where the film falls slack, so that the charge is continuous there."""
FLOOR = 0.05
"""Added to the change of the capacitance before its relative error is taken."""
SMALLEST = 1e-12
CHECKED_HEIGHTS, CHECKED_SHARES = 5, (0.0, 0.5, 0.8, 0.95)
"""States at which the capacitance is compared with that of finite elements: heights in each piece, and shares of the
voltage at which the film falls slack or pulls in there."""
MARGIN = 3.0
"""Ratio of the stated error to the largest at these states."""
ERROR = "capacitance_error"

Area = Callable[[Array, Array], Array]
"""Capacitance over s and V."""


@cache
def names() -> tuple[str, ...]:
    """Names of all coefficients, piece by piece, and of the stated error."""
    return *(name for piece in formulas.PIECES for part in PARTS for name in _names(piece, part).ravel()), ERROR


@cache
def _names(piece: str, part: str) -> np.ndarray[Any, np.dtype[Any]]:
    return formulas.numbered(f"{piece}_charge_{part}", tuple(degree + 1 for degree in PARTS[part]))


def capacitance(piece: str, s: Any, own: formulas.Spot, n: Numbers, behind: Sequence[Any]) -> Any:
    """The capacitance at the spot ``own`` of a piece; ``behind`` holds 1 or 0 for ``rim`` and ``whole``: whether their
    parts count."""
    power = formulas.powers(own.u, PARTS["main"][0])
    total = formulas.double_sum(_names(piece, "main"), power, own.q, n)
    for part, distance, counts in zip(("rim", "whole"), (own.rim, own.whole), behind, strict=True):
        if getattr(counts, "value", None) != 0.0:
            factor = counts * distance
            total = total + factor * factor * formulas.double_sum(_names(piece, part), power, own.q, n)
    return (1.0 + s) * total


def numbers_of(
    area: Callable[[Numbers], Area], own: Mapping[str, Any], of_table: Mapping[str, Any], law: StrainEnergyLaw
) -> dict[str, Any]:
    """Fit the coefficients of films, in the shape of the numbers ``of_table``.

    ``area`` returns the capacitance of a film with given numbers; ``own`` are the numbers of its gel and its
    ``radius_ratio``.
    """
    shape = np.shape(of_table["film_error"])
    gel = [made.rounded(np.broadcast_to(value, shape) if shape else np.ravel(value)[0]) for value in own.values()]
    rows = np.stack([*gel, *(np.ravel(value) for value in of_table.values())], axis=-1)
    each = np.array([_made(area, (*own, *of_table), row.tobytes(), law) for row in rows])
    if not shape:
        return dict(zip(names(), each[0].tolist(), strict=True))
    return {name: each[:, k].reshape(shape) for k, name in enumerate(names())}


@lru_cache(maxsize=made.MOST)
def _made(
    area: Callable[[Numbers], Area], table_names: tuple[str, ...], row: bytes, law: StrainEnergyLaw
) -> tuple[float, ...]:
    """The coefficients of one film and their error, in the order of their names."""

    def make() -> bytes:
        n = dict(zip(table_names, np.frombuffer(row).tolist(), strict=True))
        values = np.concatenate([_fitted(piece, area(n), n) for piece in formulas.PIECES])
        return np.append(values, _error(law, n | dict(zip(names(), values.tolist(), strict=False)))).tobytes()

    sources = (Path(__file__).parent, Path(formulas.__file__).parent, type(law))
    return tuple(np.frombuffer(disk_cache.made(KIND, (law, row), make, sources)).tolist())


def _fitted(piece: str, area: Area, n: Numbers) -> Array:
    """The coefficients of a piece by least squares of the relative error; zeros for one that the film lacks."""
    rows = [degree + 1 for part in PARTS.values() for degree in part]
    if not abs(n[f"{piece}_scale"]) > 0.0:
        return np.zeros(sum(one * other for one, other in zip(rows[::2], rows[1::2], strict=True)))
    s, V, weight = _places(piece, n)
    own = formulas.pull(piece, s, V, n)
    ratios = area(s, V) / (1.0 + s)
    finite = np.isfinite(ratios)
    weight = weight / (np.abs(ratios - 1.0 / (1.0 + s)) + FLOOR)
    parts = []
    for part, factor in (("main", 1.0), ("rim", np.maximum(own.rim, 0.0)), ("whole", np.maximum(own.whole, 0.0))):
        parts.append(products(own.u, own.q, PARTS[part]) * np.square(factor + 0.0 * s)[:, None])
    values = solved(np.hstack(parts)[finite], ratios[finite], weight[finite], SMALLEST)
    split = np.split(values, np.cumsum([part.shape[1] for part in parts])[:-1])
    shaped = (own.reshape([d + 1 for d in PARTS[part]]) for part, own in zip(PARTS, split, strict=True))
    return np.concatenate([chebyshev_to_powers(own).ravel() for own in shaped])


def _places(piece: str, n: Numbers) -> tuple[Array, Array, Array]:
    """s, V and weights of a piece: Chebyshev points in u, and in V up to where the film ends."""
    share = 0.5 - 0.5 * np.cos(np.pi * np.arange(VOLTAGES) / (VOLTAGES - 1.0))
    s, end = _ends(piece, chebyshev.chebpts1(HEIGHTS), n)
    V = end[:, None] * share * TOP
    weight = np.where(share == 1.0, BORDER if piece == "near" else 1.0, 1.0) + 0.0 * V
    return np.repeat(s, VOLTAGES), V.ravel(), weight.ravel()


def _ends(piece: str, u: Array, n: Numbers) -> tuple[Array, Array]:
    """s at ``u`` of a piece, and the V at which the film falls slack or pulls in there."""
    grid = np.linspace(0.0, np.sqrt(n["reach_squared"]), PLACES) ** 2
    s = np.interp(u, n[f"{piece}_scale"] * formulas.place(piece, grid, n)[0] + n[f"{piece}_offset"], grid)
    with np.errstate(invalid="ignore"):
        end = formulas.tension(s, 0.0, n) if piece == "near" else formulas.pull_in(s, n)
    return s, np.maximum(end, 0.0)


def _error(law: StrainEnergyLaw, n: Numbers) -> float:
    """The stated relative error of the capacitance of a film with all its numbers; NaN for a film without a piece."""
    film, errors = Elements(Gel(law, n, n["A"], n["B"]), n["radius_ratio"]), []
    for piece in (name for name in formulas.PIECES if abs(n[f"{name}_scale"]) > 0.0):
        s, end = _ends(piece, np.linspace(-1.0, 1.0, CHECKED_HEIGHTS + 2)[1:-1], n)
        V = (end[:, None] * np.square(CHECKED_SHARES)).ravel()
        s = np.repeat(s, len(CHECKED_SHARES))
        with np.errstate(all="ignore"):
            states, spot = held(film, np.sqrt(s), V), formulas.spot(piece, s, V, n)
            behind = np.where(spot.rim > 0.0, 1.0, 0.0), np.where(spot.whole > 0.0, 1.0, 0.0)
            off = capacitance(piece, s, spot, n, behind) / film.measures(states).area - 1.0
        errors.append(np.abs(off[states.found]))
    return ELEMENT_ERROR + MARGIN * float(np.concatenate(errors).max(initial=0.0)) if errors else np.nan
