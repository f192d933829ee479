"""Asking an analysis: what was typed becomes its arguments, and its result text and JSON."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses import tables
from gelcone.analyses.answer import in_si, result_json, shown_states
from gelcone.analyses.lab import lab_answer
from gelcone.analyses.request import Subject
from gelcone.analyses.values import read_measure, read_measures
from gelcone.devices.analysis import at_rest, check_one
from gelcone.errors import DoubtfulInput, InputError, check_result
from gelcone.register.analyses import find_analysis
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device


@dataclass(frozen=True)
class Answers:
    """The answer of a command: ``words``, its text, and ``json``, the ``result`` of its JSON object.

    Both take the result as it is shown, in the units of a device.
    """

    command: str
    words: Callable[[xr.Dataset, Subject], str]
    json: Callable[[xr.Dataset], dict[str, Any]] = result_json


TITLES: Mapping[str, str] = {
    "time response": "simulate",
    "step": "step",
    "creep": "creep",
    "transfer functions": "transfer",
    "triptych": "triptych",
    "Poincare section": "section",
    "extrema": "extrema",
    "spectrum": "spectrum",
    "Lyapunov exponents": "lyapunov",
    "regime of motion": "regime",
    "statics": "static",
    "film": "film",
    "cone and continuum": "validate",
    "limits": "limits",
    "settled motion": "settled",
    "operating limits": "operating_limits",
    "instability tongues of rest": "tongues",
    "bifurcation diagram": "bifurcation",
    "branches": "continue_branch",
    "locus": "locus",
    "parameter map": "map",
    "sweep": "sweep",
    "basins of attraction": "basin",
    "frequency response": "frequency",
    "operating envelope": "envelope",
    "best drive": "drive",
    "data sheet": "datasheet",
}
"""Title of a result, up to a colon -> the analysis that gave it."""
DRAWS = "draws"
"""The title of an analysis of every draw, which its attribute names."""


def answer_to(result: xr.Dataset) -> tuple[Answers, Subject]:
    """The answers of the command that gave a result, and its subject; `InputError` for another Dataset."""
    title = str(result.attrs.get("title", "")).partition(":")[0]
    from gelcone.dataset import model_of
    from gelcone.devices.si import device_of

    if "model" not in result.attrs:
        raise InputError(
            f"the result is {title or 'none of gelcone'!r}, which has no words; read its variables in Python"
        )
    answers = _answers_to(title, result)
    device = device_of(result)
    initial = _initial_of(result, device)
    if device is not None:
        return answers, Subject(device.to_model(), device, initial)
    values = json.loads(result.attrs["model"])  # what a sweep varies has a value there too, an ensemble's has none
    return answers, Subject(
        model_of(result.drop_vars([name for name in result.coords if name in values])), None, initial
    )


def _answers_to(title: str, result: xr.Dataset) -> Answers:
    """The answers of the command that gave a result of this title; of another the numbers by their names."""
    if title == DRAWS:
        return drawn_answers(result.attrs["analysis"])
    if title in TITLES:
        return answers_of(find_analysis(TITLES[title]))
    return Answers(re.sub(r"\W+", "-", title.lower()), tables.any_words)


def in_words(result: xr.Dataset) -> str:
    """Return what the command that gives such a result prints, or the numbers of a result that no command gives.

    Parameters
    ----------
    result : a Dataset that an analysis returned or `gelcone.load` read.

    Returns
    -------
    The text, in the units of the result's device.

    Raises
    ------
    InputError : for a Dataset that is not a result of gelcone.

    Examples
    --------
    >>> import gelcone
    >>> words = gelcone.in_words(gelcone.limits(gelcone.ConeModel()))
    >>> words.splitlines()[0], words.count("1.2247")
    ('cone model, dimensionless', 1)
    """
    check_result("in_words", result)
    if (lab := lab_answer(result)) is not None:
        return lab[0]()
    answers, subject = answer_to(result)
    return answers.words(in_si(result, subject), subject)


def _initial_of(result: xr.Dataset, device: Device | None) -> Any:
    """The initial state of a result, dimensionless; of one that states none the device's own, or None."""
    stated = json.loads(result.attrs["options"]).get("initial")
    if device is None:
        return result["initial"].values[..., :2] if "initial" in result else stated
    if "initial" in result:
        return result["initial"].values[..., :2] / shown_states(device)
    scales = np.stack(np.broadcast_arrays(device.scales.length, device.scales.velocity), axis=-1)
    return device.initial_state() if stated is None else stated / scales


def answers_of(analysis: Analysis) -> Answers:
    """The answers of the command of an analysis."""
    home = import_module(f"gelcone.analyses.{analysis.answers}")
    words = getattr(home, f"{analysis.name}_words", tables.table_words)
    as_json = getattr(home, f"{analysis.name}_json", partial(result_json, left_out=analysis.file_only))
    return Answers(analysis.command, words, as_json)


def drawn_answers(analysis: str) -> Answers:
    """The answers, about draws, of the command of an analysis over an axis of its own."""
    from gelcone.analyses.drawn import over_draws_words

    analysis_entry = find_analysis(analysis)
    return Answers(analysis_entry.command, over_draws_words, partial(result_json, left_out=analysis_entry.file_only))


def arguments_of(analysis: Analysis, subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments of the public function, besides the model, for a subject and the values typed.

    Raises `InputError` for values that cannot be used.
    """
    if analysis.single:
        check_one(subject.model, analysis.command)
    given = {**given, **read_options(analysis, subject, given, in_si=analysis.planned)}
    reader = getattr(import_module(f"gelcone.analyses.{analysis.answers}"), f"{analysis.name}_arguments", None)
    arguments: dict[str, Any] = reader(subject, given) if reader else given
    if analysis.axes:
        arguments |= subject.axes(arguments.pop("over", ()), analysis)
    if "initial" in analysis.signature.parameters:
        arguments["initial"] = subject.beginning if analysis.planned else subject.initial
        warn_at_rest(subject)
    else:
        subject.without_initial(f"{analysis.command} does not start from a state; leave it out")
    return arguments


def warn_at_rest(subject: Subject) -> None:
    """Says where a device starts from a rest that nothing leaves."""
    if subject.device is not None and not subject.starts and (named := at_rest(subject.device, subject.initial)):
        warnings.warn(named, DoubtfulInput, stacklevel=2)


def read_options(
    analysis: Analysis, subject: Subject, given: Mapping[str, Any], *, in_si: bool = False
) -> dict[str, Any]:
    """Options of an analysis that measure something, read from their texts: dimensionless or, with a device, ``in_si``.

    A value that is not a text is dimensionless.
    """
    numbers: dict[str, Any] = {}
    for name, option in analysis.options.items():
        if option.quantity and isinstance(text := given.get(name), str):
            read = read_measures if option.kind is None else read_measure
            numbers[name] = read(option.flags[0], text.strip(), option.quantity, subject.device, in_si=in_si)
    return numbers
