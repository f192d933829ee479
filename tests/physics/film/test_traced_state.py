"""The formulas that programs take for stresses, field and share of the limit are those of the films' states."""

from __future__ import annotations

import numpy as np
import pytest

import gelcone
from gelcone.physics.differentiate import evaluated
from gelcone.physics.trace import Graph

FILMS = {
    "taut": {"film": "taut"},
    "wrinkling": {"film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05},
    "short": {"film": "wrinkling", "meridional_prestretch": 0.9, "hoop_prestretch": 0.8},
    "membrane": {"film": "membrane"},
    "strong hoop": {"film": "membrane", "meridional_prestretch": 1.0, "hoop_prestretch": 1.6},
}


def in_program(film, n, x, voltage):
    """The formulas at a displacement and a voltage, with the switches there."""
    signs = {name: float(np.ravel(v)[0]) for name, v in film.switches(x, voltage**2, [], n).items()}
    graph = Graph()
    numbers = {name: graph.number(name) for name in n} | {name: graph.constant(s) for name, s in signs.items()}
    leaf, squared = graph.state(0), graph.state(1)
    found = film.traced_state(leaf, squared, [], numbers, graph)
    known = {numbers[name].index: np.float64(value) for name, value in n.items() if name not in signs}
    known |= {leaf.index: np.float64(x), squared.index: np.float64(voltage**2)}
    return [float(value) for value in evaluated([graph.node(value) for value in found], known)], signs


@pytest.mark.parametrize("kind", FILMS)
def test_formulas_of_programs_are_those_of_the_state(kind):
    model = gelcone.find_device("biased-pump").replace(FILMS[kind]).to_model()
    film, n = model.film, {name: float(np.ravel(value)[0]) for name, value in model.numbers().items()}
    rng, seen, compared = np.random.default_rng(3), set(), 0
    for _ in range(60):
        x, voltage = float(rng.uniform(0.02, 1.1)), float(rng.uniform(0.0, 0.9))
        state = film.state(x, voltage, [], n)
        if not np.isfinite(state.meridional_stress):
            continue
        (along, across, field, share), signs = in_program(film, n, x, voltage)
        seen.add(tuple(signs.values()))
        compared += 1
        right = state.meridional_stress, state.hoop_stress, state.true_field**2
        np.testing.assert_allclose((along, across, field), right, rtol=1e-9, atol=1e-9)
        assert share == pytest.approx(float(film.limit_share(x, voltage, [], n)), rel=1e-9)
    assert compared > 20
    assert len(seen) > 1 or kind == "taut"
