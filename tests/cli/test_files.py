"""`gelcone show` and `gelcone export` take every file that gelcone writes."""

import json

import numpy as np
import pytest

from gelcone.analyses.ask import TITLES
from gelcone.register.analyses import ANALYSES
from tests.answers import answer

BASE = ("--preset", "base")
COMMANDS = [
    ("simulate", "biased-pump", "--periods", "2"),
    ("section", *BASE, "--repeats", "3", "--discard", "2"),
    ("extrema", *BASE, "--repeats", "3", "--discard", "2"),
    ("spectrum", *BASE, "--periods", "16"),
    ("regime", "soft-film", "--budget", "60 ms"),
    ("static", "biased-pump", "--set", "film_thickness=0.2 mm,0.3 mm"),
    (
        *("film", "paper-table1", "--film", "membrane"),
        *("--over", "displacement=20 mm,30 mm", "--over", "constant_voltage=0 V,3 kV"),
    ),
    ("limits", *BASE),
    ("tongues", *BASE, "--over", "drive_frequency=0.1:2:3", "--over", "voltage=0.1:1.9:2"),
    ("map", *BASE, "--over", "voltage=0.9:1.1:3", "--over", "damping_ratio=0.01:0.02:2", "--budget", "600"),
    (
        "map",
        "biased-pump",
        "--over",
        "frequency=9 Hz,10 Hz",
        "--over",
        "film_thickness=0.2 mm,0.3 mm",
        "--initial",
        "5 mm,0.1 m/s",
        "--transient",
        "1 s",
        "--budget",
        "2 s",
    ),
    ("sweep", "biased-pump", "--analysis", "limits", "--over", "film_thickness=0.2 mm:0.3 mm:2"),
    ("validate", "paper-table1", "--over", "displacement=20 mm", "--over", "constant_voltage=0 V", "--elements", "20"),
]


@pytest.mark.parametrize("typed", COMMANDS, ids=lambda typed: typed[0])
def test_a_result_is_shown_in_the_words_of_its_command(typed, command_line, undrawn):
    code, out, err = command_line(*typed, "--out", "there")
    assert code == 0, err
    told, name = out.split("wrote ")[0], typed[0]
    assert command_line("show", f"there/{name}.nc")[1] == told
    again = json.loads(command_line("show", f"there/{name}.nc", "--json")[1])
    first = json.loads(command_line(*typed, "--json")[1])
    starts = [known["subject"].pop("initial") for known in (again, first)]
    for known in (again, first):
        known["result"].pop("totals", None)  # holds how long it took
    assert again == first
    if starts[0] is not None and name != "limits":
        assert np.ravel(starts[0]) == pytest.approx(np.ravel(starts[1]))


def test_every_analysis_is_known_by_its_title():
    assert set(TITLES.values()) == set(ANALYSES) - {"show"}


def test_a_device_is_shown(command_line):
    command_line("init", "mine.toml")
    code, out, err = command_line("show", "mine.toml")
    assert (code, err) == (0, "")
    assert 'film_thickness = "200 um"' in out
    shown = answer(command_line("show", "mine.toml", "--json")[1])
    assert (shown["command"], shown["result"]["film_thickness"]) == ("show", 2e-4)


@pytest.mark.parametrize("command", ["show", "export"])
@pytest.mark.parametrize(("name", "why"), [("bad.nc", "is not a readable netCDF-4 file"), ("no.nc", "no such file")])
def test_a_damaged_or_missing_file_is_called_that(command, name, why, command_line, tmp_path):
    (tmp_path / "bad.nc").write_bytes(b"no netCDF")
    code, out, err = command_line(command, name)
    assert (code, out) == (2, "")
    assert err.startswith(f"Error: {name}: {why}")
    assert err.count("\n") == 1


def test_a_result_and_a_store_become_tables(command_line, undrawn, tmp_path):
    command_line("simulate", "biased-pump", "--periods", "2", "--out", "there")
    code, out, err = command_line("export", "there/simulate.nc")
    assert (code, err) == (0, "")
    assert "wrote there/simulate.time.csv" in out
    assert (tmp_path / "there" / "simulate.time.csv").read_text().startswith("time (ms),displacement (mm),")
    grid = ("--analysis", "limits", "--over", "film_thickness=0.2 mm:0.3 mm:2")
    command_line("sweep", "biased-pump", *grid, "--store", "s.zarr")
    code, out, err = command_line("export", "s.zarr")
    assert (code, err) == (0, "")
    (head, *rows) = (tmp_path / "s.film_thickness.csv").read_text().splitlines()
    assert head.startswith("film_thickness (mm),")
    assert "pull_in_voltage (V)" in head
    assert [row.split(",")[0] for row in rows] == ["0.2", "0.3"]
