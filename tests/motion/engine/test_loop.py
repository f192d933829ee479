"""The loop over all lanes: what is prepared of the numbers, which law goes first, and where a call ends."""

from dataclasses import dataclass

import numpy as np
import pytest
from engine_systems import Cone, cone_numbers

from gelcone.motion.engine.events import Event
from gelcone.motion.engine.loop import module_text, step_text
from gelcone.motion.engine.plan import ARRIVED, Job
from gelcone.motion.engine.program import Program
from gelcone.motion.engine.run import Work
from gelcone.physics.differentiate import evaluated
from gelcone.physics.trace import ordered


@pytest.mark.parametrize("count", [1, 5, 8])
def test_what_is_prepared_of_each_member_is_its_formula(count):
    program = Program(Cone(), "states", 1e-6, width=4)
    compiled = program._compile(4)
    numbers = cone_numbers(voltage=np.linspace(0.3, 1.2, count), frequency=np.linspace(0.5, 2.0, count), bias=0.2)
    arrays = compiled.job(numbers, np.zeros((count, 2)), 0.0, np.ones((count, 1)), 0.0, 1e9, None)
    held = compiled.layout.held
    assert len(held) > 5
    leaves = {node.index: numbers[node.value] for node in ordered(held) if node.operation == "number"}
    expected = [np.broadcast_to(value, (count,)) for value in evaluated(held, leaves)]
    np.testing.assert_allclose(arrays.table[:, :count], expected, rtol=1e-15)
    assert arrays.padded == 4 * -(-count // 4)


@dataclass(frozen=True)
class Sided:
    """x' = 1 before the border at x = 100, and beyond it x' = 2."""

    states = ("x",)
    numbers = ("s",)

    def rates(self, time, state, n, xp):
        return [1.5 - 0.5 * n["s"] + 0.0 * state[0]]


BORDER = Event(lambda t, z, n, xp: n["s"] * (100.0 - z[0]) * (1.0 + 1e-9 * xp.sin(1e3 * t)), -1, "s", divides=True)
WIDTH = 2


def started(sides):
    """The work of one thread on members that are on given sides of the border, and its arrays."""
    program = Program(Sided(), "states", 1e-6, [BORDER], width=WIDTH)
    compiled, count = program._compile(WIDTH), len(sides)
    assert len(compiled.plan.laws) == 2
    starts = np.where(np.array(sides) > 0.0, 0.0, 200.0)[:, None]
    arrays = compiled.job({"s": sides}, starts, 0.0, np.full((count, 1), 1e3), 0.0, 1e9, None)
    for law in (0, 1):
        compiled.compile_step(law)
    work = Work(compiled, arrays.fields(min(compiled.plan.slots, count)))
    work.start()
    return compiled, arrays, work


def steps_of(compiled, work, law):
    return work.lanes[law, compiled.layout.steps]


def test_a_member_takes_a_lane_of_its_law_or_waits_for_one():
    compiled, _, work = started([1.0, -1.0, 1.0, 1.0, 1.0])
    layout = compiled.layout
    np.testing.assert_array_equal(work._words[:2], [0b11, 0b01])
    np.testing.assert_array_equal(work._words[layout.waiting : layout.heads], [2, 0])
    places = dict(work.under_way())
    assert sorted(places) == [0, 1, 2, 3, 4]
    assert set(places.values()) == {0.0}
    assert work.going


@pytest.mark.parametrize("sides", [[1.0, 1.0, -1.0], [1.0, -1.0, -1.0]])
def test_the_law_of_most_members_goes_first(sides):
    """Those that wait count."""
    compiled, _, work = started(sides)
    most = 0 if sides.count(1.0) > 1 else 1
    work.advance(1)
    assert (steps_of(compiled, work, most) == 1.0).all()
    assert (steps_of(compiled, work, 1 - most) == 0.0).all()
    waiting = [1.0] * 3 + [-1.0] * 2 if most == 0 else [1.0] * 2 + [-1.0] * 3
    compiled, _, work = started(waiting)
    work.advance(1)
    assert (steps_of(compiled, work, most) == 1.0).all()
    assert (steps_of(compiled, work, 1 - most) == 0.0).all()


def test_a_call_makes_the_steps_that_it_is_asked_for_and_says_how_many():
    compiled, arrays, work = started([1.0, 1.0])
    assert compiled.advance(*work._advance, 3) == 3
    assert (steps_of(compiled, work, 0) == 3.0).all()
    assert compiled.advance(*work._advance, 0) == 0
    assert (arrays.status == -1).all()
    while work.going:
        done = compiled.advance(*work._advance, 1 << 20)
    assert 0 < done < 1 << 20
    assert (arrays.status == ARRIVED).all()
    assert compiled.advance(*work._advance, 10) == 0
    np.testing.assert_allclose(arrays.result[:, 0, 0], 100.0 + 2.0 * 900.0, rtol=1e-9)


def test_a_call_ends_where_the_step_of_a_law_is_missing_and_names_it():
    compiled, _, work = started([-1.0, -1.0, 1.0])
    layout = compiled.layout
    work._words[layout.code + 1] = 0
    assert compiled.advance(*work._advance, 5) == 0
    assert work._words[layout.missing] == 2
    assert (steps_of(compiled, work, 1) == 0.0).all()
    work._words[layout.code : layout.missing] = compiled.addresses
    assert compiled.advance(*work._advance, 5) == 5
    assert work._words[layout.missing] == 0


def test_no_more_members_start_than_there_are_slots_and_the_next_one_is_counted():
    compiled, arrays, _ = started([1.0] * 9)
    work = Work(compiled, job := arrays.fields(3))
    work.start()
    assert sorted(member for member, _ in work.under_way()) == [0, 1, 2]
    assert job[Job.NEXT] == 3
    while work.going:
        work.advance(1 << 20)
    assert (arrays.status == ARRIVED).all()


def test_a_module_has_its_functions_and_the_step_where_there_is_one_law():
    def defined(text):
        return [line.partition("@")[2].partition("(")[0] for line in text.splitlines() if line.startswith("define")]

    one = Program(Cone(), "states", 1e-6)._plan(4)
    several = Program(Sided(), "states", 1e-6, [BORDER])._plan(4)
    common = {"prepare", "enter", "vacate", "refill", "serve", "start", "advance"}
    assert set(defined(module_text(one))) == common | {"step"}
    assert set(defined(module_text(several))) == common | {"crossing"}
    assert defined(step_text(several, 1)) == ["step"]
    assert step_text(several, 0) != step_text(several, 1)
    for text in (module_text(one), step_text(several, 1)):
        declared = [line for line in text.splitlines() if line.startswith("declare")]
        assert len(declared) == len(set(declared)) > 0
