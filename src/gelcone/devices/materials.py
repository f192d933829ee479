"""Gels: the numbers a film needs, each with its source, and a small library of measured ones."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any, ClassVar

import numpy as np

from gelcone.devices.record import Field, Record, plain
from gelcone.devices.units import FieldError
from gelcone.errors import InputError, unknown_name
from gelcone.physics.laws import LAWS, find_law

# CODATA 2022, F/m
VACUUM_PERMITTIVITY = 8.8541878188e-12
_LAW_PARAMETERS = frozenset(name for law in LAWS.values() for name in law.parameters)
_CHANGED = ", changed"


class Material(Record):
    """A film material. Numbers are in SI; in place of each, a string with a unit will do (see `gelcone.devices.units`).

    Each number may also be a one-dimensional array: an ensemble, member by member.

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
    InputError : a line each, for values that are missing, unknown, not exact or out of bounds.
    """

    kind: ClassVar[str] = "material"

    name: Any = Field("name of the gel", default="unnamed material")
    shear_modulus: Any = Field(
        "small-strain shear modulus", "Pa", default=None, unset="or give young_modulus, three times as much",
        typical=(1e3, 1e6), near=("modulus", "mu", "g", "shear", "stiffness"), above=0.0,
    )  # fmt: skip
    young_modulus: Any = Field(
        "Young's modulus, in place of the shear modulus", "Pa", default=None, unset="or give shear_modulus",
        typical=(3e3, 3e6), near=("modulus", "e", "youngs_modulus", "elastic_modulus", "stiffness"), above=0.0,
    )  # fmt: skip
    relative_permittivity: Any = Field(
        "relative permittivity", "1", typical=(2.0, 100.0), least=1.0,
        near=("permittivity", "epsilon", "eps", "dielectric_constant"),
    )  # fmt: skip
    relative_permittivity_range: Any = Field(
        "lowest and highest measured relative permittivity", "1", default=None, unset="not stated", least=1.0
    )
    law: Any = Field("strain-energy law: gent, neo-hookean or yeoh", default="gent", near=("model", "strain_energy"))
    stretch_limit: Any = Field(
        "Gent's J, the largest I1 - 3 of the film", "1", default=None, unset="50 with the Gent law",
        typical=(1.0, 200.0), near=("j", "jm", "j_m", "limit"), above=0.0, infinite=True,
    )  # fmt: skip
    yeoh_c2: Any = Field("Yeoh's C20/C10", "1", default=None, unset="0 with the Yeoh law", near=("c2", "c20"))
    yeoh_c3: Any = Field("Yeoh's C30/C10", "1", default=None, unset="0 with the Yeoh law", near=("c3", "c30"))
    dielectric_strength: Any = Field(
        "true electric field that the film stands", "V/m", default=None, unset="unknown (no verdict on breakdown)",
        typical=(1e6, 2e8), near=("breakdown", "breakdown_field", "breakdown_strength"), above=0.0,
    )  # fmt: skip
    sources: Any = Field("where each number comes from", default=(), unset="not stated")

    def __init__(self, /, **values: Any) -> None:
        values = {name: value for name, value in values.items() if value is not None}
        law = LAWS.get(str(values.get("law", "gent")))
        defaults = {name: quantity.default for name, quantity in law.parameters.items()} if law else {}
        super().__init__(**defaults | values)

    def read(self, name: str, value: Any) -> Any:
        if name == "sources":
            if not isinstance(value, Mapping) or not all(isinstance(t, str) for t in [*value, *value.values()]):
                raise FieldError("sources", f"sources = {value!r}: must map field names to texts")
            return dict(value)
        return super().read(name, value)

    def misfits(self) -> Iterator[FieldError]:
        own = self.__dict__
        own["sources"] = dict(own["sources"])
        if own["young_modulus"] is not None:
            if own["shear_modulus"] is not None:
                yield FieldError("young_modulus", "young_modulus and shear_modulus are both given; give one (mu = E/3)")
            own["shear_modulus"], own["young_modulus"] = own["young_modulus"] / 3.0, None
        if own["shear_modulus"] is None:
            yield FieldError(
                "shear_modulus",
                "shear_modulus: is missing; give the shear modulus in Pa (or young_modulus, three times as much)",
            )
        try:
            law = find_law(self.law)
        except InputError as error:
            yield FieldError("law", f"law: {error}")
            return
        for name in sorted(_LAW_PARAMETERS - law.parameters.keys()):
            if own[name] is not None:
                takes = ", ".join(law.parameters) or "no parameters"
                yield FieldError(name, f"{name}: the {law.name} law does not take it; it takes {takes}")
        span, nominal = self.relative_permittivity_range, np.asarray(self.relative_permittivity)
        if span is not None and not (np.shape(span) == (2,) and ((span[0] <= nominal) & (nominal <= span[1])).all()):
            yield FieldError(
                "relative_permittivity_range",
                f"relative_permittivity_range = {plain(span)}: must be [lowest, highest] around relative_permittivity "
                f"= {self.relative_permittivity:g}; correct one of the two",
            )

    @property
    def permittivity(self) -> Any:
        """Absolute permittivity, F/m."""
        return self.relative_permittivity * VACUUM_PERMITTIVITY

    @property
    def law_parameters(self) -> dict[str, Any]:
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
