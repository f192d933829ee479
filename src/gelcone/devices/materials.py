"""Gels: the numbers a film needs, each with its source, and a small library of measured ones."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from gelcone.devices.units import FieldError, parse, parse_many
from gelcone.errors import InputError, unknown_name
from gelcone.physics.laws import LAWS, StrainEnergyLaw, find_law

# CODATA 2022, F/m
VACUUM_PERMITTIVITY = 8.8541878188e-12
_LAW_PARAMETERS = frozenset(name for law in LAWS.values() for name in law.parameters)
_CHANGED = ", changed"


def si(unit: str, *, many: bool = False, **bounds: Any) -> BeforeValidator:
    """A field that `gelcone.devices.units.parse` reads (``many``: `parse_many`), in ``unit`` and within ``bounds``."""
    reader = parse_many if many else parse

    def read(value: Any, info: ValidationInfo) -> Any:
        return reader(str(info.field_name), value, unit, **bounds)

    return BeforeValidator(read)


def text(value: Any, info: ValidationInfo) -> str:
    """The check of a text field."""
    if not isinstance(value, str) or not value.strip():
        raise FieldError(str(info.field_name), f"{info.field_name} = {value!r}: must be a non-empty text in quotes")
    return value


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.parameters()
    if isinstance(value, Mapping):
        return dict(value)
    return np.asarray(value).tolist() if isinstance(value, np.ndarray | tuple) else value


class Record(BaseModel):
    """A frozen record whose input errors come as one line; a field given as None counts as left out."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    kind: ClassVar[str] = "record"

    def __init__(self, /, **values: Any) -> None:
        given = {name: value for name, value in values.items() if value is not None}
        try:
            super().__init__(**given)
        except ValidationError as error:
            raise self._one_line(error) from None

    def parameters(self) -> dict[str, Any]:
        """All that is set, as plain numbers (SI), texts, lists and dicts: ``type(self)(**parameters)`` is equal."""
        return {name: _plain(value) for name, value in self if value is not None}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and type(self) is type(other) and self.parameters() == other.parameters()

    @classmethod
    def field_names(cls) -> list[str]:
        """The names that a user may give."""
        return list(cls.model_fields)

    @classmethod
    def unknown(cls, name: str) -> FieldError:
        """The error for a field that does not exist."""
        return FieldError(name, str(unknown_name(f"{cls.kind} field", name, cls.field_names())))

    @classmethod
    def _one_line(cls, error: ValidationError) -> FieldError:
        # a misspelt name comes first: it also makes the right one missing
        found = sorted(error.errors(include_url=False), key=lambda e: e["type"] != "extra_forbidden")
        first = cls._field_error(found[0])
        others = [other.field for other in map(cls._field_error, found[1:]) if other.field != first.field]
        if others:
            return FieldError(first.field, f"{first} (to correct as well: {', '.join(others)})")
        return first

    @classmethod
    def _field_error(cls, error: Any) -> FieldError:
        name = ".".join(map(str, error["loc"]))
        raised = error.get("ctx", {}).get("error")
        if isinstance(raised, InputError):
            return raised if isinstance(raised, FieldError) else FieldError(str(raised).split(" ")[0], str(raised))
        if error["type"] == "extra_forbidden":
            return cls.unknown(name)
        if error["type"] == "missing":
            return FieldError(name, f"{name}: is missing; give the {cls.model_fields[name].description}")
        return FieldError(name, f"{name} = {error['input']!r}: {error['msg']}")


def _law_of_field(name: str) -> StrainEnergyLaw:
    """`find_law`, with its error told about the field ``law``."""
    try:
        return find_law(name)
    except InputError as error:
        raise FieldError("law", f"law: {error}") from None


class Material(Record):
    """A film material. Numbers are in SI; in place of each, a string with a unit will do (see `gelcone.devices.units`).

    Parameters
    ----------
    name : what it is called.
    shear_modulus : small-strain shear modulus mu, Pa, positive. Or ``young_modulus`` E, of which mu = E/3
        is taken (incompressible); exactly one of both.
    relative_permittivity : at least 1.
    relative_permittivity_range : lowest and highest measured value, around the nominal one. Default None.
    law : name of its strain-energy law in `gelcone.physics.laws.LAWS`. Default "gent".
    stretch_limit : Gent's J, the largest I1 - 3; infinity is neo-Hookean. Default 50 with the Gent law.
    yeoh_c2, yeoh_c3 : Yeoh's C20/C10 and C30/C10. Default 0 with the Yeoh law.
    dielectric_strength : true field that the film stands, V/m, positive; None (default) = unknown.
    sources : field name -> where its number comes from. Default none stated.

    Raises
    ------
    InputError : one line, for values that are missing, unknown, not exact or out of bounds.
    """

    kind: ClassVar[str] = "material"

    name: Annotated[str, BeforeValidator(text)] = "unnamed material"
    shear_modulus: Annotated[float, si("Pa", above=0.0)] = Field(
        description="shear modulus in Pa (or young_modulus, three times as much)"
    )
    relative_permittivity: Annotated[float, si("1", least=1.0)] = Field(description="relative permittivity")
    relative_permittivity_range: Annotated[Any, si("1", many=True, least=1.0)] = None
    law: Annotated[str, BeforeValidator(text)] = "gent"
    stretch_limit: Annotated[float | None, si("1", above=0.0, infinite=True)] = None
    yeoh_c2: Annotated[float | None, si("1")] = None
    yeoh_c3: Annotated[float | None, si("1")] = None
    dielectric_strength: Annotated[float | None, si("V/m", above=0.0)] = None
    sources: Mapping[str, str] = {}

    def __init__(self, /, **values: Any) -> None:
        values = {name: value for name, value in values.items() if value is not None}
        if "young_modulus" in values:
            if "shear_modulus" in values:
                raise FieldError("young_modulus", "young_modulus and shear_modulus are both given; give one (mu = E/3)")
            values["shear_modulus"] = parse("young_modulus", values.pop("young_modulus"), "Pa", above=0.0) / 3.0
        law = LAWS.get(str(values.get("law", "gent")))
        defaults = {name: quantity.default for name, quantity in law.parameters.items()} if law else {}
        super().__init__(**defaults | values)

    @classmethod
    def field_names(cls) -> list[str]:
        return [*super().field_names(), "young_modulus"]

    @field_validator("sources", mode="before")
    @classmethod
    def _sources_are_texts(cls, value: Any) -> Any:
        if not isinstance(value, Mapping) or not all(isinstance(t, str) for t in [*value, *value.values()]):
            raise FieldError("sources", f"sources = {value!r}: must map field names to texts")
        return value

    @model_validator(mode="after")
    def _parts_fit(self) -> Material:
        law = _law_of_field(self.law)
        for name in _LAW_PARAMETERS - law.parameters.keys():
            if getattr(self, name) is not None:
                takes = ", ".join(law.parameters) or "no parameters"
                raise FieldError(name, f"{name}: the {law.name} law does not take it; it takes {takes}")
        span = self.relative_permittivity_range
        if span is not None and not (np.shape(span) == (2,) and span[0] <= self.relative_permittivity <= span[1]):
            raise FieldError(
                "relative_permittivity_range",
                f"relative_permittivity_range = {_plain(span)}: must be [lowest, highest] around relative_permittivity "
                f"= {self.relative_permittivity:g}; correct one of the two",
            )
        return self

    @property
    def young_modulus(self) -> float:
        """Young's modulus 3 mu of the incompressible material, Pa."""
        return 3.0 * self.shear_modulus

    @property
    def permittivity(self) -> float:
        """Absolute permittivity, F/m."""
        return self.relative_permittivity * VACUUM_PERMITTIVITY

    @property
    def law_parameters(self) -> dict[str, float]:
        """The numbers of the law, by name."""
        return {name: getattr(self, name) for name in LAWS[self.law].parameters}

    def replace(self, **changes: Any) -> Material:
        """A copy with some fields changed; None takes a field's default.

        A changed number loses its source and its measured range, and the copy says in its name that it is changed.
        A new ``law`` starts from its own default parameters. Raises `InputError` as the constructor does.
        """
        values = self.parameters()
        changed = {"shear_modulus" if name == "young_modulus" else name for name in changes}
        dropped = set(changed)
        if "relative_permittivity" in changed:
            dropped.add("relative_permittivity_range")
        if "law" in changed:
            dropped |= _LAW_PARAMETERS
        values = {name: value for name, value in values.items() if name not in dropped}
        values["sources"] = {name: source for name, source in self.sources.items() if name not in dropped}
        if changed - {"sources"} and not self.name.endswith(_CHANGED):
            values["name"] = self.name + _CHANGED
        return Material(**values | changes)


@functools.cache
def _library() -> dict[str, Material]:
    data = tomllib.loads(resources.files("gelcone.devices").joinpath("materials.toml").read_text(encoding="utf-8"))
    return {name: Material(name=name, **fields) for name, fields in data.items()}


def load_materials() -> dict[str, Material]:
    """The library of measured gels, by name; ``materials.toml`` beside this file holds the figures and sources."""
    return dict(_library())


def find_material(name: str) -> Material:
    """The library's material of that name; `InputError` with the nearest name when there is none.

    >>> round(find_material("PVC-DBA 4:1").shear_modulus)
    18700
    """
    if name not in _library():
        raise unknown_name("material", name, _library())
    return _library()[name]
