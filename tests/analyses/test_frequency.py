"""Frequency responses in words, of made-up numbers."""

import numpy as np

from gelcone.analyses import (
    answer,
    frequency,
)  # fmt: skip
from gelcone.analyses.request import Subject, read_subject
from gelcone.codes import Outcome
from tests.analyses.said import EVENTS, MODEL, NAN
from tests.edited import coded, edited, made


def sweeps(**changes):
    both = ("branch", "drive_frequency")
    own = {
        "outcome": (both, [[0, 0, 0], [0, 0, 0]]), "stroke": (both, [[1.0, 2.0, 1.0]] * 2, "mm"),
        "peak_amplitude": ("branch", [1.5, 1.25], "mm"), "peak_amplitude_error": ("branch", [0.05, 0.025]),
        "peak_frequency": ("branch", [11.0, 10.5]), "peak_low": ("branch", [10.75, 10.25]),
        "peak_high": ("branch", [11.25, 10.625]), "period": (both, [[1, 1, 1], [1, 1, 1]]),
        "resting": (both, [[0, 0, 0], [0, 0, 0]]), "linear_stroke": ("drive_frequency", [0.5, 0.75, 0.25]),
        "jump_low": ("jump", [11.5]), "jump_high": ("jump", [11.75]), "jump_from": ("jump", [2.5]),
        "jump_to": ("jump", [0.5]), "jump_branch": ("jump", ["up"]), "jump_event_kind": coded("jump", [0], EVENTS),
        "jump_event": ("jump", [11.625]),
    }  # fmt: skip
    coords = {"branch": ("branch", ["up", "down"]), "drive_frequency": ("drive_frequency", [10.0, 11.0, 12.0], "Hz")}
    return edited(made(own, coords), **changes)


RESPONSE = [
    "drive frequency 10 to 12 Hz, 3 values",
    "swept up    largest stroke 3.00 ± 0.10 mm at 11 [10.75, 11.25] Hz",
    "swept down  largest stroke 2.500 ± 0.050 mm at 10.5 [10.25, 10.625] Hz",
    "linear theory: largest stroke 0.75 mm at 11 Hz",
    "  stroke at  swept up  swept down  linear",
    "  10 Hz          1 mm        1 mm     0.5",
    "  11 Hz          2 mm        2 mm    0.75",
    "  12 Hz          1 mm        1 mm    0.25",
    "jumps (the sweeps differ between):",
    "  swept up    at 11.5 to 11.75 Hz: stroke 2.5 -> 0.5 mm, fold at 11.625 Hz",
]


def response_lines(shown, model=MODEL):
    subject = Subject(model)
    head = len(answer.heading(subject, ["drive_frequency"]))
    return frequency.frequency_words(shown, subject).splitlines()[head:]


def test_the_heading_leaves_out_the_frequency_of_the_device_itself():
    device = read_subject("biased-pump", settings=["film=taut", "frequency=7 Hz"])
    said = frequency.frequency_words(sweeps(), device)
    assert "voltage_amplitude 680 V" in said
    assert "7 Hz" not in said


def test_the_largest_linear_stroke_may_lie_between_the_frequencies():
    shown = sweeps().assign(linear_peak_stroke=((), 0.875, {"units": "mm"}), linear_peak_frequency=((), 11.25))
    assert "linear theory: largest stroke 0.875 mm at 11.25 Hz" in response_lines(shown)


def test_a_sweep_that_finds_no_motion_or_only_rest_has_no_largest_stroke():
    failed = [[int(Outcome.PULLED_IN)] * 3, [0] * 3]
    strokes = {"peak_amplitude": [NAN, 1e-12], "stroke": np.array([[NAN] * 3, [1e-12] * 3])}
    shown = sweeps(**strokes, outcome=failed, resting=[[0] * 3, [1] * 3]).isel(jump=slice(0))
    lines = response_lines(shown)
    assert "swept up    no motion is found at any frequency" in lines
    assert "swept down  at rest at every frequency" in lines
    assert lines[-3:] == [
        "  10 Hz       unknown     at rest     0.5",
        "  11 Hz       unknown     at rest    0.75",
        "  12 Hz       unknown     at rest    0.25",
    ]
    assert not [line for line in lines if "no jump" in line]
    said = "linear theory: largest stroke 0.75 mm at 11 Hz"
    assert said in lines
    every = [[int(Outcome.PULLED_IN)] * 3] * 2
    assert f"{said}; it holds for small motions, and none was found" in response_lines(edited(shown, outcome=every))


def test_strokes_of_many_frequencies_are_not_listed(monkeypatch):
    monkeypatch.setattr(frequency, "FEW", 2)
    assert response_lines(sweeps()) == [line for line in RESPONSE if "Hz   " not in line and "stroke at" not in line]


def test_a_frequency_response():
    assert response_lines(sweeps()) == RESPONSE
    found = response_lines(sweeps(peak_frequency=[12.0, 10.0]))
    rising = ", an end of the frequencies: it may rise beyond"
    assert [line.endswith(rising) for line in found[1:3]] == [True, True]
    exact = response_lines(sweeps(peak_amplitude=[1.815, 1.25], peak_amplitude_error=[3e-5, NAN]))
    assert "largest stroke 3.63000 ± 6e-05 mm at" in exact[1]  # to the digits of its error
    assert "largest stroke 2.5 mm at" in exact[2]
    odd = sweeps(period=[[1, 2, 0], [1, 1, 3]])
    assert response_lines(odd)[2] == "            subharmonic at 1, not periodic at 1 of 3 frequencies"
    assert response_lines(odd)[4] == "            subharmonic at 1 of 3 frequencies"
    at_rest = sweeps(period=[[1, 2, 0], [1, 1, 3]], resting=[[0, 0, 1], [0, 0, 0]])
    assert response_lines(at_rest)[2] == "            subharmonic at 1 of 3 frequencies"
    assert response_lines(sweeps(jump_event_kind=-1))[-1].endswith("0.5 mm, no bifurcation found there")
    assert response_lines(sweeps().drop_vars("jump_event"))[-1].endswith("0.5 mm")
    close = response_lines(sweeps(jump_low=11.500001, jump_high=11.500002))
    assert close[-1].startswith("  swept up    at 11.5 Hz: stroke 2.5 -> 0.5 mm")
    none = response_lines(sweeps().isel(jump=slice(0, 0)))
    assert none[-1] == "no jump: where both sweeps find a motion, it is the same"
    lost = sweeps(linear_stroke=[NAN, NAN, NAN])
    lost["linear_stroke"].attrs["nan_means"] = "too many harmonics of the drive"
    assert response_lines(lost)[3] == "no linear theory: too many harmonics of the drive"
    some = lost.assign(linear_stroke=lost["linear_stroke"].copy(data=[NAN, 1.0, 0.5]))
    words = "linear theory: largest stroke 1 mm at 11 Hz, none at 1 of 3 frequencies: too many harmonics of the drive"
    assert response_lines(some)[3] == words
    assert response_lines(sweeps(linear_stroke=[0.0, 0.0, 0.0]))[3] == "linear theory: largest stroke 0 mm"
    failed = sweeps(outcome=[[0, 0, 0], [0, int(Outcome.PULLED_IN), 0]])
    assert response_lines(failed)[1] == f"1 of 6 runs failed: {Outcome.PULLED_IN.meaning}"
    assert response_lines(failed)[5] == "only one of the sweeps finds a motion at 1 of 3 frequencies"
    both = sweeps(outcome=[[0, int(Outcome.PULLED_IN), 0]] * 2)
    assert not [line for line in response_lines(both) if "only one" in line]
