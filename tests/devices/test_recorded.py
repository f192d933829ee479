"""Recorded drives: files that are read, samples that are left out, and files that are refused in a line each."""

import os
import random

import numpy as np
import pytest
from scipy.io import savemat

import gelcone
from gelcone.devices.recorded import needed, read_recording, recorded
from gelcone.errors import DoubtfulInput, InputError

PUMP = gelcone.find_device("biased-pump").replace(film="wrinkling")
GOOD = "time (ms), voltage (kV)\n0, 0\n200, 0.7\n500, 0.5\n600, 0.9\n1200, 0\n"


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "drive.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def test_a_device_follows_a_recording(write):
    device = recorded(PUMP, write(GOOD), scale=0.5)
    assert device.frequency == pytest.approx(1.0 / 1.2)
    run = gelcone.simulate(device)
    assert float(run["time"][-1]) == pytest.approx(1200.0)
    expected = 1e3 * 0.5 * np.interp(run["time"], [0, 200, 500, 600, 1200], [0.0, 0.7, 0.5, 0.9, 0.0])
    np.testing.assert_allclose(run["drive_voltage"], expected, atol=1e-9)
    again = recorded(PUMP, write(GOOD), repeat=True)
    assert float(gelcone.settled(again)["stroke"]) > 0.1
    smooth = gelcone.simulate(recorded(PUMP, write(GOOD), interpolation="pchip"))
    assert float(smooth["drive_voltage"].max()) == pytest.approx(900.0, rel=1e-3)
    model = recorded(PUMP.to_model(), write("time, voltage\n1, 0\n3, 0.4\n"))
    assert (model.voltage, model.drive_frequency) == (0.4, pytest.approx(np.pi))


@pytest.mark.parametrize("scale", [0.5, -0.5])
def test_a_recording_may_swing_further_below_zero(write, scale):
    device = recorded(
        PUMP.replace(voltage_offset="100 V"), write("time (s),voltage (V)\n0,0\n1,300\n2,-800\n4,0\n"), scale=scale
    )
    assert (device.voltage_amplitude, device.voltage_offset, device.frequency) == (400.0, 0.0, 0.25)
    assert max(map(abs, device.waveform.values)) == 1.0
    members = device.to_model().members()
    volts = np.ravel(members.voltages(np.array([[1.0, 2.0, 3.0]]) / device.scales.time, np.zeros((1, 3, 2)))[0])
    np.testing.assert_allclose(volts * device.scales.voltage, scale * np.array([300.0, -800.0, -400.0]), rtol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        "# made by a scope\n" + GOOD,
        "voltage/kV,remark,time/ms\n0,a,0\n0.7,b,200\n0.5,,500\n0.9,,600\n0,,1200\n",
        "voltage/kV,gate,time/ms\n0,1,0\n0.7,1,200\n0.5,1,500\n0.9,off,600\n0,1,1200\n",
        "u (kV),v (mm/s),t (s)\n0,1,0\n0.7,1,.2\n0.5,1,.5\n0.9,0,.6\n0,1,1.2\n",
        "Time [s],Voltage [V]\n0,0\n.2,700\n.5,5e2\n.6,900\n1.2,0\n",
    ],
)
def test_other_ways_to_write_the_same(write, text):
    times, volts = read_recording(write(text), True)
    np.testing.assert_allclose(times, [0.0, 0.2, 0.5, 0.6, 1.2], rtol=1e-15)
    np.testing.assert_allclose(volts, [0.0, 700.0, 500.0, 900.0, 0.0], rtol=1e-15)


def test_samples_on_straight_lines_are_left_out():
    t = np.linspace(0.0, 10.0, 10_001)
    corners = np.array([0.0, 2.0, 3.0, 7.0, 10.0])
    v = np.interp(t, corners, [0.0, 7.0, 3.0, 9.0, 0.0])
    assert len(needed(t, v)) == 5
    wave = np.sin(t) + 1e-5 * np.random.default_rng(1).normal(size=t.size)
    kept = needed(t, wave)
    assert len(kept) < 300
    assert np.abs(np.interp(t, t[kept], wave[kept]) - wave).max() <= 1.0001e-4 * np.abs(wave).max()


BAD = {
    "": "is empty",
    "\n\n": "is empty",
    "0,1\n1,2\n": "line 1: is a row of numbers, not a header",
    "times (s),voltage (V)\n0,1\n1,2\n": "has no column 'time'",
    "time (s)\n1\n2\n": "has no column 'voltage'",
    "time (s), time (s), voltage (V)\n0,0,0\n": "has two columns 'time'",
    "time (s), Time (s), voltage (V)\n0,0,0\n": "columns 'time' and 'Time' are spelt alike",
    "time, voltage\n0,0\n1,1\n": 'column "time" has no unit; write "time (s)"',
    "time (d), voltage (V)\n0,0\n1,1\n": "column 'time': 'd' is not a unit of time; write one of s, ms, us, min, h",
    "time (s), voltage (A)\n0,0\n1,1\n": "column 'voltage': 'A' is not a unit of voltage",
    "time (s), voltage (V)\n0,0\n": "has 1 samples; a drive needs at least 2",
    "time (s), voltage (V)\n0,0\n1\n2,2\n": "line 3: has 1 cells for 2 columns; complete it",
    "time (s), voltage (V)\n0,0\n1,5,2\n": "line 3: has 3 cells for 2 columns; decimal commas need semicolons",
    "time (s), voltage (V)\n0,0\n1,\n": "line 3: column 'voltage' has an empty cell",
    "time (s), voltage (V)\n0,0\n1,nan\n": "line 3: column 'voltage' has an empty cell",
    "time (s), voltage (V)\n0,0\n1,inf\n": "line 3: column 'voltage' holds 'inf'; give one number a cell",
    "time (s), voltage (V)\n0,0\n1,1e300\n": "line 3: column 'voltage' holds '1e300'; give numbers of at most 1e+20",
    "time (s), voltage (V)\n0,0\n1,-2e20\n": "line 3: column 'voltage' holds '-2e20'; give numbers of at most 1e+20",
    "time (s), voltage (V)\n0,0\n1,1_0\n": "line 3: column 'voltage' holds '1_0'; give one number a cell",
    "time (s), voltage (V)\n0,0\n1,5 V\n": "line 3: column 'voltage' holds '5 V'; give one number a cell",
    "time (s), voltage (V)\n0,low\n1,high\n": "column 'voltage' holds words, and voltage is a number",
    "time (s), voltage (V)\n0,0\n1,1\n1,2\n": "line 4: the time 1 s repeats 1 s; times must increase",
    "time (s), voltage (V)\n0,0\n2,1\n1,2\n": "line 4: the time 1 s goes back from 2 s; times must increase",
    'time (s),voltage (V)\n0,"1,000"\n1,"2,500"\n': "column 'voltage' holds '1,000': a decimal comma, or a mark",
}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_file_is_refused_in_a_line(write, text):
    with pytest.raises(InputError) as raised:
        recorded(PUMP, write(text))
    assert BAD[text] in str(raised.value)
    assert "drive.csv" in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.parametrize("data", [b"\xff\xfe", b"\x00" * 100, os.urandom(2000)])
def test_bytes_that_are_no_text_are_refused_in_a_line(write, data):
    with pytest.raises(InputError) as raised:
        recorded(PUMP, write(data))
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.filterwarnings("ignore::gelcone.errors.DoubtfulInput")
def test_a_good_file_with_one_byte_wrong_is_read_or_refused_in_a_line(write):
    draw = random.Random(4)
    for _ in range(200):
        data = bytearray(GOOD.encode())
        data[draw.randrange(len(data))] = draw.randrange(256)
        found, told = None, "one line"
        try:
            found = read_recording(write(bytes(data)), True)
        except InputError as error:
            told = str(error)
        assert len(told.splitlines()) == 1, data
        assert found is None or ((np.diff(found[0]) > 0.0).all() and np.isfinite(found[1]).all())


def test_what_is_no_file_or_too_much_is_refused(write, tmp_path):
    for path, message in (
        (tmp_path, "is a folder"),
        (tmp_path / "none.csv", "no such file"),
        ("/dev/zero", "is not a regular file"),
    ):
        with pytest.raises(InputError, match=message):
            recorded(PUMP, path)
    rows = "".join(f"{k},{k % 7}\n" for k in range(1_000_001))
    with pytest.raises(InputError, match="has 1000001 rows; give at most 1000000, thinned out"):
        recorded(PUMP, write("time (ms), voltage (V)\n" + rows))
    draw = random.Random(1)
    rows = "".join(f"{k},{draw.random()}\n" for k in range(30_000))
    with pytest.raises(InputError, match="of which 20000 are taken; record fewer, or smooth it"):
        recorded(PUMP, write("time (ms), voltage (V)\n" + rows))


def test_options_of_a_recording_are_checked(write):
    for options, message in (
        ({"scale": 0.0}, "scale = 0.0: must be a finite number other than 0"),
        ({"scale": np.nan}, "scale = nan"),
        ({"interpolation": "cubic"}, "'cubic' is not a interpolation|'cubic' is not an interpolation"),
    ):
        with pytest.raises(InputError, match=message):
            recorded(PUMP, write(GOOD), **options)
    text = GOOD.replace("1200, 0", "1200, 0.35")
    with pytest.raises(InputError, match=r"0\.388889 at the end, 0 at the start: repeated they would jump"):
        recorded(PUMP, write(text), repeat=True)
    assert recorded(PUMP, write(text), repeat=True, jump=True).waveform.jump


INTERPRETED = {
    GOOD.replace(",", "\t"): "cells are separated by tabs",
    GOOD.replace(",", ";").replace(".", ","): "separated by semicolons; decimals are written with commas: 0,7 is",
    GOOD.replace(" (ms)", "").replace("(kV)\n", "\nms,kV\n"): "units stand in the second row",
    GOOD + "1300": "line 7, the last, is cut off (1 cells of 2) and left out",
    GOOD.replace("0.7", '"0,7"').replace("0.5", '"0,5"').replace("0.9", '"0,9"').replace(", ", ","): "0,7 is 0.7",
}


@pytest.mark.parametrize("text", INTERPRETED)
def test_what_was_interpreted_is_stated(write, text):
    with pytest.warns(DoubtfulInput) as told:
        times, volts = read_recording(write(text), True)
    assert [str(one.message).startswith("drive.csv: ") for one in told] == [True]
    assert INTERPRETED[text] in str(told[0].message)
    np.testing.assert_allclose(times, [0.0, 0.2, 0.5, 0.6, 1.2], rtol=1e-15)
    np.testing.assert_allclose(volts, [0.0, 700.0, 500.0, 900.0, 0.0], rtol=1e-15)


def test_a_recording_may_be_a_file_of_matlab(tmp_path):
    savemat(tmp_path / "drive.mat", {"time_ms": [0.0, 200.0, 1200.0], "voltage_kV": [0.0, 0.7, 0.1], "note": "a"})
    with pytest.warns(DoubtfulInput, match="read as MATLAB"):
        times, volts = read_recording(tmp_path / "drive.mat", True)
    np.testing.assert_allclose(times, [0.0, 0.2, 1.2])
    np.testing.assert_allclose(volts, [0.0, 700.0, 100.0])


@pytest.mark.parametrize("heads", ["time, voltage", "time (1), voltage [1]", "Voltage/1, time"])
def test_a_model_takes_pure_numbers_with_or_without_the_unit_one(write, heads):
    rows = "0.4,1\n0.1,3\n" if heads.startswith("Voltage") else "1,0.4\n3,0.1\n"
    times, volts = read_recording(write(f"{heads}\n{rows}"), False)
    assert (times.tolist(), volts.tolist()) == ([0.0, 2.0], [0.4, 0.1])
    with pytest.raises(InputError, match="column 'time' is in ms, and a model has no units; give a device"):
        read_recording(write("time (ms), voltage\n0,0\n1,1\n"), False)
