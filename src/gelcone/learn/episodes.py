"""Episodes of many devices that a controller holds at a height: a learning environment, without its library.

The device of an episode is drawn from a pool of uncertain devices. The integrator advances all devices by the time
between two actions, each from its state and with its numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.atlas.distribution import Distribution
from gelcone.atlas.uncertain import draw
from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, Outcome
from gelcone.devices.device import Device
from gelcone.errors import InputError
from gelcone.motion.flow import smallest_step, steps
from gelcone.motion.natural import natural_frequency
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.physics.driven import INPUTS, DrivenSystem, driven
from gelcone.physics.members import Members
from gelcone.physics.statics import stable_near, switched_off
from gelcone.quantity import Array

Places = npt.NDArray[np.intp]

OBSERVED = ("height", "velocity", "target", "voltage")
LARGEST = 10.0
"""Largest size of an observation."""


@dataclass(frozen=True)
class Task:
    """A task: to hold a height between ``lowest`` and ``highest``, m, with at most the ``highest_voltage``, V, which is
    set every ``period`` seconds, ``steps`` times an episode. ``radian``: the time, s, of a radian of free vibration."""

    highest_voltage: float
    lowest: float
    highest: float
    period: float
    steps: int
    radian: float

    @property
    def span(self) -> float:
        """The range of heights, m."""
        return self.highest - self.lowest


def task_of(
    device: Device, highest_voltage: float | None, heights: tuple[float, float] | None, period: float, episode: float
) -> Task:
    """Make the task of a device. Default ``highest_voltage``: the peak of its drive; default ``heights``: the rests
    without voltage and under ``highest_voltage``. Raises `InputError` for numbers that make no task."""
    model, scales = device.to_model(), device.scales
    if highest_voltage is None:
        highest_voltage = float(model.peak_voltage * scales.voltage)
    if not 0.0 < highest_voltage < np.inf:
        raise InputError(
            f"highest_voltage = {highest_voltage:g} V: must be positive and finite; give the largest voltage"
        )
    if heights is None:
        ramp = stroke_and_blocked_force(model, [0.0, highest_voltage / scales.voltage])
        at = ramp["displacement"].values * scales.length
        if np.isnan(at).any():
            raise InputError(
                f"highest_voltage = {highest_voltage:g} V: no height is held there, for the film pulls in; lower it or "
                "give heights"
            )
        heights = float(at.min()), float(at.max())
    if not (np.isfinite(heights).all() and heights[0] < heights[1]):
        raise InputError(f"heights = {heights}: must be a lower and a higher one; give both, in metres or as texts")
    if not (0.0 < period < np.inf and period <= episode < np.inf):
        raise InputError(f"period = {period:g} s, episode = {episode:g} s: must be positive, and the episode longer")
    omega = float(natural_frequency(model, 0.0))
    radian = scales.time / (omega if omega > 0.0 else 1.0)
    return Task(highest_voltage, *heights, period, round(episode / period), radian)


@dataclass(frozen=True)
class Pool:
    """Drawn devices (draws,): their ``members``, their states at the start, and the scales of their units."""

    members: Members
    system: DrivenSystem
    starts: Array
    length: Array
    velocity: Array
    voltage: Array
    time: Array

    @classmethod
    def of(cls, device: Device, uncertain: Mapping[str, Distribution], count: int, seed: int) -> Pool:
        """Draw ``count`` devices; one if nothing is uncertain. `InputError` if one of them has no rest."""
        drawn = device.replace_quietly(draw(uncertain, count, seed=seed)) if uncertain else device
        model, s = drawn.to_model(), drawn.scales
        system = driven(model.system, breaks_down="dielectric_strength" in model.values)
        members = Members(system, model.members().values, model.size)
        disc = np.empty((members.size, 2))
        disc[:, 1] = drawn.release_velocity / s.velocity
        if drawn.release_height is None:
            disc[:, 0] = _rests(members, device.initial_state()[0] * device.scales.length / s.length)
        else:
            disc[:, 0] = drawn.release_height / s.length
        each = np.ones(members.size)
        return cls(
            members,
            system,
            members.start_states(disc),
            *(each * scale for scale in (s.length, s.velocity, s.voltage, s.time)),
        )

    @cached_property
    def reach(self) -> tuple[Array, Array]:
        """The lowest and highest displacement with a state of all films, m, (draws,) each."""
        films = self.system.films
        ends = np.array([[film.reach(n)[:2] for film in films] for n in map(self.members.numbers_at, range(self.size))])
        return ends[..., 0].max(axis=1) * self.length, ends[..., 1].min(axis=1) * self.length

    @property
    def size(self) -> int:
        """The number of devices."""
        return self.members.size


def _rests(members: Members, near: Any) -> Array:
    """Find the stable rests without voltage near displacements."""
    off = switched_off(members)
    n = off.numbers()
    x, _ = stable_near(np.zeros(members.size) + near, lambda x: off.system.static_force(x, 0.0 * x, n))
    if lost := int(np.isnan(x).sum()):
        raise InputError(
            f"uncertain: {lost} of {members.size} draws have no rest near that of the device; narrow the ranges"
        )
    return x


class Episodes:
    """Episodes of many devices that a controller holds at heights.

    ``displacement``, ``target`` (m) and ``voltage`` (V) are the current ones, (count,) each.
    """

    def __init__(self, pool: Pool, task: Task, count: int, tolerance: float) -> None:
        self.task, self.count = task, count
        self._pool = pool
        span = (task.period / pool.time * pool.members.fastest).max()
        most = STEPS_PER_CALL * max(np.ceil(span / CALL_SPAN), 1.0)
        self._run = steps(pool.system, tolerance, count, float(most))
        self._numbers = np.array([pool.members.own_numbers[name] for name in self._run.numbers])
        zero = np.zeros(pool.size)
        switches = pool.system.switches(zero, list(pool.starts.T), pool.members.own_numbers)
        self._switches = np.stack([zero + switches[name] for name in self._run.switch_names] or [zero], axis=1)
        self._smallest = smallest_step(pool.members)
        self.displacement, self.target, self.voltage, self._velocity = (np.zeros(count) for _ in range(4))
        self._length, self._speed, self._volt, self._low, self._high = (np.ones(count) for _ in range(5))
        self._age = np.zeros(count, dtype=np.int64)

    def begin(self, where: Places, rng: np.random.Generator) -> None:
        """Begin episodes at some places, each with a drawn device of the pool and a drawn height."""
        pool, run, task = self._pool, self._run, self.task
        which = rng.integers(pool.size, size=where.size)
        run.set_all(self._numbers[:, which], where)
        run.states[where] = pool.starts[which]
        if run.switch_names:
            run.switches[where] = self._switches[which]
        run.lengths[where] = task.period / pool.time[which]
        run.smallest_step[where] = self._smallest[which]
        scales = (pool.length, pool.velocity, 1.0 / pool.voltage, *pool.reach)
        kept_scales = (self._length, self._speed, self._volt, self._low, self._high)
        for kept_scale, scale in zip(kept_scales, scales, strict=True):
            kept_scale[where] = scale[which]
        self.target[where] = rng.uniform(task.lowest, task.highest, where.size)
        self.voltage[where], self._age[where] = 0.0, 0
        self.displacement[where] = run.states[where, 0] * self._length[where]
        self._velocity[where] = run.states[where, 1] * self._speed[where]

    def advance(self, actions: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Set the voltages and advance by a period; return rewards, and masks of terminated and truncated episodes.

        An action from -1 to 1 is the squared voltage from 0 to that of ``highest_voltage``. The reward of a step is
        minus the error of the height over the range of heights, at least -1. An episode that terminates early gets -1
        for this step and each step that is left.
        """
        given = np.asarray(actions, dtype=float).reshape(self.count)
        if not np.isfinite(given).all():
            raise InputError("actions: must be finite numbers from -1 to 1")
        task, run = self.task, self._run
        self.voltage = task.highest_voltage * np.sqrt(0.5 + 0.5 * np.clip(given, -1.0, 1.0))
        run.set(INPUTS[0], self.voltage * self._volt)
        self._outcome = run.step()
        self.displacement = run.states[:, 0] * self._length
        self._velocity = run.states[:, 1] * self._speed
        self._age += 1
        inside = (self.displacement >= self._low) & (self.displacement <= self._high)
        terminated = (self._outcome != Outcome.OK) | ~inside
        reward = -np.minimum(np.abs(self.displacement - self.target) / task.span, 1.0)
        if terminated.any():
            reward[terminated] = self._age[terminated] - task.steps - 1.0
        return reward, terminated, (self._age >= task.steps) & ~terminated

    @property
    def endings(self) -> npt.NDArray[np.str_]:
        """Words for the end of each device's motion in the last step; empty where it has not ended."""
        words = np.array([Outcome(code).label if code else "" for code in self._outcome.tolist()], dtype="U16")
        words[(words == "") & ((self.displacement < self._low) | (self.displacement > self._high))] = "stretch_limit"
        words[self._run.broke_down] = "breakdown"
        return words

    def observe(self) -> npt.NDArray[np.float32]:
        """Make the observations of a controller, (count, 4), see `OBSERVED`."""
        task = self.task
        observations = np.empty((self.count, len(OBSERVED)), dtype=np.float32)
        share = 1.0 / task.span
        observations[:, 0] = (self.displacement - task.lowest) * share
        observations[:, 1] = self._velocity * (share * task.radian)
        observations[:, 2] = (self.target - task.lowest) * share
        observations[:, 3] = self.voltage * (1.0 / task.highest_voltage)
        return np.clip(observations, -LARGEST, LARGEST, out=observations)
