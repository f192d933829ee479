"""The units of the dimensionless model, by hand."""

import dataclasses
import math

import numpy as np
import pytest

from gelcone.devices.device import Device, find_device
from gelcone.devices.scales import MEASURES, Scales
from gelcone.devices.units import DIMENSIONS, parse


def test_scales_by_hand():
    """Round numbers: b - a = 0.1 m, Vol = pi 0.03 0.001 m^3, mu = 1e4 Pa, so mu Vol = 0.3 pi J."""
    material = {"shear_modulus": 1e4, "relative_permittivity": 1 / 8.8541878188e-2}  # eps = 1e-10 F/m
    device = Device(
        disc_radius=0.1, film_radius=0.2, film_thickness=1e-3, moving_mass=3.0, spring_rate=100.0, quality_factor=10.0,
        voltage_amplitude=1e3, frequency=1.0, material=material,
    )  # fmt: skip
    energy = 0.3 * math.pi
    rate = math.sqrt(energy / (3.0 * 0.01))
    by_hand = Scales(
        length=0.1,
        time=1 / rate,
        velocity=0.1 * rate,
        force=energy / 0.1,
        energy=energy,
        power=energy * rate,
        voltage=1e4,
        current=energy * rate / 1e4,
        field=1e7,
        stress=1e4,
        frequency=rate / (2 * math.pi),
        heat_capacity=1.8e6,
    )
    assert dataclasses.asdict(device.scales) == pytest.approx(dataclasses.asdict(by_hand), rel=1e-14)


def test_a_payload_slows_the_clock():
    device = find_device("biased-pump")
    laden = device.replace(payload="15 g", gravity="9.81 m/s^2")
    assert laden.scales.time == pytest.approx(2.0 * device.scales.time, rel=1e-14)


@pytest.fixture(scope="module")
def device():
    return find_device("soft-film")


@pytest.mark.parametrize(
    ("quantity", "unit", "scale"),
    [
        ("length", "mm", lambda s: 1e3 * s.length),
        ("time", "ms", lambda s: 1e3 * s.time),
        ("velocity", "m/s", lambda s: s.length / s.time),
        ("force", "N", lambda s: s.force),
        ("stiffness", "N/m", lambda s: s.force / s.length),
        ("energy", "mJ", lambda s: 1e3 * s.force * s.length),
        ("power", "mW", lambda s: 1e3 * s.force * s.length / s.time),
        ("apparent power", "mVA", lambda s: 1e3 * s.force * s.length / s.time),
        ("voltage", "V", lambda s: s.voltage),
        ("current", "mA", lambda s: 1e3 * s.force * s.length / s.time / s.voltage),
        ("field", "MV/m", lambda s: 1e-6 * s.field),
        ("stress", "kPa", lambda s: 1e-3 * s.stress),
        ("frequency", "Hz", lambda s: 1.0 / (2.0 * np.pi * s.time)),
        ("rate", "1/s", lambda s: 1.0 / s.time),
        ("cubic stiffness", "N/m^3", lambda s: s.force / s.length**3),
        ("resistance", "Mohm", lambda s: 1e-6 * s.voltage**2 / s.power),
        ("charge", "uC", lambda s: 1e6 * s.energy / s.voltage),
        ("capacitance", "nF", lambda s: 1e9 * s.energy / s.voltage**2),
        ("resistivity", "Gohm m", lambda s: 1e-9 * s.time * s.field**2 / s.stress),
        ("slew rate", "V/ms", lambda s: 1e-3 * s.voltage / s.time),
        ("thickness", "mm", lambda s: 1e3 * s.voltage / s.field),
        ("gain", "mm/kV", lambda s: 1e6 * s.length / s.voltage),
        ("admittance", "uS", lambda s: 1e6 * s.energy / s.voltage**2 / s.time),
        ("heating", "mK/s", lambda s: 1e3 * s.stress / s.time / 1.8e6),
        ("energy density", "J/m^3", lambda s: s.stress),
        ("power density", "W/m^3", lambda s: s.stress / s.time),
        ("specific energy", "mJ/kg", lambda s: 1e3 * (s.length / s.time) ** 2),
        ("specific power", "mW/kg", lambda s: 1e3 * s.length**2 / s.time**3),
    ],
)
def test_a_quantity_has_its_unit_and_scale(device, quantity, unit, scale):
    assert MEASURES[quantity].shown == unit
    assert device.scales.shown(quantity) == pytest.approx(scale(device.scales), rel=1e-12)


def test_every_quantity_that_is_read_in_si_is_tested():
    assert len(MEASURES) == 28


@pytest.mark.parametrize("quantity", MEASURES)
def test_the_units_of_a_quantity_agree(device, quantity):
    """What is read, shown and scaled is one size: the shown unit is one of the SI unit's, where these can be read."""
    unit, shown, per_unit = MEASURES[quantity]
    if unit in DIMENSIONS:
        assert parse("", f"1 {shown}", unit) * per_unit == pytest.approx(1.0, rel=1e-15)
    value = 3.0 * device.scales.size(quantity)
    assert device.scales.dimensionless(quantity, value) == pytest.approx(3.0, rel=1e-14)
