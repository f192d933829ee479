"""Averages of growth: analytic values, statistics by hand, errors that are those of many averages."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gelcone.motion import exponents as module
from gelcone.motion.exponents import (
    average,
    block_statistics,
    bound_shear,
    grown_statistics,
    running_estimate,
    steady_statistics,
)
from gelcone.motion.settle import Clock, clocks, repeats_lasting, settle
from gelcone.physics.model import ConeModel
from tests.motion.test_lyapunov import CHAOS


@pytest.mark.parametrize(("damping", "stiffness"), [(0.05, 1.5), (0.7, 2.5), (2.0, 1.5), (3.0, 0.5), (0.0, 1.0)])
def test_rest_has_the_exponents_of_a_damped_linear_oscillator(damping, stiffness):
    """-zeta twice below critical damping, -zeta +- sqrt(zeta^2 - K) above."""
    model = ConeModel(voltage=0.0, damping_ratio=damping, spring_stiffness=stiffness)
    apart = np.sqrt(max(damping**2 - float(model.stiffness(0.0)), 0.0))
    expected = np.array([-damping + apart, -damping - apart])
    # A frame that turns with an oscillation averages over it as 1/t only.
    found = average(model.members(), np.zeros((1, 2)), budget=20_000.0 if apart == 0.0 else 3_000.0)
    np.testing.assert_allclose(found.values[0], expected, atol=1e-9 if apart else 2e-3)
    if apart == 0.0:
        assert found.values.sum() == pytest.approx(-2.0 * damping, abs=1e-10)


def test_the_standard_error_is_the_spread_of_many_averages():
    """48 runs on one chaotic attractor: their spread is what each of them says it is."""
    count = 48
    model = ConeModel(**CHAOS | {"damping_ratio": np.full(count, 0.05)})
    initial = np.stack([np.linspace(0.2, 1.5, count), np.zeros(count)], axis=1)
    states, _ = settle(model.members(), initial, repeats_lasting(model.members(), 200.0))
    found = average(model.members(), states, budget=1.0)
    assert (found.sign >= 0).all()
    spread, stated = found.values[:, 0].std(ddof=1), np.sqrt((found.standard_error[:, 0] ** 2).mean())
    assert spread / stated == pytest.approx(1.0, abs=0.35)


def test_the_running_estimate_ends_with_the_mean():
    growth = np.random.default_rng(4).normal(size=(2, 700, 2))
    clock = clocks(ConeModel(**CHAOS | {"damping_ratio": [0.1, 0.1]}).members())[0][1]
    running = running_estimate(growth, clock)
    np.testing.assert_allclose(running[:, -1, 1], growth[:, :, 0].mean(axis=1) / clock.spacing, rtol=1e-12)
    assert (np.diff(running[..., 0]) > 0.0).all()


def test_block_statistics_are_those_of_the_blocks():
    """Two blocks of two stretches of length 3: rates (a + b)/6, their mean, and the error of a mean of two."""
    clock = Clock(1, 2, np.array([3.0]), np.ones(1))
    growth = np.array([[[1.0, -1.0], [5.0, -3.0], [2.0, -2.0], [10.0, -6.0]]])
    means, errors = block_statistics(growth, clock)
    np.testing.assert_allclose(means, [[1.5, -1.0]])
    np.testing.assert_allclose(errors, [[0.5, 1.0 / 3.0]])  # half the difference of two rates


def test_half_of_what_the_halves_of_a_run_differ_by_is_an_error():
    """Where the first half, still settling, grows at another rate than the second, which alone counts."""
    clock = Clock(1, 1, np.ones(1), np.ones(1))
    growth = np.repeat([[1.0, 0.0, 1.0], [2.0, 0.0, 2.0]], 64, axis=0)[None]
    growth = growth + 1e-3 * np.random.default_rng(1).standard_normal(growth.shape)
    means, errors, steady, _ = steady_statistics(growth, clock)
    assert not steady[0]
    assert means[0, 0] == pytest.approx(2.0, abs=1e-3)
    assert errors[0, 0] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(("memory", "grown_share", "spread"), [(0.0, 1.0, 1.0), (0.7, 0.0, 1.07), (0.95, 0.0, 1.8)])
def test_stated_errors_cover_averages_of_noise_with_a_memory(memory, grown_share, spread):
    """400 averages of 640 stretches: deviations over stated errors scatter by about 1, also where longer blocks have to
    be taken because errors still grow; a memory longer than most blocks is too long."""
    noise = np.random.default_rng(4).standard_normal((400, 2640))
    rates = 0.3 + lfilter([1.0], [1.0, -memory], noise, axis=1)[:, 2000:]
    clock = Clock(1, 1, np.ones(400), np.ones(400))
    means, errors, grown = grown_statistics(rates[:, :, None], clock)
    off = (means[:, 0] - 0.3) / errors[:, 0]
    assert off.std() == pytest.approx(spread, rel=0.15)
    assert abs(off.mean()) < 0.3 * spread
    assert grown.mean() == pytest.approx(grown_share, abs=0.1)


# --- made-up growth ---------------------------------------------------------------------------------------------------


def averaging(monkeypatch, growth, outcomes=None, damping=0.1, **given):
    """The exponents of members that grow by ``growth`` (members,) and shrink by three times that each unit of time."""
    members = ConeModel(damping_ratio=np.broadcast_to(damping, len(growth))).members()
    clock, asked = Clock(1, 1, np.full(len(growth), 64.0), np.ones(len(growth))), []
    growth, noise = np.asarray(growth, dtype=float), np.random.default_rng(3)
    of = np.arange(len(growth))

    def advanced(members, run, clock, stretches, **flow):
        rows = run.states[:, 0].astype(int)
        asked.append((rows.tolist(), stretches, flow))
        more = (
            growth[rows][:, None]
            * 64.0
            * (1.0 + given.get("noise", 0.0) * noise.standard_normal((rows.size, stretches)))
        )
        if outcomes is not None and len(asked) > 1:
            run.outcome = np.asarray(outcomes, dtype=np.int8)[rows]
        run.states, run.error = (
            run.states + np.array([0.0, 0.25]),
            np.tile([0.0, given.get("error", 0.0)], (rows.size, 1)),
        )
        return np.stack([more, -3.0 * more], axis=2), -2.0 * more + 0.5

    monkeypatch.setattr(module, "clocks", lambda members, stretch: [(of, clock)])
    monkeypatch.setattr(module, "advance", advanced)
    states = np.column_stack([of.astype(float), np.zeros(of.size)])
    options = {name: given[name] for name in ("budget", "precision") if name in given}
    return module.average(members, states, tolerance=2e-9, threads=5, **options), asked


def test_an_average_takes_a_block_to_turn_and_then_a_hundred(monkeypatch):
    """Each member has its own numbers, the trace among them; the signs are certain at once."""
    found, asked = averaging(monkeypatch, [0.5, -0.25], noise=1e-3)
    assert [(rows, stretches) for rows, stretches, _ in asked] == [([0, 1], 1), ([0, 1], module.FEWEST_BLOCKS)]
    assert all(flow == {"tolerance": 2e-9, "threads": 5} for *_, flow in asked)
    np.testing.assert_allclose(found.values[:, 0], [0.5, -0.25], rtol=1e-3)
    np.testing.assert_allclose(found.values[:, 1], -3.0 * found.values[:, 0])
    np.testing.assert_allclose(found.divergence, -2.0 * found.values[:, 0] + 0.5 / 64.0)
    assert found.time.tolist() == [6400.0, 6400.0]
    assert found.sign.tolist() == [1, -1]
    np.testing.assert_array_equal(found.states, [[0.0, 0.5], [1.0, 0.5]])
    assert (found.standard_error[:, 0] < 1e-4).all()


def test_an_average_continues_while_twice_its_time_is_within_the_budget(monkeypatch):
    """Of members whose sign is not certain; one that fails ends, and has its outcome."""
    found, asked = averaging(monkeypatch, [0.0, 0.0, 0.5], outcomes=[0, 4, 0], budget=4 * 6400.0)
    assert [rows for rows, *_ in asked] == [[0, 1, 2], [0, 1, 2], [0], [0]]
    assert found.time.tolist() == [4 * 6400.0, 6400.0, 6400.0]
    assert found.outcome.tolist() == [0, 4, 0]
    assert found.sign.tolist() == [0, 0, 1]


@pytest.mark.parametrize("lacking", ["steady", "grown"])
def test_an_average_continues_until_its_errors_are_steady_and_grown(monkeypatch, lacking):
    """A sign that is certain does not suffice."""
    true, asked = module.steady_statistics, []

    def statistics(growth, clock):
        means, errors, *_ = true(growth, clock)
        asked.append(growth.shape[1])
        yes, late = np.array([True]), np.array([len(asked) > 1])
        return means, errors, *((late, yes) if lacking == "steady" else (yes, late))

    monkeypatch.setattr(module, "steady_statistics", statistics)
    found, _ = averaging(monkeypatch, [0.5], noise=1e-3)
    assert (found.time.tolist(), asked) == ([12800.0], [100, 200])


@pytest.mark.parametrize(("given", "time"), [({}, 12800.0), ({"precision": 1e-12}, 6553600.0)])
def test_the_budget_is_longer_where_a_precision_is_asked_for(monkeypatch, given, time):
    found, _ = averaging(monkeypatch, [0.0], noise=1.0, **given)
    assert found.time.tolist() == [time]


def test_a_sign_is_certain_three_errors_off_zero_and_above_what_shear_gives(monkeypatch):
    """Without damping a growth below that of shear over the time is none."""
    small = 0.5 * float(module.shear_level(np.array([6400.0]))[0])
    damped, _ = averaging(monkeypatch, [small], budget=1.0)
    free, _ = averaging(monkeypatch, [small], damping=0.0, budget=1.0)
    assert (damped.sign.tolist(), free.sign.tolist()) == ([1], [0])


def test_an_error_is_at_least_that_of_a_tangent_map_over_its_stretch(monkeypatch):
    """Errors of the maps may all have one sign, so that an average does not lower them."""
    found, _ = averaging(monkeypatch, [0.5, -0.25], noise=1e-6, error=0.064)
    assert (found.standard_error[:, 0] < 1e-6).all()
    np.testing.assert_allclose(found.standard_error[:, 1], 1e-3, rtol=1e-12)


def test_without_damping_the_exponents_of_the_disc_alone_are_zero():
    """Those of a circuit are not near 0."""
    members = ConeModel(damping_ratio=[0.0, 0.1]).members()
    result = module.Exponents.blank(2, states=3)
    result.values[:], result.standard_error[:], result.time[:] = [0.001, -0.0012, -50.0], 1e-4, 6400.0
    bound_shear(members, result)
    assert result.values.tolist() == [[0.0, 0.0, -50.0], [0.001, -0.0012, -50.0]]
    assert result.standard_error.tolist() == [[0.0012, 0.0012, 1e-4], [1e-4] * 3]
