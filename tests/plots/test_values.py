"""The figure of results that have none of their own."""

import numpy as np
import xarray as xr

from gelcone.plots.values import values_figure


def test_whole_numbers_have_whole_ticks_and_labels_fit_their_panel():
    harmonics = xr.DataArray([0.3, 0.1, 0.0, 0.0], dims="harmonic", attrs={"units": "mm"})
    result = xr.Dataset({"harmonic_amplitude": harmonics}, coords={"harmonic": [1, 2, 3, 4]})
    (axes,) = values_figure(result).axes
    ticks = axes.get_xticks()
    np.testing.assert_array_equal(ticks, np.round(ticks))
    assert axes.get_ylabel() == "harmonic amplitude\n(mm)"
