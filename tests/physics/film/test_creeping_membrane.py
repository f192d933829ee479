"""The membrane that creeps: its reduced form against branches in every ring, one energy, relaxed and loose films."""

from types import SimpleNamespace

import numpy as np
import pytest
from creeping_membrane import relaxation
from scipy.integrate import solve_ivp

from gelcone import ConeModel, InputError, simulate
from gelcone.codes import Outcome
from gelcone.membrane.gel import Gel
from gelcone.membrane.mean_length import mean_length
from gelcone.motion.flow import integrate
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.film.branches import Branches
from gelcone.physics.film.creeping_membrane import CreepingMembrane
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.statics import balances_of
from tests.physics.film.programs import in_program

GEL = {"prestretch": 1.5, "prestretch_mode": "equibiaxial", "radius_ratio": 0.2}
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


LOOSE = {"prestretch": 1.0, "rest_height": 0.25, "spring_stiffness": 0.5}
"""A film that hangs loose for a while as its disc comes back."""


@pytest.mark.usefixtures("undelivered")
def test_at_a_constant_voltage_the_source_gives_the_voltage_times_the_charge():
    model = model_of(voltage=0.0, voltage_bias=0.2, **LOOSE)
    result = simulate(model, initial=(0.9, 0.0), times=np.linspace(0.0, 20.0, 41))
    film, n = numbers_of(model)
    y = [result[state.name].values for state in film.states]
    charge = 0.2 * np.array(film.capacitance(result.displacement.values, 0.04, y, n))
    moved = result.dissipated_energy.values[-1]
    assert result.outcome == Outcome.OK
    assert result.film_state_slack > 0.1
    np.testing.assert_allclose(result.supplied_energy, 0.2 * (charge - charge[0]), rtol=0.0, atol=1e-9 * moved)


def test_the_engine_follows_the_same_motion_as_scipy_through_loose_states():
    model = model_of(voltage=0.3, **LOOSE)
    times, start = np.linspace(0.0, 2.0, 9), (0.9, 0.0)
    run = integrate(model, start, times, keep="work")  # the program of the test above
    film, n = numbers_of(model)

    def rates(time, state):
        squared = float(model.system.waveform.voltage(time, n)) ** 2
        own = {**n, **film.switches(state[0], squared, list(state[2:]), n)}
        return [float(value) for value in model.system.rates(time, list(state), own, np)]

    z0 = run.states[0, 0]
    found = solve_ivp(rates, (0.0, times[-1]), z0, method="DOP853", rtol=1e-8, atol=1e-10, t_eval=times)
    assert run.outcome[0] == Outcome.OK
    loose = [film.switches(z[0], 0.0, list(z[2:]), n)["in_tension"] < 0.0 for z in run.states[0]]
    assert 0 < sum(loose) < len(loose)
    np.testing.assert_allclose(run.states[0].T, found.y, rtol=0.0, atol=1e-6)


def test_it_relaxes_like_a_membrane_with_branches_in_every_ring():
    film = MembraneFilm()
    gel = Gel(film.law, film.law.numbers({"stretch_limit": 50.0}), 2.25, 2.25)
    full, reduced = relaxation(gel, 0.2, 0.5, 0.3, 0.5)
    assert full[0] > 1.08 * full[-1]  # and the branch carries a part of the load at first
    np.testing.assert_allclose(reduced, full, rtol=5e-3)
    np.testing.assert_allclose(reduced[-1], full[-1], rtol=1e-3)


def test_a_relaxed_film_is_the_membrane_and_statics_at_once_hold_the_branches():
    model = model_of(voltage=0.0)
    film, n = numbers_of(model)
    relaxed = film.starts(0.6, n)  # rested flat
    assert relaxed == [1.0, 1.0]
    raised = model_of(rested="raised").system.film
    at_rest = raised.starts(0.6, n)
    assert film.force(0.6, 0.25, at_rest, n)[0] == pytest.approx(film.force(0.6, 0.25, [], n)[0], rel=1e-12)
    assert film.force(0.65, 0.25, at_rest, n)[0] > 1.01 * film.force(0.65, 0.25, [], n)[0]
    (balance,) = balances_of(films_at_once(model))
    ((rest,),) = balance.equilibria(np.array([0.25]))
    x = rest.displacement
    assert film.force(x, 0.25, relaxed, n)[0] == pytest.approx(0.9 * (0.8 - x), rel=1e-9)


def test_a_second_membrane_creeps_as_the_first():
    model = model_of(second_film="membrane", second_flat_height=0.9)
    assert [state.name for state in model.system.states][2:] == [
        "viscous_meridional_1", "viscous_hoop_1", "second_viscous_meridional_1", "second_viscous_hoop_1",
    ]  # fmt: skip


def test_branches_without_states_are_refused():
    with pytest.raises(InputError, match="relaxation_time_1 takes its states in a membrane; take the taut film"):
        model_of(relaxation_time_1=0.01, reduced="relaxation_time_1")


@pytest.mark.parametrize("prestretch_mode", ["equibiaxial", "radial"])
def test_a_program_that_begins_with_a_loose_film_finds_its_natural_height(prestretch_mode):
    """Where the branches have crept far above the disc: a run may begin so, or be resumed. Arrays bracket that height,
    and a program comes to it by Newton's method from above."""
    own = {"prestretch": 1.0 if prestretch_mode == "equibiaxial" else 1.5, "prestretch_mode": prestretch_mode}
    film, n = numbers_of(model_of(**own))
    random = np.random.default_rng(8)
    x, squared = random.uniform(0.02, 0.8, 600), random.uniform(0.0, 0.4, 600)
    y = [random.uniform(0.5, 0.9, 600), random.uniform(0.95, 1.05, 600)]
    signs = film.switches(x, squared, y, n)
    loose = (signs["in_tension"] < 0.0) & np.isfinite(film.force(x, squared, y, n)[0])
    assert loose.sum() > 30
    table = np.array(list(signs.values())).T
    for row in np.unique(table[loose], axis=0):
        here = loose & (table == row).all(axis=1)
        at = x[here], squared[here], [value[here] for value in y]
        (found,) = in_program(film._place, n, dict(zip(signs, row, strict=True)), *at)
        np.testing.assert_allclose(found, film._place(*at, n), rtol=1e-9)


class Relaxed:
    """A relaxed film of formulas: k = 0.2 + 0.5 s - V, whose V at a pull is known."""

    viscous = Branches(1, "log", 1, True)
    switch_names = ("near",)

    def relaxed_pull(self, s, squared, n, xp=np):
        k = 0.2 + 0.5 * s - squared
        return SimpleNamespace(k=k, by_s=0.5 + 0.0 * s), 1.0

    def balancing(self, x, pull, n):
        return 0.2 + 0.5 * np.square(x) - pull

    def highest_squared(self, x, n):
        return 7.0 + x


MADE = {
    "mean_begin": 0.04, "mean_scale": 0.5, "mean_length_0": 0.4, "mean_length_1": 0.1, "mean_length_2": 0.02,
    **{f"mean_length_{k}": 0.0 for k in range(3, 7)},
    "reach_squared": 9.0, "viscous_modulus_1": 0.6, "flow_rate_1": 0.5, "inverse_viscous_limit_1": 0.05,
}  # fmt: skip


def test_a_film_of_formulas_pulls_with_its_branches_by_the_slope_of_their_length():
    """K = k + M' t1/M; its slope by differences; the V of a pull, and the height at which a loose film hangs."""
    film, s, y, h = CreepingMembrane(Relaxed()), np.array([0.2, 0.6, 1.4]), [0.9, 1.1], 1e-5
    (length, slope, _), over = mean_length(s, MADE), Relaxed.viscous.pull(mean_length(s, MADE)[0], y, MADE)[0]
    k, by_s = film.pull(s, 0.3, y, MADE)
    np.testing.assert_allclose(k, 0.2 + 0.5 * s - 0.3 + slope * over)
    assert (np.abs(slope - 1.0) > 0.05).all()
    assert (np.abs(over) > 1e-3).all()
    np.testing.assert_allclose(by_s, (film.pull(s + h, 0.3, y, MADE)[0] - film.pull(s - h, 0.3, y, MADE)[0]) / (2 * h))
    force, stiffness = film.force(np.sqrt(s), 0.1, y, MADE, np)
    np.testing.assert_allclose(force, np.sqrt(s) * film.pull(s, 0.1, y, MADE)[0])
    x = np.sqrt(s)
    ahead, behind = (film.force(x + d, 0.1, y, MADE, np)[0] for d in (h, -h))
    np.testing.assert_allclose(stiffness, (ahead - behind) / (2.0 * h), rtol=1e-6)
    for pull in (0.0, 0.15):
        squared = film.balancing(x, pull, y, MADE)
        np.testing.assert_allclose(film.pull(s, squared, y, MADE)[0], pull, atol=1e-12)
    (low, steep, _), below = mean_length(np.array(0.04), MADE), np.array([0.0, 0.1, 0.19])
    more = steep * Relaxed.viscous.pull(low, y, MADE)[0]  # below its begin its branches are as long as there
    np.testing.assert_allclose(film.balancing(below, 0.15, y, MADE), 0.2 + 0.5 * below**2 - 0.15 + more)
    np.testing.assert_array_equal(film.highest_squared(x, y, MADE), 7.0 + x)
    assert length.min() > 1.0


def test_a_loose_film_hangs_where_it_pulls_nothing_also_below_the_height_at_which_it_begins_to_pull():
    """At a voltage at which it pulls from some height on; lower discs leave its lengths as they are."""
    film, y, squared = CreepingMembrane(Relaxed()), [0.7, 1.0], 0.6
    s = np.array([0.0, 0.01, 0.03, 0.3, 3.0])
    at, pulls = film.place(s, squared, y, MADE)
    assert pulls.tolist() == [0.0, 0.0, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(at[:4], at[0])
    assert at[4] == 3.0
    assert film.pull(at[0], squared, y, MADE)[0] == pytest.approx(0.0, abs=1e-12)
    lengths, width = film.lengths(np.sqrt(s), squared, y, MADE)
    np.testing.assert_allclose(lengths, mean_length(at, MADE)[0])
    assert width == 1.0
    np.testing.assert_array_equal(film.force(np.sqrt(s[:4]), squared, y, MADE, np), 0.0)
    strong = film.place(np.array([0.0, 0.03, 0.05]), 0.0, [0.99, 1.0], MADE)  # it pulls wherever it may
    np.testing.assert_allclose(strong[0], [0.04, 0.04, 0.05])
    assert strong[1].tolist() == [0.0, 0.0, 1.0]


def test_a_film_with_stiff_branches_that_crept_at_its_reach_hangs_loose_next_to_it():
    """Its natural height, where K = 0, is found over all that the membrane reaches."""
    film, own = CreepingMembrane(Relaxed()), MADE | {"viscous_modulus_1": 5000.0, "inverse_viscous_limit_1": 0.0}
    y = [1.0 / mean_length(np.array(8.7), own)[0], 1.0]
    at, pulls = film.place(np.array([0.0, 1.0, 8.0]), 0.1, y, own)
    assert pulls.tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(at, at[0], rtol=1e-12)
    assert 8.3 < at[0] < 8.7
    assert film.pull(at[0], 0.1, y, own)[0] == pytest.approx(0.0, abs=1e-10)


def test_a_film_whose_tension_ends_in_the_flat_state_is_that_of_one_next_to_it():
    """The natural height and K are 0 there at once, and K stays 0 while the voltage is above that of slackness."""
    film = {"meridional_prestretch": 1.1, "hoop_prestretch": 1.4, "prestretch": None, "prestretch_mode": "radial"}
    model = model_of(**film, rest_height=0.0, voltage=0.65, voltage_bias=0.28, drive_frequency=1.5)
    runs = [simulate(model, (x, 0.0), periods=2) for x in (0.0, 1e-6)]
    assert [int(run.outcome) for run in runs] == [Outcome.OK] * 2
    np.testing.assert_array_equal(runs[0].displacement, 0.0)
    slack, other = (run.film_state_wrinkled.item() + run.film_state_slack.item() for run in runs)
    assert 0.1 < slack < 0.9
    assert slack == pytest.approx(other, abs=0.02)
