"""`gelcone fit`: measured data in, a fitted material or device out; and `gelcone datasheet`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.cli.command import command_of, run
from gelcone.cli.options import PLACE, output_parameters, samples_parameter, uncertain_parameters
from gelcone.cli.output import Output, progress_bar, result_files
from gelcone.errors import InputError
from gelcone.files import check_writable, read_text, read_toml, writer_of
from gelcone.register.analyses import find_analysis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("material.toml", "fit.nc", "fit.png")
DEVICE_FILES = ("fit.nc", "fit.png", "device.toml", "draws.nc", "band.csv")
PLAN_FILES = ("plan.nc", "plan.png")
REMEDY = "give a TOML file with a table [material]"


def fit_command() -> click.Command:
    """`gelcone fit`."""
    text = """Fit a material to tests on coupons, or a device to its measurements.

    A material is a file with what is known without the tests, in a table [material]: name, relative_permittivity,
    dielectric_strength. Law and Maxwell branches are chosen by predicting tests left out. The data are CSV files
    as they were exported, or a list of them, tests.toml.

    Of a device the fields that are --free are fitted, each with the standard deviation of its prior, and with them the
    gains of the instruments; --plan says before any test what the tests can determine, and what to measure next. Their
    list is a file that `gelcone init --tests tests.toml` writes to be filled in.

    \b
    gelcone fit material.toml --data tests.toml --out fitted
    gelcone fit material.toml --data tension.csv --data relaxation.csv --laws yeoh --branches 1,2
    gelcone fit pump.toml --data pump-tests.toml --free spring_rate~3% --free material.shear_modulus~50% --plan
    gelcone fit pump.toml --data pump-tests.toml --free spring_rate~3% --films taut,wrinkling --predict "stroke@1.5 kV"
    """
    params: list[click.Parameter] = [
        click.Argument(["subject"], required=False, metavar="[MATERIAL|DEVICE]"),
        click.Option(
            ["--data"], multiple=True, type=PLACE, metavar="FILE",
            help="Measured data: tests.toml, or a CSV file; may be repeated.",
        ),
        click.Option(["--laws"], metavar="NAMES", help="Laws to compare.  [default: all: gent,neo-hookean,yeoh]"),
        click.Option(["--branches"], metavar="COUNTS", help="Numbers of branches to compare.  [default: 0,1,2,3,4]"),
        click.Option(["--flow"], default="log", show_default=True, help="Flow rule of the branches: log or linear."),
        click.Option(["--draws"], type=int, default=60, show_default=True, help="Draws of tests, for intervals."),
        click.Option(["--seed"], type=int, default=0, show_default=True, help="Seed of the draws."),
        click.Option(
            ["--free"], multiple=True, metavar="FIELD[~SD]",
            help="Of a device: a field to fit, and the standard deviation of its prior, 3% or '5 um'; may be repeated.",
        ),
        click.Option(["--plan"], is_flag=True, help="Of a device: what the tests can determine, without fitting."),
        click.Option(["--films"], metavar="NAMES", help="Of a device: films to compare, of taut,wrinkling,membrane."),
        click.Option(
            ["--loss"], metavar="NAMES",
            help="Of a device: losses to compare, of damper,branch,both: damper, Maxwell branch of the film, or both.",
        ),
        click.Option(
            ["--profile"], multiple=True, metavar="FIELD",
            help="Of a device: a free field or gain whose interval is also that of the profile; may be repeated.",
        ),
        click.Option(
            ["--predict", "--next", "predict"], multiple=True, metavar="WHAT",
            help="Of a device: 'stroke@1.5 kV', 'blocked force@1 kV', 'natural frequency@1 kV' or pull-in, with its "
            "standard deviation and the experiments that would lower it most; may be repeated.",
        ),
        *output_parameters(),
    ]  # fmt: skip
    return click.Command("fit", params=params, callback=run_fit, help=text)


OF_MATERIALS = {"laws": None, "branches": None, "flow": "log", "draws": 60, "seed": 0}
"""Options of a material's fit, and their defaults."""
OF_DEVICES = {"free": (), "plan": False, "films": None, "loss": None, "predict": (), "profile": ()}
"""Options of a device's fit."""


def run_fit(
    *, subject: str | None, data: tuple[Path, ...], out: Path | None, force: bool, as_json: bool, **options: Any
) -> int:
    """Reads data and subject, fits, and prints and writes what was found."""
    if not data:
        raise InputError("--data is missing; give tests.toml or a measured CSV file")
    content, output = _content(subject), Output("fit", out, force, as_json)
    other, others = ("a material", OF_MATERIALS) if content is None else ("a device", OF_DEVICES)
    for name, default in others.items():
        if options.pop(name) != default:
            raise InputError(f"--{name}: is an option of the fit of {other}; leave it out")
    if content is not None:
        return _fit_material(subject, content, data, output, options)
    assert subject is not None
    return _fit_device(subject, data, output, options)


def _fit_material(
    subject: str | None, content: dict[str, Any], data: tuple[Path, ...], output: Output, options: dict[str, Any]
) -> int:
    """Fits a material to tests on coupons."""
    from gelcone.analyses.material_fit import fit_json, fit_words
    from gelcone.lab.material import fit_material, fitted_text, known_fields_of
    from gelcone.lab.measured import read_tests

    known = {} if subject is None else known_fields_of(Path(subject), content)
    tests = read_tests(*data)
    output.check(FILES)
    options |= {"laws": _words(options["laws"]), "branches": _counts(options["branches"])}
    with progress_bar("fit") as progress:
        result = fit_material(tests, known, **options, progress=progress)
    material = {"material.toml": writer_of(fitted_text(result))}
    output.deliver(fit_words(result), fit_json(result), material | result_files("fit", result))
    return 0


def _fit_device(subject: str, data: tuple[Path, ...], output: Output, options: dict[str, Any]) -> int:
    """Plans or fits a device; 1 where chi2 refuses the structure."""
    from gelcone.analyses.device_fit import device_fit_json, device_fit_words, device_plan_words
    from gelcone.devices.device import find_device
    from gelcone.lab.device import fit_device, plan_device, read_free
    from gelcone.lab.device_tests import read_device_tests
    from gelcone.lab.fitted import fitted_band, fitted_device, fitted_draws
    from gelcone.netcdf import write_netcdf

    device = find_device(subject)
    if len(data) > 1:
        raise InputError("--data: of a device is one list of tests; put all into one tests.toml")
    tests, free = read_device_tests(data[0]), read_free(options["free"], device)
    films, losses, plan = _words(options["films"]), _words(options["loss"]), options["plan"]
    output.check(PLAN_FILES if plan else DEVICE_FILES)
    if plan:
        for name, given in (("films", films), ("loss", losses)):
            if given is not None and len(given) > 1:
                raise InputError(f"--{name}: a plan is that of one structure; give one")
        one = {"film": films[0] if films else None, "loss": losses[0] if losses else None}
        result = plan_device(device, tests, free, predict=options["predict"], **one)
        words = device_plan_words(result, device)
    else:
        asked = {name: options[name] for name in ("predict", "profile")}
        result = fit_device(device, tests, free, films=films, losses=losses, **asked)
        words = device_fit_words(result, device)
    writers = result_files("plan" if plan else "fit", result)
    if output.out is not None and not plan:
        writers["device.toml"] = writer_of(fitted_device(result).to_toml())
        writers["draws.nc"] = partial(write_netcdf, fitted_draws(result))
        writers["band.csv"] = writer_of(fitted_band(result))
    output.deliver(words, device_fit_json(result), writers)
    return int(result.attrs.get("refused", 0))


def _content(subject: str | None) -> dict[str, Any] | None:
    """The content of a material's file; None for a device."""
    from gelcone.devices.files import shipped_devices

    if subject is None:
        return {}
    path = Path(subject)
    if subject in shipped_devices() and not path.is_file():
        return None
    content = read_toml(path, read_text(path, REMEDY))
    return None if "disc_radius" in content or "film_radius" in content else content


def _words(text: str | None) -> list[str] | None:
    return None if text is None else [word.strip() for word in text.split(",")]


def _counts(text: str | None) -> list[int] | None:
    if text is None:
        return None
    try:
        return [int(word) for word in text.split(",")]
    except ValueError:
        raise InputError(f"--branches = {text[:60]!r}: must be whole numbers, such as 1,2,3") from None


def datasheet_command() -> click.Command:
    """`gelcone datasheet`: its figure is a page, which is written as PDF, too; with the tolerances of draws."""
    command = command_of(find_analysis("datasheet"))
    command.params[-3:-3] = [*uncertain_parameters(), samples_parameter()]
    command.callback = run_datasheet
    return command


def run_datasheet(*, out: Path | None, force: bool, **typed: Any) -> int:
    """Runs the analysis as it was typed, and writes its figure as PDF, too."""
    from gelcone.plots import plot, style

    pages: list[Figure] = []

    def draw(result: Any) -> Figure:
        pages.append(plot(result))
        return pages[-1]

    page = None if out is None else out / "datasheet.pdf"
    check_writable([] if page is None else [page], force=force)
    code = run(find_analysis("datasheet"), out=out, force=force, draw=draw, **typed)
    if page is not None:
        style.save_figure(pages[-1], page, force=force)
        if not typed["as_json"]:
            click.echo(f"wrote {page}")
    return code
