"""Made-up periodic motions, whose amplitudes are functions of the frequency."""

import numpy as np

from gelcone.motion.swing import Swing
from gelcone.physics.model import ConeModel

RESTING = ConeModel(rest_height=0.3)
PLACE, WIDTH, HEIGHT = 1.37, 0.05, 0.8


def swings(amplitude, period=1):
    """Swings up and down, (members, branches, steps)."""
    found = Swing.blank(*np.shape(amplitude))
    found.highest[:], found.lowest[:], found.period[:] = amplitude, -np.asarray(amplitude), period
    return found


def resonance(omega):
    return HEIGHT / (1.0 + ((omega - PLACE) / WIDTH) ** 2)


def moving(amplitude, final=0.0):
    """Periodic motions of some amplitudes, which end at some displacements."""
    found = swings(np.asarray(amplitude, dtype=float))
    found.final[..., 0], found.final[..., 1] = final, 0.0
    return found
