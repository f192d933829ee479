"""Largest values of motions between their samples, against formulas of discs that are held."""

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome
from gelcone.motion import peaks
from gelcone.motion.corners import between_corners, sampled_evenly
from gelcone.motion.electrical import charge_of, current_of, field_of
from gelcone.motion.flow import integrate
from gelcone.motion.peaks import largest

HELD = {"rest_height": 0.5, "spring_stiffness": 1e7, "damping_ratio": 20.0, "drive_frequency": 0.7, "film": "taut"}
CAPACITANCE = 1.25
"""Of the taut cone at 0.5, over that of the flat film."""
SAMPLES = 9


def held(**more):
    return gelcone.ConeModel(**HELD, **more)


def few_samples(model, samples=SAMPLES):
    """Members and a period of their motion, whose samples miss the peaks."""
    members = model.members()
    period = np.broadcast_to(members.drive_period, members.shape).ravel()
    times = period[:, None] * (np.arange(1, samples + 1) / samples)
    begin = members.start_states((0.5, 0.0))
    return members, sampled_evenly(times, integrate(members, begin, times).states, begin, 0.0 * period, period)


def between_corners_of(model):
    members = model.members()
    period = np.broadcast_to(members.drive_period, members.shape).ravel()
    return members, between_corners(members, members.start_states((0.5, 0.0)), 0.0 * period, period)


def test_charge_and_current_of_a_held_film_are_those_of_a_capacitor():
    """C (b + A) and C A omega; the disc trembles a little at the start."""
    members, path = few_samples(held(voltage=[0.1, 0.2], voltage_bias=0.4))
    np.testing.assert_allclose(largest(members, path, charge_of), CAPACITANCE * np.array([0.5, 0.6]), rtol=1e-6)
    np.testing.assert_allclose(largest(members, path, current_of), CAPACITANCE * np.array([0.1, 0.2]) * 0.7, rtol=2e-4)
    assert (charge_of(members, path.times, path.states).max(axis=1) < 0.999 * CAPACITANCE * np.array([0.5, 0.6])).all()


def test_a_value_is_exact_at_its_peak_and_near_to_it_at_a_corner():
    members, path = few_samples(held(voltage=0.1))

    def at(members, times, states):
        return np.cos(times - 2.3)

    def cornered(members, times, states):
        return -np.abs(times - 2.3)

    assert largest(members, path, at)[0] == pytest.approx(1.0, abs=1e-12)
    assert -1e-5 < largest(members, path, cornered)[0] <= 0.0


def test_every_peak_that_may_be_the_largest_is_examined():
    """The highest sample lies next to the lower of two peaks."""
    members, path = few_samples(held(voltage=0.1), samples=16)
    spacing = path.times[0, 1] - path.times[0, 0]
    near, between = path.times[0, 3], path.times[0, 10] + 0.5 * spacing

    def two(members, times, states):
        return np.maximum(1.0 - ((times - near) / spacing) ** 2, 1.1 - ((times - between) / spacing) ** 2)

    assert two(members, path.times, path.states).argmax() == 3
    assert largest(members, path, two)[0] == pytest.approx(1.1, rel=1e-9)


def test_a_value_that_stays_equal_is_sampled_once(monkeypatch):
    """As the rate of a constant voltage: no peak rises above equal samples. A plateau has peaks at its ends alone."""
    members, path = few_samples(held(voltage=0.1))
    examined = []
    monkeypatch.setattr(peaks, "_closer", lambda some, states, begin, *_, **__: examined.extend(begin) or begin * 0.0)
    assert largest(members, path, lambda some, times, states: 0.0 * times + 0.3) == [0.3]
    assert examined == []
    first, last = path.times[0, 2], path.times[0, 6]
    largest(members, path, lambda some, times, states: 1.0 * ((times >= first) & (times <= last)))
    assert examined == [path.times[0, 1], path.times[0, 5]]


def test_several_numbers_are_each_as_alone_and_known_samples_are_not_computed_again():
    members, path = few_samples(held(voltage=[0.1, 0.2], voltage_bias=0.4))
    alone = [charge_of, current_of, field_of]
    asked = []

    def together(some, times, states):
        asked.append(times)
        return np.stack([of(some, times, states) for of in alone])

    found = largest(members, path, together)
    assert found.shape == (3, 2)
    for row, of in zip(found, alone, strict=True):
        np.testing.assert_array_equal(row, largest(members, path, of))
    first, rounds = asked[0], len(asked) - 1
    known = together(members, first, np.concatenate([path.begin[:, None], path.states], axis=1))
    asked.clear()
    np.testing.assert_array_equal(largest(members, path, together, known), found)
    assert len(asked) == rounds
    assert (largest(members, path, together, 2.0 * known) == 2.0 * known.max(axis=-1)).all()


@pytest.mark.parametrize("at", [0.0, 0.3, 8.7, 9.0])
def test_peaks_at_both_ends_and_in_the_first_and_last_interval_are_found(at):
    members, path = few_samples(held(voltage=0.1))
    peak = at * path.times[0, 0]
    found = largest(members, path, lambda members, times, states: -((times - peak) ** 2))
    assert found[0] == pytest.approx(0.0, abs=1e-9)


def test_a_value_that_grows_to_the_end_is_that_at_the_end():
    members, path = few_samples(held(voltage=0.1))
    assert largest(members, path, lambda members, times, states: times)[0] == path.end[0] == path.times[0, -1]
    between = between_corners_of(held(voltage=0.1, waveform="triangle"))
    assert largest(*between, lambda members, times, states: times)[0] == between[1].end[0]


def test_a_motion_that_ended_has_no_largest_value_and_nodes_of_no_weight_do_not_count():
    members, path = few_samples(held(voltage=[0.1, 0.1]))
    path.states[0, 5:] = np.nan
    found = largest(members, path, charge_of)
    np.testing.assert_array_equal(np.isnan(found), [True, False])
    weights = path.weights.copy()
    weights[:, 4:] = 0.0
    early = path._replace(weights=weights, end=path.times[:, 3])
    found = largest(members, early, lambda members, times, states: times)
    np.testing.assert_array_equal(found, path.times[:, 3])
    later = path._replace(end=path.end + 0.5)  # samples that leave out the end
    np.testing.assert_array_equal(largest(members, later, lambda members, times, states: times), later.end)


def test_the_current_behind_a_resistance_is_largest_where_a_short_rise_ends():
    """C times the slope times 1 - exp(-t/(R C)) at the end t of the rise, which lasts a third of R C; after a half of
    the period all is as it was but for the plateau's rest, exp(-37)."""
    resistance, rise = 0.05, 0.005
    model = held(waveform="square", duty=0.5, rise=rise, voltage=0.1, voltage_bias=0.4, series_resistance=resistance)
    period = 2.0 * np.pi / 0.7
    slope, lasting = 0.2 / (rise * period), rise * period
    expected = CAPACITANCE * slope * (1.0 - np.exp(-lasting / (resistance * CAPACITANCE)))
    assert float(gelcone.settled(model, (0.5, 0.0))["current"]) == pytest.approx(expected, rel=1e-5)


def test_settled_envelope_and_simulation_have_one_largest_field_charge_and_current():
    """Samples missed 42 % of this current, and a thousandth of the field."""
    device = gelcone.find_device("biased-pump").replace(
        {"film": "taut", "waveform": "square", "waveform.rise": 0.0005, "series_resistance": 2e5, "frequency": 5.0}
    )
    settled, peak = gelcone.settled(device), float(device.voltage_offset + device.voltage_amplitude)
    plane = gelcone.envelope(device, peaks=[0.5 * peak, peak], frequencies=[5.0, 5.5]).isel(drive_frequency=0)
    late = gelcone.simulate(device, times=np.concatenate([[0.0], np.linspace(12.0, 12.4, 200_001)]))
    assert int(late.outcome) == Outcome.OK
    assert float(settled["field"]) == pytest.approx(late["true_field"].values[1:].max(), rel=1e-6)
    assert float(settled["current"]) == pytest.approx(np.abs(late["current"].values[1:]).max(), rel=1e-5)
    assert float(plane["driven_field"][1]) == pytest.approx(float(settled["field"]), rel=1e-9)
    charge = 2.0 * late["field_energy"] * 1e-3 / peak  # the moving disc changes the film's voltage by 1e-5 there
    assert plane["driven_peak_charge"].attrs["units"] == "uC"
    assert float(plane["driven_peak_charge"][1]) == pytest.approx(charge.values[1:].max() * 1e6, rel=1e-5)


def test_of_two_films_the_larger_value_counts():
    model = held(voltage=0.1, voltage_bias=0.4, second_film="taut", second_drive="opposite")
    members, path = few_samples(model)
    fields = [film.true_field for film in members.film_states(path.states, members.voltages(path.times, path.states))]
    np.testing.assert_array_equal(field_of(members, path.times, path.states), np.maximum(*fields))


def test_the_charge_of_a_triangle_is_largest_at_its_corner():
    assert largest(*between_corners_of(held(voltage=0.1, waveform="triangle")), charge_of)[0] == pytest.approx(
        CAPACITANCE * 0.1, rel=1e-6
    )
