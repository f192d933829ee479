"""The wrinkling film: where it pulls in, and laws of a user's own."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.motion.equilibrium import stroke_and_blocked_force
from gelcone.motion.flow import integrate
from gelcone.physics.film import elastic
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
    m, width = film.resting_lengths(x, n)
    exact = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
    np.testing.assert_allclose(film.strain(x, n), exact, atol=1e-9)
    kinds = 2 * (m > (1.0 + x * x) * (1.0 + 1e-9)) + (width > 1.0 + 1e-9)
    assert np.bincount(kinds, minlength=4).min() > 5
