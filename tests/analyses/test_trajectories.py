"""Texts of steps, creep, transfer functions and limited amplifiers: each number under its own name."""

import numpy as np
import xarray as xr

from gelcone.analyses import trajectories as runs
from gelcone.analyses.request import Subject
from gelcone.codes import Outcome
from gelcone.presets import find_preset
from tests.plots.made_up import result

SUBJECT = Subject(find_preset("base").model)
TIME = [0.0, 2000.0, 20_000.0]


def own_lines(text, count):
    """The last lines, behind those about the model."""
    return text.splitlines()[-count:]


def test_a_step_names_its_numbers():
    step = result(
        {
            "begin": ("constant_voltage", [1.0, 1.0]),
            "end": ("constant_voltage", [3.0, np.nan]),
            "equilibrium": ("constant_voltage", [3.25, np.nan]),
            "rise_time": ("constant_voltage", [12.0, np.nan]),
            "overshoot": ("constant_voltage", [0.4, np.nan]),
            "settling_time": ("constant_voltage", [np.nan, np.nan]),
            "drift": ("constant_voltage", [0.03, np.nan]),
            "outcome": ("constant_voltage", [0, int(Outcome.PULLED_IN)]),
        },
        {"constant_voltage": ("constant_voltage", [500.0, 900.0])},
        dict.fromkeys(("begin", "end", "equilibrium"), "mm")
        | {"rise_time": "ms", "settling_time": "ms", "constant_voltage": "V"},
    )
    assert own_lines(runs.step_words(step, SUBJECT), 3) == [
        "before the step: 1 mm",
        "  500 V: moves by 2 mm to 3 mm (a slow ramp ends at 3.25 mm); rise 12 ms, overshoot 40.0%, not settled "
        "within the run, drift at the end 3.00%",
        f"  900 V: {Outcome.PULLED_IN.meaning}",
    ]


def test_creep_names_both_thresholds_and_what_becomes_of_each_voltage():
    along, over = "constant_voltage", ("constant_voltage", "time")
    creep = result(
        {
            "begin": (along, [1.0, 1.5, np.nan]),
            "end": (along, [1.2, np.nan, np.nan]),
            "equilibrium": (along, [1.3, np.nan, np.nan]),
            "pull_in_time": (along, [np.inf, 5000.0, 0.0]),
            "outcome": (along, [0, 4, 4]),
            "heating": (over, [[np.nan, 2.0, 3.0]] * 3),
            "margin": (over, [[0.5, 0.4, 0.35]] * 3),
            "long_time_voltage": ((), 600.0),
            "instant_voltage": ((), 900.0),
            "holding_voltage": ((), 650.0),
            "time_to_pull_in": ("held_voltage", [np.inf, 8000.0]),
        },
        {
            along: (along, [300.0, 700.0, 1000.0]),
            "time": ("time", TIME),
            "held_voltage": ("held_voltage", [640.0, 800.0]),
        },
        dict.fromkeys((along, "held_voltage", "long_time_voltage", "instant_voltage", "holding_voltage"), "V")
        | {"begin": "mm", "end": "mm", "equilibrium": "mm", "time": "ms", "heating": "K/s"},
    )
    assert own_lines(runs.creep_words(creep, SUBJECT), 6) == [
        "pull-in at once 900 V, in the long run 600 V; up to 650 V is held for 20 s",
        "  300 V: creeps from 1 mm to 1.2 mm in 20 s, in the long run 1.3 mm; warms by 3 K/s; margin to pull-in at the "
        "end: 35.0%",
        "  700 V: from 1.5 mm, pulls in after 5 s",
        "  1000 V: pulls in at once",
        "time to pull-in:",
        "  800 V: 8 s",
    ]


def test_a_table_of_gains_has_the_linear_one_at_the_frequency_of_its_row():
    transfer = result(
        {
            "bias_voltage": ((), 1000.0),
            "equilibrium": ((), 14.0),
            "natural_frequency": ((), 10.0),
            "resonance": ((), 8.0),
            "gain": ("drive_frequency", [1.0, 2.0, 7.0, 3.0]),
            "measured_gain": (("amplitude", "measured_frequency"), [[2.5, 4.5]]),
        },
        {
            "drive_frequency": ("drive_frequency", [2.0, 4.0, 8.0, 16.0]),
            "measured_frequency": ("measured_frequency", [4.0, 12.0]),
            "amplitude": ("amplitude", [20.0]),
        },
        dict.fromkeys(("gain", "measured_gain"), "mm/kV") | dict.fromkeys(("measured_frequency", "resonance"), "Hz"),
    )
    *_, largest, _, first, second = runs.transfer_words(transfer, SUBJECT).splitlines()
    assert largest == "largest gain 7 mm/kV at 8 Hz"
    assert first.split() == ["4", "Hz", "2", "mm/kV", "2.5", "mm/kV"]
    assert second.split() == ["12", "Hz", "5", "mm/kV", "4.5", "mm/kV"]


def test_the_time_at_a_limit_is_in_percent():
    shown = xr.Dataset(
        {
            **dict.fromkeys(
                ("peak_current", "peak_charge", "peak_slew_rate", "rms_voltage", "rms_current", "apparent_power"), 1.0
            ),
            "slew_limited": 0.25,
            "outcome": 0,
        }
    )
    behind = Subject(find_preset("base").model.replace(series_resistance=0.1))
    assert runs._source_lines(shown, behind)[-1] == "  slew limited for 25 % of the time"
