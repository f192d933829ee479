"""Vectors of MATLAB files, and damaged ones."""

import struct
import warnings
import zlib

import numpy as np
import pytest
from scipy.io import savemat

from gelcone.devices import binary, hdf5, reading
from gelcone.devices.reading import read_table
from gelcone.errors import InputError

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
    monkeypatch.setattr(hdf5, "MOST_VALUES", 5)
    with pytest.raises(InputError, match=r"has more than 64 vectors, or more than 5 values"):
        read_table(matlab(tmp_path))


def test_columns_of_a_binary_file_have_the_names_and_sizes_of_those_of_a_text(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="has two columns of one name with different units"):
        read_table(matlab(tmp_path, voltage_V=VOLTS))
    table = read_table(matlab(tmp_path, huge=VOLTS * 1e20))
    assert table.columns["huge"].values is None
    with pytest.raises(InputError, match=r"stroke.mat: column 'huge' holds 5e\+22; give numbers of at most 1e\+20"):
        table.numbers("huge", "force")
    monkeypatch.setattr(reading, "LONGEST_WORD", 6)
    with pytest.raises(InputError, match=r"column 1 is named 'vol\.\.\.'; give it at most 6 letters"):
        read_table(matlab(tmp_path))


def test_a_file_that_unpacks_to_much_more_is_refused(tmp_path, monkeypatch):
    """Though what it unpacks to is left out."""
    monkeypatch.setattr(binary, "UNPACKED", 0)
    with pytest.raises(InputError, match="unpacks to more than"):
        read_table(matlab(tmp_path, compressed=True))


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


def element(kind, data, order):
    return struct.pack(f"{order}II", kind, len(data)) + data + bytes(-len(data) % 8)


def matrix(name, values, order="<", flags=6, stored=9, shape=None):
    """A matrix of a MATLAB file by its format; of other types than numbers with another ``stored`` type."""
    values = np.asarray(values, dtype=f"{order}{binary.STORED.get(stored, 'f8')}")
    dims = np.array(shape or (values.size, 1), dtype=f"{order}i4").tobytes()
    parts = ((6, struct.pack(f"{order}II", flags, 0)), (5, dims), (1, name.encode()), (stored, values.tobytes()))
    return element(14, b"".join(element(kind, data, order) for kind, data in parts), order)


@pytest.mark.parametrize(("order", "mark"), [("<", b"IM"), (">", b"MI")])
def test_files_of_either_order_of_bytes_and_of_any_type_of_number_are_read(order, mark, tmp_path):
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(f"{order}H", 0x0100) + mark
    bodies = [matrix(f"t{stored}_mm", [1, 2], order, stored=stored) for stored in binary.STORED]
    (tmp_path / "own.mat").write_bytes(head + b"".join(bodies))
    table = read_table(tmp_path / "own.mat")
    assert list(table.columns) == [f"t{stored}" for stored in binary.STORED]
    for column in table.columns.values():
        assert (column.values.tolist(), column.unit) == ([1.0, 2.0], "mm")


def vectors(data):
    return hdf5.gathered(binary._matlab(data))


def test_what_is_no_vector_of_real_numbers_is_left_out():
    """Two numbers are one; a row is one as a column is; other classes, complex numbers and squares are not."""
    head = b"MATLAB".ljust(126) + b"IM"
    parts = [
        matrix("row", [1.0, 2.0, 3.0], shape=(1, 3)), matrix("pair", [1.0, 2.0]), matrix("one", [1.0]),
        matrix("words", [1.0, 2.0], flags=4), matrix("imaginary", [1.0, 2.0], flags=6 | 0x0800),
        matrix("square", np.arange(4.0), shape=(2, 2)), matrix("odd", [1.0, 2.0], stored=18),
        matrix("logical", [1.0, 2.0], flags=15), matrix("beyond", [1.0, 2.0], flags=16),
    ]  # fmt: skip
    found = vectors(head + b"".join(parts))
    assert {name: vector.values.tolist() for name, vector in found.items()} == {
        "row": [1.0, 2.0, 3.0], "pair": [1.0, 2.0], "logical": [1.0, 2.0],
    }  # fmt: skip
    compressed = element(15, zlib.compress(matrix("small", [3.0, 4.0])), "<").rstrip(b"\0")
    packed = zlib.compress(matrix("small", [3.0, 4.0]))
    compressed = struct.pack("<II", 15, len(packed)) + packed
    both = vectors(head + compressed + matrix("after", [5.0, 6.0]))
    assert {name: vector.values.tolist() for name, vector in both.items()} == {"small": [3.0, 4.0], "after": [5.0, 6.0]}


def test_as_many_vectors_and_values_are_read_as_are_allowed(monkeypatch):
    head = b"MATLAB".ljust(126) + b"IM"
    both = head + matrix("a", [1.0, 2.0]) + matrix("b", [1.0, 2.0])
    monkeypatch.setattr(hdf5, "MOST_NAMES", 2)
    monkeypatch.setattr(hdf5, "MOST_VALUES", 4)
    assert list(vectors(both)) == ["a", "b"]
    monkeypatch.setattr(hdf5, "MOST_NAMES", 1)
    with pytest.raises(InputError):
        vectors(both)
    monkeypatch.setattr(hdf5, "MOST_NAMES", 2)
    monkeypatch.setattr(hdf5, "MOST_VALUES", 3)
    with pytest.raises(InputError):
        vectors(both)


def test_lengths_are_shown_of_four_vectors(tmp_path):
    columns = {name: np.arange(float(k + 2)) for k, name in enumerate("abcde")}
    savemat(tmp_path / "own.mat", columns)
    with pytest.raises(InputError, match=r"several lengths \(a 2, b 3, c 4, d 5\); store one test in a file"):
        read_table(tmp_path / "own.mat")


@pytest.mark.parametrize(
    ("name", "column", "unit"),
    [("stress_kPa", "stress", "kPa"), ("wet_stress_kPa", "wet_stress", "kPa"), ("_mm", "_mm", None),
     ("stress_wet", "stress_wet", None), ("mm", "mm", None)],
)  # fmt: skip
def test_a_unit_is_what_follows_the_last_underscore_of_a_name_that_is_left(name, column, unit):
    values = np.array([1.0, 2.0])
    assert binary._unit_of(name, values, "") == (column, (values, unit))
    assert binary._unit_of(name, values, "N") == (name, (values, "N"))
