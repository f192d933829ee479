"""One question about dielectric breakdown has one answer, whichever command is asked and whatever the own drive is."""

import pytest

import gelcone
from gelcone.motion.plane import DRIVEN_LIMITS
from gelcone.motion.static_limits import STATIC_LIMITS

NAME = "dielectric breakdown"
TAUT = {"film": "taut", "dielectric_strength": "8 MV/m", "hoop_prestretch": 1.6}
MEMBRANE = {"film": "membrane", "dielectric_strength": "9 MV/m"}


def driven(device, share):
    """The device with its drive in proportion."""
    return device.replace(
        voltage_amplitude=share * device.voltage_amplitude, voltage_offset=share * device.voltage_offset
    )


@pytest.mark.parametrize("changes", [TAUT, pytest.param(MEMBRANE, marks=pytest.mark.slow)])
def test_breakdown_is_one_voltage_whatever_the_own_drive(changes):
    """Beyond twice the smallest drive, too."""
    pump = gelcone.find_device("biased-pump").replace(changes)
    limits = gelcone.operating_limits(pump)
    names = ("dielectric_breakdown", "driven_dielectric_breakdown", "driven_error")
    constant, moving, error = (float(limits[f"{name}_voltage"]) for name in names)
    assert 700.0 < moving < constant < 2e4
    assert error < 0.01 * moving
    volts = gelcone.stroke_and_blocked_force(pump, [0.999 * constant, 1.001 * constant])
    at_rest = gelcone.envelope(pump, peaks=[100.0, 1.001 * constant], frequencies=[9.0, 10.0])
    field = at_rest["static_field"].interp(constant_voltage=volts["constant_voltage"])
    strength = pump.to_model().dielectric_strength * pump.scales.size("field") / 1e6
    assert field.values[0] < strength < field.values[1]
    for share in (0.125, 2.0):
        device = driven(pump, share)
        sheet, alone = gelcone.datasheet(device), gelcone.operating_limits(device)
        found = gelcone.envelope(device, frequencies=[pump.frequency, 1.1 * pump.frequency])
        ramps = [sheet["dielectric_breakdown_voltage"], alone["dielectric_breakdown_voltage"]]
        ramps.append(found["static_limit_voltage"][STATIC_LIMITS.index(NAME)])
        assert [float(value) for value in ramps] == pytest.approx([constant] * 3, rel=1e-9)
        motions = [sheet["driven_dielectric_breakdown_voltage"], alone["driven_dielectric_breakdown_voltage"]]
        motions.append(found["limit_low"][DRIVEN_LIMITS.index(NAME), 0])
        assert [float(value) for value in motions] == pytest.approx([moving] * 3, abs=error)
        assert sheet.attrs["first_limit"] == f"driven {NAME}"
        assert float(sheet["safe_peak_voltage"]) == pytest.approx(moving, abs=1.001 * error)
