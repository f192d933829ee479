"""Ranges of thresholds on made-up kinds of motion: sharp ones, mixed ones, cascades."""

import numpy as np
import pytest

from gelcone.atlas.threshold import Threshold, changes, refine, share_of
from gelcone.codes import Regime
from gelcone.motion.attractor.classification import Evidence


def evidence(shares, periods=None):
    """Cells of which a share of the starts is chaotic, the others on a cycle."""
    shares = np.asarray(shares, dtype=float)
    found = Evidence.blank(len(shares))
    found.regime[:] = np.where(shares > 0.5, Regime.CHAOTIC, Regime.PERIODIC)
    found.period[:] = np.where(shares > 0.5, 0, 1 if periods is None else periods)
    mixed = (shares > 0.0) & (shares < 1.0)
    found.share_chaotic[mixed] = shares[mixed]
    found.fate_regime[mixed, 0], found.fate_share[mixed, 0] = Regime.PERIODIC, 1.0 - shares[mixed]
    return found


def narrowed(share, values, halvings, periods=lambda value: 1):
    def cells(tried):
        return evidence([share(value) for value in tried], [periods(value) for value in tried])

    (threshold,) = changes("up", values, cells(values))
    refine([threshold], lambda owners, tried: [cells(tried)], halvings, lambda part: None)
    return threshold


@pytest.mark.parametrize("edge", [0.31, 0.5, 0.77])
def test_a_sharp_change_is_narrowed_down_to_the_width_asked_for(edge):
    found = narrowed(lambda value: float(value > edge), np.linspace(0.0, 1.0, 3), 10)
    assert found.low <= edge <= found.high
    assert found.high - found.low <= 0.5 / 2**10
    assert (found.below, found.above, found.cascade) == (Regime.PERIODIC, Regime.CHAOTIC, False)


def test_where_starts_disagree_the_range_is_where_they_do():
    """Shares of chaos that rise from 0 at 0.4 to 1 at 0.7, over several values of the grid."""
    found = narrowed(lambda value: float(np.clip((value - 0.4) / 0.3, 0.0, 1.0)), np.linspace(0.0, 1.0, 11), 12)
    assert found.low == pytest.approx(0.4, abs=0.02)
    assert found.high == pytest.approx(0.7, abs=0.02)
    assert found.low <= 0.4 + 1e-9
    assert found.high >= 0.7 - 1e-9


def test_windows_inside_a_range_belong_to_it():
    def share(value):
        return 0.0 if value < 0.5 or 0.55 < value < 0.6 else 1.0 if value > 0.65 else 0.5

    found = narrowed(share, np.linspace(0.0, 1.0, 3), 10)
    assert found.low <= 0.5
    assert found.high >= 0.65
    assert found.high - found.low < 0.3


def test_a_range_that_no_longer_changes_is_not_tried_for_ever():
    asked = []

    def cells(owners, tried):
        asked.append(len(tried))
        return [evidence(np.full(len(tried), 0.5))]

    (threshold,) = changes("up", np.array([0.0, 1.0]), evidence([0.0, 1.0]))
    refine([threshold], cells, 20, lambda part: None)
    assert (threshold.low, threshold.high) == (0.0, 1.0)
    assert asked == [3, 3]


def test_chaos_that_begins_by_doublings_of_the_period_says_so():
    edge = 0.4871

    def period(value):
        return int(2 ** max(np.floor(np.log(0.5 / (edge - value)) / np.log(4.67)), 0.0)) if value < edge else 1

    def share(value):
        return float(value > edge)

    assert narrowed(share, np.linspace(0.0, 1.0, 5), 12, period).cascade
    assert not narrowed(share, np.linspace(0.0, 1.0, 5), 12).cascade


def test_changes_over_the_same_values_are_one():
    """Two changes of the named regime within cells whose starts disagree all the way."""
    found = changes("up", np.arange(5.0), evidence([0.0, 0.6, 0.4, 0.7, 1.0]))
    assert [(change.low, change.high) for change in found if change.below == Regime.PERIODIC] == [(0.0, 4.0)]


def test_the_share_of_a_kind_counts_starts_where_they_disagree():
    cells = evidence([0.0, 0.25, 1.0])
    assert share_of(cells, Regime.CHAOTIC).tolist() == [0.0, 0.25, 1.0]
    assert share_of(cells, Regime.PERIODIC).tolist() == [1.0, 0.75, 0.0]
    cells.regime[1] = Regime.TRANSIENT_CHAOS
    assert share_of(cells, Regime.TRANSIENT_CHAOS).tolist() == [0.0, 1.0, 0.0]
    assert Threshold("up", Regime.REST, Regime.PERIODIC, 0.0, 1.0).cascade is False


@pytest.mark.parametrize(
    ("periods", "cascade"),
    [([1, 2, 4], True), ([1, 2, 2, 4, 0], True), ([1, 2, 0, 0], False), ([1, 3, 6], False), ([1, 2, 6, 12], False)],
)
def test_two_doublings_in_a_row_make_a_cascade(periods, cascade):
    threshold = Threshold("up", Regime.PERIODIC, Regime.CHAOTIC, 0.0, 1.0)
    for k, period in enumerate(periods):
        threshold.add(0.1 * k, 1.0, period)
    assert threshold.cascade is cascade
    mirrored = Threshold("up", Regime.CHAOTIC, Regime.PERIODIC, 0.0, 1.0)
    for k, period in enumerate(periods):
        mirrored.add(1.0 - 0.1 * k, 1.0, period)
    assert mirrored.cascade is cascade


def test_three_values_on_either_side_of_a_change_are_known_from_the_start():
    """Also where the change covers several values, and at the ends of the branch: their periods show a cascade."""
    shares = [0.0] * 5 + [0.3, 0.6] + [1.0] * 5
    (found,) = changes("up", np.arange(12.0), evidence(shares))
    assert (found.low, found.high) == (4.0, 7.0)
    assert sorted(found.tried) == [float(k) for k in range(1, 11)]
    assert [found.tried[k][0] for k in (1.0, 4.0, 5.0, 6.0, 7.0, 10.0)] == pytest.approx([1, 1, 0.7, 0.4, 0, 0])
    (early,) = changes("up", np.arange(4.0), evidence([0.0, 1.0, 1.0, 1.0], [8, 0, 0, 0]))
    assert sorted(early.tried) == [0.0, 1.0, 2.0, 3.0]
    assert early.tried[0.0] == (1.0, 8)


def test_shares_of_several_fates_add_up_to_at_most_all():
    cells = evidence([0.25])
    cells.fate_regime[0, :2], cells.fate_share[0, :2] = Regime.PERIODIC, (0.7, 0.4)
    assert share_of(cells, Regime.PERIODIC).tolist() == [1.0]
    cells.fate_regime[0, 1] = Regime.REST
    assert share_of(cells, Regime.PERIODIC) == pytest.approx([0.7])
    assert share_of(cells, Regime.REST) == pytest.approx([0.4])
    cells.share_chaotic[0] = np.nan
    assert share_of(cells, Regime.PERIODIC).tolist() == [1.0]  # one motion, which is periodic


def test_a_range_is_narrowed_to_the_last_of_one_kind_and_the_first_of_the_other():
    threshold = Threshold("up", Regime.PERIODIC, Regime.CHAOTIC, 1.0, 2.0)
    for value, share in (
        (0.5, 0.0),
        (1.2, 1.0),
        (1.4, 1.0),
        (1.5, 0.6),
        (1.6, 1.0),
        (1.8, 0.0),
        (1.9, 0.0),
        (2.5, 1.0),
    ):
        threshold.add(value, share, 1)
    threshold.narrow()
    assert (threshold.low, threshold.high, threshold.unchanged) == (1.4, 1.8, 0)
    assert threshold.middle == pytest.approx([1.5, 1.6, 1.7])
    threshold.narrow()
    threshold.narrow()
    assert threshold.unchanged == 2
    threshold.add(1.7, 0.0, 1)
    threshold.narrow()
    assert (threshold.low, threshold.high, threshold.unchanged) == (1.4, pytest.approx(1.7), 0)


def test_each_of_several_thresholds_gets_its_own_shares_and_periods():
    """Period 2 up to 0.31, chaos up to 0.77, and period 5 beyond it."""

    def cells(tried):
        return evidence([float(0.31 < v < 0.77) for v in tried], [2 if v < 0.5 else 5 for v in tried])

    values = np.linspace(0.0, 1.0, 5)
    found = changes("up", values, cells(values))
    refine(found, lambda owners, tried: [cells(tried)], 6, lambda part: None)
    for threshold, edge in zip(found, (0.31, 0.77), strict=True):
        assert threshold.low <= edge <= threshold.high < threshold.low + 0.01
        for value, (share, period) in threshold.tried.items():
            assert period == (0 if 0.31 < value < 0.77 else 2 if value < 0.5 else 5)
            assert share == float((0.31 < value < 0.77) == (threshold.below is Regime.CHAOTIC))


def test_chaos_that_ends_is_no_share_of_what_it_ends_in():
    """Nor is it one of the kinds that settled, whatever its starts end in."""
    cells = evidence([0.25, 0.25])
    cells.regime[:] = Regime.TRANSIENT_CHAOS, Regime.PERIODIC
    assert share_of(cells, Regime.PERIODIC).tolist() == [0.0, 0.75]


def test_a_cascade_is_the_longest_run_of_doublings_towards_chaos_in_its_own_direction():
    """Two doublings and a period that does not double; and periods that halve towards chaos, which are none."""
    up = Threshold("up", Regime.PERIODIC, Regime.CHAOTIC, 0.0, 1.0)
    for k, period in enumerate([1, 2, 4, 3]):
        up.add(0.1 * k, 1.0, period)
    assert up.cascade
    down = Threshold("up", Regime.CHAOTIC, Regime.PERIODIC, 0.0, 1.0)
    for k, period in enumerate([1, 2, 4]):
        down.add(0.1 * k, 1.0, period)
    assert not down.cascade


def test_a_range_ends_where_no_start_is_of_the_one_kind_any_more():
    """Shares of 1 on the far side, where the kind comes again, lengthen it."""
    shares = evidence([0.0, 0.5, 1.0, 1.0])
    (found,) = changes("up", np.arange(4.0), shares)
    assert (found.low, found.high) == (0.0, 2.0)


def test_a_range_whose_starts_disagree_at_its_own_ends_stays():
    """Windows of one kind within it say nothing about the values beyond."""
    own = Threshold("up", Regime.PERIODIC, Regime.CHAOTIC, 1.0, 2.0)
    for value, share in ((1.0, 0.5), (1.25, 1.0), (1.75, 0.0), (2.0, 0.25)):
        own.add(value, share, 1)
    own.narrow()
    assert (own.low, own.high, own.unchanged) == (1.0, 2.0, 1)


@pytest.mark.parametrize("edges", [(0.3, 0.3), (0.3, 0.37)])
def test_a_range_holds_the_values_at_which_paths_differ_and_is_then_of_one_path(edges):
    """Chaos above an edge that differs between two paths."""
    values = np.linspace(0.0, 1.0, 5)

    def paths(owners, tried):
        return [evidence((tried > edge).astype(float)) for edge in edges]

    (threshold,) = changes("down", values, evidence((values > edges[0]).astype(float)))
    assert threshold.wandering
    assert threshold.of_one_path
    refine([threshold], paths, 8, lambda part: None)
    assert threshold.low <= min(edges) <= max(edges) <= threshold.high
    assert threshold.of_one_path is (edges[0] != edges[1])


@pytest.mark.parametrize(
    ("below", "above", "of_one_path"),
    [
        (Regime.REST, Regime.PERIODIC, False), (Regime.PERIODIC, Regime.CHAOTIC, False),
        (Regime.TRANSIENT_CHAOS, Regime.CHAOTIC, True), (Regime.PERIODIC, Regime.TRANSIENT_CHAOS, True),
    ],
)  # fmt: skip
def test_a_change_to_or_from_chaos_that_ends_is_of_one_path(below, above, of_one_path):
    """Whether chaos has ended depends on the run, however narrow the range."""
    assert Threshold("up", below, above, 0.0, 1.0, sharp=True).of_one_path is of_one_path
    out_of_chaos = Threshold("up", below, above, 0.0, 1.0, sharp=True, out_of_chaos=True)
    assert out_of_chaos.of_one_path is (Regime.REST not in (below, above))
