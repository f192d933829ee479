"""The page of a data sheet: forces on a load, and the limit that comes first in another colour than the others."""

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb

from gelcone.plots.datasheet import limit_bars, over_displacement, over_voltage
from gelcone.plots.style import BLUE, VERMILION
from tests.plots.made_up import blank, corners, data_of, line, result


def test_the_force_on_a_load_is_the_blocked_force_at_rest_and_none_at_the_free_stroke():
    sheet = result(
        {
            "rest_displacement": ((), 2.0),
            "force": (("constant_voltage", "displacement_value"), [[-3.0, -2.0, 0.0, 1.0]]),
            "blocked_force": ("constant_voltage", [2.0]),
            "stroke": ("constant_voltage", [4.0]),
        },
        {
            "constant_voltage": ("constant_voltage", [500.0]),
            "displacement": ("displacement_value", [0.0, 2.0, 6.0, 8.0]),
        },
        {"force": "N", "displacement": "mm", "constant_voltage": "V"},
    )
    axes = blank()
    over_displacement(sheet, axes)
    np.testing.assert_array_equal(data_of(line(axes, "500 V")), [[0.0, 2.0, 6.0, 8.0], [3.0, 2.0, 0.0, -1.0]])
    dots = {one.get_marker(): data_of(one).ravel().tolist() for one in axes.lines if one.get_marker() in "oD"}
    assert dots == {"o": [2.0, 2.0], "D": [6.0, 0.0]}
    np.testing.assert_array_equal(corners(axes.collections[0]), [[2.0, 6.0, 0.0, 2.0]])


def test_stroke_and_blocked_force_have_their_own_axes_and_units():
    sheet = result(
        {"ramp_stroke": ("ramp_voltage", [0.0, 4.0]), "ramp_blocked_force": ("ramp_voltage", [0.0, 2.0])},
        {"ramp_voltage": ("ramp_voltage", [0.0, 500.0])},
        {"ramp_stroke": "mm", "ramp_blocked_force": "N", "ramp_voltage": "V"},
    )
    axes = blank()
    over_voltage(sheet, axes)
    _, other = axes.figure.axes
    assert (axes.lines[0].get_ydata()[-1], axes.get_ylabel()) == (4.0, "free stroke (mm)")
    assert (other.lines[0].get_ydata()[-1], other.get_ylabel()) == (2.0, "blocked force (N)")


def test_the_first_limit_is_red_and_the_longest_bar_lowest():
    sheet = xr.Dataset(
        {
            "pull_in_voltage": 3000.0, "driven_hoop_slack_voltage": 900.0, "stretch_limit_voltage": np.inf,
            "first_limit_voltage": ((), 900.0, {"units": "V"}), "pitchfork_voltage": 100.0, "safe_peak_voltage": 500.0,
        }
    )  # fmt: skip
    axes = blank()
    limit_bars(sheet, axes)
    names = [text.get_text() for text in axes.get_yticklabels()]
    bars = [(bar.get_width(), bar.get_facecolor()[:3]) for bar in axes.patches]
    assert names == ["pull in", "drive: hoop slack"]
    assert bars == [(3000.0, to_rgb(BLUE)), (900.0, to_rgb(VERMILION))]
    assert axes.get_xlabel() == "peak voltage (V)"
