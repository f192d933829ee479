"""Motions that coexist with the one that grows out of rest, and how large a kick it takes to get to them.

A kick is a sudden change of the disc's velocity. Kicks of both signs are tried at several phases of the forcing, from
small ones up to that which would carry the disc to nine tenths of its reach. Motions that are found at one drive
frequency are tried at the neighbouring ones too, up and down, until nothing new appears.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import transient_of_the_disc
from gelcone.motion.flow import integrate
from gelcone.motion.settle import repeats_lasting, settle
from gelcone.motion.swing import Swing, settled_swing, swing
from gelcone.motion.validity import unknown
from gelcone.physics.bracket import halved
from gelcone.physics.members import Members
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array

Rows = npt.NDArray[np.intp]

PHASES = 6
"""Phases of the forcing period at which kicks are tried."""
LEVELS = 8
"""Sizes of kicks, each twice the one before."""
REACH = 0.9
"""The largest kick carries the disc to this share of its reach, from rest and without voltage."""
FARTHEST = 10.0
"""That far where the film has no stretch limit, or one that lies farther."""
HALVINGS = 6
"""How often the interval of the smallest kick is halved."""
CLOSER_PHASES = 3
"""How often the spacing of phases around that of the smallest kick is halved."""
HANDED_ON = 8
"""How often motions are tried at the neighbouring frequencies."""
SAME = 1e-2
"""Motions whose ends agree to this share of the larger one's size are one, where one of them has no period."""
SAME_CYCLE = 1e-3
LOOKS = 2
"""How often a motion after a kick is compared with the own cycle before it has been followed to the end."""
LOOK_AFTER = 0.25
"""Share of the disc's transient between them; a kick hardly changes what creeps slowly."""
ARRIVED = 1e-4
"""Share of the own motion's size within which a motion that comes so near to the own cycle ends in it."""
CHUNK = 512
TOLERANCE = 1e-10
"""Relative error of a step."""


@dataclass
class Motions:
    """The motions known at one drive frequency: the own motion and the others. ``kinds`` holds one `Swing` row of each,
    the own first; ``kick`` the interval (low, high) of the smallest kick to each, NaN where none led there."""

    kinds: list[Swing]
    kick: list[tuple[float, float]]
    smallest: tuple[float, float] = (np.nan, np.nan)
    handed_on: set[int] = field(default_factory=set)

    def number_of(self, motion: Swing) -> int:
        """Number of a motion among the known ones; it joins them if it is new."""
        for number, known in enumerate(self.kinds):
            if _same(known, motion):
                return number
        self.kinds.append(motion)
        self.kick.append((np.nan, np.nan))
        return len(self.kinds) - 1


def coexisting(
    members: Members, states: Array, *, threads: int | None = None, progress: Progress = None, shift: float = 0.0
) -> dict[str, Array]:
    """Motions other than those that members (at increasing drive frequencies) settle on from ``states`` (members, N).

    ``shift`` moves the phases of the kicks by a share of their spacing.

    Returns
    -------
    Over (members,): ``motions``, how many others were found; ``kick_low`` and ``kick_high``, the interval of the
    smallest kick that leads away from the own motion (both infinite: none up to ``kick_tried`` does). Over (members,
    motions), NaN-padded, by rising kick: ``stroke``, ``lowest``, ``highest``, ``period``, ``regime`` (of `Regime`; one
    that leaves the domain has no stroke), ``outcome``, how it leaves it (of `Outcome`), ``motion_kick_low`` and
    ``motion_kick_high`` (NaN where only the motion at a neighbouring frequency led there), and the shares of
    `gelcone.motion.validity` in ``validity``.
    """
    counted, flow = Counted(progress), dict[str, Any](threads=threads, tolerance=TOLERANCE)
    if not members.size:
        return _arrays(members, [], np.empty(0), flow)
    own = settled_swing(members, states, only_extent=True, **flow)
    found = [Motions([own.take([k])], [(np.nan, np.nan)]) for k in range(members.size)]
    alive = np.flatnonzero(own.outcome == Outcome.OK)
    largest = _largest_kicks(members)
    kicks = _Kicks(members, own, largest, shift, flow)
    counted(0.05)
    first = _climb(kicks, alive, found, counted)
    _let_go(members, alive, found, flow)
    _hand_on(members, alive, found, flow)
    counted(0.1)
    _narrow(kicks, alive, found, first)
    result = _arrays(members, found, largest, flow)
    counted.finish()
    return result


def _largest_kicks(members: Members) -> Array:
    """The velocities that carry the discs from x = 0 to `REACH` of their reach."""
    farthest = np.array([_farthest(members, k) for k in range(members.size)])
    gained = np.asarray(members.energy(farthest)) - np.asarray(members.energy(np.zeros(members.size)))
    return np.sqrt(2.0 * np.maximum(gained, 1e-6))


def _farthest(members: Members, k: int) -> float:
    """`REACH` of the displacements that a member reaches."""
    highest = float(members.system.film.reach(members.numbers_at(k))[1])
    return min(REACH * highest, FARTHEST)


class _Kicks:
    """The members' own motions, and what becomes of them after kicks."""

    def __init__(self, members: Members, own: Swing, largest: Array, shift: float, flow: dict[str, Any]) -> None:
        self.members, self.own, self.largest, self.flow = members, own, largest, flow
        self.phases = (np.arange(PHASES) + shift) / PHASES
        self.signs = np.array([1.0, -1.0])

    def after(self, rows: Rows, phases: Array, kicks: Array) -> list[Swing]:
        """The motions (kicks,) that some rows settle on after kicks at phases of the forcing."""
        motions: list[Swing] = []
        for begin in range(0, len(rows), CHUNK):
            part = slice(begin, begin + CHUNK)
            motions += self._after(rows[part], phases[part] % 1.0, kicks[part])
        return motions

    def _after(self, rows: Rows, phases: Array, kicks: Array) -> list[Swing]:
        members = self.members.take(rows)
        whole = members.forcing_period
        # a phase of 0 is that of the end of the period
        until = np.where(phases > 0.0, phases, 1.0) * whole
        struck = integrate(members, self.own.final[rows], until[:, None], **self.flow).states[:, 0]
        struck[:, 1] += kicks
        clock = np.where(phases > 0.0, until, 0.0)
        run = integrate(members, struck, whole[:, None], start=clock, **self.flow)
        settled, states = self.own.take(rows), run.states[:, 0]
        settled.outcome[:] = run.outcome
        away = np.flatnonzero(run.outcome == Outcome.OK)
        for _ in range(LOOKS):
            part = members.take(away)
            repeats = repeats_lasting(part, LOOK_AFTER * transient_of_the_disc(part))
            states[away], settled.outcome[away] = settle(part, states[away], repeats, **self.flow)
            away = away[(settled.outcome[away] == Outcome.OK) & ~self._back(rows[away], states[away])]
        if away.size:
            settled.put(away, settled_swing(members.take(away), states[away], only_extent=True, **self.flow))
        return [settled.take([k]) for k in range(len(rows))]

    def _back(self, rows: Rows, states: Array) -> npt.NDArray[np.bool_]:
        """Whether states at phase 0 have arrived at the own motion of their rows, where that repeats with the forcing:
        nearer to an attracting cycle than any other motion could stay."""
        own = self.own.take(rows)
        size = np.maximum(np.maximum(np.abs(own.lowest), np.abs(own.highest)), 1e-2)
        scale = np.ones(states.shape)
        scale[:, 1] = 2.0 * np.pi / self.members.take(rows).forcing_period
        near = (np.abs(states - own.final) / scale).max(axis=1)
        return (own.period == 1) & (near <= ARRIVED * size)


def _climb(kicks: _Kicks, alive: Rows, found: list[Motions], progress: Counted) -> dict[int, list[tuple[float, float]]]:
    """Tries all kicks; for each row the (phase, signed kick) that lead away with no smaller one of theirs that does."""
    leading: dict[int, list[tuple[float, float]]] = {int(row): [] for row in alive}
    phases, signs = (mesh.ravel() for mesh in np.meshgrid(kicks.phases, kicks.signs, indexing="ij"))
    for level in range(LEVELS):
        share = 2.0 ** (level + 1 - LEVELS)
        rows = np.repeat(alive, phases.size)
        at, sizes = np.tile(phases, alive.size), np.tile(signs, alive.size) * share * kicks.largest[rows]
        for row, phase, size, motion in zip(rows, at, sizes, kicks.after(rows, at, sizes), strict=True):
            own = found[row]
            number = own.number_of(motion)
            if number and np.isnan(own.kick[number][1]):
                own.kick[number] = (0.5 * abs(size) if level else 0.0, abs(size))
            before = {(p, np.sign(s)) for p, s in leading[int(row)]}
            if number and (phase, np.sign(size)) not in before:
                leading[int(row)].append((phase, size))
        progress(0.7 / LEVELS)
    return leading


def _let_go(members: Members, alive: Rows, found: list[Motions], flow: dict[str, Any]) -> None:
    """Lets the disc go at rest from displacements on both sides, up to `REACH` of its reach."""
    shares = np.array([-1.0, -0.5, 0.5, 1.0])
    rows = np.repeat(alive, shares.size)
    heights = np.tile(shares, alive.size) * np.array([_farthest(members, int(row)) for row in rows])
    states = members.take(rows).start_states(np.column_stack([heights, np.zeros(rows.size)]))
    settled = settled_swing(members.take(rows), states, only_extent=True, **flow)
    for k, row in enumerate(rows):
        if settled.outcome[k] == Outcome.OK:
            found[row].number_of(settled.take([k]))


def _hand_on(members: Members, alive: Rows, found: list[Motions], flow: dict[str, Any]) -> None:
    """Starts the neighbours of a frequency from the motions found there."""
    for _ in range(HANDED_ON):
        seeds = [
            (int(to), known.final[0])
            for row in alive
            for number, known in enumerate(found[row].kinds)
            if number not in found[row].handed_on and known.outcome[0] == Outcome.OK
            for to in (row - 1, row + 1)
            if to in alive
        ]
        for row in alive:
            found[row].handed_on.update(range(len(found[row].kinds)))
        if not seeds:
            return
        rows, states = np.array([row for row, _ in seeds]), np.array([state for _, state in seeds])
        settled = settled_swing(members.take(rows), states, only_extent=True, **flow)
        for k, row in enumerate(rows):
            if settled.outcome[k] == Outcome.OK:
                found[row].number_of(settled.take([k]))


def _narrow(kicks: _Kicks, alive: Rows, found: list[Motions], leading: dict[int, list[tuple[float, float]]]) -> None:
    """The interval of the smallest kick that leads away, at each frequency: between phases and sizes tried."""
    for row in alive:
        found[row].smallest = (np.inf, np.inf) if not leading[int(row)] else (np.nan, np.nan)
    rows = [int(row) for row in alive if leading[int(row)]]
    if not rows:
        return
    tried = [(row, phase, size) for row in rows for phase, size in _promising(leading[row])]
    of, phase, high = (np.array(column) for column in zip(*tried, strict=True))
    high = _edge(kicks, found, of, phase, high)
    spacing, best = 1.0 / PHASES, {}
    for row in rows:
        own = np.flatnonzero(of == row)
        k = own[np.abs(high[own]).argmin()]
        best[row] = (phase[k], high[k])
    spread = dict.fromkeys(rows, 0.0)
    for _ in range(CLOSER_PHASES):
        spacing *= 0.5
        of = np.repeat(rows, 2)
        phase = np.array([best[row][0] + side * spacing for row in rows for side in (-1.0, 1.0)])
        start = np.array([1.5 * best[row][1] for row in rows for _ in (0, 1)])
        high = _edge(kicks, found, of, phase, start)
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


def _promising(leading: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The kicks of a row that are among its smallest, one for each phase and sign."""
    least = min(abs(size) for _, size in leading)
    return [(phase, size) for phase, size in leading if abs(size) <= least]


def _edge(kicks: _Kicks, found: list[Motions], rows: Rows, phases: Array, sizes: Array) -> Array:
    """The smallest kicks that lead away at these phases, halved down from ``sizes``; NaN where those do not."""
    low, high = np.zeros(len(rows)), np.asarray(sizes, dtype=float)

    def stays(tried: Array) -> Array:
        motions = kicks.after(rows, phases, tried)
        return np.array([found[row].number_of(motion) == 0 for row, motion in zip(rows, motions, strict=True)])

    return np.where(stays(high), np.nan, halved(stays, low, high, HALVINGS + 1)[1])


def _same(one: Swing, other: Swing) -> bool:
    """Whether two settled motions are one; all that fail count as one."""
    if (one.outcome[0] != Outcome.OK) or (other.outcome[0] != Outcome.OK):
        return bool((one.outcome[0] != Outcome.OK) == (other.outcome[0] != Outcome.OK))
    ends = np.array([[motion.lowest[0], motion.highest[0]] for motion in (one, other)])
    cycles = one.period[0] == other.period[0] > 0
    return bool(np.abs(ends[0] - ends[1]).max() <= (SAME_CYCLE if cycles else SAME) * max(np.abs(ends).max(), 1e-2))


def _arrays(members: Members, found: list[Motions], largest: Array, flow: dict[str, Any]) -> dict[str, Array]:
    """What was found as arrays, the motions by rising kick."""
    others = [
        sorted(range(1, len(own.kinds)), key=lambda n: np.nan_to_num(own.kick[n][1], nan=np.inf)) for own in found
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
    smallest = np.array([own.smallest for own in found]).reshape(-1, 2)
    return result | {
        "motions": np.array([len(order) for order in others]),
        "kick_low": smallest[:, 0],
        "kick_high": smallest[:, 1],
        "kick_tried": largest,
    }
