"""Poincare sections: the motion seen once every repeat of the drive, or at its turning points.

Between two repeats the drive looks the same, so a run goes on with the clock set back to 0 at whole repeats: the
phase of the drive stays as exact after a million repeats as in the first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.dataset import with_initial
from gelcone.errors import InputError
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.response import start_states
from gelcone.physics.dual import derivative
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, split_progress, weighted
from gelcone.quantity import Array, check_count

if TYPE_CHECKING:
    import xarray as xr

CLOCK_REPEATS = 1000
"""Most repeats between two returns of the clock to 0."""
CLOCK_SAMPLES = 8192
"""Most samples between them, which bounds the memory of a densely sampled run."""
SAMPLES_PER_OSCILLATION = 32
MOST_PER_REPEAT = 2**16
BLOCK_SAMPLES = 2**22
"""Most samples of an ensemble held at once; a larger one is gone through in blocks of members."""
STILL = 1e-12
"""Motion smaller than this (in units of b-a and 1/Omega0) is rounding, not motion."""
VELOCITY_LEFT = 1e-11
SMALL_STEP = 1e-3
"""A last step up to this share of the samples' spacing is taken by the Taylor expansion of the flow."""
MOST_POLISHINGS = 60


def section(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    repeats: int = 500,
    discard: int = 200,
    phase: float = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Stroboscopic Poincare section: displacement and velocity once every repeat of the drive.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    repeats : points to keep, one a drive repeat (pi/omega for a pure sine, as the force goes with the square of the
        voltage; 2 pi/omega with a bias). Default 500.
    discard : repeats to let pass before, until the motion has settled. Default 200.
    phase : where in the repeat the points are taken, from 0 (the voltage's sine starts) up to but not including 1.
        Default 0.
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims and ``repeat`` (numbered from the start of the run) with ``displacement`` and
    ``velocity`` at ``time``; NaN from where a member failed.

    Raises
    ------
    InputError : for no repeats, a negative discard, a phase outside [0, 1), or an initial state of which no member
        lies inside its stretch limit.
    """
    check_count("repeats", repeats, 1)
    check_count("discard", discard, 0)
    phase = _checked_phase(phase)
    states0 = start_states(model, initial)
    settling, sampling = split_progress(progress, discard, repeats)
    states, settled = settle(model, states0, discard, tolerance=tolerance, threads=threads, progress=settling)
    points = np.full((model.size, repeats, 2), np.nan)
    outcome = settled
    for piece in pieces(
        model, states, repeats, [phase], outcome=settled, tolerance=tolerance, threads=threads, progress=sampling
    ):
        points[:, piece.first : piece.first + piece.repeats] = piece.states[:, :-1]
        outcome = piece.outcome
    numbers = discard + np.arange(repeats)
    times = (numbers + phase) * repeat_of(model)[:, None]
    shared = bool((times == times[0]).all())
    result = dataset.label(
        model,
        {
            "displacement": (("repeat",), points[..., 0], "displacement x = h/(b-a)", "length"),
            "velocity": (("repeat",), points[..., 1], "velocity of the disc", "velocity"),
        },
        coords={
            "repeat": (("repeat",), numbers, "drive repeats since the start", "count"),
            "time": (("repeat",), times[0] if shared else times, "time", "time"),
        },
        outcome=outcome,
        options={"repeats": repeats, "discard": discard, "phase": phase, "tolerance": tolerance},
        title="Poincare section",
    )
    return with_initial(result, model, states0)


def extrema(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    repeats: int = 200,
    discard: int = 200,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Section at zero velocity: the maxima and minima of the displacement, with their times.

    The velocity's sign changes are bracketed by at least `SAMPLES_PER_OSCILLATION` samples an oscillation of film and
    spring (at most 65,536 a repeat), and every one is polished by integrating to it anew until the velocity left is
    below 1e-11 or the time's rounding. Two extrema closer together than the samples may be missed as a pair.

    Parameters
    ----------
    model, initial, tolerance, threads, progress : as in `section`.
    repeats : length of the run in drive repeats. Default 200.
    discard : repeats to let pass before. Default 200.

    Returns
    -------
    Dataset over the ensemble's dims and ``extremum``, in the order of time and padded with NaN where members differ in
    number: ``displacement``, ``velocity`` (what polishing left of it), ``time`` since the start, ``phase`` within the
    drive repeat (0 to 1, as exact late as early), ``maximum`` (1: a maximum, -1: a minimum, 0: padding); and ``count``.

    Raises
    ------
    InputError : for no repeats, a negative discard, or an initial state of which no member lies inside its stretch
        limit.
    """
    check_count("repeats", repeats, 1)
    check_count("discard", discard, 0)
    states0 = start_states(model, initial)
    outcome = np.zeros(model.size, dtype=np.int8)
    found = []
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    for (samples,), members in blocks(samples_per_repeat(model, SAMPLES_PER_OSCILLATION)):
        part = model.members().take(members)
        settling, sampling = split_progress(progress, discard, repeats, share=members.size / model.size)
        states, settled = settle(part, states0[members], discard, progress=settling, **flow)
        shares = np.arange(samples) / samples
        for piece in pieces(part, states, repeats, shares, outcome=settled, progress=sampling, **flow):
            which, turns = _turning_points(part, piece, flow)
            turns[:, 0] += discard + piece.first
            found.append((members[which], turns))
            outcome[members] = piece.outcome
    table, count = _padded(found, model.size)
    repeat = repeat_of(model)[:, None]
    result = dataset.label(
        model,
        {
            "displacement": (("extremum",), table[..., 1], "displacement x = h/(b-a) at a turning point", "length"),
            "velocity": (("extremum",), table[..., 2], "velocity left at the turning point", "velocity"),
            "phase": (("extremum",), table[..., 0] % 1.0, "phase within the drive repeat", "share"),
            "maximum": (
                ("extremum",),
                np.nan_to_num(table[..., 3]).astype(np.int8),
                "1: a maximum, -1: a minimum, 0: padding",
                "flag",
            ),
            "count": ((), count, "number of extrema", "count"),
        },
        coords={"time": (("extremum",), table[..., 0] * repeat, "time", "time")},
        outcome=outcome,
        options={"repeats": repeats, "discard": discard, "tolerance": tolerance},
        title="extrema",
    )
    return with_initial(result, model, states0)


# --- runs over whole repeats of the drive -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Piece:
    """Some repeats of a run.

    ``times`` (members, samples) since their beginning and ``states`` (members, samples, 2) there, the last sample at
    their end; ``outcome`` (members,) of the run so far.
    """

    first: int
    repeats: int
    times: Array
    states: Array
    outcome: npt.NDArray[np.int8]


def pieces(
    model: ConeModel,
    states: Array,
    repeats: int,
    shares: Sequence[float] | Array,
    *,
    outcome: npt.NDArray[np.int8] | None = None,
    progress: Progress = None,
    **flow: Any,
) -> Iterator[Piece]:
    """Runs some repeats of the drive piece by piece, sampled at the given shares (0 to 1) of each repeat.

    ``states`` (members, 2) are at phase 0 of the drive; each piece starts with the clock at 0. ``outcome`` is how
    the members fared before; ``flow`` goes to `integrate`.
    """
    most = int(np.clip(CLOCK_SAMPLES // max(1, len(shares)), 1, CLOCK_REPEATS))
    outcome = np.zeros(model.size, dtype=np.int8) if outcome is None else outcome
    for first in range(0, repeats, most):
        count = min(most, repeats - first)
        ticks = np.append((np.arange(count)[:, None] + np.asarray(shares)).ravel(), count)
        times = ticks * repeat_of(model)[:, None]
        run = integrate(model, states, times, progress=weighted(progress, count / repeats), **flow)
        # A member that failed goes on as NaN, which the flow cannot start from; what counts is how it failed first.
        outcome = np.where(outcome == Outcome.OK, run.outcome, outcome)
        states = run.states[:, -1]
        yield Piece(first, count, run.times, run.states, outcome)


def settle(
    model: ConeModel,
    states: Array,
    repeats: int | npt.NDArray[np.int64],
    *,
    progress: Progress = None,
    **flow: Any,
) -> tuple[Array, npt.NDArray[np.int8]]:
    """States (members, 2) after whole repeats of the drive, at phase 0 again, and how each member fared.

    ``repeats`` is one number for all or (members,); ``flow`` goes to `integrate`. Nothing is kept but the end.
    """
    states, outcome = states.copy(), np.zeros(model.size, dtype=np.int8)
    left = np.broadcast_to(repeats, (model.size,)).copy()
    whole = int(left.sum())
    while (on := np.flatnonzero((left > 0) & (outcome == Outcome.OK))).size:
        step = np.minimum(left[on], CLOCK_REPEATS)
        part = model.take(on)
        share = weighted(progress, float(step.sum()) / whole)
        run = integrate(part, states[on], (step * repeat_of(part))[:, None], progress=share, **flow)
        states[on], outcome[on] = run.states[:, 0], run.outcome
        left[on] -= step
    return states, outcome


def repeats_lasting(model: ConeModel, duration: Array | float) -> npt.NDArray[np.int64]:
    """The whole repeats of the drive that take ``duration`` or a little longer, (members,)."""
    return np.ceil(duration / repeat_of(model)).astype(np.int64)


def repeat_of(model: ConeModel) -> Array:
    """The drive's repeat of every member, (members,)."""
    return np.broadcast_to(model.forcing_period, model.shape).ravel()


def fastest(model: ConeModel) -> Array:
    """An estimate of the fastest angular frequency of film and spring, (members,).

    It takes the stiffness at rest, the film's at large displacements, and what the voltage takes away, all as if they
    added up.
    """
    members = model.members()
    voltage = np.abs(members.voltage) + np.abs(members.voltage_bias)
    with np.errstate(divide="ignore", invalid="ignore"):
        at_rest = np.abs(members.stiffness(0.0))
    # A film that is at its stretch limit while flat has no stiffness at rest.
    stiffness = np.where(np.isfinite(at_rest), at_rest, 0.0) + members.number("A") + voltage**2
    return np.sqrt(np.broadcast_to(stiffness, members.shape))


def samples_per_repeat(model: ConeModel, per_oscillation: int) -> npt.NDArray[np.int64]:
    """Samples a drive repeat that give at least so many an oscillation of film and spring, (members,).

    A power of two, from 16 to `MOST_PER_REPEAT`, that follows from each member's own numbers alone, so that a member
    is sampled alike in any ensemble.
    """
    oscillations = fastest(model) * repeat_of(model) / (2.0 * np.pi)
    return np.minimum(next_power_of_two(np.maximum(per_oscillation * oscillations, 16.0)), MOST_PER_REPEAT)


def next_power_of_two(least: Array) -> npt.NDArray[np.int64]:
    """The smallest power of two that is not below."""
    return 2 ** np.ceil(np.log2(least)).astype(np.int64)


def blocks(samples: npt.NDArray[np.int64], *keys: npt.NDArray[np.int64]) -> Iterator[tuple[Any, npt.NDArray[np.intp]]]:
    """Members that are sampled alike, in blocks of bounded memory: ((samples, *keys), members).

    ``samples`` and ``keys`` are (members,). The results of a member do not depend on the block it is in.
    """
    rows, group = np.unique(np.stack([samples, *keys], axis=1), axis=0, return_inverse=True)
    for i, row in enumerate(rows.tolist()):
        members = np.flatnonzero(group.ravel() == i)
        size = max(1, BLOCK_SAMPLES // max(row[0], CLOCK_SAMPLES))
        for first in range(0, members.size, size):
            yield tuple(row), members[first : first + size]


# --- turning points ---------------------------------------------------------------------------------------------------


def _turning_points(members: Members, piece: Piece, flow: dict[str, Any]) -> tuple[npt.NDArray[np.intp], Array]:
    """Member and (time in repeats since the piece began, displacement, velocity, kind) of each, in the order of time.

    A turning point belongs to the samples between which the velocity changes its sign, the later sample included.
    """
    x, u = piece.states[..., 0], piece.states[..., 1]
    a = _acceleration(members, piece.times, piece.states)
    # The sign just after the sample: that of the acceleration where the velocity is exactly zero.
    rising = np.where(u == 0.0, a, u) > 0.0
    moving = np.maximum(np.abs(a[:, :-1]), np.abs(a[:, 1:])) > STILL  # false for NaN
    which, sample = np.nonzero((rising[:, 1:] != rising[:, :-1]) & moving)
    if not which.size:
        return which, np.empty((0, 4))
    begin, end = piece.times[which, sample], piece.times[which, sample + 1]
    gap = end - begin
    guess = begin + gap * _zero_of_quartic(
        u[which, sample],
        u[which, sample + 1],
        gap * a[which, sample],
        gap * a[which, sample + 1],
        (x[which, sample + 1] - x[which, sample]) / gap,
    )
    kind = np.where(rising[which, sample], 1.0, -1.0)
    turning = members.take(which)
    times, states = _polish(turning, piece.states[which, sample], begin, end, guess, kind, flow)
    return which, np.column_stack([times / repeat_of(turning), states, kind])


def _acceleration(members: Members, times: Array, states: Array) -> Array:
    """The disc's acceleration at (members, samples)."""
    return np.asarray(members.flow(times, states)[0][1])


def _jerk(members: Members, times: Array, states: Array) -> Array:
    """Rate of the acceleration at (members, samples), by the chain rule along the motion."""
    rates, jacobian = members.flow(times, states)
    n, z = members.numbers(trailing=1), list(np.moveaxis(states, -1, 0))
    waveform = members.system.waveform
    commanded, change = waveform.voltage(times, n), waveform.voltage_rate(times, n)
    by_voltage = derivative(lambda v, xp: members.system.rates_under(v, z, n, xp)[1], commanded)
    return sum(slope * rate for slope, rate in zip(jacobian[1], rates, strict=True)) + by_voltage * change


def _zero_of_quartic(u0: Array, u1: Array, slope0: Array, slope1: Array, mean: Array) -> Array:
    """Zero in (0, 1) of the quartics with these values and slopes at 0 and 1 and this mean, which change sign there."""
    low, high = np.zeros_like(u0), np.ones_like(u0)
    # A value of exactly 0 at the left end has the sign with which it is left.
    sign = np.sign(np.where(u0 == 0.0, slope0, u0))
    # The cubic of the values and slopes has the mean (u0 + u1)/2 + (slope0 - slope1)/12; s^2 (1 - s)^2 has 1/30.
    bump = 30.0 * (mean - 0.5 * (u0 + u1) - (slope0 - slope1) / 12.0)
    for _ in range(40):
        s = 0.5 * (low + high)
        r = 1.0 - s
        value = r * r * ((1.0 + 2.0 * s) * u0 + s * slope0) + s * s * ((1.0 + 2.0 * r) * u1 - r * slope1 + r * r * bump)
        before = value * sign > 0.0
        low, high = np.where(before, s, low), np.where(before, high, s)
    return 0.5 * (low + high)


def _polish(
    turning: Members, starts: Array, begin: Array, end: Array, guess: Array, kind: Array, flow: dict[str, Any]
) -> tuple[Array, Array]:
    """Times (points,) and states (points, 2) where the velocity vanishes, by Newton's method on the flow itself.

    ``starts`` are the states at ``begin``, ``kind`` the sign of the velocity on the way to the turning point. The last
    step, once it is small enough, is the flow's Taylor expansion. The bracket is halved where Newton's step leaves it,
    as it does where the film turns the motion round like a wall.
    """
    low, high, times, states = begin.copy(), end.copy(), guess.copy(), np.empty((guess.size, 2))
    left = np.arange(guess.size)
    for _ in range(MOST_POLISHINGS):
        part, at = turning.take(left), times[left]
        states[left] = integrate(part, starts[left], at[:, None], start=begin[left], **flow).states[:, 0]
        here = states[left][:, None, :]
        x, u = here[..., 0], here[..., 1]
        a = _acceleration(part, at[:, None], here)
        step = -u / np.where(a == 0.0, 1.0, a)
        remains = u + a * step + 0.5 * _jerk(part, at[:, None], here) * step * step
        final = np.column_stack([x + (u + 0.5 * a * step) * step, remains])
        before = u[:, 0] * kind[left] > 0.0
        low[left], high[left] = np.where(before, at, low[left]), np.where(before, high[left], at)
        newton = at + step[:, 0]
        inside = (low[left] <= newton) & (newton <= high[left])
        small = np.abs(step[:, 0]) <= SMALL_STEP * (end - begin)[left]
        done = inside & small & (np.abs(remains[:, 0]) <= VELOCITY_LEFT)
        states[left[done]], times[left[done]] = final[done], newton[done]
        better = np.where(inside & (newton != at), newton, 0.5 * (low[left] + high[left]))
        unfinished = ~done & (low[left] < better) & (better < high[left])
        left = left[unfinished]
        if not left.size:
            break
        times[left] = better[unfinished]
    return times, states


def _padded(found: list[tuple[npt.NDArray[np.intp], Array]], count: int) -> tuple[Array, npt.NDArray[np.int64]]:
    """Rows of all members as (members, most rows but at least 1, columns), NaN beyond each own; and their numbers."""
    which = np.concatenate([members for members, _ in found])
    rows = np.concatenate([rows for _, rows in found])
    order = np.argsort(which, kind="stable")
    numbers = np.bincount(which, minlength=count)
    place = np.arange(which.size) - np.repeat(np.cumsum(numbers) - numbers, numbers)
    table = np.full((count, int(numbers.max(initial=1)), rows.shape[1]), np.nan)
    table[which[order], place] = rows[order]
    return table, numbers


# --- shared with the spectrum -----------------------------------------------------------------------------------------


def _checked_phase(phase: Any) -> float:
    try:
        value = float(phase)
    except (TypeError, ValueError):
        raise InputError(f"phase = {phase!r}: must be a number") from None
    if not 0.0 <= value < 1.0:
        raise InputError(f"phase = {value:g}: must be at least 0 and below 1, the share of the drive repeat gone by")
    return value
