"""The fit of a membrane that bears compression: its error and its free limit."""

from functools import cache
from types import SimpleNamespace

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
    inside = squared / film.highest_squared(np.sqrt(s), {}) < CEILING_MARGIN
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


@pytest.mark.parametrize("limit", [4.0, 10.0, 50.0])
def test_the_voltage_of_a_free_film_has_its_largest_value_before_the_stretch_limit(limit):
    """Gent's response 1/(1 - strain/J) times (1 - t^-3)/t first falls at the voltage that is found."""
    t = np.linspace(1.0, 0.5 * (limit + 3.0), 400_001)[1:-1]
    strain = 2.0 * t + t**-2.0 - 3.0
    squared = ((1.0 - t**-3.0) / t / (1.0 - strain / limit))[strain < limit]
    falls = np.flatnonzero(np.diff(squared) < 0.0)
    expected = squared[falls[0]] if falls.size else 1.0
    assert free_film_limit(ConeModel(stretch_limit=limit)) == pytest.approx(expected, rel=1e-5)


def test_a_film_that_the_stretch_limit_holds_ends_at_one_over_g():
    model = ConeModel(stretch_limit=0.2, prestretch=1.05, prestretch_mode="equibiaxial")
    assert free_film_limit(model) == pytest.approx(1.05**4, rel=1e-9)


# --- states on made-up paths ------------------------------------------------------------------------------------------


def made(height, force=1.0, most=-0.1, squared=0.0):
    return SimpleNamespace(height=height, force=force, squared=squared, forces=SimpleNamespace(most=most))


@pytest.fixture
def paths(monkeypatch):
    """Points stand for states; a load is reached as ``limit`` says, (load, from, to) -> point or None."""
    given = SimpleNamespace(limit=lambda load, before, value: None)
    monkeypatch.setattr(
        unwrinkled_fit, "reach", lambda film, point, load, value: (given.limit(load, point, value), point)
    )
    monkeypatch.setattr(unwrinkled_fit, "_state", lambda film, point, slack=False: (point, slack))
    monkeypatch.setattr(unwrinkled_fit, "flat", lambda film, squared: made(0.0))
    monkeypatch.setattr(unwrinkled_fit, "cone", lambda film, height, below=None: height)
    monkeypatch.setattr(unwrinkled_fit, "newton", lambda film, guess, squared: made(guess))
    return given


def test_a_compressed_film_is_raised_by_shorter_steps_where_a_long_one_leads_elsewhere(paths):
    """Up to 0.1 by long steps, up to 0.13 by short ones; beyond it is not compressed any more."""

    def limit(load, before, value):
        step = value - before.height
        most = 0.1 if value > 0.13 else -0.1
        return None if step > (0.05 if before.height < 0.09 else 0.015) else made(value, most=most)

    paths.limit = limit
    states = unwrinkled_fit._compressed(None, 0.3)
    assert [point.height for point, _ in states] == pytest.approx([0.02, 0.06, 0.1, 0.11, 0.12, 0.13])
    assert all(slack for _, slack in states)


@pytest.mark.parametrize("where", ["flat", "newton"])
def test_a_film_that_is_not_compressed_as_a_whole_has_no_such_states(paths, monkeypatch, where):
    for found in (None, made(0.02, most=0.1)):
        monkeypatch.setattr(unwrinkled_fit, where, lambda film, *_, found=found: found)
        assert unwrinkled_fit._compressed(None, 0.3) == []


@pytest.mark.parametrize(("fold", "kind"), [(0.31, "fold"), (9.0, "slack")])
def test_a_charged_film_ends_at_its_fold_or_where_a_free_film_does(paths, fold, kind):
    """Towards a fold the voltage weakens it ever faster; one that loses its tension ever less."""

    def force(squared):
        if kind == "fold":
            return 1.0 - 0.8 * (1.0 - np.sqrt(max(1.0 - squared / fold, 0.0)))
        return np.exp(-6.0 * squared)

    paths.limit = lambda load, before, value: made(0.5, force(value), squared=value) if value < fold else None
    states, end = unwrinkled_fit._charged(None, made(0.5, force(0.0)), 0.5)
    reached = [point.squared for point, _ in states]
    assert (np.diff(reached) > 0.0).all()
    assert end == pytest.approx(fold if kind == "fold" else 0.5, rel=0.02)
    assert any(slack for _, slack in states) == (kind == "slack")
    if kind == "slack":
        assert all(slack == (np.exp(-6.0 * point.squared) < 0.3) for point, slack in states[3:])


def test_a_film_ends_as_a_free_one_below_all_displacements_at_which_it_is_in_tension(paths, monkeypatch):
    """Raised it is in tension from 0.3 on, and up to 0.5 below its stretch limit: it ends there as free films do
    below, and as its columns do above."""
    heights = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    monkeypatch.setattr(unwrinkled_fit, "_heights", lambda film: heights)
    monkeypatch.setattr(
        unwrinkled_fit, "raised_film", lambda film, at: {h: SimpleNamespace(position=np.array([h])) for h in at[2:]}
    )
    shares = np.array([[0.5], [1.0]]) * LIMIT_SHARE / 0.55  # of two elements the more strained one decides
    monkeypatch.setattr(unwrinkled_fit, "limit_shares", lambda film, position: shares * position)
    monkeypatch.setattr(
        unwrinkled_fit, "_charged", lambda film, point, free: ([f"column {point.position[0]}"], 0.5 + point.position[0])
    )
    monkeypatch.setattr(unwrinkled_fit, "_compressed", lambda film, squared: ["compressed"] if squared > 0.0 else [])
    states, ends = unwrinkled_fit._states(None, 0.7)
    assert states[:3] == ["column 0.3", "column 0.4", "column 0.5"]
    assert set(states[3:]) == {"compressed"}
    np.testing.assert_allclose(
        ends, [(0.0, 0.7), (0.01, 0.7), (0.04, 0.7), (0.09, 0.8), (0.16, 0.9), (0.25, 1.0)], rtol=1e-12
    )
