"""Equations of roots, from the graph of their residuals."""

import pytest

from gelcone.motion.engine.equations import equations_of
from gelcone.physics.trace import Graph


def test_an_equation_without_its_root_is_refused():
    graph = Graph()
    with pytest.raises(ValueError, match="root 'y': its equation does not contain it"):
        equations_of([graph.root("y", lambda y, x, xp: x, [graph.state(0)], lambda x, xp: x)])
