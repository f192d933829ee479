"""Strain-energy laws of an incompressible film: Gent, neo-Hookean and Yeoh.

All energies are per shear modulus ``mu`` and film volume, so that every law has the response 1 at zero strain.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from gelcone.physics.component import Component, Numbers
from gelcone.physics.contract import (
    DEFAULTS,
    NUMBERS,
    ONE_EACH,
    PLACES,
    Trial,
    check_formulas,
    numbers_of,
    same_formula,
)
from gelcone.physics.differentiate import derivative
from gelcone.quantity import Quantity


class StrainEnergyLaw(Component):
    """An energy W(I1 - 3) of the first invariant of the left Cauchy-Green tensor.

    A new law supplies a ``name``, its ``parameters`` and four formulas, in arithmetic, powers and the functions of
    ``xp``:

    * `energy` - W/mu at the strain I1 - 3;
    * `response` - 2 dW/dI1 over mu, 1 at zero strain;
    * `response_slope` - the derivative of `response` by I1;
    * `strain_limit` - the I1 - 3 that the film cannot reach. Default infinity.

    The functions of ``xp`` are ``sin``, ``cos``, ``exp``, ``log``, ``log1p`` and ``sqrt``. A law whose response or
    slope does not follow from its energy is refused.

    `compliance`, `stiffening` and `film_stiffness` follow from these; override them where a cheaper closed form exists,
    as `Gent` does. `numbers` computes the numbers of the formulas from the parameters (default: the parameters).
    ``tests/physics/test_laws.py`` compares each of these functions with the energy, for all `LAWS`.

    Examples
    --------
    >>> import gelcone
    >>> {name: round(float(law.response(2.0, law.numbers(law.complete({})))), 4) for name, law in gelcone.LAWS.items()}
    {'gent': 1.0417, 'neo-hookean': 1.0, 'yeoh': 1.0}
    """

    @abstractmethod
    def energy(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        """Energy over mu at a strain I1 - 3."""

    @abstractmethod
    def response(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        """Twice the derivative of the energy by I1; 1 at zero strain."""

    @abstractmethod
    def response_slope(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        """Derivative of the response by I1."""

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Compare response and slope with the derivatives of the energy, too."""
        super().prove(given)
        n, many = numbers_of(self, given)
        small = 0.1 * PLACES * PLACES
        check_formulas(
            self,
            [
                Trial("strain_limit", (many,), ONE_EACH),
                *(
                    Trial(name, (small, many), NUMBERS)
                    for name in ("energy", "response", "response_slope", "compliance", "stiffening")
                ),
            ],
        )
        strain = np.linspace(0.0, 0.9, 10) * np.minimum(self.strain_limit(n), 4.0)
        response, slope = self.response(strain, n), self.response_slope(strain, n)
        same_formula(
            self,
            "response, twice the derivative of the energy by I1, at a strain I1 - 3",
            strain,
            response,
            lambda: 2.0 * derivative(lambda at, xp: self.energy(at, n, xp), strain),
        )
        same_formula(
            self,
            "response_slope, the derivative of the response by I1, at a strain I1 - 3",
            strain,
            slope,
            lambda: derivative(lambda at, xp: self.response(at, n, xp), strain),
        )
        same_formula(
            self,
            "response at zero strain, over which the shear modulus is that of small strains",
            strain[:1],
            response if np.ndim(response) == 0 else response[:1],
            lambda: 1.0,
        )

    def compliance(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        """1 over the response, which stays finite at a stretch limit."""
        return 1.0 / self.response(strain, n, xp)

    def stiffening(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        """Minus the derivative of `compliance` with respect to I1."""
        response = self.response(strain, n, xp)
        return self.response_slope(strain, n, xp) / (response * response)

    def strain_limit(self, n: Numbers) -> Any:
        """The strain at which the response is infinite."""
        return np.asarray(np.inf)

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """The film's secant stiffness h = (dW/dx)/x per mu Vol and its derivative dh/dq, at q = 1 + x^2.

        With I1 - 3 = A q + B + G/q - 3 (see `gelcone.physics.film.taut`): h = (A - G/q^2) R, where R is the response.
        """
        r = 1.0 / q
        strain = A * q + B + G * r - 3.0
        strain_slope = A - G * r * r
        response = self.response(strain, n, xp)
        slope = 2.0 * G * r * r * r * response + strain_slope * strain_slope * self.response_slope(strain, n, xp)
        return strain_slope * response, slope


class Gent(StrainEnergyLaw):
    """W = -(J/2) ln(1 - (I1-3)/J); J = infinity is neo-Hookean. Gent, Rubber Chem. Technol. 69 (1996) 59.

    Examples
    --------
    >>> import gelcone
    >>> law = gelcone.Gent()
    >>> round(float(law.response(10.0, law.numbers({"stretch_limit": 50.0}))), 4)
    1.25
    """

    name = "gent"
    parameters = {
        "stretch_limit": Quantity(
            "J",
            "stretch limit: largest I1 - 3 of the film",
            50.0,
            positive=True,
            infinite=True,
            typical=(1.0, 200.0),
            near=("j", "jm", "j_m", "limit"),
        )
    }

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        return {"inverse_stretch_limit": 1.0 / parameters["stretch_limit"]}

    def energy(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        s = n["inverse_stretch_limit"]
        if xp is not np:
            return -xp.log1p(-s * strain) / (2.0 * s)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(s == 0.0, 0.5 * strain, -np.log1p(-s * strain) / (2.0 * s))

    def response(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 1.0 / (1.0 - n["inverse_stretch_limit"] * strain)

    def response_slope(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        s = n["inverse_stretch_limit"]
        return s / ((1.0 - s * strain) * (1.0 - s * strain))

    def compliance(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 1.0 - n["inverse_stretch_limit"] * strain

    def stiffening(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return n["inverse_stretch_limit"]

    def strain_limit(self, n: Numbers) -> Any:
        with np.errstate(divide="ignore"):
            return 1.0 / np.asarray(n["inverse_stretch_limit"])

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """h = (A q^2 - G) / (q M), M = q (1 + (3-B)/J) - (A q^2 + G)/J: one division serves h, one more its slope."""
        s = n["inverse_stretch_limit"]
        qq = q * q
        centre = 1.0 + (3.0 - B) * s
        denominator = q * (q * centre - (A * qq + G) * s)
        h = (A * qq - G) / denominator
        denominator_slope = 2.0 * centre * q - (3.0 * A * qq + G) * s
        return h, (2.0 * A * q - h * denominator_slope) / denominator


class NeoHookean(StrainEnergyLaw):
    """W = (I1-3)/2. Treloar, The Physics of Rubber Elasticity (1975).

    Examples
    --------
    >>> import gelcone
    >>> float(gelcone.NeoHookean().energy(10.0, {}))
    5.0
    """

    name = "neo-hookean"

    def compliance(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 1.0

    def stiffening(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.0

    def energy(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.5 * strain

    def response(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 1.0 + 0.0 * strain

    def response_slope(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.0 * strain

    def film_stiffness(self, q: Any, A: Any, B: Any, G: Any, n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """h = A - G/q^2."""
        r = 1.0 / q
        g = G * r * r
        return A - g, 2.0 * g * r


class Yeoh(StrainEnergyLaw):
    """W = (e + c2 e^2 + c3 e^3)/2, e = I1-3, with c2 = C20/C10 and c3 = C30/C10.

    Yeoh, Rubber Chem. Technol. 66 (1993) 754.

    Examples
    --------
    >>> import gelcone
    >>> float(gelcone.Yeoh().response(1.0, {"yeoh_c2": 0.1, "yeoh_c3": 0.0}))
    1.2
    """

    name = "yeoh"
    parameters = {
        "yeoh_c2": Quantity("c2", "Yeoh's second coefficient over the first, C20/C10", 0.0, near=("c2", "c20")),
        "yeoh_c3": Quantity("c3", "Yeoh's third coefficient over the first, C30/C10", 0.0, near=("c3", "c30")),
    }

    def energy(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 0.5 * strain * (1.0 + strain * (n["yeoh_c2"] + n["yeoh_c3"] * strain))

    def response(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 1.0 + strain * (2.0 * n["yeoh_c2"] + 3.0 * n["yeoh_c3"] * strain)

    def response_slope(self, strain: Any, n: Numbers, xp: Any = np) -> Any:
        return 2.0 * n["yeoh_c2"] + 6.0 * n["yeoh_c3"] * strain


LAWS: dict[str, StrainEnergyLaw] = {law.name: law for law in (Gent(), NeoHookean(), Yeoh())}
