"""What the data of a study depend on: sizes, versions, and all sources that compute."""

import json
from dataclasses import fields, replace
from pathlib import Path

import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.paper import stamp as module
from gelcone.paper.effort import FULL, QUICK


def test_sources_are_those_that_compute_with_the_devices_in_the_order_of_their_names():
    names = [name for name, _ in module.sources()]
    assert names == sorted(names)
    assert {"motion/flow.py", "paper/studies/triples.py", "continuum/compare.py", "physics/laws.py"} <= set(names)
    assert {f"devices/{path.name}" for path in shipped_devices().values()} <= set(names)
    for part in module.SHOWING:
        assert not [name for name in names if name == part or name.startswith(f"{part}/")], part
    for name, path in module.sources():
        assert path.name == name.rpartition("/")[2]


@pytest.fixture
def digest(tmp_path, monkeypatch):
    """The digest of two made-up sources and library versions."""

    def of(one=b"1", other=b"2", names=("a.py", "b.py"), numpy="2.0"):
        for name, content in zip(names, (one, other), strict=True):
            (tmp_path / name).write_bytes(content)
        monkeypatch.setattr(module, "sources", lambda: [(name, tmp_path / name) for name in names])
        monkeypatch.setattr(module, "version", lambda name: numpy if name == "numpy" else "1.0")
        return module.program.__wrapped__()

    return of


def test_another_byte_name_or_library_is_another_program(digest):
    others = [
        digest(b"11"),
        digest(other=b"3"),
        digest(names=("a.py", "c.py")),
        digest(numpy="2.1"),
        digest(b"2", b"1"),
    ]
    assert len({digest(), *others}) == 6
    assert digest() == digest()


def test_a_stamp_has_the_sizes_without_the_name():
    assert module.stamp(FULL)["effort"] == FULL.name != QUICK.name
    renamed = module.stamp(replace(FULL, name="other"))
    assert renamed["effort_sizes"] == module.stamp(FULL)["effort_sizes"]
    assert module.stamp(QUICK)["effort_sizes"] != module.stamp(FULL)["effort_sizes"]
    assert module.stamp(FULL)["program"] == module.program()


def test_each_size_is_in_the_stamp():
    own = module.stamp(QUICK)
    for one in fields(QUICK):
        other = module.stamp(replace(QUICK, **{one.name: "another"}))
        changed = "effort" if one.name == "name" else "effort_sizes"
        assert {key for key in own if own[key] != other[key]} == {changed}, one.name
    assert json.loads(own["effort_sizes"])["window"] == 500.0
    assert own["gelcone_version"] == gelcone.__version__


def test_both_libraries_count(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "sources", lambda: [])
    found = set()
    for numbers in ({}, {"numpy": "2"}, {"scipy": "2"}):
        monkeypatch.setattr(module, "version", lambda name, numbers=numbers: numbers.get(name, "1"))
        found.add(module.program.__wrapped__())
    assert len(found) == 3


def test_what_shows_is_left_out_and_nothing_else():
    """All modules of the program, less those folders and modules that print, draw and judge."""
    shown = {
        "accessor.py",
        "amounts.py",
        "words.py",
        "paper/report.py",
        "paper/run.py",
        "paper/stamp.py",
        "paper/work.py",
    }
    folders = ("analyses/", "cli/", "plots/", "paper/figures/", "paper/claims/")
    root = Path(gelcone.__file__).parent
    every = {path.relative_to(root).as_posix() for path in root.rglob("*.py")}
    computing = {name for name in every if name not in shown and not name.startswith(folders)}
    assert {name for name, _ in module.sources() if name.endswith(".py")} == computing
    assert {"devices/materials.toml", "presets.toml"} & {name for name, _ in module.sources()}
