"""Vectors of HDF5 files and of MATLAB 7.3, what is refused, and damaged files."""

import random
import time
import warnings
import zlib

import netCDF4
import numpy as np
import pytest

from gelcone.devices import binary, hdf5
from gelcone.devices.hdf5 import UNDEFINED, _dense, _hard_link
from gelcone.devices.reading import read_table
from gelcone.errors import InputError
from tests.devices.hdf5_files import PACKED, unpacked

VOLTS, FORCES = np.array([0.5, 1.0, 1.5, 2.0, 2.5]), np.array([1.0, 2.0, 4.0, 8.0, 16.0])


@pytest.fixture
def stored(tmp_path):
    """Writes a file of `PACKED`, or other bytes."""

    def write(name, content=None):
        (tmp_path / name).write_bytes(unpacked(name) if content is None else content)
        return tmp_path / name

    return write


@pytest.mark.parametrize("name", ["plain.h5", "chunks.h5", "latest.h5", "user.h5"])
def test_datasets_are_columns_with_the_units_of_attributes_and_names(name, stored):
    table = read_table(stored(name))
    columns = {own: (column.unit, column.values.tolist()) for own, column in table.columns.items()}
    wanted = {"voltage": ("kV", VOLTS.tolist()), "force": ("mN", FORCES.tolist()), "count": (None, [0, 1, 2, 3, 4])}
    assert columns == wanted
    assert table.notes == ("read as HDF5",)


def test_vectors_of_matlab_73_are_columns_and_its_words_are_not(stored):
    table = read_table(stored("matlab.mat"))
    assert {name: column.unit for name, column in table.columns.items()} == {"voltage": "kV", "stroke": "mm"}
    np.testing.assert_array_equal(table.columns["stroke"].values, FORCES)
    assert table.notes == ("read as MATLAB",)


def test_a_file_of_netcdf_is_one_of_hdf5(tmp_path):
    with netCDF4.Dataset(tmp_path / "own.h5", "w") as file:
        file.createDimension("row", 5)
        for name, values in (("voltage_kV", VOLTS), ("force", FORCES)):
            file.createVariable(name, "f8", ("row",))[:] = values
        file["force"].units = "mN"
    table = read_table(tmp_path / "own.h5")
    np.testing.assert_array_equal(table.columns["voltage"].values, VOLTS)
    assert table.columns["force"].unit == "mN"


def test_units_of_variable_length_are_read_and_dimensions_are_no_columns(tmp_path):
    with netCDF4.Dataset(tmp_path / "own.h5", "w") as file:
        file.createDimension("row", 5)
        for name, values, unit in (("voltage", VOLTS, "kV"), ("force", FORCES, "mN")):
            file.createVariable(name, "f8", ("row",))[:] = values
            file[name].setncattr_string("units", unit)
    table = read_table(tmp_path / "own.h5")
    assert {name: column.unit for name, column in table.columns.items()} == {"voltage": "kV", "force": "mN"}


@pytest.mark.parametrize("chunks", [None, [2]])
def test_what_was_never_written_has_the_fill_value(chunks, tmp_path):
    with netCDF4.Dataset(tmp_path / "own.h5", "w") as file:
        file.createDimension("row", 5)
        file.createVariable("voltage_kV", "f8", ("row",), fill_value=-7.5, chunksizes=chunks, contiguous=chunks is None)
        if chunks:
            file["voltage_kV"][:2] = [1.0, 2.0]
    content = (tmp_path / "own.h5").read_bytes()
    ((values, _),) = hdf5.vectors_of(content).values()
    assert values.tolist() == ([1.0, 2.0] if chunks else [-7.5] * 2) + [-7.5] * 3


def test_fill_values_of_all_versions():
    value, size = np.array(-7.5).tobytes(), bytes([8, 0, 0, 0])
    for parts in (
        {5: bytes([1, 2, 2, 0]) + size + value}, {5: bytes([2, 2, 2, 1]) + size + value},
        {5: bytes([3, 0x20]) + size + value}, {4: size + value},
    ):  # fmt: skip
        assert hdf5._fill(parts, 8) == value
    for parts in ({}, {5: bytes([2, 2, 2, 0])}, {5: bytes([3, 0x0A])}, {5: bytes([2, 2, 2, 1, 0, 0, 0, 0])}):
        assert hdf5._fill(parts, 8) == bytes(8)


def test_empty_arrays_of_matlab_are_no_columns():
    name, of, space = b"MATLAB_empty\0", bytes([0x10, 0, 0, 0, 1, 0, 0, 0, 0, 0, 8, 0]), bytes([2, 0, 0, 0])
    sizes = b"".join(len(part).to_bytes(2, "little") for part in (name, of, space))
    body = bytes([3, 0]) + sizes + b"\0" + name + of + space + b"\1"
    file = hdf5.File(unpacked("matlab.mat"))
    whole = file.messages
    file.messages = lambda address: [*whole(address), (hdf5.ATTRIBUTE, body)]
    assert [file.vector(own, at) for own, at in file.links(file.root)] == [None] * len(list(file.links(file.root)))


def test_chunks_that_unpack_to_too_much_are_refused(stored, monkeypatch):
    monkeypatch.setattr(hdf5, "MOST_VALUES", 20)
    monkeypatch.setattr(hdf5, "UNPACKED", 2)
    with pytest.raises(InputError, match="unpacks to more than 40 bytes"):
        read_table(stored("chunks.h5"))


def test_a_chunk_that_reaches_beyond_the_values_adds_none(stored, monkeypatch):
    """Of five values in chunks of two: what a file can take is bounded by what it says that it holds."""
    read, lengths = hdf5.File._content, []

    def measured(file, name, parts, width, shape):
        content = read(file, name, parts, width, shape)
        lengths.append(len(content) == width * max(shape))
        return content

    monkeypatch.setattr(hdf5.File, "_content", measured)
    read_table(stored("chunks.h5"))
    assert lengths == [True] * 3


def test_a_dataset_without_values_is_zero(stored):
    assert read_table(stored("filled.h5")).columns["empty"].values.tolist() == [0.0] * 5


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("soft.h5", "'alias' is a link, which is not followed; store the values themselves"),
        ("external.h5", "'other' is a link, which is not followed; store the values themselves"),
        ("external-latest.h5", "'other' is a link, which is not followed; store the values themselves"),
        ("raw.h5", "'secret' lies in another file, which is not opened; store the values themselves"),
        ("virtual.h5", "'v' is stored in a way that is not read; save it for an early version of HDF5"),
        ("compound.h5", "'t' has a compound type; store each column as a dataset of its own"),
        ("huge.h5", "has more than 64 vectors, or more than 2e+06 values"),
        ("chunk.h5", "is damaged, or no MATLAB or HDF5 file; export it again, or as CSV"),
        ("lzf.h5", "is packed by filter 32000, which is not read; store it with gzip or unpacked"),
        ("heap.h5", "has its names in a heap; store at most 8 datasets in a file, or save it as CSV"),
        ("words.h5", "has no vectors of numbers; store each column as a vector"),
    ],
)
def test_what_is_not_read_is_refused_in_one_line(name, message, stored, monkeypatch):
    opened = []
    monkeypatch.setattr(
        "builtins.open", lambda path, *given, **named: opened.append(path) or OPEN(path, *given, **named)
    )
    with pytest.raises(InputError) as refused:
        read_table(stored(name))
    assert message in str(refused.value)
    assert str(refused.value).startswith(f"{name}: ")
    assert "\n" not in str(refused.value)
    assert {str(path) for path in opened} == {str(stored(name))}


OPEN = open


def test_files_of_many_parts_and_values_are_refused(stored, monkeypatch):
    monkeypatch.setattr(hdf5, "MOST_PARTS", 20)
    with pytest.raises(InputError, match="has more than 20 parts; store each column in one piece"):
        read_table(stored("chunks.h5"))
    monkeypatch.setattr(hdf5, "MOST_PARTS", 20_000)
    monkeypatch.setattr(hdf5, "MOST_VALUES", 12)
    with pytest.raises(InputError, match="or more than 12 values"):
        read_table(stored("plain.h5"))
    monkeypatch.setattr(hdf5, "MOST_VALUES", 2_000_000)
    monkeypatch.setattr(hdf5, "MOST_NAMES", 2)
    with pytest.raises(InputError, match="has more than 2 vectors"):
        read_table(stored("plain.h5"))


@pytest.mark.parametrize("name", sorted(PACKED))
def test_a_damaged_file_is_read_or_refused_in_one_line(name, stored):
    rng, whole = random.Random(name), unpacked(name)
    path = stored(f"damaged.{name.partition('.')[2]}", whole)
    begun, refused = time.process_time(), []
    for _ in range(120):
        broken = bytearray(whole)
        for _ in range(rng.choice((1, 1, 2, 8))):
            broken[rng.randrange(len(broken))] = rng.choice((0, 1, 2, 7, 128, 255, rng.randrange(256)))
        if rng.random() < 0.2:
            del broken[rng.randrange(len(broken)) :]
        path.write_bytes(bytes(broken))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                read = [values.size for values, _ in binary.read_vectors(path, path.name, "").values()]
            except InputError as error:
                read = []
                refused.append(str(error))
        assert max(read, default=0) <= hdf5.MOST_VALUES
    assert not any("\n" in said for said in refused)
    assert time.process_time() - begun < 60.0


@pytest.mark.parametrize("flags", [0, 1, 2, 3])
@pytest.mark.parametrize("heap", [4096, UNDEFINED])
def test_links_stand_in_a_heap_where_the_message_has_its_address(flags, heap):
    """Version, flags, the largest creation index where bit 0 says so, and the address of the heap."""
    index = (7).to_bytes(8, "little") if flags & 1 else b""
    body = bytes([0, flags]) + index + heap.to_bytes(8, "little") + (5).to_bytes(8, "little")
    assert _dense(body) is (heap != UNDEFINED)


@pytest.mark.parametrize("flags", [0, 1, 4, 8, 16, 28, 30])
def test_a_hard_link_has_its_name_behind_what_its_flags_say(flags):
    """Kind, creation order, character set; then the length of the name in 1, 2, 4 or 8 bytes. A soft one is refused."""
    name, width = b"stress", 1 << (flags & 3)
    for kind in (0, 1) if flags & 8 else (0,):
        body = bytes([1, flags]) + (bytes([kind]) if flags & 8 else b"") + (b"\1" * 8 if flags & 4 else b"")
        body += (
            (b"\0" if flags & 16 else b"") + len(name).to_bytes(width, "little") + name + (800).to_bytes(8, "little")
        )
        if kind:
            with pytest.raises(InputError, match="'stress' is a link, which is not followed"):
                _hard_link(body)
        else:
            assert _hard_link(body) == ("stress", 800)


@pytest.mark.parametrize("skipped", range(8))
def test_a_chunk_is_unpacked_by_the_filters_that_it_was_packed_with(skipped):
    """Shuffled, deflated, with a checksum behind; each but for those of the mask."""
    filters, content = [hdf5.SHUFFLE, hdf5.DEFLATE, hdf5.CHECKSUM], VOLTS.tobytes()
    packed = content
    if not skipped & 1:
        packed = np.frombuffer(packed, np.uint8).reshape(-1, 8).T.tobytes()
    if not skipped & 2:
        packed = zlib.compress(packed)
    if not skipped & 4:
        packed += b"sum!"
    assert hdf5._unpacked(packed, filters, skipped, 8, len(content)) == content
    with pytest.raises(ValueError, match="shorter than its values"):
        hdf5._unpacked(packed, filters, skipped, 8, len(content) + 8)


@pytest.mark.parametrize("size", [1, 2, 4, 8])
@pytest.mark.parametrize(("flags", "order", "kind"), [(0, "<", "u"), (8, "<", "i"), (1, ">", "u"), (9, ">", "i")])
def test_whole_numbers_have_their_sign_order_and_size(size, flags, order, kind):
    body = bytes([0x10, flags, 0, 0]) + size.to_bytes(4, "little") + bytes([0, 0]) + (8 * size).to_bytes(2, "little")
    assert hdf5._datatype(body) == np.dtype(f"{order}{kind}{size}")
    few = body[:10] + (8 * size - 1).to_bytes(2, "little")
    assert hdf5._datatype(few) is None  # of some bits


def header(*messages):
    """A file that is nothing but the header of an object, of the first version: kind, flags and content of messages."""
    parts = [
        kind.to_bytes(2, "little") + len(body).to_bytes(2, "little") + bytes([flag, 0, 0, 0]) + body
        for kind, flag, body in messages
    ]
    size = sum(map(len, parts))
    file = object.__new__(hdf5.File)
    file.data = bytes([1, 0, len(parts), 0, 1, 0, 0, 0]) + size.to_bytes(4, "little") + bytes(4) + b"".join(parts)
    file.base = file.parts = file.unpacked = 0
    return file


def test_nothing_is_read_before_or_behind_a_file():
    file = header((hdf5.TYPE, 0, b"12345678"))
    size = len(file.data)
    assert (file.read(size - 3, 3), file.read(0, 1), file.read(size, 0)) == (b"678", b"\1", b"")
    for at, count in ((size - 3, 4), (size, 1), (-1, 1), (0, -1), (2**63, 8)):
        with pytest.raises(ValueError, match="an address outside the file"):
            file.read(at, count)
    file.base = 4  # addresses count from there
    assert file.read(size - 7, 3) == b"678"
    with pytest.raises(ValueError, match="outside"):
        file.read(size - 7, 4)


@pytest.mark.parametrize("kind", [hdf5.SPACE, hdf5.TYPE, hdf5.LAYOUT, hdf5.FILTERS])
def test_what_datasets_share_is_refused_and_shared_attributes_are_passed_over(kind):
    own = [(kind, 0, b"12345678"), (hdf5.ATTRIBUTE, 2, b"87654321")]
    assert list(header(*own).messages(0)) == [(kind, b"12345678"), (hdf5.ATTRIBUTE, b"87654321")]
    with pytest.raises(InputError, match="shares a type among datasets; save it anew, or as CSV"):
        list(header((kind, 2, b"12345678")).messages(0))


def test_values_in_the_header_itself_stand_behind_their_size():
    """The compact layout; of another version or kind a dataset is refused."""
    content = VOLTS.tobytes()
    layout = bytes([3, 0]) + len(content).to_bytes(2, "little") + content + b"more"
    file = header()
    assert file._content("x", {hdf5.LAYOUT: layout}, 8, [5]) == content
    for other in (bytes([2, 0]), bytes([4, 2]), bytes([3, 3])):
        with pytest.raises(InputError, match="'x' is stored in a way that is not read; save it for an early version"):
            file._content("x", {hdf5.LAYOUT: other + layout[2:]}, 8, [5])


@pytest.mark.parametrize(("across", "refused"), [(4, False), (5, True)])
def test_chunks_of_more_values_than_are_read_are_refused_however_short_the_vector(across, refused, monkeypatch):
    """Five values in one row, in chunks of ``across`` rows of five; none was ever written."""
    monkeypatch.setattr(hdf5, "MOST_VALUES", 20)
    sides = b"".join(side.to_bytes(4, "little") for side in (across, 5, 8))
    layout = {hdf5.LAYOUT: bytes([3, 2, 3]) + hdf5.UNDEFINED.to_bytes(8, "little") + sides}
    if refused:
        with pytest.raises(InputError, match="more than 20 values"):
            header()._content("x", layout, 8, [1, 5])
    else:
        assert header()._content("x", layout, 8, [1, 5]) == bytes(40)


@pytest.mark.parametrize("flags", [0, 1])
@pytest.mark.parametrize("version", [1, 2])
def test_filters_are_read_behind_one_another_in_either_version(version, flags):
    """The first gives each a name, padded, and pads an odd number of values; the second neither to those of HDF5."""
    body = bytes([version, 3]) + (bytes(6) if version == 1 else b"")
    for kind, values in ((hdf5.SHUFFLE, 1), (hdf5.DEFLATE, 2), (hdf5.CHECKSUM, 0)):
        name = b"shuffle\0more\0" if kind == hdf5.SHUFFLE else b""
        body += kind.to_bytes(2, "little") + (len(name).to_bytes(2, "little") if version == 1 else b"")
        body += flags.to_bytes(2, "little") + values.to_bytes(2, "little")
        if version == 1:
            body += name + bytes(-len(name) % 8)
        body += bytes(4 * values) + bytes(4 * (version == 1 and values % 2))
    assert hdf5._filters("x", body) == [hdf5.SHUFFLE, hdf5.DEFLATE, hdf5.CHECKSUM]
    assert hdf5._filters("x", b"") == []
    other = bytes([2, 1]) + (32000).to_bytes(2, "little") + bytes(6)
    with pytest.raises(InputError, match="'x' is packed by filter 32000, which is not read"):
        hdf5._filters("x", other)
