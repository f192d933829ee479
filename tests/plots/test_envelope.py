"""The figure of an operating envelope: limits, window and static curves stand at their values."""

import numpy as np
import pytest
import xarray as xr

from gelcone import Outcome, Regime
from gelcone.plots.envelope import (
    broken_at_jumps,
    driven_limits,
    envelope_figure,
    frequency_axis,
    natural_frequency,
    static_curves,
    twin_curves,
    window_yield,
)
from gelcone.plots.style import BLUE, GREEN, VERMILION
from tests.plots.made_up import blank, colour, corners, data_of, line, result, texts

OMEGA, VOLTS = np.array([1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 3.0])
WINDOW = np.array([1.0, 0.8, 1.2])


def padded(values, count):
    """As many limits as an envelope has; those added are not there."""
    blank = "other" if values.dtype.kind == "U" else np.nan
    return np.concatenate([values, np.full((count - len(values), *values.shape[1:]), blank)])


def envelope(**changed):
    values = {
        "peak_voltage": ("voltage", [0.5, 4.0]),
        "recommended_peak": ("drive_frequency", WINDOW),
        "driven_limit": ("limit", ["rest is lost", "dielectric breakdown"]),
        "limit_low": (("limit", "drive_frequency"), [[2.0, 1.0, 3.0], [np.nan] * 3]),
        "limit_high": (("limit", "drive_frequency"), [[2.2, 1.4, np.inf], [np.nan] * 3]),
        "static_limit": ("static", ["pitchfork", "pull-in", "stretch limit", "never"]),
        "static_limit_voltage": ("static", [1.5, 4.1, 4.3, np.nan]),
        "operating_frequency": ((), 2.0),
        "operating_peak_voltage": ((), 0.6),
        "constant_voltage": ("peak", VOLTS),
        "stroke": ("peak", [0.0, 0.1, 0.4, 0.9]),
        "blocked_force": ("peak", [0.0, -1.0, -2.0, -3.0]),
        "natural_frequency": ("peak", [1.0, 0.9, 0.7, 0.2]),
        "recommended_constant": ((), 1.2),
        "window_stroke": ("drive_frequency", [0.1, 0.2, 0.3]),
        "window_power": ("drive_frequency", [1.0, 2.0, 3.0]),
        "coexisting_motions": ("drive_frequency", [0, 1, np.nan]),
        "motion_regime": (("drive_frequency", "motion"), [[np.nan], [1.0], [np.nan]]),
        "motion_outcome": (("drive_frequency", "motion"), [[np.nan], [0.0], [np.nan]]),
        "kick_high": ("drive_frequency", [np.inf, 0.7, np.nan]),
        "window_regime": ("drive_frequency", [int(Regime.PERIODIC)] * 3),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    for name in ("driven_limit", "limit_low", "limit_high", "static_limit", "static_limit_voltage"):
        values[name] = values[name][0], padded(np.asarray(values[name][1]), 6 if "static" in name else 7)
    return result(values, {"drive_frequency": ("drive_frequency", OMEGA)}, {"drive_frequency": "Hz"})


def test_a_limit_is_drawn_at_the_lower_end_of_its_interval_and_not_where_it_is_unbounded():
    axes = blank()
    driven_limits(envelope(), axes)
    np.testing.assert_allclose(data_of(line(axes, "rest is lost, driven")), [[1.0, 2.0], [2.0, 1.0]])
    unknown = line(axes, "dielectric breakdown: unknown,\nno strength given")
    assert data_of(unknown).size == 0
    assert unknown.get_color() != line(axes, "rest is lost, driven").get_color()
    assert axes.get_ylim() == pytest.approx((0.0, 4.2))


def test_limits_of_a_held_voltage_say_for_how_long():
    axes = blank()
    driven_limits(envelope().assign(holding_time=((), 90.0, {"units": "s", "quantity": "time"})), axes)
    assert data_of(line(axes, "pitchfork, held for 90 s")).max() == 1.5


def test_a_line_parts_where_a_limit_jumps():
    x, y = broken_at_jumps(OMEGA, np.array([2.1, 2.2, 3.0]))
    np.testing.assert_array_equal(x, [1.0, 2.0, 4.0, 4.0])
    np.testing.assert_array_equal(y, [2.1, 2.2, np.nan, 3.0])
    x, y = broken_at_jumps(OMEGA, np.array([3.0, 2.2, 2.1]))  # falling, too
    np.testing.assert_array_equal(x, [1.0, 2.0, 2.0, 4.0])
    np.testing.assert_array_equal(y, [3.0, np.nan, 2.2, 2.1])


def test_where_another_motion_coexists_a_ring_says_how_small_a_kick_leads_there():
    axes = blank()
    driven_limits(envelope(), axes)
    ring = line(axes, "a kick from 0.7 on\nleads to another motion")
    np.testing.assert_array_equal(data_of(ring), [[2.0], [0.8]])
    alone = blank()
    pulled_in = blank()
    driven_limits(envelope(motion_outcome=[[np.nan], [float(Outcome.PULLED_IN)], [np.nan]]), pulled_in)
    line(pulled_in, "a kick from 0.7 on\nleads to pull-in")
    mixed = blank()
    both = {"coexisting_motions": [0, 1, 1], "kick_high": [np.inf, 0.7, 0.5], "motion_regime": [[np.nan], [1.0], [1.0]]}
    ends = [[np.nan], [float(Outcome.PULLED_IN)], [0.0]]
    driven_limits(envelope(motion_outcome=ends, **both), mixed)
    np.testing.assert_array_equal(
        data_of(line(mixed, "a kick from 0.5 on\nleads to another motion")), [[2.0, 4.0], [0.8, 1.2]]
    )
    driven_limits(envelope(coexisting_motions=[0, 0, np.nan]), alone)
    assert not [one for one in alone.lines if "kick" in str(one.get_label())]


def test_a_limit_that_is_never_met_is_not_drawn():
    axes = blank()
    driven_limits(envelope(limit_low=[[4.0] * 3, [4.0] * 3], limit_high=np.full((2, 3), np.inf)), axes)
    assert not [one for one in axes.lines if "driven" in one.get_label() or "breakdown" in one.get_label()]


def test_only_breakdown_without_a_strength_is_called_unknown():
    axes = blank()
    driven_limits(envelope(limit_low=np.full((2, 3), np.nan), limit_high=np.full((2, 3), np.nan)), axes)
    assert [one.get_label() for one in axes.lines if "unknown" in one.get_label()] == [
        "dielectric breakdown: unknown,\nno strength given"
    ]


def test_the_window_reaches_from_zero_to_the_recommended_peak():
    axes = blank()
    driven_limits(envelope(), axes)
    (band,) = axes.collections
    x, y = band.get_paths()[0].vertices.T
    for frequency, peak in zip(OMEGA, WINDOW, strict=True):
        assert set(y[x == frequency]) == {0.0, peak}
    assert colour(band) == colour(blank().plot([], [], color=GREEN)[0])
    gap = blank()
    driven_limits(envelope(recommended_peak=np.array([1.0, 0.0, 1.2])), gap)
    assert all(2.0 not in path.vertices[:, 0] for path in gap.collections[0].get_paths())
    none = blank()
    driven_limits(envelope(recommended_peak=np.zeros(3)), none)
    assert not none.collections


def test_quasi_static_limits_within_the_picture_are_level_lines():
    axes = blank()
    driven_limits(envelope(), axes)
    assert line(axes, "pitchfork, quasi-static").get_ydata() == [1.5, 1.5]
    assert line(axes, "pull-in, quasi-static").get_ydata() == [4.1, 4.1]
    assert line(axes, "pull-in, quasi-static").get_linestyle() == "--"
    assert not [one for one in axes.lines if one.get_label().startswith(("stretch limit", "never"))]


def test_of_films_in_opposite_phase_axes_and_levels_are_of_the_drive_held_at_its_peak():
    scaled, axes, below = envelope().assign(recommended_second_voltage=1.0), blank(), blank()
    driven_limits(scaled, axes)
    natural_frequency(scaled, below)
    assert line(axes, "pitchfork, drive held at its peak").get_ydata() == [1.5, 1.5]
    assert axes.get_ylabel() == "peak voltage, bias and amplitude in proportion"
    assert below.get_xlabel() == "peak held, bias in proportion"
    plain, under = blank(), blank()
    driven_limits(envelope(), plain)
    natural_frequency(envelope(), under)
    assert (plain.get_ylabel(), under.get_xlabel()) == ("peak voltage", "constant voltage")


@pytest.mark.parametrize(("own", "there"), [(1.0, True), (2.0, True), (4.0, True), (0.9, False), (4.1, False)])
def test_the_own_drive_is_a_star_where_it_lies_in_the_picture(own, there):
    axes = blank()
    driven_limits(envelope(operating_frequency=own), axes)
    stars = [one for one in axes.lines if one.get_marker() == "*"]
    assert len(stars) == there
    if there:
        np.testing.assert_array_equal(data_of(stars[0]), [[own], [0.6]])


def test_static_curves_stand_over_the_constant_voltage_and_the_window_is_shaded():
    axes = blank()
    static_curves(envelope(), axes)
    (_, other) = axes.figure.axes
    np.testing.assert_array_equal(data_of(axes.lines[0]), [VOLTS, [0.0, 0.1, 0.4, 0.9]])
    np.testing.assert_array_equal(data_of(other.lines[0]), [VOLTS, [0.0, -1.0, -2.0, -3.0]])
    assert (axes.lines[0].get_color(), other.lines[0].get_color()) == (BLUE, VERMILION)
    assert (axes.lines[0].get_linestyle(), other.lines[0].get_linestyle()) == ("-", "--")
    assert (axes.get_ylabel(), other.get_ylabel()) == ("static stroke", "blocked force")
    (span,) = axes.patches
    assert (span.get_x(), span.get_width()) == pytest.approx((0.0, 1.2))
    assert axes.get_xlim() == (0.0, 3.0)
    assert axes.get_ylim()[0] == 0.0
    assert other.get_ylim()[0] < -3.0
    assert not axes.texts


def test_a_curve_of_rounding_is_a_line_at_zero():
    axes, data = blank(), envelope(stroke=[0.0, 1e-12, -1e-12, np.nan])
    static_curves(data, axes)
    assert axes.get_ylim() == (0.0, 1.0)
    assert axes.get_yticks().tolist() == [0.0]
    assert [text.get_text() for text in axes.texts] == ["the film stays flat"]


def test_curves_that_go_below_zero_are_shown_whole():
    axes = blank()
    falling = result({"y": ("x", [1.0, -2.0])}, units={"y": "mm"})["y"]
    twin_curves(axes, np.array([0.0, 1.0]), falling, "one", falling, "other")
    assert axes.get_ylim()[0] < -2.0
    assert axes.get_ylabel() == "one (mm)"
    assert axes.figure.axes[1].spines["right"].get_visible()


def test_the_natural_frequency_stands_over_the_constant_voltage():
    axes = blank()
    natural_frequency(envelope(), axes)
    np.testing.assert_array_equal(data_of(axes.lines[0]), [VOLTS, [1.0, 0.9, 0.7, 0.2]])
    assert axes.get_ylim()[0] == 0.0
    assert axes.get_xlim() == (0.0, 3.0)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, []),
        ({"recommended_peak": np.zeros(3)}, ["no window"]),
        ({"window_regime": [int(Regime.REST)] * 3}, ["the film stays at rest"]),
        ({"window_regime": [int(Regime.REST), int(Regime.PERIODIC), int(Regime.REST)]}, []),
    ],
)
def test_what_the_window_yields_or_why_nothing(changed, said):
    axes = blank()
    window_yield(envelope(**changed), axes)
    np.testing.assert_array_equal(data_of(axes.lines[0]), [OMEGA, [0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(data_of(axes.figure.axes[1].lines[0]), [OMEGA, [1.0, 2.0, 3.0]])
    assert [text.get_text() for text in axes.texts] == said


def test_frequencies_are_on_a_log_scale_from_the_first_to_the_last():
    axes = blank()
    frequency_axis(envelope(), axes)
    assert (axes.get_xscale(), axes.get_xlim()) == ("log", (1.0, 4.0))
    assert axes.get_xlabel() == "drive frequency (Hz)"


def test_the_figure_has_limits_beside_three_small_panels():
    figure = envelope_figure(envelope())
    limits, static, force, natural, window, power = figure.axes
    del force, power
    assert limits.get_position().x0 < static.get_position().x0
    assert static.get_position().y0 > natural.get_position().y0 > window.get_position().y0
    assert "recommended window" in texts(figure)
    assert static.get_shared_x_axes().joined(static, natural)
    assert limits.get_shared_x_axes().joined(limits, window)
    assert corners(limits.collections[0])[0] == pytest.approx([1.0, 4.0, 0.0, 1.2])


@pytest.mark.parametrize("of", ["membrane", "cone"])
def test_pull_in_says_whose_it_is(of):
    from gelcone.plots.envelope import limit_label

    result = xr.Dataset(attrs={"pull_in_of": of})
    assert limit_label(result, "pull-in") == f"pull-in of the {of}"
    assert limit_label(result, "chaos") == "chaos"
    assert limit_label(xr.Dataset(), "pull-in") == "pull-in"
