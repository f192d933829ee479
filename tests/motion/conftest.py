"""Fixtures of the tests of motion."""

import pytest

from gelcone.motion import equilibrium, ramp, static_bifurcations, static_results
from tests.motion.balances import Balance


@pytest.fixture
def balances(monkeypatch):
    """Two balances in the place of any model's, which rest at 0.5 and at where they are started from."""
    own, asked = [Balance(1.0), Balance(2.0)], []
    made_up = {
        "balances_of": lambda model, *more: asked.append((model, *more)) or own[: model.size],
        "every_balance": lambda model, *more: asked.append((model, *more)) or own[: model.size],
        "rest_of": lambda balance, start: 0.5 * balance.at if start is None else start,
    }
    for module in (equilibrium, ramp, static_bifurcations, static_results):
        for name in made_up.keys() & vars(module).keys():
            monkeypatch.setattr(module, name, made_up[name])
    return asked
