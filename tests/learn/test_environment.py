"""A device as a learning environment: the motion is that of the device, and Gymnasium's own checks pass."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelcone
from gelcone.errors import InputError, MissingDependency
from gelcone.export.sources import _kinds
from tests.export.instance import device
from tests.export.test_c import WRINKLING

UNCERTAIN = {
    "film_thickness": gelcone.Uniform("0.19 mm", "0.21 mm"),
    "moving_mass": gelcone.Normal("5 g", "0.2 g"),
}


@pytest.fixture(scope="module")
def taut():
    return device(film="taut")


@pytest.fixture(scope="module")
def wrinkling():
    """Its hoops slacken while the voltage swings."""
    return device(**WRINKLING)


def action(share):
    """The action of a share of the largest voltage."""
    return 2.0 * share**2 - 1.0


def swung(environment, steps, shares=(0.2, 1.0), hold=25):
    """Heights (steps, count), m, under a voltage that jumps between two shares of the largest."""
    count = environment.num_envs
    heights = []
    for k in range(steps):
        environment.step(np.full((count, 1), action(shares[k // hold % 2])))
        heights.append(environment.episodes.displacement.copy())
    return np.array(heights)


def test_a_seed_gives_the_same_episodes(taut):
    vector = gelcone.environment(taut, 8, uncertain=UNCERTAIN, draws=16)
    runs = []
    for seed in (3, 3, 4):
        first, _ = vector.reset(seed=seed)
        runs.append((first, swung(vector, 5)))
    np.testing.assert_array_equal(runs[0][0], runs[1][0])
    np.testing.assert_array_equal(runs[0][1], runs[1][1])
    assert (runs[0][0] != runs[2][0]).any()


# --- the motion -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["taut", "wrinkling"])
def test_the_motion_is_that_of_another_integrator_over_jumps_of_the_voltage(kind, request):
    own = request.getfixturevalue(kind)
    vector = gelcone.environment(own, 2, highest_voltage="1.5 kV", tolerance=1e-12)
    vector.reset(seed=0)
    found = swung(vector, 20, hold=8)
    f, state, right = gelcone.rates(own), gelcone.rates(own).start, []
    for k in range(20):
        volts = 1500.0 * (0.2, 1.0)[k // 8 % 2]
        run = solve_ivp(lambda t, y, v=volts: f(t, y, voltage=v), (0.0, 1e-3), state, rtol=1e-8, atol=1e-11)
        state = run.y[:, -1]
        right.append(state[0])
    np.testing.assert_allclose(found[:, 0], right, rtol=0.0, atol=1e-7 * np.ptp(right))
    np.testing.assert_array_equal(found[:, 0], found[:, 1])


def test_switches_are_carried_across_steps(wrinkling):
    """Without the switches that the step before left, the integrator would have to find the borders anew."""
    vector = gelcone.environment(wrinkling, 1, highest_voltage="1.7 kV", episode="10 s")
    vector.reset(seed=0)
    run, system = vector.episodes._run, vector.episodes._pool.system
    kinds, seen = _kinds(system.films[0], run.switch_names), set()
    for k in range(60):
        vector.step(np.array([[action((0.2, 1.0)[k // 10 % 2])]]))
        n = dict(zip(run.numbers, run._values[:, 0], strict=True))
        right = system.switches(0.0, [np.float64(value) for value in run.states[0]], n)
        found = [
            kinds[sum((sign < 0) << bit for bit, sign in enumerate(signs))]
            for signs in (
                [float(np.ravel(right[name])[0]) for name in run.switch_names],
                run.switches[0].tolist(),
            )
        ]
        assert found[0] == found[1]
        seen.add(found[1])
    assert len(seen) == 2, "taut, and hoops slack"


def test_a_member_has_the_bits_that_it_has_alone(wrinkling):
    many = gelcone.environment(wrinkling, 40, uncertain=UNCERTAIN, draws=40)
    many.reset(seed=2)
    run = many.episodes._run
    lengths = run.lengths.copy()
    found = swung(many, 60)
    one = gelcone.environment(wrinkling, 1, uncertain=UNCERTAIN, draws=40)
    for member in (0, 17, 39):
        one.reset(seed=0)
        alone, pool = one.episodes, one.episodes._pool
        which = int(np.flatnonzero(one.episodes.task.period / pool.time == lengths[member])[0])
        alone.begin(np.zeros(1, dtype=int), _Always(which))
        np.testing.assert_array_equal(swung(one, 60)[:, 0], found[:, member])


class _Always:
    """A generator that draws one device of the pool."""

    def __init__(self, which):
        self._which = which

    def integers(self, _, size):
        return np.full(size, self._which)

    def uniform(self, low, high, size):
        return np.full(size, 0.5 * (low + high))


def test_an_episode_is_that_of_its_device(taut):
    """Drawn devices move like devices that are made one by one."""
    vector = gelcone.environment(taut, 4, uncertain=UNCERTAIN, draws=4, tolerance=1e-12)
    drawn = gelcone.draw(UNCERTAIN, 4, seed=0)
    vector.episodes.begin(np.arange(4), np.random.default_rng(0))
    which = np.random.default_rng(0).integers(4, size=4)
    found = swung(vector, 30)
    highest_voltage = vector.episodes.task.highest_voltage
    for member, k in enumerate(which):
        own = taut.replace({name: float(values[k]) for name, values in drawn.items()})
        one = gelcone.environment(own, 1, highest_voltage=highest_voltage, heights=("12 mm", "14 mm"), tolerance=1e-12)
        one.reset(seed=0)
        np.testing.assert_allclose(swung(one, 30)[:, 0], found[:, member], rtol=1e-12)


def test_the_devices_are_those_that_the_seed_draws(taut):
    for seed in (0, 5):
        pool = gelcone.environment(taut, 2, uncertain=UNCERTAIN, draws=4, seed=seed).episodes._pool
        drawn = gelcone.draw(UNCERTAIN, 4, seed=seed)
        own = [taut.replace({name: float(values[k]) for name, values in drawn.items()}) for k in range(4)]
        np.testing.assert_allclose(pool.time, [one.scales.time for one in own], rtol=1e-12)


def test_what_is_seen_and_earned_follows_from_the_motion(taut):
    vector = gelcone.environment(taut, 2, heights=("12 mm", "14 mm"), highest_voltage="1 kV")
    vector.reset(seed=0)
    seen, reward, *_ = vector.step(np.array([[0.0], [0.5]]))
    own = vector.episodes
    np.testing.assert_allclose(own.voltage, 1000.0 * np.sqrt([0.5, 0.75]))
    np.testing.assert_allclose(seen[:, 0], (own.displacement - 12e-3) / 2e-3, rtol=1e-6)
    speed = own._run.states[:, 1] * taut.scales.velocity
    np.testing.assert_allclose(seen[:, 1], speed / (2e-3 / own.task.radian), rtol=1e-6)
    assert (np.abs(speed) > 0.0).all()
    np.testing.assert_allclose(seen[:, 2], (own.target - 12e-3) / 2e-3, rtol=1e-6)
    np.testing.assert_allclose(seen[:, 3], own.voltage / 1000.0, rtol=1e-6)
    np.testing.assert_allclose(reward, -np.abs(own.displacement - own.target) / 2e-3)
    assert ((own.target >= 12e-3) & (own.target <= 14e-3)).all()


def test_the_default_largest_voltage_is_the_peak_of_the_devices_own_drive():
    own = device(film="taut", voltage_amplitude=200.0, voltage_offset=-700.0)
    assert gelcone.environment(own).episodes.task.highest_voltage == pytest.approx(900.0)


def test_the_default_heights_are_those_that_the_device_can_hold(taut):
    task = gelcone.environment(taut, highest_voltage="1 kV").episodes.task
    static = gelcone.stroke_and_blocked_force(taut, ["0 V", "1 kV"])
    np.testing.assert_allclose(1e3 * np.array([task.lowest, task.highest]), static.displacement.values)
    linear = gelcone.state_space(taut, voltage=0.0)
    assert 1.0 / task.radian == pytest.approx(np.sqrt(-linear.A[1, 0]))


def test_behind_a_leak_the_highest_height_is_that_of_the_voltage_that_is_left(taut):
    behind = taut.replace_quietly({"series_resistance": "100 MOhm", "material.resistivity": 2e7})
    task = gelcone.environment(behind, highest_voltage="1 kV").episodes.task
    held = gelcone.stroke_and_blocked_force(behind, [0.0, 1e3]).displacement.values
    np.testing.assert_allclose(1e3 * np.array([task.lowest, task.highest]), held)
    plain = gelcone.stroke_and_blocked_force(taut, [0.0, 1e3]).displacement.values
    assert held[0] < held[1] < plain[1]


# --- where it ends ----------------------------------------------------------------------------------------------------


def test_pull_in_terminates_costs_what_is_left_and_begins_anew():
    own = device(film="wrinkling", voltage_amplitude=0.0, voltage_offset=2700.0)
    vector = gelcone.environment(own, 2, highest_voltage="2.7 kV", heights=("12 mm", "14 mm"), episode="0.1 s")
    rest, _ = vector.reset(seed=0)
    for steps in range(1, 100):  # noqa: B007
        seen, reward, terminated, truncated, info = vector.step(np.array([[1.0], [-1.0]]))
        if terminated.any():
            break
    assert terminated.tolist() == [True, False]
    assert not truncated.any()
    assert info["ended"].tolist() == ["pulled_in", ""]
    assert reward[0] == pytest.approx(-(100 - steps) - 1.0)
    model = own.to_model()
    run = gelcone.integrate(model, own.initial_state(), [0.1 / own.scales.time], tolerance=1e-7)
    assert steps == int(np.ceil(1e3 * own.scales.time * run.end_times[0])) > 2, "a step is a millisecond"
    seen, reward, terminated, _, info = vector.step(np.array([[1.0], [-1.0]]))
    assert reward[0] == 0.0
    assert not terminated.any()
    assert info == {}
    np.testing.assert_array_equal(seen[0, :2], rest[0, :2])


def test_breakdown_terminates_where_the_true_field_is_the_strength(taut):
    strength = 6.4e6
    one = gelcone.environment(
        taut.replace(dielectric_strength=strength), highest_voltage="1.1 kV", heights=("12 mm", "14 mm")
    )
    one.reset(seed=0)
    for steps in range(1, 100):  # noqa: B007
        *_, terminated, _, info = one.step(np.array([1.0]))
        if terminated:
            break
    assert steps > 2
    assert info == {"ended": "breakdown"}
    own = one.episodes
    model, s = taut.to_model(), taut.scales
    state = model.film_state(own.displacement[0] / s.length, own.voltage[0] / s.voltage)
    field = float(state.true_field) * s.field
    assert field == pytest.approx(strength, rel=1e-6)


@pytest.mark.parametrize("side", ["_low", "_high"])
def test_a_height_at_which_a_film_is_not_known_terminates(taut, side):
    """The range is moved so that the second of two equal devices lies beyond one of its ends, in the last step of the
    first one's episode."""
    vector = gelcone.environment(taut, 2, heights=("12 mm", "14 mm"), highest_voltage="1 kV")
    vector.reset(seed=0)
    own = vector.episodes
    getattr(own, side)[1] = own.displacement[1] + (1e-3 if side == "_low" else -1e-3)
    own._age[0] = own.task.steps - 1
    _, reward, terminated, truncated, info = vector.step(np.full((2, 1), -1.0))
    assert terminated.tolist() == [False, True]
    assert truncated.tolist() == [True, False]
    assert info["ended"].tolist() == ["", "stretch_limit"]
    assert info["_ended"].tolist() == [False, True]
    assert reward[1] == 1 - own.task.steps - 1.0


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"count": 0}, "count = 0"),
        ({"count": 1.5}, r"count = 1\.5: must be a whole number, at least 1"),
        ({"draws": 1}, "draws = 1: must be at least 2"),
        ({"tolerance": -1.0}, r"tolerance = -1\.0"),
        ({"tolerance": 0.0}, r"tolerance = 0\.0"),
        ({"highest_voltage": "0 V"}, "highest_voltage = 0 V"),
        ({"highest_voltage": "1 mm"}, "highest_voltage"),
        ({"highest_voltage": "9 kV"}, "pulls in"),
        ({"heights": ("14 mm", "12 mm")}, "heights"),
        ({"period": "0 s"}, "period"),
        ({"period": "2 s"}, "period"),
        ({"uncertain": {"spring_rate": gelcone.Uniform(-50.0, -40.0)}}, "spring_rate"),
        ({"uncertain": {"no_such": gelcone.Uniform(1.0, 2.0)}}, "no_such"),
    ],
)
def test_what_is_no_task_is_refused(wrinkling, options, match):
    with pytest.raises(InputError, match=match):
        gelcone.environment(wrinkling, **options)


def test_an_action_that_is_no_number_is_refused(taut):
    vector = gelcone.environment(taut, 2)
    vector.reset(seed=0)
    with pytest.raises(InputError, match="finite"):
        vector.step(np.array([[np.nan], [0.0]]))


def test_an_ensemble_is_refused():
    with pytest.raises(InputError, match="takes one actuator, not an ensemble of 2"):
        gelcone.environment(device(film_thickness=[1.9e-4, 2e-4]))


def test_without_gymnasium_the_remedy_is_named(taut, monkeypatch):
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    for name in [name for name in sys.modules if name == "gelcone.learn.environments"]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(MissingDependency, match=r"gelcone\[learn\]"):
        gelcone.environment(taut)
