"""Membranes with certified states, which several tests take."""

from functools import cache

from gelcone.physics.film.membrane import MembraneFilm

MADE = [(0.2, 1, 1), (0.2, 1.5, 1.5), (0.2, 1, 1.5)]
"""Ratio, meridional and hoop pre-stretch of films with certified states, of one stretch limit."""


@cache
def film_of(ratio, meridional, hoop):
    film = MembraneFilm(prestretch_mode="equibiaxial" if meridional == hoop else "radial")
    own = {"radius_ratio": ratio, "prestretch": float(hoop), "stretch_limit": 50.0}
    return film, film.numbers(film.complete(own))
