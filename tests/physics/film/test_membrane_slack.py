"""The membrane without tension: its even stretch, of arrays and in a program, and its charge."""

import numpy as np
import pytest

from gelcone.physics.film.membrane import KINDS
from gelcone.physics.film.membrane_slack import energy_and_area, natural_stretch, traced_area, traced_stretch
from tests.physics.film.membranes import MADE, film_of
from tests.physics.film.programs import in_program


def test_a_slack_film_has_no_force_and_the_charge_of_an_even_stretch():
    film, n = film_of(0.2, 1, 1)
    x, V = 0.3, 0.4
    assert film.force(x, V, [], n) == (0.0, 0.0)
    assert KINDS[film.state(x, V**0.5, [], n).kind] == "slack"
    t = film.capacitance(x, V, [], n) ** 0.5  # A = B = G = 1
    stress = (1.0 - t**-3.0) / (t * (1.0 - (2.0 * t + t**-2.0 - 3.0) / 50.0))
    assert stress == pytest.approx(V, rel=1e-9)


@pytest.mark.parametrize("made", MADE)
def test_the_stretch_solves_its_balance_of_arrays_and_in_a_program(made):
    film, n = film_of(*made)
    V = np.array([0.0, 0.1, 0.3]) / n["G"]
    t = natural_stretch(film.law, V, n)
    stress = film.law.response(2.0 * t + t**-2.0 - 3.0, n) * (1.0 - t**-3.0) / t
    np.testing.assert_allclose(stress, V * n["G"], rtol=1e-9, atol=1e-12)
    assert (np.diff(t) > 0.0).all()
    for share, expected in ((1.0, t), (0.0, np.ones(3))):

        def formula(V, n, xp, share=share):
            return traced_stretch(film.law, V, share, n, xp)

        (found,) = in_program(formula, n, {}, V)
        np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("made", MADE[:2])
def test_the_area_in_a_program_is_that_of_the_stretch_and_one_where_the_film_pulls(made):
    """Of films whose hoop is not the more stretched direction."""
    film, n = film_of(*made)
    V = np.array([0.0, 0.1, 0.3]) / n["G"]
    for pulls, expected in ((0.0, energy_and_area(film.law, V, n)[1]), (1.0, np.full(3, n["G"]))):

        def formula(V, n, xp, pulls=pulls):
            return traced_area(film.law, V, xp.constant(pulls), n, xp)

        (found,) = in_program(formula, n, {}, V)
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_slack_film_whose_hoop_is_the_more_stretched_direction_has_the_area_of_the_flat_one():
    film, n = film_of(*MADE[2])
    V = np.array([0.0, 0.05])
    (found,) = in_program(lambda V, n, xp: traced_area(film.law, V, xp.constant(0.0), n, xp), n, {}, V)
    np.testing.assert_allclose(found, film.capacitance(np.zeros(2), V, [], n), rtol=1e-12)
    assert found[1] != pytest.approx(energy_and_area(film.law, V, n)[1][1], rel=1e-3)
