"""Natural frequencies of an oscillator with a known stiffness."""

import numpy as np
import pytest
from scipy.optimize import brentq

import gelcone
from gelcone.motion.natural import STIFFNESS_ROUNDING, driven_frequency, frequency_of, natural_frequency
from gelcone.motion.plane import Plane
from gelcone.motion.static_limits import static_curves
from gelcone.physics.bias import LinearSpring, Together
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.model import ConeModel
from tests.toys import TurningBias


def test_the_frequency_is_the_root_of_the_stiffness_and_unknown_where_it_is_negative():
    """A stiffness that is negative by rounding is that of a fold."""
    found = frequency_of(np.array([4.0, 0.25, 0.0, -0.5 * STIFFNESS_ROUNDING, -2.0 * STIFFNESS_ROUNDING, -1.0, np.nan]))
    np.testing.assert_array_equal(found, [2.0, 0.5, 0.0, 0.0, np.nan, np.nan, np.nan])
    assert frequency_of(9.0) == 3.0


def test_a_flat_film_softens_with_the_square_of_the_voltage_until_its_pitchfork():
    """By V^2 of the stiffness at rest, whichever its sign."""
    model = gelcone.ConeModel(spring_stiffness=0.5, hoop_prestretch=1.3, stretch_limit=8.0)
    stiffness = float(model.stiffness(0.0))
    for share in (0.0, 0.5, 0.9):
        volts = share * np.sqrt(stiffness)
        for sign in (1.0, -1.0):
            expected = np.sqrt(stiffness - volts**2)
            assert float(natural_frequency(model, sign * volts, 0.0)) == pytest.approx(expected, rel=1e-9)
            assert float(natural_frequency(model, sign * volts)) == pytest.approx(expected, rel=1e-6)
    assert np.isnan(natural_frequency(model, 1.01 * np.sqrt(stiffness), 0.0))
    both = natural_frequency(model, np.array([0.0, 0.1]))
    np.testing.assert_allclose(both, np.sqrt(stiffness - np.array([0.0, 0.01])), rtol=1e-6)


def test_a_raised_disc_oscillates_about_where_the_voltage_holds_it():
    """By differences of the force at its root, which the voltage moves."""
    model = gelcone.ConeModel(spring_stiffness=2.0, rest_height=0.6, hoop_prestretch=1.3, stretch_limit=8.0)
    volts, step = np.array([0.0, 0.3, 0.5, -0.5]), 1e-5
    found = natural_frequency(model, volts)
    assert found.shape == volts.shape
    for own, v in zip(found, volts, strict=True):
        x = brentq(lambda x, v=v: float(model.force(x, v)), 0.1, 1.5, xtol=1e-13)
        slope = (float(model.force(x + step, v)) - float(model.force(x - step, v))) / (2.0 * step)
        assert own == pytest.approx(np.sqrt(slope), rel=1e-5)
        assert natural_frequency(model, v, x) == pytest.approx(np.sqrt(slope), rel=1e-6)
    assert found[0] > found[1] > found[2] == found[3]


# --- films that creep, and circuits -----------------------------------------------------------------------------------

TAUT = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.02, "voltage_bias": 0.6}
CREEP = {"viscous_modulus_1": 0.4, "relaxation_time_1": 0.7}
DEVICES = {
    "elastic": {},
    "creeping": CREEP,
    "filter": {"circuit": "amplifier", "filter_time": 0.3},
    "resistance": {"series_resistance": 0.5},
    "creeping behind a resistance that leaks": {**CREEP, "series_resistance": 0.2, "leakage_time": 40.0},
    "own bias with a quicker wheel": {
        "bias": Together((LinearSpring(), TurningBias())),
        "wheel_turning": 9.0,
    },
}


def peak_of(model):
    """The frequency of the largest displacement under a small force, on a fine grid: gains of circuits are left out."""
    space = gelcone.state_space(model, inputs=("force",))
    omega = np.linspace(1.2, 2.2, 100_001)
    return omega[np.abs(space.transfer(omega)[:, 0, 0]).argmax()]


@pytest.mark.parametrize("name", DEVICES)
def test_the_disc_resonates_at_its_natural_frequency(name):
    """The peak lies below it by the damping of the pair, sqrt(1 - 2 zeta^2), up to the relaxation near it."""
    model = ConeModel(**{**TAUT, **DEVICES[name]})
    space = gelcone.state_space(model)
    values = np.linalg.eigvals(space.A)
    near = values[np.argmin(np.abs(np.abs(values.imag) - peak_of(model)))]
    found = natural_frequency(model, 0.6, space.place)
    assert found == pytest.approx(np.abs(near), rel=1e-9)
    loss = abs(near.real) / np.abs(near)
    assert peak_of(model) == pytest.approx(found * np.sqrt(1.0 - 2.0 * loss**2), rel=2e-2 * loss + 1e-5)


@pytest.mark.parametrize("name", ["elastic", "filter"])
def test_without_a_branch_or_a_loaded_circuit_it_is_the_root_of_the_stiffness(name):
    model = ConeModel(**{**TAUT, **DEVICES[name]})
    expected = frequency_of(model.stiffness(gelcone.state_space(model).place, 0.6))
    assert natural_frequency(model, 0.6) == pytest.approx(expected, rel=1e-12)


def test_branches_stiffen_the_film_from_relaxed_to_held():
    """Slow branches have no time to relax, quick ones all; between them the frequency rises with the time."""
    still = {"viscous_modulus_1": 0.4, **TAUT}
    found = [float(natural_frequency(ConeModel(relaxation_time_1=t, **still), 0.6)) for t in (1e-3, 0.3, 1.0, 1e4)]
    model = ConeModel(relaxation_time_1=1e4, **still)
    relaxed = float(frequency_of(model.stiffness(gelcone.state_space(model).place, 0.6)))
    held = films_at_once(model, np.array([gelcone.state_space(model).rest]))
    assert found == sorted(found)
    assert found[0] == pytest.approx(relaxed, rel=1e-3)
    assert found[-1] == pytest.approx(np.sqrt(held.stiffness(gelcone.state_space(model).place, 0.6).item()), rel=1e-4)


@pytest.mark.parametrize("name", ["filter", "own bias with a quicker wheel"])
def test_an_overdamped_disc_has_the_frequency_without_damping(name):
    """Not that of a state that oscillates without the disc."""
    model = ConeModel(**{**TAUT, **DEVICES[name], "damping_ratio": 5.0})
    expected = frequency_of(model.stiffness(gelcone.state_space(model).place, 0.6))
    assert natural_frequency(model, 0.6) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["creeping", "resistance"])
def test_data_sheet_transfer_envelope_and_driven_motion_have_one_natural_frequency(name):
    model = ConeModel(**{**TAUT, **DEVICES[name]}, voltage=0.0)
    expected = natural_frequency(model, [0.0, 0.6])
    sheet = gelcone.datasheet(model.replace(voltage=0.1), [0.6])
    np.testing.assert_allclose(sheet["natural_frequency"], expected, rtol=1e-9)
    np.testing.assert_allclose(gelcone.transfer(model, amplitudes=0.0)["natural_frequency"], expected[1], rtol=1e-9)
    assert driven_frequency(model) == pytest.approx(expected[1], rel=1e-9)
    plane = Plane.of(model, None)
    curves = static_curves(plane, 0.6)
    np.testing.assert_allclose(curves["natural_frequency"][[0, -1]], expected, rtol=1e-9)
    assert np.abs(np.log(plane.default_frequencies() / expected[1])).min() < 0.02


def test_films_in_opposite_phase_behind_resistances_have_their_own_voltages():
    """A symmetric double cone oscillates alike if its films exchange their voltages, 0.8 and 0.4 about 0.6."""
    films = {"second_film": "taut", "second_flat_height": 1.2, "hoop_prestretch": 1.4, "rest_height": 0.6, **CREEP}
    model = ConeModel(second_drive="opposite", series_resistance=0.3, voltage=0.0, voltage_bias=0.6, **films)
    one, other, both = natural_frequency(model, [0.8, 0.4, 0.6])
    assert one == pytest.approx(other, rel=1e-9)
    assert one != pytest.approx(both, rel=1e-4)
    assert both == pytest.approx(driven_frequency(model), rel=1e-9)
