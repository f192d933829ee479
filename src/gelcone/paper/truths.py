"""Truths that may be left open, and shares of parameters with their intervals.

A truth is True, False, or None (open: an interval contains the cut, or the motion at a point is not known). A share
counts the parameters of a range at which a statement holds; its interval is Wilson's (J. Am. Stat. Assoc. 22, 1927,
209). A sample is judged up to six times while it grows, at 99.2 % each, so that all judgements together hold at 95 %.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gelcone.paper.numbers import Number, Truth
from gelcone.quantity import Array
from gelcone.statistics import wilson

LOOKS_Z = 2.638257273476751
"""Standard errors on either side that hold 1 - 0.05/6 of a normal distribution: a sample is judged at most six
times."""


@dataclass(frozen=True)
class Share:
    """The share of parameters at which a statement holds: counts ``holding``, ``failing``, and ``open``.

    ``sample`` is False if these are all parameters, so that the share is exact: two readings of a word, or the parts of
    a range between bracketed edges, measured by their lengths. A sample with one point in each of equal parts of a
    range is more precise than independent draws: ``apart`` is the number of its pairs of neighbours that differ.
    """

    holding: float
    failing: float
    open: float = 0
    sample: bool = True
    apart: int | None = None

    @property
    def count(self) -> float:
        """The number of parameters."""
        return self.holding + self.failing + self.open

    @property
    def value(self) -> float:
        """The share among the decided parameters; NaN without any."""
        decided = self.holding + self.failing
        return self.holding / decided if decided else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the share over the whole range; open parameters count as failing in the lower and as holding in the
        upper one."""
        count = self.count
        if not count:
            return 0.0, 1.0
        ends = self.holding / count, (self.holding + self.open) / count
        if not self.sample:
            return ends
        (low, _), (_, high) = (wilson(end, self._draws(end), LOOKS_Z) for end in ends)
        return float(low), float(high)

    def _draws(self, share: float) -> float:
        """The number of independent draws with the variance of this sample.

        The variance of a mean of strata is at most that within pairs of them (Cochran, Sampling Techniques, 3rd ed.,
        section 5A.12); some pairs are added to the observed number, as few pairs are weak evidence.
        """
        if self.apart is None:
            return self.count
        variance = (self.apart + 0.5 * LOOKS_Z**2) / self.count**2
        return max(self.count, share * (1.0 - share) / variance)

    def exceeds(self, cut: float) -> Truth:
        """Whether the share is larger than ``cut``; None if its interval contains the cut."""
        low, high = self.interval
        return True if low > cut else False if high <= cut else None

    @property
    def found(self) -> Truth:
        """Whether the statement holds at any parameter; None if only open ones could."""
        return True if self.holding else None if self.open else False

    def number(self, meaning: str) -> Number:
        """The share as a number with its interval."""
        low, high = self.interval
        return Number(meaning, self.value, low=low, high=high)


def share(truths: Any, *, sample: bool = True) -> Share:
    """The share of truths in an array or a list: True, False and None, or 1, 0 and NaN."""
    flat = np.asarray(truths, dtype=float).ravel()
    return Share(int((flat == 1.0).sum()), int((flat == 0.0).sum()), int(np.isnan(flat).sum()), sample)


def stratified(values: Array, truths: Any) -> Share:
    """The share of a range, from an even number of values, one in each of equal parts of it."""
    flat = np.asarray(truths, dtype=float)[np.argsort(values)]
    apart = int((flat[0::2] != flat[1::2]).sum())
    return replace(share(flat), apart=apart)


def lengths(values: Array, truths: Any) -> Share:
    """The share of a range, from increasing values at which a statement does or does not hold.

    Between two values with the same truth that truth holds; between others lies an edge, and the length is open.
    """
    ends, flat = np.diff(np.asarray(values, dtype=float)), np.asarray(truths, dtype=float)
    both, none = ((flat[1:] == flat[:-1]) & (flat[1:] == known) for known in (1.0, 0.0))
    return Share(float(ends[both].sum()), float(ends[none].sum()), float(ends[~both & ~none].sum()), sample=False)


def every(*truths: Truth) -> Truth:
    """Whether all hold; None if none fails but one is open."""
    return False if False in truths else None if None in truths else True


def truth(value: Any) -> Truth:
    """The truth of one entry of an array of truths."""
    return None if np.isnan(value) else bool(value)
