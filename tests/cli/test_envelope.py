"""`gelcone envelope`: the table an engineer reads, JSON with power, SI units, what is unknown, one-line errors."""

from functools import partial

import numpy as np
import pytest

from gelcone.dataset import load
from gelcone.plots.envelope import envelope_figure
from tests.answers import result

pytestmark = pytest.mark.usefixtures("computed_once")

PUMP = ["biased-pump", "--film", "taut", "--over", "frequency=8 Hz,10 Hz", "--over", "peak_voltage=1100 V:2900 V:5"]
FLAT = ["--set", "damping_ratio=0.1", "--set", "voltage=0.8", "--set", "prestretch=1.3"]
FLAT += ["--over", "drive_frequency=0.7,1.5", "--over", "peak_voltage=0.4,0.8"]


@pytest.fixture
def gelcone(command_line):
    return partial(command_line, "envelope")


def test_the_object_holds_limits_window_stroke_and_power_in_si(gelcone):
    code, out, err = gelcone(*PUMP, "--json")
    assert (code, err) == (0, "")
    content = result(out)
    np.testing.assert_allclose(content["drive_frequency"], [8.0, 10.0])
    units = content["units"]
    assert [units[f"window_{name}"] for name in ("stroke", "power", "apparent_power")] == ["mm", "mW", "mVA"]
    static = dict(zip(content["static_limit"], content["static_limit_voltage"], strict=True))
    driven = dict(zip(content["driven_limit"], content["limit_low"], strict=True))
    assert static["pitchfork"] == "unknown or not applicable"
    assert driven["onset of rest"] == ["unknown or not applicable"] * 2
    low = np.array(driven["pull-in"])
    assert (np.array(content["recommended_peak"]) <= 0.8 * low + 1e-9).all()
    assert [content["driven_limit"][k] for k in content["first_limit"]] == ["pull-in"] * 2
    assert content["window_regime"] == ["periodic"] * 2
    power, apparent = content["window_power"], content["window_apparent_power"]
    assert (np.array(power) > 0.0).all()
    assert (np.array(power) < 0.2 * np.array(apparent)).all()
    assert content["recommended_constant"] == pytest.approx(0.8 * static["pull-in"])


def test_the_text_says_what_comes_first_what_the_window_yields_and_where_the_device_is(gelcone, undrawn, tmp_path):
    code, out, err = gelcone(*PUMP, "--out", "there")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert any(line.split()[:2] == ["dielectric", "breakdown"] and "2281 to 2288 V" in line for line in lines)
    assert "frequency (Hz)    up to (V)   stroke (mm)   power (mW)    apparent (mVA)" in out
    assert "its drive, 1470 V at 10 Hz: inside the window, 1510 V there" in out
    figure = envelope_figure(load(tmp_path / "there" / "envelope.nc"))
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert {"recommended window", "hoop slack, driven", "the device's drive"} <= set(labels)
    assert {"mean power supplied (mW)", "natural freq. (Hz)", "blocked force (N)"} <= {
        a.get_ylabel() for a in figure.axes
    }


def test_without_a_dielectric_strength_text_object_and_figure_say_unknown(gelcone, undrawn, tmp_path):
    code, out, _ = gelcone(*FLAT, "--out", ".")
    assert code == 0
    assert "the dielectric strength is not given: the window takes no account of breakdown" in out
    assert "within the window the film stays at rest" in out
    labels = envelope_figure(load(tmp_path / "envelope.nc")).axes[0].get_legend_handles_labels()[1]
    assert any("unknown" in label for label in labels)
    content = result(gelcone(*FLAT, "--json")[1])
    for kind, name in (("static", "static_limit_voltage"), ("driven", "limit_low")):
        low = dict(zip(content[f"{kind}_limit"], content[name], strict=True))["dielectric breakdown"]
        assert set(np.ravel(low)) == {"unknown or not applicable"}
    assert content["window_regime"] == ["rest", "rest"]


def test_a_film_that_is_slack_from_the_start_has_no_window(gelcone):
    code, out, _ = gelcone(*FLAT[:4], *FLAT[6:])
    assert code == 0
    assert "no driven window is recommended: hoop slack from 0 on at every frequency" in out
    assert "no constant voltage is recommended: the film is slack from 0 on; pre-stretch it" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--over", "damping_ratio=0.1,0.2"], "sweeps drive_frequency and peak_voltage"),
        (["--initial", "1,0"], "envelope does not start from a state"),
        (["--margin", "1"], "--margin 1: "),
        (["--set", "voltage=0"], "give it an amplitude or a bias"),
        (["--over", "drive_frequency=8 Hz,10 Hz"], "units need a device"),
    ],
)
def test_bad_input_is_one_line(gelcone, arguments, message):
    code, out, err = gelcone(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
