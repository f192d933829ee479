"""Figures and tables of `docs/claims.md`, from a run of `gelcone paper`.

python docs/paper.py FOLDER      (a folder that `gelcone paper --out FOLDER` has filled)

Writes docs/figure-07.png, docs/figure-14.png, docs/end-of-chaos.png and the tables between the marks in docs/claims.md,
each where the folder holds it. A film that no claim was judged with has no column: that of the film that creeps comes
with a run without --quick. The last column of the claims is how often a verdict came out the same from other starts, by
docs/verdicts.csv of `python benchmarks/intervals.py verdicts`.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
FIGURES = ("figure-07", "figure-14", "end-of-chaos")
WIDTH = 760
FILMS = {
    "wrinkling": "if the film wrinkles",
    "membrane": "with the membrane",
    "creeping": "if it also creeps, behind 1 MOhm",
}
CLAIMS = "<!-- claims: written by docs/paper.py -->", "<!-- end of claims -->"
CHAOS = "<!-- end of chaos: written by docs/paper.py -->", "<!-- end of that -->"


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


def claim_table(run: dict[str, object]) -> str:
    """The claim table in Markdown, with a column for each film that a claim was judged with."""
    same = agreeing(run)
    claims: list[dict[str, object]] = run["claims"]  # type: ignore[assignment]
    films = [film for film in FILMS if any(with_film(claim, film) for claim in claims)]
    head = ("claim", "verdict", *(FILMS[film] for film in films), "key number", "same verdict")
    rows = [
        (c["id"], c["text"], *(with_film(c, film) for film in films), number(c), same[str(c["id"])]) for c in claims
    ]
    return markdown(run, head, rows)


def markdown(run: dict[str, object], head: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown, with the date and version that produced it."""
    made = f"Made on {datetime.now(UTC):%Y-%m-%d} by gelcone {run['version']}, {run['effort']} run."
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (head, *rows)]
    return "\n".join([made, "", lines[0], "|---" * len(head) + "|", *lines[1:]])


def put(text: str, marks: tuple[str, str], table: str) -> str:
    """The page with another table between two marks."""
    before, rest = text.split(marks[0])
    return f"{before}{marks[0]}\n\n{table}\n\n{marks[1]}{rest.split(marks[1])[1]}"


def agreeing(run: dict[str, object]) -> dict[str, str]:
    """Of how many judgements from starts 1e-12 to 1e-9 apart so many gave the verdict of this run, by claim."""
    with (ROOT / "docs" / "verdicts.csv").open(encoding="utf-8", newline="") as file:
        seen = list(csv.DictReader(file))
    claims: list[dict[str, str]] = run["claims"]  # type: ignore[assignment]
    return {c["id"]: f"{sum(one[c['id']] == c['verdict'] for one in seen)} of {len(seen)}" for c in claims}


def main(folder: Path) -> None:
    page = ROOT / "docs" / "claims.md"
    text = page.read_text(encoding="utf-8")
    run = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    if run["claims"]:
        text = put(text, CLAIMS, claim_table(run))
    if "end-of-chaos" in run.get("tables", {}):
        found = run["tables"]["end-of-chaos"]
        text = put(text, CHAOS, markdown(run, found["head"], found["rows"]))
    page.write_text(text, encoding="utf-8")
    for name in (name for name in FIGURES if (folder / f"{name}.png").exists()):
        with Image.open(folder / f"{name}.png") as picture:
            size = (WIDTH, round(picture.height * WIDTH / picture.width))
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
            # the palette covers rare colours too: median cut, the default, turns the few blue pixels grey
            palette = small.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            palette.save(ROOT / "docs" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
