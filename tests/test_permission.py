"""Names in texts are followed only where they may be: nothing is imported and no file is opened unasked."""

import sys
import threading
from pathlib import Path

import pytest

from gelcone import ConeModel, Device, InputError, find_device
from gelcone.devices.files import shipped_devices
from gelcone.permission import check, check_data, limit, only, record
from gelcone.physics.component import names_of
from tests.toys import ThreeHarmonics


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module that could be imported; its name is among `sys.modules` once it was."""
    (tmp_path / "recorder.py").write_text("import gelcone\nclass K(gelcone.Waveform): name = 'k'\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield "recorder"
    sys.modules.pop("recorder", None)


@pytest.mark.parametrize("kind", ["waveform", "circuit", "bias", "film", "law", "second_film"])
@pytest.mark.parametrize("name", ["recorder:K", "spring+recorder:K", {"component": "recorder:K"}])
def test_no_component_is_imported(module, kind, name):
    with only(frozenset()), pytest.raises(InputError):
        ConeModel(**{kind: name})
    assert module not in sys.modules


def test_no_part_of_a_component_is_imported(module):
    film = {"component": "taut", "law": {"nested": "recorder:K"}}
    with only(frozenset()), pytest.raises(InputError, match="recorder:K"):
        ConeModel(film=film)
    assert module not in sys.modules


def test_what_was_given_is_imported():
    toy = ThreeHarmonics()
    names = names_of(toy)
    (name,) = (one for one in names if not one.startswith("{"))
    with only(frozenset(names)):
        assert ConeModel(waveform=name).system.waveform == toy
        with pytest.raises(InputError):
            ConeModel(circuit="tests.toys:FilteredVoltage")
    assert ConeModel(circuit="tests.toys:FilteredVoltage").system.states  # anywhere else as ever


def test_the_parts_of_a_component_are_named_too():
    names = {one for one in names_of(ConeModel(film="taut", law="yeoh").film) if not one.startswith("{")}
    assert names == {"gelcone.physics.film.taut:TautCone", "gelcone.physics.laws:Yeoh"}


def test_no_file_is_opened(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    there = Path("there.toml")
    there.write_text("{}")
    told = set()
    for path in (there, Path("none.toml")):
        with only(frozenset()), pytest.raises(InputError, match="does not ship") as refused:
            find_device(str(path))
        told.add(str(refused.value).replace(str(path), ""))
    assert len(told) == 1  # nothing says whether there is such a file
    with only(frozenset({str(there)})), pytest.raises(InputError, match="broken TOML"):
        find_device(str(there))


def test_the_text_of_a_device_is_read_as_its_file_is():
    path = shipped_devices()["biased-pump"]
    assert Device.from_text(path.read_text(encoding="utf-8")) == Device.from_toml(path)


def test_a_permission_holds_for_its_block_and_its_thread_alone():
    with only(frozenset({"a"})):
        with only(frozenset()), pytest.raises(InputError):
            check("film", "a")
        check("film", "a")
        thread = threading.Thread(target=limit, args=(frozenset(),))
        thread.start()
        thread.join()
        check("film", "a")
    check("film", "b")


def test_a_class_receives_no_data_but_those_given_at_the_start():
    """Other values, and further data, are refused; what is left out has its default."""
    given = frozenset({"mine:Own", record("mine:Own", {"levels": [1, 2], "rise": 0.1})})
    with only(given):
        check_data("waveform", "mine:Own", {"levels": [1, 2], "rise": 0.1})
        check_data("waveform", "mine:Own", {"rise": 0.1})
        check_data("waveform", "mine:Own", {})
        for data in ({"rise": 0.2}, {"rise": 0.1, "path": "x"}, {"path": "x"}):
            with pytest.raises(InputError, match="waveform 'mine:Own': its data are not those with which gelcone was"):
                check_data("waveform", "mine:Own", data)
        with pytest.raises(InputError, match="its data are not those"):
            check_data("waveform", "other:Own", {"rise": 0.1})
    check_data("waveform", "other:Own", {"path": "x"})


def test_a_long_name_is_shortened():
    with only(frozenset()), pytest.raises(InputError) as refused:
        check("film", "x" * 10_000)
    assert len(str(refused.value)) < 200


READER = """
from dataclasses import dataclass
import gelcone

@dataclass(frozen=True)
class Reader(gelcone.Bias):
    path: str = "own.csv"
    levels: tuple = (1.0, 2.0)
    name = "reader"
    def force(self, x, y, n, xp=None):
        return x, 1.0 + 0.0 * x
    def __post_init__(self):
        with open("opened", "a") as seen:
            seen.write(self.path + "\\n")
"""


def test_a_class_of_ones_own_is_handed_only_the_data_that_were_given(tmp_path, monkeypatch):
    (tmp_path / "readers.py").write_text(READER)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    given = {"component": "readers:Reader", "path": "mine.csv"}
    names = frozenset(names_of(ConeModel(bias=given).system.bias))
    Path("opened").unlink()
    with only(names):
        for allowed in (given, "readers:Reader", given | {"levels": [1.0, 2.0]}):
            ConeModel(bias=allowed)
        seen = Path("opened").read_text().split()
        assert set(seen) == {"mine.csv", "own.csv"}
        for other in ({"path": "/etc/passwd"}, {"path": "mine.csv", "levels": [3.0]}, {"path": ["mine.csv"]}):
            with pytest.raises(InputError, match="not those with which gelcone was started"):
                ConeModel(bias={"component": "readers:Reader", **other})
        with pytest.raises(InputError):
            ConeModel(film={"component": "taut", "law": {"nested": {"component": "readers:Reader", "path": "x"}}})
    assert Path("opened").read_text().split() == seen
    sys.modules.pop("readers")
