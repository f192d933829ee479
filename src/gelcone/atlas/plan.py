"""The cells of a sweep: which model and initial state belong to each, and with which options it is analysed.

A cell's numbers depend on the plan and its own index alone, so that cells can be computed in any order, in any
grouping and by any worker, with the same result to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError, unknown_name
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Quantity

STATES = {
    "displacement": Quantity("x(0)", "initial displacement", 1.0),
    "velocity": Quantity("x'(0)", "initial velocity", 0.0),
}


@dataclass(frozen=True)
class Plan:
    """A grid of cells: a model with some parameters, or components of the initial state, swept over values.

    Attributes
    ----------
    model : a single model; the swept parameters replace its own.
    over : swept name -> values, the first varying slowest. Names are the model's parameters, ``displacement`` and
        ``velocity``.
    initial : displacement and velocity at time 0 where they are not swept. Default (1, 0).
    draws : name -> values, as many of each: draws of uncertain parameters. Each is made at every point of the grid, as
        a last axis ``draw``. Default none.
    options : option of the analysis -> value, such as ``{"budget": 1500.0}``; those not given take the defaults of
        the analysis, which `gelcone.sweep` checks them against. Default none.

    Raises
    ------
    InputError : for an unknown name, fewer than two values, values that do not increase or are out of bounds, an
        ensemble as model, an initial state of the wrong shape, or draws of unlike number or of a swept name.
    """

    model: ConeModel
    over: Mapping[str, Any]
    initial: tuple[float, ...] = (1.0, 0.0)
    draws: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.model.shape:
            raise InputError(f"a sweep starts from a single model, not from an ensemble of shape {self.model.shape}")
        if np.shape(self.initial) not in ((len(STATES),), (len(self.model.system.states),)):
            raise InputError(f"initial = {self.initial!r}: must be a displacement and a velocity")
        if not (self.over or self.draws):
            raise InputError("over: is empty; give at least one name and its values")
        object.__setattr__(self, "over", {name: swept_values(self.model, name, v) for name, v in self.over.items()})
        object.__setattr__(self, "draws", drawn_values(self.model, self.draws, self.over))
        object.__setattr__(self, "options", dict(self.options))

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the axes: the swept names, then ``draw`` where there are draws."""
        return (*self.over, *(("draw",) if self.draws else ()))

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along `dims`."""
        lengths = [len(values) for values in self.over.values()]
        return (*lengths, *(len(values) for values in list(self.draws.values())[:1]))

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def grid(self) -> dict[str, Array]:
        """Value of every swept and drawn name at every cell, flattened."""
        return self.values(np.arange(self.size))

    def values(self, cells: npt.NDArray[np.intp]) -> dict[str, Array]:
        """Value of every swept and drawn name at some cells of the flattened grid."""
        places = dict(zip(self.dims, np.unravel_index(cells, self.shape), strict=True))
        swept = {name: values[places[name]] for name, values in self.over.items()}
        return swept | {name: values[places["draw"]] for name, values in self.draws.items()}

    def at(self, values: Mapping[str, Array]) -> tuple[ConeModel, Array]:
        """Models and initial states, shape (cells, 2), at given values of the swept names."""
        count = len(next(iter(values.values())))
        states = np.tile(np.asarray(self.initial, dtype=float), (count, 1))
        for column, name in enumerate(STATES):
            if name in values:
                states[:, column] = values[name]
        parameters = {name: v for name, v in values.items() if name not in STATES}
        model = self.model.replace(**parameters) if parameters else self.model
        if not model.shape:
            model = model.replace(damping_ratio=np.full(count, model.damping_ratio))
        return model, states


def swept_values(model: ConeModel, name: str, values: npt.ArrayLike) -> Array:
    """The checked values of a swept parameter or component of the initial state."""
    known = [*model.system.parameters, *STATES]
    if name not in known:
        raise unknown_name("parameter that can be swept", name, known)
    quantity = STATES[name] if name in STATES else model.system.parameters[name]
    array = np.atleast_1d(np.asarray(quantity.check(name, values), dtype=float))
    if array.ndim != 1 or array.size < 2:
        raise InputError(f"{name}: a sweep needs at least 2 values in one dimension, not shape {array.shape}")
    if not (np.diff(array) > 0.0).all():
        raise InputError(f"{name}: the values of a sweep must increase; sort them and remove duplicates")
    if name not in STATES:
        model.replace(**{name: array})
    return array


def drawn_values(model: ConeModel, draws: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Array]:
    """The checked draws of uncertain parameters."""
    checked: dict[str, Array] = {}
    for name, values in draws.items():
        if name in over:
            raise InputError(f"{name}: is both swept and drawn; choose one")
        known = [*model.system.parameters, *STATES]
        if name not in known:
            raise unknown_name("parameter that can be drawn", name, known)
        quantity = STATES[name] if name in STATES else model.system.parameters[name]
        checked[name] = np.atleast_1d(np.asarray(quantity.check(name, values), dtype=float))
        if name not in STATES:
            model.replace(**{name: checked[name]})
    if len({array.shape for array in checked.values()}) > 1 or any(array.ndim != 1 for array in checked.values()):
        shapes = ", ".join(f"{name} {array.shape}" for name, array in checked.items())
        raise InputError(f"draws: must be the same number of values for each parameter, in one dimension: {shapes}")
    return checked


def quantity_of(name: str) -> str:
    """How a swept coordinate turns into SI units: the initial state has a scale, a parameter stays dimensionless."""
    return {"displacement": "length", "velocity": "velocity"}.get(name, "parameter")


def meaning_of(model: ConeModel, name: str) -> str:
    """Long name of a swept coordinate."""
    return STATES[name].meaning if name in STATES else model.system.parameters[name].meaning
