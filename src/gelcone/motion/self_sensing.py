"""Self-sensing: the displacement of the disc from a measured capacitance of its film."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.bracket import halved
from gelcone.devices.analysis import for_devices
from gelcone.errors import InputError
from gelcone.membrane.table import ELEMENT_ERROR
from gelcone.motion.profile import capacitance_of_states
from gelcone.motion.single_film import single_film
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Capacitance, Capacitances, Voltage

if TYPE_CHECKING:
    import xarray as xr

HALVINGS = 60
HEIGHTS = 601
"""Heights at which it is tried whether the film has a state."""
STATES, ROUNDS, BEND = 61, 3, 4e-5
"""Heights at which states of the membrane are computed first; rounds that add others between them; and the error of the
capacitance, linear in x^2 between heights, above which they do, as a share of it."""

Known = Callable[[Array], Array]
"""Capacitance over x."""


@for_devices
def sense(
    model: ConeModel, capacitance: Capacitances, *, voltage: Voltage = 0.0, uncertainty: Capacitance = 0.0
) -> xr.Dataset:
    """Compute the displacement of the disc from a measured capacitance of its film, with its error.

    Parameters
    ----------
    model : a single model or device with one film.
    capacitance : measured, shape (samples,).
    voltage : constant voltage on the film, which widens a film that wrinkles. Default 0.
    uncertainty : of the measured capacitance. Default 0.

    Returns
    -------
    Dataset over ``sample``: ``capacitance``, and the ``displacement``, above the film's plane, with its
    ``displacement_error``, the larger distance to the displacements of a capacitance that is off by the uncertainty.
    NaN for a capacitance that the film does not reach within that.

    The capacitance of a membrane is that of its states by finite elements, as in `film`; their error, 2e-4 of the
    capacitance, is added to the uncertainty. Runs have a fitted capacitance, which differs by the ``capacitance_error``
    of their results and so means another displacement.

    Raises
    ------
    InputError : for an ensemble, two films, a film that creeps, and a negative uncertainty.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.sense(model, [1.3], uncertainty=0.01)
    >>> f"{found.displacement.item():.4f} +- {found.displacement_error.item():.4f}"
    '0.5477 +- 0.0092'
    """
    system = single_film(model, "sense")
    measured = np.atleast_1d(np.asarray(capacitance, dtype=float))
    if measured.ndim != 1 or not float(uncertainty) >= 0.0:
        raise InputError(f"capacitance, uncertainty = {uncertainty:g}: must be a list and a number of at least 0")
    known, ends = _known(model, float(voltage) ** 2)
    of_states = ELEMENT_ERROR if isinstance(system.films[0].film, MembraneFilm) else 0.0
    x, low, high = _inverted(known, measured, ends, float(uncertainty) + of_states * measured)
    error = np.maximum(high - x, x - low)
    dims = ("sample",)
    return dataset.label(
        model,
        {
            "capacitance": (dims, measured, "measured capacitance", "capacitance"),
            "displacement": (dims, x, "displacement x = h/(b-a)", "length"),
            "displacement_error": (dims, error, "error of the displacement", "length"),
        },
        options={"voltage": voltage, "uncertainty": uncertainty},
        title="self-sensing",
    )


def _known(model: ConeModel, squared: float) -> tuple[Known, Array]:
    """The capacitance under a squared voltage, and the two ends of the x of the film's states; without ends where it
    has none."""
    n, members, placed = model.numbers(), model.members(), model.system.films[0]

    def of_film(x: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(placed.film.capacitance(x, squared + 0.0 * x, [], n), dtype=float)

    reach = placed.film.reach(n)
    grid = np.linspace(reach[0], min(reach[1], 3.0), HEIGHTS)
    there = grid[np.isfinite(of_film(grid))]
    ends = there[[0, -1]] if there.size else there
    if not (there.size and isinstance(placed.film, MembraneFilm)):
        return of_film, ends
    x, values = _states(lambda at: capacitance_of_states(members, placed, at, squared + 0.0 * at), ends)
    increasing = np.maximum.accumulate(values)  # next to its plane a charged film may have less, by 1e-5
    return lambda at: np.interp(at * at, x * x, increasing), ends if x.size else x


def _states(known: Known, ends: Array) -> tuple[Array, Array]:
    """The x of states between two ``ends`` and their ``known`` capacitance: denser where it bends over x^2, and towards
    an end next to which no state is found."""
    new_x, x, values = np.unique(np.linspace(ends[0], ends[-1], STATES)), ends[:0], ends[:0]
    for _ in range(ROUNDS + 1):
        measured = known(new_x)
        x, values = np.append(x, new_x[np.isfinite(measured)]), np.append(values, measured[np.isfinite(measured)])
        x, values = x[np.argsort(x)], values[np.argsort(x)]
        widths = np.diff(x * x)
        error = np.abs(np.diff(np.diff(values) / widths)) * np.maximum(widths[1:], widths[:-1]) / 8.0
        bent = np.flatnonzero(error > BEND * values[1:-1])
        places = np.concatenate([ends[:1], x, ends[1:]])
        chosen = np.isin(np.arange(places.size - 1), [bent + 1, bent + 2])
        chosen[[0, -1]] |= np.diff(places)[[0, -1]] > 0.0
        new_x = (0.5 * (places[:-1] + places[1:]))[chosen]
        if not (x.size and new_x.size):
            break
    return x, values


def _inverted(known: Known, wanted: Array, ends: Array, uncertainty: Array) -> Array:
    """The x at which ``known``, which increases between two ``ends``, has the ``wanted`` values, and the ends of the x
    for their ``uncertainty``, (3, samples); NaN for values that are further than that from those of any x."""
    every = np.stack([wanted, wanted - uncertainty, wanted + uncertainty])
    if not ends.size:
        return np.full(every.shape, np.nan)
    least, most = known(ends)
    low, high = np.full(every.shape, ends[0]), np.full(every.shape, ends[1])
    low, high = halved(lambda x: known(x) < every, low, high, HALVINGS)
    reached = (wanted >= least - uncertainty) & (wanted <= most + uncertainty)
    return np.where(reached, 0.5 * (low + high), np.nan)
