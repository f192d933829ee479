"""Pull-in curves that are interpolated between those of a few films: values, error, and where they apply."""

import numpy as np
import pytest

from gelcone.physics.film import interpolated_pull_in
from gelcone.physics.film.interpolated_pull_in import InterpolatedCurve, interpolated_curves
from gelcone.physics.film.pull_in import curves_between
from gelcone.physics.model import ConeModel


@pytest.mark.parametrize("bend", [0.0, 0.05])
def test_curves_between_others_are_the_plane_through_them_and_their_error_is_that_of_leaving_one_out(monkeypatch, bend):
    """Of made-up films, whose voltage is a plane over hoop pre-stretch squared and a/b, and bends by ``bend``."""
    made, places = [], np.linspace(0.0, 2.0, interpolated_pull_in.PLACES)

    def volts(B, ratio):
        return (0.5 + 0.2 * B + 0.3 * ratio + bend * (B - 1.4) ** 2) * (1.0 + 0.1 * places)

    def curve_of(law, numbers, A, B, ratio):
        made.append((B, ratio))
        return InterpolatedCurve({"film_error": 0.01 * B, "reach_squared": 4.0}, volts(B, ratio))

    monkeypatch.setattr(interpolated_pull_in, "curve_of", curve_of)
    random = np.random.default_rng(1)
    hoops, ratios = random.uniform(1.1, 1.3, 60), random.uniform(0.15, 0.3, 60)
    members = ConeModel(film="wrinkling", hoop_prestretch=hoops, radius_ratio=ratios).members()
    with interpolated_curves(members) as between:
        assert between.films == 60
        assert between.made == len(made) == len(set(made)) < 15
        assert len(curves_between) == 60 - between.made
        off = []
        for (_, _, A, B, ratio), curve in curves_between.items():
            assert A == 1.0
            assert ratio in ratios
            assert curve.reach == 2.0
            assert curve.error == pytest.approx(0.01 * max(B for B, _ in made))
            off.append(np.max(np.abs(curve.voltage(places) / volts(B, ratio) - 1.0)))
        assert max(off) < (1e-10 if not bend else 6.0 * between.error)
        columns = np.array([(1.0, B, ratio) for B, ratio in made])
        left_out = []
        for k in range(len(made)):
            others = np.arange(len(made)) != k
            values = np.array([volts(*one) for one in made])
            found = columns[k] @ np.linalg.lstsq(columns[others], values[others], rcond=None)[0]
            left_out.append((values[k] - found) / values[k])
        assert between.error == pytest.approx(np.sqrt(np.mean(np.square(left_out))), rel=1e-6, abs=1e-12)
    assert not curves_between
    read = InterpolatedCurve({"film_error": 0.0, "reach_squared": 4.0}, volts(1.4, 0.2))
    np.testing.assert_allclose(read.voltage([-1.0, 1.0, 5.0]), [0.924, 0.924, 1.008], rtol=1e-12)


def test_few_films_and_films_without_curves_are_not_interpolated(monkeypatch):
    """Films that differ in one way take six to interpolate between, so that seven are the fewest."""
    curve = InterpolatedCurve({"film_error": 0.0, "reach_squared": 4.0}, np.ones(2))
    for count, lost, there in ((6, 2.0, False), (7, 2.0, True), (7, 1.19, False)):
        monkeypatch.setattr(
            interpolated_pull_in, "curve_of", lambda law, numbers, A, B, ratio, lost=lost: curve if lost > B else None
        )
        members = ConeModel(film="wrinkling", hoop_prestretch=np.sqrt(np.linspace(1.1, 1.2, count))).members()
        with interpolated_curves(members) as between:
            assert (between is not None) == there
            assert between is None or (between.films, between.made) == (count, 6)
    members = ConeModel(film="wrinkling", pull_in="minimum", hoop_prestretch=np.linspace(1.1, 1.2, 9)).members()
    with interpolated_curves(members) as between:
        assert between is None


@pytest.mark.parametrize(("bend", "interpolated"), [(0.0, True), (3.0, False)])
def test_curves_that_bend_too_much_are_not_interpolated(monkeypatch, bend, interpolated):
    """Their error by leaving one out is more than 3 %: each film then has a membrane of its own."""
    numbers = {"film_error": 0.0, "reach_squared": 4.0}

    def curve_of(law, of_law, A, B, ratio):
        return InterpolatedCurve(numbers, np.full(2, 0.5 + 0.2 * B + bend * (B - 1.4) ** 2))

    monkeypatch.setattr(interpolated_pull_in, "curve_of", curve_of)
    members = ConeModel(film="wrinkling", hoop_prestretch=np.linspace(1.05, 1.35, 40)).members()
    with interpolated_curves(members) as between:
        assert (between is not None) == interpolated
        assert bool(curves_between) == interpolated


def test_only_films_with_a_curve_and_pull_in_at_the_same_places_are_interpolated(monkeypatch):
    """A taut cone has a curve where its radius ratio is given; inf next to numbers cannot be interpolated."""
    numbers, hoops = {"film_error": 0.0, "reach_squared": 4.0}, np.linspace(1.05, 1.35, 40)
    never = np.inf

    def curve_of(law, of_law, A, B, ratio):
        return InterpolatedCurve(numbers, np.array([0.5, 0.5, 0.5 if B < 1.5 else never]))

    monkeypatch.setattr(interpolated_pull_in, "curve_of", curve_of)
    for film, more, there in (
        ("wrinkling", {}, True), ("taut", {}, False), ("taut", {"radius_ratio": 0.2}, True), ("membrane", {}, False),
    ):  # fmt: skip
        never = 0.5
        members = ConeModel(film=film, hoop_prestretch=hoops, **more).members()
        with interpolated_curves(members) as between:
            assert (between is not None) == there
    never = np.inf
    with interpolated_curves(ConeModel(film="wrinkling", hoop_prestretch=hoops).members()) as between:
        assert between is None
