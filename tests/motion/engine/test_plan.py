"""Where numbers are: no row of a lane, of the scratch room or of the words belongs to two."""

import numpy as np
import pytest

from gelcone.motion.engine.equations import equations_of
from gelcone.motion.engine.interruptions import border_events, corner_numbers
from gelcone.motion.engine.plan import CROWD, Job, Law, Layout, Plan
from gelcone.motion.engine.program import Program
from gelcone.physics.model import ConeModel
from gelcone.physics.trace import Graph, ordered

MODELS = {
    "cone": ConeModel(),
    "laws": ConeModel(film="wrinkling", viscous_modulus_1=0.5, relaxation_time_1=3.0, waveform="square"),
    "pair": ConeModel(film="taut", second_film="wrinkling", series_resistance=0.3, current_limit=0.8),
}


def plan_of(name, keep="states", width=4) -> Plan:
    system = MODELS[name].system
    return Program(system, keep, 1e-6, border_events(system), **corner_numbers(system))._plan(width)


def covers(blocks, total):
    """Whether blocks (begin, length) lie side by side from 0 to ``total``."""
    taken = sorted((begin, begin + length) for begin, length in blocks if length)
    return [begin for begin, _ in taken] == [0, *(end for _, end in taken[:-1])] and taken[-1][1] == total


@pytest.mark.parametrize("keep", ["states", "tangents", "work"])
@pytest.mark.parametrize("name", MODELS)
def test_rows_scratch_and_words_are_parted_without_gaps(name, keep):
    plan = plan_of(name, keep)
    layout, laws, equations = Layout(plan), len(plan.laws), len(Layout(plan).equations)
    single = ("time", "time_low", "target", "stop", "corner", "smallest", "most_steps", "least", "steps", "member")
    rows = [(getattr(layout, each), 1) for each in (*single, "slot", "sample", "corner_number", "since", "in_place")]
    rows += [(0, layout.states), (layout.table, len(layout.held)), (layout.switches, len(plan.switches))]
    rows += [(layout.sides, len(plan.borders)), (layout.roots, equations), (layout.dwell, layout.combinations)]
    assert covers(rows, layout.rows)
    terms = plan.order + 1
    scratch = [(0, layout.states * terms), (layout.borders, len(plan.borders) * terms)]
    scratch += [(layout.root_terms, equations * terms)]
    scratch += [(getattr(layout, each), 1) for each in ("step_time", "step_low", "step")]
    assert covers(scratch, layout.scratch_rows)
    words = [(0, laws), (layout.waiting, laws), (layout.heads, laws), (layout.rings, laws * plan.slots)]
    words += [(layout.code, laws), (layout.serve, 1), (layout.missing, 1)]
    assert covers(words, layout.words)


def test_slots_are_the_lanes_of_a_single_law_and_some_more_of_several():
    """A power of 2: the places of a ring are counted by its bits."""
    for name in MODELS:
        for width in (1, 4, 8):
            plan = plan_of(name, width=width)
            laws = len(plan.laws)
            assert plan.slots == (width if laws == 1 else CROWD * laws * width)
            assert plan.slots & (plan.slots - 1) == 0
    assert len(plan_of("laws").laws) == 4


def test_each_combination_of_signs_has_its_dwell_and_pieces_have_none():
    plan = plan_of("laws")
    assert plan.pieces == 6
    assert plan.signs == len(plan.switches) - 6 > 0
    assert [Layout(plan_of(name)).combinations for name in MODELS] == [0, 4, 128]
    assert [plan_of(name).signs for name in MODELS] == [0, 2, 7]
    names = [node.value for node in plan.switches]
    assert names[plan.signs :] == list(corner_numbers(MODELS["laws"].system)["pieces"])


def test_steps_end_at_samples_where_something_restarts_there():
    assert plan_of("cone", "tangents").ends_at_samples
    assert not plan_of("cone").ends_at_samples
    assert not plan_of("cone", "work").ends_at_samples


def test_what_is_held_of_a_law_covers_its_equations_too():
    for law in plan_of("laws").laws:
        held = {node.index for node in law.held}
        parts = [node for equation in law.equations for node in (*equation.slopes, equation.first)]
        for node in ordered([*law.wanted, *parts]):
            for argument in node.arguments if not node.fixed else ():
                assert not argument.fixed or argument.operation == "constant" or argument.index in held
    plan = plan_of("laws")
    indices = [node.index for node in Layout(plan).held]
    assert sorted(indices) == sorted({node.index for law in plan.laws for node in law.held})


def test_a_root_has_one_place_in_all_laws():
    plan = plan_of("laws")
    layout = Layout(plan)
    places = {}
    for law in plan.laws:
        for equation in law.equations:
            assert places.setdefault(equation.root.index, layout.root(equation)) == layout.root(equation)
    assert sorted(places.values()) == list(range(len(layout.equations)))


def test_the_fields_of_a_job_are_counted_from_zero():
    np.testing.assert_array_equal([int(field) for field in Job], np.arange(len(Job)))


def test_what_only_the_first_guess_of_a_root_takes_is_held():
    graph = Graph()
    x, a, b = graph.state(0), graph.number("a"), graph.number("b")
    root = graph.root("y", lambda y, x, xp: y * y * b - x, [x], lambda x, xp: x * xp.exp(a))
    law = Law((root,), (x,), equations_of([root]))
    assert {graph.exp(a), b} <= set(law.held)
    assert law.wanted == [root, x]
