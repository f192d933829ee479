"""Parameter sets near the base set, and the motions of the base set itself from nearby starts."""

from dataclasses import replace

import numpy as np
import pytest

from gelcone.paper.effort import QUICK
from gelcone.paper.studies.neighbours import FACTOR, STARTS, neighbours, sets
from gelcone.presets import find_preset

TINY = replace(QUICK, name="tiny", neighbours=2, neighbour_voltages=2, patience=300.0)


def test_sets_are_within_a_factor_and_the_same_each_time():
    base = find_preset("base").model
    drawn = sets(200)
    for name, values in drawn.items():
        ratio = values / float(getattr(base, name))
        assert ratio.min() >= 1.0 / FACTOR
        assert ratio.max() <= FACTOR
        assert np.mean(ratio > 1.0) == pytest.approx(0.5, abs=0.1)
        np.testing.assert_array_equal(values, sets(200)[name])
    assert abs(np.corrcoef(list(drawn.values()))[0, 1]) < 0.2


@pytest.mark.slow
def test_the_study_of_the_neighbours():
    shares = []
    found = neighbours(TINY, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert dict(found.sizes) == {"set": 2, "voltage": 2, "prestretch": 3, "start": STARTS, "exponent": 2}
    assert np.isfinite(found["extent"].values).all()
    np.testing.assert_allclose(found["voltage"].values, [1.04, 2.0])
    # at the threshold the eight starts are the same motion, or chaos of the same size
    own = found["own_extent"].values
    assert (own[:, 0] > 0.3).all()
    assert (own < 7.1).all()  # where the film ends at J = 50
