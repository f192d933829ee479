"""`gelcone frequency`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.motions import shortened, single
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, progress_bar
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError
from gelcone.words import unit_of

if TYPE_CHECKING:
    import xarray as xr

NAME = "frequency"
PEAK = ("peak_frequency", "peak_low", "peak_high", "peak_amplitude", "peak_amplitude_error")
JUMP = ("jump_low", "jump_high", "jump_from", "jump_to")
CURVES = ("stroke", "lowest", "highest", "harmonic_amplitude", "harmonic_phase")


@click.command(NAME)
@subject_options
@over_option(
    "The drive frequencies, drive_frequency=from:to:count or =f1,f2,... [default: a tenth to three times the natural "
    "frequency]"
)
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Stroke over drive frequency at full drive, swept up and down: resonances, jumps, and linear theory beside it.

    \b
    gelcone frequency biased-pump
    gelcone frequency biased-pump --over "drive_frequency=4 Hz:20 Hz:80" --out results
    gelcone frequency --preset spring --set spring_stiffness=0.1 --over drive_frequency=0.2:1:81 --json
    """
    subject = single(read_subject(device, settings, initial), NAME)
    swept = read_over(over, subject.device)
    if list(swept) not in ([], ["drive_frequency"]):
        raise InputError(
            "--over: a frequency response takes drive_frequency alone, as in --over drive_frequency=0.1:2:80"
        )
    check_folder(out, NAME, force)
    from gelcone.motion.frequency import frequency_response
    from gelcone.plots.frequency import frequency_figure

    with progress_bar(NAME, hidden=as_json) as progress:
        result = frequency_response(subject.model, swept.get("drive_frequency"), subject.initial, progress=progress)
    deliver(
        NAME,
        result,
        subject,
        figure=frequency_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; frequencies and lengths in SI units for a device."""
    named = ("drive_frequency", "stroke", "harmonic_phase")
    branches = {
        str(branch): {
            **{name: shown[name].sel(branch=branch) for name in CURVES},
            "period": [int(period) or None for period in shown["period"].sel(branch=branch).values],
            "peak": {name.removeprefix("peak_"): float(shown[name].sel(branch=branch)) for name in PEAK},
        }
        for branch in shown["branch"].values
    }
    jumps = [
        {"branch": str(jump["jump_branch"].values)} | {name.removeprefix("jump_"): float(jump[name]) for name in JUMP}
        for jump in (shown.isel(jump=i) for i in range(shown.sizes["jump"]))
    ]
    return {
        "units": {name: shown[name].attrs["units"] for name in named} | {"harmonic_phase": "degrees"},
        "drive_frequency": shown["drive_frequency"],
        "harmonic": shown["harmonic"],
        "branches": branches,
        "jumps": jumps,
        "linear": {name: shown[f"linear_{name}"] for name in ("stroke", "amplitude", "phase")},
        **common_json(result, subject),
    }


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal: the peak and what is not periodic on each sweep, and the jumps."""
    from gelcone.plots.frequency import kinds_of_motion

    hertz, length = unit_of(shown["drive_frequency"]), unit_of(shown["stroke"])
    frequency = shown["drive_frequency"].values
    lines = [
        *heading(subject, ["drive_frequency"]),
        f"drive frequency {frequency[0]:.6g} to {frequency[-1]:.6g}{hertz}, {frequency.size} values",
        *outcome_lines(shown),
    ]
    for branch in shown["branch"].values:
        own = shown.sel(branch=branch)
        stroke, error = 2.0 * float(own["peak_amplitude"]), 2.0 * float(own["peak_amplitude_error"])
        at = f"{float(own['peak_frequency']):.5g} [{float(own['peak_low']):.5g}, {float(own['peak_high']):.5g}]{hertz}"
        ends = float(own["peak_frequency"]) in (frequency[0], frequency[-1])
        rising = ", an end of the frequencies: it may rise beyond" if ends else ""
        lines.append(f"swept {branch:5s} largest stroke {stroke:.4g} ± {error:.1g}{length} at {at}{rising}")
        counts = {kind: int(which.sum()) for kind, which in kinds_of_motion(own).items()}
        told = ", ".join(f"{kind} at {n}" for kind, n in counts.items() if n)
        if told:
            lines.append(f"            {told} of {frequency.size} frequencies")
    linear = shown["linear_stroke"].values
    if np.isfinite(linear).all():
        k = int(linear.argmax())
        lines.append(f"linear theory: largest stroke {linear[k]:.4g}{length} at {frequency[k]:.5g}{hertz}")
    else:
        lines.append("no linear theory: no stable equilibrium under the drive's mean square")
    return "\n".join([*lines, *shortened(jump_lines(shown, hertz, length))])


def jump_lines(shown: xr.Dataset, hertz: str, length: str) -> list[str]:
    """Where each sweep jumps, from which stroke to which."""
    if not shown.sizes["jump"]:
        return ["no jump: both sweeps show the same motion"]
    told = ["jumps (the sweeps differ between):"]
    for i in range(shown.sizes["jump"]):
        jump = shown.isel(jump=i)
        low, high, before, after = (float(jump[name]) for name in JUMP)
        told.append(
            f"  swept {jump['jump_branch'].values!s:5s} at {low:.5g} to {high:.5g}{hertz}: "
            f"stroke {2.0 * before:.4g} -> {2.0 * after:.4g}{length}"
        )
    return told
