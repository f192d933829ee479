"""Motions of the wrinkling film across its borders against independently computed ones, and what holds exactly."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone import frequency, lyapunov, regime, simulate, static
from gelcone.codes import FilmPullIn, Outcome, Regime
from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.motion.engine import backend
from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.interruptions import border_events, switches_at
from gelcone.motion.engine.program import Program
from gelcone.motion.flow import integrate
from gelcone.motion.validity import ASSUMPTIONS
from gelcone.physics.film.wrinkling import PULL_IN, STATES, WrinklingCone
from gelcone.physics.model import ConeModel

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "wrinkling.json").read_text())
SETS = {"base": (0.9, 0.1), "fast": (0.5, 0.3)}
PRESTRETCHES = {"lp1": (1.0, 1.0), "radial1.5": (1.0, 1.5), "equi1.5": (1.5, 1.5)}


def model_of(case, **film):
    limit = {} if case["J"] == "inf" else {"stretch_limit": float(case["J"])}
    return ConeModel(
        film=WrinklingCone(**film),
        law="neo-hookean" if case["J"] == "inf" else "gent",
        damping_ratio=case["zeta"],
        spring_stiffness=case["kappa"],
        rest_height=case["x0"],
        voltage=case["v"],
        drive_frequency=case["omega"],
        meridional_prestretch=case["lm"],
        hoop_prestretch=case["lh"],
        **limit,
    )


@pytest.mark.parametrize("case", REFERENCE["trajectories"], ids=lambda case: case["case"])
def test_trajectories_of_the_reference(case):
    times = [state["tau"] for state in case["states"]]
    run = integrate(model_of(case), case["start"], times)
    wanted = [[state["x"], state["velocity"]] for state in case["states"]]
    np.testing.assert_allclose(run.states[0], wanted, atol=5e-12)
    assert run.film_times.sum() == pytest.approx(times[-1], abs=1e-12)
    first = case["first_borders"][0]
    if case["case"].startswith("C"):  # one stretch of taut film, then none that pulls
        run = integrate(model_of(case), case["start"], [case["first_borders"][1]["tau"]])
        slack = case["first_borders"][1]["tau"] - first["tau"]
        assert run.film_times[0, 0, 2] == pytest.approx(slack, abs=1e-9)


@pytest.mark.parametrize("case", REFERENCE["pull_in_times_from_x1"], ids=lambda case: f"{case['set']} {case['pre']}")
def test_pull_in_of_the_reference(case):
    kappa, omega = SETS[case["set"]]
    lm, lh = PRESTRETCHES[case["pre"]]
    given = {"kappa": kappa, "omega": omega, "v": case["v"], "lm": lm, "lh": lh, "J": 50, "x0": 0.0, "zeta": 0.01}
    ends = {}
    for pull_in in ("minimum", "first"):
        run = integrate(model_of(given, pull_in=pull_in), (1.0, 0.0), [200.0])
        ends[pull_in] = run.end_times[0]
        if case["tau_pull_in"] is None:
            assert run.outcome[0] == Outcome.OK
            continue
        assert run.outcome[0] == Outcome.PULLED_IN
        if pull_in == "minimum" or run.pull_in[0, 0] == FilmPullIn.MINIMUM:
            assert run.end_times[0] == pytest.approx(case["tau_pull_in"], abs=1e-11)
            assert run.end_states[0, 0] == pytest.approx(case["x_pull_in"], abs=1e-11)
    assert ends["first"] <= ends["minimum"] + 1e-12


def test_energy_is_kept_across_borders_without_damping_under_constant_voltage():
    """1,000 natural periods that cross two borders four times each."""
    model = ConeModel(
        film="wrinkling", damping_ratio=0.0, spring_stiffness=0.9, rest_height=0.6, voltage=0.0, voltage_bias=0.5
    )
    times = np.linspace(0.0, 2000.0 * np.pi / np.sqrt(0.9), 400)
    run = integrate(model, (1.1, 0.0), times)
    x, u = run.states[0].T
    n = model.members().numbers_at(0)
    energy = 0.5 * u * u + model.system.film.work(x, 0.25, [], n) + 0.45 * (x - 0.6) ** 2
    assert (run.film_times[0, 0, [0, 1, 3]] > 10.0).all()
    np.testing.assert_allclose(energy, energy[0], atol=1e-10)


def test_a_film_that_slackens_at_rest_ends_as_rest():
    """At lp = 1 all borders meet at rest; the run goes on, in few steps, as a damped spring."""
    model = ConeModel(film="wrinkling", damping_ratio=0.05, spring_stiffness=0.9, voltage=[0.0, 0.5], prestretch=1.0)
    run = integrate(model, (0.01, 0.0), [2000.0])
    assert (run.outcome == Outcome.OK).all()
    assert (np.abs(run.states) < 1e-20).all()
    assert (run.steps < 20_000).all()
    at_rest = integrate(model, (0.0, 0.0), [1000.0])
    assert (at_rest.outcome == Outcome.OK).all()
    assert (at_rest.states == 0.0).all()


@pytest.mark.parametrize("case", REFERENCE["lle_tests"], ids=lambda case: case["case"])
def test_exponents_of_the_reference(case):
    """Its two integrators differ by more than the error that it states."""
    run = lyapunov(model_of(case), tuple(case["start"]))
    known = case["err"] + abs(case["lle"] - case["lle_other_integrator"])
    largest, error = float(run["lyapunov"][0]), float(run["standard_error"][0])
    assert abs(largest - case["lle"]) < known + 3.0 * error
    assert abs(float(run["sum_residual"])) < 1e-12


def test_a_run_says_in_which_states_the_film_was_and_where_it_pulled_in():
    model = ConeModel(
        film="wrinkling", spring_stiffness=0.9, damping_ratio=0.01, drive_frequency=0.1, voltage=[0.5, 1.04]
    )
    run = simulate(model, (1.0, 0.0), periods=1)
    shares = sum(run[f"film_state_{kind}"] for kind in ("taut", "hoop_slack", "meridional_slack", "crumpled"))
    np.testing.assert_allclose(shares, 1.0, atol=1e-14)
    assert run["outcome"].values.tolist() == [Outcome.OK, Outcome.PULLED_IN]
    assert float(run["pull_in_time"][1]) == pytest.approx(7.272791117551, abs=1e-11)
    assert float(run["pull_in_film_voltage"][1]) == pytest.approx(0.691433218, abs=1e-9)
    assert np.isnan(run["pull_in_time"][0])
    assert float(abs(run["energy_residual"]).max()) < 1e-12
    assert float(run["meridional_stress"].min()) >= 0.0


def test_a_held_film_pulls_in_where_the_statics_say_and_not_beyond_the_valley():
    """A stiff spring holds the disc while the voltage rises slowly. Behind the valley of Vb, x = 1.218 at J = 8 and
    3.499 at J = 50, a film localises while its hoop is slack or, from x = 1.218 and 3.65 on, crumples and stays.
    """
    height = np.array([1.1, 1.2, 1.25, 1.6, 1.2, 3.3, 3.6, 3.8])
    model = ConeModel(
        film="wrinkling", stretch_limit=[8.0] * 4 + [50.0] * 4, rest_height=height, spring_stiffness=400.0,
        damping_ratio=20.0, voltage=1.0, drive_frequency=0.005,
    )  # fmt: skip
    run = integrate(model, np.stack([height, np.zeros(8)], axis=1), np.full((8, 1), 300.0), tolerance=1e-9)
    ends = np.array([True, True, False, False, True, True, True, False])
    np.testing.assert_array_equal(run.outcome == Outcome.PULLED_IN, ends)
    assert (run.film_times[~ends, 0, 3] > 50.0).all()
    members, squared = model.members(), np.sin(0.005 * run.end_times) ** 2
    numbers = {name: members.number(name) for name in members.system.numbers}
    limit = model.film.highest_squared(run.end_states[:, 0], numbers)
    np.testing.assert_allclose(limit[ends], squared[ends], rtol=1e-8)
    assert (limit[~ends] > 1e5).all()
    force = model.film.force(run.end_states[:, 0], squared, [], numbers)[0]
    np.testing.assert_array_equal(force[~ends], 0.0)


def test_a_film_that_goes_on_after_pull_in_says_for_how_long_it_has_failed():
    """Near the flat film without pre-stretch it fails at the first fold of the reference; memoryless it is back there,
    snapping at the second."""
    folds = REFERENCE["folds_of_Vb"]["50.0"]
    begin, end = (np.arcsin(np.sqrt(folds[name]) / 1.04) for name in ("VG_c", "VG_f"))
    exact = {"memoryless": 1.0 - 2.0 * begin / np.pi, "snap": 1.0 - (begin + end) / np.pi}
    for pull_in, share in exact.items():
        model = ConeModel(film="wrinkling", pull_in=pull_in, voltage=1.04, damping_ratio=0.05, prestretch=1.0)
        run = simulate(model, (0.01, 0.0), periods=3)
        assert int(run["outcome"]) == Outcome.OK
        assert float(run["film_state_pulled_in"]) == pytest.approx(share, abs=1e-9)
        assert float(run["validity_pulled_in"]) == float(run["film_state_pulled_in"])
        assert "failed" in model.film.describe()


def test_a_film_that_has_failed_does_not_pull_until_it_snaps_back():
    """Its acceleration is that of spring and damping alone while it has failed, which is where a minimum is there again
    too."""
    model = ConeModel(
        film="wrinkling", pull_in="snap", voltage=1.3, voltage_bias=0.3, hoop_prestretch=1.5, meridional_prestretch=1.2,
        spring_stiffness=0.9, damping_ratio=0.05, drive_frequency=0.7, stretch_limit=50.0,
    )  # fmt: skip
    members, times = model.members(), np.linspace(0.0, 60.0, 30_001)
    run = integrate(model, (1.0, 0.0), times)
    x, u = run.states[0].T
    free = np.abs(np.gradient(u, times) + 0.1 * u + 0.9 * x) < 1e-4
    assert free.mean() == pytest.approx(
        run.film_times[0, 0, 4] / 60.0 + run.film_times[0, 0, 2:4].sum() / 60.0, abs=0.01
    )
    squared, n = (0.3 + 1.3 * np.sin(0.7 * times)) ** 2, members.numbers_at(0)
    pulls = model.film.force(x, squared, [], {name: np.asarray(v) for name, v in n.items()})[0] / x > 0.01
    assert (free & pulls).mean() > 0.01
    late = free & pulls & (squared < 0.99 * n["valley_squared"])
    assert late.mean() < 1e-3  # samples whose differences reach over the snap


def test_studies_of_pull_in_change_nothing_for_a_film_that_is_whole():
    model, initial = random_films(8, seed=3)
    model = model.replace(voltage=0.3, voltage_bias=0.1)
    ends = [integrate(model.replace(pull_in=name), initial, [20.0]).states for name in PULL_IN]
    for other in ends[1:]:
        np.testing.assert_allclose(other, ends[0], rtol=0.0, atol=1e-11)


def test_a_slack_film_with_a_low_stretch_limit_does_not_switch_on_and_on():
    """Mounted with too little length for its gap: evenly compressed lengths would lie beyond its stretch limit."""
    model = ConeModel(
        film="wrinkling",
        damping_ratio=0.0,
        spring_stiffness=1.2221,
        rest_height=0.4107,
        voltage=2.9474,
        drive_frequency=2.1234,
        meridional_prestretch=0.7532,
        hoop_prestretch=0.7532,
        stretch_limit=0.8373,
    )
    run = integrate(model, (1.1228, 0.2085), [20.0])
    assert int(run.steps[0]) < 10_000
    often = integrate(model, (1.1228, 0.2085), np.linspace(0.1, 20.0, 200))
    assert often.outcome[0] == run.outcome[0] == Outcome.OK
    np.testing.assert_allclose(often.states[0, -1], run.states[0, -1], rtol=0.0, atol=1e-10)


def test_the_way_to_pull_in_is_part_of_models_and_devices():
    model = ConeModel(film="wrinkling", pull_in="snap", second_film="wrinkling", second_flat_height=0.5)
    assert model.system.films[1].film.pull_in == "snap"
    assert ConeModel.from_parameters(model.parameters()).film == model.film
    assert model.replace(voltage=0.2).film.pull_in == "snap"
    pump = find_device("biased-pump").replace(film="wrinkling")
    assert pump.replace(pull_in="minimum").to_model().film.pull_in == "minimum"
    with pytest.raises(InputError, match="did you mean 'snap'"):
        pump.replace(pull_in="snp")
    with pytest.raises(InputError, match="take the film wrinkling"):
        ConeModel(pull_in="snap")


@pytest.mark.parametrize("of", ["regime", "frequency"])
def test_settled_motions_say_in_which_states_the_film_is(of):
    model = ConeModel(
        film="wrinkling", spring_stiffness=0.9, damping_ratio=0.1, voltage=0.5, rest_height=0.4, prestretch=1.0
    )
    found = regime(model, (0.5, 0.0)) if of == "regime" else frequency(model, [0.9, 1.0])
    shares = [found[f"film_state_{kind}"].values for kind in STATES]
    np.testing.assert_allclose(sum(shares), 1.0, atol=1e-12)
    assert (shares[0] > 0.1).all()
    assert (shares[0] < 0.9).all()
    if of == "regime":
        late = integrate(model, (0.5, 0.0), [400.0 * np.pi, 420.0 * np.pi])
        early = integrate(model, (0.5, 0.0), [400.0 * np.pi])
        exact = (late.film_times - early.film_times)[0, 0] / (20.0 * np.pi)
        np.testing.assert_allclose(shares, exact, atol=3.0 * float(found["validity_error"]))
    assert "film_state_taut" not in regime(model.replace(film="taut"), (0.5, 0.0), budget=1.0)


def random_films(count, seed=7):
    """Films of all kinds, half of which pull in or wrinkle within the run."""
    random = np.random.default_rng(seed)
    model = ConeModel(
        film="wrinkling",
        damping_ratio=random.uniform(0.0, 0.1, count),
        spring_stiffness=random.uniform(0.3, 1.5, count),
        rest_height=random.uniform(-0.5, 0.8, count),
        voltage=random.uniform(0.0, 0.8, count),
        voltage_bias=random.uniform(0.0, 0.3, count),
        drive_frequency=random.uniform(0.1, 1.5, count),
        meridional_prestretch=random.uniform(0.9, 1.3, count),
        hoop_prestretch=random.uniform(0.9, 1.5, count),
    )
    return model, random.uniform(-1.2, 1.2, (count, 2))


def test_numbers_have_the_same_bits_on_every_width_and_processor():
    model, initial = random_films(24)
    members, times = model.members(), np.linspace(0.0, 20.0, 5)
    program = backend._program(members.system, "states", 1e-10)
    start = np.zeros(24)
    numbers = {name: members.number(name) for name in members.system.numbers}
    numbers |= switches_at(members.system, start, initial, numbers)
    events = border_events(members.system)
    haswell = compiler.Machine(compiler.host().triple, "haswell", "")
    raw = program.run(numbers, initial, 0.0, np.tile(times, (24, 1)))
    assert 1 < (raw.status > 0).sum() < 20
    shuffled = np.random.default_rng(1).permutation(24)
    for width, machine in ((4, None), (2, haswell)):
        other = Program(members.system, "states", 1e-10, events, width=width, machine=machine)
        some = {name: value[shuffled] for name, value in numbers.items()}
        again = other.run(some, initial[shuffled], 0.0, np.tile(times, (24, 1)), threads=2)
        for name in ("states", "end_time", "end_state", "dwell", "status"):
            own = np.ascontiguousarray(getattr(raw, name)[shuffled]).view(np.int64)
            np.testing.assert_array_equal(own, np.ascontiguousarray(getattr(again, name)).view(np.int64), err_msg=name)


@pytest.mark.slow
def test_random_films_move_as_the_law_without_branches_says():
    """Against SciPy with the statics' own force, which knows nothing of borders."""
    model, initial = random_films(6, seed=3)
    run = integrate(model, initial, [4.0])
    members = model.members()
    for i in np.flatnonzero(run.outcome == Outcome.OK):
        n = members.numbers_at(i)
        wanted = solve_ivp(
            lambda t, z, n=n: members.system.rates(t, z, n), (0.0, 4.0), initial[i], "DOP853", rtol=1e-10, atol=1e-12,
            max_step=0.02,
        ).y[:, -1]  # fmt: skip
        np.testing.assert_allclose(run.states[i, 0], wanted, atol=1e-6)


def test_a_shipped_device_is_chaotic_while_its_film_is_whole():
    model = find_device("snap-cone").to_model().replace(film="wrinkling")
    found = regime(model, (0.4, 0.0), patience=500.0, budget=3000.0)
    assert (Regime(int(found.regime)), int(found.doubtful)) == (Regime.CHAOTIC, 0)
    assert float(found.share_chaotic) == 1.0
    assert float(found.lyapunov[0]) == pytest.approx(0.12, abs=0.02)
    assert float(found.lyapunov[0]) > 10.0 * float(found.standard_error[0])
    assert [float(found[f"validity_{name}"]) for name in ASSUMPTIONS] == [0.0] * len(ASSUMPTIONS)
    run = integrate(model, (0.4, 0.0), [1000.0])
    assert run.outcome[0] == Outcome.OK
    assert run.film_times[0, 0, 0] == pytest.approx(1000.0, rel=1e-12)


def test_the_shares_of_slack_film_are_those_of_its_states():
    """A wrinkled film has no stress in a slack direction instead of a compressive one: its states tell. That is no
    failure of the model."""
    model = ConeModel(film="wrinkling", voltage=0.3, drive_frequency=0.3, spring_stiffness=0.5, damping_ratio=0.05)
    found = simulate(model, [1.0, 0.0], periods=20)
    hoops = float(found["film_state_hoop_slack"]) + float(found["film_state_crumpled"])
    meridians = float(found["film_state_meridional_slack"]) + float(found["film_state_crumpled"])
    # Every 57th sample is where the voltage is zero, and a flat film without voltage taut.
    assert float(found["hoop_slack"].mean()) == pytest.approx(hoops, abs=1.0 / 57.0)
    assert float(found["meridional_slack"].mean()) == pytest.approx(meridians, abs=1.0 / 57.0)
    assert hoops > 0.5
    assert found["validity_hoop_slack"] == found["validity_meridional_slack"] == 0.0


@pytest.mark.parametrize("law", ["neo-hookean", "yeoh", "gent"])
@pytest.mark.parametrize("x", [-0.66, -0.2])
def test_a_second_film_that_cannot_hold_its_voltage_has_pulled_in_at_the_start(law, x):
    """Its hoops have no stress-free width there: the root of the law with force does not exist."""
    model = ConeModel(
        film="taut", second_film="wrinkling", second_flat_height=1.0, law=law, spring_stiffness=0.1, rest_height=0.4,
        meridional_prestretch=1.1, hoop_prestretch=1.2, voltage=0.0, voltage_bias=0.9,
    )  # fmt: skip
    run = integrate(model, np.array([[x, 0.1]]), np.array([[5.0]]))
    assert run.outcome[0] == Outcome.PULLED_IN
    assert run.end_times[0] == 0.0
    assert run.pull_in[0].tolist() == [FilmPullIn.NONE, FilmPullIn.MINIMUM]


def test_the_current_follows_from_the_states():
    """Against differences of the charge along a run sampled 1e-5 apart; at the ends, at borders, and between samples
    that nearly coincide, where differences of the samples say nothing."""
    model = ConeModel(
        film="wrinkling",
        prestretch=1.2,
        stretch_limit=5.0,
        rest_height=0.5,
        spring_stiffness=1.0,
        damping_ratio=0.1,
        drive_frequency=0.35,
        voltage=0.75,
    )
    even = np.linspace(0.5, 40.0, 400)
    times = np.sort(np.concatenate([even - 1e-5, even, even + 1e-5]))
    run = simulate(model, (0.5, 0.0), times=times)
    assert set(run["film_state"].values) >= {0, 2}
    voltage = run["drive_voltage"].values
    charge = 2.0 * run["field_energy"].values / voltage
    expected = (charge[2::3] - charge[::3]) / 2e-5
    np.testing.assert_allclose(run["current"].values[1::3], expected, atol=1e-6)
    crowded = np.sort(np.concatenate([even, even + 1e-13]))
    np.testing.assert_allclose(
        simulate(model, (0.5, 0.0), times=crowded)["current"].values[::2], run["current"].values[1::3], atol=1e-10
    )


def test_static_force_and_stiffness_are_unknown_beyond_localisation():
    model = ConeModel(film="wrinkling", stretch_limit=50.0)
    x = np.array([0.3, 1.3, 1.6])
    limit = float(model.film.highest_squared(1.3, model.own_numbers))
    for level, known in ((np.sqrt(limit) * (1.0 - 1e-9), True), (np.sqrt(limit) * (1.0 + 1e-9), False)):
        assert np.isfinite(model.force(1.3, level)) == known
        assert np.isfinite(model.stiffness(1.3, level)) == known
        found = static(model, voltages=[level], displacements=x)
        assert np.isfinite(found["force"].values[0, 1]) == known
        assert np.isfinite(found["stiffness"].values[0, 1]) == known
    assert np.isfinite(model.film.force(1.3, limit * 1.01, [], model.own_numbers)[0])  # it has localised, not ended


@pytest.mark.parametrize("voltage", [0.0, 0.1])
def test_static_force_is_unknown_where_the_second_film_alone_has_pulled_in(voltage):
    """It localises at V = 0.3118, and has a force up to the end of its minimum."""
    second = {"second_film": "wrinkling", "second_drive": "constant", "second_flat_height": 1.6}
    model = ConeModel(film="wrinkling", second_voltage=np.sqrt([0.31, 0.32]), **second)
    force = model.force(np.array([0.3, 0.3]), voltage)
    assert np.isfinite(force).tolist() == [True, False]


@pytest.mark.parametrize("stretches", [(1.3, 1.05), (1.05, 1.3)], ids=["thinner first", "thinner second"])
def test_of_two_films_behind_a_resistance_the_one_whose_minimum_ends_has_pulled_in(stretches):
    """The one that is stretched less is the first to crumple; mirrored, the other."""
    lengths = dict(zip(("prestretch", "second_prestretch"), stretches, strict=True))
    model = ConeModel(
        film="wrinkling", second_film="wrinkling", second_flat_height=1.0, prestretch_mode="equibiaxial",
        law="neo-hookean", rest_height=0.5, damping_ratio=0.3, voltage=0.0, voltage_bias=1.0, series_resistance=0.05,
        **lengths,
    )  # fmt: skip
    run = simulate(model, (0.5, 0.0), times=[20.0])
    lost, kept = ("second_", "") if stretches[0] > stretches[1] else ("", "second_")
    assert int(run[f"{kept}pull_in_kind"]) == FilmPullIn.NONE
    assert int(run[f"{lost}pull_in_kind"]) == FilmPullIn.MINIMUM
    assert float(run[f"{lost}pull_in_time"]) == pytest.approx(0.2907, abs=1e-4)
