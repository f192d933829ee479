"""The fields of a device: meaning, unit, bounds and usual range of each, and which require or exclude each other."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from gelcone.devices.materials import Material
from gelcone.devices.record import Field, Record
from gelcone.devices.scales import Scales
from gelcone.physics.film.gel import PRESTRETCH_MODES
from gelcone.physics.film.wrinkling import PULL_IN
from gelcone.physics.placed import DRIVES
from gelcone.physics.records import FILMS

DAMPINGS = ("damping_coefficient", "damping_ratio", "quality_factor")
"""Three ways to give the damping; a device takes one of them."""
DIRECT_PRESTRETCHES = ("meridional_prestretch", "hoop_prestretch")
DRIVE_NUMBERS = ("voltage_amplitude", "voltage_offset", "frequency")
"""Fields that are single numbers of the drive: neither the rest nor the scales depend on them."""
GEL = "material."
"""Prefix of the names of the material's fields."""
ELECTRIC = (
    "filter_frequency",
    "slew_rate",
    "series_resistance",
    "current_limit",
    f"{GEL}resistivity",
    f"{GEL}dielectric_share",
)
"""Fields of the amplifier that ships, and of a gel that leaks or polarizes with a delay."""
SECOND_PRESTRETCHES = tuple(f"second_{name}" for name in ("prestretch", *DIRECT_PRESTRETCHES))
CHOICES: tuple[tuple[str, str, Collection[str]], ...] = (
    ("prestretch_mode", "pre-stretch mode", PRESTRETCH_MODES),
    ("pull_in", "way to treat pull-in", PULL_IN),
    ("second_film", "second film", FILMS),
    ("second_drive", "drive of a second film", DRIVES),
)
"""Fields with a few allowed texts: name, meaning for messages, and the texts."""
BELONGING = (
    ("beam_rate", ("beam_cubic_rate", "beam_height")),
    ("series_resistance", ("current_limit",)),
    ("filter_frequency", ("slew_rate",)),
    ("second_film", ("second_flat_height", *SECOND_PRESTRETCHES, "second_drive", "second_voltage")),
)
"""Fields, and the fields that need them."""
EXCLUDING = (
    (("prestretch",), DIRECT_PRESTRETCHES),
    (DIRECT_PRESTRETCHES, ("prestretch",)),
    (SECOND_PRESTRETCHES[:1], SECOND_PRESTRETCHES[1:]),
    (SECOND_PRESTRETCHES[1:], SECOND_PRESTRETCHES[:1]),
    *(((name,), DAMPINGS) for name in DAMPINGS),
)
"""Fields, and the fields that they replace when they are given."""
_NOT_MEMBERS = (GEL + "relative_permittivity_range", GEL + "shear_modulus_range")


class DeviceFields(Record):
    """The fields of a conical gel actuator, see `gelcone.devices.device.Device`."""

    kind: ClassVar[str] = "device"

    # A field is one entry here, and one in `gelcone.devices.numbers` where it is a parameter of the model.
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
        near=("thickness", "membrane_thickness", "height_film", "t", "h"), example=2e-4,
    )  # fmt: skip
    material: Any = Field(
        "name of a gel that ships (`gelcone materials`), or a table [material] of its numbers",
        near=("gel", "film_material", "material_name"),
    )
    prestretch: Any = Field(
        "pre-stretch of the mounted film, along the hoop (radial mode) or in both directions (equibiaxial); in place "
        "of meridional_prestretch and hoop_prestretch", "1", default=None,
        unset="1 (none)", typical=(0.5, 4.0), near=("pre_stretch", "stretch", "lambda_p"),
        above=0.0, example=1.2,
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
        "membrane; for study wrinkling or taut (homogeneous cones); or a user-defined one as module:Class",
        default="membrane",
        near=("film_model",),
    )  # fmt: skip
    pull_in: Any = Field(
        "where a wrinkling film pulls in, a run ends (first); for study: minimum, memoryless or snap", default=None,
        unset="first", near=("after_pull_in", "on_pull_in"), example="first",
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
        example=-20.0,
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
        example=9.81,
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
        unset="or give damping_coefficient or quality_factor", typical=(1e-3, 1.0), near=("damping", "zeta"),
        least=0.0, example=0.02,
    )  # fmt: skip
    quality_factor: Any = Field(
        "quality factor of the free vibration about the rest without voltage", "1", default=None,
        unset="or give damping_coefficient or damping_ratio", typical=(0.5, 500.0), near=("damping", "q", "q_factor"),
        above=0.0, example=20.0,
    )  # fmt: skip
    dielectric_strength: Any = Field(
        "true electric field that the film stands", "V/m", default=None, unset="the material's, or unknown",
        typical=(1e6, 2e8), near=("breakdown", "breakdown_field", "breakdown_strength", "field_limit"), above=0.0,
        example=2e7,
    )  # fmt: skip
    voltage_amplitude: Any = Field(
        "amplitude of the drive: voltage = offset + amplitude sin(2 pi frequency t)", "V", typical=(50.0, 2e4),
        least=0.0, near=("voltage", "amplitude", "drive_voltage", "v", "u", "ac_voltage"),
    )  # fmt: skip
    voltage_offset: Any = Field(
        "constant part of the drive", "V", default=0.0, typical=(50.0, 2e4),
        near=("voltage_bias", "offset", "bias_voltage", "dc_voltage", "voltage_dc"),
    )  # fmt: skip
    frequency: Any = Field(
        "frequency of the drive", "Hz", typical=(0.1, 1000.0), above=0.0,
        near=("drive_frequency", "omega", "f", "driving_frequency", "voltage_frequency"),
    )  # fmt: skip
    waveform: Any = Field(
        "shape of the drive: sine, triangle, square, trapezoid, ramp, half_wave, burst, chirp, harmonics, staircase or "
        "samples, by its name or as a table with its numbers; or a user-defined one as module:Class", default="sine",
        near=("shape", "drive"),
    )  # fmt: skip
    filter_frequency: Any = Field(
        "frequency above which the amplifier no longer follows (-3 dB)", "Hz", default=None, unset="none: it follows",
        typical=(10.0, 1e5), above=0.0,
        near=("bandwidth", "cutoff", "cutoff_frequency", "corner_frequency", "amplifier"),
    )  # fmt: skip
    slew_rate: Any = Field(
        "fastest change of the amplifier's voltage", "V/s", default=None, unset="no limit", typical=(1e4, 7e8),
        above=0.0, near=("slew", "rise_rate"),
    )  # fmt: skip
    series_resistance: Any = Field(
        "resistance of amplifier, leads and electrodes before the film", "ohm", default=None, unset="0",
        typical=(1e3, 1e8), least=0.0, example=1e6,
        near=("resistance", "resistor", "source_resistance", "electrode_resistance", "r"),
    )  # fmt: skip
    current_limit: Any = Field(
        "largest current of the amplifier", "A", default=None, unset="no limit", typical=(1e-4, 0.04), above=0.0,
        near=("current", "maximum_current", "compliance"),
    )  # fmt: skip
    reduced: Any = Field(
        "what is too fast to have states of its own, of a taut film: series_resistance, relaxation_time_1 (its "
        "stresses are left out), or several joined by +", default=None, unset="none", near=("stiff", "quick"),
        example="series_resistance",
    )  # fmt: skip
    circuit: Any = Field(
        "charge: the drive commands the charge, by the voltage that it gives the flat film; or a user-defined circuit, "
        "as module:Class", default=None, unset="none", near=("source",), example="charge",
    )  # fmt: skip
    bias: Any = Field(
        "user-defined bias, as module:Class, that acts besides spring, beam, weight and force", default=None,
        unset="none", near=("own_bias", "magnet"), example="module:Class",
    )  # fmt: skip
    release_height: Any = Field(
        "height at which the disc is held and let go at t = 0", "m", default=None,
        unset="its rest without voltage", typical=(1e-4, 0.1),
        near=("displacement", "initial_displacement", "start_height", "x0"), example=0.005,
    )  # fmt: skip
    release_velocity: Any = Field(
        "velocity of the disc at t = 0", "m/s", default=0.0, typical=(1e-3, 10.0),
        near=("velocity", "initial_velocity", "start_velocity"),
    )  # fmt: skip

    second_film: Any = Field(
        "film on the other side of the disc, for a double cone: membrane, wrinkling or taut", default=None,
        unset="none: a single cone", near=("antagonist", "other_film", "double_cone"), example="membrane",
    )  # fmt: skip
    second_flat_height: Any = Field(
        "height of the disc at which the second film is flat", "m", default=None, unset="0", typical=(1e-3, 0.1),
        near=("separation", "rod_length", "spacer_height"),
    )  # fmt: skip
    second_prestretch: Any = Field(
        "pre-stretch of the second film, as prestretch", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0, example=1.2,
    )  # fmt: skip
    second_meridional_prestretch: Any = Field(
        "pre-stretch of the second film from rim to disc", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0, example=1.2,
    )  # fmt: skip
    second_hoop_prestretch: Any = Field(
        "pre-stretch of the second film along the hoop", "1", default=None, unset="the first film's",
        typical=(0.5, 4.0), above=0.0, example=1.2,
    )  # fmt: skip
    second_drive: Any = Field(
        "voltage of the second film: same, opposite (offset - amplitude sin) or constant", default=None, unset="same",
        near=("second_phase", "antagonist_drive"), example="opposite",
    )  # fmt: skip
    second_voltage: Any = Field(
        "constant voltage of the second film, where second_drive is constant", "V", default=None, unset="0",
        typical=(50.0, 2e4), near=("second_voltage_offset", "antagonist_voltage"),
    )  # fmt: skip

    def all_fields(self) -> dict[str, Field]:
        """All fields: the device's, the material's under dotted names, and those of user-defined components."""
        gel = self.__dict__.get("material") or Material
        return {**self.fields, **{GEL + name: field for name, field in gel.fields.items()}}

    def swept_fields(self) -> dict[str, Field]:
        """The fields that may be arrays, and therefore be swept, mapped and uncertain."""
        return {n: f for n, f in self.all_fields().items() if f.unit and n not in _NOT_MEMBERS}

    def get(self, name: str) -> Any:
        """The value of a field, the material's under dotted names."""
        return getattr(self.material, name.removeprefix(GEL)) if name.startswith(GEL) else getattr(self, name)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape (members,) of an ensemble; () for a single device."""
        return next((v.shape for n in self.swept_fields() if isinstance(v := self.get(n), np.ndarray)), ())

    @cached_property
    def scales(self) -> Scales:
        """The SI value of each dimensionless unit."""
        return Scales.of(self.get)


DEVICE_FIELDS = {**DeviceFields.fields, **{GEL + name: field for name, field in Material.fields.items()}}
"""The fields of every device by name, the material's under dotted names."""
SWEPT_FIELDS = {n: f for n, f in DEVICE_FIELDS.items() if f.unit and n not in _NOT_MEMBERS}
"""The fields of every device that may be arrays."""
