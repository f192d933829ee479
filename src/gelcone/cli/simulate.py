"""`gelcone simulate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.options import Subject, output_options, read_subject, read_times, subject_options
from gelcone.cli.output import check_folder, deliver, heading, outcome_names, parameters_json, progress_bar

if TYPE_CHECKING:
    import xarray as xr

NAME = "simulate"


@click.command(NAME)
@subject_options
@click.option("--periods", type=float, default=20.0, show_default=True, help="Length in periods of the voltage.")
@click.option("--times", metavar="T1,T2,...", help="Sample at these times instead (with a device also '20 ms').")
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    periods: float,
    times: str | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """How a device (a TOML file or one of `gelcone devices`) or a dimensionless model moves.

    \b
    gelcone simulate --set voltage=1.04 --set drive_frequency=0.1 --json
    gelcone simulate paper-table1 --periods 30 --out results
    """
    subject = read_subject(device, settings, initial)
    wanted = None if times is None else read_times(times, subject.device)
    check_folder(out, NAME, force)
    from gelcone.motion.response import simulate

    field_limit = subject.device.breakdown_field() if subject.device else None
    with progress_bar("simulate", hidden=as_json) as progress:
        result = simulate(
            subject.model,
            subject.initial,
            periods=periods,
            times=wanted,
            field_limit=field_limit,
            progress=progress,
        )
    from gelcone.plots.response import response_figure

    deliver(
        NAME,
        result,
        subject,
        figure=response_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object: dimensionless numbers, and with a device the same in SI units under ``si``."""
    content: dict[str, Any] = {
        "time": result["time"],
        "displacement": result["displacement"],
        "velocity": result["velocity"],
        "drive_voltage": result["drive_voltage"],
        "outcome": outcome_names(result),
        "parameters": parameters_json(subject.model),
        "initial": list(subject.initial),
        "validity": {str(n).removeprefix("validity_"): v for n, v in result.items() if str(n).startswith("validity_")},
        "energy_residual": float(abs(result["energy_residual"]).max()),
    }
    if subject.device is not None:
        names = ("time", "displacement", "velocity", "drive_voltage")
        content["device"] = subject.device.name
        content["si"] = {n: {"units": shown[n].attrs["units"], "values": shown[n]} for n in names}
    return content


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    from gelcone.codes import Outcome

    lines = heading(subject)
    time, x = shown["time"], shown["displacement"]
    units = {
        n: "" if shown[n].attrs["units"] == "1" else " " + shown[n].attrs["units"] for n in ("time", "displacement")
    }
    lines.append(f"run of {float(time.max()):.5g}{units['time']}, {subject.model.size} member(s)")
    codes = shown["outcome"].values.ravel()
    for outcome in Outcome:
        count = int((codes == outcome).sum())
        if count and (outcome or len(codes) > 1):
            lines.append(f"  {count} of {len(codes)}: {outcome.meaning}")
    if (codes == Outcome.OK).any():
        late = x.isel({x.dims[-1]: slice(x.shape[-1] // 2, None)})
        lines.append(
            f"displacement {float(x.min()):.4g} to {float(x.max()):.4g}{units['displacement']}; "
            f"in the second half {float(late.min()):.4g} to {float(late.max()):.4g}{units['displacement']}"
        )
        lines.append("share of the time outside the model's validity (mean over members):")
        for name, variable in shown.items():
            if str(name).startswith("validity_"):
                share = float(variable.mean())
                text = f"{100 * share:5.1f} %" if share == share else "unknown (no dielectric strength given)"
                lines.append(f"  {str(name).removeprefix('validity_').replace('_', ' '):17s} {text}")
    return "\n".join(lines)
