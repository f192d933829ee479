"""The membrane by shooting, against certified numbers, its own balance of charge, and limits with closed forms."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.membrane.gel import Gel
from gelcone.membrane.states import Film
from gelcone.physics.laws import LAWS

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "membrane.json").read_text())
"""Made by an independent program, see tests/reference/README.md."""
SOLVED = [r for r in REFERENCE["states"] if r["meridional_prestretch"] >= r["hoop_prestretch"]]
QUICK = {(0.2, 1, 0.5, 0.6), (0.2, 1.5, 0.25, 1.0), (0.2, 1.2, 0.3, 0.3), (0.4, 0.9, 0.8, 0.3)}


def gent(ratio, lm, lh, limit):
    return Film(Gel(LAWS["gent"], {"inverse_stretch_limit": 1.0 / (limit or np.inf)}, lm * lm, lh * lh), ratio)


def film_of(row):
    names = ("radius_ratio", "meridional_prestretch", "hoop_prestretch", "stretch_limit")
    return gent(*(row[name] for name in names))


def marked(row):
    own = (row["radius_ratio"], row["meridional_prestretch"], row["x"], row["v"])
    return pytest.param(row, marks=() if own in QUICK else pytest.mark.slow, id="-".join(map(str, own)))


@pytest.mark.parametrize("row", [marked(row) for row in SOLVED])
def test_certified_states(row):
    found = film_of(row).at(np.array([row["x"]]), np.array([row["v"] ** 2]), 48)
    assert found.force[0] == pytest.approx(row["force"], rel=1e-8, abs=3.0 * row["error_force"])
    assert found.area[0] == pytest.approx(row["area"], rel=1e-8, abs=3.0 * row["error_area"])
    own = film_of(row).profile(row["v"] ** 2, *(values[0] for values in (found.l1, found.u, found.end)))
    assert own.m[0] == pytest.approx(row["disc_m"], rel=1e-7)
    assert own.n[-1] == pytest.approx(row["rim_n"], rel=1e-7)
    assert own.field.max() == pytest.approx(row["largest_field"], rel=1e-6)
    assert own.radius.min() == pytest.approx(row["least_radius"], rel=1e-6)
    assert own.firmness.min() > 0.0


@pytest.mark.parametrize("row", [r for r in REFERENCE["pull_in"] if r["v"] in (0.6, 1.2, 0.4)])
def test_certified_pull_in(row):
    found = film_of(row).pull_in(np.array([row["v"] ** 2]))
    assert found.x[0] == pytest.approx(row["x"], abs=1e-6)
    assert found.l1[0] == pytest.approx(row["disc_l1"], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("row", REFERENCE["pull_in"])
def test_all_certified_pull_in(row):
    found = film_of(row).pull_in(np.array([row["v"] ** 2]))
    assert found.x[0] == pytest.approx(row["x"], abs=1e-5)


def test_no_film_pulls_in_below_its_lowest_voltage():
    """Without a zero of the firmness below the stretch limit nothing localises (lp 1, J 50: V* = 0.09841)."""
    film = gent(0.2, 1.0, 1.0, 50.0)
    below, above = film.pull_in(np.array([0.0983, 0.0985])).x
    assert np.isnan(below)
    assert 1.4 < above < 2.0


def test_force_and_charge_come_from_one_energy():
    """Maxwell: dF/dV = -(dA/dx)/2, where rings wrinkle too."""
    film, step = gent(0.2, 1.0, 1.0, 50.0), 5e-4
    x, V = 0.5, 0.25
    found = film.at(np.array([x, x, x - step, x + step]), np.array([V - step, V + step, V, V]))
    by_voltage = (found.force[1] - found.force[0]) / (2.0 * step)
    assert by_voltage == pytest.approx(-(found.area[3] - found.area[2]) / (4.0 * step), rel=3e-6)


@pytest.mark.parametrize(("law", "numbers"), [("yeoh", {"yeoh_c2": 0.02, "yeoh_c3": 0.001}), ("neo-hookean", {})])
def test_a_long_narrow_film_is_the_cone(law, numbers):
    """For a/b -> 1 all rings are equal, and the homogeneous cone is exact: F = x (A - G/q^2) R - x V."""
    film, x, V = Film(Gel(LAWS[law], numbers, 1.44, 1.44), 0.9995), 0.5, 0.3
    found, q = film.at(np.array([x]), np.array([V])), 1.0 + x * x
    response = LAWS[law].response(1.44 * q + 1.44 + 1.0 / (1.44**2 * q) - 3.0, numbers)
    assert found.force[0] == pytest.approx(x * ((1.44 - 1.0 / (1.44 * q) ** 2) * response - V), rel=2e-3)


def test_a_height_without_a_state_gives_none():
    """Slack below the height where the film comes under tension, pulled in above that of localisation."""
    assert np.isnan(gent(0.2, 1.0, 1.0, 50.0).at(np.array([0.1, 0.9]), np.array([0.36, 0.36])).force).all()
