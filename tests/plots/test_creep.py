"""The figure of creep: displacement and margin over the holding time, and the time to pull-in, in one unit of time."""

import numpy as np
import pytest

from gelcone.plots.branches import UNHELD, UNHELD_LABEL
from gelcone.plots.creep import creep_figure
from gelcone.plots.style import CYCLE
from tests.plots.made_up import data_of, line, result, texts

TIME = np.array([0.0, 200.0, 2000.0, 20_000.0])


def creep(**changed):
    along, over = ("constant_voltage",), ("constant_voltage", "time")
    values = {
        "displacement": (over, [[1.0, 1.1, 1.2, 1.3], [2.0, 2.1, 2.2, np.nan]]),
        "margin": (over, [[0.5, 0.4, 0.3, 0.2], [0.15, 0.1, 0.05, np.nan]]),
        "equilibrium_displacement": (along, [1.4, np.nan]),
        "pull_in_time": (along, [np.inf, 5000.0]),
        "long_term_pull_in_voltage": ((), 500.0),
        "instantaneous_pull_in_voltage": ((), 900.0),
        "time_to_pull_in": ("held_voltage", [np.inf, 8000.0, 4000.0]),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    coords = {"constant_voltage": (along, [300.0, 700.0]), "time": ("time", TIME)}
    coords["held_voltage"] = ("held_voltage", [550.0, 600.0, 800.0])
    units = dict.fromkeys(("constant_voltage", "held_voltage"), "V") | {"time": "ms", "displacement": "mm"}
    return result(values, coords, units)


def test_times_are_in_seconds_where_a_run_lasts_some_and_margins_in_percent():
    place, curve, margin = creep_figure(creep()).axes
    np.testing.assert_allclose(data_of(place.lines[0]), [[0.2, 2.0, 20.0], [1.1, 1.2, 1.3]])
    np.testing.assert_allclose(data_of(line(margin, "300 V")), [[0.2, 2.0, 20.0], [40.0, 30.0, 20.0]])
    np.testing.assert_allclose(data_of(line(margin, "700 V")), [[0.2, 2.0], [10.0, 5.0]])
    (dashed,) = (one for one in place.lines if one.get_linestyle() == "--")
    assert (dashed.get_ydata()[0], dashed.get_color()) == (1.4, CYCLE[0])
    for axes in (place, margin):
        (dotted,) = (one for one in axes.lines if one.get_linestyle() == ":")
        assert (dotted.get_xdata()[0], dotted.get_color()) == (pytest.approx(5.0), CYCLE[1])
    np.testing.assert_allclose(data_of(curve.lines[0]), [[600.0, 800.0], [8.0, 4.0]])
    np.testing.assert_allclose(data_of(line(curve, "held for the duration")), [[550.0], [20.0]])
    thresholds = [one.get_xdata()[0] for one in curve.lines if one.get_linestyle() == "--"]
    assert thresholds == [500.0, 900.0]
    assert [text.get_text().strip() for text in curve.texts] == ["in the long run", "at once"]
    assert (margin.get_xlabel(), margin.get_ylabel()) == ("holding time (s)", "margin (% of the voltage)")
    assert (curve.get_xlabel(), curve.get_ylabel()) == ("constant voltage (V)", "time to pull-in (s)")


def test_lines_of_voltages_at_which_the_model_does_not_hold_are_faint():
    place, _, margin = creep_figure(creep().assign(validity_breakdown=("constant_voltage", [0.5, 0.0]))).axes
    assert [one.get_alpha() for one in place.lines[:1]] == [UNHELD]
    assert [one.get_label() for one in margin.lines if one.get_alpha() == UNHELD] == ["300 V", UNHELD_LABEL]
    assert not any(one.get_alpha() == UNHELD for axes in creep_figure(creep()).axes for one in axes.lines)


def test_a_film_that_never_pulls_in_says_so():
    assert "no voltage pulls it in" in texts(creep_figure(creep(long_term_pull_in_voltage=np.inf)))


def test_a_time_that_is_not_known_is_neither_one_of_pull_in_nor_held():
    curve = creep_figure(creep(time_to_pull_in=[np.inf, np.nan, 4000.0])).axes[1]
    np.testing.assert_allclose(data_of(line(curve, "held for the duration")), [[550.0], [20.0]])
    np.testing.assert_allclose(data_of(curve.lines[0]), [[800.0], [4.0]])
    lost = creep_figure(creep(time_to_pull_in=[np.nan, 8000.0, 4000.0])).axes[1]
    assert lost.get_legend() is None


def test_what_pulls_in_at_once_has_no_time_on_a_log_axis():
    curve = creep_figure(creep(time_to_pull_in=[np.inf, 8000.0, 0.0])).axes[1]
    np.testing.assert_allclose(curve.lines[0].get_xydata(), [[600.0, 8.0]])
    assert (np.array(curve.lines[0].get_ydata()) > 0.0).all()
