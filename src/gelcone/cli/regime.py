"""`gelcone regime`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.lyapunov import UNIT
from gelcone.cli.motions import (
    budget_options,
    counts_text,
    flag_line,
    member_lines,
    periods_json,
    regime_counts,
    regime_names,
)
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, progress_bar, si_json

if TYPE_CHECKING:
    import xarray as xr

NAME = "regime"


@click.command(NAME)
@subject_options
@budget_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    transient: float | None,
    budget: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """What kind of motion it is in the long run - rest, periodic, chaotic, ... - with the evidence.

    \b
    gelcone regime --set voltage=1.04 --set drive_frequency=0.1 --json
    gelcone regime paper-table1 --set voltage=0.5,1,1.5 --out results
    """
    subject = read_subject(device, settings, initial)
    check_folder(out, NAME, force)
    from gelcone.motion.regime import regime
    from gelcone.plots.regime import regime_figure

    with progress_bar(NAME, hidden=as_json) as progress:
        result = regime(subject.model, subject.initial, transient=transient, budget=budget, progress=progress)
    deliver(
        NAME,
        result,
        subject,
        figure=regime_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object."""
    evidence = {
        "lyapunov": {
            "values": result["lyapunov"],
            "standard_error": result["standard_error"],
            "sign": result["sign"],
            "averaged_time": result["averaged_time"],
            "unit": UNIT,
        },
        **{name: result[name] for name in ("return_distance", "cycle_distance", "zero_one")},
        **{name: result[name] for name in ("lowest", "highest", "settled_time")},
        "section": {"displacement": result["section"][..., 0], "velocity": result["section"][..., 1]},
        "disagrees": result["doubtful"].astype(bool),
    }
    kind = {
        "name": regime_names(result["regime"]),
        "period": periods_json(result["period"]),
        "symmetric": result["symmetric"].astype(bool),
        "evidence": evidence,
    }
    content = {NAME: kind, **common_json(result, subject)}
    if subject.device is not None:
        names = ("lyapunov", "standard_error", "averaged_time", "lowest", "highest", "settled_time")
        content["si"] = si_json(shown, names)
    return content


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + evidence_lines(shown))
    told = member_lines(shown, lambda member: "; ".join(evidence_lines(member)[:2]))
    return "\n".join([*lines, counts_text(regime_counts(shown)), *flag_line(shown), *told])


def evidence_lines(member: xr.Dataset) -> list[str]:
    """The name of one motion and the evidence for it."""
    import numpy as np

    from gelcone.plots.regime import caption
    from gelcone.words import unit_of

    told = caption(member)
    if int(member["outcome"]):
        return told
    unit, time = unit_of(member["lowest"]), unit_of(member["averaged_time"]) or " time units"
    told.insert(2, f"displacement {float(member['lowest']):.4g} to {float(member['highest']):.4g}{unit}")
    settled, averaged = float(member["settled_time"]), float(member["averaged_time"])
    if np.isfinite(settled):
        of_cycle = np.isfinite(member["cycle_distance"])
        source = "of the cycle" if of_cycle else f"averaged over {averaged:.4g}{time}"
        told.append(f"settled for {settled:.4g}{time}, exponents {source}")
    return told
