"""The second film: the equation of motion from the energy, two cones added by hand, and statics against brute force."""

import json
import math
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from cone_energy import lagrangian
from scipy.integrate import solve_ivp

from gelcone import Regime, regime, simulate, static
from gelcone.dataset import load, model_of, save
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.linear import linear_response
from gelcone.motion.settled import settled
from gelcone.motion.state_space import state_space
from gelcone.physics.balance import PullIn, rest_of
from gelcone.physics.component import State
from gelcone.physics.film.film import Border, Film
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import DRIVES, PlacedFilm
from gelcone.physics.statics import balances_of, rest_displacement
from gelcone.quantity import Quantity
from tests.toys import FilteredVoltage, PowerFilm, QuickResistor

SYMBOLIC = SimpleNamespace(log1p=lambda z: sympy.log(1 + z), sqrt=sympy.sqrt, sin=sympy.sin, cos=sympy.cos)
X = np.linspace(-1.5, 2.5, 17)
every_drive = pytest.mark.parametrize("drive", DRIVES)


def double(drive="same", **parameters):
    own = {"second_voltage": 0.4} if drive == "constant" else {}
    given = {"spring_stiffness": 0.0, "prestretch": 1.2, "second_flat_height": 1.0} | own | parameters
    return ConeModel(**({"second_film": "taut", "second_drive": drive} | given))


# --- the force --------------------------------------------------------------------------------------------------------


@every_drive
def test_euler_lagrange_of_both_films_is_the_acceleration(drive):
    t, x, u = sympy.symbols("t x u", real=True)
    system = double(drive).system
    n = {name: sympy.Symbol(name, positive=True) for name in system.numbers}
    first = n["voltage_bias"] + n["voltage"] * sympy.sin(n["drive_frequency"] * t)
    second = {"same": first, "opposite": 2 * n["voltage_bias"] - first, "constant": n.get("second_voltage")}[drive]
    pair = (system.films[1], second)
    L = lagrangian(x, u, first, n, system.film, system.bias, SYMBOLIC, pair)
    motion = sympy.diff(L, x) - 2 * n["damping_ratio"] * u
    found = system.rates(t, [x, u], n, SYMBOLIC)[1]
    symbols = [*n.values(), t, x, u]
    expected, own = (sympy.lambdify(symbols, formula, "mpmath") for formula in (motion, found))
    for at in np.random.default_rng(1).uniform(0.1, 0.4, (5, len(symbols))):
        assert float(own(*at)) == pytest.approx(float(expected(*at)), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("height", [0.0, 0.7])
def test_two_equal_films_without_voltage_pull_like_two_cones_and_oddly(height):
    both = double(second_flat_height=height)
    one = ConeModel(spring_stiffness=0.0, prestretch=1.2)
    np.testing.assert_array_equal(both.force(X), one.force(X) - one.force(height - X))
    np.testing.assert_allclose(both.force(height - X), -both.force(X), rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(both.energy(height - X), both.energy(X), rtol=1e-14)
    if height == 0.0:
        np.testing.assert_allclose(both.force(X), 2.0 * one.force(X), rtol=1e-15)


@every_drive
def test_each_film_has_its_own_voltage_prestretch_and_kind(drive):
    model = ConeModel(
        second_film=PowerFilm(1.2),
        second_drive=drive,
        prestretch=1.3,
        second_film_modulus=0.7,
        second_flat_height=0.6,
        voltage_bias=0.3,
        rest_height=0.1,
        **({"second_voltage": 0.4} if drive == "constant" else {}),
    )
    one, other = ConeModel(prestretch=1.3, rest_height=0.1), ConeModel(film=PowerFilm(1.2), film_modulus=0.7)
    spring = 1.5 * (0.6 - X)
    second = {"same": 0.9, "opposite": 2.0 * 0.3 - 0.9, "constant": 0.4}[drive]
    expected = one.force(X, 0.9) - (other.force(0.6 - X, second) - spring)
    np.testing.assert_allclose(model.force(X, 0.9), expected, rtol=1e-13, atol=1e-14)
    h = 1e-6
    slope = (model.force(X + h, 0.9) - model.force(X - h, 0.9)) / (2.0 * h)
    np.testing.assert_allclose(model.stiffness(X, 0.9), slope, rtol=1e-7, atol=1e-8)


def test_a_double_cone_without_its_second_film_is_the_single_cone():
    single = ConeModel(prestretch=1.2, rest_height=0.2, voltage_bias=0.1)
    again = single.replace(second_film="taut", second_flat_height=0.5).replace(second_film="none")
    assert again.system == single.system
    assert again.parameters() == single.parameters()
    run, other = (integrate(m, (0.3, 0.1), np.linspace(0.1, 9.0, 9)).states for m in (single, again))
    np.testing.assert_array_equal(run, other)


def test_a_second_film_that_pulls_nothing_changes_nothing_that_rounding_does_not():
    nothing = ConeModel(second_film=PowerFilm(), second_film_modulus=0.0, second_drive="constant")
    times = np.linspace(0.5, 20.0, 9)
    run, other = (integrate(m, (0.3, 0.1), times).states for m in (ConeModel(), nothing))
    np.testing.assert_allclose(run, other, rtol=1e-12, atol=1e-13)


# --- the model --------------------------------------------------------------------------------------------------------


def test_a_circuit_that_follows_the_rate_of_its_command_turns_it_for_a_film_in_opposite_phase():
    """Equal films in one plane have opposite voltages, also behind a circuit that takes the rate of the voltage."""
    model = ConeModel(second_film="taut", second_drive="opposite", circuit=QuickResistor(), voltage=0.6)
    n = model.own_numbers
    for tau in (0.3, 1.7, 4.0):
        first, second = (float(np.ravel(v)[0]) for v in model.system.voltages(tau, [0.5, 0.4], n))
        assert second == pytest.approx(-first, rel=1e-12)
        assert abs(first - float(np.ravel(model.system.waveform.voltage(tau, n))[0])) > 1e-4


def test_what_is_not_given_of_the_second_film_is_the_first_ones():
    model = ConeModel(second_film="taut", prestretch=[1.2, 1.3], stretch_limit=20.0)
    np.testing.assert_array_equal(model.second_prestretch, [1.2, 1.3])
    assert model.second_stretch_limit == 20.0
    assert ConeModel(second_film="taut", second_prestretch=1.4, prestretch=1.2).second_prestretch == 1.4
    direct = ConeModel(second_film="taut", prestretch=1.2, second_hoop_prestretch=1.3)
    assert (direct.second_meridional_prestretch, direct.second_hoop_prestretch) == (1.0, 1.3)
    assert direct.replace(second_prestretch=1.5).second_prestretch == 1.5
    assert ConeModel(second_film="taut", law="yeoh", yeoh_c2=0.1).second_yeoh_c2 == 0.1
    assert ConeModel(second_film="taut").replace(law="yeoh", yeoh_c2=0.1).second_yeoh_c2 == 0.1


@every_drive
def test_the_parameters_of_a_double_cone_make_it_again(drive):
    model = double(drive, second_film=PowerFilm(1.1)) if drive == "same" else double(drive)
    again = ConeModel.from_parameters(json.loads(json.dumps(model.parameters())))
    assert again.system == model.system
    assert again.parameters() == model.parameters()


def test_a_double_cone_is_saved_and_read_again(tmp_path):
    model = double("opposite", second_prestretch=[1.1, 1.4])
    save(simulate(model, (0.5, 0.0), periods=0.1), tmp_path / "pair.nc")
    again = model_of(load(tmp_path / "pair.nc"))
    assert again.system == model.system
    np.testing.assert_array_equal(again.second_prestretch, [1.1, 1.4])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"second_prestretch": 1.2}, "second_prestretch: there is no second film; give second_film = 'taut'"),
        (
            {"second_drive": "same"},
            "second_drive = same: there is no second film; give second_film = 'taut', or leave it out",
        ),
        ({"second_film": "tout"}, "'tout' is not a film; did you mean 'taut'?"),
        (
            {"second_film": "taut", "second_drive": "oposite"},
            "'oposite' is not a second_drive; did you mean 'opposite'?",
        ),
        (
            {"second_film": "taut", "second_prestretch": 1.2, "second_hoop_prestretch": 1.1},
            "prestretch and meridional_prestretch/hoop_prestretch are both given; give one or the other",
        ),
    ],
)
def test_what_does_not_fit_is_refused(given, message):
    with pytest.raises(InputError) as error:
        ConeModel(**given)
    assert str(error.value) == message


def test_only_a_pair_that_is_flat_together_is_its_own_mirror_image():
    assert double(second_flat_height=0.0).members().symmetric[0]
    assert not double().members().symmetric[0]
    assert not double(second_flat_height=0.0, spring_stiffness=1.0, rest_height=0.1).members().symmetric[0]


# --- motion -----------------------------------------------------------------------------------------------------------


@every_drive
def test_the_motion_is_that_of_an_independent_integration(drive):
    model = double(drive, voltage=0.5, voltage_bias=0.3, drive_frequency=1.7, second_prestretch=1.3)
    n, system = model.own_numbers, model.system
    times = np.linspace(1.0, 20.0, 9)
    run = integrate(model, (0.7, 0.1), times).states[0]

    def rates(t, z):
        return system.rates(t, z, n)

    other = solve_ivp(rates, (0.0, 20.0), (0.7, 0.1), "DOP853", times, rtol=3e-14, atol=1e-15).y.T
    np.testing.assert_allclose(run, other, atol=1e-11)


@every_drive
@pytest.mark.parametrize("circuit", [False, True])
def test_the_energy_balance_closes_and_the_sources_supply_what_it_takes(drive, circuit):
    own = {"circuit": FilteredVoltage()} if circuit else {}
    model = double(drive, voltage=0.6, voltage_bias=0.2, second_prestretch=1.3, **own)
    found = simulate(model, (0.8, 0.0), times=np.linspace(0.0, 15.0, 6001))
    assert abs(found["energy_residual"]).max() < 1e-12
    time, power = found["time"].values, found["input_power"].values
    supplied = np.trapezoid(power, time)
    assert supplied == pytest.approx(float(found["supplied_energy"][-1]), abs=2e-5)
    first, second = (found.get(f"{film}film_voltage", found[f"{film}drive_voltage"]) for film in ("", "second_"))
    both = first * found["current"] + second * found["second_current"]
    np.testing.assert_allclose(power, both, rtol=1e-13, atol=1e-15)
    # in the cone the charge is v q, with q of the second film's own displacement
    charge = second.values * (1.0 + (1.0 - found["displacement"].values) ** 2)
    np.testing.assert_allclose(found["second_current"], np.gradient(charge, time, edge_order=2), atol=1e-4)


def test_filtered_films_in_opposite_phase_have_a_filter_each():
    model = double("opposite", circuit=FilteredVoltage(), voltage=0.5, voltage_bias=0.3)
    names = [state.name for state in model.system.states]
    assert names == ["displacement", "velocity", "film_voltage", "second_film_voltage"]
    found = simulate(model, (0.5, 0.0), periods=20.0)
    late = found.isel(time=slice(-100, None))
    for of in ("drive", "film"):
        np.testing.assert_allclose(late[f"{of}_voltage"] + late[f"second_{of}_voltage"], 0.6, atol=1e-9)
    assert abs(late["film_voltage"] - late["drive_voltage"]).max() > 0.1
    assert [state.name for state in double("same", circuit=FilteredVoltage()).system.states][2:] == ["film_voltage"]


@every_drive
def test_the_exponents_add_up_and_a_settled_motion_is_found(drive):
    model = double(drive, voltage=0.3, voltage_bias=0.3, damping_ratio=0.2, drive_frequency=1.5)
    found = regime(model, (0.5, 0.0))
    assert float(found["lyapunov"].sum()) == pytest.approx(-0.4, abs=1e-9)
    # equal films under one voltage leave the disc in the middle
    assert Regime(int(found["regime"])) == (Regime.REST if drive == "same" else Regime.PERIODIC)


def test_films_in_opposite_phase_drive_the_disc_linearly():
    """About d/2 the squares (v0 + v s)^2 and (v0 - v s)^2 leave 4 v0 v s: no second harmonic, whatever v is."""
    model = double("opposite", voltage=0.1, voltage_bias=0.4, damping_ratio=0.2, drive_frequency=0.9)
    linear = linear_response(model, np.array([0.9]))
    assert abs(linear.harmonics[1, 0]) < 1e-15 < abs(linear.harmonics[0, 0])
    # the gain of both films at d/2 is d/2 each, and their forces add up
    stiffness = float(model.stiffness(0.5, 0.4)) - 0.5 * 0.1**2 * 2.0
    expected = 0.5 * 2.0 * 2.0 * 0.4 * 0.1 / abs(stiffness - 0.81 + 2j * 0.2 * 0.9)
    assert abs(linear.harmonics[0, 0]) == pytest.approx(expected, rel=1e-12)
    weak = model.replace(voltage=0.002)
    seen = settled(weak, (0.5, 0.0))
    assert float(seen["stroke"]) == pytest.approx(float(linear_response(weak, np.array([0.9])).stroke[0]), rel=1e-4)
    small = state_space(weak)
    gain = abs((small.C @ np.linalg.solve(0.9j * np.eye(2) - small.A, small.B))[0, 0])
    assert 2.0 * gain * 0.002 == pytest.approx(float(seen["stroke"]), rel=1e-4)


# --- statics ----------------------------------------------------------------------------------------------------------


def brute_force(model, voltage):
    """Roots of the force by its sign on a grid finer than what is tested."""
    (balance,) = balances_of(model)
    x = np.linspace(balance.lowest, balance.highest, 100_001)
    with np.errstate(all="ignore"):
        force = model.force(x, voltage)
    at = np.flatnonzero(force[:-1] * force[1:] < 0.0)
    return x[at] - force[at] * (x[at + 1] - x[at]) / (force[at + 1] - force[at])


def test_no_equilibrium_is_missed():
    rng = np.random.default_rng(5)
    for _ in range(8):
        drive = DRIVES[rng.integers(3)]
        model = double(
            drive,
            second_flat_height=rng.uniform(-0.5, 1.5),
            second_prestretch=rng.uniform(1.0, 1.6),
            spring_stiffness=rng.uniform(0.0, 0.5),
            voltage_bias=rng.uniform(0.0, 0.5),
            stretch_limit=rng.uniform(5.0, 60.0),
        )
        (balance,) = balances_of(model)
        for voltage in rng.uniform(0.0, 2.0, 3):
            found = balance.equilibria(np.array([voltage**2]))[0]
            expected = brute_force(model, voltage)
            np.testing.assert_allclose([e.displacement for e in found], expected, atol=2e-4)
            assert all(abs(model.force(e.displacement, voltage)) < 1e-11 for e in found)
            assert [e.stable for e in found] == [bool(model.stiffness(e.displacement, voltage) > 0.0) for e in found]


def test_films_flat_together_lose_stability_where_a_single_one_does():
    """2 (K - V) = 0, K = (A - G)/(1 - (A+B+G-3)/J): the pitchfork of a cone without a spring."""
    both, one = double(second_flat_height=0.0), ConeModel(spring_stiffness=0.0, prestretch=1.2)
    expected = float(static(one)["pitchfork_voltage"])
    found = static(both, [0.0, expected + 0.1])
    assert float(found["pitchfork_voltage"]) == pytest.approx(expected, rel=1e-13)
    assert float(found["pitchfork_displacement"]) == 0.0
    assert PullIn(int(found["pull_in_kind"])) == PullIn.NEVER
    # beyond it each film pushes: the disc goes where a single cone's does
    single = static(one, [expected + 0.1])["equilibrium_displacement"].values[0]
    np.testing.assert_allclose(found["equilibrium_displacement"].values[1], single, atol=1e-12)
    assert float(found["stroke"][1]) == pytest.approx(single.max(), rel=1e-9)


def test_a_raised_pair_under_one_voltage_leaves_its_middle_in_a_pitchfork():
    model, one = double(), ConeModel(spring_stiffness=0.0, prestretch=1.2)
    found = static(model, [0.3])
    voltage = float(found["pull_in_voltage"])
    assert rest_displacement(model) == 0.5
    assert PullIn(int(found["pull_in_kind"])) == PullIn.PITCHFORK
    assert float(one.stiffness(0.5, voltage)) == pytest.approx(0.0, abs=1e-9)
    assert (float(found["pitchfork_voltage"]), float(found["pitchfork_displacement"])) == (voltage, 0.5)
    # it is a subcritical one: the branches turn back in two folds, mirror images of one another
    folds = np.stack([found["fold_voltage"], found["fold_displacement"]], axis=1)
    assert folds.shape == (2, 2)
    assert folds[0, 0] == pytest.approx(folds[1, 0], rel=1e-12)
    assert folds[0, 0] < voltage
    assert folds[0, 1] + folds[1, 1] == pytest.approx(1.0, abs=1e-9)
    for level, place in folds:
        assert abs(model.force(place, level)) < 1e-12
        assert abs(model.stiffness(place, level)) < 1e-9


@every_drive
def test_branches_are_equilibria_and_meet_those_of_single_voltages(drive):
    model = double(drive, voltage_bias=0.4, second_prestretch=1.3)
    levels = [0.0, 0.5, 1.1, 1.6]
    found = static(model, levels)
    place, voltage = found["branch_displacement"].values, found["branch_voltage"].values
    known = np.isfinite(place)
    assert np.abs(model.force(place[known], voltage[known])).max() < 1e-9
    with np.errstate(invalid="ignore"):
        crossings = [int(np.sum((voltage[:-1] - v) * (voltage[1:] - v) < 0.0)) for v in levels[1:]]
    np.testing.assert_array_equal(crossings, found["equilibria"].values[1:])


def test_the_constant_second_film_acts_like_a_bias():
    """A ramp of the first film's voltage alone: what a single cone does against a bias of the same force."""
    model = double("constant")
    found = static(model, [0.0, 0.6])
    for k, level in enumerate((0.0, 0.6)):
        x = float(found["rest_displacement"]) + float(found["stroke"][k])
        one = ConeModel(spring_stiffness=0.0, prestretch=1.2)
        assert float(one.force(x, level)) == pytest.approx(float(one.force(1.0 - x, 0.4)), abs=1e-12)


def test_a_pair_that_cannot_meet_is_refused():
    with pytest.raises(InputError, match="second_flat_height = 30: so far from 0 that no displacement lies inside"):
        static(double(second_flat_height=30.0))


# --- wrinkling films --------------------------------------------------------------------------------------------------


def test_a_pair_of_wrinkling_films_that_both_go_slack_is_held_by_nothing_in_between():
    """Where both are slack no force acts: one equilibrium stands for the whole stretch, and it is not stable. There is
    another stretch on either side, where both films are crumpled beyond the valley of the voltage barrier."""
    model = double(film="wrinkling", second_film="wrinkling")
    (balance,) = balances_of(model)
    below, found, above = balance.equilibria(np.array([0.8**2]))[0]
    valley = math.sqrt(float(balance.n["valley"] / balance.n["A"]) - 1.0)
    assert below.displacement == pytest.approx(1.0 - above.displacement, abs=1e-9)
    assert above.displacement > 1.0 + valley
    assert not any(each.stable for each in (below, above))
    assert float(model.force(found.displacement, 0.8)) == 0.0
    assert found.displacement == pytest.approx(0.5, abs=0.01)
    assert not found.stable
    (tight,) = balance.equilibria(np.array([0.3**2]))[0]
    assert tight.displacement == pytest.approx(0.5, abs=1e-12)
    assert tight.stable


def test_a_ramp_passes_the_voltage_at_which_a_film_begins_to_wrinkle():
    """There the stiffness jumps; the ramp ends where the film loses its tension or pulls in, far beyond."""
    model = double("opposite", film="wrinkling", second_film="wrinkling", voltage_bias=0.4)
    (balance,) = balances_of(model)
    place, losses = balance.along_ramp(rest_of(balance, None), np.array([0.01, 0.09, 0.25]))
    np.testing.assert_array_equal(losses, 0)
    np.testing.assert_allclose(model.force(place, np.array([0.1, 0.3, 0.5])), 0.0, atol=1e-12)
    assert (np.diff(place) > 0.0).all()


@every_drive
def test_a_model_that_has_moved_can_be_pickled(drive):
    """Worker processes take models; borders of placed films are made once and stay with them."""
    model = double(drive, film="wrinkling", second_film="wrinkling", voltage=0.1)
    before = simulate(model, (0.4, 0.0), periods=3)
    again = pickle.loads(pickle.dumps(model))
    assert again.system == model.system
    np.testing.assert_array_equal(simulate(again, (0.4, 0.0), periods=3)["displacement"], before["displacement"])


class Recorder(Film):
    """Stands for a film: what each of its formulas is given, without the numbers, which hold ``c`` alone."""

    name = "recorder"
    parameters = {"c": Quantity("c", "its number", 2.0)}
    states = (State("wear", "its state", "share"),)

    def __init__(self):
        self.seen = []

    def told(self, name, *given, answer=3.0):
        *given, n = given
        assert n["c"] == 7.0
        self.seen.append((name, *given))
        return answer

    def force(self, x, squared, y, n, xp=np):
        return self.told("force", x, squared, y, n, answer=(3.0, 5.0))

    def voltage_force(self, x, squared, y, n, xp=np):
        return self.told("voltage_force", x, squared, y, n)

    def rates(self, x, velocity, squared, y, n, xp=np):
        return self.told("rates", x, velocity, squared, y, n, answer=[3.0])

    def dissipation(self, x, velocity, squared, y, n, xp=np):
        return self.told("dissipation", x, velocity, squared, y, n)

    def drag(self, x, n):
        return self.told("drag", x, n)

    def overstretched(self, x, y, n):
        return self.told("overstretched", x, y, n)

    def strain(self, x, n):
        return self.told("strain", x, n)

    def strain_limit(self, n):
        return self.told("strain_limit", n)

    def highest_squared(self, x, n):
        return self.told("highest_squared", x, n)

    def highest_squared_held(self, x, y, n):
        return self.told("highest_squared_held", x, y, n)

    def voltage_gain(self, x, squared, n):
        return self.told("voltage_gain", x, squared, n)

    def work(self, x, squared, y, n):
        return self.told("work", x, squared, y, n)

    def capacitance(self, x, squared, y, n, xp=np):
        return self.told("capacitance", x, squared, y, n)

    def current(self, x, velocity, voltage, rate, n):
        return self.told("current", x, velocity, voltage, rate, n)

    def state(self, x, voltage, y, n):
        return self.told("state", x, voltage, y, n)

    def limit_share(self, x, voltage, y, n, state=None):
        assert state == "its state"
        return self.told("limit_share", x, voltage, y, n)

    def stiffness_scale(self, n):
        return self.told("stiffness_scale", n)

    def time_constant(self, n):
        return self.told("time_constant", n)

    def starts(self, x, n):
        return self.told("starts", x, n, answer=[3.0])

    def switches(self, x, squared, y, n):
        return self.told("switches", x, squared, y, n, answer={"pulls": 1.0})

    def reach(self, n):
        return self.told("reach", n, answer=(0.25, 1.5))

    def outside(self, x, n):
        return self.told("outside", x, n, answer="too far")

    def unreachable(self, n):
        return self.told("unreachable", n, answer="nowhere")

    def pull_in_kind(self, switches):
        return self.told("pull_in_kind", switches)


@pytest.mark.parametrize("drive", [None, "same"])
def test_a_film_is_asked_at_its_own_place_with_its_own_numbers_and_answers_along_the_discs(drive):
    """The second, flat at 0.5, is asked at 0.5 - x and for the opposite velocity; forces and gains are turned back."""
    film = Recorder()
    placed, second = PlacedFilm(film, drive), drive is not None
    n = {"second_c": 7.0, "c": 1.0, "second_flat_height": 0.5} if second else {"c": 7.0}
    at, u, turned = (0.5 - 0.2, -0.9, -3.0) if second else (0.2, 0.9, 3.0)
    y = [0.1]
    calls = [
        (placed.force(0.2, 0.4, y, n), (turned, 5.0), ("force", at, 0.4, y)),
        (placed.voltage_force(0.2, 0.4, y, n), turned, ("voltage_force", at, 0.4, y)),
        (placed.rates(0.2, 0.9, 0.4, y, n), [3.0], ("rates", at, u, 0.4, y)),
        (placed.dissipation(0.2, 0.9, 0.4, y, n), 3.0, ("dissipation", at, u, 0.4, y)),
        (placed.drag(0.2, n), 3.0, ("drag", at)),
        (placed.overstretched(0.2, y, n), 3.0, ("overstretched", at, y)),
        (placed.strain(0.2, n), 3.0, ("strain", at)),
        (placed.strain_limit(n), 3.0, ("strain_limit",)),
        (placed.highest_squared(0.2, n), 3.0, ("highest_squared", at)),
        (placed.highest_squared_held(0.2, y, n), 3.0, ("highest_squared_held", at, y)),
        (placed.voltage_gain(0.2, 0.4, n), turned, ("voltage_gain", at, 0.4)),
        (placed.work(0.2, 0.4, y, n), 3.0, ("work", at, 0.4, y)),
        (placed.capacitance(0.2, 0.4, y, n), 3.0, ("capacitance", at, 0.4, y)),
        (placed.current(0.2, 0.9, 0.6, 0.7, n), 3.0, ("current", at, u, 0.6, 0.7)),
        (placed.state(0.2, 0.6, y, n), 3.0, ("state", at, 0.6, y)),
        (placed.limit_share(0.2, 0.6, y, n, "its state"), 3.0, ("limit_share", at, 0.6, y)),
        (placed.stiffness_scale(n), 3.0, ("stiffness_scale",)),
        (placed.time_constant(n), 3.0, ("time_constant",)),
        (placed.starts(0.2, n), [3.0], ("starts", at)),
        (placed.reach(n), ((0.5 if second else 0.0) - 1.5, (0.5 if second else 0.0) + 1.5, 0.25), ("reach",)),
        (placed.outside(0.2, n), "second film, too far" if second else "too far", ("outside", at)),
        (placed.unreachable(n), "second film: nowhere" if second else "nowhere", ("unreachable",)),
        (placed.pull_in_kind(n), 3.0, ("pull_in_kind",)),
    ]
    for (answer, expected, asked), seen in zip(calls, film.seen, strict=True):
        assert answer == expected, asked[0]
        assert seen == asked
    assert [state.name for state in placed.states] == ["second_wear" if second else "wear"]
    assert placed.words == ("the second film" if second else "the film")
    assert placed.switches(0.2, 0.4, y, n) == {}
    assert bool(placed.odd(n)) == (not second)
    assert placed.odd({**n, "second_flat_height": 0.0})
    assert not second or not placed.odd({**n, "second_flat_height": -0.5})


def test_a_second_films_borders_divide_no_laws_and_have_switches_of_its_own():
    def value(x, squared, y, n, xp):
        return x, squared, y, n["c"]

    film = Recorder()
    film.borders = (Border(value, "pulls", divides=True), Border(value, seldom=True, folds=True))
    first, second = PlacedFilm(film).borders, PlacedFilm(film, "same").borders
    assert [border.switch for border in first] == ["pulls", None]
    assert [border.switch for border in second] == ["second_pulls", None]
    assert [border.divides for border in (*first, *second)] == [True, False, False, False]
    assert (second[1].seldom, second[1].folds) == (True, True)
    n = {"second_c": 7.0, "second_flat_height": 0.5, "c": 1.0}
    assert second[0].value(0.2, 0.4, [], n, np) == (0.3, 0.4, [], 7.0)
    assert first[0].value(0.2, 0.4, [], n, np) == (0.2, 0.4, [], 1.0)
    assert PlacedFilm(film, "same").switches(0.2, 0.4, [], n) == {"second_pulls": 1.0}
    assert film.seen[-1] == ("switches", 0.3, 0.4, [])


def test_a_constant_voltage_is_a_parameter_of_a_film_that_has_one():
    names = {drive: list(PlacedFilm(Recorder(), drive).parameters) for drive in (None, *DRIVES)}
    assert names == {
        None: ["c"], "same": ["second_flat_height", "second_c"], "opposite": ["second_flat_height", "second_c"],
        "constant": ["second_flat_height", "second_voltage", "second_c"],
    }  # fmt: skip
    placed = PlacedFilm(Recorder(), "constant")
    assert placed.parameters["second_c"].meaning == "second film: its number"
    values = placed.complete_with({"second_voltage": 0.4}, {"c": 7.0})
    assert values == {"second_flat_height": 0.0, "second_voltage": 0.4, "second_c": 7.0}
    assert dict(placed.numbers(values)) == {"second_flat_height": 0.0, "second_voltage": 0.4, "second_c": 7.0}
    assert placed.number_names == ("second_flat_height", "second_voltage", "second_c")
    assert list(placed.own({"second_c": 7.0, "c": 1.0})) == ["c"]
    assert (len(placed.own({"second_c": 7.0, "c": 1.0})), "d" in placed.own({"d": 1.0})) == (1, False)


def test_each_film_counts_its_time_by_its_own_switches():
    """Of a list of the switches of both, those of the other film under another name, so that none is taken for one's
    own."""
    film, seen = Recorder(), []
    film.borders = (Border(lambda *given: 0.0, "pulls"), Border(lambda *given: 0.0, seldom=True))
    film.times_of_kinds = lambda switches, dwell: seen.append(list(switches)) or dwell
    switches, dwell = ["pulls", "second_pulls", "limited"], np.ones((2, 8))
    assert PlacedFilm(film).times_of_kinds(switches, dwell) is dwell
    PlacedFilm(film, "same").times_of_kinds(switches, dwell)
    first, second = seen
    assert (first[0], second[1]) == ("pulls", "pulls")
    assert all(name != "pulls" for name in (*first[1:], second[0], second[2]))


@pytest.mark.parametrize(("drive", "differs"), [(None, False), ("same", False), ("opposite", True), ("constant", True)])
def test_a_second_film_has_another_voltage_unless_it_has_the_same(drive, differs):
    films = ConeModel(second_film="taut", second_drive=drive).system.films if drive else ConeModel().system.films
    assert films[-1].has_other_voltage is differs
