"""Vectors of HDF5 files, also of MATLAB 7.3, up to a largest size.

The bytes are read here, by the published format (HDF5 File Format Specification 3.0): nothing outside the file is
opened, no link is followed, and no library ends the process at a damaged file. Unusual features are refused in one
line.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from gelcone.errors import InputError
from gelcone.quantity import Array

SIGNATURE = b"\x89HDF\r\n\x1a\n"
MOST_VALUES, MOST_NAMES, MOST_PARTS = 2_000_000, 64, 20_000
"""Most values of all vectors of a file, most vectors, and most parts (messages, nodes, chunks)."""
DEEPEST = 16
UNDEFINED = 2**64 - 1
UNPACKED = 64
"""Most bytes that the parts of a file unpack to, over `MOST_VALUES`."""
SPACE, TYPE, OLD_FILL, FILL, LINK_INFO, LINK, EXTERNAL, LAYOUT, FILTERS, ATTRIBUTE, MORE, TABLE = (
    1, 3, 4, 5, 2, 6, 7, 8, 11, 12, 16, 17,
)  # fmt: skip
"""Kinds of messages in the header of an object."""
NUMBER, TEXT, COMPOUND, VARIABLE = 0, 3, 6, 9
"""Classes of types."""
IEEE = {2: (5, 10), 4: (8, 23), 8: (11, 52)}
"""Bits of exponent and mantissa of floating-point numbers, by their bytes."""
DEFLATE, SHUFFLE, CHECKSUM = 1, 2, 3
"""Filters of chunks."""
PLAINLY = "save it for an early version of HDF5 (h5py: libver='earliest'), or as CSV"
UNITS = ("units", "unit", "Units", "Unit")
"""Names of the attribute with the unit of a dataset."""
NO_VARIABLE = "This is a netCDF dimension but not"
"""Beginning of the attribute NAME of a netCDF dimension without values."""
WORDS = ("char", "cell", "logical", "struct", "function_handle", "string")
"""Classes of MATLAB other than numbers."""


class Vector(NamedTuple):
    """A dataset of one dimension: its values, and the unit in an attribute, empty if there is none."""

    values: Array
    unit: str


def vectors_of(data: bytes) -> dict[str, Vector]:
    """Read the vectors of numbers among the datasets of the root of a file, by name.

    Raises `InputError` for links, compound types, values outside the file and files that are too large; `ValueError`,
    `IndexError` or `zlib.error` for a damaged file.
    """
    file = File(data)
    return gathered((name, file.vector(name, address)) for name, address in file.links(file.root))


def gathered(vectors: Iterable[tuple[str, Vector | None]]) -> dict[str, Vector]:
    """Gather the vectors of a file by name, without other data; `InputError` once they are too many."""
    by_name: dict[str, Vector] = {}
    for name, vector in vectors:
        if vector is not None:
            by_name[name] = vector
        if len(by_name) > MOST_NAMES or sum(entry.values.size for entry in by_name.values()) > MOST_VALUES:
            raise too_many()
    return by_name


def too_many() -> InputError:
    """Make the error for a file with too many vectors or values."""
    return InputError(f"has more than {MOST_NAMES} vectors, or more than {MOST_VALUES:.3g} values")


def too_much() -> InputError:
    """Make the error for a file that unpacks to too many bytes."""
    return InputError(f"unpacks to more than {UNPACKED * MOST_VALUES:.3g} bytes; store columns alone")


@dataclass
class File:
    """The bytes of a file; ``base`` is the origin of its addresses, ``parts`` counts the parts read, and ``unpacked``
    the bytes that its chunks unpacked to."""

    data: bytes
    base: int = 0
    parts: int = 0
    unpacked: int = 0
    root: int = field(init=False)

    def __post_init__(self) -> None:
        self.base = next((at for at in (0, 512, 1024, 2048) if self.data[at : at + 8] == SIGNATURE), -1)
        if self.base < 0:
            raise ValueError("no HDF5 file")
        version = self.data[self.base + 8]
        if version in (2, 3):
            sizes, root = self.read(9, 2), 12 + 3 * 8
        else:
            # a symbol table entry of the root begins behind four addresses
            sizes, root = self.read(13, 2), 24 + 4 * 8 + 4 * (version == 1) + 8
        if version > 3 or sizes != b"\x08\x08":
            raise InputError("is of a version of HDF5 that is not read; export it anew, or as CSV")
        self.root = self.number(root, 8)

    def read(self, at: int, size: int) -> bytes:
        """Read bytes at an address; `ValueError` outside the file."""
        self.parts += 1
        if self.parts > MOST_PARTS:
            raise InputError(f"has more than {MOST_PARTS} parts; store each column in one piece")
        begin = self.base + at
        if at < 0 or size < 0 or begin + size > len(self.data):
            raise ValueError("an address outside the file")
        return self.data[begin : begin + size]

    def number(self, at: int, size: int) -> int:
        """Read a whole number at an address."""
        return int.from_bytes(self.read(at, size), "little")

    # --- groups -------------------------------------------------------------------------------------------------------

    def links(self, address: int) -> Iterator[tuple[str, int]]:
        """Names and addresses of the objects of a group; `InputError` for a link to elsewhere."""
        for kind, body in self.messages(address):
            if kind == TABLE:
                tree, heap = (int.from_bytes(body[at : at + 8], "little") for at in (0, 8))
                if self.read(heap, 4) != b"HEAP":
                    raise ValueError("no heap of names")
                yield from self._entries(tree, self.number(heap + 24, 8))
            elif kind == LINK:
                yield _hard_link(body)
            elif kind == LINK_INFO and _dense(body):
                raise InputError("has its names in a heap; store at most 8 datasets in a file, or save it as CSV")

    def _entries(self, tree: int, names: int) -> Iterator[tuple[str, int]]:
        """The entries of a tree of a group, with their ``names`` in the heap."""
        for _, node in self._leaves(tree, 0, 8):
            if self.read(node, 4) != b"SNOD":
                raise ValueError("no entries of a group")
            for k in range(self.number(node + 6, 2)):
                entry = node + 8 + 40 * k
                name = self._name(names + self.number(entry, 8))
                if self.number(entry + 16, 4) == 2:
                    raise _link(name)
                yield name, self.number(entry + 8, 8)

    def _leaves(self, node: int, kind: int, key: int, depth: int = 0) -> Iterator[tuple[bytes, int]]:
        """Keys and addresses of what the nodes of a tree hold at its lowest level."""
        if self.read(node, 4) != b"TREE" or self.number(node + 4, 1) != kind or depth > DEEPEST:
            raise ValueError("no node of a tree")
        lowest = self.number(node + 5, 1) == 0
        for k in range(self.number(node + 6, 2)):
            at = node + 24 + k * (key + 8)
            leaf_key, child = self.read(at, key), self.number(at + key, 8)
            if lowest:
                yield leaf_key, child
            else:
                yield from self._leaves(child, kind, key, depth + 1)

    def _name(self, at: int) -> str:
        left = self.data[self.base + at : self.base + at + 256]
        return left[: left.index(b"\0")].decode()

    # --- headers ------------------------------------------------------------------------------------------------------

    def messages(self, address: int) -> Iterator[tuple[int, bytes]]:
        """The kinds and contents of the messages of an object's header and its continuations."""
        second = self.read(address, 4) == b"OHDR"
        if not second and self.number(address, 1) != 1:
            raise ValueError("no header")
        if second:
            flags = self.number(address + 5, 1)
            at = address + 6 + 16 * bool(flags & 0x20) + 4 * bool(flags & 0x10)
            width = 1 << (flags & 3)
            blocks, head = [(at + width, self.number(at, width))], 4 + 2 * bool(flags & 4)
        else:
            blocks, head = [(address + 16, self.number(address + 8, 4))], 8
        while blocks:
            at, size = blocks.pop(0)
            end = at + size
            while at + head <= end:
                kind, length, flag = self._message(at, second)
                body = self.read(at + head, length)
                at += head + length
                if flag & 2 and kind in (SPACE, TYPE, LAYOUT, FILTERS):
                    raise InputError("shares a type among datasets; save it anew, or as CSV")
                if kind == MORE:
                    more, extent = (int.from_bytes(body[k : k + 8], "little") for k in (0, 8))
                    # those of the second version begin with a signature and end with a checksum
                    blocks.append((more + 4, extent - 8) if second else (more, extent))
                else:
                    yield kind, body

    def _message(self, at: int, second: bool) -> tuple[int, int, int]:
        """Kind, length and flags of a message."""
        wide = 1 if second else 2
        return self.number(at, wide), self.number(at + wide, 2), self.number(at + wide + 2, 1)

    def _attribute(self, body: bytes) -> dict[str, str]:
        """The name and text of an attribute, or the flag of an empty array of MATLAB; empty for any other."""
        version = body[0]
        if version not in (1, 2, 3):
            return {}
        sizes = [int.from_bytes(body[2 + 2 * k : 4 + 2 * k], "little") for k in range(3)]
        at = 8 + (version == 3)
        parts = []
        for size in sizes:
            parts.append(body[at : at + size])
            at += -(-size // 8) * 8 if version == 1 else size
        name, of, _ = parts
        if not of or len(name) > 64:
            return {}
        length, named = int.from_bytes(of[4:8], "little"), name.rstrip(b"\0").decode(errors="replace")
        kind, value = of[0] & 15, body[at : at + min(length, 64)]
        if kind == NUMBER and named == "MATLAB_empty":
            return {named: str(int.from_bytes(value, "little"))}
        if kind == VARIABLE and of[1] & 15 == 1 and named in (*UNITS, "MATLAB_class"):
            value = self._of_heap(*(int.from_bytes(value[k : k + n], "little") for k, n in ((4, 8), (12, 4), (0, 4))))
        elif kind != TEXT:
            return {}
        return {named: value.rstrip(b"\0 ").decode(errors="replace")}

    def _of_heap(self, heap: int, wanted: int, length: int) -> bytes:
        """The first bytes of a text of variable length, an object of a heap."""
        if not length:
            return b""
        if self.read(heap, 4) != b"GCOL":
            raise ValueError("no heap of texts")
        at, end = heap + 16, heap + self.number(heap + 8, 8)
        while at + 16 <= end and (number := self.number(at, 2)):
            size = self.number(at + 8, 8)
            if number == wanted:
                return self.read(at + 16, min(size, length, 64))
            at += 16 + -(-size // 8) * 8
        raise ValueError("a text outside of its heap")

    # --- datasets -----------------------------------------------------------------------------------------------------

    def vector(self, name: str, address: int) -> Vector | None:
        """Read the dataset at an address if it is a vector of real numbers; None for other data and groups."""
        parts: dict[int, bytes] = {}
        texts: dict[str, str] = {}
        for kind, body in self.messages(address):
            if kind == ATTRIBUTE:
                texts |= self._attribute(body)
            else:
                parts.setdefault(kind, body)
        if EXTERNAL in parts:
            raise InputError(f"{name!r} lies in another file, which is not opened; store the values themselves")
        if texts.get("NAME", "").startswith(NO_VARIABLE) or texts.get("MATLAB_empty", "0") != "0":
            return None
        if not {LAYOUT, TYPE, SPACE} <= set(parts) or texts.get("MATLAB_class", "") in WORDS:
            return None
        number, shape = _datatype(parts[TYPE]), _shape(parts[SPACE])
        if parts[TYPE][0] & 15 == COMPOUND:
            raise InputError(f"{name!r} has a compound type; store each column as a dataset of its own")
        size = int(np.prod(np.array(shape, dtype=object)))
        if number is None or size < 2 or size != max(shape):
            return None
        if size > MOST_VALUES:
            raise too_many()
        content = self._content(name, parts, number.itemsize, shape)
        with np.errstate(invalid="ignore"):  # a damaged NaN
            values = np.frombuffer(content, number, size).astype(float)
        return Vector(values, next((texts[key] for key in UNITS if key in texts), ""))

    def _content(self, name: str, parts: Mapping[int, bytes], width: int, shape: list[int]) -> bytes:
        """Read the bytes of all values of a vector."""
        layout, size = parts[LAYOUT], width * max(shape)
        version, kind = layout[0], layout[1]
        if version not in (3, 4):
            raise InputError(f"{name!r} is stored in a way that is not read; {PLAINLY}")
        if kind == 0:
            return layout[4 : 4 + size]
        if kind == 1:
            at = int.from_bytes(layout[2:10], "little")
            return _fill(parts, width) * max(shape) if at == UNDEFINED else self.read(at, size)
        if kind != 2 or version == 4:
            raise InputError(f"{name!r} is stored in a way that is not read; {PLAINLY}")
        rank, tree = layout[2], int.from_bytes(layout[3:11], "little")
        sides = [int.from_bytes(layout[11 + 4 * k : 15 + 4 * k], "little") for k in range(rank)]
        if rank != len(shape) + 1 or min(sides) < 1 or max(sides[:-1]) > MOST_VALUES:
            raise ValueError("chunks of another shape")
        filters = _filters(name, parts.get(FILTERS, b""))
        content, along = bytearray(_fill(parts, width) * max(shape)), int(np.argmax(shape))
        whole = width * int(np.prod(np.array(sides[:-1], dtype=object)))
        if whole > width * MOST_VALUES:
            raise too_many()
        if tree != UNDEFINED:
            for key, at in self._leaves(tree, 1, 8 + 8 * rank):
                first = int.from_bytes(key[8 + 8 * along : 16 + 8 * along], "little")
                packed = self.read(at, int.from_bytes(key[:4], "little"))
                skipped = int.from_bytes(key[4:8], "little")
                self.unpacked += whole
                if self.unpacked > UNPACKED * MOST_VALUES:
                    raise too_much()
                chunk = _unpacked(packed, filters, skipped, width, whole)
                # of a vector one side of a chunk lies along it, and the others begin with its only row
                values = np.frombuffer(chunk, f"V{width}").reshape(sides[:-1])
                row = values[tuple(slice(None) if k == along else 0 for k in range(len(shape)))]
                last = min(first + len(row), max(shape))
                content[first * width : last * width] = row[: max(last - first, 0)].tobytes()
        return bytes(content)


def _link(name: str) -> InputError:
    shown = "".join(c if c.isprintable() else "?" for c in name)[:60]
    return InputError(f"{shown!r} is a link, which is not followed; store the values themselves")


def _hard_link(body: bytes) -> tuple[str, int]:
    """Name and address of a link message; `InputError` for a link to a name or another file."""
    flags, at = body[1], 2
    kind = body[at] if flags & 8 else 0
    at += bool(flags & 8) + 8 * bool(flags & 4) + bool(flags & 16)
    width = 1 << (flags & 3)
    length = int.from_bytes(body[at : at + width], "little")
    at += width
    name = body[at : at + length].decode()
    if kind:
        raise _link(name)
    return name, int.from_bytes(body[at + length : at + length + 8], "little")


def _dense(body: bytes) -> bool:
    """Whether the links of a group stand in a heap."""
    at = 2 + 8 * (body[1] & 1)
    return int.from_bytes(body[at : at + 8], "little") != UNDEFINED


def _datatype(body: bytes) -> np.dtype[Any] | None:
    """The type of stored numbers; None for other data."""
    kind, size = body[0] & 15, int.from_bytes(body[4:8], "little")
    order = ">" if body[1] & 1 else "<"
    whole = int.from_bytes(body[10:12], "little") == 8 * size and not body[1] & 0x40
    if kind == 0 and size in (1, 2, 4, 8) and whole:
        return np.dtype(f"{order}{'i' if body[1] & 8 else 'u'}{size}")
    if kind == 1 and IEEE.get(size) == (body[13], body[15]) and whole:
        return np.dtype(f"{order}f{size}")
    return None


def _shape(body: bytes) -> list[int]:
    """The sides of a dataset; one side of 1 for a single value."""
    at = 8 if body[0] == 1 else 4
    sides = [int.from_bytes(body[at + 8 * k : at + 8 * k + 8], "little") for k in range(body[1])]
    return sides or [1]


def _fill(parts: Mapping[int, bytes], width: int) -> bytes:
    """The fill value of data that was never written; 0 if none is stated."""
    body = parts.get(FILL, b"")
    if not body:
        old = parts.get(OLD_FILL, b"")
        body = b"\3\x20" + old if old else b"\3\0"
    stated, at = (body[1] & 0x20, 2) if body[0] == 3 else (body[0] == 1 or body[3], 4)
    size = int.from_bytes(body[at : at + 4], "little") if stated else 0
    if size in (0, 0xFFFFFFFF):
        return bytes(width)
    value = body[at + 4 : at + 4 + size]
    if size != width or len(value) != width:
        raise ValueError("a fill value of another size")
    return value


def _filters(name: str, body: bytes) -> list[int]:
    """The filters of a dataset's chunks, in the order of packing."""
    if not body:
        return []
    version, count = body[0], body[1]
    at, filters = 8 if version == 1 else 2, []
    for _ in range(count):
        kind = int.from_bytes(body[at : at + 2], "little")
        named = version == 1 or kind >= 256
        length = int.from_bytes(body[at + 2 : at + 4], "little") if named else 0
        values = int.from_bytes(body[at + 4 + 2 * named : at + 6 + 2 * named], "little")
        if kind not in (DEFLATE, SHUFFLE, CHECKSUM):
            raise InputError(f"{name!r} is packed by filter {kind}, which is not read; store it with gzip or unpacked")
        filters.append(kind)
        at += 6 + 2 * named + (-(-length // 8) * 8 if version == 1 else length) + 4 * values
        at += 4 * (version == 1 and values % 2)
    return filters


def _unpacked(packed: bytes, filters: list[int], skipped: int, width: int, whole: int) -> bytes:
    """Unpack a chunk of ``whole`` bytes by its filters, except those in the bit mask ``skipped``."""
    content = packed
    for k in reversed(range(len(filters))):
        if skipped & 1 << k:
            continue
        if filters[k] == CHECKSUM:
            content = content[:-4]
        elif filters[k] == DEFLATE:
            content = zlib.decompressobj().decompress(content, whole + 8)
        else:
            rows = np.frombuffer(content[: len(content) // width * width], np.uint8).reshape(width, -1)
            content = np.ascontiguousarray(rows.T).tobytes()
    if len(content) < whole:
        raise ValueError("a chunk is shorter than its values")
    return content[:whole]
