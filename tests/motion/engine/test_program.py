"""What programs compute, and how members end."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import heyoka as hk
import numpy as np
import pytest
from engine_systems import Chain, Cone, Decay, Oscillator, Riccati, TwoRoots, cone_numbers
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from gelcone.motion.engine import program as programs
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.plan import ARRIVED, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS
from gelcone.motion.engine.program import Program, order_and_label

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "trajectories.json").read_text())
KEEPS = ("states", "tangents", "work")


def cone_of(case):
    given = {key: float(value) for key, value in case["parameters"].items()}
    return cone_numbers(
        damping_ratio=given["zeta"],
        spring_stiffness=given["k"],
        rest_height=given["rest"],
        meridional=given["meridional"],
        hoop=given["hoop"],
        stretch_limit=given["J"],
        voltage=given["v"],
        frequency=given["omega"],
    )


@pytest.mark.parametrize("keep", KEEPS)
def test_trajectories_agree_with_34_digits(keep):
    program = Program(Cone(), keep, 1e-15)
    for case in REFERENCE:
        initial = np.array([case["initial"]], dtype=float)
        exact = np.array(case["trajectory"])
        raw = program.run(cone_of(case), initial, 0.0, exact[None, :, 0])
        assert raw.status[0] == ARRIVED
        np.testing.assert_allclose(raw.states[0], exact[:, 1:], rtol=0.0, atol=5e-14)
        np.testing.assert_array_equal(raw.end_state[0], raw.states[0, -1])
        assert raw.end_time[0] == exact[-1, 0]


def test_tangents_agree_with_heyoka():
    cone, times = Cone(), np.array([0.7, 3.0, 11.0])
    numbers = cone_numbers(voltage=1.3, frequency=0.7, bias=0.2, rest_height=0.1)
    n = {name: hk.par[i] for i, name in enumerate(cone.numbers)}
    x, u, *deviations = variables = hk.make_vars("x", "u", "a", "b", "c", "d")
    rates, slopes = cone.flow(hk.time, (x, u), n, hk)
    rows = [[sum(slopes[i][k] * deviations[2 * k + j] for k in range(2)) for j in range(2)] for i in range(2)]
    system = list(zip(variables, [*rates, *rows[0], *rows[1]], strict=True))
    integrator = hk.taylor_adaptive(
        system, [0.6, -0.2, 1.0, 0.0, 0.0, 1.0], pars=[float(numbers[k]) for k in cone.numbers]
    )
    raw = Program(cone, "tangents", 1e-15).run(numbers, [[0.6, -0.2]], 0.0, times[None])
    for k, moment in enumerate(times):
        integrator.propagate_until(moment)
        np.testing.assert_allclose(raw.states[0, k], integrator.state[:2], rtol=0.0, atol=3e-14)
        np.testing.assert_allclose(raw.tangents[0, k].ravel(), integrator.state[2:], rtol=3e-14, atol=3e-14)
        integrator.state[2:] = [1.0, 0.0, 0.0, 1.0]


def test_tangents_of_three_states_are_the_derivative_of_the_map():
    program = Program(Chain(), "tangents", 1e-15)
    start, times = np.array([0.3, -0.1, 0.4]), np.array([[0.5, 2.0]])
    raw = program.run({"rate": 0.7}, start[None], 0.0, times)
    assert raw.tangents.shape == (1, 2, 3, 3)
    both = raw.tangents[0, 1] @ raw.tangents[0, 0]
    small = 1e-6
    moved = np.concatenate([start + small * np.eye(3), start - small * np.eye(3)])
    ends = Program(Chain(), "states", 1e-15).run({"rate": 0.7}, moved, 0.0, np.repeat(times, 6, axis=0)).states[:, 1]
    np.testing.assert_allclose(both, (ends[:3] - ends[3:]).T / (2.0 * small), rtol=0.0, atol=1e-9)


def test_two_roots_that_depend_on_each_other_are_found_together():
    """Against SciPy, which solves both equations in every call; tangents against differences of motions."""
    start, times = np.array([0.6, 0.3]), np.array([[0.5, 2.0, 5.0]])

    def solved(u, w):
        both = fsolve(
            lambda v: [v[0] + 0.5 * v[1] * v[0] ** 2 - u, v[1] + np.sin(v[1]) / 3.0 - v[0] - w * w], [u, u], xtol=1e-13
        )
        return both

    def right(t, s):
        y, z = solved(*s)
        return [y - s[0] * z + 0.4 * np.cos(t), z - s[1]]

    found = solve_ivp(right, (0.0, 5.0), start, method="DOP853", t_eval=times[0], rtol=1e-12, atol=1e-13)
    raw = Program(TwoRoots(), "tangents", 1e-15).run({"a": 0.4}, start[None], 0.0, times)
    np.testing.assert_allclose(raw.states[0], found.y.T, rtol=0.0, atol=1e-11)
    assert raw.steps[0] < 60
    whole = raw.tangents[0, 2] @ raw.tangents[0, 1] @ raw.tangents[0, 0]
    moved = np.concatenate([start + 1e-6 * np.eye(2), start - 1e-6 * np.eye(2)])
    ends = Program(TwoRoots(), "states", 1e-15).run({"a": 0.4}, moved, 0.0, np.repeat(times, 4, axis=0)).states[:, 2]
    np.testing.assert_allclose(whole, (ends[:2] - ends[2:]).T / 2e-6, rtol=0.0, atol=1e-8)


def test_work_balances_the_energy():
    numbers = cone_numbers(voltage=0.8, frequency=0.9, damping_ratio=0.05)
    times = np.linspace(2.0, 60.0, 30)[None]
    raw = Program(Cone(), "work", 1e-15).run(numbers, [[0.5, 0.1]], 0.0, times)

    def energy(x, u):
        s = numbers["s"]
        invariant = numbers["A"] * (1.0 + x * x) + numbers["B"] + numbers["G"] / (1.0 + x * x) - 3.0
        return 0.5 * u * u + 0.5 * numbers["kappa"] * x * x - np.log1p(-s * invariant) / (2.0 * s)

    gained = energy(*raw.states[0].T) - energy(0.5, 0.1)
    np.testing.assert_allclose(gained, raw.work[0, :, 0] - raw.work[0, :, 1], rtol=0.0, atol=1e-13)
    assert raw.work[0, -1, 1] > 0.05


def test_energy_is_conserved_without_damping_and_voltage():
    numbers = cone_numbers(voltage=0.0, damping_ratio=0.0, stretch_limit=5.0)
    times = np.linspace(100.0, 2000.0, 20)[None]
    x, u = Program(Cone(), "states", 1e-15).run(numbers, [[0.9, 0.3]], 0.0, times).states[0].T
    s = numbers["s"]
    invariant = 1.0 + x * x + 1.0 + 1.0 / (1.0 + x * x) - 3.0
    energy = 0.5 * u * u + 0.45 * x * x - np.log1p(-s * invariant) / (2.0 * s)
    assert np.ptp(energy) < 2e-13


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_errors_follow_the_tolerance(tolerance):
    numbers, times = cone_numbers(voltage=1.3, frequency=1.0), np.array([[30.0]])
    exact = Program(Cone(), "states", 1e-15).run(numbers, [[1.0, 0.0]], 0.0, times).states
    program = Program(Cone(), "states", tolerance)
    assert (program.order, program.label) == order_and_label(tolerance)
    error = np.abs(program.run(numbers, [[1.0, 0.0]], 0.0, times).states - exact).max()
    assert 1e-4 * tolerance < error < 10.0 * tolerance


def test_every_operation_against_extended_precision():
    """One right-hand side with all operations, in long double by heyoka."""
    system, long = Everything(), np.longdouble
    x, u = hk.make_vars("x", "u")
    formula = system.rates(hk.time, (x, u), {"a": hk.par[0], "b": hk.par[1], "p": 1.3}, hk_namespace())
    integrator = hk.taylor_adaptive(
        list(zip((x, u), formula, strict=True)), np.zeros(2, long), tol=long(1e-19), fp_type=long
    )
    a, b = np.linspace(0.5, 2.0, 12), np.linspace(0.3, 3.0, 12)
    raw = Program(system, "states", 1e-15).run(
        {"a": a, "b": b, "p": 1.3}, np.tile([1.0, 0.0], (12, 1)), 0.0, np.tile([5.0, 20.0], (12, 1))
    )
    for i in range(12):
        integrator.time = long(0)
        integrator.state[:] = [1, 0]
        integrator.pars[:] = [long(a[i]), long(b[i])]
        for k, moment in enumerate((5.0, 20.0)):
            integrator.propagate_until(long(moment))
            np.testing.assert_allclose(raw.states[i, k], integrator.state.astype(float), rtol=0.0, atol=2e-14)


def hk_namespace():
    class Namespace:
        sin, cos, exp, log, sqrt = hk.sin, hk.cos, hk.exp, hk.log, hk.sqrt

        @staticmethod
        def log1p(value):
            return hk.log(1.0 + value)

    return Namespace


@dataclass(frozen=True)
class Everything:
    states = ("x", "u")
    numbers = ("a", "b", "p")

    def rates(self, time, state, n, xp):
        x, u = state
        r = 1.0 + x * x
        force = -n["a"] * x - 0.1 * u + 0.05 * xp.exp(-0.3 * x) * xp.cos(n["b"] * time + 0.2 * x)
        force = force + 0.1 * xp.log(r) / (1.0 + u * u) + 0.02 * r**0.5 + 0.01 * r ** n["p"] - 0.01 * (x - 2.0) ** 3
        force = force + 0.01 / r**2 + 0.05 * xp.sin(x) + 0.03 * xp.log1p(0.1 * u * u) * r**-0.5 + 0.01 * r**1.5
        return [u, force + 0.01 * xp.sin(n["a"]) * xp.sqrt(1.0 + 0.1 * xp.sin(time)) - (-x) * 0.02]


# --- samples ---------------------------------------------------------------------------------------------------------


def test_dense_samples_are_as_good_as_steps_that_end_there():
    numbers = cone_numbers(voltage=1.2, frequency=0.5)
    times = np.sort(np.concatenate([np.linspace(0.0, 0.2, 3000), np.linspace(0.3, 50.0, 100)]))
    program = Program(Cone(), "states", 1e-15)
    many = program.run(numbers, [[0.7, 0.0]], 0.0, times[None])
    assert many.steps[0] < 400  # thousands of samples lie in one step
    np.testing.assert_array_equal(many.states[0, 0], [0.7, 0.0])
    chosen = [1, 500, 2999, 3000, 3050, 3099]
    single = np.concatenate([program.run(numbers, [[0.7, 0.0]], 0.0, [[times[k]]]).states[0] for k in chosen])
    np.testing.assert_allclose(many.states[0, chosen], single, rtol=0.0, atol=2e-14)


def test_a_sample_at_the_start_gives_the_start():
    raw = Program(Cone(), "tangents", 1e-10).run(cone_numbers(), [[0.7, 0.1]], 3.0, [[3.0, 4.0]])
    np.testing.assert_array_equal(raw.states[0, 0], [0.7, 0.1])
    np.testing.assert_array_equal(raw.tangents[0, 0], np.eye(2))


def test_rest_stays_at_rest_over_huge_gaps():
    for keep in KEEPS:
        raw = Program(Cone(), keep, 1e-15).run(cone_numbers(voltage=0.4), [[0.0, 0.0]], 0.0, [[0.0, 2e3, 4e3, 1e9][:3]])
        assert raw.status[0] == ARRIVED
        np.testing.assert_array_equal(raw.states, 0.0)
    raw = Program(Cone(), "states", 1e-15).run(cone_numbers(voltage=0.4), [[0.0, 0.0]], 0.0, [[1e9]])
    assert raw.steps[0] <= 2


def test_gaps_of_2000_time_units_keep_the_digits():
    numbers = cone_numbers(voltage=0.3, damping_ratio=0.2, frequency=1.0, rest_height=0.3)
    far, close = np.array([[2000.0, 4000.0]]), np.linspace(0.0, 4000.0, 4001)[None, 1:]
    program = Program(Cone(), "states", 1e-15)
    wide = program.run(numbers, [[0.5, 0.0]], 0.0, far).states[0]
    narrow = program.run(numbers, [[0.5, 0.0]], 0.0, close).states[0, [1999, 3999]]
    np.testing.assert_allclose(wide, narrow, rtol=0.0, atol=1e-13)


def test_without_stretch_limit_and_with_negative_states():
    numbers = cone_numbers(stretch_limit=np.inf, voltage=0.0, bias=0.3, damping_ratio=0.1)
    assert numbers["s"] == 0.0
    both = Program(Cone(), "states", 1e-15).run(numbers, [[0.8, 0.2], [-0.8, -0.2]], 0.0, [[5.0, 9.0]] * 2)
    np.testing.assert_array_equal(both.states[0], -both.states[1])
    assert (both.status == ARRIVED).all()


def test_each_member_has_its_own_start_times_and_numbers():
    frequency, start = np.array([0.5, 1.5, 1.0]), np.array([0.0, 10.0, -3.0])
    times = start[:, None] + np.array([[1.0, 2.0], [0.1, 30.0], [5.0, 6.0]])
    states0 = np.array([[0.1, 0.0], [0.2, 0.3], [0.4, -0.5]])
    program = Program(Cone(), "states", 1e-15)
    together = program.run(cone_numbers(frequency=frequency), states0, start, times)
    for i in range(3):
        alone = program.run(cone_numbers(frequency=frequency[i]), states0[[i]], start[i], times[[i]])
        np.testing.assert_array_equal(alone.states[0], together.states[i])


# --- how members end -------------------------------------------------------------------------------------------------


def test_a_member_that_fails_is_told_apart_and_disturbs_nobody():
    voltage = np.full(40, 1.2)
    voltage[[3, 17, 18]] = 4.0
    states0 = np.tile([1.0, 0.0], (40, 1))
    states0[25] = np.nan
    times = np.tile(np.linspace(5.0, 60.0, 12), (40, 1))
    small = np.full(40, 2e-8)
    program = Program(Cone(), "states", 1e-6)
    raw = program.run(cone_numbers(voltage=voltage, stretch_limit=5.0), states0, 0.0, times, smallest_step=small)
    bad = np.zeros(40, dtype=bool)
    bad[[3, 17, 18, 25]] = True
    assert (raw.status[~bad] == ARRIVED).all()
    assert raw.status[25] == NOT_FINITE
    assert raw.steps[25] == 1
    good = program.run(cone_numbers(voltage=1.2, stretch_limit=5.0), states0[:1], 0.0, times[:1])
    np.testing.assert_array_equal(raw.states[~bad], np.repeat(good.states, 36, axis=0))
    for i in np.flatnonzero(raw.status > 0):
        reached = times[i] <= raw.end_time[i]
        assert np.isfinite(raw.states[i, reached]).all()
        assert np.isnan(raw.states[i, ~reached]).all()


def test_a_step_below_the_bound_ends_a_member():
    raw = Program(Riccati(), "states", 1e-10).run({}, [[1.0], [1.0]], 0.0, [[0.5, 2.0]] * 2, smallest_step=[1e-6, 1e-3])
    np.testing.assert_array_equal(raw.status, STEP_TOO_SMALL)  # x' = x^2 is infinite at t = 1
    assert raw.end_time[1] < raw.end_time[0] < 1.0
    assert 1.0 - raw.end_time[0] < 1e-4
    np.testing.assert_allclose(raw.states[:, 0, 0], 2.0, rtol=1e-9)
    assert np.isnan(raw.states[:, 1]).all()
    np.testing.assert_allclose(raw.end_state[:, 0], 1.0 / (1.0 - raw.end_time), rtol=1e-4)
    assert (raw.smallest_step < [1e-6, 1e-3]).all()


def test_infinite_states_end_a_member_when_no_bound_is_set():
    raw = Program(Riccati(), "states", 1e-10).run({}, [[1.0]], 0.0, [[2.0]], most_steps=5000)
    assert raw.status[0] in (NOT_FINITE, TOO_MANY_STEPS)
    overflow = Program(Decay(), "states", 1e-10).run({"rate": -1.0}, [[1.0]], 0.0, [[700.0, 800.0]])
    assert overflow.status[0] == NOT_FINITE
    assert overflow.states[0, 0, 0] == pytest.approx(math.exp(700.0), rel=1e-7)
    assert 705.0 < overflow.end_time[0] < 711.0


def test_a_member_ends_after_its_steps():
    raw = Program(Cone(), "states", 1e-10).run(cone_numbers(), [[1.0, 0.0]] * 2, 0.0, [[5.0, 500.0]] * 2, most_steps=50)
    np.testing.assert_array_equal(raw.status, TOO_MANY_STEPS)
    np.testing.assert_array_equal(raw.steps, 50)
    assert np.isfinite(raw.states[:, 0]).all()
    assert np.isnan(raw.states[:, 1]).all()
    assert (raw.end_time > 5.0).all()


def test_options_that_cannot_be_used_are_refused():
    with pytest.raises(ValueError, match="keep = 'speed': must be one of states, tangents, work"):
        Program(Cone(), "speed", 1e-6)
    with pytest.raises(ValueError, match="between 0 and 1"):
        Program(Cone(), "states", 0.0)
    numbers = cone_numbers()
    del numbers["zeta"]
    with pytest.raises(ValueError, match="numbers: zeta missing"):
        Program(Cone(), "states", 1e-6).run(numbers, [[1.0, 0.0]], 0.0, [[1.0]])
    for times in ([2.0, 1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, np.inf], [np.nan, 1.0]):
        with pytest.raises(ValueError, match="times: must be finite, increase"):
            Program(Cone(), "states", 1e-6).run(cone_numbers(), [[1.0, 0.0]], 0.0, [times])
    with pytest.raises(ValueError, match="threads = 0"):
        Program(Cone(), "states", 1e-6).run(cone_numbers(), [[1.0, 0.0]], 0.0, [[1.0]], threads=0)


# --- corners, reruns -------------------------------------------------------------------------------------------------


def test_a_square_wave_flips_at_its_corners():
    """x'' + x = s, s = +-1 flipping each half period: pieces of circles."""
    system = Oscillator()
    corners = np.arange(0.5, 40.0, 0.5)
    times = np.array([[0.3, 1.7, 20.05, 39.9]])
    exact = []
    for moment in times[0]:
        x, u, s, at = 0.2, 0.0, 1.0, 0.0
        for corner in [*corners[corners < moment], moment]:
            c, d = math.cos(corner - at), math.sin(corner - at)
            x, u = s + (x - s) * c + u * d, u * c - (x - s) * d
            s, at = -s, corner
        exact.append([x, u])
    for tolerance, bound in ((1e-15, 2e-14), (1e-6, 1e-6)):
        for keep in ("states", "tangents"):
            raw = Program(system, keep, tolerance, pieces=("begin", "sign")).run(
                {"begin": 0.0, "sign": 1.0}, [[0.2, 0.0]], 0.0, times, corners=corners, terms=([[[1.0], [-1.0]]], 1)
            )
            np.testing.assert_allclose(raw.states[0], exact, rtol=0.0, atol=bound)


def test_rerun_gives_the_bits_of_run():
    program, starts, ends = Program(Cone()), np.array([0.0, 1.0, 2.5]), np.array([3.0, 4.0, 2.75])
    again = programs.Rerun(program, starts, ends, 1e5)
    for voltage in (0.5, 1.3):
        numbers = cone_numbers(voltage=voltage, frequency=0.7, bias=0.2, rest_height=0.1)
        states = np.array([[0.6, -0.2], [0.1, 0.3], [-1.0, voltage]])
        raw = program.run(numbers, states, starts, ends[:, None])
        values = np.array([float(numbers[name]) for name in again.numbers])
        found, arrived = again.run(values, states, 0.0)
        assert arrived.all()
        np.testing.assert_array_equal(found, raw.states[:, 0])
    found, arrived = again.run(values, states * 1e200, 0.0)
    assert not arrived.any()


def test_the_divergence_is_known_of_a_planar_system_and_integrated_of_another():
    flat = Program(Cone(), "tangents", 1e-10).run(cone_numbers(), [[0.6, 0.1]], 0.0, [[1.0, 3.0]])
    assert flat.divergence is None
    raw = Program(Chain(), "tangents", 1e-12).run({"rate": 0.7}, [[0.3, -0.1, 0.4]], 0.0, [[0.5, 2.0]])
    np.testing.assert_allclose(raw.divergence, [[-0.8 * 0.5, -0.8 * 1.5]], rtol=1e-10)  # the trace is -0.1 - 0.7
    np.testing.assert_allclose(np.log(np.linalg.det(raw.tangents)), raw.divergence, rtol=1e-9)


def test_orders_rise_with_fewer_digits_left_to_err_and_tangents_ask_for_less():
    assert [order_and_label(tolerance)[0] for tolerance in (1e-6, 1e-8, 1e-10, 1e-12)] == [8, 12, 12, 18]
    assert [order_and_label(tolerance, "tangents")[0] for tolerance in (1e-6, 1e-8, 1e-10, 1e-12)] == [8, 12, 12, 16]
    assert order_and_label(1e-6)[1] == pytest.approx(1e-7, rel=1e-15)
    assert (order_and_label(1e-15)[1], order_and_label(1e-15, "tangents")[1]) == (3e-16, 1e-15)


def test_a_rerun_knows_whether_a_member_met_an_event():
    program = Program(Decay(), "states", 1e-10, [Event(lambda t, s, n, xp: s[0] - 0.5, -1)])
    again = programs.Rerun(program, np.zeros(2), np.ones(2), 1e5)
    for rates, met in (([0.1, 0.2], False), ([0.1, 2.0], True), ([2.0, 2.0], True), ([0.3, 0.1], False)):
        _, arrived = again.run(np.array([rates]), np.ones((2, 1)), 0.0)
        assert again.met_event == met
        np.testing.assert_array_equal(arrived, np.array(rates) < 1.0)


def test_a_rerun_forgets_the_corners_of_the_run_before():
    """x'' + x = s with s as the last corner left it."""
    program = Program(Oscillator(), "states", 1e-12, pieces=("begin", "sign"))
    again = programs.Rerun(program, np.zeros(1), np.full(1, 3.0), 1e5, corners=3, pieces=2)
    terms, first, switches = np.array([[[1.0], [-1.0]]]), np.array([1]), np.array([[0.0, 1.0]])
    for corners in ([0.5, 1.0, 2.0], [1.5], [0.7, 0.9]):
        given = np.array([corners]), terms, first
        found, arrived = again.run(np.zeros(2), np.array([[0.2, 0.0]]), 0.0, switches, given)
        raw = program.run(
            {"begin": 0.0, "sign": 1.0}, [[0.2, 0.0]], 0.0, [[3.0]], corners=corners, terms=(terms, first)
        )
        assert arrived.all()
        np.testing.assert_array_equal(found, raw.states[:, 0])
