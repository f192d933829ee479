"""Verdicts: the rules in their order, on made-up findings that must give each verdict."""

import dataclasses
import itertools
import math

import pytest

from gelcone.paper.verdicts import WIDE, Finding, Number, Verdict, judge

ASIDE = {"numbers": (), "why": "made up"}


@pytest.mark.parametrize(
    ("expected", "found"),
    [
        # Rule 1: nothing else counts when the text does not say enough.
        (Verdict.UNDECIDABLE, {"holds": None}),
        (Verdict.UNDECIDABLE, {"holds": None, "holds_finite": True, "share": 1.0, "holds_fixed_step": True}),
        # Rule 2: it holds, on at least half of the neighbours or with none looked at.
        (Verdict.REPRODUCED, {"holds": True}),
        (Verdict.REPRODUCED, {"holds": True, "share": WIDE}),
        (Verdict.REPRODUCED, {"holds": True, "share": 1.0, "holds_finite": False, "holds_fixed_step": True}),
        # Rule 3: it holds on a thin set.
        (Verdict.CHOSEN, {"holds": True, "share": math.nextafter(WIDE, 0.0)}),
        (Verdict.CHOSEN, {"holds": True, "share": 0.0, "holds_finite": True}),
        # Rule 4: it fails in the long run, but holds over a window; this comes before artefact and share.
        (Verdict.TRANSIENT, {"holds": False, "holds_finite": True}),
        (Verdict.TRANSIENT, {"holds": False, "holds_finite": True, "holds_fixed_step": True, "share": 0.9}),
        # Rule 5: only the fixed-step integrator shows it; this comes before the share.
        (Verdict.ARTEFACT, {"holds": False, "holds_finite": False, "holds_fixed_step": True}),
        (Verdict.ARTEFACT, {"holds": False, "holds_fixed_step": True, "share": 0.3}),
        # Rule 6: it fails at the paper's parameters, and holds at some others.
        (Verdict.CHOSEN, {"holds": False, "holds_finite": False, "holds_fixed_step": False, "share": 0.01}),
        (Verdict.CHOSEN, {"holds": False, "share": 0.9}),
        # Rule 7.
        (Verdict.NOT_REPRODUCED, {"holds": False}),
        (Verdict.NOT_REPRODUCED, {"holds": False, "holds_finite": False, "share": 0.0, "holds_fixed_step": False}),
    ],
)
def test_each_verdict_by_its_rule(expected, found):
    assert judge(Finding(**found, **ASIDE)) is expected


def test_every_combination_gives_a_verdict_and_each_verdict_can_be_given():
    maybe = (None, False, True)
    findings = itertools.product(maybe, maybe, (None, 0.0, 0.2, 0.8), maybe)
    given = {judge(Finding(holds=a, holds_finite=b, share=c, holds_fixed_step=d, **ASIDE)) for a, b, c, d in findings}
    assert given == set(Verdict)


def test_numbers_and_words_do_not_sway_a_verdict():
    plain = Finding(holds=False, holds_finite=True, **ASIDE)
    told = dataclasses.replace(plain, numbers=(Number("exponent", 0.3, error=0.1),), why="other", unseen="much")
    assert judge(told) is judge(plain)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (Number("threshold", 1.04321, error=0.00312), "1.0432 ± 0.0031"),
        (Number("voltage", 1.04321, low=1.03, high=1.05), "1.043 [1.030, 1.050]"),
        (Number("share", 0.2, low=0.03622, high=0.6245), "0.20 [0.04, 0.62]"),
        (Number("stroke", 12.3456, error=0.1, unit="mm"), "12.35 ± 0.10 mm"),
        (Number("count", 3.0, error=0.0), "3"),
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
