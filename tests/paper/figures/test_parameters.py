"""Figures 13 and 14 on made-up studies: sections, exponents and maps stand at their parameters."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from gelcone.codes import Regime
from gelcone.paper.figures import FIGURES, parameters
from gelcone.paper.figures.parameters import _exponent_map, _exponents, _sections, _stack
from gelcone.paper.studies.diagrams import PANELS, diagram_name
from tests.paper.made_up import cells, diagram
from tests.plots.made_up import cells_of, data_of, line, texts

VALUES = np.array([0.5, 1.0, 2.0])
POINTS = np.arange(3 * 40, dtype=float).reshape(3, 40)


def panel(parameter="voltage"):
    data = diagram(parameter, VALUES, [0, 1, 1], exponent=[-0.2, 0.01, 0.05], finite=[0.1, 0.2, 0.3], error=0.004)
    section = np.stack([np.stack([POINTS + 1000.0 * k, -POINTS], axis=-1) for k in range(2)])
    data["section"] = (("branch", parameter, "point", "state"), section)
    data["rest_growth"] = (parameter, [-1.0, 1.0, 1.0])
    data["static_stiffness"] = (parameter, [1.0, 0.5, -0.5])
    return data


def plane():
    over = {"voltage": VALUES, "prestretch": np.array([0.6, 1.0])}
    values = np.array([[-0.1, -0.2], [0.1, 0.2], [0.3, 0.4]])
    kinds = np.full((3, 2), int(Regime.CHAOTIC))
    kinds[2, 1] = int(Regime.LEFT_THE_DOMAIN)
    growth = VALUES[:, None] - np.array([1.2, 1.6])
    data = cells(
        over,
        np.ones((3, 2)),
        exponent=values,
        finite=values + 1.0,
        kinds=kinds,
        rest_growth=growth,
        static_stiffness=np.ones((3, 2)),
    )
    section = POINTS[:, :, None, None] + np.array([0.0, 0.5])[None, None, :, None] + np.zeros(2)
    data["section"] = (("voltage", "point", "stacked_prestretch", "state"), section)
    return data.assign_coords(stacked_prestretch=[0.6, 1.0]).assign_attrs(window=500.0)


def test_the_last_32_points_of_each_branch_stand_over_the_parameter():
    axes = Figure().add_subplot()
    _sections(panel(), "voltage", axes)
    fixed, up = line(axes, "from the fixed state"), line(axes, "swept up")
    np.testing.assert_array_equal(data_of(fixed), [np.repeat(VALUES, 32), 1000.0 + POINTS[:, 8:].ravel()])
    np.testing.assert_array_equal(data_of(up), [np.repeat(VALUES, 32), POINTS[:, 8:].ravel()])
    assert not [one for one in axes.lines if one.get_label() == "down"]


def test_rest_is_shaded_where_theory_has_it_unstable():
    axes = Figure().add_subplot()
    _sections(panel(), "voltage", axes)
    drive, static = axes.collections
    assert "Floquet" in drive.get_label()
    x = np.concatenate([path.vertices[:, 0] for path in drive.get_paths()])
    assert (x.min(), x.max()) == (1.0, 2.0)
    assert "static pitchfork" in static.get_label()
    x = np.concatenate([path.vertices[:, 0] for path in static.get_paths()])
    assert (x.min(), x.max()) == (2.0, 2.0)


def test_exponents_of_the_long_run_and_the_window_with_three_errors():
    axes = Figure().add_subplot()
    _exponents(panel(), "voltage", axes)
    np.testing.assert_array_equal(data_of(line(axes, "over the window from the start")), [VALUES, [0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(
        data_of(line(axes, "in the long run, with 3 standard errors")), [VALUES, [-0.2, 0.01, 0.05]]
    )
    y = axes.collections[0].get_paths()[0].vertices
    for value, exponent in zip(VALUES, (-0.2, 0.01, 0.05), strict=True):
        own = y[y[:, 0] == value, 1]
        np.testing.assert_allclose((own.min(), own.max()), (exponent - 0.012, exponent + 0.012))
    # not below -0.12 however negative, and never less than 0.02 to either side
    np.testing.assert_allclose(axes.get_ylim(), (-1.15 * 0.12, 1.25 * 0.062))
    quiet = panel()
    quiet["lyapunov"][:] = -0.001
    other = Figure().add_subplot()
    _exponents(quiet, "voltage", other)
    np.testing.assert_allclose(other.get_ylim(), (-0.023, 0.025))


def test_figure_13_has_a_pair_of_panels_for_each_set_and_parameter():
    studies = {diagram_name(*which): panel(which[1]) for which in PANELS}
    studies["diagram-fast-voltage"]["lyapunov"][:] += 7.0
    figure = FIGURES[13].draw(studies)
    assert len(figure.axes) == 16
    grid = np.array(figure.axes).reshape(4, 4)
    assert [axes.get_title() for axes in grid[0]] == [
        "set base, v = 0.5",
        "set base",
        "set base, v = 1",
        "set base, v = 1.04",
    ]
    assert [axes.get_title() for axes in grid[2]] == [
        "set fast, v = 1.005",
        "set fast",
        "set fast, v = 1.005",
        "set fast, v = 1.005",
    ]
    assert [axes.get_xscale() for axes in grid[3]] == ["linear"] * 3 + ["log"]
    assert [bool(axes.get_xlabel()) for axes in grid.ravel()] == [False] * 12 + [True] * 4
    assert grid[3, 1].get_ylim()[1] > 7.0 > grid[1, 1].get_ylim()[1]
    assert [axes.get_ylabel() for axes in grid[:, 0]] == ["section $x$", "largest\nexponent"] * 2
    assert "swept up" in texts(figure)


def test_a_map_has_voltage_along_x_and_hatches_what_left_the_domain():
    axes = Figure().add_subplot()
    image = _exponent_map(plane().transpose("prestretch", "voltage", ...), "lyapunov", 0.12, axes)
    x, y, values = cells_of(image)
    assert (len(x), len(y)) == (4, 3)
    np.testing.assert_allclose(values, [[-0.1, 0.1, 0.3], [-0.2, 0.2, 0.4]])
    assert image.get_clim() == (-0.12, 0.12)
    hatched, border = axes.collections[1:]
    assert hatched.hatches == ["////"]
    # rest is lost at v = 1.2 without, at 1.6 with pre-stretch; the stiffness has one sign and no line
    np.testing.assert_allclose(sorted(border.get_paths()[0].vertices[[0, -1], 0]), [1.2, 1.6], atol=1e-9)
    assert len(axes.collections) == 3
    assert [one.get_linestyle() for one in axes.lines] == ["-", "--"]


def test_a_map_in_which_nothing_left_the_domain_has_no_hatching():
    axes, data = Figure().add_subplot(), plane().transpose("prestretch", "voltage", ...)
    data["regime"][:] = int(Regime.REST)
    _exponent_map(data, "lyapunov", 0.12, axes)
    assert len(axes.collections) == 2


def test_sections_are_stacked_ten_apart():
    axes = Figure().add_subplot()
    _stack(plane(), axes)
    for k, offset in enumerate((0.0, 10.5)):
        np.testing.assert_allclose(
            data_of(axes.lines[2 * k]), [np.repeat(VALUES, 32), (POINTS[:, 8:] + offset).ravel()]
        )
        assert axes.lines[2 * k + 1].get_ydata() == [10.0 * k, 10.0 * k]
    np.testing.assert_array_equal(axes.get_yticks(), [0.0, 10.0])
    assert [text.get_text() for text in axes.get_yticklabels()] == ["0.6", "1"]


def test_figure_14_shows_both_meanings_the_long_run_above_the_window():
    radial, equibiaxial = plane(), plane()
    equibiaxial["lyapunov"][:] += 5.0
    figure = FIGURES[14].draw({"map-radial": radial, "map-equibiaxial": equibiaxial})
    grid = np.array(figure.axes[:6]).reshape(3, 2)
    assert [axes.get_title() for axes in grid[0]] == ["radial pre-stretch", "equi-biaxial pre-stretch"]
    assert [axes.get_title() for axes in grid[1:, 0]] == [
        "largest exponent in the long run",
        "largest exponent over the first 500 time units",
    ]
    for (row, column), shift in {(1, 0): 0.0, (1, 1): 5.0, (2, 0): 1.0, (2, 1): 1.0}.items():
        assert cells_of(grid[row, column].collections[0])[2][0, 0] == pytest.approx(shift - 0.1)
    assert isinstance(radial, xr.Dataset)


def test_events_of_orbits_of_up_to_the_longest_period_shown_are_ticked(monkeypatch):
    monkeypatch.setattr(parameters, "sections_of", lambda own: np.zeros((2, 1)))
    short = parameters.SHORT
    followed = xr.Dataset(
        {
            "period": ("branch", [1, short, short + 1]),
            "value": (("branch", "point"), [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]),
            "stable": (("branch", "point"), np.ones((3, 2), int)),
            "event_branch": ("event", [2, 0, 1, 1]),
            "event_value": ("event", [0.55, 0.15, 0.31, 0.39]),
        }
    )
    axes = Figure().subplots()
    parameters._branches(followed, axes)
    ticks = [line for line in axes.lines if line.get_marker() == "|"]
    assert [line.get_xdata().tolist() for line in ticks] == [[0.15, 0.31, 0.39]]
    drawn = {tuple(line.get_xdata()) for line in axes.lines if line.get_marker() != "|"}
    assert drawn == {(0.1, 0.2), (0.3, 0.4)}
