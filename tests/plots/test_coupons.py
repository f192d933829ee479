"""The figure of a material fit: holds over hours, other tests over the stretch, with the whole band."""

import numpy as np

from gelcone.plots.coupons import coupon_figure
from tests.plots.made_up import corners, data_of, line, result


def made_up():
    return result(
        {
            "sample_test": ("sample", [0, 0, 0, 1, 1]),
            "time": ("sample", [0.0, 1800.0, 7200.0, np.nan, np.nan]),
            "stretch": ("sample", [1.5, 1.5, 1.5, 1.0, 2.0]),
            "stress": ("sample", [9.0, 6.0, 5.0, 0.0, 8.0]),
            "predicted": ("sample", [9.5, 6.5, 5.5, 0.5, 8.5]),
            "left_out": ("sample", [10.0, 7.0, 6.0, 1.0, 9.0]),
            "largest_stress": ("test", [9.0, 8.0]),
            "error": ("test", [0.031, 0.042]),
            "test_kind": ("test", ["relaxation", "quasi-static"]),
            "test_name": ("test", ["hold", "pull"]),
            "test_use": ("test", ["fit", "fit"]),
        },
        attrs={"band": 0.1, "chosen_law": "gent", "chosen_branches": 2, "title": "material fit: gel"},
    )


def test_a_hold_is_drawn_over_hours_and_a_band_lies_on_both_sides():
    hold, pull = (axes for axes in coupon_figure(made_up()).axes if axes.get_visible())
    np.testing.assert_allclose(data_of(line(hold, "measured")), [[0.0, 0.5, 2.0], [9.0, 6.0, 5.0]])
    np.testing.assert_allclose(data_of(line(hold, "material")), [[0.0, 0.5, 2.0], [9.5, 6.5, 5.5]])
    np.testing.assert_allclose(data_of(line(hold, "predicted from the other tests"))[1], [10.0, 7.0, 6.0])
    np.testing.assert_allclose(corners(hold.collections[0]), [[0.0, 2.0, 5.1, 10.9]])
    np.testing.assert_allclose(data_of(line(pull, "measured")), [[1.0, 2.0], [0.0, 8.0]])
    np.testing.assert_allclose(corners(pull.collections[0]), [[1.0, 2.0, 0.2, 9.8]])
    assert [(axes.get_xlabel(), axes.get_title()) for axes in (hold, pull)] == [
        ("time (h)", "hold: 3.1 %"),
        ("stretch", "pull: 4.2 %"),
    ]
    assert hold.get_ylabel() == "stress (kPa)"


def test_without_a_band_none_is_drawn_or_named():
    hold = coupon_figure(made_up().assign_attrs(band=np.nan)).axes[0]
    assert not hold.collections


def test_tests_that_only_check_the_fit_are_drawn_and_those_left_out_are_not():
    for uses, drawn in (
        (["check", "fit"], ["hold", "pull"]),
        (["leave out", "check"], ["pull"]),
        (["fit", "leave out"], ["hold"]),
    ):
        figure = coupon_figure(made_up().assign(test_use=("test", uses)))
        assert [axes.get_title().partition(":")[0] for axes in figure.axes if axes.get_visible()] == drawn
