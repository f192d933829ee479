"""Marks that the paper's figures share."""

import json

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from gelcone.codes import Regime
from gelcone.paper.figures.marks import film_legend, fixed_parameters, listed, mark_slack
from gelcone.plots.regime import REGIME_COLOURS, motion_colour
from gelcone.plots.style import BLACK, GREY


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


def test_the_legend_of_a_film_names_its_lines_its_window_and_each_kind_of_motion_once():
    assert motion_colour(xr.Dataset({"regime": Regime.CHAOTIC.value})) == REGIME_COLOURS[Regime.CHAOTIC]
    film_legend(figure := Figure(), [Regime.REST, Regime.CHAOTIC, Regime.REST])
    (legend,) = figure.legends
    lines = {text.get_text(): line for text, line in zip(legend.get_texts(), legend.get_lines(), strict=True)}
    assert list(lines) == [
        "film taut", "film slack: the model does not hold", "window from the start",
        f"long run: {Regime.REST.label}", f"long run: {Regime.CHAOTIC.label}",
    ]  # fmt: skip
    assert [line.get_alpha() for line in lines.values()] == [None, 0.45, None, None, None]
    assert [line.get_marker() for line in lines.values()] == ["None", "None", "x", "o", "o"]
    colours = [line.get_color() for line in lines.values()]
    assert colours == [BLACK, BLACK, GREY, REGIME_COLOURS[Regime.REST], REGIME_COLOURS[Regime.CHAOTIC]]
