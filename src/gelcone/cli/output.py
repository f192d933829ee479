"""What commands print and write: text or JSON, netCDF and figures, progress."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.analyses.answer import answer_json, in_si, plain, write_results
from gelcone.analyses.ask import Answers
from gelcone.codes import Outcome
from gelcone.plots import plot

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.analyses.request import Subject
    from gelcone.atlas.record import Tally

LOG_SECONDS = 20.0
"""Time between two lines about a run that is not watched on a terminal."""


def deliver(
    answers: Answers,
    result: xr.Dataset,
    subject: Subject,
    out: Path | None,
    force: bool,
    as_json: bool,
    draw: Callable[..., Figure] = plot,
) -> int:
    """What every command does with its result: SI units for a device, NAME.nc and NAME.png for --out, JSON or text.

    Returns the exit code: 1 when every run failed.
    """
    code = int("outcome" in result and bool((result["outcome"].values != Outcome.OK).all()))
    shown = in_si(result, subject)
    paths = () if out is None else write_results(out, answers.command, shown, draw(shown), force)
    if as_json:
        print_json(answer_json(answers.command, answers.json(shown), shown, subject))
        return code
    click.echo(answers.words(shown, subject))
    for path in paths:
        click.echo(f"wrote {path}")
    return code


def print_json(content: dict[str, Any]) -> None:
    """One JSON object; what is not a finite number becomes null, an infinite parameter the string "inf"."""
    click.echo(json.dumps(plain(content), allow_nan=False))


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Takes shares of the work; a bar on a terminal, else a line on the error stream now and then."""
    if not sys.stderr.isatty():
        yield progress_lines(label)
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=label, leave=False, bar_format=form, delay=0.5) as bar:
        yield lambda share: bar.update(share)


def progress_lines(label: str) -> Callable[[float], None]:
    """Takes shares of the work and says every `LOG_SECONDS` how far it is, on the error stream."""
    begun = said = time.monotonic()
    done = 0.0

    def say(share: float) -> None:
        nonlocal said, done
        done += share
        now = time.monotonic()
        if now - said > LOG_SECONDS:
            said = now
            left = f", {(now - begun) * (1.0 / done - 1.0):.0f} s left" if done else ""
            click.echo(f"{label}: {100.0 * done:.0f} % after {now - begun:.0f} s{left}", err=True)

    return say


@contextmanager
def tally_shown(label: str) -> Iterator[Callable[[Tally], None]]:
    """How far a sweep is, on the error stream: a bar on a terminal, else a line now and then."""
    if not sys.stderr.isatty():
        said = time.monotonic()

        def say(tally: Tally) -> None:
            nonlocal said
            if time.monotonic() - said > LOG_SECONDS:
                said = time.monotonic()
                click.echo(f"{label}: {tally_text(tally)}", err=True)

        yield say
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n_fmt}/{total_fmt} cells [{elapsed}<{remaining}, {rate_fmt}{postfix}]"
    with tqdm(desc=label, leave=False, bar_format=form, unit="cells", delay=0.5) as bar:

        def show(tally: Tally) -> None:
            bar.total, bar.n, bar.initial = tally.asked, tally.computed, tally.found
            bar.set_postfix_str(_chaotic(tally), refresh=False)
            bar.refresh()

        yield show


def tally_text(tally: Tally) -> str:
    """How far a run is, in one line; the rate is that of the cells computed in this run."""
    done = tally.computed - tally.found
    rate = done / tally.seconds if tally.seconds > 0.0 else 0.0
    left = f", {(tally.asked - tally.computed) / rate:.0f} s left" if rate else ""
    return f"{tally.computed} of {tally.asked} cells, {rate:.3g} a second{left}, {_chaotic(tally)}"


def _chaotic(tally: Tally) -> str:
    return f"{100.0 * tally.chaotic / max(tally.computed, 1):.3g} % chaotic"
