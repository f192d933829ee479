"""The command of an analysis, made from what the register says of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gelcone.analyses.answer import check_folder
from gelcone.analyses.ask import answers_of, arguments_of, drawn_answers
from gelcone.analyses.draws import drawn_options, read_draws, read_samples, table_among
from gelcone.cli.options import (
    drive_parameters,
    help_of,
    option_parameters,
    output_parameters,
    over_parameter,
    samples_parameter,
    subject_of,
    subject_parameters,
    take_how_drawn,
)
from gelcone.cli.output import deliver, progress_bar
from gelcone.devices.analysis import check_one, device_words, plain
from gelcone.devices.files import shipped_devices
from gelcone.errors import InputError
from gelcone.plots import plot
from gelcone.register.analyses import find_analysis
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gelcone.analyses.request import Subject


def command_of(analysis: Analysis) -> click.Command:
    """The command that runs an analysis."""
    device, *subject = subject_parameters(starts="initial" in analysis.signature.parameters)
    if analysis.arguments:
        device = click.Argument(["words"], nargs=-1, metavar=" ".join(["[DEVICE]", *analysis.arguments.values()]))
    options = option_parameters(analysis.options.values())
    drive = drive_parameters() if analysis.takes in ("model", "device") else []
    samples = [samples_parameter()] if analysis.drawn or (analysis.swept and analysis.takes == "model") else []
    params = [device, *subject, *drive, *over_parameter(analysis), *options, *samples, *output_parameters()]
    return click.Command(analysis.command, params=params, callback=partial(run, analysis), help=help_of(analysis))


def _in_places(analysis: Analysis, words: tuple[str, ...]) -> dict[str, str | None]:
    """The arguments of a command by their names, the device first where one is given."""
    places = list(analysis.arguments)
    form = " ".join(["[DEVICE]", *analysis.arguments.values()])
    if len(words) == len(places):
        if words[0].endswith(".toml") or words[0] in shipped_devices():
            arguments = [*analysis.arguments.values()]
            missing = arguments[0] if len(arguments) == 1 else f"one of {', '.join(arguments)}"
            raise InputError(
                f"{analysis.command}: takes {form}, and behind the device {words[0]} {missing} is missing, as in "
                f"gelcone {analysis.command} {analysis.examples[0]}"
            )
        return {"device": None, **dict(zip(places, words, strict=True))}
    if len(words) == 1 + len(places):
        return dict(zip(["device", *places], words, strict=True))
    raise InputError(f"{analysis.command}: takes {form}, not {len(words)} words: {' '.join(words) or 'none'}")


def run(
    analysis: Analysis,
    *,
    out: Path | None,
    force: bool,
    as_json: bool,
    draw: Callable[..., Figure] = plot,
    **typed: Any,
) -> int:
    """Reads what was typed, runs the analysis, of draws where they are given, and delivers its result, drawn by
    ``draw``."""
    if analysis.arguments:
        typed |= _in_places(analysis, typed.pop("words"))
    subject, samples, uncertain = subject_of(typed), typed.pop("samples", None), typed.pop("uncertain", ())
    how = take_how_drawn(typed, samples or table_among(uncertain))
    given = {name: value for name, value in typed.items() if value is not None}
    if uncertain or samples is not None:
        draws = (
            read_samples(samples, uncertain, subject)
            if samples is not None
            else read_draws(uncertain, subject, indices=False, **how)
        )
        return _run_draws(analysis, subject, draws, given, out=out, force=force, as_json=as_json, draw=draw)
    arguments = arguments_of(analysis, subject, given)
    check_folder(out, analysis.command, force)
    with progress_bar(analysis.command) as progress:
        if "progress" in analysis.signature.parameters:
            arguments["progress"] = progress
        with subject.axes_as_typed(given.get("over", ()), analysis), device_words(subject.device):
            result = plain(analysis.call)(subject.target if analysis.planned else subject.model, **arguments)
    return deliver(answers_of(analysis), result, subject, out, force, as_json, draw)


def _run_draws(
    analysis: Analysis, subject: Subject, draws: dict[str, Any], given: dict[str, Any], *, out: Path | None, **how: Any
) -> int:
    """Runs an analysis of every draw, and delivers what they show."""
    from gelcone.atlas.drawn import over_draws

    starts = "initial" in analysis.signature.parameters
    if not starts:
        subject.without_initial(f"{analysis.command} does not start from a state; leave it out")
    check_one(subject.model, analysis.command)
    options = drawn_options(analysis, subject, given)
    answers = answers_of(find_analysis("sweep") if analysis.swept else analysis)
    answers = drawn_answers(analysis.name) if analysis.drawn else answers
    check_folder(out, answers.command, how["force"])
    start = subject.beginning if starts and (subject.starts or subject.device is None) else None
    words = subject.axes_as_typed(given.get("over", ()), analysis), device_words(subject.device)
    with progress_bar(analysis.command) as progress, words[0], words[1]:
        result = over_draws(subject.target, draws, analysis.name, initial=start, progress=progress, **options)
    return deliver(answers, result, subject, out, **how)
