"""The data sheet: certified numbers, and the numbers of the analyses that it rests on."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import InputError
from gelcone.lab.datasheet import _drive, _rise_time, _static_numbers, _with_membrane, datasheet
from gelcone.motion.operating_limits import operating_limits

FIELDS = {
    "disc_radius": 0.008, "film_radius": 0.03, "film_thickness": 2e-4, "meridional_prestretch": 1.1,
    "hoop_prestretch": 1.4, "spring_rate": 15.0, "initial_height": 0.02, "moving_mass": 0.005,
    "damping_coefficient": 0.01, "voltage_offset": 1000.0, "voltage_amplitude": 300.0, "frequency": 8.0, "film": "taut",
}  # fmt: skip
GEL = {"material.shear_modulus": 8233.333, "material.stretch_limit": 50.0, "material.relative_permittivity": 6.05}
CERTIFIED = {
    # voltage: blocked force mN, stroke mm, stiffness N/m, work uJ, J/m^3, coupling, nF, uJ of the field, natural Hz
    1000.0: (18.29721, 0.7394698, 24.84569, 6.774559, 12.89718, 0.0591122, 0.9616485, 480.8242, 11.21917),
    1500.0: (41.16871, 1.784917, 23.28934, 36.8655, 70.18333, 0.1438609, 1.003742, 1129.209, 10.8621),
    1900.0: (66.05291, 3.109105, 21.59091, 103.2827, 196.6262, 0.2469588, 1.061619, 1916.221, 10.45853),
}
"""Of a taut pump, by closed forms of another program."""
NAMES = {
    "blocked_force": 1e3, "stroke": 1.0, "stiffness_at_rest": 1.0, "stroke_work": 1e3, "volume_work": 1.0,
    "coupling": 1.0, "capacitance": 1.0, "field_energy": 1e3, "natural_frequency": 1.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def pump():
    return gelcone.find_device("biased-pump").replace(GEL, **FIELDS)


@pytest.fixture(scope="module")
def still(pump):
    """The pump without a drive, whose sheet has neither limits nor a settled motion, which take longest."""
    return pump.replace(voltage_offset=0.0, voltage_amplitude=0.0)


@pytest.fixture(scope="module")
def sheet(pump):
    return datasheet(pump, list(CERTIFIED))


def test_the_numbers_are_the_certified_ones(sheet):
    for voltage, row in CERTIFIED.items():
        own = sheet.sel(constant_voltage=voltage)
        for (name, scale), value in zip(NAMES.items(), row, strict=True):
            assert float(own[name]) * scale == pytest.approx(value, rel=5e-7), (voltage, name)
    assert float(sheet["rest_displacement"]) == pytest.approx(12.58925, rel=5e-7)
    assert float(sheet["stiffness_at_rest"][0]) == pytest.approx(26.09184, rel=5e-7)


def test_the_largest_work_on_a_constant_load_is_a_largest_one(sheet):
    """At least that of a search over a grid by another program, and close to it; nearly a quarter of force x stroke."""
    work = 1e3 * sheet["load_work"].values[1:]
    np.testing.assert_allclose(work, [3.389591, 18.46378, 51.792], rtol=2e-5)
    assert (work >= np.array([3.389591, 18.46378, 51.792]) * (1.0 - 1e-7)).all()
    quarter = 0.25e3 * (sheet["blocked_force"] * sheet["stroke"]).values[1:]
    np.testing.assert_allclose(work, quarter, rtol=0.02)


def test_energy_balances_over_a_small_cycle(sheet, still):
    """What the free film takes more charge than the held one, at neighbouring voltages, is the coupling."""
    around = datasheet(still, [1499.0, 1501.0])
    charge = around["capacitance"].values * around["constant_voltage"].values
    held, free = float(sheet.sel(constant_voltage=1500.0)["capacitance"]), (charge[2] - charge[1]) / 2.0
    assert 1.0 - held / free == pytest.approx(float(sheet.sel(constant_voltage=1500.0)["coupling"]), rel=1e-4)


def test_work_over_mass_and_volume_are_the_work(sheet, pump):
    volume = np.pi * (0.03**2 - 0.008**2) * 2e-4
    work = 1e-3 * sheet["stroke_work"].values
    np.testing.assert_allclose(sheet["volume_work"].values, work / volume, rtol=1e-12)
    np.testing.assert_allclose(sheet["mass_work"].values, 1e3 * work / 0.005, rtol=1e-12)
    hertz = sheet["natural_frequency"].values
    np.testing.assert_allclose(sheet["volume_power"].values, work / volume * hertz, rtol=1e-12)
    np.testing.assert_allclose(sheet["mass_power"].values, 1e3 * work / 0.005 * hertz, rtol=1e-12)


def test_the_energy_of_the_field_is_that_of_the_voltage_which_a_leaking_film_has_behind_a_resistance(still):
    resistance, resistivity = 2e7, 1e9
    leaking = still.replace({"series_resistance": resistance, "material.resistivity": resistivity})
    model, scales = leaking.to_model(), leaking.scales
    commanded = 1500.0 / scales.voltage
    found = _static_numbers(model, gelcone.static(model, [0.0, commanded]))
    capacitance, energy = found["capacitance"][1][1], found["field_energy"][1][1]
    decay = resistivity * GEL["material.relative_permittivity"] * 8.8541878e-12  # s, in which its charge leaks away
    voltage = commanded / (1.0 + resistance * capacitance * scales.size("capacitance") / decay)
    assert voltage < 0.8 * commanded
    assert energy == pytest.approx(0.5 * capacitance * voltage**2, rel=1e-7)


def test_small_signals_are_those_of_a_damped_oscillator(sheet):
    """With a taut film and the ideal source: half width c/(2 m), bandwidth and rise time in closed form."""
    own = sheet.sel(constant_voltage=1500.0)
    natural, width = 10.8621, 0.01 / (2.0 * 0.005) / (2.0 * np.pi)
    assert float(own["half_width"]) == pytest.approx(width, rel=1e-6)
    z2 = (width / natural) ** 2
    edge = natural * np.sqrt(1.0 - 2.0 * z2 + np.sqrt((1.0 - 2.0 * z2) ** 2 + 1.0))
    assert float(own["bandwidth"]) == pytest.approx(edge, rel=1e-5)
    t = np.linspace(0.0, 0.05, 200001)
    omega, decay = 2.0 * np.pi * natural, 2.0 * np.pi * width
    swing = np.sqrt(omega**2 - decay**2)
    step = 1.0 - np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t))
    rise = t[np.argmax(step >= 0.9)] - t[np.argmax(step >= 0.1)]
    assert float(own["rise_time"]) == pytest.approx(1e3 * rise, rel=2e-3)
    gain = sheet["gain"].sel(constant_voltage=1500.0)
    f = sheet["drive_frequency"].values
    expected = natural**2 / np.hypot(natural**2 - f**2, 2.0 * width * f)
    np.testing.assert_allclose(gain.values, expected, rtol=1e-4)


def test_limits_and_statics_are_those_of_their_analyses(sheet, pump):
    """Asked from two places, one answer."""
    limits = operating_limits(pump)
    for name in limits.data_vars:
        if str(name).endswith("_voltage"):
            assert float(sheet[name]) == pytest.approx(float(limits[name]), rel=1e-12, nan_ok=True)
    lowest = min(float(v) for n, v in limits.items() if n not in NOT_LIMITS and np.isfinite(v))
    assert float(sheet["first_limit_voltage"]) == lowest
    first = sheet.attrs["first_limit"].replace(" ", "_").replace("-", "_")
    assert float(limits[f"{first}_voltage"]) == lowest
    ramp = gelcone.stroke_and_blocked_force(pump, list(CERTIFIED))
    np.testing.assert_allclose(sheet["stroke"].values[1:], ramp["stroke"].values, rtol=1e-12)


NOT_LIMITS = ("safe_peak_voltage", "examined_voltage", "examined_step_voltage", "driven_error_voltage", "outcome")


def test_the_drive_is_that_of_a_run(sheet, pump):
    run = gelcone.simulate(pump, times=np.linspace(0.0, 40.0, 80001))
    late = run.isel(time=slice(-10000, None))
    assert float(sheet["drive_stroke"]) == pytest.approx(float(np.ptp(late["displacement"].values)), rel=1e-3)
    assert float(sheet["peak_current"]) == pytest.approx(float(np.abs(late["current"]).max()), rel=2e-3)
    rms = [np.sqrt(np.mean(late[name].values ** 2)) for name in ("drive_voltage", "current")]
    assert float(sheet["apparent_power"]) == pytest.approx(rms[0] * rms[1], rel=5e-3)
    assert float(sheet["mean_power"]) == pytest.approx(power_of(late), rel=5e-3)


def test_a_drive_under_which_rest_is_unstable_has_the_stroke_of_the_motion_that_leaves_it():
    model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5, voltage=0.65, damping_ratio=0.05)
    stroke = float(gelcone.settled(model, (0.05, 0.0))["stroke"])
    assert stroke > 0.1
    assert _drive(model, None)["drive_stroke"][1] == pytest.approx(stroke, rel=1e-6)


def test_a_drive_whose_motion_does_not_repeat_has_no_stroke():
    """That of another run is another one; of a disc that comes to rest it is 0."""
    chaotic = gelcone.ConeModel(damping_ratio=0.01, spring_stiffness=0.5, drive_frequency=0.3, voltage=1.15)
    assert int(gelcone.settled(chaotic, (0.05, 0.0))["period"]) == 0
    assert np.isnan(_drive(chaotic, None)["drive_stroke"][1])
    at_rest = chaotic.replace(voltage=0.1, damping_ratio=0.2)
    assert abs(_drive(at_rest, None)["drive_stroke"][1]) < 1e-9


def test_the_rise_time_is_that_of_the_exact_step_response():
    """One pole, ln 9 over its rate; and an oscillator that a slow state barely lifts: 1.02 is its final height."""
    decay = SimpleNamespace(A=np.array([[-3.0]]), B=np.array([[3.0]]), C=np.array([[1.0]]))
    assert _rise_time(decay, np.array([-3.0])) == pytest.approx(np.log(9.0) / 3.0, rel=1e-3)
    swing = np.array([[0.0, 1.0, 0.0], [-1.0, -0.2, 0.0], [0.0, 0.0, -1e-3]])
    slow = SimpleNamespace(A=swing, B=np.array([[0.0], [1.0], [1e-3]]), C=np.array([[1.0, 0.0, 0.02]]))
    rate = np.sqrt(0.99)
    times = np.linspace(0.0, 3.0, 30001)
    height = 1.0 - np.exp(-0.1 * times) * (np.cos(rate * times) + 0.1 / rate * np.sin(rate * times))
    height += 0.02 * (1.0 - np.exp(-1e-3 * times))
    begin, end = (times[np.argmax(height >= share * 1.02)] for share in (0.1, 0.9))
    assert _rise_time(slow, np.linalg.eigvals(swing)) == pytest.approx(end - begin, rel=1e-3)


@pytest.mark.parametrize(("growth", "known"), [((-3.0, -5.0), True), ((-3.0, 0.5), False), ((1.0, 0.5), False)])
def test_an_unstable_state_has_no_rise_time(growth, known):
    """One growing motion of two is enough."""
    states = SimpleNamespace(A=np.diag(growth), B=np.ones((2, 1)), C=np.ones((1, 2)))
    assert np.isfinite(_rise_time(states, np.array(growth, dtype=complex))) == known


def power_of(run):
    lost, time = run["dissipated_energy"].values, run["time"].values
    return 1e3 * (lost[-1] - lost[0]) / (time[-1] - time[0])


def test_a_device_without_a_drive_has_statics_alone(still):
    found = datasheet(still, [1500.0])
    assert found["apparent_power"].isnull()
    assert "first_limit_voltage" not in found
    assert found.attrs["first_limit"] == "not asked: the device has no drive"
    assert float(found["blocked_force"][1]) == pytest.approx(0.04116871, rel=1e-6)


@pytest.mark.parametrize(("drive", "words"), [("same", ""), ("opposite", ", at the actuator's bias")])
def test_the_pull_in_of_the_membrane_says_at_which_bias_it_holds(drive, words):
    pair = {"second_film": "wrinkling", "second_drive": drive, "second_flat_height": 1.0}
    cone = gelcone.ConeModel(film="wrinkling", rest_height=0.9, damping_ratio=0.3, voltage=0.0, **pair)
    said = _with_membrane(xr.Dataset(), cone)["membrane_pull_in_voltage"].attrs["long_name"]
    assert said == f"constant voltage at which the disc jumps or the film pulls in{words}, of the membrane"


def test_beyond_pull_in_there_are_words_and_no_numbers(still):
    slack = still.replace(film="wrinkling", hoop_prestretch=1.0, spring_rate=3.0)
    highest = float(gelcone.pull_in_voltage(slack)["pull_in_voltage"])
    assert np.isfinite(highest)
    found = datasheet(slack, [0.5 * highest, 1.1 * highest])
    assert np.isfinite(found["stroke_work"].values[1])
    assert np.isnan(found["stroke_work"].values[2])
    assert found["stroke_work"].attrs["nan_means"] == "beyond pull-in"


@pytest.mark.parametrize(("hoop", "voltage"), [(1.0, 600.0), (1.0, 1400.0), (1.1, 1500.0)])
def test_a_film_that_wrinkles_balances_its_energy_too(hoop, voltage, still):
    """The charge of the held film does not grow with the voltage in proportion."""
    slack = still.replace(film="wrinkling", hoop_prestretch=hoop)
    found = datasheet(slack, [voltage - 1.0, voltage, voltage + 1.0])
    charge = found["capacitance"].values * found["constant_voltage"].values
    gain = -np.gradient(held_forces(slack, voltage), 0.5)[1]
    expected = gain**2 / float(found["stiffness_at_rest"][2])  # (N/V)^2/(N/m) = F
    free = 1e-9 * (charge[3] - charge[1]) / 2.0
    assert expected / free == pytest.approx(float(found["coupling"][2]), rel=2e-3)


def held_forces(device, voltage):
    """Forces in N at the rest under a voltage, held there at neighbouring voltages."""
    rest = gelcone.stroke_and_blocked_force(device, [voltage])["displacement"].values
    volts = [voltage - 0.5, voltage, voltage + 0.5]
    return gelcone.static(device, volts, 1e-3 * np.array([rest[0], rest[0] + 1.0]))["force"].values[:, 0]


def test_what_is_refused():
    model = gelcone.ConeModel(rest_height=0.3)
    with pytest.raises(InputError, match="takes one actuator, not an ensemble of 2"):
        datasheet(model.replace(voltage=[0.1, 0.2]))


def test_of_two_films_the_charge_is_not_known(still):
    found = datasheet(still.replace(second_film="taut", second_flat_height=0.03), [1000.0])
    assert np.isfinite(found["stroke_work"].values[1])
    assert np.isnan(found["coupling"].values).all()


def test_a_film_that_creeps_has_the_statics_of_the_relaxed_one(still, sheet):
    gel = {"material.viscous_modulus_1": 8e3, "material.relaxation_time_1": 0.05}
    found = datasheet(still.replace(gel), [1500.0])
    relaxed = sheet.sel(constant_voltage=1500.0)
    for name in ("stroke_work", "coupling", "capacitance"):
        assert float(found[name][1]) == pytest.approx(float(relaxed[name]), rel=1e-9)
    assert float(found["half_width"][1]) > 2.0 * float(relaxed["half_width"])
    assert float(found["rise_time"][1]) > float(relaxed["rise_time"])


def test_films_in_opposite_phase_have_their_resonance_where_the_sheet_has_the_disc(pump, monkeypatch):
    """The small signal is about the rest with 2 v0 - v on the second film; it was about v on both: 13.9 Hz."""
    monkeypatch.setattr(importlib.import_module("gelcone.lab.datasheet"), "_with_limits", lambda found, *given: found)
    films = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 0.03}
    found = datasheet(pump.replace(films, voltage_offset=1500.0, damping_coefficient=0.002), [300.0])
    resonance = float(found.drive_frequency[int(found.gain[1].values.argmax())])
    assert resonance == pytest.approx(float(found.natural_frequency[1]), abs=float(found.drive_frequency[0]))
    assert float(found.natural_frequency[1]) == pytest.approx(11.78, rel=1e-3)


def test_the_rest_of_films_in_opposite_phase_is_that_without_voltage_on_any():
    """Where 0 on the first film is beyond pull-in, with twice the bias on the second."""
    films = {"film": "taut", "second_film": "taut", "second_flat_height": 1.5, "law": "neo-hookean", "rest_height": 0.0}
    model = gelcone.ConeModel(**films, spring_stiffness=0.0, second_drive="opposite", voltage_bias=0.8)
    levels = [0.0, 0.8, 0.9]
    found = _static_numbers(model, gelcone.static(model, levels))
    off = gelcone.static(model.replace(voltage_bias=0.0), levels)
    stiffness = found["stiffness_at_rest"][1]
    assert stiffness[0] == pytest.approx(off["slope"].values[0, 0])
    assert np.signbit(found["load_work"][1][1:]).tolist() == [False, False]
