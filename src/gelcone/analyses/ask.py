"""Asking an analysis: what was typed becomes its arguments, and its result text and JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gelcone.register.analysis import Analysis, load

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.subject import Subject


@dataclass(frozen=True)
class Answers:
    """How a command answers: ``words`` of a result as it is shown, in SI units for a device, and the subject; ``json``
    of the dimensionless result, the result as it is shown, and the subject: the ``result`` of the JSON object."""

    command: str
    words: Callable[[xr.Dataset, Subject], str]
    json: Callable[[xr.Dataset, xr.Dataset, Subject], dict[str, Any]]


def answers_of(analysis: Analysis) -> Answers:
    """How the command of an analysis answers."""
    words, as_json = (load(f"{analysis.answers}:{analysis.name}_{form}") for form in ("words", "json"))
    return Answers(analysis.command, words, as_json)


def arguments_of(analysis: Analysis, subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments of the public function, besides the model, for a subject and the values typed.

    Raises `InputError` for values that cannot be used.
    """
    if analysis.single:
        subject.alone(analysis.command)
    arguments: dict[str, Any] = load(analysis.reader)(subject, given) if analysis.reader else dict(given)
    if "initial" in analysis.signature.parameters:
        arguments["initial"] = subject.initial
    return arguments
