"""The text of functions: long blocks are parted without a change of what is computed."""

import ctypes

import numpy as np
import pytest

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.code import Function
from gelcone.motion.engine.machine_code import aligned

LONGEST, TERMS = 50, 200


def summed(longest_block):
    """The text of a function that adds up the multiples of a number, and its result for 0.1."""
    f = Function("add", ["ptr %a"], "void", 1, external=True, longest_block=longest_block)
    number = f.load("%a")
    total = number
    for k in range(TERMS):
        total = f.fused(number, f.real(float(k)), total)
    f.store(total, "%a")
    f.finish()
    text = "\n".join([*f.intrinsics, f.text()])
    library = compiler.Library(compiler.object_code(text, compiler.host()), compiler.host())
    value = np.array([0.1])
    library.function("add", None, ctypes.c_void_p)(value.ctypes.data)
    return text, value[0]


def test_long_blocks_are_parted_and_give_the_same_bits():
    whole, expected = summed(None)
    parted, value = summed(LONGEST)
    assert value == expected
    blocks = parted.split(":\n")
    assert max(block.count("\n") for block in blocks) <= LONGEST + 2
    assert TERMS // LONGEST <= len(blocks) <= 3 * TERMS // LONGEST
    assert whole.count(":\n") == 1


# --- what the instructions do -----------------------------------------------------------------------------------------

A = np.array([1.5, -2.0, np.nan, 4.0])
B = np.array([2.5, -3.0, 1.0, np.nan])


def lanes_of(emit, width=4):
    """What ``emit(f, a, b, out)`` writes to 8 places from vectors a and b."""
    f = Function("made", ["ptr %a", "ptr %b", "ptr %out"], "void", width, external=True)
    emit(f, f.load("%a"), f.load("%b"), "%out")
    f.finish()
    text = "\n".join([*sorted(f.intrinsics), f.text()])
    library = compiler.Library(compiler.object_code(text, compiler.host()), compiler.host())
    rooms = aligned(3, 16)
    rooms[0, :4], rooms[1, :4] = A, B
    library.function("made", None, *[ctypes.c_void_p] * 3)(*(room.ctypes.data for room in rooms))
    return rooms[2]


@pytest.mark.parametrize(
    ("emit", "expected"),
    [
        (lambda f, a, b: f.larger(a, b), [2.5, -2.0, 1.0, np.nan]),
        (lambda f, a, b: f.larger(b, a), [2.5, -2.0, np.nan, 4.0]),
        (lambda f, a, b: f.smaller(a, b), [1.5, -3.0, 1.0, np.nan]),
        (lambda f, a, b: f.smaller(b, a), [1.5, -3.0, np.nan, 4.0]),
        (lambda f, a, b: f.subtract(a, f.negative(f.absolute(b))), [4.0, 1.0, np.nan, np.nan]),
        (lambda f, a, b: f.polynomial(a, [f.real(1.0), b, f.real(2.0)]), [9.25, 15.0, np.nan, np.nan]),
        (lambda f, a, b: f.divide(f.multiply(a, b), f.sqrt(f.real(4.0))), [1.875, 3.0, np.nan, np.nan]),
    ],
)
def test_what_operations_give_in_each_lane(emit, expected):
    """Of two numbers the second where the first is NaN."""
    np.testing.assert_array_equal(lanes_of(lambda f, a, b, out: f.store(emit(f, a, b), out))[:4], expected)


def test_truth_values_are_joined_lane_by_lane():
    def emit(f, a, b, out):
        below, positive = f.compare("olt", a, b), f.compare("ogt", a, f.real(0.0))
        for k, truth in enumerate((f.both(below, positive), f.either(below, positive), f.opposite(below))):
            f.store_whole(f.lanes(truth), f.place(out, k))
        f.store_whole(f.lanes(f.compare("uno", a, b)), f.place(out, 3))
        never = f.compare("ogt", f.absolute(a), f.real(1e9))
        for k, truth in enumerate((below, never)):
            f.store_whole(f.new(f"zext i1 {f.anywhere(truth)} to i64"), f.place(out, 4 + k))

    found = lanes_of(emit).view(np.int64)[:6]
    # a < b in lane 0 alone; a > 0 in lanes 0 and 3; NaN in lanes 2 and 3
    np.testing.assert_array_equal(found, [0b0001, 0b1001, 0b1110, 0b1100, 1, 0])


def test_blocks_are_entered_repeated_and_left_as_their_conditions_say():
    def emit(f, a, b, out):
        with f.each(3) as number:
            f.store_whole(number, f.place(out, number))
        count = f.slot()
        f.store_whole("0", count)
        with f.repeat() as done:
            now = f.load_whole(count)
            f.leave(done, f.compare_whole("sge", now, "5"))
            f.store_whole(f.whole("add", now, "2"), count)
        f.store_whole(f.load_whole(count), f.place(out, 3))
        for place, relation in ((4, "slt"), (5, "sgt")):
            f.store_whole("7", f.place(out, place))
            with f.when(f.compare_whole(relation, "1", "2")):
                f.store_whole("8", f.place(out, place))
            f.store_whole("9", f.place(out, place + 2))
            with f.leavable() as on:
                f.leave(on, f.compare_whole(relation, "1", "2"))
                f.store_whole("10", f.place(out, place + 2))

    np.testing.assert_array_equal(lanes_of(emit, 1).view(np.int64)[:8], [0, 1, 2, 6, 8, 7, 9, 10])


def test_a_single_lane_is_computed_as_one_of_many():
    def emit(f, a, b, out):
        f.store(f.choose(f.opposite(f.compare("ogt", a, b)), f.fused(a, b, a), b), out)

    assert lanes_of(emit, 1)[0] == lanes_of(emit)[0] == 1.5 * 2.5 + 1.5
