"""`gelcone frequency`: JSON, files, SI units, text and figure, one-line errors."""

from functools import partial

import numpy as np
import pytest

from gelcone.dataset import load
from gelcone.devices.device import find_device
from gelcone.plots.frequency import frequency_figure
from tests.answers import result

pytestmark = pytest.mark.usefixtures("computed_once")

SPRING = ["--preset", "spring", "--set", "spring_stiffness=0.1"]
BAND = ["--over", "drive_frequency=0.36:0.72:10"]
HARD = ["--set", "voltage_amplitude=901 V", "--set", "voltage_offset=1.126 kV"]
HERTZ = ["biased-pump", "--film", "taut", *HARD, "--over", "frequency=9 Hz:13 Hz:5"]


@pytest.fixture
def gelcone(command_line):
    return partial(command_line, "frequency")


def test_the_object_holds_both_sweeps_their_peaks_and_the_jump(gelcone):
    code, out, err = gelcone(*SPRING, *BAND, "--json")
    assert (code, err) == (0, "")
    content = result(out)
    np.testing.assert_allclose(content["drive_frequency"], np.linspace(0.36, 0.72, 10))
    assert content["branch"] == ["up", "down"]
    up, down = content["period"]
    assert up == [2] * 8 + [1] * 2
    assert down[-4:] == [1] * 4
    assert content["stroke"][0][6] > 20.0 * content["stroke"][1][6]
    assert content["dims"]["harmonic_amplitude"] == ["branch", "harmonic", "drive_frequency"]
    assert np.shape(content["harmonic_amplitude"]) == (2, len(content["harmonic"]), 10)
    assert content["jump_branch"][-1] == "up"
    assert 0.64 < content["jump_low"][-1] < content["jump_high"][-1] < 0.68
    assert content["peak_low"][0] <= content["peak_frequency"][0] <= content["peak_high"][0]
    assert len(content["linear_stroke"]) == 10
    assert content["parameters"]["spring_stiffness"] == 0.1


def test_a_device_answers_in_hertz_and_millimetres(gelcone, undrawn, tmp_path):
    code, out, err = gelcone(*HERTZ, "--out", "there")
    assert (code, err) == (0, "")
    assert "drive frequency 9 to 13 Hz, 5 values" in out
    assert "mm at" in out
    assert "no jump" in out
    result = load(tmp_path / "there" / "frequency.nc")
    assert result["drive_frequency"].attrs["units"] == "Hz"
    assert result["stroke"].attrs["units"] == "mm"
    np.testing.assert_allclose(result["drive_frequency"], np.linspace(9.0, 13.0, 5))
    assert (tmp_path / "there" / "frequency.png").exists()
    peak = result.sel(branch="up")
    assert 10.0 < float(peak["peak_low"]) <= float(peak["peak_frequency"]) <= float(peak["peak_high"]) < 12.0
    scale = 1e3 * find_device("biased-pump").scales.length
    assert 2.0 < float(peak["peak_amplitude"]) / scale < 3.0


def test_the_text_tells_jumps_and_subharmonics_and_the_figure_draws_them(gelcone, tmp_path):
    code, out, _ = gelcone(*SPRING, *BAND, "--out", ".")
    assert code == 0
    assert "subharmonic at 8 of 10 frequencies" in out
    assert "jumps (the sweeps differ between):" in out
    assert out.count("swept up") >= 2
    figure = frequency_figure(load(tmp_path / "frequency.nc"))
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert {"swept up", "swept down", "subharmonic, swept up", "linear theory"} <= set(labels)


def test_a_stroke_that_is_largest_at_an_end_says_so(gelcone):
    ends = gelcone("biased-pump", "--film", "wrinkling", *HARD, "--over", "frequency=9 Hz:10 Hz:3")[1]
    assert ends.count("an end of the frequencies: it may rise beyond") == 2
    assert "linear theory: largest stroke 13.3 mm at 10 Hz" in ends
    falling = gelcone("biased-pump", "--film", "wrinkling", *HARD, "--over", "frequency=13 Hz:16 Hz:3")[1]
    assert falling.count("at 13 [13, ") == falling.count("an end of the frequencies: it may rise beyond") == 2


def test_without_frequencies_the_band_lies_around_the_natural_one(gelcone):
    """Of the flat film without bias: sqrt(kappa)."""
    _, out, _ = gelcone("--set", "voltage=0.1", "--set", "damping_ratio=0.1", "--json")
    content = result(out)
    natural = content["parameters"]["spring_stiffness"] ** 0.5
    even, found = natural * np.geomspace(0.1, 3.0, 81), np.array(content["drive_frequency"])
    assert np.abs(even[:, None] / found - 1.0).min(axis=1).max() < 1e-12
    assert (found[0], found[-1]) == pytest.approx((even[0], even[-1]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--over", "voltage=0:1:5"], "sweeps drive_frequency"),
        ([*BAND, "--over", "voltage=0:1:5"], "sweeps drive_frequency"),
        (["--set", "voltage_bias=5", "--set", "stretch_limit=inf"], "beyond pull-in"),
        (["--over", "drive_frequency=1"], "give at least two, or take gelcone settled"),
        (["--over", "drive_frequency=9 Hz:13 Hz:5"], "units need a device"),
        (["--set", "voltage=0.5,1", *BAND], "takes one actuator, not an ensemble of 2"),
        (["--set", "damping_ratio=0", *BAND], "without damping no motion settles"),
    ],
)
def test_bad_input_is_one_line(gelcone, arguments, message):
    code, out, err = gelcone(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
