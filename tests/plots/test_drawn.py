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


def test_a_band_holds_95_percent_of_the_draws_of_each_sweep():
    rng = np.random.default_rng(3)
    values = np.exp(rng.normal(size=(400, 2, 3)))
    result = xr.Dataset(
        {
            "stroke": (
                ("draw", "branch", "drive_frequency"),
                values,
                {"units": "mm", "long_name": "stroke, peak to peak"},
            )
        },
        {"drive_frequency": ("drive_frequency", [8.0, 9.0, 10.0], {"units": "Hz"}), "branch": ["up", "down"]},
        {"analysis": "frequency"},
    )
    (axes,) = drawn_figure(result).axes
    for k, (branch, band, line) in enumerate(zip(("up", "down"), axes.collections, axes.lines, strict=True)):
        x, y = band.get_paths()[0].vertices.T
        low, high = ([own(y[x == place]) for place in (8.0, 9.0, 10.0)] for own in (np.min, np.max))
        share = [np.mean((values[:, k, j] >= low[j]) & (values[:, k, j] <= high[j])) for j in range(3)]
        np.testing.assert_allclose(share, 0.95, atol=0.01)
        np.testing.assert_allclose(line.get_ydata(), np.median(values[:, k], axis=0))
        assert band.get_label() == f"95 % of the draws, swept {branch}"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("drive frequency (Hz)", "stroke (mm)")
