"""Models and states that the tests of the continuum film share."""

from functools import cache

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


@cache
def fitted_with_states():
    """The film of the cone model's defaults with a/b = 0.2, fitted once for all tests, and the states it was fitted to:
    rows of s, V, stiffness, kind."""
    from gelcone.paper import unwrinkled

    kept = []
    fitted, own = unwrinkled._fitted, unwrinkled.ELEMENTS

    def keeping(film, free, states, ends):
        kept.extend((state.s, state.squared, state.stiffness, state.kind) for state in states)
        return fitted(film, free, states, ends)

    unwrinkled._fitted = keeping
    unwrinkled.ELEMENTS = 16  # as good, sooner
    try:
        film = unwrinkled.fit_unwrinkled(ConeModel(), 0.2)
    finally:
        unwrinkled._fitted = fitted
        unwrinkled.ELEMENTS = own
    return film, np.array(kept)
