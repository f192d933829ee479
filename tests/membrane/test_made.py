"""Tables by films: each once, for all that share it; and each part of a film in the key of its table."""

from dataclasses import dataclass

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.membrane import made
from gelcone.physics.laws import LAWS

GENT = {"stretch_limit": 50.0}


@dataclass(frozen=True)
class Own:
    """Stands for a law with data of its own."""

    power: float


@pytest.fixture
def tables(monkeypatch):
    """The rows of the tables that were asked for; a table holds its row over and over, and none is for A above 4."""
    asked = []

    def one(law, names, row):
        asked.append((type(law).__name__, names, row))
        return "too soft" if row[1] > 4.0 else tuple(np.resize(row, len(made.names())).tolist())

    monkeypatch.setattr(made, "_made", one)
    return asked


def test_films_that_differ_in_rounding_alone_share_a_table_and_each_gets_its_own(tables):
    A = np.array([[1.0, 2.0, 1.0 + 1e-15], [5.0, 2.0, 1.5]])
    found = made.numbers_of(LAWS["gent"], GENT, 0.2, A, 1.3)
    assert len(tables) == 4
    first, second = list(made.names())[:2]
    np.testing.assert_array_equal(np.isnan(found[first]), A == 5.0)
    np.testing.assert_allclose(found[second][A < 4.0], A[A < 4.0])
    assert found[first].shape == A.shape
    assert {row for _, _, row in tables} == {(0.2, a, 1.3, 50.0) for a in (1.0, 1.5, 2.0, 5.0)}


def test_one_film_has_plain_numbers_or_is_refused_in_words(tables):
    assert made.numbers_of(LAWS["gent"], GENT, 0.2, 1.0, 1.3)[made.names()[0]] == 0.2
    assert np.isnan(made.numbers_of(LAWS["gent"], GENT, 0.2, np.array([5.0]), 1.3)[made.names()[0]]).all()
    with pytest.raises(InputError, match="too soft"):
        made.numbers_of(LAWS["gent"], GENT, 0.2, 5.0, 1.3)
    with pytest.raises(InputError, match="radius_ratio = 1: must be below 1"):
        made.numbers_of(LAWS["gent"], GENT, [0.2, 1.0], 1.0, 1.3)
    assert made.refusal(LAWS["gent"], GENT, 0.2, 5.0, 1.3) == "too soft"
    assert made.refusal(LAWS["gent"], GENT, 0.2, 1.0, 1.3) == ""


def test_each_part_of_a_film_is_in_the_key_of_its_table(monkeypatch):
    keys = []

    def remembered(kind, parts, make, sources):
        keys.append(repr((kind, parts, sorted(map(str, sources)))))
        return np.zeros(len(made.names())).tobytes()

    monkeypatch.setattr(made.disk_cache, "made", remembered)
    law, names, row = LAWS["gent"], ("stretch_limit",), (0.21, 1.1, 1.3, 50.0)
    others = [(law, names, tuple(x * (1.0 + 1e-3 * (k == i)) for i, x in enumerate(row))) for k in range(4)]
    others += [(LAWS["yeoh"], names, row), (law, ("another",), row), (Own(1.0), names, row), (Own(2.0), names, row)]
    for one in [(law, names, row), *others]:
        assert made._made(*one) == (0.0,) * len(made.names())
    assert len(set(keys)) == len(keys) == 9


def test_digits_beyond_those_of_a_table_are_dropped():
    assert made.rounded([1.0, 1.0 + 1e-15, 0.1 + 0.2]).tolist() == [1.0, 1.0, 0.3]


def test_a_table_is_made_of_its_film_and_stored_in_the_order_of_its_names(monkeypatch):
    """A refusal is stored in words; without one the numbers come back by name."""
    asked = {}

    def table(gel, ratio):
        asked.update(gel=gel, ratio=ratio)
        if ratio > 0.5:
            raise InputError("too wide")
        return {name: float(k) for k, name in reversed(list(enumerate(made.names())))}

    monkeypatch.setattr(made, "table", table)
    monkeypatch.setattr(made.disk_cache, "made", lambda kind, parts, make, sources: make())
    law, names = LAWS["yeoh"], ("yeoh_c2", "yeoh_c3")
    assert made._made.__wrapped__(law, names, (0.2, 1.1, 1.3, 0.5, 0.6)) == tuple(map(float, range(len(made.names()))))
    assert (asked["gel"].A, asked["gel"].B, asked["ratio"], asked["gel"].law) == (1.1, 1.3, 0.2, law)
    assert asked["gel"].numbers == {"yeoh_c2": 0.5, "yeoh_c3": 0.6}
    assert made._made.__wrapped__(law, names, (0.6, 1.1, 1.3, 0.5, 0.6)) == "too wide"


def test_films_that_differ_by_more_than_rounding_have_tables_of_their_own():
    assert made.rounded(1.0 + 3e-12)[0] == 1.0 + 3e-12 != made.rounded(1.0)[0]
    assert made.rounded(1.0 + 3e-13)[0] == 1.0


def test_a_refusal_is_that_of_the_film_that_was_asked_for(tables):
    assert made.refusal(LAWS["yeoh"], {"yeoh_c2": 0.5, "yeoh_c3": 0.6}, 0.2, 5.0, 1.3) == "too soft"
    assert tables == [(type(LAWS["yeoh"]).__name__, ("yeoh_c2", "yeoh_c3"), (0.2, 5.0, 1.3, 0.5, 0.6))]
