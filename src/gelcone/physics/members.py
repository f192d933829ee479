"""Ensembles: the numbers of many actuators of one system, and their forces, rates and states of the films.

A `ConeModel` has the shape that its user gave it. An analysis flattens it once into `Members`, whose numbers are
arrays (members,) by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.physics.film.film import FilmState
from gelcone.physics.records import system_record
from gelcone.physics.structure import Line
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array, spread


class Ensemble:
    """Actuators of one ``system`` with the parameters ``values``, by name, which broadcast to ``shape``."""

    system: ConeSystem
    values: Mapping[str, Any]
    shape: tuple[int, ...]

    def members(self) -> Members:
        """The ensemble flattened in C order."""
        return self._members

    @cached_property
    def _members(self) -> Members:
        values = {name: spread(value, self.shape).ravel() for name, value in self.values.items()}
        return Members(self.system, values, self.size)

    def parameters(self) -> dict[str, Any]:
        """All parameters by their flat names, and the components as plain data; ``ConeModel.from_parameters`` makes the
        model of them."""
        return dict(self.values) | system_record(self.system)

    @property
    def size(self) -> int:
        """Number of members."""
        return math.prod(self.shape)

    @cached_property
    def own_numbers(self) -> Mapping[str, Any]:
        """The numbers that the formulas take, by name, each a number or an array that broadcasts to the shape."""
        arrays = {name: np.asarray(value, dtype=float) for name, value in self.values.items()}
        return self.system.numbers_of(arrays)

    def numbers(self, trailing: int = 0) -> Mapping[str, Any]:
        """The numbers of the formulas with ``trailing`` axes of length 1 appended for samples."""

        def fit(value: Any) -> Any:
            array = np.asarray(value, dtype=float)
            if array.ndim == 0:
                return array
            return np.broadcast_to(array, self.shape).reshape(self.shape + (1,) * trailing)

        return {name: fit(value) for name, value in self.own_numbers.items()}

    def _at(self, x: npt.ArrayLike) -> tuple[Array, Mapping[str, Any]]:
        array = np.asarray(x, dtype=float)
        return array, self.numbers(max(0, array.ndim - len(self.shape)))

    # --- the film ----------------------------------------------------------------------------------------------------

    def strain(self, x: npt.ArrayLike) -> Any:
        """The film's measure of strain (I1 - 3 in the cone; in a double cone the larger share of the limit) at
        displacements, in the ensemble's shape followed by any sample axes."""
        x, n = self._at(x)
        return self.system.strain(x, n)

    def strain_limit(self, trailing: int = 0) -> Any:
        """The strain that the film cannot reach."""
        limit = self.system.strain_limit(self.numbers(trailing))
        return spread(limit, self.shape + (1,) * trailing)[()]

    def film_state(self, x: npt.ArrayLike, voltage: Any) -> FilmState:
        """The state of the film at x under a voltage."""
        x, n = self._at(x)
        return self.system.film.state(x, voltage, [], n)

    # --- statics -----------------------------------------------------------------------------------------------------

    def energy(self, x: npt.ArrayLike) -> Any:
        """Energy of films and bias without voltage; NaN beyond a film's limit."""
        x, n = self._at(x)
        first, *others = (film.work(x, 0.0, [], n) for film in self.system.films)
        return sum(others, first + self.system.bias.energy(x, n))

    def force(self, x: npt.ArrayLike, voltage: Any = 0.0) -> Any:
        """Static force that holds the disc at x against film, bias and a constant voltage, per mu Vol/(b-a).

        NaN at and beyond the stretch limit, and beyond the voltage at which a film pulls in.
        """
        return self._static(x, voltage, 0)

    def stiffness(self, x: npt.ArrayLike, voltage: Any = 0.0) -> Any:
        """Slope of `force` by x, positive at a stable equilibrium; NaN where the force is."""
        return self._static(x, voltage, 1)

    def film_force(self, x: npt.ArrayLike, voltage: Any = 0.0) -> Any:
        """Static force of the first film and its field alone, without bias and other films, per mu Vol/(b-a).

        NaN at and beyond the film's stretch limit, and beyond the voltage at which it pulls in.
        """
        x, n = self._at(x)
        film, squared = self.system.film, np.square(np.asarray(voltage, dtype=float))
        with np.errstate(all="ignore"):
            inside = film.strain(x, n) < film.strain_limit(n)
            # without a voltage nothing pulls in, which a wrinkling film takes long to compute
            if np.any(squared):
                inside = inside & ~(squared > film.highest_squared(x, n))
            return np.where(inside, film.force(x, squared, [], n)[0], np.nan)[()]

    def _static(self, x: npt.ArrayLike, voltage: Any, order: int) -> Any:
        x, n = self._at(x)
        squared = np.square(np.asarray(voltage, dtype=float))
        with np.errstate(all="ignore"):
            inside = self.system.strain(x, n) < self.system.strain_limit(n)
            # without a voltage nothing pulls in, which a wrinkling film takes long to compute
            if any(np.any(square) for square in self.system.squares_at_rest(squared, n)):
                inside = inside & ~self.system.pulled_in(x, squared, n)
            return np.where(inside, self.system.static_force(x, squared, n)[order], np.nan)[()]

    # --- the drive ---------------------------------------------------------------------------------------------------

    @property
    def drive_period(self) -> Array:
        """Period of the voltage, 2 pi/omega."""
        return self.system.waveform.period(self.own_numbers)

    @property
    def forcing_period(self) -> Array:
        """Smallest period of the force: pi/omega for a pure sine, 2 pi/omega with a bias."""
        return self.system.forcing_period(self.own_numbers)

    @property
    def peak_voltage(self) -> Any:
        """Largest absolute value of the commanded voltage."""
        return self.system.waveform.peak(self.own_numbers)

    @property
    def offset_voltage(self) -> Any:
        """Commanded voltage without amplitude."""
        return self.system.waveform.offset(self.own_numbers)

    @property
    def peak_voltages(self) -> list[Any]:
        """Largest absolute value of each film's commanded voltage."""
        system = self.system

        def peak(line: Line) -> Any:
            if line.drive is None:
                return self.peak_voltage
            samples = system.waveform.samples(self.own_numbers)
            return np.abs(system.command_of(line, samples, self.numbers(trailing=1))).max(axis=-1)[()]

        return [peak(line) for line in system.film_lines]

    def __getattr__(self, name: str) -> Any:
        """A parameter by its name; None for one that the system knows but does not use."""
        if name.startswith("_") or name in ("system", "values", "shape"):
            raise AttributeError(name)
        if name in self.values:
            return self.values[name]
        if name in self.system.parameters:
            return None
        raise AttributeError(f"{type(self).__name__} has no parameter {name!r}")


BLOCK = 2**24
"""More than the rows of any block."""
SAMPLES = 2**14
"""Samples of a motion that are evaluated at once: a membrane takes up to 20 kB for the current of each."""


class Rows(Mapping[str, Array]):
    """Numbers of members by name, (members,) each.

    Numbers that all members share are stored once, and broadcast when they are read: a film may have a thousand, of
    which a formula takes few. The place of a number is block times `BLOCK` plus row, one integer, since thousands of
    places are read at once.
    """

    def __init__(self, places: Mapping[str, int], *blocks: Array):
        self._places, self._blocks = places, blocks

    @classmethod
    def of(cls, numbers: Mapping[str, Any], shape: tuple[int, ...]) -> Rows:
        """Store numbers or arrays that broadcast to a ``shape``, (members,)."""
        alike = {name: value for name, value in numbers.items() if isinstance(value, float)}
        others = [name for name in numbers if name not in alike]
        matrix = np.array([spread(numbers[name], shape) for name in others]).reshape(-1, *shape)
        alike |= zip(others, matrix[:, 0].tolist(), strict=True)
        bits = matrix.view(np.int64)
        alone = np.flatnonzero((bits != bits[:, :1]).any(axis=1))
        places = {name: k for k, name in enumerate(numbers)} | {others[row]: BLOCK + k for k, row in enumerate(alone)}
        shared = np.array([alike[name] for name in numbers]).reshape(-1, *(1 for _ in shape))
        return cls(places, np.broadcast_to(shared, (len(alike), *shape)), matrix[alone])

    def __getitem__(self, name: str) -> Array:
        block, row = divmod(self._places[name], BLOCK)
        values: Array = self._blocks[block][row]
        return values

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def take(self, index: Any) -> Rows:
        """The numbers of the members at ``index``, a slice, mask or array."""
        shared, *blocks = self._blocks[0], *(block[:, index] for block in self._blocks[1:])
        count = blocks[0].shape[1]
        fewer = count <= shared.shape[1]
        return Rows(
            self._places, shared[:, :count] if fewer else np.broadcast_to(shared[:, :1], (len(shared), count)), *blocks
        )

    def missing(self, names: Sequence[str]) -> list[str]:
        """The ``names`` without a number."""
        return [name for name in names if name not in self._places]

    def fill(self, names: Sequence[str], matrix: Array) -> None:
        """Write the numbers of ``names`` into a ``matrix`` (names, members)."""
        which, rows = np.divmod(np.fromiter(map(self._places.__getitem__, names), np.intp, len(names)), BLOCK)
        for k, block in enumerate(self._blocks):
            matrix[which == k] = block[rows[which == k]]

    def trailing(self, axes: int) -> Rows:
        """The numbers with ``axes`` axes of length 1 appended."""
        return Rows(self._places, *(block[(..., *[None] * axes)] for block in self._blocks))

    def __or__(self, more: Mapping[str, Array]) -> Rows:
        """The numbers with some replaced or added, arrays of the same shape."""
        if not more:
            return self
        places = {name: BLOCK * len(self._blocks) + k for k, name in enumerate(more)}
        return Rows({**self._places, **places}, *self._blocks, np.array([*more.values()]))


class Members(Ensemble):
    """A flat ensemble: ``values`` are arrays (members,)."""

    def __init__(self, system: ConeSystem, values: Mapping[str, Any], size: int):
        self.system: ConeSystem = system
        self.shape: tuple[int, ...] = (size,)
        arrays = {name: np.asarray(value, dtype=float).ravel() for name, value in values.items()}
        self.values: Mapping[str, Any] = {name: spread(array, self.shape) for name, array in arrays.items()}

    @cached_property
    def own_numbers(self) -> Rows:
        """The numbers that the formulas take, by name, each (members,)."""
        return Rows.of(self.system.numbers_of(self.values), self.shape)

    def numbers(self, trailing: int = 0) -> Mapping[str, Any]:
        """The numbers of the formulas with ``trailing`` axes of length 1 appended for samples."""
        return self.own_numbers.trailing(trailing) if trailing else self.own_numbers

    def members(self) -> Members:
        return self

    def take(self, index: Any) -> Members:
        """The members at ``index``, a slice, mask or array."""
        taken = Members.__new__(Members)
        taken.system = self.system
        taken.values = {name: value[index] for name, value in self.values.items()}
        taken.own_numbers = self.own_numbers.take(index)
        taken.shape = taken.values["damping_ratio"].shape
        taken.rate, taken.fastest = self.rate[index], self.fastest[index]  # every integration reads them
        return taken

    def replace(self, **changes: npt.ArrayLike) -> Members:
        """The members with some parameters in use changed, numbers or arrays (members,)."""
        return Members(self.system, {**self.values, **changes}, self.size)

    def number(self, name: str) -> Array:
        """A number by its name, (members,)."""
        return self.own_numbers[name]

    def numbers_at(self, member: int) -> dict[str, float]:
        """The numbers of one member."""
        return {name: float(values[member]) for name, values in self.own_numbers.items()}

    # --- integration -------------------------------------------------------------------------------------------------

    @cached_property
    def damped(self) -> npt.NDArray[np.bool_]:
        """Whether each member is damped."""
        return np.asarray(self.values["damping_ratio"] > 0.0)

    @cached_property
    def rate(self) -> Array:
        """An upper bound of the rates of the motion and of small deviations from it, per unit time, (members,).

        Damping 2 zeta, plus the root of the sum of the stiffnesses of bias and film (at rest, or their scale if that is
        larger) and of the field at the peak voltage.
        """
        n = self.own_numbers
        scale = sum((film.stiffness_scale(n) for film in self.system.films), self.system.bias.stiffness_scale(n))
        squared = sum(np.square(peak) for peak in self.peak_voltages)
        with np.errstate(all="ignore"):
            at_rest = np.abs(self.stiffness(np.zeros(self.shape)))
        # a film that is at its stretch limit while flat has no stiffness at rest
        stiffness = np.fmax(scale, np.where(np.isfinite(at_rest), at_rest, 0.0))
        rate = 2.0 * self.values["damping_ratio"] + np.sqrt(1.0 + stiffness + squared)
        return spread(rate, self.shape)

    @cached_property
    def fastest(self) -> Array:
        """An upper bound of the rates of deviations from a motion, per unit time, (members,): `rate`, or the fastest
        decay of a state of a component, whether or not its circuit saturates at the start, where deviations of it stay
        as they are."""
        system, n, start = self.system, self.own_numbers, list(self.start_states((0.0, 0.0)).T)
        if system.planar:
            return self.rate
        free = {str(border.switch): 1.0 for film, border in system.borders if film is None}
        decays: list[Array] = []
        for switches in ({}, free) if free else ({},):
            _, slopes = system.rates_and_slopes(np.zeros(self.shape), start, n, switches)
            decays += [spread(np.abs(row[i + 1]), self.shape) for i, row in enumerate(slopes) if i > 1]
        with np.errstate(invalid="ignore"):
            return np.fmax.reduce([self.rate, *decays])

    @property
    def time_constant(self) -> Array:
        """The slowest time constant of the states that components add, (members,)."""
        slowest = [spread(part.time_constant(self.own_numbers), self.shape) for part in self.system.parts]
        return np.maximum.reduce(slowest)

    @cached_property
    def symmetric(self) -> npt.NDArray[np.bool_]:
        """Mask of members whose motions have mirror images: their flat film is an equilibrium at every voltage."""
        system, n = self.system, self.numbers()
        odd = reduce(np.logical_and, (film.odd(n) for film in system.films), system.bias.odd(n))
        return np.broadcast_to(odd, self.shape)

    def start_states(self, disc: npt.ArrayLike) -> Array:
        """States (members, N) with displacement and velocity ``disc``, (2,) or (members, 2), and the initial values of
        all others there."""
        x, u = np.broadcast_to(np.asarray(disc, dtype=float), (self.size, 2)).T
        return np.stack(
            [spread(value, self.shape) for value in (x, u, *self.system.starts(x, self.own_numbers))], axis=1
        )

    def flow(self, times: Array, states: Array) -> tuple[list[Any], list[list[Any]]]:
        """Rates of change and their Jacobian along motions, at ``times`` (members, samples) and ``states`` (..., N)."""
        n = self.numbers(times.ndim - 1)
        return self.system.flow(times, list(np.moveaxis(states, -1, 0)), n)

    def film_states(self, states: Array, voltages: Sequence[Array]) -> list[FilmState]:
        """States of the films along motions, under the ``voltages`` on each.

        ``states`` are (members, samples, N), or (members, samples, 1) for settled films held at displacements.
        """
        z, n = list(np.moveaxis(states, -1, 0)), self.numbers(trailing=states.ndim - 2)
        pairs = zip(self.system.films, voltages, strict=True)
        film_states = [film.state(z[0], v, self.system.states_of(z, "film", k), n) for k, (film, v) in enumerate(pairs)]
        if not self.system.circuit.delays or len(z) < len(self.system.states):
            return film_states
        extra_stress = (voltages[0] ** 2 - self.system.squared_at(voltages[0], z, n)) * self.system.film.capacitance(
            z[0], 0.0, [], n
        )  # the delayed share of the field pulls less, or more
        stresses = {name: getattr(film_states[0], name) + extra_stress for name in ("meridional_stress", "hoop_stress")}
        return [film_states[0]._replace(**stresses)]

    def voltages(self, times: Array, states: Array) -> list[Array]:
        """Voltage on each film along motions."""
        return self.along(self.system.voltages, times, states)

    def along(self, values: Callable[..., Sequence[Any]], times: Array, states: Array) -> list[Array]:
        """Evaluate a function of the system, such as `currents`, along motions, (members, samples) each, at ``times``
        (members, samples) and ``states`` (members, samples, N)."""
        z, n, blocks = np.moveaxis(states, -1, 0), self.numbers(times.ndim - 1), []
        for start in range(0, max(times.shape[-1], 1), SAMPLES):
            block_times = times[..., start : start + SAMPLES]
            series = values(block_times, list(z[..., start : start + SAMPLES]), n)
            blocks.append([np.broadcast_to(value, block_times.shape) for value in series])
        return [np.concatenate(parts, axis=-1) for parts in zip(*blocks, strict=True)]
