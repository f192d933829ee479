"""Gels: the numbers of film materials with their sources, and a library of measured gels."""

from __future__ import annotations

import dataclasses
import functools
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from typing import Any, ClassVar, Unpack

import numpy as np

from gelcone.devices.given import MaterialValues
from gelcone.devices.parts import component_of, field_of, own_fields, part_record, read_part
from gelcone.devices.record import Field, Record, plain
from gelcone.devices.units import FieldError
from gelcone.errors import check_name
from gelcone.physics.film.branches import FLOWS, MOST_BRANCHES
from gelcone.physics.laws import LAWS, StrainEnergyLaw

CHANGED = ", changed"
"""Ending of the name of a gel that was changed."""
RANGED = ("shear_modulus", "relative_permittivity")
"""Fields for which a material may state the range of the measurements."""


class Material(Record):
    """A film material. Numbers are in SI; in place of each, a string with a unit will do (see `gelcone.devices.units`).

    Each number may also be a one-dimensional array: an ensemble, member by member.

    Parameters
    ----------
    name : what it is called.
    shear_modulus : small-strain shear modulus mu, Pa, positive. Or ``young_modulus`` E, of which mu = E/3
        is taken (incompressible); exactly one of both.
    shear_modulus_range : lowest and highest modulus that the measurement leaves, around the nominal one. Default None.
    relative_permittivity : at least 1.
    relative_permittivity_range : lowest and highest measured value, around the nominal one. Default None.
    law : its strain-energy law: the name of one in `gelcone.physics.laws.LAWS`, a `StrainEnergyLaw`, ``"module:Class"``
        of one's own, or a mapping with that as ``component`` and its data. Default "gent". Its parameters are fields of
        the material: ``stretch_limit`` (Gent's J, the largest I1 - 3; infinity is neo-Hookean; default 50), ``yeoh_c2``
        and ``yeoh_c3`` (Yeoh's C20/C10 and C30/C10; default 0).
    dielectric_strength : true field that the film stands, V/m, positive; None (default) = unknown.
    viscous_modulus_1, relaxation_time_1, viscous_stretch_limit_1 : Maxwell branch of a gel that creeps, Pa, s and
        largest I1 - 3 (default infinity); the shear modulus then is the long-term one. Default none.
    viscous_modulus_2, relaxation_time_2, viscous_stretch_limit_2 : a second branch. Default none.
    viscous_modulus_3, relaxation_time_3, viscous_stretch_limit_3 : a third branch. Default none.
    flow : the flow rule with which the branches were fitted, "log" (default) or "linear".
    resistivity : of the gel, ohm m, positive; ``resistivity_field``, V/m, the true field E_b from which it leaks more,
        E_b sinh(E/E_b) over the resistivity. Default none: nothing leaks.
    dielectric_share, dielectric_time : the share of the permittivity, below 1, that follows the field with a delay, and
        its time constant, s; of the film ``taut``. Default none does.
    heat_capacity : over the volume, J/(m^3 K), positive, from which the rate of the temperature follows. Default
        none: 1.8e6 is taken, an estimate between polymer and plasticiser.
    sources : field name -> where its number comes from. Default none stated.

    Raises
    ------
    InputError : a line each, for values that are missing, unknown, not exact or out of bounds.

    Examples
    --------
    >>> import gelcone
    >>> gel = gelcone.Material(young_modulus="24 kPa", relative_permittivity=5, dielectric_strength="20 kV/mm")
    >>> device = gelcone.find_device("biased-pump").replace(material=gel)
    >>> device.material.shear_modulus, device.replace({"material.shear_modulus": ["7 kPa", "8 kPa"]}).shape
    (8000.0, (2,))
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
    shear_modulus_range: Any = Field(
        "lowest and highest shear modulus that the measurement leaves",
        "Pa",
        default=None,
        unset="not stated",
        above=0.0,
    )
    relative_permittivity: Any = Field(
        "relative permittivity", "1", typical=(2.0, 100.0), least=1.0,
        near=("permittivity", "epsilon", "eps", "dielectric_constant"),
    )  # fmt: skip
    relative_permittivity_range: Any = Field(
        "lowest and highest measured relative permittivity", "1", default=None, unset="not stated", least=1.0,
        example=(4.0, 6.0),
    )  # fmt: skip
    law: Any = Field(
        "strain-energy law: gent, neo-hookean or yeoh, or a user-defined one as module:Class", default="gent",
        near=("model", "strain_energy"),
    )  # fmt: skip
    dielectric_strength: Any = Field(
        "true electric field that the film stands", "V/m", default=None, unset="unknown (no verdict on breakdown)",
        typical=(1e6, 2e8), near=("breakdown", "breakdown_field", "breakdown_strength"), above=0.0,
    )  # fmt: skip
    flow: Any = Field(
        "flow rule of the Maxwell branches: log or linear",
        default=None,
        unset="log",
        near=("flow_rule",),
        example="log",
    )
    resistivity: Any = Field(
        "resistivity of the gel, through which charge leaks", "ohm m", default=None, unset="inf: nothing leaks",
        typical=(1e7, 1e14), above=0.0, infinite=True, example=1e9,
        near=("conductivity", "leakage", "volume_resistivity"),
    )  # fmt: skip
    resistivity_field: Any = Field(
        "true field E_b of ionic hopping: the film leaks E_b sinh(E/E_b) over its resistivity", "V/m", default=None,
        unset="ohmic", typical=(1e6, 1e8), above=0.0, near=("leakage_field", "hopping_field"), example=1.7e7,
    )  # fmt: skip
    dielectric_share: Any = Field(
        "share of the permittivity that follows the field with a delay, of a taut film", "1", default=None,
        unset="none", typical=(0.01, 0.9), above=0.0, near=("debye_share", "relaxing_share"), example=0.3,
    )  # fmt: skip
    dielectric_time: Any = Field(
        "time constant of that share", "s", default=None, unset="none follows late", typical=(1e-4, 100.0), above=0.0,
        infinite=True, near=("debye_time", "dielectric_relaxation_time"), example=0.1,
    )  # fmt: skip
    heat_capacity: Any = Field(
        "heat capacity of the gel over its volume", "J/(m^3 K)", default=None,
        unset="1.8 MJ/(m^3 K), an estimate", typical=(1e6, 5e6), above=0.0,
        near=("specific_heat", "thermal_capacity", "volumetric_heat_capacity"),
    )  # fmt: skip
    sources: Any = Field("where each number comes from", default=(), unset="not stated")

    def __init__(self, /, **given: Unpack[MaterialValues]) -> None:
        values: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        values["law"], numbers = read_part("law", values.get("law", "gent"))
        self.__dict__["fields"] = {**type(self).fields, **own_fields("law", values["law"])}
        law = component_of("law", values["law"])
        defaults = {name: quantity.default for name, quantity in law.parameters.items() if quantity.scale == "1"}
        super().__init__(**defaults | numbers | values)

    def read(self, name: str, value: Any) -> Any:
        if name == "law":
            return value
        if name == "sources":
            if not isinstance(value, Mapping) or not all(isinstance(t, str) for t in [*value, *value.values()]):
                raise FieldError("sources", f"sources = {value!r}: must map field names to texts")
            return dict(value)
        return super().read(name, value)

    def misfits(self) -> Iterator[FieldError]:
        values = self.__dict__
        values["sources"] = dict(values["sources"])
        if values["young_modulus"] is not None:
            if values["shear_modulus"] is not None:
                yield FieldError("young_modulus", "young_modulus and shear_modulus are both given; give one (mu = E/3)")
            values["shear_modulus"], values["young_modulus"] = values["young_modulus"] / 3.0, None
        if values["shear_modulus"] is None:
            yield FieldError(
                "shear_modulus",
                "shear_modulus: is missing; give the shear modulus in Pa (or young_modulus, three times as much)",
            )
        yield from self._branch_misfits()
        for name, other in (("dielectric_share", "dielectric_time"), ("dielectric_time", "dielectric_share")):
            if values[name] is not None and values[other] is None:
                yield FieldError(name, f"{name}: there is no {other}; give it, or leave it out")
        if self.resistivity is None and self.resistivity_field is not None:
            yield FieldError(
                "resistivity_field", "resistivity_field: there is no resistivity; give it, or leave it out"
            )
        law = self.strain_energy_law
        for name in sorted(_LAW_FIELDS.keys() - law.parameters.keys()):
            if values[name] is not None:
                takes = ", ".join(law.parameters) or "no parameters"
                yield FieldError(name, f"{name}: the {law.name} law does not take it; it takes {takes}")
        for name in RANGED:
            span, nominal = getattr(self, f"{name}_range"), np.asarray(getattr(self, name))
            around = np.shape(span) == (2,) and bool(((span[0] <= nominal) & (nominal <= span[1])).all())
            if span is not None and not around:
                yield FieldError(
                    f"{name}_range",
                    f"{name}_range = {plain(span)}: must be [lowest, highest] around {name} = {plain(nominal)}; "
                    "correct one of the two",
                )

    def _branch_misfits(self) -> Iterator[FieldError]:
        for k in range(1, MOST_BRANCHES + 1):
            branch_fields = [f"viscous_modulus_{k}", f"relaxation_time_{k}", f"viscous_stretch_limit_{k}"]
            given = [name for name in branch_fields if getattr(self, name) is not None]
            missing = [name for name in branch_fields[:2] if name not in given]
            if given and missing:
                yield FieldError(missing[0], f"{missing[0]}: is missing; {given[0]} is given, so give it too")
            elif given and k > 1 and getattr(self, f"viscous_modulus_{k - 1}") is None:
                yield FieldError(given[0], f"{given[0]}: there is no branch {k - 1}; number them from 1")
        if self.flow is not None and self.flow not in FLOWS:
            yield FieldError("flow", f"flow = {self.flow!r}: must be one of {', '.join(FLOWS)}")
        limits = [f"viscous_stretch_limit_{k}" for k in range(1, MOST_BRANCHES + 1)]
        for name in limits if self.flow == "linear" else ():
            if getattr(self, name) is not None:
                yield FieldError(name, f"{name}: the linear flow has none; leave it out")

    @property
    def branches(self) -> int:
        """The number of Maxwell branches."""
        return sum(getattr(self, f"viscous_modulus_{k}") is not None for k in range(1, MOST_BRANCHES + 1))

    def plain(self, name: str, value: Any) -> Any:
        return part_record(name, value) if name == "law" else plain(value)

    @property
    def strain_energy_law(self) -> StrainEnergyLaw:
        """The law itself."""
        law: StrainEnergyLaw = component_of("law", self.law)
        return law

    @property
    def law_parameters(self) -> dict[str, Any]:
        """The parameters of the law that are set, by name, in SI units."""
        return {name: value for name in self.strain_energy_law.parameters if (value := getattr(self, name)) is not None}

    def replace(self, **changes: Unpack[MaterialValues]) -> Material:
        """A copy with some fields changed; None takes a field's default.

        A changed number loses its source and its measured range, and the copy says in its name that it is changed.
        A new ``law`` starts from its default parameters. Raises `InputError` as the constructor does.
        """
        values = {name: value for name, value in self if value is not None}
        changed = {"shear_modulus" if name == "young_modulus" else name for name in changes}
        dropped = set(changed)
        dropped |= {f"{name}_range" for name in RANGED if name in changed}
        if "law" in changed:
            dropped |= _LAW_FIELDS.keys() | self.strain_energy_law.parameters.keys()
        values = {name: value for name, value in values.items() if name not in dropped}
        values["sources"] = {name: source for name, source in self.sources.items() if name not in dropped}
        if changed - {"sources"} and not self.name.endswith(CHANGED):
            values["name"] = self.name + CHANGED
        given: dict[str, Any] = {**values, **changes}
        return Material(**given)


_LAW_FIELDS = {
    name: dataclasses.replace(field_of(name, quantity), unset=f"{quantity.default:g} with the {law.name} law")
    for law in LAWS.values()
    for name, quantity in law.parameters.items()
}
_BRANCH_FIELDS = {
    name: field
    for k in range(1, MOST_BRANCHES + 1)
    for name, field in {
        f"viscous_modulus_{k}": Field(
            f"modulus of Maxwell branch {k}", "Pa", default=None, unset="none: the gel is elastic", typical=(1e2, 1e6),
            above=0.0, near=("viscous_modulus", "maxwell_modulus"),
        ),
        f"relaxation_time_{k}": Field(
            f"relaxation time of Maxwell branch {k}", "s", default=None, unset="none", typical=(1e-3, 1e4), above=0.0,
            near=("relaxation_time", "tau"),
        ),
        f"viscous_stretch_limit_{k}": Field(
            f"stretch limit of Maxwell branch {k}: largest I1 - 3", "1", default=None, unset="inf", above=0.0,
            infinite=True, example=50.0,
        ),
    }.items()
}  # fmt: skip
_AFTER = {"law": _LAW_FIELDS, "dielectric_strength": _BRANCH_FIELDS}
Material.fields = {
    field_name: field
    for name, declared in Material.fields.items()
    for field_name, field in ({name: declared} | _AFTER.get(name, {})).items()
}
Material.sign()


SEPARATOR = " / "
"""Separator of the names of gels in `side_by_side`."""


def side_by_side(gels: Sequence[Material]) -> Material:
    """Make one material of several, to compare them member by member, with the numbers that all of them have.

    Raises `FieldError` for an empty list, and for gels with different laws or flow rules.
    """
    if not gels:
        raise FieldError("material", "material = []: is empty; give at least one gel")
    laws = {str(gel.strain_energy_law.name) for gel in gels}
    if len(laws) > 1:
        raise FieldError("material", f"material: the laws {' and '.join(sorted(laws))} differ; run the gels one by one")
    if len({gel.flow or FLOWS[0] for gel in gels if gel.branches}) > 1:
        raise FieldError("material", "material: the flow rules of the gels differ; run the gels one by one")
    numbers = {name: [getattr(gel, name) for gel in gels] for name, field in gels[0].fields.items() if field.unit}
    numbers = {name: values for name, values in numbers.items() if not name.endswith("_range")}
    known = {name: values for name, values in numbers.items() if all(value is not None for value in values)}
    spread: dict[str, Any] = {n: v[0] if len(set(map(float, v))) == 1 else np.array(v) for n, v in known.items()}
    return Material(name=SEPARATOR.join(gel.name for gel in gels), law=gels[0].law, flow=gels[0].flow, **spread)


@functools.cache
def _library() -> dict[str, Material]:
    data = tomllib.loads(resources.files("gelcone.devices").joinpath("materials.toml").read_text(encoding="utf-8"))
    return {name: Material(name=name, **fields) for name, fields in data.items()}


def load_materials() -> dict[str, Material]:
    """Read the library of measured gels; ``materials.toml`` in this folder holds numbers and sources.

    Returns
    -------
    Each `Material` by its name.

    Raises
    ------
    InputError : for a library whose numbers cannot be used, which a test excludes.

    Examples
    --------
    >>> import gelcone
    >>> gels = gelcone.load_materials()
    >>> len(gels) > 3, gels["VHB 4910"].viscous_modulus_1
    (True, 82313.0)
    """
    return dict(_library())


def find_material(name: str) -> Material:
    """Return the library's material of a name; `InputError` with the nearest name if there is none.

    >>> round(find_material("PVC-DBA 4:1").shear_modulus)
    18700
    """
    check_name("material", name, _library())
    return _library()[name]
