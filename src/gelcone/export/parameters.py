"""The parameters of an exported device that can be changed without a new export, and the numbers that follow from them.

The film's geometry, pre-stretches and strain-energy law are fixed, since a membrane's force is fitted to them. All
other fields enter the equation of motion by closed formulas, which are traced from those that devices use.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.devices.cone import following
from gelcone.devices.device import Device
from gelcone.devices.fields import DIRECT_PRESTRETCHES, GEL, SECOND_PRESTRETCHES
from gelcone.devices.numbers import numbers_of
from gelcone.devices.record import Field
from gelcone.devices.scales import MEASURES, Scales, carried_mass
from gelcone.errors import InputError
from gelcone.physics.component import Component
from gelcone.physics.film.gel import GelFilm
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import PREFIX, PlacedFilm
from gelcone.physics.trace import Graph, Node, ordered

FIXED = ("disc_radius", "film_radius", "prestretch", *DIRECT_PRESTRETCHES, *SECOND_PRESTRETCHES)
"""Fields on which the film's numbers depend."""
STRENGTH, DAMPING = "dielectric_strength", "damping_coefficient"
SCALES = ("length", "time", "velocity", "force", "voltage", "current", "field", "stress", "charge", "capacitance")


@dataclass(frozen=True)
class Parameters:
    """Parameters by field: their ``values`` in SI units and their ``fields``; ``nodes`` of the numbers of the formulas
    that follow from them, by name; and ``scales``, nodes of the SI values of dimensionless units, by quantity."""

    values: Mapping[str, float]
    fields: Mapping[str, Field]
    nodes: Mapping[str, Node]
    scales: Mapping[str, Node]


def parameters_of(device: Device, model: ConeModel, used: Collection[str], quantities: Collection[str]) -> Parameters:
    """Trace the parameters on which the numbers ``used`` depend, and the scales of `SCALES` and of ``quantities``.

    Raises `InputError` for a user-defined component whose numbers cannot be traced.
    """
    graph, fields = Graph(), device.swept_fields()
    fixed = {*FIXED, *(GEL + parameter for parameter in device.material.law_parameters)}
    strength = device.material.dielectric_strength if device.dielectric_strength is None else device.dielectric_strength
    field_values = {name: device.get(name) for name in fields if name not in fixed}
    field_values |= {STRENGTH: 0.0 if strength is None else strength}
    if field_values.get(DAMPING) is None:
        field_values[DAMPING] = 2.0 * carried_mass(device.get) * model.values["damping_ratio"] / device.scales.time
    values = {name: float(value) for name, value in field_values.items() if value is not None and np.isfinite(value)}
    leaves = {name: graph.number(name) for name in values}

    def get(name: str) -> Any:
        return leaves.get(name, device.get(name))

    scales = Scales.of(get, graph)
    sizes = {name: graph.node(scales.size(name)) for name in dict.fromkeys([*SCALES, *quantities]) if name in MEASURES}
    nodes = {name: node for name, node in _numbers(device, model, scales, get, graph).items() if name in used}
    reached = {leaf.value for leaf in ordered([*nodes.values(), *sizes.values()]) if leaf.operation == "number"}
    reached |= {STRENGTH}
    return Parameters(
        values={name: value for name, value in values.items() if name in reached},
        fields={name: fields[name] for name in values if name in reached},
        nodes=nodes,
        scales={"1": graph.constant(1.0)} | sizes,
    )


def _numbers(device: Device, model: ConeModel, scales: Scales, get: Any, graph: Graph) -> dict[str, Node]:
    """Trace the numbers of the formulas that are not the film's own."""
    values, device_numbers = dict(model.values), numbers_of(device)
    for parameter, (field, quantity) in device_numbers.items():
        of_second = () if PREFIX + parameter in device_numbers else (PREFIX + parameter,)  # which is of the same gel
        if device.get(field) is not None:
            number = scales.dimensionless(quantity, get(field))
            values |= {name: number for name in (parameter, *of_second) if name in values}
    values |= following(device, get, scales)
    values["damping_ratio"] = get(DAMPING) * scales.time / (2.0 * carried_mass(get))
    system = model.system
    for name, declaration in system.parameters.items():
        untraced = name in values and not isinstance(values[name], Node) and name != STRENGTH
        if untraced and declaration.scale != "1" and not (values[name] == 0.0 or np.isinf(values[name])):
            raise InputError(
                f"{name}: cannot be exported, for it is not known how it follows from fields of the device"
            )
    traced_numbers: dict[str, Any] = {"damping_ratio": values["damping_ratio"]}
    for part in (system.bias, system.waveform, system.circuit):
        traced_numbers |= _traced(part, values)
    for film in system.films:
        traced_numbers |= _of_film(film, values)
    return {name: graph.node(value) for name, value in traced_numbers.items() if np.ndim(value) == 0}


def _of_film(film: PlacedFilm, values: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a film that have a scale: flat height and voltage of a second film, and those of Maxwell
    branches."""
    film_values = film.own(values) if film.drive else values
    if not isinstance(film.film, GelFilm):
        return _traced(film, values)
    numbers = {name: values[name] for name in ("second_flat_height", "second_voltage") if name in film.parameters}
    viscous = getattr(film.film, "viscous", None)
    creeps = {} if viscous is None else viscous.parameters
    if other := [name for name, q in film.film.parameters.items() if q.scale != "1" and name not in creeps]:
        raise InputError(
            f"{film.film.name}: the scale of its parameter {other[0]} may change in C; make it a pure number"
        )
    if viscous is not None and viscous.count:
        numbers |= {film.prefix + name: value for name, value in viscous.numbers(film_values).items()}
    return numbers


def _traced(part: Component, values: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a component as nodes; `InputError` if they cannot be traced."""
    try:
        return part.numbers(values)
    except TypeError as error:
        raise InputError(
            f"{part.name}: its numbers cannot leave as a formula ({error}); write them with + - * / and ** alone"
        ) from None
