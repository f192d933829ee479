"""The figure of a frequency response: strokes, peaks, jumps and phases where they belong."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from gelcone import Outcome
from gelcone.plots.branches import colour_of
from gelcone.plots.frequency import LOOKS, arrows, branch_strokes, frequency_figure, phases, strokes
from gelcone.plots.style import UNHELD, UNHELD_LABEL
from tests.plots.made_up import blank, data_of, line, result, texts
from tests.plots.test_branches import VALUES, branches

OMEGA = np.array([1.0, 2.0, 3.0, 4.0])
STROKE = {"up": [1.0, 2.0, 5.0, 1.5], "down": [1.1, 2.2, 2.6, 1.4]}
PERIOD = {"up": [1, 2, 0, 0], "down": [1, 1, 1, 1]}
PHASE = {"up": [0.0, -90.0, -179.0, 170.0], "down": [10.0, 40.0, 50.0, 60.0]}


def response(frequency=OMEGA, second=3.0, **units):
    each, wave = ("branch", "drive_frequency"), ("branch", "harmonic", "drive_frequency")
    outcome = np.zeros((2, 4), dtype=int)
    outcome[0, 3] = Outcome.STEP_LIMIT
    phase = np.stack([[np.full(4, 5.0), PHASE[b]] for b in ("up", "down")])
    return result(
        {
            "stroke": (each, [STROKE["up"], STROKE["down"]]),
            "period": (each, [PERIOD["up"], PERIOD["down"]]),
            "outcome": (each, outcome),
            "peak_frequency": ("branch", [2.9, 2.4]),
            "peak_amplitude": ("branch", [2.6, 1.35]),
            "linear_stroke": ("drive_frequency", [1.0, 2.0, 50.0, 1.0]),
            "harmonic_phase": (wave, phase),
            "linear_phase": (("harmonic", "drive_frequency"), [[0.0] * 4, [-45.0, -80.0, -100.0, -135.0]]),
            "linear_amplitude": (("harmonic", "drive_frequency"), [[1.0, 2.0, np.nan, 1.0], [0.5, second, 0.5, 0.5]]),
            "jump_branch": ("jump", ["up", "down"]),
            "jump_low": ("jump", [3.0, 2.0]),
            "jump_high": ("jump", [3.2, 2.2]),
            "jump_from": ("jump", [5.0, 1.2]),
            "jump_to": ("jump", [1.5, 2.6]),
        },
        {
            "drive_frequency": ("drive_frequency", frequency),
            "branch": ("branch", ["up", "down"]),
            "harmonic": ("harmonic", [1, 2]),
        },
        units,
    )


def drawn():
    axes = blank()
    strokes(response(), axes)
    return axes


@pytest.mark.parametrize("branch", ["up", "down"])
def test_each_sweep_is_its_stroke_over_the_frequency_in_its_own_colour(branch):
    own = line(drawn(), f"swept {branch}")
    at = {"up": (2.9, 5.2), "down": (2.4, 2.7)}[branch]
    order = np.argsort([*OMEGA, at[0]])
    expected = np.array([[*OMEGA, at[0]], [*STROKE[branch], at[1]]])[:, order]
    np.testing.assert_allclose(data_of(own), expected, err_msg="the curve goes through its refined peak")
    assert own.get_markevery() == [k for k, number in enumerate(order) if number < OMEGA.size]
    assert own.get_color() == LOOKS[branch]["color"]
    assert own.get_marker() == LOOKS[branch]["marker"]


def test_many_points_are_not_marked_one_by_one():
    axes, many = blank(), np.linspace(1.0, 4.0, 61)
    strokes(
        response()
        .interp(drive_frequency=many, kwargs={"fill_value": 0.0})
        .assign(
            period=response()["period"].sel(drive_frequency=many, method="nearest").assign_coords(drive_frequency=many)
        ),
        axes,
    )
    assert line(axes, "swept up").get_marker() in ("", "None")
    np.testing.assert_array_equal(line(axes, "swept up").get_xdata(), many)


def test_peaks_stand_at_the_full_stroke():
    """The stroke is twice the amplitude."""
    axes = drawn()
    np.testing.assert_allclose(data_of(line(axes, "highest, up")), [[2.9], [5.2]])
    np.testing.assert_allclose(data_of(line(axes, "highest, down")), [[2.4], [2.7]])
    assert line(axes, "highest, down").get_markeredgecolor() == LOOKS["down"]["color"]


def test_what_does_not_follow_the_drive_is_marked_and_failed_runs_are_not():
    axes = drawn()
    sub, wild = line(axes, "subharmonic, swept up"), line(axes, "not periodic, swept up")
    np.testing.assert_array_equal(data_of(sub), [[2.0], [2.0]])
    np.testing.assert_array_equal(data_of(wild), [[3.0], [5.0]])
    assert to_rgb(sub.get_markerfacecolor()) == (1.0, 1.0, 1.0)
    assert to_rgb(wild.get_markerfacecolor()) == (0.0, 0.0, 0.0)
    assert not any("periodic, swept down" in one.get_label() for one in axes.lines)


def test_the_highest_stroke_and_not_the_linear_one_sets_the_height():
    axes = drawn()
    assert axes.get_ylim() == pytest.approx((0.0, 1.1 * 5.2))
    np.testing.assert_array_equal(data_of(line(axes, "linear theory")), [OMEGA, [1.0, 2.0, 50.0, 1.0]])


def test_where_the_model_does_not_hold_the_curve_is_faint():
    axes, data = blank(), response()
    data["validity_breakdown"] = (("branch", "drive_frequency"), np.array([[0.0, 0.0, 0.4, 0.2], [0.0] * 4]))
    strokes(data, axes)
    up = data_of(line(axes, "swept up"))
    np.testing.assert_array_equal(up[0], [1.0, 2.0, 2.9])
    faint = next(one for one in axes.lines if one.get_alpha() == UNHELD)
    assert data_of(faint).shape == (2, 5)
    assert len([one for one in axes.lines if one.get_label() == UNHELD_LABEL]) == 1


def test_an_arrow_goes_from_the_stroke_before_a_jump_to_the_one_after_it():
    axes = blank()
    arrows(response(), axes)
    up, down = axes.texts
    assert up.xyann == pytest.approx((3.1, 5.0))
    assert up.xy == pytest.approx((3.1, 1.5))
    assert down.xyann == pytest.approx((2.1, 1.2))
    assert down.xy == pytest.approx((2.1, 2.6))
    assert [to_rgb(a.arrow_patch.get_edgecolor()) for a in (up, down)] == [
        to_rgb(LOOKS[b]["color"]) for b in ("up", "down")
    ]
    assert up.arrow_patch.get_arrowstyle().arrow == "->"


def test_linear_theory_is_drawn_through_its_largest_stroke():
    axes, peak = blank(), {"linear_peak_frequency": 2.5, "linear_peak_stroke": 60.0}
    strokes(response().assign(peak), axes)
    linear = line(axes, "linear theory")
    np.testing.assert_array_equal(data_of(linear), [[1.0, 2.0, 2.5, 3.0, 4.0], [1.0, 2.0, 60.0, 50.0, 1.0]])


def test_the_phase_is_that_of_the_strongest_harmonic_of_linear_theory():
    axes = blank()
    phases(response(), axes)
    up, down, linear = (data_of(one) for one in axes.lines)
    # 170 degrees ahead are 190 behind; nothing is drawn across the turn
    np.testing.assert_allclose(up, [[1.0, 2.0, 3.0, 4.0], [0.0, -90.0, -179.0, -190.0]])
    np.testing.assert_allclose(down, [[1.0, 3.0, 4.0], [10.0, -310.0, -300.0]])
    np.testing.assert_allclose(linear, [OMEGA, [-45.0, -80.0, -100.0, -135.0]])
    assert axes.get_ylabel() == "phase at 2 x\nthe drive frequency\n(degrees)"
    assert axes.get_ylim() == (-315.0, 45.0)
    np.testing.assert_array_equal(axes.get_yticks(), [-270.0, -180.0, -90.0, 0.0])
    assert [one.get_color() for one in axes.lines[:2]] == [LOOKS[b]["color"] for b in ("up", "down")]
    first = blank()
    phases(response(second=1.0), first)
    np.testing.assert_allclose(data_of(first.lines[0]), [OMEGA, np.full(4, 5.0)])
    assert first.get_ylabel() == "phase\n(degrees)"


@pytest.mark.parametrize(("highest", "scale"), [(4.9, "linear"), (5.1, "log")])
def test_a_wide_range_of_frequencies_has_a_log_scale(highest, scale):
    figure = frequency_figure(response(np.array([1.0, 2.0, 3.0, highest]), drive_frequency="Hz", stroke="mm"))
    stroke, phase = figure.axes
    assert phase.get_xscale() == scale
    assert phase.get_xlim() == pytest.approx((1.0, highest))
    assert phase.get_xlabel() == "drive frequency (Hz)"
    assert stroke.get_ylabel() == "stroke, peak to peak (mm)"
    assert "linear theory" in texts(figure)


def test_branches_have_their_stroke_and_their_events_lie_on_it():
    followed = branches(event_point=[1, 2, 2]).assign(
        highest=(("branch", "point"), [np.zeros(4), 3.0 * VALUES]), lowest=(("branch", "point"), [np.zeros(4), VALUES])
    )
    axes = blank()
    branch_strokes(response().assign(fixed_stroke=(("start", "drive_frequency"), np.full((1, 4), 0.5))), followed, axes)
    own = [
        data_of(one).T.tolist()
        for one in axes.lines
        if to_rgb(one.get_color()) == to_rgb(colour_of(followed.isel(branch=1)))
    ]
    assert own[:2] == [[[1.0, 2.0], [2.0, 4.0]], [[2.0, 4.0], [3.0, 6.0], [4.0, 8.0]]]  # stable, unstable
    assert own[2:4] == [[[2.5, 5.0]], [[3.5, 7.0]]]  # events
    assert axes.get_ylim() == pytest.approx((0.0, 1.1 * 8.0))
