"""Plans and fits of devices: certified fits, symmetries, and what refuses a wrong structure."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.errors import DoubtfulInput, InputError
from gelcone.lab.bench import KINDS, DeviceTest, Variants
from gelcone.lab.device import _readings, _with_loss, fit_device, plan_device, read_free
from gelcone.lab.device_fit import (
    Problem,
    _peaks,
    _simple,
    _with_all_gains,
    _without_state,
    fit_problem,
    left_out,
    next_experiments,
    plan_of,
    profiled,
)
from gelcone.lab.device_tests import DeviceTests, read_device_tests
from gelcone.lab.fitted import fitted_device, fitted_draws
from tests.lab.certified import CERTIFIED, FIELDS, GAINS, TAUT, WRINKLING, problem

PUMP = Path(__file__).parents[2] / "docs" / "measured" / "pump"
PRIORS = {FIELDS[name]: spread for name, spread in CERTIFIED["device_fits"][TAUT]["priors_relative_sd"].items()}


def certified(case, film):
    own = CERTIFIED["device_fits"][case]["fits"][film]
    names = [*FIELDS, *GAINS]
    values = np.array([own["log_deviation_from_nominal"][name] for name in names])
    return own, values, np.array([own["standard_deviation"][name] for name in names])


def check(case, film):
    fitted = fit_problem(problem(case, film))
    own, values, spreads = certified(case, film)
    assert fitted.objective == pytest.approx(own["objective"], abs=1e-3)
    assert np.abs((fitted.logs - values) / spreads).max() < 0.02
    np.testing.assert_allclose(np.sqrt(np.diag(fitted.covariance)), spreads, rtol=0.01)
    assert fitted.p_value == pytest.approx(own["p_value"], rel=0.01)
    return fitted


def test_a_taut_pump_is_fitted_as_certified():
    fitted = check(TAUT, "taut")
    assert [one.p_value > 0.01 for one in left_out(fitted)] == [True] * 4


def test_a_taut_film_is_refused_where_the_film_wrinkles():
    fitted = check(WRINKLING, "taut")
    assert fitted.p_value < 1e-50


@pytest.mark.slow
def test_a_wrinkling_pump_is_fitted_as_certified():
    fitted = check(WRINKLING, "wrinkling")
    assert [one.p_value > 0.01 for one in left_out(fitted)] == [True] * 5


def test_the_plan_of_all_tests_is_the_certified_one():
    whole = problem(TAUT, "taut", gains=False)
    plan = plan_of(whole)
    own = CERTIFIED["identifiability"]["all"]
    found = plan.left[: len(FIELDS)] / whole.priors[: len(FIELDS)]
    np.testing.assert_allclose(found, list(own["sd_over_prior"].values()), atol=0.03)
    assert plan.learnt == own["informative_directions"] == 6


@pytest.mark.parametrize(("name", "which"), [("blocked force at three voltages", [0]), ("stroke over voltage", [1])])
def test_the_plan_of_single_tests_is_the_certified_one(name, which):
    whole = problem(TAUT, "taut", gains=False)
    plan = plan_of(Problem(whole.device, whole.free, tuple(whole.tests[k] for k in which), whole.gains))
    own = CERTIFIED["identifiability"][name]
    found = plan.left[: len(FIELDS)] / whole.priors[: len(FIELDS)]
    np.testing.assert_allclose(found, list(own["sd_over_prior"].values()), atol=0.03)
    assert plan.learnt == own["informative_directions"]


def test_what_the_plan_calls_invariant_changes_no_reading():
    """Not only to the first order: by a tenth."""
    whole = problem(TAUT, "taut")
    plan = plan_of(whole)
    names = list(whole.free)
    first = dict(zip(names, plan.directions[0], strict=True))
    known = {"material.shear_modulus": 1.0, "film_thickness": -1.0, "material.relative_permittivity": -1.0}
    assert {name: share for name, share in first.items() if share} == known
    factors = np.exp(0.1 * plan.directions[:1])
    changed, same = (Variants(whole.device, names, own, {}) for own in (factors, np.ones_like(factors)))
    for test in whole.tests:
        np.testing.assert_allclose(changed.predict(test), same.predict(test), rtol=1e-9, atol=1e-12)
    assert len(plan.directions) == 3


def test_without_a_force_or_a_mass_all_stiffnesses_change_together():
    whole = problem(TAUT, "taut")
    names = ["material.shear_modulus", "spring_rate", "moving_mass", "damping_coefficient"]
    names.append("material.relative_permittivity")
    free = {name: PRIORS[name] for name in names}
    without = plan_of(Problem(whole.device, free, whole.tests[1:], whole.gains))
    np.testing.assert_array_equal(without.directions, np.ones((1, 5)))
    assert len(plan_of(Problem(whole.device, free, whole.tests, whole.gains)).directions) == 0


def test_the_next_experiment_is_a_calibration_of_the_amplifier():
    """A stroke beyond the tests hangs on the voltage; what is promised is what a plan with that calibration finds."""
    whole = problem(TAUT, "taut")
    result = plan_device(whole.device, DeviceTests(whole.tests, whole.gains), whole.free, predict=["stroke@2.15 kV"])
    ranked = json.loads(result.attrs["next"])[0]
    assert ranked[0][0] == "gain of the amplifier calibrated to 0.2 %"
    assert ranked[0][1] == pytest.approx(0.32, abs=0.05)
    better = DeviceTests(whole.tests, {**whole.gains, "amplifier": 0.002})
    after = plan_device(whole.device, better, whole.free, predict=["stroke@2.15 kV"])
    ratio = float(after["predicted_spread"][0] / result["predicted_spread"][0])
    assert ratio == pytest.approx(ranked[0][1], rel=1e-3)
    assert dict(map(tuple, ranked))["four times the rows of: stroke over voltage"] > 0.95
    for name, prior in whole.free.items():
        assert f"{name} known to {50.0 * prior:.2g} %" in dict(map(tuple, ranked))  # half of its prior


def test_the_promise_of_more_rows_is_kept():
    whole = problem(TAUT, "taut")
    row = np.zeros(len(whole.names))
    row[0] = 1.0
    promised = dict(next_experiments(whole, row))["four times the rows of: blocked force"]
    more = Problem(whole.device, whole.free, (*[whole.tests[0]] * 3, *whole.tests), whole.gains)
    assert plan_of(more).left[0] / plan_of(whole).left[0] == pytest.approx(promised, rel=1e-6)


def test_predictions_and_their_spread_are_the_certified_ones():
    whole = problem(TAUT, "taut")
    asked = ["stroke@2.15 kV", "natural frequency@1.5 kV"]
    result = fit_device(whole.device, DeviceTests(whole.tests, whole.gains), whole.free, predict=asked)
    own = CERTIFIED["device_fits"][TAUT]["fits"]["taut"]["predictions"]
    expected = [own["stroke at high voltage, m"], own["natural frequency at the middle bias, Hz"]]
    np.testing.assert_allclose(result["predicted_value"].values, [one["value"] for one in expected], rtol=1e-4)
    np.testing.assert_allclose(result["predicted_spread"].values, [one["sd"] for one in expected], rtol=0.01)
    assert (result.attrs["refused"], result.attrs["film"]) == (0, "taut")
    device = fitted_device(result)
    assert device.spring_rate == pytest.approx(15.0 * np.exp(0.031655825), rel=1e-5)
    assert float(gelcone.stroke_and_blocked_force(device, [2150.0])["stroke"][0]) * 1e-3 == pytest.approx(
        float(result["predicted_value"][0]), rel=1e-9
    )


def test_where_chi2_refuses_deviations_are_wider():
    """By the root of chi2 over the readings (Birge), those of the draws, too."""
    whole = problem(TAUT, "taut")
    free = {"damping_coefficient": 1.0}
    plain = fit_problem(Problem(whole.device, free, whole.tests, whole.gains))
    result = fit_device(whole.device, DeviceTests(whole.tests, whole.gains), free)
    wider = np.sqrt(plain.chi2 / 77.0)
    assert (result.attrs["refused"], wider > 3.0) == (1, True)
    np.testing.assert_allclose(result["posterior"].values, wider * np.sqrt(np.diag(plain.covariance)), rtol=1e-6)
    np.testing.assert_allclose(result["covariance"].values, wider**2 * plain.covariance, rtol=1e-6)


def test_intervals_cover_on_made_up_pumps():
    """True deviations of fields and gains within two standard deviations in 90 to 100 % of 12 small fits."""
    whole = problem(TAUT, "taut")
    names = ["material.shear_modulus", "material.relative_permittivity", "spring_rate", "damping_coefficient"]
    free = {name: min(PRIORS[name], 0.3) for name in names}
    inside = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        own = Problem(whole.device, free, whole.tests, whole.gains)
        truth = own.priors * rng.standard_normal(own.priors.size)
        readings = own.predict(truth[None])[0] + own.noise * rng.standard_normal(own.noise.size)
        fitted = fit_problem(Problem(whole.device, free, with_readings(own.tests, readings), whole.gains))
        inside.append(np.abs(fitted.logs - truth) / np.sqrt(np.diag(fitted.covariance)) < 1.96)
    assert 0.88 <= np.mean(inside) <= 1.0


@pytest.fixture(scope="module")
def lossy():
    """Readings of a pump with damper and branch, at three biases, and the pump as drawn, without a branch."""
    drawn = gelcone.find_device("biased-pump").replace(film="taut", damping_coefficient=5e-3)
    true = drawn.replace({"material.viscous_modulus_1": 1500.0, "material.relaxation_time_1": 0.02})
    frequency, planned = np.linspace(9.0, 14.0, 7), []
    for volts in (500.0, 1000.0, 1500.0):
        commanded = {"voltage_offset": np.full(7, volts), "voltage_amplitude": np.full(7, 60.0), "frequency": frequency}
        columns = {name: np.zeros(7) for name in ("in_phase", "quadrature")}
        noise = {name: np.full(7, 1e-5) for name in columns}
        planned.append(DeviceTest(f"at {volts:g} V", "frequency response", commanded, columns, noise))
    whole = Problem(true, {"damping_coefficient": 1.0}, tuple(planned), {"laser": 0.01, "amplifier": 0.01})
    readings = whole.predict(np.zeros((1, 3)))[0] + 1e-5 * np.random.default_rng(4).standard_normal(42)
    return true, drawn, DeviceTests(with_readings(whole.tests, readings), whole.gains)


def test_a_loss_is_found_by_what_contains_damper_and_branch(lossy):
    true, drawn, tests = lossy
    free = {"damping_coefficient": 1.0, "material.relative_permittivity": 0.05, "spring_rate": 0.03}
    result = fit_device(drawn, tests, free, losses=["damper", "both"], predict=["natural frequency@1.2 kV"])
    assert result.attrs["chosen"] == "taut film, loss both"
    assert float(np.diff(result["structure_objective"].values)[0]) < -30.0
    assert not result.attrs["refused"]
    off = np.log([1500.0 / 823.33, 0.02 * 2.0 * np.pi * drawn.frequency])
    found = result.sel(unknown=["material.viscous_modulus_1", "material.relaxation_time_1"])
    assert (np.abs(found["deviation"].values - off) < 2.5 * found["posterior"].values).all()
    assert (found["posterior"].values < 0.6).all()
    known = Variants(true, ["spring_rate"], np.ones((1, 1)), {}).natural_frequency(1200.0)[0]
    assert abs(float(result["predicted_value"][0]) - known) < 2.5 * float(result["predicted_spread"][0])
    device = fitted_device(result)
    assert device.material.branches == 1
    assert {"material.viscous_modulus_1", "damping_coefficient"} < set(fitted_draws(result).data_vars)


def test_losses_change_device_and_free_fields(lossy):
    true, drawn, tests = lossy
    problem = Problem(*_with_loss(true, {"spring_rate": 0.03}, "damper"), tests.tests, tests.gains)
    assert (problem.device.material.branches, list(problem.free)) == (0, ["spring_rate", "damping_coefficient"])
    own, free = _with_loss(drawn, {"damping_coefficient": 0.5}, "branch")
    assert (own.damping_coefficient, list(free)) == (0.0, ["material.viscous_modulus_1", "material.relaxation_time_1"])
    own, free = _with_loss(true, {"damping_coefficient": 0.5}, "both")
    assert (own.material.viscous_modulus_1, free["damping_coefficient"]) == (1500.0, 0.5)
    with pytest.raises(InputError, match="'friction' is not a structure of the loss; known: damper, branch, both"):
        fit_device(drawn, tests, {"spring_rate": 0.03}, losses=["friction"])
    with pytest.raises(InputError, match=r"^loss: needs damping_coefficient in place of a damping that changes"):
        plan_device(
            drawn.replace(damping_coefficient=None, quality_factor=9.0), tests, {"spring_rate": 0.03}, loss="both"
        )


def test_a_series_is_fitted(tmp_path):
    """Stroke and current of a step, thinned; the fit finds a mass that is 5 % off."""
    own = gelcone.find_device("biased-pump").replace(film="taut")
    time = np.linspace(0.0, 0.6, 1201)
    volts = np.minimum(1000.0 * time / 0.05, 1000.0)
    true = Variants(own.replace(moving_mass=1.05 * own.moving_mass), ["spring_rate"], np.ones((1, 1)), {})
    stroke, current = np.split(true.series(time, volts, ("stroke", "current"))[0], 2)
    rows = zip(time[::3], volts[::3], 1e3 * stroke, 1e6 * current, strict=True)
    text = "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows)
    (tmp_path / "run.csv").write_text(f"time (s),voltage (V),stroke (mm),current (uA)\n{text}\n")
    (tmp_path / "list.toml").write_text(
        '[[test]]\nkind = "series"\nfile = "run.csv"\nnoise = {stroke = "10 um", current = "10 nA"}\n'
    )
    tests = read_device_tests(tmp_path / "list.toml")
    assert (tests.tests[0].name, tests.tests[0].values.size) == ("series, run.csv", 802)
    result = fit_device(own, tests, {"moving_mass": 0.2, "damping_coefficient": 1.0})
    assert np.exp(float(result["deviation"][0])) == pytest.approx(1.05, rel=2e-3)
    assert set(result["reading_axis"].values) == {"time (s)"}
    assert gelcone.plot(result).axes[0].get_xlabel() == "time (s)"


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0,1,1\n1,2,1\n1,3,1", "the time 1 s follows 1 s; times must rise"),
        ("0,100,1", "has 1 times; a series takes 2 to"),
    ],
)
def test_times_that_cannot_be_followed_are_refused(rows, message, tmp_path):
    (tmp_path / "run.csv").write_text(f"time (s),voltage (V),stroke (mm)\n{rows}\n")
    (tmp_path / "list.toml").write_text('[[test]]\nkind = "series"\nfile = "run.csv"\nnoise = "10 um"\n')
    with pytest.raises(InputError, match=message):
        read_device_tests(tmp_path / "list.toml")


def with_readings(tests, values):
    found, at = [], 0
    for test in tests:
        read = {}
        for name, old in test.read.items():
            read[name], at = values[at : at + old.size], at + old.size
        found.append(type(test)(test.name, test.kind, test.set, read, test.noise))
    return tuple(found)


def test_a_voltage_beyond_every_pull_in_is_refused():
    own = problem(WRINKLING, "wrinkling")
    stroke = own.tests[1]
    high = type(stroke)(stroke.name, stroke.kind, {"voltage": 3.0 * stroke.set["voltage"]}, stroke.read, stroke.noise)
    with pytest.raises(
        InputError,
        match=r"of 10 measured voltages lie above the pull-in of every device within the priors \(highest 1,7\d\d V\)",
    ):
        fit_problem(Problem(own.device, {"spring_rate": 0.03}, (high,), own.gains), np.zeros(3))


def test_the_rows_above_pull_in_are_counted_for_each_reading(monkeypatch):
    """In phase and in quadrature: of three rows the last lies above, and only the readings that were lost count."""
    lost = np.array([False, True, True, False, False, True])
    own, drive = problem(TAUT, "taut"), {"voltage_amplitude": np.array([100.0, 900.0, 2100.0])}
    rows = drive | {"voltage_offset": np.zeros(3), "frequency": np.ones(3)}
    read = {"in_phase": np.zeros(3), "quadrature": np.zeros(3)}
    swinging = DeviceTest("a", "frequency response", rows, read, read)
    pull_in = {"pull_in_voltage": np.array([1000.0, 2000.0])}
    monkeypatch.setattr("gelcone.lab.device_fit.pull_in_voltage", lambda device: pull_in)
    said = _without_state(Problem(own.device, {"spring_rate": 0.03}, (swinging,), own.gains), lost)
    assert said.startswith(
        "2 of 6 measured voltages lie above the pull-in of every device within the priors (highest 2,0"
    )
    pull_in["pull_in_voltage"][:] = 3000.0
    said = _without_state(Problem(own.device, {"spring_rate": 0.03}, (swinging,), own.gains), lost)
    assert said.startswith("3 of 6 measured values lie where no device within the priors has a state: ")


# --- files and what is asked ------------------------------------------------------------------------------------------


def test_the_peak_of_a_row_is_that_of_its_whole_voltage():
    """Offset and amplitude together; of a series the largest of all, for its state follows from what came before."""
    read = {"in_phase": np.zeros(2), "quadrature": np.zeros(2)}
    drive = {"voltage_offset": np.array([-1e3, 900.0]), "voltage_amplitude": np.array([100.0, 300.0])}
    rows = {"frequency": np.array([8.0, 9.0])}
    assert _peaks(DeviceTest("a", "frequency response", drive | rows, read, read)).tolist() == [1100.0, 1200.0]
    series = {"time": np.array([0.0, 1.0, 2.0]), "voltage": np.array([0.0, -700.0, 300.0])}
    assert _peaks(DeviceTest("b", "series", series, {"stroke": np.zeros(3)}, {})).tolist() == [700.0] * 3
    assert _peaks(DeviceTest("c", "ring-down", {}, {"frequency": np.zeros(1)}, {})).tolist() == [0.0]


def test_a_gain_that_the_other_tests_do_not_use_is_as_uncertain_as_its_prior():
    own = problem(TAUT, "taut")
    free, tests = {"spring_rate": 0.1, "moving_mass": 0.2}, {test.kind: test for test in own.tests}
    whole = Problem(own.device, free, (tests["blocked force"], tests["stroke over voltage"]), own.gains)
    others = Problem(own.device, free, (tests["blocked force"],), own.gains)
    lost = set(whole.names) - set(others.names)
    assert lost == {"gain of the laser"}
    covariance = 1e-4 * (np.eye(len(others.names)) + 0.5)
    known = SimpleNamespace(logs=np.arange(1.0, 1.0 + len(others.names)), covariance=covariance)
    logs, found = _with_all_gains(whole, others, known)
    laser = whole.names.index("gain of the laser")
    rest = [whole.names.index(name) for name in others.names]
    assert (logs[laser], logs[rest].tolist()) == (0.0, known.logs.tolist())
    np.testing.assert_array_equal(found[np.ix_(rest, rest)], covariance)
    assert found[laser, laser] == own.gains["laser"] ** 2
    assert not found[laser, rest].any()


def test_the_example_is_the_certified_case():
    tests = read_device_tests(PUMP / "pump-tests.toml")
    for found, own in zip(tests.tests, problem(TAUT, "taut").tests, strict=True):
        np.testing.assert_allclose(found.values, own.values, rtol=1e-3, atol=1e-9)
        np.testing.assert_allclose(found.deviations, own.deviations, rtol=1e-3)
    assert tests.gains == {
        "load cell": 0.02,
        "laser": 0.01,
        "capacitance meter": 0.01,
        "ammeter": 0.01,
        "amplifier": 0.01,
    }
    assert tests.measured


def test_amplitude_and_phase_and_planned_points(tmp_path):
    (tmp_path / "list.toml").write_text(
        '[[test]]\nkind = "frequency response"\nvoltage_offset = "1 kV"\nvoltage_amplitude = "60 V"\nnoise = "10 um"\n'
        'frequency = ["8 Hz", "9 Hz"]\namplitude = ["1 mm", "2 mm"]\nphase = ["-30 deg", "90 deg"]\n'
        '[[test]]\nkind = "stroke over voltage"\nvoltage = ["500 V", "1 kV"]\nnoise = "10 um"\n'
    )
    response, planned = read_device_tests(tmp_path / "list.toml").tests
    np.testing.assert_allclose(response.read["in_phase"], [1e-3 * np.cos(np.pi / 6.0), 0.0], atol=1e-15)
    np.testing.assert_allclose(response.read["quadrature"], [-0.5e-3, 2e-3])
    assert np.isnan(planned.values).all()
    tests = DeviceTests((planned,), {"load cell": 0.02, "laser": 0.01, "amplifier": 0.01})
    pump = gelcone.find_device(PUMP / "pump.toml")
    assert np.isfinite(plan_device(pump, tests, {"spring_rate": 0.03})["posterior"]).all()
    with pytest.raises(InputError, match="a test has no readings; measure them, or ask for the plan"):
        fit_device(pump, tests, {"spring_rate": 0.03})


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_set_and_read_and_its_noise_are_in_units_of_their_own(kind, tmp_path):
    own = KINDS[kind]
    units = dict(own.set) | {name: reading.unit for name, reading in own.read.items()}
    lines = [f'{name} = ["{k + 1} {unit}", "{k + 2} {unit}"]' for k, (name, unit) in enumerate(units.items())]
    noise = ", ".join(f'{name} = "{k + 1} {reading.unit}"' for k, (name, reading) in enumerate(own.read.items()))
    (tmp_path / "list.toml").write_text("\n".join(["[[test]]", f'kind = "{kind}"', *lines, f"noise = {{ {noise} }}"]))
    (found,) = read_device_tests(tmp_path / "list.toml").tests
    stated = {name: [k + 1.0, k + 2.0] for k, name in enumerate(units)}
    assert {name: values.tolist() for name, values in (found.set | found.read).items()} == stated
    deviations = {name: [k + 1.0] * 2 for k, name in enumerate(own.read)}
    assert {name: values.tolist() for name, values in found.noise.items()} == deviations


def test_fields_that_change_the_form_of_a_membrane_are_not_free():
    pump = gelcone.find_device("biased-pump").replace(film="membrane")
    for name in ("disc_radius", "hoop_prestretch", "material.stretch_limit"):
        with pytest.raises(InputError, match=f"free {name}: the film 'membrane' is computed anew for each value"):
            Problem(pump, {"spring_rate": 0.03, name: 0.03}, (), {})


def test_readings_are_drawn_over_what_was_set_in_si():
    """The first of what varies: heights in metres, volts, hertz; else the numbers of the rows."""
    whole = problem(TAUT, "taut")
    found = _readings(SimpleNamespace(problem=whole, predicted=whole.values))
    assert {own.attrs["quantity"] for own in found.data_vars.values()} == {"code", "count", "share"}
    for k, test in enumerate(whole.tests):
        own = found.isel(reading=np.flatnonzero(found["reading_test"].values == k))
        (words,) = set(own["reading_axis"].values)
        name, count = words.partition(" (")[0], len(test.read)
        values = np.arange(own.sizes["reading"] // count) if name == "row" else test.set[name]
        np.testing.assert_array_equal(own["reading_along"], np.tile(values, count))
        assert words == "row" or words == f"{name} ({KINDS[test.kind].set[name]})"
        np.testing.assert_array_equal(own["measured"], test.values)
        np.testing.assert_array_equal(own["noise"], test.deviations)
        assert own["reading_unit"].values.tolist() == [reading.unit for reading in test.readings]
        assert own["reading_name"].values.tolist() == [name for name, read in test.read.items() for _ in read]


LISTS = {
    "an unknown kind": (
        'kind = "free force"',
        "'free force' is not a kind of test on a device; did you mean 'blocked force'",
    ),
    "no kind": ('noise = "1 mN"', "is not a kind of test on a device; known: blocked force"),
    "an unknown setting": ('kind = "ring-down"\nvolt = 1', "'volt' is not a setting of a ring-down test"),
    "no noise": (
        'kind = "ring-down"\nfrequency = "1 Hz"\ndecay = "1 1/s"',
        "the noise of frequency is missing; give noise",
    ),
    "no voltage": ('kind = "blocked force"\nheight = "1 mm"\nnoise = "1 mN"', "a blocked force test needs voltage"),
    "a bare number": ('kind = "stroke over voltage"\nvoltage = "5"\nnoise = "1 um"', "voltage = '5': has no unit"),
    "a wrong unit": (
        'kind = "stroke over voltage"\nvoltage = "5 N"\nnoise = "1 um"',
        "N is a unit of force, not of voltage",
    ),
    "negative noise": ('kind = "stroke over voltage"\nvoltage = "5 V"\nnoise = "-1 um"', "must be greater than 0"),
    "a column without a file": (
        'kind = "stroke over voltage"\nvoltage = "U, V"\nnoise = "1 um"',
        "but no file is given",
    ),
    "a file elsewhere": ('kind = "stroke over voltage"\nfile = "../x.csv"', "must lie in the folder of the list"),
    "uneven lists": (
        'kind = "stroke over voltage"\nvoltage = ["1 V", "2 V"]\nstroke = ["1 mm", "1 mm", "1 mm"]\nnoise = "1 um"',
        "voltage has 2 values and others 3; give one for each row",
    ),
    "a column without a unit": (
        'kind = "blocked force"\nfile = "f.csv"\nvoltage = "0 V"\nnoise = "1 mN"',
        'f.csv, line 1: column "F" has no unit; write "F (N)", or name it in tests.toml: force = "F, mN"',
    ),
    "kilovolts": (
        'kind = "blocked force"\nfile = "f.csv"\nvoltage = "U"\nforce = "F, mN"\nnoise = "1 mN"',
        "2 of 2 voltages are below 20 V: kilovolts? write the unit",
    ),
    "a column that is not there": (
        'kind = "blocked force"\nfile = "f.csv"\nvoltage = "0 V"\nforce = "P, mN"\nnoise = "1 mN"',
        "'P' is not a column",
    ),
    "gaps": (
        'kind = "blocked force"\nfile = "gap.csv"\nvoltage = "0 V"\nnoise = "1 mN"',
        "line 3: column 'F' has an empty cell; complete it, or leave the row out",
    ),
}


@pytest.mark.parametrize("kind", LISTS)
def test_a_list_that_is_wrong_is_refused_in_one_line(kind, tmp_path):
    (tmp_path / "f.csv").write_text("height (mm),U,F\n1,1,2\n2,1.5,3\n")
    (tmp_path / "gap.csv").write_text("height (mm),F (mN)\n1,2\n2,\n3,4\n")
    text, message = LISTS[kind]
    (tmp_path / "list.toml").write_text(f"[[test]]\n{text}\n")
    with pytest.raises(InputError) as error:
        read_device_tests(tmp_path / "list.toml")
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_instruments_are_known(tmp_path):
    ring = '[[test]]\nkind = "ring-down"\nnoise = {frequency = "0.1 Hz", decay = "0.1 1/s"}\n'
    (tmp_path / "list.toml").write_text(f'{ring}[instruments]\nlaser = "0.5 %"\n')
    assert read_device_tests(tmp_path / "list.toml").gains["laser"] == 0.005
    for text, message in (("lazer = 0.1", "'lazer' is not an instrument"), ("laser = '0 %'", "a share such as")):
        (tmp_path / "list.toml").write_text(f"{ring}[instruments]\n{text}\n")
        with pytest.raises(InputError, match=message):
            read_device_tests(tmp_path / "list.toml")


def test_priors_are_relative_or_absolute():
    pump = gelcone.find_device(PUMP / "pump.toml")
    assert read_free(["spring_rate~3%", "film_thickness~6 um"], pump) == {
        "spring_rate": pytest.approx(0.03),
        "film_thickness": pytest.approx(0.03),
    }
    with pytest.warns(DoubtfulInput, match=r"^free spring_rate: has no prior; give one where it was measured"):
        assert read_free(["spring_rate"], pump)["spring_rate"] == 10.0
    for text, message in (
        ("spring_rate~0%", "a share such as '2 %'"),
        ("spring_rate~3 mm", "mm is a unit of length, not of stiffness"),
        ("nothing~3%", "is not a field that can be fitted"),
    ):
        with pytest.raises(InputError, match=message):
            read_free([text], pump)
    with pytest.raises(InputError, match=r"^free spring_rate: is given twice"):
        read_free(["spring_rate~1%", "spring_rate~2%"], pump)


def test_three_fields_that_change_together_are_one_too_many():
    whole = problem(TAUT, "taut")
    names = ["material.shear_modulus", "film_thickness", "material.relative_permittivity"]
    tests = DeviceTests(whole.tests, whole.gains)
    with pytest.raises(InputError, match="these three are one number too many: mu H and eps/H are all that any test"):
        fit_device(whole.device, tests, dict.fromkeys(names, 10.0))
    with pytest.raises(InputError, match="is not a film that can be fitted; known: taut, wrinkling, membrane"):
        fit_device(whole.device, tests, {"spring_rate": 0.1}, films=["foil"])
    with pytest.raises(InputError, match="free: names no field; give some with priors"):
        plan_device(whole.device, tests, {})


def measured_with(device, factors, gains, films_tests, seed):
    """Tests with readings of a device whose fields are multiplied, as its instruments show them."""
    rng = np.random.default_rng(seed)
    shown = Variants(
        device, list(factors), np.array([list(factors.values())]), {k: np.array([v]) for k, v in gains.items()}
    )
    made = []
    for test in films_tests:
        values = shown.predict(test)[0] + rng.standard_normal(test.values.size) * test.deviations
        parts = np.split(values, np.cumsum([len(own) for own in test.read.values()])[:-1])
        made.append(type(test)(test.name, test.kind, test.set, dict(zip(test.read, parts, strict=True)), test.noise))
    return tuple(made)


LOADED = """
[[test]]
kind = "stroke over load"
load = ["0 mN", "20 mN", "40 mN"]
voltage = "1.5 kV"
noise = "5 um"
[[test]]
kind = "capacitance"
height = ["10 mm", "12 mm", "14 mm"]
voltage = "100 V"
noise = "1 pF"
[[test]]
kind = "stroke over voltage"
voltage = ["0.5 kV", "1 kV", "1.5 kV"]
noise = "5 um"
"""


@pytest.mark.parametrize("film", ["taut", "membrane"])
def test_loads_and_capacitances_are_fitted_also_on_the_membrane(film, tmp_path):
    """The fields with which the readings were made are found within what the fit says."""
    (tmp_path / "tests.toml").write_text(LOADED)
    planned = read_device_tests(tmp_path / "tests.toml")
    device = gelcone.find_device("biased-pump").replace(film=film)
    truth = {"film_thickness": 1.04, "spring_rate": 0.97, "material.shear_modulus": 1.1}
    used = [one for one in planned.tests if film == "taut" or one.kind != "capacitance"]  # an integral of a second each
    tests = measured_with(device, truth, {"laser": 1.005, "capacitance meter": 0.992}, used, 3)
    free = {"film_thickness": 0.05, "spring_rate": 0.1, "material.shear_modulus": 0.3}
    found = fit_problem(Problem(device, free, tests, planned.gains))
    spreads = np.sqrt(np.diag(found.covariance))
    apart = found.logs[:3] - np.log(list(truth.values()))
    assert (np.abs(apart) < 3.0 * spreads[:3]).all()
    assert spreads[2] < 0.5 * free["material.shear_modulus"]
    assert found.p_value > 1e-3


def test_a_profile_is_the_curvature_where_the_objective_is_a_parabola():
    whole = problem(TAUT, "taut")
    fitted = fit_problem(whole)
    k = fitted.problem.names.index("spring_rate")
    low, high = profiled(fitted, "spring_rate")
    spread = float(np.sqrt(fitted.covariance[k, k]))
    assert (low - fitted.logs[k]) / spread == pytest.approx(-1.96, rel=0.03)
    assert (high - fitted.logs[k]) / spread == pytest.approx(1.96, rel=0.03)
    with pytest.raises(InputError, match="profile: 'mass' is not a free field or gain of this fit"):
        fit_device(whole.device, DeviceTests(whole.tests, whole.gains), {"spring_rate": 0.03}, profile=["mass"])


def test_directions_are_shown_with_as_many_zeros_as_there_can_be():
    """The same plane; one entry of each is not zero where no other direction has one, the largest is 1, and entries of
    either sign count. By hand: (4, 3, 3, 2) over its pivot less 0.75 times the other is (1, 0, 1.35, 0.125)."""
    rows = np.array([[1.0, -2.0, 0.5, 0.0], [3.0, 1.0, -1.0, 4.0]])
    mixed = np.array([[0.8, 0.3], [-0.5, 0.9]]) @ rows
    found = _simple(mixed)
    assert np.linalg.matrix_rank(np.concatenate([rows, found])) == 2
    assert (found < -0.1).any()
    alone = np.isclose(found, 0.0).sum(axis=0) == 1
    assert (~np.isclose(found[:, alone], 0.0)).any(axis=1).all()
    np.testing.assert_allclose([found.max(axis=1), np.abs(found).max(axis=1)], 1.0)
    found = _simple(np.array([[4.0, 3.0, 3.0, 2.0], [0.0, 1.0, -0.8, 0.5]]))
    np.testing.assert_allclose(found, [[20.0 / 27.0, 0.0, 1.0, 5.0 / 54.0], [0.0, 1.0, -0.8, 0.5]])
    noisy = _simple(np.array([[1.0, 1e-4, -1e-4, -0.5]]))
    np.testing.assert_array_equal(noisy, [[1.0, 0.0, 0.0, -0.5]])
