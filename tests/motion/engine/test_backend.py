"""The back end: any number of states, equal systems share a program, and heyoka as the second integrator agrees."""

from dataclasses import dataclass
from types import SimpleNamespace

import heyoka_backend as heyoka
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone.codes import FilmPullIn, Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion.engine import backend
from gelcone.motion.engine.plan import NOT_FINITE
from gelcone.motion.flow import integrate
from gelcone.motion.job import KEEPS
from gelcone.motion.regime import regime
from gelcone.physics.circuit import Circuit
from gelcone.physics.component import State
from gelcone.physics.film.film import Border
from gelcone.physics.model import ConeModel
from tests.physics.test_system import ViscousFilm
from tests.toys import CubicBias, FilteredVoltage, PowerFilm, ThreeHarmonics

MODELS = {
    "cone": ConeModel(voltage_bias=0.2, rest_height=0.1, prestretch=1.1),
    "toys": ConeModel(film=PowerFilm(1.3), bias=CubicBias(), waveform=ThreeHarmonics(), voltage_bias=0.1),
    "filter": ConeModel(circuit=FilteredVoltage(), voltage=0.9, rest_height=0.1),
    "four states": ConeModel(
        film=ViscousFilm(), bias=CubicBias(), waveform=ThreeHarmonics(), circuit=FilteredVoltage(), voltage=0.8
    ),
}
every_model = pytest.mark.parametrize("name", MODELS)


def start(model):
    return np.array([0.6, -0.2, 0.3, 0.1])[: len(model.system.states)]


# --- what is compiled -------------------------------------------------------------------------------------------------


@every_model
@pytest.mark.parametrize("keep", KEEPS)
def test_the_program_has_a_variable_for_each_state_and_for_what_is_kept(name, keep):
    pytest.importorskip("heyoka")
    system = MODELS[name].system
    count = len(system.states)
    compiled = heyoka.equations(system, keep)
    names = [str(variable) for variable, _ in compiled]
    assert names[:count] == [state.name for state in system.states]
    assert len(set(names)) == len(names) == count + {"states": 0, "tangents": count * count, "work": 2}[keep]


@every_model
def test_compiled_rates_are_those_of_the_system(name):
    hk = pytest.importorskip("heyoka")
    model = MODELS[name]
    compiled = heyoka.equations(model.system, "work")
    function = hk.cfunc([right for _, right in compiled], vars=[left for left, _ in compiled][:-2])
    pars = np.array([model.own_numbers[name] for name in model.system.numbers], dtype=float)
    rng = np.random.default_rng(1)
    for tau in rng.uniform(0.0, 20.0, 5):
        z = rng.uniform(-0.5, 0.5, len(model.system.states))
        expected = [*model.system.rates(tau, z, model.own_numbers), *model.system.powers(tau, z, model.own_numbers)[:2]]
        np.testing.assert_allclose(function(z, pars=pars, time=tau), expected, rtol=1e-12, atol=1e-14)


def test_every_function_of_the_contract_is_there():
    hk = pytest.importorskip("heyoka")
    z = hk.make_vars("z")
    xp = heyoka.functions()
    for name in ("sin", "cos", "exp", "log", "log1p", "sqrt"):
        (found,) = hk.cfunc([getattr(xp, name)(z)], vars=[z])(np.array([0.7]))
        assert found == pytest.approx(getattr(np, name)(0.7), rel=1e-15)


def test_systems_that_differ_in_numbers_alone_share_a_program():
    integrate(MODELS["filter"], start(MODELS["filter"]), [0.5])
    programs = backend._program.cache_info().misses
    other = ConeModel(circuit=FilteredVoltage(), voltage=[0.1, 0.2], filter_time=0.9, stretch_limit=7.0)
    integrate(other, (0.1, 0.0), [0.5])
    assert backend._program.cache_info().misses == programs
    integrate(ConeModel(circuit=FilteredVoltage(), law="neo-hookean"), (0.1, 0.0), [0.5])
    assert backend._program.cache_info().misses == programs + 1


def test_a_number_that_a_components_formulas_depend_on_makes_another_program():
    """A field of a component is no parameter: it is compiled into the program."""
    times = [4.0]
    ends = [integrate(ConeModel(film=PowerFilm(p)), (0.6, 0.0), times).states[0, 0, 0] for p in (1.1, 1.2, 1.1)]
    assert ends[0] == ends[2]
    assert abs(ends[0] - ends[1]) > 1e-4


# --- motions ----------------------------------------------------------------------------------------------------------


@every_model
def test_motions_are_those_of_another_integrator(name):
    model = MODELS[name]
    times = np.linspace(0.0, 12.0, 25)
    run = integrate(model, start(model), times)
    reference = solve_ivp(
        lambda tau, z: model.system.rates(tau, z, model.own_numbers),
        (0.0, 12.0),
        start(model),
        "DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13,
    )
    assert run.states.shape == (1, 25, len(model.system.states))
    np.testing.assert_allclose(run.states[0], reference.y.T, atol=2e-10)


@pytest.mark.parametrize("name", ["cone", "toys", "filter"])
def test_tangents_are_the_derivative_of_the_motion(name):
    model = MODELS[name]
    z0, times, h = start(model), [1.0, 2.5], 1e-5
    run = integrate(model, z0, times, keep="tangents")
    total = run.tangents[0, 1] @ run.tangents[0, 0]
    for column, shift in enumerate(h * np.eye(z0.size)):
        ahead, behind = (integrate(model, z0 + s * shift, times).states[0, 1] for s in (1.0, -1.0))
        np.testing.assert_allclose(total[:, column], (ahead - behind) / (2.0 * h), rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("name", ["cone", "filter"])
def test_tangents_shrink_volumes_by_the_integrated_trace(name):
    """Liouville: ln det = integral of the trace of the Jacobian along the motion."""
    model = MODELS[name]
    times = np.linspace(0.0, 6.0, 2001)
    run = integrate(model, start(model), times, keep="tangents")
    total = np.log(np.linalg.det(run.tangents[0])).sum()
    _, jacobian = model.members().flow(times[None], run.states)
    trace = sum(np.broadcast_to(jacobian[i][i], (1, times.size)) for i in range(run.states.shape[-1]))[0]
    assert total == pytest.approx(np.trapezoid(trace, times), rel=1e-5)


@every_model
def test_work_is_the_integral_of_the_powers(name):
    model = MODELS[name]
    times = np.linspace(0.0, 6.0, 4001)
    run = integrate(model, start(model), times, keep="work")
    powers = model.system.powers(times, list(run.states[0].T), model.own_numbers)
    for column, power in enumerate(powers):
        simpson = (power[:-1:2] + 4.0 * power[1::2] + power[2::2]).sum() * (times[1] / 3.0)
        assert run.work[0, -1, column] == pytest.approx(simpson, rel=1e-9, abs=1e-11)


@pytest.mark.parametrize("keep", KEEPS)
@pytest.mark.parametrize("threads", [1, 2])
def test_members_of_three_states_are_the_same_alone_and_together(keep, threads):
    model = ConeModel(
        circuit=FilteredVoltage(), voltage=np.linspace(0.2, 1.2, 11), filter_time=np.linspace(0.1, 0.9, 11)
    )
    times = np.linspace(0.0, 20.0, 9)
    initial = np.random.default_rng(2).uniform(-0.5, 0.5, (11, 3))
    together = integrate(model, initial, times, keep=keep, threads=threads)
    for member in (0, 7, 8, 10):
        alone = integrate(model.take([member]), initial[member], times, keep=keep)
        for name in ("states", "tangents", "work", "steps"):
            if getattr(alone, name) is not None:
                np.testing.assert_array_equal(getattr(together, name)[member], getattr(alone, name)[0])


# --- starts and ends --------------------------------------------------------------------------------------------------


def test_displacement_and_velocity_will_do_as_a_start():
    model = ConeModel(film=ViscousFilm(), circuit=FilteredVoltage(), voltage=[0.3, 0.9])
    short = integrate(model, (0.6, -0.2), [0.0, 2.0])
    whole = integrate(model, (0.6, -0.2, 0.1, 0.0), [0.0, 2.0])
    np.testing.assert_array_equal(short.states, whole.states)
    np.testing.assert_array_equal(short.states[:, 0], [[0.6, -0.2, 0.1, 0.0]] * 2)
    each = integrate(model, [(0.6, -0.2), (0.1, 0.0)], [0.0])
    np.testing.assert_array_equal(each.states[:, 0, :2], [(0.6, -0.2), (0.1, 0.0)])
    with pytest.raises(InputError, match="initial: must be numbers of shape"):
        integrate(model, (0.6, -0.2, 0.1), [2.0])


def test_a_member_of_three_states_that_fails_changes_no_bit_of_its_neighbours():
    limits = np.array([9.0, 9.0, 1e-2, 9.0])
    model = ConeModel(circuit=FilteredVoltage(), voltage=np.array([0.2, 0.5, 3.0, 0.9]), stretch_limit=limits)
    model = model.replace(voltage_bias=np.array([0.0, 0.1, 30.0, 0.0]))
    times = np.linspace(0.0, 15.0, 16)
    run = integrate(model, (0.05, 0.0), times)
    assert run.outcome.tolist() == [Outcome.OK, Outcome.OK, Outcome.STRETCH_LIMIT, Outcome.OK]
    assert np.isnan(run.states[2, -1]).all()
    others = [0, 1, 3]
    alone = integrate(model.take(others), (0.05, 0.0), times)
    np.testing.assert_array_equal(run.states[others], alone.states)


def test_a_start_with_an_infinite_extra_state_is_not_finite():
    run = integrate(MODELS["filter"], (0.1, 0.0, np.inf), [1.0])
    assert run.outcome[0] == Outcome.NOT_FINITE
    assert np.isnan(run.states).all()


# --- drives with corners ----------------------------------------------------------------------------------------------


def test_a_triangular_drive_is_followed_piece_by_piece():
    """Each piece between corners by SciPy, under the straight line that the voltage is there."""
    model = ConeModel(damping_ratio=0.02, drive_frequency=0.37, voltage=0.8, voltage_bias=0.1, waveform="triangle")
    waveform, n = model.system.waveform, model.members().numbers()
    times, state, at, expected = np.linspace(3.0, 40.0, 12), np.array([0.5, 0.1]), 2.0, []
    corners = waveform.corners_between(np.array([at]), times[-1:], n).later[0]
    for end in np.unique([*times, *corners]):
        middle = 0.5 * (at + end)
        voltage, rate = (float(f(np.array([middle]), n)[0]) for f in (waveform.voltage, waveform.voltage_rate))

        def flow(tau, z, voltage=voltage, rate=rate, middle=middle):
            rates = model.system.under(voltage + rate * (tau - middle), [np.array([x]) for x in z], n).rates()
            return [float(np.ravel(each)[0]) for each in rates]

        state, at = solve_ivp(flow, (at, end), state, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1], end
        if end in times:
            expected.append(state)
    run = integrate(model, (0.5, 0.1), times, start=2.0, keep="tangents")
    np.testing.assert_allclose(run.states[0], expected, rtol=0.0, atol=1e-9)
    areas = np.linalg.det(run.tangents[0])
    np.testing.assert_allclose(areas, np.exp(-0.04 * np.diff(times, prepend=2.0)), rtol=1e-12)


def test_an_orbit_under_a_triangular_drive_is_that_of_the_motion():
    model = ConeModel(damping_ratio=0.05, drive_frequency=0.8, voltage=0.3, rest_height=0.2, waveform="triangle")
    settled = regime(model)
    assert settled["regime"] == Regime.PERIODIC
    start = settled["section"].values[-1]
    period = float(model.members().forcing_period[0])
    turn = integrate(model, start, [period], keep="tangents")
    np.testing.assert_allclose(turn.states[0, 0], start, rtol=0.0, atol=1e-12)
    rates = np.sort(np.log(np.abs(np.linalg.eigvals(turn.tangents[0, 0]))) / period)
    np.testing.assert_allclose(np.sort(settled["lyapunov"].values), rates, rtol=1e-9)


# --- corners of the drive ---------------------------------------------------------------------------------------------


def test_members_have_the_same_bits_however_many_corners_are_held_at_once(monkeypatch):
    model = ConeModel(waveform="square", voltage=[0.4, 0.5, 0.6], drive_frequency=[0.7, 0.9, 1.1])
    times = np.linspace(0.0, 200.0, 21)
    whole = integrate(model.members(), np.tile([0.5, 0.0], (3, 1)), times)
    monkeypatch.setattr(backend, "MOST_CORNERS", 160)  # of the third alone they are 156 at most
    parts = integrate(model.members(), np.tile([0.5, 0.0], (3, 1)), times)
    assert parts.states.tobytes() == whole.states.tobytes()
    assert (parts.outcome == Outcome.OK).all()


def test_a_member_with_too_many_corners_ends_where_it_begins_and_the_others_run(monkeypatch):
    model = ConeModel(waveform="square", voltage=0.5, drive_frequency=[0.9, 100.0, 1.1])
    times = np.linspace(0.0, 200.0, 21)
    monkeypatch.setattr(backend, "MOST_CORNERS", 1000)
    run = integrate(model.members(), np.tile([0.5, 0.0], (3, 1)), times)
    assert run.outcome.tolist() == [Outcome.OK, Outcome.STEP_LIMIT, Outcome.OK]
    assert np.isnan(run.states[1, 1:]).all()
    assert (run.end_times[1], *run.end_states[1]) == (0.0, 0.5, 0.0)
    assert np.isfinite(run.states[[0, 2]]).all()


JUMPING = {
    "law": "neo-hookean", "branches": 1, "flow": "linear", "bias": "beam", "waveform": {"component": "trapezoid"},
    "damping_ratio": 0.009, "voltage": 0.94, "voltage_bias": -0.75, "drive_frequency": 1.54,
    "meridional_prestretch": 1.57, "hoop_prestretch": 1.31, "beam_stiffness": 1.2, "beam_cubic": 0.5,
    "beam_height": -0.27, "high": 0.23, "rise": 0.09, "fall": 0.0, "viscous_modulus_1": 0.21, "relaxation_time_1": 6.4,
}  # fmt: skip
BEHIND_A_RESISTANCE = {
    "branches": 1, "bias": "beam+weight", "circuit": "amplifier", "series_resistance": 0.09,
    "waveform": {"component": "chirp", "sweep": "logarithmic", "repeat": False},
    "damping_ratio": 0.019, "voltage": 0.93, "voltage_bias": -0.6, "drive_frequency": 2.06, "start_frequency": 2.34,
    "end_frequency": 3.16, "meridional_prestretch": 0.89, "hoop_prestretch": 1.57, "beam_stiffness": 0.6,
    "beam_cubic": 0.93, "beam_height": 0.16, "weight": -0.18, "stretch_limit": 140.0, "viscous_modulus_1": 0.35,
    "relaxation_time_1": 0.085, "viscous_limit_1": 52.0,
}  # fmt: skip
RUNAWAY = {
    "branches": 2, "bias": "spring+weight", "flow_exponent": 5, "damping_ratio": 0.0, "voltage": 0.624201,
    "voltage_bias": -0.452007, "drive_frequency": 6.5, "meridional_prestretch": 0.849009, "hoop_prestretch": 0.968389,
    "spring_stiffness": 0.582296, "rest_height": 0.362262, "weight": -0.244544, "stretch_limit": 48.9971,
    "flow_stress": 0.351251, "viscous_modulus_1": 0.0789535, "relaxation_time_1": 0.0591071,
    "viscous_modulus_2": 2.08603, "relaxation_time_2": 0.327714,
}  # fmt: skip

TWO_MINIMA = {
    "branches": 2, "bias": "spring+weight", "flow_exponent": 3, "damping_ratio": 0.03202, "voltage": 0.963,
    "waveform": {"component": "staircase", "levels": (-0.45, -0.92, 0.25, 0.86, 0.89), "rise": 0.0, "repeat": False},
    "drive_frequency": 1.406, "meridional_prestretch": 1.0, "hoop_prestretch": 0.9542, "spring_stiffness": 5.1,
    "rest_height": 0.3723, "weight": 0.1264, "stretch_limit": 11.92, "flow_stress": 1.252,
    "viscous_modulus_1": 0.07655, "relaxation_time_1": 65.53, "viscous_modulus_2": 0.06113, "relaxation_time_2": 32.1,
    "viscous_limit_2": 61.69,
}  # fmt: skip


@pytest.mark.parametrize(
    ("device", "start", "ends"),
    [
        (TWO_MINIMA, (0.0922, 0.2779), 0.8937674690155883),
        (JUMPING, (0.26, -0.06), 1.121997376282069),
        (BEHIND_A_RESISTANCE, (-0.29, -0.04), 1.777603780970001),
        (RUNAWAY, (0.43, 0.356), 0.582369316285389),
    ],
    ids=[
        "by a jump over the end of a minimum",
        "after a jump of the voltage",
        "where it enters a state without a minimum",
        "by flow faster than any step",
    ],
)
def test_a_film_that_finds_no_minimum_has_pulled_in(device, start, ends):
    """The times are those of ``benchmarks/creeping_reference.py``, another integrator on other equations."""
    run = integrate(ConeModel(film="wrinkling", **device), np.array([start]), np.array([[8.0]]))
    assert run.outcome[0] == Outcome.PULLED_IN
    assert run.pull_in[0, 0] == FilmPullIn.MINIMUM
    assert run.end_times[0] == pytest.approx(ends, rel=3e-6)
    assert run.steps[0] < 1000


def test_the_kind_of_a_pull_in_is_that_of_the_film_at_its_border():
    """Held at three heights under a slow drive, a flat film ends where it finds no minimum and raised ones where they
    localise, at the voltage at which the film held there does; the shares of its states last as long as it does."""
    heights = np.array([0.3, 1.0, 2.0])
    held = {"spring_stiffness": 100.0, "damping_ratio": 1.0, "voltage": 2.0, "drive_frequency": 0.05}
    for pull_in, kinds in (("first", [1, 2, 2]), ("minimum", [1, 1, 1])):
        model = ConeModel(film="wrinkling", pull_in=pull_in, rest_height=heights, **held)
        run = integrate(model, np.stack([heights, 0.0 * heights], axis=1), [60.0])
        assert (run.outcome == Outcome.PULLED_IN).all()
        assert [FilmPullIn(kind) for kind in run.pull_in[:, 0]] == [FilmPullIn(kind) for kind in kinds]
        squared = (2.0 * np.sin(0.05 * run.end_times)) ** 2
        limit = model.system.film.highest_squared(run.end_states[:, 0], model.members().numbers())
        np.testing.assert_allclose(squared, limit, rtol=1e-9)
        np.testing.assert_allclose(run.film_times[:, 0].sum(axis=1), run.end_times, rtol=1e-12)
    below = integrate(model, np.stack([heights, 0.0 * heights], axis=1), 0.99 * run.end_times[:, None])
    assert (below.outcome == Outcome.OK).all()
    assert (below.pull_in == FilmPullIn.NONE).all()


@dataclass(frozen=True)
class Clutch(Circuit):
    """A circuit whose voltage is drawn back to where it slips, from both sides."""

    name = "clutch"
    parameters = {}
    states = (State("slip", "what slips"),)
    borders = (Border(lambda port, y, n, xp: n["slips"] * (y[0] - 0.5), "slips"),)

    def numbers(self, parameters):
        return {"slips": 1.0}

    def voltage(self, port, y, n, xp=np):
        return port.command

    def rates(self, port, y, n, xp=np):
        return [-1.0 * n["slips"]]


def test_a_circuit_that_switches_on_and_on_ends_the_motion_at_once_and_no_film_has_pulled_in():
    run = integrate(ConeModel(film="wrinkling", circuit=Clutch()), np.array([[0.3, 0.0, 0.8]]), np.array([[2.0]]))
    assert run.outcome[0] == Outcome.STEP_LIMIT
    assert run.end_times[0] == pytest.approx(0.3, abs=1e-12)
    assert run.pull_in[0, 0] == FilmPullIn.NONE
    assert run.steps[0] < 1000


def test_a_film_that_creeps_and_has_no_state_at_its_start_has_pulled_in_there_and_the_other_runs_on():
    model = ConeModel(
        film="wrinkling", voltage=0.0, voltage_bias=[1.2, 0.3], viscous_modulus_1=0.5, relaxation_time_1=10.0
    )
    starts = model.members().start_states((0.4, 0.1))
    run = integrate(model, starts, [1.0, 2.0])
    assert run.outcome.tolist() == [Outcome.PULLED_IN, Outcome.OK]
    assert run.pull_in[:, 0].tolist() == [FilmPullIn.MINIMUM, FilmPullIn.NONE]
    assert run.end_times[0] == 0.0
    np.testing.assert_array_equal(run.end_states[0], starts[0])
    assert np.isnan(run.states[0]).all()
    assert np.isfinite(run.states[1]).all()


# --- deviations behind a resistance, and the shortest steps -----------------------------------------------------------


def test_behind_a_resistance_the_divergence_is_that_of_the_voltages_map():
    model = ConeModel(film="taut", series_resistance=0.4, voltage=0.7, rest_height=0.5, drive_frequency=0.8)
    run = integrate(model, (0.5, 0.1, 0.2), [0.7, 2.0, 4.0], keep="tangents", tolerance=1e-12)
    volumes = np.log(np.abs(np.linalg.det(run.tangents[0])))
    np.testing.assert_allclose(run.divergence[0], volumes, rtol=1e-8)
    h, whole = 1e-5, run.tangents[0, 2] @ run.tangents[0, 1] @ run.tangents[0, 0]
    for j, step in enumerate(h * np.eye(3)):
        ends = [
            integrate(model, np.array([0.5, 0.1, 0.2]) + s * step, [4.0], tolerance=1e-12).states[0, 0]
            for s in (1.0, -1.0)
        ]
        np.testing.assert_allclose(whole[:, j], (ends[0] - ends[1]) / (2.0 * h), rtol=1e-6, atol=1e-7)


def test_the_shortest_step_shrinks_with_the_time_scale_of_stiff_members_and_is_none_without_a_limit():
    members = ConeModel(spring_stiffness=[1.0, 1e4, 1e8]).members()
    shortest = backend.smallest_step(members)
    np.testing.assert_allclose(shortest, 2e-8 * np.minimum(1.0, 10.0 / members.rate), rtol=1e-14)
    assert shortest[0] == 2e-8
    assert shortest[1] == pytest.approx(100.0 * shortest[2], rel=0.05)  # the rate is as the root of the stiffness
    assert not backend.smallest_step(ConeModel(law="neo-hookean", spring_stiffness=[1.0, 2.0]).members()).any()
    creeping = ConeModel(film="wrinkling", viscous_modulus_1=0.5, relaxation_time_1=10.0).members()
    assert backend.smallest_step(creeping)[0] == pytest.approx(
        2e-8 * backend.RUNAWAY * min(1.0, 10.0 / creeping.rate[0])
    )


def test_infinite_deviations_are_those_of_a_motion_away_from_its_stretch_limit():
    """Steps that became shorter than the least one came near the limit."""
    members, away = ConeModel(damping_ratio=[0.1, 0.1]).members(), np.zeros(2, dtype=bool)
    raw = SimpleNamespace(status=np.full(2, NOT_FINITE), smallest_step=np.array([1e-3, 1e-12]))
    for keep, first in (("tangents", Outcome.NOT_FINITE), ("states", Outcome.STRETCH_LIMIT)):
        found = backend._outcomes(SimpleNamespace(keep=keep), members, raw, np.full(2, -1), np.full(2, 1e-9), away)
        assert found.tolist() == [first, Outcome.STRETCH_LIMIT]
