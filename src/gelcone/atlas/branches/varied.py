"""The quantities that vary along branches: parameters of a model, or fields of a device, over an interval each.

A field to which one parameter of the model is proportional is followed as that parameter. Any other field, such as the
film's thickness, changes several parameters at once: the device then computes the model of each value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gelcone.atlas.plan import STATES, Plan
from gelcone.dataset import attributes
from gelcone.devices.analysis import check_one
from gelcone.devices.device import Device
from gelcone.devices.numbers import SHIPPED
from gelcone.devices.points import at, field_attributes, read_swept, shown_value
from gelcone.devices.si import device_attributes, state_factors
from gelcone.errors import InputError, check_name
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.orbit import Kind, Settings, Shooting, repeat_phase, segments_for
from gelcone.motion.start import complete, start_states
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

PROPORTIONAL = 1e-12
HALVINGS = 10


@dataclass(frozen=True)
class Varied:
    """Names and intervals of the quantities that vary, of a model or a device. Use `vary`, which checks them.

    Branches are followed in values over the ``scales``, which are of order 1 in any unit: a value of a branch times the
    scale is that of the parameter, or of the field in SI. ``parameters`` are those of the model that represent the
    fields; empty where a field changes several. ``refused`` are values in words beyond the intervals, and the reasons
    why they make no actuator.
    """

    target: ConeModel | Device
    names: tuple[str, ...]
    low: Array
    high: Array
    initial: Any
    scales: Array
    parameters: tuple[str, ...]
    refused: tuple[tuple[str, str], ...] = ()

    @property
    def device(self) -> Device | None:
        """The device; None where a model's parameters vary."""
        return self.target if isinstance(self.target, Device) else None

    @cached_property
    def plan(self) -> Plan:
        """The corners of the intervals as a plan, which gives the model and the start at any values."""
        ends = {name: [low, high] for name, low, high in zip(self.names, self.low, self.high, strict=True)}
        return Plan(self.target, ends, self.initial)

    @cached_property
    def corners(self) -> tuple[list[Array], ConeModel]:
        """The ends and middles of the intervals, each with each of the others, in SI, of which an actuator can be made;
        and the models there."""
        ends = zip(self.names, self.low, self.high, strict=True)
        plan = replace(self.plan, over={name: np.linspace(low, high, 3) for name, low, high in ends})
        cells, models, _ = plan.possible()
        values = plan.values(cells)
        return [np.asarray(values[name]) for name in self.names], models

    def ensemble(self, values: Sequence[Any]) -> ConeModel:
        """The models at values over the scales, each (members,)."""
        named = _named(self, values)
        return self.plan.at(named)[0] if self.device is None else at(self.device, named).to_model()

    def starts(self, values: Sequence[float]) -> Array:
        """States (1, N) from which brute force settles: the initial ones, displaced where the disc would stay at
        rest."""
        if self.device is None:
            members, states = self.plan.cone.members(), start_states(self.plan.cone, self.plan.initial).copy()
        else:
            model, begun = self.plan.at(_named(self, [np.array([value]) for value in values]))
            members = model.members()
            states = complete(members, begun)
        if members.symmetric[0] and not states[:, :2].any():
            states[:, 0] = min(1.0, 0.5 * members.system.film.reach(members.numbers_at(0))[1])
        return states

    def without_units(self, states: Array, attributes: Mapping[str, Any], values: Array) -> Array:
        """States (members, ..., N) of a variable, dimensionless again, at ``values`` (members,) of the field in SI."""
        if attributes["units"] == "1" or self.device is None:
            return states
        each, _ = state_factors(attributes, states.shape[-1], at(self.device, {self.names[0]: values}).scales)
        factors = np.stack([np.broadcast_to(one, len(states)) for one in each], axis=-1)
        return states / factors.reshape(len(states), *(1,) * (states.ndim - 2), -1)

    @property
    def settings(self) -> Settings | None:
        """The settings that `Shooting` takes; None where parameters of the model vary."""
        if self.parameters:
            return None

        def made(values: Sequence[Any]) -> dict[str, Any]:
            spread = np.broadcast_arrays(*(np.atleast_1d(value) for value in values))
            model_values = self.ensemble(spread).values
            single = not any(np.ndim(value) for value in values)
            return {name: np.ravel(v)[0] if single else v for name, v in model_values.items()}

        return made

    def shooting(self, tolerance: float = DEFAULT_TOLERANCE) -> Shooting:
        """Shooting for all orbits in the intervals, with the number of segments that the fastest corner needs."""
        values, models = self.corners
        corners = models.members()
        phase = max(repeat_phase(corners.take(slice(k, k + 1))) for k in range(corners.size))
        time = phase / corners.number("drive_frequency")
        segments = segments_for(float(corners.fastest.max()), float(time.max()))
        if self.device is None:
            return Shooting(self.plan.cone.members(), self.names, Kind(1), segments, phase, tolerance)
        inner = corners.size // 2
        middle = corners.take(slice(inner, inner + 1))
        around = tuple(float(value[inner] / scale) for value, scale in zip(values, self.scales, strict=True))
        names = self.parameters or self.names
        return Shooting(middle, names, Kind(1), segments, phase, tolerance, self.settings, around)

    @property
    def ends(self) -> tuple[Array, Array]:
        """The ends of the intervals over the scales."""
        return self.low / self.scales, self.high / self.scales

    def attributes(self, k: int = 0) -> dict[str, str]:
        """The attributes of a variable with values of the k-th quantity."""
        name = self.names[k]
        if self.device is not None:
            return field_attributes(self.device, name)
        quantity = SHIPPED[name].quantity if name in SHIPPED else "parameter value"
        return attributes(self.plan.cone.system.parameters[name].meaning, quantity)

    @property
    def about(self) -> dict[str, str]:
        """The attributes of a result that describe its device, and why values beyond the intervals make none."""
        why = {"impossible": "; ".join(f"at {at}: {why}" for at, why in self.refused)} if self.refused else {}
        return why | ({} if self.device is None else device_attributes(self.device))

    def along(self, *variables: str) -> dict[str, str]:
        """The attribute of variables whose units depend on fields that vary: the variables that hold these fields."""
        if self.device is None:
            return {}
        return {"along": ",".join(f"{n}={v}" for n, v in zip(self.names, variables, strict=True))}

    def said(self, value: float, k: int = 0) -> str:
        """A value over its scale in words."""
        return self.worded(value * float(self.scales[k]), k)

    def worded(self, value: float, k: int = 0) -> str:
        """A value of the k-th parameter or, in SI, of the k-th field in words."""
        from gelcone.devices.units import format_si

        return f"{value:g}" if self.device is None else format_si(value, self.attributes(k)["units"])


def vary(target: ConeModel | Device, over: Mapping[str, tuple[Any, Any]], initial: Any = None) -> Varied:
    """Checked intervals of parameters or fields, each cut before values that make no actuator with the target's own
    values of the others.

    Raises
    ------
    InputError : for an ensemble, an unknown name, or an interval that is empty, reversed or out of bounds.
    """
    check_one(target, "branches")
    each = []
    for name, ends in over.items():
        low, high = _interval(target, name, *ends)
        one = Varied(target, (name,), np.array([low]), np.array([high]), initial, np.ones(1), (name,))
        each.append(_narrowed(one))
    lows, highs = (np.concatenate([getattr(one, end) for one in each]) for end in ("low", "high"))
    refused = tuple(pair for one in each for pair in one.refused)
    varied = Varied(target, tuple(over), lows, highs, initial, np.ones(len(over)), tuple(over), refused)
    if not isinstance(target, Device):
        return varied
    parameters, scales = _standing_for(varied)
    return replace(varied, scales=scales, parameters=parameters)


def _interval(target: ConeModel | Device, name: str, low: Any, high: Any) -> tuple[float, float]:
    """The checked ends of an interval."""
    if name in STATES:
        raise InputError(f"{name}: belongs to the initial state; branches follow a parameter")
    if isinstance(target, Device):
        low, high = (float(end) for end in read_swept(target, name, [low, high]))
    else:
        check_name("parameter of the model", name, target.values)
        for end in (low, high):
            target.system.parameters[name].check(name, end)
    if not (np.isfinite([low, high]).all() and low < high):
        device = target if isinstance(target, Device) else None
        ends = " to ".join(shown_value(device, name, end) for end in (low, high))
        raise InputError(f"{name} from {ends}: must be an interval, its lower end first; swap the ends")
    return float(low), float(high)


def _narrowed(varied: Varied) -> Varied:
    """One interval up to where its values cease to make an actuator, to 2 to the power of minus `HALVINGS` of its
    length. Raises `InputError` where neither its ends nor its middle make one."""

    def refusal(value: float) -> str:
        try:
            varied.plan.at({varied.names[0]: np.array([value])})
        except InputError as error:
            return str(error)
        return ""

    ends = [float(varied.low[0]), float(varied.high[0])]
    reasons = [refusal(end) for end in ends]
    if not any(reasons):
        return varied
    inner = next((at for at in (*ends, 0.5 * (ends[0] + ends[1])) if not refusal(at)), None)
    if inner is None:
        raise InputError(reasons[0])
    refused, possible_ends = [], list(ends)
    for k in np.flatnonzero(reasons):
        possible_ends[k], beyond = inner, ends[k]
        for _ in range(HALVINGS):
            middle = 0.5 * (possible_ends[k] + beyond)
            if refusal(middle):
                beyond = middle
            else:
                possible_ends[k] = middle
        refused.append((varied.worded(beyond), refusal(beyond)))
    return replace(varied, low=np.array(possible_ends[:1]), high=np.array(possible_ends[1:]), refused=tuple(refused))


def _named(varied: Varied, values: Sequence[Any]) -> dict[str, Array]:
    scaled = zip(varied.names, values, varied.scales, strict=True)
    return {name: np.asarray(value) * scale for name, value, scale in scaled}


def _standing_for(varied: Varied) -> tuple[tuple[str, ...], Array]:
    """The parameters of the model that are proportional to the fields, and the field of one unit of each. Without
    parameters, where others change with the fields, too, the larger end of each field."""
    fields, model = varied.corners
    moved = {name: v for name, v in model.values.items() if np.unique(v).size > 1}
    parameters, scales = [], []
    for field in fields:
        top = np.abs(field).argmax()
        matching_names = [
            name
            for name, values in moved.items()
            if np.allclose(values * field[top], field * values[top], rtol=PROPORTIONAL, atol=0.0)
        ]
        if len(matching_names) == 1:
            parameters.append(matching_names[0])
            scales.append(float(field[top] / moved[matching_names[0]][top]))
    if len(parameters) == len(fields) == len(moved):
        return tuple(parameters), np.array(scales)
    return (), np.maximum(np.abs(varied.low), np.abs(varied.high))
