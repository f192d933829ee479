"""`gelcone basin`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.map import cells_json
from gelcone.cli.motions import budget_options, flag_line, grid_text, periods_json, regime_names, shortened, single
from gelcone.cli.options import Subject, output_options, read_measure, read_range, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines, progress_bar, si_json
from gelcone.cli.sweeps import increasing, over_option
from gelcone.errors import InputError, unknown_name
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

NAME = "basin"
QUANTITIES = {"displacement": "length", "velocity": "velocity"}
DEFAULTS = {"displacement": "-2:2:81", "velocity": "-2:2:81"}


@click.command(NAME)
@subject_options
@over_option(
    "Initial displacements or velocities, from:to:count or v1,v2,... (with a device also '-5 mm:5 mm:41'). "
    "[default: displacement=-2:2:81 and velocity=-2:2:81]"
)
@budget_options
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    transient: float | None,
    budget: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Which motions coexist: the attractor that each initial state ends on, and the attractors' shares.

    \b
    gelcone basin --set voltage=1.04 --set drive_frequency=0.1 --out results
    gelcone basin --set voltage=1.2 --over displacement=-1:1:41 --over velocity=-1:1:41 --json
    """
    if initial is not None:
        raise InputError(
            "--initial: a basin starts from a grid of states; give --over displacement=... and velocity=..."
        )
    subject = single(read_subject(device, settings, initial), NAME)
    swept = read_states(over, subject.device)
    check_folder(out, NAME, force)
    from gelcone.atlas.maps import basin
    from gelcone.plots.basin import basin_figure

    with progress_bar(NAME, hidden=as_json) as progress:
        result = basin(subject.model, swept, transient=transient, budget=budget, progress=progress)
    deliver(
        NAME,
        result,
        subject,
        figure=basin_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def read_states(over: Iterable[str], device: Device | None) -> dict[str, Array]:
    """Initial displacements and velocities; one that is not given takes its default."""
    given: dict[str, str] = {}
    for text in over:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and name and values):
            raise InputError(f"--over {text!r}: must be name=from:to:count, for example --over displacement=-2:2:81")
        if name not in QUANTITIES:
            raise unknown_name("component of the initial state", name, QUANTITIES)
        if name in given:
            raise InputError(f"--over {name}: is given twice; give it once")
        given[name] = values
    return {name: _read(name, given.get(name, DEFAULTS[name]), device) for name in QUANTITIES}


def _read(name: str, text: str, device: Device | None) -> Array:
    option = f"--over {name}"
    if text.count(":") == 2:
        *ends, count = text.split(":")
        begin, end = (read_measure(option, part, QUANTITIES[name], device) for part in ends)
        return increasing(option, read_range(f"{begin!r}:{end!r}:{count.strip()}"))
    return increasing(option, np.array([read_measure(option, p, QUANTITIES[name], device) for p in text.split(",")]))


def attractors_json(result: xr.Dataset) -> list[dict[str, Any]]:
    """The attractors by falling share."""
    columns: dict[str, Any] = {
        "regime": regime_names(result["attractor_regime"]),
        "period": periods_json(result["attractor_period"]),
        **{name: result[f"attractor_{name}"].values for name in ("share", "lowest", "highest", "lyapunov")},
    }
    return [{"number": n} | {k: v[n] for k, v in columns.items()} for n in range(result.sizes["attractor_number"])]


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; arrays are nested in the order of ``axes``."""
    content: dict[str, Any] = {"attractors": attractors_json(result), "attractor": result["attractor"]}
    content |= cells_json(result) | common_json(result, subject)
    del content["initial"], content["options"]["initial"]
    if subject.device is not None:
        measured = [f"attractor_{name}" for name in ("lowest", "highest", "lyapunov")]
        content["si"] = si_json(shown, [*QUANTITIES, *measured])
    return content


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    from gelcone.plots.basin import attractor_in_words

    count = shown.sizes["attractor_number"]
    told = [attractor_in_words(shown.isel(attractor_number=n)).replace("\n", ", ") for n in range(count)]
    lines = [*heading(subject), f"initial {grid_text(shown, QUANTITIES)}", *outcome_lines(shown)]
    lines.append(f"{count} attractor(s):")
    lines += shortened([f"  {n}: {text}" for n, text in enumerate(told)])
    nowhere = float((shown["attractor"] < 0).mean())
    if nowhere:
        lines.append(f"  none: {100.0 * nowhere:.3g} % (failed or not settled)")
    return "\n".join(lines + flag_line(shown))
