"""Taylor coefficients of the states, border functions and roots of a law, order by order, as vector code.

The rates give the states, x_(n+1) = rate_n / (n + 1), and the operations their coefficients by `recurrences`. The root
y of an equation F(y, ...) = 0 is corrected by Newton's method where a step begins. Its n-th coefficient follows from
that of F, which is linear in it with the factor dF/dy: F is computed with y_n = 0 first, which gives y_n, and with it
(dN/dy) y_n is added to the coefficient of every node N of the equation. Two roots whose equations contain each other
are found together: Newton's method and the n-th coefficients then take the 2 x 2 matrix of derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from gelcone.motion.engine.code import Function, Value
from gelcone.motion.engine.equations import Equation
from gelcone.motion.engine.recurrences import Coefficient, Recurrences, evaluate, present, single_parts
from gelcone.physics.trace import Node, ordered

ENOUGH = 1e-9
"""Largest correction, over the root or 1, after which Newton's method has converged to rounding: it squares errors."""
MOST_CORRECTIONS = 60
"""Most corrections of a root, for one without a value nearby; one that follows its last value takes one."""


class Jet:
    """Taylor coefficients of the states, border functions and roots, emitted into ``f``.

    Parameters
    ----------
    f : the function that the code goes into.
    rates : rate of change of each state.
    borders : further nodes, each with its highest coefficient.
    order : the highest coefficient of states and roots.
    states, time : values at the start of the step.
    held : values of the nodes of `held_values` and of the switches, by index.
    equations : those of all roots among the nodes.
    found : addresses of the last values of the roots, in the order of the equations.
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
        self._solutions: dict[int, tuple[list[list[Value]], list[Value]]] = {}
        followed = [*((equation.residual, order) for equation in equations), *borders]
        targets = [*rates, *(node for node, _ in followed)]
        nodes = ordered(targets)
        self._series = Recurrences(f, single_parts(nodes, {node.index for node in targets}))
        self._rows = self._series.rows
        self.states: list[list[Coefficient]] = [[value] for value in states]
        self._rows.update({node.index: self._leaf(node, order, time, held) for node in nodes})
        known = {node.index for node in nodes if self._rows[node.index] or node.operation == "root"}
        moving = [node for node in nodes if node.index not in known | self._series.inlined]
        addresses = {equation.root.index: address for equation, address in zip(equations, found, strict=True)}
        self._blocks = {
            equation.root.index: [own for own in equations if own.root in equation.block] for equation in equations
        }
        for equation in equations:
            own = self._blocks[equation.root.index]
            if equation is own[-1]:
                self._correct_roots(own, [addresses[one.root.index] for one in own])
        self._run(rates, followed, moving, equations, order)
        self.borders = [self._rows[border.index][: highest + 1] for border, highest in borders]
        self.roots = [self._rows[equation.root.index] for equation in equations]

    def _run(
        self,
        rates: Sequence[Node],
        followed: Sequence[tuple[Node, int]],
        moving: Sequence[Node],
        equations: Sequence[Equation],
        order: int,
    ) -> None:
        """Emits all coefficients, order by order: those of moving nodes and roots, then, from the rates, of states."""
        f, residuals = self._f, {equation.residual.index: equation for equation in equations}
        last = dict.fromkeys((node.index for node in ordered(rates)), order - 1)
        for node, highest in followed:
            last |= {part.index: max(highest, last.get(part.index, 0)) for part in ordered([node])}
        for n in range(order + 1):
            for equation in equations if n else ():
                self._rows[equation.root.index].append(None)
            self._extend([node for node in moving if n <= last[node.index]], n, residuals)
            for row, rate in zip(self.states, rates, strict=True) if n < order else ():
                slope = self._rows[rate.index][n]
                row.append(slope if slope is None or n == 0 else f.multiply(slope, f.real(1.0 / (n + 1))))

    def _extend(self, nodes: Sequence[Node], n: int, residuals: Mapping[int, Equation]) -> None:
        """Emits the n-th coefficients of operations, and of the roots whose residuals are among them."""
        for node in nodes:
            if len(self._rows[node.index]) == n:
                self._rows[node.index].append(self._series.coefficient(node, n))
            if n and node.index in residuals:
                block = self._blocks[residuals[node.index].root.index]
                if all(len(self._rows[equation.residual.index]) > n for equation in block):
                    self._solve_roots(block, n)

    # --- roots ---------------------------------------------------------------------------------------------------

    def _first(self, node: Node, values: dict[int, Value]) -> Value:
        """The value of a node at the start of the step; ``values`` are those known besides first coefficients."""
        if node.index in values:
            return values[node.index]
        if node.operation == "constant":
            return self._f.real(node.value)
        if node.index in self._held:
            return self._held[node.index]
        known = self._rows.get(node.index)
        if known:
            return present(known[0])
        arguments = [self._first(argument, values) for argument in node.arguments]
        if node.operation in ("sin", "cos") and not node.fixed:
            values[node.index] = self._series.of_angle(node, arguments[0])
        else:
            values[node.index] = evaluate(self._f, node, arguments)
        return values[node.index]

    def _correct_roots(self, block: Sequence[Equation], addresses: Sequence[Value]) -> None:
        """Corrects one root, or two that depend on each other, by Newton's method until each lane has converged.

        It starts from the values at ``addresses``, or from the first guess if these are NaN.
        """
        f = self._f
        for equation, address in zip(block, addresses, strict=True):
            before = f.load(address)
            unknown = f.compare("uno", before, before)
            with f.when(f.anywhere(unknown)):
                f.store(f.choose(unknown, self._first(equation.first, {}), before), address)
        others: dict[int, Value] = {}
        for node in (node for equation in block for node in equation.others):
            value = self._first(node, others)
            if not self._rows.get(node.index, [value]) and node.index not in self._series.inlined:
                self._rows[node.index].append(value)
        unfinished, count = f.slot(), f.slot()
        f.store(f.real(1.0), unfinished)
        f.store_whole("0", count)
        with f.repeat() as out:
            roots = [f.load(address) for address in addresses]
            steps = self._steps(block, roots, others)
            moves = f.compare("ogt", f.load(unfinished), f.real(0.0))
            large = None
            for root, address, step in zip(roots, addresses, steps, strict=True):
                corrected = f.choose(moves, f.subtract(root, step), root)
                f.store(corrected, address)
                size = f.larger(f.absolute(corrected), f.real(1.0))
                moved = f.compare("ogt", f.absolute(step), f.multiply(f.real(ENOUGH), size))
                large = moved if large is None else f.either(large, moved)
            assert large is not None
            large = f.both(moves, large)
            f.store(f.choose(large, f.real(1.0), f.real(0.0)), unfinished)
            corrections = f.new(f"add i64 {f.load_whole(count)}, 1")
            f.store_whole(corrections, count)
            f.leave(out, f.new(f"icmp sge i64 {corrections}, {MOST_CORRECTIONS}"))
            f.leave(out, f.new(f"xor i1 {f.anywhere(large)}, true"))
        for equation, address in zip(block, addresses, strict=True):
            self._rows[equation.root.index] = [f.load(address)]

    def _steps(self, block: Sequence[Equation], roots: Sequence[Value], others: dict[int, Value]) -> list[Value]:
        """Steps of Newton's method for one root or two."""
        f = self._f
        values = others | {equation.root.index: root for equation, root in zip(block, roots, strict=True)}
        residuals = [self._first(equation.residual, values) for equation in block]
        if len(block) == 1:
            (equation,), (root,), (residual,) = block, roots, residuals
            slope = self._search_slope(equation, self._first(equation.slope, values), residual, root)
            rising = f.compare("ogt", slope, f.real(0.0))
            return [self._bounded(f.divide(residual, slope), root, equation, rising)]
        slopes = self._slopes_of_block(block, values)
        for k, equation in enumerate(block):
            slopes[k][k] = self._search_slope(equation, slopes[k][k], residuals[k], roots[k])
        inverse, determinant = self._inverse(slopes)
        rising = f.both(f.compare("ogt", determinant, f.real(0.0)), f.compare("ogt", slopes[0][0], f.real(0.0)))
        return [
            self._bounded(
                f.add(f.multiply(row[0], residuals[0]), f.multiply(row[1], residuals[1])), root, equation, rising
            )
            for equation, root, row in zip(block, roots, inverse, strict=True)
        ]

    def _search_slope(self, equation: Equation, slope: Value, residual: Value, value: Value) -> Value:
        """The slope of the residual, or, for bounded steps, that of the residual over the root, times the root."""
        if equation.longest == math.inf:
            return slope
        return self._f.subtract(slope, self._f.divide(residual, value))

    def _bounded(self, step: Value, value: Value, equation: Equation, rising: Value) -> Value:
        """A step from a value, cut to the longest, and NaN where the residual is not ``rising``; steps of a search
        without a longest one are left as they are."""
        f = self._f
        if equation.longest == math.inf:
            return step
        most = f.multiply(f.real(equation.longest), f.larger(f.absolute(value), f.real(1.0)))
        return f.choose(rising, f.larger(f.smaller(step, most), f.negative(most)), f.real(math.nan))

    def _slopes_of_block(self, block: Sequence[Equation], values: dict[int, Value]) -> list[list[Value]]:
        """The matrix of derivatives of the residuals of a block with respect to its roots."""

        def slope(of: Equation, by: Equation) -> Value:
            node = by.slope_of(of.residual)
            return self._f.real(0.0) if node is None else self._first(node, values)

        return [[slope(of, by) for by in block] for of in block]

    def _inverse(self, matrix: Sequence[Sequence[Value]]) -> tuple[list[list[Value]], Value]:
        """The inverse of a matrix of one row or two, and its determinant."""
        f = self._f
        if len(matrix) == 1:
            return [[f.divide(f.real(1.0), matrix[0][0])]], matrix[0][0]
        (a, b), (c, d) = matrix
        determinant = f.subtract(f.multiply(a, d), f.multiply(b, c))
        one = f.divide(f.real(1.0), determinant)
        minus = f.negative(one)
        return [[f.multiply(d, one), f.multiply(b, minus)], [f.multiply(c, minus), f.multiply(a, one)]], determinant

    def _solve_roots(self, block: Sequence[Equation], n: int) -> None:
        """Sets the n-th coefficients of one root, or of two that depend on each other, and corrects those of their
        dependents."""
        f, series, first = self._f, self._series, block[0].root.index
        rows = [self._rows[equation.residual.index] for equation in block]
        if all(row[n] is None for row in rows):
            return
        if first not in self._solutions:
            values: dict[int, Value] = {}
            inverse, _ = self._inverse(self._slopes_of_block(block, values))
            self._solutions[first] = inverse, [self._first(s, values) for equation in block for s in equation.slopes]
        inverse, slopes = self._solutions[first]
        terms = [[(value, row[n]) for value, row in zip(line, rows, strict=True)] for line in inverse]
        coefficients, slopes_left = [f.negative(present(series.chain(pairs))) for pairs in terms], iter(slopes)
        for equation, coefficient in zip(block, coefficients, strict=True):
            self._rows[equation.root.index][n] = coefficient
            for node in equation.dependents:
                slope, row = next(slopes_left), self._rows[node.index]
                if node.index not in series.inlined and len(row) > n:
                    row[n] = series.chain([(slope, coefficient)], row[n])
        for row in rows:
            row[n] = None

    def _leaf(self, node: Node, order: int, time: Value, held: Mapping[int, Value]) -> list[Coefficient]:
        """The coefficients of a leaf or a fixed node; an empty list for other nodes."""
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
