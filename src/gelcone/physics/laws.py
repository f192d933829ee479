"""Strain-energy laws of an incompressible film: Gent, neo-Hookean and Yeoh.

All energies are per shear modulus ``mu`` and film volume, so that every law has the response 1 at zero strain.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from gelcone.errors import unknown_name
from gelcone.quantity import Quantity


class StrainEnergyLaw(ABC):
    """An energy W(I1 - 3) of the first invariant of the left Cauchy-Green tensor.

    A new law supplies a ``name``, its ``parameters`` (name -> `Quantity`) and five functions. They must work on
    floats, NumPy arrays, SymPy and heyoka expressions alike, hence use only arithmetic and the functions of ``xp``:

    * `coefficients` - from the parameters, the numbers its formulas use (``c`` below);
    * `energy` - W/mu at the strain I1 - 3;
    * `response` - 2 dW/dI1 per mu, 1 at zero strain;
    * `response_slope` - the derivative of `response` with respect to I1;
    * `strain_limit` - the I1 - 3 that the film cannot reach (infinity if there is none).

    `film_stiffness` follows from these; override it where a cheaper closed form exists, as `Gent` does. A law that
    holds numbers of its own is best a frozen dataclass: equal laws share a compiled program, also between processes.
    The tests in ``tests/test_laws.py`` run over `LAWS` and prove each of these functions against the energy.
    """

    name: ClassVar[str]
    parameters: ClassVar[Mapping[str, Quantity]]

    def __eq__(self, other: object) -> bool:
        """Laws of a class that hold nothing of their own are the same: another process's law needs no new program."""
        return self is other or (type(self) is type(other) and not vars(self) and not vars(other))

    def __hash__(self) -> int:
        return hash(type(self))

    @abstractmethod
    def coefficients(self, parameters: Mapping[str, Any]) -> tuple[Any, ...]: ...

    @abstractmethod
    def energy(self, strain: Any, c: tuple[Any, ...], xp: Any = np) -> Any: ...

    @abstractmethod
    def response(self, strain: Any, c: tuple[Any, ...]) -> Any: ...

    @abstractmethod
    def response_slope(self, strain: Any, c: tuple[Any, ...]) -> Any: ...

    @abstractmethod
    def strain_limit(self, c: tuple[Any, ...]) -> Any: ...

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, c: tuple[Any, ...]) -> tuple[Any, Any]:
        """The film's secant stiffness h = (dW/dx)/x per mu Vol and its derivative dh/dq, at q = 1 + x^2.

        With I1 - 3 = A q + B + G/q - 3 (see `gelcone.physics.model`): h = (A - G/q^2) R, where R is the response.
        """
        r = 1.0 / q
        strain = A * q + B + G * r - 3.0
        strain_slope = A - G * r * r
        response = self.response(strain, c)
        slope = 2.0 * G * r * r * r * response + strain_slope * strain_slope * self.response_slope(strain, c)
        return strain_slope * response, slope


class Gent(StrainEnergyLaw):
    """W = -(J/2) ln(1 - (I1-3)/J); J = infinity is neo-Hookean. Gent, Rubber Chem. Technol. 69 (1996) 59."""

    name = "gent"
    parameters = {
        "stretch_limit": Quantity("J", "stretch limit: largest I1 - 3 of the film", 50.0, positive=True, infinite=True)
    }

    def coefficients(self, parameters: Mapping[str, Any]) -> tuple[Any, ...]:
        return (1.0 / parameters["stretch_limit"],)

    def energy(self, strain: Any, c: tuple[Any, ...], xp: Any = np) -> Any:
        (s,) = c
        if xp is not np:
            return -xp.log1p(-s * strain) / (2.0 * s)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(s == 0.0, 0.5 * strain, -np.log1p(-s * strain) / (2.0 * s))

    def response(self, strain: Any, c: tuple[Any, ...]) -> Any:
        (s,) = c
        return 1.0 / (1.0 - s * strain)

    def response_slope(self, strain: Any, c: tuple[Any, ...]) -> Any:
        (s,) = c
        return s / ((1.0 - s * strain) * (1.0 - s * strain))

    def strain_limit(self, c: tuple[Any, ...]) -> Any:
        with np.errstate(divide="ignore"):
            return 1.0 / np.asarray(c[0])

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, c: tuple[Any, ...]) -> tuple[Any, Any]:
        """h = (A q^2 - G) / (q M), M = q (1 + (3-B)/J) - (A q^2 + G)/J: one division serves h, one more its slope."""
        (s,) = c
        qq = q * q
        centre = 1.0 + (3.0 - B) * s
        denominator = q * (q * centre - (A * qq + G) * s)
        h = (A * qq - G) / denominator
        denominator_slope = 2.0 * centre * q - (3.0 * A * qq + G) * s
        return h, (2.0 * A * q - h * denominator_slope) / denominator


class NeoHookean(StrainEnergyLaw):
    """W = (I1-3)/2. Treloar, The Physics of Rubber Elasticity (1975)."""

    name = "neo-hookean"
    parameters: ClassVar[Mapping[str, Quantity]] = {}

    def coefficients(self, parameters: Mapping[str, Any]) -> tuple[Any, ...]:
        return ()

    def energy(self, strain: Any, c: tuple[Any, ...], xp: Any = np) -> Any:
        return 0.5 * strain

    def response(self, strain: Any, c: tuple[Any, ...]) -> Any:
        return 1.0 + 0.0 * strain

    def response_slope(self, strain: Any, c: tuple[Any, ...]) -> Any:
        return 0.0 * strain

    def strain_limit(self, c: tuple[Any, ...]) -> Any:
        return np.asarray(np.inf)

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, c: tuple[Any, ...]) -> tuple[Any, Any]:
        """h = A - G/q^2."""
        r = 1.0 / q
        g = G * r * r
        return A - g, 2.0 * g * r


class Yeoh(StrainEnergyLaw):
    """W = (e + c2 e^2 + c3 e^3)/2, e = I1-3, with c2 = C20/C10 and c3 = C30/C10.

    Yeoh, Rubber Chem. Technol. 66 (1993) 754.
    """

    name = "yeoh"
    parameters = {
        "yeoh_c2": Quantity("c2", "Yeoh's second coefficient over the first, C20/C10", 0.0),
        "yeoh_c3": Quantity("c3", "Yeoh's third coefficient over the first, C30/C10", 0.0),
    }

    def coefficients(self, parameters: Mapping[str, Any]) -> tuple[Any, ...]:
        return parameters["yeoh_c2"], parameters["yeoh_c3"]

    def energy(self, strain: Any, c: tuple[Any, ...], xp: Any = np) -> Any:
        c2, c3 = c
        return 0.5 * strain * (1.0 + strain * (c2 + c3 * strain))

    def response(self, strain: Any, c: tuple[Any, ...]) -> Any:
        c2, c3 = c
        return 1.0 + strain * (2.0 * c2 + 3.0 * c3 * strain)

    def response_slope(self, strain: Any, c: tuple[Any, ...]) -> Any:
        c2, c3 = c
        return 2.0 * c2 + 6.0 * c3 * strain

    def strain_limit(self, c: tuple[Any, ...]) -> Any:
        return np.asarray(np.inf)


LAWS: dict[str, StrainEnergyLaw] = {law.name: law for law in (Gent(), NeoHookean(), Yeoh())}


def find_law(name: str) -> StrainEnergyLaw:
    """The law of that name; `InputError` with the nearest name when there is none."""
    if name not in LAWS:
        raise unknown_name("strain-energy law", name, LAWS)
    return LAWS[name]
