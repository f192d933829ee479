"""Motions that coexist with the motion from rest, and the smallest kicks that lead to them.

A kick is a sudden change of the disc's velocity. Kicks of both signs are tried at several phases of the forcing, up to
the kick that would carry the disc to nine tenths of its reach. Motions found at one drive frequency are tried at the
neighbouring frequencies, too, until none is new.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.bracket import halved
from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import transient_of_the_disc
from gelcone.motion.flow import integrate
from gelcone.motion.settle import repeats_lasting, settle
from gelcone.motion.swing import Swing, settled_swing, swing
from gelcone.motion.validity import unknown
from gelcone.physics.members import Members
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array

Rows = npt.NDArray[np.intp]

PHASES = 6
"""Phases of the forcing period at which kicks are tried."""
LEVELS = 8
"""Number of sizes of kicks, each twice the one before."""
REACH = 0.9
"""Displacement to which the largest kick carries the disc from rest without voltage, over its reach."""
FARTHEST_KICKED = 10.0
"""Largest such displacement, also of a film without a stretch limit."""
HALVINGS = 6
"""Number of halvings of the interval of the smallest kick."""
CLOSER_PHASES = 3
"""Number of halvings of the spacing of phases around that of the smallest kick."""
ROUNDS = 8
"""Most rounds in which motions are tried at the neighbouring frequencies."""
SAME = 1e-2
"""Largest difference between the ends of equal motions, over the larger size, unless both have periods."""
SAME_CYCLE = 1e-3
EARLY_CHECKS = 2
"""Number of comparisons with the member's cycle before a motion after a kick is followed to its end."""
CHECK_AFTER = 0.25
"""Time between these comparisons over the disc's transient; a kick hardly changes slow states."""
ARRIVED = 1e-4
"""Largest distance from the member's cycle, over its size, of a motion that ends on it."""
CHUNK = 512
TOLERANCE = 1e-10
"""Relative error of a step."""


@dataclass
class Motions:
    """Known motions at one drive frequency.

    ``kinds``, a `Swing` of one row each, the member's motion first; ``kick``, the interval (low, high) of the smallest
    kick to each (NaN: found without a kick); ``smallest``, that of the smallest kick to any; ``passed_on``, the numbers
    of those already tried at the neighbouring frequencies.
    """

    kinds: list[Swing]
    kick: list[tuple[float, float]]
    smallest: tuple[float, float] = (np.nan, np.nan)
    passed_on: set[int] = field(default_factory=set)

    def number_of(self, motion: Swing) -> int:
        """Number of a motion among the known ones; adds a new motion."""
        for number, known in enumerate(self.kinds):
            if _same(known, motion):
                return number
        self.kinds.append(motion)
        self.kick.append((np.nan, np.nan))
        return len(self.kinds) - 1


def coexisting(
    members: Members, states: Array, *, threads: int | None = None, progress: Progress = None, shift: float = 0.0
) -> dict[str, Array]:
    """Find motions other than those that members (at increasing drive frequencies) settle on from ``states``.

    ``states`` (members, N); ``shift`` moves the phases of the kicks by a share of their spacing.

    Returns
    -------
    Over (members,): ``motions``, the number of others; ``kick_low`` and ``kick_high``, the interval of the smallest
    kick that leads away from the member's motion (both infinite: none up to ``kick_tried``). Over (members, motions),
    padded with NaN, by rising kick: ``stroke``, ``lowest``, ``highest``, ``period``, ``regime`` (a `Regime`; a motion
    that leaves the domain has no stroke), ``outcome`` (an `Outcome`), ``motion_kick_low`` and ``motion_kick_high`` (NaN
    for a motion found without a kick), and the shares of `gelcone.motion.validity` in ``validity``.
    """
    counted, flow = Counted(progress), dict[str, Any](threads=threads, tolerance=TOLERANCE)
    if not members.size:
        return _as_arrays(members, [], np.empty(0), flow)
    swings = settled_swing(members, states, only_extent=True, **flow)
    motions = [Motions([swings.take([k])], [(np.nan, np.nan)]) for k in range(members.size)]
    alive = np.flatnonzero(swings.outcome == Outcome.OK)
    largest = _largest_kicks(members)
    kicks = _Kicks(members, swings, largest, shift, flow)
    counted(0.05)
    first = _try_kicks(kicks, alive, motions, counted)
    _try_releases(members, alive, motions, flow)
    _try_neighbours(members, alive, motions, flow)
    counted(0.1)
    _narrow(kicks, alive, motions, first)
    result = _as_arrays(members, motions, largest, flow)
    counted.finish()
    return result


def _largest_kicks(members: Members) -> Array:
    """Velocities (members,) that carry the discs from x = 0 to `REACH` of their reach."""
    farthest = np.array([_farthest(members, k) for k in range(members.size)])
    gained = np.asarray(members.energy(farthest)) - np.asarray(members.energy(np.zeros(members.size)))
    return np.sqrt(2.0 * np.maximum(gained, 1e-6))


def _farthest(members: Members, k: int) -> float:
    """`REACH` times the largest displacement of a member, at most `FARTHEST_KICKED`."""
    n = members.numbers_at(k)
    return min(REACH * min(float(film.reach(n)[1]) for film in members.system.films), FARTHEST_KICKED)


class _Kicks:
    """Kicks of the members' motions."""

    def __init__(self, members: Members, own: Swing, largest: Array, shift: float, flow: dict[str, Any]) -> None:
        self.members, self.own, self.largest, self.flow = members, own, largest, flow
        self.phases = (np.arange(PHASES) + shift) / PHASES
        self.signs = np.array([1.0, -1.0])

    def after(self, rows: Rows, phases: Array, kicks: Array) -> list[Swing]:
        """The motions (kicks,) on which ``rows`` settle after kicks at phases of the forcing."""
        motions: list[Swing] = []
        for begin in range(0, len(rows), CHUNK):
            part = slice(begin, begin + CHUNK)
            motions += self._after(rows[part], phases[part] % 1.0, kicks[part])
        return motions

    def _after(self, rows: Rows, phases: Array, kicks: Array) -> list[Swing]:
        members = self.members.take(rows)
        whole = members.forcing_period
        # phase 0 is taken at the end of the period
        until = np.where(phases > 0.0, phases, 1.0) * whole
        struck = integrate(members, self.own.final[rows], until[:, None], **self.flow).states[:, 0]
        struck[:, 1] += kicks
        clock = np.where(phases > 0.0, until, 0.0)
        run = integrate(members, struck, whole[:, None], start=clock, **self.flow)
        settled, states = self.own.take(rows), run.states[:, 0]
        settled.outcome[:] = run.outcome
        away = np.flatnonzero(run.outcome == Outcome.OK)
        for _ in range(EARLY_CHECKS):
            part = members.take(away)
            repeats = repeats_lasting(part, CHECK_AFTER * transient_of_the_disc(part))
            states[away], settled.outcome[away] = settle(part, states[away], repeats, **self.flow)
            away = away[(settled.outcome[away] == Outcome.OK) & ~self._back(rows[away], states[away])]
        if away.size:
            settled.put(away, settled_swing(members.take(away), states[away], only_extent=True, **self.flow))
        return [settled.take([k]) for k in range(len(rows))]

    def _back(self, rows: Rows, states: Array) -> npt.NDArray[np.bool_]:
        """True for each state at phase 0 so near to its row's cycle of one forcing period that it ends on it."""
        swings = self.own.take(rows)
        size = np.maximum(np.maximum(np.abs(swings.lowest), np.abs(swings.highest)), 1e-2)
        scale = np.ones(states.shape)
        scale[:, 1] = 2.0 * np.pi / self.members.take(rows).forcing_period
        near = (np.abs(states - swings.final) / scale).max(axis=1)
        return (swings.period == 1) & (near <= ARRIVED * size)


def _try_kicks(
    kicks: _Kicks, alive: Rows, found: list[Motions], progress: Counted
) -> dict[int, list[tuple[float, float]]]:
    """Tries all kicks, and returns the smallest of each phase and sign that lead away: (phase, signed kick) by row."""
    leading: dict[int, list[tuple[float, float]]] = {int(row): [] for row in alive}
    phases, signs = (mesh.ravel() for mesh in np.meshgrid(kicks.phases, kicks.signs, indexing="ij"))
    for level in range(LEVELS):
        share = 2.0 ** (level + 1 - LEVELS)
        rows = np.repeat(alive, phases.size)
        at, sizes = np.tile(phases, alive.size), np.tile(signs, alive.size) * share * kicks.largest[rows]
        for row, phase, size, motion in zip(rows, at, sizes, kicks.after(rows, at, sizes), strict=True):
            motions = found[row]
            number = motions.number_of(motion)
            if number and np.isnan(motions.kick[number][1]):
                motions.kick[number] = (0.5 * abs(size) if level else 0.0, abs(size))
            before = {(p, np.sign(s)) for p, s in leading[int(row)]}
            if number and (phase, np.sign(size)) not in before:
                leading[int(row)].append((phase, size))
        progress(0.7 / LEVELS)
    return leading


def _try_releases(members: Members, alive: Rows, found: list[Motions], flow: dict[str, Any]) -> None:
    """Releases the disc at rest from displacements on both sides, up to `REACH` of its reach."""
    shares = np.array([-1.0, -0.5, 0.5, 1.0])
    rows = np.repeat(alive, shares.size)
    heights = np.tile(shares, alive.size) * np.array([_farthest(members, int(row)) for row in rows])
    states = members.take(rows).start_states(np.column_stack([heights, np.zeros(rows.size)]))
    _add_settled(members, rows, states, found, flow)


def _try_neighbours(members: Members, alive: Rows, found: list[Motions], flow: dict[str, Any]) -> None:
    """Starts members from the motions found at the neighbouring frequencies."""
    for _ in range(ROUNDS):
        seeds = [
            (int(to), known.final[0])
            for row in alive
            for number, known in enumerate(found[row].kinds)
            if number not in found[row].passed_on and known.outcome[0] == Outcome.OK
            for to in (row - 1, row + 1)
            if to in alive
        ]
        for row in alive:
            found[row].passed_on.update(range(len(found[row].kinds)))
        if not seeds:
            return
        rows, states = np.array([row for row, _ in seeds]), np.array([state for _, state in seeds])
        _add_settled(members, rows, states, found, flow)


def _add_settled(members: Members, rows: Rows, states: Array, found: list[Motions], flow: dict[str, Any]) -> None:
    """Adds the motions on which members end from ``states`` (rows, N)."""
    settled = settled_swing(members.take(rows), states, only_extent=True, **flow)
    for k, row in enumerate(rows):
        if settled.outcome[k] == Outcome.OK:
            found[row].number_of(settled.take([k]))


def _narrow(kicks: _Kicks, alive: Rows, found: list[Motions], leading: dict[int, list[tuple[float, float]]]) -> None:
    """Finds the interval of the smallest kick that leads away at each frequency, between the phases and sizes tried."""
    for row in alive:
        found[row].smallest = (np.inf, np.inf) if not leading[int(row)] else (np.nan, np.nan)
    rows = [int(row) for row in alive if leading[int(row)]]
    if not rows:
        return
    tried = [(row, phase, size) for row in rows for phase, size in _smallest(leading[row])]
    kick_rows, phase, high = (np.array(column) for column in zip(*tried, strict=True))
    high = _edge(kicks, found, kick_rows, phase, high)
    spacing, best = 1.0 / PHASES, {}
    for row in rows:
        indices = np.flatnonzero(kick_rows == row)
        k = indices[np.abs(high[indices]).argmin()]
        best[row] = (phase[k], high[k])
    spread = dict.fromkeys(rows, 0.0)
    for _ in range(CLOSER_PHASES):
        spacing *= 0.5
        kick_rows = np.repeat(rows, 2)
        phase = np.array([best[row][0] + side * spacing for row in rows for side in (-1.0, 1.0)])
        start = np.array([1.5 * best[row][1] for row in rows for _ in (0, 1)])
        high = _edge(kicks, found, kick_rows, phase, start)
        for k, row in enumerate(rows):
            both = high[2 * k : 2 * k + 2]
            sizes = np.abs([best[row][1], *both])
            spread[row] = float(np.nanmax(sizes) - np.nanmin(sizes))
            if np.nanmin(sizes[1:], initial=np.inf) < sizes[0]:
                at = int(np.nanargmin(sizes[1:]))
                best[row] = (phase[2 * k + at], both[at])
    for row in rows:
        size = abs(best[row][1])
        found[row].smallest = (max(size * (1.0 - 2.0**-HALVINGS) - spread[row], 0.0), size)


def _smallest(leading: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The kicks (phase, signed kick) of the smallest size."""
    least = min(abs(size) for _, size in leading)
    return [(phase, size) for phase, size in leading if abs(size) <= least]


def _edge(kicks: _Kicks, found: list[Motions], rows: Rows, phases: Array, sizes: Array) -> Array:
    """The smallest kicks that lead away at these phases, by bisection below ``sizes``; NaN if these do not."""
    low, high = np.zeros(len(rows)), np.asarray(sizes, dtype=float)

    def stays(tried: Array) -> Array:
        motions = kicks.after(rows, phases, tried)
        return np.array([found[row].number_of(motion) == 0 for row, motion in zip(rows, motions, strict=True)])

    return np.where(stays(high), np.nan, halved(stays, low, high, HALVINGS + 1)[1])


def _same(one: Swing, other: Swing) -> bool:
    """True if two settled motions are equal; all that fail count as equal."""
    if (one.outcome[0] != Outcome.OK) or (other.outcome[0] != Outcome.OK):
        return bool((one.outcome[0] != Outcome.OK) == (other.outcome[0] != Outcome.OK))
    ends = np.array([[motion.lowest[0], motion.highest[0]] for motion in (one, other)])
    cycles = one.period[0] == other.period[0] > 0
    return bool(np.abs(ends[0] - ends[1]).max() <= (SAME_CYCLE if cycles else SAME) * max(np.abs(ends).max(), 1e-2))


def _as_arrays(members: Members, found: list[Motions], largest: Array, flow: dict[str, Any]) -> dict[str, Array]:
    """The found motions as arrays, by rising kick."""
    others = [
        sorted(range(1, len(motions.kinds)), key=lambda n: np.nan_to_num(motions.kick[n][1], nan=np.inf))
        for motions in found
    ]
    shape = (len(found), max((len(order) for order in others), default=0))
    named = ("stroke", "lowest", "highest", "period", "regime", "outcome", "motion_kick_low", "motion_kick_high")
    result = {name: np.full(shape, np.nan) for name in named} | {"validity": unknown(*shape)}
    places = [(row, column, n) for row, order in enumerate(others) for column, n in enumerate(order)]
    for row, column, n in places:
        motion = found[row].kinds[n]
        result["motion_kick_low"][row, column], result["motion_kick_high"][row, column] = found[row].kick[n]
        result["regime"][row, column] = Regime.LEFT_THE_DOMAIN
        result["outcome"][row, column] = motion.outcome[0]
        if motion.outcome[0] == Outcome.OK:
            result["stroke"][row, column] = 2.0 * motion.amplitude[0]
            for name in ("lowest", "highest", "period"):
                result[name][row, column] = getattr(motion, name)[0]
    settled = [(row, column, n) for row, column, n in places if found[row].kinds[n].outcome[0] == Outcome.OK]
    if settled:
        rows, columns, _ = (np.array(column) for column in zip(*settled, strict=True))
        states = np.array([found[row].kinds[n].final[0] for row, _, n in settled])
        result["regime"][rows, columns] = classify(members.take(rows), states, **flow).regime
        result["validity"][rows, columns] = swing(members.take(rows), states, **flow).validity
    smallest = np.array([motions.smallest for motions in found]).reshape(-1, 2)
    return result | {
        "motions": np.array([len(order) for order in others]),
        "kick_low": smallest[:, 0],
        "kick_high": smallest[:, 1],
        "kick_tried": largest,
    }
