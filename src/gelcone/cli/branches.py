"""`gelcone continue` and `gelcone locus`: branches of periodic orbits, and their bifurcations in two parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gelcone.cli.command import help_of, run
from gelcone.cli.options import option_parameters, output_parameters, over_parameter, subject_parameters
from gelcone.register.analyses import ANALYSES

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
        *output_parameters(),
    ]
    return click.Command(CONTINUE.command, params=params, callback=run_continue, help=help_of(CONTINUE))


def run_continue(*, out: Path | None, force: bool, as_json: bool, **typed: Any) -> None:
    """Reads what was typed, follows the branches and delivers them."""
    run(CONTINUE, out=out, force=force, as_json=as_json, **typed)


def locus_command() -> click.Command:
    """`gelcone locus`."""
    params = [
        click.Argument(["event"]),
        *subject_parameters(),
        *over_parameter(LOCUS),
        *option_parameters(LOCUS.options.values()),
        *output_parameters(),
    ]
    return click.Command(LOCUS.command, params=params, callback=run_locus, help=help_of(LOCUS))


def run_locus(*, out: Path | None, force: bool, as_json: bool, **typed: Any) -> None:
    """Reads what was typed, follows the curves and delivers them."""
    run(LOCUS, out=out, force=force, as_json=as_json, **typed)
