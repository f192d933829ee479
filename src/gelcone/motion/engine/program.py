"""Programs: a system of equations of motion compiled for one purpose and tolerance, run over any number of members."""

from __future__ import annotations

import ctypes
import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.loop import module_text, step_text
from gelcone.motion.engine.plan import (
    ARRIVED,
    NOT_FINITE,
    STEP_TOO_SMALL,
    TERMINAL_EVENT,
    TOO_MANY_STEPS,
    Border,
    Job,
    Law,
    Layout,
    Plan,
)
from gelcone.motion.engine.recurrences import equations_of
from gelcone.physics.members import Rows
from gelcone.physics.trace import Graph, Node, fingerprint, ordered

__all__ = [
    "ARRIVED",
    "NOT_FINITE",
    "STEP_TOO_SMALL",
    "TERMINAL_EVENT",
    "TOO_MANY_STEPS",
    "Event",
    "Program",
    "Raw",
    "Rerun",
    "System",
]

Array = npt.NDArray[np.float64]
Keep = Literal["states", "tangents", "work"]

STEPS_PER_CALL = 256
"""Steps of all lanes in the first call of the compiled loop."""
CALL_SECONDS = 0.02
"""Duration of later calls: between calls interrupts and progress are served."""
REPORT_EVERY = 0.05
"""Seconds between two reports of progress."""
DISC_STATES = 2
"""States without which the trace of the Jacobian depends on the damping alone."""
MOST_TELLING = 4
"""Switches that distinguish laws: each more of them doubles the code."""
_ALIGNMENT = 128
_ADDRESSES = tuple(field.name.lower() for field in list(Job)[: Job.MEMBERS])


class System(Protocol):
    """The equations that a program is made of. Every formula is traced with a `Graph` as ``xp``."""

    @property
    def states(self) -> tuple[Any, ...]:
        """The state variables, one each."""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers in the formulas, of which each member has its own."""

    def rates(self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> Sequence[Any]:
        """Rates of change of the states, (N,)."""

    def flow(
        self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any
    ) -> tuple[Sequence[Any], Sequence[Sequence[Any]]]:
        """Rates (N,) and their derivatives with respect to the states (N, N)."""

    def powers(self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> tuple[Any, ...]:
        """Powers whose integrals ``"work"`` keeps."""

    @property
    def bounding_powers(self) -> int:
        """Number of the first of them that bear on the length of steps; the others have the motion's poles alone."""


@dataclass(frozen=True)
class Raw:
    """The result of a run; samples that a member did not reach are NaN.

    ``states`` (members, samples, N); ``tangents`` (members, samples, N, N), [..., i, j] the derivative of state i with
    respect to state j of the previous sample, or of the start; ``divergence`` (members, samples), the integral of the
    Jacobian's trace since then, unless it is known (a `planar` system); ``work`` (members, samples, powers), the
    integrals of the powers since the start. ``status`` (members,): `ARRIVED`, `NOT_FINITE`, `STEP_TOO_SMALL`,
    `TOO_MANY_STEPS` or `TERMINAL_EVENT` + the number of the event. ``steps`` and ``smallest_step`` (members,): how many
    steps, and the shortest that the tolerance asked for. ``end_time`` (members,), ``end_state`` (members, N) and
    ``switches``, name -> (members,): the last that is known of a member; a run from there continues with these.
    ``dwell`` (members, 2^switches): how long each combination of signs of the switches lasted; bit k of the place is
    set where the k-th switch is negative.
    """

    states: Array
    tangents: Array | None
    divergence: Array | None
    work: Array | None
    status: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    smallest_step: Array
    end_time: Array
    end_state: Array
    switches: Mapping[str, Array]
    dwell: Array


def order_and_label(tolerance: float, keep: str = "states") -> tuple[int, float]:
    """Order of the Taylor polynomials and tolerance of the step rule for a relative error of one step.

    Order 8 for tolerances above 3e-8, 12 above 3e-11, else 18, or 16 with tangents: each ran fastest at the error that
    it gives. The step rule takes a tenth of the tolerance, so that the errors are those of heyoka at ``tolerance``, and
    at least 3e-16, or 1e-15 with tangents: steep films still gain from that, nothing from less.
    """
    tangents = keep == "tangents"
    order = 8 if tolerance > 3e-8 else 12 if tolerance > 3e-11 else 16 if tangents else 18
    return order, max(tolerance / 10.0, 1e-15 if tangents else 3e-16)


class Program:
    """A compiled integrator of one system.

    Parameters
    ----------
    system : the equations of motion.
    keep : ``"states"``; ``"tangents"`` adds the tangent maps between samples, ``"work"`` the integrals of the powers.
    tolerance : relative error of one step, between 0 and 1; see `order_and_label`.
    events : borders at which a member ends or a number changes its sign.
    pieces : names of the numbers of a piece of the drive: its beginning, which is the time of the last corner, and its
        terms, which `run` is given.
    width : lanes; default by the number of members. It does not change a bit of the result.
    machine : what to compile for; default this process's machine. It does not either.

    Raises
    ------
    ValueError : for an unknown ``keep``, a tolerance out of bounds, or a switch that is not among the numbers.
    """

    def __init__(
        self,
        system: System,
        keep: str = "states",
        tolerance: float = 1e-15,
        events: Sequence[Event] = (),
        *,
        pieces: Sequence[str] = (),
        width: int | None = None,
        machine: compiler.Machine | None = None,
    ) -> None:
        if keep not in get_args(Keep):
            raise ValueError(f"keep = {keep!r}: must be one of {', '.join(get_args(Keep))}")
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"tolerance = {tolerance!r}: must be between 0 and 1")
        self.keep = keep
        self.size = len(system.states)
        self.numbers = tuple(system.numbers)
        self.order, self.label = order_and_label(tolerance, keep)
        self._machine = machine
        self._width = width
        self._lock = threading.Lock()
        self._compiled: dict[int, _Compiled] = {}
        self.piece_terms = max(len(pieces) - 1, 0)
        self._traced = _trace(system, keep, events, tuple(pieces))

    def _plan(self, width: int) -> Plan:
        return Plan(**self._traced, order=self.order, tolerance=self.label, width=width)

    def module_text(self, width: int) -> str:
        """The LLVM module that is compiled for this many lanes."""
        return module_text(self._plan(width))

    def _best_width(self, members: int, threads: int) -> int:
        """Lanes that run fastest: two registers side by side hide waiting times, as long as the numbers of the step
        find room in the others, and every thread has lanes to fill."""
        vector = (self._machine or compiler.host()).vector
        wide = self.order <= 12 and self.keep != "tangents" and members > vector * threads
        return 2 * vector if wide else vector

    def _compile(self, width: int) -> _Compiled:
        with self._lock:
            if width not in self._compiled:
                self._compiled[width] = _Compiled(self._plan(width), self._machine)
            return self._compiled[width]

    def run(
        self,
        numbers: Mapping[str, npt.ArrayLike],
        states0: npt.ArrayLike,
        start: npt.ArrayLike,
        times: npt.ArrayLike,
        *,
        smallest_step: npt.ArrayLike = 0.0,
        most_steps: npt.ArrayLike = 1e9,
        threads: int = 1,
        corners: npt.ArrayLike | None = None,
        terms: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        report: Callable[[float], None] | None = None,
        stopped: Callable[[], bool] | None = None,
    ) -> Raw:
        """Integrates all members.

        Parameters
        ----------
        numbers : name -> values, scalar or (members,).
        states0 : initial states, (members, N).
        start : time of the initial states, scalar or (members,).
        times : sample times, (members, samples), increasing along a row and not before the start.
        smallest_step : a member ends where its step falls below this, scalar or (members,).
        most_steps : number of steps after which a member ends, scalar or (members,).
        threads : how many threads work; does not change a bit of the result.
        corners : increasing times, (members, corners), at which steps end; infinite ones and those before the start
            are left out. Default none.
        terms : the terms of the pieces, (members, pieces, terms), and the piece that begins at the first corner of each
            member, (members,); behind the last piece comes the first again.
        report : called from this thread, now and then, with the share of the work done since the last call.
        stopped : asked now and then; the run ends early, with what is there, once it returns True.

        Raises
        ------
        ValueError : for arrays that do not fit, times that do not increase, a number that is missing, or fewer threads
            than one.
        """
        if threads < 1:
            raise ValueError(f"threads = {threads!r}: must be at least 1")
        sample_times = np.ascontiguousarray(times, dtype=float)
        members, samples = sample_times.shape
        first = _each(start, members)
        known = np.isfinite(sample_times).all() and np.isfinite(first).all()
        later = (sample_times[:, 1:] > sample_times[:, :-1]).all() and (sample_times[:, :1] >= first[:, None]).all()
        if not (known and later):
            raise ValueError("times: must be finite, increase, and not be before the start")
        compiled = self._compile(self._width or self._best_width(members, threads))
        arrays = compiled.job(numbers, states0, first, sample_times, smallest_step, most_steps, corners, terms)
        if members and samples:
            _Run(compiled, arrays, threads, report, stopped).work()
        result, count = arrays.result, self.size
        extra, deviations = result[..., count:], self.keep == "tangents"
        return Raw(
            states=result[..., :count],
            tangents=extra[..., : count * count].reshape(members, samples, count, count) if deviations else None,
            divergence=extra[..., -1] if deviations and extra.shape[-1] > count * count else None,
            work=extra if self.keep == "work" else None,
            status=arrays.status,
            steps=arrays.steps.astype(np.int64),
            smallest_step=arrays.least,
            end_time=arrays.end_time,
            end_state=arrays.end_state[:, :count],
            switches={
                node.value: values for node, values in zip(compiled.plan.switches, arrays.switches.T, strict=True)
            },
            dwell=arrays.dwell,
        )


class Rerun:
    """A program run again and again by one thread, with arrays that are made once. ``numbers`` names what `run` takes.

    For some tens of members over a short time, where setting up a run would take longer than the run. `run` changes no
    bit of what `Program.run` gives.

    Parameters
    ----------
    program : what is run.
    start, end : times of the initial states and of the one sample, (members,).
    most_steps : number of steps after which a member ends.
    corners : room for corners, (members, corners), and ``pieces`` of the drive, of which `run` is given the terms.
    """

    def __init__(
        self, program: Program, start: Array, end: Array, most_steps: float, corners: int = 0, pieces: int = 0
    ) -> None:
        members = start.size
        compiled = program._compile(program._width or program._best_width(members, 1))
        plan, layout = compiled.plan, compiled.layout
        zeros = dict.fromkeys(plan.numbers, 0.0)
        states = np.zeros((members, layout.states))
        self.numbers = program.numbers
        self._compiled = compiled
        self._arrays = arrays = compiled.job(
            zeros, states, start, end[:, None], 0.0, most_steps, *_room(program, members, corners, pieces)
        )
        self._job = arrays.fields(plan.slots)
        self._values = aligned(len(plan.numbers), arrays.padded)
        self._work = _Work(compiled, self._job)
        self._table = self._values.ctypes.data, arrays.table.ctypes.data, arrays.padded
        self._members = members

    def run(
        self,
        numbers: Array,
        states0: Array,
        smallest_step: float,
        switches: Array | None = None,
        corners: tuple[Array, Array, Array] | None = None,
    ) -> tuple[Array, npt.NDArray[np.bool_]]:
        """The states at the end, (members, states), valid until the next run, and which members arrived.

        ``numbers`` (names,) or (names, members) in the order of `numbers`; ``states0`` (members, states); ``switches``
        (members, switches) where events or corners switch numbers, in the order of the events, those of corners last;
        ``corners`` their times, the terms of the pieces and the piece that begins at the first, as `Program.run` takes.
        """
        compiled, arrays = self._compiled, self._arrays
        if numbers.ndim == 1:
            self._values[:] = numbers[:, None]
        else:
            self._values[:] = numbers[:, -1:]
            self._values[:, : self._members] = numbers
        compiled.prepare(*self._table)
        arrays.states[:] = states0
        arrays.smallest[:] = smallest_step
        if switches is not None:
            arrays.switches[:] = switches
        if corners is not None:
            times, terms, first = corners
            arrays.corners[:] = np.inf
            arrays.corners[:, : times.shape[1]] = times
            arrays.pieces[:], arrays.first_piece[:] = terms, first
        self._run_again()
        return arrays.result[:, 0], arrays.status == ARRIVED

    def _run_again(self) -> None:
        """Run all members from what the arrays hold."""
        self._job[Job.NEXT] = 0
        self._work.start()
        while self._work.going:
            self._work.advance(1 << 20)

    @property
    def met_event(self) -> bool:
        """Whether a member of the last run ended at a terminal event."""
        return bool((self._arrays.status >= TERMINAL_EVENT).any())


def _trace(system: System, keep: str, events: Sequence[Event], pieces: tuple[str, ...]) -> dict[str, Any]:
    """The system's formulas as fields of a `Plan`."""
    graph = Graph()
    count = len(system.states)
    state = [graph.state(i) for i in range(count)]
    names = [event.switch for event in events] + list(pieces)
    switched = tuple(dict.fromkeys(name for name in names if name is not None))
    for name in switched:
        if name not in system.numbers:
            raise ValueError(f"switch = {name!r}: is not among the numbers {', '.join(system.numbers)}")
    n = {name: graph.switch(name) if name in switched else graph.number(name) for name in system.numbers}
    telling = list(dict.fromkeys(event.switch for event in events if event.divides and event.switch is not None))
    telling = telling[:MOST_TELLING]

    laws = []
    for signs in range(2 ** len(telling)):
        own = {name: graph.constant(-1.0 if signs >> k & 1 else 1.0) for k, name in enumerate(telling)}
        laws.append(_law(graph, system, keep, events, state, n | own))
    return {
        "laws": tuple(laws),
        "telling": tuple(switched.index(name) for name in telling),
        "borders": tuple(_border(k, event, n, laws, telling, switched) for k, event in enumerate(events)),
        "switches": tuple(graph.switch(name) for name in switched),
        "numbers": tuple(system.numbers),
        "restarts": _restarts(keep, count, len(laws[0].rates)),
        "passengers": _passengers(system, keep, len(laws[0].rates)),
        "pieces": len(pieces),
    }


def _border(
    k: int, event: Event, n: Mapping[str, Node], laws: Sequence[Law], telling: Sequence[str], switched: Sequence[str]
) -> Border:
    """The k-th event as a border between the laws; ``switched``, the names of all switches."""
    switch = None if event.switch is None else n[event.switch]
    own_switch = event.switch in telling or any(switch in ordered([law.borders[k]]) for law in laws)
    if own_switch and not event.direction:
        raise ValueError(f"direction = 0: a border that contains its switch {event.switch!r} takes -1 or 1")
    place = None if event.switch is None else switched.index(event.switch)
    return Border(event.direction, place, own_switch or event.inside, event.smooth, event.seldom)


def _law(
    graph: Graph, system: System, keep: str, events: Sequence[Event], state: Sequence[Any], n: Mapping[str, Any]
) -> Law:
    """What the states obey where the numbers are ``n``."""
    count = len(state)
    if keep == "tangents":
        flow, slopes = system.flow(graph.time, state, n, graph)
        rates = [graph.node(rate) for rate in flow]
        deviation = [[graph.state(count + count * i + j) for j in range(count)] for i in range(count)]
        for i in range(count):
            for j in range(count):
                terms = [graph.multiply(slopes[i][k], deviation[k][j]) for k in range(count)]
                rates.append(sum(terms, graph.constant(0.0)))
        if count > DISC_STATES or not getattr(system, "planar", True):  # else it is known
            rates.append(graph.node(sum((slopes[i][i] for i in range(count)), graph.constant(0.0))))
    else:
        rates = [graph.node(rate) for rate in system.rates(graph.time, state, n, graph)]
        if keep == "work":
            rates += [graph.node(power) for power in system.powers(graph.time, state, n, graph)]
    values = [graph.node(event.border(graph.time, state, n, graph)) for event in events]
    return Law(tuple(rates), tuple(values), equations_of([*rates, *values]))


def _restarts(keep: str, count: int, rates: int) -> tuple[float | None, ...]:
    """What the states are set to after each sample: those of the system, ``count``, and the others of ``rates``."""
    if keep != "tangents":
        return (None,) * rates
    unit = [float(i == j) for i in range(count) for j in range(count)]
    return (*[None] * count, *unit, *[0.0] * (rates - count - len(unit)))


def _passengers(system: System, keep: str, rates: int) -> int:
    """How many of the last states are integrals that do not shorten the steps."""
    count = len(system.states)
    bounding = {"states": 0, "tangents": count * count}
    return rates - count - (system.bounding_powers if keep == "work" else bounding[keep])


class _Compiled:
    """The machine code of one plan."""

    def __init__(self, plan: Plan, machine: compiler.Machine | None) -> None:
        self.plan = plan
        self.layout = Layout(plan)
        self._machine, self._content = machine, _content(plan)
        # the steps of several laws have modules of their own; what is left runs once a sample or crossing
        level = compiler.HOT if len(plan.laws) == 1 else compiler.COLD
        library = compiler.library(self._content, lambda: module_text(plan), machine, level)
        address, whole = ctypes.c_void_p, ctypes.c_int64
        self._library = library  # its code is freed with it
        self._steps: dict[int, compiler.Library] = {}
        alone = library.address("step") if len(plan.laws) == 1 else 0
        self.addresses = [*[alone] * len(plan.laws), library.address("serve")]
        """Where the step of each law is, 0 where it is not compiled yet, and ``serve``."""
        self._lock = threading.Lock()
        self.prepare = library.function("prepare", None, address, address, whole)
        self.start = library.function("start", None, address, address, address, address)
        self.advance = library.function("advance", whole, address, address, address, address, address, whole)

    def compile_step(self, law: int) -> None:
        """Makes the step of a law, unless it is there."""
        with self._lock:
            if law not in self._steps:
                content = repr((self._content, "step", law))
                self._steps[law] = compiler.library(
                    content, lambda: step_text(self.plan, law), self._machine, compiler.COLD
                )
                self.addresses[law] = self._steps[law].address("step")

    def job(
        self,
        numbers: Mapping[str, npt.ArrayLike],
        states0: npt.ArrayLike,
        start: npt.ArrayLike,
        times: Array,
        smallest_step: npt.ArrayLike,
        most_steps: npt.ArrayLike,
        corners: npt.ArrayLike | None,
        terms: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    ) -> _Arrays:
        """The arrays of a run, filled in."""
        members, samples = times.shape
        plan, states = self.plan, self.layout.states
        own = numbers if isinstance(numbers, Rows) else Rows.of(numbers, (members,))
        if missing := own.missing(plan.numbers):
            raise ValueError(f"numbers: {', '.join(missing)} missing")
        width = plan.width
        padded = -(-max(members, 1) // width) * width
        values = aligned(len(plan.numbers), padded)
        own.fill(plan.numbers, values[:, :members])
        values[:, members:] = values[:, :1] if members else 0.0
        table = aligned(max(len(self.layout.held), 1), padded)
        self.prepare(values.ctypes.data, table.ctypes.data, padded)

        initial = np.zeros((members, states))
        given = np.asarray(states0, dtype=float)
        initial[:, : given.shape[-1]] = given
        for k, restart in enumerate(plan.restarts):
            if restart is not None:
                initial[:, k] = restart
        first = _each(start, members)
        pieces, begun = (np.zeros((1, 1, 1)), 0) if terms is None else terms
        given_terms = np.asarray(pieces, dtype=float)
        return _Arrays(
            table=table,
            states=initial,
            switches=values[[plan.numbers.index(node.value) for node in plan.switches], :members].T.copy(),
            start=first,
            times=times,
            corners=_corner_rows(corners, first),
            pieces=np.array(np.broadcast_to(given_terms, (members, *given_terms.shape[1:])), order="C"),
            first_piece=np.broadcast_to(np.asarray(begun, dtype=np.int64), (members,)).copy(),
            smallest=_each(smallest_step, members),
            result=np.full((members, samples, states), np.nan),
            status=np.full(members, -1, dtype=np.int64),
            steps=np.zeros(members),
            least=np.full(members, math.inf),
            end_time=first.copy(),
            end_state=initial.copy(),
            dwell=np.zeros((members, self.layout.combinations)),
            padded=padded,
            most_steps=_each(most_steps, members),
        )


def _room(program: Program, members: int, corners: int, pieces: int) -> tuple[Any, Any]:
    """Room for corners and the terms of pieces; none where the drive has none."""
    if not pieces:
        return None, None
    return np.full((members, corners), np.inf), (np.zeros((members, pieces, program.piece_terms)), 0)


def _each(value: npt.ArrayLike, members: int) -> Array:
    """An array of its own with a value for each member."""
    own = np.empty(members)
    own[:] = value
    return own


def _corner_rows(corners: npt.ArrayLike | None, start: Array) -> Array:
    """The corners after each member's start, (members, corners + 1), with infinity behind the last."""
    members = start.size
    if corners is None:
        return np.full((members, 1), math.inf)
    given = np.broadcast_to(np.asarray(corners, dtype=float), (members, np.shape(corners)[-1]))
    later = np.where(given > start[:, None], given, math.inf)
    return np.ascontiguousarray(np.hstack([np.sort(later, axis=1), np.full((members, 1), math.inf)]))


def _content(plan: Plan) -> str:
    """A text that identifies the plan's code."""
    borders = [(border.direction, border.switch, border.sided, border.smooth, border.seldom) for border in plan.borders]
    switches = [node.value for node in plan.switches]
    laws = (len(plan.laws), plan.telling)
    rest = (
        borders,
        switches,
        plan.numbers,
        plan.order,
        plan.tolerance.hex(),
        plan.restarts,
        plan.passengers,
        plan.pieces,
        *laws,
    )
    return repr((fingerprint(plan.wanted), rest, plan.width))


def aligned(*shape: int) -> Array:
    """Zeros that start at a multiple of the largest vector's size."""
    count = math.prod(shape)
    room = np.zeros(count + _ALIGNMENT // 8)
    skip = (-room.ctypes.data // 8) % (_ALIGNMENT // 8)
    return room[skip : skip + count].reshape(shape)


@dataclass
class _Arrays:
    """The arrays of a run, in the order of `Job`, and its sizes."""

    table: Array
    states: Array
    switches: Array
    start: Array
    times: Array
    corners: Array
    pieces: Array
    first_piece: npt.NDArray[np.int64]
    smallest: Array
    most_steps: Array
    result: Array
    status: npt.NDArray[np.int64]
    steps: Array
    least: Array
    end_time: Array
    end_state: Array
    dwell: Array
    padded: int

    def fields(self, slots: int) -> npt.NDArray[np.int64]:
        """The job as the compiled loop reads it, with the members that a thread works on at a time."""
        job = np.zeros(len(Job), dtype=np.int64)
        for place, name in enumerate(_ADDRESSES):
            job[place] = getattr(self, name).__array_interface__["data"][0]
        job[Job.MEMBERS], job[Job.SAMPLES] = self.times.shape
        job[Job.CORNER_COUNT] = self.corners.shape[1]
        job[Job.PADDED] = self.padded
        job[Job.SLOTS] = slots
        job[Job.PIECES], job[Job.FIRST_PIECE] = self.pieces.ctypes.data, self.first_piece.ctypes.data
        job[Job.PIECE_COUNT] = self.pieces.shape[1]
        return job


class _Work:
    """What one thread works with."""

    def __init__(self, compiled: _Compiled, job: npt.NDArray[np.int64]) -> None:
        plan, layout = compiled.plan, compiled.layout
        self._compiled, self._job = compiled, job
        self.lanes = aligned(len(plan.laws), layout.rows, plan.width)
        self.slots = aligned(plan.slots, layout.rows)
        self._scratch = aligned(layout.scratch_rows, plan.width)
        self._words = np.zeros(layout.words, dtype=np.int64)
        self._words[layout.code : layout.missing] = compiled.addresses
        lanes, scratch, words, slots = (a.ctypes.data for a in (self.lanes, self._scratch, self._words, self.slots))
        self._start = lanes, job.ctypes.data, words, slots
        self._advance = lanes, scratch, job.ctypes.data, words, slots

    def start(self) -> None:
        """Takes the first members."""
        self._compiled.start(*self._start)

    def advance(self, steps: int) -> None:
        """Make up to ``steps`` steps of all lanes of a law; none where it had to be compiled first."""
        self._compiled.advance(*self._advance, steps)
        layout = self._compiled.layout
        if missing := int(self._words[layout.missing]):
            self._compiled.compile_step(missing - 1)
            self._words[layout.code : layout.missing] = self._compiled.addresses
            self._words[layout.missing] = 0

    @property
    def going(self) -> bool:
        """Whether any member is under way; whoever waits does so for a lane that has one."""
        return bool(self._words[: len(self.lanes)].any())

    def under_way(self) -> Iterator[tuple[int, float]]:
        """The members under way, and where they are in time."""
        layout, laws, width = self._compiled.layout, len(self.lanes), self.lanes.shape[-1]
        for law in range(laws):
            records = [self.lanes[law, :, lane] for lane in range(width) if int(self._words[law]) >> lane & 1]
            count, head = (int(self._words[first + law]) for first in (layout.waiting, layout.heads))
            ring = self._words[layout.rings : layout.code].reshape(laws, -1)[law]
            records += [self.slots[ring[(head + k) % ring.size]] for k in range(count)]
            for record in records:
                yield int(record[layout.member : layout.member + 1].view(np.int64)[0]), float(record[layout.time])


class _Run:
    """One run: threads that take members from one queue until it is empty, or the run is stopped."""

    def __init__(
        self,
        compiled: _Compiled,
        arrays: _Arrays,
        threads: int,
        report: Callable[[float], None] | None,
        stopped: Callable[[], bool] | None,
    ) -> None:
        self._arrays = arrays
        members, width = arrays.start.size, compiled.plan.width
        count = min(threads, -(-members // width))
        own = -(-members // count)
        # threads that share the members leave half of them in the queue, so that all have work to the end
        taken = own if count == 1 else max(len(compiled.plan.laws) * width, own // 2)
        self._job = arrays.fields(min(compiled.plan.slots, own, taken))
        self._works = [_Work(compiled, self._job) for _ in range(count)]
        self._report, self._stopped = report, stopped
        self._stop = threading.Event()
        self._told, self._next_report = 0.0, 0.0

    def work(self) -> None:
        """Runs to the end; this thread is one of those that work, so that an interrupt reaches it between calls.

        The others start when there is work left after its first call: for less they would come too late.
        """
        others: list[threading.Thread] = []
        try:
            for _ in self._advance(0):
                if not others and self._works[0].going:
                    for k in range(1, len(self._works)):
                        thread = threading.Thread(target=self._work_on, args=(k,))
                        thread.start()
                        others.append(thread)
                self._look_around()
            for thread in others:
                while thread.is_alive():
                    thread.join(REPORT_EVERY)
                    self._look_around()
        except BaseException:
            self._stop.set()
            for thread in others:
                thread.join()
            raise
        if self._report is not None and not self._stop.is_set() and self._told < 1.0:
            self._report(1.0 - self._told)

    def _work_on(self, k: int) -> None:
        for _ in self._advance(k):
            pass

    def _advance(self, k: int) -> Iterator[None]:
        """One call of the compiled loop after the other."""
        work = self._works[k]
        work.start()
        steps = STEPS_PER_CALL
        while work.going and not self._stop.is_set():
            before = time.perf_counter()
            work.advance(steps)
            took = time.perf_counter() - before
            steps = max(
                1, 2 * steps if took < 0.5 * CALL_SECONDS else steps // 2 if took > 2.0 * CALL_SECONDS else steps
            )
            yield

    def _look_around(self) -> None:
        if self._stopped is not None and self._stopped():
            self._stop.set()
        now = time.perf_counter()
        if self._report is not None and now >= self._next_report:
            self._next_report = now + REPORT_EVERY
            done = self._share_done()
            if done > self._told:
                self._report(done - self._told)
                self._told = done

    def _share_done(self) -> float:
        """Members that are done, and the shares of those under way, over all."""
        arrays = self._arrays
        members = arrays.start.size
        total = float(min(self._job[Job.NEXT], members))
        for work in self._works:
            for member, moment in work.under_way():
                first, last = arrays.start[member], arrays.times[member, -1]
                share = (moment - first) / (last - first) if last > first else 1.0
                total -= 1.0 - min(max(share, 0.0), 1.0)
        return max(total, 0.0) / members
