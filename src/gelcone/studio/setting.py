"""The setting of a page - a device or preset, values of its parameters, an initial state - read with the checks of the
command line.

A page may name a shipped device or the file that the studio was started with, or send the text of a device file. Its
values must belong to existing controls, and texts must be among their choices. No name leads to another module or file:
a `Shelf` and the workers read settings under `gelcone.permission`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gelcone import disk_cache, permission
from gelcone.analyses.request import Subject, read_subject
from gelcone.analyses.values import read_pairs, read_value
from gelcone.devices.device import Device
from gelcone.devices.fields import DRIVE_NUMBERS
from gelcone.devices.files import shipped_devices
from gelcone.devices.units import DIMENSIONS, FieldError
from gelcone.errors import InputError, check_name, unknown_name
from gelcone.physics.bias import Together
from gelcone.physics.component import names_of
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.model import shipped_components
from gelcone.physics.records import FILMS
from gelcone.physics.statics import RestKey, continuing, store_rests
from gelcone.physics.system import ConeSystem
from gelcone.presets import load_presets
from gelcone.studio.controls import CHOICES, NONE, Control, controls_of, leaf
from gelcone.studio.grids import device_in, modified

LONGEST_VALUE = 40
LONGEST_FILE, LONGEST_LINE = 30_000, 500
"""Most characters of a value, and of a device file and of one of its lines, from a page: reading a key takes time
quadratic in its length."""
OWN_FILE = "device.toml"
"""Name under which a sent device file is saved."""
MOST_VALUES = 60
STATES = ("displacement", "velocity")
_UNITS = {unit for dimension in DIMENSIONS.values() for unit in dimension.powers}
_NUMBER = re.compile(rf"[+-]?(inf|[\d.]+([eE][+-]?\d+)?) ?({'|'.join(map(re.escape, _UNITS))})", re.ASCII)
"""One number with or without a unit: never several values, a path or a module."""


@dataclass(frozen=True)
class Setting:
    """The setting of a page: one of ``device`` (name), ``preset`` (name) or ``file`` (text of a device file), and
    ``values`` by control."""

    device: str | None = None
    preset: str | None = None
    file: str | None = None
    values: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Any) -> Setting:
        """The setting in the page's JSON; `InputError` for anything else."""
        if not isinstance(given, dict) or not given.keys() <= {"device", "preset", "file", "values"}:
            raise InputError("the setting must hold device, preset or file, and values")
        names = {name: given[name] for name in ("device", "preset", "file") if given.get(name) is not None}
        if len(names) != 1:
            raise InputError("the setting must hold one of device, preset and file")
        ((kind, text),) = names.items()
        longest = LONGEST_FILE if kind == "file" else LONGEST_VALUE
        if not isinstance(text, str) or len(text) > longest:
            raise InputError(f"{kind}: must be a text of at most {longest} characters")
        if kind == "file" and any(len(line) > LONGEST_LINE for line in text.splitlines()):
            raise InputError(f"file: has a line of more than {LONGEST_LINE} characters; break it into several")
        values = given.get("values", {})
        if not isinstance(values, dict) or len(values) > MOST_VALUES:
            raise InputError(f"values: must be at most {MOST_VALUES} names and texts")
        for name, value in values.items():
            if not isinstance(value, str) or not 0 < len(value) <= LONGEST_VALUE:
                shown = name[:LONGEST_VALUE]
                raise FieldError(name, f"{shown}: must be a number with its unit, or one of its choices")
        return cls(**names, values=dict(values))

    @property
    def base(self) -> Setting:
        """The setting without values."""
        return replace(self, values={})

    @property
    def chosen(self) -> Setting:
        """The setting with its choices alone, without numbers."""
        return replace(self, values={name: value for name, value in self.values.items() if leaf(name) in CHOICES})


class Shelf:
    """The devices and presets that a page may use: those that ship, ``given``, and devices sent as text.

    ``given`` is the file that the studio was started with, as typed; ``names`` are the names of own code in that user's
    device, see `names_in`. Nothing else is opened or imported, whatever a page sends.
    """

    def __init__(self, given: Path | None = None, names: frozenset[str] = frozenset()) -> None:
        self.given, self.names = given, names
        self._places: dict[_Key, dict[ConeSystem, float]] = {}
        """The last rest of each device."""
        self._guesses: dict[tuple[_Key, _Texts], dict[RestKey, float]] = {}
        """Rests continued from another setting, not yet confirmed by a search."""
        self.devices: Mapping[str, Path] = shipped_devices() | ({} if given is None else {given.stem: given.resolve()})
        """Name -> file."""
        # caches of this shelf: reading a device fills its places
        self._device, self._start = lru_cache(MOST_READ)(self._read), lru_cache(MOST_READ)(self._begin)
        self._controls = lru_cache(MOST_READ)(self._find_controls)

    def path(self, setting: Setting) -> Path | None:
        """The file of a setting's device; None for a preset or a sent device. `InputError` for an unknown name."""
        if setting.file is not None:
            return None
        if setting.device is None:
            check_name("preset of the paper", setting.preset, load_presets())
            return None
        check_name("device", setting.device, self.devices)
        return self.devices[setting.device]

    def called(self, setting: Setting) -> str:
        """The device's name on the command line; empty for a preset."""
        if setting.file is not None:
            return OWN_FILE
        is_given = self.given is not None and setting.device == self.given.stem
        return str(self.given) if is_given else setting.device or ""

    def controls(self, setting: Setting) -> list[Control]:
        """The controls of a setting, with the values to which they reset: its choices count, its numbers do not.

        While a membrane is not made, its cone gives the rest height.
        """
        with permission.only(self.names):
            given = self._key(setting), setting.device, setting.preset, tuple(setting.chosen.values.items())
            try:
                with disk_cache.unmade_refused():
                    return self._controls(*given)
            except disk_cache.Unmade:
                return self._controls(*given, cone=bool(self._cone(setting.chosen)))

    def at_once(
        self, setting: Setting, compute: Callable[[Subject], _Found], *, patient: bool = False
    ) -> tuple[Subject, _Found, bool]:
        """The subject of a setting, the result of ``compute`` for it, and False.

        If the membrane takes seconds to make and the call is not ``patient``, all of this with a cone in its place, and
        True. `InputError` as `subject`.
        """
        try:
            with nullcontext() if patient else disk_cache.unmade_refused():
                subject = self.subject(setting)
                return subject, compute(subject), False
        except disk_cache.Unmade:
            with permission.only(self.names):
                stands = bool(self._cone(setting))
            subject = self.subject(setting, cone=stands)
            return subject, compute(subject), stands

    def _cone(self, setting: Setting) -> _Texts:
        """The fields that put cones in place of a device's membranes; empty without membranes."""
        if setting.preset is not None:
            return ()
        # reads the fields alone: building the device with these values would make the membranes
        device, texts = self._device(self._key(setting)), dict(self._own(setting))
        films = ("film", "second_film")
        chosen = {name: read_value(texts[name]) if name in texts else getattr(device, name) for name in films}
        return tuple((name, CONE) for name, film in chosen.items() if film == MembraneFilm.name)

    def check(self, setting: Setting) -> None:
        """Raises `InputError` for names or texts that a page may not send, see `subject`."""
        with permission.only(self.names):
            self._check(setting)

    def subject(self, setting: Setting, *, cone: bool = False) -> Subject:
        """The subject of the analyses, with cones in place of membranes if ``cone``.

        Raises `InputError` as the command line does, for a value that belongs to no control of the device or preset,
        and for a text that is not among the choices of its control.
        """
        with permission.only(self.names):
            self._check(setting)
            key = self._key(setting)
            if setting.preset is not None:
                return read_subject(**typed(setting))
            try:
                texts, device_texts = _split(typed(setting)["settings"]) if setting.values else ({}, ())
                device_texts = (*device_texts, *self._cone(setting)) if cone else device_texts
                places = _bounded(self._places).setdefault(key, {})
                with continuing(places) as guessed:
                    device = self._device(key, device_texts)
                    device = device.redriven({name: read_value(texts[name]) for name in DRIVE_NUMBERS if name in texts})
                    subject = Subject(device.to_model(), device, self._start(key, device_texts))
                if guessed:
                    _bounded(self._guesses).setdefault((key, device_texts), {}).update(guessed)
                return subject
            except InputError as error:
                if setting.file is None:
                    raise
                raise FieldError(getattr(error, "field", "file"), str(error)) from None

    def guesses(self, setting: Setting) -> dict[RestKey, float]:
        """The rests of a setting that were continued from another one and not confirmed by a search."""
        return self._guesses.get((self._key(setting), self._own(setting)), {})

    def confirm(self, setting: Setting, found: dict[RestKey, float]) -> float:
        """Takes the rests of a setting found by a search, and returns their largest distance from the guesses, in units
        of b - a."""
        guesses = self._guesses.pop((self._key(setting), self._own(setting)), {})
        store_rests(found)
        moved = max((abs(found.get(key, guess) - guess) for key, guess in guesses.items()), default=0.0)
        if moved > 0.0:
            self._places.get(self._key(setting), {}).update({system: rest for (system, _), rest in found.items()})
            self._start.cache_clear()
        return moved

    def _own(self, setting: Setting) -> _Texts:
        """The values of a setting, without those of the drive."""
        return () if not setting.values else _split(typed(setting)["settings"])[1]

    def _check(self, setting: Setting) -> None:
        """Raises `InputError` for values without a control; a choice may bring controls."""
        if not setting.values:
            return
        chosen = setting.chosen
        if chosen.values == setting.values:  # some of the choices may belong to parts that others bring
            names = {control.name for control in self.controls(setting.base)}
            first = {name: value for name, value in setting.values.items() if name in names}
            chosen = replace(setting, values={} if first == setting.values else first)
        known = {control.name: control for control in self.controls(chosen)}
        for name, value in setting.values.items():
            if name not in known:
                raise FieldError(name[:LONGEST_VALUE], f"{name[:LONGEST_VALUE]!r}: is not a control of this subject")
            if known[name].kind == "choice":
                choices = CHOICES[leaf(name)]
                if not set(value.split("+")) <= set(choices):  # several biases are joined by a plus
                    raise FieldError(name, str(unknown_name(leaf(name).replace("_", " "), value, choices)))
            elif not _NUMBER.fullmatch(value):
                raise FieldError(name, f"{name} = {value!r}: must be one number, with its unit")

    def _find_controls(
        self, key: _Key, device: str | None, preset: str | None, values: _Texts, cone: bool = False
    ) -> list[Control]:
        setting = Setting(device, preset, key[2], dict(values))
        controls = controls_of(self.subject(setting, cone=cone))
        if "second_film" in setting.values and self._device(key).second_film is None:
            controls = [replace(c, choices=(NONE, *c.choices)) if c.name == "second_film" else c for c in controls]
        films = dict(self._cone(setting)) if cone else {}
        return [replace(control, value=MembraneFilm.name) if control.name in films else control for control in controls]

    def _read(self, key: _Key, texts: _Texts = ()) -> Device:
        """A device with some fields replaced by typed values."""
        if texts:
            return self._device(key).replace_quietly({name: read_value(text) for name, text in texts})
        path, _, text = key
        device = device_in(path, text)
        assert device is not None
        check_single(device)
        return device

    def _begin(self, key: _Key, texts: _Texts) -> Any:
        """`Device.initial_state` of a device, which no drive changes."""
        return self._device(key, texts).initial_state()

    def _key(self, setting: Setting) -> _Key:
        path = self.path(setting)
        return path, modified(path), setting.file


_Key = tuple[Path | None, int, str | None]
"""Identity of a device: its file and modification time, or its text."""
_Texts = tuple[tuple[str, str], ...]
_Found = TypeVar("_Found")
CONE = WrinklingCone.name
MOST_KEPT, MOST_READ = 256, 64


def _split(settings: list[str]) -> tuple[Mapping[str, str], _Texts]:
    """All settings by name, and those not of the drive, sorted."""
    texts = read_pairs(settings, device=True)
    return texts, tuple((name, text) for name, text in sorted(texts.items()) if name not in DRIVE_NUMBERS)


def _bounded(store: dict[Any, Any]) -> dict[Any, Any]:
    if len(store) >= MOST_KEPT:
        store.clear()
    return store


def check_single(device: Device) -> None:
    """Raises `FieldError` for a device with several values in a field: the studio shows one actuator."""
    for name in device.swept_fields():
        if np.ndim(device.get(name)):
            count = np.size(device.get(name))
            raise FieldError(name, f"{name}: holds {count} values; give one, and sweep it in the studio's map or strip")


def names_in(device: Device) -> frozenset[str]:
    """The classes of a device's components that do not ship, with their data."""
    system = device.to_model().system
    films = [film.film for film in system.films]
    records = set[str]().union(*map(names_of, (*films, system.bias, system.waveform, system.circuit)))
    shipped = {name for part in shipped_components() for name in names_of(part)}
    known_names = {*FILMS, f"{Together.__module__}:{Together.__qualname__}", *shipped}
    return frozenset(
        entry
        for entry in records
        if (json.loads(entry)["component"] if entry.startswith("{") else entry) not in known_names
    )


def typed(setting: Setting) -> dict[str, Any]:
    """The values as options of a command: ``settings``, ``preset``, and ``initial`` if a state is among them."""
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
