"""Where films with a strong hoop fall slack, and where slack films pull in."""

import numpy as np
import pytest

from gelcone.membrane import slack
from gelcone.membrane.elements import Chains, Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.slack import slack_height, slack_limit, slack_voltages
from gelcone.physics.laws import LAWS

LAW = LAWS["gent"]


def gel_of(meridional, hoop, limit=50.0):
    return Gel(LAW, LAW.numbers({"stretch_limit": limit}), meridional**2, hoop**2)


HEIGHTS = [
    (1.1, 1.4, 0.267, [(0.8, 0.0078), (0.85, 0.0402), (0.9, 0.0797), (0.95, 0.1302), (0.99, 0.1844)]),
    (1.0, 1.5, 0.2, [(0.25, 0.0151), (0.4, 0.0537), (0.6, 0.1188), (0.8, 0.208)]),
]
"""Pre-stretches, a/b, and heights at shares of the voltage that takes the flat film's tension: found by marching the
rims of a film between the layers of its fold, in a program of its own (see the documentation of the continuum)."""


@pytest.mark.parametrize(("meridional", "hoop", "ratio", "rows"), HEIGHTS)
def test_heights_at_which_a_film_with_rims_falls_slack(meridional, hoop, ratio, rows):
    gel = gel_of(meridional, hoop)
    flat = float(gel.crumpling(gel.B)) / gel.G
    for share, height in rows:
        assert slack_height(gel, ratio, share * flat) == pytest.approx(height, abs=6e-5)
        assert slack_voltages(gel, ratio)(np.array([height]))[0] == pytest.approx(share * flat, rel=2e-3)


@pytest.mark.parametrize("excess", [1e-6, 1e-4, 1e-3, 0.01, 0.03])
@pytest.mark.parametrize(("stretch", "ratio"), [(1.3, 0.3), (1.78, 0.47)])
def test_a_hoop_stretched_a_little_more_changes_little(stretch, ratio, excess):
    """Its rims are longer than the film: it is in tension at all heights, up to voltages near those of equal ones."""
    x = np.array([0.01, 0.1, 0.3])
    gel, equal = gel_of(stretch, stretch * (1.0 + excess)), gel_of(stretch, stretch)
    assert slack_height(gel, ratio, 0.0) == 0.0
    if equal.hump() > equal.A:  # else it localises first
        own, other = (slack_voltages(each, ratio)(x) for each in (gel, equal))
        np.testing.assert_allclose(own, other, rtol=4.0 * excess + 0.05)
    film = Elements(gel, ratio, 60)
    assert (film.measures(film.unloaded(x)).force > 0.0).all()


@pytest.mark.parametrize(("meridional", "hoop", "ratio"), [(1.1, 1.4, 0.267), (1.0, 1.5, 0.2), (1.1, 1.3, 0.5)])
def test_the_force_of_the_elements_vanishes_there(meridional, hoop, ratio):
    """The square root of the force falls to zero linearly with the voltage (section 3 of the specification)."""
    gel, x = gel_of(meridional, hoop), 0.1
    slack = float(slack_voltages(gel, ratio)(np.array([x]))[0])
    film = Elements(gel, ratio, 160)
    at, forces = film.unloaded(np.array([x])), []
    for share in [*np.linspace(0.1, 0.9, 17), 0.94, 0.96, 0.98, 0.985]:
        at = film.found(Chains(np.array([share * slack]), at.r, at.z, at.tension, at.found))
        assert at.found[0]
        forces.append(float(film.measures(at).force[0]))
    last, before = np.sqrt(forces[-1]), np.sqrt(forces[-2])
    assert 0.985 + 0.005 * last / (before - last) == pytest.approx(1.0, abs=1.2e-2)


def test_a_film_whose_hoop_is_not_the_stronger_falls_slack_as_a_whole():
    gel = gel_of(1.2, 1.2)
    x = np.array([0.0, 0.3])
    np.testing.assert_allclose(slack_voltages(gel, 0.2)(x) * gel.G, gel.crumpling(gel.A * (1.0 + x * x)))
    assert slack_height(gel, 0.2, float(slack_voltages(gel, 0.2)(x)[1])) == pytest.approx(0.3, rel=1e-6)
    assert slack_limit(gel) == pytest.approx(float(gel.crumpling(gel.hump())) / gel.G)


def test_a_slack_film_pulls_in_where_its_rim_localises():
    """Columns of finite elements at several heights end at one voltage, below that of an evenly stretched film."""
    gel = gel_of(1.1, 1.4)
    limit = slack_limit(gel)
    assert limit < float(gel.crumpling(gel.hump())) / gel.G
    film = Elements(gel, 0.267, 160)
    for x in (0.2, 0.3):
        at = film.unloaded(np.array([x]))
        for share in np.linspace(0.05, 0.99, 30):
            at = film.found(Chains(np.array([share * limit]), at.r, at.z, at.tension, at.found))
            assert at.found[0]
        beyond = film.found(Chains(np.array([1.01 * limit]), at.r, at.z, at.tension, at.found))
        assert not beyond.found[0] or film.least_tangent_stiffness(beyond)[0] < 0.0


def test_the_limit_lies_between_the_voltages_at_which_rims_are_computed(monkeypatch):
    gel = gel_of(1.1, 1.4)
    limit = slack_limit(gel)
    monkeypatch.setattr(slack, "VOLTAGES", 2 * slack.VOLTAGES + 7)
    assert slack_limit(gel) == pytest.approx(limit, rel=1e-5)


def test_a_film_without_a_hump_has_no_limit_while_slack():
    assert slack_limit(gel_of(1.0, 1.0, 3.0)) == np.inf


def test_voltages_of_a_film_whose_rims_end_early_rise_with_its_height():
    law = LAWS["yeoh"]
    soft = Gel(law, law.numbers({"yeoh_c2": -0.0088808, "yeoh_c3": 9.6887e-05}), 1.0, 4.0)
    voltages = slack_voltages(soft, 0.25)(np.array([0.01, 0.05, 0.08]))
    assert np.all(np.diff(voltages) > 0.0)
    assert slack_height(soft, 0.25, voltages[1]) == pytest.approx(0.05, rel=1e-3)


@pytest.mark.parametrize("lengthened", [1.46, 1.5, 1.55])
def test_a_film_whose_hoop_is_slack_when_flat_falls_slack_as_a_whole_too(lengthened):
    """Its voltage lengthens it beyond both pre-stretches: A (1 + x^2) is the natural stretch, as of equal ones."""
    gel = gel_of(1.1, 1.2)
    V, x = float(gel.crumpling(lengthened)) / gel.G, np.sqrt(lengthened / gel.A - 1.0)
    assert lengthened > gel.B
    assert slack_height(gel, 0.25, V) == pytest.approx(x, rel=1e-9)
    assert slack_voltages(gel, 0.25)(np.array([x]))[0] == pytest.approx(V, rel=1e-12)


def test_the_heights_between_rims_are_computed_once(monkeypatch):
    gel, made, between = gel_of(1.0, 1.5), [], slack._between_rims
    monkeypatch.setattr(slack, "_between_rims", lambda *given: made.append(given) or between(*given))
    of_height = slack_voltages(gel, 0.2)
    assert 0.0 < of_height(np.array([0.05]))[0] < of_height(np.array([0.1]))[0]
    assert len(made) == 1
