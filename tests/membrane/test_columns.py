"""Columns of states: where rings localise, how columns end, and what is read from them."""

import numpy as np
import pytest

from gelcone.membrane.columns import Columns, columns, localised, longest, lowest_localisation
from gelcone.membrane.elements import Elements, Measures
from gelcone.membrane.gel import Gel
from gelcone.membrane.slack import slack_voltages
from gelcone.physics.laws import LAWS

GEL = Gel(LAWS["gent"], LAWS["gent"].numbers({"stretch_limit": 50.0}), 1.0, 1.0)


@pytest.mark.parametrize("V", [0.25, 0.3, 0.4])
def test_a_ring_is_firm_up_to_the_longest_length_and_soft_beyond(V):
    found = longest(GEL, np.array([V]))[0]
    lengths = np.array([found * (1.0 - 1e-6), found * (1.0 + 1e-6)])
    firm, soft = GEL.at(lengths, np.ones(2), np.full(2, V)).tangent_stiffness
    assert firm > 0.0 > soft
    before = np.linspace(1.0, found * (1.0 - 1e-6), 500)
    ring = GEL.at(before, np.ones(500), np.full(500, V))
    assert (ring.tangent_stiffness[ring.meridional > 0.0] > 0.0).all()


def test_the_lowest_localisation_is_the_lowest_voltage_with_a_longest_length():
    lowest = lowest_localisation(GEL, 0.6)
    below, above = longest(GEL, lowest * np.array([0.995, 1.0005]), 3000)
    assert np.isnan(below)
    assert np.isfinite(above)
    assert lowest_localisation(GEL, 0.9 * lowest) == np.inf


def made(**changes):
    """Two columns, whose states are out of order; numbers that fall through zero in the second."""
    column, V = np.array([0, 1, 0, 1, 1]), np.array([0.2, 0.0, 0.0, 0.3, 0.1])
    values = {name: np.arange(5.0) for name in Measures._fields} | {"force": np.array([2.0, 7.0, 5.0, 1.0, 3.0])}
    parts = {"heights": np.array([0.5, 0.6]), "slack": np.zeros(2, bool), "end": np.array([0.25, 0.35])}
    parts |= {"top": np.array([0.25, 0.5]), "last": None, "measures": Measures(**values)} | changes
    return Columns(column, V, **parts)


def test_a_column_is_read_in_the_order_of_its_voltage():
    found = made()
    assert [part.tolist() for part in found.along(1, found.measures.force)] == [[0.0, 0.1, 0.3], [7.0, 3.0, 1.0]]
    assert found.first.tolist() == [5.0, 7.0]
    falls = found.falls(np.array([1.0, 2.0, 3.0, -1.0, 1.0]))
    assert np.isnan(falls[0])
    assert falls[1] == pytest.approx(0.2)
    assert found.falls(np.array([1.0, 2.0, -3.0, -1.0, 3.0])).tolist() == pytest.approx([np.nan, 0.25], nan_ok=True)
    assert found.falls(np.array([-1.0, 2.0, 3.0, 0.0, 1.0])).tolist() == pytest.approx([0.15, 0.3])


@pytest.mark.parametrize(("share", "ends"), [(0.98, False), (0.995, True)])
def test_a_column_localises_where_it_ends_before_its_top_with_a_long_edge(share, ends):
    """The first column ends at its top, whatever its edge is."""
    edge = np.full(5, (share * longest(GEL, np.array([0.3 * 1.01]))[0]) ** 2)
    found = made()
    found = made(measures=found.measures._replace(edge=edge, force=np.ones(5)))
    assert localised(GEL, found).tolist() == [False, ends]


def test_columns_rise_from_no_voltage_to_their_end_by_states_in_balance():
    """A film alike all over: slack where its crumpling voltage is; ended by its top where that is lower."""
    film, x = Elements(GEL, 0.25, 30), np.array([0.2, 0.3, 0.3])
    slack = slack_voltages(GEL, 0.25)(x)
    found = columns(film, x, slack, np.array([2.0, 2.0, 0.5]) * slack)
    assert found.slack.tolist() == [True, True, False]
    np.testing.assert_allclose(found.end, slack * [1.0, 1.0, 0.5], rtol=5e-3)
    assert (found.end <= found.top).all()
    for k, height in enumerate(x):
        V, force = found.along(k, found.measures.force)
        assert V[0] == 0.0
        assert (np.diff(V) > 0.0).all()
        assert (np.diff(force) < 0.0).all()
        assert force[0] == found.first[k]
        heights = found.along(k, found.measures.x)[1]
        np.testing.assert_allclose(heights, height)
        assert found.last.V[k] == V[-1]
    alone = film.measures(film.found(film.unloaded(x[:1])._replace(V=np.array([0.0]))))
    assert found.first[0] == pytest.approx(float(alone.force[0]), rel=1e-9)


@pytest.mark.parametrize("steps", [1, 4])
def test_a_column_ends_where_steps_are_as_short_as_was_asked_for_however_long_they_were(steps):
    """Each step that leads to no state is halved; the end lies in the middle of the last one."""
    film, x, ends = Elements(GEL, 0.25, 30), np.array([0.9, 1.5]), []
    for finest in (3e-4, 3e-3):
        found = columns(film, x, np.array([0.24, 0.15]), np.full(2, 0.6), steps, finest)
        assert not found.slack.any()
        for k in range(2):
            V, _ = found.along(k, found.measures.force)
            assert 0.0 < found.end[k] - V[-1] <= finest * 0.24
            assert V.size > steps + 2
        ends.append(found.end)
    np.testing.assert_allclose(ends[1], ends[0], atol=2.0 * 3e-3 * 0.24)
