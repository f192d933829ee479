"""With more than two states a pair of multipliers can leave the unit circle: a torus is born, and is reported."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.branches import continue_branch_words
from gelcone.analyses.request import Subject
from gelcone.atlas.branches import crossing
from tests.atlas.branches.events import events_of
from tests.toys import TurningBias

MODEL = gelcone.ConeModel(bias=TurningBias(), damping_ratio=0.1, voltage=0.3, drive_frequency=0.8)


@pytest.fixture(scope="module")
def result():
    # brute force starts with the wheel moving: one at rest stays so
    start = (0.4, 0.0, 0.1, 0.0)
    return gelcone.continue_branch(MODEL, "wheel_growth", -0.11, 0.07, start, start="settled", checks=3)


def test_a_torus_is_born_where_the_wheel_begins_to_grow(result):
    """The wheel's deviations grow as exp((g + i w) t), whatever the disc does: at g = 0 they pass the unit circle."""
    (event,) = events_of(result)
    assert event["kind"] == "torus"
    assert abs(event["value"]) <= event["value_error"] < 1e-10
    assert event["born_branch"] is None
    assert event["supercritical"] is None
    period = np.pi / 0.8
    pair = np.exp(0.618j * period)
    found = [complex(*m) for m in event["multipliers"]]
    np.testing.assert_allclose(sorted(found, key=abs)[-2:], [pair, pair.conjugate()], atol=1e-9)
    # those of the disc shrink areas by exp(-2 zeta T)
    assert abs(np.prod(sorted(found, key=abs)[:2])) == pytest.approx(np.exp(-0.2 * period), rel=1e-9)


@pytest.mark.parametrize("width", [0.3, 1e-2, 1e-5])
def test_the_error_of_a_torus_holds_the_bracket(monkeypatch, width):
    """However early the search ends, the true value, 0, lies within the error."""
    monkeypatch.setattr(crossing, "TORUS_WIDTH", width)
    start = (0.4, 0.0, 0.1, 0.0)
    found = gelcone.continue_branch(MODEL, "wheel_growth", -0.11, 0.07, start, start="settled", checks=2, switch=0)
    (event,) = events_of(found)
    assert abs(event["value"]) <= event["value_error"] <= max(width, 0.2) * 0.18 + 1e-12


def test_the_orbit_is_stable_before_and_unstable_behind(result):
    own = result.isel(branch=0)
    np.testing.assert_array_equal(own["stable"], own["value"] < 0.0)
    assert result.sizes["flag"] == 0


def test_text_and_figure_tell_it(result):
    assert "torus at" in continue_branch_words(result, Subject(MODEL))
    assert "torus" in [handle.get_label() for handle in gelcone.plot(result).axes[0].get_legend().legend_handles]
