"""`gelcone validate`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from gelcone.analyses.answer import check_folder
from gelcone.analyses.ask import Answers
from gelcone.analyses.request import read_measures
from gelcone.analyses.validation import constant_voltages, radius_ratio, split_settings, validate_words
from gelcone.cli.options import output_parameters, subject_of, subject_parameters
from gelcone.cli.output import deliver, progress_bar
from gelcone.errors import InputError

DEFAULT_DISPLACEMENTS = (0.1, 2.0, 20)
HELP = """Is the cone right? Force over displacement of the film as a cone and as an axisymmetric membrane.

--set radius_ratio=a/b gives the disc's radius over the film's (default 0.2; a device has its own). The spring,
mass and drive play no part. Needs scikit-fem: pip install 'gelcone[fem]'.

\b
gelcone validate --set radius_ratio=0.2 --displacements 0.5,1,1.5 --voltages 0,0.3 --out results
gelcone validate --set radius_ratio=0.05,0.2,0.5 --set prestretch=1.2 --set prestretch_mode=equibiaxial --json
gelcone validate paper-table1 --displacements "5 mm:40 mm:8" --voltages "0 kV,1 kV"
"""


def validate_command() -> click.Command:
    """`gelcone validate`."""
    params: list[click.Parameter] = [
        *subject_parameters(),
        click.Option(
            ["--displacements"],
            metavar="X1,X2,...",
            help="Displacements x = h/(b-a) of the disc, a list or from:to:count (with a device '2 mm,5 mm'). "
            "[default: 20 from 0.1 to 2 times the width b-a]",
        ),
        click.Option(
            ["--voltages"],
            metavar="V1,V2,...",
            help="Constant voltages, a list or from:to:count (with a device also '0 V,500 V'). "
            "[default: the voltage that is set, taken as a constant one, or else 0]",
        ),
        click.Option(
            ["--wrinkles"],
            default="mark",
            show_default=True,
            metavar="mark|relax",
            help="Mark where a film without wrinkles is compressed, or let it wrinkle (tension field).",
        ),
        click.Option(
            ["--elements"], type=int, default=200, show_default=True, help="Finite elements along the radius."
        ),
        *output_parameters(),
    ]
    return click.Command("validate", params=params, callback=run_validate, help=HELP)


def run_validate(
    *,
    displacements: str | None,
    voltages: str | None,
    wrinkles: Any,
    elements: int,
    out: Path | None,
    force: bool,
    as_json: bool,
    **typed: Any,
) -> int:
    """Compares the forces of cone and continuum."""
    if typed["initial"] is not None:
        raise InputError("--initial: the disc is held at each displacement; leave it out")
    if typed["film"] is not None:
        raise InputError("--film: the cone and the continuum are both computed here; leave it out")
    settings = typed["settings"]
    own, typed["settings"] = split_settings(settings)
    subject = subject_of(typed)
    ratio = radius_ratio(own, subject)
    x = (
        np.linspace(*DEFAULT_DISPLACEMENTS)
        if displacements is None
        else read_measures("--displacements", displacements, "length", subject.device)
    )
    levels = constant_voltages(voltages, settings, subject)
    check_folder(out, "validate", force)
    from gelcone.continuum.compare import compare, with_mesh_table

    # The film alone: a voltage that is given as a list makes levels, not members.
    film = subject.model.replace(voltage=0.0, voltage_bias=0.0, drive_frequency=1.0, film="taut")
    with progress_bar("validate") as progress:
        result = compare(
            film, ratio, displacements=x, voltages=levels, wrinkles=wrinkles, elements=elements, progress=progress
        )
    result = with_mesh_table(result, ratio)
    return deliver(Answers("validate", validate_words), result, subject, out, force, as_json)
