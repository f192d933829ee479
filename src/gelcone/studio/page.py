"""One open page: reads its requests, checks and answers them."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager, nullcontext, suppress
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
from gelcone.physics.film.pull_in import CurveKey, known_curves, store_curve
from gelcone.physics.model import ConeModel
from gelcone.presets import load_presets
from gelcone.progress import Stopped, Watch, watching
from gelcone.studio import asked, equilibria, look, profiles, settled
from gelcone.studio.controls import as_json, is_name
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
"""Messages read per second, and at most at once."""
RUN_SECONDS, EVIDENCE_SECONDS = 15.0, 30.0
"""Time limits of a run, and of each part of its evidence."""
THREADS = 3
"""Threads of a page: one for each slot, and one that reads other requests."""
A_PICTURE, LEAST = 0.016, 0.003
"""Processor time of one picture while a slider moves. What the run leaves of the first, but at least the second, is
saved up for the kind of motion, which is computed whenever the savings suffice."""
WANDERING = (Regime.CHAOTIC, Regime.QUASI_PERIODIC, Regime.TRANSIENT)
SAME_REST = 1e-9
"""Rests closer than this, in units of b - a, look alike in a picture of a regular motion."""
RESTED_SECONDS = 0.2
"""Time without a new look after which slower computations begin."""


class Page:
    """A page and its connection."""

    def __init__(self, socket: WebSocket, shelf: Shelf, pool: Pool, saving: Pool) -> None:
        self.socket, self.shelf, self.pool = socket, shelf, pool
        self.first, self.second = Slot(self._look, patient=True), Slot(self._examine)
        self._threads = ThreadPoolExecutor(THREADS, initializer=permission.limit, initargs=(shelf.names,))
        self._taken, self._cost, self._saved = (dict.fromkeys(SIDES, 0.0) for _ in range(3))
        """By side: duration and processor time of the last computation of the kind of motion, and processor time saved
        up for the next."""
        self._newest, self._known = (dict.fromkeys(SIDES, -1) for _ in range(2))
        """By side: the newest look, and the newest look whose kind of motion the page has received."""
        self._sending = asyncio.Lock()
        self.lanes = Lanes(pool, saving, self.send, self.fail)
        self._profiles: set[str] = set()
        """Names of the profile tables that the page has received."""
        self._ended = asyncio.Event()

    # --- reading ---------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Reads and answers requests until the connection ends."""
        tasks = [
            asyncio.ensure_future(part)
            for part in (self._read(), self.first.run(), self.second.run(), self._ended.wait())
        ]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                if not task.cancelled():  # tasks that wait for a thread are cancelled once the page has ended
                    with suppress(WebSocketDisconnect):
                        task.result()
        finally:
            for task in tasks:
                task.cancel()

    def end(self) -> None:
        """Stops the page's computations and closes its connection."""
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
        """Answers a message; any error is sent to the page, and the connection stays open."""
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

    # --- the answers to a look ---------------------------------------------------------------------------------------

    async def _look(self, side: str, request: dict[str, Any]) -> None:
        """Computes the run, preceded by the controls if the page asks for them, and passes it on to the second slot."""

        def read() -> dict[str, Any]:
            self.shelf.at_once(request["setting"], lambda subject: None)
            return {"controls": as_json(self.shelf.controls(request["setting"]))}

        def compute() -> tuple[Subject, look.Parts, dict[str, Any]]:
            subject, parts, request["stands"] = self.shelf.at_once(
                request["setting"],
                lambda shown_subject: look.response(shown_subject, request["periods"]),
                patient=request["made"],
            )
            about = look.about(subject) | {"membrane": profiles.names(subject.model), "stands": request["stands"]}
            return subject, parts, {"about": about}

        try:
            if request.get("controls"):  # sent first: the run may take a while
                await self._show("subject", request, look.Parts(), await self._computed(self.first, read))
            subject, parts, more = await self._computed(self.first, compute)
        except (Stopped, WebSocketDisconnect):
            raise
        except Exception as error:
            return await self.fail(request["id"], error, side)
        self.second.give(side, (request, subject))
        await self._show("response", request, parts, more)

    async def _examine(self, side: str, job: tuple[dict[str, Any], Subject]) -> None:
        """Computes the kind of motion with its evidence, further section points if it does not repeat, and the open
        panels."""
        request, subject = job
        loop = asyncio.get_running_loop()
        self._saved[side] += max(A_PICTURE - self.first.cost, LEAST)
        # evidence that is expensive, or would be interrupted by a moving slider, waits until the slider rests; a user
        # who moves it only after seeing the last kind of motion has let it rest
        at_once = self._taken[side] < GRACE and (request["follows"] or self._saved[side] >= self._cost[side])
        await self.second.until(loop.time() + (0.0 if at_once else GRACE))
        began, self._saved[side] = loop.time(), 0.0
        try:
            await self._examine_now(side, request, subject)
        finally:
            self._taken[side], self._cost[side] = loop.time() - began, self.second.cost

    async def _examine_now(self, side: str, request: dict[str, Any], subject: Subject) -> None:
        wanted = ["kind", "spectrum"] if "spectrum" in request["panels"] else ["kind"]
        for name in wanted:
            self.second.refines = name == "section"
            try:
                parts = await self._computed(self.second, partial(settled.STAGES[name], subject))
            except Stopped:
                raise
            except Exception as error:
                await self._late(request, name, error)
                parts, self.second.missing = settled.Settled(words={"regime": None}), []
            else:
                await self._show(name, request, parts)
            self.pool.warm(load)
            if name == "kind" and request["id"] == self._newest[side]:
                self._known[side] = request["id"]
                self.lanes.start(
                    side, request["id"], partial(self._afterwards, request, subject, parts, self.second.missing)
                )
            if name == "kind" and parts.words["regime"] in WANDERING:
                wanted.append("section")

    async def _afterwards(
        self, request: dict[str, Any], subject: Subject, kind: settled.Settled, missing: list[CurveKey]
    ) -> None:
        """Sends stored answers at once, and slower ones once the slider rests: current and power, the membrane for
        which a cone stands, rests, statics and profiles."""
        if request["stands"]:
            return await self._make_membrane(request)
        model = subject.model
        answers: list[tuple[str, equilibria.Answers[Any], Callable[..., look.Parts], Callable[..., Any]]]
        answers = [("numbers", equilibria.PULL_INS, equilibria.margins, find_pull_in)]
        if "statics" in request["panels"]:
            answers.append(("statics", equilibria.STATICS, equilibria.statics, find_static))
        unanswered = [answer for answer in answers if not answer[1].has(model)]
        for name, stored, show, _ in answers:
            if stored.has(model):
                await self._add(name, request, show, subject)
        await asyncio.sleep(RESTED_SECONDS)
        if kind.run is not None:
            await self._add("numbers", request, settled.electrical, subject, kind.run)
        async with self._working(request, "statics") as (work, source):
            if not await self._rests_there(work, source, request, kind):
                self.first.give(request["side"], request)
                return
            for name, stored, show, find in unanswered:
                with suppress(InputError) if name == "numbers" else nullcontext():
                    stored.keep(model, await work.do(find, source))
                    await self._add(name, request, show, subject)
            await self._send_profiles(request, model, work, source)
            if missing:
                for key, curve in zip(missing, await work.do(find_curves, source, missing), strict=True):
                    store_curve(key, curve)
                self.second.give(request["side"], (request, subject))  # its evidence needs these curves

    async def _make_membrane(self, request: dict[str, Any]) -> None:
        """Makes the missing membrane in a worker once the slider rests, then requests the picture again."""
        await asyncio.sleep(RESTED_SECONDS)
        async with self._working(request, "film") as (work, source):
            await work.do(make_membrane, source, request["periods"])
            self.first.give(request["side"], request | {"made": True})

    @asynccontextmanager
    async def _working(self, request: Mapping[str, Any], stage: str) -> AsyncIterator[tuple[Work, Source]]:
        """`_worker` for a stage of a look, whose error is sent; a cancelled stage drops its work."""
        work, source = self._worker(request)
        try:
            yield work, source
        except InputError as error:
            await self._late(request, stage, error)
        except asyncio.CancelledError:
            self.lanes.drop(work)
            raise

    def _worker(self, request: Mapping[str, Any]) -> tuple[Work, Source]:
        """The work and the source with which a worker computes the slower answers to a look."""
        return self.lanes.work(request["side"], request["id"]), asked.source(self.shelf, request["setting"])

    async def _late(self, request: Mapping[str, Any], stage: str, error: Exception) -> None:
        """Sends the reason why a stage of a look is missing."""
        head = {"kind": "late", "id": request["id"], "side": request["side"], "stage": stage}
        await self.send(head | {"message": _in_words(error)})

    async def _send_profiles(self, request: dict[str, Any], model: ConeModel, work: Work, source: Source) -> None:
        """Sends the profile tables that the page does not have yet."""
        for film, name in enumerate(profiles.names(model)):
            if name and name not in self._profiles:
                await self._show("profiles", request, await work.do(find_profiles, source, film))
                self._profiles.add(name)

    async def _add(
        self, name: str, request: Mapping[str, Any], compute: Callable[..., look.Parts], *given: Any
    ) -> None:
        """Computes an answer in a thread and sends it."""
        parts = await asyncio.get_running_loop().run_in_executor(self._threads, compute, *given)
        await self._show(name, request, parts)

    async def _rests_there(self, work: Work, source: Source, request: Mapping[str, Any], kind: settled.Settled) -> bool:
        """Whether the picture shows the rests that a full search finds."""
        guesses = self.shelf.guesses(request["setting"])
        if not guesses:
            return True
        moved = self.shelf.confirm(request["setting"], await work.do(find_rests, source, list(guesses)))
        return moved <= SAME_REST and not (moved > 0.0 and kind.words["regime"] in WANDERING)

    async def _computed(self, slot: Slot, compute: Callable[[], Any]) -> Any:
        """The result of ``compute``, run in a thread under the slot's watch; `InputError` beyond its time limit."""
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
            answer = await loop.run_in_executor(self._threads, watched)
        except Stopped:
            if loop.time() < limit.when() or slot.overtaken or self._ended.is_set():
                raise
            slot.watch = Watch()  # for the next stages of this request
            what = "the evidence" if slot is self.second else "the run"
            raise InputError(
                f"{what} takes more than {seconds:g} s; take a shorter run, or ask the command line (Save…)"
            ) from None
        finally:
            limit.cancel()
        if slot.overtaken:
            raise Stopped
        return answer

    # --- work of seconds ---------------------------------------------------------------------------------------------

    async def _begin(self, request: dict[str, Any]) -> None:
        """Starts one of `_LONG`, in place of the work that runs in its lane."""
        read, do = _LONG[request["kind"]]
        work = self.lanes.work(request["kind"], request["id"])

        async def read_and_do() -> None:
            await do(work, *await self._in_thread(read, request))

        self.lanes.start(request["kind"], request["id"], read_and_do)

    async def _glance(self, request: dict[str, Any]) -> None:
        """Sends a small picture of a device or preset with its values."""

        async def answer() -> None:
            watch, loop = Watch(), asyncio.get_running_loop()
            limit = loop.call_later(RUN_SECONDS, watch.stop.set)
            try:
                parts, about = await self._in_thread(partial(_glimpse, watch), request)
            except Stopped:
                raise InputError(f"the picture takes more than {RUN_SECONDS:g} s") from None
            finally:
                limit.cancel()
                watch.stop.set()  # also if another picture is requested
            head = {"kind": "glance", "id": request["id"], "words": parts.words, "about": about}
            await self.send(head, parts.arrays)

        self.lanes.start("glance", request["id"], answer)

    async def _device_file(self, request: dict[str, Any]) -> None:
        """Sends the current values of the device as a device file."""

        async def answer() -> None:
            text = await self._in_thread(asked.device_file, request)
            head = {"kind": "file", "id": request["id"], "name": OWN_FILE}
            await self.send(head, {"data": np.frombuffer(text.encode(), dtype=np.uint8)})

        self.lanes.start("device", request["id"], answer)

    async def _code(self, request: dict[str, Any]) -> None:
        """Sends the command and the Python lines that compute what the page shows."""

        async def answer() -> None:
            words = await self._in_thread(asked.code, request)
            await self.send({"kind": "code", "id": request["id"], **words})

        self.lanes.start("code", request["id"], answer)

    async def _in_thread(self, read: Callable[[Shelf, Mapping[str, Any]], Any], request: Mapping[str, Any]) -> Any:
        """The result of ``read`` for a request, computed in a thread: a film that wrinkles would block the event
        loop."""
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
        """Sends an error, with the control that it concerns, None if it names no control at its beginning."""
        message = _in_words(error)
        first = message.removeprefix("--set ").partition(" ")[0].rstrip(":")
        control = getattr(error, "field", None) or (first if is_name(first) else None)
        await self.send({"kind": "error", "id": number, "side": side, "control": control, "message": message})

    async def send(self, head: Mapping[str, Any], arrays: Mapping[str, Any] | None = None) -> None:
        """Sends a message in one frame, while the page is connected."""
        frame = pack(head, arrays)
        async with self._sending:
            if self.socket.application_state is WebSocketState.CONNECTED:
                try:
                    await self.socket.send_bytes(frame)
                except RuntimeError:  # the connection has been closed
                    raise WebSocketDisconnect from None


_LONG: Mapping[str, tuple[Callable[..., tuple[Any, ...]], Callable[..., Awaitable[None]]]] = {
    "map": (asked.read_map, fill_map),
    "strip": (asked.read_sweep, fill_strip),
    "envelope": (asked.read_envelope, draw_envelope),
    "export": (asked.read_export, make_file),
}
"""Long work by kind: the function that reads the request, and the one that does the work."""
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
"""Handlers of requests by kind."""


def _glimpse(watch: Watch, shelf: Shelf, request: Mapping[str, Any]) -> tuple[look.Parts, dict[str, Any]]:
    setting = Setting.read(request.get("setting"))
    if setting.file is not None or setting.values:
        raise InputError("a small picture shows a device or preset with its values; name one")
    with watching(watch), known_curves():
        subject, parts, _ = shelf.at_once(setting, look.glance)
        return parts, look.about(subject)


def _in_words(error: Exception) -> str:
    """The message for an error; unexpected ones are also logged to the terminal."""
    if isinstance(error, ProcessesEnded):
        return "a worker process ended, perhaps for lack of memory; change a setting to try again"
    if isinstance(error, InputError | MissingDependency):
        return " ".join(str(error).split())
    _log.error("the studio failed", exc_info=error)
    return "internal error; see the terminal"
