"""The command line: arguments in, an analysis out. Commands are made from the register when they are called."""

from __future__ import annotations

import re
import shlex
import sys
from importlib import import_module
from itertools import pairwise
from typing import NoReturn

import click

from gelcone._version import __version__
from gelcone.cli.waiting import said_before, warned
from gelcone.register import analyses

OWN_COMMANDS = {
    "studio": ("A page in the browser in which every control answers at once.", "studio:studio_command"),
    "paper": ("Redraw the source paper's figures and check its claims.", "paper:paper_command"),
    "fit": ("A material from tests on coupons, or a device from its measurements.", "lab:fit_command"),
    "design": ("Designs that meet requirements in spite of tolerances.", "design:design_command"),
    "measured": ("Measured devices against what is predicted of them.", "measured:measured_command"),
    "export": (
        "A device as FMU, C or WebAssembly; a result as tables (CSV, Parquet) or for MATLAB.",
        "export:export_command",
    ),
    "init": ("Write a first device file, every field explained, to be filled in.", "own:init_command"),
    "help": ("Explain a subject: the fields of a device, a term, or a command.", "own:help_command"),
    "devices": ("List the device files that ship, or print one.", "lists:devices_command"),
    "materials": ("List the measured gels that ship.", "lists:materials_command"),
}
"""Commands that are not an analysis: the line in the list of commands, and who makes them."""
SPECIAL = {
    "continue": "branches:continue_command",
    "datasheet": "lab:datasheet_command",
    "locus": "branches:locus_command",
    "map": "grids:map_command",
    "sweep": "grids:sweep_command",
    "show": "grids:show_command",
}
"""Commands that take more than their analysis declares, and who makes them."""
COMMANDS = {
    "paper": OWN_COMMANDS["paper"][0],
    "studio": OWN_COMMANDS["studio"][0],
    **{command: analyses.ANALYSES.summaries[name] for command, name in analyses.COMMANDS.items()},
    **{name: summary for name, (summary, _) in OWN_COMMANDS.items()},
}

SECTIONS = {
    "Begin": "init devices materials help studio",
    "How it moves": "simulate step creep transfer settled frequency extrema section spectrum triptych",
    "Periodic or chaotic": "regime lyapunov basin tongues bifurcation continue locus",
    "Force, stroke and limits": "static film limits operating-limits envelope drive datasheet",
    "Many parameters": "map sweep show",
    "Measured data and design": "fit measured design",
    "Other tools, and checks": "export paper validate",
}
"""The commands in the order in which help lists them, by what one asks."""
QUIET = ("studio", "paper")
"""Commands that say themselves, in their own way, what one waits for."""
WIDEST_NAME = max(map(len, COMMANDS))


class LazyGroup(click.Group):
    """Lists every command without importing what it needs."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import and make a command; None for an unknown name."""
        if name not in COMMANDS:
            return None
        if place := OWN_COMMANDS[name][1] if name in OWN_COMMANDS else SPECIAL.get(name):
            module, _, maker = place.partition(":")
            command: click.Command = getattr(import_module(f"gelcone.cli.{module}"), maker)()
            return command
        from gelcone.cli.command import command_of

        return command_of(analyses.find_analysis(analyses.COMMANDS[name]))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that was typed, with ``_`` read as ``-``; an unknown one is refused with the nearest name."""
        args = [args[0].replace("_", "-"), *args[1:]]
        if args[0] not in COMMANDS:
            from gelcone.errors import unknown_name

            raise unknown_name("command", args[0], COMMANDS)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in the sections of the help."""
        for title, names in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(WIDEST_NAME), COMMANDS[name]) for name in names.split()])


@click.group(cls=LazyGroup, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gelcone")
@click.pass_context
def group(context: click.Context) -> None:
    """Conical PVC-gel actuators, from energy to motion.

    Begin with a device: `gelcone init mine.toml` writes a file to fill in, `gelcone simulate mine.toml` runs it,
    `gelcone help device` lists its fields and `gelcone help glossary` explains the terms of figures and tables. A field
    is changed with --set "film_thickness=0.3 mm"; a list "500 V,800 V" or a range "0 V:800 V:5" (from, to, how many)
    makes an ensemble. Without a device all numbers are dimensionless.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())
    elif context.invoked_subcommand not in QUIET:
        context.with_resource(said_before(context.invoked_subcommand))


def main() -> None:
    """Runs the command line; errors of the input are a line each and exit code 2, an interrupt exits with 130."""
    try:
        _main()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


def _main() -> None:
    import warnings

    from gelcone.errors import DoubtfulInput, InputError, LostWorker, MissingDependency

    warnings.showwarning = _say_warning
    warnings.simplefilter("default", DoubtfulInput)
    warnings.simplefilter("always", LostWorker)
    sys.path.append("")  # user-defined components are found in this folder, behind all that is installed
    try:
        code = group.main(prog_name="gelcone", standalone_mode=False)
    except click.UsageError as error:
        _fail(_said(error), 2)
    except click.Abort:
        raise KeyboardInterrupt from None
    except InputError as error:
        _fail(str(error), 2)
    except (click.ClickException, MissingDependency, OSError) as error:
        _fail(str(error), 1)
    except MemoryError:
        _fail("out of memory; use fewer members or samples", 1)
    sys.exit(code if isinstance(code, int) else 0)


def _fail(message: str, code: int) -> NoReturn:
    for line in message.splitlines():
        print(f"Error: {' '.join(as_typed(line, sys.argv[1:]).split())}", file=sys.stderr)
    sys.exit(code)


_PART = r" [\w.]+(?: = [^:]*)?| '[^']*'"
"""The part of an option that a message is about: a field, or the text of one of several."""


def as_typed(message: str, typed: list[str]) -> str:
    """A message about an option by its name in Python, ``margin = 2.0: ...``, as it was typed, ``--margin 2: ...``."""
    for word, after in pairwise([*typed, ""]):
        option, given, value = word.partition("=")
        name = re.escape(option[2:].replace("-", "_"))
        if not option.startswith("--") or not (match := re.match(rf"{name}( = [^:]*|{_PART})?(?=: )", message)):
            continue
        typed_value, part = value if given else after, match[1] or ""
        again = sum(other.partition("=")[0] == option for other in typed) > 1
        part = f" {shlex.quote(typed_value)}" if part.startswith(" = ") and not again else part
        return f"{option}{part}{message[match.end() :]}"
    return message


def _said(error: click.UsageError) -> str:
    """An error of usage with its remedy: the axis that ``--over`` takes for a keyword of Python, the command that takes
    options of grids and draws, the option that begins as the one typed, or where options are explained."""
    name = analyses.COMMANDS.get((error.ctx and error.ctx.info_name) or "")
    option, analysis = getattr(error, "option_name", ""), analyses.ANALYSES[name] if name else None
    if analysis and (axis := analysis.axes.get(option[2:])):
        with_device = "" if axis.of_device == axis.of_model else f", with a device --over {axis.of_device}=..."
        return f"No such option {option!r}; give --over {axis.of_model}=...{with_device}"
    if analysis and option == "--over" and analysis.arguments:
        form = " ".join(["[DEVICE]", *analysis.arguments.values()])
        return f"No such option {option!r}; gelcone {analysis.command} takes {form}"
    if analysis and analysis.swept and option in ("--over", "--uncertain"):
        remedy = f"gelcone sweep --analysis {name} takes it"
    elif analysis and analysis.drawn and option == "--uncertain":
        return f"No such option {option!r}; give a table of draws, --samples FILE"
    elif analysis and option in ("--uncertain", "--samples"):
        *first, last = _takers(option)
        return f"No such option {option!r}; gelcone {', '.join(first)} and {last} take it"
    elif longer := _beginning(option, error.ctx):
        return f"No such option {option!r}; did you mean {longer[0]!r}?"
    else:
        remedy = f"see {error.ctx.command_path if error.ctx else 'gelcone'} --help"
    return f"{error.format_message().rstrip('.')}; {remedy}"


def _takers(option: str) -> list[str]:
    """The commands that have an ``option``."""
    commands = (group.get_command(click.Context(group), name) for name in COMMANDS)
    return [
        str(command.name)
        for command in commands
        if command and any(option in parameter.opts for parameter in command.params)
    ]


def _beginning(option: str, context: click.Context | None) -> list[str]:
    """The options of a command that begin with the words of an ``option``, which are nearer than those of like
    letters: --lowest-frequency to --lowest."""
    options = [name for parameter in (context.command.params if context else ()) for name in parameter.opts]
    return [name for name in options if option and name.startswith(f"{option}-")]


def _say_warning(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    """A warning of gelcone as one line, without the place in the source, on the error stream and for JSON. Those of
    libraries are not for users."""
    from gelcone.errors import DoubtfulInput, LostWorker

    if not issubclass(category, DoubtfulInput | LostWorker):
        return
    line = " ".join(as_typed(str(message), sys.argv[1:]).split())
    warned().append(line)
    print(f"Warning: {line}", file=sys.stderr)
