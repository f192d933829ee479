"""Constant commands: films in opposite phase have 2 v0 - v, as in statics."""

import numpy as np
import pytest

from gelcone.motion.constant_voltage import at_constant_voltages
from gelcone.physics.model import ConeModel

DRIVE = {"voltage": 0.2, "voltage_bias": 0.4, "second_flat_height": 1.2, "second_film": "taut"}
LEVELS = np.array([0.0, 0.1, 0.4, 0.9])


@pytest.mark.parametrize(
    ("drive", "second"), [("same", LEVELS), ("opposite", 0.8 - LEVELS), ("constant", np.full(4, 0.3))]
)
@pytest.mark.parametrize("waveform", ["sine", "square"])
def test_each_film_has_the_voltage_that_statics_take(drive, second, waveform):
    own = {"second_voltage": 0.3} if drive == "constant" else {}
    model = ConeModel(**DRIVE, waveform=waveform, second_drive=drive, **own)
    members = at_constant_voltages(model, LEVELS).members()
    at_rest = [np.sqrt(squared) for squared in model.system.squares_at_rest(LEVELS**2, model.numbers())]
    for tau in (0.0, 0.7, 31.0):
        found = members.system.voltages(tau, [np.full(4, 0.3), np.zeros(4)], members.numbers())
        for voltage, wanted, static in zip(found, (LEVELS, second), at_rest, strict=True):
            np.testing.assert_allclose(voltage + 0.0 * LEVELS, wanted, atol=1e-15)
            np.testing.assert_allclose(np.abs(voltage) + 0.0 * LEVELS, static + 0.0 * LEVELS, atol=1e-15)
