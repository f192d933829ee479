"""A system that another program drives: held and ramped inputs, its own drive inside, and where a film breaks down."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.physics.drive import PIECE
from gelcone.physics.driven import DRIVE_PIECE, INPUTS, PHASE, STRENGTH_SQUARED, driven
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import WAVEFORMS

MODEL = ConeModel(
    film="taut", voltage=0.5, voltage_bias=0.2, drive_frequency=0.7, rest_height=0.6, hoop_prestretch=1.2,
    damping_ratio=0.1, dielectric_strength=3.0,
)  # fmt: skip
Z = [np.array([0.4, 0.7]), np.array([0.3, -0.2])]
GIVEN = {"input_voltage": 0.3, "input_voltage_rate": 0.25, "input_force": 0.15, "input_force_rate": -0.4}


def numbers_of(system, values, **own):
    return {**system.numbers_of(values), **own}


def test_inputs_stand_for_a_voltage_and_a_force_that_change_at_their_rates():
    """The disc of the same model under that constant voltage, and the force over the mass, 1, besides."""
    system = driven(MODEL.system)
    n = numbers_of(system, MODEL.values, **GIVEN)
    for tau in (0.0, 0.8):
        volts = 0.3 + 0.25 * tau
        held = MODEL.replace(voltage=0.0, voltage_bias=volts)
        exact = held.system.rates(0.0, Z, held.own_numbers, np)
        found = system.rates(tau, Z, n, np)
        np.testing.assert_allclose(found[0], exact[0], rtol=1e-14)
        np.testing.assert_allclose(found[1] - exact[1], 0.15 - 0.4 * tau, rtol=1e-12)
        assert system.waveform.voltage(tau, n) == pytest.approx(volts)
        assert system.waveform.voltage_rate(tau, n) == pytest.approx(0.25)


@pytest.mark.parametrize("name", [name for name in WAVEFORMS if name != "half_wave"])
def test_a_drive_inside_goes_on_from_the_phase_at_which_a_step_begins_and_the_input_is_added(name):
    model = MODEL.replace(waveform=name)
    own, n = model.system.waveform, model.own_numbers
    system = driven(model.system, inside=True)
    started = 1.3 / 0.7
    given = {**GIVEN, PHASE: 1.3}
    if own.pieced:  # the numbers of the piece in which the step lies
        piece = own._place(np.asarray(1.3), n)
        given |= dict(zip(DRIVE_PIECE, [piece["since"], *(piece[name] for name in PIECE[1:])], strict=True))
    taken = numbers_of(system, model.values)
    assert {INPUTS[0], PHASE} <= taken.keys()
    assert (DRIVE_PIECE[1] in taken) == own.pieced
    assert sorted(taken) == sorted(system.numbers)  # those of a piece by their names as inputs alone
    assert not taken.keys() & set(PIECE)
    taken |= given
    for tau in (0.0, 1e-3):
        exact = own.voltage(started + tau, n) + 0.3 + 0.25 * tau
        assert float(system.waveform.voltage(tau, taken)) == pytest.approx(float(exact), abs=1e-12)
        rate = float(own.voltage_rate(started + tau, n)) + 0.25
        assert float(system.waveform.voltage_rate(tau, taken)) == pytest.approx(rate, abs=1e-12)


def test_a_drive_whose_corners_move_with_the_voltage_is_left_outside():
    with pytest.raises(InputError, match="waveform = half_wave: its corners move with the voltage"):
        driven(MODEL.replace(waveform="half_wave").system, inside=True)


def test_a_film_breaks_down_where_its_true_field_is_the_strength():
    """E = v q^(1/2) of a taut film; the border of breakdown is the last."""
    system = driven(MODEL.system, breaks_down=True)
    assert system.numbers[-1] == STRENGTH_SQUARED
    assert STRENGTH_SQUARED not in driven(MODEL.system).numbers
    n = numbers_of(system, MODEL.values, input_voltage=1.7, input_voltage_rate=0.5)
    assert n[STRENGTH_SQUARED] == 9.0
    place, border = system.borders[-1]
    assert (place, border.switch, len(system.borders)) == (None, None, len(MODEL.system.borders) + 1)
    left = border.value(0.6, [np.array([0.4, 1.2, 1.4]), np.zeros(3)], n, np)
    np.testing.assert_allclose(left, 9.0 - 2.0**2 * (1.0 + np.array([0.4, 1.2, 1.4]) ** 2), rtol=1e-12)
    double = MODEL.replace(second_film="taut", second_flat_height=1.0, second_drive="opposite")
    two = driven(double.system, breaks_down=True)
    n = numbers_of(two, double.values, input_voltage=1.7, input_voltage_rate=0.5)
    values = [border.value(0.6, [np.array([0.4]), np.array([0.0])], n, np) for _, border in two.borders[-2:]]
    np.testing.assert_allclose(
        np.ravel(values), [9.0 - 4.0 * 1.16, 9.0 - (0.4 - 2.0) ** 2 * (1.0 + 0.6**2)], rtol=1e-12
    )
