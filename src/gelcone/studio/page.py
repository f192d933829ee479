"""One open page: what it asks is read, checked and answered; the newest request wins.

A page has slots. A slot does one thing at a time; what arrives meanwhile replaces what waits. What runs is told to stop
once it has had its grace: stopped at once, a slider that moves sixty times a second would never see an answer.
"""

from __future__ import annotations

import asyncio
import json
import logging
import time
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from gelcone._version import __version__
from gelcone.analyses.subject import Subject
from gelcone.atlas.processes import ProcessesEnded
from gelcone.atlas.refinement import refine
from gelcone.codes import Regime
from gelcone.errors import InputError, MissingDependency
from gelcone.presets import load_presets
from gelcone.progress import Stopped, Watch, watching
from gelcone.studio import exports, look
from gelcone.studio.branches import EVENTS, follow_branches, follow_loci
from gelcone.studio.controls import Control, as_json, before_changes, controls_of
from gelcone.studio.frames import pack
from gelcone.studio.grids import (
    COARSEST,
    FIRST_TASK,
    FREQUENCIES,
    TASK,
    VOLTAGES,
    Axis,
    Source,
    axis,
    even_tasks,
    find_envelope,
    kinds,
    load,
    thresholds,
)
from gelcone.studio.pool import Pool
from gelcone.studio.setting import OWN_FILE, Setting, Shelf, typed

_log = logging.getLogger(__name__)
GRACE = 0.15
"""Seconds that what runs may go on after something newer has come."""
RATE, BURST = 200.0, 400
"""Messages a second that are read, and how many at once."""
LONGEST_ID = 2**53
PERIODS = (1, 500)
LANES = ("map", "strip", "envelope", "export")
"""Long work, each in a lane of its own."""
MAP_CELLS = (65, 49)
STRIP_VALUES = 241
PROGRESS_SECONDS = 0.25


class Slot:
    """Does the newest of what it is given for each side of the page, one after the other."""

    def __init__(self, work: Callable[[str, Any], Awaitable[None]]) -> None:
        self.work, self.watch = work, Watch()
        self.refines = False
        """Whether what runs only adds to what the page shows already."""
        self._next: dict[str, Any] = {}
        self._side = ""
        self._began = 0.0
        self._wake = asyncio.Event()

    @property
    def overtaken(self) -> bool:
        """Whether something newer waits and the grace is over."""
        return self._side in self._next and time.monotonic() - self._began > GRACE

    def give(self, side: str, request: Any) -> None:
        self._next[side] = request
        self._wake.set()
        left = self._began + GRACE - time.monotonic()
        asyncio.get_running_loop().call_later(max(left, 0.0), self._overtake, self.watch)

    def put_off(self, side: str) -> None:
        """Stops at once what only refines an older picture of a side: it would slow the newer one down."""
        if self.refines and self._side == side:
            self.watch.stop.set()

    def _overtake(self, watch: Watch) -> None:
        if self._side in self._next and self.watch is watch:
            watch.stop.set()

    async def run(self) -> None:
        while True:
            if not self._next:
                self._wake.clear()
                await self._wake.wait()
            self._side = next(iter(self._next))
            request = self._next.pop(self._side)
            self.watch, self._began, self.refines = Watch(), time.monotonic(), False
            with suppress(Stopped, WebSocketDisconnect):
                await self.work(self._side, request)

    def end(self) -> None:
        self.watch.stop.set()


class Page:
    """A page and its connection."""

    def __init__(self, socket: WebSocket, shelf: Shelf, pool: Pool, saving: Pool) -> None:
        self.socket, self.shelf, self.pool, self.saving = socket, shelf, pool, saving
        self.first, self.second = Slot(self._look), Slot(self._examine)
        self._threads = ThreadPoolExecutor(2)
        self._sending = asyncio.Lock()
        self._lanes = {name: self._pool(name).lane() for name in LANES}
        self._tasks: set[asyncio.Task[None]] = set()
        self._ended = asyncio.Event()

    # --- reading ---------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Reads and answers until the page is gone."""
        tasks = [
            asyncio.ensure_future(part)
            for part in (self._read(), self.first.run(), self.second.run(), self._ended.wait())
        ]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                with suppress(WebSocketDisconnect):
                    task.result()
        finally:
            for task in tasks:
                task.cancel()

    def end(self) -> None:
        """Stops what the page still computes, and its connection."""
        self._ended.set()
        self.first.end()
        self.second.end()
        for task in self._tasks:
            task.cancel()
        for name, lane in self._lanes.items():
            self._pool(name).leave(lane)
        self._lanes = {}
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _pool(self, lane: str) -> Pool:
        """Who works in a lane: a file that one waits for does not queue behind a map."""
        return self.saving if lane == "export" else self.pool

    async def _read(self) -> None:
        tokens, before = float(BURST), time.monotonic()
        while True:
            message = await self.socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            now = time.monotonic()
            tokens, before = min(tokens + RATE * (now - before), BURST) - 1.0, now
            if tokens < 0.0:
                await asyncio.sleep(-tokens / RATE)
            if self._ended.is_set():
                return
            await self._answer(message.get("text"))

    async def _answer(self, text: str | None) -> None:
        """Answers a message; whatever is wrong with it is said, and nothing ends."""
        number = None
        try:
            request = _request(text)
            number = request["id"]
            await _KINDS[request["kind"]](self, request)
        except WebSocketDisconnect:
            raise
        except Exception as error:
            await self.fail(number, error)

    async def _hello(self, request: Mapping[str, Any]) -> None:
        await self.send(
            {
                "kind": "hello",
                "id": request["id"],
                "version": __version__,
                "devices": list(self.shelf.devices),
                "presets": {name: preset.purpose for name, preset in load_presets().items()},
                **look.legend(),
            }
        )

    async def _take_look(self, request: dict[str, Any]) -> None:
        request["setting"] = Setting.read(request.get("setting"))
        periods = request.get("periods", look.PERIODS)
        if not (isinstance(periods, int | float) and PERIODS[0] <= periods <= PERIODS[1]):
            raise InputError(f"periods: must be from {PERIODS[0]} to {PERIODS[1]}")
        if _text(request, "side") not in ("a", "b"):
            raise InputError("side: must be a or b")
        panels = request.setdefault("panels", [])
        if not isinstance(panels, list):
            raise InputError("panels: must be a list of names")
        self.first.give(request["side"], request)
        self.second.put_off(request["side"])

    # --- what a look shows -------------------------------------------------------------------------------------------

    async def _look(self, side: str, request: dict[str, Any]) -> None:
        """The run from the start, and the controls if they are asked for; then hands on to the second slot."""

        def compute() -> tuple[Subject, look.Parts, dict[str, Any]]:
            setting = request["setting"]
            more: dict[str, Any] = {}
            if request.get("controls"):
                more["controls"] = as_json(self.controls(setting))
            subject = self.shelf.subject(setting)
            more["about"] = look.about(subject)
            return subject, look.response(subject, request.get("periods", look.PERIODS)), more

        found = await self._computed(self.first, request, compute)
        if found is None:
            return
        subject, parts, more = found
        self.second.give(side, (request, subject))
        await self._show("response", request, parts, more)

    async def _examine(self, side: str, job: tuple[dict[str, Any], Subject]) -> None:
        """The kind of motion with its evidence, more section points if it does not repeat, and the open panels."""
        request, subject = job
        wanted = ["kind", *(name for name in ("spectrum", "statics") if name in request["panels"])]
        for name in wanted:
            self.second.refines = name == "section"
            parts = await self._computed(self.second, request, partial(look.STAGES[name], subject))
            if parts is None:
                return
            await self._show(name, request, parts)
            self.pool.warm(load)
            if name == "kind" and parts.words["regime"] in (Regime.CHAOTIC, Regime.QUASI_PERIODIC, Regime.TRANSIENT):
                wanted.append("section")

    def controls(self, setting: Setting) -> list[Control]:
        """The controls of a setting; those used last are kept."""
        return controls_of(self.shelf.subject(before_changes(setting)))

    async def _computed(self, slot: Slot, request: Mapping[str, Any], compute: Callable[[], Any]) -> Any:
        """What ``compute`` gives, in a thread under the slot's watch; None after an error, which the page is told."""
        if self._ended.is_set():
            raise Stopped
        watch = slot.watch

        def watched() -> Any:
            with watching(watch):
                return compute()

        try:
            found = await asyncio.get_running_loop().run_in_executor(self._threads, watched)
        except Stopped:
            raise
        except Exception as error:
            await self.fail(request["id"], error, request.get("side"))
            return None
        if slot.overtaken:
            raise Stopped
        return found

    # --- long work ---------------------------------------------------------------------------------------------------

    async def _map(self, request: dict[str, Any]) -> None:
        """A map over two parameters: cells from coarse to fine, then the thresholds over it, all other cells, and
        the curves of bifurcations."""
        setting = Setting.read(request.get("setting"))
        controls = self.controls(setting)
        x, y = (axis(controls, request.get(name), count) for name, count in (("x", MAP_CELLS[0]), ("y", MAP_CELLS[1])))
        if x.name == y.name:
            raise InputError(f"{x.name}: is on both axes; choose two parameters")
        await self._begin("map", request, partial(self._fill_map, request, self.source(setting), x, y))

    async def _fill_map(self, request: dict[str, Any], source: Source, x: Axis, y: Axis) -> None:
        work = Filling(self, "map", request, source, (x, y))
        await self.send({"kind": "grid", "grid": "map", "id": request["id"], "cells": work.shape})
        levels = refine(work.shape, COARSEST)
        wanted = next(levels)
        drawn = False
        while True:
            found = await work.compute(wanted)
            if not drawn:
                drawn = True
                await self._thresholds(work, x, y)
            try:
                wanted = levels.send(found)
            except StopIteration:
                break
        await work.compute(np.flatnonzero(work.kinds < 0))
        await self.send({"kind": "done", "grid": "map", "id": request["id"]})
        for event in EVENTS:
            with suppress(InputError):  # there is none
                found = await work.do(follow_loci, source, x, y, event)
                await self.send({"kind": "loci", "id": request["id"], "name": event}, found)
        await self.send({"kind": "followed", "id": request["id"]})

    async def _thresholds(self, work: Filling, x: Axis, y: Axis) -> None:
        """The lines of thresholds over a map of which one axis is the voltage."""
        volts, other = (x, y) if x.name in VOLTAGES else (y, x)
        if volts.name not in VOLTAGES:
            return
        lines = await work.do(thresholds, work.source, {other.name: other.texts(range(len(other.values)))})
        scale = 1e-3 if volts.unit == "kV" else 1.0
        head = {"kind": "thresholds", "id": work.request["id"], "upright": volts is x, "names": list(lines)}
        await self.send(head, {"at": other.values} | {name: values * scale for name, values in lines.items()})

    async def _strip(self, request: dict[str, Any]) -> None:
        """A sweep of one parameter: the section at each value, from coarse to fine, then the branches over it."""
        setting = Setting.read(request.get("setting"))
        over = axis(self.controls(setting), request.get("over"), STRIP_VALUES)
        await self._begin("strip", request, partial(self._fill_strip, request, self.source(setting), over))

    async def _fill_strip(self, request: dict[str, Any], source: Source, over: Axis) -> None:
        work = Filling(self, "strip", request, source, (over,))
        await self.send({"kind": "grid", "grid": "strip", "id": request["id"], "cells": work.shape})
        places = np.arange(STRIP_VALUES)
        for step in (8, 4, 2, 1):
            await work.compute(places[(places % step == 0) & (work.kinds < 0)])
        await self.send({"kind": "done", "grid": "strip", "id": request["id"]})
        head = {"kind": "branches", "id": request["id"]}
        try:
            found = await work.do(follow_branches, source, over)
        except InputError as error:
            await self.send({**head, "kinds": [], "none": " ".join(str(error).split())})
            return
        arrays = found.pop("arrays")
        await self.send({**head, **found}, arrays)

    async def _envelope(self, request: dict[str, Any]) -> None:
        setting = Setting.read(request.get("setting"))
        if self.shelf.subject(setting).device is None:
            raise InputError("an envelope is that of a device; choose one")
        await self._begin("envelope", request, partial(self._find_envelope, request, self.source(setting)))

    async def _find_envelope(self, request: dict[str, Any], source: Source) -> None:
        lane = self._lanes["envelope"]
        run = self.pool.begin(lane)
        work = asyncio.ensure_future(self.pool.do(lane, run, find_envelope, source))
        while not (await asyncio.wait([work], timeout=PROGRESS_SECONDS))[0]:
            share = self.pool.progress(lane)
            await self.send({"kind": "progress", "grid": "envelope", "id": request["id"], "share": share})
        found = work.result()
        if found is not None:
            arrays = found.pop("arrays")
            await self.send({"kind": "envelope", "id": request["id"], **found}, arrays)

    async def _device_file(self, request: dict[str, Any]) -> None:
        """The device as it is set, as a device file."""
        device = self.shelf.subject(Setting.read(request.get("setting"))).device
        if device is None:
            raise InputError("a preset is no device; only a device has a file")
        head = {"kind": "file", "id": request["id"], "name": OWN_FILE}
        await self.send(head, {"data": np.frombuffer(device.to_toml().encode(), dtype=np.uint8)})

    async def _code(self, request: dict[str, Any]) -> None:
        """The command and the Python lines that give what the page shows."""
        setting, wanted = self._wanted(request)
        self.shelf.subject(setting)
        device = self.shelf.called(setting)
        text = {"command": exports.command(setting, wanted, device), "python": exports.lines(setting, wanted, device)}
        await self.send({"kind": "code", "id": request["id"], "own_file": setting.file is not None, **text})

    async def _export(self, request: dict[str, Any]) -> None:
        """A file of what the page shows."""
        setting, wanted = self._wanted(request)
        form = _text(request, "format")
        if form not in exports.FORMATS:
            raise InputError(f"format: must be one of {', '.join(exports.FORMATS)}")
        await self._begin("export", request, partial(self._make, request, self.source(setting), wanted, form))

    async def _make(self, request: dict[str, Any], source: Source, wanted: exports.Wanted, form: str) -> None:
        lane = self._lanes["export"]
        data = await self.saving.do(lane, self.saving.begin(lane), exports.make, source, wanted, form)
        if data is not None:
            head = {"kind": "file", "id": request["id"], "name": f"{wanted.analysis.command}.{form}"}
            await self.send(head, {"data": np.frombuffer(data, dtype=np.uint8)})

    def _wanted(self, request: Mapping[str, Any]) -> tuple[Setting, exports.Wanted]:
        setting, name = Setting.read(request.get("setting")), _text(request, "what")
        names = exports.OVER.get(name, ())
        counts = MAP_CELLS if len(names) == 2 else (STRIP_VALUES,)
        controls = self.controls(setting) if names else []
        axes = tuple(axis(controls, request.get(n), count) for n, count in zip(names, counts, strict=False))
        wanted = exports.Wanted.read(name, request.get("options", {}), axes)
        return exports.fitting(setting, wanted), wanted

    async def _begin(self, name: str, request: dict[str, Any], work: Callable[[], Awaitable[None]]) -> None:
        """Starts long work in place of what runs under that name."""

        async def guarded() -> None:
            with suppress(WebSocketDisconnect):
                try:
                    await work()
                except (Outdated, WebSocketDisconnect):
                    pass
                except Exception as error:
                    await self.fail(request["id"], error)

        self._pool(name).begin(self._lanes[name])
        for task in self._tasks:
            if task.get_name() == name:
                task.cancel()
        task = asyncio.create_task(guarded(), name=name)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _cancel(self, request: dict[str, Any]) -> None:
        """Ends the long work that the page does not look at any more."""
        name = _text(request, "grid")
        if name not in self._lanes:
            raise InputError(f"grid: must be one of {', '.join(self._lanes)}")
        self._pool(name).begin(self._lanes[name])
        for task in self._tasks:
            if task.get_name() == name:
                task.cancel()

    def source(self, setting: Setting) -> Source:
        """What a worker needs to read the subject of a setting; `InputError` as `Shelf.subject`."""
        self.shelf.subject(setting)
        path = self.shelf.path(setting)
        return Source(None if path is None else str(path), typed(setting))

    # --- sending -----------------------------------------------------------------------------------------------------

    async def _show(self, kind: str, request: Mapping[str, Any], parts: look.Parts, more: Any = None) -> None:
        head = {"kind": kind, "id": request["id"], "side": request["side"], "words": parts.words, **(more or {})}
        await self.send(head, parts.arrays)

    async def fail(self, number: Any, error: Exception, side: str | None = None) -> None:
        """Tells the page what is wrong, and with which control; a fault of gelcone goes to the terminal, too."""
        if isinstance(error, ProcessesEnded):
            message = "a worker process ended, perhaps for lack of memory; change a setting to try again"
        elif isinstance(error, InputError | MissingDependency):
            message = " ".join(str(error).split())
        else:
            _log.error("the studio failed", exc_info=error)
            message = "the studio failed at this; the terminal says how"
        control = getattr(error, "field", None) or message.removeprefix("--set ").partition(" ")[0].rstrip(":")
        await self.send({"kind": "error", "id": number, "side": side, "control": control, "message": message})

    async def send(self, head: Mapping[str, Any], arrays: Mapping[str, Any] | None = None) -> None:
        frame = pack(head, arrays)
        async with self._sending:
            if self.socket.application_state is WebSocketState.CONNECTED:
                try:
                    await self.socket.send_bytes(frame)
                except RuntimeError:  # closed meanwhile, as by a browser that is too busy to answer a ping
                    raise WebSocketDisconnect from None


class Outdated(Exception):
    """Something newer has been asked for."""


class Filling:
    """The cells of one run of a map or strip, as they come. ``kinds`` holds what is known, -1 elsewhere."""

    def __init__(self, page: Page, name: str, request: dict[str, Any], source: Source, axes: tuple[Axis, ...]) -> None:
        self.page, self.name, self.request, self.source, self.axes = page, name, request, source, axes
        self.shape = tuple(len(axis.values) for axis in axes)
        self.kinds = np.full(int(np.prod(self.shape)), -1, dtype=np.int64)
        self.lane = page._lanes[name]
        self.run = page.pool.begin(self.lane)
        self._room = asyncio.Semaphore(
            page.pool.size + 1
        )  # one more than workers: none waits, and others get their turn

    async def compute(self, cells: Any) -> Any:
        """The kinds of some cells, which the page is sent task by task; `Outdated` once the run is."""
        alike = cells[np.lexsort(self._groups(cells))]
        most = FIRST_TASK if self.kinds.max() < 0 else TASK
        await asyncio.gather(*(self._task(part) for part in even_tasks(alike, self.page.pool.size, most)))
        return self.kinds[cells]

    def _groups(self, cells: Any) -> list[Any]:
        """What cells are sorted by: cells of one frequency are computed side by side at a third of the cost."""
        places = np.unravel_index(cells, self.shape)
        return [cells, *(own for axis, own in zip(self.axes, places, strict=True) if axis.name in FREQUENCIES)]

    async def do(self, function: Callable[..., Any], *arguments: Any) -> Any:
        found = await self.page.pool.do(self.lane, self.run, function, *arguments)
        if found is None:
            raise Outdated
        return found

    async def _task(self, cells: Any) -> None:
        places = np.unravel_index(cells, self.shape)
        texts = {axis.name: axis.texts(own.tolist()) for axis, own in zip(self.axes, places, strict=True)}
        async with self._room:
            found = await self.do(kinds, self.source, texts)
        self.kinds[cells] = found["regime"]
        share = float((self.kinds >= 0).mean())
        if self.name == "map":
            del found["section"]
        head = {"kind": "cells", "grid": self.name, "id": self.request["id"], "share": share}
        await self.page.send(head, {"places": np.asarray(cells, dtype=float), **found})


_KINDS: Mapping[str, Callable[[Page, dict[str, Any]], Awaitable[None]]] = {
    "hello": Page._hello,
    "look": Page._take_look,
    "map": Page._map,
    "strip": Page._strip,
    "envelope": Page._envelope,
    "cancel": Page._cancel,
    "code": Page._code,
    "device": Page._device_file,
    "export": Page._export,
}
"""What a page may ask."""


def _request(text: str | None) -> dict[str, Any]:
    """A message of the page: an object with a known ``kind`` and a number ``id``; `InputError` for anything else."""
    if text is None:
        raise InputError("the message is not text; send JSON")
    try:
        request = json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise InputError("the message is not JSON") from None
    if not isinstance(request, dict) or _text(request, "kind") not in _KINDS:
        raise InputError("the message must be an object whose kind is one of: " + ", ".join(_KINDS))
    number = request.get("id")
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < LONGEST_ID:
        raise InputError("id: must be a whole number")
    return request


def _text(request: Mapping[str, Any], name: str) -> str:
    """A text of a message, empty where there is none; `InputError` for anything else."""
    value = request.get(name, "")
    if not isinstance(value, str):
        raise InputError(f"{name}: must be a text")
    return value


def _refuse(constant: str) -> Any:
    raise ValueError(constant)
