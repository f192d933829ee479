"""A device in SI units: read from Python or TOML, turned into a `ConeModel`, and the scales that lead back.

With the film's volume Vol = pi (b^2 - a^2) H, shear modulus mu and permittivity eps, the units of the dimensionless
model are the length b - a, the time 1/Omega0 = sqrt(m (b-a)^2 / (mu Vol)), the energy mu Vol and the field
sqrt(mu/eps).
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from gelcone.devices.materials import Material, Record, find_material, si, text
from gelcone.devices.units import FieldError, format_si
from gelcone.errors import InputError, unknown_name
from gelcone.physics.balance import rest_displacement
from gelcone.physics.film.continuum import ContinuumFilm
from gelcone.physics.film.taut import PRESTRETCH_MODES
from gelcone.physics.model import ConeModel

# What a user of the dimensionless model may type for a device, and the device's name for it.
_DIMENSIONLESS = {
    "damping_ratio": "damping_coefficient",
    "spring_stiffness": "spring_rate",
    "voltage": "voltage_amplitude",
    "voltage_bias": "voltage_offset",
    "drive_frequency": "frequency",
    "rest_height": "initial_height",
    "stretch_limit": "material.stretch_limit",
    "yeoh_c2": "material.yeoh_c2",
    "yeoh_c3": "material.yeoh_c3",
    "law": "material.law",
}


@dataclass(frozen=True)
class Scales:
    """The SI value of one dimensionless unit: ``x_in_metres = x * scales.length``.

    Attributes
    ----------
    length : b - a, m.
    time : 1/Omega0, s.
    velocity : (b-a) Omega0, m/s.
    force : mu Vol/(b-a), N.
    energy : mu Vol, J.
    power : mu Vol Omega0, W.
    voltage : H sqrt(mu/eps), V.
    current : power/voltage, A.
    field : sqrt(mu/eps), V/m.
    stress : mu, Pa.
    frequency : Omega0/(2 pi), Hz: the ordinary frequency of one unit of the angular omega.
    """

    length: float
    time: float
    velocity: float
    force: float
    energy: float
    power: float
    voltage: float
    current: float
    field: float
    stress: float
    frequency: float


class Device(Record):
    """A conical gel actuator in SI units. In place of each number, a string such as ``"50 mm"`` will do.

    ``voltage_amplitude``, ``voltage_offset`` and ``frequency`` may also be lists or one-dimensional arrays of one
    length: they make an ensemble, member by member. All else is one number.

    Parameters
    ----------
    name : what it is called. Default "unnamed device"; a file's name when read from a file.
    disc_radius : radius a of the rigid disc, m, positive and less than ``film_radius``.
    film_radius : radius b at which the film is clamped, m.
    film_thickness : thickness H of the film as mounted (flat, after pre-stretch), m, positive.
    initial_height : height h0 of the disc at which the spring is free, m. Default 0.
    spring_rate : stiffness k of the spring, N/m, at least 0.
    moving_mass : mass m of the disc and what moves with it, kg, positive.
    damping_coefficient : viscous damping c, N s/m, at least 0.
    material : name of a library material, a `Material`, or a mapping of its fields.
    dielectric_strength : true field that the film stands, V/m, positive. Default: the material's (None = unknown).
    voltage_amplitude : amplitude of the drive offset + amplitude sin(2 pi f t), V, at least 0.
    voltage_offset : its constant part, V. Default 0.
    frequency : f, Hz, positive.
    prestretch, prestretch_mode, meridional_prestretch, hoop_prestretch : as in `ConeModel`.
    film : ``"taut"`` (default), the homogeneous cone; ``"continuum"``, the continuum film, fitted on first use and kept
        (see `gelcone.continuum.fit.find_film`); or a file that ``gelcone validate --fit`` wrote, in a device file
        relative to it.
    release_height : the disc is held there and let go at t = 0, m. Default: it starts from rest, see `initial_state`.
    release_velocity : its velocity at t = 0, m/s. Default 0.

    A field of the material is reached by a dotted name, such as ``"material.shear_modulus"``.

    Raises
    ------
    InputError : one line, for values that are missing, unknown, not exact or out of bounds.
    """

    kind: ClassVar[str] = "device"

    name: Annotated[str, BeforeValidator(text)] = "unnamed device"
    disc_radius: Annotated[float, si("m", above=0.0)] = Field(description="radius of the rigid disc in m")
    film_radius: Annotated[float, si("m", above=0.0)] = Field(description="radius at which the film is clamped in m")
    film_thickness: Annotated[float, si("m", above=0.0)] = Field(description="thickness of the film as mounted in m")
    initial_height: Annotated[float, si("m")] = 0.0
    spring_rate: Annotated[float, si("N/m", least=0.0)] = Field(description="stiffness of the spring in N/m")
    moving_mass: Annotated[float, si("kg", above=0.0)] = Field(description="mass that moves in kg")
    damping_coefficient: Annotated[float, si("N s/m", least=0.0)] = Field(description="viscous damping in N s/m")
    material: Material = Field(description="name of a library material or a table of its numbers")
    dielectric_strength: Annotated[float | None, si("V/m", above=0.0)] = None
    voltage_amplitude: Annotated[Any, si("V", many=True, least=0.0)] = Field(description="amplitude of the drive in V")
    voltage_offset: Annotated[Any, si("V", many=True)] = 0.0
    frequency: Annotated[Any, si("Hz", many=True, above=0.0)] = Field(description="frequency of the drive in Hz")
    prestretch: Annotated[float | None, si("1", above=0.0)] = None
    prestretch_mode: str = "radial"
    meridional_prestretch: Annotated[float | None, si("1", above=0.0)] = None
    hoop_prestretch: Annotated[float | None, si("1", above=0.0)] = None
    film: Annotated[str, BeforeValidator(text)] = "taut"
    release_height: Annotated[float | None, si("m")] = None
    release_velocity: Annotated[float, si("m/s")] = 0.0

    def __init__(self, /, **values: Any) -> None:
        super().__init__(**_with_material(values))

    # --- checks ---------------------------------------------------------------------------------------------------

    @classmethod
    def field_names(cls) -> list[str]:
        return [*super().field_names(), *(f"material.{name}" for name in Material.field_names())]

    @classmethod
    def unknown(cls, name: str) -> FieldError:
        if name in _DIMENSIONLESS:
            own = _DIMENSIONLESS[name]
            return FieldError(name, f"{name!r} belongs to the dimensionless model; a device takes {own!r}")
        names = [known for known in cls.field_names() if ("." in known) == ("." in name)]
        return FieldError(name, str(unknown_name("device field", name, names)))

    @field_validator("material", mode="before")
    @classmethod
    def _material(cls, value: Any) -> Material:
        return _as_material(value)

    @field_validator("prestretch_mode", mode="before")
    @classmethod
    def _mode(cls, value: Any, info: ValidationInfo) -> str:
        if text(value, info) not in PRESTRETCH_MODES:
            error = unknown_name("pre-stretch mode", value, PRESTRETCH_MODES)
            raise FieldError("prestretch_mode", f"prestretch_mode: {error}")
        return str(value)

    @model_validator(mode="after")
    def _parts_fit(self) -> Device:
        if self.disc_radius >= self.film_radius:
            raise FieldError(
                "disc_radius",
                f"disc_radius = {format_si(self.disc_radius, 'm')}: must be less than film_radius = "
                f"{format_si(self.film_radius, 'm')}; make the disc smaller or the film larger",
            )
        lengths = {n: np.size(v) for n, v in self if isinstance(v, np.ndarray) and v.size > 1}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            raise FieldError(next(iter(lengths)), f"{told} values; give lists of one length")
        self._check_scales()
        with np.errstate(all="ignore"):
            self._check_heights(self.cone_model())
        return self

    def _check_scales(self) -> None:
        try:
            usable = all(math.isfinite(scale) and scale > 0.0 for scale in astuple(self.scales))
        except (OverflowError, ZeroDivisionError):
            usable = False
        if not usable:
            raise FieldError(
                "film_thickness", "the sizes, mass and shear modulus give no finite time and energy; check their units"
            )

    def _check_heights(self, model: ConeModel) -> None:
        single = model.members().take([0])
        if not single.strain([0.0])[0] < single.strain_limit()[0]:
            raise FieldError(
                "prestretch",
                f"prestretch: mounted flat, the film has I1 - 3 = {float(single.strain([0.0])[0]):.4g}, which must be "
                f"less than its stretch limit {float(single.strain_limit()[0]):.4g}; lower the pre-stretch or raise "
                "the limit",
            )
        highest = model.system.film.reach(single.numbers_at(0))[1]
        if self.release_height is not None and abs(self.release_height) >= highest * self.scales.length:
            raise FieldError(
                "release_height",
                f"release_height = {format_si(self.release_height, 'm')}: must be less than "
                f"{format_si(highest * self.scales.length, 'm')}, where the film reaches its stretch limit "
                f"{float(single.strain_limit()[0]):.4g}; start lower or raise material.stretch_limit",
            )

    # --- to the model and back ---------------------------------------------------------------------------------------

    @property
    def scales(self) -> Scales:
        """The SI value of each dimensionless unit."""
        length = self.film_radius - self.disc_radius
        volume = math.pi * (self.film_radius**2 - self.disc_radius**2) * self.film_thickness
        energy = self.material.shear_modulus * volume
        rate = math.sqrt(energy / self.moving_mass) / length
        field = math.sqrt(self.material.shear_modulus / self.material.permittivity)
        return Scales(
            length=length,
            time=1.0 / rate,
            velocity=length * rate,
            force=energy / length,
            energy=energy,
            power=energy * rate,
            voltage=self.film_thickness * field,
            current=energy * rate / (self.film_thickness * field),
            field=field,
            stress=self.material.shear_modulus,
            frequency=rate / (2.0 * math.pi),
        )

    def to_model(self) -> ConeModel:
        """The dimensionless model with its ``film``; drive arrays make an ensemble of their length."""
        model = self.cone_model()
        film = self.film_for(model)
        return model if film is None else model.replace(film=film)

    def film_for(self, model: ConeModel, *, starting: Callable[[], None] = lambda: None) -> ContinuumFilm | None:
        """The film that ``film`` names, None for the cone; ``starting`` is called before one is fitted."""
        if self.film == "taut":
            return None
        from gelcone.continuum.fit import find_film

        return find_film(self.film, model, self.disc_radius / self.film_radius, starting=starting)

    def cone_model(self) -> ConeModel:
        """`to_model` with the film as a homogeneous cone."""
        s = self.scales
        parameters = {
            "damping_ratio": self.damping_coefficient * s.time / (2.0 * self.moving_mass),
            "spring_stiffness": self.spring_rate * s.length / s.force,
            "voltage": self.voltage_amplitude / s.voltage,
            "voltage_bias": self.voltage_offset / s.voltage,
            "drive_frequency": self.frequency / s.frequency,
            "rest_height": self.initial_height / s.length,
            "prestretch": self.prestretch,
            "prestretch_mode": self.prestretch_mode,
            "meridional_prestretch": self.meridional_prestretch,
            "hoop_prestretch": self.hoop_prestretch,
            "law": self.material.law,
            **self.material.law_parameters,
        }
        return ConeModel.from_parameters(parameters)

    def initial_state(self) -> tuple[float, float]:
        """Displacement and velocity at t = 0, dimensionless.

        The displacement is the release height or, without one, the stable rest equilibrium of the film and spring
        without voltage that is nearest the initial height. Raises `InputError` when there is none.
        """
        s = self.scales
        velocity = self.release_velocity / s.velocity
        if self.release_height is not None:
            return self.release_height / s.length, velocity
        x = rest_displacement(self.to_model().take([0]))
        if math.isnan(x):
            raise FieldError(
                "initial_height",
                "initial_height: no stable rest position was found without voltage; give a release_height",
            )
        return x, velocity

    def breakdown_field(self) -> float | None:
        """Dielectric strength over the scale of the field, or None when it is unknown."""
        strength = self.dielectric_strength or self.material.dielectric_strength
        return None if strength is None else strength / self.scales.field

    # --- variants and files ------------------------------------------------------------------------------------------

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Device:
        """A copy with some fields changed; None takes a field's default.

        ``changes`` serves dotted names: ``device.replace({"material.shear_modulus": "20 kPa"}, frequency=8.0)``.
        Giving ``prestretch`` drops the two direct pre-stretches, and the reverse. Raises `InputError` as the
        constructor does.
        """
        changed = {**(changes or {}), **more}
        values = {name: value for name, value in self if value is not None}
        direct = ("meridional_prestretch", "hoop_prestretch")
        if any(changed.get(name) is not None for name in direct):
            values.pop("prestretch", None)
        elif changed.get("prestretch") is not None:
            values = {name: value for name, value in values.items() if name not in direct}
        return Device(**values | changed)

    @classmethod
    def from_toml(cls, path: str | Path) -> Device:
        """A device from a TOML file whose keys are the fields, the material's in a table ``[material]``.

        Raises `InputError` with the file, and the line where it can be told, for a file that cannot be read or used.
        """
        path = Path(path)
        source = _read_text(path)
        try:
            values = tomllib.loads(source)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}: broken TOML: {error}; correct it there") from None
        try:
            film = values.get("film")
            if isinstance(film, str) and film not in ("taut", "continuum"):
                values["film"] = str(path.parent / film)
            return cls(**{"name": path.stem} | values)
        except FieldError as error:
            line = _line_of(error.field, source)
            raise InputError(f"{path}{f', line {line}' if line else ''}: {error}") from None


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


def _read_text(path: Path) -> str:
    told = str(path) if str(path).isprintable() else repr(str(path))
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{told}: there is no such file; {_what_ships()}") from None
    except IsADirectoryError:
        raise InputError(f"{told}: is a folder; give a TOML file or a name; {_what_ships()}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{told}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{told}: cannot be read ({reason}); give a TOML file that can") from None


def _line_of(field: str, source: str) -> int | None:
    """Line on which a field is set, by its last name."""
    leaf = re.split(r"\W", field.removeprefix("material."))[0]
    for number, line in enumerate(source.splitlines(), start=1):
        if re.search(rf"(?:^|[\s\[{{,.\"']){re.escape(leaf)}[\"']?\s*[=\]]", line.split("#")[0]):
            return number
    return None


# --- the devices that ship -------------------------------------------------------------------------------------------


def shipped_devices() -> dict[str, Path]:
    """Name -> TOML file of the worked devices that come with gelcone."""
    here = Path(__file__).resolve().parent
    # an installed wheel holds them beside this file, a checkout among its examples
    for folder in (here / "shipped", here.parents[2] / "examples" / "devices"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def _what_ships() -> str:
    return f"devices that ship: {', '.join(shipped_devices()) or 'none'}"


def find_device(name_or_path: str | Path) -> Device:
    """The device in a TOML file, or the shipped one of that name.

    A file of that name wins over a shipped device. Raises `InputError` that says what ships when there is neither.
    """
    path = Path(name_or_path)
    shipped = shipped_devices()
    if str(name_or_path) in shipped and not path.is_file():
        return Device.from_toml(shipped[str(name_or_path)])
    return Device.from_toml(path)
