"""Envelopes and frequency responses of draws in words, of made-up numbers."""

import numpy as np

from gelcone.analyses import (
    answer,
    drawn,
)  # fmt: skip
from gelcone.codes import Outcome
from tests.analyses.said import INF, NAN, SUBJECT
from tests.edited import edited, made


def drawn_window(**changes):
    own = {
        "outcome": ("draw", [0, 0, 0, 6]), "recommended_peak": (("draw", "drive_frequency"), [[8.0,
        6.0]] * 3 + [[NAN] * 2],
                                                               "V"),
        "static_limit_voltage": (("draw", "static_limit"), [[20.0, INF]] * 3 + [[NAN] * 2], "V"),
        "recommended_constant": ("draw", [16.0, 16.0, 16.0, NAN], "V"),
        "limit_low": (("draw", "driven_limit", "drive_frequency"),
                      [[[10.0, 30.0], [12.0, 7.5]]] * 2 + [[[10.0, NAN], [12.0, INF]]] + [[[NAN] * 2] * 2], "V"),
        "operating_frequency": ("draw", [12.0] * 4, "Hz"),
        "operating_peak_voltage": ("draw", [6.5, 7.5, 7.0, 7.25], "V"),
    }  # fmt: skip
    coords = {"drive_frequency": ("drive_frequency", [10.0, 14.0], "Hz"), "static_limit": ("static_limit", ["pull-in",
              "pitchfork"]), "driven_limit": ("driven_limit", ["hoop slack", "chaos"])}  # fmt: skip
    shown = made(own, coords, analysis="envelope", options='{"margin": 0.2}')
    return edited(shown, **changes).assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2, 1.3]))


def test_an_envelope_of_draws():
    lines = drawn.over_draws_words(drawn_window(), SUBJECT).splitlines()
    lines = lines[len(answer.heading(SUBJECT, ["prestretch"])) :]
    assert lines[:5] == [
        "4 draws of prestretch", f"1 of 4 runs failed: {Outcome.PULLED_IN.meaning}",
        "pull-in at constant voltage: 20 V, 95 % within 20 V; none in 1 of 4 draws",
        "recommended constant voltage, 20% below its limits: 16 V, 95 % within 16 V; none in 1 of 4 draws",
        "recommended drive, 20% below its limits:",
    ]  # fmt: skip
    assert lines[5].split() == [
        "frequency",
        "(Hz)",
        "up",
        "to",
        "(V)",
        "95",
        "%",
        "within",
        "first",
        "limit,",
        "in",
        "how",
        "many",
        "draws",
    ]
    assert lines[6].split() == ["10", "8", "8", "to", "8", "hoop", "slack", "3,", "failed", "1"]
    assert lines[7].split() == [
        "14",
        "6",
        "6",
        "to",
        "6",
        "chaos",
        "2,",
        "pull-in",
        "at",
        "constant",
        "1,",
        "failed",
        "1",
    ]
    assert (
        lines[8] == "its drive, 7.125 V at 12 Hz: inside the window (interpolated between 10 and 14 Hz) in 2 of 4 draws"
    )
    outside = drawn.over_draws_words(drawn_window(operating_frequency=15.0), SUBJECT).splitlines()[-1]
    assert outside == "its own drive: outside the frequencies examined"
    free = drawn._first_limits(drawn_window(limit_low=INF, static_limit_voltage=NAN))
    assert (free == "none").all()


def test_an_envelope_of_draws_of_films_in_opposite_phase_is_of_the_drive_held_at_its_peak():
    shown = drawn_window().assign(recommended_second_voltage=("draw", [12.0, 12.0, 12.0, NAN], {"units": "V"}))
    lines = drawn.over_draws_words(shown, SUBJECT).splitlines()
    assert lines[-8:-5] == [
        "pull-in of the drive held at its peak, bias and amplitude in proportion: 20 V, 95 % within 20 V; none in 1 of "
        "4 draws",
        "recommended peak at which the drive is held, bias and amplitude in proportion, 20% below its limits: 16 V, 95 "
        "% within 16 V; none in 1 of 4 draws",
        "voltage on the second film then: 12 V, 95 % within 12 V; none in 1 of 4 draws",
    ]
    assert "pull-in of the drive held at its peak 1," in " ".join(lines[-2].split())
    assert not any("constant" in line for line in lines)


def test_a_frequency_response_of_draws():
    own = {
        "outcome": (("draw", "branch"), np.zeros((2, 2), dtype=int)),
        "peak_amplitude": (("draw", "branch"), [[1.0, 2.0], [1.0, 2.0]], "mm"),
        "peak_frequency": (("draw", "branch"), [[11.0, 12.0], [11.0, 12.0]], "Hz"), "jumps": ("draw", [0, 1]),
    }  # fmt: skip
    coords = {"branch": ("branch", ["up", "down"]), "drive_frequency": ("drive_frequency", [10.0, 14.0], "Hz")}
    shown = made(own, coords, analysis="frequency").assign_coords(drawn_prestretch=("draw", [1.0, 1.1]))
    lines = drawn.over_draws_words(shown, SUBJECT).splitlines()[len(answer.heading(SUBJECT, ["prestretch"])) :]
    assert lines == [
        "2 draws of prestretch", "drive frequency 10 to 14 Hz, 2 values",
        "swept up, largest stroke: 2 mm, 95 % within 2 mm",
        "swept up, its frequency: 11 Hz, 95 % within 11 Hz",
        "swept down, largest stroke: 4 mm, 95 % within 4 mm",
        "swept down, its frequency: 12 Hz, 95 % within 12 Hz",
        "the sweeps differ, with jumps, in 1 of 2 draws",
    ]  # fmt: skip


def test_the_own_drive_of_each_draw_is_held_against_its_own_window():
    """At 12 Hz, in the middle of windows of 7, 6.5 and 8 V; one draw outside the frequencies leaves all unsaid."""
    windows = [[8.0, 6.0], [7.0, 6.0], [9.0, 7.0], [NAN] * 2]
    shown = drawn_window(recommended_peak=windows, operating_peak_voltage=[6.75, 6.75, 6.5, 7.75])
    assert (
        drawn._own_line(shown)
        == "its drive, 6.75 V at 12 Hz: inside the window (interpolated between 10 and 14 Hz) in 2 of 4 draws"
    )
    lines = drawn._window_lines(shown)
    assert lines[-3].split()[1:5] == ["8", "7.05", "to", "8.95"]
    assert lines[-2].split()[1:5] == ["6", "6", "to", "6.95"]
    far = drawn._own_line(drawn_window(operating_frequency=[12.0, 12.0, 12.0, 15.0]))
    assert far == "its own drive: outside the frequencies examined"
