"""Threads that do tasks: each once, a few ahead, as they come, and stopped when left."""

import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from gelcone.atlas.processes import processes
from gelcone.atlas.workers import AHEAD, as_they_come, threads, watched
from gelcone.errors import InputError
from gelcone.progress import Stopped, current_watch


@pytest.mark.parametrize("size", [1, 3])
def test_tasks_are_taken_a_little_ahead_and_each_is_answered_once(size):
    """At most four for each thread are given and not answered."""
    taken, most = [], []

    def tasks():
        for k in range(60):
            taken.append(k)
            yield k

    with ThreadPoolExecutor(size) as pool:
        answers = []
        for answer in as_they_come(pool, size, lambda k: k * k, tasks(), threading.Event()):
            most.append(len(taken) - len(answers))
            answers.append(answer)
    assert sorted(answers) == [k * k for k in range(60)]
    assert AHEAD * size < most[0]
    assert max(most) == AHEAD * size + 1


def test_an_answer_comes_as_soon_as_it_is_there():
    """Not after a slower one that was given before."""
    wait = threading.Event()
    with ThreadPoolExecutor(2) as pool:
        found = as_they_come(pool, 2, lambda k: wait.wait(10.0) if k == 0 else k, iter([0, 1]), threading.Event())
        assert next(found) == 1
        wait.set()
        assert next(found) is True


def outcome(answers):
    """The next answer, or what it is refused with; it does not wait for ever."""
    found = []

    def ask():
        try:
            found.append(next(answers))
        except (Stopped, StopIteration) as error:
            found.append(type(error))

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(10.0)
    return found[0] if found else "waits"


def counted(steps):
    """The number of steps of a task, added to its watch."""
    current_watch().steps += steps
    return -steps


def test_a_team_has_the_threads_that_it_is_asked_for_and_stops_when_it_is_left():
    """What is under way is stopped by its watch; what has not begun never begins."""
    seen, begun = [], threading.Event()

    def long(task):
        begun.set()
        seen.append((task, current_watch().stop.wait(10.0)))

    with threads(1)() as team:
        assert team.size == 1
        assert sorted(team.run(counted, [1, 2, 3])) == [(-3, 3), (-2, 2), (-1, 1)]
        pending = team.run(long, ["a", "b", "c"])
        found = []
        thread = threading.Thread(target=lambda: found.append(outcome(pending)))
        thread.start()
        assert begun.wait(10.0)
    thread.join()
    assert found in ([(None, 0)], [Stopped])  # by whichever comes first, its own end or that of the next
    assert seen == [("a", True)]


@pytest.mark.parametrize("given", [0, 1, 4])
@pytest.mark.parametrize("workers", [threads, processes])
def test_a_team_that_was_left_gives_no_further_answers(workers, given):
    """Whether it has been asked for some before or not; what is asked then ends at once."""
    with workers(1)() as team:
        answers = team.run(counted, range(9))
        early = [next(answers) for _ in range(given)]
    assert len(early) == given
    found = [outcome(answers) for _ in range(9 - given)]
    assert Stopped in found
    assert outcome(team.run(counted, [1])) is Stopped


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal to one thread")
def test_an_interrupt_that_does_not_end_a_wait_is_noticed_soon():
    """As one that arrives just before the wait begins: here it is delivered to another thread."""
    left, given_up = threading.Event(), []

    def interrupt(_):
        time.sleep(0.1)  # until the wait has begun
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)
        given_up.append(not left.wait(5.0))

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(KeyboardInterrupt):
            next(as_they_come(pool, 1, interrupt, [0], left))
        left.set()
    assert given_up == [False]


def test_a_pool_that_takes_no_task_for_another_reason_says_so():
    with ThreadPoolExecutor(1) as pool:
        pass
    with pytest.raises(RuntimeError, match="shutdown"):
        next(as_they_come(pool, 1, counted, [1], threading.Event()))


def test_steps_of_a_task_are_its_own():
    assert watched(counted, 7) == (-7, 7)
    assert current_watch() is None


@pytest.mark.parametrize("count", [0, -1, 2.0, "2"])
def test_a_number_of_threads_is_at_least_one(count):
    with pytest.raises(InputError, match=r"must be (a whole number, )?at least 1; leave it out to use all cores"):
        threads(count)
