"""The formulas of a wrinkling film that creeps: one energy for stresses, lengths and force; its ends; its borders."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize

from gelcone.physics.film.creeping import UNREACHED, Creeping
from gelcone.physics.film.wrinkling import STATES, WrinklingCone
from tests.physics.film.programs import in_program

GIVEN = {
    "meridional_prestretch": 1.05, "hoop_prestretch": 1.1, "stretch_limit": 20.0,
    "viscous_modulus_1": 0.6, "relaxation_time_1": 2.0, "viscous_limit_1": 15.0,
    "viscous_modulus_2": 0.3, "relaxation_time_2": 8.0, "viscous_limit_2": 30.0,
}  # fmt: skip
FLOWS = {"log": 2, "linear": 3}
"""Flow rules, and the states of a branch."""


@cache
def film_of(flow="log", pull_in="first", **changes):
    """A film with two branches, and its numbers."""
    film = WrinklingCone(branches=2, flow=flow, pull_in=pull_in)
    given = {k: v for k, v in {**GIVEN, **changes}.items() if flow == "log" or "viscous_limit" not in k}
    return film, film.numbers(film.complete(given))


def samples(flow="log", count=60, seed=4, across=(0.75, 1.05)):
    """Heights, squared voltages and states at which all four kinds of slackness occur; with branches that are stretched
    more ``across``, the meridian is slack more often."""
    random = np.random.default_rng(seed)
    x, squared = random.uniform(0.05, 1.2, count), random.uniform(0.0, 0.9, count)
    y = []
    for _ in range(2):
        first, second = random.uniform(0.45, 1.05, count), random.uniform(*across, count)
        y += [first, second] if flow == "log" else [first, second, 1.0 / (first * second)]
    return x, squared, y


def energy(film, m, width, squared, y, n):
    """Energy of law and branches less V m n/2."""
    strain = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
    return film.law.energy(strain, n) + film.viscous.energy(m, width, y, n) - 0.5 * squared * m * width


@pytest.mark.parametrize("flow", FLOWS)
def test_stresses_and_their_slopes_are_derivatives_of_one_energy(flow):
    (film, n), (x, squared, y), h = film_of(flow), samples(flow), 1e-4
    m, width = 1.0 + x * x, 1.0 + 0.3 * squared

    def at(a, b):
        return energy(film, m * np.exp(a * h), width * np.exp(b * h), squared, y, n)

    def stress(a, b):
        own = film.creeping.tension(m * np.exp(a * h), squared, width * np.exp(b * h), y, n)
        return own.along / own.compliance, own.across / own.compliance

    own = film.creeping.tension(m, squared, width, y, n)
    np.testing.assert_allclose(own.along / own.compliance, (at(1, 0) - at(-1, 0)) / h, atol=1e-7)
    np.testing.assert_allclose(own.across / own.compliance, (at(0, 1) - at(0, -1)) / h, atol=1e-7)
    h11, h12, h22 = (value / own.compliance for value in film.creeping.slopes(own, m, width, y, n))
    by_m, by_n = (
        [(b - a) / (2.0 * h) for a, b in zip(stress(-i, -j), stress(i, j), strict=True)] for i, j in [(1, 0), (0, 1)]
    )
    np.testing.assert_allclose([h11, h12, h12, h22], [*by_m, *by_n], atol=1e-6)


@pytest.mark.parametrize("flow", FLOWS)
def test_the_film_takes_the_least_energy_over_lengths_that_are_not_shorter_than_its_gap(flow):
    """By a minimiser that knows the energy alone; the force is its slope, in every kind of slackness."""
    (film, n), (x, squared, y) = film_of(flow), samples(flow, 48)
    q = 1.0 + x * x
    m, width = film.creeping.solved(q, squared, y, n)
    kinds, scale = [], 1e-5
    for k in np.flatnonzero(np.isfinite(m)):
        own = [value[k] for value in y]

        def of(z, q, own=own, k=k):
            return energy(film, *np.exp(z), squared[k], own, n)

        def least(q, k=k):
            bounds = [(np.log(q), np.log(2.5 * q)), (0.0, 0.9)]
            start = [np.log(max(m[k], q)), np.log(width[k])]
            return minimize(of, start, (q,), bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-10})

        found = least(q[k])
        np.testing.assert_allclose([m[k], width[k]], np.exp(found.x), rtol=2e-4)
        slope = (least(q[k] + scale).fun - least(q[k] - scale).fun) / (2.0 * scale)
        force = film.force(x[k], squared[k], own, n)[0]
        assert float(force) == pytest.approx(2.0 * x[k] * slope, abs=2e-4)
        kinds.append(2 * (m[k] > q[k] * (1.0 + 1e-9)) + (width[k] > 1.0 + 1e-9))
    assert np.bincount(kinds, minlength=4).min() > 1
    np.testing.assert_array_equal(film.state(x, np.sqrt(squared), y, n).kind[np.isfinite(m)], kinds)
    assert len(STATES) == 4


@pytest.mark.parametrize("flow", FLOWS)
def test_the_slope_of_the_force_is_its_derivative_and_no_voltage_but_one_gives_a_force(flow):
    (film, n), (x, squared, y), h = film_of(flow), samples(flow, 200), 1e-5
    force, slope = film.force(x, squared, y, n)
    above, below = (film.force(x + d, squared, y, n)[0] for d in (h, -h))
    smooth = np.isfinite(force) & (np.abs(above - 2.0 * force + below) < 1e-8)
    assert smooth.sum() > 100
    np.testing.assert_allclose(slope[smooth], ((above - below) / (2.0 * h))[smooth], atol=2e-4)
    pulls = smooth & (force > 1e-3)
    own = [value[pulls] for value in y]
    found = film.creeping.balancing(x[pulls], force[pulls] / x[pulls], own, n)
    np.testing.assert_allclose(found, squared[pulls], rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("pull_in", ["first", "minimum"])
@pytest.mark.parametrize("limit", [4.0, 20.0, np.inf])
def test_a_film_whose_branches_carry_nothing_is_the_elastic_one(pull_in, limit):
    law = {"stretch_limit": limit, "viscous_limit_1": np.inf, "viscous_limit_2": np.inf}
    film, n = film_of("log", pull_in, **law, viscous_modulus_1=0.0, viscous_modulus_2=0.0)
    plain = WrinklingCone(pull_in=pull_in)
    own = plain.numbers(
        plain.complete({k: v for k, v in GIVEN.items() if "prestretch" in k} | {"stretch_limit": limit})
    )
    x = np.linspace(0.05, 1.6, 24)
    y = [np.full(24, value) for value in (0.9, 1.0, 0.8, 1.1)]
    highest = plain.highest_squared(x, own)
    found = np.minimum(film.highest_squared_held(x, y, n), UNREACHED)
    np.testing.assert_allclose(found, np.minimum(highest, UNREACHED), rtol=1e-6)
    squared = np.linspace(0.02, 0.97, 24) * np.minimum(highest, 2.0)
    for name in ("force", "capacitance", "work"):
        np.testing.assert_allclose(
            getattr(film, name)(x, squared, y, n), getattr(plain, name)(x, squared, [], own), rtol=1e-7, atol=1e-9
        )
    np.testing.assert_allclose(
        film.creeping.solved(1.0 + x * x, squared, y, n), plain.lengths(x, squared, own), rtol=1e-7
    )


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("pull_in", ["first", "minimum"])
@pytest.mark.parametrize(("across", "limit"), [((0.75, 1.05), 15.0), ((1.0, 1.4), 15.0), ((0.9, 1.3), 8.0)])
def test_a_film_ends_at_its_highest_voltage_where_a_border_says_so(flow, pull_in, across, limit):
    """Below it the film has a minimum and, where it is held, does not localise; above one of both is lost. Branches
    near their limit withstand more."""
    film, n = film_of(flow, pull_in, viscous_limit_1=limit)
    x, _, y = samples(flow, 40, 7, across)
    with np.errstate(all="ignore"):
        inside = film.viscous.limit_share(1.0 + x * x, 1.0, y, n) < 0.95 + 0.0 * x
    x, y = x[inside], [value[inside] for value in y]
    highest = film.highest_squared_held(x, y, n)
    assert (highest < UNREACHED).sum() > 5
    ends = [border for border in film.borders if border.switch is None]
    assert len(ends) == 2 - (pull_in == "minimum")
    for share, whole in ((0.999, True), (1.001, False)):
        squared = share * highest
        signs = film.switches(x, squared, y, n)
        with np.errstate(all="ignore"):
            values = [border.value(x, squared, y, {**n, **signs}, np) for border in ends]
        lost = np.isnan(signs["width_held"]) | ~(np.min(values, axis=0) > 0.0)
        np.testing.assert_array_equal(lost[highest < UNREACHED], not whole)


@pytest.mark.parametrize("flow", FLOWS)
def test_borders_have_the_side_of_their_switch_in_arrays_and_in_programs(flow):
    """Each border that divides is positive where its switch is that of the state; so is each that ends the film."""
    (film, n), (x, squared, y) = film_of(flow), samples(flow, 60, 9)
    signs = film.switches(x, squared, y, n)
    whole, seen = np.isfinite(signs["width_held"]), set()
    for sign in np.ndindex(2, 2):
        own = {"meridian_held": 1.0 - 2.0 * sign[0], "width_held": 1.0 - 2.0 * sign[1]}
        here = whole & (signs["meridian_held"] == own["meridian_held"]) & (signs["width_held"] == own["width_held"])
        at = x[here], squared[here], [value[here] for value in y]
        seen.add(bool(here.any()))
        arrays = {k: np.full(here.sum(), v) for k, v in own.items()}
        for border in film.borders:
            (value,) = in_program(border.value, n, own, *at)
            with np.errstate(all="ignore"):
                np.testing.assert_allclose(value, border.value(*at, {**n, **arrays}, np), rtol=1e-7, atol=1e-9)
            if border.switch:
                assert (value > 0.0).all()
        for name in ("capacitance", "force"):
            program = in_program(getattr(film, name), n, own, *at)[0]
            exact = getattr(film, name)(*at, n)
            np.testing.assert_allclose(program, exact[0] if name == "force" else exact, rtol=1e-7, atol=1e-9)
    assert seen == {True}


def test_a_film_that_nothing_holds_ends_where_its_voltage_is_highest():
    """Flat, and equally stretched like its branches: V over the stretch t has its first maximum there, on a grid."""
    film, n = film_of("log", "minimum", meridional_prestretch=1.0, hoop_prestretch=1.0, stretch_limit=50.0)
    state = 0.9
    y = [np.array([state])] * 4
    t = np.linspace(1.0, 2.4, 200_001)
    inside = [(n[f"viscous_modulus_{k}"], 1.0 / n[f"inverse_viscous_limit_{k}"]) for k in (1, 2)]
    strain = 2.0 * t + t**-2 - 3.0
    stress = (t - t**-2) / (1.0 - strain / 50.0)
    for g, limit in inside:
        own = state * t
        stress = stress + g * (own - own**-2) / (1.0 - (2.0 * own + own**-2 - 3.0) / limit)
    squared = stress / t**2
    last = int(np.argmax(np.diff(squared) < 0.0))
    found = Creeping(film, localises=False).highest_squared(np.array([0.0]), y, n)
    assert float(found[0]) == pytest.approx(squared[last], rel=1e-8)
    V, longest = Creeping(film, localises=False)._free_end(y, n)
    assert (float(V[0]), float(longest[0])) == pytest.approx((squared[last], t[last]), rel=1e-4)


@pytest.mark.parametrize("flow", FLOWS)
def test_the_borders_that_end_the_film_are_those_of_its_energy(flow):
    """The Hessian by the logarithms of its free lengths less a share of the modulus; 2 (h11 h22 - h12^2) - s1 h22 of a
    held film with slack hoops; 1 where the other border is the one."""
    (film, n), (x, squared, y) = film_of(flow), samples(flow, 240, 13)
    m, width = film.creeping.solved(1.0 + x * x, squared, y, n)
    localises, ends = [border.value for border in film.borders if border.switch is None]
    own = film.creeping.tension(m, squared, width, y, n)
    h11, h12, h22 = film.creeping.slopes(own, m, width, y, n)
    stiff = 1.0 + n["viscous_modulus_1"] + n["viscous_modulus_2"]
    held, narrow = m <= 1.0 + x * x, width <= 1.0
    free = h11 * h22 - h12 * h12
    signs = {"meridian_held": np.where(held, 1.0, -1.0), "width_held": np.where(narrow, 1.0, -1.0)}
    at, whole = (x, squared, y, {**n, **signs}, np), np.isfinite(m)
    right = np.where(held, 1.0, np.where(narrow, h11 - 3e-4 * stiff, free - 3e-4 * stiff**2))
    np.testing.assert_allclose(ends(*at)[whole], right[whole], rtol=1e-10)
    right = np.where(held & ~narrow, 2.0 * free - own.along * h22, 1.0)
    np.testing.assert_allclose(localises(*at)[whole], right[whole], rtol=1e-10)
    assert np.bincount((2 * ~held + ~narrow)[whole], minlength=4).min() > 1


def test_a_film_whose_branch_is_at_its_limit_before_it_softens_never_pulls_in():
    """A branch that may be stretched by 10 % alone bears any voltage with the film still thick; so at any states, also
    where a search for the width comes to the limit itself. Steps of Newton's method lead beyond that limit; the
    lengths are inside, in balance, and the charge rises with the voltage."""
    film, n = film_of("log", "first", viscous_limit_1=0.6)
    n = dict(n)
    x, _, y = samples("log", 24, 7, (0.9, 1.3))
    inside = film.viscous.limit_share(1.0 + x * x, 1.0, y, n) < 0.95
    assert inside.sum() > 12
    x, y = x[inside], [value[inside] for value in y]
    assert (film.highest_squared_held(x, y, n) >= UNREACHED).all()
    x, y, squared = x[:4], [value[:4] for value in y], np.array([[3.0], [5.0]])
    n["viscous_modulus_2"] = np.full(4, n["viscous_modulus_2"])  # numbers of members
    q = 1.0 + np.square(np.append(x[:3], np.nan))
    m, width = film.creeping.solved(q, squared, y, n)
    assert np.isnan(m).tolist() == np.isnan(width).tolist() == [[False, False, False, True]] * 2
    own = film.creeping.tension(m, squared, width, y, n)
    assert (film.viscous.limit_share(m, width, y, n)[:, :3] < 1.0).all()
    for stress, held in ((own.along, m == q), (own.across, width == 1.0)):
        assert np.where(held, stress >= -1e-9, np.abs(stress) < 1e-6)[:, :3].all()
    assert (np.diff(m * width, axis=0)[:, :3] > 0.0).all()


@pytest.mark.parametrize("flow", FLOWS)
def test_the_time_in_each_kind_is_that_of_the_states_with_its_switches(flow):
    (film, n), (x, squared, y) = film_of(flow), samples(flow, 120, 9)
    signs, kind = film.switches(x, squared, y, n), film.state(x, np.sqrt(squared), y, n).kind
    whole = kind >= 0
    places = sum(((value < 0.0) << k for k, value in enumerate(signs.values())), np.zeros(120, dtype=int))
    dwell = np.eye(2 ** len(signs))[places]
    np.testing.assert_array_equal(np.argmax(film.times_of_kinds(tuple(signs), dwell), axis=1)[whole], kind[whole])
    assert np.bincount(kind[whole], minlength=4).min() > 1


def test_where_a_film_has_no_length_no_switch_has_a_sign():
    film, n = film_of("log", "minimum")
    x, _, y = samples("log", 20, 7)
    highest = film.highest_squared_held(x, y, n)
    ends = highest < UNREACHED
    assert ends.sum() > 5
    for share, lost in ((0.99, False), (1.2, True)):
        for sign in film.switches(x, share * highest, y, n).values():
            np.testing.assert_array_equal(np.isnan(sign)[ends], lost)


def test_a_single_state_has_the_lengths_and_switches_that_it_has_among_others():
    """As numbers, not arrays; also where the minimum has ended and where descent of the energy finds it."""
    film, n = film_of("log", "minimum")
    x, _, y = samples("log", 20, 7)
    for squared in 0.99 * film.highest_squared_held(x, y, n), np.full(20, 3.0):
        together = film.creeping.solved(1.0 + x * x, squared, y, n)
        signs = film.switches(x, squared, y, n)
        for k in range(20):
            own = x[k], squared[k], [value[k] for value in y], n
            alone = film.creeping.solved(1.0 + own[0] ** 2, *own[1:])
            np.testing.assert_allclose(alone, np.stack(together)[:, k], rtol=1e-12)
            for name, sign in film.switches(*own).items():
                np.testing.assert_array_equal(sign, signs[name][k])


def test_the_border_of_the_meridian_is_its_stress_at_the_width_that_the_film_takes():
    (film, n), (x, squared, y) = film_of(), samples("log", 240, 13)
    q = 1.0 + x * x
    m, width = film.creeping.solved(q, squared, y, n)
    held = (m <= q) & (width > 1.0)
    assert held.sum() > 20
    at = x[held], squared[held], [value[held] for value in y]
    signs = {"meridian_held": np.ones(held.sum()), "width_held": -np.ones(held.sum())}
    own = film.creeping.tension(q[held], at[1], width[held], at[2], n)
    (border,) = [border for border in film.borders if border.switch == "meridian_held"]
    np.testing.assert_allclose(border.value(*at, {**n, **signs}, np), own.along, rtol=1e-9)
    np.testing.assert_allclose(own.across, 0.0, atol=1e-8)


def test_a_film_that_the_disc_holds_far_beyond_where_it_would_end_free_has_its_minimum_at_any_voltage():
    """Held shorter it ends as a free one; where the film without tension is firm again it does not."""
    film, n = film_of("log", "minimum", stretch_limit=8.0, viscous_limit_1=np.inf, viscous_limit_2=np.inf)
    y = [np.array([0.9])] * 4
    V, longest = film.creeping._free_end(y, n)
    assert np.isfinite(V[0])
    q = longest[0] * np.array([0.6, 0.95, 1.7, 1.9])
    y = [np.full(4, 0.9)] * 4
    found = film.highest_squared_held(np.sqrt(q - 1.0), y, n)
    np.testing.assert_allclose(found[:2], V[0], rtol=1e-6)
    assert (found[2:] >= UNREACHED).all()
    m, width = film.creeping.solved(q[2:], np.full(2, 20.0), [value[2:] for value in y], n)
    assert np.isfinite([m, width]).all()


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("share", [0.9, 0.99, 0.999])
def test_a_program_finds_the_lengths_of_a_film_without_tension_next_to_where_its_minimum_ends(flow, share):
    """Both are roots that depend on each other: there the Hessian is nearly singular."""
    film, n = film_of(flow, "minimum", meridional_prestretch=1.0, hoop_prestretch=1.0, stretch_limit=50.0)
    x, _, y = samples(flow, 40, 9)
    squared = share * np.minimum(film.highest_squared_held(x, y, n), 3.0)
    signs = film.switches(x, squared, y, n)
    here = (signs["meridian_held"] < 0.0) & (signs["width_held"] < 0.0)
    assert here.sum() > 15
    at, own = (x[here], squared[here], [value[here] for value in y]), {"meridian_held": -1.0, "width_held": -1.0}
    np.testing.assert_allclose(in_program(film.capacitance, n, own, *at)[0], film.capacitance(*at, n), rtol=1e-10)


def test_a_free_film_whose_hoop_is_held_is_as_soft_as_along_its_meridian():
    """-h11 where its width is the mounted one, the Hessian where both lengths are free; minima end in folds."""
    film, n = film_of("log", "minimum", meridional_prestretch=0.8, hoop_prestretch=1.4)
    y, m = [np.full(3, 0.9)] * 4, np.array([1.2, 1.5, 4.5])
    width = film.creeping.free_width(m, y, n)
    assert (width > 1.0).tolist() == [False, False, True]
    own = film.creeping.tension(m, 0.0, width, y, n)
    at = film.creeping.tension(m, own.along / (own.compliance * m * width), width, y, n)
    h11, h12, h22 = film.creeping.slopes(at, m, width, y, n)
    softness, whole = film.creeping.softness(m, y, n)
    assert whole.all()
    np.testing.assert_allclose(softness, np.where(width > 1.0, h12 * h12 - h11 * h22, -h11), rtol=1e-12)
    assert [border.folds for border in film.borders] == [False, False, True]
