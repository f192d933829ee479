"""Exact first derivatives of formulas by dual numbers: value + sum of part_i e_i with e_i e_j = 0.

They run over floats, arrays, SymPy symbols and the expressions of the compiled program alike. Griewank and Walther,
Evaluating Derivatives (2008), chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np


class Dual:
    """A value with its partial derivatives by some variables; a part that is the float 0.0 is left out of the work."""

    __array_ufunc__ = None  # an array on the left leaves the operation to this class
    __slots__ = ("parts", "value")

    def __init__(self, value: Any, parts: Iterable[Any]):
        self.value, self.parts = value, tuple(parts)

    def _chain(self, value: Any, slope: Any) -> Dual:
        return Dual(value, [_times(slope, part) for part in self.parts])

    def __add__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value + other.value, map(_plus, self.parts, other.parts))
        return Dual(self.value + other, self.parts)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return self._chain(-self.value, -1.0)

    def __sub__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value - other.value, map(_plus, self.parts, (-other).parts))
        return Dual(self.value - other, self.parts)

    def __rsub__(self, other: Any) -> Dual:
        return Dual(other - self.value, (-self).parts)

    def __mul__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            left = [_times(other.value, part) for part in self.parts]
            right = [_times(self.value, part) for part in other.parts]
            return Dual(self.value * other.value, map(_plus, left, right))
        return self._chain(self.value * other, other)

    def __rmul__(self, other: Any) -> Dual:
        return self._chain(other * self.value, other)

    def __truediv__(self, other: Any) -> Dual:
        if not isinstance(other, Dual):
            return self._chain(self.value / other, 1.0 / other)
        quotient, inverse = self.value / other.value, 1.0 / other.value
        left = [_times(inverse, part) for part in self.parts]
        right = [_times(-(quotient * inverse), part) for part in other.parts]
        return Dual(quotient, map(_plus, left, right))

    def __rtruediv__(self, other: Any) -> Dual:
        quotient = other / self.value
        return self._chain(quotient, -(quotient / self.value))

    def __pow__(self, power: Any) -> Dual:
        return self._chain(self.value**power, power * self.value ** (power - 1))


def _is_zero(part: Any) -> bool:
    return isinstance(part, float) and part == 0.0


def _times(factor: Any, part: Any) -> Any:
    if _is_zero(part) or _is_zero(factor):
        return 0.0
    return factor if isinstance(part, float) and part == 1.0 else factor * part


def _plus(one: Any, other: Any) -> Any:
    return other if _is_zero(one) else one if _is_zero(other) else one + other


class Functions:
    """The functions of a namespace, for duals and for what is none."""

    def __init__(self, xp: Any):
        self.inner = xp

    def _apply(self, name: str, z: Any, slope: Callable[[Any, Any], Any]) -> Any:
        function = getattr(self.inner, name)
        if not isinstance(z, Dual):
            return function(z)
        value = function(z.value)
        return z._chain(value, slope(z.value, value))

    def sin(self, z: Any) -> Any:
        return self._apply("sin", z, lambda at, _: self.inner.cos(at))

    def cos(self, z: Any) -> Any:
        return self._apply("cos", z, lambda at, _: -self.inner.sin(at))

    def exp(self, z: Any) -> Any:
        return self._apply("exp", z, lambda _, value: value)

    def log(self, z: Any) -> Any:
        return self._apply("log", z, lambda at, _: 1.0 / at)

    def log1p(self, z: Any) -> Any:
        return self._apply("log1p", z, lambda at, _: 1.0 / (1.0 + at))

    def sqrt(self, z: Any) -> Any:
        return self._apply("sqrt", z, lambda _, value: 0.5 / value)


def plain(z: Any) -> Any:
    """The value of a dual number; anything else as it is."""
    return z.value if isinstance(z, Dual) else z


def gradients(function: Callable[[list[Any], Any], Sequence[Any]], at: Sequence[Any], xp: Any = np) -> list[list[Any]]:
    """Partial derivatives [i][j] of the i-th value of ``function(variables, xp)`` by the j-th variable."""
    count = len(at)
    seeds = [Dual(value, [float(i == j) for j in range(count)]) for i, value in enumerate(at)]
    values = function(list(seeds), Functions(xp))
    return [list(value.parts) if isinstance(value, Dual) else [0.0] * count for value in values]


def derivative(function: Callable[[Any, Any], Any], at: Any) -> Any:
    """Derivative of ``function(variable, xp)`` by its variable."""
    return gradients(lambda variables, xp: [function(variables[0], xp)], [at])[0][0]
