"""The membrane's pull-in over the displacement: its voltages, where it applies, and that it is kept."""

import importlib.util

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum import pull_in
from gelcone.continuum.charged import Charged
from gelcone.continuum.path import Ending
from gelcone.continuum.pull_in import PullInCurve, find_pull_in_curve, pull_in_curve
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel

CURVE = PullInCurve((0.0, 1.0, 2.0), (0.7, 0.5, 0.4), 0.01)


def test_voltages_are_those_of_the_membrane_within_their_error(monkeypatch):
    """Those of 200 elements at two heights; a lower film falls slack first and pulls in as a free one does."""
    monkeypatch.setattr(pull_in, "HEIGHTS", (0.5, 0.75, 1.0))
    found = pull_in_curve(ConeModel())
    np.testing.assert_allclose(found.voltage([0.2, 0.75, 1.0]), [0.691433, 0.5445, 0.4377], rtol=found.error)
    assert 0.005 < found.error < 0.1


def test_a_film_that_is_slack_at_any_voltage_pulls_in_only_where_it_is_in_tension(monkeypatch):
    """A low stretch limit: a slack film never pulls in."""
    monkeypatch.setattr(pull_in, "HEIGHTS", (1.0, 1.6))
    found = pull_in_curve(ConeModel(stretch_limit=5.0))
    np.testing.assert_array_equal(found.voltage([0.0, 0.5, 1.0, 1.3]), np.inf)
    np.testing.assert_allclose(found.voltage([1.6, 2.0]), 1.0653, rtol=found.error)
    assert found.error < 0.02


def test_a_height_at_which_the_search_fails_says_nothing(monkeypatch):
    found = Charged([], 0.01, 0.0, Ending.NOT_CONVERGED), Charged([], 0.25, 0.0, Ending.PULLED_IN)
    monkeypatch.setattr(pull_in, "HEIGHTS", (0.5, 0.75))
    monkeypatch.setattr(pull_in, "charged", lambda film, start, *_, **__: found[start.height == 0.75])
    curve = pull_in_curve(ConeModel())
    assert curve.displacements == (0.0, 0.75)
    assert curve.voltages[-1] == 0.5


def test_a_curve_is_even_linear_between_its_points_and_level_beyond():
    np.testing.assert_allclose(CURVE.voltage([-0.5, 0.5, 1.5, 9.0]), [0.6, 0.6, 0.45, 0.4])


def test_a_curve_is_computed_once_and_kept(tmp_path, monkeypatch):
    computed = []
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    monkeypatch.setattr(pull_in, "pull_in_curve", lambda model, ratio: (computed.append(ratio), CURVE)[1])
    wrinkling = ConeModel(film="wrinkling")
    for _ in range(2):
        assert find_pull_in_curve(wrinkling, 0.3) == CURVE
    assert computed == [0.3]
    assert find_pull_in_curve(wrinkling.replace(stretch_limit=40.0), 0.3) == CURVE
    assert len(computed) == 2
    monkeypatch.setenv("GELCONE_CACHE", "")
    find_pull_in_curve(wrinkling, 0.3)
    assert len(computed) == 3


@pytest.mark.parametrize(
    "model",
    [
        ConeModel(),
        ConeModel(film="wrinkling", pull_in="minimum"),
        ConeModel(film="wrinkling", second_film="wrinkling"),
        ConeModel(film="wrinkling", voltage=[0.1, 0.2]),
    ],
)
def test_other_films_have_none(model):
    assert find_pull_in_curve(model, 0.2) is None


def test_without_scikit_fem_there_is_none(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert find_pull_in_curve(ConeModel(film="wrinkling"), 0.2) is None


def test_a_disc_as_large_as_the_film_is_refused():
    with pytest.raises(InputError, match="must lie between 0 and 1"):
        find_pull_in_curve(ConeModel(film="wrinkling"), 1.0)
