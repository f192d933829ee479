"""Envelopes in words: a made-up window, and edits of it for each other word."""

import json

import numpy as np
import pytest

import gelcone
from gelcone import words
from gelcone.analyses import envelope
from gelcone.analyses.request import Subject
from tests.analyses.said import INF, NAN, said
from tests.edited import edited, labelled, made


def window(**changes):
    driven, at = ("driven_limit", "drive_frequency"), "drive_frequency"
    own = {
        "outcome": 0, "static_limit_voltage": ("static_limit", [2500.0, 2000.0, INF], "V"),
        "limit_low": (driven, [[1250.0, 1500.0], [NAN, NAN]]), "limit_high": (driven, [[1300.0, 1500.0], [NAN, NAN]]),
        "recommended_constant": (None, 1600.0, "V"), "recommended_peak": (at, [1000.0, 1200.0], "V"),
        "window_stroke": (at, [3.0, 2.0], "mm"), "window_power": (at, [40.0, 50.0], "mW"),
        "window_apparent_power": (at, [60.0, 70.0], "mVA"), "window_regime": (at, [1, 1]), "first_limit": (at, [0, 0]),
        "stroke": ("constant_voltage", [0.0, 8.0], "mm"), "blocked_force": ("constant_voltage", [0.0, 0.5], "N"),
        "natural_frequency": ("constant_voltage", [12.0, 10.0], "Hz"),
        "static_displacement": ("constant_voltage", [1.0, 2.0]),
        "operating_peak_voltage": (None, 900.0, "V"), "operating_frequency": (None, 12.0, "Hz"),
        "kick_tried": (at, [NAN, NAN], "m/s"),
        "kick_low": (at, [0.25, 0.5], "m/s"), "kick_high": (at, [0.375, 0.625], "m/s"),
        "coexisting_motions": (at, [0, 0]),
        "motion_regime": ((at, "motion"), [[3], [3]]), "motion_outcome": ((at, "motion"), [[0], [0]]),
        "motion_period": ((at, "motion"), [[0], [0]]), "motion_stroke": ((at, "motion"), [[5.0], [5.0]], "mm"),
        **{f"motion_validity_{n}": ((at, "motion"), [[0.0], [0.0]]) for n in words.FAILINGS},
    }  # fmt: skip
    coords = {
        "drive_frequency": (at, [10.0, 14.0], "Hz"), "constant_voltage": ("constant_voltage", [0.0, 3200.0], "V"),
        "peak_voltage": ("peak_voltage", [500.0, 2400.0], "V"), "driven_limit": ("driven_limit", ["pull-in",
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
    "  dielectric breakdown  none to pull-in   unknown",
    "pull-in is that of the film as a membrane, its force known to 1.2%",
    "recommended constant voltage, 20% below its limits: 1600 V; stroke 4 mm, blocked force 0.25 N, natural "
    "frequency 11 Hz "
    "(12 at 0)",
    "recommended drive, 20% below its limits when it is switched on from rest:",
    "  frequency (Hz)    up to (V)   stroke (mm)   power (mW)    apparent (mVA)  first limit",
    "  10                1000        3             40            60              pull-in 1250 to 1300 V",
    "  14                1200        2             50            70              pull-in 1500 V",
    "its drive, 900 V at 12 Hz: inside the window, 1100 V there (interpolated between 10 and 14 Hz)",
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
         "  pull-in               none              1250 to 1300 V at 10 Hz"),
        ({"static_limit_voltage": [INF, 2000.0, INF]}, "  dielectric breakdown  above 3200 V      unknown"),
        ({"static_limit_voltage": [4000.0, 2000.0, INF]}, "  dielectric breakdown  above 3200 V      unknown"),
        ({"limit_low": [[1500.0, 1250.0], [NAN, NAN]], "limit_high": [[1500.0, 1300.0], [NAN, NAN]]},
         "  pull-in               2500 V            1250 to 1300 V at 14 Hz"),
        ({"limit_low": [[1250.0, 1500.0], [1700.0, 1800.0]], "limit_high": [[1300.0, 1500.0], [1700.0, 1900.0]]},
         "  dielectric breakdown  none to pull-in   1700 V at 10 Hz"),
        ({"limit_low": [[1250.0, 1500.0], [INF, INF]]}, "  dielectric breakdown  none to pull-in   none to pull-in"),
        ({"limit_low": INF, "static_limit_voltage": [2300.0, 2000.0, INF]},
         "  dielectric breakdown  none to pull-in   none to pull-in"),
        ({"limit_low": INF}, "  dielectric breakdown  none to pull-in   above 2400 V"),
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
        ({"operating_peak_voltage": 1150.0},
        "its drive, 1150 V at 12 Hz: above the window, 1100 V there (interpolated between 10 and 14 Hz), "
        "and below a limit"),
        ({"operating_peak_voltage": 1400.0},
        "its drive, 1400 V at 12 Hz: above the window, 1100 V there (interpolated between 10 and 14 Hz), "
        "and beyond a limit"),
        ({"operating_frequency": 9.0}, "its drive, 900 V at 9 Hz: outside the frequencies examined"),
        ({"operating_frequency": 15.0}, "its drive, 900 V at 15 Hz: outside the frequencies examined"),
        ({"operating_peak_voltage": 2500.0, "recommended_peak": 1920.0},
         "its drive, 2500 V at 12 Hz: above the voltages examined, up to 2400 V, at which no limit was met"),
        ({"kick_tried": [0.75, 0.5]},
         "no other motion was found within the window: no kick, a sudden change of the disc's velocity, up to 0.75 m/s "
         "leads away"),
    ],
)  # fmt: skip
def test_another_envelope(changes, text):
    assert text not in ENVELOPE
    assert text in said(envelope.envelope_words, window(**changes))


def in_proportion(**changes):
    """The window of films in opposite phase, with the voltage of the second film at the recommended peak."""
    return window(**changes).assign(recommended_second_voltage=((), 1200.0, {"units": "V"}))


def test_of_films_in_opposite_phase_the_drive_is_held_at_its_peak():
    """No constant voltage is named, which would keep the bias; the voltage of either film is given."""
    lines = said(envelope.envelope_words, in_proportion(static_limit_voltage=[2500.0, 1100.0, INF]))
    assert lines[0] == "limit                   held at its peak  driven, lowest peak voltage"
    assert "held at its peak: the drive raised slowly as a whole, bias and amplitude in proportion" in lines
    recommended = "recommended peak at which the drive is held, 20% below its limits: 1600 V on the first film and"
    then = "1200 V on the second, bias and amplitude in proportion; stroke 4 mm, blocked force 0.25 N"
    assert f"{recommended} {then}, natural frequency 11 Hz (12 at 0)" in lines
    row = "  10                1000        3             40            60              "
    assert f"{row}hoop slack of the drive held at its peak 1100 V" in lines
    slack = said(envelope.envelope_words, in_proportion(recommended_constant=0.0))
    assert "no peak at which the drive is held is recommended: the film is slack from 0 on; pre-stretch it" in slack
    assert not any("constant" in line for line in (*lines, *slack))


@pytest.mark.parametrize(
    ("late", "text"),
    [
        (2300.0, "the film creeps: held at its peak the drive pulls the cone itself in above 2700 V at once, above "
         "2300 V after a while; limits of the drive held at its peak are those in the long run"),
        (INF, "the film creeps: held at no peak the drive pulls the cone itself in, at once or in the long run"),
    ],
)  # fmt: skip
def test_thresholds_of_creep_in_proportion_are_said_to_be_of_the_drive(late, text):
    volts = {"units": "V"}
    creeps = in_proportion().assign(
        proportional_instantaneous_pull_in_voltage=((), 2700.0, volts),
        proportional_long_term_pull_in_voltage=((), late, volts),
    )
    lines = said(envelope.envelope_words, creeps)
    assert text in lines
    assert "pull-in is that of the film as a membrane of the relaxed gel, its force known to 1.2%" in lines
    assert not any("constant" in line for line in lines)


def test_a_drive_beyond_a_pitchfork_in_proportion_alone():
    names = ["pull-in", "pitchfork", "dielectric breakdown"]
    shown = in_proportion(static_limit_voltage=[2500.0, 700.0, INF], limit_low=INF, operating_frequency=14.0)
    shown = shown.assign_coords(static_limit=("static_limit", names))
    shown = edited(shown, recommended_peak=560.0)
    expected = (
        "above pitchfork of the drive held at its peak, 700 V; 64% below the first other limit, pull-in of the drive "
        "held at its peak 2500 V"
    )
    assert said(envelope.envelope_words, shown)[-1] == f"its drive, 900 V at 14 Hz: {expected}"


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
    shown = window(
        operating_peak_voltage=800.0,
        operating_frequency=14.0,
        recommended_peak=560.0,
        static_limit_voltage=[INF, NAN, INF],
    )
    shown = shown.assign_coords(driven_limit=["onset of rest", "pull-in"]).assign(limit_low=low)
    shown.attrs["options"] = json.dumps({"margin": margin})
    assert envelope._own_line(shown) == f"its drive, 800 V at 14 Hz: {text}"


@pytest.mark.parametrize(
    ("start", "text"),
    [("rest", " when it is switched on from rest"), ("settled", " when its voltage rises slowly"),
     ("both", " when it is switched on from rest or its voltage rises slowly"), (None, "")],
)  # fmt: skip
def test_what_the_limits_of_a_window_hold_for(start, text):
    options = {"margin": 0.25} | ({} if start is None else {"limits_from": start})
    shown = window().assign_attrs(options=json.dumps(options))
    assert said(envelope.envelope_words, shown)[6] == f"recommended drive, 25% below its limits{text}:"


@pytest.mark.parametrize(("chaos", "late"), [([1100.0, np.inf], True), ([1300.0, 1600.0], False)])
def test_a_pull_in_out_of_chaos_is_that_of_one_run(chaos, late):
    shown = window().assign_coords(driven_limit=["pull-in", "chaos"])
    shown["limit_low"][1] = chaos
    line = "a driven pull-in above the limit of chaos is that of one run: others pull in lower or higher"
    assert (line in said(envelope.envelope_words, shown)) is late


def test_the_film_whose_pull_in_limits_an_envelope():
    cone = said(envelope.envelope_words, window().assign_attrs(pull_in_of="cone"))[4]
    assert (
        cone == "pull-in is that of the model's film; a membrane, which a wrinkling cone stands for, pulls in earlier"
    )
    volts = {"units": "V"}
    creeps = window().assign(
        instantaneous_pull_in_voltage=((), 2700.0, volts), long_term_pull_in_voltage=((), 2300.0, volts)
    )
    lines = said(envelope.envelope_words, creeps)
    assert lines[4:7] == [
        "pull-in is that of the film as a membrane of the relaxed gel, its force known to 1.2%",
        "the film creeps: at constant voltage the cone itself pulls in above 2700 V at once, above 2300 V after a "
        "while (gelcone creep says when)",
        "limits at constant voltage are those in the long run, with --duration those of a time",
    ]
    never = said(envelope.envelope_words, edited(creeps, long_term_pull_in_voltage=INF))
    assert never[5] == "the film creeps: no constant voltage pulls the cone itself in, at once or in the long run"
    membrane = Subject(gelcone.ConeModel(film="membrane"))
    lines = envelope.envelope_words(creeps, membrane).splitlines()
    assert any("at constant voltage the film pulls in above" in line for line in lines)
    assert never[6].startswith("recommended constant voltage")


@pytest.mark.parametrize(
    ("regime", "outcome", "period", "goal"),
    [(3, 0, 0, "chaotic"), (1, 0, 2, "periodic, period 2"), (5, 6, 0, "pull-in"),
     (5, 2, 0, "left the domain, stretch limit")],
)  # fmt: skip
def test_where_a_kick_leads(regime, outcome, period, goal):
    shown = window(kick_tried=[NAN, 0.75], coexisting_motions=[0, 1], motion_regime=regime, motion_outcome=outcome,
                   motion_period=period, motion_validity_near_limit=0.25)  # fmt: skip
    *_, kick, span, to = said(envelope.envelope_words, shown)
    assert kick == (
        "where a kick, a sudden change of the disc's velocity, can lead from the recommended drive (tried up to 0.75 "
        "m/s):"
    )
    assert span == "  14 Hz: the smallest that leads away lies between 0.5 and 0.625 m/s"
    fails = "" if goal == "pull-in" else "; the model does not hold: near the stretch limit 25 %"
    assert to == f"    to: {goal}, stroke 5 mm{fails}"


def test_a_film_that_is_held_and_gets_warm():
    """Up to what it bears, which is above what it bears in the long run; the stroke is from rest without voltage, after
    the time, and each row has its own heat."""
    volts = {"units": "V"}
    shown = window(static_limit_voltage=[2500.0, 1100.0, INF]).assign(
        instantaneous_pull_in_voltage=((), 2700.0, volts), long_term_pull_in_voltage=((), 2300.0, volts),
        holding_voltage=((), 2600.0, volts),
        holding_time=((), 240_000.0, {"units": "ms"}), rest_displacement=((), 0.5, {"units": "mm"}),
        held_displacement=("held_voltage", [1.0, 5.0], {"units": "mm"}),
        static_heating=("constant_voltage", [0.0, 4.0], {"units": "K/s"}),
        window_heating=("drive_frequency", [0.125, 0.375], {"units": "K/s"}),
    ).assign_coords(held_voltage=("held_voltage", [0.0, 2000.0], volts))  # fmt: skip
    lines = said(envelope.envelope_words, shown)
    assert lines[0] == "limit                   held for 4 min    driven, lowest peak voltage"
    assert lines[6] == "up to 2600 V is held for 4 min: limits at constant voltage are those of that time"
    assert lines[7] == (
        "recommended constant voltage, held for 4 min, 20% below its limits: 1600 V; stroke 3.7 mm after that time, "
        "blocked force 0.25 N, natural frequency 11 Hz (12 at 0), warms by 2 K/s"
    )
    assert lines[9].split()[-5:] == ["warms", "by", "(K/s)", "first", "limit"]
    assert [line.split()[5] for line in lines[10:12]] == ["0.125", "0.375"]
    assert lines[10].endswith("hoop slack at 1100 V held for 4 min")


def test_neighbouring_frequencies_with_the_same_other_motions_are_one_line():
    """The smallest kick of them, where it is, and the range of strokes; what does not hold is the most of them."""
    shown = window(
        kick_tried=[0.75, 0.5], coexisting_motions=[1, 1], motion_regime=3,
        motion_validity_near_limit=[[0.125], [0.25]],
        motion_validity_breakdown=[[0.5], [0.0]], motion_stroke=[[5.0], [6.0]], kick_low=[0.5, 0.25],
        kick_high=[0.625, 0.375],
    )  # fmt: skip
    *_, kick, span, to = said(envelope.envelope_words, shown)
    assert kick.endswith("(tried up to 0.75 m/s):")
    assert span == "  10 to 14 Hz: the smallest that leads away lies between 0.25 and 0.375 m/s, at 14 Hz"
    assert to.startswith("    to: chaotic, stroke 5 to 6 mm; the model does not hold: ")
    assert "near the stretch limit up to 25 %" in to
    assert "breakdown up to 50 %" in to
    none = said(envelope.envelope_words, edited(shown, kick_low=INF, kick_high=INF))
    assert none[-2] == "  10 to 14 Hz: no kick leads away, but another motion exists"


@pytest.mark.parametrize(
    ("frequency", "more"), [(10.0 * (1.0 + 1e-13), ""), (14.0, ""), (12.0, " (interpolated between 10 and 14 Hz)")]
)
def test_a_window_between_the_frequencies_examined_is_said_to_be_interpolated(frequency, more):
    """A drive frequency that differs by the rounding of its units is one of those examined."""
    lines = said(envelope.envelope_words, window(operating_frequency=frequency, operating_peak_voltage=900.0))
    highest = {10.0: "1000", 14.0: "1200"}.get(round(frequency, 6), "1100")
    assert lines[-1] == f"its drive, 900 V at {frequency:.4g} Hz: inside the window, {highest} V there{more}"
