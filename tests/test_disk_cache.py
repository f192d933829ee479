"""The disk cache: entries that are whole and one's own are found, all others are as if they were not there."""

import os
from pathlib import Path

import pytest

from gelcone import disk_cache

CONTENT = bytes(range(256)) * 8


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "kind"


def test_content_comes_back_under_its_kind_and_key(folder):
    assert disk_cache.read("kind", "key") is None
    disk_cache.write("kind", "key", CONTENT)
    assert disk_cache.read("kind", "key") == CONTENT
    assert [path.name for path in folder.iterdir()] == ["key"]
    assert disk_cache.read("another", "key") is None
    assert disk_cache.read("kind", "another") is None


@pytest.mark.parametrize("damage", ["cut", "flip", "head", "empty", "foreign", "folder"])
def test_a_damaged_entry_is_not_found(folder, damage):
    disk_cache.write("kind", "key", CONTENT)
    disk_cache.write("kind", "other", CONTENT)
    entry, whole = folder / "key", (folder / "key").read_bytes()
    if damage == "folder":
        entry.unlink()
        entry.mkdir()
    else:
        entry.write_bytes(
            {
                "cut": whole[:-100],
                "flip": whole[:-50] + bytes([whole[-50] ^ 1]) + whole[-49:],
                "head": b"G" + whole[1:],
                "empty": b"",
                "foreign": (folder / "other").read_bytes(),  # whole, under another key
            }[damage]
        )
    assert disk_cache.read("kind", "key") is None
    if damage != "folder":
        disk_cache.write("kind", "key", CONTENT)
        assert disk_cache.read("kind", "key") == CONTENT


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no such owner here")
def test_an_entry_of_another_owner_is_not_found(folder, monkeypatch):
    disk_cache.write("kind", "key", CONTENT)
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    assert disk_cache.read("kind", "key") is None


def test_the_entries_used_longest_ago_go_first(folder, monkeypatch):
    for number, name in enumerate("abc"):
        disk_cache.write("kind", name, CONTENT)
        os.utime(folder / name, (number + 1.0, number + 1.0))
    disk_cache.read("kind", "a")  # used just now
    size = (folder / "a").stat().st_size
    monkeypatch.setattr(disk_cache, "MOST_BYTES", 3.5 * size)
    disk_cache.write("kind", "d", CONTENT)
    assert sorted(path.name for path in folder.iterdir()) == ["a", "c", "d"]


def test_without_a_folder_nothing_is_stored(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("GELCONE_CACHE", "")
    disk_cache.write("kind", "key", CONTENT)
    assert disk_cache.folder("kind") is None
    assert disk_cache.read("kind", "key") is None
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path / "file" / "below"))
    disk_cache.write("kind", "key", CONTENT)
    assert disk_cache.read("kind", "key") is None


def test_the_usual_folder_is_below_the_home(monkeypatch, tmp_path):
    monkeypatch.delenv("GELCONE_CACHE", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert disk_cache.folder("kind") == tmp_path / "gelcone" / "kind"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert disk_cache.folder("kind") is None
    monkeypatch.delenv("XDG_CACHE_HOME")

    def homeless(*_):
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", homeless)
    assert disk_cache.folder("kind") is None


def test_a_file_left_half_written_does_no_harm(folder):
    folder.mkdir(parents=True)
    (folder / "0123456789abcdef.part").write_bytes(b"half")
    disk_cache.write("kind", "key", CONTENT)
    assert disk_cache.read("kind", "key") == CONTENT


def test_an_empty_key_is_neither_stored_nor_found(folder):
    disk_cache.write("kind", "", CONTENT)
    assert not folder.exists()
    assert disk_cache.read("kind", "") is None


def test_an_entry_is_made_again_when_parts_a_file_or_the_file_of_a_class_change(folder, tmp_path, monkeypatch):
    calls = []

    def made(parts, *sources):
        disk_cache.digest_of.cache_clear()
        calls.append(parts)
        return disk_cache.made("kind", parts, lambda: str(len(calls)).encode(), sources)

    law, other = tmp_path / "law.py", tmp_path / "other.py"
    for path in (law, other):
        path.write_text("1")
    monkeypatch.setattr(disk_cache.inspect, "getfile", lambda own: law)
    assert made((1.0, "a"), tmp_path) == made((1.0, "a"), tmp_path) == b"1"
    assert made((1.0, "b"), tmp_path) == b"3"
    assert made((1.0, "a"), tmp_path, int) == made((1.0, "a"), tmp_path) == b"1"  # the class lies in the folder
    other.write_text("2")
    assert made((1.0, "a"), tmp_path) == b"6"
    assert made((1.0, "a"), int) == made((1.0, "a"), int) == b"7"
    law.write_text("2")
    assert made((1.0, "a"), int) == b"9"


def test_what_is_not_made_is_refused_where_one_asks_for_that(folder, monkeypatch):
    def made(parts, make=lambda: CONTENT):
        return disk_cache.made("kind", parts, make, (Path(__file__),))

    with pytest.raises(disk_cache.Unmade), disk_cache.unmade_refused():
        made(1)
    assert made(1) == CONTENT
    with disk_cache.unmade_refused():
        assert made(1, lambda: pytest.fail("it is there")) == CONTENT
        monkeypatch.setenv("GELCONE_CACHE", "")  # where nothing is stored, nothing is waited for
        assert made(2) == CONTENT


def test_one_may_ask_whether_content_is_there_and_whether_none_may_be_made(folder, monkeypatch):
    parts = ("a", 1.5)
    assert not disk_cache.holds("kind", parts, ())
    assert not (folder / "kind").exists()
    disk_cache.made("kind", parts, lambda: b"content", ())
    assert disk_cache.holds("kind", parts, ())
    assert not disk_cache.holds("kind", ("a", 2.5), ())
    assert not disk_cache.holds("other", parts, ())
    assert not disk_cache.refuses()
    with disk_cache.unmade_refused():
        assert disk_cache.refuses()
    assert not disk_cache.refuses()


def test_what_a_class_of_a_session_gives_is_not_stored(folder):
    session = {"__name__": "a session"}
    exec("class Own: pass", session)
    assert disk_cache.made("kind", 1, lambda: b"one", (session["Own"],)) == b"one"
    assert disk_cache.made("kind", 1, lambda: b"two", (session["Own"],)) == b"two"
