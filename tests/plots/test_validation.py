"""Figures of the cone and the continuum: taut, slack and pulled in, profiles and stretches of both."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from gelcone.continuum.path import Ending
from gelcone.plots.style import CYCLE
from gelcone.plots.validation import (
    force_curves,
    limit_forces,
    profiles,
    shapes,
    stretch_curves,
    validation_figure,
)
from gelcone.words import members_of
from tests.plots.made_up import blank, data_of, line, parameter, result, texts

X, V = np.array([0.0, 0.5, 1.0, 1.5]), np.array([0.0, 1.0])
ROUND = np.array([0.25, 0.75, 1.25])
CONE = np.array([[0.0, 1.0, 2.0, 3.0], [0.0, -0.5, -0.2, 0.4]])
CONTINUUM = np.array([[0.0, 0.9, 1.8, 2.7], [0.0, -0.4, 30.0, np.nan]])


def film(members=None, **changed):
    at = ("constant_voltage", "displacement")
    each = (*at, "ring")
    ring = np.broadcast_to(ROUND, (2, 4, 3)) * (1.0 + 0.1 * X[None, :, None])
    values = {
        "cone_force": (at, CONE),
        "continuum_force": (at, CONTINUUM),
        "hoop_slack": (at, [[False] * 4, [False, True, False, False]]),
        "meridional_slack": (at, [[False, False, True, False], [False] * 4]),
        "folds": (at, [[0, 0, 0, 0], [0, 0, 2, 0]]),
        "ending": (at, [[int(Ending.CONVERGED)] * 4, [int(Ending.CONVERGED)] * 3 + [int(Ending.PULLED_IN)]]),
        "radius": (each, ring),
        "height": (each, np.broadcast_to(X[None, :, None] * np.array([1.0, 0.4, 0.0]), (2, 4, 3))),
        "meridional_stretch": (each, ring + 1.0),
        "hoop_stretch": (each, ring + 2.0),
        "mounted_radius": ("ring", ROUND),
        "cone_stretch": ("displacement", np.sqrt(1.0 + X**2)),
        "outcome": ((), 0),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    coords = {"constant_voltage": ("constant_voltage", V), "displacement": ("displacement", X)}
    if members:
        over = {n: v for n, v in values.items() if n != "mounted_radius"}
        values |= {
            n: (("member", *(d if isinstance(d, tuple) else (d,))), np.stack([np.asarray(v)] * members))
            for n, (d, v) in over.items()
        }
        coords |= {
            "radius_ratio": ("member", np.linspace(0.1, 0.5, members)),
            "prestretch": ("member", np.full(members, 1.2)),
            "stretch_limit": ("member", 10.0 * np.arange(1, members + 1)),
            "note": ("member", np.arange(members)),
        }
        return parameter(result(values, coords), "prestretch", "stretch_limit")
    return result(values, coords, {"displacement": "mm", "constant_voltage": "V"})


def test_the_cone_is_a_line_and_the_continuum_markers_taut_slack_or_pulled_in():
    axes = blank()
    force_curves(film(), axes)
    zero, *drawn = axes.lines
    assert zero.get_ydata() == [0.0, 0.0]
    for k, level in enumerate(("0 V", "1 V")):
        cone, taut, slack, pulled = drawn[4 * k : 4 * k + 4]
        np.testing.assert_array_equal(data_of(cone), [X, CONE[k]])
        assert cone.get_label() == f"cone, voltage {level}"
        assert {one.get_markeredgecolor() for one in (taut, slack, pulled)} == {cone.get_color()} == {CYCLE[k]}
        kinds = ([0, 1, 3], [2], []) if k == 0 else ([0], [1], [2])
        for one, chosen in zip((taut, slack, pulled), kinds, strict=True):
            np.testing.assert_array_equal(data_of(one), [X[chosen], CONTINUUM[k, chosen]])
        assert to_rgb(taut.get_markerfacecolor()) == to_rgb(CYCLE[k])
        assert to_rgb(slack.get_markerfacecolor()) == to_rgb(pulled.get_markerfacecolor()) == (1.0, 1.0, 1.0)
        assert [one.get_marker() for one in (taut, slack, pulled)] == ["o", "o", "X"]
    said = [one.get_label() for one in axes.lines if one.get_label().startswith("continuum")]
    assert said == ["continuum, taut", "continuum, slack: not physical", "continuum, pulled in"]
    assert to_rgb(line(axes, "continuum, taut").get_markerfacecolor()) == (0.0, 0.0, 0.0)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("displacement (mm)", "force on the disc, film and field")


def test_a_film_that_is_slack_where_it_has_pulled_in_is_marked_as_pulled_in_alone():
    axes = blank()
    force_curves(film(hoop_slack=[[False] * 4, [False, True, True, False]]), axes)
    slack, pulled = axes.lines[7:9]
    assert (slack.get_marker(), pulled.get_marker()) == ("o", "X")
    assert data_of(slack).tolist() == [[0.5], [-0.4]]
    assert data_of(pulled).tolist() == [[1.0], [30.0]]


def test_only_what_occurs_is_in_the_legend():
    axes = blank()
    force_curves(film().isel(constant_voltage=[0], displacement=[0, 1]), axes)
    assert [one.get_label() for one in axes.lines if one.get_label().startswith("continuum")] == ["continuum, taut"]


def test_displacements_are_drawn_in_their_order():
    axes = blank()
    force_curves(film().isel(displacement=[2, 0, 3, 1]), axes)
    np.testing.assert_array_equal(axes.lines[1].get_xdata(), X)


def test_at_most_four_voltages_are_drawn_the_first_and_last_among_them():
    many = film().isel(constant_voltage=np.array([0, 0, 0, 0, 0, 0, 1]))
    many = many.assign_coords(constant_voltage=np.arange(7.0))
    axes = blank()
    force_curves(many, axes)
    said = [one.get_label() for one in axes.lines if one.get_label().startswith("cone")]
    assert said == [f"cone, voltage {k}" for k in (0, 2, 4, 6)]


def test_a_film_that_pulled_in_does_not_stretch_the_axis():
    axes = blank()
    limit_forces(film(), axes)
    assert axes.get_ylim() == pytest.approx((-0.5 - 0.06 * 3.5, 3.0 + 0.06 * 3.5))
    flat = blank()
    before = flat.get_ylim()
    limit_forces(film(cone_force=np.zeros((2, 4)), continuum_force=np.zeros((2, 4))), flat)
    assert flat.get_ylim() == before


def test_profiles_are_the_film_in_full_and_the_cone_dashed():
    axes = blank()
    profiles(film(), axes)
    assert len(axes.lines) == 6
    for k, x in enumerate(X[1:]):
        continuum, cone = axes.lines[2 * k : 2 * k + 2]
        np.testing.assert_allclose(data_of(continuum), [ROUND * (1.0 + 0.1 * x), x * np.array([1.0, 0.4, 0.0])])
        np.testing.assert_array_equal(data_of(cone), [[0.25, 1.25], [x, 0.0]])
        assert (continuum.get_linestyle(), cone.get_linestyle()) == ("-", "--")
        assert continuum.get_color() == cone.get_color() == CYCLE[k]
        assert continuum.get_label() == f"displacement {x:g} mm"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("radius", "height")


def test_stretches_are_drawn_along_the_film_hoop_dotted_and_the_cone_level():
    axes = blank()
    stretch_curves(film(), axes)
    for k, x in enumerate(X[1:]):
        meridional, hoop, cone = axes.lines[3 * k : 3 * k + 3]
        ring = ROUND * (1.0 + 0.1 * x)
        np.testing.assert_allclose(data_of(meridional), [ROUND, ring + 1.0])
        np.testing.assert_allclose(data_of(hoop), [ROUND, ring + 2.0])
        assert cone.get_ydata() == pytest.approx([np.sqrt(1.0 + x * x)] * 2)
        assert [one.get_linestyle() for one in (meridional, hoop, cone)] == ["-", ":", "--"]
    labels = {one.get_label(): one.get_linestyle() for one in axes.lines[-3:]}
    assert labels == {"meridional": "-", "hoop": ":", "meridional, cone": "--"}
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("mounted radius", "stretch")


def test_shapes_are_those_of_the_lowest_voltage_at_which_the_film_was_found():
    lost = int(Ending.TENSION_LOST)
    converged = int(Ending.CONVERGED)
    shown = shapes(film(ending=[[lost] * 4, [converged, lost, converged, converged]]))
    assert float(shown["constant_voltage"]) == 1.0
    assert shown["displacement"].values.tolist() == [1.0, 1.5]
    many = film().isel(displacement=np.array([0, 1, 1, 1, 2, 2, 3]))
    many = many.assign_coords(displacement=np.arange(7.0))
    assert shapes(many)["displacement"].values.tolist() == [1.0, 3.0, 6.0]
    shown = shapes(film(ending=[[converged, converged, lost, converged], [converged] * 4]))
    assert (float(shown["constant_voltage"]), shown["displacement"].values.tolist()) == (0.0, [0.5, 1.5])


def test_a_film_that_was_not_found_says_so():
    none = film(ending=np.full((2, 4), int(Ending.TENSION_LOST)))
    axes = blank()
    profiles(none, axes)
    assert not axes.lines
    assert [text.get_text() for text in axes.texts] == ["no film in tension found"]
    taut = blank()
    profiles(film(), taut)
    assert not taut.texts


def test_members_are_named_by_the_parameters_that_vary():
    assert members_of(film())[0][0] == ""
    names = [name for name, _ in members_of(film(3))]
    assert names == [
        "radius_ratio 0.1, stretch_limit 10",
        "radius_ratio 0.3, stretch_limit 20",
        "radius_ratio 0.5, stretch_limit 30",
    ]


def test_members_of_a_device_are_named_by_the_fields_and_gels_that_vary():
    found = film(3).drop_vars(["radius_ratio", "stretch_limit"])
    of_field = {"quantity": "device field", "units": "mm"}
    found = found.assign_coords(
        film_thickness=("member", [0.1, 0.2, 0.3], of_field),
        disc_radius=("member", [8.0, 8.0, 8.0], of_field),
        material=("member", ["soft", "soft", "stiff"], {"quantity": "device field", "units": "1"}),
    )
    assert [name for name, _ in members_of(found)] == [
        "material soft, film_thickness 0.1 mm",
        "material soft, film_thickness 0.2 mm",
        "material stiff, film_thickness 0.3 mm",
    ]


@pytest.mark.parametrize(("members", "rows"), [(2, [0, 1]), (5, [0, 2, 4])])
def test_up_to_three_members_have_a_row_each(members, rows):
    figure = validation_figure(film(members))
    titles = [axes.get_title(loc="left") for axes in figure.axes[::3]]
    names = [name for name, _ in members_of(film(members))]
    assert titles == [names[k] for k in rows]
    assert all((axes.get_legend() is not None) == (k < 3) for k, axes in enumerate(figure.axes))
    assert "continuum, pulled in" in texts(figure)
    legend = [text.get_text() for text in figure.axes[1].get_legend().get_texts()]
    assert legend == ["displacement 0.5", "displacement 1", "displacement 1.5"]
