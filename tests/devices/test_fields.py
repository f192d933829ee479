"""The fields of a device: units and bounds, which belong to others and which exclude each other, and what is swept."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.devices.device import find_device
from gelcone.devices.fields import (
    BELONGING,
    CHOICES,
    DEVICE_FIELDS,
    DRIVE_NUMBERS,
    ELECTRIC,
    EXCLUDING,
    SWEPT_FIELDS,
    DeviceFields,
)
from gelcone.devices.record import meant_fields
from gelcone.devices.scales import Scales
from gelcone.errors import InputError
from tests.physics.test_laws import Fung

PUMP = find_device("biased-pump").replace(film="taut")
PAIR = PUMP.replace(second_film="taut", second_flat_height="30 mm")
TEXTS = [
    "name", "material", "prestretch_mode", "film", "pull_in", "waveform", "reduced", "circuit", "bias", "second_film",
    "second_drive", "material.name", "material.law", "material.flow", "material.sources",
]  # fmt: skip


def test_numbers_alone_are_swept_and_bounds_are_those_of_what_they_measure():
    """Sizes and masses are positive, stiffness and damping not negative; heights, forces and offsets have a sign."""
    assert [name for name, field in DEVICE_FIELDS.items() if not field.unit] == TEXTS
    ranges = {"material.shear_modulus_range", "material.relative_permittivity_range"}
    assert set(DEVICE_FIELDS) - set(SWEPT_FIELDS) == {*TEXTS, *ranges}
    assert set(PUMP.swept_fields()) == set(SWEPT_FIELDS)
    own = {name: field for name, field in SWEPT_FIELDS.items() if not name.startswith("material.")}
    signed = {
        "initial_height", "beam_rate", "beam_height", "constant_force", "gravity", "voltage_offset", "release_height",
        "release_velocity", "second_flat_height", "second_voltage",
    }  # fmt: skip
    assert {name for name, field in own.items() if field.above is None and field.least is None} == signed
    zero = {"spring_rate", "beam_cubic_rate", "payload", "damping_coefficient", "damping_ratio", "voltage_amplitude",
            "series_resistance"}  # fmt: skip
    assert {name for name, field in own.items() if field.least == 0.0} == zero
    assert {name for name, field in own.items() if field.above == 0.0} == set(own) - signed - zero
    units = {"m": 7, "N/m": 2, "N/m^3": 1, "N": 1, "m/s^2": 1, "kg": 2, "N s/m": 1, "V/m": 1, "V": 3, "Hz": 2, "V/s": 1,
             "ohm": 1, "A": 1, "m/s": 1, "1": 8}  # fmt: skip
    counted = {unit: sum(field.unit == unit for field in own.values()) for unit in units}
    assert counted == units
    assert sum(units.values()) == len(own)


NOUNS = {
    "m": "radius|thickness|height", "N/m": "stiffness", "N/m^3": "cubic stiffness", "N": "force", "m/s^2": "gravity",
    "kg": "mass", "N s/m": "viscous damping", "Pa": "(small-strain shear |Young's |lowest and highest shear )?modulus",
    "V": "amplitude|constant (part|voltage)", "V/m": "true (electric )?field", "V/s": "fastest change",
    "Hz": "frequency", "s": "(relaxation time|time constant)", "m/s": "velocity", "ohm": "resistance",
    "ohm m": "resistivity", "A": "largest current", "J/(m^3 K)": "heat capacity",
}  # fmt: skip


@pytest.mark.parametrize(("name", "field"), SWEPT_FIELDS.items(), ids=SWEPT_FIELDS)
def test_the_meaning_of_a_field_begins_with_what_its_unit_measures(name, field):
    if field.unit != "1":
        assert re.match(NOUNS[field.unit], field.meaning)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("outer_radius", ["film_radius"]), ("inner_radius", ["disc_radius"]),
        ("diameter", ["disc_radius", "film_radius"]), ("thickness", ["film_thickness"]),
        ("mass", ["moving_mass"]), ("load", ["constant_force"]),
        ("weight", ["gravity", "payload"]), ("spring_constant", ["spring_rate"]), ("zeta", ["damping_ratio"]),
        ("buckled_beam", ["beam_rate"]), ("damping", ["damping_coefficient", "damping_ratio", "quality_factor"]),
        ("dc_voltage", ["voltage_offset"]), ("ac_voltage", ["voltage_amplitude"]), ("omega", ["frequency"]),
        ("bandwidth", ["filter_frequency"]), ("slew", ["slew_rate"]), ("resistor", ["series_resistance"]),
        ("maximum_current", ["current_limit"]), ("x0", ["release_height"]), ("initial_velocity", ["release_velocity"]),
        ("free_height", ["initial_height"]), ("rod_length", ["second_flat_height"]), ("gel", ["material"]),
        ("elastic_modulus", ["material.young_modulus"]), ("mu", ["material.shear_modulus"]),
        ("dielectric_constant", ["material.relative_permittivity"]), ("jm", ["material.stretch_limit"]),
        ("leakage", ["material.resistivity"]), ("specific_heat", ["material.heat_capacity"]),
        ("breakdown_field", ["dielectric_strength", "material.dielectric_strength"]),
    ],
)  # fmt: skip
def test_the_words_of_other_texts_lead_to_the_field(typed, meant):
    assert meant_fields(typed, DEVICE_FIELDS) == meant


def test_what_belongs_to_a_part_is_refused_without_it():
    belonging = {
        "beam_cubic_rate": "beam_rate", "beam_height": "beam_rate", "current_limit": "series_resistance",
        "slew_rate": "filter_frequency", "second_flat_height": "second_film", "second_prestretch": "second_film",
        "second_meridional_prestretch": "second_film", "second_hoop_prestretch": "second_film",
        "second_drive": "second_film", "second_voltage": "second_film",
    }  # fmt: skip
    assert {name: owner for owner, names in BELONGING for name in names} == belonging
    for name, owner in belonging.items():
        value = "same" if name == "second_drive" else 1.0
        with pytest.raises(InputError, match=f"{name}: there is no {owner}; give {owner}, or leave {name} out"):
            PUMP.replace({name: value})


def test_a_field_given_drops_those_that_say_the_same_otherwise():
    pairs = (
        ("prestretch", "meridional_prestretch"), ("prestretch", "hoop_prestretch"),
        ("second_prestretch", "second_meridional_prestretch"), ("second_prestretch", "second_hoop_prestretch"),
        ("damping_ratio", "quality_factor"), ("damping_ratio", "damping_coefficient"),
        ("quality_factor", "damping_coefficient"),
    )  # fmt: skip
    for one, other in pairs:
        for first, then in ((one, other), (other, one)):
            base = PAIR if "second" in one else PUMP
            changed = base.replace({first: 1.1}).replace({then: 1.2})
            assert (changed.get(first), changed.get(then)) == (None, 1.2)
    both = PUMP.replace(meridional_prestretch=1.1).replace(hoop_prestretch=1.2)
    assert (both.meridional_prestretch, both.hoop_prestretch) == (1.1, 1.2)
    assert len(EXCLUDING) == 7


def test_texts_that_are_chosen_are_one_of_a_few():
    """A wrong one is refused with all that there are, under the words for it."""
    allowed = {
        "prestretch_mode": ("pre-stretch mode", "equibiaxial"), "pull_in": ("way to treat pull-in", "memoryless"),
        "second_film": ("second film", "membrane"), "second_drive": ("drive of a second film", "opposite"),
    }  # fmt: skip
    assert {name: what for name, what, _ in CHOICES} == {name: what for name, (what, _) in allowed.items()}
    for name, (what, some) in allowed.items():
        with pytest.raises(InputError, match=f"{what}.*{some}"):
            PAIR.replace({name: "none of them"})


def test_the_fields_of_the_amplifier_are_those_that_a_circuit_of_ones_own_replaces():
    values = {"filter_frequency": 100.0, "slew_rate": 1e5, "series_resistance": 1e6, "current_limit": 1e-3,
              "material.resistivity": 1e9, "material.dielectric_share": 0.1}  # fmt: skip
    assert set(ELECTRIC) == set(values)
    assert DRIVE_NUMBERS == ("voltage_amplitude", "voltage_offset", "frequency")


def test_the_shape_of_an_ensemble_is_that_of_any_field_that_has_several_values():
    assert PUMP.shape == ()
    assert PUMP.replace(release_velocity=[0.0, 0.1, 0.2]).shape == (3,)
    assert PUMP.replace({"material.shear_modulus": [1e4, 2e4]}).shape == (2,)


def test_a_gel_of_a_law_of_ones_own_has_its_fields():
    own = PUMP.replace({"material.law": Fung()})
    assert set(own.all_fields()) - set(DEVICE_FIELDS) == {"material.fung_b"}
    assert set(own.swept_fields()) - set(SWEPT_FIELDS) == {"material.fung_b"}


def test_a_value_is_got_by_its_name_and_the_materials_by_a_dotted_one():
    """Of the gel's own fields only those under its name: both have a dielectric strength."""
    own = SimpleNamespace(dielectric_strength=3.0, material=SimpleNamespace(dielectric_strength=5.0))
    assert DeviceFields.get(own, "dielectric_strength") == 3.0
    assert DeviceFields.get(own, "material.dielectric_strength") == 5.0
    assert PUMP.all_fields()["material.shear_modulus"].unit == "Pa"
    assert PUMP.scales == Scales.of(PUMP.get)
    assert np.isclose(PUMP.scales.length, PUMP.film_radius - PUMP.disc_radius)
