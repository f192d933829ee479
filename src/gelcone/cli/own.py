"""`gelcone init` and `gelcone help`: a device file to fill in, and what its fields mean."""

from __future__ import annotations

from pathlib import Path

import click

from gelcone import glossary
from gelcone.cli.options import PLACE
from gelcone.errors import InputError, unknown_name

START = "biased-pump"
"""The device whose numbers a first file starts from."""
TOPICS = ("device", "units", "glossary")


def init_command() -> click.Command:
    """`gelcone init`."""
    text = """Write a first device file: every field with its unit, its meaning and its usual range.

    With --wish: what a device must do, for `gelcone design`. With --tests: a list of tests on a device, for
    `gelcone fit`.

    \b
    gelcone init mine.toml
    gelcone simulate mine.toml --out results
    gelcone init --wish wish.toml
    gelcone design wish.toml --out designs
    gelcone init --tests mine-tests.toml
    gelcone fit mine.toml --data mine-tests.toml --free spring_rate~3% --plan
    """
    params: list[click.Parameter] = [
        click.Argument(["file"], type=PLACE, metavar="FILE"),
        click.Option(["--wish"], is_flag=True, help="What a device must do, in place of a device."),
        click.Option(["--tests"], is_flag=True, help="A list of tests on a device, in place of a device."),
        click.Option(["--force"], is_flag=True, help="Overwrite a file that exists."),
    ]
    return click.Command("init", params=params, callback=write_first_file, help=text)


def write_first_file(*, file: Path, wish: bool, tests: bool, force: bool) -> None:
    """Write the file; an existing one only with ``force``."""
    from gelcone.devices.device import find_device
    from gelcone.devices.template import first_file
    from gelcone.files import write_whole, writer_of
    from gelcone.lab.device_tests import FIRST_TESTS
    from gelcone.lab.wish import FIRST_WISH

    if wish and tests:
        raise InputError("--wish and --tests: give one of them")
    device = find_device(START)
    text = FIRST_WISH.format(file=file) if wish else first_file(str(file), device, device.material)
    text = FIRST_TESTS.format(file=file) if tests else text
    write_whole(file, writer_of(text), force=force)
    command = f"design {file} --out designs" if wish else f"simulate {file}"
    command = f"fit DEVICE --data {file} --free spring_rate~3% --plan" if tests else command
    click.echo(f"wrote {file}: change its numbers, then `gelcone {command}`")


def help_command() -> click.Command:
    """`gelcone help`."""
    text = """Explain a subject: `device` lists the fields of a device, `units` the units, `glossary` the terms of
    figures and tables; or one of these fields or terms; or a command.

    \b
    gelcone help device
    gelcone help film_thickness
    gelcone help glossary
    gelcone help pull-in
    gelcone help simulate
    """
    form = "[device|FIELD|units|glossary|TERM|COMMAND]"
    params: list[click.Parameter] = [click.Argument(["topic"], required=False, metavar=form)]
    return click.Command("help", params=params, callback=explain, help=text)


def explain(*, topic: str | None) -> None:
    """Prints what is known of a subject."""
    context = click.get_current_context()
    group = context.find_root()
    assert isinstance(group.command, click.Group)
    if topic is None:
        click.echo(group.get_help())
    elif (subject := topic.lower()) == "device":
        from gelcone.devices.device import Device
        from gelcone.devices.template import field_table

        click.echo(field_table(Device.fields))
    elif subject == "units":
        from gelcone.devices.template import unit_table

        click.echo(unit_table())
    elif subject == "glossary":
        click.echo("\n".join(map(glossary.explain, glossary.GLOSSARY)))
    elif not (explanations := [*_of_terms(topic), *_of_commands(topic, group)] or _fields_called(topic)):
        from gelcone.devices.device import Device

        subjects = [*TOPICS, *group.command.list_commands(group), *glossary.GLOSSARY, *Device.fields]
        raise unknown_name("subject of help", topic, subjects, "`gelcone help glossary` lists the terms")
    else:
        click.echo("\n\n".join(explanations))


def _of_terms(topic: str) -> list[str]:
    """The help on a term and on a field of a device, of those that have this name."""
    term = glossary.find_term(topic)
    return [text for text in (term and glossary.explain(term), _field(topic)) if text]


def _of_commands(topic: str, context: click.Context) -> list[str]:
    """The help of the command of this name, if there is one."""
    assert isinstance(context.command, click.Group)
    name = topic.replace("_", "-")
    command = context.command.get_command(context, name)
    return [command.get_help(click.Context(command, info_name=name, parent=context))] if command else []


def _field(topic: str) -> str | None:
    """The help on a field of a device, or None."""
    from gelcone.devices.device import Device
    from gelcone.devices.template import field_help

    return field_help(Device.fields, topic.lower().replace("-", "_"))


def _fields_called(topic: str) -> list[str]:
    """The help on the fields for which people use this name."""
    from gelcone.devices.fields import DEVICE_FIELDS

    name = topic.lower().replace("-", "_").replace(" ", "_")
    return [text for field_name, field in DEVICE_FIELDS.items() if name in field.near and (text := _field(field_name))]
