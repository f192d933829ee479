"""Motions moved on step by step: numbers set in between, alone in the table of programs or not, count at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelcone
from gelcone.codes import Outcome
from gelcone.motion.engine.interruptions import border_events
from gelcone.motion.engine.program import Program
from gelcone.motion.engine.steps import Steps
from gelcone.physics.driven import driven
from gelcone.physics.members import Members

MODEL = gelcone.ConeModel(rest_height=0.4, damping_ratio=0.1)
COUNT = 3


@pytest.fixture
def made():
    """Three members, and what `Program.run` gives of one with some numbers over a length."""
    system = driven(MODEL.system)
    steps, program = Steps(system, 1e-10, COUNT, 1e6), Program(system, "states", 1e-10, border_events(system))
    own = {name: float(value) for name, value in MODEL.replace(voltage=0.0).members().numbers_at(0).items()}
    own = {name: own.get(name, 0.0) for name in program.numbers}
    steps.set_all(np.array([[own[name]] * COUNT for name in steps.numbers]), np.arange(COUNT))
    steps.lengths[:] = [1.0, 2.0, 3.0]
    steps.states[:] = [0.4, 0.0]

    def right(numbers, states, lengths):
        given = own | numbers
        return program.run(given, states, 0.0, lengths[:, None]).states[:, 0]

    return steps, right


@pytest.mark.parametrize(
    "name", ["input_voltage", "input_force", "damping_ratio", "spring_stiffness", "inverse_stretch_limit"]
)
def test_a_number_counts_from_the_step_after_it_was_set(made, name):
    steps, right = made
    steps.step()
    values = np.array([0.3, 0.5, 0.7])
    before = steps.states.copy()
    steps.set(name, values)
    assert (steps.step() == Outcome.OK).all()
    np.testing.assert_array_equal(steps.states, right({name: values}, before, steps.lengths))
    assert (steps.states != right({}, before, steps.lengths)).any(axis=1).all()


def test_voltage_and_force_change_evenly_over_a_step(made):
    """Against an integration of the model's own acceleration, with a constant voltage at each moment."""
    steps, _ = made
    names = ("input_voltage", "input_voltage_rate", "input_force", "input_force_rate")
    for name, value in zip(names, (0.2, 0.1, -0.05, 0.03), strict=True):
        steps.set(name, value)
    steps.step()

    def rates(time, state):
        held = MODEL.replace(voltage=0.0, voltage_bias=0.2 + 0.1 * time)
        acceleration = held.system.rates(0.0, list(state), held.own_numbers)[1]
        return [state[1], float(acceleration) - 0.05 + 0.03 * time]

    run = solve_ivp(rates, (0.0, 3.0), [0.4, 0.0], t_eval=[1.0, 2.0, 3.0], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(steps.states, run.y.T, atol=1e-6)


def test_a_step_of_two_lengths_is_that_of_both(made):
    steps, right = made
    start = steps.states.copy()
    for _ in range(4):
        steps.step()
    np.testing.assert_allclose(steps.states, right({}, start, 4.0 * steps.lengths), atol=1e-10)


def test_a_member_that_ends_stays_where_it_did(made):
    steps, _ = made
    steps.states[1] = [1e200, 0.0]
    outcome = steps.step()
    assert outcome.tolist() == [Outcome.OK, Outcome.NOT_FINITE, Outcome.OK]
    assert not steps.broke_down.any()
    assert np.isfinite(steps.states).all()
    steps.states[1], steps.smallest_step[1] = [np.inf, 0.0], 2e-8  # of a member that may come to a wall it is the wall
    assert steps.step().tolist() == [Outcome.OK, Outcome.STRETCH_LIMIT, Outcome.OK]


def test_a_film_that_creeps_pulls_in_where_its_voltage_is_set_beyond_the_end_of_its_minimum():
    """A film without force between its disc and the next minimum, some fifty times as large: it does not go there, and
    stays where it was when the voltage was set."""
    model = gelcone.ConeModel(
        film="wrinkling", branches=2, bias="spring+weight", flow_exponent=3, flow_stress=1.252, damping_ratio=0.03202,
        hoop_prestretch=0.9542, meridional_prestretch=1.0, spring_stiffness=5.1, rest_height=0.3723, weight=0.1264,
        stretch_limit=11.92, viscous_modulus_1=0.07655, relaxation_time_1=65.53, viscous_modulus_2=0.06113,
        relaxation_time_2=32.1, viscous_limit_2=61.69,
    )  # fmt: skip
    system = driven(model.system)
    steps = Steps(system, 1e-12, 1, 1e6)
    members = Members(system, model.members().values, 1)
    steps.set_all(np.array([members.own_numbers[name] for name in steps.numbers]).reshape(-1, 1), np.arange(1))
    steps.states[:] = members.start_states(np.array([[0.0922, 0.2779]]))
    sides = system.switches(np.zeros(1), list(steps.states.T), members.own_numbers)
    steps.switches[:] = np.stack([sides[name] + np.zeros(1) for name in steps.switch_names], axis=1)
    steps.lengths[:] = 0.894
    steps.set("input_voltage", -0.433)
    assert steps.step() == Outcome.OK
    before = steps.states.copy()
    steps.set("input_voltage", -0.886)
    assert steps.step() == Outcome.PULLED_IN
    assert not steps.broke_down.any()
    np.testing.assert_array_equal(steps.states, before)


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_film_whose_field_reaches_its_strength_breaks_down_and_one_that_pulls_in_does_not(film):
    """The first is weak; the third, under the highest voltage, pulls in if it wrinkles."""
    model = gelcone.ConeModel(
        film=film, rest_height=0.4, damping_ratio=0.1, voltage=0.0, dielectric_strength=[0.5, 50.0, 50.0]
    )
    system = driven(model.system, breaks_down=True)
    steps, own = Steps(system, 1e-10, 3, 1e6), Members(system, model.members().values, 3).own_numbers
    steps.set_all(np.array([np.broadcast_to(own[name], 3) for name in steps.numbers]), np.arange(3))
    steps.states[:], steps.lengths[:] = [0.4, 0.0], 1.0
    sides = system.switches(np.zeros(3), list(steps.states.T), own)
    for place, name in enumerate(steps.switch_names):
        steps.switches[:, place] = sides[name]
    before, switches = steps.states.copy(), steps.switches.copy()
    steps.set("input_voltage_rate", np.array([0.8, 0.3, 3.0]))
    third = Outcome.OK if film == "taut" else Outcome.PULLED_IN
    assert steps.step().tolist() == [Outcome.PULLED_IN, Outcome.OK, third]
    assert steps.broke_down.tolist() == [True, False, False]
    steps.states[:], steps.switches[:] = before, switches
    steps.set("input_voltage_rate", 0.3)
    assert steps.step().tolist() == [Outcome.OK] * 3
    assert not steps.broke_down.any()


def test_numbers_that_are_set_together_count_from_the_next_step_on_too(made):
    steps, right = made
    steps.step()
    before, values = steps.states.copy(), steps._values[:, :COUNT].copy()
    row = list(steps.numbers).index("damping_ratio")
    values[row] = [0.3, 0.5, 0.7]
    steps.set_all(values[:, 1:], np.array([1, 2]))
    steps.step()
    np.testing.assert_array_equal(
        steps.states, right({"damping_ratio": np.array([0.1, 0.5, 0.7])}, before, steps.lengths)
    )


def test_a_step_that_needs_more_steps_of_the_integrator_than_it_may_take_says_so():
    steps = Steps(driven(MODEL.system), 1e-10, 1, 2.0)
    own = MODEL.replace(voltage=0.0).members().numbers_at(0)
    steps.set_all(np.array([[float(own.get(name, 0.0))] for name in steps.numbers]), np.arange(1))
    steps.lengths[:], steps.states[:] = 50.0, [0.4, 0.3]
    assert steps.step().tolist() == [Outcome.STEP_LIMIT]
    assert not steps.broke_down.any()
