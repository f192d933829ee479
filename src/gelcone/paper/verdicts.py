"""From numbers to verdicts: the rules, all in one place.

A claim's check says whether it holds in the long run at the paper's own parameters, whether it holds over a finite
window like the paper's, at what share of other parameters it holds, and whether it holds for the paper's fixed-step
integrator while that integrator is beyond the stretch limit. The verdict follows from these alone. Where one of them
is not known and the verdict depends on it, there is no verdict.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from itertools import product

from gelcone.paper.numbers import Number, Truth
from gelcone.paper.truths import Share

NEARLY_ALL = 0.9
"""A statement about every point of a range holds when the share of it is certain to be larger than this."""
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

    ``holds`` in the long run at the paper's parameters; ``holds_finite`` over a finite window from the start;
    ``holds_fixed_step`` for the fixed-step integrator in runs that go beyond the stretch limit; each False where the
    question does not apply, None where the numbers do not say. ``share`` of other parameters at which it holds in the
    long run, the paper's own not among them, and what these are (``neighbourhood``). ``decidable`` is False where the
    surviving text does not say enough, or nothing could be computed. ``numbers``, the first being the key number;
    ``slack`` says for what share of the time the film was slack; ``consequence`` says of a claim that follows from
    the equation of motion, for any motion, how; ``unseen`` is what the paper could not see. ``parts`` of a claim that
    makes several statements are the findings on each, by its words.
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
    """The verdict in words; of a claim with parts those on each of them."""
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
