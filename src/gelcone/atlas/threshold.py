"""Thresholds: the range of a parameter over which one kind of motion gives way to another.

Changes to or from chaos are not sharp: starts that no measurement distinguishes settle on different motions, and there
are periodic windows in between. A threshold is therefore a range, from the last value up to which all nearby starts are
of the one kind to the first from which on none is. Each round tries the quarters of the range; the search ends when
these no longer change it. A motion that was chaotic on its way has other states at the same value when it is repeated:
a range is narrowed down from several of them, and is of one path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gelcone.codes import Regime
from gelcone.motion.attractor.classification import Evidence
from gelcone.quantity import Array

QUARTERS = (0.25, 0.5, 0.75)
STABLE = 0.9
"""Share of its width above which a range has not changed in a round; after two such rounds it is stable."""
WANDERING = {Regime.CHAOTIC, Regime.TRANSIENT_CHAOS, Regime.QUASI_PERIODIC}
"""Kinds of motion whose states differ from run to run."""
DOUBLINGS = 2
"""Number of successive doublings of the period towards chaos that make a cascade."""


@dataclass
class Threshold:
    """A change of regime between ``low`` and ``high``, from ``below`` to ``above``, on a branch.

    ``tried`` maps the values examined to the share of the nearby starts of kind ``below`` and the period; ``sharp``
    says that the range is as narrow as it was asked for, ``out_of_chaos`` that a sweep came to it through chaos.
    """

    branch: str
    below: Regime
    above: Regime
    low: float
    high: float
    tried: dict[float, tuple[float, int]] = field(default_factory=dict)
    unchanged: int = 0
    sharp: bool = False
    out_of_chaos: bool = False

    def add(self, value: float, share: float, period: int) -> None:
        """Add a value that was examined."""
        self.tried[value] = (share, period)

    def narrow(self) -> None:
        """Moves the ends of the range to the last value of the one kind and the first of the other."""
        values = sorted(value for value in self.tried if self.low <= value <= self.high)
        before = self.high - self.low
        low, high = self.low, self.high
        for value in values:
            if self.tried[value][0] < 1.0:
                break
            low = value
        for value in reversed(values):
            if self.tried[value][0] > 0.0:
                break
            high = value
        self.low, self.high = low, high
        self.unchanged = self.unchanged + 1 if self.high - self.low > STABLE * before else 0

    @property
    def wandering(self) -> bool:
        """True if the motion on one of both sides differs from run to run."""
        return not WANDERING.isdisjoint((self.below, self.above))

    @property
    def of_one_path(self) -> bool:
        """True if another path may have another range: chaos takes part, and the range stays wide, a sweep comes to it
        through chaos, or chaos ends on one side."""
        ends = Regime.TRANSIENT_CHAOS in (self.below, self.above)
        return self.wandering and (self.out_of_chaos or ends or not self.sharp)

    @property
    def middle(self) -> list[float]:
        """The quarters of the range."""
        return [self.low + (self.high - self.low) * share for share in QUARTERS]

    @property
    def cascade(self) -> bool:
        """True if chaos begins by doublings: towards it the period doubles at least `DOUBLINGS` times in a row."""
        if Regime.CHAOTIC not in (self.below, self.above):
            return False
        order = sorted(self.tried, reverse=self.below is Regime.CHAOTIC)
        periods = [self.tried[value][1] for value in order if self.tried[value][1] > 0]
        longest = run = 0
        for one, other in pairwise(periods):
            run = run + 1 if other == 2 * one else run if other == one else 0
            longest = max(longest, run)
        return longest >= DOUBLINGS


def share_of(evidence: Evidence, kind: Regime) -> Array:
    """The share of the nearby starts of each member that are of a kind, (members,)."""
    share = (evidence.regime == kind).astype(float)
    several = np.isfinite(evidence.share_chaotic)
    if kind is Regime.CHAOTIC:
        return np.where(several, evidence.share_chaotic, share)
    if kind in (Regime.REST, Regime.PERIODIC):
        ends = np.where(evidence.fate_regime == kind, evidence.fate_share, 0.0).sum(axis=1)
        settled = several & (evidence.regime != Regime.TRANSIENT_CHAOS)
        return np.where(settled, np.minimum(ends, 1.0), share)
    return share


def changes(branch: str, values: Array, evidence: Evidence) -> list[Threshold]:
    """The changes of regime between neighbouring values of a branch, each over the values whose starts disagree.

    Equal ranges are merged into one, from the kind below to the kind above.
    """
    thresholds: dict[tuple[int, int], Threshold] = {}
    for at in np.flatnonzero(evidence.regime[1:] != evidence.regime[:-1]):
        below, above = Regime(int(evidence.regime[at])), Regime(int(evidence.regime[at + 1]))
        share = share_of(evidence, below)
        first, last = int(at), int(at) + 1
        while first > 0 and share[first] < 1.0:
            first -= 1
        while last < len(values) - 1 and share[last] > 0.0:
            last += 1
        if (first, last) in thresholds:
            thresholds[first, last].above = above
            continue
        threshold = Threshold(branch, below, above, float(values[first]), float(values[last]))
        near = range(max(first - 3, 0), min(last + 4, len(values)))
        for k in near:
            threshold.add(float(values[k]), float(share[k]), int(evidence.period[k]))
        thresholds[first, last] = threshold
    return list(thresholds.values())


def refine(
    thresholds: list[Threshold],
    classified: Callable[[list[Threshold], Array], list[Evidence]],
    halvings: int,
    progress: Callable[[float], None],
) -> None:
    """Narrows the thresholds down to 2^-``halvings`` of their ranges, or until these no longer change.

    ``classified`` takes a threshold for each value and returns the evidence at the values, along each path to them.
    """
    least = [(t.high - t.low) / 2.0**halvings for t in thresholds]
    for _ in range(halvings):
        wide = [t for t, width in zip(thresholds, least, strict=True) if t.high - t.low > width and t.unchanged < 2]
        if not wide:
            break
        owners = [threshold for threshold in wide for _ in QUARTERS]
        tried = np.array([value for threshold in wide for value in threshold.middle])
        paths = classified(owners, tried)
        for threshold in wide:
            owned_rows = np.flatnonzero([owner is threshold for owner in owners])
            shares = np.mean([share_of(path.take(owned_rows), threshold.below) for path in paths], axis=0)
            for value, share, period in zip(tried[owned_rows], shares, paths[0].period[owned_rows], strict=True):
                threshold.add(float(value), float(share), int(period))
            threshold.narrow()
        for threshold, width in zip(thresholds, least, strict=True):
            threshold.sharp = threshold.high - threshold.low <= width
        progress(1.0 / halvings)
