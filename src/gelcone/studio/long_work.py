"""Work of seconds that a page asks for: maps, sweeps, envelopes, files. Worker processes compute it, and the page
receives each part as it finishes."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.atlas.refinement import refine
from gelcone.devices.units import DIMENSIONS
from gelcone.errors import InputError
from gelcone.studio import exports
from gelcone.studio.branches import EVENTS, follow_branches, follow_loci
from gelcone.studio.grids import (
    COARSEST,
    FIRST_TASK,
    FREQUENCIES,
    TASK,
    VOLTAGES,
    Axis,
    Source,
    even_tasks,
    kinds,
    thresholds,
)
from gelcone.studio.pool import Pool

STRIP_STEPS = (8, 4, 2, 1)
"""Strides through the values of a sweep, from coarse to fine."""


class Outdated(Exception):
    """A newer request has replaced this work."""


@dataclass(frozen=True)
class Work:
    """One run of long work: its ``lane`` of the ``pool``, the ``number`` of the page's request, and ``send``, which
    sends results to the page."""

    pool: Pool
    lane: int
    run: int
    number: int
    send: Callable[..., Awaitable[None]]

    async def do(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Calls ``function(*arguments)`` in a worker; raises `Outdated` if the run has been replaced."""
        answer = await self.pool.do(self.lane, self.run, function, *arguments)
        if answer is None:
            raise Outdated
        return answer

    async def tell(self, kind: str, arrays: Mapping[str, Any] | None = None, **words: Any) -> None:
        """Sends the page a message of this kind about the work."""
        await self.send({"kind": kind, "id": self.number, **words}, arrays)


# --- maps and sweeps -------------------------------------------------------------------------------------------------


async def fill_map(work: Work, source: Source, x: Axis, y: Axis) -> None:
    """Computes a map from coarse to fine: cells near changes of kind with the thresholds, then all other cells, then
    the curves of bifurcations."""
    filling = Filling(work, "map", source, (x, y))
    await work.tell("grid", grid="map", cells=filling.shape)
    levels = refine(filling.shape, COARSEST)
    lattice_cells = next(levels)
    drawn = False
    while True:
        computed_kinds = await filling.compute(lattice_cells)
        if not drawn:
            drawn = True
            await _draw_thresholds(work, source, x, y)
        try:
            lattice_cells = levels.send(computed_kinds)
        except StopIteration:
            break
    await filling.compute(np.flatnonzero(filling.kinds < 0))
    await work.tell("done", grid="map")
    for event in EVENTS:
        with suppress(InputError):  # this bifurcation does not occur here
            await work.tell("loci", await work.do(follow_loci, source, x, y, event), name=event)
    await work.tell("followed")


async def _draw_thresholds(work: Work, source: Source, x: Axis, y: Axis) -> None:
    """Sends the threshold lines, if one axis of the map is the voltage."""
    volts, other = (x, y) if x.name in VOLTAGES else (y, x)
    if volts.name not in VOLTAGES:
        return
    lines = await work.do(thresholds, source, {other.name: other.texts(range(len(other.values)))})
    scale = 10.0 ** -DIMENSIONS["V"].powers.get(volts.unit, 0)
    arrays = {"at": other.values} | {name: values * scale for name, values in lines.items()}
    await work.tell("thresholds", arrays, upright=volts is x, names=list(lines))


async def fill_strip(work: Work, source: Source, over: Axis) -> None:
    """Computes a sweep: the section at each value from coarse to fine, then the branches."""
    filling = Filling(work, "strip", source, (over,))
    await work.tell("grid", grid="strip", cells=filling.shape)
    places = np.arange(len(over.values))
    for step in STRIP_STEPS:
        await filling.compute(places[(places % step == 0) & (filling.kinds < 0)])
    await work.tell("done", grid="strip")
    try:
        branches = await work.do(follow_branches, source, over)
    except InputError as error:
        await work.tell("branches", kinds=[], none=" ".join(str(error).split()))
        return
    arrays = branches.pop("arrays")
    await work.tell("branches", arrays, **branches)


class Filling:
    """The cells of one map or sweep while they are computed. ``kinds`` holds the kind of each cell, -1 where it is not
    known yet."""

    def __init__(self, work: Work, name: str, source: Source, axes: tuple[Axis, ...]) -> None:
        self.work, self.name, self.source, self.axes = work, name, source, axes
        self.shape = tuple(len(axis.values) for axis in axes)
        self.kinds = np.full(int(np.prod(self.shape)), -1, dtype=np.int64)
        # one task more than workers: none idles, and other pages get their turn
        self._room = asyncio.Semaphore(work.pool.size + 1)

    async def compute(self, cells: Any) -> Any:
        """Computes some cells, sends them to the page task by task, and returns their kinds; `Outdated` if the run has
        been replaced."""
        alike = cells[np.lexsort(self._groups(cells))]
        most = FIRST_TASK if self.kinds.max() < 0 else TASK
        await asyncio.gather(*(self._task(part) for part in even_tasks(alike, self.work.pool.size, most)))
        return self.kinds[cells]

    def _groups(self, cells: Any) -> list[Any]:
        """Sort keys of cells: cells of equal frequency next to each other compute three times as fast."""
        places = np.unravel_index(cells, self.shape)
        return [cells, *(indices for axis, indices in zip(self.axes, places, strict=True) if axis.name in FREQUENCIES)]

    async def _task(self, cells: Any) -> None:
        places = np.unravel_index(cells, self.shape)
        texts = {axis.name: axis.texts(indices.tolist()) for axis, indices in zip(self.axes, places, strict=True)}
        async with self._room:
            motions = await self.work.do(kinds, self.source, texts)
        self.kinds[cells] = motions["regime"]
        share = float((self.kinds >= 0).mean())
        if self.name == "map":
            del motions["section"]
        arrays = {"places": np.asarray(cells, dtype=float), **motions}
        await self.work.tell("cells", arrays, grid=self.name, share=share)


# --- files -----------------------------------------------------------------------------------------------------------


async def make_file(work: Work, source: Source, wanted: exports.Wanted, form: str) -> None:
    """Computes a file and sends it to the page."""
    data = await work.do(exports.make, source, wanted, form)
    name = f"{wanted.analysis.command}.{form}"
    await work.tell("file", {"data": np.frombuffer(data, dtype=np.uint8)}, name=name)
