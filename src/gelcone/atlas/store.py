"""Store of the results of a sweep on disk while it runs: a Zarr group from which the run can be resumed at any time.

The group's attributes hold the plan. Each variable is an array over the plan's axes, cut into tiles. ``status`` states
for every cell whether its values are computed, and is written after the rest of a tile, so that cells with that status
are complete whenever the run ends. A tile that is all NaN is written like any other. Every tile has a checksum.
"""

from __future__ import annotations

import errno
import json
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import IntEnum
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from gelcone.errors import DoubtfulInput, InputError

TILE_CELLS = 16384
"""Largest number of cells of a tile, which is equally wide along each axis."""
PLAN = "gelcone_plan"
VERSION = "gelcone_version"
FILM_ERRORS = "film_errors"
"""Entry of a plan that follows from the others, but for rounding, in which machines differ."""
"""The entry of a plan that names the version which wrote it."""
COMPRESSION = 3
LOCK = "gelcone.lock"
"""Name of the empty file in a store that is locked by the run that writes to it."""


class Status(IntEnum):
    """Origin of the values of a cell."""

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
    """A variable over all cells: the names of its own dims, its values (cells, ...) and its attributes."""

    dims: tuple[str, ...]
    values: npt.NDArray[Any]
    attributes: Mapping[str, Any]


class Store:
    """A sweep's results in a folder; `open_store` makes one and locks it."""

    def __init__(self, path: Path, plan: dict[str, Any], dims: tuple[str, ...], shape: tuple[int, ...]) -> None:
        self.path, self.plan, self.dims, self.shape = path, plan, dims, shape
        self.tile = _tile(shape)

    def read(self) -> dict[str, Field]:
        """All fields, ``status`` included, as far as they are computed; empty before the first tile is written.

        Raises `InputError` for a tile that is missing, truncated or changed.
        """
        try:
            return self._read()
        except (InputError, MemoryError):
            raise
        except Exception as error:  # the readers raise many kinds on damaged metadata and tiles
            raise _damaged(self.path, f"an array cannot be read: {_line(error)}") from None

    def _read(self) -> dict[str, Field]:
        for name in _consolidated(self.path):
            if not (self.path / name / "zarr.json").is_file():
                raise _damaged(self.path, f"its array {name} is missing")
        group = _open_group(self.path)
        names = sorted(entry.name for entry in self.path.iterdir() if (entry / "zarr.json").is_file())
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
                    raise _damaged(self.path, f"a tile of {name} is missing")
        return {name: self._field(name, array) for name, array in arrays.items()}

    def _field(self, name: str, array: Any) -> Field:
        dims = tuple(array.metadata.dimension_names[len(self.shape) :])
        values = self._read_whole(name, array)
        return Field(dims, values.reshape(-1, *values.shape[len(self.shape) :]), dict(array.attrs))

    def _read_whole(self, name: str, array: Any) -> npt.NDArray[Any]:
        try:
            return np.asarray(array[...])
        except Exception as error:  # codecs raise many kinds on damaged bytes
            raise _damaged(self.path, f"a tile of {name} cannot be read: {_line(error)}") from None

    def begin(self, fields: Mapping[str, Field], coordinates: Mapping[str, Field]) -> None:
        """Creates the arrays, ``status`` last, so that the others exist if it does."""
        group = _open_group(self.path, mode="r+")
        for name, field in coordinates.items():
            _create(group, name, field.values.shape, field.values.shape, field, field.dims)[...] = field.values
        for name in sorted(fields, key=lambda name: name == "status"):
            field = fields[name]
            field_shape = field.values.shape[1:]
            _create(group, name, self.shape + field_shape, self.tile + field_shape, field, self.dims + field.dims)
        _consolidate(self.path)

    def write(self, fields: Mapping[str, Field], cells: npt.NDArray[np.intp]) -> None:
        """Writes the tiles of all fields that contain the cells, ``status`` last.

        Raises `InputError` where the disk is full or not writable; earlier tiles stay intact.
        """
        places = np.unravel_index(cells, self.shape)
        tiles = np.unique([place // width for place, width in zip(places, self.tile, strict=True)], axis=1).T
        names = sorted(fields, key=lambda name: name == "status")
        # Otherwise a tile of fill values would not be written, and could not be distinguished from a lost one.
        import zarr

        with zarr.config.set({"array.write_empty_chunks": True}):
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
    resume: bool,
) -> Iterator[Store]:
    """The store at ``path``, locked for this run: created for ``plan`` or, to ``resume``, opened with the same plan.

    To ``resume`` a folder in which nothing is written creates the store, too.

    Raises
    ------
    InputError : for a folder that holds something else, a store of another plan or version (naming the difference), a
        store that another run is writing, or a place that cannot be written.
    """
    import zarr

    resume = resume and not (path.is_dir() and holds_nothing(path))
    if resume:
        stored_plan = read_plan(path)
        if stored_plan | {FILM_ERRORS: None} != plan | {FILM_ERRORS: None}:
            raise _another(path, stored_plan, plan)
    else:
        with _explained(path):
            path.mkdir(parents=True, exist_ok=True)
            if not holds_nothing(path):
                raise InputError(f"{path}: is not empty; resume it with --resume {path}, or choose another store")
    with _locked(path):
        for partial in path.rglob("*.partial"):  # left by a run that was killed while it wrote
            partial.unlink()
        with _explained(path):
            if resume and not _consolidated(path):
                _consolidate(path)
            elif not resume:
                zarr.create_group(store=path, zarr_format=3, attributes={PLAN: json.dumps(plan)})
        yield Store(path, plan, dims, shape)


def holds_nothing(folder: Path) -> bool:
    """Decide whether a folder is empty, but for what a run leaves that is killed before it writes."""
    return all(entry.suffix == ".partial" or entry.name == LOCK for entry in folder.iterdir())


def read_plan(path: Path) -> dict[str, Any]:
    """The plan of a store. Raises `InputError` for a folder that is not a store of gelcone."""
    text = _open_group(path).attrs.get(PLAN)
    if text is None:
        raise InputError(f"{path}: is a Zarr group, but not one that gelcone wrote; name a store of gelcone")
    try:
        plan = json.loads(text)
    except (TypeError, ValueError):
        plan = None
    if not isinstance(plan, dict):
        raise _damaged(path, f"its attribute {PLAN} cannot be read")
    return plan


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


def _another(path: Path, found: Mapping[str, Any], plan: Mapping[str, Any]) -> InputError:
    """The refusal of a store with another plan than the requested one."""
    theirs, ours = found.get(VERSION), plan.get(VERSION)
    if theirs != ours:
        return InputError(
            f"{path}: {VERSION} is {theirs} there and {ours} here, so that its cells would not match; resume it with "
            f"gelcone {theirs}, or choose another store"
        )
    return InputError(f"{path}: holds another run: {difference(found, plan)}; choose another store")


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Locks the folder for this run, on this machine and on those that share its locks.

    The operating system releases the lock when the process ends, however it ends; the file that carries it may stay.
    """
    from filelock import FileLock, Timeout

    lock = FileLock(path / LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise InputError(f"{path}: another run is writing to it; wait for it, or choose another store") from None
    except (OSError, NotImplementedError) as error:
        warnings.warn(f"{path}: cannot be locked ({error}); start no second run on it", DoubtfulInput, stacklevel=2)
    try:
        yield
    finally:
        if lock.is_locked:
            with suppress(OSError):  # Windows removes it on release, and not before
                (path / LOCK).unlink()
            lock.release()


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Turns errors of writing into an `InputError` with the remedy."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        remedy = "free some space" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "make it writable"
        raise InputError(
            f"{path}: cannot be written ({reason}); what it holds is safe: {remedy} and continue with --resume {path}"
        ) from None


def _consolidate(path: Path) -> None:
    """Collects all metadata in the one file that readers open first."""
    import zarr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=UserWarning)  # not every reader supports it
        zarr.consolidate_metadata(path, zarr_format=3)


def _consolidated(path: Path) -> list[str]:
    """Names of the arrays in the collected metadata; none before it is written."""
    _open_group(path)
    whole = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
    return list((whole.get("consolidated_metadata") or {}).get("metadata", {}))


def _open_group(path: Path, mode: Literal["r", "r+"] = "r") -> Any:
    import zarr

    if path.is_file():
        raise InputError(f"{path}: is a file and no store; gelcone.load reads it, and gelcone.in_words prints it")
    if not path.is_dir():
        raise InputError(f"{path}: no such store")
    if not (path / "zarr.json").is_file():
        if holds_nothing(path):
            raise InputError(f"{path}: is empty: no run has written to it yet; begin one with --store {path}")
        held = sorted(path.glob("*.nc"))
        remedy = f"name a file in it, such as {held[0]}" if held else "name a store of gelcone"
        raise InputError(f"{path}: holds no metadata (zarr.json); {remedy}")
    try:
        return zarr.open_group(store=path, mode=mode, zarr_format=3, use_consolidated=False)
    except Exception as error:  # the reader raises many kinds on damaged or foreign metadata
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
    """The value of a cell that is not computed: NaN, -1 or 0."""
    kind = np.dtype(kind)
    return np.nan if kind.kind == "f" else -1 if kind.kind == "i" else 0


def _tile(shape: tuple[int, ...]) -> tuple[int, ...]:
    width = max(1, round(TILE_CELLS ** (1.0 / len(shape)) - 0.5))
    return tuple(min(n, width) for n in shape)


def _damaged(path: Path, what: str) -> InputError:
    return InputError(f"{path}: is damaged: {what}; restore it from a copy, or compute it again in another store")


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
