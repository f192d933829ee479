"""The film at once: forces and thresholds as certified, and the limits of its branches."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone import ConeModel
from gelcone.motion.static_bifurcations import jump_voltages
from gelcone.physics.film.at_once import FilmAtOnce, films_at_once
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.statics import rest_displacement

CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "viscous.json").read_text())


def model_of(case, film=WrinklingCone, **more):
    """The model of a case of statics or delays, with a spring that pulls nowhere at x = 0."""
    own = {
        f"{name}_{k}": float(branch[key])
        for k, branch in enumerate(case["branches"], 1)
        for name, key in (("viscous_modulus", "g"), ("viscous_limit", "J"))
    }
    lm, lh = case.get("lm", case.get("prestretch")), case.get("lh", case.get("prestretch"))
    return ConeModel(
        film=film(branches=len(case["branches"])),
        meridional_prestretch=float(lm),
        hoop_prestretch=float(lh),
        stretch_limit=float(case["J"]),
        rest_height=0.0,
        **own,
        **more,
    )


@pytest.mark.parametrize("case", CERTIFIED["statics"], ids=lambda case: f"x {case['x']} v {case['v']}")
def test_forces_at_once_are_certified(case):
    held = films_at_once(model_of(case, spring_stiffness=0.0))
    force, slope = held.system.static_force(np.array([case["x"]]), np.array([case["v"] ** 2]), held.numbers())
    assert force[0] == pytest.approx(float(case["at_once"]["force"]), rel=1e-12)
    more = held.system.static_force(np.array([case["x"] + 1e-6]), np.array([case["v"] ** 2]), held.numbers())[0]
    less = held.system.static_force(np.array([case["x"] - 1e-6]), np.array([case["v"] ** 2]), held.numbers())[0]
    assert slope[0] == pytest.approx((more - less)[0] / 2e-6, rel=1e-6)


@pytest.mark.parametrize("number", [0, 5, 7])
def test_thresholds_at_once_are_certified(number):
    case = CERTIFIED["delays"][number]
    known = case["thresholds"]
    voltages = [jump_voltages(ensemble)[0][0] for ensemble in (model_of(case), films_at_once(model_of(case)))]
    np.testing.assert_allclose(voltages, [float(known["long_term"]), float(known["instantaneous"])], rtol=1e-10)


def test_a_film_at_once_pulls_in_where_the_run_does():
    """Hoop-slack films of which the disc is held at a place localise where the force at fixed states says."""
    held = films_at_once(model_of(CERTIFIED["delays"][0]))
    n, film = held.numbers_at(0), held.system.film
    for x in (0.4, 1.0, 1.6):
        squared = float(film.highest_squared(np.float64(x), n))
        ends = [border.value for border in film.film.borders if border.switch is None]
        own = {**n, **film.switches(np.array([x]), np.array([squared]), [], n)}
        before, after = (
            np.min([value(np.array([x]), np.array([share * squared]), film.held(own), own, np) for value in ends])
            for share in (1.0 - 1e-6, 1.0 + 1e-6)
        )
        assert before > 0.0
        assert not after > 0.0


def test_a_taut_film_reaches_as_far_as_its_branches_allow():
    case = {"branches": [{"g": 0.5, "J": 4.0}], "lm": 1.0, "lh": 1.0, "J": 50.0}
    held = films_at_once(model_of(case, TautCone))
    end = held.system.film.reach(held.numbers_at(0))[1]
    q = 1.0 + end * end
    assert q + 1.0 + 1.0 / q - 3.0 == pytest.approx(4.0, rel=1e-9)


def test_an_elastic_film_is_its_own():
    model = ConeModel(prestretch=1.2)
    assert films_at_once(model) is model.members()


@pytest.mark.parametrize("limit", [7.0, 8.0, 50.0])
def test_a_film_whose_next_minimum_is_near_pulls_in_where_the_first_ends(limit):
    """The voltage of a flat, equally stretched film over its stretch t: its first maximum, on a fine grid. Behind it a
    film with a low stretch limit has another minimum, at half as much again, which the voltage does not lead to."""
    model = ConeModel(film="wrinkling", stretch_limit=limit, viscous_modulus_1=0.2, relaxation_time_1=5.0)
    held = films_at_once(model)
    t = np.linspace(1.0, 2.6, 400_001)
    response = limit / (limit - (2.0 * t + t**-2 - 3.0))
    squared = (response + 0.2) * (t - t**-2) / t**2
    first = squared[np.argmax(np.diff(squared) < 0.0)]
    found = held.system.films[0].highest_squared(np.array([0.0]), held.numbers())
    np.testing.assert_allclose(found, first, rtol=1e-10)


def test_branches_are_held_as_they_are_where_a_run_starts_from_rest():
    """Those that have rested where the disc is raised to: at their own lengths there they carry nothing."""
    given = {"viscous_modulus_1": 0.8, "relaxation_time_1": 5.0, "rest_height": 0.7, "spring_stiffness": 0.9}
    model = ConeModel(film=TautCone(branches=1, rested="raised"), hoop_prestretch=1.1, **given)
    rest = float(rest_displacement(model))
    assert rest > 0.2
    held = films_at_once(model)
    for name, value in (("meridional", 1.0 / (1.0 + rest * rest)), ("hoop", 1.0)):
        assert float(held.values[f"held_viscous_{name}_1"][0]) == pytest.approx(value, rel=1e-12)
    own = films_at_once(model, np.array([[0.3, 0.0, 0.8, 0.9]]))
    assert [float(own.values[f"held_viscous_{name}_1"][0]) for name in ("meridional", "hoop")] == [0.8, 0.9]
    x, squared, n = np.array([0.5]), np.array([0.2]), own.numbers()
    film = own.system.films[0].film
    exact = model.film.force(x, squared, [np.array([0.8]), np.array([0.9])], n)
    np.testing.assert_allclose(film.force(x, squared, [], n), exact, rtol=1e-14)


@pytest.mark.parametrize(("law", "branch"), [(4.0, 50.0), (4.0, np.inf), (np.inf, 3.0), (np.inf, np.inf)])
def test_a_film_reaches_as_far_as_the_lower_of_its_limits(law, branch):
    """q + 1/q - 2 at the limit of law or branch, of a film that is not pre-stretched."""
    case = {"branches": [{"g": 0.5, "J": branch}], "lm": 1.0, "lh": 1.0, "J": law}
    held = films_at_once(model_of(case, TautCone))
    begin, end = held.system.film.reach(held.numbers_at(0))
    assert begin == 0.0
    lowest = min(law, branch)
    if np.isinf(lowest):
        assert end == np.inf
    else:
        q = 1.0 + end * end
        assert q + 1.0 / q - 2.0 == pytest.approx(lowest, rel=1e-9)


def test_what_is_asked_of_a_film_at_once_is_that_of_the_film_at_its_held_states():
    model = ConeModel(film="wrinkling", hoop_prestretch=1.1, viscous_modulus_1=0.8, relaxation_time_1=5.0)
    model = model.replace(viscous_limit_1=3.0)
    y = [0.7, 0.9]
    held = films_at_once(model, np.array([[0.3, 0.0, *y]]))
    film, n = held.system.film, held.numbers_at(0)
    own = film.film
    x, squared = np.array([0.4, 0.9]), np.array([0.2, 0.4])
    for name in ("work", "capacitance"):
        found = getattr(film, name)(x, squared, [], n)
        np.testing.assert_allclose(found, getattr(own, name)(x, squared, y, n), rtol=1e-14)
        assert (np.abs(found - getattr(own, name)(x, squared, [], n)) > 1e-4).any()
    share = film.limit_share(x, np.sqrt(squared), [], n)
    np.testing.assert_allclose(share, own.limit_share(x, np.sqrt(squared), y, n), rtol=1e-14)
    assert (np.abs(share - own.limit_share(x, np.sqrt(squared), [], n)) > 1e-3).any()
    assert (film.linear_charge, films_at_once(model.replace(film="taut")).system.film.linear_charge) == (False, True)
    assert film.kinds == own.kinds
    for name, sign in film.switches(x, squared, [], n).items():
        np.testing.assert_array_equal(sign, own.switches(x, squared, y, n)[name])
    state, right = film.state(x, np.sqrt(squared), [], n), own.state(x, np.sqrt(squared), y, n)
    np.testing.assert_allclose(state, right, rtol=1e-14)
    assert (np.abs(state.meridional_stress - own.state(x, np.sqrt(squared), [], n).meridional_stress) > 1e-3).any()


def test_no_voltage_makes_a_film_at_once_push_and_one_that_has_pulled_in_turns_nothing():
    held = films_at_once(model_of(CERTIFIED["delays"][0]))
    n, film = held.numbers_at(0), held.system.film
    x = np.array([0.4, 1.0])
    at_rest = film.balancing(x, 0.0, n)
    for pull in (-1e-3, -0.5):
        np.testing.assert_allclose(film.balancing(x, pull, n), at_rest - 1e10 * pull, rtol=1e-9)
    highest = film.highest_squared(x, n)
    gone = 5.0 * highest
    assert np.isnan(film.force(x, gone, [], n)[0]).all()
    np.testing.assert_array_equal(film.turning(x, gone, n), [0.0, 0.0])
    assert (np.abs(film.turning(x, 0.9 * highest, n)) > 1e-3).any()


def test_each_film_of_a_pair_is_held_at_its_own_states():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.6, viscous_modulus_1=0.8, relaxation_time_1=5.0
    )
    names = [state.name for state in pair.system.states]
    held = films_at_once(pair, np.array([[0.3, 0.0, 0.7, 0.8, 1.1, 1.2]]))
    for name, value in zip(names[2:], (0.7, 0.8, 1.1, 1.2), strict=True):
        key = f"second_held_{name.removeprefix('second_')}" if name.startswith("second_") else f"held_{name}"
        assert held.values[key].tolist() == [value]
    n, x = held.numbers_at(0), 0.2
    for film, own, y in zip(held.system.films, pair.system.films, ([0.7, 0.8], [1.1, 1.2]), strict=True):
        assert film.force(x, 0.3, [], n) == pytest.approx(own.force(x, 0.3, y, n), rel=1e-14)


def test_a_film_at_once_that_is_too_wide_while_flat_begins_where_its_film_does():
    wide = {"prestretch": 0.5, "prestretch_mode": "equibiaxial", "stretch_limit": 8.0}
    model = ConeModel(**wide, viscous_modulus_1=0.5, relaxation_time_1=3.0)
    film, n = (held := films_at_once(model)).system.film, held.numbers_at(0)
    begin, end = film.reach(n)
    assert (begin, end) == model.film.reach(model.own_numbers)
    assert begin > 0.5
    near = films_at_once(model.replace(viscous_limit_1=1.0))
    assert near.system.film.reach(near.numbers_at(0))[0] == begin


class Lopsided(TautCone):
    """A film that is not odd in x, and says where a start is."""

    def odd(self, n):
        return False

    def outside(self, x, n):
        return f"start {x:g}"

    def unreachable(self, n):
        return "nowhere"


def test_what_branches_do_not_change_is_that_of_the_film():
    film, x = FilmAtOnce(Lopsided(branches=1)), np.array([0.3, 0.8])
    n = film.numbers(film.complete({"hoop_prestretch": 1.2}))
    assert (film.odd(n), FilmAtOnce(TautCone(branches=1)).odd(n)) == (False, True)
    assert (film.outside(-2.0, n), film.unreachable(n)) == ("start -2", "nowhere")
    np.testing.assert_array_equal(film.strain(x, n), film.film.strain(x, n))
    assert film.strain_limit(n) == film.film.strain_limit(n)
    assert film.stiffness_scale(n) == film.film.stiffness_scale(n) == 1.0 + 0.5
    assert film.held(n) == [1.0, 1.0]
