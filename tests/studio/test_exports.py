"""What the page saves is, to the last bit, what its command and its Python lines give."""

import functools
import inspect
import re
import shlex
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses.ask import arguments_of
from gelcone.devices.files import shipped_devices
from gelcone.presets import load_presets
from gelcone.register.analyses import find_analysis
from gelcone.studio import exports
from gelcone.studio.grids import Axis, Source
from gelcone.studio.setting import Setting, Shelf, typed

SETTINGS = {
    "device": Setting(
        device="biased-pump",
        values={"frequency": "9.5 Hz", "material.shear_modulus": "9 kPa", "waveform": "triangle", "film": "wrinkling"},
    ),
    "file": Setting(device="own", values={"frequency": "9.5 Hz"}),
    "preset": Setting(preset="base", values={"voltage": "1.04", "displacement": "0.9"}),
}
AXES = defaultdict(tuple) | {
    ("device", "map"): (Axis("voltage_amplitude", "V", [700, 900]), Axis("film_thickness", "mm", [0.19, 0.2, 0.21])),
    ("device", "bifurcation"): (Axis("frequency", "Hz", [9, 9.5, 10]),),
    ("file", "map"): (Axis("voltage_amplitude", "V", [700, 900]), Axis("frequency", "Hz", [9.0, 10.0])),
    ("file", "bifurcation"): (Axis("frequency", "Hz", [9, 9.5, 10]),),
    ("preset", "map"): (Axis("voltage", "", [0.5, 0.6]), Axis("prestretch", "", [1.0, 1.1])),
    ("preset", "bifurcation"): (Axis("voltage", "", [0.5, 0.55, 0.6]),),
}


def saved(setting, wanted, form, shelf):
    path = shelf.path(setting)
    return exports.make(Source(path, setting.file, typed(setting)), wanted, form)


@pytest.mark.parametrize(
    "name", ["simulate", *(pytest.param(n, marks=pytest.mark.slow) for n in ("static", "regime", "map", "bifurcation"))]
)
@pytest.mark.parametrize("kind", SETTINGS)
def test_the_command_and_the_lines_give_the_same_bits(kind, name, command_line, tmp_path, monkeypatch):
    folder = tmp_path / "devices"
    folder.mkdir()
    (folder / "own.toml").write_text(shipped_devices()["biased-pump"].read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    shelf = Shelf(Path("devices/own.toml"))
    wanted = exports.Wanted.read(name, {"periods": 7} if name == "simulate" else {}, AXES[kind, name])
    setting = exports.fitting(SETTINGS[kind], wanted)
    own = tmp_path / "own.nc"
    own.write_bytes(saved(setting, wanted, "nc", shelf))
    expected = gelcone.load(own)

    device = shelf.called(setting)
    code, _, err = command_line(*shlex.split(exports.command(setting, wanted, device))[1:])
    assert code == 0, err
    exec(exports.lines(setting, wanted, device), {})
    for path in (tmp_path / "results", tmp_path):
        found = gelcone.load(path / f"{wanted.analysis.command}.nc")
        assert set(found.data_vars) == set(expected.data_vars)
        for variable in found.variables:
            assert found[variable].values.tobytes() == expected[variable].values.tobytes(), (path, variable)


@pytest.mark.parametrize("name", [name for name in exports.OPTIONS if not exports.OVER.get(name)])
def test_the_lines_give_an_analysis_what_the_command_gives_it(name, monkeypatch):
    shelf, given = Shelf(), {}
    wanted = exports.Wanted.read(name, {"periods": 7} if name == "simulate" else {}, ())
    setting = exports.fitting(SETTINGS["device"], wanted)
    monkeypatch.setattr(gelcone, name, lambda model, **options: given.update(options))
    monkeypatch.setattr(gelcone, "to_si", lambda result, device: result)
    monkeypatch.setattr(gelcone, "save", lambda result, path: None)
    exec(exports.lines(setting, wanted, shelf.called(setting)), {})
    assert given == arguments_of(wanted.analysis, shelf.subject(setting), wanted.given)


@pytest.mark.parametrize("name", ["map", "bifurcation"])
@pytest.mark.parametrize("kind", ["device", "preset"])
def test_the_lines_sweep_what_is_saved(kind, name, monkeypatch):
    """The same target, axes and start, by the lines and by what makes the file."""
    shelf, calls = Shelf(), []
    wanted = exports.Wanted.read(name, {}, AXES[kind, name])
    setting = exports.fitting(SETTINGS[kind], wanted)
    subject = shelf.subject(setting)
    signature = inspect.signature(getattr(gelcone, name))

    @functools.wraps(getattr(gelcone, name))
    def ask(*given, **options):
        calls.append(dict(signature.bind(*given, **options).arguments))
        return "result"

    monkeypatch.setattr(gelcone, name, ask)
    monkeypatch.setattr(gelcone, "to_si", lambda result, device: result)
    monkeypatch.setattr(gelcone, "save", lambda result, path: calls.append((result, path)))
    exec(exports.lines(setting, wanted, shelf.called(setting)), {})
    exports.compute(subject, replace(wanted, analysis=replace(wanted.analysis, call=ask)))
    lines, saved_, made = calls
    assert saved_ == ("result", f"{wanted.analysis.command}.nc")
    assert lines.keys() == {key for key, value in made.items() if value is not None}
    for key, value in lines.items():
        if key == "over":
            assert list(value) == list(made[key])
            for axis in value:
                np.testing.assert_allclose(value[axis], made[key][axis], rtol=1e-12)
        elif isinstance(value, str):
            assert value == made[key]
        elif hasattr(value, "parameters"):
            assert (type(value), value.parameters()) == (type(made[key]), made[key].parameters())
        else:
            np.testing.assert_allclose(np.asarray(value, float), np.asarray(made[key], float), rtol=1e-12)


@pytest.mark.parametrize("kind", SETTINGS)
def test_a_map_on_the_page_is_uniform_and_leaves_out_what_it_sweeps(kind):
    wanted = exports.Wanted.read("map", {}, AXES[kind, "map"])
    setting = exports.fitting(SETTINGS[kind], wanted)
    words = shlex.split(exports.command(setting, wanted, "own.toml"))
    assert words[-3:] == ["--uniform", "--out", "results"]
    assert "--uniform" not in exports.command(setting, exports.Wanted.read("regime", {}, ()), "own.toml")
    swept = {axis.name for axis in AXES[kind, "map"]}
    assert not swept & setting.values.keys()
    assert setting.values.keys() == SETTINGS[kind].values.keys() - swept


def test_a_result_without_a_start_has_neither_a_start_nor_what_it_sweeps():
    wanted = exports.Wanted(find_analysis("tongues"), {}, ("voltage=0:1:3",))
    setting = Setting(preset="base", values={"voltage": "1.04", "displacement": "0.9", "law": "gent"})
    assert exports.fitting(setting, wanted).values == {"law": "gent"}


@pytest.mark.slow
def test_figures_are_files(tmp_path):
    shelf = Shelf()
    wanted = exports.Wanted.read("regime", {}, ())
    assert saved(SETTINGS["device"], wanted, "png", shelf).startswith(b"\x89PNG")
    assert b"<svg" in saved(SETTINGS["device"], wanted, "svg", shelf)[:1000]


def test_the_lines_write_a_number_as_python_reads_it():
    values = {"stretch_limit": "inf", "voltage": "+1e-1", "law": "gent"}
    setting, wanted = (
        Setting(preset="base", values=values),
        exports.Wanted.read("simulate", {"periods": 123.456789}, ()),
    )
    lines = exports.lines(setting, wanted, "")
    given = {}
    exec(lines.partition("result =")[0], given)
    assert (given["model"].stretch_limit, given["model"].voltage) == (float("inf"), 0.1)
    assert "periods=123.456789" in lines
    assert "--periods 123.456789" in exports.command(setting, wanted, "")


@pytest.mark.parametrize("name", ["waveform.duty", "waveform.rise", "film_thickness"])
def test_the_lines_sweep_whatever_the_page_sweeps(name):
    shelf, setting = Shelf(), Setting(device="soft-film", values={"waveform": "square"})
    control = next(control for control in shelf.controls(setting) if control.name == name)
    wanted = exports.Wanted.read("bifurcation", {}, (Axis(name, control.unit, [control.low, control.high]),))
    given = {}
    exec(exports.lines(setting, wanted, "soft-film").partition("result =")[0], given)
    si = 10.0 ** control.powers[control.unit]
    assert given["values"].tolist() == pytest.approx([control.low * si, control.high * si])


PERIODS = [-3, 0, 0.5, 1e300, 501, 10**400, True, None, "9", float("nan"), float("inf"), [20]]


@pytest.mark.parametrize(
    ("name", "options"),
    [("os", {}), ("simulate", {"tolerance": 1}), ("regime", []), *(("simulate", {"periods": p}) for p in PERIODS)],
)
def test_nothing_else_can_be_asked_for(name, options):
    with pytest.raises(gelcone.InputError):
        exports.Wanted.read(name, options, ())


@pytest.mark.parametrize("form", exports.FORMATS)
def test_a_file_holds_what_the_page_shows_in_its_units(form, monkeypatch):
    def written(content, path, **options):
        assert path.name == f"regime.{form}"
        path.write_text(content)

    monkeypatch.setattr(exports, "compute", lambda subject, wanted: f"result of {subject}")
    monkeypatch.setattr(exports, "in_si", lambda result, subject: f"{result} in SI")
    monkeypatch.setattr("gelcone.netcdf.write_netcdf", written)
    monkeypatch.setattr("gelcone.plots.plot", lambda shown: f"figure of {shown}")
    monkeypatch.setattr("gelcone.plots.style.draw_file", written)
    source = SimpleNamespace(subject=lambda: "pump")
    found = exports.make(source, exports.Wanted.read("regime", {}, ()), form).decode()
    assert found == ("result of pump in SI" if form == "nc" else "figure of result of pump in SI")


def test_a_file_has_one_of_three_forms():
    wanted = exports.Wanted.read("regime", {}, ())
    with pytest.raises(gelcone.InputError, match="'exe' is not a format; known: nc, png, svg"):
        exports.make(None, wanted, "exe")


@pytest.mark.parametrize("kind", ["device", "preset"])
def test_the_lines_import_what_they_name(kind):
    lines = exports.lines(SETTINGS[kind], exports.Wanted.read("bifurcation", {}, AXES[kind, "bifurcation"]), "own")
    named = set(re.findall(r"\b(?:gelcone\.presets|gelcone|np)(?=\.)", lines.replace("import gelcone.presets", "")))
    imported = re.findall(r"^import (\S+)(?: as (\S+))?$", lines, re.MULTILINE)
    assert named <= {short or name for name, short in imported}


def test_a_sweep_is_written_with_both_ends_and_the_number_of_its_values():
    assert exports.over_text(Axis("frequency", "Hz", [9.0, 9.25, 9.5])) == "frequency=9 Hz:9.5 Hz:3"
    assert exports.over_text(Axis("voltage", "", [0.0, 2.0])) == "voltage=0:2:2"


@pytest.mark.parametrize("name", sorted(load_presets()))
@pytest.mark.parametrize("values", [{}, {"velocity": "0.25"}, {"voltage": "0.7"}])
def test_command_and_lines_of_a_preset_begin_where_the_page_does(name, values, monkeypatch):
    shelf, given = Shelf(), {}
    wanted = exports.Wanted.read("simulate", {"periods": 3}, ())
    setting = exports.fitting(Setting(preset=name, values=values), wanted)
    monkeypatch.setattr(gelcone, "simulate", lambda model, **options: given.update(options, model=model))
    monkeypatch.setattr(gelcone, "save", lambda result, path: None)
    exec(exports.lines(setting, wanted, ""), {})
    subject = shelf.subject(setting)
    assert tuple(given["initial"]) == tuple(subject.initial)
    assert given["model"].parameters() == subject.model.parameters()
    words = shlex.split(exports.command(setting, wanted, ""))
    assert words[:4] == ["gelcone", "simulate", "--preset", name]
    assert ("--initial" in words) == ("velocity" in values)
