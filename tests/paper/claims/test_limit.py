"""Verdicts on the claims about the stretch limit, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.reading import parted, same_extents
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import both_exponents, cells, checked, found, number, verdict
from tests.paper.worlds import World, studies_in


@pytest.mark.parametrize("effort", [QUICK, FULL], ids=["quick", "full"])
def test_shares_of_chaos_on_both_sides_and_the_largest_limit_over_the_voltage(effort):
    def chaos(n):
        low = np.where(n["voltage"] > 1.2, n["stretch_limit"] < 5.0, n["stretch_limit"] < 0.8)
        return low & (n["voltage"] > 0.8)

    finding = checked("limit-threshold", studies_in(World(chaos), "limit-threshold", effort))
    assert finding.holds is False
    below, above = number(finding, "below 1.25 with"), number(finding, "above 1.8 with")
    assert below.low <= np.log(0.8 / 0.52) / np.log(1.25 / 0.52) <= below.high
    assert above.value == 1.0
    first = finding.numbers[0]
    assert first.meaning == "largest stretch limit at which chaos was seen"
    assert first.low == first.value <= 0.8 < first.high
    shown = list(finding.details.values())
    assert shown[0] == "none from 0.52 on"
    assert 0.52 <= float(shown[len(shown) // 2]) < 0.8
    assert 3.0 < float(shown[-1]) < 5.0


def test_without_chaos_there_is_no_threshold_to_print():
    never = World(lambda n: n["voltage"] < 0.0)
    assert len(checked("limit-threshold", studies_in(never, "limit-threshold", QUICK)).numbers) == 2


@pytest.mark.parametrize(
    ("below", "above", "truth"),
    [
        ("3333", "1111", 1.0),
        ("3331", "0101", 1.0),
        ("3311", "1111", 0.0),  # half is not most
        ("3333", "1131", 0.0),
        ("3333", "1151", 0.0),  # a run that ended is no regular motion
        ("3344", "1111", np.nan),
        ("3334", "1111", 1.0),
        ("3333", "1141", np.nan),
    ],
)
def test_a_voltage_parts_chaos_from_regular_motion(below, above, truth):
    limits = np.array([0.6, 0.8, 1.0, 1.2, 2.0, 4.0, 8.0, 16.0])
    kinds = np.array([[int(k) for k in below + above]])
    study = cells({"point": [0]}, [False]).drop_vars(["regime"]).isel(point=[0])
    study = study.assign(regime=(("point", "inner"), kinds), stretch_limit=(("point", "inner"), limits[None]))
    np.testing.assert_equal(parted(study), [truth])


# --- large limits -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("first", "last", "kinds", "truth"),
    [
        ([1.0, 1.0], [1.04, 1.04], (1, 1), 1.0),
        ([1.0, 2.0], [2.04, 1.04], (1, 1), 1.0),  # each has one that is the same
        ([1.0, 2.0], [1.0, 1.0], (1, 1), np.nan),  # the start decides
        ([1.0, 1.0], [2.0, 1.0], (1, 1), np.nan),
        ([1.0, 2.0], [1.0, 1.0], (3, 3), 1.0),  # chaos covers its extent slowly
        ([1.0, 2.0], [1.0, 1.0], (3, 1), np.nan),
        ([1.0, 1.0], [1.2, 1.2], (1, 1), 0.0),
        ([1.0, 1.0], [1.2, 1.2], (3, 3), 0.0),
        ([0.005, 0.005], [0.0054, 0.0054], (1, 1), 1.0),  # of at least a hundredth
        ([np.nan, 1.0], [1.0, 1.0], (1, 1), np.nan),
    ],
)
def test_extents_are_the_same_from_each_start_or_from_none(first, last, kinds, truth):
    extent = np.array([[first, last, last]])
    codes = np.array([[[kinds[0]] * 2, [kinds[1]] * 2, [kinds[1]] * 2]])
    np.testing.assert_equal(same_extents(extent, codes), [truth])


def test_numbers_of_the_largest_limits():
    world = World(lambda n: n["voltage"] < 0.0, extent=lambda n: np.where(n["voltage"] > 1.1, n["stretch_limit"], 1.0))
    studies = studies_in(world, "limit-large-same", QUICK)
    study = studies["large-limits"]
    time = np.linspace(0.0, 6.0, study.sizes["time"])
    waves = np.array([1.2, 1.0, 1.0])[:, None] * np.sin(time)
    own = study["own_extent"].values.copy()
    own[0, 0] = 1.2 * own[2, 0]
    study = study.assign(displacement=(("limit", "time"), waves), own_extent=(study["own_extent"].dims, own))
    finding = checked("limit-large-same", {"large-limits": study})
    key = finding.numbers[0]
    assert (key.value, key.low, key.high) == pytest.approx((0.2, 0.0, 0.2))
    assert finding.share.value == pytest.approx(0.5, abs=0.04)
    assert number(finding, "v = 1.005").value == pytest.approx(0.2 / 1.2, rel=0.01)
    assert "that of v = 1.005" in finding.unseen


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
        (Verdict.NOT_REPRODUCED, {}),  # one of three is chance
        (Verdict.NOT_REPRODUCED, {"fixed": POSITIVE}),
        (Verdict.CHOSEN, {"fixed": POSITIVE, "inside": (-0.1, 0.1, 0.1, 0.1)}),
        (Verdict.NOT_REPRODUCED, {"fixed": POSITIVE, "inside": (-0.1, 0.1, 0.1, 0.1), "error": 0.04}),
        # a start that the smallest limits allow shows a negative exponent itself
        (Verdict.UNDECIDED, {"inside": (-0.1, -0.1, 0.1, 0.1), "strain": 0.15}),
    ],
)
def test_negative_exponents_at_small_limits(expected, changed):
    """The initial state lies beyond the limits up to its strain 0.5, that one included."""
    assert verdict("limit-tiny-negative", beyond=beyond(**changed)) is expected


def test_a_fixed_step_run_that_is_negative_at_most_limits_is_an_artefact():
    study = xr.concat([beyond(fixed=(-1.0, -1.0, -1.0, 1.0))] * 5, "limit")
    assert verdict("limit-tiny-negative", beyond=study) is Verdict.ARTEFACT


def test_negative_exponents_from_the_papers_start_and_others_are_reproduced():
    study = xr.concat([beyond(inside=(-0.1, -0.1, -0.1, 0.1), strain=0.4)] * 5, "limit")
    assert verdict("limit-tiny-negative", beyond=study) is Verdict.REPRODUCED


def test_fixed_step_runs_at_limits_that_the_start_allows_are_no_artefact():
    """Negative at these alone, which are most of the small limits."""
    study = xr.concat([beyond(fixed=(-1.0, 1.0, -1.0, -1.0), strain=0.15)] * 9, "limit")
    assert found("limit-tiny-negative", beyond=study).holds_fixed_step is False


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
