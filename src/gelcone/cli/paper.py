"""`gelcone paper`."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.options import json_parameter
from gelcone.cli.output import say
from gelcone.cli.waiting import BAR_SECONDS, ticking

if TYPE_CHECKING:
    from gelcone.paper.report import JudgedClaim
    from gelcone.paper.run import PaperRun

HELP = """Redraw the source paper's figures and check its claims; all of them, or those named.

Writes one self-contained report.html, the figures as PNG and SVG, and their data as netCDF. A run that was stopped
continues with what is missing.

\b
gelcone paper --quick
gelcone paper 7 voltage-threshold --out results
"""
MOST_PROCESSES = 4
"""More would compete for memory: each holds its own programs and data, and uses all cores where it can by itself."""


def paper_command() -> click.Command:
    """`gelcone paper`."""
    params: list[click.Parameter] = [
        click.Argument(["names"], nargs=-1, metavar="[FIGURE|CLAIM]..."),
        click.Option(["--quick"], is_flag=True, help="Coarser and shorter, a fraction of the work."),
        click.Option(
            ["--out"],
            type=click.Path(path_type=Path),
            metavar="DIR",
            help="Folder for report, figures and data.  [default: paper-results, with --quick paper-results-quick]",
        ),
        click.Option(["--force"], is_flag=True, help="Compute again what exists already."),
        json_parameter(),
    ]
    return click.Command("paper", params=params, callback=run_paper, help=HELP)


def run_paper(*, names: tuple[str, ...], quick: bool, out: Path | None, force: bool, as_json: bool) -> None:
    """Runs studies, figures and claims, and prints what came of them."""
    from gelcone.motion.flow import available_threads
    from gelcone.paper.run import run

    workers = min(available_threads(), MOST_PROCESSES)
    try:
        with progress_bar(hidden=as_json) as progress:
            result = run(names, quick=quick, out=out, force=force, workers=workers, progress=progress)
    except KeyboardInterrupt:
        print("interrupted; what is complete is saved, and the same command continues from there", file=sys.stderr)
        sys.exit(130)
    say("paper", as_json, report(result), summary(result))


@contextmanager
def progress_bar(hidden: bool) -> Iterator[Callable[[str, float], None]]:
    """A bar on a terminal that names what is being worked on and takes shares of the work; nothing when piped."""
    from tqdm import tqdm

    disable = True if hidden or not sys.stderr.isatty() else None
    form = "{bar:24}| {percentage:3.0f} % {elapsed}, {remaining} left: {desc}"
    bar = tqdm(total=1.0, disable=disable, leave=False, bar_format=form, smoothing=0.0)
    with bar, ticking(bar.refresh, BAR_SECONDS):

        def progress(label: str, share: float) -> None:
            bar.set_description_str(label, refresh=share == 0.0)
            bar.update(share)

        yield progress


def report(result: PaperRun) -> dict[str, Any]:
    """The JSON object."""
    from gelcone.paper.run import claim_record

    return {
        "claims": [claim_record(judged) for judged in result.claims],
        "figures": [
            {
                "number": drawn.figure.number,
                "png": str(drawn.png),
                "svg": str(drawn.svg),
                "data": [str(path) for path in drawn.data],
            }
            | ({"table": asdict(drawn.table)} if drawn.table else {})
            for drawn in result.figures
        ],
        "report": str(result.report),
        "effort": result.effort,
    }


def summary(result: PaperRun) -> str:
    """The text on the terminal: the table of claims, and where everything is."""
    lines = claim_table(result.claims) if result.claims else []
    for drawn in result.figures:
        lines += _in_columns([drawn.table.head, *drawn.table.rows]) if drawn.table else []
    numbers = [str(drawn.figure.number) for drawn in result.figures]
    lines.append(f"figure{'s' if len(numbers) > 1 else ''} {', '.join(numbers)} in {result.report.parent}")
    lines.append(f"wrote {result.report}")
    return "\n".join(lines)


def claim_table(claims: Sequence[JudgedClaim]) -> list[str]:
    """Claim, verdict, what becomes of it with other films, and key number with what it is: a line a claim, cut to the
    width of a terminal."""
    from gelcone.paper.report import films_of
    from gelcone.paper.verdicts import verdict_text

    films = films_of(claims)
    rows = [("claim", "verdict", *(heading.lower() for heading in films.values()), "key number", "which is")]
    rows += [
        (judged.claim.name, verdict_text(judged.finding), *(judged.with_film(film) for film in films), *_key(judged))
        for judged in claims
    ]
    return _in_columns(rows)


def _in_columns(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    lines = [
        "  ".join([f"{cell:{width}}" for cell, width in zip(row, widths, strict=False)] + [row[-1]]) for row in rows
    ]
    return [_cut(line.rstrip()) for line in lines]


def _key(judged: JudgedClaim) -> tuple[str, str]:
    numbers = judged.finding.numbers
    return (str(numbers[0]), numbers[0].meaning) if numbers else ("", "")


def _cut(line: str) -> str:
    width = shutil.get_terminal_size().columns
    return line if len(line) <= width or not sys.stdout.isatty() else f"{line[: width - 1]}…"
