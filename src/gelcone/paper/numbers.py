"""Numbers behind verdicts, with the digits that their errors support, and truths that may stay open."""

from __future__ import annotations

import math
from dataclasses import dataclass

Truth = bool | None
"""None if the numbers leave it open."""
DIGITS = 4
"""Digits of a number whose error is negligible."""
MOST_DECIMALS = 7


@dataclass(frozen=True)
class Number:
    """A number behind a verdict: meaning, value, and error or interval."""

    meaning: str
    value: float
    error: float | None = None
    low: float | None = None
    high: float | None = None
    unit: str = ""

    def __str__(self) -> str:
        """The value with the digits that its error or interval supports; without either all digits shown are
        correct."""
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
