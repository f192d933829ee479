"""The command line: what it prints and writes, one line for every bad input, a fast start and a clean stop."""

import errno
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel
from gelcone.cli import COMMANDS, SECTIONS
from tests.answers import answer, result

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "trajectories.json").read_text())
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def run(command_line):
    return command_line


def started(*arguments, **options):
    """A true process of the command line."""
    return subprocess.run(
        [sys.executable, "-m", "gelcone", *arguments], capture_output=True, text=True, check=False, **options
    )


# --- JSON and text ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", REFERENCE, ids=[f"case{i}" for i in range(len(REFERENCE))])
def test_times_agree_with_34_digit_arithmetic(run, case):
    names = {
        "zeta": "damping_ratio",
        "k": "spring_stiffness",
        "meridional": "meridional_prestretch",
        "hoop": "hoop_prestretch",
        "J": "stretch_limit",
        "v": "voltage",
        "omega": "drive_frequency",
        "rest": "rest_height",
    }
    settings = [part for key, name in names.items() for part in ("--set", f"{name}={case['parameters'][key]}")]
    table = np.array(case["trajectory"])
    times = ",".join(map(str, table[:, 0]))
    code, out, err = run(
        "simulate", *settings, "--initial", ",".join(case["initial"]), "--over", f"time={times}", "--json"
    )
    assert (code, err) == (0, "")
    found = result(out)
    assert found["time"] == table[:, 0].tolist()
    np.testing.assert_allclose(found["displacement"], table[:, 1], rtol=1e-12)
    np.testing.assert_allclose(found["velocity"], table[:, 2], rtol=1e-12)
    assert found["outcome"] == "ok"


def test_json_holds_what_a_program_needs(run):
    code, out, err = run("simulate", "--json", "--periods", "2")
    assert (code, err) == (0, "")
    assert len(out.splitlines()) == 1
    found = result(out)
    assert {"time", "displacement", "velocity", "outcome", "parameters", "validity"} <= found.keys()
    assert found["parameters"] == ConeModel().parameters() | {"law": "gent"}
    assert found["validity"].keys() == {
        "hoop_slack",
        "meridional_slack",
        "breakdown",
        "near_limit",
        "beyond_membrane",
        "pulled_in",
        "error",
    }
    assert found["validity"]["breakdown"] == "unknown"
    assert found["subject"]["initial"] == [1.0, 0.0]
    assert len(found["time"]) == len(found["displacement"]) == len(found["velocity"]) == 201
    assert np.abs(found["energy_residual"]).max() < 1e-12


def test_what_no_number_can_hold_is_a_word_and_an_infinite_limit_says_so(run):
    arguments = ("simulate", "--set", "stretch_limit=inf", "--set", "voltage_bias=3", "--over", "time=1,900", "--json")
    code, out, _ = run(*arguments)
    found = result(out)
    assert code == 1, "every member failed"
    assert found["outcome"] == "not_finite"
    assert found["displacement"][0] == "unknown" or np.isfinite(found["displacement"][0])
    assert found["displacement"][1] == "unknown"
    assert found["parameters"]["stretch_limit"] == "inf"


@pytest.mark.parametrize("values", ["0.5,1", "0.5:1:2", " 0.5 , 1 "])
def test_a_list_or_a_range_makes_an_ensemble(run, values):
    code, out, _ = run("simulate", "--set", f"voltage={values}", "--over", "time=1,2,3", "--json")
    found = result(out)
    assert code == 0
    assert found["parameters"]["voltage"] == [0.5, 1.0]
    assert found["outcome"] == ["ok", "ok"]
    assert np.shape(found["displacement"]) == (2, 3)
    assert np.shape(found["time"]) == (3,)
    for voltage, displacement in zip((0.5, 1.0), found["displacement"], strict=True):
        alone = gelcone.simulate(ConeModel(voltage=voltage), times=[1.0, 2.0, 3.0])
        np.testing.assert_array_equal(alone.displacement, displacement)


def test_the_summary_tells_range_and_validity(run):
    code, out, err = run("simulate", "--set", "voltage=0.5,1.0", "--set", "stretch_limit=0.6", "--initial", "0.5,0")
    assert (code, err) == (0, "")
    assert "cone model, dimensionless" in out
    assert "2 of 2: ok" in out
    assert "0.5  -0.6413 to 0.6025" in out  # a column for each, between samples, too
    assert "hoop slack" in out
    assert "breakdown unknown: the dielectric strength is not given" in out


def test_the_summary_says_why_a_member_failed(run):
    code, out, _ = run("simulate", "--set", "stretch_limit=0.4,50", "--periods", "1")
    assert code == 0
    assert "1 of 2: ok" in out
    assert f"1 of 2: {gelcone.Outcome.OUTSIDE.meaning}" in out


# --- devices ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper-table1", "soft-film", "biased-pump"])
def test_every_device_that_ships_runs_in_si_units(run, name):
    code, out, _ = run("simulate", name, "--periods", "3", "--json")
    assert code == 0
    found = result(out)
    device = gelcone.find_device(name)
    assert found["outcome"] == "ok"
    assert found["subject"]["device"] == device.name
    assert found["validity"]["breakdown"] is not None
    units = {name: unit for name, unit in found["units"].items() if unit in ("mm", "mm, m/s", "ms", "m/s", "V")}
    assert units.pop("initial") == "mm, m/s"
    ends = {f"pull_in_{name}": unit for name, unit in (("time", "ms"), ("displacement", "mm"), ("film_voltage", "V"))}
    own = {"time": "ms", "displacement": "mm", "velocity": "m/s", "drive_voltage": "V", "rms_voltage": "V"}
    assert units == own | (ends if device.film == "membrane" else {})
    assert (found["film_state"] is not None) == (device.film == "membrane")
    alone = gelcone.simulate(device.to_model(), device.initial_state(), periods=3)
    np.testing.assert_allclose(found["displacement"], 1e3 * device.scales.length * alone["displacement"])
    assert found["time"][-1] == pytest.approx(3e3 / device.frequency)
    assert found["subject"]["initial"][0] == pytest.approx(found["displacement"][0], rel=1e-12)


def test_a_device_is_changed_in_its_units(run):
    base = result(run("simulate", "paper-table1", "--over", "time=20 ms", "--json")[1])
    same = result(
        run("simulate", "paper-table1", "--over", "time=20ms", "--set", "film_radius=50 mm", "--json")[1],
    )
    assert same == base
    softer = result(
        run("simulate", "paper-table1", "--over", "time=20 ms", "--set", "material.shear_modulus=10 kPa", "--json")[1]
    )
    assert softer["parameters"] is None
    assert softer["subject"]["fields"]["material"]["shear_modulus"] == 1e4
    assert softer["displacement"] != base["displacement"]
    code, out, err = run("simulate", "paper-table1", "--over", "time=20 ms", "--set", "voltage=0.2", "--json")
    assert (code, out) == (2, "")
    assert err == "Error: --set voltage: 'voltage' is not a device field; did you mean 'voltage_amplitude'?\n"


def test_initial_states_and_times_of_a_device_may_have_units(run):
    arguments = ("simulate", "paper-table1", "--initial", "5 mm, 10 mm/s", "--over", "time=0 ms, 1 ms", "--json")
    found = result(run(*arguments)[1])
    assert found["displacement"][0] == pytest.approx(5.0, rel=1e-14)
    assert found["velocity"][0] == pytest.approx(0.01, rel=1e-14)
    assert found["subject"]["initial"] == pytest.approx([5.0, 0.01], rel=1e-14)
    np.testing.assert_allclose(found["time"], [0.0, 1.0], rtol=1e-14)


def test_a_device_file_of_ones_own(run, tmp_path):
    text = gelcone.devices.device.shipped_devices()["soft-film"].read_text()
    (tmp_path / "mine.toml").write_text(text.replace('"530 V"', '"265 V"'))
    mine = result(run("simulate", "mine.toml", "--over", "time=1 s", "--json")[1])
    theirs = result(run("simulate", "soft-film", "--over", "time=1 s", "--json")[1])
    assert 2.0 * np.array(mine["drive_voltage"]) == pytest.approx(np.array(theirs["drive_voltage"]))


def test_devices_and_materials_are_listed(run):
    code, out, err = run("devices")
    assert (code, err) == (0, "")
    assert "paper-table1" in out
    devices = answer(run("devices", "--json")[1])["result"]
    assert {"biased-pump", "double-cone", "snap-cone"} <= devices.keys()
    assert all(Path(entry["file"]).is_file() for entry in devices.values())
    code, out, err = run("materials")
    assert (code, err) == (0, "")
    assert "PVC-DBA 4:1: shear modulus 18.7 kPa" in out
    assert "Polymers" in out
    materials = result(run("materials", "--json")[1])
    assert materials["PVC-DBA 4:1"]["shear_modulus"] == pytest.approx(56.1e3 / 3.0)


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("device", [[], ["paper-table1"]])
def test_out_writes_data_and_figure_and_never_twice(run, tmp_path, device):
    arguments = ("simulate", *device, "--periods", "2", "--out", "results")
    code, out, err = run(*arguments)
    assert (code, err) == (0, "")
    assert sorted(os.listdir("results")) == ["simulate.nc", "simulate.png"]
    assert "wrote results/simulate.nc\nwrote results/simulate.png\n" in out
    data, picture = Path("results/simulate.nc"), Path("results/simulate.png")
    assert picture.read_bytes().startswith(PNG)
    result = gelcone.load(data)
    assert result.displacement.attrs["units"] == ("mm" if device else "1")
    assert result.sizes["time"] == 201
    before = data.read_bytes(), picture.read_bytes()

    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    said = "exists already; choose another name, or overwrite it with force (force=True, --force)"
    assert err == f"Error: results/simulate.nc: {said}\n"
    assert before == (data.read_bytes(), picture.read_bytes())

    code, _, err = run(*arguments, "--force", "--set", "damping_ratio=0.3")
    assert (code, err) == (0, "")
    changed = gelcone.load(data)
    assert not changed.displacement.equals(result.displacement)
    assert sorted(os.listdir("results")) == ["simulate.nc", "simulate.png"]


def test_a_lone_figure_is_not_overwritten_either(run):
    os.mkdir("results")
    Path("results/simulate.png").write_text("mine")
    code, _, err = run("simulate", "--periods", "1", "--out", "results")
    assert code == 2
    assert "results/simulate.png: exists already" in err
    assert os.listdir("results") == ["simulate.png"]


def test_out_and_json_go_together(run):
    code, out, _ = run("simulate", "--periods", "1", "--out", "results", "--json")
    assert code == 0
    assert result(out)["displacement"] == gelcone.load("results/simulate.nc").displacement.values.tolist()


def test_a_file_in_the_way_of_the_folder_is_refused_before_the_work(run, monkeypatch):
    Path("file").write_text("mine")

    def never(*arguments, **options):
        raise AssertionError("the work was begun")

    monkeypatch.setattr("gelcone.motion.response.simulate", never)
    for folder in ("file", "file/below"):
        code, out, err = run("simulate", "--out", folder)
        assert (code, out) == (2, "")
        assert err == f"Error: {folder}: cannot be written ({Path.cwd() / 'file'} is a file); choose another folder\n"
    assert Path("file").read_text() == "mine"


def test_a_figure_that_cannot_be_drawn_leaves_no_data_behind(run, monkeypatch):
    def full(figure, path):
        path.write_bytes(PNG)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("gelcone.plots.style.draw_file", full)
    code, _, err = run("simulate", "--periods", "1", "--out", "results")
    assert code == 2
    full_disk = "cannot be written (No space left on device); free some space or choose another folder"
    assert err == f"Error: {Path('results', 'simulate.png')}: {full_disk}\n"
    assert os.listdir("results") == []


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        # names
        (["simulat"], "'simulat' is not a command; did you mean 'simulate'?"),
        (["simulate", "--perids", "3"], "--periods"),
        (["simulate", "--set", "volage=1"], "'volage' is not a model parameter; did you mean 'voltage'?"),
        (["simulate", "--set", "law=gnt"], "'gnt' is not a strain-energy law; did you mean 'gent'?"),
        (["simulate", "--set", "prestretch_mode=radail"], "did you mean 'radial'?"),
        (["simulate", "paper-table1", "--set", "film_radus=1"], "did you mean 'film_radius'?"),
        (["simulate", "paper-table1", "--set", "material=PVC-DBA 4"], "did you mean 'PVC-DBA 4:1'?"),
        (["simulate", "one.toml", "two.toml"], "unexpected extra argument (two.toml)"),
        # types
        (["simulate", "--set", "voltage=high"], "voltage = 'high': must be a number"),
        (["simulate", "--set", "voltage=1,high"], "voltage = '1,high': must be a number"),
        (["simulate", "--set", "voltage"], "--set 'voltage': must be name=value, for example --set voltage=1.04"),
        (["simulate", "--set", "voltage="], "--set 'voltage=': must be name=value"),
        (["simulate", "--set", "=1"], "--set '=1': must be name=value"),
        (["simulate", "--set", "voltage=1", "--set", "voltage=2"], "--set voltage: is given twice; give it once"),
        (["simulate", "--set", "voltage=1:2:x"], "'1:2:x': must be a range from:to:count"),
        (["simulate", "--set", "voltage=2:1:5"], "'2:1:5': is empty or reversed"),
        (["simulate", "--set", "voltage=0:1:1"], "'0:1:1': has 1 points; a range takes 2 to"),
        (["simulate", "--set", "voltage=[1, 2]", "--set", "rest_height=1,2,3"], "do not broadcast together"),
        (["simulate", "--periods", "many"], "'many' is not a valid float"),
        (["simulate", "--initial", "1"], "--initial '1': must be a displacement and a velocity"),
        (["simulate", "--initial", "up,0"], "--initial displacement 'up': must be a number"),
        (["simulate", "--over", "time=soon"], "--over time 'soon': must be a number"),
        (["simulate", "--over", "time=1,,2"], "has an empty value"),
        # not a number, infinite
        (["simulate", "--set", "voltage=nan"], "voltage = nan: must be a number"),
        (["simulate", "--set", "voltage=inf"], "voltage = inf: must be finite"),
        (["simulate", "--set", "voltage=0:inf:5"], "'0:inf:5': the ends of a range must be finite"),
        (["simulate", "--set", "stretch_limit=nan"], "stretch_limit = nan: must be a number"),
        (["simulate", "--initial", "nan,0"], "--initial displacement nan: must be finite"),
        (["simulate", "--initial", "1,inf"], "--initial velocity inf: must be finite"),
        (["simulate", "--over", "time=nan"], "--over time nan: must be finite"),
        (["simulate", "--periods", "nan"], "--periods nan: must be a positive number of drive periods"),
        (["simulate", "--periods", "inf"], "--periods inf: must be a positive number of drive periods"),
        # bounds
        (["simulate", "--set", "drive_frequency=0"], "drive_frequency = 0: must be greater than 0"),
        (["simulate", "--set", "damping_ratio=-0.1"], "damping_ratio = -0.1: must be at least 0"),
        (["simulate", "--set", "prestretch=0"], "prestretch = 0: must be greater than 0"),
        (["simulate", "--set", "voltage=0.5,-1"], "voltage = -1: must be at least 0"),
        (["simulate", "--periods", "0"], "--periods 0: must be a positive number of drive periods"),
        (["simulate", "--periods", "-2"], "--periods -2: must be a positive number of drive periods"),
        (["simulate", "--over", "time=2,1"], "--over time: must increase; sort the values"),
        (
            ["simulate", "--over", "time=-1,1"],
            "--over time=-1,1: -1 is among them; they must be finite and not before 0",
        ),
        (["simulate", "--over", "time=0"], "--over time=0: the run has no length; give at least one later time"),
        (["simulate", "paper-table1", "--set", "film_radius=0"], "film_radius = 0.0: must be greater than 0 m"),
        (["simulate", "paper-table1", "--set", "moving_mass=-1 g"], "moving_mass = '-1 g': must be greater than 0 kg"),
        (["simulate", "paper-table1", "--set", "disc_radius=60 mm"], "must be less than film_radius = 50 mm"),
        # the stretch limit
        (
            ["simulate", "--set", "stretch_limit=0.4"],
            "stretch_limit = 0.4: must exceed I1 - 3 = 0.5 at the initial displacement 1; start lower or raise it",
        ),
        (["simulate", "--initial", "9,0"], "stretch_limit = 50: must exceed I1 - 3 = 80.01"),
        (["simulate", "--initial", "1e200,0", "--set", "stretch_limit=inf"], "its strain is beyond what doubles hold"),
        (["simulate", "paper-table1", "--initial", "900 mm,0"], "stretch_limit = 50: must exceed I1 - 3 ="),
        # combinations
        (["simulate", "--set", "law=yeoh", "--set", "stretch_limit=9"], "the yeoh law does not take it"),
        (["simulate", "--set", "prestretch=1.1", "--set", "hoop_prestretch=1.1"], "give one or the other"),
        # units that are not exact
        (["simulate", "--initial", "5 mm,0"], "must be a number (units need a device)"),
        (["simulate", "paper-table1", "--set", "voltage_amplitude=1,2 kV"], "looks like a decimal comma; write 1.2 kV"),
        (["simulate", "paper-table1", "--set", "film_radius=50 MM"], "'MM' is not a unit of length"),
        (["simulate", "paper-table1", "--set", "film_radius=50 V"], "V is a unit of voltage, not of length"),
        (["simulate", "paper-table1", "--set", "film_radius=about 50 mm"], "is not one decimal number and one unit"),
        (["simulate", "paper-table1", "--over", "time=20 mm"], "is a unit of length, not of time"),
        # files
        (["simulate", "none.toml"], "none.toml: there is no such file"),
        (["simulate", "paper-tabel1"], "paper-table1"),
        (["simulate", "."], "is a folder"),
        (["simulate", "broken.toml"], "broken.toml: broken TOML"),
        (["simulate", "bytes.toml"], "bytes.toml: is not UTF-8 text"),
        (["simulate", "empty.toml"], "empty.toml"),
        (["simulate", "typo.toml"], "typo.toml, line 2"),
        (["simulate", "--out", "x" * 300], "cannot be written (File name too long); choose another folder"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run, arguments, message):
    Path("broken.toml").write_text('name = "half\n')
    Path("bytes.toml").write_bytes(b"\xff\xfe\x00")
    Path("empty.toml").write_text("")
    Path("typo.toml").write_text('name = "typo"\nfilm_radus = "50 mm"\n')
    before = sorted(os.listdir())
    code, out, err = run(*arguments)
    assert code == 2
    assert out == ""
    fields = ("empty.toml", "typo.toml")  # which lack several fields, a line each
    assert all(line.startswith("Error: ") for line in err.splitlines())
    assert err.count("\n") == (8 if set(fields) & set(arguments) else 1)
    assert err.endswith("\n")
    assert message in err
    assert sorted(os.listdir()) == before


# --- reading of values ------------------------------------------------------------------------------------------------


# --- true processes ---------------------------------------------------------------------------------------------------


def test_help_and_version(run):
    for arguments in ([], ["--help"], ["-h"], ["simulate", "--help"]):
        code, out, err = run(*arguments)
        assert (code, err) == (0, "")
        assert out.startswith("Usage: gelcone")
    assert run("--version")[1] == f"gelcone, version {gelcone.__version__}\n"


def test_help_lists_every_command_once_under_what_one_asks(command_line):
    assert sorted(" ".join(SECTIONS.values()).split()) == sorted(COMMANDS)
    _, out, _ = command_line("--help")
    listed = re.findall(r"^  ([a-z-]+) +[A-Z]", out[out.index(f"{next(iter(SECTIONS))}:") :], flags=re.MULTILINE)
    assert sorted(listed) == sorted(COMMANDS)
    assert all(f"\n{title}:\n" in out for title in SECTIONS)


HEAVY = {"llvmlite", "matplotlib", "pandas", "xarray", "scipy", "pydantic", "netCDF4"}


@pytest.mark.parametrize(
    "statement",
    [
        "import gelcone",
        "import gelcone.cli",
        "import sys; sys.argv[1:] = ['--help']\nfrom gelcone.cli import main\ntry: main()\nexcept SystemExit: pass",
    ],
)
def test_starting_loads_nothing_heavy(statement):
    code = f"{statement}\nimport sys\nprint(sorted({HEAVY!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_process_prints_one_line_for_bad_input_and_exits_with_2(tmp_path):
    done = started("simulate", "--set", "volage=1", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "Error: 'volage' is not a model parameter; did you mean 'voltage'?\n"


def test_a_process_prints_one_json_object(tmp_path):
    done = started("simulate", "--over", "time=1,2", "--json", cwd=tmp_path)
    assert done.returncode == 0
    assert all(line.startswith("simulate, ") for line in done.stderr.splitlines())  # progress, after five seconds
    assert result(done.stdout)["time"] == [1.0, 2.0]
    assert os.listdir(tmp_path) == []


INTERRUPTED = """
import os, signal, sys, threading
import gelcone
from gelcone.cli import main
gelcone.simulate(gelcone.ConeModel(), periods=1)  # whatever is imported on first use
signal.signal(signal.SIGINT, signal.default_int_handler)  # also where the shell has it ignored
threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
sys.argv[0] = "gelcone"
main()
"""


def test_an_interrupt_ends_a_long_run_without_traceback_and_without_files(tmp_path):
    """The run would take days; it is interrupted when it has well begun."""
    command = [sys.executable, "-c", INTERRUPTED, "simulate", "--periods", "1e8", "--out", "results"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 130
    assert done.stdout == ""
    assert done.stderr.strip() == "interrupted"
    assert os.listdir(tmp_path) == []


def test_an_ensemble_of_which_some_run_has_succeeded(run):
    code, out, _ = run("simulate", "--set", "stretch_limit=0.4,50", "--over", "time=1", "--json")
    assert code == 0
    assert result(out)["outcome"] == ["outside", "ok"]
