"""Episodes worked out by hand: a made-up integrator whose states are set, so that every number that is seen is known.

Three devices of the pool differ in every scale; a place of an episode shows which one it has.
"""

import inspect
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.atlas.uncertain import draw
from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, Outcome
from gelcone.errors import InputError
from gelcone.learn import environment as public
from gelcone.learn import episodes as module
from gelcone.learn.environments import HeightEnv, HeightVectorEnv
from gelcone.learn.episodes import INPUTS, LARGEST, OBSERVED, Episodes, Task, task_of
from tests.export.instance import device

TASK = Task(highest_voltage=1000.0, lowest=0.012, highest=0.016, period=0.002, steps=4, radian=0.05)
LENGTH, VELOCITY, VOLTAGE, TIME = (np.array(v) for v in ((0.01, 0.02, 0.04), (1.0, 2.0, 4.0), (500.0, 250.0, 125.0),
                                                         (0.1, 0.2, 0.4)))  # fmt: skip
STARTS = np.array([[1.25, 0.0], [0.65, 0.5], [0.35, -0.25]])
REACH = np.array([0.005, 0.006, 0.007]), np.array([0.02, 0.021, 0.022])


class Run:
    """The integrator: it records what it is given and ends where it was said."""

    numbers, switch_names = ("stiffness", "mass"), ("taut", "slack")

    def __init__(self, count):
        self.states, self.lengths, self.smallest_step = np.zeros((count, 2)), np.zeros(count), np.zeros(count)
        self.switches, self.broke_down = np.zeros((count, 2)), np.zeros(count, dtype=bool)
        self.given, self.own = {}, np.zeros((2, count))
        self.outcomes, self.moves = np.zeros(count, dtype=int), {}

    def set_all(self, values, where):
        self.own[:, where] = values

    def set(self, name, values):
        self.given[name] = values.copy()

    def step(self):
        for place, state in self.moves.items():
            self.states[place] = state
        return self.outcomes.copy()


@pytest.fixture
def made(monkeypatch):
    """Episodes of some places, and the integrator behind them."""

    def make(count, task=TASK):
        asked = []

        def steps(system, tolerance, places, most):
            asked.append((tolerance, places, most))
            return Run(places)

        monkeypatch.setattr(module, "steps", steps)
        monkeypatch.setattr(module, "smallest_step", lambda members: np.array([1e-9, 2e-9, 3e-9]))
        members = SimpleNamespace(
            own_numbers={"stiffness": np.array([1.0, 2.0, 3.0]), "mass": np.array([4.0, 5.0, 6.0])},
            fastest=np.array([3.0, 2.0, 1.0]),
        )
        switches = {"taut": np.array([1.0, -1.0, 1.0]), "slack": np.array([-1.0, 1.0, -1.0])}
        system = SimpleNamespace(switches=lambda t, z, n: switches)
        pool = SimpleNamespace(
            members=members, system=system, starts=STARTS, length=LENGTH, velocity=VELOCITY, voltage=VOLTAGE, time=TIME,
            reach=REACH, size=3,
        )  # fmt: skip
        episodes = Episodes(pool, task, count, 1e-6)
        return episodes, episodes._run, asked

    return make


class Drawn:
    """A generator that draws these devices and these shares of the range of heights."""

    def __init__(self, which, shares):
        self.which, self.shares, self.asked = which, shares, []

    def integers(self, most, size):
        self.asked.append((most, size))
        return np.array(self.which)

    def uniform(self, low, high, size):
        self.asked.append((low, high, size))
        return low + (high - low) * np.array(self.shares)


def test_an_episode_begins_with_the_numbers_of_its_device(made):
    episodes, run, asked = made(3)
    assert asked == [(1e-6, 3, STEPS_PER_CALL * max(np.ceil(0.06 / CALL_SPAN), 1.0))]
    episodes._age[:], episodes.voltage[:] = 3, 900.0
    drawn = Drawn([2, 0], [0.25, 1.0])
    episodes.begin(np.array([0, 2]), drawn)
    assert drawn.asked == [(3, 2), (TASK.lowest, TASK.highest, 2)]
    np.testing.assert_array_equal(run.own, [[3.0, 0.0, 1.0], [6.0, 0.0, 4.0]])
    np.testing.assert_array_equal(run.states, [STARTS[2], [0.0, 0.0], STARTS[0]])
    np.testing.assert_array_equal(run.switches, [[1.0, -1.0], [0.0, 0.0], [1.0, -1.0]])
    np.testing.assert_allclose(run.lengths, [0.002 / 0.4, 0.0, 0.002 / 0.1])
    np.testing.assert_allclose(run.smallest_step, [3e-9, 0.0, 1e-9])
    np.testing.assert_allclose(episodes.target[[0, 2]], [0.013, 0.016])
    np.testing.assert_allclose(episodes.displacement, [0.35 * 0.04, 0.0, 1.25 * 0.01])
    np.testing.assert_array_equal(episodes.voltage, [0.0, 900.0, 0.0])
    np.testing.assert_array_equal(episodes._age, [0, 3, 0])
    np.testing.assert_allclose(episodes._velocity, [-0.25 * 4.0, 0.0, 0.0])


def test_a_long_period_is_given_more_steps(made):
    asked = made(2, Task(1.0, 0.0, 1.0, 100.0 * CALL_SPAN, 5, 1.0))[2]
    assert asked == [(1e-6, 2, STEPS_PER_CALL * np.ceil(100.0 * 3.0 / 0.1))]


@pytest.mark.parametrize(
    ("action", "share"), [(-1.0, 0.0), (0.0, np.sqrt(0.5)), (0.5, np.sqrt(0.75)), (1.0, 1.0), (-9.0, 0.0), (9.0, 1.0)]
)
def test_an_action_is_the_squared_voltage(action, share, made):
    episodes, run, _ = made(2)
    episodes.begin(np.arange(2), Drawn([0, 2], [0.5, 0.5]))
    episodes.advance([[action], [-1.0]])
    np.testing.assert_allclose(episodes.voltage, [1000.0 * share, 0.0])
    np.testing.assert_allclose(run.given[INPUTS[0]], [1000.0 * share / 500.0, 0.0])
    np.testing.assert_allclose(episodes.observe()[:, 3], [share, 0.0], rtol=1e-6)


def test_rewards_observations_and_ends_by_hand(made):
    """Heights from 12 to 16 mm; the second device is 20 mm a unit of length, and 2 m/s a unit of velocity."""
    episodes, run, _ = made(2)
    episodes.begin(np.arange(2), Drawn([0, 1], [0.0, 1.0]))
    run.moves = {0: [1.3, 0.5], 1: [0.7, -0.25]}
    reward, terminated, truncated = episodes.advance([0.0, 0.0])
    np.testing.assert_allclose(reward, [-0.25, -0.5])
    assert (terminated.tolist(), truncated.tolist()) == ([False, False], [False, False])
    wanted = [[0.25, 0.5 * 0.05 / 0.004, 0.0, np.sqrt(0.5)], [0.5, -0.5 * 0.05 / 0.004, 1.0, np.sqrt(0.5)]]
    np.testing.assert_allclose(episodes.observe(), np.clip(wanted, -LARGEST, LARGEST), rtol=1e-6)
    assert OBSERVED == ("height", "velocity", "target", "voltage")
    run.moves = {0: [1.95, 0.0], 1: [0.35, 0.0]}  # farther away than the range of heights
    reward, terminated, _ = episodes.advance([0.0, 0.0])
    np.testing.assert_allclose(reward, [-1.0, -1.0])
    assert not terminated.any()


@pytest.mark.parametrize("ran", [1, 2, 3, 4])
@pytest.mark.parametrize(
    ("outcome", "height", "broke", "word"),
    [
        (Outcome.PULLED_IN, 0.014, False, "pulled_in"),
        (Outcome.STRETCH_LIMIT, 0.014, False, "stretch_limit"),
        (Outcome.OK, 0.0049, False, "stretch_limit"),
        (Outcome.OK, 0.0201, False, "stretch_limit"),
        (Outcome.STRETCH_LIMIT, 0.014, True, "breakdown"),
    ],
)
def test_an_end_costs_one_and_all_that_is_left(outcome, height, broke, word, ran, made):
    """The first of two episodes of four steps ends in its step ``ran``; the other goes on to its time."""
    episodes, run, _ = made(2)
    episodes.begin(np.arange(2), Drawn([0, 0], [0.5, 0.5]))
    run.moves = {0: [1.4, 0.0], 1: [1.4, 0.0]}
    for _ in range(ran - 1):
        reward, terminated, truncated = episodes.advance([0.0, 0.0])
        assert not np.any([terminated, truncated, np.abs(reward) > 1e-12])
    run.moves[0], run.outcomes[0], run.broke_down[0] = [height / 0.01, 0.0], outcome, broke
    reward, terminated, truncated = episodes.advance([0.0, 0.0])
    assert terminated.tolist() == [True, False]
    assert truncated.tolist() == [False, ran == 4]
    np.testing.assert_allclose(reward, [-1.0 - (4 - ran), 0.0], atol=1e-12)
    assert episodes.endings.tolist() == [word, ""]


def test_an_episode_is_over_after_its_steps_and_begins_anew_at_age_zero(made):
    episodes, run, _ = made(1)
    run.moves = {0: [1.4, 0.0]}
    for _ in range(2):
        episodes.begin(np.zeros(1, dtype=int), Drawn([0], [0.5]))
        over = [episodes.advance([0.0])[2].tolist() for _ in range(4)]
        assert over == [[False], [False], [False], [True]]


@pytest.mark.parametrize(("state", "inside"), [(0.5, True), (2.0, True), (0.4999, False), (2.0001, False)])
def test_a_film_is_known_up_to_the_ends_of_its_reach(state, inside, made):
    """From 5 to 20 mm, the ends among them."""
    episodes, run, _ = made(1)
    episodes.begin(np.zeros(1, dtype=int), Drawn([0], [0.5]))
    run.moves = {0: [state, 0.0]}
    assert episodes.advance([0.0])[1].tolist() == [not inside]


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_an_action_must_be_a_number(wrong, made):
    with pytest.raises(InputError, match="must be finite numbers from -1 to 1"):
        made(2)[0].advance([0.0, wrong])


# --- the devices ------------------------------------------------------------------------------------------------------


def test_drawn_devices_begin_each_at_its_own_rest():
    """However far from that of the device."""
    taut = device(film="taut")
    wide = {"spring_rate": gelcone.Uniform(3.0, 60.0), "initial_height": gelcone.Uniform(0.012, 0.03)}
    pool = module.Pool.of(taut, wide, 12, 3)
    rests = gelcone.static(taut.replace_quietly(draw(wide, 12, seed=3)), ["0 V"]).rest_displacement.values
    assert np.ptp(rests) > 5.0
    np.testing.assert_allclose(1e3 * pool.starts[:, 0] * pool.length, rests, rtol=1e-9)
    np.testing.assert_array_equal(pool.starts[:, 1], 0.0)


TWO_RESTS = {"film": "taut", "initial_height": 0.0, "spring_rate": 0.01, "beam_rate": -20.0, "beam_cubic_rate": 4e5}


@pytest.mark.parametrize("beams", [{}, {"beam_rate": gelcone.Uniform(-22.0, -18.0)}])
def test_devices_of_two_rests_begin_at_that_of_the_device_or_where_they_are_released(beams):
    """A buckled beam, whose flat state halfway is unstable. The velocity is that of the release in any case."""
    own = device(**TWO_RESTS, release_velocity=0.25)
    changes = draw(beams, 4, seed=0) if beams else {}
    rests = np.ravel(gelcone.static(own.replace_quietly(changes), ["0 V"]).rest_displacement.values)
    assert (rests > 3.0).all()
    higher = {"release_height": gelcone.Uniform(1e-3, 2e-3)}
    for one, uncertain, heights in (
        (own, beams, 1e-3 * rests),
        (own.replace(release_height="-6 mm"), beams, -6e-3),
        (own, higher, draw(higher, 4, seed=0)["release_height"]),
    ):
        pool = module.Pool.of(one, uncertain, 4, 0)
        assert pool.size == (4 if uncertain else 1)
        np.testing.assert_allclose(pool.starts[:, 0] * pool.length, heights, rtol=1e-9)
        np.testing.assert_allclose(pool.starts[:, 1] * pool.velocity, 0.25, rtol=1e-12)


def test_films_are_known_where_all_of_them_are():
    """Lowest and highest displacement of two films, in metres."""
    ends = [(-1.0, 2.0, None), (-0.5, 3.0, None)]
    films = [SimpleNamespace(reach=lambda n, own=own: own) for own in ends]
    pool = SimpleNamespace(
        system=SimpleNamespace(films=films),
        members=SimpleNamespace(numbers_at=lambda k: k),
        size=2,
        length=np.array([0.01, 0.02]),
    )
    low, high = module.Pool.reach.func(pool)
    np.testing.assert_allclose([low, high], [[-0.005, -0.01], [0.02, 0.04]])


# --- what is asked for ------------------------------------------------------------------------------------------------


@pytest.fixture
def asked(monkeypatch):
    """What `gelcone.environment` asks of task, pool and episodes."""
    found = {}
    tasks, pools = inspect.signature(task_of), inspect.signature(module.Pool.of)

    def task(*given):
        found.update(tasks.bind(*given).arguments)
        return "task"

    def pool(*given):
        found.update(pools.bind(*given).arguments)
        return "pool"

    def of(*given):
        found.update(zip(("pool", "task", "places", "tolerance"), given, strict=True))
        return SimpleNamespace(count=given[2])

    monkeypatch.setattr(public, "task_of", task)
    monkeypatch.setattr(public, "Pool", SimpleNamespace(of=pool))
    monkeypatch.setattr(public, "Episodes", of)
    return found


USUAL = {"highest_voltage": None, "heights": None, "period": 1e-3, "episode": 1.0, "uncertain": {}, "count": 1024,
"seed": 0,
         "places": 1, "tolerance": 1e-7}  # fmt: skip
SPREAD = {"moving_mass": gelcone.Normal(5e-3, 1e-4)}


@pytest.mark.parametrize(
    ("options", "found"),
    [
        ({}, {}),
        ({"count": 3}, {"places": 3}),
        ({"uncertain": SPREAD}, {"uncertain": SPREAD}),
        ({"highest_voltage": "1.5 kV"}, {"highest_voltage": 1500.0}),
        ({"heights": ("12 mm", "14 mm")}, {"heights": (0.012, 0.014)}),
        ({"period": "2 ms"}, {"period": 2e-3}),
        ({"episode": "3 s"}, {"episode": 3.0}),
        ({"draws": 16}, {"count": 16}),
        ({"seed": 7}, {"seed": 7}),
        ({"tolerance": 1e-9}, {"tolerance": 1e-9}),
    ],
)
def test_every_option_reaches_what_it_is_for(options, found, asked):
    device = gelcone.find_device("biased-pump")
    made = gelcone.environment(device, **options)
    assert isinstance(made, HeightVectorEnv if "count" in options else HeightEnv)
    known = asked | {"heights": None if asked["heights"] is None else pytest.approx(asked["heights"])}
    assert (known.pop("pool"), known.pop("task"), known.pop("device")) == ("pool", "task", device)
    assert USUAL | found == known
    assert set(options) <= set(inspect.signature(gelcone.environment).parameters)


@pytest.mark.parametrize(
    ("period", "episode", "steps"), [(1e-3, 0.0106, 11), (1e-3, 0.0104, 10), (0.1, 0.3, 3), (1e-3, 1e-3, 1)]
)
def test_an_episode_has_the_nearest_number_of_periods(period, episode, steps):
    device = gelcone.find_device("biased-pump").replace(film="taut")
    task = task_of(device, 900.0, (0.012, 0.014), period, episode)
    assert task == Task(900.0, 0.012, 0.014, period, steps, task.radian)
    assert task.span == pytest.approx(0.002)
    with pytest.raises(InputError, match="must be positive, and the episode longer"):
        task_of(device, 900.0, (0.012, 0.014), episode * 1.5, episode)
    for wrong in ((0.014, 0.012), (0.012, 0.012), (0.012, np.inf)):
        with pytest.raises(InputError, match="must be a lower and a higher one"):
            task_of(device, 900.0, wrong, period, episode)


def test_default_heights_are_those_under_the_command_which_a_leaking_film_lowers():
    """Through the resistance a fifth of the voltage of the source is lost, and more as the film grows."""
    leak = {"series_resistance": "20 Mohm", "material.resistivity": "1 Gohm m", "film": "taut"}
    leaking = gelcone.find_device("biased-pump").replace(leak)
    model = leaking.to_model()
    gain = abs(complex(model.system.circuit.gain(0.0, model.numbers())))
    assert 0.7 < gain < 0.9
    task = task_of(leaking, 1500.0, None, 2e-3, 0.1)
    rests = gelcone.stroke_and_blocked_force(leaking, [0.0, 1500.0]).displacement.values
    assert [task.lowest, task.highest] == pytest.approx(sorted(1e-3 * rests), rel=1e-9)
    tight = gelcone.stroke_and_blocked_force(leaking.replace({"series_resistance": 0.0}), [0.0, 1500.0 * gain])
    assert rests[0] < rests[1] < tight.displacement.values[1]


def test_what_is_seen_ends_at_ten_ranges_on_either_side(made):
    episodes = made(3)[0]
    episodes.displacement = 12e-3 + 4e-3 * np.array([9.0, 11.0, -11.0])
    np.testing.assert_allclose(episodes.observe()[:, 0], [9.0, 10.0, -10.0], rtol=1e-5)
