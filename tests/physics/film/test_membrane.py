"""The membrane as a film: against certified states, its own differences, and the engine against SciPy."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone import ConeModel, InputError
from gelcone.codes import FilmPullIn, Outcome
from gelcone.motion.flow import integrate
from gelcone.physics.film.membrane import MembraneFilm

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "membrane.json").read_text())
MADE = [(0.2, 1), (0.2, 1.5)]
"""Ratio and equibiaxial pre-stretch of films with certified states, of one stretch limit."""


def film_of(ratio, prestretch):
    film = MembraneFilm(prestretch_mode="equibiaxial")
    own = {"radius_ratio": ratio, "prestretch": prestretch, "stretch_limit": 50.0}
    return film, film.numbers(film.complete(own))


def rows(kind):
    return [
        r
        for r in REFERENCE[kind]
        if (r["radius_ratio"], r["meridional_prestretch"]) in MADE
        and r["hoop_prestretch"] == r["meridional_prestretch"]
        and r["x"] < 1.1
    ]


@pytest.mark.parametrize("row", rows("states"), ids=lambda r: f"{r['meridional_prestretch']}-{r['x']}-{r['v']}")
def test_forces_are_certified_ones_within_the_stated_error(row):
    film, n = film_of(row["radius_ratio"], row["meridional_prestretch"])
    force = film.force(row["x"], row["v"] ** 2, [], n)[0]
    without = film.force(row["x"], 0.0, [], n)[0]
    assert abs(force - row["force"]) < n["film_error"] * (row["force"] + 0.02 * without)
    assert n["film_error"] < 0.15
    if row["meridional_prestretch"] > 1:
        assert force == pytest.approx(row["force"], rel=2e-3)


@pytest.mark.parametrize("row", rows("pull_in"), ids=lambda r: f"{r['meridional_prestretch']}-{r['v']}")
def test_heights_of_pull_in_are_certified_ones(row):
    """Below its height a film rests in tension, above it has pulled in."""
    film, n = film_of(row["radius_ratio"], row["meridional_prestretch"])
    below, above = film.force(np.array([0.985, 1.015]) * row["x"], row["v"] ** 2, [], n)[0]
    assert below > 0.0
    assert np.isnan(above)


def test_the_border_bends_back():
    """lp 1, J 50: at x 0.69 the film pulls in at V 0.35; at x 0.675 and V 0.455, reached while slack, it holds."""
    film, n = film_of(0.2, 1)
    assert film.highest_squared(0.69, n) == pytest.approx(0.35, abs=0.02)
    assert film.force(0.675, 0.455, [], n)[0] > 0.0


@pytest.mark.parametrize(("prestretch", "x", "squared"), [(1, 0.5, 0.2), (1, 0.5, 0.33), (1.5, 0.25, 1.0)])
def test_slopes_are_those_of_the_force(prestretch, x, squared):
    film, n = film_of(0.2, prestretch)
    step = 1e-5
    force, slope = film.force(np.array([x - step, x, x + step]), squared, [], n)
    assert slope[1] == pytest.approx((force[2] - force[0]) / (2.0 * step), rel=1e-6)
    sides = film.force(x, squared + np.array([-step, step]), [], n)[0]
    assert film.voltage_gain(x, squared, n) == pytest.approx((sides[0] - sides[1]) / (2.0 * step), rel=1e-6)


def test_force_vanishes_where_the_cone_falls_slack():
    """With equal pre-stretches both fall slack at one border, V G = Vb(A q)."""
    film, n = film_of(0.2, 1)
    border = float(film._cone.balancing(0.5, 0.0, n))
    assert film.force(0.5, border * (1.0 + 1e-9), [], n)[0] == 0.0
    assert 0.0 < film.force(0.5, border * (1.0 - 1e-6), [], n)[0] < 1e-6


def test_charge_and_work_come_from_one_energy():
    film, n = film_of(0.2, 1.5)
    x, squared, step = 0.3, 0.8, 1e-4
    work = film.work(np.array([x - step, x + step]), squared, [], n)
    assert film.force(x, squared, [], n)[0] == pytest.approx((work[1] - work[0]) / (2.0 * step), rel=1e-6)
    work = [film.work(np.array([x]), squared + side * step, [], n)[0] for side in (-1, 1)]
    charge = film.capacitance(np.array([x]), squared, [], n)[0]
    assert charge - 1.0 == pytest.approx(-(work[1] - work[0]) / step, rel=1e-5)


@pytest.mark.parametrize(
    "parameters",
    [
        {"prestretch": 1.5, "prestretch_mode": "equibiaxial", "voltage": 0.4, "voltage_bias": 0.3, "rest_height": 0.3},
        {"prestretch": 1.0, "voltage": 0.45, "voltage_bias": 0.1, "rest_height": 0.6},
    ],
    ids=["taut", "across the borders"],
)
def test_motions_are_those_of_scipy(parameters):
    """The first stays taut; the second wrinkles at the rim and beside the disc in every period."""
    model = ConeModel(film="membrane", drive_frequency=1.3, damping_ratio=0.1, spring_stiffness=1.5, **parameters)
    film, n = model.film, {name: float(value) for name, value in model.numbers().items()}
    end = 2.0 * 2.0 * np.pi / 1.3

    def rates(t, z):
        voltage = n["voltage_bias"] + n["voltage"] * np.sin(n["drive_frequency"] * t)
        force = film.force(z[0], voltage**2, [], n)[0]
        return [z[1], -0.2 * z[1] - force - 1.5 * (z[0] - n["rest_height"])]

    own = integrate(model, np.array([0.3, 0.0]), np.array([0.0, end]), threads=1)
    assert own.outcome[0] == 0
    other = solve_ivp(rates, (0.0, end), [0.3, 0.0], rtol=1e-7, atol=1e-9, max_step=0.2).y[:, -1]
    assert own.states[0, -1] == pytest.approx(other, abs=2e-5)


def test_a_rising_voltage_ends_the_run_in_localisation():
    model = ConeModel(film="membrane", prestretch=1.5, prestretch_mode="equibiaxial", voltage=1.6, rest_height=0.4)
    own = integrate(model, np.array([0.3, 0.0]), np.array([0.0, 20.0]), threads=1)
    assert Outcome(own.outcome[0]) == Outcome.PULLED_IN
    assert FilmPullIn(own.pull_in[0]) == FilmPullIn.LOCALISATION


def test_films_that_are_not_computed_say_so():
    with pytest.raises(InputError, match="equal meridional and hoop"):
        ConeModel(film="membrane", prestretch=1.3).numbers()
    with pytest.raises(InputError, match="must be below 1"):
        ConeModel(film="membrane", radius_ratio=1.2).numbers()
    with pytest.raises(InputError, match="pull_in = snap"):
        ConeModel(film="membrane", pull_in="snap")
