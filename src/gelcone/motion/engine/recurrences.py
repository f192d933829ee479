"""Recurrences for the Taylor coefficients of a graph's operations, as vector code.

With a(t) = a_0 + a_1 h + a_2 h^2 + ... for every node, each operation gives its n-th coefficient from those of its
arguments. The recurrences are those of Moore, Interval Analysis (1966), ch. 11, collected by Jorba & Zou, Experimental
Mathematics 14 (2005) 99, sec. 2; that of real powers is in Knuth, The Art of Computer Programming 2, 4.7. A coefficient
known to be zero is None and costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gelcone.motion.engine import functions
from gelcone.motion.engine.code import Function, Value
from gelcone.physics.trace import Node, ordered, partner

Coefficient = Value | None


def held_values(roots: Sequence[Node]) -> list[Node]:
    """The fixed nodes, except constants, that are arguments of moving nodes or among ``roots``."""
    nodes = ordered(roots)
    taken = {a.index for node in nodes if not node.fixed for a in node.arguments} | {root.index for root in roots}
    return [node for node in nodes if node.fixed and node.operation != "constant" and node.index in taken]


def evaluate(f: Function, node: Node, values: Sequence[Value]) -> Value:
    """The value of a node from those of its arguments."""
    operation = node.operation
    if operation == "constant":
        return f.real(node.value)
    if operation in ("add", "subtract", "multiply", "divide", "sqrt"):
        value: Value = getattr(f, operation)(*values)
        return value
    return _FUNCTIONS[operation](f, *values)


_FUNCTIONS: dict[str, Callable[..., Value]] = {
    "power": functions.power,
    "exp": functions.exponential,
    "log": lambda f, value: functions.logarithm(f, value)[0],
    "log1p": functions.logarithm_of_one_plus,
    "sin": lambda f, angle: functions.sine_cosine(f, angle)[0],
    "cos": lambda f, angle: functions.sine_cosine(f, angle)[1],
}


def fixed_values(f: Function, nodes: Sequence[Node], load: Callable[[str], Value]) -> dict[int, Value]:
    """Values, by index, of the fixed ones among nodes and their arguments; ``load`` loads the number of a name."""
    values: dict[int, Value] = {}
    for node in ordered(nodes):
        if node.operation == "number":
            values[node.index] = load(node.value)
        elif node.fixed:
            values[node.index] = evaluate(f, node, [values[argument.index] for argument in node.arguments])
    return values


class Recurrences:
    """Coefficients of operations, each from those of its arguments, emitted into ``f``.

    ``rows`` holds the coefficients known so far by the index of their node; ``inlined`` the indices of products and
    sums that become links of the chain of the one sum that takes them, see `single_parts`.
    """

    def __init__(self, f: Function, inlined: set[int]) -> None:
        self._f, self.inlined = f, inlined
        self.rows: dict[int, list[Coefficient]] = {}
        self._reciprocals: dict[int, Value] = {}
        self._weighted: dict[tuple[int, int], Value] = {}
        self._angles: dict[int, tuple[Value, Value]] = {}

    def coefficient(self, node: Node, n: int) -> Coefficient:
        """The n-th coefficient of an operation."""
        f = self._f
        row = self.rows[node.index]
        if node.operation == "multiply":
            return self._product(node, n, None, False)
        if node.operation in ("add", "subtract"):
            return self._sum(node, n)
        a = self.rows[node.arguments[0].index]
        if node.operation == "divide":
            # q_n = (a_n - sum_(j=1..n) b_j q_(n-j)) / b_0
            divisor = node.arguments[1]
            b = self.rows[divisor.index]
            if n == 0:
                return f.divide(present(a[0]), present(b[0]))
            total = self.chain([(b[j], row[n - j]) for j in _oldest_first(1, n, n)])
            return self._times(self._difference(a[n], total), self._reciprocal(divisor))
        if node.operation in ("sin", "cos"):
            # s_n = (1/n) sum_(j=1..n) j a_j c_(n-j), c_n = -(1/n) sum_(j=1..n) j a_j s_(n-j)
            if n == 0:
                return self.of_angle(node, present(a[0]))
            other = self.rows[partner(node).index]
            return self._times(
                self._slopes(node.arguments[0], other, n), f.real((1.0 if node.operation == "sin" else -1.0) / n)
            )
        if n == 0:
            arguments = [present(self.rows[argument.index][0]) for argument in node.arguments]
            return evaluate(f, node, arguments)
        if node.operation == "sqrt":
            # s_n = (a_n - sum_(j=1..n-1) s_j s_(n-j)) / (2 s_0)
            total = self._square(row, n, None, False, inner=True)
            return self._times(self._difference(a[n], total), f.multiply(f.real(0.5), self._reciprocal(node)))
        if node.operation == "exp":
            # e_n = (1/n) sum_(j=1..n) j a_j e_(n-j)
            return self._times(self._slopes(node.arguments[0], row, n), f.real(1.0 / n))
        return self._power(node, n) if node.operation == "power" else self._logarithm(node, n)

    def _power(self, node: Node, n: int) -> Coefficient:
        """r_n = sum_(j=1..n) (p j - (n - j)) a_j r_(n-j) / (n a_0)."""
        f, row = self._f, self.rows[node.index]
        a = self.rows[node.arguments[0].index]
        exponent = present(self.rows[node.arguments[1].index][0])
        terms = [
            (f.multiply(f.fused(exponent, f.real(float(j)), f.real(float(j - n))), present(a[j])), row[n - j])
            for j in range(1, n + 1)
            if a[j] is not None and row[n - j] is not None
        ]
        total = self._times(self.chain(terms), f.real(1.0 / n))
        return self._times(total, self._reciprocal(node.arguments[0]))

    def _logarithm(self, node: Node, n: int) -> Coefficient:
        """l_n = (a_n - (1/n) sum_(j=1..n-1) j l_j a_(n-j)) / a_0, with 1 + a_0 in place of a_0 for log1p."""
        f, argument = self._f, node.arguments[0]
        a = self.rows[argument.index]
        total = self.chain([(self._weight(node, j), a[n - j]) for j in _oldest_first(1, n - 1, n)])
        if node.operation == "log1p":
            argument = argument.graph.add(1.0, argument)
            self.rows.setdefault(argument.index, [f.add(f.real(1.0), present(a[0]))])
        return self._times(self._difference(a[n], self._times(total, f.real(1.0 / n))), self._reciprocal(argument))

    def of_angle(self, node: Node, angle: Value) -> Value:
        """Sine or cosine of an angle; both are emitted together, once."""
        place = node.arguments[0].index
        if place not in self._angles:
            self._angles[place] = functions.sine_cosine(self._f, angle)
        return self._angles[place][node.operation == "cos"]

    # --- sums and products ---------------------------------------------------------------------------------------

    def _sum(self, node: Node, n: int) -> Coefficient:
        """s_n = a_n + b_n or a_n - b_n; products inlined into the sum become links of its chain."""
        total: Coefficient = None
        parts = [(node.arguments[0], False), (node.arguments[1], node.operation == "subtract")]
        for part, negative in sorted(parts, key=lambda pair: self._is_link(pair[0]) or pair[1]):
            if self._is_link(part):
                total = self._product(part, n, total, negative)
            elif part.index in self.inlined:
                total = self._plus(total, self._sum(part, n), negative)
            else:
                total = self._plus(total, self.rows[part.index][n], negative)
        return total

    def _is_link(self, node: Node) -> bool:
        return node.operation == "multiply" and node.index in self.inlined

    def _product(self, node: Node, n: int, start: Coefficient, negative: bool) -> Coefficient:
        """start +- p_n, p_n = sum_(j=0..n) a_j b_(n-j)."""
        f = self._f
        a, b = (self.rows[argument.index] for argument in node.arguments)
        if node.arguments[0] is node.arguments[1]:
            return self._square(a, n, start, negative)
        if node.arguments[1].fixed:
            a, b = b, a
        if node.arguments[0].fixed or node.arguments[1].fixed:
            factor = present(a[0])
            return self.chain([(f.negative(factor) if negative else factor, b[n])], start)
        total = self.chain([(a[j], b[n - j]) for j in _oldest_first(0, n, n)], None if negative else start)
        return self._plus(start, total, True) if negative else total

    def _square(
        self, a: Sequence[Coefficient], n: int, start: Coefficient, negative: bool, inner: bool = False
    ) -> Coefficient:
        """start +- sum_(j=0..n) a_j a_(n-j), each mixed product once; ``inner`` omits j = 0 and j = n."""
        f = self._f
        lowest = 1 if inner else 0
        total = start
        if n % 2 == 0 and n // 2 >= lowest and a[n // 2] is not None:
            middle = present(a[n // 2])
            total = self.chain([(f.negative(middle) if negative else middle, middle)], total)
        mixed = self.chain([(a[j], a[n - j]) for j in range((n - 1) // 2, lowest - 1, -1)])
        return total if mixed is None else self.chain([(f.real(-2.0 if negative else 2.0), mixed)], total)

    def _slopes(self, argument: Node, other: Sequence[Coefficient], n: int) -> Coefficient:
        """sum_(j=1..n) j a_j other_(n-j)."""
        return self.chain([(self._weight(argument, j), other[n - j]) for j in _oldest_first(1, n, n)])

    def _weight(self, node: Node, j: int) -> Coefficient:
        """j a_j."""
        value = self.rows[node.index][j]
        if j == 1 or value is None:
            return value
        if (node.index, j) not in self._weighted:
            self._weighted[node.index, j] = self._f.multiply(self._f.real(float(j)), value)
        return self._weighted[node.index, j]

    def _reciprocal(self, node: Node) -> Value:
        """1 / a_0, emitted once for each divisor."""
        if node.index not in self._reciprocals:
            first = present(self.rows[node.index][0])
            self._reciprocals[node.index] = self._f.divide(self._f.real(1.0), first)
        return self._reciprocals[node.index]

    def chain(self, terms: Sequence[tuple[Coefficient, Coefficient]], start: Coefficient = None) -> Coefficient:
        """start + a b + ... for all pairs, by fused multiply-adds."""
        total = start
        for a, b in terms:
            if a is not None and b is not None:
                total = self._f.multiply(a, b) if total is None else self._f.fused(a, b, total)
        return total

    def _plus(self, a: Coefficient, b: Coefficient, negative: bool) -> Coefficient:
        if b is None:
            return a
        if a is None:
            return self._f.negative(b) if negative else b
        return self._f.subtract(a, b) if negative else self._f.add(a, b)

    def _difference(self, a: Coefficient, b: Coefficient) -> Coefficient:
        return self._plus(a, b, True)

    def _times(self, a: Coefficient, factor: Value) -> Coefficient:
        return None if a is None else self._f.multiply(a, factor)


def single_parts(nodes: Sequence[Node], wanted: set[int]) -> set[int]:
    """Indices of products and sums whose only use is in one sum."""
    uses: dict[int, int] = {}
    for node in nodes:
        for argument in node.arguments:
            uses[argument.index] = uses.get(argument.index, 0) + 1
    return {
        a.index
        for node in nodes
        if not node.fixed and node.operation in ("add", "subtract")
        for a in node.arguments
        if a.operation in ("multiply", "add", "subtract")
        and not a.fixed
        and uses[a.index] == 1
        and a.index not in wanted
    }


def _oldest_first(low: int, high: int, n: int) -> list[int]:
    """The j from ``low`` to ``high``, those first whose coefficients j and n - j have been known longest."""
    return sorted(range(low, high + 1), key=lambda j: -min(j, n - j))


def present(value: Coefficient) -> Value:
    """A coefficient that is never None, such as a first one."""
    if value is None:
        raise ValueError("a first coefficient is never left out")
    return value
