"""Is the paper's report the same to the byte on another processor? The quick run with and without AVX-512.

    python benchmarks/instruction_sets.py [FOLDER]

Runs ``gelcone paper --quick`` three times, each in fresh processes with an empty cache: as this machine does it, again,
and as a Haswell would (code compiled for it; NumPy and its linear algebra kept from everything newer). Every file of
the three folders (data, pictures, claims, report) is compared byte for byte. It exits with 1 when one differs.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HASWELL = """
import llvmlite.binding

llvmlite.binding.get_host_cpu_name = lambda: "haswell"
llvmlite.binding.get_host_cpu_features = dict
"""
"""A module that every Python process imports at its start, also those that a process starts."""
OLDER = {
    "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
}


def run(folder: Path, out: str, older: bool) -> dict[str, str]:
    """The quick run's files with their digests."""
    starts = folder / f"starts-{out}"
    starts.mkdir(parents=True)
    paths = [str(Path(__file__).parents[1] / "src")]
    if older:
        (starts / "sitecustomize.py").write_text(HASWELL)
        paths.insert(0, str(starts))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths), "GELCONE_CACHE": str(starts / "cache")}
    command = [sys.executable, "-m", "gelcone", "paper", "--quick", "--out", out]
    subprocess.run(command, cwd=folder, env=environment | (OLDER if older else {}), check=True)
    files = sorted(path for path in (folder / out).rglob("*") if path.is_file())
    return {str(path.relative_to(folder / out)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def main(folder: Path) -> int:
    first, again, haswell = run(folder, "first", False), run(folder, "again", False), run(folder, "haswell", True)
    failed = 0
    for name, other in (("a second run", again), ("code for a Haswell", haswell)):
        different = sorted(path for path in first.keys() | other.keys() if first.get(path) != other.get(path))
        failed += bool(different)
        print(f"{name}: {len(first)} files, {len(different)} differ {' '.join(different)}".rstrip())
    return int(failed > 0)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        sys.exit(main(Path(sys.argv[1]).resolve()))
    with tempfile.TemporaryDirectory() as temporary:
        sys.exit(main(Path(temporary)))
