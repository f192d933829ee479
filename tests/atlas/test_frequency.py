"""Frequency response at full drive: the linear limit, hysteresis, jumps, peaks, bad input."""

from __future__ import annotations

from types import SimpleNamespace

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
from gelcone.atlas.resonance import Peaks
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.linear import linear_peak, linear_response
from gelcone.motion.state_space import equilibrium_under_bias, small_signal_response
from gelcone.motion.stepping import Falls, Walk
from gelcone.motion.swing import HARMONICS, Swing, settled_swing
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset
from tests.atlas.made_up_swings import RESTING, moving, resonance
from tests.recorded import numbers, record

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


@pytest.mark.parametrize("answer", ["frequency", "settled"])
def test_a_phase_is_that_by_which_the_displacement_is_ahead_of_the_voltage_over_time(answer):
    """The label names the sign: the disc follows the voltage by a part of a period, so that its phase is negative."""
    omega, count = 1.3, 400
    model = LINEAR.replace(drive_frequency=omega)
    period = 2.0 * np.pi / omega
    run = gelcone.simulate(model, (0.8, 0.0), times=40.0 * period + period * np.arange(count + 1) / count)
    lines = [np.fft.rfft(run[name].values[:-1])[1] for name in ("displacement", "drive_voltage")]
    ahead = np.degrees(np.angle(lines[0] / lines[1]))
    assert -170.0 < ahead < -10.0
    found = gelcone.settled(model, (0.8, 0.0)) if answer == "settled" else frequency(model, [omega, 1.6], (0.8, 0.0))
    phase = found["harmonic_phase"]
    assert "ahead of the voltage" in phase.attrs["long_name"]
    assert float(phase.sel(harmonic=1).values.flat[0]) == pytest.approx(ahead, abs=0.1)


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
    monkeypatch.setattr("gelcone.atlas.resonance.NARROWINGS", narrowings)
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


def test_sweeps_that_pull_in_at_every_frequency_have_no_peak():
    film = ConeModel(film="wrinkling", damping_ratio=0.2, voltage=0.1, voltage_bias=2.0, hoop_prestretch=1.2)
    found = frequency(film, [0.5, 1.0])
    assert (found["outcome"] == Outcome.PULLED_IN).all()
    for name in ("stroke", "peak_amplitude", "peak_amplitude_error", "peak_frequency", "peak_low", "peak_high"):
        assert found[name].isnull().all(), name


def test_the_largest_linear_stroke_lies_between_the_frequencies():
    """That of a light linear oscillator: Q times the static one at omega sqrt(1 - 2 zeta^2)."""
    found = frequency(LINEAR, [1.0, 1.3, 1.6])
    fine = np.linspace(1.0, 1.6, 20_001)
    strokes = linear_response(LINEAR, fine).stroke
    assert found["linear_peak_stroke"].item() == pytest.approx(strokes.max(), rel=1e-6)
    assert found["linear_peak_frequency"].item() == pytest.approx(fine[strokes.argmax()], abs=1e-4)
    assert found["linear_peak_stroke"].item() > 1.001 * found["linear_stroke"].values.max()
    below, exact = np.nextafter(1.3, 0.0), found["linear_peak_stroke"].item()
    for grid in ([1.0, below, 1.3, 1.6], [1.0, 1.3, np.nextafter(1.3, 2.0), 1.6], [1.0, 1.7 - 0.4, 1.6]):
        again = linear_peak(LINEAR.members(), np.array([grid]), linear_response(LINEAR, grid).stroke[None])
        assert again[1].item() == pytest.approx(exact, rel=1e-9), "two frequencies one rounding apart end no search"
    rising = frequency(LINEAR, [0.5, 0.6])
    assert rising["linear_peak_frequency"].item() == 0.6
    assert rising["linear_peak_stroke"].item() == rising["linear_stroke"].values[-1]


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
    figure = gelcone.plot(bent)
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"brute force", "stable", "unstable", "period 1", "fold"} <= labels
    low, high = sorted(bent["jump_event"].values)
    dashed = [line for line in figure.axes[0].lines if line.get_linestyle() == "--" or line.is_dashed()]
    inside = [np.isfinite(line.get_ydata()) & (line.get_xdata() > low) & (line.get_xdata() < high) for line in dashed]
    assert any(own.any() for own in inside)


def test_a_well_that_no_sweep_enters_has_its_branch():
    """Above the pitchfork a cone has two wells; the sweeps stay in the upper one."""
    wells = ConeModel(damping_ratio=0.1, voltage=0.02, voltage_bias=1.5, rest_height=0.01, stretch_limit=1e6)
    found = frequency(wells, [0.5, 0.6], (1.0, 0.0), branches=True)
    assert float(found["lowest"].min()) > 0.0
    followed = attached_branches(found)
    assert sorted(np.sign(followed["highest"].max("point").values)) == [-1.0, 1.0]
    assert followed.sizes["flag"] == 0


def test_branches_of_an_ensemble_are_refused():
    with pytest.raises(InputError, match="branches: takes one actuator"):
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


# --- made-up motions: amplitudes are functions of the frequency -------------------------------------------------------


def walked(model, grids, initial, progress, search):
    """Each motion is at its frequency, and begins where the walk does."""
    made = moving(resonance(grids), grids)
    made.final[..., 1] = initial[:, :1]
    nothing = np.full(grids.shape, np.nan)
    return Walk(made, Falls(grids - 0.01, grids + 0.01, made), [grids, nothing])


@pytest.fixture
def made_up(monkeypatch):
    """Walks, swings and what follows a motion give the resonance; ``looked`` are the frequencies looked at."""
    looked = []

    def seen(model, final, period, **options):
        return moving(resonance(model.number("drive_frequency")), final[:, 0])

    monkeypatch.setattr(module, "walk", walked)
    monkeypatch.setattr(module, "swing", seen)
    monkeypatch.setattr(module, "_complete", lambda model, grids, swept, search: looked.append(grids))
    return looked


def test_odd_members_are_swept_down_and_all_is_told_by_rising_frequency(made_up):
    grids = np.array([[1.0, 1.3, 1.4, 1.9], [1.1, 1.2, 1.5, 2.0]])
    initial = np.array([[0.1, 0.0], [0.2, 0.0]])
    swept, falls, trail = module._sweep(RESTING.members().take([0, 0]), np.array([0, 1]), grids, initial, None, {})
    np.testing.assert_array_equal(trail[0], [grids[0], grids[1, ::-1]])
    np.testing.assert_array_equal(swept.final[..., 0], grids)
    np.testing.assert_array_equal(swept.amplitude, resonance(grids))
    np.testing.assert_array_equal(falls.start, grids - 0.01)
    np.testing.assert_array_equal(falls.before.final[..., 0], grids)
    np.testing.assert_array_equal(made_up[0], grids)


def test_intervals_next_to_a_bend_are_filled_from_the_side_where_each_sweep_comes_from(made_up):
    """In even ratios; a motion that failed there begins anew. No frequency is lost, and each has its own motion."""
    grid = np.geomspace(0.8, 2.2, 12)
    grids = np.tile(grid, (2, 1))
    swept = moving(resonance(grids), 10.0 + grids)
    swept.final[0, 5] = np.nan
    initial = np.array([[0.1, 0.0], [0.2, 0.0]])
    every, filled = module._bends_filled(RESTING.members().take([0, 0]), grids, swept, initial, None, {})
    line = lambda k: np.interp(np.log(grid[k]), np.log(grid[[k - 1, k + 1]]), resonance(grid[[k - 1, k + 1]]))  # noqa: E731
    bends = [k for k in range(1, 11) if abs(resonance(grid[k]) - line(k)) > module.BENT * resonance(grid).max()]
    intervals = sorted({k + side for k in bends for side in (-1, 0)})
    assert 2 < len(intervals) < 11
    assert 5 in intervals
    inner = [np.geomspace(grid[k], grid[k + 1], module.FILLED + 2)[1:-1] for k in intervals]
    np.testing.assert_allclose(every, np.tile(np.sort(np.concatenate([grid, *inner])), (2, 1)))
    np.testing.assert_allclose(filled.amplitude, resonance(every))
    np.testing.assert_allclose(made_up[0], np.tile(inner, (2, 1)))
    for k, own in zip(intervals, inner, strict=True):
        for branch, end in ((0, k), (1, k + 1)):
            at = np.isclose(every[0][:, None], own).any(axis=1)
            np.testing.assert_allclose(filled.final[branch, at, 0], own)
            begun = 0.1 if (branch, end) == (0, 5) else 10.0 + grid[end]
            np.testing.assert_allclose(filled.final[branch, at, 1], begun)
    kept = np.isin(every[0], grid)
    np.testing.assert_array_equal(filled.final[:, kept], swept.final)
    flat = moving(np.ones((2, 12)))
    assert module._bends_filled(RESTING.members().take([0, 0]), grids, flat, initial, None, {})[1] is flat


def test_branches_begin_with_all_swept_motions_and_with_those_from_fixed_states(monkeypatch):
    """Of three starts, one near rest and one on the other side; what failed has no period."""
    grid, initial = np.array([1.0, 1.2, 1.4]), np.array([[0.8, 0.1]])
    asked = {}

    def settled(members, states, **options):
        asked["settled"] = members.number("drive_frequency"), states
        return moving(np.arange(9.0), np.arange(9.0))

    def followed(model, name, low, high, begin, **options):
        asked["branches"] = name, low, high, begin, options
        return "branches"

    swept = moving(np.ones((1, 2, 3)), np.arange(10.0, 16.0).reshape(1, 2, 3))
    swept.final[0, 1, 2] = np.nan
    monkeypatch.setattr(module, "settled_swing", settled)
    monkeypatch.setattr(module, "continue_branch", followed)
    monkeypatch.setattr(module, "attach", lambda result, branches: result)
    monkeypatch.setattr(module, "_jump_events", lambda result, branches: {})
    result = xr.Dataset(coords={"drive_frequency": grid, "start": [0, 1, 2]})
    found = module._with_branches(RESTING, result, swept, initial, None, {"tolerance": 1e-9, "threads": 2})
    omega, states = asked["settled"]
    np.testing.assert_array_equal(omega, np.tile(grid, 3))
    np.testing.assert_allclose(states, np.repeat([[0.8, 0.1], [0.04, 0.005], [-0.8, -0.1]], 3, axis=0))
    np.testing.assert_array_equal(found["fixed_stroke"], 2.0 * np.arange(9.0).reshape(3, 3))
    name, low, high, begin, options = asked["branches"]
    assert (name, low, high) == ("drive_frequency", 1.0, 1.4)
    assert tuple(begin) == (0.8, 0.1)
    runs = options["start"]
    np.testing.assert_array_equal(runs.values, np.tile(grid, 5))
    np.testing.assert_array_equal(runs.section[:, 0, 0], [*range(10, 15), np.nan, *range(9)])
    assert runs.period.tolist() == [1] * 5 + [0] + [1] * 9
    assert runs.arrived.tolist() == [True] * 5 + [False] + [True] * 9


# --- what is handed on ------------------------------------------------------------------------------------------------

SEARCH = {"transient": 11.0, "patience": 12.0, "tolerance": 2e-9, "threads": 5}
FLOW = {"tolerance": 2e-9, "threads": 5}


def numbered(*shape, at=0.0):
    """Swings in which no two numbers are equal."""
    blank = Swing.blank(*shape)
    own = {name: numbers(*values.shape, at=at + k) for k, (name, values) in enumerate(vars(blank).items())}
    own |= {
        "period": np.ones(shape, dtype=int),
        "resting": np.zeros(shape, dtype=bool),
        "outcome": np.zeros(shape, np.int8),
    }
    return Swing(**own)


@pytest.mark.parametrize("branches", [False, True])
@pytest.mark.parametrize("given", [False, True])
def test_a_response_hands_each_part_what_it_was_asked_for(monkeypatch, given, branches):
    """Two sweeps of each member, from its own start; frequencies are filled in where none are given."""
    model = ConeModel(damping_ratio=0.1) if branches or not given else ConeModel(damping_ratio=[0.1, 0.2])
    count, grid, shares = model.size, np.array([0.5, 0.75, 1.0]), []
    swept, filled = numbered(2 * count, 3, at=10.0), numbered(2, 4, at=50.0)
    finer = np.tile([0.5, 0.6, 0.75, 1.0], (2, 1))
    asked = record(
        monkeypatch, module, _around_resonance=grid, _sweep=(swept, "falls", "trail"), highest_peaks="peaks",
        jumps_of_sweeps="jumps", _bends_filled=(finer, filled), _label=xr.Dataset({"made": 1.0}),
        jump_variables={"jump": 2.0},
        _with_branches=lambda *given: given[1].assign(followed=3.0),
    )  # fmt: skip
    initial = numbers(*model.shape, 2)
    found = frequency(model, grid if given else None, initial, branches=branches, progress=shares.append, **SEARCH)
    made = {"made": 1.0, "jump": 2.0} | ({"followed": 3.0} if branches else {})
    assert {name: float(found[name]) for name in found} == made
    (sweep,), (peaks,), (jumps,), (label,) = (
        asked[name] for name in ("_sweep", "highest_peaks", "jumps_of_sweeps", "_label")
    )
    own = np.atleast_2d(initial)
    np.testing.assert_array_equal(sweep["initial"], np.repeat(own, 2, axis=0))
    np.testing.assert_array_equal(sweep["grids"], [grid] * 2 * count)
    np.testing.assert_array_equal(sweep["branch"], [0, 1] * count)
    assert sweep["model"].damping_ratio.tolist() == np.repeat(np.ravel(model.damping_ratio), 2).tolist()
    for call in (sweep, peaks, jumps):
        assert call["search"] == SEARCH
    assert (peaks["trail"], peaks["falls"], peaks["model"]) == ("trail", "falls", sweep["model"])
    assert (jumps["falls"], jumps["model"].size) == ("falls", count)
    np.testing.assert_array_equal(jumps["swept"].lowest, swept.lowest.reshape(count, 2, 3))
    shown = swept if given else filled
    np.testing.assert_array_equal(label["swept"].lowest, shown.lowest.reshape(count, 2, -1))
    np.testing.assert_array_equal(label["grid"], [grid] * count if given else finer[:1])
    assert (label["shared"], label["peaks"]) == (True, "peaks")
    options = {"initial": initial.tolist(), "nudge": module.NUDGE} | SEARCH
    del options["threads"]
    assert label["options"] == options
    assert asked["jump_variables"] == [{"jumps": "jumps", "ensemble": count > 1}]
    if not given:
        (bends,) = asked["_bends_filled"]
        assert bends["search"] == SEARCH
        assert bends["swept"] is swept
        np.testing.assert_array_equal(bends["initial"], sweep["initial"])
    if branches:
        (followed,) = asked["_with_branches"]
        assert (followed["model"], followed["search"]) == (model, SEARCH)
        np.testing.assert_array_equal(followed["initial"], own)
        np.testing.assert_array_equal(followed["swept"].lowest, shown.lowest.reshape(1, 2, -1))
    parts = [call["progress"] for call in (sweep, peaks, jumps, *asked["_bends_filled"], *asked["_with_branches"])]
    for part in parts:
        part(1.0)
    assert sum(shares) == pytest.approx(1.0)


def test_frequencies_lie_around_the_natural_one_under_the_bias(monkeypatch):
    asked = record(monkeypatch, module, natural_frequency=2.0, equilibrium_under_bias=0.75)
    model = ConeModel(voltage_bias=0.3)
    np.testing.assert_allclose(module._around_resonance(model), 2.0 * np.geomspace(*SPAN))
    assert asked["natural_frequency"] == [{"model": model, "voltage": 0.3, "displacement": 0.75}]
    assert asked["equilibrium_under_bias"] == [{"model": model, "bias": 0.3, "given": "voltage_bias ="}]
    module._around_resonance(model.replace(waveform="half_wave", voltage_bias=-0.3))
    assert asked["equilibrium_under_bias"][1]["bias"] == 0.0  # a half wave has no voltage below 0


def test_harmonics_and_validity_are_those_of_motions_that_ran_at_their_own_frequencies(monkeypatch):
    """Some at a time; what failed stays unknown."""
    monkeypatch.setattr(module, "AT_ONCE", 2)
    swept, grids = numbered(2, 2, at=10.0), np.array([[0.5, 0.75], [1.0, 1.25]])
    swept.outcome[0, 1] = Outcome.PULLED_IN
    before = swept.take(...)
    seen = {2: numbered(2, at=40.0), 1: numbered(1, at=70.0)}
    asked = record(monkeypatch, module, swing=lambda members, states, period, **options: seen[members.size])
    module._complete(ConeModel(damping_ratio=[0.1, 0.2]).members(), grids, swept, SEARCH)
    for call, rows, columns in zip(asked["swing"], ([0, 1], [1]), ([0, 0], [1]), strict=True):
        np.testing.assert_array_equal(call["members"].number("drive_frequency"), grids[rows, columns])
        np.testing.assert_array_equal(call["members"].damping_ratio, np.array([0.1, 0.2])[rows])
        np.testing.assert_array_equal(call["states"], before.final[rows, columns])
        np.testing.assert_array_equal(call["period"], before.period[rows, columns])
        assert {name: call[name] for name in FLOW} == FLOW
        assert not {"transient", "patience"} & call.keys()
        np.testing.assert_array_equal(swept.harmonics[rows, columns], seen[len(rows)].harmonics)
        np.testing.assert_array_equal(swept.validity[rows, columns], seen[len(rows)].validity)
    np.testing.assert_array_equal(swept.harmonics[0, 1], before.harmonics[0, 1])


def test_a_response_is_labelled_with_each_of_its_numbers(monkeypatch):
    """The linear response has the first two harmonics; strokes are twice amplitudes,"""
    model, grid = ConeModel(damping_ratio=0.1), np.array([[0.5, 0.75, 1.0]])
    swept = numbered(1, 2, 3, at=10.0)
    swept = Swing(**(vars(swept) | {"harmonics": swept.harmonics * np.exp(0.5j)}))
    harmonics = np.exp(0.25j) * numbers(1, 2, 3, at=3.0)
    linear = SimpleNamespace(stroke=numbers(1, 3, at=2.0), harmonics=harmonics)
    asked = record(monkeypatch, module, linear_response=linear)
    peaks = Peaks(*(numbers(2, at=20.0 + k) for k in range(5)))
    found = module._label(model, grid, True, swept, peaks, {"options": 1})
    np.testing.assert_array_equal(asked["linear_response"][0]["frequencies"], grid)
    own = swept.take(0)
    expected = {
        "amplitude": own.amplitude, "stroke": own.highest - own.lowest, "lowest": own.lowest, "highest": own.highest,
        "period": own.period, "resting": own.resting, "harmonic_amplitude": np.moveaxis(np.abs(own.harmonics), -1, 1),
        "harmonic_phase": np.moveaxis(own.phases, -1, 1), "linear_stroke": linear.stroke[0], "outcome": own.outcome,
        "drive_frequency": grid[0],
    }  # fmt: skip
    names = ("frequency", "low", "high", "amplitude", "amplitude_error")
    expected |= {f"peak_{name}": numbers(2, at=20.0 + k) for k, name in enumerate(names)}
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, err_msg=name)
    np.testing.assert_allclose(found["linear_amplitude"][:2], np.abs(harmonics[0]))
    np.testing.assert_allclose(found["linear_phase"][:2], np.degrees(0.25))
    assert (found["linear_amplitude"].values[2:] == 0.0).all()
    assert np.isnan(found["linear_phase"].values[2:]).all()
    assert found["branch"].values.tolist() == ["up", "down"]
    assert all(coordinate.attrs["long_name"] and "units" in coordinate.attrs for coordinate in found.coords.values())


def test_a_disc_at_rest_has_no_peak():
    """What is left of its start is no motion: 1e-56 of the width, of which a peak was reported."""
    flat = gelcone.ConeModel(voltage=[0.3, 0.9], voltage_bias=0.2, damping_ratio=0.1, spring_stiffness=0.5)
    found = frequency(flat, [0.9, 1.1])
    assert found["resting"][0].all()
    assert (found["amplitude"][0] < 1e-9).all()
    assert not found["resting"][1].all()
    for name in ("peak_amplitude", "peak_amplitude_error", "peak_frequency", "peak_low", "peak_high"):
        assert found[name][0].isnull().all(), name
        assert found[name][1].notnull().all(), name
