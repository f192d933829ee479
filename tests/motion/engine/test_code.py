"""The text of functions: long blocks are parted without a change of what is computed."""

import ctypes

import numpy as np

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.code import Function

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
    assert len(blocks) >= TERMS // LONGEST
    assert whole.count(":\n") == 1
