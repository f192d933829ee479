"""The figure of a fitted device: readings next to their predictions, and each unknown's bar next to its name."""

import json

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from gelcone.plots.device_fit import device_fit_figure, draw_row, in_prefixes, left_bars
from gelcone.plots.style import BLUE, GREY, VERMILION
from tests.plots.made_up import blank, corners, data_of, result


def test_readings_have_their_noise_and_bars_their_names():
    fit = result(
        {
            "reading_test": ("reading", [0, 0, 0]),
            "reading_name": ("reading", ["force"] * 3),
            "reading_axis": ("reading", ["height (m)"] * 3),
            "reading_unit": ("reading", ["N"] * 3),
            "reading_along": ("reading", [0.01, 0.02, 0.015]),
            "measured": ("reading", [1.0, 2.0, 1.4]),
            "noise": ("reading", [0.1, 0.2, 0.3]),
            "predicted": ("reading", [1.1, 2.2, 1.5]),
            "posterior": ("unknown", [0.02, 0.9, 0.06]),
            "prior": ("unknown", [0.1, 1.0, 0.1]),
            "deviation": ("unknown", [0.25, 0.1, 0.15]),
        },
        {"unknown": ("unknown", ["material.shear_modulus", "spring_rate", "moving_mass"])},
        attrs={"tests": json.dumps(["blocked force"]), "refused": 0, "title": "device fit: pump", "chosen": "taut"},
    )
    panel, bars, *_ = device_fit_figure(fit).axes
    np.testing.assert_allclose(
        corners(panel.collections[0]), [[0.01, 0.01, 0.9, 1.1], [0.02, 0.02, 1.8, 2.2], [0.015, 0.015, 1.1, 1.7]]
    )
    curves = [one.get_ydata().tolist() for one in panel.lines[1:]]
    assert curves == [[1.1, 2.2], [1.5]]  # a curve for each rise of the height
    assert panel.get_xlabel() == "height"
    assert (panel.xaxis.get_major_formatter()(0.02), panel.yaxis.get_major_formatter()(1.5)) == ("20 mm", "1.5 N")
    names = dict(zip(bars.get_yticks(), (text.get_text() for text in bars.get_yticklabels()), strict=True))
    found = {names[bar.get_y() + bar.get_height() / 2]: bar.get_width() for bar in bars.patches}
    assert found == pytest.approx({"shear_modulus": 0.2, "spring_rate": 0.9, "moving_mass": 0.6})
    assert names[max(names)] == "shear_modulus"  # the first on top
    assert [bar.get_facecolor()[:3] for bar in bars.patches] == [to_rgb(BLUE), to_rgb(GREY), to_rgb(GREY)]
    (far,) = (text for text in bars.texts if text.get_text() == "far from its prior")
    assert (names[far.get_position()[1]], far.get_color()) == ("shear_modulus", VERMILION)


def test_an_unknown_is_far_from_its_prior_on_either_side():
    for moved, said in ((0.25, 1), (-0.25, 1), (0.19, 0), (-0.19, 0)):
        fit = result(
            {name: ("unknown", [value]) for name, value in (("posterior", 0.02), ("prior", 0.1), ("deviation", moved))},
            {"unknown": ("unknown", ["spring_rate"])},
        )
        axes = blank()
        left_bars(fit, axes)
        assert len(axes.texts) == said


def test_readings_of_a_single_row_are_shares_of_the_fitted_ones():
    """Their noise too, whichever the sign; each with its name and number."""
    row = result(
        {
            "reading_name": ("reading", ["rest_height", "force"]), "reading_unit": ("reading", ["mm", "N"]),
            "measured": ("reading", [3.0, -1.0]), "predicted": ("reading", [2.0, -4.0]),
            "noise": ("reading", [0.1, 0.2]),
        }
    )  # fmt: skip
    axes = blank()
    draw_row(row, "weight", axes)
    np.testing.assert_allclose(data_of(axes.lines[0]), [[0.0, 1.0], [1.5, 0.25]])
    np.testing.assert_allclose(corners(axes.collections[0]), [[0.0, 0.0, 1.45, 1.55], [1.0, 1.0, 0.2, 0.3]])
    assert [text.get_text() for text in axes.get_xticklabels()] == ["rest height\n3 mm", "force\n-1 N"]
    assert axes.get_title() == "weight"


@pytest.mark.parametrize(
    ("unit", "tick", "label"),
    [("m", "2 mm", "height"), ("N", "2 mN", "height"), ("V", "2 mV", "height"), ("F", "2 mF", "height"),
     ("s", None, "height (s)"), ("", None, "height")],
)  # fmt: skip
def test_lengths_forces_voltages_and_capacitances_have_ticks_with_prefixes(unit, tick, label):
    axis = blank().xaxis
    in_prefixes(axis, "height", unit)
    assert axis.get_label_text() == label
    if tick:
        assert axis.get_major_formatter()(0.002) == tick
    axis = blank().yaxis
    in_prefixes(axis, "", unit)
    assert axis.get_label_text() == ("" if tick else unit)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_each_test_has_a_panel_with_its_own_readings_and_the_bars_one_more(count):
    tests = np.repeat(np.arange(count), 2)
    fit = result(
        {
            "reading_test": ("reading", tests), "reading_name": ("reading", ["force"] * (2 * count)),
            "reading_axis": ("reading", ["height (m)"] * (2 * count)), "reading_unit": ("reading", ["N"] * (2 * count)),
            "reading_along": ("reading", [0.01, 0.02] * count), "measured": ("reading", 1.0 + tests),
            "noise": ("reading", np.full(2 * count, 0.1)), "predicted": ("reading", 1.5 + tests),
            "posterior": ("unknown", [0.5]), "prior": ("unknown", [1.0]), "deviation": ("unknown", [0.0]),
        },
        {"unknown": ("unknown", ["spring_rate"])},
        attrs={"tests": json.dumps([f"test {k}" for k in range(count)]), "refused": 0, "title": "t", "chosen": "taut"},
    )  # fmt: skip
    *panels, bars = (axes for axes in device_fit_figure(fit).axes if axes.get_visible())
    assert [axes.get_title() for axes in panels] == [f"test {k}" for k in range(count)]
    for k, axes in enumerate(panels):
        np.testing.assert_array_equal(data_of(axes.lines[-1]), [[0.01, 0.02], [1.5 + k] * 2])
    assert bars.get_xlabel() == "standard deviation left, over the prior"
