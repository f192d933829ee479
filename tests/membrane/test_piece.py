"""One piece of a film's force, fitted to films whose formulas are known."""

from dataclasses import replace

import numpy as np
import pytest

from gelcone import InputError
from gelcone.membrane import force
from gelcone.membrane import piece as module
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from tests.membrane.made_up import GELS, LAW, made_up, places


@pytest.mark.parametrize("piece", force.PIECES)
@pytest.mark.parametrize("kind", GELS)
def test_a_table_gives_back_the_formulas_of_a_made_up_film(kind, piece):
    film, n = made_up(kind)
    s, V = places(film, n, piece)
    rough = 3e-2 if piece == "far" else 1e-10  # W of the far piece is a cubic; the film's has a corner at the star
    own = force.pull(piece, s, V, n)
    np.testing.assert_allclose(own.q, film.q(s, V), atol=rough)
    for found, at in zip((own.rim, own.whole), film.kinks(s), strict=True):
        np.testing.assert_allclose(found, film.q(s, V) - at, atol=rough if piece == "far" else 1e-4)
    np.testing.assert_allclose(own.k, film.pull(s, V), rtol=5e-3, atol=2e-3 * (piece == "near"))
    ends, measured = force.ends(piece, own.u + 0.0 * V, own.q, n), film.measured(film.height(s), V)
    np.testing.assert_allclose(ends.disc, measured.disc + 0.0 * V, rtol=1e-5)
    np.testing.assert_allclose(ends.field, measured.field**2, rtol=2e-3)
    if piece == "far":
        np.testing.assert_allclose(force.pull_in(s, n), film.localisation(s), rtol=1e-12)


@pytest.mark.parametrize("kind", GELS)
def test_the_stated_error_of_a_made_up_film_covers_its_forces_and_not_much_more(kind):
    """One whose force swings over the height faster than the fit; over the force and a tenth of the floor."""
    film, n = made_up(kind, star=0.1, ripple=0.1)
    errors = []
    for piece in force.PIECES:
        s, V = places(film, n, piece)
        if piece == "far":  # up to the star: behind it the film is held at the lowest voltage
            V = np.linspace(0.0, 0.95, 17)[:, None] * force.pull_in(s, n)
        x = film.height(s)
        own, exact = x * force.pull(piece, s, V, n).k, x * film.pull(s, V)
        errors.append(np.abs(own - exact) / (exact + 0.1 * np.maximum(x * film.pull(s, 0.0), low(film))))
    largest = max(map(np.max, errors))
    assert largest < n["film_error"] < 6.0 * largest
    assert n["film_error"] > 10.0 * made_up(kind, star=0.1)[1]["film_error"]


def three_columns():
    """A made-up film with its table, and columns of its states below, at and above the height 0.1."""
    film, n = made_up("even")
    heights = np.array([0.05, 0.3, 0.5])
    top = 0.9 * film.slack(film.of_height(heights))
    return film, module.FittedFilm(film, n), film.columns(None, heights, top, top)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_error_of_a_fit_too_high_and_of_one_too_low_is_stated(factor):
    """Over the force of the state and a tenth of that without voltage at its height, or at 0.1 if that is greater."""
    film, fitted, found = three_columns()
    for at in (12, 26):  # one of the first column, which is low, and one of the second
        force_of = found.measures.force.copy()
        force_of[at] *= factor
        other = replace(found, measures=found.measures._replace(force=force_of))
        floor = 0.1 * max(other.first[found.column[at]], low(film))
        expected = abs(1.0 - factor) * found.measures.force[at] / (force_of[at] + floor)
        stated = [module._error(fitted, "near", other, np.array(own)) for own in ([at, 16], [16, at], [16])]
        assert stated[:2] == pytest.approx([expected] * 2, rel=0.03)
        assert stated[2] < 1e-2


@pytest.mark.parametrize(("share", "expected"), [(0.8, 0.25), (1.25, 0.2)])
def test_the_error_of_the_reduction_by_voltages_is_that_of_states_that_are_not_low(share, expected):
    _, fitted, found = three_columns()
    every, column = np.arange(found.V.size), found.column
    assert module._gain_error(fitted, "near", found, every) < 0.02
    for at, stated in ((5, 0.0), (20, expected), (40, expected)):
        taken, force_of = found.first[column] - found.measures.force, found.measures.force.copy()
        force_of[at] = found.first[column[at]] - share * taken[at]
        other = replace(found, measures=found.measures._replace(force=force_of))
        assert module._gain_error(fitted, "near", other, every) == pytest.approx(stated, abs=0.02)
    assert module._gain_error(fitted, "near", found, every[found.V == 0.0]) == 0.0


def low(film):
    """The force without voltage at the height 0.1."""
    return 0.1 * float(film.pull(film.of_height(0.1), 0.0))


def test_a_film_that_localises_nowhere_is_refused_in_words(monkeypatch):
    film = module.FittedFilm(
        Elements(Gel(LAW, LAW.numbers({"stretch_limit": 50.0}), 1.0, 1.0), 0.2),
        {"lowest_pull_in": 0.1, "slack_limit": 1.0},
    )
    film.numbers["flat_voltage"] = 0.0
    monkeypatch.setattr(module, "longest", lambda gel, V, grid=0: np.full(V.shape, np.nan))
    with pytest.raises(InputError, match="no voltage is found at which this film localises; take film = wrinkling"):
        module._tops(film, "far", np.array([0.8]))
