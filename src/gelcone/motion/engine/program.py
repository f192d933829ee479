"""Programs: equations of motion compiled for one purpose and tolerance, run over any number of members."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.laws import System, traced_plan
from gelcone.motion.engine.machine_code import Compiled, aligned, each
from gelcone.motion.engine.plan import ARRIVED, TERMINAL_EVENT, Job, Plan
from gelcone.motion.engine.run import Run, Work
from gelcone.motion.job import KEEPS
from gelcone.quantity import Array


@dataclass(frozen=True)
class Raw:
    """The result of a run; samples that a member did not reach are NaN.

    ``states`` (members, samples, N); ``tangents`` (members, samples, N, N), [..., i, j] the derivative of state i with
    respect to state j of the previous sample, or of the start; ``divergence`` (members, samples), the integral of the
    Jacobian's trace since then, unless it is known (a `planar` system); ``work`` (members, samples, powers), the
    integrals of the powers since the start. ``status`` (members,): `ARRIVED`, `NOT_FINITE`, `STEP_TOO_SMALL`,
    `TOO_MANY_STEPS` or `TERMINAL_EVENT` + the number of the event. ``steps`` and ``smallest_step`` (members,): number
    of steps, and the shortest by the tolerance. ``end_time`` (members,), ``end_state`` (members, N) and ``switches``,
    name -> (members,), at the end of a member's run, from which another run can continue. ``dwell`` (members,
    2^switches): duration of each combination of signs of the switches; bit k of its index is set if the k-th switch is
    negative.
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

    Order 8 for tolerances above 3e-8, 12 above 3e-11, else 18, or 16 with tangents: each was the fastest at its error.
    The step rule takes a tenth of the tolerance, so that the errors are those of heyoka at ``tolerance``, and at least
    3e-16, or 1e-15 with tangents: steep films still gain from that, but not from less.
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
        terms, which are given to `run`.
    width : lanes; default by the number of members. Does not change a bit of the result.
    machine : target of the compilation; default this process's machine. Does not change a bit of the result.

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
        if keep not in KEEPS:
            raise ValueError(f"keep = {keep!r}: must be one of {', '.join(KEEPS)}")
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"tolerance = {tolerance!r}: must be between 0 and 1")
        self.keep = keep
        self.size = len(system.states)
        self.numbers = tuple(system.numbers)
        self.order, self.label = order_and_label(tolerance, keep)
        self._machine = machine
        self._width = width
        self._lock = threading.Lock()
        self._compiled: dict[int, Compiled] = {}
        self.piece_terms = max(len(pieces) - 1, 0)
        self._traced = traced_plan(system, keep, events, tuple(pieces))

    def _plan(self, width: int) -> Plan:
        return Plan(**self._traced, order=self.order, tolerance=self.label, width=width)

    def _best_width(self, members: int, threads: int) -> int:
        """The fastest number of lanes: two registers hide latencies, as long as the other registers hold the numbers of
        the step and the members fill the lanes of every thread."""
        vector = (self._machine or compiler.host()).vector
        wide = self.order <= 12 and self.keep != "tangents" and members > vector * threads
        return 2 * vector if wide else vector

    def _compile(self, width: int) -> Compiled:
        with self._lock:
            if width not in self._compiled:
                self._compiled[width] = Compiled(self._plan(width), self._machine)
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
        """Integrate all members.

        Parameters
        ----------
        numbers : name -> values, scalar or (members,).
        states0 : initial states, (members, N).
        start : time of the initial states, scalar or (members,).
        times : sample times, (members, samples), increasing along a row and not before the start.
        smallest_step : a member ends where its step falls below this, scalar or (members,).
        most_steps : number of steps after which a member ends, scalar or (members,).
        threads : number of threads; does not change a bit of the result.
        corners : increasing times, (members, corners), at which steps end; infinite ones and those before the start
            are left out. Default none.
        terms : the terms of the pieces, (members, pieces, terms), and the piece that begins at the first corner of each
            member, (members,); the first piece follows the last.
        report : called from this thread, now and then, with the share of the work done since the last call.
        stopped : called now and then; the run ends early, with incomplete results, once it returns True.

        Raises
        ------
        ValueError : for arrays that do not fit, times that do not increase, a number that is missing, or fewer threads
            than one.
        """
        if threads < 1:
            raise ValueError(f"threads = {threads!r}: must be at least 1")
        sample_times = np.ascontiguousarray(times, dtype=float)
        members, samples = sample_times.shape
        first = each(start, members)
        known = np.isfinite(sample_times).all() and np.isfinite(first).all()
        later = (sample_times[:, 1:] > sample_times[:, :-1]).all() and (sample_times[:, :1] >= first[:, None]).all()
        if not (known and later):
            raise ValueError("times: must be finite, increase, and not be before the start")
        compiled = self._compile(self._width or self._best_width(members, threads))
        arrays = compiled.job(numbers, states0, first, sample_times, smallest_step, most_steps, corners, terms)
        if members and samples:
            Run(compiled, arrays, threads, report, stopped).work()
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
    """A program that one thread runs repeatedly, with arrays that are made once; ``numbers`` are the names for `run`.

    It saves the setup for some tens of members over a short time, which would take longer than the run. `run` gives the
    same bits as `Program.run`.

    Parameters
    ----------
    program : the program.
    start, end : times of the initial states and of the one sample, (members,).
    most_steps : number of steps after which a member ends.
    corners, pieces : largest numbers of corners of a member and of pieces of the drive, whose terms are given to `run`.
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
        self._work = Work(compiled, self._job)
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
        """The states at the end, (members, states), valid until the next run, and the mask of members that arrived.

        ``numbers`` (names,) or (names, members) in the order of `numbers`; ``states0`` (members, states); ``switches``
        (members, switches) where events or corners switch numbers, in the order of the events, those of corners last;
        ``corners`` their times, the terms of the pieces and the piece that begins at the first, as `Program.run` takes.
        """
        compiled, arrays = self._compiled, self._arrays
        self._values[:, : self._members] = numbers[:, None] if numbers.ndim == 1 else numbers
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
        """Runs all members from the contents of the arrays."""
        self._job[Job.NEXT] = 0
        self._work.start()
        while self._work.going:
            self._work.advance(1 << 20)

    @property
    def met_event(self) -> bool:
        """True if a member of the last run ended at a terminal event."""
        return bool((self._arrays.status >= TERMINAL_EVENT).any())


def _room(program: Program, members: int, corners: int, pieces: int) -> tuple[Any, Any]:
    """Arrays for corners and the terms of pieces; None for a drive without pieces."""
    if not pieces:
        return None, None
    return np.full((members, corners), np.inf), (np.zeros((members, pieces, program.piece_terms)), 0)
