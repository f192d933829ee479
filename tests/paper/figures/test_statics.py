"""Figures 3 and 6 on made-up studies: stable and unstable, taut and slack, continuum and energies."""

import json

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from gelcone.continuum.path import Ending
from gelcone.paper.effort import QUICK
from gelcone.paper.figures.statics import (
    continuum_markers,
    equilibria_over_voltage,
    film_energies,
    force_figure,
    force_over_displacement,
    surfaces,
)
from gelcone.paper.studies import STUDIES
from gelcone.paper.studies.continuum import MISSING
from gelcone.plots.style import BLUE, CYCLE, VERMILION
from tests.plots.made_up import data_of, line

X = np.linspace(-1.0, 1.0, 5)


def static():
    """The real study, which takes no time."""
    return STUDIES["static"].compute(QUICK, lambda share: None)


def test_force_is_solid_where_the_film_is_taut_and_dashed_where_it_is_slack():
    axes, study = Figure().add_subplot(), static()
    force_over_displacement(study, axes)
    drawn = [one for one in axes.lines if len(one.get_xdata()) == study.sizes["displacement"]]
    for k in range(3):
        own = study.isel(constant_voltage=k)
        taut = own["slack"].values == 0
        solid, dashed = drawn[2 * k : 2 * k + 2]
        x, force = own["displacement"].values, own["force"].values
        np.testing.assert_array_equal(data_of(solid), [x[taut], force[taut]])
        np.testing.assert_array_equal(data_of(dashed), [x[~taut], force[~taut]])
        assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")
        assert solid.get_color() == dashed.get_color() == CYCLE[k]


def test_equilibria_are_filled_where_stable():
    axes, study = Figure().add_subplot(), static()
    force_over_displacement(study, axes)
    marks = [one for one in axes.lines if one.get_marker() == "o" and not one.get_label().endswith("equilibrium")]
    filled, empty = marks[4:6]
    at = study.isel(constant_voltage=2)
    x, stable = at["equilibrium_displacement"].values, at["stable"].values
    np.testing.assert_array_equal(data_of(filled), [x[stable], [0.0, 0.0]])
    np.testing.assert_array_equal(data_of(empty), [[0.0], [0.0]])
    assert to_rgb(filled.get_markerfacecolor()) == to_rgb(CYCLE[2])
    assert to_rgb(empty.get_markerfacecolor()) == (1.0, 1.0, 1.0)


def test_branches_are_solid_where_stable_and_the_voltages_are_marked():
    axes, study = Figure().add_subplot(), static()
    equilibria_over_voltage(study, axes)
    voltage, x, slope = (study[f"branch_{name}"].values for name in ("voltage", "displacement", "slope"))
    for label, kept, colour in (("stable", slope >= 0.0, BLUE), ("unstable", slope <= 0.0, VERMILION)):
        np.testing.assert_array_equal(data_of(line(axes, label)), [voltage[kept], x[kept]])
        assert line(axes, label).get_color() == colour
    assert line(axes, "unstable").get_linestyle() == "--"
    assert [one.get_xdata()[0] for one in axes.lines[2:]] == study["constant_voltage"].values.tolist()
    (note,) = axes.texts
    assert note.xy == (float(study["pitchfork_voltage"]), 0.0)
    assert "1.225" in note.get_text()
    assert axes.get_xlim() == (-0.05, np.nanmax(voltage))


def continuum():
    at = ("member", "constant_voltage", "displacement")
    force = np.array([[[1.0, 2.0], [3.0, 4.0]], [[50.0, 60.0], [70.0, 80.0]]])
    ending = np.full((2, 2, 2), int(Ending.CONVERGED))
    ending[0, 1] = [int(Ending.COMPRESSED), int(Ending.TENSION_LOST)]
    folds = np.zeros((2, 2, 2), dtype=int)
    folds[0, 0, 1] = 2
    return xr.Dataset(
        {"continuum_force": (at, force), "ending": (at, ending), "folds": (at, folds)},
        coords={"constant_voltage": [0.0, 1.0], "displacement": [0.5, 1.0]},
    )


def test_the_continuum_of_the_papers_ratio_is_mirrored_and_carries_the_spring():
    axes, study = Figure().add_subplot(), static()
    spring = json.loads(study.attrs["model"])["spring_stiffness"]
    continuum_markers(continuum(), study, axes)
    taut, taut_mirrored, pressed, _, _, _, second, mirrored = axes.lines[:8]
    np.testing.assert_allclose(data_of(taut), [[0.5], [1.0 + 0.5 * spring]])
    np.testing.assert_allclose(data_of(taut_mirrored), [[-0.5], [-1.0 - 0.5 * spring]])
    assert data_of(pressed).size == 0
    np.testing.assert_allclose(data_of(second), [[0.5], [3.0 + 0.5 * spring]])
    np.testing.assert_allclose(data_of(mirrored), [[-0.5], [-3.0 - 0.5 * spring]])
    assert to_rgb(second.get_markerfacecolor()) == (1.0, 1.0, 1.0)
    assert to_rgb(taut.get_markerfacecolor()) == to_rgb(CYCLE[0])
    nothing = Figure().add_subplot()
    continuum_markers(xr.Dataset(attrs={MISSING: "no elements"}), study, nothing)
    assert not nothing.lines


def test_the_figure_has_the_forces_with_their_continuum_on_the_left_and_the_equilibria_on_the_right():
    left, right = force_figure({"static": static(), "continuum": continuum()}).axes
    only = Figure().add_subplot()
    force_over_displacement(static(), only)
    assert len(left.lines) > len(only.lines)
    assert [one.get_label() for one in right.lines[:2]] == ["stable", "unstable"]


def energies():
    force = np.array([[3.0, 1.0, 0.0, 1.0, 3.0], [2.0, 0.5, 0.0, 0.5, 2.0]])
    x, u = np.linspace(-2.0, 2.0, 41), np.linspace(-3.0, 3.0, 31)
    surface = np.stack([x[:, None] ** 2 + 0.5 * u**2] * 2)
    surface[0, np.abs(x) > 1.5] = np.nan
    return xr.Dataset(
        {
            "film_energy": (("stretch_limit", "displacement"), force),
            "reach": ("stretch_limit", [0.7, 5.0]),
            "surface_energy": (("surface_limit", "surface_displacement", "surface_velocity"), surface),
        },
        coords={
            "stretch_limit": [1.0, 100.0],
            "displacement": X,
            "surface_limit": [1.0, 100.0],
            "surface_displacement": x,
            "surface_velocity": u,
        },
    )


def test_energies_stand_over_the_displacement_with_the_ends_of_the_film_on_both_sides():
    axes = Figure().add_subplot()
    film_energies(energies(), axes)
    for k, limit in enumerate((1.0, 100.0)):
        curve, left, right = axes.lines[3 * k : 3 * k + 3]
        np.testing.assert_array_equal(data_of(curve), [X, energies()["film_energy"].values[k]])
        reach = float(energies()["reach"][k])
        assert (left.get_xdata()[0], right.get_xdata()[0]) == (-reach, reach)
        assert curve.get_label() == f"$J$ = {limit:g}"
        assert left.get_linestyle() == ":"
    assert (axes.get_xlim(), axes.get_ylim()) == ((-1.0, 1.0), (-0.1, 4.0))


def test_the_free_motion_from_the_start_is_the_level_line_through_it():
    figure = Figure(layout="constrained")
    surfaces(energies(), figure)
    panels = figure.axes[:2]
    for axes in panels:
        free = axes.collections[2]
        points = np.concatenate([path.vertices for path in free.get_paths()])
        # x^2 + 0.5 u^2 = 1, an ellipse
        np.testing.assert_allclose(np.hypot(points[:, 0], np.sqrt(0.5) * points[:, 1]), 1.0, atol=0.01)
        np.testing.assert_array_equal(data_of(axes.lines[0]), [[1.0], [0.0]])
        assert (axes.collections[0].levels[0], axes.collections[0].levels[-1]) == (0.0, 6.0)
    assert [bool(axes.texts) for axes in panels] == [True, False]
    assert [axes.get_title(loc="left") for axes in panels] == ["$J$ = 1", "$J$ = 100"]
