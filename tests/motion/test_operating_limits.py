"""Operating limits: the ends of the envelope at the own drive frequency of each member."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome
from gelcone.motion.plane import DRIVEN_LIMITS
from gelcone.motion.static_limits import STATIC_LIMITS
from tests.motion.planes import LOW, TAUT, straight

operating_limits_module = importlib.import_module("gelcone.motion.operating_limits")


def test_the_limits_of_each_member_are_those_of_its_own_drive(monkeypatch):
    """The safe peak lies below the lower ends, by which limits are named; the widest interval is the error."""
    high = np.where(np.isfinite(LOW[:1]), LOW[:1] + 0.01 * np.arange(len(DRIVEN_LIMITS)), LOW[:1])
    examined = []
    monkeypatch.setattr(operating_limits_module, "plane_of", lambda model, threads: straight(model, jump=1.2))
    monkeypatch.setattr(operating_limits_module, "driven", lambda plane, omegas, volts, **options: {
        "low": omegas[0] * LOW[:1], "high": omegas[0] * high, "asked": examined.append(volts),
    })  # fmt: skip
    model = TAUT.replace(drive_frequency=np.array([1.0, 2.0, 3.0]), voltage=np.array([0.3, 0.0, 0.3]))
    found = gelcone.operating_limits(model.replace(voltage_bias=np.array([0.3, 0.0, 0.3])))
    assert found["outcome"].values.tolist() == [Outcome.OK, Outcome.ERROR, Outcome.OK]
    for k, omega in ((0, 1.0), (2, 3.0)):
        own = found.isel(member=k) if "member" in found.dims else found.isel({found["outcome"].dims[0]: k})
        static = [float(own[f"{name.replace(' ', '_').replace('-', '_')}_voltage"]) for name in STATIC_LIMITS]
        assert static[-1] == 1.2
        safe = min(omega * 0.5, *(value for value in static if value == value), 1.2)
        assert float(own["safe_peak_voltage"]) == pytest.approx(safe)
        assert float(own["driven_error_voltage"]) == pytest.approx(omega * 0.03)
        assert float(own["driven_meridional_slack_voltage"]) == pytest.approx(omega * 0.5)
        assert float(own["driven_chaos_voltage"]) == np.inf
        assert float(own["examined_voltage"]) == 1.212
        assert float(own["examined_step_voltage"]) == pytest.approx(1.212 / 20.0)
    np.testing.assert_allclose(examined[0], 1.212 * np.arange(1.0, 21.0) / 20.0)
    assert "chaos" not in found["driven_pull_in_voltage"].attrs["long_name"]
    assert np.isnan(found["safe_peak_voltage"].values[1])


@pytest.mark.parametrize("ratio", [None, 0.3])
def test_the_pull_in_of_a_membrane_is_unknown_for_a_reason(ratio, monkeypatch):
    """A taut cone without a radius ratio stands for no membrane."""
    monkeypatch.setattr(operating_limits_module, "plane_of", lambda model, threads: straight(model, jump=1.2))
    low = np.full((1, len(DRIVEN_LIMITS)), 0.9)
    monkeypatch.setattr(operating_limits_module, "driven", lambda *given, **options: {"low": low, "high": low})
    found = gelcone.operating_limits(TAUT if ratio is None else TAUT.replace(radius_ratio=ratio))
    words = found["membrane_pull_in_voltage"].attrs["nan_means"]
    assert words == ("unknown without radius_ratio" if ratio is None else "unknown")


@pytest.mark.parametrize(("pull_in", "chaos", "late"), [(0.9, 0.6, True), (0.6, 0.9, False), (np.inf, 0.6, False)])
def test_a_pull_in_above_the_limit_of_chaos_is_said_to_be_that_of_one_run(monkeypatch, pull_in, chaos, late):
    low = np.full((1, len(DRIVEN_LIMITS)), np.inf)
    low[0, DRIVEN_LIMITS.index("pull-in")], low[0, DRIVEN_LIMITS.index("chaos")] = pull_in, chaos
    monkeypatch.setattr(operating_limits_module, "plane_of", lambda model, threads: straight(model, jump=1.2))
    monkeypatch.setattr(operating_limits_module, "driven", lambda *given, **options: {"low": low, "high": low})
    found = gelcone.operating_limits(TAUT)
    words = found["driven_pull_in_voltage"].attrs["long_name"]
    assert ("out of chaos" in words) is late
    assert "pull-in of the cone" in words
    assert "chaos" not in found["pull_in_voltage"].attrs["long_name"]
    calm = np.where(np.arange(len(DRIVEN_LIMITS)) == DRIVEN_LIMITS.index("pull-in"), 0.8, np.inf)[None]
    each = iter([calm, low])
    monkeypatch.setattr(
        operating_limits_module, "driven", lambda *given, **options: dict.fromkeys(("low", "high"), next(each))
    )
    two = gelcone.operating_limits(TAUT.replace(voltage=np.array([0.2, 0.3])))
    assert ("out of chaos" in two["driven_pull_in_voltage"].attrs["long_name"]) is late  # one of them is enough
