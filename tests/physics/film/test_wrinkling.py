"""The wrinkling film: where it pulls in, and laws of a user's own."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.codes import FilmPullIn
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.physics.film import elastic
from gelcone.physics.film.film import Film
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.physics.model import ConeModel
from gelcone.quantity import Quantity
from tests.physics.film.programs import in_program

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "wrinkling.json").read_text())

PARAMETERS = {"gent": {"stretch_limit": 50.0}, "neo-hookean": {}, "yeoh": {"yeoh_c2": 0.02, "yeoh_c3": 0.001}}


def numbers(film, **given):
    return film.numbers(film.complete(given))


@pytest.mark.parametrize("limit", list(REFERENCE["folds_of_Vb"]))
def test_a_crumpled_film_pulls_in_at_the_hump_of_the_reference(limit):
    film, fold = WrinklingCone(), REFERENCE["folds_of_Vb"][limit]
    n = numbers(film, stretch_limit=float(limit))
    assert float(n["limit_squared"]) == pytest.approx(fold["VG_c"], abs=1e-14)
    assert float(n["hump"]) == pytest.approx(fold["t_c"], abs=1e-7)


def test_a_film_that_stiffens_early_never_pulls_in():
    film = WrinklingCone()
    for limit, ever in ((5.0, False), (7.3, False), (7.32, True)):
        n = numbers(film, stretch_limit=limit)
        assert np.isfinite(film.highest_squared(0.3, n)) == ever


class Fung(StrainEnergyLaw):
    """W = (exp(b e) - 1)/(2 b), e = I1 - 3: a law of a user's own that needs more than arithmetic."""

    name = "fung"
    parameters = {"fung_b": Quantity("b", "how fast it stiffens", 0.05, positive=True)}

    def energy(self, strain, n, xp=np):
        return (xp.exp(n["fung_b"] * strain) - 1.0) / (2.0 * n["fung_b"])

    def response(self, strain, n, xp=np):
        return xp.exp(n["fung_b"] * strain)

    def response_slope(self, strain, n, xp=np):
        return n["fung_b"] * xp.exp(n["fung_b"] * strain)

    def strain_limit(self, n):
        return np.asarray(50.0)


def test_statics_and_motion_of_a_film_whose_law_takes_functions():
    """The static force of a wrinkled film is what the motion feels, and its slopes are those of differences."""
    model = ConeModel(film=WrinklingCone(law=Fung()), rest_height=0.9, prestretch=1.1, spring_stiffness=3.0)
    n = model.own_numbers
    x, squared, h = np.linspace(0.2, 1.2, 9), 0.3, 1e-6
    _, slope = model.film.force(x, squared, [], n)
    ahead, behind = (model.film.force(x + step, squared, [], n)[0] for step in (h, -h))
    np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * h), rtol=1e-7, atol=1e-8)
    up, down = (model.film.force(x, squared + step, [], n)[0] for step in (h, -h))
    np.testing.assert_allclose(model.film.voltage_gain(x, squared, n), (down - up) / (2.0 * h), rtol=1e-7, atol=1e-8)
    place = float(stroke_and_blocked_force(model, [0.4])["displacement"][0])
    held = model.replace(voltage=0.0, voltage_bias=0.4, damping_ratio=0.5)
    assert integrate(held, (place, 0.0), [200.0]).states[0, 0, 0] == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize(
    ("meridional", "hoop", "turning"),
    [
        (1.0, 1.0, "hump"),
        (1.0, 1.9, None),
        (1.9, 1.0, "hump"),
        (1.9, 1.9, None),
        (1.0, 1.45, "hoop"),
        (1.45, 1.0, "hump"),
    ],
)
def test_a_slack_film_pulls_in_at_the_hump_or_its_hoop_and_never_where_that_lies_beyond_the_valley(
    meridional, hoop, turning
):
    """Hump 1.862 and valley 2.483 at a stretch limit of 8: what counts is the square of the pre-stretch of the hoop."""
    film = WrinklingCone()
    n = numbers(film, stretch_limit=8.0, meridional_prestretch=meridional, hoop_prestretch=hoop)
    assert (float(n["hump"]), float(n["valley"])) == pytest.approx((1.8625, 2.4826), abs=1e-4)
    assert float(n["edge"]) == (hoop**2 - meridional**2 if hoop > meridional else -1.0)
    if turning is None:
        assert float(n["limit_squared"]) >= 1e29
        return
    t = {"hump": float(n["hump"]), "hoop": hoop**2}[turning]
    stress = (1.0 - t**-3) / (t * (1.0 - (2.0 * t + t**-2 - 3.0) / 8.0))
    assert float(n["limit_squared"]) == pytest.approx(stress * (meridional * hoop) ** 2, rel=1e-9)
    assert float(n["end_of_slack"]) == pytest.approx(t)


def test_where_a_film_without_tension_changes_and_how_long_its_gel_is_by_hand():
    """The A x^2 at which A q = B; the V of the valley; the q at which A q is the natural 1, or 1/B^(1/2) of a hoop that
    is wider than its gel, of films that would be beyond their limit if they were as short as their gap."""
    n = numbers(WrinklingCone(pull_in="snap"), meridional_prestretch=0.8, hoop_prestretch=1.2, stretch_limit=8.0)
    assert float(n["edge"]) == pytest.approx(1.44 - 0.64)
    t = float(n["valley"])
    stress = (1.0 - t**-3) / (t * (1.0 - (2.0 * t + t**-2 - 3.0) / 8.0))
    assert float(n["valley_squared"]) == pytest.approx(stress * (0.8 * 1.2) ** 2, rel=1e-9)
    for lm, lh, natural in ((0.6, 0.7, 1.0), (0.6, 1.2, 1.0 / 1.2), (0.5, 1.0, 1.0)):
        film = WrinklingCone()
        n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=0.7)
        assert float(n["shortest"]) == pytest.approx(natural / lm**2 - 1.0)
        x = np.sqrt(natural / lm**2 - 1.0)
        m, width = film.resting_lengths(np.array([0.5, 0.999, 1.02]) * x, 0.0, n)
        np.testing.assert_allclose(lm**2 * m[:2], natural, rtol=1e-6)
        np.testing.assert_allclose(width[:2], max(1.0, lh**-2), rtol=1e-6)
        assert lm**2 * m[2] > natural * (1.0 + 1e-3)
        free = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=1e3)
        assert float(free["shortest"]) == -1.0  # compressed as far it is within its limit


# --- borders ----------------------------------------------------------------------------------------------------------


def drawn(limit, pull_in, count=400, seed=11, law="gent", **more):
    """A random film at each of many places and voltages, some of them above its highest."""
    film, random = WrinklingCone(law=LAWS[law], pull_in=pull_in), np.random.default_rng(seed)
    lm, lh, x = (random.uniform(low, high, count) for low, high in ((0.7, 1.6), (0.7, 1.7), (0.05, 1.6)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit, **more)
    return film, n, x, random


@pytest.mark.parametrize("pull_in", ["first", "minimum"])
@pytest.mark.parametrize("limit", [4.0, 8.0, 50.0])
def test_the_film_ends_at_its_highest_voltage_where_its_border_says_so(limit, pull_in):
    """A film that the disc stretches beyond the valley of its voltage does not; nor does one that stiffens early."""
    film, n, x, _ = drawn(limit, pull_in)
    highest = film.highest_squared(x, n)
    ends = np.isfinite(highest) & (highest < 1e5)
    (border,) = [border for border in film.borders if border.switch is None]
    for share, whole in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
        squared = np.where(ends, share * highest, 2.0)
        own = {**n, **film.switches(x, squared, [], n)}
        with np.errstate(all="ignore"):
            value = border.value(x, squared, [], own, np)
        np.testing.assert_array_equal(value[ends] > 0.0, whole)
        assert (value[~ends] > 0.0).all()
        gone = np.isnan(film.force(x, squared, [], n)[0])
        assert not gone[~ends].any()
        assert whole <= (not gone.any())
    for share in np.linspace(0.0, 0.999, 30):  # and nowhere before
        squared = share * np.where(ends, highest, 3.0)
        with np.errstate(all="ignore"):
            value = border.value(x, squared, [], {**n, **film.switches(x, squared, [], n)}, np)
        assert (value > 0.0).all()
    assert ends.sum() >= 300 * (limit > 20.0)
    assert (~ends).any() or limit > 20.0


@pytest.mark.parametrize("pull_in", ["first", "minimum", "memoryless", "snap"])
@pytest.mark.parametrize("limit", [8.0, 50.0])
def test_borders_of_a_program_have_the_side_of_the_switches_of_arrays(limit, pull_in):
    """Each is positive where the switches are those of the state, and the force is that of arrays there."""
    film, n, x, random = drawn(limit, pull_in)
    squared = random.uniform(0.0, 0.98, x.size) * np.minimum(film.highest_squared(x, n), 3.0)
    signs = film.switches(x, squared, [], n)
    names = [border.switch for border in film.borders if border.switch]
    assert sorted(names) == sorted(signs)
    table = np.array([signs[name] for name in names]).T
    for row in np.unique(table, axis=0):
        here = (table == row).all(axis=1)
        own, there = dict(zip(names, row, strict=True)), elastic._taken(n, here)
        at = x[here], squared[here], []
        for border in film.borders:
            (value,) = in_program(border.value, there, own, *at)
            assert np.all(value > -1e-12), border.switch
        exact = film.force(*at, there)
        for found, right in zip(in_program(film.force, there, own, *at), exact, strict=True):
            np.testing.assert_allclose(found + 0.0 * at[0], right, rtol=1e-7, atol=1e-8)
    assert len(np.unique(table[:, :3], axis=0)) > 3


@pytest.mark.parametrize("law", list(LAWS))
def test_the_strain_is_that_of_the_lengths_without_voltage(law):
    """Of films that are too short or too wide for their gap, too."""
    film, random = WrinklingCone(law=LAWS[law]), np.random.default_rng(2)
    lm, lh, x = (random.uniform(low, high, 200) for low, high in ((0.6, 1.4), (0.6, 1.6), (0.0, 1.2)))
    n = numbers(film, meridional_prestretch=lm, hoop_prestretch=lh, **PARAMETERS[law])
    m, width = film.resting_lengths(x, 0.0, n)
    exact = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
    np.testing.assert_allclose(film.strain(x, n), exact, atol=1e-9)
    kinds = 2 * (m > (1.0 + x * x) * (1.0 + 1e-9)) + (width > 1.0 + 1e-9)
    assert np.bincount(kinds, minlength=4).min() > 5


# --- branches ---------------------------------------------------------------------------------------------------------

CREEPING = {
    "hoop_prestretch": 1.1, "stretch_limit": 20.0, "viscous_modulus_1": 0.6, "relaxation_time_1": 2.0,
    "viscous_limit_1": 5.0,
}  # fmt: skip


def creeping(count=80, **changes):
    """A film with a branch, its numbers, and heights, squared voltages and states at which it has a length."""
    film, random = WrinklingCone(branches=1), np.random.default_rng(4)
    n = numbers(film, **CREEPING | changes)
    x, squared = random.uniform(0.05, 1.2, count), random.uniform(0.0, 0.9, count)
    y = [random.uniform(0.5, 1.05, count), random.uniform(0.75, 1.05, count)]
    whole = np.isfinite(film.force(x, squared, y, n)[0])
    return film, n, x[whole], squared[whole], [value[whole] for value in y]


def test_a_film_that_creeps_pulls_with_its_meridional_stress_and_has_none_across_its_wrinkles():
    """F = x s1/q; at n > 1 the hoop has no stress. A share of a limit is the larger one of law and branch."""
    film, n, x, squared, y = creeping()
    state, (m, width) = film.state(x, np.sqrt(squared), y, n), film._lengths_at(x, squared, y, n)
    pull = state.meridional_stress * x / (1.0 + x * x)
    np.testing.assert_allclose(film.force(x, squared, y, n)[0], np.where(m > 1.0 + x * x, 0.0, pull), atol=1e-9)
    slack = width > 1.0
    assert 5 < slack.sum() < x.size - 5
    np.testing.assert_allclose(state.hoop_stress[slack], 0.0, atol=1e-8)
    assert (state.hoop_stress[~slack] > 0.0).all()
    of_law = (n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0) / 20.0
    first, second = y[0] * m, y[1] * width
    of_branch = (first + second + 1.0 / (first * second) - 3.0) / 5.0
    assert (of_branch > of_law).any()
    assert (of_branch < of_law).any()
    np.testing.assert_allclose(film.limit_share(x, np.sqrt(squared), y, n), np.maximum(of_law, of_branch), rtol=1e-12)


def test_a_program_has_the_stresses_and_shares_of_a_film_that_creeps_and_of_one_that_is_short():
    """The elastic film's share of the limit is that without voltage, also where it is longer than its gap."""
    film, n, x, squared, y = creeping()
    state, share = film.state(x, np.sqrt(squared), y, n), film.limit_share(x, np.sqrt(squared), y, n)
    signs = film.switches(x, squared, y, n)
    for held, narrow in np.ndindex(2, 2):
        own = {"meridian_held": 1.0 - 2.0 * held, "width_held": 1.0 - 2.0 * narrow}
        here = np.all([signs[name] == sign for name, sign in own.items()], axis=0)
        at = x[here], squared[here], [value[here] for value in y]
        along, across, field, limit = in_program(film.traced_state, n, own, *at)
        np.testing.assert_allclose(along, state.meridional_stress[here], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(across, state.hoop_stress[here], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(field, state.true_field[here] ** 2, rtol=1e-7)
        np.testing.assert_allclose(limit, share[here], rtol=1e-7)
    plain = WrinklingCone()
    for lm, lh in ((0.6, 0.9), (0.6, 1.2), (1.1, 0.8), (1.1, 1.2)):
        n, x = numbers(plain, meridional_prestretch=lm, hoop_prestretch=lh), np.linspace(0.05, 1.3, 12)
        signs = plain.switches(x, 0.1, [], n)
        for k, place in enumerate(x):
            own = {name: float(np.broadcast_to(value, x.shape)[k]) for name, value in signs.items()}
            found = in_program(plain.traced_state, n, own, np.array([place]), np.array([0.1]), [])
            np.testing.assert_allclose(found[3], plain.limit_share(place, 0.0, [], n), rtol=1e-9)


def test_where_and_how_a_film_that_creeps_ends_is_said_by_its_own_states():
    film, n, x, _, y = creeping()
    np.testing.assert_array_equal(film.shortest_lengths(x, n)[0], 1.0 + x * x)
    assert film.shortest_lengths(x, n)[1] == 1.0
    held = film.highest_squared_held(x, y, n)
    np.testing.assert_array_equal(held, film.creeping.highest_squared(x, y, n))
    assert (np.abs(held - film.highest_squared(x, n)) > 1e-3).all()
    for meridian in (1.0, -1.0):
        for width in (1.0, -1.0):
            kind = film.pull_in_kind({"meridian_held": meridian, "width_held": width})
            assert kind == (FilmPullIn.LOCALISATION if meridian > 0.0 else FilmPullIn.MINIMUM)
    for pull_in in ("memoryless", "snap"):
        with pytest.raises(InputError, match=f"pull_in = {pull_in}: a film with branches ends there"):
            WrinklingCone(branches=1, pull_in=pull_in)


def test_a_voltage_gives_a_flat_film_no_energy_while_it_is_taut():
    film = WrinklingCone()
    n = numbers(film, meridional_prestretch=1.2, hoop_prestretch=1.3)
    assert float(film.work(0.0, 0.5, [], n)) == float(film.work(0.0, 0.0, [], n))
    h, x, squared = 1e-5, np.array([0.0, 0.4, 0.9]), 0.3
    change = (film.work(x, squared - h, [], n) - film.work(x, squared + h, [], n)) / h
    np.testing.assert_allclose(film.capacitance(x, squared, [], n), 1.0 + change, rtol=1e-7)


@pytest.mark.parametrize(("pull_in", "gone"), [("first", -1), ("minimum", -1), ("memoryless", 4), ("snap", 4)])
def test_the_kind_of_a_film_is_that_of_its_lengths_and_of_one_that_has_failed_its_own(pull_in, gone):
    """In the order taut, hoop slack, meridional slack, crumpled; a charge is known unless a run continues."""
    film, n, x, random = drawn(50.0, pull_in)
    squared = random.uniform(0.0, 1.2, x.size) * np.minimum(film.highest_squared(x, n), 3.0)
    kind, (m, width) = film.state(x, np.sqrt(squared), [], n).kind, film.lengths(x, squared, n)
    longer, wider = m > (1.0 + x * x) * (1.0 + 1e-9), width > 1.0 + 1e-9
    np.testing.assert_array_equal(kind, np.where(np.isnan(m), gone, np.where(longer, 2, 0) + np.where(wider, 1, 0)))
    assert all((kind == place).any() for place in (0, 1, 2, 3, gone))
    assert film.kinds == ("taut", "hoop_slack", "meridional_slack", "crumpled", "pulled_in")[: 4 + (gone == 4)]
    assert film.traced_charge == (gone == -1)


def test_the_energy_of_a_film_that_creeps_has_the_force_as_its_slope():
    film, n, x, squared, y = creeping()
    h = 1e-5
    ahead, own, behind = (film.work(x + d, squared, y, n) for d in (h, 0.0, -h))
    smooth = np.abs(ahead - 2.0 * own + behind) < 1e-8
    assert smooth.sum() > 30
    np.testing.assert_allclose(film.force(x, squared, y, n)[0][smooth], ((ahead - behind) / (2 * h))[smooth], atol=1e-5)


def test_a_film_says_what_happens_where_it_pulls_in_and_how_it_creeps():
    words = {pull_in: WrinklingCone(pull_in=pull_in).describe() for pull_in in ("first", "minimum", "snap")}
    assert words["first"].endswith("pulls in at a higher voltage than the membrane that it stands for")
    assert words["minimum"] == words["first"] + "; its localisation is left out (study)"
    assert "until it snaps back (study)" in words["snap"]
    assert WrinklingCone(branches=1).describe() == words["first"] + "; it creeps: 1 Maxwell branch, logarithmic flow"


@pytest.mark.parametrize("pull_in", ["first", "snap"])
def test_the_voltage_gain_is_the_derivative_of_the_force_in_every_state(pull_in):
    """Taut, hoop-slack, slack, and where it has pulled in."""
    film = WrinklingCone(pull_in=pull_in)
    n = ConeModel(film=film, meridional_prestretch=1.3, hoop_prestretch=1.1).numbers()
    x, squared = np.linspace(-2.0, 2.0, 41)[:, None], np.linspace(0.0, 1.5, 16)
    found = film.voltage_gain(x, squared, n)
    assert set(film.state(x, np.sqrt(squared), [], n).kind.ravel()) >= {0, 1}
    np.testing.assert_allclose(found, Film.voltage_gain(film, x, squared, n), rtol=1e-12, atol=1e-13)
