"""Motions beside the one that grows out of rest, and the kick that leads to them."""

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, Outcome, Regime
from gelcone.motion import coexisting as module
from gelcone.motion.coexisting import Motions, _narrow, coexisting
from gelcone.motion.settle import start_states
from gelcone.motion.settled import Swing, settled_swing

WELLS = ConeModel(damping_ratio=0.3, spring_stiffness=0.5, rest_height=0.0, voltage=0.05, voltage_bias=1.6)
"""Two wells, mirror images of each other, and next to no drive: a kick over the hill leads from one to the other."""
PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def pump(hertz, volts):
    model, scales = PUMP.to_model(), PUMP.scales
    peak = volts / scales.voltage / float(model.voltage + model.voltage_bias)
    drive = {"voltage": peak * float(model.voltage), "voltage_bias": peak * float(model.voltage_bias)}
    model = model.replace(drive_frequency=np.atleast_1d(hertz) / scales.frequency, **drive)
    return model, start_states(model, (PUMP.initial_state()[0] + 1e-3, 0.0))


@pytest.fixture(scope="module")
def wells():
    model = WELLS.replace(drive_frequency=np.array([3.0]))
    start = np.array([[float(gelcone.settled(WELLS.replace(drive_frequency=3.0))["highest"]), 0.0]])
    return model, start, coexisting(model.members(), start)


def test_the_mirror_image_coexists_and_the_kick_over_the_hill_leads_there(wells):
    model, start, found = wells
    assert found["motions"].tolist() == [1]
    own = settled_swing(model.members(), start)
    assert found["highest"][0, 0] == pytest.approx(-float(own.lowest[0]), abs=1e-6)
    assert found["regime"][0, 0] == Regime.PERIODIC
    # without damping the kick that just climbs the hill at x = 0 would do; with it more is needed
    held = WELLS.replace(voltage=0.0)
    energy = [float(held.energy(x)) - 0.5 * 1.6**2 * x * x for x in (0.0, float(own.highest[0]))]
    assert found["kick_high"][0] > np.sqrt(2.0 * (energy[0] - energy[1]))


def test_below_the_interval_kicks_lead_back_and_above_they_lead_away(wells):
    model, start, found = wells
    own = settled_swing(model.members(), start)
    kicked = np.repeat(own.final, 2, axis=0)
    members = model.members().take([0, 0])
    kicked[:, 1] -= [0.95 * found["kick_low"][0], 0.0]
    assert settled_swing(members, kicked).highest[0] == pytest.approx(own.highest[0], abs=1e-4)
    assert found["kick_low"][0] < found["kick_high"][0] < found["kick_tried"][0]
    assert found["motion_kick_low"][0, 0] <= found["kick_high"][0] <= found["motion_kick_high"][0, 0]


@pytest.mark.slow
def test_other_phases_give_an_interval_that_overlaps(wells):
    model, start, found = wells
    for shift in (0.3, 0.5):
        again = coexisting(model.members(), start, shift=shift)
        assert again["kick_low"][0] <= found["kick_high"][0]
        assert found["kick_low"][0] <= again["kick_high"][0]


def test_one_well_has_no_other_motion():
    alone = WELLS.replace(voltage_bias=0.2, drive_frequency=np.array([1.0, 1.5]))
    found = coexisting(alone.members(), start_states(alone, (0.01, 0.0)))
    assert found["motions"].tolist() == [0, 0]
    assert np.isinf(found["kick_low"]).all()
    assert found["stroke"].shape == (2, 0)


def test_the_pump_can_be_kicked_into_a_motion_beyond_breakdown():
    """Between 1.8 and 2.25 kV at 29.75 Hz it moves by half a millimetre, and by 250 mm after (0 mm, 10 m/s)."""
    model, start = pump(29.75, 2027.0)
    found = coexisting(model.members(), start)
    millimetres, speed = 1e3 * PUMP.scales.length, PUMP.scales.velocity
    assert found["motions"].tolist() == [1]
    assert found["stroke"][0, 0] * millimetres == pytest.approx(250.0, rel=0.02)
    assert 0.4 < found["validity"][0, 0, 2] < 0.55
    assert 5.0 < found["kick_low"][0] * speed < found["kick_high"][0] * speed < 10.3
    thrown = settled_swing(model.members(), np.array([[0.0, 10.0 / speed]]))
    assert thrown.outcome.tolist() == [Outcome.OK]
    assert 2.0 * thrown.amplitude[0] * millimetres == pytest.approx(250.0, rel=0.02)


class MadeUpKicks:
    """Kicks that lead from one motion to another when they exceed a least size, which has a sharp valley at a phase."""

    def __init__(self, valley):
        self.valley = valley

    def least(self, phases):
        off = np.abs(np.asarray(phases) - self.valley) % 1.0
        return 1.0 + 20.0 * np.minimum(off, 1.0 - off)

    def after(self, rows, phases, kicks):
        return [motion(1.0 if leads else 0.1) for leads in np.abs(kicks) > self.least(phases)]


def motion(size):
    made = Swing.blank(1)
    made.lowest[:], made.highest[:], made.period[:] = -size, size, 1
    return made


@pytest.mark.parametrize("valley", [0.01, 0.172, 0.49])
def test_the_interval_of_the_smallest_kick_holds_that_between_the_phases_tried(valley):
    kicks, phases = MadeUpKicks(valley), np.arange(6) / 6.0
    found = [Motions([motion(0.1)], [(np.nan, np.nan)])]
    sizes = 2.0 ** np.ceil(np.log2(kicks.least(phases)))
    _narrow(kicks, np.array([0]), found, {0: list(zip(phases, sizes, strict=True))})
    low, high = found[0].smallest
    assert low <= 1.0 <= high < 1.5


def test_kicks_stay_within_what_a_disc_does_where_the_stretch_limit_is_far():
    model = ConeModel(stretch_limit=1e6, damping_ratio=0.1, voltage=0.3)
    assert module._farthest(model.members(), 0) == module.FARTHEST
    assert module._farthest(model.replace(stretch_limit=10.0).members(), 0) < module.FARTHEST
