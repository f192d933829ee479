"""Studies behind claims about parameter ranges: samples of them, see `gelcone.paper.sampling`.

Each sample stops once the share that its claim needs is certainly on one side of the claim's cut. A claim that fails in
the long run is also judged over the finite window, whose share must then be certain as well.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import NEARBY
from gelcone.motion.start import complete
from gelcone.paper import reading
from gelcone.paper.effort import Effort
from gelcone.paper.films import WRINKLING
from gelcone.paper.numbers import Truth
from gelcone.paper.reading import LIMIT_THRESHOLD, STARTS, chaotic, finite_positive
from gelcone.paper.sampling import SIGN_BUDGET, Sample, observed, over_points, sampled, share_of
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.studies.study import OF_MOTION, Progress, Study
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.truths import Share, every
from gelcone.paper.verdicts import NEARLY_ALL, WIDE
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE_THRESHOLD = 1.04
"""Threshold from the paper's text."""
HIGHEST = 2.0
"""Largest voltage and damping ratio of figure 13 (text)."""
ABOUT = 1.2
"""Factor that the word "about" allows to either side."""
FACTOR = 1.25
"""Factor within which the base set's reconstructed parameters are varied, as their identification is not unique."""
DRAWN = ("drive_frequency", "spring_stiffness", "damping_ratio")
VOLTAGES, SET_VOLTAGES, DAMPINGS, LIMITS = 10, 5, 8, 4
"""Values at each draw of samples with inner parameters."""
LOWER = np.geomspace(0.52, LIMIT_THRESHOLD / ABOUT, LIMITS, endpoint=False)
HIGHER = np.geomspace(100.0, LIMIT_THRESHOLD * ABOUT, LIMITS, endpoint=False)
"""Stretch limits on both sides of the threshold, each from its far end."""
HIGH = 1.6
"""Lowest high voltage."""
STRETCHES = (0.4, 2.0)
"""Pre-stretches of figure 14, and those up to which they are small and beyond which they are not."""
SMALL, LARGE = 0.8, 1.2
BANDS = 4
"""Number of ranges into which the pre-stretches are divided."""
MODES = ("radial", "equibiaxial")

Read = Callable[["xr.Dataset"], Array]


def decided(holds: Callable[[Share], Truth], read: Read, finite: Read, points: xr.Dataset) -> bool:
    """Whether a sample decides if a statement ``holds`` (in the long run, and else over the finite window)."""
    long, window = (holds(share_of(points, truths(points))) for truths in (read, finite))
    return long is True or (long is False and window is not None)


def holds_nearly(found: Share) -> Truth:
    """Whether a statement holds at nearly all points."""
    return found.exceeds(NEARLY_ALL)


def holds_throughout(found: Share) -> Truth:
    """Whether a statement holds at every point, of enough points to be certain."""
    return every(found.failing == 0, found.exceeds(NEARLY_ALL) if not found.failing else True)


def half(*reads_and_points: Any) -> bool:
    """Whether the side of one half on which a share lies is certain, for all truths."""
    *reads, points = reads_and_points
    return all(share_of(points, read(points)).exceeds(WIDE) is not None for read in reads)


def _voltage(name: str, low: float, high: float, holds: Callable[[Share], Truth], read: Read, finite: Read) -> Sample:
    return Sample(name, "base", {"voltage": (low, high)}, partial(decided, holds, read, finite))


def _limit(name: str, low: float, high: float, read: Read, finite: Read) -> Sample:
    drawn, changes = {"stretch_limit": (low, high)}, {"voltage": PANELS["fast", "stretch_limit"]}
    return Sample(name, "fast", drawn, partial(decided, holds_nearly, read, finite), changes, logarithmic=True)


def rows_without_chaos(points: xr.Dataset) -> Array:
    """Truths: no damping ratio of a row is chaotic."""
    return reading.all_of(reading.without_chaos(points))


def rows_with_chaos(points: xr.Dataset) -> Array:
    """Truths: some voltage of a row is chaotic."""
    return reading.any_of(chaotic(points))


def rows_finite(points: xr.Dataset) -> Array:
    """Truths: some voltage of a row has a positive exponent over the window."""
    return reading.any_of(finite_positive(points))


def rows_positive(points: xr.Dataset) -> Array:
    """Truths: nearly all voltages of a row have a positive exponent."""
    return reading.nearly_all_of(reading.positive(points))


def rows_about_six(points: xr.Dataset) -> Array:
    """Truths: the largest displacement in the chaos of a row is about 6."""
    chaos = chaotic(points)
    return reading.about_six(reading.largest_in(chaos, points["extent"].values), chaos)


def rows_ordered(points: xr.Dataset) -> Array:
    """Truths: small, moderate and larger pre-stretch of a row are chaotic, periodic and at rest."""
    return reading.ordered(points["prestretch_kind"].values)


def rows_same(points: xr.Dataset) -> Array:
    """Truths: the large stretch limits of a row have the same extents."""
    return reading.same_extents(points["extent"].values, points["regime"].values)


SAMPLES: dict[str, tuple[Sample, ...]] = {
    "share-voltage": (
        _voltage("below", 0.0, VOLTAGE_THRESHOLD, holds_throughout, reading.not_positive, reading.finite_not_positive),
        _voltage("above", VOLTAGE_THRESHOLD, HIGHEST, holds_nearly, reading.positive, finite_positive),
    ),
    "share-limit": (
        _limit("below", 0.52, LIMIT_THRESHOLD / ABOUT, chaotic, finite_positive),
        _limit("above", LIMIT_THRESHOLD * ABOUT, 100.0, reading.regular, reading.finite_not_positive),
    ),
    "share-damping": (
        Sample(
            "damping ratio",
            "base",
            {"damping_ratio": (0.0, HIGHEST)},
            partial(decided, holds_throughout, reading.without_chaos, reading.finite_not_positive),
            {"voltage": PANELS["base", "damping_ratio"]},
        ),
    ),
    "other-voltages-damping": (
        Sample(
            "voltage",
            "base",
            {"voltage": (0.5, HIGHEST)},
            partial(half, rows_without_chaos),
            inner={"damping_ratio": np.geomspace(0.02, HIGHEST, DAMPINGS)},
        ),
    ),
    "other-voltages-limit": (
        Sample(
            "voltage",
            "fast",
            {"voltage": (0.7, 1.6)},
            partial(half, reading.parted),
            inner={"stretch_limit": np.concatenate([LOWER, HIGHER[::-1]])},
        ),
    ),
    "share-high-voltage": tuple(
        Sample(
            f"{mode}, pre-stretch {low:g} to {high:g}",
            "base",
            {"voltage": (HIGH, HIGHEST), "prestretch": (float(low), float(high))},
            partial(half, reading.positive),
            {"prestretch_mode": mode},
            # points that the paper's wording does not cover are open, and decide nothing
            costly=mode == "radial",
        )
        for mode in MODES
        for low, high in np.linspace(*STRETCHES, BANDS + 1)[np.add.outer(np.arange(BANDS), [0, 1])]
    ),
    "share-prestretch": tuple(
        Sample(
            f"{mode}, {size}",
            "base",
            {"prestretch": ends},
            partial(half, rows_with_chaos, rows_finite),
            {"prestretch_mode": mode},
            {"voltage": np.linspace(0.0, VOLTAGE_THRESHOLD, VOLTAGES + 2)[1:-1]},
        )
        for mode in MODES
        for size, ends in (("small", (STRETCHES[0], SMALL)), ("large", (LARGE, STRETCHES[1])))
    ),
}


def neighbours(effort: Effort, progress: Progress) -> xr.Dataset:
    """Parameter sets near the base set: motions over ``inner`` voltages, ``prestretch_kind`` over ``prestretch``; and
    ``own_extent`` of the base set over nearby ``start``s and ``inner``."""
    base = find_preset("base").model
    voltages = np.linspace(VOLTAGE_THRESHOLD, HIGHEST, SET_VOLTAGES)
    drawn = {name: (float(getattr(base, name)) / FACTOR, float(getattr(base, name)) * FACTOR) for name in DRAWN}
    answered = partial(half, rows_positive, rows_about_six, rows_ordered)
    sample = Sample("set", "base", drawn, answered, inner={"voltage": voltages}, logarithmic=True)
    result = sampled((sample,), effort, lambda done: progress(0.8 * done), _of_sets)
    offsets = NEARBY * np.linspace(-1.0, 1.0, STARTS)
    preset = effort.preset("base")
    model = preset.model.replace(voltage=voltages + 0.0 * offsets[:, None])
    starts = np.tile(preset.initial, (model.size, 1)) + np.repeat(offsets, SET_VOLTAGES)[:, None]
    members = model.members()
    base_motions = classify(members, complete(members, starts), patience=effort.patience, budget=SIGN_BUDGET)
    extent = np.fmax(np.abs(base_motions.lowest), np.abs(base_motions.highest)).reshape(model.shape)
    progress(0.2)
    kinds = base_motions.regime.reshape(model.shape)
    return result.assign(own_extent=(("start", "inner"), extent), own_regime=(("start", "inner"), kinds))


def _of_sets(model: ConeModel, initial: tuple[float, float], effort: Effort) -> xr.Dataset:
    """`observed`, and the kinds of motion of the same sets at the pre-stretches of figure 10."""
    _, parameter, stretches, changes = TRIPLES["prestretch"]
    others = model.replace(**changes, **{parameter: np.array(stretches)})
    members = others.members()
    starts = complete(members, np.tile(initial, (others.size, 1)))
    kinds = classify(members, starts, patience=effort.patience, budget=SIGN_BUDGET)
    motions = over_points(observed(model, initial, effort))
    return motions.assign(prestretch_kind=(("point", "prestretch"), kinds.regime.reshape(others.shape)))


WORK = {"share-high-voltage": 15.0, "other-voltages-damping": 7.0, "share-limit": 3.0, "other-voltages-limit": 3.0}

FOLLOWED = ("share-voltage", "share-damping", "other-voltages-damping")
"""Samples also computed with the creeping film, for claims judged with it."""

STUDIES = (
    *(
        Study(name, partial(sampled, samples), WORK.get(name, 2.0), OF_MOTION if name in FOLLOWED else (WRINKLING,))
        for name, samples in SAMPLES.items()
    ),
    Study("neighbours", neighbours, work=10.0, films=OF_MOTION),
)
