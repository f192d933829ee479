"""Lanes of the worker pool: what is out of date ends, and each run counts its own progress."""

import asyncio
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone import permission
from gelcone.errors import InputError
from gelcone.progress import Stopped, current_watch
from gelcone.studio.pool import LANES, Busy, Pool, work


@pytest.fixture
def pool():
    pool = Pool(1, background=False)
    yield pool
    pool.close()


def done_here(pool, lane, run, function, *arguments):
    """What a worker does with a task of the pool."""
    return work(pool._task(lane, run, function, arguments))


def test_a_task_of_an_older_run_is_not_begun_and_others_are(pool):
    lane, other = pool.lane(), pool.lane()
    old, own = pool.begin(lane), pool.begin(other)
    new = pool.begin(lane)
    assert new != old
    assert done_here(pool, lane, old, np.add, 1, 2) is None
    assert done_here(pool, lane, new, np.add, 1, 2) == done_here(pool, other, own, np.add, 1, 2) == 3


def test_a_task_that_becomes_out_of_date_is_stopped(pool):
    lane = pool.lane()
    run = pool.begin(lane)

    def endless():
        pool.begin(lane)
        assert current_watch().stop.wait(10)
        raise Stopped

    assert done_here(pool, lane, run, endless) is None


def test_what_runs_when_the_pool_is_closed_is_out_of_date():
    own = Pool(1)
    lane = own.lane()
    run = own.begin(lane)
    assert done_here(own, lane, run, np.add, 1, 2) == 3
    own.close()
    assert done_here(own, lane, run, np.add, 1, 2) is None


def test_nothing_looks_after_a_task_that_is_done(pool):
    lane, before = pool.lane(), set(threading.enumerate())
    assert done_here(pool, lane, pool.begin(lane), np.add, 1, 2) == 3
    with pytest.raises(ZeroDivisionError):
        done_here(pool, lane, pool.begin(lane), divmod, 1, 0)
    for watcher in set(threading.enumerate()) - before:
        watcher.join(2)
        assert not watcher.is_alive()


def test_a_task_follows_the_names_that_were_given_when_the_studio_began_and_no_others():
    own = Pool(1, background=False, names=frozenset({"mine:Law"}))
    lane = own.lane()
    run = own.begin(lane)
    assert done_here(own, lane, run, permission.check, "law", "mine:Law") is None
    with pytest.raises(InputError, match="law = 'other:Law': does not ship"):
        done_here(own, lane, run, permission.check, "law", "other:Law")
    own.close()


def test_a_task_is_done_though_the_one_who_asked_for_it_waits_no_more(pool, monkeypatch):
    """It finds out by its lane whether it still counts."""
    begun, free = [], threading.Event()

    def do(processes, task):
        begun.append(task.arguments)
        assert free.wait(10)

    async def ask():
        asked = [asyncio.create_task(pool.do(0, 0, print, k)) for k in range(2)]
        await asyncio.sleep(0.01)
        for one in asked:
            one.cancel()
        await asyncio.gather(*asked, return_exceptions=True)

    threads = ThreadPoolExecutor(1)
    monkeypatch.setattr("gelcone.studio.pool._do", do)
    monkeypatch.setattr(pool, "_processes", SimpleNamespace(threads=threads, close=lambda patience: None))
    asyncio.run(ask())
    free.set()
    threads.shutdown()
    assert begun == [(0,), (1,)]


def test_lanes_are_given_back_and_never_given_twice(pool):
    taken = [pool.lane() for _ in range(LANES)]
    assert sorted(taken) == list(range(LANES))
    with pytest.raises(Busy, match="close a browser tab"):
        pool.lane()
    run = pool.begin(taken[0])
    pool.leave(taken[0])
    assert done_here(pool, taken[0], run, np.add, 1, 2) is None  # what ran there is cancelled
    assert pool.lane() == taken[0]


def test_a_worker_process_gives_what_it_finds_and_raises_what_it_raises(pool):
    lane = pool.lane()
    run = pool.begin(lane)
    assert asyncio.run(pool.do(lane, run, divmod, 7, 2)) == (3, 1)
    with pytest.raises(ZeroDivisionError):
        asyncio.run(pool.do(lane, run, divmod, 7, 0))
    assert asyncio.run(pool.do(lane, run - 1, divmod, 7, 2)) is None


@pytest.mark.parametrize(("background", "niceness"), [(True, 10), (False, 0)])
def test_workers_in_the_background_leave_the_processor_to_the_studio(background, niceness, monkeypatch):
    from gelcone.studio import pool as pools

    asked = []
    monkeypatch.setattr(pools.os, "nice", asked.append)
    with warnings.catch_warnings():
        pools._begin.__wrapped__(background)
        warnings.warn("what is doubtful is said by the studio", stacklevel=1)
    assert asked == [niceness]


def test_a_task_carries_what_it_runs_under(monkeypatch):
    names = frozenset({"mine:Law"})
    own = Pool(3, background=False, names=names)
    task = own._task(2, 5, divmod, (7, 2))
    assert (task.background, task.names, task.lane, task.run, task.function, task.arguments) == (
        False, names, 2, 5, divmod, (7, 2),
    )  # fmt: skip
    assert own.size == 3
    asked, run = [], own.begin(0)  # what loads a module is done though the lane has been used
    threads = SimpleNamespace(submit=lambda do, pool, task: asked.append((do.__name__, task.lane, task.run)))
    processes = SimpleNamespace(threads=threads, close=lambda patience: None)
    monkeypatch.setattr("gelcone.studio.pool.processes.Pool", lambda size: asked.append(size) or processes)
    own.warm(print)
    own.warm(print)  # they run already
    assert asked == [3, *[("_do", 0, run)] * 3]
    own.close()
