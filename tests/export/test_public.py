"""What `export` writes: every option reaches its writer, files are whole, and what cannot leave is refused."""

import inspect
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.errors import DoubtfulInput, InputError
from gelcone.export import public
from gelcone.export.compiler import find_compiler
from tests.export.instance import STRICT, device

compiles = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")


@pytest.fixture(scope="module")
def taut():
    return device(film="taut")


OPTIONS = {"fmi": (2, 3), "platforms": (("host",), ["linux"]), "drive": (None, "own"), "tolerance": (1e-7, 1e-9)}
"""Option -> its default and another value."""


@pytest.fixture
def asked(monkeypatch):
    """What is asked of those that write."""
    calls = []
    for name in ("write_fmu", "write_wasm", "_write_c"):
        real = inspect.signature(getattr(public, name))

        def ask(*given, name=name, real=real):
            calls.append((name, real.bind(*given).arguments))
            return [Path("there")]

        monkeypatch.setattr(public, name, ask)
    return calls


def described(call):
    name, given = call
    own = given["exported"]
    found = {"writer": name, "name": own.name, "drive": own.inside, "tolerance": own.tolerance, "force": given["force"]}
    found["path"] = given.get("path", given.get("folder"))
    return found | {n: given[n] for n in ("fmi", "platforms") if n in given}


@pytest.mark.parametrize(("path", "writer"), [("a.fmu", "write_fmu"), ("a.wasm", "write_wasm"), ("a", "_write_c")])
@pytest.mark.parametrize("option", [None, *OPTIONS, "force"])
def test_every_option_of_an_export_reaches_its_writer(path, writer, option, asked, taut, tmp_path):
    if writer != "write_fmu" and option in ("fmi", "platforms"):
        with pytest.raises(InputError, match=f"{option} = .*: belongs to an FMU, and {path} is none; leave it out, or"):
            gelcone.export(taut, tmp_path / path, **{option: OPTIONS[option][1]})
        assert asked == []
        return
    values = {n: usual for n, (usual, _) in OPTIONS.items()}
    changed = {} if option is None else {option: True if option == "force" else OPTIONS[option][1]}
    gelcone.export(taut, tmp_path / path, **changed)
    wanted = values | {"force": False} | changed
    wanted["drive"] = wanted["drive"] is not None
    if writer != "write_fmu":
        del wanted["fmi"], wanted["platforms"]
    assert described(asked.pop()) == wanted | {"writer": writer, "name": "a", "path": tmp_path / path}


def test_a_result_is_written_as_was_asked(monkeypatch, tmp_path):
    import xarray as xr

    asked, result = [], xr.Dataset()
    monkeypatch.setattr(public.interchange, "export", lambda *given, **how: asked.append((given, how)) or ["there"])
    for force in (False, True):
        assert gelcone.export(result, tmp_path / "run.csv", force=force) == ["there"]
        ((what, path), how) = asked.pop()
        assert (what is result, path, how) == (True, tmp_path / "run.csv", {"force": force})


@pytest.mark.parametrize("name", ["a.h", "a.c", "example.c", "test.c", "device.toml"])
def test_files_of_a_folder_are_not_overwritten(name, taut, tmp_path, monkeypatch):
    monkeypatch.setattr(public, "sources", lambda exported: {"a.h": "", "a.c": ""})
    for own in ("example", "test_program"):
        monkeypatch.setattr(public, own, lambda exported: "")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / name).write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(taut, tmp_path / "a")
    assert [path.read_text() for path in (tmp_path / "a").iterdir()] == ["mine"]
    assert len(gelcone.export(taut, tmp_path / "a", force=True)) == 5


@compiles
@pytest.mark.parametrize(
    ("drive", "waveform"), [(None, "sine"), ("sine", "sine"), ("own", "trapezoid"), ("own", "harmonics")]
)
def test_the_folder_holds_programs_that_run(tmp_path, drive, waveform):
    own = device(film="taut", waveform=waveform)
    paths = gelcone.export(own, tmp_path / "My Pump", drive=drive)
    assert [path.name for path in paths] == ["my_pump.h", "my_pump.c", "example.c", "test.c", "device.toml"]
    folder = tmp_path / "My Pump"
    assert gelcone.Device.from_toml(folder / "device.toml") == own
    printed = {}
    for name in ("example", "test"):
        command = [*find_compiler(), *STRICT, "-O1", f"{name}.c", "my_pump.c", "-lm", "-o", name]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        printed[name] = subprocess.run([f"./{name}"], cwd=folder, capture_output=True, text=True, check=True).stdout
    assert printed["test"] == "20 of 20 steps with the bits of gelcone\n"
    rows = np.loadtxt(printed["example"].splitlines()[1:], delimiter=",")
    assert rows.shape == (1000, 4)
    right = gelcone.simulate(own, times=rows[:250, 0])
    assert rows[:, 0] == pytest.approx(1e-3 * np.arange(1, 1001), rel=1e-12)
    volts = right.drive_voltage if drive is None else right.get("film_voltage", right.drive_voltage)
    assert rows[:250, 1] == pytest.approx(volts.values, abs=1e-5)
    for column, name in ((2, "displacement"), (3, "current")):
        wanted = 1e-3 * right[name].values
        # the current of a chord is that of the drive in the middle of its millisecond
        assert np.abs(rows[:250, column] - wanted).max() < {2: 5e-4, 3: 0.05}[column] * np.ptp(wanted)
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(own, folder)
    gelcone.export(own, folder, force=True)


def test_a_title_cannot_end_a_comment(tmp_path):
    own = device().replace(film="taut", name="a */ int main(void) { return 1; } /* ??/ \\")
    gelcone.export(own, tmp_path / "pump")
    text = (tmp_path / "pump" / "pump.h").read_text()
    assert text.splitlines()[0].count("*/") == 0
    assert "int main(void) { return 1; }" in text.splitlines()[0]


@pytest.mark.parametrize(
    ("changes", "options", "match"),
    [
        ({"film_thickness": [1.9e-4, 2e-4]}, {}, "export: takes one actuator, not an ensemble of 2"),
        ({"waveform": "triangle"}, {"drive": "sine"}, "give drive = 'own'"),
        ({"waveform": "half_wave"}, {"drive": "own"}, "its corners move with the voltage"),
        ({"waveform": "chirp"}, {"drive": "own"}, "cannot be exported"),
        ({}, {"drive": "square"}, "is not a drive"),
        ({}, {"tolerance": 0.0}, "tolerance"),
        ({}, {"fmi": 4, "name": "pump.fmu"}, "fmi = 4: must be 2 or 3"),
        ({}, {"name": "pump.csv"}, r"pump\.csv: a device is written to NAME\.fmu, NAME\.wasm or a folder for C"),
        ({}, {"name": "..."}, "holds no letter"),
    ],
)
def test_what_cannot_leave_is_refused_with_the_remedy(tmp_path, changes, options, match):
    options = dict(options)
    with pytest.raises(InputError, match=match):
        gelcone.export(device(film="taut", **changes), tmp_path / options.pop("name", "pump"), **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", OPTIONS)
def test_a_result_takes_no_option_of_devices(option, tmp_path):
    value = OPTIONS[option][1]
    with pytest.raises(InputError) as refused:
        gelcone.export(gelcone.static(gelcone.ConeModel(), [0.0]), tmp_path / "a.csv", **{option: value})
    assert str(refused.value) == f"{option} = {value!r}: {public.OF_DEVICE}"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["My Pump 7.fmu", "My Pump 7.wasm", "My Pump 7"])
def test_the_model_has_the_name_of_its_file_in_c(path, asked, taut, tmp_path):
    gelcone.export(taut, tmp_path / path)
    assert described(asked.pop())["name"] == "my_pump_7"


@pytest.mark.parametrize(("drive", "inside"), [(None, False), ("own", True), ("sine", True)])
def test_a_sine_is_inside_by_either_name(drive, inside, asked, taut, tmp_path):
    gelcone.export(taut, tmp_path / "a", drive=drive)
    assert described(asked.pop())["drive"] == inside


def test_a_file_that_exists_is_found_before_anything_is_compiled(asked, taut, tmp_path):
    (tmp_path / "a.fmu").write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(taut, tmp_path / "a.fmu")
    assert asked == []
    assert gelcone.export(taut, tmp_path / "a.fmu", force=True) == [tmp_path / "a.fmu"]


def test_an_fmu_without_libraries_is_written_with_a_warning(taut, tmp_path, monkeypatch):
    monkeypatch.setattr(public, "write_fmu", lambda *given: False)
    with pytest.warns(DoubtfulInput, match="a.fmu: holds sources only, for there is no C compiler here"):
        assert gelcone.export(taut, tmp_path / "a.fmu") == [tmp_path / "a.fmu"]
    monkeypatch.setattr(public, "write_fmu", lambda *given: True)
    gelcone.export(taut, tmp_path / "a.fmu")
