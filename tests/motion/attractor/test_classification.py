"""Names of motions and the evidence behind them, made up and real; every member alone, whatever its neighbours."""

from dataclasses import fields

import numpy as np
import pytest

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor import classification
from gelcone.motion.attractor.classification import Evidence, classify
from gelcone.motion.attractor.lifetime import STARTS, Nearby
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel
from tests.toys import TurningBias

SET = {"spring_stiffness": 0.5, "damping_ratio": 0.05, "drive_frequency": 0.3}


def test_drifts_are_told_from_chaos():
    k = np.arange(200)
    leaving = np.stack([1e-4 * (-1.02) ** k, 1e-4 * 1.02**k], axis=1)
    wandering = np.random.default_rng(5).normal(size=(20, 200, 2))
    settling = np.stack([0.98**k, 0.99**k], axis=1)
    found = classification.drifts(np.concatenate([leaving[None], settling[None], wandering]))
    assert found.tolist() == [True] + [False] * 21


def test_judging_flags_what_disagrees():
    model = ConeModel(damping_ratio=np.full(6, 0.1))
    evidence = Evidence.blank(6)
    evidence.regime[:] = [Regime.TRANSIENT] * 3 + [Regime.PERIODIC] * 2 + [Regime.TRANSIENT]
    evidence.sign[:] = [1, 1, 1, -1, 0, -1]
    evidence.zero_one[:3] = [0.95, 0.4, 0.95]
    classification.judge(model.members(), evidence)
    assert [Regime(code).label for code in evidence.regime] == ["chaotic"] * 3 + ["periodic"] * 2 + ["transient"]
    assert evidence.doubtful.tolist() == [False, True, False, False, True, True]


def test_the_test_is_taken_at_the_phase_at_which_the_motion_varies_the_most():
    """The eight samples of a period lie at 1/8, 2/8, ... 1; the last is phase 0."""
    for widest, expected in ((3, 3), (8, 0), (1, 1)):
        at = np.arange(1, 9) / 8.0
        size = 1.0 + np.exp(-50.0 * (at - widest / 8.0) ** 2)
        path = np.array([1.0, -1.0, 0.5])[None, :, None] * size
        assert classification._widest(path).tolist() == [expected]


@pytest.mark.parametrize("phase", [0, 1, 3, 6])
def test_the_0_1_test_takes_the_displacement_once_a_period_at_its_phase(monkeypatch, phase):
    """And the state that is left is the one after all of its periods."""
    taken = []
    monkeypatch.setattr(classification, "zero_one", lambda values: taken.append(values) or np.array([0.5]))
    members, evidence = ConeModel(**SET, voltage=1.0).members(), Evidence.blank(1)
    evidence.final[:], evidence.test_phase[:] = [0.3, 0.1], phase
    classification._test(members, np.array([0]), evidence, 100, {})
    shares = np.arange(100) + (phase / 8.0 or 1.0)
    run = integrate(members, [0.3, 0.1], members.forcing_period[:, None] * np.unique([*shares, 100.0]))
    np.testing.assert_allclose(taken[0], run.states[:, :100, 0], atol=1e-9)
    np.testing.assert_allclose(evidence.final, run.states[:, -1], atol=1e-9)


def test_a_member_that_ran_out_of_steps_or_digits_has_not_left_the_domain():
    model = ConeModel(damping_ratio=np.full(4, 0.1))
    evidence = Evidence.blank(4)
    evidence.outcome[:] = [Outcome.STEP_LIMIT, Outcome.STRETCH_LIMIT, Outcome.PULLED_IN, Outcome.OUTSIDE]
    classification.judge(model.members(), evidence)
    assert evidence.regime.tolist() == [Regime.TRANSIENT] * 2 + [Regime.LEFT_THE_DOMAIN] * 2
    assert evidence.doubtful.tolist() == [True, True, False, False]


@pytest.mark.parametrize(
    ("plane", "zero_one", "under_way", "name", "doubtful"),
    [
        (True, 0.05, False, "transient", True),
        (False, 0.05, False, "quasi-periodic", False),
        (False, 0.5, False, "transient", True),
        (False, 0.05, True, "transient", True),
    ],
)
def test_with_more_than_two_states_a_damped_motion_may_be_quasi_periodic(
    monkeypatch, plane, zero_one, under_way, name, doubtful
):
    """Its largest exponent is zero within its error and its 0-1 test regular; in the plane areas shrink, so never;
    nor while it still leaves an unstable cycle behind."""
    members = ConeModel(damping_ratio=np.array([0.1])).members()
    monkeypatch.setitem(vars(members.system), "planar", plane)
    evidence = Evidence.blank(1, states=2 if plane else 3)
    evidence.zero_one[:], evidence.sign[:], evidence.under_way[:] = zero_one, 0, under_way
    classification.judge(members, evidence)
    assert Regime(int(evidence.regime[0])).label == name
    assert evidence.doubtful.tolist() == [doubtful]


@pytest.mark.parametrize(
    ("changes", "name", "lifetime"),
    [
        ({}, "transient chaos", 1200.0),
        ({"regime": Regime.REST}, "transient chaos", 1200.0),
        ({"duration": 2000.0}, "periodic", 1200.0),  # no longer than a transient
        ({"apart": np.inf}, "periodic", np.nan),  # no chaos
        ({"ended": 0}, "periodic", np.inf),  # which none of the starts comes to
        ({"early": 10.0}, "periodic", None),  # the others would have ended: chaos and the cycle coexist
        ({"sign": 0}, "periodic", 1200.0),  # it may not attract
        ({"regime": Regime.QUASI_PERIODIC}, "quasi-periodic", 1200.0),
        ({"regime": Regime.CHAOTIC}, "chaotic", 1200.0),
        ({"regime": Regime.CHAOTIC, "apart": np.inf}, "chaotic", 1400.0),
        ({"outcome": Outcome.PULLED_IN}, "periodic", np.nan),
    ],
)
def test_chaos_that_ends_after_longer_than_a_transient_is_transient(changes, name, lifetime):
    """Half of the starts ended after 400, the others were followed for 800, both since they had separated at 100; each
    takes at most 1e-3 to settle. The name is that of the attractor unless there was chaos that ends."""
    case = {"regime": Regime.PERIODIC, "duration": 500.0, "apart": 100.0, "ended": STARTS // 2, "early": 500.0,
            "sign": -1, "outcome": Outcome.OK} | changes  # fmt: skip
    nearby, evidence = Nearby.at(np.zeros((2, 2)), STARTS), Evidence.blank(2)
    nearby.ended[1, : case["ended"]], nearby.period[1, : case["ended"]] = case["early"], 1
    nearby.followed[1], nearby.apart[1] = 900.0, case["apart"]
    nearby.lowest[1], nearby.highest[1] = -1.0, 1.0
    evidence.regime[:], evidence.sign[:], evidence.exponents[:] = case["regime"], case["sign"], -1e6
    evidence.outcome[:] = case["outcome"]
    members = ConeModel(damping_ratio=[0.1, 1e6]).members()
    classification._store_lifetimes(members, np.array([1]), np.array([0.0, case["duration"]]), nearby, evidence)
    assert Regime(int(evidence.regime[1])).label == name
    assert evidence.regime[0] == case["regime"]
    assert np.isnan(evidence.lifetime[0])
    if lifetime is not None:
        assert evidence.lifetime[1] == pytest.approx(lifetime, rel=1e-3, nan_ok=True)
        assert np.isnan(lifetime) or evidence.share_chaotic[1] == 1.0 - case["ended"] / STARTS
    assert evidence.coexisting[1] == ("early" in changes)
    assert evidence.doubtful[1] == ("duration" in changes)  # the interval of the lifetime holds 2000


@pytest.mark.parametrize("share", [0.99, 1.01])
@pytest.mark.parametrize("end", ["lifetime_low", "lifetime", "lifetime_high"])
def test_a_lifetime_whose_interval_holds_the_transient_leaves_the_name_doubtful(share, end):
    """A start 1e-12 away has another lifetime: the name is doubtful on both sides of the transient's duration."""
    members = ConeModel(damping_ratio=[1e6]).members()

    def judged(duration):
        nearby, evidence = Nearby.at(np.zeros((1, 2)), STARTS), Evidence.blank(1)
        nearby.ended[0, : STARTS // 2], nearby.period[0, : STARTS // 2] = 500.0, 1
        nearby.followed[0], nearby.apart[0], nearby.lowest[0], nearby.highest[0] = 900.0, 100.0, -1.0, 1.0
        evidence.regime[:], evidence.sign[:], evidence.exponents[:] = Regime.PERIODIC, -1, -1e6
        classification._store_lifetimes(members, np.array([0]), np.array([duration]), nearby, evidence)
        return evidence

    known = float(getattr(judged(500.0), end)[0])
    inside = {"lifetime_low": share > 1.0, "lifetime": True, "lifetime_high": share < 1.0}[end]
    found = judged(share * known)
    assert bool(found.doubtful[0]) == inside
    assert (found.regime[0] == Regime.TRANSIENT_CHAOS) == (share * known < float(found.lifetime[0]))


def test_chaos_without_damping_never_ends():
    members, evidence = ConeModel(damping_ratio=[0.0, 0.0]).members(), Evidence.blank(2)
    evidence.regime[:], evidence.settled_time[:], evidence.averaged_time[:] = [Regime.CHAOTIC, Regime.REST], 300.0, 50.0
    nearby = Nearby.at(np.zeros((2, 2)), STARTS)
    classification._store_lifetimes(members, np.array([], dtype=int), np.zeros(2), nearby, evidence)
    np.testing.assert_array_equal(evidence.chaotic_until, [350.0, np.nan])
    np.testing.assert_array_equal(evidence.lifetime, [np.inf, np.nan])
    assert (evidence.share_chaotic[0], evidence.lifetime_low[0], evidence.lifetime_high[0]) == (1.0, 0.0, np.inf)


def mixed():
    """Ten members of all kinds, their drives repeating differently."""
    model = ConeModel(
        spring_stiffness=[0.5, 0.5, 0.5, 0.5, 0.9, 0.9, 1.5, 0.5, 0.9, 0.5],
        damping_ratio=[0.05, 0.05, 0.05, 0.05, 0.1, 0.1, 0.0, 0.05, 0.1, 0.3],
        drive_frequency=[0.3, 0.3, 0.3, 0.3, 1.5, 1.0, 0.77, 0.3, 3.0, 0.05],
        voltage=[0.3, 0.8, 1.0, 2.0, 2.5, 2.5, 0.1, 0.5, 1.5, 1.2],
        voltage_bias=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.0],
        stretch_limit=[50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 0.4, 20.0, 50.0],
    )
    return model, np.tile([1.0, 0.0], (10, 1))


def test_members_one_by_one_and_any_number_of_threads_give_the_same_to_the_last_bit():
    model, states = mixed()
    together, threaded = (classify(model.members(), states, patience=4000.0, threads=n) for n in (1, 2))
    assert len(set(together.regime.tolist())) >= 5
    for field in fields(Evidence):
        np.testing.assert_array_equal(getattr(together, field.name), getattr(threaded, field.name), field.name)
    for i in range(model.size):
        alone = classify(model.members().take([i]), states[[i]], patience=4000.0)
        for field in fields(Evidence):
            expected = getattr(together, field.name)[i]
            np.testing.assert_array_equal(getattr(alone, field.name)[0], expected, f"{field.name} of {i}")


def test_a_slow_drift_is_no_cycle():
    """A drive so fast that the decay over one of its repeats is below the tolerance of returns, far from rest."""
    model = ConeModel(voltage=0.0, damping_ratio=0.01, spring_stiffness=1.5, drive_frequency=np.pi / 0.01)
    evidence = classify(model.members(), np.array([[2e-3, 0.0]]), transient=1.0)
    assert Regime(evidence.regime[0]) in (Regime.REST, Regime.TRANSIENT)
    assert evidence.period[0] == 0


def test_a_model_with_more_starts_than_one_may_start_outside_with_some():
    states = np.array([[0.1, 0.0], [30.0, 0.0]])
    evidence = classify(ConeModel(**SET | {"damping_ratio": [0.05, 0.05]}, voltage=0.3).members(), states)
    assert [Regime(code).name for code in evidence.regime] == ["REST", "LEFT_THE_DOMAIN"]


class TwoWays(TurningBias):
    """The wheel pushes the disc, and the disc the wheel."""

    name = "turning two ways"

    def force(self, x, y, n, xp=np):
        force, slope = super().force(x, y, n, xp)
        return (force + 0.1 * y[0] if y else force), slope

    def rates(self, x, velocity, y, n, xp=np):
        along, across = super().rates(x, velocity, y, n, xp)
        return [along + 0.05 * (x - 0.35), across]


def test_a_motion_on_a_torus_is_quasi_periodic_and_its_evidence_that_of_the_path():
    """Section, extent, exponents and 0-1 test are found again from the states of the section."""
    model = ConeModel(bias=TwoWays(), damping_ratio=0.1, voltage=0.3, drive_frequency=0.8, wheel_growth=0.05)
    members = model.members()
    found = classify(members, np.array([[0.4, 0.0, 0.1, 0.0]]), transient=200.0, patience=400.0, budget=3000.0)
    assert Regime(int(found.regime[0])) is Regime.QUASI_PERIODIC
    assert (found.sign[0], found.period[0], found.doubtful[0]) == (0, 0, False)
    assert 0.0 <= found.zero_one[0] < 0.1
    assert found.exponents[0].sum() == pytest.approx(-0.2 - 4.0 * 0.05 + 2.0 * 0.05, abs=0.01)
    section = found.section[0]
    period = members.forcing_period[0]
    run = integrate(members.take(np.zeros(len(section) - 1, int)), section[:-1], period * np.arange(1, 65) / 64)
    np.testing.assert_allclose(run.states[:, -1], section[1:], atol=1e-9)
    x = run.states[..., 0]
    assert found.lowest[0] == pytest.approx(x.min(), abs=3e-3)
    assert found.highest[0] == pytest.approx(x.max(), abs=3e-3)
    spread = np.ptp(x, axis=0)
    assert spread[8 * int(found.test_phase[0] or 8) - 1] == pytest.approx(spread.max(), rel=0.1)
