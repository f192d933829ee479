"""The numbers of the page Benchmarks: runs benchmarks and writes their output to docs/benchmarks.txt.

python benchmarks/page.py [NAME.py ...] (some minutes; by default all, and what others printed stays)

What threads, processes and workers gain is left out on a busy machine, which it does not tell.
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import gelcone

ROOT = Path(__file__).resolve().parents[1]
RUNS = {
    "engine.py": ("3",),
    "peak.py": ("80",),
    "cells.py": ("41", "33", "--turns", "1"),
    "cluster.py": ("21", "17", "--turns", "5"),
}
QUIET = 0.3
"""Load of a machine on which threads and processes can be compared."""


def processor() -> str:
    """The name of this machine's processor, if the system reports it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.processor())


def without_scaling(text: str) -> str:
    """The output of a benchmark without the gains of threads, processes and workers, which a busy machine distorts."""
    lines = [line for line in text.splitlines() if "over one:" not in line]
    return re.sub(r"; two threads [\d.]+", "", "\n".join(lines))


def sections(text: str) -> dict[str, str]:
    """Contents of the page, by the name of the benchmark."""
    parts = re.split(r"^(?=\$ python benchmarks/)", text, flags=re.MULTILINE)[1:]
    return {part.split()[2].removeprefix("benchmarks/"): part.strip() for part in parts}


def printed_by(name: str) -> str:
    """The command of a benchmark, the machine and the day, and its output."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    busy = f", a load of {load:.0f} by other work when it began" if load > QUIET else ""
    command = [sys.executable, str(ROOT / "benchmarks" / name), *RUNS[name]]
    done = subprocess.run(command, capture_output=True, text=True, check=True).stdout.rstrip()
    lines = [
        f"$ python benchmarks/{name} {' '.join(RUNS[name])}",
        f"gelcone {gelcone.__version__}, {datetime.now(UTC):%Y-%m-%d}, Python {platform.python_version()}, "
        f"{processor()}, {os.cpu_count()} cores{busy}",
        without_scaling(done) if busy else done,
    ]
    return "\n".join(lines)


def main(names: list[str]) -> None:
    """Runs one benchmark after the other."""
    page = ROOT / "docs" / "benchmarks.txt"
    known = sections(page.read_text(encoding="utf-8"))
    for name in names or RUNS:
        known[name] = printed_by(name)
    text = "\n\n".join(known[name] for name in RUNS if name in known)
    page.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
