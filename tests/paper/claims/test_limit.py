"""Verdicts on the claims about the stretch limit, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import both_exponents, cells, diagram, found, number, verdict

LIMITS = [0.5, 1.0, 1.4, 1.6, 3.0, 10.0]
BELOW = [1, 1, 1, 0, 0, 0]
VOLTAGES = [0.7, 1.0, 1.6]


def threshold(chaos=BELOW, finite=(1, 1, 1, -1, -1, -1), largest=(1.0, 1.4, 1.6)):
    plane = np.array([[limit <= top for limit in LIMITS] for top in largest])
    over = {"voltage": VOLTAGES, "stretch_limit": LIMITS}
    return {
        "diagram_fast_stretch_limit": diagram("stretch_limit", LIMITS, chaos, finite=np.array(finite, dtype=float)),
        "limit_map": cells(over, plane),
    }


NEVER = (-1.0,) * 6


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),  # between 1.4 and 1.6
        (Verdict.CHOSEN, {"largest": (0.5, 0.5, 1.4)}),
        (Verdict.TRANSIENT, {"chaos": [1, 0, 0, 0, 0, 0]}),
        (Verdict.TRANSIENT, {"chaos": [1, 1, 1, 1, 1, 0]}),
        (Verdict.TRANSIENT, {"chaos": [0] * 6}),
        (Verdict.CHOSEN, {"chaos": [1, 0, 0, 0, 0, 0], "finite": (1, 1, 1, 1, -1, -1)}),
        (Verdict.CHOSEN, {"chaos": [1, 0, 0, 0, 0, 0], "finite": (1, -1, 1, -1, -1, -1)}),
        (Verdict.NOT_REPRODUCED, {"chaos": [1, 0, 0, 0, 0, 0], "finite": NEVER, "largest": (0.5, 3.0, 0.1)}),
    ],
)
def test_the_threshold_of_the_stretch_limit(expected, changed):
    assert verdict("limit-threshold", **threshold(**changed)) is expected


@pytest.mark.parametrize(
    ("tops", "share"), [((1.0, 1.4, 1.6), 1.0), ((0.5, 1.4, 3.0), 1.0 / 3.0), ((0.1, 0.5, 10.0), 0.0)]
)
def test_a_neighbouring_voltage_counts_where_its_threshold_is_within_a_factor_of_1_5(tops, share):
    finding = found("limit-threshold", **threshold(largest=tops))
    assert finding.share == pytest.approx(share)
    shown = list(finding.details.values())
    assert shown == [f"{top:.3g}" if top >= 0.5 else "none from 0.5 on" for top in tops]
    assert ("none at v = 0.7" in finding.unseen) == (tops[0] < 0.5)


def test_shares_of_chaos_on_both_sides_of_1_5():
    finding = found("limit-threshold", **threshold(chaos=[1, 0, 1, 0, 0, 1]))
    assert number(finding, "below 1.5 with").value == pytest.approx(2.0 / 3.0)
    assert number(finding, "above 1.5 with").value == pytest.approx(1.0 / 3.0)
    assert len(found("limit-threshold", **threshold(chaos=[0] * 6)).numbers) == 2


# --- large limits -----------------------------------------------------------------------------------------------------


def large(extents=((1.0, 1.0, 1.0), (2.0, 2.01, 2.0), (3.0, 3.0, 3.0)), shift=(0.0, 0.0, 0.0), mirrored=False):
    """Three voltages, the second the paper's own, and three limits; motions are sines of the given extents."""
    extents = np.array(extents)
    time = np.linspace(0.0, 6.0, 50)
    x = extents[..., None] * np.sin(time) + np.array(shift)[:, None, None] * np.array([1.0, 0.0, 0.0])[None, :, None]
    highest, lowest = extents, -0.5 * extents
    if mirrored:
        highest, lowest = np.where([[1, 0, 1]], highest, -lowest), np.where([[1, 0, 1]], lowest, -highest)
    at = ("voltage_index", "limit_index")
    return xr.Dataset(
        {
            "displacement": ((*at, "time"), x),
            "highest": (at, highest),
            "lowest": (at, lowest),
            "voltage": (at, np.broadcast_to([[0.5], [1.005], [1.7]], (3, 3))),
        }
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"mirrored": True}),
        (Verdict.CHOSEN, {"extents": ((1.0, 2.0, 1.0), (2.0, 2.0, 2.0), (3.0, 2.0, 3.0))}),
        (Verdict.CHOSEN, {"extents": ((1.0, 1.0, 1.0), (2.2, 2.0, 2.0), (3.0, 3.0, 3.0))}),
        (Verdict.NOT_REPRODUCED, {"extents": ((1.1, 1.0, 1.0), (2.2, 2.0, 2.0), (3.3, 3.0, 3.0))}),
    ],
)
def test_large_limits_are_the_same_at_the_papers_own_voltage(expected, changed):
    assert verdict("limit-large-same", large_limits=large(**changed)) is expected


def test_large_limits_may_agree_over_the_window_alone():
    study = large()
    study["highest"][1, 0] = 3.0
    assert verdict("limit-large-same", large_limits=study) is Verdict.TRANSIENT
    study["displacement"][1, 0] += 1.0
    assert verdict("limit-large-same", large_limits=study) is Verdict.CHOSEN


def test_numbers_of_the_largest_limits():
    finding = found(
        "limit-large-same",
        large_limits=large(extents=((1.0, 1.0, 1.0), (2.04, 2.0, 2.0), (3.3, 3.0, 3.0)), shift=(0.0, 0.0, 0.0)),
    )
    key = finding.numbers[0]
    assert (key.value, key.error) == pytest.approx((0.02, 1e-4 / 2.0))
    assert finding.share == pytest.approx(2.0 / 3.0)
    assert number(finding, "same extent").value == pytest.approx(2.0 / 3.0)
    assert number(finding, "share of these voltages").value == pytest.approx(2.0 / 3.0)
    assert number(finding, "v = 1.005").value == pytest.approx(0.04 / 2.04, rel=0.01)
    assert "that of v = 1.005" in finding.unseen
    assert "for 2 of 3" in finding.unseen
    small = large()
    small["highest"][1], small["lowest"][1] = [0.006, 0.005, 0.005], 0.0
    finding = found("limit-large-same", large_limits=small)
    assert finding.numbers[0].value == pytest.approx(0.1)  # of at least a hundredth


# --- tiny limits ------------------------------------------------------------------------------------------------------


def beyond(fixed=(1.0, -1.0, 1.0, -9.0), inside=(0.1, 0.1, 0.1, -9.0), error=0.01):
    return xr.Dataset(
        {
            "initial_strain": ("limit", np.full(4, 0.5)),
            "fixed_step_exponent": ("limit", list(fixed)),
            "lyapunov": (("limit", "exponent"), both_exponents(inside)),
            "standard_error": (("limit", "exponent"), np.full((4, 2), error)),
            "stretch_limit": ("limit", [0.2, 0.1, 0.5, 0.6]),
        }
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.ARTEFACT, {}),
        (Verdict.NOT_REPRODUCED, {"fixed": (1.0, 1.0, 1.0, -9.0)}),
        (Verdict.CHOSEN, {"fixed": (1.0, 1.0, 1.0, -9.0), "inside": (-0.1, 0.1, 0.1, 0.1)}),
        (Verdict.NOT_REPRODUCED, {"fixed": (1.0, 1.0, 1.0, -9.0), "inside": (-0.1, 0.1, 0.1, 0.1), "error": 0.04}),
    ],
)
def test_negative_exponents_beyond_the_limit_are_an_artefact(expected, changed):
    """The initial state lies beyond the limits up to its strain 0.5, that one included."""
    assert verdict("limit-tiny-negative", beyond=beyond(**changed)) is expected


def test_numbers_at_the_smallest_limit():
    finding = found("limit-tiny-negative", beyond=beyond(inside=(-0.1, 0.2, 0.1, -0.1)))
    assert finding.numbers[0].value == 0.5
    assert finding.numbers[1].value == finding.share == pytest.approx(1.0 / 3.0)
    assert (finding.numbers[2].value, finding.numbers[2].error) == (0.2, 0.01)
    assert finding.numbers[3].value == -1.0
    assert "1 of 3 stretch limits" in finding.why


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
