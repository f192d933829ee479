"""Models whose force or capacitance can be inverted: one film without states, and an ideal source."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.motion.single_film import single_film
from gelcone.physics.model import ConeModel


@pytest.mark.parametrize("changes", [{}, {"film": "wrinkling"}, {"rest_height": 0.8, "waveform": "triangle"}])
def test_a_film_without_states_behind_an_ideal_source_is_taken(changes):
    model = ConeModel(**changes)
    assert single_film(model, "follow") is model.system


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"second_film": "taut"}, "follow: takes one film, and here are two; leave second_film out"),
        ({"series_resistance": 0.3}, "follow: .* must have no states .* have film_voltage; leave them out"),
        ({"film": "taut", "circuit": "charge"}, "follow: .* must have no states .* have charge; leave them out"),
        ({"viscous_modulus_1": 0.4, "relaxation_time_1": 3.0}, "follow: .* must have no states of their own"),
        ({"damping_ratio": np.array([0.1, 0.2])}, "follow"),
    ],
)
def test_all_others_are_refused_with_what_stands_in_the_way(changes, message):
    with pytest.raises(InputError, match=message):
        single_film(ConeModel(**changes), "follow")
