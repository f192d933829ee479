"""Rings of held states against those that shooting certified, and against laws that every profile obeys."""

import numpy as np
import pytest

from gelcone.membrane.profile import held, profile
from tests.membrane.test_elements import CERTIFIED, film

COUNT = 100


def rings(state: dict):
    """The film, the state and its rings."""
    own = film(state, COUNT)
    at = held(own, np.array([state["x"]]), np.array([state["v"] ** 2]))
    assert at.found.all()
    return own, at, profile(own, at)


@pytest.mark.parametrize(
    "state", CERTIFIED, ids=lambda s: f"{s['radius_ratio']}-{s['hoop_prestretch']}-{s['x']}-{s['v']}"
)
def test_the_first_and_last_ring_the_largest_field_and_the_least_firmness_are_certified(state):
    _, _, found = rings(state)
    ends = [found.l1[0, 0] ** 2, found.width[0, 0] ** 2, found.l1[0, -1] ** 2, found.width[0, -1] ** 2]
    assert ends == pytest.approx([state[f"{end}_{of}"] for end in ("disc", "rim") for of in "mn"], rel=1e-3)
    assert np.max(found.field) * state["v"] == pytest.approx(state["largest_field"], rel=1e-3)
    assert np.min(found.tangent_stiffness) == pytest.approx(state["least_firmness"], rel=3e-3)


@pytest.mark.parametrize("state", CERTIFIED[1:6], ids=lambda s: f"{s['x']}-{s['v']}")
def test_an_axial_cut_anywhere_carries_the_force_of_the_disc(state):
    """R T1 sech u, the axial force over 2 pi mu H, is the same in all rings (membrane.md, section 2)."""
    own, at, found = rings(state)
    r, z = at.r[0], at.z[0]
    steep = -np.diff(z) / np.hypot(np.diff(r), np.diff(z))
    inner = slice(1, -1)
    tension = own.gel.at(found.l1[:, inner], found.span[:, inner], np.full((1, COUNT), state["v"] ** 2)).meridional[0]
    force = 2.0 * own.middles * tension * steep / own.mounted
    assert force == pytest.approx(np.full(COUNT, state["force"]), rel=2e-4)


def test_shape_is_held_at_both_ends_and_the_volume_of_every_ring_is_unchanged():
    own, _, found = rings(CERTIFIED[3])
    assert (found.r[0, 0], found.z[0, 0]) == pytest.approx((own.disc, 0.75))
    assert (found.r[0, -1], found.z[0, -1]) == pytest.approx((own.disc + 1.0, 0.0))
    np.testing.assert_allclose(found.thickness * found.l1 * found.width, 1.0, rtol=1e-14)


def test_the_largest_field_of_a_state_is_that_of_its_rings():
    for state in CERTIFIED[1:6]:
        own, at, found = rings(state)
        assert float(own.measures(at).field[0]) == pytest.approx(float(found.field.max()), rel=2e-5)


def test_wrinkles_hold_what_the_hoop_is_too_long_by():
    """At x .75, v .5 disc and rim are wrinkled and rings between are not; at .5, .6 all are."""
    _, _, partly = rings(CERTIFIED[3])
    assert np.any(partly.excess[0] == 0.0)
    assert partly.excess[0, 0] == pytest.approx(1.0 - CERTIFIED[3]["disc_n"] ** -0.5, rel=2e-3)
    assert partly.excess[0, -1] == pytest.approx(1.0 - CERTIFIED[3]["rim_n"] ** -0.5, rel=2e-3)
    _, _, wholly = rings(CERTIFIED[4])
    assert np.all(wholly.excess[0] > 0.0)
    own = film(CERTIFIED[4], COUNT).gel  # its own hoop counts, not the one that the ring spans
    wanted = own.strain(wholly.l1**2, wholly.width**2) / own.strain_limit
    np.testing.assert_allclose(wholly.limit_share, wanted, rtol=1e-12)
    assert np.all(np.diff(wholly.z[0]) < 0.0)
    slopes = np.diff(wholly.z[0]) / np.diff(wholly.r[0])
    assert np.ptp(slopes) < 1e-6  # where no hoop pulls the meridian is straight


def test_what_cannot_be_held_is_not_found_and_does_not_disturb_others():
    """The film localises at x .7485 and v .545 (certified)."""
    own = film(CERTIFIED[1], COUNT)
    x, v = np.array([0.74, 0.76, 0.25, 0.25]), np.array([0.545, 0.545, 0.25, 0.0])
    at = held(own, x, v**2)
    assert at.found.tolist() == [True, False, True, True]
    found = profile(own, at)
    assert np.isnan(found.field[1]).all()
    alone = held(own, x[2:3], v[2:3] ** 2)
    np.testing.assert_allclose(at.r[2], alone.r[0], rtol=1e-9)


def test_the_flat_film_is_a_state_of_height_zero():
    own = film(CERTIFIED[7], COUNT)  # equi-biaxial: nothing moves
    at = held(own, np.zeros(2), np.array([0.0, 0.5]))
    assert at.found.all()
    found = profile(own, at)
    assert not found.z.any()
    np.testing.assert_allclose(found.l1, 1.0, rtol=1e-6)
    assert own.measures(at).force == pytest.approx([0.0, 0.0], abs=1e-12)
