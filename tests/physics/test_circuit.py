"""Circuits: the ideal source changes nothing, and a circuit of one's own has the defaults of the contract."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp

import gelcone
from gelcone.errors import InputError
from gelcone.motion.flow import integrate, phase_program
from gelcone.motion.response import simulate
from gelcone.physics.circuit import Circuit, IdealSource, Port
from gelcone.physics.component import State
from gelcone.physics.film.film import Border
from gelcone.physics.film.taut import TautCone
from gelcone.physics.model import ConeModel
from gelcone.physics.records import CIRCUITS
from tests.toys import FilteredVoltage, QuickResistor, SaturatingAmplifier, SeriesResistor, VoltageBehindResistor


def test_the_ideal_source_gives_the_film_the_commanded_voltage():
    source = IdealSource()
    commanded = np.linspace(-1.0, 1.0, 5)
    port = SimpleNamespace(command=commanded)
    assert source.voltage(port, [], {}) is commanded
    assert source.rates(port, [], {}) == []
    assert source.states == ()
    assert source.parameters == {}
    assert source.gain(3.0, {}) == 1.0


def test_the_table_of_circuits():
    assert all(circuit.name == name for name, circuit in CIRCUITS.items())
    assert isinstance(CIRCUITS["ideal"], IdealSource)


def test_a_circuit_without_a_voltage_cannot_be_made():
    class Unfinished(Circuit):
        name = "unfinished"

    with pytest.raises(TypeError, match="voltage"):
        Unfinished()


def test_a_filters_gain_is_that_of_its_own_rates():
    """y' = (v - y)/t under v = exp(i w tau): y = gain v solves it, and a constant voltage passes."""
    n = {"filter_time": 0.7}
    circuit = FilteredVoltage()
    for frequency in (0.0, 0.3, 4.0):
        gain = circuit.gain(frequency, n)
        (rate,) = circuit.rates(SimpleNamespace(command=1.0), [gain], n)
        assert rate == pytest.approx(1j * frequency * gain, abs=1e-14)


def test_a_circuit_with_states_has_the_period_of_the_voltage_itself():
    """Its states follow the voltage's sign: after half a period they are not where they were."""
    ideal, filtered = ConeModel(drive_frequency=0.8), ConeModel(drive_frequency=0.8, circuit=FilteredVoltage())
    assert ideal.forcing_period == pytest.approx(np.pi / 0.8, rel=1e-15)
    assert filtered.forcing_period == pytest.approx(2.0 * np.pi / 0.8, rel=1e-15)
    assert [state.name for state in filtered.system.states] == ["displacement", "velocity", "film_voltage"]
    assert filtered.filter_time == 0.3


def test_the_voltage_on_a_filtered_film_follows_the_closed_form():
    """After its transient: gain |G| and phase of the RC filter, along a motion that heyoka integrates."""
    pytest.importorskip("heyoka")
    from gelcone.motion.flow import integrate

    model = ConeModel(circuit=FilteredVoltage(), filter_time=0.6, voltage=0.5, voltage_bias=0.2, drive_frequency=1.7)
    times = np.linspace(30.0, 40.0, 101)
    states = integrate(model, (0.3, 0.0), times).states[0]
    gain = model.system.circuit.gain(1.7, {"filter_time": 0.6})
    expected = 0.2 + 0.5 * np.imag(gain * np.exp(1j * 1.7 * times))
    np.testing.assert_allclose(states[:, 2], expected, atol=1e-12)


# --- circuits that see the film ---------------------------------------------------------------------------------------

DRIVE = {"voltage": 0.4, "voltage_bias": 0.5, "drive_frequency": 0.6, "rest_height": 0.7, "damping_ratio": 0.1}
TIMES = np.linspace(0.5, 40.0, 80)


def by_scipy(model, rates, start):
    """States of the disc and a circuit by DOP853; ``rates(t, x, u, y, v_s)`` gives the film's voltage and y'."""
    n = model.own_numbers

    def right(t, z):
        command = n["voltage_bias"] + n["voltage"] * np.sin(n["drive_frequency"] * t)
        voltage, change = rates(t, z[0], z[1], z[2:], command)
        h = model.law.film_stiffness(1.0 + z[0] ** 2, n["A"], n["B"], n["G"], n)[0]
        spring = n["spring_stiffness"] * (z[0] - n["rest_height"])
        return [z[1], -2.0 * n["damping_ratio"] * z[1] - z[0] * (h - voltage**2) - spring, *change]

    found = solve_ivp(right, (0.0, TIMES[-1]), start, method="DOP853", t_eval=TIMES, rtol=1e-11, atol=1e-12)
    return found.y.T


def test_a_film_is_charged_through_a_resistance_and_leaks():
    model = ConeModel(circuit=SeriesResistor(), series_resistance=5.0, leakage_time=20.0, **DRIVE)

    def rates(t, x, u, y, command):
        v = y[0] / (1.0 + x * x)
        return v, [(command - v) / 5.0 - y[0] / 20.0]

    run = integrate(model, (0.6, 0.0), TIMES, keep="tangents")
    expected = by_scipy(model, rates, [0.6, 0.0, 0.0])
    np.testing.assert_allclose(run.states[0], expected, atol=1e-9)
    fixed = by_scipy(model, lambda t, x, u, y, command: (y[0], [(command - y[0]) / 5.0 - y[0] / 20.0]), [0.6, 0.0, 0.0])
    assert np.abs(fixed[:, 0] - expected[:, 0]).max() > 0.02  # the circuit must see that the film stretches


def test_voltage_and_charge_as_the_state_of_a_circuit_agree():
    charge = ConeModel(circuit=SeriesResistor(), series_resistance=2.0, **DRIVE)
    voltage = ConeModel(circuit=VoltageBehindResistor(), series_resistance=2.0, **DRIVE)
    one, other = (integrate(model, (0.6, 0.0), TIMES, keep="tangents") for model in (charge, voltage))
    np.testing.assert_allclose(other.states[0, :, :2], one.states[0, :, :2], atol=1e-12)
    x, q = one.states[0, :, 0], one.states[0, :, 2]
    np.testing.assert_allclose(other.states[0, :, 2], q / (1.0 + x * x), atol=1e-12)
    n, z = voltage.own_numbers, [x, one.states[0, :, 1], other.states[0, :, 2]]
    by_hand = ((voltage.system.waveform.voltage(TIMES, n) - z[2]) / 2.0 - 2.0 * z[2] * x * z[1]) / (1.0 + x * x)
    np.testing.assert_allclose(voltage.system.rates(TIMES, z, n)[2], by_hand, atol=1e-13)


def test_a_circuit_sees_the_rate_of_the_command_also_over_the_phase():
    """A small resistance without a state deviates from the one with a state by its square."""
    errors = []
    for rho in (0.04, 0.02):
        exact = ConeModel(circuit=SeriesResistor(), series_resistance=rho, **DRIVE)
        quick = ConeModel(circuit=QuickResistor(), series_resistance=rho, **DRIVE)
        charge = 1.36 * (0.5 - rho * 1.36 * 0.24)
        x = integrate(exact, (0.6, 0.0, charge), TIMES).states[0, :, 0]
        reduced = integrate(quick, (0.6, 0.0), TIMES).states[0, :, 0]
        errors.append(np.abs(reduced - x).max())
    assert errors[1] < 0.35 * errors[0] < 1e-3
    program = phase_program(quick.system, (), 1e-13)
    numbers = {name: np.ones(1) * quick.own_numbers[name] for name in quick.system.numbers}
    own = [np.ravel(numbers[name])[0] if name in numbers else 0.0 for name in program.numbers]
    again = program.again(np.zeros(1), np.array([0.6 * TIMES[0]]))
    start = np.zeros((1, again._arrays.states.shape[1]))
    start[0, 0] = 0.6
    end, arrived = again.run(np.array(own), start, 0.0)
    assert arrived.all()
    np.testing.assert_allclose(end[0, :2], integrate(quick, (0.6, 0.0), TIMES[:1]).states[0, 0], atol=1e-11)


@pytest.mark.parametrize("circuit", ["charge", QuickResistor()], ids=["charge", "quick"])
def test_tangents_know_that_a_voltage_follows_the_disc(circuit):
    """Those of differences; the trace, which is not -2 zeta then, is that of the tangent map."""
    model = ConeModel(circuit=circuit, **DRIVE)
    assert not model.system.planar
    run = integrate(model, (0.6, 0.1), [5.0], keep="tangents")
    starts = np.array([0.6, 0.1]) + 1e-6 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    ends = np.array([integrate(model, start, [5.0]).states[0, -1] for start in starts])
    np.testing.assert_allclose(run.tangents[0, -1], ((ends[:2] - ends[2:]) / 2e-6).T, atol=1e-8)
    assert float(run.divergence[0, -1]) == pytest.approx(np.log(np.linalg.det(run.tangents[0, -1])), abs=1e-10)
    exponents = gelcone.lyapunov(model, budget=2000.0)
    assert float(abs(exponents["sum_residual"])) < 1e-6
    assert ConeModel(film="wrinkling", circuit="charge", **DRIVE).system.planar  # statics alone


def test_an_amplifier_saturates_at_its_borders():
    model = ConeModel(circuit=SaturatingAmplifier(), voltage_limit=0.3, **DRIVE | {"voltage_bias": 0.1})
    run = integrate(model, (0.6, 0.0), TIMES)
    expected = by_scipy(model, lambda t, x, u, y, command: (np.clip(command, -0.3, 0.3), []), [0.6, 0.0])
    np.testing.assert_allclose(run.states[0], expected, atol=2e-8)  # SciPy steps over the borders
    simulated = simulate(model, (0.6, 0.0), periods=4)
    assert float(abs(simulated["film_voltage"]).max()) == pytest.approx(0.3, rel=1e-15)
    assert float(abs(simulated["energy_residual"]).max()) < 1e-12
    shares = np.abs(model.voltage * np.sin(np.linspace(0.0, 8.0 * np.pi, 100_001)) + 0.1) > 0.3
    assert float(simulated["top_voltage_limited"]) == pytest.approx(shares.mean(), abs=1e-4)
    assert simulated["top_voltage_limited"].attrs["long_name"] == "share of the time at the limit top voltage"
    assert model.forcing_period == pytest.approx(2.0 * np.pi / 0.6)


def test_a_border_needs_a_switch_and_a_charge_a_film_that_knows_it():
    class Endless(SaturatingAmplifier):
        borders = (Border(lambda port, y, n, xp: 1.0 - port.command),)

    with pytest.raises(InputError, match="circuit 'saturating': a border has no switch"):
        ConeModel(circuit=Endless())
    with pytest.raises(InputError, match="film 'wrinkling': its voltage does not follow from its charge"):
        integrate(ConeModel(circuit=SeriesResistor(), film="wrinkling"), (0.6, 0.0), TIMES)
    failing = ConeModel(circuit=VoltageBehindResistor(), film="wrinkling", pull_in="snap")
    with pytest.raises(InputError, match="film 'wrinkling': its charge is not known while a motion is computed"):
        integrate(failing, (0.6, 0.0), TIMES)


def test_both_films_of_a_double_cone_are_charged_through_one_resistance():
    model = ConeModel(circuit=SeriesResistor(), series_resistance=3.0, second_film="taut", **DRIVE)
    n = model.own_numbers

    def right(t, z):
        x, u, q = z
        v = q / (2.0 * (1.0 + x * x))
        h = model.law.film_stiffness(1.0 + x * x, n["A"], n["B"], n["G"], n)[0]
        force = 2.0 * x * (h - v * v) + n["spring_stiffness"] * (x - 0.7)
        return [u, -0.2 * u - force, (0.5 + 0.4 * np.sin(0.6 * t) - v) / 3.0]

    run = integrate(model, (0.6, 0.0), TIMES)
    found = solve_ivp(right, (0.0, 40.0), [0.6, 0.0, 0.0], method="DOP853", t_eval=TIMES, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(run.states[0], found.y.T, atol=1e-9)


# --- powers -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("circuit", [SeriesResistor(), "amplifier"], ids=["own", "shipped"])
def test_what_the_source_gives_is_lost_somewhere_or_stored(circuit):
    """Each loss by a quadrature of its own formula over SciPy's motion; the balance closes, and would not without."""
    model = ConeModel(circuit=circuit, series_resistance=5.0, leakage_time=20.0, **DRIVE)
    run = simulate(model, (0.6, 0.0), times=TIMES)

    def rates(t, x, u, y, command):
        v = y[0] / (1.0 + x * x)
        current = (command - v) / 5.0
        losses = [0.2 * u * u, (command - v) * current, v * y[0] / 20.0]
        return v, [current - y[0] / 20.0, command * current, *losses]

    expected = by_scipy(model, rates, [0.6, 0.0, *[0.0] * 5])
    names = "supplied_energy", "damper_dissipation", "resistor_dissipation", "leak_dissipation"
    for name, integral in zip(names, expected[:, 3:].T, strict=True):
        np.testing.assert_allclose(run[name].values, integral, atol=1e-9)
    assert float(run["resistor_dissipation"][-1]) > 0.1
    np.testing.assert_allclose(run["dissipated_energy"], sum(run[name] for name in names[1:]), rtol=1e-13)
    assert float(abs(run["energy_residual"]).max()) < 1e-12
    power = run["input_power"].values
    np.testing.assert_allclose(power, np.gradient(expected[:, 3], TIMES), atol=0.05)


def test_what_a_permittivity_that_follows_late_loses_closes_the_balance():
    late = {"series_resistance": 0.5, "leakage_time": 20.0, "dielectric_share": 0.4, "dielectric_time": 2.0}
    run = simulate(ConeModel(circuit="amplifier", **late, **DRIVE), (0.6, 0.0), times=TIMES)
    assert float(run["dielectric_dissipation"][-1]) > 0.01
    assert float(run["leak_dissipation"][-1]) > 0.01
    assert float(abs(run["energy_residual"]).max()) < 1e-10


def test_a_film_that_wrinkles_is_charged_through_a_resistance():
    """What the source gives, integrated in the program, is what is stored, by the lengths of the film, or lost."""
    model = ConeModel(
        film="wrinkling",
        circuit=VoltageBehindResistor(),
        series_resistance=0.2,
        prestretch=1.2,
        stretch_limit=5.0,
        rest_height=0.3,
        spring_stiffness=1.0,
        damping_ratio=0.1,
        voltage=0.8,
        drive_frequency=0.35,
    )
    run = simulate(model, (0.6, 0.0), times=TIMES)
    assert int(run["outcome"]) == 0
    assert float(run["film_state_meridional_slack"]) > 0.05
    assert float(run["resistor_dissipation"][-1]) > 0.01
    assert float(abs(run["energy_residual"]).max()) < 1e-12


BRANCH = 0.4


class Lossy(TautCone):
    """The taut cone with a spring beside it whose other end follows the disc through a dashpot."""

    name = "lossy"
    states = (State("lag", "displacement that the dashpot follows", "length"),)

    def force(self, x, squared, y, n, xp=np):
        force, slope = super().force(x, squared, y, n, xp)
        lag = x - y[0] if y else 0.0 * x
        return force + BRANCH * lag, slope + (BRANCH if y else 0.0)

    def rates(self, x, velocity, squared, y, n, xp=np):
        return [x - y[0]]

    def work(self, x, squared, y, n):
        lag = x - y[0] if y else 0.0 * x
        return super().work(x, squared, y, n) + 0.5 * BRANCH * lag * lag

    def dissipation(self, x, velocity, squared, y, n, xp=np):
        return BRANCH * (x - y[0]) * (x - y[0])


def test_a_film_that_dissipates_is_accounted_for():
    """The integral of the input power is the energy supplied, and a wrong dissipation leaves a residual."""
    model = ConeModel(film=Lossy(), **DRIVE)
    run = simulate(model, (0.6, 0.0), times=np.linspace(0.0, 40.0, 4001))
    power, time = run["input_power"].values, run["time"].values
    assert float(run["supplied_energy"][-1]) == pytest.approx(simpson(power, x=time), abs=1e-8)
    assert float(run["film_dissipation"][-1]) > 0.05
    assert float(abs(run["energy_residual"]).max()) < 1e-12

    class Wrong(Lossy):
        def dissipation(self, x, velocity, squared, y, n, xp=np):
            return 1.01 * super().dissipation(x, velocity, squared, y, n, xp)

    wrong = simulate(ConeModel(film=Wrong(), **DRIVE), (0.6, 0.0), times=[40.0])
    assert abs(float(wrong["energy_residual"][-1])) > 1e-4


def test_a_films_own_loss_counts_also_where_its_charge_is_unknown_in_a_program():
    class Uncharged(Lossy):
        traced_charge = False

    known, unknown = (
        simulate(ConeModel(film=film, **DRIVE), (0.6, 0.0), times=TIMES) for film in (Lossy(), Uncharged())
    )
    for name in ("film_dissipation", "damper_dissipation", "dissipated_energy", "dissipated_power"):
        np.testing.assert_allclose(unknown[name], known[name], rtol=1e-12)
    np.testing.assert_allclose(unknown["supplied_energy"], known["supplied_energy"], atol=1e-12)
    assert float(abs(unknown["energy_residual"]).max()) < 1e-12


def test_a_film_on_an_open_circuit_senses_the_motion_and_is_stiffer():
    """K + 4 x^2 v^2/q, where a film at a held voltage has K."""
    charge = 0.6
    open_circuit = ConeModel(circuit="charge", voltage=0.0, voltage_bias=charge, rest_height=0.8, damping_ratio=0.0005)
    x = float(gelcone.settled(open_circuit.replace(damping_ratio=0.1))["mean"])
    q = 1.0 + x * x
    held = open_circuit.replace(circuit="ideal", voltage_bias=charge / q)
    squares = []
    for model in (open_circuit, held):
        run = simulate(model, (x + 1e-4, 0.0), times=np.linspace(0.0, 60.0, 3001))
        deviation, time = run["displacement"].values - x, run["time"].values
        k = np.flatnonzero((deviation[:-1] < 0.0) & (deviation[1:] >= 0.0))
        zeros = time[k] - deviation[k] * (time[k + 1] - time[k]) / (deviation[k + 1] - deviation[k])
        squares.append((2.0 * np.pi / np.diff(zeros).mean()) ** 2)
        if model is open_circuit:
            sensed = run["film_voltage"] * (1.0 + run["displacement"] ** 2)
            np.testing.assert_allclose(sensed, charge, rtol=1e-14)
    assert squares[0] - squares[1] == pytest.approx(4.0 * (x * charge / q) ** 2 / q, rel=1e-5)


# --- ports, of films that are formulas --------------------------------------------------------------------------------


class Formula:
    """A film of the capacitance (1 + x^2) (1 + V/4) (2 + y) whose state changes by x u - V y."""

    def __init__(self, share):
        self.share, self.film = share, SimpleNamespace(linear_charge=False, borders=(), name="formula")
        self.words = "the film"

    def capacitance(self, x, squared, y, n, xp):
        return self.share * ((1.0 + x * x) * (1.0 + 0.25 * squared) * (2.0 + y[0]))

    def fitted_capacitance(self, x, squared, y, n):
        return self.capacitance(x, squared, y, n, np)

    def rates(self, x, velocity, squared, y, n, xp):
        return [x * velocity - squared * y[0]]


def test_a_port_knows_how_charge_and_voltage_of_its_films_change():
    """Q' = Q_v v' + Q_x u + Q_y y', by hand; the voltage of a charge is the inverse of the charge of a voltage."""
    x, u, v = np.array([0.3, -0.7]), np.array([0.5, 1.1]), np.array([0.6, -0.4])
    y, films = [np.array([0.2, 0.4]), np.array([0.3, -0.1])], (Formula(1.0), Formula(0.4))
    port = Port(0.0, x, u, lambda: 0.0, tuple((film, [own]) for film, own in zip(films, y, strict=True)), {}, np)
    weight = (2.0 + y[0]) + 0.4 * (2.0 + y[1])
    by_v, by_x = (1.0 + x * x) * (1.0 + 0.75 * v * v) * weight, 2.0 * x * (v + 0.25 * v**3) * weight
    area = (1.0 + x * x) * (1.0 + 0.25 * v * v)
    of_states = [share * area * v * (x * u - v * v * own) for share, own in zip((1.0, 0.4), y, strict=True)]
    np.testing.assert_allclose(port.capacitance(v), area * weight, rtol=1e-14)
    np.testing.assert_allclose(port.slope(v), by_v, rtol=1e-12)
    rate = port.voltage_rate(v, np.array([0.9, -0.2]))
    np.testing.assert_allclose(by_v * rate + by_x * u + sum(of_states), [0.9, -0.2], rtol=1e-12)
    np.testing.assert_allclose(port.voltage(port.charge(v)), v, rtol=1e-12)
    held = area * weight * 0.3 + by_x * u + sum(of_states)  # of films whose capacitance the voltage does not change
    np.testing.assert_allclose(port.charge_rate(v, 0.3), held, rtol=1e-12)


def test_switches_do_not_depend_on_what_they_were():
    circuit = SaturatingAmplifier()
    n = circuit.numbers(circuit.complete({"voltage_limit": 0.5}))
    for command, sides in ((0.9, [-1.0, 1.0]), (-0.9, [1.0, -1.0]), (0.2, [1.0, 1.0])):
        port = SimpleNamespace(command=command)
        found = circuit.switches(port, [], n)
        assert list(found.values()) == sides
        assert circuit.switches(port, [], {**n, **found}) == found


def test_a_circuit_with_powers_of_its_own_loses_in_its_resistor_and_by_leaking():
    assert SeriesResistor().losses == ("resistor", "leak")
    assert FilteredVoltage().losses == ()


def test_a_circuit_without_leaks_has_none_through_each_film():
    assert IdealSource().leaks(SimpleNamespace(films=("first", "second")), [], {}) == [0.0, 0.0]


def test_a_voltage_jumps_with_the_command_where_no_state_follows_it():
    assert IdealSource().jumps
    assert SaturatingAmplifier().jumps
    assert not FilteredVoltage().jumps
    with pytest.raises(InputError, match="film 'wrinkling': its voltage does not follow from its charge"):
        integrate(ConeModel(film="wrinkling", circuit="charge"), (0.3, 0.0), [1.0])
