"""How long functions are positive along motions, by exact times: against the same integration at many more times."""

import numpy as np
import pytest

from gelcone.motion.dwell import Path, dwell_times
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel

MODEL = ConeModel(damping_ratio=[0.05, 0.2], voltage=0.4, rest_height=0.3, spring_stiffness=2.0, drive_frequency=0.7)
TIMES = np.linspace(0.0, 20.0, 201)


@pytest.fixture(scope="module")
def motion():
    members = MODEL.members()
    run = integrate(MODEL, (0.6, 0.0), np.broadcast_to(TIMES, (2, TIMES.size)))
    return Path(members, run.times, run.states)


def lasted(path, level):
    """Of x above and of x below a level."""

    def functions(members, times, states):
        return np.stack([states[..., 0] - level, level - states[..., 0]])

    return dwell_times(path, functions, functions(path.members, path.times, path.states))


def test_times_above_a_level_are_those_of_a_fine_sampling(motion):
    fine = np.linspace(0.0, 20.0, 400_001)
    x = integrate(MODEL, (0.6, 0.0), np.broadcast_to(fine, (2, fine.size))).states[..., 0]
    found, error = lasted(motion, 0.31)
    np.testing.assert_allclose(found.sum(axis=2)[0], (x > 0.31).mean(axis=1) * 20.0, atol=5e-4)
    np.testing.assert_allclose(found.sum(axis=0), np.broadcast_to(np.diff(TIMES), (2, TIMES.size - 1)), rtol=1e-13)
    assert (error < 1e-4).all()
    halved, _ = lasted(Path(motion.members, motion.times[:, ::2], motion.states[:, ::2]), 0.31)
    assert (np.abs(halved.sum(axis=2) - found.sum(axis=2)) < 1e-4).all()


def test_a_passing_between_two_samples_is_found_from_either_side(motion):
    """Levels just inside of the turning points, by the parabola with the acceleration there; the samples miss it."""
    x, u = motion.states[0, :, 0], motion.states[0, :, 1]
    k = int(np.flatnonzero((u[1:-1] > 0.0) & (u[2:] < 0.0))[2]) + 1
    fine = np.linspace(TIMES[k], TIMES[k + 1], 20_001)
    near = integrate(MODEL.take(0), motion.states[0, k], fine[None], start=TIMES[k]).states[0, :, 0]
    level = 0.5 * (near.max() + max(x[k], x[k + 1]))
    above, below = lasted(motion, level)[0][:, 0, k]
    width = (near > level).mean() * (TIMES[k + 1] - TIMES[k])
    assert 0.0 < width < 0.1
    assert above == pytest.approx(width, abs=1e-5)
    assert below == pytest.approx(TIMES[k + 1] - TIMES[k] - width, abs=1e-5)


def test_where_a_motion_has_ended_nothing_lasts(motion):
    states = motion.states.copy()
    states[1, 50:] = np.nan
    found, _ = lasted(Path(motion.members, motion.times, states), 0.31)
    assert (found[:, 1, 49:] == 0.0).all()
    np.testing.assert_array_equal(found[:, 0], lasted(motion, 0.31)[0][:, 0])


class Alone:
    """Members of which nothing is known but what a path was given."""

    def take(self, rows):
        return self


def sine(times, pace=1.0):
    """x = cos(pace t) at ``times`` (samples,), with its rates."""
    x, u, a = np.cos(pace * times), -pace * np.sin(pace * times), -(pace**2) * np.cos(pace * times)
    path = Path(Alone(), times[None], np.stack([x, u], axis=-1)[None])
    path.__dict__["rates"] = np.stack([u, a], axis=-1)[None]
    return path


@pytest.mark.parametrize("share", [0.15, 0.35, 0.5, 0.65, 0.85])
def test_a_sine_that_turns_between_two_samples_lasts_as_its_arc_cosine_says(share):
    """Above and below of a level that it passes twice there, wherever in the interval it turns, before or behind the
    sample that is closest; samples are not evenly apart."""
    times = np.array([-1.1, -0.8, -0.4, 0.0, 0.4, 0.8, 1.1]) - 0.4 * share
    for level in (0.9998, 0.9995, 0.995):
        path = sine(times)
        if path.states[0, :, 0].max() > level:
            continue
        found, error = lasted(path, level)
        lasts = 2.0 * np.arccos(level)
        assert found[0, 0].sum() == pytest.approx(lasts, rel=1e-3)
        assert found[1, 0].sum() == pytest.approx(np.ptp(times) - lasts, rel=1e-5)
        np.testing.assert_array_equal(np.flatnonzero(found[0, 0]), [3])
        assert (
            error < (0.05 if share != 0.5 else 0.41)
        ).all()  # of samples that are equal nothing says how steep it is
        assert (np.abs(found[:, 0].sum(axis=1) - [lasts, np.ptp(times) - lasts]) <= error[:, 0]).all()


def test_times_and_their_errors_scale_with_the_time():
    """The same motion ten times as slow lasts ten times as long, and its error is ten times as large."""
    times = np.array([-1.1, -0.8, -0.4, 0.0, 0.4, 0.8, 1.1]) - 0.1
    for level in (0.5, 0.996):
        (found, error), (slow, slower) = lasted(sine(times), level), lasted(sine(10.0 * times, 0.1), level)
        np.testing.assert_allclose(slow, 10.0 * found, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(slower, 10.0 * error, rtol=1e-6)
        assert (error > 0.0).all()


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_error_of_a_crossing_is_what_two_polynomials_differ_by_over_how_steep_it_is(share):
    times = np.array([0.3, 0.7, 1.1, 1.5])
    level = (1.0 - share) * np.cos(0.7) + share * np.cos(1.1)
    path = sine(times)
    found, error = lasted(path, level)
    at = found[0, 0, 1] / 0.4
    rough = path.at(np.array([0]), np.array([1]), np.array([at]), cubic=True)[1][0, 0]
    expected = abs(rough - level) / (np.cos(0.7) - np.cos(1.1)) * 0.4
    np.testing.assert_allclose(error[:, 0], expected, rtol=0.3)  # and what the interpolation leaves
    assert expected > 1e-6


def test_the_rates_along_a_path_are_those_of_the_motion_also_where_a_switch_has_changed_its_law():
    """Of an amplifier at its limit of current: differences of samples that are close."""
    model = ConeModel(
        series_resistance=0.5,
        current_limit=0.1,
        voltage=0.4,
        rest_height=0.3,
        spring_stiffness=2.0,
        drive_frequency=0.7,
    )
    times = np.linspace(0.0, 10.0, 5001)[None]
    run = integrate(model, (0.6, 0.0), times)
    free = integrate(model.replace(current_limit=10.0), (0.6, 0.0), times)
    assert np.abs(free.states - run.states).max() > 0.05
    path = Path(model.members(), run.times, run.states)
    differences = (run.states[:, 2:] - run.states[:, :-2]) / (times[0, 2] - times[0, 0])
    off = np.abs(path.rates[0, 1:-1] - differences[0]).max(axis=1)
    assert np.quantile(off, 0.995) < 1e-5  # but where the law changes between two of them


@pytest.mark.parametrize(("last", "duration"), [(-1.5, 0.0), (0.5, 0.5)])
def test_where_a_motion_has_no_rate_at_its_end_a_straight_line_leads_there(last, duration):
    """As where a film has pulled in: between the last two samples its functions are unknown. The first motion has its
    least distance to zero before, the second passes zero there."""
    times, states = np.arange(4.0)[None], np.zeros((1, 4, 2))
    values = np.array([[[-2.0, -1.0, -0.5, last]]])
    path = Path(ConeModel().members(), times, states)

    def functions(members, at, z):
        return np.full((1, *at.shape), -np.inf)

    lasts, error = dwell_times(path, functions, values)
    assert lasts[0, 0].tolist() == [0.0, 0.0, duration]
    assert error[0, 0] == (1.0 if duration else 0.0)
