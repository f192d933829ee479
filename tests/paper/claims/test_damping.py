"""Verdicts on the claims about damping, on made-up studies."""

import numpy as np
import pytest

from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.verdicts import Verdict
from gelcone.presets import find_preset
from tests.paper.made_up import checked, diagram, found, number, verdict
from tests.paper.worlds import World, studies_in


@pytest.mark.parametrize("effort", [QUICK, FULL], ids=["quick", "full"])
def test_the_numbers_behind_damping_without_chaos(effort):
    studies = studies_in(World(lambda n: (n["voltage"] > 1.0) & (n["damping_ratio"] < 0.5)), NAME, effort)
    finding = checked(NAME, studies)
    assert finding.holds is True
    assert finding.share.interval[1] < 0.5 <= finding.share.holding / 10.0  # a third of 0.5 to 2, of 16 or more
    assert finding.numbers[0].value == 1.0
    largest = number(finding, "largest drive voltage")
    assert largest.low <= 1.0 < largest.high < 1.1
    assert largest.value == largest.low
    none = checked(NAME, studies_in(World(lambda n: n["voltage"] > 0.0), NAME, effort))
    assert np.isnan(number(none, "largest drive voltage").value)


def test_chaos_without_damping_does_not_speak_against_it():
    studies = studies_in(World(lambda n: n["damping_ratio"] == 0.0), NAME, QUICK)
    finding = checked(NAME, studies)
    assert finding.holds is True
    undamped = number(finding, "without damping")
    assert (undamped.value, undamped.error) == (0.1, 0.01)


NAME = "damping-never-chaotic"
GRID = np.array([0.0, 0.1, *np.linspace(0.5, 2.0, 31)])
LARGE = GRID[1:] >= 0.5


def order(overdamped=LARGE, largest=-0.1, apart=1.0, error=1e-4):
    """Exponents at a small damping ratio and 31 from the largest drawn, 0.5, on; equal ones oscillate."""
    base = diagram("damping_ratio", GRID, np.zeros(33), error=error)
    base["lyapunov"][:, 1:, 0] = largest
    base["lyapunov"][:, 1:, 1] = largest - apart * np.where(overdamped, 1.0, 0.0)
    return {"diagram_base_damping_ratio": base}


def only(*places):
    return np.isin(np.arange(32), places)


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        # two exponents apart by less than a fiftieth of the damping ratio are one, and so are those within their errors
        (Verdict.NOT_REPRODUCED, {"apart": 0.0099}),
        (Verdict.CHOSEN, {"apart": 0.0101}),  # enough at 0.5, not above
        (Verdict.NOT_REPRODUCED, {"apart": 0.59, "error": 0.1}),
        (Verdict.CHOSEN, {"overdamped": only(1)}),
        (Verdict.CHOSEN, {"overdamped": LARGE & ~only(1)}),
        (Verdict.CHOSEN, {"overdamped": only(*range(1, 16))}),  # over less than half of 0.5 to 2
        (Verdict.REPRODUCED, {"overdamped": only(*range(1, 19))}),
        (Verdict.UNDECIDED, {"overdamped": only(*range(1, 17))}),  # the edge lies about the middle
        (Verdict.NOT_REPRODUCED, {"largest": -1.0}),  # a swing halved in one oscillation is no slow decay
        (Verdict.NOT_REPRODUCED, {"overdamped": only()}),
    ],
)
def test_the_order_of_decay_and_overdamped_return(expected, changed):
    """The paper's own case is the largest that it draws; those larger are the others."""
    assert verdict("damping-order", **order(**changed)) is expected


@pytest.mark.parametrize(("smallest", "middle", "holds"), [(-0.1, -1.0, True), (-1.0, -0.1, False)])
def test_slow_decay_is_that_of_the_smallest_damping_ratio_drawn(smallest, middle, holds):
    """What the swing loses at the middle one, in which it loses more than half, decides nothing."""
    small, between, large = TRIPLES["damping"][2]
    base = diagram("damping_ratio", np.array([0.0, small, between, large, 2.0]), np.zeros(5), error=1e-4)
    largest = np.array([0.0, smallest, middle, -0.1, -0.1])
    base["lyapunov"][:] = np.stack([largest, largest - np.array([0.0, 0.0, 0.0, 1.0, 1.0])], axis=-1)
    assert found("damping-order", diagram_base_damping_ratio=base).holds is holds


def test_where_overdamping_begins():
    finding = found("damping-order", **order(overdamped=LARGE & ~only(1, 2)))
    assert finding.share.interval == pytest.approx((28.0 / 30.0, 28.0 / 30.0 + 1.0 / 30.0))
    first = finding.numbers[0]
    assert (first.low, first.high, first.value) == pytest.approx((0.55, 0.6, 0.6))
    assert number(finding, "critical damping").value == pytest.approx(0.9**0.5)
    assert np.isnan(found("damping-order", **order(overdamped=only())).numbers[0].value)


def test_no_voltage_above_one_with_chaos_is_without_chaos():
    """Of chaos between 0.8 and 1.2 alone the largest voltage without it lies below."""
    studies = studies_in(World(lambda n: np.abs(n["voltage"] - 1.0) < 0.2), NAME, QUICK)
    largest = number(checked(NAME, studies), "largest drive voltage")
    assert 0.5 < largest.value <= 0.8 <= largest.high < 1.0


def test_at_the_voltage_of_the_figure_rest_is_stable_as_the_reason_says():
    model = find_preset("base").model
    stable = PANELS["base", "damping_ratio"] < float(np.sqrt(model.stiffness(0.0)))
    finding = checked(NAME, studies_in(World(lambda n: n["voltage"] > 1.0), NAME, QUICK))
    assert (" rest is stable and " in finding.why, "below the loss of stability" in finding.unseen) == (stable, stable)
