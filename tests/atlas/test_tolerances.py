"""Tolerances: risks, quantiles and Sobol indices of draws, against closed forms and independent counts."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binom, binomtest

from gelcone import dataset
from gelcone.atlas import tolerances as module
from gelcone.atlas.distribution import Normal, Uniform
from gelcone.atlas.plan import Plan
from gelcone.atlas.sweep import sweep
from gelcone.atlas.tolerances import arranged, base_draws, sobol, stroke_quantiles, strokes_of, tolerances
from gelcone.atlas.uncertain import draw
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel

THREE = {"a": Uniform(0.0, 1.0), "b": Normal(0.0, 1.0), "c": Uniform(0.0, 1.0)}


def cells(draws, stroke, regime=None, outcome=None, breakdown=None, over=None):
    """A made-up sweep with draws."""
    count = len(next(iter(draws.values())))
    dims = ("voltage", "draw") if over is not None else ("draw",)
    shape = (len(over), count) if over is not None else (count,)
    regime = np.full(shape, int(Regime.PERIODIC)) if regime is None else regime
    outcome = np.zeros(shape, dtype=int) if outcome is None else outcome
    study = dataset.label(ConeModel(), {}, options={}, title="sweep: regime")
    variables = {"regime": regime, "outcome": outcome, "highest": stroke, "lowest": np.zeros(shape)}
    if breakdown is not None:
        variables["validity_breakdown"] = breakdown
    study = study.assign({name: (dims, np.broadcast_to(values, shape)) for name, values in variables.items()})
    study = study.assign_coords({f"drawn_{name}": ("draw", values) for name, values in draws.items()})
    return study.assign_coords(voltage=list(over)) if over is not None else study


def test_arranged_draws_are_recognised_and_others_are_not():
    draws = draw(THREE, 32, indices=True)
    assert arranged(draws) == 16
    assert len(draws["a"]) == 16 * 5
    a, b, mixed = draws["b"][:16], draws["b"][16:32], draws["b"][48:64]
    np.testing.assert_array_equal(mixed, b)  # the block of b takes it from the second
    np.testing.assert_array_equal(draws["b"][32:48], a)
    assert arranged(draw(THREE, 80)) == 0
    assert arranged({"a": np.arange(6.0)}) == 0
    swapped = dict(draws) | {"a": draws["a"][::-1]}
    assert arranged(swapped) == 0
    assert base_draws(cells(draws, draws["a"])).sizes["draw"] == 32
    assert base_draws(cells(draw(THREE, 30), 1.0)).sizes["draw"] == 30


def test_sobol_indices_are_those_of_the_ishigami_function():
    """Ishigami and Homma (1990): f = sin x + 7 sin^2 y + 0.1 z^4 sin x over (-pi, pi)."""
    ends = Uniform(-np.pi, np.pi)
    x, y, z = draw({"x": ends, "y": ends, "z": ends}, 4096, indices=True).values()
    found = sobol(np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x), 3)
    variance = 0.1 * np.pi**4 / 5.0 + 0.01 * np.pi**8 / 18.0 + 0.5 + 49.0 / 8.0
    first = np.array([0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0]) / variance
    with_z = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0) / variance
    total = first + np.array([with_z, 0.0, with_z])
    np.testing.assert_allclose(found[0, :, 0], first, atol=0.03)
    np.testing.assert_allclose(found[1, :, 0], total, atol=0.03)
    assert (found[..., 1] <= found[..., 0]).all()
    assert (found[..., 0] <= found[..., 2]).all()
    assert (np.abs(found[0, :, 1:] - first[:, None]) > 0.0).all()  # intervals have a width


def test_ends_of_the_indices_hold_the_truth_about_as_often_as_they_say():
    """A sum of two parameters: indices 0.8 and 0.2, alone and with interactions."""
    held = 0
    for seed in range(40):
        a, b = draw({"a": Normal(0.0, 2.0), "b": Normal(0.0, 1.0)}, 128, seed=seed, indices=True).values()
        ends = sobol(a + b, 2)[..., 1:]
        truth = np.array([0.8, 0.2])
        held += int(((ends[..., 0] <= truth) & (truth <= ends[..., 1])).sum())
    assert held >= 0.9 * 160


def test_an_interval_of_no_confidence_has_no_width_and_one_of_more_is_wider(monkeypatch):
    a, b = draw({"a": Normal(0.0, 2.0), "b": Normal(0.0, 1.0)}, 32, indices=True).values()
    widths = []
    for confidence in (0.0, 0.5, 0.95):
        monkeypatch.setattr(module, "CONFIDENCE", confidence)
        widths.append(np.diff(sobol(a + b, 2)[..., 1:], axis=-1))
    assert (widths[0] == 0.0).all()
    assert (widths[0] < widths[1]).all()
    assert (widths[1] < widths[2]).all()


@pytest.mark.parametrize("strokes", [np.full(8, 2.0), np.array([1.0, 2.0, np.nan, 3.0, 1.0, 2.0, 3.0, 4.0])])
def test_no_indices_of_a_stroke_that_is_constant_or_missing(strokes):
    assert np.isnan(sobol(strokes, 2)).all()


def test_quantiles_have_intervals_by_ranks():
    """The chance that the median lies between two ranks is binomial: at least 95 %, and the narrowest ranks."""
    values = np.random.default_rng(2).permutation(np.arange(1.0, 41.0))
    (low, middle, high), lows, highs = stroke_quantiles(values)
    assert middle == 20.5
    assert (low, high) == (np.quantile(values, 0.05), np.quantile(values, 0.95))
    assert binom.cdf(highs[1] - 1, 40, 0.5) - binom.cdf(lows[1] - 1, 40, 0.5) >= 0.95
    assert highs[1] - lows[1] <= 14
    assert np.isnan(lows[0])  # forty draws do not bound the lowest twentieth from below
    assert np.isnan(stroke_quantiles(np.array([1.0, np.nan]))).all()


def test_risks_are_shares_of_the_decided_draws_with_binomial_intervals():
    draws = draw({"a": Uniform(0.0, 1.0)}, 20)
    regime = np.array([int(Regime.CHAOTIC)] * 4 + [int(Regime.TRANSIENT)] * 3 + [int(Regime.PERIODIC)] * 8 + [5] * 5)
    outcome = np.array([0] * 15 + [Outcome.PULLED_IN] * 3 + [Outcome.STRETCH_LIMIT, Outcome.ERROR])
    field = np.array([0.1] * 6 + [0.0] * 10 + [np.nan] * 4)
    found = tolerances(cells(draws, 1.0, regime, outcome, field))
    assert found["risk"].values.tolist() == ["pull-in", "breakdown", "chaos"]
    for risk, hits, of in (("pull-in", 3, 19), ("breakdown", 6, 16), ("chaos", 4, 16)):
        one = found.sel(risk=risk)
        assert (float(one["probability"]), int(one["decided"])) == (hits / of, of)
        interval = binomtest(hits, of).proportion_ci()
        assert (float(one["low"]), float(one["high"])) == pytest.approx((interval.low, interval.high))
    unknown = tolerances(cells(draws, 1.0, regime, outcome)).sel(risk="breakdown")
    assert np.isnan(float(unknown["probability"]))
    assert (float(unknown["low"]), float(unknown["high"])) == (0.0, 1.0)


def test_the_extra_draws_of_indices_count_for_no_risk_and_no_quantile():
    draws = draw({"a": Uniform(0.0, 1.0), "b": Uniform(0.0, 1.0)}, 16, indices=True)
    extra = np.arange(32) >= 16
    regime = np.where(extra, int(Regime.CHAOTIC), int(Regime.PERIODIC))
    found = tolerances(cells(draws, np.where(extra, 9.0, draws["a"]), regime))
    assert float(found["probability"].sel(risk="chaos")) == 0.0
    assert int(found["decided"].sel(risk="chaos")) == 16
    assert float(found["stroke"].sel(quantile=0.95)) < 1.0


def test_rest_has_no_stroke_and_an_ended_run_none_at_all():
    regime = np.array([int(Regime.REST), int(Regime.PERIODIC), int(Regime.LEFT_THE_DOMAIN)])
    outcome = np.array([0, 0, int(Outcome.PULLED_IN)])
    study = cells({"a": np.arange(3.0)}, np.array([1e-30, 2.0, 3.0]), regime, outcome)
    np.testing.assert_equal(strokes_of(study).values, [0.0, 2.0, np.nan])


def test_each_point_of_a_grid_has_its_own_tolerances():
    draws = draw({"a": Uniform(0.0, 1.0), "b": Uniform(0.0, 1.0)}, 64, indices=True)
    stroke = np.stack([draws["a"], draws["b"]])
    made_up = cells(draws, stroke, over=[1.0, 2.0])
    found = tolerances(made_up)
    xr.testing.assert_identical(tolerances(made_up.transpose("draw", "voltage")), found)
    assert found["probability"].dims == ("voltage", "risk")
    assert found["first_order"].dims == ("voltage", "parameter", "end")
    for dim in ("risk", "quantile", "parameter", "end"):
        assert found[dim].attrs["long_name"]
        assert found[dim].attrs["units"] == "1"
    value = found["total_order"].sel(end="value")
    assert float(value.sel(voltage=1.0, parameter="a")) > 0.8 > 0.2 > float(value.sel(voltage=1.0, parameter="b"))
    assert float(value.sel(voltage=2.0, parameter="b")) > 0.8


def test_tolerances_of_a_sweep_are_those_of_its_cells():
    fast = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
    draws = draw({"voltage": Uniform(0.2, 1.6), "prestretch": Normal(1.0, 0.02)}, 16, indices=True)
    own = sweep(Plan(fast, {}, draws=draws, options={"transient": 300.0, "budget": 1500.0, "patience": 300.0}))
    assert own.attrs["totals"].count('"border_dimension": null') == 1
    found = tolerances(own)
    chaos = (own["regime"].values[:16] == Regime.CHAOTIC).sum()
    one = found.sel(risk="chaos")
    assert float(one["probability"]) == pytest.approx(chaos / int(one["decided"]))
    assert found["parameter"].values.tolist() == ["voltage", "prestretch"]


def test_a_sweep_without_draws_has_no_tolerances():
    with pytest.raises(InputError, match="no draws of the regime"):
        tolerances(xr.Dataset({"regime": ("voltage", [1])}))
