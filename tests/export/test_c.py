"""A device as C: the bits of the integrator, the numbers of simulate, and what happens at the ends."""

from __future__ import annotations

import ctypes
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelcone
from gelcone.export import reference
from gelcone.export import sources as export_sources
from gelcone.export.compiler import find_compiler
from gelcone.export.reference import Reference
from gelcone.export.sources import Exported
from gelcone.motion.flow import smallest_step
from tests.export.instance import Instance, compiled, device
from tests.toys import TurningBias, VoltageBehindResistor

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")

WRINKLING = {
    "film": "wrinkling",
    "meridional_prestretch": 1.0,
    "hoop_prestretch": 1.05,
    "voltage_amplitude": 788.0,
    "voltage_offset": 901.0,
}
"""The drive slackens the hoops of this pump for a sixth of the time."""


OPTIMISED = ("taut", "beam and sine", "wrinkling")
"""Devices whose C is optimised, which takes three times as long to compile and is tested for equal bits, too."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Exported devices and their libraries, each compiled once: (device, options) -> both."""
    found = {}

    def of(key, *arguments, **options):
        if key not in found:
            exported = Exported(*arguments, **options)
            level = () if key in OPTIMISED else ("-O0",)
            found[key] = exported, compiled(exported, tmp_path_factory.mktemp(key.replace(" ", "-")), *level)
        return found[key]

    return of


@pytest.fixture
def pump(made):
    """An exported taut pump with inputs, and a new instance."""
    exported, library = made("taut", device(film="taut"), "pump", False, 1e-10)
    return exported, Instance(exported, library)


def raw(library, exported, numbers, z, switches, length):
    """A run of the C with given numbers: status, states, switches."""
    own = np.array([numbers[name] for name in exported.program.numbers])
    z, signs = z.copy(), np.array([*switches.values(), 0.0])
    given, states, switched = (ctypes.c_void_p(array.ctypes.data) for array in (own, z, signs))
    return library.raw(given, ctypes.c_double(length), states, switched), z, signs[:-1]


def same_bits(exported, library, count, seed):
    """How many of random runs end with the same states, switches and status, and how many changed their law."""
    rng, own, (start, _) = np.random.default_rng(seed), exported.numbers(), exported.start()
    least, volt = float(smallest_step(exported.model.members())[0]), exported.scale_values["voltage"]
    same = changed = 0
    for _ in range(count):
        n = own | {
            "input_voltage": rng.uniform(0.0, 1900.0) / volt,
            "input_voltage_rate": 1e-2 * rng.normal(),
            "input_force": 1e-3 * rng.normal(),
            "input_force_rate": 1e-5 * rng.normal(),
            "input_phase": rng.uniform(0.0, 6.0),
        }
        z, length = start * np.array([rng.uniform(0.3, 1.5), 1.0, *rng.uniform(0.9, 1.1, start.size - 2)]), 60.0
        z[1] = 0.3 * rng.normal()
        found = exported.system.switches(0.0, [np.float64(value) for value in z], n)
        switches = {name: float(np.ravel(found[name])[0]) for name in exported.program.switches}
        status, states, signs = raw(library, exported, n, z, switches, length)
        right = exported.program.run(n | switches, z, length, least, 1e7)
        equal = status == right.status and states.tobytes() == np.ascontiguousarray(right.states).tobytes()
        same += equal and signs.tolist() == [right.switches[name] for name in exported.program.switches]
        changed += signs.tolist() != list(switches.values())
    return same, changed


BEAM = {"film": "taut", "beam_rate": -10.0, "beam_cubic_rate": 4e4, "gravity": 9.81}
CREEPING = {
    "film": "wrinkling",
    "hoop_prestretch": 1.1,
    "material.viscous_modulus_1": 1e4,
    "material.relaxation_time_1": 0.1,
}
AMPLIFIER = {
    "film": "wrinkling",
    "filter_frequency": 300.0,
    "slew_rate": 2e5,
    "series_resistance": 2e6,
    "current_limit": 1e-3,
    "material.resistivity": 1e8,
}
SECOND = {"film": "wrinkling", "second_film": "taut", "second_flat_height": 0.03, "second_drive": "opposite"}
BITS = {
    "taut": ({"film": "taut"}, False, 1e-10),
    "wrinkling": (WRINKLING, False, 1e-7),
    "creeping": (CREEPING, False, 1e-7),
    "beam and sine": (BEAM, True, 1e-10),
    "circuit": ({"film": "taut", "circuit": VoltageBehindResistor()}, False, 1e-7),
    "amplifier": (AMPLIFIER, False, 1e-7),
    "bias with states": ({"film": "taut", "bias": TurningBias()}, False, 1e-7),
    "second film": (SECOND, True, 1e-7),
    "snap": ({"film": "wrinkling", "pull_in": "snap"}, False, 1e-7),
}


@pytest.mark.parametrize("name", BITS)
def test_the_c_has_the_bits_of_the_integrator(made, name):
    changes, sine, tolerance = BITS[name]
    exported, library = made(name, device().replace(changes), "pump", sine, tolerance)
    same, changed = same_bits(exported, library, 12, seed=1)
    assert same == 12
    assert changed or not exported.program.switches


@pytest.mark.slow
@pytest.mark.parametrize("name", ["biased-pump", "double-cone"])
def test_a_membrane_has_the_bits_of_the_integrator(made, name):
    exported, library = made(f"membrane {name}", device(name), "pump", False, 1e-7)
    assert same_bits(exported, library, 40, seed=2)[0] == 40


def test_a_changed_coefficient_is_noticed(made):
    exported, library = made("taut", device(film="taut"), "pump", False, 1e-10)
    other = Exported(device(film="taut", spring_rate=15.000000000000002), "pump", False, 1e-10)
    z, switches = exported.start()
    one = raw(library, exported, exported.numbers(), z, switches, 30.0)[1]
    another = raw(library, exported, other.numbers(), z, switches, 30.0)[1]
    assert one.tobytes() != another.tobytes()


def test_the_numbers_that_follow_from_parameters_are_those_of_the_model(made):
    """Rounded as in the C exactly, and as in Python to the last digits."""
    exported, library = made("beam and sine", device(**BEAM), "pump", True, 1e-10)
    library.closed.restype = ctypes.c_double
    numbers, model = exported.numbers(), exported.model.numbers()
    found = [library.closed(k) for k in range(len(exported.program.numbers))]
    assert found == [numbers[name] for name in exported.program.numbers]
    for name in exported.parameters.nodes:
        assert numbers[name] == pytest.approx(float(model[name]), rel=1e-15, abs=0.0)


# --- what an instance gives -------------------------------------------------------------------------------------------

OUTPUTS = {
    "displacement": "displacement", "velocity": "velocity", "current": "current", "film_voltage": "film_voltage",
    "meridional_stress": "meridional_stress", "hoop_stress": "hoop_stress", "true_field": "true_field",
}  # fmt: skip
SI = {"mm": 1e-3, "mA": 1e-3, "MV/m": 1e6, "kPa": 1e3}
CODES = {"breakdown": "breakdown", "near_limit": "near_limit", "film_state": "film_state"}


def compared(exported, library, tolerance):
    """Outputs under the device's own sine against simulate, as a share of the range of each."""
    own, step = exported.device, 2e-3
    times = step * np.arange(1, 151)
    right = gelcone.simulate(own, times=times, tolerance=exported.tolerance)
    right["film_voltage"] = right.get("film_voltage", right["drive_voltage"])
    instance, rows, codes, others = Instance(exported, library), [], [], []
    for _ in times:
        assert instance.step(step) == 0
        rows.append([instance[name] for name in OUTPUTS])
        others.append([instance["charge"] * instance["film_voltage"], instance["limit_share"]])
        codes.append([instance[name] for name in CODES])
    for values, wanted in zip(np.transpose(rows), OUTPUTS.values(), strict=True):
        known = right[wanted].values * SI.get(right[wanted].attrs["units"], 1.0)
        assert np.abs(values - known).max() <= tolerance * np.ptp(known), wanted
    for values, wanted in zip(np.transpose(codes), CODES.values(), strict=True):
        if wanted in right:
            np.testing.assert_array_equal(values, right[wanted].values)
    stored, share = np.transpose(others)
    np.testing.assert_allclose(stored, 2e-3 * right.field_energy.values, rtol=1e-9)
    strain = sum(right[f"{name}_stretch"].values ** 2 for name in ("meridional", "hoop", "thickness")) - 3.0
    taut = ~right.film_state.astype(bool).values if "film_state" in right else slice(None)
    np.testing.assert_allclose(share[taut], strain[taut] / own.material.law_parameters["stretch_limit"], rtol=1e-9)
    return right


def test_outputs_of_a_taut_film_are_those_of_simulate(made):
    exported, library = made("sine", device(film="taut"), "pump", True, 1e-15)
    compared(exported, library, 1e-12)


LEAKS = {"film": "taut", "material.resistivity": "2 Gohm m"}


@pytest.mark.parametrize("more", [{}, {"series_resistance": "2 Mohm"}], ids=["ideal source", "behind a resistance"])
def test_the_current_into_a_film_that_leaks_has_its_leak(made, more):
    exported, library = made(f"leak {len(more)}", device(**LEAKS, **more), "pump", True, 1e-15)
    right = compared(exported, library, 1e-9)
    dry = gelcone.simulate(exported.device.replace({"material.resistivity": None}), times=1e-3 * right.time.values)
    assert np.abs(right.current - dry.current).max() > 0.02 * np.abs(dry.current).max()


def test_outputs_of_a_film_that_wrinkles_are_those_of_simulate(made):
    exported, library = made("wrinkling sine", device(**WRINKLING), "pump", True, 1e-15)
    right = compared(exported, library, 1e-12)
    assert len(np.unique(right.film_state)) > 1


def test_capacitance_is_the_charge_over_the_voltage(pump):
    _, instance = pump
    instance.set("voltage", 900.0)
    assert instance["charge"] == pytest.approx(900.0 * instance["capacitance"], rel=1e-15)


def test_an_input_with_a_rate_follows_the_commanded_sine(pump):
    """With the chord of a sine in each millisecond, the motion is that of the sine to 5e-4 of the stroke."""
    exported, instance = pump
    own, step = exported.device, 1e-3
    times = step * np.arange(0, 401)
    volts = own.voltage_offset + own.voltage_amplitude * np.sin(2.0 * np.pi * own.frequency * times)
    found = []
    for now, after in pairwise(volts):
        instance.set("voltage", now)
        instance.set("voltage_rate", (after - now) / step)
        assert instance.step(step) == 0
        found.append(instance["displacement"])
        assert instance["voltage"] == pytest.approx(after, rel=1e-12)
    right = 1e-3 * gelcone.simulate(own, times=times[1:]).displacement.values
    assert np.abs(np.array(found) - right).max() < 5e-4 * np.ptp(right)


WAVES = {
    "trapezoid": "trapezoid",
    "jumps": {"component": "square", "rise": 0.0, "duty": 0.3},
    "burst": "burst",
    "harmonics": "harmonics",
    "once": {"component": "staircase", "repeat": False},
}


@pytest.mark.parametrize("name", WAVES)
def test_a_drive_of_any_shape_runs_inside_and_the_input_adds_to_it(made, name):
    """In steps that lie between its corners, and in steps across several."""
    own = device(film="taut", waveform=WAVES[name])
    exported, library = made(f"inside {name}", own, "pump", True, 1e-15)
    times = 2e-3 * np.arange(1, 151)
    right = 1e-3 * gelcone.simulate(own, times=times).displacement.values
    for every in (1, 15):
        instance, found = Instance(exported, library), []
        for _ in times[every - 1 :: every]:
            assert instance.step(every * 2e-3) == 0
            found.append(instance["displacement"])
        assert np.abs(np.array(found) - right[every - 1 :: every]).max() < 1e-13 * np.ptp(right)
    instance = Instance(exported, library)
    begun = instance["film_voltage"]
    instance.set("voltage", 100.0)
    assert instance["film_voltage"] - begun == pytest.approx(100.0)
    motion, given = Reference(exported), {"voltage": 100.0, "voltage_rate": 2e3, "external_force": 1e-2}
    for variable, value in (given | {"external_force_rate": -0.1}).items():
        instance.set(variable, value)
    assert instance.step(0.07) == motion.step(0.07, (*given.values(), -0.1)) == 0
    assert instance["displacement"] == motion.z[0] * exported.scale_values["length"]
    assert (instance["voltage"], instance["external_force"]) == pytest.approx((240.0, 3e-3), rel=1e-12)
    assert motion.time == pytest.approx(0.07, rel=1e-15)


def test_a_force_lifts_the_disc_by_the_force_over_the_stiffness(pump):
    exported, instance = pump
    start = instance["displacement"]
    assert instance.set("damping_coefficient", 1.0) == 0
    instance.set("external_force", 1e-4)
    assert instance.step(2.0) == 0
    model, s = exported.model, exported.device.scales
    stiffness = float(model.stiffness(start / s.length, 0.0)) * s.force / s.length
    assert instance["displacement"] - start == pytest.approx(1e-4 / stiffness, rel=2e-3)
    assert abs(instance["velocity"]) < 1e-9


def test_a_changed_parameter_gives_the_motion_of_the_changed_device(pump):
    _, instance = pump
    changes = {"moving_mass": 7e-3, "material.shear_modulus": 2.2e4, "film_thickness": 2.3e-4, "initial_height": 0.021}
    other = device(film="taut").replace(changes)
    start = instance["displacement"]
    for name, value in changes.items():
        assert instance.set(name, value) == 0
    assert instance["displacement"] == pytest.approx(start, rel=1e-14)
    instance.set("voltage", 800.0)
    run = Reference(Exported(other, "pump", False, 1e-10))
    run.z[0] = start / other.scales.length
    run.step(0.05, (800.0, 0.0, 0.0, 0.0))
    assert instance.step(0.05) == 0
    assert instance["displacement"] == pytest.approx(run.z[0] * other.scales.length, rel=1e-13)


@pytest.mark.parametrize("key", ["amplifier", "creeping"])
def test_what_is_not_changed_stays_what_it_is_in_si_units(made, key):
    """Time constants of amplifier and gel while a mass changes the unit of time."""
    changes, sine, tolerance = BITS[key]
    exported, library = made(key, device().replace(changes), "pump", sine, tolerance)
    instance = Instance(exported, library)
    instance.set("moving_mass", 0.02)
    other = Exported(device().replace(changes).replace(moving_mass=0.02), "pump", sine, tolerance)
    instance.set("voltage", 800.0)
    run = Reference(other)
    for _ in range(3):
        run.step(0.02, (800.0, 0.0, 0.0, 0.0))
        assert instance.step(0.02) == 0
    for k, state in enumerate(other.system.states):
        right = run.z[k] * other.scale_values.get(state.quantity, 1.0)
        assert instance[state.name] == pytest.approx(right, rel=1e-10, abs=1e-15)


def test_a_stored_instance_continues_with_the_same_bits(pump):
    _, instance = pump
    instance.set("voltage", 900.0)
    instance.step(0.013)
    stored = instance.stored()
    instance.step(0.02)
    first = instance.stored()
    instance.restore(stored)
    instance.step(0.02)
    assert instance.stored() == first


def test_steps_of_nothing_and_of_ten_seconds(pump):
    _, instance = pump
    before = instance["displacement"]
    assert instance.step(0.0) == 0
    assert instance["displacement"] == before
    assert instance.step(10.0) == 0
    assert instance["displacement"] == pytest.approx(before, abs=1e-9)
    assert instance["time"] == 10.0


def test_what_cannot_be_used_is_refused_and_changes_nothing(pump):
    _, instance = pump
    instance.set("voltage", 500.0)
    before = instance.stored()
    refused = {"voltage": np.nan, "external_force": np.inf, "moving_mass": 0.0, "film_thickness": -1.0, "current": 1.0}
    for name, value in (refused | {"damping_coefficient": -1e-9, "time": 1.0, "displacement": np.nan}).items():
        assert instance.set(name, value) == -1, name
    for seconds in (-1e-3, np.nan, np.inf):
        assert instance.step(seconds) == -1
    assert instance.stored() == before
    assert "refused" in instance.words(-1)


def test_pull_in_ends_where_simulate_says(made):
    own = device(film="wrinkling", voltage_amplitude=0.0, voltage_offset=2703.0)
    exported, library = made("ending", own, "pump", False, 1e-15)
    instance = Instance(exported, library)
    instance.set("voltage", 2703.0)
    right = gelcone.simulate(own, times=[0.1])
    outcomes = [instance.step(1e-3) for _ in range(60)]
    assert 0 in outcomes
    assert outcomes[-1] == gelcone.Outcome.PULLED_IN == int(instance["outcome"])
    assert instance["time"] == pytest.approx(1e-3 * float(right.pull_in_time), rel=1e-9)
    assert instance["valid"] == 0.0
    assert "pulled in" in instance.words(outcomes[-1])
    ended = instance.stored()
    instance.step(1.0)
    assert instance["time"] == pytest.approx(1e-3 * float(right.pull_in_time), rel=1e-9)
    assert len(ended) == len(instance.stored())


@pytest.mark.parametrize("volts", [1e20, -1e20, 1e4])
def test_a_jump_far_across_pull_in_ends_and_does_not_hang(made, volts):
    exported, library = made("ending", device(film="wrinkling"), "pump", False, 1e-15)
    instance = Instance(exported, library)
    instance.set("voltage", volts)
    assert instance.step(1.0) in (gelcone.Outcome.PULLED_IN, gelcone.Outcome.STRETCH_LIMIT)


# --- every variable of an instance ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BITS)
def test_rates_of_all_states_are_those_of_the_equation_of_motion(made, name):
    """At random states, voltages and forces, of every kind of device, in SI units."""
    changes, sine, tolerance = BITS[name]
    exported, library = made(name, device().replace(changes), "pump", sine, tolerance)
    right, rng = gelcone.rates(exported.device), np.random.default_rng(3)
    units = {variable.name: variable.unit for variable in exported.variables}
    for _ in range(5):
        instance = Instance(exported, library)
        y = right.start * rng.uniform(0.8, 1.2, len(right.states))
        y[1] = 0.1 * rng.normal()
        y = np.where([units[state] == "V" for state in right.states], rng.uniform(100.0, 900.0), y)
        force, volts = 1e-2 * rng.normal(), rng.uniform(100.0, 900.0)
        drive = float(right._waveform.voltage(0.0, right._drive)) * exported.device.scales.voltage if sine else 0.0
        given = {**dict(zip(right.states, y, strict=True)), "voltage": volts, "external_force": force}
        for state, value in given.items():
            assert instance.set(state, value) == 0
            assert instance[state] == pytest.approx(value, rel=1e-14)
        assert instance.step(0.0) == 0
        found = [instance[f"{state}_rate"] for state in right.states]
        np.testing.assert_allclose(found, right(0.0, y, voltage=drive + volts, force=force), rtol=1e-9)


def test_a_motion_under_rates_of_voltage_and_force_is_that_of_another_integrator(pump):
    exported, instance = pump
    given = {"voltage": 700.0, "voltage_rate": 4e3, "external_force": 2e-2, "external_force_rate": -0.7}
    for name, value in given.items():
        assert instance.set(name, value) == 0
    steps = [2e-3, 0.0, 0.03, 0.018]
    assert [instance.step(step) for step in steps] == [0] * 4
    right, (volts, volt_rate, force, force_rate) = gelcone.rates(exported.device), given.values()

    def fall(t, y):
        return right(t, y, voltage=volts + volt_rate * t, force=force + force_rate * t)

    end = solve_ivp(fall, (0.0, 0.05), right.start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    assert [instance["displacement"], instance["velocity"]] == pytest.approx(end, rel=1e-7)
    assert instance["time"] == pytest.approx(0.05, rel=1e-15)
    assert instance["voltage"] == pytest.approx(900.0, rel=1e-12)
    assert instance["external_force"] == pytest.approx(-0.015, rel=1e-12)
    assert (instance["voltage_rate"], instance["external_force_rate"]) == (4e3, -0.7)


@pytest.mark.parametrize("name", ["beam and sine", "creeping", "amplifier", "second film"])
def test_every_parameter_is_that_of_the_device_and_keeps_to_its_bounds(made, name):
    """The bound itself is taken where it is allowed, a number next to it in the other direction never."""
    changes, sine, tolerance = BITS[name]
    exported, library = made(name, device().replace(changes), "pump", sine, tolerance)
    own, instance = exported.device, Instance(exported, library)
    fields = own.swept_fields()
    assert {"moving_mass", "spring_rate", "film_thickness", "dielectric_strength"} <= set(exported.parameters.values)
    for parameter in exported.parameters.values:
        value, bounds = own.get(parameter), fields[parameter]
        strength = own.material.dielectric_strength if parameter == "dielectric_strength" else value
        assert instance[parameter] == float(value if value is not None else strength), parameter
        unknown = parameter == "dielectric_strength"  # where it is 0
        for bound, taken in ((bounds.above, unknown), (bounds.least, True)):
            if bound is not None:
                before = instance[parameter]
                assert instance.set(parameter, np.nextafter(bound, -np.inf)) == -1, parameter
                assert instance.set(parameter, bound) == (0 if taken else -1), parameter
                assert instance[parameter] == (bound if taken else before)
                instance.set(parameter, before)
        assert instance.set(parameter, np.inf) == -1
    kinds = {variable.name: variable.kind for variable in exported.variables}
    for variable, kind in kinds.items():
        known = instance[variable]
        assert instance.set(variable, known) == (0 if kind in ("input", "state", "parameter") else -1), variable
    assert all(np.isnan(instance._own["get"](instance._at, place)) for place in (-1, len(kinds), len(kinds) + 7))
    assert all(instance._own["set"](instance._at, place, 0.0) == -1 for place in (-1, len(kinds), len(kinds) + 7))


def at(instance, **values):
    """The codes of an instance once some of its variables were set."""
    for name, value in values.items():
        assert instance.set(name, value) == 0
    instance.step(0.0)
    return {name: int(instance[name]) for name in ("film_is_slack", "breakdown", "near_limit", "valid", "outcome")}


HOLDS = {"film_is_slack": 0, "breakdown": 0, "near_limit": 0, "valid": 1, "outcome": 0}


def test_codes_change_where_their_numbers_cross_the_bound(pump):
    """Breakdown where the field passes the strength, which 0 leaves unknown; nearness at 99 % of the stretch limit; and
    slack where a stress is below 0."""
    _, instance = pump
    assert at(instance, voltage=900.0) == HOLDS
    field = instance["true_field"]
    assert at(instance, dielectric_strength=1.001 * field) == HOLDS
    assert at(instance, dielectric_strength=0.999 * field) == HOLDS | {"breakdown": 1, "valid": 0}
    assert at(instance, dielectric_strength=0.0, voltage=0.0) == HOLDS

    def above(name, bound, low, high):
        """Displacements on either side of where an output passes a bound."""
        for _ in range(60):
            middle = 0.5 * (low + high)
            instance.set("displacement", middle)
            low, high = (middle, high) if instance[name] < bound else (low, middle)
        return low * (1.0 - 1e-6), low * (1.0 + 1e-6)

    known = exported_reach(pump[0])
    below, beyond = above("limit_share", 0.99, 0.01, known)
    assert at(instance, displacement=below) == HOLDS
    assert at(instance, displacement=beyond) == HOLDS | {"near_limit": 1, "valid": 0}
    assert at(instance, displacement=0.9999 * known)["outcome"] == 0
    assert at(instance, displacement=1.0001 * known)["outcome"] == gelcone.Outcome.STRETCH_LIMIT
    instance._own["init"](instance._at)
    assert instance["outcome"] == 0.0
    low, high = 0.0, 5e3
    for _ in range(60):  # the hoop is the first to be pressed
        middle = 0.5 * (low + high)
        instance.set("voltage", middle)
        least = min(instance["hoop_stress"], instance["meridional_stress"])
        low, high = (middle, high) if least > 0.0 else (low, middle)
    assert at(instance, voltage=low * (1.0 - 1e-6), dielectric_strength=0.0) == HOLDS
    assert at(instance, voltage=high * (1.0 + 1e-6)) == HOLDS | {"film_is_slack": 1, "valid": 0}


def exported_reach(exported):
    """The height up to which the film is known, in metres."""
    (film,) = exported.system.films
    return float(film.film.reach(exported.numbers())[1]) * exported.device.scales.length


def test_a_film_that_wrinkles_may_be_slack_and_the_model_holds(made):
    exported, library = made("wrinkling", device(**WRINKLING), "pump", False, 1e-7)
    instance = Instance(exported, library)
    assert (at(instance), instance["film_state"]) == (HOLDS, 0.0)
    assert at(instance, voltage=1900.0, dielectric_strength=0.0) == HOLDS | {"film_is_slack": 1}
    assert instance["film_state"] == 1.0
    assert exported.kinds[0][1] == "hoop_slack"


def test_codes_are_those_of_either_film(made):
    """Breakdown of the film with the larger field, whichever that is, and pressing of the second, taut one."""
    changes, sine, tolerance = BITS["second film"]
    exported, library = made("second film", device().replace(changes), "pump", sine, tolerance)
    instance, larger = Instance(exported, library), set()
    for height in (0.004, 0.026):
        instance._own["init"](instance._at)
        instance.set("displacement", height)
        fields = [instance[f"{prefix}true_field"] for prefix in ("", "second_")]
        larger.add(int(np.argmax(fields)))
        for share, broken in ((0.999, 1), (1.001, 0)):
            assert at(instance, dielectric_strength=share * max(fields))["breakdown"] == broken, (height, fields)
    assert larger == {0, 1}
    instance._own["init"](instance._at)
    found = at(instance, voltage=4e3, dielectric_strength=0.0)
    assert min(instance["second_meridional_stress"], instance["second_hoop_stress"]) < 0.0
    assert (found["film_is_slack"], found["valid"], found["breakdown"]) == (1, 0, 0)


def test_a_long_step_may_take_as_many_steps_as_it_is_long(tmp_path, monkeypatch):
    """The most for a stretch of motion is that many for each part of it."""
    for home in (export_sources, reference):
        monkeypatch.setattr(home, "STEPS_PER_CALL", 100)
        monkeypatch.setattr(home, "CALL_SPAN", 20.0)
    exported = Exported(device(film="taut"), "pump", False, 1e-7)
    instance, motion = Instance(exported, compiled(exported, tmp_path, "-O0")), Reference(exported)
    instance.set("voltage", 900.0)
    assert instance.step(3.0) == motion.step(3.0, (900.0, 0.0, 0.0, 0.0)) == 0
    assert instance["time"] == 3.0
    assert instance["displacement"] == motion.z[0] * exported.scale_values["length"]
    assert instance.set("spring_rate", 1e9) == 0  # it vibrates a thousand times as fast as the device for which that is
    assert instance.step(3.0) == gelcone.Outcome.STEP_LIMIT == int(instance["outcome"])
    assert 3.0 < instance["time"] < 6.0
    assert instance["valid"] == 0.0


def test_a_film_without_a_stretch_limit_that_is_torn_away_ends_as_simulate_says(tmp_path):
    changes = {
        "film": "taut",
        "voltage_amplitude": 0.0,
        "voltage_offset": 30e3,
        "material.law": "neo-hookean",
        "hoop_prestretch": 1.1,
    }
    own = device(**changes)
    exported = Exported(own, "pump", True, 1e-7)
    instance = Instance(exported, compiled(exported, tmp_path, "-O0"))
    outcome = instance.step(2.0)
    assert outcome == gelcone.Outcome.NOT_FINITE == int(gelcone.simulate(own, times=[2.0]).outcome)
    assert 0.2 < instance["time"] < 1.0
    assert (instance["valid"], instance["outcome"]) == (0.0, outcome)


def test_every_outcome_has_its_words(pump):
    instance = pump[1]
    found = {code: instance.words(code) for code in range(-1, 8)}
    for own in gelcone.Outcome:
        if own.value in (2, 3, 4, 6):
            assert found[own.value] == own.meaning
    assert found[0] == "ok"
    assert all("refused" in found[code] for code in (-1, 1, 5, 7))


# --- the folder -------------------------------------------------------------------------------------------------------
