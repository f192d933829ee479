"""Self-sensing: the displacement of the disc from a measured capacitance of its film."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.devices.analysis import for_devices
from gelcone.errors import InputError
from gelcone.motion.single_film import single_film
from gelcone.physics.bracket import halved
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Capacitance, Capacitances, Voltage

if TYPE_CHECKING:
    import xarray as xr

HALVINGS = 60


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
    n, film, squared = model.numbers(), system.films[0], float(voltage) ** 2

    def known(x: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(film.capacitance(x, squared + 0.0 * x, [], n), dtype=float)

    x, low, high = _inverted(known, measured, film.film.reach(n), float(uncertainty))
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


def _inverted(known: Any, wanted: Array, reach: tuple[float, float], uncertainty: float) -> Array:
    """The x at which ``known``, which increases where it is finite, has the ``wanted`` values, and the ends of the x
    for their ``uncertainty``, (3, samples); NaN for values that are further than that from those of any x."""
    grid = np.linspace(reach[0], min(reach[1], 3.0), 601)
    values = known(grid)
    there = grid[np.isfinite(values)]
    every = np.stack([wanted, wanted - uncertainty, wanted + uncertainty])
    if not there.size:
        return np.full(every.shape, np.nan)
    ends = known(there[[0, -1]])
    low, high = np.full(every.shape, there[0]), np.full(every.shape, there[-1])
    low, high = halved(lambda x: known(x) < every, low, high, HALVINGS)
    reached = (wanted >= ends[0] - uncertainty) & (wanted <= ends[1] + uncertainty)
    return np.where(reached, 0.5 * (low + high), np.nan)
