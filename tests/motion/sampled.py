"""Motions that are sampled, and made-up pieces of a run."""

import numpy as np

from gelcone.motion import settle as module
from gelcone.physics.model import ConeModel

PERIODIC = ConeModel(damping_ratio=0.1, spring_stiffness=1.0, voltage=0.8, drive_frequency=1.0, rest_height=0.3)
CHAOTIC = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, voltage=1.7, drive_frequency=0.1)


def pieces_of(first, count, values, outcome, **more):
    return module.Piece(first, count, np.zeros(0), values, np.array(outcome, dtype=np.int8), **more)
