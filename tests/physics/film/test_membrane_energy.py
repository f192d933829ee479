"""The energy of the membrane: force and charge are its slopes, and it has no steps."""

import numpy as np
import pytest

from gelcone import ConeModel
from gelcone.membrane.columns import columns
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.motion.response import simulate
from gelcone.physics.film import membrane_energy
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.membrane_energy import energy_and_area
from tests.physics.film.membranes import MADE, film_of

RAISED = ConeModel(
    film="membrane", prestretch=1.5, prestretch_mode="equibiaxial", damping_ratio=0.01, spring_stiffness=0.9,
    rest_height=0.5, voltage=0.6, drive_frequency=0.1,
)  # fmt: skip
PLACES = [(0.5, 0.1), (0.5, 0.36), (0.62, 0.3), (0.03, 5e-4), (0.9, 0.1), (1.4, 0.08), (-0.4, 0.1)]


@pytest.mark.parametrize(("x", "V"), PLACES)
@pytest.mark.parametrize("prestretch", [(1, 1), (1.5, 1.5), (1, 1.5)])
def test_force_and_charge_are_slopes_of_one_energy(x, V, prestretch):
    film, n = film_of(0.2, *prestretch)
    step = 1e-4 * abs(x)
    by_x = (film.work(x + step, V, [], n) - film.work(x - step, V, [], n)) / (2.0 * step)
    assert by_x == pytest.approx(film.force(x, V, [], n)[0], rel=1e-6)
    change = 1e-4 * V
    by_v = (film.work(x, V + change, [], n) - film.work(x, V - change, [], n)) / (2.0 * change)
    assert 1.0 - 2.0 * by_v == pytest.approx(film.capacitance(x, V, [], n), rel=1e-6)
    gain = (film.force(x, V - change, [], n)[0] - film.force(x, V + change, [], n)[0]) / (2.0 * change)
    assert film.voltage_gain(x, V, n) == pytest.approx(gain, rel=1e-5)
    slope = (film.force(x + step, V, [], n)[0] - film.force(x - step, V, [], n)[0]) / (2.0 * step)
    assert film.force(x, V, [], n)[1] == pytest.approx(slope, rel=1e-4)


@pytest.mark.parametrize(("hoop", "V", "kinks"), [(1.5, 0.0, 0), (1.0, 0.05, 2), (1.5, 0.36, 1)])
def test_a_kink_is_searched_only_where_a_hoop_falls_slack(hoop, V, kinks, monkeypatch):
    """Two hoops fall slack in two pieces at most; and the height at which the film begins to pull is searched."""
    searched, halved = [], membrane_energy.halved
    monkeypatch.setattr(membrane_energy, "halved", lambda *search: searched.append(search) or halved(*search))
    film, n = film_of(0.2, 1.0, hoop)
    film.work(np.array([0.5, 0.9]), np.full(2, V), [], n)
    assert len(searched) == 1 + kinks


def test_the_energy_is_that_of_the_film_alone_where_no_ring_moves():
    """Of an even film that is flat the field's energy is V/2, whatever the voltage: its own stays 0."""
    film, n = film_of(0.2, 1.5, 1.5)
    V = np.array([0.0, 0.3, 0.9])
    np.testing.assert_allclose(film.work(np.zeros(3), V, [], n), 0.0, atol=1e-15)
    run = simulate(RAISED, initial=(0.3, 0.0), periods=3)
    first = run.isel(time=0)
    held = film_of(0.2, 1.5, 1.5)[0].work(0.3, 0.0, [], n)
    assert float(first["film_energy"] + first["field_energy"]) == pytest.approx(held, rel=1e-12)


def test_the_energy_of_a_flat_film_has_no_step_where_the_voltage_takes_its_tension():
    """With the numbers of a film that keeps it up to V = 0.2."""
    film, n = film_of(*MADE[0])
    own, V = {**n, "flat_voltage": 0.2}, np.array([0.2 - 1e-7, 0.2, 0.2 + 1e-7, 0.3])
    work = film.work(np.zeros(4), V, [], own)
    np.testing.assert_allclose(work[:3], work[0], atol=1e-6)
    slack = film.work(0.0, np.array([0.2, 0.3]), [], n)
    assert work[3] - work[1] == pytest.approx(slack[1] - slack[0], rel=1e-9)
    assert abs(slack[0]) > 1e-3


@pytest.mark.parametrize(
    ("meridional", "hoop", "limit", "x"),
    [
        (0.94, 0.94, np.inf, 0.6),  # compressed: slack at low heights without voltage, too
        (2.9, 3.1, 70.0, 0.08),  # with rims: in tension above the voltage up to which the flat film is
    ],
)
def test_the_charge_is_that_of_states_where_the_flat_film_is_without_tension(meridional, hoop, limit, x):
    film = MembraneFilm(prestretch_mode="radial")
    own = {"meridional_prestretch": meridional, "hoop_prestretch": hoop, "radius_ratio": 0.1, "stretch_limit": limit}
    n = film.numbers(film.complete(own))
    V = 1.05 * n["flat_voltage"]
    states = columns(Elements(Gel(film.law, n, n["A"], n["B"]), 0.1, 160), *np.array([[x], [V + 1e-3], [V]]))
    assert states.V[-1] == pytest.approx(V, rel=1e-9)
    assert float(film.capacitance(x, V, [], n)) == pytest.approx(states.measures.area[-1], rel=3e-3)


@pytest.mark.parametrize("made", MADE)
def test_the_energy_is_the_integral_of_the_force_from_the_flat_film(made):
    """By the trapezoidal rule, over heights at which the film is slack, partly wrinkled and taut."""
    film, n = film_of(*made)
    x, V = np.linspace(0.0, 0.9, 9001), np.full(9001, 0.1)
    energy, _ = energy_and_area(film.law, x**2, V, n)
    force = film.force(x, V, [], n)[0]
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))])
    np.testing.assert_allclose(energy - energy[0], work, atol=1e-7)
    assert work[-1] > 0.05
