"""A claim of the paper.

Every check returns a `Finding` made of numbers; the verdict follows from it by the rules in `verdicts.judge`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gelcone.paper.verdicts import Finding

if TYPE_CHECKING:
    import xarray as xr

Studies = Mapping[str, "xr.Dataset"]
Check = Callable[[Studies], Finding]


@dataclass(frozen=True)
class Claim:
    """A claim: ``check`` turns the Datasets of its ``studies``, by name, into a finding; ``figure`` shows it.

    It is judged with another film if all its studies are computed with that film, unless the film is in ``without``:
    there the check would not apply.
    """

    name: str
    statement: str
    figure: int
    studies: tuple[str, ...]
    check: Check
    without: tuple[str, ...] = ()


def claim(
    name: str, statement: str, figure: int, *studies: str, without: tuple[str, ...] = ()
) -> Callable[[Check], Claim]:
    """Registers a check as a claim."""
    return lambda check: Claim(name, statement, figure, studies, check, without)
