"""--film of every command: the answers of a film that is the cone, its errors in the text, and without scikit-fem."""

import sys

import numpy as np
import pytest

import gelcone
from gelcone import disk_cache
from gelcone.continuum.fit import FITS
from tests.answers import result
from tests.physics.film.test_unwrinkled import film_like_the_cone

pytestmark = pytest.mark.usefixtures("computed_once")

MODEL = ["--set", "law=neo-hookean", "--set", "damping_ratio=0.1", "--set", "voltage=0.4", "--set", "rest_height=0.3"]
COMMANDS = {
    "simulate": ["--periods", "3"],
    "regime": [],
    "static": [],
    "lyapunov": [],
    "bifurcation": ["--over", "drive_frequency=0.9,1"],
    "map": ["--over", "spring_stiffness=1.4,1.5", "--over", "drive_frequency=0.9,1"],
    "frequency": ["--over", "drive_frequency=0.9,1"],
    "envelope": ["--over", "drive_frequency=0.9,1", "--over", "voltage=0.2,0.4"],
}


@pytest.fixture
def run(monkeypatch, command_line, tmp_path):
    """Runs a command in an empty folder that holds ``film.json``."""
    usual = disk_cache.folder
    monkeypatch.setattr(disk_cache, "folder", lambda kind: tmp_path / kind if kind == FITS else usual(kind))
    gelcone.write_film(film_like_the_cone(errors=(("taut", 0.0123),)), tmp_path / "film.json")
    return command_line


SAME = {
    "simulate": lambda content: content["displacement"],
    "regime": lambda content: content["lyapunov"],
    "static": lambda content: content["slope"][0],
    "frequency": lambda content: content["stroke"][0] + content["linear_stroke"],
    "envelope": lambda content: content["driven_stroke"] + content["driven_power"],
}


@pytest.mark.parametrize("command", SAME)
def test_a_film_that_is_the_cone_gives_the_cones_answers(run, command):
    cone, film = (
        SAME[command](result(run(command, *MODEL, *COMMANDS[command], "--film", choice, "--json")[1]))
        for choice in ("taut", "film.json")
    )
    np.testing.assert_allclose(film, cone, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_takes_a_film_and_says_how_well_it_fits(run, command):
    code, out, err = run(command, *MODEL, *COMMANDS[command], "--film", "film.json")
    assert (code, err) == (0, "")
    assert (
        "film as a continuum that bears compression, a/b = 0.2, up to |x| = 1000; largest error of its force: taut 1.2%"
        in out
    )


def test_without_scikit_fem_one_line_says_how_to_get_it(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "skfem", None)
    for subject in (["biased-pump"], ["--preset", "table1", "--set", "voltage=0.5"]):
        code, out, err = run("simulate", *subject, "--film", "continuum")
        assert (code, out) == (1, "")
        assert "pip install 'gelcone[fem]'" in err
        assert err.count("\n") == 1
