"""Formulas of the force of a film, for numbers, arrays or the expressions of a program.

With s = x^2, the squared voltage V, p = -(s + c)^e and u, p scaled to run from -1 to 1, a film pulls the disc back with
x k,

    k = base [P(u, q) + rim^2 P1(u, q) + whole^2 P2(u, q)],

in two pieces. The ``near`` piece covers heights at which the film falls slack as the voltage rises, at V = W(u): there
q = V/W and base = W - V. The ``far`` piece covers heights at which a ring at an edge localises first, where q = V W(u)
is about 1: there base = 1. ``rim`` = q - (the q at which the first hoop falls slack) and ``whole`` = q - (that of the
last hoop) count where they are positive: the force has kinks there in its second derivative. A film held at s localises
above

    V = lowest + d E(t),    d = p(star) - p where that is positive, else 0,

with t, (p - p0)^(1/2) scaled to run from -1 to 1. Before the star the innermost ring localises; behind it another ring,
whose hoop is slack, localises at the lowest V of all.

The numbers are those of `gelcone.membrane.table.table`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np

Numbers = Mapping[str, Any]
PIECES = ("near", "far")
MAIN, KINK = {"near": (8, 8), "far": (9, 5)}, (3, 2)
"""Degrees in u and q of P, and of P1 and P2."""
ALONE = {"near": 8, "far": 11}
"""Degree in u of the terms that do not depend on V."""
SCALE = {"near": 8, "far": 3}
"""Degree of W, which is exact only in the near piece."""
CURVE, END = 3, 8
"""Degrees of the curves in u at which hoops fall slack, and of E."""
END_NAMES = [f"end_{i}" for i in range(END + 1)]
LENGTH = (10, 6)
"""Degrees in u and q of the innermost ring's length and of the largest field."""
FLAT = 6
"""Degree in V of the flat film's area."""
NEVER = 1e30
"""A squared voltage that is never reached."""
TINY = 1e-12
"""Added to the near W, so that a flat film without tension has a q."""
ROUNDED = 1e-3
"""Distance of p over which d turns into 0."""


class Pull(NamedTuple):
    """k, its derivatives by s and V, ``rim``, ``whole``, the base, and u and q."""

    k: Any
    by_s: Any
    by_v: Any
    rim: Any
    whole: Any
    base: Any
    u: Any
    q: Any


class Spot(NamedTuple):
    """``rim``, ``whole``, the base, and u and q: a `Pull` without the force."""

    rim: Any
    whole: Any
    base: Any
    u: Any
    q: Any


class Ends(NamedTuple):
    """The squared length of the ring at the disc, and the square of the largest field over V."""

    disc: Any
    field: Any


@cache
def shapes(piece: str) -> dict[str, tuple[int, ...]]:
    """Shapes of the numbers of a piece, by name.

    c = ``shift``, e = ``exponent``, u = ``scale`` p + ``offset``, W = ``start`` + (u + 1) times the sum with ``rise``.
    Sums run over rising powers of u, or of u and q.
    """
    main = (max(MAIN[piece][0], ALONE[piece]) + 1, MAIN[piece][1] + 1)
    kink, length = (KINK[0] + 1, KINK[1] + 1), (LENGTH[0] + 1, LENGTH[1] + 1)
    curve = (CURVE + 1,)
    return {
        "shift": (), "exponent": (), "scale": (), "offset": (), "start": (), "rise": (SCALE[piece] + 1,),
        "main": main, "rim": kink, "whole": kink, "rim_at": curve, "whole_at": curve, "disc": length, "field": length,
    }  # fmt: skip


@cache
def names(piece: str, what: str) -> np.ndarray[Any, np.dtype[Any]]:
    """Names of the numbers of one kind, in their shape."""
    return numbered(f"{piece}_{what}", shapes(piece)[what])


def numbered(name: str, shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[Any]]:
    """Names that end in the indices of their places in an array of a ``shape``."""
    names = np.empty(shape, dtype=object)
    for index in np.ndindex(shape):
        names[index] = "_".join([name, *map(str, index)])
    return names


def place(piece: str, s: Any, n: Numbers) -> tuple[Any, Any]:
    """p and its derivative by s."""
    shifted, exponent = s + n[f"{piece}_shift"], n[f"{piece}_exponent"]
    p = -(shifted**exponent)
    return p, exponent * p / shifted


def pull(piece: str, s: Any, V: Any, n: Numbers, behind: tuple[Any, Any] | None = None) -> Pull:
    """The force of one piece. ``behind`` states with 1 or 0 whether ``rim`` and ``whole`` count; by default they count
    where they are positive."""
    return Held.at(piece, s, n).pull(V, behind)


@dataclass(frozen=True)
class Held:
    """The film at one height, in one piece: the part of its force that serves all voltages."""

    piece: str
    n: Numbers
    u: Any
    u_slope: Any
    powers: Sequence[Any]
    W: Any
    W_slope: Any
    _sums: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def at(cls, piece: str, s: Any, n: Numbers) -> Held:
        """The film at the squared height ``s``."""
        p, p_slope = place(piece, s, n)
        scale = n[f"{piece}_scale"]
        u, u_slope = scale * p + n[f"{piece}_offset"], scale * p_slope
        power = powers(u, max(ALONE[piece], SCALE[piece]))
        rise, rise_slope = _line(piece, "rise", n, power)
        return cls(piece, n, u, u_slope, power, n[f"{piece}_start"] + (u + 1.0) * rise, rise + (u + 1.0) * rise_slope)

    def pull(self, V: Any, behind: tuple[Any, Any] | None = None) -> Pull:
        """The force at the squared voltage ``V``, as that of `pull`."""
        q, q_by_v, q_by_w = share(self.piece, V, self.W)
        q_by_u = q_by_w * self.W_slope
        total, by_u, by_q = self._tensor("main", q)
        kinks = []
        for k, kink in enumerate(("rim", "whole")):
            at, at_slope = self._line(f"{kink}_at")
            distance = q - at
            kinks.append(distance)
            counts = np.where(distance > 0.0, 1.0, 0.0) if behind is None else behind[k]
            if getattr(counts, "value", None) == 0.0:
                continue
            factor, tensor = counts * distance, self._tensor(kink, q)
            square, twice = factor * factor, 2.0 * factor * tensor[0]
            total = total + square * tensor[0]
            by_u = by_u + square * tensor[1] - twice * at_slope
            by_q = by_q + square * tensor[2] + twice
        by_s, by_v = (by_u + by_q * q_by_u) * self.u_slope, by_q * q_by_v
        if self.piece == "near":
            base = self.W - V
            slope = self.W_slope * self.u_slope * total + base * by_s
            return Pull(base * total, slope, base * by_v - total, kinks[0], kinks[1], base, self.u, q)
        return Pull(total, by_s, by_v, kinks[0], kinks[1], 1.0, self.u, q)

    def _line(self, what: str) -> Any:
        if what not in self._sums:
            self._sums[what] = _line(self.piece, what, self.n, self.powers)
        return self._sums[what]

    def _tensor(self, what: str, q: Any) -> tuple[Any, Any, Any]:
        if what not in self._sums:
            self._sums[what] = columns(self.piece, what, self.n, self.powers, q)
        return tensor(self._sums[what], q)


def spot(piece: str, s: Any, V: Any, n: Numbers) -> Spot:
    """The place of a state in one piece."""
    W, power = _scale(piece, s, n)
    q = share(piece, V, W)[0]
    rim, whole = (q - _line(piece, f"{kink}_at", n, power)[0] for kink in ("rim", "whole"))
    return Spot(rim, whole, W - V if piece == "near" else 1.0, power[1], q)


def share(piece: str, V: Any, W: Any) -> tuple[Any, Any, Any]:
    """q, and its derivatives by V and W."""
    if piece == "far":
        return V * W, W, V
    inverse = 1.0 / (W + TINY)
    q = V * inverse
    return q, inverse, -q * inverse


def tension(s: Any, V: Any, n: Numbers) -> Any:
    """W - V: positive where a film below the cut is in tension."""
    return _scale("near", s, n)[0] - V


def distance(piece: str, kink: str, s: Any, V: Any, n: Numbers) -> Any:
    """``rim`` or ``whole``."""
    W, power = _scale(piece, s, n)
    return share(piece, V, W)[0] - _line(piece, f"{kink}_at", n, power)[0]


def _scale(piece: str, s: Any, n: Numbers) -> tuple[Any, list[Any]]:
    """W and the powers of u."""
    p, _ = place(piece, s, n)
    u = n[f"{piece}_scale"] * p + n[f"{piece}_offset"]
    power = powers(u, SCALE[piece])
    return n[f"{piece}_start"] + (u + 1.0) * _line(piece, "rise", n, power)[0], power


def pull_in(s: Any, n: Numbers, xp: Any = np) -> Any:
    """The V above which a film held at s localises."""
    p, _ = place("far", s, n)
    t = n["end_scale"] * xp.sqrt(p - n["end_begin"]) + n["end_offset"]
    before = _sum([n[name] for name in END_NAMES], powers(t, END))
    below = n["star_place"] - p
    rounded = xp.sqrt(below * below + ROUNDED * ROUNDED)
    return n["lowest_pull_in"] + 0.5 * (rounded + below) * before


def tensor(columns: tuple[Any, Any], q: Any) -> tuple[Any, Any, Any]:
    """The sum of c_ij u^i q^j, from its `columns`, and its derivatives by u and q."""
    sums, slopes = columns
    value, by_u, by_q = sums[-1], slopes[-1], 0.0
    for one, slope in zip(sums[-2::-1], slopes[-2::-1], strict=True):
        by_q = by_q * q + value
        value, by_u = value * q + one, by_u * q + slope
    return value, by_u, by_q


def ends(piece: str, u: Any, q: Any, n: Numbers) -> Ends:
    """Lengths and fields of one piece, for numbers, arrays or the expressions of a program."""
    power = powers(u, LENGTH[0])
    return Ends(*(double_sum(names(piece, what), power, q, n) for what in Ends._fields))


def double_sum(name: np.ndarray[Any, np.dtype[Any]], power: Sequence[Any], q: Any, n: Numbers) -> Any:
    """The sum of c_ij u^i q^j, whose c_ij have the names ``name``, from the powers of u."""
    total: Any = 0.0
    for column in name.T[::-1]:
        total = total * q + _sum([n[cell] for cell in column], power)
    return total


def columns(piece: str, what: str, n: Numbers, power: Sequence[Any], q: Any) -> tuple[Any, Any]:
    """The sums over i of c_ij u^i and their derivatives by u, for each j; numbers and arrays take all j at once."""
    most = MAIN[piece][0] if what == "main" else shapes(piece)[what][0] - 1
    if isinstance(q, float | np.ndarray | np.generic):
        rows = _rows(piece, what, n, q)
        sums, slopes = _line_of(rows[: most + 1], power)
        if most + 1 < len(rows):
            sums[0], slopes[0] = _line_of(rows[:, 0], power)
        return sums, slopes
    name = names(piece, what)
    pairs = [
        _line_of([n[one] for one in column[: None if j == 0 else most + 1]], power) for j, column in enumerate(name.T)
    ]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def _rows(piece: str, what: str, n: Numbers, like: Any) -> Any:
    """The c_ij as an array that broadcasts against ``like``."""
    named = names(piece, what)
    values = np.array([n[name] for name in named.ravel()])
    return values.reshape(named.shape + (1,) * (np.ndim(like) - values.ndim + 1) + values.shape[1:])


def powers(u: Any, most: int) -> list[Any]:
    """1, u, u^2, ... to the power ``most``."""
    powers = [1.0, u]
    while len(powers) <= most:
        half = len(powers) // 2
        powers.append(powers[half] * powers[len(powers) - half])
    return powers


def _line(piece: str, what: str, n: Numbers, power: Sequence[Any]) -> tuple[Any, Any]:
    """The sum of c_i u^i and its derivative."""
    return _line_of([n[name] for name in names(piece, what)], power)


def _line_of(own: Sequence[Any], power: Sequence[Any]) -> tuple[Any, Any]:
    """The sum of the ``own`` coefficients times powers, and its derivative."""
    return _sum(own, power), _sum([float(i) * c for i, c in enumerate(own)][1:], power)


def _sum(coefficients: Sequence[Any], power: Sequence[Any]) -> Any:
    total = coefficients[0]
    for c, value in zip(coefficients[1:], power[1:], strict=False):
        total = total + c * value
    return total
