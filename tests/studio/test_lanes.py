"""Lanes of a page: newer work takes the place of older, and all of them are given back."""

import asyncio

import pytest
from starlette.websockets import WebSocketDisconnect

from gelcone.studio.lanes import LANES, SIDES, Lanes
from gelcone.studio.long_work import Outdated


class Pool:
    """A pool that counts the runs of each of its lanes."""

    def __init__(self):
        self.runs, self.left = {}, []

    def lane(self):
        self.runs[len(self.runs)] = 0
        return len(self.runs) - 1

    def begin(self, lane):
        self.runs[lane] += 1
        return self.runs[lane]

    def leave(self, lane):
        self.begin(lane)
        self.left.append(lane)


class Page:
    """Lanes over two pools, and what the page is sent."""

    def __init__(self):
        self.pool, self.saving, self.sent, self.failed = Pool(), Pool(), [], []
        self.lanes = Lanes(self.pool, self.saving, self.send, self.fail)

    async def send(self, head, arrays):
        self.sent.append((head, arrays))

    async def fail(self, number, error):
        self.failed.append((number, error))


async def settled():
    """Until each task has done what it can."""
    for _ in range(5):
        await asyncio.sleep(0)


def test_what_one_waits_for_has_a_pool_of_its_own():
    page = Page()
    assert list(page.lanes) == [*LANES, *SIDES]
    for name, (pool, _) in page.lanes.items():
        assert pool is (page.saving if name in ("export", "a", "b") else page.pool), name
    for pool in (page.pool, page.saving):
        own = [lane for one, lane in page.lanes.values() if one is pool]
        assert sorted(own) == list(range(len(own)))


def test_a_run_is_the_next_of_its_lane_and_sends_the_page_what_it_finds():
    page = Page()
    _, lane = page.lanes["map"]
    first, second = (page.lanes.work("map", number) for number in (7, 8))
    assert [(own.pool, own.lane, own.run, own.number) for own in (first, second)] == [
        (page.pool, lane, 1, 7), (page.pool, lane, 2, 8),
    ]  # fmt: skip
    asyncio.run(second.tell("grid", {"x": [1.0]}, cells=3))
    assert page.sent == [({"kind": "grid", "id": 8, "cells": 3}, {"x": [1.0]})]
    page.lanes.drop(second)
    assert page.pool.runs[lane] == 3
    assert [runs for own, runs in page.pool.runs.items() if own != lane] == [0] * (len(page.pool.runs) - 1)
    page.lanes.end()
    page.lanes.drop(second)
    assert page.pool.runs[lane] == 4  # a page that is gone has given its lanes to others


def test_a_newer_task_of_a_name_takes_the_place_of_the_older_and_others_go_on():
    async def story():
        page, done, gate = Page(), [], asyncio.Event()

        def waits(name):
            async def answer():
                await gate.wait()
                done.append(name)

            return answer

        page.lanes.start("map", 1, waits("old map"))
        page.lanes.start("strip", 2, waits("strip"))
        await settled()
        page.lanes.start("map", 3, waits("map"))
        page.lanes.start("a", 4, waits("a"))
        await settled()
        page.lanes.cancel("a")
        gate.set()
        await settled()
        return page, done

    page, done = asyncio.run(story())
    assert sorted(done) == ["map", "strip"]
    assert page.failed == []
    assert not page.lanes._tasks


@pytest.mark.parametrize("stop", ["stop", "end"])
def test_what_is_stopped_ends_with_its_run(stop):
    async def story():
        page, ends = Page(), []

        async def answer():
            try:
                await asyncio.sleep(60.0)
            finally:
                ends.append(1)

        page.lanes.start("envelope", 1, answer)
        page.lanes.start("export", 2, answer)
        await settled()
        if stop == "stop":
            page.lanes.stop("envelope")
        else:
            page.lanes.end()
        await settled()
        return page, len(ends)

    page, ends = asyncio.run(story())
    assert ends == (1 if stop == "stop" else 2)
    runs = [*page.pool.runs.values(), *page.saving.runs.values()]
    if stop == "stop":
        assert (sum(runs), page.pool.runs[page.lanes["envelope"][1]], page.pool.left) == (1, 1, [])
    else:
        assert runs == [1] * len(runs)
        assert sorted(page.pool.left + page.saving.left) == sorted([*page.pool.runs, *page.saving.runs])
        assert page.lanes == {}


@pytest.mark.parametrize(
    ("error", "reported"), [(ValueError("no"), True), (Outdated(), False), (WebSocketDisconnect(), False)]
)
def test_the_page_is_sent_what_goes_wrong_unless_nobody_waits_for_it(error, reported):
    async def story():
        page = Page()

        async def answer():
            raise error

        page.lanes.start("map", 5, answer)
        await settled()
        return page.failed

    assert asyncio.run(story()) == ([(5, error)] if reported else [])
