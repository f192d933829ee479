"""Steps of an exported device by the integrator: those of `simulate`, and the test program that holds them."""

from __future__ import annotations

import re
import struct
import subprocess

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelcone
from gelcone.export import reference
from gelcone.export.compiler import find_compiler
from gelcone.export.reference import Reference
from gelcone.export.sources import Exported
from gelcone.physics.drive import Pieces
from gelcone.physics.waveforms import Triangle
from tests.export.instance import STRICT, device

compiles = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")


@pytest.mark.parametrize("inside", [False, True])
def test_the_test_program_drives_a_period_as_the_device_is_driven(inside):
    """Its steps, its voltages with their rates, and where the displacement is after each."""
    own = device(film="taut", voltage_offset=700.0, voltage_amplitude=80.0, frequency=8.0)
    exported = Exported(own, "pump", inside, 1e-10)
    steps, right = tables_of(reference.test_program(exported))
    times = np.arange(21) / (20 * 8.0)
    volts = np.zeros(21) if inside else 700.0 + 80.0 * np.sin(2.0 * np.pi * 8.0 * times)
    sizes, starts, rates = np.array(steps).T
    np.testing.assert_allclose(sizes, np.diff(times), rtol=1e-12)
    np.testing.assert_allclose(starts, volts[:-1], rtol=1e-12)
    np.testing.assert_allclose(rates, np.diff(volts) / np.diff(times), rtol=1e-9, atol=1e-9)
    x = 1e-3 * gelcone.simulate(own, times=times[1:]).displacement.values
    found = np.array(right)[:, 0] * own.scales.length
    assert np.abs(found - x).max() < (1e-8 if inside else 0.02) * np.ptp(x)


def tables_of(text):
    """The numbers of the two tables of a test program: doubles as they are, and those that are given by their bits."""
    rows = [row.split(", ") for row in re.findall(r"^ *\{(.*?)\}", text, flags=re.MULTILINE)]
    plain = [[float(one) for one in row] for row in rows if "0x" not in row[0]]
    bits = [[struct.unpack("<d", struct.pack("<Q", int(one, 16)))[0] for one in row] for row in rows if "0x" in row[0]]
    return plain, bits


@compiles
def test_a_test_program_notices_other_numbers(tmp_path):
    gelcone.export(device(film="taut"), tmp_path / "pump")
    source = tmp_path / "pump" / "pump.c"
    text = source.read_text()
    twice = "static double twice(double a, double b, double c) { return a * b + c; }"
    first = "typedef pump_word word;"
    assert first in text
    source.write_text(text.replace("fma(", "twice(").replace(first, f"{first}\n{twice}"))
    command = [*find_compiler(), *STRICT, "-O1", "test.c", "pump.c", "-lm", "-o", "test"]
    subprocess.run(command, cwd=tmp_path / "pump", check=True)
    assert subprocess.run(["./test"], cwd=tmp_path / "pump", capture_output=True, check=False).returncode == 1


# --- the motion -------------------------------------------------------------------------------------------------------


class Late(Triangle):
    """A triangle whose first piece begins at three quarters of the period."""

    name = "late"

    def table(self, n):
        pieces = super().table(n)
        return Pieces(pieces.begins + 2.0 * np.pi, pieces.terms)


WAVES = {
    "sine": "sine",
    "trapezoid": "trapezoid",
    "jumps": {"component": "square", "rise": 0.0, "duty": 0.3},
    "late": "tests.export.test_reference:Late",
    "harmonics": "harmonics",
    "once": {"component": "staircase", "repeat": False},
}


@pytest.mark.parametrize("name", WAVES)
@pytest.mark.parametrize("size", [3e-3, 0.07, 0.1])
def test_a_motion_under_the_drive_inside_is_that_of_simulate(name, size):
    """In steps between the corners of the drive, across several, and from period to period."""
    own = device(film="taut", waveform=WAVES[name])
    motion = Reference(Exported(own, "pump", True, 1e-15))
    times = size * np.arange(1, int(0.3 / size) + 1)
    right = gelcone.simulate(own, times=times)
    found = []
    for time in times:
        assert motion.step(size, (0.0, 0.0, 0.0, 0.0)) == 0
        assert motion.time == pytest.approx(time, rel=1e-12)
        found.append(motion.z[:2])
    x, u = np.transpose(found) * [[own.scales.length], [own.scales.velocity]]
    for values, name, unit in ((1e3 * x, "displacement", "mm"), (u, "velocity", "m/s")):
        known = right[name].values
        assert right[name].units == unit
        assert np.abs(values - known).max() < 1e-11 * max(np.ptp(known), 0.1 * np.abs(known).max())


def test_inputs_and_their_rates_drive_across_corners_of_the_drive_inside():
    """A voltage and a force that change for the whole of a step, against another integrator."""
    own = device(film="taut", waveform="trapezoid")
    motion, right = Reference(Exported(own, "pump", True, 1e-12)), gelcone.rates(own)
    given, waveform = (70.0, 900.0, 2e-2, -0.3), own.to_model().system.waveform

    def fall(t, y):
        drive = float(waveform.voltage(t / own.scales.time, right._drive)) * own.scales.voltage
        return right(t, y, voltage=drive + given[0] + given[1] * t, force=given[2] + given[3] * t)

    assert motion.step(0.04, given) == 0
    end = solve_ivp(fall, (0.0, 0.04), right.start, rtol=1e-10, atol=1e-13, max_step=1e-4).y[:, -1]
    scales = [own.scales.length, own.scales.velocity]
    np.testing.assert_allclose(motion.z * scales, end, rtol=1e-6)


def test_a_motion_that_ends_has_no_more_steps():
    """It pulls in at the time of `simulate`, and the test program ends with that step."""
    own = device(film="wrinkling", voltage_offset=2703.0, voltage_amplitude=0.0)
    exported = Exported(own, "pump", True, 1e-12)
    motion = Reference(exported)
    steps = 1
    while not motion.step(1e-3, (0.0, 0.0, 0.0, 0.0)):
        steps += 1
    assert steps == int(motion.time / 1e-3) + 1
    right = gelcone.simulate(own, times=[0.1])
    assert 1e3 * motion.time == pytest.approx(float(right.pull_in_time), rel=1e-9)
    steps, states = tables_of(reference.test_program(exported))
    assert len(steps) == len(states) == int(motion.time * own.frequency * 20) + 1


def test_a_long_step_may_take_as_many_steps_as_it_is_long(monkeypatch):
    monkeypatch.setattr(reference, "STEPS_PER_CALL", 100)
    monkeypatch.setattr(reference, "CALL_SPAN", 20.0)
    motion = Reference(Exported(device(film="taut"), "pump", False, 1e-7))
    assert motion.step(3.0, (900.0, 0.0, 0.0, 0.0)) == 0
    assert motion.time == 3.0
