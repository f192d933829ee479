"""Forces on the disc other than the film's: springs, a buckled beam, weight, a constant force, and several together."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.contract import (
    DEFAULTS,
    GRID,
    NUMBERS,
    ONE_EACH,
    PAIR,
    PLACES,
    Trial,
    called,
    check_formulas,
    check_numbers,
    check_rates,
    check_slope,
    listed,
    numbers_of,
)
from gelcone.physics.quadrature import integral
from gelcone.quantity import Quantity


class Bias(Component):
    """A force on the disc that is not the film's, counted positive where it pulls the disc down, per mu Vol/(b-a).

    A new bias supplies `force`; everything else follows from it, and is overridden where a closed form is known.

    Examples
    --------
    >>> import gelcone
    >>> class Magnet(gelcone.Bias):
    ...     name = "magnet"
    ...     parameters = {"magnet_strength": gelcone.Quantity("m", "strength", 0.2, lower=0.0)}
    ...
    ...     def force(self, x, y, n, xp=None):
    ...         gap = 1.0 / (4.0 + x * x)
    ...         return -n["magnet_strength"] * gap, 2.0 * n["magnet_strength"] * x * gap * gap
    >>> both = gelcone.Together((gelcone.LinearSpring(), Magnet()))
    >>> model = gelcone.ConeModel(bias=both, magnet_strength=0.4)
    >>> round(gelcone.static(model, [0.0]).equilibrium_displacement.values.item(), 4)
    0.0662
    """

    @abstractmethod
    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """Force at the displacement x and its derivative by x. ``y`` holds the bias's states; it is empty in
        statics, which use the settled bias."""

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Compare the stated slope of the force with its derivative, too."""
        super().prove(given)
        n, many = numbers_of(self, given)
        y = [np.broadcast_to(start, GRID.shape) for start in self.starts(GRID, many)]
        check_formulas(
            self,
            [
                Trial("force", (GRID, [], many), PAIR),
                Trial("force", (GRID, y, many), PAIR),
                Trial("rates", (GRID, GRID, y, many), listed(len(self.states))),
                *(Trial(name, (GRID, many), NUMBERS) for name in ("energy", "turning", "secant")),
                *(Trial(name, (many,), ONE_EACH) for name in ("odd", "free_height", "stiffness_scale")),
            ],
        )
        check_numbers(self, "force", called(self, "force", PLACES, [], n))
        held = [start[0] for start in y]
        check_slope(self, lambda x, states, xp: self.force(x, states, n, xp), held, bool(self.odd(n)))
        check_rates(self, len(self.states), lambda z, xp: self.rates(z[0], z[1], z[2:], n, xp))

    def rates(self, x: Any, velocity: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the bias's states."""
        return []

    def energy(self, x: Any, n: Numbers) -> Any:
        """Energy at x, 0 at the flat film."""
        return integral(lambda at: self.force(at, [], n)[0], np.asarray(x, dtype=float))

    def turning(self, x: Any, n: Numbers) -> Any:
        """x dF/dx - F of the force F."""
        force, slope = self.force(x, [], n)
        return x * slope - force

    def secant(self, x: Any, n: Numbers) -> Any:
        """F/x; at x = 0 its limit, infinite where the force does not vanish there."""
        force, slope = self.force(x, [], n)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where((np.asarray(x) == 0.0) & (force == 0.0), slope, force / np.asarray(x, dtype=float))[()]

    def odd(self, n: Numbers) -> Any:
        """Whether the force is odd in x. Default: whether it vanishes at the flat film."""
        return self.force(0.0, [], n)[0] == 0.0

    def free_height(self, n: Numbers) -> Any:
        """A displacement at which the force vanishes, from which a search for equilibria begins. Default 0."""
        return 0.0

    def stiffness_scale(self, n: Numbers) -> Any:
        """A typical stiffness, which bounds the rate of the motion. Default: that at the flat film."""
        return np.abs(self.force(0.0, [], n)[1])


def summed(pulls: Sequence[tuple[Any, Any]]) -> tuple[Any, Any]:
    """The sums of forces and of their slopes."""
    return reduce(lambda one, other: (one[0] + other[0], one[1] + other[1]), pulls)


class LinearSpring(Bias):
    """F = kappa (x - x0).

    Examples
    --------
    >>> import gelcone
    >>> force, slope = gelcone.LinearSpring().force(0.5, [], {"spring_stiffness": 2.0, "rest_height": 0.75})
    >>> force, slope
    (-0.5, 2.0)
    """

    name = "spring"
    parameters = {
        "spring_stiffness": Quantity("kappa", "spring stiffness k (b-a)^2/(mu Vol)", 1.5, lower=0.0, scale="stiffness"),
        "rest_height": Quantity("x0", "height at which the spring is free, h0/(b-a)", 0.0, scale="length"),
    }

    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return n["spring_stiffness"] * (x - n["rest_height"]), n["spring_stiffness"]

    def energy(self, x: Any, n: Numbers) -> Any:
        """(kappa/2) (x - x0)^2, which is not 0 at the flat film."""
        return 0.5 * n["spring_stiffness"] * (x - n["rest_height"]) * (x - n["rest_height"])

    def turning(self, x: Any, n: Numbers) -> Any:
        return n["spring_stiffness"] * n["rest_height"] + 0.0 * x

    def secant(self, x: Any, n: Numbers) -> Any:
        """kappa - kappa x0/x."""
        push = n["spring_stiffness"] * n["rest_height"]
        with np.errstate(divide="ignore", invalid="ignore"):
            return n["spring_stiffness"] - np.where(push == 0.0, 0.0, push / np.asarray(x, dtype=float))

    def free_height(self, n: Numbers) -> Any:
        return n["rest_height"]

    def stiffness_scale(self, n: Numbers) -> Any:
        return n["spring_stiffness"]


class BuckledBeam(Bias):
    """F = k1 d + k3 d^3, d = x - xb: a beam clamped at both ends and pressed along its axis, held at its middle.

    A beam beyond buckling has a negative k1: it pushes away from its straight shape at xb, up to d = sqrt(-k1/k3) on
    either side, where it is free. The first mode of a buckled beam: Holmes,
    Phil. Trans. R. Soc. A 292 (1979) 419, doi 10.1098/rsta.1979.0068.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(bias="beam", hoop_prestretch=1.2)
    >>> gelcone.static(model, [0.0]).equilibrium_displacement.values.round(4).tolist()
    [[-0.2944, 0.0, 0.2944]]
    """

    name = "beam"
    parameters = {
        "beam_stiffness": Quantity(
            "k1", "beam's stiffness where it is straight, over mu Vol/(b-a)^2", -0.5, scale="stiffness"
        ),
        "beam_cubic": Quantity(
            "k3", "beam's cubic stiffness, over mu Vol/(b-a)^4", 1.0, lower=0.0, scale="cubic stiffness"
        ),
        "beam_height": Quantity("xb", "height at which the beam is straight, over b-a", 0.0, scale="length"),
    }

    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        d = x - n["beam_height"]
        stiffening = n["beam_cubic"] * (d * d)
        return d * (n["beam_stiffness"] + stiffening), n["beam_stiffness"] + 3.0 * stiffening

    def energy(self, x: Any, n: Numbers) -> Any:
        """k1 d^2/2 + k3 d^4/4, which is 0 where the beam is straight."""
        d = x - n["beam_height"]
        squared = d * d
        return squared * (0.5 * n["beam_stiffness"] + 0.25 * n["beam_cubic"] * squared)

    def odd(self, n: Numbers) -> Any:
        return np.asarray(n["beam_height"]) == 0.0

    def free_height(self, n: Numbers) -> Any:
        """The higher of the two free displacements of a buckled beam; else the one at which the beam is straight."""
        with np.errstate(divide="ignore", invalid="ignore"):
            squared = -np.asarray(n["beam_stiffness"]) / n["beam_cubic"]
            away = np.where((squared > 0.0) & np.isfinite(squared), np.sqrt(np.maximum(squared, 0.0)), 0.0)
        return (n["beam_height"] + away)[()]

    def stiffness_scale(self, n: Numbers) -> Any:
        """The largest |k1| + 3 k3 d^2 between the film's plane and one film width above it."""
        farthest = np.maximum(np.abs(n["beam_height"]), np.abs(1.0 - n["beam_height"]))
        return np.abs(n["beam_stiffness"]) + 3.0 * n["beam_cubic"] * np.square(farthest)


class Weight(Bias):
    """F = W: gravity along the axis pulls the disc, and what it carries, towards the film's plane and beyond.

    A negative W is that of a device that hangs: gravity pulls the disc away from the plane.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(bias="spring+weight", rest_height=0.8, weight=0.1)
    >>> round(gelcone.static(model, [0.0]).equilibrium_displacement.values.item(), 4)
    0.5697
    """

    name = "weight"
    parameters = {
        "weight": Quantity("W", "weight m g (b-a)/(mu Vol), positive where it pulls the disc down", 0.1, scale="force")
    }

    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return n["weight"] + 0.0 * x, 0.0 * x

    def energy(self, x: Any, n: Numbers) -> Any:
        return n["weight"] * x

    def stiffness_scale(self, n: Numbers) -> Any:
        return 0.0 * n["weight"]


class ConstantForce(Bias):
    """F = -P: a force that pushes the disc away from the film's plane wherever it is.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(bias="force", push=0.2, hoop_prestretch=1.4)
    >>> round(gelcone.static(model, [0.0]).equilibrium_displacement.values.item(), 4)
    0.3364
    """

    name = "force"
    parameters = {
        "push": Quantity(
            "P", "constant force over mu Vol/(b-a), positive where it pushes the disc up", 0.1, scale="force"
        )
    }

    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return 0.0 * x - n["push"], 0.0 * x

    def energy(self, x: Any, n: Numbers) -> Any:
        return -n["push"] * x

    def stiffness_scale(self, n: Numbers) -> Any:
        return 0.0 * n["push"]


@dataclass(frozen=True)
class Together(Bias):
    """Several biases at once: their forces add up.

    Parameters
    ----------
    parts : at least two biases, of different kinds.

    Examples
    --------
    >>> import gelcone
    >>> both = gelcone.Together((gelcone.LinearSpring(), gelcone.Weight()))
    >>> force, slope = both.force(0.5, [], {"spring_stiffness": 2.0, "rest_height": 0.5, "weight": 0.1})
    >>> force, slope
    (0.1, 2.0)
    """

    parts: tuple[Bias, ...]

    name = "together"

    def __post_init__(self) -> None:
        names = [part.name for part in self.parts]
        if len(names) < 2 or len(set(names)) < len(names):
            raise InputError(f"bias = {'+'.join(names)}: must be at least two different ones; name each once")

    @property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        """The states of all parts."""
        return tuple(state for part in self.parts for state in part.states)

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        return {name: quantity for part in self.parts for name, quantity in part.parameters.items()}

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for part in self.parts:
            values |= part.complete({name: given[name] for name in part.parameters if name in given})
        return values

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        return {name: value for part in self.parts for name, value in part.numbers(parameters).items()}

    def _own(self, y: list[Any]) -> list[tuple[Bias, list[Any]]]:
        """Each part with its states; none in statics."""
        taken, pairs = 0, []
        for part in self.parts:
            count = len(part.states) if y else 0
            pairs.append((part, y[taken : taken + count]))
            taken += count
        return pairs

    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return summed([part.force(x, states, n, xp) for part, states in self._own(y)])

    def rates(self, x: Any, velocity: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        return [rate for part, states in self._own(y) for rate in part.rates(x, velocity, states, n, xp)]

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        return [start for part in self.parts for start in part.starts(x, n)]

    def energy(self, x: Any, n: Numbers) -> Any:
        return sum(part.energy(x, n) for part in self.parts)

    def turning(self, x: Any, n: Numbers) -> Any:
        return sum(part.turning(x, n) for part in self.parts)

    def odd(self, n: Numbers) -> Any:
        return np.logical_and.reduce([np.asarray(part.odd(n)) for part in self.parts])

    def free_height(self, n: Numbers) -> Any:
        """The first part's, shifted by one Newton step of the total force."""
        first = self.parts[0].free_height(n)
        force, slope = self.force(np.asarray(first, dtype=float), [], n)
        with np.errstate(divide="ignore", invalid="ignore"):
            shift = force / slope
        return (first - np.where((np.asarray(slope) > 0.0) & np.isfinite(shift), shift, 0.0))[()]

    def stiffness_scale(self, n: Numbers) -> Any:
        return sum(part.stiffness_scale(n) for part in self.parts)

    def time_constant(self, n: Numbers) -> Any:
        return np.maximum.reduce([np.asarray(part.time_constant(n)) for part in self.parts])


BIASES: dict[str, Bias] = {bias.name: bias for bias in (LinearSpring(), BuckledBeam(), Weight(), ConstantForce())}
"""Name -> bias that ships; several together are written with a plus, as in ``"spring+weight"``."""
