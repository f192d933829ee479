"""Models and made-up planes of peak voltage and frequency, for the tests of envelopes and of their static half."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

import gelcone
from gelcone.motion.plane import DRIVEN_LIMITS, YIELDS, DriveShape, Plane
from gelcone.motion.ramp import Ramp
from gelcone.physics.model import ConeModel

TAUT = ConeModel(
    damping_ratio=0.1, voltage=0.3, voltage_bias=0.3, rest_height=0.6, meridional_prestretch=1.2, hoop_prestretch=1.5
)
FLAT = ConeModel(damping_ratio=0.1, voltage=1.2, spring_stiffness=0.5, hoop_prestretch=1.3, stretch_limit=8.0)
WRINKLING = ConeModel(
    film="wrinkling", damping_ratio=0.2, voltage=0.1, voltage_bias=0.2, rest_height=1.0, spring_stiffness=2.0
)
BEAM = ConeModel(
    film=gelcone.TautCone(branches=1, prestretch_mode="equibiaxial"),
    bias=gelcone.BuckledBeam(),
    **{"prestretch": 1.2, "beam_stiffness": -0.6, "beam_cubic": 2.0, "beam_height": 1.0, "damping_ratio": 0.3},
    **{"viscous_modulus_1": 1.0, "relaxation_time_1": 20.0, "voltage": 0.2, "voltage_bias": 0.5},
)
"""A disc that snaps late: in the long run at 1.19, the sooner the higher the voltage."""


class Curve(NamedTuple):
    """A membrane's pull-in, linear between points."""

    displacements: tuple
    voltages: tuple
    error: float
    reach = 2.0

    def voltage(self, x):
        return np.interp(np.abs(x), self.displacements, self.voltages)


class Straight(Plane):
    """A plane whose disc rises in proportion to the voltage, and which pulls in where it is told to."""

    slope, share, pitchfork, jump = 0.5, 0.5, np.nan, 5.0

    def ramp(self, levels):
        x = self.rest + self.slope * levels
        voltages = [levels, self.share * levels][: len(self.model.system.films)]
        return Ramp(self.rest, x, 2.0 * levels, 3.0 * levels, 1.0 - 0.25 * levels, voltages, self.pitchfork, self.jump)

    def examine(self, omegas, peaks, lower=None, *, yields=True, shift=0.0):
        return {name: 10.0 * k + omegas + 0.1 * peaks for k, name in enumerate((*YIELDS, "regime", "final"))}


def straight(model, **changes):
    plane = Straight(model, DriveShape.of(model), 0.1, None, changes.pop("membrane", None))
    for name, value in changes.items():
        object.__setattr__(plane, name, value)
    return plane


def passes(excess, low, high):
    """Where a function passes zero."""
    return brentq(excess, low, high, xtol=1e-12)


OMEGAS, VOLTS = np.array([0.5, 0.6, 0.7, 0.9]), np.array([0.3, 0.9, 1.4])
LOW = np.full((4, len(DRIVEN_LIMITS)), np.inf)
LOW[0, [1, 3]], LOW[1, [0, 2]], LOW[3, 4] = (0.8, 0.5), (np.nan, 1.3), 0.0
"""Frequencies whose first limit is meridional slack, hoop slack, none, and the stretch limit from the start."""
