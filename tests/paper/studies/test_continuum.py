"""Thresholds of the corrected model: where they are read off, and what is lost with a film that pulls in."""

import importlib
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from gelcone import ConeModel
from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.classification import Evidence
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import continuum as module
from gelcone.presets import find_preset
from tests.paper.test_unwrinkled import CONE, film_like_the_cone

VOLTAGES = np.array([0.1, 0.2, 0.4, 0.7])


@pytest.mark.parametrize(
    ("met", "interval"),
    [
        ([False, False, True, True], (0.2, 0.4)),
        ([False, True, False, True], (0.1, 0.2)),
        ([True, True, True, True], (0.1, 0.1)),
        ([False, False, False, True], (0.4, 0.7)),
    ],
)
def test_a_threshold_lies_between_the_last_voltage_without_and_the_first_with(met, interval):
    assert module._first(VOLTAGES, np.array(met)) == interval


def test_what_is_never_met_has_no_threshold():
    assert np.isnan(module._first(VOLTAGES, np.zeros(4, dtype=bool))).all()


def test_the_onset_of_a_film_that_is_the_cone_is_the_cones_and_nothing_is_lost():
    model = CONE.replace(damping_ratio=0.05, drive_frequency=0.3)
    found = module._onset("onset", model, film_like_the_cone())
    assert np.isnan(found.lost)
    np.testing.assert_allclose(found.corrected, found.cone, rtol=1e-9)
    assert found.cone[1] > found.cone[0] > 0.0


def test_a_film_that_pulls_in_before_rest_is_lost_says_at_which_voltage():
    """The flat film's highest V is 1/0.04; with a stiff spring rest is stable up to there."""
    film = film_like_the_cone(ceiling=(0.04,))
    model = CONE.replace(spring_stiffness=200.0, damping_ratio=0.2, drive_frequency=0.9)
    found = module._onset("onset", model, film)
    assert np.isnan(found.corrected).all()
    assert found.lost == pytest.approx(5.0, rel=1e-12)


def test_the_pitchfork_of_a_film_with_another_stiffness_carries_the_error_of_its_fit():
    pytest.importorskip("skfem")
    model = ConeModel(law="neo-hookean", spring_stiffness=0.09)
    found = module._pitchfork("pitchfork", model, film_like_the_cone(radius_ratio=0.2))
    assert np.isnan(found.lost)  # no state is lost before it
    assert found.cone == pytest.approx((0.3, 0.3), rel=1e-9)
    middle = 0.5 * sum(found.corrected)
    assert middle == pytest.approx(0.3, rel=1e-9)
    assert 0.0 < found.corrected[1] - found.corrected[0] < 0.1


def test_last_bits_of_the_linear_algebra_do_not_reach_the_report():
    """Values keep 8 digits of the largest one, estimates of error 3."""
    force = xr.DataArray(np.array([123.456789012345, 1e-9, np.nan]), name="force", attrs={"units": "1"})
    rounded = module._rounded(force)
    assert rounded.values[:2].tolist() == [123.45679, 0.0]
    assert np.isnan(rounded.values[2])
    assert rounded.attrs == force.attrs
    other = module._rounded(force * (1.0 + 1e-13))
    assert np.array_equal(other.values, rounded.values, equal_nan=True)
    assert module._rounded(force.rename("force_error")).values[0] == 123.0
    assert module._rounded(force * 0.0).values[0] == 0.0


@pytest.mark.parametrize(
    ("film", "name", "count"), [("taut", "quick", 8), ("wrinkling", "quick", 5), ("taut", "full", 15)]
)
def test_the_continuum_is_compared_without_a_drive_at_the_voltages_of_figure_3(monkeypatch, film, name, count):
    """Another film than the paper's wrinkles on both sides; fewer heights in a quick run."""
    compare = importlib.import_module("gelcone.continuum.compare")
    asked = {}

    def compared(model, ratios, **options):
        asked.update(model=model, ratios=ratios, **options)
        return xr.Dataset({"force": ("x", [1.2345678912, 3.0]), "ending": ("x", [1, 2])})

    monkeypatch.setattr(compare, "compare", compared)
    found = module.continuum(replace(QUICK, film=film, name=name), lambda share: None)
    assert float(asked["model"].voltage) == 0.0
    assert float(asked["model"].spring_stiffness) == float(find_preset("table1").model.spring_stiffness)
    np.testing.assert_allclose(asked["displacements"], np.linspace(0.1, 1.3, count))
    assert (asked["ratios"], asked["voltages"]) == ((0.2, 0.5), (0.0, 1.0, 1.5))
    assert asked["wrinkles"] == ("mark" if film == "taut" else "relax")
    assert asked["elements"] == module.ELEMENTS
    assert found["force"].values.tolist() == [1.2345679, 3.0]
    assert found["ending"].values.tolist() == [1, 2]
    assert found.attrs == {"preset": "table1", "film": film}


def test_thresholds_are_those_of_their_sets_each_with_the_film_that_was_fitted_to_it(monkeypatch):
    seen = []
    monkeypatch.setattr(module, "_film", lambda model: f"film of {float(model.prestretch):g} {model.prestretch_mode}")

    def found(kind):
        def of(name, model, film, *more):
            own = tuple(float(getattr(model, one)) for one in ("prestretch", "spring_stiffness", "drive_frequency"))
            seen.append((kind, name, *own, film, *(np.ravel(one).tolist() for one in more)))
            return module.Threshold(name, (len(seen), 2.0 * len(seen)), (3.0 * len(seen), 0.5), 0.1 * len(seen))

        return of

    for kind in ("_pitchfork", "_onset", "_chaos"):
        monkeypatch.setattr(module, kind, found(kind))

    plain = module._film

    def fitted(model):
        return SimpleNamespace(of=plain(model), errors={"force": 0.25 * float(model.prestretch)})

    monkeypatch.setattr(module, "_film", fitted)
    shares = []
    result = module.corrected(replace(QUICK, film="taut"), shares.append)
    assert sum(shares) == pytest.approx(1.0)
    base, fast = find_preset("base").model, find_preset("fast").model
    own = [(row[0], *row[2:5], row[5].of) for row in seen]
    k1, k2 = float(base.spring_stiffness), float(fast.spring_stiffness)
    w1, w2 = float(base.drive_frequency), float(fast.drive_frequency)
    plain_film, tight = "film of 1 radial", f"film of {module.HIGH_PRESTRETCH:g} equibiaxial"
    assert own == [
        ("_pitchfork", 1.0, k1, w1, plain_film), ("_pitchfork", 1.0, k2, w2, plain_film),
        ("_pitchfork", 1.0, 0.1, w1, plain_film), ("_pitchfork", module.HIGH_PRESTRETCH, k1, w1, tight),
        ("_onset", 1.0, k1, w1, plain_film), ("_onset", 1.0, k2, w2, plain_film), ("_chaos", 1.0, k1, w1, plain_film),
    ]  # fmt: skip
    assert seen[-1][6:] == (list(find_preset("base").initial), [9])
    names = json.loads(result.attrs["threshold_names"])
    assert names == [row[1] for row in seen]
    assert json.loads(result.attrs["fit_errors"]) == {"force": 0.25}
    np.testing.assert_array_equal(result["cone"], [[k, 2 * k] for k in range(1, 8)])
    np.testing.assert_array_equal(result["corrected"], [[3 * k, 0.5] for k in range(1, 8)])
    np.testing.assert_allclose(result["lost"], 0.1 * np.arange(1, 8))
    other = module.corrected(replace(QUICK, film="wrinkling"), shares.append)
    assert (other.attrs["threshold_names"], set(other.data_vars)) == ("[]", set())


def test_chaos_is_searched_where_it_is_expected_and_below_with_the_film(monkeypatch):
    """The film pulls in above 0.55 and is chaotic above 0.35; the cone from the middle of its voltages on."""
    asked = []

    def classified(members, states):
        volts = members.values["voltage"]
        asked.append((volts, states, members.system.film.name))
        found = Evidence.blank(members.size)
        cone = members.system.film.name == "taut"
        found.regime[:] = np.where(volts > (1.01 if cone else 0.35), int(Regime.CHAOTIC), int(Regime.PERIODIC))
        found.outcome[:] = np.where((volts > 0.55) & (not cone), int(Outcome.PULLED_IN), int(Outcome.OK))
        return found

    monkeypatch.setattr(module, "classify", classified)
    start = np.array([1.0, 0.0])
    found = module._chaos("chaos", CONE, film_like_the_cone(), start, 9)
    (high, _, first), (low, states, second) = asked
    np.testing.assert_allclose(high, np.linspace(0.9, 1.1, 9))
    np.testing.assert_allclose(low, np.linspace(0.1, 0.9, 9))
    assert states is start
    assert first == "taut" != second
    assert found.cone == pytest.approx((1.0, 1.025))
    assert found.corrected == pytest.approx((0.3, 0.4))
    assert found.lost == pytest.approx(0.6)  # the lowest voltage at which no state is left


def test_the_error_of_a_fit_is_that_of_its_stiffness_over_what_a_voltage_takes_from_it(monkeypatch):
    """At a height of 0.02: |F/x - K + v^2|/(2 v gain) to both sides; the fitted film of formulas has K and the gain."""
    membrane = importlib.import_module("gelcone.continuum.membrane")
    asked = {}

    class Film:
        radius_ratio = 0.3

        @staticmethod
        def stiffness(xx, squared):
            asked.update(stiffness=(xx, squared))
            return np.array(5.0), np.array(9.0)

        @staticmethod
        def gain(xx, squared):
            asked.update(gain=(xx, squared))
            return np.array(1.25)

    def solved(model, ratio, **options):
        asked.update(ratio=ratio, **options)
        return xr.Dataset({"force": ("member", [0.02 * 4.0])})

    monkeypatch.setattr(membrane, "membrane", solved)
    low, high = module._with_fit_error(CONE, Film(), 2.0)
    off = abs(4.0 - 5.0 + 4.0) / (2.0 * 2.0 * 1.25)
    assert (low, high) == pytest.approx((2.0 - off, 2.0 + off))
    assert asked["stiffness"] == pytest.approx((0.0004, 4.0))
    assert asked["gain"] == (0.0, 4.0)
    assert (asked["ratio"], asked["displacements"], asked["voltages"]) == (0.3, 0.02, 2.0)


def test_an_onset_has_its_error_on_both_sides(monkeypatch):
    onset = xr.Dataset({"onset_voltage": 2.0, "onset_error": 0.25})
    assert module._interval(onset) == (1.75, 2.25)
