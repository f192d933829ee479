"""`gelcone continue`, branches along one parameter, and `gelcone locus`, bifurcations in two, perhaps on a map."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.command import command_of, run
from gelcone.cli.grids import one_store, store_parameters
from gelcone.cli.options import PLACE
from gelcone.errors import InputError
from gelcone.plots import plot
from gelcone.register.analyses import find_analysis

if TYPE_CHECKING:
    import xarray as xr


def continue_command() -> click.Command:
    """`gelcone continue`, with the options of stores that maps and sweeps have."""
    command = command_of(find_analysis("continue_branch"))
    store_options = {option.name: option for option in store_parameters()}
    command.params = [store_options.get(parameter.name, parameter) for parameter in command.params]
    command.callback = run_continue
    return command


def run_continue(*, store: Path | None, resume: Path | None, **typed: Any) -> int:
    """Follows branches, with a new store or one to resume."""
    kept = one_store(store, resume)
    return run(find_analysis("continue_branch"), store=kept, resume=None if resume is None else True, **typed)


def locus_command() -> click.Command:
    """`gelcone locus`."""
    text = (
        "Draw the curves on a map or on tongues over the same two parameters: the file that --out wrote, or the store "
        "of a map."
    )
    command = command_of(find_analysis("locus"))
    command.params.append(click.Option(["--on"], type=PLACE, metavar="FILE|STORE", help=text))
    command.callback = run_locus
    return command


def run_locus(*, on: Path | None, out: Path | None, **typed: Any) -> int:
    """Reads what was typed, follows the curves and delivers them."""
    if on is None:
        return run(find_analysis("locus"), out=out, **typed)
    if out is None:
        raise InputError(f"--on {on}: says what the curves are drawn on; give --out for the figure too")
    return run(find_analysis("locus"), out=out, draw=partial(plot, on=_below(on)), **typed)


def _below(path: Path) -> xr.Dataset:
    """The map or the tongues of a file or a store, in SI units for a device."""
    from gelcone.atlas.record import show
    from gelcone.dataset import load

    return show(path) if path.is_dir() else load(path)
