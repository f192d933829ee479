"""Verdicts on the claims about damping, on made-up studies."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import PERIODIC, cells, diagram, found, number, verdict

ZETA = np.linspace(0.0, 2.0, 41)
VOLTAGES = np.linspace(0.5, 2.0, 31)
CHAOS = np.array([1] + [0] * 40)
WINDOW = np.where(ZETA > 0.0, -1.0, 1.0)


def studies(chaos=CHAOS, finite=WINDOW, calm=25, own=True, kinds=None):
    """``calm`` of the 30 other voltages are without chaos, and the paper's own, the first, if ``own``."""
    plane = np.zeros((31, 3))
    plane[1 + calm :, 1] = 1
    plane[0, 1] = not own
    wide = cells({"voltage": VOLTAGES, "damping_ratio": [0.1, 1.0, 2.0]}, plane)
    base = diagram("damping_ratio", ZETA, chaos, finite=np.array(finite, dtype=float), kinds=kinds)
    return {"diagram_base_damping_ratio": base, "diagram_fast_damping_ratio": base, "damping_map": wide}


ONE = np.where(np.arange(41) == 20, 1, CHAOS)
SEEN = np.where(np.arange(41) == 20, 1.0, WINDOW)
UNSETTLED = np.where(np.arange(41) > 30, int(Regime.TRANSIENT), int(PERIODIC))


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"own": False}),  # the map's row at the paper's own voltage is not a neighbour
        (Verdict.UNDECIDED, {"calm": 17}),
        (Verdict.UNDECIDED, {"kinds": UNSETTLED, "chaos": 0 * CHAOS}),
        (Verdict.CHOSEN, {"calm": 5}),
        (Verdict.TRANSIENT, {"chaos": ONE}),
        (Verdict.CHOSEN, {"chaos": ONE, "finite": SEEN}),
        (Verdict.NOT_REPRODUCED, {"chaos": ONE, "finite": SEEN, "calm": 0}),
    ],
)
def test_whether_damping_allows_chaos(expected, changed):
    """Chaos without damping does not speak against it: the claim is about damping ratios above zero."""
    assert verdict("damping-never-chaotic", **studies(**changed)) is expected


def test_the_numbers_behind_damping_without_chaos():
    finding = found("damping-never-chaotic", **studies(chaos=ONE, calm=10))
    assert finding.holds is False
    assert finding.share == Share(10, 20)
    assert finding.numbers[0].value == pytest.approx(39.0 / 40.0)
    undamped = number(finding, "without damping")
    assert (undamped.value, undamped.error) == (0.1, 0.01)
    largest = number(finding, "largest drive voltage")
    assert (largest.value, largest.error) == pytest.approx((1.0, 0.05))
    none = found("damping-never-chaotic", **studies(calm=0))
    assert np.isnan(number(none, "largest drive voltage").value)


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
        (Verdict.UNDECIDED, {"overdamped": only(1, *range(16))}),
        (Verdict.NOT_REPRODUCED, {"largest": -1.0}),  # a swing halved in one oscillation is no slow decay
        (Verdict.NOT_REPRODUCED, {"overdamped": only()}),
    ],
)
def test_the_order_of_decay_and_overdamped_return(expected, changed):
    """The paper's own case is the largest that it draws; those larger are the others."""
    assert verdict("damping-order", **order(**changed)) is expected


def test_where_overdamping_begins():
    finding = found("damping-order", **order(overdamped=LARGE & ~only(1, 2)))
    assert finding.share == Share(29, 1)
    assert finding.numbers[0].value == pytest.approx(0.6)
    assert number(finding, "critical damping").value == pytest.approx(0.9**0.5)
    assert np.isnan(found("damping-order", **order(overdamped=only())).numbers[0].value)
