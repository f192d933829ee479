"""The energy of the homogeneous cone, written once more: the equation of motion follows from it."""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone.physics.bias import Bias
from gelcone.physics.component import Numbers
from gelcone.physics.film.taut import TautCone
from gelcone.physics.placed import PlacedFilm


def electric_energy(x: Any, voltage: Any, xp: Any = np, displacement: Any = None) -> Any:
    """Field energy of the homogeneous cone less the work of the voltage source.

    ``displacement`` is the electric displacement D/sqrt(eps mu); left out, it takes the value v sqrt(q) that makes
    the energy stationary, which leaves -v^2 q/2.
    """
    q = 1.0 + x * x
    if displacement is None:
        return -0.5 * voltage * voltage * q
    return 0.5 * displacement * displacement - voltage * displacement * xp.sqrt(q)


def lagrangian(
    x: Any,
    velocity: Any,
    voltage: Any,
    n: Numbers,
    film: TautCone,
    bias: Bias,
    xp: Any = np,
    second: tuple[PlacedFilm, Any] | None = None,
) -> Any:
    """Kinetic less potential energy of film, bias and field, of the homogeneous cone.

    ``second`` adds a second film, itself a homogeneous cone, with its voltage.
    """
    potential = film.law.energy(film.cone_strain(x, n), n, xp) + bias.energy(x, n) + electric_energy(x, voltage, xp)
    if second is not None:
        other, own, place = second[0].film, second[0].own(n), second[0].place(x, n)
        assert isinstance(other, TautCone)
        potential = potential + other.law.energy(other.cone_strain(place, own), own, xp)
        potential = potential + electric_energy(place, second[1], xp)
    return 0.5 * velocity * velocity - potential


def dissipation(velocity: Any, n: Numbers) -> Any:
    """Rayleigh dissipation function; the power lost is twice this."""
    return n["damping_ratio"] * velocity * velocity
