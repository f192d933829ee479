"""What a device predicts of its tests, against another program and against the settled motion."""

import importlib

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import InputError
from gelcone.lab.bench import KINDS, DeviceTest, Variants, field_value, rows_read
from gelcone.lab.periodic import balanced, linear_motion
from tests.lab.certified import CERTIFIED, device, made

datasheet_module = importlib.import_module("gelcone.lab.datasheet")


def alone(own):
    return Variants(own, ["spring_rate"], np.ones((1, 1)), {})


@pytest.mark.parametrize("case", CERTIFIED["forward"], ids=lambda case: case["film"])
def test_statics_and_ring_down_are_the_certified_ones(case):
    variants = alone(device(case["device"], case["film"]))
    for test in map(made, case["tests"]):
        if test.kind != "frequency response":
            np.testing.assert_allclose(variants.predict(test)[0], test.values, rtol=1e-10)


@pytest.mark.parametrize("case", CERTIFIED["responses"], ids=lambda r: f"{r['film']}-{r['voltage_offset_V']:g}")
def test_responses_are_those_of_the_settled_motion(case):
    """Within 0.5 % across the border where the film turns slack, where linear theory is up to 17 % off."""
    variants, frequency = alone(device(case["device"], case["film"])), np.array(case["frequency_Hz"])
    n = frequency.size
    volts = [np.full(n, case[f"voltage_{name}_V"]) for name in ("offset", "amplitude")]
    found = variants.response(*volts, frequency)[0]
    ratio = np.hypot(found[:n], found[n:]) / np.array(case["settled_amplitude_m"])
    np.testing.assert_allclose(ratio, 1.0, atol=5e-3)
    phase = np.degrees(np.arctan2(found[n:], found[:n]))
    apart = (phase - np.array(case["settled_phase_deg"]) + 180.0) % 360.0 - 180.0
    assert np.abs(apart).max() < 1.0


def test_the_response_is_that_of_settled():
    own = device(CERTIFIED["responses"][0]["device"], "taut").replace(
        voltage_offset=1000.0, voltage_amplitude=60.0, frequency=9.0
    )
    settled = gelcone.settled(own)
    found = alone(own).response(np.array([1000.0]), np.array([60.0]), np.array([9.0]))[0]
    assert 2e3 * np.hypot(*found) == pytest.approx(float(settled["stroke"]), rel=2e-3)


def test_variants_are_predicted_together_as_alone():
    own = device(CERTIFIED["forward"][1]["device"], "wrinkling")
    factors = np.array([[1.0, 1.0], [1.03, 0.97], [0.98, 1.1]])
    together = Variants(own, ["spring_rate", "film_thickness"], factors, {"amplifier": np.array([1.0, 1.01, 0.99])})
    near = Variants(own, ["spring_rate", "film_thickness"], factors[:1], {})
    for test in map(made, CERTIFIED["forward"][1]["tests"]):
        near.predict(test)
    started = Variants(own, ["spring_rate", "film_thickness"], factors[:1] * 1.001, {}, near)
    for test in map(made, CERTIFIED["forward"][1]["tests"]):
        found = together.predict(test)
        for k, row in enumerate(factors):
            gain = {"amplifier": np.array([[1.0, 1.01, 0.99][k]])}
            single = Variants(own, ["spring_rate", "film_thickness"], row[None], gain).predict(test)
            np.testing.assert_allclose(found[k], single[0], rtol=1e-9)
        fresh = Variants(own, ["spring_rate", "film_thickness"], factors[:1] * 1.001, {}).predict(test)
        np.testing.assert_allclose(started.predict(test), fresh, rtol=1e-8, atol=1e-12)


def test_gains_multiply_what_their_instrument_reads():
    own = device(CERTIFIED["forward"][0]["device"], "taut")
    force, stroke, *_ = map(made, CERTIFIED["forward"][0]["tests"])
    gains = {"load cell": np.array([1.1]), "laser": np.array([0.9]), "amplifier": np.array([1.0])}
    with_gains, without = Variants(own, ["spring_rate"], np.ones((1, 1)), gains), alone(own)
    np.testing.assert_allclose(with_gains.predict(force), 1.1 * without.predict(force))
    np.testing.assert_allclose(with_gains.predict(stroke), 0.9 * without.predict(stroke))
    meter = Variants(own, ["spring_rate"], np.ones((1, 1)), {"capacitance meter": np.array([1.2])})
    held = {"height": np.array([0.01, 0.02]), "voltage": np.array([0.0, 500.0])}
    np.testing.assert_allclose(meter.capacitance(**held), 1.2 * without.capacitance(**held))


def test_beyond_pull_in_there_is_nothing():
    own = device(CERTIFIED["forward"][1]["device"], "wrinkling")
    highest = float(gelcone.pull_in_voltage(own)["pull_in_voltage"])
    found = alone(own).stroke(np.array([0.9, 1.1]) * highest)[0]
    assert np.isfinite(found[0])
    assert np.isnan(found[1])
    turned = alone(own).stroke(np.array([1.1, 0.9]) * highest)[0]
    assert np.isnan(turned[0])
    assert turned[1] == pytest.approx(found[0])


def test_fields_that_cannot_be_fitted():
    own = device(CERTIFIED["forward"][0]["device"], "taut")
    with pytest.raises(InputError, match="'sprig_rate' is not a field that can be fitted; did you mean 'spring_rate'"):
        field_value(own, "sprig_rate")
    with pytest.raises(InputError, match=r"^free beam_rate: is not set; a field that is fitted must have one value"):
        field_value(own, "beam_rate")
    with pytest.raises(InputError, match=r"^free material\.young_modulus: a device has material.shear_modulus"):
        field_value(own.replace({"material.young_modulus": "45 kPa"}), "material.young_modulus")
    for changes, message in (
        ({"second_film": "taut", "second_drive": "opposite"}, "second_drive is 'opposite'; leave it out"),
        ({"circuit": "charge"}, "circuit is 'charge'; leave it out"),
    ):
        with pytest.raises(InputError, match=message):
            alone(own.replace(changes))


CREEP = {"material.viscous_modulus_1": 2000.0, "material.relaxation_time_1": 0.02}
STATES = {
    "creep": CREEP,
    "slack creep": {**CREEP, "hoop_prestretch": 1.0},
    "amplifier": {"circuit": "amplifier"},
    "creep, amplifier": {**CREEP, "circuit": "amplifier"},
    "double": {"second_film": "wrinkling"},
}


@pytest.mark.parametrize("kind", STATES)
def test_with_states_of_films_and_circuits_responses_ring_downs_and_series_are_those_of_the_analyses(kind):
    own = gelcone.find_device("biased-pump").replace(
        {**STATES[kind], "voltage_offset": 1e3, "voltage_amplitude": 60.0, "frequency": 8.0, "film": "wrinkling"}
    )
    variants = alone(own)
    found = variants.response(np.array([1e3]), np.array([60.0]), np.array([8.0]))[0]
    assert 2e3 * np.hypot(*found) == pytest.approx(float(gelcone.settled(own)["stroke"]), rel=2e-3)
    swing = np.linalg.eigvals(gelcone.state_space(own, voltage=0.0).A)
    swing = swing[np.argmax(swing.imag)]
    np.testing.assert_allclose(variants.ring_down()[0], [swing.imag / (2.0 * np.pi), -swing.real], rtol=1e-5)
    values = np.linalg.eigvals(gelcone.state_space(own, voltage=1e3).A)
    natural = np.abs(values[np.argmax(values.imag)]) / (2.0 * np.pi)
    assert variants.natural_frequency(1e3)[0] == pytest.approx(natural, rel=1e-6)
    model, scales = own.to_model(), own.scales
    levels, stroke = [1e3 / scales.voltage], variants.stroke(np.array([1e3]))[0] / scales.length
    rest = xr.Dataset(
        {"stroke": ("constant_voltage", stroke), "rest_displacement": variants.rest[0, 0]},
        {"constant_voltage": levels},
    )
    sheet = datasheet_module._dynamic_numbers(model, rest)
    assert sheet["natural_frequency"][1] * scales.frequency == pytest.approx([natural], rel=1e-6)


@pytest.mark.parametrize("kind", ["creep", "amplifier", "double"])
def test_a_series_is_the_run_of_a_recorded_drive(kind, tmp_path):
    own = gelcone.find_device("biased-pump").replace({**STATES[kind], "film": "taut"})
    time, volts = np.linspace(0.0, 0.2, 41), 900.0 * np.minimum(np.linspace(0.0, 2.0, 41), 1.0)
    rows = "\n".join(f"{t:.17g},{v:.17g}" for t, v in zip(time, volts, strict=True))
    (tmp_path / "drive.csv").write_text(f"time (s),voltage (V)\n{rows}\n")
    run = gelcone.simulate(gelcone.recorded(own, tmp_path / "drive.csv"), times=time.tolist())
    stroke, current = np.split(alone(own).series(time + 7.0, volts, ("stroke", "current"))[0], 2)
    measured = 1e-3 * (run["displacement"] - run["displacement"][0]).values
    np.testing.assert_allclose(stroke, measured, atol=1e-7 * np.abs(measured).max())
    known = 1e-3 * sum(run[name] for name in ("current", "second_current") if name in run).values
    inside = [k for k in range(1, 40) if k != 20]  # where the slope of the voltage does not jump
    np.testing.assert_allclose(current[inside], known[inside], rtol=1e-6, atol=1e-6 * np.abs(known).max())
    assert np.abs(current).max() > 1e-6


FILMS = ["taut", "wrinkling", "membrane"]


@pytest.mark.parametrize("film", FILMS)
def test_statics_responses_and_capacitances_of_a_film_are_those_of_its_analyses(film):
    """Also of the membrane, which is the film of a device."""
    own = gelcone.find_device("biased-pump").replace(
        film=film, voltage_offset=1e3, voltage_amplitude=60.0, frequency=8.0
    )
    variants, volts = alone(own), [500.0, 1500.0]
    found = gelcone.static(own, volts)["stroke"].values
    np.testing.assert_allclose(1e3 * variants.stroke(np.array(volts))[0], found, rtol=1e-6)
    swing = np.hypot(*variants.response(np.array([1e3]), np.array([60.0]), np.array([8.0]))[0])
    assert 2e3 * swing == pytest.approx(float(gelcone.settled(own)["stroke"]), rel=1e-3)
    height = 0.015
    model, scales = own.to_model(), own.scales
    known = model.film.capacitance(height / scales.length, (1.5e3 / scales.voltage) ** 2, [], model.numbers())
    measured = variants.capacitance(np.array([height]), np.array([1.5e3]))[0, 0]
    assert measured == pytest.approx(float(known) * scales.size("capacitance"), rel=1e-12)


def test_a_stroke_under_a_load_is_that_of_a_device_with_a_constant_force():
    own = gelcone.find_device("biased-pump").replace(film="taut")
    found = alone(own).loaded_stroke(np.array([0.0, 0.03]), np.array([1.5e3, 1.5e3]))[0]
    for load, stroke in zip((0.0, 0.03), found, strict=True):
        pulled = own.replace(constant_force=-load) if load else own
        assert 1e3 * stroke == pytest.approx(float(gelcone.static(pulled, [1.5e3])["stroke"][0]), rel=1e-6)


TAUT = gelcone.find_device("biased-pump").replace(film="taut")


def with_gains(own=TAUT, **gains):
    return Variants(own, ["spring_rate"], np.ones((1, 1)), {name: np.array([gain]) for name, gain in gains.items()})


def test_each_variant_rings_down_with_its_own_damping_and_mass():
    """c/(2 m) of a damping coefficient that is given; a heavier disc swings slower."""
    factors = np.array([[1.0, 1.0], [2.0, 1.0], [1.0, 3.0]])
    found = Variants(TAUT, ["moving_mass", "damping_coefficient"], factors, {}).ring_down()
    decay = TAUT.damping_coefficient / (2.0 * TAUT.moving_mass)
    np.testing.assert_allclose(found[:, 1], decay * np.array([1.0, 0.5, 3.0]))
    swings = np.sqrt((2.0 * np.pi * found[:, 0]) ** 2 + found[:, 1] ** 2)
    np.testing.assert_allclose(swings / swings[0], [1.0, np.sqrt(0.5), 1.0])


def test_the_amplifiers_gain_is_on_what_is_commanded_and_the_others_on_what_is_read():
    plain, volts = with_gains(), np.array([500.0, 1200.0])
    louder = with_gains(amplifier=1.1)
    np.testing.assert_allclose(louder.stroke(volts), plain.stroke(1.1 * volts), rtol=1e-9)
    held = np.array([0.012, 0.015])
    np.testing.assert_allclose(louder.blocked_force(held, volts), plain.blocked_force(held, 1.1 * volts))
    np.testing.assert_allclose(louder.loaded_stroke(held, volts), plain.loaded_stroke(held, 1.1 * volts), rtol=1e-9)
    drive = np.array([1e3]), np.array([60.0]), np.array([8.0])
    np.testing.assert_allclose(
        louder.response(*drive), plain.response(1.1 * drive[0], 1.1 * drive[1], drive[2]), rtol=1e-8
    )
    lasers = with_gains(laser=0.9)
    np.testing.assert_allclose(lasers.response(*drive), 0.9 * plain.response(*drive), rtol=1e-12)
    np.testing.assert_allclose(lasers.loaded_stroke(held, volts), 0.9 * plain.loaded_stroke(held, volts), rtol=1e-12)
    np.testing.assert_allclose(lasers.ring_down(), plain.ring_down())
    assert lasers.natural_frequency(1e3)[0] == pytest.approx(plain.natural_frequency(1e3)[0], rel=1e-12)


def test_a_series_reads_laser_and_ammeter_and_knows_either_sign():
    time, volts = np.linspace(0.0, 0.05, 11), 900.0 * np.minimum(np.linspace(0.0, 2.0, 11), 1.0)
    names = ("stroke", "current")
    plain = np.split(with_gains().series(time, volts, names)[0], 2)
    read = np.split(with_gains(laser=0.9, ammeter=1.2).series(time, volts, names)[0], 2)
    np.testing.assert_allclose(read[0], 0.9 * plain[0], rtol=1e-12)
    np.testing.assert_allclose(read[1], 1.2 * plain[1], rtol=1e-12)
    louder, raised = with_gains(amplifier=1.1).series(time, volts, names), with_gains().series(time, 1.1 * volts, names)
    np.testing.assert_allclose(louder, raised, rtol=1e-8, atol=1e-15)
    stroke, current = np.split(with_gains().series(time, -volts, names)[0], 2)
    np.testing.assert_allclose(stroke, plain[0], rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(current, -plain[1], rtol=1e-8, atol=1e-15)
    np.testing.assert_array_equal(with_gains().series(time, volts, ("current",))[0], plain[1])
    np.testing.assert_allclose(with_gains().series(time, 0.0 * volts)[0], 0.0, atol=1e-12)


def test_at_a_corner_of_the_voltage_the_current_is_the_mean_of_both_sides():
    """Up to the corner a ramp that ends there is one that continues, whose current has no jump: C dV/dt."""
    time, names, variants = np.linspace(0.0, 0.05, 11), ("stroke", "current"), with_gains()
    whole = 900.0 * np.linspace(0.0, 2.0, 11)
    both = [variants.series(time, volts, names)[0] for volts in (whole, np.minimum(whole, 900.0))]
    (stroke, through), (same, mean) = ((one[5], one[16]) for one in both)
    assert same == pytest.approx(stroke, rel=1e-6)
    height = variants.rest[0] * variants.scale("length")[0] + stroke
    jump = float(variants.capacitance(height, np.array([900.0]))[0, 0]) * 900.0 / time[5]
    assert through - mean == pytest.approx(0.5 * jump, rel=1e-5)


def test_a_ramp_takes_its_voltages_in_the_order_of_their_size():
    volts = np.array([1500.0, -500.0, 1000.0])
    ordered = with_gains().stroke(np.array([500.0, 1000.0, 1500.0]))[0]
    np.testing.assert_allclose(with_gains().stroke(volts)[0], ordered[[2, 0, 1]], rtol=1e-9)


@pytest.mark.parametrize("drive", ["same", "constant"])
def test_the_capacitance_is_that_of_all_films_that_the_source_charges(drive):
    pair = TAUT.replace(second_film="taut", second_drive=drive, second_flat_height="25 mm")
    at = np.array([0.01]), np.array([500.0])
    alone = with_gains().capacitance(*at)
    other = with_gains().capacitance(np.array([0.015]), at[1]) if drive == "same" else 0.0
    np.testing.assert_allclose(with_gains(pair).capacitance(*at), alone + other, rtol=1e-12)


def test_every_kind_of_test_reaches_its_prediction(monkeypatch):
    """What is set by name, the test itself as the key of its states, and the readings of a series."""
    variants = with_gains()
    seen = []
    for name in ("blocked_force", "stroke", "loaded_stroke", "capacitance", "series", "response", "ring_down"):
        monkeypatch.setattr(variants, name, lambda name=name, **given: seen.append((name, given)) or name)
    ways = {
        "blocked force": "blocked_force", "stroke over voltage": "stroke", "stroke over load": "loaded_stroke",
        "capacitance": "capacitance", "series": "series", "frequency response": "response", "ring-down": "ring_down",
    }  # fmt: skip
    assert set(ways) == set(KINDS)
    for kind, name in ways.items():
        numbers = {own: np.array([float(k)]) for k, own in enumerate(KINDS[kind].set)}
        test = DeviceTest("t", kind, numbers, dict.fromkeys(KINDS[kind].read, np.zeros(1)), {})
        assert variants.predict(test) == name
        (_, given) = seen.pop()
        more = {"stroke": {"key": test}, "loaded_stroke": {"key": test}, "response": {"key": test}}
        more["series"] = {"names": ("stroke", "current")}
        assert given == {**numbers, **more.get(name, {})} if name != "ring_down" else given == {"rows": 1}


def test_readings_of_a_test_stand_in_a_row_with_their_noise_units_and_instruments():
    read = {"stroke": np.array([1.0, 2.0]), "current": np.array([3.0, 4.0])}
    noise = {"current": np.array([0.3, 0.4]), "stroke": np.array([0.1, 0.2])}
    test = DeviceTest("t", "series", {}, read, noise)
    assert test.values.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert test.deviations.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert test.readings == [("m", "laser"), ("m", "laser"), ("A", "ammeter"), ("A", "ammeter")]
    assert [rows_read(rows).step for rows in (1, 500, 501, 1000, 1001)] == [1, 1, 2, 2, 3]


@pytest.mark.parametrize("changes", [{}, {"circuit": "amplifier"}, CREEP])
def test_a_film_that_pulls_in_within_a_period_has_no_response_and_no_settled_motion(changes):
    """With states of films and circuits and without."""
    own = gelcone.find_device("biased-pump").replace({**changes, "film": "wrinkling"})
    offset, amplitude = np.array([1700.0, 2200.0]), np.array([400.0, 600.0])
    found = alone(own).response(offset, amplitude, np.full(2, 8.0))[0]
    stroke = 2e3 * np.hypot(found[:2], found[2:])
    driven = [own.replace(voltage_offset=v, voltage_amplitude=a) for v, a in zip(offset, amplitude, strict=True)]
    settled = [gelcone.settled(one.replace(frequency=8.0)) for one in driven]
    assert [int(one["outcome"]) for one in settled] == [gelcone.Outcome.OK, gelcone.Outcome.PULLED_IN]
    assert stroke[0] == pytest.approx(float(settled[0]["stroke"]), rel=5e-3)
    assert np.isnan(stroke[1])


@pytest.mark.parametrize("circuit", [{}, {"series_resistance": "1 MOhm"}])
@pytest.mark.parametrize(("steps", "known"), [(1, False), (40, True)])
def test_a_response_that_has_not_converged_is_none(circuit, steps, known, monkeypatch):
    """With states of circuits and without."""
    for module in ("bench", "periodic"):
        monkeypatch.setattr(f"gelcone.lab.{module}.NEWTON_STEPS", steps)
    own = gelcone.find_device("biased-pump").replace({"film": "wrinkling", **circuit})
    found = alone(own).response(np.array([1700.0]), np.array([400.0]), np.array([8.0]))
    assert np.isfinite(found).all() == known


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_balance_of_the_disc_alone_is_that_of_all_states(film):
    own = device(CERTIFIED["responses"][0]["device"], film)
    variants = Variants(own, ["spring_rate"], np.array([[1.0], [1.2]]), {})
    set_numbers = np.full(2, 1000.0), np.array([60.0, 300.0]), np.array([9.0, 9.0])
    variants.response(*set_numbers, key="own")
    alone_balanced = variants._states["own"].reshape(-1, 3)
    volts = [np.broadcast_to(variants.volts(one), (2, 2)) for one in set_numbers[:2]]
    driven = variants._driven(*volts, set_numbers[2] / variants.scale("frequency"))
    found = balanced(driven, linear_motion(driven, alone_balanced[:, 0]))
    np.testing.assert_allclose(found[:, 0], alone_balanced, rtol=1e-10, atol=1e-12)
