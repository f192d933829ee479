"""The settled motion as a curve: one turn of a periodic orbit, or a stretch of a motion that does not repeat."""

from __future__ import annotations

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.flow import integrate
from gelcone.motion.job import Trajectories
from gelcone.physics.members import Members
from gelcone.quantity import Array

PER_PERIOD, PER_OSCILLATION = 100, 40
"""Samples of a curve on the screen: each period of the voltage, and each oscillation at the fastest rate, at least."""
MOST_SAMPLES, MOST_OF_ORBIT = 8000, 100_000
"""Samples of a motion that does not repeat, and of a periodic orbit: of a very slow drive they are further apart."""
LONGEST = 64
"""Forcing periods of it that are drawn."""


def samples_over(members: Members, span: float) -> int:
    """The even samples of a single actuator's motion that a curve over the time ``span`` needs, at least `PER_PERIOD`.

    The rate that counts is a bound of the actuator's own: the motion oscillates no faster."""
    periods = span / float(members.drive_period[0])
    oscillations = float(members.rate[0]) * span / (2.0 * np.pi)
    return int(np.ceil(max(PER_PERIOD * periods, PER_OSCILLATION * oscillations, PER_PERIOD)))


def settled_orbit(members: Members, start: Array, regime: Regime, period: int) -> tuple[Trajectories, slice]:
    """The run along the settled motion of a single actuator from ``start`` (N,) at phase 0, and its samples at the
    beginning of each forcing period.

    ``period`` is that of a periodic orbit in forcing periods; the run along it, and along a rest, lasts whole periods
    of the drive, so that the voltage repeats with it. A motion that does not repeat is followed for as many periods as
    `MOST_SAMPLES` can draw, at least one and at most `LONGEST`.
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
