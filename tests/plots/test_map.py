"""Figures of maps: cells, colours, marks and lines stand at their parameters."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

import gelcone
from gelcone import ConeModel, InputError, Outcome, Regime, find_device, to_si
from gelcone.plots.map import (
    exponent_bar,
    exponent_map,
    map_figure,
    marks,
    overlay,
    regime_map,
    signed_root,
    signed_square,
)
from gelcone.plots.style import save_figure
from tests.plots.made_up import DOUBTFUL, EXPONENT, blank, cells_of, corners, data_of, result, texts

X, Y = np.array([1.0, 2.0, 4.0]), np.array([0.5, 1.0])
VALUES = np.array([[-0.01, 0.0], [0.08, 0.02], [-0.005, np.nan]])
KINDS = np.array([[1, 0], [3, 4], [1, 5]])
FAILED = np.array([[0, 0], [0, 0], [0, int(Outcome.STRETCH_LIMIT)]])
FLAGS = np.array([[0, 1], [0, 1], [0, 1]])


def cells(**changed):
    each = ("voltage", "prestretch")
    values = {
        EXPONENT: ((*each, "exponent"), np.stack([VALUES, VALUES - 1.0], axis=-1)),
        "regime": (each, KINDS),
        "outcome": (each, FAILED),
        DOUBTFUL: (each, FLAGS),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    return result(values, {"voltage": ("voltage", X), "prestretch": ("prestretch", Y)})


def test_the_first_parameter_lies_along_x_and_the_largest_exponent_is_shown():
    axes = blank()
    mesh = exponent_map(cells(), axes)
    x, y, values = cells_of(mesh)
    np.testing.assert_array_equal(x, [0.5, 1.5, 3.0, 5.0])
    np.testing.assert_array_equal(y, [0.25, 0.75, 1.25])
    np.testing.assert_array_equal(values, VALUES.T)
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.5, 5.0), (0.25, 1.25))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("voltage", "prestretch")
    assert axes.get_title(loc="left") == "largest exponent (per unit time)"


def test_failed_cells_are_hatched_and_doubtful_ones_dotted():
    axes = blank()
    exponent_map(cells(), axes)
    (hatched,) = (c for c in axes.collections if isinstance(c, PolyCollection) and c.get_hatch())
    np.testing.assert_array_equal(corners(hatched), [[3.0, 5.0, 0.75, 1.25]])
    np.testing.assert_allclose(data_of(axes.lines[0]), [[1.0, 2.25], [1.0, 1.0]])


def test_a_regime_map_shows_codes_and_dots_only_where_the_colour_does_not_tell():
    axes = blank()
    regime_map(cells(), axes)
    np.testing.assert_array_equal(cells_of(axes.collections[0])[2], KINDS.T)
    assert KINDS[1, 1] == Regime.TRANSIENT
    np.testing.assert_allclose(data_of(axes.lines[0]), [[1.0], [1.0]])
    assert corners(axes.collections[1]).shape == (1, 4)


def test_marks_are_given_row_by_row():
    regime, failed, flagged = marks(cells())
    np.testing.assert_array_equal(regime, KINDS.T)
    np.testing.assert_array_equal(failed, FAILED.T > 0)
    np.testing.assert_array_equal(flagged, (FLAGS.T > 0) & ~(FAILED.T > 0))


def test_cells_that_were_not_computed_did_not_fail():
    _, failed, flagged = marks(cells(outcome=np.full((3, 2), -1), **{DOUBTFUL: np.full((3, 2), -1)}))
    assert not failed.any()
    assert not flagged.any()


def test_equal_exponents_of_both_signs_have_equal_depth_and_zero_is_neutral():
    axes = blank()
    mesh = exponent_map(cells(), axes)
    exponent_bar(mesh, axes, axes.figure)
    depth = {value: np.asarray(mesh.to_rgba([value]))[0, :3].min() for value in (0.0, 0.01, -0.01, 0.08)}
    assert (mesh.norm.vmin, mesh.norm.vmax) == (-0.08, 0.08)
    assert mesh.norm(0.0) == pytest.approx(0.5)
    assert mesh.norm(0.02) == pytest.approx(0.75)  # the root of a quarter is a half
    assert mesh.norm(0.02) + mesh.norm(-0.02) == pytest.approx(1.0)
    assert depth[0.0] > 0.95
    assert depth[-0.01] == pytest.approx(depth[0.01], abs=0.1)
    assert depth[0.08] < 0.2 < depth[-0.01] < 0.85
    red, _, blue = np.asarray(mesh.to_rgba([0.08]))[0, :3]
    assert red > blue
    bar = axes.figure.axes[1]
    np.testing.assert_allclose(bar.get_ylim(), (-0.01, 0.08))
    np.testing.assert_allclose(bar.get_yticks(), [-0.01, -0.005, 0.0, 0.005, 0.01, 0.02, 0.05])


def test_roots_and_squares_keep_the_sign():
    np.testing.assert_allclose(signed_root([-4.0, 0.0, 9.0]), [-2.0, 0.0, 3.0])
    np.testing.assert_allclose(signed_square([-2.0, 0.0, 3.0]), [-4.0, 0.0, 9.0])


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_map_without_any_exponent_has_a_bar_from_minus_one_to_one(value):
    axes = blank()
    mesh = exponent_map(cells(**{EXPONENT: np.full((3, 2, 2), value)}), axes)
    exponent_bar(mesh, axes, axes.figure)
    assert (mesh.norm.vmin, mesh.norm.vmax) == (-1.0, 1.0)
    assert axes.figure.axes[1].get_ylim() == (-1.0, 1.0)


def test_lines_are_drawn_over_both_panels_in_their_own_style():
    lines = {"onset": ([1.0, 4.0], [0.5, 1.0]), "pitchfork": ([2.0, 3.0], [0.5, 1.0])}
    axes = blank()
    overlay(lines, axes)
    np.testing.assert_array_equal(data_of(axes.lines[0]), lines["onset"])
    np.testing.assert_array_equal(data_of(axes.lines[1]), lines["pitchfork"])
    assert [line.get_linestyle() for line in axes.lines] == ["-", "--"]
    figure = map_figure(cells(), lines)
    for panel in (axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.collections):
        assert [line.get_label() for line in panel.lines[-2:]] == ["onset", "pitchfork"]
    legend = [text.get_text() for text in figure.axes[1].get_legend().get_texts()]
    assert legend == [
        "rest",
        "periodic",
        "chaotic",
        "transient",
        "run failed",
        "evidence disagrees",
        "onset",
        "pitchfork",
    ]
    assert figure.axes[1].get_ylabel() == ""


@pytest.mark.parametrize("dims", [1, 3])
def test_a_map_of_other_than_two_parameters_is_refused(dims):
    data = cells().isel(voltage=0) if dims == 1 else cells().expand_dims(zeta=2)
    with pytest.raises(InputError, match=rf"two parameters, not {dims}; draw one with bifurcation_figure"):
        map_figure(data)


def test_a_computed_map_is_drawn_with_failed_cells_in_si_and_where_all_failed(tmp_path):
    model = ConeModel(damping_ratio=0.3, stretch_limit=5.0)
    over = {"voltage": [0.5, 1.0], "prestretch": [0.7, 1.0, 2.8]}
    found = gelcone.map(model, over, transient=60.0, budget=100.0)
    figure = map_figure(found)
    save_figure(figure, tmp_path / "map.png")
    hatched = [
        c for axes in figure.axes[:2] for c in axes.collections if isinstance(c, PolyCollection) and c.get_hatch()
    ]
    assert [len(c.get_paths()) for c in hatched] == [2, 2]
    assert "per second" in texts(map_figure(to_si(found, find_device("soft-film"))))
    lost = found.copy(deep=True)
    lost["outcome"][:], lost[EXPONENT][:] = Outcome.STEP_LIMIT, np.nan
    assert "run failed" in texts(map_figure(lost))


def test_cells_that_are_not_computed_yet_are_in_the_legend():
    data = cells()
    for first, shown in ((0, True), (1, False)):
        status = np.ones(data["regime"].shape, dtype=int)
        status[0, 0] = first
        figure = map_figure(data.assign(status=(data["regime"].dims, status)))
        words = [text.get_text() for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()]
        assert ("not computed yet" in words) == shown


def test_a_map_may_show_the_stroke():
    data = cells()
    data = data.assign(highest=0.0 * data["regime"] + 3.0, lowest=0.0 * data["regime"] - 1.0)
    for name in ("highest", "lowest"):
        data[name].attrs.update(units="mm", long_name=name)
    mesh = map_figure(data, colour="stroke").axes[0].collections[0]
    assert set(np.ravel(mesh.get_array())) == {4.0}
    with pytest.raises(InputError, match="'size' is not a colour"):
        map_figure(data, colour="size")


def test_a_map_shows_a_margin_in_two_colours_and_a_power_by_its_root():
    data = cells()
    for name, quantity, least in (("margin", "share", -0.4), ("power", "power", 0.0), ("power", "power", -0.4)):
        values = 0.0 * data["regime"] + np.linspace(least, 0.8, data["regime"].size).reshape(data["regime"].shape)
        shown = data.assign({name: values.assign_attrs(units="mW", quantity=quantity, long_name=name)})
        mesh = map_figure(shown, colour=name).axes[0].collections[0]
        assert sorted(np.ravel(mesh.get_array())) == pytest.approx(np.linspace(least, 0.8, values.size))
        assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((-0.8 if least else 0.0, 0.8))
        assert mesh.norm(0.2) == pytest.approx(0.625 if least else 0.5)
    with pytest.raises(InputError, match="the map does not hold it"):
        map_figure(data, colour="power")


@pytest.mark.parametrize("largest", [0.1, 0.9, -0.2])
def test_the_colours_of_exponents_reach_to_the_largest_of_either_sign(largest):
    data = cells()
    values = np.linspace(-0.5, largest, data[EXPONENT].size).reshape(data[EXPONENT].shape)
    mesh = exponent_map(data.assign({EXPONENT: (data[EXPONENT].dims, values, data[EXPONENT].attrs)}), blank())
    most = np.abs(values[..., 0]).max()
    assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((-most, most))
