"""Figures of uncertain parameters show what the draws give, and nothing that they do not."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer

from gelcone.analyses.grids import sweep_words
from gelcone.analyses.request import read_subject
from gelcone.atlas.distribution import Uniform
from gelcone.atlas.tolerances import tolerances
from gelcone.atlas.uncertain import draw
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.plots.sweep import any_figure, sweep_figure
from gelcone.plots.tolerances import density, tolerances_figure
from tests.atlas.test_tolerances import cells

TOTALS = dict.fromkeys(("computed", "cells", "computed_before", "inferred", "failed", "checked"), 0)
TOTALS |= {"integrator_steps": 0, "wall_time_s": 0.0, "border_dimension": None}
TWO = draw({"a": Uniform(0.0, 1.0), "b": Uniform(0.0, 1.0)}, 64, indices=True)


def made_up(**more):
    return cells(TWO, 1.0 + TWO["a"] + 0.1 * TWO["b"], **more)


def widths(axes):
    return [bar.get_width() for bar in axes.patches]


def test_strokes_are_a_density_and_no_line_joins_draws():
    figure = any_figure(made_up())
    top, risks, tornado = figure.axes
    curve = next(line for line in top.lines if len(line.get_xdata()) == 200)
    area = np.trapezoid(curve.get_ydata(), curve.get_xdata())
    assert 0.8 < area < 1.0  # between the least and the greatest draw
    ticks = next(line for line in top.lines if len(line.get_xdata()) == 64)
    assert ticks.get_linestyle() == "None"
    np.testing.assert_allclose(sorted(ticks.get_xdata()), np.sort(1.0 + TWO["a"][:64] + 0.1 * TWO["b"][:64]))
    drawn = {float(line.get_xdata()[0]) for line in top.lines if len(line.get_xdata()) == 2}
    assert drawn == set(tolerances(made_up())["stroke"].values.tolist())
    assert [label.get_text() for label in risks.get_yticklabels()] == ["pull-in", "breakdown: not known", "chaos"]
    assert [label.get_text() for label in tornado.get_yticklabels()] == ["b", "a"]  # the largest on top
    found = tolerances(made_up())
    order = found["total_order"].sel(end="value").values[[1, 0]]
    np.testing.assert_allclose(widths(tornado)[:2], order)


def test_risks_are_bars_with_their_intervals():
    count = len(TWO["a"])
    regime = np.where(np.arange(count) < 16, int(Regime.CHAOTIC), int(Regime.PERIODIC))
    outcome = np.where(np.arange(count) == 20, int(Outcome.PULLED_IN), 0)
    figure = tolerances_figure(made_up(regime=regime, outcome=outcome, breakdown=np.zeros(count)))
    assert len(figure.axes) == 2  # a draw without a stroke: no indices
    assert widths(figure.axes[1]) == pytest.approx([1.0 / 64.0, 0.0, 0.25])
    assert "without a long run 1.56 %" in figure.axes[0].get_title(loc="left")


def intervals(axes):
    """Ends of the error bars of each set of bars: (place, low, high)."""
    bars = [one for one in axes.containers if isinstance(one, ErrorbarContainer)]
    return [[(y, *sorted((x0, x1))) for (x0, y), (x1, _) in bar.lines[2][0].get_segments()] for bar in bars]


def test_each_bar_of_the_error_runs_from_the_lower_to_the_upper_end():
    """The intervals of small shares are not symmetric: an exchange of their ends shows."""
    regime = np.where(np.arange(len(TWO["a"])) < 3, int(Regime.CHAOTIC), int(Regime.PERIODIC))
    study = made_up(regime=regime)
    _, risks, tornado = any_figure(study).axes
    found = tolerances(study)
    known = np.flatnonzero(np.isfinite(found["probability"].values))
    wanted = [(k, float(found["low"][k]), float(found["high"][k])) for k in known]
    (shown,) = intervals(risks)
    np.testing.assert_allclose(shown, wanted, atol=1e-12)
    assert any(abs(low + high - 2.0 * float(found["probability"][k])) > 0.01 for k, low, high in wanted)
    order = np.argsort(found["total_order"].sel(end="value").values)
    for shown, name in zip(intervals(tornado), ("total_order", "first_order"), strict=True):
        ends = [found[name].sel(end=end).values[order] for end in ("low", "high")]
        np.testing.assert_allclose(shown, np.column_stack([[0, 1], *ends]), atol=1e-12)


def test_rest_is_named_and_not_drawn_as_a_density():
    count = len(TWO["a"])
    regime = np.full(count, int(Regime.REST))
    figure = tolerances_figure(made_up(regime=regime))
    assert "at rest 100 %" in figure.axes[0].get_title(loc="left")
    assert not any(len(line.get_xdata()) == 200 for line in figure.axes[0].lines)


def test_draws_at_rest_are_no_part_of_the_density_of_motions():
    """Every second one rests: the ticks and the curve are those of the others, and the title has both shares."""
    count = len(TWO["a"])
    rests = np.arange(count) % 2 == 0
    figure = tolerances_figure(made_up(regime=np.where(rests, int(Regime.REST), int(Regime.PERIODIC))))
    top = figure.axes[0]
    ticks = next(line for line in top.lines if line.get_marker() == "|")
    own = (1.0 + TWO["a"] + 0.1 * TWO["b"])[:64][~rests[:64]]
    np.testing.assert_allclose(sorted(ticks.get_xdata()), np.sort(own))
    curve = next(line for line in top.lines if len(line.get_xdata()) == 200)
    assert curve.get_xdata().min() == pytest.approx(own.min())
    assert "at rest 50 %, without a long run 0 %" in top.get_title(loc="left")


def test_along_a_parameter_quantiles_are_a_band_and_risks_are_lines():
    stroke = np.stack([TWO["a"], 2.0 * TWO["a"], 3.0 * TWO["a"]])
    study = cells(TWO, stroke, over=[1.0, 2.0, 3.0])
    upper, lower = any_figure(study).axes
    found = tolerances(study)
    np.testing.assert_allclose(upper.lines[0].get_ydata(), found["stroke"].sel(quantile=0.5))
    x, y = upper.collections[0].get_paths()[0].vertices.T
    for k, at in enumerate((1.0, 2.0, 3.0)):
        ends = [float(found["stroke"].sel(quantile=q)[k]) for q in (0.05, 0.95)]
        np.testing.assert_allclose([y[x == at].min(), y[x == at].max()], ends)
    np.testing.assert_allclose(lower.lines[1].get_ydata(), found["probability"].sel(risk="chaos"))
    assert [line.get_label() for line in lower.lines] == ["pull-in", "chaos"]


def test_draws_over_three_axes_are_refused_in_words():
    study = cells(TWO, np.stack([TWO["a"]] * 2), over=[1.0, 2.0]).expand_dims(prestretch=[1.0, 1.1])
    with pytest.raises(InputError, match="take a slice"):
        tolerances_figure(study)


def test_draws_of_any_analysis_are_densities():
    study = cells(TWO, TWO["a"]).drop_vars(["regime", "lowest"]).assign(status=("draw", np.ones(len(TWO["a"]))))
    (axes,) = sweep_figure(study).axes
    assert any(len(line.get_xdata()) == 200 for line in axes.lines)
    assert axes.get_xlabel() != "draw"


@pytest.mark.parametrize("values", [[2.0, 2.0, 2.0], [1.0, 2.0], [np.nan] * 3, []])
def test_too_few_or_equal_numbers_have_no_density_curve(values):
    axes = plt.figure().subplots()
    density(axes, np.array(values, dtype=float))
    assert not any(len(line.get_xdata()) == 200 for line in axes.lines)


def test_answer_and_figure_count_the_same_draws():
    """Draws that stand for Sobol indices alone are no draws of their own."""
    limit = np.where(TWO["a"] > 0.7, np.inf, 1.0 + TWO["b"])
    drawn = made_up().drop_vars(["regime", "lowest"]).assign(status=("draw", np.ones(limit.size)))
    drawn = drawn.assign(limit=("draw", limit, {"infinite_means": "not reached", "units": "V"}))
    drawn = drawn.assign(other=("draw", np.full(limit.size, np.inf), {"infinite_means": "not reached"}))
    drawn = drawn.assign_attrs(totals=json.dumps(TOTALS))
    lost, of = int((TWO["a"][:64] > 0.7).sum()), 64
    assert lost != int((TWO["a"] > 0.7).sum())
    (axes,) = (axes for axes in sweep_figure(drawn).axes if axes.get_xlabel() == "limit (V)")
    assert axes.get_title(loc="left") == f"not reached in {lost} of {of} draws"
    assert len(axes.lines[0].get_xdata()) == of - lost
    answer = sweep_words(drawn, read_subject(None, preset="base"))
    assert f"other: not reached in {of} of {of} draws" in answer.splitlines()
    assert f"{of} draws of a, b, and 64 for Sobol indices" in answer.splitlines()
