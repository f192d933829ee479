"""Transfer functions: certified ones, signals that tend to them, and what is refused."""

import importlib
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome
from gelcone.motion.attractor.cycle import find_cycles
from gelcone.motion.settled import Swing
from gelcone.motion.state_space import state_space
from gelcone.motion.transfer import _amplitudes
from tests.recorded import numbers, record

transfer_module = importlib.import_module("gelcone.motion.transfer")

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
    monkeypatch.setattr(transfer_module, "find_cycles", elsewhere)
    found = gelcone.transfer(PUMP, ["6 Hz", "8 Hz"], **own)
    np.testing.assert_allclose(found["measured_gain"], expected["measured_gain"], rtol=1e-6)


def test_about_a_leaking_film_all_is_as_about_its_own_voltage():
    """A leak behind a resistance leaves the film a part of the bias, which an ideal source may have, too."""
    plain = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.1}
    behind = ConeModel(voltage_bias=0.6, series_resistance=1.0, leakage_time=4.0, **plain)
    found = gelcone.transfer(behind, [1.0], amplitudes=0.0)
    area = 1.0 + float(found["equilibrium_displacement"]) ** 2
    own = ConeModel(voltage_bias=0.6 / (1.0 + area / 4.0), **plain)
    alone = gelcone.transfer(own, [1.0], amplitudes=0.0)
    assert float(found["equilibrium_displacement"]) == pytest.approx(float(alone["equilibrium_displacement"]), rel=1e-9)
    swing = np.linalg.eigvals(gelcone.state_space(behind).A)
    swing = np.abs(swing[np.argmax(swing.imag)])  # a charge that does not follow stiffens it
    assert float(alone["natural_frequency"]) < float(found["natural_frequency"]) == pytest.approx(swing, rel=1e-9)


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
        (PUMP.replace(waveform="half_wave", voltage_offset="-500 V"), {}, "bias = 0"),
        (PUMP, {"amplitudes": [-5.0]}, "amplitudes: must be finite and not negative"),
        (PUMP, {"frequencies": [3.0, -5.0, 0.0]}, "frequencies: -5 Hz is among them; they must be positive and finite"),
        (PUMP, {"frequencies": []}, r"frequencies = \[\]: is empty; give at least one"),
        (PUMP.replace(frequency=[8.0, 9.0]), {}, "takes one actuator"),
        (PUMP.replace(damping_coefficient=0.0), {}, "damping_.* = 0: without damping"),
    ],
)
def test_what_has_no_transfer_function_is_refused(device, options, message):
    with pytest.raises(InputError, match=message):
        gelcone.transfer(device, **options)


@pytest.mark.parametrize("damping", [0.5, 0.05, 0.0025, 1e-5])
@pytest.mark.parametrize("given", [None, [0.5, 1.0, 4.0]])
def test_the_largest_gain_is_that_of_an_oscillator(damping, given):
    """With stiffness k: at the frequency sqrt(k - 2 zeta^2), where it is b/(2 zeta sqrt(k - zeta^2))."""
    model = ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=damping)
    found = gelcone.transfer(model, given, amplitudes=0.0)
    linear = state_space(model)
    stiffness, push = -linear.A[1, 0], linear.B[1, 0]
    largest = push / (2.0 * damping * np.sqrt(stiffness - damping**2))
    assert float(found["largest_gain"]) == pytest.approx(largest, rel=1e-8)
    assert float(found["resonance"]) == pytest.approx(np.sqrt(stiffness - 2.0 * damping**2), rel=1e-6)
    if given is None:
        assert float(found["gain"].max()) == pytest.approx(largest, rel=1e-8)
    else:
        assert found["drive_frequency"].values.tolist() == given


def test_a_gain_that_only_falls_is_largest_at_the_lowest_frequency():
    model = ConeModel(voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=3.0)
    found = gelcone.transfer(model, [0.5, 1.0], amplitudes=0.0)
    assert float(found["resonance"]) == 0.5
    assert float(found["largest_gain"]) == float(found["gain"][0]) == float(found["gain"].max())


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_transfer_functions_hold_what_theory_and_measurement_gave(monkeypatch):
    """About a bias of its own; the resonance is where the displacement is largest, not the current."""
    model = ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
    model = model.replace(series_resistance=0.8, leakage_time=8.0)
    space = state_space(model, voltage=0.5, outputs=("displacement", "charge", "leak"))
    space.place = 0.75
    omega = np.array([0.5, 1.0, 1.5])
    linear = np.exp(0.1j) * np.array([1.0, 5.0, 2.0]), np.exp(0.2j) * np.array([7.0, 3.0, 4.0]), np.zeros((3, 3))
    measured = (
        np.exp(0.3j) * numbers(2, 3, at=8.0),
        np.exp(0.4j) * numbers(2, 3, at=9.0),
        np.array([[0, 1, 2], [3, 4, 5]]),
    )
    asked = record(
        monkeypatch, transfer_module, state_space=space, natural_frequency=1.25, _linear=linear, _measured=measured,
        _largest_gain=(1.125, 6.0),
    )  # fmt: skip
    shares = []
    found = gelcone.transfer(
        model, omega, bias=-0.5, amplitudes=[0.2, 0.1], tolerance=2e-9, threads=5, progress=shares.append
    )
    (of_space,), (natural,), (signals,) = asked["state_space"], asked["natural_frequency"], asked["_measured"]
    assert (float(of_space["model"].voltage_bias), of_space["outputs"]) == (
        -0.5,
        ("displacement", "source_charge", "source_leak"),
    )
    assert natural["displacement"] == 0.75
    assert natural["voltage"] == 0.5  # commanded, whatever leaks behind the resistance
    assert (signals["signals"].tolist(), signals["progress"]) == ([0.1, 0.2], shares.append)
    assert signals["options"] == {"tolerance": 2e-9, "threads": 5}
    np.testing.assert_array_equal(signals["omega"], omega)
    for before, (x, i) in (("", linear[:2]), ("measured_", measured[:2])):
        np.testing.assert_allclose(found[f"{before}gain"], np.abs(x))
        np.testing.assert_allclose(found[f"{before}phase"], np.degrees(np.angle(x)))
        np.testing.assert_allclose(found[f"{before}admittance"], np.abs(i))
        np.testing.assert_allclose(found[f"{before}admittance_phase"], np.degrees(np.angle(i)))
    expected = {"bias_voltage": -0.5, "equilibrium_displacement": 0.75, "natural_frequency": 1.25, "resonance": 1.125}
    assert {name: float(found[name]) for name in expected} == expected
    assert float(found["largest_gain"]) == 6.0
    assert found["outcome"].values.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert found["measured_frequency"].values.tolist() == omega.tolist()
    assert json.loads(found.attrs["options"]) == {"bias": -0.5, "tolerance": 2e-9}


def test_by_default_each_tenth_frequency_within_the_measured_range_is_measured(monkeypatch):
    model = ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)

    def nothing(model, space, signals, omega, *given):
        return (np.zeros((signals.size, omega.size)),) * 3

    asked = record(monkeypatch, transfer_module, natural_frequency=2.0, _measured=nothing)
    monkeypatch.setattr(transfer_module, "POINTS", 141)
    found = gelcone.transfer(model)
    omega = 2.0 * np.geomspace(0.05, 10.0, 141)
    within = omega[(omega >= 0.4) & (omega <= 8.0)]
    near = transfer_module._with_resonances(state_space(model), omega)
    np.testing.assert_array_equal(found["drive_frequency"], np.union1d(near, found["resonance"]))
    np.testing.assert_array_equal(asked["_measured"][0]["omega"], within[::10])
    assert asked["_measured"][0]["signals"].tolist() == pytest.approx([0.02 * 0.6, 0.3])


def test_signals_start_on_the_linear_motion_and_are_measured_over_their_amplitude(monkeypatch):
    """At the second of two frequencies Newton's method finds a cycle of period 2 for the smaller signal alone; the
    others are searched, and the last of them does not settle."""
    model = ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
    space = state_space(model, voltage=0.6)
    linear = np.array([[0.1 + 0.2j, 0.3 + 0.4j], [0.5 + 0.6j, 0.7 + 0.8j]])
    cycles = SimpleNamespace(
        found=np.array([False, True, True, False]), sign=np.array([-1, -1, 1, -1]), period=np.array([1, 2, 1, 1]),
        point=numbers(4, 2, at=5.0),
    )  # fmt: skip

    def settling(members, states, **options):
        searched.append((members, states, options))
        found = Swing.blank(3)
        found.period[:], found.final[:], found.outcome[:] = [1, 1, 0], numbers(3, 2, at=6.0), [0, 0, 4]
        return found

    searched = []
    asked = record(
        monkeypatch, transfer_module, _linear=(None, None, linear), find_cycles=cycles, settled_swing=settling,
        _fundamentals=lambda members, states, period, **options: np.stack([states[:, 0] + 10.0 * period, states[:, 1]]),
    )  # fmt: skip
    options, signals, omega = {"tolerance": 2e-9, "threads": 5}, np.array([0.1, 0.2]), np.array([0.5, 1.0])
    x, i, outcome = transfer_module._measured(model.replace(voltage_bias=0.6), space, signals, omega, None, options)
    (newton,), (one, two) = asked["find_cycles"], asked["_fundamentals"]
    each = np.repeat(signals, 2)[:, None] * np.tile(linear.imag, (2, 1))
    np.testing.assert_allclose(newton["states"], np.array(space.rest) + each)
    assert newton["members"].number("voltage").tolist() == [0.1, 0.1, 0.2, 0.2]
    assert newton["members"].number("voltage_bias").tolist() == [0.6] * 4
    assert newton["members"].number("drive_frequency").tolist() == [0.5, 1.0, 0.5, 1.0]
    ((members, states, more),) = searched
    np.testing.assert_allclose(states, (np.array(space.rest) + each)[[0, 2, 3]])
    assert members.number("voltage").tolist() == [0.1, 0.2, 0.2]
    assert more == options | {"only_extent": True, "progress": None}
    for call in (newton, one, two):
        assert {name: call[name] for name in options} == options
    assert (one["period"], two["period"]) == (1, 2)
    first, cycle = numbers(3, 2, at=6.0), numbers(4, 2, at=5.0)[1]
    nan = np.nan + 0j
    np.testing.assert_allclose(
        x, [[(first[0, 0] + 10.0) / 0.1, (cycle[0] + 20.0) / 0.1], [(first[1, 0] + 10.0) / 0.2, nan]]
    )
    np.testing.assert_allclose(i, [[first[0, 1] / 0.1, cycle[1] / 0.1], [first[1, 1] / 0.2, nan]])
    assert outcome.tolist() == [[0, 0], [0, 4]]


def test_a_motion_of_odd_multiples_of_half_the_drive_has_no_gain(monkeypatch):
    """Its part at the drive frequency is rounding; what flows has one."""
    members = ConeModel(
        voltage=0.3, voltage_bias=0.6, rest_height=0.8, drive_frequency=1.5, damping_ratio=0.1
    ).members()
    samples = transfer_module.SAMPLES
    times = np.linspace(0.0, 8.0 * np.pi / 3.0, 2 * samples + 1)[None]
    path = np.stack([0.5 * np.sin(0.75 * times), 0.375 * np.cos(0.75 * times)], axis=-1)[:, 1:]
    monkeypatch.setattr(transfer_module, "sampled", lambda *given, **options: SimpleNamespace(times=times, path=path))
    x, current = transfer_module._fundamentals(members, path[:, -1], 2)
    assert np.isnan(x).all()
    assert np.abs(current).min() > 0.1


@pytest.mark.parametrize("circuit", [{}, {"leakage_time": 5.0}, {"series_resistance": 0.3, "leakage_time": 5.0}])
def test_one_source_charges_both_films_of_a_double_cone(circuit):
    """Midway between two flat heights 1.2 apart the disc stays: 1 + 0.6^2 for each film."""
    pair = {"second_film": "taut", "second_drive": "same", "second_flat_height": 1.2, "rest_height": 0.6}
    model = ConeModel(**pair, **circuit, voltage_bias=0.4, damping_ratio=0.3)
    middle = gelcone.transfer(model, [0.5, 1.0], amplitudes=0.0)
    rate = np.array([0.5j, 1.0j]) + (0.2 if "leakage_time" in circuit else 0.0)
    expected = 2.72 * rate / (1.0 + circuit.get("series_resistance", 0.0) * 2.72 * rate)
    np.testing.assert_allclose(middle["admittance"], abs(expected), rtol=1e-9)
    moving = gelcone.transfer(model.replace(rest_height=0.9, spring_stiffness=2.0), [0.5, 1.0], amplitudes=1e-4)
    np.testing.assert_allclose(moving["measured_admittance"][0], moving["admittance"], rtol=1e-6)
    assert moving["gain"].min() > 0.01
