"""The natural frequency of small motions about an equilibrium under a constant voltage.

It is that of the pair of eigenvalues in which the disc takes the largest part, with all states of films and circuits:
the modulus of a pair that oscillates, which is the frequency without damping. A device without such states has the root
of its stiffness. The branches of a film that creeps have little time to relax within an oscillation, so that the disc
oscillates faster than by the slope of its statics; so it does where a series resistance keeps the charge from
following.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.linear import slopes_of_drive, slopes_under
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.motion.regular import solved_where_regular
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance
from gelcone.quantity import Array

STIFFNESS_ROUNDING = 1e-9
"""Amount by which a stiffness that counts as zero, as in a fold, may be negative, and the share of an eigenvalue up to
which its imaginary part is rounding."""


def natural_frequency(model: ConeModel, voltage: npt.ArrayLike, displacement: npt.ArrayLike | None = None) -> Any:
    """Angular frequency of small motions about an equilibrium, as if undamped; NaN where there is no stable one.

    Parameters
    ----------
    model : a single model.
    voltage : constant commanded voltage, dimensionless: a number, or shape (voltages,).
    displacement : the equilibrium there, of the same shape. Default: the one that a slow ramp from 0 to the voltage
        ends at.
    """
    if displacement is None:
        ramp = stroke_and_blocked_force(model, np.abs(voltage))
        displacement = ramp["displacement"].values.reshape(np.shape(voltage))
    volts, place = np.broadcast_arrays(np.asarray(voltage, dtype=float), np.asarray(displacement, dtype=float))
    (balance,) = every_balance(model)
    squares = [np.reshape(square, (1, -1)) for square in balance.films(place, volts**2)]
    stiffness = np.reshape(balance.stiffness(place, volts**2), (1, -1))
    frequency = frequencies_under(
        model.members(), stiffness, place.reshape(1, -1), [np.sqrt(square) for square in squares]
    )
    return frequency.reshape(place.shape)[()]


def frequencies_under(members: Members, stiffness: Array, place: Array, voltages: Sequence[Array]) -> Array:
    """Natural frequencies about rests ``place`` of a static ``stiffness`` under constant ``voltages`` on each film,
    (members, levels); NaN where the stiffness is negative."""
    if members.system.planar:
        return np.asarray(frequency_of(stiffness))
    return np.where(stiffness >= -STIFFNESS_ROUNDING, _of_the_disc(slopes_under(members, place, voltages)), np.nan)


def driven_frequency(model: ConeModel) -> float:
    """Natural frequency about the rest of a single model under the mean squares of its drive; NaN without one."""
    stiffness, slopes = slopes_of_drive(model)
    frequency = frequency_of(stiffness) if model.system.planar else _of_the_disc(slopes)
    return float(np.where(stiffness >= -STIFFNESS_ROUNDING, frequency, np.nan)[0, 0])


def frequency_of(stiffness: Array | float) -> Any:
    """Angular frequency of small undamped motions at a slope of the static force; NaN where that is negative."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where(np.asarray(stiffness) >= -STIFFNESS_ROUNDING, np.maximum(stiffness, 0.0), np.nan))[()]


def _of_the_disc(slopes: Array) -> Array:
    """The root of the product of the two eigenvalues in which the disc takes the largest part: a pair that oscillates,
    or two of an overdamped disc. (..., N, N) to (...); NaN where there are none.

    The part of a state in a mode is the product of its entries in the right and the left eigenvector: Perez-Arriaga,
    Verghese, Schweppe, IEEE Trans. Power Appar. Syst. 101 (1982) 3117.
    """
    finite = np.isfinite(slopes).all(axis=(-2, -1))
    roots = np.full(finite.shape, np.nan)
    values, right = np.linalg.eig(slopes[finite])
    units = np.eye(slopes.shape[-1])
    left = (solved_where_regular(right, np.broadcast_to(units[i], values.shape)) for i in range(2))
    shares = sum(np.abs(right[:, i, :] * left_row) for i, left_row in enumerate(left))
    size, swings = np.abs(values), np.abs(values.imag) > STIFFNESS_ROUNDING * np.abs(values)
    rows, pair = np.arange(len(shares)), np.where(swings, shares, 0.0).argmax(axis=1)
    still = np.argsort(np.where(swings, -1.0, shares), axis=1)[:, -2:]
    of_two = np.where(swings, 0.0, shares)[rows[:, None], still].sum(axis=1)
    oscillates = 2.0 * np.where(swings, shares, 0.0)[rows, pair] > of_two
    two = np.sqrt(size[rows[:, None], still].prod(axis=1))
    roots[finite] = np.where(np.isnan(shares).any(axis=1), np.nan, np.where(oscillates, size[rows, pair], two))
    return roots
