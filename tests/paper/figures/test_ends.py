"""The figure and the table of what ends the chaos, on made-up counts."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.figures.ends import counted, draw, table, words
from gelcone.paper.studies.ends import NAME, VOLTAGES, Case
from gelcone.paper.truths import Share
from tests.paper.made_up import cells

CASES = (Case(), Case(0.01), Case(0.1), Case(0.0, 0.1, 50.0), Case(0.0, 0.5, 50.0), Case(0.0, 0.5, 2.0))
CHAOTIC = (9, 2, 1, 8, 7, 4)
OPEN = (0, 3, 0, 0, 1, 0)
BEFORE = (10.0, np.nan, 3.0, 8.0, np.nan, 5.0)


def study():
    """Of ten voltages the first are chaotic and the next have not settled."""
    voltages = np.linspace(1.0, 1.9, 10)
    place, chaos, open_ = np.arange(10), np.array(CHAOTIC)[:, None], np.array(OPEN)[:, None]
    kinds = np.where(place < chaos, Regime.CHAOTIC, np.where(place < chaos + open_, Regime.TRANSIENT, Regime.PERIODIC))
    exponent = np.where(place < chaos, 0.1, np.where(place < chaos + open_, 0.0, -0.1))
    own = cells({"case": np.arange(len(CASES)), "voltage": voltages}, place < chaos, kinds=kinds, exponent=exponent)
    columns = dict(zip(("series_resistance", "viscous_modulus_1", "relaxation_time_1"), np.array(CASES).T, strict=True))
    more = {name: ("case", values) for name, values in (columns | {"counted": np.array(BEFORE)}).items()}
    return own.drop_vars("case").assign(more).assign_attrs(window=500.0)


def test_the_table_has_each_count_with_what_is_not_decided():
    found = table({NAME: study()})
    assert found.head[1] == "chaotic, of 10 voltages"
    assert [row[0] for row in found.rows] == [words(case) for case in CASES]
    assert [row[1] for row in found.rows] == ["9", "2 to 5", "1", "8", "7 to 8", "4"]
    assert [row[2] for row in found.rows] == ["9", "2 to 5", "1", "8", "7 to 8", "4"]
    assert [row[-1] for row in found.rows] == ["10", "", "3", "8", "", "5"]


def test_the_exponents_are_counted_apart_from_the_motions():
    """Chaos with starts nearby that have left it is open, though its exponent is positive."""
    own = study()
    shares = np.where(own["regime"].values == Regime.CHAOTIC, 1.0, np.nan)
    shares[0, 0] = 0.5
    found = table({NAME: own.assign(share_chaotic=(("case", "voltage"), shares))})
    assert found.rows[0][1:3] == ("8 to 9", "9")


@pytest.mark.parametrize(
    ("panel", "values", "bars", "squares"),
    [
        (0, [0.01, 0.1], [(2, 5), (1, 1)], [np.nan, 3.0]),
        (1, [0.1, 0.5], [(8, 8), (7, 8)], [8.0, np.nan]),
        (2, [2.0, 50.0], [(4, 4), (7, 8)], [5.0, np.nan]),
    ],
)
def test_counts_stand_at_their_values_with_bars_over_what_is_not_decided(panel, values, bars, squares):
    axes = draw({NAME: study()}).axes[panel]
    points, *_, before = axes.lines
    ends = [(low, high) for (_, low), (_, high) in axes.collections[0].get_segments()]
    np.testing.assert_array_equal(points.get_xydata(), list(zip(values, [low for low, _ in bars], strict=True)))
    np.testing.assert_array_equal(ends, bars)
    np.testing.assert_array_equal(before.get_xdata(), values)
    np.testing.assert_array_equal(before.get_ydata(), squares)
    (band,) = axes.patches
    assert band.get_y() < 9.0 < band.get_y() + band.get_height()
    assert axes.get_xscale() == "log"
    assert axes.get_ylim()[0] < 0.0 < VOLTAGES.size < axes.get_ylim()[1]


def test_a_count_says_its_range():
    assert (counted(Share(3, 1)), counted(Share(3, 1, 2))) == ("3", "3 to 5")


def test_an_undecided_count_without_anything_added_is_a_band():
    own = study()
    own["regime"][0, 9] = int(Regime.TRANSIENT)
    (band,) = draw({NAME: own}).axes[0].patches
    assert band.get_height() > 1.0
