"""Poincare sections: returning points, phases, turning points against SciPy, ensembles to the last bit, contracts."""

import importlib
import json

import numpy as np
import pytest
from matplotlib.figure import Figure

import gelcone
from gelcone.codes import Outcome
from gelcone.dataset import load, model_of, save
from gelcone.errors import InputError
from gelcone.motion import settle as module
from gelcone.motion.extrema import extrema
from gelcone.motion.flow import integrate
from gelcone.motion.section import section
from gelcone.physics.model import ConeModel
from gelcone.plots.section import section_figure
from tests.motion.sampled import CHAOTIC, PERIODIC, pieces_of
from tests.recorded import numbers, record
from tests.toys import TurningBias

section_module = importlib.import_module("gelcone.motion.section")
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


@both
def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(analysis, integrations):
    analysis(PERIODIC, repeats=2, discard=2, tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2)}
