"""Double cones whose films have no limit, against what far displacements leave of the balance."""

import math

import pytest

import gelcone
from gelcone.physics.balance import SEARCH_RANGE, PullIn

PAIR = gelcone.ConeModel(
    law="neo-hookean", film="taut", second_film="taut", second_flat_height=0.5, spring_stiffness=0.3
)


@pytest.mark.parametrize(("drive", "driven", "side"), [("same", 2, -1), ("opposite", 2, -1), ("constant", 1, 1)])
def test_without_a_limit_the_disc_leaves_where_the_voltage_takes_the_stiffness_of_all(drive, driven, side):
    """Far away a neo-Hookean film pulls with x (1 - v^2): all is gone at k + 2 = v^2 times the films that v drives."""
    found = gelcone.pull_in_voltage(PAIR.replace(second_drive=drive))
    assert int(found["pull_in_kind"]) == PullIn.SEARCH_RANGE
    assert float(found["pull_in_voltage"]) == pytest.approx(math.sqrt(2.3 / driven), rel=1e-3)
    assert 0.9 * SEARCH_RANGE < side * float(found["pull_in_from"]) < SEARCH_RANGE
    assert float(found["pull_in_to"]) == side * math.inf


@pytest.mark.parametrize("drive", ["same", "constant"])
def test_with_a_limit_it_does_not(drive):
    found = gelcone.pull_in_voltage(PAIR.replace(second_drive=drive, law="gent"))
    assert int(found["pull_in_kind"]) == PullIn.NEVER
    assert float(found["pull_in_voltage"]) == math.inf
