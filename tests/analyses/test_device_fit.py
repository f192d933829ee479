"""The text of a fitted device: deviations with their sign, what lies far from its prior, and what is refused."""

import numpy as np

from gelcone.analyses.device_fit import _left_out_lines, _unknown_lines
from gelcone.devices.device import find_device
from tests.plots.made_up import result


def fit():
    return result(
        {
            "prior": ("unknown", [0.1, 0.02]),
            "left": ("unknown", [0.01, 0.01]),
            "deviation": ("unknown", [np.log(1.15), np.log(0.95)]),
            "value": ("field", [17.25]),
            "left_out_chi2": ("test", [9.5, 40.0]),
            "left_out_points": ("test", [10, 12]),
            "left_out_p_value": ("test", [0.6, 0.001]),
        },
        {
            "unknown": ("unknown", ["spring_rate", "gain of the laser"]),
            "field": ("field", ["spring_rate"]),
            "test": ("test", ["stroke", "force"]),
        },
    )


def test_deviations_have_their_sign_and_are_measured_by_the_prior():
    _, spring, laser = _unknown_lines(fit(), find_device("biased-pump"))
    assert spring.split() == ["spring_rate", "17.25", "N/m", "+15.0", "%", "1", "%", "10", "%", "0.10"]
    assert laser.split()[4:10] == ["-5.0", "%", "1", "%", "2", "%"]
    assert laser.endswith("more than 2 standard deviations from its prior")


def test_a_test_that_the_others_contradict_is_refused():
    _, stroke, force = _left_out_lines(fit())
    assert stroke.endswith("chi2 9.5 of 10, p = 0.6")
    assert force.endswith("chi2 40 of 12, p = 0.001: refused")
