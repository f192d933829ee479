"""`gelcone section` and `gelcone spectrum`: JSON, files, units of a device, and one-line errors."""

import numpy as np
import pytest

from gelcone import find_device, spectrum
from gelcone.dataset import load
from tests.answers import result

pytestmark = pytest.mark.usefixtures("computed_once")

MODEL = [
    "--set",
    "damping_ratio=0.1",
    "--set",
    "spring_stiffness=1",
    "--set",
    "voltage=0.8",
    "--set",
    "rest_height=0.3",
]
DEVICE = """
name = "bench cone"
disc_radius = "10 mm"
film_radius = "50 mm"
film_thickness = "0.5 mm"
initial_height = "10 mm"
spring_rate = "40 N/m"
moving_mass = "5 g"
damping_coefficient = 0.1
voltage_amplitude = "2 kV"
frequency = "8 Hz"

[material]
shear_modulus = "18.7 kPa"
relative_permittivity = 6.05
stretch_limit = 50
"""


@pytest.fixture
def gelcone(command_line):
    return command_line


@pytest.fixture
def device(tmp_path):
    path = tmp_path / "cone.toml"
    path.write_text(DEVICE)
    return path


def test_section_prints_its_points_as_json(gelcone):
    code, out, err = gelcone("section", *MODEL, "--repeats", 5, "--discard", 150, "--phase", 0.25, "--json")
    content = result(out)
    assert (code, err) == (0, "")
    assert content["repeat"] == [150, 151, 152, 153, 154]
    np.testing.assert_allclose(content["time"], (150.25 + np.arange(5)) * np.pi)
    assert np.ptp(content["displacement"]) < 1e-8
    assert content["outcome"] == "ok"
    assert content["parameters"]["voltage"] == 0.8


def test_extrema_as_json(gelcone):
    code, out, _ = gelcone("extrema", *MODEL, "--repeats", 3, "--json")
    content = result(out)
    assert code == 0
    assert content["count"] == 6
    assert sorted(content["maximum"]) == [-1, -1, -1, 1, 1, 1]
    assert np.abs(content["velocity"]).max() < 1e-9
    assert all(0.0 <= phase < 1.0 for phase in content["phase"])


def test_section_of_an_ensemble_in_words(gelcone):
    code, out, _ = gelcone("extrema", "--set", "voltage=0.2:0.8:3", "--repeats", 4)
    assert code == 0
    assert "3 members" in out
    assert "3 of 3: ok" in out
    code, out, _ = gelcone("section", "--set", "voltage=0.5,0.8", "--repeats", 4)
    assert "displacement" in out


def test_spectrum_as_json(gelcone):
    code, out, _ = gelcone("spectrum", *MODEL, "--periods", 32, "--highest", 10, "--json")
    content = result(out)
    assert code == 0
    np.testing.assert_allclose(content["line_ratio"][:3], [2.0, 4.0, 6.0], rtol=1e-6)
    assert content["frequency_ratio"][-1] == 10.0
    assert content["power_in_lines"] > 0.999
    assert content["flatness"] < 1e-9
    assert len(content["line_prominence"]) == len(content["line_amplitude"])


def test_spectrum_in_words(gelcone):
    code, out, _ = gelcone("spectrum", *MODEL, "--periods", 32)
    assert code == 0
    assert "% of the variance in lines" in out
    code, out, _ = gelcone("spectrum", "--set", "damping_ratio=1", "--set", "voltage=0", "--periods", 16)
    assert "stands still" in out
    code, out, _ = gelcone("spectrum", *MODEL, "--set", "drive_frequency=0.9,1", "--periods", 16)
    assert "flatness" in out
    assert "2 of 2: ok" in out


def test_a_device_gets_hertz_and_millimetres(gelcone, device):
    code, out, err = gelcone("spectrum", device, "--periods", 32, "--json")
    assert (code, err) == (0, "")
    content = result(out)
    assert content["subject"]["device"] == "bench cone"
    assert content["units"]["line_frequency"] == "Hz"
    np.testing.assert_allclose(content["line_frequency"], 8.0 * np.array(content["line_ratio"]), rtol=1e-9)
    bench = find_device(device)
    alone = spectrum(bench.to_model(), bench.initial_state(), periods=32)
    np.testing.assert_allclose(content["amplitude"], 40.0 * alone["amplitude"], rtol=1e-12)
    code, out, _ = gelcone("section", device, "--repeats", 2, "--json")
    assert result(out)["units"]["displacement"] == "mm"


@pytest.mark.parametrize("name", ["section", "extrema"])
def test_section_writes_data_and_figure_and_overwrites_only_if_forced(gelcone, undrawn, device, tmp_path, name):
    arguments = (name, device, "--repeats", 3, "--out", tmp_path / "out")
    code, out, _ = gelcone(*arguments)
    assert code == 0
    assert f"{name}.png" in out
    written = load(tmp_path / "out" / f"{name}.nc")
    assert written.displacement.attrs["units"] == "mm"
    code, _, err = gelcone(*arguments)
    assert code == 2
    assert "exists already" in err
    assert gelcone(*arguments, "--force")[0] == 0


def test_spectrum_writes_data_and_figure(gelcone, device, tmp_path):
    code, out, _ = gelcone("spectrum", device, "--periods", 32, "--out", tmp_path)
    assert code == 0
    assert "spectrum.png" in out
    assert "Hz" in out
    written = load(tmp_path / "spectrum.nc")
    assert written.frequency.attrs["units"] == "Hz"
    assert (tmp_path / "spectrum.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("section --phase 1.2", "--phase 1.2: must be at least 0 and below 1"),
        ("section --repeats 0", "--repeats 0: must be at least 1"),
        ("section --discard -1", "--discard -1: must be at least 0"),
        ("extrema --phase 0.5", "--phase"),
        ("extrema --repeats 0", "--repeats 0: must be at least 1"),
        ("spectrum --periods 0", "--periods 0: must be at least 16"),
        ("spectrum --discard -1", "--discard -1: must be at least 0"),
        ("spectrum --highest 0", "--highest 0: must be from 1"),
        ("spectrum --set voltag=1", "did you mean 'voltage'"),
        ("section --initial 20,0", "start lower or raise it"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(gelcone, arguments, message):
    code, out, err = gelcone(*arguments.split())
    assert code == 2
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
