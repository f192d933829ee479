"""What a page asks is read within bounds, and what is wrong is said in full words with the control that it is of."""

import asyncio
import logging
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas.processes import ProcessesEnded
from gelcone.codes import Regime
from gelcone.devices.units import FieldError
from gelcone.errors import InputError, MissingDependency
from gelcone.studio import equilibria, look, settled
from gelcone.studio import page as pages
from gelcone.studio.lanes import LANES, SIDES
from gelcone.studio.page import Page
from gelcone.studio.setting import Setting, Shelf

PUMP, BASE = {"device": "biased-pump", "values": {"film": "taut"}}, {"preset": "base"}
X, Y = ["voltage_amplitude", 100, 700], ["frequency", 5, 15]


@pytest.fixture(scope="module")
def page():
    """A page without a connection, for what it reads."""
    own = object.__new__(Page)
    own.shelf = Shelf()
    return own


# --- messages ---------------------------------------------------------------------------------------------------------


def test_an_error_is_said_in_words_and_a_fault_to_the_terminal_alone(caplog):
    assert pages._in_words(InputError("a:\n  b")) == "a: b"
    assert pages._in_words(MissingDependency("pip install it")) == "pip install it"
    assert pages._in_words(ProcessesEnded("lost")) == (
        "a worker process ended, perhaps for lack of memory; change a setting to try again"
    )
    assert not caplog.records
    with caplog.at_level(logging.ERROR):
        assert pages._in_words(ValueError("/home/me")) == "internal error; see the terminal"
    assert caplog.records[0].exc_info[1].args == ("/home/me",)


@pytest.mark.parametrize(
    ("error", "control"),
    [
        (FieldError("film_radius", "is too small"), "film_radius"), (InputError("there is none"), None),
        (InputError("periods: must be a number"), "periods"), (InputError("--set voltage: is too large"), "voltage"),
        (InputError("waveform.duty: is too large"), "waveform.duty"), (InputError("'../../etc/passwd' is none"), None),
        (InputError("the device is lost"), None), (InputError("prestretch_mode: is none"), "prestretch_mode"),
        (InputError("displacement: is too large"), "displacement"), (InputError("waveform: is none"), "waveform"),
        (InputError("material.law: is none"), "material.law"), (InputError("a.b: is none"), None),
    ],
)  # fmt: skip
def test_an_error_names_the_control_that_it_is_of(error, control, page, monkeypatch):
    sent = []

    async def send(head, arrays=None):
        sent.append(head)

    monkeypatch.setattr(page, "send", send, raising=False)
    asyncio.run(page.fail(7, error, "b"))
    assert sent == [
        {"kind": "error", "id": 7, "side": "b", "control": control, "message": " ".join(str(error).split())}
    ]


@pytest.mark.parametrize("given", [PUMP, {"preset": "base", "values": {"voltage": "1"}}, {"file": "name = 'a'"}])
def test_a_small_picture_is_that_of_a_device_as_it_is(given, page):
    with pytest.raises(InputError) as error:
        pages._glimpse(pages.Watch(), page.shelf, {"setting": given})
    assert str(error.value) == "a small picture shows a device or preset with its values; name one"


def test_a_picture_is_waited_for_less_long_than_its_evidence():
    assert 0.0 < pages.RESTED_SECONDS < pages.RUN_SECONDS < pages.EVIDENCE_SECONDS <= 60.0
    assert pages.LEAST < pages.A_PICTURE < pages.GRACE
    assert pages.BURST > pages.RATE > 60.0  # a hand that moves asks for a picture in every frame


# --- lanes ------------------------------------------------------------------------------------------------------------


class Lanes:
    """A pool that records its lanes."""

    def __init__(self, first):
        self.begun, self.left, self._next = [], [], first

    def lane(self):
        self._next += 1
        return self._next

    def begin(self, lane):
        self.begun.append(lane)
        return 5

    def leave(self, lane):
        self.left.append(lane)


def test_what_one_waits_for_has_workers_of_its_own_and_all_lanes_are_given_back():
    async def story():
        pool, saving = Lanes(0), Lanes(100)
        own = Page(SimpleNamespace(), Shelf(), pool, saving)
        for name in (*LANES, *SIDES):
            assert own.lanes[name][0] is (saving if name in ("export", "a", "b") else pool), name
        lanes = {name: lane for name, (_, lane) in own.lanes.items()}
        assert len(set(lanes.values())) == len(LANES) + len(SIDES)
        work, source = own._worker({"side": "b", "id": 7, "setting": pages.Setting.read(BASE)})
        assert (work.pool, work.lane, work.run, work.number, source.path) == (saving, lanes["b"], 5, 7, None)
        assert saving.begun == [lanes["b"]]
        await own._cancel({"grid": "strip"})
        assert pool.begun == [lanes["strip"]]
        with pytest.raises(InputError) as error:
            await own._cancel({"grid": "hello"})
        assert str(error.value) == "grid: must be one of map, strip, envelope, export, a, b"
        own.lanes.drop(work)
        own.end()
        own.lanes.drop(work)  # the page is gone
        assert saving.begun == [lanes["b"]] * 2
        assert sorted(pool.left + saving.left) == sorted(lanes.values())
        assert set(pool.left) == {lanes[name] for name in ("map", "strip", "envelope")}

    asyncio.run(story())


# --- what follows a look ----------------------------------------------------------------------------------------------


class Sent(Page):
    """A page whose messages are stored in place of being sent; work of seconds gives what ``found`` says."""

    def __init__(self, **found):
        super().__init__(SimpleNamespace(), Shelf(), Lanes(0), Lanes(100))
        self.sent, self.found, self.done = [], found, []

    async def send(self, head, arrays=None):
        self.sent.append((head, arrays))

    def _worker(self, request):
        async def do(function, source, *given):
            self.done.append(function.__name__)
            result = self.found[function.__name__]
            if isinstance(result, Exception):
                raise result
            return result

        return SimpleNamespace(do=do), "source"


LOOK = {"kind": "look", "id": 3, "side": "a", "setting": Setting.read(BASE), "periods": 20, "panels": []}


@pytest.mark.parametrize("regime", [Regime.REST, Regime.PERIODIC, *pages.WANDERING])
@pytest.mark.parametrize("moved", [0.0, 1e-12, 1e-3])
def test_a_picture_shows_the_rests_that_a_search_finds_but_for_rounding(regime, moved, monkeypatch):
    """Of a motion that wanders any other rest makes another motion."""

    async def story():
        own = Sent(find_rests={})
        monkeypatch.setattr(own, "shelf", SimpleNamespace(guesses=lambda _: {"key": 0.5}, confirm=lambda *_: moved))
        there = await own._rests_there(*own._worker(LOOK), LOOK, settled.Settled(words={"regime": int(regime)}))
        assert there == (moved == 0.0 or (moved < 1e-9 and regime in (Regime.REST, Regime.PERIODIC)))
        own.shelf.guesses = lambda _: {}
        assert await own._rests_there(*own._worker(LOOK), LOOK, settled.Settled(words={"regime": 3}))
        assert own.done == ["find_rests"]
        own.end()

    asyncio.run(story())


def test_a_motion_wanders_unless_it_rests_or_repeats():
    ended = {Regime.LEFT_THE_DOMAIN, Regime.TRANSIENT_CHAOS}
    assert set(Regime) - set(pages.WANDERING) == {Regime.REST, Regime.PERIODIC, *ended}


def test_a_run_and_its_evidence_have_times_of_their_own(monkeypatch):
    """What is late is said with its time; of a run as an error, of what follows as a part that is missing."""
    monkeypatch.setattr(pages, "RUN_SECONDS", 0.05)
    monkeypatch.setattr(pages, "EVIDENCE_SECONDS", 0.15)

    async def story():
        own = Sent()

        def never(slot):
            slot.watch.stop.wait(5.0)
            raise pages.Stopped

        own.shelf = SimpleNamespace(at_once=lambda *_, **__: never(own.first))
        own.pool = SimpleNamespace(warm=lambda _: None)
        monkeypatch.setitem(pages.settled.STAGES, "kind", lambda _: never(own.second))
        stopped = own.second.watch
        await own._look("a", LOOK | {"made": False})
        await own._examine_now("a", LOOK, None)
        (run, _), (evidence, _) = own.sent
        assert (run["kind"], run["id"], run["side"]) == ("error", 3, "a")
        assert (evidence["kind"], evidence["id"], evidence["side"], evidence["stage"]) == ("late", 3, "a", "kind")
        late = "takes more than {} s; take a shorter run, or ask the command line (Save…)"
        assert run["message"] == "the run " + late.format("0.05")
        assert evidence["message"] == "the evidence " + late.format("0.15")
        assert own.second.watch is not stopped  # so that what comes next of this request is not stopped, too
        assert await own._computed(own.second, lambda: "found") == "found"
        own.end()
        with pytest.raises(pages.Stopped):
            await own._computed(own.second, lambda: "found")

    asyncio.run(story())


def test_tables_of_profiles_are_sent_once_a_film(monkeypatch):
    monkeypatch.setattr(pages.profiles, "names", lambda model: ["one", "", "two"])

    async def story():
        own = Sent(find_profiles=look.Parts(words={"name": "a table"}))
        for _ in range(2):
            await own._send_profiles(LOOK, "model", *own._worker(LOOK))
        assert [head["kind"] for head, _ in own.sent] == ["profiles", "profiles"]
        assert own.done == ["find_profiles"] * 2
        own.end()

    asyncio.run(story())


@pytest.mark.parametrize("panels", [[], ["statics"]])
@pytest.mark.parametrize("stored", [False, True])
def test_equilibria_are_computed_and_shown_where_they_are_open(panels, stored, monkeypatch):
    """Pull-in always; what is stored of other drives at once, what is not once the hand rests."""
    monkeypatch.setattr(pages, "RESTED_SECONDS", 0.0)
    monkeypatch.setattr(pages.profiles, "names", lambda model: [])
    for name in ("PULL_INS", "STATICS"):
        answers = equilibria.Answers(str, lambda model: None)
        monkeypatch.setattr(equilibria, name, answers)
        if stored:
            answers.keep("model", "known")
    monkeypatch.setattr(equilibria, "margins", lambda subject: look.Parts(words={"numbers": ["pull-in"]}))
    monkeypatch.setattr(equilibria, "statics", lambda subject: look.Parts(words={"marks": {}}))

    async def story():
        own = Sent(find_pull_in=1.0, find_static="found")
        request = LOOK | {"panels": panels, "stands": False}
        await own._afterwards(request, SimpleNamespace(model="model"), settled.Settled(words={"regime": 1}), [])
        assert [head["kind"] for head, _ in own.sent] == ["numbers", *panels]
        assert own.done == ([] if stored else ["find_pull_in", *(["find_static"] if panels else [])])
        own.end()

    asyncio.run(story())


def test_why_a_membrane_is_missing_is_said_of_the_film_and_why_equilibria_are_of_them(monkeypatch):
    monkeypatch.setattr(pages, "RESTED_SECONDS", 0.0)

    async def story():
        own = Sent(make_membrane=InputError("too thick\n for it"), find_static=InputError("none"), find_pull_in=1.0)
        monkeypatch.setattr(equilibria, "PULL_INS", equilibria.Answers(str, lambda model: 1.0))
        monkeypatch.setattr(equilibria, "margins", lambda subject: look.Parts())
        subject, kind = SimpleNamespace(model="model"), settled.Settled(words={"regime": 1})
        await own._afterwards(LOOK | {"stands": True}, subject, kind, [])
        monkeypatch.setattr(equilibria, "STATICS", equilibria.Answers(str, lambda model: None))
        await own._afterwards(LOOK | {"stands": False, "panels": ["statics"]}, subject, kind, [])
        late = [(head["stage"], head["message"]) for head, _ in own.sent if head["kind"] == "late"]
        assert late == [("film", "too thick for it"), ("statics", "none")]
        own.end()

    asyncio.run(story())


def test_a_new_look_ends_what_followed_the_old_one_and_may_follow_its_evidence_at_once():
    """At once where the page has the kind of motion of the last look of that side."""

    async def story():
        own, cancelled, given = Sent(), [], []
        own.lanes.cancel = cancelled.append
        own.first.give = lambda side, request: given.append((side, request["follows"]))
        raw = {"kind": "look", "side": "a", "setting": BASE}
        for number, known in ((1, None), (2, None), (3, 2), (4, None), (5, 4)):
            if known is not None:
                own._known["a"] = known
            await own._take_look(raw | {"id": number})
        await own._take_look(raw | {"id": 6, "side": "b"})
        assert cancelled == ["a"] * 5 + ["b"]
        assert given == [("a", True), ("a", False), ("a", True), ("a", False), ("a", True), ("b", True)]
        own.end()

    asyncio.run(story())


def test_a_device_is_handed_over_as_a_device_file():
    async def story():
        own = Sent()
        await own._device_file({"id": 9, "setting": PUMP})
        while not own.sent:
            await asyncio.sleep(0.01)
        (head, arrays), device = own.sent[0], own.shelf.subject(Setting.read(PUMP)).device
        assert head == {"kind": "file", "id": 9, "name": "device.toml"}
        assert bytes(arrays["data"]).decode() == device.to_toml()
        own.end()

    asyncio.run(story())


def test_messages_are_read_at_a_bounded_rate(monkeypatch):
    """As many at once as may come, however long nothing came before; then as many as a second allows."""

    async def story():
        own, moments, clock, slept, come = Sent(), iter([0.0, 100.0]), [0.0], [], []

        async def receive():
            clock[0] = next(moments, clock[0])
            come.append(clock[0])
            return {"type": "websocket.disconnect" if len(come) > 451 else "websocket.receive", "text": "{}"}

        async def answer(text):
            pass

        async def sleep(seconds):
            slept.append(seconds)

        own.socket.receive, own._answer = receive, answer
        monkeypatch.setattr(pages, "time", SimpleNamespace(monotonic=lambda: clock[0]))
        monkeypatch.setattr(pages.asyncio, "sleep", sleep)
        await own._read()
        assert len(slept) == 451 - 1 - pages.BURST
        np.testing.assert_allclose(slept, np.arange(1, len(slept) + 1) / pages.RATE)
        own.end()

    asyncio.run(story())
