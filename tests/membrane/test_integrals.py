"""Integrals over the height: those of a force whose integrals are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.membrane.integrals import integrals


@pytest.mark.parametrize("low", [0.0, 0.2])
def test_they_are_those_of_powers_of_the_height(low):
    """k = V^2 s^2, from the flat film and from a height on; nothing where the range is empty."""

    def pull(s, V, n):
        return SimpleNamespace(k=V * V * s * s, by_v=2.0 * V * s * s)

    high, V = np.array([0.9, 1.7, low, 0.5 * low]), np.array([0.3, 0.7, 0.5, 0.5])
    k, by_v = integrals(pull, np.full(4, low), high, V, {}, 1.0)
    exact = np.maximum(high**3 - low**3, 0.0) / 3.0
    np.testing.assert_allclose(k, V * V * exact, rtol=1e-10, atol=1e-15)
    np.testing.assert_allclose(by_v, 2.0 * V * exact, rtol=1e-10, atol=1e-15)
