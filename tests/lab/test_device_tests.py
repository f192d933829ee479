"""Lists of tests whose files hold more than the tests use, and readings that say too little to judge their sign."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.lab.bench import KINDS, DeviceTest
from gelcone.lab.device import _check_signs
from gelcone.lab.device_tests import _assembled, _noise, _parsed, read_device_tests

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
        with pytest.raises(InputError, match="stroke has the opposite sign of the device's") as error:
            judged(read, np.negative(read), noise)
        assert str(error.value).endswith(': write a minus before its column, stroke = "-Stroke, ..."')


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


@pytest.fixture
def read(tmp_path):
    def of(text, **files):
        for name, content in files.items():
            (tmp_path / f"{name}.csv").write_text(content, encoding="utf-8")
        (tmp_path / "tests.toml").write_text(text, encoding="utf-8")
        return read_device_tests(tmp_path / "tests.toml")

    return of


STROKE = '[[test]]\nkind = "stroke over voltage"\nvoltage = ["1 kV", "500 V"]\nnoise = "10 um"\n'


def test_gains_are_those_of_the_list_or_usual_ones(read):
    plain = {"load cell": 0.02, "laser": 0.01, "capacitance meter": 0.01, "ammeter": 0.01, "amplifier": 0.01}
    assert read(STROKE).gains == plain
    own = read(STROKE + '[instruments]\ncapacitance_meter = "3 %"\nlaser = 0.05\n').gains
    assert own == plain | {"capacitance meter": pytest.approx(0.03), "laser": 0.05}
    with pytest.raises(InputError, match="did you mean 'laser'"):
        read(STROKE + "[instruments]\nlasr = 0.05\n")
    for wrong in ("0", '"1000 %"', '"-1 %"', '"a"'):
        with pytest.raises(InputError, match="a share such as"):
            read(STROKE + f"[instruments]\nlaser = {wrong}\n")
    assert read(STROKE + '[instruments]\nlaser = "999 %"\n').gains["laser"] == pytest.approx(9.99)


def test_an_amplitude_and_a_phase_are_an_in_phase_and_a_quadrature_part(read):
    text = (
        '[[test]]\nkind = "frequency response"\nvoltage_offset = "1 kV"\nvoltage_amplitude = "60 V"\n'
        'frequency = ["6 Hz", "9 Hz"]\namplitude = ["2 mm", "1 mm"]\nphase = ["60 deg", "-90 deg"]\nnoise = "10 um"\n'
    )
    found = read(text)
    (test,) = found.tests
    np.testing.assert_allclose(test.read["in_phase"], [1e-3, 0.0], atol=1e-18)
    np.testing.assert_allclose(test.read["quadrature"], [2e-3 * np.sin(np.radians(60.0)), -1e-3])
    np.testing.assert_array_equal(test.set["voltage_offset"], [1e3, 1e3])
    np.testing.assert_array_equal(test.set["voltage_amplitude"], [60.0, 60.0])
    np.testing.assert_array_equal(test.set["frequency"], [6.0, 9.0])
    np.testing.assert_allclose(test.deviations, [1e-5] * 4)
    assert test.readings == [("m", "laser")] * 4
    assert found.measured
    assert test.name == "frequency response, test 1"
    with pytest.raises(InputError, match=r"test 1: frequency\[1\] = '9 mm'"):
        read(text.replace("9 Hz", "9 mm"))


def test_tests_are_measured_once_all_readings_are_there(read):
    half = '[[test]]\nkind = "blocked force"\nheight = ["10 mm", "12 mm"]\nvoltage = "0 V"\nnoise = "1 mN"\n'
    assert not read(half).measured
    ringing = RINGING.replace('file = "ringing.csv"', 'frequency = "9 Hz"')
    assert not read(ringing).measured  # its decay is missing
    assert read(ringing + 'decay = "1 1/s"\n').measured
    assert not read(half + 'force = ["1 mN", "2 mN"]\n' + STROKE).measured
    found = read(half + 'force = ["1 mN", "2 mN"]\n')
    assert found.measured
    (test,) = found.tests
    np.testing.assert_allclose(test.set["height"], [0.01, 0.012])
    np.testing.assert_array_equal(test.set["voltage"], [0.0, 0.0])
    np.testing.assert_allclose(test.read["force"], [1e-3, 2e-3])
    np.testing.assert_allclose(test.noise["force"], [1e-3, 1e-3])
    with pytest.raises(InputError, match="test 1: height has 2 values and others 3; give one"):
        read(half.replace('voltage = "0 V"', 'voltage = ["0 V", "0 V", "1 V"]'))
    with pytest.raises(InputError, match='a blocked force test needs height; name a column, or give height = "10 mm"'):
        read(half.replace('height = ["10 mm", "12 mm"]\n', ""))


def test_a_series_has_the_readings_that_are_there_thinned_and_times_that_rise(read):
    text = '[[test]]\nkind = "series"\nfile = "step.csv"\nnoise = {stroke = "10 um", current = "2 uA"}\n'
    count = 1001
    table = "time (ms),voltage (kV),stroke (mm),current (uA)\n"
    step = table + "".join(f"{k},{0.001 * k},{0.1 * k},{0.2 * k}\n" for k in range(count))
    (test,) = read(text, step=step).tests
    assert test.name == "series, step.csv, 334 of 1001 rows"
    np.testing.assert_allclose(test.set["time"], 1e-3 * np.arange(count))
    np.testing.assert_allclose(test.set["voltage"], np.arange(count))
    np.testing.assert_allclose(test.read["stroke"], 1e-4 * np.arange(0, count, 3))
    np.testing.assert_allclose(test.read["current"], 2e-7 * np.arange(0, count, 3))
    np.testing.assert_allclose(test.deviations, [1e-5] * 334 + [2e-6] * 334)
    assert test.readings == [("m", "laser")] * 334 + [("A", "ammeter")] * 334
    short = "time (s),voltage (V),current (mA)\n0,0,1\n1,10,2\n"
    (test,) = read(text, step=short).tests
    assert list(test.read) == ["current"]
    assert test.name == "series, step.csv"
    with pytest.raises(InputError, match="has 1 times; a series takes 2 to 20000"):
        read(text, step="time (s),voltage (V),current (mA)\n0,0,1\n")
    with pytest.raises(InputError, match="the time 1 s follows 1 s; times must rise"):
        read(text, step=short + "1,3,4\n")
    planned = '[[test]]\nkind = "series"\ntime = ["0 s", "1 s"]\nvoltage = ["0 V", "5 V"]\nnoise = "10 um"\n'
    (test,) = read(planned).tests
    assert list(test.read) == ["stroke"]
    assert np.isnan(test.read["stroke"]).all()


def test_columns_are_found_by_name_or_named_and_turned_round(read):
    text = (
        '[[test]]\nkind = "stroke over load"\nfile = "a.csv"\nload = "-W, mN"\nvoltage = "2 kV"\n'
        'noise = {stroke = "5 um"}\n'
    )
    (test,) = read(text, a="W,displacement (um),note\n-1,10,x\n-2,20,y\n").tests
    np.testing.assert_allclose(test.set["load"], [1e-3, 2e-3])
    np.testing.assert_allclose(test.read["stroke"], [1e-5, 2e-5])
    np.testing.assert_array_equal(test.set["voltage"], [2e3, 2e3])
    np.testing.assert_allclose(test.noise["stroke"], [5e-6] * 2)
    assert test.name == "stroke over load, a.csv"
    with pytest.raises(InputError, match='the noise of stroke is missing; give noise = "10 um", or a table'):
        read(text.replace('noise = {stroke = "5 um"}', 'noise = {force = "1 mN"}'), a="W,d (um)\n-1,10\n")
    with pytest.raises(InputError, match="'kV' is not a unit of length; write one of m, cm, mm"):
        read(text, a="W,displacement (kV)\n-1,10\n-2,20\n")
    with pytest.raises(InputError, match="column 'W' is in N by its heading and in mN by the list; leave the unit out"):
        read(text, a="W (N),displacement (um)\n-1,10\n-2,20\n")
    np.testing.assert_allclose(
        read(text, a="W (mN),displacement (um)\n-1,10\n-2,20\n").tests[0].set["load"], [1e-3, 2e-3]
    )
    for micro in ("\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}"):
        (test,) = read(text.replace("-W, mN", "-W, uN"), a=f"W ({micro}N),displacement (um)\n-1,10\n-2,20\n").tests
        np.testing.assert_allclose(test.set["load"], [1e-6, 2e-6])
    with pytest.raises(InputError, match="line 3: column 'W' has an empty cell"):
        read(text, a="W,displacement (um)\n-1,10\n,20\n")


def example_in(error, name):
    (found,) = re.findall(rf'{name} = "(.*?)"', str(error.value))
    return found


@pytest.mark.parametrize("unit", sorted({own.unit for kind in KINDS.values() for own in kind.read.values()}))
def test_the_example_of_a_missing_noise_is_one_of_its_unit(unit):
    with pytest.raises(InputError, match="the noise of reading is missing") as error:
        _noise("test 1", "reading", unit, None)
    assert 0.0 < _noise("test 1", "reading", unit, example_in(error, "noise")) < 0.1


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, own in KINDS.items() for name in own.set])
def test_the_example_of_a_missing_setting_is_one_of_its_unit(kind, name):
    own = KINDS[kind]
    numbers = {other: np.zeros(1) for other in (*own.set, *own.read) if other != name}
    with pytest.raises(InputError, match=f"test 1: a {kind} test needs {name};") as error:
        _assembled("test 1", kind, numbers, "1", None)
    assert _parsed("test 1", name, example_in(error, name), own.set[name]) > 0.0
