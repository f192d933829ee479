"""A constant voltage is the commanded one, whichever command is asked and whatever lies between source and film."""

import numpy as np
import pytest

import gelcone
from gelcone.physics.amplifier import Amplifier
from gelcone.physics.model import ConeModel

TAUT = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "spring_stiffness": 1.5}
PAIR = {**TAUT, "second_film": "taut", "second_flat_height": 1.4, "voltage_bias": 0.4}
LEAK = {"series_resistance": 3.0, "leakage_time": 12.0}
SINH = {**LEAK, "leakage_field": 0.4}
CIRCUITS = {
    "ideal": TAUT,
    "filter": {**TAUT, "filter_time": 0.4},
    "resistance": {**TAUT, "series_resistance": 0.5},
    "leak": {**TAUT, **LEAK},
    "leak of an ideal source": {**TAUT, "leakage_time": 12.0},
    "sinh leak": {**TAUT, **SINH},
    "filter and sinh leak": {**TAUT, **SINH, "filter_time": 0.4, "slew_rate": 2.0},
    "current limit above the leak": {**TAUT, **LEAK, "current_limit": 2.0},
    "current limit below the leak": {**TAUT, **LEAK, "current_limit": 0.03},
    "reduced": {**TAUT, "leakage_time": 0.05, "circuit": Amplifier(("series_resistance", "leakage_time"), True),
                "series_resistance": 0.009},
    "late permittivity": {**TAUT, **LEAK, "dielectric_share": 0.3, "dielectric_time": 2.0},
    "charge": {**TAUT, "circuit": "charge"},
    "wrinkling": {**TAUT, **LEAK, "film": "wrinkling"},
    "creeping": {**TAUT, **LEAK, "viscous_modulus_1": 0.4, "relaxation_time_1": 3.0},
    **{f"double cone, {drive}": {**PAIR, **SINH, "second_drive": drive} for drive in ("same", "opposite")},
    "double cone, constant": {**PAIR, **LEAK, "second_drive": "constant", "second_voltage": 0.5},
    "double cone, charge": {**PAIR, "circuit": "charge"},
    "double cone, opposite, ideal": {**PAIR, "second_drive": "opposite"},
    "double cone, opposite, negative bias": {**PAIR, **SINH, "second_drive": "opposite", "voltage_bias": -0.4},
    "negative bias": {**TAUT, **LEAK, "voltage_bias": -0.4},
    "double cone, opposite, resistance": {**PAIR, "second_drive": "opposite", "series_resistance": 0.5},
}  # fmt: skip
LEVEL = 0.9
LASTS = 400.0


PLACES = np.array([0.55 - 1e-5, 0.55, 0.55 + 1e-5])


WITHIN = ("double cone, opposite", "double cone, same", "double cone, opposite, ideal", "leak", "filter")
"""Circuits that have no part that another one lacks."""


@pytest.fixture(
    scope="module",
    params=[pytest.param(parts, marks=pytest.mark.slow if name in WITHIN else []) for name, parts in CIRCUITS.items()],
    ids=CIRCUITS,
)
def model(request):
    return ConeModel(voltage=0.2, **request.param)


@pytest.fixture(scope="module")
def static(model):
    """The statics at `level_of` a model, with the force at three places."""
    return gelcone.static(model, [level_of(model)], PLACES)


def level_of(model):
    """A constant voltage that a run can have, too: of films in opposite phase their bias."""
    return abs(model.voltage_bias) if model.system.films[-1].drive == "opposite" else LEVEL


def place_of(static):
    """The displacement at the end of the ramp to the last voltage."""
    return float(static["stroke"][-1] + static["rest_displacement"])


def test_one_voltage_has_one_rest(model, static):
    level = level_of(model)
    place = place_of(static)
    step = gelcone.step(model, [level], duration=LASTS)
    held = model.replace(voltage=0.0, voltage_bias=np.copysign(level, model.voltage_bias))
    run = gelcone.simulate(held, times=[LASTS])
    found = {
        "ramp": gelcone.stroke_and_blocked_force(model, [level])["displacement"],
        "step": step["final_displacement"],
        "ramp of step": step["equilibrium_displacement"],
        "run": run["displacement"],
        "state space": gelcone.state_space(model, voltage=level).place,
        "transfer": gelcone.transfer(model, [1.0], bias=level, amplitudes=[0.0])["equilibrium_displacement"],
    }
    for name, value in found.items():
        assert np.ravel(value)[-1] == pytest.approx(place, abs=1e-6), name
    at = np.abs(static["equilibrium_displacement"].values.ravel() - place)
    assert np.nanmin(at) < 1e-9
    volts = static.get("film_voltage")
    on_film = level if volts is None else volts.values.ravel()[np.nanargmin(at)]
    assert abs(float(np.ravel(run["drive_voltage"])[-1])) == level
    assert abs(float(np.ravel(run.get("film_voltage", run["drive_voltage"]))[-1])) == pytest.approx(on_film, abs=1e-6)


def test_a_step_from_a_voltage_to_itself_does_not_move(model):
    found = gelcone.step(model, [LEVEL], before=LEVEL)
    assert np.abs(found["displacement"] - found["initial_displacement"]).max() < 1e-9


@pytest.mark.parametrize("name", [name for name in CIRCUITS if name.startswith("double cone")])
def test_a_step_from_no_voltage_begins_with_that_of_the_second_film(name):
    found = gelcone.step(ConeModel(voltage=0.2, **CIRCUITS[name]), [0.0], before=0.0)
    assert np.abs(found["displacement"] - found["initial_displacement"]).max() < 1e-9


@pytest.mark.parametrize("leak", [pytest.param(LEAK, marks=pytest.mark.slow), SINH], ids=["leak", "sinh leak"])
def test_a_membrane_that_leaks_rests_and_runs_where_its_statics_say(leak):
    """Without voltage it rests where one that does not leak does. All have the charge that runs have, a fit."""
    plain = ConeModel(voltage=0.2, **TAUT, film="membrane")
    model = plain.replace(**leak)
    static = gelcone.static(model, [LEVEL])
    assert float(static["rest_displacement"]) == pytest.approx(float(gelcone.static(plain, [0.0])["rest_displacement"]))
    place = place_of(static)
    assert np.isfinite(static["pull_in_voltage"])
    step = gelcone.step(model, [LEVEL], before=LEVEL, duration=30.0)
    assert np.abs(step["displacement"] - place).max() < 1e-9
    run = gelcone.integrate(model.replace(voltage=0.0, voltage_bias=LEVEL), (place, 0.0), [LASTS])
    at = np.nanargmin(np.abs(static["equilibrium_displacement"].values.ravel() - place))
    on_film = static["film_voltage"].values.ravel()[at]
    np.testing.assert_allclose(run.states[0, -1], [place, 0.0, on_film], atol=1e-9)
    np.testing.assert_allclose(gelcone.state_space(model, voltage=LEVEL).rest, [place, 0.0, on_film], atol=1e-12)


def test_the_stiffness_is_the_slope_of_the_force_under_the_command(static):
    force, stiffness = static["force"].values.ravel(), static["stiffness"].values.ravel()
    assert stiffness[1] == pytest.approx((force[2] - force[0]) / (PLACES[2] - PLACES[0]), rel=1e-6)


@pytest.mark.parametrize("name", ["sinh leak", "charge"])
def test_a_data_sheet_has_the_rest_of_the_statics(name):
    """Its coupling is that of the held film, at the voltage on it: (g^2/K)/(dQ/dv + g^2/K)."""
    model = ConeModel(voltage=0.2, voltage_bias=0.5, **CIRCUITS[name])
    sheet, static = gelcone.datasheet(model, [LEVEL]), gelcone.static(model, [LEVEL])
    assert place_of(sheet) == pytest.approx(place_of(static), abs=1e-9)
    x, v = place_of(static), float(static["film_voltage"][0, 0])
    assert float(sheet["capacitance"][-1]) == pytest.approx(1.0 + x * x, rel=1e-6)
    assert float(sheet["field_energy"][-1]) == pytest.approx(0.5 * (1.0 + x * x) * v * v, rel=1e-6)
    moved = (2.0 * x * v) ** 2 / float(model.stiffness(x, v))
    assert float(sheet["coupling"][-1]) == pytest.approx(moved / (1.0 + x * x + moved), rel=1e-6)
    linear = np.linalg.eigvals(gelcone.state_space(model, voltage=LEVEL).A)
    pair = linear[np.abs(linear.imag) > 1e-9]
    assert float(sheet["natural_frequency"][-1]) == pytest.approx(np.abs(pair[0]), rel=1e-9)


def test_a_film_creeps_under_one_kind_of_voltage():
    """The threshold is that of the statics, below which every voltage is held, and none a little above for long."""
    beam = {"beam_stiffness": -0.6, "beam_cubic": 2.0, "beam_height": 1.0, "damping_ratio": 0.3, "prestretch": 1.2}
    film = gelcone.TautCone(branches=1, prestretch_mode="equibiaxial")
    branch = {"viscous_modulus_1": 1.0, "relaxation_time_1": 20.0}
    model = ConeModel(film=film, bias=gelcone.BuckledBeam(), voltage=0.2, **beam, **branch)
    behind = model.replace(series_resistance=0.5, leakage_time=8.0)
    plain, found = (gelcone.creep(one, [0.5], duration=20.0, tolerance=1e-8) for one in (model, behind))
    assert float(found["long_term_pull_in_voltage"]) > 1.03 * float(plain["long_term_pull_in_voltage"])
    static = gelcone.static(behind, [0.5])
    assert float(found["equilibrium_displacement"][0]) == pytest.approx(place_of(static), abs=1e-9)
    assert float(found["long_term_pull_in_voltage"]) == pytest.approx(float(static["pull_in_voltage"]), rel=1e-9)
    longest = gelcone.creep(behind, [0.5], duration=2000.0, tolerance=1e-8)
    assert found["long_term_pull_in_voltage"] <= longest["holding_voltage"] < found["holding_voltage"]
    assert float(longest["holding_voltage"]) == pytest.approx(float(found["long_term_pull_in_voltage"]), rel=1e-2)


@pytest.mark.parametrize("circuit", [LEAK, {"circuit": "charge"}], ids=["leak", "charge"])
def test_static_limits_are_those_of_a_run_whose_command_rises_slowly(circuit):
    """Of a taut film the hoop is slack at the same command in both."""
    model = ConeModel(voltage=0.2, voltage_bias=0.6, **{**TAUT, "hoop_prestretch": 1.2}, **circuit)
    limits = gelcone.operating_limits(model)
    slack = min(float(limits[f"{name}_slack_voltage"]) for name in ("hoop", "meridional"))
    assert float(limits["safe_peak_voltage"]) <= slack
    shares = []
    for share in (0.999, 1.001):
        static = gelcone.static(model, [share * slack])
        held = model.replace(voltage=0.0, voltage_bias=share * slack)
        run = gelcone.simulate(held, (place_of(static), 0.0), times=np.linspace(0.0, LASTS, 800))
        names = ("validity_hoop_slack", "validity_meridional_slack")
        shares.append([max(float(np.ravel(one[name])[0]) for name in names) for one in (run, static)])
    assert shares[0] == [0.0, 0.0]
    assert min(shares[1]) > 0.0


def test_films_in_opposite_phase_rest_about_their_bias_where_without_the_first_voltage_they_pull_in():
    """The second film has twice the offset there, so that this is no place to start from."""
    films = {"film": "wrinkling", "second_film": "wrinkling"}
    device = gelcone.find_device("double-cone").replace(**films, voltage_offset="1.6 kV")
    ramp = gelcone.stroke_and_blocked_force(device, ["0 V", "1.6 kV", "1.77 kV"])
    moved = float(ramp["stroke"][2])
    assert np.isnan(ramp["stroke"].values[0])
    assert moved > 0.1
    np.testing.assert_allclose(ramp["displacement"][1:], [10.0, 10.0 + moved], rtol=1e-9)
    step = gelcone.step(device, duration="0.1 s")
    assert step["constant_voltage"].values.tolist() == pytest.approx([1770.0])
    assert float(step["initial_displacement"][0]) == pytest.approx(10.0)
    assert float(step["equilibrium_displacement"][0]) == pytest.approx(10.0 + moved)
    assert float(gelcone.transfer(device, ["5 Hz"], amplitudes=["0 V"])["equilibrium_displacement"]) == pytest.approx(
        10.0
    )
    for name, option in (("step", {"before": "0 V"}), ("state_space", {"voltage": "0 V"})):
        with pytest.raises(gelcone.InputError, match=rf"{min(option)}.* 0 V: beyond .*closer to voltage_offset"):
            getattr(gelcone, name)(device, **option)
    with pytest.raises(gelcone.InputError, match=r"bias = 9 kV: beyond pull-in.*; lower it"):
        gelcone.transfer(device, ["5 Hz"], bias="9 kV")
    for option in ({}, {"before": "1 kV"}):
        with pytest.raises(gelcone.InputError, match=r"voltage_offset = 9 kV: beyond pull-in.*; lower it"):
            gelcone.step(device.replace(voltage_offset="9 kV"), **option)


def test_a_second_film_beyond_its_pull_in_is_named():
    held = {"second_drive": "constant", "second_voltage": 5.0, "law": "neo-hookean"}
    model = ConeModel(**{**PAIR, **held})
    for asked in (gelcone.step, lambda model: gelcone.transfer(model, [1.0])):
        with pytest.raises(gelcone.InputError, match=r"second_voltage = 5: beyond pull-in.*; lower it"):
            asked(model)
