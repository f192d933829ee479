"""Figures of the statics: stable and unstable, pitchfork, folds and the jump of a slow ramp."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import gelcone
from gelcone import Outcome
from gelcone.physics.balance import PullIn
from gelcone.plots.equilibrium import MARKER_SIZES, delivered_force, equilibrium_branches, force_curves, static_figure
from gelcone.plots.style import BLUE, CYCLE, UNHELD, UNHELD_LABEL, VERMILION
from tests.plots.made_up import blank, corners, data_of, line, parameter, result, texts

X = np.linspace(-2.0, 2.0, 41)
LEVELS = np.linspace(0.0, 1.6, 9)


def statics(outcome=0, members=None, **changed):
    """A double well: force x (x^2 - v), with equilibria at 0 and +- sqrt(v)."""
    force = X * (X**2 - LEVELS[:, None])
    places = np.stack([-np.sqrt(LEVELS), 0.0 * LEVELS, np.sqrt(LEVELS)], axis=1)
    stable = np.tile([True, False, True], (9, 1))
    places[0], stable[0] = [np.nan, 0.0, np.nan], [False, True, False]
    values = {
        "force": (("constant_voltage", "displacement"), force),
        "stiffness": (("constant_voltage", "displacement"), 3.0 * X**2 - LEVELS[:, None]),
        "equilibrium_displacement": (("constant_voltage", "equilibrium"), places),
        "stable": (("constant_voltage", "equilibrium"), stable),
        "branch_voltage": ("step", [0.0, 0.5, 1.0, 1.5]),
        "branch_displacement": ("step", [0.0, 0.1, 0.2, 0.4]),
        "branch_slope": ("step", [2.0, 1.0, -1.0, -2.0]),
        "pitchfork_voltage": ((), 0.7),
        "pitchfork_displacement": ((), 0.25),
        "fold_voltage": ("fold", [1.2, np.nan]),
        "fold_displacement": ("fold", [0.9, np.nan]),
        "pull_in_voltage": ((), 1.2),
        "pull_in_from": ((), 0.9),
        "pull_in_to": ((), -1.7),
        "pull_in_kind": ((), int(PullIn.FOLD)),
    }
    values |= {name: (values[name][0], np.asarray(value)) for name, value in changed.items()}
    if members:
        values = {
            n: (("member", *np.atleast_1d(d)) if d != () else ("member",), np.stack([v] * members))
            for n, (d, v) in values.items()
        }
    values["outcome"] = ("member" if members else (), np.full(members, outcome) if members else outcome)
    coords = {"constant_voltage": ("constant_voltage", LEVELS), "displacement": ("displacement", X)}
    if members:
        coords["spring_stiffness"] = ("member", np.arange(1.0, members + 1.0))
        return parameter(result(values, coords), "spring_stiffness")
    return result(values, coords)


def test_force_is_solid_where_its_slope_is_positive_and_dashed_where_it_is_negative():
    axes = blank()
    force_curves(statics(), axes)
    curves = [one for one in axes.lines if len(one.get_xdata()) == X.size]
    assert len(curves) == 10  # five of the nine voltages, each solid and dashed
    for k, i in enumerate([0, 2, 4, 6, 8]):
        solid, dashed = curves[2 * k : 2 * k + 2]
        slope, force = 3.0 * X**2 - LEVELS[i], X * (X**2 - LEVELS[i])
        np.testing.assert_allclose(data_of(solid), [X[slope >= 0.0], force[slope >= 0.0]])
        np.testing.assert_allclose(data_of(dashed), [X[slope <= 0.0], force[slope <= 0.0]])
        assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
        assert solid.get_color() == dashed.get_color() == CYCLE[k]
        assert line(axes, f"voltage {LEVELS[i]:.4g}").get_color() == CYCLE[k]


def test_what_is_stable_everywhere_has_no_name_for_unstable():
    axes = blank()
    equilibrium_branches(statics(branch_slope=[2.0, 1.0, 1.0, 0.5]), axes)
    names = {one.get_label() for one in axes.lines}
    assert "stable" in names
    assert "unstable" not in names


def test_stable_equilibria_are_filled_and_unstable_ones_open_at_zero_force():
    axes = blank()
    force_curves(statics(), axes)
    marks = [one for one in axes.lines if one.get_marker() == "o"]
    filled, empty = marks[2:4]
    np.testing.assert_allclose(data_of(filled), [[-np.sqrt(0.4), np.sqrt(0.4)], [0.0, 0.0]])
    np.testing.assert_allclose(data_of(empty), [[0.0], [0.0]])
    assert to_rgb(filled.get_markerfacecolor()) == to_rgb(CYCLE[1])
    assert to_rgb(empty.get_markerfacecolor()) == (1.0, 1.0, 1.0)
    # without voltage there is one, and it is stable
    np.testing.assert_allclose(data_of(marks[0]), [[0.0], [0.0]])
    assert data_of(marks[1]).shape == (2, 0)
    assert [one.get_markersize() for one in marks[::2]] == list(MARKER_SIZES)


def test_the_force_is_shown_between_the_equilibria_and_not_up_to_the_wall():
    axes = blank()
    force_curves(statics(), axes)
    farthest = np.sqrt(1.6)
    near = np.abs(X) <= 1.1 * farthest
    most = 1.6 * np.abs(X * (X**2 - LEVELS[:, None]))[:, near].max()
    assert axes.get_ylim() == pytest.approx((-most, most))
    assert most < 0.8 * (8.0 - 0.0)
    pushed = blank()
    force_curves(statics(force=X * (X**2 - LEVELS[:, None]) - 10.0), pushed)
    assert pushed.get_ylim()[1] == pytest.approx(most + 16.0)  # the force is negative throughout
    flat = blank()
    force_curves(statics(equilibrium_displacement=np.zeros((9, 3))), flat)
    assert flat.get_ylim() == pytest.approx((-12.8, 12.8))


def test_branches_are_solid_where_stable_with_pitchfork_fold_and_limits():
    axes = blank()
    equilibrium_branches(statics(), axes)
    stable, unstable = axes.lines[:2]
    np.testing.assert_array_equal(data_of(stable), [[0.0, 0.5], [0.0, 0.1]])
    np.testing.assert_array_equal(data_of(unstable), [[1.0, 1.5], [0.2, 0.4]])
    assert (stable.get_linestyle(), unstable.get_linestyle()) == ("-", "--")
    assert (stable.get_color(), unstable.get_color()) == (BLUE, VERMILION)
    assert line(axes, "stable").get_color() == BLUE
    assert (line(axes, "unstable").get_color(), line(axes, "unstable").get_linestyle()) == (VERMILION, "--")
    np.testing.assert_array_equal(data_of(line(axes, "pitchfork 0.7")), [[0.7], [0.25]])
    np.testing.assert_array_equal(data_of(line(axes, "fold")), [[1.2], [0.9]])
    assert axes.get_xlim() == (0.0, 1.5)


def test_what_is_not_there_is_not_drawn():
    axes = blank()
    equilibrium_branches(statics(pitchfork_voltage=np.nan, fold_voltage=[np.nan, np.nan], pull_in_to=np.nan), axes)
    assert {one.get_label() for one in axes.lines if not one.get_label().startswith("_")} == {"stable", "unstable"}
    assert not axes.texts


def test_the_arrow_goes_from_where_the_ramp_jumps_to_where_it_lands():
    axes = blank()
    equilibrium_branches(statics(), axes)
    (arrow,) = axes.texts
    assert arrow.xyann == (1.2, 0.9)
    assert arrow.xy == (1.2, -1.7)
    assert arrow.arrow_patch.get_arrowstyle().arrow == "->"
    assert line(axes, "pull-in at 1.2 (fold)").get_marker() == r"$\uparrow$"
    gone = blank()
    equilibrium_branches(statics(pull_in_to=np.inf), gone)
    assert not gone.texts
    assert line(gone, "pull-in at 1.2 (fold)").get_marker() == "X"


def test_a_failed_member_says_so_instead_of_an_empty_picture():
    nothing = statics(int(Outcome.STEP_LIMIT), branch_voltage=np.full(4, np.nan))
    figure = static_figure(nothing)
    assert texts(figure).count("failed: step limit") == 2
    assert figure.axes[1].get_xlim() == (0.0, 1.0)


def test_branches_are_faint_where_the_model_does_not_hold():
    """Up to the next point at which it does, so that no gaps are left; results that do not say are not faint."""
    axes = blank()
    equilibrium_branches(statics().assign(branch_fails=("step", [False, False, False, True])), axes)
    faint = [one for one in axes.lines if one.get_alpha() == UNHELD]
    np.testing.assert_array_equal(data_of(faint[1]), [[1.0, 1.5], [0.2, 0.4]])
    assert (faint[1].get_color(), faint[1].get_linestyle()) == (VERMILION, "--")
    assert faint[-1].get_label() == UNHELD_LABEL
    full = [one for one in axes.lines if one.get_alpha() == 1.0]
    np.testing.assert_array_equal(data_of(full[0]), [[0.0, 0.5], [0.0, 0.1]])
    np.testing.assert_array_equal(data_of(full[1]), [[1.0], [0.2]])
    for fails in ({}, {"branch_fails": ("step", [False] * 4)}):
        equilibrium_branches(statics().assign(fails), axes := blank())
        assert not any(one.get_alpha() == UNHELD for one in axes.lines)


@pytest.mark.parametrize(("members", "rows"), [(2, 2), (5, 3)])
def test_up_to_three_members_have_a_row_each(members, rows):
    figure = static_figure(statics(members=members))
    assert len(figure.axes) == 2 * rows
    titles = [figure.axes[2 * k].get_title(loc="left") for k in range(rows)]
    assert titles == [f"spring stiffness {k}" for k in ([1, 2] if members == 2 else [1, 3, 5])]
    for axes in figure.axes[:2]:
        assert axes.get_legend() is not None
    assert all(axes.get_legend() is None for axes in figure.axes[2:])


def test_displacements_that_are_given_show_what_a_load_feels():
    device = gelcone.find_device("biased-pump")
    result = gelcone.static(device, ["0 V", "1.1 kV", "2.2 kV"], ["12 mm", "14 mm", "16 mm", "18 mm"])
    axes = gelcone.plot(result).axes[0]
    assert axes.get_ylabel() == "force on a load (N)"
    curves = [one for one in axes.lines if len(one.get_xdata()) == 4]
    for curve, force in zip(curves, result["force"].values, strict=True):
        assert curve.get_ydata().tolist() == (-force).tolist()
    points = {tuple(map(float, one.get_xydata()[0])) for one in axes.lines if len(one.get_xdata()) == 1}
    rest = float(result["rest_displacement"])
    for k in range(3):
        assert (rest, float(result["blocked_force"][k])) in points
        assert (rest + float(result["stroke"][k]), 0.0) in points
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels[2] == "2200 V: 0.0563 N, 2.71 mm, 0.17 mJ"
    assert "work of a cycle" in labels
    assert gelcone.plot(gelcone.static(device)).axes[0].get_ylabel() == "force that holds the disc (N)"


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_work_of_a_cycle_lies_between_the_forces_from_rest_to_the_stroke_on_either_side(way):
    place = way * np.array([0.5, 1.0, 2.0, 3.0, 4.0])
    force = way * np.array([[-1.0, 0.0, 1.0, 2.0, 3.0], [-4.0, -3.0, -2.0, 0.0, 1.0]])
    member = result(
        {
            "force": (("constant_voltage", "displacement"), force),
            "blocked_force": ("constant_voltage", [0.0, way * 3.0]), "stroke": ("constant_voltage", [0.0, way * 2.0]),
            "cycle_work": ("constant_voltage", [0.0, 1.5]), "rest_displacement": ((), way), "outcome": ((), 0),
        },
        {"constant_voltage": ("constant_voltage", [0.0, 2.0]), "displacement": ("displacement", place)},
    )  # fmt: skip
    axes = blank()
    delivered_force(member, axes)
    (area,) = axes.collections
    (x0, x1, *_), *more = corners(area)
    assert not more
    assert sorted((x0, x1)) == sorted((way * 1.0, way * 3.0))
    between = {(x, y) for x, y in area.get_paths()[0].vertices.tolist()}
    assert {(way * 2.0, -way), (way * 2.0, 2.0 * way)} <= between
    assert (float(way), way * 3.0) in {tuple(one.get_xydata()[0]) for one in axes.lines if len(one.get_xdata()) == 1}


def test_equilibria_at_which_the_model_does_not_hold_are_crossed():
    fails = np.zeros((9, 3))
    fails[8, 2] = fails[1, 0] = 0.5  # at the highest voltage, and at one whose force is not drawn
    found = statics().assign(validity_near_limit=(("constant_voltage", "equilibrium"), fails))
    force_curves(found, axes := blank())
    crosses = [data_of(one).tolist() for one in axes.lines if one.get_marker() == "x"]
    assert crosses == [[[np.sqrt(1.6)], [0.0]], [[], []]]
    assert line(axes, "model does not hold").get_marker() == "x"
    force_curves(found.assign(validity_near_limit=0.0 * found["validity_near_limit"]), axes := blank())
    assert not [one for one in axes.lines if one.get_marker() == "x"]
