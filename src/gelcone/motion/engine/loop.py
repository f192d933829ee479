"""The compiled loop: lanes that advance together, each with its own member, step, end and samples.

The vector part advances all lanes by a Taylor step of their own length. Lanes for which something is due - a sample,
the end, a corner, a failure, perhaps a crossed border - are then served one by one in scalar code. A lane whose member
is done takes the next one from a queue that all threads share.

Step size: the last two coefficients of the states bound what a step leaves out,
    h = min over k in (p - 1, p) of (tolerance max(small, |x_0|) / |x_k|)^(1/k),   |.| the largest of all states,
as in Jorba & Zou, Experimental Mathematics 14 (2005) 99, sec. 3.2. Roots of equations and border functions bound the
step as well: between poles of a border function the states may allow steps on which its polynomial says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

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
    NEXT = 19  # the member that the next free lane takes


@dataclass(frozen=True)
class Border:
    """A traced event: its function, direction, the place of its switch (None: terminal), and whether it is ``sided``:
    whether the function is known to be positive (direction -1) where a member is; ``smooth`` and ``seldom`` are those
    of the event."""

    value: Node
    direction: int
    switch: int | None
    sided: bool
    smooth: bool
    seldom: bool


@dataclass(frozen=True)
class Plan:
    """All that the code of a program depends on.

    ``restarts``: what the states are set to after each sample (None leaves them); steps then end at the samples, else
    samples are read from the Taylor polynomial. ``corner_switch``: place of the switch that flips at corners, the last
    of those whose signs are counted; ``corner_time``: behind it, that of the number that takes the corner's time.
    """

    rates: tuple[Node, ...]
    borders: tuple[Border, ...]
    equations: tuple[Equation, ...]
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
    def roots(self) -> list[Node]:
        """All nodes that are wanted."""
        return [*self.rates, *(border.value for border in self.borders)]


class Layout:
    """Rows of a lane, ``width`` numbers each, and of the scratch room that keeps the last step."""

    def __init__(self, plan: Plan) -> None:
        self.states = len(plan.rates)
        self.held = held_values([*plan.roots, *(slope for equation in plan.equations for slope in equation.slopes)])
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
            self.sample,
            self.corner_number,
            self.table,
        ) = range(first, first + 13)
        self.switches = self.table + len(self.held)
        self.sides = self.switches + len(plan.switches)
        self.roots = self.sides + len(plan.borders)
        self.dwell = self.roots + len(plan.equations)
        self.combinations = 2**plan.signs if plan.signs else 0
        self.since = self.dwell + self.combinations
        self.rows = self.since + 1
        self.terms = plan.order + 1
        self.borders = self.states * self.terms
        self.root_terms = self.borders + len(plan.borders) * self.terms
        self.step_time = self.root_terms + len(plan.equations) * self.terms
        self.step_low = self.step_time + 1
        self.step = self.step_time + 2
        self.scratch_rows = self.step_time + 3


def module_text(plan: Plan) -> str:
    """The LLVM module of a program: ``prepare``, ``start`` and ``advance``, and what these call."""
    layout = Layout(plan)
    made = [
        _prepare(plan, layout),
        _refill(plan, layout),
        *([crossing_function(plan.order, plan.width)] if plan.borders else []),
        _serve(plan, layout),
        _start(plan),
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


def _advance(plan: Plan, layout: Layout) -> Function:
    """``advance(lanes, scratch, job, active, most)``: up to ``most`` steps of all lanes; returns how many were made.

    ``active`` points to a word with one bit for each lane that has a member.
    """
    arguments = ["ptr noalias %lanes", "ptr noalias %scratch", "ptr %job", "ptr %active", "i64 %most"]
    f = Function("advance", arguments, "i64", plan.width, external=True)
    width = plan.width
    count = f.slot()
    f.store_whole("0", count)

    def row(k: int) -> Value:
        return f.place("%lanes", k * width)

    with f.repeat() as out:
        f.leave(out, f.new(f"icmp eq i64 {f.load_whole('%active')}, 0"))
        done = f.load_whole(count)
        f.leave(out, f.new(f"icmp sge i64 {done}, %most"))
        f.store_whole(f.new(f"add i64 {done}, 1"), count)

        states = [f.load(row(k)) for k in range(layout.states)]
        time, low = f.load(row(layout.time)), f.load(row(layout.time_low))
        held = {node.index: f.load(row(layout.table + k)) for k, node in enumerate(layout.held)}
        held |= {node.index: f.load(row(layout.switches + k)) for k, node in enumerate(plan.switches)}
        kept = [row(layout.roots + k) for k in range(len(plan.equations))]
        borders = [(border.value, SELDOM_ORDER if border.seldom else plan.order) for border in plan.borders]
        jet = Jet(f, plan.rates, borders, plan.order, states, time, held, plan.equations, kept)
        wanted = _step_size(f, jet, plan)
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
        _bound_seldom(f, jet, plan, layout, step)
        near = _near(f, jet, plan, layout, step)
        due = f.either(f.either(ends, sampled), f.either(small, spent))
        due = f.either(due, f.new(f"xor {f.truth_type} {finite}, splat (i1 true)"))
        for mask in near:
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
        due_bits, *bits = (
            f.new(f"zext {word} {f.new(f'bitcast {f.truth_type} {mask} to {word}')} to i64")
            for mask in (due, finite, small, *near)
        )
        flagged = f.new(f"and i64 {due_bits}, {f.load_whole('%active')}")
        with f.when(f.new(f"icmp ne i64 {flagged}, 0")):
            _keep_step(f, jet, plan, layout, time, low, step)
            _serve_each(f, flagged, *bits)
    f.finish(f"i64 {f.load_whole(count)}")
    return f


def _step_size(f: Function, jet: Jet, plan: Plan) -> Value:
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
        rows = [
            row
            for row, border in zip(jet.borders, plan.borders, strict=True)
            if border.smooth == smooth and not border.seldom
        ]
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


def _side(f: Function, layout: Layout, border: Border, k: int) -> Value:
    """The sign that makes a border function positive on the member's side."""
    side = f.load(f.place("%lanes", (layout.sides + k) * f.width))
    return f.negative(side) if border.direction > 0 else side


def _bound_seldom(f: Function, jet: Jet, plan: Plan, layout: Layout, step: Value) -> None:
    """Takes from the last coefficient of borders of low order m what the next ones may hold, on the member's side:
    |g_m| h^m + |g_(m-1)| h^(m-1)/2. Coefficients times h^k fall to a seventh or so from order to order."""
    for k, (border, g) in enumerate(zip(plan.borders, jet.borders, strict=True)):
        if border.seldom:
            before, last = (f.real(0.0) if value is None else value for value in g[-2:])
            rest = f.fused(
                f.divide(f.real(0.5), f.larger(step, f.real(SHORTEST))), f.absolute(before), f.absolute(last)
            )
            g[-1] = f.subtract(last, f.multiply(_side(f, layout, border, k), rest))


def _near(f: Function, jet: Jet, plan: Plan, layout: Layout, step: Value) -> list[Value]:
    """Lanes that may cross each border in this step: with the sign that makes g positive on the member's side, those in
    which g_0 + g_1 t - b t^2 is not at t = 0, at t = h or between, b = |g_3| h + |g_4| h^2 + ... - g_2."""
    near = []
    for k, (border, coefficients) in enumerate(zip(plan.borders, jet.borders, strict=True)):
        g = [f.real(0.0) if value is None else value for value in coefficients]
        sign = _side(f, layout, border, k)
        value, slope, curve = (f.multiply(sign, part) for part in g[:3])
        rest = f.polynomial(step, [f.real(0.0), *(f.absolute(part) for part in g[3:])])
        bend = f.subtract(rest, curve)
        last = f.fused(f.fused(f.negative(bend), step, slope), step, value)
        ends = f.compare("ule", f.smaller(value, last), f.real(0.0))
        valley = f.both(f.compare("olt", slope, f.real(0.0)), f.compare("olt", bend, f.real(0.0)))
        deep = f.compare("oge", f.multiply(slope, slope), f.multiply(f.multiply(f.real(-4.0), bend), value))
        near.append(f.either(ends, f.both(valley, deep)))
    return near


def _keep_step(f: Function, jet: Jet, plan: Plan, layout: Layout, time: Value, low: Value, step: Value) -> None:
    """Puts the step's polynomials where the scalar code finds them; of states that no one reads inside of a step, the
    start alone."""
    terms = layout.terms if plan.borders or not _ends_at_samples(plan) else 1
    rows = [(i * layout.terms + k, value) for i, row in enumerate(jet.states) for k, value in enumerate(row[:terms])]
    rows += [
        (layout.borders + i * layout.terms + k, value)
        for i, row in enumerate(jet.borders)
        for k, value in enumerate([*row, *[None] * (terms - len(row))])
    ]
    if plan.borders:
        rows += [
            (layout.root_terms + i * layout.terms + k, value)
            for i, row in enumerate(jet.roots)
            for k, value in enumerate(row)
        ]
    rows += [(layout.step_time, time), (layout.step_low, low), (layout.step, step)]
    for k, value in rows:
        f.store(f.real(0.0) if value is None else value, f.place("%scratch", k * f.width))


def _serve_each(f: Function, flagged: Value, *bits: Value) -> None:
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
        lanes, scratch = f.place("%lanes", lane), f.place("%scratch", lane)
        told = ", ".join(f"i1 {flag}" for flag in flags)
        f.line(f"call void @serve(ptr {lanes}, ptr {scratch}, ptr %job, i64 {lane}, ptr %active, {told})")


# --- the scalar part -----------------------------------------------------------------------------------------------


class _Lane:
    """Scalar access to the rows of the lane that ``%lane`` and ``%scratch`` point to, and to the job."""

    def __init__(self, f: Function, width: int) -> None:
        self.f, self.width = f, width

    def place(self, row: int) -> Value:
        return self.f.place("%lane", row * self.width)

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


def _refill(plan: Plan, layout: Layout) -> Function:
    """``refill(lane, job, number, active)``: the next member for a lane, or its end when there is none."""
    f = Function("refill", ["ptr %lane", "ptr %job", "i64 %number", "ptr %active"], "void", 1)
    lane = _Lane(f, plan.width)
    member = f.new(f"atomicrmw add ptr {f.place('%job', Job.NEXT)}, i64 1 monotonic")
    with f.when(f.compare_whole("sge", member, lane.size(Job.MEMBERS))):
        # a lane without member stands still
        bit = f.whole("shl", "1", "%number")
        f.store_whole(f.whole("and", f.load_whole("%active"), f.whole("xor", bit, "-1")), "%active")
        lane.set(layout.stop, lane.get(layout.time))
        lane.set(layout.time_low, f.real(0.0))
        f.finish_here()
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
    for k in range(len(plan.equations)):
        lane.set(layout.roots + k, f.real(0.0))
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
    f.finish()
    return f


def _serve(plan: Plan, layout: Layout) -> Function:
    """``serve(lane, scratch, job, number, active, finite, small, near0, ...)``: what is due in one lane after a step;
    a flag for each border tells whether it may be near."""
    near = [f"%near{k}" for k in range(len(plan.borders))]
    arguments = ["ptr %lane", "ptr %scratch", "ptr %job", "i64 %number", "ptr %active", "i1 %finite", "i1 %small"]
    f = Function("serve", [*arguments, *(f"i1 {flag}" for flag in near)], "void", 1)
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
        f.line("call void @refill(ptr %lane, ptr %job, i64 %number, ptr %active)")
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
        for k in range(len(plan.equations)):
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


def _start(plan: Plan) -> Function:
    """``start(lanes, job, active)``: a member for each lane."""
    f = Function("start", ["ptr %lanes", "ptr %job", "ptr %active"], "void", 1, external=True)
    f.store_whole(str((1 << plan.width) - 1), "%active")
    for lane in range(plan.width):
        f.line(f"call void @refill(ptr {f.place('%lanes', lane)}, ptr %job, i64 {lane}, ptr %active)")
    f.finish()
    return f
