"""A device's operating envelope while it is computed: static limits first, then driven limits at more and more
frequencies, in workers and as `gelcone.envelope` computes them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gelcone.motion.driven import REFINEMENTS, rows_of, unknown_between
from gelcone.motion.envelope import plane_of, pull_in_of, recommended_peaks
from gelcone.motion.plane import DRIVEN_LIMITS, DriveShape, Plane
from gelcone.motion.static_limits import STATIC_LIMITS, peaks_of, static_limits_of
from gelcone.quantity import Array
from gelcone.studio.grids import Source, subject_of
from gelcone.studio.long_work import Work
from gelcone.studio.look import scales

FIRST_TASK, TASK = 2, 4
"""Frequencies in a task: until the first picture, and later."""
STEPS = (16, 8, 4, 2, 1)
"""Strides through the frequencies, from coarse to fine."""
EXPECTED = 1.8
"""Approximate number of frequencies of a finished envelope, over that of its first grid; for the progress shown."""


# --- in the workers --------------------------------------------------------------------------------------------------


@lru_cache(maxsize=4)
def _plane(path: Path | None, time: int, text: str | None, options: str) -> Plane:
    return plane_of(subject_of(path, time, text, options).model, threads=1)


class Axes(NamedTuple):
    """The first grid of drive frequencies in the model's units, and the scales to hertz and volts."""

    omegas: Array
    hertz: float
    volts: float


def find_axes(source: Source) -> Axes:
    """The `Axes` of an envelope."""
    plane, by = _plane(*source.key), scales(source.subject())
    return Axes(plane.default_frequencies(), by["frequency"], by["voltage"])


class Limits(NamedTuple):
    """The voltage of each of `STATIC_LIMITS` and the default peak voltages in the model's units, the film (``membrane``
    or ``cone``) whose pull-in is used, the shape of the drive, and whether static limits are of a drive that is held at
    its peak, with the bias of films in opposite phase in proportion."""

    static: Array
    peaks: Array
    pull_in_of: str
    shape: DriveShape
    in_proportion: bool = False


def find_limits(source: Source) -> Limits:
    """The `Limits` under a constant voltage."""
    plane = _plane(*source.key)
    static = static_limits_of(plane)
    in_proportion = plane.model.system.in_opposite_phase
    return Limits(static, peaks_of(plane, static), pull_in_of(plane), plane.shape, in_proportion)


def find_rows(source: Source, omegas: Array, static: Array, around: Array | None = None) -> dict[str, Array]:
    """The limits of the motion at some drive frequencies, from `rows_of`; searched near the peak voltages ``around``
    (frequencies,), default from the lowest up."""
    plane, pull_in = _plane(*source.key), float(static[-1])
    rows = rows_of(plane, omegas, peaks_of(plane, static), None, pull_in=pull_in, around=around, yields=False)
    return {name: rows[name] for name in ("frequency", "low", "high", "final_below")}


def find_between(
    source: Source, rows: dict[str, Array], ceiling: float, confirmed: set[tuple[float, float]]
) -> tuple[Array, Array, set[tuple[float, float]]]:
    """The frequencies to add between rows, where the lowest limit is not on a straight line; the limits next to them;
    and the pairs of rows confirmed to need none."""
    return *unknown_between(_plane(*source.key), rows, ceiling, confirmed), confirmed


# --- in the studio ---------------------------------------------------------------------------------------------------


async def draw_envelope(work: Work, source: Source) -> None:
    """Computes a device's operating envelope and sends it to the page whenever it has grown."""
    await _Envelope(work, source).grow()


class _Envelope:
    axes: Axes
    limits: Limits

    def __init__(self, work: Work, source: Source) -> None:
        self.work, self.source = work, source
        self.rows: dict[str, Array] = {}
        self._room = asyncio.Semaphore(work.pool.size + 1)

    async def grow(self) -> None:
        self.axes, self.limits = await asyncio.gather(self._do(find_axes), self._do(find_limits))
        await self._show()
        await self._begin(self.axes.omegas)
        ceiling = min(float(np.nanmin(self.limits.static, initial=np.inf)), float(self.limits.peaks[-1]))
        confirmed: set[tuple[float, float]] = set()
        for _ in range(REFINEMENTS):
            pairs = np.array_split(np.arange(len(self.rows["frequency"]) - 1), self.work.pool.size)
            parts = [slice(own[0], own[-1] + 2) for own in pairs if own.size]
            cut = [{name: values[part] for name, values in self.rows.items()} for part in parts]
            answers = await asyncio.gather(*(self._do(find_between, rows, ceiling, confirmed) for rows in cut))
            confirmed = confirmed.union(*(own for *_, own in answers))
            between, around = (np.concatenate([part[k] for part in answers]) for k in (0, 1))
            if not between.size:
                break
            tasks = -(-between.size // TASK)
            await self._find_rows(zip(np.array_split(between, tasks), np.array_split(around, tasks), strict=True))
        await self.work.tell("done", grid="envelope")

    async def _do(self, function: Any, *arguments: Any) -> Any:
        async with self._room:
            return await self.work.do(function, self.source, *arguments)

    async def _begin(self, omegas: Array) -> None:
        order = np.array(list(dict.fromkeys(k for step in STEPS for k in range(0, len(omegas), step))))
        first = FIRST_TASK * self.work.pool.size
        tasks = [*np.array_split(order[:first], self.work.pool.size)]
        tasks += np.array_split(order[first:], -(-max(len(order) - first, 1) // TASK))
        await self._find_rows((omegas[np.sort(places)],) for places in tasks if places.size)

    async def _find_rows(self, tasks: Iterable[tuple[Array, ...]]) -> None:
        async def find(omegas: Array, *around: Array) -> None:
            new = await self._do(find_rows, omegas, self.limits.static, *around)
            if self.rows:
                order = np.argsort(np.concatenate([self.rows["frequency"], new["frequency"]]))
                new = {name: np.concatenate([values, new[name]])[order] for name, values in self.rows.items()}
            self.rows = new
            await self._show()

        await asyncio.gather(*(find(*task) for task in tasks))

    async def _show(self) -> None:
        """Sends what is known so far, in volts and hertz."""
        omegas, hertz, volts = self.axes
        static, peaks, pull_in_of, shape, in_proportion = self.limits
        low = self.rows.get("low", np.empty((0, len(DRIVEN_LIMITS))))
        arrays = {
            "frequency": self.rows.get("frequency", np.empty(0)) * hertz,
            "window": recommended_peaks(low, float(np.nanmin(static, initial=np.inf)), peaks) * volts,
        }
        arrays |= {f"limit {name}": low[:, k] * volts for k, name in enumerate(DRIVEN_LIMITS)}
        await self.work.tell(
            "envelope",
            arrays,
            limits=list(DRIVEN_LIMITS),
            static=dict(zip(STATIC_LIMITS, (static * volts).tolist(), strict=True)),
            highest=float(peaks[-1]) * volts,
            least=float(omegas[0]) * hertz,
            most=float(omegas[-1]) * hertz,
            pull_in_of=pull_in_of,
            shape={"voltage_amplitude": shape.amplitude, "voltage_offset": shape.bias},
            in_proportion=in_proportion,
            share=min(len(arrays["frequency"]) / (EXPECTED * len(omegas)), 0.99),
        )
