"""The films that claims are judged with: the one that creeps is what its sources say, and nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest

from gelcone.paper.effort import FULL
from gelcone.paper.films import creeping_in_words, film_of_device, film_of_model
from gelcone.presets import find_preset

# Table 1 of the paper, its gel and what is assumed, in SI; VHB 4910 by Wang et al.
DISC, FILM, THICKNESS, MASS, SHEAR, PERMITTIVITY = 0.01, 0.05, 5e-4, 0.02, 56.1e3 / 3.0, 4.77 * 8.8541878188e-12
BRANCH = (26.06 / 15.36, 0.6074)
CREEPING = replace(FULL, film="creeping")


def scales():
    """Rate and capacitance of the flat film by their formulas."""
    area = np.pi * (FILM**2 - DISC**2)
    return np.sqrt(SHEAR * area * THICKNESS / MASS) / (FILM - DISC), PERMITTIVITY * area / THICKNESS


def test_the_branch_and_the_resistance_have_the_numbers_of_their_sources():
    rate, capacitance = scales()
    found = film_of_model("creeping")
    assert found["film"] == "wrinkling"
    assert found["flow"] == "linear"
    assert found["viscous_modulus_1"] == pytest.approx(BRANCH[0], rel=1e-12)
    assert found["relaxation_time_1"] == pytest.approx(BRANCH[1] * rate, rel=1e-9)
    assert found["series_resistance"] == pytest.approx(1e6 * capacitance * rate, rel=1e-9)
    # the range of 1 MOhm at the devices that ship
    assert 0.017 < found["series_resistance"] < 0.038


@pytest.mark.parametrize("name", ["base", "fast", "spring"])
def test_a_set_of_the_paper_changes_in_its_film_and_circuit_alone(name):
    paper, own = find_preset(name).model, CREEPING.preset(name).model
    added = {"series_resistance", "viscous_modulus_1", "relaxation_time_1"}
    assert set(own.values) - set(paper.values) == added
    assert {name: own.values[name] for name in paper.values} == dict(paper.values)
    states = [state.name for state in own.members().system.states]
    assert states[2:] == ["viscous_meridional_1", "viscous_hoop_1", "viscous_thickness_1", "film_voltage"]
    assert FULL.preset(name).model.parameters() == paper.parameters()


def test_the_device_and_the_model_have_the_same_film():
    made, own = film_of_device("creeping").to_model(), film_of_model("creeping")
    assert [made.values[name] for name in own if name not in ("film", "flow")] == list(own.values())[2:]
    assert (made.film.name, made.film.flow, made.film.branches) == ("wrinkling", "linear", 1)
    for film in ("wrinkling", "membrane"):
        assert film_of_device(film).to_model().film.name == film
        assert not film_of_device(film).to_model().system.circuit.states


def test_the_words_name_sources_and_numbers():
    words = creeping_in_words()
    for part in ("1 MOhm", "rho = 0.0299", "g = 1.697", "tau = 28.5", "linear flow rule", "VHB 4910", "paper-table1"):
        assert part in words
