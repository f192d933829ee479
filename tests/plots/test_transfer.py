"""The Bode plot: gains and phases where they belong, phases without turns."""

import numpy as np
import pytest

from gelcone.plots.transfer import transfer_figure
from tests.plots.made_up import data_of, line, result

OMEGA, AT = [1.0, 2.0, 4.0], [1.5, 3.0]
UNITS = {"gain": "mm/kV", "admittance": "uA/kV", "phase": "degrees", "admittance_phase": "degrees"}


def bode(amplitudes=(20.0,), **changed):
    """A transfer function with what was measured at one amplitude."""
    measured = {f"measured_{name}": unit for name, unit in UNITS.items()}
    return result(
        {
            "gain": ("drive_frequency", [3.0, 5.0, 1.0]),
            "phase": ("drive_frequency", [-20.0, -170.0, 160.0]),
            "admittance": ("drive_frequency", [0.3, 0.5, 0.1]),
            "admittance_phase": ("drive_frequency", [80.0, 85.0, 89.0]),
            "measured_gain": (("amplitude", "measured_frequency"), [[4.0, 2.0]]),
            "measured_phase": (("amplitude", "measured_frequency"), [[-30.0, -175.0]]),
            "measured_admittance": (("amplitude", "measured_frequency"), [[0.4, 0.2]]),
            "measured_admittance_phase": (("amplitude", "measured_frequency"), [[81.0, 86.0]]),
            "natural_frequency": ((), 2.5),
            **changed,
        },
        {
            "drive_frequency": ("drive_frequency", OMEGA),
            "measured_frequency": ("measured_frequency", AT),
            "amplitude": ("amplitude", amplitudes),
        },
        UNITS | measured | {"drive_frequency": "Hz", "amplitude": "V"},
    )


def test_each_quantity_stands_in_its_panel_with_its_unit():
    panels = transfer_figure(bode()).axes
    right = [[3.0, 5.0, 1.0], [0.3, 0.5, 0.1], [-20.0, -170.0, -200.0], [80.0, 85.0, 89.0]]
    dots = [[4.0, 2.0], [0.4, 0.2], [-30.0, -175.0], [81.0, 86.0]]
    words = ["displacement over voltage (mm/kV)", "current over voltage (uA/kV)", "phase (degrees)", "phase (degrees)"]
    for axes, linear, real, label in zip(panels, right, dots, words, strict=True):
        np.testing.assert_allclose(data_of(line(axes, "linear theory")), [OMEGA, linear])
        np.testing.assert_allclose(data_of(line(axes, "simulated, 20 V")), [AT, real])
        assert axes.get_ylabel() == label
        (dashed,) = (one for one in axes.lines if one.get_linestyle() == "--")
        assert dashed.get_xdata()[0] == 2.5
    assert [axes.get_xlabel() for axes in panels] == ["", "", "drive frequency (Hz)", "drive frequency (Hz)"]


def test_each_amplitude_has_its_own_dots_and_name():
    each = {f"measured_{name}": (("amplitude", "measured_frequency"), [[1.0, 2.0], [3.0, 4.0]]) for name in UNITS}
    for axes in transfer_figure(bode([20.0, 200.0], **each)).axes:
        drawn = [line(axes, f"simulated, {level} V") for level in (20, 200)]
        np.testing.assert_allclose([data_of(one)[1] for one in drawn], [[1.0, 2.0], [3.0, 4.0]])
        assert len({one.get_color() for one in drawn}) == len({one.get_marker() for one in drawn}) == 2


def test_gains_of_several_decades_are_drawn_on_a_log_scale_over_the_frequencies_asked_for():
    figure = transfer_figure(bode())
    assert [axes.get_yscale() for axes in figure.axes] == ["log", "log", "linear", "linear"]
    assert {axes.get_xscale() for axes in figure.axes} == {"log"}
    assert {axes.get_xlim() for axes in figure.axes} == {(1.0, 4.0)}
    still = transfer_figure(bode(admittance=("drive_frequency", [0.0, 0.0, 0.0])))
    assert [axes.get_yscale() for axes in still.axes[:2]] == ["log", "linear"]


@pytest.mark.parametrize("at", [0, 1, 2])
def test_a_phase_that_is_not_known_leaves_the_others(at):
    values = np.array([-20.0, -170.0, 150.0])
    values[at] = np.nan
    drawn = transfer_figure(bode(phase=("drive_frequency", values))).axes[2].lines[0].get_ydata()
    right = np.array([-20.0, -170.0, -210.0] if at != 1 else [-20.0, np.nan, 150.0])
    right[at] = np.nan
    np.testing.assert_allclose(drawn, right)
