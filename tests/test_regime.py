"""Kinds of motion: cases whose answer is certain."""

from __future__ import annotations

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.model import ConeModel
from gelcone.motion.flow import Outcome
from gelcone.motion.regime import Regime, regime

BASE = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, drive_frequency=0.1)
FAST = ConeModel(damping_ratio=0.01, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"budget": 4000.0}


def kind(result) -> tuple[str, int]:
    return Regime(int(result["regime"])).label, int(result["period"])


def test_below_the_onset_the_disc_comes_to_rest():
    found = regime(BASE.replace(voltage=0.5), **QUICK)
    assert kind(found) == ("rest", 0)
    assert float(found["lyapunov"][0]) == pytest.approx(-0.01, abs=1e-4)
    assert int(found["flag"]) == 0


def test_a_biased_drive_of_a_lifted_disc_gives_a_cycle_of_one_repeat():
    model = ConeModel(damping_ratio=0.1, voltage=0.2, voltage_bias=0.3, rest_height=0.5)
    found = regime(model, (0.5, 0.0), **QUICK)
    assert kind(found) == ("periodic", 1)
    assert int(found["symmetric"]) == 0
    assert int(found["flag"]) == 0


def test_a_parametric_swing_takes_two_repeats_and_is_its_own_mirror_image():
    model = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, voltage=0.9, drive_frequency=1.1)
    found = regime(model, **QUICK)
    assert kind(found) == ("periodic", 2)
    assert int(found["symmetric"]) == 1
    assert float(found["highest"]) == pytest.approx(-float(found["lowest"]), rel=1e-3)


def test_returning_points_do_return():
    found = regime(BASE.replace(voltage=1.2), **QUICK)
    name, period = kind(found)
    points = found["section"].values
    assert name == "periodic"
    assert np.abs(points[period:] - points[:-period]).max() < 1e-3


def test_chaos_has_a_positive_exponent_and_passes_the_second_test():
    found = regime(BASE.replace(voltage=1.7), **QUICK)
    assert kind(found) == ("chaotic", 0)
    assert float(found["lyapunov"][0]) > 3.0 * float(found["standard_error"][0])
    assert float(found["zero_one"]) > 0.8
    assert int(found["flag"]) == 0


def test_without_damping_a_small_free_swing_under_drive_is_quasi_periodic():
    model = ConeModel(damping_ratio=0.0, spring_stiffness=1.0, voltage=0.2, drive_frequency=1.0)
    found = regime(model, (0.3, 0.0), transient=200.0, budget=3000.0)
    assert kind(found) == ("quasi-periodic", 0)
    assert abs(float(found["zero_one"])) < 0.2


def test_members_that_leave_the_domain_say_so_and_leave_the_rest_alone():
    ensemble = FAST.replace(voltage=1.005, stretch_limit=[0.4, 1.2, 10.0])
    found = regime(ensemble, **QUICK)
    names = [Regime(int(k)).label for k in found["regime"].values]
    assert names == ["left the domain", "chaotic", "periodic"]
    assert found["outcome"].values.tolist() == [Outcome.OUTSIDE, Outcome.OK, Outcome.OK]


def test_a_film_without_a_limit_can_run_away():
    model = ConeModel(law="neo-hookean", voltage=0.0, voltage_bias=2.5, spring_stiffness=0.5)
    found = regime(model, transient=2000.0, **QUICK)
    assert kind(found)[0] == "left the domain"


def test_an_ensemble_equals_its_members_one_by_one_to_the_last_bit():
    ensemble = FAST.replace(voltage=np.array([0.3, 0.9, 1.3, 1.7]))
    together = regime(ensemble, threads=2, **QUICK)
    for k in range(4):
        alone = regime(ensemble.take([k]), threads=1, **QUICK)
        for name in ("regime", "period", "lyapunov", "standard_error", "section", "settled_time"):
            np.testing.assert_array_equal(together[name][k], alone[name][0])


@pytest.mark.parametrize("name", ["transient", "budget"])
def test_times_that_are_not_positive_are_refused(name):
    with pytest.raises(InputError, match=name):
        regime(BASE, **{name: 0.0})
