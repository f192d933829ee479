"""What an integrator is given and gives back: the arrays of a run of which nothing is known yet."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.motion.job import KEEPS, Trajectories, to_the_end
from gelcone.physics.model import ConeModel
from tests.toys import FilteredVoltage

MODELS = {
    "planar": ConeModel(damping_ratio=0.1),
    "filtered": ConeModel(damping_ratio=0.1, circuit=FilteredVoltage()),
    "mixed": ConeModel(damping_ratio=0.1, film="wrinkling", second_film="taut", second_drive="same"),
}


@pytest.mark.parametrize("keep", KEEPS)
@pytest.mark.parametrize("kind", MODELS)
def test_nothing_is_known_of_a_run_that_has_not_begun(kind, keep):
    """Tangents and works are there where they are kept; the divergence of a planar system is known without a run."""
    system, times = MODELS[kind].members().system, np.arange(8.0).reshape(2, 4)
    outcome, states = np.array([0, 3], dtype=np.int8), 3 if kind == "filtered" else 2
    found = Trajectories.blank(times, system, keep, outcome)
    unknown = {"states": (2, 4, states), "end_times": (2,), "end_states": (2, states)}
    unknown |= {"tangents": (2, 4, states, states)} if keep == "tangents" else {}
    unknown |= {"divergence": (2, 4)} if keep == "tangents" and kind == "filtered" else {}
    unknown |= {"work": (2, 4, len(system.causes))} if keep == "work" else {}
    for name in ("states", "tangents", "divergence", "work", "end_times", "end_states"):
        values = getattr(found, name)
        assert (values is None) == (name not in unknown), name
        if values is not None:
            assert values.shape == unknown[name], name
            assert np.isnan(values).all(), name
    films = len(system.films)
    assert films == (2 if kind == "mixed" else 1)
    most = len(system.films[0].kinds)
    assert (most > 0) == (kind == "mixed")
    for name, shape in {"steps": (2,), "pull_in": (2, films), "film_times": (2, films, most)}.items():
        assert getattr(found, name).shape == shape, name
        assert not getattr(found, name).any(), name
    assert found.times is times
    assert found.outcome is outcome


def test_samples_of_a_run_that_ended_have_its_end_behind_the_last_that_it_reached():
    """One ends between two samples, one on a sample, one not at all, and one before the second sample taken."""
    times = np.tile(np.arange(5.0), (4, 1))
    states = np.stack([times, 0.0 * times], axis=-1)
    for member, reached in enumerate((3, 3, 5, 1)):
        states[member, reached:] = np.nan
    ends = np.array([2.7, 2.0, 4.0, 0.4])
    run = SimpleNamespace(times=times, states=states, end_times=ends, end_states=np.stack([ends, ends + 9.0], axis=-1))
    at, found = to_the_end(run, np.array([0, 2, 3, 4]))
    np.testing.assert_array_equal(at, [[0.0, 2.0, 2.7, 4.0], [0, 2, 3, 4], [0, 2, 3, 4], [0.0, 0.4, 3.0, 4.0]])
    nan = np.nan
    np.testing.assert_array_equal(found[..., 0], [[0, 2, 2.7, nan], [0, 2, nan, nan], [0, 2, 3, 4], [0, 0.4, nan, nan]])
    np.testing.assert_array_equal(found[..., 1], [[0, 0, 11.7, nan], [0, 0, nan, nan], [0] * 4, [0, 9.4, nan, nan]])
    np.testing.assert_array_equal(run.times, times)
    np.testing.assert_array_equal(to_the_end(run)[0][0], [0.0, 1.0, 2.0, 2.7, 4.0])
