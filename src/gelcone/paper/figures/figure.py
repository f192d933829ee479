"""A figure of the paper: the studies it draws, and its text."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Draw = Callable[[Mapping[str, "xr.Dataset"]], "Figure"]


@dataclass(frozen=True)
class Table:
    """A table below a figure, as texts."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


Tabulate = Callable[[Mapping[str, "xr.Dataset"]], Table]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: ``draw`` and ``table`` (if any) receive the Datasets of its ``studies`` by name.

    ``number`` is its number in the paper, or a name for our own figures. ``presets`` are its parameter sets; ``values``
    describes the varied parameters and whether they are reconstructed; ``message`` is a paragraph for the report.
    """

    number: int | str
    title: str
    presets: tuple[str, ...]
    values: str
    message: str
    studies: tuple[str, ...]
    draw: Draw
    table: Tabulate | None = None

    @property
    def name(self) -> str:
        """Name of its files without suffix."""
        return f"figure-{self.number:02d}" if isinstance(self.number, int) else self.number

    @property
    def heading(self) -> str:
        """The number and the title."""
        return f"Figure {self.number}: {self.title}" if isinstance(self.number, int) else self.title

    @property
    def command(self) -> str:
        """The command that redraws it."""
        return f"gelcone paper {self.number}"


@cache
def _texts() -> dict[str, Any]:
    return tomllib.loads(files("gelcone.paper.figures").joinpath("texts.toml").read_text(encoding="utf-8"))


def paper_figure(
    number: int | str, studies: tuple[str, ...], draw: Draw, table: Tabulate | None = None, **values: Any
) -> PaperFigure:
    """The figure with its texts from ``texts.toml``, filled in with ``values``."""
    text = _texts()[str(number)]
    varied = text["values"].format(**values)
    return PaperFigure(number, text["title"], tuple(text["presets"]), varied, text["message"], studies, draw, table)
