"""Statics: force over displacement under a constant voltage, equilibria, pitchfork, folds and pull-in.

How equilibria are found is explained in `gelcone.physics.balance`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, for_devices
from gelcone.errors import InputError
from gelcone.motion.validity import ASSUMPTIONS, outside, untrue_by
from gelcone.physics.balance import (
    ROUNDING,
    SEARCH_RANGE,
    Equilibrium,
    PullIn,
    StaticBalance,
    rest_of,
)
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.statics import balances_of, each, every_balance
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, Lengths, VoltageArray, Voltages

if TYPE_CHECKING:
    import xarray as xr

FORCE_SAMPLES = 401
_PLACE: dataset.Of = dataset.absent("length", nan="none")
_FOLD: dataset.Of = dataset.absent("voltage", nan="none")
_FROM = dataset.absent("length")
_TO = dataset.absent("length", infinite="no other equilibrium")
PITCHFORK = "constant voltage at which the flat film, or the middle of two equal ones, loses stability"
PULL_IN = "constant voltage at which the disc jumps or the film pulls in"
PULL_IN_KIND = "how the disc jumps or pulls in"
WORK_PANELS, WORK_NODES = 16, 8
"""Panels, and Gauss-Legendre nodes of each, over which the work of a cycle is integrated; corners lie in few."""
_WORK = dataset.absent("energy", nan="beyond pull-in")
_PULLED = dataset.absent("length", nan="beyond pull-in", infinite="beyond pull-in")


@analysis(
    answers="statics",
    examples=(
        "--set spring_stiffness=1.5 --voltages 0,1,1.5 --out results",
        'paper-table1 --voltages "0 kV:10 kV:11" --json',
    ),
)
def static(
    model: Ensemble,
    voltages: Voltages | None = None,
    displacements: Lengths | None = None,
    *,
    at_once: bool = False,
    progress: Progress = None,
) -> xr.Dataset:
    """Force over displacement, equilibria, their branches, pitchfork, folds and pull-in under constant voltages.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive only gives the default of ``voltages``.
    voltages : constant voltages v, at least 0, one or several. Default the peak of the drive and,
        where it has one, its offset.
    displacements : increasing x at which the force is given; default 401 even ones around all equilibria.
    at_once : of a film that creeps, before its branches have relaxed: the first stroke of a step, the blocked force
        of a fast one. Default the film that has relaxed.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims, ``constant_voltage``, ``displacement`` and ``equilibrium`` (padded with NaN;
    ``equilibria`` counts them). ``force`` holds the disc at x and ``stiffness`` is its slope, both NaN beyond the
    stretch limit and where a film held at x has pulled in. ``slope`` is that of the force at
    ``equilibrium_displacement``, which is ``stable`` where the energy
    has a minimum. ``branch_*`` trace the equilibria over the voltage, pieces parted by NaN, with the folds among the
    points. Pitchfork, folds and pull-in are those of `pitchfork_voltage`, `fold_voltages` and `pull_in_voltage`,
    ``stroke``, ``blocked_force`` and ``cycle_work`` on a slow voltage ramp those of `stroke_and_blocked_force`.
    ``validity_*`` are 1 at an equilibrium where an assumption of the model fails
    (`gelcone.motion.validity.ASSUMPTIONS`), 0 elsewhere, NaN where it is unknown; one has pulled in that lies beyond
    the displacement from which a slow ramp jumps. The ``outcome`` of a member is ``outside`` where its pre-stretch
    exceeds the stretch limit at every displacement.

    Raises
    ------
    InputError : for voltages out of bounds, displacements that do not increase or of which none can be reached, or
        when no member can be reached at all.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> found = gelcone.static(device, ["0 V"])
    >>> f"one of {int(found.equilibria.item())}: {found.equilibrium_displacement.values[0, 0]:.2f} mm"
    'one of 1: 12.59 mm'
    """
    levels = own_levels(model) if voltages is None else constant_voltages(voltages)
    held = films_at_once(model) if at_once else model
    balances = balances_of(held)
    counted = Counted(progress)
    found = []
    for balance in balances:
        found.append(balance.equilibria(levels**2))
        counted(0.7 / len(balances))
    x = _force_range(balances, found) if displacements is None else _wanted(displacements, balances)
    squared = levels[:, None] ** 2
    whole = np.stack([balance.whole(x, squared) for balance in balances])
    force = np.where(whole, np.stack([balance.force(x, squared) for balance in balances]), np.nan)
    stiffness = np.where(whole, np.stack([balance.slope(x, squared) for balance in balances]), np.nan)
    count = np.array([[len(at) for at in row] for row in found])
    folds = each(lambda balance: balance.folds(), balances)
    rests = each(rest_of, balances, [None] * len(balances))
    pull_in, delivered = _pull_in_variables(balances, rests), _ramp_variables(balances, rests, levels)
    rows = [np.array(at, dtype=float).reshape(-1, 3) for row in found for at in row]
    place, slope, stable = (_padded([at[:, k] for at in rows]).reshape(*count.shape, -1) for k in range(3))
    dims = ("constant_voltage", "equilibrium")
    result = _label(
        model,
        balances,
        dict[str, dataset.Variable]()
        | {
            "force": (("constant_voltage", "displacement"), force, "static force that holds the disc", "force"),
            "stiffness": (("constant_voltage", "displacement"), stiffness, "slope of the static force", "stiffness"),
            "equilibria": (("constant_voltage",), count, "number of equilibria", "count"),
            "equilibrium_displacement": (dims, place, "displacement of the equilibrium", _PLACE),
            "slope": (dims, slope, "slope of the static force at the equilibrium", "stiffness"),
            "stable": (dims, stable == 1.0, "whether the equilibrium is stable", "flag"),
        }
        | _branches(balances, _branch_limit(balances, levels, folds, pull_in["pull_in_voltage"][1]))
        | _pitchfork_variable(balances)
        | _fold_variables(folds)
        | pull_in
        | {name: delivered[name] for name in ("stroke", "blocked_force", "cycle_work")},
        coords={
            "constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage"),
            "displacement": (("displacement",), x, "displacement x = h/(b-a)", "length"),
        },
        title="statics",
    )
    result = _with_validity(result, held.members(), levels, place)
    counted.finish()
    options = json.loads(result.attrs["options"]) | {"voltages": None if voltages is None else levels.tolist()}
    options |= {"displacements": None if displacements is None else x.tolist(), "at_once": at_once}
    return result.assign_attrs(options=json.dumps(options))


def own_levels(model: Ensemble) -> Array:
    """The peaks of the drive and the offsets other than 0, as constant voltages in rising order."""
    offsets = np.abs(np.ravel(model.voltage_bias))
    return np.unique([*np.ravel(model.peak_voltage), *offsets[offsets > 0.0]])


def _with_validity(result: xr.Dataset, members: Members, levels: Array, place: Array) -> xr.Dataset:
    """The state of the films, and which assumptions fail, at the equilibria (members, voltages, equilibria)."""
    held = np.broadcast_to(levels[:, None], place.shape)
    films, n, first = members.system.films, members.numbers(trailing=1), held.reshape(members.size, -1)
    at = place.reshape(members.size, -1, 1)
    voltages = [first, *map(np.sqrt, members.system.squares_at_rest(first**2, n)[1:])]
    with np.errstate(over="ignore", invalid="ignore"):
        states = members.film_states(at, voltages)
    fails = dict(outside(members, at, voltages, states))
    for film, state in zip(films, states, strict=True):
        if kinds := film.kinds:
            found = np.where(np.isnan(place), -1, np.reshape(state.kind, place.shape)).reshape(result["slope"].shape)
            attrs = {"long_name": f"state of {film.words}", "units": "1"}
            attrs |= {"quantity": "flag"} | dataset.flags_of(kinds)
            result[f"{film.prefix}film_state"] = (result["slope"].dims, found.astype(np.int8), attrs)
    lost, before = (result[name].values.reshape(-1, 1, 1) for name in ("pull_in_voltage", "pull_in_from"))
    snaps = (held > lost) & (np.abs(place) > np.abs(before))
    fails["pulled_in"] = snaps.reshape(members.size, -1)
    for name in ASSUMPTIONS:
        found = fails[name].reshape(place.shape) if name in fails else np.full(place.shape, np.nan)
        values = np.where(np.isnan(place), np.nan, found).reshape(result["slope"].shape)
        attrs = {"long_name": f"1 at an equilibrium with {untrue_by(name)}", "units": "1", "quantity": "share"}
        result[f"validity_{name}"] = (result["slope"].dims, values, attrs)
    return result


@for_devices
def pitchfork_voltage(model: Ensemble) -> VoltageArray:
    """Constant voltage at which the flat film, or a raised pair of equal films in its middle, loses its stability.

    Of a single film it is the root of the small-signal stiffness kappa + (A - G)/(1 - (A+B+G-3)/J), or that of another
    film.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.

    Returns
    -------
    Voltages of the ensemble's shape; of a device in volts. NaN where x = 0 is not an equilibrium (``rest_height`` with
    a spring; of two films where they do not rest in their middle), cannot be reached or is unstable without voltage
    already, or where the film pulls in before.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> gelcone.pitchfork_voltage(gelcone.ConeModel(spring_stiffness=[0.5, 1.5])).round(4).tolist()
    [0.7071, 1.2247]
    """
    return _pitchfork_voltages(every_balance(model)).reshape(model.shape)


def _pitchfork_voltages(balances: list[StaticBalance]) -> Array:
    squared = np.array(each(lambda balance: balance.pitchfork(), balances))
    highest = np.array([balance.highest_squared if balance.flat else np.inf for balance in balances])
    with np.errstate(invalid="ignore"):
        exists = (squared >= -ROUNDING) & (squared < highest)
        return np.where(exists, np.sqrt(np.maximum(squared, 0.0)), np.nan)


@for_devices
def fold_voltages(model: Ensemble) -> xr.Dataset:
    """All constant voltages at which two equilibria meet and vanish, and where: the limit points.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.

    Returns
    -------
    Dataset with ``fold_voltage`` and ``fold_displacement`` over the ensemble's dims and ``fold``, in the order of the
    voltage, NaN-padded. Displacements up to the stretch limit are searched, at most 1000.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(hoop_prestretch=1.4, rest_height=0.3, spring_stiffness=0.5)
    >>> found = gelcone.fold_voltages(model)
    >>> found.fold_voltage.values.round(4).tolist(), found.fold_displacement.values.round(4).tolist()
    ([1.217], [-0.5313])
    """
    balances = balances_of(model)
    folds = each(lambda balance: balance.folds(), balances)
    return _label(model, balances, _fold_variables(folds), title="folds of the equilibria")


@for_devices
def pull_in_voltage(model: Ensemble, start: Lengths | None = None) -> xr.Dataset:
    """Compute where the disc jumps or a film pulls in on a slow (quasi-static) voltage ramp from 0.

    A pitchfork from which the disc rises gradually is neither: the ramp follows it (`pitchfork_voltage`).

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.
    start : the ramp starts from the stable equilibrium at v = 0 nearest to this displacement; default the model's
        ``rest_height`` (of two equally near ones the higher).

    Returns
    -------
    Dataset over the ensemble's dims: ``pull_in_voltage`` (infinity if never, NaN where nothing is stable at v = 0);
    ``pull_in_kind``, a `PullIn`; ``pull_in_from``, the displacement there; ``pull_in_to``, where the disc goes: to the
    next stable equilibrium that the force leads to, infinity when there is none, NaN if never. ``rest_displacement`` is
    where the ramp starts.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(film="wrinkling", law="neo-hookean", hoop_prestretch=1.4, rest_height=0.8)
    >>> found = gelcone.pull_in_voltage(model)
    >>> gelcone.PullIn(found.pull_in_kind.item()).name, round(found.pull_in_voltage.item(), 4)
    ('FILM', 0.9312)
    """
    balances = balances_of(model)
    variables = _pull_in_variables(balances, _rests(model, balances, start))
    return _label(model, balances, variables, start=start, title="pull-in")


@for_devices
def stroke_and_blocked_force(model: Ensemble, voltages: Voltages, start: Lengths | None = None) -> xr.Dataset:
    """The output of the actuator at constant voltages reached on a slow ramp from 0: stroke and blocked force.

    Parameters
    ----------
    model : one actuator or an ensemble; its own drive plays no part.
    voltages : constant voltages v, at least 0, one or several.
    start : as in `pull_in_voltage`.

    Returns
    -------
    Dataset over the ensemble's dims and ``constant_voltage``: ``displacement`` of the disc and its ``stroke`` from
    ``rest_displacement``, on the branch that the ramp follows and past its end on the one it goes to (after a pitchfork
    the positive one), NaN where it goes to infinity; ``losses``, how many losses of stability the ramp has passed;
    ``blocked_force``, what the voltage adds to the force (v^2 x in the cone), with which the disc pushes (away from the
    flat film) on a stop that holds it where it rests without voltage; ``cycle_work``, the largest work on a load in a
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
    variables = _ramp_variables(balances, _rests(model, balances, start), levels)
    return _label(
        model,
        balances,
        variables,
        coords={"constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage")},
        start=start,
        title="stroke and blocked force",
    )


class Ramp(NamedTuple):
    """A slow ramp of a drive from rest: ``displacement``, ``stroke``, ``blocked_force`` and ``stiffness`` at constant
    voltages, (voltages,), the constant ``voltages`` on each film; and the voltages of its ``pitchfork`` and of its
    first jump or ``pull_in``, infinite if never."""

    rest: float
    displacement: Array
    stroke: Array
    blocked_force: Array
    stiffness: Array
    voltages: list[Array]
    pitchfork: float
    pull_in: float


def drive_ramp(balance: StaticBalance, levels: Array) -> Ramp:
    """The ramp of a single model's drive at the ``levels``."""
    squared, rest = levels**2, rest_of(balance, None)
    x = balance.along_ramp(rest, squared)[0]
    stiffness = np.where(balance.whole(x, squared), balance.slope(x, squared), np.nan)
    (pitchfork,) = _pitchfork_voltages([balance])
    return Ramp(
        rest,
        x,
        x - rest,
        balance.voltage_force(rest, squared) + 0.0,
        stiffness,
        [np.sqrt(own) for own in balance.system.squares_at_rest(squared, balance.n)],
        float(np.nan_to_num(pitchfork, nan=np.inf)),
        balance.jump(rest).voltage,
    )


def _ramp_variables(balances: list[StaticBalance], rests: list[float], levels: Array) -> dict[str, dataset.Variable]:
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
    """The area between the forces without and with a voltage from the rest to where the ramp goes, (members, voltages).

    A load takes it up in a cycle that pushes it out under the voltage and takes it back without one.
    """
    work = np.full(place.shape, np.nan)
    for member, (balance, rest) in enumerate(zip(balances, rests, strict=True)):
        for k in np.flatnonzero(np.isfinite(place[member])):
            x, weights = on_the_way(rest, place[member, k])
            work[member, k] = float(balance.voltage_force(x, np.full(x.shape, levels[k] ** 2)) @ weights)
    return work


def on_the_way(begin: float, end: float) -> tuple[Array, Array]:
    """Displacements between two, and the weights with which forces there add up to their work."""
    nodes, weights = np.polynomial.legendre.leggauss(WORK_NODES)
    panels = (0.5 + 0.5 * nodes + np.arange(WORK_PANELS)[:, None]).ravel() / WORK_PANELS
    return begin + (end - begin) * panels, (end - begin) * np.tile(0.5 * weights / WORK_PANELS, WORK_PANELS)


def _label(
    model: Ensemble,
    balances: list[StaticBalance],
    variables: dict[str, dataset.Variable],
    *,
    coords: dict[str, dataset.Variable] | None = None,
    start: npt.ArrayLike | None = None,
    title: str,
) -> xr.Dataset:
    options = {"search_range": SEARCH_RANGE, "start": None if start is None else np.asarray(start).tolist()}
    outcome = [Outcome.OK if balance.reachable else Outcome.OUTSIDE for balance in balances]
    return dataset.label(model, variables, coords=coords, outcome=outcome, options=options, title=title)


def constant_voltages(voltages: npt.ArrayLike) -> Array:
    """Constant voltages as an array, (voltages,); `InputError` for what is not one or below 0."""
    try:
        levels = np.atleast_1d(np.asarray(VOLTAGE["voltage"].check("voltages", voltages), dtype=float))
    except InputError as error:
        refused = str(error).partition("; its default is")[0]
        remedy = "; leave out the sign, on which no force depends" * refused.endswith("must be at least 0")
        raise InputError(refused + remedy) from None
    if levels.ndim > 1:
        raise InputError(f"voltages has the shape {levels.shape}: must be a number or one-dimensional; ravel it")
    return levels


def _wanted(displacements: npt.ArrayLike, balances: list[StaticBalance]) -> Array:
    x = np.atleast_1d(np.asarray(displacements, dtype=float))
    if x.ndim > 1 or x.size == 0 or not np.isfinite(x).all() or (np.diff(x) <= 0.0).any():
        raise InputError(f"displacements = {np.asarray(displacements).tolist()}: must be finite and increasing")
    if not any(balance.inside(x).any() for balance in balances):
        highest = max(balance.highest for balance in balances if balance.reachable)
        raise InputError(f"displacements from {x[0]:g} to {x[-1]:g}: none is reached; stay within {highest:.6g}")
    return x


def _rests(model: Ensemble, balances: list[StaticBalance], start: npt.ArrayLike | None) -> list[float]:
    """Where the slow ramp of each starts: the rest nearest to ``start``."""
    return each(rest_of, balances, _starts(model, start))


def _starts(model: Ensemble, start: npt.ArrayLike | None) -> list[float | None]:
    if start is None:
        return [None] * model.size
    try:
        values = np.broadcast_to(np.asarray(start, dtype=float), model.shape).ravel()
    except (TypeError, ValueError):
        raise InputError(f"start = {start!r}: must be a displacement, or one a member (shape {model.shape})") from None
    if not np.isfinite(values).all():
        raise InputError(f"start = {values[~np.isfinite(values)][0]:g}: must be finite")
    return [float(value) for value in values]


def _force_range(balances: list[StaticBalance], found: list[list[list[Equilibrium]]]) -> Array:
    """Even displacements around all equilibria and rest heights, or up to 1, as far as any member reaches."""
    farthest = max((abs(e.displacement) for row in found for at in row for e in at), default=0.0)
    rests = max(abs(balance.free_height) for balance in balances)
    wanted = 1.4 * max(farthest, rests, 1.0 if farthest == 0.0 else 0.0)
    reached = max(0.995 * balance.highest for balance in balances if balance.reachable)
    return np.linspace(-1.0, 1.0, FORCE_SAMPLES) * min(wanted, reached)


def _padded(rows: Sequence[Array]) -> Array:
    """Rows of different lengths as one array with at least one column, NaN behind each."""
    longest = max(1, *(len(row) for row in rows))
    return np.stack([np.concatenate([row, np.full(longest - len(row), np.nan)]) for row in rows])


def _fold_variables(folds: list[list[tuple[float, float]]]) -> dict[str, dataset.Variable]:
    rows = [np.array(own).reshape(-1, 2) for own in folds]
    voltage, place = (_padded([row[:, k] for row in rows]) for k in range(2))
    return {
        "fold_voltage": (("fold",), voltage, "voltage at which two equilibria meet in a fold", _FOLD),
        "fold_displacement": (("fold",), place, "displacement of the fold", _PLACE),
    }


def _pitchfork_variable(balances: list[StaticBalance]) -> dict[str, dataset.Variable]:
    voltage = _pitchfork_voltages(balances)
    place = np.array([0.5 * balance.flat_height for balance in balances])
    return {
        "pitchfork_voltage": ((), voltage, PITCHFORK, dataset.absent("voltage")),
        "pitchfork_displacement": (
            (),
            np.where(np.isnan(voltage), np.nan, place),
            "displacement that is left in the pitchfork",
            dataset.absent("length"),
        ),
    }


def jump_voltages(model: Ensemble) -> tuple[Array, Array]:
    """Constant voltage at which each member jumps or pulls in on a slow ramp from rest, (members,), infinite if never;
    and how, a `PullIn`. A pitchfork that continues smoothly is neither."""
    balances = balances_of(model)
    lost = each(lambda balance, rest: balance.jump(rest), balances, each(rest_of, balances, [None] * len(balances)))
    return np.array([loss.voltage for loss in lost]), np.array([loss.kind for loss in lost], dtype=np.int8)


def _pull_in_variables(balances: list[StaticBalance], rests: list[float]) -> dict[str, dataset.Variable]:
    lost = each(lambda balance, rest: balance.jump(rest), balances, rests)
    voltage, kind, before, after = (np.array([row[k] for row in lost]) for k in range(4))
    return {
        "rest_displacement": ((), np.array(rests), "stable equilibrium without voltage", "length"),
        "pull_in_voltage": ((), voltage, PULL_IN, dataset.absent("voltage")),
        "pull_in_kind": ((), kind.astype(np.int8), PULL_IN_KIND, PullIn),
        "pull_in_from": ((), before, "displacement at which the disc jumps or the film pulls in", _FROM),
        "pull_in_to": ((), after, "displacement that the disc jumps to", _TO),
    }


def _branch_limit(
    balances: list[StaticBalance], levels: Array, folds: list[list[tuple[float, float]]], pull_in: Array
) -> float:
    """Highest voltage to which the branches are traced: past all that happens and all that was asked for."""
    events = [float(v) for v in pull_in if np.isfinite(v)] + [v for own in folds for v, _ in own]
    events += [math.sqrt(w) for balance in balances if balance.flat and (w := balance.pitchfork()) > 0.0]
    return max(1.2 * float(levels.max()), 1.5 * max(events, default=0.0), 1e-3)


def _branches(balances: list[StaticBalance], highest: float) -> dict[str, dataset.Variable]:
    traced = [_with_gaps(balance.curves(highest)) for balance in balances]
    place, voltage, slope = (_padded([t[k] for t in traced]) for k in range(3))
    dims = ("branch_point",)
    return {
        "branch_displacement": (dims, place, "displacement along the equilibria", "length"),
        "branch_voltage": (dims, voltage, "constant voltage along the equilibria", "voltage"),
        "branch_slope": (dims, slope, "slope of the static force along the equilibria", "stiffness"),
    }


def _with_gaps(curves: list[Array]) -> Array:
    """Rows of curves, one behind the other, parted by NaN."""
    gap = np.full((3, 1), np.nan)
    return np.concatenate([gap, *(piece for curve in curves for piece in (curve, gap))], axis=1)
