"""A branch as arrays: all that was found, and how it ended, comes back as it was."""

from dataclasses import is_dataclass

import numpy as np
import pytest

from gelcone.atlas.branches.branch import Ending, Event, EventKind
from gelcone.atlas.branches.checkpoint import Checkpoint
from gelcone.atlas.branches.event import DOUBLE, FOLD, Born, Singular
from gelcone.atlas.branches.point import Direction, Point
from gelcone.motion.orbit import Kind

RNG = np.random.default_rng(8)


def nodes():
    return RNG.normal(size=(3, 2))


def singular(at):
    return Singular(nodes(), RNG.normal(size=1), RNG.normal(size=1), nodes(), nodes(), RNG.normal(size=2) + 1j, at)


def some(ended=None, merge=None, events=True):
    points = [Point(nodes(), RNG.normal(), RNG.normal(size=2) + 2j, Direction(nodes(), RNG.normal())) for _ in range(4)]
    found = Checkpoint(points, 0.37)
    if events:
        found.events = [
            Event(EventKind.FOLD, singular(FOLD), Born(0.3, nodes(), 1.5), 0.0, 1, Kind(2), True),
            Event(EventKind.PERIOD_DOUBLING, singular(DOUBLE), None, -1.0, 2, Kind(2), False),
        ]
    found.ended, found.merge = ended, merge
    return found


def same(one, other):
    for a, b in zip(vars(one).values(), vars(other).values(), strict=True):
        if is_dataclass(a) and not isinstance(a, Kind):
            same(a, b)
        else:
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("ended", [None, *Ending])
def test_what_is_stored_comes_back_as_it_was(ended):
    found = some(ended, (Kind(1, True), singular(DOUBLE)) if ended is Ending.MERGED else None)
    again = Checkpoint.of(found.arrays(), Kind(2))
    assert again.ended == found.ended
    assert again.step == found.step
    for one, other in ((found.points, again.points), (found.events, again.events)):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            same(a, b)
    assert (again.merge is None) == (found.merge is None)
    if found.merge is not None:
        assert again.merge[0] == found.merge[0]
        same(found.merge[1], again.merge[1])


def test_a_branch_without_events_has_none_and_its_end_may_lie_behind_a_last_point():
    found = some(events=False)
    assert Checkpoint.of(found.arrays(), Kind(1)).events == []
    last = some().points[0]
    assert found.finish(Ending.CLOSED, last) is found
    assert found.points[-1] is last
    assert found.ended is Ending.CLOSED
