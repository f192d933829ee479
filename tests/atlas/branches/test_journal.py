"""A run along branches that is stopped anywhere goes on there, and gives the bits of one that was not."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import InputError
from gelcone.atlas.branches import check, follow, journal
from gelcone.atlas.store import LOCK
from gelcone.presets import find_preset

BASE = find_preset("base").model


def followed(store=None, **options):
    """A branch, the one born at its doubling, brute force and runs beside."""
    given = {"switch": 1, "checks": 2, "start": "settled"} | options
    return gelcone.continue_branch(BASE, "voltage", 0.99, 1.01, store=store, **given)


@pytest.fixture(scope="module")
def whole():
    return followed()


def stopped_at(monkeypatch, module, name, calls):
    """Replaces a function by one that is interrupted at so many calls, and tells of all calls."""
    original, made = getattr(module, name), []

    def counted(*arguments, **options):
        made.append(name)
        if len(made) == calls:
            raise KeyboardInterrupt
        return original(*arguments, **options)

    monkeypatch.setattr(module, name, counted)
    return made


def test_a_run_stopped_again_and_again_gives_the_same_bits(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(journal, "EVERY", 0.0)
    for module, name, calls in (
        (follow, "correct", 12),
        (follow, "correct", 20),
        (check, "search", 1),
        (check, "settle", 1),
    ):
        with monkeypatch.context() as patch:
            stopped_at(patch, module, name, calls)
            with pytest.raises(KeyboardInterrupt):
                followed(tmp_path / "store", resume=(tmp_path / "store").exists())
    again = stopped_at(monkeypatch, follow, "correct", 0)
    xr.testing.assert_identical(followed(tmp_path / "store", resume=True), whole)
    assert not again


def test_a_run_that_is_done_is_not_computed_again(whole, tmp_path, monkeypatch):
    followed(tmp_path)
    for module, name in ((follow, "correct"), (check, "settle")):
        monkeypatch.setattr(module, name, None)
    result = followed(tmp_path, resume=True)
    np.testing.assert_array_equal(result["orbit"], whole["orbit"])
    xr.testing.assert_identical(result, whole)


def test_a_store_of_another_run_is_refused(tmp_path):
    first = gelcone.continue_branch(BASE, "voltage", 0.93, 0.95, checks=2, store=tmp_path)
    with pytest.raises(InputError, match=r"holds another run: high is 0.95 there and 0.96 here"):
        gelcone.continue_branch(BASE, "voltage", 0.93, 0.96, checks=2, store=tmp_path, resume=True)
    with pytest.raises(InputError, match="start is rest there and result"):
        gelcone.continue_branch(BASE, "voltage", 0.93, 0.95, checks=2, start=first, store=tmp_path, resume=True)
    with pytest.raises(InputError, match="holds branches, no sweep"):
        gelcone.show(tmp_path)


def test_a_store_that_exists_is_continued_by_resume_alone(tmp_path):
    with journal.journal_in(tmp_path / "store", {"a": 1}, resume=False):
        pass
    with (
        pytest.raises(InputError, match="store: is not empty; resume it with --resume"),
        journal.journal_in(tmp_path / "store", {"a": 1}, resume=False),
    ):
        pass
    with journal.journal_in(tmp_path / "store", {"a": 1}, resume=True):
        pass
    with pytest.raises(InputError, match="none"), journal.journal_in(tmp_path / "none", {"a": 1}, resume=True):
        pass


def test_a_folder_with_something_else_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty; resume it with --resume"):
        gelcone.continue_branch(BASE, "voltage", 0.93, 0.95, checks=2, store=tmp_path)


def test_what_a_run_left_that_was_killed_before_it_wrote_is_no_obstacle(tmp_path):
    (tmp_path / LOCK).write_bytes(b"")
    with journal.journal_in(tmp_path, {"a": 1}, resume=False):
        assert (tmp_path / "zarr.json").is_file()


def test_a_damaged_entry_is_told(tmp_path):
    gelcone.continue_branch(BASE, "voltage", 0.93, 0.95, checks=2, store=tmp_path)
    entry = tmp_path / "00000.npz"
    entry.write_bytes(entry.read_bytes()[:100])
    with pytest.raises(InputError, match=r"00000.npz: is damaged .* remove it"):
        gelcone.continue_branch(BASE, "voltage", 0.93, 0.95, checks=2, store=tmp_path, resume=True)


def test_the_state_of_an_entry_under_way_is_written_now_and_then(tmp_path, monkeypatch):
    """Once `EVERY` has passed since what was written last, and not before; the whole entry takes its place."""
    clock, noted = [100.0], []
    monkeypatch.setattr(journal.time, "monotonic", lambda: clock[0])
    own = journal.Journal(tmp_path)
    for now in (100.5, 101.1, 101.5, 102.0, 102.2):
        clock[0] = now
        own.note(lambda now=now: noted.append(now) or {"at": np.array(now)})
    assert noted == [101.1, 102.2]
    found, all_of_it = journal.Journal(tmp_path).begin()
    assert (float(found["at"]), all_of_it) == (102.2, False)
    own.end(lambda: {"at": np.array(7.0)})
    found, all_of_it = journal.Journal(tmp_path).begin()
    assert (float(found["at"]), all_of_it) == (7.0, True)
    assert len(list(tmp_path.iterdir())) == 1


def test_what_a_run_that_was_killed_left_half_written_is_removed(tmp_path):
    with journal.journal_in(tmp_path, {"a": 1}, resume=False) as own:
        own.entry(lambda: {"found": np.arange(3)})
    (tmp_path / ".00001.npz").write_bytes(b"half")
    with journal.journal_in(tmp_path, {"a": 1}, resume=True) as own:
        assert not list(tmp_path.glob(".*.npz"))
        assert own.entry(dict)["found"].tolist() == [0, 1, 2]
