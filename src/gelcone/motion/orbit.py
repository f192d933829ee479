"""Periodic orbits by Newton's method with multiple shooting, their multipliers and their derivatives by parameters.

An orbit is a fixed point of the map over some repeats of the drive; a symmetric orbit is a fixed point of the map over
half its period followed by the mirror image. The map is cut into segments whose end states must meet, so that unstable
orbits of any strength are found: single shooting loses an orbit whose multipliers reach 1e8. Time is the phase of the
drive. Ascher, Mattheij and Russell, Numerical Solution of Boundary Value Problems (1988), chapter 4; Seydel, Practical
Bifurcation and Stability Analysis (2010), chapter 7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.cyclic import scaled_product
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate, phase_program, smallest_step
from gelcone.motion.job import Trajectories
from gelcone.motion.multipliers import log_multipliers, multipliers_of_rings
from gelcone.motion.tangents import contraction, solved
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.members import Members
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

SEGMENT = 12.0
"""Longest segment in units of the fastest linear time scale. Along the branches of the paper's sets deviations grow by
less than 1,000 in one. Shorter segments cost more and change no digit."""
FEWEST_SEGMENTS = 4
DIFFERENCE = 1e-6
"""Relative step of the differences for the derivatives of the formulas' numbers by a parameter. They enter Newton's
matrix alone, so that their error does not affect the orbit."""
MOST_KNOWN = 64
"""Most values of the free quantities whose numbers are stored."""
Settings = Callable[[Sequence[Any]], dict[str, Any]]
"""Values of the free quantities -> parameters of the model."""


class Kind(NamedTuple):
    """The map whose fixed point an orbit is: over a number of ``repeats`` of the drive and, if ``reflected``, followed
    by the mirror image x -> -x."""

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
    """One pass over all segments: their ``ends`` (n, N), ``tangents`` (n, N, N) and ``slopes`` (n, N, P) by the free
    quantities; and ``arrived``, true if all of them did."""

    ends: Array
    tangents: Array
    slopes: Array
    arrived: bool


def repeat_phase(members: Members) -> float:
    """Phase of the drive in one repeat of the force: pi or 2 pi, the same for all members."""
    phases = members.forcing_period * members.number("drive_frequency")
    return float(np.round(np.max(phases) / np.pi) * np.pi)


def segments_for(rate: float, repeat: float) -> int:
    """Number of segments of a repeat, a power of 2, from the fastest ``rate`` and the length of the ``repeat``."""
    return int(2 ** max(np.ceil(np.log2(max(rate * repeat / SEGMENT, 1.0))), np.log2(FEWEST_SEGMENTS)))


class Shooting:
    """Passes over one orbit of one actuator while parameters change.

    Parameters
    ----------
    members : the actuator, one member.
    free : names of the free quantities, whose values `run` takes.
    kind : the map.
    segments : of one repeat.
    phase : of one repeat, pi or 2 pi.
    tolerance : relative error of one step of the integrator.
    settings : function that turns values of the free quantities, each a number or an array, into the model's parameters
        by name. Default: the free quantities are parameters themselves.
    around : typical values of the free quantities. Default: that of the actuator.
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
        self.system: ConeSystem = members.system
        self.free: tuple[str, ...] = tuple(free)
        self.kind: Kind = kind
        self.segments: int = segments
        self.phase: float = phase
        self.tolerance: float = tolerance
        self.size: int = len(self.system.states)
        self.count: int = segments * kind.repeats
        self._members = members
        self._values: dict[str, Any] = {name: float(value[0]) for name, value in members.values.items()}
        self._given = settings
        self._settings = settings or (lambda values: dict(zip(self.free, values, strict=True)))
        self._around = tuple(self._values[name] for name in self.free) if around is None else tuple(around)
        self._numbers = self.system.numbers_of(self._values | self._settings(self._around))
        self._moved = tuple(self._moved_by(k) for k in range(len(self.free)))
        self._check_moved()
        # most parameters are a number of the formulas and change no other one
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
        self._program, self._starts, self._ends = program, start, end
        self._place = {name: k for k, name in enumerate(program.numbers)}
        self._own = np.array([self._place[name] for name in self._numbers])
        self._row = np.zeros(len(self._place))
        self._row[self._own] = [*self._numbers.values()]
        self._states = np.zeros((self.count, self.size * (1 + self.size + len(self.free))))
        self._states[:, self.size : self.size * (1 + self.size)] = np.eye(self.size).ravel()
        self._kinds: dict[Kind, Shooting] = {kind: self}
        self._smallest = float(smallest_step(members)[0])

    def _check_moved(self) -> None:
        """Raises `InputError` for a parameter that shapes the pieces of the drive, whose tables have no derivatives."""
        shaping = set(self.system.waveform.parameters) - set(VOLTAGE) if self.system.waveform.pieced else set()
        if taken := sorted(shaping & {name for moved in self._moved for name in moved}):
            raise InputError(f"{taken[0]}: shapes the drive's pieces; a branch cannot follow it, run it at some values")

    @cached_property
    def signs(self) -> Array:
        """The signs that close the orbit: z(end) = signs z(start)."""
        return self.system.mirror if self.kind.reflected else np.ones(self.size)

    @cached_property
    def symmetric(self) -> bool:
        """True if the mirror image of a motion is a motion."""
        return bool(self._members.symmetric[0])

    def of_kind(self, kind: Kind) -> Shooting:
        """Shooting for another map."""
        if kind not in self._kinds:
            same = self.segments, self.phase, self.tolerance, self._given, self._around
            other = Shooting(self._members, self.free, kind, *same)
            other._kinds = self._kinds
            self._kinds[kind] = other
        return self._kinds[kind]

    def numbers_at(self, values: Sequence[float]) -> dict[str, float]:
        """The numbers of the formulas at values of the free quantities, by name."""
        if self._plain:
            return self._numbers | dict(zip(self.free, map(float, values), strict=True))
        return self._with_slopes(values)[0]

    def members_at(self, values: Sequence[Any]) -> Members:
        """The actuator at values of the free quantities, each a number or an array (members,)."""
        size = max((np.size(value) for value in values), default=1)
        return Members(self.system, self._values | self._settings(values), size)

    def _with_slopes(self, values: Sequence[float]) -> tuple[dict[str, float], Array]:
        """The numbers of the formulas, and their changes over a step of each free quantity, (numbers, free)."""
        at = tuple(map(float, values))
        if at not in self._known:
            count, apart = len(at), DIFFERENCE * np.array(_steps(at))
            near = np.tile(np.array(at)[:, None], 1 + 2 * count)
            near[np.arange(count), 1 + 2 * np.arange(count)] += apart
            near[np.arange(count), 2 + 2 * np.arange(count)] -= apart
            numbers = self.system.numbers_of(self._values | self._settings([*near]))
            table = np.stack([np.broadcast_to(np.asarray(v, dtype=float), near.shape[1:]) for v in numbers.values()])
            slopes = (table[:, 1::2] - table[:, 2::2]) * (0.5 / DIFFERENCE)
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            self._known[at] = dict(zip(numbers, table[:, 0].tolist(), strict=True)), slopes
        return self._known[at]

    def repeat_time(self, values: Sequence[float]) -> float:
        """Time of one repeat."""
        return self.phase / float(self.numbers_at(values)["drive_frequency"])

    def _moved_by(self, k: int) -> tuple[str, ...]:
        """Names of the numbers that depend on the k-th free quantity."""
        other = list(self._around)
        other[k] += DIFFERENCE
        after = self.system.numbers_of(self._values | self._settings(other))
        return tuple(number for number in self.system.numbers if after[number] != self._numbers[number])

    def run(self, nodes: Array, values: Sequence[float]) -> Pass:
        """All segments from ``nodes`` (n, N) at ``values`` of the free parameters.

        The arrays are valid until the next run.
        """
        steps = _steps(values)
        self._set_row(values, steps)
        n, size = self.count, self.size
        self._states[:, :size] = nodes
        switches = corners = None
        if self._program.switches:
            node_numbers = self.numbers_at(values)
            switches = self._program.switches_at(self._starts, nodes, node_numbers)
            corners = self._program.corners(self._starts, self._ends, node_numbers)
        smallest = self._smallest * self._row[self._place["drive_frequency"]]
        result, arrived = self._rerun.run(self._row, self._states, smallest, switches, corners)
        tangents = result[:, size : size * (1 + size)].reshape(n, size, size).transpose(0, 2, 1)
        slopes = result[:, size * (1 + size) :].reshape(n, len(steps), size).transpose(0, 2, 1)
        if self.system.charged:
            numbers = dict(zip(self._program.numbers, self._row.tolist(), strict=True))
            states, phases = (nodes, result[:, :size]), (self._starts, self._ends)
            with np.errstate(all="ignore"):  # of a motion that leaves the domain
                tangents, slopes = self._program.of_states(phases, states, tangents, slopes, numbers)
        slopes = slopes / (steps[0] if len(steps) == 1 else np.array(steps))
        return Pass(result[:, :size], tangents, slopes, bool(arrived.all()))

    def _set_row(self, values: Sequence[float], steps: Sequence[float]) -> None:
        """Sets the numbers of a run, in the order of the program."""
        row, place = self._row, self._place
        if self._plain:
            for k, name in enumerate(self.free):
                row[place[name]], row[place[f"{name} by {k}"]] = values[k], steps[k]
            return
        numbers, slopes = self._with_slopes(values)
        row[self._own] = [*numbers.values()]
        by_name = dict(zip(numbers, slopes, strict=True))
        for k, moved in enumerate(self._moved):
            for number in moved:
                row[place[f"{number} by {k}"]] = by_name[number][k]

    @property
    def pulled_in(self) -> bool:
        """True if the last run ended where the film pulls in."""
        return self._rerun.met_event or self.system.film.ending == Outcome.PULLED_IN

    def gaps(self, nodes: Array, ends: Array) -> Array:
        """The gap between the end of each segment and the next node, (n, N)."""
        ahead = np.empty_like(nodes)
        ahead[:-1], ahead[-1] = nodes[1:], self.signs * nodes[0]
        return ends - ahead

    def log_determinant(self, values: Sequence[float]) -> float:
        """Logarithm of the determinant of the map of a planar system, -2 zeta times its length."""
        numbers = self.numbers_at(values)
        time = self.phase / float(numbers["drive_frequency"])
        return -2.0 * float(numbers["damping_ratio"]) * self.kind.repeats * time

    def multipliers(self, tangents: Array, values: Sequence[float]) -> npt.NDArray[np.complex128]:
        """Multipliers (N,) of the map, the mirror image included where it is reflected, the largest modulus first."""
        if not self.system.planar:
            rings = multipliers_of_rings(tangents[None], self.signs, self.tolerance)
            with np.errstate(over="ignore"):
                return np.asarray((np.exp(rings.log_modulus) * rings.direction)[0])
        product, scale = scaled_product(tangents)
        return multipliers_of(self.signs[:, None] * product, float(scale), self.log_determinant(values))

    def inside(self, nodes: Array, values: Sequence[float]) -> bool:
        """True if the displacements of all nodes are inside the stretch limits of all films."""
        n = self.numbers_at(values)
        with np.errstate(all="ignore"):
            return bool(np.all(self.system.strain(nodes[:, 0], n) < self.system.strain_limit(n)))


def _steps(values: Sequence[float]) -> list[float]:
    """Typical changes of the free quantities. Derivatives are integrated over these, so that they have the size of the
    states."""
    return [max(0.1 * abs(value), 1e-3) for value in values]


def multipliers_of(product: Array, log_scale: float, log_determinant: float) -> npt.NDArray[np.complex128]:
    """Eigenvalues (2,) of a scaled map of the plane, the larger modulus first, from trace and determinant.

    The determinant is given, since for a map that grows the computed one would be rounding.
    """
    half = 0.5 * (product[0, 0] + product[1, 1])
    inner = half * half - np.exp(log_determinant - 2.0 * log_scale)
    if inner < 0.0:
        pair = complex(half, np.sqrt(-inner)) * np.exp(log_scale)
        return np.array([pair, pair.conjugate()])
    larger = half + np.copysign(np.sqrt(inner), half)
    return np.array([larger * np.exp(log_scale), np.exp(log_determinant - log_scale) / larger], dtype=complex)


# --- the orbits near the motions of an ensemble -----------------------------------------------------------------------


class Turn(NamedTuple):
    """One turn of members during Newton's method for their orbits.

    ``point`` (members, N), its start at phase 0; ``path`` (members, n, N), the ends of the segments;
    ``log_multipliers`` (members, N), logarithms of the moduli of the multipliers, the largest first, and their
    ``error`` by errors in the tangent maps, as of `gelcone.motion.multipliers.log_multipliers`; Newton's ``step``
    (members, N) at the point; ``contraction`` (members,), the logarithm of the change of a volume of states over the
    turn. NaN for a run that has ended.
    """

    point: Array
    path: Array
    log_multipliers: Array
    error: Array
    step: Array
    contraction: Array


def newton(
    members: Members, states: Array, repeats: int, segments: int, tolerances: Sequence[float], **flow: Any
) -> Iterator[Turn]:
    """Newton's steps towards the orbits over ``repeats`` of the drive near ``states`` (members, N) at phase 0.

    Each turn has the next of the ``tolerances`` of the integrator; the first turn is the motion itself. In later turns
    each of the ``segments`` of a repeat is a run of its own, so that even few members fill the lanes of the integrator.
    ``flow`` goes to `integrate`. The numbers of a member depend on itself alone.
    """
    count, size = states.shape
    n = repeats * segments
    times = members.forcing_period[:, None] * (np.arange(n + 1) / segments)
    run = integrate(members, states, times[:, 1:], keep="tangents", tolerance=tolerances[0], **flow)
    nodes = np.concatenate([states[:, None], run.states[:, :-1]], axis=1)
    yield (turn := _turn(members, nodes, run, times[:, -1], tolerances[0]))[0]
    segment_members = members.take(np.repeat(np.arange(count), n))
    for tolerance in tolerances[1:]:
        nodes = nodes + turn[1]
        run = integrate(
            segment_members,
            nodes.reshape(-1, size),
            times[:, 1:].reshape(-1, 1),
            start=times[:, :-1].ravel(),
            keep="tangents",
            tolerance=tolerance,
            **flow,
        )
        yield (turn := _turn(members, nodes, run, times[:, -1], tolerance))[0]


def _turn(members: Members, nodes: Array, run: Trajectories, time: Array, tolerance: float) -> tuple[Turn, Array]:
    """The turn whose segments begin at ``nodes`` (members, n, N) and last ``time`` (members,) together, and Newton's
    steps at all nodes."""
    assert run.tangents is not None
    size = nodes.shape[-1]
    path, tangents = run.states.reshape(nodes.shape), run.tangents.reshape(*nodes.shape, size)
    product, log_scale = scaled_product(tangents)
    shrunk = contraction(members, run, time[:, None]).reshape(len(nodes), -1).sum(axis=1)
    moduli, error = log_multipliers(tangents, (product, log_scale), shrunk, tolerance)
    step = _condensed(tangents, product, log_scale, path - np.roll(nodes, -1, axis=1))
    return Turn(nodes[:, 0], path, moduli, error, step[:, 0], shrunk), step


def _condensed(tangents: Array, product: Array, log_scale: Array, gaps: Array) -> Array:
    """Newton's steps (members, n, N) that close the ``gaps`` between the segments; those of a member depend on itself
    alone.

    All equations are condensed into those of the first node (Bock and Plitt, IFAC Proceedings 17 (1984) 1603). On an
    orbit of strong growth the loss of digits in the step costs further steps, but no accuracy, since the gaps are
    computed segment by segment.
    """
    n, size = gaps.shape[1:]
    end = gaps[:, 0]
    for k in range(1, n):
        end = mapped(tangents[:, k], end) + gaps[:, k]
    steps = np.empty(gaps.shape)
    steps[:, 0] = solved(np.eye(size) - product * np.exp(log_scale)[:, None, None], end)
    for k in range(1, n):
        steps[:, k] = mapped(tangents[:, k - 1], steps[:, k - 1]) + gaps[:, k - 1]
    return steps


def mapped(matrices: Array, vectors: Array) -> Array:
    """Each vector (members, N) times its matrix (members, N, N), summed in one order."""
    return np.asarray((matrices * vectors[:, None, :]).sum(axis=2))
