"""A system as laws: one for each side of the borders that tell laws apart, and what restarts at samples."""

import numpy as np
import pytest
from engine_systems import Cone

import gelcone
from gelcone.motion.engine.interruptions import border_events, corner_numbers
from gelcone.motion.engine.laws import traced_plan

WRINKLING = gelcone.ConeModel(film="wrinkling", viscous_modulus_1=0.5, relaxation_time_1=3.0).system


@pytest.mark.parametrize("keep", ["states", "tangents", "work"])
def test_what_is_kept_adds_states(keep):
    system = gelcone.ConeModel().system
    plan = traced_plan(system, keep, (), ())
    (law,) = plan["laws"]
    count = {"states": 2, "tangents": 6, "work": 2 + len(system.causes)}[keep]
    assert len(law.rates) == count
    assert plan["passengers"] == (len(system.causes) - system.bounding_powers if keep == "work" else 0)
    unit = (None, None, 1.0, 0.0, 0.0, 1.0)
    assert plan["restarts"] == (unit if keep == "tangents" else (None,) * count)


def test_the_divergence_is_a_state_where_it_is_not_known():
    """Of a system with more than the disc's states: the trace of its Jacobian, an integral."""
    system = gelcone.ConeModel(viscous_modulus_1=0.5, relaxation_time_1=3.0).system
    plan = traced_plan(system, "tangents", (), ())
    assert len(plan["laws"][0].rates) == 4 + 16 + 1
    assert plan["passengers"] == 1
    assert plan["restarts"][4:-1] == tuple(np.eye(4).ravel())
    assert plan["restarts"][-1] == 0.0


def test_there_is_a_law_for_each_side_of_the_borders_that_tell_them_apart():
    plan = traced_plan(WRINKLING, "states", border_events(WRINKLING), corner_numbers(WRINKLING).get("pieces", ()))
    names = [plan["switches"][place].value for place in plan["telling"]]
    assert names == ["width_held", "meridian_held"]
    assert len(plan["laws"]) == 4
    # held in both directions a film has no lengths to be found; free in one it has one, in both it has two
    assert [len(law.equations) for law in plan["laws"]] == [0, 1, 1, 2]


def test_a_switch_that_is_no_number_is_refused():
    (event, *_) = border_events(WRINKLING)
    with pytest.raises(ValueError, match="switch = 'width_held': is not among the numbers"):
        traced_plan(Cone(), "states", (event,), ())
