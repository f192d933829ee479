"""Cells of maps and sweeps: the kind of motion over one or two parameters, computed in workers.

The cells of a map come level by level, as `gelcone.atlas.refinement` chooses them: first a coarse lattice, then cells
between neighbours of different kinds. The others are shown in the kind of the nearest computed cell until their turn
comes.
"""

from __future__ import annotations

import json
import reprlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.request import Subject, read_subject
from gelcone.atlas.plan import model_at
from gelcone.codes import Outcome
from gelcone.devices.device import Device
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError
from gelcone.motion.attractor.classification import RETURNS
from gelcone.motion.limits import limits_cells
from gelcone.motion.start import start_states
from gelcone.physics.film.pull_in import CurveKey, PullInCurve, curve_of
from gelcone.physics.members import Members
from gelcone.physics.statics import RestKey, stored_rests
from gelcone.quantity import Array
from gelcone.register.analyses import ANALYSES
from gelcone.studio import equilibria, look, profiles, settled
from gelcone.studio.controls import Control

if TYPE_CHECKING:
    import xarray as xr

LEAST_TASK, FIRST_TASK, TASK = 32, 48, 128
"""Fewest cells in a task, and most in a task of the coarsest picture and of later ones: enough to fill the lanes of
vectors, few enough that the picture grows steadily and that no worker waits long at the end of a level."""
COARSEST = 9
"""Cells along each axis of the coarsest picture."""
PULLED_IN, IMPOSSIBLE = 98, 99
"""Kinds of cells in addition to the regimes of motion."""


def even_tasks(cells: Array, workers: int, most: int) -> list[Array]:
    """Cells split into tasks of equal size (to within one cell).

    Two tasks per worker, or more if they would exceed ``most`` cells; none smaller than `LEAST_TASK` unless fewer cells
    are left.
    """
    size = min(max(-(-cells.size // (2 * workers)), LEAST_TASK), most)
    return np.array_split(cells, -(-cells.size // size)) if cells.size else []


@dataclass(frozen=True)
class Source:
    """The origin of a worker's subject: the ``path`` or the ``text`` of a device file, or a preset among the
    ``options`` of `read_subject`."""

    path: Path | None
    text: str | None
    options: Mapping[str, Any]

    @property
    def key(self) -> tuple[Path | None, int, str | None, str]:
        """A cache key, equal for sources of equal subjects."""
        return self.path, modified(self.path), self.text, json.dumps(self.options)

    def subject(self) -> Subject:
        """The subject, cached in this process."""
        return subject_of(*self.key)


@lru_cache(maxsize=8)
def subject_of(path: Path | None, time: int, text: str | None, options: str) -> Subject:
    """The subject of a `Source.key`; ``time`` only distinguishes versions of the file."""
    return read_subject(device_in(path, text), **json.loads(options))


def modified(path: Path | None) -> int:
    """Modification time of a file in nanoseconds; 0 for None and for a missing file, which the reader reports."""
    try:
        return 0 if path is None else path.stat().st_mtime_ns
    except OSError:
        return 0


def device_in(path: Path | None, text: str | None) -> Device | None:
    """The device in a file or in the text of one; None without either."""
    if path is not None:
        return Device.from_toml(path)
    return None if text is None else Device.from_text(text)


@dataclass(frozen=True)
class Axis:
    """A parameter and its ``values`` in the unit of its control."""

    name: str
    unit: str
    values: Array

    def texts(self, places: Iterable[int]) -> list[str]:
        """The values at these places, as they would be typed."""
        return [f"{self.values[i]:.10g} {self.unit}".strip() for i in places]


def axis(controls: Iterable[Control], given: Any, count: int) -> Axis:
    """An axis from the page's JSON ``[name, from, to]``; `InputError` for a parameter that cannot be swept."""
    name, low, high = given if isinstance(given, list) and len(given) == 3 else (given, None, None)
    control = next((c for c in controls if c.name == name and c.kind == "number"), None)
    if control is None:
        raise InputError(f"{reprlib.repr(name)}: is not a parameter that can be swept here; choose one of the list")
    if not (isinstance(low, int | float) and isinstance(high, int | float) and np.isfinite([low, high]).all()):
        raise InputError(f"{control.label}: give numbers for both ends")
    if not low < high:
        raise InputError(f"{control.label}: from {low:g} to {high:g} is empty; the first end must be below the second")
    return Axis(control.name, control.unit, np.linspace(low, high, count))


@dataclass(frozen=True)
class Cells:
    """Members with initial states (members, N), and the page's units for one unit of length, rate and voltage
    (members,)."""

    members: Members
    states: Array
    length: Array
    rate: Array
    voltage: Array


def cells_of(subject: Subject, axes: Mapping[str, Any]) -> Cells:
    """The actuators of some cells; ``axes``: parameter -> its value in each cell, as typed."""
    return _of_device(subject.device, axes) if subject.device is not None else _of_model(subject, axes)


def _of_model(subject: Subject, axes: Mapping[str, list[str]]) -> Cells:
    values = {name: np.array([float(text) for text in texts]) for name, texts in axes.items()}
    model, states = model_at(subject.model, values, subject.initial)
    return Cells(model.members(), start_states(model, states), *np.ones((3, len(states))))


def _of_device(device: Device, axes: Mapping[str, list[str]]) -> Cells:
    count = len(next(iter(axes.values())))
    changed = device.replace_quietly(axes)
    scales = changed.scales
    length, rate, voltage = (
        np.broadcast_to(scale * MEASURES[quantity].per_unit, (count,))
        for quantity, scale in (("length", scales.length), ("rate", 1.0 / scales.time), ("voltage", scales.voltage))
    )
    model = changed.to_model()
    return Cells(model.members(), start_states(model, changed.initial_state()), length, rate, voltage)


# --- in the workers --------------------------------------------------------------------------------------------------


def load() -> None:
    """Does nothing: running it in a worker loads the modules that later tasks need."""


def find_pull_in(source: Source) -> float:
    """`equilibria.PULL_INS.of` a subject."""
    return equilibria.PULL_INS.of(source.subject().model)


def make_membrane(source: Source, periods: float) -> bool:
    """Stores in the disk cache the membrane that a subject's picture and kind of motion need. A drive that does not
    repeat has no kind of motion, but the picture has stored the membrane by then."""
    subject = source.subject()
    look.response(subject, periods)
    with suppress(InputError):
        settled.kind(subject)
    return True


def find_curves(source: Source, keys: list[CurveKey]) -> list[PullInCurve | None]:
    """The pull-in curves of a subject's membranes."""
    return [curve_of(*key) for key in keys]


def find_static(source: Source) -> xr.Dataset:
    """`equilibria.STATICS.of` a subject."""
    return equilibria.STATICS.of(source.subject().model)


def find_profiles(source: Source, film: int) -> look.Parts:
    """`profiles.table` of one film of a subject."""
    return profiles.table(source.subject(), film)


def find_rests(source: Source, keys: list[RestKey]) -> dict[RestKey, float]:
    """The rest displacements of a subject under these keys; reading the subject searches for them."""
    source.subject()
    return stored_rests(keys)


def kinds(source: Source, axes: Mapping[str, list[str]]) -> dict[str, Any]:
    """Kind of motion, largest exponent, extent and section of each cell, in the units of the page.

    Cells without a valid actuator, such as a disc larger than the film, have the kind `IMPOSSIBLE`.
    """
    return _kinds(source.subject(), axes)


def _kinds(subject: Subject, axes: Mapping[str, list[str]]) -> dict[str, Any]:
    count = len(next(iter(axes.values())))
    try:
        cells = cells_of(subject, axes)
    except InputError:
        if count == 1:
            return _impossible()
        parts = [_kinds(subject, {name: [texts[i]] for name, texts in axes.items()}) for i in range(count)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    computed = ANALYSES["regime"].compute(cells.members, cells.states, threads=1)
    regime = np.where(computed.outcome == Outcome.PULLED_IN, PULLED_IN, computed.variables["regime"][1])
    low, high = (np.asarray(computed.variables[name][1]) * cells.length for name in ("lowest", "highest"))
    section = np.asarray(computed.variables["section"][1])[..., 0] * cells.length[:, None]
    return {
        "regime": regime.astype(np.uint8),
        "exponent": np.asarray(computed.variables["lyapunov"][1])[:, 0] * cells.rate,
        "low": low,
        "high": high,
        "section": section,
    }


def _impossible() -> dict[str, Any]:
    nothing = np.full(1, np.nan)
    regime = np.full(1, IMPOSSIBLE, dtype=np.uint8)
    section = np.full((1, RETURNS), np.nan)
    return {"regime": regime, "exponent": nothing, "low": nothing, "high": nothing, "section": section}


THRESHOLDS = {
    "onset_voltage": "rest becomes unstable",
    "pitchfork_voltage": "flat film loses its stability at the peak",
    "pull_in_voltage": "pull-in of the {film} at the peak",
}
"""Voltages of `gelcone.limits` drawn over a map, with their labels."""
FREQUENCIES = ("frequency", "drive_frequency")
VOLTAGES = ("voltage", "voltage_amplitude")
"""Parameters that hold the voltage's amplitude."""


def thresholds(source: Source, axes: Mapping[str, list[str]]) -> dict[str, Any]:
    """The voltage amplitude at each threshold along one axis, in V or dimensionless; thresholds never met are left out.

    Pull-in and pitchfork are those of a constant voltage: they are met when the peak of the drive reaches them.
    """
    subject = source.subject()
    try:
        cells = cells_of(subject, axes)
    except InputError:
        return {}
    limits = limits_cells(cells.members, cells.states, threads=1).variables
    waveform, n = subject.model.system.waveform, cells.members.numbers()
    lines, film = {}, look.pull_in_film(subject.model)
    for name, words in THRESHOLDS.items():
        volts = np.asarray(limits[name][1])
        if name != "onset_voltage":
            volts = waveform.amplitude_at(n, volts)
        if (volts > 0.0).any():
            lines[words.format(film=film)] = np.where(volts > 0.0, volts, np.nan) * cells.voltage
    return lines
