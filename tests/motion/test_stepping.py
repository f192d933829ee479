"""Motions along frequencies: when one has jumped, and all that was met, in order."""

import numpy as np
import pytest

from gelcone.codes import Outcome
from gelcone.motion.settled import Swing
from gelcone.motion.stepping import JUMPED, NEGLIGIBLE, Trail, jumped, walk
from gelcone.physics.model import ConeModel


def swings(*rows):
    """Motions by (lowest, highest, period)."""
    found = Swing.blank(len(rows), states=2)
    found.lowest[:], found.highest[:], found.period[:] = zip(*rows, strict=True)
    found.outcome[:] = Outcome.OK
    found.final[:] = np.arange(2.0 * len(rows)).reshape(-1, 2)
    return found


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ((-1.0, 1.0, 1), False),
        ((-1.0 - 0.9 * JUMPED, 1.0 + 0.9 * JUMPED, 1), False),
        ((-1.0 - 1.5 * JUMPED, 1.0 + 1.5 * JUMPED, 1), True),
        ((-1.0 + 1.5 * JUMPED, 1.0 + 1.5 * JUMPED, 1), True),
        ((-1.0, 1.0, 0), True),
    ],
)
def test_a_motion_has_jumped_where_amplitude_or_middle_changed_much_or_it_is_lost(other, expected):
    one = swings((-1.0, 1.0, 1))
    assert jumped(one, swings(other), np.array([1.0])).tolist() == [expected]


def test_what_is_negligible_failed_or_was_not_periodic_has_not_jumped():
    tiny = NEGLIGIBLE * 0.4
    assert jumped(swings((-tiny, tiny, 1)), swings((0.0, 0.0, 1)), np.array([1.0])).tolist() == [False]
    assert jumped(swings((-tiny, tiny, 1)), swings((0.0, 0.0, 1)), np.array([tiny])).tolist() == [True]
    assert jumped(swings((-1.0, 1.0, 0)), swings((-3.0, 3.0, 1)), np.ones(1)).tolist() == [False]
    failed = swings((np.nan, np.nan, 0))
    failed.outcome[:] = Outcome.PULLED_IN
    assert jumped(swings((-1.0, 1.0, 1)), failed, np.ones(1)).tolist() == [False]


def test_what_was_met_is_sorted_by_frequency_for_each_member():
    trail = Trail()
    trail.add(np.array([0, 1]), np.array([2.0, 5.0]), swings((-1.0, 1.0, 1), (-2.0, 2.0, 3)), 2)
    trail.add(np.array([1]), np.array([4.0]), swings((-3.0, 3.0, 2)), 2)
    trail.add(np.array([0]), np.array([1.0]), swings((-4.0, 4.0, 5)), 2)
    frequency, amplitude, period, final = trail.sorted()
    np.testing.assert_array_equal(frequency, [[1.0, 2.0, np.nan], [4.0, 5.0, np.nan]])
    np.testing.assert_array_equal(amplitude, [[4.0, 1.0, np.nan], [3.0, 2.0, np.nan]])
    assert period.tolist() == [[5, 1, 0], [2, 3, 0]]
    np.testing.assert_array_equal(final[:, 0], [[0.0, 1.0], [0.0, 1.0]])
    assert final.shape == (2, 3, 2)


def test_a_walk_reaches_each_frequency_and_reports_all_of_it():
    """Alike up and down where nothing jumps: the linear amplitude of a stiff spring."""
    model = ConeModel(
        film="taut", spring_stiffness=[8.0, 9.0], rest_height=0.4, voltage=0.05, voltage_bias=0.3, damping_ratio=0.2
    ).members()
    up = np.tile([1.0, 2.0, 2.5], (2, 1))
    told: list[float] = []
    start = model.start_states((0.3, 0.0))
    found, back = (walk(model, grid, start, told.append, {}) for grid in (up, up[:, ::-1]))
    assert sum(told) == pytest.approx(2.0)
    assert (found.reached.outcome == Outcome.OK).all()
    assert (found.reached.period == 1).all()
    np.testing.assert_allclose(found.reached.amplitude, back.reached.amplitude[:, ::-1], rtol=1e-6)
    assert np.isnan(found.falls.start).all()
    frequency, *_ = found.trail.sorted()
    for k in range(2):
        assert set(up[k]) <= set(frequency[k])
