"""Frequency response at full drive, by sweeps up and down: resonances, jumps and motions that are not periodic.

The linear response to the same drive is reported, too; it is exact in the limit of small drives. Branches of periodic
orbits complete the sweeps by the unstable part between two jumps, and by motions that lie apart from both sweeps.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.branches.attached import attach
from gelcone.atlas.branches.check import Runs
from gelcone.atlas.branches.continuation import continue_branch
from gelcone.atlas.hysteresis import BRANCHES, jump_variables, jumps_of_sweeps
from gelcone.atlas.resonance import Peaks, highest_peaks
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, check_one
from gelcone.errors import InputError
from gelcone.motion.attractor.cycle import REST_TOLERANCE
from gelcone.motion.attractor.search import integration
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.linear import linear_peak, linear_response, quantity_of_stroke
from gelcone.motion.natural import natural_frequency
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import start_states
from gelcone.motion.state_space import equilibrium_under_bias
from gelcone.motion.stepping import NUDGE, Falls, Trail, walk
from gelcone.motion.swing import HARMONICS, Swing, settled_swing, swing
from gelcone.motion.validity import validity_variables
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Frequencies, Time
from gelcone.register.analysis import Axis

if TYPE_CHECKING:
    import xarray as xr

SPAN = (0.1, 3.0, 81)
"""Default frequencies over the natural one: first, last, number."""
FILLED = 7
"""Frequencies that are added in an interval next to a bend."""
BENT = 0.01
"""Distance of a stroke from the line between its neighbours, over the largest stroke, at which the response bends."""
OfSweeps = TypeVar("OfSweeps", Swing, Peaks)
AT_ONCE = 512
"""Motions whose samples are in memory at a time."""
STARTS = (1.0, 0.05, -1.0)
"""Multiples of the initial state from which motions settle that start further branches."""
SWEEPS_SHARE = 0.6
"""Share of the progress for the sweeps where branches follow."""
FILLED_SHARE = 0.4
"""Share of the progress for the frequencies added where the response bends."""


@analysis(
    axes={"frequencies": Axis("drive_frequency", "frequency", replaces=True, one="settled")},
    answers="frequency",
    drawn=True,
    file_only=("followed_orbit",),
    single=True,
    examples=(
        "biased-pump",
        'biased-pump --over "frequency=4 Hz:20 Hz:80" --out results',
        "--preset spring --set spring_stiffness=0.1 --over drive_frequency=0.2:1:81 --json",
    ),
)
def frequency(
    model: ConeModel,
    frequencies: Frequencies | None = None,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    branches: bool = False,
    transient: Time | None = None,
    patience: Time | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """The settled motion over drive frequency, in a sweep up and one down, each from the last state of the one before.

    A motion is followed as long as its cycle attracts, as in a sweep without noise that is slow enough.

    Parameters
    ----------
    model : one actuator, or an ensemble of one dimension, with damping; the frequencies replace its own.
    frequencies : angular drive frequencies, positive and increasing, at least two. Shape (frequencies,), or (members,
        frequencies) for members with frequencies of their own. Default 81 for one actuator, evenly on a log scale, from
        a tenth to three times its natural frequency under the bias, and more where the stroke bends.
    initial : displacement and velocity from which each sweep starts, shape (2,) or (members, 2). Default (1, 0).
    branches : whether branches of periodic orbits, stable and unstable, are followed too; see `continue_branch`; of
        one actuator. Default no.
    transient, patience : as in `settled`.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dim, ``branch`` (up, down) and ``drive_frequency`` (for frequencies of the members' own:
    ``step``, with ``swept_frequency`` over both), with

    * ``lowest``, ``highest``, ``stroke`` (between them) and ``amplitude`` (half of that) of the displacement;
      ``period`` in forcing periods: 1 where the motion follows the drive, more for subharmonics, 0 where the disc is
      ``resting``, and where none up to 64 was found (chaos, or not settled); ``outcome``; and ``validity_*`` as in
      `regime`;
    * over ``harmonic``, multiples of the drive frequency: ``harmonic_amplitude`` and ``harmonic_phase`` in degrees
      ahead of sin(harmonic omega t), where the voltage is sin(omega t);
    * over ``branch``, its highest peak: ``peak_frequency`` between ``peak_low`` and ``peak_high``, ``peak_amplitude``
      and ``peak_amplitude_error``; NaN for a disc that rests at every frequency;
    * over ``jump``, each end of a range in which the sweeps differ: ``jump_branch``, the sweep that jumps there,
      between the frequencies ``jump_low`` and ``jump_high``, from the stroke ``jump_from`` to ``jump_to``;
      for an ensemble also ``jump_member``, its index;
    * with branches: what `continue_branch` gives, with ``followed_`` before each name; over ``start`` and the frequency
      ``fixed_stroke``, that of settled motions from ``initial``, a twentieth of it and its mirror image, which are
      seeds of branches like the sweeps; and over ``jump`` the bifurcation behind each, ``jump_event`` (its frequency)
      and ``jump_event_kind`` (NaN and -1 where there is none);
    * the linear response to the same drive: ``linear_stroke``, ``linear_amplitude`` and ``linear_phase`` over
      ``harmonic``, see `gelcone.motion.linear.linear_response`; NaN where there is no equilibrium. The stroke is that
      of all harmonics of the drive, and NaN where these are more than some 700,000. ``linear_peak_stroke`` is its
      largest value, also between the frequencies, at ``linear_peak_frequency``.

    Raises
    ------
    InputError : for frequencies that do not increase or do not fit, a model without damping, an ensemble of more than
        one dimension or over the drive frequency, branches of an ensemble, or no member inside its stretch limit.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.06, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> response = gelcone.frequency(model, [1.2, 1.4, 1.6])
    >>> response.stroke.sel(branch="up").values.round(4).tolist()
    [0.1189, 0.3371, 0.2285]
    """
    if branches:
        check_one(model, "branches")
    counted = weighted(progress, SWEEPS_SHARE if branches else 1.0)
    grid = _grid(model, _around_resonance(model) if frequencies is None else frequencies)
    flat = model.members()
    members = np.repeat(np.arange(flat.size), len(BRANCHES))
    states = start_states(model, initial)[members]
    both, grids = flat.take(members), grid[members]
    check_budgets(transient=transient, patience=patience)
    search = {"transient": transient, "patience": patience, "tolerance": tolerance, "threads": threads}
    filled = FILLED_SHARE if frequencies is None else 0.0
    first = weighted(counted, 1.0 - filled)
    branch = np.tile(np.arange(len(BRANCHES)), flat.size)
    swept, falls, trail = _sweep(both, branch, grids, states, weighted(first, 0.8), search)
    peaks = highest_peaks(both, trail, falls, weighted(first, 0.15), search)
    jumps = jumps_of_sweeps(flat, grid, _by_branch(swept), falls, weighted(first, 0.05), search)
    options = {"initial": np.asarray(initial, dtype=float).tolist(), "nudge": NUDGE} | search
    del options["threads"]
    shared = frequencies is None or np.ndim(frequencies) < 2
    if frequencies is None:
        grids, swept = _bends_filled(both, grids, swept, states, weighted(counted, filled), search)
        grid = grids[:1]
    result = _label(model, grid, shared, _by_branch(swept), peaks, options)
    result = result.assign(jump_variables(jumps, bool(model.shape)))
    if not branches:
        return result
    return _with_branches(model, result, _by_branch(swept), states[:1], weighted(progress, 1.0 - SWEEPS_SHARE), search)


def _around_resonance(model: ConeModel) -> Array:
    """The default frequencies of one actuator."""
    if model.shape:
        raise InputError("frequencies: an ensemble has no default; give them")
    bias = float(model.offset_voltage)
    natural = natural_frequency(model, bias, equilibrium_under_bias(model, bias))
    return np.asarray(natural * np.geomspace(*SPAN))


def _grid(model: ConeModel, frequencies: npt.ArrayLike) -> Array:
    """The checked frequencies of every member, (members, frequencies)."""
    if len(model.shape) > 1:
        raise InputError(f"a frequency response takes an ensemble of one dimension, not of shape {model.shape}")
    if np.ndim(model.drive_frequency):
        raise InputError("drive_frequency: is what is swept; give the model a single one")
    if not (np.asarray(model.damping_ratio) > 0.0).all():
        raise InputError("damping_ratio = 0: without damping no motion settles; give it some")
    try:
        omega = np.asarray(frequencies, dtype=float)
        grid = np.broadcast_to(omega, (model.size, omega.shape[-1] if omega.ndim else 0))
    except (TypeError, ValueError):
        raise InputError(
            f"frequencies: must be numbers of shape (frequencies,) or ({model.size}, frequencies)"
        ) from None
    if omega.ndim > 2 or grid.shape[1] < 2:
        raise InputError(f"frequencies: has {grid.shape[1]} and takes at least 2; `settled` answers at a single one")
    if not np.isfinite(grid).all() or not (grid > 0.0).all() or not (np.diff(grid, axis=1) > 0.0).all():
        raise InputError("frequencies: must be positive and increase; sort them and leave out doubles")
    return grid


# --- sweeps -----------------------------------------------------------------------------------------------------------


def _sweep(
    model: Members, branch: Any, grids: Array, initial: Array, progress: Progress, search: dict[str, Any]
) -> tuple[Swing, Falls, Trail]:
    """Swings (members, steps) at the frequencies ``grids``, each member on the ``branch`` of this index; their falls
    before each step; and the trail of all motions on the way."""
    down, steps = branch == BRANCHES.index("down"), np.arange(grids.shape[1])
    order = np.where(down[:, None], steps[::-1], steps)
    walked = walk(model, np.take_along_axis(grids, order, axis=1), initial, progress, search)
    by_frequency = np.arange(model.size)[:, None], order
    swept = walked.reached.take(by_frequency)
    _complete(model, grids, swept, search)
    return swept, walked.falls.take(by_frequency), walked.trail


def _bends_filled(
    model: Members, grids: Array, swept: Swing, initial: Array, progress: Progress, search: dict[str, Any]
) -> tuple[Array, Swing]:
    """Frequencies and swings of an actuator's two sweeps with `FILLED` more in each interval next to a bend of either.

    They start from the motion at the end of the interval where the sweep comes from. The frequencies are evenly spaced
    on a log scale, as those of `_around_resonance`.
    """
    amplitude, log = np.nan_to_num(swept.amplitude), np.log(grids[0])
    off = np.abs(amplitude[:, 1:-1] - 0.5 * (amplitude[:, :-2] + amplitude[:, 2:]))
    bent = (off > BENT * max(amplitude.max(), REST_TOLERANCE)).any(axis=0)
    gaps = np.flatnonzero(np.append(bent, False) | np.insert(bent, 0, False))
    if not gaps.size:
        advance(progress, 1.0)
        return grids, swept
    places = (np.arange(FILLED) + 1.0) / (FILLED + 1.0)
    inner = np.exp(log[gaps, None] + np.diff(log)[gaps, None] * places)
    branch, interval = (part.ravel() for part in np.indices((len(BRANCHES), gaps.size)))
    start = swept.final[branch, gaps[interval] + (branch == BRANCHES.index("down"))]
    start = np.where(np.isnan(start), initial[branch], start)
    inner_swing, *_ = _sweep(model.take(branch), branch, inner[interval], start, progress, search)
    every = np.concatenate([grids[0], inner.ravel()])
    order = np.argsort(every)

    def joined(values: Any, more: Any) -> Any:
        inner_values = more.reshape(len(BRANCHES), -1, *more.shape[2:])
        return np.concatenate([values, inner_values], axis=1)[:, order]

    parts = {name: joined(values, vars(inner_swing)[name]) for name, values in vars(swept).items()}
    return np.tile(every[order], (len(BRANCHES), 1)), Swing(**parts)


def _complete(model: Members, grids: Array, swept: Swing, search: dict[str, Any]) -> None:
    """Sets harmonics and validity of the swings, which are not computed for each try on the way."""
    member, step = np.nonzero(swept.outcome == Outcome.OK)
    for first in range(0, member.size, AT_ONCE):
        at = member[first : first + AT_ONCE], step[first : first + AT_ONCE]
        members = model.take(at[0]).replace(drive_frequency=grids[at])
        motion = swing(members, swept.final[at], swept.period[at], **integration(search))
        swept.harmonics[at], swept.validity[at] = motion.harmonics, motion.validity


def _by_branch(swept: OfSweeps) -> OfSweeps:
    """The swings or peaks (members * branches, ...) with the shape (members, branches, ...)."""
    return replace(swept, **{n: v.reshape(-1, len(BRANCHES), *v.shape[1:]) for n, v in vars(swept).items()})


# --- branches ---------------------------------------------------------------------------------------------------------


def _with_branches(
    model: ConeModel, result: xr.Dataset, swept: Swing, initial: Array, progress: Progress, search: dict[str, Any]
) -> xr.Dataset:
    """The result with branches, seeded by both sweeps and by settled motions from fixed states."""
    grid = result["drive_frequency"].values
    starts = initial * np.array(STARTS)[:, None]
    members = model.members().take(np.zeros(grid.size * len(starts), dtype=int))
    members = members.replace(drive_frequency=np.tile(grid, len(starts)))
    fixed = settled_swing(members, np.repeat(starts, grid.size, axis=0), only_extent=True, **search)
    values = np.tile(grid, len(BRANCHES) + len(starts))
    final = np.concatenate([swept.final[0].reshape(-1, initial.shape[1]), fixed.final])
    period = np.concatenate([swept.period[0].ravel(), fixed.period])
    period[~np.isfinite(final).all(axis=1)] = 0
    runs = Runs(values, final[:, None], period, np.zeros(values.size, dtype=bool), period > 0)
    ends, settings = (grid[0], grid[-1]), integration(search)
    followed = continue_branch(
        model, "drive_frequency", *ends, tuple(initial[0]), start=runs, progress=progress, **settings
    )
    result = attach(result, followed)
    named = dataset.attributes("stroke of the settled motion from a fixed state", "length")
    result["fixed_stroke"] = ("start", "drive_frequency"), 2.0 * fixed.amplitude.reshape(len(starts), -1), named
    return result.assign(_jump_events(result, followed))


def _jump_events(result: xr.Dataset, followed: xr.Dataset) -> dict[str, Any]:
    """The bifurcation at which each sweep jumps: in the bracket of the jump, or at most its width away from it."""
    low, high = result["jump_low"].values, result["jump_high"].values
    at, kinds = followed["event_value"].values, followed["event_kind"].values
    events, codes = np.full(low.size, np.nan), np.full(low.size, -1, dtype=np.int8)
    for k, (below, above) in enumerate(zip(low, high, strict=True)):
        off = np.maximum(np.maximum(below - at, at - above), 0.0)
        near = np.flatnonzero(off <= above - below)
        if near.size:
            best = near[np.lexsort((kinds[near], off[near]))[0]]
            events[k], codes[k] = at[best], kinds[best]
    kind_attributes = followed["event_kind"].attrs
    table: dataset.Table = {
        "jump_event": (events, "drive frequency of the bifurcation behind the jump", "frequency"),
        "jump_event_kind": (codes, "kind of the bifurcation behind the jump, -1 for none", kind_attributes),
    }
    return dataset.columns("jump", table)


# --- labels -----------------------------------------------------------------------------------------------------------


def _label(
    model: ConeModel, grid: Array, shared: bool, swept: Swing, peaks: Peaks, options: dict[str, Any]
) -> xr.Dataset:

    step = "drive_frequency" if shared else "step"
    each, wave, linear_wave = ("branch", step), ("branch", "harmonic", step), ("harmonic", step)
    harmonics, phase = np.moveaxis(swept.harmonics, -1, 2), np.moveaxis(swept.phases, -1, 2)
    members, still = model.members(), (swept.resting | np.isnan(swept.amplitude)).all(axis=-1)
    peaks = Peaks(*(np.where(still, np.nan, values) for values in vars(_by_branch(peaks)).values()))
    linear = linear_response(members, grid)
    linear_frequency, largest = linear_peak(members, grid, np.reshape(linear.stroke, grid.shape))
    of_stroke = quantity_of_stroke(members, linear.stroke, grid)
    lines = np.zeros((len(grid), len(HARMONICS), grid.shape[1]), dtype=complex)
    lines[:, :2] = linear.harmonics
    line_phase = np.where(np.abs(lines) > 0.0, np.degrees(np.angle(lines)), np.nan)
    variables: dict[str, dataset.Variable] = {
        "amplitude": (each, swept.amplitude, "half of what the settled motion covers", "length"),
        "stroke": (each, 2.0 * swept.amplitude, "stroke of the settled motion, peak to peak", "length"),
        "lowest": (each, swept.lowest, "lowest displacement", "length"),
        "highest": (each, swept.highest, "highest displacement", "length"),
        "period": (each, swept.forcing_periods, "period in forcing periods, 0 if none", "count"),
        "resting": (each, swept.resting.astype(np.int8), "1 if the disc is at rest", "code"),
        "harmonic_amplitude": (wave, np.abs(harmonics), "amplitude of a harmonic of the drive", "length"),
        "harmonic_phase": (wave, phase, "phase of the harmonic ahead of the voltage's", "angle"),
        "linear_stroke": ((step,), linear.stroke, "stroke by linear theory", of_stroke),
        "linear_peak_frequency": ((), linear_frequency, "drive frequency of the largest linear stroke", "frequency"),
        "linear_peak_stroke": ((), largest, "largest stroke by linear theory", "length"),
        "linear_amplitude": (linear_wave, np.abs(lines), "amplitude of a harmonic by linear theory", "length"),
        "linear_phase": (linear_wave, line_phase, "phase of the harmonic by linear theory", "angle"),
        "peak_frequency": (("branch",), peaks.frequency, "drive frequency of the highest peak", "frequency"),
        "peak_low": (("branch",), peaks.low, "the peak lies above this frequency", "frequency"),
        "peak_high": (("branch",), peaks.high, "the peak lies below this frequency", "frequency"),
        "peak_amplitude": (("branch",), peaks.amplitude, "amplitude at the peak", "length"),
        "peak_amplitude_error": (("branch",), peaks.error, "error of the amplitude at the peak", "length"),
    }
    variables |= validity_variables(swept.validity, swept.outcome, model.system, each)
    over = grid[0] if shared else grid
    coords: dict[str, dataset.Variable] = {
        "drive_frequency" if shared else "swept_frequency": ((step,), over, "drive frequency", "frequency"),
    }
    result = dataset.label(model, variables, coords=coords, options=options, title="frequency response")
    outcome = swept.outcome if model.shape else swept.outcome[0]
    result["outcome"] = dataset.outcome_array(outcome, (*dataset.member_dims(model), *each))
    return result.assign_coords(branch=("branch", list(BRANCHES), dataset.attributes("direction of the sweep", "code")))
