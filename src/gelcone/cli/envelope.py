"""`gelcone envelope`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, progress_bar
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

NAME = "envelope"


@click.command(NAME)
@subject_options
@click.option("--margin", type=float, default=0.2, show_default=True, help="Share kept below the lowest limit.")
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    margin: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Where a device is safe to drive: limits over voltage and frequency, which comes first, a recommended window.

    \b
    gelcone envelope biased-pump --out results
    gelcone envelope my-device.toml --margin 0.3 --json
    """
    if initial is not None:
        raise InputError("--initial: an envelope starts from the device's rest; leave it out")
    subject = read_subject(device, settings, None)
    check_folder(out, NAME, force)
    from gelcone.atlas.envelope import envelope
    from gelcone.plots.envelope import envelope_figure

    field_limit = subject.device.breakdown_field() if subject.device else None
    with progress_bar(NAME, hidden=as_json) as progress:
        result = envelope(subject.model, field_limit=field_limit, margin=margin, progress=progress)
    deliver(
        NAME,
        result,
        subject,
        figure=envelope_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; voltages, frequencies and so on in SI units for a device."""
    axes = ("peak_voltage", "stroke", "blocked_force", "natural_frequency")
    static = map(reading, shown["static_limit_voltage"].values)
    driven = ("drive_frequency", "recommended_peak", "driven_peak", "driven_stroke", "driven_power")
    common = common_json(result.drop_vars("outcome").assign(outcome=0), subject)
    return {
        **{k: v for k, v in common.items() if k != "outcome"},
        "units": {name: shown[name].attrs["units"] for name in (*axes, *driven)},
        "static_limits": dict(zip(_names(shown, "static_limit"), static, strict=True)),
        "driven_limits": {
            name: {"low": shown["limit_low"].values[i], "high": shown["limit_high"].values[i]}
            for i, name in enumerate(_names(shown, "driven_limit"))
        },
        "first_limit": [first_name(shown, i) for i in shown["first_limit"].values],
        **{name: shown[name] for name in (*axes, *driven)},
    }


def _names(shown: xr.Dataset, dim: str) -> list[str]:
    return [str(name) for name in shown[dim].values]


def first_name(shown: xr.Dataset, index: int) -> str | None:
    """Name of the limit that comes first, None where none does."""
    return None if index < 0 else _names(shown, "driven_limit")[int(index)]


def reading(voltage: float) -> float | str:
    """A limit's voltage, or in words that it is unknown or not reached."""
    if np.isnan(voltage):
        return "unknown or not applicable"
    return "not reached" if np.isinf(voltage) else float(voltage)


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What an engineer reads on the terminal: a table of limits, and the window at three frequencies."""
    volt = shown["driven_peak"].attrs["units"].replace("1", "")
    hertz = shown["drive_frequency"].attrs["units"].replace("1", "")
    lines = [*heading(subject), f"{'limit (constant voltage)':28s} peak voltage"]
    for name, voltage in zip(_names(shown, "static_limit"), shown["static_limit_voltage"].values, strict=True):
        value = reading(voltage)
        lines.append(f"  {name:26s} {value if isinstance(value, str) else f'{value:.5g} {volt}'}")
    unit = f"({hertz})" if hertz else ""
    lines.append(f"{'drive frequency ' + unit:28s} recommended peak   stroke there     first limit, and where")
    for i, frequency in enumerate(shown["drive_frequency"].values):
        lines.append(f"  {frequency:<26.4g} {_row(shown, i, volt)}")
    return "\n".join(lines)


def _row(shown: xr.Dataset, i: int, volt: str) -> str:
    """Recommended peak, stroke there and first limit at one drive frequency."""
    recommended, first = float(shown["recommended_peak"].values[i]), int(shown["first_limit"].values[i])
    stroke = np.interp(recommended, shown["driven_peak"].values, shown["driven_stroke"].values[i])
    unit = shown["driven_stroke"].attrs["units"].replace("1", "")
    window = f"{recommended:.4g} {volt}" if recommended > 0.0 else "none"
    moved = f"{stroke:.4g} {unit}" if recommended > 0.0 else "-"
    if first < 0:
        return f"{window:18s} {moved:16s} none met"
    low, high = (shown[name].values[first, i] for name in ("limit_low", "limit_high"))
    return f"{window:18s} {moved:16s} {first_name(shown, first)}, {low:.4g} to {high:.4g} {volt}"
