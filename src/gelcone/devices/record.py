"""Records of named fields in SI units: a field is declared once; its checks, its help and its file text follow."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, ClassVar

import numpy as np

from gelcone.devices.units import FieldError, format_range, format_si, parse_many

REQUIRED: Any = object()
"""Default of a required field."""
LARGEST = 1e20
"""Largest size of a value in SI, so that squares and products do not overflow."""


@dataclass(frozen=True)
class Field:
    """A field of a record: its meaning, unit, default and bounds.

    Attributes
    ----------
    meaning : its meaning, in a few words.
    unit : its SI unit, a key of `gelcone.devices.units.DIMENSIONS` (``"1"``: pure number); empty for a text.
    default : its value when it is left out. Default: it must be given.
    unset : text about a field that is left out, in place of its default.
    typical : lowest and highest usual value, SI.
    near : other names that users give it; a message about one of them names the field.
    above, least : bounds in SI, exclusive and inclusive.
    infinite : whether infinity is allowed.
    example : a value for messages, and for the lines of left-out fields in a first file. Default: from the typical
        range.
    """

    meaning: str
    unit: str = ""
    default: Any = REQUIRED
    unset: str = ""
    typical: tuple[float, float] | None = None
    near: tuple[str, ...] = ()
    above: float | None = None
    least: float | None = None
    infinite: bool = False
    example: Any = None

    @property
    def required(self) -> bool:
        """True if the field must be given."""
        return self.default is REQUIRED

    def read(self, name: str, value: Any) -> Any:
        """Check ``value``, and return SI numbers or a text; `FieldError` for one that cannot be used."""
        if not self.unit:
            if not isinstance(value, str) or not value.strip():
                raise FieldError(name, f"{name} = {value!r}: must be a non-empty text in quotes")
            return value
        bounds: dict[str, Any] = {"above": self.above, "least": self.least, "infinite": self.infinite}
        bounds["example"] = self.example_text()
        number = parse_many(name, value, self.unit, **bounds)
        sizes = np.abs(np.atleast_1d(number))
        if (sizes[np.isfinite(sizes)] > LARGEST).any():
            shown = f"{sizes[np.isfinite(sizes)].max():g} {self.unit}".rstrip(" 1")
            raise FieldError(name, f"{name}: {shown} is beyond what can be computed with; give a smaller one")
        return number

    def implausible(self, value: Any, far: float) -> float | None:
        """The first value outside the typical range, widened by a factor; None if there is none."""
        if self.typical is None or value is None:
            return None
        low, high = self.typical[0] / far, self.typical[1] * far
        sizes = np.atleast_1d(np.asarray(value, dtype=float))
        odd = sizes[(sizes != 0.0) & np.isfinite(sizes) & ((np.abs(sizes) < low) | (np.abs(sizes) > high))]
        return float(odd[0]) if odd.size else None

    def example_value(self) -> Any:
        """A usual value: the example, or the middle of the typical range, rounded to one digit."""
        if self.example is not None or self.typical is None:
            return 1.0 if self.example is None else self.example
        return float(f"{(self.typical[0] * self.typical[1]) ** 0.5:.1g}")

    def example_text(self) -> str:
        """The example with its unit; empty without an example and a typical range."""
        known = self.unit and (self.example is not None or self.typical is not None) and not np.ndim(self.example)
        return format_si(self.example_value(), self.unit) if known else ""

    def typical_text(self) -> str:
        """The typical range with units; empty if there is none."""
        if self.typical is None:
            return ""
        low, high = self.typical
        text = format_range(low, high, self.unit)
        return f"{low:g} to {high:g} {self.unit}" if "e+" in text else text  # beyond the largest prefix


MOST_UNKNOWN = 20
"""Most unknown names in an error; for each the fields that were meant are searched."""


MOST_NAMED = 12
"""Most fields that an error about an unknown one names."""
SHORTEST_PART = 3
"""Fewest letters of a name that is searched for within the names of fields."""


class FieldErrors(FieldError):
    """Several errors about fields, one line each; ``errors`` holds them."""

    def __init__(self, errors: Iterable[FieldError]) -> None:
        self.errors: list[FieldError] = list(errors)
        super().__init__(self.errors[0].field, "\n".join(map(str, self.errors)))

    def __reduce__(self) -> tuple[Any, ...]:
        return FieldErrors, (self.errors,)

    def within(self, parent: str) -> FieldError:
        return FieldErrors(error.within(parent) for error in self.errors)


class Record:
    """A frozen record of the fields that are `Field` attributes of its class; None leaves a field out."""

    kind: ClassVar[str] = "record"
    fields: Mapping[str, Field] = {}
    __signature__: ClassVar[inspect.Signature]

    def __init_subclass__(cls) -> None:
        declared_fields = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        cls.fields = {**cls.fields, **declared_fields}
        cls.sign()

    @classmethod
    def sign(cls) -> None:
        """Set the signature of the constructor to the fields, for help and completion."""
        cls.__signature__ = inspect.Signature([_parameter(name, field) for name, field in cls.fields.items()])

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{type(self).__name__} has no field {name!r}")

    def __init__(self, /, **values: Any) -> None:
        given = {name: value for name, value in values.items() if value is not None}
        unknown = (name for name in given if name not in self.fields)
        errors = [self.unknown(name) for name in islice(unknown, MOST_UNKNOWN)]
        meant = {name for error in errors for name in error.meant}
        for name, field in self.fields.items():
            if name not in given:
                if field.required and name not in meant:
                    errors.append(FieldError(name, f"{name}: is missing; give the {_with_unit(field)}"))
                self.__dict__[name] = None if field.required else field.default
                continue
            try:
                self.__dict__[name] = self.read(name, given[name])
            except FieldError as error:
                errors.append(error)
        if not errors:
            errors = list(self.misfits())
        if errors:
            raise errors[0] if len(errors) == 1 else FieldErrors(errors)

    def read(self, name: str, value: Any) -> Any:
        """Check the value of a field; `FieldError` for one that cannot be used."""
        return self.fields[name].read(name, value)

    def misfits(self) -> Iterator[FieldError]:
        """Find the errors of the fields taken together. Default: none."""
        yield from ()

    def parameters(self) -> dict[str, Any]:
        """All fields that are set, as plain numbers (SI), texts, lists and dicts; ``type(self)(**parameters)`` is
        equal."""
        return {name: self.plain(name, value) for name, value in self if value is not None}

    def plain(self, name: str, value: Any) -> Any:
        """The value of a field as plain data."""
        return plain(value)

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return ((name, self.__dict__[name]) for name in self.fields)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a {self.kind} does not change; replace({name}=...) gives one that differs")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and type(self) is type(other) and self.parameters() == other.parameters()

    __hash__: ClassVar[None]  # type: ignore[assignment]

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.parameters().items())
        return f"{type(self).__name__}({given})"

    def unknown(self, name: str) -> FieldError:
        """Make the error for an unknown field, with the fields that were probably meant."""
        return unknown_field(self.kind, name, self.fields)


def _parameter(name: str, field: Field) -> inspect.Parameter:
    """Make the parameter of a field in the signature of the constructor."""
    default = inspect.Parameter.empty if field.required else field.default
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default)


def unknown_field(kind: str, name: str, fields: Mapping[str, Field]) -> FieldError:
    """Make the error for a name that is not one of ``fields``, with those that were probably meant, that contain it, or
    where they are listed."""
    meant = meant_fields(name, fields)
    within = (
        [field_name for field_name in fields if plain_name(name) in field_name] if len(name) >= SHORTEST_PART else []
    )
    if meant:
        names = " or ".join([", ".join(map(repr, meant[:-1])), repr(meant[-1])] if meant[1:] else [repr(meant[0])])
        remedy = f"did you mean {names}?"
    elif 0 < len(within) <= MOST_NAMED:
        remedy = f"with {name!r} in their names: {', '.join(within)}"
    elif len(fields) <= MOST_NAMED:
        remedy = f"known: {', '.join(fields)}"
    else:
        remedy = "gelcone help device lists them"
    return FieldError(name, f"{name!r} is not a {kind} field; {remedy}", meant)


def meant_fields(name: str, fields: Mapping[str, Field]) -> list[str]:
    """The fields that an unknown name probably means: those that list it or whose dotted name ends in it, else the one
    with the most similar name."""
    typed = plain_name(name)
    listed = [
        field_name
        for field_name, field in fields.items()
        if typed in (field_name, field_name.rpartition(".")[2]) or typed in field.near
    ]
    if listed:
        return listed
    spelt = {field_name: field_name for field_name in fields} | {
        other: field_name for field_name, field in fields.items() for other in field.near
    }
    near = difflib.get_close_matches(typed, spelt, n=1, cutoff=0.6)
    return [spelt[near[0]]] if near else []


def plain_name(name: str) -> str:
    """A name in the form of the names of fields."""
    return name.strip().lower().replace("-", "_").replace(" ", "_")


def _with_unit(field: Field) -> str:
    return f"{field.meaning} in {field.unit}" if field.unit not in ("", "1") else field.meaning


def plain(value: Any) -> Any:
    """A record, a mapping or an array as plain data; other values unchanged."""
    if isinstance(value, Record):
        return value.parameters()
    if isinstance(value, Mapping):
        return dict(value)
    return np.asarray(value).tolist() if isinstance(value, np.ndarray | tuple) else value
