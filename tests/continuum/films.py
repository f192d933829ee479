"""Models and states that the tests of the continuum film share."""

import numpy as np

from gelcone.continuum.mesh import BAND
from gelcone.continuum.path import cone
from gelcone.physics.model import ConeModel

MODELS = {
    "gent": ConeModel(),
    "soft limit": ConeModel(stretch_limit=4.0, meridional_prestretch=1.1, hoop_prestretch=1.2),
    "neo-hookean": ConeModel(law="neo-hookean", prestretch=1.2, prestretch_mode="equibiaxial"),
    "yeoh": ConeModel(law="yeoh", yeoh_c2=0.1, yeoh_c3=0.02, prestretch=1.1),
}
EQUIBIAXIAL = {"prestretch": 1.2, "prestretch_mode": "equibiaxial"}
NEO_HOOKEAN = ConeModel(law="neo-hookean")


def alone(model):
    """The cone model's film without its spring."""
    return model.replace(spring_stiffness=0.0)


def some_position(film, height=0.6):
    """A smooth state that is no equilibrium."""
    position = cone(film, height)
    s = film.place
    position[0::2] = 0.06 * np.sin(np.pi * s)
    position[1::2] -= 0.05 * np.sin(np.pi * s) * s
    return position


def dense(band):
    """The full matrix of a band matrix."""
    size = band.shape[1]
    full = np.zeros((size, size))
    for k in range(2 * BAND + 1):
        for column in range(size):
            row = column + k - BAND
            if 0 <= row < size:
                full[row, column] = band[k, column]
    return full
