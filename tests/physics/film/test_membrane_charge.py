"""The membrane's charge while a motion is computed: that of its energy, continuous, and in circuits."""

import numpy as np
import pytest

from gelcone import ConeModel, Outcome, simulate
from gelcone.membrane import force as formulas
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.profile import held
from gelcone.physics.differentiate import evaluated
from gelcone.physics.film import membrane_charge
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.membrane_charge import HEIGHTS, VOLTAGES
from gelcone.physics.trace import Graph
from tests.physics.test_circuit import VoltageBehindResistor

SWITCHES = ("pulls", "near", "rim_taut", "any_taut")
FILMS = {
    "unstretched": {},
    "equi-biaxial": {"prestretch": 1.3, "prestretch_mode": "equibiaxial"},
    "strong hoop": {"meridional_prestretch": 1.1, "hoop_prestretch": 1.4, "radius_ratio": 0.267},
    "mixed": {"meridional_prestretch": 1.3, "hoop_prestretch": 1.1, "radius_ratio": 0.3},
}


def film_of(name: str) -> tuple[MembraneFilm, dict[str, float]]:
    model = ConeModel(film="membrane", stretch_limit=50.0, **FILMS[name])
    return model.film, model.members().numbers_at(0)


def in_a_program(film, n, x, V):
    """The capacitance as programs compute it, at the switches of the place."""
    graph = Graph()
    place, squared = graph.state(0), graph.state(1)
    leaves = {name: graph.switch(name) for name in SWITCHES}
    node = graph.node(film.capacitance(place, squared, [], {**n, **leaves}, graph))
    known = {place.index: x, squared.index: V}
    return evaluated([node], known | {leaf.index: film.switches(x, V, [], n)[name] for name, leaf in leaves.items()})[0]


@pytest.mark.parametrize("name", FILMS)
def test_it_is_that_of_the_energy(name):
    film, n = film_of(name)
    x, share = np.meshgrid(np.linspace(0.03, 1.5, 25), np.linspace(0.0, 0.98, 13))
    with np.errstate(invalid="ignore"):
        V = share * np.minimum(film.highest_squared(x, n), 1.5)
    exact = film.capacitance(x, V, [], n)
    error = np.abs(in_a_program(film, n, x, V) - exact)
    assert np.max(error / (exact - 1.0 + 0.05)) < 8e-3  # largest next to localisation
    assert np.sqrt(np.mean(np.square(error / exact))) < 3e-4
    kinds = film.state(x, np.sqrt(V), [], n).kind
    assert set(np.unique(kinds)) >= ({0, 3} if name == "strong hoop" else {0, 1})


@pytest.mark.parametrize("name", FILMS)
def test_the_stated_error_covers_that_of_states_by_finite_elements(name):
    film, n = film_of(name)
    elements = Elements(Gel(film.law, n, n["A"], n["B"]), n["radius_ratio"])
    x, share = np.random.default_rng(7).uniform((0.02, 0.0), (0.98, 0.95), (24, 2)).T
    x = film.reach(n)[1] * x
    V = np.minimum(film.highest_squared(x, n), 1.5) * np.square(share)
    states = held(elements, x, V)
    error = np.abs(film.fitted_capacitance(x, V, [], n) / elements.measures(states).area - 1.0)[states.found]
    assert error.size > 12
    assert error.max() < n["capacitance_error"] < 0.1


@pytest.mark.parametrize("name", ["unstretched", "strong hoop"])
def test_the_fit_has_its_places_up_to_where_the_film_ends_and_weighs_the_border_to_the_slack_film(name):
    """In each piece: V from 0, where a film falls slack with ten times the weight."""
    n = film_of(name)[1]
    for piece in formulas.PIECES:
        if not abs(n[f"{piece}_scale"]) > 0.0:
            continue
        s, V, weight = (one.reshape(HEIGHTS, VOLTAGES) for one in membrane_charge._places(piece, n))
        assert (s == s[:, :1]).all()
        np.testing.assert_array_equal(V[:, 0], 0.0)
        assert (np.diff(V, axis=1) >= 0.0).all()
        ends = formulas.tension(s[:, 0], 0.0, n) if piece == "near" else formulas.pull_in(s[:, 0], n)
        np.testing.assert_allclose(V[:, -1], np.maximum(ends, 0.0), rtol=1e-8)
        assert (weight[:, :-1] == 1.0).all()
        assert (weight[:, -1] == (10.0 if piece == "near" else 1.0)).all()
        x = np.sqrt(s[:, 0])
        assert ((x >= 0.0) & (x <= np.sqrt(n["reach_squared"]))).all()


def test_a_slack_film_has_the_charge_of_its_even_stretch():
    film, n = film_of("unstretched")
    x, V = np.full(4, 0.2), np.array([0.15, 0.2, 0.3, 0.44])
    assert np.all(film.switches(x, V, [], n)["pulls"] < 0.0)
    np.testing.assert_allclose(in_a_program(film, n, x, V), film.capacitance(x, V, [], n), rtol=1e-9)


BEHIND = {
    "film": "membrane",
    "circuit": VoltageBehindResistor(),
    "series_resistance": 0.2,
    "stretch_limit": 50.0,
    "rest_height": 0.3,
    "spring_stiffness": 1.0,
    "damping_ratio": 0.1,
    "voltage": 0.4,
    "drive_frequency": 0.35,
}
TIMES = np.linspace(0.0, 40.0, 401)


@pytest.mark.usefixtures("undelivered")
def test_what_a_source_gives_is_stored_in_the_film_or_lost():
    """Through all states of the film; the balance closes as well as the charge is that of the energy."""
    run = simulate(ConeModel(**BEHIND), (0.6, 0.0), times=TIMES)
    assert int(run["outcome"]) == Outcome.OK
    assert all(run[f"film_state_{kind}"].item() > 0.02 for kind in ("taut", "partly_wrinkled", "wrinkled", "slack"))
    moved = float(run["resistor_dissipation"][-1])
    assert moved > 0.05
    assert float(abs(run["energy_residual"]).max()) < 2e-4 * moved
    charge = np.gradient(run["film_voltage"] * capacitance(run), TIMES, edge_order=2)
    assert np.abs(run["current"] - charge)[5:-5].max() < 0.02 * float(abs(run["current"]).max())


def capacitance(run):
    model = ConeModel(**BEHIND)
    x, v = run["displacement"].values, run["film_voltage"].values
    return model.film.capacitance(x, v * v, [], model.members().numbers_at(0))


def test_behind_a_small_resistance_it_moves_as_at_the_source():
    model = ConeModel(**BEHIND | {"series_resistance": 1e-4, "voltage": 0.3})
    run, alone = (simulate(one, (0.6, 0.0), times=TIMES) for one in (model, model.replace(circuit="ideal")))
    assert float(abs(run["displacement"] - alone["displacement"]).max()) < 1e-4


@pytest.mark.usefixtures("undelivered")
def test_a_film_with_a_strong_hoop_is_charged_through_a_resistance():
    model = ConeModel(**BEHIND | {"rest_height": 0.5, "voltage": 0.6} | FILMS["strong hoop"])
    run = simulate(model, (0.6, 0.0), times=TIMES[:201])
    assert int(run["outcome"]) == Outcome.OK
    moved = float(run["resistor_dissipation"][-1])
    assert float(abs(run["energy_residual"]).max()) < 1e-3 * moved


def test_circuits_give_equal_bits_on_other_threads():
    several = ConeModel(**BEHIND | {"voltage": [0.2, 0.3, 0.4, 0.5, 0.55]})
    one, four = (simulate(several, (0.6, 0.0), times=TIMES[:101], threads=count) for count in (1, 4))
    assert one.identical(four)


def test_of_many_films_each_has_the_charge_of_its_own():
    both = ConeModel(
        film="membrane", stretch_limit=50.0, meridional_prestretch=[[1.0], [1.3]], hoop_prestretch=[[1.0], [1.1]],
        radius_ratio=[[0.2], [0.3]],
    )  # fmt: skip
    together = both.members()
    for k, name in enumerate(("unstretched", "mixed")):
        alone = film_of(name)[1]
        own = together.numbers_at(k)
        assert {key: own[key] for key in membrane_charge.names()} == {k: alone[k] for k in membrane_charge.names()}


def test_a_charge_is_stored_by_film_and_law(monkeypatch):
    """Laws may have equal numbers and be others."""
    asked = []
    monkeypatch.setattr(
        membrane_charge.disk_cache, "made", lambda kind, parts, make, sources: asked.append(parts) or bytes(8)
    )
    own = {"film_error": 0.1, "other": 2.0}
    for law in ("first", "second"):
        membrane_charge._made.cache_clear()
        membrane_charge._made(lambda n: None, tuple(own), np.array(list(own.values())).tobytes(), law)
    membrane_charge._made.cache_clear()
    assert len({repr(parts) for parts in asked}) == 2
