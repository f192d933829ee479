"""The membrane in finite elements against states that shooting certified."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.membrane.elements import BAND, Chains, Elements, _solved
from gelcone.membrane.gel import Gel
from gelcone.physics.laws import LAWS

CERTIFIED = json.loads((Path(__file__).parents[1] / "reference" / "membrane.json").read_text())["states"]


def film(state: dict, count: int) -> Elements:
    law = LAWS["gent"]
    numbers = law.numbers({"stretch_limit": state["stretch_limit"] or np.inf})
    A, B = state["meridional_prestretch"] ** 2, state["hoop_prestretch"] ** 2
    return Elements(Gel(law, numbers, A, B), state["radius_ratio"], count)


def found(state: dict, count: int):
    """The certified state, raised in voltage at its height from the straight cone."""
    own = film(state, count)
    V = state["v"] ** 2
    at = own.found(own.cones(np.array([state["x"]]), np.zeros(1)))
    for share in np.linspace(0.0, 1.0, 2 + int(V / 0.05))[1:]:
        at = own.found(at._replace(V=np.array([V * share])))
    return own, at


@pytest.mark.parametrize(
    "state", CERTIFIED, ids=lambda s: f"{s['radius_ratio']}-{s['hoop_prestretch']}-{s['x']}-{s['v']}"
)
def test_states_are_the_certified_ones_within_the_error_of_the_elements(state):
    errors = []
    for count in (60, 120):
        own, at = found(state, count)
        assert at.found.all()
        measured = own.measures(at)
        assert measured.x[0] == pytest.approx(state["x"])
        errors.append([abs(measured.force[0] / state["force"] - 1.0), abs(measured.area[0] / state["area"] - 1.0)])
        assert measured.disc[0] == pytest.approx(state["disc_m"], rel=5e-4)
        assert measured.field[0] * state["v"] == pytest.approx(state["largest_field"], rel=5e-2, abs=1e-12)
    coarse, fine = np.array(errors)
    assert fine[0] < 8e-5
    assert fine[1] < 2e-5
    assert np.all(fine < np.maximum(0.35 * coarse, 5e-7))  # the error falls with the square of the length


def test_a_force_is_the_slope_of_the_energy_and_the_area_that_by_the_voltage():
    own = film(CERTIFIED[2], 60)
    step, x, V = 1e-4, 0.5, 0.25
    places = [(x, V), (x + step, V), (x - step, V), (x, V + step), (x, V - step)]
    heights, voltages = (np.array(values) for values in zip(*places, strict=True))
    at = own.found(own.cones(heights, 0.0 * voltages))
    for share in np.linspace(0.0, 1.0, 8)[1:]:
        at = own.found(at._replace(V=share * voltages))
    measured = own.measures(at)
    assert -2.0 * (measured.force[3] - measured.force[4]) == pytest.approx(
        measured.area[1] - measured.area[2], rel=1e-6
    )  # d(area)/dx = -2 dF/dV, as both come from one energy


def test_the_tensions_after_a_step_are_foreseen_to_second_order():
    """Of a film that nowhere wrinkles, after half the change of the voltage, they are off by a quarter."""
    own = Elements(Gel(LAWS["gent"], LAWS["gent"].numbers({"stretch_limit": 50.0}), 1.2**2, 1.5**2), 0.3, 40)
    at, off = own.unloaded(np.array([0.3])), []
    for change in (0.02, 0.01):
        other = at._replace(V=at.V + change)
        step, foreseen, _ = own._step(other, np.full((1, 40), np.nan))
        moved = other._replace(r=at.r + step[:, :, 0], z=at.z + step[:, :, 1])
        l1, l2, _, _ = own.stretches(moved)
        V = np.full(l1.shape, change)
        assert (own.gel.hoop(l1, l2, V) > 0.0).all()
        off.append(np.abs(foreseen - own.gel.at(l1, l2, V).meridional).max())
        assert off[-1] < 0.01 * np.abs(foreseen - at.tension).max()
    assert off[1] / off[0] == pytest.approx(0.25, abs=0.02)


def test_the_least_firmness_is_looked_for_between_elements_too():
    """Two elements of a gel with a low limit, one short and one near it, both firmer than what lies between."""
    law = LAWS["gent"]
    own = Elements(Gel(law, law.numbers({"stretch_limit": 6.0}), 1.0, 1.0), 0.5, 2)
    lengths = np.array([1.05, 2.2])
    r = np.tile(own.nodes, (1, 1))
    z = np.concatenate([[0.0], np.cumsum(np.sqrt((lengths * own.lengths) ** 2 - np.diff(own.nodes) ** 2))])[None]
    at = Chains(np.array([0.15]), r, z, np.full((1, 2), np.nan), np.ones(1, bool))
    l1, l2, _, _ = own.stretches(at)
    np.testing.assert_allclose(l1[0], lengths)
    share = np.linspace(0.0, 1.0, 2001)
    between = own.gel.at(l1[0, 0] + share * np.diff(l1[0]), l2[0, 0] + share * np.diff(l2[0]), np.full(2001, 0.15))
    least = own.least_tangent_stiffness(at)[0]
    assert least < 0.98 * between.tangent_stiffness[[0, -1]].min()
    assert least == pytest.approx(between.tangent_stiffness.min(), rel=0.05)


@pytest.mark.parametrize("outwards", [1.0, -1.0])
def test_lengths_at_disc_and_rim_lie_on_the_line_through_the_two_elements_next_to_them(outwards):
    """Of lengths that rise or fall evenly along the film; the longer of both is the edge."""
    law = LAWS["gent"]
    own = Elements(Gel(law, law.numbers({"stretch_limit": 50.0}), 1.0, 1.0), 0.3, 20)
    line = lambda R: 1.4 + 0.3 * outwards * (R - own.middles.mean())  # noqa: E731
    drop = np.sqrt((line(own.middles) * own.lengths) ** 2 - np.diff(own.nodes) ** 2)
    z = np.concatenate([[drop.sum()], drop.sum() - np.cumsum(drop)])[None]
    at = Chains(np.zeros(1), own.nodes[None], z, np.full((1, 20), np.nan), np.ones(1, bool))
    found = own.measures(at)
    disc, rim = (float(line(own.nodes[k])) for k in (0, -1))
    assert found.disc[0] == pytest.approx(disc**2, rel=1e-12)
    assert found.edge[0] == pytest.approx(max(disc, rim) ** 2, rel=1e-12)
    assert found.x[0] == pytest.approx(drop.sum())


def test_heights_behind_the_first_without_a_state_are_left_out_where_that_is_asked(monkeypatch):
    """Of a gel near its stretch limit; those before are the same."""
    law, tried = LAWS["gent"], []
    own, other = (Elements(Gel(law, law.numbers({"stretch_limit": 1.75}), 1.3, 1.3), 0.3, 20) for _ in range(2))
    moved = Elements._moved

    def counted(self, at, x):
        tried.append(x)
        return moved(self, at, x)

    monkeypatch.setattr(Elements, "_moved", counted)
    heights = np.array([0.1, 0.3, 4.0, 5.0, 6.0])
    all_of_them = own.unloaded(heights)
    assert tried == [4.0, 5.0, 6.0]
    until = other.unloaded(heights, until_lost=True)
    assert tried[3:] == [4.0]
    assert until.found.tolist() == all_of_them.found.tolist() == [True, True, False, False, False]
    np.testing.assert_array_equal(until.z[:2], all_of_them.z[:2])


def test_a_state_without_voltage_is_computed_once(monkeypatch):
    """Also one that is hard to find; a height without a state is tried each time."""
    law = LAWS["gent"]
    own = Elements(Gel(law, law.numbers({"stretch_limit": 1.75}), 1.3, 1.3), 0.3, 20)
    before, tried, found = own.unloaded(np.array([0.1, 4.0, 0.3])), [], Elements.found

    def counted(self, start, *given):
        tried.append(start.z[:, 0].tolist())
        return found(self, start, *given)

    monkeypatch.setattr(Elements, "found", counted)
    after = own.unloaded(np.array([0.3, 0.2, 0.1]))
    assert tried == [[0.2]]
    for one, other in zip(before.where([2, 0]), after.where([0, 2]), strict=True):
        np.testing.assert_array_equal(one, other)
    assert own.unloaded(np.array([4.0, 0.1])).found.tolist() == [False, True]
    assert tried[1] == [4.0]


def test_a_system_that_rounding_leaves_singular_is_lost_alone():
    """Which one that is depends on the processor; the others are solved as without it."""
    rng = np.random.default_rng(3)
    band, right = rng.normal(size=(2 * BAND + 1, 4, 6)), rng.normal(size=(4, 6))
    band[BAND] += 20.0
    for k in range(1, BAND + 1):  # the systems do not touch one another
        band[BAND - k, :, :k], band[BAND + k, :, -k:] = 0.0, 0.0
    known = np.array([True, True, False, True])
    expected = _solved(band.copy(), right.copy(), known)
    for k in (0, 1, 3):
        matrix = sum(np.diag(band[BAND - d, k, max(d, 0) : 6 + min(d, 0)], d) for d in range(-BAND, BAND + 1))
        np.testing.assert_allclose(matrix @ expected[k], right[k], rtol=1e-12)
    assert np.isnan(expected[2]).all()
    singular = band.copy()
    singular[:, 1] = 0.0
    found = _solved(singular, right.copy(), known)
    assert np.isnan(found[1:3]).all()
    np.testing.assert_array_equal(found[[0, 3]], expected[[0, 3]])
    assert known.tolist() == [True, True, False, True]
