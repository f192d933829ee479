"""Files on disk: whole or not at all, never over another one unasked."""

import os
import socket
import stat
from pathlib import Path

import pytest

from gelcone import InputError, files, find_device
from gelcone.files import check_writable, read_text, write_together, write_whole


def write_text(text):
    return lambda path: path.write_text(text)


def half_written(path):
    path.write_text("half")
    raise RuntimeError("disk full")


# --- whole or not at all ----------------------------------------------------------------------------------------------


def test_a_file_appears_with_the_folders_above_it(tmp_path):
    path = tmp_path / "some" / "where" / "a.txt"
    write_whole(path, write_text("whole"))
    assert path.read_text() == "whole"
    assert os.listdir(path.parent) == ["a.txt"]


def test_a_file_has_the_usual_permissions(tmp_path):
    write_whole(tmp_path / "a.txt", write_text("whole"))
    (tmp_path / "b.txt").write_text("by hand")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("a.txt", "b.txt")}
    assert len(modes) == 1


def test_the_writer_sees_the_suffix_of_the_file(tmp_path):
    seen = []
    write_whole(tmp_path / "a.nc", lambda path: seen.append(path))
    assert [path.suffix for path in seen] == [".nc"]
    assert seen[0].parent == tmp_path


def test_a_writer_that_raises_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="disk full"):
        write_whole(tmp_path / "a.txt", half_written)
    assert os.listdir(tmp_path) == []


def test_a_writer_that_raises_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="disk full"):
        write_whole(path, half_written, force=True)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_an_interrupt_while_writing_leaves_nothing(tmp_path):
    def interrupted(path):
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_together({tmp_path / "a.txt": write_text("whole"), tmp_path / "b.txt": interrupted})
    assert os.listdir(tmp_path) == []


def test_several_files_appear_together(tmp_path):
    files = {tmp_path / "a.txt": write_text("one"), tmp_path / "b.txt": write_text("two")}
    write_together(files)
    assert sorted(os.listdir(tmp_path)) == ["a.txt", "b.txt"]
    with pytest.raises(RuntimeError, match="disk full"):
        write_together(dict.fromkeys(files, half_written), force=True)
    assert [path.read_text() for path in files] == ["one", "two"]


# --- what is refused --------------------------------------------------------------------------------------------------


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(
        InputError, match=r"exists already; choose another name, or overwrite it with force \(force=True, --force\)"
    ):
        write_whole(path, write_text("new"))
    assert path.read_text() == "old"
    write_whole(path, write_text("new"), force=True)
    assert path.read_text() == "new"


def test_a_folder_is_never_replaced(tmp_path):
    (tmp_path / "a.nc").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        write_whole(tmp_path / "a.nc", write_text("new"), force=True)


@pytest.mark.parametrize("below", ["a.nc", "more/a.nc"])
def test_a_folder_that_is_a_file_is_refused(tmp_path, below):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(InputError) as error:
        write_whole(tmp_path / "file" / below, write_text("new"))
    assert "cannot be written" in str(error.value)
    assert str(error.value).endswith("file is a file); choose another folder")
    assert (tmp_path / "file").read_text() == "not a folder"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_permission_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="no permission"):
        write_whole(tmp_path / "a.nc", write_text("new"))


@pytest.mark.parametrize("name", ["x" * 300, "nul\0byte"])
def test_a_name_that_no_folder_can_have_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="cannot be written"):
        write_whole(tmp_path / name / "a.nc", write_text("new"))


def test_looking_whether_files_can_be_written_touches_nothing(tmp_path):
    check_writable([tmp_path / "new" / "a.nc", tmp_path / "b.nc"])
    assert os.listdir(tmp_path) == []


# --- what is read -----------------------------------------------------------------------------------------------------


def test_a_text_is_read_with_and_without_its_byte_order_mark(tmp_path):
    for mark in (b"", b"\xef\xbb\xbf"):
        (tmp_path / "a.txt").write_bytes(mark + "µ".encode())
        assert read_text(tmp_path / "a.txt", "remedy") == "µ"


def test_only_a_regular_file_is_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(str(tmp_path / "socket"))
    (tmp_path / "link").symlink_to("/dev/zero")
    for path in ("/dev/zero", "/dev/stdin", tmp_path / "pipe", tmp_path / "socket", tmp_path / "link"):
        with pytest.raises(InputError, match="is not a regular file; give another"):
            read_text(Path(path), "give another")
    with pytest.raises(InputError, match="is a folder; give another"):
        read_text(tmp_path, "give another")
    listening.close()


def test_a_file_that_becomes_a_pipe_meanwhile_holds_up_nobody(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    regular = (tmp_path / "a.txt").write_text("") or (tmp_path / "a.txt").stat()
    monkeypatch.setattr(Path, "stat", lambda self: regular)
    assert read_text(tmp_path / "pipe", "remedy") == ""


def test_a_file_that_is_too_large_is_refused_after_the_bytes_that_are_read_at_most(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "LARGEST_TEXT", 2**20)
    path = tmp_path / "large.txt"
    path.write_bytes(b"x" * 2**20)
    assert len(read_text(path, "remedy")) == 2**20
    path.write_bytes(b"x" * (2**20 + 1))
    with pytest.raises(InputError, match=r"large.txt: is larger than 1 MB; give another"):
        read_text(path, "give another")
    with path.open("r+b") as file:
        file.truncate(2**40)  # a file with a hole, of which reading all would end the memory
    with pytest.raises(InputError, match="is larger than 1 MB"):
        read_text(path, "give another")


def test_devices_are_read_within_these_bounds(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "LARGEST_TEXT", 2**20)
    (tmp_path / "large").write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(InputError, match="is larger than 1 MB"):
        find_device(tmp_path / "large")
    with pytest.raises(InputError, match="is not a regular file"):
        find_device("/dev/zero")


def test_texts_that_a_user_names_are_read_in_this_one_place():
    """Other reads are of files that ship, or that gelcone wrote into a store or the user's cache."""
    own = {
        "__init__.py", "presets.py", "plots/style.py", "devices/materials.py", "cli/lists.py",
        "atlas/store.py", "atlas/branches/journal.py", "atlas/processes.py", "disk_cache.py",
        "export/sources.py", "export/compiler.py", "membrane/made.py",
        "motion/engine/compile.py", "paper/figures/figure.py", "paper/report.py", "paper/stamp.py", "studio/server.py",
        "studio/exports.py",
    }  # fmt: skip
    package = Path(files.__file__).parent
    reads = ("read_text(encoding", "read_bytes(", "np.load(", ".open(", " open(", "loadtxt", "genfromtxt", "fromfile(")
    found = {
        str(path.relative_to(package))
        for path in package.rglob("*.py")
        if any(read in path.read_text(encoding="utf-8") for read in reads)
    }
    assert found - own - {"files.py"} == set()
