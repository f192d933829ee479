"""Prints which share of the lines the tests ran, a line for each folder of the package.

pytest --cov --cov-report= && python tools/coverage_by_folder.py
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any


def by_folder(report: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Folder below the package -> lines that ran, and all; from what ``coverage json`` writes."""
    counted: dict[str, tuple[int, int]] = defaultdict(lambda: (0, 0))
    for name, file in report["files"].items():
        parts = PurePath(name.replace("\\", "/")).parts
        inside = parts[parts.index("gelcone") + 1 :]
        folder = inside[0] + "/" if len(inside) > 1 else "."
        ran, lines = counted[folder]
        summary = file["summary"]
        counted[folder] = ran + summary["covered_lines"], lines + summary["num_statements"]
    return dict(sorted(counted.items()))


def table(counted: Mapping[str, tuple[int, int]]) -> str:
    """The shares as text, the whole last."""
    whole = {"all": (sum(ran for ran, _ in counted.values()), sum(lines for _, lines in counted.values()))}
    rows = {**counted, **whole}
    return "\n".join(
        f"{folder:12s} {100 * ran / max(lines, 1):5.1f} % of {lines:5d} lines" for folder, (ran, lines) in rows.items()
    )


def main() -> int:
    """Reads the data that pytest left in this folder; 1 where there is none."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "coverage.json"
        done = subprocess.run([sys.executable, "-m", "coverage", "json", "-q", "-o", path], check=False)
        if done.returncode:
            return 1
        print("lines run by the tests")
        print(table(by_folder(json.loads(path.read_text(encoding="utf-8")))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
