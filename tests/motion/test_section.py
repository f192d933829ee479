"""Poincare sections: returning points, phases, turning points against SciPy, ensembles to the last bit, contracts."""

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gelcone
from gelcone.codes import Outcome
from gelcone.dataset import load, model_of, save
from gelcone.errors import InputError
from gelcone.motion import settle as module
from gelcone.motion.flow import integrate
from gelcone.motion.section import extrema, section
from gelcone.physics.model import ConeModel
from gelcone.plots.section import section_figure
from tests.recorded import numbers, record
from tests.toys import TurningBias

section_module = importlib.import_module("gelcone.motion.section")
PERIODIC = ConeModel(damping_ratio=0.1, spring_stiffness=1.0, voltage=0.8, drive_frequency=1.0, rest_height=0.3)
CHAOTIC = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, voltage=1.7, drive_frequency=0.1)
ESCAPES = ConeModel(stretch_limit=np.inf, voltage=8.0, spring_stiffness=0.1)
both = pytest.mark.parametrize("analysis", [section, extrema])


def varied():
    """Members with and without a bias, of different speeds, one that starts outside and one that escapes."""
    return ConeModel(
        damping_ratio=[0.01, 0.1, 0.05, 0.02, 0.05, 0.1],
        spring_stiffness=[0.9, 1.0, 1.5, 0.5, 1.0, 0.1],
        voltage=[1.7, 0.8, 0.5, 1.2, 0.5, 8.0],
        voltage_bias=[0.0, 0.0, 0.3, 0.1, 0.0, 0.0],
        drive_frequency=[0.1, 1.0, 1.0, 0.3, 1.0, 1.0],
        stretch_limit=[50.0, 50.0, 10.0, 20.0, 0.04, np.inf],
        rest_height=[0.0, 0.3, 0.1, 0.0, 0.0, 0.0],
    )


def assert_member_equals(one, many, index, dim):
    """A run on its own equals the member of an ensemble to the last bit, as far as it is not padding."""
    for name, alone in one.data_vars.items():
        inside = many[name].isel(member=index).values
        if dim in alone.dims:
            count = alone.sizes[dim]
            padding = inside[count:]
            inside = inside[:count]
            assert np.isnan(padding).all() if padding.dtype.kind == "f" else not padding.any()
        np.testing.assert_array_equal(alone.values, inside, err_msg=str(name))


def test_further_states_of_a_device_are_in_their_own_units():
    device = gelcone.find_device("biased-pump").replace(film="taut", series_resistance="2 MOhm")
    found = section(device, repeats=2, discard=3)
    run = gelcone.simulate(device, times=1e-3 * found["time"].values)
    for name in ("displacement", "velocity", "film_voltage"):
        assert found[name].attrs == run[name].attrs
        np.testing.assert_allclose(found[name], run[name], rtol=1e-6)


# --- stroboscopic -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [0.0, 0.37])
def test_a_motion_of_one_repeat_gives_one_point(phase):
    result = section(PERIODIC, repeats=50, phase=phase)
    assert result.sizes == {"repeat": 50, "state": 2}
    assert np.ptp(result.displacement.values) < 1e-12
    assert np.ptp(result.velocity.values) < 1e-12
    at = (200 + phase) * np.pi
    direct = integrate(PERIODIC, (1.0, 0.0), [at]).states[0, 0]
    np.testing.assert_allclose([result.displacement[0], result.velocity[0]], direct, rtol=0.0, atol=1e-12)
    assert float(result.time[0]) == pytest.approx(at, rel=1e-15)
    assert result.repeat.values.tolist() == list(range(200, 250))


def test_points_at_a_phase_are_samples_of_the_motion():
    result = section(CHAOTIC, repeats=6, discard=0, phase=0.6)
    direct = integrate(CHAOTIC, (1.0, 0.0), (np.arange(6) + 0.6) * 10.0 * np.pi).states[0]
    np.testing.assert_allclose(result.displacement, direct[:, 0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(result.velocity, direct[:, 1], rtol=0.0, atol=1e-9)


def test_phase_0_without_discard_begins_at_the_start():
    result = section(PERIODIC, (0.7, -0.2), repeats=1, discard=0)
    assert (float(result.displacement[0]), float(result.velocity[0]), float(result.time[0])) == (0.7, -0.2, 0.0)


def test_a_bias_doubles_the_repeat():
    biased = PERIODIC.replace(voltage_bias=0.2)
    result = section(biased, repeats=20)
    np.testing.assert_allclose(np.diff(result.time), 2.0 * np.pi, rtol=1e-12)
    assert np.ptp(result.displacement.values) < 1e-12
    middle = section(biased, repeats=1, phase=0.5)
    assert abs(float(middle.displacement[0] - result.displacement[0])) > 1e-3


def test_the_phase_of_the_drive_stays_exact_in_long_runs():
    early = section(PERIODIC, repeats=1, phase=0.25)
    late = section(PERIODIC, repeats=1, discard=20_000, phase=0.25)
    assert abs(late.displacement.item() - early.displacement.item()) < 1e-13
    assert abs(late.velocity.item() - early.velocity.item()) < 1e-13


def test_a_period_doubled_motion_gives_two_points():
    """At voltage 1 of the paper's fast set the motion takes two repeats of the drive."""
    model = ConeModel(damping_ratio=0.01, spring_stiffness=0.5, voltage=1.0, drive_frequency=0.3)
    x = section(model, repeats=20).displacement.values
    assert np.ptp(x[::2]) < 1e-8
    assert np.ptp(x[1::2]) < 1e-8
    assert abs(x[0] - x[1]) > 0.1


# --- turning points ---------------------------------------------------------------------------------------------------


def scipy_extrema(model, initial, span):
    """Turning points from a fine SciPy run and root finding on its dense output."""

    def slope(t, state):
        voltage = float(model.voltage_bias) + float(model.voltage) * np.sin(float(model.drive_frequency) * t)
        return [state[1], -float(model.force(state[0], voltage)) - 2.0 * float(model.damping_ratio) * state[1]]

    run = solve_ivp(slope, (0.0, span), initial, "DOP853", rtol=1e-13, atol=1e-14, dense_output=True, max_step=0.05)
    times = np.linspace(0.0, span, 20_001)[1:]
    velocity = run.sol(times)[1]
    at = np.flatnonzero(np.sign(velocity[1:]) != np.sign(velocity[:-1]))
    roots = [brentq(lambda t: run.sol(t)[1], times[i], times[i + 1], xtol=1e-14) for i in at]
    return np.array(roots), run.sol(np.array(roots))[0]


@pytest.mark.parametrize(("model", "repeats"), [(PERIODIC, 8), (CHAOTIC, 1), (PERIODIC.replace(voltage_bias=0.3), 4)])
def test_extrema_agree_with_a_fine_scipy_run(model, repeats):
    times, displacements = scipy_extrema(model, (1.0, 0.0), repeats * float(model.forcing_period))
    result = extrema(model, repeats=repeats, discard=0)
    assert int(result["count"]) == len(times)
    np.testing.assert_allclose(result.time, times, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(result.displacement, displacements, rtol=0.0, atol=1e-8)


def test_extrema_have_no_velocity_and_alternate():
    result = extrema(CHAOTIC, repeats=60, discard=20)
    assert result.sizes["extremum"] > 300
    assert float(abs(result.velocity).max()) < 1e-10
    assert (np.diff(result.time) > 0.0).all()
    assert set(result.maximum.values.tolist()) == {1, -1}
    assert (np.diff(result.maximum) != 0).all()
    assert (np.sign(np.diff(result.displacement)) == result.maximum[1:]).all()
    assert result.time.min() >= 20 * CHAOTIC.forcing_period
    np.testing.assert_allclose((result.time / CHAOTIC.forcing_period) % 1.0, result.phase, rtol=0.0, atol=1e-9)


def test_the_film_turning_the_motion_round_like_a_wall_is_an_extremum():
    """Near the stretch limit the velocity flips within a small part of a sample: Newton's steps leave the bracket."""
    model = ConeModel(
        damping_ratio=0.194,
        spring_stiffness=1.87,
        voltage=2.38,
        voltage_bias=0.5,
        drive_frequency=1.69,
        stretch_limit=4.654,
        prestretch=0.893,
    )
    result = extrema(model, (0.3, 0.0), repeats=40, discard=20)
    assert float(model.strain(result.displacement).max()) > 0.99 * float(model.strain_limit())
    assert float(abs(result.velocity).max()) < 1e-9
    assert (np.diff(result.maximum) != 0).all()


def test_velocity_really_vanishes_where_extrema_say():
    result = extrema(PERIODIC, repeats=3, discard=0)
    states = integrate(PERIODIC, (1.0, 0.0), result.time.values).states[0]
    assert np.abs(states[:, 1]).max() < 1e-10
    np.testing.assert_allclose(states[:, 0], result.displacement, rtol=0.0, atol=1e-12)


def test_a_start_at_rest_is_no_turning_point_but_an_exact_zero_later_is():
    """Released at its amplitude, an undamped motion turns once each half period, also where a sample hits the zero."""
    free = ConeModel(damping_ratio=0.0, voltage=0.0, spring_stiffness=1.0, law="neo-hookean", drive_frequency=1.0)
    result = extrema(free, (1e-3, 0.0), repeats=6, discard=0)
    assert result.maximum.values[:4].tolist() == [-1, 1, -1, 1]
    np.testing.assert_allclose(result.time[:4], np.pi * np.arange(1, 5), rtol=1e-5)
    np.testing.assert_allclose(abs(result.displacement), 1e-3, rtol=1e-11)


def test_rest_has_no_extrema():
    result = extrema(ConeModel(damping_ratio=0.5, voltage=0.0), (0.0, 0.0), repeats=5, discard=0)
    assert int(result["count"]) == 0
    assert result.displacement.isnull().all()
    settled = extrema(ConeModel(damping_ratio=0.5, voltage=0.0, rest_height=0.3), (1.0, 0.0), repeats=20)
    assert int(settled["count"]) == 0


# --- ensembles, outcomes, contracts -----------------------------------------------------------------------------------


@both
def test_an_ensemble_equals_its_members_one_by_one_to_the_last_bit(analysis):
    model = varied()
    many = analysis(model, (0.5, 0.0), repeats=12, discard=40)
    for i in range(model.size):
        if i != 4:
            alone = analysis(model.take(i), (0.5, 0.0), repeats=12, discard=40)
            assert_member_equals(alone, many, i, "repeat" if analysis is section else "extremum")


@both
def test_threads_do_not_change_a_bit(analysis):
    one = analysis(varied(), (0.5, 0.0), repeats=5, discard=2, threads=1)
    assert one.identical(analysis(varied(), (0.5, 0.0), repeats=5, discard=2, threads=2))


@both
def test_blocks_do_not_change_a_bit(analysis, monkeypatch):
    whole = analysis(varied(), (0.5, 0.0), repeats=5, discard=2)
    monkeypatch.setattr(module, "BLOCK_SAMPLES", 1)
    assert whole.identical(analysis(varied(), (0.5, 0.0), repeats=5, discard=2))


@both
def test_members_that_fail_say_how_and_hold_nothing(analysis):
    result = analysis(varied(), (0.5, 0.0), repeats=5, discard=45)
    assert result.outcome.values.tolist() == [0, 0, 0, 0, Outcome.OUTSIDE, Outcome.NOT_FINITE]
    assert result.displacement[4:].isnull().all()
    assert (result.displacement[:4].notnull().sum(axis=1) > 0).all()


@both
def test_a_grid_of_members_keeps_its_shape(analysis):
    model = ConeModel(voltage=[[0.5], [0.8]], damping_ratio=[0.1, 0.2, 0.3], rest_height=0.2)
    result = analysis(model, repeats=4, discard=1)
    assert result.displacement.shape[:2] == (2, 3)
    assert result.displacement.dims[:2] == ("member_0", "member_1")
    assert model_of(result).shape == (2, 3)


@both
def test_results_read_back_equal(analysis, tmp_path):
    result = analysis(varied(), (0.5, 0.0), repeats=5, discard=2)
    save(result, tmp_path / "result.nc")
    assert load(tmp_path / "result.nc").identical(result)


@both
def test_progress_adds_up_to_one(analysis):
    shares = []
    analysis(CHAOTIC, repeats=30, discard=10, progress=shares.append)
    assert len(shares) > 2
    assert sum(shares) == pytest.approx(1.0)


@both
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"repeats": 0}, "repeats = 0: must be at least 1"),
        ({"repeats": 2.5}, "repeats = 2.5: must be a whole number"),
        ({"repeats": True}, "repeats = True: must be at least 1"),
        ({"discard": -1}, "discard = -1: must be at least 0"),
        ({"initial": (9.0, 0.0)}, "start lower or raise it"),
        ({"initial": (np.nan, 0.0)}, "must be finite"),
    ],
)
def test_bad_input_is_refused(analysis, options, message):
    with pytest.raises(InputError, match=message):
        analysis(PERIODIC, **options)


@pytest.mark.parametrize("phase", [1.2, 1.0, -0.1, np.nan, "late"])
def test_a_phase_outside_the_repeat_is_refused(phase):
    with pytest.raises(InputError, match=r"phase = .*: must be"):
        section(PERIODIC, phase=phase)


# --- pictures ---------------------------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("model", [PERIODIC, varied(), ESCAPES], ids=["one", "several", "failed"])
def test_figures_are_drawn_from_the_dataset_alone(analysis, model):
    figure = section_figure(analysis(model, (0.5, 0.0), repeats=6, discard=45))
    assert isinstance(figure, Figure)
    (axes,) = figure.axes
    members = max(1, model.size)
    assert len(axes.collections) == members * (1 if analysis is section else 2)
    assert axes.get_xlabel() == ("displacement" if analysis is section else "phase within the forcing period")


def test_one_returning_point_is_not_magnified_into_rounding():
    axes = section_figure(section(PERIODIC, repeats=50)).axes[0]
    left, right = axes.get_xlim()
    assert right - left > 0.05


def test_failed_members_are_named_in_the_legend():
    figure = section_figure(section(varied(), (0.5, 0.0), repeats=6, discard=45))
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names[4].endswith("failed: outside")
    assert names[5].endswith("failed: not finite")


def test_further_states_are_points_of_the_section_too():
    model = ConeModel(bias=TurningBias(), damping_ratio=0.1, voltage=0.3, drive_frequency=0.8)
    start = (0.4, 0.0, 0.1, 0.2)
    found = section(model, start, repeats=3, discard=2)
    periods = float(model.forcing_period) * np.arange(2, 5)
    states = integrate(model, start, periods).states[0]
    names = ["displacement", "velocity", *(state.name for state in model.system.states[2:])]
    for k, name in enumerate(names):
        np.testing.assert_allclose(found[name], states[:, k], rtol=1e-12, atol=1e-14)


def test_a_motion_turns_where_its_velocity_changes_sign_also_from_a_standstill(monkeypatch):
    """Velocity -(1 - t)^3 up to its end at t = 1, where the acceleration is 0 too, and (t - 1)^3 after it; a motion of
    rounding turns nowhere."""
    times = np.array([[0.5, 1.0, 1.5], [0.25, 0.75, 1.25], [0.25, 0.75, 1.25]])
    off = times - 1.0
    size = np.array([[1.0], [1.0], [1e-14]])
    states = np.stack([0.25 * size * off**4, size * off**3], axis=-1)
    monkeypatch.setattr(section_module, "acceleration_at", lambda members, t, z: 3.0 * size * (t - 1.0) ** 2)
    monkeypatch.setattr(
        section_module, "turning_points", lambda turning, starts, begin, end, guess, kind: (guess, starts)
    )
    members = SimpleNamespace(take=lambda rows: SimpleNamespace(forcing_period=2.0))
    piece = SimpleNamespace(times=times, states=states)
    which, rows = section_module._turning_points(members, piece, {})
    assert which.tolist() == [0, 1]
    assert rows[:, 3].tolist() == [-1.0, -1.0]  # both fall before
    assert rows[0, 0] == pytest.approx(0.5, abs=1e-3)
    assert rows[1, 0] == pytest.approx(0.5, abs=0.02)


# --- what is handed on ------------------------------------------------------------------------------------------------


def pieces_of(first, count, values, outcome, **more):
    return module.Piece(first, count, np.zeros(0), values, np.array(outcome, dtype=np.int8), **more)


def test_points_are_the_begins_of_the_periods_of_each_piece(monkeypatch):
    """In two pieces, in the second of which the last of three members ends; the times are those of the points."""
    model = ConeModel(damping_ratio=0.1, drive_frequency=[0.5, 1.0, 2.0], voltage_bias=0.3)
    values = [numbers(3, 3, 2, at=5.0), numbers(3, 2, 2, at=7.0)]
    parts = [pieces_of(0, 2, values[0], [0, 4, 0]), pieces_of(2, 1, values[1], [0, 4, 3])]
    states, shares, outcome = numbers(3, 2, at=3.0), [], np.array([0, 1, 0], dtype=np.int8)

    def settled(members, states0, repeats, *, progress, tolerance, threads):
        progress(1.0)
        return states, outcome

    def run(members, begin, repeats, at, *, outcome, progress, tolerance, threads):
        progress(1.0)
        return iter(parts)

    asked = record(monkeypatch, section_module, settle=settled, pieces=run)
    found = section(
        model, (0.25, 0.5), repeats=3, discard=6, phase=0.25, tolerance=2e-9, threads=5, progress=shares.append
    )
    (before,), (after,) = asked["settle"], asked["pieces"]
    np.testing.assert_array_equal(before["states"], [[0.25, 0.5]] * 3)
    np.testing.assert_array_equal(after["states"], states)
    np.testing.assert_array_equal(after["outcome"], outcome)
    assert (before["repeats"], after["repeats"], list(after["shares"])) == (6, 3, [0.25])
    for call in (before, after):
        assert (call["tolerance"], call["threads"]) == (2e-9, 5)
    assert shares == pytest.approx([2.0 / 3.0, 1.0 / 3.0])
    points = np.concatenate([part[:, :-1] for part in values], axis=1)
    np.testing.assert_array_equal(found["displacement"], points[..., 0])
    np.testing.assert_array_equal(found["velocity"], points[..., 1])
    assert found["repeat"].values.tolist() == [6, 7, 8]
    np.testing.assert_allclose(found["time"], 2.0 * np.pi / model.drive_frequency[:, None] * [6.25, 7.25, 8.25])
    assert found["outcome"].values.tolist() == [0, 4, 3]
    options = {"repeats": 3, "discard": 6, "phase": 0.25, "tolerance": 2e-9}
    assert json.loads(found.attrs["options"]) == options


def test_turning_points_of_each_block_are_those_of_its_members_counted_from_the_start_of_the_run(monkeypatch):
    """Members 1 and 2 are sampled alike, and member 0 otherwise; of each block there are two pieces."""
    model = ConeModel(damping_ratio=0.1, drive_frequency=[0.5, 1.0, 1.0], voltage_bias=0.3)
    groups = {16: [0], 32: [1, 2]}
    monkeypatch.setattr(section_module, "samples_per_repeat", lambda members, per: np.array([16, 32, 32]))
    states, told = {1: numbers(1, 2, at=3.0), 2: numbers(2, 2, at=4.0)}, []

    def settled(members, states0, repeats, *, progress, tolerance, threads):
        progress(1.0)
        return states[members.size], np.full(members.size, members.size, dtype=np.int8)

    def run(members, begin, repeats, at, *, outcome, progress, tolerance, threads):
        progress(1.0)
        size = members.size
        yield pieces_of(0, 2, f"{size} first", [0] * size)
        yield pieces_of(2, 1, f"{size} second", [size] * size)

    def turning(members, piece, flow):
        return np.arange(members.size), np.column_stack(
            [0.25 + np.zeros(members.size), numbers(members.size, 3, at=9.0)]
        )

    asked = record(monkeypatch, section_module, settle=settled, pieces=run, _turning_points=turning)
    found = extrema(model, numbers(3, 2), repeats=3, discard=6, tolerance=2e-9, threads=5, progress=told.append)
    flow = {"tolerance": 2e-9, "threads": 5}
    for before, after, (samples, rows) in zip(asked["settle"], asked["pieces"], groups.items(), strict=True):
        np.testing.assert_array_equal(before["states"], numbers(3, 2)[rows])
        np.testing.assert_array_equal(after["states"], states[len(rows)])
        assert after["outcome"].tolist() == [len(rows)] * len(rows)
        np.testing.assert_allclose(after["shares"], np.arange(samples) / samples)
        assert (before["repeats"], after["repeats"]) == (6, 3)
        for call in (before, after):
            assert {name: call[name] for name in flow} == flow
    assert [call["flow"] for call in asked["_turning_points"]] == [flow] * 4
    assert [call["piece"].states for call in asked["_turning_points"]] == ["1 first", "1 second", "2 first", "2 second"]
    assert sum(told) == pytest.approx(1.0)
    period = 2.0 * np.pi / model.drive_frequency[:, None]
    np.testing.assert_allclose(found["time"], period * [6.25, 8.25])
    np.testing.assert_allclose(found["phase"], 0.25)
    own = np.array([numbers(1, 3, at=9.0)[0], *numbers(2, 3, at=9.0)])
    np.testing.assert_array_equal(found["displacement"], own[:, :1] + [[0.0, 0.0]])
    np.testing.assert_array_equal(found["velocity"], own[:, 1:2] + [[0.0, 0.0]])
    assert found["count"].values.tolist() == [2, 2, 2]
    assert found["outcome"].values.tolist() == [1, 2, 2]
    assert json.loads(found.attrs["options"]) == {"repeats": 3, "discard": 6, "tolerance": 2e-9}


@both
def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(analysis, integrations):
    analysis(PERIODIC, repeats=2, discard=2, tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2)}
