"""The lock of a store: one writer, released however the writing process ends, and no trace of it afterwards."""

import subprocess
import sys
import textwrap

import pytest

from gelcone.atlas.store import LOCK, VERSION, open_store
from gelcone.errors import InputError

PLAN = {VERSION: "1.0", "analysis": "regime"}
HOLD = textwrap.dedent(
    """
    import sys
    from pathlib import Path

    from gelcone.atlas.store import open_store

    with open_store(Path(sys.argv[1]), {"gelcone_version": "1.0", "analysis": "regime"}, ("x",), (4,), resume=False):
        print("open", flush=True)
        sys.stdin.read()
    """
)


def opened(path, resume=True):
    return open_store(path, PLAN, ("x",), (4,), resume=resume)


@pytest.fixture
def other(tmp_path):
    """Another process that holds the store ``s``."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path / "s")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with process:
        assert process.stdout.readline() == "open\n"
        yield process
        process.kill()


def test_a_second_process_is_refused_with_a_remedy(tmp_path, other):
    with pytest.raises(InputError, match="another run is writing to it; wait for it, or choose another store"):
        opened(tmp_path / "s").__enter__()


def test_a_killed_process_leaves_the_store_free(tmp_path, other):
    other.kill()
    other.wait()
    assert (tmp_path / "s" / LOCK).exists()
    with opened(tmp_path / "s") as store:
        assert store.read() == {}


def test_a_finished_process_leaves_the_store_free_and_no_lock_file(tmp_path, other):
    other.stdin.close()
    assert other.wait() == 0
    assert not (tmp_path / "s" / LOCK).exists()
    with opened(tmp_path / "s"):
        assert (tmp_path / "s" / LOCK).exists()
    assert not (tmp_path / "s" / LOCK).exists()


def test_a_lock_without_a_store_is_one_to_begin_again(tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / LOCK).touch()
    with opened(tmp_path / "s", resume=False) as store:
        assert store.read() == {}


def test_a_failed_run_releases_the_store(tmp_path):
    with pytest.raises(ZeroDivisionError), opened(tmp_path / "s", resume=False):
        raise ZeroDivisionError
    with opened(tmp_path / "s"):
        pass


def test_a_file_system_that_cannot_lock_is_a_warning_and_no_stop(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("filelock.FileLock.acquire", refuse)
    with (
        pytest.warns(UserWarning, match=r"cannot be locked \(.*not supported\); start no second run"),
        opened(tmp_path / "s", resume=False) as store,
    ):
        assert store.read() == {}


def test_a_store_of_another_version_names_both_and_what_to_do(tmp_path):
    with opened(tmp_path / "s", resume=False):
        pass
    with (
        pytest.raises(InputError, match=r"is 1\.0 there and 2\.0 here.*resume it with gelcone 1\.0, or choose another"),
        open_store(tmp_path / "s", PLAN | {VERSION: "2.0"}, ("x",), (4,), resume=True),
    ):
        pass
