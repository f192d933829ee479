"""Truths that the numbers may leave open, and shares of parameters with their intervals.

A truth is True, False or None: None where the numbers do not say, because an interval contains the cut or the motion
at a point could not be told. A share counts the parameters of a range at which something holds; its interval is that
of Wilson (J. Am. Stat. Assoc. 22, 1927, 209) at 95 %, the points of the range taken as a sample of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.paper.numbers import Number, Truth
from gelcone.quantity import Array
from gelcone.statistics import wilson


@dataclass(frozen=True)
class Share:
    """At how many of some parameters a statement holds: ``holding``, ``failing``, and ``open`` where it cannot be told.

    ``sample`` is False where the parameters are all that there are (two readings of a word, say): the share is exact.
    """

    holding: int
    failing: int
    open: int = 0
    sample: bool = True

    @property
    def value(self) -> float:
        """Share of the parameters that could be told; NaN for none."""
        told = self.holding + self.failing
        return self.holding / told if told else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Between which the share of the whole range lies; what is open counts against it, and for it."""
        count = self.holding + self.failing + self.open
        if not count:
            return 0.0, 1.0
        ends = self.holding / count, (self.holding + self.open) / count
        if not self.sample:
            return ends
        (low, _), (_, high) = (wilson(end, count) for end in ends)
        return float(low), float(high)

    def exceeds(self, cut: float) -> Truth:
        """Whether the share is larger than ``cut``; None when its interval contains it."""
        low, high = self.interval
        return True if low > cut else False if high <= cut else None

    @property
    def found(self) -> Truth:
        """Whether it holds at any of them; None when all that could is open."""
        return True if self.holding else None if self.open else False

    def number(self, meaning: str) -> Number:
        low, high = self.interval
        return Number(meaning, self.value, low=low, high=high)


def share(truths: Any, *, sample: bool = True) -> Share:
    """The share of an array or a list of truths: True, False and None, or 1, 0 and NaN."""
    flat = np.asarray(truths, dtype=float).ravel()
    return Share(int((flat == 1.0).sum()), int((flat == 0.0).sum()), int(np.isnan(flat).sum()), sample)


def every(*truths: Truth) -> Truth:
    """Whether all hold; None when none fails but one is open."""
    return False if False in truths else None if None in truths else True


def some(*truths: Truth) -> Truth:
    """Whether at least one holds; None when none does but one is open."""
    return True if True in truths else None if None in truths else False


def truth(value: float) -> Truth:
    """One entry of an array of truths."""
    return None if np.isnan(value) else bool(value)


def entries(truths: Array) -> list[Truth]:
    """All entries of an array of truths."""
    return [truth(value) for value in np.asarray(truths, dtype=float).ravel()]
