"""The text of the best drive: how far below its limit it is, and what a kick does."""

import numpy as np
import pytest

from gelcone.analyses import (
    answer,
    drive,
)  # fmt: skip
from gelcone.analyses.drive import drive_words
from gelcone.analyses.request import Subject
from gelcone.presets import find_preset
from tests.analyses.said import INF, NAN, SUBJECT
from tests.edited import edited, made
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
    names = ("stroke", "work", "speed", "power", "supplied_power", "apparent_power", "voltage_bias", "voltage")
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
    assert "limited by pull-in at 1000 V: 20% below it; this voltage stays below all limits from 10 to 14 Hz" in text
    assert ("kick" in text) == (words is not None)
    assert words is None or words in text
    assert "stroke changes by, % per %: spring_rate -2, moving_mass +0.5" in text
    assert text.endswith("a change of 1 % leads to another motion or ends it: film_thickness")


def best(**changes):
    own = {
        "stroke": (None, 5.0, "mm"), "work": (None, 6.0, "mJ"), "speed": (None, 0.75, "m/s"), "power": (None, 8.0,
        "mW"), "supplied_power": (None, 20.0, "mW"),
        "apparent_power": (None, 90.0, "mVA"), "voltage_bias": (None, 700.0, "V"), "voltage": (None, 400.0, "V"),
        "drive_frequency": (None, 11.0, "Hz"), "peak_voltage": (None, 1100.0, "V"), "limit_voltage": (None, 1375.0,
        "V"),
        "frequency_low": (None, 10.0, "Hz"), "frequency_high": (None, 13.0, "Hz"), "kick": (None, 0.25, "m/s"),
        "sensitivity": ("field", [0.5, -2.0, NAN]),
    }  # fmt: skip
    coords = {"field": ("field", ["moving_mass", "spring_rate", "film_thickness"])}
    return edited(made(own, coords, largest="stroke", limit="pull-in"), **changes)


@pytest.mark.parametrize("largest", ["stroke", "work", "speed", "power"])
def test_the_best_drive(largest):
    values = {"stroke": "stroke 5 mm", "work": "work a period 6 mJ", "speed": "rms speed 0.75 m/s",
              "power": "mean power on the load 8 mW of 20 mW supplied"}  # fmt: skip
    named = {"stroke": "5 mm", "work": "6 mJ", "speed": "0.75 m/s", "power": "8 mW"}[largest]
    own = ["voltage_amplitude", "voltage_offset", "frequency", "voltage", "voltage_bias"]
    lines = drive.drive_words(best().assign_attrs(largest=largest), SUBJECT).splitlines()
    lines = lines[len(answer.heading(SUBJECT, own)) :]
    others = ", ".join(text for name, text in values.items() if name != largest)
    others += ", mean power supplied 20 mW" if largest == "power" else ""
    of = "power on the load" if largest == "power" else largest
    assert lines == [
        f"largest {of}: {named} at 11 Hz and 1100 V peak (offset 700 V, amplitude 400 V)",
        f"  {others}, apparent power 90 mVA",
        "  limited by pull-in at 1375 V: 20% below it; this voltage stays below all limits from 10 to 13 Hz",
        "  a kick of 0.25 m/s leads to another motion",
        "  stroke changes by, % per %: spring_rate -2, moving_mass +0.5",
        "  a change of 1 % leads to another motion or ends it: film_thickness",
    ]
    off = best().assign(detuned_stroke=("detuning", [2.5, NAN], {"units": "mm", "nan_means": "the motion ends"}))
    off = off.assign_coords(detuning=("detuning", [-0.01, 0.01]))
    said = "  stroke at a frequency 1% lower 2.5 mm, as much higher the motion ends"
    assert said in drive.drive_words(off, SUBJECT).splitlines()
    free = drive.drive_words(best(limit_voltage=INF, kick=INF, sensitivity=0.5), SUBJECT).splitlines()
    assert free[-3:-1] == [
        "  no limit was met at this frequency, up to the highest voltage examined",
        "  no kick that was tried leads to another motion",
    ]
    assert "kick" not in drive.drive_words(best(kick=NAN), SUBJECT)


def test_numbers_of_a_drive_read_as_elsewhere():
    """In the unit that leaves 1 to 1000 before the point, both ends of the frequencies in one."""
    shown = best(apparent_power=0.5, frequency_high=1300.0)
    measures = {"peak_voltage": "voltage", "apparent_power": "apparent power", "frequency_low": "frequency",
                "frequency_high": "frequency"}  # fmt: skip
    for name, quantity in measures.items():
        shown[name].attrs["quantity"] = quantity
    text = drive.drive_words(shown, SUBJECT)
    assert "11 Hz and 1.1 kV peak" in text
    assert "apparent power 500 uVA" in text
    assert "from 0.01 to 1.3 kHz" in text
