"""Texts of steps, creep, transfer functions and limited amplifiers: each number under its own name."""

import math

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.analyses import (
    trajectories,
)  # fmt: skip
from gelcone.analyses import trajectories as runs
from gelcone.analyses.request import Subject
from gelcone.codes import Outcome
from gelcone.physics.balance import PullIn
from gelcone.presets import find_preset
from tests.analyses.said import INF, MODEL, NAN, said
from tests.edited import edited, made
from tests.plots.made_up import result

SUBJECT = Subject(find_preset("base").model)
TIME = [0.0, 2000.0, 20_000.0]


def own_lines(text, count):
    """The last lines, behind those about the model."""
    return text.splitlines()[-count:]


def test_a_step_names_its_numbers():
    step = result(
        {
            "initial_displacement": ("constant_voltage", [1.0, 1.0]),
            "final_displacement": ("constant_voltage", [3.0, np.nan]),
            "equilibrium_displacement": ("constant_voltage", [3.25, np.nan]),
            "rise_time": ("constant_voltage", [12.0, np.nan]),
            "overshoot": ("constant_voltage", [0.4, np.nan]),
            "settling_time": ("constant_voltage", [np.nan, np.nan]),
            "drift": ("constant_voltage", [0.03, np.nan]),
            "outcome": ("constant_voltage", [0, int(Outcome.PULLED_IN)]),
            "before_voltage": ((), 0.0),
        },
        {"constant_voltage": ("constant_voltage", [500.0, 900.0])},
        {"before_voltage": "V"}
        | dict.fromkeys(("initial_displacement", "final_displacement", "equilibrium_displacement"), "mm")
        | {"rise_time": "ms", "settling_time": "ms", "constant_voltage": "V"},
    )
    assert own_lines(runs.step_words(step, SUBJECT), 3) == [
        "before the step, at 0 V: 1 mm",
        "  500 V: moves by 2 mm to 3 mm (a slow ramp ends at 3.25 mm); rise 12 ms, overshoot 40.0 %, not settled "
        "within the run, drift at the end 3 %",
        f"  900 V: {Outcome.PULLED_IN.meaning}",
    ]
    shares = {"breakdown": [0.25, np.nan], "pulled_in": [0.0, 1.0], "near_limit": [0.0, np.nan]}
    valid = step.assign({f"validity_{name}": ("constant_voltage", own) for name, own in shares.items()})
    assert own_lines(runs.step_words(valid, SUBJECT), 1) == [
        "of 2 motions the model does not hold in: above breakdown in 1 (up to 25 % of the motion), pulled in in 1 (up "
        "to 100 % of the motion)"
    ]


def test_creep_names_both_thresholds_and_what_becomes_of_each_voltage():
    along, over = "constant_voltage", ("constant_voltage", "time")
    creep = result(
        {
            "initial_displacement": (along, [1.0, 1.5, np.nan]),
            "final_displacement": (along, [1.2, np.nan, np.nan]),
            "equilibrium_displacement": (along, [1.3, np.nan, np.nan]),
            "pull_in_time": (along, [np.inf, 5000.0, 0.0]),
            "outcome": (along, [0, 4, 4]),
            "heating": (over, [[np.nan, 2.0, 3.0]] * 3),
            "margin": (over, [[0.5, 0.4, 0.35]] * 3),
            "long_term_pull_in_voltage": ((), 600.0),
            "long_term_pull_in_kind": ((), PullIn.FOLD),
            "instantaneous_pull_in_voltage": ((), 900.0),
            "holding_voltage": ((), 650.0),
            "time_to_pull_in": ("held_voltage", [np.inf, 8000.0]),
        },
        {
            along: (along, [300.0, 700.0, 1000.0]),
            "time": ("time", TIME),
            "held_voltage": ("held_voltage", [640.0, 800.0]),
        },
        dict.fromkeys(
            (along, "held_voltage", "long_term_pull_in_voltage", "instantaneous_pull_in_voltage", "holding_voltage"),
            "V",
        )
        | {
            "initial_displacement": "mm",
            "final_displacement": "mm",
            "equilibrium_displacement": "mm",
            "time": "ms",
            "heating": "K/s",
        },
    )
    assert own_lines(runs.creep_words(creep, SUBJECT), 7) == [
        "pull-in voltage of the cone itself: 900 V at once, 600 V in the long run",
        "highest voltage without pull-in for 20 s: 650 V",
        "  300 V: creeps from 1 mm to 1.2 mm in 20 s, to 1.3 mm in the long run; warms by 3 K/s; margin to pull-in of "
        "the cone itself at the end: 35.0%",
        "  700 V: from 1.5 mm, pulls in after 5 s",
        "  1000 V: pulls in at once",
        "time to pull-in at other voltages:",
        "  800 V: 8 s",
    ]

    valid = creep.assign(validity_breakdown=(along, [0.0, 0.25, np.nan]), validity_near_limit=(along, [0.0] * 3))
    assert own_lines(runs.creep_words(valid, SUBJECT), 1) == [
        "of 3 motions the model does not hold in: above breakdown in 1 (up to 25 % of the motion)"
    ]
    localises = creep.assign(long_term_pull_in_kind=((), PullIn.FILM))
    assert own_lines(runs.creep_words(localises, SUBJECT), 7)[1] == (
        "above 600 V one ring of the film slowly lengthens. The uniform cone does not show that: the film may pull in "
        "earlier and at lower voltages than printed"
    )
    close = creep.assign(holding_voltage=creep["holding_voltage"].copy(data=800.0004))
    first, *_, last = own_lines(runs.creep_words(close, SUBJECT), 6)
    assert first == "highest voltage without pull-in for 20 s: 800.0004 V"
    assert last == "  800 V: 8 s"


def test_a_table_of_gains_has_the_linear_one_at_the_frequency_of_its_row():
    transfer = result(
        {
            "bias_voltage": ((), 1000.0),
            "equilibrium_displacement": ((), 14.0),
            "natural_frequency": ((), 10.0),
            "resonance": ((), 8.0),
            "largest_gain": ((), 7.5),
            "gain": ("drive_frequency", [1.0, 2.0, 7.0, 3.0]),
            "measured_gain": (("amplitude", "measured_frequency"), [[2.5, 4.5]]),
        },
        {
            "drive_frequency": ("drive_frequency", [2.0, 4.0, 8.0, 16.0]),
            "measured_frequency": ("measured_frequency", [4.0, 12.0]),
            "amplitude": ("amplitude", [20.0]),
        },
        dict.fromkeys(("gain", "largest_gain", "measured_gain"), "mm/kV")
        | dict.fromkeys(("measured_frequency", "resonance"), "Hz"),
    )
    *_, largest, _, first, second = runs.transfer_words(transfer, SUBJECT).splitlines()
    assert largest == "largest gain 7.5 mm/kV at 8 Hz"
    assert first.split() == ["4", "Hz", "2", "mm/kV", "2.5", "mm/kV"]
    assert second.split() == ["12", "Hz", "5", "mm/kV", "4.5", "mm/kV"]
    transfer["measured_gain"][0, 1] = np.nan
    *_, second, why = runs.transfer_words(transfer, SUBJECT).splitlines()
    assert second.split() == ["12", "Hz", "5", "mm/kV", "unknown"]
    assert why == "  unknown: the motion ends, does not repeat with the drive, or is as small as rounding"


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


def response(**more):
    names = ("hoop_slack", "meridional_slack", "breakdown", "near_limit", "beyond_membrane", "pulled_in")
    shares = dict(zip(names, (0.125, 0.0, NAN, 0.25, 0.5, 0.0), strict=True))
    return made(
        {
            "displacement": ("time", [-4.0, 3.0, 1.0, 2.0], "mm"), "velocity": ("time", [0.0] * 4, "m/s"), "outcome": 0,
            **{f"validity_{n}": v for n, v in shares.items()}, "validity_error": 1e-9,
            "peak_current": (None, 1.5, "mA"), **more,
        },
        {"time": ("time", [0.0, 10.0, 20.0, 30.0], "ms")},
    )  # fmt: skip


SHARES = [
    "share of the motion in which the model does not hold: hoop slack 12.5 %, near the stretch limit 25 %, above "
    "membrane pull-in 50 %",
    "breakdown unknown: the dielectric strength is not given",
]


def test_members_whose_runs_differ_in_length_say_from_which_to_which():
    time = xr.DataArray(
        [[0.0, 1250.0], [0.0, 1428.0]], dims=("member", "sample"), attrs={"units": "ms", "quantity": "time"}
    )
    assert trajectories._lengths(time) == "1.25 to 1.428 s"
    assert trajectories._lengths(time[0]) == "1.25 s"


RUN = ["run of 30 ms", "displacement -4 to 3 mm; in the second half 1 to 2 mm"]


def test_a_time_response():
    assert said(trajectories.simulate_words, response()) == [*RUN, *SHARES]
    warm = response(heating=(None, 0.75, "K/s"), heat=(None, 6.5, "mW"))
    assert said(trajectories.simulate_words, warm) == [
        *RUN, "heat in the film 6.5 mW, which alone warms it by 0.75 K/s", *SHARES
    ]  # fmt: skip
    jumps = edited(response(), peak_current=math.inf)
    assert said(trajectories.simulate_words, jumps) == [*RUN, trajectories._JUMPS, *SHARES]
    failed = edited(response(), outcome=int(Outcome.STRETCH_LIMIT))
    assert said(trajectories.simulate_words, failed) == [RUN[0], f"failed: {Outcome.STRETCH_LIMIT.meaning}"]


def test_the_range_of_a_run_has_its_turning_points_between_samples():
    """Those of a cubic are exact."""
    time = np.array([0.0, 20.0, 30.0])
    place, speed = time * (time - 15.0) * (time - 30.0) / 100.0, (3.0 * time**2 - 90.0 * time + 450.0) / 100.0
    found = made(
        {"displacement": ("time", place, "mm"), "velocity": ("time", speed, "m/s")}, {"time": ("time", time, "ms")}
    )
    assert trajectories._reach(found) == ["-12.99 to 12.99 mm", "-12.99 to 0 mm"]


def test_members_of_a_time_response_stand_side_by_side():
    """Each with its own range, or how it ended; only the first of many, and without a field that varies by number."""
    runs = np.array([[-4.0, 3.0, 1.0, 2.0], [NAN] * 4, [0.0, 5.0, 5.0, 6.0]])
    found = made(
        {
            "displacement": (("member", "time"), runs, "mm"), "velocity": (("member", "time"), 0.0 * runs, "m/s"),
            "outcome": ("member", [0, int(Outcome.PULLED_IN), 0]),
            "validity_near_limit": ("member", [0.0, NAN, 0.5]), "validity_breakdown": ("member", [0.0, NAN, 0.0]),
        },
        {"time": ("time", [0.0, 10.0, 20.0, 30.0], "ms"), "frequency": ("member", [7.0, 8.0, 9.0], "Hz")},
    )  # fmt: skip
    found["frequency"].attrs["quantity"] = "device field"
    lines = said(trajectories.simulate_words, found)
    assert lines[0] == "run of 30 ms, 3 members"
    assert lines[1:3] == [f"  2 of 3: {Outcome.OK.meaning}", f"  1 of 3: {Outcome.PULLED_IN.meaning}"]
    assert [[cell.strip() for cell in line.split("  ") if cell.strip()] for line in lines[3:6]] == [
        ["frequency", "7 Hz", "8 Hz", "9 Hz"],
        ["displacement", "-4 to 3 mm", Outcome.PULLED_IN.words, "0 to 6 mm"],
        ["in the second half", "1 to 2 mm", "5 to 6 mm"],
    ]
    assert lines[6:] == [
        "of 2 motions the model does not hold in: near the stretch limit in 1 (up to 50 % of the motion)"
    ]
    numbered = said(trajectories.simulate_words, found.drop_vars("frequency"))
    assert numbered[3].split() == ["member", "0", "1", "2"]
    many = said(trajectories.simulate_words, found.isel(member=[0] * 25))
    assert "  and 5 more (all with --json or --out)" in many


MEASURED = ("time", "displacement", "film_voltage")
"""What is stated of a pull-in."""


def test_a_time_response_of_a_film_that_wrinkles():
    more = {"film_state_taut": 0.75, "film_state_crumpled": 0.25, "pull_in_kind": 0, "pull_in_time": (None, 12.0, "ms")}
    more |= {"pull_in_displacement": (None, 14.5, "mm"), "pull_in_film_voltage": (None, 1700.0, "V")}
    wrinkles = edited(response(**more), validity_hoop_slack=0.0)
    film = "film (share of the time): taut 75.0 %, crumpled 25.0 %"
    shares = [SHARES[0].replace("hoop slack 12.5 %, ", ""), SHARES[1]]  # a film that wrinkles is never compressed
    assert said(trajectories.simulate_words, wrinkles) == [*RUN, film, *shares]
    for kind, word in ((1, "minimum"), (2, "localisation")):
        pulled = edited(wrinkles, pull_in_kind=kind)
        line = f"film pulls in at 12 ms, displacement 14.5 mm, voltage on it 1700 V ({word})"
        assert said(trajectories.simulate_words, pulled) == [*RUN, line, film, *shares]
        failed = edited(pulled, outcome=int(Outcome.PULLED_IN))
        assert said(trajectories.simulate_words, failed)[-2:] == [line, film]
    of_second = {"pull_in_kind": "second_pull_in_kind", **{f"pull_in_{n}": f"second_pull_in_{n}" for n in MEASURED}}
    lines = said(trajectories.simulate_words, pulled.rename(of_second))
    assert f"second {line}" in lines
    assert line not in lines


def test_what_an_amplifier_delivers_and_loses():
    behind = Subject(MODEL.replace(series_resistance=0.1))
    lost = ("damper", "film", "resistor", "leak", "dielectric")
    found = made(
        {
            "outcome": 0, "peak_current": (None, 1.5, "mA"), "peak_charge": (None, 4.5, "uC"),
            "peak_slew_rate": (None, 2.5, "V/ms"),
            "rms_voltage": (None, 800.0, "V"), "rms_current": (None, 0.25, "mA"), "apparent_power": (None, 200.0,
            "mVA"),
            "supplied_energy": ("time", [0.0, 9.0], "mJ"), "slew_limited": 0.125, "current_limited": 0.25,
            **{f"{n}_dissipation": ("time", [0.0, k], "mJ") for k, n in enumerate(lost, start=1)},
        },
    )  # fmt: skip
    lines = [
        "amplifier: up to 1.5 mA, 4.5 uC, 2.5 V/ms; rms in the second half 800 V, 0.25 mA, 200 mVA",
        "  slew limited for 12.5 % of the time",
        "  current limited for 25 % of the time",
        "  supplied 9 mJ, lost: damper 1 mJ, film 2 mJ, resistor 3 mJ, leak 4 mJ, dielectric 5 mJ",
    ]
    assert trajectories._source_lines(found, behind) == lines
    assert trajectories._source_lines(found, Subject(MODEL)) == []
    assert trajectories._source_lines(found.expand_dims("member"), behind) == []
    assert trajectories._source_lines(found[["outcome", *list(found)[1:7]]], behind) == lines[:1]
    second = {f"second_{name}": (2.0 * found[name]).assign_attrs(found[name].attrs) for name in list(found)[1:6]}
    assert trajectories._source_lines(found.assign(second), behind) == [
        "first film's amplifier: up to 1.5 mA, 4.5 uC, 2.5 V/ms; rms in the second half 800 V, 0.25 mA",
        "second film's amplifier: up to 3 mA, 9 uC, 5 V/ms; rms in the second half 1600 V, 0.5 mA, 200 mVA of both",
        *lines[1:],
    ]


def test_sections_turning_points_and_spectra():
    found = made(
        {
            "displacement": ("repeat", [1.0, NAN, -2.0], "mm"), "velocity": ("repeat", [0.5, NAN, 0.25], "m/s"),
            "outcome": 0,
        },
        title="Poincare section",
    )  # fmt: skip
    assert said(trajectories.section_words, found) == [
        "Poincare section", "displacement -2 to 1 mm", "velocity 0.25 to 0.5 m/s",
    ]  # fmt: skip
    empty = edited(found, displacement=NAN, velocity=NAN, outcome=int(Outcome.OUTSIDE))
    assert said(trajectories.section_words, empty)[1:] == [f"failed: {Outcome.OUTSIDE.meaning}"]
    turns = found.assign(maximum=("repeat", [1, 0, -1]), count=2).assign_attrs(title="extrema")
    assert said(trajectories.extrema_words, turns)[1:] == [
        "displacement -2 to 1 mm", "  1 maxima: 1 to 1 mm", "  1 minima: -2 to -2 mm",
    ]  # fmt: skip
    assert said(trajectories.extrema_words, turns.assign(count=0, maximum=("repeat", [0, 0, 0])))[-1] == (
        "no turning points: the disc is at rest by then"
    )


def spectrum(count):
    k = np.arange(1.0, count + 1)
    lines = {"ratio": (0.5 * k, "1"), "frequency": (5.0 * k, "Hz"), "amplitude": (2.0**-k, "mm"),
             "prominence": (10.0 * k, "dB")}  # fmt: skip
    return made(
        {
            "outcome": 0, "rms": (None, 0.75, "mm"), "mean_displacement": (None, 13.5, "mm"),
            "power_in_lines": 0.875, "flatness": 0.015625,
            **{f"line_{n}": ("line", v, unit) for n, (v, unit) in lines.items()},
        },
    )  # fmt: skip


def test_the_spectrum_of_a_run_has_no_lines():
    """Powers 1, 1, 16, 1, 1 above frequency 0: nine tenths of all begin at the first and end at the last but one."""
    run = edited(spectrum(1), power_in_lines=NAN).assign(
        amplitude=("frequency_ratio", [9.0, 1.0, 1.0, 4.0, 1.0, 1.0], {"units": "mm"}),
        frequency=("frequency_ratio", [0.0, 2.0, 4.0, 6.0, 8.0, 10.0], {"units": "Hz"}),
    )
    assert said(trajectories.spectrum_words, run) == [
        "rms 0.75 mm about 13.5 mm", "of the run of a drive that does not repeat, from its start on; it has no lines",
        "largest at 6 Hz: 4 mm", "90 % of the power from 2 to 8 Hz; spectral flatness 0.0156",
    ]  # fmt: skip


def test_the_lines_of_a_spectrum():
    lines = said(trajectories.spectrum_words, spectrum(2))
    assert lines[:2] == ["rms 0.75 mm about 13.5 mm", "87.5 % of the variance in lines, spectral flatness 0.0156"]
    assert [line.split() for line in lines[2:]] == [
        ["frequency/drive", "frequency", "amplitude", "prominence"],
        ["0.5", "5", "Hz", "0.5", "mm", "10.0", "dB"],
        ["1", "10", "Hz", "0.25", "mm", "20.0", "dB"],
    ]
    assert said(trajectories.spectrum_words, spectrum(trajectories.PRINTED_LINES))[-1].endswith("80.0 dB")
    assert said(trajectories.spectrum_words, spectrum(trajectories.PRINTED_LINES + 2))[-1] == "  and 2 more"
    padded = spectrum(3)
    for name in ("ratio", "frequency", "amplitude", "prominence"):
        padded[f"line_{name}"][2:] = NAN
    assert said(trajectories.spectrum_words, padded) == lines
    none = padded.assign(power_in_lines=0.0).isel(line=slice(2, None))
    assert said(trajectories.spectrum_words, none) == [lines[0], "no lines; spectral flatness 0.0156"]
    still = edited(spectrum(2), power_in_lines=NAN, flatness=NAN)
    assert said(trajectories.spectrum_words, still) == ["the actuator stands still: it has no spectrum"]
    failed = edited(spectrum(2), outcome=int(Outcome.STEP_LIMIT))
    assert said(trajectories.spectrum_words, failed) == [f"failed: {Outcome.STEP_LIMIT.meaning}"]
    two = xr.concat([spectrum(2), edited(spectrum(2), rms=0.25, power_in_lines=0.5, flatness=0.5)], "member")
    two["rms"].attrs["units"] = "mm"
    assert said(trajectories.spectrum_words, two)[1:] == [
        "rms 0.25 to 0.75 mm", "power in lines 0.5 to 0.875", "flatness 0.01562 to 0.5",
    ]  # fmt: skip


@pytest.mark.parametrize(("drive", "of"), [("same", ""), ("opposite", " on the first film")])
def test_a_step_begins_at_a_voltage(drive, of):
    along = "constant_voltage"
    values = {
        name: (along, [0.0], "mm")
        for name in ("initial_displacement", "final_displacement", "equilibrium_displacement")
    }
    values |= {name: (along, [NAN], "ms") for name in ("rise_time", "settling_time")}
    own = values | {"overshoot": (along, [NAN]), "outcome": (along, [0]), "before_voltage": (None, 250.0, "V")}
    step = made(own, {along: (along, [500.0], "V")})
    subject = Subject(gelcone.ConeModel(second_film="taut", second_drive=drive))
    assert trajectories.step_words(step, subject).splitlines()[-2:] == [
        f"before the step, at 250 V{of}: 0 mm", "  500 V: does not move the disc from 0 mm",
    ]  # fmt: skip


def test_a_step_that_goes_down_and_settles():
    along = "constant_voltage"
    values = {"initial_displacement": (5.0, "mm"), "final_displacement": (2.0, "mm"),
    "equilibrium_displacement": (1.5, "mm"), "rise_time": (12.0, "ms"),
              "settling_time": (40.0, "ms"), "overshoot": (0.25, "1"), "drift": (0.0125, "1"), "outcome": (0,
              "1")}  # fmt: skip
    own = {n: (along, [v], unit) for n, (v, unit) in values.items()} | {"before_voltage": (None, 0.0, "V")}
    step = made(own, {along: (along, [500.0], "V")})
    assert said(trajectories.step_words, step) == [
        "before the step, at 0 V: 5 mm",
        "  500 V: moves by 3 mm to 2 mm (a slow ramp ends at 1.5 mm); rise 12 ms, overshoot 25.0 %, settled after 40 "
        "ms, "
        "drift at the end 1.2 %",
    ]
    for drift, text in ((-4e-5, "-0.004 %"), (1.2e-5, "0.0012 %"), (-1e-9, "0 %")):
        small = step.assign(drift=step["drift"].copy(data=[drift]))
        assert said(trajectories.step_words, small)[1].endswith(f"drift at the end {text}")
    still = step.assign(
        {name: step[name].copy(data=[NAN]) for name in ("rise_time", "settling_time", "overshoot", "drift")}
    )
    assert said(trajectories.step_words, still)[1] == "  500 V: does not move the disc from 2 mm"
    slow = step.assign(
        rise_time=step["rise_time"].copy(data=[5.4e6]), settling_time=step["settling_time"].copy(data=[2.7e7])
    )
    assert "; rise 90 min, overshoot 25.0 %, settled after 7.5 h, drift" in said(trajectories.step_words, slow)[1]


def test_the_lines_of_steps_have_one_unit_a_column():
    along = "constant_voltage"
    values = {"initial_displacement": ([1.0, 1.0], "mm"), "final_displacement": ([1.5, 3.0], "mm"),
    "equilibrium_displacement": ([1.5, 3.0], "mm"),
              "rise_time": ([12.0, 9.0], "ms"), "settling_time": ([1967.0, 2001.0], "ms"),
              "overshoot": ([0.25, 0.5], "1"), "drift": ([0.0, 0.0], "1"), "outcome": ([0, 0], "1")}  # fmt: skip
    own = {n: (along, v, unit) for n, (v, unit) in values.items()} | {"before_voltage": (None, 0.0, "V")}
    step = made(own, {along: (along, [850.0, 1200.0], "V")})
    for name in ("initial_displacement", "final_displacement", "equilibrium_displacement"):
        step[name].attrs["quantity"] = "length"
    step[along].attrs["quantity"] = "voltage"
    _, first, second = said(trajectories.step_words, step)
    assert first.startswith("  0.85 kV: moves by 0.5 mm to 1.5 mm (a slow ramp ends at 1.5 mm)")
    assert second.startswith("  1.2 kV: moves by 2 mm to 3 mm (a slow ramp ends at 3 mm)")
    assert "; rise 12 ms, overshoot 25.0 %, settled after 1.967 s," in first
    assert "; rise 9 ms, overshoot 50.0 %, settled after 2.001 s," in second


def test_a_creeping_film_that_never_pulls_in_or_could_not_be_followed():
    along = "constant_voltage"
    found = made(
        {
            "initial_displacement": (along, [1.0, 2.0], "mm"), "final_displacement": (along, [1.25, NAN], "mm"),
            "equilibrium_displacement": (along, [1.5, NAN],
            "mm"),
            "pull_in_time": (along, [INF, NAN], "ms"), "outcome": (along, [0, int(Outcome.STEP_LIMIT)]),
            "heating": ((along, "time"), [[0.0, 2.0]] * 2, "K/s"), "long_term_pull_in_voltage": (None, INF, "V"),
            "long_term_pull_in_kind": (None, int(PullIn.NEVER)),
            "instantaneous_pull_in_voltage": (None, INF, "V"), "holding_voltage": (None, INF, "V"),
            "margin": ((along, "time"), [[0.5, 1.0]] * 2),
            "time_to_pull_in": ("held_voltage", [INF], "ms"),
        },
        {along: (along, [300.0, 700.0], "V"), "time": ("time", [0.0, 60_000.0], "ms"),
         "held_voltage": ("held_voltage", [640.0], "V")},
    )  # fmt: skip
    assert said(trajectories.creep_words, found) == [
        "no constant voltage pulls the cone itself in, at once or in the long run",
        "  300 V: creeps from 1 mm to 1.25 mm in 60 s, to 1.5 mm in the long run; warms by 2 K/s; margin to pull-in of "
        "the cone itself at the end: 100.0%",
        f"  700 V: {Outcome.STEP_LIMIT.meaning}",
    ]
    cold = found["heating"].copy(data=[[2.0, 1e-7]] * 2)
    assert (
        "to 1.5 mm in the long run; no longer warms; margin"
        in said(trajectories.creep_words, found.assign(heating=cold))[1]
    )


def test_voltages_that_pull_in_at_once_share_a_line():
    along = "constant_voltage"
    found = made(
        {
            "initial_displacement": (along, [NAN], "mm"), "pull_in_time": (along, [0.0], "ms"), "outcome": (along, [0]),
            "long_term_pull_in_voltage": (None, 600.0, "V"), "instantaneous_pull_in_voltage": (None, 900.0, "V"),
            "long_term_pull_in_kind": (None, int(PullIn.FOLD)),
            "holding_voltage": (None, 650.0, "V"),
            "time_to_pull_in": ("held_voltage", [INF, 8000.0, 0.0, 0.0], "ms"),
        },
        {along: (along, [1000.0], "V"), "time": ("time", [0.0, 60_000.0], "ms"),
         "held_voltage": ("held_voltage", [640.0, 800.0, 910.0, 920.0], "V")},
    )  # fmt: skip
    assert said(trajectories.creep_words, found)[-3:] == [
        "time to pull-in at other voltages:",
        "  800 V: 8 s",
        "  from 910 V on: at once",
    ]


def test_voltages_are_written_with_the_digits_that_tell_them_apart():
    assert trajectories.telling_digits([3359.11, 3359.14, 3359.14, 3416.0]) == 6
    assert trajectories.telling_digits([3000.0, 3100.0]) == 4
    assert trajectories.telling_digits([1.0, 1.0 + 1e-15]) == 12


def test_transfer_functions_that_were_not_measured():
    found = made(
        {
            "bias_voltage": (None, 900.0, "V"), "equilibrium_displacement": (None, 14.0, "mm"),
            "natural_frequency": (None, 11.0,
            "Hz"),
            "resonance": (None, 10.5, "Hz"), "largest_gain": (None, 7.5, "mm/kV"),
            "gain": ("drive_frequency", [2.0, 7.0], "mm/kV"),
            "measured_gain": (("amplitude", "measured_frequency"), np.zeros((0, 0))),
        },
        {"drive_frequency": ("drive_frequency", [5.0, 10.0], "Hz"), "measured_frequency": ("measured_frequency", []),
         "amplitude": ("amplitude", [])},
    )  # fmt: skip
    assert said(trajectories.transfer_words, found) == [
        "about 900 V: displacement 14 mm, natural frequency 11 Hz", "largest gain 7.5 mm/kV at 10.5 Hz",
    ]  # fmt: skip
