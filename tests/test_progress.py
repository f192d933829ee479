"""Progress adds up, and a run is stopped by its watch."""

import threading

import pytest

from gelcone import ConeModel, simulate
from gelcone.progress import Stopped, Watch, advance, split_progress, watching, weighted


def test_a_share_is_reported_to_a_progress_if_there_is_one():
    told = []
    advance(told.append, 0.25)
    advance(None, 0.5)
    assert told == [0.25]


def test_a_weighted_progress_is_a_share_of_the_whole():
    told = []
    half = weighted(told.append, 0.5)
    half(0.25)
    half(0.75)
    assert told == [0.125, 0.375]
    assert weighted(None, 0.5) is None


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_two_parts_add_up_in_the_ratio_of_their_work(share):
    told = []
    first, second = split_progress(told.append, 3.0, 1.0, share)
    first(1.0)
    second(1.0)
    assert told == pytest.approx([0.75 * share, 0.25 * share])
    assert split_progress(None, 3.0, 1.0) == (None, None)


def test_a_watch_counts_steps_and_stops_what_it_watches():
    watch = Watch()
    with watching(watch):
        simulate(ConeModel(), periods=2)
    assert watch.steps > 10
    watch.stop.set()
    with pytest.raises(Stopped), watching(watch):
        simulate(ConeModel(), periods=2)
    counted = watch.steps
    simulate(ConeModel(), periods=2)  # outside nothing is watched
    assert watch.steps == counted


def test_a_watch_inside_another_gives_back_the_place():
    outer, inner = Watch(), Watch()
    with watching(outer):
        with watching(inner):
            simulate(ConeModel(), periods=1)
        before = outer.steps
        simulate(ConeModel(), periods=1)
    assert (before, outer.steps) == (0, inner.steps)


def test_a_watch_belongs_to_its_thread():
    watch = Watch()
    watch.stop.set()
    ended = []
    with watching(watch):
        other = threading.Thread(target=lambda: ended.append(simulate(ConeModel(), periods=1)))
        other.start()
        other.join()
    assert len(ended) == 1
