"""What the page saves is, to the last bit, what its command and its Python lines give."""

import shlex

import pytest
import xarray as xr

import gelcone
from gelcone.studio import exports
from gelcone.studio.grids import Source
from gelcone.studio.setting import Setting, Shelf, typed

SETTINGS = {
    "device": Setting(device="biased-pump", values={"frequency": "9.5 Hz", "material.shear_modulus": "9 kPa"}),
    "preset": Setting(preset="base", values={"voltage": "1.04", "displacement": "0.9"}),
}


def saved(setting, wanted, form, shelf):
    path = shelf.path(setting)
    return exports.make(Source(None if path is None else str(path), typed(setting)), wanted, form)


@pytest.mark.parametrize("name", ["simulate", *(pytest.param(n, marks=pytest.mark.slow) for n in ("static", "regime"))])
@pytest.mark.parametrize("kind", SETTINGS)
def test_the_command_and_the_lines_give_the_same_bits(kind, name, command_line, tmp_path, monkeypatch):
    setting, shelf = SETTINGS[kind], Shelf()
    wanted = exports.Wanted.read(name, {"periods": 7} if name == "simulate" else {}, ())
    own = tmp_path / "own.nc"
    own.write_bytes(saved(setting, wanted, "nc", shelf))
    shelf.close()
    expected = gelcone.load(own)

    code, _, err = command_line(*shlex.split(exports.command(setting, wanted))[1:])
    assert code == 0, err
    xr.testing.assert_identical(gelcone.load(tmp_path / "results" / f"{wanted.analysis.command}.nc"), expected)

    exec(exports.lines(setting, wanted), {})
    by_lines = gelcone.load(tmp_path / f"{wanted.analysis.command}.nc")
    for variable in by_lines.variables:
        if by_lines[variable].attrs.get("quantity") == "state":
            continue  # `to_si` leaves states as they are
        assert by_lines[variable].values.tobytes() == expected[variable].values.tobytes(), variable
    assert by_lines.data_vars


@pytest.mark.slow
def test_figures_are_files(tmp_path):
    shelf = Shelf()
    wanted = exports.Wanted.read("regime", {}, ())
    assert saved(SETTINGS["device"], wanted, "png", shelf).startswith(b"\x89PNG")
    assert b"<svg" in saved(SETTINGS["device"], wanted, "svg", shelf)[:1000]
    shelf.close()


@pytest.mark.parametrize(
    ("name", "options"), [("os", {}), ("simulate", {"tolerance": 1}), ("simulate", {"periods": "9"}), ("regime", [])]
)
def test_nothing_else_can_be_asked_for(name, options):
    with pytest.raises(gelcone.InputError):
        exports.Wanted.read(name, options, ())
