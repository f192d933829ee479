"""The settled motion and its harmonics: phases in degrees, and none of what does not move."""

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone import frequency, in_words, regime, settled
from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import FIRST_TOLERANCE
from gelcone.motion.electrical import MEANINGS, known_of
from gelcone.motion.state_space import small_signal_response, state_space
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import Harmonics
from tests.motion.swings import swings
from tests.recorded import numbers, record

module, swing_module = (importlib.import_module(f"gelcone.motion.{name}") for name in ("settled", "swing"))
SMALL = ConeModel(
    voltage=1e-4, voltage_bias=0.3, rest_height=0.3, spring_stiffness=2.0, damping_ratio=0.2, drive_frequency=0.8
)


def test_phases_are_degrees_ahead_of_the_voltage():
    """Of a small motion about a bias the first phase is that of linear theory; the third harmonic is rounding."""
    result = settled(SMALL, (0.3, 0.0))
    linear = small_signal_response(SMALL, [0.8])
    assert result["harmonic_phase"].attrs["units"] == linear["phase"].attrs["units"] == "degree"
    assert float(result["harmonic_phase"][0]) == pytest.approx(float(linear["phase"][0]), abs=1e-3)
    assert -179.0 < float(linear["phase"][0]) < -1.0
    assert np.isnan(result["harmonic_phase"].values[2:]).all()


def test_what_does_not_move_has_no_phase():
    still = ConeModel(voltage=0.2, damping_ratio=0.3, drive_frequency=[0.4, 0.8])
    at_rest = settled(still, (0.3, 0.0))
    assert at_rest["resting"].values.all()
    assert np.isnan(at_rest["harmonic_phase"].values).all()
    swept = frequency(still.replace(drive_frequency=0.4), [0.4, 0.5], (0.3, 0.0))
    assert np.isnan(swept["harmonic_phase"].values).all()
    assert np.isnan(small_signal_response(still.replace(drive_frequency=0.4), [0.4])["phase"].values).all()


def test_rounding_of_a_disc_at_rest_is_zero():
    late = {"dielectric_share": 0.3, "dielectric_time": 2.0, "filter_time": 0.4, "leakage_time": 5.0}
    undriven = ConeModel(voltage=0.0, rest_height=0.6, damping_ratio=0.3, **late)
    found = settled(undriven, (0.8, 0.1))
    assert found["resting"] == 1
    for name in ("current", "power", "damper_power", "leak_power", "apparent_power", "field", "heat"):
        assert float(found[name]) == 0.0, name
    assert float(settled(undriven.replace(voltage=0.4), (0.8, 0.1))["current"]) > 0.1
    assert float(found["linear_stroke"]) == 0.0


def test_a_drive_with_too_many_harmonics_is_the_reason_of_no_linear_stroke():
    rich = ConeModel(voltage=0.0, rest_height=0.6, damping_ratio=0.3, waveform=Harmonics(((30_000, 1.0, 0.0),)))
    found = settled(rich, (0.8, 0.1))
    assert "stroke by linear theory: too many harmonics of the drive" in in_words(found)


@pytest.mark.parametrize("frequency", [[0.005], [0.01, 0.9]])
def test_the_stroke_of_a_slow_drive_that_jumps_has_its_overshoot(frequency):
    """The disc oscillates many times within a period, about each of two rests."""
    model = SMALL.replace(waveform="square", rise=0.0, drive_frequency=frequency)
    linear = state_space(SMALL)
    zeta = -0.5 * linear.A[1, 1] / np.sqrt(-linear.A[1, 0])
    overshoot = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta * zeta))
    found = settled(model, (0.3, 0.0))["stroke"].values
    assert found[0] == pytest.approx(-2e-4 * linear.B[1, 0] / linear.A[1, 0] * (1.0 + 2.0 * overshoot), rel=1e-3)
    alone = [settled(model.replace(drive_frequency=one), (0.3, 0.0))["stroke"].item() for one in frequency]
    assert found.tolist() == alone
    kinds = regime(model, (0.3, 0.0))
    np.testing.assert_allclose(kinds["highest"] - kinds["lowest"], found, rtol=1e-9)


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_each_variable_holds_its_number_of_the_swing_and_the_linear_stroke_that_of_motions_that_ran(monkeypatch):
    """The first of four members has no damping, the second ended; the others have frequencies of their own."""
    model = ConeModel(damping_ratio=[0.0, 0.1, 0.2, 0.3], drive_frequency=[0.5, 0.6, 0.7, 0.8], film="taut")
    own = swings(3, outcome=np.array([4, 0, 0], dtype=np.int8))
    asked = record(
        monkeypatch, module, settled_swing=own,
        linear_response=lambda members, omega: SimpleNamespace(stroke=10.0 * omega),
    )  # fmt: skip
    options, shares = {"transient": 11.0, "patience": 12.0, "tolerance": 2e-9}, []
    states = numbers(4, 2, at=0.5)
    found = settled(model, states, **options, threads=5, progress=shares.append)
    ((search,), (linear,)) = asked.values()
    np.testing.assert_array_equal(search["states"], states[1:])
    assert search["members"].damping_ratio.tolist() == [0.1, 0.2, 0.3]
    assert {name: search[name] for name in options} == options
    assert (search["threads"], search["source"], search["only_extent"]) == (5, True, False)
    assert sum(shares) == 1.0
    search["progress"](1.0)
    assert sum(shares) == 1.5  # linear theory has the other half
    assert linear["model"].damping_ratio.tolist() == [0.2, 0.3]
    assert linear["frequencies"].tolist() == [[0.7], [0.8]]
    np.testing.assert_array_equal(found["linear_stroke"], [np.nan, np.nan, 7.0, 8.0])
    expected = {
        "stroke": own.highest - own.lowest, "lowest": own.lowest, "highest": own.highest, "mean": own.mean,
        "period": [2, 0, 4], "resting": [0, 1, 0],
        "harmonic_amplitude": np.abs(own.harmonics), "harmonic_phase": own.phases,
    }  # fmt: skip
    expected |= {name: own.source[:, list(MEANINGS).index(name)] for name in known_of(model.system)}
    for name, values in expected.items():
        np.testing.assert_allclose(found[name][1:], values, err_msg=name)
    assert {"current", "power", "apparent_power", "field"} <= expected.keys()
    assert found["harmonic"].values.tolist() == [1, 2, 3, 4]
    assert found["outcome"].values.tolist() == [Outcome.ERROR, 4, 0, 0]
    assert json.loads(found.attrs["options"]) == options


def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(integrations):
    settled(SMALL, (0.3, 0.0), tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2), (FIRST_TOLERANCE, 2)}
