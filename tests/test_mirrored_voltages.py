"""All voltages with the other sign are the same actuator, for the forces depend on squares alone."""

import numpy as np
import pytest

import gelcone
from gelcone.motion.natural import natural_frequency
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import Harmonics

TAUT = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "spring_stiffness": 1.5}
PAIR = {**TAUT, "second_film": "taut", "second_flat_height": 1.4}
OPPOSITE = {**PAIR, "second_drive": "opposite"}
CONES = {
    "single": TAUT,
    "same": PAIR,
    "constant": {**PAIR, "second_drive": "constant", "second_voltage": 0.5},
    "opposite": OPPOSITE,
    "opposite, resistance": {**OPPOSITE, "series_resistance": 0.5},
    "opposite, leak": {**OPPOSITE, "series_resistance": 3.0, "leakage_time": 12.0},
}
FILM = {"viscous_modulus_1": 0.4, "relaxation_time_1": 3.0}
ANALYSES = {
    "static": lambda model: gelcone.static(model, [0.2, 0.4, 0.9]),
    "stroke": lambda model: gelcone.stroke_and_blocked_force(model, [0.2, 0.9]),
    "limits": gelcone.limits,
    "natural frequency": lambda model: natural_frequency(model, [0.2, 0.9]),
    "state space": lambda model: [gelcone.state_space(model, voltage=v).A for v in (0.3, 0.4)],
    "step": lambda model: gelcone.step(model, [0.4, 0.9], before=0.3),
    "creep": lambda model: gelcone.creep(model.replace(**FILM), [0.4], duration=5.0, tolerance=1e-8),
    "transfer": lambda model: gelcone.transfer(model, [1.0, 1.5], amplitudes=[0.05]),
    "transfer about a voltage": lambda model: gelcone.transfer(model, [1.0], bias=0.5, amplitudes=[0.05]),
    "settled": gelcone.settled,
    "operating limits": gelcone.operating_limits,
    "envelope": lambda model: gelcone.envelope(model, frequencies=[1.0, 1.2], peaks=[0.4, 0.8], limits_from="settled"),
    "data sheet": lambda model: gelcone.datasheet(model, [0.4, 0.6]),
}
TURNED = ("phase", "bias_voltage", "current")
"""Parts of the names of what has the other sign."""
LONG = {
    "creep": ("opposite",), "settled": ("constant", "opposite, resistance"), "envelope": ("opposite",),
    "transfer": ("single", "constant", "opposite, leak"), "operating limits": ("single",), "data sheet": ("opposite",),
}  # fmt: skip
"""Analyses that take longest, with the cones that show by themselves what they may get wrong."""
CASES = [
    pytest.param(cone, analysis, marks=[] if cone in LONG.get(analysis, CONES) else pytest.mark.slow)
    for cone in CONES
    for analysis in ANALYSES
    if (cone == "opposite" or analysis != "data sheet")
    and (cone != "opposite, leak" or analysis in ("stroke", "state space", "step", "transfer"))
]
"""All pairs, but for those that find nothing that others do not."""


def both(cone, bias=0.4):
    """A cone, and the one with all voltages of the other sign."""
    drive = {"voltage": 0.1, "voltage_bias": bias, "drive_frequency": 1.3}
    other = {name: -value for name, value in cone.items() if name == "second_voltage"} | {"voltage_bias": -bias}
    turned = Harmonics(((1, -1.0, 0.0),))
    return (
        ConeModel(**cone, **drive, waveform=Harmonics(((1, 1.0, 0.0),))),
        ConeModel(**{**cone, **drive, **other}, waveform=turned),
    )


def numbers(found):
    """The numbers of a result by name, without those that are turned."""
    if not hasattr(found, "data_vars"):
        return {"": np.asarray(found)}
    names = (name for name in found.data_vars if not any(part in name for part in TURNED))
    return {name: found[name].values for name in names if found[name].dtype.kind in "fiub"}


@pytest.mark.parametrize(("cone", "analysis"), CASES)
def test_the_other_sign_of_all_voltages_changes_nothing(cone, analysis):
    here, there = (numbers(ANALYSES[analysis](model)) for model in both(CONES[cone]))
    assert here.keys() == there.keys()
    for name, values in here.items():
        np.testing.assert_allclose(there[name], values, rtol=1e-11, atol=1e-12, err_msg=name)
