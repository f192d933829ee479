"""The flow: certified trajectories, exact facts, ensembles to the last bit, outcomes, tangents, and its contract."""

import dataclasses
import json
import pickle
import threading
from pathlib import Path
from types import SimpleNamespace

import heyoka_backend as heyoka
import numpy as np
import pytest
from scipy.linalg import expm

from gelcone import codes
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion import flow
from gelcone.motion.engine import backend
from gelcone.motion.engine import run as runs
from gelcone.motion.flow import integrate
from gelcone.motion.job import KEEPS
from gelcone.physics.laws import LAWS, Gent
from gelcone.physics.model import ConeModel
from tests.recorded import numbers

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "trajectories.json").read_text())
every_case = pytest.mark.parametrize("case", REFERENCE, ids=[f"case{i}" for i in range(len(REFERENCE))])
every_keep = pytest.mark.parametrize("keep", KEEPS)


def certified(case):
    """Model, initial state, times and states of a case of the reference file."""
    p = {name: float(value) for name, value in case["parameters"].items()}
    model = ConeModel(
        damping_ratio=p["zeta"],
        spring_stiffness=p["k"],
        voltage=p["v"],
        drive_frequency=p["omega"],
        stretch_limit=p["J"],
        meridional_prestretch=p["meridional"],
        hoop_prestretch=p["hoop"],
        rest_height=p["rest"],
    )
    table = np.array(case["trajectory"])
    return model, [float(number) for number in case["initial"]], table[:, 0], table[:, 1:]


def varied(count=21, **fixed):
    """An ensemble whose members differ in everything: stiffness, drive, limit, pre-stretch and start."""
    rng = np.random.default_rng(8)
    parameters = {
        "damping_ratio": rng.uniform(0.0, 0.3, count),
        "spring_stiffness": rng.uniform(0.1, 4.0, count),
        "voltage": rng.uniform(0.0, 1.5, count),
        "voltage_bias": rng.uniform(-0.5, 0.5, count),
        "drive_frequency": rng.uniform(0.1, 3.0, count),
        "stretch_limit": rng.uniform(2.0, 60.0, count),
        "hoop_prestretch": rng.uniform(0.8, 1.3, count),
        "rest_height": rng.uniform(-0.2, 0.2, count),
    }
    return ConeModel(**parameters | fixed), rng.uniform(-0.7, 0.7, (count, 2))


def assert_same(one, other):
    """Two sets of trajectories are equal to the last bit."""
    for name in (field.name for field in dataclasses.fields(one)):
        a, b = getattr(one, name), getattr(other, name)
        assert (a is None) == (b is None)
        if a is not None:
            np.testing.assert_array_equal(a, b, err_msg=name)


def rows(run, members):
    """The same trajectories, of some members only."""
    fields = {field.name: getattr(run, field.name) for field in dataclasses.fields(run)}
    return flow.Trajectories(**{name: None if value is None else value[members] for name, value in fields.items()})


# --- certified numbers and convergence --------------------------------------------------------------------------------


@every_case
@every_keep
def test_trajectories_agree_with_34_digit_arithmetic(case, keep):
    model, initial, times, states = certified(case)
    run = integrate(model, initial, times, keep=keep)
    error = np.abs(run.states[0] - states).max(axis=1) / np.abs(states).max(axis=1)
    assert error.max() < 1e-13
    np.testing.assert_array_equal(run.outcome, [Outcome.OK])


@every_case
def test_the_error_falls_with_the_tolerance(case):
    model, initial, times, states = certified(case)
    tolerances = 10.0 ** -np.arange(6, 14)
    errors = [
        np.abs(integrate(model, initial, times, tolerance=tolerance).states[0] - states).max()
        for tolerance in tolerances
    ]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.85 < slope < 1.1
    assert (errors < 10.0 * tolerances).all()
    assert errors[-1] < 1e-13


# --- exact facts ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("keep", ["states", "work"])
def test_energy_is_conserved_over_a_thousand_natural_periods(keep):
    model = ConeModel(
        damping_ratio=0.0,
        voltage=0.0,
        spring_stiffness=[0.5, 1.5, 3.0, 1.0],
        stretch_limit=[2.0, 50.0, np.inf, 1.2],
        rest_height=[0.0, 0.2, 0.0, -0.1],
        prestretch=[1.0, 1.0, 1.2, 0.9],
    )
    period = 2.0 * np.pi / np.sqrt(model.spring_stiffness)
    run = integrate(model, (0.8, 0.1), period[:, None] * np.arange(1001), keep=keep)
    x, u = np.moveaxis(run.states, 2, 0)
    energy = model.energy(x) + 0.5 * u * u
    np.testing.assert_allclose(energy, np.repeat(energy[:, :1], 1001, axis=1), rtol=1e-12)
    if keep == "work":
        film = model.system.film.work(x, 0.0, [], model.numbers(trailing=1))
        np.testing.assert_allclose(run.work[..., 0], film[:, :1] - film, atol=1e-12)
        np.testing.assert_array_equal(run.work[..., 1], 0.0)


def test_mirrored_starts_give_mirrored_motion_to_the_last_bit():
    model, initial = varied(rest_height=0.0)
    times = np.linspace(0.0, 50.0, 60)
    one, other = (integrate(model, sign * initial, times, keep="tangents") for sign in (1.0, -1.0))
    np.testing.assert_array_equal(one.states, -other.states)
    np.testing.assert_array_equal(one.tangents, other.tangents)


def test_rest_at_zero_is_a_solution():
    model, _ = varied(rest_height=0.0, voltage_bias=2.0)
    np.testing.assert_array_equal(integrate(model, (0.0, 0.0), [1.0, 40.0]).states, 0.0)


def test_a_small_motion_without_limit_drive_and_damping_is_harmonic():
    """x = a cos(sqrt(kappa) tau), with the film's cubic term a^2 below the rounding of the comparison."""
    kappa = np.array([0.3, 1.0, 7.0])
    model = ConeModel(damping_ratio=0.0, voltage=0.0, spring_stiffness=kappa, stretch_limit=np.inf)
    times = np.linspace(0.0, 40.0, 81)
    amplitude = 1e-7
    x, u = np.moveaxis(integrate(model, (amplitude, 0.0), times).states, 2, 0)
    phase = np.sqrt(kappa)[:, None] * times
    np.testing.assert_allclose(x, amplitude * np.cos(phase), atol=1e-12 * amplitude)
    np.testing.assert_allclose(u, -amplitude * np.sqrt(kappa)[:, None] * np.sin(phase), atol=1e-11 * amplitude)


def test_a_small_motion_with_damping_and_a_constant_voltage_is_the_damped_oscillator():
    kappa, zeta, bias = 2.0, 0.1, 0.7
    model = ConeModel(
        damping_ratio=zeta, spring_stiffness=kappa, voltage=0.0, voltage_bias=bias, prestretch=1.2, stretch_limit=9.0
    )
    matrix = np.array([[0.0, 1.0], [-float(model.stiffness(0.0, bias)), -2.0 * zeta]])
    times = np.array([0.5, 3.0, 20.0])
    start = np.array([1e-7, 2e-7])
    expected = [expm(matrix * t) @ start for t in times]
    np.testing.assert_allclose(integrate(model, start, times).states[0], expected, atol=1e-19)


def test_the_drive_is_periodic_and_its_phase_is_set_by_the_start():
    """A start one forcing period later is the same motion; a start at another phase is another one."""
    model, initial = varied(count=9, voltage=1.2, voltage_bias=0.0, rest_height=0.0)
    times = np.linspace(0.5, 6.0, 12)
    first = integrate(model, initial, times)
    later = model.forcing_period
    again = integrate(model, initial, later[:, None] + times, start=later)
    np.testing.assert_allclose(again.states, first.states, rtol=1e-10, atol=1e-12)
    np.testing.assert_array_equal(again.times, later[:, None] + times)
    shifted = integrate(model, initial, 0.25 * later[:, None] + times, start=0.25 * later)
    assert (np.abs(shifted.states - first.states).max(axis=(1, 2)) > 1e-2).all()


def test_going_on_from_a_state_is_the_same_motion():
    model, initial = varied()
    whole = integrate(model, initial, [3.0, 7.0])
    rest = integrate(model, whole.states[:, 0], [7.0], start=3.0)
    np.testing.assert_allclose(rest.states[:, 0], whole.states[:, 1], rtol=1e-11, atol=1e-12)


@every_keep
def test_how_often_is_sampled_changes_nothing_beyond_the_tolerance(keep):
    model, initial = varied()
    few, many = (integrate(model, initial, np.linspace(0.0, 30.0, n + 1), keep=keep) for n in (3, 3000))
    np.testing.assert_allclose(many.states[:, ::1000], few.states, rtol=1e-10, atol=1e-11)
    if keep == "work":
        np.testing.assert_allclose(many.work[:, ::1000], few.work, rtol=1e-10, atol=1e-11)
    if keep == "tangents":
        product = np.broadcast_to(np.eye(2), (model.size, 2, 2))
        for k in range(1, 1001):
            product = many.tangents[:, k] @ product
        np.testing.assert_allclose(product, few.tangents[:, 1], rtol=1e-9, atol=1e-10)


def test_a_gap_of_many_calls_is_crossed_in_pieces():
    """Longer than `CALL_SPAN`: in pieces whose ends are not kept, on the same motion."""
    model = ConeModel(damping_ratio=0.02, voltage=0.8)
    far = 10.0 * codes.CALL_SPAN
    alone = integrate(model, (1.0, 0.0), [far])
    among = integrate(model, (1.0, 0.0), np.linspace(0.0, far, 3001))
    np.testing.assert_allclose(alone.states[0, -1], among.states[0, -1], rtol=1e-11, atol=1e-12)
    assert alone.states.shape == (1, 1, 2)


# --- ensembles: to the last bit ---------------------------------------------------------------------------------------


@every_keep
def test_an_ensemble_equals_its_members_one_by_one(keep):
    model, initial = varied()
    times = np.linspace(0.0, 25.0, 40)
    ensemble = integrate(model, initial, times, keep=keep)
    for i in range(model.size):
        assert_same(rows(ensemble, [i]), integrate(model.take([i]), initial[i], times, keep=keep))


@every_keep
def test_threads_change_no_bit(keep):
    model, initial = varied(count=40)
    times = np.linspace(0.0, 25.0, 40)
    one = integrate(model, initial, times, keep=keep, threads=1)
    for threads in (2, 5, None):
        assert_same(one, integrate(model, initial, times, keep=keep, threads=threads))


@every_keep
def test_the_order_of_the_members_is_irrelevant(keep):
    model, initial = varied()
    times = np.cumsum(np.random.default_rng(3).uniform(0.1, 40.0, (model.size, 12)), axis=1)
    order = np.random.default_rng(4).permutation(model.size)
    straight = integrate(model, initial, times, keep=keep)
    assert_same(rows(straight, order), integrate(model.take(order), initial[order], times[order], keep=keep))


def test_an_ensemble_of_several_dims_is_flattened_in_c_order():
    model = ConeModel(voltage=[[0.2], [0.9]], spring_stiffness=[1.0, 2.0, 3.0])
    run = integrate(model, (0.5, 0.0), [4.0])
    single = integrate(ConeModel(voltage=0.9, spring_stiffness=2.0), (0.5, 0.0), [4.0])
    np.testing.assert_array_equal(run.states[4], single.states[0])


def test_integrators_are_kept_apart_when_several_threads_integrate_at_once():
    model, initial = varied(count=16)
    times = np.linspace(0.0, 25.0, 40)
    expected = integrate(model, initial, times, threads=1)
    found = []

    def work():
        found.extend(integrate(model, initial, times, threads=2) for _ in range(5))

    workers = [threading.Thread(target=work) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(found) == 20
    for run in found:
        assert_same(run, expected)


# --- outcomes ---------------------------------------------------------------------------------------------------------


def bad_members():
    """name -> a member that does not arrive, its start, and what becomes of it; all share the Gent law."""
    gent = ConeModel(stretch_limit=2.0, damping_ratio=0.0, voltage=0.0)
    free = ConeModel(stretch_limit=np.inf, damping_ratio=0.0, voltage=0.0)
    return {
        "outside": (gent, (3.0, 0.0), Outcome.OUTSIDE),
        "at the wall": (gent, ((1 - 1e-14) * np.sqrt(1 + np.sqrt(3.0)), 0.0), Outcome.STRETCH_LIMIT),
        "thrown at the wall": (gent, (0.0, 1e6), Outcome.STRETCH_LIMIT),
        "unbounded": (free.replace(voltage_bias=3.0), (1.0, 0.0), Outcome.NOT_FINITE),
        "not a number": (gent, (np.nan, 0.0), Outcome.NOT_FINITE),
        "infinitely fast": (gent, (0.0, np.inf), Outcome.NOT_FINITE),
        "infinitely far without limit": (free, (np.inf, 0.0), Outcome.OUTSIDE),
    }


def among(model, initial, member, start, position):
    """The ensemble with one member put in at ``position``."""
    parameters = {
        name: np.insert(np.broadcast_to(value, model.shape), position, member.parameters()[name])
        for name, value in model.parameters().items()
        if not isinstance(value, str)
    }
    return ConeModel(**parameters), np.insert(initial, position, start, axis=0)


@every_keep
@pytest.mark.parametrize("name", bad_members())
def test_a_member_that_fails_says_why_and_changes_no_bit_of_its_neighbours(name, keep):
    member, start, outcome = bad_members()[name]
    model, initial = varied(count=7, hoop_prestretch=1.0)
    model = model.replace(prestretch=1.0)
    times = np.linspace(0.0, 300.0, 31)
    alone = integrate(model, initial, times, keep=keep)
    assert (alone.outcome == Outcome.OK).all()
    together = integrate(*among(model, initial, member, start, 3), times, keep=keep)
    assert together.outcome[3] == outcome
    assert np.isnan(together.states[3, -1]).all()
    neighbours = np.delete(np.arange(8), 3)
    assert_same(rows(together, neighbours), alone)


def test_after_a_failure_all_samples_are_nan_and_before_it_none():
    model = ConeModel(stretch_limit=np.inf, voltage=0.0, voltage_bias=3.0)
    run = integrate(model, (1e-3, 0.0), np.arange(0.0, 600.0))
    gone = np.isnan(run.states[0]).any(axis=1)
    assert run.outcome[0] == Outcome.NOT_FINITE
    assert gone.any()
    assert not gone[0]
    assert (np.diff(gone.astype(int)) >= 0).all()
    np.testing.assert_array_equal(gone, np.isnan(run.states[0]).all(axis=1))


@every_keep
def test_a_member_that_needs_too_many_steps_says_so_and_changes_no_bit_of_its_neighbours(keep, monkeypatch):
    monkeypatch.setattr(backend, "STEPS_PER_CALL", 400)
    monkeypatch.setattr(backend, "CALL_SPAN", 100.0)
    model, initial = varied(count=7, drive_frequency=0.5)
    times = np.arange(0.0, 60.0)
    alone = integrate(model, initial, times, keep=keep)
    assert (alone.outcome == Outcome.OK).all()
    hasty = ConeModel(drive_frequency=5e3, hoop_prestretch=1.0, voltage_bias=0.1)
    together = integrate(*among(model, initial, hasty, (0.1, 0.0), 5), times, keep=keep)
    assert together.outcome[5] == Outcome.STEP_LIMIT
    assert np.isnan(together.states[5, -1]).all()
    assert_same(rows(together, np.delete(np.arange(8), 5)), alone)


def test_a_very_stiff_member_is_not_taken_for_one_at_the_wall():
    kappa = 1e16
    model = ConeModel(spring_stiffness=kappa, damping_ratio=0.0, voltage=0.0)
    run = integrate(model, (1e-3, 0.0), [1e-7])
    assert run.outcome[0] == Outcome.OK
    assert run.states[0, 0, 0] == pytest.approx(1e-3 * np.cos(1e-7 * np.sqrt(kappa)), rel=1e-6)


def test_every_outcome_has_a_meaning_of_one_line():
    for outcome in Outcome:
        assert outcome.meaning
        assert "\n" not in outcome.meaning


# --- tangents and work ------------------------------------------------------------------------------------------------


def test_tangents_are_the_derivative_of_the_motion():
    """Against central differences over a short run: each column is a deviation carried along."""
    model, initial = varied(count=12)
    times = np.array([2.0])
    tangents = integrate(model, initial, times, keep="tangents").tangents[:, 0]
    h = 1e-5
    for column, shift in enumerate(h * np.eye(2)):
        ahead, behind = (integrate(model, initial + sign * shift, times).states[:, 0] for sign in (1.0, -1.0))
        np.testing.assert_allclose(tangents[:, :, column], (ahead - behind) / (2.0 * h), rtol=1e-7, atol=1e-8)


@every_case
def test_tangents_equal_heyokas_variational_equations(case):
    hk = heyoka.import_heyoka()
    model, initial, times, _ = certified(case)
    tangents = integrate(model, initial, times, keep="tangents").tangents[0]
    system = hk.var_ode_sys(heyoka.equations(model.system, "states"), hk.var_args.vars, order=1)
    variational = hk.taylor_adaptive(system, list(initial), tol=1e-15)
    variational.pars[:] = [float(model.own_numbers[name]) for name in model.system.numbers]
    total = np.eye(2)
    for time, tangent in zip(times, tangents, strict=True):
        variational.propagate_until(time)
        total = tangent @ total
        expected = variational.state[variational.get_vslice(order=1)].reshape(2, 2)
        np.testing.assert_allclose(total, expected, rtol=1e-10, atol=1e-11 * np.abs(expected).max())


def test_the_tangent_map_shrinks_areas_by_the_damping():
    """det = exp(-2 zeta T) for any motion: the sum rule of the Lyapunov exponents."""
    model, initial = varied(count=30)
    times = np.linspace(0.0, 40.0, 81)
    determinants = np.linalg.det(integrate(model, initial, times, keep="tangents").tangents)
    expected = np.exp(-2.0 * model.damping_ratio[:, None] * np.diff(times, prepend=0.0))
    np.testing.assert_allclose(determinants, expected, rtol=1e-10)


def test_work_is_the_integral_of_the_powers():
    model, initial = varied(count=6)
    times = np.linspace(0.0, 10.0, 4001)
    run = integrate(model, initial, times, keep="work")
    x, u = np.moveaxis(run.states, 2, 0)
    v = model.voltage_bias[:, None] + model.voltage[:, None] * np.sin(model.drive_frequency[:, None] * times)
    force = model.system.film.force(x, v * v, [], model.numbers(trailing=1))[0]
    powers = -force * u, 2.0 * model.damping_ratio[:, None] * u * u
    for column, power in enumerate(powers):
        simpson = (power[:, :-1:2] + 4.0 * power[:, 1::2] + power[:, 2::2]).sum(axis=1) * (times[1] / 3.0)
        np.testing.assert_allclose(run.work[:, -1, column], simpson, rtol=1e-9, atol=1e-10)
    np.testing.assert_array_equal(run.work[:, 0], 0.0)


# --- the contract -----------------------------------------------------------------------------------------------------


def test_the_first_sample_may_be_the_start():
    model, initial = varied(count=3)
    run = integrate(model, initial, [0.0, 1.0], keep="tangents")
    np.testing.assert_array_equal(run.states[:, 0], initial)
    np.testing.assert_array_equal(run.tangents[:, 0], np.broadcast_to(np.eye(2), (3, 2, 2)))
    later = integrate(model, initial, [1.0], keep="tangents")
    np.testing.assert_array_equal(run.states[:, 1], later.states[:, 0])
    only = integrate(model, initial, [2.5], start=2.5)
    np.testing.assert_array_equal(only.states[:, 0], initial)


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_adds_up_to_one(threads, monkeypatch):
    monkeypatch.setattr(runs, "REPORT_EVERY", 0.0)
    monkeypatch.setattr(runs, "FIRST_STEPS", 256)
    model, initial = varied(count=20)
    shares = []
    integrate(model, initial, np.linspace(0.0, 900.0, 10), threads=threads, progress=shares.append)
    assert len(shares) > 3
    assert min(shares) > 0.0
    assert sum(shares) == pytest.approx(1.0)


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_ends_the_run_and_leaves_the_next_one_right(threads):
    model, initial = varied(count=20)
    times = np.linspace(0.0, 900.0, 10)
    expected = integrate(model, initial, times)

    def interrupt(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        integrate(model, initial, times, threads=threads, progress=interrupt)
    assert_same(integrate(model, initial, times, threads=threads), expected)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": []}, "times: must be at least one and, like the start, finite"),
        ({"times": [1.0, np.nan]}, "times: must be at least one and, like the start, finite"),
        ({"times": [1.0, np.inf, np.inf]}, "times: must be at least one and, like the start, finite"),
        ({"start": np.nan}, "times: must be at least one and, like the start, finite"),
        ({"times": [1.0, 1.0]}, "times: must increase and not be before the start; sort them and leave out doubles"),
        ({"times": [2.0, 1.0]}, "times: must increase and not be before the start"),
        ({"times": [-1.0, 1.0]}, "times: must increase and not be before the start"),
        ({"times": [1.0], "start": 2.0}, "times: must increase and not be before the start"),
        ({"times": np.arange(1.0, 9.0).reshape(2, 4)}, "times: must be numbers of shape (4,) or (3, 4), not (2, 4)"),
        ({"times": ["soon"]}, "times: must be numbers of shape (1,) or (3, 1), not (1,)"),
        ({"initial": (1.0, 0.0, 0.0)}, "initial: must be numbers of shape (2,) or (3, 2), not (3,)"),
        ({"initial": (1.0,)}, "initial: must be numbers of shape (2,) or (3, 2), not (1,)"),
        ({"initial": 1.0}, "initial: must be numbers of shape (2,) or (3, 2), not ()"),
        ({"initial": "up"}, "initial: must be numbers of shape (2,) or (3, 2), not ()"),
        ({"start": [0.0, 0.0]}, "start: must be numbers of shape () or (3,), not (2,)"),
        ({"keep": "tangent"}, "'tangent' is not a thing to keep; did you mean 'tangents'?"),
        ({"tolerance": 0.0}, "tolerance = 0.0: must be a number above 0 and below 1, for example 1e-15"),
        ({"tolerance": np.nan}, "tolerance = nan: must be a number above 0 and below 1"),
        ({"tolerance": "fine"}, "tolerance = 'fine': must be a number above 0 and below 1"),
        ({"threads": 0}, "threads = 0: must be at least 1; leave it out to use all cores"),
    ],
)
def test_bad_input_is_refused_in_one_line(options, message):
    arguments = {"initial": (1.0, 0.0), "times": [1.0]} | options
    with pytest.raises(InputError) as error:
        integrate(ConeModel(voltage=[0.1, 0.5, 1.0]), **arguments)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_law_of_ones_own_is_compiled_too():
    class Doubled(Gent):
        name = "doubled"

    model = ConeModel(law=Doubled(), stretch_limit=5.0)
    expected = integrate(ConeModel(stretch_limit=5.0), (0.5, 0.0), [3.0])
    np.testing.assert_array_equal(integrate(model, (0.5, 0.0), [3.0]).states, expected.states)


@pytest.mark.parametrize("law", LAWS)
def test_a_model_from_another_process_needs_no_new_program(law):
    model = ConeModel(voltage=0.3, law=law)
    integrate(model, (0.1, 0.0), [1.0])
    programs = backend._program.cache_info().currsize
    integrate(pickle.loads(pickle.dumps(model)), (0.1, 0.0), [1.0])
    assert backend._program.cache_info().currsize == programs


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_the_integrator_is_asked_for_what_can_run_and_every_step_of_every_member_is_counted(monkeypatch):
    """Of three members the second cannot start; films that a jump may end are looked at with the same watch."""
    watch, jobs, shares = SimpleNamespace(steps=5), [], []

    def run(job, *, threads, progress, watch):
        jobs.append((job, threads, progress, watch))
        if job != "more":
            job.result.steps[:] = [7, 0, 11]

    monkeypatch.setattr(flow, "backend", lambda: SimpleNamespace(run=run))
    monkeypatch.setattr(flow, "end_films", lambda job, run: run("more"))
    monkeypatch.setattr(flow, "current_watch", lambda: watch)
    model = ConeModel(stretch_limit=[50.0, 1e-3, 50.0], damping_ratio=0.1)
    found = integrate(
        model,
        numbers(3, 2, at=0.5),
        [2.0, 3.0],
        start=2.0,
        keep="work",
        tolerance=2e-9,
        threads=5,
        progress=shares.append,
    )
    (job, threads, progress, own), more = jobs
    assert (threads, progress, own) == (5, shares.append, watch)
    assert more == ("more", 5, None, watch)
    assert job.runs.tolist() == [True, False, True]
    assert found.outcome.tolist() == [Outcome.OK, Outcome.OUTSIDE, Outcome.OK]
    np.testing.assert_array_equal(job.states0, numbers(3, 2, at=0.5))
    np.testing.assert_array_equal(
        found.states[:, 0], [numbers(3, 2, at=0.5)[0], [np.nan] * 2, numbers(3, 2, at=0.5)[2]]
    )
    np.testing.assert_array_equal(found.work[[0, 2], 0], 0.0)
    assert np.isnan(found.work[1]).all()
    assert np.isnan(found.states[:, 1]).all()
    np.testing.assert_array_equal(job.gaps, [[0.0, 1.0]] * 3)
    assert (job.keep, job.tolerance, job.start.tolist()) == ("work", 2e-9, [2.0] * 3)
    assert watch.steps == 5 + 18


@pytest.mark.parametrize("times", [[1.0, 1.0], [0.5, 0.25], [-1.0, 1.0]])
def test_times_that_do_not_increase_or_lie_before_the_start_are_refused(times):
    with pytest.raises(InputError, match="times: must increase"):
        integrate(ConeModel(), (0.1, 0.0), times)
