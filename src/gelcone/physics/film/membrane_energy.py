"""Energy and charge of the membrane: integrals of its force over the height, by Gauss's quadrature.

    E(x, V) = E(x0, V) + integral of the force from x0 to x,    capacitance = -2 dE/dV,

with x0 = 0 where the flat film is in tension, else the height at which the film begins to pull. The range is divided
where the force has kinks: at the cut between the pieces of `gelcone.membrane.force`, and where a hoop falls slack.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from gelcone.bracket import halved
from gelcone.membrane import force as formulas
from gelcone.membrane.force import FLAT
from gelcone.membrane.integrals import integrals
from gelcone.physics.component import Numbers
from gelcone.physics.film import membrane_slack
from gelcone.physics.laws import StrainEnergyLaw

BISECTIONS = 48


def energy_and_area(law: StrainEnergyLaw, s: Any, V: Any, n: Numbers) -> tuple[Any, Any]:
    """Energy of film and field less the charge times the voltage, and capacitance, at squared heights and voltages."""
    energy, area = _without_tension(law, V, n)
    for piece, low, high in _parts(s, V, n):
        if (high <= low).all():
            continue
        k, by_v = integrals(partial(formulas.pull, piece), low, high, V, n, n[f"{piece}_shift"])
        energy, area = energy + 0.5 * k, area - by_v
    return energy, area


def _without_tension(law: StrainEnergyLaw, V: Any, n: Numbers) -> tuple[Any, Any]:
    """Energy and area of the flat film, where it is in tension or its rims are, else of the slack one."""
    has_rims = (n["A"] < n["B"]) & (n["B"] > 1.0)
    flat = np.where(has_rims, V, np.minimum(V, n["flat_voltage"]))
    powers = formulas.powers(flat, FLAT + 1)
    coefficients = [n[f"flat_area_{i}"] for i in range(FLAT + 1)]
    area = 1.0 + sum(c * power for c, power in zip(coefficients, powers, strict=False))
    energy = -0.5 * (
        flat + sum(c * power / (i + 1.0) for i, (c, power) in enumerate(zip(coefficients, powers[1:], strict=True)))
    )
    beyond = np.logical_not(has_rims) & ((flat < V) | (n["flat_voltage"] <= 0.0))
    slack, before = (membrane_slack.energy_and_area(law, np.where(beyond, value, flat), n) for value in (V, flat))
    return np.where(beyond, energy + slack[0] - before[0], energy), np.where(beyond, slack[1], area)


def _parts(s: Any, V: Any, n: Numbers) -> list[tuple[str, Any, Any]]:
    """Piece and ends of the ranges of s, from where the film begins to pull up to ``s``, in which the force is
    smooth."""
    begin = _begin(V, n)
    ranges = []
    for piece in formulas.PIECES:
        if piece == "near":
            low, high = np.minimum(begin, s), np.minimum(s, np.maximum(n["cut_squared"], begin))
        else:
            low, high = np.minimum(np.maximum(begin, n["cut_squared"]), s), s
        at = [_kink(piece, which, low, high, V, n) for which in ("rim", "whole")]
        places = [low, np.minimum(*at), np.maximum(*at), high]
        ranges += [(piece, start, stop) for start, stop in pairwise(places)]
    return ranges


def _begin(V: Any, n: Numbers) -> Any:
    """The s at which the film begins to pull."""
    low = np.zeros_like(V) + n["begin_squared"]
    high = np.maximum(low, np.zeros_like(V) + n["cut_squared"])
    low, _ = halved(lambda s: formulas.tension(s, V, n) < 0.0, low, high, BISECTIONS)
    return np.where(n["cut_squared"] > 0.0, np.where(low > n["begin_squared"], low, n["begin_squared"]), 0.0)


def _kink(piece: str, which: str, low: Any, high: Any, V: Any, n: Numbers) -> Any:
    """The s between ``low`` and ``high`` at which a hoop falls slack; ``high`` if there is none."""

    def distance(s: Any) -> Any:
        return formulas.distance(piece, which, s, V, n)

    sign = np.sign(distance(low))
    none = sign == np.sign(distance(high))
    if none.all():
        return high
    return np.where(none, high, halved(lambda s: np.sign(distance(s)) == sign, low, high, BISECTIONS)[1])
