"""The film as a continuum that wrinkles: its derivatives, borders and energies, where it ends, and files."""

import dataclasses
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome
from gelcone.analyses.ask import arguments_of
from gelcone.analyses.request import Subject
from gelcone.codes import FilmPullIn
from gelcone.errors import DoubtfulInput
from gelcone.motion.lyapunov import finite_exponents
from gelcone.physics.balance import PullIn
from gelcone.physics.film.stored import film_from_json, read_film
from gelcone.register.analyses import ANALYSES

BASE = ConeModel(spring_stiffness=0.9, damping_ratio=0.05, drive_frequency=0.3, voltage=0.4)


@cache
def film():
    return read_film(Path(__file__).parents[2] / "reference" / "continuum-film.json")


def numbers():
    return film().numbers(film().complete({}))


def force(x, squared):
    return film().force(x, squared, [], numbers())


@pytest.mark.parametrize("squared", [0.0, 0.01, 0.09, 0.3])
def test_derivatives_and_energies_are_those_of_the_force(squared):
    x, h = np.linspace(0.05, 3.8, 60), 1e-6
    pull, slope = force(x, squared)
    inside = np.isfinite(force(x + 1e-3, squared)[0]) & (force(x - 1e-3, squared)[0] > 0.0)
    assert inside.sum() > 2
    x, pull, slope = x[inside], pull[inside], slope[inside]
    np.testing.assert_allclose(slope, (force(x + h, squared)[0] - force(x - h, squared)[0]) / (2 * h), rtol=1e-6)
    work, area = film().work, film().capacitance
    rise = (work(x + h, squared, [], numbers()) - work(x - h, squared, [], numbers())) / (2 * h)
    np.testing.assert_allclose(rise, pull, rtol=1e-4, atol=1e-6)
    up, down = squared + 1e-6, max(squared - 1e-6, 0.0)
    gain = -(force(x, up)[0] - force(x, down)[0]) / (up - down)
    np.testing.assert_allclose(film().voltage_gain(x, squared, numbers()), gain, rtol=2e-3, atol=1e-3)
    grown = (area(x + h, squared, [], numbers()) - area(x - h, squared, [], numbers())) / (2 * h)
    np.testing.assert_allclose(grown, 2.0 * gain, rtol=1e-2, atol=1e-4)


def test_a_film_that_hangs_loose_has_the_slope_and_the_work_of_its_force():
    """Its force turns with |x| near the flat film: rounded there, not cut."""
    loose, h = dataclasses.replace(film(), rounding=0.02), 1e-6
    x, squared = np.array([0.004, 0.02, 0.3, 1.1]), np.array([0.0, 0.0, 0.02, 0.1])
    low, high = (loose.force(x + d, squared, [], numbers())[0] for d in (-h, h))
    np.testing.assert_allclose(loose.force(x, squared, [], numbers())[1], (high - low) / (2 * h), rtol=1e-6)
    rise = (loose.work(x + h, squared, [], numbers()) - loose.work(x - h, squared, [], numbers())) / (2 * h)
    np.testing.assert_allclose(rise, loose.force(x, squared, [], numbers())[0], rtol=1e-4, atol=1e-7)
    assert loose.force(0.0, 0.0, [], numbers())[0] == 0.0


def test_the_force_ends_at_the_voltage_above_which_the_film_is_slack():
    """Whatever the polynomials do there, and without a jump."""
    strong = dataclasses.replace(film(), stiffness=((1.0,),))
    x = np.array([0.2, 0.4])
    t, most = (s / (s + strong.variable) for s in (x**2, strong.reach_squared))
    highest = t * np.polynomial.chebyshev.chebval(2.0 * t / most - 1.0, strong.slack_above)
    pulls = [strong.force(x, share * highest, [], numbers())[0] for share in (0.5, 1.0 - 1e-9, 1.01)]
    assert (pulls[0] > 1e-3).all()
    np.testing.assert_allclose(pulls[1], 0.0, atol=1e-7)
    np.testing.assert_array_equal(pulls[2], 0.0)


def test_it_never_pushes_and_the_voltage_only_weakens_it():
    x, squared = np.linspace(0.0, 3.9, 80), np.linspace(0.0, 0.5, 101)[:, None]
    pull = force(x, squared)[0]
    assert np.nanmin(pull) >= 0.0
    # without voltage the fit may rise by less than its error
    assert np.nanmax(np.diff(pull, axis=0) / (0.01 + pull[:-1])) < 5e-3
    np.testing.assert_array_equal(np.isnan(pull), squared > film().highest_squared(x, numbers()) + 0.0 * squared)


def test_the_force_of_numbers_is_that_of_programs():
    """`pull` has the same law in fewer operations, for statics."""
    s, squared = np.linspace(0.001, 15.0, 40), np.linspace(0.0, 0.5, 21)[:, None]
    k, _, _ = film().rate(s, squared)
    tense = film().pull(s, squared) > 0.0
    assert 0.1 < tense.mean() < 0.9
    np.testing.assert_allclose(film().pull(s, squared)[tense], k[tense], rtol=1e-9)


def test_small_heights_keep_the_law_of_their_scale():
    """k(s, V) = s f(V/s): without pre-stretch nothing else sets a scale."""
    pulls = [force(np.sqrt(s), 0.7 * s)[0] / s**1.5 for s in (1e-4, 1e-6, 1e-8)]
    np.testing.assert_allclose(pulls, pulls[0], rtol=3e-3)
    assert force(0.0, 0.0)[0] == 0.0
    assert force(0.1, 0.03)[0] == 0.0 < force(0.1, 0.028)[0]


def test_the_voltage_that_balances_a_pull_is_found():
    x, squared = np.array([0.3, 0.8, 1.5]), np.array([0.1, 0.15, 0.05])
    pull = force(x, squared)[0] / x
    np.testing.assert_allclose(film().balancing(x, pull, numbers()), squared, rtol=1e-9)
    assert (film().balancing(x, -0.1, numbers()) > 1e6).all()


def test_a_force_that_is_poorly_fitted_is_doubted():
    assert film().doubt() == ""
    poor = dataclasses.replace(film(), errors=(("force", 0.07), ("pull-in voltage", 0.01)))
    assert "wrong by up to 7%" in poor.doubt()
    with pytest.warns(DoubtfulInput, match="take the wrinkling cone"):
        arguments_of(ANALYSES["simulate"], Subject(BASE.replace(film=poor), initial=(0.1, 0.0)), {"periods": 2})


def test_a_trajectory_is_slack_most_of_the_time_or_ends_where_it_pulls_in():
    model = BASE.replace(film=film(), voltage=[0.4, 0.6, 0.72])
    run = gelcone.simulate(model, (1.0, 0.0), times=np.linspace(0.0, 60.0, 601))
    assert run["outcome"].values.tolist() == [Outcome.OK, Outcome.PULLED_IN, Outcome.PULLED_IN]
    assert run["pull_in_kind"].values[1] == FilmPullIn.LOCALISATION
    x, v = (run[f"pull_in_{name}"].values[1] for name in ("displacement", "voltage"))
    assert v**2 == pytest.approx(film().highest_squared(x, numbers()), rel=1e-6)
    shares = run["film_state_slack"].values[0], run["film_state_in_tension"].values[0]
    assert sum(shares) == pytest.approx(1.0, abs=1e-12)
    assert 0.3 < shares[0] < 0.9


def test_a_slack_film_pulls_in_where_it_would_thin_without_end():
    model = BASE.replace(film=film(), voltage=[0.68, 0.7])
    run = gelcone.simulate(model, (0.02, 0.0), periods=2)
    assert run["outcome"].values.tolist() == [Outcome.OK, Outcome.PULLED_IN]
    assert run["pull_in_kind"].values[1] == FilmPullIn.MINIMUM
    assert run["pull_in_voltage"].values[1] == pytest.approx(0.691433, abs=1e-6)


def test_motions_across_borders_keep_their_energy():
    model = BASE.replace(film=film(), voltage=0.0, voltage_bias=0.2, damping_ratio=0.0, rest_height=0.3)
    run = gelcone.simulate(model, (0.9, 0.0), times=np.linspace(0.0, 100.0, 201))
    assert float(abs(run["energy_residual"]).max()) < 1e-6
    assert 0.02 < float(run["film_state_slack"]) < 0.9


def test_flat_rest_stays_rest_and_has_no_pitchfork():
    model = BASE.replace(film=film())
    assert float(abs(gelcone.simulate(model, (0.0, 0.0), periods=5)["displacement"]).max()) == 0.0
    assert np.isnan(gelcone.pitchfork_voltage(model))


def test_a_ramp_ends_where_the_film_pulls_in():
    ramp = gelcone.pull_in_voltage(BASE.replace(film=film(), rest_height=1.2))
    assert int(ramp["pull_in_kind"]) == PullIn.FILM
    x, v = float(ramp["pull_in_from"]), float(ramp["pull_in_voltage"])
    assert 0.7 < x < 1.2
    assert v**2 == pytest.approx(film().highest_squared(x, numbers()), rel=1e-6)


def test_exponents_add_up_to_the_damping():
    members = BASE.replace(film=film(), rest_height=0.4).members()
    values, _ = finite_exponents(members, np.array([[1.0, 0.0]]), 60.0, {})
    assert values.sum() == pytest.approx(-0.1, abs=1e-6)


def test_the_state_is_that_of_the_ring_beside_the_disc():
    model = BASE.replace(film=film())
    tense, slack = (model.film_state(x, v) for x, v in ((1.0, 0.2), (0.1, 0.3)))
    assert (int(tense.kind), int(slack.kind)) == (0, 1)
    # beside the disc the meridian is stretched more than in the cone
    assert 1.8 < float(tense.meridional_stretch) < 2.4
    assert float(tense.meridional_stress) > 0.0
    assert float(slack.meridional_stress) == pytest.approx(0.0, abs=1e-9)
    assert int(model.film_state(1.0, 0.6).kind) == -1


def test_files(tmp_path):
    gelcone.write_film(film(), tmp_path / "film.json")
    assert read_film(tmp_path / "film.json") == film()
    values = json.loads(film().to_json())
    assert values["gelcone_film"] == 3
    damages = [{"stiffness": [[float("nan")]]}, {"reach": -1.0}, {"wall": 2.0}, {"gelcone_film": 99}]
    damages += [{"variable": 0.0}, {"rounding": -1.0}]
    for damage in damages:
        with pytest.raises(InputError, match="gelcone validate --fit"):
            film_from_json(json.dumps(values | damage))
    assert dataclasses.replace(film(), largest=1.0) != film()
    assert "largest error of the fit: force" in film().describe()
