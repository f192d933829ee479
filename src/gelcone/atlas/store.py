"""Results of a sweep on disk while it runs: a Zarr group that is never half written and can be gone on with.

The group's attributes hold the plan. Each variable is an array over the plan's axes, cut into tiles; ``status`` says of
every cell whether it is there, and is written after the rest of a tile. So what ``status`` tells of is whole whenever
the run ends; a tile that is all NaN is written like any other. Every tile carries a checksum.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError, MissingDependency

TILE_CELLS = 16384
"""Cells of a tile at most; a tile is as wide along each axis."""
PLAN = "gelcone_plan"
COMPRESSION = 3


class Status(IntEnum):
    """What is known of a cell."""

    MISSING = 0
    COMPUTED = 1
    INFERRED = 2


STATUS_ATTRIBUTES = {
    "long_name": "what is known of the cell",
    "units": "1",
    "flag_values": [status.value for status in Status],
    "flag_meanings": " ".join(status.name.lower() for status in Status),
}


@dataclass(frozen=True)
class Field:
    """A variable of all cells: names of its own dims, values (cells, ...), attributes."""

    dims: tuple[str, ...]
    values: npt.NDArray[Any]
    attributes: Mapping[str, Any]


class Store:
    """A sweep's results in a folder; `open_store` makes one and keeps other runs out."""

    def __init__(self, path: Path, plan: dict[str, Any], dims: tuple[str, ...], shape: tuple[int, ...]) -> None:
        self.path, self.plan, self.dims, self.shape = path, plan, dims, shape
        self.tile = _tile(shape)

    def read(self) -> dict[str, Field]:
        """The fields as far as they are there, ``status`` among them; empty before the first.

        Raises `InputError` for a tile that is gone, cut short or changed.
        """
        for name in _consolidated(self.path):
            if not (self.path / name / "zarr.json").is_file():
                raise _damaged(self.path, f"its array {name} is gone")
        group = _open_group(self.path)
        names = sorted(group.array_keys())
        if "status" not in names:
            return {}
        arrays = {name: group[name] for name in names if name not in self.dims and not name.startswith("drawn_")}
        if any(array.shape[: len(self.shape)] != self.shape for array in arrays.values()):
            raise _damaged(self.path, "its arrays do not have the shape of its plan")
        self.tile = tuple(arrays["status"].chunks)
        status = self._read_whole("status", arrays["status"])
        written = [tile for tile in self._tiles() if status[tile].any()]
        for name, array in arrays.items():
            for tile in written:
                if not self._chunk_path(name, tile, array.ndim).exists():
                    raise _damaged(self.path, f"a tile of {name} is gone")
        return {name: self._field(name, array) for name, array in arrays.items()}

    def _field(self, name: str, array: Any) -> Field:
        dims = tuple(array.metadata.dimension_names[len(self.shape) :])
        values = self._read_whole(name, array)
        return Field(dims, values.reshape(-1, *values.shape[len(self.shape) :]), dict(array.attrs))

    def _read_whole(self, name: str, array: Any) -> npt.NDArray[Any]:
        try:
            return np.asarray(array[...])
        except Exception as error:  # whatever a codec makes of damaged bytes
            raise _damaged(self.path, f"a tile of {name} cannot be read: {_line(error)}") from None

    def begin(self, fields: Mapping[str, Field], coordinates: Mapping[str, Field]) -> None:
        """Makes the arrays, ``status`` last: where it is, the others are."""
        group = _open_group(self.path, mode="r+")
        for name, field in coordinates.items():
            _create(group, name, field.values.shape, field.values.shape, field, field.dims)[...] = field.values
        for name in sorted(fields, key=lambda name: name == "status"):
            field = fields[name]
            own = field.values.shape[1:]
            _create(group, name, self.shape + own, self.tile + own, field, self.dims + field.dims)
        _consolidate(self.path)

    def write(self, fields: Mapping[str, Field], cells: npt.NDArray[np.intp]) -> None:
        """Writes the tiles that the cells lie in, of all fields, ``status`` last.

        Raises `InputError` where the disk is full or not writable: what was written before is not touched by it.
        """
        places = np.unravel_index(cells, self.shape)
        tiles = np.unique([place // width for place, width in zip(places, self.tile, strict=True)], axis=1).T
        names = sorted(fields, key=lambda name: name == "status")
        # Else a tile that holds what stands for nothing would not be written, and look like one that got lost.
        with _import_zarr().config.set({"array.write_empty_chunks": True}):
            group = _open_group(self.path, mode="r+")
            arrays = {name: group[name] for name in names}
        for tile in tiles:
            part = tuple(slice(int(k) * w, (int(k) + 1) * w) for k, w in zip(tile, self.tile, strict=True))
            for name in names:
                values = fields[name].values
                with _explained(self.path):
                    _write_part(arrays[name], part, values.reshape(self.shape + values.shape[1:]))

    def _tiles(self) -> Iterator[tuple[slice, ...]]:
        for corner in product(*(range(0, n, w) for n, w in zip(self.shape, self.tile, strict=True))):
            yield tuple(slice(k, k + w) for k, w in zip(corner, self.tile, strict=True))

    def _chunk_path(self, name: str, tile: tuple[slice, ...], rank: int) -> Path:
        place = [part.start // width for part, width in zip(tile, self.tile, strict=True)]
        return self.path.joinpath(name, "c", *map(str, place + [0] * (rank - len(place))))


def _write_part(array: Any, part: tuple[slice, ...], values: npt.NDArray[Any]) -> None:
    array[part] = values[part]


@contextmanager
def open_store(
    path: Path,
    plan: dict[str, Any],
    dims: tuple[str, ...],
    shape: tuple[int, ...],
    *,
    about: Mapping[str, str] = MappingProxyType({}),
    resume: bool,
) -> Iterator[Store]:
    """The store at ``path``, made for ``plan`` or - to ``resume`` - found there with the same one, for this run alone.

    ``about`` are further attributes of one that is made.

    Raises
    ------
    InputError : for a folder that holds something else, a store of another plan or version (with the difference), a
        store that another run works on, or a place that cannot be written.
    """
    _import_zarr()
    if resume:
        found = read_plan(path)
        if found != plan:
            raise InputError(f"{path}: holds another sweep: {difference(found, plan)}; choose another store")
    else:
        with _explained(path):
            path.mkdir(parents=True, exist_ok=True)
            if any(entry.suffix != ".partial" for entry in path.iterdir()):
                raise InputError(f"{path}: is not empty; go on with it by --resume {path}, or choose another store")
    with _locked(path):
        for partial in path.rglob("*.partial"):  # of a run that was killed while it wrote
            partial.unlink()
        with _explained(path):
            if resume and not _consolidated(path):
                _consolidate(path)
            elif not resume:
                _create_group(path, {PLAN: json.dumps(plan), **about})
        yield Store(path, plan, dims, shape)


def read_plan(path: Path) -> dict[str, Any]:
    """The plan that a store was made for; `InputError` for what is not a store of gelcone."""
    plan = read_attribute(path, PLAN)
    if plan is None:
        raise InputError(f"{path}: is a Zarr group, but not one that gelcone wrote; give a store of gelcone")
    return plan


def read_attribute(path: Path, name: str) -> dict[str, Any] | None:
    """An attribute of a store that holds a JSON object; None where there is none."""
    text = _open_group(path).attrs.get(name)
    if text is None:
        return None
    try:
        value = json.loads(text)
    except (TypeError, ValueError):
        value = None
    if not isinstance(value, dict):
        raise _damaged(path, f"its attribute {name} cannot be read")
    return value


def difference(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """The first entry in which two plans differ, in words."""
    for name in [*asked, *(n for n in stored if n not in asked)]:
        one, other = stored.get(name), asked.get(name)
        if one == other:
            continue
        if isinstance(one, dict) and isinstance(other, dict):
            inner = difference(one, other)
            return f"{name}: {inner}" if name in ("over", "draws") else inner
        return f"{name} is {_shortly(one)} there and {_shortly(other)} here"
    return "nothing"


def _shortly(value: Any) -> str:
    if isinstance(value, list) and len(value) > 4:
        return f"{len(value)} values from {value[0]:g} to {value[-1]:g}"
    return "missing" if value is None else str(value)


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Keeps other runs on this machine, and on those that share its locks, out of the folder."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise InputError(f"{path}: another run is working on it; wait for it, or choose another store") from None
    except OSError as error:
        warnings.warn(f"{path}: cannot be locked ({error.strerror}); start no second run on it", stacklevel=2)
    try:
        yield
    finally:
        os.close(handle)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Says of a write that failed what is safe and what to do."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        remedy = "free some space" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "make it writable"
        raise InputError(
            f"{path}: cannot be written ({reason}); what it holds is safe: {remedy} and go on with --resume {path}"
        ) from None


def _import_zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise MissingDependency("a store needs zarr: pip install 'gelcone[store]'") from None
    return zarr


def _create_group(path: Path, attributes: dict[str, str]) -> None:
    _import_zarr().create_group(store=path, zarr_format=3, attributes=attributes)


def _consolidate(path: Path) -> None:
    """Puts all metadata into one file, which readers look for first."""
    zarr = _import_zarr()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=zarr.errors.ZarrUserWarning)  # that not every reader knows of it
        zarr.consolidate_metadata(path, zarr_format=3)


def _consolidated(path: Path) -> list[str]:
    """Names of the arrays that the one file knows of; none before it is there."""
    _open_group(path)
    whole = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
    return list((whole.get("consolidated_metadata") or {}).get("metadata", {}))


def _open_group(path: Path, mode: str = "r") -> Any:
    zarr = _import_zarr()
    if not path.is_dir():
        raise InputError(f"{path}: no such store")
    if not (path / "zarr.json").is_file():
        there = any(path.iterdir())
        raise InputError(f"{path}: holds no metadata (zarr.json)" + ("; give a store of gelcone" if there else ""))
    try:
        return zarr.open_group(store=path, mode=mode, zarr_format=3, use_consolidated=False)
    except Exception as error:  # whatever the reader makes of damaged or foreign metadata
        raise _damaged(path, f"its metadata cannot be read: {_line(error)}") from None


def _create(
    group: Any, name: str, shape: tuple[int, ...], tile: tuple[int, ...], field: Field, dims: Iterable[str]
) -> Any:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    kind = field.values.dtype
    attributes = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in field.attributes.items()}
    return group.create_array(
        name,
        shape=shape,
        chunks=tuple(max(1, min(n, w)) for n, w in zip(shape, tile, strict=True)),
        dtype=kind,
        compressors=[ZstdCodec(level=COMPRESSION), Crc32cCodec()],
        fill_value=fill_of(kind),
        dimension_names=list(dims),
        attributes=attributes,
        overwrite=True,
    )


def fill_of(kind: npt.DTypeLike) -> Any:
    """What stands in a cell that is not known: NaN, -1 or 0."""
    kind = np.dtype(kind)
    return np.nan if kind.kind == "f" else -1 if kind.kind == "i" else 0


def _tile(shape: tuple[int, ...]) -> tuple[int, ...]:
    width = max(1, round(TILE_CELLS ** (1.0 / len(shape)) - 0.5))
    return tuple(min(n, width) for n in shape)


def _damaged(path: Path, what: str) -> InputError:
    return InputError(f"{path}: is damaged: {what}; restore it from a copy, or compute it again in another store")


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
