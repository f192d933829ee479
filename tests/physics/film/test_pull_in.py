"""The membrane's pull-in over the displacement: its voltages, where it applies, and that it is stored."""

import json
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.membrane.gel import Gel
from gelcone.membrane.pull_in import PullInCurve, pull_in_curve
from gelcone.physics.film import pull_in
from gelcone.physics.film.pull_in import membrane_pull_in
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel

CURVE = PullInCurve((0.0, 1.0, 2.0), (0.7, 0.5, 0.4), 0.01)
CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "membrane.json").read_text())["pull_in"]
WRINKLING = ConeModel(film="wrinkling")


def gel_of(meridional, hoop, limit):
    law = LAWS["gent"]
    return Gel(law, law.numbers({"stretch_limit": limit}), meridional**2, hoop**2)


@pytest.mark.parametrize("prestretch", [1, 1.5])
def test_voltages_are_certified_ones_within_their_error(prestretch):
    found = pull_in_curve(gel_of(prestretch, prestretch, 50), 0.2)
    rows = [
        r
        for r in CERTIFIED
        if (r["radius_ratio"], r["meridional_prestretch"], r["hoop_prestretch"]) == (0.2, prestretch, prestretch)
        and r["x"] > 0.7 * (prestretch == 1)
    ]
    assert len(rows) >= 2
    assert found.voltage([r["x"] for r in rows]) == pytest.approx([r["v"] for r in rows], rel=found.error)
    assert 1e-3 < found.error < 0.02
    if prestretch == 1:  # a low film falls slack first, and pulls in as a free one does
        assert found.voltage(0.3) == pytest.approx(0.691433, rel=1e-6)


@pytest.mark.parametrize(("x", "expected"), [(0.2, 1.0196), (0.6, 0.9904), (0.75, 0.8685), (1.5, 0.5371)])
def test_strong_hoops_pull_in_where_two_dimensional_elements_do(x, expected):
    """Of the continuum's elements (scikit-fem, 16 of the second order), for lm 1.1, lh 1.4, a/b 0.2667."""
    found = pull_in_curve(gel_of(1.1, 1.4, 50), 0.26666667)
    assert found.voltage(x) == pytest.approx(expected, rel=max(found.error, 4e-3))
    assert found.error < 0.05  # of low heights, where no localisation is found


def test_a_film_that_is_slack_at_any_voltage_pulls_in_nowhere_below():
    """A low stretch limit: a slack film never pulls in."""
    found = pull_in_curve(gel_of(1, 1, 5.0), 0.2)
    np.testing.assert_array_equal(found.voltage([0.0, 0.5, 1.0, 1.3]), np.inf)


def test_a_curve_is_even_linear_between_its_points_and_level_beyond():
    np.testing.assert_allclose(CURVE.voltage([-0.5, 0.5, 1.5, 9.0]), [0.6, 0.6, 0.45, 0.4])


def test_a_curve_is_computed_once_and_stored(tmp_path, monkeypatch):
    computed = []
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    monkeypatch.setattr(pull_in, "pull_in_curve", lambda gel, ratio: (computed.append(ratio), CURVE)[1])
    for _ in range(2):
        pull_in._curves.clear()  # that of this process
        assert membrane_pull_in(WRINKLING, 0.3) == CURVE
    assert computed == [0.3]
    assert membrane_pull_in(WRINKLING.replace(stretch_limit=40.0), 0.3) == CURVE
    assert membrane_pull_in(WRINKLING.replace(prestretch=1.1), 0.3) == CURVE
    assert membrane_pull_in(WRINKLING, None) == CURVE
    assert computed == [0.3, 0.3, 0.3, 0.2]
    monkeypatch.setenv("GELCONE_CACHE", "")
    membrane_pull_in(WRINKLING, 0.3)
    assert len(computed) == 4
    pull_in._curves.clear()
    membrane_pull_in(WRINKLING, 0.3)
    assert len(computed) == 5
    pull_in._curves.clear()


@pytest.mark.parametrize(
    "model",
    [
        ConeModel(),
        ConeModel(film="membrane"),
        ConeModel(film="wrinkling", pull_in="minimum"),
        ConeModel(film="wrinkling", second_film="wrinkling"),
        ConeModel(film="wrinkling", voltage=[0.1, 0.2]),
    ],
)
def test_other_films_have_none(model):
    assert membrane_pull_in(model, 0.2) is None


@pytest.mark.parametrize("ratio", [1.0, 0.0, np.nan])
def test_a_disc_as_large_as_the_film_is_refused(ratio):
    with pytest.raises(InputError, match="must lie between 0 and 1"):
        membrane_pull_in(WRINKLING, ratio)


def test_curves_that_are_not_known_are_left_out_where_a_hand_waits_and_named(monkeypatch):
    model = gelcone.find_device("biased-pump").to_model()
    members, x = model.members(), np.array([[0.2, 0.6]])
    film, voltage = members.system.films[0], np.array([[0.1, 0.2]])
    expected = pull_in.over_pull_in(film, members.values, x, voltage)
    assert expected is not None
    monkeypatch.setattr(pull_in, "_curves", {})
    with pull_in.known_curves() as missing:
        assert pull_in.over_pull_in(film, members.values, x, voltage) is None
    ((law, *_, ratio),) = missing
    assert (law, ratio) == (members.system.film.law, pytest.approx(8.0 / 30.0))
    for key in missing:
        pull_in.keep_curve(key, pull_in.curve_of(*key))
    with pull_in.known_curves() as missing:
        np.testing.assert_array_equal(pull_in.over_pull_in(film, members.values, x, voltage), expected)
    assert missing == {}
