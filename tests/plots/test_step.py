"""The figure of steps: each voltage's displacement, where a slow ramp ends, and when it has settled."""

import numpy as np
import pytest

from gelcone.codes import Outcome
from gelcone.plots.step import step_figure
from gelcone.plots.style import CYCLE, UNHELD, UNHELD_LABEL
from tests.plots.made_up import line, result


def test_lines_stand_at_the_equilibrium_and_at_the_settling_time():
    step = result(
        {
            "displacement": (("constant_voltage", "time"), [[1.0, 2.5, 2.1], [1.0, 3.0, 2.9]]),
            "outcome": ("constant_voltage", [0, 4]),
            "equilibrium_displacement": ("constant_voltage", [2.2, 3.3]),
            "final_displacement": ("constant_voltage", [2.0, 3.1]),
            "rise_time": ("constant_voltage", [4.0, 5.0]),
            "settling_time": ("constant_voltage", [7.0, np.nan]),
            "initial_displacement": ("constant_voltage", [1.0, 1.0]),
        },
        {"constant_voltage": ("constant_voltage", [300.0, 600.0]), "time": ("time", [0.0, 10.0, 20.0])},
        {"time": "ms", "displacement": "mm", "constant_voltage": "V"},
    )
    (axes,) = step_figure(step).axes
    assert not any(one.get_alpha() == UNHELD or one.get_label() == UNHELD_LABEL for one in axes.lines)
    np.testing.assert_array_equal(line(axes, "300 V").get_ydata(), [1.0, 2.5, 2.1])
    assert line(axes, "300 V").get_xdata().tolist() == [0.0, 10.0, 20.0]
    ended = next(one for one in axes.lines if one.get_label().startswith("600 V, "))
    assert ended.get_color() == CYCLE[1]
    assert ended.get_label() == f"600 V, {Outcome(4).words}"
    dashed = [one for one in axes.lines if one.get_linestyle() == "--"]
    assert [(one.get_ydata()[0], one.get_color()) for one in dashed] == [(2.2, CYCLE[0]), (3.3, CYCLE[1])]
    (dotted,) = (one for one in axes.lines if one.get_linestyle() == ":")
    assert (dotted.get_xdata()[0], dotted.get_color()) == (7.0, CYCLE[0])
    assert axes.get_xlim() == pytest.approx((0.0, 20.0))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time after the step (ms)", "displacement (mm)")
    (axes,) = step_figure(step.assign(validity_hoop_slack=("constant_voltage", [0.0, 0.25]))).axes
    faint = [one.get_label() for one in axes.lines if one.get_alpha() == UNHELD]
    assert faint == [ended.get_label(), UNHELD_LABEL]
    assert UNHELD_LABEL in [text.get_text() for text in axes.get_legend().get_texts()]
