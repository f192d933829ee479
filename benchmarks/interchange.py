"""Checks of exported C and FMU: importer, compilers, sanitizers, bits in random runs, time of a step.

``python benchmarks/interchange.py [DEVICE ...]``: all shipped devices with the films that they name, or some; then the
films of the pump. Some minutes: compilers take most of it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from fmpy.validation import validate_fmu

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.export.sources import Exported

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.export.instance import STRICT, compiled
from tests.export.test_c import BITS, WRINKLING, same_bits

RUNS = 500
FILMS = {"taut": {"film": "taut"}, "wrinkling": WRINKLING, "membrane": {}}
TIMED = """
#include <stdio.h>
#include <math.h>
#include <time.h>
#include "pump.h"
int main(void) {
  pump device;
  int k;
  clock_t begin;
  pump_init(&device);
  for (k = 0; k < 22000; ++k) {
    if (k == 2000) begin = clock();
    pump_set(&device, PUMP_VOLTAGE, 700.0 + 600.0 * sin(6.283 * 0.01 * k));
    if (pump_step(&device, 1e-3)) return 1;
  }
  printf("%.3f\\n", 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC / 20000);
  return 0;
}
"""


def command(folder: Path, *words: str) -> str:
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else f"FAILED {done.stderr[:300]}"


def of_device(name: str, folder: Path) -> None:
    """Prints the importer's findings, and whether two compilers accept the source without a warning."""
    device, found = gelcone.find_device(name), []
    for version in (2, 3):
        (path,) = gelcone.export(device, folder / f"{version}.fmu", fmi=version, platforms=(), force=True)
        found.append(f"FMI {version}: {len(validate_fmu(str(path)))} problems")
    gelcone.export(device, folder / "pump", force=True)
    size = (folder / "pump" / "pump.c").stat().st_size
    for compiler in ("gcc", "clang"):
        made = command(folder / "pump", compiler, *STRICT, "-O0", "-c", "pump.c", "-o", f"{compiler}.o")
        found.append(f"{compiler}: {made or 'no warning'}")
    allocating = {"malloc", "calloc", "realloc", "free"} & set(command(folder / "pump", "nm", "-u", "gcc.o").split())
    print(f"{name}: {size / 1e6:.2f} MB of C, {', '.join(found)}, allocates by {allocating or 'nothing'}", flush=True)


def of_film(name: str, changes: dict[str, object], folder: Path) -> None:
    """Prints bits in random runs, sanitizers, time of a step."""
    device = gelcone.find_device("biased-pump").replace(changes)
    exported = Exported(device, "pump", False, 1e-7)
    begin = time.perf_counter()
    same, changed = same_bits(exported, compiled(exported, folder / "raw"), RUNS, seed=1)
    print(f"{name}: {same} of {RUNS} random runs with the same bits, {changed} changed their law", end="; ")
    gelcone.export(device, folder / "pump", force=True)
    own = folder / "pump"
    (own / "timed.c").write_text(TIMED)
    plain = ("-std=c99", "-O2", "-ffp-contract=off")
    strict = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    for program in ("test.c", "timed.c"):
        made = command(own, "gcc", *plain[::2], *strict, program, "pump.c", "-lm", "-o", "checked")
        print(f"{program} under sanitizers: {made or command(own, './checked')}", end="; ")
    for words, flags in (("plain", ()), ("fma", ("-mfma",))):
        made = command(own, "gcc", *plain, *flags, "timed.c", "pump.c", "-lm", "-o", "timed")
        best = made or min(command(own, "./timed") for _ in range(3))
        print(f"{words} {best} us a step of 1 ms", end="; ")
    print(f"({time.perf_counter() - begin:.0f} s)", flush=True)


def main() -> None:
    wanted = sys.argv[1:]
    with tempfile.TemporaryDirectory() as place:
        for name in wanted or sorted(shipped_devices()):
            of_device(name, Path(place))
        for name, changes in [] if wanted else FILMS.items():
            of_film(name, changes, Path(place, name))
        for name in () if wanted else ("creeping", "amplifier", "second film", "snap"):
            changes, sine, tolerance = BITS[name]
            exported = Exported(gelcone.find_device("biased-pump").replace(changes), "pump", sine, tolerance)
            same, _ = same_bits(exported, compiled(exported, Path(place, name.replace(" ", "-"))), RUNS, seed=1)
            print(f"{name}: {same} of {RUNS} random runs with the same bits", flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
