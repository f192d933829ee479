"""netCDF files: the same objects, attributes and numbers that xarray writes and reads with h5netcdf."""

import h5py
import numpy as np
import pytest
import xarray as xr

from gelcone.netcdf import read_netcdf, write_netcdf

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


def contents(path):
    """Everything that a file holds by name: shapes, types, values, attributes with their types, and attached dims."""

    def attribute(part, name):
        kind, value = part.attrs.get_id(name).dtype, part.attrs[name]
        if name == "DIMENSION_LIST":
            value = [[part.file[reference].name for reference in scales] for scales in value]
        if name == "REFERENCE_LIST":
            value = sorted((part.file[reference].name, int(place)) for reference, place in value)
        return repr((name, str(kind), value))

    with h5py.File(path) as file:
        parts = {name: (part.shape, part.dtype, part.maxshape, repr(part[()])) for name, part in file.items()}
        return parts | {
            f"{name} attributes": sorted(attribute(part, key) for key in part.attrs)
            for name, part in {**file, "/": file}.items()
        }


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    write_netcdf(DATASET, folder / "own.nc")
    DATASET.to_netcdf(folder / "xarray.nc", engine="h5netcdf")
    return folder


def test_a_file_holds_what_xarray_writes(files):
    own, other = contents(files / "own.nc"), contents(files / "xarray.nc")
    assert list(own) == list(other)
    for name in own:
        assert own[name] == other[name], name


@pytest.mark.parametrize("name", ["own.nc", "xarray.nc"])
def test_a_file_is_read_as_xarray_reads_it(files, name):
    found = read_netcdf(files / name)
    with xr.open_dataset(files / name, engine="h5netcdf") as dataset:
        expected = dataset.load()
    xr.testing.assert_identical(found, expected)
    xr.testing.assert_identical(found, DATASET)
    assert list(found.data_vars) == list(DATASET.data_vars)
    types = {key: type(value) for part in [found, *found.variables.values()] for key, value in part.attrs.items()}
    assert types == {key: type(v) for part in [expected, *expected.variables.values()] for key, v in part.attrs.items()}


def test_what_was_read_is_written_again(files, tmp_path):
    write_netcdf(read_netcdf(files / "own.nc"), tmp_path / "again.nc")
    xr.testing.assert_identical(read_netcdf(tmp_path / "again.nc"), DATASET)
