"""Statics under a commanded voltage: films between command and rest, forces, slopes and losses."""

import numpy as np
import pytest

import gelcone
from gelcone.physics import commanded as commanded_module
from gelcone.physics.balance import PullIn, rest_of, single_balance
from gelcone.physics.commanded import (
    CommandedBalance,
    command_at,
    commanded_balance,
    rest_at_command,
    voltage_under,
)
from gelcone.physics.model import ConeModel

TAUT = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "spring_stiffness": 1.5}
LEAK = {"series_resistance": 3.0, "leakage_time": 12.0}


def leaking(**more):
    return ConeModel(voltage=0.2, **TAUT, **LEAK, **more)


def test_a_film_that_leaks_divides_the_voltage_with_the_resistance_in_front():
    """The film of the capacitance 1 + x^2 leaks through leakage_time/(1 + x^2)."""
    model = leaking()
    n, line = model.own_numbers, model.system.lines[0]
    assert not rest_at_command(model.system, n)
    x, v = np.array([0.0, 0.4, 1.3]), np.array([0.3, 0.9, 0.1])
    command = command_at(model.system, line, x, v, n)
    np.testing.assert_allclose(command, v * (1.0 + 3.0 * (1.0 + x * x) / 12.0), rtol=1e-12)
    np.testing.assert_allclose(voltage_under(model.system, line, x, command, n), v, rtol=1e-12)
    np.testing.assert_allclose(voltage_under(model.system, line, x, -command, n), v, rtol=1e-12)
    assert np.isnan(voltage_under(model.system, line, np.nan, 0.5, n))


def test_a_film_that_rests_at_the_command_has_the_balance_of_the_film():
    model = ConeModel(voltage=0.2, **TAUT, series_resistance=3.0)
    n = model.own_numbers
    assert rest_at_command(model.system, n)
    assert type(commanded_balance(model.system, n)) is type(single_balance(model.system, n))
    assert voltage_under(model.system, model.system.lines[0], 0.4, -0.7, n) == 0.7
    assert isinstance(commanded_balance(leaking().system, leaking().own_numbers), CommandedBalance)


def test_force_slope_and_equilibrium_are_those_at_the_voltage_on_the_film():
    model = leaking()
    n = model.own_numbers
    held, under = single_balance(model.system, n), commanded_balance(model.system, n)
    x, h = np.array([0.3, 0.7]), 1e-5
    ratio = 1.0 + 3.0 * (1.0 + x * x) / 12.0
    np.testing.assert_allclose(under.force(x, (0.6 * ratio) ** 2), held.force(x, 0.36), rtol=1e-11)
    np.testing.assert_allclose(under.squared(x), held.squared(x) * ratio**2, rtol=1e-11)
    between = (under.force(x + h, 0.5) - under.force(x - h, 0.5)) / (2.0 * h)
    np.testing.assert_allclose(under.slope(x, 0.5), between, rtol=1e-8)
    rise = (under.squared(x + h) - under.squared(x - h)) / (2.0 * h)
    # at an equilibrium the stiffness is the slope of the command along the branch, times the pull of the voltage
    at = under.squared(x)
    pull = (under.force(x, at * (1.0 + 1e-6)) - under.force(x, at * (1.0 - 1e-6))) / (2e-6 * at)
    np.testing.assert_allclose(under.slope(x, at), -pull * rise, rtol=1e-6)


def test_where_the_command_turns_is_where_the_force_at_a_constant_command_does():
    """At an equilibrium x dF/dx - F is x dF/dx, with the slope that the leak changes as the disc moves."""
    model = leaking().replace(leakage_time=2.0)
    balance = commanded_balance(model.system, model.own_numbers)
    x, h = np.array([-1.2, -0.9, 0.6, 0.8, 1.3]), 1e-5
    squared = balance.squared(x)
    assert (squared > 0.0).all()
    slope = (balance.force(x + h, squared) - balance.force(x - h, squared)) / (2.0 * h)
    np.testing.assert_allclose(balance.turning(x), x * slope, rtol=1e-6)


class Divider(gelcone.Circuit):
    name = "divider"

    def voltage(self, port, y, n, xp=None):
        return 0.5 * port.command

    def gain(self, frequency, n):
        return 0.5 + 0.0j


def test_behind_a_circuit_that_halves_the_voltage_a_film_is_as_under_half_of_it():
    plain, halved = ConeModel(**TAUT), ConeModel(**TAUT, circuit=Divider())
    levels = np.array([0.2, 0.8, 1.6])
    behind, alone = gelcone.static(halved, levels), gelcone.static(plain, levels / 2.0)
    np.testing.assert_allclose(behind["equilibrium_displacement"], alone["equilibrium_displacement"], rtol=1e-9)
    np.testing.assert_allclose(behind["pull_in_voltage"], 2.0 * alone["pull_in_voltage"], rtol=1e-9)
    n = halved.own_numbers
    assert command_at(halved.system, halved.system.lines[0], 0.3, 0.7, n) == pytest.approx(1.4)


def test_slopes_of_a_pair_are_those_of_its_force_also_where_the_opposite_command_is_below_zero():
    model = leaking(second_film="taut", second_flat_height=1.5, second_drive="opposite", voltage_bias=0.3)
    under, x, h = commanded_balance(model.system, model.own_numbers), 0.6, 1e-5
    for command in (0.5, 0.9):  # that of the second film is 0.6 less the first
        force, slope, gain = under._slopes(x, command)
        assert force == float(under.force(x, command**2))
        between = (under.force(x + h, command**2) - under.force(x - h, command**2)) / (2.0 * h)
        assert slope == pytest.approx(float(between), rel=1e-7)
        between = (under.force(x, (command + h) ** 2) - under.force(x, (command - h) ** 2)) / (2.0 * h)
        assert gain == pytest.approx(float(between), rel=1e-7)


@pytest.mark.parametrize(("law", "kind"), [("gent", PullIn.NEVER), ("neo-hookean", PullIn.SEARCH_RANGE)])
def test_a_disc_that_no_command_in_reach_releases_is_stable_to_the_end_of_the_search(law, kind):
    for more in ({}, {"current_limit": 0.03}):
        model = leaking(law=law, **more)
        loss = commanded_balance(model.system, model.own_numbers).jump(0.8)
        assert (loss.voltage, loss.kind) == (np.inf, kind)


CAPPED = {"hoop_prestretch": 1.4, "damping_ratio": 0.25, **LEAK}


@pytest.mark.parametrize("leak", [{}, {"leakage_field": 0.5}])
@pytest.mark.parametrize("rest", [0.0, 0.8, -0.6])
@pytest.mark.parametrize("limit", [0.05, 0.1, 0.2])
def test_beyond_the_limit_of_the_current_the_disc_rests_where_the_leak_takes_all_of_it(limit, rest, leak):
    """At one place for all higher commands; nothing is lost there, and a run rests there too."""
    model = ConeModel(voltage=0.0, voltage_bias=4.0, rest_height=rest, current_limit=limit, **CAPPED, **leak)
    balance, n = commanded_balance(model.system, model.own_numbers), model.own_numbers
    at_rest = rest_of(balance, None)
    places = balance.along_ramp(at_rest, np.array([4.0, 40.0, 4e6]) ** 2)[0]
    np.testing.assert_allclose(places, places[0], rtol=1e-12, atol=1e-15)
    assert [(loss.voltage, loss.kind) for loss in balance.losses(at_rest)][-1] == (np.inf, PullIn.NEVER)
    assert balance.folds() == []
    place, command, slope = (row[~np.isnan(row)] for row in np.concatenate(balance.curves(9.0), axis=1))
    at = np.flatnonzero((np.abs(place - places[0]) < 1e-12) & (command == 9.0))
    assert (slope[at] > 0.0).all()
    assert at.size
    v = np.sqrt(balance.films(places[:1], np.array([16.0]))[0])
    commands = command_at(model.system, model.system.lines[0], places[0], v * np.array([1.0 - 1e-9, 1.0 + 1e-9]), n)
    np.testing.assert_allclose(commands, [v[0] + LEAK["series_resistance"] * limit, np.inf], rtol=1e-7)
    run = gelcone.integrate(model, (places[0] + 1e-3, 0.0), [4000.0]).states[0, -1]
    np.testing.assert_allclose(run[0], places[0], atol=1e-8)
    h = 1e-5
    force = balance.force(places[0] + np.array([-h, h]), 16.0)
    assert balance.slope(places[0], 16.0) == pytest.approx((force[1] - force[0]) / (2.0 * h), rel=1e-5)


def test_at_once_a_creeping_membrane_pulls_in_alike_behind_a_resistance_without_leak_to_speak_of():
    """Held at its states it hangs loose in the flat state and has no charge there, hence no command."""
    film = {"film": "membrane", "prestretch": 1.5, "prestretch_mode": "equibiaxial", "radius_ratio": 0.2}
    branch = {"viscous_modulus_1": 0.5, "relaxation_time_1": 10.0}
    drive = {"damping_ratio": 0.02, "spring_stiffness": 0.9, "rest_height": 0.8}
    alone = ConeModel(**film, **branch, **drive)
    source = alone.replace(circuit="amplifier", series_resistance=0.05)
    found = [
        gelcone.limits(model, at_once=True)
        for model in (alone, source.replace(leakage_time=1e12), source.replace(leakage_time=9.0))
    ]
    free, led, leaking = (one.pull_in_voltage.item() for one in found)
    assert [int(one.pull_in_kind) for one in found] == [PullIn.FILM] * 3
    assert led == pytest.approx(free, rel=1e-9)
    assert 1.001 * led < leaking < 1.05 * led


def test_a_ramp_of_commands_takes_no_search_for_the_voltage_on_the_film(monkeypatch):
    """The command of each equilibrium is explicit."""
    model = leaking()
    balance = commanded_balance(model.system, model.own_numbers)
    rest, squared = rest_of(balance, None), np.array([0.01, 0.1, 0.3])

    def searched(*given):
        raise AssertionError("searched")

    assert balance.lifted
    with monkeypatch.context() as patch:
        patch.setattr(commanded_module, "voltage_under", searched)
        place, losses = balance.along_ramp(rest, squared)
    np.testing.assert_allclose(balance.force(place, squared), 0.0, atol=1e-13)
    assert losses.tolist() == [0, 0, 0]
