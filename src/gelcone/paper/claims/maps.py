"""What the paper claims about the map over voltage and pre-stretch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.reading import chaotic, finite_positive, positive, share, share_number
from gelcone.paper.verdicts import Finding, Number

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE_THRESHOLD = 1.04
"""From the paper's text."""


@claim(
    "map-high-voltage",
    "At high voltage the largest exponent is predominantly positive whatever the pre-stretch.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_high_voltage(studies: Studies) -> Finding:
    def shares(mode: str) -> Any:
        plane = studies[f"map-{mode}"]
        high = plane.sel(voltage=plane["voltage"] >= 1.6)
        return np.mean(positive(high), axis=high["regime"].dims.index("voltage"))

    radial, equibiaxial = shares("radial"), shares("equibiaxial")
    return Finding(
        holds=bool(radial.mean() > 0.5),
        share=share(np.concatenate([radial, equibiaxial]) > 0.5),
        neighbourhood="pre-stretches from 0.4 to 2, radial and equi-biaxial, each over v from 1.6 to 2",
        numbers=(
            share_number(
                "share of the radial map above v = 1.6 with a positive exponent", positive(_high(studies["map-radial"]))
            ),
            share_number("the same, equi-biaxial", positive(_high(studies["map-equibiaxial"]))),
            Number(
                "smallest such share of one radial pre-stretch", float(radial.min()), low=0.0, high=float(radial.min())
            ),
        ),
        why="Predominantly means more than half of the voltages above 1.6.",
        unseen="Which pre-stretch was meant: stretched in both directions the film stiffens, and less of the map is "
        "chaotic.",
    )


def _high(plane: xr.Dataset) -> xr.Dataset:
    return plane.sel(voltage=plane["voltage"] >= 1.6)


@claim(
    "map-low-prestretch",
    "At small pre-stretch the motion is chaotic already at moderate voltage.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_low_prestretch(studies: Studies) -> Finding:
    def early(mode: str, finite: bool = False) -> Any:
        plane = studies[f"map-{mode}"].transpose("prestretch", "voltage", ...)
        low = plane.sel(prestretch=plane["prestretch"] <= 0.8, voltage=plane["voltage"] < VOLTAGE_THRESHOLD)
        return (finite_positive(low) if finite else chaotic(low)).any(axis=1)

    radial, equibiaxial = early("radial"), early("equibiaxial")
    return Finding(
        holds=bool(radial.mean() > 0.5),
        holds_finite=bool(early("radial", finite=True).mean() > 0.5),
        share=share(np.concatenate([radial, equibiaxial])),
        neighbourhood="pre-stretches from 0.4 to 0.8, radial and equi-biaxial",
        numbers=(
            share_number("share of radial pre-stretches up to 0.8 with chaos below v = 1.04", radial),
            share_number("the same, equi-biaxial", equibiaxial),
        ),
        why="Moderate means below the threshold 1.04 of the film without pre-stretch; a pre-stretch below 1 is a slack "
        "film that buckles out of plane, so that the motion has two sides to choose from without any voltage.",
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
    def safe(mode: str) -> Any:
        plane = studies[f"map-{mode}"]
        return ~np.any(chaotic(plane), axis=plane["regime"].dims.index("voltage"))

    stretches = studies["map-radial"]["prestretch"].values
    radial, equibiaxial = safe("radial"), safe("equibiaxial")
    calm = np.flatnonzero(~equibiaxial)
    edge = float(stretches[min(calm[-1] + 1, len(stretches) - 1)]) if calm.size else float(stretches[0])
    window = ~np.any(finite_positive(studies["map-radial"]), axis=studies["map-radial"]["regime"].dims.index("voltage"))
    return Finding(
        holds=bool(radial[-1]),
        holds_finite=bool(window[-1]),
        share=share(np.concatenate([radial, equibiaxial])),
        neighbourhood="pre-stretches from 0.4 to 2, radial and equi-biaxial",
        numbers=(
            share_number("share of radial pre-stretches without chaos up to v = 2", radial),
            share_number("share of equi-biaxial pre-stretches without chaos up to v = 2", equibiaxial),
            Number(
                "equi-biaxial pre-stretch from which on there is no chaos up to v = 2",
                edge if equibiaxial[-1] else float("nan"),
                error=float(np.diff(stretches)[0]),
            ),
        ),
        why="The largest pre-stretch of the map decides: chaos-free up to v = 2, or not.",
        unseen="That the answer depends on what pre-stretch means; the paper's wording fits the radial reading.",
    )


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
        share=share([bool(radial), bool(equibiaxial)]),
        neighbourhood="radial and equi-biaxial pre-stretch",
        numbers=(
            Number("enclosed pockets of negative exponents in the radial map", float(len(radial)), error=0.0),
            Number("cells in the largest of them", float(max(radial, default=0)), error=0.0),
            Number("enclosed pockets in the equi-biaxial map", float(len(equibiaxial)), error=0.0),
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
