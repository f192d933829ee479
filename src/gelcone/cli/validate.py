"""`gelcone validate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.motions import shortened
from gelcone.cli.options import (
    DEFAULT_RADIUS_RATIO,
    RADIUS_RATIO,
    Subject,
    film_choice,
    output_options,
    read_settings,
    read_subject,
    subject_options,
)
from gelcone.cli.output import check_folder, common_json, deliver, film_errors, heading, progress_bar, si_json
from gelcone.cli.sweeps import read_values
from gelcone.errors import InputError
from gelcone.files import check_writable
from gelcone.physics.model import ConeModel

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.quantity import Array

NAME = "validate"
FORCES = (
    "force that holds the disc against film and field at a constant voltage, per mu Vol/(b-a), without the spring; "
    "the voltage enters both models as -v^2/2 times the squared area ratio, v = Phi sqrt(eps/mu)/H with the mounted H"
)
HOOP_SLACK = "converged, but compressed along the hoop: the film wrinkles there, and this state is not physical"
AT_POINTS = ("cone_force", "continuum_force", "deviation", "force_error", "limit_share", "cone_limit_share")
FLAGS = ("hoop_slack", "meridional_slack", "overhangs", "stable", "folds", "reached_voltage")
LIMITS = ("limit_displacement", "cone_limit_displacement")
IN_SI = ("displacement", "constant_voltage", "cone_force", "continuum_force", "reached_voltage", *LIMITS)


@click.command(NAME)
@subject_options
@click.option(
    "--displacements",
    default="0.1:2:20",
    show_default=True,
    metavar="X1,X2,...",
    help="Displacements x = h/(b-a) of the disc, a list or from:to:count (with a device also '2 mm,5 mm').",
)
@click.option(
    "--voltages",
    metavar="V1,V2,...",
    help="Constant voltages, a list or from:to:count (with a device also '0 V,500 V'). "
    "[default: the voltage that is set, taken as a constant one, or else 0]",
)
@click.option(
    "--wrinkles",
    default="mark",
    show_default=True,
    metavar="mark|relax",
    help="Mark where a film without wrinkles is compressed, or let it wrinkle (tension field).",
)
@click.option("--elements", type=int, default=200, show_default=True, help="Finite elements along the radius.")
@click.option(
    "--fit",
    "fit_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the continuum film as a fitted force there, for --film of every command.",
)
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    displacements: str,
    voltages: str | None,
    wrinkles: Any,
    elements: int,
    fit_file: Path | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Is the cone right? Force over displacement of the film as a cone and as an axisymmetric membrane.

    --set radius_ratio=a/b gives the disc's radius over the film's (default 0.2; a device has its own). The spring,
    mass and drive play no part. Needs scikit-fem: pip install 'gelcone[fem]'.

    \b
    gelcone validate --set radius_ratio=0.2 --displacements 0.5,1,1.5 --voltages 0,0.3 --out results
    gelcone validate --set radius_ratio=0.05,0.2,0.5 --set prestretch=1.2 --set prestretch_mode=equibiaxial --json
    gelcone validate paper-table1 --displacements "5 mm:40 mm:8" --voltages "0 kV,1 kV"
    """
    if initial is not None:
        raise InputError("--initial: the disc is held at each displacement; leave it out")
    if film_choice() is not None:
        raise InputError("--film: the cone and the continuum are both computed here; leave it out")
    own, others = split_settings(settings)
    subject = read_subject(device, others, None)
    ratio = radius_ratio(own, subject)
    x = read_values("--displacements", displacements, "rest_height", subject.device)
    levels = constant_voltages(voltages, settings, subject)
    check_folder(out, NAME, force)
    if fit_file is not None:
        check_writable([fit_file], force=force)
    from gelcone.continuum.compare import compare, with_mesh_table
    from gelcone.plots.validation import validation_figure

    # the film alone: a voltage that is given as a list makes levels, not members
    film = subject.model.replace(voltage=0.0, voltage_bias=0.0, drive_frequency=1.0, film=None)
    with progress_bar(NAME, hidden=as_json) as progress:
        result = compare(
            film, ratio, displacements=x, voltages=levels, wrinkles=wrinkles, elements=elements, progress=progress
        )
    result = with_mesh_table(result, ratio)
    if fit_file is not None:
        write_fit(film, ratio, fit_file, force)
    deliver(
        NAME,
        result,
        subject,
        figure=validation_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def write_fit(model: ConeModel, ratio: Any, path: Path, force: bool) -> None:
    """Fits the film and writes it; says on standard error how well it fits."""
    from gelcone.continuum.fit import fit_film, write_film

    fitted = fit_film(model, ratio)
    write_film(fitted, path, force=force)
    click.echo(f"{path}: continuum film, {film_errors(fitted)}", err=True)


def split_settings(settings: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The settings of the radius ratio, and those of the model or device."""
    own = tuple(s for s in settings if s.partition("=")[0].strip() == RADIUS_RATIO)
    return own, tuple(s for s in settings if s not in own)


def radius_ratio(own: tuple[str, ...], subject: Subject) -> Any:
    """a/b as given, as the device has it, or the default."""
    given = read_settings(own).get(RADIUS_RATIO)
    if subject.device is None:
        return DEFAULT_RADIUS_RATIO if given is None else given
    if given is not None:
        raise InputError(f"--set {RADIUS_RATIO}: a device has its own; set disc_radius or film_radius")
    return subject.device.disc_radius / subject.device.film_radius


def constant_voltages(voltages: str | None, settings: tuple[str, ...], subject: Subject) -> Array:
    """The voltages that were asked for; else the amplitude that is set or that the device has; else 0."""
    if voltages is not None:
        return np.unique(read_values("--voltages", voltages, "voltage", subject.device))
    is_set = subject.device is not None or any(s.partition("=")[0].strip() == "voltage" for s in settings)
    return np.unique(subject.model.voltage) if is_set else np.zeros(1)


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object. Points are lists over voltages and displacements, over displacements alone at one voltage."""
    result, shown = (
        one.squeeze("constant_voltage") if one.sizes["constant_voltage"] == 1 else one for one in (result, shown)
    )
    common = common_json(result, subject)
    content = {
        **{name: result[name] for name in ("displacement", "constant_voltage", RADIUS_RATIO, *AT_POINTS, *FLAGS)},
        "ending": ending_names(result),
        "largest_deviation": abs(result["deviation"]).max(_points(result)),
        "limit": {
            "share": result["share"],
            "continuum": result["limit_displacement"],
            "cone": result["cone_limit_displacement"],
        },
        "mesh": {n.removeprefix("mesh_"): result[n] for n in map(str, result.variables) if n.startswith("mesh_")},
        "forces": FORCES,
        **{name: value for name, value in common.items() if name != "initial"},
    }
    return content if subject.device is None else content | {"si": si_json(shown, IN_SI)}


def _points(result: xr.Dataset) -> list[str]:
    return [dim for dim in ("constant_voltage", "displacement") if dim in result["deviation"].dims]


def ending_names(result: xr.Dataset) -> Any:
    """How each point's search ended, as names."""
    from gelcone.continuum.path import Ending

    return np.vectorize(lambda code: Ending(code).name.lower(), otypes=[object])(result["ending"].values).tolist()


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What a person reads on the terminal."""
    from gelcone.plots.validation import member_labels

    lines = heading(subject)
    for name, member in member_labels(shown):
        told = [*voltage_lines(member), *limit_lines(member), *mesh_lines(member)]
        lines += [*([f"{name}:"] if name else []), *told]
    return "\n".join(lines)


def voltage_lines(member: xr.Dataset) -> list[str]:
    """At each voltage the deviation of the cone where the film is taut, and what became of it elsewhere."""
    from gelcone.continuum.path import Ending
    from gelcone.words import unit_of

    lines = [
        f"disc over film a/b {float(member[RADIUS_RATIO]):.4g}; cone force over that of the taut continuum, less 1:"
    ]
    for i in range(member.sizes["constant_voltage"]):
        one = member.isel(constant_voltage=i)
        taut = one["deviation"].where(~one["hoop_slack"]).values
        told = "the film is taut nowhere"
        if np.isfinite(taut).any():
            ends = dict.fromkeys((int(np.nanargmin(taut)), int(np.nanargmax(taut))))
            told = " to ".join(f"{taut[k]:+.1%} at {_place(one, k)}" for k in ends)
        lines.append(f"  {float(one['constant_voltage']):.4g}{unit_of(one['constant_voltage'])}: {told}")
        endings = [Ending(code) for code in one["ending"].values]
        wrinkled = int((one["hoop_slack"] & (one["ending"] == Ending.CONVERGED)).sum())
        if wrinkled:
            lines.append(f"    {wrinkled} of {len(endings)}: {HOOP_SLACK}")
        kinds = [ending for ending in Ending if ending and ending in endings]
        lines += [f"    {endings.count(ending)} of {len(endings)}: {ending.meaning}" for ending in kinds]
    return shortened(lines)


def _place(one: xr.Dataset, k: int) -> str:
    from gelcone.words import unit_of

    return f"{float(one['displacement'][k]):.4g}{unit_of(one['displacement'])}"


def limit_lines(member: xr.Dataset) -> list[str]:
    """Where continuum and cone come to shares of the stretch limit."""
    from gelcone.words import unit_of

    lines = []
    for k, share in enumerate(member["share"].values):
        found, cone = (float(member[name][k]) for name in LIMITS)
        if np.isfinite(found):
            unit = unit_of(member["limit_displacement"])
            lines.append(f"  {share:.0%} of the stretch limit at {found:.4g}{unit}, the cone at {cone:.4g}{unit}")
    return ["without voltage the film reaches, beside the disc:", *lines] if lines else []


def mesh_lines(member: xr.Dataset) -> list[str]:
    """The mesh-convergence table."""
    from gelcone.words import unit_of

    if not np.isfinite(member["mesh_force"]).all():
        return []
    place = f"{float(member['mesh_displacement']):.4g}{unit_of(member['mesh_displacement'])}"
    lines = [f"mesh at {place}: elements, error of the force (order), of the shape (order)"]
    for k, count in enumerate(member["mesh_elements"].values):
        one = {n: float(member[f"mesh_{n}"][k]) for n in ("force_error", "force_order", "shape_error", "shape_order")}
        orders = [f" ({one[n]:.2f})" if np.isfinite(one[n]) else "" for n in ("force_order", "shape_order")]
        lines.append(f"  {count:4d}  {one['force_error']:.2e}{orders[0]}  {one['shape_error']:.2e}{orders[1]}")
    return lines
