"""Verdicts on the claims about the map over voltage and pre-stretch, on made-up maps."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import cells, found, number, verdict

STRETCHES = [0.4, 0.8, 0.9, 2.0]
VOLTAGES = [0.5, 1.0, 1.1, 1.6, 1.8, 2.0]
NONE, ALL = np.zeros((6, 4)), np.ones((6, 4))


def chaos(*rows):
    """Chaos by (voltage, pre-stretch) from the voltages at which each pre-stretch is chaotic."""
    return np.array([[v in own for own in rows] for v in VOLTAGES])


def plane(where, **more):
    over = {"voltage": VOLTAGES, "prestretch": STRETCHES}
    return cells(over, where, **more)


def maps(radial, equibiaxial=None, **more):
    return {
        "map_radial": plane(radial, **more),
        "map_equibiaxial": plane(radial if equibiaxial is None else equibiaxial, **more),
    }


HIGH = (1.6, 1.8, 2.0)


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial"),
    [
        (Verdict.REPRODUCED, chaos(HIGH, HIGH, (), (1.6,)), chaos(HIGH, HIGH, HIGH, HIGH)),
        (Verdict.CHOSEN, chaos(HIGH, HIGH, (2.0,), ()), NONE),
        (Verdict.CHOSEN, chaos(HIGH, (), (), ()), NONE),
        (Verdict.NOT_REPRODUCED, chaos((0.5, 1.0, 1.1), (0.5, 1.0, 1.1), (), ()), NONE),
        (Verdict.NOT_REPRODUCED, NONE, NONE),
    ],
)
def test_high_voltage(expected, radial, equibiaxial):
    assert verdict("map-high-voltage", **maps(radial, equibiaxial)) is expected


def test_high_voltage_counts_certain_exponents_from_the_voltage_1_6_on():
    finding = found("map-high-voltage", **maps(chaos(HIGH, (1.6,), (), (0.5, 1.1)), ALL))
    assert finding.numbers[0].value == pytest.approx(4.0 / 12.0)
    assert finding.numbers[1].value == 1.0
    smallest = number(finding, "smallest such share")
    assert (smallest.value, smallest.low, smallest.high) == (0.0, 0.0, 0.0)
    assert finding.share == pytest.approx(5.0 / 8.0)
    assert found("map-high-voltage", **maps(ALL, error=0.05)).holds is False  # 0.1 is no more than three errors


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial", "finite"),
    [
        (Verdict.REPRODUCED, chaos((0.5,), (1.0,), (), ()), NONE, NONE - 1.0),
        (Verdict.CHOSEN, chaos((0.5,), (1.1,), (), ()), NONE, NONE - 1.0),  # from 1.04 on it is not moderate
        (Verdict.TRANSIENT, NONE, NONE, chaos((0.5,), (1.0,), (), ()) - 0.5),
        (Verdict.CHOSEN, NONE, chaos((0.5,), (), (), ()), NONE - 1.0),
        (Verdict.NOT_REPRODUCED, chaos((1.1,), (1.6,), (0.5,), (0.5,)), NONE, NONE - 1.0),
    ],
)
def test_low_prestretch(expected, radial, equibiaxial, finite):
    assert verdict("map-low-prestretch", **maps(radial, equibiaxial, finite=finite)) is expected


def test_low_prestretch_is_up_to_0_8_and_moderate_below_1_04():
    finding = found("map-low-prestretch", **maps(chaos((0.5,), (1.0,), (), ()), chaos((0.5,), (), (0.5,), ())))
    assert [one.value for one in finding.numbers] == [1.0, 0.5]
    assert finding.share == 0.75


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial", "finite"),
    [
        (Verdict.REPRODUCED, chaos((2.0,), (), (), ()), NONE, NONE - 1.0),
        (Verdict.CHOSEN, chaos((2.0,), (2.0,), (2.0,), ()), ALL, NONE - 1.0),
        (Verdict.TRANSIENT, chaos((), (), (), (0.5,)), NONE, NONE - 1.0),
        (Verdict.CHOSEN, chaos((), (), (), (0.5,)), NONE, chaos((), (), (), (2.0,)) - 0.5),
        (Verdict.NOT_REPRODUCED, ALL, ALL, NONE + 1.0),
    ],
)
def test_safe_prestretch(expected, radial, equibiaxial, finite):
    assert verdict("map-safe-prestretch", **maps(radial, equibiaxial, finite=finite)) is expected


@pytest.mark.parametrize(
    ("equibiaxial", "edge"),
    [
        (chaos((1.0,), (2.0,), (), ()), 0.9),
        (NONE, 0.4),
        (chaos((), (), (2.0,), ()), 2.0),
        (chaos((), (), (), (2.0,)), np.nan),
    ],
)
def test_from_which_prestretch_on_there_is_no_chaos(equibiaxial, edge):
    finding = found("map-safe-prestretch", **maps(NONE, equibiaxial))
    one = number(finding, "from which on")
    np.testing.assert_equal(one.value, edge)
    assert one.error == pytest.approx(0.4)
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
        (Verdict.REPRODUCED, with_pockets(POCKET), with_pockets([])),
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
