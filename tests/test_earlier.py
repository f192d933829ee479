"""Names of earlier versions: exchanged at once, and only where a result has them all and not yet today's."""

import numpy as np
import xarray as xr

from gelcone.earlier import NAMES, with_names_of_today


def test_the_curves_and_the_motions_of_an_envelope_exchange_their_axes():
    dims = {"static_displacement": ("peak_voltage", [1.0, 2.0]), "driven_stroke": ("driven_peak", [3.0, 4.0, 5.0])}
    coords = {"peak_voltage": [10.0, 20.0], "driven_peak": [30.0, 40.0, 50.0], "own_peak": 7.0, "own_frequency": 8.0}
    old = xr.Dataset(dims | {"coexisting": ("k", np.zeros(2))}, coords)
    new = with_names_of_today(old)
    assert new["static_displacement"].dims == ("constant_voltage",)
    assert new["constant_voltage"].values.tolist() == [10.0, 20.0]
    assert new["driven_stroke"].dims == ("peak_voltage",)
    assert new["peak_voltage"].values.tolist() == [30.0, 40.0, 50.0]
    assert (float(new["operating_peak_voltage"]), float(new["operating_frequency"])) == (7.0, 8.0)
    assert with_names_of_today(new) is new


def test_a_result_of_today_that_has_one_of_the_names_stays_as_it_is():
    for names in NAMES:
        if len(names) > 1:
            today = xr.Dataset({next(iter(names)): 1.0})
            assert with_names_of_today(today) is today
