"""The fit of the film as a continuum that bears compression: the force of the membrane that does not wrinkle.

This is the film of the source paper; only the claim `fem-agreement` uses it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gelcone.continuum.membrane import (
    highest_span,
    limit_shares,
    raised_film,
    stress_state,
)
from gelcone.continuum.mesh import Film, mesh_film
from gelcone.continuum.path import Point, cone, flat, newton, reach
from gelcone.paper.unwrinkled import UnwrinkledFilm
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

ELEMENTS = 32
FARTHEST = 6.0
"""Largest fitted displacement, in b - a, unless the stretch limit is closer."""
LIMIT_SHARE = 0.97
"""Share of the stretch limit next to the disc up to which displacements are fitted."""
STEPS = 12
"""Steps of the voltage squared, from 0 to the highest that a free film withstands."""
STEEP = 1.3
"""Near a fold or bulge the voltage weakens the film faster than at first, by this factor or more."""
FREE_SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
"""Shares of that voltage squared at which the compressed film near the flat one is computed."""
CEILING_MARGIN = 0.97
"""Share of the highest V up to which states are fitted: at the fold itself the slope is infinite."""
TAUT, HOOP_SLACK, SLACK, FLAT = range(4)
KINDS = ("taut", "hoop slack", "near slack", "nearly flat")
WEIGHTS = (1.0, 0.1, 0.02, 1.0)
"""Weights of the kinds of states in the fit. Only the first is a film that does not wrinkle; the last, compressed but
nearly flat, decides the stability of rest."""
NEARLY_FLAT = 0.03
DEGREES = {"rest": 9, "field": 6, "fold": 5, "field_squared": 3, "ceiling": 6}
"""Number of coefficients of each polynomial."""
WALLS, FARTHEST_WALL = 30, 20.0


class _State(NamedTuple):
    """One state to fit: stiffness over s and V."""

    s: float
    squared: float
    stiffness: float
    kind: int


def fit_unwrinkled(model: ConeModel, radius_ratio: float) -> UnwrinkledFilm:
    """The fitted force of the membrane of a model with equal pre-stretches, if it bore compression, with the error of
    the fit.

    The membrane is raised step by step, and at each height charged until it pulls in. Near the flat film its compressed
    states are computed too, so that a disc can pass through x = 0. Displacements are fitted up to 97 % of the stretch
    limit next to the disc or 6 (b - a), voltages up to pull-in or the electromechanical instability of a free film.
    """
    film = mesh_film(model.replace(spring_stiffness=0.0), radius_ratio, ELEMENTS)
    free = free_film_limit(film.model)
    states, ends = _states(film, free)
    return _fitted(film, free, states, ends)


def free_film_limit(model: ConeModel) -> float:
    """The V at which a film that may take any area (slack, or wrinkled in all directions) becomes unstable.

    Its stretch t^(1/2) is equal in all directions, and V G = response (1 - t^-3)/t has a maximum: the electromechanical
    instability of dielectric elastomers (Zhao and Suo, Appl. Phys. Lett. 91 (2007) 061921). Where the stretch limit
    prevents it, 1/G is the end of the fit.
    """
    c, limit = model.numbers(), float(model.gel_law().strain_limit(model.numbers()))
    t = 1.0 + np.geomspace(1e-4, min(0.5 * (limit + 3.0), 30.0), 20001)
    strain = 2.0 * t + t**-2.0 - 3.0
    t, strain = t[strain < limit], strain[strain < limit]
    squared = model.gel_law().response(strain, c) * (1.0 - t**-3.0) / t / float(c["G"])
    falls = np.flatnonzero(np.diff(squared) < 0.0)
    return float(squared[falls[0]]) if falls.size else 1.0 / float(c["G"])


# --- the states ------------------------------------------------------------------------------------------------------


def _heights(film: Film) -> Array:
    top = min(highest_span(film), FARTHEST)
    low = min(1.0, top / 4.0)
    return np.unique(np.concatenate([[0.05 * low], np.linspace(0.1, 1.0, 10) * low, np.linspace(low, top, 18)]))


def _states(film: Film, free: float) -> tuple[list[_State], list[tuple[float, float]]]:
    """The states to fit, and the ends (s, V) of the voltage."""
    heights = _heights(film)
    states: list[_State] = []
    raised = raised_film(film, heights.tolist())
    ends = [(height * height, free) for height in (0.0, *heights) if height < min(raised, default=0.0)]
    for height, point in raised.items():
        if limit_shares(film, point.position).max() > LIMIT_SHARE:
            break
        column, end = _charged(film, point, free)
        states += column
        ends.append((height * height, end))
    for share in FREE_SHARES:
        states += _compressed(film, share * free)
    return states, ends


def _charged(film: Film, start: Point, free: float) -> tuple[list[_State], float]:
    """States at one height under rising V, and its end: a fold, a bulge, or the limit of a free film.

    Towards a fold or bulge the voltage weakens the film at a growing rate. For a film that loses its tension the rate
    falls, and the curve does not end there.
    """
    point, states, squared, step = start, [_state(film, start)], 0.0, free / STEPS
    first, ratio, steepest = 0.0, 1.0, 1.0
    while step > 0.01 * max(squared, 0.04 * free) and squared < free * (1.0 - 1e-9):
        step = min(step, free - squared)
        next_point = reach(film, point, "squared", squared + step)[0]
        rate = 0.0 if next_point is None else (point.force - next_point.force) / step
        if rate <= 0.0 or (steepest > STEEP and rate < 0.25 * first):
            step *= 0.5
            continue
        first = first or rate
        ratio, steepest = rate / first, max(steepest, rate / first)
        squared, point = squared + step, next_point or point
        states.append(_state(film, point, slack=ratio < 0.5 and point.force < 0.3 * start.force))
    return states, squared if ratio >= 0.5 or steepest > STEEP else free


def _compressed(film: Film, squared: float) -> list[_State]:
    """States of a film that its voltage compresses along the meridian, from the flat one up."""
    start = flat(film, squared)
    if start is None or not start.forces.most < 0.0:
        return []
    height, states = 0.02, []
    point = newton(film, cone(film, height, start), squared)
    while point is not None and point.forces.most < 0.0:
        states.append(_state(film, point, slack=True))
        nexts = (reach(film, point, "height", point.height + step)[0] for step in (0.04, 0.02, 0.01))
        point = next((candidate for candidate in nexts if candidate is not None and candidate.forces.most < 0.0), None)
    return states


def _state(film: Film, point: Point, *, slack: bool = False) -> _State:
    smallest = float(np.min(stress_state(film, point.position, point.squared)[3]))
    kind = FLAT if slack and point.height < NEARLY_FLAT else SLACK if slack else HOOP_SLACK if smallest < 0.0 else TAUT
    return _State(point.height**2, point.squared, point.force / point.height, kind)


# --- the fit ---------------------------------------------------------------------------------------------------------


def _fitted(film: Film, free: float, states: list[_State], ends: list[tuple[float, float]]) -> UnwrinkledFilm:
    s, squared, stiffness, kind = (np.array(column) for column in zip(*states, strict=True))
    farthest = float(s.max())
    # t runs from -1 at the flat film to 1 at the farthest
    scale = 2.0 * (1.0 + farthest) / farthest
    variable = (scale - 1.0, -scale)
    end_s, end = np.array(ends).T
    ceiling = _least_squares(
        _powers(variable, end_s, DEGREES["ceiling"]), 1.0 / np.maximum(end, 0.02 * free), np.maximum(end, 0.02 * free)
    )
    share = squared * (_powers(variable, s, DEGREES["ceiling"]) @ ceiling)
    inside = share < CEILING_MARGIN
    s, squared, stiffness, kind, share = (values[inside] for values in (s, squared, stiffness, kind, share))
    relative = 1.0 / (np.abs(stiffness) + 0.3 * squared + 0.02)
    weights = np.array(WEIGHTS)[kind] * relative
    bend = 1.0 - np.sqrt(1.0 - share) - 0.5 * share
    factors = {"rest": np.ones_like(s), "field": squared, "fold": bend, "field_squared": squared**2}
    flat_stiffness, flat_gain = _flat(film)
    base = flat_stiffness + squared * (1.0 - flat_gain)
    # zero at t = -1: an error there would open spurious instability tongues
    rise = 1.0 + _powers(variable, s, 2)[:, 1:]
    parts = {name: _powers(variable, s, DEGREES[name]) * factor[:, None] * rise for name, factor in factors.items()}
    smooth = np.concatenate(list(parts.values()), axis=1)

    def fit(wall: float) -> tuple[Array, Array]:
        columns = np.column_stack([smooth, s / (wall - s)])
        coefficients = _least_squares(columns, stiffness + squared - base, weights)
        return coefficients, columns @ coefficients + base - stiffness - squared

    # without a stretch limit, the pole represents a law that stiffens
    highest = min(1.2 * highest_span(film) ** 2, FARTHEST_WALL * farthest)
    walls = np.geomspace(1.01 * farthest, max(highest, 1.1 * farthest), WALLS)
    wall = float(min(walls, key=lambda w: float(np.sum((fit(w)[1] * weights) ** 2))))
    coefficients, error = fit(wall)
    pieces = np.split(coefficients, np.cumsum([DEGREES[name] for name in parts]))
    strength = float(pieces[-1][0])
    numbers = {
        name: np.asarray(np.polynomial.polynomial.polymul(values, (1.0, 1.0)))
        for name, values in zip(parts, pieces, strict=False)
    }
    numbers["rest"][0] += flat_stiffness
    numbers["field"][0] += 1.0 - flat_gain
    # the term of the wall is 1/(1 - s/wall) = 1 + s/(wall - s)
    numbers["rest"][0] -= strength
    fitted: dict[str, Any] = {name: tuple(values.tolist()) for name, values in numbers.items()}
    return UnwrinkledFilm(
        radius_ratio=film.radius_ratio,
        scale=float(np.square(film.model.stretches[0])),
        largest=float(np.sqrt(farthest)),
        wall=wall,
        variable=variable,
        **fitted,
        wall_strength=strength,
        ceiling=tuple(ceiling.tolist()),
        errors=tuple(
            (name, float(np.max(np.abs(error * relative)[kind == k])))
            for k, name in enumerate(KINDS)
            if (kind == k).any()
        ),
    )


def _flat(film: Film) -> tuple[float, float]:
    """Exact stiffness of the flat film without voltage, and the rate at which V weakens it.

    With equal pre-stretches the tension N = (A - G) response - V of the flat film is the same everywhere; raised a
    little it satisfies (R w')' = 0, hence the stiffness 2 (1 - r) N/((1 + r) ln(1/r)) for a/b = r.
    """
    c, r = film.coefficients, film.radius_ratio
    share = 2.0 * (1.0 - r) / ((1.0 + r) * np.log(1.0 / r))
    tension = (c["A"] - c["G"]) * film.model.gel_law().response(c["A"] + c["B"] + c["G"] - 3.0, c)
    return float(share * tension), float(share)


def _powers(variable: tuple[float, float], s: Array, count: int) -> Array:
    return np.vander(variable[0] + variable[1] / (1.0 + s), count, increasing=True)


def _least_squares(columns: Array, values: Array, weights: Array) -> Array:
    return np.asarray(np.linalg.lstsq(columns * weights[:, None], values * weights, rcond=None)[0])
