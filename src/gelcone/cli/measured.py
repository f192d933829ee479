"""`gelcone measured`: measured devices against what gelcone predicts of them."""

from __future__ import annotations

from pathlib import Path

import click

from gelcone.cli.options import PLACE
from gelcone.cli.output import progress_bar, say


def measured_command() -> click.Command:
    """`gelcone measured`."""
    text = """Compare measured devices with what gelcone predicts of them.

    A page is a TOML file: what a source states of a device, each number with its value, unit, sentence and kind
    (stated, derived, digitised or assumed), and what was measured. Uncertain numbers are drawn; printed are prediction,
    95 % interval, measured value, and whether it is inside. What rests on assumed numbers by more than half of its
    variance is not compared, and a page that cannot be simulated says what is missing.

    \b
    gelcone measured docs/measured/vhb.toml
    gelcone measured docs/measured/cao-2018.toml --json
    """
    params: list[click.Parameter] = [
        click.Argument(["pages"], nargs=-1, required=True, type=PLACE, metavar="PAGE..."),
        click.Option(["--seed"], type=click.IntRange(0, 2**31), default=0, show_default=True, help="Of the draws."),
        click.Option(["--json", "as_json"], is_flag=True, help="One JSON object on standard output."),
    ]
    return click.Command("measured", params=params, callback=run_measured, help=text)


def run_measured(*, pages: tuple[Path, ...], seed: int, as_json: bool) -> int:
    """Compares and prints each page; 1 where something is outside its interval."""
    from gelcone.lab.page import compare_measured, page_words

    compared_pages = []
    for page_path in pages:
        with progress_bar("measured") as progress:
            compared_pages.append(compare_measured(page_path, seed=seed, progress=progress))
    listed = [
        page._asdict() | {"compared": [comparison._asdict() for comparison in page.compared]} for page in compared_pages
    ]
    say("measured", as_json, {"pages": listed}, "\n".join(map(page_words, compared_pages)))
    return int(any(comparison.verdict.startswith("outside") for page in compared_pages for comparison in page.compared))
