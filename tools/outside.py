"""Build the wheel and the sdist, and use the wheel as a stranger does: in a fresh environment, outside of a clone.

    python tools/outside.py [--extras studio] [--keep FOLDER]

The wheel is made from the sdist. Checked are the metadata (twine), that the files it must hold are there, the version,
the first commands of the README, and its Python block. It takes ``pip install build twine``; ``--keep`` leaves both
files.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HELD = (
    "gelcone/py.typed",
    "gelcone/presets.toml",
    "gelcone/devices/materials.toml",
    "gelcone/devices/shipped/biased-pump.toml",
    "gelcone/studio/static/main.js",
    "gelcone/export/templates/core.c",
    "licenses/LICENSE",
)
"""Endings of files that the wheel must hold."""
COMMANDS = (
    ("--version",),
    ("init", "mine.toml"),
    ("simulate", "mine.toml", "--film", "wrinkling", "--periods", "5", "--out", "results"),
    ("static", "biased-pump", "--film", "wrinkling", "--over", "constant_voltage=0.5 kV", "--json"),
)


def run(*command: str | Path, folder: str | Path) -> str:
    """Run a command outside of the clone; its output, or an error with it."""
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run([*map(str, command)], cwd=folder, env=clean, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def built(folder: Path) -> Path:
    """The wheel, from the sdist, both checked."""
    run(sys.executable, "-m", "build", "--outdir", folder, ROOT, folder=folder)
    run(sys.executable, "-m", "twine", "check", "--strict", *folder.glob("gelcone-*"), folder=folder)
    (wheel,) = folder.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    for ending in HELD:
        assert any(name.endswith(ending) for name in names), f"the wheel lacks {ending}"
    assert not [name for name in names if "test" in name.lower().split("/")], "the wheel holds tests"
    return wheel


def main() -> None:
    """Build, install, use."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--extras", default="", help="extras to install, separated by commas")
    parser.add_argument("--keep", type=Path, help="folder for wheel and sdist")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = given.keep.resolve() if given.keep else Path(place, "dist")
        folder.mkdir(parents=True, exist_ok=True)
        wheel = built(folder)
        home, away = Path(place, "venv"), Path(place, "away")
        away.mkdir()
        venv.create(home, with_pip=True)
        binaries = home / ("Scripts" if os.name == "nt" else "bin")
        python = binaries / ("python.exe" if os.name == "nt" else "python")
        run(python, "-m", "pip", "install", "-q", f"{wheel}[{given.extras}]" if given.extras else wheel, folder=away)
        where = run(python, "-c", "import gelcone; print(gelcone.__file__)", folder=away)
        assert str(ROOT) not in where, where
        for command in COMMANDS:
            print("gelcone", *command, "->", len(run(python, "-m", "gelcone", *command, folder=away)), "characters")
        assert (away / "results" / "simulate.png").stat().st_size > 10_000
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        (block,) = re.findall(r"```python\n(>>>.*?)```", readme, flags=re.DOTALL)
        (away / "readme.txt").write_text(block, encoding="utf-8")
        run(python, "-m", "doctest", "readme.txt", folder=away)
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB, used outside of the clone")


if __name__ == "__main__":
    main()
