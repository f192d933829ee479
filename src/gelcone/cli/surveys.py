"""What the commands that compute many cells share: who computes, where results are kept, and how far it is."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gelcone.cli.options import FILM, PRESET
from gelcone.errors import InputError

if TYPE_CHECKING:
    from gelcone.atlas.record import Tally
    from gelcone.atlas.workers import Workers

F = TypeVar("F", bound=Callable[..., Any])
LOG_SECONDS = 20.0
"""Between two lines about a run that is not watched on a terminal."""
_BESIDE_THE_SWEEP = {"store", "resume", "threads", "workers", "scheduler", "out", "force", "as_json"}


def survey_options(function: F) -> F:
    """--store, --resume, --threads, --workers and --scheduler."""
    for decorate in (
        click.option("--scheduler", metavar="ADDRESS", help="Use the dask cluster whose scheduler is there."),
        click.option("--workers", type=int, metavar="N", help="Start so many processes (needs the extra 'cluster')."),
        click.option("--threads", type=int, metavar="N", help="Threads of this process. [default: one a core]"),
        click.option(
            "--resume",
            type=click.Path(path_type=Path),
            metavar="STORE",
            help="Go on with what a store holds; without other arguments its own plan is taken.",
        ),
        click.option(
            "--store",
            type=click.Path(path_type=Path),
            metavar="STORE",
            help="Keep results there while they come (Zarr); an interrupted run can be resumed.",
        ),
    ):
        function = decorate(function)
    return function


def read_workers(threads: int | None, workers: int | None, scheduler: str | None) -> Workers:
    """Who computes."""
    from gelcone.atlas import workers as kinds

    if sum(option is not None for option in (threads, workers, scheduler)) > 1:
        raise InputError("--threads, --workers and --scheduler: give one of them")
    if workers is None and scheduler is None:
        return kinds.threads(threads)
    return kinds.cluster(workers, scheduler)


def from_store(resume: Path, given: object) -> bool:
    """Whether the sweep is the store's own, as the command line describes none; `InputError` for a part of one."""
    from click.core import ParameterSource

    context = click.get_current_context()
    typed = {name for name in context.params if context.get_parameter_source(name) != ParameterSource.DEFAULT}
    if typed <= _BESIDE_THE_SWEEP and not context.meta.keys() & {PRESET, FILM}:
        return True
    if not given:
        raise InputError(
            f"--resume {resume}: give it alone, and the store's own sweep is taken, or with all of the sweep "
            "(device, --set, --over), and it is compared"
        )
    return False


def one_store(store: Path | None, resume: Path | None) -> Path | None:
    """The folder that keeps the results, if any."""
    if store is not None and resume is not None:
        raise InputError("--store and --resume: give one of them; --store begins, --resume goes on")
    return store or resume


@contextmanager
def tally_shown(label: str) -> Iterator[Callable[[Tally], None]]:
    """Shows on a terminal a bar, elsewhere a line now and then, on the error stream: cells, rate, time left, chaos."""
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
            bar.set_postfix_str(f"{_chaotic(tally)}", refresh=False)
            bar.refresh()

        yield show


def tally_text(tally: Tally) -> str:
    """How far a run is, in one line."""
    done = tally.computed - tally.found
    rate = done / tally.seconds if tally.seconds > 0.0 else 0.0
    left = f", {(tally.asked - tally.computed) / rate:.0f} s left" if rate else ""
    return f"{tally.computed} of {tally.asked} cells, {rate:.3g} a second{left}, {_chaotic(tally)}"


def _chaotic(tally: Tally) -> str:
    return f"{100.0 * tally.chaotic / max(tally.computed, 1):.3g} % chaotic"


def totals_lines(totals: dict[str, Any]) -> str:
    """What a run computed, what its check found, and the dimension of the borders."""
    parts = [f"{totals['computed']} of {totals['cells']} cells computed"]
    if totals["computed_before"]:
        parts.append(f"{totals['computed_before']} of them before")
    if totals["inferred"]:
        parts.append(f"{totals['inferred']} inferred")
    if totals["failed"]:
        parts.append(f"{totals['failed']} failed")
    lines = [f"{', '.join(parts)}; {totals['integrator_steps']:,} steps in {totals['wall_time_s']:.3g} s"]
    if totals["checked"]:
        from gelcone.atlas.uncertain import share_interval

        checked, missed = totals["checked"], totals["missed"]
        low, high = share_interval(missed, checked)
        lines.append(
            f"check: of {checked} inferred cells, drawn and computed, {missed} were of another regime or sign: "
            f"{100 * missed / checked:.2g} % [{100 * low:.2g}, {100 * high:.2g}]"
        )
    if totals["border_dimension"] is not None:
        dimension, error = totals["border_dimension"]
        power = "the work of refining grows with that power of the cells a side"
        lines.append(f"borders between regimes: dimension {dimension:.2f} ± {error:.2f} ({power})")
    return "\n".join(lines)
