"""Names that variables of results had in earlier versions.

`gelcone.load` gives results of versions 0.1 and 0.2 today's names. Variables that are newer stay missing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

ENDS_OF_RUNS = {"displacement": "displacement", "voltage": "film_voltage"}
"""What runs of 0.2 say of a pull-in -> today's name; without displacement the voltage is that of another result."""
NAMES: Sequence[Mapping[str, str]] = (
    {"seen_until": "chaotic_until"},
    {
        "driven_peak": "peak_voltage",
        "peak_voltage": "constant_voltage",
        "own_peak": "operating_peak_voltage",
        "own_frequency": "operating_frequency",
        "coexisting": "coexisting_motions",
    },
    {
        "own_onset_voltage": "operating_onset_voltage",
        "own_onset_kind": "operating_onset_kind",
        "own_searched": "operating_searched",
    },
    {"folded": "aliasing_bound"},
    *(
        {f"{film}pull_in_{end}": f"{film}pull_in_{today}" for end, today in ENDS_OF_RUNS.items()}
        for film in ("", "second_")
    ),
)
"""Earlier names of variables and dims that a result has all -> today's names."""
BEHIND_A_CIRCUIT = {"drive_voltage": "film_voltage", "second_drive_voltage": "second_film_voltage"}
"""Variables of 0.2 that were the voltage on a film: behind a circuit not the commanded one, which it did not write."""


def with_names_of_today(result: xr.Dataset) -> xr.Dataset:
    """The result of an earlier version with the names of today; another one as it is."""
    for names in NAMES:
        if all(name in result.variables for name in names):
            result = result.rename({name: new for name, new in names.items() if name != new})
    circuit = json.loads(result.attrs.get("model", "{}")).get("circuit", "ideal")
    if str(result.attrs.get("gelcone_version", "")) in ("0.1.0", "0.2.0") and circuit != "ideal":
        result = result.rename({name: new for name, new in BEHIND_A_CIRCUIT.items() if name in result.variables})
    return result
