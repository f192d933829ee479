"""Branches of periodic orbits over a sweep, and curves of bifurcations over a map, computed in workers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import in_si
from gelcone.devices.units import DIMENSIONS
from gelcone.plots.branches import has_mirror, section_of_event, sections_of
from gelcone.progress import Stopped, current_watch
from gelcone.quantity import Array
from gelcone.studio.grids import Axis, Source
from gelcone.words import event_label

if TYPE_CHECKING:
    import xarray as xr

OPTIONS: Mapping[str, Any] = {"checks": 8, "points": 500, "threads": 1}
"""Options of continuation: the sweep's cells already give brute force at every value, and a picture needs few
points."""
EVENTS = ("period doubling", "fold", "symmetry breaking")
"""Bifurcations whose curves are drawn over a map."""


def follow_branches(source: Source, over: Axis) -> dict[str, Any]:
    """Branches of periodic orbits along an axis, as lines of section points that end in NaN, and their events.

    ``arrays`` holds ``value`` and ``section`` of all lines, whether each point is ``stable``, and ``event_value``,
    ``event_section`` and ``event_kind`` (index into ``kinds``). `InputError` where no branch is found.
    """
    from gelcone.atlas.branches.continuation import continue_branch

    subject = source.subject()
    low, high = _ends(over, subject.device is not None)
    start = [subject.initial] if subject.device is None else []
    shown = in_si(continue_branch(subject.target, over.name, low, high, *start, progress=_heed, **OPTIONS), subject)
    scale = _scale(over, shown["value"])
    lines = [line for k in range(shown.sizes["branch"]) for line in _lines(shown.isel(branch=k), has_mirror(shown))]
    value, section, stable = (np.concatenate(parts) for parts in zip(*lines, strict=True))
    labels = [event_label(shown["event_kind"][k]) for k in range(shown.sizes["event"])]
    kinds = list(dict.fromkeys(labels))
    marks = [_mark(shown, k, kinds.index(label)) for k, label in enumerate(labels)]
    at, where, kind = np.concatenate(marks, axis=1) if marks else np.zeros((3, 0))
    arrays = {"value": value * scale, "section": section, "stable": stable}
    arrays |= {"event_value": at * scale, "event_section": where, "event_kind": kind.astype(np.uint8)}
    return {"arrays": arrays, "kinds": kinds}


def follow_loci(source: Source, x: Axis, y: Axis, event: str) -> dict[str, Array]:
    """The curves of one bifurcation over two axes: ``x`` and ``y`` of lines that end in NaN.

    `InputError` where the bifurcation does not occur at the actuator's value of the second parameter.
    """
    from gelcone.atlas.branches.locus import locus

    subject = source.subject()
    over = {axis.name: _ends(axis, subject.device is not None) for axis in (x, y)}
    start = [subject.initial] if subject.device is None else []
    shown = in_si(locus(subject.target, event, over, *start, progress=_heed, **OPTIONS), subject)
    curves = {}
    for name, axis in (("x", x), ("y", y)):
        values = shown[axis.name].values * _scale(axis, shown[axis.name])
        curves[name] = np.pad(values, ((0, 0), (0, 1)), constant_values=np.nan).ravel()
    return curves


def _heed(share: float) -> None:
    """Stops a cancelled continuation between the points of a branch, where no integration checks for it."""
    watch = current_watch()
    if watch is not None and watch.stop.is_set():
        raise Stopped


def _ends(axis: Axis, texts: bool) -> tuple[Any, Any]:
    low, high = axis.texts((0, len(axis.values) - 1))
    return (low, high) if texts else (float(low), float(high))


def _scale(axis: Axis, values: xr.DataArray) -> float:
    """Factor from the unit of a result to the unit of an axis."""
    powers = next(
        (dimension.powers for dimension in DIMENSIONS.values() if axis.unit and axis.unit in dimension.powers), {}
    )
    unit = values.attrs.get("units", "1")
    return float(10.0 ** (powers[unit] - powers[axis.unit])) if unit in powers else 1.0


def _lines(branch: xr.Dataset, mirror: bool) -> Iterable[tuple[Array, Array, Array]]:
    """Value, section and stability of each line of a branch, and of its mirror image if that is a different motion."""
    value, stable = branch["value"].values, branch["stable"].values == 1
    image = mirror and not bool(branch["symmetric"]) and not bool(branch["resting"])
    for line in sections_of(branch).T:
        for sign in (1.0, -1.0) if image else (1.0,):
            yield np.append(value, np.nan), np.append(sign * line, np.nan), np.append(stable, False)


def _mark(shown: xr.Dataset, k: int, kind: int) -> Array:
    """Value, section and kind of an event: a column for each point of its section."""
    event = shown.isel(event=k)
    branch = shown.isel(branch=int(event["event_branch"]))
    return np.stack(np.broadcast_arrays(float(event["event_value"]), section_of_event(branch, event), float(kind)))
