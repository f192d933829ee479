"""An analysis as it is declared: a public function, and what sweeps and commands need to know beyond it.

The decorator `gelcone.devices.analysis.analysis` makes the declaration where the function is written. Names, types and
defaults of options come from its signature, their quantities from annotations such as `gelcone.quantity.Time`, and
their explanations from the section "Parameters" of its docstring, each written there alone.
"""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

from gelcone.errors import InputError, check_names

if TYPE_CHECKING:
    import xarray as xr

NOT_OPTIONS = ("model", "plan", "path", "store", "over", "parameter", "values", "initial", "progress")
"""Parameters of public functions that say what is computed, or that make no difference to it."""
_KINDS: Mapping[str, type] = {"float": float, "int": int, "bool": bool, "str": str, "str | Path": Path}


@dataclass(frozen=True)
class Axis:
    """An axis of an analysis, whose values ``--over`` gives.

    Attributes
    ----------
    of_model : its name for a model.
    of_device : its name for a device.
    replaces : whether it replaces the actuator's value, which then must not be set.
    default : from where to where, in how many steps, it runs by default; None where the function decides.
    least : the number of values that it takes at least.
    one : the command that answers at one value, where two are the least.
    """

    of_model: str
    of_device: str
    replaces: bool = False
    default: tuple[float, float, int] | None = None
    least: int = 2
    one: str = ""

    def name(self, of_device: bool) -> str:
        """The name on the command line, with a device or without one."""
        return self.of_device if of_device else self.of_model


CONSTANT_VOLTAGE = Axis("constant_voltage", "constant_voltage", least=1)


@dataclass(frozen=True)
class Option:
    """An option of an analysis: its name, its default, its type (None: text to be read), and a line of explanation.

    ``unset`` says what happens by default where ``default`` is None. ``quantity`` is what it measures, with a device in
    SI units; empty for a pure number. ``flags`` are those of the command line.
    """

    name: str
    default: Any
    kind: type | None
    help: str
    unset: str
    quantity: str
    flags: tuple[str, ...]


@dataclass(frozen=True)
class Analysis:
    """An analysis of one model, or of every cell of a sweep.

    Attributes
    ----------
    call : the public function.
    answers : the module of `gelcone.analyses` with ``NAME_words``, the text of a result, and ``NAME_arguments``, which
        reads what was typed; what it lacks follows from the labels of the result.
    file_only : variables of many values, which files hold and JSON does not.
    kinds : variables, of small whole numbers, that distinguish kinds of cells; a map is refined where they change.
    bulky : variables that a sweep leaves out unless it is asked for them, because they hold many values a cell.
    over : help text of ``--over``; empty where the command takes none, or takes the ``axes``.
    axes : keyword -> the axis that ``--over`` sets.
    arguments : keyword -> what stands for it in the help, of arguments in the order of the command line.
    flags : keyword -> flags of the command line, where they are not ``--`` and the keyword.
    swept : whether it can be asked of every cell of a sweep, by the function ``NAME_cells`` of its module.
    drawn : whether its command takes draws, each a run of its own, though it cannot be swept.
    single : whether it takes one model only, no ensemble.
    takes : what its first argument is: ``model``, which a device is turned into; ``device``, or a model, of which it
        makes a plan; ``plan``; or ``store``.
    examples : command lines, without ``gelcone`` and the name.
    """

    call: Callable[..., xr.Dataset]
    answers: str = "tables"
    file_only: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    bulky: tuple[str, ...] = ()
    over: str = ""
    axes: Mapping[str, Axis] = field(default_factory=dict)
    arguments: Mapping[str, str] = field(default_factory=dict)
    flags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    swept: bool = False
    drawn: bool = False
    single: bool = False
    takes: str = "model"
    examples: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        return attrgetter("analysis"), (self.call,)

    @property
    def name(self) -> str:
        """The name in Python."""
        return self.call.__name__

    @property
    def planned(self) -> bool:
        """True for an analysis that makes a plan, and so takes the device in place of its model."""
        return self.takes == "device"

    @property
    def command(self) -> str:
        """The name on the command line."""
        return command_name(self.name)

    @property
    def compute(self) -> Callable[..., Any]:
        """The function of cells: (members, states, **options) -> findings; `InputError` where there is none."""
        if not self.swept:
            raise InputError(
                f"{self.name}: cannot be swept; run `gelcone {self.command}` (in Python gelcone.{self.name})"
            )
        return getattr(import_module(self.call.__module__), f"{self.name}_cells")

    @cached_property
    def signature(self) -> inspect.Signature:
        """The signature of the public function."""
        return inspect.signature(self.call)

    @cached_property
    def options(self) -> Mapping[str, Option]:
        """The options by name, in the order of the signature."""
        others = (*NOT_OPTIONS, *self.arguments, *self.axes)
        names = (name for name in self.signature.parameters if name in self.flags or name not in others)
        return {name: self._option(name) for name in names}

    @cached_property
    def axis_options(self) -> Mapping[str, Option]:
        """Keyword of an axis -> it as an option, in the order in which the axes are declared."""
        return {name: self._option(name) for name in self.axes}

    @property
    def quantities(self) -> Mapping[str, str]:
        """Option or keyword of an axis -> the quantity that it measures; empty for a pure number."""
        return {name: option.quantity for name, option in {**self.options, **self.axis_options}.items()}

    def _option(self, name: str) -> Option:
        default = self.signature.parameters[name].default
        default = None if default is inspect.Parameter.empty else default
        explanation, unset = explanations(self.call).get(name, ("", ""))
        type_, quantity = annotation_of(self.call, name)
        flags = self.flags.get(name, (f"--{name.replace('_', '-')}",))
        return Option(name, default, type_, explanation, unset if default is None else "", quantity, flags)

    def settings(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """All options that decide a cell's numbers, those not given at their defaults.

        Raises `InputError` for a name that is not an option (with the nearest that is) and for a value that is not a
        number where one is needed.
        """
        known = {name: option for name, option in self.options.items() if name != "threads"}
        check_names(f"option of the analysis {self.name}", given, known)
        return {name: _checked(option, given.get(name, option.default)) for name, option in known.items()}


def command_name(name: str) -> str:
    """The command of a public function; Python reserves the word ``continue``."""
    return "continue" if name == "continue_branch" else name.replace("_", "-")


@cache
def annotation_of(function: Callable[..., Any], name: str) -> tuple[type | None, str]:
    """The type of a parameter (None: not a plain number or text), and the quantity that it measures, or empty."""
    function = inspect.unwrap(function)
    text = str(function.__annotations__.get(name, "")).removesuffix(" | None")
    alias = function.__globals__.get(text)
    if get_origin(alias) is not Annotated:
        return _KINDS.get(text), ""
    value_type, quantity = get_args(alias)
    return (value_type if value_type is float else None), quantity


@cache
def explanations(function: Callable[..., Any]) -> Mapping[str, tuple[str, str]]:
    """Parameter -> what it is, as a sentence, and what its default is, both from the docstring.

    An entry reads ``names : explanation. Default what is taken.``; ``as in `other` `` takes that of another public
    function.
    """
    lines = iter(inspect.cleandoc(function.__doc__ or "").splitlines())
    entries: dict[str, str] = {}
    for line in lines:
        if line == "Parameters":
            break
    next(lines, "")
    for line in lines:
        if not line.strip():
            break
        names, is_entry, text = line.partition(" : ")
        if line.startswith(" ") or not is_entry:
            entries[list(entries)[-1]] += f" {line.strip()}"
        else:
            entries[names] = text
    return {name: _explanation(name, text) for names, text in entries.items() for name in names.split(", ")}


def _explanation(name: str, text: str) -> tuple[str, str]:
    """The first sentence of an entry of a docstring, and what it says of the default."""
    if text.startswith("as in `"):
        import gelcone

        other, _, remainder = text.removeprefix("as in `").partition("`")
        said, default = explanations(getattr(gelcone, other.removeprefix("gelcone."))).get(name, ("", ""))
        return said, remainder.partition("Default ")[2].strip().rstrip(".") or default
    text = f"{text} ".replace("`", "").replace("; default ", ". Default ").replace(". Default: ", ". Default ")
    sentences = text.replace("; ", ". ").split(". ")
    default = next((s.removeprefix("Default ") for s in sentences if s.startswith("Default ")), "")
    return f"{sentences[0][:1].upper()}{sentences[0][1:].rstrip('. ')}.", default.rstrip(". ")


def check_number(name: str, value: Any) -> None:
    """`InputError` for a value of an option that is not a number."""
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise InputError(f"{name} = {reprlib.repr(value)}: must be a number, without a unit")


def check_flag(name: str, value: Any) -> None:
    """`InputError` for a value of an option that is neither true nor false."""
    if not isinstance(value, bool):
        raise InputError(f"{name} = {reprlib.repr(value)}: must be True or False")


def _checked(option: Option, value: Any) -> Any:
    """A value of an option, a whole number as a float where the option is one."""
    if option.kind is bool:
        check_flag(option.name, value)
    if value is None or option.kind not in (float, int):
        return value
    check_number(option.name, value)
    if option.kind is int:
        if int(value) != value:
            raise InputError(f"{option.name} = {value}: must be a whole number")
        return int(value)
    return value if isinstance(value, float) else float(value)
