"""Borders as events, and corners of the drive as a run takes them."""

from dataclasses import dataclass

import numpy as np
import pytest

from gelcone.motion.engine.interruptions import border_events, corner_numbers, corner_times, switches_at
from gelcone.physics.drive import PIECE
from gelcone.physics.film.film import Border
from gelcone.physics.model import ConeModel
from tests.toys import PowerFilm

TIMES = np.array([0.0, 1.3, 4.0])
STATES = np.array([[0.3, 0.1], [0.2, -0.4], [-0.5, 0.0]])


@dataclass(frozen=True)
class Bordered(PowerFilm):
    """A power film whose law changes at x = 1, where its force jumps at x = -1; it ends where V = 3."""

    @property
    def borders(self):
        return (
            Border(lambda x, squared, y, n, xp: n["upper"] * (1.0 - x), "upper", divides=True),
            Border(lambda x, squared, y, n, xp: n["lower"] * (1.0 + x), "lower", jumps=True, gentle=True),
            Border(lambda x, squared, y, n, xp: 3.0 - squared, seldom=True),
        )

    def numbers(self, parameters):
        return super().numbers(parameters) | {"upper": 1.0, "lower": 1.0}

    def switches(self, x, squared, y, n):
        return {"upper": np.where(x > 1.0, -1.0, 1.0), "lower": np.where(x < -1.0, -1.0, 1.0)}


def test_events_are_borders_that_fall_through_zero_where_a_member_is_inside():
    model = ConeModel(film=Bordered(), voltage=0.8)
    events = border_events(model.system)
    assert [event.switch for event in events] == ["upper", "lower", None]
    assert [(event.direction, event.inside) for event in events] == [(-1, True)] * 3
    assert [event.smooth for event in events] == [True, False, True]
    assert [event.seldom for event in events] == [False, False, True]
    assert [event.divides for event in events] == [True, False, False]
    assert [event.gentle for event in events] == [False, True, False]
    n, z = model.own_numbers, [0.3, 0.7]
    values = [event.border(0.5, z, n, np) for event in events]
    np.testing.assert_allclose(values, [0.7, 1.3, 3.0 - (0.8 * np.sin(0.5)) ** 2], rtol=1e-14)


def test_events_of_a_program_take_its_own_numbers():
    model = ConeModel(film=Bordered(), voltage=0.8)
    turned = border_events(model.system, lambda numbers: {**model.own_numbers, "upper": numbers["other"]})
    assert turned[0].border(0.5, [0.3, 0.7], {"other": -2.0}, np) == pytest.approx(-1.4, rel=1e-14)


def test_behind_a_resistance_the_rates_are_not_continuous_at_any_border():
    events = border_events(ConeModel(film="wrinkling", series_resistance=0.4).system)
    assert events
    assert not any(event.smooth for event in events)
    assert any(event.smooth for event in border_events(ConeModel(film="wrinkling", filter_time=0.4).system))


def test_a_smooth_drive_has_no_corners():
    system = ConeModel().system
    assert corner_numbers(system) == {}
    assert corner_times(system, TIMES, TIMES + 1.0, ConeModel().own_numbers) == {}
    assert switches_at(system, TIMES, STATES, ConeModel().own_numbers) == {}


def test_the_corners_of_a_triangle_lie_half_a_period_apart_and_its_slopes_take_turns():
    model = ConeModel(waveform="triangle", drive_frequency=0.8, voltage=0.6)
    system, n, start = model.system, model.members().numbers(), np.array([0.0, 3.0])
    assert corner_numbers(system) == {"pieces": PIECE}
    found = corner_times(system, start, np.array([20.0, 20.0]), n)
    corners = (np.arange(8) + 0.5) * np.pi / 0.8
    for k in range(2):
        own = found["corners"][k][np.isfinite(found["corners"][k])]
        np.testing.assert_allclose(own, corners[(corners > start[k]) & (corners <= 20.0)], rtol=1e-12)
    terms, first = found["terms"]
    slopes = terms[np.arange(2), first, 1]
    np.testing.assert_allclose(slopes, [-2.0 / np.pi, 2.0 / np.pi], rtol=1e-12)  # from pi/2 on down, then up again


def test_switches_are_those_of_film_circuit_and_drive_at_each_members_time():
    model = ConeModel(
        film=Bordered(), waveform="triangle", drive_frequency=0.8, voltage=[0.6, 0.6, 0.9], circuit="amplifier",
        filter_time=0.2, slew_rate=0.4,
    )  # fmt: skip
    states = np.hstack([STATES, [[0.0], [0.5], [0.0]]])
    states[2, 0], states[1, 0] = 1.7, -1.2
    n = model.members().numbers()
    found = switches_at(model.system, TIMES, states, n)
    assert set(found) == {"upper", "lower", "slew_rate_above", "slew_rate_below", *PIECE}
    assert all(value.shape == (3,) for value in found.values())
    np.testing.assert_array_equal(found["upper"], [1.0, 1.0, -1.0])
    np.testing.assert_array_equal(found["lower"], [1.0, -1.0, 1.0])
    command = model.system.waveform.voltage(TIMES, n)
    wanted = (command - states[:, 2]) / 0.2
    np.testing.assert_array_equal(found["slew_rate_above"], np.where(wanted > 0.4, -1.0, 1.0))
    np.testing.assert_array_equal(found["slew_rate_below"], np.where(wanted < -0.4, -1.0, 1.0))
    corners = np.array([-0.5, 0.5, 1.5]) * np.pi / 0.8  # at or before each time lies the last one
    begins = [corners[corners <= time].max() for time in TIMES]
    np.testing.assert_allclose(found["piece_begin"], begins, rtol=1e-12)
    since = 0.8 * (TIMES - found["piece_begin"])
    shape = found["piece_0"] + since * found["piece_1"]
    np.testing.assert_allclose(model.voltage * shape, command, rtol=1e-12, atol=1e-14)
