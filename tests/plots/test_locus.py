"""Curves of bifurcations on a map or on tongues: where they belong, and refused where they do not."""

import numpy as np
import pytest

from gelcone import ConeModel, InputError, plot, tongues
from gelcone.plots import locus
from tests.plots.made_up import blank, result

MODEL = ConeModel(damping_ratio=0.3, stretch_limit=5.0)


VALUES = {"voltage": [0.5, 1.0, 1.5], "drive_frequency": [0.3, 0.35, 0.4], "damping_ratio": [0.1, 0.2, 0.3]}


def curves(first="voltage", second="drive_frequency"):
    made = result(
        {
            first: (("curve", "point"), [VALUES[first]]),
            second: (("curve", "point"), [VALUES[second]]),
            "curvature": (("curve", "point"), [[1.0, 1.0, -1.0]]),
            "period": ("curve", [2]),
            "event_kind": ("event", np.zeros(0, dtype=int)),
        },
        {},
        {first: "1", second: "1"},
    )
    return made.assign_attrs(parameters=f"{first},{second}", event="fold", title="locus", gelcone_version="0")


@pytest.fixture(scope="module")
def ground():
    return tongues(MODEL, [0.3, 0.4, 0.5], [0.0, 1.0, 2.0])


def test_curves_lie_on_tongues_whichever_parameter_comes_first(ground):
    for order in (("voltage", "drive_frequency"), ("drive_frequency", "voltage")):
        figure = plot(curves(*order), on=ground)
        axes = figure.axes[0]
        (line,) = [line for line in axes.lines if line.get_label() == "fold, period 2"]
        np.testing.assert_array_equal(line.get_xdata(), VALUES["drive_frequency"])
        np.testing.assert_array_equal(line.get_ydata(), [*VALUES["voltage"][:2], np.nan])
        assert axes.get_xlim() == (0.3, 0.5)
        (legend,) = figure.legends
        assert "fold, period 2" in [text.get_text() for text in legend.get_texts()]


def test_curves_over_other_parameters_are_refused(ground):
    with pytest.raises(InputError, match="curves over voltage and damping_ratio are drawn on a map or tongues over"):
        plot(curves("voltage", "damping_ratio"), on=ground)
    with pytest.raises(InputError, match="drawn on a map or tongues"):
        plot(curves(), on=curves())


def test_axes_of_curves_alone_have_the_units_of_their_parameters():
    made = curves()
    made["voltage"].attrs["units"], made["drive_frequency"].attrs["units"] = "V", "Hz"
    axes = plot(made).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("voltage (V)", "drive frequency (Hz)")


def test_a_name_stands_once_in_the_legend_however_many_curves_and_points_have_it():
    """Dashed where the branch that is born lies below, up to the points where that changes."""
    at, kinds = ("curve", "point"), {"flag_values": [0, 1], "flag_meanings": "cusp fold"}
    made = result(
        {
            "voltage": (at, np.arange(12.0).reshape(3, 4)), "damping_ratio": (at, np.arange(12.0).reshape(3, 4) / 10.0),
            "curvature": (at, [[-1.0, 1.0, 1.0, -1.0], [1.0] * 4, [1.0] * 4]), "period": ("curve", [2, 2, 4]),
            "event_kind": ("event", [0, 0]),
            "event_first": ("event", [3.0, 7.0]), "event_second": ("event", [0.3, 0.7]),
        }
    )  # fmt: skip
    made["event_kind"].attrs = kinds
    made.attrs |= {"parameters": "voltage,damping_ratio", "event": "fold"}
    axes = blank()
    locus.curves(made, axes)
    named = [line.get_label() for line in axes.lines if not line.get_label().startswith("_") and line.get_label()]
    assert named == ["fold, period 2", "fold, period 4", "cusp", locus.BELOW]
    solid, dashed = axes.lines[:2]
    np.testing.assert_array_equal(solid.get_ydata(), [np.nan, 0.1, 0.2, np.nan])
    np.testing.assert_array_equal(dashed.get_ydata(), [0.0, 0.1, 0.2, 0.3])
    dots = [line.get_xydata()[0].tolist() for line in axes.lines if len(line.get_xdata()) == 1]
    assert dots == [[3.0, 0.3], [7.0, 0.7]]
    turned = blank()
    locus.curves(made, turned, "damping_ratio")
    assert [line.get_xydata()[0].tolist() for line in turned.lines if len(line.get_xdata()) == 1] == [
        [0.3, 3.0],
        [0.7, 7.0],
    ]


@pytest.mark.parametrize(("curvature", "named"), [([1.0, 1.0, 1.0], False), ([-1.0, -1.0, -1.0], True)])
def test_branches_that_are_born_below_have_a_name_where_there_are_some(curvature, named):
    made = curves()
    made["curvature"][0] = curvature
    axes = plot(made).axes[0]
    (dashed,) = [one for one in axes.lines if one.get_label() == locus.BELOW] or [None]
    assert (dashed is not None) == named
    assert any(one.is_dashed() for one in axes.lines) == named
