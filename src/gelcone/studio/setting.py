"""What the page is set to: a device or a preset, values of its parameters, an initial state; read with the checks of
the command line, and never a path.

A page names devices that ship, the one file that the studio was started with, or sends a file's text. Texts among its
values must be among the choices of their control, so that no value can name a file or a module.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from gelcone.analyses.subject import Subject, read_pairs, read_subject, read_value
from gelcone.devices.device import DRIVE_NUMBERS, SWEPT_FIELDS, Device
from gelcone.devices.files import shipped_devices
from gelcone.devices.materials import load_materials
from gelcone.devices.units import DIMENSIONS, FieldError
from gelcone.errors import InputError, unknown_name
from gelcone.physics.bias import BIASES
from gelcone.physics.circuit import CIRCUITS
from gelcone.physics.drive import WAVEFORMS
from gelcone.physics.film.taut import PRESTRETCH_MODES
from gelcone.physics.laws import LAWS
from gelcone.physics.records import FILMS
from gelcone.presets import load_presets

LONGEST_VALUE = 40
LONGEST_FILE = 30_000
"""Characters of a value, and of a device file, that the page may send."""
OWN_FILE = "device.toml"
"""What the text of a device file is called once it is saved."""
MOST_VALUES = 60
STATES = ("displacement", "velocity")
CHOICES: Mapping[str, Iterable[str]] = {
    "film": FILMS,
    "law": LAWS,
    "bias": BIASES,
    "waveform": WAVEFORMS,
    "circuit": CIRCUITS,
    "prestretch_mode": PRESTRETCH_MODES,
    "material": load_materials(),
}
"""What a text may be, by the last part of its name."""
_UNITS = {unit for dimension in DIMENSIONS.values() for unit in dimension.powers}
_NUMBER = re.compile(rf"[+-]?(inf|[\d.]+([eE][+-]?\d+)?) ?({'|'.join(map(re.escape, _UNITS))})", re.ASCII)
"""One number and one unit, or none: never several values, a path or a module."""


@dataclass(frozen=True)
class Setting:
    """One of ``device`` (a name), ``preset`` (a name) and ``file`` (the text of a device file); ``values`` by name."""

    device: str | None = None
    preset: str | None = None
    file: str | None = None
    values: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Any) -> Setting:
        """A setting from the page's JSON; `InputError` for anything else."""
        if not isinstance(given, dict) or not given.keys() <= {"device", "preset", "file", "values"}:
            raise InputError("the setting must hold device, preset or file, and values")
        names = {name: given[name] for name in ("device", "preset", "file") if given.get(name) is not None}
        if len(names) != 1:
            raise InputError("the setting must hold one of device, preset and file")
        ((kind, text),) = names.items()
        if not isinstance(text, str) or len(text) > (LONGEST_FILE if kind == "file" else LONGEST_VALUE):
            raise InputError(f"{kind}: must be a text of at most {LONGEST_FILE} characters")
        values = given.get("values", {})
        if not isinstance(values, dict) or len(values) > MOST_VALUES:
            raise InputError("values: must be names and texts")
        for name, value in values.items():
            if not isinstance(value, str) or not 0 < len(value) <= LONGEST_VALUE:
                raise FieldError(str(name), f"{name}: must be a number with its unit, or one of its choices")
        return cls(**names, values=dict(values))

    @property
    def base(self) -> Setting:
        """The same without values."""
        return Setting(self.device, self.preset, self.file)


class Shelf:
    """The devices and presets that a page may name: those that ship, ``given``, and files whose text it sent.

    ``given`` is the file that the studio was started with, as it was typed. Texts are kept as files of this process, so
    that they are read as any device file is.
    """

    def __init__(self, given: Path | None = None) -> None:
        self.given = given
        self._folder = TemporaryDirectory(prefix="gelcone-studio-")
        self.folder = Path(self._folder.name)
        self.devices: Mapping[str, Path] = shipped_devices() | ({} if given is None else {given.stem: given.resolve()})
        """Name -> file."""

    def close(self) -> None:
        self._folder.cleanup()

    def path(self, setting: Setting) -> Path | None:
        """The device file of a setting; None for a preset. `InputError` for an unknown name or a bad text."""
        if setting.file is not None:
            return self._kept(setting.file)
        if setting.device is None:
            if setting.preset not in load_presets():
                raise unknown_name("preset of the paper", str(setting.preset), load_presets())
            return None
        if setting.device not in self.devices:
            raise unknown_name("device", setting.device, self.devices)
        return self.devices[setting.device]

    def called(self, setting: Setting) -> str:
        """What the command line calls the device of a setting; empty for a preset."""
        if setting.file is not None:
            return OWN_FILE
        own = self.given is not None and setting.device == self.given.stem
        return str(self.given) if own else setting.device or ""

    def subject(self, setting: Setting) -> Subject:
        """What the analyses work on.

        Raises `InputError` as the command line does, and for texts that are not among `CHOICES`.
        """
        for name, value in setting.values.items():
            if leaf(name) in CHOICES:
                known = CHOICES[leaf(name)]
                if not set(value.split("+")) <= set(known):  # several biases are joined by a plus
                    raise FieldError(name, str(unknown_name(leaf(name).replace("_", " "), value, known)))
            elif not _NUMBER.fullmatch(value):
                raise FieldError(name, f"{name} = {value!r}: must be one number, with its unit")
        path = self.path(setting)
        if path is None:
            return read_subject(**typed(setting))
        try:
            texts = read_pairs(typed(setting)["settings"], device=True) if setting.values else {}
            own = tuple((name, text) for name, text in sorted(texts.items()) if name not in DRIVE_NUMBERS)
            undriven = (path, path.stat().st_mtime_ns, own)
            found = _device(*undriven)
            found = found.redriven({name: read_value(texts[name]) for name in DRIVE_NUMBERS if name in texts})
            return Subject(found.to_model(), found, _start(*undriven))
        except InputError as error:
            if setting.file is None:
                raise
            message = str(error).replace(str(path), "the device file")
            raise FieldError(getattr(error, "field", "file"), message) from None

    def _kept(self, text: str) -> Path:
        try:
            table = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError(f"the device file is broken TOML: {error}; correct it there") from None
        _refuse_references(table)
        path = self.folder / f"{sha256(text.encode()).hexdigest()[:16]}.toml"
        if not path.exists():
            path.write_text(text, encoding="utf-8")
        return path


@lru_cache(maxsize=64)
def _device(path: Path, changed: int, texts: tuple[tuple[str, str], ...] = ()) -> Device:
    """The device in a file that was ``changed`` at a time, with other fields as they were typed."""
    if texts:
        return _device(path, changed).replace_quietly({name: read_value(text) for name, text in texts})
    found = Device.from_toml(path)
    check_single(found)
    return found


@lru_cache(maxsize=64)
def _start(path: Path, changed: int, texts: tuple[tuple[str, str], ...]) -> Any:
    """`Device.initial_state` of a `_device`, which no drive changes."""
    return _device(path, changed, texts).initial_state()


def check_single(device: Device) -> None:
    """`FieldError` for a device that is several: the studio shows one."""
    for name in SWEPT_FIELDS:
        if np.ndim(device.get(name)):
            count = np.size(device.get(name))
            raise FieldError(name, f"{name}: holds {count} values; give one, and sweep it in the studio's map or strip")


def leaf(name: str) -> str:
    """The last part of a dotted name."""
    return name.rpartition(".")[2]


def typed(setting: Setting) -> dict[str, Any]:
    """The values as the options of a command: ``settings``, ``preset``, and ``initial`` where a state is among them."""
    values = dict(setting.values)
    states = [values.pop(name, None) for name in STATES]
    options: dict[str, Any] = {"settings": [f"{name}={value}" for name, value in values.items()]}
    if setting.preset is not None:
        options["preset"] = setting.preset
        if any(state is not None for state in states):
            start = load_presets()[setting.preset].initial if setting.preset in load_presets() else (1.0, 0.0)
            options["initial"] = ",".join(
                f"{default:g}" if state is None else state for state, default in zip(states, start, strict=True)
            )
    return options


def _refuse_references(table: Any, name: str = "") -> None:
    """`InputError` for a text that could name a file or a module; a name and sources are free texts."""
    if isinstance(table, Mapping):
        for key, value in table.items():
            if key not in ("name", "sources"):
                _refuse_references(value, str(key))
    elif isinstance(table, list):
        for value in table:
            _refuse_references(value, name)
    elif isinstance(table, str) and name != "material" and (":" in table or table.endswith((".toml", ".json", ".py"))):
        raise FieldError(name, f"{name} = {table!r}: the studio opens no file or module that a device file names")
