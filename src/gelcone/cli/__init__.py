"""The command line: arguments in, calls to the library, text or JSON out. One command a file, loaded when called."""

from __future__ import annotations

import sys
from importlib import import_module

import click

from gelcone._version import __version__

COMMANDS = {
    "simulate": "How it moves: time response, stresses, energies, validity.",
    "section": "Poincare section: once a drive repeat, or at the turning points.",
    "spectrum": "Amplitude spectrum, its lines and its flatness.",
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


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gelcone")
def group() -> None:
    """Conical PVC-gel actuators, from energy to motion.

    Parameters are set with --set name=value; a value may be a number, a list 0.5,1,1.5 or a range 0:2:5 (from, to,
    how many), which makes an ensemble. A command without a device starts from a dimensionless default.
    """


def main() -> None:
    """Runs the command line; errors of the input are one line and exit code 2, an interrupt exits with 130."""
    from gelcone.errors import InputError, MissingDependency

    try:
        code = group.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        print("interrupted; nothing was written", file=sys.stderr)
        sys.exit(130)
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(2)
    except MissingDependency as error:
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(1)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(141)
    sys.exit(code if isinstance(code, int) else 0)
