"""Kinds of motion in words, of made-up numbers."""

import pytest
import xarray as xr

from gelcone.analyses import (
    motions,
)  # fmt: skip
from gelcone.codes import Outcome, Regime
from tests.analyses.said import NAN, said
from tests.edited import edited, labelled, made


def exponents(**changes):
    own = {
        "outcome": 0, "lyapunov": ("exponent", [0.04, -0.06], "1/s"), "standard_error": ("exponent", [0.002, 0.003]),
        "sign": 1, "per_repeat": 0.5, "sum_residual": -3e-9, "finite": ("exponent", [0.0625, -0.125]),
        "finite_standard_error": ("exponent", [0.025, 0.0]), "finite_time": ("window", [10.0, 5000.0], "ms"),
        "averaged_time": (None, 240_000.0, "ms"), "cycle": 0,
    }  # fmt: skip
    return edited(made(own), **changes)


@pytest.mark.parametrize(
    ("sign", "word"), [(1, "certainly positive"), (0, "sign uncertain within the budget"), (-1, "certainly negative")]
)
def test_exponents_of_one_run(sign, word):
    """0.5 a repeat over 0.04 a second: a forcing period of 12.5 seconds."""
    assert said(motions.lyapunov_words, exponents(sign=sign)) == [
        f"largest exponent +0.0400 ± 0.0020 per second (+0.500 ± 0.025 per forcing period), {word}",
        "second exponent -0.0600 ± 0.0030 per second; the sum of all is off the mean trace by 3e-09 per second, "
        "0 without rounding",
        "averaged over 4 min after the transient",
        "over the first 5 s from the start: +0.062 ± 0.025, -0.125 per second",
    ]
    earlier = exponents().drop_vars("finite_standard_error")
    assert said(motions.lyapunov_words, earlier)[3] == "over the first 5 s from the start: +0.0625, -0.125 per second"


@pytest.mark.parametrize(
    ("cycle", "words_"), [(1, "rest or a cycle of 1 forcing period"), (3, "a cycle of 3 forcing periods")]
)
def test_exponents_of_a_cycle(cycle, words_):
    line = said(motions.lyapunov_words, exponents(cycle=cycle))[2]
    assert line == f"from the multipliers of what it settles on, {words_}"


def test_exponents_that_rounding_hides():
    hidden = exponents(lyapunov=[0.04, NAN], standard_error=[0.002, NAN], finite=[0.0625, NAN], sum_residual=NAN)
    lines = said(motions.lyapunov_words, hidden)
    assert lines[1] == "second exponent unknown per second; not all are known: rounding hides fast decays"
    assert lines[3] == "over the first 5 s from the start: +0.062 ± 0.025, unknown per second"


def test_exponents_of_an_ensemble_and_of_a_failed_run():
    failed = exponents(outcome=int(Outcome.PULLED_IN))
    assert said(motions.lyapunov_words, failed) == [f"failed: {Outcome.PULLED_IN.meaning}"]
    voltages = labelled(("voltage", [0.5, 0.75], "V")).assign_attrs(quantity="parameter")
    two = xr.concat([exponents(), failed], voltages.rename("voltage"))
    two["voltage"].attrs.update(quantity="parameter", units="V")
    lines = said(motions.lyapunov_words, two)
    assert lines[1] == "largest exponent in the long run:"
    assert lines[2].startswith("  voltage 0.5 V: +0.0400 ± 0.0020 per second (")
    assert lines[3] == "  voltage 0.75 V: failed, pulled in"


def motion(**changes):
    own = {
        "outcome": 0, "regime": int(Regime.PERIODIC), "period": 2, "symmetric": 0, "doubtful": 0, "zero_one": NAN,
        "lyapunov": ("exponent", [-0.25, -0.5], "1/s"), "standard_error": ("exponent", [0.0, 0.0]),
        "cycle_distance": 3e-9, "return_distance": 2e-7, "lowest": (None, 11.0, "mm"), "highest": (None, 14.0, "mm"),
        "averaged_time": (None, 240_000.0, "ms"), "settled_time": (None, 9000.0, "ms"), "validity_near_limit": 0.0,
        "validity_breakdown": 0.0,
    }  # fmt: skip
    return edited(made(own), **changes)


UNREPEATED = "the motion does not repeat: numbers are of one run, those of another differ"
HOLDS = "the model holds: film taut, away from its limits"


def test_the_kind_of_one_motion():
    base = [
        "periodic, period 2", "largest exponent -0.25 per second", "displacement 11 to 14 mm",
        "settled (within 3e-09 of its size)", "examined after 9 s; exponents of the cycle", HOLDS,
    ]  # fmt: skip
    assert said(motions.regime_words, motion()) == base
    assert said(motions.regime_words, motion(symmetric=1))[0] == "periodic, period 2, symmetric"
    near = motion(cycle_distance=NAN, doubtful=1)
    assert said(motions.regime_words, near) == [
        *base[:3], "points return to within 2e-07 of its size", "! the evidence disagrees",
        "examined after 9 s; exponents averaged over 4 min", HOLDS,
    ]  # fmt: skip
    chaos = motion(regime=int(Regime.CHAOTIC), period=0, cycle_distance=NAN, zero_one=0.875, settled_time=NAN)
    assert said(motions.regime_words, chaos) == ["chaotic", base[1], base[2], "0-1 test 0.88", UNREPEATED, HOLDS]
    lost = motion(validity_near_limit=0.125, validity_breakdown=NAN)
    assert said(motions.regime_words, lost)[-2:] == [
        "share of the motion in which the model does not hold: near the stretch limit 12.5 %",
        "breakdown unknown: the dielectric strength is not given",
    ]
    rest = motion(regime=int(Regime.REST), period=0, lowest=-1.083e-56, highest=1.332e-55)
    rest["lowest"].attrs["quantity"] = rest["highest"].attrs["quantity"] = "length"
    assert said(motions.regime_words, rest)[2] == "displacement 0 mm"
    failed = motion(outcome=int(Outcome.OUTSIDE), validity_near_limit=NAN, validity_breakdown=NAN)
    assert said(motions.regime_words, failed) == [
        f"failed: {Outcome.OUTSIDE.meaning}", "failed: outside",
    ]  # fmt: skip


def test_the_kinds_of_an_ensemble_have_a_line_each_with_the_first_evidence():
    voltages = labelled(("voltage", [0.5, 0.75], "V")).rename("voltage").assign_attrs(quantity="parameter")
    two = xr.concat([motion(), motion(lyapunov=[-0.5, -0.75], period=1)], voltages)
    two["voltage"].attrs.update(quantity="parameter", units="V")
    assert said(motions.regime_words, two)[-2:] == [
        "  voltage 0.5 V: periodic, period 2; largest exponent -0.25 per second",
        "  voltage 0.75 V: periodic, period 1; largest exponent -0.5 per second",
    ]
