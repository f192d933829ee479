"""The text of a program for one member at a time, and of formulas at a point, for translation to C.

At width 1 the text has some thirty kinds of instructions and calls no external function, so that another language runs
the same operations in the same order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gelcone.motion.engine.code import Function
from gelcone.motion.engine.equations import equations_of
from gelcone.motion.engine.interruptions import border_events
from gelcone.motion.engine.jet import Jet
from gelcone.motion.engine.loop import module_text, step_text
from gelcone.motion.engine.plan import ARRIVED, Job, Law, Layout, Plan
from gelcone.motion.engine.program import Program
from gelcone.motion.engine.recurrences import fixed_values
from gelcone.motion.job import Ended, Portable
from gelcone.physics.system import ConeSystem
from gelcone.physics.trace import Graph, Node, ordered
from gelcone.quantity import Array

Outputs = Callable[[Node, Sequence[Node], Mapping[str, Node], Graph], Mapping[str, tuple[Any, Any]]]
"""Function of time, states and numbers that gives the outputs at a point by name, each with None, or with what is added
to its rate of change, which then is an output, too."""


@dataclass
class Text(Portable):
    """The text, and the program compiled from it."""

    program: Program

    def run(
        self, numbers: Mapping[str, Any], states: Array, length: float, smallest_step: float, most_steps: float
    ) -> Ended:
        """Run one member by the compiled program from time 0 over a length."""
        given = {name: [value] for name, value in numbers.items()}
        raw = self.program.run(
            given, states[None], 0.0, [[length]], smallest_step=[smallest_step], most_steps=[most_steps]
        )
        arrived = raw.status[0] == ARRIVED
        switches = {name: float(values[0]) for name, values in raw.switches.items()}
        states = raw.states[0, 0] if arrived else raw.end_state[0]
        return Ended(int(raw.status[0]), length if arrived else float(raw.end_time[0]), states, switches)


def portable(system: ConeSystem, outputs: Outputs, tolerance: float) -> Text:
    """Make the text of the program that integrates a system without corners, and of its outputs at a point."""
    program = Program(system, "states", tolerance, border_events(system))
    plan = program._plan(1)
    layout = Layout(plan)
    several = len(plan.laws) > 1
    made = [_point(system, plan, law, outputs) for law in range(len(plan.laws))]
    held = {node.value for node in ordered(layout.held) if node.operation == "number"}
    sizes = {
        "states": layout.states,
        "laws": len(plan.laws),
        "rows": layout.rows,
        "scratch": layout.scratch_rows,
        "words": layout.words,
        "held": len(layout.held),
        "combinations": layout.combinations,
        "code": layout.code,
        "serve": layout.serve,
        "roots": max(roots for _, _, roots, _ in made),
    }
    return Text(
        program=program,
        modules=(module_text(plan), *(step_text(plan, law) for law in range(len(plan.laws)) if several)),
        points=tuple(text for text, _, _, _ in made),
        outputs=made[0][1],
        sizes=sizes | {f"job_{field.name.lower()}": int(field) for field in Job} | {"job": len(Job)},
        numbers=plan.numbers,
        used=frozenset(held.union(*(names for _, _, _, names in made))),
        switches=tuple(node.value for node in plan.switches),
        telling=plan.telling,
        border_switches=tuple(-1 if border.switch is None else border.switch for border in plan.borders),
    )


def _point(system: ConeSystem, plan: Plan, law: int, outputs: Outputs) -> tuple[str, tuple[str, ...], int, set[str]]:
    """The function of a law at a point, the names of its results, the number of its roots, and its numbers."""
    graph, switched = Graph(), [node.value for node in plan.switches]
    z = [graph.state(i) for i in range(len(system.states))]
    n = {name: graph.switch(name) if name in switched else graph.number(name) for name in plan.numbers}
    n |= {switched[place]: graph.constant(-1.0 if law >> k & 1 else 1.0) for k, place in enumerate(plan.telling)}
    rates = [graph.node(rate) for rate in system.rates(graph.time, z, n, graph)]
    requested = outputs(graph.time, z, n, graph)
    values_of = [graph.node(value) for value, _ in requested.values()]
    added = {name: graph.node(addend) for name, (_, addend) in requested.items() if addend is not None}
    borders = [graph.node(border.value(graph.time, z, n, graph)) for _, border in system.borders]
    followed = [*values_of, *added.values(), *borders]
    point_law = Law(tuple(rates), tuple(followed), equations_of([*rates, *followed]))
    arguments = ["ptr %z", "double %time", "ptr %numbers", "ptr %switches", "ptr %roots", "ptr %out"]
    f = Function(f"point_{law}", arguments, "void", 1, external=True)
    values = fixed_values(f, point_law.held, lambda name: f.load(f.place("%numbers", plan.numbers.index(name))))
    values |= {graph.switch(name).index: f.load(f.place("%switches", k)) for k, name in enumerate(switched)}
    orders = [*(int(name in added) for name in requested), *[0] * (len(added) + len(borders))]
    states = [f.load(f.place("%z", k)) for k in range(len(z))]
    roots = [f.place("%roots", k) for k in range(len(point_law.equations))]
    jet = Jet(
        f, rates, list(zip(followed, orders, strict=True)), 1, states, "%time", values, point_law.equations, roots
    )
    named_values = {f"rate_{k}": row[1] for k, row in enumerate(jet.states)}
    plus = dict(zip(added, (row[0] for row in jet.borders[len(requested) :]), strict=False))
    for name, row in zip(requested, jet.borders, strict=False):
        named_values[name] = row[0]
        if name in plus:
            named_values[f"{name}_rate"] = _sum(f, row[1], plus[name])
    named_values |= {f"border_{k}": row[0] for k, row in enumerate(jet.borders[len(requested) + len(added) :])}
    for k, value in enumerate(named_values.values()):
        f.store(f.real(0.0) if value is None else value, f.place("%out", k))
    f.finish()
    names = {node.value for node in ordered(point_law.held) if node.operation == "number"}
    return f.text(), tuple(named_values), len(point_law.equations), names


def _sum(f: Function, a: str | None, b: str | None) -> str | None:
    """The sum of two values, None for 0."""
    return a or b if a is None or b is None else f.add(a, b)


def formulas_text(name: str, leaves: Sequence[str], nodes: Mapping[int, Node]) -> str:
    """The function ``name(given, found)`` that evaluates nodes of the numbers ``leaves`` to places of ``found``."""
    f = Function(name, ["ptr %given", "ptr %found"], "void", 1, external=True)
    values = fixed_values(f, list(nodes.values()), lambda leaf: f.load(f.place("%given", leaves.index(leaf))))
    for place, node in nodes.items():
        f.store(values[node.index], f.place("%found", place))
    f.finish()
    return f.text()
