"""What the paper claims about the map over voltage and pre-stretch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number, Truth
from gelcone.paper.reading import chaotic, finite_positive, positive, slack_of
from gelcone.paper.studies.maps import HIGH
from gelcone.paper.truths import entries, every, share, some
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE_THRESHOLD = 1.04
"""From the paper's text."""
BANDS = 4
"""Into how many ranges the pre-stretches are divided."""


@claim(
    "map-high-voltage",
    "At high voltage the largest exponent is predominantly positive whatever the pre-stretch.",
    14,
    "map-radial",
    "map-equibiaxial",
    "voltage",
)
def map_high_voltage(studies: Studies) -> Finding:
    high = {
        mode: _rows(studies[f"map-{mode}"].sel(voltage=slice(HIGH, None)), positive)
        for mode in ("radial", "equibiaxial")
    }
    radial, equibiaxial = ([share(band) for band in np.array_split(rows, BANDS)] for rows in high.values())
    return Finding(
        holds=every(*(band.exceeds(0.5) for band in radial)),
        share=share([band.exceeds(0.5) for band in equibiaxial], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial, each quarter of the range from 0.4 to 2 for itself",
        numbers=(
            share(high["radial"]).number("share of the radial map above v = 1.6 with a positive exponent"),
            share(high["equibiaxial"]).number("the same, equi-biaxial"),
            min(radial, key=lambda band: band.value).number("smallest such share of a quarter of the pre-stretches"),
        ),
        why="Predominantly means at more than half of the points above v = 1.6; whatever the pre-stretch, in each "
        "quarter of its range from 0.4 to 2.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="Which pre-stretch was meant: stretched in both directions the film stiffens, and less of the map is "
        "chaotic.",
    )


@claim(
    "map-low-prestretch",
    "At small pre-stretch the motion is chaotic already at moderate voltage.",
    14,
    "map-radial",
    "map-equibiaxial",
    "prestretch",
)
def map_low_prestretch(studies: Studies) -> Finding:
    def early(mode: str, finite: bool = False) -> Array:
        plane = studies[f"map-{mode}"].transpose("prestretch", "voltage", ...)
        low = plane.sel(prestretch=plane["prestretch"] <= 0.8, voltage=plane["voltage"] < VOLTAGE_THRESHOLD)
        rows = finite_positive(low) if finite else chaotic(low)
        return np.array([some(*entries(row)) for row in rows], dtype=float)

    radial, equibiaxial = share(early("radial")), share(early("equibiaxial"))
    return Finding(
        holds=radial.exceeds(0.5),
        holds_finite=share(early("radial", finite=True)).exceeds(0.5),
        share=equibiaxial,
        neighbourhood="equi-biaxial pre-stretches from 0.4 to 0.8",
        numbers=(
            radial.number("share of radial pre-stretches up to 0.8 with chaos below v = 1.04"),
            equibiaxial.number("the same, equi-biaxial"),
        ),
        why="Needed: chaos below the threshold 1.04 of the film without pre-stretch at more than half of the "
        "pre-stretches up to 0.8. A pre-stretch below 1 is a slack film that buckles out of plane, so that the motion "
        "has two sides to choose from without any voltage.",
        slack=slack_of(studies["prestretch"], "prestretch"),
        unseen="Below 1 the film is compressed when flat, and the membrane model does not hold.",
    )


@claim(
    "map-safe-prestretch",
    "Above some pre-stretch the motion is periodic over the whole range of voltage.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_safe_prestretch(studies: Studies) -> Finding:
    rows = {mode: _rows(studies[f"map-{mode}"], chaotic) for mode in ("radial", "equibiaxial")}
    window = _rows(studies["map-radial"], finite_positive)
    stretches = studies["map-radial"]["prestretch"].values
    free, edge = share([_never(row) for row in rows["radial"]]), _edge(rows["equibiaxial"])
    return Finding(
        holds=_calm_above(rows["radial"]),
        holds_finite=_calm_above(window),
        share=share([_calm_above(rows["equibiaxial"])], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial",
        numbers=(
            free.number("share of radial pre-stretches without chaos up to v = 2"),
            share([_never(row) for row in rows["equibiaxial"]]).number(
                "share of equi-biaxial pre-stretches without chaos up to v = 2"
            ),
            Number(
                "equi-biaxial pre-stretch from which on there is no chaos up to v = 2",
                float(stretches[edge]) if edge < len(stretches) else float("nan"),
                error=float(np.diff(stretches)[0]),
            ),
        ),
        why="Needed: from some pre-stretch up to the largest of the map no chaos at any voltage, over so many points "
        f"that its share is below {1.0 - NEARLY_ALL:.0%}.",
        unseen="That the answer depends on what pre-stretch means; the paper's wording fits the radial reading.",
    )


def _rows(plane: xr.Dataset, read: Callable[[xr.Dataset], Array]) -> Array:
    """Truths over pre-stretch and voltage."""
    return read(plane.transpose("prestretch", "voltage", ...))


def _never(row: Array) -> float:
    return 0.0 if (row == 1.0).any() else float("nan") if np.isnan(row).any() else 1.0


def _edge(rows: Array) -> int:
    """Index of the pre-stretch from which on no point is chaotic; their number for none."""
    chaos = np.flatnonzero((rows == 1.0).any(axis=1))
    return int(chaos[-1]) + 1 if chaos.size else 0


def _calm_above(rows: Array) -> Truth:
    """Whether nothing is chaotic from some pre-stretch on."""
    calm = rows[_edge(rows) :]
    return share(1.0 - calm).exceeds(NEARLY_ALL) if calm.size else False


@claim(
    "stable-pocket",
    "A narrow pocket of negative exponents is surrounded by a transitional domain.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def stable_pocket(studies: Studies) -> Finding:
    radial, equibiaxial = (_pockets(studies[f"map-{mode}"]) for mode in ("radial", "equibiaxial"))
    return Finding(
        holds=bool(radial),
        share=share([bool(equibiaxial)], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial",
        numbers=(
            Number("enclosed pockets of negative exponents in the radial map", float(len(radial))),
            Number("cells in the largest of them", float(max(radial, default=0))),
            Number("enclosed pockets in the equi-biaxial map", float(len(equibiaxial))),
        ),
        why="A pocket is a connected set of at least two cells with a certainly negative exponent that touches neither "
        "the edge of the map nor the large regular domain.",
        unseen="How many there are: periodic windows riddle the chaotic domain, and finer maps show more of them.",
    )


def _pockets(plane: xr.Dataset) -> list[int]:
    """Cells of each enclosed pocket of a map."""
    from scipy import ndimage

    regular = (plane["sign"].values < 0) & (plane["regime"].values == Regime.PERIODIC)
    labels, count = ndimage.label(regular)
    edge = {*labels[0], *labels[-1], *labels[:, 0], *labels[:, -1]}
    grown = ndimage.binary_dilation(np.isin(plane["regime"].values, [Regime.REST]))
    pockets = []
    for number in range(1, count + 1):
        cells = labels == number
        if number not in edge and cells.sum() >= 2 and not (cells & grown).any():
            pockets.append(int(cells.sum()))
    return pockets
