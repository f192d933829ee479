"""The contract of components: a name, parameters by name, and formulas that run on any kind of number.

Films, biases, waveforms, circuits and strain-energy laws are components. Their parameters are the model's parameters,
which can be set, swept, drawn, saved and shown without another line. Their formulas take numbers by
name (``n``) and the functions of a namespace (``xp``: ``sin``, ``cos``, ``exp``, ``log``, ``log1p``, ``sqrt``), so that
the same line runs on floats, NumPy arrays, SymPy symbols and the expressions of the compiled program.
"""

from __future__ import annotations

import dataclasses
from abc import ABC
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar, TypeVar

import numpy as np

from gelcone import permission
from gelcone.errors import InputError, unknown_name
from gelcone.physics.contract import (
    DEFAULTS,
    ONE_EACH,
    PLACES,
    Trial,
    check_data,
    check_formulas,
    check_overrides,
    listed,
    numbers_of,
    points_of,
    ships,
    written,
)
from gelcone.quantity import Quantity

Numbers = Mapping[str, Any]
"""Numbers of the formulas, by name: floats, arrays, symbols or expressions."""


@dataclass(frozen=True)
class State:
    """A state that a component adds to displacement and velocity.

    Parameters
    ----------
    name : its name, in results and among initial values.
    meaning : in words.
    quantity : the quantity whose SI scale converts it. Default ``"share"``, a pure number.
    start : its value at the start of a run that gives displacement and velocity alone. Default 0.
    mirrored : whether it changes sign in the mirror image x -> -x. Default no.

    Examples
    --------
    >>> import gelcone
    >>> charge = gelcone.State("charge", "charge on the film", "charge")
    >>> charge.name, charge.start
    ('charge', 0.0)
    """

    name: str
    meaning: str
    quantity: str = "share"
    start: float = 0.0
    mirrored: bool = False


class Component(ABC):
    """One part of an actuator; a frozen dataclass where it holds numbers or parts of its own.

    A new component supplies a ``name``, its ``parameters`` (flat name -> `Quantity`) and the formulas of its kind.
    Equal components share a compiled program, also between processes, so all that its formulas depend on must be
    a parameter or a field.

    Examples
    --------
    >>> import gelcone
    >>> gelcone.Gent().parameters["stretch_limit"].default, isinstance(gelcone.Sine(), gelcone.Component)
    (50.0, True)
    """

    name: ClassVar[str]
    states: tuple[State, ...] = ()

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        """The parameters, by their flat names. A class attribute will do. Default none."""
        return {}

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """Compute the numbers of the formulas from the parameters, once for each member. Default: the parameters."""
        return {name: parameters[name] for name in self.parameters}

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        """Initial values of the states that it adds, in a run from the displacement x. Default: `State.start`."""
        return [state.start for state in self.states]

    @property
    def number_names(self) -> tuple[str, ...]:
        """The names of `numbers`, in their order."""
        return tuple(self.numbers(self.complete({})))

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Raise `InputError` where the class does not fulfil its contract: where a formula is missing, takes other
        arguments, fails, returns something else, contradicts another or cannot be compiled. Called at the
        default parameters, and at two points near them; ``given`` are the parameters that differ from their
        defaults."""
        check_overrides(self)
        check_data(self, State, Quantity)
        n = numbers_of(self, given)[1]
        count = len(self.states)
        check_formulas(self, [Trial("starts", (PLACES, n), listed(count)), Trial("time_constant", (n,), ONE_EACH)])

    def time_constant(self, n: Numbers) -> Any:
        """Slowest time constant of the states that it adds; motions settle within 20 of it. Default 0: no states."""
        return 0.0

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check the ``given`` parameters and fill in the defaults of the others."""
        return {
            name: quantity.check(name, given.get(name, quantity.default)) for name, quantity in self.parameters.items()
        }

    def __getstate__(self) -> dict[str, Any]:
        return uncached(self)

    def __eq__(self, other: object) -> bool:
        """Compare class and fields, so that equal components share a compiled program, also between processes. Cached
        properties do not count: components are keys of caches, and must not become equal later."""
        return self is other or (type(self) is type(other) and uncached(self) == uncached(other))

    def __hash__(self) -> int:
        return hash(type(self))

    def __repr__(self) -> str:
        """The class and the fields of the component, the same in each process, for keys of the disk cache."""
        held = ", ".join(f"{name}={value!r}" for name, value in self.__getstate__().items())
        return f"{type(self).__module__}.{type(self).__qualname__}({held})"


def uncached(holder: object) -> dict[str, Any]:
    """Return the attributes to pickle, without those of a `cached_property`, which may hold closures."""
    holder_class = type(holder)
    return {
        name: v
        for name, v in vars(holder).items()
        if not isinstance(getattr(holder_class, name, None), cached_property)
    }


C = TypeVar("C", bound=Component)


# --- components in files ---------------------------------------------------------------------------------------------


def to_record(component: Component, shipped: Mapping[str, Component]) -> Any:
    """The component as plain data: its name, or a table with its ``component`` and its fields.

    One that does not ship is named by module and class, ``"module:Class"``.
    """
    ships = type(shipped.get(component.name)) is type(component)
    name = component.name if ships else _class_name(component)
    fields = {f.name: _plain(getattr(component, f.name)) for f in _fields(component)}
    return {"component": name, **fields} if fields else name


def from_record(kind: str, record: Any, shipped: Mapping[str, C], base: type[C]) -> C:
    """Make the component that `to_record` wrote; ``kind`` names it in messages.

    Raises `InputError` for an unknown name, for a class that cannot be imported or does not take the fields, and for
    one that does not ship where `gelcone.permission` does not allow it.
    """
    fields = dict(record) if isinstance(record, Mapping) else {"component": record}
    name = fields.pop("component", None)
    if not isinstance(name, str):
        raise InputError(f"{kind} = {record!r}: must be the name of a {kind}: {', '.join(shipped)}")
    if name in shipped:
        part_class: type[Any] = type(shipped[name])
    elif ":" in name:
        part_class = _imported(kind, name)
        if not issubclass(part_class, base):
            raise InputError(f"{kind} {name!r}: is not a {kind}; derive its class from gelcone.{base.__name__}")
        permission.check_data(kind, name, {f.name: fields[f.name] for f in _fields(part_class) if f.name in fields})
    else:
        raise unknown_name(kind, name, shipped)
    if missing := sorted(getattr(part_class, "__abstractmethods__", ())):
        raise InputError(f"{kind} {name!r}: its class lacks {' and '.join(missing)}; {written(part_class, missing[0])}")
    try:
        values = {f.name: _value(fields[f.name]) for f in _fields(part_class) if f.name in fields}
        component: C = part_class(**values)
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{kind} {name!r}: its numbers do not fit its class ({error}); use the version that wrote it"
        ) from None
    return component


def find_component(kind: str, given: Any, shipped: Mapping[str, C], base: type[C]) -> C:
    """Return a component that is given as an instance or as its record; `InputError` for anything else, for one that
    cannot be compared with another, and where its formulas contradict one another."""
    if isinstance(given, str | Mapping):
        given = from_record(kind, given, shipped, base)
    if isinstance(given, base):
        _check_comparable(given)
        _proved(given)
        return given
    raise InputError(f"{kind} = {given!r}: must be a {kind} or the name of one: {', '.join(shipped)}")


def _check_comparable(component: Component) -> None:
    """Raise `InputError` for a component that holds arrays or lists: it must be a key of caches."""
    arrays = [name for name, value in uncached(component).items() if isinstance(value, np.ndarray)]
    if arrays:
        raise InputError(f"{component.name}: {arrays[0]} is an array; hold a tuple of numbers, tuple(values.tolist())")
    try:
        hash(component)
    except TypeError as error:
        raise InputError(
            f"{component.name}: cannot be compared with another component ({error}); make its class a frozen "
            "dataclass, @dataclass(frozen=True), that holds tuples in place of lists"
        ) from None


_PROVEN: set[tuple[type[Component], str]] = set()


def _proved(component: Component) -> None:
    """Prove a component and its parts once, unless it ships."""
    for value in uncached(component).values():
        for part in _flat(value):
            _proved(part)
    key = type(component), repr(component)
    if key not in _PROVEN and not ships(component):
        component.prove()
        for given in points_of(component):
            try:
                component.prove(given)
            except InputError as error:
                at = ", ".join(f"{name} = {value:.4g}" for name, value in given.items())
                raise InputError(f"{error} (it is right at the defaults, and wrong at {at})") from None
        _PROVEN.add(key)


def _fields(component: Any) -> tuple[Any, ...]:
    return dataclasses.fields(component) if dataclasses.is_dataclass(component) else ()


def _plain(value: Any) -> Any:
    """A field as plain data: a component becomes its record, a tuple a list."""
    if isinstance(value, Component):
        return {"nested": to_record(value, {})}
    if isinstance(value, tuple | list):
        return [_plain(part) for part in value]
    return value


def _value(data: Any) -> Any:
    if isinstance(data, Mapping) and data.keys() == {"nested"}:
        return from_record("component", data["nested"], {}, Component)
    return tuple(_value(part) for part in data) if isinstance(data, list | tuple) else data


def names_of(component: Component) -> set[str]:
    """The permissions of `gelcone.permission` that reading a component and its parts needs: the names of their classes
    in files, ``"module:Class"``, and their records."""
    data = {f.name: getattr(component, f.name) for f in _fields(component)}
    class_name, parts = _class_name(component), [part for value in data.values() for part in _flat(value)]
    plain = permission.record(class_name, {name: _plain(value) for name, value in data.items()})
    return {class_name, plain}.union(*map(names_of, parts))


def _flat(value: Any) -> list[Component]:
    values = value if isinstance(value, tuple | list) else [value]
    return [part for part in values if isinstance(part, Component)]


def _class_name(component: Component) -> str:
    return f"{type(component).__module__}:{type(component).__qualname__}"


def _imported(kind: str, name: str) -> type[Any]:
    permission.check(kind, name)
    module, _, path = name.partition(":")
    try:
        imported: Any = import_module(module)
        for part in path.split("."):
            imported = getattr(imported, part)
    except (ImportError, AttributeError) as error:
        where = "a script or notebook" if module == "__main__" else f"the module {module!r}"
        raise InputError(
            f"{kind} {name!r}: cannot be imported ({error}); it was defined in {where}: put its class into a module "
            "that Python finds (in this folder or on PYTHONPATH) under that name"
        ) from None
    if not isinstance(imported, type):
        raise InputError(f"{kind} {name!r}: is not a class; give the component itself")
    return imported
