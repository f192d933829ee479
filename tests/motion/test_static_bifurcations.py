"""Static bifurcations: folds and pitchforks where theory has them, pull-in where a slow ramp jumps."""

import numpy as np
import pytest

from gelcone import (
    ConeModel,
    InputError,
    Outcome,
    PullIn,
    fold_voltages,
    limits,
    pitchfork_voltage,
    pull_in_voltage,
    static,
    stroke_and_blocked_force,
)
from gelcone.motion.operating_limits import _limit
from gelcone.motion.plane import Plane
from gelcone.motion.static_limits import STATIC_LIMITS, static_limits_of
from tests.motion.balances import SOFTENING, TABLE1, random_model, settled


def test_the_pitchfork_is_the_root_of_the_small_signal_stiffness():
    assert pitchfork_voltage(TABLE1).pitchfork_voltage == np.sqrt(1.5)
    model = ConeModel(prestretch=[0.9, 1.0, 1.3], spring_stiffness=1.0, prestretch_mode="equibiaxial")
    A = B = np.array([0.9, 1.0, 1.3]) ** 2
    G = 1.0 / (A * B)
    expected = np.sqrt(1.0 + (A - G) / (1.0 - (A + B + G - 3.0) / 50.0))
    np.testing.assert_allclose(pitchfork_voltage(model).pitchfork_voltage, expected, rtol=1e-14)
    np.testing.assert_allclose(static(model, [0.0]).pitchfork_voltage, expected, rtol=1e-14)


def test_the_pitchfork_of_a_raised_pair_of_films_is_where_the_disc_leaves_their_middle():
    """There the stiffnesses of both films and of the spring, whose rest is the middle, add up to none."""
    heights, film, h = np.array([0.8, 1.0]), ConeModel(spring_stiffness=0.0), 1e-4
    pair = ConeModel(spring_stiffness=1.5, second_film="taut", second_flat_height=heights, rest_height=0.5 * heights)
    found = pitchfork_voltage(pair)
    np.testing.assert_allclose(found.pitchfork_displacement, 0.5 * heights)
    for x, v in zip(0.5 * heights, found.pitchfork_voltage.values, strict=True):
        slope = (float(film.force(x + h, v)) - float(film.force(x - h, v))) / (2.0 * h)
        assert 1.5 + 2.0 * slope == pytest.approx(0.0, abs=1e-6)
    aside = pitchfork_voltage(pair.replace(rest_height=0.3))
    assert np.isnan(aside.pitchfork_voltage).all()
    assert np.isnan(aside.pitchfork_displacement).all()


@pytest.mark.parametrize("changes", [{"rest_height": 0.1}, {"prestretch": 0.6, "spring_stiffness": 0.1}])
def test_there_is_no_pitchfork_without_a_stable_flat_film(changes):
    found = pitchfork_voltage(TABLE1.replace(**changes))
    assert np.isnan(found.pitchfork_voltage)
    assert np.isnan(found.pitchfork_displacement)


BISTABLE = {"bias": "beam", "beam_stiffness": -1.5, "beam_cubic": 2.0, "beam_height": 0.0}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [({}, np.sqrt(1.5)), (BISTABLE, np.nan), ({"film": "wrinkling"}, np.inf), ({"rest_height": 0.3}, np.nan)],
)
def test_every_command_has_one_voltage_and_one_word_for_a_pitchfork(changes, expected):
    """Of a flat film that buckles, one that is unstable without voltage, one that pulls in before, and a raised one."""
    model = ConeModel(voltage=0.1, **changes)
    answers = [static(model, [0.0]), limits(model), pitchfork_voltage(model)]
    for found in answers:
        np.testing.assert_allclose(float(found["pitchfork_voltage"]), expected)
    np.testing.assert_allclose(static_limits_of(Plane.of(model, None))[STATIC_LIMITS.index("pitchfork")], expected)
    assert np.isnan(answers[0]["pitchfork_displacement"]) == (not np.isfinite(expected))
    words = [{name: v for name, v in found["pitchfork_voltage"].attrs.items() if "_means" in name} for found in answers]
    own = {name: v for name, v in _limit("pitchfork", "").items() if "_means" in name}
    assert words[0] == words[1] == words[2] == own
    assert words[0] == {"nan_means": "not applicable", "infinite_means": "none before pull-in"}


def test_a_member_that_reaches_nothing_has_no_pitchfork_and_says_so():
    """Alone it is refused, as by the other statics."""
    found = pitchfork_voltage(ConeModel(prestretch=1.3, stretch_limit=[0.1, 50.0]))
    assert found.outcome.values.tolist() == [Outcome.OUTSIDE, Outcome.OK]
    assert np.isfinite(found.pitchfork_voltage).values.tolist() == [False, True]
    for function in (pitchfork_voltage, pull_in_voltage):
        with pytest.raises(InputError, match=r"stretch_limit = 0\.1"):
            function(ConeModel(prestretch=1.3, stretch_limit=0.1))


@pytest.mark.parametrize("seed", range(12))
def test_folds_are_the_extrema_of_the_voltage_along_the_equilibria(seed):
    """v^2 = force without voltage over displacement: its extrema on a fine grid, by brute force."""
    model = random_model(np.random.default_rng(100 + seed))
    model = model.replace(rest_height=0.2) if seed % 2 else model
    folds = fold_voltages(model)
    found = np.sort(folds.fold_displacement.values[np.abs(folds.fold_displacement.values) < 20.0])
    expected = []
    for side in (-1.0, 1.0):
        x = side * np.linspace(0.02, 20.0, 400_001)
        w = model.force(x) / x
        rising = np.sign(np.diff(w))
        turn = 1 + np.flatnonzero(rising[:-1] * rising[1:] < 0)
        expected += [a for a, v in zip(x[turn], w[turn], strict=True) if v >= 0.0]
    np.testing.assert_allclose(found[np.abs(found) > 0.02], np.sort(expected), atol=2e-3)
    np.testing.assert_allclose(
        folds.fold_voltage**2, model.force(folds.fold_displacement.values) / folds.fold_displacement, atol=1e-10
    )


def test_pull_in_in_a_fold_is_where_a_slow_ramp_jumps_and_to_where():
    result = pull_in_voltage(SOFTENING)
    assert PullIn(int(result.pull_in_kind)) == PullIn.FOLD
    voltage = float(result.pull_in_voltage)
    ramp = np.append(np.linspace(0.5, 0.99, 4), 1.01) * voltage
    place = settled(SOFTENING, ramp, float(result.rest_displacement))
    expected = stroke_and_blocked_force(SOFTENING, ramp)
    np.testing.assert_allclose(place, expected.displacement, atol=1e-6)
    assert expected.losses.values.tolist() == [0, 0, 0, 0, 1]
    assert place[-2] < float(result.pull_in_from) < float(result.pull_in_to) < place[-1]
    assert SOFTENING.force(float(result.pull_in_to), voltage) == pytest.approx(0.0, abs=1e-10)


def test_a_slow_ramp_leaves_the_flat_film_gradually_in_a_pitchfork_which_is_no_pull_in():
    result, voltage = pull_in_voltage(TABLE1), float(pitchfork_voltage(TABLE1).pitchfork_voltage)
    assert PullIn(int(result.pull_in_kind)) == PullIn.NEVER
    assert (voltage, float(result.pull_in_voltage)) == (np.sqrt(1.5), np.inf)
    ramp = np.array([0.9, 0.99, 1.06, 1.2]) * voltage
    place = settled(TABLE1, ramp, 0.0)
    np.testing.assert_allclose(place, stroke_and_blocked_force(TABLE1, ramp).displacement, atol=1e-6)
    assert (np.abs(place[:2]) < 1e-6).all()
    assert (place[2:] > 0.1).all()


def test_a_subcritical_pitchfork_jumps():
    model = SOFTENING.replace(
        rest_height=0.0, yeoh_c2=-0.25, yeoh_c3=0.03, prestretch=1.5, prestretch_mode="equibiaxial"
    )
    result = pull_in_voltage(model)
    assert PullIn(int(result.pull_in_kind)) == PullIn.PITCHFORK
    assert float(result.pull_in_voltage) == pitchfork_voltage(model).pitchfork_voltage
    voltage = float(result.pull_in_voltage)
    assert float(result.pull_in_to) > 0.9
    jumped = settled(model, [1.03 * voltage], 0.0)
    np.testing.assert_allclose(jumped, stroke_and_blocked_force(model, 1.03 * voltage).displacement, atol=1e-6)
    assert model.force(float(result.pull_in_to), float(result.pull_in_voltage)) == pytest.approx(0.0, abs=1e-10)


def test_a_lifted_gent_film_never_pulls_in_and_an_unlimited_one_runs_away():
    lifted = pull_in_voltage(TABLE1.replace(rest_height=0.1))
    assert PullIn(int(lifted.pull_in_kind)) == PullIn.NEVER
    assert float(lifted.pull_in_voltage) == np.inf
    away = pull_in_voltage(ConeModel(law="neo-hookean", spring_stiffness=1.5, rest_height=0.1))
    assert PullIn(int(away.pull_in_kind)) == PullIn.RUNAWAY
    assert float(away.pull_in_voltage) == pytest.approx(np.sqrt(2.5), rel=1e-4)
    assert float(away.pull_in_to) == np.inf


def test_a_film_that_is_unstable_when_flat_starts_from_the_side_asked_for():
    buckled = TABLE1.replace(prestretch=0.6, spring_stiffness=0.1)
    up, down = (pull_in_voltage(buckled, start=side) for side in (0.5, -0.5))
    assert float(up.rest_displacement) == -float(down.rest_displacement) > 0.0
    assert float(pull_in_voltage(buckled).rest_displacement) == float(up.rest_displacement)
