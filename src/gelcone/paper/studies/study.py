"""A study: one named computation behind figures and claims."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import default_transient
from gelcone.motion.regime import label_evidence
from gelcone.motion.start import start_states
from gelcone.paper.effort import Effort
from gelcone.paper.films import CREEPING, MEMBRANE, WRINKLING
from gelcone.physics.film.gel import cone_reach
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float], None]

DECAYS = 20.0
OF_FORCE = (WRINKLING, MEMBRANE)
"""Films for studies of force and pull-in: the creeping film has the settled states of the wrinkling one."""
OF_MOTION = (WRINKLING, CREEPING)


@dataclass(frozen=True)
class Study:
    """A computation by name; ``compute`` takes the effort and a progress callback (shares that add up to 1).

    ``work`` is about its seconds of one core in a quick run. ``films`` are those of `gelcone.paper.films.OTHER_FILMS`
    that it is also computed with.
    """

    name: str
    compute: Callable[[Effort, Progress], xr.Dataset]
    work: float = 1.0
    films: tuple[str, ...] = (WRINKLING,)


def kinds_of(model: ConeModel, initial: tuple[float, float], effort: Effort) -> xr.Dataset:
    """`gelcone.regime` with this effort's patience, and enough time for the least damped member to decay."""
    transient = max(float(default_transient(model.members()).max()), DECAYS / float(np.min(model.damping_ratio)))
    states = start_states(model, initial)
    evidence = classify(model.members(), states, transient=transient, patience=effort.patience)
    return label_evidence(model, evidence, {"transient": transient, "patience": effort.patience}, "regime of motion")


def reach_of(model: ConeModel) -> Array:
    """The displacements (members,) at which cones reach their stretch limit."""
    return np.asarray(cone_reach(model.strain_limit(), model.own_numbers)[1])


def merged(*parts: xr.Dataset) -> xr.Dataset:
    """Datasets of one ensemble merged, with the attributes of the first."""
    import xarray as xr

    return xr.merge(parts, compat="no_conflicts", join="exact", combine_attrs="override")


def about(
    result: xr.Dataset,
    model_from: xr.Dataset,
    preset: str,
    parameter: str,
    effort: Effort,
    options: Mapping[str, Any],
    title: str,
) -> xr.Dataset:
    """The result with the attributes of all studies, and the model attributes of ``model_from``."""
    result.attrs = dict(model_from.attrs) | {"title": title, "options": json.dumps(dict(options))}
    return result.assign_attrs(preset=preset, parameter=parameter, window=effort.window)
