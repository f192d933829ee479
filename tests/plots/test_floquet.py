"""The figure of instability tongues: its border, its growth rate, where the period doubles."""

import numpy as np
import pytest

from gelcone.plots.floquet import growth_map, onset_lines, tongues_figure
from tests.plots.made_up import blank, data_of, line, result, texts

OMEGA, VOLTAGE = np.linspace(1.0, 3.0, 21), np.linspace(0.0, 2.0, 31)


def border(omega):
    return 0.5 + 0.25 * omega


def tongues(stable=False, **units):
    """Rest is lost above a straight border; what grows there has twice the period below the frequency 2."""
    margin = np.tanh(VOLTAGE[None, :] - border(OMEGA)[:, None])
    margin = margin - 2.0 if stable else margin
    growth = np.where(margin > 0.0, 0.3 * margin, -0.1)
    doubles = np.broadcast_to(OMEGA[:, None] < 2.0, margin.shape)
    each = ("drive_frequency", "voltage")
    return result(
        {
            "growth_rate": (each, growth),
            "margin": (each, margin),
            "doubles": (each, doubles),
            "onset_voltage": ("drive_frequency", border(OMEGA)),
            "pitchfork_amplitude": ((), 1.6),
        },
        {"drive_frequency": ("drive_frequency", OMEGA), "voltage": ("voltage", VOLTAGE)},
        units,
    )


def vertices(contours, level):
    return np.concatenate([part.vertices for part in [contours.get_paths()[level]]])


def test_the_growth_rate_is_drawn_as_it_is_from_zero_to_its_largest():
    axes, data = blank(), tongues()
    filled = growth_map(data, axes)
    growth = data["growth_rate"].values
    assert filled.zmax == pytest.approx(growth.max())
    assert filled.zmin == pytest.approx(growth.min())
    assert filled.levels[0] == 0.0
    assert filled.levels[-1] >= growth.max() > filled.levels[-2]
    assert 6 <= len(filled.levels) <= 11
    assert (axes.get_xlim(), axes.get_ylim()) == ((1.0, 3.0), (0.0, 2.0))


def test_frequency_is_along_x_and_voltage_along_y():
    axes = blank()
    onset_lines(tongues(), axes)
    (edge,) = axes.collections
    x, y = np.concatenate([path.vertices for path in edge.get_paths()]).T
    np.testing.assert_allclose(y, border(x), atol=1e-3)
    assert x.min() == pytest.approx(1.0)
    assert x.max() == pytest.approx(3.0)


def test_white_lies_where_rest_is_stable_and_hatching_where_the_period_doubles():
    axes = blank()
    growth_map(tongues(), axes)
    white, hatched = axes.collections[1], axes.collections[2]
    x, y = np.concatenate([path.vertices for path in white.get_paths()]).T
    assert (y <= border(x) + 1e-2).all()
    assert y.min() == 0.0
    np.testing.assert_allclose(white.get_facecolor()[0], [1.0, 1.0, 1.0, 1.0])
    x, y = np.concatenate([path.vertices for path in hatched.get_paths()]).T
    assert (y >= border(x) - 1e-2).all()
    assert x.max() < 2.0
    assert hatched.hatches == ["///"]
    assert "grows with period 2" in [c.get_label() for c in axes.collections]


def test_where_nothing_doubles_nothing_is_hatched():
    axes, data = blank(), tongues()
    data["doubles"][:] = False
    growth_map(data, axes)
    assert len(axes.collections) == 2


def test_the_onset_and_the_static_pitchfork():
    axes, data = blank(), tongues()
    data["onset_voltage"][10:] += 0.5
    onset_lines(data, axes)
    onset = line(axes, "onset")
    np.testing.assert_allclose(data_of(onset), [OMEGA, data["onset_voltage"].values])
    # a jump from one tongue to the next is a gap of the line
    gaps = np.flatnonzero(np.isnan(onset.get_ydata()))
    assert gaps.tolist() == [10]
    pitchfork = line(axes, "static pitchfork at the peak")
    np.testing.assert_array_equal(pitchfork.get_ydata(), [1.6, 1.6])
    assert pitchfork.get_linestyle() == "--"
    none = blank()
    onset_lines(data.assign(pitchfork_amplitude=np.nan), none)
    assert len(none.lines) == 1


@pytest.mark.parametrize(("step", "gaps"), [(0.11, 0), (0.13, 1)])
def test_a_jump_is_six_percent_of_the_voltages(step, gaps):
    axes, data = blank(), tongues()
    data["onset_voltage"][:] = np.where(OMEGA < 1.95, 1.0, 1.0 + step)
    onset_lines(data, axes)
    assert np.isnan(line(axes, "onset").get_ydata()).sum() == gaps


def test_a_figure_of_a_device_that_stays_at_rest_says_so():
    figure = tongues_figure(tongues(stable=True, drive_frequency="Hz", voltage="V"))
    assert "rest is stable everywhere" in texts(figure)
    assert len(figure.axes) == 1
    assert figure.axes[0].get_xlabel() == "drive frequency (Hz)"
    assert figure.axes[0].get_ylabel() == "voltage amplitude (V)"
    assert "growth rate of deviations\nfrom rest (per unit time)" in texts(tongues_figure(tongues()))
