"""The rules by which numbers become verdicts.

The check of a claim states whether it holds in the long run at the paper's parameters, over a finite window like
the paper's, at what share of other parameters, and for the paper's fixed-step integrator beyond the stretch limit. The
verdict follows from these alone. If one of them is open and the verdict depends on it, the verdict is undecided.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from itertools import product

from gelcone.paper.numbers import Number, Truth
from gelcone.paper.truths import Share

NEARLY_ALL = 0.9
"""A statement about every point of a range holds if its share is certain to exceed this."""
WIDE = 0.5
"""A claim that holds for more than this share of other parameters does not depend on their choice."""


class Verdict(Enum):
    """The verdict on a claim."""

    REPRODUCED = "reproduced"
    TRANSIENT = "only as a transient"
    CHOSEN = "only for chosen parameters"
    NOT_REPRODUCED = "not reproduced"
    ARTEFACT = "artefact"
    UNDECIDED = "undecided"
    UNDECIDABLE = "undecidable"


@dataclass(frozen=True)
class Finding:
    """Findings of the check of a claim.

    ``holds``: in the long run at the paper's parameters; ``holds_finite``: over a finite window from the start;
    ``holds_fixed_step``: for the fixed-step integrator in runs beyond the stretch limit. Each is False if it does not
    apply, and None if the numbers leave it open. ``share``: of other parameters (described in ``neighbourhood``) at
    which the claim holds in the long run. ``decidable``: False if the surviving text does not suffice, or nothing could
    be computed. ``numbers``: the key number first. ``slack``: the share of the time with slack film. ``consequence``:
    how a claim follows from the equation of motion for any motion. ``unseen``: facts that the paper could not see.
    ``parts``: findings on each of several statements, by its words.
    """

    holds: Truth
    numbers: tuple[Number, ...]
    why: str
    holds_finite: Truth = False
    share: Share | None = None
    neighbourhood: str = ""
    holds_fixed_step: Truth = False
    decidable: bool = True
    slack: tuple[Number, ...] = ()
    consequence: str = ""
    unseen: str = ""
    details: dict[str, str] = field(default_factory=dict)
    parts: dict[str, Finding] = field(default_factory=dict)


def judge(finding: Finding) -> Verdict:
    """The verdict on a finding; the first rule that applies decides.

    1. The surviving text does not say enough, or nothing could be computed: undecidable.
    2. It holds, and for more than half of the other parameters (where these were checked): reproduced.
    3. It holds, but for at most half of them: only for chosen parameters.
    4. It does not hold in the long run, but over a finite window: only as a transient.
    5. It holds for neither, but for the fixed-step integrator beyond the stretch limit: artefact.
    6. It holds at some of the other parameters: only for chosen parameters.
    7. Otherwise: not reproduced.
    8. Where the numbers leave one of these questions open and the verdict depends on it: undecided.
    """
    if not finding.decidable:
        return Verdict.UNDECIDABLE
    asked = (
        finding.holds,
        finding.holds_finite,
        finding.holds_fixed_step,
        finding.share is None or finding.share.exceeds(WIDE),
        finding.share is not None and finding.share.found,
    )
    possible = {_rule(*answers) for answers in product(*((True, False) if a is None else (a,) for a in asked))}
    return possible.pop() if len(possible) == 1 else Verdict.UNDECIDED


def verdict_text(finding: Finding) -> str:
    """The verdict in words; for a claim with parts, the verdict on each."""
    parts = [f"{name}: {judge(part).value}" for name, part in finding.parts.items()]
    return "; ".join(parts) or judge(finding).value


def _rule(holds: bool, finite: bool, fixed_step: bool, wide: bool, elsewhere: bool) -> Verdict:
    if holds:
        return Verdict.REPRODUCED if wide else Verdict.CHOSEN
    if finite:
        return Verdict.TRANSIENT
    if fixed_step:
        return Verdict.ARTEFACT
    return Verdict.CHOSEN if elsewhere else Verdict.NOT_REPRODUCED
