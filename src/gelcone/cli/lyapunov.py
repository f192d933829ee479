"""`gelcone lyapunov`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.motions import budget_options, member_lines, periods_json
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, progress_bar

if TYPE_CHECKING:
    import xarray as xr

NAME = "lyapunov"
UNIT = "per unit dimensionless time"


@click.command(NAME)
@subject_options
@click.option(
    "--window", type=float, default=500.0, show_default=True, help="Finite window from the start, dimensionless time."
)
@budget_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    window: float,
    transient: float | None,
    budget: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Both Lyapunov exponents, over a window from the start and in the long run, with standard errors.

    They are those of the flow, per unit of dimensionless time; with a device also per second.

    \b
    gelcone lyapunov --set voltage=1.7 --set drive_frequency=0.1 --out results
    gelcone lyapunov --set voltage=0.5,1,1.5 --budget 5000 --json
    """
    subject = read_subject(device, settings, initial)
    check_folder(out, NAME, force)
    from gelcone.motion.lyapunov import lyapunov
    from gelcone.plots.lyapunov import lyapunov_figure

    with progress_bar(NAME, hidden=as_json) as progress:
        result = lyapunov(
            subject.model, subject.initial, window=window, transient=transient, budget=budget, progress=progress
        )
    deliver(
        NAME,
        result,
        subject,
        figure=lyapunov_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object."""
    exponents = {
        "values": result["lyapunov"],
        **{name: result[name] for name in ("standard_error", "finite", "lyapunov", "sign", "sum_residual")},
        "averaged_time": result["averaged_time"],
        "cycle": periods_json(result["cycle"]),
        "per_repeat": result["per_repeat"],
        "unit": UNIT,
    }
    content = {NAME: exponents, **common_json(result, subject)}
    if subject.device is not None:
        names = ("lyapunov", "standard_error", "finite", "sum_residual", "averaged_time")
        own = {name: shown[name] for name in names}
        units = {"unit": shown["lyapunov"].attrs["units"], "time_unit": shown["averaged_time"].attrs["units"]}
        content["si"] = {NAME: {"values": shown["lyapunov"], **own, **units}}
    return content


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    lines = heading(subject) + outcome_lines(shown)
    if not shown["outcome"].dims:
        return "\n".join(lines + _single(shown))
    return "\n".join([*lines, "largest exponent in the long run:", *member_lines(shown, _largest)])


def _largest(member: xr.Dataset) -> str:
    """The largest exponent in one line."""
    from gelcone.plots.lyapunov import SIGNS
    from gelcone.words import outcome_in_words, rate_unit, with_error

    if int(member["outcome"]):
        return f"failed, {outcome_in_words(int(member['outcome']))}"
    value, error = float(member["lyapunov"][0]), float(member["standard_error"][0])
    repeat = float(member["per_repeat"]) / value if value else 0.0
    at = rate_unit(member["lyapunov"])
    return (
        f"{with_error(value, error)} {at} ({with_error(value * repeat, error * repeat)} per drive repeat), "
        f"{SIGNS[int(member['sign'])]}"
    )


def _single(member: xr.Dataset) -> list[str]:
    """Both exponents of one run, what they rest on, and the finite window beside."""
    from gelcone.words import rate_unit, unit_of, with_error

    if int(member["outcome"]):
        return []
    at = rate_unit(member["lyapunov"])
    second = with_error(float(member["lyapunov"][1]), float(member["standard_error"][1]))
    finite = " and ".join(f"{float(value):+.4g}" for value in member["finite"])
    window, averaged = float(member["finite_time"].max()), float(member["averaged_time"])
    unit, period = unit_of(member["averaged_time"]) or " time units", int(member["cycle"])
    source = f"averaged over {averaged:.4g}{unit} after the transient"
    if period:
        settled = "rest or a cycle of 1 drive repeat" if period == 1 else f"a cycle of {period} drive repeats"
        source = f"from the multipliers of what it settles on, {settled}"
    return [
        f"largest exponent {_largest(member)}",
        f"second exponent {second} {at}; their sum is off -2 zeta by {abs(float(member['sum_residual'])):.1g}",
        source,
        f"over the first {window:.4g}{unit} from the start: {finite} {at}",
    ]
