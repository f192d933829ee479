"""Deviations of voltages as those of charges, against Q = v (1 + x^2) by hand."""

import numpy as np
import pytest

from gelcone.motion.engine.charges import voltage_turns
from gelcone.physics.model import ConeModel

X, V, W = np.array([[0.3, -0.7], [0.1, 1.2]]), np.array([[0.5, 0.2], [-0.4, 0.6]]), np.array([[0.1, 0.7], [0.3, 0.2]])


def states_of(model, *voltages):
    states = np.zeros((*X.shape, len(model.system.states)))
    states[..., 0], states[..., 1] = X, 0.4
    for place, value in zip(model.system.charged, voltages, strict=True):
        states[..., place] = value
    return states


@pytest.mark.parametrize("drive", [None, "same", "opposite"])
def test_a_deviation_of_the_charge_is_that_of_voltage_and_area(drive):
    second = {} if drive is None else {"second_film": "taut", "second_drive": drive, "second_flat_height": 0.8}
    model = ConeModel(film="taut", series_resistance=0.3, filter_time=0.2, **second)
    area, by_x = 1.0 + X**2, 2.0 * X
    if drive == "same":
        area, by_x = area + 1.0 + (0.8 - X) ** 2, by_x - 2.0 * (0.8 - X)
    places = list(model.system.charged)
    states = states_of(model, *[V, W][: len(places)])
    turns, scale = voltage_turns(model.system, np.zeros(X.shape), states, model.own_numbers)
    expected = np.broadcast_to(np.eye(states.shape[-1]), turns.shape).copy()
    expected[..., places[0], places[0]], expected[..., places[0], 0] = area, V * by_x
    if drive == "opposite":
        other = 1.0 + (0.8 - X) ** 2
        expected[..., places[1], places[1]], expected[..., places[1], 0] = other, -2.0 * W * (0.8 - X)
    np.testing.assert_allclose(turns, expected, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(scale, np.log(np.linalg.det(expected)), rtol=1e-12)


def test_without_a_voltage_among_the_states_nothing_turns():
    model = ConeModel(film="taut", filter_time=0.2)
    turns, scale = voltage_turns(model.system, np.zeros(X.shape), states_of(model), model.own_numbers)
    np.testing.assert_array_equal(turns, np.broadcast_to(np.eye(3), turns.shape))
    np.testing.assert_array_equal(scale, np.zeros(X.shape))


def test_a_state_that_is_lost_loses_its_own_map_alone():
    model = ConeModel(film="taut", series_resistance=0.3)
    states = states_of(model, V)
    states[0, 1, 0] = np.nan
    turns, _ = voltage_turns(model.system, np.zeros(X.shape), states, model.own_numbers)
    assert np.isnan(np.diagonal(turns[0, 1])).all()
    assert np.isfinite(turns[0, 0]).all()
    assert np.isfinite(turns[1]).all()
