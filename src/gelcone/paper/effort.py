"""How finely the paper's figures are computed: in full, or quickly."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gelcone.presets import Preset, find_preset


@dataclass(frozen=True)
class Effort:
    """Sizes of the paper's studies, and the ``film`` that they are computed with."""

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
    neighbours: int
    neighbour_voltages: int
    window: float = 500.0
    film: str = "taut"

    def preset(self, name: str) -> Preset:
        """A parameter set of the paper, with this film."""
        return replace(find_preset(name), film=self.film)


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
    neighbours=24,
    neighbour_voltages=13,
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
    neighbours=12,
    neighbour_voltages=5,
)
