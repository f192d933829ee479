"""The highest peak of a sweep: its bracket, its error, and jumps next to it."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas import resonance as module
from gelcone.motion.stepping import Falls
from tests.atlas.made_up_swings import HEIGHT, PLACE, RESTING, moving, resonance


def test_what_differs_from_a_peak_by_less_than_is_resolved_may_be_the_peak():
    places, nearly = np.array([[1.0, 2.0, 3.0, 4.0, 5.0]]), 1.0 - 0.5 * module.RESOLVED
    low, high = module._bracket(places, np.array([[0.5, nearly, 1.0, nearly, 0.9]]), np.array([3.0]), np.array([1.0]))
    assert (low.tolist(), high.tolist()) == ([1.0], [5.0])


def test_a_height_is_certain_where_the_motion_is_periodic_or_there_is_none():
    heights, period = np.array([[0.5, 0.6, -1.0, 0.7]]), np.array([[1, 0, 0, 2]])
    np.testing.assert_array_equal(module._certain(heights, period), [[0.5, np.nan, -1.0, 0.7]])


def test_a_peak_lies_between_the_next_places_that_are_certainly_lower():
    places, heights = (
        np.array([[1.0, 2.0, 3.0, 4.0, 5.0]] * 2),
        np.array([[0.2, 0.9, 1.0, np.nan, 0.5], [1, 2, 3, 4, 5.0]]),
    )
    low, high = module._bracket(places, heights, np.array([3.0, 5.0]), np.array([1.0, 5.0]))
    assert (low.tolist(), high.tolist()) == ([2.0, 4.0], [5.0, 5.0])


@pytest.fixture
def made_up(monkeypatch):
    """Swings, and what follows a motion, give the resonance."""

    def seen(model, final, period, **options):
        return moving(resonance(model.number("drive_frequency")), final[:, 0])

    monkeypatch.setattr(module, "swing", seen)
    monkeypatch.setattr(
        module, "carried", lambda model, before, height, search: seen(model, before.final, before.period)
    )


@pytest.mark.parametrize("fall", [None, (1.30, 1.41)])
def test_a_peak_is_narrowed_to_where_it_is(made_up, fall):
    """Its place within its bracket, its height within its error; a jump next to it widens the bracket."""
    met = np.array([[0.9, 1.2, 1.33, 1.45, 1.8]])
    trail = SimpleNamespace(sorted=lambda: (met, resonance(met), np.ones((1, 5), int), np.zeros((1, 5, 2))))
    ends = np.full((2, 1, 5), np.nan)
    if fall:
        ends[:, 0, 3] = fall
    falls = Falls(ends[1], ends[0], None)
    found = module.highest_peaks(RESTING.members(), trail, falls, None, {})
    assert found.low[0] < PLACE < found.high[0]
    assert abs(found.amplitude[0] - HEIGHT) <= found.error[0] < 2e-3
    assert found.amplitude[0] == resonance(found.frequency[0])
    assert (found.low[0] <= 1.30) == (found.high[0] >= 1.41) == bool(fall)
    assert found.high[0] - found.low[0] < (0.111 if fall else 0.02)


def test_the_error_of_a_peak_between_equal_heights_is_what_settled_motions_leave(made_up, monkeypatch):
    """On a plateau nothing but the share that is resolved says how far off its height may be."""
    monkeypatch.setattr(module, "carried", lambda model, *_: moving(np.full(model.size, HEIGHT)))
    met, level = np.array([[0.9, 1.2, 1.33, 1.45, 1.8]]), np.full((1, 5), HEIGHT)
    trail = SimpleNamespace(sorted=lambda: (met, level, np.ones((1, 5), int), np.zeros((1, 5, 2))))
    nothing = np.full((1, 5), np.nan)
    found = module.highest_peaks(RESTING.members(), trail, Falls(nothing, nothing, None), None, {})
    np.testing.assert_allclose(found.error, module.RESOLVED * HEIGHT)
    assert (found.low[0], found.high[0]) == (0.9, 1.8)


def test_a_peak_lies_as_low_and_as_high_as_a_fall_that_touches_its_bracket(made_up):
    """Ends of a fall beyond either end of the bracket widen it on that side; a fall elsewhere does not."""
    met = np.array([[0.9, 1.2, 1.33, 1.45, 1.8]])
    trail = SimpleNamespace(sorted=lambda: (met, resonance(met), np.ones((1, 5), int), np.zeros((1, 5, 2))))
    brackets = []
    for fall in ((1.1, PLACE), (PLACE, 1.75), (1.5, 1.7)):
        ends = np.full((2, 1, 5), np.nan)
        ends[:, 0, 2] = fall
        found = module.highest_peaks(RESTING.members(), trail, Falls(ends[0], ends[1], None), None, {})
        brackets.append((float(found.low[0]), float(found.high[0])))
    narrow = brackets[2]
    assert brackets[0] == (1.1, narrow[1])
    assert brackets[1] == (narrow[0], 1.75)
    assert 1.33 < narrow[0] < PLACE < narrow[1] < 1.45
