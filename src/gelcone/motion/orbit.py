"""Periodic orbits by Newton's method with multiple shooting, their multipliers and how they move with parameters.

An orbit is a fixed point of the map over some repeats of the drive, or of its mirror image for a symmetric orbit: then
the map over half a period ends at the mirror image of where it began. The map is cut into segments whose end states
must meet, so that unstable orbits of any strength are found: single shooting loses an orbit whose multipliers reach
1e8. Time is the phase of the drive. Ascher, Mattheij and Russell, Numerical Solution of
Boundary Value Problems (1988), chapter 4; Seydel, Practical Bifurcation and Stability Analysis (2010), chapter 7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.cyclic import scaled_product, solve_ring
from gelcone.motion.flow import DEFAULT_TOLERANCE, available_threads, integrate, phase_program, smallest_step
from gelcone.physics.members import Members
from gelcone.progress import Stopped, current_watch
from gelcone.quantity import Array

SEGMENT = 8.0
"""Longest segment in units of the fastest linear time scale. Deviations grow by less than 100 in one."""
FEWEST_SEGMENTS = 4
DIFFERENCE = 1e-6
"""Relative step of the differences that say how the numbers of the formulas follow a parameter. Only Newton's matrix
uses them, not what it converges to."""


MOST_KNOWN = 64
"""Values of what is free whose numbers are kept."""
Settings = Callable[[Sequence[Any]], dict[str, Any]]
"""Values of what is free -> parameters of the model."""


class Kind(NamedTuple):
    """Which map an orbit is a fixed point of: over so many ``repeats`` of the drive and, where ``reflected``, with the
    mirror image x -> -x after it."""

    repeats: int = 1
    reflected: bool = False

    @property
    def period(self) -> int:
        """Period of the orbit in repeats of the drive."""
        return 2 * self.repeats if self.reflected else self.repeats

    @property
    def doubled(self) -> Kind:
        """The kind of the orbits born where the multiplier of the map is -1."""
        return Kind(2 * self.repeats, False)


class Pass(NamedTuple):
    """Where all segments end: ``ends`` (n, N), the ``tangents`` (n, N, N) of the segments, ``slopes`` (n, N, P) with
    respect to the free parameters, and whether all ``arrived``."""

    ends: Array
    tangents: Array
    slopes: Array
    arrived: bool


def repeat_phase(members: Members) -> float:
    """Phase of the drive in one repeat of the force: pi or 2 pi, the same for all members."""
    own = members.forcing_period * members.number("drive_frequency")
    return float(np.round(np.max(own) / np.pi) * np.pi)


def segments_for(rate: float, repeat: float) -> int:
    """Segments of a repeat of that length, a power of 2."""
    return int(2 ** max(np.ceil(np.log2(max(rate * repeat / SEGMENT, 1.0))), np.log2(FEWEST_SEGMENTS)))


class Shooting:
    """Passes over one orbit of one actuator while parameters change.

    Parameters
    ----------
    members : the actuator, one member.
    free : what changes; `run` takes the values.
    kind : the map.
    segments : of one repeat.
    phase : of one repeat, pi or 2 pi.
    tolerance : relative error of one step of the integrator.
    settings : the model's parameters, by name, that values (free,) of what is free make, each a number or an array.
        Default: what is free are parameters themselves.
    around : values of what is free that are in use. Default: the actuator's own.
    """

    def __init__(
        self,
        members: Members,
        free: Sequence[str],
        kind: Kind,
        segments: int,
        phase: float,
        tolerance: float = DEFAULT_TOLERANCE,
        settings: Settings | None = None,
        around: Sequence[float] | None = None,
    ) -> None:
        self.system, self.free, self.kind = members.system, tuple(free), kind
        self.segments, self.phase, self.tolerance = segments, phase, tolerance
        self.size = len(self.system.states)
        self.count = segments * kind.repeats
        self._members = members
        self._values: dict[str, Any] = {name: float(value[0]) for name, value in members.values.items()}
        self._told = settings is not None
        self._settings = settings or (lambda values: dict(zip(self.free, values, strict=True)))
        self._around = tuple(self._values[name] for name in self.free) if around is None else tuple(around)
        self._numbers = self.system.numbers_of(self._values | self._settings(self._around))
        self._moved = tuple(self._moved_by(k) for k in range(len(self.free)))
        # most parameters are a number of the formulas and move no other
        self._plain = settings is None and all(
            moved == (name,) and self._numbers[name] == self._values[name]
            for name, moved in zip(self.free, self._moved, strict=True)
        )
        self._known: dict[tuple[float, ...], tuple[dict[str, float], Array]] = {}
        program = phase_program(self.system, self._moved, tolerance)
        # the drive is the same in every repeat, so that each begins at phase 0
        place = np.tile(np.arange(segments, dtype=float), kind.repeats)
        start, end = place * (phase / segments), (place + 1.0) * (phase / segments)
        self._rerun = program.again(start, end)
        self._program, self._starts = program, start
        self._place = {name: k for k, name in enumerate(program.numbers)}
        self._own = np.array([self._place[name] for name in self._numbers])
        self._row = np.zeros(len(self._place))
        self._states = np.zeros((self.count, self.size * (1 + self.size + len(self.free))))
        self._states[:, self.size : self.size * (1 + self.size)] = np.eye(self.size).ravel()
        self._kinds: dict[Kind, Shooting] = {kind: self}
        self._smallest = float(smallest_step(members)[0])

    @cached_property
    def signs(self) -> Array:
        """What closes the orbit: z(end) = signs z(start)."""
        return self.system.mirror if self.kind.reflected else np.ones(self.size)

    @cached_property
    def symmetric(self) -> bool:
        """Whether the mirror image of a motion is a motion."""
        return bool(self._members.symmetric[0])

    def of_kind(self, kind: Kind) -> Shooting:
        """The same for another map."""
        if kind not in self._kinds:
            other = Shooting(
                self._members,
                self.free,
                kind,
                self.segments,
                self.phase,
                self.tolerance,
                self._settings if self._told else None,
                self._around,
            )
            other._kinds = self._kinds
            self._kinds[kind] = other
        return self._kinds[kind]

    def numbers_at(self, values: Sequence[float]) -> dict[str, float]:
        """What the formulas take, by name."""
        if self._plain:
            return self._numbers | dict(zip(self.free, map(float, values), strict=True))
        return self._with_slopes(values)[0]

    def members_at(self, values: Sequence[Any]) -> Members:
        """The actuator at values of what is free, each a number or an array (members,)."""
        size = max((np.size(value) for value in values), default=1)
        return Members(self.system, self._values | self._settings(values), size)

    def _with_slopes(self, values: Sequence[float]) -> tuple[dict[str, float], Array]:
        """What the formulas take, and how it changes with what is free over a step each, (numbers, free)."""
        at = tuple(map(float, values))
        if at not in self._known:
            count, apart = len(at), DIFFERENCE * np.array(_steps(at))
            near = np.tile(np.array(at)[:, None], 1 + 2 * count)
            near[np.arange(count), 1 + 2 * np.arange(count)] += apart
            near[np.arange(count), 2 + 2 * np.arange(count)] -= apart
            found = self.system.numbers_of(self._values | self._settings([*near]))
            table = np.stack([np.broadcast_to(np.asarray(v, dtype=float), near.shape[1:]) for v in found.values()])
            slopes = (table[:, 1::2] - table[:, 2::2]) * (0.5 / DIFFERENCE)
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            self._known[at] = dict(zip(found, table[:, 0].tolist(), strict=True)), slopes
        return self._known[at]

    def repeat_time(self, values: Sequence[float]) -> float:
        """Time of one repeat."""
        return self.phase / float(self.numbers_at(values)["drive_frequency"])

    def _moved_by(self, k: int) -> tuple[str, ...]:
        """Numbers that depend on what is free."""
        other = list(self._around)
        other[k] += DIFFERENCE
        after = self.system.numbers_of(self._values | self._settings(other))
        return tuple(number for number in self.system.numbers if after[number] != self._numbers[number])

    def run(self, nodes: Array, values: Sequence[float]) -> Pass:
        """All segments from ``nodes`` (n, N) at ``values`` of the free parameters.

        The arrays are valid until the next run.
        """
        numbers = self.numbers_at(values)
        row, place = self._row, self._place
        row[self._own] = [*numbers.values()]
        steps = _steps(values)
        if self._plain:
            for k, name in enumerate(self.free):
                row[place[f"{name} by {k}"]] = steps[k]
        else:
            slopes = dict(zip(numbers, self._with_slopes(values)[1], strict=True))
            for k, moved in enumerate(self._moved):
                for number in moved:
                    row[place[f"{number} by {k}"]] = slopes[number][k]
        n, size = self.count, self.size
        self._states[:, :size] = nodes
        switches = None
        if self._program.switches:
            found = self._program.switches_at(self._starts, nodes, numbers)
            switches = np.stack([found[name] for name in self._program.switches], axis=1)
        result, arrived = self._rerun.run(row, self._states, self._smallest * numbers["drive_frequency"], switches)
        tangents = result[:, size : size * (1 + size)].reshape(n, size, size).transpose(0, 2, 1)
        slopes = result[:, size * (1 + size) :].reshape(n, len(self.free), size).transpose(0, 2, 1) / np.array(steps)
        return Pass(result[:, :size], tangents, slopes, bool(arrived.all()))

    @property
    def pulled_in(self) -> bool:
        """Whether the last run ended where the film pulls in."""
        return self._rerun.met_event or self.system.film.ending == Outcome.PULLED_IN

    def gaps(self, nodes: Array, ends: Array) -> Array:
        """How far each segment ends from the next node, (n, N)."""
        return ends - np.concatenate([nodes[1:], self.signs * nodes[:1]])

    def log_determinant(self, tangents: Array, values: Sequence[float]) -> float:
        """Logarithm of the determinant of the map: with two states exactly -2 zeta times its length."""
        if self.size == 2:
            numbers = self.numbers_at(values)
            time = self.phase / float(numbers["drive_frequency"])
            return -2.0 * float(numbers["damping_ratio"]) * self.kind.repeats * time
        return float(np.linalg.slogdet(tangents)[1].sum())

    def multipliers(self, tangents: Array, values: Sequence[float]) -> npt.NDArray[np.complex128]:
        """Multipliers (N,) of the map, the mirror image included where it is reflected, the largest modulus first."""
        product, scale = scaled_product(tangents)
        return multipliers_of(self.signs[:, None] * product, float(scale), self.log_determinant(tangents, values))

    def inside(self, nodes: Array, values: Sequence[float]) -> bool:
        """Whether all nodes are displacements that the film can take."""
        n, film = self.numbers_at(values), self.system.film
        with np.errstate(all="ignore"):
            return bool((film.strain(nodes[:, 0], n) < film.strain_limit(n)).all())


def _steps(values: Sequence[float]) -> list[float]:
    """Typical changes of what is free: the derivatives are integrated along them, so that they are of the states'
    size."""
    return [max(0.1 * abs(value), 1e-3) for value in values]


def multipliers_of(product: Array, log_scale: float, log_determinant: float) -> npt.NDArray[np.complex128]:
    """Eigenvalues (N,) of a scaled map, the largest modulus first.

    The smallest one follows from the determinant. With two states so do both from trace and determinant: the computed
    determinant of a map that grows would be rounding.
    """
    if product.shape[-1] == 2:
        half = 0.5 * (product[0, 0] + product[1, 1])
        inner = half * half - np.exp(log_determinant - 2.0 * log_scale)
        if inner < 0.0:
            pair = complex(half, np.sqrt(-inner)) * np.exp(log_scale)
            return np.array([pair, pair.conjugate()])
        larger = half + np.copysign(np.sqrt(inner), half)
        return np.array([larger * np.exp(log_scale), np.exp(log_determinant - log_scale) / larger], dtype=complex)
    values = np.linalg.eigvals(product)
    values = values[np.argsort(-np.abs(values), kind="stable")].astype(complex)
    if values[-1].imag == 0.0 and np.abs(values[:-1]).all():
        with np.errstate(over="ignore"):
            rest = np.exp(log_determinant - len(values) * log_scale) / np.prod(np.abs(values[:-1]))
        values[-1] = np.copysign(rest, values[-1].real)
    return np.asarray(values * np.exp(log_scale))


# --- the orbits near the motions of an ensemble -----------------------------------------------------------------------

NEWTON_STEPS = 8
CLOSED = 1e-9
"""An orbit is found when Newton's step is smaller than this share of its size: the next one would be rounding."""
LARGEST_GROWTH = 1e3
"""The search ends where a step leads this many times further out than the motion's size."""


@dataclass(frozen=True)
class Orbits:
    """Orbits near the states of members, arrays (members, ...).

    ``found``; ``nodes`` (members, repeats, segments, N), the first at phase 0; ``tangents`` (members, n, N, N) of the
    segments; ``times`` of a whole map; ``size``, the largest state.
    """

    found: npt.NDArray[np.bool_]
    nodes: Array
    tangents: Array
    times: Array
    size: Array


def find_orbits(
    members: Members,
    states: Array,
    kind: Kind,
    *,
    steps: int = NEWTON_STEPS,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
) -> Orbits:
    """The orbits of one kind to which Newton's method leads from ``states`` (members, N) at phase 0.

    It begins with the motion from there as nodes. Members with an unlike number of segments do not mix: the numbers of
    a member depend on itself alone.
    """
    repeat = members.forcing_period
    segments = np.array([segments_for(rate, time) for rate, time in zip(members.rate, repeat, strict=True)], dtype=int)
    size, width = states.shape[1], int(segments.max(initial=FEWEST_SEGMENTS))
    found = np.zeros(members.size, dtype=bool)
    nodes = np.full((members.size, kind.repeats, width, size), np.nan)
    tangents = np.full((members.size, kind.repeats * width, size, size), np.nan)
    for count in np.unique(segments):
        rows = np.flatnonzero(segments == count)
        ensemble = _Ensemble(members.take(rows), kind, int(count), tolerance, threads)
        own, maps, good = ensemble.newton(states[rows], steps)
        found[rows] = good
        nodes[rows, :, :count] = own.reshape(rows.size, kind.repeats, count, size)
        tangents[rows, : own.shape[1]] = maps
        tangents[rows, own.shape[1] :] = np.eye(size)
    with np.errstate(invalid="ignore"):
        extent = np.nanmax(np.abs(nodes), axis=(1, 2, 3), initial=0.0)
    return Orbits(found, nodes, tangents, kind.repeats * repeat, extent)


class _Ensemble:
    """Multiple shooting for members with the same number of segments, all lanes of the engine at once."""

    def __init__(self, members: Members, kind: Kind, segments: int, tolerance: float, threads: int | None) -> None:
        self.members, self.kind, self.segments = members, kind, segments
        self.signs = members.system.mirror if kind.reflected else np.ones(len(members.system.states))
        self.program = phase_program(members.system, (), tolerance)
        self.threads = threads or available_threads()
        self.phase = members.forcing_period * members.number("drive_frequency")

    def pass_over(self, which: npt.NDArray[np.intp], nodes: Array) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
        """Ends (members, n, N) and tangent maps of the segments that begin at ``nodes`` (members, n, N), and of which
        members all arrived."""
        members, (count, n, size) = self.members.take(which), nodes.shape
        per = self.segments
        place = np.tile(np.arange(n) % per, (count, 1))
        start = place * (self.phase[which, None] / per)
        end = (place + 1) * (self.phase[which, None] / per)
        states = np.zeros((count * n, size * (1 + size)))
        states[:, :size] = nodes.reshape(-1, size)
        states[:, size:] = np.eye(size).ravel()
        numbers = {name: np.repeat(members.number(name), n) for name in members.system.numbers}
        numbers |= self.program.switches_at(start.ravel(), nodes.reshape(-1, size), numbers)
        numbers |= {name: np.zeros(count * n) for name in self.program.numbers if name not in numbers}
        watch = current_watch()
        smallest = smallest_step(members) * members.number("drive_frequency")
        run, arrived, steps = self.program.run(
            numbers,
            states,
            start.ravel(),
            end.ravel(),
            smallest_step=np.repeat(smallest, n),
            threads=self.threads,
            stopped=None if watch is None else watch.stop.is_set,
        )
        if watch is not None:
            watch.steps += steps
            if watch.stop.is_set():
                raise Stopped
        whole = run.reshape(count, n, -1)
        maps = whole[..., size:].reshape(count, n, size, size).swapaxes(-1, -2)
        good = arrived.reshape(count, n) & np.isfinite(whole).all(axis=2)
        return whole[..., :size], maps, np.asarray(good.all(axis=1))

    def newton(self, states: Array, steps: int) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
        """Nodes (members, n, N), tangent maps, and which members closed."""
        count, size = states.shape
        n = self.segments * self.kind.repeats
        nodes, alive = self._unrolled(states, n)
        maps = np.full((count, n, size, size), np.nan)
        found = np.zeros(count, dtype=bool)
        scale = np.maximum(np.abs(nodes).max(axis=(1, 2)), 1e-3)
        rows = np.flatnonzero(alive)
        for _ in range(steps + 1):
            if not rows.size:
                break
            ends, tangents, arrived = self.pass_over(rows, nodes[rows])
            maps[rows] = tangents
            gaps = ends - np.concatenate([nodes[rows, 1:], self.signs * nodes[rows, :1]], axis=1)
            step = _ring_steps(tangents, self.signs, gaps)
            length = np.abs(step).max(axis=(1, 2)) / scale[rows]
            with np.errstate(invalid="ignore"):
                good = arrived & (length < LARGEST_GROWTH)
            nodes[rows[good]] += step[good]
            closed = good & (length < CLOSED)
            found[rows[closed]] = True
            rows = rows[good & ~closed]
        return nodes, maps, found

    def _unrolled(self, states: Array, n: int) -> tuple[Array, npt.NDArray[np.bool_]]:
        """The motion from ``states`` at the beginnings of n segments, and whose motion got there."""
        times = self.members.forcing_period[:, None] * (np.arange(n) / self.segments)
        run = integrate(self.members, states, times, tolerance=1e-12, threads=self.threads)
        return run.states, np.asarray(np.isfinite(run.states).all(axis=(1, 2)))


def _ring_steps(tangents: Array, signs: Array, gaps: Array) -> Array:
    """Newton's steps (members, n, N); NaN where the equations are singular."""
    count, n, size = gaps.shape
    none = np.zeros((count, n, size, 0))
    rows, corner, top = np.zeros((count, 0, n, size)), np.zeros((count, 0, 0)), np.zeros((count, 0, 1))
    try:
        return solve_ring(tangents, signs, gaps[..., None], none, rows, corner, top, np.inf)[0][..., 0]
    except np.linalg.LinAlgError:
        steps = [
            np.full((1, n, size), np.nan) if count == 1 else _ring_steps(t[None], signs, g[None])
            for t, g in zip(tangents, gaps, strict=True)
        ]
        return np.concatenate(steps)
