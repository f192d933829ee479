"""Figures of bifurcation diagrams: points, exponents, extents, strips and thresholds stand at their values."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from gelcone import ConeModel, Outcome, Regime, bifurcation
from gelcone.plots.bifurcation import (
    SWEEP_STYLES,
    bifurcation_figure,
    branch_styles,
    extent,
    largest_exponent,
    marker_size,
    marks,
    refined_edges,
    regime_strip,
    section_points,
    slack_shares,
    slack_states,
    thresholds,
)
from gelcone.plots.style import BLACK, PURPLE, save_figure
from tests.plots.made_up import DOUBTFUL, EXPONENT, blank, cells_of, colour, corners, data_of, line, result, texts

V = np.array([1.0, 2.0, 4.0])
BRANCHES = ["up", "down", "from 1,0"]
KINDS = np.array([[0, 3, 3], [1, 1, 3], [0, int(Regime.TRANSIENT), int(Regime.LEFT_THE_DOMAIN)]])
FLAGS = np.array([[0, 1, 0], [0, 0, 0], [0, 1, 1]])


def diagram(threshold=2, **changed):
    each = ("branch", "voltage")
    point = np.arange(3 * 3 * 2, dtype=float).reshape(3, 3, 2)
    outcome = np.zeros((3, 3), dtype=int)
    outcome[2, 2] = int(Outcome.STRETCH_LIMIT)
    values = {
        "section": ((*each, "point", "state"), np.stack([point, -100.0 - point], axis=-1)),
        EXPONENT: ((*each, "exponent"), np.stack([point[..., 0], point[..., 0] - 50.0], axis=-1)),
        "standard_error": ((*each, "exponent"), np.full((3, 3, 2), [0.5, 9.0])),
        "lowest": (each, -point[..., 0]),
        "highest": (each, point[..., 1]),
        "regime": (each, KINDS),
        "outcome": (each, outcome),
        DOUBTFUL: (each, FLAGS),
        "threshold_branch": ("threshold", np.array(["up", "down"])[:threshold]),
        "threshold_low": ("threshold", np.array([1.2, 2.5])[:threshold]),
        "threshold_high": ("threshold", np.array([1.4, 2.7])[:threshold]),
    }
    values |= changed
    data = result(values, {"voltage": ("voltage", V), "branch": ("branch", BRANCHES)}, attrs={"parameter": "voltage"})
    return data


def test_section_points_are_displacements_over_the_parameter_branch_by_branch():
    axes, data = blank(), diagram()
    section_points(data, axes)
    drawn = [one for one in axes.lines if one.get_xdata().size == 6]
    for one, branch in zip(
        drawn,
        ["from 1,0", "up", "down"] if list(branch_styles(data))[1] == "up" else ["from 1,0", "down", "up"],
        strict=True,
    ):
        own = data["section"].sel(branch=branch).isel(state=0).values
        np.testing.assert_array_equal(data_of(one), [np.repeat(V, 2), own.ravel()])
        assert to_rgb(one.get_color()) == colour(line(axes, branch))
    np.testing.assert_array_equal(line(axes, "a run failed").get_xdata(), [4.0])
    assert line(axes, "a run failed").get_transform() == axes.get_xaxis_transform()


def test_up_and_down_sweeps_differ_in_colour_and_marker_and_lie_over_fixed_states():
    styles = branch_styles(diagram())
    assert list(styles) == ["from 1,0", "down", "up"]
    assert len({style[0] for style in styles.values()}) == 3
    assert len({style[1] for style in styles.values()}) == 3
    assert styles["from 1,0"][:2] == (PURPLE, "o")
    assert styles["up"] == SWEEP_STYLES["up"]
    axes = blank()
    section_points(diagram(), axes)
    assert to_rgb(line(axes, "up").get_markerfacecolor()) == to_rgb(BLACK)
    assert line(axes, "down").get_markerfacecolor() == "none"
    assert (
        line(axes, "from 1,0").get_markersize()
        > line(axes, "down").get_markersize()
        > line(axes, "up").get_markersize()
    )


@pytest.mark.parametrize(("values", "size"), [(50, 2.4), (60, 2.0), (120, 1.0), (400, 0.55)])
def test_markers_shrink_with_the_number_of_values(values, size):
    data = diagram().isel(voltage=np.zeros(values, dtype=int))
    assert marker_size(data) == size


def test_the_largest_exponent_has_its_error_and_the_zero_line():
    axes, data = blank(), diagram()
    largest_exponent(data, axes)
    assert axes.lines[0].get_ydata() == [0.0, 0.0]
    for container, branch in zip(axes.containers, branch_styles(data), strict=True):
        own = data.sel(branch=branch)
        np.testing.assert_array_equal(data_of(container.lines[0]), [V, own[EXPONENT].values[:, 0]])
        bars = np.array([segment[:, 1] for segment in container.lines[2][0].get_segments()])
        np.testing.assert_allclose(np.diff(bars, axis=1), 1.0)
        np.testing.assert_allclose(bars.mean(axis=1), own[EXPONENT].values[:, 0])
    assert axes.get_ylabel() == "largest exponent\n(per unit time)"


def test_the_extent_is_the_lowest_and_highest_displacement():
    axes, data = blank(), diagram()
    extent(data, axes)
    for k, branch in enumerate(branch_styles(data)):
        own = data.sel(branch=branch)
        np.testing.assert_array_equal(data_of(axes.lines[2 * k]), [V, own["lowest"].values])
        np.testing.assert_array_equal(data_of(axes.lines[2 * k + 1]), [V, own["highest"].values])


def test_the_shares_of_a_slack_film_have_a_panel_where_it_is_slack():
    each, axes = ("branch", "voltage"), blank()
    share = np.arange(9.0).reshape(3, 3) / 10.0
    slack = diagram(film_state_taut=(each, 1.0 - share), film_state_crumpled=(each, share))
    slack["film_state_hoop_slack"] = each, np.zeros((3, 3))
    assert slack_states(slack) == ["film_state_crumpled"]
    assert slack_states(diagram()) == []
    slack_shares(slack, slack_states(slack), axes)
    np.testing.assert_array_equal(data_of(axes.lines[0]), [V, share[0]])  # the sweep up, drawn on top of the others
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["crumpled"]
    assert [len(bifurcation_figure(one).axes) for one in (slack, diagram())] == [4, 3]


def test_where_nothing_moves_the_diagram_has_room_beside_rest():
    axes, data = blank(), diagram()
    data["section"] = 1e-50 * data["section"]
    section_points(data, axes)
    assert axes.get_ylim() == (-1e-6, 1e-6)


def test_a_strip_has_a_row_a_branch_from_the_top():
    axes = blank()
    regime_strip(diagram(), axes)
    meshes = [c for c in axes.collections if hasattr(c, "get_coordinates")]
    for row, mesh in enumerate(meshes):
        _, y, values = cells_of(mesh)
        np.testing.assert_array_equal(y, [row - 0.5, row + 0.5])
        np.testing.assert_array_equal(values, KINDS[[row]])
    assert [text.get_text() for text in axes.get_yticklabels()] == BRANCHES
    assert axes.get_yticks().tolist() == [0, 1, 2]
    assert axes.get_ylim() == (2.5, -0.5)
    np.testing.assert_allclose(cells_of(meshes[0])[0], [0.5, 1.3, 3.0, 5.0])
    (hatched,) = (c for c in axes.collections if not hasattr(c, "get_coordinates"))
    np.testing.assert_array_equal(corners(hatched), [[3.0, 5.0, 1.5, 2.5]])
    # a transient says by its colour that it has not settled, and a failed run has no name to doubt
    dots = [data_of(one) for one in axes.lines]
    assert [points.shape[1] for points in dots] == [1, 0, 0]
    np.testing.assert_allclose(dots[0], [[0.5 * (1.3 + 3.0)], [0.0]])


def test_marks_leave_out_failed_and_unsettled_runs():
    regime, failed, doubtful = marks(diagram())
    np.testing.assert_array_equal(regime, KINDS)
    assert np.argwhere(failed).tolist() == [[2, 2]]
    assert np.argwhere(doubtful).tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("branch", "borders"),
    [("up", [0.5, 1.3, 3.0, 5.0]), ("down", [0.5, 1.5, 2.6, 5.0]), ("from 1,0", [0.5, 1.5, 3.0, 5.0])],
)
def test_the_strip_changes_colour_where_bisection_found_the_threshold(branch, borders):
    np.testing.assert_allclose(refined_edges(diagram(), branch), borders)


@pytest.mark.parametrize(
    ("low", "high", "borders"),
    [
        (1.0, 2.0, [0.5, 1.5, 3.0, 5.0]), (2.0, 4.0, [0.5, 1.5, 3.0, 5.0]), (1.0, 1.5, [0.5, 1.25, 3.0, 5.0]),
        (1.5, 2.0, [0.5, 1.75, 3.0, 5.0]), (3.5, 4.0, [0.5, 1.5, 3.75, 5.0]), (2.0, 2.5, [0.5, 1.5, 2.25, 5.0]),
    ],
)  # fmt: skip
def test_a_threshold_that_ends_at_a_value_moves_the_border_between_it_and_its_neighbour(low, high, borders):
    """As where few bisections or none were made; the ends of the strip stay."""
    ends = {"threshold_low": ("threshold", [low]), "threshold_high": ("threshold", [high])}
    data = diagram(threshold_branch=("threshold", ["up"]), **ends)
    np.testing.assert_allclose(refined_edges(data, "up"), borders)


def test_thresholds_are_intervals_on_their_row_and_through_the_panels():
    """A wide one is a bar at the foot of its row, above which the regime shows."""
    panels, data = [blank(), blank(), blank()], diagram()
    thresholds(data, panels)
    strips = np.concatenate([corners(c) for c in panels[2].collections])
    np.testing.assert_allclose(strips, [[1.2, 1.4, 0.35, 0.5], [2.5, 2.7, 1.35, 1.5]])
    for axes in panels[:2]:
        assert [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches] == [
            pytest.approx((1.2, 1.4)),
            pytest.approx((2.5, 2.7)),
        ]
        assert [to_rgb(p.get_facecolor()) for p in axes.patches] == [to_rgb(SWEEP_STYLES[b][0]) for b in ("up", "down")]
    assert not panels[2].patches
    assert panels[1].get_title(loc="right") == "changes of regime: 2, vertical lines"


@pytest.mark.parametrize(("count", "lines"), [(0, 0), (12, 12), (13, 0)])
def test_many_thresholds_are_only_marked_on_the_strip(count, lines):
    panels = [blank(), blank(), blank()]
    low = np.linspace(1.0, 3.0, count)
    more = {
        "threshold_branch": ("threshold", np.full(count, "up")),
        "threshold_low": ("threshold", low),
        "threshold_high": ("threshold", low + 0.01),
    }
    thresholds(diagram(**more), panels)
    assert [len(axes.patches) for axes in panels[:2]] == [lines, lines]
    assert len(panels[2].collections) == count
    title = {0: "", 12: "changes of regime: 12, vertical lines", 13: "changes of regime: 13, black on the strip below"}
    assert panels[1].get_title(loc="right") == title[count]


@pytest.mark.parametrize("middle", ["exponent", "extent"])
def test_the_panels_share_their_parameter(middle):
    figure = bifurcation_figure(diagram(), middle)
    assert all(axes.get_xlim() == (0.5, 5.0) for axes in figure.axes[:3])
    assert ("largest exponent" in texts(figure)) == (middle == "exponent")
    assert ("lowest and highest" in texts(figure)) == (middle == "extent")
    assert [figure.axes[k].get_xlabel() for k in range(3)] == ["", "", "voltage"]
    legend = [text.get_text() for text in figure.axes[1].get_legend().get_texts()]
    assert legend == ["rest", "periodic", "chaotic", "transient", "run failed", "evidence disagrees"]
    heights = [axes.get_position().y0 for axes in figure.axes[:3]]
    assert heights == sorted(heights, reverse=True)


def test_a_computed_diagram_is_drawn_and_its_strips_change_at_its_thresholds(tmp_path):
    model = ConeModel(damping_ratio=0.3, stretch_limit=5.0)
    found = bifurcation(model, "voltage", [1.0, 1.5, 2.0], bisections=2, transient=60.0, budget=100.0)
    save_figure(bifurcation_figure(found), tmp_path / "diagram.png")
    for branch in found["branch"].values:
        own = found["threshold_branch"].values == branch
        middles = 0.5 * (found["threshold_low"] + found["threshold_high"]).values[own]
        assert middles.size
        assert np.isin(middles, refined_edges(found, str(branch))).all()
