"""The text of the best drive: how far below its limit it is, and what a kick does."""

import numpy as np
import pytest

from gelcone.analyses.drive import drive_words
from gelcone.analyses.request import Subject
from gelcone.presets import find_preset
from tests.plots.made_up import result


@pytest.mark.parametrize(
    ("kick", "words"),
    [
        (0.5, "a kick of 0.5 leads to another motion"),
        (np.inf, "no kick that was tried leads to another motion"),
        (np.nan, None),
    ],
)
def test_limit_and_kick_are_in_words(kick, words):
    names = ("stroke", "work", "speed", "power", "apparent_power", "voltage_bias", "voltage")
    drive = result(
        dict.fromkeys(names, ((), 1.0))
        | {
            "drive_frequency": ((), 12.0),
            "peak_voltage": ((), 800.0),
            "limit_voltage": ((), 1000.0),
            "frequency_low": ((), 10.0),
            "frequency_high": ((), 14.0),
            "kick": ((), kick),
            "sensitivity": ("field", [-2.0, 0.5, np.nan]),
        },
        {"field": ("field", ["spring_rate", "moving_mass", "film_thickness"])},
        {"limit_voltage": "V", "frequency_low": "Hz", "frequency_high": "Hz"},
        {"limit": "pull-in", "largest": "stroke"},
    )
    text = drive_words(drive, Subject(find_preset("base").model))
    assert "limited by pull-in at 1000 V: 20% below it; this voltage stays below all limits from 10 Hz to 14 Hz" in text
    assert ("kick" in text) == (words is not None)
    assert words is None or words in text
    assert "stroke changes by, % per %: spring_rate -2, moving_mass +0.5" in text
    assert text.endswith("a change of 1 % ends the motion or its period: film_thickness")
