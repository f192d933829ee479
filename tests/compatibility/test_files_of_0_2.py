"""Files that version 0.2 wrote (`write_0_2.py` made them with it): each still reads, is shown and drawn."""

import tarfile
from pathlib import Path

import pytest

import gelcone
from gelcone.earlier import with_names_of_today

ARCHIVE = Path(__file__).parent / "0.2.tar.xz"
SHOWN = {
    "basin": "meridional slack",
    "bifurcation": "no change of regime",
    "envelope": "  pull-in ",
    "extrema": "turning points",
    "frequency": "swept up",
    "limits": "constant voltage at which",
    "lyapunov": "exponent",
    "map": "cells",
    "operating-limits": "quasi-static limit",
    "regime": "meridional slack",
    "section": "section",
    "settled": "stroke of the settled motion",
    "simulate": "displacement",
    "spectrum": "spectrum",
    "static": "equilibrium at",
    "static-pair": "equilibri",
    "sweep": "cells",
    "tongues": "own frequency",
}
"""A word that `gelcone show` prints of each file."""
RENAMED = {
    "regime": {"chaotic_until"},
    "map": {"chaotic_until"},
    "bifurcation": {"chaotic_until"},
    "envelope": {"constant_voltage", "peak_voltage", "operating_peak_voltage", "operating_frequency"},
    "tongues": {"operating_onset_voltage", "operating_onset_kind", "operating_searched"},
    "spectrum": {"aliasing_bound"},
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written by 0.2")
    with tarfile.open(ARCHIVE) as packed:
        packed.extractall(folder, filter="data")
    return folder


def test_no_result_in_the_archive_is_left_out(written):
    assert {path.stem for path in written.iterdir()} == set(SHOWN)


@pytest.mark.parametrize("name", SHOWN)
def test_a_result_is_read_shown_and_drawn(written, name, command_line):
    result = gelcone.load(written / f"{name}.nc")
    assert result.attrs["gelcone_version"] == "0.2.0"
    assert RENAMED.get(name, set()) <= {*result.variables}
    assert "driven_peak" not in result.sizes
    assert gelcone.plot(result).axes
    code, out, err = command_line("show", str(written / f"{name}.nc"))
    assert code == 0, err
    assert SHOWN[name] in out


def test_the_curves_of_an_envelope_are_over_the_constant_voltage_and_its_motions_over_the_peak(written):
    result = gelcone.load(written / "envelope.nc")
    assert result["static_displacement"].dims == ("constant_voltage",)
    assert result["driven_stroke"].dims == ("drive_frequency", "peak_voltage")
    assert float(result["operating_peak_voltage"]) == pytest.approx(1800.0)


def test_the_voltage_of_a_run_behind_a_circuit_is_the_films(written):
    """0.2 wrote the voltage on the film as the drive's; with an ideal source both are one."""
    result = gelcone.load(written / "simulate.nc")
    assert {"drive_voltage"} == {*result.variables} & {"drive_voltage", "film_voltage"}
    old = result.assign_attrs(model=result.attrs["model"].replace('"circuit": "ideal"', '"circuit": "amplifier"'))
    read = with_names_of_today(old)
    assert {"film_voltage"} == {*read.variables} & {"drive_voltage", "film_voltage"}
    assert read["film_voltage"].equals(result["drive_voltage"].rename("film_voltage"))
    today = old.assign_attrs(gelcone_version=gelcone.__version__)
    assert with_names_of_today(today) is today


def test_the_pull_in_of_a_run_is_that_of_the_film(written):
    ends = {f"{film}pull_in_{end}": ((), 2.0) for film in ("", "second_") for end in ("displacement", "voltage")}
    read = with_names_of_today(gelcone.load(written / "simulate.nc").assign(ends))
    for film in ("", "second_"):
        assert {f"{film}pull_in_displacement", f"{film}pull_in_film_voltage"} <= {*read.variables}
        assert f"{film}pull_in_voltage" not in read
    assert "pull_in_voltage" in gelcone.load(written / "limits.nc")
