"""``result.gelcone``: the functions that take a result, as methods of the Dataset itself.

Each method only calls the public function of the same name. The accessor is registered when gelcone labels or loads its
first result; ``import gelcone.accessor`` registers it for Datasets that xarray itself opened.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

import gelcone

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from matplotlib.figure import Figure


@xr.register_dataset_accessor("gelcone")  # type: ignore[no-untyped-call]
class Accessor:
    """Methods of a result: plot, save, export, print, tabulate, convert."""

    def __init__(self, result: xr.Dataset) -> None:
        self._result = result

    @property
    def model(self) -> gelcone.ConeModel:
        """The model that the result was computed from; see `gelcone.model_of`."""
        return gelcone.model_of(self._result)

    def plot(self, **options: Any) -> Figure:
        """The figure of the result; see `gelcone.plot`."""
        return gelcone.plot(self._result, **options)

    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Writes the result as netCDF-4; see `gelcone.save`."""
        gelcone.save(self._result, path, force=force)

    def export(self, path: str | Path, *, force: bool = False) -> list[Path]:
        """Writes the result as CSV, Parquet or for MATLAB; see `gelcone.export`."""
        return gelcone.export(self._result, path, force=force)

    def words(self) -> str:
        """The text that the command prints for such a result; see `gelcone.in_words`."""
        return gelcone.in_words(self._result)

    def table(self, over: str | Sequence[str] | None = None) -> pd.DataFrame:
        """The variables over the same dims, as a table of pandas; see `gelcone.table`."""
        return gelcone.table(self._result, over)

    def to_si(self, device: gelcone.Device | None = None) -> xr.Dataset:
        """The result in the units of its device; see `gelcone.to_si`."""
        return gelcone.to_si(self._result, device)
