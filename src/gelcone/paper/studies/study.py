"""What a study is: one named computation behind figures and claims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gelcone.paper.effort import Effort

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Study:
    """A computation by name; ``compute`` takes the effort and a progress callback (shares that add up to 1).

    ``work`` is about how many seconds of one core it takes in a quick run.
    """

    name: str
    compute: Callable[[Effort, Progress], xr.Dataset]
    work: float = 1.0
