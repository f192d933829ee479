"""Equations of roots, from the graph of their residuals."""

import pytest

from gelcone.motion.engine.equations import equations_of
from gelcone.physics.trace import Graph


def test_an_equation_without_its_root_is_refused():
    graph = Graph()
    with pytest.raises(ValueError, match="root 'y': its equation does not contain it"):
        equations_of([graph.root("y", lambda y, x, xp: x, [graph.state(0)], lambda x, xp: x)])


def test_of_two_roots_that_depend_on_each_other_each_has_its_own_longest_step():
    def inner(root, other, x, xp):
        return root - 0.3 * other - x

    def outer(root, x, xp):
        return root + 0.5 * xp.root("inner", inner, [root, x], lambda *at: 1.0, 0.1) - x

    graph = Graph()
    found = equations_of([graph.root("outer", outer, [graph.state(0)], lambda *at: 1.0, 0.4)])
    assert {(equation.root.value, len(equation.block)): equation.longest for equation in found} == {
        ("outer", 2): 0.4,
        ("inner", 2): 0.1,
    }
