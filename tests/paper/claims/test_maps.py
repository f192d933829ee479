"""Verdicts on the claims about the map over voltage and pre-stretch, on made-up maps."""

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import cells, checked, found, number, verdict
from tests.paper.worlds import World, studies_in

STRETCHES = np.linspace(0.4, 2.0, 33)
VOLTAGES = np.linspace(0.0, 2.0, 33)


def where(rule):
    """Chaos by (voltage, pre-stretch)."""
    return np.array([[rule(v, p) for p in STRETCHES] for v in VOLTAGES], dtype=bool)


def plane(chaos, **more):
    return cells({"voltage": VOLTAGES, "prestretch": STRETCHES}, chaos, **more)


def maps(radial, equibiaxial=None, **more):
    return {
        "map_radial": plane(radial, **more),
        "map_equibiaxial": plane(radial if equibiaxial is None else equibiaxial, **more),
    }


@pytest.mark.parametrize("effort", [QUICK, FULL], ids=["quick", "full"])
def test_high_voltage_is_judged_in_each_quarter_of_the_prestretches(effort):
    """Chaos at all pre-stretches up to 1.2, at one of ten voltages from there on, equi-biaxial at none from 1.6 on."""

    def chaos(n):
        rare = np.mod(n["voltage"] * 40.0, 1.0) < 0.1
        return (
            (n["voltage"] > 1.5)
            & (n["prestretch"] < (1.6 if n["mode"] == "equibiaxial" else 9.0))
            & ((n["prestretch"] < 1.2) | rare)
        )

    finding = checked("map-high-voltage", studies_in(World(chaos), "map-high-voltage", effort))
    assert finding.holds is False
    smallest, other = finding.numbers
    assert smallest.low <= 0.1 <= smallest.high < 0.5
    assert other.value == 0.0
    assert finding.share == Share(2, 2, sample=False)


def test_quarters_of_equibiaxial_prestretches_are_the_other_parameters_of_high_voltage():
    """Radial chaos everywhere, equi-biaxial in the third quarter alone."""

    def chaos(n):
        third = (n["prestretch"] > 1.2) & (n["prestretch"] < 1.6)
        return third if n["mode"] == "equibiaxial" else n["voltage"] > 0.0

    finding = checked("map-high-voltage", studies_in(World(chaos), "map-high-voltage", QUICK))
    assert (finding.holds, finding.share) == (True, Share(1, 3, sample=False))
    assert [one.value for one in finding.numbers] == [1.0, 0.0]


def test_the_shares_of_low_prestretches():
    """Radial up to 0.6 of 0.4 to 0.8, equi-biaxial up to 0.5; from 1.2 on nowhere."""

    def chaos(n):
        return (n["voltage"] > 0.3) & (n["prestretch"] < (0.5 if n["mode"] == "equibiaxial" else 0.68))

    world = World(chaos, finite=lambda n: n["voltage"] < 0.0)
    finding = checked("map-low-prestretch", studies_in(world, "map-low-prestretch", FULL))
    small, large, equibiaxial = finding.numbers
    assert small.low <= 0.7 <= small.high
    assert large.value == 0.0
    assert equibiaxial.low <= 0.25 <= equibiaxial.high
    assert (finding.holds, finding.holds_finite) == (True, False)


NONE, ALL = where(lambda v, p: False), where(lambda v, p: True)
NEVER = NONE - 1.0
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
    studies = maps(radial, equibiaxial, finite=finite)
    assert verdict("map-safe-prestretch", **studies) is expected
    finding = found("map-safe-prestretch", **studies)
    assert finding.neighbourhood == "equi-biaxial pre-stretch instead of radial"
    shares = finding.numbers[:2]  # of all rows of the map: exact
    assert [(one.low, one.high) for one in shares] == [(one.value, one.value) for one in shares]


def test_the_window_is_that_of_the_radial_map():
    for radial, equibiaxial, holds in ((NEVER, NONE + 1.0, True), (NONE + 1.0, NEVER, False)):
        studies = {"map_radial": plane(ONE, finite=radial), "map_equibiaxial": plane(ONE, finite=equibiaxial)}
        assert found("map-safe-prestretch", **studies).holds_finite is holds


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
    assert finding.numbers[0].value == 1.0
    assert finding.numbers[1].value == pytest.approx(1.0 - equibiaxial.any(axis=0).mean())


def test_pull_in_is_no_periodic_motion():
    """As with a film that wrinkles: a map whose runs all end from some pre-stretch on is not safe there."""
    ended = np.where(BELOW, int(Regime.LEFT_THE_DOMAIN), int(Regime.PERIODIC))
    gone = np.where(NONE, 0, int(Regime.LEFT_THE_DOMAIN))
    assert found("map-safe-prestretch", **maps(BELOW, kinds=ended)).holds is True
    finding = found("map-safe-prestretch", **maps(NONE, kinds=gone, exponent=np.full(NONE.shape, np.nan)))
    assert (finding.holds, finding.holds_finite) == (False, None)


# --- pockets ----------------------------------------------------------------------------------------------------------

SIZE = 15


def with_pockets(pockets, rest=None, uncertain=()):
    """A chaotic map of 15 by 15 cells with regular cells."""
    kinds = np.full((SIZE, SIZE), int(Regime.CHAOTIC))
    sign = np.ones((SIZE, SIZE), dtype=int)
    for cell in pockets:
        kinds[cell], sign[cell] = int(Regime.PERIODIC), -1
    for cell in uncertain:
        sign[cell] = 0
    if rest is not None:
        kinds[rest] = int(Regime.REST)
    over = {"voltage": np.arange(float(SIZE)), "prestretch": np.arange(float(SIZE))}
    return cells(over, kinds == Regime.CHAOTIC, kinds=kinds, sign=sign)


POCKET = [(3, 3), (3, 4), (4, 3), (4, 4)]
LARGE = [(row, column) for row in range(2, 8) for column in range(2, 8)]
EMPTY = with_pockets([])


@pytest.mark.parametrize(
    ("expected", "radial", "equibiaxial"),
    [
        (Verdict.REPRODUCED, with_pockets(POCKET), with_pockets(POCKET)),
        (Verdict.CHOSEN, with_pockets(POCKET), EMPTY),
        (Verdict.CHOSEN, EMPTY, with_pockets(POCKET)),
        (Verdict.NOT_REPRODUCED, with_pockets(POCKET[:1]), EMPTY),
        (Verdict.NOT_REPRODUCED, with_pockets(LARGE), EMPTY),  # 36 of 225 cells are not narrow
        (Verdict.UNDECIDED, with_pockets(POCKET[:2]), EMPTY),  # two cells of two: chance in about 2 of 100
        (Verdict.NOT_REPRODUCED, with_pockets([*POCKET[:2], (8, 8)]), EMPTY),  # two of three
    ],
)
def test_a_pocket_is_narrow_and_larger_than_chance(expected, radial, equibiaxial):
    assert verdict("stable-pocket", map_radial=radial, map_equibiaxial=equibiaxial) is expected


@pytest.mark.parametrize(
    "open_map",
    [
        with_pockets([(0, 3), *((1, k) for k in range(2, 6))]),
        with_pockets([(SIZE - 1, 3), *((SIZE - 2, k) for k in range(2, 6))]),
        with_pockets([(3, 0), *((k, 1) for k in range(2, 6))]),
        with_pockets([(3, SIZE - 1), *((k, SIZE - 2) for k in range(2, 6))]),
        with_pockets(POCKET, rest=(2, 3)),
        with_pockets(POCKET, uncertain=POCKET),
    ],
)
def test_a_pocket_touches_neither_the_edge_nor_rest_and_is_certain(open_map):
    assert found("stable-pocket", map_radial=open_map, map_equibiaxial=open_map).holds is False


@pytest.mark.parametrize("size", [QUICK.map_shape[0], FULL.map_shape[0]])
def test_shuffled_maps_have_no_pocket(size):
    """Of maps with a fifth of regular cells by chance about one in a hundred passes, with pockets of some cells."""
    rng = np.random.default_rng(3)
    passed = 0
    maps_seen = 40 if size < 20 else 4
    for _ in range(maps_seen):
        kinds = np.where(rng.random((size, size)) < 0.2, int(Regime.PERIODIC), int(Regime.CHAOTIC))
        sign = np.where(kinds == Regime.CHAOTIC, 1, -1)
        over = {"voltage": np.arange(float(size)), "prestretch": np.arange(float(size))}
        one = cells(over, kinds == Regime.CHAOTIC, kinds=kinds, sign=sign)
        finding = found("stable-pocket", map_radial=one, map_equibiaxial=EMPTY)
        assert finding.numbers[0].value >= 2.0
        passed += finding.holds is True
    assert passed <= 1


def test_pockets_are_measured():
    two = with_pockets([*POCKET, (9, 9), (9, 10)])
    finding = found("stable-pocket", map_radial=two, map_equibiaxial=with_pockets(POCKET, rest=(5, 3)))
    assert finding.numbers[0].value == 4.0
    assert finding.numbers[1].value == pytest.approx(0.001)  # none of 999, and the map itself
    assert [one.value for one in finding.numbers[2:]] == [0.0, 1.0]
