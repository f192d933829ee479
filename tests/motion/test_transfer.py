"""Transfer functions: certified ones, signals that tend to them, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome
from gelcone.motion import transfer
from gelcone.motion.attractor.cycle import find_cycles
from gelcone.motion.state_space import state_space
from gelcone.motion.transfer import _amplitudes

CERTIFIED = json.loads((Path(__file__).parents[1] / "reference" / "viscous.json").read_text())["transfer"]
PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def model_of(case):
    given = {
        f"{name}_{k}": value
        for k, branch in enumerate(case["br"], 1)
        for name, value in zip(("viscous_modulus", "relaxation_time"), branch, strict=True)
    }
    if case["circ"]:
        given |= {"series_resistance": case["circ"]["rho"], "leakage_time": case["circ"]["leak_time"]}
    if "chi" in case["circ"]:
        given |= {"dielectric_share": case["circ"]["chi"], "dielectric_time": case["circ"]["debye_time"]}
    return ConeModel(
        meridional_prestretch=case["lm"],
        hoop_prestretch=case["lh"],
        stretch_limit=case["J"],
        damping_ratio=case["zeta"],
        spring_stiffness=case["kappa"],
        rest_height=case["x0"],
        voltage_bias=case["v0"],
        **given,
    )


def both(result, before=""):
    """Complex displacement and current over the voltage."""
    names = ((f"{before}gain", f"{before}phase"), (f"{before}admittance", f"{before}admittance_phase"))
    return [result[gain].values * np.exp(1j * np.radians(result[phase].values)) for gain, phase in names]


@pytest.mark.parametrize("which", [0, 1, 2])
def test_linear_theory_is_certified(which):
    rows = CERTIFIED[which]["rows"]
    found = gelcone.transfer(model_of(CERTIFIED[which]["case"]), [row["omega"] for row in rows], amplitudes=0.0)
    assert found["measured_gain"].size == 0
    for own, name in zip(both(found), ("gain", "admittance"), strict=True):
        np.testing.assert_allclose(own, [complex(*row[name]) for row in rows], atol=1e-10)


def test_signals_tend_to_linear_theory_as_their_squares():
    """Through a resistance and a leak, with three branches whose slowest takes 600 to relax."""
    model, omega = model_of(CERTIFIED[1]["case"]), [0.5, 1.6, 3.0]
    found = gelcone.transfer(model, omega, amplitudes=[0.01, 0.02, 0.04], tolerance=1e-10)
    assert (found["outcome"] == Outcome.OK).all()
    for linear, measured in zip(both(found), both(found, "measured_"), strict=True):
        errors = np.abs(measured / linear - 1.0)
        assert errors[0].max() < 2e-4
        np.testing.assert_allclose(errors[1:] / errors[:-1], 4.0, rtol=0.03)


def test_a_large_signal_is_the_settled_motion():
    found = gelcone.transfer(PUMP, ["8 Hz"], bias="1 kV", amplitudes="400 V", tolerance=1e-10)
    assert found["gain"].attrs["units"] == "mm/kV"
    assert found["admittance"].attrs["units"] == "uS"
    drive = {"voltage_offset": "1 kV", "voltage_amplitude": "400 V", "frequency": "8 Hz"}
    settled = gelcone.settled(PUMP.replace(drive), tolerance=1e-10)
    assert found["measured_gain"].item() == pytest.approx(float(settled["harmonic_amplitude"][0]) / 0.4, rel=1e-6)
    assert found["measured_phase"].item() == pytest.approx(float(settled["harmonic_phase"][0]), abs=1e-5)
    assert abs(found["measured_gain"].item() / found["gain"].item() - 1.0) > 0.01


def test_a_cycle_that_is_not_stable_is_not_measured(monkeypatch):
    """One that Newton's method found nearby; a run from the linear motion ends elsewhere."""

    def elsewhere(*arguments, **options):
        cycles = find_cycles(*arguments, **options)
        cycles.exponents[1], cycles.point[1] = [0.1, -0.3], [0.9, 0.2]
        return cycles

    own = {"amplitudes": "50 V", "bias": "1 kV", "tolerance": 1e-10}
    expected = gelcone.transfer(PUMP, ["6 Hz", "8 Hz"], **own)
    monkeypatch.setattr(transfer, "find_cycles", elsewhere)
    found = gelcone.transfer(PUMP, ["6 Hz", "8 Hz"], **own)
    np.testing.assert_allclose(found["measured_gain"], expected["measured_gain"], rtol=1e-6)


def test_about_a_leaking_film_all_is_as_about_its_own_voltage():
    """A leak behind a resistance leaves the film a part of the bias, which an ideal source may have, too."""
    plain = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.1}
    behind = ConeModel(voltage_bias=0.6, series_resistance=1.0, leakage_time=4.0, **plain)
    found = gelcone.transfer(behind, [1.0], amplitudes=0.0)
    area = 1.0 + float(found["equilibrium"]) ** 2
    own = ConeModel(voltage_bias=0.6 / (1.0 + area / 4.0), **plain)
    alone = gelcone.transfer(own, [1.0], amplitudes=0.0)
    assert float(found["equilibrium"]) == pytest.approx(float(alone["equilibrium"]), rel=1e-9)
    assert float(found["natural_frequency"]) == pytest.approx(float(alone["natural_frequency"]), rel=1e-2)


def test_signals_are_two_percent_of_the_bias_and_the_drive():
    assert _amplitudes(ConeModel(voltage=0.3), -0.6).tolist() == pytest.approx([0.012, 0.3])


def test_current_is_that_of_the_charge_and_of_the_leak():
    model = model_of(CERTIFIED[1]["case"])
    found = state_space(model, outputs=("charge", "leak", "current"))
    assert found.rest[0] == found.place
    for omega in (0.3, 4.0):
        solved = np.linalg.solve(1j * omega * np.eye(len(found.A)) - found.A, found.B)
        charge, leak, current = (found.C @ solved + found.D)[:, 0]
        assert current == pytest.approx(1j * omega * charge + leak, rel=1e-10)


def test_an_amplifier_within_its_limit_is_linear():
    """From a film without voltage it would be at its limit, where linear theory has no gain."""
    behind = PUMP.replace(series_resistance="1 MOhm")
    gains = [
        gelcone.transfer(device, ["5 Hz", "12 Hz"], amplitudes=0.0)["gain"].values
        for device in (behind, behind.replace(current_limit="0.02 mA"))
    ]
    np.testing.assert_allclose(gains[0], gains[1], rtol=1e-12)
    assert gains[0].min() > 0.5


@pytest.mark.parametrize(
    ("device", "options", "message"),
    [
        (PUMP.replace(voltage_offset=0.0), {}, "bias = 0"),
        (PUMP, {"amplitudes": [-5.0]}, "amplitudes: must be finite and not negative"),
        (PUMP, {"frequencies": [0.0]}, "frequencies: must be positive"),
        (PUMP.replace(frequency=[8.0, 9.0]), {}, "takes one actuator"),
        (PUMP.replace(damping_coefficient=0.0), {}, "damping_.* = 0: without damping"),
    ],
)
def test_what_has_no_transfer_function_is_refused(device, options, message):
    with pytest.raises(InputError, match=message):
        gelcone.transfer(device, **options)
