"""Check of branches against brute force: every settled cycle lies on a branch, and motions return to stable orbits.

Each contradiction is reported as a flag. A settled cycle that lies on no branch starts one; it is a contradiction only
where Newton's method finds no orbit at it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.atlas.branches.branch import Branch, Event, EventKind, Walk
from gelcone.atlas.branches.follow import follow
from gelcone.atlas.branches.journal import Journal
from gelcone.atlas.branches.point import Metric, Point, at_value
from gelcone.atlas.branches.tree import Tree, kind_of
from gelcone.codes import Outcome
from gelcone.motion.attractor.search import search
from gelcone.motion.cyclic import scaled_product
from gelcone.motion.flow import integrate
from gelcone.motion.orbit import Kind, Shooting
from gelcone.motion.settle import settle
from gelcone.quantity import Array

DISTANCE = 1e-5
"""Distance from an orbit at which a run starts, as a share of its size."""
CLOSER = (1e-6, 1e-8, 1e-10)
"""Distances of further runs where the motion leaves from the first: some basins are narrower."""
REACHED = 1e-7
"""Distance from an orbit, as a share of its size, at which a run has reached it as far as rounding allows: deviations
can grow a millionfold within a period before they decay."""
DECAYED = 1e-2
"""Share to which the multiplier reduces the distance during a run."""
MOST_PERIODS = 400
"""Longest run in periods; orbits that need a longer one are left out, since their multipliers are too close to 1."""
RETURNED = 0.5
"""Share of the distance at the start below which a run has returned."""
ORBITS = 24
"""Number of stable orbits of each branch that are checked."""
RESTING = 1e-7
"""Size of motions below which they are rest."""
SETTLED = 1e-6
"""Largest difference between equal orbits, over their size."""
FARTHEST_CYCLE = 0.2
"""Largest distance, over the size of the motion, of the cycle that the motion is on."""

LEAVES = "stable branch that the motion leaves"
NO_ORBIT = "attractor without orbit"
OTHER_PERIOD = "another period"
NOT_BRACKETED = "event that no regime change brackets"
FLAGS = (LEAVES, NO_ORBIT, OTHER_PERIOD, NOT_BRACKETED)


@dataclass(frozen=True)
class Flag:
    """A contradiction: its kind, one of `FLAGS`, the branch (-1: none), the value of the parameter, and an explanation
    if there is one."""

    kind: str
    branch: int
    value: float
    explanation: str = ""


@dataclass(frozen=True)
class Runs:
    """Settled motions: ``values`` (runs,) of the parameter; ``section`` (runs, repeats, N), the states once every
    repeat; ``period`` (runs,), 0 where a motion is not periodic; ``symmetric`` (runs,); and ``arrived`` (runs,), true
    if the motion is so close to its cycle that an orbit must be there. ``attracting`` is False for orbits of earlier
    branches."""

    values: Array
    section: Array
    period: npt.NDArray[np.int64]
    symmetric: npt.NDArray[np.bool_]
    arrived: npt.NDArray[np.bool_]
    attracting: bool = True


@dataclass(frozen=True)
class Checked:
    """Number of settled ``cycles`` that were compared with the branches, of those that ``seeded`` a branch, and of
    stable ``orbits`` near which runs started; and the flags."""

    cycles: int
    seeded: int
    orbits: int
    flags: list[Flag]


def brute_force(walk: Walk, shooting: Shooting, values: Array, starts: Array, **flow: Any) -> Runs:
    """The settled motions from each of the ``starts`` (starts, N) at each value of the parameter."""
    return Runs(**walk.journal.entry(lambda: vars(_settled(shooting, values, starts, **flow))))


def _settled(shooting: Shooting, values: Array, starts: Array, **flow: Any) -> Runs:
    grid = np.repeat(values, len(starts))
    members = shooting.members_at((grid,))
    # without damping there are no attractors
    rows = np.flatnonzero(members.damped)
    settled_motions = search(members.take(rows), np.tile(starts, (values.size, 1))[rows], **flow)
    section, period = np.full((grid.size, 1, shooting.size), np.nan), np.zeros(grid.size, dtype=np.int64)
    symmetric, arrived = np.zeros((2, grid.size), dtype=bool)
    cycles = settled_motions.cycles
    section[rows, 0] = np.where(cycles.found[:, None], cycles.point, settled_motions.state)
    period[rows], symmetric[rows] = np.where(cycles.found, cycles.period, 0), cycles.found & cycles.symmetric
    arrived[rows] = cycles.attracting
    return Runs(grid, section, period, symmetric & (period % 2 == 0), arrived)


def cover(tree: Tree, shooting: Shooting, runs: Runs, **flow: Any) -> Checked:
    """Searches the branches for the cycle of every run; one that is missing starts a branch, and the tree grows."""
    flags: list[Flag] = []
    seeded = cycles = 0
    for k in np.flatnonzero(runs.period > 0):
        if shooting.symmetric and np.abs(runs.section[k][:, :2]).max() < RESTING:
            continue
        cycle_shooting, point = polished(shooting, runs, k, tree.walk.scale, **flow)
        if point is None or (runs.attracting and not point.stable):
            if runs.arrived[k]:
                flags.append(Flag(NO_ORBIT, -1, float(runs.values[k])))
            continue
        if shooting.symmetric and np.abs(point.nodes[:, :2]).max() < RESTING:
            continue  # a slow decay, which ends at rest
        cycles += 1
        cycle_shooting, point = shortest(cycle_shooting, point, tree.walk.scale)
        if not tree.holds(cycle_shooting, point):
            tree.add(follow(cycle_shooting, point, tree.walk), 0)
            seeded += 1
            tree.grow()
    return Checked(cycles, seeded, 0, flags)


def polished(shooting: Shooting, runs: Runs, k: np.intp, scale: float, **flow: Any) -> tuple[Shooting, Point | None]:
    """The shooting for the period of a settled motion, and the orbit near the motion; None where there is none."""
    value, state = float(runs.values[k]), runs.section[k, -1]
    shooting = shooting.of_kind(kind_of(int(runs.period[k]), bool(runs.symmetric[k])))
    members = shooting.members_at((value,))
    times = members.forcing_period[:, None] * (np.arange(shooting.count) / shooting.segments)
    nodes = integrate(members, state, times, **flow).states[0]
    if not np.isfinite(nodes).all():
        return shooting, None
    corrected = at_value(shooting, nodes, value, Metric.of(nodes, scale))
    return shooting, corrected.point if corrected.step < FARTHEST_CYCLE else None


def shortest(shooting: Shooting, point: Point, scale: float) -> tuple[Shooting, Point]:
    """The orbit as a fixed point of the shortest map: its cycle may have a shorter period than ``shooting``."""
    kind = shooting.kind
    candidates = [Kind(d) for d in range(1, kind.repeats) if kind.repeats % d == 0]
    if shooting.symmetric and not kind.reflected:
        halves = [d for d in range(1, kind.repeats // 2 + 1) if kind.repeats % (2 * d) == 0]
        candidates += [Kind(d, True) for d in halves]
    for candidate in sorted(candidates, key=lambda k: k.period):
        shorter = shooting.of_kind(candidate)
        image = shorter.signs * point.nodes[: shorter.count]
        apart = np.abs(np.roll(point.nodes, -shorter.count, axis=0)[: shorter.count] - image).max()
        if apart < SETTLED * max(float(np.abs(point.nodes).max()), RESTING):
            orbit = at_value(shorter, point.nodes[: shorter.count], point.value, Metric.of(point.nodes, scale)).point
            if orbit is not None:
                return shorter, orbit
    return shooting, point


# --- runs near orbits -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Perturbed:
    """A run that starts near an orbit: number and branch of the orbit, its point, its event, and its periods."""

    number: int
    branch: Branch
    point: Point
    event: Event | None
    periods: int


def run_perturbed(tree: Tree, **flow: Any) -> Checked:
    """Runs motions that start at a distance of 1e-5 from orbits. They must return to stable orbits, and leave the
    unstable orbits next to events at which a branch loses stability."""
    stable = [run for number, branch in enumerate(tree.branches) for run in _stable(number, branch)]
    lost = [run for number, branch in enumerate(tree.branches) for run in _lost(number, branch)]
    flags, journal = [], tree.walk.journal
    left = _apart(journal, stable, DISTANCE, **flow) >= RETURNED
    away = [run for run, leaves in zip(stable, left, strict=True) if leaves]
    nearer = np.array(
        [_apart(journal, away, start, **flow) * start < np.maximum(RETURNED * start, REACHED) for start in CLOSER]
    )
    for run, returns in zip(away, nearer.T, strict=True):
        explanation = _narrow(CLOSER[int(returns.argmax())]) if returns.any() else ""
        flags.append(Flag(LEAVES, run.number, run.point.value, explanation))
    for run, leaves in zip(stable, left, strict=True):
        if not leaves and _repeats_sooner(run):
            flags.append(Flag(OTHER_PERIOD, run.number, run.point.value))
    for run in _staying(journal, lost, **flow):
        assert run.event is not None
        flags.append(Flag(NOT_BRACKETED, run.number, run.event.value))
    return Checked(0, 0, len(stable), flags)


def _stable(number: int, branch: Branch) -> Iterator[_Perturbed]:
    """Runs near stable orbits of a branch, evenly chosen among those to which return is not too slow."""
    last = len(branch.points) - 1  # either end may be an orbit of another branch
    inner = [k for k, point in enumerate(branch.points) if point.stable and (k not in (0, last) or last < 2)]
    for k in [inner[int(i)] for i in np.linspace(0, len(inner) - 1, min(ORBITS, len(inner)))]:
        periods = _periods(branch, branch.points[k])
        if periods <= MOST_PERIODS:
            yield _Perturbed(number, branch, branch.points[k], None, periods)


def _lost(number: int, branch: Branch) -> Iterator[_Perturbed]:
    """Runs near the unstable orbit next to every event at which a branch loses or gains stability."""
    for event in branch.events:
        before, after = branch.points[event.after], branch.points[event.after + 1]
        if event.kind == EventKind.TORUS or before.stable == after.stable:
            continue
        unstable = after if before.stable else before
        periods = _periods(branch, unstable)
        if periods <= MOST_PERIODS:
            yield _Perturbed(number, branch, unstable, event, periods)


def _periods(branch: Branch, point: Point) -> int:
    """Periods after which every deviation has decayed to `DECAYED`, or the largest has grown by its inverse.

    Deviations can grow in the first periods although all multipliers lie inside the unit circle. Therefore powers of
    the map are computed, not of its multipliers.
    """
    shooting = branch.shooting
    product, scale = scaled_product(shooting.run(point.nodes, (point.value,)).tangents)
    once = product * np.exp(min(float(scale), 600.0)) * shooting.signs[:, None]
    once = once @ once if shooting.kind.reflected else once
    if not point.stable:
        rate = np.log(max(float(np.abs(point.multipliers[0])), 1.0 + 1e-12))
        return int(np.ceil(min(-2.0 * np.log(DECAYED) / rate, 10.0 * MOST_PERIODS))) + 1
    power, periods = once, 1
    with np.errstate(over="ignore", invalid="ignore"):  # a map that overflows has not decayed
        while not np.abs(power).max() <= DECAYED and periods <= MOST_PERIODS:
            power, periods = power @ once, periods + 1
    return max(periods, 2)


def _apart(journal: Journal, runs: list[_Perturbed], distance: float, **flow: Any) -> Array:
    """Distance of each run from its orbit at the end over that at the start, ``distance`` times its size."""
    if not runs:
        return np.zeros(0)
    return np.asarray(journal.entry(lambda: {"apart": _ran(runs, distance, **flow)})["apart"])


def _ran(runs: list[_Perturbed], distance: float, **flow: Any) -> Array:
    shooting = runs[0].branch.shooting
    members = shooting.members_at((np.array([run.point.value for run in runs]),))
    orbits = np.stack([run.point.nodes[0] for run in runs])
    size = np.array([max(float(np.abs(run.point.nodes).max()), 1e-3) for run in runs])
    side = np.random.default_rng(0).normal(size=orbits.shape)
    side /= np.linalg.norm(side, axis=1)[:, None]
    repeats = np.array([run.periods * run.branch.map.period for run in runs])
    ends, outcome = settle(members, orbits + (distance * size)[:, None] * side, repeats, **flow)
    apart = np.abs(ends - orbits).max(axis=1) / (distance * size)
    return np.where((outcome == Outcome.OK) & np.isfinite(apart), apart, np.inf)


def _staying(journal: Journal, runs: list[_Perturbed], **flow: Any) -> list[_Perturbed]:
    """The runs that do not leave their unstable orbits. Chaos returns to one now and then, so that a run must be close
    to it at two times, the second one half as many periods later."""
    for longer in (1.0, 1.5):
        runs = [replace(run, periods=int(longer * run.periods)) for run in runs]
        apart = _apart(journal, runs, DISTANCE, **flow)
        runs = [run for run, by in zip(runs, apart, strict=True) if by < 1.0 / RETURNED]
    return runs


def _narrow(returns_from: float) -> str:
    return f"its basin is narrower than {DISTANCE:.0e} there: from {returns_from:.0e} away the motion returns"


def _repeats_sooner(run: _Perturbed) -> bool:
    """True if the orbit of a run has a shorter period than its branch."""
    shooting = run.branch.shooting
    kind, nodes = shooting.kind, run.point.nodes
    for d in range(1, kind.repeats):
        if kind.repeats % d == 0:
            apart = np.abs(np.roll(nodes, d * shooting.segments, axis=0) - nodes).max()
            if apart < SETTLED * np.abs(nodes).max():
                return True
    return False
