"""Films of a gel: their strain-energy law, pre-stretches and Maxwell branches.

With the meridional and hoop pre-stretches lm and lh the numbers of a film are A = lm^2, B = lh^2 and G = 1/(A B).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from gelcone.errors import InputError, check_name
from gelcone.physics.component import Numbers, State
from gelcone.physics.film.branches import RESTED, Branches
from gelcone.physics.film.film import Film, FilmState, TracedState
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.quantity import Quantity

PRESTRETCH_MODES = ("radial", "equibiaxial")
PRESTRETCHES = {
    "prestretch": Quantity("lp", "pre-stretch of the film, see prestretch_mode", 1.0, positive=True),
    "meridional_prestretch": Quantity("lm", "meridional pre-stretch, given directly", 1.0, positive=True),
    "hoop_prestretch": Quantity("lh", "hoop pre-stretch, given directly", 1.0, positive=True),
}


RADIUS_RATIO = {"radius_ratio": Quantity("a/b", "radius of the disc over that of the ring", 0.2, positive=True)}


def cone_reach(strain: Any, n: Numbers) -> tuple[Any, Any]:
    """The smallest and largest |x| between which I1 - 3 of the homogeneous cone is less than ``strain``; NaN where it
    never is.

    A q + B + G/q - 3 = strain is quadratic in q = 1 + x^2.
    """
    half, middle = 0.5 * (strain + 3.0 - n["B"]), np.sqrt(n["A"] * n["G"])
    with np.errstate(invalid="ignore", divide="ignore"):
        above = (half + np.sqrt(half - middle) * np.sqrt(half + middle)) / n["A"]
        below = n["G"] / (n["A"] * above)
        inside = (half > middle) & (above > 1.0)
        low, high = np.sqrt(np.maximum(below - 1.0, 0.0)), np.sqrt(above - 1.0)
        return np.where(inside, low, np.nan)[()], np.where(inside, high, np.nan)[()]


class GelFilm(Film):
    """A film with a strain-energy law and pre-stretches; its numbers are A, B, G and those of the law."""

    law: StrainEnergyLaw
    prestretch_mode: str

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        return PRESTRETCHES | dict(self.law.parameters)

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check ``prestretch`` or the two direct ones (default 1), and the parameters of the law."""
        given = {name: value for name, value in given.items() if value is not None or name not in PRESTRETCHES}
        direct = given.keys() & {"meridional_prestretch", "hoop_prestretch"}
        if direct and "prestretch" in given:
            raise InputError(
                "prestretch and meridional_prestretch/hoop_prestretch are both given; give one or the other"
            )
        names = ("meridional_prestretch", "hoop_prestretch") if direct else ("prestretch",)
        stretches = {name: PRESTRETCHES[name].check(name, given.get(name, 1.0)) for name in names}
        return stretches | self.law.complete(given)

    def stretches(self, parameters: Numbers) -> tuple[Any, Any]:
        """Meridional and hoop pre-stretch lm, lh."""
        if "prestretch" not in parameters:
            return parameters["meridional_prestretch"], parameters["hoop_prestretch"]
        both = parameters["prestretch"]
        return (both if self.prestretch_mode == "equibiaxial" else 1.0), both

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        lm, lh = self.stretches(parameters)
        A, B = np.square(lm), np.square(lh)
        return {"A": A, "B": B, "G": 1.0 / (A * B)} | self.law.numbers(parameters)

    def stiffness_scale(self, n: Numbers) -> Any:
        """A, the stiffness at large displacements."""
        return n["A"]

    def cone_strain(self, x: Any, n: Numbers) -> Any:
        """I1 - 3 of the homogeneous cone."""
        q = 1.0 + x * x
        return n["A"] * q + n["B"] + n["G"] / q - 3.0

    def ring_state(self, m: Any, width: Any, voltage: Any, n: Numbers, more: tuple[Any, Any] = (0.0, 0.0)) -> FilmState:
        """Stretches and true stresses of a ring of the squared lengths m and ``width`` over the mounted ones; ``more``
        holds stresses that are added to the law's."""
        ring = self.traced_ring(m, width, np.square(voltage), n, np, more)
        l1, l2 = np.sqrt(n["A"] * m), np.sqrt(n["B"] * width)
        return FilmState(
            meridional_stretch=l1,
            hoop_stretch=l2,
            thickness_stretch=1.0 / (l1 * l2),
            meridional_stress=ring.meridional_stress,
            hoop_stress=ring.hoop_stress,
            true_field=np.abs(voltage) * np.sqrt(m * width),
            limit_share=ring.limit_share,
        )

    def traced_ring(
        self, m: Any, width: Any, squared: Any, n: Numbers, xp: Any, more: tuple[Any, Any] = (0.0, 0.0)
    ) -> TracedState:
        """Stresses, squared field and share of the limit of a ring of the squared lengths m and ``width`` over the
        mounted ones; ``more`` holds stresses that are added to the law's."""
        meridian, hoop, thin = n["A"] * m, n["B"] * width, n["G"] / (m * width)
        strain = meridian + hoop + thin - 3.0
        response, field = self.law.response(strain, n, xp), squared * (m * width)
        along, across = (meridian - thin) * response - field + more[0], (hoop - thin) * response - field + more[1]
        return TracedState(along, across, field, strain / self.law.strain_limit(n))


@dataclass(frozen=True)
class BranchedFilm(GelFilm):
    """A film of a gel with Maxwell branches.

    The fields of the branches are those of `TautCone`; ``held_width``: their hoop is held at its mounted length.
    """

    law: StrainEnergyLaw = LAWS["gent"]
    prestretch_mode: str = "radial"
    branches: int = 0
    flow: str = "log"
    flow_exponent: int = 1
    rested: str = "flat"
    reduced: tuple[int, ...] = ()

    held_width: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_name("prestretch_mode", self.prestretch_mode, PRESTRETCH_MODES)
        object.__setattr__(self, "reduced", tuple(sorted({int(k) for k in self.reduced})))
        _ = self.viscous
        check_name("rested", self.rested, RESTED)

    @cached_property
    def viscous(self) -> Branches:
        """The Maxwell branches."""
        return Branches(self.branches, self.flow, self.flow_exponent, self.held_width, self.reduced)

    @property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        """The states of the branches."""
        return self.viscous.states

    @abstractmethod
    def branch_lengths(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """The squared lengths m along the meridian and n across it, over the mounted ones, to which branches with the
        states ``y`` are stretched."""

    @abstractmethod
    def resting_lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """The squared lengths m and n to which the branches of the relaxed film are stretched at x and V."""

    def shortest_lengths(self, x: Any, n: Numbers) -> tuple[Any, Any]:
        """The least squared lengths of the branches at x. Default: `resting_lengths` without voltage."""
        return self.resting_lengths(x, 0.0, n)

    def starts(self, x: Any, n: Numbers) -> list[Any]:
        if not self.branches or self.rested == "flat":
            return super().starts(x, n)
        return self.viscous.relaxed(*self.resting_lengths(x, 0.0, n))

    def relaxed(self, x: Any, squared: Any, n: Numbers) -> list[Any] | None:
        if not self.branches:
            return super().relaxed(x, squared, n)
        return self.viscous.relaxed(*self.resting_lengths(x, squared, n))

    def overstretched(self, x: Any, y: list[Any], n: Numbers) -> Any:
        if not (self.branches and y):
            return super().overstretched(x, y, n)
        return self.viscous.limit_share(*self.shortest_lengths(x, n), y, n) >= 1.0

    def rates(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        return self.viscous.rates(*self.branch_lengths(x, squared, y, n, xp), y, n) if self.branches else []

    def dissipation(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        if not self.branches:
            return 0.0
        lost = self.viscous.dissipation(*self.branch_lengths(x, squared, y, n, xp), y, n)
        return lost + self.drag(x, n) * (velocity * velocity) if self.drags else lost

    @property
    def drags(self) -> bool:
        return bool(self.reduced)

    def drag(self, x: Any, n: Numbers) -> Any:
        return self.viscous.drag(x, n)

    @property
    def dissipates(self) -> bool:
        return self.branches > 0 or type(self).dissipation is not BranchedFilm.dissipation

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        return dict(super().parameters) | RADIUS_RATIO | dict(self.viscous.parameters)

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check the parameters of the gel and of the branches."""
        branch_values = {name: q.check(name, given.get(name, q.default)) for name, q in self.viscous.parameters.items()}
        self.viscous.check(branch_values)
        return super().complete(given) | branch_values

    def time_constant(self, n: Numbers) -> Any:
        return self.viscous.time_constant(n) if self.branches else 0.0

    def stiffness_scale(self, n: Numbers) -> Any:
        """A, the stiffness at large displacements, plus the moduli of branches before they relax."""
        return super().stiffness_scale(n) + self.viscous.modulus(n) if self.branches else super().stiffness_scale(n)
