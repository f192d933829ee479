"""The paper's claims: what it says, in our words, and how each is read off the studies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gelcone.paper.verdicts import Finding

if TYPE_CHECKING:
    import xarray as xr

Studies = Mapping[str, "xr.Dataset"]


@dataclass(frozen=True)
class Claim:
    """A claim: ``check`` turns the Datasets of its ``studies``, by name, into a finding; ``figure`` shows it."""

    name: str
    statement: str
    figure: int
    studies: tuple[str, ...]
    check: Callable[[Studies], Finding]


CLAIMS: dict[str, Claim] = {}
