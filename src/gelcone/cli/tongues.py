"""`gelcone tongues`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.motions import single
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, progress_bar
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

NAME = "tongues"
DEFAULT_OVER = {"drive_frequency": "0.2:3:120", "voltage": "0:2:100"}


@click.command(NAME)
@subject_options
@over_option(
    "drive_frequency or voltage, with its values as from:to:count or v1,v2,...; may be given for both. "
    f"[default: {', '.join(f'{name}={values}' for name, values in DEFAULT_OVER.items())}]"
)
@click.option(
    "--highest",
    type=float,
    metavar="V",
    help="Search the onset at the model's own frequency up to this amplitude, dimensionless. "
    "[default: three times the static pitchfork voltage]",
)
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    highest: float | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Where the drive makes rest unstable: onset voltage, and tongues over drive frequency and voltage.

    \b
    gelcone tongues --over drive_frequency=0.2:3:120 --over voltage=0:2:100 --out results
    gelcone tongues --set damping_ratio=0.01 --set drive_frequency=0.1 --json
    """
    subject = single(read_subject(device, settings, initial), NAME)
    swept = read_plane(over, subject)
    check_folder(out, NAME, force)
    from gelcone.motion.floquet import onset_voltage, tongues
    from gelcone.plots.floquet import tongues_figure

    own = onset_voltage(subject.model, highest=highest)
    with progress_bar(NAME, hidden=as_json) as progress:
        plane = tongues(subject.model, swept["drive_frequency"], swept["voltage"], progress=progress)
    result = plane.assign({f"own_{name}": own[name] for name in ("onset_voltage", "onset_kind", "searched")})
    deliver(
        NAME,
        result,
        subject,
        figure=tongues_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def read_plane(over: tuple[str, ...], subject: Subject) -> dict[str, Any]:
    """Drive frequencies and voltages, those not given by default."""
    swept = read_over(over, subject.device)
    for name in swept:
        if name not in DEFAULT_OVER:
            raise InputError(f"--over {name}: tongues go over drive_frequency and voltage; fix the others with --set")
    missing = [f"{name}={values}" for name, values in DEFAULT_OVER.items() if name not in swept]
    return swept | read_over(missing)


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; the grid is nested frequency first."""
    content = tongues_json(result) | common_json(result, subject)
    if subject.device is not None:
        names = ("drive_frequency", "voltage", "growth_rate")
        content["si"] = tongues_json(shown) | {"units": {name: shown[name].attrs["units"] for name in names}}
    return content


def tongues_json(result: xr.Dataset) -> dict[str, Any]:
    """Onset at the model's own frequency, and the grid."""
    boundary = result["boundary_voltage"].values
    return {
        "onset_voltage": result["own_onset_voltage"],
        "onset_kind": kind_name(result["own_onset_kind"]),
        "searched": result["own_searched"],
        "pitchfork_amplitude": result["pitchfork_amplitude"],
        NAME: {
            "drive_frequency": result["drive_frequency"],
            "voltage": result["voltage"],
            "growth_rate": result["growth_rate"],
            "onset_voltage": result["onset_voltage"],
            "onset_kind": [kind_name(kind) for kind in result["onset_kind"].values],
            "boundary_voltages": [row[np.isfinite(row)] for row in boundary],
            "unstable_share": float((result["margin"] > 0.0).mean()),
        },
    }


def kind_name(kind: Any) -> str:
    """The name of an `Onset`."""
    from gelcone.motion.floquet import Onset

    return Onset(int(kind)).name.lower()


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    from gelcone.motion.floquet import Onset
    from gelcone.words import unit_of

    volt, hertz = unit_of(shown["voltage"]), unit_of(shown["drive_frequency"])
    onset, kind = float(shown["own_onset_voltage"]), Onset(int(shown["own_onset_kind"]))
    searched = f"searched up to {float(shown['own_searched'][1]):.4g}{volt}"
    found = f"onset at {onset:.6g}{volt}, " if np.isfinite(onset) else ""
    lines = [*heading(subject), *outcome_lines(shown), f"at its own frequency: {found}{kind.meaning} ({searched})"]
    line = shown["onset_voltage"].values
    if np.isfinite(line).any():
        i = int(np.nanargmin(line))
        lines.append(
            f"lowest onset on the grid {line[i]:.4g}{volt} at drive frequency "
            f"{float(shown['drive_frequency'][i]):.4g}{hertz}"
        )
    lines.append(f"rest is unstable in {100.0 * float((shown['margin'] > 0.0).mean()):.3g} % of the grid")
    static = float(shown["pitchfork_amplitude"])
    return "\n".join(
        [*lines, f"static pitchfork, for comparison: {static:.4g}{volt}"] if np.isfinite(static) else lines
    )
