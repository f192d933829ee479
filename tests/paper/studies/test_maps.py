"""The voltages of the maps behind figure 14."""

import numpy as np
import pytest

from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.studies.maps import BETWEEN, HIGH, voltages


@pytest.mark.parametrize("count", [QUICK.map_shape[0], FULL.map_shape[0]])
def test_voltages_are_closer_where_shares_are_counted(count):
    found, even = voltages(count), np.linspace(0.0, 2.0, count)
    steps = np.diff(found)
    assert (steps > 0.0).all()
    assert set(np.round(even, 12)) <= set(np.round(found, 12))  # no even voltage is left out
    high = found[:-1] > HIGH
    assert steps[~high] == pytest.approx(even[1])
    assert steps[high] == pytest.approx(even[1] / (BETWEEN + 1))
    assert (found > HIGH).sum() == ((even > HIGH).sum() - 1) * (BETWEEN + 1) + 1
