"""Arguments that several commands share, and those of an analysis, made from its options."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from gelcone.analyses.request import Subject, read_subject
from gelcone.errors import InputError
from gelcone.register.analyses import ANALYSES
from gelcone.register.analysis import Analysis, Axis, Option

SUBJECT = ("device", "preset", "film", "settings", "initial")
OUTPUT = ("out", "force", "as_json")


class Place(click.Path):
    """A file or folder; an empty text is refused."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path that was typed; an empty text fails."""
        if isinstance(value, str) and not value.strip():
            self.fail("is empty; name a file or folder", param, ctx)
        return super().convert(value, param, ctx)


PLACE = Place(path_type=Path)


def subject_parameters(*, starts: bool = True) -> list[click.Parameter]:
    """DEVICE, --preset, --set, --initial and --film; the help leaves out --initial where nothing ``starts`` from it."""
    return [
        click.Argument(["device"], required=False, metavar="[DEVICE]"),
        click.Option(
            ["--preset"],
            metavar="NAME",
            help="Start from a parameter set of the source paper: table1, base, fast or spring.",
        ),
        click.Option(
            ["--set", "settings"],
            multiple=True,
            metavar="NAME=VALUE",
            help="Set a parameter, or a field of the device (`gelcone help device`); may be repeated.",
        ),
        click.Option(
            ["--initial"],
            hidden=not starts,  # refused with a remedy where it is typed
            metavar="X,U",
            help="Initial displacement and velocity (of a device '5 mm,0 m/s'), all states, or some by name=value, "
            "such as 'displacement=5 mm'.",
        ),
        click.Option(
            ["--film"],
            metavar="membrane|wrinkling|taut",
            help="Model of the film. membrane: stretches vary from disc to rim, and it wrinkles (default of devices). "
            "wrinkling: a cone of uniform stretch that wrinkles. taut: such a cone that bears compression, as in the "
            "paper (default without a device). Without a device --set radius_ratio=... is the membrane's a/b, "
            "default 0.2.",
        ),
    ]


DRIVE = ("recording", "drive_scale", "drive_repeat", "drive_interpolation")


def drive_parameters() -> list[click.Parameter]:
    """--drive and what goes with it."""
    return [
        click.Option(
            ["--drive", "recording"],
            type=PLACE,
            metavar="CSV",
            help='Recorded voltage: a table (CSV, .mat, .h5) with the header "time (s), voltage (V)".',
        ),
        click.Option(
            ["--drive-scale"], type=float, metavar="FACTOR", help="Factor on the recorded voltage. Default 1."
        ),
        click.Option(["--drive-repeat"], is_flag=True, default=None, help="Repeat the recorded voltage."),
        click.Option(
            ["--drive-interpolation"], metavar="linear|pchip", help="Interpolation between its samples. Default linear."
        ),
    ]


def help_of(analysis: Analysis) -> str:
    """The help text of an analysis: its purpose, from the docstring of its function, and examples."""
    if analysis.takes in ("plan", "store") or analysis.name == "map":
        text = ANALYSES.summaries[analysis.name]
    else:
        text = inspect.cleandoc(analysis.call.__doc__ or "").split("\n\n")[0].replace("`", "")
    examples = "\n".join(f"gelcone {analysis.command} {example}" for example in analysis.examples)
    return "\n\n".join([text, OF_DEVICE, *([f"\b\n{examples}"] if examples else [])])


OF_DEVICE = (
    "DEVICE is a device file (`gelcone init` writes one) or a name that `gelcone devices` lists. Without one all "
    "numbers are dimensionless."
)
"""The explanation of the first argument of an analysis."""


def samples_parameter() -> click.Parameter:
    """--samples."""
    return click.Option(
        ["--samples"], type=PLACE, metavar="FILE",
        help="Repeat the analysis for every draw of a table: draws.nc, which a fit writes, or a CSV file. Values of a "
        "row belong together, so that correlations are preserved.",
    )  # fmt: skip


HOW_DRAWN = ("count", "method", "seed")


def take_how_drawn(typed: dict[str, Any], file: Path | str | None) -> dict[str, Any]:
    """Take --count, --method and --seed from what was typed; `InputError` if one is given and a ``file`` holds the
    draws."""
    how = {name: typed.pop(name) for name in HOW_DRAWN if name in typed}
    given = [
        name for name in how if click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if file is not None and given:
        raise InputError(f"--{given[0]}: says how draws are made, and {file} holds them; leave it out")
    return how


def uncertain_parameters() -> list[click.Parameter]:
    """--uncertain, and how it is drawn: --count, --method and --seed."""
    return [
        click.Option(
            ["--uncertain"], multiple=True, metavar="NAME=DISTRIBUTION|TABLE",
            help="A parameter that is drawn at every point: low:high (uniform) or mean~deviation (normal, such as "
            "'15 N/m~3%'); may be repeated. Or a table of draws as they come from a fit (.csv, .nc), which may be "
            "correlated.",
        ),
        click.Option(["--count"], type=int, default=64, show_default=True, help="Draws of the uncertain parameters."),
        click.Option(
            ["--method"], default="sobol", show_default=True, help="How they are drawn: sobol or latin-hypercube."
        ),
        click.Option(["--seed"], type=int, default=0, show_default=True, help="Seed of the draws."),
    ]  # fmt: skip


def output_parameters() -> list[click.Parameter]:
    """--out, --force and --json."""
    return [
        click.Option(["--out"], type=PLACE, metavar="DIR", help="Write netCDF and a figure there."),
        click.Option(["--force"], is_flag=True, help="Overwrite results that exist."),
        json_parameter(),
    ]


def json_parameter() -> click.Option:
    """--json."""
    return click.Option(["--json", "as_json"], is_flag=True, help="Print one JSON object instead of text.")


def over_parameter(analysis: Analysis) -> list[click.Parameter]:
    """--over, where the analysis takes it."""
    text = analysis.over or (_axes_help(analysis) if analysis.axes else "")
    option = click.Option(["--over"], multiple=True, metavar="NAME=VALUES", help=text)
    return [option] if text else []


def _axes_help(analysis: Analysis) -> str:
    """The explanation of the axes of an analysis by their names, with the forms of their values."""
    single = all(axis.least == 1 for axis in analysis.axes.values())
    forms = "NAME=from:to:count, NAME=v1,v2,... or NAME=v1" if single else "NAME=from:to:count or NAME=v1,v2,..."
    explanations = [_axis_help(axis, analysis.axis_options[name]) for name, axis in analysis.axes.items()]
    return " ".join([f"Increasing values, {forms}.", *explanations])


def _axis_help(axis: Axis, option: Option) -> str:
    """The explanation of an axis."""
    device_name = "" if axis.of_device == axis.of_model else f"{axis.of_device}, "
    device = f"{device_name}in {_units(option.quantity)}"
    default = option.unset
    if axis.default is not None:
        first, last, count = axis.default
        default = f"{first:g}:{last:g}:{count}, dimensionless"
    explained = f"{option.help[:1].lower()}{option.help[1:-1]}"
    return f"{axis.of_model} (with a device {device}): {explained} [default: {default}]."


def option_parameters(options: Iterable[Option]) -> list[click.Parameter]:
    """Options of analyses; None stands for one that is not given."""
    return [
        click.Option([*option.flags, option.name], is_flag=True, default=None, help=option.help)
        if option.kind is bool
        else click.Option(
            [*option.flags, option.name],
            type=str if option.quantity else PLACE if option.kind is Path else option.kind or str,
            metavar=_metavar(option),
            help=_help(option),
        )
        for option in options
    ]


def _metavar(option: Option) -> str | None:
    """The placeholder of the value in the help; None leaves it to the type."""
    if option.quantity:
        return "VALUE" if option.kind else "VALUES"
    choices = re.findall(r'"(\w+)"', option.help) if option.kind is str else []
    if len(choices) > 1:
        return "|".join(choices)
    return None if option.kind else "VALUES"


def _help(option: Option) -> str:
    """The explanation of an option and its default."""
    default = option.default
    if isinstance(default, list | tuple):
        default = ",".join(map(str, default))
    if isinstance(default, float):
        default = f"{default:g}"
    default = default if option.default is not None else option.unset
    if option.quantity and option.default is not None:
        default = f"{default}, dimensionless"
    text = f"{option.help} With a device in {_units(option.quantity)}." if option.quantity else option.help
    return f"{text}  [default: {default}]" if default else text


def _units(quantity: str) -> str:
    return {"time": "s or ms", "voltage": "V or kV", "frequency": "Hz", "length": "mm or m"}[quantity]


def subject_of(given: dict[str, Any]) -> Subject:
    """Takes the arguments of `subject_parameters` out of ``given`` and reads them."""
    arguments = {name: given.pop(name) for name in SUBJECT}
    drive = {name: value for name in DRIVE if (value := given.pop(name, None)) is not None}
    subject = read_subject(arguments.pop("device"), **arguments)
    return _driven(subject, drive) if drive else subject


def _driven(subject: Subject, drive: dict[str, Any]) -> Subject:
    """A subject driven by the recording that was named."""
    from gelcone.devices.fields import DRIVE_NUMBERS
    from gelcone.devices.recorded import recorded

    path = drive.pop("recording", None)
    if path is None:
        raise InputError(f"--{min(drive).replace('_', '-')}: there is no --drive; name a CSV file")
    fixed = (*DRIVE_NUMBERS, "waveform", "voltage", "voltage_bias", "drive_frequency")
    if taken := sorted(subject.given & set(fixed)):
        raise InputError(f"--set {taken[0]}: the recording of --drive sets it; leave it out, or give --drive-scale")
    options = {name.removeprefix("drive_"): value for name, value in drive.items()}
    if subject.device is None:
        return replace(subject, model=recorded(subject.model, path, **options))
    device = recorded(subject.device, path, **options)
    return replace(subject, model=device.to_model(), device=device)
