"""The formulas of a membrane's force: sums of powers and their derivatives."""

import numpy as np
import pytest

from gelcone.membrane import force


@pytest.mark.parametrize("piece", force.PIECES)
@pytest.mark.parametrize("what", ["main", "rim", "disc"])
@pytest.mark.parametrize("shape", [(), (3, 1)])
def test_sums_and_their_derivatives_are_those_of_the_powers(piece, what, shape):
    """For one film and arrays of places, and for several films; by j at once and one after the other."""
    rng = np.random.default_rng(3)
    named = force.names(piece, what)
    n = {name: rng.uniform(-1.0, 1.0, shape)[()] for name in named.ravel()}
    u, q = rng.uniform(-1.0, 1.0, (2, 3, 5))
    rows, expected = np.array([[n[name] for name in row] for row in named]), np.zeros((3, 3, 5))
    for i, j in np.ndindex(named.shape):
        if what == "main" and j > 0 and i > force.MAIN[piece][0]:
            continue  # what depends on u alone
        expected[0] += rows[i, j] * u**i * q**j
        expected[1] += i * rows[i, j] * u ** max(i - 1, 0) * q**j
        expected[2] += j * rows[i, j] * u**i * q ** max(j - 1, 0)
    found = force.tensor(piece, what, n, force.powers(u, len(named)), q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    if what == "disc":
        field = n | {name.replace("disc", "field"): value for name, value in n.items()}
        np.testing.assert_allclose(force.ends(piece, u, q, field), [expected[0]] * 2, rtol=1e-12, atol=1e-12)
