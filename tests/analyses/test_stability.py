"""Tongues in words, of made-up numbers."""

from gelcone.analyses import (
    stability,
)  # fmt: skip
from gelcone.motion.floquet import Onset
from tests.analyses.said import NAN, said
from tests.edited import edited, made


def test_tongues():
    found = made(
        {
            "outcome": 0, "operating_onset_voltage": (None, 1250.0, "V"), "operating_onset_kind": int(Onset.MINUS_ONE),
            "operating_searched": ("end", [0.0, 3000.0], "V"),
            "onset_voltage": ("drive_frequency", [NAN, 900.0, 1100.0], "V"),
            "margin": (("drive_frequency", "voltage"), [[-1.0, -1.0], [-1.0, 1.0], [0.0, -1.0]]),
            "pitchfork_amplitude": (None, 1500.0, "V"),
        },
        {"drive_frequency": ("drive_frequency", [5.0, 10.0, 15.0], "Hz"), "voltage": ("voltage", [0.0, 3000.0], "V")},
    )  # fmt: skip
    lines = [
        f"at its own frequency: onset at 1250 V, {Onset.MINUS_ONE.meaning} (searched up to 3000 V)",
        "lowest onset on the grid 900 V at drive frequency 10 Hz",
        "rest is unstable in 16.7 % of the grid",
        "static pitchfork, for comparison: 1500 V",
    ]
    assert said(stability.tongues_words, found) == lines
    none = edited(found, operating_onset_voltage=NAN, operating_onset_kind=int(Onset.NONE), onset_voltage=NAN,
    margin=-1.0,
                  pitchfork_amplitude=NAN)  # fmt: skip
    assert said(stability.tongues_words, none) == [
        f"at its own frequency: {Onset.NONE.meaning} (searched up to 3000 V)", "rest is unstable in 0 % of the grid",
    ]  # fmt: skip
    partly = edited(found, margin=[[-1.0, NAN], [1.0, NAN], [-1.0, NAN]])
    expected = "rest is unstable in 33.3 % of the 3 of 6 cells in which that is known"
    assert said(stability.tongues_words, partly)[2] == expected
    unknown = edited(found, margin=NAN)
    expected = "whether rest is stable is unknown on all of the grid"
    assert said(stability.tongues_words, unknown)[2] == expected
