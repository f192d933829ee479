"""The cascade that leads to chaos in the base set: where it ends, and on which branch."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.paper.studies import cascade as module
from gelcone.paper.studies.cascade import cascade
from gelcone.presets import find_preset


@pytest.mark.slow
def test_the_doublings_of_the_base_set_end_at_the_threshold_of_chaos():
    model = find_preset("base").model
    followed = gelcone.continue_branch(model, "voltage", 0.93, 1.003, switch=0, checks=2)
    found = cascade(model, followed)
    doublings = found["doubling"][1]
    assert doublings[:3] == pytest.approx([1.0012791592, 1.0249821545, 1.0276379323], abs=1e-9)
    end, error = found["cascade_end"][1], found["cascade_end_error"][1]
    assert abs(end - 1.02830633) < 2.0 * error < 1e-5
    _, value, about = found["cascade_born"]
    assert value == pytest.approx(0.9392035806, abs=1e-9)
    assert about["born"] == "loss of rest"


def test_without_doublings_there_is_no_cascade():
    model = find_preset("base").model
    followed = gelcone.continue_branch(model, "voltage", 0.945, 0.955, switch=0, checks=2)
    assert cascade(model, followed) == {}


def test_a_cascade_ends_where_feigenbaums_ratio_says():
    """Doublings whose distances shrink by exactly that ratio, towards 2: each level gives the same end."""
    ratio = 4.66920160910299
    doublings = [2.0 - ratio**-k for k in range(4)]
    followed = xr.Dataset({"event_value": ("event", [1.5]), "event_kind": ("event", [0])})
    found = module._told(followed, doublings, None)
    assert found["cascade_end"][1] == pytest.approx(2.0, abs=1e-12)
    assert found["cascade_end_error"][1] < 1e-12
    assert np.isnan(found["cascade_born"][1])
