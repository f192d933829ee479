"""Systems that the tests integrate: the cone from its formulas, and small ones with known motions."""

from dataclasses import dataclass
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from gelcone.motion.engine import compile as compiler
from gelcone.physics.differentiate import derivatives, jacobian


def assembly(text, machine):
    """The machine code of a module in words."""
    target = compiler._target_machine(machine, machine.triple == compiler.host().triple)
    module = llvm.parse_assembly(text)
    module.triple = target.triple
    module.data_layout = str(target.target_data)
    return str(target.emit_assembly(module))


@dataclass(frozen=True)
class Cone:
    """x'' = kappa x0 - 2 zeta x' + x (v^2 - kappa - h) with Gent's film, h = (A q^2 - G)/(q M), q = 1 + x^2."""

    states = ("displacement", "velocity")
    numbers = ("zeta", "kappa", "rest", "A", "B", "G", "s", "amplitude", "bias", "frequency")
    bounding_powers = 2

    def _parts(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[Any, Any, Any, Any]:
        x, _ = state
        voltage = n["bias"] + n["amplitude"] * xp.sin(n["frequency"] * time)
        squared, xx, s = voltage * voltage, x * x, n["s"]
        q = 1.0 + xx
        qq = q * q
        centre = 1.0 + (3.0 - n["B"]) * s
        denominator = q * (q * centre - (n["A"] * qq + n["G"]) * s)
        h = (n["A"] * qq - n["G"]) / denominator
        slope = 2.0 * centre * q - (3.0 * n["A"] * qq + n["G"]) * s
        return squared, xx, h, (2.0 * n["A"] * q - h * slope) / denominator

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        return self.flow(time, state, n, xp)[0]

    def forced(self, time: Any, state: Any, n: Any, xp: Any, name: str) -> list[Any]:
        return derivatives([xp.node(rate) for rate in self.rates(time, state, n, xp)], n[name])

    def flow(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[list[Any], list[list[Any]]]:
        x, u = state
        squared, xx, h, h_slope = self._parts(time, state, n, xp)
        g = squared - n["kappa"] - h
        rate = n["kappa"] * n["rest"] - 2.0 * n["zeta"] * u + x * g
        return [u, rate], [[0.0, 1.0], [g - 2.0 * xx * h_slope, -2.0 * n["zeta"]]]

    def powers(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[Any, Any]:
        x, u = state
        squared, _, _, _ = self._parts(time, state, n, xp)
        return squared * x * u, 2.0 * n["zeta"] * u * u


def cone_numbers(**changed: Any) -> dict[str, Any]:
    """Numbers of the cone by the names of its parameters."""
    given = {
        "damping_ratio": 0.01,
        "spring_stiffness": 0.9,
        "rest_height": 0.0,
        "meridional": 1.0,
        "hoop": 1.0,
        "stretch_limit": 50.0,
        "voltage": 1.5,
        "bias": 0.0,
        "frequency": 0.1,
    } | changed
    A, B = np.asarray(given["meridional"], float) ** 2, np.asarray(given["hoop"], float) ** 2
    return {
        "zeta": given["damping_ratio"],
        "kappa": given["spring_stiffness"],
        "rest": given["rest_height"],
        "A": A,
        "B": B,
        "G": 1.0 / (A * B),
        "s": 1.0 / np.asarray(given["stretch_limit"], float),
        "amplitude": given["voltage"],
        "bias": given["bias"],
        "frequency": given["frequency"],
    }


@dataclass(frozen=True)
class Oscillator:
    """x'' = sign - x."""

    states = ("x", "u")
    numbers = ("begin", "sign")

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        return self.flow(time, state, n, xp)[0]

    def flow(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[list[Any], list[list[Any]]]:
        x, u = state
        return [u, n["sign"] - x], [[0.0, 1.0], [-1.0, 0.0]]


@dataclass(frozen=True)
class Riccati:
    """x' = x^2, infinite at a finite time."""

    states = ("x",)
    numbers = ()

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        return [state[0] * state[0]]


@dataclass(frozen=True)
class Decay:
    """x' = -rate x."""

    states = ("x",)
    numbers = ("rate",)

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        return [-n["rate"] * state[0]]

    def flow(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[list[Any], list[list[Any]]]:
        return self.rates(time, state, n, xp), [[-n["rate"]]]


@dataclass(frozen=True)
class Chain:
    """A damped nonlinear oscillator with a third state that follows its displacement."""

    states = ("x", "u", "w")
    numbers = ("rate",)

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        return self.flow(time, state, n, xp)[0]

    def flow(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[list[Any], list[list[Any]]]:
        x, u, w = state
        rates = [u, -x * x * x - 0.1 * u - w + xp.sin(time), n["rate"] * (x - w)]
        slopes = [[0.0, 1.0, 0.0], [-3.0 * x * x, -0.1, -1.0], [n["rate"], 0.0, -n["rate"]]]
        return rates, slopes


@dataclass(frozen=True)
class TwoRoots:
    """u' = y - u z + a cos(t), w' = z, with the roots of y + z y^2/2 = u and z + sin(z)/3 - y = w^2, found together."""

    states = ("u", "w")
    numbers = ("a",)

    def roots(self, state: Any, xp: Any) -> tuple[Any, Any]:
        u, w = state

        def second(y: Any) -> Any:
            return xp.root(
                "z", lambda z, y, w, xp: z + xp.sin(z) / 3.0 - y - w * w, [y, w], lambda y, w, xp: xp.sqrt(1.0 + w * w)
            )

        y = xp.root("y", lambda y, u, xp: y + 0.5 * second(y) * y * y - u, [u], lambda u, xp: u)
        return y, second(y)

    def rates(self, time: Any, state: Any, n: Any, xp: Any) -> list[Any]:
        y, z = self.roots(state, xp)
        return [y - state[0] * z + n["a"] * xp.cos(time), z - state[1]]

    def flow(self, time: Any, state: Any, n: Any, xp: Any) -> tuple[list[Any], list[list[Any]]]:
        rates = self.rates(time, state, n, xp)
        return rates, jacobian([xp.node(rate) for rate in rates], state)
