"""What films of a gel share: pre-stretches, the state of a ring, and the states of branches."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS
from tests.physics.film.programs import in_program

BRANCH = {"viscous_modulus_1": 0.6, "relaxation_time_1": 2.0, "viscous_limit_1": 4.0}


def test_pre_stretches_are_given_together_or_one_by_one():
    radial, equal = TautCone(), TautCone(prestretch_mode="equibiaxial")
    for film, given, squares in [
        (radial, {"prestretch": 1.2}, (1.0, 1.44)),
        (equal, {"prestretch": 1.2}, (1.44, 1.44)),
        (equal, {"meridional_prestretch": 1.3}, (1.69, 1.0)),
        (radial, {"hoop_prestretch": 0.8}, (1.0, 0.64)),
        (radial, {"meridional_prestretch": 1.3, "hoop_prestretch": 0.8, "prestretch": None}, (1.69, 0.64)),
        (radial, {}, (1.0, 1.0)),
    ]:
        n = film.numbers(film.complete(given))
        assert (n["A"], n["B"]) == pytest.approx(squares)
        assert n["G"] == pytest.approx(1.0 / (squares[0] * squares[1]))
        assert film.stiffness_scale(n) == n["A"]
    with pytest.raises(InputError, match="prestretch and meridional_prestretch/hoop_prestretch are both given"):
        radial.complete({"prestretch": 1.2, "hoop_prestretch": 1.1})


@pytest.mark.parametrize("law", list(LAWS))
def test_the_state_of_a_cone_is_that_of_its_stretches_in_arrays_and_in_programs(law):
    """sigma_i = (l_i^2 - l3^2) R - v^2 of the true field; a ring of other lengths, with further stresses, as well."""
    film = TautCone(law=LAWS[law])
    n = film.numbers(film.complete({"meridional_prestretch": 1.1, "hoop_prestretch": 1.3}))
    q, v = np.array([1.0, 1.4, 2.2]), np.array([0.3, -0.6, 0.0])
    state = film.ring_state(q, np.ones_like(q), v, n)
    l1, l2 = 1.1 * np.sqrt(q), 1.3
    l3 = 1.0 / (l1 * l2)
    strain = l1**2 + l2**2 + l3**2 - 3.0
    response, field = film.law.response(strain, n), v * v * q
    np.testing.assert_allclose(state.meridional_stretch, l1)
    np.testing.assert_allclose(state.hoop_stretch, l2 + 0.0 * q)
    np.testing.assert_allclose(state.thickness_stretch, l3)
    np.testing.assert_allclose(state.meridional_stress, (l1**2 - l3**2) * response - field)
    np.testing.assert_allclose(state.hoop_stress, (l2**2 - l3**2) * response - field)
    np.testing.assert_allclose(state.true_field, np.sqrt(field))
    np.testing.assert_allclose(state.limit_share, strain / film.law.strain_limit(n))
    np.testing.assert_allclose(film.cone_strain(np.sqrt(q - 1.0), n), strain)
    width = np.array([1.0, 1.1, 0.9])

    def ring(m, width, squared, n, xp):
        return film.traced_ring(m, width, squared, n, xp, (0.2, -0.1))

    along, across, squared, _ = in_program(ring, n, {}, q, width, v * v)
    l1, l2 = 1.1 * np.sqrt(q), 1.3 * np.sqrt(width)
    l3 = 1.0 / (l1 * l2)
    response = film.law.response(l1**2 + l2**2 + l3**2 - 3.0, n)
    np.testing.assert_allclose(squared, v * v * q * width)
    np.testing.assert_allclose(along, (l1**2 - l3**2) * response - squared + 0.2)
    np.testing.assert_allclose(across, (l2**2 - l3**2) * response - squared - 0.1)


@pytest.mark.parametrize("film", [TautCone, WrinklingCone])
def test_branches_rest_on_the_mounted_film_or_where_a_run_starts(film):
    x = 0.8
    flat, raised = film(branches=1), film(branches=1, rested="raised")
    n = flat.numbers(flat.complete(BRANCH | {"meridional_prestretch": 1.1, "hoop_prestretch": 0.8}))
    assert flat.starts(x, n) == [1.0, 1.0]
    m, width = raised.resting_lengths(x, 0.0, n)
    assert raised.starts(x, n) == pytest.approx([1.0 / m, 1.0 / width])
    assert (width > 1.0) == (film is WrinklingCone)
    assert film().starts(x, n) == []
    rested = raised.starts(x, n)
    assert raised.rates(x, 0.3, 0.0, rested, n) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert raised.dissipation(x, 0.3, 0.0, rested, n) == pytest.approx(0.0, abs=1e-20)
    assert float(raised.stiffness_scale(n)) == pytest.approx(1.21 + 0.6)
    assert (raised.dissipates, film().dissipates, raised.drags) == (True, False, False)
    assert float(raised.time_constant(n)) == pytest.approx(1.6 * 2.0)
    assert film().time_constant(n) == 0.0


def test_branches_are_overstretched_where_their_strain_is_their_limit():
    """E1 + E2 + 1/(E1 E2) - 3 = J with E1 = p1 q of a taut film."""
    film = TautCone(branches=1)
    n = film.numbers(film.complete(BRANCH))
    edge = 0.5 * (4.0 + 2.0 + np.sqrt((4.0 + 2.0) ** 2 - 4.0))  # E + 1/E = J + 2
    for p, share in ((1.0, 0.999), (1.0, 1.001), (0.7, 0.999), (0.7, 1.001)):
        x = np.sqrt(share * edge / p - 1.0)
        assert bool(film.overstretched(x, [p, 1.0], n)) == (share > 1.0)
    assert not film.overstretched(9.0, [], n)


def test_a_film_that_wrinkles_is_overstretched_by_its_gap_and_not_by_the_length_that_it_may_take():
    """Without voltage a film of pre-stretch 0.6 rests longer than its gap: its branch would be beyond its limit."""
    film = WrinklingCone(branches=1)
    n = film.numbers(film.complete({**BRANCH, "viscous_limit_1": 0.5, "prestretch": 0.6}))
    m, width = film.resting_lengths(0.3, 0.0, n)
    y = [1.0, 1.0]
    assert film.viscous.limit_share(m, width, y, n) > 1.0 > film.viscous.limit_share(1.09, 1.0, y, n)
    assert not film.overstretched(0.3, y, n)
    edge = 0.5 * (2.5 + np.sqrt(2.5**2 - 4.0))
    assert film.overstretched(np.sqrt(1.001 * edge - 1.0), y, n)


def test_a_reduced_branch_loses_what_its_drag_takes():
    film = TautCone(branches=1, reduced=(1,))
    n = film.numbers(film.complete({**BRANCH, "relaxation_time_1": 0.01}))
    x, u = 0.7, 1.3
    drag = 4.0 * 0.6 * 0.01 * (x / (1.0 + x * x)) ** 2
    assert float(film.drag(x, n)) == pytest.approx(drag)
    assert float(film.dissipation(x, u, 0.2, [], n)) == pytest.approx(drag * u * u)
    assert film.drags
    assert film.states == ()


def test_a_slow_branch_keeps_its_states_and_equal_choices_are_one_film():
    film = TautCone(branches=2, reduced=(1,))
    with pytest.raises(InputError, match=r"relaxation_time_1 = 0\.02 .*must be below 0\.02"):
        film.complete({"relaxation_time_1": 0.02})
    film.complete({"relaxation_time_1": 0.0199, "relaxation_time_2": 5.0})
    assert TautCone(branches=3, reduced=(3, 1, 3)) == TautCone(branches=3, reduced=(1, 3))
    with pytest.raises(InputError, match="'lifted' is not a rested; known: flat, raised"):
        TautCone(branches=1, rested="lifted")
    with pytest.raises(InputError, match="prestretch_mode"):
        TautCone(prestretch_mode="hoop")


def test_a_film_loses_what_its_branches_lose_at_their_lengths():
    """(t1^2 - t1 t2 + t2^2)/(3 g tau) of the stresses that its branch has, of which it feels those."""
    film = TautCone(branches=1)
    n = film.numbers(film.complete(BRANCH))
    x, y = 0.7, [0.8, 1.1]
    first, second = 0.8 * (1.0 + x * x), 1.1
    third = 1.0 / (first * second)
    response = 0.6 / (1.0 - (first + second + third - 3.0) / 4.0)
    along, across = response * (first - third), response * (second - third)
    lost = (along**2 - along * across + across**2) / (3.0 * 0.6 * 2.0)
    assert float(film.dissipation(x, 0.3, 0.2, y, n)) == pytest.approx(lost, rel=1e-12)
    plain = TautCone()
    assert plain.dissipation(x, 0.3, 0.2, [], plain.numbers(plain.complete({}))) == 0.0
