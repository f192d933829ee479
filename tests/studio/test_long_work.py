"""Maps, strips, envelopes and files as the page is sent them: each cell in its place, in the page's units."""

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.errors import InputError
from gelcone.studio import exports, long_work
from gelcone.studio.grids import THRESHOLDS, Axis, Source
from gelcone.studio.long_work import Outdated, Work, fill_map, fill_strip, make_file
from gelcone.studio.look import pull_in_film

PUMP = Source(shipped_devices()["biased-pump"], None, {"settings": []})
BASE = Source(None, None, {"preset": "base", "settings": []})


class Here:
    """A pool that does its tasks here and now."""

    size = 2

    async def do(self, lane, run, function, *arguments):
        await asyncio.sleep(0)
        return function(*arguments)


def sent(fill, *arguments):
    """The messages that the page is sent: (head, arrays) each."""
    found = []

    async def send(head, arrays=None):
        found.append((head, dict(arrays or {})))

    asyncio.run(fill(Work(Here(), 1, 1, 7, send), *arguments))
    assert all(head["id"] == 7 for head, _ in found)
    return found


# --- thresholds -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("unit", "scale", "upright"), [("V", 1.0, True), ("kV", 1e-3, False), ("mV", 1e3, True)])
def test_thresholds_lie_at_the_voltages_of_limits_on_the_axis_of_the_voltage(unit, scale, upright):
    volts = Axis("voltage_amplitude", unit, np.linspace(500.0, 2500.0, 3) * scale)
    other = Axis("film_thickness", "mm", np.array([0.18, 0.2, 0.22]))
    ((head, arrays),) = sent(long_work._draw_thresholds, PUMP, *((volts, other) if upright else (other, volts)))
    assert (head["kind"], head["upright"]) == ("thresholds", upright)
    device = gelcone.find_device("biased-pump").replace(film_thickness=["0.18 mm", "0.2 mm", "0.22 mm"])
    limits = gelcone.to_si(gelcone.limits(device.to_model()), device)
    np.testing.assert_array_equal(arrays.pop("at"), other.values)
    offset, film = {"onset_voltage": 0.0}, pull_in_film(device.to_model())
    for name, words in THRESHOLDS.items():
        expected = limits[name].values - offset.get(name, device.voltage_offset)
        if (expected > 0.0).any():
            np.testing.assert_allclose(
                arrays.pop(words.format(film=film)), np.where(expected > 0.0, expected, np.nan) * scale, rtol=1e-9
            )
    assert not arrays
    assert f"pull-in of the {film} at the peak" in head["names"]


def test_a_map_without_the_voltage_has_no_thresholds():
    axes = Axis("frequency", "Hz", np.linspace(5, 15, 3)), Axis("film_thickness", "mm", np.linspace(0.1, 0.3, 3))
    assert sent(long_work._draw_thresholds, PUMP, *axes) == []


# --- cells ------------------------------------------------------------------------------------------------------------

X, Y = Axis("voltage", "", np.linspace(0.0, 1.0, 17)), Axis("damping_ratio", "", np.linspace(0.1, 0.5, 9))


@pytest.fixture
def told_kinds(monkeypatch):
    """Cells that say which they are: of kind 1 in a corner, with the values of the axes as exponent and extent."""
    asked = []

    def kinds(source, texts):
        assert source is BASE
        x = np.array([float(text) for text in texts["voltage"]])
        y = np.array([float(text) for text in texts.get("damping_ratio", texts["voltage"])])
        asked.extend(zip(x, y, strict=True))
        regime = ((x > 0.5) & (y > 0.3)).astype(np.uint8)
        return {"regime": regime, "exponent": x, "low": y, "high": x + y, "section": np.stack([x, y], axis=1)}

    monkeypatch.setattr(long_work, "kinds", kinds)
    monkeypatch.setattr(long_work, "thresholds", lambda source, axes: {"line": np.arange(9.0)})
    return asked


def test_every_cell_of_a_map_stands_in_its_place_once(told_kinds, monkeypatch):
    events = []

    def follow_loci(source, x, y, event):
        events.append(event)
        if event == "fold":
            raise InputError("there is none")
        return {"x": np.zeros(2), "y": np.ones(2)}

    monkeypatch.setattr(long_work, "follow_loci", follow_loci)
    messages = sent(fill_map, BASE, X, Y)
    cells = [(head, arrays) for head, arrays in messages if head["kind"] == "cells"]
    places = np.concatenate([arrays["places"] for _, arrays in cells]).astype(int)
    assert sorted(places) == list(range(17 * 9))
    assert len(told_kinds) == 17 * 9
    for _, arrays in cells:
        i, j = np.divmod(arrays["places"].astype(int), 9)
        np.testing.assert_allclose(arrays["exponent"], X.values[i], atol=1e-9)
        np.testing.assert_allclose(arrays["low"], Y.values[j], atol=1e-9)
        assert "section" not in arrays
    shares = [head["share"] for head, _ in cells]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    order = [head["kind"] for head, _ in messages]
    assert order[0] == "grid"
    assert messages[0][0]["cells"] == (17, 9)
    assert order.index("cells") < order.index("thresholds") < order.index("done") < order.index("loci")
    assert order.count("thresholds") == order.count("done") == 1
    assert order[-1] == "followed"
    assert events == list(long_work.EVENTS)
    assert [head["name"] for head, _ in messages if head["kind"] == "loci"] == [e for e in events if e != "fold"]


def test_every_value_of_a_strip_comes_from_coarse_to_fine_and_then_its_branches(told_kinds, monkeypatch):
    found = {"arrays": {"value": np.ones(2)}, "kinds": ["fold"]}
    monkeypatch.setattr(long_work, "follow_branches", lambda source, over: dict(found))
    messages = sent(fill_strip, BASE, X)
    cells = [arrays for head, arrays in messages if head["kind"] == "cells"]
    places = np.concatenate([arrays["places"] for arrays in cells]).astype(int)
    assert sorted(places) == list(range(17))
    assert set(places[:3]) == {0, 8, 16}
    for arrays in cells:
        np.testing.assert_allclose(arrays["section"][:, 0], X.values[arrays["places"].astype(int)])
    head, arrays = messages[-1]
    assert (head["kind"], head["kinds"], list(arrays)) == ("branches", ["fold"], ["value"])
    assert [head["kind"] for head, _ in messages][-2] == "done"


def test_a_strip_without_branches_says_why(told_kinds, monkeypatch):
    def follow_branches(source, over):
        raise InputError("no periodic\norbit")

    monkeypatch.setattr(long_work, "follow_branches", follow_branches)
    assert sent(fill_strip, BASE, X)[-1][0] == {"kind": "branches", "id": 7, "kinds": [], "none": "no periodic orbit"}


def test_cells_of_one_frequency_are_computed_side_by_side(told_kinds, monkeypatch):
    filling = long_work.Filling(Work(Here(), 1, 1, 7, None), "map", BASE, (X, Axis("drive_frequency", "", Y.values)))
    cells = np.arange(17 * 9)
    alike = cells[np.lexsort(filling._groups(cells))]
    assert (np.diff(alike % 9) >= 0).all()


def test_what_is_out_of_date_ends_without_another_message():
    class Gone(Here):
        async def do(self, *arguments):
            return None

    async def send(head, arrays=None):
        assert head["kind"] == "grid"

    with pytest.raises(Outdated):
        asyncio.run(fill_map(Work(Gone(), 1, 1, 7, send), BASE, X, Y))


# --- files -----------------------------------------------------------------------------------------------------------


def test_a_file_is_sent_with_its_name(monkeypatch):
    asked = []
    monkeypatch.setattr(exports, "make", lambda *arguments: asked.append(arguments) or b"\x00\xff")
    wanted = SimpleNamespace(analysis=SimpleNamespace(command="regime"))
    ((head, arrays),) = sent(make_file, PUMP, wanted, "png")
    assert (head["kind"], head["name"]) == ("file", "regime.png")
    assert arrays["data"].tobytes() == b"\x00\xff"
    assert asked == [(PUMP, wanted, "png")]
