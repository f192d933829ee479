"""Above which voltage the wrinkling membrane has pulled in, over the displacement: at a few heights, kept for later.

Higher up than a height at which it pulls in, it has pulled in on the way there at no more than that voltage; where it
falls slack first, it pulls in as a free film does.
"""

from __future__ import annotations

import importlib.util
import json
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone import disk_cache
from gelcone.continuum.charged import charged, slack_limit, slack_squared
from gelcone.continuum.fit import FITS, SEARCHED, SLACK_MARGIN, film_key
from gelcone.continuum.membrane import DEFAULT_RADIUS_RATIO, raised_film
from gelcone.continuum.mesh import check_radius_ratio, mesh_film
from gelcone.continuum.path import Ending
from gelcone.errors import InputError
from gelcone.physics.film.wrinkling import NEVER, WrinklingCone
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

ELEMENTS = 16
HEIGHTS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0)
STEPS = 6
"""Of the voltage squared, up to the pull-in of the next lower height."""
TOLERANCE = 4e-3
MESH_ERROR = 0.006
"""Of the voltage by the mesh, against one of 200 elements."""


@dataclass(frozen=True)
class PullInCurve:
    """Voltages above which a film has pulled in, at displacements from the lowest up; infinite where it does not.

    ``error`` is the largest of the voltages between, over them: of the mesh, the bracket and the interpolation.
    """

    displacements: tuple[float, ...]
    voltages: tuple[float, ...]
    error: float

    def voltage(self, x: npt.ArrayLike) -> Array:
        """At displacements of either sign: linear between those of the curve, level beyond, infinite up to the first at
        which it pulls in."""
        return np.interp(np.abs(x), self.displacements, self.voltages)


def pull_in_curve(model: ConeModel, radius_ratio: float = DEFAULT_RADIUS_RATIO) -> PullInCurve:
    """The curve of one actuator's film, computed in seconds; its law and pre-stretches alone play a part.

    Raises `InputError` for a film that is in tension at no displacement, `MissingDependency` without scikit-fem.
    """
    film = mesh_film(model.replace(spring_stiffness=0.0), radius_ratio, ELEMENTS, relaxed=True)
    lowest = free = slack_limit(film.model)
    known = film.coefficients["A"] >= film.coefficients["B"]  # all rings then fall slack at once, where the cone does
    searched = min(free, SEARCHED / float(film.coefficients["G"]))
    x, squared, guess = [0.0], [free], searched
    for height, start in raised_film(film, list(HEIGHTS)).items():
        slack = slack_squared(film, height) if known else np.inf
        highest = min(lowest, searched, SLACK_MARGIN * slack)
        found = charged(film, start, highest, min(highest, 1.2 * guess) / STEPS, tolerance=TOLERANCE)
        if found.ending == Ending.NOT_CONVERGED:
            continue  # nothing is known there: its neighbours tell
        if found.ending == Ending.PULLED_IN:
            lowest = min(lowest, found.end)
        x.append(height)
        squared.append(lowest)
        guess = found.end or searched
    if len(x) == 1:
        raise InputError("the film is in tension at no displacement; raise the pre-stretch or the stretch limit")
    voltages = np.where(np.array(squared) < NEVER, np.sqrt(squared), np.inf)
    # where slackness gives way to pull-in the curve is steep: its place, not its voltage, is uncertain there
    smooth = voltages[voltages < voltages[0]]
    bent = np.abs(np.diff(smooth, 2)) / 8.0 / smooth[1:-1]
    return PullInCurve(
        tuple(x), tuple(voltages.tolist()), MESH_ERROR + 0.5 * TOLERANCE + float(np.max(bent, initial=0.0))
    )


def find_pull_in_curve(model: ConeModel, radius_ratio: float) -> PullInCurve | None:
    """The curve, from the user's cache if it is there; None where it does not apply: for another film than the
    wrinkling cone, or with a second one; and without scikit-fem."""
    single = isinstance(model.film, WrinklingCone) and model.film.pull_in == "first" and len(model.system.films) == 1
    if not single or model.shape or importlib.util.find_spec("skfem") is None:
        return None
    key, alone = film_key("pull-in", model, check_radius_ratio(radius_ratio))
    stored = disk_cache.read(FITS, key)
    if stored is not None:
        x, voltages, error = json.loads(stored)
        return PullInCurve(tuple(x), tuple(voltages), float(error))
    try:
        found = pull_in_curve(alone, float(radius_ratio))
    except InputError:
        return None
    disk_cache.write(FITS, key, json.dumps([found.displacements, found.voltages, found.error]).encode())
    return found
