"""The machine code of a plan, and the arrays that it reads and fills."""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone import disk_cache
from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.loop import module_text, step_text
from gelcone.motion.engine.plan import Job, Layout, Plan
from gelcone.physics.members import Rows
from gelcone.physics.trace import fingerprint
from gelcone.quantity import Array, spread

_ALIGNMENT = 128
SECONDS_PER_BYTE = 1e-5
"""Time to compile quickly compiled code again, optimised, over its size."""
_ADDRESSES = tuple(field.name.lower() for field in list(Job)[: Job.MEMBERS])


class Compiled:
    """The machine code of a plan."""

    def __init__(self, plan: Plan, machine: compiler.Machine | None) -> None:
        self.plan = plan
        self.layout = Layout(plan)
        self._machine, self._content = machine, content_of(plan)
        # the steps of several laws have modules of their own; the rest runs only at samples and crossings
        level = compiler.HOT if len(plan.laws) == 1 else compiler.COLD
        library = compiler.library(self._content, lambda: module_text(plan), machine, level)
        address, whole = ctypes.c_void_p, ctypes.c_int64
        self._libraries = [library]  # code is freed with its library, and other threads may run replaced code
        self._quick: dict[int, float] = {}
        """Laws whose steps were compiled quickly, and the seconds in which they compile optimised."""
        self._seconds = 0.0
        alone = library.address("step") if len(plan.laws) == 1 else 0
        self.addresses = [*[alone] * len(plan.laws), library.address("serve")]
        """Addresses of the step of each law, 0 if it is not compiled yet, and of ``serve``."""
        self._lock = threading.Lock()
        self.prepare = library.function("prepare", None, address, address, whole)
        self.start = library.function("start", None, address, address, address, address)
        self.advance = library.function("advance", whole, address, address, address, address, address, whole)

    def compile_step(self, law: int) -> None:
        """Compiles the step of a law, unless it is there: quickly, unless the optimised one is stored."""
        with self._lock:
            if not self.addresses[law]:
                self._make_step(law, compiler.COLD if self._is_stored(law) else compiler.QUICK)

    def has_run(self, seconds: float) -> None:
        """Counts the ``seconds`` of a call, and optimises quickly compiled steps once they have run for as long as that
        takes: a run takes at most twice as long as with the better choice from the start.

        If the cache refuses new entries, only steps that another process has stored are used.
        """
        if not self._quick or not self._lock.acquire(blocking=False):
            return
        try:
            self._seconds += seconds
            if self._seconds > sum(self._quick.values()):
                self._seconds = 0.0
                for law in [law for law in self._quick if not disk_cache.refuses() or self._is_stored(law)]:
                    self._make_step(law, compiler.COLD)
        finally:
            self._lock.release()

    def _is_stored(self, law: int) -> bool:
        """True if the cache holds the optimised step."""
        return compiler.is_stored(self._step_content(law, compiler.COLD), self._machine)

    def _make_step(self, law: int, level: int) -> None:
        text = partial(step_text, self.plan, law)
        library = compiler.library(self._step_content(law, level), text, self._machine, level)
        self._libraries.append(library)
        self.addresses[law] = library.address("step")
        self._quick.pop(law, None)
        if level == compiler.QUICK:
            self._quick[law] = SECONDS_PER_BYTE * library.size

    def _step_content(self, law: int, level: int) -> str:
        return repr((self._content, "step", law, level))

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
    ) -> Arrays:
        """The arrays of a run, with all inputs filled in."""
        members, samples = times.shape
        plan, states = self.plan, self.layout.states
        number_rows = numbers if isinstance(numbers, Rows) else Rows.of(numbers, (members,))
        if missing := number_rows.missing(plan.numbers):
            raise ValueError(f"numbers: {', '.join(missing)} missing")
        width = plan.width
        padded = -(-max(members, 1) // width) * width
        values = aligned(len(plan.numbers), padded)
        number_rows.fill(plan.numbers, values[:, :members])
        table = aligned(max(len(self.layout.held), 1), padded)
        self.prepare(address_of(values), address_of(table), padded)

        initial = np.zeros((members, states))
        given_states = np.asarray(states0, dtype=float)
        initial[:, : given_states.shape[-1]] = given_states
        for k, restart in enumerate(plan.restarts):
            if restart is not None:
                initial[:, k] = restart
        first = each(start, members)
        pieces, begun = (np.zeros((members, 1, 1)), 0) if terms is None else terms
        given_terms = np.asarray(pieces, dtype=float)
        return Arrays(
            table=table,
            states=initial,
            switches=values[[plan.numbers.index(node.value) for node in plan.switches], :members].T.copy(),
            start=first,
            times=times,
            corners=_corner_rows(corners, first),
            pieces=np.array(spread(given_terms, (members, *given_terms.shape[1:])), order="C"),
            first_piece=each(begun, members, np.int64),
            smallest=each(smallest_step, members),
            result=np.full((members, samples, states), np.nan),
            status=np.full(members, -1, dtype=np.int64),
            steps=np.zeros(members),
            least=np.full(members, math.inf),
            end_time=first.copy(),
            end_state=initial.copy(),
            dwell=np.zeros((members, self.layout.combinations)),
            padded=padded,
            most_steps=each(most_steps, members),
        )


def each(value: npt.ArrayLike, members: int, kind: npt.DTypeLike = float) -> Any:
    """A new array with a value for each member."""
    values = np.empty(members, dtype=kind)
    values[:] = value
    return values


def address_of(array: npt.NDArray[Any]) -> int:
    """The address of the values of an array; ``array.ctypes.data`` takes five times as long."""
    if array.size and array.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    return int(array.ctypes.data)


def _corner_rows(corners: npt.ArrayLike | None, start: Array) -> Array:
    """Corners after each member's start, (members, corners + 1), with infinity behind the last."""
    members = start.size
    if corners is None:
        return np.full((members, 1), math.inf)
    given = np.broadcast_to(np.asarray(corners, dtype=float), (members, np.shape(corners)[-1]))
    later = np.where(given > start[:, None], given, math.inf)
    return np.ascontiguousarray(np.hstack([np.sort(later, axis=1), np.full((members, 1), math.inf)]))


def content_of(plan: Plan) -> str:
    """A text that identifies the plan's code."""
    switches = [node.value for node in plan.switches]
    laws = len(plan.laws), plan.telling
    rest = plan.numbers, plan.order, plan.tolerance, plan.restarts, plan.passengers, plan.pieces, plan.width
    return repr((fingerprint(plan.wanted), plan.borders, switches, laws, rest))


def aligned(*shape: int) -> Array:
    """Zeros that start at a multiple of the largest vector's size."""
    count = math.prod(shape)
    room = np.zeros(count + _ALIGNMENT // 8)
    skip = (-address_of(room) // 8) % (_ALIGNMENT // 8)
    return room[skip : skip + count].reshape(shape)


@dataclass
class Arrays:
    """Arrays of a run, in the order of `Job`, and the padded number of members."""

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
        """The job as the compiled loop reads it; ``slots`` is the number of members that a thread works on at a
        time."""
        job = np.zeros(len(Job), dtype=np.int64)
        for place, name in enumerate(_ADDRESSES):
            job[place] = address_of(getattr(self, name))
        job[Job.MEMBERS], job[Job.SAMPLES] = self.times.shape
        job[Job.CORNER_COUNT] = self.corners.shape[1]
        job[Job.PADDED] = self.padded
        job[Job.SLOTS] = slots
        job[Job.PIECES], job[Job.FIRST_PIECE] = address_of(self.pieces), address_of(self.first_piece)
        job[Job.PIECE_COUNT] = self.pieces.shape[1]
        return job
