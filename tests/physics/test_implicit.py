"""Roots between two ends."""

import numpy as np
import pytest

from gelcone.physics.implicit import rise


def test_each_root_is_the_nearest_double_or_one_beside_it():
    wanted = np.random.default_rng(1).uniform(0.01, 3.0, 500)
    for power in (1.0, 3.0, 9.0):
        found = rise(lambda x, p=power: x**p - wanted**p, np.zeros(500), np.full(500, 4.0))
        assert np.abs(found / wanted - 1.0).max() < 1e-15


def test_a_function_may_be_infinite_or_flat_inside_the_bracket():
    wanted = np.array([0.25, 0.999, 0.5])

    def wall(x):
        return np.where(x >= 1.0, np.inf, x / (1.0 - x)) - wanted / (1.0 - wanted)

    assert rise(wall, np.zeros(3), np.full(3, 2.0)) == pytest.approx(wanted, rel=1e-14)
    steps = rise(lambda x: np.where(x < wanted, -1.0, 1.0), np.zeros(3), np.ones(3))
    assert steps == pytest.approx(wanted, rel=1e-14)


def test_without_a_root_it_is_the_end_nearest_to_one():
    low, high = np.zeros(2), np.ones(2)
    assert rise(lambda x: x + np.array([1.0, -3.0]), low, high).tolist() == [0.0, 1.0]


def test_company_changes_no_bit():
    wanted = np.linspace(0.1, 2.9, 40)
    together = rise(lambda x: x * x * x - wanted * wanted * wanted, np.zeros(40), np.full(40, 3.0))
    alone = [rise(lambda x, w=w: x * x * x - w * w * w, np.zeros(1), np.full(1, 3.0))[0] for w in wanted]
    assert (together == alone).all()
