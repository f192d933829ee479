"""Figure 9 on a made-up study: amplitudes, thresholds and responses stand at their volts."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from gelcone.paper.figures import FIGURES
from gelcone.paper.figures.practical import LOOKS, LOWEST, amplitudes, response
from tests.plots.made_up import data_of, line, texts

VOLTS = np.array([10.0, 30.0, 50.0])
TIME = np.array([0.0, 1000.0, 2000.0, 3000.0])


def practical():
    each = ("initial_height", "voltage_amplitude")
    motion = np.arange(2 * 3 * 4, dtype=float).reshape(2, 3, 4)
    return xr.Dataset(
        {
            "window_amplitude": (each, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
            "late_amplitude": (each, [[1e-9, 1e-6, 1e-9], [0.1, 0.2, 0.3]]),
            "onset_voltage": ("initial_height", [6000.0, np.nan]),
            "pitchfork_voltage": ("initial_height", [5000.0, 5500.0]),
            "rest_displacement": (each, [[0.0] * 3, [11.0] * 3]),
            "displacement": ((*each, "time"), motion),
        },
        coords={"initial_height": [0.0, 20.0], "voltage_amplitude": VOLTS, "time": TIME},
        attrs={"device": "a device"},
    )


def test_amplitudes_from_the_start_are_filled_and_those_of_the_long_run_open():
    axes = Figure().add_subplot()
    amplitudes(practical(), axes)
    window, late, still, raised, raised_late = axes.lines[:5]
    np.testing.assert_array_equal(data_of(window), [VOLTS, [1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(data_of(late), [[30.0], [1e-6]])
    np.testing.assert_array_equal(data_of(still), [[10.0, 50.0], [LOWEST, LOWEST]])
    np.testing.assert_array_equal(data_of(raised), [VOLTS, [4.0, 5.0, 6.0]])
    np.testing.assert_array_equal(data_of(raised_late), [VOLTS, [0.1, 0.2, 0.3]])
    assert late.get_markerfacecolor() == raised_late.get_markerfacecolor() == still.get_markerfacecolor() == "none"
    assert to_rgb(window.get_markerfacecolor()) == to_rgb(LOOKS[0][0])
    assert [one.get_marker() for one in (window, still, raised)] == ["o", "v", "s"]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_ylim() == (LOWEST, 1e3)
    assert axes.get_xlim() == (7.0, 3e4)


def test_thresholds_are_the_highest_at_which_rest_is_lost_and_the_volts_are_shaded():
    axes = Figure().add_subplot()
    amplitudes(practical(), axes)
    assert line(axes, "rest is lost under the drive").get_xdata() == [6000.0, 6000.0]
    assert line(axes, "rest is lost statically").get_xdata() == [5500.0, 5500.0]
    assert line(axes, "rest is lost statically").get_linestyle() == ":"
    (span,) = axes.patches
    assert (span.get_x(), span.get_width()) == (10.0, 40.0)
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    signs = dict(zip(words, axes.get_legend().legend_handles, strict=True))
    fills = [signs[name].get_markerfacecolor() for name in ("filled: from the start", "open: long run")]
    assert (to_rgb(fills[0]), fills[1]) == (to_rgb("black"), "none")
    assert words[:5] == [
        "initial height 0 mm",
        "initial height 20 mm",
        "filled: from the start",
        "open: long run",
        "long run: at rest",
    ]


def test_a_response_is_shown_in_seconds_up_to_2_5():
    axes = Figure().add_subplot()
    response(practical().sel(voltage_amplitude=30.0), axes)
    flat, rest, raised, raised_rest = axes.lines
    np.testing.assert_allclose(data_of(flat), [[0.0, 1.0, 2.0], [4.0, 5.0, 6.0]])
    np.testing.assert_allclose(data_of(raised), [[0.0, 1.0, 2.0], [16.0, 17.0, 18.0]])
    assert rest.get_ydata() == [0.0, 0.0]
    assert raised_rest.get_ydata() == [11.0, 11.0]
    assert [one.get_color() for one in axes.lines] == [LOOKS[0][0]] * 2 + [LOOKS[1][0]] * 2


def test_figure_9_has_the_amplitudes_beside_three_responses():
    figure = FIGURES[9].draw({"practical": practical()})
    amplitude, *responses = figure.axes
    assert [axes.get_title(loc="left") for axes in responses] == ["10 V", "30 V", "50 V"]
    for axes, first in zip(responses, (0.0, 4.0, 8.0), strict=True):
        assert axes.lines[0].get_ydata()[0] == first
    assert amplitude.get_position().x0 < responses[0].get_position().x0
    assert [axes.get_xlabel() for axes in responses] == ["", "", "time from the release (s)"]
    assert "a device" in texts(figure)
    assert amplitude.get_xlabel() == "voltage amplitude (V)"
    assert pytest.approx(3) == len(responses)
