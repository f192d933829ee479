"""Motions side by side: the same numbers as each alone, and what each panel shows."""

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome, Regime
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.presets import find_preset

BASE = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
"""Rests below a voltage, swings above."""
QUICK = {"periods": 4, "late_periods": 3, "budget": 2000.0}


def test_each_column_is_what_the_analyses_of_its_motion_give():
    found = gelcone.triptych(BASE.replace(voltage=[0.3, 0.9]), **QUICK)
    for voltage in (0.3, 0.9):
        member, model = found.sel(voltage=voltage), BASE.replace(voltage=voltage)
        alone = gelcone.regime(model, budget=2000.0)
        for name in ("regime", "period", "lyapunov", "lowest", "highest"):
            np.testing.assert_array_equal(member[name], alone[name], name)
        run = gelcone.simulate(model, times=member["time"].values)
        np.testing.assert_allclose(member["displacement"], run["displacement"], atol=1e-12)
        np.testing.assert_allclose(member["velocity"], run["velocity"], atol=1e-12)
        assert float(member["late_displacement"].max()) == pytest.approx(float(alone["highest"]), abs=1e-3)
        assert float(member["late_displacement"].min()) == pytest.approx(float(alone["lowest"]), abs=1e-3)
    period = 2.0 * np.pi / 0.3
    assert float(found["time"].max()) == pytest.approx(4.0 * period)
    assert float(found["late_time"].max()) == pytest.approx(3.0 * period)
    assert found["regime"].values.tolist() == [Regime.REST, Regime.PERIODIC]


def test_the_section_lies_on_the_settled_motion_once_every_forcing_period():
    found = gelcone.triptych(BASE.replace(voltage=0.9), **QUICK)
    period = int(found["period"])
    x = found["section_displacement"].values
    known = x[np.isfinite(x)]
    assert known.size > 2 * period
    np.testing.assert_allclose(known[period:], known[:-period], atol=1e-9)
    assert x[0] == pytest.approx(float(found["late_displacement"][0]), abs=1e-12)


def test_chaos_has_its_whole_section_and_a_motion_that_ended_none():
    chaos = gelcone.triptych(find_preset("base").model.replace(voltage=1.7), **QUICK)
    assert int(chaos["regime"]) == Regime.CHAOTIC
    assert int(np.isfinite(chaos["section_displacement"]).sum()) == 600
    pump = gelcone.find_device("biased-pump").replace(film="wrinkling", voltage_amplitude="1700 V")
    ended = gelcone.triptych(pump, periods=4, late_periods=3)
    assert int(ended["outcome"]) == Outcome.PULLED_IN
    assert not np.isfinite(ended["late_displacement"]).any()
    assert not np.isfinite(ended["section_displacement"]).any()
    assert 0 < int(np.isfinite(ended["displacement"]).sum()) < ended["displacement"].size
    assert ended["displacement"].attrs["units"] == "mm"


def test_the_figure_has_a_column_for_each_motion_in_the_colour_of_its_regime():
    found = gelcone.triptych(BASE.replace(voltage=[0.3, 0.9]), **QUICK)
    figure = found.gelcone.plot()
    assert len(figure.axes) == 8
    settled = [axes.get_lines()[0].get_color() for axes in figure.axes[2:4]]
    assert settled == [REGIME_COLOURS[Regime.REST], REGIME_COLOURS[Regime.PERIODIC]]
    for k, axes in enumerate(figure.axes[:4]):
        name = "displacement" if k < 2 else "late_displacement"
        np.testing.assert_array_equal(axes.get_lines()[0].get_ydata(), found[name][k % 2])
    titles = [axes.get_title(loc="left") for axes in figure.axes[:2]]
    assert titles[0].startswith("voltage 0.3\nrest\n")
    assert titles[1].startswith("voltage 0.9\nperiodic")
    low, high = figure.axes[2].get_ylim()
    assert high - low > 0.1, "a rest is not magnified"


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({"voltage": [0.1, 0.2, 0.3, 0.4, 0.5]}, {}, "was given 5 motions; give at most 4"),
        ({}, {"periods": 0}, "periods = 0: must be at least 1"),
        ({}, {"late_periods": 0.5}, "late_periods = 0.5: must be a whole number"),
    ],
)
def test_what_has_no_room_is_refused(changes, options, message):
    with pytest.raises(InputError, match=message):
        gelcone.triptych(BASE.replace(**changes), **options)
