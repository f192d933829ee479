"""What commands print and write: text or JSON, netCDF and figures, progress."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone import disk_cache
from gelcone.analyses.answer import answer_json, in_si, plain, write_results
from gelcone.analyses.ask import Answers
from gelcone.codes import Outcome
from gelcone.plots import plot

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.analyses.request import Subject
    from gelcone.atlas.record import Tally

BAR_SECONDS = 1.0
"""Time after which a bar on a terminal is drawn again, whether or not there is news."""
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
        with progress_lines(label) as report:
            yield report
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {elapsed}<{remaining}"
    bar = tqdm(total=1.0, desc=label, leave=False, bar_format=form, delay=0.5, smoothing=0.0)
    with bar, preparing(label, bar.set_description_str) as computing, ticking(bar.refresh, BAR_SECONDS):

        def report(share: float) -> None:
            computing()
            bar.update(share)

        yield report


@contextmanager
def progress_lines(label: str) -> Iterator[Callable[[float], None]]:
    """Takes shares of the work and reports every `LOG_SECONDS` how far it is, on the error stream."""
    begun, done, now = time.monotonic(), 0.0, label

    def name(text: str) -> None:
        nonlocal now
        now = text

    def say() -> None:
        spent = time.monotonic() - begun
        left = f", {spent * (1.0 / done - 1.0):.0f} s left" if 0.0 < done < 1.0 else ""
        click.echo(f"{now}: {100.0 * done:.0f} % after {spent:.0f} s{left}", err=True)

    with preparing(label, name) as computing, ticking(say, LOG_SECONDS):

        def report(share: float) -> None:
            nonlocal done
            computing()
            done += share

        yield report


@contextmanager
def preparing(label: str, name: Callable[[str], object]) -> Iterator[Callable[[], None]]:
    """Calls ``name`` with the label of a progress line while membranes are made or programs compiled, which takes
    seconds each and moves no progress. Yields a function that says that something is computed again."""
    films, making = 0, False

    def hear(kind: str) -> None:
        nonlocal films, making
        making = True
        films += kind == disk_cache.MEMBRANES
        name(f"{label}, making membrane {films}" if kind == disk_cache.MEMBRANES else f"{label}, compiling")

    def computing() -> None:
        nonlocal making
        if making:
            making = False
            name(label)

    with disk_cache.heard(hear):
        yield computing


@contextmanager
def ticking(say: Callable[[], object], seconds: float) -> Iterator[None]:
    """Calls ``say`` every so often during other work, however long that takes without a report of its own."""
    stop = threading.Event()

    def tick() -> None:
        while not stop.wait(seconds):
            say()

    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@contextmanager
def tally_shown(label: str) -> Iterator[Callable[[Tally], None]]:
    """How far a sweep is, on the error stream: a bar on a terminal, else a line now and then."""
    if not sys.stderr.isatty():
        begun = time.monotonic()
        known: deque[Tally] = deque(maxlen=1)

        def say() -> None:
            text = tally_text(known[-1]) if known else f"no cell yet after {time.monotonic() - begun:.0f} s"
            click.echo(f"{now[-1]}: {text}", err=True)

        now = deque([label], maxlen=1)
        with preparing(label, now.append) as computing, ticking(say, LOG_SECONDS):

            def keep(tally: Tally) -> None:
                computing()
                known.append(tally)

            yield keep
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n_fmt}/{total_fmt} cells [{elapsed}<{remaining}, {rate_fmt}{postfix}]"
    bar = tqdm(desc=label, leave=False, bar_format=form, unit="cells", delay=0.5, smoothing=0.0)
    with bar, preparing(label, bar.set_description_str) as computing, ticking(bar.refresh, BAR_SECONDS):

        def show(tally: Tally) -> None:
            computing()
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
