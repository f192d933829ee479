"""Membranes with all that acts on a disc: double cones, springs, beams and weights; their energy and their bits."""

import numpy as np
import pytest

from gelcone import ConeModel, Outcome, regime, simulate, static

MEMBRANE = {"film": "membrane", "stretch_limit": 50.0, "damping_ratio": 0.05, "drive_frequency": 0.4}
LOADS = {
    "spring": {"bias": "spring", "spring_stiffness": 0.8, "rest_height": 0.5},
    "double": {"second_film": "membrane", "second_flat_height": 1.1, "spring_stiffness": 0.0},
    "opposite": {
        "second_film": "membrane", "second_flat_height": 1.1, "second_drive": "opposite", "spring_stiffness": 0.2,
        "voltage_bias": 0.25, "second_prestretch": 1.15, "prestretch_mode": "equibiaxial",
    },
    "all": {
        "bias": "spring+beam+weight+force", "spring_stiffness": 0.5, "beam_stiffness": -0.2, "beam_cubic": 0.5,
        "beam_height": 0.2, "weight": 0.05, "push": 0.02, "second_film": "membrane", "second_flat_height": 0.9,
        "second_drive": "constant", "second_voltage": 0.2,
    },
}  # fmt: skip


def model(load: str, **more) -> ConeModel:
    return ConeModel(**MEMBRANE | {"voltage": 0.25} | LOADS[load] | more)


@pytest.mark.usefixtures("undelivered")
@pytest.mark.parametrize(
    ("load", "periods"),
    [("spring", 200), pytest.param("double", 50, marks=pytest.mark.slow), ("opposite", 20), ("all", 20)],
)
def test_energy_balances_over_a_long_run(load, periods):
    """What film, field and bias take is what the disc and its damping give, to 1e-10 of the energy moved."""
    run = simulate(model(load), (0.45, 0.0), periods=periods)
    assert int(run["outcome"]) == Outcome.OK
    moved = float(run["dissipated_energy"].max())
    assert moved > 1e-4
    assert float(abs(run["energy_residual"]).max()) < 1e-10 * moved


@pytest.mark.usefixtures("undelivered")
def test_two_equal_films_move_as_their_mirror_image():
    """x and d - x with u and -u are the same motion of films that are equal and have one voltage."""
    times = np.linspace(0.0, 60.0, 301)
    double = model("double", voltage=0.3)
    below, above = (simulate(double, start, times=times) for start in ((0.3, 0.1), (0.8, -0.1)))
    np.testing.assert_allclose(1.1 - below["displacement"], above["displacement"], atol=1e-10)
    np.testing.assert_allclose(-below["velocity"], above["velocity"], atol=1e-10)
    assert np.ptp(below["displacement"].values) > 0.2


def test_flat_together_they_pull_twice_as_much_as_one():
    single, double = (ConeModel(**MEMBRANE, spring_stiffness=0.0, **more) for more in ({}, {"second_film": "membrane"}))
    x, v = np.array([-0.7, -0.3, 0.2, 0.5, 0.6]), 0.3
    np.testing.assert_allclose(double.force(x, v), 2.0 * single.force(x, v), rtol=1e-12)


def test_a_double_cone_rests_in_its_middle_and_is_pulled_to_the_film_without_a_voltage():
    rest = static(model("double", voltage=0.0))["rest_displacement"].item()
    assert rest == pytest.approx(0.55, abs=1e-9)
    constant = model("double", voltage=0.4, second_drive="constant", second_voltage=0.0)
    place = static(constant, [0.4])["displacement"]
    assert place.size
    found = static(constant, [0.4]).isel(constant_voltage=0)
    stable = found["equilibrium_displacement"].values[found["stable"].values == 1]
    assert stable.min() > 0.56  # the first film weakens, and the second one pulls the disc up to its own plane


@pytest.mark.parametrize("load", ["double", "spring"])
def test_equal_bits_on_other_threads(load):
    several = model(load, voltage=np.linspace(0.05, 0.35, 7))
    times = np.linspace(0.0, 40.0, 41)
    one, three = (simulate(several, (0.45, 0.0), times=times, threads=count) for count in (1, 3))
    assert one.identical(three)


def test_the_kind_of_motion_of_a_double_cone_is_found():
    found = regime(model("opposite"), (0.45, 0.0))
    assert int(found["outcome"]) == Outcome.OK
    assert found["period"].item() == 1
