"""Curves of bifurcations on a map or on tongues: where they belong, and refused where they do not."""

import numpy as np
import pytest

from gelcone import ConeModel, InputError, plot, tongues
from tests.plots.made_up import result

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
