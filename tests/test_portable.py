"""What Windows and macOS lack is not needed: every module imports and integrates without it, and a store is locked."""

import subprocess
import sys
import textwrap

import pytest

WITHOUT = textwrap.dedent(
    """
    import os, signal, sys

    for name in ("fcntl", "resource", "pwd", "grp", "termios", "heyoka"):
        sys.modules[name] = None
    missing = [(os, "sysconf"), (os, "sched_getaffinity"), (os, "O_DIRECTORY"), (os, "fork"), (signal, "SIGKILL")]
    for holder, name in missing:
        if hasattr(holder, name):
            delattr(holder, name)
    """
)
IMPORTS = """
import importlib, pkgutil
import gelcone

found = [module.name for module in pkgutil.walk_packages(gelcone.__path__, "gelcone.")]
for name in found:
    if name != "gelcone.__main__":
        importlib.import_module(name)
print(len(found))
"""
STORE = """
import warnings
from pathlib import Path
import gelcone
from gelcone.atlas.store import open_store
from gelcone.errors import InputError

path, plan = Path(sys.argv[1]), {"gelcone_version": "1.0"}
warnings.simplefilter("ignore")  # filelock reports that it falls back to a lock file that exists or does not
with open_store(path, plan, ("x",), (4,), resume=False) as store:
    print(store.read())
    try:
        with open_store(path, plan, ("x",), (4,), resume=True):
            print("two runs write")
    except InputError as error:
        print("another run" in str(error))
with open_store(path, plan, ("x",), (4,), resume=True):
    print("again")
"""
COMPUTE = """
import gelcone

model = gelcone.ConeModel(rest_height=0.3)
result = gelcone.static(model, [0.0, 0.5])
gelcone.save(result, sys.argv[1])
print(int(gelcone.load(sys.argv[1]).equilibria[0]), len(gelcone.plot(result).axes))
print(int(gelcone.simulate(model, periods=1).outcome))
"""


def run(program, *arguments):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT + program, *map(str, arguments)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_every_module_imports_without_what_only_linux_has():
    pytest.importorskip("skfem")
    (count,) = run(IMPORTS)
    assert int(count) > 100


def test_a_store_keeps_its_one_writer_without_the_locks_of_unix(tmp_path):
    assert run(STORE, tmp_path / "s") == ["{}", "True", "again"]


def test_statics_motion_files_and_figures_need_nothing_of_linux(tmp_path):
    assert run(COMPUTE, tmp_path / "a.nc") == ["1", "2", "0"]
