"""The paper's integrator: of fourth order, with the exponent of its own steps, and without a guard at the limit."""

import numpy as np
import pytest

from gelcone.motion.flow import integrate
from gelcone.paper.fixed_step import fixed_step
from gelcone.physics.model import ConeModel

MODEL = ConeModel(voltage=0.7, drive_frequency=0.8, damping_ratio=[0.05, 0.2], rest_height=0.3)


def test_the_error_falls_with_the_fourth_power_of_the_step():
    exact = integrate(MODEL, np.tile([0.5, 0.1], (2, 1)), [4.0]).states[:, -1]
    runs = [fixed_step(MODEL, (0.5, 0.1), 4.0 / steps, steps) for steps in (40, 80, 160)]
    errors = [np.abs(run.states[:, -1] - exact).max() for run in runs]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.25)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.15)
    assert runs[0].states.shape == (2, 41, 2)
    np.testing.assert_array_equal(runs[0].states[:, 0], [[0.5, 0.1], [0.5, 0.1]])


def test_the_exponent_is_the_mean_growth_of_a_deviation_along_the_displacement():
    run = fixed_step(MODEL, (0.5, 0.1), 0.01, 500)
    flow = integrate(MODEL, np.tile([0.5, 0.1], (2, 1)), [5.0], keep="tangents")
    grown = np.log(np.linalg.norm(flow.tangents[:, -1, :, 0], axis=1)) / 5.0
    np.testing.assert_allclose(run.exponent, grown, rtol=1e-6)


def test_steps_beyond_the_limit_are_counted():
    free = ConeModel(stretch_limit=[50.0, 0.05], spring_stiffness=0.5, damping_ratio=0.0, voltage=0.0)
    run = fixed_step(free, (0.1, 1.0), 0.01, 200)
    strain = free.take([1] * 200).members().strain(run.states[1, 1:, 0])
    np.testing.assert_array_equal(run.beyond, [0.0, (~(strain < 0.05)).mean()])
    assert run.beyond[1] > 0.5
