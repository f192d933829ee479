"""Derivatives with respect to numbers that a program carries along, against runs with other numbers."""

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers

from gelcone.motion.engine.phase import Sensitivities, phase_program
from gelcone.motion.engine.program import Program
from gelcone.motion.flow import integrate
from gelcone.physics.differentiate import evaluated, jacobian
from gelcone.physics.model import ConeModel
from gelcone.physics.trace import Graph
from tests.toys import PowerFilm


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


# --- over the phase ---------------------------------------------------------------------------------------------------

DRIVE = {"voltage": 0.7, "voltage_bias": 0.2, "drive_frequency": 0.8, "rest_height": 0.4, "damping_ratio": 0.1}


class Areal(PowerFilm):
    """A power film whose capacitance is its modulus times the area of a cone."""

    name = "areal"
    linear_charge = traced_charge = True

    def capacitance(self, x, squared, y, n, xp=np):
        return n["film_modulus"] * (1.0 + x * x)


MODELS = {
    "cone": ConeModel(film="taut", hoop_prestretch=1.2, **DRIVE),
    "resistance": ConeModel(film=Areal(), series_resistance=0.4, **DRIVE),
    "wrinkled": ConeModel(film="wrinkling", hoop_prestretch=1.1, series_resistance=0.4, **DRIVE),
    "triangle": ConeModel(film="taut", waveform="triangle", **DRIVE),
}
BEGIN, END = np.array([0.4, 2.0]), np.array([2.5, 9.5])
STATES = np.array([[0.5, 0.1, 0.45], [0.3, -0.2, 0.6]])


DIRECTIONS = {
    "cone": ({"voltage": 1.0}, {"drive_frequency": 1.0}, {"spring_stiffness": 0.5, "damping_ratio": -2.0}),
    "resistance": ({"voltage": 1.0}, {"drive_frequency": 1.0}, {"film_modulus": 0.3, "series_resistance": 1.0}),
    "wrinkled": ({"drive_frequency": 1.0}, {"hoop_prestretch": 1.0}),
    "triangle": ({"voltage": 1.0, "voltage_bias": -0.5}, {"rest_height": 1.0}),
}
MOVED = 1e-5


class Passed:
    """Runs of two members from `BEGIN` to `END`, with derivatives along directions of the parameters."""

    def __init__(self, model, directions):
        self.system, self.size = model.system, len(model.system.states)
        self.n, self.sides = self.numbers(model), []
        for direction in directions:
            ahead, behind = (
                self.numbers(
                    model.replace(**{name: getattr(model, name) + s * MOVED * by for name, by in direction.items()})
                )
                for s in (1.0, -1.0)
            )
            self.sides.append((ahead, behind))
        self.by = [
            {name: (ahead[name] - behind[name]) / (2.0 * MOVED) for name in self.n if ahead[name] != behind[name]}
            for ahead, behind in self.sides
        ]
        self.program = phase_program(self.system, tuple(tuple(own) for own in self.by), 1e-13)
        self.again = self.program.again(BEGIN, END)

    def numbers(self, model):
        return {name: float(value) for name, value in model.own_numbers.items()}

    def run(self, n, states):
        """Ends with what the program carries behind them, and the numbers that it takes."""
        size = self.size
        row = n | {f"{name} by {k}": value for k, own in enumerate(self.by) for name, value in own.items()}
        row = {name: row.get(name, 0.0) for name in self.program.numbers}
        start = np.zeros((2, size * (1 + size + len(self.by))))
        start[:, :size], start[:, size : size * (1 + size)] = states, np.eye(size).ravel()
        switches = self.program.switches_at(BEGIN, states, n) if self.program.switches else None
        corners = self.program.corners(BEGIN, END, n)
        ends, arrived = self.again.run(np.array([*row.values()]), start, 0.0, switches, corners)
        assert arrived.all()
        return ends.copy(), row

    def ends(self, n, states):
        """The states alone."""
        return self.run(n, states)[0][:, : self.size]

    def maps(self):
        """Ends, tangent maps and derivatives along the directions, of the states."""
        size, states = self.size, STATES[:, : self.size]
        ends, row = self.run(self.n, states)
        tangents = ends[:, size : size * (1 + size)].reshape(2, size, size).transpose(0, 2, 1)
        slopes = ends[:, size * (1 + size) :].reshape(2, len(self.by), size).transpose(0, 2, 1)
        if self.system.charged:
            both = (BEGIN, END), (states, ends[:, :size])
            tangents, slopes = self.program.of_states(*both, tangents, slopes, row)
        return ends[:, :size], tangents, slopes


@pytest.mark.parametrize("name", ["cone", "resistance", "triangle", pytest.param("wrinkled", marks=pytest.mark.slow)])
def test_over_the_phase_ends_are_those_of_the_time_and_tangents_and_slopes_their_differences(name):
    """Also where what is carried along are deviations of the film's charge, which parameters of the film change by
    themselves."""
    model, omega = MODELS[name], DRIVE["drive_frequency"]
    passed = Passed(model, DIRECTIONS[name])
    ends, tangents, slopes = passed.maps()
    size, states = passed.size, STATES[:, : passed.size]
    for k in range(2):
        run = integrate(model, states[k], [END[k] / omega], start=BEGIN[k] / omega, tolerance=1e-13)
        np.testing.assert_allclose(ends[k], run.states[0, 0], rtol=0.0, atol=1e-10)
    for j, step in enumerate(MOVED * np.eye(size)):
        differences = (passed.ends(passed.n, states + step) - passed.ends(passed.n, states - step)) / (2.0 * MOVED)
        np.testing.assert_allclose(tangents[:, :, j], differences, rtol=1e-6, atol=1e-7)
    for k, (ahead, behind) in enumerate(passed.sides):
        differences = (passed.ends(ahead, states) - passed.ends(behind, states)) / (2.0 * MOVED)
        np.testing.assert_allclose(slopes[:, :, k], differences, rtol=1e-6, atol=1e-7)
