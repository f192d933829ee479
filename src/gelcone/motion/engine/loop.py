"""The compiled loop: lanes that advance together, each with its own member, step, end and samples.

The vector part advances all lanes by Taylor steps of individual length. Lanes with a sample, an end, a corner, a
failure or perhaps a crossed border are then served one by one in scalar code. A finished member makes room for the next
one in a queue that all threads share.

If switches change the law of the motion, each law has its own code of a step and its own lanes: a member that crosses a
border moves to the lanes of its new law, or waits until one is free. The law with most members goes first, so that few
lanes of a vector stay empty. A thread works on more members than a vector holds; each has a slot, a record in which it
waits.

The vector part is in `gelcone.motion.engine.step`, the scalar one in `gelcone.motion.engine.service`.
"""

from __future__ import annotations

from gelcone.motion.engine.code import Function, Value
from gelcone.motion.engine.events import crossing_function
from gelcone.motion.engine.plan import SAME_THREAD, THREAD, Job, Layout, Plan
from gelcone.motion.engine.recurrences import fixed_values
from gelcone.motion.engine.service import enter_function, refill_function, serve_function, vacate_function
from gelcone.motion.engine.step import step_function


def module_text(plan: Plan) -> str:
    """The LLVM module of a program: ``prepare``, ``start``, ``advance``, ``serve``, the functions that they call, and
    ``step`` if there is one law."""
    layout = Layout(plan)
    return _text(
        _prepare(plan, layout),
        enter_function(plan, layout),
        vacate_function(plan, layout),
        refill_function(plan, layout),
        *([crossing_function(plan.order, plan.width)] if plan.borders else []),
        serve_function(plan, layout),
        _start(layout),
        _advance(plan, layout),
        *([step_function(plan, layout, 0)] if len(plan.laws) == 1 else []),
    )


def step_text(plan: Plan, law: int) -> str:
    """The LLVM module of ``step`` of one law of several, compiled when a member first needs it."""
    return _text(step_function(plan, Layout(plan), law))


def _text(*made: Function) -> str:
    declarations = sorted({line for function in made for line in function.intrinsics})
    return "\n".join([*declarations, "", *(function.text() for function in made)])


def _prepare(plan: Plan, layout: Layout) -> Function:
    """``prepare(numbers, table, padded)``: fills the table of held values from the numbers of all members."""
    f = Function("prepare", ["ptr %numbers", "ptr %table", "i64 %padded"], "void", plan.width, external=True)
    at = f.slot()
    f.store_whole("0", at)
    with f.repeat() as out:
        block = f.load_whole(at)
        f.leave(out, f.new(f"icmp sge i64 {block}, %padded"))

        def row(base: Value, k: int) -> Value:
            return f.place(base, f.new(f"add i64 {block}, {f.new(f'mul i64 %padded, {k}')}"))

        values = fixed_values(f, layout.held, lambda name: f.load(row("%numbers", plan.numbers.index(name))))
        for k, node in enumerate(layout.held):
            f.store(values[node.index], row("%table", k))
        f.store_whole(f.new(f"add i64 {block}, {plan.width}"), at)
    f.finish()
    return f


def _advance(plan: Plan, layout: Layout) -> Function:
    """``advance(lanes, scratch, job, words, store, most)``: up to ``most`` steps; returns their number.

    Each is a step of the lanes of the law with most members. Ends early if the ``step`` of a law is missing, and stores
    the law.
    """
    f = Function("advance", [*THREAD, "i64 %most"], "i64", 1, external=True)
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
        now = f.load_whole(chosen)
        step = f.place("%words", f.whole("add", now, str(layout.code)))
        f.store_whole(f.whole("add", now, "1"), f.place("%words", layout.missing))
        f.leave(out, f.compare_whole("eq", f.load_whole(step), "0"))
        f.store_whole("0", f.place("%words", layout.missing))
        f.store_whole(f.whole("add", done, "1"), count)
        f.line(f"call void {f.load_pointer(step)}({SAME_THREAD})")
    f.finish(f"i64 {f.load_whole(count)}")
    return f


def _start(layout: Layout) -> Function:
    """``start(lanes, job, words, store)``: fills the slots with members of the job."""
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
