"""Requests that a page repeats while a hand moves: the newest one wins.

A slot does one thing at a time; what arrives meanwhile replaces what waits. What runs is asked to stop once it has had
its grace: stopped at once, a slider that moves sixty times a second would never see an answer. A patient slot lets what
follows a stopped one run to its end: else nothing that takes longer than the grace would come before the hand rests.
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
"""Seconds for which what runs may continue after something newer has come."""
LOOK_SECONDS = 0.01


class Slot:
    """Does the newest of what it is given for each side of the page, one after the other."""

    def __init__(self, work: Callable[[str, Any], Awaitable[None]], *, patient: bool = False) -> None:
        self.work, self.patient, self.watch = work, patient, Watch()
        self.refines = False
        """Whether what runs only adds to what the page shows already."""
        self.cost = 0.0
        """Seconds of processor that what is done has taken."""
        self.missing: list[Any] = []
        """What was left out of what was done last, for it takes long."""
        self._next: dict[str, Any] = {}
        self._unanswered: set[str] = set()
        """Sides of a patient slot whose last request was stopped."""
        self._side = ""
        self._began = 0.0
        self._wake = asyncio.Event()

    @property
    def overtaken(self) -> bool:
        """Whether something newer waits and the grace is over."""
        return self._gives_way and time.monotonic() - self._began > GRACE

    @property
    def _gives_way(self) -> bool:
        return self._side in self._next and self._side not in self._unanswered

    def give(self, side: str, request: Any) -> None:
        """Take a request of a side, in place of one that waits."""
        self._next[side] = request
        self._wake.set()
        left = self._began + GRACE - time.monotonic()
        asyncio.get_running_loop().call_later(max(left, 0.0), self._overtake, self.watch)

    def put_off(self, side: str) -> None:
        """Stops at once what only refines an older picture of a side: it would slow the newer one down."""
        if self.refines and self._side == side:
            self.watch.stop.set()

    def _overtake(self, watch: Watch) -> None:
        if self._gives_way:
            watch.stop.set()

    async def run(self) -> None:
        """Answer requests until the task is cancelled."""
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
        """Waits until a moment of the loop's clock; `Stopped` once something newer for the side has come."""
        loop = asyncio.get_running_loop()
        while (left := moment - loop.time()) > 0.0:
            if self._side in self._next:
                raise Stopped
            await asyncio.sleep(min(left, LOOK_SECONDS))

    def end(self) -> None:
        """Stop what runs."""
        self.watch.stop.set()
