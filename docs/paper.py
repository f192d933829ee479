"""Two figures and the claim table of `docs/claims.md`, from a run of `gelcone paper`.

python docs/paper.py FOLDER      (a folder that `gelcone paper --quick --out FOLDER` has filled)

Writes docs/figure-07.png, docs/figure-14.png and the table between the marks in docs/claims.md. Its last column is how
often a verdict came out the same from other starts, by docs/verdicts.csv of `python benchmarks/intervals.py verdicts`.
"""

from __future__ import annotations

import csv
import json
import sys
from datetime import UTC, datetime
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
FIGURES = ("figure-07", "figure-14")
WIDTH = 760
HEAD = "| claim | verdict | if the film wrinkles | with the membrane | key number | same verdict |"
BEGIN, END = "<!-- claims: written by docs/paper.py -->", "<!-- end of claims -->"


def number(entry: dict[str, object]) -> str:
    """The key number of a claim with its error or interval, and what it is."""
    if not entry["numbers"]:
        return ""
    first = entry["numbers"][0]  # type: ignore[index]
    return f"{first['text']}: {first['meaning']}"


def with_film(entry: dict[str, object], film: str) -> str:
    """What becomes of a claim with another film; empty if it was not judged with it."""
    found: list[dict[str, str]] = entry["with_films"]  # type: ignore[assignment]
    return next((one["text"] for one in found if one["film"] == film), "")


def table(run: dict[str, object]) -> str:
    """The claim table in Markdown, with the date and version that produced it."""
    same = agreeing(run)
    rows = [
        f"| {c['id']} | {c['text']} | {with_film(c, 'wrinkling')} | {with_film(c, 'membrane')} | {number(c)} "
        f"| {same[c['id']]} |"
        for c in run["claims"]  # type: ignore[attr-defined]
    ]
    made = f"Made on {datetime.now(UTC):%Y-%m-%d} by gelcone {run['version']}, {run['effort']} run."
    return "\n".join([BEGIN, "", made, "", HEAD, "|---|---|---|---|---|---|", *rows, "", END])


def agreeing(run: dict[str, object]) -> dict[str, str]:
    """Of how many judgements from starts 1e-12 to 1e-9 apart so many gave the verdict of this run, by claim."""
    with (ROOT / "docs" / "verdicts.csv").open(encoding="utf-8", newline="") as file:
        seen = list(csv.DictReader(file))
    claims: list[dict[str, str]] = run["claims"]  # type: ignore[assignment]
    return {c["id"]: f"{sum(one[c['id']] == c['verdict'] for one in seen)} of {len(seen)}" for c in claims}


def main(folder: Path) -> None:
    page = ROOT / "docs" / "claims.md"
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    run = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    page.write_text(before + table(run) + after, encoding="utf-8")
    for name in FIGURES:
        with Image.open(folder / f"{name}.png") as picture:
            size = (WIDTH, round(picture.height * WIDTH / picture.width))
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
            # the palette covers rare colours too: median cut, the default, turns the few blue pixels grey
            palette = small.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            palette.save(ROOT / "docs" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
