"""Proofs of components: each formula of a contract is called at a few sets of numbers when its class is read."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.differentiate import derivative, gradients
from gelcone.quantity import Array

FUNCTIONS = ("sin", "cos", "exp", "log", "log1p", "sqrt")
"""The functions of the namespace ``xp``."""
PLACES = np.linspace(-1.5, 1.5, 9)
"""Displacements, and phases, at which formulas are called."""
MEMBERS = 2
"""Number of members whose numbers formulas are called with."""
GRID = np.tile(PLACES, (MEMBERS, 1))
"""The places of each member."""
DEFAULTS: Mapping[str, Any] = MappingProxyType({})
"""No parameter that differs from its default."""
NEAR, SOME = 1.27, 0.1
"""Factor between the defaults and the points near them at which components are proved, and the number in place of a
default of 0 or infinity."""
ODD = "correct it, or write def odd(self, n): return False"
_PACKAGE = __name__.partition(".")[0]


class Trial(NamedTuple):
    """A call of a formula with ``arguments``, and what the formula ``must`` return: a check of a value, and its words.

    ``must`` is one of `NUMBERS`, `ONE_EACH`, `PAIR`, `TEXT` and `NAMED`, or that of `listed`.
    """

    formula: str
    arguments: Sequence[Any]
    must: tuple[Callable[[Any], bool], str]


def _numeric(value: Any, shape: tuple[int, ...]) -> bool:
    """Whether a value is a number or an array that broadcasts to a shape."""
    try:
        array = np.asarray(value)
        return array.dtype.kind in "biufc" and np.broadcast_shapes(array.shape, shape) == shape
    except ValueError:
        return False


def _several(value: Any, count: int) -> bool:
    shape = GRID.shape
    return isinstance(value, tuple | list) and len(value) == count and all(_numeric(one, shape) for one in value)


NUMBERS = (lambda value: _numeric(value, GRID.shape), "one number for each member and displacement")
ONE_EACH = (lambda value: _numeric(value, (MEMBERS, 1)), "one number for each member")
PAIR = (lambda value: _several(value, 2), "two, a value and its derivative by x, for each member and displacement")
TEXT = (lambda value: isinstance(value, str), "a text")
NAMED = (
    lambda value: isinstance(value, Mapping) and _several(list(value.values()), len(value)),
    "a mapping of names to numbers",
)


def listed(count: int, of: str = "states") -> tuple[Callable[[Any], bool], str]:
    """The ``must`` of a formula that returns a list of numbers, one for each of ``count`` states or others."""
    return lambda value: _several(value, count), f"a list of {count}, one for each of its {of}"


def ships(component: Any) -> bool:
    """Whether the class of a component ships with gelcone, whose tests prove it."""
    return type(component).__module__.partition(".")[0] == _PACKAGE


def wrong(component: Any, formula: str, problem: str, remedy: str) -> InputError:
    """The error for a formula of a component's class: class, formula, problem and remedy."""
    return InputError(f"{type(component).__qualname__}.{formula}: {problem}; {remedy}")


def check_overrides(component: Any) -> None:
    """Raise `InputError` where a user-defined class has a value in place of a method of its contract or the reverse, a
    method that takes other arguments, or a value of another type."""
    classes = [base for base in type(component).__mro__ if base.__module__.partition(".")[0] == _PACKAGE]
    for name in (name for name in dir(component) if not name.startswith("_")):
        stated = inspect.getattr_static(component, name)
        contract = next((vars(base)[name] for base in classes if name in vars(base)), None)
        if contract is None or stated is contract:
            continue
        if inspect.isfunction(contract):
            _check_method(component, name, contract)
        elif inspect.isfunction(stated):
            remedy = f"write {name} = ..., or put @property before"
            raise wrong(component, name, "is a method, and must be a value", remedy)
        elif isinstance(contract, bool | tuple) and not isinstance(getattr(component, name), type(contract)):
            kind = "True or False" if isinstance(contract, bool) else "a tuple"
            shown = reprlib.repr(getattr(component, name))
            raise wrong(component, name, f"is {shown}, and must be {kind}", "correct it")


def _check_method(component: Any, name: str, contract: Any) -> None:
    """Raise `InputError` for what is not a method with the arguments of the ``contract``."""
    arguments = list(inspect.signature(contract).parameters)
    method, remedy = getattr(component, name), written(type(component), name, contract)
    if not callable(method):
        value = f": return {method!r}" if isinstance(method, bool | int | float) else ""
        raise wrong(component, name, f"is {reprlib.repr(method)}, and must be a method", remedy + value)
    try:
        inspect.signature(method).bind(*arguments[1:])
    except TypeError:
        taken = ", ".join(inspect.signature(method).parameters)
        raise wrong(component, name, f"takes ({taken}), and must take ({', '.join(arguments[1:])})", remedy) from None


def written(own: type[Any], name: str, contract: Any = None) -> str:
    """The remedy for a method that a class lacks: how it is written."""
    arguments = inspect.signature(contract or getattr(own, name)).parameters
    return f"write def {name}({', '.join(arguments)})"


def called(component: Any, formula: str, *arguments: Any) -> Any:
    """Call a formula; raise `InputError` where it fails."""
    try:
        with np.errstate(all="ignore"):
            return getattr(component, formula)(*arguments)
    except InputError:
        raise
    except KeyError as error:
        problem = f"reads {error}, which is not one of its numbers"
        raise wrong(component, formula, problem, "list it in parameters, or correct it") from error
    except Exception as error:
        problem = f"fails ({type(error).__name__}: {error})"
        raise wrong(component, formula, problem, "correct it; it takes numbers and arrays of them") from error


def check_formulas(component: Any, trials: Sequence[Trial]) -> None:
    """Call each formula of a contract; raise `InputError` for one that fails or returns something else."""
    for formula, arguments, (fits, words) in trials:
        value = called(component, formula, *arguments)
        if not fits(value):
            raise wrong(component, formula, f"returns {reprlib.repr(value)}", f"return {words}")


def points_of(component: Any) -> list[dict[str, float]]:
    """Parameters at two points near the defaults, inside their bounds; without those that the component refuses."""
    points = []
    for sign in (1.0, -1.0) if component.parameters else ():
        given = {
            name: max(NEAR ** (sign * (-1.0) ** k) * _size(quantity.default), quantity.lower)
            for k, (name, quantity) in enumerate(component.parameters.items())
        }
        try:
            component.complete(given)
        except InputError:
            continue
        points.append(given)
    return points


def _size(default: float) -> float:
    """A default, or a number in place of one that no factor changes."""
    return default if default != 0.0 and np.isfinite(default) else SOME


def numbers_of(component: Any, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The numbers of a component at its default parameters, but for those ``given``: of one member, and of `MEMBERS`
    equal ones, with an axis for displacements."""
    given = called(component, "complete", given)
    one = called(component, "numbers", given)
    many = called(component, "numbers", {name: np.full(MEMBERS, value) for name, value in given.items()})
    return dict(one), {
        name: np.reshape(value, (MEMBERS, 1)) if np.shape(value) == (MEMBERS,) else value
        for name, value in many.items()
    }


def check_data(component: Any, state: type[Any], quantity: type[Any]) -> None:
    """Raise `InputError` for a component without a name, and for states and parameters of another kind."""
    if not isinstance(getattr(component, "name", None), str):
        raise wrong(component, "name", "is missing, and must be a text", 'write name = "..." in the class')
    if not all(isinstance(one, state) for one in component.states):
        raise wrong(component, "states", f"is {reprlib.repr(component.states)}", "give a tuple of gelcone.State")
    named = component.parameters
    if not isinstance(named, Mapping) or not all(isinstance(one, quantity) for one in named.values()):
        raise wrong(component, "parameters", f"is {reprlib.repr(named)}", "give names and their gelcone.Quantity")


def compiled(component: Any, what: str, differentiate: Callable[[], Any]) -> Any:
    """Return what ``differentiate`` does; raise `InputError` where a formula cannot be differentiated and compiled."""
    try:
        with np.errstate(all="ignore"):
            return differentiate()
    except (TypeError, AttributeError) as error:
        problem = f"a formula cannot be differentiated and compiled ({error})"
        functions = ", ".join(f"xp.{name}" for name in FUNCTIONS)
        remedy = f"take arithmetic, powers and the functions of its argument xp ({functions}), not those of NumPy"
        raise wrong(component, what, problem, remedy) from None


def same_formula(
    component: Any, what: str, at: Array, stated: Any, true: Callable[[], Any], remedy: str = "correct its formula"
) -> None:
    """Raise `InputError`, which ends in the ``remedy``, where the values ``stated`` by a formula at the places ``at``
    differ from the ``true`` ones."""
    expected = np.broadcast_to(compiled(component, what, true), np.shape(at))
    differs = ~np.isclose(stated, expected, rtol=1e-6, atol=1e-9) & np.isfinite(expected)
    if differs.any():
        k = int(np.argmax(differs))
        one = float(np.broadcast_to(stated, np.shape(at))[k])
        raise wrong(component, what, f"it is {one:.6g} at {at[k]:.3g}, and must be {expected[k]:.6g}", remedy)


def check_slope(
    component: Any,
    force: Callable[[Any, list[Any], Any], tuple[Any, Any]],
    y: Sequence[Any],
    odd: bool,
    borders: bool = False,
) -> None:
    """Raise `InputError` where the second value of ``force(x, y, xp)`` is not the derivative of the first by x, without
    states and with the states ``y`` at `PLACES`, and where the first is not ``odd`` although it is said to be. With
    ``borders`` the flat film, which may lie on one, is left out."""
    for states in ([], list(y)):
        slope = compiled(component, "force", partial(force, PLACES, states, np))[1]
        same_formula(
            component, "force, its slope at a displacement", PLACES, slope, partial(_slope, force, states, borders)
        )
    if odd:
        value = np.broadcast_to(force(PLACES, [], np)[0], PLACES.shape)
        same_formula(component, "force, odd in x, at a displacement", PLACES, value, lambda: -value[::-1], ODD)


def _slope(force: Callable[..., tuple[Any, Any]], y: list[Any], borders: bool) -> Any:
    """The derivative of a force by x at `PLACES`; NaN where it is not compared."""
    slope = derivative(lambda at, xp: force(at, y, xp)[0], PLACES)
    return np.where(borders & (PLACES == 0.0), np.nan, slope)


def check_numbers(component: Any, formula: str, values: Sequence[Any]) -> None:
    """Raise `InputError` where a formula returns NaN at one of `PLACES`."""
    missing = np.any([np.isnan(np.broadcast_to(value, PLACES.shape)) for value in values], axis=0)
    if missing.any():
        problem = f"is NaN at x = {PLACES[int(np.argmax(missing))]:.3g}"
        ends = f"from {PLACES[0]:g} to {PLACES[-1]:g}"
        remedy = f"return a finite number for every x {ends} (continue a root beyond its end)"
        raise wrong(component, formula, problem, remedy)


def check_rates(component: Any, count: int, rates: Callable[[list[Any], Any], list[Any]]) -> None:
    """Raise `InputError` where the rates of displacement, velocity and ``count`` states cannot be compiled."""
    compiled(component, "rates", lambda: gradients(rates, [PLACES] * (2 + count)))
