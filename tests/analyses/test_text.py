"""What commands print as text: its numbers are those of the results, its words those of their kinds."""

import re

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.analyses import answer, branches, envelope, frequency, grids, motions, stability, statics, tables
from gelcone.analyses import trajectories as runs
from gelcone.analyses.request import Subject
from gelcone.codes import Outcome, Regime
from gelcone.presets import find_preset
from gelcone.words import (
    FAILINGS,
    MOST_LINES,
    UNKNOWN_STRENGTH,
    evidence_in_words,
    lasting_in_words,
    members_of,
    shortened,
    strength_in_words,
    validity_in_words,
)

BASE = find_preset("base").model
CHAOS = BASE.replace(voltage=1.04)
NUMBER = r"([-+]?\d[\d.e+-]*)"


def numbers(line):
    return [float(text.rstrip(".")) for text in re.findall(NUMBER, line)]


def text_of(words, result, model):
    return words(result, Subject(model)).splitlines()


def line_with(lines, part):
    (found,) = [line for line in lines if part in line]
    return found


# --- numbers of runs --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("voltages", [1.04, [0.5, 1.04]])
def test_the_exponent_per_forcing_period_and_its_error_are_those_per_time_times_the_period(voltages):
    model = BASE.replace(voltage=voltages)
    lines = text_of(motions.lyapunov_words, gelcone.lyapunov(model, budget=600.0, window=50.0), model)
    line = next(line for line in reversed(lines) if "per forcing period" in line)
    *_, value, error, by_period, its_error = numbers(line)
    period = np.pi / 0.1
    assert by_period / value == pytest.approx(period, rel=0.02)
    assert its_error / error == pytest.approx(period, rel=0.05)


def test_the_lines_of_the_exponents_of_one_run():
    found = gelcone.lyapunov(CHAOS, budget=600.0, window=50.0)
    lines = text_of(motions.lyapunov_words, found, CHAOS)
    second, error, off, _ = numbers(line_with(lines, "second exponent"))  # the last: 0 without rounding
    assert second == pytest.approx(float(found["lyapunov"][1]), abs=1e-3)
    assert error == pytest.approx(float(found["standard_error"][1]), rel=0.1)
    assert off == pytest.approx(abs(float(found["sum_residual"])), rel=0.5)
    assert numbers(line_with(lines, "averaged over"))[0] == pytest.approx(float(found["averaged_time"]), rel=1e-3)
    window, first, other = numbers(line_with(lines, "over the first"))
    assert window == pytest.approx(float(found["finite_time"].max()), rel=1e-3)
    assert [first, other] == pytest.approx(found["finite"].values, rel=1e-3)
    cycle = gelcone.lyapunov(BASE.replace(voltage=0.97), budget=600.0, window=50.0)
    lines = text_of(motions.lyapunov_words, cycle, BASE)
    assert "a cycle of 1 forcing period" in line_with(lines, "multipliers of what it settles on")


def test_the_regime_says_extent_evidence_and_times():
    model = BASE.replace(voltage=1.02)
    found = gelcone.regime(model, budget=600.0)
    lines = text_of(motions.regime_words, found, model)
    assert lines[lines.index("periodic, period 2") + 1].startswith("largest exponent -0.01")
    extent = numbers(line_with(lines, "displacement"))
    assert extent == pytest.approx([float(found["lowest"]), float(found["highest"])], rel=1e-3)
    assert numbers(line_with(lines, "examined after"))[0] == pytest.approx(float(found["settled_time"]), rel=1e-3)
    assert numbers(line_with(lines, "of its size"))[0] == pytest.approx(float(found["cycle_distance"]), rel=0.5)
    shares = numbers(line_with(lines, "the model does not hold"))
    own = [100.0 * float(found[f"validity_{name}"]) for name in ("hoop_slack", "meridional_slack")]
    assert shares == pytest.approx(own, rel=0.01)


def test_sections_and_extrema_say_their_ranges():
    found = gelcone.section(CHAOS, repeats=9, discard=20)
    lines = text_of(runs.section_words, found, CHAOS)
    for name in ("displacement", "velocity"):
        ends = [float(found[name].min()), float(found[name].max())]
        assert numbers(line_with(lines, f"{name} ")) == pytest.approx(ends, rel=1e-4)
    turns = gelcone.extrema(CHAOS, repeats=9, discard=20)
    lines = text_of(runs.extrema_words, turns, CHAOS)
    for kind, word in ((1, "maxima"), (-1, "minima")):
        own = turns["displacement"].values[turns["maximum"].values == kind]
        assert numbers(line_with(lines, word)) == pytest.approx([own.size, own.min(), own.max()], rel=1e-4)


def test_a_spectrum_lists_its_strongest_lines():
    found = gelcone.spectrum(CHAOS)
    lines = text_of(runs.spectrum_words, found, CHAOS)
    shown = numbers(line_with(lines, "rms"))
    for name, value, error in zip(("rms", "mean_displacement"), shown[::2], shown[1::2], strict=True):
        assert error == pytest.approx(float(found[f"{name}_standard_error"]), rel=0.05)
        assert value == pytest.approx(float(found[name]), abs=0.1 * error)  # no digit that the error does not bear
    share, flatness = numbers(line_with(lines, "variance in lines"))
    assert share == pytest.approx(100.0 * float(found["power_in_lines"]), rel=1e-3)
    assert flatness == pytest.approx(float(found["flatness"]), rel=0.01)
    head = next(k for k, line in enumerate(lines) if "frequency/drive" in line)
    names = ("line_ratio", "line_frequency", "line_amplitude", "line_prominence")
    for k in range(runs.PRINTED_LINES):
        own = [float(found[name][k]) for name in names]
        assert numbers(lines[head + 1 + k]) == pytest.approx(own, rel=1e-3, abs=0.06)
    assert lines[-2:] == [
        f"  and {found.sizes['line'] - runs.PRINTED_LINES} more",
        "the motion does not repeat: numbers are of one run, those of another differ",
    ]


def test_a_time_response_says_its_ranges_and_where_a_film_pulls_in():
    model = BASE.replace(film="wrinkling", voltage=1.3)
    found = gelcone.simulate(model, periods=3)
    lines = text_of(runs.simulate_words, found, model)
    time, place, voltage = numbers(line_with(lines, "film pulls in at"))
    own = [float(found[f"pull_in_{name}"]) for name in ("time", "displacement", "film_voltage")]
    assert [time, place, voltage] == pytest.approx(own, rel=1e-4)
    kind = ("", "minimum", "localisation")[int(found["pull_in_kind"])]
    assert line_with(lines, "film pulls in at").endswith(f"({kind})")
    quiet = gelcone.simulate(BASE, periods=3)
    lines = text_of(runs.simulate_words, quiet, BASE)
    half, end = (float(quiet["time"][k]) for k in (quiet["time"].size // 2, -1))
    closer = gelcone.simulate(BASE, times=np.union1d(np.linspace(0.0, half, 4000), np.linspace(half, end, 4000)))
    late = closer["displacement"].sel(time=slice(half, None))
    expected = [float(end) for x in (closer["displacement"], late) for end in (x.min(), x.max())]
    assert numbers(line_with(lines, "in the second half")) == pytest.approx(expected, rel=2e-4)
    slack = line_with(lines, "share of the motion in which the model does not hold").partition("hoop slack ")[2]
    assert numbers(slack)[0] == pytest.approx(100.0 * float(quiet["validity_hoop_slack"]), rel=5e-3)
    assert not [line for line in lines if line.strip().startswith("error")]


def test_the_settled_motion_of_a_device_in_words():
    device = gelcone.find_device("biased-pump").replace(film="wrinkling", voltage_amplitude="20 V")
    subject, found = Subject(device.to_model(), device), gelcone.settled(device)
    lines = tables.table_words(found, subject).splitlines()
    assert "the disc is at rest: no" in lines
    assert found.power.units == "mW"
    assert f"mean power that the source gives: {1e6 * float(found.power):.5g} nW" in lines
    assert line_with(lines, "share of the").startswith("film (share of the time): taut")  # of all its states
    still = gelcone.settled(device.replace(voltage_amplitude=0.0))
    assert "the disc is at rest: yes" in tables.table_words(still, subject).splitlines()


def with_their_headings(lines):
    """Lines with what is common to several numbers, which stands in a line above them."""
    heading, whole = "", []
    for line in lines:
        if not line.startswith("  "):
            heading = line if line.endswith(":") else ""
        whole.append(f"{heading} {line.strip()}" if heading and line != heading else line)
    return whole


def test_numbers_with_common_words_stand_below_them():
    rows = {"own": "1 V", "limit of a ramp: slack": "2 V", "limit of a drive: slack": "3 V"}
    rows |= {"limit of a ramp: chaos": "4 V", "limit of a ramp: rest": "none", "limit of a drive: rest": "none"}
    assert tables._single_lines(rows, {"none"}) == [
        "own: 1 V", "limit of a ramp:", "  slack: 2 V", "  chaos: 4 V", "limit of a drive: slack: 3 V",
        "none: limit of a ramp: rest; limit of a drive: rest",
    ]  # fmt: skip


def test_a_table_has_a_line_for_every_number_and_says_what_is_not_reached():
    model = find_preset("spring").model.replace(voltage=0.1)
    found = gelcone.operating_limits(model)
    lines = text_of(tables.table_words, found, model)
    whole = "\n".join(lines).replace("\n  ", " ")
    lines = with_their_headings(lines)
    for name, variable in found.data_vars.items():
        if name == "outcome" or str(name).startswith("validity"):
            continue
        value, named = float(variable), str(variable.attrs["long_name"])
        if np.isfinite(value):
            (line,) = [line for line in lines if line.startswith(f"{named}: ")]
            assert numbers(line.rpartition(": ")[2]) == pytest.approx([value], rel=1e-4)
        else:
            why = "unknown" if name.endswith("breakdown_voltage") else "not applicable"
            why = "unknown without radius_ratio" if name == "membrane_pull_in_voltage" else why
            lies = "above the voltages examined" if name.startswith("driven") else "none before pull-in"
            lies = "none" if name == "pull_in_voltage" else lies
            why = why if np.isnan(value) else lies
            begin, _, end = named.rpartition(": ")
            together = rf"(?m)^{why}: (?:.*; )?{begin}: (?:[^;:]*, )?{end}(?:[,;]|$)"
            assert f"{named}: {why}" in lines or re.search(together, whole)


# --- statics and stability --------------------------------------------------------------------------------------------


def test_a_ramp_with_a_jump_says_where_to():
    """On real statics: the disc of a buckled film leaves the middle gradually, that of a soft bias jumps."""
    model = gelcone.ConeModel(spring_stiffness=1.5)
    found = gelcone.static(model, [0.0, 1.5])
    lines = text_of(statics.static_words, found, model)
    assert "stable at every voltage" in line_with(lines, "slow voltage ramp")
    assert numbers(line_with(lines, "pitchfork at")) == pytest.approx([np.sqrt(1.5), 0.0], rel=1e-3)
    at = line_with(lines, "  1.5: equilibria at")
    there = [float(x) for x in found["equilibrium_displacement"][1]]
    assert [float(t) for t in re.findall(NUMBER + r" \((?:un)?stable", at)] == pytest.approx(there, rel=1e-3)
    assert re.findall(r"\((\w+)", at) == ["stable", "unstable", "stable"]
    told = [float(found[name][1]) for name in ("stroke", "blocked_force", "cycle_work")]
    assert numbers(at.rpartition("; ")[2]) == pytest.approx(told, rel=5e-4, abs=1e-4)  # four digits are printed


def test_tongues_say_their_lowest_onset_and_the_share_that_is_unstable():
    found = gelcone.tongues(BASE, [0.1, 0.3, 1.0, 2.0], np.linspace(0.1, 1.9, 7))
    lines = text_of(stability.tongues_words, found, BASE)
    onset, *_, searched = numbers(line_with(lines, "at its own frequency"))
    assert onset == pytest.approx(float(found["operating_onset_voltage"]), rel=1e-5)
    assert searched == pytest.approx(float(found["operating_searched"][1]), rel=1e-3)
    k = int(np.nanargmin(found["onset_voltage"].values))
    lowest, at = numbers(line_with(lines, "lowest onset"))
    assert [lowest, at] == pytest.approx([float(found[n][k]) for n in ("onset_voltage", "drive_frequency")], rel=1e-3)
    share = 100.0 * float((found["margin"] > 0.0).mean())
    assert numbers(line_with(lines, "of the grid"))[0] == pytest.approx(share, rel=0.01)


# --- envelopes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("peak", "at", "words"),
    [
        (0.79, 2.0, "inside the window"),
        (0.98, 2.0, "and below a limit"),
        (1.02, 2.0, "and beyond a limit"),
        (0.79, 9.0, "outside the frequencies examined"),
    ],
)
def test_where_the_own_drive_lies(peak, at, words):
    """The window of 0.8 with a margin of 0.2 lies below a limit of 1."""
    window = {"drive_frequency": ("drive_frequency", [1.0, 3.0]), "recommended_peak": ("drive_frequency", [0.7, 0.9])}
    own = {"operating_peak_voltage": peak, "operating_frequency": at, "peak_voltage": ("peak_voltage", [0.5, 1.5])}
    shown = xr.Dataset(window | own, attrs={"options": '{"margin": 0.2}'})
    line = envelope._own_line(shown)
    assert words in line
    assert numbers(line)[:2] == [peak, at]


@pytest.mark.parametrize(
    ("peak", "words"),
    [(0.55, "inside the window, 0.56 there"),
     (0.825, "above onset of rest, 0.7; 25% below the first other limit, pull-in 1.1"),
     (0.69, "above the window, 0.56 there, and below a limit"), (1.2, "beyond a limit")],
)  # fmt: skip
def test_a_device_that_swings_by_the_loss_of_flat_rest_may_be_below_all_other_limits(peak, words):
    """Flat rest is lost at 0.7, the film pulls in at 1.1 under the drive and at 1.3 at constant voltage."""
    limits = [[np.nan, np.nan], [1.5, 1.1], [1.0, 0.7]]
    shown = xr.Dataset(
        {
            "limit_low": (("driven_limit", "drive_frequency"), limits),
            "static_limit_voltage": ("static_limit", [np.inf, 1.3]),
            "recommended_peak": ("drive_frequency", [0.8, 0.56]),
            "operating_peak_voltage": peak,
            "operating_frequency": 2.0,
        },
        {
            "drive_frequency": [1.0, 2.0],
            "peak_voltage": [0.5, 1.5],
            "driven_limit": ["dielectric breakdown", "pull-in", "onset of rest"],
            "static_limit": ["pitchfork", "pull-in"],
        },
        {"options": '{"margin": 0.2}'},
    )
    assert words in envelope._own_line(shown)
    away = shown.assign(operating_frequency=1.5)  # between the frequencies examined, where others may be nearer
    assert "other limit" not in envelope._own_line(away)


def test_the_tables_of_an_envelope_are_its_numbers():
    model = find_preset("spring").model
    found = gelcone.envelope(model, frequencies=[0.3, 0.6], peaks=[0.1, 0.5, 0.9])
    lines = text_of(envelope.envelope_words, found, model)
    static = found["static_limit_voltage"].sel(static_limit="hoop slack")
    k = int(np.argmin(found["limit_low"].sel(driven_limit="hoop slack").values))
    driven = [float(found[f"limit_{end}"].sel(driven_limit="hoop slack")[k]) for end in ("low", "high")]
    row = numbers(next(line for line in lines if line.startswith("  hoop slack")))
    assert row == pytest.approx([float(static), *driven, float(found["drive_frequency"][k])], rel=1e-3)
    heading = next(k for k, line in enumerate(lines) if line.startswith("recommended drive"))
    names = ("drive_frequency", "recommended_peak", "window_stroke", "window_power", "window_apparent_power")
    for k in range(2):
        row = lines[heading + 2 + k]
        first = [float(found[f"limit_{end}"].sel(driven_limit="hoop slack")[k]) for end in ("low", "high")]
        assert numbers(row) == pytest.approx([*(float(found[name][k]) for name in names), *first], rel=1e-3)
    constant = line_with(lines, "recommended constant voltage")
    assert numbers(constant)[1] == pytest.approx(float(found["recommended_constant"]), rel=1e-3)
    level = float(found["recommended_constant"])
    volts = found["constant_voltage"]
    at = [np.interp(level, volts, found[name]) for name in ("stroke", "blocked_force", "natural_frequency")]
    assert numbers(constant)[2:5] == pytest.approx(at, rel=1e-3)


def test_a_held_voltage_and_a_warm_film_are_said():
    """Of a film with branches that leaks: the time, the voltage that is held for it, and a column of heating."""
    film, beam = gelcone.TautCone(branches=1, prestretch_mode="equibiaxial"), gelcone.BuckledBeam()
    numbers_of_beam = {"beam_stiffness": -0.6, "beam_cubic": 2.0, "beam_height": 1.0, "damping_ratio": 0.3}
    model = gelcone.ConeModel(
        film=film, bias=beam, prestretch=1.2, viscous_modulus_1=1.0, relaxation_time_1=20.0, leakage_time=30.0,
        voltage=0.2, voltage_bias=0.5, **numbers_of_beam,
    )  # fmt: skip
    found = gelcone.envelope(model, frequencies=[0.5, 0.6], peaks=[0.6, 1.4], duration=60.0)
    lines = text_of(envelope.envelope_words, found, model)
    assert "held for 60" in line_with(lines, "driven, lowest peak voltage")
    held = f"{float(found['holding_voltage']):.4g}"
    assert line_with(lines, "limits at constant voltage are those of that time").startswith(
        f"up to {held} is held for 60"
    )
    constant = line_with(lines, "recommended constant voltage, held for 60")
    level = float(found["recommended_constant"])
    end = np.interp(level, found["held_voltage"], found["held_displacement"]) - float(found["rest_displacement"])
    assert f"stroke {float(f'{end:.4g}'):.10g} after that time" in constant
    warm = np.interp(level, found["constant_voltage"], found["static_heating"])
    assert constant.endswith(f"warms by {warm:.3g}")
    row = lines[next(k for k, line in enumerate(lines) if line.startswith("recommended drive")) + 2]
    assert numbers(row)[5] == pytest.approx(float(found["window_heating"][0]), rel=1e-2)


# --- grids ------------------------------------------------------------------------------------------------------------


def test_a_map_names_its_extreme_exponents_and_counts_its_cells():
    over = {"voltage": [0.9, 0.97, 1.04], "damping_ratio": [0.01, 0.02]}
    found = gelcone.map(BASE, over, budget=600.0)
    lines = text_of(grids.map_words, found, BASE)
    exponent = found["lyapunov"].isel(exponent=0)
    for word, at in (("highest", exponent.argmax(...)), ("lowest", exponent.argmin(...))):
        value, _, *where = numbers(line_with(lines, f"{word} exponent"))
        assert value == pytest.approx(float(exponent[at]), abs=1e-3)
        assert where == pytest.approx([float(found[d].isel({d: at[d]})) for d in over])
    counted = line_with(lines, "% chaotic")
    for kind in Regime:
        count = int((found["regime"] == kind).sum())
        assert (f"{kind.label} {count}" in counted) == (count > 0)
    assert numbers(counted.rpartition("(")[2])[0] == pytest.approx(
        100.0 * float((found["regime"] == 3).mean()), rel=0.01
    )
    assert line_with(lines, "cells computed").startswith("6 of 6 cells computed; ")


def test_a_sweep_says_how_probable_chaos_is_at_each_point():
    draws = {"voltage": np.array([0.9, 1.04, 1.05])}
    plan = gelcone.Plan(BASE, {"damping_ratio": [0.01, 0.5]}, draws=draws, options={"budget": 600.0})
    found = gelcone.sweep(plan)
    chance = gelcone.probability(found)
    assert float(chance["probability"][0]) > float(chance["probability"][1])
    lines = [line for line in text_of(grids.sweep_words, found, BASE) if "probability of chaos" in line]
    for k, line in enumerate(lines):
        own = [float(chance[name][k]) for name in ("probability", "low", "high", "decided")]
        assert line.startswith(f"  damping_ratio {found['damping_ratio'][k].item():g}: ")
        part = line.partition("probability of chaos")[2].partition(";")[0]
        assert numbers(part) == pytest.approx(own, rel=0.01, abs=1e-9)
    assert len(lines) == 2


def test_thresholds_and_counts_of_each_branch_of_a_diagram():
    found = gelcone.bifurcation(BASE, "voltage", [0.9, 0.97, 1.04], sweeps=["up"], budget=600.0, bisections=2)
    lines = text_of(grids.bifurcation_words, found, BASE)
    assert line_with(lines, "  up: rest 1,").startswith("  up: rest 1, periodic 1, chaotic 1")
    rows = gelcone.thresholds_of(found)
    told = lines[lines.index("changes of regime:") + 1 :][: len(rows)]
    for row, line in zip(rows, told, strict=True):
        assert line.startswith(f"  {row['branch']}: {row['from']} -> {row['to']} at voltage ")
        assert numbers(line.rpartition(" at voltage ")[2])[:2] == pytest.approx([row["low"], row["high"]], rel=1e-5)
        assert ("cascade" in line) == row["cascade"]


def test_the_answer_of_a_frequency_response_doubles_amplitudes_and_names_its_jumps():
    model = find_preset("spring").model.replace(voltage=0.4)
    found = gelcone.frequency(model, np.linspace(0.3, 0.9, 7))
    lines = text_of(frequency.frequency_words, found, model)
    for branch in ("up", "down"):
        own = found.sel(branch=branch)
        stroke, error, at, low, high = numbers(line_with(lines, f"swept {branch:5s} largest"))[:5]
        assert stroke == pytest.approx(2.0 * float(own["peak_amplitude"]), rel=1e-3)
        assert error == pytest.approx(2.0 * float(own["peak_amplitude_error"]), rel=0.3)
        expected = [float(own[f"peak_{end}"]) for end in ("frequency", "low", "high")]
        assert [at, low, high] == pytest.approx(expected, rel=1e-4)
    expected = [float(found[f"linear_peak_{name}"]) for name in ("stroke", "frequency")]
    assert numbers(line_with(lines, "linear theory")) == pytest.approx(expected, rel=1e-3)
    jump = xr.Dataset({"jump_low": 1.0, "jump_high": 1.1, "jump_from": 0.2, "jump_to": 0.7}).expand_dims("jump")
    jump["jump_branch"] = ("jump", ["up"])
    (line,) = frequency._jump_lines(jump, "", "")[1:]
    assert line == "  swept up    at 1 to 1.1: stroke 0.2 -> 0.7"


def test_branches_say_where_they_run_what_is_stable_and_what_is_born():
    found = gelcone.continue_branch(BASE, "voltage", 0.9, 0.99, checks=2)
    lines = branches.branch_lines(found)
    for k in range(found.sizes["branch"]):
        own = found.isel(branch=k)
        values = own["value"].values[np.isfinite(own["value"].values)]
        line = line_with(lines, f"branch {k}: ")
        kind = "rest" if int(own["resting"]) else f"period {int(own['period'])}"
        assert line.startswith(f"branch {k}: {kind}{', symmetric' * int(own['symmetric'])}, voltage ")
        low, high, points, share = numbers(line.partition(", voltage ")[2])[:4]
        assert [low, high] == pytest.approx([values.min(), values.max()], rel=1e-5)
        assert points == values.size
        assert share == pytest.approx(100.0 * float((own["stable"] == 1).sum()) / values.size, rel=0.01)
    first = found.isel(event=int(np.flatnonzero(found["event_born_branch"].values >= 0)[0]))
    line = line_with(lines, f"branch {int(first['event_born_branch'])} is born")
    assert numbers(line)[:2] == pytest.approx([float(first["event_value"]), float(first["event_error"])], rel=0.5)
    assert float(numbers(line)[0]) == pytest.approx(float(first["event_value"]), rel=1e-9)
    assert ("supercritical" in line) == (int(first["event_supercritical"]) == 1)


def coded(dims, values, names):
    """Codes with their words, as results hold them."""
    return dims, values, {"flag_values": np.arange(len(names)), "flag_meanings": " ".join(names)}


def test_a_locus_says_for_each_curve_where_it_runs_and_what_lies_on_it():
    """Every number of the made-up result is another."""
    ends = ["limit", "wall", "closed"]
    shown = xr.Dataset(
        {
            "voltage": (("curve", "point"), [[0.9, 0.95, np.nan], [1.2, 1.1, 1.05]], {"units": "kV"}),
            "drive_frequency": (("curve", "point"), [[5.0, 7.0, np.nan], [9.0, 8.0, 11.0]], {"units": "Hz"}),
            "period": ("curve", [1, 2]),
            "symmetric": ("curve", [0, 1]),
            "ended": coded(("curve", "end"), [[0, 1], [2, 2]], ends),
            "event_curve": ("event", [1, 0]),
            "event_kind": coded("event", [1, 0], ["cusp", "strong_resonance"]),
            "event_first": ("event", [1.15, 0.93], {"units": "kV"}),
            "event_first_error": ("event", [2e-6, 4e-6]),
            "event_second": ("event", [8.5, 6.5], {"units": "Hz"}),
            "event_second_error": ("event", [3e-7, 5e-7]),
        },
        attrs={"parameters": "voltage,drive_frequency", "event": "fold"},
    )
    *_, first, cusp, second, resonance = text_of(branches.locus_words, shown, BASE)
    assert numbers(first) == [0, 1, 0.9, 0.95, 5.0, 7.0, 2]
    assert numbers(second) == [1, 2, 1.05, 1.2, 8.0, 11.0, 3]
    assert first.startswith("curve 0: fold, period 1, voltage ")
    assert first.endswith("kV, drive_frequency 5 to 7 Hz, 2 points; ends: the end of the interval, the stretch limit")
    assert second.startswith("curve 1: fold, period 2, symmetric, ")
    assert second.endswith("ends: closed, closed")
    assert cusp == "  cusp at voltage 0.93 ± 4e-06 kV, drive_frequency 6.5 ± 5e-07 Hz"
    assert resonance == "  strong resonance at voltage 1.15 ± 2e-06 kV, drive_frequency 8.5 ± 3e-07 Hz"


def test_a_basin_says_the_share_of_each_attractor_and_of_those_that_lead_to_none():
    over = {"displacement": [-1.0, -0.5, 0.5, 1.0], "velocity": [0.0, 0.1]}
    found = gelcone.basin(gelcone.ConeModel(damping_ratio=0.3, stretch_limit=5.0), over, transient=30.0, budget=60.0)
    lost = found.assign(attractor=found["attractor"].where([[1, 1], [1, 0], [0, 1], [1, 1]], -1))
    for shown, none in ((found, 0), (lost, 2)):
        lines = text_of(grids.basin_words, shown, BASE)
        count = shown.sizes["attractor_number"]
        head = lines.index(f"{count} attractor(s):")
        for n in range(count):
            share = 100.0 * float(shown["attractor_share"][n])
            assert numbers(lines[head + 1 + n].partition(" %")[0])[-1] == pytest.approx(share, rel=0.01)
        said = [numbers(line) for line in lines if line.startswith("  none: ")]
        assert said == ([[100.0 * none / 8.0]] if none else [])


def test_a_limit_that_is_not_met_is_said_with_the_highest_voltage_examined():
    """In the table of an envelope: at constant voltages up to 3 kV, under a drive up to 2 kV, or up to pull-in."""
    shown = xr.Dataset(
        {
            "static_displacement": ("constant_voltage", [1.0, 2.0, 3.0]),
            "limit_low": (("driven_limit", "drive_frequency"), [[np.inf, np.inf], [np.inf, 1.5], [1.9, np.inf]]),
            "limit_high": (("driven_limit", "drive_frequency"), [[np.inf, np.inf], [np.inf, 1.6], [1.9, np.inf]]),
            "static_limit_voltage": ("static_limit", [np.inf]),
        },
        {
            "constant_voltage": ("constant_voltage", [0.0, 1.0, 3.0], {"units": "kV"}),
            "peak_voltage": ("peak_voltage", [0.5, 2.0], {"units": "kV"}),
            "drive_frequency": ("drive_frequency", [8.0, 9.0], {"units": "Hz"}),
            "driven_limit": ["hoop slack", "chaos", "pull-in"],
            "static_limit": ["pull-in"],
        },
    )
    assert envelope._static_reading(shown, "hoop slack", np.inf) == "above 3 kV"
    assert envelope._static_reading(shown, "hoop slack", 1.25) == "1.25 kV"
    lost = shown.assign(static_limit_voltage=("static_limit", [2.9]))
    assert envelope._static_reading(lost, "hoop slack", np.inf) == "none to pull-in"
    rows = [envelope._lowest_driven(shown, k) for k in range(3)]
    assert rows == ["above 2 kV", "1.5 to 1.6 kV at 9 Hz", "1.9 kV at 8 Hz"]


def test_the_smallest_kick_is_said_with_its_frequency_and_where_it_leads():
    part = xr.Dataset(
        {
            "kick_low": ("drive_frequency", [0.6, 0.4, 0.8], {"units": "m/s"}),
            "kick_high": ("drive_frequency", [0.7, 0.5, 0.9], {"units": "m/s"}),
            "motion_stroke": (("drive_frequency", "motion"), [[3.0], [2.0], [4.0]], {"units": "mm"}),
        },
        {"drive_frequency": ("drive_frequency", [10.0, 11.0, 12.0], {"units": "Hz"})},
    )
    shares = {name: [[0.01 * k], [0.03 * k], [0.02 * k]] for k, name in enumerate(FAILINGS)}
    part = part.assign({f"motion_validity_{n}": (("drive_frequency", "motion"), v) for n, v in shares.items()})
    kick, goal = envelope._kick_lines(part, ("periodic, period 2",))
    assert kick == "  10 to 12 Hz: the smallest that leads away lies between 0.4 and 0.5 m/s, at 11 Hz"
    assert goal.startswith("    to: periodic, period 2, stroke 2 to 4 mm; the model does not hold: ")
    for k, words in enumerate(FAILINGS.values()):
        assert (f"{words} up to {3.0 * k:g} %" in goal) == (k > 0)
    alone, goal = envelope._kick_lines(part.isel(drive_frequency=[0]), ("pull-in",))
    assert alone == "  10 Hz: the smallest that leads away lies between 0.6 and 0.7 m/s"
    assert goal == "    to: pull-in, stroke 3 mm"
    never, _ = envelope._kick_lines(part.assign(kick_high=np.inf * part["kick_high"]), ("rest",))
    assert never == "  10 to 12 Hz: no kick leads away, but another motion exists"


def test_numbers_over_draws_have_their_median_their_interval_and_how_many_have_none():
    values = np.append(np.arange(101.0), np.nan)
    known = xr.Dataset(
        {
            "status": ("draw", np.ones(102, dtype=int)),
            "outcome": ("draw", np.zeros(102, dtype=int)),
            "stroke": ("draw", values, {"long_name": "stroke of the disc", "units": "mm"}),
            "stroke_error": ("draw", values, {"units": "mm"}),
            "validity_near_limit": ("draw", values, {"units": "1"}),
            "lost": ("draw", np.nan * values, {"units": "1"}),
            "pull_in": ("draw", values + np.inf, {"units": "V", "infinite_means": "not reached"}),
            "period": ("draw", np.ones(102, dtype=int)),
        }
    )
    assert grids.number_lines(known) == [
        "stroke of the disc: 50 mm, 95 % within 2.5 to 97.5 mm; none in 1 of 102 draws",
        "pull_in: not reached in 101 of 102 draws; none in 1 of 102 draws",
    ]


def test_a_strength_is_missing_only_where_all_else_of_the_film_is_known():
    for limit, field, said in ((0.1, np.nan, True), (np.nan, np.nan, False), (0.1, 0.2, False)):
        found = xr.Dataset({"validity_near_limit": ("m", [limit]), "validity_breakdown": ("m", [field])})
        assert strength_in_words(found) == [UNKNOWN_STRENGTH] * said


# --- lists, members, kinds --------------------------------------------------------------------------------------------


def test_a_long_list_shows_its_beginning():
    lines = [str(k) for k in range(MOST_LINES + 5)]
    assert shortened(lines)[:-1] == lines[:MOST_LINES]
    assert shortened(lines)[-1] == "  and 5 more (all with --json or --out)"
    assert shortened(lines[:MOST_LINES]) == lines[:MOST_LINES]
    assert shortened(lines[:3], MOST_LINES + 2)[-1].startswith("  and 2 more")


def test_members_are_named_by_what_varies_in_their_order():
    found = gelcone.settled(BASE.replace(voltage=[0.5, 0.6, 0.7]))
    assert [name for name, _ in members_of(found)] == ["voltage 0.5", "voltage 0.6", "voltage 0.7"]
    assert [name for name, _ in members_of(found, range(2))] == ["voltage 0.5", "voltage 0.6"]


def cells(outcomes, regimes, doubtful):
    columns = {"outcome": outcomes, "regime": regimes, "doubtful": doubtful}
    return xr.Dataset({name: ("member", values) for name, values in columns.items()})


def test_cells_that_pulled_in_are_counted_by_themselves_and_failed_ones_are_not_doubtful():
    left, ok, gone = Regime.LEFT_THE_DOMAIN, Outcome.OK, Outcome.PULLED_IN
    found = cells([ok, gone, Outcome.STRETCH_LIMIT, ok], [3, left, left, 1], [1, 1, 0, 0])
    assert answer.counts_text(found) == "periodic 1, chaotic 1, left the domain 1, pulled in 1"
    (line,) = answer.doubt_lines(found)
    assert line.startswith("1 of 4 doubtful")
    assert answer.outcome_lines(found) == [
        f"1 of 4 runs failed: {Outcome.STRETCH_LIMIT.meaning}",
        f"1 of 4 runs failed: {gone.meaning}",
    ]


def chaos(share, **changed):
    times = {"lifetime": 50.0, "lifetime_low": 20.0, "lifetime_high": 90.0, "chaotic_until": 700.0} | changed
    own = {name: ((), value, {"units": "1"}) for name, value in times.items()}
    fates = {"fate_regime": ("fate", [1, 0, -1]), "fate_period": ("fate", [3, 0, 0])}
    for end, values in (("", [0.75, 0.25, 0.0]), ("_low", [0.5, 0.1, 0.0]), ("_high", [0.9, 0.5, 0.2])):
        fates[f"fate_share{end}"] = ("fate", values)
    return xr.Dataset(own | fates | {"starts": 16, "share_chaotic": share})


def test_how_long_chaos_lasts_and_where_it_ends():
    short, fates = lasting_in_words(chaos(0.25))
    assert short == "chaos lasts 50 [20, 90] time units in the mean; 4 of 16 nearby starts are still chaotic"
    assert fates.endswith("periodic, period 3 75% [50%, 90%]; rest 25% [10%, 50%]")
    (whole,) = lasting_in_words(chaos(1.0))
    assert numbers(whole) == [700.0, 20.0]


@pytest.mark.parametrize("outcome", [one for one in Outcome if one])
def test_a_failed_member_says_how_it_failed(outcome):
    failed = xr.Dataset({"outcome": int(outcome)})
    assert motions._largest(failed) == f"failed, {outcome.name.lower().replace('_', ' ')}"


def test_the_evidence_of_a_doubtful_or_failed_run():
    one = {"outcome": 0, "regime": 1, "period": 2, "symmetric": 0, "doubtful": 1, "zero_one": 0.03}
    one |= {"cycle_distance": np.nan, "return_distance": 2e-7}
    member = xr.Dataset(one).assign(lyapunov=("exponent", [-0.1, -0.2]), standard_error=("exponent", [0.01, 0.01]))
    assert evidence_in_words(member) == [
        "periodic, period 2",
        "largest exponent -0.100 ± 0.010 per unit time",
        "0-1 test 0.03",
        "points return to within 2e-07 of its size",
        "! the evidence disagrees",
    ]
    assert evidence_in_words(member.assign(outcome=int(Outcome.OUTSIDE))) == ["failed: outside"]


def test_where_the_model_does_not_hold():
    shares = {"hoop_slack": [0.2, 0.1, np.nan], "near_limit": [0.0, 0.0, 0.0], "breakdown": [np.nan] * 3}
    found = xr.Dataset({f"validity_{name}": ("member", values) for name, values in shares.items()})
    assert validity_in_words(found) == [
        "of 3 motions the model does not hold in: hoop slack in 2 (up to 20 % of the motion)",
        "breakdown unknown: the dielectric strength is not given",
    ]
    held = found.assign(validity_breakdown=("member", [0.0] * 3), validity_hoop_slack=("member", [0.0] * 3))
    assert validity_in_words(held) == ["the model holds: film taut, away from its limits"]


def test_the_table_of_a_window_leaves_out_what_lies_on_lines():
    x, flat = np.linspace(0.0, 1.0, 41), np.full(41, 2.0)
    peak = np.exp(-(((x - 0.5) / 0.1) ** 2))
    assert envelope._kept_rows(x, flat, flat) == [0, 40]
    kept = envelope._kept_rows(x, flat, peak)
    assert {0, 20, 40} <= set(kept)
    assert 6 < len(kept) < 30
    assert np.abs(np.interp(x, x[kept], peak[kept]) - peak).max() <= 0.04
    assert envelope._kept_rows(x[:12], flat[:12]) == list(range(12))


def test_the_heading_says_how_well_each_membrane_is_known():
    device = gelcone.find_device("double-cone").replace(second_hoop_prestretch=1.2, second_meridional_prestretch=1.2)
    lines = answer.heading(Subject(device.to_model(), device))
    said = " ".join(" ".join(lines).split())
    errors = [error for known in said.split("its force is known to")[1:] for error in numbers(known)[:3]]
    own, stated = device.to_model().own_numbers, ("film_error", "gain_error", "capacitance_error")
    names = [*stated, *(f"second_{name}" for name in stated)]
    wanted = [100.0 * float(np.max(own[name])) for name in names]
    assert errors == pytest.approx(wanted, abs=0.051)
    assert errors[0] > 0.0


def test_a_creeping_film_that_no_voltage_pulls_in_says_so():
    """The cone that bears compression is pushed towards its stretch limit and finds a rest at any voltage."""
    device = gelcone.find_device("biased-pump").replace(
        {"film": "taut", "material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"}
    )
    shown = gelcone.to_si(gelcone.creep(device.to_model(), voltages=[0.3], duration=20.0), device)
    words = runs.creep_words(shown, Subject(device.to_model(), device))
    assert "no constant voltage pulls the cone itself in, at once or in the long run" in words
    assert "margin to pull-in of the cone itself at the end" in words
    assert "never is held" not in words


def test_statics_and_limits_say_when_they_are_those_of_a_film_that_has_not_crept():
    creeps = gelcone.ConeModel(rest_height=0.4, viscous_modulus_1=0.5)
    for words, analysis in ((statics.static_words, gelcone.static), (tables.table_words, gelcone.limits)):
        said = [
            any("at once" in line for line in text_of(words, analysis(model, at_once=at_once), model))
            for model, at_once in ((creeps, True), (creeps, False), (BASE, True))
        ]
        assert said == [True, False, False]
