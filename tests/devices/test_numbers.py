"""Parameters of a model and the fields of a device that give them: each is its field over its unit."""

import numpy as np
import pytest

import gelcone
from gelcone.devices.materials import Material
from gelcone.devices.numbers import SHIPPED, numbers_of
from tests.toys import TurningBias

GEL = Material(
    name="gel", shear_modulus="12 kPa", relative_permittivity=5.0, law="yeoh", yeoh_c2=0.02, yeoh_c3=0.003,
    viscous_modulus_1="7 kPa", relaxation_time_1="0.3 s", viscous_stretch_limit_1=40.0, viscous_modulus_2="3 kPa",
    relaxation_time_2="5 s", viscous_stretch_limit_2=30.0, resistivity="3 Gohm m", resistivity_field="9 MV/m",
    dielectric_share=0.2, dielectric_time="0.05 s",
)  # fmt: skip
DEVICE = gelcone.find_device("biased-pump").replace(
    {
        "film": "taut", "material": GEL, "meridional_prestretch": 1.1, "hoop_prestretch": 1.2, "prestretch": None,
        "beam_rate": "-20 N/m", "beam_cubic_rate": "4e5 N/m^3", "beam_height": "3 mm", "constant_force": "0.05 N",
        "series_resistance": "2 MOhm", "filter_frequency": "900 Hz", "slew_rate": "30 kV/s", "current_limit": "0.4 mA",
        "voltage_offset": "300 V",
        "waveform": "trapezoid",
    }
)  # fmt: skip


def units(device):
    """The SI value of 1 of each parameter that is not a pure number, from a few scales."""
    s, permittivity = device.scales, 8.8541878188e-12 * device.material.relative_permittivity
    rate, charge = 1.0 / s.time, s.force * s.length / s.voltage
    return {
        "spring_stiffness": s.force / s.length, "rest_height": s.length, "voltage": s.voltage,
        "voltage_bias": s.voltage, "drive_frequency": rate / (2.0 * np.pi), "beam_stiffness": s.force / s.length,
        "beam_cubic": s.force / s.length**3, "beam_height": s.length, "push": s.force, "dielectric_time": s.time,
        "leakage_time": s.time / permittivity, "leakage_field": s.voltage / device.film_thickness,
        "slew_rate": s.voltage * rate, "series_resistance": s.voltage / (charge * rate), "current_limit": charge * rate,
        "second_flat_height": s.length, "second_voltage": s.voltage, "relaxation_time_1": s.time,
        "relaxation_time_2": s.time, "viscous_modulus_1": device.material.shear_modulus,
        "viscous_modulus_2": device.material.shear_modulus,
    }  # fmt: skip


def test_every_parameter_of_a_device_is_its_field_over_its_unit():
    """Also those of its law, its branches and its leak."""
    values, found, unit = DEVICE.to_model().values, numbers_of(DEVICE), units(DEVICE)
    told = {name: number for name, number in found.items() if name in values}
    for name, number in told.items():
        if not number.field.startswith("waveform."):
            expected = DEVICE.get(number.field) / unit.get(name, 1.0)
            assert float(values[name]) == pytest.approx(float(expected), rel=1e-12), name
    given = {
        "viscous_modulus_1": 7e3, "viscous_modulus_2": 3e3, "relaxation_time_1": 0.3, "relaxation_time_2": 5.0,
        "viscous_limit_1": 40.0, "viscous_limit_2": 30.0, "yeoh_c2": 0.02, "yeoh_c3": 0.003, "leakage_time": 3e9,
        "leakage_field": 9e6, "dielectric_share": 0.2, "dielectric_time": 0.05, "beam_stiffness": -20.0,
        "beam_cubic": 4e5, "beam_height": 3e-3, "push": 0.05, "series_resistance": 2e6, "slew_rate": 3e4,
        "current_limit": 4e-4, "voltage_bias": 300.0, "meridional_prestretch": 1.1, "hoop_prestretch": 1.2,
        "spring_stiffness": DEVICE.spring_rate, "rest_height": DEVICE.initial_height,
        "drive_frequency": DEVICE.frequency, "voltage": DEVICE.voltage_amplitude,
    }  # fmt: skip
    assert {name: values[name] * unit.get(name, 1.0) for name in given} == pytest.approx(given, rel=1e-12)
    assert {name for name, number in told.items() if not number.field.startswith("waveform.")} == set(given)
    assert set(found) - set(told) == {name for name in SHIPPED if name.startswith("second_")} | {"prestretch"}
    assert set(unit) - set(told) == {"second_flat_height", "second_voltage"}


def test_parameters_of_a_second_film_are_its_fields_over_their_units():
    own = {"second_flat_height": "11 mm", "second_voltage": "900 V", "second_drive": "constant", "second_film": "taut"}
    own |= {"second_meridional_prestretch": 1.05, "second_hoop_prestretch": 1.3}
    device = gelcone.find_device("double-cone").replace({"film": "taut", **own})
    values, found, unit = device.to_model().values, numbers_of(device), units(device)
    for name in ("second_flat_height", "second_voltage", "second_meridional_prestretch", "second_hoop_prestretch"):
        expected = device.get(found[name].field) / unit.get(name, 1.0)
        assert float(values[name]) == pytest.approx(float(expected), rel=1e-12), name


def test_a_filter_and_a_weight_follow_from_several_fields():
    """The time constant of a filter is one over its angular corner frequency; a payload weighs with the disc."""
    device = DEVICE.replace({"gravity": "9.81 m/s^2", "payload": "3 g"})
    values = device.to_model().values
    assert float(values["filter_time"]) * device.scales.time == pytest.approx(1.0 / (2.0 * np.pi * 900.0), rel=1e-12)
    mass = device.moving_mass + 3e-3
    assert float(values["weight"]) * device.scales.force == pytest.approx(mass * 9.81, rel=1e-12)


def test_numbers_of_a_waveform_are_its_own():
    """Given as a text too; one of its own parameters has the scale that it names."""
    found = numbers_of(DEVICE)
    assert {name: found[name] for name in ("rise", "high", "fall")} == {
        name: (f"waveform.{name}", "1") for name in ("rise", "high", "fall")
    }
    assert "rise" not in numbers_of(DEVICE.replace(waveform="sine"))
    filtered = numbers_of(DEVICE.replace(bias=TurningBias()))
    assert [filtered[name].field for name in TurningBias.parameters] == [f"bias.{n}" for n in TurningBias.parameters]
