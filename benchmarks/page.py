"""The numbers of the page Benchmarks: runs the benchmarks below and writes what they print to docs/benchmarks.txt.

python benchmarks/page.py      (some minutes; on a busy machine what threads and processes gain is left out)
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
RUNS = (("engine.py", "3"), ("cells.py", "41", "33", "--turns", "1"))
QUIET = 0.3
"""Load of a machine on which threads and processes can be compared."""


def processor() -> str:
    """The name of this machine's processor, where the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.processor())


def without_scaling(text: str) -> str:
    """What a benchmark printed without what threads and processes gain, which a busy machine does not tell."""
    lines = [line for line in text.splitlines() if "over one:" not in line]
    return re.sub(r"; two threads [\d.]+", "", "\n".join(lines))


def main() -> None:
    """Run one benchmark after the other."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    busy = f", a load of {load:.1f} when it began: scaling is left out" if load > QUIET else ""
    text = [f"gelcone {gelcone.__version__}, {datetime.now(UTC):%Y-%m-%d}, Python {platform.python_version()}"]
    text += [f"{processor()}, {os.cpu_count()} cores{busy}", ""]
    for name, *arguments in RUNS:
        command = [sys.executable, str(ROOT / "benchmarks" / name), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        printed = without_scaling(done.stdout) if busy else done.stdout.rstrip()
        text += [f"$ python benchmarks/{name} {' '.join(arguments)}", printed, ""]
    (ROOT / "docs" / "benchmarks.txt").write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
