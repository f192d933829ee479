"""The example of CONTRIBUTING, a strain-energy law of one's own, through every command with a device."""

import re
from pathlib import Path

import numpy as np
import pytest
import sympy

import gelcone
from gelcone.motion import best_drive
from gelcone.register.analyses import ANALYSES
from tests.answers import result
from tests.toys import STATED

TEXT = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
DEVICE = """
disc_radius = "8 mm"
film_radius = "30 mm"
film_thickness = "0.2 mm"
meridional_prestretch = 1.1
hoop_prestretch = 1.1
initial_height = "20 mm"
spring_rate = "15 N/m"
moving_mass = "5 g"
quality_factor = 4
voltage_amplitude = "0.4 kV"
voltage_offset = "0.5 kV"
frequency = "10 Hz"
film = "tests.toys:StatedCone"
"""
MEMBRANE = ["--film", "membrane"]
SMALL = {
    "simulate": ["--periods", "3", *MEMBRANE],
    "static": MEMBRANE,
    "section": ["--repeats", "5", "--discard", "20"],
    "extrema": ["--repeats", "5", "--discard", "20"],
    "lyapunov": ["--budget", "60 s", "--window", "1 s"],
    "frequency": ["--over", "frequency=9 Hz:11 Hz:3"],
    "tongues": ["--over", "frequency=9 Hz:11 Hz:3", "--over", "voltage_amplitude=0.1 kV:0.9 kV:3"],
    "bifurcation": ["--over", "voltage_amplitude=0.2 kV:0.4 kV:3", "--sweeps", "up"],
    "continue_branch": ["voltage_amplitude", "0.3 kV", "0.4 kV", "--checks", "2"],
    "map": ["--over", "material.fung_b=0.1:0.2:2", "--over", "quality_factor=4:5:2", "--uniform"],
    "film": MEMBRANE,
    "creep": ["--set", "material.viscous_modulus_1=4 kPa", "--set", "material.relaxation_time_1=2 s", "--film", "taut"],
    "drive": ["--lowest-frequency", "9 Hz", "--highest-frequency", "11 Hz"],
    "sweep": ["--over", "material.fung_b=0.1:0.2:2"],
    "validate": ["--over", "displacement=10 mm", "--elements", "10"],
    "basin": ["--over", "displacement=10 mm:12 mm:2", "--over", "velocity=0 m/s:0.1 m/s:2"],
    "envelope": ["--over", "frequency=9 Hz:11 Hz:2", "--over", "peak_voltage=0.6 kV:1 kV:2"],
}
FLAT = ["--set", "initial_height=0", "--set", "voltage_offset=0", "--set", "release_height=1 mm"]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """An empty folder with the law and a device of it, as CONTRIBUTING writes them."""
    (law,) = (text for text in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL) if "class Fung" in text)
    (gel,) = (text for text in re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL) if "fung_b" in text)
    (tmp_path / "mylaw.py").write_text(law)
    (tmp_path / "mine.toml").write_text(DEVICE + gel)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_the_law_obeys_its_energy(place):
    law = gelcone.find_device("mine.toml").to_model().law
    e, b = sympy.symbols("e b", positive=True)
    n = {"fung_b": b}
    response = 2 * sympy.diff(law.energy(e, n, sympy), e)
    assert sympy.simplify(response - law.response(e, n, sympy)) == 0
    assert sympy.simplify(sympy.diff(response, e) - law.response_slope(e, n, sympy)) == 0
    assert law.response(0.0, {"fung_b": 0.1}) == 1.0


@pytest.mark.parametrize("name", [name for name in ANALYSES if name not in ("show", "locus")])
def test_every_command_takes_a_device_of_it(name, place, command_line, undrawn, monkeypatch):
    """A cone that wrinkles, quicker than the membrane, on which some run; a rest that is flat where one is needed. The
    answer and its file state the errors of a fitted film."""
    for constant, few in (("COARSE", 4), ("FINE", 3), ("PEAKS", (0.5, 1.2, 3))):
        monkeypatch.setattr(best_drive, constant, few)
    analysis = ANALYSES[name]
    flat = FLAT if name in ("onset", "onset_voltage", "floquet", "tongues") else []
    code, out, err = command_line(
        analysis.command, "mine.toml", *SMALL.get(name, []), *flat, "--json", "--out", "results"
    )
    assert code == 0, err
    subject = result(out)["subject"]
    (written,) = (place / "results").glob("*.nc")
    shown = gelcone.load(written)
    own = gelcone.model_of(shown)
    assert own.law == gelcone.find_device("mine.toml").to_model().law
    assert set(np.ravel(own.values["fung_b"])) <= {0.1, 0.2}
    stated = {error: shown.attrs.get(error) for error in STATED}
    assert {error: subject[error] for error in STATED} == stated
    if "membrane" in SMALL.get(name, []):
        assert all(value > 0.0 for value in stated.values())
    else:
        assert stated == (dict.fromkeys(STATED) if "taut" in SMALL.get(name, []) else STATED)


@pytest.mark.usefixtures("no_membranes")
def test_it_is_set_in_python_and_on_the_command_line(place, command_line):
    from mylaw import Fung

    own = gelcone.find_device("mine.toml")
    gel = gelcone.Material(shear_modulus="8 kPa", relative_permittivity=6, law=Fung(), fung_b=0.1)
    pump = gelcone.find_device("biased-pump")
    for device in (
        pump.replace(material=gel),
        pump.replace(material=own.material),
        pump.replace({"material.law": "mylaw:Fung", "material.fung_b": 0.1}),
        pump.replace({"material.law": Fung(), "material.fung_b": 0.1}),
        pump.replace({"material.law": {"component": "mylaw:Fung", "fung_b": 0.1}}),
    ):
        model = device.to_model()
        assert (model.law, model.values["fung_b"]) == (Fung(), 0.1)
    texts = ["--set", "material.law=mylaw:Fung", "--set", "material.fung_b=0.1"]
    code, out, err = command_line("static", "biased-pump", *texts, "--json")
    assert code == 0, err
    assert result(out)["subject"]["fields"]["material"]["fung_b"] == 0.1
