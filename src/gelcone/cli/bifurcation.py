"""`gelcone bifurcation`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.lyapunov import UNIT
from gelcone.cli.motions import (
    budget_options,
    counts_text,
    first,
    flag_line,
    grid_text,
    marked_cells,
    periods_json,
    regime_counts,
    regime_names,
    shortened,
    single,
)
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import (
    check_folder,
    common_json,
    deliver,
    heading,
    outcome_lines,
    parameter_scale,
    progress_bar,
)
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

NAME = "bifurcation"


@click.command(NAME)
@subject_options
@over_option("The parameter to sweep, from:to:count or v1,v2,...")
@click.option(
    "--sweeps",
    default="up,down",
    show_default=True,
    metavar="up,down|none",
    help="Sweeps that follow the motion, besides the branch that starts from --initial at every value.",
)
@click.option("--bisections", type=int, default=8, show_default=True, help="Halvings of each threshold's interval.")
@budget_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    sweeps: str,
    bisections: int,
    transient: float | None,
    budget: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """What the motion is along one parameter: section points, exponents, regimes, and where these change.

    \b
    gelcone bifurcation --over voltage=0:2:401 --set drive_frequency=0.1 --out results
    gelcone bifurcation paper-table1 --over "voltage=0 kV:10 kV:101" --sweeps up --json
    """
    subject = single(read_subject(device, settings, initial), NAME)
    swept = read_over(over, subject.device)
    if len(swept) != 1:
        other = "two make a `gelcone map`" if len(swept) == 2 else "for example --over voltage=0:2:401"
        raise InputError(f"--over: a bifurcation diagram takes one parameter, not {len(swept)}; {other}")
    followed = read_sweeps(sweeps)
    check_folder(out, NAME, force)
    from gelcone.atlas.bifurcation import bifurcation
    from gelcone.plots.bifurcation import bifurcation_figure

    ((name, values),) = swept.items()
    with progress_bar(NAME, hidden=as_json) as progress:
        result = bifurcation(
            subject.model,
            name,
            values,
            initial=[subject.initial],
            sweeps=followed,
            bisections=bisections,
            transient=transient,
            budget=budget,
            progress=progress,
        )
    deliver(
        NAME,
        result,
        subject,
        figure=bifurcation_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def read_sweeps(text: str) -> list[str]:
    """``up,down``, one of them, or ``none``."""
    sweeps = [part.strip() for part in text.split(",")]
    if sweeps == ["none"]:
        return []
    if not set(sweeps) <= {"up", "down"} or len(set(sweeps)) < len(sweeps):
        raise InputError(f"--sweeps {text!r}: must be up, down, up,down or none")
    return sweeps


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; section points are in the netCDF file."""
    from gelcone.atlas.bifurcation import thresholds_of

    name = result.attrs["parameter"]
    content = {
        "parameter": name,
        "values": result[name],
        "thresholds": thresholds_of(result),
        "branches": {str(branch): branch_json(result.sel(branch=branch)) for branch in result["branch"].values},
        "unit": UNIT,
        **marked_cells(result),
        **common_json(result, subject),
    }
    scale = None if subject.device is None else parameter_scale(name, subject.device)
    if subject.device is not None:
        measured = ("lowest", "highest", "lyapunov", "standard_error")
        content["si"] = {n: {"units": shown[n].attrs["units"]} for n in measured} | {
            "branches": {str(b): {n: first(shown.sel(branch=b)[n]) for n in measured} for b in shown["branch"].values}
        }
    if scale is not None:
        ends = [{end: row[end] * scale[0] for end in ("low", "high")} for row in content["thresholds"]]
        content["si"] |= {
            "values": {"units": scale[1], "values": shown[f"{name}_si"]},
            "thresholds": [
                row | own | {"units": scale[1]} for row, own in zip(content["thresholds"], ends, strict=True)
            ],
        }
    return content


def branch_json(branch: xr.Dataset) -> dict[str, Any]:
    """What one branch is at each value."""
    return {
        "regime": regime_names(branch["regime"]),
        "period": periods_json(branch["period"]),
        "symmetric": branch["symmetric"].astype(bool),
        **{name: first(branch[name]) for name in ("lyapunov", "standard_error", "lowest", "highest", "zero_one")},
    }


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    name = shown.attrs["parameter"]
    lines = [*heading(subject, [name]), grid_text(shown, [name]), *outcome_lines(shown)]
    for branch in shown["branch"].values:
        lines.append(f"  {branch}: {counts_text(regime_counts(shown.sel(branch=branch)))}")
    return "\n".join([*lines, *flag_line(shown), *threshold_lines(shown, subject)])


def threshold_lines(shown: xr.Dataset, subject: Subject) -> list[str]:
    """Where the regime changes, on which branch, from what to what."""
    from gelcone.atlas.bifurcation import thresholds_of

    name = shown.attrs["parameter"]
    scale = None if subject.device is None else parameter_scale(name, subject.device)
    told = []
    for row in thresholds_of(shown):
        low, high = row["low"], row["high"]
        in_si = "" if scale is None else f" ({low * scale[0]:.6g} to {high * scale[0]:.6g} {scale[1]})"
        told.append(f"  {row['branch']}: {row['from']} -> {row['to']} at {name} {low:.6g} to {high:.6g}{in_si}")
    return ["changes of regime:" if told else "no change of regime", *shortened(told)]
