"""`gelcone map`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli import surveys
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
    single,
)
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, si_json
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

NAME = "map"


@click.command(NAME)
@subject_options
@over_option("A parameter of the map, from:to:count or v1,v2,...; give two, the first one is drawn along x.")
@click.option(
    "--coarsest",
    type=int,
    default=64,
    show_default=True,
    help="Points along each axis that are computed at least; the map is refined where it changes between them.",
)
@click.option("--uniform", is_flag=True, help="Compute every cell.")
@budget_options
@surveys.survey_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    coarsest: int,
    uniform: bool,
    transient: float | None,
    budget: float,
    store: Path | None,
    resume: Path | None,
    threads: int | None,
    workers: int | None,
    scheduler: str | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Largest exponent and regime over two parameters, every cell from the same initial state.

    Refined where the regime or the exponent's sign changes between neighbours; --uniform computes every cell.

    \b
    gelcone map --preset base --over voltage=0:2:101 --over prestretch=0.4:2:81 --out results
    gelcone map --preset base --over voltage=0:2:512 --over prestretch=0.4:2:512 --store map.zarr
    gelcone map --resume map.zarr --out results
    """
    kept = surveys.one_store(store, resume)
    who = surveys.read_workers(threads, workers, scheduler)
    from gelcone.atlas.plan import Plan
    from gelcone.atlas.record import stored_device, stored_plan
    from gelcone.atlas.survey import survey
    from gelcone.plots.map import map_figure

    lattice: int | None
    if resume is not None and surveys.from_store(resume, over):
        plan, analysis, lattice = stored_plan(resume)
        if analysis != "regime" or len(plan.dims) != 2 or plan.draws:
            raise InputError(f"{resume}: holds no map but a sweep; go on with `gelcone sweep --resume {resume}`")
        subject = Subject(plan.model, stored_device(resume), plan.initial)
    else:
        subject = single(read_subject(device, settings, initial), NAME)
        swept = read_over(over, subject.device)
        if len(swept) != 2:
            remedies = {
                0: "for example --over voltage=0:2:101 --over prestretch=0.4:2:81",
                1: "for one, use `gelcone bifurcation`",
            }
            remedy = remedies.get(len(swept), "fix the others with --set, or use `gelcone sweep`")
            raise InputError(f"--over: a map takes two parameters, not {len(swept)}; {remedy}")
        plan = Plan(subject.model, swept, subject.initial, transient, budget)
        lattice = None if uniform else coarsest
    check_folder(out, NAME, force)
    with surveys.tally_shown(NAME) as progress:
        result = survey(
            plan,
            coarsest=lattice,
            store=kept,
            resume=resume is not None,
            device=subject.device,
            workers=who,
            progress=progress,
        )
    deliver(
        NAME, result, subject, figure=map_figure, report=report, summary=summary, out=out, force=force, as_json=as_json
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; arrays are nested in the order of ``axes``."""
    content = cells_json(result) | common_json(result, subject)
    content["status"] = result["status"]
    content["totals"] = json.loads(result.attrs["totals"])
    if subject.device is not None:
        swept = [f"{dim}_si" for dim in result["regime"].dims if f"{dim}_si" in shown.coords]
        content["si"] = si_json(shown, [*swept, "lyapunov", "standard_error", "lowest", "highest"])
    return content


def cells_json(result: xr.Dataset) -> dict[str, Any]:
    """What is known of every cell, nested in the order of ``axes``."""
    counts = regime_counts(result)
    return {
        "axes": {str(dim): result[dim] for dim in result["regime"].dims},
        "counts": counts,
        "chaotic_share": counts.get("chaotic", 0) / result["regime"].size,
        "regime": regime_names(result["regime"]),
        "period": periods_json(result["period"]),
        "lyapunov": {
            "values": first(result["lyapunov"]),
            "standard_error": first(result["standard_error"]),
            "unit": UNIT,
        },
        "lowest": result["lowest"],
        "highest": result["highest"],
        **marked_cells(result),
    }


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    lines = [*heading(subject, shown["regime"].dims), grid_text(shown, shown["regime"].dims), *outcome_lines(shown)]
    counts = regime_counts(shown)
    lines.append(f"{counts_text(counts)} ({100.0 * counts.get('chaotic', 0) / shown['regime'].size:.3g} % chaotic)")
    lines.append(surveys.totals_lines(json.loads(shown.attrs["totals"])))
    return "\n".join([*lines, *exponent_lines(shown), *flag_line(shown)])


def exponent_lines(shown: xr.Dataset) -> list[str]:
    """The largest and the smallest of the largest exponents, where they are, per unit time and per drive repeat."""
    from gelcone.words import rate_unit, with_error

    exponent = first(shown["lyapunov"])
    if not exponent.notnull().any():
        return []
    lines = []
    for word, at in (("highest", exponent.argmax(...)), ("lowest", exponent.argmin(...))):
        cell = shown.isel(at)
        value = with_error(float(cell["lyapunov"][0]), float(cell["standard_error"][0]))
        where = ", ".join(f"{dim} {float(cell[dim]):.4g}" for dim in exponent.dims)
        lines.append(f"{word} exponent {value} {rate_unit(exponent)} at {where}")
    return lines
