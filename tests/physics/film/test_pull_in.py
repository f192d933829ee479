"""The membrane's pull-in over the displacement: its voltages, where it applies, and that it is stored."""

import json
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.physics.film import pull_in
from gelcone.physics.film.interpolated_pull_in import InterpolatedCurve
from gelcone.physics.film.pull_in import membrane_pull_in
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel

CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "membrane.json").read_text())["pull_in"]
WRINKLING = ConeModel(film="wrinkling")


def curve_at(meridional, hoop, ratio=0.2, limit=50.0):
    law = LAWS["gent"]
    numbers = {name: float(value) for name, value in law.numbers({"stretch_limit": limit}).items()}
    return pull_in.curve_of(law, tuple(numbers.items()), meridional**2, hoop**2, ratio)


@pytest.mark.parametrize("prestretch", [1, 1.5])
def test_voltages_are_certified_ones(prestretch):
    found = curve_at(prestretch, prestretch)
    rows = [
        r
        for r in CERTIFIED
        if (r["radius_ratio"], r["meridional_prestretch"], r["hoop_prestretch"]) == (0.2, prestretch, prestretch)
        and r["x"] > 0.7 * (prestretch == 1)
    ]
    assert len(rows) >= 2
    assert found.voltage([-r["x"] for r in rows]) == pytest.approx([r["v"] for r in rows], rel=2e-3)
    if prestretch == 1:  # a low film falls slack first, and pulls in as a free one does
        assert found.voltage(0.3) == pytest.approx(0.691433, rel=1e-6)


@pytest.mark.parametrize(("x", "expected"), [(0.2, 1.0196), (0.6, 0.9904), (0.75, 0.8685), (1.5, 0.5371)])
def test_strong_hoops_pull_in_where_two_dimensional_elements_do(x, expected):
    """Of the continuum's elements (scikit-fem, 16 of the second order), for lm 1.1, lh 1.4, a/b 0.2667."""
    assert curve_at(1.1, 1.4, 8.0 / 30.0).voltage(x) == pytest.approx(expected, rel=1.1e-2)


def test_the_curve_of_a_cone_is_that_of_the_film_named_membrane():
    """At any displacement, of the device with either film."""
    device = gelcone.find_device("biased-pump")
    cone, membrane = (device.replace(film=film).to_model() for film in ("wrinkling", "membrane"))
    x = np.linspace(-2.0, 2.0, 41)
    expected = np.sqrt(membrane.film.highest_squared(x, membrane.own_numbers))
    found = membrane_pull_in(cone)
    np.testing.assert_allclose(found.voltage(x), expected, rtol=1e-12)
    assert found.error == membrane.own_numbers["film_error"]


def test_a_film_of_which_there_is_no_table_has_no_curve():
    assert curve_at(1.0, 1.0, limit=5.0) is None
    assert membrane_pull_in(WRINKLING.replace(stretch_limit=5.0)) is None


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
    assert membrane_pull_in(model) is None


@pytest.mark.parametrize("ratio", [1.0, 0.0, np.nan])
def test_a_disc_as_large_as_the_film_is_refused(ratio):
    with pytest.raises(InputError, match="radius_ratio"):
        membrane_pull_in(WRINKLING.replace(radius_ratio=ratio))


def test_curves_that_are_not_known_are_left_out_where_a_hand_waits_and_named(monkeypatch):
    model = gelcone.find_device("biased-pump").replace(film="wrinkling").to_model()
    members, x = model.members(), np.array([[0.2, 0.6]])
    film, voltage = members.system.films[0], np.array([[0.1, 0.2]])
    expected = pull_in.over_pull_in(film, members.values, x, voltage)
    assert expected is not None
    np.testing.assert_array_equal(pull_in.over_pull_in(film, members.values, x, -voltage), expected)
    monkeypatch.setattr(pull_in, "_curves", {})
    with pull_in.known_curves() as missing:
        assert pull_in.over_pull_in(film, members.values, x, voltage) is None
    ((law, *_, ratio),) = missing
    assert (law, ratio) == (members.system.film.law, pytest.approx(8.0 / 30.0))
    for key in missing:
        pull_in.store_curve(key, pull_in.curve_of(*key))
    with pull_in.known_curves() as missing:
        np.testing.assert_array_equal(pull_in.over_pull_in(film, members.values, x, voltage), expected)
    assert missing == {}


@pytest.mark.slow
def test_a_curve_that_would_dip_below_its_lowest_column_takes_a_lower_degree():
    """Interpolation the flat film and the lowest column its polynomial went below 0: the film had no state there."""
    model = gelcone.find_device("biased-pump").replace(disc_radius="9.3 mm", hoop_prestretch=1.55).to_model()
    n, x = model.members().numbers_at(0), np.geomspace(1e-4, 0.1, 40)
    assert model.film.highest_squared(x, n).min() > 0.1
    assert np.isfinite(model.force(x, 0.1)).all()


class Ten(InterpolatedCurve):
    """A curve of which the voltage is known: ten and the displacement without its sign."""

    def voltage(self, x):
        return 10.0 + np.abs(x)


def test_the_excess_over_pull_in_is_that_of_each_member_at_its_own_place(monkeypatch):
    """Curves of made-up films; the second film is asked at its own displacement, and one without a curve has none."""
    asked = []

    def curve_of(law, numbers, A, B, ratio):
        asked.append((law.name, dict(numbers), A, B, ratio))
        return None if B > 1.5 else Ten({}, np.zeros(1))

    monkeypatch.setattr(pull_in, "curve_of", curve_of)
    model = ConeModel(
        film="wrinkling", second_film="wrinkling", second_flat_height=0.5, hoop_prestretch=[1.1, 1.3, 1.1],
        radius_ratio=[0.2, 0.2, 0.3], second_hoop_prestretch=1.2, second_radius_ratio=0.25,
    )  # fmt: skip
    members = model.members()
    x, volts = np.array([[0.2, -0.4]] * 3), np.array([[11.0, -5.0], [1.0, 1.0], [22.0, 0.0]])
    first, second = members.system.films
    values = {name: np.broadcast_to(value, 3) for name, value in members.values.items()}
    found = pull_in.over_pull_in(first, values, x, volts)
    whole = np.abs(volts) / (10.0 + np.abs(x)) - 1.0
    np.testing.assert_allclose(found, np.where(np.array([[False], [True], [False]]), -1.0, whole))
    squares = sorted((round(A, 12), round(B, 12), ratio) for _, _, A, B, ratio in asked)
    assert squares == [(1.0, 1.21, 0.2), (1.0, 1.21, 0.3), (1.0, 1.69, 0.2)]
    other = pull_in.over_pull_in(second, values, x, volts)
    np.testing.assert_allclose(other, np.abs(volts) / (10.0 + np.abs(0.5 - x)) - 1.0)
    assert asked[-1][2:] == (pytest.approx(1.0), pytest.approx(1.44), 0.25)
    membrane = ConeModel(film="membrane").members()
    assert pull_in.over_pull_in(membrane.system.films[0], membrane.values, x[:1], volts[:1]) is None


def test_next_to_the_flat_film_a_strong_hoop_pulls_in_at_no_voltage_and_a_place_without_state_says_so():
    found = curve_at(1.0, 1.5)
    volts = found.voltage(np.array([0.0, 1e-3, 0.2, 0.9 * found.reach]))
    assert not np.isnan(volts).any()
    unknown = pull_in.PullInCurve({**found.numbers, "slack_limit": np.nan})
    assert unknown.voltage(np.array([0.0])) == [np.inf]


def test_a_hand_within_a_hand_leaves_out_what_the_outer_one_does(monkeypatch):
    monkeypatch.setattr(pull_in, "_curves", {})
    monkeypatch.setattr(pull_in, "curve_of", lambda *key: pytest.fail("a curve was made"))
    members, x = WRINKLING.replace(radius_ratio=0.25).members(), np.array([[0.2]])
    film = members.system.films[0]
    with pull_in.known_curves() as outer:
        with pull_in.known_curves() as inner:
            assert pull_in.over_pull_in(film, members.values, x, x) is None
        assert (len(inner), len(outer)) == (1, 0)
        assert pull_in.over_pull_in(film, members.values, x, x) is None
        assert outer == inner


def test_curves_are_held_in_numbers_and_those_of_films_themselves_come_before_interpolated_ones(monkeypatch):
    monkeypatch.setattr(pull_in, "MOST", 3)
    monkeypatch.setattr(pull_in, "_curves", {})
    own, between = Ten({}, np.zeros(1)), InterpolatedCurve({}, np.zeros(1))
    keys = [(LAWS["gent"], (("inverse_stretch_limit", 0.02),), 1.0, 1.0 + k, 0.2) for k in range(9)]
    for key in keys:
        pull_in.store_curve(key, own)
        assert len(pull_in._curves) <= 3
    monkeypatch.setattr(pull_in, "curves_between", {keys[-1]: between, keys[0]: between})
    assert pull_in.curve_of(*keys[-1]) is own
    assert pull_in.curve_of(*keys[0]) is between
