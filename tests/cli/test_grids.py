from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.analyses.grids import totals_text
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import Tally
from gelcone.atlas.sweep import sweep
from gelcone.cli import grids, group
from gelcone.cli.grids import stored
from gelcone.cli.output import tally_text
from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from tests.answers import result

SETTINGS = ["--set", "damping_ratio=0.05", "--set", "spring_stiffness=0.5", "--set", "drive_frequency=0.3"]
QUICK = ["--transient", "300", "--budget", "1500"]
MAP = ["map", *SETTINGS, "--over", "voltage=0:1.2:9", "--over", "prestretch=0.8:1.6:7", "--coarsest", "3", *QUICK]


@pytest.fixture
def run():
    from click.testing import CliRunner

    def call(*arguments):
        result = CliRunner().invoke(group, [str(a) for a in arguments], standalone_mode=False)
        if result.exception:
            raise result.exception
        return result.stdout

    return call


def test_a_map_is_stored_shown_and_resumed(run, tmp_path):
    told = result(run(*MAP, "--store", tmp_path / "s", "--json"))
    assert told["totals"]["computed"] + told["totals"]["inferred"] == told["totals"]["cells"] == 63
    assert told["totals"]["integrator_steps"] > 0 == told["totals"]["failed"]
    again = result(run("map", "--resume", tmp_path / "s", "--json"))
    assert again["regime"] == told["regime"]
    assert again["totals"]["computed_before"] == told["totals"]["computed"]
    shown = result(run("show", tmp_path / "s", "--json", "--out", tmp_path / "o"))
    assert shown["regime"] == told["regime"]
    assert shown["status"] == told["status"]
    assert (tmp_path / "o" / "show.png").stat().st_size > 5000
    text = run("show", tmp_path / "s")
    assert "0 missing of 63" in text
    with pytest.raises(InputError, match=r"damping_ratio is 0\.05 there and 0\.1 here"):
        run(*[a.replace("0.05", "0.1") for a in MAP], "--resume", tmp_path / "s")


@pytest.mark.parametrize("device", [None, "biased-pump"])
def test_a_store_knows_where_its_cells_start(device, tmp_path):
    """What resumes or shows a store is about its own initial state, not about the usual one."""
    if device is None:
        plan, wanted = Plan(ConeModel(damping_ratio=0.3), {"voltage": [0.1, 0.2]}, (0.3, 0.1)), (0.3, 0.1)
    else:
        own = find_device(device).replace(film="taut")
        plan = Plan(own, {"frequency": ["9 Hz", "10 Hz"]}, ("5 mm", "0.1 m/s"))
        wanted = 5e-3 / own.scales.length, 0.1 / own.scales.velocity
    sweep(plan, "settled", store=tmp_path / "s")
    subject = stored(tmp_path / "s").subject
    np.testing.assert_allclose(np.ravel(subject.initial), wanted, rtol=1e-12)
    assert (subject.device is None) == (device is None)


def test_a_store_knows_its_device(run, tmp_path):
    device = [
        "map",
        "biased-pump",
        "--over",
        "voltage_amplitude=0 V:400 V:4",
        "--over",
        "spring_rate=14 N/m:16 N/m:3",
        "--uniform",
        "--film",
        "taut",
    ]
    told = result(run(*device, "--transient", "1 s", "--budget", "2 s", "--store", tmp_path / "s", "--json"))
    for command in (["map", "--resume"], ["show"]):
        again = result(run(*command, tmp_path / "s", "--json"))
        assert again["subject"]["device"] == told["subject"]["device"] == "biased pumping cone"
        assert "0 to 400 V" in run(*command, tmp_path / "s")
    assert result(run("map", "--resume", tmp_path / "s", "--json"))["lyapunov"] == told["lyapunov"]
    with pytest.raises(InputError, match="give it alone, and the store's sweep is taken"):
        run("map", "biased-pump", "--resume", tmp_path / "s")


@pytest.mark.slow
def test_uniform_computes_every_cell(run):
    told = result(run(*MAP, "--uniform", "--json"))
    assert told["totals"]["computed"] == 63


def test_probability_of_chaos(run, tmp_path):
    arguments = ["sweep", *SETTINGS, "--over", "voltage=0.3,2", "--uncertain", "prestretch=1~0.02", "--count", "8"]
    told = result(run(*arguments, *QUICK, "--json", "--out", tmp_path))
    assert told["dims"]["regime"] == ["voltage", "draw"]
    assert told["probability"]["probability"][0] == 0.0
    assert told["probability"]["low"][1] <= told["probability"]["probability"][1] <= told["probability"]["high"][1]
    assert len(told["drawn_prestretch"]) == 8
    assert (tmp_path / "sweep.png").stat().st_size > 5000
    assert "probability of chaos" in run(*arguments, *QUICK)


def test_limits_over_three_parameters(run):
    over = ["--over", "prestretch=0.9,1.1", "--over", "spring_stiffness=0.5,1", "--over", "drive_frequency=0.3,0.5"]
    told = result(run("sweep", *over, "--analysis", "limits", "--json"))
    assert told["dims"]["pitchfork_voltage"] == ["prestretch", "spring_stiffness", "drive_frequency"]
    assert told["pitchfork_voltage"][0][0][0] == told["pitchfork_voltage"][0][0][1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sweep"], "--over: is not given; give what is swept, such as"),
        (["sweep", "--over", "voltage=0.1:0.2:2", "--analysis", "static"], "cannot be swept; choose one of .*settled"),
        (["sweep", "--over", "voltage=0.1:0.2:2", "--analysis", "static"], "; static itself takes lists"),
        (["sweep", "--over", "voltage=0:1:3", "--uncertain", "prestretch=1"], "must be name=low:high"),
        (["sweep", "--over", "voltage=0:1:3", "--analysis", "regimes"], "did you mean 'regime'"),
        (["map", "--store", "a", "--resume", "b"], "--store and --resume"),
        (["map", "--threads", "1", "--workers", "2"], "give one of them"),
        (["map", "--resume", "nothing-there"], "no such store"),
        (["show", "nothing-there"], "no such file"),
    ],
)
def test_bad_input(run, arguments, message):
    with pytest.raises(InputError, match=message):
        run(*arguments)


def test_options_of_the_chosen_analysis_are_taken_and_others_refused(run):
    over = ["sweep", "--over", "voltage=0.4,0.5", "--json"]
    told = result(run(*over, "--analysis", "lyapunov", "--window", "30", *QUICK))
    assert told["options"]["window"] == 30.0
    assert told["options"]["budget"] == 1500.0
    assert "running_exponent" not in told
    kept = result(run(*over, "--analysis", "lyapunov", "--window", "30", *QUICK, "--keep", "running_exponent"))
    assert len(kept["running_exponent"][0]) > 1
    with pytest.raises(InputError, match="'window' is not an option of the analysis regime"):
        run(*over, "--window", "30")


def test_the_line_about_a_run_counts_what_is_left_of_what_was_asked():
    tally = Tally(cells=1000, asked=300, computed=200, found=100, chaotic=50, seconds=20.0)
    assert tally_text(tally) == "200 of 300 cells, 5 a second, 20 s left, 25 % chaotic"
    assert tally_text(Tally(cells=10)) == "0 of 0 cells, 0 a second"
    assert tally_text(Tally(cells=10, chaotic=0)) == "0 of 0 cells, 0 a second, 0 % chaotic"


def test_the_totals_say_what_the_check_missed_with_its_interval():
    totals = Tally(cells=400, computed=200, inferred=200, steps=1234, seconds=2.0, checked=33, missed=2).record()
    assert totals_text(totals).splitlines() == [
        "200 of 400 cells computed, 200 inferred; 1,234 steps in 2 s",
        "check: of 33 inferred cells, drawn at random and computed, 2 had another regime or sign: 6.1 % [0.74, 20]",
    ]


def test_tolerances_in_words_and_as_json_are_the_same(run, tmp_path):
    table = tmp_path / "fit.csv"
    rows = [(0.3, 1.0), (1.2, 1.1), (1.6, 0.9), (1.9, 1.05), (2.0, 1.0), (0.4, 1.2)]
    table.write_text("voltage,prestretch\n" + "\n".join(f"{v},{p}" for v, p in rows), encoding="utf-8")
    arguments = ["sweep", *SETTINGS, "--uncertain", str(table), *QUICK]
    told, text = result(run(*arguments, "--json")), run(*arguments)
    assert told["drawn_voltage"] == [v for v, _ in rows]  # as they come
    found = told["tolerances"]
    assert found["risk"] == ["pull-in", "breakdown", "chaos"]
    chance, low, high = (found[name][2] for name in ("probability", "low", "high"))
    assert f"probability of chaos {chance:.3g} [{low:.3g}, {high:.3g}] of {found['decided'][2]} draws" in text
    assert f"50 % {found['stroke'][1]:.3g} [" in text
    assert "breakdown" not in text.split("probability of", 1)[1]  # not known
    assert "6 draws of voltage, prestretch" in text
    assert "Sobol" not in text  # a table is not arranged for them


def test_indices_are_printed_the_largest_first(run):
    two = ["--uncertain", "voltage=0.2:2", "--uncertain", "prestretch=0.99:1.01", "--count", "16"]
    text = run("sweep", *SETTINGS, *two, *QUICK)
    lines = [line.strip() for line in text.splitlines()]
    first = next(k for k, line in enumerate(lines) if "Sobol indices: alone" in line)
    assert lines[first + 1].startswith("voltage: ")
    assert lines[first + 2].startswith("prestretch: ")
    assert "16 draws of voltage, prestretch, and 16 for Sobol indices" in text
    assert "Sobol" not in run("sweep", *SETTINGS, *two, *QUICK, "--no-indices")


# --- what is refused, word by word ------------------------------------------------------------------------------------

ONE, TWO = ("--over", "voltage=0:1:3"), ("--over", "voltage=0:1:3", "--over", "prestretch=1:2:3")
THREE = (*TWO, "--over", "damping_ratio=0.1:0.2:2")
TAKES = "--over: a map takes two parameters, not"
ALONE = (
    "--resume s: give it alone, and the store's sweep is taken, or with all of the sweep (device, --set, --over), "
    "and it is compared"
)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["map"], f"{TAKES} 0; for example --over voltage=0:2:101 --over prestretch=0.4:2:81"),
        (
            ["map", "biased-pump", "--film", "taut"],
            f"{TAKES} 0; for example --over \"voltage_amplitude=100 V:800 V:29\" --over \"frequency=5 Hz:20 Hz:31\"",
        ),
        (["map", *ONE], f"{TAKES} 1; for one, use `gelcone bifurcation`"),
        (["map", *THREE], f"{TAKES} 3; fix the others with --set, or use `gelcone sweep`"),
        (["map", *TWO, "--store", "a", "--resume", "b"],
         "--store and --resume: give one of them; --store begins, --resume continues"),
        (["sweep", *ONE, "--threads", "1", "--scheduler", "a"],
         "--threads, --workers and --scheduler: give one of them"),
        (["map", "--resume", "s", "--set", "damping_ratio=0.1"], ALONE),
        (["map", "--resume", "s", "--coarsest", "9"], ALONE),
        (["sweep", "--resume", "s", "--count", "8"], ALONE),
        (["sweep", "--resume", "s", "--preset", "base"], ALONE),
        (["show", "a.toml", "--out", "b"], "--out b: a device has no figure; leave it out"),
    ],
)  # fmt: skip
def test_a_sweep_that_cannot_be_is_refused_in_full_words(typed, message, run):
    with pytest.raises(InputError) as error:
        run(*typed)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("analysis", "dims", "draws", "taken"),
    [
        ("regime", 2, {}, True), ("regime", 1, {}, False), ("regime", 3, {}, False), ("settled", 2, {}, False),
        ("regime", 2, {"a": [1.0, 2.0]}, False),
    ],
)  # fmt: skip
@pytest.mark.parametrize("how", [(), ("--threads", "2"), ("--out", "there", "--force"), ("--json",)])
def test_a_map_continues_a_store_of_a_map_alone(analysis, dims, draws, taken, how, run, monkeypatch):
    plan = SimpleNamespace(dims=("a", "b", "c")[:dims], draws=draws)
    wanted = grids.Sweep(None, plan, analysis, 9, ())
    asked = []
    monkeypatch.setattr(grids, "stored", lambda store: wanted)
    monkeypatch.setattr(grids, "run", lambda *given, **more: asked.append((given, more)))
    if not taken:
        with pytest.raises(InputError) as error:
            run("map", "--resume", "s", *how)
        assert str(error.value) == "s: holds a sweep that is not a map; use `gelcone sweep --resume s`"
        return
    run("map", "--resume", "s", *how)
    (command, own, store, resume, workers, drawn), more = asked.pop()
    assert (command.name, own, store, resume, more) == ("map", wanted, Path("s"), True, {"also": None})
    assert (workers is None) == ("--threads" not in how)
    assert (drawn["out"], drawn["force"], drawn["as_json"]) == (
        Path("there") if "--out" in how else None, "--force" in how, "--json" in how,
    )  # fmt: skip
    run("sweep", "--resume", "s", *how)
    assert asked.pop()[0][0].name == "sweep"


@pytest.mark.parametrize(("typed", "coarsest"), [((), 64), (("--coarsest", "9"), 9), (("--uniform",), None)])
def test_every_cell_of_a_uniform_map_is_computed_and_others_from_a_grid_on(typed, coarsest, run, monkeypatch):
    asked = []
    monkeypatch.setattr(grids, "run", lambda command, wanted, *given, **more: asked.append(wanted))
    run("map", *TWO, *typed)
    assert (asked[0].coarsest, asked[0].plan.dims) == (coarsest, ("voltage", "prestretch"))


@pytest.mark.parametrize(("analysis", "draws"), [("regime", 32), ("settled", 16)])
def test_draws_for_sobol_indices_are_made_where_kinds_of_motion_are_asked_for_alone(analysis, draws, run, monkeypatch):
    asked = []
    monkeypatch.setattr(grids, "run", lambda command, wanted, *given, **more: asked.append(wanted))
    two = ("--uncertain", "voltage=0.2:2", "--uncertain", "prestretch=0.99:1.01", "--count", "16")
    run("sweep", *two, "--analysis", analysis)
    assert {name: len(values) for name, values in asked[0].plan.draws.items()} == {
        "voltage": draws,
        "prestretch": draws,
    }


def test_the_options_of_a_sweep_name_the_analyses_that_take_them():
    from gelcone.register.analyses import sweepable

    takers = {}
    for analysis in sweepable().values():
        for name in analysis.options:
            takers.setdefault(name, []).append(analysis.name)
    found = {option.name: option.help for option in grids.sweep_options()}
    assert set(found) == set(takers) - {"threads"}
    for name, text in found.items():
        own = sweepable()[takers[name][0]].options[name].help
        assert text == f"{own} Of {', '.join(takers[name])}."


def test_what_a_store_or_file_holds_is_shown_in_its_own_words(run, monkeypatch, tmp_path):
    """A store as it is, a file by the command that wrote it, and what a fit or design wrote by its own words."""
    calls = []
    (tmp_path / "s").mkdir()
    monkeypatch.setattr(grids, "show", lambda place: f"cells of {place.name}")
    monkeypatch.setattr(grids, "stored", lambda place: SimpleNamespace(subject=f"subject of {place.name}"))
    monkeypatch.setattr(grids, "load", lambda place: f"result of {place.name}")
    monkeypatch.setattr(grids, "check_folder", lambda *given: calls.append(given))
    monkeypatch.setattr(grids, "answer_to", lambda result: (SimpleNamespace(command="settled"), f"what {result} is of"))
    monkeypatch.setattr(grids, "lab_answer", lambda result: None)
    monkeypatch.setattr(
        grids, "deliver", lambda answers, result, subject, *how: calls.append((answers.command, result, subject, *how))
    )
    run("show", tmp_path / "s", "--out", "there", "--force")
    assert calls == [
        (Path("there"), "show", True), ("show", "cells of s", "subject of s", Path("there"), True, False),
    ]  # fmt: skip
    calls.clear()
    run("show", "a.nc", "--json")
    assert calls == [
        (None, "settled", False), ("settled", "result of a.nc", "what result of a.nc is of", None, False, True),
    ]  # fmt: skip
    calls.clear()
    monkeypatch.setattr(grids, "lab_answer", lambda result: (lambda: "words of a fit", lambda: {"of": result}))
    assert run("show", "fit.nc") == "words of a fit\n"
    assert result(run("show", "fit.nc", "--json"))["result"] == {"of": "result of fit.nc"}
    with pytest.raises(InputError) as error:
        run("show", "fit.nc", "--out", "there")
    assert str(error.value) == ("--out there: the command that wrote fit.nc writes its figure, too; leave it out")
    assert calls == []
