"""Where rest loses its stability: what each member of an ensemble takes from which search."""

import json

import numpy as np
import pytest

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion import limits as module
from gelcone.physics.balance import PullIn
from gelcone.physics.film.at_once import FilmAtOnce
from gelcone.physics.model import ConeModel

MIXED = ConeModel(film="taut", rest_height=[0.0, 0.3, 0.0, 0.0], stretch_limit=[50.0, 50.0, 0.01, 20.0], prestretch=1.2)
"""Flat, raised, beyond its stretch limit, and flat."""


@pytest.fixture
def searches(monkeypatch):
    """Searches whose results are told apart, and what they were asked."""
    asked = {}

    def onset(members, **options):
        asked["onset"] = (members.values["stretch_limit"].tolist(), options)
        options["progress"](1.0)
        return {
            "outcome": np.array([Outcome.OK, Outcome.STEP_LIMIT]),
            "onset_voltage": np.array([0.5, 0.6]),
            "onset_error": np.array([1e-6, 2e-6]),
        }

    monkeypatch.setattr(module, "onset_voltage", onset)
    monkeypatch.setattr(module, "every_balance", lambda members: members)
    monkeypatch.setattr(module, "pitchfork_voltages", lambda members: 0.1 * members.values["stretch_limit"])
    monkeypatch.setattr(
        module, "jump_voltages", lambda members: (members.values["stretch_limit"], np.full(members.size, PullIn.FILM))
    )
    return asked


def test_each_member_has_the_results_of_its_own_searches(searches):
    """One beyond its limit has none, one that does not rest flat no onset; an onset that fails is the outcome."""
    shares = []
    members = MIXED.members()
    found = module.limits_cells(
        members, members.start_states((0.0, 0.0)), tolerance=1e-9, threads=3, progress=shares.append
    )
    nan = np.nan
    expected = {
        "onset_voltage": [0.5, nan, nan, 0.6],
        "onset_error": [1e-6, nan, nan, 2e-6],
        "pitchfork_voltage": [5.0, 5.0, nan, 2.0],
        "pull_in_voltage": [50.0, 50.0, nan, 20.0],
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(found.variables[name][1], values, name)
    assert found.variables["pull_in_kind"][1].tolist() == [PullIn.FILM, PullIn.FILM, PullIn.NEVER, PullIn.FILM]
    assert found.outcome.tolist() == [Outcome.OK, Outcome.OK, Outcome.OUTSIDE, Outcome.STEP_LIMIT]
    limits, options = searches["onset"]
    assert limits == [50.0, 20.0]
    assert (options["tolerance"], options["threads"]) == (1e-9, 3)
    assert sum(shares) == pytest.approx(1.0)


def test_rest_that_stays_stable_is_told_from_a_film_that_does_not_rest_flat(searches, monkeypatch):
    onset = {"outcome": np.zeros(2), "onset_voltage": np.array([np.nan, 0.6]), "onset_error": np.array([np.nan, 1e-6])}
    monkeypatch.setattr(module, "onset_voltage", lambda *given, **options: onset)
    members = MIXED.members()
    found = module.limits_cells(members, members.start_states((0.0, 0.0)))
    np.testing.assert_array_equal(found.variables["onset_voltage"][1], [np.inf, np.nan, np.nan, 0.6])
    of = found.variables["onset_voltage"][3]
    assert (of["infinite_means"], of["nan_means"]) == ("none found", "not applicable")


def test_where_no_member_rests_flat_no_onset_is_searched_and_progress_ends(searches):
    shares, members = [], MIXED.members().take(np.array([1, 2]))
    module.limits_cells(members, members.start_states((0.0, 0.0)), progress=shares.append)
    assert "onset" not in searches
    assert shares == [1.0]


@pytest.mark.parametrize("at_once", [False, True])
def test_at_once_the_branches_of_pitchfork_and_pull_in_are_held_and_those_of_the_onset_are_not(searches, at_once):
    model = MIXED.replace(viscous_modulus_1=1.0, relaxation_time_1=1e4).members()
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "pitchfork_voltages", lambda members: seen.append(members.system.film) or np.zeros(3))
        patch.setattr(
            module, "jump_voltages", lambda members: seen.append(members.system.film) or (np.ones(3), np.zeros(3))
        )
        found = module.limits_cells(model, model.start_states((0.0, 0.0)), at_once=at_once, progress=lambda share: None)
    assert [isinstance(film, FilmAtOnce) for film in seen] == [at_once] * 2
    np.testing.assert_array_equal(found.variables["onset_voltage"][1], [0.5, np.nan, np.nan, 0.6])
    np.testing.assert_array_equal(found.variables["pitchfork_voltage"][1], [0.0, 0.0, np.nan, 0.0])


def test_limits_are_those_of_the_cells_labelled_and_refused_where_no_film_lies_flat(searches):
    found = module.limits(MIXED, tolerance=1e-9, threads=3, progress=lambda share: None)
    np.testing.assert_array_equal(found["pitchfork_voltage"], [5.0, 5.0, np.nan, 2.0])
    assert found["outcome"].values.tolist() == [Outcome.OK, Outcome.OK, Outcome.OUTSIDE, Outcome.STEP_LIMIT]
    assert found.attrs["title"] == "limits"
    assert json.loads(found.attrs["options"]) == {"at_once": False, "tolerance": 1e-9}
    with pytest.raises(InputError, match=r"stretch_limit = 0\.01: must exceed"):
        module.limits(MIXED.replace(stretch_limit=0.01))
