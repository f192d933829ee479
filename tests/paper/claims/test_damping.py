"""Verdicts on the claims about damping, on made-up studies."""

import numpy as np
import pytest

from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import cells, diagram, found, number, verdict

ZETA = [0.0, 0.5, 1.0, 2.0]
VOLTAGES = [0.5, 1.0, 1.5, 2.0]


def studies(chaos=(1, 0, 0, 0), finite=(1, -1, -1, -1), calm=(1, 1, 1, 0)):
    plane = np.zeros((4, 3))
    plane[np.array(calm) == 0, 1] = 1
    wide = cells({"voltage": VOLTAGES, "damping_ratio": [0.1, 1.0, 2.0]}, plane)
    base = diagram("damping_ratio", ZETA, chaos, finite=np.array(finite, dtype=float))
    return {"diagram_base_damping_ratio": base, "diagram_fast_damping_ratio": base, "damping_map": wide}


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"calm": (1, 1, 0, 0)}),
        (Verdict.CHOSEN, {"calm": (1, 0, 0, 0)}),
        (Verdict.TRANSIENT, {"chaos": (0, 0, 0, 1)}),
        (Verdict.CHOSEN, {"chaos": (0, 0, 0, 1), "finite": (1, 1, -1, -1)}),
        (Verdict.NOT_REPRODUCED, {"chaos": (0, 1, 0, 0), "finite": (1, 1, -1, -1), "calm": (0, 0, 0, 0)}),
    ],
)
def test_whether_damping_allows_chaos(expected, changed):
    """Chaos without damping does not speak against it: the claim is about damping ratios above zero."""
    assert verdict("damping-never-chaotic", **studies(**changed)) is expected


def test_the_numbers_behind_damping_without_chaos():
    finding = found("damping-never-chaotic", **studies(chaos=(1, 0, 1, 0), calm=(1, 1, 0, 0)))
    assert finding.holds is False
    assert finding.share == 0.5
    assert finding.numbers[0].value == pytest.approx(2.0 / 3.0)
    undamped = number(finding, "without damping")
    assert (undamped.value, undamped.error) == (0.1, 0.01)
    largest = number(finding, "largest drive voltage")
    assert (largest.value, largest.error) == (1.0, 0.5)
    none = found("damping-never-chaotic", **studies(calm=(0, 0, 0, 0)))
    assert np.isnan(number(none, "largest drive voltage").value)


def order(largest=(-0.1, -0.2, -0.2, -0.3), second=(-0.1, -0.2, -0.8, -3.0), error=1e-4):
    base = diagram("damping_ratio", [0.0, 0.1, 0.2, 0.5, 2.0], np.zeros(5), error=error)
    base["lyapunov"][:, 1:, 0] = np.array(largest)
    base["lyapunov"][:, 1:, 1] = np.array(second)
    return {"diagram_base_damping_ratio": base}


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        # two exponents apart by less than a fiftieth of the damping ratio are one, and so are those within their errors
        (Verdict.CHOSEN, {"second": (-0.1, -0.2, -0.2099, -3.0)}),
        (Verdict.REPRODUCED, {"second": (-0.1, -0.2, -0.2101, -3.0)}),
        (Verdict.CHOSEN, {"second": (-0.1, -0.2, -0.79, -3.0), "error": 0.1}),
        (Verdict.CHOSEN, {"largest": (-0.1, 0.01, -0.2, -0.3)}),
        (Verdict.NOT_REPRODUCED, {"second": (-0.1, -0.2, -0.2, -0.3)}),
    ],
)
def test_the_order_of_decay_and_overdamped_return(expected, changed):
    assert verdict("damping-order", **order(**changed)) is expected


def test_where_overdamping_begins():
    finding = found("damping-order", **order())
    assert finding.share == 0.5
    assert finding.numbers[0].value == 0.5
    assert finding.numbers[0].error == pytest.approx(0.1)
    assert number(finding, "critical damping").value == pytest.approx(0.9**0.5)
    assert np.isnan(found("damping-order", **order(second=(-0.1, -0.2, -0.2, -0.3))).numbers[0].value)
