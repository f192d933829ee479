"""Films that creep far more slowly than their drive repeats: the drift is followed, not waited for."""

import numpy as np

import gelcone.motion.attractor.search as searching
from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.drift import drifted
from gelcone.motion.attractor.search import default_transient, search
from gelcone.motion.flow import integrate
from gelcone.motion.regime import regime
from gelcone.physics.model import ConeModel

CREEPS = {"viscous_modulus_1": 0.5, "damping_ratio": 0.05, "spring_stiffness": 0.9}
SWINGS = {**CREEPS, "rest_height": 0.8, "voltage": 0.9, "drive_frequency": 0.5}
SOFTENS = {**CREEPS, "film": "wrinkling", "voltage": 0.02, "drive_frequency": 0.8, "relaxation_time_1": 1e3}


def time_integrated(monkeypatch):
    """A list to which every run of a search adds the time that it covers."""
    spent = []

    def watched(members, states, times, **options):
        spent.append(float(times[:, -1].sum()))
        return integrate(members, states, times, **options)

    monkeypatch.setattr(searching, "integrate", watched)
    return spent


def test_a_slow_branch_costs_little_more_than_none_and_changes_no_answer(monkeypatch):
    """The cycle that patience reaches, to its last digits; the film of the fast drive is the one of the specification:
    p1 = <q>^(-2/3) <1/q>^(1/3), p2 = (<q> <1/q>)^(1/3) for a neo-Hookean branch."""
    model = ConeModel(**SWINGS, relaxation_time_1=1e3, viscous_limit_1=np.inf).members()
    spent = time_integrated(monkeypatch)
    found = search(model, model.start_states((1.0, 0.0)))
    assert found.cycles.attracting.all()
    assert sum(spent) < 2.0 * 450.0
    monkeypatch.setattr(searching, "SLOW", np.inf)
    spent.clear()
    patient = search(model, model.start_states((1.0, 0.0)))
    assert sum(spent) >= 2.0 * default_transient(model)[0]
    np.testing.assert_allclose(found.cycles.point, patient.cycles.point, atol=1e-12)
    np.testing.assert_allclose(found.cycles.exponents, patient.cycles.exponents, atol=1e-12)
    times = model.forcing_period[:, None] * np.arange(1, 257) / 256
    q = 1.0 + integrate(model, found.cycles.point, times).states[0, :, 0] ** 2
    mean, inverse = q.mean(), (1.0 / q).mean()
    held = [mean ** (-2 / 3) * inverse ** (1 / 3), (mean * inverse) ** (1 / 3)]
    np.testing.assert_allclose(found.cycles.point[0, 2:], held, atol=1e-4)


def test_a_film_that_pulls_in_late_is_not_called_periodic():
    """A raised film is held up to about .595 and localises above after tens of relaxation times; a flat one pulls in
    late above the long-term threshold .6914."""
    model = ConeModel(
        **SOFTENS | {"spring_stiffness": [3.0, 3.0, 0.9, 0.9], "rest_height": [1.4, 1.4, 0.0, 0.0]},
        voltage_bias=[0.59, 0.60, 0.66, 0.74],
    ).members()
    found = search(model, model.start_states((1.0, 0.0)), tolerance=1e-9)
    assert found.cycles.attracting.tolist() == [True, False, True, False]
    assert found.outcome.tolist() == [Outcome.OK, Outcome.PULLED_IN] * 2
    flat = model.take([2, 3])
    starts = flat.start_states((0.0, 0.0))
    followed = drifted(flat, starts, np.ones(2, dtype=int))
    assert followed.ends.tolist() == [True, False]
    for course, start, point in zip(followed.course, starts, followed.point, strict=True):
        passed = course[np.isfinite(course[:, 0])]
        np.testing.assert_array_equal(passed[[0, -1]], [start, point])
        assert len(passed) > 5
        assert (np.diff(passed[:, 2]) < 0.0).all()  # its branch relaxes all the way


def test_a_drift_that_one_period_does_not_show_is_followed_to_its_end():
    """It moves by less than 1e-6 in a period, and by .02 until it ends."""
    model = ConeModel(**SWINGS, relaxation_time_1=1e6).members()
    found = search(model, model.start_states((1.0, 0.0)))
    quicker = ConeModel(**SWINGS, relaxation_time_1=1e4).members()
    usual = search(quicker, quicker.start_states((1.0, 0.0)))
    assert found.cycles.attracting.all()
    np.testing.assert_allclose(found.cycles.point, usual.cycles.point, atol=2e-3)


def test_the_drift_of_an_unstable_motion_is_not_followed():
    """A flat disc stays flat at any voltage, but above 2 any other leaves it."""
    model = ConeModel(**CREEPS, voltage=0.01, voltage_bias=[0.5, 2.5], relaxation_time_1=1e4).members()
    assert drifted(model, model.start_states((0.0, 0.0)), np.ones(2, dtype=int)).ends.tolist() == [True, False]


def test_a_film_that_begins_pulled_in_ends_there():
    """Beyond the end of its minimum the steps of the integrator would go nowhere."""
    model = ConeModel(**SOFTENS, voltage_bias=0.74).members()
    run = integrate(model, [[0.0, 0.0, 0.6, 0.6]], [1.0], tolerance=1e-10)
    assert (run.outcome.tolist(), run.steps.tolist(), run.end_times.tolist()) == ([Outcome.PULLED_IN], [0], [0.0])


def test_chaos_with_a_slow_branch_is_chaos():
    given = {"spring_stiffness": 0.9, "damping_ratio": 0.1, "drive_frequency": 1.5, "voltage": 2.5}
    found = regime(ConeModel(**given, viscous_modulus_1=0.05, relaxation_time_1=1e3), budget=4000.0, patience=4e4)
    assert int(found["regime"]) == Regime.CHAOTIC
    assert float(found["lyapunov"][0]) > 0.1


def test_a_member_drifts_alike_in_any_company():
    together = ConeModel(**SWINGS | {"voltage": [0.5, 0.9, 0.2]}, relaxation_time_1=[1e3, 3e3, 2e4]).members()
    starts, period = together.start_states((0.6, 0.0)), np.array([1, 1, 1])
    every, alone = drifted(together, starts, period), drifted(together.take([1]), starts[1:2], period[:1])
    np.testing.assert_array_equal([*alone.point[0], alone.time[0]], [*every.point[1], every.time[1]])
    np.testing.assert_array_equal(alone.course[0], every.course[1, : alone.course.shape[1]])


def test_a_drift_takes_the_time_that_its_motion_takes():
    """Integrated for that time the motion is where the drift ends; a tenth of it is not enough."""
    model = ConeModel(**SOFTENS, voltage_bias=0.66).members()
    start = model.start_states((0.0, 0.0))
    drift = drifted(model, start, np.ones(1, dtype=int))
    run = integrate(model, start, drift.time[:, None] * [0.1, 1.0])
    off = np.abs(run.states[0] - drift.point).max(axis=1)
    assert off[1] < 1e-4 < 1e-2 < off[0]
