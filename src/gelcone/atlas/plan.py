"""The plan of a sweep: the model, initial state and options of each cell.

A cell's numbers depend on the plan and its own index alone, so that cells can be computed in any order, in any
grouping and by any worker, with the same result to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.dataset import attributes
from gelcone.devices.analysis import Scaled, check_model, check_one, dimensionless
from gelcone.devices.device import Device
from gelcone.devices.points import GELS, at, device_at, field_attributes, read_state, read_swept, shown_value
from gelcone.errors import InputError, check_name, described
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Quantity
from gelcone.register.analyses import sweepable

STATES = {
    "displacement": Quantity("x(0)", "initial displacement", 1.0),
    "velocity": Quantity("x'(0)", "initial velocity", 0.0),
}
DEFAULT_INITIAL = (1.0, 0.0)


@dataclass(frozen=True)
class Plan:
    """A grid of cells: a model or a device with some of its numbers, or of the initial state's, swept over values.

    With a device all is in SI units, and any number of it can be swept: each cell has the model and the start of the
    device with the cell's values.

    Attributes
    ----------
    model : a single model, or a single `Device`; what is swept replaces its own.
    over : swept name -> values, the first varying slowest. Names are the model's parameters or the device's fields
        (``"film_thickness"``, ``"material.shear_modulus"``), ``displacement`` and ``velocity``, and of a model also the
        initial values of other states, by their names. Values of a device are in SI, or texts with units; of
        ``material`` names of gels that ship, in the order given.
    initial : displacement and velocity, or all states of a model, at time 0 where they are not swept; of a device
        displacement and velocity in m and m/s. Default: (1, 0);
        of a device its rest or release, see `Device.initial_state`.
    draws : name -> values, as many of each: draws of uncertain parameters. Each is made at every point of the grid, as
        a last axis ``draw``. Default none.
    options : option of the analysis -> value, such as ``{"budget": 1500.0}``; those not given take the defaults of
        the analysis, which `gelcone.sweep` checks them against. Those of a device are in SI units, or texts with units,
        and are scaled to the model. Default none.

    Raises
    ------
    InputError : for an unknown name, fewer than two values, values that do not increase or are out of bounds, an
        ensemble as model, an initial state of the wrong shape, or draws of unlike number or of a swept name. Values
        within bounds that exclude one another, such as a disc larger than its film, are refused where cells are made.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> plan = gelcone.Plan(device, {"film_thickness": ["0.18 mm", "0.2 mm"], "frequency": [9.0, 10.0, 11.0]})
    >>> plan.shape
    (2, 3)
    """

    model: ConeModel | Device
    over: Mapping[str, Any]
    initial: Any = None
    draws: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_model(self.cone, "Plan")
        check_one(self.cone, "Plan")
        if not isinstance(self.over, Mapping):
            raise InputError(f"over: was given {described(self.over)}; give names and their values, name -> values")
        if not (self.over or self.draws):
            raise InputError("over: is empty; give at least one name and its values, or draws")
        object.__setattr__(self, "initial", self._initial())
        object.__setattr__(self, "over", {name: self._swept(name, v) for name, v in self.over.items()})
        object.__setattr__(self, "draws", self._drawn())
        object.__setattr__(self, "options", self._options())

    @property
    def device(self) -> Device | None:
        """The device, None for a plan of a model."""
        return self.model if isinstance(self.model, Device) else None

    @cached_property
    def cone(self) -> ConeModel:
        """The model before anything is swept."""
        return self.model.to_model() if isinstance(self.model, Device) else self.model

    @property
    def _own_states(self) -> list[str]:
        """The names of the states that the components of a model add."""
        return [] if self.device is not None else [state.name for state in self.cone.system.states[len(STATES) :]]

    def _options(self) -> dict[str, Any]:
        """The options, for a device scaled from SI to the model."""
        if self.device is None:
            return dict(self.options)
        quantities = {
            name: option.quantity for analysis in sweepable().values() for name, option in analysis.options.items()
        }
        if all(
            value is None or isinstance(value, Scaled) or not quantities.get(name)
            for name, value in self.options.items()
        ):
            return dict(self.options)
        device = self.device
        made = self.values(self._makes(lambda values: at(device, values), np.arange(self.size)))
        return dimensionless(quantities, self.options, at(device, made).scales)

    def _initial(self) -> tuple[float, ...] | None:
        """The checked initial state; None for a device that starts from its own."""
        if self.initial is None:
            return None if self.device is not None else DEFAULT_INITIAL
        if self.device is not None:
            return read_state(self.initial)
        if np.shape(self.initial) not in ((len(STATES),), (len(self.cone.system.states),)):
            raise InputError(f"initial = {self.initial!r}: must be a displacement and a velocity")
        return tuple(map(float, self.initial))

    def _swept(self, name: str, values: npt.ArrayLike) -> Array:
        """The checked values of a swept name."""
        if self.device is not None and name == GELS:
            gels: Array = read_swept(self.device, name, values)
            if gels.size < 2 or np.unique(gels).size < gels.size:
                raise InputError("material: a sweep needs at least 2 gels, each once")
            return gels
        array = np.atleast_1d(np.asarray(self._checked(name, values, "swept"), dtype=float))
        if array.ndim != 1 or array.size < 2:
            raise InputError(f"{name}: a sweep needs at least 2 values in one dimension, not shape {array.shape}")
        falls = np.flatnonzero(~(np.diff(array) > 0.0))
        if falls.size:
            before, after = (shown_value(self.device, name, value) for value in array[falls[0] :][:2])
            increase = "the values of a sweep must increase, sort them and leave out duplicates"
            raise InputError(f"{name}: {after} comes after {before}; {increase}")
        return array

    def _drawn(self) -> dict[str, Array]:
        """The checked draws of uncertain parameters."""
        if not isinstance(self.draws, Mapping):
            raise InputError(f"draws = {self.draws!r}: must be names and their values, as gelcone.draw gives them")
        checked: dict[str, Array] = {}
        for name, values in self.draws.items():
            if name in self.over:
                raise InputError(f"{name}: is both swept and drawn; choose one")
            checked[name] = np.atleast_1d(np.asarray(self._checked(name, values, "drawn"), dtype=float))
        if len({array.shape for array in checked.values()}) > 1 or any(array.ndim != 1 for array in checked.values()):
            shapes = ", ".join(f"{name} {array.shape}" for name, array in checked.items())
            raise InputError(f"draws: must be the same number of values for each parameter, in one dimension: {shapes}")
        return checked

    def _checked(self, name: str, values: Any, how: str) -> Any:
        """Values of a name that can be swept or drawn, within their bounds."""
        if self.device is not None:
            return read_swept(self.device, name, values)
        known = [*self.cone.system.parameters, *STATES, *self._own_states]
        check_name(f"parameter that can be {how}", name, known)
        if name in STATES:
            return STATES[name].check(name, values)
        if name in self._own_states:
            return Quantity(name, "initial state", 0.0).check(name, values)
        return self.cone.system.parameters[name].check(name, values)

    def check_order(self, command: str) -> None:
        """Raises `InputError` for a plan over gels, which have no order."""
        if GELS in self.over:
            raise InputError(f"material: gels have no order; {command} takes numbers, such as material.shear_modulus")

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
        """Number of cells."""
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

    def possible(self) -> tuple[npt.NDArray[np.intp], ConeModel, Array]:
        """The cells whose values make an actuator, by rising index, with their models and initial states as from `at`.

        Raises `InputError`, the reason of the first cell, where none does.
        """
        cells = np.arange(self.size)
        try:
            return (cells, *self.at(self.grid))
        except InputError:
            device = self.device
            if device is not None:  # first without their rests, which take most of the time
                cells = self._makes(lambda values: at(device, values), cells)
            made = self._makes(self.at, cells)
        return (made, *self.at(self.values(made)))

    def refusal(self, cell: int) -> str:
        """The reason why the values of a cell make no actuator; empty where they do."""
        try:
            self.at(self.values(np.array([cell])))
        except InputError as error:
            return str(error)
        return ""

    def _makes(self, make: Callable[[dict[str, Array]], Any], cells: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
        """Return those of the ``cells`` for whose values ``make`` raises no `InputError`, by halves; raise that of the
        first cell if there are none."""
        try:
            make(self.values(cells))
            return cells
        except InputError:
            if cells.size == 1:
                raise
        refused, made = list[InputError](), list[npt.NDArray[np.intp]]()
        for half in np.array_split(cells, 2):
            try:
                made.append(self._makes(make, half))
            except InputError as error:
                refused.append(error)
        if not made:
            raise refused[0]
        return np.concatenate(made)

    def at(self, values: Mapping[str, Array]) -> tuple[ConeModel, Array]:
        """Models and initial states, shape (cells, 2) or (cells, N), at given values of the swept names."""
        if self.device is not None:
            return device_at(self.device, values, self.initial)
        return model_at(self.cone, values, self.initial)


def model_at(model: ConeModel, values: Mapping[str, Array], initial: Sequence[float] | None) -> tuple[ConeModel, Array]:
    """Models and initial states, (cells, 2) or (cells, N), at ``values`` of parameters and states, (cells,) each."""
    count = len(next(iter(values.values())))
    states = np.tile(np.asarray(initial, dtype=float), (count, 1))
    for column, name in enumerate(STATES):
        if name in values:
            states[:, column] = values[name]
    state_names = [*STATES, *(state.name for state in model.system.states[len(STATES) :])]
    parameters = {name: v for name, v in values.items() if name not in state_names}
    if parameters:
        model = model.replace(**parameters)
    if not model.shape:
        model = model.replace(damping_ratio=np.full(count, model.damping_ratio))
    if swept := [name for name in state_names[len(STATES) :] if name in values]:
        whole = model.members().start_states(states[:, :2])
        whole[:, : states.shape[1]] = states
        for name in swept:
            whole[:, state_names.index(name)] = values[name]
        states = whole
    return model, states


def about(plan: Plan, name: str) -> dict[str, str]:
    """The attributes of a swept coordinate: its meaning, its unit, and its scale in SI units."""
    if plan.device is not None:
        return field_attributes(plan.device, name)
    state_meanings = {state.name: state.meaning for state in plan.cone.system.states[len(STATES) :]}
    if name in state_meanings:
        return attributes(f"initial {state_meanings[name]}", "parameter")
    meaning = STATES[name].meaning if name in STATES else plan.cone.system.parameters[name].meaning
    disc = {state.name: state.quantity for state in plan.cone.system.states[: len(STATES)]}
    return attributes(meaning, disc.get(name, "parameter"))
