"""Runs the tests with the lowest versions that pyproject.toml allows, in a virtual environment of its own.

    python tools/lower_bounds.py                       # the quick tests
    python tools/lower_bounds.py tests/motion -x       # what pytest is given instead
    python tools/lower_bounds.py --pins                # print the versions and stop

The lower bound of every direct dependency is pinned; what these need in turn is left to pip. Installing takes a minute
or two. Choose bounds that have wheels for the oldest Python that is supported.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXTRAS = ("cluster", "fem", "test")
"""Extras that are installed and pinned too; those of the benchmarks are not."""
REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9_.-]+)(\[[^]]*\])?\s*>=\s*(?P<lowest>[0-9.]+)")
OLD = tuple(f"-Wignore::{kind}Warning" for kind in ("Deprecation", "PendingDeprecation", "Future"))
"""Old packages use what newer ones announce to remove; here that is no error, as it is elsewhere."""
QUICK = ("-m", "not slow", "tests", "-x")


def pins(text: str) -> dict[str, str]:
    """Package -> lowest version that a pyproject.toml allows; `ValueError` for a requirement without lower bound."""
    project = tomllib.loads(text)["project"]
    required = [*project["dependencies"], *(r for extra in EXTRAS for r in project["optional-dependencies"][extra])]
    lowest: dict[str, str] = {}
    for requirement in required:
        found = REQUIREMENT.match(requirement)
        if found is None:
            raise ValueError(f"{requirement}: has no lower bound; write NAME>=VERSION")
        name, version = found["name"].lower(), found["lowest"]
        if lowest.setdefault(name, version) != version:
            raise ValueError(f"{name}: has two lower bounds, {lowest[name]} and {version}; write one")
    return lowest


def main(arguments: list[str]) -> int:
    """Installs, tests, and returns pytest's exit code."""
    lines = [f"{name}=={version}" for name, version in pins((ROOT / "pyproject.toml").read_text("utf-8")).items()]
    if arguments == ["--pins"]:
        print(*lines, sep="\n")
        return 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "lowest.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        venv.create(folder / "venv", with_pip=True)
        python = folder / "venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
        package = f"{ROOT}[{','.join(EXTRAS)}]"
        install = [python, "-m", "pip", "install", "--quiet", "--constraint", folder / "lowest.txt", "-e", package]
        subprocess.run(install, check=True)
        return subprocess.run([python, "-m", "pytest", *OLD, *(arguments or QUICK)], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
