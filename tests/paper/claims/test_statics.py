"""Verdicts on the claims about statics and the linear limit, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import found, number, verdict


def static(counts=(1, 1, 3), slopes=(0.4, -0.2, 0.4)):
    slope = np.full((3, 5), np.nan)
    slope[:2, 0] = 1.0
    slope[2, : len(slopes)] = slopes
    place = np.where(np.isfinite(slope), np.arange(5.0), np.nan)
    each = ("constant_voltage", "equilibrium")
    return xr.Dataset(
        {
            "equilibria": ("constant_voltage", list(counts)),
            "slope": (each, slope),
            "equilibrium_displacement": (each, place),
            "pitchfork_voltage": ((), 1.2247),
        },
        coords={"constant_voltage": [0.0, 1.0, 1.5]},
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.NOT_REPRODUCED, {"slopes": (-0.4, 0.2, -0.4)}),
        (Verdict.NOT_REPRODUCED, {"slopes": (0.4, 0.2, 0.4)}),
        (Verdict.NOT_REPRODUCED, {"counts": (3, 3, 1)}),
    ],
)
def test_three_equilibria_of_alternating_slope_at_the_highest_voltage(expected, changed):
    assert verdict("static-bistable", static=static(**changed)) is expected


def test_equilibria_are_listed_with_place_and_slope():
    finding = found("static-bistable", static=static())
    assert finding.numbers[0].value == 3.0
    assert [(one.meaning, one.value) for one in finding.numbers[1:4]] == [
        ("slope at x = 0", 0.4),
        ("slope at x = 1", -0.2),
        ("slope at x = 2", 0.4),
    ]
    assert number(finding, "pitchfork").value == 1.2247


def oscillator(ratio):
    amplitude = np.linspace(0.0, 1.0, 101)
    return xr.Dataset(
        {"period_ratio": ("amplitude", np.interp(amplitude, [0.0, 0.5, 1.0], ratio))}, coords={"amplitude": amplitude}
    )


@pytest.mark.parametrize(
    ("expected", "ratio"),
    [
        (Verdict.REPRODUCED, [1.0, 0.999, 0.991]),
        (Verdict.CHOSEN, [0.9, 0.9, 1.0]),  # linear at the paper's own amplitude and hardly at a smaller one
        (Verdict.REPRODUCED, [0.971, 0.991, 1.0]),  # at a little more than half of the smaller ones
        (Verdict.CHOSEN, [1.0, 0.99, 0.9]),
        (Verdict.CHOSEN, [1.0, 1.01, 1.1]),
        (Verdict.NOT_REPRODUCED, [0.9, 0.8, 0.7]),
    ],
)
def test_linear_is_within_one_percent_of_the_linear_period_at_the_papers_own_amplitude(expected, ratio):
    assert verdict("linear-limit", linear_limit=oscillator(ratio)) is expected


def test_how_far_the_oscillator_is_linear():
    finding = found("linear-limit", linear_limit=oscillator([1.0, 1.005, 1.015]))
    assert finding.numbers[0].value == pytest.approx(0.75)
    assert finding.share.value == pytest.approx(0.75, abs=0.02)
    assert finding.numbers[1].value == 1.015
    assert found("linear-limit", linear_limit=oscillator([1.0, 1.0, 1.0])).numbers[0].value == 1.0


def test_smaller_displacements_count_evenly_however_they_were_computed():
    """Close together at small ones, of which there are most; the period is off beyond a quarter."""
    amplitude = np.geomspace(1e-3, 1.0, 31)
    off = np.where(amplitude < 0.25, 0.0, 0.02)
    study = xr.Dataset({"period_ratio": ("amplitude", 1.0 + off)}, coords={"amplitude": amplitude})
    finding = found("linear-limit", linear_limit=study)
    assert finding.share.value == pytest.approx(0.22, abs=0.03)
    assert not finding.share.sample
    assert not finding.holds
