"""Messages about what was typed, in the words of what was typed."""

import json

import pytest


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["static", "soft-film", "--over", "constant_voltage=0 V:2 kV"], "must be a range from:to:count"),
        (["simulate", "soft-film", "--set", "voltage_amplitude=0 V:2 kV"], "must be a range from:to:count"),
        (["static", "soft-film", "--over", "displacement=5 mm,4 mm"], "--over displacement: must increase"),
        (["static", "--voltages", "1"], "No such option '--voltages'; give --over constant_voltage=..."),
        (["static", "--displacements", "1"], "No such option '--displacements'; give --over displacement=..."),
        (["drive", "--lowest", "1"], "No such option '--lowest'; did you mean '--lowest-frequency'?"),
        (["drive", "--highest", "1"], "No such option '--highest'; did you mean '--highest-frequency'?"),
        (["film", "--height", "1"], "No such option '--height'; give --over displacement=..."),
        (
            ["transfer", "--frequencies", "1"],
            "No such option '--frequencies'; give --over drive_frequency=..., with a device --over frequency=...",
        ),
        (
            ["film", "soft-film", "--over", "constant_voltage=-1kV"],
            "--over constant_voltage=-1kV: must be at least 0; leave",
        ),
        (
            ["transfer", "biased-pump", "--bias", "1 kV", "--over", "frequency=-1 Hz"],
            "--over frequency=-1 Hz: -1 Hz is among them; they must be positive",
        ),
        (
            ["static", "soft-film", "--over", "frequency=1 Hz"],
            "--over frequency: cannot be swept here; static sweeps",
        ),
        (["continue", "frequency", "5 Hz"], "takes [DEVICE] PARAMETER FROM TO, not 2 words: frequency 5 Hz"),
        (["continue", "no-such", "frequency", "5 Hz", "9 Hz"], "no-such"),
        (
            ["continue", "soft-film", "--over", "voltage_amplitude=0.8kV:1.2kV"],
            "No such option '--over'; gelcone continue takes [DEVICE] PARAMETER FROM TO",
        ),
        (["locus"], "takes [DEVICE] EVENT, not 0 words: none"),
        (
            ["locus", "soft-film", "fold", "--over", "frequency=9 Hz:5 Hz", "--over", "film_thickness=1 mm:2 mm"],
            "frequency from 9 Hz to 5 Hz: is empty or reversed",
        ),
        (
            ["simulate", "soft-film", "--set", "gravity=9,81"],
            "--set gravity=9,81: may be one number or two; write 9.81 with a point, or the list [9, 81]",
        ),
        (
            ["simulate", "soft-film", "--set", "gravity=9.5,9.81"],
            "--set gravity=9.5,9.81: a list needs a unit on every value, or brackets: [9.5, 9.81]",
        ),
        (
            ["simulate", "--set", "voltage=0,5"],
            "--set voltage=0,5: may be one number or two; write 0.5 with a point, or the list [0, 5]",
        ),
        (
            ["static", "biased-pump", "--over", "displacement=500 mm,600 mm"],
            "--over displacement=500 mm,600 mm: none is reached; stay within 66 mm",
        ),
        (
            [
                "locus",
                "biased-pump",
                "fold",
                "--over",
                "film_thickness=0.1 mm:0.3 mm",
                "--over",
                "frequency=19 Hz:22 Hz",
            ],
            "frequency from 19 Hz to 22 Hz: must hold the device's own value, which is 10 Hz",
        ),
        (
            ["simulate", "biased-pump", "--set", "film_thickness=0.2 mmm"],
            "give a number in m or a string such as '200 um' (units m, cm, mm, um, nm)",
        ),
        (
            ["simulate", "biased-pump", "--set", "film_radius=-3 cm"],
            "must be greater than 0 m; give a larger one, such as 30 mm",
        ),
        (
            ["simulate", "soft-film", "--set", "prestretch=9", "--set", "damping_ratio=0.1"],
            "prestretch: mounted flat, the film has I1 - 3 = 159, which must be less than its stretch limit 50",
        ),
        (["envelope", "soft-film", "--over", "damping_ratio=1:2:3"], "envelope sweeps frequency and peak_voltage"),
        (
            ["envelope", "soft-film", "--over", "frequency=9 Hz"],
            'has one point; give at least two, or take gelcone operating-limits --set "frequency=9 Hz"',
        ),
        (["frequency", "--over", "drive_frequency=0.5"], 'or take gelcone settled --set "drive_frequency=0.5"'),
        (["envelope", "soft-film", "--over", "peak_voltage=1 kV"], "--over peak_voltage: has one point; a sweep takes"),
    ],
)
def test_a_message_speaks_of_what_was_typed(command_line, typed, message):
    code, out, err = command_line(*typed)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert message in err


@pytest.mark.parametrize(
    "typed", [["soft-film", "--set", "gravity=[9, 81]"], ["--set", "voltage=[0, 1]"], ["--set", "voltage=0.5,1"]]
)
def test_brackets_or_a_point_make_a_list(command_line, typed):
    code, out, err = command_line("simulate", *typed, "--periods", "1", "--json")
    assert code == 0, err
    assert len(json.loads(out)["outcome"]) == 2
