"""Figures of sweeps: probabilities with their band, cells of two parameters, curves and clouds."""

import numpy as np
import pytest
import xarray as xr

from gelcone import InputError, Uniform, draw
from gelcone.plots.map import map_figure
from gelcone.plots.style import BLUE
from gelcone.plots.sweep import WIDEST, probability_figure, sweep_figure
from tests.plots.made_up import cells_of, data_of, line, result
from tests.plots.test_map import cells

X, Y = np.array([0.0, 1.0, 2.0]), np.array([10.0, 20.0])


def probability(shape=("voltage",), **coords):
    low, share, high = np.array([0.0, 0.2, 0.7]), np.array([0.1, 0.5, 0.9]), np.array([0.3, 0.6, 1.0])
    if len(shape) == 2:
        low, share, high = (np.stack([v, 0.5 * v], axis=1) for v in (low, share, high))
    data = result(
        {"low": (shape, low), "probability": (shape, share), "high": (shape, high)},
        {"voltage": ("voltage", X)} | ({"damping_ratio": ("damping_ratio", Y)} if len(shape) == 2 else {}) | coords,
    )
    data["probability"].attrs["long_name"] = "probability of chaos"
    return data


def test_a_probability_lies_in_the_band_of_its_interval():
    figure = probability_figure(probability())
    (axes,) = figure.axes
    np.testing.assert_array_equal(data_of(line(axes, "share of the draws")), [X, [0.1, 0.5, 0.9]])
    (band,) = axes.collections
    x, y = band.get_paths()[0].vertices.T
    for at, low, high in zip(X, [0.0, 0.2, 0.7], [0.3, 0.6, 1.0], strict=True):
        assert set(y[x == at]) == {low, high}
    assert band.get_label() == "interval"
    low, high = axes.get_ylim()
    assert low < 0.0
    assert 1.0 < high < 1.1
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("voltage", "probability of chaos")


def test_a_probability_over_two_parameters_stands_beside_the_width_of_its_interval():
    figure = probability_figure(probability(("voltage", "damping_ratio")))
    left, right = figure.axes[:2]
    x, y, share = cells_of(left.collections[0])
    np.testing.assert_array_equal(x, [-0.5, 0.5, 1.5, 2.5])
    np.testing.assert_array_equal(y, [5.0, 15.0, 25.0])
    np.testing.assert_allclose(share, [[0.1, 0.5, 0.9], [0.05, 0.25, 0.45]])
    np.testing.assert_allclose(cells_of(right.collections[0])[2], [[0.3, 0.4, 0.3], [0.15, 0.2, 0.15]])
    assert left.collections[0].get_clim() == (0.0, 1.0)
    assert right.collections[0].get_clim() == pytest.approx((0.15, 0.4))
    assert (left.get_xlabel(), left.get_ylabel(), right.get_ylabel()) == ("voltage", "damping ratio", "")
    assert right.get_title(loc="left") == "width of the interval"


def test_cells_in_si_stand_at_the_si_values():
    data = probability(("voltage", "damping_ratio"))
    data = data.assign_coords(voltage=("voltage", 100.0 * X, data["voltage"].attrs | {"units": "V"}))
    left = probability_figure(data).axes[0]
    np.testing.assert_array_equal(cells_of(left.collections[0])[0], [-50.0, 50.0, 150.0, 250.0])
    assert left.get_xlabel() == "voltage (V)"


def test_a_probability_of_three_parameters_is_refused():
    three = probability(("voltage", "damping_ratio")).expand_dims(prestretch=[1.0])
    with pytest.raises(InputError, match="over one parameter or two; take a slice of the others"):
        probability_figure(three)


def swept(dims, shape, coords, **more):
    rng = np.random.default_rng(0)
    values = {"stroke": (dims, rng.random(shape)), "peak": (dims, rng.random(shape))} | more
    status = np.ones(shape, dtype=int)
    status.flat[0] = 0
    book = dict.fromkeys(("status", "source", "outcome"), (dims, status))
    return result(values | book, coords, {"stroke": "mm"})


def test_a_sweep_over_one_parameter_is_a_curve_for_each_variable_without_what_was_not_computed():
    data = swept(("voltage",), (3,), {"voltage": ("voltage", X)}, lost=("voltage", np.full(3, np.nan)))
    figure = sweep_figure(data)
    assert [axes.get_ylabel() for axes in figure.axes] == ["stroke (mm)", "peak"]
    for axes, name in zip(figure.axes, ("stroke", "peak"), strict=True):
        (curve,) = axes.lines
        np.testing.assert_array_equal(data_of(curve), [X[1:], data[name].values[1:]])
        assert (curve.get_linestyle(), curve.get_color()) == ("-", BLUE)
    assert figure.axes[-1].get_xlabel() == "voltage"


def test_draws_are_a_cloud_over_the_first_parameter():
    data = swept(("voltage", "draw"), (3, 4), {"voltage": ("voltage", X)})
    stroke = sweep_figure(data).axes[0]
    assert len(stroke.lines) == 4
    assert {one.get_linestyle() for one in stroke.lines} == {"None"}
    for k, one in enumerate(stroke.lines):
        x, y = data_of(one)
        np.testing.assert_array_equal(x, X[1:] if k == 0 else X)
        np.testing.assert_array_equal(y, data["stroke"].values[-x.size :, k])


def test_draws_alone_are_ticks_of_a_density():
    study = swept(("draw",), (5,), {})
    axes = sweep_figure(study).axes[0]
    places, heights = data_of(axes.lines[0])
    assert (np.asarray(heights) == 0.0).all()
    assert axes.lines[0].get_linestyle() == "None"
    assert len(places) == 4


def test_draws_that_serve_sobol_indices_alone_are_not_in_the_density():
    """Of four blocks of 32 the first two are independent of one another."""
    draws = draw({"a": Uniform(0.0, 1.0), "b": Uniform(0.0, 1.0)}, 64, indices=True)
    assert len(draws["a"]) == 128
    for drawn, count in ((draws, 63), ({"a": draws["a"]}, 127)):
        data = swept(("draw",), (128,), {f"drawn_{name}": ("draw", values) for name, values in drawn.items()})
        for axes, name in zip(sweep_figure(data).axes, ("stroke", "peak"), strict=True):
            np.testing.assert_array_equal(axes.lines[0].get_xdata(), data[name].values[1 : count + 1])


def test_a_sweep_over_two_parameters_is_a_map_for_each_variable():
    data = swept(
        ("voltage", "damping_ratio"), (3, 2), {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y)}
    )
    extra = data["stroke"].rename("third")
    figure = sweep_figure(data.assign(third=extra))
    meshes = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    assert len(meshes) == 3
    for axes, name in zip(meshes, ("stroke", "peak", "third"), strict=True):
        x, y, values = cells_of(axes.collections[0])
        np.testing.assert_array_equal(x, [-0.5, 0.5, 1.5, 2.5])
        np.testing.assert_array_equal(y, [5.0, 15.0, 25.0])
        expected = data["stroke" if name == "third" else name].values.T.copy()
        expected[0, 0] = np.nan
        np.testing.assert_array_equal(values, expected)
    assert [axes.get_title(loc="left") for axes in meshes] == ["stroke (mm)", "peak", "third (mm)"]


def test_no_more_than_six_variables_are_drawn():
    more = {f"v{k}": ("voltage", X + k) for k in range(8)}
    figure = sweep_figure(swept(("voltage",), (3,), {"voltage": ("voltage", X)}, **more))
    assert len(figure.axes) == WIDEST == 6


def test_few_values_have_a_tick_each_on_the_bar_and_many_do_not():
    over = {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y)}
    dims = ("voltage", "damping_ratio")
    data = swept(dims, (3, 2), over, period=(dims, [[1, 1], [2, 2], [4, 4]]))
    figure = sweep_figure(data)
    bars = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
    assert bars[2].get_yticks().tolist() == [1.0, 2.0, 4.0]
    wide = np.linspace(0.0, 1.0, 9)
    many = swept(dims, (9, 2), over | {"voltage": ("voltage", wide)})
    bar = next(axes for axes in sweep_figure(many).axes if axes.get_label() == "<colorbar>")
    assert len(bar.get_yticks()) < 17


def test_few_numbers_that_are_not_whole_have_no_ticks_of_their_own():
    """They may be close to one another."""
    dims, over = ("voltage", "damping_ratio"), {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y)}
    data = swept(dims, (3, 2), over, close=(dims, [[12.8, 3.5], [12.81, 3.51], [12.82, 3.52]]))
    axes = sweep_figure(data).axes
    titles = [own.get_title(loc="left") for own in axes if own.get_label() != "<colorbar>"]
    bar = [own for own in axes if own.get_label() == "<colorbar>"][titles.index("close")]
    assert 12.81 not in bar.get_yticks()
    assert not {4.0, 13.0} >= set(bar.get_yticks())


def test_each_gel_has_a_line_of_its_own():
    gels = ["PVC-DBA 4:1", "PVC-DBA 6:1"]
    data = swept(("material", "frequency"), (2, 3), {"material": ("material", gels), "frequency": ("frequency", X)})
    stroke, _ = sweep_figure(data).axes
    for name, values in zip(gels, data["stroke"].values, strict=True):
        x, y = data_of(line(stroke, name))
        np.testing.assert_array_equal(x, X[-x.size :])
        np.testing.assert_array_equal(y, values[-x.size :])


def test_over_three_parameters_each_panel_is_the_slice_that_its_title_names():
    coords = {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y), "mass": ("mass", [1.0, 2.0])}
    data = swept(("voltage", "damping_ratio", "mass"), (3, 2, 2), coords)
    panels = [axes for axes in sweep_figure(data).axes if axes.get_label() != "<colorbar>"]
    assert [axes.get_title(loc="left") for axes in panels] == ["mass 1", "mass 2"]
    for k, axes in enumerate(panels):
        values = cells_of(axes.collections[0])[2]
        known = np.isfinite(values)
        assert known.sum() >= 5
        np.testing.assert_array_equal(values[known], data["stroke"].values[:, :, k].T[known])


def test_of_many_values_of_a_third_parameter_some_are_drawn_and_the_title_says_how_many():
    for count, said in ((3, "pump"), (9, "pump, 6 of 9 values of mass")):
        coords = {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y), "mass": ("mass", np.arange(count))}
        data = swept(("voltage", "damping_ratio", "mass"), (3, 2, count), coords).assign_attrs(device="pump")
        figure = sweep_figure(data)
        panels = [axes.get_title(loc="left") for axes in figure.axes if axes.get_label() != "<colorbar>"]
        assert len(panels) == min(count, 6)
        assert (panels[0], panels[-1]) == ("mass 0", f"mass {count - 1}")
        assert figure.get_suptitle() == said


def test_a_map_says_where_no_value_is_and_which_cells_failed():
    """What failed is hatched and named; white is a cell without a value that did not fail."""
    coords = {"voltage": ("voltage", X), "damping_ratio": ("damping_ratio", Y)}
    data = swept(("voltage", "damping_ratio"), (3, 2), coords)
    data["status"][:] = 1
    data["outcome"][:] = 0

    def named():
        return [text.get_text() for legend in sweep_figure(data).legends for text in legend.get_texts()]

    assert named() == []
    data["stroke"][0, 0] = np.nan
    assert named() == ["white: no value"]
    data["outcome"][0, 0] = 1
    (failed,) = named()
    assert "failed" in failed
    data["peak"][2, 1] = np.nan
    assert set(named()) == {failed, "white: no value"}


def test_maps_of_regimes_over_three_parameters_are_those_of_their_slices():
    """Panels, and the legend, which names what is drawn in any of them and nothing else."""
    own = [cells(), cells(regime=np.zeros((3, 2), int), doubtful=np.array([[0, 0], [0, 0], [0, 1]]))]
    both = xr.concat(own, "mass").transpose("voltage", "prestretch", "mass", ...).assign_coords(mass=[1.0, 2.0])
    both["status"] = both["outcome"] * 0 + 1
    drawn = sweep_figure(both)
    named = []
    for k, one in enumerate(own):
        figure = map_figure(one)
        alone = figure.axes[1]
        for mine, right in zip(drawn.axes[k].collections, alone.collections, strict=True):
            np.testing.assert_array_equal(*(np.ma.filled(c.get_array(), -1) for c in (mine, right)))
        np.testing.assert_array_equal(data_of(drawn.axes[k].lines[0]), data_of(alone.lines[0]))
        named += [text.get_text() for text in alone.get_legend().get_texts()]
        legend = sweep_figure(both.isel(mass=[k])).legends[0]
        assert [text.get_text() for text in legend.get_texts()] == named[len(named) - len(legend.get_texts()) :]
    assert {text.get_text() for text in drawn.legends[0].get_texts()} == set(named)


def test_codes_are_not_drawn_as_numbers_and_nothing_but_codes_says_so():
    """Of the limits over one parameter the voltages, not how the disc pulls in."""
    data = result({"status": ("voltage", [1, 1, 1]), "kind": ("voltage", [0, 1, 2]), "limit": ("voltage", X + 5.0)},
                  {"voltage": ("voltage", X)})  # fmt: skip
    for name, quantity in (("kind", "flag"), ("limit", "voltage")):
        data[name].attrs["quantity"] = quantity
    assert [axes.get_ylabel() for axes in sweep_figure(data).axes] == ["limit"]
    (axes,) = sweep_figure(data.drop_vars("limit")).axes
    assert [text.get_text() for text in axes.texts] == ["no cell has a number"]


@pytest.mark.parametrize(("along", "of"), [("draw", "draws"), ("voltage", "cells")])
def test_limits_that_no_cell_reaches_are_said_and_counted(along, of):
    """And those that some draws do not reach, over the density of the others; only computed cells count."""
    data = result({"status": (along, [1, 1, 1, 0]), "pull_in_voltage": (along, [np.inf, np.inf, np.nan, 7.0])}, {})
    data["pull_in_voltage"].attrs.update(units="V", infinite_means="not reached", nan_means="not applicable")
    (axes,) = sweep_figure(data).axes
    words = f"not reached in 2 of 3 {of}, not applicable in 1 of 3 {of}"
    assert [text.get_text() for text in axes.texts] == [f"pull in voltage: {words}"]
    assert not axes.axison
    if along == "draw":
        data["pull_in_voltage"].values[1] = 5.0
        (axes,) = sweep_figure(data).axes
        assert axes.get_title(loc="left") == "not reached in 1 of 3 draws, not applicable in 1 of 3 draws"
        assert axes.get_xlabel() == "pull in voltage (V)"
        data["pull_in_voltage"].values[:3] = [5.0, 6.0, 7.0]
        assert sweep_figure(data).axes[0].get_title(loc="left") == ""
