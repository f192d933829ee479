"""The vector part of the compiled loop: a Taylor step of all lanes of a law.

Step size: the last two coefficients of the states bound the remainder,
    h = min over k in (p - 1, p) of (tolerance max(small, |x_0|) / |x_k|)^(1/k),   |.| the largest of all states,
as in Jorba & Zou, Experimental Mathematics 14 (2005) 99, sec. 3.2. Roots of equations and border functions bound the
step as well: close to a pole of a border function the states may allow steps on which its polynomial diverges.
Integrals along the motion, such as that of the power, bound it only at rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import reduce
from typing import NamedTuple

from gelcone.motion.engine import functions
from gelcone.motion.engine.code import Function, Value
from gelcone.motion.engine.jet import Jet
from gelcone.motion.engine.plan import THREAD, Border, Law, Layout, Plan
from gelcone.physics.trace import Node

SMALLEST_NORM = 1e-8
"""Least size of the states to which errors are relative."""
LONGEST_STEP_BITS = 40.0
"""Binary logarithm of the longest step, if all coefficients vanish."""
LONGEST_BLOCK = 1000
"""Most instructions of a step between two branches: long steps of membranes then compile in two thirds of the time."""
SELDOM_ORDER = 4
"""Order of the polynomials of borders that are seldom near."""
SHORTEST = 2.0**-60
"""Least step in the bound of the remainder of such a polynomial."""
BERNSTEIN = (0.25,), (0.5, 1.0 / 6.0), (0.75, 0.5, 0.25), (1.0, 1.0, 1.0, 1.0)
"""Factors of a_1, a_2, ... in the Bernstein coefficients of a_0 + a_1 s + ... + a_4 s^4, each with a_0 besides."""


class _Followed(NamedTuple):
    """A border that can be crossed under a law, its place, and the Taylor coefficients of its function."""

    place: int
    border: Border
    coefficients: list[Value | None]


def step_function(plan: Plan, layout: Layout, place: int) -> Function:
    """``step(lanes, scratch, job, words, store)``: one step of all lanes of a law."""
    longest = LONGEST_BLOCK if plan.width > 1 else None  # the text at width 1 is for other compilers
    f = Function("step", THREAD, "void", plan.width, external=True, longest_block=longest)
    width, law = plan.width, plan.laws[place]
    block = f.place("%lanes", place * layout.rows * width)

    def row(k: int) -> Value:
        return f.place(block, k * width)

    states = [f.load(row(k)) for k in range(layout.states)]
    time, low = f.load(row(layout.time)), f.load(row(layout.time_low))
    needed = {node.index for node in law.held}
    held = {node.index: f.load(row(layout.table + k)) for k, node in enumerate(layout.held) if node.index in needed}
    held |= {node.index: f.load(row(layout.switches + k)) for k, node in enumerate(plan.switches)}
    kept = [row(layout.roots + layout.root(equation)) for equation in law.equations]
    places = [k for k, border in enumerate(plan.borders) if not _never(border, law.borders[k])]
    borders = [(law.borders[k], SELDOM_ORDER if plan.borders[k].seldom else plan.order) for k in places]
    jet = Jet(f, law.rates, borders, plan.order, states, time, held, law.equations, kept)
    followed = [_Followed(k, plan.borders[k], row) for k, row in zip(places, jet.borders, strict=True)]
    wanted = _step_size(f, jet, followed, plan)
    left = f.subtract(f.subtract(f.load(row(layout.stop)), time), low)
    ends = f.compare("ole", left, wanted)
    step = f.choose(ends, left, wanted)
    new_states = [_at(f, coefficients, step) for coefficients in jet.states]
    new_time, new_low = later(f, time, low, step)
    new_time = f.choose(ends, f.load(row(layout.stop)), new_time)
    new_low = f.choose(ends, f.real(0.0), new_low)

    finite = f.compare("olt", f.absolute(reduce(f.add, new_states)), f.real(math.inf))
    small = f.compare("olt", wanted, f.load(row(layout.smallest)))
    steps = f.add(f.load(row(layout.steps)), f.real(1.0))
    sampled = f.compare("ole", f.subtract(f.subtract(f.load(row(layout.target)), time), low), step)
    spent = f.compare("oge", steps, f.load(row(layout.most_steps)))
    sides = {part.place: _side(f, row(layout.sides + part.place), part.border) for part in followed}
    _bound_seldom(f, followed, sides, step)
    near = {part.place: _near(f, part.coefficients, sides[part.place], step) for part in followed}
    due = f.either(f.either(ends, sampled), f.either(small, spent))
    due = f.either(due, f.opposite(finite))
    due = reduce(f.either, near.values(), due)
    for k, value in enumerate(new_states):
        f.store(value, row(k))
    for address, coefficients in zip(kept, jet.roots, strict=True):
        f.store(_at(f, coefficients, step), address)
    f.store(new_time, row(layout.time))
    f.store(new_low, row(layout.time_low))
    f.store(steps, row(layout.steps))
    f.store(f.smaller(wanted, f.load(row(layout.least))), row(layout.least))
    due_bits, finite_bits, small_bits, *near_bits = (f.lanes(mask) for mask in (due, finite, small, *near.values()))
    flagged = f.new(f"and i64 {due_bits}, {f.load_whole(f.place('%words', place))}")
    with f.when(f.new(f"icmp ne i64 {flagged}, 0")):
        _keep_step(f, jet, followed, plan, layout, law, time, low, step)
        known = dict(zip(near, near_bits, strict=True))
        bits = [known.get(k, "0") for k in range(len(plan.borders))]
        _serve_each(f, layout, place, block, flagged, finite_bits, small_bits, *bits)
    f.finish()
    return f


def _never(border: Border, value: Node) -> bool:
    """True if a border cannot be crossed under a law: its function is a constant on the member's side."""
    return border.sided and value.operation == "constant" and value.value * border.direction < 0.0


def _step_size(f: Function, jet: Jet, followed: Sequence[_Followed], plan: Plan) -> Value:
    """The step by the tolerance (see the module's docstring)."""

    def largest(rows: Sequence[Sequence[Value | None]], k: int) -> Value:
        sizes = [f.absolute(value) for row in rows if (value := row[k]) is not None]
        return reduce(f.larger, sizes) if sizes else f.real(0.0)

    # roots count relative to themselves or 1, borders relative to 1, as states relative to the largest of them
    count = len(jet.states) - plan.passengers
    states, integrals = jet.states[:count], jet.states[count:]
    still = f.compare("ole", largest(states, 0), f.real(SMALLEST_NORM))
    size = f.larger(largest(states, 0), f.real(SMALLEST_NORM))
    shared = [(jet.roots, f.divide(size, f.larger(largest(jet.roots, 0), f.real(1.0))))] if jet.roots else []
    for smooth in (False, True):
        rows = [part.coefficients for part in followed if part.border.smooth == smooth and not part.border.seldom]
        if rows:
            shared.append((rows, f.multiply(f.real(math.sqrt(plan.tolerance)), size) if smooth else size))

    def norm(k: int) -> Value:
        sizes = (f.multiply(share, largest(rows, k)) for rows, share in shared)
        moving = reduce(f.larger, sizes, largest(states, k))
        if not integrals:
            return moving
        # at rest the states bound no step, but the source still charges the film: integrals count relative to 1
        return f.choose(still, f.larger(moving, f.multiply(size, largest(integrals, k))), moving)

    allowed = functions.rough_log2(f, f.multiply(size, f.real(plan.tolerance)))
    logarithms = [
        f.multiply(f.subtract(allowed, functions.rough_log2(f, norm(k))), f.real(1.0 / k))
        for k in (plan.order - 1, plan.order)
    ]
    return functions.rough_exp2(f, f.smaller(f.smaller(*logarithms), f.real(LONGEST_STEP_BITS)))


def _at(f: Function, row: Sequence[Value | None], step: Value) -> Value:
    """A Taylor polynomial at the end of the step; odd and even terms are independent, which hides latencies."""
    coefficients = [f.real(0.0) if value is None else value for value in row]
    square = f.multiply(step, step)
    odd = f.polynomial(square, coefficients[1::2])
    even = f.polynomial(square, coefficients[2::2])
    return f.fused(f.fused(even, step, odd), step, coefficients[0])


def later(f: Function, time: Value, low: Value, step: Value) -> tuple[Value, Value]:
    """The time after a step, in two parts."""
    total, lost = functions.two_sum(f, time, step)
    lost = f.add(lost, low)
    new_time = f.add(total, lost)
    return new_time, f.subtract(lost, f.subtract(new_time, total))


def _side(f: Function, address: Value, border: Border) -> Value | None:
    """The sign that makes a border function positive on the member's side; None if it always is."""
    if border.sided and border.direction < 0:
        return None
    side = f.load(address)
    return f.negative(side) if border.direction > 0 else side


def _bound_seldom(f: Function, followed: Sequence[_Followed], sides: Mapping[int, Value | None], step: Value) -> None:
    """Reduces the last coefficient of borders of low order m by a bound of the remainder, on the member's side.

    The bound is |g_m| h^m + |g_(m-1)| h^(m-1)/2: terms g_k h^k fall to about a seventh from order to order.
    """
    for place, border, g in followed:
        if border.seldom:
            before, last = (f.real(0.0) if value is None else value for value in g[-2:])
            rest = f.fused(
                f.divide(f.real(0.5), f.larger(step, f.real(SHORTEST))), f.absolute(before), f.absolute(last)
            )
            sign = sides[place]
            g[-1] = f.subtract(last, rest if sign is None else f.multiply(sign, rest))


def _near(f: Function, coefficients: Sequence[Value | None], sign: Value | None, step: Value) -> Value:
    """Mask of lanes that may cross a border in this step.

    With the sign that makes g positive on the member's side, two bounds exclude the others: g_0 + g_1 t - b t^2 is
    positive in [0, h], with b = - g_2 - n_3 h - n_4 h^2 - ... and n_k = min(g_k, 0); or the Bernstein coefficients of
    g_0 + ... + g_4 t^4 over the step are positive after adding n_5 h^5 + ....
    """
    zero = f.real(0.0)
    g = [zero if term is None or sign is None else f.multiply(sign, term) for term in coefficients]
    g = [signed if signed != zero or term is None else term for signed, term in zip(g, coefficients, strict=True)]
    falling = [zero if term is None else f.smaller(zero, signed) for signed, term in zip(g, coefficients, strict=True)]
    after = f.polynomial(step, falling[5:]) if falling[5:] else zero
    third_on = f.polynomial(step, [falling[3], falling[4], after])
    value, slope, curve = g[:3]
    bend = f.negative(f.fused(third_on, step, curve))
    last = f.fused(f.fused(f.negative(bend), step, slope), step, value)
    ends = f.compare("ule", f.smaller(value, last), zero)
    valley = f.both(f.compare("olt", slope, zero), f.compare("olt", bend, zero))
    deep = f.compare("oge", f.multiply(slope, slope), f.multiply(f.multiply(f.real(-4.0), bend), value))
    near = f.either(ends, f.both(valley, deep))
    power, scaled = step, [f.multiply(g[1], step)]
    for term in g[2:5]:
        power = f.multiply(power, step)
        scaled.append(f.multiply(term, power))
    lowest = value
    for shares in BERNSTEIN:
        total = value
        for share, term in zip(shares, scaled, strict=False):
            total = f.fused(f.real(share), term, total)
        lowest = f.smaller(lowest, total)
    lowest = f.fused(f.multiply(power, step), after, lowest)
    return f.both(near, f.compare("ule", lowest, zero))


def _keep_step(
    f: Function, jet: Jet, followed: Sequence[_Followed], plan: Plan, layout: Layout, law: Law, *span: Value
) -> None:
    """Stores the step's polynomials in the scratch room, for states that are not read inside the step only the start;
    and its ``span``, the time in two parts and the length."""
    terms = layout.terms if plan.borders or not plan.ends_at_samples else 1
    rows = [(i * layout.terms + k, value) for i, row in enumerate(jet.states) for k, value in enumerate(row[:terms])]
    rows += [
        (layout.borders + part.place * layout.terms + k, value)
        for part in followed
        for k, value in enumerate([*part.coefficients, *[None] * (terms - len(part.coefficients))])
    ]
    if plan.borders:
        # roots of other laws are searched again when they are needed
        roots = dict(zip(map(layout.root, law.equations), jet.roots, strict=True))
        for i in range(len(layout.equations)):
            rows += enumerate(roots.get(i, [None] * terms), layout.root_terms + i * layout.terms)
    rows += enumerate(span, layout.step_time)
    for k, value in rows:
        f.store(f.real(0.0) if value is None else value, f.place("%scratch", k * f.width))


def _serve_each(f: Function, layout: Layout, law: int, block: Value, flagged: Value, *bits: Value) -> None:
    """Calls ``serve`` for each lane whose bit is set."""
    pending = f.slot()
    f.store_whole(flagged, pending)
    serve = f.load_pointer(f.place("%words", layout.serve))
    f.intrinsics.add("declare i64 @llvm.cttz.i64(i64, i1)")
    with f.repeat() as out:
        now = f.load_whole(pending)
        f.leave(out, f.new(f"icmp eq i64 {now}, 0"))
        lane = f.new(f"call i64 @llvm.cttz.i64(i64 {now}, i1 true)")
        f.store_whole(f.new(f"and i64 {now}, {f.new(f'sub i64 {now}, 1')}"), pending)
        flags = [f.new(f"trunc i64 {f.new(f'lshr i64 {word}, {lane}')} to i1") for word in bits]
        lane_arguments = f"ptr {f.place(block, lane)}, ptr {f.place('%scratch', lane)}, i64 {law}, i64 {lane}"
        arguments = ", ".join(f"i1 {flag}" for flag in flags)
        f.line(f"call void {serve}({lane_arguments}, ptr %lanes, ptr %job, ptr %words, ptr %store, {arguments})")
