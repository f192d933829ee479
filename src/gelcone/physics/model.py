"""The cone model: components and their dimensionless parameters, assembled and checked.

Energies are per mu Vol (shear modulus times film volume), times per 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)), lengths per
b - a. The equation of motion is that of `gelcone.physics.system`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from dataclasses import replace as with_fields
from functools import lru_cache
from typing import Any

import numpy as np

from gelcone.errors import InputError, check_name, unknown_name
from gelcone.physics.amplifier import ELECTRICS, with_electrics
from gelcone.physics.bias import BIASES
from gelcone.physics.component import Component
from gelcone.physics.film.branches import MOST_BRANCHES, branches_of
from gelcone.physics.film.film import Film
from gelcone.physics.film.gel import PRESTRETCH_MODES, PRESTRETCHES, BranchedFilm, GelFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.placed import DRIVES, PREFIX, PlacedFilm
from gelcone.physics.records import (
    COMPONENTS,
    FILMS,
    bias_record,
    find_part,
    with_numbers,
)
from gelcone.physics.shown import model_html
from gelcone.physics.structure import DAMPING, STRENGTH
from gelcone.physics.system import ConeSystem
from gelcone.physics.waveforms import WAVEFORMS
from gelcone.quantity import Quantity

OF_FILM = ("pull_in", "branches", "flow", "flow_exponent", "rested", "reduced")
"""Fields that some films have."""
KINDS = ("law", "prestretch_mode", "film", *OF_FILM, "bias", "waveform", "circuit", "second_film", "second_drive")
"""Arguments of a model that are not numbers: its components and their fields."""

_BOTH = ("stretch_limit", "radius_ratio", *PRESTRETCHES)
LEFT_OUT = (*_BOTH, *(PREFIX + name for name in _BOTH), *STRENGTH)
"""Parameters that None leaves out."""


class ConeModel(Ensemble):
    """A conical gel actuator in dimensionless form; arrays make an ensemble.

    Any number may be an array; all arrays broadcast together into the ensemble's `shape`. A component that is not
    named here is given as an instance, or as a table of its name, fields and numbers: ``{"component": "square",
    "duty": 0.3}``; its parameters are added to those below.

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
    dielectric_strength : true field over sqrt(mu/eps) beyond which the film breaks down. It does not change the motion;
        results say for which share of it the field is higher. Default None: unknown.
    law : a `StrainEnergyLaw` or the name of one in `LAWS`. Default Gent. Its parameters (Yeoh: ``yeoh_c2``,
        ``yeoh_c3``) are parameters of the model.
    film : a `Film`: ``"taut"`` (default) and ``"wrinkling"``, homogeneous cones; ``"membrane"``, which takes
        ``radius_ratio`` = a/b (default 0.2).
    pull_in : where a wrinkling film pulls in: ``"first"`` (default) ends the run; for study ``"minimum"``,
        ``"memoryless"`` and ``"snap"``, see `gelcone.physics.film.wrinkling.WrinklingCone`.
    branches : number of Maxwell branches, 0 to 3, of a film that creeps: ``viscous_modulus_k``, over the long-term
        shear modulus, ``relaxation_time_k`` and ``viscous_limit_k`` belong to each. Default: as many as have a number.
    flow : the branches' rule, ``"log"`` (default) or ``"linear"``; ``flow_exponent``, odd, and ``flow_stress`` make
        the logarithmic one faster under stress; see `gelcone.physics.film.branches`.
    rested : where the branches have relaxed before a run: ``"flat"`` (default), on the film as mounted, or
        ``"raised"``, where the run starts.
    reduced : fast parts without states, so that the motion is right to second order in their time:
        ``"series_resistance"`` below 0.01, a ``"relaxation_time_k"`` below 0.02, or several, joined by "+"; ``"none"``.
        They need the taut film, whose stresses leave such a branch out. Default: none, or as in the given film and
        circuit.
    bias : a `Bias`, the forces on the disc other than the film's. ``"spring"`` (default), the linear spring;
        ``"beam"``, a buckled beam; ``"weight"``; ``"force"``, a constant force; or several, as in ``"spring+weight"``.
    waveform : a `Waveform`. Default ``"sine"``.
    circuit : a `Circuit` between the commanded and the film's voltage. Default ``"ideal"``, or ``"amplifier"`` where
        one of its numbers is given: ``filter_time`` and ``slew_rate``; ``series_resistance`` and ``current_limit``
        behind it; ``leakage_time`` and ``leakage_field`` of the film. ``"charge"``: the charge is commanded.
    second_film : a `Film` on the other side of the disc, by itself or by its name, of the first film's law and
        ``prestretch_mode``: the antagonistic double cone. Its parameters are named as the first film's with ``second_``
        before them, and are the first film's where they are not given; ``second_flat_height`` is the height of the
        disc at which it is flat (default 0). Default None: a single cone.
    second_drive : its voltage: ``"same"`` as the first's (default); ``"opposite"``, in opposite phase about the same
        bias, 2 v0 - v; or ``"constant"``, the parameter ``second_voltage``.

    Raises
    ------
    InputError : for unknown names (with the nearest one), a value out of bounds, or arrays that do not
        broadcast.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=[0.4, 0.8], law="neo-hookean")
    >>> model.shape, model.damping_ratio, model.replace(voltage=1.0).voltage
    ((2,), 0.05, 1.0)
    """

    def __init__(
        self,
        *,
        law: Any = None,
        prestretch_mode: str | None = None,
        film: Any = "taut",
        pull_in: str | None = None,
        branches: int | None = None,
        flow: str | None = None,
        flow_exponent: int | None = None,
        rested: str | None = None,
        reduced: str | None = None,
        bias: Any = "spring",
        waveform: Any = "sine",
        circuit: Any = "ideal",
        second_film: Any = None,
        second_drive: str | None = None,
        **parameters: Any,
    ) -> None:
        parts = {"bias": bias, "waveform": waveform, "circuit": circuit}
        parameters = with_numbers({"film": film, **parts, **parameters})
        film, parts = parameters.pop("film"), {name: parameters.pop(name) for name in parts}
        resistance, fast = _reduced(reduced)
        parts["circuit"], parameters = with_electrics(parts["circuit"], parameters, resistance)
        film_fields: dict[str, Any] = dict(
            zip(OF_FILM, (pull_in, branches, flow, flow_exponent, rested, fast), strict=True)
        )
        system = _system(_film(film, law, prestretch_mode, film_fields, parameters), second_film, second_drive, **parts)
        values = system.complete(_known(system, parameters))
        self.__dict__.update(system=system, values=values, shape=_shape(values))

    @classmethod
    def of_system(cls, system: ConeSystem, values: Mapping[str, Any]) -> ConeModel:
        """Make a model of a system's components with the values of all parameters."""
        parts = {name: getattr(system, name) for name in ("film", "bias", "waveform", "circuit")}
        return cls(**parts, **_second_parts(system), **values)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a model does not change; model.replace({name}=...) gives one that differs")

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.parameters().items() if name != "film")
        return f"ConeModel({given})"

    def _repr_html_(self) -> str:
        """The model as a notebook shows it."""
        return model_html(self)

    # --- parameters by name ------------------------------------------------------------------------------------------

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, Any]) -> ConeModel:
        """Make a model from flat names and the records of its components, the form of files and of the command line.

        Raises `InputError` with the nearest name for one that is not known.
        """
        return cls(**parameters)

    def replace(self, **changes: Any) -> ConeModel:
        """A copy with some parameters or components changed, by their names.

        A component that changes starts from the defaults of what is its own. Raises `InputError` as the constructor.
        """
        changes = with_numbers(changes)
        given = changes.get("film", self.system.film)
        # a film that is given by its name takes over the law; an instance has its own
        law = self.law if isinstance(given, str) and given in FILMS else None
        film_fields = {name: changes.get(name) for name in OF_FILM} | {"reduced": _reduced(changes.get("reduced"))[1]}
        if law is not None:
            film_fields = {
                name: getattr(self.film, name, None) for name in OF_FILM[1:] if getattr(self.film, "branches", 0)
            } | {name: value for name, value in film_fields.items() if value is not None}
        film = _film(given, changes.get("law", law), changes.get("prestretch_mode"), film_fields, changes)
        if isinstance(film, GelFilm) and self.prestretch_mode and "prestretch_mode" not in changes:
            film = _film(film, None, self.prestretch_mode)
        parts = {name: changes.get(name, getattr(self.system, name)) for name in ("bias", "waveform", "circuit")}
        parts |= _second_parts(self.system)
        parts |= {name: changes[name] for name in ("second_film", "second_drive") if name in changes}
        if no_film(parts.get("second_film")) and "second_drive" not in changes:
            parts.pop("second_drive", None)
        others = self._others(changes, _system(film, **parts))
        numbers = {name: value for name, value in changes.items() if name not in KINDS}
        return ConeModel(film=film, **parts, reduced=changes.get("reduced"), **(others | numbers))

    def _others(self, changes: Mapping[str, Any], system: ConeSystem) -> dict[str, Any]:
        """The parameters that ``system`` takes over, given the ``changes``."""
        values = {name: value for name, value in self.values.items() if name in system.parameters}
        if "law" in changes and self.law is not None and getattr(system.film, "law", None) != self.law:
            values = {name: v for name, v in values.items() if name.removeprefix(PREFIX) not in self.law.parameters}
        for prefix in ("", PREFIX):
            prestretches = {prefix + name for name in PRESTRETCHES}
            if any(changes.get(name) is not None for name in prestretches):
                values = {k: v for k, v in values.items() if k not in prestretches or _goes_with(k, changes, prefix)}
        return values

    @property
    def stiff(self) -> tuple[str, ...]:
        """Names for ``reduced`` of the parts that have states and need none."""
        stiff_names, reduced = [], self.reduced
        for name in ("series_resistance", *(f"relaxation_time_{k}" for k in range(1, MOST_BRANCHES + 1))):
            if name in reduced or name not in self.values:
                continue
            try:
                self.replace(reduced="+".join((*reduced, name)))
            except InputError:
                continue
            stiff_names.append(name)
        return tuple(stiff_names)

    @property
    def reduced(self) -> tuple[str, ...]:
        """Names in ``reduced``: the parts whose states are left out."""
        resistance = ("series_resistance",) if getattr(self.system.circuit, "reduced", False) else ()
        return (*resistance, *(f"relaxation_time_{k}" for k in getattr(self.film, "reduced", ())))

    @property
    def law(self) -> StrainEnergyLaw | None:
        """The film's strain-energy law; None for a film without one."""
        return getattr(self.system.film, "law", None)

    @property
    def film(self) -> Film:
        """The first film."""
        return self.system.film

    def gel_law(self) -> StrainEnergyLaw:
        """The film's strain-energy law; `InputError` for a film without one."""
        if self.law is None:
            raise InputError(f"film = {self.film.name}: has no strain-energy law, which this needs; take the taut film")
        return self.law

    @property
    def stretch_limit(self) -> Any:
        """The law's stretch limit; infinity for one without."""
        return self.values.get("stretch_limit", np.inf)

    @property
    def prestretch_mode(self) -> str | None:
        """The meaning of one pre-stretch; None for a film without one."""
        return getattr(self.system.film, "prestretch_mode", None)

    @property
    def stretches(self) -> tuple[Any, Any]:
        """Meridional and hoop pre-stretch lm, lh; 1 for a film that has none."""
        film = self.system.film
        return film.stretches(self.values) if isinstance(film, GelFilm) else (1.0, 1.0)

    # --- members -----------------------------------------------------------------------------------------------------

    def take(self, index: Any) -> ConeModel:
        """The members at ``index`` of the flattened ensemble, in a one-dimensional ensemble."""
        flat = {name: np.broadcast_to(value, self.shape).ravel()[index] for name, value in self.values.items()}
        return self.replace(**flat)


def _reduced(given: Any) -> tuple[bool | None, tuple[int, ...] | None]:
    """Whether the series resistance has no state, and the numbers of the branches without states; None if not given."""
    if given is None:
        return None, None
    names = [] if given == "none" else [part.strip() for part in str(given).split("+")]
    allowed = ("series_resistance", *(f"relaxation_time_{k}" for k in range(1, MOST_BRANCHES + 1)))
    for name in names:
        if name not in allowed:
            raise unknown_name("reduced", name, (*allowed, "none"))
    branches = tuple(sorted(allowed.index(name) for name in names if name != allowed[0]))
    return allowed[0] in names, branches


def _film(
    film: Any, law: Any, mode: str | None, own: Mapping[str, Any] | None = None, parameters: Iterable[str] = ()
) -> Film:
    """Make the film with a law, a pre-stretch ``mode`` and its ``own`` fields, None if not given. It has at least as
    many branches as ``parameters`` name."""
    if law is not None:
        law = find_part("law", law)
    if mode is not None:
        check_name("prestretch_mode", mode, PRESTRETCH_MODES)
    new_film: Film = find_part("film", film)
    chosen = {name: value for name, value in (own or {}).items() if value is not None}
    if not chosen.get("reduced", True) and not hasattr(new_film, "reduced"):
        del chosen["reduced"]  # a film without branches reduces none
    if "branches" not in chosen and (count := branches_of(parameters)) > getattr(new_film, "branches", 0):
        chosen["branches"] = count
    for name, value in chosen.items():
        if name not in {field.name for field in fields(new_film)} if is_dataclass(new_film) else True:
            takes = {"pull_in": "wrinkling", "reduced": "taut"}.get(name, "membrane, wrinkling or taut")
            raise InputError(
                f"{name}: the film {new_film.name!r} does not take it; take the film {takes}, or leave it out"
            )
        chosen[name] = int(value) if isinstance(value, float) and value.is_integer() else value
    new_film = with_fields(new_film, **chosen) if chosen else new_film  # type: ignore[type-var]
    if not isinstance(new_film, GelFilm):
        if law is not None or mode is not None:
            raise InputError(f"law, prestretch_mode: the film {new_film.name!r} takes neither; leave them out")
        return new_film
    of_gel = {"law": law, "prestretch_mode": mode}
    return with_fields(new_film, **{name: value for name, value in of_gel.items() if value is not None})  # type: ignore[type-var]


def no_film(given: Any) -> bool:
    """Whether the value of ``second_film`` stands for none."""
    return given is None or (isinstance(given, str) and given == "none")


def _films(first: Film, given: Any, drive: str | None) -> tuple[PlacedFilm, ...]:
    """The placed films; a second one takes over the law, the pre-stretch mode and the branches of the first."""
    if no_film(given):
        if drive is not None:
            raise InputError(
                f"second_drive = {drive}: there is no second film; give second_film = 'taut', or leave it out"
            )
        return (PlacedFilm(first),)
    film = given if isinstance(given, Film) else _film(given, None, None)
    of_branches = OF_FILM[1:] if getattr(first, "branches", 0) else ()
    shared = {GelFilm: ("law", "prestretch_mode"), BranchedFilm: of_branches, WrinklingCone: OF_FILM[:1]}
    for kind, names in shared.items():
        if isinstance(film, kind) and isinstance(first, kind):
            film = with_fields(film, **{name: getattr(first, name) for name in names})  # type: ignore[type-var]
    return PlacedFilm(first), PlacedFilm(film, "same" if drive is None else drive)


def _system(film: Film, second_film: Any = None, second_drive: str | None = None, **parts: Any) -> ConeSystem:
    """Assemble films, bias, waveform and circuit; `InputError` for one that is not known."""
    components = (find_part(name, parts[name]) for name in ("bias", "waveform", "circuit"))
    return _put_together(_films(film, second_film, second_drive), *components)


@lru_cache(maxsize=64)
def _put_together(*parts: Any) -> ConeSystem:
    """Assemble the system once for equal components, since it caches its names and numbers."""
    return ConeSystem(*parts)


def _second_parts(system: ConeSystem) -> dict[str, Any]:
    """The arguments of a model that describe the second film of a system; empty without one."""
    return {"second_film": film.film, "second_drive": film.drive} if (film := system.films[-1]).drive else {}


def _known(system: ConeSystem, given: Mapping[str, Any]) -> dict[str, Any]:
    """The ``given`` parameters without those left out; `InputError` for a name that the system does not take."""
    known = system.parameters
    values = {name: value for name, value in given.items() if value is not None or name not in LEFT_OUT}
    if "stretch_limit" in values and "stretch_limit" not in known and _infinite(values["stretch_limit"]):
        del values["stretch_limit"]  # a law without a limit has an infinite one
    for name in values:
        if name in known:
            continue
        law = getattr(system.film, "law", None)
        if law is not None and any(name in other.parameters for other in LAWS.values()):
            takes = ", ".join(law.parameters) or "no parameters"
            raise InputError(f"{name}: the {law.name} law does not take it; it takes {takes}")
        if name.startswith(PREFIX) and len(system.films) == 1 and name in PARAMETERS:
            raise InputError(f"{name}: there is no second film; give second_film = 'taut'")
        owner = next((bias for bias in BIASES.values() if name in bias.parameters), None)
        if owner is not None:
            raise InputError(
                f"{name}: is a parameter of the bias {owner.name!r}, which this model has not; give bias = "
                f"'{bias_record(system.bias)}+{owner.name}'"
            )
        if shape := next((one.name for one in WAVEFORMS.values() if name in one.parameters), None):
            raise InputError(
                f"{name}: is a parameter of the waveform {shape!r}, which this model has not; give waveform = '{shape}'"
            )
        raise unknown_name("model parameter", name, [*known, *KINDS])
    return values


def _infinite(value: Any) -> bool:
    try:
        return bool(np.isinf(np.asarray(value, dtype=float)).all())
    except (TypeError, ValueError):
        return False


def _goes_with(name: str, changes: Mapping[str, Any], prefix: str) -> bool:
    """Whether a direct pre-stretch stays, because the other direct one changes."""
    direct = {prefix + "meridional_prestretch", prefix + "hoop_prestretch"}
    return name in direct and any(changes.get(other) is not None for other in direct)


def _shape(values: Mapping[str, Any]) -> tuple[int, ...]:
    arrays = {name: np.shape(value) for name, value in values.items()}
    try:
        return np.broadcast_shapes(*arrays.values())
    except ValueError:
        shapes = ", ".join(f"{name} {shape}" for name, shape in arrays.items() if shape)
        raise InputError(f"the parameter arrays do not broadcast together: {shapes}") from None


# --- names of all parameters, without a model -------------------------------------------------------------------------


def shipped_components() -> Iterable[Component]:
    """All components that ship."""
    return [part for _, shipped, _ in COMPONENTS.values() for part in shipped.values()]


def _shipped_parameters() -> dict[str, Quantity]:
    parts = {name: q for part in shipped_components() for name, q in part.parameters.items()}
    seconds = [PlacedFilm(TautCone(law), drive) for law in LAWS.values() for drive in DRIVES]
    parts |= {name: q for second in seconds for name, q in second.parameters.items()}
    first = [*DAMPING, "spring_stiffness", "voltage", "voltage_bias", "drive_frequency", "rest_height", *PRESTRETCHES]
    return {name: (DAMPING | parts)[name] for name in first} | parts | dict(ELECTRICS) | STRENGTH


PARAMETERS = _shipped_parameters()
"""The numeric parameters of all components that ship, by name."""


def parameter_names() -> list[str]:
    """All names that a model of shipped components takes."""
    return [*PARAMETERS, *KINDS]


def parameter_quantity(name: str, system: ConeSystem | None = None) -> Quantity:
    """The `Quantity` behind a numeric parameter; `InputError` for an unknown or non-numeric one."""
    known = PARAMETERS | (system.parameters if system else {})
    check_name("numeric model parameter", name, known)
    return known[name]


def single(members: Members, row: int) -> ConeModel:
    """One member as a single model."""
    return ConeModel.of_system(members.system, {name: float(value[row]) for name, value in members.values.items()})
