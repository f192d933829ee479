"""Taylor coefficients of a graph, order by order, as vector code.

With a(t) = a_0 + a_1 h + a_2 h^2 + ... for every node, each operation gives its n-th coefficient from those of its
arguments, and the rates give the states: x_(n+1) = rate_n / (n + 1). The recurrences are those of Moore, Interval
Analysis (1966), ch. 11, collected by Jorba & Zou, Experimental Mathematics 14 (2005) 99, sec. 2; that of real powers is
in Knuth, The Art of Computer Programming 2, 4.7. A coefficient known to be zero is None, and costs nothing.

The root y of an equation F(y, ...) = 0 is corrected by Newton's method where a step begins. Its n-th coefficient
follows from that of F, which is linear in it with the factor dF/dy: F is computed with y_n = 0 first, gives y_n, and
with it what is missing in every node N of the equation, (dN/dy) y_n. Two roots whose equations contain each other are
found together: Newton's method and the n-th coefficients then take the 2 x 2 matrix of derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from gelcone.motion.engine import functions
from gelcone.motion.engine.code import Function, Value
from gelcone.physics.differentiate import block_of, derivatives
from gelcone.physics.trace import Node, ordered, partner

Coefficient = Value | None

ENOUGH = 1e-9
"""Newton's method squares its error: a correction by this share of the root, or of 1, leaves none that doubles hold."""
MOST_CORRECTIONS = 60
"""A root that follows its last value takes one; this many only without any value near it."""


@dataclass(frozen=True)
class Equation:
    """The equation of a root: ``residual`` is zero; ``first`` is where the search for the root begins. ``dependents``
    are the nodes of the residual that change with the root, the residual among them, and ``slopes`` their derivatives
    with respect to the root, ``slope`` that of the residual. ``others`` are the nodes that these are made of and that
    do not change with the root. ``block``: the roots that are found together, itself alone or one of two, whose other
    one is held in all derivatives. ``longest`` step of the search, over the root or 1."""

    root: Node
    residual: Node
    first: Node
    slope: Node
    dependents: tuple[Node, ...]
    slopes: tuple[Node, ...]
    others: tuple[Node, ...]
    block: tuple[Node, ...]
    longest: float

    def slope_of(self, residual: Node) -> Node | None:
        """The derivative of another residual of the block with respect to this root; None where there is none."""
        return next((s for node, s in zip(self.dependents, self.slopes, strict=True) if node is residual), None)


def equations_of(roots: Sequence[Node]) -> tuple[Equation, ...]:
    """The equations of all roots that nodes depend on."""
    found = []
    for root in ordered(roots):
        if root.operation == "root":
            residual, block = root.graph.equations[root.index], block_of(root)
            dependents = _moved(ordered([residual]), root)
            if residual not in dependents:
                raise ValueError(f"root {root.value!r}: its equation does not contain it")
            slopes = derivatives(dependents, root, block)
            slope = slopes[dependents.index(residual)]
            needed = ordered([residual, *slopes] if len(block) > 1 else [residual, slope])
            moved = {node.index for of in block for node in (of, *_moved(needed, of))}
            others = tuple(node for node in needed if not node.fixed and node.index not in moved)
            first = root.graph.guesses[root.index]
            longest = root.graph.longest[root.index]
            found.append(
                Equation(root, residual, first, slope, tuple(dependents), tuple(slopes), others, block, longest)
            )
    return tuple(found)


def _moved(nodes: Sequence[Node], root: Node) -> list[Node]:
    """Those of ordered nodes that change with a root."""
    moved = {root.index}
    found = []
    for node in nodes:
        if node is not root and any(argument.index in moved for argument in node.arguments):
            moved.add(node.index)
            found.append(node)
    return found


def held_values(roots: Sequence[Node]) -> list[Node]:
    """The fixed nodes, constants apart, that nodes which change take as they are, or that are roots themselves."""
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


class Jet:
    """Taylor coefficients of the states and of the border functions, emitted into ``f``.

    Parameters
    ----------
    f : the function that the code goes into.
    rates : rate of change of each state.
    borders : further nodes that are wanted, each with its highest coefficient.
    order : the highest coefficient of states and roots.
    states, time : values at the start of the step.
    held : values of the nodes of `held_values` and of the switches, by index.
    equations : those of all roots among the nodes.
    found : where the last values of the roots are held, in the order of the equations: addresses.
    """

    def __init__(
        self,
        f: Function,
        rates: Sequence[Node],
        borders: Sequence[tuple[Node, int]],
        order: int,
        states: Sequence[Value],
        time: Value,
        held: Mapping[int, Value],
        equations: Sequence[Equation] = (),
        found: Sequence[Value] = (),
    ) -> None:
        self._f = f
        self._held = held
        self._coefficients: dict[int, list[Coefficient]] = {}
        self._reciprocals: dict[int, Value] = {}
        self._weighted: dict[tuple[int, int], Value] = {}
        self._rounds: dict[int, tuple[Value, Value]] = {}
        self._slopes_by_root: dict[int, list[Value]] = {}
        followed = [*((equation.residual, order) for equation in equations), *borders]
        wanted = [*rates, *(node for node, _ in followed)]
        nodes = ordered(wanted)
        self._inlined = _single_parts(nodes, {node.index for node in wanted})
        self.states: list[list[Coefficient]] = [[value] for value in states]
        self._coefficients.update({node.index: self._leaf(node, order, time, held) for node in nodes})
        known = {node.index for node in nodes if self._coefficients[node.index] or node.operation == "root"}
        moving = [node for node in nodes if node.index not in known | self._inlined]
        addresses = {equation.root.index: address for equation, address in zip(equations, found, strict=True)}
        self._blocks = {
            equation.root.index: [own for own in equations if own.root in equation.block] for equation in equations
        }
        for equation in equations:
            own = self._blocks[equation.root.index]
            if equation is own[-1]:
                self._correct_roots(own, [addresses[one.root.index] for one in own])
        self._run(rates, followed, moving, equations, order)
        self.borders = [self._coefficients[border.index][: highest + 1] for border, highest in borders]
        self.roots = [self._coefficients[equation.root.index] for equation in equations]

    def _run(
        self,
        rates: Sequence[Node],
        followed: Sequence[tuple[Node, int]],
        moving: Sequence[Node],
        equations: Sequence[Equation],
        order: int,
    ) -> None:
        """All coefficients, order by order: of the nodes that move and the roots, and with the rates of the states."""
        f, residuals = self._f, {equation.residual.index: equation for equation in equations}
        last = dict.fromkeys((node.index for node in ordered(rates)), order - 1)
        for node, highest in followed:
            last |= {part.index: max(highest, last.get(part.index, 0)) for part in ordered([node])}
        for n in range(order + 1):
            for equation in equations if n else ():
                self._coefficients[equation.root.index].append(None)
            self._extend([node for node in moving if n <= last[node.index]], n, residuals)
            for row, rate in zip(self.states, rates, strict=True) if n < order else ():
                slope = self._coefficients[rate.index][n]
                row.append(slope if slope is None or n == 0 else f.multiply(slope, f.real(1.0 / (n + 1))))

    def _extend(self, nodes: Sequence[Node], n: int, residuals: Mapping[int, Equation]) -> None:
        """The n-th coefficients of operations, and of the roots whose residuals are among them."""
        for node in nodes:
            if len(self._coefficients[node.index]) == n:
                self._coefficients[node.index].append(self._coefficient(node, n))
            if n and node.index in residuals:
                own = self._blocks[residuals[node.index].root.index]
                if len(own) == 1:
                    self._solve_root(own[0], n)
                elif all(len(self._coefficients[one.residual.index]) > n for one in own):
                    self._solve_roots(own, n)

    # --- roots ---------------------------------------------------------------------------------------------------

    def _first(self, node: Node, values: dict[int, Value]) -> Value:
        """The value of a node at the start of the step, from those in ``values`` and those known already."""
        if node.index in values:
            return values[node.index]
        if node.operation == "constant":
            return self._f.real(node.value)
        if node.index in self._held:
            return self._held[node.index]
        known = self._coefficients.get(node.index)
        if known:
            return _known(known[0])
        arguments = [self._first(argument, values) for argument in node.arguments]
        if node.operation in ("sin", "cos") and not node.fixed:
            values[node.index] = self._of_angle(node, arguments[0])
        else:
            values[node.index] = evaluate(self._f, node, arguments)
        return values[node.index]

    def _correct_roots(self, block: Sequence[Equation], addresses: Sequence[Value]) -> None:
        """Newton's method for one root, or two that depend on each other, from the values at ``addresses``, lane by
        lane until nothing is left to correct; where none is there (NaN), from the first guess."""
        f = self._f
        for equation, address in zip(block, addresses, strict=True):
            before = f.load(address)
            unknown = f.compare("uno", before, before)
            with f.when(f.anywhere(unknown)):
                f.store(f.choose(unknown, self._first(equation.first, {}), before), address)
        others: dict[int, Value] = {}
        for node in (node for equation in block for node in equation.others):
            value = self._first(node, others)
            if not self._coefficients.get(node.index, [value]) and node.index not in self._inlined:
                self._coefficients[node.index].append(value)
        going, count = f.slot(), f.slot()
        f.store(f.real(1.0), going)
        f.store_whole("0", count)
        with f.repeat() as out:
            roots = [f.load(address) for address in addresses]
            steps = self._steps(block, roots, others)
            moves = f.compare("ogt", f.load(going), f.real(0.0))
            large = None
            for root, address, step in zip(roots, addresses, steps, strict=True):
                corrected = f.choose(moves, f.subtract(root, step), root)
                f.store(corrected, address)
                size = f.larger(f.absolute(corrected), f.real(1.0))
                moved = f.compare("ogt", f.absolute(step), f.multiply(f.real(ENOUGH), size))
                large = moved if large is None else f.either(large, moved)
            assert large is not None
            large = f.both(moves, large)
            f.store(f.choose(large, f.real(1.0), f.real(0.0)), going)
            corrections = f.new(f"add i64 {f.load_whole(count)}, 1")
            f.store_whole(corrections, count)
            f.leave(out, f.new(f"icmp sge i64 {corrections}, {MOST_CORRECTIONS}"))
            f.leave(out, f.new(f"xor i1 {f.anywhere(large)}, true"))
        for equation, address in zip(block, addresses, strict=True):
            self._coefficients[equation.root.index] = [f.load(address)]

    def _steps(self, block: Sequence[Equation], roots: Sequence[Value], others: dict[int, Value]) -> list[Value]:
        """Newton's steps of one root or two."""
        f = self._f
        values = others | {equation.root.index: root for equation, root in zip(block, roots, strict=True)}
        residuals = [self._first(equation.residual, values) for equation in block]
        if len(block) == 1:
            (equation,), (root,), (residual,) = block, roots, residuals
            slope = self._searched(equation, self._first(equation.slope, values), residual, root)
            rising = f.compare("ogt", slope, f.real(0.0))
            return [self._short(f.divide(residual, slope), root, equation, rising)]
        slopes = self._slopes_of_block(block, values)
        for k, equation in enumerate(block):
            slopes[k][k] = self._searched(equation, slopes[k][k], residuals[k], roots[k])
        inverse, determinant = self._inverse(slopes)
        rising = f.both(f.compare("ogt", determinant, f.real(0.0)), f.compare("ogt", slopes[0][0], f.real(0.0)))
        return [
            self._short(
                f.add(f.multiply(row[0], residuals[0]), f.multiply(row[1], residuals[1])), root, equation, rising
            )
            for equation, root, row in zip(block, roots, inverse, strict=True)
        ]

    def _searched(self, equation: Equation, slope: Value, residual: Value, value: Value) -> Value:
        """The slope that the search takes; where its steps are bounded, that of the residual over the root, times the
        root."""
        if equation.longest == math.inf:
            return slope
        return self._f.subtract(slope, self._f.divide(residual, value))

    def _short(self, step: Value, value: Value, equation: Equation, rising: Value) -> Value:
        """A step of the search from a value, cut to the longest, and NaN where the residual is not ``rising``; where
        its steps are not bounded, as it is."""
        f = self._f
        if equation.longest == math.inf:
            return step
        most = f.multiply(f.real(equation.longest), f.larger(f.absolute(value), f.real(1.0)))
        return f.choose(rising, f.larger(f.smaller(step, most), f.negative(most)), f.real(math.nan))

    def _slopes_of_block(self, block: Sequence[Equation], values: dict[int, Value]) -> list[list[Value]]:
        """The derivatives of two residuals by their roots."""

        def slope(of: Equation, by: Equation) -> Value:
            node = by.slope_of(of.residual)
            return self._f.real(0.0) if node is None else self._first(node, values)

        return [[slope(of, by) for by in block] for of in block]

    def _inverse(self, matrix: Sequence[Sequence[Value]]) -> tuple[list[list[Value]], Value]:
        """The inverse of a 2 x 2 matrix, and its determinant."""
        f, ((a, b), (c, d)) = self._f, matrix
        determinant = f.subtract(f.multiply(a, d), f.multiply(b, c))
        one = f.divide(f.real(1.0), determinant)
        minus = f.negative(one)
        return [[f.multiply(d, one), f.multiply(b, minus)], [f.multiply(c, minus), f.multiply(a, one)]], determinant

    def _solve_roots(self, block: Sequence[Equation], n: int) -> None:
        """The n-th coefficients of two roots that depend on each other, and with them those of what depends on them."""
        f, first = self._f, block[0].root.index
        rows = [self._coefficients[equation.residual.index] for equation in block]
        if all(row[n] is None for row in rows):
            return
        if first not in self._slopes_by_root:
            values: dict[int, Value] = {}
            flat = [value for row in self._inverse(self._slopes_of_block(block, values))[0] for value in row]
            self._slopes_by_root[first] = [
                *flat,
                *(self._first(slope, values) for equation in block for slope in equation.slopes),
            ]
        flat, left = self._slopes_by_root[first][:4], iter(self._slopes_by_root[first][4:])
        changes = [self._chain([(flat[2 * i], rows[0][n]), (flat[2 * i + 1], rows[1][n])]) for i in range(2)]
        own = [f.negative(_known(change)) for change in changes]
        for equation, change in zip(block, own, strict=True):
            self._coefficients[equation.root.index][n] = change
            for node in equation.dependents:
                slope, row = next(left), self._coefficients[node.index]
                if node.index not in self._inlined and len(row) > n:
                    row[n] = self._chain([(slope, change)], row[n])
        for row in rows:
            row[n] = None

    def _solve_root(self, equation: Equation, n: int) -> None:
        """The n-th coefficient of a root, and with it those of what depends on it."""
        f = self._f
        residual = self._coefficients[equation.residual.index]
        if residual[n] is None:
            return
        if equation.root.index not in self._slopes_by_root:
            values: dict[int, Value] = {}
            slopes = [self._first(slope, values) for slope in equation.slopes]
            inverse = f.divide(f.real(-1.0), self._first(equation.slope, values))
            self._slopes_by_root[equation.root.index] = [inverse, *slopes]
        inverse, *slopes = self._slopes_by_root[equation.root.index]
        own = f.multiply(_known(residual[n]), inverse)
        self._coefficients[equation.root.index][n] = own
        for node, slope in zip(equation.dependents, slopes, strict=True):
            row = self._coefficients[node.index]
            if node.index not in self._inlined:
                row[n] = self._chain([(slope, own)], row[n])
        residual[n] = None

    def _leaf(self, node: Node, order: int, time: Value, held: Mapping[int, Value]) -> list[Coefficient]:
        """The coefficients of a leaf or of what is fixed; none yet of other nodes."""
        if node.operation == "state":
            return self.states[node.value]
        if node.operation == "root":
            return []
        if node.operation == "time":
            return [time, self._f.real(1.0), *[None] * (order - 1)]
        if node.operation == "constant":
            return [self._f.real(node.value), *[None] * order]
        if node.fixed or node.operation == "switch":
            return [held.get(node.index), *[None] * order]
        return []

    def _coefficient(self, node: Node, n: int) -> Coefficient:
        """The n-th coefficient of an operation."""
        f = self._f
        own = self._coefficients[node.index]
        if node.operation == "multiply":
            return self._product(node, n, None, False)
        if node.operation in ("add", "subtract"):
            return self._sum(node, n)
        a = self._coefficients[node.arguments[0].index]
        if node.operation == "divide":
            # q_n = (a_n - sum_(j=1..n) b_j q_(n-j)) / b_0
            divisor = node.arguments[1]
            b = self._coefficients[divisor.index]
            if n == 0:
                return f.divide(_known(a[0]), _known(b[0]))
            total = self._chain([(b[j], own[n - j]) for j in _oldest_first(1, n, n)])
            return self._times(self._difference(a[n], total), self._reciprocal(divisor))
        if node.operation in ("sin", "cos"):
            # s_n = (1/n) sum_(j=1..n) j a_j c_(n-j), c_n = -(1/n) sum_(j=1..n) j a_j s_(n-j)
            if n == 0:
                return self._of_angle(node, _known(a[0]))
            other = self._coefficients[partner(node).index]
            return self._times(
                self._slopes(node.arguments[0], other, n), f.real((1.0 if node.operation == "sin" else -1.0) / n)
            )
        if n == 0:
            arguments = [_known(self._coefficients[argument.index][0]) for argument in node.arguments]
            return evaluate(f, node, arguments)
        if node.operation == "sqrt":
            # s_n = (a_n - sum_(j=1..n-1) s_j s_(n-j)) / (2 s_0)
            total = self._square(own, n, None, False, inner=True)
            return self._times(self._difference(a[n], total), f.multiply(f.real(0.5), self._reciprocal(node)))
        if node.operation == "exp":
            # e_n = (1/n) sum_(j=1..n) j a_j e_(n-j)
            return self._times(self._slopes(node.arguments[0], own, n), f.real(1.0 / n))
        return self._power(node, n) if node.operation == "power" else self._logarithm(node, n)

    def _power(self, node: Node, n: int) -> Coefficient:
        """r_n = sum_(j=1..n) (p j - (n - j)) a_j r_(n-j) / (n a_0)."""
        f, own = self._f, self._coefficients[node.index]
        a = self._coefficients[node.arguments[0].index]
        exponent = _known(self._coefficients[node.arguments[1].index][0])
        terms = [
            (f.multiply(f.fused(exponent, f.real(float(j)), f.real(float(j - n))), _known(a[j])), own[n - j])
            for j in range(1, n + 1)
            if a[j] is not None and own[n - j] is not None
        ]
        total = self._times(self._chain(terms), f.real(1.0 / n))
        return self._times(total, self._reciprocal(node.arguments[0]))

    def _logarithm(self, node: Node, n: int) -> Coefficient:
        """l_n = (a_n - (1/n) sum_(j=1..n-1) j l_j a_(n-j)) / a_0, with 1 + a_0 in place of a_0 for log1p."""
        f, argument = self._f, node.arguments[0]
        a = self._coefficients[argument.index]
        total = self._chain([(self._weight(node, j), a[n - j]) for j in _oldest_first(1, n - 1, n)])
        if node.operation == "log1p":
            argument = argument.graph.add(1.0, argument)
            self._coefficients.setdefault(argument.index, [f.add(f.real(1.0), _known(a[0]))])
        return self._times(self._difference(a[n], self._times(total, f.real(1.0 / n))), self._reciprocal(argument))

    def _of_angle(self, node: Node, angle: Value) -> Value:
        """Sine or cosine, which come together."""
        place = node.arguments[0].index
        if place not in self._rounds:
            self._rounds[place] = functions.sine_cosine(self._f, angle)
        return self._rounds[place][node.operation == "cos"]

    # --- sums and products ---------------------------------------------------------------------------------------

    def _sum(self, node: Node, n: int) -> Coefficient:
        """s_n = a_n + b_n or a_n - b_n; products that only this sum takes become links of its chain."""
        total: Coefficient = None
        parts = [(node.arguments[0], False), (node.arguments[1], node.operation == "subtract")]
        for part, negative in sorted(parts, key=lambda pair: self._is_link(pair[0]) or pair[1]):
            if self._is_link(part):
                total = self._product(part, n, total, negative)
            elif part.index in self._inlined:
                total = self._plus(total, self._sum(part, n), negative)
            else:
                total = self._plus(total, self._coefficients[part.index][n], negative)
        return total

    def _is_link(self, node: Node) -> bool:
        return node.operation == "multiply" and node.index in self._inlined

    def _product(self, node: Node, n: int, start: Coefficient, negative: bool) -> Coefficient:
        """start +- p_n, p_n = sum_(j=0..n) a_j b_(n-j)."""
        f = self._f
        a, b = (self._coefficients[argument.index] for argument in node.arguments)
        if node.arguments[0] is node.arguments[1]:
            return self._square(a, n, start, negative)
        if node.arguments[1].fixed:
            a, b = b, a
        if node.arguments[0].fixed or node.arguments[1].fixed:
            factor = _known(a[0])
            return self._chain([(f.negative(factor) if negative else factor, b[n])], start)
        total = self._chain([(a[j], b[n - j]) for j in _oldest_first(0, n, n)], None if negative else start)
        return self._plus(start, total, True) if negative else total

    def _square(
        self, a: Sequence[Coefficient], n: int, start: Coefficient, negative: bool, inner: bool = False
    ) -> Coefficient:
        """start +- sum_(j=0..n) a_j a_(n-j), each mixed product once; ``inner`` leaves j = 0 and j = n out."""
        f = self._f
        lowest = 1 if inner else 0
        total = start
        if n % 2 == 0 and n // 2 >= lowest and a[n // 2] is not None:
            middle = _known(a[n // 2])
            total = self._chain([(f.negative(middle) if negative else middle, middle)], total)
        mixed = self._chain([(a[j], a[n - j]) for j in range((n - 1) // 2, lowest - 1, -1)])
        return total if mixed is None else self._chain([(f.real(-2.0 if negative else 2.0), mixed)], total)

    def _slopes(self, argument: Node, other: Sequence[Coefficient], n: int) -> Coefficient:
        """sum_(j=1..n) j a_j other_(n-j)."""
        return self._chain([(self._weight(argument, j), other[n - j]) for j in _oldest_first(1, n, n)])

    def _weight(self, node: Node, j: int) -> Coefficient:
        """j a_j."""
        value = self._coefficients[node.index][j]
        if j == 1 or value is None:
            return value
        if (node.index, j) not in self._weighted:
            self._weighted[node.index, j] = self._f.multiply(self._f.real(float(j)), value)
        return self._weighted[node.index, j]

    def _reciprocal(self, node: Node) -> Value:
        """1 / a_0, which all quotients by the same node share."""
        if node.index not in self._reciprocals:
            first = _known(self._coefficients[node.index][0])
            self._reciprocals[node.index] = self._f.divide(self._f.real(1.0), first)
        return self._reciprocals[node.index]

    def _chain(self, terms: Sequence[tuple[Coefficient, Coefficient]], start: Coefficient = None) -> Coefficient:
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


def _single_parts(nodes: Sequence[Node], wanted: set[int]) -> set[int]:
    """Products and sums that one sum alone takes."""
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
    """j from ``low`` to ``high`` so that the products of coefficients j and n - j known longest come first."""
    return sorted(range(low, high + 1), key=lambda j: -min(j, n - j))


def _known(value: Coefficient) -> Value:
    if value is None:
        raise ValueError("a first coefficient is never left out")
    return value
