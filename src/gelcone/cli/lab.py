"""`gelcone fit`: measured data in, a fitted material out; and `gelcone datasheet`."""

from __future__ import annotations

import tomllib
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.analyses.answer import bare_answer
from gelcone.cli.command import command_of, run
from gelcone.cli.options import PLACE, output_parameters
from gelcone.cli.output import print_json, progress_bar
from gelcone.errors import InputError
from gelcone.files import check_writable, read_text, write_together
from gelcone.register.analyses import find_analysis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("material.toml", "fit.nc", "fit.png")
REMEDY = "give a TOML file with a table [material]"


def fit_command() -> click.Command:
    """`gelcone fit`."""
    text = """Fit a material to tests on coupons: law and Maxwell branches, chosen by predicting tests left out.

    MATERIAL is a file with what is known without the tests, in a table [material]: name, relative_permittivity,
    dielectric_strength. The data are CSV files as they were exported, or a list of them, tests.toml.

    \b
    gelcone fit material.toml --data tests.toml --out fitted
    gelcone fit material.toml --data tension.csv --data relaxation.csv --laws yeoh --branches 1,2
    """
    params: list[click.Parameter] = [
        click.Argument(["material"], required=False, metavar="[MATERIAL]"),
        click.Option(
            ["--data"], multiple=True, type=PLACE, metavar="FILE",
            help="Measured data: tests.toml, or a CSV file; may be repeated.",
        ),
        click.Option(["--laws"], metavar="NAMES", help="Laws to compare.  [default: all: gent,neo-hookean,yeoh]"),
        click.Option(["--branches"], metavar="COUNTS", help="Numbers of branches to compare.  [default: 0,1,2,3,4]"),
        click.Option(["--flow"], default="log", show_default=True, help="Flow rule of the branches: log or linear."),
        click.Option(["--draws"], type=int, default=60, show_default=True, help="Draws of tests, for intervals."),
        click.Option(["--seed"], type=int, default=0, show_default=True, help="Seed of the draws."),
        *output_parameters(),
    ]  # fmt: skip
    return click.Command("fit", params=params, callback=run_fit, help=text)


def run_fit(
    *, material: str | None, data: tuple[Path, ...], out: Path | None, force: bool, as_json: bool, **options: Any
) -> int:
    """Reads data and material, fits, and prints and writes what was found."""
    from gelcone.analyses.material_fit import fit_json, fit_words
    from gelcone.lab.material import fit_material, fitted_text
    from gelcone.lab.measured import read_tests
    from gelcone.netcdf import write_netcdf
    from gelcone.plots import plot, style

    if not data:
        raise InputError("--data is missing; give tests.toml or a measured CSV file")
    known = _known(material)
    tests = read_tests(*data)
    places = [] if out is None else [out / name for name in FILES]
    check_writable(places, force=force)
    with progress_bar("fit") as progress:
        result = fit_material(
            tests,
            known,
            laws=_words(options["laws"]),
            branches=_counts(options["branches"]),
            flow=options["flow"],
            draws=options["draws"],
            seed=options["seed"],
            progress=progress,
        )
    if places:
        figure, text = plot(result), fitted_text(result)
        writers = (
            lambda to: to.write_text(text, encoding="utf-8"),
            partial(write_netcdf, result),
            partial(style.draw_file, figure),
        )
        write_together(dict(zip(places, writers, strict=True)), force=force)
    if as_json:
        print_json(bare_answer("fit", fit_json(result)))
        return 0
    click.echo(fit_words(result))
    for path in places:
        click.echo(f"wrote {path}")
    return 0


def _known(material: str | None) -> dict[str, Any]:
    """The fields of a material's file."""
    from gelcone.lab.material import known_fields_of

    if material is None:
        return {}
    path = Path(material)
    try:
        content = tomllib.loads(read_text(path, REMEDY))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: broken TOML: {error}; correct it there") from None
    return known_fields_of(path, content)


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
    """`gelcone datasheet`: its figure is a page, which is written as PDF, too."""
    command = command_of(find_analysis("datasheet"))
    command.callback = run_datasheet
    return command


def run_datasheet(*, out: Path | None, force: bool, **typed: Any) -> int:
    """Reads what was typed, computes the sheet and delivers it, with --out also as PDF."""
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
