"""The wrinkling film without branches: its force is the slope of the relaxed energy, and a table of forces."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from gelcone.membrane.gel import Gel
from gelcone.physics.differentiate import evaluated, gradients
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS
from gelcone.physics.trace import Graph
from tests.physics.film.programs import in_program

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "wrinkling.json").read_text())


def numbers(film, **given):
    return film.numbers(film.complete(given))


@pytest.mark.parametrize("row", REFERENCE["static"], ids=lambda row: f"x{row['x']}-v{row['v']}-J{row['J']}")
def test_forces_of_the_reference(row):
    film = WrinklingCone()
    n = numbers(film, stretch_limit=float(row["J"]), meridional_prestretch=row["lm"], hoop_prestretch=row["lh"])
    force, slope = film.force(row["x"], row["v"] ** 2, [], n)
    if row["pulled_in"]:
        assert np.isnan(force)
        return
    assert abs(force - float(row["film_force"])) < 1e-12
    stiffness = float(row["h_r"]) + 2.0 * row["x"] ** 2 * row["dh_dq"]
    assert abs(slope - stiffness) < 1e-11


PARAMETERS = {"gent": {"stretch_limit": 50.0}, "neo-hookean": {}, "yeoh": {"yeoh_c2": 0.02, "yeoh_c3": 0.001}}


def relaxed(film, q, squared, n):
    """Minimum of phi(m, n) over m >= q, n >= 1 and where it lies, by Newton's method from the thick film, of arrays."""

    def phi(z, xp):
        m, width = z
        strain = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
        if film.law.name == "gent":
            s = n["inverse_stretch_limit"]
            return [xp.log1p(-s * strain) * (-0.5 / s) - 0.5 * squared * (m * width)]
        return [film.law.energy(strain, n, xp) - 0.5 * squared * (m * width)]

    def slopes(z):
        return np.array(gradients(phi, list(z))[0])

    z, least, step = np.array([q, np.ones_like(q)]), np.array([q, np.ones_like(q)]), 1e-6
    for _ in range(100):
        slope = slopes(z)
        bends = np.array([(slopes(z + step * e) - slopes(z - step * e)) / (2.0 * step) for e in np.eye(2)[:, :, None]])
        free = (z > least) | (slope < 0.0)
        bends = np.where(free[:, None] & free[None, :], bends, np.eye(2)[:, :, None])
        down = np.linalg.solve(np.moveaxis(bends, 2, 0), np.where(free, slope, 0.0).T[..., None])[..., 0].T
        z = np.maximum(z - np.clip(down, -0.05, 0.05), least)
    return phi(z, np)[0], z


@pytest.mark.parametrize("law", list(LAWS))
def test_the_force_is_the_slope_of_the_relaxed_energy_in_every_state(law):
    """150 random films for each law; the minimum is found from the energy alone."""
    film, random = WrinklingCone(law=LAWS[law]), np.random.default_rng(3)
    lm, lh, x = (random.uniform(low, high, 150) for low, high in ((0.8, 1.4), (0.8, 1.6), (0.1, 1.6)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, **PARAMETERS[law])
    squared = random.uniform(0.0, 0.99, 150) * np.minimum(film.highest_squared(x, n), 3.0)
    q, step = 1.0 + x * x, 1e-4
    (low, _), (high, _), (energy, (m, width)) = (relaxed(film, q + d, squared, n) for d in (-step, step, 0.0))
    np.testing.assert_allclose(film.force(x, squared, [], n)[0], x * (high - low) / step, atol=1e-6)
    np.testing.assert_allclose(film.work(x, squared, [], n), energy + 0.5 * squared, atol=1e-12)
    np.testing.assert_allclose(film.lengths(x, squared, n), (m, width), atol=1e-9)
    kinds = 2 * (m > q + 1e-9) + (width > 1.0 + 1e-9)
    assert np.bincount(kinds, minlength=4).min() > 3


@pytest.mark.parametrize(("law", "limit"), [*((law, 50.0) for law in LAWS), ("gent", 8.0), ("gent", 3.0)])
def test_a_program_and_arrays_give_the_same_charge_in_every_state(law, limit):
    """Of 3,000 random films, flat ones and ones with low stretch limits among them; lengths are bracketed in arrays,
    and found by Newton's method in a program."""
    film, random = WrinklingCone(law=LAWS[law]), np.random.default_rng(1)
    lm, lh, x = (random.uniform(low, high, 3000) for low, high in ((0.6, 1.5), (0.6, 1.8), (-1.5, 1.5)))
    x[::10] = 0.0
    given = PARAMETERS[law] | ({"stretch_limit": limit} if law == "gent" else {})
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, **given)
    # 2 % below pull-in: at the hump the root of a crumpled film is a double one
    squared = random.uniform(0.0, 0.98, 3000) ** 2 * np.minimum(film.highest_squared(x, n), 3.0)
    squared[::7] = 0.0
    n = {**n, **film.switches(x, squared, [], n)}
    graph = Graph()
    at, level, leaves = graph.state(0), graph.state(1), {name: graph.switch(name) for name in n}
    charge = film.capacitance(at, level, [], leaves, graph)
    values = {leaves[name].index: value for name, value in n.items()} | {at.index: x, level.index: squared}
    with np.errstate(all="ignore"):
        (found,) = evaluated([charge], values)
        arrays, kind = film.capacitance(x, squared, [], n), film.state(x, np.sqrt(squared), [], n).kind
    whole = np.isfinite(arrays)
    np.testing.assert_allclose(found[whole], arrays[whole], rtol=1e-9)
    assert np.bincount(kind[whole], minlength=4).min() > 100


def test_a_film_is_short_below_the_height_at_which_it_would_be_compressed_to_its_limit():
    """Of an equibiaxial pre-stretch 0.6 at x^2 = 1/0.36 - 1; a film with a wide limit never is."""
    for limit, edge in ((5.0, 1.0 / 0.36 - 1.0), (6.0, -1.0)):
        film = WrinklingCone(prestretch_mode="equibiaxial")
        n = film.numbers(film.complete({"prestretch": 0.6, "stretch_limit": limit}))
        assert float(n["shortest"]) == pytest.approx(edge)
        xx = np.array([0.0, 1.0, 1.77, 1.79, 4.0])
        switches = film.elastic.switches(np.sqrt(xx), 0.0, n)
        np.testing.assert_array_equal(switches["long"], np.where(xx > edge, 1.0, -1.0))


@pytest.mark.parametrize("limit", [8.0, 50.0, np.inf])
def test_a_film_pulls_in_by_whichever_comes_first(limit):
    """At no height later than where its minimum ends, and there where it does not localise before."""
    given = {"meridional_prestretch": 1.1, "hoop_prestretch": 0.9, "stretch_limit": limit}
    first, minimum = WrinklingCone(), WrinklingCone(pull_in="minimum")
    n = first.numbers(first.complete(given))
    x = np.linspace(0.0, 2.5, 60)
    ends, whole = minimum.highest_squared(x, n), first.highest_squared(x, n)
    localises = first.elastic._localising(x * x, n)
    np.testing.assert_array_equal(whole, np.minimum(ends, localises))
    for pull_in in ("memoryless", "snap"):  # their runs end by neither; the film fails where its minimum ends
        np.testing.assert_array_equal(WrinklingCone(pull_in=pull_in).highest_squared(x, n), ends)
    assert (localises < ends).any()
    assert (localises > ends).any()


@pytest.mark.parametrize("law", list(LAWS))
def test_a_film_localises_where_its_tension_no_longer_grows_with_its_length(law):
    """The tangent stiffness of a ring of the membrane with a slack hoop, which other formulas give, falls below
    zero."""
    for lm, lh in ((1.0, 1.0), (1.1, 0.9), (0.9, 1.2)):
        film = WrinklingCone(law=LAWS[law])
        n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, **PARAMETERS[law])
        x = np.linspace(0.8, 3.0, 12)
        V = film.elastic._localising(x * x, n)
        some = np.isfinite(V) & (film.elastic.highest_squared(x, n) == V)
        assert some.any()
        length, V, gel = np.sqrt(1.0 + x[some] ** 2), V[some], Gel(LAWS[law], n, lm**2, lh**2)
        below, at, above = (gel.at(length, np.ones(V.size), share * V) for share in (0.98, 1.0, 1.02))
        assert ((below.tangent_stiffness > 0.0) & (above.tangent_stiffness < 0.0) & (above.width > 1.0)).all()
        smooth = at.width > 1.0 + 1e-9  # elsewhere the tangent stiffness jumps, where the hoop falls slack
        assert smooth.any()
        np.testing.assert_allclose(
            (at.tangent_stiffness / (below.tangent_stiffness - above.tangent_stiffness))[smooth], 0.0, atol=1e-6
        )


def test_a_slack_film_comes_to_its_hoop_at_the_height_of_its_edge():
    """Without tension its border is edge - A x^2; a film that has failed returns by one of two rules."""
    given, x = {"meridional_prestretch": 0.8, "hoop_prestretch": 1.2}, np.array([0.2, 0.5, 1.1])
    film = WrinklingCone()
    n = film.numbers(film.complete(given))
    slack = {"pulls": -1.0, "width_held": 1.0, "crumpled": -1.0, "long": 1.0, "below_hump": 1.0}
    (value,) = in_program(film.elastic._width_border, n, slack, x, np.full(3, 0.3), [])
    np.testing.assert_allclose(value, (1.44 - 0.64) - 0.64 * x**2)
    failed = slack | {"whole": -1.0}
    for pull_in, expected in (("memoryless", 0.3 - n["limit_squared"]), ("snap", None)):
        own = WrinklingCone(pull_in=pull_in)
        m = own.numbers(own.complete(given))
        wanted = 0.3 - m["valley_squared"] if expected is None else expected
        (value,) = in_program(own.elastic._failure_border, m, failed, x, np.full(3, 0.3), [])
        np.testing.assert_allclose(value, np.full(3, float(wanted)))


def test_a_film_that_would_be_beyond_its_limit_if_it_were_held_flat_wrinkles_or_hangs_loose():
    """Pre-stretched by 0.6 either way it is as long as its gel at x^2 = 1/0.36 - 1: below, it does not pull; above, it
    does with the least energy over all widths, of which the mounted one is beyond the limit."""
    film, squared = WrinklingCone(prestretch_mode="equibiaxial"), 0.1
    n = film.numbers(film.complete({"prestretch": 0.6, "stretch_limit": 0.1}))
    edge = 1.0 / 0.36 - 1.0
    assert film.cone_strain(np.sqrt(2.5), n) > 0.1
    short = np.sqrt(edge * np.array([0.01, 0.3, 0.7, 0.99]))
    np.testing.assert_array_equal(film.force(short, squared, [], n)[0], np.zeros(4))
    loose = {"pulls": -1.0, "width_held": -1.0, "crumpled": 1.0, "long": -1.0, "below_hump": 1.0}
    (value,) = in_program(film.elastic._force_border, n, loose, short, np.full(4, squared), [])
    np.testing.assert_allclose(value + 0.0 * short, 1.0)  # whatever its formula says of a film beyond its limit

    def energy(x):
        A = B = 0.36
        q = 1.0 + x * x

        def at(width):
            strain = A * q + B * width + 1.0 / (A * B * q * width) - 3.0
            return np.where(strain < 0.1, -0.05 * np.log1p(-10.0 * strain) - 0.5 * squared * q * width, np.inf)

        widths = np.linspace(1.0, 5.0, 4001)
        with np.errstate(invalid="ignore", divide="ignore"):
            middle = widths[np.argmin(at(widths))]
        return minimize_scalar(
            at, bounds=(middle - 1e-3, middle + 1e-3), method="bounded", options={"xatol": 1e-12}
        ).fun

    for x in np.sqrt([2.4, 2.5]):
        slope = (energy(x + 1e-4) - energy(x - 1e-4)) / 2e-4
        assert float(film.force(x, squared, [], n)[0]) == pytest.approx(slope, rel=1e-5)
        assert slope > 0.01


@pytest.mark.parametrize("pull_in", ["first", "minimum", "memoryless", "snap"])
@pytest.mark.parametrize("limit", [8.0, 50.0])
def test_the_time_in_each_kind_is_that_of_the_states_with_its_switches(pull_in, limit):
    film, random = WrinklingCone(pull_in=pull_in), np.random.default_rng(5)
    lm, lh, x = (random.uniform(low, high, 300) for low, high in ((0.7, 1.6), (0.7, 1.7), (0.05, 1.6)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit)
    squared = random.uniform(0.0, 1.3, 300) * np.minimum(film.highest_squared(x, n), 3.0)
    signs, kind = film.switches(x, squared, [], n), film.state(x, np.sqrt(squared), [], n).kind
    places = sum(((value < 0.0) << k for k, value in enumerate(signs.values())), np.zeros(300, dtype=int))
    dwell = np.zeros((300, 2 ** len(signs)))
    dwell[np.arange(300), places] = 1.0
    times = film.times_of_kinds(tuple(signs), dwell)
    there = kind >= 0
    np.testing.assert_array_equal(np.argmax(times, axis=1)[there], kind[there])
    np.testing.assert_array_equal(times.sum(axis=1), np.ones(300))
    assert np.bincount(kind[there], minlength=len(film.kinds)).min() > 3
    below = n["A"] * (1.0 + x * x) < n["end_of_slack"]
    np.testing.assert_array_equal(signs["below_hump"], np.where(below, 1.0, -1.0))


def test_a_film_that_the_disc_stretches_beyond_its_valley_never_pulls_in():
    """Without tension it lies at one stretch t both ways, behind the valley 2.483, on the rising part of Vb."""
    film, x = WrinklingCone(), 1.0
    n = numbers(film, stretch_limit=8.0, meridional_prestretch=1.2)
    t = 2.88  # A (1 + x^2)
    assert float(n["valley"]) < t
    assert film.highest_squared(x, n) == 1e6
    for squared in (0.5, 1.5, 4.0):
        force, _ = film.force(x, squared, [], n)
        m, width = film.lengths(x, squared, n)
        assert np.isfinite([force, m, width]).all()
        if m > 2.0 + 1e-9:
            even = 1.44 * m
            assert width == pytest.approx(even)
            Vb = (1.0 - even**-3) / (even * (1.0 - (2.0 * even + even**-2 - 3.0) / 8.0))
            assert squared / 1.44 == pytest.approx(Vb)
    assert m > 2.1


def test_where_a_film_without_tension_ends_and_where_one_that_has_failed_returns():
    """Behind the hump, where the disc leaves the valley; a film that pulls has not failed."""
    given, x = {"meridional_prestretch": 1.3, "hoop_prestretch": 1.1, "stretch_limit": 8.0}, np.array([0.4, 0.8, 1.1])
    slack = {"pulls": -1.0, "width_held": -1.0, "crumpled": -1.0, "long": 1.0, "below_hump": -1.0}
    beyond = 1.69 * (1.0 + x * x) - 2.48259
    for pull_in in ("first", "minimum"):
        film = WrinklingCone(pull_in=pull_in)
        (value,) = in_program(film.elastic._end_border, numbers(film, **given), slack, x, np.full(3, 0.3), [])
        np.testing.assert_allclose(value, beyond, atol=1e-4)
    film = WrinklingCone(pull_in="memoryless")
    n = numbers(film, **given)
    failed, at = slack | {"whole": -1.0}, (x, np.full(3, 0.3), [])
    np.testing.assert_allclose(in_program(film.elastic._failure_border, n, failed, *at)[0], -beyond, atol=1e-4)
    taut = failed | {"pulls": 1.0, "width_held": 1.0}
    np.testing.assert_allclose(in_program(film.elastic._failure_border, n, taut, *at)[0], -np.ones(3))


@pytest.mark.parametrize(("pull_in", "pulls"), [("memoryless", 1.0), ("snap", 0.0)])
def test_a_film_that_has_failed_pulls_again_at_once_or_once_it_has_snapped_back(pull_in, pulls):
    film = WrinklingCone(pull_in=pull_in)
    n, x = numbers(film, hoop_prestretch=1.2, stretch_limit=8.0), np.array([0.4, 0.8])
    taut = {"pulls": 1.0, "width_held": 1.0, "crumpled": -1.0, "long": 1.0, "below_hump": 1.0}
    force, slope = (value for value in film.force(x, 0.05, [], n))
    for whole, share in ((1.0, 1.0), (-1.0, pulls)):
        for value, right in zip(
            in_program(film.force, n, taut | {"whole": whole}, x, np.full(2, 0.05), []), (force, slope), strict=True
        ):
            np.testing.assert_allclose(value + 0.0 * x, share * right, rtol=1e-12)


@pytest.mark.parametrize("limit", [8.0, 50.0])
def test_balancing_is_the_voltage_at_which_a_film_pulls_so_taut_or_wrinkled(limit):
    film, random = WrinklingCone(), np.random.default_rng(6)
    lm, lh, x = (random.uniform(low, high, 300) for low, high in ((0.8, 1.4), (0.8, 1.5), (0.1, 1.2)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit)
    squared = random.uniform(0.0, 0.99, 300) * np.minimum(film.highest_squared(x, n), 3.0)
    force, kind = film.force(x, squared, [], n)[0], film.state(x, np.sqrt(squared), [], n).kind
    pulls = (force > 1e-3) & (film.strain(x, n) < 0.99 * limit)
    np.testing.assert_allclose(film.balancing(x, force / x, n)[pulls], squared[pulls], rtol=1e-9, atol=1e-10)
    assert np.bincount(kind[pulls], minlength=2).min() > 20
    np.testing.assert_allclose(film.balancing(x, -0.1, n), film.balancing(x, 0.0, n) + 1e9, rtol=1e-9)


@pytest.mark.parametrize("limit", [8.0, 20.0, 50.0])
def test_a_film_localises_at_the_voltage_at_which_its_border_says_so(limit):
    """Above it the meridional force falls as a ring lengthens; behind the valley a film may do so, too."""
    film, random = WrinklingCone(), np.random.default_rng(9)
    lm, lh, x = (random.uniform(low, high, 2000) for low, high in ((0.6, 2.2), (0.5, 1.6), (0.1, 3.0)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit)
    localises = film.elastic._localising(x * x, n)
    found = (localises <= film.highest_squared(x, n)) & (localises < 1e5) & (film.strain(x, n) < limit)
    behind = n["A"] * (1.0 + x * x) >= n["valley"]
    assert (found & ~behind).sum() > 50
    assert (found & behind).sum() > 10 or limit < 20.0
    for share, whole in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
        squared = np.where(found, share * localises, 0.1)
        own = {**n, **film.switches(x, squared, [], n)}
        with np.errstate(all="ignore"):
            value = film.elastic._end_border(x, squared, [], own, np)
        np.testing.assert_array_equal(value[found] > 0.0, whole)


def test_where_the_place_is_unknown_so_are_the_lengths():
    film = WrinklingCone()
    x = np.array([0.1, np.nan, 0.8])
    for lm, lh, squared in itertools.product((0.9, 1.0), (0.9, 1.1), (0.0, 0.1, 0.3)):
        n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh)
        for found in film.lengths(x, squared, n):
            assert np.isnan(found).tolist() == [False, True, False]


@pytest.mark.parametrize("pull_in", ["first", "minimum", "memoryless", "snap"])
@pytest.mark.parametrize("limit", [8.0, 50.0])
def test_programs_have_the_force_of_arrays_and_borders_on_the_side_of_their_switches(pull_in, limit):
    """Whether the switches are fixed by the program, as those of a first film, or may change, as those of a second."""
    film, random = WrinklingCone(pull_in=pull_in), np.random.default_rng(11)
    lm, lh, x = (random.uniform(low, high, 150) for low, high in ((0.7, 1.6), (0.7, 1.7), (0.05, 1.6)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit)
    squared = random.uniform(0.0, 0.98, 150) * np.minimum(film.highest_squared(x, n), 3.0)
    signs = film.switches(x, squared, [], n)
    names = [border.switch for border in film.borders if border.switch]
    assert sorted(names) == sorted(signs)

    def formulas(x, squared, y, n, xp):
        return [*film.force(x, squared, y, n, xp), *(border.value(x, squared, y, n, xp) for border in film.borders)]

    def check(found, here):
        for value, right in zip(found[:2], film.force(x[here], squared[here], [], taken(here)), strict=True):
            np.testing.assert_allclose(value + 0.0 * x[here], right, rtol=1e-7, atol=1e-8)
        for value, border in zip(found[2:], film.borders, strict=True):
            assert np.all(value > -1e-12), border.switch

    def taken(here):
        return {name: np.broadcast_to(value, x.shape)[here] for name, value in n.items()}

    everywhere = np.ones(150, dtype=bool)
    mixed = in_program(formulas, {**n, **signs}, {}, x, squared, [])
    check(mixed, everywhere)
    table = np.array([signs[name] for name in names]).T
    for row in np.unique(table, axis=0):
        here = (table == row).all(axis=1)
        own = dict(zip(names, row, strict=True))
        found = in_program(formulas, taken(here), own, x[here], squared[here], [])
        check(found, here)
        for value, other in zip(found, mixed, strict=True):
            np.testing.assert_allclose(value + 0.0 * x[here], (other + 0.0 * x)[here], rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("law", list(LAWS))
def test_the_slope_of_the_hoop_stress_by_the_width_is_its_derivative(law):
    film, random = WrinklingCone(law=LAWS[law]), np.random.default_rng(3)
    n = numbers(film, hoop_prestretch=1.3, **PARAMETERS[law])
    xx, squared, y = random.uniform([[0.0], [0.0], [0.0]], [[3.0], [2.0], [1.5]], (3, 50))
    (slopes,) = gradients(lambda z, xp: [film.elastic.local(xx, squared, z[0], n, xp).excess], [y])
    np.testing.assert_allclose(film.elastic._excess_slope(xx, squared, y, n), slopes[0], rtol=1e-12)


def test_the_widest_film_is_at_its_stretch_limit_and_without_one_has_no_bound():
    film, xx = WrinklingCone(), np.linspace(0.0, 30.0, 40)
    n = numbers(film, hoop_prestretch=1.3, stretch_limit=12.0)
    most = film.elastic._most_stretched(xx, n)
    own = film.elastic.local(xx, 0.0, most, n)
    bounded = most > 0.0
    np.testing.assert_allclose(own.strain[bounded], 12.0, rtol=1e-11)
    assert (own.compliance[bounded] > 0.0).all()
    assert 5 < bounded.sum() < 30
    assert (film.strain(np.sqrt(xx), n)[~bounded] > 11.9).all()
    assert np.isinf(film.elastic._most_stretched(xx, numbers(film, stretch_limit=math.inf))).all()
