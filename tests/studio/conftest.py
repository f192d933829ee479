"""Subjects whose panels are compared with the results of their analyses."""

import pytest

from gelcone.studio.setting import Setting

SUBJECTS = {
    "device": Setting(device="biased-pump"),
    "preset": Setting(preset="base", values={"voltage": "0.8"}),
    "offset": Setting(preset="base", values={"voltage": "0.3", "voltage_bias": "0.5", "drive_frequency": "1.3"}),
}


@pytest.fixture(params=SUBJECTS)
def subject(request, shelf):
    return shelf.subject(SUBJECTS[request.param])
