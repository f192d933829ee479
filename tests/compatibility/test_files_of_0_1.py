"""Files that version 0.1 wrote (`write.py` made them with it): each still reads, or is refused with one clear line."""

import json
import shutil
import tarfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import gelcone

ARCHIVE = Path(__file__).parent / "0.1.tar.xz"
NUMBERS = {
    "simulate": {"damping_ratio": 0.05, "spring_stiffness": 0.5, "voltage": 1.04, "drive_frequency": 0.3},
    "simulate-ensemble": {"voltage": [0.5, 1.5], "drive_frequency": 0.3, "stretch_limit": 50.0},
    "simulate-device": {"voltage_bias": 0.40330555834493903, "meridional_prestretch": 1.1, "hoop_prestretch": 1.4},
    "simulate-yeoh": {"yeoh_c2": 0.02, "yeoh_c3": 0.001, "voltage": 0.5},
    "simulate-film": {"voltage": 0.5, "prestretch": 1.0},
    "section": {"voltage": 0.9, "drive_frequency": 1.0},
    "lyapunov": {"voltage": 0.9, "drive_frequency": 1.0},
    "regime": {"voltage": [0.2, 0.9]},
    "map": {"voltage": [[0.3] * 3, [0.9] * 3], "prestretch": [[0.8, 1.0, 1.2]] * 2},
    "bifurcation": {"voltage": [0.3, 0.9]},
    "static": {"rest_height": 0.3, "voltage": 0.5},
}
"""Some parameters of the model behind each file."""
REMEDIES = ("choose another store", "use that version", "install")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written by 0.1")
    with tarfile.open(ARCHIVE) as packed:
        packed.extractall(folder, filter="data")
    return folder


@pytest.fixture(scope="module")
def kept(written):
    """A result by the name of its file, read once."""
    return cache(lambda name: gelcone.load(written / f"{name}.nc"))


def test_no_result_in_the_archive_is_left_out(written):
    assert {path.stem for path in written.glob("*.nc")} == set(NUMBERS)
    assert {path.name for path in written.iterdir() if path.suffix != ".nc"} == {
        "film.json",
        "map.zarr",
        "interrupted.zarr",
    }


@pytest.mark.parametrize("name", NUMBERS)
def test_a_result_reads_and_knows_its_model(kept, name):
    result = kept(name)
    assert result.attrs["gelcone_version"] == "0.1.0"
    if name == "simulate-film":
        with pytest.raises(gelcone.InputError, match="take film = membrane, the same") as refused:
            gelcone.model_of(result)
        assert "\n" not in str(refused.value)
        return
    parameters = gelcone.model_of(result).parameters()
    for parameter, number in NUMBERS[name].items():
        np.testing.assert_array_equal(parameters[parameter], number, err_msg=parameter)


@pytest.mark.parametrize("name", ["simulate", "simulate-ensemble", "simulate-device", "simulate-yeoh"])
def test_the_model_of_a_result_moves_as_it_did(kept, name):
    """The numbers of 0.1 again: the law and the parameters came through whole."""
    before = kept(name)
    length = 1e3 * gelcone.find_device("biased-pump").scales.length if name == "simulate-device" else 1.0
    now = gelcone.simulate(gelcone.model_of(before), before["initial"].values, times=np.linspace(0.0, 4.0, 5))
    np.testing.assert_allclose(length * now["displacement"], before["displacement"], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_result_is_drawn_or_refused_in_one_line(kept, name):
    try:
        assert gelcone.plot(kept(name)).axes
    except gelcone.InputError as error:
        message = str(error)
        assert "of gelcone 0.1.0 lacks what its figure draws" in message
        assert "compute it again" in message
        assert "\n" not in message


def test_a_result_in_si_units_keeps_them(kept):
    result = kept("simulate-device")
    assert result["displacement"].attrs["units"] == "mm"
    assert result["drive_voltage"].attrs["units"] == "V"


def test_an_exponent_keeps_its_number(kept):
    exponents = kept("lyapunov")
    assert float(exponents["finite"][0] + exponents["finite"][1]) == pytest.approx(-0.1, abs=1e-9)


def test_a_fitted_film_is_refused_in_one_line(written, command_line):
    code, out, err = command_line("simulate", "--film", written / "film.json")
    assert (code, out) == (2, "")
    assert "is a fitted film of gelcone 0.1 or 0.2, which is not read any more; take film = membrane" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(("name", "held"), [("map.zarr", (16, 4)), ("interrupted.zarr", (6, 0))])
@pytest.mark.parametrize("command", [("show",), ("map", "--resume")])
def test_a_store_reads_or_is_refused_in_one_line(command_line, written, tmp_path, name, held, command):
    store = tmp_path / name
    shutil.copytree(written / name, store)
    code, out, err = command_line(*command, store, "--json")
    if code == 0:
        answer = json.loads(out)
        assert answer["totals"]["cells"] == 20
        status = np.array(answer["status"])
        assert ((status == 1).sum(), (status == 2).sum()) == held if command == ("show",) else (status > 0).all()
        return
    message = err.strip()
    assert len(message.splitlines()) == 1, message
    assert "0.1.0" in message
    assert any(remedy in message for remedy in REMEDIES), message
    assert contents(store) == contents(written / name)


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
