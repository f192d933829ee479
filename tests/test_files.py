"""Files on disk: whole or not at all, never over another one unasked."""

import os
import stat

import pytest

from gelcone import InputError
from gelcone.files import check_writable, write_together, write_whole


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
    with pytest.raises(InputError, match="exists already; choose another folder or give --force to overwrite it"):
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
