"""The machine code of a plan: what its key holds, and where vectors lie."""

import dataclasses

import numpy as np
import pytest
from engine_systems import Cone, Oscillator, cone_numbers

from gelcone import disk_cache
from gelcone.motion.engine import machine_code
from gelcone.motion.engine.compile import COLD, QUICK
from gelcone.motion.engine.interruptions import border_events, corner_numbers
from gelcone.motion.engine.machine_code import SECONDS_PER_BYTE, Compiled, aligned, content_of
from gelcone.motion.engine.plan import Job
from gelcone.motion.engine.program import Program
from gelcone.presets import find_preset


def other(value):
    """Another value of a part of a plan."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + 1
    if value is None:
        return 7
    return (*value[::-1], *value[:1])


def test_each_part_of_a_plan_is_in_the_key_of_its_code():
    """Among them each field of each border: code with another direction is other code."""
    model = find_preset("base").model.replace(film="wrinkling", second_film="wrinkling", circuit="amplifier")
    system = model.system
    plan = Program(system, "work", 1e-6, border_events(system), **corner_numbers(system))._plan(2)
    assert plan.borders
    parts = {field.name: other(getattr(plan, field.name)) for field in dataclasses.fields(plan)}
    plans = [dataclasses.replace(plan, **{name: part}) for name, part in parts.items()]
    for k, border in enumerate(plan.borders):
        for field in dataclasses.fields(border):
            changed = dataclasses.replace(border, **{field.name: other(getattr(border, field.name))})
            plans.append(dataclasses.replace(plan, borders=(*plan.borders[:k], changed, *plan.borders[k + 1 :])))
    contents = {content_of(one) for one in (plan, *plans)}
    assert len(contents) == 1 + len(plans) > 20


@pytest.mark.parametrize("shape", [(3,), (1, 8), (5, 2, 4)])
def test_arrays_begin_where_the_largest_vector_may(shape):
    for _ in range(20):
        zeros = aligned(*shape)
        assert zeros.shape == shape
        assert zeros.ctypes.data % 128 == 0
        assert zeros.flags.c_contiguous
        np.testing.assert_array_equal(zeros, 0.0)


def test_corners_after_each_start_stand_in_their_order_with_infinity_behind():
    compiled = Program(Cone(), "states", 1e-6)._compile(2)
    given = cone_numbers(), np.zeros((3, 2)), np.array([0.0, 1.0, 2.5]), np.full((3, 1), 9.0), 0.0, 1e9
    rows = compiled.job(*given, np.array([3.0, 1.0, 2.0])).corners
    np.testing.assert_array_equal(rows[0], [1.0, 2.0, 3.0, np.inf])
    np.testing.assert_array_equal(rows[1], [2.0, 3.0, np.inf, np.inf])  # the one at its start has been passed
    np.testing.assert_array_equal(rows[2], [3.0, np.inf, np.inf, np.inf])
    np.testing.assert_array_equal(compiled.job(*given, None).corners, np.full((3, 1), np.inf))


def test_a_job_begins_with_what_its_members_are_given():
    compiled = Program(Cone(), "tangents", 1e-6)._compile(2)
    states, times = np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]), np.array([[1.0, 2.0]] * 3)
    arrays = compiled.job(cone_numbers(), states, 0.5, times, [1e-9, 1e-8, 1e-7], 77.0, None)
    np.testing.assert_array_equal(arrays.states, np.hstack([states, np.tile([1.0, 0.0, 0.0, 1.0], (3, 1))]))
    np.testing.assert_array_equal(arrays.end_state, arrays.states)
    assert arrays.end_state is not arrays.states
    np.testing.assert_array_equal(
        [arrays.start, arrays.end_time, arrays.most_steps], [[0.5] * 3, [0.5] * 3, [77.0] * 3]
    )
    np.testing.assert_array_equal(arrays.smallest, [1e-9, 1e-8, 1e-7])
    assert (arrays.status == -1).all()
    assert np.isnan(arrays.result).all()
    assert arrays.result.shape == (3, 2, 6)
    assert np.isinf(arrays.least).all()
    assert arrays.padded == 4
    fields = arrays.fields(5)
    numbers = {Job.MEMBERS: 3, Job.SAMPLES: 2, Job.CORNER_COUNT: 1, Job.PADDED: 4, Job.SLOTS: 5, Job.PIECE_COUNT: 1}
    assert {field: fields[field] for field in numbers} == numbers
    for field in (Job.TABLE, Job.STATES, Job.RESULT, Job.DWELL, Job.PIECES, Job.MOST_STEPS, Job.SMALLEST):
        assert fields[field] == getattr(arrays, field.name.lower()).ctypes.data


def test_a_job_holds_the_pieces_of_each_member():
    compiled = Program(Oscillator(), "states", 1e-6, pieces=("begin", "sign"))._compile(2)
    pieces, first = np.array([[[1.0], [-1.0], [0.5]]]), [1, 2]
    numbers = {"begin": 0.0, "sign": 1.0}
    arrays = compiled.job(numbers, np.zeros((2, 2)), 0.0, np.ones((2, 1)), 0.0, 1e9, [0.5, 0.7], (pieces, first))
    assert arrays.fields(2)[Job.PIECE_COUNT] == 3
    np.testing.assert_array_equal(arrays.pieces, np.repeat(pieces, 2, axis=0))
    np.testing.assert_array_equal(arrays.first_piece, first)
    np.testing.assert_array_equal(arrays.switches, [[0.0, 1.0]] * 2)


@pytest.fixture
def levels(monkeypatch, tmp_path):
    """The level of each library that is asked for, with an empty cache."""
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    found, library = [], machine_code.compiler.library

    def recorded(content, text, machine, level):
        found.append(level)
        return library(content, text, machine, level)

    monkeypatch.setattr(machine_code.compiler, "library", recorded)
    return found


def wrinkling():
    """A program of several laws, and a run of it that comes into two of them."""
    model = find_preset("base").model.replace(film="wrinkling", rest_height=0.3, voltage=0.3)
    system, numbers = model.system, model.members().own_numbers
    program = Program(system, "states", 1e-10, border_events(system))
    return program, lambda: program.run(numbers, [[0.35, 0.0]], 0.0, np.linspace(0.0, 60.0, 20)[None]).states.tobytes()


def test_steps_are_made_quickly_and_well_once_they_have_run_for_as_long_as_that_takes(levels):
    """With the same bits; another process finds the code that runs faster."""
    program, run = wrinkling()
    quick = run()
    (compiled,) = program._compiled.values()
    laws = [law for law, address in enumerate(compiled.addresses[:-1]) if address]
    assert len(laws) > 1
    assert levels == [COLD] + [QUICK] * len(laws)
    costs = [compiled._quick[law] for law in laws]
    sizes = [library.size for library in compiled._libraries[1:]]
    assert sum(costs) == pytest.approx(SECONDS_PER_BYTE * sum(sizes), rel=1e-12)
    before, spent = list(compiled.addresses), compiled._seconds
    assert 0.0 < spent < 0.5 * sum(costs)
    compiled.has_run(0.9 * sum(costs) - spent)
    assert compiled.addresses == before
    second = Compiled(compiled.plan, None)
    second.compile_step(laws[0])
    with disk_cache.unmade_refused():  # and nothing is stored yet
        compiled.has_run(0.2 * sum(costs))
    assert compiled.addresses == before
    compiled.has_run(0.9 * sum(costs))
    compiled.has_run(0.2 * sum(costs))
    assert levels == [COLD] + [QUICK] * len(laws) + [COLD, QUICK] + [COLD] * len(laws)
    changed = [law for law in range(len(before)) if compiled.addresses[law] != before[law]]
    assert changed == laws
    compiled.has_run(1e9)
    assert len(levels) == 3 + 2 * len(laws)
    assert run() == quick
    with disk_cache.unmade_refused():
        second.has_run(1e9)
    assert not second._quick
    third = Compiled(compiled.plan, None)
    third.compile_step(laws[0])
    third.compile_step(laws[0])
    assert levels[3 + 2 * len(laws) :] == [COLD, COLD, COLD]
