"""Devices as environments of Gymnasium, one or many at once."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from gelcone.learn.episodes import LARGEST, OBSERVED, Episodes
from gelcone.quantity import Array

ACTIONS = Box(-1.0, 1.0, (1,), np.float32)
OBSERVATIONS = Box(-LARGEST, LARGEST, (len(OBSERVED),), np.float32)


class HeightEnv(gymnasium.Env[Any, Any]):
    """One device of `gelcone.environment`; ``episodes`` has its height, target and voltage in SI units."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, episodes: Episodes) -> None:
        self.episodes = episodes
        self.action_space: Any = ACTIONS
        self.observation_space: Any = OBSERVATIONS

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode."""
        super().reset(seed=seed)
        self.episodes.begin(np.zeros(1, dtype=np.intp), self.np_random)
        return self.episodes.observe()[0], {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Set the voltage and advance by a period."""
        reward, terminated, truncated = self.episodes.advance(action)
        info = {"ended": str(self.episodes.endings[0])} if terminated[0] else {}
        return self.episodes.observe()[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), info


class HeightVectorEnv(VectorEnv[Any, Any, Any]):
    """Many devices of `gelcone.environment`, each of which begins a new episode in the step after the end of the last;
    ``episodes`` has their heights, targets and voltages in SI units."""

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, episodes: Episodes) -> None:
        self.episodes: Episodes = episodes
        self.num_envs: int = episodes.count
        self.single_action_space: Any = ACTIONS
        self.single_observation_space: Any = OBSERVATIONS
        self.action_space: Any = batch_space(ACTIONS, self.num_envs)
        self.observation_space: Any = batch_space(OBSERVATIONS, self.num_envs)
        self._over = np.zeros(self.num_envs, dtype=bool)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of each device."""
        super().reset(seed=seed)
        self.episodes.begin(np.arange(self.num_envs), self.np_random)
        self._over[:] = False
        return self.episodes.observe(), {}

    def step(self, actions: Array) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Set the voltages and advance by a period; devices whose episode has ended begin a new one instead."""
        over = np.flatnonzero(self._over)
        reward, terminated, truncated = self.episodes.advance(actions)
        if over.size:
            self.episodes.begin(over, self.np_random)
            reward[over], terminated[over], truncated[over] = 0.0, False, False
        self._over = terminated | truncated
        info = {"ended": self.episodes.endings, "_ended": terminated} if terminated.any() else {}
        return self.episodes.observe(), reward, terminated, truncated, info
