"""`gelcone section`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, deliver, outcome_names, parameters_json, progress_bar
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

NAME = "section"


@click.command(NAME)
@subject_options
@click.option("--repeats", type=int, default=500, show_default=True, help="Length in repeats of the drive.")
@click.option("--discard", type=int, default=200, show_default=True, help="Repeats to let pass before.")
@click.option(
    "--phase", type=float, metavar="P", help="Where in the repeat the points are taken, in [0, 1). [default: 0]"
)
@click.option("--extrema", "at_zero_velocity", is_flag=True, help="Take the turning points instead.")
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    repeats: int,
    discard: int,
    phase: float | None,
    at_zero_velocity: bool,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Poincare section: the motion once every repeat of the drive, or its maxima and minima.

    The drive repeats every half period of a pure sine voltage, and every period of one with a bias.

    \b
    gelcone section --set voltage=1.7 --set drive_frequency=0.1 --repeats 2000 --out results
    gelcone section paper-table1 --extrema --json
    """
    if at_zero_velocity and phase is not None:
        raise InputError("--phase: the turning points have no common phase; leave out --phase or --extrema")
    subject = read_subject(device, settings, initial)
    name = "extrema" if at_zero_velocity else NAME
    check_folder(out, name, force)
    from gelcone.motion.section import extrema, section

    with progress_bar(name, hidden=as_json) as progress:
        options: dict[str, Any] = {"repeats": repeats, "discard": discard, "progress": progress}
        if at_zero_velocity:
            result = extrema(subject.model, subject.initial, **options)
        else:
            result = section(subject.model, subject.initial, phase=phase or 0.0, **options)
    from gelcone.plots.section import section_figure

    deliver(
        name,
        result,
        subject,
        figure=section_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object: dimensionless numbers, and with a device the same in SI units under ``si``."""
    own = ("repeat",) if "repeat" in result.dims else ("phase", "maximum", "count")
    measured = ("time", "displacement", "velocity")
    content: dict[str, Any] = {n: result[n] for n in (*own, *measured)}
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
    lines.append(f"{shown.attrs['title']}, {subject.model.size} member(s)")
    for outcome in Outcome:
        count = int((codes == outcome).sum())
        if count and (outcome or len(codes) > 1):
            lines.append(f"  {count} of {len(codes)}: {outcome.meaning}")
    x, u = shown["displacement"], shown["velocity"]
    units = {v.name: "" if v.attrs["units"] == "1" else f" {v.attrs['units']}" for v in (x, u)}
    if x.notnull().any():
        lines.append(f"displacement {float(x.min()):.5g} to {float(x.max()):.5g}{units['displacement']}")
    if "count" in shown:
        for kind, word in ((1, "maxima"), (-1, "minima")):
            of_kind = x.where(shown["maximum"] == kind)
            if of_kind.notnull().any():
                span = f"{float(of_kind.min()):.5g} to {float(of_kind.max()):.5g}{units['displacement']}"
                lines.append(f"  {int(of_kind.notnull().sum())} {word}: {span}")
    elif u.notnull().any():
        lines.append(f"velocity {float(u.min()):.5g} to {float(u.max()):.5g}{units['velocity']}")
    return "\n".join(lines)
