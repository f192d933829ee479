"""The command line: arguments in, calls to the library, text or JSON out. One command a file, loaded when called."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import NoReturn

import click

from gelcone._version import __version__

COMMANDS = {
    "paper": "Redraw the source paper's figures and check its claims.",
    "simulate": "How it moves: time response, stresses, energies, validity.",
    "section": "Poincare section: once a drive repeat, or at the turning points.",
    "spectrum": "Amplitude spectrum, its lines and its flatness.",
    "lyapunov": "Both Lyapunov exponents, in a window and in the long run, with errors.",
    "regime": "What kind of motion it is, with the evidence.",
    "static": "Equilibria under constant voltage, pitchfork, folds, pull-in, stroke.",
    "tongues": "Where the drive makes rest unstable: onset voltage and tongues.",
    "bifurcation": "What the motion is along one parameter, and where it changes.",
    "map": "Exponent and regime over two parameters.",
    "sweep": "Any analysis over any parameters, and the probability of chaos.",
    "show": "What the store of a map or sweep holds by now.",
    "basin": "Which motions coexist: the attractor of each initial state.",
    "frequency": "Stroke over drive frequency, swept up and down: resonances and jumps.",
    "envelope": "Where a device is safe to drive, and which limit comes first.",
    "validate": "Is the cone right? Its force against the film as a continuum.",
    "devices": "List the device files that ship.",
    "materials": "List the measured gels that ship.",
}


class LazyGroup(click.Group):
    """Lists every command without importing what it needs."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command: click.Command = import_module(f"gelcone.cli.{name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in COMMANDS:
            from gelcone.errors import unknown_name

            raise unknown_name("command", args[0], COMMANDS)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gelcone")
@click.pass_context
def group(context: click.Context) -> None:
    """Conical PVC-gel actuators, from energy to motion.

    Parameters are set with --set name=value; a value may be a number, a list 0.5,1,1.5 or a range 0:2:5 (from, to,
    how many), which makes an ensemble. A command without a device starts from a dimensionless default.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> None:
    """Runs the command line; errors of the input are one line and exit code 2, an interrupt exits with 130."""
    from gelcone.errors import InputError, MissingDependency

    try:
        code = group.main(standalone_mode=False)
    except click.UsageError as error:
        help_of = error.ctx.command_path if error.ctx else "gelcone"
        _fail(f"{error.format_message().rstrip('.')}; see {help_of} --help", 2)
    except (click.Abort, KeyboardInterrupt):
        print("interrupted", file=sys.stderr)
        sys.exit(130)
    except InputError as error:
        _fail(str(error), 2)
    except (click.ClickException, MissingDependency, OSError) as error:
        _fail(str(error), 1)
    except MemoryError:
        _fail("out of memory; take fewer members or samples", 1)
    sys.exit(code if isinstance(code, int) else 0)


def _fail(message: str, code: int) -> NoReturn:
    print(f"Error: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(code)
