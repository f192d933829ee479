"""Claims about the map over voltage and pre-stretch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number, Truth
from gelcone.paper.reading import all_of, finite_not_positive, positive, regular, slack_of
from gelcone.paper.sampling import part, share_of
from gelcone.paper.studies.samples import BANDS, SAMPLES, rows_finite, rows_with_chaos
from gelcone.paper.truths import Share, every, share
from gelcone.paper.verdicts import NEARLY_ALL, WIDE, Finding
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SHUFFLES = 999
"""Number of shuffled maps for the test of the largest pocket."""
SURE, CHANCE = 0.01, 0.05
"""A pocket is real if at most the first share of shuffled maps has one as large, and chance if more than the second."""
WIDEST = 0.1
"""Largest share of the map that a narrow pocket covers."""


@claim(
    "map-high-voltage",
    "At high voltage the largest exponent is predominantly positive whatever the pre-stretch.",
    14,
    "share-high-voltage",
    "voltage",
)
def map_high_voltage(studies: Studies) -> Finding:
    """Judges each quarter of the pre-stretches on a sample above the voltage 1.6."""
    study = studies["share-high-voltage"]
    names = [sample.name for sample in SAMPLES["share-high-voltage"]]
    bands = [share(positive(part(study, name))) for name in names]
    radial, equibiaxial = bands[:BANDS], bands[BANDS:]
    return Finding(
        holds=every(*(band.exceeds(WIDE) for band in radial)),
        share=share([band.exceeds(WIDE) for band in equibiaxial], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial, each quarter of the range from 0.4 to 2 for itself",
        numbers=(
            min(radial, key=lambda band: band.interval).number(
                "smallest share of a quarter of the radial pre-stretches with a positive exponent above v = 1.6"
            ),
            min(equibiaxial, key=lambda band: band.interval).number("the same, equi-biaxial"),
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
    "share-prestretch",
    "prestretch",
)
def map_low_prestretch(studies: Studies) -> Finding:
    """Judges samples of small pre-stretches, contrasted with larger ones."""

    def early(name: str, finite: bool = False) -> Share:
        points = part(studies["share-prestretch"], name)
        return share_of(points, (rows_finite if finite else rows_with_chaos)(points))

    def already(finite: bool = False) -> Truth:
        late = early("radial, large", finite).exceeds(WIDE)
        return every(early("radial, small", finite).exceeds(WIDE), None if late is None else not late)

    radial, equibiaxial = early("radial, small"), early("equibiaxial, small")
    return Finding(
        holds=already(),
        holds_finite=already(finite=True),
        share=equibiaxial,
        neighbourhood="equi-biaxial pre-stretches from 0.4 to 0.8",
        numbers=(
            radial.number("share of radial pre-stretches up to 0.8 with chaos below v = 1.04"),
            early("radial, large").number("the same from 1.2 on"),
            equibiaxial.number("the same up to 0.8, equi-biaxial"),
        ),
        why="Needed: chaos at one or more of ten even voltages below 1.04, the threshold of the film without "
        "pre-stretch, at more than half of the pre-stretches up to 0.8 and not of those from 1.2 on. Below "
        "0.73 the compressed film buckles out of plane, so that the motion has two sides to choose from without any "
        "voltage.",
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
    """Judges the rows of the map above the last row that fails."""
    rows = {mode: _rows(studies[f"map-{mode}"], regular) for mode in ("radial", "equibiaxial")}
    window = _rows(studies["map-radial"], finite_not_positive)
    stretches = studies["map-radial"]["prestretch"].values
    safe = {mode: share(all_of(row_values), sample=False) for mode, row_values in rows.items()}
    edge = _edge(rows["equibiaxial"])
    return Finding(
        holds=_regular_above(rows["radial"]),
        holds_finite=_regular_above(window),
        share=share([_regular_above(rows["equibiaxial"])], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial",
        numbers=(
            safe["radial"].number("share of the map's radial pre-stretches with regular motion up to v = 2"),
            safe["equibiaxial"].number("the same, equi-biaxial"),
            Number(
                "smallest equi-biaxial pre-stretch of the map from which on all motions up to v = 2 are regular",
                float(stretches[edge]) if edge < len(stretches) else float("nan"),
            ),
        ),
        why="Needed: from some pre-stretch up to the largest of the map regular motion at all voltages, over "
        f"enough points to bound the share of others by {1.0 - NEARLY_ALL:.0%}. A run that ends by pull-in "
        "is not a motion.",
        unseen="That the answer depends on what pre-stretch means; the paper's wording fits the radial reading.",
    )


def _rows(plane: xr.Dataset, read: Callable[[xr.Dataset], Array]) -> Array:
    """Truths over pre-stretch and voltage."""
    return read(plane.transpose("prestretch", "voltage", ...))


def _edge(rows: Array) -> int:
    """Index of the lowest pre-stretch above which no point fails; their number if there is none."""
    failing = np.flatnonzero((rows == 0.0).any(axis=1))
    return int(failing[-1]) + 1 if failing.size else 0


def _regular_above(rows: Array) -> Truth:
    """Whether no point fails above some pre-stretch."""
    above = rows[_edge(rows) :]
    return share(above).exceeds(NEARLY_ALL) if above.size else False


@claim(
    "stable-pocket",
    "A narrow pocket of negative exponents is surrounded by a transitional domain.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def stable_pocket(studies: Studies) -> Finding:
    """Judges the largest narrow pocket of the map against shuffled maps."""
    radial, equibiaxial = (_pocket(studies[f"map-{mode}"]) for mode in ("radial", "equibiaxial"))
    return Finding(
        holds=radial.found,
        share=share([equibiaxial.found], sample=False),
        neighbourhood="equi-biaxial pre-stretch instead of radial",
        numbers=(
            Number("cells in the largest narrow pocket of the radial map", float(radial.cells)),
            Number("share of shuffled maps with a pocket as large", radial.chance),
            Number("cells in the largest narrow pocket of the equi-biaxial map", float(equibiaxial.cells)),
            Number("share of shuffled maps with a pocket as large, equi-biaxial", equibiaxial.chance),
        ),
        why="A pocket is a connected set of cells with a certainly negative exponent that touches neither the edge of "
        f"the map nor the large regular domain; narrow, if at most {WIDEST:.0%} of the map. It must be larger than "
        f"chance makes it: at most {SURE:.0%} of the maps whose cells inside the chaotic domain are shuffled have one "
        f"as large. Above {CHANCE:.0%} it is chance.",
        unseen="How many there are: periodic windows riddle the chaotic domain, and finer maps show more of them.",
    )


Mask = npt.NDArray[np.bool_]


class _Pocket(NamedTuple):
    """Cells of the largest narrow pocket, and the share of shuffled maps with one as large."""

    cells: int
    chance: float

    @property
    def found(self) -> Truth:
        if not self.cells or self.chance > CHANCE:
            return False
        return True if self.chance <= SURE else None


def _pocket(plane: xr.Dataset) -> _Pocket:
    from scipy import ndimage

    negative = (plane["sign"].values < 0) & (plane["regime"].values == Regime.PERIODIC)
    rest = ndimage.binary_dilation(plane["regime"].values == Regime.REST)

    def largest(negative: Mask) -> tuple[int, npt.NDArray[np.intp]]:
        """Cells of the largest narrow pocket, and the labels of pockets: 0 outside of all."""
        labels, count = ndimage.label(negative)
        sizes = np.bincount(labels.ravel(), minlength=count + 1)
        sizes[outside(labels)] = 0
        return int(sizes[sizes <= WIDEST * labels.size].max()), labels

    def outside(labels: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
        """Labels that touch the edge or rest."""
        return np.concatenate([[0], labels[0], labels[-1], labels[:, 0], labels[:, -1], labels[rest]])

    cells, labels = largest(negative)
    domain = (negative & np.isin(labels, outside(labels))) | rest
    domain[[0, -1]] = domain[:, [0, -1]] = True  # cells at the edge stay where they are
    inside = np.flatnonzero(~domain)
    rng = np.random.default_rng(SHUFFLES)
    as_large, shuffled = 0, negative.copy()
    for _ in range(SHUFFLES if cells else 0):
        shuffled.flat[inside] = rng.permutation(negative.flat[inside])
        as_large += largest(shuffled)[0] >= cells
    return _Pocket(cells, (1 + as_large) / (1 + SHUFFLES) if cells else 1.0)
