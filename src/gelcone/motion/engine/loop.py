"""The compiled loop: lanes that advance together, each with its own member, step, end and samples.

The vector part advances all lanes by a Taylor step of their own length. Lanes for which something is due - a sample,
the end, a corner, a failure, perhaps a crossed border - are then served one by one in scalar code. A member that is
done makes room for the next one from a queue that all threads share.

Where switches change the law of the motion, the code of a step is made for each law apart, and each law has lanes of
its own: a member that crosses a border goes over to the lanes of its new law, or waits until one is free. The lanes
that hold most members go first, so that few of a vector stay empty. A thread works on more members than a vector holds;
each has a slot, a record of its own, where it waits.

Step size: the last two coefficients of the states bound what a step leaves out,
    h = min over k in (p - 1, p) of (tolerance max(small, |x_0|) / |x_k|)^(1/k),   |.| the largest of all states,
as in Jorba & Zou, Experimental Mathematics 14 (2005) 99, sec. 3.2. Roots of equations and border functions bound the
step as well: between poles of a border function the states may allow steps on which its polynomial says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from gelcone.motion.engine import functions
from gelcone.motion.engine.code import Function, Value
from gelcone.motion.engine.events import ON_BORDER, crossing_function
from gelcone.motion.engine.recurrences import Equation, Jet, evaluate, held_values
from gelcone.motion.engine.trace import Node, ordered

SMALLEST_NORM = 1e-8
"""Errors are relative to the largest state; where all are below this, to this."""
LONGEST_STEP_BITS = 40.0
"""Steps are at most 2^40: where all coefficients vanish nothing else bounds them."""
SELDOM_ORDER = 4
"""Order of the polynomials of borders that are seldom near."""
SHORTEST = 2.0**-60
"""A step of which it matters not what such a polynomial leaves out."""
CROWD = 4
"""Members that a thread works on, for each lane of each law: with 1 there is always a law whose lanes are full, with
more this lasts longer at the end."""
BERNSTEIN = (0.25,), (0.5, 1.0 / 6.0), (0.75, 0.5, 0.25), (1.0, 1.0, 1.0, 1.0)
"""Shares of a_1, a_2, ... in the Bernstein coefficients of a_0 + a_1 s + ... + a_4 s^4, but for a_0 in all of them."""
THERE = 2.0**-13
"""Share of a step below which a polynomial of that order is exact."""
ARRIVED, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, TERMINAL_EVENT = range(5)
"""How a member ended; terminal event k is told by TERMINAL_EVENT + k."""


class Job(IntEnum):
    """Fields of the job that the loop reads, 8 bytes each: addresses of arrays, then integers."""

    TABLE = 0  # (held values, padded members)
    STATES = 1  # (members, states)
    SWITCHES = 2  # (members, switches), at the start, then at the end
    START = 3  # (members,)
    TIMES = 4  # (members, samples)
    CORNERS = 5  # (members, corners + 1), the last infinite
    SMALLEST = 6  # (members,)
    MOST_STEPS = 7  # (members,)
    RESULT = 8  # (members, samples, states)
    STATUS = 9  # (members,) int64
    STEPS = 10  # (members,)
    LEAST = 11  # (members,)
    END_TIME = 12  # (members,)
    END_STATE = 13  # (members, states)
    DWELL = 14  # (members, 2^switches)
    MEMBERS = 15
    SAMPLES = 16
    CORNER_COUNT = 17
    PADDED = 18
    SLOTS = 19  # members that a thread works on at a time
    NEXT = 20  # the member that the next free slot takes


@dataclass(frozen=True)
class Border:
    """A traced event: its direction, the place of its switch (None: terminal), and whether it is ``sided``: whether the
    function is known to be positive (direction -1) where a member is; ``smooth`` and ``seldom`` are those of the
    event."""

    direction: int
    switch: int | None
    sided: bool
    smooth: bool
    seldom: bool


@dataclass(frozen=True)
class Law:
    """What a member obeys as long as the switches that tell laws apart keep their signs: the rates of change of the
    states, the border functions and the equations of all roots among both."""

    rates: tuple[Node, ...]
    borders: tuple[Node, ...]
    equations: tuple[Equation, ...]

    @property
    def wanted(self) -> list[Node]:
        """All nodes that are wanted."""
        return [*self.rates, *self.borders]

    @property
    def held(self) -> list[Node]:
        """What its formulas take that does not change while a member is integrated."""
        parts = [node for equation in self.equations for node in (*equation.slopes, equation.first)]
        return held_values([*self.wanted, *parts])


@dataclass(frozen=True)
class Plan:
    """All that the code of a program depends on.

    ``laws``: one for each combination of signs of the switches at the places ``telling``; bit k of its place is set
    where the k-th of them is negative.
    ``restarts``: what the states are set to after each sample (None leaves them); steps then end at the samples, else
    samples are read from the Taylor polynomial. ``corner_switch``: place of the switch that flips at corners, the last
    of those whose signs are counted; ``corner_time``: behind it, that of the number that takes the corner's time.
    """

    laws: tuple[Law, ...]
    telling: tuple[int, ...]
    borders: tuple[Border, ...]
    switches: tuple[Node, ...]
    numbers: tuple[str, ...]
    order: int
    tolerance: float
    restarts: tuple[float | None, ...]
    corner_switch: int | None
    corner_time: int | None
    width: int

    @property
    def signs(self) -> int:
        """How many switches have a sign that counts."""
        return len(self.switches) - (self.corner_time is not None)

    @property
    def wanted(self) -> list[Node]:
        """All nodes that are wanted, law by law."""
        return [node for law in self.laws for node in law.wanted]

    @property
    def slots(self) -> int:
        """Members that a thread can work on; without laws to tell apart more than lanes serve nothing. A power of 2."""
        return self.width if len(self.laws) == 1 else CROWD * len(self.laws) * self.width


class Layout:
    """Rows of a lane, ``width`` numbers each, and of the scratch room that keeps the last step."""

    def __init__(self, plan: Plan) -> None:
        self.states = len(plan.laws[0].rates)
        self.held = list({node.index: node for law in plan.laws for node in law.held}.values())
        self.equations = list(dict.fromkeys(equation.root.index for law in plan.laws for equation in law.equations))
        first = self.states
        (
            self.time,
            self.time_low,
            self.target,
            self.stop,
            self.corner,
            self.smallest,
            self.most_steps,
            self.least,
            self.steps,
            self.member,
            self.slot,
            self.sample,
            self.corner_number,
            self.table,
        ) = range(first, first + 14)
        self.switches = self.table + len(self.held)
        self.sides = self.switches + len(plan.switches)
        self.roots = self.sides + len(plan.borders)
        self.dwell = self.roots + len(self.equations)
        self.combinations = 2**plan.signs if plan.signs else 0
        self.since = self.dwell + self.combinations
        self.rows = self.since + 1
        self.terms = plan.order + 1
        self.borders = self.states * self.terms
        self.root_terms = self.borders + len(plan.borders) * self.terms
        self.step_time = self.root_terms + len(self.equations) * self.terms
        self.step_low = self.step_time + 1
        self.step = self.step_time + 2
        self.scratch_rows = self.step_time + 3
        # words of a thread: for each law a bit for each lane that has a member, how many wait, and where in the law's
        # ring the first of them is; then the rings
        self.waiting = len(plan.laws)
        self.heads = 2 * len(plan.laws)
        self.rings = 3 * len(plan.laws)
        self.words = self.rings + len(plan.laws) * plan.slots

    def root(self, equation: Equation) -> int:
        """Place of the equation's root among all."""
        return self.equations.index(equation.root.index)


def module_text(plan: Plan) -> str:
    """The LLVM module of a program: ``prepare``, ``start`` and ``advance``, and what these call."""
    layout = Layout(plan)
    made = [
        _prepare(plan, layout),
        _enter(plan, layout),
        _vacate(plan, layout),
        _refill(plan, layout),
        *([crossing_function(plan.order, plan.width)] if plan.borders else []),
        _serve(plan, layout),
        _start(plan, layout),
        *(_step(plan, layout, place) for place in range(len(plan.laws))),
        _advance(plan, layout),
    ]
    declarations = sorted({line for function in made for line in function.intrinsics})
    return "\n".join([*declarations, "", *(function.text() for function in made)])


def _prepare(plan: Plan, layout: Layout) -> Function:
    """``prepare(numbers, table, padded)``: what depends on a member's numbers alone, once a member."""
    f = Function("prepare", ["ptr %numbers", "ptr %table", "i64 %padded"], "void", plan.width, external=True)
    at = f.slot()
    f.store_whole("0", at)
    with f.repeat() as out:
        block = f.load_whole(at)
        f.leave(out, f.new(f"icmp sge i64 {block}, %padded"))

        def row(base: Value, k: int) -> Value:
            return f.place(base, f.new(f"add i64 {block}, {f.new(f'mul i64 %padded, {k}')}"))

        values: dict[int, Value] = {}
        for node in ordered(layout.held):
            if node.fixed:
                values[node.index] = (
                    f.load(row("%numbers", plan.numbers.index(node.value)))
                    if node.operation == "number"
                    else evaluate(f, node, [values[a.index] for a in node.arguments])
                )
        for k, node in enumerate(layout.held):
            f.store(values[node.index], row("%table", k))
        f.store_whole(f.new(f"add i64 {block}, {plan.width}"), at)
    f.finish()
    return f


# --- the vector part -----------------------------------------------------------------------------------------------


_THREAD = ["ptr noalias %lanes", "ptr noalias %scratch", "ptr %job", "ptr %words", "ptr noalias %store"]
"""A thread's lanes (laws, rows, width), room for the last step, job, words, and slots (slots, rows)."""
_SAME_THREAD = "ptr %lanes, ptr %scratch, ptr %job, ptr %words, ptr %store"


class _Followed(NamedTuple):
    """A border that can be crossed under a law: its place, itself, and the Taylor coefficients of its function."""

    place: int
    border: Border
    coefficients: list[Value | None]


def _advance(plan: Plan, layout: Layout) -> Function:
    """``advance(lanes, scratch, job, words, store, most)``: up to ``most`` steps of a law's lanes; returns how many."""
    f = Function("advance", [*_THREAD, "i64 %most"], "i64", 1, external=True)
    count, chosen, size = f.slot(), f.slot(), f.slot()
    f.store_whole("0", count)
    f.intrinsics.add("declare i64 @llvm.ctpop.i64(i64)")
    with f.repeat() as out:
        f.store_whole("0", size)
        for law in range(len(plan.laws)):
            active = f.load_whole(f.place("%words", law))
            waiting = f.load_whole(f.place("%words", layout.waiting + law))
            members = f.whole("add", f.new(f"call i64 @llvm.ctpop.i64(i64 {active})"), waiting)
            with f.when(f.compare_whole("sgt", members, f.load_whole(size))):
                f.store_whole(members, size)
                f.store_whole(str(law), chosen)
        f.leave(out, f.compare_whole("eq", f.load_whole(size), "0"))
        done = f.load_whole(count)
        f.leave(out, f.compare_whole("sge", done, "%most"))
        f.store_whole(f.whole("add", done, "1"), count)
        now = f.load_whole(chosen)
        for law in range(len(plan.laws)):
            with f.when(f.compare_whole("eq", now, str(law))):
                f.line(f"call void @step{law}({_SAME_THREAD})")
    f.finish(f"i64 {f.load_whole(count)}")
    return f


def _step(plan: Plan, layout: Layout, place: int) -> Function:
    """``step(lanes, scratch, job, words, store)``: one step of all lanes of a law."""
    f = Function(f"step{place}", _THREAD, "void", plan.width)
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
    new_time, new_low = _later(f, time, low, step)
    new_time = f.choose(ends, f.load(row(layout.stop)), new_time)
    new_low = f.choose(ends, f.real(0.0), new_low)

    total = new_states[0]
    for value in new_states[1:]:
        total = f.add(total, value)
    finite = f.compare("olt", f.absolute(total), f.real(math.inf))
    small = f.compare("olt", wanted, f.load(row(layout.smallest)))
    steps = f.add(f.load(row(layout.steps)), f.real(1.0))
    sampled = f.compare("ole", f.subtract(f.subtract(f.load(row(layout.target)), time), low), step)
    spent = f.compare("oge", steps, f.load(row(layout.most_steps)))
    sides = {part.place: _side(f, row(layout.sides + part.place), part.border) for part in followed}
    _bound_seldom(f, followed, sides, step)
    near = {part.place: _near(f, part.coefficients, sides[part.place], step) for part in followed}
    due = f.either(f.either(ends, sampled), f.either(small, spent))
    due = f.either(due, f.new(f"xor {f.truth_type} {finite}, splat (i1 true)"))
    for mask in near.values():
        due = f.either(due, mask)
    for k, value in enumerate(new_states):
        f.store(value, row(k))
    for address, coefficients in zip(kept, jet.roots, strict=True):
        f.store(_at(f, coefficients, step), address)
    f.store(new_time, row(layout.time))
    f.store(new_low, row(layout.time_low))
    f.store(steps, row(layout.steps))
    f.store(f.smaller(wanted, f.load(row(layout.least))), row(layout.least))
    word = f"i{width}"
    due_bits, finite_bits, small_bits, *near_bits = (
        f.new(f"zext {word} {f.new(f'bitcast {f.truth_type} {mask} to {word}')} to i64")
        for mask in (due, finite, small, *near.values())
    )
    flagged = f.new(f"and i64 {due_bits}, {f.load_whole(f.place('%words', place))}")
    with f.when(f.new(f"icmp ne i64 {flagged}, 0")):
        _keep_step(f, jet, followed, plan, layout, law, time, low, step)
        told = dict(zip(near, near_bits, strict=True))
        bits = [told.get(k, "0") for k in range(len(plan.borders))]
        _serve_each(f, place, block, flagged, finite_bits, small_bits, *bits)
    f.finish()
    return f


def _never(border: Border, value: Node) -> bool:
    """Whether a border is not crossed under a law: whether its function keeps the sign of the member's side."""
    return border.sided and value.operation == "constant" and value.value * border.direction < 0.0


def _step_size(f: Function, jet: Jet, followed: Sequence[_Followed], plan: Plan) -> Value:
    """The step that the tolerance allows (see the module's docstring)."""

    def largest(rows: Sequence[Sequence[Value | None]], k: int) -> Value:
        sizes = [f.absolute(value) for row in rows if (value := row[k]) is not None]
        total = sizes[0] if sizes else f.real(0.0)
        for size in sizes[1:]:
            total = f.larger(total, size)
        return total

    # roots count relative to themselves or 1, borders relative to 1, as states relative to the largest of them
    size = f.larger(largest(jet.states, 0), f.real(SMALLEST_NORM))
    shared = [(jet.roots, f.divide(size, f.larger(largest(jet.roots, 0), f.real(1.0))))] if jet.roots else []
    for smooth in (False, True):
        rows = [part.coefficients for part in followed if part.border.smooth == smooth and not part.border.seldom]
        if rows:
            shared.append((rows, f.multiply(f.real(math.sqrt(plan.tolerance)), size) if smooth else size))

    def norm(k: int) -> Value:
        total = largest(jet.states, k)
        for rows, share in shared:
            total = f.larger(total, f.multiply(share, largest(rows, k)))
        return total

    allowed = functions.rough_log2(f, f.multiply(size, f.real(plan.tolerance)))
    logarithms = [
        f.multiply(f.subtract(allowed, functions.rough_log2(f, norm(k))), f.real(1.0 / k))
        for k in (plan.order - 1, plan.order)
    ]
    return functions.rough_exp2(f, f.smaller(f.smaller(*logarithms), f.real(LONGEST_STEP_BITS)))


def _at(f: Function, row: Sequence[Value | None], step: Value) -> Value:
    """A Taylor polynomial at the end of the step: odd and even terms apart, which run side by side."""
    coefficients = [f.real(0.0) if value is None else value for value in row]
    square = f.multiply(step, step)
    odd = f.polynomial(square, coefficients[1::2])
    even = f.polynomial(square, coefficients[2::2])
    return f.fused(f.fused(even, step, odd), step, coefficients[0])


def _later(f: Function, time: Value, low: Value, step: Value) -> tuple[Value, Value]:
    """The time after a step, in two parts."""
    total, lost = functions.two_sum(f, time, step)
    lost = f.add(lost, low)
    new_time = f.add(total, lost)
    return new_time, f.subtract(lost, f.subtract(new_time, total))


def _side(f: Function, address: Value, border: Border) -> Value | None:
    """The sign that makes a border function positive on the member's side; None where it always is."""
    if border.sided and border.direction < 0:
        return None
    side = f.load(address)
    return f.negative(side) if border.direction > 0 else side


def _bound_seldom(f: Function, followed: Sequence[_Followed], sides: Mapping[int, Value | None], step: Value) -> None:
    """Takes from the last coefficient of borders of low order m what the next ones may hold, on the member's side:
    |g_m| h^m + |g_(m-1)| h^(m-1)/2. Coefficients times h^k fall to a seventh or so from order to order."""
    for place, border, g in followed:
        if border.seldom:
            before, last = (f.real(0.0) if value is None else value for value in g[-2:])
            rest = f.fused(
                f.divide(f.real(0.5), f.larger(step, f.real(SHORTEST))), f.absolute(before), f.absolute(last)
            )
            sign = sides[place]
            g[-1] = f.subtract(last, rest if sign is None else f.multiply(sign, rest))


def _near(f: Function, coefficients: Sequence[Value | None], sign: Value | None, step: Value) -> Value:
    """Lanes that may cross a border in this step. With the sign that makes g positive on the member's side, two bounds
    tell those that do not: g_0 + g_1 t - b t^2 is above zero at t = 0, at t = h and between, where
    b = - g_2 - n_3 h - n_4 h^2 - ..., and n_k is g_k where that is negative, else 0; or the Bernstein coefficients of
    g_0 + ... + g_4 t^4 over the step are above zero, less what n_5, ... take.
    """
    zero = f.real(0.0)
    g = [zero if part is None or sign is None else f.multiply(sign, part) for part in coefficients]
    g = [own if own != zero or part is None else part for own, part in zip(g, coefficients, strict=True)]
    falling = [zero if part is None else f.smaller(zero, own) for own, part in zip(g, coefficients, strict=True)]
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
    for part in g[2:5]:
        power = f.multiply(power, step)
        scaled.append(f.multiply(part, power))
    lowest = value
    for shares in BERNSTEIN:
        total = value
        for share, part in zip(shares, scaled, strict=False):
            total = f.fused(f.real(share), part, total)
        lowest = f.smaller(lowest, total)
    lowest = f.fused(f.multiply(power, step), after, lowest)
    return f.both(near, f.compare("ule", lowest, zero))


def _keep_step(
    f: Function,
    jet: Jet,
    followed: Sequence[_Followed],
    plan: Plan,
    layout: Layout,
    law: Law,
    time: Value,
    low: Value,
    step: Value,
) -> None:
    """Puts the step's polynomials where the scalar code finds them; of states that no one reads inside of a step, the
    start alone."""
    terms = layout.terms if plan.borders or not _ends_at_samples(plan) else 1
    rows = [(i * layout.terms + k, value) for i, row in enumerate(jet.states) for k, value in enumerate(row[:terms])]
    rows += [
        (layout.borders + part.place * layout.terms + k, value)
        for part in followed
        for k, value in enumerate([*part.coefficients, *[None] * (terms - len(part.coefficients))])
    ]
    if plan.borders:
        roots: list[list[Value | None]] = [
            [None] * terms for _ in layout.equations
        ]  # those of other laws begin anew when they are needed
        for equation, row in zip(law.equations, jet.roots, strict=True):
            roots[layout.root(equation)] = row
        rows += [
            (layout.root_terms + i * layout.terms + k, value)
            for i, row in enumerate(roots)
            for k, value in enumerate(row)
        ]
    rows += [(layout.step_time, time), (layout.step_low, low), (layout.step, step)]
    for k, value in rows:
        f.store(f.real(0.0) if value is None else value, f.place("%scratch", k * f.width))


def _serve_each(f: Function, law: int, block: Value, flagged: Value, *bits: Value) -> None:
    """Calls ``serve`` for each lane whose bit is set."""
    left = f.slot()
    f.store_whole(flagged, left)
    f.intrinsics.add("declare i64 @llvm.cttz.i64(i64, i1)")
    with f.repeat() as out:
        now = f.load_whole(left)
        f.leave(out, f.new(f"icmp eq i64 {now}, 0"))
        lane = f.new(f"call i64 @llvm.cttz.i64(i64 {now}, i1 true)")
        f.store_whole(f.new(f"and i64 {now}, {f.new(f'sub i64 {now}, 1')}"), left)
        flags = [f.new(f"trunc i64 {f.new(f'lshr i64 {word}, {lane}')} to i1") for word in bits]
        own = f"ptr {f.place(block, lane)}, ptr {f.place('%scratch', lane)}, i64 {law}, i64 {lane}"
        told = ", ".join(f"i1 {flag}" for flag in flags)
        f.line(f"call void @serve({own}, ptr %lanes, ptr %job, ptr %words, ptr %store, {told})")


# --- the scalar part -----------------------------------------------------------------------------------------------


class _Lane:
    """Scalar access to the rows of the lane that ``base`` points to, ``width`` places apart, to those of the last step
    behind ``%scratch``, and to the job. A slot is a lane of width 1."""

    def __init__(self, f: Function, width: int, base: Value = "%lane") -> None:
        self.f, self.width, self.base = f, width, base

    def place(self, row: int) -> Value:
        return self.f.place(self.base, row * self.width)

    def take(self, other: _Lane, layout: Layout) -> None:
        """Takes all rows of another one."""
        for row in range(layout.rows):
            self.set_whole(row, other.get_whole(row))

    def get(self, row: int) -> Value:
        return self.f.load(self.place(row))

    def set(self, row: int, value: Value) -> None:
        self.f.store(value, self.place(row))

    def get_whole(self, row: int) -> Value:
        return self.f.load_whole(self.place(row))

    def set_whole(self, row: int, value: Value) -> None:
        self.f.store_whole(value, self.place(row))

    def step(self, row: int) -> Value:
        return self.f.load(self.f.place("%scratch", row * self.width))

    def array(self, field: Job, *index: Value) -> Value:
        """Address of an element: the array's address plus the sum of the index."""
        address = self.f.load_pointer(self.f.place("%job", field))
        for part in index:
            address = self.f.place(address, part)
        return address

    def size(self, field: Job) -> Value:
        return self.f.load_whole(self.f.place("%job", field))

    def times(self, a: Value, b: Value | int) -> Value:
        return self.f.new(f"mul i64 {a}, {b}")

    def set_stop(self, plan: Plan, layout: Layout, member: Value) -> None:
        """The next time at which a step must end: a corner, or the next sample, or the last one."""
        f = self.f
        end = self.get(layout.target)
        if not _ends_at_samples(plan):
            samples = self.size(Job.SAMPLES)
            end = f.load(self.array(Job.TIMES, self.times(member, samples), f.whole("sub", samples, "1")))
        self.set(layout.stop, f.smaller(self.get(layout.corner), end))


def _ends_at_samples(plan: Plan) -> bool:
    return any(value is not None for value in plan.restarts)


def _slot(f: Function, layout: Layout, number: Value) -> _Lane:
    return _Lane(f, 1, f.place("%store", f.whole("mul", number, str(layout.rows))))


def _block_lane(f: Function, plan: Plan, layout: Layout, number: Value) -> _Lane:
    """A lane of the law ``%law``."""
    block = f.place("%lanes", f.whole("mul", "%law", str(layout.rows * plan.width)))
    return _Lane(f, plan.width, f.place(block, number))


def _ring(f: Function, plan: Plan, layout: Layout, number: Value) -> Value:
    """The address of a place in the ring of the law ``%law``."""
    place = f.whole("and", number, str(plan.slots - 1))
    first = f.whole("add", f.whole("mul", "%law", str(plan.slots)), str(layout.rings))
    return f.place("%words", f.whole("add", first, place))


def _enter(plan: Plan, layout: Layout) -> Function:
    """``enter(law, slot, lanes, words, store)``: gives a member a lane of its law, or lets it wait for one."""
    f = Function("enter", ["i64 %law", "i64 %slot", "ptr %lanes", "ptr %words", "ptr %store"], "void", 1)
    f.intrinsics.add("declare i64 @llvm.cttz.i64(i64, i1)")
    word = f.place("%words", "%law")
    active = f.load_whole(word)
    free = f.whole("and", f.whole("xor", active, "-1"), str((1 << plan.width) - 1))
    with f.when(f.compare_whole("eq", free, "0")):
        count = f.place(word, layout.waiting)
        waiting, head = f.load_whole(count), f.load_whole(f.place(word, layout.heads))
        f.store_whole("%slot", _ring(f, plan, layout, f.whole("add", head, waiting)))
        f.store_whole(f.whole("add", waiting, "1"), count)
        f.finish_here()
    number = f.new(f"call i64 @llvm.cttz.i64(i64 {free}, i1 true)")
    f.store_whole(f.whole("or", active, f.whole("shl", "1", number)), word)
    _block_lane(f, plan, layout, number).take(_slot(f, layout, "%slot"), layout)
    f.finish()
    return f


def _vacate(plan: Plan, layout: Layout) -> Function:
    """``vacate(law, number, lanes, words, store)``: gives a lane to the member that waits longest for it, if any."""
    f = Function("vacate", ["i64 %law", "i64 %number", "ptr %lanes", "ptr %words", "ptr %store"], "void", 1)
    lane = _block_lane(f, plan, layout, "%number")
    word = f.place("%words", "%law")
    waiting = f.load_whole(f.place(word, layout.waiting))
    with f.when(f.compare_whole("eq", waiting, "0")):
        # a lane without member stands still
        bit = f.whole("shl", "1", "%number")
        f.store_whole(f.whole("and", f.load_whole(word), f.whole("xor", bit, "-1")), word)
        lane.set(layout.stop, lane.get(layout.time))
        lane.set(layout.time_low, f.real(0.0))
        f.finish_here()
    head = f.load_whole(f.place(word, layout.heads))
    f.store_whole(f.whole("sub", waiting, "1"), f.place(word, layout.waiting))
    f.store_whole(f.whole("add", head, "1"), f.place(word, layout.heads))
    lane.take(_slot(f, layout, f.load_whole(_ring(f, plan, layout, head))), layout)
    f.finish()
    return f


def _law(lane: _Lane, plan: Plan, layout: Layout) -> Value:
    """The place of a member's law among all."""
    f, law = lane.f, "0"
    for k, place in enumerate(plan.telling):
        sign = f.whole("lshr", f.bits(lane.get(layout.switches + place)), "63")
        law = f.whole("or", law, f.whole("shl", sign, str(k)))
    return law


def _refill(plan: Plan, layout: Layout) -> Function:
    """``refill(slot, lanes, job, words, store)``: the next member, if there is one, for a slot."""
    f = Function("refill", ["i64 %slot", "ptr %lanes", "ptr %job", "ptr %words", "ptr %store"], "void", 1)
    lane = _slot(f, layout, "%slot")
    member = f.new(f"atomicrmw add ptr {f.place('%job', Job.NEXT)}, i64 1 monotonic")
    with f.when(f.compare_whole("sge", member, lane.size(Job.MEMBERS))):
        f.finish_here()
    lane.set_whole(layout.slot, "%slot")
    lane.set_whole(layout.member, member)
    lane.set_whole(layout.sample, "0")
    lane.set_whole(layout.corner_number, "0")
    padded = lane.size(Job.PADDED)
    for k in range(len(layout.held)):
        lane.set(layout.table + k, f.load(lane.array(Job.TABLE, lane.times(padded, k), member)))
    for k in range(layout.states):
        lane.set(k, f.load(lane.array(Job.STATES, lane.times(member, layout.states), str(k))))
    for k in range(len(plan.switches)):
        value = f.load(lane.array(Job.SWITCHES, lane.times(member, len(plan.switches)), str(k)))
        lane.set(layout.switches + k, value)
    for k, border in enumerate(plan.borders):
        lane.set(layout.sides + k, f.real(1.0 if border.sided else 0.0))
    for k in range(len(layout.equations)):
        lane.set(layout.roots + k, f.real(math.nan))
    for k in range(layout.combinations):
        lane.set(layout.dwell + k, f.real(0.0))
    lane.set(layout.time, f.load(lane.array(Job.START, member)))
    lane.set(layout.since, lane.get(layout.time))
    lane.set(layout.time_low, f.real(0.0))
    lane.set(layout.target, f.load(lane.array(Job.TIMES, lane.times(member, lane.size(Job.SAMPLES)))))
    lane.set(layout.corner, f.load(lane.array(Job.CORNERS, lane.times(member, lane.size(Job.CORNER_COUNT)))))
    lane.set_stop(plan, layout, member)
    lane.set(layout.smallest, f.load(lane.array(Job.SMALLEST, member)))
    lane.set(layout.most_steps, f.load(lane.array(Job.MOST_STEPS, member)))
    lane.set(layout.least, f.real(math.inf))
    lane.set(layout.steps, f.real(0.0))
    law = _law(lane, plan, layout)
    f.line(f"call void @enter(i64 {law}, i64 %slot, ptr %lanes, ptr %words, ptr %store)")
    f.finish()
    return f


def _serve(plan: Plan, layout: Layout) -> Function:
    """``serve(lane, scratch, law, number, lanes, job, words, store, finite, small, near0, ...)``: what is due in one
    lane after a step; a flag for each border tells whether it may be near."""
    near = [f"%near{k}" for k in range(len(plan.borders))]
    own = ["ptr %lane", "ptr %scratch", "i64 %law", "i64 %number"]
    shared = ["ptr %lanes", "ptr %job", "ptr %words", "ptr %store"]
    f = Function("serve", [*own, *shared, "i1 %finite", "i1 %small", *(f"i1 {flag}" for flag in near)], "void", 1)
    lane = _Lane(f, plan.width)
    member = lane.get_whole(layout.member)
    start, low = lane.step(layout.step_time), lane.step(layout.step_low)
    status, reach, event = f.slot(), f.slot(), f.slot()
    f.store_whole("-1", status)
    f.store_whole("-1", event)
    f.store(lane.step(layout.step), reach)

    failed = f.new("or i1 %small, " + f.new("xor i1 %finite, true"))
    with f.when(failed):  # the step does not count: the member ended where it began
        total = f.real(0.0)
        for k in range(layout.states):
            total = f.add(total, lane.step(k * layout.terms))
        lost = f.both("%small", f.compare("olt", f.absolute(total), f.real(math.inf)))
        code = f.new(f"select i1 {lost}, i64 {STEP_TOO_SMALL}, i64 {NOT_FINITE}")
        f.store_whole(code, status)
        for k in range(layout.states):
            lane.set(k, lane.step(k * layout.terms))
        lane.set(layout.time, start)
        lane.set(layout.time_low, low)
    with f.when(f.new(f"xor i1 {failed}, true")):
        for k, flag in enumerate(near):
            with f.when(flag):
                _find_crossing(f, lane, plan, layout, k, reach, event)
        if plan.borders:
            _cut_step(f, lane, plan, layout, reach, event)
        _take_samples(f, lane, plan, layout, member, reach, status)
        going = f.compare_whole("slt", f.load_whole(status), "0")
        with f.when(going):
            for k, border in enumerate(plan.borders):
                with f.when(f.compare_whole("eq", f.load_whole(event), str(k))):
                    _pass_border(f, lane, plan, layout, border, k, status)
            _pass_corner(f, lane, plan, layout, member)
            spent = f.compare("oge", lane.get(layout.steps), lane.get(layout.most_steps))
            with f.when(f.both(spent, f.compare_whole("slt", f.load_whole(status), "0"))):
                f.store_whole(str(TOO_MANY_STEPS), status)
    with f.when(f.compare_whole("sge", f.load_whole(status), "0")):
        _count_dwell(lane, plan, layout)
        for k in range(layout.combinations):
            value = lane.get(layout.dwell + k)
            f.store(value, lane.array(Job.DWELL, lane.times(member, layout.combinations), str(k)))
        f.store_whole(f.load_whole(status), lane.array(Job.STATUS, member))
        for field, row in ((Job.STEPS, layout.steps), (Job.LEAST, layout.least), (Job.END_TIME, layout.time)):
            f.store(lane.get(row), lane.array(field, member))
        for k in range(layout.states):
            f.store(lane.get(k), lane.array(Job.END_STATE, lane.times(member, layout.states), str(k)))
        for k in range(len(plan.switches)):
            value = lane.get(layout.switches + k)
            f.store(value, lane.array(Job.SWITCHES, lane.times(member, len(plan.switches)), str(k)))
        slot = lane.get_whole(layout.slot)
        f.line("call void @vacate(i64 %law, i64 %number, ptr %lanes, ptr %words, ptr %store)")
        f.line(f"call void @refill(i64 {slot}, ptr %lanes, ptr %job, ptr %words, ptr %store)")
        f.finish_here()
    if plan.telling:
        law = _law(lane, plan, layout)
        with f.when(f.compare_whole("ne", law, "%law")):
            for k in range(len(layout.equations)):
                lane.set(layout.roots + k, f.real(math.nan))
            slot = lane.get_whole(layout.slot)
            _slot(f, layout, slot).take(lane, layout)
            f.line("call void @vacate(i64 %law, i64 %number, ptr %lanes, ptr %words, ptr %store)")
            f.line(f"call void @enter(i64 {law}, i64 {slot}, ptr %lanes, ptr %words, ptr %store)")
    f.finish()
    return f


def _take_samples(
    f: Function, lane: _Lane, plan: Plan, layout: Layout, member: Value, reach: Value, status: Value
) -> None:
    """Writes all samples that the step passed; the member has arrived with the last one."""
    samples = lane.size(Job.SAMPLES)
    first = lane.times(member, samples)
    with f.repeat() as out:
        target = lane.get(layout.target)
        offset = f.subtract(f.subtract(target, lane.step(layout.step_time)), lane.step(layout.step_low))
        f.leave(out, f.compare("ogt", offset, f.load(reach)))
        number = lane.get_whole(layout.sample)
        place = lane.times(f.whole("add", first, number), layout.states)
        for k in range(layout.states):
            value = lane.get(k)
            if not _ends_at_samples(plan):
                inside = f.polynomial(offset, [lane.step(k * layout.terms + j) for j in range(layout.terms)])
                value = f.choose(f.compare("oeq", offset, f.load(reach)), value, inside)
            f.store(value, lane.array(Job.RESULT, place, str(k)))
        for k, restart in enumerate(plan.restarts):
            if restart is not None:
                lane.set(k, f.real(restart))
        number = f.whole("add", number, "1")
        lane.set_whole(layout.sample, number)
        last = f.compare_whole("eq", number, samples)
        with f.when(last):
            f.store_whole(str(ARRIVED), status)
        f.leave(out, last)
        lane.set(layout.target, f.load(lane.array(Job.TIMES, first, number)))
    if _ends_at_samples(plan):
        lane.set_stop(plan, layout, member)


def _pass_corner(f: Function, lane: _Lane, plan: Plan, layout: Layout, member: Value) -> None:
    """Goes on to the next corner when the step ended at one."""
    passed = lane.get(layout.corner)
    with f.when(f.compare("oge", lane.get(layout.time), passed)):
        number = f.whole("add", lane.get_whole(layout.corner_number), "1")
        lane.set_whole(layout.corner_number, number)
        first = lane.times(member, lane.size(Job.CORNER_COUNT))
        lane.set(layout.corner, f.load(lane.array(Job.CORNERS, first, number)))
        if plan.corner_switch is not None:
            _count_dwell(lane, plan, layout)
            row = layout.switches + plan.corner_switch
            lane.set(row, f.negative(lane.get(row)))
        if plan.corner_time is not None:
            lane.set(layout.switches + plan.corner_time, passed)
        lane.set_stop(plan, layout, member)


def _find_crossing(f: Function, lane: _Lane, plan: Plan, layout: Layout, k: int, reach: Value, event: Value) -> None:
    """Shortens ``reach`` to where border k is crossed, if it is; ``event`` is told so. Where the bound of a border of
    low order is crossed, the step ends without an event, unless it has come so near that no more is to be told."""
    border = plan.borders[k]
    row = (layout.borders + k * layout.terms) * plan.width
    coefficients = f.place("%scratch", row)
    with f.when(f.compare("oeq", lane.get(layout.sides + k), f.real(0.0))):
        # the first step: which side of the border the member is on, or where to it goes if it is on the border
        g = [f.load(f.place(coefficients, j * plan.width)) for j in range(layout.terms)]
        change = f.polynomial(f.load(reach), [f.real(0.0), *(f.absolute(value) for value in g[1:])])
        toward = f.choose(f.compare("une", g[1], f.real(0.0)), g[1], g[2])
        off = f.compare("ogt", f.absolute(g[0]), f.multiply(f.real(ON_BORDER), change))
        value = f.choose(off, g[0], toward)
        side = f.choose(f.compare("olt", value, f.real(0.0)), f.real(-1.0), f.real(1.0))
        lane.set(layout.sides + k, f.negative(side) if border.direction > 0 else side)
    side = lane.get(layout.sides + k)
    sign = f.negative(side) if border.direction > 0 else side
    time = f.new(f"call double @crossing(ptr {coefficients}, double {sign}, double {f.load(reach)})")
    earlier = f.compare("olt", time, f.load(reach))
    first = f.new(f"icmp slt i64 {f.load_whole(event)}, 0")
    found = f.both(f.compare("ole", time, f.load(reach)), f.either(earlier, first))
    told = str(k)
    if border.seldom:
        there = f.compare("olt", time, f.multiply(f.real(THERE), lane.step(layout.step)))
        told = f.new(f"select i1 {there}, i64 {k}, i64 {len(plan.borders)}")
    with f.when(found):
        f.store(time, reach)
        f.store_whole(told, event)


def _cut_step(f: Function, lane: _Lane, plan: Plan, layout: Layout, reach: Value, event: Value) -> None:
    """Goes back to where the first border is crossed."""
    with f.when(f.compare_whole("sge", f.load_whole(event), "0")):
        for k in range(layout.states):
            coefficients_of = [lane.step(k * layout.terms + j) for j in range(layout.terms)]
            lane.set(k, f.polynomial(f.load(reach), coefficients_of))
        for k in range(len(layout.equations)):
            row = layout.root_terms + k * layout.terms
            lane.set(layout.roots + k, f.polynomial(f.load(reach), [lane.step(row + j) for j in range(layout.terms)]))
        time, low = _later(f, lane.step(layout.step_time), lane.step(layout.step_low), f.load(reach))
        lane.set(layout.time, time)
        lane.set(layout.time_low, low)


def _pass_border(f: Function, lane: _Lane, plan: Plan, layout: Layout, border: Border, k: int, status: Value) -> None:
    """The event itself: the member ends, or its switch flips. An event in the direction that does not count only tells
    the side of the border."""
    side = lane.get(layout.sides + k)
    counts = f.compare("ogt", side, f.real(0.0)) if border.direction else f.compare_whole("eq", "0", "0")
    if not border.sided:
        lane.set(layout.sides + k, f.negative(side))
    with f.when(counts):
        if border.switch is None:
            f.store_whole(str(TERMINAL_EVENT + k), status)
        else:
            _count_dwell(lane, plan, layout)
            row = layout.switches + border.switch
            lane.set(row, f.negative(lane.get(row)))


def _count_dwell(lane: _Lane, plan: Plan, layout: Layout) -> None:
    """Adds the time since the last switch to that spent at the present signs of the switches: bit k of the place is set
    where switch k is negative."""
    f = lane.f
    if not plan.signs:
        return
    place = "0"
    for k in range(plan.signs):
        sign = f.whole("lshr", f.bits(lane.get(layout.switches + k)), "63")
        place = f.whole("or", place, f.whole("shl", sign, str(k)))
    row = f.whole("mul", f.whole("add", place, str(layout.dwell)), str(lane.width))
    address = f.place("%lane", row)
    time = lane.get(layout.time)
    f.store(f.add(f.load(address), f.subtract(time, lane.get(layout.since))), address)
    lane.set(layout.since, time)


def _start(plan: Plan, layout: Layout) -> Function:
    """``start(lanes, job, words, store)``: a member for each slot, as many as the job tells."""
    f = Function("start", ["ptr %lanes", "ptr %job", "ptr %words", "ptr %store"], "void", 1, external=True)
    for k in range(layout.rings):
        f.store_whole("0", f.place("%words", k))
    count = f.slot()
    f.store_whole("0", count)
    with f.repeat() as out:
        slot = f.load_whole(count)
        f.leave(out, f.compare_whole("sge", slot, f.load_whole(f.place("%job", Job.SLOTS))))
        f.line(f"call void @refill(i64 {slot}, ptr %lanes, ptr %job, ptr %words, ptr %store)")
        f.store_whole(f.whole("add", slot, "1"), count)
    f.finish()
    return f
