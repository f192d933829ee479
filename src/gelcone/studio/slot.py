"""Requests that a page repeats while a slider moves: the newest one wins.

A slot does one thing at a time; new requests replace the waiting one. Running work may finish within its grace: if it
were stopped at once, a slider that moves sixty times a second would never see an answer. A patient slot lets the work
after a stopped one finish: otherwise nothing slower than the grace would appear before the slider rests.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from starlette.websockets import WebSocketDisconnect

from gelcone.progress import Stopped, Watch

GRACE = 0.15
"""Seconds that running work may continue after a newer request."""
LOOK_SECONDS = 0.01


class Slot:
    """Does the newest request of each side of the page, one after the other."""

    def __init__(self, work: Callable[[str, Any], Awaitable[None]], *, patient: bool = False) -> None:
        self.work, self.patient, self.watch = work, patient, Watch()
        self.refines = False
        """Whether the running work only adds to a picture that the page already shows."""
        self.cost = 0.0
        """Processor seconds of the running work."""
        self.missing: list[Any] = []
        """Pull-in curves that the last work left out because they take long."""
        self._next: dict[str, Any] = {}
        self._unanswered: set[str] = set()
        """Sides of a patient slot whose last work was stopped."""
        self._side = ""
        self._began = 0.0
        self._wake = asyncio.Event()

    @property
    def overtaken(self) -> bool:
        """Whether a newer request waits and the grace is over."""
        return self._gives_way and time.monotonic() - self._began > GRACE

    @property
    def _gives_way(self) -> bool:
        return self._side in self._next and self._side not in self._unanswered

    def give(self, side: str, request: Any) -> None:
        """Takes a request of a side, in place of the waiting one."""
        self._next[side] = request
        self._wake.set()
        left = self._began + GRACE - time.monotonic()
        asyncio.get_running_loop().call_later(max(left, 0.0), self._overtake, self.watch)

    def put_off(self, side: str) -> None:
        """Stops work that only refines an older picture of this side: it would slow the newer one down."""
        if self.refines and self._side == side:
            self.watch.stop.set()

    def _overtake(self, watch: Watch) -> None:
        if self._gives_way:
            watch.stop.set()

    async def run(self) -> None:
        """Answers requests until the task is cancelled."""
        while True:
            if not self._next:
                self._wake.clear()
                await self._wake.wait()
            self._side = next(iter(self._next))
            request = self._next.pop(self._side)
            self.watch, self._began, self.refines, self.cost = Watch(), time.monotonic(), False, 0.0
            with suppress(WebSocketDisconnect):
                try:
                    await self.work(self._side, request)
                    self._unanswered.discard(self._side)
                except Stopped:
                    if self.patient:
                        self._unanswered.add(self._side)

    async def until(self, moment: float) -> None:
        """Waits until a moment of the loop's clock; `Stopped` once a newer request of the side waits."""
        loop = asyncio.get_running_loop()
        while (left := moment - loop.time()) > 0.0:
            if self._side in self._next:
                raise Stopped
            await asyncio.sleep(min(left, LOOK_SECONDS))

    def end(self) -> None:
        """Stops the running work."""
        self.watch.stop.set()
