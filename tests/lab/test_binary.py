"""Vectors of MATLAB files, and damaged ones."""

import warnings

import numpy as np
import pytest
from scipy.io import savemat

from gelcone.errors import InputError
from gelcone.lab import binary
from gelcone.lab.reading import read_table

VOLTS, STROKE = np.array([500.0, 1000.0, 1500.0]), np.array([0.1, 0.5, 1.3])


def matlab(folder, compressed=False, **more):
    columns = {
        "voltage_kV": VOLTS / 1e3,
        "stroke_mm": STROKE[:, None],
        "name": "pump",
        "both": np.eye(2),
        "z": VOLTS * 1j,
    }
    savemat(folder / "stroke.mat", columns | more, do_compression=compressed)
    return folder / "stroke.mat"


@pytest.mark.parametrize("compressed", [False, True])
def test_vectors_of_a_matlab_file_are_columns_with_the_units_of_their_names(compressed, tmp_path):
    table = read_table(matlab(tmp_path, compressed, count=np.array([1, 2, 3], dtype=np.int16)))
    assert {name: column.unit for name, column in table.columns.items()} == {
        "voltage": "kV",
        "stroke": "mm",
        "count": None,
    }
    np.testing.assert_array_equal(table.columns["stroke"].values, STROKE)
    assert table.notes == ("read as MATLAB",)


def test_files_without_even_vectors_are_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"its vectors have several lengths \(voltage_kV 3, stroke_mm 3, more 4\)"):
        read_table(matlab(tmp_path, more=np.arange(4.0)))
    savemat(tmp_path / "words.mat", {"name": "pump"})
    with pytest.raises(InputError, match="has no vectors of numbers"):
        read_table(tmp_path / "words.mat")
    monkeypatch.setattr(binary, "MOST_VALUES", 5)
    with pytest.raises(InputError, match=r"has more than 64 vectors, or more than 2e\+06 values"):
        read_table(matlab(tmp_path))


def refusal(path):
    """Why a file is refused; empty if it is read."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read_table(path)
        except InputError as error:
            return str(error)
    return ""


@pytest.mark.parametrize("compressed", [False, True])
def test_damaged_files_are_one_line(compressed, tmp_path):
    path = matlab(tmp_path, compressed)
    whole, rng, refused = path.read_bytes(), np.random.default_rng(0), 0
    for k in range(100):
        damaged = bytearray(whole[: rng.integers(1, len(whole))] if k % 2 else whole)
        for at in rng.integers(0, len(damaged), 8):
            damaged[at] = rng.integers(256)
        path.write_bytes(bytes(damaged))
        reason = refusal(path)
        refused += bool(reason)
        assert "\n" not in reason
        assert not reason or reason.startswith(path.name)
    assert refused > 50
