"""The picture of a membrane: a second film hangs from above, and the dielectric strength is that of the shares."""

import numpy as np

from gelcone.plots.profile import cone_profile, fields
from tests.plots.made_up import blank, result


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
    cone_profile(profile(), [(0, 0)], "", axes.figure, axes)
    pieces = [np.array(c.get_segments()) for c in axes.collections]
    right = [own[0] for own in pieces if own[0][0][0] > 0.0]
    np.testing.assert_array_equal(right[0], [[8.0, 5.0], [30.0, 0.0]])
    np.testing.assert_array_equal(right[1], [[8.0, 5.0], [30.0, 2.0]])  # held 3 below its own rim, which is at 2
    assert {tuple(own[0][0]) for own in pieces} == {(8.0, 5.0), (-8.0, 5.0)}


def test_the_strength_is_the_largest_field_over_its_share():
    axes = blank()
    fields(profile(), [(0, 0)], "", axes)
    (dotted,) = (one for one in axes.lines if one.get_linestyle() == ":")
    assert dotted.get_ydata()[0] == 25.0
