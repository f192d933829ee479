"""The page of a data sheet: forces on a load, and the limit that comes first in another colour than the others."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

from gelcone.plots.datasheet import (
    MOST_COLUMNS,
    _columns,
    limit_bars,
    over_displacement,
    over_frequency,
    over_voltage,
    write_table,
)
from gelcone.plots.style import BLUE, VERMILION
from gelcone.words import SHEET_DRIVE, SHEET_ROWS
from tests.plots.made_up import blank, corners, data_of, line, result


def test_the_force_on_a_load_is_the_blocked_force_at_rest_and_none_at_the_free_stroke():
    sheet = result(
        {
            "rest_displacement": ((), 2.0),
            "force": (("constant_voltage", "displacement_value"), [[-3.0, -2.0, 0.0, 1.0]]),
            "blocked_force": ("constant_voltage", [2.0]),
            "stroke": ("constant_voltage", [4.0]),
        },
        {
            "constant_voltage": ("constant_voltage", [500.0]),
            "displacement": ("displacement_value", [0.0, 2.0, 6.0, 8.0]),
        },
        {"force": "N", "displacement": "mm", "constant_voltage": "V"},
    )
    axes = blank()
    over_displacement(sheet, axes)
    np.testing.assert_array_equal(data_of(line(axes, "500 V")), [[0.0, 2.0, 6.0, 8.0], [3.0, 2.0, 0.0, -1.0]])
    dots = {one.get_marker(): data_of(one).ravel().tolist() for one in axes.lines if one.get_marker() in "oD"}
    assert dots == {"o": [2.0, 2.0], "D": [6.0, 0.0]}
    np.testing.assert_array_equal(corners(axes.collections[0]), [[2.0, 6.0, 0.0, 2.0]])


def written(axes):
    """Lines of a table from the top: the texts of each from the left."""
    lines = {}
    for text in axes.texts:
        x, y = text.get_position()
        lines.setdefault(round(y, 6), []).append((x, text.get_text()))
    return [[text for _, text in sorted(lines[y])] for y in sorted(lines, reverse=True)]


@pytest.mark.parametrize("volts", [[0.0, 500.0], [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]])
def test_each_column_of_the_table_is_the_sheet_at_the_voltage_on_its_top(volts):
    """Every number of the made-up sheet is another; the first voltage above 0 and the last one are shown."""
    volts = np.array(volts)
    numbers = {name: 1e4 * (k + 1) + volts for k, name in enumerate(SHEET_ROWS)}
    single = {"rest_displacement": 1.5, "pull_in_voltage": 9e5} | {name: 8e5 + k for k, name in enumerate(SHEET_DRIVE)}
    limits = {"first_limit_voltage": 7e5, "safe_peak_voltage": 6e5, "dielectric_breakdown_voltage": np.nan}
    sheet = result(
        {name: ("constant_voltage", values) for name, values in numbers.items()}
        | {name: ((), value) for name, value in (single | limits).items()},
        {"constant_voltage": ("constant_voltage", volts)},
        {"constant_voltage": "V"},
        {"first_limit": "driven hoop slack", "device": "pump"},
    )
    axes = blank()
    write_table(sheet, axes)
    top, head, *rows = [line for line in written(axes) if line != ["data sheet, computed"]]
    assert top == ["pump"]
    shown = np.array([float(text.removesuffix(" V")) for text in head[1:]])
    assert (len(shown), shown[-1]) == (min(volts.size - 1, MOST_COLUMNS), volts[-1])
    assert shown[0] == volts[1]
    assert (np.diff(shown) > 0.0).all()
    table = {line[0]: [float(text) for text in line[1:]] for line in rows[: len(SHEET_ROWS)]}
    for name, words in SHEET_ROWS.items():
        at = [numbers[name][volts == own][0] for own in shown]
        np.testing.assert_allclose(table[words], at, rtol=1e-3)
    pairs = [line[k : k + 2] for line in rows[len(SHEET_ROWS) :] for k in range(0, len(line) - 1, 2)]
    found = {words: float(text) for words, text in pairs}
    wanted = {"rest height": 1.5, "stiffness at rest": numbers["stiffness_at_rest"][0]}
    assert found == pytest.approx(wanted | {words: single[name] for name, words in SHEET_DRIVE.items()}, rel=1e-3)
    ends = [line[0] for line in rows if len(line) == 1]
    assert ends == [
        "pull-in under constant voltage: 9e+05",
        "first limit: hoop slack of the drive, at a peak of 7e+05",
        "below every limit: peaks up to 6e+05",
        "dielectric strength: unknown, breakdown is not accounted for",
    ]
    axes = blank()
    write_table(sheet.assign_attrs(first_limit="pull in"), axes)
    assert ["first limit: pull in on a slow ramp, at a peak of 7e+05"] in written(axes)


def test_the_response_about_each_voltage_that_is_held_is_named_by_it():
    sheet = result(
        {"gain": (("constant_voltage", "drive_frequency"), [[1.0, 3.0], [np.nan, np.nan], [1.0, 2.0]])},
        {
            "constant_voltage": ("constant_voltage", [0.0, 300.0, 500.0]),
            "drive_frequency": ("drive_frequency", [1.0, 9.0]),
        },
        {"constant_voltage": "V", "drive_frequency": "Hz"},
    )
    axes = blank()
    over_frequency(sheet, axes)
    curves = {one.get_label(): list(one.get_ydata()) for one in axes.lines}
    half = curves.pop("half power")
    assert curves == {"about 0 V": [1.0, 3.0], "about 500 V": [1.0, 2.0]}
    assert half == pytest.approx([np.sqrt(0.5)] * 2)


def test_stroke_and_blocked_force_have_their_own_axes_and_units():
    sheet = result(
        {"ramp_stroke": ("ramp_voltage", [0.0, 4.0]), "ramp_blocked_force": ("ramp_voltage", [0.0, 2.0])},
        {"ramp_voltage": ("ramp_voltage", [0.0, 500.0])},
        {"ramp_stroke": "mm", "ramp_blocked_force": "N", "ramp_voltage": "V"},
    )
    axes = blank()
    over_voltage(sheet, axes)
    _, other = axes.figure.axes
    assert (axes.lines[0].get_ydata()[-1], axes.get_ylabel()) == (4.0, "free stroke (mm)")
    assert (other.lines[0].get_ydata()[-1], other.get_ylabel()) == (2.0, "blocked force (N)")


def test_the_first_limit_is_red_and_the_longest_bar_lowest():
    sheet = xr.Dataset(
        {
            "pull_in_voltage": 3000.0, "driven_hoop_slack_voltage": 900.0, "stretch_limit_voltage": np.inf,
            "first_limit_voltage": ((), 900.0, {"units": "V"}), "pitchfork_voltage": 100.0, "safe_peak_voltage": 500.0,
            "examined_voltage": 4000.0, "examined_step_voltage": 200.0, "driven_error_voltage": 3.0,
        }
    )  # fmt: skip
    axes = blank()
    limit_bars(sheet, axes)
    names = [text.get_text() for text in axes.get_yticklabels()]
    bars = [(bar.get_width(), bar.get_facecolor()[:3]) for bar in axes.patches]
    assert names == ["pull-in", "drive: hoop slack"]
    assert bars == [(3000.0, to_rgb(BLUE)), (900.0, to_rgb(VERMILION))]
    assert axes.get_xlabel() == "peak voltage (V)"


def test_bars_of_a_cone_say_whose_pull_in_they_are():
    own = {"pull_in_voltage": 800.0, "membrane_pull_in_voltage": 700.0, "driven_pull_in_voltage": 600.0}
    sheet = xr.Dataset({**own, "first_limit_voltage": ((), 600.0, {"units": "V"})}, attrs={"pull_in_of": "membrane"})
    axes = blank()
    limit_bars(sheet, axes)
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names == ["cone pull-in", "membrane pull-in", "drive: membrane pull-in"]


def test_a_device_without_a_drive_has_no_bars_of_limits():
    axes = blank()
    limit_bars(xr.Dataset({"pull_in_voltage": 800.0}, attrs={"first_limit": "not asked: no drive"}), axes)
    assert [text.get_text() for text in axes.texts] == ["not asked: no drive"]
    assert not axes.patches


def test_a_limit_far_above_the_others_does_not_squash_their_bars():
    far = {"driven_hoop_slack_voltage": 900.0, "pull_in_voltage": 1400.0, "stretch_limit_voltage": 18000.0}
    axes = blank()
    limit_bars(xr.Dataset({**far, "first_limit_voltage": ((), 900.0, {"units": "V"})}), axes)
    assert [bar.get_width() for bar in axes.patches] == [1400.0, 1400.0, 900.0]
    assert [text.get_text().strip() for text in axes.texts] == ["1.8e+04"]


def test_bars_of_films_in_opposite_phase_are_peaks_of_the_drive_without_the_pull_in_at_its_bias():
    own = {"pull_in_voltage": 800.0, "ramp_begin_voltage": 300.0, "proportional_pitchfork_voltage": 500.0}
    peaks = {"driven_pull_in_voltage": 900.0, "proportional_pull_in_voltage": 1400.0}
    axes = blank()
    limit_bars(xr.Dataset({**own, **peaks, "first_limit_voltage": ((), 900.0, {"units": "V"})}), axes)
    bars = {text.get_text(): bar.get_width() for text, bar in zip(axes.get_yticklabels(), axes.patches, strict=True)}
    assert bars == {"pull-in": 1400.0, "drive: pull-in": 900.0}
    assert axes.get_title("left") == "limits met: peak of the drive, bias and amplitude in proportion"


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_intervals_stand_in_a_column_of_their_own_behind_the_voltages(count):
    """The last column, at the right edge; of many voltages the first and the last are among those that are shown."""
    for toleranced in (False, True):
        chosen, places = _columns(count, toleranced)
        assert chosen.size == places.size == min(count, MOST_COLUMNS)
        assert (np.diff(chosen) > 0).all()
        assert (np.diff(places) > 0.0).all()
        assert places[-1] == pytest.approx(1.0)
        last = chosen[-2] if toleranced else chosen[-1]
        assert (chosen[0], last) == (0, count - 1 - toleranced)
        if toleranced:
            assert chosen[-1] == count - 1
            assert places[-2] == pytest.approx(0.7)
