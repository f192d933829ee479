"""Slow voltage ramps from rest: stroke, blocked force and the work of a cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gelcone import dataset
from gelcone.devices.analysis import for_devices
from gelcone.motion.static_bifurcations import pitchfork_voltages
from gelcone.motion.static_results import constant_voltages, label_static, rests_near
from gelcone.physics.balance import StaticBalance, rest_of
from gelcone.physics.members import Ensemble
from gelcone.physics.statics import balances_of, each
from gelcone.quantity import Array, Lengths, Voltages

if TYPE_CHECKING:
    import xarray as xr

WORK_PANELS, WORK_NODES = 16, 8
"""Number of panels, and of Gauss-Legendre nodes in each, over which the work of a cycle is integrated; kinks of the
force affect few panels."""
_WORK = dataset.absent("energy", nan="beyond pull-in")
_PULLED = dataset.absent("length", nan="beyond pull-in", infinite="beyond pull-in")


@for_devices
def stroke_and_blocked_force(model: Ensemble, voltages: Voltages, start: Lengths | None = None) -> xr.Dataset:
    """Compute stroke and blocked force at constant voltages that are reached on a slow ramp from 0.

    Films in opposite phase rise together to the bias v0; from there the first goes to v, and the second to 2 v0 - v.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive plays no part, but for the bias of films in opposite phase.
    voltages : constant commanded voltages v, at least 0, one or several.
    start : as in `pull_in_voltage`.

    Returns
    -------
    Dataset over the ensemble's dims and ``constant_voltage``: ``displacement`` of the disc and its ``stroke`` from
    ``rest_displacement``, on the branch that the ramp follows and past its end on the one it goes to (after a pitchfork
    the positive one), NaN where it goes to infinity; ``losses``, how many losses of stability the ramp has passed;
    ``blocked_force``, the part of the force due to the voltage (v^2 x in the cone), with which the disc pushes (away
    from the flat film) on a stop at its rest without voltage; ``cycle_work``, the largest work on a load in a
    cycle: the area between the forces with and without the voltage over the stroke.

    Raises
    ------
    InputError : for negative voltages, and for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.stroke_and_blocked_force(model, [0.4, 0.8])
    >>> found.stroke.values.round(4).tolist(), found.blocked_force.values.round(4).tolist()
    ([0.0371, 0.1814], [0.0871, 0.3482])
    """
    levels = constant_voltages(voltages)
    balances = balances_of(model)
    variables = ramp_variables(balances, rests_near(model, balances, start), levels)
    return label_static(
        model,
        balances,
        variables,
        coords={"constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage")},
        start=start,
        title="stroke and blocked force",
    )


class Ramp(NamedTuple):
    """A slow voltage ramp from ``rest``: ``displacement``, ``stroke``, ``blocked_force`` and ``stiffness`` at constant
    voltages, (voltages,), and the ``voltages`` on each film; and the voltages of its ``pitchfork``, as in
    `pitchfork_voltages`, and of its first jump or ``pull_in``, infinite if never."""

    rest: float
    displacement: Array
    stroke: Array
    blocked_force: Array
    stiffness: Array
    voltages: list[Array]
    pitchfork: float
    pull_in: float


def drive_ramp(balance: StaticBalance, levels: Array) -> Ramp:
    """The ramp of a single model to the ``levels``."""
    squared, rest = levels**2, rest_of(balance, None)
    pull_in = balance.jump(rest).voltage
    x = balance.along_ramp(rest, squared)[0]
    (pitchfork,) = pitchfork_voltages([balance])
    return Ramp(
        rest,
        x,
        x - rest,
        balance.voltage_force(rest, squared) + 0.0,
        balance.stiffness(x, squared),
        [np.sqrt(square) for square in balance.films(x, squared)],
        float(pitchfork),
        pull_in,
    )


def ramp_variables(balances: list[StaticBalance], rests: list[float], levels: Array) -> dict[str, dataset.Variable]:
    """Variables of the equilibria that slow ramps from the rests ``rests`` to the voltages ``levels`` reach."""
    reached = each(lambda balance, rest: balance.along_ramp(rest, levels**2), balances, rests)
    place, losses = (np.stack([row[k] for row in reached]) for k in range(2))
    rest, dims = np.array(rests), ("constant_voltage",)
    with np.errstate(all="ignore"):
        blocked = np.stack([balance.voltage_force(x, levels**2) for x, balance in zip(rests, balances, strict=True)])
    return {
        "displacement": (dims, place, "displacement on a slow voltage ramp", _PULLED),
        "stroke": (dims, place - rest[:, None], "displacement from the rest without voltage", _PULLED),
        "blocked_force": (dims, blocked + 0.0, "force on a stop at the rest position", "force"),
        "cycle_work": (dims, each_work(balances, rests, place, levels), "largest work of a cycle on a load", _WORK),
        "losses": (dims, losses, "losses of stability passed on the ramp", "count"),
        "rest_displacement": ((), rest, "stable equilibrium without voltage", "length"),
    }


def each_work(balances: list[StaticBalance], rests: list[float], place: Array, levels: Array) -> Array:
    """The largest work on a load in a cycle, which pushes the load under the voltage and returns without: the area
    between the forces with and without a voltage from the rest to the end of the ramp, (members, voltages)."""
    work = np.full(place.shape, np.nan)
    for member, (balance, rest) in enumerate(zip(balances, rests, strict=True)):
        for k in np.flatnonzero(np.isfinite(place[member])):
            x, weights = on_the_way(rest, place[member, k])
            work[member, k] = float(balance.voltage_force(x, np.full(x.shape, levels[k] ** 2)) @ weights)
    return work


def on_the_way(begin: float, end: float) -> tuple[Array, Array]:
    """Displacements between two, and the weights with which the forces there sum to their work."""
    nodes, weights = np.polynomial.legendre.leggauss(WORK_NODES)
    panels = (0.5 + 0.5 * nodes + np.arange(WORK_PANELS)[:, None]).ravel() / WORK_PANELS
    return begin + (end - begin) * panels, (end - begin) * np.tile(0.5 * weights / WORK_PANELS, WORK_PANELS)
