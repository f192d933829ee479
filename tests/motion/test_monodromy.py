"""The map over one repeat: closed forms, WKB, its determinant, and the motion itself."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone import ConeModel, floquet_multipliers, integrate, pitchfork_voltage
from gelcone.codes import Outcome
from gelcone.motion import monodromy as module
from tests.recorded import numbers, record
from tests.toys import FilteredVoltage


def test_without_drive_the_multipliers_are_those_of_the_damped_oscillator():
    zeta = np.array([0.0, 0.05, 0.5, 3.0])
    result = floquet_multipliers(ConeModel(damping_ratio=zeta, voltage=0.0, spring_stiffness=1.5))
    root = np.sqrt((zeta**2 - 1.5).astype(complex))
    expected = np.exp((-zeta[:, None] + root[:, None] * [1.0, -1.0]) * np.pi)
    computed = result.multiplier_real.values + 1j * result.multiplier_imag.values
    np.testing.assert_allclose(np.sort_complex(computed), np.sort_complex(expected), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(result.growth_rate, np.log(np.abs(expected[:, 0])) / np.pi, atol=1e-13)


def test_a_constant_voltage_grows_where_it_is_above_the_pitchfork():
    """No amplitude, a bias alone: growth rate -zeta + sqrt(zeta^2 - k + bias^2)."""
    bias = np.array([0.5, 1.2, 1.25, 2.0])
    model = ConeModel(voltage=0.0, voltage_bias=bias, spring_stiffness=1.5, damping_ratio=0.1)
    result = floquet_multipliers(model)
    expected = np.real(-0.1 + np.sqrt((0.01 - 1.5 + bias**2).astype(complex)))
    np.testing.assert_allclose(result.growth_rate, expected, atol=1e-12)
    assert ((result.margin > 0.0).values == (bias > pitchfork_voltage(model).pitchfork_voltage)).all()


def test_a_long_repeat_does_not_overflow():
    """At omega = 2e-4 deviations grow by more than e^1000 in one repeat, as WKB says to a few per mille."""
    omega, v, k = 2e-4, 2.0, 1.5
    result = floquet_multipliers(ConeModel(drive_frequency=omega, voltage=v, spring_stiffness=k, damping_ratio=0.01))
    phase = np.linspace(0.0, np.pi, 100_001)
    wkb = np.trapezoid(np.sqrt(np.maximum(v**2 * np.sin(phase) ** 2 - k + 1e-4, 0.0)), phase) / np.pi - 0.01
    assert float(result.log_modulus[0]) > 1000.0
    assert np.isinf(result.spectral_radius)
    assert float(result.growth_rate) == pytest.approx(wkb, rel=5e-3)
    assert abs(float(result.product_error)) < 1e-8


@given(
    st.floats(0.0, 2.0),
    st.floats(0.0, 3.0),
    st.floats(0.05, 5.0),
    st.sampled_from([0.0, 0.4]),
    st.floats(0.8, 1.4),
)
@settings(max_examples=30, deadline=None)
def test_the_multipliers_multiply_to_the_damping_of_a_repeat(zeta, voltage, omega, bias, stretch):
    model = ConeModel(damping_ratio=zeta, voltage=voltage, drive_frequency=omega, voltage_bias=bias, prestretch=stretch)
    result = floquet_multipliers(model)
    repeat = (2.0 if bias else 1.0) * np.pi / omega
    assert float(result.forcing_period) == pytest.approx(repeat)
    assert abs(float(result.product_error)) < 1e-9
    assert float(result.log_modulus.sum()) == pytest.approx(-2.0 * zeta * repeat, abs=1e-9)


def test_the_map_is_the_tangent_map_of_the_motion():
    """Two finite deviations through the full equations of motion give the same multipliers."""
    model = ConeModel(voltage=0.8, drive_frequency=0.9)
    small = 1e-7
    columns = [integrate(model, state, [float(model.forcing_period)]).states[0, 0] for state in small * np.eye(2)]
    expected = np.linalg.eigvals(np.array(columns).T / small)
    result = floquet_multipliers(model)
    computed = result.multiplier_real.values + 1j * result.multiplier_imag.values
    np.testing.assert_allclose(np.sort_complex(computed), np.sort_complex(expected), atol=1e-10)


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_the_maps_of_members_with_as_many_pieces_are_run_together_with_the_options(monkeypatch):
    """The first and the last of three; the tangents are those of the disc, which come first."""
    members = ConeModel(damping_ratio=[0.1, 0.2, 0.3], drive_frequency=[1.0, 0.01, 1.0]).members()
    resting, shares = numbers(3, 2), []

    def ran(members, states, times, **options):
        options["progress"](1.0)
        tangents = np.broadcast_to(np.eye(3), (*times.shape, 3, 3)).copy()
        tangents[:, 0, :2, :2] = np.diag([2.0, 0.25])
        tangents[:, 0, 2, 2] = 7.0
        return SimpleNamespace(tangents=tangents, outcome=np.full(len(states), len(asked["integrate"]), dtype=np.int8))

    asked = record(monkeypatch, module, integrate=ran, _resting=(resting, np.zeros(3, dtype=np.int8)))
    found = module.monodromy(members, {"tolerance": 2e-9, "threads": 5}, shares.append)
    assert asked["_resting"][0]["options"] == {"tolerance": 2e-9, "threads": 5}
    few, many = sorted(asked["integrate"], key=lambda call: call["times"].shape[1])
    for call, rows in ((few, [0, 2]), (many, [1])):
        np.testing.assert_allclose(call["model"].damping_ratio, np.array([0.1, 0.2, 0.3])[rows])
        np.testing.assert_array_equal(call["initial"], resting[rows])
        count = call["times"].shape[1]
        np.testing.assert_allclose(
            call["times"], np.pi * np.array([1.0, 100.0, 1.0])[rows, None] * np.arange(1, count + 1) / count
        )
        assert (call["keep"], call["tolerance"], call["threads"]) == ("tangents", 2e-9, 5)
        assert found.outcome[rows].tolist() == [1 + (call is asked["integrate"][1])] * len(rows)
    assert few["times"].shape[1] < many["times"].shape[1]
    np.testing.assert_allclose(found.trace * np.exp(found.log_scale), 2.25)
    np.testing.assert_allclose(found.repeat, [np.pi, 100.0 * np.pi, np.pi])
    np.testing.assert_allclose(found.log_product, -2.0 * np.array([0.1, 0.2, 0.3]) * found.repeat)
    np.testing.assert_allclose(found.product_error, np.expm1(np.log(0.5) - found.log_product))
    assert sum(shares) == pytest.approx(1.0)


def test_states_besides_the_discs_settle_with_the_options_until_they_no_longer_change(monkeypatch):
    """64 forcing periods at a time; of two states there is nothing to wait for."""
    runs = iter([(1.0, [0, 0]), (0.5, [0, 6]), (0.5, [0, 4])])

    def ran(members, states, times, **options):
        value, outcome = next(runs)
        return SimpleNamespace(states=np.tile([0.0, 0.0, value], (members.size, 1, 1)), outcome=np.array(outcome))

    asked = record(monkeypatch, module, integrate=ran)
    members = ConeModel(circuit=FilteredVoltage(), drive_frequency=0.5, damping_ratio=[0.1, 0.2]).members()
    states, outcome = module._resting(members, {"tolerance": 2e-9, "threads": 5})
    assert states.tolist() == [[0.0, 0.0, 0.5]] * 2
    assert outcome.tolist() == [0, 6]  # how a member first ended
    assert len(asked["integrate"]) == 3
    for call in asked["integrate"]:
        np.testing.assert_allclose(call["times"], module.SETTLING * np.full((2, 1), float(members.forcing_period[0])))
        assert (call["tolerance"], call["threads"]) == (2e-9, 5)
    states, outcome = module._resting(ConeModel().members(), {"tolerance": 2e-9, "threads": 5})
    assert (states.tolist(), outcome.tolist()) == ([[0.0, 0.0]], [0])


def test_a_flat_film_that_pulls_in_before_it_has_settled_says_so():
    creeping = {"film": "wrinkling", "viscous_modulus_1": 0.5, "relaxation_time_1": 10.0, "hoop_prestretch": 1.4}
    found = floquet_multipliers(ConeModel(**creeping, voltage=[0.5, 3.0], drive_frequency=0.5))
    assert found.outcome.values.tolist() == [Outcome.OK, Outcome.PULLED_IN]
    assert np.isfinite(found.multiplier_real.values).tolist() == [[True, True], [False, False]]
