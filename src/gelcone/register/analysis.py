"""What an analysis is: its public function, and what sweeps, command line and figures need to know of it.

An `Analysis` holds names only and loads what they stand for when it is used: it stands on the ground floor, and every
folder may read the register without importing what is above it. Its options are read from the signature
and the docstring of the public function, so that Python, sweeps, stores and the command line share names, defaults and
explanations.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from gelcone.errors import InputError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

NOT_OPTIONS = (
    *("model", "plan", "path", "store", "over", "parameter", "values", "low", "high", "event", "initial", "progress"),
)
"""Parameters of public functions that say what is computed, or that make no difference to it."""
QUANTITIES: Mapping[str, str] = {
    **dict.fromkeys(("transient", "patience", "budget", "window", "times"), "time"),
    **dict.fromkeys(
        ("voltages", "peaks", "tongues.highest", "onset_voltage.highest", "pitchfork_voltage.returns"), "voltage"
    ),
    "frequencies": "frequency",
    **dict.fromkeys(("displacements", "start"), "length"),
    **dict.fromkeys(("continue_branch.start", "locus.start"), ""),
}
"""Options that have a unit with a device, by their names (of one analysis: behind its name) -> the quantity."""
_KINDS: Mapping[str, type] = {"float": float, "int": int, "bool": bool, "str": str}


@dataclass(frozen=True)
class Option:
    """An option of an analysis: its name, its default, its type (None: text to be read), and a line of explanation.

    ``unset`` says what happens by default where ``default`` is None. ``quantity`` is what it measures, with a device in
    SI units; empty for a pure number.
    """

    name: str
    default: Any
    kind: type | None
    help: str
    unset: str
    quantity: str = ""


@dataclass(frozen=True)
class Analysis:
    """An analysis of one model, or of every cell of a sweep.

    Attributes
    ----------
    name, summary : what it is called in Python and on the command line, and a line about it.
    function : the public function, as ``module:name`` below ``gelcone``.
    answers : the module with ``NAME_words``, the text, and ``NAME_json``, the object, of a result.
    cells : the function of one cell that the public function calls too, for sweeps; none where it cannot be swept.
    kinds : variables, of small whole numbers, that tell kinds of cells apart; a map is refined where they change.
    bulky : variables that a sweep leaves out unless it is asked to keep them, because they hold many values a cell.
    over : help text of ``--over``; empty where the command takes none.
    from_over : keywords that ``--over`` sets instead of an option of their own.
    reader : the function that makes keyword arguments of a subject and the values typed; none where these are the
        options as they are.
    called : its name on the command line, where that is not the function's.
    single : whether it takes one model only, no ensemble.
    exclusive : pairs of options of which one is given at most.
    planned : whether it makes a plan of what it is given, and so takes the device in place of its model.
    examples : command lines, without ``gelcone`` and the name.
    """

    name: str
    summary: str
    function: str
    answers: str
    cells: str | None = None
    kinds: tuple[str, ...] = ()
    bulky: tuple[str, ...] = ()
    over: str = ""
    from_over: tuple[str, ...] = ()
    reader: str | None = None
    called: str = ""
    single: bool = False
    exclusive: tuple[tuple[str, str], ...] = ()
    planned: bool = False
    examples: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The name on the command line."""
        return self.called or self.name.replace("_", "-")

    @property
    def call(self) -> Callable[..., xr.Dataset]:
        """The public function."""
        return load(self.function)

    @property
    def compute(self) -> Callable[..., Any]:
        """The function of cells: (members, states, **options) -> findings; `InputError` where there is none."""
        if self.cells is None:
            raise InputError(f"{self.name}: cannot be swept; use gelcone.{self.name}")
        return load(self.cells)

    @cached_property
    def signature(self) -> inspect.Signature:
        """That of the public function."""
        return inspect.signature(self.call)

    @cached_property
    def options(self) -> Mapping[str, Option]:
        """The options by name, in the order of the signature."""
        explained = explanations(self.call.__doc__ or "")
        return {
            name: _option(self.name, name, parameter, explained.get(name, ""))
            for name, parameter in self.signature.parameters.items()
            if name not in (*NOT_OPTIONS, *self.from_over)
        }

    def settings(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """All options that decide a cell's numbers, those not given at their defaults.

        Raises `InputError` for a name that is not an option (with the nearest that is) and for a value that is no
        number where one is needed.
        """
        known = {name: option for name, option in self.options.items() if name != "threads"}
        for name in given:
            if name not in known:
                raise unknown_name(f"option of the analysis {self.name}", name, known)
        return {name: _checked(option, given.get(name, option.default)) for name, option in known.items()}


def load(reference: str) -> Any:
    """What a ``module:name`` below ``gelcone`` stands for."""
    module, _, name = reference.partition(":")
    return getattr(import_module(f"gelcone.{module}"), name)


def quantity_of_option(analysis: str, name: str) -> str:
    """What an option of an analysis measures; empty for a pure number."""
    return QUANTITIES.get(f"{analysis}.{name}", QUANTITIES.get(name, ""))


def _option(analysis: str, name: str, parameter: inspect.Parameter, explanation: str) -> Option:
    default = None if parameter.default is inspect.Parameter.empty else parameter.default
    kind = _KINDS.get(str(parameter.annotation).removesuffix("| None").strip())
    unset = default_of(explanation) if default is None else ""
    return Option(name, default, kind, first_sentence(explanation), unset, quantity_of_option(analysis, name))


def _checked(option: Option, value: Any) -> Any:
    """A value of an option, a whole number as a float where the option is one."""
    if value is None or option.kind not in (float, int):
        return value
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise InputError(f"{option.name} = {value!r}: must be a number")
    if option.kind is int:
        if int(value) != value:
            raise InputError(f"{option.name} = {value}: must be a whole number")
        return int(value)
    return value if isinstance(value, float) else float(value)


@cache
def explanations(docstring: str) -> dict[str, str]:
    """Name -> explanation, from the section "Parameters" of a docstring; "as in `x`" is looked up there."""
    lines = inspect.cleandoc(docstring).splitlines()
    if "Parameters" not in lines:
        return {}
    found: dict[str, list[str]] = {}
    names: Sequence[str] = ()
    for line in lines[lines.index("Parameters") + 2 :]:
        if re.fullmatch(r"-{3,}", line):  # the heading of the next section has been taken for text
            break
        begin = re.match(r"(\w+(?:, \w+)*) : (.*)", line)
        if begin:
            names = begin[1].split(", ")
            found |= {name: [begin[2]] for name in names}
        elif line.startswith(" "):
            for name in names:
                found[name].append(line.strip())
        else:
            names = ()
    return {name: _looked_up(name, " ".join(parts)) for name, parts in found.items()}


def _looked_up(name: str, explanation: str) -> str:
    """An explanation, or the one of the public function that it refers to."""
    other = re.match(r"as in `(?:gelcone\.)?(\w+)`", explanation)
    if other is None:
        return explanation
    function = getattr(import_module("gelcone"), other[1])
    return explanations(function.__doc__ or "").get(name, explanation)


def first_sentence(explanation: str) -> str:
    """The first sentence of an explanation, as a help text."""
    text = re.split(r"[.;] |[.;]$", explanation.replace("`", ""))[0]
    text = re.sub(r"[,;:]? ?\bdefault\b.*", "", text)
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def default_of(explanation: str) -> str:
    """What an explanation says of the default."""
    stated = re.search(r"\bdefault:? (.*?)(?:[.;] |[.;]$|$)", explanation.replace("`", ""), flags=re.IGNORECASE)
    return stated[1] if stated else ""
