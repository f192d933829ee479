"""`gelcone show`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.motions import counts_text, grid_text, regime_counts
from gelcone.cli.options import Subject, output_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NAME = "show"


@click.command(NAME)
@click.argument("store", type=click.Path(path_type=Path))
@output_options
def command(store: Path, out: Path | None, force: bool, as_json: bool) -> None:
    """What a store of `gelcone map` or `gelcone sweep` holds by now, also while its run goes on.

    \b
    gelcone show map.zarr --out results
    """
    from gelcone.atlas.record import look, stored_device, stored_plan

    check_folder(out, NAME, force)
    plan, _, _ = stored_plan(store)
    result = look(store)
    deliver(
        NAME,
        result,
        Subject(plan.model, stored_device(store), plan.initial),
        figure=figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def figure(result: xr.Dataset) -> Figure:
    """The picture of a sweep: a map, a probability, or else what is known over the first axes."""
    from gelcone.plots.map import map_figure
    from gelcone.plots.sweep import probability_figure, sweep_figure

    if "regime" in result and "draw" in result.dims and 2 <= len(result["regime"].dims) <= 3:
        from gelcone.atlas.uncertain import probability

        return probability_figure(probability(result))
    if "regime" in result and result["regime"].ndim == 2:
        return map_figure(result)
    return sweep_figure(result)


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object: axes, counts and totals."""
    content: dict[str, Any] = {"axes": {str(dim): result[dim] for dim in result["status"].dims if dim in result.coords}}
    if "regime" in result:
        content["counts"] = regime_counts(result)
    content |= {"status": result["status"], "totals": json.loads(result.attrs["totals"])}
    return content | {k: v for k, v in common_json(known(result), subject).items() if k != "outcome"}


def known(result: xr.Dataset) -> xr.Dataset:
    """The cells that are there, one after the other."""
    flat = result.stack(cell=result["status"].dims)
    return flat.isel(cell=(flat["status"] > 0).values)


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    totals = json.loads(shown.attrs["totals"])
    missing = int((shown["status"] == 0).sum())
    told = f"{totals['computed']} cells computed, {totals['inferred']} inferred, {missing} missing of {totals['cells']}"
    return "\n".join([*head_lines(shown, subject), told, *regime_lines(shown)])


def head_lines(shown: xr.Dataset, subject: Subject) -> list[str]:
    """What was computed on, over which axes and draws, and what failed."""
    axes = [dim for dim in shown["status"].dims if dim in shown.coords]
    drawn = [str(name)[len("drawn_") :] for name in shown.coords if str(name).startswith("drawn_")]
    lines = [*heading(subject, [*axes, *drawn]), grid_text(shown, axes), *outcome_lines(known(shown))]
    lines += [f"{shown.sizes['draw']} draws of {', '.join(drawn)}"] if drawn else []
    return [line for line in lines if line]


def regime_lines(shown: xr.Dataset) -> list[str]:
    """How often each regime was found, where that was the question."""
    return [counts_text(regime_counts(shown))] if "regime" in shown else []
