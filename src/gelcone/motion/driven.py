"""The driven part of an operating envelope: the settled motion over peak voltage and drive frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.floquet import onset_voltage
from gelcone.motion.plane import DRIVEN_LIMITS, YIELDS, Plane, Rows
from gelcone.progress import Counted, Progress, weighted
from gelcone.quantity import Array

NARROWINGS, PARTS = 3, 4
"""How often the interval of a limit is narrowed, and the factor by which it shrinks each time."""
WITHIN = 0.01
"""Relative error of the straight line between the lowest limits at two frequencies, at most."""
NARROWEST = 1.002
"""Ratio of two frequencies within which a limit that does not follow the line is taken to jump."""
REFINEMENTS = 10
CHAOS = DRIVEN_LIMITS.index("chaos")
SHIFTS = (1e-9, -1e-9, 2e-9)
"""Distances of further starts of motions at voltages with chaos. The borders of chaos are fractal: an interval of a
limit ends where motions from all starts meet it, and begins below the first voltage where one does."""
PROBES = (0.25, 0.5, 0.75)
"""Shares of the interval between two frequencies at which the line between their limits is checked."""
FAR = 1.05
"""Ratio of two frequencies below which the line is checked in the middle alone."""
AROUND = 0.8
"""Share of the neighbours' lower limit from which peaks are examined at a frequency between them."""


def driven(
    plane: Plane,
    omegas: Array,
    volts: Array,
    *,
    refine: bool,
    progress: Progress,
    ceiling: float = np.inf,
    pull_in: float = np.inf,
    to_first: bool = False,
) -> dict[str, Array]:
    """Results of `Plane.examine`, each (frequencies, peaks); ``low`` and ``high`` (frequencies, limits), the intervals
    of the peak voltage in which each limit is first met; and ``frequency`` (frequencies,).

    At each frequency peaks are examined until the film pulls in, or up to the first above the constant ``pull_in``
    voltage; the others are NaN. ``to_first`` ends at the first limit, which leaves later ones unknown: above it motions
    are often chaotic, and take longest. With ``refine``, frequencies are added until the lowest limit, or the
    ``ceiling`` where that is lower, is known to `WITHIN` between any two. At these frequencies peaks are examined
    around the limits of the neighbours, and yields are left out.
    """
    counted, confirmed = Counted(progress), set[tuple[float, float]]()
    first = weighted(counted, 0.5 if refine else 1.0)
    examined = rows_of(plane, omegas, volts, first, pull_in=pull_in, to_first=to_first)
    for _ in range(REFINEMENTS if refine else 0):
        between, lowest = unknown_between(plane, examined, min(ceiling, float(volts[-1])), confirmed)
        if not between.size:
            break
        share = weighted(counted, 0.5 / REFINEMENTS)
        added = rows_of(plane, between, volts, share, pull_in=pull_in, around=lowest, to_first=to_first)
        order = np.argsort(np.concatenate([examined["frequency"], between]))
        examined = {name: np.concatenate([values, added[name]])[order] for name, values in examined.items()}
    counted.finish()
    return examined


def unknown_between(
    plane: Plane, found: dict[str, Array], ceiling: float, confirmed: set[tuple[float, float]]
) -> tuple[Array, Array]:
    """Middles of the pairs of neighbouring frequencies between which the lowest limit does not follow the straight
    line, and the lower limit of each pair. Pairs whose limit follows the line are added to ``confirmed``.

    ``found`` holds ``frequency``, ``low``, ``high`` and ``final_below`` of `driven`. At each of `PROBES` two voltages
    are examined: one `WITHIN` below the line between the lower ends, which must not meet a limit, and one above the
    line between the upper ends, which must meet one.
    """
    known = found["frequency"]
    lowest, highest = (np.clip(np.fmin.reduce(found[end], axis=1), 0.0, ceiling) for end in ("low", "high"))
    pairs = list(zip(known[:-1].tolist(), known[1:].tolist(), strict=True))
    wide = known[1:] > NARROWEST * known[:-1]
    at = np.flatnonzero([pair not in confirmed for pair in pairs] & wide & (lowest[:-1] + lowest[1:] > 0.0))
    if not at.size:
        return np.empty(0), np.empty(0)
    pair, share = np.repeat(at, len(PROBES)), np.tile(PROBES, at.size)
    probed = (known[pair + 1] > FAR * known[pair]) | (share == 0.5)
    pair, share = pair[probed], share[probed]
    omega = known[pair] ** (1.0 - share) * known[pair + 1] ** share
    lower_line, upper_line = ((1.0 - share) * end[pair] + share * end[pair + 1] for end in (lowest, highest))
    below, above = lower_line * (1.0 - WITHIN), upper_line * (1.0 + WITHIN)
    lower = 0.5 * (found["final_below"][pair] + found["final_below"][pair + 1])
    tried = np.concatenate([below, above])
    examined = plane.examine(np.tile(omega, 2), tried, lower=np.tile(lower, (2, 1)), yields=False)
    met = np.any([examined[name] > 0.0 for name in DRIVEN_LIMITS[:-1]], axis=0).reshape(2, -1)
    onset = _onset(plane, omega, ceiling)[0]
    met |= np.stack([below, above]) >= onset
    off = np.unique(pair[met[0] | ~(met[1] | (above >= ceiling))])
    confirmed.update(pairs[k] for k in np.setdiff1d(at, off))
    return np.sqrt(known[off] * known[off + 1]), np.minimum(lowest[off], lowest[off + 1])


def rows_of(
    plane: Plane,
    omegas: Array,
    volts: Array,
    progress: Progress,
    *,
    pull_in: float = np.inf,
    around: Array | None = None,
    yields: bool = True,
    to_first: bool = False,
) -> dict[str, Array]:
    """`driven` at the given frequencies, upwards from the lowest peak voltage to pull-in, or ``to_first``, to the first
    limit.

    With limits expected ``around`` voltages (frequencies,), peaks are examined upwards from a little below these, and
    downwards where a limit is met there already. Yields are left out then, and without ``yields``.
    """
    rest, yields, every = plane.limits_from == "rest", yields and around is None, len(volts)
    volts = volts[: int(np.searchsorted(volts, (1.0 + WITHIN) * pull_in)) + 1]
    first = np.zeros(len(omegas), dtype=np.intp)
    if around is not None and rest:
        first = np.clip(np.searchsorted(volts, AROUND * around) - 1, 0, len(volts) - 1)
    shape, tables = (len(omegas), len(volts)), dict[str, Array]()
    met, lower = np.zeros((len(omegas), len(DRIVEN_LIMITS) - 1, len(volts))), None
    counted, step = Counted(weighted(progress, 0.6)), 4 if rest else 1

    def examine(rows: Rows, columns: Rows, lower: Array | None) -> None:
        """Examines some pairs of frequency and level."""
        examined = plane.examine(omegas[rows], volts[columns], lower=lower, yields=yields)
        for name, values in examined.items():
            tables.setdefault(name, np.full((*shape, *values.shape[1:]), np.nan))[rows, columns] = values
        met[rows, :, columns] = np.stack([examined[name] for name in DRIVEN_LIMITS[:-1]], axis=1)
        counted(rows.size / (shape[0] * shape[1]))

    rising, level = np.arange(len(omegas)), first.copy()
    while rising.size:
        rows, columns = np.repeat(rising, step), (level[rising, None] + np.arange(step)).ravel()
        inside = columns < len(volts)
        examine(rows[inside], columns[inside], lower if lower is None else lower[rows[inside]])
        lower = None if rest else tables["final"][np.arange(len(omegas)), np.minimum(level, len(volts) - 1)]
        level[rising] += step
        ends = met[rising] if to_first else met[rising, :1]
        rising = rising[(level[rising] < len(volts)) & ~(ends > 0.0).any(axis=(1, 2))]
    falling = np.flatnonzero(first > 0)
    while (falling := falling[(first[falling] > 0) & (met[falling, :, first[falling]] > 0.0).any(axis=1)]).size:
        first[falling] -= 1
        examine(falling, first[falling], None)
    counted.finish()
    low, high = _limits(plane, met, tables["final"], omegas, volts, weighted(progress, 0.4))
    final = tables.pop("final")
    kept = {name: tables.get(name, np.full(shape, np.nan)) for name in ("regime", "outcome", *YIELDS)}
    beyond = ((0, 0), (0, every - len(volts)))
    of_plane = {name: np.pad(values, beyond, constant_values=np.nan) for name, values in kept.items()}
    return of_plane | {"low": low, "high": high, "frequency": omegas, "final_below": _below_all(final, low, volts)}


def _below_all(final: Array, low: Array, volts: Array) -> Array:
    """The settled states (frequencies, N) at the highest voltage below all limits, or the lowest voltage."""
    lowest = np.fmin.reduce(low, axis=1)
    place = np.clip(np.searchsorted(volts, lowest, side="right") - 1, 0, len(volts) - 1)
    return np.asarray(final[np.arange(len(final)), place])


def _limits(
    plane: Plane, met: Array, final: Array, omegas: Array, volts: Array, progress: Progress
) -> tuple[Array, Array]:
    """Intervals of the peak voltage in which each limit is first met, (frequencies, limits) each, from ``met``
    (frequencies, limits, peaks) and the states ``final`` (frequencies, peaks, N) on which motions settled."""
    counted = Counted(progress)
    reached, first = (met > 0.0).any(axis=2), np.argmax(met > 0.0, axis=2)
    below = np.concatenate([[0.0], volts])
    low, high = np.full((2, len(omegas), len(DRIVEN_LIMITS)), np.nan)
    low[:, :-1] = np.where(reached, below[first], np.inf)
    high[:, :-1] = np.where(reached, volts[first], np.inf)
    unknown = np.isnan(met).any(axis=2)
    low[:, :-1][unknown] = high[:, :-1][unknown] = np.nan
    rows, columns = np.nonzero(reached & ~unknown)
    for _ in range(NARROWINGS if rows.size else 0):
        begin, end = low[rows, columns], high[rows, columns]
        inner = begin[:, None] + (end - begin)[:, None] * np.arange(1, PARTS) / PARTS
        # a motion that leaves the domain meets several limits at one voltage, and is examined once
        pairs = np.stack([np.repeat(rows, PARTS - 1), inner.ravel()])
        points, of = np.unique(pairs, axis=1, return_inverse=True)
        at = points[0].astype(np.intp)
        place = np.clip(np.searchsorted(volts, points[1]) - 1, 0, len(volts) - 1)
        omega, volt, start = omegas[at], points[1], final[at, place]
        fuzzy = volt > low[at, CHAOS]
        shifts = SHIFTS if fuzzy.any() else ()
        share = 0.9 / NARROWINGS / (1 + len(shifts))
        some = _met(plane, omega, volt, start)
        counted(share)
        every = some.copy()
        for shift in shifts:
            now = _met(plane, omega[fuzzy], volt[fuzzy], start[fuzzy], shift)
            counted(share)
            some[fuzzy], every[fuzzy] = some[fuzzy] | now, every[fuzzy] & now
        hit = np.stack([some, every])[:, of.ravel()].reshape(2, *inner.shape, -1)
        hit = np.take_along_axis(hit, columns[None, :, None, None], axis=3)[..., 0]
        first, last = np.where(hit.any(axis=2), hit.argmax(axis=2), PARTS - 1)
        edges, every_row = np.column_stack([begin, inner, end]), np.arange(rows.size)
        low[rows, columns], high[rows, columns] = edges[every_row, first], edges[every_row, last + 1]
    low[:, -1], high[:, -1] = _onset(plane, omegas, float(volts[-1]))
    counted.finish()
    return low, high


def _met(plane: Plane, omegas: Array, volts: Array, lower: Array, shift: float = 0.0) -> npt.NDArray[np.bool_]:
    """Find which limits (pairs, limits) are met at pairs of frequency and peak, without the onset of rest."""
    now = plane.examine(omegas, volts, lower=lower, yields=False, shift=shift)
    return np.stack([now[name] > 0.0 for name in DRIVEN_LIMITS[:-1]], axis=1)


def _onset(plane: Plane, omegas: Array, highest: float) -> tuple[Any, Any]:
    """Peak voltages at which flat rest loses stability under an unbiased drive; NaN where rest is not flat."""
    if not plane.model.members().symmetric[0] or plane.shape.bias != 0.0:
        return np.nan, np.nan
    amplitude = plane.shape.amplitude
    onsets = onset_voltage(plane.model.replace(drive_frequency=omegas), highest=amplitude * highest)
    onset = np.where(np.isnan(onsets["onset_voltage"].values), np.inf, onsets["onset_voltage"].values)
    return onset / amplitude, (onset + np.nan_to_num(onsets["onset_error"].values)) / amplitude
