"""The public function `environment`, a device that a controller learns to drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gelcone.atlas.distribution import Distribution
from gelcone.devices.analysis import check_device
from gelcone.devices.device import Device
from gelcone.devices.units import parse
from gelcone.errors import MissingDependency
from gelcone.learn.episodes import Episodes, Pool, task_of
from gelcone.motion.flow import check_flow
from gelcone.quantity import check_count

if TYPE_CHECKING:
    from gelcone.learn.environments import HeightEnv, HeightVectorEnv

TOLERANCE = 1e-7
"""Relative error of a step of the integrator."""


def environment(
    device: Device,
    count: int | None = None,
    *,
    uncertain: Mapping[str, Distribution] | None = None,
    highest_voltage: float | str | None = None,
    heights: tuple[float | str, float | str] | None = None,
    period: float | str = "1 ms",
    episode: float | str = "1 s",
    draws: int = 1024,
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> HeightEnv | HeightVectorEnv:
    """Make an environment of Gymnasium in which a controller holds the disc of a device at a height.

    An episode draws a device and a height. The observation is height, velocity, wanted height and voltage: heights from
    0 to 1 over ``heights``, the velocity as their change in a radian of the free vibration, the voltage over
    ``highest_voltage``. The action, from -1 to 1, is the squared voltage, to which the force is proportional, from 0 to
    that of ``highest_voltage``. The reward of a step is minus the error of the height over the range of heights, at
    least -1. An episode is terminated if the film pulls in, breaks down or reaches its stretch limit, with a reward of
    -1 for each step that is left.

    Parameters
    ----------
    device : a device of single numbers, with any film and circuit.
    count : number of devices in a ``gymnasium.vector.VectorEnv``. Default None: one device, a ``gymnasium.Env``.
    uncertain : field -> `gelcone.Uniform` or `gelcone.Normal`, drawn for each episode. Default: none.
    highest_voltage : largest voltage, V. Default: the peak of the device's drive.
    heights : lowest and highest wanted height, m. Default: where the disc rests under no voltage and under
        ``highest_voltage``.
    period : time between two actions, over which the voltage is held, s. Default 1 ms.
    episode : length of an episode, s. Default 1 s.
    draws : number of drawn devices, of which an episode takes one. Default 1024.
    seed : seed of these draws; ``reset(seed=...)`` sets that of the episodes. Default 0.
    tolerance : relative error of one step of the integrator. Default 1e-7.

    Returns
    -------
    The environment. Its ``episodes`` have ``displacement``, ``target`` (m) and ``voltage`` (V); ``"ended"`` in the info
    of a step holds the reason why an episode was terminated.

    Raises
    ------
    InputError : for an ensemble, numbers out of bounds, and draws without a rest.
    MissingDependency : without gymnasium, which the extra ``learn`` brings.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> pump = gelcone.environment(device, heights=("13 mm", "14 mm"), episode="50 ms", draws=2)
    >>> observation, info = pump.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = pump.step([0.0])
    >>> observation.shape, bool(terminated)
    ((4,), False)
    """
    check_device(device, "environment")
    if count is not None:
        check_count("count", count, 1)
    check_count("draws", draws, 2)
    check_flow(tolerance, None)
    try:
        from gelcone.learn.environments import HeightEnv, HeightVectorEnv
    except ImportError:
        raise MissingDependency("learning environments need gymnasium: pip install 'gelcone[learn]'") from None
    task = task_of(
        device,
        None if highest_voltage is None else parse("highest_voltage", highest_voltage, "V"),
        None if heights is None else (parse("heights", heights[0], "m"), parse("heights", heights[1], "m")),
        parse("period", period, "s"),
        parse("episode", episode, "s"),
    )
    episodes = Episodes(Pool.of(device, uncertain or {}, draws, seed), task, 1 if count is None else count, tolerance)
    return HeightEnv(episodes) if count is None else HeightVectorEnv(episodes)
