"""Studies behind figure 14: maps of the largest exponent, and sections along some of their rows."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gelcone.atlas.plan import Plan
from gelcone.atlas.sweep import sweep
from gelcone.paper.effort import Effort
from gelcone.paper.studies.diagrams import over_plan
from gelcone.paper.studies.samples import MODES
from gelcone.paper.studies.study import Progress, Study

if TYPE_CHECKING:
    import xarray as xr

STACKED = (0.6, 0.8, 1.0, 1.2, 1.5)
"""Pre-stretches with stored section points; rows of the map at every effort."""


def plane(mode: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """Regime, exponents and finite exponents over voltage and pre-stretch, at the base set.

    ``section`` has ``stacked_prestretch`` instead, the rows of the map nearest to `STACKED`.
    """
    count, stretches = effort.map_shape
    over = {"voltage": np.linspace(0.0, 2.0, count), "prestretch": np.linspace(0.4, 2.0, stretches)}
    preset = effort.preset("base")
    plan = Plan(preset.model.replace(prestretch_mode=mode), over, preset.initial, options={"patience": effort.patience})
    result = sweep(plan, keep=["section"], progress=lambda share: progress(0.9 * share))
    result = result.drop_vars(["status", "source"]).assign_attrs(title="parameter map")
    window_variables = over_plan(plan, effort)
    progress(0.1)
    rows = result["section"].sel(prestretch=list(STACKED), method="nearest").rename(prestretch="stacked_prestretch")
    result = result.drop_vars("section").assign(window_variables | {"section": rows})
    return result.assign_attrs(preset="base", prestretch_mode=mode, window=effort.window)


STUDIES = tuple(Study(f"map-{mode}", partial(plane, mode), work=5.0) for mode in MODES)
