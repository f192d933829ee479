"""Means over motions whose voltage has corners, against formulas of discs that are held."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.motion import corners as module
from gelcone.motion.corners import Weighted, between_corners, root_mean_squares
from tests.motion.made_up import MadeUp

HELD = {"rest_height": 0.5, "spring_stiffness": 1e6, "damping_ratio": 20.0, "drive_frequency": 0.7, "film": "taut"}
CAPACITANCE = 1.25
"""Of the taut cone at 0.5, over that of the flat film."""
UNUSED = np.zeros((1, 2)), np.zeros(1), np.ones(1)
"""Begin, start and end of a path, which its means do not need."""


def held(**more):
    return gelcone.ConeModel(**HELD, **more)


def path_of(model, start=0.0, periods=1.0):
    members = model.members()
    begin, period = members.start_states((0.5, 0.0)), np.broadcast_to(members.drive_period, members.shape).ravel()
    return members, between_corners(members, begin, start * period, periods * period, tolerance=1e-12)


@pytest.mark.parametrize("start", [0.0, 0.37])
def test_nodes_lie_between_corners_and_their_weights_give_the_length_of_each_piece(start):
    model = held(waveform="square", duty=0.4, rise=0.02, voltage=[0.3, 0.2], voltage_bias=0.3)
    members, path = path_of(model.replace(drive_frequency=[0.7, 1.1]), start, 2.0)
    assert (np.diff(path.times, axis=1) > 0.0).all()
    np.testing.assert_allclose(path.weights.sum(axis=1), 1.0, rtol=1e-12)
    n, waveform = members.numbers(trailing=1), members.system.waveform
    rates = waveform.voltage(path.times + 1e-9, n) - waveform.voltage(path.times - 1e-9, n)
    # up for 0.02 of the period, and down for as long: whatever lies between is exact, for no node is on the other side
    risen = path.mean(1.0 * (rates > 1e-10)), path.mean(1.0 * (rates < -1e-10))
    np.testing.assert_allclose(risen, 0.02, rtol=1e-9)


@pytest.mark.parametrize(
    ("waveform", "squares", "rates"),
    [
        ({"waveform": "triangle"}, 1.0 / 3.0, 1.0),
        ({"waveform": "square", "duty": 0.5, "rise": 0.002}, 1.0 - 0.004 + 0.004 / 3.0, 250.0),
    ],
    ids=["triangle", "square"],
)
def test_a_held_film_has_the_current_of_a_capacitor_between_its_corners(waveform, squares, rates):
    """C v' of a voltage of the amplitude A about a bias b: <v^2> = b^2 + A^2 squares, and <v'^2> = (4 A f)^2 rates: of
    a square 2 r (2 A f/r)^2 with the share r of its rise."""
    amplitude, bias, frequency = 0.1, 0.4, 0.7 / (2.0 * np.pi)
    members, path = path_of(held(**waveform, voltage=amplitude, voltage_bias=bias))
    ((voltage, current),) = root_mean_squares(members, path)
    assert voltage[0] == pytest.approx(np.sqrt(bias**2 + squares * amplitude**2), rel=1e-6)
    assert current[0] == pytest.approx(CAPACITANCE * 4.0 * amplitude * frequency * np.sqrt(rates), rel=1e-3)


def test_one_apparent_power_of_a_square_voltage_in_every_answer():
    """Samples miss its short rises: the envelope's gave up to 74 % more."""
    device = gelcone.find_device("biased-pump").replace(film="taut", waveform="square")
    settled = float(gelcone.settled(device)["apparent_power"])
    peak = float(device.voltage_offset + device.voltage_amplitude)
    plane = gelcone.envelope(device, peaks=[0.5 * peak, peak], frequencies=[10.0, 11.0])
    assert float(plane["driven_apparent_power"][0, 1]) == pytest.approx(settled, rel=1e-9)
    assert float(gelcone.simulate(device, periods=60)["apparent_power"]) == pytest.approx(settled, rel=1e-4)
    assert float(gelcone.datasheet(device)["apparent_power"]) == pytest.approx(settled, rel=1e-9)


def test_values_behind_the_end_do_not_count():
    path = Weighted(np.zeros((1, 3)), np.zeros((1, 3, 2)), np.array([[0.25, 0.75, 0.0]]), *UNUSED)
    assert path.mean(np.array([[2.0, 4.0, np.nan]])).tolist() == [3.5]


def test_members_with_fewer_corners_end_at_their_own_time(monkeypatch):
    """Behind their end they have nodes of no weight."""
    corners = np.array([[0.3, 0.7], [0.5, np.inf]])
    members = SimpleNamespace(
        drive_period=np.array([1.0, 1.0]), shape=(2,), size=2, own_numbers={},
        system=SimpleNamespace(
            waveform=SimpleNamespace(corners_between=lambda start, end, n: SimpleNamespace(later=corners))
        ),
    )  # fmt: skip
    monkeypatch.setattr(
        module, "integrate", lambda members, begin, times, **flow: SimpleNamespace(states=times[..., None])
    )
    path = between_corners(members, np.zeros((2, 2)), np.zeros(2), np.ones(2))
    np.testing.assert_allclose(path.weights.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(path.mean(np.where(path.times <= 1.0, path.times, np.inf)), 0.5, rtol=1e-12)
    assert (path.weights[1] == 0.0).sum() > (path.weights[0] == 0.0).sum()
    assert (path.times[1][path.weights[1] == 0.0] > 1.0).all()


def test_a_source_has_its_own_voltage_and_current():
    """Those of all sources are computed together, since each takes the voltages and currents of all films."""
    times, asked = np.zeros((1, 2)), []
    path = Weighted(times, np.zeros((1, 2, 2)), np.array([[0.25, 0.75]]), *UNUSED)
    system = SimpleNamespace(
        source_voltages=lambda *_: [np.array([[7.0, 7.0]]), np.array([[1.0, 3.0]]), np.array([[1.0, 3.0]])],
        source_currents=lambda *_: asked.append(1) or [100.0, np.array([[3.0, 2.0]])],
        lines=(SimpleNamespace(films=(0,)), SimpleNamespace(films=(1, 2))),
    )
    first, (voltage, current) = root_mean_squares(MadeUp(system=system), path)
    assert (first[0][0], first[1][0]) == (7.0, 100.0)
    assert (voltage[0], current[0]) == (np.sqrt(0.25 + 0.75 * 9.0), np.sqrt(0.25 * 9.0 + 0.75 * 4.0))
    assert len(asked) == 1
