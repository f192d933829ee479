"""Tangent maps of any number of states: known exponents, fixed points; two states by both formulas."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from gelcone.codes import Regime
from gelcone.motion import orbit, tangents
from gelcone.motion.attractor import cycle
from gelcone.motion.attractor.classification import RETURNS
from gelcone.motion.exponents import average
from gelcone.motion.lyapunov import lyapunov
from gelcone.motion.regime import regime
from gelcone.motion.settle import Clock
from gelcone.motion.tangents import TangentRun, advance, first_frames, qr_growth, resolved, solved
from gelcone.physics.model import ConeModel
from tests import recorded
from tests.recorded import numbers
from tests.toys import FilteredVoltage, SeriesResistor

TURN = np.array([[np.cos(0.7), -np.sin(0.7), 0.0], [np.sin(0.7), np.cos(0.7), 0.0], [0.0, 0.0, 1.0]])


def basis(seed=3, size=3):
    """A basis that is neither orthogonal nor aligned with the axes."""
    return np.eye(size) + 0.4 * np.random.default_rng(seed).normal(size=(size, size))


def conjugated(matrix):
    own = basis(size=len(matrix))
    return own @ matrix @ np.linalg.inv(own)


# --- two states by both formulas --------------------------------------------------------------------------------------


def both_ways(monkeypatch, compute):
    fast = compute()
    with monkeypatch.context() as patch:
        patch.setattr(tangents, "_two_states", lambda matrices: False)
        return fast, compute()


def test_growth_of_two_states_is_the_same_by_both_formulas(monkeypatch):
    maps = np.random.default_rng(1).normal(size=(30, 25, 2, 2))
    fast, slow = both_ways(monkeypatch, lambda: qr_growth(maps, first_frames(np.zeros((30, 2)))))
    np.testing.assert_allclose(slow[0], fast[0], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(np.abs(slow[1]), np.abs(fast[1]), rtol=0.0, atol=1e-12)


def test_solutions_for_two_states_are_the_same_by_both_formulas(monkeypatch):
    rng = np.random.default_rng(4)
    matrices, right = np.eye(2) + 0.3 * rng.normal(size=(40, 2, 2)), rng.normal(size=(40, 2))
    fast, slow = both_ways(monkeypatch, lambda: solved(matrices, right))
    np.testing.assert_allclose(slow, fast, rtol=1e-12)


# --- three states -----------------------------------------------------------------------------------------------------


def test_growth_of_three_states_has_the_exponents_of_the_map():
    """Eigenvalues 2, 0.5 and 1e-4 in a skew basis: the growth settles on their logarithms."""
    step = conjugated(np.diag([2.0, 0.5, 1e-4]))
    growth, frames = qr_growth(np.tile(step, (2, 60, 1, 1)), first_frames(np.zeros((2, 3))))
    np.testing.assert_allclose(growth[:, 40:].mean(axis=1), np.tile(np.log([2.0, 0.5, 1e-4]), (2, 1)), rtol=1e-9)
    np.testing.assert_allclose(frames.swapaxes(1, 2) @ frames, np.tile(np.eye(3), (2, 1, 1)), atol=1e-14)


def test_growth_of_a_rotation_that_shrinks():
    """A spiral of modulus e^-0.1 and a fast direction e^-2: the first two exponents are equal."""
    step = conjugated(TURN @ np.diag(np.exp([-0.1, -0.1, -2.0])))
    growth, _ = qr_growth(np.tile(step, (1, 900, 1, 1)), first_frames(np.zeros((1, 3))))
    np.testing.assert_allclose(growth[0].mean(axis=0), [-0.1, -0.1, -2.0], atol=5e-3)
    assert growth[0].sum(axis=1) == pytest.approx(-2.2, abs=1e-12)


def test_growth_goes_on_where_it_stopped_and_a_lost_member_leaves_the_others():
    maps = np.random.default_rng(5).normal(size=(3, 8, 3, 3))
    whole, end = qr_growth(maps, first_frames(np.zeros((3, 3))))
    first, between = qr_growth(maps[:, :3], first_frames(np.zeros((3, 3))))
    second, last = qr_growth(maps[:, 3:], between)
    np.testing.assert_array_equal(np.concatenate([first, second], axis=1), whole)
    np.testing.assert_array_equal(last, end)
    maps[1, 4] = np.nan
    lost, _ = qr_growth(maps, first_frames(np.zeros((3, 3))))
    assert np.isnan(lost[1, 4:]).all()
    np.testing.assert_array_equal(lost[[0, 2]], whole[[0, 2]])


def test_equations_without_a_solution_leave_the_others():
    rng = np.random.default_rng(6)
    matrices, right = rng.normal(size=(4, 3, 3)), rng.normal(size=(4, 3))
    matrices[1], matrices[2] = 0.0, np.nan
    found = solved(matrices, right)
    assert np.isnan(found[1:3]).all()
    for i in (0, 3):
        np.testing.assert_allclose(matrices[i] @ found[i], right[i], atol=1e-12)


def test_a_growth_that_its_map_does_not_hold_is_left_by_the_others_if_it_is_the_last():
    """With errors of 1e-15 a map of entries near 1 holds exp(-20), and not exp(-40)."""
    growth, whole = np.array([[[-0.1, -20.0, -40.0], [-0.1, -35.0, -40.0]]]), np.array([[-60.0, -75.0]])
    error = 1e-15 * np.exp(-growth)
    found, left = resolved(growth, error, whole)
    np.testing.assert_allclose(found, [[[-0.1, -20.0, -39.9], [-0.1, np.nan, np.nan]]])
    np.testing.assert_allclose(
        left, [[[error[0, 0, 0], error[0, 0, 1], error[0, 0, :2].sum()], [error[0, 1, 0], np.nan, np.nan]]]
    )
    np.testing.assert_array_equal(resolved(growth, error, whole, maps=10**7)[0], growth)


# --- along a made-up flow of three states -----------------------------------------------------------------------------

RATES = np.array([[-0.02, 1.0, 0.3], [-1.0, -0.02, 0.1], [0.0, 0.0, -3.0]])
CENTRE = np.array([0.3, -0.1, 0.5])


def linear_flow(members, initial, times, *, start=0.0, keep="states", **options):
    """Motions of x' = RATES (x - CENTRE), in the place of `integrate`."""
    begin = np.broadcast_to(start, (len(initial),))
    states, maps = np.empty((*times.shape, 3)), np.empty((*times.shape, 3, 3))
    for i, row in enumerate(times):
        before = begin[i]
        state = initial[i]
        for k, time in enumerate(row):
            maps[i, k] = expm(RATES * (time - before))
            state = CENTRE + maps[i, k] @ (state - CENTRE)
            states[i, k], before = state, time
    spans = np.diff(times, axis=1, prepend=begin[:, None])
    outcome = np.zeros(len(initial), dtype=np.int8)
    return SimpleNamespace(states=states, tangents=maps, divergence=np.trace(RATES) * spans, outcome=outcome)


@pytest.fixture
def three_states(monkeypatch):
    """What so many members of `linear_flow` say of themselves."""
    monkeypatch.setattr(tangents, "integrate", linear_flow)
    monkeypatch.setattr(orbit, "integrate", linear_flow)
    system = SimpleNamespace(mirror=np.array([-1.0, -1.0, 1.0]), planar=False)

    def members(count):
        own = {"rate": 3.0, "fastest": 3.0, "forcing_period": 2.0}
        own = {name: np.full(count, value) for name, value in own.items()}
        return SimpleNamespace(system=system, size=count, shape=(count,), take=lambda rows: members(len(rows)), **own)

    return members


def test_advance_gives_three_exponents_also_over_long_stretches(three_states):
    """Over stretches of 60 fast time scales the last growth is what the divergence leaves."""
    for per_repeat in (8, 1):
        clock = Clock(per_repeat, 8, np.full(2, 20.0), np.ones(2))
        run = TangentRun.at(np.zeros((2, 3)))
        advance(three_states(2), run, clock, 8)
        growth, trace = advance(three_states(2), run, clock, 400)
        np.testing.assert_allclose(growth.mean(axis=1) / clock.spacing[:, None], [[-0.02, -0.02, -3.0]] * 2, atol=1e-3)
        np.testing.assert_allclose(growth.sum(axis=2), -3.04 * 20.0 / per_repeat, rtol=1e-12)
        np.testing.assert_allclose(trace, -3.04 * 20.0 / per_repeat, rtol=1e-12)


def test_the_error_of_a_run_is_the_largest_of_all_its_stretches(three_states):
    """An early part with maps of 1e-6 is not made good by a later one with maps of 1e-9."""
    clock, run = Clock(32, 32, np.full(2, 20.0), np.ones(2)), TangentRun.at(np.zeros((2, 3)))
    advance(three_states(2), run, clock, 64, tolerance=1e-6)
    early = run.error.copy()
    assert (early > 5e-7).all()
    advance(three_states(2), run, clock, 64, tolerance=1e-9)
    np.testing.assert_array_equal(run.error, early)


def test_newton_steps_to_the_fixed_point_of_three_states(three_states):
    first, second = orbit.newton(three_states(1), np.zeros((1, 3)), 3, 4, (1e-15, 1e-15))
    np.testing.assert_allclose(first.step[0], CENTRE, atol=1e-12)
    np.testing.assert_allclose(second.path[0], np.tile(CENTRE, (12, 1)), atol=1e-12)
    for turn in (first, second):
        np.testing.assert_allclose(turn.log_multipliers[0] / 6.0, [-0.02, -0.02, -3.0], atol=1e-9)


def test_a_path_with_a_third_state_is_its_own_mirror_image():
    """Half a period later the disc is on the other side, and the voltage on the film the same."""
    turn = np.pi * np.arange(16).reshape(1, 2, 8) / 8.0
    path = np.stack([np.sin(turn), np.cos(turn), np.cos(2.0 * turn)], axis=3)
    period, size = np.array([2]), np.ones(1)
    assert cycle._is_symmetric(path, period, size, np.array([-1.0, -1.0, 1.0])).tolist() == [True]
    assert cycle._is_symmetric(path, period, size, np.array([-1.0, -1.0, -1.0])).tolist() == [False]


# --- a real film behind a filter --------------------------------------------------------------------------------------


def filtered(**parameters):
    return ConeModel(circuit=FilteredVoltage(), damping_ratio=0.05, **parameters)


def test_three_exponents_of_an_undriven_film_behind_a_filter():
    """The disc's own two are -zeta; the third is the rate of the filter, of which the motion knows nothing."""
    model = filtered(voltage=0.0)
    rate = -1.0 / float(model.values["filter_time"])
    result = lyapunov(model, (0.3, 0.0), window=50.0, budget=2_000.0)
    np.testing.assert_allclose(result["lyapunov"], sorted([-0.05, -0.05, rate], reverse=True), atol=1e-7)
    assert int(result["cycle"]) == 1
    assert abs(float(result["sum_residual"])) < 1e-9


def test_the_cycle_of_a_film_behind_a_filter_has_the_exponents_of_its_average():
    """Newton's steps and multipliers in three states against growth along the motion; their sum is the divergence."""
    model = filtered(voltage=0.8, spring_stiffness=1.0, rest_height=0.3)
    cycle_result = lyapunov(model, window=600.0)
    assert int(cycle_result["cycle"]) == 1
    found, averaged = cycle_result["lyapunov"].values, cycle_result["finite"].values
    values = model.values
    trace = -2.0 * float(values["damping_ratio"]) - 1.0 / float(values["filter_time"])
    assert found.sum() == pytest.approx(trace, abs=1e-9)
    np.testing.assert_allclose(averaged, found, atol=0.02)
    named = regime(model)
    assert Regime(int(named["regime"])) == Regime.PERIODIC
    assert named["section"].shape == (RETURNS, 3)
    np.testing.assert_allclose(named["lyapunov"], found, atol=1e-8)


def test_exponents_add_up_to_the_trace_along_the_motion():
    """Behind a resistor the film's charge decays at 1/(rho C(x)), which differs from that at the flat film."""
    model = ConeModel(
        circuit=SeriesResistor(), series_resistance=0.8, voltage=0.8, damping_ratio=0.2, film="taut",
        spring_stiffness=0.5, rest_height=0.8, drive_frequency=0.7,
    )  # fmt: skip
    found = lyapunov(model, window=100.0, budget=2_000.0)
    assert int(found["cycle"]) == 1
    system, n = model.system, model.own_numbers

    def trace(tau, z):
        moved = [(z + 1e-5 * row, z - 1e-5 * row) for row in np.eye(3)]
        rates = [(system.rates(tau, up, n)[i], system.rates(tau, down, n)[i]) for i, (up, down) in enumerate(moved)]
        return sum(up - down for up, down in rates) / 2e-5

    def with_trace(tau, z):
        return [*system.rates(tau, z[:3], n), trace(tau, z[:3])]

    span = np.array([10, 12]) * 2 * np.pi / 0.7
    run = solve_ivp(with_trace, (0.0, span[1]), [1.0, 0.0, 0.0, 0.0], "DOP853", rtol=1e-9, atol=1e-10, t_eval=span)
    mean = (run.y[3, 1] - run.y[3, 0]) / np.diff(span)[0]
    assert abs(mean - trace(0.0, np.zeros(3))) > 0.05
    assert float(found["lyapunov"].sum()) == pytest.approx(mean, abs=1e-6)
    assert abs(float(found["sum_residual"])) < 1e-9
    averaged = average(model.members(), run.y[:3, 0][None], budget=500.0)
    assert averaged.divergence[0] == pytest.approx(mean, abs=1e-6)
    assert averaged.values.sum() == pytest.approx(mean, abs=1e-6)


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_a_run_continues_at_the_phase_in_which_it_stopped_and_its_first_failure_counts(monkeypatch):
    """Four stretches to a period of 3, of which six are done; the second member has failed before."""
    members = ConeModel(damping_ratio=[0.1, 0.2]).members()
    run = TangentRun(numbers(2, 2), first_frames(numbers(2, 2)), 6, np.array([0, 4], dtype=np.int8), np.zeros((2, 2)))
    clock = Clock(4, 4, np.array([3.0, 6.0]), np.ones(2))

    def ran(members, states, times, **options):
        shape = (*times.shape, 2, 2)
        return SimpleNamespace(
            tangents=np.broadcast_to(np.diag([2.0, 0.5]), shape), divergence=None, states=numbers(*times.shape, 2,
            at=5.0),
            outcome=np.array([3, 5], dtype=np.int8),
        )  # fmt: skip

    asked = recorded.record(monkeypatch, tangents, integrate=ran)
    growth, whole = advance(members, run, clock, 3, tolerance=2e-9, threads=5)
    (call,) = asked["integrate"]
    np.testing.assert_allclose(call["start"], [1.5, 3.0])
    np.testing.assert_allclose(call["times"], [[2.25, 3.0, 3.75], [4.5, 6.0, 7.5]])
    assert (call["keep"], call["tolerance"], call["threads"]) == ("tangents", 2e-9, 5)
    np.testing.assert_array_equal(call["initial"], numbers(2, 2))
    np.testing.assert_allclose(growth, [[[np.log(2.0), -np.log(2.0)]] * 3] * 2)
    np.testing.assert_allclose(whole, [[-2.0 * 0.1 * 0.75] * 3, [-2.0 * 0.2 * 1.5] * 3])
    np.testing.assert_array_equal(run.states, numbers(2, 3, 2, at=5.0)[:, -1])
    assert run.done == 9
    assert run.outcome.tolist() == [3, 4]
    part = run.take([1])
    assert (part.done, part.outcome.tolist(), part.states.tolist()) == (9, [4], run.states[1:].tolist())
