"""The cone model: its dimensionless parameters, its energy and its equation of motion.

A disc in the middle of a gel film is pushed out of plane by a spring; x is its height over the width of the film,
q = 1 + x^2 the square of the cone's slant over that width. With the meridional and hoop pre-stretches lm and lh the
film's stretches are l1 = lm sqrt(q), l2 = lh, l3 = 1/(l1 l2), and with A = lm^2, B = lh^2, G = 1/(A B)

    I1 - 3 = A q + B + G/q - 3.

A `ContinuumFilm`, fitted to the film as a continuum, may stand in for the homogeneous cone's force.

Energies are per mu Vol (shear modulus times film volume), times per 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError, unknown_name
from gelcone.physics import drive
from gelcone.physics.film.continuum import ContinuumFilm, film_from_json
from gelcone.physics.laws import LAWS, StrainEnergyLaw, find_law
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


Body = StrainEnergyLaw | ContinuumFilm
"""What resists the disc: a law in the homogeneous cone, or a continuum film that was fitted for one."""


def film_stiffness(xx: Any, squared: Any, c: Coefficients, body: Body) -> tuple[Any, Any]:
    """h of the film in x (h - v^2), and its derivative with respect to x^2, at x^2 and v^2.

    In the homogeneous cone the voltage plays no part in it.
    """
    if isinstance(body, ContinuumFilm):
        return body.stiffness(xx, squared)
    return body.film_stiffness(1.0 + xx, c.A, c.B, c.G, c.law)


def acceleration(x: Any, velocity: Any, voltage: Any, c: Coefficients, body: Body) -> tuple[Any, Any]:
    """x'' of the equation of motion, and its derivative with respect to x.

    x'' = kappa x0 - 2 zeta x' + g x, g = v^2 - kappa - h, where h is the stiffness of law or film;
    the derivative is g - 2 x^2 dh/d(x^2).
    """
    xx, squared = x * x, voltage * voltage
    h, h_slope = film_stiffness(xx, squared, c, body)
    g = squared - c.kappa - h
    return c.kappa * c.rest - 2.0 * c.zeta * velocity + x * g, g - 2.0 * xx * h_slope


def electric_force(x: Any, voltage: Any, c: Coefficients, body: Body) -> Any:
    """What the voltage adds to x'': v^2 x in the homogeneous cone, what it takes from the force of a continuum film."""
    squared = voltage * voltage
    if not isinstance(body, ContinuumFilm):
        return squared * x
    xx = x * x
    return x * (squared - body.stiffness(xx, squared)[0] + body.stiffness(xx, 0.0)[0])


def electric_pull(x: Any, voltage: Any, c: Coefficients, body: Body) -> Any:
    """Derivative of x'' with respect to v^2: x in the homogeneous cone."""
    return x * body.gain(x * x, voltage * voltage) if isinstance(body, ContinuumFilm) else x


class FilmState(NamedTuple):
    """True stretches, true stresses over mu, true field over sqrt(mu/eps), and (I1 - 3) over the stretch limit."""

    meridional_stretch: Any
    hoop_stretch: Any
    thickness_stretch: Any
    meridional_stress: Any
    hoop_stress: Any
    true_field: Any
    limit_share: Any


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
    film : a `ContinuumFilm` fitted for this law and pre-stretch, or its JSON text, in place of the homogeneous cone.
        Default None: the cone.

    Raises
    ------
    InputError : for a value out of bounds, arrays that do not broadcast, or a film that was fitted for another law or
        pre-stretch.
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
    film: Any = None

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
        if self.film is not None:
            object.__setattr__(self, "film", self._checked_film())
        self.shape  # noqa: B018 - arrays that do not broadcast are refused here

    def _checked_film(self) -> ContinuumFilm:
        film = film_from_json(self.film) if isinstance(self.film, str) else self.film
        if not isinstance(film, ContinuumFilm):
            raise InputError(f"film = {film!r}: must be a ContinuumFilm, or None for the homogeneous cone")
        own = {"stretch_limit": self.stretch_limit} | dict(self.law_parameters)
        differences = film.differences(self.law.name, own, self.stretches)
        if differences:
            raise InputError(
                f"the continuum film does not fit the model: {'; '.join(differences)}; fit another film for each law "
                "and pre-stretch (gelcone validate --fit, or gelcone.fit_film), or leave it out for the cone"
            )
        return film

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
        names = {*parameter_names(), "film"} - {"stretch_limit"}
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
        values |= {"prestretch_mode": self.prestretch_mode, "law": self.law.name}
        return values if self.film is None else values | {"film": self.film.to_json()}

    def replace(self, **changes: Any) -> ConeModel:
        """A copy with some parameters changed, by their flat names; a new law starts from its own defaults."""
        law = changes.get("law", self.law)
        law = find_law(law) if isinstance(law, str) else law
        fields = {f.name for f in dataclasses.fields(self)}
        known = [*parameter_names(), *getattr(law, "parameters", ())]
        for name in changes:
            if name not in known and name not in ("law_parameters", "film"):
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

    @cached_property
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
        shape = self.shape
        values = {
            name: value if isinstance(value, str) else np.broadcast_to(value, shape).ravel()[index]
            for name, value in self.parameters().items()
        }
        values |= {"law": self.law, "film": self.film}
        fields = {f.name for f in dataclasses.fields(self)}
        own = {k: values.pop(k) for k in list(values) if k not in fields}
        return ConeModel(**values, law_parameters=own)

    @property
    def body(self) -> Body:
        """What resists the disc: the continuum film if there is one, else the law in the homogeneous cone."""
        body: Body = self.law if self.film is None else self.film
        return body

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
        """I1 - 3 at displacements of the ensemble's shape followed by any sample axes; of a continuum film x^2."""
        x, c = self._at(x)
        return strain(x, c) if self.film is None else x * x

    def strain_limit(self, trailing: int = 0) -> Any:
        """The I1 - 3 that the film cannot reach; of a continuum film the largest x^2 that it was fitted for."""
        return self.law.strain_limit(self.coefficients(trailing).law) if self.film is None else self.film.limit

    def energy(self, x: ArrayLike) -> Any:
        """Energy of film and spring without voltage; NaN beyond the stretch limit."""
        x, c = self._at(x)
        film = self.law.energy(strain(x, c), c.law) if self.film is None else self.film.work(x)
        return film + spring_energy(x, c)

    def force(self, x: ArrayLike, voltage: Any = 0.0) -> Any:
        """Static force that holds the disc at x against film, spring and a constant voltage, per mu Vol/(b-a).

        NaN at and beyond the stretch limit, and beyond the voltage at which a continuum film pulls in.
        """
        x, c = self._at(x)
        return self._within(x, lambda: -acceleration(x, 0.0, voltage, c, self.body)[0])

    def stiffness(self, x: ArrayLike, voltage: Any = 0.0) -> Any:
        """Slope of `force`: positive where an equilibrium is stable; NaN where that is."""
        x, c = self._at(x)
        return self._within(x, lambda: -acceleration(x, 0.0, voltage, c, self.body)[1])

    def film_state(self, x: ArrayLike, voltage: Any) -> FilmState:
        """What x and the voltage do to the film; in a continuum film beside the disc, where the meridian is stretched
        most, but for the hoop stress, which is the smallest of all rings."""
        x, c = self._at(x)
        trailing = max(0, x.ndim - len(self.shape))
        squared = voltage * voltage
        q = 1.0 + x * x if self.film is None else self.film.squared_stretch(x * x, squared)
        l1, l2 = np.sqrt(c.A * q), np.sqrt(c.B) + 0.0 * x
        l3 = 1.0 / (l1 * l2)
        invariant = c.A * q + c.B + c.G / q - 3.0
        response = self.law.response(invariant, c.law)
        hoop = (l2 * l2 - l3 * l3) * response - squared * q
        meridional = (l1 * l1 - l3 * l3) * response - squared * q
        if self.film is not None:
            hoop = np.minimum(hoop, self.film.smallest_hoop_stress(x * x, squared))
            # a film that pushes the disc is compressed along its whole meridian; NaN where it has pulled in
            with np.errstate(all="ignore"):
                pull = self.film.stiffness(x * x, squared)[0] - squared
            meridional = np.where(pull < 0.0, np.minimum(meridional, pull), meridional)
        return FilmState(
            meridional_stretch=l1,
            hoop_stretch=l2,
            thickness_stretch=l3,
            meridional_stress=meridional,
            hoop_stress=hoop,
            true_field=np.abs(voltage) * np.sqrt(q),
            limit_share=invariant / self.law.strain_limit(self.coefficients(trailing).law),
        )

    def _within(self, x: Array, compute: Callable[[], Any]) -> Any:
        inside = self.strain(x) < self.strain_limit(max(0, x.ndim - len(self.shape)))
        with np.errstate(all="ignore" if self.film else None):
            return np.where(inside, compute(), np.nan)[()]


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
