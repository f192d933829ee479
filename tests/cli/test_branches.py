"""`gelcone locus`: its curves on a map; `gelcone continue`: its store. Its answers are among the contracts of all."""

from pathlib import Path

import pytest

from gelcone.atlas import record
from gelcone.cli import branches
from tests.answers import result

LOCUS = ("locus", "fold", "--over", "voltage=1.15:1.3", "--over", "damping_ratio=0.009:0.011")


@pytest.mark.parametrize("on", [None, "map.nc", "map.zarr"])
@pytest.mark.parametrize("out", [None, "there"])
def test_curves_are_drawn_on_the_map_of_a_file_or_a_store(on, out, monkeypatch, command_line, tmp_path):
    """For the figure alone, so that without a place for it the map is refused before any work."""
    (tmp_path / "map.zarr").mkdir()
    ran = []

    def run(analysis, *, out, draw=None, **typed):
        ran.append((analysis.name, out, typed["words"]))
        return draw("curves") if draw else 1

    monkeypatch.setattr(branches, "run", run)
    monkeypatch.setattr(branches, "plot", lambda curves, on: ran.append((curves, on)) or 0)
    monkeypatch.setattr("gelcone.dataset.load", lambda path: f"file {path}")
    monkeypatch.setattr(record, "show", lambda path: f"store {path}")
    code, _, err = command_line(*LOCUS, *(("--on", on) if on else ()), *(("--out", out) if out else ()))
    if on and not out:
        message = f"Error: --on {on}: says what the curves are drawn on; give --out for the figure too\n"
        assert (code, err, ran) == (2, message, [])
    else:
        asked = ("locus", Path(out) if out else None, ("fold",))
        drawn = [("curves", {"map.nc": "file map.nc", "map.zarr": "store map.zarr"}[on])] if on else []
        assert (code, ran) == (0 if on else 1, [asked, *drawn])


@pytest.mark.slow
def test_a_locus_is_an_answer(command_line):
    code, out, err = command_line("locus", "doubling", "--preset", "base", *LOCUS[2:], "--json")
    assert code == 0, err
    content = result(out)
    assert content["command"] == "locus"
    assert content["parameters"]["drive_frequency"] > 0.0
    assert content["result"]


@pytest.mark.parametrize(
    ("typed", "store", "resume"), [((), None, None), (("--store", "s"), "s", None), (("--resume", "s"), "s", True)]
)
def test_branches_have_a_new_store_or_resume_one(typed, store, resume, monkeypatch, command_line):
    asked = []
    monkeypatch.setattr(branches, "run", lambda analysis, **given: asked.append((analysis.name, given)) or 0)
    assert command_line("continue", "voltage", "0.9", "1.1", *typed)[0] == 0
    ((name, given),) = asked
    assert (name, given["store"], given["resume"]) == ("continue_branch", store and Path(store), resume)


def test_branches_have_one_store(command_line):
    code, _, err = command_line("continue", "voltage", "0.9", "1.1", "--store", "a", "--resume", "b")
    assert (code, err) == (2, "Error: --store and --resume: give one of them; --store begins, --resume continues\n")
