"""`gelcone continue`: branches of periodic orbits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gelcone.cli.command import help_of, run
from gelcone.cli.options import option_parameters, output_parameters, subject_parameters
from gelcone.register.analyses import ANALYSES

CONTINUE = ANALYSES["continue_branch"]


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
