"""Feed-forward: the voltage under which the disc follows a wanted motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from gelcone import dataset
from gelcone.devices.analysis import for_devices
from gelcone.errors import InputError
from gelcone.motion.single_film import single_film
from gelcone.physics.driven import INPUTS, driven
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Lengths, Times, Voltage

if TYPE_CHECKING:
    import xarray as xr

DEGREE = 5
"""Degree of the spline through the wanted heights, whose accelerations are smooth."""
TOP = 1.0 - 1e-9
"""Share of the squared voltage at which the film ends, up to which it is used."""
TOLERANCE = 1e-9


@for_devices
def follow(
    model: ConeModel, times: Times, displacement: Lengths, *, highest_voltage: Voltage | None = None
) -> xr.Dataset:
    """Compute the voltage under which the disc follows a wanted motion, and check it by an integration.

    The equation of motion gives the force of the film that the motion takes, and the film the voltage of that force.
    Where no voltage gives it - the film cannot push, and it ends where it pulls in - the nearest one is taken. Between
    samples the voltage changes at a constant rate.

    Parameters
    ----------
    model : a single model or device with one film without states, and an ideal source.
    times : increasing times, at least 6.
    displacement : wanted displacements at these, through which a smooth curve is laid.
    highest_voltage : largest voltage. Default None: no limit but those of the film.

    Returns
    -------
    Dataset over ``time``: ``displacement`` as wanted, the ``voltage``, whether it is ``reachable``, the displacement
    that the voltage gives, ``followed``, from the wanted start on, and its ``error``; and the ``largest_error``.
    Displacements are NaN from where the film has pulled in.

    Raises
    ------
    InputError : for an ensemble, films, biases and circuits with states, two films, and times that do not increase.

    Examples
    --------
    >>> import gelcone
    >>> import numpy as np
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    >>> rest = gelcone.static(model, [0.0]).equilibrium_displacement.values.item()
    >>> times = np.linspace(0.0, 10.0, 101)
    >>> found = gelcone.follow(model, times, rest + 0.02 * (1.0 - np.cos(times)))
    >>> bool(found.reachable.values.all()), f"{found.voltage.values.max():.3f}, error {found.largest_error.item():.0e}"
    (True, '0.371, error 2e-05')
    """
    system = single_film(model, "follow")
    tau, x = _samples(times, displacement)
    wanted = make_interp_spline(tau, x, k=DEGREE)
    n, film = model.numbers(), system.films[0]
    speed, acceleration = wanted.derivative(1)(tau), wanted.derivative(2)(tau)
    bias = np.broadcast_to(system.bias.force(x, [], n)[0], x.shape)
    pull = -acceleration - 2.0 * np.asarray(n["damping_ratio"]) * speed - bias
    with np.errstate(all="ignore"):
        nowhere = x == 0.0  # the flat film pulls with no voltage
        squared = np.asarray(film.film.balancing(x, np.where(nowhere, 0.0, pull / np.where(nowhere, 1.0, x)), n))
        end = TOP * np.broadcast_to(film.highest_squared(x, n), x.shape)
    end = np.minimum(end, np.inf if highest_voltage is None else float(highest_voltage) ** 2)
    taken = np.clip(np.nan_to_num(squared, nan=0.0, posinf=np.inf), 0.0, end)
    voltage = np.sqrt(np.where(nowhere, 0.0, taken))
    followed = _integrated(model, tau, voltage, (float(x[0]), float(speed[0])))
    error = followed - x
    dims = ("time",)
    return dataset.label(
        model,
        {
            "displacement": (dims, x, "wanted displacement x = h/(b-a)", "length"),
            "voltage": (dims, voltage, "voltage across the film", "voltage"),
            "reachable": (dims, (squared == taken) & ~nowhere, "is there a voltage that gives the motion", "flag"),
            "followed": (dims, followed, "displacement under the voltage", "length"),
            "error": (dims, error, "displacement under the voltage less the wanted one", "length"),
            "largest_error": ((), np.abs(error).max(), "largest error of the displacement", "length"),
        },
        coords={"time": (dims, tau, "time", "time")},
        options={"highest_voltage": highest_voltage},
        title="feed-forward",
    )


def _samples(times: Any, displacement: Any) -> tuple[Array, Array]:
    """Times and wanted displacements. Raises `InputError` for samples that do not make a motion."""
    tau, x = np.asarray(times, dtype=float), np.asarray(displacement, dtype=float)
    if tau.ndim != 1 or tau.size <= DEGREE or tau.shape != x.shape:
        raise InputError(f"times, displacement: must be two lists of one length of at least {DEGREE + 1}")
    if not (np.isfinite(tau).all() and np.isfinite(x).all() and (np.diff(tau) > 0.0).all()):
        raise InputError("times: must increase and, like displacement, be finite")
    return tau - tau[0], x


def _integrated(model: ConeModel, tau: Array, voltage: Array, start: tuple[float, float]) -> Array:
    """The displacement under a voltage that changes at a constant rate between its samples."""
    system = driven(model.system)
    n = {**system.numbers_of({name: np.asarray(value, dtype=float) for name, value in model.values.items()})}

    def rates(t: float, z: Array) -> list[float]:
        numbers = n | {INPUTS[0]: np.interp(t, tau, voltage)}
        with np.errstate(all="ignore"):
            return [float(rate) for rate in system.rates(0.0, list(z), numbers)]

    options = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE**1.5, "max_step": np.diff(tau).max()}
    displacement = np.full(tau.shape, np.nan)
    with np.errstate(all="ignore"):
        run = solve_ivp(rates, (0.0, tau[-1]), start, t_eval=tau, **options)
    displacement[: run.t.size] = run.y[0]
    return np.where(np.logical_or.accumulate(np.isnan(displacement)), np.nan, displacement)
