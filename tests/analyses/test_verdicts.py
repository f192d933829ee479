"""What each text says by verdict: a made-up result in which every number is another, and edits for each other word.

Every line of the text is compared, so that numbers, units, words and their order are all seen; nothing is computed.
"""

import json
import math
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import words
from gelcone.analyses import (
    answer,
    branches,
    design,
    device_fit,
    drawn,
    drive,
    envelope,
    frequency,
    grids,
    material_fit,
    motions,
    profile,
    stability,
    statics,
    tables,
    trajectories,
    validation,
)  # fmt: skip
from gelcone.analyses.request import Subject, read_subject
from gelcone.analyses.swept import example
from gelcone.codes import Outcome, Regime
from gelcone.motion.floquet import Onset
from gelcone.motion.profile import Held
from gelcone.physics.balance import PullIn
from gelcone.register.analyses import ANALYSES
from tests.edited import coded, edited, labelled, made

NAN, INF = np.nan, np.inf
MODEL = gelcone.ConeModel()
SUBJECT = Subject(MODEL)
HEAD = len(answer.heading(SUBJECT))
EVENTS = ("fold", "period_doubling", "symmetry_breaking")


def said(function, shown, subject=SUBJECT):
    return function(shown, subject).splitlines()[HEAD:]


# --- single runs ------------------------------------------------------------------------------------------------------


def response(**more):
    names = ("hoop_slack", "meridional_slack", "breakdown", "near_limit", "beyond_membrane", "pulled_in")
    shares = dict(zip(names, (0.125, 0.0, NAN, 0.25, 0.5, 0.0), strict=True))
    return made(
        {
            "displacement": ("time", [-4.0, 3.0, 1.0, 2.0], "mm"), "outcome": 0,
            **{f"validity_{n}": v for n, v in shares.items()}, "validity_error": 1e-9,
            "peak_current": (None, 1.5, "mA"), **more,
        },
        {"time": ("time", [0.0, 10.0, 20.0, 30.0], "ms")},
    )  # fmt: skip


SHARES = [
    "share of the time outside the model's validity (mean over members):",
    "  hoop slack              12.5 %",
    "  meridional slack         0.0 %",
    "  above breakdown        unknown (no dielectric strength given)",
    "  near the stretch limit  25.0 %",
    "  above membrane pull-in  50.0 %",
    "  pulled in                0.0 %",
]
RUN = ["run of 30 ms, 1 member(s)", "displacement -4 to 3 mm; in the second half 1 to 2 mm"]


def test_a_time_response():
    assert said(trajectories.simulate_words, response()) == [*RUN, *SHARES]
    warm = response(heating=(None, 0.75, "K/s"), heat=(None, 6.5, "mW"))
    assert said(trajectories.simulate_words, warm) == [
        *RUN, "heat in the film 6.5 mW, which alone warms it by 0.75 K/s", *SHARES
    ]  # fmt: skip
    no_membrane = edited(response(), validity_beyond_membrane=NAN, validity_pulled_in=NAN)
    assert said(trajectories.simulate_words, no_membrane)[2:] == [*SHARES[:5], "  pulled in              unknown"]
    jumps = edited(response(), peak_current=math.inf)
    assert said(trajectories.simulate_words, jumps) == [*RUN, trajectories._JUMPS, *SHARES]
    failed = edited(response(), outcome=int(Outcome.STRETCH_LIMIT))
    assert said(trajectories.simulate_words, failed) == [RUN[0], f"  1 of 1: {Outcome.STRETCH_LIMIT.meaning}"]


def test_a_time_response_of_a_film_that_wrinkles():
    more = {"film_state_taut": 0.75, "film_state_crumpled": 0.25, "pull_in_kind": 0, "pull_in_time": (None, 12.0, "ms")}
    more |= {"pull_in_displacement": (None, 14.5, "mm"), "pull_in_voltage": (None, 1700.0, "V")}
    wrinkles = edited(response(**more), validity_hoop_slack=0.0)
    film = "film (share of the time): taut 75.0 %, crumpled 25.0 %"
    shares = [SHARES[0], *SHARES[3:]]  # a film that wrinkles is never compressed
    assert said(trajectories.simulate_words, wrinkles) == [RUN[0], film, RUN[1], *shares]
    for kind, word in ((1, "minimum"), (2, "localisation")):
        pulled = edited(wrinkles, pull_in_kind=kind)
        assert said(trajectories.simulate_words, pulled)[2] == (
            f"film pulls in at 12 ms, displacement 14.5 mm, voltage 1700 V ({word})"
        )


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
    assert trajectories._source_lines(found, SUBJECT) == []
    assert trajectories._source_lines(found.expand_dims("member"), behind) == []
    assert trajectories._source_lines(found[["outcome", *list(found)[1:7]]], behind) == lines[:1]


def test_sections_turning_points_and_spectra():
    found = made(
        {
            "displacement": ("repeat", [1.0, NAN, -2.0], "mm"), "velocity": ("repeat", [0.5, NAN, 0.25], "m/s"),
            "outcome": 0,
        },
        title="Poincare section",
    )  # fmt: skip
    assert said(trajectories.section_words, found) == [
        "Poincare section, 1 member(s)", "displacement -2 to 1 mm", "velocity 0.25 to 0.5 m/s",
    ]  # fmt: skip
    empty = edited(found, displacement=NAN, velocity=NAN, outcome=int(Outcome.OUTSIDE))
    assert said(trajectories.section_words, empty)[1:] == [f"  1 of 1: {Outcome.OUTSIDE.meaning}"]
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
    still = edited(spectrum(2), power_in_lines=NAN, flatness=NAN)
    assert said(trajectories.spectrum_words, still) == ["the actuator stands still: it has no spectrum"]
    failed = edited(spectrum(2), outcome=int(Outcome.STEP_LIMIT))
    assert said(trajectories.spectrum_words, failed) == [f"  1 of 1: {Outcome.STEP_LIMIT.meaning}"]
    two = xr.concat([spectrum(2), edited(spectrum(2), rms=0.25, power_in_lines=0.5, flatness=0.5)], "member")
    two["rms"].attrs["units"] = "mm"
    assert said(trajectories.spectrum_words, two)[1:] == [
        "rms 0.25 to 0.75 mm", "power in lines 0.5 to 0.875", "flatness 0.01562 to 0.5",
    ]  # fmt: skip


def test_a_step_that_goes_down_and_settles():
    along = "constant_voltage"
    values = {"begin": (5.0, "mm"), "end": (2.0, "mm"), "equilibrium": (1.5, "mm"), "rise_time": (12.0, "ms"),
              "settling_time": (40.0, "ms"), "overshoot": (0.25, "1"), "drift": (0.0125, "1"), "outcome": (0,
              "1")}  # fmt: skip
    step = made({n: (along, [v], unit) for n, (v, unit) in values.items()}, {along: (along, [500.0], "V")})
    assert said(trajectories.step_words, step) == [
        "before the step: 5 mm",
        "  500 V: moves by 3 mm to 2 mm (a slow ramp ends at 1.5 mm); rise 12 ms, overshoot 25.0%, settled after 40 "
        "ms, "
        "drift at the end 1.25%",
    ]
    still = step.assign(
        {name: step[name].copy(data=[NAN]) for name in ("rise_time", "settling_time", "overshoot", "drift")}
    )
    assert said(trajectories.step_words, still)[1] == "  500 V: does not move the disc from 2 mm"
    slow = step.assign(
        rise_time=step["rise_time"].copy(data=[5.4e6]), settling_time=step["settling_time"].copy(data=[2.7e7])
    )
    assert "; rise 90 min, overshoot 25.0%, settled after 7.5 h, drift" in said(trajectories.step_words, slow)[1]


def test_a_creeping_film_that_never_pulls_in_or_could_not_be_followed():
    along = "constant_voltage"
    found = made(
        {
            "begin": (along, [1.0, 2.0], "mm"), "end": (along, [1.25, NAN], "mm"), "equilibrium": (along, [1.5, NAN],
            "mm"),
            "pull_in_time": (along, [INF, NAN], "ms"), "outcome": (along, [0, int(Outcome.STEP_LIMIT)]),
            "heating": ((along, "time"), [[0.0, 2.0]] * 2, "K/s"), "long_time_voltage": (None, INF, "V"),
            "instant_voltage": (None, INF, "V"), "holding_voltage": (None, INF, "V"),
            "margin": labelled(((along, "time"), [[0.5, INF]] * 2)).assign_attrs(infinite_means="never"),
            "time_to_pull_in": ("held_voltage", [INF], "ms"),
        },
        {along: (along, [300.0, 700.0], "V"), "time": ("time", [0.0, 60_000.0], "ms"),
         "held_voltage": ("held_voltage", [640.0], "V")},
    )  # fmt: skip
    assert said(trajectories.creep_words, found) == [
        "no constant voltage pulls the film in, at once or in the long run",
        "  300 V: creeps from 1 mm to 1.25 mm in 60 s, in the long run 1.5 mm; warms by 2 K/s; margin to pull-in at "
        "the "
        "end: never",
        f"  700 V: {Outcome.STEP_LIMIT.meaning}",
    ]
    cold = found["heating"].copy(data=[[2.0, 1e-7]] * 2)
    assert (
        "in the long run 1.5 mm; no longer warms; margin"
        in said(trajectories.creep_words, found.assign(heating=cold))[1]
    )


def test_voltages_are_written_with_the_digits_that_tell_them_apart():
    assert trajectories.telling_digits([3359.11, 3359.14, 3359.14, 3416.0]) == 6
    assert trajectories.telling_digits([3000.0, 3100.0]) == 4
    assert trajectories.telling_digits([1.0, 1.0 + 1e-15]) == 12


def test_transfer_functions_that_were_not_measured():
    found = made(
        {
            "bias_voltage": (None, 900.0, "V"), "equilibrium": (None, 14.0, "mm"), "natural_frequency": (None, 11.0,
            "Hz"),
            "resonance": (None, 10.5, "Hz"), "gain": ("drive_frequency", [2.0, 7.0], "mm/kV"),
            "measured_gain": (("amplitude", "measured_frequency"), np.zeros((0, 0))),
        },
        {"drive_frequency": ("drive_frequency", [5.0, 10.0], "Hz"), "measured_frequency": ("measured_frequency", []),
         "amplitude": ("amplitude", [])},
    )  # fmt: skip
    assert said(trajectories.transfer_words, found) == [
        "about 900 V: displacement 14 mm, natural frequency 11 Hz", "largest gain 7 mm/kV at 10.5 Hz",
    ]  # fmt: skip


# --- kinds of motion --------------------------------------------------------------------------------------------------


def exponents(**changes):
    own = {
        "outcome": 0, "lyapunov": ("exponent", [0.04, -0.06], "1/s"), "standard_error": ("exponent", [0.002, 0.003]),
        "sign": 1, "per_repeat": 0.5, "sum_residual": -3e-9, "finite": ("exponent", [0.0625, -0.125]),
        "finite_time": ("window", [10.0, 5000.0], "ms"), "averaged_time": (None, 240_000.0, "ms"), "cycle": 0,
    }  # fmt: skip
    return edited(made(own), **changes)


@pytest.mark.parametrize(
    ("sign", "word"), [(1, "certainly positive"), (0, "sign uncertain within the budget"), (-1, "certainly negative")]
)
def test_exponents_of_one_run(sign, word):
    """0.5 a repeat over 0.04 a second: a forcing period of 12.5 seconds."""
    assert said(motions.lyapunov_words, exponents(sign=sign)) == [
        f"largest exponent +0.0400 ± 0.0020 per second (+0.500 ± 0.025 per forcing period), {word}",
        "second exponent -0.0600 ± 0.0030 per second; the sum of all is off the mean trace by 3e-09",
        "averaged over 4 min after the transient",
        "over the first 5 s from the start: +0.0625 and -0.125 per second",
    ]


@pytest.mark.parametrize(
    ("cycle", "words_"), [(1, "rest or a cycle of 1 forcing period"), (3, "a cycle of 3 forcing periods")]
)
def test_exponents_of_a_cycle(cycle, words_):
    line = said(motions.lyapunov_words, exponents(cycle=cycle))[2]
    assert line == f"from the multipliers of what it settles on, {words_}"


def test_exponents_of_an_ensemble_and_of_a_failed_run():
    failed = exponents(outcome=int(Outcome.PULLED_IN))
    assert said(motions.lyapunov_words, failed) == [f"1 of 1 run(s) failed: {Outcome.PULLED_IN.meaning}"]
    voltages = labelled(("voltage", [0.5, 0.75], "V")).assign_attrs(quantity="parameter")
    two = xr.concat([exponents(), failed], voltages.rename("voltage"))
    two["voltage"].attrs.update(quantity="parameter", units="V")
    lines = said(motions.lyapunov_words, two)
    assert lines[1] == "largest exponent in the long run:"
    assert lines[2].startswith("  voltage 0.5 V: +0.0400 ± 0.0020 per second (")
    assert lines[3] == "  voltage 0.75 V: failed, pulled in"


def motion(**changes):
    own = {
        "outcome": 0, "regime": int(Regime.PERIODIC), "period": 2, "symmetric": 0, "doubtful": 0, "zero_one": NAN,
        "lyapunov": ("exponent", [-0.25, -0.5], "1/s"), "standard_error": ("exponent", [0.0, 0.0]),
        "cycle_distance": 3e-9, "return_distance": 2e-7, "lowest": (None, 11.0, "mm"), "highest": (None, 14.0, "mm"),
        "averaged_time": (None, 240_000.0, "ms"), "settled_time": (None, 9000.0, "ms"), "validity_near_limit": 0.0,
        "validity_breakdown": 0.0,
    }  # fmt: skip
    return edited(made(own), **changes)


HOLDS = "the model holds: film taut, away from its limits"


def test_the_kind_of_one_motion():
    base = [
        "periodic, period 2", "largest exponent -0.25 per second", "displacement 11 to 14 mm",
        "settled (within 3e-09 of its size)", "examined after 9 s; exponents of the cycle", HOLDS,
    ]  # fmt: skip
    assert said(motions.regime_words, motion()) == base
    assert said(motions.regime_words, motion(symmetric=1))[0] == "periodic, period 2, symmetric"
    near = motion(cycle_distance=NAN, doubtful=1)
    assert said(motions.regime_words, near) == [
        *base[:3], "points return to within 2e-07 of its size", "! the evidence disagrees",
        "examined after 9 s; exponents averaged over 4 min", HOLDS,
    ]  # fmt: skip
    chaos = motion(regime=int(Regime.CHAOTIC), period=0, cycle_distance=NAN, zero_one=0.875, settled_time=NAN)
    assert said(motions.regime_words, chaos) == ["chaotic", base[1], base[2], "0-1 test 0.88", HOLDS]
    lost = motion(validity_near_limit=0.125, validity_breakdown=NAN)
    assert said(motions.regime_words, lost)[-2:] == [
        "share of the motion in which the model does not hold: near the stretch limit 12.5 %",
        "breakdown unknown: the dielectric strength is not given",
    ]
    failed = motion(outcome=int(Outcome.OUTSIDE), validity_near_limit=NAN, validity_breakdown=NAN)
    assert said(motions.regime_words, failed) == [
        f"1 of 1 run(s) failed: {Outcome.OUTSIDE.meaning}", "failed: outside",
    ]  # fmt: skip


# --- statics, tongues, films ------------------------------------------------------------------------------------------


def statics_of(**changes):
    over = ("constant_voltage", "equilibrium")
    own = {
        "outcome": 0, "displacement": ("displacement", [0.0], "mm"), "pitchfork_voltage": (None, NAN, "V"),
        "fold_voltage": ("fold", [NAN, 1300.0]), "fold_displacement": ("fold", [NAN, 16.0]),
        "pull_in_kind": int(PullIn.FOLD), "pull_in_voltage": (None, 1300.0, "V"), "pull_in_from": (None, 16.0, "mm"),
        "pull_in_to": (None, 22.0, "mm"), "equilibria": ("constant_voltage", [2, 0]),
        "equilibrium_displacement": (over, [[13.0, 21.0], [NAN, NAN]], "mm"), "stable": (over, [[1, 0], [0, 0]]),
        "film_state": coded(over, [[1, 0], [0, 0]], ("taut", "hoop_slack")),
        "second_film_state": coded(over, [[0, 2], [0, 0]], ("taut", "hoop_slack", "crumpled")),
        "stroke": ("constant_voltage", [3.0, NAN], "mm"), "blocked_force": ("constant_voltage", [0.5, NAN], "N"),
        "cycle_work": ("constant_voltage", [NAN, NAN], "mJ"),
        **{f"validity_{n}": (over, [[0.0, 1.0 * (n == "near_limit")]] * 2) for n in words.FAILINGS},
    }  # fmt: skip
    return edited(made(own, {"constant_voltage": ("constant_voltage", [800.0, 1400.0], "V")}), **changes)


RAMP = f"slow voltage ramp from 0: at 1300 V the disc {PullIn.FOLD.meaning}"


def test_equilibria_at_constant_voltages():
    lines = [
        "constant voltage:",
        "  800 V: rests at 13 mm (stable, film hoop slack), 21 mm (unstable, second film crumpled, near the stretch "
        "limit); stroke 3 mm, blocked force 0.5 N",
        "  1400 V: rests at nothing; beyond pull-in",
        "fold at 1300 V, displacement 16 mm",
        f"{RAMP} (moves to 22 mm)",
    ]
    assert said(statics.static_words, statics_of()) == lines
    never = statics_of(pull_in_voltage=NAN, fold_voltage=NAN, pitchfork_voltage=900.0)
    assert said(statics.static_words, never)[2:] == [
        "  1400 V: rests at nothing; no slow ramp from 0 leads there",
        "pitchfork of the flat film at 900 V",
        "slow voltage ramp from 0: no stable equilibrium to start from",
    ]
    stays = statics_of(pull_in_kind=int(PullIn.NEVER), pull_in_voltage=INF)
    assert said(statics.static_words, stays)[-1] == f"slow voltage ramp from 0: {PullIn.NEVER.meaning}"
    assert said(statics.static_words, statics_of(pull_in_to=16.0))[-1] == f"{RAMP} (it leaves it gradually)"
    assert said(statics.static_words, statics_of(pull_in_to=INF))[-1] == RAMP
    lost = statics_of(outcome=int(Outcome.OUTSIDE))
    assert said(statics.static_words, lost) == [
        f"1 of 1 run(s) failed: {Outcome.OUTSIDE.meaning}", "nothing can be reached inside the stretch limit",
    ]  # fmt: skip


def test_tongues():
    found = made(
        {
            "outcome": 0, "own_onset_voltage": (None, 1250.0, "V"), "own_onset_kind": int(Onset.MINUS_ONE),
            "own_searched": ("end", [0.0, 3000.0], "V"), "onset_voltage": ("drive_frequency", [NAN, 900.0, 1100.0],
            "V"),
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
    none = edited(found, own_onset_voltage=NAN, own_onset_kind=int(Onset.NONE), onset_voltage=NAN, margin=-1.0,
                  pitchfork_amplitude=NAN)  # fmt: skip
    assert said(stability.tongues_words, none) == [
        f"at its own frequency: {Onset.NONE.meaning} (searched up to 3000 V)", "rest is unstable in 0 % of the grid",
    ]  # fmt: skip


def film_of(heights=(14.0,), voltages=(800.0,), **changes):
    over = ("height", "constant_voltage")
    numbers = {
        "force": (0.25, "N"), "charge": (1.5, "uC"), "capacitance": (2.5, "nF"), "pull_in_voltage": (1700.0, "V"),
        "largest_field": (12.0, "V/um"), "largest_field_radius": (8.5, "mm"), "breakdown_share": (0.625, "1"),
        "largest_limit_share": (0.125, "1"), "least_firmness": (1.75, "1"), "least_firmness_radius": (9.5, "mm"),
        "wrinkled_share": (0.375, "1"), "film_error": (0.0125, "1"),
    }  # fmt: skip
    shape = (len(heights), len(voltages))
    own = {n: (over, np.full(shape, v), unit) for n, (v, unit) in numbers.items()}
    own |= {"held": (over, np.zeros(shape, dtype=int)), "film_state": coded(over, np.ones(shape, dtype=int), ("taut",
            "partly_wrinkled")), "displacement": (over, np.broadcast_to(np.array(heights)[:, None], shape),
            "mm")}  # fmt: skip
    rings = ("ring", *over)
    own |= {"meridional_stretch": (rings, np.stack([np.full(shape, v) for v in (1.25, 1.5)])),
            "thickness": (rings, np.stack([np.full(shape, v) for v in (0.1, 0.2)]), "mm")}  # fmt: skip
    own["outcome"] = 0
    coords = {"height": ("height", list(heights), "mm"), "constant_voltage": ("constant_voltage", list(voltages), "V")}
    return edited(made(own, coords), **changes)


def film_lines(shown):
    return profile.film_words(shown, SUBJECT).splitlines()[len(answer.heading(SUBJECT, profile.OWN)) :]


def test_one_state_of_a_film():
    lines = [
        "14 mm at 800 V: partly wrinkled, 38% of its area",
        "  force 0.25 N (in runs within 1.2%), charge 1.5 uC, capacitance 2.5 nF",
        "  largest field 12 V/um at the mounted radius 8.5 mm, 62% of the dielectric strength",
        "  meridional stretch 1.25 to 1.5, thickness 0.1 to 0.2 mm; at most 0.12 of the stretch limit",
        "  least firmness 1.75 at the mounted radius 9.5 mm (0: localisation); pulls in at this height at 1700 V",
    ]
    assert film_lines(film_of()) == lines
    for share in (0.0, 1.0):
        assert film_lines(film_of(wrinkled_share=share))[0] == "14 mm at 800 V: partly wrinkled"
    assert film_lines(film_of(breakdown_share=1.25))[2] == f"{lines[2].replace('62%', '125%')}: breaks down"
    assert film_lines(film_of(breakdown_share=NAN)) == [
        *lines[:2], lines[2].partition(", 62%")[0], *lines[3:], words.UNKNOWN_STRENGTH
    ]  # fmt: skip
    slack = film_of(held=int(Held.SLACK), force=NAN)
    assert film_lines(slack) == [f"14 mm at 800 V: {Held.SLACK.meaning}"]
    assert film_lines(film_of(held=int(Held.NO_REST), force=NAN, displacement=NAN)) == [
        f"no rest at 800 V: {Held.NO_REST.meaning}"
    ]


def test_states_of_a_film_over_heights_and_voltages():
    lines = film_lines(
        film_of((12.0, 14.0), (800.0, 900.0), held=[[0, 0], [0, 1]], capacitance=[[2.0, 3.0], [4.0, NAN]])
    )
    assert lines[0] == (
        "  12 mm at 800 V: partly wrinkled, 38% of its area; force 0.25 N, capacitance 2 nF, field 12 V/um, 62% of the "
        "dielectric strength"
    )
    assert lines[3] == f"  14 mm at 900 V: {Held.SLACK.meaning}"
    assert lines[4] == "capacitance nF over height mm and voltage V:"
    assert [line.split() for line in lines[5:]] == [["800", "900"], ["12", "2", "3"], ["14", "4", "-"]]


# --- tables -----------------------------------------------------------------------------------------------------------


def test_a_table_says_yes_or_no_and_what_a_code_means():
    found = made({"outcome": 0, "resting": 1, "kind": coded(None, 1, ("none", "the_cone")), "small": (None, 0.005,
    "mm"),
                  "large": (None, 12.5, "mm"), "validity_near_limit": 0.0, "validity_breakdown": 0.0})  # fmt: skip
    for name, text in (("resting", "1 if the disc rests"), ("kind", "the kind"), ("small", "a small number"),
                       ("large", "a number"), ("outcome", "outcome")):  # fmt: skip
        found[name].attrs["long_name"] = text
    for name in ("small", "large"):
        found[name].attrs["quantity"] = "length"
    lines = ["the disc rests: yes", "the kind: the cone", "a small number: 5 um", "a number: 12.5 mm"]
    assert said(tables.table_words, found) == [*lines, HOLDS]
    assert said(tables.table_words, edited(found, resting=0))[0] == "the disc rests: no"
    failed = edited(found, outcome=int(Outcome.ERROR), validity_near_limit=NAN, validity_breakdown=NAN)
    assert said(tables.table_words, failed) == [f"1 of 1 run(s) failed: {Outcome.ERROR.meaning}", "failed"]
    names = labelled(("voltage", [1.0, 2.0], "V")).rename("voltage")
    two = xr.concat([found, failed], names)
    two["voltage"].attrs.update(quantity="parameter", units="V")
    members = said(tables.table_words, two)[1:3]
    assert members == [f"  voltage 1 V: {'; '.join(lines)}", "  voltage 2 V: failed"]


# --- frequency responses and diagrams ---------------------------------------------------------------------------------


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
    "swept up    largest stroke 3 ± 0.1 mm at 11 [10.75, 11.25] Hz",
    "swept down  largest stroke 2.5 ± 0.05 mm at 10.5 [10.25, 10.625] Hz",
    "linear theory: largest stroke 0.75 mm at 11 Hz",
    "jumps (the sweeps differ between):",
    "  swept up    at 11.5 to 11.75 Hz: stroke 2.5 -> 0.5 mm, fold at 11.625 Hz",
]


def response_lines(shown, model=MODEL):
    subject = Subject(model)
    head = len(answer.heading(subject, ["drive_frequency"]))
    return frequency.frequency_words(shown, subject).splitlines()[head:]


def test_a_frequency_response():
    assert response_lines(sweeps()) == RESPONSE
    found = response_lines(sweeps(peak_frequency=[12.0, 10.0]))
    rising = ", an end of the frequencies: it may rise beyond"
    assert [line.endswith(rising) for line in found[1:3]] == [True, True]
    odd = sweeps(period=[[1, 2, 0], [1, 1, 3]])
    assert response_lines(odd)[2] == "            subharmonic at 1, not periodic at 1 of 3 frequencies"
    assert response_lines(odd)[4] == "            subharmonic at 1 of 3 frequencies"
    at_rest = sweeps(period=[[1, 2, 0], [1, 1, 3]], resting=[[0, 0, 1], [0, 0, 0]])
    assert response_lines(at_rest)[2] == "            subharmonic at 1 of 3 frequencies"
    assert response_lines(sweeps(jump_event_kind=-1))[-1].endswith("0.5 mm, no bifurcation found there")
    assert response_lines(sweeps().drop_vars("jump_event"))[-1].endswith("0.5 mm")
    assert response_lines(sweeps().isel(jump=slice(0, 0)))[-1] == "no jump: both sweeps show the same motion"
    assert response_lines(sweeps(linear_stroke=[NAN, 1.0, 1.0]))[3] == (
        "no linear theory: no stable equilibrium under the drive's mean square"
    )
    failed = sweeps(outcome=[[0, 0, 0], [0, int(Outcome.PULLED_IN), 0]])
    assert response_lines(failed)[1] == f"1 of 6 run(s) failed: {Outcome.PULLED_IN.meaning}"


def branches_of(**changes):
    own = {
        "value": (("branch", "point"), [[1.0, 1.5, 2.0, NAN], [1.25, 1.75, NAN, NAN]], "V"),
        "stable": (("branch", "point"), [[1, 0, 0, -1], [1, 1, -1, -1]]), "resting": ("branch", [1, 0]),
        "period": ("branch", [1, 2]), "symmetric": ("branch", [0, 1]),
        "ended": coded(("branch", "end"), [[0, 1], [2, 3]], ("limit", "wall", "merged", "step")),
        "event_branch": ("event", [0, 1]), "event_kind": coded("event", [1, 2], EVENTS),
        "event_value": ("event", [1.125, 1.625], "V"), "event_error": ("event", [2e-7, 3e-7]),
        "event_supercritical": ("event", [1, 0]), "event_born_branch": ("event", [1, -1]),
        "event_resolved": ("event", [1, 0]), "checked_cycles": 7, "checked_orbits": 5, "seeded": 2,
        "flag_explanation": ("flag", ["near a fold", ""]), "flag_branch": ("flag", [1, -1]),
        "flag_kind": coded("flag", [0, 1], ("lost_orbit", "another_motion")), "flag_value": ("flag", [1.4375, 1.9]),
    }  # fmt: skip
    return edited(made(own, parameter="voltage"), **changes)


def test_branches_of_orbits():
    lines = [
        "branch 0: rest, voltage 1 to 2 V, 3 points, 33.3 % of them stable; ends: the end of the interval, the "
        "stretch limit",
        "  period doubling at 1.125 V ± 2e-07 V, supercritical, branch 1 is born",
        "branch 1: period 2, symmetric, voltage 1.25 to 1.75 V, 2 points, 100 % of them stable; ends: a branch of "
        "half its "
        "period or a symmetric one, the shortest step",
        "  symmetry breaking at 1.625 V ± 3e-07 V, subcritical, unresolved",
        "brute force: 7 settled cycles, all on these branches (2 started one); 5 stable orbits run from 1e-5 away; 2 "
        "contradiction(s), 1 explained",
        "  lost orbit, branch 1, voltage 1.438 V: near a fold".replace("1.438", "1.4375"),
        "  another motion, branch none, voltage 1.9 V",
    ]
    assert branches.branch_lines(branches_of()) == lines
    assert branches.branch_lines(branches_of(event_supercritical=-1))[1].endswith("± 2e-07 V, branch 1 is born")
    none = branches_of(checked_orbits=0, flag_explanation=["", ""])
    assert branches.branch_lines(none)[4] == (
        "brute force: 7 settled cycles, all on these branches (2 started one); no stable orbit decays fast enough to "
        "be "
        "run; 2 contradiction(s)"
    )
    assert branches.branch_lines(branches_of(), "drive frequency")[0].startswith(
        "branch 0: rest, drive frequency 1 to 2 V"
    )


@pytest.mark.parametrize(
    ("low", "high", "word"), [("1", "1", "is empty"), ("2", "1", "is reversed"), ("1", "2", None), ("1 V", "0 V", None)]
)
def test_two_ends_in_the_wrong_order(low, high, word):
    if word is None:
        branches._check_order("voltage", low, high)
        return
    with pytest.raises(gelcone.InputError, match=f"voltage from {low} to {high}: {word}; give the lower end first"):
        branches._check_order("voltage", low, high)


# --- maps, sweeps, draws ----------------------------------------------------------------------------------------------

TOTALS = {"computed": 5, "computed_before": 0, "cells": 6, "inferred": 0, "failed": 0, "integrator_steps": 12345,
          "wall_time_s": 2.5, "checked": 0, "missed": 0, "border_dimension": None}  # fmt: skip


def test_what_a_run_of_cells_says_of_itself():
    assert grids.totals_text(TOTALS) == "5 of 6 cells computed; 12,345 steps in 2.5 s"
    more = TOTALS | {"computed_before": 2, "inferred": 1, "failed": 3, "border_dimension": [1.25, 0.125]}
    assert grids.totals_text(more).splitlines() == [
        "5 of 6 cells computed, 2 of them before, 1 inferred, 3 failed; 12,345 steps in 2.5 s",
        "borders between regimes: dimension 1.25 ± 0.12 (the work of refining grows with that power of the cells a "
        "side)",
    ]
    checked = grids.totals_text(TOTALS | {"checked": 200, "missed": 1}).splitlines()[1]
    head, _, share = checked.partition(": 0.5 % [")
    assert head.endswith("of 200 inferred cells, drawn at random and computed, 1 had another regime or sign")
    low, high = (float(end) for end in share.rstrip("]").split(", "))
    assert 0.0 < low < 0.5 < high < 5.0


def map_of(**changes):
    over = ("voltage", "damping_ratio")
    own = {
        "regime": (over, [[1, 3], [0, 3]]), "outcome": (over, [[0, 0], [0, 0]]), "doubtful": (over, [[0, 1], [0, 0]]),
        "lyapunov": ((*over, "exponent"), [[[-0.25, -1.0], [0.5, -2.0]], [[-0.75, -3.0], [0.125, -4.0]]], "1/s"),
        "standard_error": ((*over, "exponent"), np.zeros((2, 2, 2))),
    }  # fmt: skip
    coords = {"voltage": ("voltage", [800.0, 900.0], "V"), "damping_ratio": ("damping_ratio", [0.25, 0.5])}
    return edited(made(own, coords, totals=json.dumps(TOTALS)), **changes)


def test_a_map():
    head = len(answer.heading(SUBJECT, ["voltage", "damping_ratio"]))
    lines = grids.map_words(map_of(), SUBJECT).splitlines()[head:]
    assert lines == [
        "voltage 800 to 900 V, 2 values; damping_ratio 0.25 to 0.5, 2 values",
        "rest 1, periodic 1, chaotic 2 (50 % chaotic)",
        "5 of 6 cells computed; 12,345 steps in 2.5 s",
        "highest exponent +0.5 per second at voltage 800 V, damping_ratio 0.5",
        "lowest exponent -0.75 per second at voltage 900 V, damping_ratio 0.25",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
    ]
    unknown = grids.map_words(map_of(lyapunov=NAN, doubtful=0), SUBJECT).splitlines()[head:]
    assert unknown == lines[:3]


def test_cells_that_are_counted_and_missing():
    left = int(Regime.LEFT_THE_DOMAIN)
    pulled = map_of(regime=[[1, left], [left, 3]], outcome=[[0, 6], [2, 0]])
    assert answer.counts_text(pulled) == "periodic 1, chaotic 1, left the domain 1, pulled in 1"
    alone = map_of(regime=[[1, left], [left, 3]], outcome=[[0, 6], [6, 0]])
    assert answer.counts_text(alone) == "periodic 1, chaotic 1, pulled in 2"
    shown = map_of().assign(status=(("voltage", "damping_ratio"), [[1, 2], [0, 0]]))
    shown.attrs["totals"] = json.dumps(TOTALS | {"computed": 1, "inferred": 1, "cells": 4})
    assert "1 cells computed, 1 inferred, 2 missing of 4" in grids.show_words(shown, SUBJECT).splitlines()
    names = answer.outcome_names(shown)
    assert names == [["ok", "ok"], ["unknown", "unknown"]]


def thresholds(rows):
    columns = {"low": (1.25, "V"), "high": (1.5, "V"), "from": (1, "1"), "to": (3, "1"), "cascade": (1, "1")}
    own = {f"threshold_{n}": ("threshold", [v] * rows, unit) for n, (v, unit) in columns.items()}
    own["threshold_branch"] = ("threshold", ["up"] * rows)
    return made(own, parameter="voltage")


def test_changes_of_regime():
    assert grids._threshold_lines(thresholds(1)) == [
        "changes of regime:", "  up: periodic -> chaotic at voltage 1.25 to 1.5 V, by a cascade of period doublings",
    ]  # fmt: skip
    assert grids._threshold_lines(edited(thresholds(1), threshold_cascade=0))[1].endswith("1.25 to 1.5 V")
    assert grids._threshold_lines(thresholds(0)) == ["no change of regime"]


def tolerances(**changes):
    sobol = ("parameter", "end")
    own = {
        "probability": ("risk", [0.25, NAN]), "low": ("risk", [0.125, NAN]), "high": ("risk", [0.5, NAN]),
        "decided": ("risk", [16, 0]), "stroke": ("quantile", [1.0, 2.0, 3.0], "mm"),
        "stroke_low": ("quantile", [NAN, 1.5, 2.5]), "stroke_high": ("quantile", [1.25, 2.25, INF]),
        "first_order": (sobol, [[0.25, 0.125, 0.375], [0.5, 0.375, 0.625]]),
        "total_order": (sobol, [[0.375, 0.25, 0.5], [0.75, 0.625, 0.875]]),
    }  # fmt: skip
    coords = {"risk": ("risk", ["chaos", "pull-in"]), "quantile": ("quantile", [0.05, 0.5, 0.95]),
              "parameter": ("parameter", ["prestretch", "damping_ratio"]), "end": ("end", ["value", "low",
              "high"])}  # fmt: skip
    return edited(made(own, coords), **changes)


def test_tolerances():
    lines = [
        "probability of chaos 0.25 [0.125, 0.5] of 16 draws",
        "quantiles of the stroke in mm: 5 % 1 [unknown, 1.25], 50 % 2 [1.5, 2.25], 95 % 3 [2.5, unknown]",
        "share of the stroke's variance by each parameter (Sobol indices: alone; with interactions):",
        "  damping_ratio: 0.50 [0.38, 0.62]; 0.75 [0.62, 0.88]",
        "  prestretch: 0.25 [0.12, 0.38]; 0.38 [0.25, 0.50]",
    ]
    assert grids.tolerance_lines(tolerances()) == lines
    assert grids.tolerance_lines(tolerances(total_order=NAN))[2:] == [
        "Sobol indices of the stroke: none, for some draw has no stroke or all have the same one"
    ]
    assert grids.tolerance_lines(tolerances(stroke=NAN)) == lines[:1]
    assert grids.tolerance_lines(tolerances().drop_vars(["first_order", "total_order"])) == lines[:2]
    over = xr.concat([tolerances(), tolerances(probability=0.75, stroke=[4.0, 5.0, 6.0])], "voltage")
    over = over.assign_coords(voltage=("voltage", [800.0, 900.0], {"units": "V"}))
    found = grids.tolerance_lines(over.drop_vars(["first_order", "total_order"]))
    assert found[0].endswith(", the highest, at voltage 900 V")
    assert found[-1].startswith("quantiles of the stroke in mm: 5 % 4 [")
    assert found[-1].endswith("], at voltage 900 V")


def test_membranes_between_which_voltages_were_interpolated():
    assert grids.membranes_lines(made({})) == []
    between = made({}, membranes=json.dumps({"made": 7, "films": 64, "error": 0.00125}))
    assert grids.membranes_lines(between) == [
        "pull-in of the membrane: 7 membranes made for 64 films, the voltages of the others interpolated to 0.12 % "
        "(root "
        "mean square)"
    ]


def drawn_window(**changes):
    own = {
        "outcome": ("draw", [0, 0, 0, 6]), "recommended_peak": (("draw", "drive_frequency"), [[8.0,
        6.0]] * 3 + [[NAN] * 2],
                                                               "V"),
        "static_limit_voltage": (("draw", "static_limit"), [[20.0, INF]] * 3 + [[NAN] * 2], "V"),
        "recommended_constant": ("draw", [16.0, 16.0, 16.0, NAN], "V"),
        "limit_low": (("draw", "driven_limit", "drive_frequency"),
                      [[[10.0, 30.0], [12.0, 7.5]]] * 2 + [[[10.0, NAN], [12.0, INF]]] + [[[NAN] * 2] * 2], "V"),
        "own_frequency": ("draw", [12.0] * 4, "Hz"), "own_peak": ("draw", [6.5, 7.5, 7.0, 7.25], "V"),
    }  # fmt: skip
    coords = {"drive_frequency": ("drive_frequency", [10.0, 14.0], "Hz"), "static_limit": ("static_limit", ["pull-in",
              "pitchfork"]), "driven_limit": ("driven_limit", ["hoop slack", "chaos"])}  # fmt: skip
    shown = made(own, coords, analysis="envelope", options='{"margin": 0.2}')
    return edited(shown, **changes).assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2, 1.3]))


def test_an_envelope_of_draws():
    lines = drawn.over_draws_words(drawn_window(), SUBJECT).splitlines()
    lines = lines[len(answer.heading(SUBJECT, ["prestretch"])) :]
    assert lines[:5] == [
        "4 draws of prestretch", f"1 of 4 run(s) failed: {Outcome.PULLED_IN.meaning}",
        "pull-in at constant voltage: 20 V, 95 % within 20 V to 20 V; none in 1 of 4 draws",
        "recommended constant voltage, 20% below its limits: 16 V, 95 % within 16 V to 16 V; none in 1 of 4 draws",
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
    assert lines[8] == "its own drive, 7.125 V at 12 Hz: inside the window in 2 of 4 draws"
    outside = drawn.over_draws_words(drawn_window(own_frequency=15.0), SUBJECT).splitlines()[-1]
    assert outside == "its own drive: outside the frequencies examined"
    free = drawn._first_limits(drawn_window(limit_low=INF, static_limit_voltage=NAN))
    assert (free == "none").all()


def test_a_frequency_response_of_draws():
    own = {
        "outcome": (("draw", "branch"), np.zeros((2, 2), dtype=int)),
        "peak_amplitude": (("draw", "branch"), [[1.0, 2.0], [1.0, 2.0]], "mm"),
        "peak_frequency": (("draw", "branch"), [[11.0, 12.0], [11.0, 12.0]], "Hz"), "jumps": ("draw", [0, 2]),
    }  # fmt: skip
    coords = {"branch": ("branch", ["up", "down"]), "drive_frequency": ("drive_frequency", [10.0, 14.0], "Hz")}
    shown = made(own, coords, analysis="frequency").assign_coords(drawn_prestretch=("draw", [1.0, 1.1]))
    lines = drawn.over_draws_words(shown, SUBJECT).splitlines()[len(answer.heading(SUBJECT, ["prestretch"])) :]
    assert lines == [
        "2 draws of prestretch", "drive frequency 10 to 14 Hz, 2 values",
        "swept up, largest stroke: 2 mm, 95 % within 2 mm to 2 mm",
        "swept up, its frequency: 11 Hz, 95 % within 11 Hz to 11 Hz",
        "swept down, largest stroke: 4 mm, 95 % within 4 mm to 4 mm",
        "swept down, its frequency: 12 Hz, 95 % within 12 Hz to 12 Hz",
        "the sweeps differ, with jumps, in 1 of 2 draws",
    ]  # fmt: skip


# --- envelopes and drives ---------------------------------------------------------------------------------------------


def window(**changes):
    driven, at = ("driven_limit", "drive_frequency"), "drive_frequency"
    own = {
        "outcome": 0, "static_limit_voltage": ("static_limit", [2500.0, 2000.0, INF], "V"),
        "limit_low": (driven, [[1250.0, 1500.0], [NAN, NAN]]), "limit_high": (driven, [[1300.0, 1500.0], [NAN, NAN]]),
        "recommended_constant": (None, 1600.0, "V"), "recommended_peak": (at, [1000.0, 1200.0], "V"),
        "window_stroke": (at, [3.0, 2.0], "mm"), "window_power": (at, [40.0, 50.0], "mW"),
        "window_apparent_power": (at, [60.0, 70.0], "mVA"), "window_regime": (at, [1, 1]), "first_limit": (at, [0, 0]),
        "stroke": ("peak_voltage", [0.0, 8.0], "mm"), "blocked_force": ("peak_voltage", [0.0, 0.5], "N"),
        "natural_frequency": ("peak_voltage", [12.0, 10.0], "Hz"), "static_displacement": ("peak_voltage", [1.0, 2.0]),
        "own_peak": (None, 900.0, "V"), "own_frequency": (None, 12.0, "Hz"), "kick_tried": (at, [NAN, NAN], "m/s"),
        "kick_low": (at, [0.25, 0.5], "m/s"), "kick_high": (at, [0.375, 0.625], "m/s"), "coexisting": (at, [0, 0]),
        "motion_regime": ((at, "motion"), [[3], [3]]), "motion_outcome": ((at, "motion"), [[0], [0]]),
        "motion_period": ((at, "motion"), [[0], [0]]), "motion_stroke": ((at, "motion"), [[5.0], [5.0]], "mm"),
        **{f"motion_validity_{n}": ((at, "motion"), [[0.0], [0.0]]) for n in words.FAILINGS},
    }  # fmt: skip
    coords = {
        "drive_frequency": (at, [10.0, 14.0], "Hz"), "peak_voltage": ("peak_voltage", [0.0, 3200.0], "V"),
        "driven_peak": ("driven_peak", [500.0, 2400.0], "V"), "driven_limit": ("driven_limit", ["pull-in",
        "dielectric breakdown"]), "static_limit": ("static_limit", ["pull-in", "hoop slack", "dielectric breakdown"]),
    }  # fmt: skip
    shown = made(
        own, coords, pull_in_of="membrane", pull_in_error=0.0125, options='{"margin": 0.2, "limits_from": "rest"}'
    )
    return edited(shown, **changes)


ENVELOPE = [
    "limit                   constant voltage  driven, lowest peak voltage",
    "  pull-in               2500 V            1250 to 1300 V at 10 Hz",
    "  hoop slack            2000 V            -",
    "  dielectric breakdown  above 3200 V      unknown",
    "pull-in is that of the film as a membrane, its force known to 1.2%",
    "recommended constant voltage, 20% below its limits: 1600 V; stroke 4 mm, blocked force 0.25 N, natural "
    "frequency 11 Hz "
    "(12 at 0)",
    "recommended drive, 20% below its limits when it is switched on from rest:",
    "  frequency (Hz)    up to (V)   stroke (mm)   power (mW)    apparent (mVA)  first limit",
    "  10                1000        3             40            60              pull-in 1250 to 1300 V",
    "  14                1200        2             50            70              pull-in 1500 V",
    "its own drive, 900 V at 12 Hz: inside the window, 1100 V there",
]


def test_an_envelope():
    assert said(envelope.envelope_words, window()) == ENVELOPE


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"static_limit_voltage": [2500.0, 2000.0, NAN]}, "  dielectric breakdown  unknown           unknown"),
        ({"static_limit_voltage": [2500.0, 2000.0, NAN]},
         "the dielectric strength is not given: the window takes no account of breakdown"),
        ({"static_limit_voltage": [NAN, 2000.0, INF]},
         "  pull-in               not applicable    1250 to 1300 V at 10 Hz"),
        ({"static_limit_voltage": [INF, 2000.0, INF]},
         "  pull-in               not reached       1250 to 1300 V at 10 Hz"),
        ({"static_displacement": [1.0, NAN]}, "  dielectric breakdown  none to pull-in   unknown"),
        ({"limit_low": [[1500.0, 1250.0], [NAN, NAN]], "limit_high": [[1500.0, 1300.0], [NAN, NAN]]},
         "  pull-in               2500 V            1250 to 1300 V at 14 Hz"),
        ({"limit_low": [[1250.0, 1500.0], [1700.0, 1800.0]], "limit_high": [[1300.0, 1500.0], [1700.0, 1900.0]]},
         "  dielectric breakdown  above 3200 V      1700 V at 10 Hz"),
        ({"recommended_constant": 0.0},
         "no constant voltage is recommended: the film is slack from 0 on; pre-stretch it"),
        ({"natural_frequency": NAN}, "recommended constant voltage, 20% below its limits: 1600 V; stroke 4 mm"),
        ({"static_limit_voltage": [4000.0, INF, INF]},
         "recommended constant voltage, 20% below 3200 V, up to which no limit was met: 1600 V; stroke 4 mm, blocked "
         "force 0.25 N, natural frequency 11 Hz (12 at 0)"),
        ({"recommended_peak": 0.0}, "no driven window is recommended: pull-in from 0 on at every frequency"),
        ({"recommended_peak": [0.0, 1200.0]},
         "  10                none        -             -             -               pull-in 1250 to 1300 V"),
        ({"window_regime": [0, 1]},
         "  10                1000        at rest       0             60              pull-in 1250 to 1300 V"),
        ({"window_regime": 0},
         "within the window the film stays at rest: only a bias and a spring that lifts the disc move it there"),
        ({"static_limit_voltage": [2500.0, 1100.0, INF]},
         "  10                1000        3             40            60              hoop slack at constant 1100 V"),
        ({"static_limit_voltage": INF, "limit_low": INF, "first_limit": -1},
         "  10                1000        3             40            60              none met up to 2400 V"),
        ({"own_peak": 1150.0}, "its own drive, 1150 V at 12 Hz: above the window, 1100 V there, and below a limit"),
        ({"own_peak": 1400.0}, "its own drive, 1400 V at 12 Hz: above the window, 1100 V there, and beyond a limit"),
        ({"own_frequency": 9.0}, "its own drive, 900 V at 9 Hz: outside the frequencies examined"),
        ({"own_frequency": 15.0}, "its own drive, 900 V at 15 Hz: outside the frequencies examined"),
        ({"own_peak": 2500.0, "recommended_peak": 1920.0},
         "its own drive, 2500 V at 12 Hz: above the voltages examined, up to 2400 V, at which no limit was met"),
        ({"kick_tried": [0.75, 0.5]},
         "no other motion was found within the window: no kick, a sudden change of the disc's velocity, up to 0.75 m/s "
         "leads away"),
    ],
)  # fmt: skip
def test_another_envelope(changes, text):
    assert text not in ENVELOPE
    assert text in said(envelope.envelope_words, window(**changes))


@pytest.mark.parametrize(("off", "rows"), [(0.05, [0, 1, 2]), (0.03, [0, 2])])
def test_a_row_is_left_out_where_it_is_on_a_line_to_4_per_cent_of_the_largest(off, rows):
    x = np.array([0.0, 1.0, 2.0])
    for sign in (1.0, -1.0):
        assert envelope._bends(x, np.array([0.0, 0.5 + sign * off, 1.0])) == rows
        assert envelope._bends(x, 700.0 * np.array([0.0, 0.5 + sign * off, 1.0])) == rows
    long = np.linspace(0.0, 1.0, 13)
    assert envelope._kept_rows(long, long) == [0, 12]
    assert envelope._kept_rows(long[:12], long[:12]) == list(range(12))
    assert envelope._kept_rows(long, long, np.abs(long - 0.5)) == [0, 6, 12]


@pytest.mark.parametrize(
    ("onset", "pull_in", "margin", "text"),
    [
        (700.0, INF, 0.2, "above onset of rest, 700 V; no other limit is met"),
        (700.0, NAN, 0.2, "above onset of rest, 700 V; no other limit is met"),
        (700.0, 1000.0, 0.2, "above onset of rest, 700 V; 20% below the first other limit, pull-in 1000 V"),
        (1000.0, INF, 0.5, "above the window, 560 V there, and below a limit"),
        (1000.0, 700.0, 0.2, "above the window, 560 V there, and beyond a limit"),
    ],
)
def test_a_drive_beyond_the_loss_of_rest_alone(onset, pull_in, margin, text):
    """Limits that are not met, or not known, are none of those that are left."""
    low = labelled((("driven_limit", "drive_frequency"), [[onset, onset], [pull_in, pull_in]]))
    shown = window(own_peak=800.0, own_frequency=14.0, recommended_peak=560.0, static_limit_voltage=[INF, NAN, INF])
    shown = shown.assign_coords(driven_limit=["onset of rest", "pull-in"]).assign(limit_low=low)
    shown.attrs["options"] = json.dumps({"margin": margin})
    assert envelope._own_line(shown) == f"its own drive, 800 V at 14 Hz: {text}"


@pytest.mark.parametrize(
    ("start", "text"),
    [("rest", " when it is switched on from rest"), ("settled", " when its voltage rises slowly"),
     ("both", " when it is switched on from rest or its voltage rises slowly"), (None, "")],
)  # fmt: skip
def test_what_the_limits_of_a_window_hold_for(start, text):
    options = {"margin": 0.25} | ({} if start is None else {"limits_from": start})
    shown = window().assign_attrs(options=json.dumps(options))
    assert said(envelope.envelope_words, shown)[6] == f"recommended drive, 25% below its limits{text}:"


def test_the_film_whose_pull_in_limits_an_envelope():
    cone = said(envelope.envelope_words, window().assign_attrs(pull_in_of="cone"))[4]
    assert (
        cone == "pull-in is that of the model's film; a membrane, which a wrinkling cone stands for, pulls in earlier"
    )
    volts = {"units": "V"}
    creeps = window().assign(instant_voltage=((), 2700.0, volts), long_time_voltage=((), 2300.0, volts))
    lines = said(envelope.envelope_words, creeps)
    assert lines[4:7] == [
        "pull-in is that of the film as a membrane of the relaxed gel, its force known to 1.2%",
        "the film creeps: at constant voltage it pulls in above 2700 V at once, above 2300 V after a while (gelcone "
        "creep "
        "says when)",
        "limits at constant voltage are those in the long run, with --duration those of a time",
    ]
    never = said(envelope.envelope_words, edited(creeps, long_time_voltage=INF))
    assert never[5] == "the film creeps: no constant voltage pulls it in, at once or in the long run"
    assert never[6].startswith("recommended constant voltage")


@pytest.mark.parametrize(
    ("regime", "outcome", "period", "goal"),
    [(3, 0, 0, "chaotic"), (1, 0, 2, "periodic, period 2"), (5, 6, 0, "pull-in"),
     (5, 2, 0, "left the domain, stretch limit")],
)  # fmt: skip
def test_where_a_kick_leads(regime, outcome, period, goal):
    shown = window(kick_tried=[NAN, 0.75], coexisting=[0, 1], motion_regime=regime, motion_outcome=outcome,
                   motion_period=period, motion_validity_near_limit=0.25)  # fmt: skip
    *_, kick, span, to = said(envelope.envelope_words, shown)
    assert kick == (
        "where a kick, a sudden change of the disc's velocity, can lead from the recommended drive (tried up to 0.75 "
        "m/s):"
    )
    assert span == "  14 Hz: the smallest that leads away lies between 0.5 and 0.625 m/s"
    fails = "" if goal == "pull-in" else "; the model does not hold: near the stretch limit 25 %"
    assert to == f"    to: {goal}, stroke 5 mm{fails}"


def best(**changes):
    own = {
        "stroke": (None, 5.0, "mm"), "work": (None, 6.0, "mJ"), "speed": (None, 0.75, "m/s"), "power": (None, 8.0,
        "mW"),
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
              "power": "mean power 8 mW"}  # fmt: skip
    named = {"stroke": "5 mm", "work": "6 mJ", "speed": "0.75 m/s", "power": "8 mW"}[largest]
    own = ["voltage_amplitude", "voltage_offset", "frequency", "voltage", "voltage_bias"]
    lines = drive.drive_words(best().assign_attrs(largest=largest), SUBJECT).splitlines()
    lines = lines[len(answer.heading(SUBJECT, own)) :]
    others = ", ".join(text for name, text in values.items() if name != largest)
    assert lines == [
        f"largest {largest}: {named} at 11 Hz and 1100 V peak (offset 700 V, amplitude 400 V)",
        f"  {others}, apparent power 90 mVA",
        "  limited by pull-in at 1375 V: 20% below it; this voltage stays below all limits from 10 Hz to 13 Hz",
        "  a kick of 0.25 m/s leads to another motion",
        "  stroke changes by, % per %: spring_rate -2, moving_mass +0.5",
        "  a change of 1 % ends the motion or its period: film_thickness",
    ]
    free = drive.drive_words(best(limit_voltage=INF, kick=INF, sensitivity=0.5), SUBJECT).splitlines()
    assert free[-3:-1] == [
        "  no limit was met at this frequency, up to the highest voltage examined",
        "  no kick that was tried leads to another motion",
    ]
    assert "kick" not in drive.drive_words(best(kick=NAN), SUBJECT)


# --- fits and designs -------------------------------------------------------------------------------------------------


def test_designs_in_the_plural_and_what_was_left_out():
    own = {"stroke": 5.0, "membrane_stroke": 4.0, "peak_voltage": 1500.0, "apparent_power": 3.0, "recommended": 1600.0,
           "probability": 0.96, "probability_low": 0.95, "probability_high": 0.97, "distance": 2.5, "relaxed": 0.0,
           "spring_rate": 15.0}  # fmt: skip
    found = made({n: ("design", [v, v], "N/m" if n == "spring_rate" else "1") for n, v in own.items()}
                 | {"first_limit": ("design", ["pull-in"] * 2), "binds": ("design", ["stroke"] * 2)},
                 {"design": ("design", [1, 2])}, title="designs: pump", frequency=10.0, margin=0.2,
                 free='["spring_rate"]', left_out='["design 3: no rest"]', nominal_probabilities="{}")  # fmt: skip
    lines = design.design_words(edited(found, membrane_stroke=[4.0, NAN])).splitlines()
    assert lines[0] == "pump: 2 designs at 10 Hz, 20% below all limits"
    heads = ["design", "stroke", "as membrane", "peak", "apparent", "probability", "first limit"]
    row = "1 5 mm 4 mm 1500 V 3 mVA 96.0% (95.0% to 97.0%) pull-in, 1600 V recommended"
    assert [lines[1].split(), lines[2].split(), lines[3].split()] == [
        " ".join(heads).split(), row.split(), row.replace("1 5 mm 4 mm", "2 5 mm unknown").split(),
    ]  # fmt: skip
    assert lines[4:] == [
        "design 1: spring_rate 15 N/m", "  natural frequency 2.5 half widths above that of the drive; bound by stroke",
        "design 2: spring_rate 15 N/m", "  natural frequency 2.5 half widths above that of the drive; bound by stroke",
        "left out: design 3: no rest",
    ]  # fmt: skip
    assert design.design_words(found.isel(design=[0])).startswith("pump: 1 design at 10 Hz")


def fit_of_device(**changes):
    own = {
        "prior": ("unknown", [0.1, 10.0]), "left": ("unknown", [0.01, 0.02]), "deviation": ("unknown", [-0.25, 0.125]),
        "value": ("field", [17.25]), "profile_low": ("unknown", [-0.5, NAN]), "profile_high": ("unknown", [0.25, NAN]),
        "structure_objective": ("structure", [12.0, 11.0, 99.0]), "exponent": (("invariant", "field"), [[1.0]]),
        "predicted_value": ("prediction", [0.004, NAN]), "predicted_spread": ("prediction", [0.0001, NAN]),
        "predicted_prior": ("prediction", [0.001, NAN]),
    }  # fmt: skip
    coords = {"unknown": ("unknown", ["spring_rate", "gain of the laser"]), "field": ("field", ["spring_rate"]),
              "structure": ("structure", ["taut", "wrinkling", "membrane"]),
              "prediction": ("prediction", ["stroke@1.5 kV", "pull-in"])}  # fmt: skip
    shown = made(own, coords, readings=120, chosen="wrinkling, damper", chi2=118.5, refused=0, p_value=0.5,
                 film="wrinkling", learnt=1, impossible='{"both": "no rest: anywhere"}', tests='["a", "b"]',
                 next=json.dumps([[["a step to 1 kV", 0.75], ["a ramp", 0.875]], []]))  # fmt: skip
    return edited(shown, **changes)


def test_a_fitted_device():
    pump = gelcone.find_device("biased-pump").replace(film="taut")
    lines = device_fit.device_fit_words(fit_of_device(), pump).splitlines()
    assert lines[:2] == [
        "biased pumping cone: fitted to 120 readings, wrinkling, damper",
        "chi2 = 118.5 of 120 points (p = 0.5): the structure is not refused",
    ]
    undecided = "these tests cannot tell wrinkling from taut" if device_fit.UNDECIDED > 1.0 else ""
    assert lines[2:4] == [
        "structure both: no rest",
        "structures compared, chi2 with priors: wrinkling 11; taut 12; membrane 99",
    ]
    assert (lines[4] == undecided) == bool(undecided)
    at = lines.index(next(line for line in lines if line.startswith("  spring_rate")))
    assert lines[at].split() == ["spring_rate", "17.25", "N/m", "-22.1", "%", "1", "%", "10", "%", "0.10", "more",
    "than",
                                 "2", "standard", "deviations", "from", "its", "prior"]  # fmt: skip
    assert lines[at + 1] == "    95 % by profile: -39.35 to +28.40 %; by curvature -23.63 to -20.58 %"
    assert lines[at + 2].split() == ["gain", "of", "the", "laser", "+13.3", "%", "2", "%", "none", "0.00"]
    assert lines[at + 3 :] == [
        "1 of 1 directions of the fields are learnt from the tests, the others from the priors",
        "changes that leave every reading as it is (s: any factor):", "  spring_rate x s",
        "stroke@1.5 kV: 4 mm +- 100 um (2.5 %; from the priors alone 25 %)", "pull-in: none",
        "next for stroke@1.5 kV, what it would leave of the standard deviation:", "  0.75  a step to 1 kV",
        "  0.88  a ramp", "next for pull-in, what it would leave of the standard deviation:",
    ]  # fmt: skip
    for film, other in (("wrinkling", "taut"), ("taut", "wrinkling"), ("membrane", "wrinkling")):
        refused = device_fit.verdict(fit_of_device().assign_attrs(refused=1, film=film))
        assert refused.endswith(f"the intervals below are not to be relied on; try --films {other}")
        assert "no device of this structure makes these data" in refused
    plan = device_fit.device_plan_words(fit_of_device(), pump).splitlines()
    assert plan[0] == "biased pumping cone: plan of 120 readings in 2 tests, wrinkling film"


def test_the_quality_of_a_fitted_material():
    law = ("law", "branch_count")
    found = made(
        {"fit_error": (law, [[0.02, 0.01]]), "prediction_error": (law, [[0.05, NAN]])},
        {"law": ("law", ["gent"]), "branch_count": ("branch_count", [0, 1])},
        chosen_law="gent", chosen_branches=0, band=0.125, band_mean=0.95, band_least=0.85,
    )  # fmt: skip
    assert material_fit._quality_lines(found) == [
        "mean error 2.00% of a test's largest stress; each test predicted from the others: 5.00%",
        "a prediction is within +-12.5% of a test's largest stress; this band, from the other tests, covers a test "
        "to 95% in "
        "the mean and 85% at worst",
    ]
    few = material_fit._quality_lines(found.assign_attrs(chosen_branches=1))
    assert few == [
        "mean error 1.00% of a test's largest stress; too few tests to leave one out: the error of a prediction is "
        "not known"
    ]
    _, counts, row, chosen = material_fit._compared_lines(found)
    assert (counts.split(), row.split()) == (["0", "1"], ["gent", "5.00", "-"])
    assert chosen.startswith("chosen: gent, 0: the fewest branches")
    assert material_fit._compared_lines(edited(found, prediction_error=NAN)) == []


def test_the_tests_and_notes_of_a_fitted_material():
    own = {"error": [0.0125, NAN, 0.5], "left_out_error": [0.25, NAN, NAN], "voltage": [0.0, 1500.0, 0.0],
           "test_use": ["fit", "check", "leave out"], "test_mode": ["uniaxial", "pure shear", "equibiaxial"],
           "test_kind": ["ramp", "hold", "ramp"], "test_name": ["a.csv", "b.csv", "c.csv"]}  # fmt: skip
    found = made({n: ("test", v) for n, v in own.items()}, reading='[["in percent", ["a.csv", "b.csv"]]]')
    head, *rows = material_fit._test_lines(found)
    assert head == "tests: error, and predicted from the others, % of the largest stress"
    assert [" ".join(row.split()) for row in rows] == [
        "a.csv 1.25 25.00 uniaxial ramp",
        "b.csv - - pure shear hold, 1500 V, predicted only",
        "c.csv 50.00 - equibiaxial ramp, left out",
    ]
    assert material_fit._notes(found) == ["read as:", "  a.csv, b.csv: in percent"]
    assert material_fit._notes(found.assign_attrs(reading="[]")) == []
    many = material_fit._test_lines(found.isel(test=[0] * (material_fit.MOST_TESTS + 2)))
    assert many[-1] == "  and 2 more (all with --json or --out)"


def validated(**changes):
    along = ("constant_voltage", "displacement")
    own = {
        "outcome": 0, "radius_ratio": 0.25, "deviation": (along, [[0.125, -0.25, 0.0625]]),
        "membrane_deviation": (along, [[NAN, 0.0125, -0.025]]), "hoop_slack": (along, [[False, True, False]]),
        "ending": (along, [[0, 0, 4]]), "mesh_force": ("mesh_elements", [1.0, 1.0]), "mesh_displacement": (None, 6.0,
        "mm"),
        "mesh_force_error": ("mesh_elements", [1e-3, 2.5e-4]), "mesh_force_order": ("mesh_elements", [NAN, 2.0]),
        "mesh_shape_error": ("mesh_elements", [3e-3, 1.5e-3]), "mesh_shape_order": ("mesh_elements", [NAN, 1.0]),
        "share": ("share", []), "limit_displacement": ("share", []), "cone_limit_displacement": ("share", []),
    }  # fmt: skip
    coords = {"constant_voltage": ("constant_voltage", [700.0], "V"), "displacement": ("displacement", [4.0, 6.0, 8.0],
    "mm"),
              "mesh_elements": ("mesh_elements", [10, 20])}  # fmt: skip
    return edited(made(own, coords), **changes)


def test_a_cone_against_a_continuum():
    from gelcone.continuum.path import Ending

    taut = validation._voltage_lines(validated())
    assert taut == [
        "disc over film a/b 0.25; cone force over that of the taut continuum, less 1:",
        "  700 V: +6.2% at 8 mm to +12.5% at 4 mm",
        f"    1 of 3: {validation.HOOP_SLACK}",
        f"    1 of 3: {Ending.PULLED_IN.meaning}",
    ]
    wrinkles = validated().assign(pull_in_voltage=1.0)
    assert validation._voltage_lines(wrinkles)[:2] == [
        "disc over film a/b 0.25; cone force over that of the continuum, both wrinkling, less 1:",
        "  700 V: -25.0% at 6 mm to +12.5% at 4 mm; the membrane -2.50% at 8 mm to +1.25% at 6 mm",
    ]
    assert validation._voltage_lines(edited(validated(), deviation=NAN))[1] == "  700 V: the film is taut nowhere"
    assert validation._voltage_lines(edited(wrinkles, deviation=NAN))[1] == "  700 V: no film in tension"
    assert validation._mesh_lines(validated()) == [
        "mesh at 6 mm: elements, error of the force (order), of the shape (order)", "    10  1.00e-03  3.00e-03",
        "    20  2.50e-04 (2.00)  1.50e-03 (1.00)",
    ]  # fmt: skip
    assert validation._mesh_lines(edited(validated(), mesh_force=NAN)) == []
    assert validation._pull_in_lines(validated()) == []
    assert validation._limit_lines(validated()) == []


# --- JSON -------------------------------------------------------------------------------------------------------------

SHOWN = {"time": 1e3, "voltage": 1.0, "frequency": 1.0, "length": 1e3}
"""Units in which results are read, in an SI unit."""


@pytest.fixture(scope="module")
def pump():
    device = gelcone.find_device("biased-pump").replace(film="taut")
    return Subject(device.to_model(), device, (0.25, 0.5))


@pytest.mark.parametrize("name", [name for name in ANALYSES if name not in ("show", "sweep")])
def test_the_options_of_an_answer_are_in_the_units_of_the_device(name, pump):
    model, device = pump.model, pump.device
    per = {"time": device.scales.time, "voltage": device.voltage_amplitude / model.voltage,
           "frequency": device.frequency / model.drive_frequency, "length": device.scales.length}  # fmt: skip
    measured = {o.name: o.quantity for o in ANALYSES[name].options.values() if o.quantity}
    shown = made({}, options=json.dumps(dict.fromkeys(measured, 0.5) | {"tolerance": 0.25, "unset": None}))
    found = answer.options_json(ANALYSES[name].command, shown, device)
    for option, quantity in measured.items():
        assert found[option] == pytest.approx(0.5 * per[quantity] * SHOWN[quantity], rel=1e-9), option
    assert found["tolerance"] == 0.25
    assert found["unset"] is None
    plain = answer.options_json(ANALYSES[name].command, shown, None)
    assert all(plain[option] == 0.5 for option in measured)


def test_the_answer_says_what_it_is_about(pump):
    shown = made(
        {"outcome": ("member", [0, 6]), "highest": ("member", [1.0, NAN], "mm"), "validity_near_limit": ("member",
        [0.5, NAN]),
         "film_state_taut": ("member", [1.0, 0.5])},
        options='{"budget": null}',
    )  # fmt: skip
    ensemble = Subject(MODEL.replace(voltage=[0.5, 0.75, 1.0]), None, (0.25, 0.5))
    found = answer.plain(answer.answer_json("regime", {"kind": "made"}, shown, ensemble))
    assert found["subject"] == {"device": None, "fields": None, "film": "taut", "members": 3, "initial": [0.25, 0.5]}
    assert found["parameters"]["voltage"] == [0.5, 0.75, 1.0]
    assert (found["command"], found["result"], found["units"]) == ("regime", {"kind": "made"}, None)
    assert found["outcome"] == ["ok", "pulled_in"]
    assert found["validity"] == {"near_limit": [0.5, "unknown"]}
    assert found["film_state"] == {"taut": [1.0, 0.5]}
    assert found["dims"] == {str(name): ["member"] for name in shown}
    own = answer.plain(answer.answer_json("regime", {}, shown, pump))
    assert own["subject"]["device"] == "biased pumping cone"
    assert own["subject"]["film"] == "taut"
    assert own["subject"]["fields"]["spring_rate"] == pump.device.parameters()["spring_rate"]
    scales = pump.device.scales
    assert own["subject"]["initial"] == pytest.approx([250.0 * scales.length, 0.5 * scales.velocity])
    assert (own["parameters"], own["units"]) == (None, {"highest": "mm"})
    nothing = answer.answer_json("limits", {}, made({}, options="{}"), Subject(MODEL, None, None))
    assert [nothing[name] for name in ("outcome", "validity", "film_state")] == [None, None, None]
    assert nothing["subject"]["initial"] is None


@pytest.mark.parametrize(
    ("name", "values", "found"),
    [
        ("regime", [0, 3, -1], ["rest", "chaotic", "unknown"]),
        ("fate_regime", [1, -1], ["periodic", "none"]),
        ("threshold_from", [2], ["quasi-periodic"]),
        ("threshold_to", [6], ["transient chaos"]),
        ("motion_outcome", [0, 6], ["ok", "pulled_in"]),
        ("sign", [-1, 0, 1], ["negative", "uncertain", "positive"]),
        ("symmetric", [0, 1, -1], [False, True, "unknown"]),
        ("coexisting", [0, 1], [False, True]),
        ("cascade", [1, 0], [True, False]),
        ("period", [2.0, 0.0, NAN], [2, "none", "unknown"]),
        ("cycle", [1.0, 0.0], [1, "none"]),
        ("height", [0.5, 1.0], [0.5, 1.0]),
    ],
)
def test_codes_are_words_in_json(name, values, found):
    assert answer.plain(answer.variable_json(xr.DataArray(np.array(values), dims="k", name=name))) == found


@pytest.mark.parametrize(
    ("values", "attrs", "found"),
    [
        ([1.0, NAN, INF], {}, [1.0, "unknown", "infinite"]),
        ([NAN, INF], {"nan_means": "not applicable", "infinite_means": "never"}, ["not applicable", "never"]),
    ],
)
def test_what_is_not_finite_is_a_word_in_json_and_text(values, attrs, found):
    variable = xr.DataArray(values, dims="k", attrs=attrs)
    assert answer.plain(variable) == found
    assert [words.measured(one) for one in variable] == [v if isinstance(v, str) else "1" for v in found]


# --- examples in messages ---------------------------------------------------------------------------------------------


def test_examples_of_axes_have_the_units_of_their_names():
    device = gelcone.find_device("biased-pump")
    for name, unit in (("frequency", "Hz"), ("displacement", "mm"), ("velocity", "m/s"), ("voltage_amplitude", "V")):
        assert example(device, name) == f'--over "{name}=5 {unit}:20 {unit}:31"'
    assert example(None, "voltage") == "--over voltage=0:2:401"
    assert read_subject().over([example(None, "voltage").removeprefix("--over ")])["voltage"].size == 401


# --- whole sheets -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("draws", "last"), [(False, []), (True, ["95 % at 2 kV"])])
def test_the_columns_of_a_data_sheet_are_those_of_the_voltages_above_0(draws, last):
    from gelcone.analyses.datasheet import COLUMN_WIDTH, INTERVAL_WIDTH, NAME_WIDTH, datasheet_words

    along = "constant_voltage"
    own = {name: (along, [0.0, 1.0 + k, 100.0 + k]) for k, name in enumerate(words.SHEET_ROWS)}
    own |= {
        f"{name}_{end}": (along, [0.0, 0.0, v]) for name in words.SHEET_ROWS for end, v in (("low", 5.0), ("high", 7.0))
    }
    own |= {"outcome": 0, "rest_displacement": 3.0, "apparent_power": NAN, "pull_in_voltage": 9.0}
    own |= {f"{name}_{end}": 4.0 for name in ("rest_displacement", "pull_in_voltage") for end in ("low", "high")}
    attrs = {"drawn": "{}", "failed": 0, "draws": 8} if draws else {}
    shown = made(own, {along: (along, [0.0, 1000.0, 2000.0], "V")}, **attrs)
    shown[along].attrs["quantity"] = "voltage"
    lines = said(datasheet_words, shown)
    widths = [COLUMN_WIDTH] * 2 + [INTERVAL_WIDTH] * draws

    def cells(line):
        assert len(line) == NAME_WIDTH + sum(widths)
        ends = np.cumsum([NAME_WIDTH, *widths])
        return [line[:NAME_WIDTH].rstrip(), *(line[a:b].strip() for a, b in pairwise(ends))]

    assert cells(lines[0]) == ["constant voltage", "1 kV", "2 kV", *last]
    for k, (name, line) in enumerate(zip(words.SHEET_ROWS.values(), lines[1:], strict=False)):
        assert cells(line) == [name, f"{1 + k}", f"{100 + k}", *(["5 to 7"] if draws else [])]
    rest = lines[1 + len(words.SHEET_ROWS) :]
    assert [line.split() for line in rest[:2]] == [
        ["rest", "height", "3", *(["(4)"] if draws else [])],
        ["stiffness", "at", "rest", "0", *(["(0)"] if draws else [])],
    ]
    assert rest[2] == f"pull-in under constant voltage: 9{', 95 % within 4' if draws else ''}"


@pytest.mark.parametrize(
    ("branches_", "flow", "rule"),
    [
        (0, None, "gent with 0 Maxwell branches"),
        (1, None, "gent with 1 Maxwell branch, logarithmic flow"),
        (2, "log", "gent with 2 Maxwell branches, logarithmic flow"),
        (2, "linear", "gent with 2 Maxwell branches, linear flow"),
    ],
)
def test_a_fitted_material_names_its_law_its_numbers_and_their_intervals(branches_, flow, rule, monkeypatch):
    from types import SimpleNamespace

    gel = SimpleNamespace(law="gent", branches=branches_, flow=flow, relative_permittivity=4.5)
    monkeypatch.setattr(material_fit, "fitted_material", lambda result: gel)
    for name in ("_quality_lines", "_compared_lines", "_test_lines", "_notes"):
        monkeypatch.setattr(material_fit, name, lambda result, name=name: [name])
    own = {"value": [20e3, 50.0], "low": [18e3, NAN], "high": [24e3, NAN]}
    found = made(
        {n: ("parameter", v) for n, v in own.items()} | {"test_use": ("test", ["fit", "check", "fit"])},
        {"parameter": ("parameter", ["shear_modulus", "stretch_limit"])},
        title="material fit: a gel", temperature=NAN, permittivity_note="",
    )  # fmt: skip
    lines = [
        f"a gel: {rule}", "  fitted to 2 tests", "  shear_modulus 20 kPa (95 %: 18 kPa to 24 kPa)",
        "  stretch_limit 50",
        "  relative_permittivity 4.5", "_quality_lines", "_compared_lines", "_test_lines", "_notes",
    ]  # fmt: skip
    assert material_fit.fit_words(found).splitlines() == lines
    warm = material_fit.fit_words(found.assign_attrs(temperature=296.15, permittivity_note="stated")).splitlines()
    assert (warm[1], warm[4]) == ("  fitted to 2 tests at 23 degC", "  relative_permittivity 4.5 (stated)")


def test_the_heading_of_a_text():
    lines = answer.heading(Subject(MODEL.replace(voltage=0.75, damping_ratio=0.25)), ["voltage"])
    text = " ".join(line.strip() for line in lines)
    assert lines[0] == "cone model, dimensionless"
    assert "damping_ratio 0.25" in text
    assert "voltage 0.75" not in text
    assert "voltage 0.75" in " ".join(answer.heading(Subject(MODEL.replace(voltage=0.75))))
    assert max(map(len, lines)) <= answer.WIDTH
    device = gelcone.find_device("biased-pump").replace(film="taut")
    own = " ".join(answer.heading(Subject(device.to_model(), device), ["spring_rate"]))
    assert own.startswith("biased pumping cone")
    assert "spring rate" not in own.replace("_", " ")
    grid = made({}, {"voltage": ("voltage", [800.0, 850.0, 900.0], "V"), "material": ("material", ["a", "b"])})
    assert answer.grid_text(grid, ["voltage", "material"]) == "voltage 800 to 900 V, 3 values; material a, b, 2 values"
    two = made({"outcome": ("member", [0, 6, 6])})
    assert answer.ending_lines(two) == ["  1 of 3: ok", f"  2 of 3: {Outcome.PULLED_IN.meaning}"]
    assert answer.ending_lines(made({"outcome": 0})) == []


# --- whole texts of many cells ----------------------------------------------------------------------------------------


def after_heading(function, shown, swept):
    head = len(answer.heading(SUBJECT, swept))
    return function(shown, SUBJECT).splitlines()[head:]


def test_the_texts_of_a_sweep_and_of_a_store():
    over = ("voltage", "damping_ratio")
    shown = map_of().assign(status=(over, [[1, 1], [2, 1]]), validity_near_limit=(over, [[0.0, 0.5], [0.0, 0.0]]))
    shown = shown.assign(validity_breakdown=(over, np.zeros((2, 2))))
    grid = "voltage 800 to 900 V, 2 values; damping_ratio 0.25 to 0.5, 2 values"
    counts = "rest 1, periodic 1, chaotic 2"
    holds = "of 4 motions the model does not hold in: near the stretch limit in 1 (up to 50 % of the motion)"
    total = "5 of 6 cells computed; 12,345 steps in 2.5 s"
    assert after_heading(grids.sweep_words, shown, over) == [grid, counts, holds, total]
    stored = shown.assign_attrs(totals=json.dumps(TOTALS | {"inferred": 1}))
    assert after_heading(grids.show_words, stored, over) == [
        grid, "5 cells computed, 1 inferred, 0 missing of 6", counts, holds,
    ]  # fmt: skip
    failed = edited(shown, outcome=[[0, int(Outcome.OUTSIDE)], [0, 0]])
    assert after_heading(grids.sweep_words, failed, over)[1] == f"1 of 4 run(s) failed: {Outcome.OUTSIDE.meaning}"
    missing = edited(failed, status=[[1, 0], [0, 1]])  # a failed cell that is not there yet does not count
    assert after_heading(grids.sweep_words, missing, over)[1] == counts
    others = shown.drop_vars(["regime", "validity_near_limit", "validity_breakdown"])
    assert after_heading(grids.sweep_words, others, over) == [grid, total]


def test_the_text_of_a_sweep_over_draws():
    own = {"status": ("draw", [1, 1, 0]), "outcome": ("draw", [0, 0, 0]), "stroke": ("draw", [2.0, 2.0, 9.0], "mm"),
           "stroke_error": ("draw", [1.0, 1.0, 1.0])}  # fmt: skip
    shown = made(own, totals=json.dumps(TOTALS), membranes=json.dumps({"made": 2, "films": 3, "error": 0.5}))
    shown = shown.assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2]))
    shown["stroke"].attrs["long_name"] = "free stroke"
    lines = after_heading(grids.sweep_words, shown, ["prestretch"])
    assert lines[0].startswith("3 draws of prestretch")
    assert lines[1:] == [
        "5 of 6 cells computed; 12,345 steps in 2.5 s", "free stroke: 2 mm, 95 % within 2 mm to 2 mm",
        "pull-in of the membrane: 2 membranes made for 3 films, the voltages of the others interpolated to 50 % "
        "(root mean "
        "square)",
    ]  # fmt: skip


def test_the_text_of_a_diagram():
    both = ("branch", "voltage")
    own = {"outcome": (both, [[0, 0], [0, 6]]), "regime": (both, [[0, 1], [3, 5]]), "doubtful": (both, [[1, 0], [0,
    0]]),
           "validity_near_limit": (both, [[0.0, 0.25], [0.0, 0.0]]), "validity_breakdown": (both, np.zeros((2,
           2)))}  # fmt: skip
    shown = made(own, {"branch": ("branch", ["up", "down"]), "voltage": ("voltage", [1.0, 2.0], "V")})
    shown = shown.merge(thresholds(1)).assign_attrs(parameter="voltage")
    assert after_heading(grids.bifurcation_words, shown, ["voltage"]) == [
        "voltage 1 to 2 V, 2 values",
        f"1 of 4 run(s) failed: {Outcome.PULLED_IN.meaning}",
        "  up: rest 1, periodic 1",
        "    of 2 motions the model does not hold in: near the stretch limit in 1 (up to 25 % of the motion)",
        "  down: chaotic 1, pulled in 1",
        f"    {HOLDS}",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
        "changes of regime:",
        "  up: periodic -> chaotic at voltage 1.25 to 1.5 V, by a cascade of period doublings",
    ]


def test_the_text_of_basins():
    over = ("displacement", "velocity")
    own = {
        "attractor": (over, [[0, 1], [0, -1]]),
        "outcome": (over, [[0, 0], [0, 2]]),
        "doubtful": (over, [[0, 0], [1, 0]]),
    }
    kinds = {"regime": [0, 1], "period": [0, 2], "share": [0.5, 0.25], "lyapunov": [-0.5, -0.5], "lowest": [1.0, -2.0],
             "highest": [1.0, 3.0]}  # fmt: skip
    own |= {f"attractor_{n}": ("attractor_number", v, "mm" if n.endswith("est") else "1") for n, v in kinds.items()}
    shown = made(
        own, {"displacement": ("displacement", [-5.0, 5.0], "mm"), "velocity": ("velocity", [0.0, 1.0], "m/s")}
    )
    lines = [
        "initial displacement -5 to 5 mm, 2 values; velocity 0 to 1 m/s, 2 values",
        f"1 of 4 run(s) failed: {Outcome.STRETCH_LIMIT.meaning}", "2 attractor(s):", "  0: rest: 50 %, at 1 mm",
        "  1: periodic, period 2: 25 %, from -2 to 3 mm", "  none: 25 % (failed or not settled)",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
    ]  # fmt: skip
    assert said(grids.basin_words, shown) == lines
    all_ = edited(shown, attractor=[[0, 1], [0, 1]], outcome=0, doubtful=0)
    assert said(grids.basin_words, all_) == [lines[0], *lines[2:5]]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("up", ["up"]),
        ("down, up", ["down", "up"]),
        ("none", []),
        ("up,up", None),
        ("sideways", None),
        ("up,none", None),
    ],
)
def test_sweeps_of_a_diagram_as_they_are_typed(text, found):
    if found is None:
        with pytest.raises(gelcone.InputError, match="must be up, down, up,down or none"):
            grids.read_sweeps(text)
    else:
        assert grids.read_sweeps(text) == found


@pytest.mark.parametrize(("low", "high", "word"), [("1.1", "0.9", "is reversed"), ("1", "1.0", "is empty")])
def test_ends_of_branches_and_curves_in_the_words_of_their_commands(low, high, word):
    said_ = f"voltage from {low} to {high}: {word}; give the lower end first"
    with pytest.raises(gelcone.InputError, match=said_):
        branches.continue_branch_arguments(SUBJECT, {"parameter": "voltage", "low": low, "high": high})
    over = (f"voltage={low}:{high}", "drive_frequency=0.1:0.2")
    with pytest.raises(gelcone.InputError, match=said_):
        branches.locus_arguments(SUBJECT, {"over": over})
    found = branches.locus_arguments(SUBJECT, {"over": ("voltage=0.9:1.1", over[1]), "points": 5})
    assert found == {"over": {"voltage": (0.9, 1.1), "drive_frequency": (0.1, 0.2)}, "points": 5}
    given = {"parameter": "voltage", "low": "0.9", "high": "1.1", "start": "settled", "points": 5}
    assert branches.continue_branch_arguments(SUBJECT, given) == {
        "parameter": "voltage", "low": 0.9, "high": 1.1, "start": "settled", "points": 5,
    }  # fmt: skip
