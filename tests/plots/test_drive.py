"""The figure of the best drive: the limit above it, and the largest sensitivities by amount."""

import numpy as np

from gelcone.plots.drive import MOST_BARS, drive_figure
from tests.plots.made_up import data_of, result


def drive(sensitivity, names):
    return result(
        {
            "window_peak": ("frequency", [1000.0, 800.0]),
            "window_value": ("frequency", [5.0, 9.0]),
            "drive_frequency": ((), 12.0),
            "peak_voltage": ((), 900.0),
            "limit_voltage": ((), 1100.0),
            "stroke": ((), 8.0),
            "displacement": ("time", [1.0, 3.0, 1.0]),
            "drive_voltage": ("time", [0.0, 900.0, 0.0]),
            "sensitivity": ("field", sensitivity),
        },
        {"frequency": ("frequency", [10.0, 20.0]), "time": ("time", [0.0, 5.0, 10.0]), "field": ("field", names)},
        {"drive_frequency": "Hz", "peak_voltage": "V", "window_value": "mm"},
        {"limit": "pull-in", "largest": "stroke"},
    )


def test_the_limit_stands_above_the_best_drive():
    window, *_ = drive_figure(drive([0.1], ["spring_rate"])).axes
    places = {one.get_label(): data_of(one).ravel().tolist() for one in window.lines if one.get_marker() in "*x"}
    assert places == {"best drive, 12 Hz, 900 V": [12.0, 900.0], "limit: pull-in": [12.0, 1100.0]}


def test_the_bars_are_the_largest_by_amount_and_a_falling_stroke_among_them():
    change = np.array([-3.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    names = ["material.shear_modulus", *(f"field_{k}" for k in range(1, 9))]
    bars = drive_figure(drive(change, names)).axes[-1]
    labels = [text.get_text() for text in bars.get_yticklabels()]
    assert len(labels) == MOST_BARS
    found = dict(zip(labels, (bar.get_width() for bar in bars.patches), strict=True))
    assert found == {"shear modulus": -3.0} | {f"field {k}": change[k] for k in range(2, 9)}
    assert labels[-1] == "shear modulus"  # the largest on top


def test_the_motion_is_drawn_with_the_commanded_voltage_dashed():
    """The voltage on the film, behind a circuit, is another one."""
    shown = drive([0.1], ["spring_rate"])
    shown["film_voltage"] = "time", [0.0, 700.0, 0.0]
    figure = drive_figure(shown)
    lines = [line for axes in figure.axes for line in axes.lines if list(line.get_xdata()) == [0.0, 5.0, 10.0]]
    drawn = {tuple(line.get_ydata()): line.get_linestyle() for line in lines}
    assert drawn == {(1.0, 3.0, 1.0): "-", (0.0, 900.0, 0.0): "--"}
