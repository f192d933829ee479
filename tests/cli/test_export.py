"""`gelcone export`: devices as C, results as tables."""

import zipfile
from pathlib import Path

import pytest

from gelcone.cli import export as command
from gelcone.export.public import OF_DEVICE


def test_a_device_is_written_as_c(command_line, tmp_path):
    code, out, _ = command_line("export", "biased-pump", "pump", "--film", "taut", "--set", "spring_rate=16 N/m")
    assert code == 0
    assert [line for line in out.splitlines() if "pump.c" in line]
    assert "16 N/m" in (tmp_path / "pump" / "device.toml").read_text()
    assert "test.c are a program each: compile one with the device, as its first lines say" in out
    for program in ("example", "test"):
        first = (tmp_path / "pump" / f"{program}.c").read_text().partition("#include")[0]
        assert f"cc -std=c99 -O2 -ffp-contract=off {program}.c pump.c" in first
    code, _, err = command_line("export", "biased-pump", "pump", "--film", "taut")
    assert (code, "exists already" in err) == (2, True)


def test_a_device_is_written_as_an_fmu(command_line, tmp_path):
    typed = ("export", "biased-pump", "pump.fmu", "--film", "taut", "--fmi", "3", "--drive", "sine")
    assert command_line(*typed)[0] == 0
    text = zipfile.ZipFile(tmp_path / "pump.fmu").read("modelDescription.xml").decode()
    assert 'fmiVersion="3.0"' in text
    assert 'name="frequency"' in text


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (("biased-pump",), "biased-pump: is a device; say where it goes, to NAME.fmu, NAME.wasm or a folder for C"),
        (("mine.toml", "mine.fmu"), "no such file"),
        (("biased-pump", "pump.c"), "pump.c: a device is written to NAME.fmu, NAME.wasm or a folder for C"),
        (("biased-pump", "pump.csv"), "pump.csv: a device is written to NAME.fmu"),
        (("no-such-device", "pump"), "no such file"),
        (
            ("biased-pump", "pump.fmu", "--film", "taut", "--platforms", "macos-arm"),
            "Error: --platforms 'macos-arm': has no place in FMI 2.0; give fmi = 3",
        ),
        (("biased-pump", "pump", "--film", "taut", "--drive", "square"), "is not a drive"),
        (("biased-pump", "pump", "--film", "taut", "--tolerance", "2"), "tolerance"),
        (("biased-pump", "pump", "--film", "taut", "--tolerance", "0"), "tolerance"),
        (("biased-pump", "pump.fmu", "--film", "taut", "--fmi", "0"), "must be 2 or 3"),
        (("biased-pump", "pump.fmu", "--film", "taut", "--fmi", "4"), "must be 2 or 3"),
        (
            ("biased-pump", "pump", "--fmi", "3", "--platforms", "linux"),
            "Error: --fmi 3: belongs to an FMU, and pump is none; leave it out, or write to NAME.fmu",
        ),
        (("biased-pump", "pump.wasm", "--platforms", "linux"), "Error: --platforms linux: belongs to an FMU"),
        (("no-such.nc",), "no such file"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(command_line, tmp_path, typed, words):
    code, _, err = command_line("export", *typed)
    assert code == 2
    assert words in err
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "pump").exists()


@pytest.mark.parametrize(
    ("there", "what", "of_device"),
    [
        ("biased-pump/pump.c", "biased-pump", True),
        ("biased-pump/zarr.json", "biased-pump", False),
        ("results/simulate.nc", "results", False),
        ("results/simulate.nc", "results/simulate.nc", False),
        ("mine.toml", "mine.toml", True),
        ("mine", "mine", True),
        (None, "biased-pump", True),
        (None, "no-such-device", True),
        (None, "no-such.nc", False),
    ],
)
def test_what_is_exported_is_a_file_of_a_result_a_store_or_a_device(there, what, of_device, command_line, monkeypatch):
    """A folder that an export to C has made with a device's name leaves the name to the device."""
    if there:
        Path(there).parent.mkdir(exist_ok=True)
        Path(there).write_text("")
    for name in ("_of_device", "_of_result"):
        monkeypatch.setattr(command, name, lambda *given, name=name: [name])
    assert command_line("export", what, "a.fmu")[1] == f"wrote {'_of_device' if of_device else '_of_result'}\n"


def test_a_result_takes_no_options_of_devices(command_line, undrawn):
    assert command_line("static", "--preset", "base", "--out", "there")[0] == 0
    for typed in (
        ("--drive", "sine"), ("--tolerance", "-1"), ("--fmi", "9"), ("--platforms", "host,linux"),
        ("--film", "taut"), ("--set", "spring_rate=1 N/m"),
    ):  # fmt: skip
        code, _, err = command_line("export", "there/static.nc", *typed)
        assert (code, err.rstrip().endswith(f": {OF_DEVICE}")) == (2, True)
        assert err.startswith(f"Error: {typed[0]} "), err
        assert typed[1] in err
    code, out, _ = command_line("export", "there/static.nc")
    assert code == 0
    assert "static.csv" in out
    code, _, err = command_line("export", "there/static.nc", "static.fmu")
    assert (code, "static.fmu" in err, ".parquet" in err) == (2, True, True)


@pytest.mark.parametrize(
    ("typed", "written"),
    [
        ((), "there/run.csv"), (("there/run.mat",), "there/run.mat"), (("tables/other.csv",), "tables/other.csv"),
        (("tables/run.parquet", "--force"), "tables/run.parquet"),
    ],
)  # fmt: skip
def test_the_files_of_a_result_lie_next_to_it_or_where_it_was_said(typed, written, command_line, monkeypatch):
    asked = []
    monkeypatch.setattr(command, "load", lambda place: f"result of {place}")
    monkeypatch.setattr(command, "export", lambda *given, **how: asked.append((*given, how)) or [given[1]])
    assert command_line("export", "there/run.nc", *typed) == (0, f"wrote {written}\n", "")
    assert asked == [("result of there/run.nc", Path(written), {"force": "--force" in typed})]
