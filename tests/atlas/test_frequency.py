"""Frequency response at full drive: the linear limit, hysteresis, jumps, peaks, bad input."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.analyses.answer import result_json
from gelcone.analyses.frequency import frequency_words
from gelcone.analyses.request import Subject
from gelcone.atlas import frequency as module
from gelcone.atlas.branches.attached import attached_branches
from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.frequency import SPAN, _around_resonance, frequency
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.settled import HARMONICS, Swing, settled_swing
from gelcone.motion.state_space import equilibrium_under_bias, small_signal_response
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset

LINEAR = ConeModel(
    damping_ratio=0.1, voltage=1e-4, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, stretch_limit=1e6
)
JUMPING = ConeModel(damping_ratio=0.05, voltage=0.5, rest_height=0.1, spring_stiffness=0.1, stretch_limit=50.0)
"""The paper's softest spring: swept up, a swing of two drive repeats goes on beyond where it begins when swept down."""


@pytest.fixture(scope="module")
def small():
    return frequency(LINEAR, np.linspace(0.4, 2.4, 7), (0.8, 0.0))


@pytest.fixture(scope="module")
def jumping():
    return frequency(JUMPING, np.arange(6, 17) / 20.0)


# --- the linear limit -------------------------------------------------------------------------------------------------


def test_a_tiny_drive_about_a_bias_gives_the_analytic_response(small):
    expected = small_signal_response(LINEAR, small["drive_frequency"].values)
    first = small.sel(harmonic=1)
    for branch in ("up", "down"):
        np.testing.assert_allclose(
            first["harmonic_amplitude"].sel(branch=branch), 1e-4 * expected["gain"], rtol=1e-4, err_msg=branch
        )
        apart = (first["harmonic_phase"].sel(branch=branch) - expected["phase"] + 180.0) % 360.0 - 180.0
        assert float(np.abs(apart).max()) < 0.01
        np.testing.assert_allclose(small["stroke"].sel(branch=branch), 2e-4 * expected["gain"], rtol=1e-3)
    np.testing.assert_allclose(small["linear_stroke"], 2e-4 * expected["gain"], rtol=1e-3)
    assert (small["period"] == 1).all()
    assert small.sizes["jump"] == 0


def test_the_peak_is_that_of_a_linear_oscillator(small):
    place = equilibrium_under_bias(LINEAR, 0.6)
    peak = np.sqrt(float(LINEAR.stiffness(place, 0.6)) - 2.0 * 0.1**2)
    for branch in ("up", "down"):
        own = small.sel(branch=branch)
        assert float(own["peak_low"]) <= peak <= float(own["peak_high"])
        assert float(own["peak_frequency"]) == pytest.approx(peak, rel=5e-3)


@pytest.mark.parametrize("narrowings", [1, 3])
def test_the_error_of_a_peak_covers_the_amplitude_of_the_linear_peak(monkeypatch, narrowings):
    """Whatever the frequencies happen to hit; however early the search ends it is not ten times too large either."""
    monkeypatch.setattr("gelcone.atlas.frequency.NARROWINGS", narrowings)
    damping = np.array([0.05, 0.1, 0.15, 0.2, 0.3])
    found = frequency(LINEAR.replace(damping_ratio=damping), np.linspace(0.4, 2.4, 7), (0.8, 0.0)).sel(branch="up")
    near = np.linspace(0.8, 1.8, 20_001)
    exact = [1e-4 * np.max(small_signal_response(LINEAR.replace(damping_ratio=zeta), near)["gain"]) for zeta in damping]
    off, error = np.abs(found["peak_amplitude"].values - exact), found["peak_amplitude_error"].values
    assert (off <= error).all()
    assert (off > 0.03 * error).any()
    assert (off > 0.1 * error).any() or narrowings == 3


def test_a_pure_sine_drives_at_twice_its_frequency():
    model = LINEAR.replace(voltage=0.02, voltage_bias=0.0)
    found = frequency(model, [0.3, 0.6, 0.9], (0.8, 0.0))
    for phase in ("amplitude", "phase"):
        large, linear = (found[f"{kind}_{phase}"].sel(harmonic=2) for kind in ("harmonic", "linear"))
        np.testing.assert_allclose(large.sel(branch="up"), linear, rtol=1e-3)
    assert (found["harmonic_amplitude"].sel(harmonic=[1, 3]) < 1e-9).all()
    np.testing.assert_allclose(found["stroke"].sel(branch="up"), found["linear_stroke"], rtol=1e-3)


# --- large motions ----------------------------------------------------------------------------------------------------


def test_where_the_sweeps_differ_both_motions_are_there(jumping):
    frequency = 0.6
    ends = jumping["stroke"].sel(drive_frequency=frequency)
    assert float(ends.sel(branch="up")) > 20.0 * float(ends.sel(branch="down"))
    starts = np.array([(x, u) for x in np.linspace(-1.0, 1.0, 6) for u in (0.0, 0.5)])
    model = JUMPING.replace(drive_frequency=frequency, damping_ratio=np.full(len(starts), 0.05))
    late = gelcone.simulate(model, starts, periods=200)["displacement"].values[:, -1000:]
    for stroke in ends.values:
        assert np.abs(np.ptp(late, axis=1) / stroke - 1.0).min() < 2e-3


def test_a_jump_ends_every_range_in_which_the_sweeps_differ(jumping):
    jumps = jumping.isel(jump=slice(None))
    assert list(jumps["jump_branch"].values[:2]) == ["down", "up"]
    assert (jumps["jump_low"] < jumps["jump_high"]).all()
    assert float((jumps["jump_high"] - jumps["jump_low"]).max()) < 0.02 / 2**5
    up = jumping.sel(branch="up")
    fall = int(np.argmax(-np.diff(up["stroke"].values)))
    ends = jumping["drive_frequency"].values[[fall, fall + 1]]
    assert ends[0] <= float(jumps["jump_low"][1]) < float(jumps["jump_high"][1]) <= ends[1]
    assert float(jumps["jump_from"][1]) == pytest.approx(float(up["stroke"][fall]), rel=0.1)
    assert float(jumps["jump_to"][1]) < 0.2 * float(jumps["jump_from"][1])


@pytest.mark.parametrize("count", [9, 17])
def test_a_jump_is_bracketed_whatever_the_frequencies(count):
    """Down into the tongue, where rest loses its stability, which the multipliers of the flat film tell. A
    motion that falls from a branch early, or stays for long where it was, shows another frequency."""
    model = find_preset("base").model.replace(spring_stiffness=1.0)
    found = frequency(model, np.geomspace(0.92, 1.03, count), (0.01, 0.0))
    own = found.isel(jump=int(np.flatnonzero(found["jump_branch"].values == "down")[-1]))
    low, high = float(own["jump_low"]), float(own["jump_high"])
    assert low <= 0.96692797 <= high
    assert high - low < 0.02 * 0.11 / (count - 1)
    peak = found.sel(branch="down")
    assert float(peak["peak_low"]) <= 0.96692797 <= float(peak["peak_high"])


def test_a_subharmonic_is_told_by_its_period_and_its_harmonic(jumping):
    up = jumping.sel(branch="up")
    at = up["drive_frequency"].where(up["period"] == 2, drop=True)
    assert at.size >= 2
    doubled = up.sel(drive_frequency=at)
    assert (doubled["harmonic_amplitude"].sel(harmonic=1) > doubled["harmonic_amplitude"].sel(harmonic=2)).all()


def test_members_do_not_depend_on_one_another():
    model = JUMPING.replace(spring_stiffness=np.array([0.1, 5.0]))
    grid = np.array([[0.3, 0.5, 0.7], [1.0, 1.1, 1.2]])
    both = frequency(model, grid)
    assert both["stroke"].dims == ("member", "branch", "step")
    one = frequency(JUMPING.replace(spring_stiffness=5.0), grid[1])
    np.testing.assert_array_equal(both["stroke"].isel(member=1), one["stroke"])
    np.testing.assert_array_equal(both["swept_frequency"].isel(member=1), one["drive_frequency"])


def test_a_result_is_labelled_and_comes_back_as_it_was(jumping, tmp_path):
    for name in jumping.data_vars:
        assert {"long_name", "units"} <= set(jumping[name].attrs), name
    gelcone.save(jumping, tmp_path / "response.nc")
    assert gelcone.load(tmp_path / "response.nc").identical(jumping)


def test_films_at_rest_do_not_jump_and_follow_the_drive():
    flat = ConeModel(damping_ratio=0.2, voltage=0.1)
    found = frequency(flat, [0.5, 1.0, 1.5])
    assert float(found["stroke"].max()) < 1e-8
    assert (found["period"] == 0).all()
    assert (found["resting"] == 1).all()
    assert found.sizes["jump"] == 0


BENT = ConeModel(
    damping_ratio=0.01, voltage=0.06, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, law="neo-hookean"
)


@pytest.fixture(scope="module")
def bent():
    return frequency(BENT, np.linspace(1.4, 1.43, 4), (0.8, 0.0), branches=True)


def test_a_softening_cone_jumps_up_and_down_at_different_frequencies(bent):
    """The resonance bends to lower frequencies: swept down, the motion stays large for longer than swept up."""
    found = bent
    assert found["jump_branch"].values.tolist() == ["down", "up"]
    assert float(found["jump_high"][0]) < float(found["jump_low"][1])
    falls, rises = (found["jump_to"] / found["jump_from"]).values
    assert falls < 0.5
    assert rises > 2.0
    assert (found["period"] == 1).all()


# --- branches beside --------------------------------------------------------------------------------------------------


def test_hysteresis_ends_at_the_folds_of_the_branch(bent):
    """The folds are exact, the jumps are brackets of the sweeps: each holds one."""
    folds = bent["followed_event_value"].values[bent["followed_event_kind"].values == EventKind.FOLD]
    assert folds.size == 2
    assert (bent["jump_event_kind"] == EventKind.FOLD).all()
    np.testing.assert_array_equal(np.sort(folds), bent["jump_event"])
    assert (bent["jump_low"] <= bent["jump_event"]).all()
    assert (bent["jump_event"] <= bent["jump_high"]).all()
    np.testing.assert_allclose(bent["jump_event"], [1.413667972, 1.422222434], atol=2e-9)


def test_the_part_between_the_folds_is_unstable_and_brute_force_lies_on_the_rest(bent):
    own = attached_branches(bent).isel(branch=0)
    between = own["stable"].values == 0
    middle = own["value"].values[between]
    assert between.any()
    assert bent["jump_event"].values.min() <= middle.min() <= middle.max() <= bent["jump_event"].values.max()
    assert int(bent["followed_seeded"]) == 1
    assert bent.sizes["followed_flag"] == 0


def test_text_json_and_figure_tell_the_folds(bent):
    subject = Subject(BENT)
    assert frequency_words(bent, subject).count("fold at 1.4136679") == 2
    told = result_json(bent)
    assert told["jump_event_kind"] == ["fold", "fold"]
    assert set(told["followed_event_kind"]) == {"fold"}
    axes = gelcone.plot(bent).axes[0]
    labels = axes.get_legend_handles_labels()[1]
    assert {"brute force", "period 1, stable", "period 1, unstable", "fold"} <= set(labels)
    (dashed,) = [line for line in axes.lines if line.get_label() == "period 1, unstable"]
    assert np.isfinite(dashed.get_ydata()).any()


def test_a_well_that_no_sweep_enters_has_its_branch():
    """Above the pitchfork a cone has two wells; the sweeps stay in the upper one."""
    wells = ConeModel(damping_ratio=0.1, voltage=0.02, voltage_bias=1.5, rest_height=0.01, stretch_limit=1e6)
    found = frequency(wells, [0.5, 0.6], (1.0, 0.0), branches=True)
    assert float(found["lowest"].min()) > 0.0
    followed = attached_branches(found)
    assert sorted(np.sign(followed["highest"].max("point").values)) == [-1.0, 1.0]
    assert followed.sizes["flag"] == 0


def test_branches_of_an_ensemble_are_refused():
    with pytest.raises(InputError, match="belong to one actuator"):
        frequency(BENT.replace(voltage=[0.05, 0.06]), [1.0, 1.1], branches=True)


# --- swings -----------------------------------------------------------------------------------------------------------


def test_a_failed_member_stays_nan_and_leaves_the_others_alone():
    model = LINEAR.replace(voltage_bias=0.0, hoop_prestretch=1.0, stretch_limit=np.array([0.3, 50.0]))
    found = settled_swing(model.members(), np.tile([1.0, 0.0], (2, 1)))
    assert list(found.outcome) == [Outcome.OUTSIDE, Outcome.OK]
    assert np.isnan(found.amplitude[0])
    assert np.isfinite(found.amplitude[1])
    assert found.harmonics.shape == (2, len(HARMONICS))


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "frequencies", "message"),
    [
        (LINEAR, [1.0], "at least 2"),
        (LINEAR, 1.0, "at least 2"),
        (LINEAR, [2.0, 1.0], "increase"),
        (LINEAR, [0.0, 1.0], "positive"),
        (LINEAR, [1.0, np.nan], "positive"),
        (LINEAR, [[1.0, 2.0], [1.0, 2.0]], r"shape \(frequencies,\) or \(1, frequencies\)"),
        (LINEAR.replace(damping_ratio=0.0), [1.0, 2.0], "damping_ratio = 0"),
        (LINEAR.replace(drive_frequency=[1.0, 2.0]), [1.0, 2.0], "drive_frequency: is what is swept"),
        (LINEAR.replace(voltage=np.ones((2, 2))), [1.0, 2.0], "one dimension"),
        (LINEAR.replace(stretch_limit=0.05, hoop_prestretch=1.0), [1.0, 2.0], "stretch_limit"),
    ],
)
def test_bad_input_is_refused(model, frequencies, message):
    with pytest.raises(InputError, match=message):
        frequency(model, frequencies)


# --- what happens at a jump -------------------------------------------------------------------------------------------


def test_the_amplitudes_of_a_jump_are_those_at_its_bracket(jumping):
    """The sweep up, taken as far as the bracket's lower end, has there the amplitude from which it jumps."""
    low, grid = float(jumping["jump_low"][1]), jumping["drive_frequency"].values
    before = grid[grid < low]
    closer = np.concatenate([before, np.linspace(before[-1], low, 6)[1:]])
    there = float(frequency(JUMPING, closer)["stroke"].sel(branch="up")[-1])
    assert float(jumping["jump_from"][1]) == pytest.approx(there, rel=1e-4)
    on_grid = float(jumping["stroke"].sel(branch="up", drive_frequency=before[-1]))
    assert abs(float(jumping["jump_from"][1]) / on_grid - 1.0) > 1e-3


def test_a_sweep_leaves_a_rest_that_has_become_unstable():
    """Started exactly at rest, only the nudge between frequencies lets the parametric motion grow."""
    flat = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, voltage=0.8)
    found = frequency(flat, [0.5, 1.0, 1.1], (0.0, 0.0))
    assert float(found["stroke"].sel(branch="up")[0]) < 1e-6
    assert float(found["stroke"].sel(branch="up")[2]) > 0.1


def test_what_differs_from_a_peak_by_less_than_is_resolved_may_be_the_peak():
    places, nearly = np.array([[1.0, 2.0, 3.0, 4.0, 5.0]]), 1.0 - 0.5 * module.RESOLVED
    low, high = module._beside(places, np.array([[0.5, nearly, 1.0, nearly, 0.9]]), np.array([3.0]), np.array([1.0]))
    assert (low.tolist(), high.tolist()) == ([1.0], [5.0])


def test_the_bifurcation_behind_a_jump_lies_in_its_bracket_or_no_further_off_than_that_is_wide():
    jumps = xr.Dataset({"jump_low": ("jump", [1.0, 1.4]), "jump_high": ("jump", [1.1, 1.5])})
    events = xr.Dataset({"event_value": ("event", [1.15, 1.7]), "event_kind": ("event", np.array([3, 4]))})
    found = jumps.assign(module._jump_events(jumps, events))
    np.testing.assert_array_equal(found["jump_event"], [1.15, np.nan])
    assert found["jump_event_kind"].values.tolist() == [3, -1]


def test_the_default_frequencies_are_closer_where_the_stroke_bends():
    """Between them the line is far nearer to the motion than between the even ones, whose strokes stay as they are."""
    model = ConeModel(damping_ratio=0.02, rest_height=0.5, voltage=0.05, voltage_bias=0.2)
    found = frequency(model)
    known = found["drive_frequency"].values
    even = _around_resonance(model)
    coarse = frequency(model, even)
    own = np.isin(known, coarse["drive_frequency"].values)
    assert own.sum() == SPAN[2] < known.size
    for name in ("stroke", "harmonic_phase", "validity_error"):
        np.testing.assert_array_equal(found[name].isel(drive_frequency=own).values, coarse[name].values)
    middle = np.sqrt(even[1:] * even[:-1])
    truth = gelcone.settled(model.replace(drive_frequency=middle))["stroke"].values
    off = [np.abs(np.interp(middle, r["drive_frequency"], r["stroke"][0]) - truth).max() for r in (found, coarse)]
    assert off[0] < 0.01 * truth.max() < 0.1 * truth.max() < off[1]


def test_of_several_bifurcations_the_nearest_to_the_bracket_counts_and_of_equal_ones_the_lower_kind():
    jumps = xr.Dataset({"jump_low": ("jump", [1.0, 2.0, 3.0]), "jump_high": ("jump", [1.1, 2.1, 3.1])})
    places, kinds = [1.02, 1.05, 1.15, 2.18, 1.94, 3.19, 2.91, 3.5], [3, 1, 0, 0, 5, 2, 4, 0]
    events = xr.Dataset({"event_value": ("event", places), "event_kind": ("event", np.array(kinds))})
    found = jumps.assign(module._jump_events(jumps, events))
    np.testing.assert_array_equal(found["jump_event"], [1.05, 1.94, 3.19])
    assert found["jump_event_kind"].values.tolist() == [1, 5, 2]


def swings(amplitude, period=1):
    """Swings up and down, (members, branches, steps)."""
    found = Swing.blank(*np.shape(amplitude))
    found.highest[:], found.lowest[:], found.period[:] = amplitude, -np.asarray(amplitude), period
    return found


def test_sweeps_differ_by_a_fiftieth_of_the_larger_unless_both_are_chaotic_or_next_to_nothing():
    up = np.array([[1.0, 1.0, 1.0, 1e-9, 1.0]])
    down = np.array([[0.975, 0.985, 1.03, 2e-9, np.nan]])
    one = swings(np.stack([up, down], axis=1))
    assert module.differing(one).tolist() == [[True, False, True, False, False]]
    chaotic = swings(np.stack([up, down], axis=1), np.array([[[0, 1, 0, 1, 1], [0, 1, 2, 1, 1]]]))
    assert module.differing(chaotic).tolist() == [[False, False, True, False, False]]


def test_a_height_is_certain_where_the_motion_is_periodic_or_there_is_none():
    heights, period = np.array([[0.5, 0.6, -1.0, 0.7]]), np.array([[1, 0, 0, 2]])
    np.testing.assert_array_equal(module._certain(heights, period), [[0.5, np.nan, -1.0, 0.7]])


def test_a_peak_lies_between_the_next_places_that_are_certainly_lower():
    places, heights = (
        np.array([[1.0, 2.0, 3.0, 4.0, 5.0]] * 2),
        np.array([[0.2, 0.9, 1.0, np.nan, 0.5], [1, 2, 3, 4, 5.0]]),
    )
    low, high = module._beside(places, heights, np.array([3.0, 5.0]), np.array([1.0, 5.0]))
    assert (low.tolist(), high.tolist()) == ([2.0, 4.0], [5.0, 5.0])
