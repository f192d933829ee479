"""Sizes of the paper's studies, in full and quick runs."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gelcone.paper.films import CREEPING, MEMBRANE, OTHER_FILMS, PAPERS, WRINKLING, film_of_model
from gelcone.presets import Preset, find_preset


@dataclass(frozen=True)
class Effort:
    """Sizes of the paper's studies, and the ``film`` that they are computed with.

    ``samples`` is the largest size of a sample, a power of two (`gelcone.paper.sampling`), and ``costly_samples`` that
    of samples with much chaos. ``films`` are the films other than the paper's that claims are judged with.
    """

    name: str
    diagram_values: int
    sweeps: tuple[str, ...]
    map_shape: tuple[int, int]
    section_points: int
    frequencies: int
    spectrum_periods: int
    limit_map: tuple[int, int]
    patience: float | None
    bisections: int
    samples: int
    costly_samples: int
    films: tuple[str, ...]
    window: float = 500.0
    film: str = PAPERS

    def preset(self, name: str) -> Preset:
        """A parameter set of the paper, with this film."""
        paper = find_preset(name)
        return paper if self.film == PAPERS else replace(paper, changes=film_of_model(self.film))

    def with_film(self, film: str) -> Effort:
        """The sizes for another film; the creeping one takes much longer, and has the sizes of a quick run."""
        return replace(QUICK if film == CREEPING else self, name=self.name, film=film)


FULL = Effort(
    "full",
    201,
    ("up", "down"),
    (65, 65),
    1500,
    160,
    400,
    (25, 60),
    patience=None,
    bisections=8,
    samples=512,
    costly_samples=512,
    films=OTHER_FILMS,
)
QUICK = Effort(
    "quick",
    41,
    (),
    (17, 17),
    200,
    32,
    64,
    (7, 18),
    patience=25_000.0,
    bisections=4,
    samples=128,
    costly_samples=16,
    films=(WRINKLING, MEMBRANE),
)
