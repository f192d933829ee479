"""Refusals of films whose membrane cannot be made."""

import numpy as np
import pytest

from gelcone.membrane.gel import Gel
from gelcone.membrane.refusals import TOO_CLOSE, not_made, too_few
from gelcone.physics.laws import LAWS

LAW = LAWS["gent"]


def gel_of(limit, squared=1.0):
    return Gel(LAW, LAW.numbers({"stretch_limit": limit}), squared, squared)


def test_a_film_of_too_few_states_is_refused_without_a_word_about_a_limit_that_its_gel_has_not():
    assert str(too_few(gel_of(50.0))) == TOO_CLOSE
    said = "film = membrane: too few states of this film are found; take film = wrinkling, or other pre-stretches"
    assert str(too_few(gel_of(np.inf))) == said


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (6.0, "film = membrane: stretch_limit = 6: must be at least about 9; take film = wrinkling"),
        (25.0, "film = membrane: why; take film = this"),
    ],
)
def test_a_membrane_that_is_not_made_names_the_stretch_limit_where_that_is_too_low(limit, said):
    assert str(not_made(gel_of(limit, 1.4), "why", "this")) == said
