"""What a figure of the paper is: which studies it draws, and the text that goes with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class PaperFigure:
    """A figure: ``draw`` gets the Datasets of its ``studies`` by name.

    ``presets`` are the parameter sets it uses, ``values`` what is varied (from the text or reconstructed, said so),
    ``message`` one paragraph on what it shows, for the report.
    """

    number: int
    title: str
    presets: tuple[str, ...]
    values: str
    message: str
    studies: tuple[str, ...]
    draw: Callable[[Mapping[str, xr.Dataset]], Figure]

    @property
    def name(self) -> str:
        return f"figure-{self.number:02d}"

    @property
    def command(self) -> str:
        """The command that redraws it."""
        return f"gelcone paper {self.number}"
