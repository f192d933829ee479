"""One open page: what it asks is read, checked and answered."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from gelcone import permission
from gelcone._version import __version__
from gelcone.analyses.request import Subject
from gelcone.atlas.processes import ProcessesEnded
from gelcone.codes import Regime
from gelcone.errors import InputError, MissingDependency
from gelcone.physics.film.pull_in import CurveKey, keep_curve, known_curves
from gelcone.physics.model import ConeModel
from gelcone.presets import load_presets
from gelcone.progress import Stopped, Watch, watching
from gelcone.studio import asked, look, profiles
from gelcone.studio.controls import as_json
from gelcone.studio.envelope import draw_envelope
from gelcone.studio.frames import pack
from gelcone.studio.grids import (
    Source,
    find_curves,
    find_profiles,
    find_pull_in,
    find_rests,
    find_static,
    load,
    make_membrane,
)
from gelcone.studio.lanes import SIDES, Lanes
from gelcone.studio.long_work import Work, fill_map, fill_strip, make_file
from gelcone.studio.pool import Pool
from gelcone.studio.setting import OWN_FILE, Setting, Shelf
from gelcone.studio.slot import GRACE, Slot

_log = logging.getLogger(__name__)
RATE, BURST = 200.0, 400
"""Messages a second that are read, and how many at once."""
RUN_SECONDS, EVIDENCE_SECONDS = 15.0, 30.0
"""After which a run, and each part of what follows it, is given up."""
THREADS = 3
"""Of a page: one for each slot, and one in which other requests are read."""
A_PICTURE, LEAST = 0.016, 0.003
"""Seconds of processor for each picture of a moving hand: what the picture leaves of the first, and at least the
second, is saved up for the kind of motion, which is found as often as that suffices."""
WANDERING = (Regime.CHAOTIC, Regime.QUASI_PERIODIC, Regime.TRANSIENT)
SAME_REST = 1e-9
"""Rests closer than this, in units of b - a, are one in a picture, but of a chaotic motion."""
RESTED_SECONDS = 0.2
"""Without a newer look, after which what takes longer than a picture is computed."""


class _Late(Exception):
    """Why a part of what follows a run is missing, such as that it takes longer than a page may have."""


class Page:
    """A page and its connection."""

    def __init__(self, socket: WebSocket, shelf: Shelf, pool: Pool, saving: Pool) -> None:
        self.socket, self.shelf, self.pool = socket, shelf, pool
        self.first, self.second = Slot(self._look, patient=True), Slot(self._examine)
        self._threads = ThreadPoolExecutor(THREADS, initializer=permission.limit, initargs=(shelf.names,))
        self._taken, self._cost, self._saved = (dict.fromkeys(SIDES, 0.0) for _ in range(3))
        """For how long the kind of motion of each side was examined last, the seconds of processor that it took, and
        those saved up for the next."""
        self._newest, self._known = (dict.fromkeys(SIDES, -1) for _ in range(2))
        """The numbers of the newest look of each side, and of the last newest one whose kind of motion the page has."""
        self._sending = asyncio.Lock()
        self.lanes = Lanes(pool, saving, self.send, self.fail)
        self._profiles: set[str] = set()
        """Names of the tables of profiles that the page has."""
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
                if not task.cancelled():  # as what waits for a thread is, once the page has ended
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
        self.lanes.end()
        self._threads.shutdown(wait=False, cancel_futures=True)

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
        number = side = None
        try:
            request = asked.read(text, _KINDS)
            number = request["id"]
            side = request.get("side") if request["kind"] == "look" and request.get("side") in SIDES else None
            await _KINDS[request["kind"]](self, request)
        except WebSocketDisconnect:
            raise
        except Exception as error:
            await self.fail(number, error, side)

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
        request["periods"] = look.check_periods(request.get("periods", look.PERIODS))
        if asked.text_of(request, "side") not in SIDES:
            raise InputError("side: must be a or b")
        panels = request.setdefault("panels", [])
        if not isinstance(panels, list):
            raise InputError("panels: must be a list of names")
        side, request["made"] = request["side"], False
        request["follows"] = self._known[side] == self._newest[side]
        self._newest[side] = request["id"]
        self.lanes.cancel(side)
        self.first.give(side, request)
        self.second.put_off(side)

    # --- what a look shows -------------------------------------------------------------------------------------------

    async def _look(self, side: str, request: dict[str, Any]) -> None:
        """The run from the start, and the controls if they are asked for; then hands on to the second slot."""

        def read() -> dict[str, Any]:
            self.shelf.at_once(request["setting"], lambda subject: None)
            return {"controls": as_json(self.shelf.controls(request["setting"]))}

        def compute() -> tuple[Subject, look.Parts, dict[str, Any]]:
            subject, parts, request["stands"] = self.shelf.at_once(
                request["setting"], lambda own: look.response(own, request["periods"]), patient=request["made"]
            )
            about = look.about(subject) | {"membrane": profiles.names(subject.model), "stands": request["stands"]}
            return subject, parts, {"about": about}

        if request.get("controls"):  # they come before the run, which may take a while
            known = await self._computed(self.first, request, read)
            if known is None:
                return
            await self._show("subject", request, look.Parts(), known)
        found = await self._computed(self.first, request, compute)
        if found is None:
            return
        subject, parts, more = found
        self.second.give(side, (request, subject))
        await self._show("response", request, parts, more)

    async def _examine(self, side: str, job: tuple[dict[str, Any], Subject]) -> None:
        """The kind of motion with its evidence, more section points if it does not repeat, and the open panels."""
        request, subject = job
        loop = asyncio.get_running_loop()
        self._saved[side] += max(A_PICTURE - self.first.cost, LEAST)
        # what is dear, or would be stopped while the hand moves, waits until it rests; a hand that comes back only once
        # it has seen the kind of motion has rested
        at_once = self._taken[side] < GRACE and (request["follows"] or self._saved[side] >= self._cost[side])
        await self.second.until(loop.time() + (0.0 if at_once else GRACE))
        began, self._saved[side] = loop.time(), 0.0
        try:
            await self._examine_now(side, request, subject)
        finally:
            self._taken[side], self._cost[side] = loop.time() - began, self.second.cost

    async def _examine_now(self, side: str, request: dict[str, Any], subject: Subject) -> None:
        wanted = ["kind", *(name for name in ("spectrum",) if name in request["panels"])]
        for name in wanted:
            self.second.refines = name == "section"
            try:
                parts = await self._computed(self.second, request, partial(look.STAGES[name], subject))
                await self._show(name, request, parts)
            except _Late as late:
                await self._late(request, name, late)
                parts, self.second.missing = look.Settled(words={"regime": None}), []
            self.pool.warm(load)
            if name == "kind" and request["id"] == self._newest[side]:
                self._known[side] = request["id"]
                self.lanes.start(
                    side, request["id"], partial(self._afterwards, request, subject, parts, self.second.missing)
                )
            if name == "kind" and parts.words["regime"] in WANDERING:
                wanted.append("section")

    async def _afterwards(
        self, request: dict[str, Any], subject: Subject, kind: look.Settled, missing: list[CurveKey]
    ) -> None:
        """Send what is stored of other drives at once; once the hand rests, current and power, and what takes longer:
        first of all the membrane for which a cone stands."""
        if request["stands"]:
            return await self._make_membrane(request)
        model = subject.model
        kept = look.PULL_INS.has(model), "statics" in request["panels"] and look.STATICS.has(model)
        if kept[0]:
            await self._add("numbers", request, look.margins, subject)
        if kept[1]:
            await self._add("statics", request, look.statics, subject)
        await asyncio.sleep(RESTED_SECONDS)
        if kind.run is not None:
            await self._add("numbers", request, look.electrical, subject, kind.run)
        work, source = self._worker(request)
        try:
            if not await self._rests_there(work, source, request, kind):
                self.first.give(request["side"], request)
                return
            await self._find_static(work, source, request, subject, kept)
            await self._send_profiles(request, model, work, source)
            if missing:
                for key, curve in zip(missing, await work.do(find_curves, source, missing), strict=True):
                    keep_curve(key, curve)
                self.second.give(request["side"], (request, subject))  # whose evidence they belong to
        except InputError as error:
            await self._late(request, "statics", error)
        except asyncio.CancelledError:
            self.lanes.drop(work)
            raise

    async def _make_membrane(self, request: dict[str, Any]) -> None:
        """Once the hand rests, the membrane that the picture lacks, in a worker; then the picture again, of it."""
        await asyncio.sleep(RESTED_SECONDS)
        work, source = self._worker(request)
        try:
            await work.do(make_membrane, source, request["periods"])
        except InputError as error:
            await self._late(request, "film", error)
        except asyncio.CancelledError:
            self.lanes.drop(work)
            raise
        else:
            self.first.give(request["side"], request | {"made": True})

    def _worker(self, request: Mapping[str, Any]) -> tuple[Work, Source]:
        """Who computes for the side of a look what takes longer, and what from."""
        return self.lanes.work(request["side"], request["id"]), asked.source(self.shelf, request["setting"])

    async def _late(self, request: Mapping[str, Any], stage: str, error: Exception) -> None:
        """Says why a stage of a look is missing."""
        message = " ".join(str(error).split())
        head = {"kind": "late", "id": request["id"], "side": request["side"], "stage": stage, "message": message}
        await self.send(head)

    async def _send_profiles(self, request: dict[str, Any], model: ConeModel, work: Work, source: Source) -> None:
        """The tables of profiles of the films that the page does not have yet."""
        for film, name in enumerate(profiles.names(model)):
            if name and name not in self._profiles:
                await self._show("profiles", request, await work.do(find_profiles, source, film))
                self._profiles.add(name)

    async def _add(
        self, name: str, request: Mapping[str, Any], compute: Callable[..., look.Parts], *given: Any
    ) -> None:
        """Shows what ``compute`` gives in a thread."""
        found = await asyncio.get_running_loop().run_in_executor(self._threads, compute, *given)
        await self._show(name, request, found)

    async def _rests_there(self, work: Work, source: Source, request: Mapping[str, Any], kind: look.Settled) -> bool:
        """Whether the picture shows the rests that a search finds."""
        guesses = self.shelf.guesses(request["setting"])
        if not guesses:
            return True
        moved = self.shelf.confirm(request["setting"], await work.do(find_rests, source, list(guesses)))
        return moved <= SAME_REST and not (moved > 0.0 and kind.words["regime"] in WANDERING)

    async def _find_static(
        self, work: Work, source: Source, request: dict[str, Any], subject: Subject, kept: tuple[bool, bool]
    ) -> None:
        """Pull-in, and the equilibria where they are shown, of which none is stored yet."""
        if not kept[0]:
            with suppress(InputError):
                look.PULL_INS.keep(subject.model, await work.do(find_pull_in, source))
                await self._add("numbers", request, look.margins, subject)
        if "statics" in request["panels"] and not kept[1]:
            look.STATICS.keep(subject.model, await work.do(find_static, source))
            await self._add("statics", request, look.statics, subject)

    async def _computed(self, slot: Slot, request: Mapping[str, Any], compute: Callable[[], Any]) -> Any:
        """The result of ``compute``, in a thread under the slot's watch; None after an error, which the page gets."""
        if self._ended.is_set():
            raise Stopped
        watch, loop = slot.watch, asyncio.get_running_loop()
        seconds = RUN_SECONDS if slot is self.first else EVIDENCE_SECONDS

        def watched() -> Any:
            began = time.thread_time()
            with watching(watch), known_curves() as missing:
                result = compute()
            slot.missing = list(missing)
            slot.cost += time.thread_time() - began
            return result

        limit = loop.call_later(seconds, watch.stop.set)
        try:
            found = await loop.run_in_executor(self._threads, watched)
        except Stopped:
            if loop.time() < limit.when() or slot.overtaken or self._ended.is_set():
                raise
            what = "the evidence" if slot is self.second else "the run"
            late = f"{what} takes more than {seconds:g} s; take a shorter run, or ask the command line (Save…)"
            if slot is self.second:
                slot.watch = Watch()  # for what comes next of this request
                raise _Late(late) from None
            await self.fail(request["id"], InputError(late), request.get("side"))
            return None
        except Exception as error:
            if slot is self.second:
                raise _Late(_in_words(error)) from None
            await self.fail(request["id"], error, request.get("side"))
            return None
        finally:
            limit.cancel()
        if slot.overtaken:
            raise Stopped
        return found

    # --- work of seconds ---------------------------------------------------------------------------------------------

    async def _begin(self, request: dict[str, Any]) -> None:
        """Starts one of `_LONG` in place of what runs in its lane."""
        read, do = _LONG[request["kind"]]
        work = self.lanes.work(request["kind"], request["id"])

        async def read_and_do() -> None:
            await do(work, *await self._in_thread(read, request))

        self.lanes.start(request["kind"], request["id"], read_and_do)

    async def _glance(self, request: dict[str, Any]) -> None:
        """A small picture of a device or preset as it is by itself."""

        async def answer() -> None:
            watch, loop = Watch(), asyncio.get_running_loop()
            limit = loop.call_later(RUN_SECONDS, watch.stop.set)
            try:
                parts, about = await self._in_thread(partial(_glimpse, watch), request)
            except Stopped:
                raise InputError(f"the picture takes more than {RUN_SECONDS:g} s") from None
            finally:
                limit.cancel()
                watch.stop.set()  # also where another one is asked for
            head = {"kind": "glance", "id": request["id"], "words": parts.words, "about": about}
            await self.send(head, parts.arrays)

        self.lanes.start("glance", request["id"], answer)

    async def _device_file(self, request: dict[str, Any]) -> None:
        """The device as it is set, as a device file."""

        async def answer() -> None:
            text = await self._in_thread(asked.device_file, request)
            head = {"kind": "file", "id": request["id"], "name": OWN_FILE}
            await self.send(head, {"data": np.frombuffer(text.encode(), dtype=np.uint8)})

        self.lanes.start("device", request["id"], answer)

    async def _code(self, request: dict[str, Any]) -> None:
        """The command and the Python lines that give what the page shows."""

        async def answer() -> None:
            words = await self._in_thread(asked.code, request)
            await self.send({"kind": "code", "id": request["id"], **words})

        self.lanes.start("code", request["id"], answer)

    async def _in_thread(self, read: Callable[[Shelf, Mapping[str, Any]], Any], request: Mapping[str, Any]) -> Any:
        """What a function makes of a request. Not in the event loop: a film that wrinkles takes it a while."""
        return await asyncio.get_running_loop().run_in_executor(self._threads, read, self.shelf, request)

    async def _cancel(self, request: dict[str, Any]) -> None:
        """Ends the long work that the page no longer shows."""
        name = asked.text_of(request, "grid")
        if name not in self.lanes:
            raise InputError(f"grid: must be one of {', '.join(self.lanes)}")
        self.lanes.stop(name)

    # --- sending -----------------------------------------------------------------------------------------------------

    async def _show(self, kind: str, request: Mapping[str, Any], parts: look.Parts, more: Any = None) -> None:
        head = {"kind": kind, "id": request["id"], "side": request["side"], "words": parts.words, **(more or {})}
        await self.send(head, parts.arrays)

    async def fail(self, number: Any, error: Exception, side: str | None = None) -> None:
        """Sends the page what is wrong, and with which control."""
        message = _in_words(error)
        control = getattr(error, "field", None) or message.removeprefix("--set ").partition(" ")[0].rstrip(":")
        await self.send({"kind": "error", "id": number, "side": side, "control": control, "message": message})

    async def send(self, head: Mapping[str, Any], arrays: Mapping[str, Any] | None = None) -> None:
        """Send a message in one frame, while the page is connected."""
        frame = pack(head, arrays)
        async with self._sending:
            if self.socket.application_state is WebSocketState.CONNECTED:
                try:
                    await self.socket.send_bytes(frame)
                except RuntimeError:  # closed meanwhile
                    raise WebSocketDisconnect from None


_LONG: Mapping[str, tuple[Callable[..., tuple[Any, ...]], Callable[..., Awaitable[None]]]] = {
    "map": (asked.over_two, fill_map),
    "strip": (asked.over_one, fill_strip),
    "envelope": (asked.of_device, draw_envelope),
    "export": (asked.to_save, make_file),
}
"""Work of seconds: what reads a request, and what then does it."""
_KINDS: Mapping[str, Callable[[Page, dict[str, Any]], Awaitable[None]]] = {
    "hello": Page._hello,
    "look": Page._take_look,
    "map": Page._begin,
    "strip": Page._begin,
    "envelope": Page._begin,
    "cancel": Page._cancel,
    "code": Page._code,
    "device": Page._device_file,
    "glance": Page._glance,
    "export": Page._begin,
}
"""What a page may ask."""


def _glimpse(watch: Watch, shelf: Shelf, request: Mapping[str, Any]) -> tuple[look.Parts, dict[str, Any]]:
    setting = Setting.read(request.get("setting"))
    if setting.file is not None or setting.values:
        raise InputError("a small picture is that of a device or preset as it is by itself; name one")
    with watching(watch), known_curves():
        subject, parts, _ = shelf.at_once(setting, look.glance)
        return parts, look.about(subject)


def _in_words(error: Exception) -> str:
    """What the page says of an error; a fault of gelcone goes to the terminal, too."""
    if isinstance(error, ProcessesEnded):
        return "a worker process ended, perhaps for lack of memory; change a setting to try again"
    if isinstance(error, InputError | MissingDependency):
        return " ".join(str(error).split())
    _log.error("the studio failed", exc_info=error)
    return "internal error; see the terminal"
