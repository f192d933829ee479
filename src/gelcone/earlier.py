"""Names that variables of results had in earlier versions.

`gelcone.load` gives results of versions 0.1 and 0.2 today's names. Variables that are newer stay missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

NAMES: Mapping[str, Mapping[str, str]] = {
    "chaotic_until": {"seen_until": "chaotic_until"},
    "constant_voltage": {
        "peak_voltage": "constant_voltage",
        "driven_peak": "peak_voltage",
        "own_peak": "operating_peak_voltage",
        "own_frequency": "operating_frequency",
        "coexisting": "coexisting_motions",
    },
    "operating_onset_voltage": {
        "own_onset_voltage": "operating_onset_voltage",
        "own_onset_kind": "operating_onset_kind",
        "own_searched": "operating_searched",
    },
    "aliasing_bound": {"folded": "aliasing_bound"},
}
"""Today's name of one variable of a result -> earlier names of its variables and dims -> today's names."""


def with_names_of_today(result: xr.Dataset) -> xr.Dataset:
    """The result of an earlier version with the names of today; another one as it is."""
    for newest, names in NAMES.items():
        if newest not in result.variables and all(name in result.variables for name in names):
            result = result.rename(names)
    return result
