"""Ranges in which sweeps up and down differ, and the jumps at their ends."""

import numpy as np
import pytest
import xarray as xr

from gelcone.atlas import hysteresis as module
from gelcone.motion.stepping import Falls
from gelcone.motion.swing import Swing
from tests.atlas.made_up_swings import RESTING, moving, swings
from tests.recorded import numbers


def test_sweeps_differ_by_a_fiftieth_of_the_larger_unless_both_are_chaotic_or_next_to_nothing():
    up = np.array([[1.0, 1.0, 1.0, 1e-9, 1.0]])
    down = np.array([[0.975, 0.985, 1.03, 2e-9, np.nan]])
    one = swings(np.stack([up, down], axis=1))
    assert module.differing(one).tolist() == [[True, False, True, False, False]]
    chaotic = swings(np.stack([up, down], axis=1), np.array([[[0, 1, 0, 1, 1], [0, 1, 2, 1, 1]]]))
    assert module.differing(chaotic).tolist() == [[False, False, True, False, False]]


@pytest.mark.parametrize("fall", [None, (1.55, 1.6), (1.59, 1.6)])
def test_jumps_are_bracketed_where_a_motion_ends(monkeypatch, fall):
    """The high motion lasts from 1.234 to 1.567; sweeps differ from 1.3 to 1.5, between the ends of which they are
    narrowed. The sweep down jumps at the lower end, with the strokes on both sides. The sweep up may have been seen to
    fall on the way; where the motion does not last to there, that says nothing."""
    first, last = 1.234, 1.567
    high, low = lambda w: 2.0 + w, lambda w: 0.1 * w

    def followed(model, before, largest, search):
        omega = model.number("drive_frequency")
        return moving(high(omega)), (omega >= first) & (omega <= last)

    def beside(model, final, **options):
        return moving(low(model.number("drive_frequency")))

    monkeypatch.setattr(module, "continued", followed)
    monkeypatch.setattr(module, "settled_swing", beside)
    grid = np.array([[1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7]])
    there = (grid > first) & (grid < last)
    # up: low until the sweeps agree, and on the high motion to its end; down: the same, as if each kept its own
    up = np.where(there, high(grid), low(grid))
    swept = moving(np.stack([up, low(grid)], axis=1))
    nothing = np.full((2, 7), np.nan)
    falls = Falls(nothing.copy(), nothing.copy(), Swing.blank(2, 7))
    if fall:
        falls.start[0, 5], falls.end[0, 5] = fall
    found = module.jumps_of_sweeps(RESTING.members(), grid, swept, falls, None, {})
    assert [module.BRANCHES[k] for k in found.branch] == ["down", "up"]
    for k, end in enumerate((first, last)):
        assert found.low[k] <= end <= found.high[k]
        assert found.high[k] - found.low[k] < 2e-3
        assert found.before[k] == pytest.approx(high(end), abs=1e-3)
        assert found.after[k] == pytest.approx(low(end), abs=1e-3)
    assert found.member.tolist() == [0, 0]


def test_jumps_are_listed_with_their_sweep_and_with_strokes_of_twice_the_amplitudes():
    jumps = module.Jumps(np.array([1, 0]), np.array([1, 0]), *(numbers(2, at=30.0 + k) for k in range(4)))
    table = xr.Dataset(module.jump_variables(jumps, True))
    assert table["jump_branch"].values.tolist() == ["down", "up"]
    assert table["jump_member"].values.tolist() == [1, 0]
    for k, (name, by) in enumerate((("low", 1.0), ("high", 1.0), ("from", 2.0), ("to", 2.0))):
        np.testing.assert_allclose(table[f"jump_{name}"], by * numbers(2, at=30.0 + k), err_msg=name)
    assert "jump_member" not in module.jump_variables(jumps, False)
