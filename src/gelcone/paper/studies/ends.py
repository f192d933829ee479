"""Study of the end of chaos: the number of voltages of the base set, of 21, at which the taut film is chaotic behind a
series resistance or with a Maxwell branch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gelcone.dataset import Table, columns
from gelcone.paper.effort import Effort
from gelcone.paper.sampling import observed
from gelcone.paper.studies.study import Progress, Study

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.physics.model import ConeModel

NAME = "chaos-counts"
VOLTAGES = np.linspace(1.0, 2.0, 21)
RESISTANCES = (0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
MODULI = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
TIMES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
"""Relaxation times over two decades; a quick run takes every second value."""
MODULUS, TIME = 0.5, 50.0
"""Modulus and time of the branch while the other one is varied."""


class Case(NamedTuple):
    """A series ``resistance``, and ``modulus`` and relaxation ``time`` of a branch; 0 without one."""

    resistance: float = 0.0
    modulus: float = 0.0
    time: float = 0.0

    def changes(self, stretch_limit: float) -> dict[str, Any]:
        """The parameters that add it to the elastic film behind an ideal source; a branch has the film's stretch
        limit."""
        branch = {
            "viscous_modulus_1": self.modulus,
            "relaxation_time_1": self.time,
            "viscous_limit_1": stretch_limit,
        }
        return {"series_resistance": self.resistance} if self.resistance else branch if self.modulus else {}


COUNTED_OVER = 4000.0
COUNTED = {
    Case(): 16,
    Case(0.01): 4,
    Case(0.03): 3,
    Case(0.1): 3,
    Case(0.0, 0.1, 50.0): 15,
    Case(0.0, 0.5, 50.0): 14,
    Case(0.0, 0.5, 2.0): 9,
}
"""Voltages with a positive exponent over the first `COUNTED_OVER` time units, counted with version 0.2 and user-defined
components."""


def cases(effort: Effort) -> tuple[Case, ...]:
    """The elastic film behind an ideal source, then the additions."""
    step = 2 if effort.name == "quick" else 1
    added = (
        *(Case(resistance) for resistance in RESISTANCES[::step]),
        *(Case(0.0, modulus, TIME) for modulus in MODULI[::step]),
        *(Case(0.0, MODULUS, time) for time in TIMES[::step]),
    )
    return (Case(), *dict.fromkeys(added))


def ends(effort: Effort, progress: Progress) -> xr.Dataset:
    """Regime and exponents of every voltage over ``case``, see `gelcone.paper.sampling.observed`.

    Only the largest exponent is stored, as cases differ in their number of states. ``series_resistance``,
    ``viscous_modulus_1`` and ``relaxation_time_1`` are 0 if absent; ``counted`` is the count of `COUNTED`.
    """
    import xarray as xr

    preset, every = effort.preset("base"), cases(effort)
    model, parts = preset.model, []
    for case in every:
        added = case.changes(float(model.stretch_limit))
        parts.append(_observed(model.replace(voltage=VOLTAGES, **added), preset.initial, effort))
        progress(1.0 / len(every))
    result = xr.concat(parts, "case", join="exact", combine_attrs="override", coords="minimal", compat="override")
    table: Table = {
        "series_resistance": ([case.resistance for case in every], "series resistance, 0 without", "parameter"),
        "viscous_modulus_1": ([case.modulus for case in every], "modulus of the branch, 0 without", "parameter"),
        "relaxation_time_1": ([case.time for case in every], "relaxation time of the branch, 0 without", "parameter"),
        "counted": ([COUNTED.get(case, math.nan) for case in every], "positive exponents, counted before", "count"),
    }
    return result.assign(columns("case", table)).assign_attrs(preset="base", window=effort.window)


def _observed(model: ConeModel, initial: tuple[float, float], effort: Effort) -> xr.Dataset:
    motions = observed(model, initial, effort).isel(exponent=[0])
    return motions.swap_dims(member="voltage").drop_vars([name for name in motions.coords if name != "voltage"])


STUDIES = (Study(NAME, ends, work=60.0, films=()),)
