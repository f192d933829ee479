"""The README's two figures and claim table of the source paper, from a run of `gelcone paper`.

python docs/paper.py FOLDER      (a folder that `gelcone paper --quick --out FOLDER` has filled)

Writes docs/figure-07.png and docs/figure-14.png, and the table between the marks in README.md.
"""

from __future__ import annotations

import json
import sys
from datetime import UTC, datetime
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
FIGURES = ("figure-07", "figure-14")
WIDTH = 760
HEAD = "| claim | verdict | if the film wrinkles | key number |"
BEGIN, END = "<!-- claims: written by docs/paper.py -->", "<!-- end of claims -->"


def number(entry: dict[str, object]) -> str:
    """The key number of a claim with its error or interval, and what it is."""
    if not entry["numbers"]:
        return ""
    first = entry["numbers"][0]  # type: ignore[index]
    return f"{first['text']}: {first['meaning']}"


def table(run: dict[str, object]) -> str:
    """The claim table in Markdown, with the date and version that produced it."""
    rows = [
        f"| {c['id']} | {c['verdict']} | {c['with_film']['text'] if c['with_film'] else ''} | {number(c)} |"
        for c in run["claims"]  # type: ignore[attr-defined]
    ]
    made = f"Made on {datetime.now(UTC):%Y-%m-%d} by gelcone {run['version']}, {run['effort']} run."
    return "\n".join([BEGIN, "", made, "", HEAD, "|---|---|---|---|", *rows, "", END])


def main(folder: Path) -> None:
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    run = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    readme.write_text(before + table(run) + after, encoding="utf-8")
    for name in FIGURES:
        with Image.open(folder / f"{name}.png") as picture:
            size = (WIDTH, round(picture.height * WIDTH / picture.width))
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
            # the palette covers rare colours too: median cut, the default, turns the few blue pixels grey
            palette = small.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            palette.save(ROOT / "docs" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
