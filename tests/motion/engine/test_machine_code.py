"""The machine code of a plan: what its key holds, and where vectors lie."""

import dataclasses

import numpy as np
import pytest

from gelcone.motion.engine.interruptions import border_events, corner_numbers
from gelcone.motion.engine.machine_code import aligned, content_of
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
