"""Columns of states, the limits of films, and the numbers that are fitted to them."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gelcone import InputError, disk_cache
from gelcone.errors import DoubtfulInput
from gelcone.membrane import force, made
from gelcone.membrane.columns import columns, longest, lowest_localisation
from gelcone.membrane.elements import Elements
from gelcone.membrane.force import NEVER
from gelcone.membrane.gel import Gel
from gelcone.membrane.table import TRIALS, names, table
from gelcone.physics.film import membrane_charge
from gelcone.physics.laws import LAWS
from tests.membrane.made_up import GELS, LAW, MadeUp, made_up

PULL_IN = json.loads((Path(__file__).parents[1] / "reference" / "membrane.json").read_text())["pull_in"]


def gel_of(meridional, hoop, limit):
    return Gel(LAW, LAW.numbers({"stretch_limit": limit}), meridional**2, hoop**2)


def numbers(ratio, meridional, hoop, limit):
    """The table of a film, which the disk cache holds under all that it depends on, also for tests of other folders."""
    return made.numbers_of(LAW, LAW.numbers({"stretch_limit": limit}), ratio, meridional**2, hoop**2)


def test_the_lowest_localisation_is_the_certified_one():
    """V* of the specification of the membrane, of one ring alone."""
    assert lowest_localisation(gel_of(1, 1, 50), 0.5) == pytest.approx(0.09841, rel=2e-4)
    assert lowest_localisation(gel_of(1.5, 1.5, 50), 2.5) == pytest.approx(0.49821, rel=1e-4)
    assert lowest_localisation(gel_of(1, 1, 50), 0.09) == np.inf


def test_the_innermost_ring_is_as_long_as_certified_where_it_localises():
    rows = [r for r in PULL_IN if r["meridional_prestretch"] == 1 and r["hoop_prestretch"] == 1]
    for row in rows:
        found = longest(gel_of(1, 1, row["stretch_limit"] or np.inf), np.array([row["v"] ** 2]))
        assert found[0] == pytest.approx(row["disc_l1"], rel=1e-8)


@pytest.mark.parametrize("prestretch", [1, 1.5])
def test_columns_end_at_the_certified_pull_in(prestretch):
    rows = [
        r
        for r in PULL_IN
        if (r["radius_ratio"], r["meridional_prestretch"], r["hoop_prestretch"]) == (0.2, prestretch, prestretch)
        and r["x"] > 0.7 * (prestretch == 1)
    ]
    gel = gel_of(prestretch, prestretch, 50)
    heights, exact = np.array([r["x"] for r in rows]), np.array([r["v"] ** 2 for r in rows])
    found = columns(Elements(gel, 0.2), heights, exact, 2.0 * exact)
    assert found.end == pytest.approx(exact, rel=1e-3)
    assert not found.slack.any()


def test_columns_of_low_heights_end_where_the_film_is_slack():
    heights = np.array([0.2, 0.4, 0.6])
    gel = gel_of(1, 1, 50)
    slack = gel.crumpling(1.0 + heights**2)
    found = columns(Elements(gel, 0.2), heights, slack, 1.2 * slack)
    assert found.end == pytest.approx(slack, rel=2e-3)
    assert np.all(found.falls(found.measures.least_hoop) < found.falls(found.measures.largest_hoop))


FILMS = [
    (0.2, 1, 1, 50), (0.3, 1.3, 1.3, 80), (0.8, 1, 1, np.inf), (0.4, 0.9, 0.9, 30), (0.25, 1.3, 1.1, 60),
    (0.25, 0.85, 0.95, 50),
]  # fmt: skip
STRONG = [(0.2857, 1.1, 1.3, 50)]


@pytest.mark.parametrize("film", FILMS + STRONG, ids=str)
def test_the_stated_errors_cover_states_of_other_heights_on_finer_elements(film):
    """Of the force, and of what small and large voltages take from it, on which strokes depend."""
    ratio, meridional, hoop, limit = film
    n, gel = numbers(*film), gel_of(meridional, hoop, limit)
    cut, reach = max(n["cut_squared"], 0.0) ** 0.5, min(n["reach_squared"] ** 0.5, 2.0)
    begin = n["begin_squared"] ** 0.5
    heights = np.concatenate(
        [begin + (cut - begin) * np.array([0.23, 0.57, 0.81]), cut + (reach - cut) * np.array([0.13, 0.37, 0.71])]
    )
    heights = heights[heights > 0.05]
    near = heights < cut
    x2 = heights**2
    with np.errstate(invalid="ignore"):  # the curve of pull-in begins at the cut
        end = np.where(near, force.tension(x2, 0.0, n), force.pull_in(x2, n))
    found = columns(Elements(gel, ratio, 160), heights, end, end * 0.995, 7)
    x = heights[found.column]
    fitted = np.where(near[found.column], *(force.pull(piece, x * x, found.V, n).k for piece in force.PIECES)) * x
    error = np.abs(fitted - found.measures.force) / (found.measures.force + 0.1 * found.first[found.column])
    assert error.size > 20
    assert error.max() < n["film_error"]
    assert n["film_error"] < (0.13 if film in STRONG else 0.02)
    without = np.where(near[found.column], *(force.pull(piece, x * x, 0.0, n).k for piece in force.PIECES)) * x
    loaded = (found.V > 0.0) & (x > 0.1)
    taken = (found.first[found.column] - found.measures.force)[loaded]
    gain_error = np.abs((without - fitted)[loaded] / taken - 1.0).max()
    assert gain_error < n["gain_error"]
    assert n["gain_error"] < 0.25


def test_the_film_ends_at_the_same_height_in_both_pieces():
    n = numbers(0.2, 1, 1, 50)
    s = n["cut_squared"]
    V = np.linspace(0.0, 0.95, 20) * force.pull_in(s * 1.002, n)
    near, far = (force.pull(piece, s, V, n).k for piece in force.PIECES)
    assert far == pytest.approx(near, rel=4e-3, abs=1e-3 * near[0])


def test_a_table_is_made_once_and_depends_on_its_film(monkeypatch, tmp_path):
    calls = []

    def counted(gel, ratio):
        calls.append((gel.A, gel.numbers["inverse_stretch_limit"], ratio))
        return dict.fromkeys(names(), ratio)

    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(made, "table", counted)

    def of(ratio=0.3, A=1.0, limit=50.0):
        made._made.cache_clear()
        law = LAW.numbers({"stretch_limit": limit})
        return made.numbers_of(LAW, law, ratio, A, A)["film_error"]

    assert of() == 0.3
    assert of() == 0.3
    assert len(calls) == 1
    assert of(ratio=0.4) == 0.4
    of(A=1.2)
    of(limit=60.0)
    assert len(calls) == 4
    both = made.numbers_of(LAW, LAW.numbers({"stretch_limit": 50.0}), np.array([0.3, 0.4]), 1.0, 1.0)["film_error"]
    assert both.tolist() == [0.3, 0.4]
    made._made.cache_clear()


def test_one_film_without_a_table_leaves_the_others_theirs(monkeypatch, tmp_path):
    """Alone it is refused, in the words that the cache keeps; among others its numbers are NaN."""
    calls = []

    def refusing(gel, ratio):
        calls.append(ratio)
        if ratio > 0.5:
            raise InputError("too wide a disc")
        return dict.fromkeys(names(), ratio)

    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(made, "table", refusing)
    made._made.cache_clear()
    law = LAW.numbers({"stretch_limit": 50.0})
    several = made.numbers_of(LAW, law, np.array([0.3, 0.6, 0.4]), 1.0, 1.0)
    np.testing.assert_array_equal(several["film_error"], [0.3, np.nan, 0.4])
    np.testing.assert_array_equal(several["cut_squared"], [0.3, np.nan, 0.4])
    assert np.isnan(made.numbers_of(LAW, law, np.array([0.6, 0.6]), 1.0, 1.0)["film_error"])
    made._made.cache_clear()
    with pytest.raises(InputError, match="too wide a disc"):
        made.numbers_of(LAW, law, 0.6, 1.0, 1.0)
    assert made.refusal(LAW, law, 0.6, 1.0, 1.0) == "too wide a disc"
    assert made.refusal(LAW, law, 0.3, 1.0, 1.0) == ""
    assert len(calls) == 3
    made._made.cache_clear()


@pytest.mark.parametrize(
    "film",
    [
        (0.2, 1.2, 1.2, 50), (0.519, 1.257, 1.257, 25.2), (4 / 15, 1.1, 1.4, 50), (0.2, 1.0, 1.2, 50),
        (0.2, 1.2, 1.2, 20),
    ],
)  # fmt: skip
def test_usual_films_are_known_well_enough_to_be_made(film):
    """Where kinks of the force lie close together next to slackness, the fit does not swing between its states."""
    assert numbers(*film)["film_error"] < 0.13


def test_a_film_that_is_slack_at_every_height_is_refused_in_words():
    """Its forces are nothing but rounding."""
    said = "film = membrane: without voltage this film is slack at every height; take film = wrinkling, or larger pre"
    with pytest.raises(InputError, match=said):
        table(Gel(LAWS["neo-hookean"], {}, 1e-4, 1e-4), 4.0 / 15.0)


class _Keyed(Exception):
    """Ends the making of a table once its key is known."""


def key_of(monkeypatch, module, make):
    """The parts and the sources under which the disk cache would hold what ``make`` makes."""
    found = []

    def caught(kind, parts, make, sources):
        found[:] = repr(parts), disk_cache.digest_of(sources), sources
        raise _Keyed

    monkeypatch.setattr(module.disk_cache, "made", caught)
    with pytest.raises(_Keyed):
        make()
    return found


@dataclass(frozen=True)
class Stiffer(type(LAW)):
    """A law of which two differ by what they hold."""

    share: float = 1.0


def test_each_thing_on_which_a_table_depends_is_in_its_key(monkeypatch):
    def key(law, names=("a",), row=(0.2, 1.0, 1.0, 50.0)):
        return key_of(monkeypatch, made, lambda: made._made.__wrapped__(law, names, row))

    others = [key(Stiffer(2.0)), key(Stiffer(), ("b",)), key(Stiffer(), row=(0.2, 1.0, 1.0, 50.1))]
    first, _, sources = key(Stiffer())
    assert len({first, *(other[0] for other in others)}) == 4
    assert Path(made.__file__).parent in sources
    assert Stiffer in sources


def test_the_key_of_a_charge_holds_the_sources_of_both_its_formulas(monkeypatch):
    row = np.zeros(2).tobytes()
    sources = key_of(
        monkeypatch, membrane_charge, lambda: membrane_charge._made.__wrapped__(None, ("a", "b"), row, Stiffer())
    )[2]
    assert {Path(membrane_charge.__file__).parent, Path(force.__file__).parent, Stiffer} <= set(sources)


def test_films_share_a_table_where_they_differ_by_rounding_alone():
    assert made.rounded(1.0 + 1e-15) == made.rounded(1.0)
    assert made.rounded(1.0 + 1e-9) != made.rounded(1.0)


# --- made-up films: what their tables hold is known -------------------------------------------------------------------


@pytest.mark.parametrize("kind", GELS)
def test_a_table_holds_the_limits_of_a_made_up_film(kind):
    film, n = made_up(kind)
    assert tuple(sorted(n)) == names()
    assert n["begin_squared"] == pytest.approx(film.begin)
    assert n["cut_squared"] == pytest.approx(film.cut, abs=2e-9)
    assert n["reach_squared"] == 9.0
    assert n["star_place"] == pytest.approx(film.star, abs=1e-3)
    assert (n["lowest_pull_in"], n["slack_limit"]) == (film.lowest, film.limit)
    hump, flat = film.gel.hump(), film.gel.crumpling(film.gel.B) / film.gel.G
    assert hump > film.gel.B
    assert n["flat_voltage"] == pytest.approx(flat if kind == "strong hoop" else film.slack(0.0), rel=1e-12)
    area = [0.0, 0.1, -0.05, 0.02, 0.0, 0.0, 0.0] if kind != "even" else [0.0] * 7
    np.testing.assert_allclose([n[f"flat_area_{i}"] for i in range(7)], area, atol=1e-8)


def test_a_film_that_never_falls_slack_below_the_heights_at_which_it_localises_has_one_piece():
    """Where the hump lies before the pre-stretch, or where the cut is next to the height at which it begins to pull."""
    gel = Gel(LAW, LAW.numbers({"stretch_limit": 50.0}), 9.0, 9.0)
    assert gel.hump() < gel.A
    thick = MadeUp(gel, begin=0.0, share=0.0)
    for film in (thick, MadeUp(Gel(LAW, gel.numbers, 1.0, 1.0), begin=0.0, lowest=0.02, rise=0.05, share=1e-4)):
        with pytest.MonkeyPatch.context() as patch:
            n = film.table(patch)
        assert n["cut_squared"] == -1.0
        assert n["near_start"] == 1.0
        assert all(n[name] == 0.0 for name in force.names("near", "main").ravel())
        V = 0.5 * film.localisation(2.0)
        assert force.pull("far", 2.0, V, n).k == pytest.approx(film.pull(2.0, V), rel=1e-2)


def test_a_film_that_localises_nowhere_has_no_far_piece_up_to_where_it_falls_slack():
    film, n = made_up("even", lowest=np.inf, share=1.0, slackest=4.0)
    assert n["cut_squared"] == n["reach_squared"] == 9.0
    assert n["lowest_pull_in"] == NEVER
    assert (n["star_place"], n["end_begin"], n["end_scale"], n["end_offset"]) == (0.0, -1.0, 1.0, 0.0)
    assert all(n[name] == 0.0 for name in force.names("far", "main").ravel())
    s = np.linspace(0.1, 8.9, 23)
    np.testing.assert_allclose(force.pull("near", s, 0.3 * film.slack(s), n).k, film.pull(s, 0.3 * film.slack(s)), 1e-3)


def test_a_film_reaches_as_far_as_nine_tenths_of_its_stretch_limit_next_to_the_disc():
    for limit in (1.9, 2.2):
        film, n = made_up("even", stretch_limit=limit, slackest=1.2)
        trial = TRIALS[np.searchsorted(TRIALS, n["reach_squared"] ** 0.5 * (1 - 1e-12)) :][:2]
        inside, beyond = film.gel.strain(film.disc(trial**2), 1.0) < 0.9 * limit
        assert (bool(inside), bool(beyond)) == (True, False)
        assert n["reach_squared"] == pytest.approx(trial[0] ** 2, rel=1e-12)
    with pytest.raises(InputError, match="stretch_limit: is too close to the pre-stretch"):
        made_up("even", stretch_limit=0.2)


def test_many_films_to_be_made_are_announced_once_with_what_they_cost(monkeypatch, recwarn):
    """Those that are stored, or were asked for before, cost nothing."""
    made_up = dict.fromkeys(made.names(), 1.0)
    monkeypatch.setattr(made, "_made", lambda *film: tuple(made_up.values()))
    monkeypatch.setattr(made, "_asked", set())
    monkeypatch.setattr(made.disk_cache, "holds", lambda kind, parts, sources: parts[3][0] < 0.1)
    law = LAW.numbers({"stretch_limit": 50.0})
    for ratios in (np.linspace(0.2, 0.3, 16), np.linspace(0.01, 0.09, 40)):
        made.numbers_of(LAW, law, ratios, 1.0, 1.0)
    assert not recwarn.list
    several = np.linspace(0.05, 0.85, 75)
    with pytest.warns(DoubtfulInput, match=r"^70 membranes that differ are made first, .* 4 to 9 min in all"):
        made.numbers_of(LAW, law, several, 1.0, 1.0)
    recwarn.clear()
    made.numbers_of(LAW, law, several, 1.0, 1.0)
    assert not recwarn.list
