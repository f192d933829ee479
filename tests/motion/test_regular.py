"""Small linear systems: solutions by hand, and NaN where there is none."""

import numpy as np
import pytest

from gelcone.motion.regular import solved_where_regular


@pytest.mark.parametrize("unit", [1.0, 1.0j])
def test_regular_systems_are_solved_and_the_others_have_nan(unit):
    matrices = np.array([[[2.0, 1.0], [0.0, 4.0]], [[1.0, 2.0], [2.0, 4.0]], [[np.nan, 0.0], [0.0, 1.0]], np.eye(2)])
    right = np.array([[4.0, 8.0], [1.0, 1.0], [1.0, 1.0], [np.nan, 1.0]])
    found = solved_where_regular(unit * matrices[:, None], right[:, None])
    assert found.shape == (4, 1, 2)
    np.testing.assert_array_equal(found[0, 0], np.array([1.0, 2.0]) / unit)
    assert np.isnan(found[1:]).all()


def test_no_system_has_no_solution():
    assert solved_where_regular(np.empty((0, 3, 3)), np.empty((0, 3))).shape == (0, 3)
