import json

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binomtest

from gelcone.atlas.distribution import Uniform
from gelcone.atlas.plan import Plan
from gelcone.atlas.probability import probability
from gelcone.atlas.sweep import sweep
from gelcone.atlas.uncertain import draw
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel

FAST = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"transient": 300.0, "budget": 1500.0, "patience": 300.0}


def test_draws_without_a_grid():
    result = sweep(Plan(FAST, {}, draws=draw({"voltage": Uniform(0.1, 0.4)}, 4), options=QUICK))
    assert result["regime"].dims == ("draw",)
    assert float(probability(result, Regime.REST)["probability"]) == 1.0


def made_up(regimes, outcomes=None):
    regimes = np.asarray(regimes, dtype=np.int8)
    outcomes = np.zeros(regimes.shape, dtype=np.int8) if outcomes is None else np.asarray(outcomes, dtype=np.int8)
    return xr.Dataset(
        {"regime": (("voltage", "draw"), regimes), "outcome": (("voltage", "draw"), outcomes)},
        coords={"voltage": np.arange(len(regimes))},
        attrs={"model": json.dumps(FAST.parameters())},
    )


def test_probability_and_its_interval_are_those_of_the_binomial():
    chaos, rest, open_, left = Regime.CHAOTIC, Regime.REST, Regime.TRANSIENT, Regime.LEFT_THE_DOMAIN
    rows = [[chaos] * 3 + [rest] * 5, [rest] * 8, [chaos] * 8, [chaos, rest, left, open_] * 2, [open_] * 8]
    chance = probability(made_up(rows))
    for row, (k, n) in zip(range(4), [(3, 8), (0, 8), (8, 8), (2, 6)], strict=True):
        interval = binomtest(k, n).proportion_ci(0.95, method="exact")
        assert float(chance["probability"][row]) == k / n
        assert float(chance["low"][row]) == pytest.approx(interval.low, abs=1e-12)
        assert float(chance["high"][row]) == pytest.approx(interval.high, abs=1e-12)
    assert np.isnan(chance["probability"][4])
    assert (float(chance["low"][4]), float(chance["high"][4]), int(chance["decided"][4])) == (0.0, 1.0, 0)
    for outcome in (Outcome.ERROR, Outcome.STEP_LIMIT, Outcome.IMPOSSIBLE):
        failed = probability(made_up([[chaos, rest]], [[outcome, Outcome.OK]]))
        assert (float(failed["probability"][0]), int(failed["decided"][0])) == (0.0, 1)


def test_the_interval_covers_as_often_as_it_says():
    rng, truth = np.random.default_rng(2), 0.3
    rows = np.where(rng.random((2000, 20)) < truth, Regime.CHAOTIC, Regime.REST)
    chance = probability(made_up(rows), confidence=0.9)
    assert ((chance["low"] <= truth) & (truth <= chance["high"])).mean() > 0.9


def test_a_probability_needs_draws():
    with pytest.raises(InputError, match="no draws of the regime"):
        probability(made_up([[0]]).isel(draw=0))
    with pytest.raises(InputError, match="confidence = 1"):
        probability(made_up([[0]]), confidence=1.0)


def test_cells_that_are_missing_are_not_counted():
    chance = probability(made_up([[Regime.CHAOTIC, -1, Regime.REST, -1]]))
    assert (float(chance["probability"][0]), int(chance["decided"][0])) == (0.5, 2)
