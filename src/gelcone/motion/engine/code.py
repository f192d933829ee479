"""Text of LLVM functions: arithmetic on vectors of lanes or on single numbers, memory, and structured control flow.

No instruction carries a fast-math flag, and every fused multiply-add is explicit: the text fixes each rounding.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

Value = str
"""A number, vector, pointer or truth value in the text: a name like ``%v7``, or a constant."""


def real_bits(value: float) -> str:
    """A double as LLVM writes it exactly."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


class Function:
    """The text of one function, whose numbers are vectors of ``width`` doubles, or single ones at width 1.

    ``arguments``, such as "ptr %job", are referred to by their names. ``external`` makes the function visible outside.
    ``longest_block`` is the most instructions between two branches (default: any number): the compiler's time grows
    faster than the length of a block, so longer blocks are divided by branches that are always taken. The first
    argument must then be a pointer.
    """

    def __init__(
        self,
        name: str,
        arguments: Sequence[str],
        result: str,
        width: int,
        external: bool = False,
        longest_block: int | None = None,
    ) -> None:
        self.width = width
        linkage = "" if external else "internal "
        self._head = f"define {linkage}{result} @{name}({', '.join(arguments)}) {'' if external else 'noinline '}{{"
        self._lines: list[str] = ["entry:"]
        self._longest_block, self._block = longest_block, 0
        self._never = ["never:", "  unreachable"] if longest_block else []
        if longest_block:
            self._lines.append(f"  %always = icmp ne ptr {arguments[0].split()[-1]}, null")
        self._slots: list[str] = []
        self._count = 0
        self.intrinsics: set[str] = set()
        self.real_type: str = "double" if width == 1 else f"<{width} x double>"
        self.integer_type: str = "i64" if width == 1 else f"<{width} x i64>"
        self.truth_type: str = "i1" if width == 1 else f"<{width} x i1>"
        self._suffix = "f64" if width == 1 else f"v{width}f64"

    def text(self) -> str:
        """The text of the whole function."""
        return "\n".join([self._head, self._lines[0], *self._slots, *self._lines[1:], *self._never, "}", ""])

    def line(self, text: str) -> None:
        """Appends an instruction without result."""
        self._lines.append("  " + text)

    def new(self, text: str) -> Value:
        """Appends an instruction, and returns the name of its result."""
        if self._longest_block and len(self._lines) - self._block >= self._longest_block:
            on = self._fresh("on")
            self.line(f"br i1 %always, label %{on}, label %never")
            self._label(on)
        self._count += 1
        self._lines.append(f"  %v{self._count} = {text}")
        return f"%v{self._count}"

    # --- numbers -------------------------------------------------------------------------------------------------

    def real(self, value: float) -> Value:
        """A constant, the same in all lanes."""
        return real_bits(value) if self.width == 1 else f"splat (double {real_bits(value)})"

    def integer(self, value: int) -> Value:
        """An integer constant, the same in all lanes."""
        return str(value) if self.width == 1 else f"splat (i64 {value})"

    def _binary(self, instruction: str, a: Value, b: Value) -> Value:
        return self.new(f"{instruction} {self.real_type} {a}, {b}")

    def add(self, a: Value, b: Value) -> Value:
        """a + b."""
        return self._binary("fadd", a, b)

    def subtract(self, a: Value, b: Value) -> Value:
        """a - b."""
        return self._binary("fsub", a, b)

    def multiply(self, a: Value, b: Value) -> Value:
        """a b."""
        return self._binary("fmul", a, b)

    def divide(self, a: Value, b: Value) -> Value:
        """a / b."""
        return self._binary("fdiv", a, b)

    def negative(self, a: Value) -> Value:
        """-a."""
        return self.new(f"fneg {self.real_type} {a}")

    def _intrinsic(self, name: str, *arguments: Value) -> Value:
        full = f"@llvm.{name}.{self._suffix}"
        self.intrinsics.add(f"declare {self.real_type} {full}({', '.join([self.real_type] * len(arguments))})")
        return self.new(f"call {self.real_type} {full}({', '.join(f'{self.real_type} {a}' for a in arguments)})")

    def fused(self, a: Value, b: Value, c: Value) -> Value:
        """a b + c with one rounding."""
        return self._intrinsic("fma", a, b, c)

    def sqrt(self, a: Value) -> Value:
        """Correctly rounded square root."""
        return self._intrinsic("sqrt", a)

    def absolute(self, a: Value) -> Value:
        """|a|."""
        return self._intrinsic("fabs", a)

    def polynomial(self, x: Value, coefficients: Sequence[Value]) -> Value:
        """coefficients[0] + coefficients[1] x + ..., by Horner's rule."""
        total = coefficients[-1]
        for coefficient in coefficients[-2::-1]:
            total = self.fused(total, x, coefficient)
        return total

    # --- integers, comparisons -----------------------------------------------------------------------------------

    def whole(self, instruction: str, a: Value, b: Value) -> Value:
        """An integer instruction: "add", "sub", "mul", "and", "or", "xor", "shl", "ashr", ..."""
        return self.new(f"{instruction} {self.integer_type} {a}, {b}")

    def bits(self, a: Value) -> Value:
        """The bits of a real number as an integer."""
        return self.new(f"bitcast {self.real_type} {a} to {self.integer_type}")

    def from_bits(self, a: Value) -> Value:
        """The real number with these bits."""
        return self.new(f"bitcast {self.integer_type} {a} to {self.real_type}")

    def compare(self, relation: str, a: Value, b: Value) -> Value:
        """A comparison of reals: "olt", "ole", ... are false for NaN, "ult", ... true."""
        return self.new(f"fcmp {relation} {self.real_type} {a}, {b}")

    def compare_whole(self, relation: str, a: Value, b: Value) -> Value:
        """A comparison of integers: "eq", "ne", "slt", ..."""
        return self.new(f"icmp {relation} {self.integer_type} {a}, {b}")

    def both(self, a: Value, b: Value) -> Value:
        """a and b."""
        return self.new(f"and {self.truth_type} {a}, {b}")

    def either(self, a: Value, b: Value) -> Value:
        """a or b."""
        return self.new(f"or {self.truth_type} {a}, {b}")

    def opposite(self, a: Value) -> Value:
        """Not a."""
        return self.new(f"xor {self.truth_type} {a}, {'true' if self.width == 1 else 'splat (i1 true)'}")

    def choose(self, condition: Value, a: Value, b: Value) -> Value:
        """a where the condition holds, else b."""
        return self.new(f"select {self.truth_type} {condition}, {self.real_type} {a}, {self.real_type} {b}")

    def larger(self, a: Value, b: Value) -> Value:
        """The larger one; b if a is NaN."""
        return self.choose(self.compare("ogt", a, b), a, b)

    def smaller(self, a: Value, b: Value) -> Value:
        """The smaller one; b if a is NaN."""
        return self.choose(self.compare("olt", a, b), a, b)

    # --- memory --------------------------------------------------------------------------------------------------

    def place(self, base: Value, index: Value | int) -> Value:
        """The address of the 8-byte number at index ``index`` of the array ``base``."""
        return self.new(f"getelementptr double, ptr {base}, i64 {index}")

    def load(self, address: Value) -> Value:
        """Loads a vector or number; vectors are aligned to 64 bytes, or to their own size if that is less."""
        return self.new(f"load {self.real_type}, ptr {address}{self._alignment()}")

    def store(self, value: Value, address: Value) -> None:
        """Stores a vector or number."""
        self.line(f"store {self.real_type} {value}, ptr {address}{self._alignment()}")

    def _alignment(self) -> str:
        return f", align {min(64, 8 * self.width)}"

    def load_whole(self, address: Value) -> Value:
        """Loads a 64-bit integer."""
        return self.new(f"load i64, ptr {address}")

    def store_whole(self, value: Value, address: Value) -> None:
        """Stores a 64-bit integer."""
        self.line(f"store i64 {value}, ptr {address}")

    def load_pointer(self, address: Value) -> Value:
        """Loads an address."""
        return self.new(f"load ptr, ptr {address}")

    def slot(self, places: int = 1) -> Value:
        """Allocates numbers, or vectors, in the function's frame, and returns their address."""
        name = f"%slot{len(self._slots)}"
        self._slots.append(f"  {name} = alloca double, i64 {places * self.width}{self._alignment()}")
        return name

    def lanes(self, truths: Value) -> Value:
        """The lanes in which a condition is true, as the bits of an integer."""
        word = f"i{self.width}"
        return self.new(f"zext {word} {self.new(f'bitcast {self.truth_type} {truths} to {word}')} to i64")

    def anywhere(self, truths: Value) -> Value:
        """True if a condition is true in any lane."""
        if self.width == 1:
            return truths
        word = f"i{self.width}"
        return self.new(f"icmp ne {word} {self.new(f'bitcast {self.truth_type} {truths} to {word}')}, 0")

    # --- control flow, by conditions that hold for all lanes alike ---------------------------------------------------

    def _label(self, name: str) -> None:
        self._lines.append(f"{name}:")
        self._block = len(self._lines)

    def _go(self, label: str) -> None:
        """Jumps to the label, whose block begins here."""
        self.line(f"br label %{label}")
        self._label(label)

    def _fresh(self, name: str) -> str:
        self._count += 1
        return f"{name}{self._count}"

    @contextmanager
    def when(self, condition: Value) -> Iterator[None]:
        """A block that runs if the condition holds."""
        inside, after = self._fresh("inside"), self._fresh("after")
        self.line(f"br i1 {condition}, label %{inside}, label %{after}")
        self._label(inside)
        yield
        self._go(after)

    @contextmanager
    def repeat(self) -> Iterator[str]:
        """A block that repeats until `leave` jumps to the label that this yields."""
        again, out = self._fresh("again"), self._fresh("out")
        self._go(again)
        yield out
        self.line(f"br label %{again}")
        self._label(out)

    @contextmanager
    def each(self, count: int) -> Iterator[Value]:
        """A block that runs for each number, which this yields, from 0 to ``count`` - 1 (``count`` at least 1).

        Thousands of equal lines in place of a loop would take the compiler seconds.
        """
        before, again, step, out = (self._fresh(name) for name in ("before", "again", "step", "out"))
        number, more = f"%{again}.number", f"%{again}.more"
        self._go(before)
        self._go(again)
        self.line(f"{number} = phi i64 [ 0, %{before} ], [ {more}, %{step} ]")
        yield number
        self._go(step)
        self.line(f"{more} = add i64 {number}, 1")
        self.line(f"br i1 {self.compare_whole('slt', more, str(count))}, label %{again}, label %{out}")
        self._label(out)

    def leave(self, label: str, condition: Value) -> None:
        """Jumps to the label if the condition holds."""
        on = self._fresh("on")
        self.line(f"br i1 {condition}, label %{label}, label %{on}")
        self._label(on)

    @contextmanager
    def leavable(self) -> Iterator[str]:
        """A block that runs once; `leave` can end it early by the label that this yields."""
        out = self._fresh("out")
        yield out
        self._go(out)

    def finish(self, value: str = "void") -> None:
        """Appends the return at the end of the text."""
        self.line(f"ret {value}")

    def finish_here(self, value: str = "void") -> None:
        """Appends a return inside a block."""
        self.finish(value)
        self._label(self._fresh("unreached"))
