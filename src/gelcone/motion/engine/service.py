"""The scalar part of the compiled loop: samples, events, corners and ends of single lanes."""

from __future__ import annotations

import math
from collections.abc import Iterable

from gelcone.motion.engine.code import Function, Value
from gelcone.motion.engine.events import ON_BORDER
from gelcone.motion.engine.plan import (
    ARRIVED,
    MOST_IN_PLACE,
    NOT_FINITE,
    STEP_TOO_SMALL,
    TERMINAL_EVENT,
    TOO_MANY_STEPS,
    Border,
    Job,
    Layout,
    Plan,
)
from gelcone.motion.engine.step import later

THERE = 2.0**-13
"""Share of a step below which the polynomial of low order of a border that is seldom near is exact."""

PAST = 2.0**-6
"""Share of a step that is taken without a gentle border whose switch flips without end."""
AT_ONCE = 2.0**-40
"""Largest relative difference between the times of switches that come at once."""


class _Lane:
    """Scalar access to the rows of the lane at ``base``, ``width`` places apart, to those of the last step at
    ``%scratch``, and to the job. A slot is a lane of width 1."""

    def __init__(self, f: Function, width: int, base: Value = "%lane") -> None:
        self.f, self.width, self.base = f, width, base

    def place(self, row: int | Value) -> Value:
        return self.f.place(self.base, row * self.width if isinstance(row, int) else self.times(row, self.width))

    def take(self, other: _Lane, layout: Layout) -> None:
        """Copies all rows of another lane."""
        with self.f.each(layout.rows) as row:
            self.set_whole(row, other.get_whole(row))

    def dwell(self, layout: Layout, number: Value) -> Value:
        """The address of the time spent at a combination of signs of the switches."""
        return self.place(self.f.whole("add", number, str(layout.dwell)))

    def get(self, row: int) -> Value:
        return self.f.load(self.place(row))

    def set(self, row: int, value: Value) -> None:
        self.f.store(value, self.place(row))

    def get_whole(self, row: int | Value) -> Value:
        return self.f.load_whole(self.place(row))

    def set_whole(self, row: int | Value, value: Value) -> None:
        self.f.store_whole(value, self.place(row))

    def step(self, row: int) -> Value:
        return self.f.load(self.f.place("%scratch", row * self.width))

    def array(self, field: Job, *index: Value) -> Value:
        """The address of an element: that of the array plus the sum of the index."""
        address = self.f.load_pointer(self.f.place("%job", field))
        for part in index:
            address = self.f.place(address, part)
        return address

    def size(self, field: Job) -> Value:
        return self.f.load_whole(self.f.place("%job", field))

    def times(self, a: Value, b: Value | int) -> Value:
        return self.f.new(f"mul i64 {a}, {b}")

    def set_stop(self, plan: Plan, layout: Layout, member: Value) -> None:
        """Sets the next time at which a step must end: a corner, the next sample, or the last one."""
        f = self.f
        end = self.get(layout.target)
        if not plan.ends_at_samples:
            samples = self.size(Job.SAMPLES)
            end = f.load(self.array(Job.TIMES, self.times(member, samples), f.whole("sub", samples, "1")))
        self.set(layout.stop, f.smaller(self.get(layout.corner), end))


def _slot(f: Function, layout: Layout, number: Value) -> _Lane:
    return _Lane(f, 1, f.place("%store", f.whole("mul", number, str(layout.rows))))


def _block_lane(f: Function, plan: Plan, layout: Layout, number: Value) -> _Lane:
    """A lane of the law ``%law``."""
    block = f.place("%lanes", f.whole("mul", "%law", str(layout.rows * plan.width)))
    return _Lane(f, plan.width, f.place(block, number))


def _ring(f: Function, plan: Plan, layout: Layout, number: Value) -> Value:
    """The address of an entry in the ring of the law ``%law``."""
    place = f.whole("and", number, str(plan.slots - 1))
    first = f.whole("add", f.whole("mul", "%law", str(plan.slots)), str(layout.rings))
    return f.place("%words", f.whole("add", first, place))


def enter_function(plan: Plan, layout: Layout) -> Function:
    """``enter(law, slot, lanes, words, store)``: gives the member of a slot a lane of its law, or lets it wait."""
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


def vacate_function(plan: Plan, layout: Layout) -> Function:
    """``vacate(law, number, lanes, words, store)``: gives a lane to the member that has waited longest, if any."""
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


def _sign_bits(lane: _Lane, layout: Layout, switches: Iterable[int]) -> Value:
    """Sign bits of some switches, 1 for negative; those of the switches that distinguish laws are the law's index."""
    f, bits = lane.f, "0"
    for k, switch in enumerate(switches):
        sign = f.whole("lshr", f.bits(lane.get(layout.switches + switch)), "63")
        bits = f.whole("or", bits, f.whole("shl", sign, str(k)))
    return bits


def refill_function(plan: Plan, layout: Layout) -> Function:
    """``refill(slot, lanes, job, words, store)``: gives a slot the next member, if there is one."""
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
    if layout.combinations:
        with f.each(layout.combinations) as place:
            f.store(f.real(0.0), lane.dwell(layout, place))
    lane.set(layout.time, f.load(lane.array(Job.START, member)))
    lane.set(layout.since, lane.get(layout.time))
    lane.set_whole(layout.in_place, "0")
    lane.set(layout.time_low, f.real(0.0))
    lane.set(layout.target, f.load(lane.array(Job.TIMES, lane.times(member, lane.size(Job.SAMPLES)))))
    lane.set(layout.corner, f.load(lane.array(Job.CORNERS, lane.times(member, lane.size(Job.CORNER_COUNT)))))
    lane.set_stop(plan, layout, member)
    lane.set(layout.smallest, f.load(lane.array(Job.SMALLEST, member)))
    lane.set(layout.most_steps, f.load(lane.array(Job.MOST_STEPS, member)))
    lane.set(layout.least, f.real(math.inf))
    lane.set(layout.steps, f.real(0.0))
    law = _sign_bits(lane, layout, plan.telling)
    f.line(f"call void @enter(i64 {law}, i64 %slot, ptr %lanes, ptr %words, ptr %store)")
    f.finish()
    return f


def serve_function(plan: Plan, layout: Layout) -> Function:
    """``serve(lane, scratch, law, number, lanes, job, words, store, finite, small, near0, ...)``: serves a lane after a
    step; the flag of each border is true if it may be near."""
    near = [f"%near{k}" for k in range(len(plan.borders))]
    lane_arguments = ["ptr %lane", "ptr %scratch", "i64 %law", "i64 %number"]
    shared = ["ptr %lanes", "ptr %job", "ptr %words", "ptr %store"]
    f = Function(
        "serve",
        [*lane_arguments, *shared, "i1 %finite", "i1 %small", *(f"i1 {flag}" for flag in near)],
        "void",
        1,
        True,
    )
    lane = _Lane(f, plan.width)
    member = lane.get_whole(layout.member)
    start, low = lane.step(layout.step_time), lane.step(layout.step_low)
    status, reach, event = f.slot(), f.slot(), f.slot()
    f.store_whole("-1", status)
    f.store_whole("-1", event)
    f.store(lane.step(layout.step), reach)

    failed = f.either("%small", f.opposite("%finite"))
    with f.when(failed):  # the step does not count: the member ends at its start
        total = f.real(0.0)
        for k in range(layout.states):
            total = f.add(total, lane.step(k * layout.terms))
        whole = f.compare("olt", f.absolute(total), f.real(math.inf))
        code = f.new(f"select i1 {f.both('%small', whole)}, i64 {STEP_TOO_SMALL}, i64 {NOT_FINITE}")
        f.store_whole(code, status)
        _end_without_value(f, lane, plan, layout, near, whole, status)
        for k in range(layout.states):
            lane.set(k, lane.step(k * layout.terms))
        lane.set(layout.time, start)
        lane.set(layout.time_low, low)
    with f.when(f.opposite(failed)):
        for k, flag in enumerate(near):
            with f.when(flag):
                _find_crossing(f, lane, plan, layout, k, reach, event)
        if plan.borders:
            _cut_step(f, lane, layout, reach, event)
        _take_samples(f, lane, plan, layout, member, reach, status)
        unfinished = f.compare_whole("slt", f.load_whole(status), "0")
        with f.when(unfinished):
            for k, border in enumerate(plan.borders):
                with f.when(f.compare_whole("eq", f.load_whole(event), str(k))):
                    _pass_border(f, lane, plan, layout, border, k, status)
            _pass_corner(f, lane, plan, layout, member)
            spent = f.compare("oge", lane.get(layout.steps), lane.get(layout.most_steps))
            with f.when(f.both(spent, f.compare_whole("slt", f.load_whole(status), "0"))):
                f.store_whole(str(TOO_MANY_STEPS), status)
    with f.when(f.compare_whole("sge", f.load_whole(status), "0")):
        _count_dwell(lane, plan, layout)
        if layout.combinations:
            with f.each(layout.combinations) as place:
                value = f.load(lane.dwell(layout, place))
                f.store(value, lane.array(Job.DWELL, lane.times(member, layout.combinations), place))
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
        law = _sign_bits(lane, layout, plan.telling)
        with f.when(f.compare_whole("ne", law, "%law")):
            for k in range(len(layout.equations)):
                lane.set(layout.roots + k, f.real(math.nan))
            slot = lane.get_whole(layout.slot)
            _slot(f, layout, slot).take(lane, layout)
            f.line("call void @vacate(i64 %law, i64 %number, ptr %lanes, ptr %words, ptr %store)")
            f.line(f"call void @enter(i64 {law}, i64 {slot}, ptr %lanes, ptr %words, ptr %store)")
    f.finish()
    return f


def _end_without_value(
    f: Function, lane: _Lane, plan: Plan, layout: Layout, near: list[str], whole: Value, status: Value
) -> None:
    """Ends a member with finite states, ``whole``, by the first terminal border whose function is NaN there: a root in
    it has been lost."""
    for k in reversed(range(len(plan.borders))):
        if plan.borders[k].switch is None:
            value = lane.step(layout.borders + k * layout.terms)
            gone = f.both(f.both(whole, near[k]), f.compare("uno", value, value))
            f.store_whole(f.new(f"select i1 {gone}, i64 {TERMINAL_EVENT + k}, i64 {f.load_whole(status)}"), status)


def _take_samples(
    f: Function, lane: _Lane, plan: Plan, layout: Layout, member: Value, reach: Value, status: Value
) -> None:
    """Stores all samples that the step passed; the member arrives with the last one."""
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
            if not plan.ends_at_samples:
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
    if plan.ends_at_samples:
        lane.set_stop(plan, layout, member)


def _pass_corner(f: Function, lane: _Lane, plan: Plan, layout: Layout, member: Value) -> None:
    """Loads the next corner, and the piece between, if the step ended at a corner."""
    with f.repeat() as out:  # pieces may have no length
        passed = lane.get(layout.corner)
        f.leave(out, f.compare("ult", lane.get(layout.time), passed))
        before = lane.get_whole(layout.corner_number)
        number = f.whole("add", before, "1")
        lane.set_whole(layout.corner_number, number)
        first = lane.times(member, lane.size(Job.CORNER_COUNT))
        lane.set(layout.corner, f.load(lane.array(Job.CORNERS, first, number)))
        if plan.pieces:
            row = layout.switches + plan.signs
            lane.set(row, passed)
            count = lane.size(Job.PIECE_COUNT)
            begun = f.load_whole(lane.array(Job.FIRST_PIECE, member))
            piece = f.whole("urem", f.whole("add", begun, before), count)
            place = f.whole("add", lane.times(member, count), piece)
            for k in range(plan.pieces - 1):
                term = lane.array(Job.PIECES, lane.times(place, plan.pieces - 1), str(k))
                lane.set(row + 1 + k, f.load(term))
        lane.set_stop(plan, layout, member)


def _find_crossing(f: Function, lane: _Lane, plan: Plan, layout: Layout, k: int, reach: Value, event: Value) -> None:
    """Shortens ``reach`` to the crossing of border k, if it is crossed, and sets ``event``.

    If the bound of a border of low order crosses zero, the step ends without an event, unless it is too short for the
    bound to differ from the border. So does it, after `PAST`, where the switch of a gentle border flips without end.
    """
    border = plan.borders[k]
    row = (layout.borders + k * layout.terms) * plan.width
    coefficients = f.place("%scratch", row)
    with f.when(f.compare("oeq", lane.get(layout.sides + k), f.real(0.0))):
        # the first step: the side of the member, or, on the border, the side to which it moves
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
    crossed = f.both(f.compare("ole", time, f.load(reach)), f.either(earlier, first))
    counted = str(k)
    if border.gentle:
        again = f.compare_whole("sgt", lane.get_whole(layout.in_place), str(MOST_IN_PLACE))
        unclear = f.both(again, _at_once(lane, layout, lane.step(layout.step_time)))
        past = f.smaller(f.multiply(f.real(PAST), lane.step(layout.step)), f.load(reach))
        time = f.choose(unclear, f.larger(time, past), time)
        counted = f.new(f"select i1 {unclear}, i64 {len(plan.borders)}, i64 {k}")
    if border.seldom:
        there = f.compare("olt", time, f.multiply(f.real(THERE), lane.step(layout.step)))
        counted = f.new(f"select i1 {there}, i64 {k}, i64 {len(plan.borders)}")
    with f.when(crossed):
        f.store(time, reach)
        f.store_whole(counted, event)


def _cut_step(f: Function, lane: _Lane, layout: Layout, reach: Value, event: Value) -> None:
    """Takes the states and roots back to the first crossing of a border."""
    with f.when(f.compare_whole("sge", f.load_whole(event), "0")):
        for k in range(layout.states):
            coefficients_of = [lane.step(k * layout.terms + j) for j in range(layout.terms)]
            lane.set(k, f.polynomial(f.load(reach), coefficients_of))
        for k in range(len(layout.equations)):
            row = layout.root_terms + k * layout.terms
            lane.set(layout.roots + k, f.polynomial(f.load(reach), [lane.step(row + j) for j in range(layout.terms)]))
        time, low = later(f, lane.step(layout.step_time), lane.step(layout.step_low), f.load(reach))
        lane.set(layout.time, time)
        lane.set(layout.time_low, low)


def _pass_border(f: Function, lane: _Lane, plan: Plan, layout: Layout, border: Border, k: int, status: Value) -> None:
    """Applies an event: the member ends, or its switch flips; it also ends if switches flip without end at a border
    that is not gentle.

    A crossing in the direction that does not count only changes the side of the border.
    """
    side = lane.get(layout.sides + k)
    counts = f.compare("ogt", side, f.real(0.0)) if border.direction else f.compare_whole("eq", "0", "0")
    if not border.sided:
        lane.set(layout.sides + k, f.negative(side))
    with f.when(counts):
        if border.switch is None:
            f.store_whole(str(TERMINAL_EVENT + k), status)
        else:
            before = lane.get_whole(layout.in_place)
            still = _at_once(lane, layout, lane.get(layout.time))
            count = f.new(f"select i1 {still}, i64 {f.whole('add', before, '1')}, i64 0")
            lane.set_whole(layout.in_place, count)
            if not border.gentle:
                with f.when(f.compare_whole("sgt", count, str(MOST_IN_PLACE))):
                    f.store_whole(str(TERMINAL_EVENT + k), status)
            _count_dwell(lane, plan, layout)
            row = layout.switches + border.switch
            lane.set(row, f.negative(lane.get(row)))


def _at_once(lane: _Lane, layout: Layout, now: Value) -> Value:
    """True if the last switch was at the time ``now`` but for rounding."""
    f = lane.f
    room = f.multiply(f.real(AT_ONCE), f.larger(f.absolute(now), f.real(1.0)))
    return f.compare("ole", f.subtract(now, lane.get(layout.since)), room)


def _count_dwell(lane: _Lane, plan: Plan, layout: Layout) -> None:
    """Adds the time since the last switch to that of the present signs of the switches; see `_sign_bits`."""
    f = lane.f
    if not plan.signs:
        return
    address = lane.dwell(layout, _sign_bits(lane, layout, range(plan.signs)))
    time = lane.get(layout.time)
    f.store(f.add(f.load(address), f.subtract(time, lane.get(layout.since))), address)
    lane.set(layout.since, time)
