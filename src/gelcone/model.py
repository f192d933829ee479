"""The cone model: its dimensionless parameters, its energy and its equation of motion.

A disc in the middle of a gel film is pushed out of plane by a spring; x is its height over the width of the film,
q = 1 + x^2 the square of the cone's slant over that width. With the meridional and hoop pre-stretches lm and lh the
film's stretches are l1 = lm sqrt(q), l2 = lh, l3 = 1/(l1 l2), and with A = lm^2, B = lh^2, G = 1/(A B)

    I1 - 3 = A q + B + G/q - 3.

Energies are per mu Vol (shear modulus times film volume), times per 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import drive
from gelcone.errors import InputError, unknown_name
from gelcone.laws import LAWS, StrainEnergyLaw, find_law
from gelcone.quantity import Array, Quantity

PARAMETERS: dict[str, Quantity] = {
    "damping_ratio": Quantity("zeta", "damping ratio c/(2 m Omega0)", 0.05, lower=0.0),
    "spring_stiffness": Quantity("kappa", "spring stiffness k (b-a)^2/(mu Vol)", 1.5, lower=0.0),
    "voltage": Quantity("v", "voltage amplitude Phi sqrt(eps/mu)/H", 0.5, lower=0.0),
    "voltage_bias": Quantity("v0", "constant part of the voltage, in the same scale", 0.0),
    "drive_frequency": Quantity("omega", "drive frequency 2 pi f/Omega0", 1.0, positive=True),
    "rest_height": Quantity("x0", "height at which the spring is free, h0/(b-a)", 0.0),
    "prestretch": Quantity("lp", "pre-stretch of the film, see prestretch_mode", 1.0, positive=True),
    "meridional_prestretch": Quantity("lm", "meridional pre-stretch, given directly", 1.0, positive=True),
    "hoop_prestretch": Quantity("lh", "hoop pre-stretch, given directly", 1.0, positive=True),
}
_PRESTRETCHES = ("prestretch", "meridional_prestretch", "hoop_prestretch")
PRESTRETCH_MODES = ("radial", "equibiaxial")

ArrayLike = npt.ArrayLike


class Coefficients(NamedTuple):
    """The numbers in the formulas: floats, arrays, SymPy symbols or heyoka parameters."""

    zeta: Any
    kappa: Any
    rest: Any
    A: Any
    B: Any
    G: Any
    law: tuple[Any, ...]


# --- the energy, written once ------------------------------------------------------------------------------------


def strain(x: Any, c: Coefficients) -> Any:
    """I1 - 3 of the film at the displacement x."""
    q = 1.0 + x * x
    return c.A * q + c.B + c.G / q - 3.0


def spring_energy(x: Any, c: Coefficients) -> Any:
    """Energy of the spring."""
    return 0.5 * c.kappa * (x - c.rest) * (x - c.rest)


def electric_energy(x: Any, voltage: Any, xp: Any = np, displacement: Any = None) -> Any:
    """Field energy less the work of the voltage source.

    ``displacement`` is the electric displacement D/sqrt(eps mu); left out, it takes the value v sqrt(q) that makes
    the energy stationary, which leaves -v^2 q/2.
    """
    q = 1.0 + x * x
    if displacement is None:
        return -0.5 * voltage * voltage * q
    return 0.5 * displacement * displacement - voltage * displacement * xp.sqrt(q)


def lagrangian(x: Any, velocity: Any, voltage: Any, c: Coefficients, law: StrainEnergyLaw, xp: Any = np) -> Any:
    """Kinetic less potential energy of film, spring and field."""
    potential = law.energy(strain(x, c), c.law, xp) + spring_energy(x, c) + electric_energy(x, voltage, xp)
    return 0.5 * velocity * velocity - potential


def dissipation(velocity: Any, c: Coefficients) -> Any:
    """Rayleigh dissipation function; the power lost is twice this."""
    return c.zeta * velocity * velocity


# --- what follows from it by Euler-Lagrange, in the form that runs fastest (tests prove both equal) -----------------


def acceleration(x: Any, velocity: Any, voltage: Any, c: Coefficients, law: StrainEnergyLaw) -> tuple[Any, Any]:
    """x'' of the equation of motion, and its derivative with respect to x.

    x'' = kappa x0 - 2 zeta x' + g x, g = v^2 - kappa - h(q), where h is the law's film stiffness;
    the derivative is g - 2 x^2 dh/dq.
    """
    xx = x * x
    h, h_slope = law.film_stiffness(1.0 + xx, c.A, c.B, c.G, c.law)
    g = voltage * voltage - c.kappa - h
    return c.kappa * c.rest - 2.0 * c.zeta * velocity + x * g, g - 2.0 * xx * h_slope


@dataclass(frozen=True, kw_only=True, eq=False)
class ConeModel:
    """A conical gel actuator in dimensionless form; arrays make an ensemble.

    Any number may be an array; all arrays broadcast together into the ensemble's `shape`.

    Parameters
    ----------
    damping_ratio : zeta = c/(2 m Omega0), at least 0. Default 0.05.
    spring_stiffness : kappa = k (b-a)^2/(mu Vol), at least 0. Default 1.5.
    voltage : amplitude v = Phi sqrt(eps/mu)/H of the drive v0 + v sin(omega tau), at least 0. Default 0.5.
    voltage_bias : its constant part v0. Default 0.
    drive_frequency : omega = 2 pi f/Omega0, positive. Default 1.
    stretch_limit : Gent's J, positive; infinity is neo-Hookean. Default 50. Only laws that have one take it.
    prestretch : lp, positive. Default 1.
    prestretch_mode : ``"radial"`` (lm = 1, lh = lp; default) or ``"equibiaxial"`` (lm = lh = lp).
    meridional_prestretch, hoop_prestretch : lm and lh given directly, instead of ``prestretch``; one left out is 1.
    rest_height : x0 = h0/(b-a), where the spring is free. Default 0.
    law : a `StrainEnergyLaw` or the name of one in `LAWS`. Default Gent.
    law_parameters : the law's own numbers other than ``stretch_limit``, by name (Yeoh: ``yeoh_c2``, ``yeoh_c3``).

    Raises
    ------
    InputError : for a value out of bounds, or arrays that do not broadcast.
    """

    damping_ratio: Any = PARAMETERS["damping_ratio"].default
    spring_stiffness: Any = PARAMETERS["spring_stiffness"].default
    voltage: Any = PARAMETERS["voltage"].default
    voltage_bias: Any = PARAMETERS["voltage_bias"].default
    drive_frequency: Any = PARAMETERS["drive_frequency"].default
    stretch_limit: Any = None
    prestretch: Any = None
    prestretch_mode: str = "radial"
    meridional_prestretch: Any = None
    hoop_prestretch: Any = None
    rest_height: Any = PARAMETERS["rest_height"].default
    law: Any = "gent"
    law_parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        law = find_law(self.law) if isinstance(self.law, str) else self.law
        if not isinstance(law, StrainEnergyLaw):
            raise InputError(f"law = {law!r}: must be a strain-energy law or the name of one: {', '.join(LAWS)}")
        direct = self.meridional_prestretch is not None or self.hoop_prestretch is not None
        if direct and self.prestretch is not None:
            raise InputError(
                "prestretch and meridional_prestretch/hoop_prestretch are both given; give one or the other"
            )
        if self.prestretch_mode not in PRESTRETCH_MODES:
            raise unknown_name("prestretch_mode", str(self.prestretch_mode), PRESTRETCH_MODES)
        values: dict[str, Any] = {"law": law}
        for name, quantity in PARAMETERS.items():
            value = getattr(self, name)
            if value is None and name in _PRESTRETCHES:
                value = quantity.default if (name == "prestretch") != direct else None
                values[name] = value
            else:
                values[name] = quantity.check(name, value)
        values |= self._checked_law_parameters(law)
        for name, value in values.items():
            object.__setattr__(self, name, value)
        self.shape  # noqa: B018 - arrays that do not broadcast are refused here

    def _checked_law_parameters(self, law: StrainEnergyLaw) -> dict[str, Any]:
        given = dict(self.law_parameters)
        if "stretch_limit" in given and self.stretch_limit is not None:
            raise InputError("stretch_limit is given twice, also in law_parameters; give it once")
        unlimited = "stretch_limit" not in law.parameters
        if self.stretch_limit is not None and not (unlimited and _infinite(self.stretch_limit)):
            given["stretch_limit"] = self.stretch_limit
        for name in given:
            if name not in law.parameters:
                takes = ", ".join(law.parameters) or "no parameters"
                raise InputError(f"{name}: the {law.name} law does not take it; it takes {takes}")
        checked = {name: q.check(name, given.get(name, q.default)) for name, q in law.parameters.items()}
        return {"stretch_limit": checked.pop("stretch_limit", np.inf), "law_parameters": checked}

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, Any]) -> ConeModel:
        """A model from flat names, the law's own among them: the form of files and of the command line.

        Raises `InputError` with the nearest name for one that is not known.
        """
        names = set(parameter_names()) - {"stretch_limit"}
        own = {name for law in LAWS.values() for name in law.parameters} - {"stretch_limit"}
        for name in parameters:
            if name not in names | own | {"stretch_limit"}:
                raise unknown_name("model parameter", name, parameter_names())
        fields = {k: v for k, v in parameters.items() if k not in own}
        return cls(**fields, law_parameters={k: v for k, v in parameters.items() if k in own})

    def parameters(self) -> dict[str, Any]:
        """All parameters under their flat names, so that ``ConeModel.from_parameters`` gives the model back."""
        values = {name: getattr(self, name) for name in PARAMETERS if getattr(self, name) is not None}
        values |= self.law_parameters
        if "stretch_limit" in self.law.parameters:
            values["stretch_limit"] = self.stretch_limit
        return values | {"prestretch_mode": self.prestretch_mode, "law": self.law.name}

    def replace(self, **changes: Any) -> ConeModel:
        """A copy with some parameters changed, by their flat names; a new law starts from its own defaults."""
        law = changes.get("law", self.law)
        law = find_law(law) if isinstance(law, str) else law
        fields = {f.name for f in dataclasses.fields(self)}
        known = [*parameter_names(), *getattr(law, "parameters", ())]
        for name in changes:
            if name not in known and name != "law_parameters":
                raise unknown_name("model parameter", name, known)
        own = dict(self.law_parameters) if law is self.law else {}
        own |= {k: changes.pop(k) for k in list(changes) if k not in fields}
        if law is not self.law:
            changes.setdefault("stretch_limit", None)
        if changes.keys() & {"meridional_prestretch", "hoop_prestretch"}:
            changes.setdefault("prestretch", None)
        elif changes.get("prestretch") is not None:
            changes |= {"meridional_prestretch": None, "hoop_prestretch": None}
        return dataclasses.replace(self, **({"law_parameters": own} | changes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the ensemble; ``()`` for a single actuator."""
        arrays = {k: np.shape(v) for k, v in self.parameters().items() if not isinstance(v, str)}
        try:
            return np.broadcast_shapes(*arrays.values())
        except ValueError:
            shapes = ", ".join(f"{k} {v}" for k, v in arrays.items() if v)
            raise InputError(f"the parameter arrays do not broadcast together: {shapes}") from None

    @property
    def size(self) -> int:
        """Number of members."""
        return int(np.prod(self.shape))

    def take(self, index: Any) -> ConeModel:
        """The members at ``index`` of the flattened ensemble, as a one-dimensional ensemble."""
        values = {
            name: value if isinstance(value, str) else np.broadcast_to(value, self.shape).ravel()[index]
            for name, value in self.parameters().items()
        }
        values["law"] = self.law
        fields = {f.name for f in dataclasses.fields(self)}
        own = {k: values.pop(k) for k in list(values) if k not in fields}
        return ConeModel(**values, law_parameters=own)

    @property
    def stretches(self) -> tuple[Any, Any]:
        """Meridional and hoop pre-stretch lm, lh."""
        if self.prestretch is None:
            return self.meridional_prestretch, self.hoop_prestretch
        return (self.prestretch if self.prestretch_mode == "equibiaxial" else 1.0), self.prestretch

    @property
    def drive_period(self) -> Array:
        """Period of the voltage, 2 pi/omega."""
        return 2.0 * np.pi / np.asarray(self.drive_frequency)

    @property
    def drive_repeat(self) -> Array:
        """Smallest period of the force: pi/omega for a pure sine, 2 pi/omega with a bias."""
        return drive.repeat(self.drive_frequency, self.voltage_bias)

    def coefficients(self, trailing: int = 0) -> Coefficients:
        """The numbers in the formulas, with ``trailing`` axes of length 1 appended for samples."""

        def fit(value: Any) -> Any:
            array = np.asarray(value, dtype=float)
            if array.ndim == 0:
                return array
            return np.broadcast_to(array, self.shape).reshape(self.shape + (1,) * trailing)

        lm, lh = (fit(stretch) for stretch in self.stretches)
        numbers = {"stretch_limit": fit(self.stretch_limit)} | {k: fit(v) for k, v in self.law_parameters.items()}
        A, B = lm * lm, lh * lh
        c = self.law.coefficients(numbers)
        return Coefficients(
            fit(self.damping_ratio), fit(self.spring_stiffness), fit(self.rest_height), A, B, 1.0 / (A * B), c
        )

    def _at(self, x: ArrayLike) -> tuple[Array, Coefficients]:
        x = np.asarray(x, dtype=float)
        return x, self.coefficients(max(0, x.ndim - len(self.shape)))

    def strain(self, x: ArrayLike) -> Any:
        """I1 - 3 at displacements of the ensemble's shape followed by any sample axes."""
        return strain(*self._at(x))

    def strain_limit(self, trailing: int = 0) -> Any:
        """The I1 - 3 that the film cannot reach."""
        return self.law.strain_limit(self.coefficients(trailing).law)

    def energy(self, x: ArrayLike) -> Any:
        """Energy of film and spring; NaN beyond the stretch limit."""
        x, c = self._at(x)
        return self.law.energy(strain(x, c), c.law) + spring_energy(x, c)

    def force(self, x: ArrayLike, voltage: Any = 0.0) -> Any:
        """Static force that holds the disc at x against film, spring and a constant voltage, per mu Vol/(b-a).

        NaN at and beyond the stretch limit.
        """
        x, c = self._at(x)
        return self._within(x, c, -acceleration(x, 0.0, voltage, c, self.law)[0])

    def stiffness(self, x: ArrayLike, voltage: Any = 0.0) -> Any:
        """Slope of `force`: positive where an equilibrium is stable; NaN at and beyond the stretch limit."""
        x, c = self._at(x)
        return self._within(x, c, -acceleration(x, 0.0, voltage, c, self.law)[1])

    def _within(self, x: Array, c: Coefficients, values: Any) -> Any:
        return np.where(strain(x, c) < self.law.strain_limit(c.law), values, np.nan)[()]


def _infinite(value: Any) -> bool:
    try:
        return bool(np.isinf(np.asarray(value, dtype=float)).all())
    except (TypeError, ValueError):
        return False


def parameter_names() -> list[str]:
    """All names that a model takes, the laws' own among them."""
    own = [name for law in LAWS.values() for name in law.parameters]
    return [*PARAMETERS, *own, "prestretch_mode", "law"]


def parameter_quantity(name: str) -> Quantity:
    """The `Quantity` behind a numeric parameter; `InputError` for an unknown or non-numeric one."""
    known = PARAMETERS | {k: q for law in LAWS.values() for k, q in law.parameters.items()}
    if name not in known:
        raise unknown_name("numeric model parameter", name, known)
    return known[name]
