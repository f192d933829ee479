"""The membrane that creeps: its reduced form against branches in every ring, one energy, relaxed and loose films."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone import ConeModel, simulate
from gelcone.codes import Outcome
from gelcone.motion.flow import integrate

GEL = {"prestretch": 1.2, "prestretch_mode": "equibiaxial", "radius_ratio": 0.2}
BRANCH = {"viscous_modulus_1": 0.5, "relaxation_time_1": 10.0}


def model_of(**changes):
    own = {"damping_ratio": 0.02, "spring_stiffness": 0.9, "rest_height": 0.8, "voltage": 0.45, "drive_frequency": 0.5}
    return ConeModel(film="membrane", **(GEL | own | BRANCH | changes))


def numbers_of(model):
    return model.system.film, model.own_numbers


@pytest.mark.parametrize(
    ("x", "squared", "y"), [(0.4, 0.2, [0.9, 1.02]), (0.7, 0.3, [0.6, 1.1]), (0.2, 0.0, [1.0, 1.0])]
)
def test_the_force_is_the_slope_of_the_energy_and_flow_loses_what_it_dissipates(x, squared, y):
    film, n = numbers_of(model_of())
    h = 1e-4
    force, slope = film.force(x, squared, y, n)
    energy = [film.work(x + step, squared, y, n) for step in (-h, h)]
    forces = [film.force(x + step, squared, y, n)[0] for step in (-h, h)]
    assert force == pytest.approx((energy[1] - energy[0]) / (2.0 * h), rel=1e-6)
    assert slope == pytest.approx((forces[1] - forces[0]) / (2.0 * h), rel=1e-6)
    rates = film.rates(x, 0.0, squared, y, n)
    lost = 0.0
    for k, rate in enumerate(rates):
        up, down = list(y), list(y)
        up[k], down[k] = y[k] + h, y[k] - h
        lost -= rate * (film.work(x, squared, up, n) - film.work(x, squared, down, n)) / (2.0 * h)
    assert film.dissipation(x, 0.0, squared, y, n) == pytest.approx(lost, rel=1e-6)


@pytest.mark.parametrize("changes", [{}, {"prestretch": 1.0, "rest_height": 0.25, "spring_stiffness": 0.5}])
def test_at_a_constant_voltage_the_source_gives_the_voltage_times_the_charge(changes):
    model = model_of(voltage=0.0, voltage_bias=0.2, **changes)
    result = simulate(model, initial=(0.9, 0.0), times=np.linspace(0.0, 20.0, 41))
    film, n = numbers_of(model)
    y = [result[state.name].values for state in film.states]
    charge = 0.2 * np.array(film.capacitance(result.displacement.values, 0.04, y, n))
    moved = result.dissipated_energy.values[-1]
    assert result.outcome == Outcome.OK
    if changes:
        assert result.film_state_slack > 0.1  # and hung loose for a while
    np.testing.assert_allclose(result.supplied_energy, 0.2 * (charge - charge[0]), rtol=0.0, atol=1e-9 * moved)


def test_the_engine_follows_the_same_motion_as_scipy_through_loose_states():
    model = model_of(prestretch=0.9, flow="linear", voltage=0.3, rest_height=0.25, spring_stiffness=0.5)
    times, start = np.linspace(0.0, 2.0, 9), (0.9, 0.0)
    run = integrate(model, start, times, tolerance=1e-13)
    film, n = numbers_of(model)

    def rates(time, state):
        squared = float(model.system.waveform.voltage(time, n)) ** 2
        own = {**n, **film.switches(state[0], squared, list(state[2:]), n)}
        return [float(value) for value in model.system.rates(time, list(state), own, np)]

    z0 = run.states[0, 0]
    found = solve_ivp(rates, (0.0, times[-1]), z0, method="DOP853", rtol=1e-7, atol=1e-9, t_eval=times)
    assert run.outcome[0] == Outcome.OK
    loose = [film.switches(z[0], 0.0, list(z[2:]), n)["in_tension"] < 0.0 for z in run.states[0]]
    assert 0 < sum(loose) < len(loose)
    np.testing.assert_allclose(run.states[0].T, found.y, rtol=0.0, atol=1e-6)
