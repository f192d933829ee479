"""Verdicts on the claims about the map over voltage and pre-stretch, on made-up maps."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from gelcone.statistics import wilson
from tests.paper.made_up import cells, found, number, triple, verdict

STRETCHES = np.linspace(0.4, 2.0, 33)
VOLTAGES = np.linspace(0.0, 2.0, 33)
MANY = VOLTAGES[VOLTAGES >= 1.6].size


def where(rule):
    """Chaos by (voltage, pre-stretch)."""
    return np.array([[rule(v, p) for p in STRETCHES] for v in VOLTAGES], dtype=bool)


NONE, ALL = where(lambda v, p: False), where(lambda v, p: True)
HIGH = where(lambda v, p: v >= 1.6)


def plane(chaos, **more):
    return cells({"voltage": VOLTAGES, "prestretch": STRETCHES}, chaos, **more)


def maps(radial, equibiaxial=None, **more):
    return {
        "map_radial": plane(radial, **more),
        "map_equibiaxial": plane(radial if equibiaxial is None else equibiaxial, **more),
        "voltage": triple("voltage"),
        "prestretch": triple("prestretch"),
    }


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial"),
    [
        (Verdict.REPRODUCED, HIGH, HIGH),
        (Verdict.REPRODUCED, HIGH & where(lambda v, p: v != 2.0), HIGH),
        (Verdict.CHOSEN, HIGH, NONE),
        # three quarters of the pre-stretches are not all
        (Verdict.CHOSEN, HIGH & where(lambda v, p: p < 1.6), HIGH & where(lambda v, p: p < 0.8)),
        (Verdict.UNDECIDED, where(lambda v, p: v >= 1.8), HIGH),
        (Verdict.NOT_REPRODUCED, where(lambda v, p: v < 1.6), NONE),
        (Verdict.NOT_REPRODUCED, NONE, NONE),
    ],
)
def test_high_voltage(expected, radial, equibiaxial):
    assert verdict("map-high-voltage", **maps(radial, equibiaxial)) is expected


def test_high_voltage_counts_certain_exponents_from_the_voltage_1_6_on():
    finding = found("map-high-voltage", **maps(HIGH & where(lambda v, p: p < 0.4 + 9 * 0.05 - 1e-9), ALL))
    assert finding.numbers[0].value == pytest.approx(9.0 / 33.0)
    assert finding.numbers[1].value == 1.0
    smallest = number(finding, "smallest such share")
    assert smallest.value == 0.0
    assert smallest.high == pytest.approx(wilson(0.0, 8 * MANY)[1])
    assert finding.share == Share(4, 0, sample=False)
    assert found("map-high-voltage", **maps(ALL, error=0.05)).holds is None  # 0.1 is no more than three errors


LOW = where(lambda v, p: v == 0.5 and p <= 0.8)
OUTSIDE = where(lambda v, p: v > 1.04 or p > 0.8)
NEVER, SEEN = NONE - 1.0, LOW - 0.5


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial", "finite"),
    [
        (Verdict.REPRODUCED, LOW, LOW, NEVER),
        (Verdict.CHOSEN, LOW, NONE, NEVER),
        (Verdict.TRANSIENT, OUTSIDE, NONE, SEEN),
        (Verdict.CHOSEN, NONE, LOW, NEVER),
        (Verdict.UNDECIDED, LOW & where(lambda v, p: p < 0.6), LOW, NEVER),
        (Verdict.NOT_REPRODUCED, OUTSIDE, NONE, NEVER),
    ],
)
def test_low_prestretch(expected, radial, equibiaxial, finite):
    """Up to 0.8 it is small, and below 1.04 the voltage is moderate."""
    assert verdict("map-low-prestretch", **maps(radial, equibiaxial, finite=finite)) is expected


def test_the_shares_of_low_prestretches():
    finding = found("map-low-prestretch", **maps(LOW, LOW & where(lambda v, p: p < 0.55)))
    assert [one.value for one in finding.numbers] == pytest.approx([1.0, 3.0 / 9.0])
    assert finding.share == Share(3, 6)


BELOW = where(lambda v, p: v > 1.0 and p < 1.5)
ONE = where(lambda v, p: v == 2.0 and p == 2.0)


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial", "finite"),
    [
        (Verdict.REPRODUCED, BELOW, BELOW, NEVER),
        (Verdict.CHOSEN, BELOW, ONE, NEVER),
        (Verdict.CHOSEN, ONE, BELOW, NONE + 1.0),
        (Verdict.TRANSIENT, ONE, ONE, NEVER),
        (Verdict.UNDECIDED, where(lambda v, p: p < 2.0), BELOW, NEVER),  # one pre-stretch is too little to say so
        (Verdict.NOT_REPRODUCED, ALL, ALL, NONE + 1.0),
    ],
)
def test_safe_prestretch(expected, radial, equibiaxial, finite):
    assert verdict("map-safe-prestretch", **maps(radial, equibiaxial, finite=finite)) is expected


@pytest.mark.parametrize(
    ("equibiaxial", "edge"),
    [
        (BELOW, 1.5),
        (NONE, 0.4),
        (where(lambda v, p: p < 2.0), 2.0),
        (ONE, np.nan),
    ],
)
def test_from_which_prestretch_on_there_is_no_chaos(equibiaxial, edge):
    finding = found("map-safe-prestretch", **maps(NONE, equibiaxial))
    one = number(finding, "from which on")
    assert one.value == pytest.approx(edge, nan_ok=True)
    assert one.error == pytest.approx(0.05)
    assert finding.numbers[0].value == 1.0
    assert finding.numbers[1].value == pytest.approx(1.0 - equibiaxial.any(axis=0).mean())


# --- pockets ----------------------------------------------------------------------------------------------------------


def with_pockets(pockets, rest=None, uncertain=()):
    """A chaotic map of 7 by 7 cells with regular cells."""
    kinds = np.full((7, 7), int(Regime.CHAOTIC))
    sign = np.ones((7, 7), dtype=int)
    for cell in pockets:
        kinds[cell], sign[cell] = int(Regime.PERIODIC), -1
    for cell in uncertain:
        sign[cell] = 0
    if rest is not None:
        kinds[rest] = int(Regime.REST)
    over = {"voltage": np.arange(7.0), "prestretch": np.arange(7.0)}
    return cells(over, kinds == Regime.CHAOTIC, kinds=kinds, sign=sign)


POCKET = [(3, 3), (3, 4)]


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial"),
    [
        (Verdict.REPRODUCED, with_pockets(POCKET), with_pockets(POCKET)),
        (Verdict.CHOSEN, with_pockets(POCKET), with_pockets([])),
        (Verdict.CHOSEN, with_pockets([]), with_pockets(POCKET)),
        (Verdict.NOT_REPRODUCED, with_pockets([(3, 3)]), with_pockets([(3, 3)])),
    ],
)
def test_a_pocket_has_two_cells_or_more(expected, radial, equibiaxial):
    assert verdict("stable-pocket", map_radial=radial, map_equibiaxial=equibiaxial) is expected


@pytest.mark.parametrize(
    "open_map",
    [
        with_pockets([(0, 3), (1, 3)]),
        with_pockets([(6, 3), (5, 3)]),
        with_pockets([(3, 0), (3, 1)]),
        with_pockets([(3, 6), (3, 5)]),
        with_pockets(POCKET, rest=(2, 3)),
        with_pockets(POCKET, uncertain=POCKET[:1]),
    ],
)
def test_a_pocket_touches_neither_the_edge_nor_rest_and_is_certain(open_map):
    assert found("stable-pocket", map_radial=open_map, map_equibiaxial=open_map).holds is False


def test_pockets_are_counted_and_measured():
    two = with_pockets([*POCKET, (1, 1), (1, 2), (2, 1)])
    finding = found("stable-pocket", map_radial=two, map_equibiaxial=with_pockets(POCKET, rest=(5, 3)))
    assert [one.value for one in finding.numbers] == [2.0, 3.0, 1.0]
    assert found("stable-pocket", map_radial=with_pockets([]), map_equibiaxial=two).numbers[1].value == 0.0
