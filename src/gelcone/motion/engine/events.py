"""Events: where a border function g(time, state, numbers) of a trajectory goes through zero.

The Taylor polynomial of g over a step is known, so the first zero is found on it: it is never jumped, because the
search advances by parabolas that lie below the polynomial, and it is never found twice, because the side of the border
that a member is on is carried from step to step instead of being read from a g that is zero but for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from gelcone.motion.engine.code import Function, Value

MARCHES = 300
"""Parabolas after which the search takes at least the 1,000th part of a step at once: only a g that is zero but for
rounding needs more."""
HORIZON = 4.0
"""A parabola lies below the polynomial up to this multiple of the last advance: where a border is close, the bound on
the whole step is far too careful."""
RESOLVED = 2.0**-53
"""Share of a step to which crossings are found."""
ON_BORDER = 2.0**-40
"""A member that starts this near to the border, as a share of what g changes in its first step, starts on it."""


@dataclass(frozen=True)
class Event:
    """A border, and what happens where it is crossed.

    Parameters
    ----------
    border : g(time, state, n, xp), with the arguments of a system's ``rates``; smooth, negative beyond the border or
        positive, see ``direction``.
    direction : -1 counts only where g falls through zero, 1 only where it rises, 0 both.
    switch : name of a number whose sign changes there. None: the event is terminal, the member ends there.
    inside : the side of the border on which g counts as not crossed (positive for direction -1, negative for 1) is the
        one where a member belongs, so that one which starts beyond it crosses it at once. Default: each member starts
        on the side of its first step.
    smooth : the rates of change are continuous across the border, so that an error of the time at which it is crossed
        counts squared: g is then followed with the square root of the tolerance only.
    seldom : the border is seldom near, and g made of what nothing else needs: far from it g is followed by a polynomial
        of low order, less a bound of what that leaves out. Near it the steps end where the bound is zero, until it is.

    divides : the switch is 1 or -1 and changes the law: the code of a step is made for both signs apart, so that a step
        costs what its own law takes.

    g should be of the order of 1: its errors count against 1. A border that contains its own switch as a factor,
    like s (d - x) falling with s = 1 while x < d, keeps the switch and the side of the border together, also where
    the border is touched and left at once; it takes direction -1 or 1 and a switch that starts with the sign that
    makes g positive (direction -1) or negative (direction 1), else it flips at once; so it does where another
    switch changes g for this one. Where the rates of change jump at a switch, the tangent maps across it lack the
    jump (the saltation matrix); where they are continuous there is none. Where the rates on both sides lead back to
    the border (dry friction at rest), or no law holds, a member would switch on and on in place: it ends there. A
    member that starts on a border counts as having just crossed it.
    """

    border: Callable[[Any, Sequence[Any], Mapping[str, Any], Any], Any]
    direction: Literal[-1, 0, 1] = -1
    switch: str | None = None
    inside: bool = False
    smooth: bool = False
    seldom: bool = False
    divides: bool = False

    def __post_init__(self) -> None:
        if self.inside and not self.direction:
            raise ValueError("direction = 0: a border with a side where members belong takes -1 or 1")
        if self.seldom and not self.inside:
            # in a member's first step its side is not known, and the bound that replaces g would be found in its place
            raise ValueError("seldom: needs a border with a side where members belong; give inside=True")
        if self.direction not in (-1, 0, 1):
            raise ValueError(f"direction = {self.direction!r}: must be -1 (g falls), 1 (g rises) or 0 (both)")


def crossing_function(order: int, width: int) -> Function:
    """Code of ``crossing(border, sign, step)``: the first time in [0, step] at which sign * g falls through zero.

    ``border`` holds g's Taylor coefficients, ``width`` places apart; sign * g is taken to be positive before the step.
    Infinity when there is no such time.
    """
    f = Function("crossing", ["ptr %border", "double %sign", "double %step"], "double", 1)
    polynomial = f.slot(2 * (order + 1))
    first, time, reach, count = f.slot(), f.slot(), f.slot(), f.slot()
    for k in range(order + 1):
        value = f.multiply("%sign", f.load(f.place("%border", k * width)))
        f.store(value, f.place(polynomial, k))
        f.store(f.real(0.0), f.place(polynomial, order + 1 + k))

    # g < 0 at the start, and not by rounding, is a border that was crossed when a switch changed g: it is crossed now
    every = [f.load(f.place(polynomial, k)) for k in range(order + 1)]
    change = f.polynomial("%step", [f.real(0.0), *(f.absolute(value) for value in every[1:])])
    with f.when(f.compare("ogt", every[0], f.multiply(f.real(1.0 + ON_BORDER), change))):
        f.finish_here(f"double {f.real(math.inf)}")
    rounding = f.multiply(f.real(-ON_BORDER), f.larger(change, f.real(1.0)))
    with f.when(f.compare("olt", every[0], rounding)):
        f.finish_here(f"double {f.real(0.0)}")
    # g <= 0 at the start is a border just crossed, or missed by rounding. If g falls further it is crossed now; if it
    # rises, the next crossing is the first zero of (g(t) - g(0)) / t, and so on for vanishing derivatives
    f.store_whole("0", first)
    with f.repeat() as out:
        place = f.load_whole(first)
        lead = f.load(f.place(polynomial, place))
        f.leave(out, f.compare("ogt", lead, f.real(0.0)))
        with f.leavable() as on:
            f.leave(on, f.compare_whole("eq", place, "0"))
            f.leave(on, f.compare("oge", lead, f.real(0.0)))
            f.finish_here(f"double {f.real(0.0)}")
        place = f.whole("add", place, "1")
        f.store_whole(place, first)
        with f.when(f.compare_whole("sgt", place, str(order))):
            f.finish_here(f"double {f.real(math.inf)}")
    start = f.place(polynomial, f.load_whole(first))
    f.store(f.real(0.0), time)
    f.store("%step", reach)
    f.store_whole("0", count)
    with f.repeat() as out:
        # the polynomial about the time reached, where it is positive
        coefficients = [f.load(f.place(start, k)) for k in range(order + 1)]
        value, slope, at = coefficients[0], coefficients[1], f.load(time)
        with f.when(f.compare("ole", value, f.real(0.0))):
            f.finish_here(f"double {at}")
        left = f.subtract("%step", at)
        horizon = f.smaller(f.load(reach), left)
        # value + slope d - bend d^2 lies below up to the horizon, and so does its zero, if it has one
        curve = coefficients[2]
        falls = [f.negative(f.smaller(value, f.real(0.0))) for value in coefficients[3:]]
        bend = f.subtract(f.polynomial(horizon, [f.real(0.0), *falls]), curve)
        within = f.fused(slope, slope, f.multiply(f.multiply(f.real(4.0), bend), value))
        root = f.sqrt(f.larger(within, f.real(0.0)))
        falling = f.divide(f.multiply(f.real(2.0), value), f.subtract(root, slope))
        rising = f.divide(f.add(root, slope), f.multiply(f.real(2.0), bend))
        rising = f.choose(f.compare("ogt", bend, f.real(0.0)), rising, horizon)
        zero = f.choose(f.compare("olt", slope, f.real(0.0)), falling, rising)
        advance = f.smaller(f.choose(f.compare("olt", within, f.real(0.0)), horizon, zero), horizon)
        marches = f.whole("add", f.load_whole(count), "1")
        f.store_whole(marches, count)
        least = f.multiply(f.real(0.001), "%step")
        advance = f.choose(f.compare_whole("sgt", marches, str(MARCHES)), f.larger(advance, least), advance)
        f.leave(out, f.compare("uge", advance, left))
        after = f.add(at, advance)
        with f.when(f.compare("ole", after, at)):
            f.finish_here(f"double {at}")
        # from below a falling zero advances square their error: what the next one would add is lost to rounding
        bends = f.polynomial(advance, [f.absolute(value) for value in coefficients[2:]])
        missed = f.multiply(bends, f.multiply(advance, advance))
        exact = f.compare("olt", missed, f.multiply(f.multiply(f.real(-RESOLVED), slope), "%step"))
        with f.when(exact):
            f.finish_here(f"double {after}")
        f.store(after, time)
        f.store(f.multiply(f.real(HORIZON), advance), reach)
        for k, coefficient in enumerate(_shifted(f, coefficients, advance)):
            f.store(coefficient, f.place(start, k))
    f.finish(f"double {f.real(math.inf)}")
    return f


def _shifted(f: Function, coefficients: Sequence[Value], by: Value) -> list[Value]:
    """Coefficients of the polynomial about ``by``, by repeated synthetic division."""
    shifted = list(coefficients)
    last = len(shifted) - 1
    for low in range(last):
        for k in range(last - 1, low - 1, -1):
            shifted[k] = f.fused(shifted[k + 1], by, shifted[k])
    return shifted
