"""The lanes of a page: each kind of long work, and what each side computes once the hand rests, has one of its own, in
which newer work takes the place of older."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress

from starlette.websockets import WebSocketDisconnect

from gelcone.studio.long_work import Outdated, Work
from gelcone.studio.pool import Pool

LANES = ("map", "strip", "envelope", "export")
"""Long work, each in a lane of its own."""
SIDES = ("a", "b")


class Lanes(dict[str, tuple[Pool, int]]):
    """The pool and the lane of each kind of work by its name, and the tasks of the event loop that wait for it. A file
    or a number that one waits for has the pool ``saving``, so that it does not queue behind a map."""

    def __init__(
        self, pool: Pool, saving: Pool, send: Callable[..., Awaitable[None]], fail: Callable[..., Awaitable[None]]
    ) -> None:
        pools = {name: saving if name in ("export", *SIDES) else pool for name in (*LANES, *SIDES)}
        super().__init__({name: (own, own.lane()) for name, own in pools.items()})
        self._send, self._fail = send, fail
        self._tasks: set[asyncio.Task[None]] = set()

    def work(self, name: str, number: int) -> Work:
        """Begin a run in the lane of a name, for the page's request of that number."""
        pool, lane = self[name]
        return Work(pool, lane, pool.begin(lane), number, self._send)

    def drop(self, work: Work) -> None:
        """Cancel a run, unless the page is gone."""
        if self:
            work.pool.begin(work.lane)

    def start(self, name: str, number: int, answer: Callable[[], Awaitable[None]]) -> None:
        """Start a task in place of the one of that name; the page is sent what goes wrong."""

        async def guarded() -> None:
            with suppress(WebSocketDisconnect):
                try:
                    await answer()
                except (Outdated, WebSocketDisconnect):
                    pass
                except Exception as error:
                    await self._fail(number, error)

        self.cancel(name)
        task = asyncio.create_task(guarded(), name=name)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def cancel(self, name: str) -> None:
        """Cancel the task of a name."""
        for task in self._tasks:
            if task.get_name() == name:
                task.cancel()

    def stop(self, name: str) -> None:
        """Cancel the run of a name and its task."""
        pool, lane = self[name]
        pool.begin(lane)
        self.cancel(name)

    def end(self) -> None:
        """Cancel all, and give the lanes back."""
        for task in self._tasks:
            task.cancel()
        for pool, lane in self.values():
            pool.leave(lane)
        self.clear()
