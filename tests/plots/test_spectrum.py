"""Figures of spectra: amplitudes over frequency, lines marked and labelled, limits, the verdict."""

import numpy as np
import pytest

from gelcone import Outcome
from gelcone.plots.spectrum import DEEPEST, amplitude_spectrum, label_lines, spectrum_figure, verdict
from gelcone.plots.style import BLUE, VERMILION
from tests.plots.made_up import blank, data_of, parameter, result, texts

RATIO = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5])
AMPLITUDE = np.array([7.0, 1e-3, 0.2, 0.0, 0.05, 1e-12])


def spectrum(share=0.9, outcome=0, flatness=2.5e-7, **units):
    return result(
        {
            "amplitude": ("frequency_ratio_dim", AMPLITUDE),
            "frequency": ("frequency_ratio_dim", 10.0 * RATIO),
            "frequency_ratio": ("frequency_ratio_dim", RATIO),
            "line_frequency": ("line", [10.0, 20.0, np.nan]),
            "line_ratio": ("line", [1.0, 2.0, np.nan]),
            "line_amplitude": ("line", [0.2, 0.05, np.nan]),
            "power_in_lines": ((), share),
            "flatness": ((), flatness),
            "outcome": ((), outcome),
        },
        units=units,
    )


@pytest.mark.parametrize(
    ("units", "scale", "label"),
    [({}, 1.0, "frequency / drive frequency"), ({"frequency": "Hz"}, 10.0, "frequency (Hz)")],
)
def test_amplitudes_stand_over_the_frequency_with_their_lines_marked(units, scale, label):
    axes = blank()
    amplitude_spectrum(spectrum(**units), axes)
    curve, marks = axes.lines
    # neither the mean displacement nor what is zero is part of a log picture
    shown = [1, 2, 4, 5]
    np.testing.assert_array_equal(data_of(curve), [scale * RATIO[shown], AMPLITUDE[shown]])
    np.testing.assert_array_equal(data_of(marks), [[scale, 2.0 * scale], [0.2, 0.05]])
    assert (curve.get_color(), marks.get_markeredgecolor()) == (BLUE, VERMILION)
    assert axes.get_xlabel() == label
    assert axes.get_yscale() == "log"
    # up to the highest frequency that is seen above rounding
    assert axes.get_xlim() == pytest.approx((0.0, 1.02 * 2.0 * scale))
    assert axes.get_ylim() == pytest.approx((0.5e-3, 4.0))
    assert [text.get_text() for text in axes.texts] == [f"{scale:.4g}", f"{2 * scale:.4g}"]
    assert [text.xy for text in axes.texts] == [(scale, 0.2), (2.0 * scale, 0.05)]


def test_the_limits_end_above_rounding():
    axes, data = blank(), spectrum()
    data["amplitude"][1] = 1.5 * DEEPEST * 0.2
    amplitude_spectrum(data, axes)
    assert axes.get_ylim()[0] == pytest.approx(DEEPEST * 0.2)


def test_what_stands_still_has_no_curve():
    axes = blank()
    amplitude_spectrum(spectrum(share=np.nan, flatness=np.nan), axes)
    assert data_of(axes.lines[0]).size == 0
    assert axes.get_title(loc="right") == "stands still"


def test_the_run_of_a_drive_that_does_not_repeat_stands_over_the_frequency_itself():
    axes = blank()
    amplitude_spectrum(spectrum(share=np.nan).assign(line_amplitude=("line", [np.nan] * 3)), axes)
    curve, marks = axes.lines
    np.testing.assert_array_equal(curve.get_xdata()[np.isfinite(curve.get_ydata())], 10.0 * RATIO[[1, 2, 4, 5]])
    assert data_of(marks).size == 0
    assert axes.get_xlabel() == "frequency"
    assert axes.get_xlim() == pytest.approx((0.0, 1.02 * 20.0))
    assert axes.get_title(loc="right") == "of the run, flatness 2.5e-07"


def test_the_verdict_in_words():
    assert verdict(spectrum()) == "90 % of the variance in lines, flatness 2.5e-07"
    assert verdict(spectrum(outcome=int(Outcome.STRETCH_LIMIT))) == "failed: stretch limit"


def test_labels_do_not_run_into_each_other_and_the_strongest_win():
    axes = blank()
    axes.set_xlim(0.0, 10.0)
    at = np.array([5.0, 5.44, 5.46, np.nan, 12.0, 0.0, 10.0, 1.0, 2.0, 3.0, 4.0, 7.0])
    label_lines(axes, at, np.linspace(1.0, 0.1, at.size))
    # 0.045 of the width of 10 apart, and no more than eight
    assert [text.get_text() for text in axes.texts] == ["5", "5.46", "0", "10", "1", "2", "3", "4"]


def test_members_share_their_limits_and_have_a_panel_each():
    both = spectrum().expand_dims(member=2).copy(deep=True)
    both["amplitude"][1] *= 10.0
    both = parameter(both.assign_coords(voltage=("member", [0.5, 1.0])), "voltage")
    figure = spectrum_figure(both)
    top, bottom = figure.axes
    assert top.get_ylim() == bottom.get_ylim() == pytest.approx((0.5e-3, 40.0))
    assert (top.get_xlabel(), bottom.get_xlabel()) == ("", "frequency / drive frequency")
    assert [axes.get_title(loc="left") for axes in (top, bottom)] == ["voltage 0.5", "voltage 1"]
    assert top.get_position().y0 > bottom.get_position().y0
    np.testing.assert_allclose(data_of(bottom.lines[0])[1], 10.0 * data_of(top.lines[0])[1])
    assert "90 % of the variance" in texts(figure)
