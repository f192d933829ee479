"""What a page asks is read within bounds, and refused in full words."""

import json

import numpy as np
import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.errors import InputError
from gelcone.studio import asked
from gelcone.studio.asked import MAP_CELLS, STRIP_VALUES
from gelcone.studio.page import _KINDS
from gelcone.studio.setting import Setting, Shelf

PUMP, BASE = {"device": "biased-pump", "values": {"film": "taut"}}, {"preset": "base"}
X, Y = ["voltage_amplitude", 100, 700], ["frequency", 5, 15]


@pytest.fixture(scope="module")
def shelf():
    return Shelf()


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
        asked.read(text, _KINDS)
    assert str(error.value) == message


@pytest.mark.parametrize("number", [0, 7, 2**53 - 1])
def test_a_message_has_its_number(number):
    found = asked.read(json.dumps({"kind": "map", "id": number, "x": [1, 2.5]}), _KINDS)
    assert found == {"kind": "map", "id": number, "x": [1.0, 2.5]}
    assert isinstance(found["id"], int)


# --- what is asked for ------------------------------------------------------------------------------------------------


def test_a_map_and_a_strip_have_their_axes_and_a_source_with_the_setting(shelf):
    source, x, y = asked.read_map(shelf, {"setting": PUMP, "x": X, "y": Y})
    assert (source.path, source.text, source.options) == (
        shipped_devices()["biased-pump"], None, {"settings": ["film=taut"]},
    )  # fmt: skip
    for axis, (name, low, high), count in ((x, X, MAP_CELLS[0]), (y, Y, MAP_CELLS[1])):
        assert axis.name == name
        np.testing.assert_allclose(axis.values, np.linspace(low, high, count))
    source, over = asked.read_sweep(shelf, {"setting": BASE, "over": ["voltage", 0.5, 1.5]})
    assert source.options == {"preset": "base", "settings": []}
    np.testing.assert_allclose(over.values, np.linspace(0.5, 1.5, STRIP_VALUES))
    text = gelcone.find_device("soft-film").to_toml()
    assert asked.source(shelf, Setting.read({"file": text})).text == text


@pytest.mark.parametrize(
    ("read", "request_", "message"),
    [
        (asked.read_map, {"setting": PUMP, "x": X, "y": X},
         "voltage_amplitude: is on both axes; choose two parameters"),
        (asked.read_map, {"setting": PUMP, "x": X},
         "None: is not a parameter that can be swept here; choose one of the list"),
        (asked.read_sweep, {"setting": BASE, "over": ["voltage", 2, 1]},
         "Voltage: from 2 to 1 is empty; the first end must be below the second"),
        (asked.read_envelope, {"setting": BASE}, "a preset has no envelope; choose a device"),
        (asked.read_export, {"setting": BASE, "what": "regime", "format": "exe"},
         "format: must be one of nc, png, svg"),
        (asked.read_export, {"setting": BASE, "what": "regime"}, "format: must be one of nc, png, svg"),
        (asked.device_file, {"setting": BASE}, "a preset has no device file; choose a device"),
        (asked.code, {"setting": BASE, "what": 3}, "what: must be a text"),
        (asked.code, {"setting": BASE, "what": "regime", "options": {"tolerance": 1}},
         "options of regime: must be among none"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_refused_in_full_words(read, request_, message, shelf):
    with pytest.raises(InputError) as error:
        read(shelf, request_)
    assert str(error.value) == message


def test_files_lines_and_devices_are_those_of_the_setting(shelf):
    source, wanted, form = asked.read_export(
        shelf,
        {"setting": PUMP | {"values": {"film": "taut", "frequency": "9 Hz"}}, "what": "bifurcation", "format": "png",
         "over": Y}
    )  # fmt: skip
    assert (source.options["settings"], wanted.analysis.name, form) == (["film=taut"], "bifurcation", "png")
    assert wanted.over == (f"frequency=5 Hz:15 Hz:{STRIP_VALUES}",)
    found = asked.code(shelf, {"setting": PUMP, "what": "map", "x": X, "y": Y})
    assert found["own_file"] is False
    assert f"--over 'voltage_amplitude=100 V:700 V:{MAP_CELLS[0]}'" in found["command"]
    assert f"--over 'frequency=5 Hz:15 Hz:{MAP_CELLS[1]}'" in found["command"]
    assert found["command"].startswith("gelcone map biased-pump --set film=taut ")
    assert found["python"].startswith("import gelcone\n")
    device = gelcone.Device.from_text(asked.device_file(shelf, {"setting": PUMP}))
    assert device == gelcone.find_device("biased-pump").replace(film="taut")
    own = asked.code(shelf, {"setting": {"file": device.to_toml()}, "what": "simulate", "options": {"periods": 7}})
    assert own["own_file"] is True
    assert own["command"] == "gelcone simulate device.toml --periods 7 --out results"


def test_a_page_of_a_started_file_is_called_as_it_was_typed(tmp_path):
    given = tmp_path / "mine.toml"
    given.write_text(shipped_devices()["soft-film"].read_text(encoding="utf-8"), encoding="utf-8")
    found = asked.code(Shelf(given), {"setting": {"device": "mine"}, "what": "regime"})
    assert found["command"] == f"gelcone regime {given} --out results"
    assert f"gelcone.find_device('{given}')" in found["python"]
