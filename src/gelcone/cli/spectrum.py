"""`gelcone spectrum`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, deliver, outcome_names, parameters_json, progress_bar

if TYPE_CHECKING:
    import xarray as xr

NAME = "spectrum"
PRINTED_LINES = 8


@click.command(NAME)
@subject_options
@click.option("--periods", type=int, default=256, show_default=True, help="Length in periods of the voltage.")
@click.option("--discard", type=int, default=200, show_default=True, help="Drive repeats to let pass before.")
@click.option("--highest", type=float, metavar="RATIO", help="End of the band, in units of the drive frequency.")
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    periods: int,
    discard: int,
    highest: float | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Amplitude spectrum of the displacement, its lines, and how much of the motion they are.

    Frequencies are in units of the voltage's (the force of a pure sine lies at 2), with a device also in hertz.

    \b
    gelcone spectrum --set voltage=1.7 --set drive_frequency=0.1 --out results
    gelcone spectrum paper-table1 --json
    """
    subject = read_subject(device, settings, initial)
    check_folder(out, NAME, force)
    from gelcone.motion.spectrum import spectrum

    with progress_bar(NAME, hidden=as_json) as progress:
        result = spectrum(
            subject.model, subject.initial, periods=periods, discard=discard, highest=highest, progress=progress
        )
    from gelcone.plots.spectrum import spectrum_figure

    deliver(
        NAME,
        result,
        subject,
        figure=spectrum_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object: dimensionless numbers, and with a device the same in SI units under ``si``."""
    measured = ("frequency", "amplitude", "line_frequency", "line_amplitude", "mean_displacement", "rms", "folded")
    others = ("frequency_ratio", "line_ratio", "line_prominence", "power_in_lines", "flatness")
    content: dict[str, Any] = {n: result[n] for n in (*others, *measured)}
    content |= {
        "outcome": outcome_names(result),
        "parameters": parameters_json(subject.model),
        "initial": list(subject.initial),
    }
    if subject.device is not None:
        content["device"] = subject.device.name
        content["si"] = {n: {"units": shown[n].attrs["units"], "values": shown[n]} for n in measured}
    return content


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    from gelcone.codes import Outcome

    lines = [subject.device.name if subject.device else "cone model, dimensionless"]
    codes = shown["outcome"].values.ravel()
    for outcome in Outcome:
        count = int((codes == outcome).sum())
        if count and (outcome or len(codes) > 1):
            lines.append(f"  {count} of {len(codes)}: {outcome.meaning}")
    if codes.size > 1:
        lines += _ensemble_ranges(shown)
    elif codes[0] == Outcome.OK:
        lines += _line_table(shown)
    return "\n".join(lines)


def _line_table(shown: xr.Dataset) -> list[str]:
    """The strongest lines of a single member."""
    if np.isnan(shown["power_in_lines"]):
        return ["the actuator stands still: it has no spectrum"]
    units = {n: "" if shown[n].attrs["units"] == "1" else f" {shown[n].attrs['units']}" for n in shown.variables}
    lines = [
        f"rms {float(shown['rms']):.5g}{units['rms']} about {float(shown['mean_displacement']):.5g}{units['rms']}",
        f"{100.0 * float(shown['power_in_lines']):.4g} % of the variance in lines, "
        f"spectral flatness {float(shown['flatness']):.3g}",
        "  frequency/drive    frequency    amplitude    prominence",
    ]
    for i in range(min(PRINTED_LINES, shown.sizes["line"])):
        line = shown.isel(line=i)
        lines.append(
            f"  {float(line['line_ratio']):15.6g} {float(line['line_frequency']):12.6g}{units['line_frequency']} "
            f"{float(line['line_amplitude']):12.4g}{units['line_amplitude']} "
            f"{float(line['line_prominence']):10.1f} dB"
        )
    if shown.sizes["line"] > PRINTED_LINES:
        lines.append(f"  and {shown.sizes['line'] - PRINTED_LINES} more")
    return lines


def _ensemble_ranges(shown: xr.Dataset) -> list[str]:
    """How far the members differ; each one is in the JSON and netCDF."""
    lines = []
    for name in ("rms", "power_in_lines", "flatness"):
        values = shown[name]
        if values.notnull().any():
            units = "" if values.attrs["units"] == "1" else f" {values.attrs['units']}"
            lines.append(f"{name.replace('_', ' ')} {float(values.min()):.4g} to {float(values.max()):.4g}{units}")
    return lines
