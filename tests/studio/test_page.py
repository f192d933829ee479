"""What a page asks is read within bounds, and what is wrong is said in full words with the control that it is of."""

import asyncio
import logging
from types import SimpleNamespace

import pytest

from gelcone.atlas.processes import ProcessesEnded
from gelcone.devices.units import FieldError
from gelcone.errors import InputError, MissingDependency
from gelcone.studio import page as pages
from gelcone.studio.lanes import LANES, SIDES
from gelcone.studio.page import Page
from gelcone.studio.setting import Shelf

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
        (FieldError("film_radius", "is too small"), "film_radius"), (InputError("there is none"), "there"),
        (InputError("periods: must be a number"), "periods"), (InputError("--set voltage: is too large"), "voltage"),
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
    assert str(error.value) == "a small picture is that of a device or preset as it is by itself; name one"


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
