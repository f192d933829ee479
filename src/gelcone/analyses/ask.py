"""Asking an analysis: what was typed becomes its arguments, and its result text and JSON."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from gelcone.analyses import tables
from gelcone.analyses.request import Subject, measure_reader, read_measures
from gelcone.errors import DoubtfulInput, InputError
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Answers:
    """How a command answers: ``words`` and ``json``, the ``result`` of the JSON object, both of the result as it is
    shown, in the units of a device, and of the subject."""

    command: str
    words: Callable[[xr.Dataset, Subject], str]
    json: Callable[[xr.Dataset, Subject], dict[str, Any]]


def answers_of(analysis: Analysis) -> Answers:
    """How the command of an analysis answers."""
    home = import_module(f"gelcone.analyses.{analysis.answers}")
    words, as_json = (
        getattr(home, f"{analysis.name}_{form}", getattr(tables, f"table_{form}")) for form in ("words", "json")
    )
    return Answers(analysis.command, words, as_json)


def arguments_of(analysis: Analysis, subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments of the public function, besides the model, for a subject and the values typed.

    Raises `InputError` for values that cannot be used.
    """
    for one, other in analysis.exclusive:
        if one in given and other in given:
            raise InputError(f"--{one} and --{other} are both given; give one of them")
    if analysis.single:
        subject.alone(analysis.command)
    given = {**given, **read_options(analysis, subject, given)}
    if told := subject.model.film.doubt():
        warnings.warn(told, DoubtfulInput, stacklevel=2)
    reader = getattr(import_module(f"gelcone.analyses.{analysis.answers}"), f"{analysis.name}_arguments", None)
    arguments: dict[str, Any] = reader(subject, given) if reader else dict(given)
    if analysis.axes:
        arguments |= subject.axes(arguments.pop("over", ()), analysis)
    if "radius_ratio" in analysis.options and subject.device is not None:
        from gelcone.devices.analysis import radius_ratio_of

        arguments.setdefault("radius_ratio", radius_ratio_of(subject.device))
    if "initial" in analysis.signature.parameters:
        arguments["initial"] = subject.beginning if analysis.planned else subject.initial
        warn_at_rest(subject)
    else:
        subject.without_initial(f"{analysis.command} does not start from a state; leave it out")
    return arguments


def warn_at_rest(subject: Subject) -> None:
    """Says where a device starts from a rest that nothing leaves."""
    if subject.device is not None and not subject.starts:
        from gelcone.devices.analysis import at_rest

        if told := at_rest(subject.device, subject.initial):
            warnings.warn(told, DoubtfulInput, stacklevel=2)


def read_options(analysis: Analysis, subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """Options of an analysis that measure something, read from their texts: in SI for a plan, else dimensionless.

    A number that is none is dimensionless.
    """
    texts = {name for name, value in given.items() if isinstance(value, str)}
    measured = {name: option for name, option in analysis.options.items() if option.quantity and name in texts}
    numbers: dict[str, Any] = {}
    for name, option in measured.items():
        shown, text = option.flags[0], str(given[name])
        if option.kind is None:
            numbers[name] = read_measures(shown, text, option.quantity, subject.device, in_si=analysis.planned)
        else:
            numbers[name] = measure_reader(option.quantity, subject.device, in_si=analysis.planned)(shown, text.strip())
    return numbers
