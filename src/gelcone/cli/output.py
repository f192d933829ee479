"""The output of commands: text or JSON, netCDF and figures, progress."""

from __future__ import annotations

import json
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
import numpy as np

from gelcone.analyses.answer import answer_json, bare_answer, in_si, plain, result_paths, write_results
from gelcone.analyses.ask import Answers
from gelcone.cli.waiting import BAR_SECONDS, STORED, logging, preparing, ticking, warned
from gelcone.codes import Outcome
from gelcone.dataset import save
from gelcone.files import check_writable, write_together
from gelcone.netcdf import write_netcdf
from gelcone.plots import plot, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.analyses.request import Subject
    from gelcone.atlas.record import Tally


def deliver(
    answers: Answers,
    result: xr.Dataset,
    subject: Subject,
    out: Path | None,
    force: bool,
    as_json: bool,
    draw: Callable[..., Figure] = plot,
) -> int:
    """Deliver a result: in SI units for a device, as NAME.nc and NAME.png for --out, as JSON or text.

    Returns the exit code: 1 where there were runs and every one failed.
    """
    outcomes = result["outcome"].values if "outcome" in result else np.zeros(0)
    code = int(outcomes.size > 0 and bool((outcomes != Outcome.OK).all()))
    shown = in_si(result, subject)
    paths = () if out is None else _write(out, answers.command, shown, draw, force)
    if as_json:
        print_json(answer_json(answers.command, answers.json(shown), shown, subject))
        return code
    click.echo(answers.words(shown, subject))
    for path in paths:
        click.echo(f"wrote {path}")
    return code


def _write(out: Path, name: str, shown: xr.Dataset, draw: Callable[..., Figure], force: bool) -> tuple[Path, Path]:
    """Writes result and figure; a figure that fails does not cost the result of a long run."""
    try:
        figure = draw(shown)
    except Exception:
        save(shown, result_paths(out, name)[0], force=force)
        raise
    return write_results(out, name, shown, figure, force)


def result_files(name: str, result: xr.Dataset) -> dict[str, Callable[[Path], object]]:
    """The files NAME.nc and NAME.png of a result, and what writes them."""
    return {
        f"{name}.nc": partial(write_netcdf, result),
        f"{name}.png": lambda path: style.draw_file(plot(result), path),
    }


def say(command: str, as_json: bool, content: Any, words: str) -> None:
    """Prints what a command that does not run a model has to say, as JSON or text."""
    if as_json:
        print_json(bare_answer(command, content))
    else:
        click.echo(words)


def print_json(content: dict[str, Any]) -> None:
    """Prints one JSON object, with the warnings until now. Numbers that are not finite are null or in words; infinite
    parameters are "inf"."""
    click.echo(json.dumps(plain(content | {"warnings": warned()}), allow_nan=False))


class Output(NamedTuple):
    """The destination of a result: the folder of ``--out``, whether files are overwritten, and whether JSON is
    printed."""

    command: str
    out: Path | None
    force: bool
    as_json: bool

    def check(self, names: Iterable[str]) -> None:
        """Refuses files of these names that exist or cannot be written."""
        if self.out is not None:
            check_writable([self.out / name for name in names], force=self.force)

    def deliver(self, words: str, content: Any, writers: Mapping[str, Callable[[Path], object]]) -> None:
        """Writes the files of these names, and prints text or JSON."""
        files = {} if self.out is None else {self.out / name: write for name, write in writers.items()}
        write_together(files, force=self.force)
        say(self.command, self.as_json, content, "\n".join([words, *(f"wrote {path}" for path in files)]))


ESTIMATED = 0.1
"""Share of the work from which on the time left is estimated: the first steps are often the slowest."""


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Takes shares of the work; a bar on a terminal, else a line on the error stream now and then."""
    if not sys.stderr.isatty():
        with progress_lines(label) as report:
            yield report
        return
    from tqdm import tqdm

    bar = tqdm(total=1.0, desc=label, leave=False, bar_format="{l_bar}{bar}| {elapsed}", delay=0.5, smoothing=0.0)
    with bar, preparing(label, bar.set_description_str), ticking(bar.refresh, BAR_SECONDS):

        def report(share: float) -> None:
            bar.update(share)
            if bar.n >= ESTIMATED:
                bar.bar_format = "{l_bar}{bar}| {elapsed}<{remaining}"

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
        share, left = f"{100.0 * done:.0f} % after {spent:.0f} s", ""
        if now != label:  # what is made moves no share, and says nothing about the time left
            share = f"{STORED}; {share}"
        elif ESTIMATED <= done < 1.0:
            left = f", {spent * (1.0 / done - 1.0):.0f} s left"
        click.echo(f"{now}: {share}{left}", err=True)

    with preparing(label, name), logging(say):

        def report(share: float) -> None:
            nonlocal done
            done += share

        yield report


@contextmanager
def tally_shown(label: str) -> Iterator[Callable[[Tally], None]]:
    """Show the progress of a sweep on the error stream: a bar on a terminal, else a line now and then."""
    if not sys.stderr.isatty():
        begun = time.monotonic()
        known: deque[Tally] = deque(maxlen=1)

        def say() -> None:
            text = tally_text(known[-1]) if known else f"no cell yet after {time.monotonic() - begun:.0f} s"
            click.echo(f"{now[-1]}: {text}", err=True)

        now = deque([label], maxlen=1)
        with preparing(label, now.append), logging(say):
            yield known.append
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n_fmt}/{total_fmt} cells [{elapsed}<{remaining}, {rate_fmt}{postfix}]"
    bar = tqdm(desc=label, leave=False, bar_format=form, unit="cells", delay=0.5, smoothing=0.0)
    with bar, preparing(label, bar.set_description_str), ticking(bar.refresh, BAR_SECONDS):

        def show(tally: Tally) -> None:
            bar.total, bar.n, bar.initial = tally.asked, tally.computed, tally.found
            bar.set_postfix_str(_chaotic(tally), refresh=False)
            bar.refresh()

        yield show


def tally_text(tally: Tally) -> str:
    """The progress of a run, in one line; the rate is that of the cells computed in this run."""
    done = tally.computed - tally.found
    rate = done / tally.seconds if tally.seconds > 0.0 else 0.0
    left = f", {(tally.asked - tally.computed) / rate:.0f} s left" if rate else ""
    parts = (f"{tally.computed} of {tally.asked} cells, {rate:.3g} a second{left}", _chaotic(tally))
    return ", ".join(filter(None, parts))


def _chaotic(tally: Tally) -> str:
    """The share of chaotic cells; empty where the analysis does not ask for it."""
    if tally.chaotic is None:
        return ""
    return f"{100.0 * tally.chaotic / max(tally.computed, 1):.3g} % chaotic"
