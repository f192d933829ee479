"""Figures 4, 5, 7, 10 and 11 on made-up motions, and the marks that figures share."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from gelcone.codes import Regime
from gelcone.paper.figures.marks import SYMBOLS, film_legend, fixed_parameters, listed, mark_slack
from gelcone.paper.figures.triptych import (
    LATE_SPAN,
    caption,
    driven_little,
    from_the_start,
    in_the_long_run,
    keep_open,
    phase_portrait,
    poincare_section,
)
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.plots.style import BLACK, GREY
from tests.plots.made_up import data_of

TIME = np.array([0.0, 1.0, 2.0, 3.0])
LATE = LATE_SPAN * np.array([0.0, 0.5, 1.5, 3.0])


def motion(kind=Regime.PERIODIC, reach=1.0, error=0.002):
    return xr.Dataset(
        {
            "regime": ((), int(kind)),
            "period": ((), 2),
            "finite": ("exponent", [0.0123, -1.0]),
            "lyapunov": ("exponent", [-0.05, -1.0]),
            "standard_error": ("exponent", [error, 9.0]),
            "late_highest": ((), reach),
            "late_lowest": ((), -reach),
            "window_highest": ((), 2.0),
            "window_lowest": ((), -1.0),
            "displacement": ("time", TIME),
            "velocity": ("time", -TIME),
            "slack": ("time", [0, 1, 0, 0]),
            "late_displacement": ("late_time", 10.0 + TIME),
            "late_velocity": ("late_time", 20.0 + TIME),
            "late_slack": ("late_time", [0, 0, 0, 0]),
            "window_validity_slack": ((), 0.254),
            "late_validity_slack": ((), 0.5),
            "early_section_displacement": ("early_repeat", [1.0, 2.0]),
            "early_section_velocity": ("early_repeat", [3.0, 4.0]),
            "section_displacement": ("repeat", [5.0, 6.0]),
            "section_velocity": ("repeat", [7.0, 8.0]),
        },
        coords={"time": TIME, "late_time": LATE},
    )


def test_the_caption_holds_both_exponents_and_the_motion():
    assert caption(motion()) == (
        "window: $\\lambda_1 = +0.0123$\nlong run: periodic, period 2,\n$\\lambda_1 = -0.0500 \\pm 0.0020$"
    )
    assert caption(motion(error=0.9e-4)).endswith("\\pm{}<0.0001$")
    assert caption(motion(error=1.1e-4)).endswith("\\pm 0.0001$")


@pytest.mark.parametrize(
    ("kind", "reach", "little"),
    [
        (Regime.PERIODIC, 0.14, True),
        (Regime.PERIODIC, 0.16, False),
        (Regime.REST, 0.01, False),
        (Regime.CHAOTIC, 0.1, True),
    ],
)
def test_little_is_less_than_a_tenth_of_the_window_and_no_rest(kind, reach, little):
    assert driven_little(motion(kind, reach)) is little


def test_time_responses_stand_over_time_with_their_share_of_slack():
    start, late = Figure().subplots(2, 1)
    from_the_start(motion(), start)
    np.testing.assert_array_equal(data_of(start.lines[0]), [TIME, TIME])
    assert [text.get_text() for text in start.texts] == ["slack 25 %"]
    assert start.lines[0].get_color() == BLACK
    in_the_long_run(motion(), late)
    np.testing.assert_array_equal(data_of(late.lines[0]), [LATE[:2], [10.0, 11.0]])
    assert [text.get_text() for text in late.texts] == ["slack 50 %"]
    assert late.lines[0].get_color() == REGIME_COLOURS[Regime.PERIODIC]
    assert late.get_xlabel() == "after the transient"
    small = Figure().add_subplot()
    in_the_long_run(motion(reach=0.1), small)
    assert small.get_xlabel() == "after the transient (enlarged)"


def test_the_phase_portrait_has_velocity_over_displacement_and_marks_where_rest_is():
    axes = Figure().add_subplot()
    phase_portrait(motion(), axes)
    window, late = axes.lines
    np.testing.assert_array_equal(data_of(window), [TIME, -TIME])
    np.testing.assert_array_equal(data_of(late), [[10.0, 11.0, 12.0], [20.0, 21.0, 22.0]])
    assert window.get_color() == GREY
    for other in (motion(Regime.REST), motion(reach=0.1)):
        axes = Figure().add_subplot()
        phase_portrait(other, axes)
        np.testing.assert_array_equal(data_of(axes.lines[2]), [[12.0], [22.0]])


@pytest.mark.parametrize(
    ("kind", "size"), [(Regime.PERIODIC, 5.0), (Regime.CHAOTIC, 1.4), (Regime.QUASI_PERIODIC, 1.4), (Regime.REST, 5.0)]
)
def test_sections_are_crosses_of_the_window_and_dots_of_the_long_run(kind, size):
    axes = Figure().add_subplot()
    poincare_section(motion(kind), axes)
    early, late = axes.lines
    np.testing.assert_array_equal(data_of(early), [[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(data_of(late), [[5.0, 6.0], [7.0, 8.0]])
    assert (early.get_marker(), late.get_marker(), late.get_markersize()) == ("x", "o", size)
    assert late.get_color() == REGIME_COLOURS[kind]


@pytest.mark.parametrize(
    ("x", "y", "wide", "high"),
    [
        ((0.0, 4.0), (0.0, 0.1), (0.0, 4.0), (-0.45, 0.55)),
        ((0.0, 0.1), (2.0, 6.0), (-0.45, 0.55), (2.0, 6.0)),
        ((0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 1.0)),
    ],
)
def test_no_side_is_less_than_a_quarter_of_the_other(x, y, wide, high):
    axes = Figure().add_subplot()
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    keep_open(axes)
    np.testing.assert_allclose(axes.get_xlim(), wide, atol=1e-12)
    np.testing.assert_allclose(axes.get_ylim(), high, atol=1e-12)


def test_a_slack_film_is_faint_without_gaps():
    axes = Figure().add_subplot()
    mark_slack(axes, np.arange(6.0), 10.0 + np.arange(6.0), [0, 1, 1, 1, 0, 0], BLACK)
    faint, strong = axes.lines
    np.testing.assert_array_equal(data_of(faint)[0], np.arange(6.0))
    np.testing.assert_array_equal(data_of(strong)[0], [0.0, 1.0, 4.0, 5.0])
    assert faint.get_alpha() < 1.0


def test_symbols_and_lists_in_words():
    assert SYMBOLS["spring_stiffness"] == r"$\kappa$"
    assert listed((0.5, 1.04, 1.7)) == "0.5, 1.04 and 1.7"
    study = xr.Dataset(attrs={"model": '{"voltage": 0.5, "damping_ratio": 0.01}', "preset": "base"})
    assert fixed_parameters(study) == r"set base: $\zeta$ = 0.01, $v$ = 0.5"
    assert fixed_parameters(study, "voltage", "prestretch") == "set base: $v$ = 0.5"


def test_the_legend_names_each_motion_once():
    figure = Figure(layout="constrained")
    film_legend(figure, [Regime.REST, Regime.CHAOTIC, Regime.REST])
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[3:] == ["long run: rest", "long run: chaotic"]
