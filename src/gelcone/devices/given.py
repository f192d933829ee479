"""The keyword arguments of devices and materials, for type checkers: they refuse a name that is not a field.

A field of `gelcone.devices.fields` or `gelcone.devices.materials` has a line here; a test compares them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, SupportsFloat, TypedDict

import numpy.typing as npt

Number = SupportsFloat | str | Sequence[SupportsFloat | str] | npt.NDArray[Any] | None
"""A number in SI, a text with a unit, or several of them."""
Text = str | None


class DeviceValues(TypedDict, total=False):
    """The fields of a device; components, the material and the film take several kinds of values."""

    name: Text
    disc_radius: Number
    film_radius: Number
    film_thickness: Number
    material: Any
    prestretch: Number
    prestretch_mode: Text
    meridional_prestretch: Number
    hoop_prestretch: Number
    film: Any
    pull_in: Text
    spring_rate: Number
    initial_height: Number
    beam_rate: Number
    beam_cubic_rate: Number
    beam_height: Number
    constant_force: Number
    gravity: Number
    payload: Number
    moving_mass: Number
    damping_coefficient: Number
    damping_ratio: Number
    quality_factor: Number
    dielectric_strength: Number
    voltage_amplitude: Number
    voltage_offset: Number
    frequency: Number
    waveform: Any
    filter_frequency: Number
    slew_rate: Number
    series_resistance: Number
    current_limit: Number
    reduced: Text
    circuit: Any
    bias: Any
    release_height: Number
    release_velocity: Number
    second_film: Text
    second_flat_height: Number
    second_prestretch: Number
    second_meridional_prestretch: Number
    second_hoop_prestretch: Number
    second_drive: Text
    second_voltage: Number


class MaterialValues(TypedDict, total=False):
    """The fields of a material with a law that ships."""

    name: Text
    shear_modulus: Number
    young_modulus: Number
    shear_modulus_range: Number
    relative_permittivity: Number
    relative_permittivity_range: Number
    law: Any
    stretch_limit: Number
    yeoh_c2: Number
    yeoh_c3: Number
    dielectric_strength: Number
    viscous_modulus_1: Number
    relaxation_time_1: Number
    viscous_stretch_limit_1: Number
    viscous_modulus_2: Number
    relaxation_time_2: Number
    viscous_stretch_limit_2: Number
    viscous_modulus_3: Number
    relaxation_time_3: Number
    viscous_stretch_limit_3: Number
    flow: Text
    resistivity: Number
    resistivity_field: Number
    dielectric_share: Number
    dielectric_time: Number
    heat_capacity: Number
    sources: Any
