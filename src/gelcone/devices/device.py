"""A device in SI units: read from Python or TOML, checked, and turned into a `ConeModel`."""

from __future__ import annotations

import tomllib
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import astuple
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from gelcone import permission
from gelcone.devices.files import located, shipped_devices, what_ships
from gelcone.devices.materials import Material, find_material
from gelcone.devices.record import Field, Record, unknown_field
from gelcone.devices.scales import Scales, carried_mass
from gelcone.devices.template import device_text
from gelcone.devices.units import FieldError, format_si
from gelcone.errors import DoubtfulInput, InputError, unknown_name
from gelcone.files import read_text
from gelcone.physics.drive import WAVEFORMS
from gelcone.physics.film.fitted import FittedFilm
from gelcone.physics.film.taut import PRESTRETCH_MODES
from gelcone.physics.film.wrinkling import PULL_IN
from gelcone.physics.model import ConeModel
from gelcone.physics.records import FILMS
from gelcone.physics.second import DRIVES
from gelcone.physics.statics import every_balance, rest_displacements, switched_off

DAMPINGS = ("damping_coefficient", "damping_ratio", "quality_factor")
"""Three ways to give the damping; a device takes one of them."""
DIRECT_PRESTRETCHES = ("meridional_prestretch", "hoop_prestretch")
THICK = 0.5
"""A film this thick, over the width b - a of its ring, is no membrane."""


class Device(Record):
    """A conical gel actuator in SI units. In place of each number, a string such as ``"50 mm"`` will do.

    Every number may also be a list or one-dimensional array, all of one length: an ensemble, member by member.
    ``gelcone help device`` lists the fields with their units, and ``gelcone init mine.toml`` writes a file of them.

    Parameters
    ----------
    name : what it is called. Default "unnamed device"; a file's name when read from a file.
    disc_radius : radius a of the rigid disc, m, positive and less than ``film_radius``.
    film_radius : radius b at which the film is clamped, m.
    film_thickness : thickness H of the film as mounted (flat, after pre-stretch), m, positive.
    material : name of a library material, a `Material`, or a mapping of its fields.
    prestretch, prestretch_mode, meridional_prestretch, hoop_prestretch : as in `ConeModel`.
    pull_in : where a wrinkling film pulls in: ``"first"`` (default) ends the run; for study ``"minimum"``,
        ``"memoryless"`` and ``"snap"``, see `gelcone.physics.film.wrinkling.WrinklingCone`.
    film : ``"wrinkling"`` (default), a homogeneous cone without compression; ``"taut"``, one that bears it;
        ``"continuum"``, the continuum film, fitted on first use and kept (see `gelcone.continuum.fit.find_film`); or a
        file that ``gelcone validate --fit`` wrote, in a device file relative to it.
    spring_rate : stiffness k of the spring, N/m, at least 0.
    initial_height : height h0 of the disc at which the spring is free, m. Default 0.
    beam_rate, beam_cubic_rate, beam_height : a buckled beam on the disc, of the force beam_rate d + beam_cubic_rate d^3
        with d from ``beam_height``; N/m (negative: buckled), N/m^3 and m. Default none.
    constant_force : pushes the disc up, away from the film's plane, N. Default none.
    gravity : along the axis, m/s^2: positive where it pulls a raised disc down, negative on a device that hangs.
        Default none: the axis is level. It acts on ``moving_mass`` and ``payload``.
    payload : mass carried by the disc, kg. Default none.
    moving_mass : mass m of the disc and what moves with it, kg, positive.
    damping_coefficient : viscous damping c, N s/m, at least 0. Or ``damping_ratio`` zeta = c/(2 m omega), or
        ``quality_factor`` Q = 1/(2 zeta), with the natural frequency omega about the rest without voltage; one of them.
    dielectric_strength : true field that the film stands, V/m, positive. Default: the material's (None = unknown).
    voltage_amplitude : amplitude of the drive offset + amplitude sin(2 pi f t), V, at least 0.
    voltage_offset : its constant part, V. Default 0.
    frequency : f, Hz, positive.
    waveform : ``"sine"`` (default), or ``"triangle"``, up and down at a constant rate in phase with the sine.
    release_height : the disc is held there and let go at t = 0, m. Default: it starts from rest, see `initial_state`.
    release_velocity : its velocity at t = 0, m/s. Default 0.
    second_film : ``"taut"`` or ``"wrinkling"``, on the other side of the disc: a double cone. Of the first film's
        material, thickness and ``prestretch_mode``. Default none.
    second_flat_height : height of the disc at which the second film is flat, m. Default 0.
    second_prestretch, second_meridional_prestretch, second_hoop_prestretch : default the first film's.
    second_drive : ``"same"`` (default), ``"opposite"`` or ``"constant"``, as in `ConeModel`; ``second_voltage``, V, is
        the constant one.

    A field of the material is reached by a dotted name, such as ``"material.shear_modulus"``.

    Raises
    ------
    InputError : a line each, for values that are missing, unknown, not exact or out of bounds.
    """

    kind: ClassVar[str] = "device"

    # A field is one entry here, and its part of the model one line in `_cone`.
    name: Any = Field("name of the device", default="unnamed device", unset="the file's name", near=("title", "device"))
    disc_radius: Any = Field(
        "radius of the rigid disc", "m", typical=(1e-3, 0.05), above=0.0,
        near=("inner_radius", "disk_radius", "radius_disc", "radius", "a", "r_in", "disc_diameter", "diameter"),
    )  # fmt: skip
    film_radius: Any = Field(
        "radius at which the film is clamped", "m", typical=(5e-3, 0.2), above=0.0,
        near=("outer_radius", "membrane_radius", "rim_radius", "radius", "b", "r_out", "film_diameter", "diameter"),
    )  # fmt: skip
    film_thickness: Any = Field(
        "thickness of the film as mounted (flat, after pre-stretch)", "m", typical=(2e-5, 2e-3), above=0.0,
        near=("thickness", "membrane_thickness", "height_film", "t", "h"),
    )  # fmt: skip
    material: Any = Field(
        "name of a gel that ships (`gelcone materials`), or a table [material] of its numbers",
        near=("gel", "film_material", "material_name"),
    )
    prestretch: Any = Field(
        "pre-stretch of the mounted film, along the hoop (radial mode) or in both directions (equibiaxial)", "1",
        default=None, unset="1 (none)", typical=(0.5, 4.0), near=("pre_stretch", "stretch", "lambda_p"),
        above=0.0,
    )  # fmt: skip
    prestretch_mode: Any = Field(
        "what one pre-stretch means: radial (hoop only) or equibiaxial", default="radial", near=("mode", "stretch_mode")
    )
    meridional_prestretch: Any = Field(
        "pre-stretch from rim to disc, in place of prestretch", "1", default=None, unset="1", typical=(0.5, 4.0),
        near=("radial_prestretch",), above=0.0,
    )  # fmt: skip
    hoop_prestretch: Any = Field(
        "pre-stretch along the hoop, in place of prestretch", "1", default=None, unset="1", typical=(0.5, 4.0),
        near=("circumferential_prestretch",), above=0.0,
    )  # fmt: skip
    film: Any = Field(
        "wrinkling or taut (homogeneous cones), continuum, or a file that gelcone validate --fit wrote",
        default="wrinkling",
        near=("film_model", "membrane"),
    )  # fmt: skip
    pull_in: Any = Field(
        "where a wrinkling film pulls in, a run ends (first); for study: minimum, memoryless or snap", default=None,
        unset="first", near=("after_pull_in", "on_pull_in"),
    )  # fmt: skip
    spring_rate: Any = Field(
        "stiffness of the spring", "N/m", typical=(1.0, 2000.0), least=0.0,
        near=("spring_stiffness", "stiffness", "spring_constant", "spring", "k"),
    )  # fmt: skip
    initial_height: Any = Field(
        "height of the disc at which the spring is free", "m", default=0.0, typical=(1e-3, 0.1),
        near=("rest_height", "height", "free_height", "preload", "h0", "spring_height"),
    )  # fmt: skip
    beam_rate: Any = Field(
        "stiffness of a buckled beam where it is straight, negative", "N/m", default=None, unset="no beam",
        typical=(0.1, 2000.0), near=("negative_rate", "negative_stiffness", "negative_spring", "buckled_beam", "k1"),
    )  # fmt: skip
    beam_cubic_rate: Any = Field(
        "cubic stiffness of the beam", "N/m^3", default=None, unset="0", typical=(1e2, 1e8), least=0.0,
        near=("cubic_stiffness", "k3"),
    )  # fmt: skip
    beam_height: Any = Field(
        "height of the disc at which the beam is straight", "m", default=None, unset="0", typical=(1e-3, 0.1),
        near=("beam_offset", "snap_height"),
    )  # fmt: skip
    constant_force: Any = Field(
        "force that pushes the disc up, wherever it is", "N", default=None, unset="none", typical=(1e-3, 10.0),
        near=("force", "push", "load", "external_force"),
    )  # fmt: skip
    gravity: Any = Field(
        "gravity along the axis, positive where it pulls a raised disc down", "m/s^2", default=None,
        unset="none: the axis is level", typical=(0.5, 20.0), near=("g", "weight", "gravitational_acceleration"),
    )  # fmt: skip
    payload: Any = Field(
        "mass carried by the disc", "kg", default=None, unset="none", typical=(1e-4, 0.5), least=0.0,
        near=("load_mass", "carried_mass", "weight", "biasing_mass"),
    )  # fmt: skip
    moving_mass: Any = Field(
        "mass of the disc and what moves with it", "kg", typical=(1e-4, 0.5), near=("mass", "disc_mass", "m"), above=0.0
    )
    damping_coefficient: Any = Field(
        "viscous damping of the disc", "N s/m", default=None, unset="or give damping_ratio or quality_factor",
        typical=(1e-4, 10.0), near=("damping", "viscous_damping", "c", "dashpot"), least=0.0,
    )  # fmt: skip
    damping_ratio: Any = Field(
        "damping over the critical damping, about the rest without voltage", "1", default=None,
        unset="or give damping_coefficient or quality_factor", typical=(1e-3, 1.0), near=("damping", "zeta"), least=0.0,
    )  # fmt: skip
    quality_factor: Any = Field(
        "quality factor of the free vibration about the rest without voltage", "1", default=None,
        unset="or give damping_coefficient or damping_ratio", typical=(0.5, 500.0), near=("damping", "q", "q_factor"),
        above=0.0,
    )  # fmt: skip
    dielectric_strength: Any = Field(
        "true electric field that the film stands", "V/m", default=None, unset="the material's, or unknown",
        typical=(1e6, 2e8), near=("breakdown", "breakdown_field", "breakdown_strength", "field_limit"), above=0.0,
    )  # fmt: skip
    voltage_amplitude: Any = Field(
        "amplitude of the drive: voltage = offset + amplitude sin(2 pi frequency t)", "V", typical=(50.0, 2e4),
        least=0.0, near=("voltage", "amplitude", "drive_voltage", "v", "u", "ac_voltage"),
    )  # fmt: skip
    voltage_offset: Any = Field(
        "constant part of the drive", "V", default=0.0, typical=(50.0, 2e4),
        near=("voltage_bias", "bias", "offset", "bias_voltage", "dc_voltage", "voltage_dc"),
    )  # fmt: skip
    frequency: Any = Field(
        "frequency of the drive", "Hz", typical=(0.1, 1000.0), above=0.0,
        near=("drive_frequency", "omega", "f", "driving_frequency", "voltage_frequency"),
    )  # fmt: skip
    waveform: Any = Field("shape of the alternating part: sine or triangle", default="sine", near=("shape", "drive"))
    release_height: Any = Field(
        "height at which the disc is held and let go at t = 0", "m", default=None,
        unset="its rest without voltage", typical=(1e-4, 0.1),
        near=("displacement", "initial_displacement", "start_height", "x0"),
    )  # fmt: skip
    release_velocity: Any = Field(
        "velocity of the disc at t = 0", "m/s", default=0.0, typical=(1e-3, 10.0),
        near=("velocity", "initial_velocity", "start_velocity"),
    )  # fmt: skip

    second_film: Any = Field(
        "film on the other side of the disc, for a double cone: taut or wrinkling", default=None,
        unset="none: a single cone", near=("antagonist", "other_film", "double_cone"),
    )  # fmt: skip
    second_flat_height: Any = Field(
        "height of the disc at which the second film is flat", "m", default=None, unset="0", typical=(1e-3, 0.1),
        near=("separation", "rod_length", "spacer_height"),
    )  # fmt: skip
    second_prestretch: Any = Field(
        "pre-stretch of the second film, as prestretch", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0,
    )  # fmt: skip
    second_meridional_prestretch: Any = Field(
        "pre-stretch of the second film from rim to disc", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0,
    )  # fmt: skip
    second_hoop_prestretch: Any = Field(
        "pre-stretch of the second film along the hoop", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0,
    )  # fmt: skip
    second_drive: Any = Field(
        "voltage of the second film: same, opposite (offset - amplitude sin) or constant", default=None, unset="same",
        near=("second_phase", "antagonist_drive"),
    )  # fmt: skip
    second_voltage: Any = Field(
        "constant voltage of the second film, where second_drive is constant", "V", default=None, unset="0",
        typical=(50.0, 2e4), near=("second_voltage_offset", "antagonist_voltage"),
    )  # fmt: skip

    def __init__(self, /, **values: Any) -> None:
        super().__init__(**_with_material(values))
        for doubt in self.doubts():
            warnings.warn(doubt, DoubtfulInput, stacklevel=2)

    # --- checks ---------------------------------------------------------------------------------------------------

    @classmethod
    def all_fields(cls) -> dict[str, Field]:
        """All fields, the material's under dotted names."""
        return {**cls.fields, **{f"material.{name}": field for name, field in Material.fields.items()}}

    @classmethod
    def field_names(cls) -> list[str]:
        return list(cls.all_fields())

    @classmethod
    def unknown(cls, name: str) -> FieldError:
        return unknown_field("device", name, DEVICE_FIELDS)

    def read(self, name: str, value: Any) -> Any:
        if name == "material":
            return _as_material(value)
        value = super().read(name, value)
        for own, kind, known in _CHOICES:
            if name == own and value not in known:
                raise FieldError(name, f"{name}: {unknown_name(kind, value, known)}")
        return value

    def get(self, name: str) -> Any:
        """The value of a field, the material's under dotted names."""
        return getattr(self.material, name[len(_DOT) :]) if name.startswith(_DOT) else getattr(self, name)

    def misfits(self) -> Iterator[FieldError]:
        errors = [*self._own_misfits()]
        yield from errors
        if not errors:
            with np.errstate(all="ignore"):
                try:
                    self._check_heights(self.cone_model())
                except FieldError as error:
                    yield error
                except InputError as error:
                    yield FieldError(str(error).split(" ")[0], str(error))

    def _own_misfits(self) -> Iterator[FieldError]:
        lengths = {n: value.size for n in SWEPT_FIELDS if isinstance(value := self.get(n), np.ndarray)}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            yield FieldError(next(iter(lengths)), f"{told} values; give lists of one length")
            return
        for owner, names in _BELONGING:
            if getattr(self, owner) is None:
                for name in names:
                    if getattr(self, name) is not None:
                        yield FieldError(name, f"{name}: there is no {owner}; give {owner}, or leave {name} out")
        if self.second_voltage is not None and self.second_film is not None and self.second_drive != "constant":
            yield FieldError(
                "second_voltage", 'second_voltage: is taken where second_drive is "constant" alone; give that'
            )
        given = [name for name in DAMPINGS if getattr(self, name) is not None]
        if not given:
            yield FieldError(
                DAMPINGS[0],
                f"{DAMPINGS[0]}: is missing; give the viscous damping in N s/m, or {' or '.join(DAMPINGS[1:])}",
            )
        if len(given) > 1:
            yield FieldError(given[1], f"{' and '.join(given)} are both given; give one of them")
        disc, film = np.broadcast_arrays(self.disc_radius, self.film_radius)
        if (disc >= film).any():
            at = int(np.argmax(disc - film))
            yield FieldError(
                "disc_radius",
                f"disc_radius = {format_si(disc.flat[at], 'm')}: must be less than film_radius = "
                f"{format_si(film.flat[at], 'm')}; make the disc smaller or the film larger",
            )
        elif not self._usable_scales():
            yield FieldError(
                "film_thickness", "the sizes, mass and shear modulus give no finite time and energy; check their units"
            )

    def _usable_scales(self) -> bool:
        try:
            with np.errstate(all="ignore"):
                return all(
                    bool((np.isfinite(scale) & (np.asarray(scale) > 0.0)).all()) for scale in astuple(self.scales)
                )
        except (OverflowError, ZeroDivisionError):
            return False

    def _check_heights(self, model: ConeModel) -> None:
        members = model.members()
        system, n = model.system, members.numbers()
        flat = np.broadcast_to(system.film.strain(np.zeros(members.size), n), members.shape)
        limit = np.broadcast_to(system.film.strain_limit(n), members.shape)
        if not (flat < limit).any():
            raise FieldError(
                "prestretch",
                f"prestretch: mounted flat, the film has I1 - 3 = {float(flat[0]):.4g}, which must be "
                f"less than its stretch limit {float(limit[0]):.4g}; lower the pre-stretch or raise "
                "the limit",
            )
        if system.second is not None and not any(balance.reachable for balance in every_balance(model)):
            raise FieldError("second_flat_height", system.unreachable(members.numbers_at(0)))
        if self.release_height is None:
            return
        lengths = np.broadcast_to(self.scales.length, members.shape)
        starts = np.broadcast_to(self.release_height, members.shape) / lengths
        if not (members.strain(starts) >= members.strain_limit()).all():
            return
        told = f"release_height = {format_si(np.ravel(self.release_height)[0], 'm')}"
        if system.second is not None:
            reason = "out of reach of the films within their stretch limits; start between their planes"
            raise FieldError("release_height", f"{told}: is {reason} or raise material.stretch_limit")
        highest = system.film.reach(members.numbers_at(0))[1] * lengths[0]
        raise FieldError(
            "release_height",
            f"{told}: must be less than {format_si(highest, 'm')}, where the film reaches its stretch limit "
            f"{float(limit[0]):.4g}; start lower or raise material.stretch_limit",
        )

    def doubts(self) -> list[str]:
        """What is hardly meant: sizes far from what is usual, each in a line."""
        told = []
        for name, field in DEVICE_FIELDS.items():
            odd = field.implausible(self.get(name)) if field.unit in _SIZES else None
            if odd is not None:
                told.append(
                    f"{name} = {format_si(odd, field.unit)} is far from what is usual "
                    f"({field.typical_text()}); check its unit"
                )
        with np.errstate(all="ignore"):
            thick = np.ravel(np.asarray(self.film_thickness) / self.scales.length)
        if thick.max() > THICK and not any(text.startswith("film_thickness") for text in told):
            at = int(thick.argmax())
            thickness, width = (np.broadcast_to(v, thick.shape)[at] for v in (self.film_thickness, self.scales.length))
            told.append(
                f"film_thickness = {format_si(thickness, 'm')} is no membrane on a ring {format_si(width, 'm')} wide "
                "(film_radius - disc_radius); check the units"
            )
        return told

    # --- to the model and back ---------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """(members,), or () for a single device."""
        return next((value.shape for n in SWEPT_FIELDS if isinstance(value := self.get(n), np.ndarray)), ())

    @cached_property
    def scales(self) -> Scales:
        """The SI value of each dimensionless unit."""
        return Scales.of(self.get)

    def to_model(self) -> ConeModel:
        """The dimensionless model with its ``film``; arrays make an ensemble of their length."""
        return self._damped(self._with_film)

    def _with_film(self, damping_ratio: Any = 0.0) -> ConeModel:
        """The model with its film and a damping."""
        if self.film in FILMS:
            model = self._cone(damping_ratio, str(self.film))
            return model if self.pull_in is None else model.replace(pull_in=self.pull_in)
        model = self._cone(damping_ratio)
        return model.replace(film=self.film_for(model), pull_in=self.pull_in)

    def film_for(self, model: ConeModel, *, starting: Callable[[], None] = lambda: None) -> FittedFilm | str:
        """The film that ``film`` names, a cone by its name; ``starting`` is called before one is fitted."""
        if self.film in FILMS:
            return str(self.film)
        from gelcone.continuum.fit import find_film

        ratios = np.unique(self.disc_radius / self.film_radius)
        if ratios.size > 1:
            raise FieldError(
                "film",
                "film: a continuum is fitted for one disc_radius/film_radius; take the wrinkling cone",
            )
        return find_film(self.film, model, float(ratios[0]), starting=starting)

    def cone_model(self) -> ConeModel:
        """`to_model` with the film as a homogeneous cone."""
        return self._damped(self._cone)

    def _cone(self, damping_ratio: Any = 0.0, film: str = "taut") -> ConeModel:
        """The homogeneous cone with a damping."""
        s = self.scales
        return ConeModel(
            **self._loads(),
            **self._second(),
            film=film,
            damping_ratio=damping_ratio,
            spring_stiffness=self.spring_rate * s.length / s.force,
            voltage=self.voltage_amplitude / s.voltage,
            voltage_bias=self.voltage_offset / s.voltage,
            drive_frequency=self.frequency / s.frequency,
            rest_height=self.initial_height / s.length,
            dielectric_strength=self.breakdown_field(),
            prestretch=self.prestretch,
            prestretch_mode=self.prestretch_mode,
            waveform=self.waveform,
            meridional_prestretch=self.meridional_prestretch,
            hoop_prestretch=self.hoop_prestretch,
            law=self.material.law,
            **self.material.law_parameters,
        )

    def _loads(self) -> dict[str, Any]:
        """What acts on the disc besides film and spring."""
        s, kinds, numbers = self.scales, ["spring"], {}
        if self.beam_rate is not None:
            kinds.append("beam")
            numbers["beam_stiffness"] = self.beam_rate * s.length / s.force
            numbers["beam_cubic"] = (
                (0.0 if self.beam_cubic_rate is None else self.beam_cubic_rate) * s.length**3 / s.force
            )
            numbers["beam_height"] = (0.0 if self.beam_height is None else self.beam_height) / s.length
        if self.gravity is not None:
            kinds.append("weight")
            numbers["weight"] = carried_mass(self.get) * self.gravity / s.force
        if self.constant_force is not None:
            kinds.append("force")
            numbers["push"] = self.constant_force / s.force
        return {"bias": "+".join(kinds)} | numbers

    def _second(self) -> dict[str, Any]:
        """The second film of the model; nothing for a single cone."""
        if self.second_film is None:
            return {}
        s, stretches = self.scales, {name: getattr(self, name) for name in _SECOND_PRESTRETCHES}
        drive = "same" if self.second_drive is None else self.second_drive
        return {
            "second_film": self.second_film,
            "second_drive": drive,
            "second_flat_height": _or_zero(self.second_flat_height) / s.length,
            **({"second_voltage": _or_zero(self.second_voltage) / s.voltage} if drive == "constant" else {}),
            **{name: value for name, value in stretches.items() if value is not None},
        }

    def _damped(self, build: Callable[..., ConeModel]) -> ConeModel:
        """What ``build`` makes of the damping ratio c/(2 m Omega0) of the device."""
        if self.damping_coefficient is not None:
            ratio = self.damping_coefficient * self.scales.time / (2.0 * carried_mass(self.get))
            return build(np.broadcast_to(ratio, self.shape)[()])
        model = build()
        name = "damping_ratio" if self.quality_factor is None else "quality_factor"
        ratio = self.damping_ratio if self.quality_factor is None else 0.5 / self.quality_factor
        stiffness = np.asarray(switched_off(model).stiffness(rest_displacements(model)))
        if not (stiffness > 0.0).all():
            raise FieldError(
                name,
                f"{name}: refers to the free vibration about the rest without voltage, and there is none, for nothing "
                "pulls the disc back; give damping_coefficient",
            )
        return model.replace(damping_ratio=np.broadcast_to(ratio * np.sqrt(stiffness), self.shape)[()])

    def initial_state(self) -> Any:
        """Displacement and velocity at t = 0, dimensionless: two numbers, or an array (members, 2) where they differ.

        The displacement is the release height or, without one, the stable rest equilibrium of the film and spring
        without voltage that is nearest the initial height. Raises `InputError` when there is none.
        """
        s = self.scales
        velocity = self.release_velocity / s.velocity
        if self.release_height is not None:
            x = self.release_height / s.length
        else:
            x = rest_displacements(self._with_film())
            if np.isnan(x).all():
                raise FieldError(
                    "initial_height",
                    "initial_height: no stable rest position was found without voltage; give a release_height",
                )
            # A member without a rest has a film beyond its stretch limit, and fails wherever it starts.
            x = np.where(np.isnan(x), 0.0, x)[()]
        states = np.stack(np.broadcast_arrays(x, velocity), axis=-1)
        if states.ndim > 1 and (states != states[0]).any():
            return states
        return float(np.ravel(x)[0]), float(np.ravel(velocity)[0])

    def breakdown_field(self) -> Any:
        """Dielectric strength over the scale of the field, or None when it is unknown."""
        strength = self.material.dielectric_strength if self.dielectric_strength is None else self.dielectric_strength
        return None if strength is None else strength / self.scales.field

    # --- variants and files ------------------------------------------------------------------------------------------

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Device:
        """A copy with some fields changed; None takes a field's default.

        ``changes`` serves dotted names: ``device.replace({"material.shear_modulus": "20 kPa"}, frequency=8.0)``.
        Giving ``prestretch`` drops the two direct pre-stretches, and the reverse; one form of damping drops the others.
        Raises `InputError` as the constructor does.
        """
        changed = {**(changes or {}), **more}
        values = {name: value for name, value in self if value is not None}
        for own, others in _EXCLUDING:
            if any(changed.get(name) is not None for name in own):
                values = {name: value for name, value in values.items() if name not in others or name in own}
        return Device(**values | changed)

    def replace_quietly(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Device:
        """`replace` without warnings: for the points of a sweep, whose device was checked before."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DoubtfulInput)
            return self.replace(changes, **more)

    def redriven(self, changes: Mapping[str, Any]) -> Device:
        """`replace_quietly` of numbers among `DRIVE_NUMBERS`, on which no check of another field rests, in a quarter of
        its time. `FieldError` as there."""
        driven = Device.__new__(Device)
        driven.__dict__.update(self.__dict__, **{name: self.read(name, value) for name, value in changes.items()})
        return driven

    def to_toml(self) -> str:
        """The device as the text of a device file, which `from_toml` reads back as an equal device."""
        return device_text(self, self.material)

    @classmethod
    def from_toml(cls, path: str | Path) -> Device:
        """A device from a TOML file whose keys are the fields, the material's in a table ``[material]``.

        Raises `InputError` with the file, and the line where it can be told, for a file that cannot be read or used.
        """
        path = Path(path)
        return cls._from_text(read_text(path, what_ships()), str(path), path.stem, path.parent)

    @classmethod
    def from_text(cls, text: str) -> Device:
        """A device from the text of a device file; `InputError` as from `from_toml`."""
        return cls._from_text(text, "the device file", "device", None)

    @classmethod
    def _from_text(cls, text: str, origin: str, name: str, folder: Path | None) -> Device:
        """``origin`` is what messages call the text, ``name`` the device's if it states none; a film's file lies in
        ``folder``."""
        try:
            values = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{origin}: broken TOML: {error}; correct it there") from None
        try:
            film = values.get("film")
            if folder is not None and isinstance(film, str) and film not in (*FILMS, "continuum"):
                values["film"] = str(folder / film)
            return cls(**{"name": name} | values)
        except FieldError as error:
            raise InputError(
                "\n".join(located(origin, text, one) for one in getattr(error, "errors", [error]))
            ) from None


def _or_zero(value: Any) -> Any:
    return 0.0 if value is None else value


_DOT = "material."
_SECOND_PRESTRETCHES = tuple(f"second_{name}" for name in ("prestretch", *DIRECT_PRESTRETCHES))
_CHOICES: tuple[tuple[str, str, Collection[str]], ...] = (
    ("prestretch_mode", "pre-stretch mode", PRESTRETCH_MODES),
    ("waveform", "waveform", WAVEFORMS),
    ("pull_in", "way to treat pull-in", PULL_IN),
    ("second_film", "second film", FILMS),
    ("second_drive", "drive of a second film", DRIVES),
)
"""Fields of which a few texts are allowed: what it is, and which."""
_BELONGING = (
    ("beam_rate", ("beam_cubic_rate", "beam_height")),
    ("second_film", ("second_flat_height", *_SECOND_PRESTRETCHES, "second_drive", "second_voltage")),
)
"""Fields that mean nothing without another."""
_SIZES = ("m", "kg", "Pa")
"""Units of the fields whose values are compared with what is usual: a drive may be as small as one likes."""
_EXCLUDING = (
    (("prestretch",), DIRECT_PRESTRETCHES),
    (DIRECT_PRESTRETCHES, ("prestretch",)),
    (_SECOND_PRESTRETCHES[:1], _SECOND_PRESTRETCHES[1:]),
    (_SECOND_PRESTRETCHES[1:], _SECOND_PRESTRETCHES[:1]),
    *(((name,), DAMPINGS) for name in DAMPINGS),
)
"""Fields that, when given, drop others."""
DEVICE_FIELDS = Device.all_fields()
"""All fields of a device by name, the material's under dotted names."""
_NOT_MEMBERS = ("material.relative_permittivity_range",)
DRIVE_NUMBERS = ("voltage_amplitude", "voltage_offset", "frequency")
"""Fields that are single numbers of the drive: neither the rest nor the scales depend on them."""
SWEPT_FIELDS = {n: f for n, f in DEVICE_FIELDS.items() if f.unit and n not in _NOT_MEMBERS}
"""Those that may be arrays, and so be swept, mapped and uncertain."""


def _as_material(value: Any) -> Material:
    if isinstance(value, Material):
        return value
    try:
        if isinstance(value, Mapping):
            return Material(**{str(name): v for name, v in value.items()})
        if isinstance(value, str):
            return find_material(value)
    except FieldError as error:
        raise error.within("material") from None
    except InputError as error:
        raise FieldError("material", f"material: {error}") from None
    raise FieldError(
        "material", f"material = {value!r}: must be the name of a library material or a table of its numbers"
    )


def _with_material(values: Mapping[str, Any]) -> dict[str, Any]:
    """The same values with the dotted names applied to the material."""
    rest = {name: value for name, value in values.items() if not name.startswith("material.")}
    dotted = {name.removeprefix("material."): value for name, value in values.items() if name not in rest}
    if not dotted:
        return rest
    if rest.get("material") is None:
        return rest | {"material": _as_material(dotted)}
    try:
        return rest | {"material": _as_material(rest["material"]).replace(**dotted)}
    except FieldError as error:
        raise (error if error.field.startswith("material") else error.within("material")) from None


def find_device(name_or_path: str | Path) -> Device:
    """The device in a TOML file, or the shipped one of that name.

    A file of that name wins over a shipped device. Raises `InputError` that says what ships when there is neither.
    """
    path = Path(name_or_path)
    shipped = shipped_devices()
    permission.check("device", str(name_or_path))
    if str(name_or_path) in shipped and not path.is_file():
        return Device.from_toml(shipped[str(name_or_path)])
    return Device.from_toml(path)
