"""The Bode plot: gains and phases where they belong, phases without turns."""

import numpy as np

from gelcone.plots.transfer import transfer_figure
from tests.plots.made_up import data_of, line, result

OMEGA, AT = [1.0, 2.0, 4.0], [1.5, 3.0]
UNITS = {"gain": "mm/kV", "admittance": "uA/kV", "phase": "degrees", "admittance_phase": "degrees"}


def test_each_quantity_stands_in_its_panel_with_its_unit():
    measured = {f"measured_{name}": unit for name, unit in UNITS.items()}
    transfer = result(
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
        },
        {
            "drive_frequency": ("drive_frequency", OMEGA),
            "measured_frequency": ("measured_frequency", AT),
            "amplitude": ("amplitude", [20.0]),
        },
        UNITS | measured | {"drive_frequency": "Hz", "amplitude": "V"},
    )
    panels = transfer_figure(transfer).axes
    right = [[3.0, 5.0, 1.0], [0.3, 0.5, 0.1], [-20.0, -170.0, -200.0], [80.0, 85.0, 89.0]]
    dots = [[4.0, 2.0], [0.4, 0.2], [-30.0, -175.0], [81.0, 86.0]]
    words = ["displacement over voltage (mm/kV)", "current over voltage (uA/kV)", "phase (degrees)", "phase (degrees)"]
    for axes, linear, real, label in zip(panels, right, dots, words, strict=True):
        np.testing.assert_allclose(data_of(line(axes, "linear theory")), [OMEGA, linear])
        np.testing.assert_allclose(data_of(line(axes, "simulated, 20 V")), [AT, real])
        assert axes.get_ylabel() == label
        (dashed,) = (one for one in axes.lines if one.get_linestyle() == "--")
        assert dashed.get_xdata()[0] == 2.5
    assert panels[2].get_xlabel() == "drive frequency (Hz)"
