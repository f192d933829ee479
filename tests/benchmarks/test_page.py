"""The numbers of the page Benchmarks: operations are counted in what is compiled, and a part is written anew alone."""

from pathlib import Path

import numpy as np
import page
import peak
import pytest

from gelcone.motion.engine.loop import module_text
from gelcone.motion.engine.program import Program
from tests.motion.engine.engine_systems import Cone

STEP = """define void @step(ptr %job) noinline {
  %1 = call <4 x double> @llvm.fma.v4f64(<4 x double> %a, <4 x double> %b, <4 x double> %c)
  %2 = fmul <4 x double> %1, %1
  %3 = fcmp olt <4 x double> %2, %1
  %4 = fdiv <4 x double> %2, %1
}
define void @serve(ptr %job) {
  %1 = fadd double %a, %b
}"""
PAGE = """$ python benchmarks/engine.py 3
gelcone 0.2.0
states: 104 ns/unit; two threads 1.61

$ python benchmarks/cells.py 41 33
map, two threads over one: 1.66 (8.84 s, not 14.64 s)
map: 19.1 % Python
"""


def test_operations_are_those_of_a_step():
    assert peak.operations_in(STEP) == 4
    of_order = {}
    for tolerance in (1e-6, 1e-10, 1e-14):
        program = Program(Cone(), "states", tolerance)
        (of_order[program.order],) = {peak.operations_in(module_text(program._plan(width))) for width in (4, 8)}
    # of the products of two series there are as many terms as the square of the order
    assert of_order[12] / of_order[8] == pytest.approx((12 / 8) ** 2, rel=0.25)
    assert of_order[18] / of_order[12] == pytest.approx((18 / 12) ** 2, rel=0.25)


def test_the_loop_at_the_peak_sums_what_it_says():
    own = peak.Peak()
    for rounds, one in ((1, 0.75), (2, 0.875)):  # x -> x/2 + 1/2 from 1/2
        numbers = np.full(own.width, 0.5)
        own.run(numbers.ctypes.data, rounds)
        assert numbers == pytest.approx(0.5 + peak.CHAINS * one)


def test_a_part_of_the_page_is_found_and_scaling_left_out():
    found = page.sections(PAGE)
    assert list(found) == ["engine.py", "cells.py"]
    assert found["engine.py"].endswith("two threads 1.61")
    assert "two threads" not in page.without_scaling(PAGE)
    assert "19.1 % Python" in page.without_scaling(PAGE)


def test_the_page_of_the_repository_holds_what_is_run():
    text = (Path(page.ROOT) / "docs" / "benchmarks.txt").read_text(encoding="utf-8")
    assert set(page.sections(text)) <= set(page.RUNS)
