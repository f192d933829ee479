"""Figures of sections: where the points stand, which are maxima, and the room around them."""

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from gelcone import Outcome
from gelcone.plots.section import MARKERS, failure, scatter, section_figure, section_points, set_room
from gelcone.plots.style import CYCLE
from tests.plots.made_up import blank, data_of, parameter, result, texts

X, U = np.array([[0.0, 2.0, np.nan], [1.0, 1.5, 0.5]]), np.array([[1.0, -3.0, np.nan], [5.0, 2.0, 0.0]])


def stroboscopic(units=None):
    each = ("member", "repeat")
    data = result(
        {"displacement": (each, X), "velocity": (each, U), "outcome": ("member", [int(Outcome.STEP_LIMIT), 0])},
        {"voltage": ("member", [0.5, 1.0])},
        units,
    )
    return parameter(data, "voltage")


def extrema():
    each = ("member", "event")
    return parameter(
        result(
            {
                "displacement": (each, [[3.0, -2.0, 2.5, np.nan], [1.0, -1.0, 0.5, -0.5]]),
                "phase": (each, [[0.25, 0.75, 0.3, np.nan], [0.1, 0.6, 0.2, 0.7]]),
                "maximum": (each, [[1, -1, 1, 0], [1, -1, 1, -1]]),
                "outcome": ("member", [0, 0]),
            },
            {"voltage": ("member", [0.5, 1.0])},
        ),
        "voltage",
    )


def test_displacement_is_along_x_and_velocity_along_y_member_by_member():
    axes = blank()
    section_points(stroboscopic({"displacement": "mm", "velocity": "m/s"}), axes)
    first, second = axes.collections
    np.testing.assert_array_equal(data_of(first), [[0.0, 2.0], [1.0, -3.0]])
    np.testing.assert_array_equal(data_of(second), [X[1], U[1]])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("displacement (mm)", "velocity (m/s)")
    assert [c.get_label() for c in axes.collections] == ["voltage 0.5, failed: step limit", "voltage 1"]
    assert [tuple(c.get_facecolor()[0]) for c in axes.collections] == [to_rgba(c) for c in CYCLE[:2]]


def test_all_points_lie_inside_the_limits():
    axes = blank()
    section_points(stroboscopic(), axes)
    np.testing.assert_allclose(axes.get_xlim(), (1.0 - 1.08, 1.0 + 1.08))
    np.testing.assert_allclose(axes.get_ylim(), (1.0 - 4.32, 1.0 + 4.32))


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ([0.0, 2.0], (-0.08, 2.08)),
        ([3.0, 3.0], (2.7, 3.3)),
        ([-3.0, -3.0 + 1e-9], (-3.3, -2.7)),
        ([0.0, 0.0], (-1.0, 1.0)),
        ([np.nan], (-0.04, 1.04)),
        ([-1.0, 0.0], (-1.04, 0.04)),
    ],
)
def test_rounding_is_not_magnified(values, limits):
    axes = blank()
    set_room(axes, np.array(values), np.array([0.0, 1.0]))
    np.testing.assert_allclose(axes.get_xlim(), limits, atol=1e-8)
    np.testing.assert_allclose(axes.get_ylim(), (-0.04, 1.04))


@pytest.mark.parametrize(("distinct", "size"), [(5, 18.0), (30, 10.0), (60, 5.0), (100, 3.0), (250, 1.5)])
def test_points_are_the_larger_the_fewer_can_be_told_apart(distinct, size):
    axes = blank()
    x = np.repeat(np.linspace(0.0, 1.0, distinct), 3)
    set_room(axes, x, x)
    scatter(axes, x, 1.0 - x, 1, "")
    (points,) = axes.collections
    assert points.get_sizes() == pytest.approx([size])
    own = blank().scatter([0.0], [0.0], marker=MARKERS[1] if size > 4.0 else "o").get_paths()[0]
    np.testing.assert_array_equal(points.get_paths()[0].vertices, own.vertices)


@pytest.mark.parametrize("axis", [0, 1])
def test_points_that_differ_in_one_direction_alone_are_told_apart(axis):
    axes = blank()
    place = np.zeros((2, 30))
    place[axis] = np.linspace(3.0, 5.0, 30)
    set_room(axes, *place)
    scatter(axes, *place, 0, "")
    assert axes.collections[0].get_sizes() == pytest.approx([10.0])


def test_extrema_of_one_run_stand_over_the_phase_maxima_and_minima_apart():
    figure = section_figure(extrema().isel(member=0))
    axes = figure.axes[0]
    maxima, minima = axes.collections[:2]
    assert (maxima.get_label(), minima.get_label()) == ("maxima", "minima")
    np.testing.assert_array_equal(data_of(maxima), [[0.25, 0.3], [3.0, 2.5]])
    np.testing.assert_array_equal(data_of(minima), [[0.75], [-2.0]])
    assert tuple(maxima.get_facecolor()[0]) == to_rgba(CYCLE[0])
    assert tuple(minima.get_facecolor()[0]) == to_rgba(CYCLE[1])
    np.testing.assert_allclose(axes.get_xlim(), (-0.04, 1.04))
    np.testing.assert_allclose(axes.get_ylim(), (0.5 - 2.7, 0.5 + 2.7))
    assert "filled" not in texts(figure)


def test_extrema_of_a_run_that_failed_say_so():
    own = extrema().isel(member=0)
    own["outcome"] = own["outcome"] * 0 + int(Outcome.STEP_LIMIT)
    labels = [text.get_text() for text in section_figure(own).axes[0].get_legend().get_texts()]
    assert labels == ["failed: step limit"] * 2


def test_extrema_of_an_ensemble_are_filled_maxima_and_open_minima():
    figure = section_figure(extrema())
    drawn = figure.axes[0].collections[:4]
    assert [len(c.get_facecolor()) for c in drawn] == [1, 0, 1, 0]
    assert [len(c.get_edgecolor()) for c in drawn] == [0, 1, 0, 1]
    np.testing.assert_array_equal(data_of(drawn[3]), [[0.6, 0.7], [-1.0, -0.5]])
    assert tuple(drawn[3].get_edgecolor()[0]) == to_rgba(CYCLE[1])
    assert "filled: maxima, open: minima" in texts(figure)
    legend = figure.axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["voltage 0.5", "voltage 1"]


def test_a_single_section_needs_no_legend_and_a_failed_one_says_why():
    one = stroboscopic().drop_vars("voltage")
    good, failed = section_figure(one.isel(member=1)), section_figure(one.isel(member=0))
    assert good.axes[0].get_legend() is None
    assert [text.get_text() for text in failed.axes[0].get_legend().get_texts()] == ["failed: step limit"]
    assert (failure(one.isel(member=0)), failure(one.isel(member=1))) == ("failed: step limit", "")
