"""Statics: force over displacement, equilibria and their branches under constant voltages.

`gelcone.physics.balance` explains how equilibria are found.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.ramp import ramp_variables
from gelcone.motion.static_bifurcations import fold_variables, pitchfork_variable, pull_in_variables
from gelcone.motion.static_results import PLACE, constant_voltages, label_static, own_levels, padded
from gelcone.motion.validity import ASSUMPTIONS, outside, untrue_by
from gelcone.physics.balance import Equilibrium, StaticBalance, rest_of
from gelcone.physics.commanded import rest_at_command
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.film.film import FilmState
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.pair import PairBalance
from gelcone.physics.statics import balances_of, each
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, Lengths, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE, Axis

if TYPE_CHECKING:
    import xarray as xr

FORCE_SAMPLES = 401
FAR = 100.0
"""Bifurcations above this multiple of the highest voltage given, or of the unit of voltage, are not traced to."""


@analysis(
    axes={"voltages": CONSTANT_VOLTAGE, "displacements": Axis("displacement", "displacement", least=1)},
    answers="statics",
    examples=(
        "--set spring_stiffness=1.5 --over constant_voltage=0,1,1.5 --out results",
        'paper-table1 --over "constant_voltage=0 kV:10 kV:11" --json',
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
    """Compute force over displacement, equilibria, branches, pitchfork, folds and pull-in under constant voltages.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive only gives the default of ``voltages``.
    voltages : constant commanded voltages v, at least 0, one or several: ``constant_voltage`` of the result and of
        ``--over``. Default the peak of the drive and, where it has one, its offset. In opposite phase about a bias v0
        of their sign the second film has 2 v0 - v, and the default is the peak of that sign. With a commanded charge
        they are the voltages that it gives the flat film.
    displacements : increasing x at which the force is given; default 401 even ones around all equilibria.
    at_once : of a film that creeps, before its branches have relaxed: the first stroke of a step, the blocked force
        of a fast one. Default the film that has relaxed.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims, ``constant_voltage``, ``displacement`` and ``equilibrium`` (padded with NaN;
    ``equilibria`` counts them). ``force`` holds the disc at x and ``stiffness`` is its slope, both NaN beyond the
    stretch limit and where a film held at x has pulled in. ``slope`` is that of the force at
    ``equilibrium_displacement``, which is ``stable`` where the energy has a minimum, and ``film_state`` the state of a
    wrinkling film there. Where films do not rest at the commanded voltage, as one that leaks behind a resistance,
    ``film_voltage`` is that on the film; ``second_film_voltage`` also is that of a second film in opposite phase, or
    with a constant voltage. In opposite phase a slow ramp raises both films to ``ramp_begin_voltage`` first.
    ``branch_displacement``, ``branch_voltage`` and ``branch_slope`` trace the
    equilibria over the voltage, pieces parted by NaN, beyond all folds and other bifurcations within 100 times the
    voltages given, with the folds among the points; ``branch_fails`` says where an assumption of the model fails.
    ``pitchfork_voltage``, ``pitchfork_displacement``, ``fold_voltage``, ``fold_displacement`` and pull-in are those of
    `pitchfork_voltage`, `fold_voltages` and `pull_in_voltage`; ``stroke``, ``blocked_force`` and ``cycle_work`` on a
    slow voltage ramp those of `stroke_and_blocked_force`. ``validity_*`` are 1 at an equilibrium where an assumption
    of the model fails (`gelcone.motion.validity.ASSUMPTIONS`), 0 elsewhere, NaN where it is unknown; an equilibrium
    beyond the displacement from which a slow ramp jumps counts as pulled in. The ``outcome`` of a member is
    ``outside`` where its pre-stretch exceeds the stretch limit at every displacement.

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
    ensemble = films_at_once(model) if at_once else model
    balances = balances_of(ensemble)
    counted = Counted(progress)
    equilibria = []
    for balance in balances:
        equilibria.append(balance.equilibria(levels**2))
        counted(0.7 / len(balances))
    x = _force_range(balances, equilibria) if displacements is None else _wanted(displacements, balances)
    squared = levels[:, None] ** 2
    whole = np.stack([balance.whole(x, squared) for balance in balances])
    held_by = zip(*(balance.force_and_slope(x, squared) for balance in balances), strict=True)
    force, stiffness = (np.where(whole, np.stack(parts), np.nan) for parts in held_by)
    count = np.array([[len(at) for at in row] for row in equilibria])
    folds = each(lambda balance: balance.folds(), balances)
    rests = each(rest_of, balances, [None] * len(balances))
    pull_in = pull_in_variables(balances, rests, model.system)
    delivered = ramp_variables(balances, rests, levels)
    rows = [np.array(at, dtype=float).reshape(-1, 3) for row in equilibria for at in row]
    place, slope, stable = (padded([at[:, k] for at in rows]).reshape(*count.shape, -1) for k in range(3))
    dims = ("constant_voltage", "equilibrium")
    result = label_static(
        model,
        balances,
        dict[str, dataset.Variable]()
        | {
            "force": (("constant_voltage", "displacement"), force, "static force that holds the disc", "force"),
            "stiffness": (("constant_voltage", "displacement"), stiffness, "slope of the static force", "stiffness"),
            "equilibria": (("constant_voltage",), count, "number of equilibria", "count"),
            "equilibrium_displacement": (dims, place, "displacement of the equilibrium", PLACE),
            "slope": (dims, slope, "slope of the static force at the equilibrium", "stiffness"),
            "stable": (dims, stable == 1.0, "whether the equilibrium is stable", "flag"),
        }
        | _branches(balances, _branch_limit(balances, levels, folds, pull_in["pull_in_voltage"][1]))
        | pitchfork_variable(balances)
        | fold_variables(folds)
        | pull_in
        | _begins(balances)
        | {name: delivered[name] for name in ("stroke", "blocked_force", "cycle_work")},
        coords={
            "constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage"),
            "displacement": (("displacement",), x, "displacement x = h/(b-a)", "length"),
        },
        title="statics",
    )
    result = _with_validity(result, ensemble.members(), balances, levels, place)
    counted.finish()
    options = json.loads(result.attrs["options"]) | {"voltages": None if voltages is None else levels.tolist()}
    options |= {"displacements": None if displacements is None else x.tolist(), "at_once": at_once}
    return result.assign_attrs(options=json.dumps(options))


def _begins(balances: list[StaticBalance]) -> dict[str, dataset.Variable]:
    """The voltage of both films in opposite phase, from which the ramp of the first begins."""
    pairs = [balance for balance in balances if isinstance(balance, PairBalance)]
    if not pairs or not pairs[0].system.in_opposite_phase:
        return {}
    meaning = "voltage of both films from which a slow ramp of the first begins"
    return {"ramp_begin_voltage": ((), np.array([pair.bias for pair in pairs]), meaning, "voltage")}


def _with_validity(
    result: xr.Dataset, members: Members, balances: list[StaticBalance], levels: Array, place: Array
) -> xr.Dataset:
    """Adds the state of the films and the assumptions that fail at the equilibria (members, voltages, equilibria)."""
    films, flat = members.system.films, (members.size, -1)
    held = np.broadcast_to(levels[:, None], place.shape).reshape(flat)
    voltages, states, fails = _failing(result, members, balances, held, place.reshape(flat))
    follow = rest_at_command(members.system, members.numbers())
    slope, nowhere = result["slope"], np.isnan(place).reshape(flat)

    def add(name: str, values: Any, attrs: dict[str, Any], missing: Any = np.nan) -> None:
        filled = np.where(nowhere, missing, values).reshape(slope.shape)
        result[name] = (slope.dims, filled, attrs)

    for film, voltage in zip(films, voltages, strict=True):
        if not follow or film.has_other_voltage:
            attrs = {"long_name": f"voltage on {film.words}"} | dataset.absent("voltage", nan="none")
            add(f"{film.prefix}film_voltage", voltage, attrs)
    for film, state in zip(films, states, strict=True):
        if film.kinds:
            attrs = dataset.attributes(f"state of {film.words}", "flag") | dataset.flags_of(film.kinds)
            add(f"{film.prefix}film_state", state.kind.astype(np.int8), attrs, np.int8(-1))
    for name in ASSUMPTIONS:
        attrs = dataset.attributes(f"1 at an equilibrium with {untrue_by(name)}", "share")
        add(f"validity_{name}", fails.get(name, np.nan), attrs)
    branch, at = result["branch_voltage"], result["branch_displacement"].values.reshape(flat)
    _, _, fails = _failing(result, members, balances, np.nan_to_num(branch.values).reshape(flat), at)
    attrs = dataset.attributes("whether an assumption of the model fails along the equilibria", "flag")
    any_fails = np.any([*fails.values()], axis=0) & np.isfinite(at)
    result["branch_fails"] = (branch.dims, any_fails.reshape(branch.shape), attrs)
    return result


def _failing(
    result: xr.Dataset, members: Members, balances: list[StaticBalance], held: Array, place: Array
) -> tuple[list[Array], list[FilmState], dict[str, npt.NDArray[np.bool_]]]:
    """Voltages on the films, their states, and masks of the assumptions that fail by name, at equilibria (members,
    points) at the commanded voltages ``held``."""
    squares = [balance.films(*at) for balance, *at in zip(balances, place, held**2, strict=True)]
    voltages = [np.sqrt(np.stack(own)) for own in zip(*squares, strict=True)]
    with np.errstate(over="ignore", invalid="ignore"):
        states = members.film_states(place[..., None], voltages)
    fails = dict(outside(members, place[..., None], voltages, states))
    lost, before = (result[name].values.reshape(-1, 1) for name in ("pull_in_voltage", "pull_in_from"))
    fails["pulled_in"] = (held > lost) & (np.abs(place) > np.abs(before))
    return voltages, states, fails


def _wanted(displacements: npt.ArrayLike, balances: list[StaticBalance]) -> Array:
    x = np.atleast_1d(np.asarray(displacements, dtype=float))
    if x.ndim > 1 or x.size == 0 or not np.isfinite(x).all() or (np.diff(x) <= 0.0).any():
        raise InputError(f"displacements = {np.asarray(displacements).tolist()}: must be finite and increasing")
    if not any(balance.inside(x).any() for balance in balances):
        highest = max(balance.highest for balance in balances if balance.reachable)
        raise InputError(f"displacements from {x[0]:g} to {x[-1]:g}: none is reached; stay within {highest:.6g}")
    return x


def _force_range(balances: list[StaticBalance], found: list[list[list[Equilibrium]]]) -> Array:
    """Even displacements around all equilibria and rest heights, or up to 1, as far as any member reaches."""
    farthest = max((abs(e.displacement) for row in found for at in row for e in at), default=0.0)
    rests = max(abs(balance.free_height) for balance in balances)
    wanted = 1.4 * max(farthest, rests, 1.0 if farthest == 0.0 else 0.0)
    reached = max(0.995 * balance.highest for balance in balances if balance.reachable)
    return np.linspace(-1.0, 1.0, FORCE_SAMPLES) * min(wanted, reached)


def _branch_limit(
    balances: list[StaticBalance], levels: Array, folds: list[list[tuple[float, float]]], pull_in: Array
) -> float:
    """Highest voltage to which branches are traced: beyond all given voltages, and all bifurcations within `FAR`."""
    events = [*map(float, pull_in)] + [v for member_folds in folds for v, _ in member_folds]
    events += [math.sqrt(w) for balance in balances if balance.flat and (w := balance.pitchfork()) > 0.0]
    given = float(levels.max())
    near = [v for v in events if v < FAR * max(given, 1.0)]
    return max(1.2 * given, 1.5 * max(near, default=0.0), 1e-3)


def _branches(balances: list[StaticBalance], highest: float) -> dict[str, dataset.Variable]:
    traced = [_with_gaps(balance.curves(highest)) for balance in balances]
    place, voltage, slope = (padded([t[k] for t in traced]) for k in range(3))
    dims = ("branch_point",)
    return {
        "branch_displacement": (dims, place, "displacement along the equilibria", "length"),
        "branch_voltage": (dims, voltage, "constant voltage along the equilibria", "voltage"),
        "branch_slope": (dims, slope, "slope of the static force along the equilibria", "stiffness"),
    }


def _with_gaps(curves: list[Array]) -> Array:
    """Rows of curves, one after the other, separated by NaN."""
    gap = np.full((3, 1), np.nan)
    return np.concatenate([gap, *(piece for curve in curves for piece in (curve, gap))], axis=1)
