"""From numbers to verdicts: the rules, all in one place.

A claim's check says whether it holds in the long run at the paper's own parameters, whether it holds over a finite
window like the paper's, for what share of the neighbouring parameters it holds, and whether it holds for the paper's
fixed-step integrator while that integrator is beyond the stretch limit. The verdict follows from these alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

WIDE = 0.5
"""A claim that holds for at least this share of the neighbouring parameters does not depend on their choice."""


DIGITS = 4
"""Digits of a number whose error is negligible."""
MOST_DECIMALS = 7


class Verdict(Enum):
    """The verdict on a claim."""

    REPRODUCED = "reproduced"
    TRANSIENT = "only as a transient"
    CHOSEN = "only for chosen parameters"
    NOT_REPRODUCED = "not reproduced"
    ARTEFACT = "artefact"
    UNDECIDABLE = "undecidable"


@dataclass(frozen=True)
class Number:
    """A number behind a verdict: its value with an error or an interval, and what it is."""

    meaning: str
    value: float
    error: float | None = None
    low: float | None = None
    high: float | None = None
    unit: str = ""

    def __str__(self) -> str:
        """To the digits that the error or the interval supports; without an error all digits shown are correct."""
        if math.isnan(self.value):
            return "none"
        unit = f" {self.unit}" if self.unit else ""
        interval = (self.low, self.high) if self.low is not None and self.high is not None else None
        spread = self.error if self.error is not None else interval[1] - interval[0] if interval else 0.0
        if not math.isfinite(spread):
            return f"{self.value:.{DIGITS}g}{unit} (error unknown)"
        if spread <= 0.5 * abs(self.value) * 10.0**-DIGITS:
            return f"{self.value:.{DIGITS}g}{unit}"
        decimals = 1 - math.floor(math.log10(spread))
        form = f".{max(decimals, 0)}f" if decimals <= MOST_DECIMALS else ".2g"
        if self.error is not None:
            return f"{self.value:{form}} ± {self.error:{form}}{unit}"
        return f"{self.value:{form}} [{self.low:{form}}, {self.high:{form}}]{unit}"


@dataclass(frozen=True)
class Finding:
    """What the check of a claim found.

    ``holds`` in the long run at the paper's parameters (None: the surviving text does not say enough to decide);
    ``holds_finite`` over a finite window from the start; ``share`` of the neighbouring parameters on which it holds in
    the long run, from 0 to 1, and what these are (``neighbourhood``); ``holds_fixed_step`` for the fixed-step
    integrator in runs that go beyond the stretch limit. None where a question does not apply. ``numbers``, the first
    being the key number; ``unseen`` is what the paper could not see.
    """

    holds: bool | None
    numbers: tuple[Number, ...]
    why: str
    holds_finite: bool | None = None
    share: float | None = None
    neighbourhood: str = ""
    holds_fixed_step: bool | None = None
    unseen: str = ""
    details: dict[str, str] = field(default_factory=dict)


def judge(finding: Finding) -> Verdict:
    """The verdict on a finding; the first rule that applies decides.

    1. It cannot be decided whether the claim holds: undecidable.
    2. It holds, and for at least half of the neighbouring parameters (where these were checked): reproduced.
    3. It holds, but for less than half of them: only for chosen parameters.
    4. It does not hold in the long run, but over a finite window: only as a transient.
    5. It holds for neither, but for the fixed-step integrator beyond the stretch limit: artefact.
    6. It holds for some of the neighbouring parameters: only for chosen parameters.
    7. Otherwise: not reproduced.
    """
    if finding.holds is None:
        return Verdict.UNDECIDABLE
    if finding.holds:
        wide = finding.share is None or finding.share >= WIDE
        return Verdict.REPRODUCED if wide else Verdict.CHOSEN
    if finding.holds_finite:
        return Verdict.TRANSIENT
    if finding.holds_fixed_step:
        return Verdict.ARTEFACT
    if finding.share:
        return Verdict.CHOSEN
    return Verdict.NOT_REPRODUCED
