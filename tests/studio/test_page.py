"""What a page asks is read within bounds, and what is wrong is said in full words with the control that it is of."""

import asyncio
import json
import logging
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.atlas.processes import ProcessesEnded
from gelcone.devices.files import shipped_devices
from gelcone.devices.units import FieldError
from gelcone.errors import InputError, MissingDependency
from gelcone.studio import page as pages
from gelcone.studio.page import LANES, MAP_CELLS, SIDES, STRIP_VALUES, Page
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "the message is not text; send JSON"),
        ("{", "the message is not JSON"),
        ("[" * 100_000, "the message is not JSON"),
        ('{"kind": "hello", "id": NaN}', "the message is not JSON"),
        ('{"kind": "hello", "id": 1e999}', "the message is not JSON"),
        ("[]", "the message must be an object whose kind is one of: hello, look, map, strip, envelope, cancel, code, "
               "device, glance, export"),
        ('{"kind": "quit", "id": 1}', "the message must be an object whose kind is one of: hello, look, map, strip, "
                                      "envelope, cancel, code, device, glance, export"),
        ('{"kind": 3, "id": 1}', "kind: must be a text"),
        *((f'{{"kind": "hello", "id": {one}}}', "id: must be a whole number")
          for one in ("true", '"1"', "null", "-1", "1.5", "9007199254740992")),
        ('{"kind": "hello"}', "id: must be a whole number"),
    ],
)  # fmt: skip
def test_a_message_that_cannot_be_read_is_refused_in_full_words(text, message):
    with pytest.raises(InputError) as error:
        pages._request(text)
    assert str(error.value) == message


@pytest.mark.parametrize("number", [0, 7, 2**53 - 1])
def test_a_message_has_its_number(number):
    found = pages._request(json.dumps({"kind": "map", "id": number, "x": [1, 2.5]}))
    assert found == {"kind": "map", "id": number, "x": [1.0, 2.5]}
    assert isinstance(found["id"], int)


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


# --- what is asked for ------------------------------------------------------------------------------------------------


def test_a_map_and_a_strip_have_their_axes_and_a_source_with_the_setting(page):
    source, x, y = page._over_two({"setting": PUMP, "x": X, "y": Y})
    assert (source.path, source.text, source.options) == (
        shipped_devices()["biased-pump"], None, {"settings": ["film=taut"]},
    )  # fmt: skip
    for axis, (name, low, high), count in ((x, X, MAP_CELLS[0]), (y, Y, MAP_CELLS[1])):
        assert axis.name == name
        np.testing.assert_allclose(axis.values, np.linspace(low, high, count))
    source, over = page._over_one({"setting": BASE, "over": ["voltage", 0.5, 1.5]})
    assert source.options == {"preset": "base", "settings": []}
    np.testing.assert_allclose(over.values, np.linspace(0.5, 1.5, STRIP_VALUES))
    text = gelcone.find_device("soft-film").to_toml()
    assert page.source(pages.Setting.read({"file": text})).text == text


@pytest.mark.parametrize(
    ("read", "request_", "message"),
    [
        ("_over_two", {"setting": PUMP, "x": X, "y": X}, "voltage_amplitude: is on both axes; choose two parameters"),
        ("_over_two", {"setting": PUMP, "x": X},
         "None: is not a parameter that can be swept here; choose one of the list"),
        ("_over_one", {"setting": BASE, "over": ["voltage", 2, 1]},
         "Voltage: from 2 to 1 is empty; the first end must be below the second"),
        ("_of_device", {"setting": BASE}, "an envelope is that of a device; choose one"),
        ("_to_save", {"setting": BASE, "what": "regime", "format": "exe"}, "format: must be one of nc, png, svg"),
        ("_to_save", {"setting": BASE, "what": "regime"}, "format: must be one of nc, png, svg"),
        ("_device_text", {"setting": BASE}, "a preset is no device; only a device has a file"),
        ("_lines", {"setting": BASE, "what": 3}, "what: must be a text"),
        ("_lines", {"setting": BASE, "what": "regime", "options": {"tolerance": 1}},
         "options of regime: must be among none"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_refused_in_full_words(read, request_, message, page):
    with pytest.raises(InputError) as error:
        getattr(page, read)(request_)
    assert str(error.value) == message


@pytest.mark.parametrize("given", [PUMP, {"preset": "base", "values": {"voltage": "1"}}, {"file": "name = 'a'"}])
def test_a_small_picture_is_that_of_a_device_as_it_is(given, page):
    with pytest.raises(InputError) as error:
        page._glimpse(pages.Watch(), {"setting": given})
    assert str(error.value) == "a small picture is that of a device or preset as it is by itself; name one"


def test_files_lines_and_devices_are_those_of_the_setting(page):
    source, wanted, form = page._to_save(
        {"setting": PUMP | {"values": {"film": "taut", "frequency": "9 Hz"}}, "what": "bifurcation", "format": "png",
         "over": Y}
    )  # fmt: skip
    assert (source.options["settings"], wanted.analysis.name, form) == (["film=taut"], "bifurcation", "png")
    assert wanted.over == (f"frequency=5 Hz:15 Hz:{STRIP_VALUES}",)
    found = page._lines({"setting": PUMP, "what": "map", "x": X, "y": Y})
    assert found["own_file"] is False
    assert f"--over 'voltage_amplitude=100 V:700 V:{MAP_CELLS[0]}'" in found["command"]
    assert f"--over 'frequency=5 Hz:15 Hz:{MAP_CELLS[1]}'" in found["command"]
    assert found["command"].startswith("gelcone map biased-pump --set film=taut ")
    assert found["python"].startswith("import gelcone\n")
    device = gelcone.Device.from_text(page._device_text({"setting": PUMP}))
    assert device == gelcone.find_device("biased-pump").replace(film="taut")
    own = page._lines({"setting": {"file": device.to_toml()}, "what": "simulate", "options": {"periods": 7}})
    assert own["own_file"] is True
    assert own["command"] == "gelcone simulate device.toml --periods 7 --out results"


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
            assert own._pool(name) is (saving if name in ("export", "a", "b") else pool), name
        lanes = dict(own._lanes)
        assert len(set(lanes.values())) == len(LANES) + len(SIDES)
        work, source = own._worker({"side": "b", "id": 7, "setting": pages.Setting.read(BASE)})
        assert (work.pool, work.lane, work.run, work.number, source.path) == (saving, lanes["b"], 5, 7, None)
        assert saving.begun == [lanes["b"]]
        await own._cancel({"grid": "strip"})
        assert pool.begun == [lanes["strip"]]
        with pytest.raises(InputError) as error:
            await own._cancel({"grid": "hello"})
        assert str(error.value) == "grid: must be one of map, strip, envelope, export, a, b"
        own._drop(work)
        own.end()
        own._drop(work)  # the page is gone
        assert saving.begun == [lanes["b"]] * 2
        assert sorted(pool.left + saving.left) == sorted(lanes.values())
        assert set(pool.left) == {lanes[name] for name in ("map", "strip", "envelope")}

    asyncio.run(story())


def test_a_page_of_a_started_file_is_called_as_it_was_typed(tmp_path):
    given = tmp_path / "mine.toml"
    given.write_text(shipped_devices()["soft-film"].read_text(encoding="utf-8"), encoding="utf-8")
    own = object.__new__(Page)
    own.shelf = Shelf(Path(given))
    found = own._lines({"setting": {"device": "mine"}, "what": "regime"})
    assert found["command"] == f"gelcone regime {given} --out results"
    assert f"gelcone.find_device('{given}')" in found["python"]
