"""Bad input is one clear line: generated command lines and damaged files, none of which ends in a traceback or a NaN.

    python benchmarks/fuzz.py [INPUTS] [SEED]      (default 10,000 and 2026)

A command line takes a command, a device or none, and some of the options of all commands with values of every unit,
spelling and size. Each runs in this process; one of a hundred in a process of its own. What it asks for is computed for
``simulate`` and ``static``; the other commands stop where their work would begin, but for one of twenty, which is made
small (`SMALL`). Files are the device files, results, films and stores of gelcone with bytes changed, cut and doubled.

An input fails that raises anything but an error of the input, takes longer than 10 s of processor time or two minutes
in all, ends with another exit code than 0, 1 or 2, prints more than a line for each error, or calls a run ok that holds
no number.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

LONGEST = 10.0
"""Processor time, in seconds."""
PATIENCE = 120.0
IN_PROCESSES = 0.01
COMPUTED = 0.05
ALWAYS_COMPUTED = ("simulate", "static", "devices", "materials", "help", "init", "show")
LEFT_OUT = ("paper", "studio")
"""Commands that write many files or serve; their arguments have tests of their own."""
FREQUENCY = ("frequency=5 Hz,8 Hz", "drive_frequency=1,2")
VOLTAGE = ("voltage_amplitude=100 V,500 V", "voltage=0.1,0.5")
SMALL = {
    "envelope": (FREQUENCY, ("peak_voltage=100 V,500 V", "peak_voltage=0.1,0.5")),
    "frequency": (FREQUENCY,),
    "tongues": (FREQUENCY, VOLTAGE),
    "basin": (("displacement=1 mm,2 mm", "displacement=0.1,0.2"), ("velocity=0 m/s,1 m/s", "velocity=0,0.1")),
    "bifurcation": (VOLTAGE,),
    "map": (VOLTAGE, FREQUENCY),
    "sweep": (VOLTAGE,),
}
"""Values of --over for commands that take a grid, with a device and without."""
SHORT = {"lyapunov": (("--window", "--budget"), ("1 s", "100")), "regime": (("--budget",), ("1 s", "100"))}
"""Options of commands that average for long, with their values with a device and without."""
NUMBERS = (
    "0",
    "1",
    "-1",
    "0.5",
    "2",
    "1e-300",
    "1e154",
    "1e155",
    "1e300",
    "1e400",
    "-0",
    "nan",
    "inf",
    "-inf",
    "1_0",
    "0x10",
)
UNITS = (
    "",
    "mm",
    "m",
    " mm",
    " V",
    "V",
    " kV",
    " MV",
    " Hz",
    " ms",
    " s",
    " kPa",
    " g",
    " N/m",
    " N s/m",
    " MM",
    " kV/mm",
    "°",
)
TEXTS = (
    "",
    " ",
    ",",
    ":",
    "::",
    "x",
    "1,2,",
    "1:2",
    "1:2:3:4",
    "0:1:1e9",
    "~",
    "1~",
    "~1",
    "../..",
    "\x00",
    "é",
    "a=b",
    "=",
    "None",
)
NAMES = (
    "voltage",
    "voltage_amplitude",
    "film_thickness",
    "material.shear_modulus",
    "material",
    "material.x",
    "frequency",
)
NAMES += (
    "drive_frequency",
    "prestretch",
    "prestretch_mode",
    "law",
    "damping",
    "mass",
    "quality_factor",
    "stretch_limit",
)
NAMES += (
    "initial_height",
    "release_height",
    "spring_stiffness",
    "displacement",
    "velocity",
    "radius_ratio",
    "film",
    "x",
)
SUBJECTS = ((), ("soft-film",), ("biased-pump",), ("paper-table1",), ("none.toml",), ("mine.toml",), ("broken.toml",))


@dataclass(frozen=True)
class Failure:
    """An input that did not end as it must, and how it ended."""

    told: str
    arguments: tuple[str, ...]


class TooLong(BaseException):
    """An input exceeded its time; not an error of gelcone's own, which would be reported in a line."""


class Begun(Exception):
    """The work of a command line would begin."""


# --- command lines ----------------------------------------------------------------------------------------------------


def value(rng: random.Random) -> str:
    """A value for an option."""
    kind = rng.random()
    if kind < 0.45:
        return rng.choice(NUMBERS[:6]) + rng.choice(UNITS)
    if kind < 0.6:
        return rng.choice(NUMBERS) + rng.choice(UNITS)
    if kind < 0.75:
        unit = rng.choice(UNITS)
        count = rng.choice(("2", "3", "1", "-1", "1e7", "10000000"))
        return f"{rng.choice(NUMBERS)}{unit}:{rng.choice(NUMBERS)}{unit}:{count}"
    if kind < 0.85:
        return ",".join(rng.choice(NUMBERS) + rng.choice(UNITS) for _ in range(rng.randint(2, 3)))
    if kind < 0.9:
        return f"{rng.choice(NUMBERS)}{rng.choice(UNITS)}~{rng.choice(NUMBERS)}"
    return rng.choice(TEXTS)


def command_line(rng: random.Random) -> list[str]:
    """A command line for gelcone."""
    from gelcone.cli import COMMANDS, group

    name = rng.choice(("simulate", "static", *COMMANDS))
    if name in LEFT_OUT:
        name = "simulate"
    command = group.get_command(None, name)
    arguments = [name, *rng.choice(SUBJECTS)]
    options = [p for p in command.params if p.param_type_name == "option" and p.name not in ("workers", "scheduler")]
    for option in rng.sample(options, min(len(options), rng.choice((0, 1, 1, 2, 3)))):
        arguments.append(option.opts[0])
        if option.is_flag:
            continue
        if option.name in ("settings", "over", "uncertain"):
            arguments.append(f"{rng.choice(NAMES)}={value(rng)}" if rng.random() < 0.95 else value(rng))
        elif option.name in ("out", "store", "resume"):
            arguments.append(rng.choice(("", "results", "mine.toml", "store.zarr", "a/b/c", "/proc/x")))
        elif option.name in ("periods", "repeats", "count", "discard", "bisections", "coarsest"):
            arguments.append(rng.choice(("2", "3", "0", "-1", "nan", "x", "1e300", "", "inf")))
        elif option.name == "threads":
            arguments.append(rng.choice(("1", "0", "-1", "x")))
        elif option.name == "tolerance":
            arguments.append(rng.choice(("1e-9", "0", "-1", "nan", "2", "x")))
        else:
            arguments.append(value(rng))
    if rng.random() < 0.02:
        rng.shuffle(arguments)
    if "--json" in [opt for p in options for opt in p.opts] and "--json" not in arguments:
        arguments.append("--json")
    return arguments


def small_grid(arguments: list[str]) -> list[str]:
    """Adds few points for a command that takes a grid, and a short average."""
    without_device = len(arguments) < 2 or arguments[1].startswith("-")
    names, values = SHORT.get(arguments[0], ((), ("", "")))
    short = [word for name in names if name not in arguments for word in (name, values[without_device])]
    if "--over" in arguments:
        return short
    return short + [word for axis in SMALL.get(arguments[0], ()) for word in ("--over", axis[without_device])]


def in_process(arguments: list[str], compute: bool) -> tuple[int, str, str]:
    """Exit code, output and errors of a command line in this process; code 0 where its work would begin."""
    from gelcone.cli import main

    out, err = io.StringIO(), io.StringIO()
    code: Any = 0
    stops = (
        []
        if compute
        else [mock.patch("gelcone.cli.command.plain", _begin), mock.patch("gelcone.cli.grids.plain", _begin)]
    )
    with contextlib.ExitStack() as stack:
        for patch in (mock.patch.object(sys, "argv", ["gelcone", *arguments]), *stops):
            stack.enter_context(patch)
        stack.enter_context(contextlib.redirect_stdout(out))
        stack.enter_context(contextlib.redirect_stderr(err))
        try:
            main()
        except SystemExit as left:
            code = left.code or 0
        except Begun:
            code = 0
    return code, out.getvalue(), err.getvalue()


def _begin(_: Any) -> Any:
    raise Begun


def in_a_process(arguments: list[str]) -> tuple[int, str, str]:
    """Exit code, output and errors of a command line in a process of its own."""
    if any("\x00" in argument for argument in arguments):
        return 2, "", "Error: a null byte cannot be passed"
    done = subprocess.run(
        [sys.executable, "-m", "gelcone", *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def judge(code: int, out: str, err: str) -> str:
    """The fault in how a command line ended; empty if there is none."""
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if "Traceback" in err:
        return "traceback"
    lines = [line for line in err.splitlines() if not line.startswith(("Warning: ", "fitting ", "Usage: "))]
    if code == 1 and out and not lines:  # every run failed, which the result tells
        return ""
    if code and not (lines and all(line.startswith("Error: ") and len(line) < 2000 for line in lines)):
        return f"errors are not a line each: {err[:300]!r}"
    if code == 0 and out.startswith("{"):
        return _numbers(json.loads(out, parse_constant=lambda name: name))
    return ""


def _numbers(answer: dict[str, Any]) -> str:
    """Whether a run reported as ok holds no number."""
    if "NaN" in json.dumps(answer):
        return "NaN in JSON"
    inner = answer.get("result") or answer
    outcome = answer.get("outcome")
    no_points = inner.get("count") == 0
    places = inner.get("displacement")
    if outcome == "ok" and not no_points and isinstance(places, list) and None in places:
        return "a run is called ok whose displacement is no number"
    return ""


def try_line(arguments: list[str], *, own_process: bool = False, compute: bool = False) -> str:
    """The fault in how a command line ends; empty if there is none."""
    begun = time.process_time()
    try:
        with _alarm():
            code, out, err = in_a_process(arguments) if own_process else in_process(arguments, compute)
    except TooLong:
        return "took too long"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return f"{type(error).__name__}: {error}\n{traceback.format_exc(limit=-4)}"
    if not own_process and time.process_time() - begun > LONGEST:
        return "took too long"
    return judge(code, out, err)


@contextlib.contextmanager
def _alarm() -> Iterator[None]:
    """Raises `TooLong` after the longest processor time, or after `PATIENCE`."""

    def ring(*_: object) -> None:
        raise TooLong

    before = {number: signal.signal(number, ring) for number in (signal.SIGALRM, signal.SIGPROF)}
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        yield
    finally:
        for timer in (signal.ITIMER_PROF, signal.ITIMER_REAL):
            signal.setitimer(timer, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)


# --- files ------------------------------------------------------------------------------------------------------------


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Bytes with some changed, cut or doubled."""
    if not data:
        return data
    first, last = sorted(rng.randrange(len(data)) for _ in range(2))
    kind = rng.randrange(4)
    if kind == 0:
        return data[:first]
    if kind == 1:
        return data[:first] + data[last:]
    if kind == 2:
        return data[:last] + data[first:]
    changed = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        changed[rng.randrange(len(changed))] = rng.choice((0, 32, 34, 44, 61, 91, 255, rng.randrange(256)))
    return bytes(changed)


def wholes(folder: Path) -> list[Path]:
    """Files of every kind that gelcone reads: a device, a result, a store."""
    import gelcone

    device = gelcone.find_device("soft-film")
    toml, result, store = folder / "whole.toml", folder / "whole.nc", folder / "whole.zarr"
    toml.write_text(device.replace({"material.shear_modulus": 4e3}).to_toml(), encoding="utf-8")
    gelcone.save(gelcone.simulate(device, periods=1), result)
    plan = gelcone.Plan(gelcone.ConeModel(), {"voltage": [0.1, 0.2]})
    gelcone.sweep(plan, "limits", store=store)
    return [toml, result, store]


def try_file(whole: Path, rng: random.Random) -> str:
    """The fault in how a damaged file is read; empty if there is none."""
    import gelcone

    copy = whole.with_name(f"damaged{whole.suffix}")
    if whole.is_dir():
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(whole, copy)
        parts = [path for path in sorted(copy.rglob("*")) if path.is_file()]
        target, source = rng.choice(parts), None
    else:
        target, source = copy, whole.read_bytes()
    target.write_bytes(damaged(target.read_bytes() if source is None else source, rng))
    read = {".toml": gelcone.find_device, ".nc": gelcone.load, ".zarr": gelcone.show}[whole.suffix]
    try:
        with _alarm():
            read(copy)
    except gelcone.InputError:
        return ""
    except TooLong:
        return "took too long"
    except Exception as error:
        return f"{type(error).__name__}: {error}\n{traceback.format_exc(limit=-4)}"
    return ""


# --- all of them ------------------------------------------------------------------------------------------------------


def run(count: int, seed: int, *, files: float = 0.2, processes: float = IN_PROCESSES) -> list[Failure]:
    """Tries ``count`` inputs in an empty folder, ``files`` of them damaged files; returns those that fail."""
    import warnings

    rng = random.Random(seed)
    failures = []
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("always")
        os.chdir(folder)
        try:
            known = wholes(Path(folder)) if files else []
            Path("mine.toml").write_text("disc_radius = 3\n", encoding="utf-8")
            Path("broken.toml").write_text("disc_radius = = 3\n", encoding="utf-8")
            for _ in range(count):
                if rng.random() < files:
                    whole = rng.choice(known)
                    arguments, told = [f"damaged{whole.suffix}"], try_file(whole, rng)
                else:
                    arguments = command_line(rng)
                    own, all_of_it = rng.random() < processes, rng.random() < COMPUTED
                    compute = arguments[0] in ALWAYS_COMPUTED or all_of_it
                    arguments += small_grid(arguments) if all_of_it else []
                    told = try_line(arguments, own_process=own, compute=compute)
                if told:
                    failures.append(Failure(told, tuple(arguments)))
        finally:
            os.chdir(here)
    return failures


def main() -> None:
    """Prints the failures and their number."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 2026
    begun = time.monotonic()
    failures = run(count, seed)
    for failure in failures[:40]:
        print(f"gelcone {' '.join(map(repr, failure.arguments))}\n    {failure.told}")
    kinds = Counter(failure.told.splitlines()[0][:60] for failure in failures)
    for kind, number in kinds.most_common():
        print(f"{number:6d}  {kind}")
    print(f"{count} inputs, {len(failures)} failures, {time.monotonic() - begun:.0f} s")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
