"""The lanes of a page: one for each kind of long work and one for each side, in which newer work replaces older
work."""

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
    """Pool and lane of each kind of work by name, and the tasks of the event loop that wait for results.

    Files, and numbers that the user waits for, have the pool ``saving``, so that they do not queue behind a map.
    """

    def __init__(
        self, pool: Pool, saving: Pool, send: Callable[..., Awaitable[None]], fail: Callable[..., Awaitable[None]]
    ) -> None:
        pools = {name: saving if name in ("export", *SIDES) else pool for name in (*LANES, *SIDES)}
        super().__init__({name: (lane_pool, lane_pool.lane()) for name, lane_pool in pools.items()})
        self._send, self._fail = send, fail
        self._tasks: set[asyncio.Task[None]] = set()

    def work(self, name: str, number: int) -> Work:
        """Begins a run in a lane, for the page's request ``number``."""
        pool, lane = self[name]
        return Work(pool, lane, pool.begin(lane), number, self._send)

    def drop(self, work: Work) -> None:
        """Cancels a run, unless the page is closed."""
        if self:
            work.pool.begin(work.lane)

    def start(self, name: str, number: int, answer: Callable[[], Awaitable[None]]) -> None:
        """Starts a task in place of the running one of the same name; errors are sent to the page."""

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
        """Cancels the task of this name."""
        for task in self._tasks:
            if task.get_name() == name:
                task.cancel()

    def stop(self, name: str) -> None:
        """Cancels the run and the task of this name."""
        pool, lane = self[name]
        pool.begin(lane)
        self.cancel(name)

    def end(self) -> None:
        """Cancels all tasks and returns the lanes to their pools."""
        for task in self._tasks:
            task.cancel()
        for pool, lane in self.values():
            pool.leave(lane)
        self.clear()
