"""What all tests need."""

import gc
import os
import signal
import sys

import pytest

# On cores that several processes share, threads of BLAS wait for one another and take a hundred times as long as one
# does for the small matrices here. It is read where NumPy is first imported, also in subprocesses.
NUMPY_CAME_FIRST = "numpy" in sys.modules
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell that runs its jobs in the background has them ignore interrupts, and so would the processes of the tests.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure():
    """Programs are compiled at the lowest level, which takes a quarter of the time, for the same bits.

    `test_compile` compares them with those of a process that has the defaults, as all processes that tests start. No
    such process finds this code in the cache. The cache holds that of all tests, which is more than what a user needs,
    so that a second run compiles nothing.
    """
    from gelcone import disk_cache
    from gelcone.motion.engine import compile as compiler

    made = compiler.object_code
    compiler.object_code = lambda text, machine, level=compiler.QUICK: made(text, machine, compiler.QUICK)
    compiler.CODE = f"{compiler.CODE}-tests"
    disk_cache.MOST_BYTES = 2**28


def pytest_collectstart():
    """Tests are collected without the collector of garbage, which would take a third of that time: they all live."""
    gc.disable()


def pytest_collection_finish():
    """It does not look through the tests themselves later, either, and seldom through what they make."""
    gc.enable()
    gc.freeze()
    gc.set_threshold(20_000)


TOGETHER = {
    "tests/paper/test_figures.py": "tests/paper/test_motions.py",
    "tests/plots/test_register.py": "tests/lab/test_design.py",
}
"""Files of tests that use what those of another file compute."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With several processes, files that share a computation run in one of them."""
    if config.option.dist != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Sharing(LoadFileScheduling):
        def _split_scope(self, nodeid):
            name = nodeid.partition("::")[0]
            return TOGETHER.get(name, name)

    return Sharing(config, log)


@pytest.fixture
def command_line(monkeypatch, capsys, tmp_path):
    """Runs ``gelcone`` with the given arguments in an empty folder: exit code, standard output and standard error.

    Commands say nothing of what takes long, however busy the machine is; tests of progress set a time of their own.
    """
    from gelcone.cli import main, waiting

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(waiting, "FIRST_SECONDS", 3600.0)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["gelcone", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        printed = capsys.readouterr()
        return left.value.code, printed.out, printed.err

    return run


@pytest.fixture
def undrawn(monkeypatch):
    """Figures are made and not drawn, which takes longest: for tests of files whose figures the tests of plots draw."""
    from gelcone.plots import style

    monkeypatch.setattr(style, "draw_file", lambda figure, path: path.write_bytes(f"{len(figure.axes)} axes".encode()))


@pytest.fixture
def delivered(monkeypatch):
    """The results that commands would write, in the order of the commands; nothing is drawn or written."""
    from gelcone.cli import output

    results = []
    monkeypatch.setattr(output, "plot", lambda result, **options: None)
    monkeypatch.setattr(output, "write_results", lambda out, name, result, figure, force: results.append(result) or ())
    return results


@pytest.fixture
def integrations(monkeypatch):
    """The tolerance and the threads of each integration so far, as a set."""
    from gelcone.motion import flow

    seen, check = set(), flow.check_flow

    def checked(tolerance, threads):
        seen.add((tolerance, threads))
        check(tolerance, threads)

    monkeypatch.setattr(flow, "check_flow", checked)
    return seen


@pytest.fixture
def undelivered(monkeypatch):
    """Runs have no root mean squares and peaks of what a source delivers, which take longer than the motion where the
    film is a membrane; runs of `test_membrane_charge` have them."""
    from gelcone.motion import response

    monkeypatch.setattr(response, "delivered", lambda *given: {})


@pytest.fixture
def no_membranes(monkeypatch):
    """The membranes for which cones stand are not made, which takes seconds for each film."""
    from gelcone.physics.film import pull_in

    monkeypatch.setattr(pull_in, "curve_of", lambda *key: None)
