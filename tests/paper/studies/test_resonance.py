"""Studies of figure 12: where the frequencies of the sweeps lie."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.atlas.branches.branch import EventKind
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import resonance
from gelcone.paper.studies.resonance import BAND, RESPONSES, STIFFNESSES, _around, _frequencies, natural_frequencies
from gelcone.presets import find_preset


def test_offsets_are_closer_together_in_the_middle():
    offsets = _around(2.0, 21)
    assert (offsets[0], offsets[10], offsets[-1]) == (-2.0, 0.0, 2.0)
    steps = np.diff(offsets)
    assert (steps > 0.0).all()
    assert steps[0] > 3.0 * steps[9]
    # u = 1/2: 0.3/2 + 0.7/8
    assert offsets[15] == pytest.approx(2.0 * (0.15 + 0.0875))


def test_frequencies_are_even_and_denser_around_half_the_natural_one_and_the_natural_one():
    natural = np.array([0.5, 3.0])
    grid = _frequencies(natural, 0.02, 100)
    assert grid.shape == (2, 100)
    for own, row in zip(natural, grid, strict=True):
        assert (np.diff(row) >= 0.0).all()
        assert (row.min(), row.max()) == (BAND[0], BAND[1])
        assert np.sum(np.abs(row - 0.5 * own) <= 0.08 + 1e-12) >= 35
        assert np.sum(np.abs(row - own) <= 0.16 + 1e-12) >= 25
        assert 0.5 * own in row
        assert own in row


def test_strong_damping_does_not_widen_the_bands_without_end():
    own = 1.0
    row = _frequencies(np.array([own]), 5.0, 100)[0]
    assert np.sum((row >= 0.5 - 0.35) & (row <= 0.5 + 0.35)) >= 35
    assert row.min() == BAND[0]


def test_natural_frequencies_rise_with_the_stiffness_and_are_those_of_the_mean_square_voltage():
    model = find_preset("spring").model.replace(spring_stiffness=np.array([5.0, 20.0]))
    found = natural_frequencies(model)
    v = float(np.asarray(model.voltage))
    for kappa, own in zip((5.0, 20.0), found, strict=True):
        one = find_preset("spring").model.replace(spring_stiffness=kappa)
        x = np.linspace(-1.0, 1.0, 200001)
        force = one.force(x, v / np.sqrt(2.0))
        k = np.flatnonzero(np.diff(np.sign(force)) > 0)[0]
        assert own**2 == pytest.approx((force[k + 1] - force[k]) / (x[1] - x[0]), rel=1e-3)
    assert (STIFFNESSES[0], STIFFNESSES[-1], len(STIFFNESSES)) == (0.1, 20.0, 6)
    assert RESPONSES == (0.7, 1.0, 1.5)


def test_branches_of_each_stiffness_stand_one_behind_the_other_with_gaps(monkeypatch):
    """Two of three branches are short; of each half of what it covers, and an instability that is not known is NaN."""
    nan = np.nan

    def followed(model, name, low, high, initial, **options):
        own = float(model.spring_stiffness)
        at = ("branch", "point")
        return xr.Dataset(
            {
                "period": ("branch", [1, resonance.LONGEST_PERIOD + 1, resonance.LONGEST_PERIOD]),
                "value": (at, [[low, own, nan], [9.0, 9.0, 9.0], [own, high, 3.0]]),
                "highest": (at, [[1.0, 2.0, nan], [9.0, 9.0, 9.0], [4.0, 5.0, 6.0]]),
                "lowest": (at, [[-1.0, 1.5, nan], [9.0, 9.0, 9.0], [1.0, 1.0, 1.0]]),
                "stable": (at, [[1, 0, -1], [1, 1, 1], [1, -1, 0]]),
                "event_value": ("event", [0.5 * own, 0.7]),
                "event_kind": ("event", [int(EventKind.FOLD), int(EventKind.PERIOD_DOUBLING)]),
            }
        )

    monkeypatch.setattr(resonance, "continue_branch", followed)
    model, count = find_preset("spring").model, len(STIFFNESSES)
    found = resonance._branches(model, (1.0, 0.0), np.tile([0.2, 0.9], (count, 1)))
    assert {name: dims for name, (dims, _, _) in found.items()} == {
        f"branch_{name}": ("member", "fold" if name == "fold" else "orbit")
        for name in ("frequency", "amplitude", "stable", "fold")
    }
    for k, stiffness in enumerate(STIFFNESSES):
        rows = {name: values[k] for name, (_, values, _) in found.items()}
        np.testing.assert_array_equal(rows["branch_frequency"], [0.2, stiffness, nan, stiffness, 0.9, 3.0, nan])
        np.testing.assert_array_equal(rows["branch_amplitude"], [1.0, 0.25, nan, 1.5, 2.0, 2.5, nan])
        np.testing.assert_array_equal(rows["branch_stable"], [1, 0, nan, 1, nan, 0, nan])
        np.testing.assert_array_equal(rows["branch_fold"], [0.5 * stiffness])


@pytest.mark.parametrize("film", ["taut", "wrinkling", "membrane"])
def test_a_response_over_the_frequency_has_the_sweeps_and_of_the_papers_film_the_branches(monkeypatch, film):
    asked, shares = {}, []
    effort = replace(QUICK, film=film, frequencies=40)
    natural = np.linspace(1.0, 6.0, len(STIFFNESSES))

    def response(model, grid, initial, progress):
        asked.update(model=model, grid=grid, initial=initial)
        progress(1.0)
        at = ("member", "branch", "step")
        stiffness = ("member", np.asarray(model.spring_stiffness))
        return xr.Dataset({"amplitude": (at, np.zeros((6, 2, 40)))}, coords={"spring_stiffness": stiffness})

    def branches(model, initial, grid):
        asked.update(branch=(float(np.asarray(model.drive_frequency)), initial), branch_grid=grid)
        return {"branch_amplitude": (("member", "orbit"), natural[:, None])}

    monkeypatch.setattr(resonance, "frequency_response", response)
    monkeypatch.setattr(resonance, "natural_frequencies", lambda model: natural)
    monkeypatch.setattr(resonance, "_branches", branches)
    found = resonance.frequency(effort, shares.append)
    preset = effort.preset("spring")
    assert shares == [1.0]
    np.testing.assert_array_equal(asked["model"].spring_stiffness, STIFFNESSES)
    assert asked["model"].film.name == film
    np.testing.assert_array_equal(asked["grid"], _frequencies(natural, float(preset.model.damping_ratio), 40))
    assert asked["initial"] == preset.initial
    assert ("branch_amplitude" in found) == (film == "taut")
    if film == "taut":
        np.testing.assert_array_equal(asked["branch_grid"], asked["grid"])
        np.testing.assert_array_equal(found["branch_amplitude"][:, 0], natural)
        assert asked["branch"][1] == preset.initial
    np.testing.assert_array_equal(found["natural_frequency"], natural)
    assert found["natural_frequency"].dims == ("spring_stiffness",)
    assert found["amplitude"].dims == ("spring_stiffness", "sweep", "step")
    assert (found.attrs["preset"], found.attrs["parameter"]) == ("spring", "drive_frequency")
    assert found.attrs["title"] == "amplitude over drive frequency"


def test_responses_lie_around_the_forced_resonance_of_one_stiffness(monkeypatch):
    """At half its natural frequency; the motions of all three are asked for together."""
    asked = {}

    def motions(preset, model, parameter, effort, progress):
        asked.update(preset=preset, model=model, parameter=parameter)
        return "motions"

    monkeypatch.setattr(resonance, "motions", motions)
    assert resonance.frequency_responses(QUICK, lambda share: None) == "motions"
    one = find_preset("spring").model.replace(spring_stiffness=np.array([1.0]))
    resonant = 0.5 * natural_frequencies(one)[0]
    np.testing.assert_allclose(asked["model"].drive_frequency, [0.7 * resonant, resonant, 1.5 * resonant])
    assert float(np.asarray(asked["model"].spring_stiffness)) == 1.0
    assert (asked["preset"].name, asked["parameter"]) == ("spring", "drive_frequency")


def test_bands_are_no_wider_than_a_share_of_the_frequency_and_for_weak_damping_than_a_few_half_widths():
    """Four half widths around half the natural frequency, eight around it; 0.35 and 0.4 of it at most."""
    for damping, half, whole in ((0.01, 0.04, 0.08), (0.5, 0.35, 0.4)):
        (row,) = _frequencies(np.array([1.0]), damping, 400)
        even = np.geomspace(*BAND, 400 - 140 - 100)
        own = row[~np.isin(row, even)]
        near = np.sort(np.concatenate([0.5 + _around(half, 140), 1.0 + _around(whole, 100)]))
        np.testing.assert_allclose(own, near)
