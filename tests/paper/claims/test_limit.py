"""Verdicts on the claims about the stretch limit, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import both_exponents, cells, diagram, found, number, triple, verdict

LIMITS = np.concatenate([np.linspace(0.52, 1.24, 40), [1.4, 1.6], np.linspace(1.81, 10.0, 40)])
BELOW = LIMITS < 1.5
VOLTAGES = np.linspace(0.705, 1.305, 21)  # 1.005 is the eleventh


def threshold(chaos=BELOW, finite=BELOW, tops=(1.4,) * 21):
    """Chaos up to a stretch limit at each voltage of the map, ``tops``."""
    plane = np.array([[limit <= top for limit in LIMITS] for top in tops])
    over = {"voltage": VOLTAGES, "stretch_limit": LIMITS}
    finite = np.where(finite, 1.0, -1.0)
    return {
        "diagram_fast_stretch_limit": diagram("stretch_limit", LIMITS, chaos, finite=finite),
        "limit_map": cells(over, plane),
        "limit": triple("stretch_limit"),
    }


FEW = LIMITS < 1.0
NEVER = LIMITS < 0.0


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"chaos": LIMITS < 1.3}),  # about 1.5 leaves a fifth to either side
        (Verdict.REPRODUCED, {"tops": (1.4,) * 10 + (0.1,) + (1.4,) * 10}),  # the own voltage is no neighbour
        (Verdict.CHOSEN, {"tops": (0.6,) * 10 + (1.4,) + (0.6,) * 10}),
        (Verdict.UNDECIDED, {"tops": (0.6,) * 10 + (1.4,) * 11}),
        (Verdict.UNDECIDED, {"chaos": BELOW & (np.arange(82) % 10 > 0)}),  # nine of ten
        (Verdict.TRANSIENT, {"chaos": FEW}),
        (Verdict.TRANSIENT, {"chaos": LIMITS < 5.0}),
        (Verdict.CHOSEN, {"chaos": FEW, "finite": FEW}),
        (Verdict.NOT_REPRODUCED, {"chaos": FEW, "finite": NEVER, "tops": (5.0,) * 21}),
    ],
)
def test_the_threshold_of_the_stretch_limit(expected, changed):
    assert verdict("limit-threshold", **threshold(**changed)) is expected


def test_another_voltage_counts_where_chaos_is_below_about_1_5_and_not_above():
    tops = [1.4] * 21
    tops[0], tops[1], tops[2] = 0.1, 0.8, 1.9
    finding = found("limit-threshold", **threshold(tops=tops))
    assert finding.share == Share(17, 3)
    shown = list(finding.details.values())
    assert shown[:4] == ["none from 0.52 on", "0.797", "1.81", "1.4"]
    assert "none at v = 0.705" in finding.unseen


def test_shares_of_chaos_on_both_sides():
    finding = found("limit-threshold", **threshold(chaos=(np.arange(82) % 4 == 0)))
    assert number(finding, "below 1.25 with").value == pytest.approx(0.25)
    assert number(finding, "above 1.8 without").value == pytest.approx(0.75)
    assert len(found("limit-threshold", **threshold(chaos=NEVER)).numbers) == 2


# --- large limits -----------------------------------------------------------------------------------------------------

SPEEDS = np.linspace(0.505, 1.705, 25)  # 1.005 is the eleventh
OWN = 10


def large(different=(), other=(), open_=(), mirrored=False, small=False):
    """Voltages of which some (by index) differ in extent between the limits; three limits, four starts each.

    ``different`` for all starts, ``open_`` for one of them; the window is that of sines of the first start's extent.
    """
    extent = np.ones((25, 3, 4))
    extent[list(different), 0] = 1.2
    extent[list(open_), 0, 0] = 1.2
    time = np.linspace(0.0, 6.0, 50)
    window = np.ones((25, 3))
    window[list(other), 0] = 1.2
    highest, lowest = extent, -0.5 * extent
    if mirrored:
        highest, lowest = np.where([[[1], [0], [1]]], highest, -lowest), np.where([[[1], [0], [1]]], lowest, -highest)
    if small:
        highest, lowest = 0.005 + 0.001 * (extent > 1.0), 0.0 * extent
    at = ("voltage_index", "limit_index")
    return xr.Dataset(
        {
            "displacement": ((*at, "time"), window[..., None] * np.sin(time)),
            "highest": ((*at, "start"), highest),
            "lowest": ((*at, "start"), lowest),
            "voltage": (at, np.repeat(SPEEDS[:, None], 3, axis=1)),
        }
    )


REST = tuple(k for k in range(25) if k != OWN)


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"mirrored": True}),
        (Verdict.CHOSEN, {"different": REST}),
        (Verdict.CHOSEN, {"different": (OWN,), "other": (OWN,)}),
        (Verdict.TRANSIENT, {"different": (OWN,)}),
        (Verdict.UNDECIDED, {"open_": (OWN,), "other": (OWN,)}),
        (Verdict.UNDECIDED, {"open_": REST}),
        (Verdict.NOT_REPRODUCED, {"different": range(25), "other": range(25)}),
    ],
)
def test_large_limits_are_the_same_at_the_papers_own_voltage(expected, changed):
    assert verdict("limit-large-same", large_limits=large(**changed)) is expected


def test_numbers_of_the_largest_limits():
    finding = found("limit-large-same", large_limits=large(different=(0, 1), other=(OWN,), open_=(2, OWN)))
    key = finding.numbers[0]
    assert (key.value, key.low, key.high) == pytest.approx((0.2, 0.0, 0.2))
    assert finding.share == Share(21, 2, open=1)
    assert number(finding, "same time series").value == pytest.approx(24.0 / 25.0)
    assert number(finding, "v = 1.005").value == pytest.approx(0.2 / 1.2, rel=0.01)
    assert "that of v = 1.005" in finding.unseen
    small = found("limit-large-same", large_limits=large(different=(OWN,), small=True))
    assert small.numbers[0].value == pytest.approx(0.1)  # of at least a hundredth


# --- tiny limits ------------------------------------------------------------------------------------------------------


def beyond(fixed=(1.0, -1.0, 1.0, -9.0), inside=(0.1, 0.1, 0.1, -9.0), error=0.01, strain=0.5):
    return xr.Dataset(
        {
            "initial_strain": ("limit", np.full(4, strain)),
            "fixed_step_exponent": ("limit", list(fixed)),
            "lyapunov": (("limit", "exponent"), both_exponents(inside)),
            "standard_error": (("limit", "exponent"), np.full((4, 2), error)),
            "stretch_limit": ("limit", [0.2, 0.1, 0.5, 0.6]),
        }
    )


POSITIVE = (1.0, 1.0, 1.0, -9.0)


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.ARTEFACT, {}),
        (Verdict.NOT_REPRODUCED, {"fixed": POSITIVE}),
        (Verdict.CHOSEN, {"fixed": POSITIVE, "inside": (-0.1, 0.1, 0.1, 0.1)}),
        (Verdict.NOT_REPRODUCED, {"fixed": POSITIVE, "inside": (-0.1, 0.1, 0.1, 0.1), "error": 0.04}),
        # a start that the smallest limits allow shows a negative exponent itself
        (Verdict.UNDECIDED, {"inside": (-0.1, -0.1, 0.1, 0.1), "strain": 0.15}),
    ],
)
def test_negative_exponents_beyond_the_limit_are_an_artefact(expected, changed):
    """The initial state lies beyond the limits up to its strain 0.5, that one included."""
    assert verdict("limit-tiny-negative", beyond=beyond(**changed)) is expected


def test_negative_exponents_from_the_papers_start_and_others_are_reproduced():
    study = xr.concat([beyond(inside=(-0.1, -0.1, -0.1, 0.1), strain=0.4)] * 5, "limit")
    assert verdict("limit-tiny-negative", beyond=study) is Verdict.REPRODUCED


def test_numbers_at_the_smallest_limit():
    finding = found("limit-tiny-negative", beyond=beyond(inside=(-0.1, 0.2, 0.1, -0.1)))
    assert finding.numbers[0].value == 0.5
    assert finding.share == Share(1, 2)
    assert finding.numbers[1].value == pytest.approx(1.0 / 3.0)
    assert (finding.numbers[2].value, finding.numbers[2].error) == (0.2, 0.01)
    assert finding.numbers[3].value == -1.0


# --- energies ---------------------------------------------------------------------------------------------------------


def energies(slopes=(4.0, 2.0, 1.0), sharp=5.0):
    """Three limits; the force of the second ends at 1.9, and rises there by a factor."""
    x = np.linspace(-2.0, 2.0, 41)
    force = np.array(slopes)[:, None] * x
    force[0, np.abs(x) > 0.95] = np.nan
    near = np.argmin(np.abs(x - 0.95 * 1.9))
    force[1, near] = sharp * force[2, near]
    force[1, np.abs(x) > 1.9] = np.nan
    return xr.Dataset(
        {"film_force": (("stretch_limit", "displacement"), force), "reach": ("stretch_limit", [1.0, 1.9, 3.0])},
        coords={"stretch_limit": [0.5, 1.0, 100.0], "displacement": x},
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.NOT_REPRODUCED, {"sharp": 1.99}),
        (Verdict.REPRODUCED, {"sharp": 2.01}),
        (Verdict.NOT_REPRODUCED, {"slopes": (2.0, 2.0, 1.0)}),
        (Verdict.NOT_REPRODUCED, {"slopes": (1.0, 2.0, 3.0)}),
    ],
)
def test_energies_steepen_as_the_limit_falls(expected, changed):
    assert verdict("energy-steepening", energy=energies(**changed)) is expected


def test_numbers_of_the_steepening():
    finding = found("energy-steepening", energy=energies())
    assert [one.value for one in finding.numbers] == pytest.approx([1.0, 1.9, 5.0])
