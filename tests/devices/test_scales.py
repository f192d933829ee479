"""The units of the dimensionless model, by hand."""

import dataclasses
import math

import pytest

from gelcone.devices.device import Device, find_device
from gelcone.devices.scales import Scales


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
