"""Lists of tests whose files hold more than the tests use, and readings that say too little to judge their sign."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.lab.bench import DeviceTest
from gelcone.lab.device import _check_signs
from gelcone.lab.device_tests import read_device_tests

RINGING = '[[test]]\nkind = "ring-down"\nfile = "ringing.csv"\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\n'


def test_a_reading_that_is_not_in_the_file_is_planned_where_another_is(tmp_path):
    (tmp_path / "tests.toml").write_text(RINGING, encoding="utf-8")
    (tmp_path / "ringing.csv").write_text("frequency (Hz),humidity\n9.1,40\n9.2,41\n", encoding="utf-8")
    (test,) = read_device_tests(tmp_path / "tests.toml").tests
    assert test.read["frequency"].tolist() == [9.1, 9.2]
    assert np.isnan(test.read["decay"]).all()
    (tmp_path / "ringing.csv").write_text("Ton (Hz),humidity\n9.1,40\n9.2,41\n", encoding="utf-8")
    with pytest.raises(InputError, match="which column of ringing"):
        read_device_tests(tmp_path / "tests.toml")


def judged(read, predicted, noise):
    one = DeviceTest("stroke", "stroke over voltage", {}, {"stroke": np.array(read)}, {"stroke": np.array(noise)})
    rows = np.array([predicted])
    _check_signs(SimpleNamespace(tests=[one], priors=np.ones(2), predict=lambda logs: rows))


def test_signs_are_judged_only_where_readings_stand_out_of_the_noise():
    judged([-1.0], [2.0], [1.0])
    judged([-20.0], [2.0], [1.0])
    judged([-100.0, 20.0], [100.0, 20.0], [50.0, 1.0])
    for read, noise in (([-20.0], [1.0]), ([-20.0, -30.0], [1.0, 1.0])):
        with pytest.raises(InputError, match="stroke has the opposite sign of the device's"):
            judged(read, np.negative(read), noise)


@pytest.mark.parametrize(
    ("volts", "message"), [("0,0.8,1.5", "2 of 2 voltages are below"), ("0,8,1500", "has no unit")]
)
def test_voltages_without_a_unit_are_taken_for_kilovolts_where_all_are_small(tmp_path, volts, message):
    text = '[[test]]\nkind = "stroke over voltage"\nfile = "a.csv"\nnoise = {stroke = "0.01 mm"}\n'
    (tmp_path / "tests.toml").write_text(text, encoding="utf-8")
    rows = "".join(f"{one},{k}\n" for k, one in enumerate(volts.split(",")))
    (tmp_path / "a.csv").write_text(f"voltage,stroke (mm)\n{rows}", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_device_tests(tmp_path / "tests.toml")
