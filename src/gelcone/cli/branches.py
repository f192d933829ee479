"""`gelcone continue` and `gelcone locus`: branches of periodic orbits, and their bifurcations in two parameters."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.command import help_of, run
from gelcone.cli.options import PLACE, option_parameters, output_parameters, over_parameter, subject_parameters
from gelcone.errors import InputError
from gelcone.plots import plot
from gelcone.register.analyses import ANALYSES

if TYPE_CHECKING:
    import xarray as xr

CONTINUE, LOCUS = ANALYSES["continue_branch"], ANALYSES["locus"]


def continue_command() -> click.Command:
    """`gelcone continue`."""
    ends = [click.Argument([name], metavar=shown) for name, shown in (("low", "FROM"), ("high", "TO"))]
    params = [
        click.Argument(["parameter"]),
        *ends,
        *subject_parameters(),
        click.Option(
            ["--from", "start"],
            metavar="rest|settled|FILE",
            help="Where branches begin: rest and what is born there, the settled motions at the ends of the interval, "
            "or the cycles of a result of bifurcation or continue.  [default: rest]",
        ),
        *option_parameters(option for name, option in CONTINUE.options.items() if name != "start"),
        click.Option(
            ["--store", "--resume", "store"],
            type=PLACE,
            metavar="STORE",
            help="Folder that keeps what is found while it comes; after an interruption the same command goes on.",
        ),
        *output_parameters(),
    ]
    return click.Command(CONTINUE.command, params=params, callback=run_continue, help=help_of(CONTINUE))


def run_continue(*, out: Path | None, force: bool, as_json: bool, **typed: Any) -> int:
    """Reads what was typed, follows the branches and delivers them."""
    return run(CONTINUE, out=out, force=force, as_json=as_json, **typed)


def locus_command() -> click.Command:
    """`gelcone locus`."""
    params = [
        click.Argument(["event"]),
        *subject_parameters(),
        *over_parameter(LOCUS),
        click.Option(
            ["--from", "start"],
            metavar="rest|settled",
            help="Where the branches begin that hold the events: rest and what is born there, or the settled motions "
            "at the ends of the first interval.  [default: rest]",
        ),
        *option_parameters(option for name, option in LOCUS.options.items() if name != "start"),
        click.Option(
            ["--on"],
            type=PLACE,
            metavar="FILE|STORE",
            help="Draw the curves on a map or on tongues over the same two parameters: the file that --out wrote, or "
            "the store of a map.",
        ),
        *output_parameters(),
    ]
    return click.Command(LOCUS.command, params=params, callback=run_locus, help=help_of(LOCUS))


def run_locus(*, on: Path | None, out: Path | None, force: bool, as_json: bool, **typed: Any) -> int:
    """Reads what was typed, follows the curves and delivers them."""
    if on is None:
        return run(LOCUS, out=out, force=force, as_json=as_json, **typed)
    if out is None:
        raise InputError(f"--on {on}: says what the curves are drawn on; give --out for the figure too")
    below = _below(on)
    return run(LOCUS, out=out, force=force, as_json=as_json, draw=partial(plot, on=below), **typed)


def _below(path: Path) -> xr.Dataset:
    """The map or the tongues of a file or a store, in SI units for a device."""
    from gelcone.atlas.record import show
    from gelcone.dataset import load
    from gelcone.devices.si import device_of, to_si

    found = show(path) if path.is_dir() else load(path)
    return found if device_of(found) is None else to_si(found)
