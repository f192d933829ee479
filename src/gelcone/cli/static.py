"""`gelcone static`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.motions import member_labels, shortened
from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, outcome_lines
from gelcone.cli.sweeps import read_values

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.quantity import Array

NAME = "static"


@click.command(NAME)
@subject_options
@click.option(
    "--voltages",
    metavar="V1,V2,...",
    help="Constant voltages, a list or from:to:count (with a device also '0 V,500 V'). "
    "[default: the voltage amplitude, taken as a constant voltage]",
)
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    voltages: str | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Equilibria under constant voltages, pitchfork, folds, pull-in, stroke and blocked force.

    The drive plays no part, except that without --voltages its amplitude is taken as a constant voltage.

    \b
    gelcone static --set spring_stiffness=1.5 --voltages 0,1,1.5 --out results
    gelcone static paper-table1 --voltages "0 kV:10 kV:11" --json
    """
    subject = read_subject(device, settings, initial)
    levels = None if voltages is None else read_values("--voltages", voltages, "voltage", subject.device)
    check_folder(out, NAME, force)
    from gelcone.motion.equilibrium import static, stroke_and_blocked_force
    from gelcone.plots.equilibrium import static_figure

    at = np.unique(subject.model.voltage) if levels is None else levels
    delivered = stroke_and_blocked_force(subject.model, at)
    result = static(subject.model, at).assign({n: delivered[n] for n in ("stroke", "blocked_force")})
    deliver(
        NAME,
        result,
        subject,
        figure=static_figure,
        report=lambda result, shown, subject: report(result, shown, subject, levels),
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject, levels: Array | None) -> dict[str, Any]:
    """The JSON object; for an ensemble each entry is a list over its members."""
    own = None if levels is not None else own_levels(result, subject)
    content = statics_json(result, own) | common_json(result, subject)
    if subject.device is not None:
        names = ("displacement", "force", "slope", "constant_voltage")
        content["si"] = {
            **statics_json(shown, own),
            "units": {name.removeprefix("constant_"): shown[name].attrs["units"] for name in names},
        }
    return content


def own_levels(result: xr.Dataset, subject: Subject) -> list[int]:
    """For each member, which of the voltages is its own amplitude."""
    own = np.broadcast_to(subject.model.voltage, subject.model.shape).ravel()
    return [int(i) for i in np.searchsorted(result["constant_voltage"].values, own)]


def statics_json(result: xr.Dataset, own: list[int] | None) -> dict[str, Any]:
    """The members side by side; a single one by itself."""
    each = [
        member_json(member) | ({} if own is None else {"equilibria": equilibria(member, own[i])})
        for i, (_, member) in enumerate(member_labels(result))
    ]
    return each[0] if not result["outcome"].dims else {name: [one[name] for one in each] for name in each[0]}


def member_json(member: xr.Dataset) -> dict[str, Any]:
    """What is known of one actuator."""
    from gelcone.physics.balance import PullIn

    folds = np.isfinite(member["fold_voltage"].values)
    return {
        "pitchfork_voltage": member["pitchfork_voltage"],
        "fold_voltages": member["fold_voltage"].values[folds],
        "fold_displacements": member["fold_displacement"].values[folds],
        "pull_in": {
            "voltage": member["pull_in_voltage"],
            "kind": PullIn(int(member["pull_in_kind"])).name.lower(),
            "from": member["pull_in_from"],
            "to": member["pull_in_to"],
        },
        "rest_displacement": member["rest_displacement"],
        "displacement": member["displacement"],
        "curves": [
            {
                "voltage": member["constant_voltage"][i],
                "equilibria": equilibria(member, i),
                "stroke": member["stroke"][i],
                "blocked_force": member["blocked_force"][i],
                "force": member["force"][i],
            }
            for i in range(member.sizes["constant_voltage"])
        ],
    }


def equilibria(member: xr.Dataset, level: int) -> list[dict[str, Any]]:
    """The equilibria at one of the voltages."""
    one = member.isel(constant_voltage=level)
    names = {"displacement": "equilibrium_displacement", "slope": "slope", "stable": "stable"}
    count = int(one["equilibria"])
    return [{key: one[name][k] for key, name in names.items()} for k in range(count)]


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    lines = heading(subject) + outcome_lines(shown)
    members = member_labels(shown)
    if len(members) == 1:
        return "\n".join(lines + curve_lines(members[0][1]) + event_lines(members[0][1]))
    told = [line for name, member in members for line in (f"{name}:", *(f"  {e}" for e in event_lines(member)))]
    return "\n".join(lines + shortened(told))


def curve_lines(member: xr.Dataset) -> list[str]:
    """The equilibria, stroke and blocked force at each voltage."""
    from gelcone.words import unit_of

    if int(member["outcome"]):
        return []
    volt, length, force = (unit_of(member[name]) for name in ("constant_voltage", "displacement", "force"))
    lines = []
    for i in range(member.sizes["constant_voltage"]):
        places = [
            f"{float(e['displacement']):.4g}{length} ({'stable' if e['stable'] else 'unstable'})"
            for e in equilibria(member, i)
        ]
        lines.append(
            f"  {float(member['constant_voltage'][i]):.4g}{volt}: rests at {', '.join(places) or 'nothing'}; "
            f"stroke {float(member['stroke'][i]):.4g}{length}, "
            f"blocked force {float(member['blocked_force'][i]):.4g}{force}"
        )
    return ["constant voltage:", *shortened(lines)]


def event_lines(member: xr.Dataset) -> list[str]:
    """Pitchfork, folds and pull-in."""
    from gelcone.physics.balance import PullIn
    from gelcone.words import unit_of

    if int(member["outcome"]):
        return ["nothing can be reached inside the stretch limit"]
    volt, length = unit_of(member["constant_voltage"]), unit_of(member["displacement"])
    pitchfork = float(member["pitchfork_voltage"])
    lines = [f"pitchfork of the flat film at {pitchfork:.4g}{volt}"] if np.isfinite(pitchfork) else []
    for voltage, place in zip(member["fold_voltage"].values, member["fold_displacement"].values, strict=True):
        if np.isfinite(voltage):
            lines.append(f"fold at {voltage:.4g}{volt}, displacement {place:.4g}{length}")
    kind = PullIn(int(member["pull_in_kind"]))
    voltage, begin, end = (float(member[f"pull_in_{part}"]) for part in ("voltage", "from", "to"))
    if np.isnan(voltage):
        return [*lines, "slow voltage ramp from 0: no stable equilibrium to start from"]
    if kind == PullIn.NEVER:
        return [*lines, f"slow voltage ramp from 0: {kind.meaning}"]
    told = f"slow voltage ramp from 0: at {voltage:.4g}{volt} the disc {kind.meaning}"
    if np.isinf(end):
        return [*lines, told]
    return [*lines, f"{told} ({'it leaves it gradually' if begin == end else f'goes on to {end:.4g}{length}'})"]
