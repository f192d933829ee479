"""The picture of a membrane: a second film hangs from above, and the dielectric strength is that of the shares."""

import numpy as np
import pytest

from gelcone.plots.profile import cone_profile, fields, films_of, profile_figure
from tests.plots.made_up import blank, data_of, line, result

RINGS = ("ring_radius", "ring_height", "true_field", "meridional_stretch", "hoop_stretch")


def profile():
    ring, cell = ("height", "constant_voltage", "ring"), ("height", "constant_voltage")
    values = {}
    for prefix in ("", "second_"):
        values |= {
            f"{prefix}held": (cell, [[0]]),
            f"{prefix}mounted_radius": ("ring", [8.0, 30.0]),
            f"{prefix}ring_radius": (ring, [[[8.0, 30.0]]]),
            f"{prefix}true_field": (ring, [[[20.0, 12.0]]]),
            f"{prefix}wrinkle_excess": (ring, [[[0.0, 0.0]]]),
            f"{prefix}largest_field": (cell, [[20.0]]),
            f"{prefix}breakdown_share": (cell, [[0.8]]),
        }
    values |= {"ring_height": (ring, [[[5.0, 0.0]]]), "second_ring_height": (ring, [[[-3.0, 0.0]]])}
    return result(values | {"displacement": (cell, [[5.0]])}, units={"true_field": "kV/mm"})


def test_films_of_a_double_cone_meet_at_the_disc():
    axes = blank()
    cone_profile(films_of(profile()), [(0, 0)], axes)
    pieces = [np.array(c.get_segments()) for c in axes.collections]
    right = [own[0] for own in pieces if own[0][0][0] > 0.0]
    np.testing.assert_array_equal(right[0], [[8.0, 5.0], [30.0, 0.0]])
    np.testing.assert_array_equal(right[1], [[8.0, 5.0], [30.0, 2.0]])  # held 3 below its own rim, which is at 2
    assert {tuple(own[0][0]) for own in pieces} == {(8.0, 5.0), (-8.0, 5.0)}


def test_the_strength_is_the_largest_field_over_its_share():
    axes = blank()
    fields(profile(), [(0, 0)], axes)
    (dotted,) = (one for one in axes.lines if one.get_linestyle() == ":")
    assert dotted.get_ydata()[0] == 25.0
    assert dotted.get_label() == "dielectric strength"
    blind = profile()
    blind["breakdown_share"][:] = np.nan  # the strength is not known
    fields(blind, [(0, 0)], axes := blank())
    assert not [one for one in axes.lines if one.get_linestyle() == ":"]


def test_wrinkles_are_named_where_a_film_has_some():
    for prefix in ("", "second_"):
        found = profile()
        cone_profile(films_of(found), [(0, 0)], smooth := blank())
        assert smooth.get_legend() is None
        found[f"{prefix}wrinkle_excess"][..., 1] = 0.2
        cone_profile(films_of(found), [(0, 0)], rough := blank())
        assert [text.get_text() for text in rough.get_legend().get_texts()] == ["wrinkled"]


@pytest.mark.parametrize(("heights", "volts"), [(3, 1), (1, 3), (2, 3)])
def test_the_capacitance_is_drawn_where_height_and_voltage_both_vary(heights, volts):
    """Each state has numbers of its own, and each curve is that of the state or voltage that its label names."""
    cell, ring = ("height", "constant_voltage"), ("height", "constant_voltage", "ring")
    own = 1.0 + np.arange(heights * volts, dtype=float).reshape(heights, volts)
    rings = own[..., None] * [1.0, 0.5]
    found = result(
        {"held": (cell, 0.0 * own), "capacitance": (cell, 100.0 * own), "largest_field": (cell, own)}
        | {"breakdown_share": (cell, 0.0 * own), "displacement": (cell, 10.0 * own), "outcome": ((), 0)}
        | {"mounted_radius": ("ring", [8.0, 30.0]), "wrinkle_excess": (ring, 0.0 * rings)}
        | {name: (ring, (k + 2.0) * rings) for k, name in enumerate(RINGS)},
        {
            "height": ("height", np.arange(heights) + 0.5),
            "constant_voltage": ("constant_voltage", 300.0 * np.arange(volts)),
        },
        {"displacement": "mm", "constant_voltage": "V", "capacitance": "pF", "height": "mm"},
    )
    figure = profile_figure(found)
    panels = {axes.get_ylabel(): axes for axes in figure.axes}
    for i, k in np.ndindex(heights, volts):
        curve = line(panels["stretch (dashed: hoop)"], f"{10.0 * own[i, k]:g} mm, {300.0 * k:g} V")
        np.testing.assert_array_equal(curve.get_ydata(), found["meridional_stretch"][i, k])
    assert ("capacitance (pF)" in panels) == (heights > 1 and volts > 1)
    for k in range(volts if heights > 1 and volts > 1 else 0):
        curve = line(panels["capacitance (pF)"], f"{300.0 * k:g} V")
        np.testing.assert_array_equal(data_of(curve), [found["height"], 100.0 * own[:, k]])


def test_the_lower_panels_of_two_films_say_whose_they_are():
    found = profile()
    for name in ("meridional_stretch", "hoop_stretch"):
        found[name] = found["true_field"] / 10.0
    found = found.assign(outcome=((), 0)).assign_coords(constant_voltage=[800.0])
    figure = profile_figure(found)
    assert figure.axes[0].get_title(loc="left") == "above: both films; below: the first film alone"
    alone = found.drop_vars([name for name in found.data_vars if str(name).startswith("second_")])
    assert profile_figure(alone).axes[0].get_title(loc="left") == ""
