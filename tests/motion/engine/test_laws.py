"""A system as laws: one for each side of the borders that tell laws apart, and what restarts at samples."""

from dataclasses import dataclass

import numpy as np
import pytest
from engine_systems import Cone

import gelcone
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.interruptions import border_events, corner_numbers
from gelcone.motion.engine.laws import MOST_TELLING, traced_plan
from gelcone.physics.trace import ordered

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


def test_of_many_borders_that_divide_laws_the_first_few_do():
    """The others switch within the laws."""
    events = [Event(lambda t, z, n, xp, name=name: n[name] * (1.0 - z[0]), -1, name, divides=True) for name in "abcdef"]

    @dataclass(frozen=True)
    class Six:
        states = ("x",)
        numbers = tuple("abcdef")

        def rates(self, time, state, n, xp):
            return [n["a"] + n["f"] + 0.0 * state[0]]

    plan = traced_plan(Six(), "states", events, ())
    assert plan["telling"] == tuple(range(MOST_TELLING))
    assert len(plan["laws"]) == 2**MOST_TELLING
    assert len(plan["switches"]) == 6
    for k, law in enumerate(plan["laws"]):
        first = [node for node in ordered(law.rates) if node.operation in ("constant", "switch")]
        assert "f" in [node.value for node in first]
        assert "a" not in [node.value for node in first]
        assert (-1.0 if k & 1 else 1.0) in [node.value for node in first]


@pytest.mark.parametrize("inside", [False, True])
def test_a_border_has_a_side_where_members_belong_if_it_says_so_or_contains_its_switch(inside):
    plain = Event(lambda t, z, n, xp: 1.0 - z[0], -1, "zeta", inside=inside)
    own = Event(lambda t, z, n, xp: n["kappa"] * (1.0 - z[0]), -1, "kappa", inside=inside)
    ends = Event(lambda t, z, n, xp: 1.0 - z[0], -1, inside=inside)
    borders = traced_plan(Cone(), "states", [plain, own, ends], ())["borders"]
    assert [border.sided for border in borders] == [inside, True, inside]
    assert [border.switch for border in borders] == [0, 1, None]


def test_a_system_of_two_states_that_is_not_planar_has_its_divergence_integrated():
    """Where the charge is commanded the voltage follows the disc."""
    for circuit, count in (("ideal", 6), ("charge", 7)):
        plan = traced_plan(gelcone.ConeModel(film="taut", circuit=circuit).system, "tangents", (), ())
        assert len(plan["laws"][0].rates) == count
        assert plan["passengers"] == count - 6
