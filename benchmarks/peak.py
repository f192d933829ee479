"""Share of the processor's peak of fused multiply-adds that the engine reaches, on one thread.

    python benchmarks/peak.py [TURNS]

The operations of a step are counted in the text that is compiled: a fused multiply-add is two, whatever else adds,
multiplies or divides is one; comparisons, events and all that serves single members count nothing, and neither do lanes
without a member. The peak is that of a loop of independent fused multiply-adds on vectors as wide as the processor's.
Both take short turns, in processor time, so that a clock that changes and other work meet both alike. Stated is the
ratio of the rates that the best tenth of TURNS (default 80) turns exceeds; the middle half of the ratios of neighbours
shows what other work takes away, by its place in the caches and on a core that two share.
"""

from __future__ import annotations

import ctypes
import re
import sys
import time
from pathlib import Path

import numpy as np

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.loop import module_text
from gelcone.motion.engine.program import Program

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "motion" / "engine"))
from engine_systems import Cone, cone_numbers

CHAINS = 12
"""Independent sums: more than two units with a latency of four need, and fewer than registers."""
PEAK_SECONDS = 0.005
BEST = 0.9
TOLERANCES = (1e-6, 1e-14)
MEMBERS = 256


def peak_text(width: int) -> str:
    """A module with ``peak(out, rounds)``: `CHAINS` fused multiply-adds a round, none of which waits for another."""
    vector, chains = f"<{width} x double>", range(CHAINS)
    fma = f"@llvm.fma.v{width}f64"
    lines = [
        f"declare {vector} {fma}({vector}, {vector}, {vector})",
        "define void @peak(ptr %out, i64 %rounds) {",
        "start:",
        f"  %first = load {vector}, ptr %out, align 8",
        "  br label %round",
        "round:",
        "  %k = phi i64 [ 0, %start ], [ %more, %round ]",
        *(f"  %a{i} = phi {vector} [ %first, %start ], [ %b{i}, %round ]" for i in chains),
        *(f"  %b{i} = call {vector} {fma}({vector} %a{i}, {vector} %first, {vector} %first)" for i in chains),
        "  %more = add i64 %k, 1",
        "  %again = icmp slt i64 %more, %rounds",
        "  br i1 %again, label %round, label %end",
        "end:",
        *(
            f"  %s{i} = fadd {vector} {f'%s{i - 1}' if i else '%first'}, %b{i}"
            for i in chains  # no chain may be left out
        ),
        f"  store {vector} %s{CHAINS - 1}, ptr %out, align 8",
        "  ret void",
        "}",
    ]
    return "\n".join(lines)


def operations_in(text: str) -> int:
    """Floating-point operations on each number of the vectors in the function ``step`` of a module."""
    (step,) = re.findall(r"define [^\n]*@step\(.*?\n}", text, flags=re.DOTALL)
    fused = len(re.findall(r"@llvm\.fma\.v\d+f64\(", step))
    return 2 * fused + len(re.findall(r"= f(?:add|sub|mul|div) ", step))


class Peak:
    """Runs the loop at the peak."""

    def __init__(self) -> None:
        self.width = compiler.host().vector
        self.library = compiler.Library(compiler.object_code(peak_text(self.width), compiler.host()), compiler.host())
        self.run = self.library.function("peak", None, ctypes.c_void_p, ctypes.c_int64)
        self.rounds = 1000
        while self.seconds() < PEAK_SECONDS:
            self.rounds *= 2

    def seconds(self) -> float:
        """Processor seconds of a run."""
        numbers = np.full(self.width, 0.5)
        begin = time.thread_time()
        self.run(numbers.ctypes.data, self.rounds)
        return time.thread_time() - begin

    def rate(self) -> float:
        """Operations a second."""
        return 2.0 * CHAINS * self.width * self.rounds / self.seconds()


def main(turns: int) -> None:
    """Prints a line for each stored quantity and tolerance."""
    peak, period = Peak(), np.pi / 0.1
    numbers, starts = cone_numbers(voltage=np.linspace(1.1, 2.0, MEMBERS)), np.tile([1.0, 0.0], (MEMBERS, 1))
    for keep, step in (("states", 1.0), ("tangents", 0.125)):
        times = np.tile(period * step * np.arange(1, 4 / step + 1), (MEMBERS, 1))
        for tolerance in TOLERANCES:
            program = Program(Cone(), keep, tolerance)
            cost = operations_in(module_text(program._plan(program._best_width(MEMBERS, 1))))
            done = cost * int(program.run(numbers, starts, 0.0, times).steps.sum())
            rates = np.empty((turns, 2))
            for turn in rates:
                begin = time.thread_time()
                program.run(numbers, starts, 0.0, times)
                turn[:] = done / (time.thread_time() - begin), peak.rate()
            best = np.divide(*np.quantile(rates, BEST, axis=0))
            low, high = np.quantile(rates[:, 0] / rates[:, 1], [0.25, 0.75])
            print(
                f"{keep:8s} {tolerance:.0e}: {best:.0%} of the peak (middle half of turns {low:.0%} to {high:.0%}), "
                f"{cost} operations a step of order {program.order}"
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 80)
