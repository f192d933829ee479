"""Marks that the paper's figures share."""

import json

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from gelcone.codes import Regime
from gelcone.paper.figures.marks import film_legend, fixed_parameters, listed, mark_slack
from gelcone.plots.regime import REGIME_COLOURS, motion_colour


def test_a_line_is_strong_where_the_film_is_taut_and_to_the_next_sample():
    axes = Figure().subplots()
    mark_slack(axes, np.arange(6.0), np.arange(6.0) ** 2, [0, 0, 1, 1, 0, 1], "red")
    faint, strong = axes.lines
    assert faint.get_ydata().tolist() == [0.0, 1.0, 4.0, 9.0, 16.0, 25.0]
    np.testing.assert_array_equal(strong.get_ydata(), [0.0, 1.0, 4.0, np.nan, 16.0, 25.0])
    assert strong.get_linewidth() > faint.get_linewidth()
    assert strong.get_alpha() is None
    assert faint.get_alpha() < 1.0


def test_words_of_numbers_and_parameters():
    assert listed([1.0, 2.5, 3.0]) == "1, 2.5 and 3"
    study = xr.Dataset(attrs={"preset": "base", "model": json.dumps({"voltage": 1.5, "damping_ratio": 0.01})})
    assert fixed_parameters(study) == r"set base: $\zeta$ = 0.01, $v$ = 1.5"
    assert fixed_parameters(study, "voltage", "prestretch") == "set base: $v$ = 1.5"


def test_each_kind_has_its_colour_once_in_the_legend():
    assert motion_colour(xr.Dataset({"regime": Regime.CHAOTIC.value})) == REGIME_COLOURS[Regime.CHAOTIC]
    figure = Figure()
    film_legend(figure, [Regime.CHAOTIC, Regime.PERIODIC, Regime.CHAOTIC])
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert words[:2] == ["film taut", "film slack: the model does not hold"]
    assert words[3:] == ["long run: chaotic", "long run: periodic"]
    assert legend.legend_handles[3].get_color() == REGIME_COLOURS[Regime.CHAOTIC]
