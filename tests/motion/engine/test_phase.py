"""Derivatives with respect to numbers that a program carries along, against runs with other numbers."""

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers

from gelcone.motion.engine.phase import Sensitivities
from gelcone.motion.engine.program import Program
from gelcone.physics.differentiate import evaluated, jacobian
from gelcone.physics.trace import Graph


def test_the_traced_jacobian_is_the_one_that_the_system_gives():
    cone, graph = Cone(), Graph()
    state = [graph.state(0), graph.state(1)]
    n = {name: graph.number(name) for name in cone.numbers}
    rates, slopes = cone.flow(graph.time, state, n, graph)
    traced = jacobian([graph.node(rate) for rate in rates], state)
    numbers = cone_numbers(voltage=0.7, stretch_limit=10.0)
    at = {n[name].index: float(numbers[name]) for name in cone.numbers}
    at |= {state[0].index: 0.6, state[1].index: -0.3, graph.time.index: 4.0}
    for i in range(2):
        for j in range(2):
            assert evaluated([traced[i][j]], at) == pytest.approx(evaluated([graph.node(slopes[i][j])], at), rel=1e-13)


def test_sensitivities_agree_with_other_numbers():
    """Central differences of the end in amplitude and frequency."""
    by, small = ("amplitude", "frequency"), 1e-4
    times, start = np.array([[3.0, 8.0]]), np.array([[0.6, -0.1]])
    numbers = cone_numbers(voltage=0.8, frequency=0.9)
    system = Sensitivities(Cone(), by)
    assert system.states[2:4] == ("d displacement / d amplitude", "d velocity / d amplitude")
    assert len(system.states) == 2 + 2 * 2
    raw = Program(system, "states", 1e-10).run(numbers, np.hstack([start, np.zeros((1, 4))]), 0.0, times)
    plain = Program(Cone(), "states", 1e-15)

    def end(**change):
        moved = {name: numbers[name] + small * change.get(name, 0.0) for name in numbers}
        return plain.run(moved, start, 0.0, times).states[0]

    np.testing.assert_array_less(np.abs(raw.states[0, :, :2] - end()), 1e-9)
    for k, name in enumerate(by):
        difference = (end(**{name: 1.0}) - end(**{name: -1.0})) / (2.0 * small)
        np.testing.assert_allclose(raw.states[0, :, 2 + 2 * k : 4 + 2 * k], difference, rtol=0.0, atol=2e-5)
