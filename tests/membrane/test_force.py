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


@pytest.mark.parametrize(("before", "beyond"), [(-2.5, 1.5), (-1.3, 0.3), (-0.5, 0.0)])
def test_pull_in_falls_to_its_lowest_up_to_the_star_and_stays_there(before, beyond):
    """By a sum that is 0.4 wherever, times how far the place, -1/s, is below the star's, -1."""
    n = dict.fromkeys(force.END_NAMES, 0.0) | {force.END_NAMES[0]: 0.4, "lowest_pull_in": 0.7, "star_place": -1.0}
    n |= {"end_scale": 0.3, "end_begin": -9.0, "end_offset": 0.1, "far_shift": 0.0, "far_exponent": -1.0}
    assert force.place("far", -1.0 / before, n)[0] == pytest.approx(before)
    assert force.pull_in(-1.0 / before, n) == pytest.approx(0.7 + 0.4 * beyond, abs=force.ROUNDED)
