"""``result.gelcone`` does what the functions of the same names do, and costs ``import gelcone`` nothing."""

import subprocess
import sys

import pytest
import xarray as xr

import gelcone


@pytest.fixture
def result():
    return gelcone.simulate(gelcone.ConeModel(voltage=0.7), times=[0.0, 1.0, 2.0])


def test_the_methods_are_the_functions(result, tmp_path):
    device = gelcone.find_device("paper-table1")
    assert result.gelcone.model.parameters() == gelcone.ConeModel(voltage=0.7).parameters()
    xr.testing.assert_identical(result.gelcone.to_si(device), gelcone.to_si(result, device))
    result.gelcone.save(tmp_path / "a.nc")
    again = gelcone.load(tmp_path / "a.nc")
    xr.testing.assert_identical(again, result)
    drawn = again.gelcone.plot().axes[0].lines[0].get_ydata()
    assert drawn.tolist() == result["displacement"].values.tolist()


def test_an_existing_file_is_kept_unless_forced(result, tmp_path):
    result.gelcone.save(tmp_path / "a.nc")
    with pytest.raises(gelcone.InputError, match="exists already"):
        result.gelcone.save(tmp_path / "a.nc")
    result.gelcone.save(tmp_path / "a.nc", force=True)


def test_a_device_is_saved_as_a_device_file(tmp_path):
    device = gelcone.find_device("biased-pump").replace(film_thickness="0.25 mm")
    gelcone.save(device, tmp_path / "mine.toml")
    assert gelcone.find_device(tmp_path / "mine.toml") == device
    with pytest.raises(gelcone.InputError, match="exists already"):
        gelcone.save(device, tmp_path / "mine.toml")
    with pytest.raises(gelcone.InputError, match="was given a dict; give a result of an analysis, or a device"):
        gelcone.save({}, tmp_path / "other.toml")


LOADED = (
    "import sys, gelcone, gelcone.plots; "
    "print(*(name for name in ('xarray', 'matplotlib', 'llvmlite') if name in sys.modules)); "
    "gelcone.load(sys.argv[1]).gelcone.model"
)


def test_importing_gelcone_and_its_plots_loads_neither_xarray_nor_matplotlib(result, tmp_path):
    result.gelcone.save(tmp_path / "a.nc")
    done = subprocess.run(
        [sys.executable, "-c", LOADED, str(tmp_path / "a.nc")], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == ""
