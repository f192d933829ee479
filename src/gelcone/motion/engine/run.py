"""A run of a program: threads take members from a queue; progress and interrupts are served between their calls."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from gelcone.motion.engine.machine_code import Arrays, Compiled, address_of, aligned
from gelcone.motion.engine.plan import Job

FIRST_STEPS = 256
"""Steps of all lanes in the first call of the compiled loop."""
CALL_SECONDS = 0.02
"""Duration of later calls, between which interrupts and progress are served."""
REPORT_EVERY = 0.05
"""Seconds between two reports of progress."""


class Work:
    """The lanes, slots and words of one thread."""

    def __init__(self, compiled: Compiled, job: npt.NDArray[np.int64]) -> None:
        plan, layout = compiled.plan, compiled.layout
        self._compiled, self._job = compiled, job
        self.lanes = aligned(len(plan.laws), layout.rows, plan.width)
        self.slots = aligned(plan.slots, layout.rows)
        self._scratch = aligned(layout.scratch_rows, plan.width)
        self._words = np.zeros(layout.words, dtype=np.int64)
        self._words[layout.code : layout.missing] = compiled.addresses
        arrays = (self.lanes, self._scratch, job, self._words, self.slots)
        lanes, scratch, own, words, slots = map(address_of, arrays)
        self._start = lanes, own, words, slots
        self._advance = lanes, scratch, own, words, slots

    def start(self) -> None:
        """Takes the first members from the queue."""
        self._compiled.start(*self._start)

    def advance(self, steps: int) -> None:
        """Makes up to ``steps`` steps; fewer if the step of a law had to be compiled."""
        before, layout = time.perf_counter(), self._compiled.layout
        self._compiled.advance(*self._advance, steps)
        if missing := int(self._words[layout.missing]):
            self._compiled.compile_step(missing - 1)
            self._words[layout.missing] = 0
        else:
            self._compiled.has_run(time.perf_counter() - before)
        self._words[layout.code : layout.missing] = self._compiled.addresses

    @property
    def going(self) -> bool:
        """True if any member is under way; a member only waits for a lane that has one."""
        return bool(self._words[: len(self.lanes)].any())

    def under_way(self) -> Iterator[tuple[int, float]]:
        """The members under way and their times."""
        layout, laws, width = self._compiled.layout, len(self.lanes), self.lanes.shape[-1]
        for law in range(laws):
            records = [self.lanes[law, :, lane] for lane in range(width) if int(self._words[law]) >> lane & 1]
            count, head = (int(self._words[first + law]) for first in (layout.waiting, layout.heads))
            ring = self._words[layout.rings : layout.code].reshape(laws, -1)[law]
            records += [self.slots[ring[(head + k) % ring.size]] for k in range(count)]
            for record in records:
                yield int(record[layout.member : layout.member + 1].view(np.int64)[0]), float(record[layout.time])


class Run:
    """Threads that take members from one queue until it is empty, or the run is stopped."""

    def __init__(
        self,
        compiled: Compiled,
        arrays: Arrays,
        threads: int,
        report: Callable[[float], None] | None,
        stopped: Callable[[], bool] | None,
    ) -> None:
        self._arrays = arrays
        members, width = arrays.start.size, compiled.plan.width
        count = min(threads, -(-members // width))
        per_thread = -(-members // count)
        # several threads leave half of the members in the queue at first, so that all have work to the end
        taken = per_thread if count == 1 else max(len(compiled.plan.laws) * width, per_thread // 2)
        self._job = arrays.fields(min(compiled.plan.slots, per_thread, taken))
        self._works = [Work(compiled, self._job) for _ in range(count)]
        self._report, self._stopped = report, stopped
        self._stop = threading.Event()
        self._reported, self._next_report = 0.0, 0.0

    def work(self) -> None:
        """Runs to the end; this thread works, too, so that an interrupt reaches it between calls.

        The other threads start if work is left after its first call: for less they would start too late.
        """
        others: list[threading.Thread] = []
        try:
            for _ in self._advance(0):
                if not others and self._works[0].going:
                    for k in range(1, len(self._works)):
                        thread = threading.Thread(target=self._work_on, args=(k,))
                        thread.start()
                        others.append(thread)
                self._report_or_stop()
            for thread in others:
                while thread.is_alive():
                    thread.join(REPORT_EVERY)
                    self._report_or_stop()
        except BaseException:
            self._stop.set()
            for thread in others:
                thread.join()
            raise
        if self._report is not None and not self._stop.is_set() and self._reported < 1.0:
            self._report(1.0 - self._reported)

    def _work_on(self, k: int) -> None:
        for _ in self._advance(k):
            pass

    def _advance(self, k: int) -> Iterator[None]:
        """Calls the compiled loop until no member is under way, and yields after each call."""
        work = self._works[k]
        work.start()
        steps = FIRST_STEPS
        while work.going and not self._stop.is_set():
            before = time.perf_counter()
            work.advance(steps)
            seconds = time.perf_counter() - before
            steps = max(
                1, 2 * steps if seconds < 0.5 * CALL_SECONDS else steps // 2 if seconds > 2.0 * CALL_SECONDS else steps
            )
            yield

    def _report_or_stop(self) -> None:
        if self._stopped is not None and self._stopped():
            self._stop.set()
        now = time.perf_counter()
        if self._report is not None and now >= self._next_report:
            self._next_report = now + REPORT_EVERY
            done = self._share_done()
            if done > self._reported:
                self._report(done - self._reported)
                self._reported = done

    def _share_done(self) -> float:
        """The share of the work that is done: finished members, and the shares of those under way."""
        arrays = self._arrays
        members = arrays.start.size
        total = float(min(self._job[Job.NEXT], members))
        for work in self._works:
            for member, moment in work.under_way():
                first, last = arrays.start[member], arrays.times[member, -1]
                share = (moment - first) / (last - first) if last > first else 1.0
                total -= 1.0 - min(max(share, 0.0), 1.0)
        return max(total, 0.0) / members
