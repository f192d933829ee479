"""`gelcone sweep`."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli import show, surveys
from gelcone.cli.motions import budget_options, single
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, deliver
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.atlas.uncertain import Distribution

NAME = "sweep"


@click.command(NAME)
@subject_options
@over_option("A parameter of the grid, from:to:count or v1,v2,...; any number of them.")
@click.option(
    "--uncertain",
    multiple=True,
    metavar="NAME=DISTRIBUTION",
    help="A parameter that is drawn at every point: low:high (uniform) or mean~deviation (normal); may be repeated.",
)
@click.option("--count", type=int, default=64, show_default=True, help="Draws of the uncertain parameters.")
@click.option("--method", default="sobol", show_default=True, help="How they are drawn: sobol or latin-hypercube.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the draws.")
@click.option(
    "--analysis",
    default="regime",
    show_default=True,
    help="regime, section, lyapunov, limits (stability of rest), response (stroke and harmonics at full drive; over "
    "drive_frequency a frequency response) or envelope (highest peak voltages).",
)
@budget_options
@surveys.survey_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    uncertain: tuple[str, ...],
    count: int,
    method: str,
    seed: int,
    analysis: str,
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
    """An analysis over any number of parameters, and over draws of uncertain ones.

    With uncertain parameters and the analysis "regime" the result is the probability of chaos at every point.

    \b
    gelcone sweep --preset base --over voltage=0:2:21 --over prestretch=0.6:1.4:5 --over damping_ratio=0.01,0.1
    gelcone sweep --preset base --over voltage=0.8:1.2:21 --uncertain prestretch=1~0.02 --count 128
    """
    kept = surveys.one_store(store, resume)
    who = surveys.read_workers(threads, workers, scheduler)
    from gelcone.atlas.plan import Plan
    from gelcone.atlas.record import stored_device, stored_plan
    from gelcone.atlas.survey import survey
    from gelcone.atlas.uncertain import draw

    lattice = None
    if resume is not None and surveys.from_store(resume, over or uncertain):
        plan, analysis, lattice = stored_plan(resume)
        subject = Subject(plan.model, stored_device(resume), plan.initial)
    else:
        subject = single(read_subject(device, settings, initial), NAME)
        spread = read_uncertain(uncertain)
        draws = draw(spread, count, method=method, seed=seed) if spread else {}  # type: ignore[arg-type]
        swept = read_over(over, subject.device)
        field_limit = subject.device.breakdown_field() if subject.device and analysis == "envelope" else None
        plan = Plan(subject.model, swept, subject.initial, transient, budget, draws=draws, field_limit=field_limit)
    check_folder(out, NAME, force)
    with surveys.tally_shown(NAME) as progress:
        result = survey(
            plan,
            analysis,
            coarsest=lattice,
            store=kept,
            resume=resume is not None,
            device=subject.device,
            workers=who,
            progress=progress,
        )
    deliver(
        NAME,
        result,
        subject,
        figure=show.figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def read_uncertain(texts: Iterable[str]) -> dict[str, Distribution]:
    """``name=low:high`` and ``name=mean~deviation`` as distributions."""
    from gelcone.atlas.uncertain import Normal, Uniform

    spread: dict[str, Distribution] = {}
    for text in texts:
        name, equals, form = (part.strip() for part in text.partition("="))
        sign = "~" if "~" in form else ":"
        parts = form.split(sign)
        try:
            one, other = (float(part) for part in parts)
        except ValueError:
            raise InputError(
                f"--uncertain {text!r}: must be name=low:high or name=mean~deviation, for example prestretch=1~0.02"
            ) from None
        if not equals or name in spread:
            raise InputError(f"--uncertain {text!r}: must be name=..., each name once")
        spread[name] = Normal(one, other) if sign == "~" else Uniform(one, other)
    return spread


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; arrays are nested in the order of ``dims``."""
    content: dict[str, Any] = {"dims": list(map(str, result["status"].dims))}
    content |= {str(name): variable for name, variable in result.data_vars.items()}
    content["draws"] = {str(n)[len("drawn_") :]: c for n, c in result.coords.items() if str(n).startswith("drawn_")}
    if "draw" in result.dims and "regime" in result:
        from gelcone.atlas.uncertain import probability

        chance = probability(result)
        content["probability"] = {str(name): variable for name, variable in chance.data_vars.items()}
    return content | show.report(result, shown, subject) | {"totals": json.loads(result.attrs["totals"])}


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    totals = surveys.totals_lines(json.loads(shown.attrs["totals"]))
    lines = [*show.head_lines(shown, subject), *show.regime_lines(shown), totals]
    if "draw" in shown.dims and "regime" in shown:
        from gelcone.atlas.uncertain import probability

        chance = probability(shown)
        highest = chance.isel(chance["probability"].argmax(...)) if chance["probability"].ndim else chance
        where = ", ".join(f"{name} {float(highest[name]):.4g}" for name in chance["probability"].dims)
        lines.append(
            f"probability of chaos {float(highest['probability']):.3g} "
            f"[{float(highest['low']):.3g}, {float(highest['high']):.3g}] "
            f"of {int(highest['decided'])} draws" + (f", the highest, at {where}" if where else "")
        )
    return "\n".join(lines)
