"""What pulls on the disc besides the film: the linear spring."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from gelcone.physics.component import Component, Numbers
from gelcone.physics.quadrature import integral
from gelcone.quantity import Quantity


class Bias(Component):
    """A force on the disc that is not the film's, counted positive where it pulls the disc down, per mu Vol/(b-a).

    A new one supplies `force`; the rest follows from it, and is overridden where a closed form is known.
    """

    @abstractmethod
    def force(self, x: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """Force at the displacement x and its derivative by x; ``y`` are the bias's own states, empty where it has
        none and in statics, which ask for the force once they have settled."""

    def rates(self, x: Any, velocity: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the bias's own states."""
        return []

    def energy(self, x: Any, n: Numbers) -> Any:
        """Energy at x, from the flat film on."""
        return integral(lambda at: self.force(at, [], n)[0], np.asarray(x, dtype=float))

    def turning(self, x: Any, n: Numbers) -> Any:
        """x dF/dx - F of the force F."""
        force, slope = self.force(x, [], n)
        return x * slope - force

    def secant(self, x: Any, n: Numbers) -> Any:
        """F/x; at x = 0 its limit, infinite where the flat film is pushed."""
        force, slope = self.force(x, [], n)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where((np.asarray(x) == 0.0) & (force == 0.0), slope, force / np.asarray(x, dtype=float))[()]

    def free_height(self, n: Numbers) -> Any:
        """A displacement at which it does not pull; where a search for equilibria begins. Default 0."""
        return 0.0

    def stiffness_scale(self, n: Numbers) -> Any:
        """A typical stiffness, which bounds how fast the disc moves. Default: that at the flat film."""
        return np.abs(self.force(0.0, [], n)[1])


class LinearSpring(Bias):
    """F = kappa (x - x0)."""

    name = "spring"
    parameters = {
        "spring_stiffness": Quantity("kappa", "spring stiffness k (b-a)^2/(mu Vol)", 1.5, lower=0.0),
        "rest_height": Quantity("x0", "height at which the spring is free, h0/(b-a)", 0.0),
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


BIASES: dict[str, Bias] = {bias.name: bias for bias in (LinearSpring(),)}
