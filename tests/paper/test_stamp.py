"""What the data of a study depend on: sizes, versions, and all sources that compute."""

from dataclasses import replace

import pytest

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
