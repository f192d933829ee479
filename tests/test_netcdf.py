"""netCDF files: read back as they were, or refused where they are not what was written."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.errors import InputError
from gelcone.netcdf import CHECKSUM, read_netcdf, write_netcdf

DATASET = xr.Dataset(
    {
        "force": (("place", "time"), np.arange(6.0).reshape(2, 3), {"units": "N", "long_name": "force"}),
        "single": (("time",), np.array([1.0, np.nan, 2.0], np.float32)),
        "kind": (("place", "state"), np.ones((2, 2), np.int8), {"flag_values": np.array([0, 1], np.int8)}),
        "stable": (("place",), np.array([True, False])),
        "name": (("place",), np.array(["rest", "größer"])),
        "word": ((), "one"),
        "count": ((), np.int64(7), {"weight": 0.5, "order": 3}),
        "events": (("event", "state"), np.empty((0, 2))),
        "phase": (("time",), np.array([1.0 + 2.0j, 0.0, 1j]).real),
    },
    coords={
        "time": ("time", [0.0, 0.5, 1.0], {"units": "s"}),
        "voltage": ("place", [1.0, 2.0]),
        "frequency": ((), 3.0),
    },
    attrs={"title": "all kinds", "options": "{}", "totals": np.array([1, 2])},
)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "all.nc"
    write_netcdf(DATASET, path)
    return path


def test_what_is_written_reads_back_equal(file, tmp_path):
    found = read_netcdf(file)
    xr.testing.assert_identical(found, DATASET)
    assert list(found.data_vars) == list(DATASET.data_vars)
    assert {name: v.dtype for name, v in found.items()} == {name: v.dtype for name, v in DATASET.items()}
    write_netcdf(found, tmp_path / "again.nc")
    xr.testing.assert_identical(read_netcdf(tmp_path / "again.nc"), DATASET)


def test_other_tools_read_it_and_see_the_checksum(file):
    with xr.open_dataset(file) as found:
        assert len(found.attrs[CHECKSUM]) == 32
        xr.testing.assert_equal(found.load(), DATASET)


def test_a_flipped_bit_is_found_wherever_it_changes_what_is_read(file, tmp_path):
    """HDF5 keeps open what it cannot read, and would read another file of its inode as it was: a file for each."""
    whole = file.read_bytes()
    numbers = whole.index(np.arange(6.0).tobytes())
    for place in {numbers + 13, whole.index(b"force") + 1, *range(7, len(whole), len(whole) // 150)}:
        changed = bytearray(whole)
        changed[place] ^= 0x10
        damaged = tmp_path / f"damaged-{place}.nc"
        damaged.write_bytes(changed)
        try:
            found = gelcone.load(damaged)
        except InputError as error:
            assert damaged.name in str(error)  # noqa: PT017
            continue
        found.attrs = {name: value for name, value in found.attrs.items() if name in DATASET.attrs}
        assert place != numbers + 13
        xr.testing.assert_identical(found, DATASET)


def test_a_changed_number_or_attribute_does_not_match_the_checksum(file, tmp_path):
    stored = xr.load_dataset(file)
    for changed in (
        stored.assign(force=stored["force"] * 1.5),
        stored.assign_attrs(title="another"),
        stored.assign(force=stored["force"].assign_attrs(units="mN")),
        stored.assign(name=("place", ["rest", "grosser"])),
        stored.drop_vars("single"),
    ):
        changed.to_netcdf(tmp_path / "changed.nc")
        with pytest.raises(InputError, match="do not match its checksum"):
            gelcone.load(tmp_path / "changed.nc")
        (tmp_path / "changed.nc").unlink()


def test_a_file_without_a_checksum_is_read(tmp_path):
    DATASET.to_netcdf(tmp_path / "older.nc")
    xr.testing.assert_identical(gelcone.load(tmp_path / "older.nc"), DATASET)


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit of file sizes")
@pytest.mark.parametrize(
    ("name", "write", "reason"),
    [
        ("result.nc", "gelcone.save", "File too large"),
        ("result.svg", "lambda r, path: save_figure(r.gelcone.plot(), path)", "File too large"),
    ],
)
def test_a_full_disk_is_one_line_and_leaves_no_half_file(tmp_path, name, write, reason):
    """A limit of 8 kB stands for a disk that fills up."""
    path = tmp_path / name
    code = f"""
import resource, signal, gelcone
from gelcone.plots.style import save_figure
r = gelcone.simulate(gelcone.ConeModel(voltage=0.5), periods=5)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
try:
    ({write})(r, {str(path)!r})
except gelcone.InputError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"{path}: cannot be written ({reason}); free some space or choose another folder\n"
    assert list(tmp_path.iterdir()) == []
