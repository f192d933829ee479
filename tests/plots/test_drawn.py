"""Bands of draws show the draws that have a value, and a gap where most have none."""

import numpy as np
import xarray as xr

from gelcone.plots.drawn import drawn_figure


def test_draws_without_a_value_are_no_zeros():
    values = np.outer(np.linspace(400.0, 500.0, 10), [1.0, 1.0, 1.0])
    values[7:, 0] = np.nan
    values[3:, 1] = np.nan
    result = xr.Dataset(
        {"recommended_peak": (("draw", "drive_frequency"), values, {"units": "V", "long_name": "peak"})},
        {"drive_frequency": ("drive_frequency", [8.0, 9.0, 10.0], {"units": "Hz"})},
        {"analysis": "envelope"},
    )
    (axes,) = drawn_figure(result).axes
    middle = axes.lines[0].get_ydata()
    np.testing.assert_allclose(middle, [np.median(values[:7, 0]), np.nan, 450.0])
    assert "without a value in 0.33 of them" in axes.collections[0].get_label()
