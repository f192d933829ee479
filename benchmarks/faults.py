"""Robustness of stores: a map that is killed and resumed again and again ends with the same bytes as an undisturbed
one.

    python benchmarks/faults.py [KILLS]      (default 20)

A map runs in a process of its own, once undisturbed, and then with KILLS times SIGKILL, after each of which it is
resumed. The moments are random shares of the time that the undisturbed run computed; the first kill falls into the
making of the store, and every second one waits for the next write and falls into that. All files of both stores are
compared byte by byte.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import zarr

COMMAND = [sys.executable, "-c", "from gelcone.cli import main; main()", "map"]
MAP = [
    *("--set", "damping_ratio=0.05", "--set", "spring_stiffness=0.5", "--set", "drive_frequency=0.3"),
    *("--over", "voltage=0:2:96", "--over", "prestretch=0.4:2:80", "--coarsest", "16"),
    *("--transient", "300", "--budget", "1500"),
]
FIELDS = ("averaged_time", "status")
"""What a store writes first and last of each tile, by name."""


def start(*arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def written(store: Path) -> list[int]:
    """Times of the last writes of the first and the last of a tile's fields, 0 if they do not exist.

    Not what is only half written: that gets its name, and so loses its own, at any moment.
    """
    whole = [[p for p in store.glob(f"{name}/c/*/*") if p.suffix != ".partial"] for name in FIELDS]
    return [max((p.stat().st_mtime_ns for p in files), default=0) for files in whole]


def cells(store: Path) -> int:
    """Cells that the store holds."""
    return int((zarr.open_array(store / "status", mode="r")[...] > 0).sum()) if written(store)[1] else 0


def wait(process: subprocess.Popen[bytes], until: float, store: Path, writing: bool) -> None:
    """Waits for a moment, and from there on for the beginning of a write."""
    while time.monotonic() < until and process.poll() is None:
        time.sleep(0.001)
    before = written(store)
    while writing and process.poll() is None and written(store)[0] == before[0]:
        time.sleep(0.0005)


def run_alone(store: Path) -> tuple[float, float]:
    """Seconds until the store is made, and from there to the end."""
    begun = time.monotonic()
    process = start(*MAP, "--store", str(store))
    while not (store / "zarr.json").exists() and process.poll() is None:
        time.sleep(0.005)
    made = time.monotonic()
    if process.wait():
        raise SystemExit("the undisturbed run failed")
    return made - begun, time.monotonic() - made


def main(kills: int, folder: Path) -> int:
    alone, store = folder / "alone.zarr", folder / "killed.zarr"
    starting, computing = run_alone(alone)
    print(f"undisturbed: {cells(alone)} cells, {starting:.1f} s to start, {computing:.1f} s to compute", flush=True)
    rng = np.random.default_rng(2026)
    legs = np.diff(np.sort(rng.random(kills)), prepend=0.0) * computing
    print("kill  after (s)  cells kept  fell into")
    for kill, leg in enumerate(legs):
        made, before = (store / "zarr.json").exists(), written(store)
        begun = time.monotonic()
        process = start("--resume", str(store)) if made else start(*MAP, "--store", str(store))
        if kill == 0:
            while not (store / "status").exists() and process.poll() is None:
                time.sleep(0.0005)
        else:
            wait(process, begun + starting + leg, store, writing=kill % 2 == 1)
            time.sleep(rng.uniform(0.0, 0.03) if kill % 2 else 0.0)
        process.kill()
        ended = process.wait() == 0
        first, last = written(store)
        writing = before[0] < first > last or any(store.rglob("*.partial"))
        where = "the making of the store" if kill == 0 else "a write" if writing else "the computation"
        where = "nothing: it had ended" if ended else where
        print(f"{kill + 1:4d} {time.monotonic() - begun:10.2f} {cells(store):11d}  {where}", flush=True)
    if start("--resume", str(store)).wait():
        raise SystemExit("the last run failed")
    one, other = ({p.relative_to(s): p.read_bytes() for p in s.rglob("*") if p.is_file()} for s in (alone, store))
    different = sorted(str(name) for name in one.keys() | other.keys() if one.get(name) != other.get(name))
    size = sum(map(len, one.values()))
    print(f"{kills} kills; {len(one)} files of {size:,} bytes, {len(different)} of them different {different[:5]}")
    return int(bool(different))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 20, Path(place)))
