"""Verdicts: the rules in their order, on made-up findings that must give each verdict."""

import dataclasses
import itertools
import math

import pytest

from gelcone.paper.numbers import Number
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Finding, Verdict, judge, verdict_text

ASIDE = {"numbers": (), "why": "made up"}
MOST, FEW, NONE, HALF = Share(18, 2), Share(2, 18), Share(0, 20), Share(10, 10)


@pytest.mark.parametrize(
    ("expected", "found"),
    [
        # Rule 1: nothing else counts when the text does not say enough.
        (Verdict.UNDECIDABLE, {"holds": True, "decidable": False}),
        (Verdict.UNDECIDABLE, {"holds": None, "decidable": False, "holds_finite": True, "share": MOST}),
        # Rule 2: it holds, on more than half of the others or with none looked at.
        (Verdict.REPRODUCED, {"holds": True}),
        (Verdict.REPRODUCED, {"holds": True, "share": MOST}),
        (Verdict.REPRODUCED, {"holds": True, "share": MOST, "holds_finite": None, "holds_fixed_step": True}),
        # Rule 3: it holds on a thin set; exactly half is not more than half.
        (Verdict.CHOSEN, {"holds": True, "share": FEW}),
        (Verdict.CHOSEN, {"holds": True, "share": NONE, "holds_finite": True}),
        (Verdict.CHOSEN, {"holds": True, "share": Share(1, 1, sample=False)}),
        # Rule 4: it fails in the long run, but holds over a window; this comes before artefact and share.
        (Verdict.TRANSIENT, {"holds": False, "holds_finite": True}),
        (Verdict.TRANSIENT, {"holds": False, "holds_finite": True, "holds_fixed_step": True, "share": MOST}),
        # Rule 5: only the fixed-step integrator shows it; this comes before the share.
        (Verdict.ARTEFACT, {"holds": False, "holds_fixed_step": True}),
        (Verdict.ARTEFACT, {"holds": False, "holds_fixed_step": True, "share": FEW}),
        # Rule 6: it fails at the paper's parameters, and holds at some others.
        (Verdict.CHOSEN, {"holds": False, "share": Share(1, 99)}),
        (Verdict.CHOSEN, {"holds": False, "share": HALF}),
        # Rule 7.
        (Verdict.NOT_REPRODUCED, {"holds": False}),
        (Verdict.NOT_REPRODUCED, {"holds": False, "share": NONE}),
        # Rule 8: what is open decides.
        (Verdict.UNDECIDED, {"holds": None}),
        (Verdict.UNDECIDED, {"holds": True, "share": HALF}),
        (Verdict.UNDECIDED, {"holds": False, "holds_finite": None}),
        (Verdict.UNDECIDED, {"holds": False, "share": Share(0, 19, open=1)}),
        # ... and where it does not decide, it does not matter.
        (Verdict.CHOSEN, {"holds": None, "share": FEW}),
        (Verdict.CHOSEN, {"holds": False, "share": Share(1, 18, open=1)}),
    ],
)
def test_each_verdict_by_its_rule(expected, found):
    assert judge(Finding(**found, **ASIDE)) is expected


def test_every_combination_gives_a_verdict_and_each_verdict_can_be_given():
    maybe = (None, False, True)
    shares = (None, NONE, FEW, HALF, MOST)
    findings = itertools.product(maybe, maybe, shares, maybe, (True, False))
    names = ("holds", "holds_finite", "share", "holds_fixed_step", "decidable")
    given = {judge(Finding(**dict(zip(names, one, strict=True)), **ASIDE)) for one in findings}
    assert given == set(Verdict)


def test_numbers_and_words_do_not_sway_a_verdict():
    plain = Finding(holds=False, holds_finite=True, **ASIDE)
    changed = dataclasses.replace(plain, numbers=(Number("exponent", 0.3, error=0.1),), why="other", unseen="much")
    assert judge(changed) is judge(plain)


def test_parts_of_a_claim_have_verdicts_of_their_own_in_its_text():
    parts = {"it falls": Finding(holds=True, **ASIDE), "it stays": Finding(holds=False, holds_finite=True, **ASIDE)}
    whole = Finding(holds=False, holds_finite=True, parts=parts, **ASIDE)
    assert judge(whole) is Verdict.TRANSIENT
    assert verdict_text(whole) == "it falls: reproduced; it stays: only as a transient"
    assert verdict_text(Finding(holds=True, **ASIDE)) == "reproduced"


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (Number("threshold", 1.04321, error=0.00312), "1.0432 ± 0.0031"),
        (Number("voltage", 1.04321, low=1.03, high=1.05), "1.043 [1.030, 1.050]"),
        (Number("share", 0.2, low=0.03622, high=0.6245), "0.20 [0.04, 0.62]"),
        (Number("stroke", 12.3456, error=0.1, unit="mm"), "12.35 ± 0.10 mm"),
        (Number("count", 3.0), "3"),
        (Number("difference", 0.018374, error=1e-9), "0.01837"),
        (Number("large", 1234.6, error=120.0), "1235 ± 120"),
        (Number("tiny", 3.2e-10, error=4e-11), "3.2e-10 ± 4e-11"),
        (Number("peak", 0.7321, error=math.inf), "0.7321 (error unknown)"),
        (Number("largest without chaos", math.nan, error=0.1), "none"),
        (Number("ratio", 0.5), "0.5"),
    ],
)
def test_numbers_show_their_error_or_interval(number, text):
    assert str(number) == text
