"""A device in SI units: read from Python or TOML, checked, and turned into a `ConeModel`."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Unpack

from gelcone import permission
from gelcone.devices import checks, cone
from gelcone.devices.fields import CHOICES, EXCLUDING, GEL, DeviceFields
from gelcone.devices.files import located, shipped_devices, what_ships
from gelcone.devices.given import DeviceValues
from gelcone.devices.materials import Material, find_material, side_by_side
from gelcone.devices.parts import PARTS, own_fields, part_record, read_part
from gelcone.devices.record import Field, unknown_field
from gelcone.devices.shown import device_html
from gelcone.devices.template import device_text
from gelcone.devices.units import FieldError
from gelcone.errors import DoubtfulInput, InputError, described, unknown_name
from gelcone.files import read_text, read_toml
from gelcone.physics.model import ConeModel


class Device(DeviceFields):
    """A conical gel actuator in SI units. In place of each number, a string such as ``"50 mm"`` will do.

    Every number may also be a list or one-dimensional array, all of one length: an ensemble, member by member.
    ``gelcone help device`` lists the fields with their units, and ``gelcone init mine.toml`` writes a file of them.

    Parameters
    ----------
    name : what it is called. Default "unnamed device"; a file's name when read from a file.
    disc_radius : radius a of the rigid disc, m, positive and less than ``film_radius``.
    film_radius : radius b at which the film is clamped, m.
    film_thickness : thickness H of the film as mounted (flat, after pre-stretch), m, positive.
    material : name of a library material, a `Material`, or a mapping of its fields; several make an ensemble.
    prestretch, prestretch_mode, meridional_prestretch, hoop_prestretch : as in `ConeModel`.
    pull_in : where a wrinkling film pulls in: ``"first"`` (default) ends the run; for study ``"minimum"``,
        ``"memoryless"`` and ``"snap"``, see `gelcone.physics.film.wrinkling.WrinklingCone`.
    film : ``"membrane"`` (default), the membrane that wrinkles; for study ``"wrinkling"``, a homogeneous cone without
        compression, or ``"taut"``, one that bears it; or a user-defined one.
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
    waveform : ``"sine"`` (default), or another of `gelcone.physics.waveforms.WAVEFORMS`, by its name or as a table with
        its data and numbers; these are fields such as ``waveform.duty``.
    filter_frequency : of the amplifier's low-pass filter, Hz; ``slew_rate``, V/s, its fastest change behind it. Default
        none: the amplifier gives what is commanded.
    series_resistance : of amplifier, leads and electrodes, ohm; ``current_limit``, A, of the amplifier behind it.
    reduced : what is too fast to have states of its own, as in `ConeModel`: ``"series_resistance"``, a branch's
        ``"relaxation_time_1"``, or several joined by "+"; of a taut film, whose stresses lack such a branch's. Default
        none.
    circuit : ``"charge"`` where the drive commands the charge, or a user-defined one. Default none.
    release_height : the disc is held there and let go at t = 0, m. Default: it starts from rest, see `initial_state`.
    release_velocity : its velocity at t = 0, m/s. Default 0.
    bias : a user-defined `Bias`, as ``"module:Class"`` or a table, besides spring, beam, weight, force. Default none.
    second_film : ``"membrane"``, ``"wrinkling"`` or ``"taut"``, on the other side of the disc: a double cone. Of the
        first film's material, thickness and ``prestretch_mode``. Default none.
    second_flat_height : height of the disc at which the second film is flat, m. Default 0.
    second_prestretch, second_meridional_prestretch, second_hoop_prestretch : default the first film's.
    second_drive : ``"same"`` (default), ``"opposite"`` or ``"constant"``, as in `ConeModel`; ``second_voltage``, V, is
        the constant one.

    A field of the material is reached by a dotted name, such as ``"material.shear_modulus"``.

    Raises
    ------
    InputError : a line each, for values that are missing, unknown, not exact or out of bounds.

    Examples
    --------
    >>> import gelcone
    >>> gel = gelcone.Material(shear_modulus="8 kPa", relative_permittivity=5)
    >>> device = gelcone.Device(
    ...     disc_radius="8 mm", film_radius="30 mm", film_thickness="0.2 mm", hoop_prestretch=1.4, material=gel,
    ...     film="taut", spring_rate="15 N/m", initial_height="20 mm", moving_mass="5 g", damping_ratio=0.03,
    ...     voltage_amplitude="0.6 kV", voltage_offset="0.7 kV", frequency="10 Hz",
    ... )
    >>> device.film_thickness, device.replace(frequency=["9 Hz", "11 Hz"]).shape
    (0.0002, (2,))
    >>> f"rests at {1e3 * device.initial_state()[0] * device.scales.length:.2f} mm"
    'rests at 13.94 mm'
    """

    def __init__(self, /, **values: Unpack[DeviceValues]) -> None:
        super().__init__(**self._with_parts(_with_material(values)))
        for doubt in checks.doubts(self):
            warnings.warn(doubt, DoubtfulInput, stacklevel=2)

    def _with_parts(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Read the components among the values, with their numbers under dotted names, and add their fields."""
        parts: dict[str, Any] = {}
        numbers: dict[str, Any] = {}
        brought: dict[str, Field] = {}
        for name in PARTS:
            given = values.get(name)
            if given is None:
                continue
            parts[name], part_numbers = read_part(name, given)
            numbers |= {f"{name}.{key}": value for key, value in part_numbers.items()}
            brought |= {f"{name}.{key}": field for key, field in own_fields(name, parts[name]).items()}
        self.__dict__["fields"] = {**type(self).fields, **brought}
        return numbers | dict(values) | parts

    def fields_with(self, changes: Mapping[str, Any]) -> Mapping[str, Field]:
        """All fields of the device after `replace` of the components and the law among ``changes``.

        Raises `InputError` for a component that cannot be used.
        """
        other = Device.__new__(Device)
        parts = {name: changes.get(name, getattr(self, name)) for name in PARTS}
        other._with_parts(parts)
        law = changes.get(f"{GEL}law")
        other.__dict__["material"] = self.material if law is None else self.material.replace(law=law)
        return other.all_fields()

    # --- checks ---------------------------------------------------------------------------------------------------

    def unknown(self, name: str) -> FieldError:
        return unknown_field("device", name, self.all_fields())

    def read(self, name: str, value: Any) -> Any:
        if name == "material":
            return _as_material(value)
        if name in PARTS:
            return value
        value = super().read(name, value)
        for field_name, kind, choices in CHOICES:
            if name == field_name and value not in choices:
                raise FieldError(name, f"{name}: {unknown_name(kind, value, choices)}")
        return value

    def plain(self, name: str, value: Any) -> Any:
        return part_record(name, value) if name in PARTS else super().plain(name, value)

    def misfits(self) -> Iterator[FieldError]:
        yield from checks.misfits(self)

    # --- to the model ---------------------------------------------------------------------------------------------

    def to_model(self) -> ConeModel:
        """Make the dimensionless model; arrays make an ensemble of their length."""
        return cone.model_of_device(self)

    def initial_state(self) -> Any:
        """Displacement and velocity at t = 0, dimensionless: two numbers, or an array (members, 2) where they differ.

        The displacement is the release height or, without one, the stable equilibrium of film and spring without
        voltage nearest to the initial height. Raises `InputError` if there is none.
        """
        return cone.initial_state(self)

    def breakdown_field(self) -> Any:
        """Dielectric strength over the scale of the field; None if it is unknown."""
        return cone.breakdown_field(self)

    def _repr_html_(self) -> str:
        """The HTML of the device in a notebook."""
        return device_html(self)

    # --- variants and files ---------------------------------------------------------------------------------------

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Unpack[DeviceValues]) -> Device:
        """A copy with some fields changed; None takes a field's default.

        ``changes`` serves dotted names: ``device.replace({"material.shear_modulus": "20 kPa"}, frequency=8.0)``.
        Giving ``prestretch`` drops the two direct pre-stretches, and the reverse; one form of damping drops the others;
        a component that changes starts from its own defaults. Raises `InputError` as the constructor does.
        """
        changed = {**(changes or {}), **more}
        values = {name: value for name, value in self if value is not None}
        for excluding, others in EXCLUDING:
            if any(changed.get(name) is not None for name in excluding):
                values = {name: value for name, value in values.items() if name not in others}
        for part in PARTS:
            if part in changed:
                values = {name: value for name, value in values.items() if not name.startswith(f"{part}.")}
        return Device(**values | changed)

    def replace_quietly(self, changes: Mapping[str, Any] | None = None, /, **more: Unpack[DeviceValues]) -> Device:
        """Make a copy as `replace` does, without warnings: for points of a sweep, whose device was checked before."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DoubtfulInput)
            return self.replace(changes, **more)

    def redriven(self, changes: Mapping[str, Any]) -> Device:
        """Make a copy with other numbers among `DRIVE_NUMBERS`, in a quarter of the time of `replace_quietly`: no check
        of another field depends on them. `FieldError` as there."""
        driven = Device.__new__(Device)
        driven.__dict__.update(self.__dict__, **{name: self.read(name, value) for name, value in changes.items()})
        return driven

    def to_toml(self) -> str:
        """The device as the text of a device file, which `from_toml` reads back as an equal device."""
        return device_text(self, self.material)

    @classmethod
    def from_toml(cls, path: str | Path) -> Device:
        """Read a device from a TOML file whose keys are the fields, the material's in a table ``[material]``.

        Raises `InputError` with the file, and the line where it is known, for a file that cannot be read or used.
        """
        path = Path(path)
        return cls._from_text(read_text(path, what_ships(path.name)), str(path), path.stem)

    @classmethod
    def from_text(cls, text: str) -> Device:
        """Read a device from the text of a device file; `InputError` as from `from_toml`."""
        return cls._from_text(text, "the device file", "device")

    @classmethod
    def _from_text(cls, text: str, origin: str, name: str) -> Device:
        """Read a device from a text; ``origin`` names the text in messages, and ``name`` is the default name."""
        values = read_toml(origin, text)
        try:
            return cls(**{"name": name} | values)
        except FieldError as error:
            raise InputError(
                "\n".join(located(origin, text, one) for one in getattr(error, "errors", [error]))
            ) from None


def _as_material(value: Any) -> Material:
    if isinstance(value, Material):
        return value
    if isinstance(value, list | tuple):
        return side_by_side([_as_material(one) for one in value])
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
    """The values with dotted names applied to the material."""
    rest = {name: value for name, value in values.items() if not name.startswith(GEL)}
    dotted = {name.removeprefix(GEL): value for name, value in values.items() if name not in rest}
    if not dotted:
        return rest
    if rest.get("material") is None:
        return rest | {"material": _as_material(dotted)}
    try:
        return rest | {"material": _as_material(rest["material"]).replace(**dotted)}
    except FieldError as error:
        raise (error if error.field.startswith("material") else error.within("material")) from None


def find_device(name_or_path: str | Path) -> Device:
    """Read the device in a TOML file, or the shipped device of a name.

    Parameters
    ----------
    name_or_path : a device file, or a name of ``gelcone devices``. A file of that name wins over a shipped device.

    Returns
    -------
    The `Device`; `Device.replace` gives one that differs.

    Raises
    ------
    InputError : where there is neither, with the names that ship; and a line for each value that cannot be used.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump")
    >>> device.name, device.film_radius
    ('biased pumping cone', 0.03)
    """
    if not isinstance(name_or_path, str | Path):
        raise InputError(f"find_device: was given {described(name_or_path)}; give a name or a TOML file")
    path = Path(name_or_path)
    shipped = shipped_devices()
    permission.check("device", str(name_or_path))
    if str(name_or_path) in shipped and not path.is_file():
        return Device.from_toml(shipped[str(name_or_path)])
    return Device.from_toml(path)
