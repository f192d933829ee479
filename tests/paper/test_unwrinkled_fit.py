"""The fit of a membrane that bears compression: its error and its free limit."""

from functools import cache

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum.membrane import membrane
from gelcone.paper import unwrinkled_fit
from gelcone.paper.unwrinkled_fit import (
    CEILING_MARGIN,
    FLAT,
    KINDS,
    LIMIT_SHARE,
    TAUT,
    free_film_limit,
)
from gelcone.physics.model import ConeModel


@cache
def fitted_with_states():
    """The film of the cone model's defaults with a/b = 0.2, fitted once for all tests, and the states it was fitted to:
    rows of s, V, stiffness, kind."""
    kept = []
    fitted, own = unwrinkled_fit._fitted, unwrinkled_fit.ELEMENTS

    def keeping(film, free, states, ends):
        kept.extend((state.s, state.squared, state.stiffness, state.kind) for state in states)
        return fitted(film, free, states, ends)

    unwrinkled_fit._fitted = keeping
    unwrinkled_fit.ELEMENTS = 16  # as good, sooner
    try:
        film = unwrinkled_fit.fit_unwrinkled(ConeModel(), 0.2)
    finally:
        unwrinkled_fit._fitted = fitted
        unwrinkled_fit.ELEMENTS = own
    return film, np.array(kept)


# --- the error --------------------------------------------------------------------------------------------------------


def misses():
    """What the fit misses at every state, relative as the weights are, and the kinds of the states."""
    film, states = fitted_with_states()
    s, squared, stiffness, kind = states.T
    inside = squared / film.highest_squared_at(s) < CEILING_MARGIN
    s, squared, stiffness, kind = (values[inside] for values in (s, squared, stiffness, kind))
    off = film.stiffness(s, squared)[0] - squared - stiffness
    return np.abs(off) / (np.abs(stiffness) + 0.3 * squared + 0.02), kind


@pytest.mark.slow
def test_the_error_of_a_fit_is_the_largest_of_each_kind_of_state():
    film, _ = fitted_with_states()
    miss, kind = misses()
    own = {name: miss[kind == k].max() for k, name in enumerate(KINDS) if (kind == k).any()}
    assert dict(film.errors) == pytest.approx(own, rel=1e-6)
    # the mean would be smaller by far
    assert miss[kind == TAUT].mean() < 0.5 * own["taut"]


@pytest.mark.slow
def test_the_fit_is_best_where_the_film_does_not_wrinkle():
    miss, kind = misses()
    assert miss[kind == TAUT].max() < 0.02
    assert miss[kind == FLAT].max(initial=0.0) < 0.05


@pytest.mark.slow
def test_the_fit_agrees_with_the_membrane_between_its_states():
    film, _ = fitted_with_states()
    x, levels = np.array([0.33, 1.21, 2.9]), np.array([0.0, 0.3])
    found = membrane(ConeModel(), 0.2, displacements=x, voltages=levels, elements=60)["force"].values
    own = x * (film.stiffness(x**2, levels[:, None] ** 2)[0] - levels[:, None] ** 2)
    taut = np.isfinite(found)
    np.testing.assert_allclose(own[taut], found[taut], rtol=0.05)
    assert taut[0].all()


def test_states_reach_up_to_the_stretch_limit_and_the_pull_in():
    film, states = fitted_with_states()
    s, squared = states[:, 0], states[:, 1]
    assert film.largest == pytest.approx(np.sqrt(s.max()))
    assert film.wall > s.max()
    at_reach = membrane(ConeModel(), 0.2, displacements=film.largest, elements=40)
    assert LIMIT_SHARE - 0.2 < float(at_reach["limit_share"].squeeze()) <= LIMIT_SHARE + 0.01
    assert squared.max() <= free_film_limit(ConeModel()) * (1.0 + 1e-9)


def test_a_flat_film_of_even_tension_has_the_stiffness_of_theory():
    """2 (1 - r) N/((1 + r) ln(1/r)) with N = (A - G) response - V; none without pre-stretch and voltage."""
    film, _ = fitted_with_states()
    share = 2.0 * 0.8 / (1.2 * np.log(5.0))
    for squared in (0.0, 0.1):
        assert film.stiffness(0.0, squared)[0] - squared == pytest.approx(-share * squared, abs=1e-10)


# --- the free film ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stretch", [1.0, 1.2])
def test_a_prestretched_free_film_runs_away_at_a_higher_voltage(stretch):
    """The voltage refers to the mounted thickness: V G = (1 - t^-3)/t with G = stretch^-4, largest at t^3 = 4."""
    model = ConeModel(law="neo-hookean", prestretch=stretch, prestretch_mode="equibiaxial")
    assert free_film_limit(model) == pytest.approx(0.75 / 4.0 ** (1 / 3) * stretch**4, rel=1e-5)


def test_a_film_that_the_stretch_limit_holds_ends_at_one_over_g():
    model = ConeModel(stretch_limit=0.2, prestretch=1.05, prestretch_mode="equibiaxial")
    assert free_film_limit(model) == pytest.approx(1.05**4, rel=1e-9)
