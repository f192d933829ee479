"""Devices as environments of Gymnasium: what one and many of them hand on of their episodes, and when they begin."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics

import gelcone
from gelcone.learn.environments import ACTIONS, OBSERVATIONS, HeightEnv, HeightVectorEnv
from tests.export.instance import device

UNCERTAIN = {"film_thickness": gelcone.Uniform("0.19 mm", "0.21 mm")}


@pytest.fixture(scope="module")
def taut():
    return device(film="taut")


class Scripted:
    """Episodes that say what they were asked, with rewards and ends by a script."""

    def __init__(self, count, script):
        self.count, self.script, self.begun, self.given = count, list(script), [], []
        self.endings = np.array([f"end of {k}" for k in range(count)])

    def begin(self, where, rng):
        self.begun.append((where.tolist(), rng.integers(1000)))

    def advance(self, actions):
        self.given.append(actions)
        return tuple(np.array(own) for own in self.script.pop(0))

    def observe(self):
        return np.arange(4.0 * self.count).reshape(self.count, 4)


def test_many_begin_anew_in_the_step_after_their_end():
    script = [
        ([-0.5, -0.25, -0.125], [False, True, False], [True, False, False]),
        ([-1.0, -2.0, -0.5], [True, True, True], [True, False, False]),
        ([-0.5, -0.5, -0.5], [False, False, False], [False, False, False]),
    ]
    episodes = Scripted(3, script)
    vector = HeightVectorEnv(episodes)
    seen, info = vector.reset(seed=3)
    assert (seen.tolist(), info) == (episodes.observe().tolist(), {})
    _, reward, terminated, truncated, info = vector.step("first")
    assert reward.tolist() == [-0.5, -0.25, -0.125]
    assert (terminated.tolist(), truncated.tolist()) == ([False, True, False], [True, False, False])
    assert (info["ended"].tolist(), info["_ended"].tolist()) == (episodes.endings.tolist(), [False, True, False])
    _, reward, terminated, truncated, info = vector.step("second")
    assert reward.tolist() == [0.0, 0.0, -0.5]
    assert (terminated.tolist(), truncated.tolist()) == ([False, False, True], [False, False, False])
    assert info["_ended"].tolist() == [False, False, True]
    _, reward, *_, info = vector.step("third")
    assert (reward.tolist(), info) == ([-0.5, -0.5, 0.0], {})
    rng = np.random.default_rng(3)
    first, *later = episodes.begun
    assert first == ([0, 1, 2], rng.integers(1000))
    assert [where for where, _ in later] == [[0, 1], [2]]
    assert later[0][1] == rng.integers(1000)
    assert episodes.given == ["first", "second", "third"]


def test_one_says_why_it_ended():
    episodes = Scripted(1, [([-0.5], [False], [True]), ([-3.0], [True], [False])])
    one = HeightEnv(episodes)
    seen, info = one.reset(seed=3)
    assert (seen.tolist(), info) == ([0.0, 1.0, 2.0, 3.0], {})
    assert episodes.begun == [([0], np.random.default_rng(3).integers(1000))]
    assert one.step("up")[1:] == (-0.5, False, True, {})
    assert one.step("down")[1:] == (-3.0, True, False, {"ended": "end of 0"})
    assert episodes.given == ["up", "down"]


def test_spaces_are_those_of_one_device_and_of_many():
    one, many = HeightEnv(Scripted(1, [])), HeightVectorEnv(Scripted(3, []))
    assert (one.action_space, one.observation_space) == (ACTIONS, OBSERVATIONS)
    assert (many.single_action_space, many.single_observation_space) == (ACTIONS, OBSERVATIONS)
    assert (many.num_envs, many.action_space.shape, many.observation_space.shape) == (3, (3, 1), (3, 4))
    for space, size, end in ((ACTIONS, 1, 1.0), (OBSERVATIONS, 4, 10.0)):
        assert (space.shape, space.dtype) == ((size,), np.float32)
        assert ((space.low == -end).all(), (space.high == end).all()) == (True, True)


def test_a_reset_forgets_which_episodes_were_over(taut):
    """Else those would begin anew once more in the first step, whose action and reward were lost."""
    vector = gelcone.environment(taut, 2, episode="1 ms")
    vector.reset(seed=0)
    *_, truncated, _ = vector.step(np.zeros((2, 1)))
    assert truncated.all()
    vector.reset(seed=1)
    _, reward, _, truncated, _ = vector.step(np.ones((2, 1)))
    assert truncated.all()
    assert (reward < 0.0).all()
    np.testing.assert_allclose(vector.episodes.voltage, vector.episodes.task.highest_voltage)
    vector.step(np.ones((2, 1)))  # a step in which they begin anew, without voltage
    np.testing.assert_array_equal(vector.episodes.voltage, 0.0)


def test_the_checks_of_gymnasium_pass(taut):
    check_env(gelcone.environment(taut, uncertain=UNCERTAIN, draws=16), skip_render_check=True)


def test_a_vector_of_environments_is_one_for_wrappers(taut):
    vector = RecordEpisodeStatistics(gelcone.environment(taut, 3, episode="4 ms"))
    seen, _ = vector.reset(seed=1)
    assert isinstance(vector.unwrapped, gymnasium.vector.VectorEnv)
    assert vector.observation_space.contains(seen)
    total = np.zeros(3)
    for _ in range(4):
        seen, reward, terminated, truncated, info = vector.step(vector.action_space.sample())
        total += reward
        assert vector.observation_space.contains(seen)
        assert not terminated.any()
    assert truncated.all()
    np.testing.assert_allclose(info["episode"]["r"], total)
    assert info["episode"]["l"].tolist() == [4, 4, 4]


def test_one_environment_does_what_one_of_many_does(taut):
    one, many = gelcone.environment(taut), gelcone.environment(taut, 2)
    first, _ = one.reset(seed=5)
    many.reset(seed=5)
    many.episodes.target[:] = one.episodes.target
    assert one.observation_space.contains(first)
    for k in range(20):
        seen, reward, *_ = one.step(np.array([0.1 * k - 1.0], dtype=np.float32))
        others, rewards, *_ = many.step(np.full((2, 1), 0.1 * k - 1.0, dtype=np.float32))
        np.testing.assert_array_equal(others[1], seen)
        assert rewards[0] == reward


def test_many_say_that_each_begins_anew_in_the_step_after_its_end():
    """In the step after an end, whose action and reward count for nothing."""
    assert HeightVectorEnv(Scripted(3, [])).metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
