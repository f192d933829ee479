"""Jumps of the voltage: which corners are jumps, and what a source gives and loses in them."""

import numpy as np
import pytest

from gelcone.codes import FilmPullIn, Outcome
from gelcone.motion.delivery import lost_in_jumps, switched
from gelcone.motion.job import Job, Trajectories
from gelcone.motion.jumps import end_films, increasing, jumping, jumps_between
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import PlacedFilm
from gelcone.physics.waveforms import Samples, Staircase
from tests.recorded import numbers

HELD = {"film": "taut", "spring_stiffness": 1e8, "rest_height": 0.5, "damping_ratio": 1.0}
"""A disc that does not move: the film is a capacitor of 1 + 0.5^2."""
SQUARE = HELD | {"waveform": "square", "rise": 0.0, "duty": 0.3, "voltage": 0.4, "voltage_bias": 0.25}
C = 1.25


def test_corners_at_which_the_voltage_jumps_are_told_from_the_others():
    """One staircase that jumps to three of its levels, of members at two frequencies and until two times."""
    model = ConeModel(
        waveform=Staircase((0.5, 0.5, -0.25, 1.0), 0.0),
        voltage=[0.4, 0.8],
        voltage_bias=0.1,
        drive_frequency=[0.5, 2.0],
    )
    members, period = model.members(), 2.0 * np.pi / np.array([0.5, 2.0])
    start, end = np.array([0.1, 0.3]) * period, np.array([1.3, 1.6]) * period
    found = jumps_between(members, start, end)
    shares = [np.array([0.5, 0.75, 1.0]), np.array([0.5, 0.75, 1.0, 1.5])]
    for i, own in enumerate(shares):
        there = found.there[i]
        np.testing.assert_allclose(found.times[i][there], own * period[i], rtol=1e-12)
        assert np.isinf(found.times[i][~there]).all()
        assert there.tolist() == [True] * own.size + [False] * (there.size - own.size)
        levels = np.array([0.5, -0.25, 1.0, 0.5, -0.25])[: own.size + 1]
        np.testing.assert_allclose(found.before[i][there], 0.1 + model.voltage[i] * levels[:-1])
        np.testing.assert_allclose(found.after[i][there], 0.1 + model.voltage[i] * levels[1:])


def test_a_drive_that_bends_and_one_that_is_smooth_have_no_jumps():
    for waveform in ("triangle", "trapezoid", Samples((0.0, 0.4, 1.0), (0.0, 1.0, 0.0), repeat=True)):
        members = ConeModel(waveform=waveform).members()
        assert not jumps_between(members, np.zeros(1), 3.0 * members.drive_period).there.any()
    assert jumping(ConeModel().system) == []
    assert len(jumping(ConeModel(waveform="square").system)) == 1
    assert jumping(ConeModel(waveform="square", circuit="amplifier").system) == []
    pair = ConeModel(waveform="square", second_film="taut", second_drive="constant", second_voltage=0.3)
    assert [line.films for line in jumping(pair.system)] == [(0,)]


def test_times_that_are_infinite_lie_behind_the_end_and_increase():
    times = np.array([[1.0, 2.0, np.inf, np.inf], [0.5, np.inf, np.inf, np.inf]])
    found = increasing(times, np.array([2.5, 7.0]))
    np.testing.assert_array_equal(found[np.isfinite(times)], times[np.isfinite(times)])
    assert (np.diff(found, axis=1) > 0.0).all()
    assert (found[~np.isfinite(times)] > np.repeat([2.5, 7.0], [2, 3])).all()


@pytest.mark.parametrize(
    ("more", "capacitance", "swing"),
    [
        ({}, C, 0.8),
        ({"second_film": "taut"}, 2.0 * C, 0.8),
        ({"second_film": "taut", "second_drive": "opposite"}, 2.0 * C, 0.8),
        ({"second_film": "taut", "second_drive": "constant", "second_voltage": 0.3}, C, 0.8),
        ({"circuit": "amplifier", "dielectric_share": 0.4, "dielectric_time": 1e9}, 0.6 * C, 0.8),
    ],
)
def test_a_capacitor_that_jumps_loses_half_its_capacitance_times_the_square_of_the_jump(more, capacitance, swing):
    """The source gives v+ C (v+ - v-), which is lost but for what is stored; a jump counts from its own time on. Of a
    permittivity that follows late only the rest is charged at once."""
    members = ConeModel(**SQUARE, **more).members()
    period = float(members.drive_period[0])
    states = np.array([[0.5, 0.0, *[0.0] * (len(members.system.states) - 2)]])
    jumps = jumps_between(members, np.zeros(1), np.array([2.2 * period])).times[0]
    assert jumps.size >= 4
    times = np.sort(np.concatenate([[0.25 * jumps[0]], jumps, 0.5 * (jumps[1:] + jumps[:-1]), [2.2 * period]]))
    work, lost = switched(members, states, times[None])
    count = np.searchsorted(jumps, times, side="right")
    np.testing.assert_allclose(lost[0], count * 0.5 * capacitance * swing**2, rtol=1e-6)
    steps = np.where(np.arange(jumps.size) % 2 == 0, -1.0, 1.0)  # it begins high
    one = {1.0: 0.65 * swing, -1.0: 0.15 * swing}  # v+ (v+ - v-) up to 0.65 and down to -0.15
    other = {1.0: 0.15 * swing, -1.0: 0.65 * swing} if more.get("second_drive") == "opposite" else one
    given = np.array([0.5 * capacitance * (one[k] + other[k]) for k in steps])
    np.testing.assert_allclose(work[0], np.append(0.0, np.cumsum(given))[count], rtol=1e-6)


def test_over_whole_repeats_the_jump_at_the_end_counts_and_the_one_at_the_start_does_not():
    """The ramp falls once a repeat, where it begins anew: by 0.8."""
    members = ConeModel(
        **HELD | {"waveform": "ramp", "fall": 0.0, "voltage": 0.4, "drive_frequency": [0.5, 1.0]}
    ).members()
    begin = np.tile([0.5, 0.0], (2, 1))
    for count in (1, 3):
        found = lost_in_jumps(members, begin, count * members.drive_period)
        np.testing.assert_allclose(found, count * 0.5 * C * 0.8**2, rtol=1e-6)


def test_behind_a_resistance_nothing_is_lost_in_jumps():
    members = ConeModel(**SQUARE, circuit="amplifier", series_resistance=0.5).members()
    work, lost = switched(members, np.array([[0.5, 0.0, 0.0]]), np.array([[1.0, 9.0]]))
    assert not work.any()
    assert not lost.any()


# --- what a jump ends -------------------------------------------------------------------------------------------------


def test_a_film_that_does_not_survive_a_jump_ends_its_member_there(monkeypatch):
    """Of four members that rise to 0.65 at 1 and 2 and fall to -0.15 at 0.5 and 1.5, the first is not looked at, the
    second ends at the second rise, the third by its second film at the first, the fourth would only at a fall."""
    drive = {"waveform": "square", "rise": 0.0, "duty": 0.5, "voltage": 0.4, "voltage_bias": 0.25}
    films = {"film": "wrinkling", "second_film": "wrinkling", "viscous_modulus_1": 0.5, "relaxation_time_1": 4.0}
    model = ConeModel(**drive, **films, drive_frequency=2.0 * np.pi, damping_ratio=[0.1, 0.2, 0.3, 0.4])
    members, asked = model.members(), []
    times, runs = np.tile([0.75, 1.25, 2.25], (4, 1)), np.array([True, True, True, True])
    result = Trajectories.blank(times, members.system, "states", np.zeros(4, dtype=np.int8))
    result.states[:] = numbers(4, 3, 6)
    result.film_times[:], result.pull_in[:] = 0.5, 3
    result.film_times[0] = 0.0
    job = Job(members, runs, numbers(4, 6, at=50.0), np.zeros(4), times, np.diff(times, axis=1, prepend=0.0),
              "states", 2e-9, result)  # fmt: skip
    most = np.full((2, 3, 4), 9.0)
    most[0, 0, 3] = most[0, 1, 3] = most[1, 1, 1] = 0.4  # below the square of 0.65
    most[0, 2, [0, 2]] = 0.01  # below that of -0.15, but voltages fall there
    films_asked = []

    def highest(film, x, states, n):
        films_asked.append((x.shape, [z.shape for z in states]))
        return most[len(films_asked) - 1]

    def run(other):
        asked.append((other.members.size, other.start.tolist(), other.times.tolist(), other.states0.tolist()))
        other.result.states[:] = numbers(*other.result.states.shape, at=100.0 * len(asked))
        other.result.steps[:] = 10 * len(asked) + np.arange(other.members.size)
        other.result.film_times[:] = numbers(*other.result.film_times.shape, at=7.0)

    monkeypatch.setattr(PlacedFilm, "highest_squared_held", highest, raising=False)
    end_films(job, run)
    corners = [0.5, 1.0, 1.5, 2.0]
    at = numbers(4, 6, at=50.0).tolist()
    assert asked == [(3, [0.0] * 3, [corners] * 3, at[1:]), (2, [0.0] * 2, [[2.0], [1.0]], at[1:3])]
    assert films_asked == [((3, 4), [(3, 4)] * 2)] * 2
    expected = numbers(4, 3, 6)
    expected[1, 2] = expected[2, 1:] = np.nan
    np.testing.assert_array_equal(result.states, expected)
    assert result.outcome.tolist() == [0, Outcome.PULLED_IN, Outcome.PULLED_IN, 0]
    assert result.steps.tolist() == [0, 20, 21, 0]
    assert result.end_times[1:3].tolist() == [2.0, 1.0]
    np.testing.assert_array_equal(result.end_states[1:3], numbers(2, 1, 6, at=200.0)[:, 0])
    np.testing.assert_array_equal(result.film_times[1:3], numbers(*result.film_times[1:3].shape, at=7.0))
    assert (result.film_times[0] == 0.0).all()
    assert (result.film_times[3] == 0.5).all()
    none, minimum = int(FilmPullIn.NONE), int(FilmPullIn.MINIMUM)
    assert result.pull_in.tolist() == [[3, 3], [minimum, none], [none, minimum], [3, 3]]
