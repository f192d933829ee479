"""Events: zeros of a border function g(time, state, numbers) along a trajectory.

The first zero in a step is found on the Taylor polynomial of g. It is never missed, because the search advances by
parabolas that lie below the polynomial, and never found twice, because the member's side of the border is carried from
step to step instead of being read from a g that is zero but for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from gelcone.motion.engine.code import Function, Value

MARCHES = 300
"""Parabolas after which the search advances by at least 1/1,000 of a step: only a g that is zero but for rounding needs
more."""
HORIZON = 4.0
"""Multiple of the last advance up to which a parabola bounds the polynomial: close to a border, a bound over the whole
step is far too low."""
RESOLVED = 2.0**-53
"""Error of the time of a crossing over the step."""
ON_BORDER = 2.0**-40
"""Largest |g|, over the change of g in the first step, of a member that starts on the border."""


@dataclass(frozen=True)
class Event:
    """A border, and the action at its crossing.

    Parameters
    ----------
    border : g(time, state, n, xp), with the arguments of a system's ``rates``; smooth, with a sign that changes at the
        border.
    direction : -1 counts crossings at which g falls, 1 those at which it rises, 0 both.
    switch : name of a number whose sign changes there. None: the event is terminal, and the member ends there.
    inside : members belong on the side before the crossing (g positive for direction -1, negative for 1), so that one
        which starts beyond the border crosses it at once. Default: each member starts on the side of its first step.
    smooth : the rates of change are continuous across the border, so that an error of the crossing time counts squared:
        g is then followed only to the square root of the tolerance.
    seldom : the border is seldom near, and nothing else needs the nodes of g: far from the border g is followed by a
        polynomial of low order less a bound of its remainder; near the border, steps end where the bound crosses zero.
    divides : the switch is 1 or -1 and changes the law: the code of a step is made for each sign, so that a step costs
        only its own law.
    gentle : the rates of change are continuous across the border and lead no member back to it, so that a switch that
        flips without end does so by rounding: a step is taken without the border, and the member continues.

    g should be of the order of 1: its errors count against 1. A border that contains its own switch as a factor,
    like s (d - x) falling with s = 1 while x < d, keeps the switch and the side of the border together, also where
    the border is touched and left at once. It takes direction -1 or 1 and a switch that starts with the sign that
    makes g positive (direction -1) or negative (direction 1); else it flips at once, as it does where another switch
    changes the sign of g. Where the rates of change jump at a switch, the tangent maps across it lack the jump (the
    saltation matrix). Where the rates on both sides lead back to the border (dry friction at rest), or no law holds, a
    member would switch without end: it ends there. A member that starts on a border counts as having just crossed it.
    """

    border: Callable[[Any, Sequence[Any], Mapping[str, Any], Any], Any]
    direction: Literal[-1, 0, 1] = -1
    switch: str | None = None
    inside: bool = False
    smooth: bool = False
    seldom: bool = False
    divides: bool = False
    gentle: bool = False

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
    Infinity if there is no such time.
    """
    f = Function("crossing", ["ptr %border", "double %sign", "double %step"], "double", 1)
    polynomial = f.slot(2 * (order + 1))
    first, time, reach, count = f.slot(), f.slot(), f.slot(), f.slot()
    for k in range(order + 1):
        value = f.multiply("%sign", f.load(f.place("%border", k * width)))
        f.store(value, f.place(polynomial, k))
        f.store(f.real(0.0), f.place(polynomial, order + 1 + k))

    # if g < 0 at the start by more than rounding, a switch changed its sign: the border is crossed now
    every = [f.load(f.place(polynomial, k)) for k in range(order + 1)]
    change = f.polynomial("%step", [f.real(0.0), *(f.absolute(value) for value in every[1:])])
    with f.when(f.compare("ogt", every[0], f.multiply(f.real(1.0 + ON_BORDER), change))):
        f.finish_here(f"double {f.real(math.inf)}")
    rounding = f.multiply(f.real(-ON_BORDER), f.larger(change, f.real(1.0)))
    with f.when(f.compare("olt", every[0], rounding)):
        f.finish_here(f"double {f.real(0.0)}")
    # if g <= 0 at the start, the border was just crossed, or missed by rounding: if g falls further it is crossed now;
    # if g rises, the next crossing is the first zero of (g(t) - g(0)) / t, and so on for vanishing derivatives
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
        # value + slope d - bend d^2 lies below the polynomial up to the horizon, so that its zero comes first
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
        # advances towards a falling zero square their error: the next one would be lost to rounding
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
