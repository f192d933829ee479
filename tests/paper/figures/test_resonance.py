"""Figure 12 on made-up sweeps: amplitudes, highest points and the natural frequency stand at their values."""

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from gelcone.paper.figures.resonance import _branches, amplitude_over_frequency, colours, peaks, three_responses
from tests.plots.made_up import data_of, line

KAPPA = np.array([0.1, 1.0])
OMEGA = np.array([[0.2, 0.4, 0.8], [0.3, 0.6, 1.2]])
UP = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def sweeps():
    each = ("spring_stiffness", "sweep")
    return xr.Dataset(
        {
            "amplitude": ((*each, "step"), np.stack([UP, UP + 10.0], axis=1)),
            "peak_frequency": (each, [[0.5, 0.45], [1.0, 0.9]]),
            "peak_amplitude": (each, [[3.5, 3.4], [6.5, 6.4]]),
            "natural_frequency": ("spring_stiffness", [0.8, 1.6]),
            "swept_frequency": (("spring_stiffness", "step"), OMEGA),
        },
        coords={"spring_stiffness": KAPPA, "sweep": ["up", "down"]},
    )


def test_sweeps_up_are_solid_in_their_colour_and_sweeps_down_dashed_on_top():
    axes = Figure().add_subplot()
    amplitude_over_frequency(sweeps(), axes)
    for k in range(2):
        up, down, highest = axes.lines[3 * k : 3 * k + 3]
        np.testing.assert_array_equal(data_of(up), [OMEGA[k], UP[k]])
        np.testing.assert_array_equal(data_of(down), [OMEGA[k], UP[k] + 10.0])
        np.testing.assert_array_equal(data_of(highest), [sweeps()["peak_frequency"][k], sweeps()["peak_amplitude"][k]])
        assert to_rgb(up.get_color()) == to_rgb(colours(sweeps())[k])
        assert (up.get_linestyle(), down.get_linestyle()) == ("-", "--")
        assert (highest.get_marker(), highest.get_linestyle()) == ("o", "None")
    assert [text.get_text() for text in axes.texts] == [r"$\kappa$ = 0.1", r"$\kappa$ = 1"]
    assert [text.xy for text in axes.texts] == [(0.2, 1.0), (0.3, 4.0)]
    assert (axes.get_xscale(), axes.get_yscale(), axes.get_xlim()[0]) == ("log", "log", 0.1)
    assert line(axes, "swept up").get_linestyle() == "-"


def test_unstable_orbits_reach_to_their_stable_neighbours_and_no_further():
    """The line between two jumps meets the sweeps at both ends, and does not run on along what a sweep shows."""
    amplitude = np.arange(1.0, 8.0)
    study = sweeps().assign(
        branch_frequency=("at", 0.1 * amplitude),
        branch_amplitude=("at", amplitude),
        branch_stable=("at", [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
    )
    axes = Figure().add_subplot()
    _branches(study, axes)
    np.testing.assert_allclose(data_of(axes.lines[0]), [[0.2, 0.3, 0.4, 0.5], [2.0, 3.0, 4.0, 5.0]])
    assert axes.lines[0].get_linestyle() == "--"


def test_highest_points_stand_over_the_stiffness_with_half_the_natural_frequency():
    frequency, height = Figure().subplots(2, 1)
    peaks(sweeps(), frequency, height)
    for axes, name in ((frequency, "peak_frequency"), (height, "peak_amplitude")):
        up, down = axes.collections
        np.testing.assert_array_equal(data_of(up), [KAPPA, sweeps()[name].sel(sweep="up")])
        np.testing.assert_array_equal(data_of(down), [KAPPA, sweeps()[name].sel(sweep="down")])
        assert (len(up.get_facecolor()), len(down.get_facecolor())) == (2, 0)
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    np.testing.assert_array_equal(data_of(line(frequency, "half the natural\nfrequency")), [KAPPA, [0.4, 0.8]])
    assert not height.lines


def test_softer_springs_are_darker():
    soft, stiff = colours(sweeps())
    assert sum(soft[:3]) < sum(stiff[:3])


def test_responses_show_the_first_hundred_of_the_window_above_and_of_the_long_run_below():
    time = np.linspace(0.0, 250.0, 251)
    each, late = ("drive_frequency", "time"), ("drive_frequency", "late_time")
    study = xr.Dataset(
        {
            "displacement": (each, np.stack([time, 2.0 * time])), "slack": (each, np.zeros((2, 251), dtype=int)),
            "late_displacement": (late, np.stack([3.0 * time, 4.0 * time])),
            "late_slack": (late, np.zeros((2, 251), dtype=int)), "regime": ("drive_frequency", [1, 1]),
            **{f"{name}_validity_slack": ("drive_frequency", [0.25, 0.5]) for name in ("window", "late")},
            **{f"{name}_{end}": ("drive_frequency", [sign, sign]) for name in ("window", "late")
               for end, sign in (("lowest", -1.0), ("highest", 1.0))},
        },
        coords={"drive_frequency": [0.7, 1.5], "time": time, "late_time": time}, attrs={"parameter": "drive_frequency"},
    )  # fmt: skip
    figure = Figure()
    three_responses(study, figure)
    top, other, bottom, _ = figure.axes
    for axes, factor in ((top, 1.0), (other, 2.0), (bottom, 3.0)):
        x, y = data_of(axes.lines[0])
        assert (min(x), max(x)) == (0.0, 100.0)
        np.testing.assert_array_equal(y, factor * np.asarray(x))
    assert top.get_title(loc="left").endswith("= 0.7")
    assert other.get_title(loc="left").endswith("= 1.5")
    assert bottom.get_xlabel() == "time after the transient"
