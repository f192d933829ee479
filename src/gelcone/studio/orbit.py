"""The settled motion as a curve: one period of a periodic orbit, or a stretch of a motion that does not repeat."""

from __future__ import annotations

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.flow import integrate
from gelcone.motion.job import Trajectories
from gelcone.physics.members import Members
from gelcone.quantity import Array

PER_PERIOD, PER_OSCILLATION = 100, 40
"""Fewest samples of a curve on the screen: per drive period, and per oscillation at the fastest rate."""
MOST_SAMPLES, MOST_OF_ORBIT = 8000, 100_000
"""Most samples of a motion that does not repeat, and of a periodic orbit (spaced wider if the drive is very slow)."""
LONGEST = 64
"""Most forcing periods drawn of a motion that does not repeat."""


def samples_over(members: Members, span: float) -> int:
    """Number of even samples for a curve of a single actuator over the time ``span``, at least `PER_PERIOD`.

    Fast oscillations count by ``members.rate``, an upper bound of the actuator's frequency.
    """
    periods = span / float(members.drive_period[0])
    oscillations = float(members.rate[0]) * span / (2.0 * np.pi)
    return int(np.ceil(max(PER_PERIOD * periods, PER_OSCILLATION * oscillations, PER_PERIOD)))


def settled_orbit(members: Members, start: Array, regime: Regime, period: int) -> tuple[Trajectories, slice]:
    """The run along the settled motion of a single actuator from ``start`` (N,) at phase 0, and its samples at the
    beginning of each forcing period.

    A periodic orbit of ``period`` forcing periods, and a rest, are followed over whole drive periods, so that the
    voltage repeats with them. A motion that does not repeat is followed for as many periods as `MOST_SAMPLES` allow,
    from one to `LONGEST`.
    """
    repeat = float(members.forcing_period[0])
    each = samples_over(members, repeat)
    if regime in (Regime.PERIODIC, Regime.REST):
        count = int(np.lcm(period if regime is Regime.PERIODIC else 1, round(float(members.drive_period[0]) / repeat)))
    else:
        count = min(max(1, MOST_SAMPLES // each), LONGEST)
    each = min(each, MOST_OF_ORBIT // count)
    ticks = np.arange(count * each + 1) / each
    run = integrate(members, start[None], ticks[None] * repeat, threads=1)
    return run, slice(0, count * each, each)
