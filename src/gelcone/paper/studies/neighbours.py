"""What the motions of figures 7 and 10 become at parameter sets near the paper's: is a claim that of one set alone?

The identification of the base set is not unique. Its drive frequency, spring stiffness and damping ratio are drawn
anew, each within a factor of `FACTOR`, independently and evenly on a log scale.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.motion.attractor.classification import Evidence, classify
from gelcone.paper.effort import Effort
from gelcone.paper.studies.study import Progress, Study
from gelcone.paper.studies.triples import TRIPLES
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

FACTOR = 1.25
DRAWN = ("drive_frequency", "spring_stiffness", "damping_ratio")
SEED = 104
HIGHEST = 2.0
"""Largest voltage of figure 13 (text); the smallest here is the paper's threshold."""
STARTS = 8
"""Nearby starts of the base set itself, from which the error of its amplitude follows."""
NEARBY = 1e-9


def sets(count: int) -> dict[str, Array]:
    """Parameters of ``count`` sets near the base set, each (count,)."""
    base = find_preset("base").model
    drawn = np.random.default_rng(SEED).uniform(-1.0, 1.0, (count, len(DRAWN)))
    return {name: float(getattr(base, name)) * FACTOR ** drawn[:, k] for k, name in enumerate(DRAWN)}


def neighbours(effort: Effort, progress: Progress) -> xr.Dataset:
    """Regimes over ``set`` and ``voltage``, of the ``prestretch_kind`` over ``set`` and ``prestretch``, and the extents
    of the base set itself from nearby starts, ``own_extent`` over ``start`` and ``voltage``."""
    preset = effort.preset("base")
    count, voltages = effort.neighbours, np.linspace(1.04, HIGHEST, effort.neighbour_voltages)
    drawn = {name: values[:, None] for name, values in sets(count).items()}
    _, parameter, stretches, changes = TRIPLES["prestretch"]
    found = _kinds(preset.model.replace(**drawn, voltage=voltages), preset.initial, effort)
    progress(0.5)
    order = _kinds(preset.model.replace(**drawn, **changes, **{parameter: np.array(stretches)}), preset.initial, effort)
    progress(0.2)
    offsets = NEARBY * np.linspace(-1.0, 1.0, STARTS)[:, None]
    model = preset.model.replace(voltage=voltages + 0.0 * offsets)
    starts = np.tile(preset.initial, (model.size, 1)) + np.stack([np.repeat(offsets, voltages.size)] * 2, axis=1)
    own, start = classify(model.members(), starts, patience=effort.patience), model.shape
    progress(0.3)
    single = dataset.label(preset.model, {}, options={"factor": FACTOR, "seed": SEED}, title="near the base set")

    def size(evidence: Evidence, shape: tuple[int, ...]) -> Array:
        return np.fmax(np.abs(evidence.lowest), np.abs(evidence.highest)).reshape(shape)

    shape = count, voltages.size
    exponents, errors = (v.reshape(*shape, -1) for v in (found.exponents, found.standard_error))
    variables = (
        ("regime", ("set", "voltage"), found.regime.reshape(shape), "kind of motion", "code"),
        ("lyapunov", ("set", "voltage", "exponent"), exponents, "exponents", "rate"),
        ("standard_error", ("set", "voltage", "exponent"), errors, "standard error of the exponents", "rate"),
        ("extent", ("set", "voltage"), size(found, shape), "largest displacement in the long run", "length"),
        ("prestretch_kind", ("set", "prestretch"), order.regime.reshape(count, -1), "kind of motion", "code"),
        ("own_extent", ("start", "voltage"), size(own, start), "largest displacement of the base set", "length"),
        ("own_regime", ("start", "voltage"), own.regime.reshape(start), "kind of motion", "code"),
    )
    coords = (
        *((name, "set", values[:, 0], name.replace("_", " "), "share") for name, values in drawn.items()),
        ("voltage", "voltage", voltages, "voltage amplitude", "voltage"),
        ("prestretch", "prestretch", np.array(stretches), "pre-stretch", "share"),
    )
    named: list[dict[str, Any]] = [
        {name: (dims, values, dataset.attributes(*of)) for name, dims, values, *of in rows}
        for rows in (variables, coords)
    ]
    return single.assign(named[0]).assign_coords(named[1])


def _kinds(model: ConeModel, initial: tuple[float, float], effort: Effort) -> Evidence:
    return classify(model.members(), np.tile(initial, (model.size, 1)), patience=effort.patience)


STUDIES = (Study("neighbours", neighbours, work=6.0),)
