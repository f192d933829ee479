"""Periodic orbits against certified ones: states, multipliers, and how they follow parameters."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.motion import orbit as module
from gelcone.motion.attractor.cycle import find_cycles
from gelcone.motion.flow import integrate
from gelcone.motion.orbit import Kind, Shooting, multipliers_of, newton, repeat_phase, segments_for
from gelcone.motion.settle import settle
from gelcone.physics.model import ConeModel
from tests.recorded import record

REFERENCES = json.loads((Path(__file__).parents[1] / "reference" / "continuation.json").read_text())["references"]
REGULAR = [r for r in REFERENCES if r["type"] in ("orbit", "period_doubling")]


def shooting_of(members, kind, free=("voltage",)):
    phase = repeat_phase(members)
    segments = segments_for(float(members.rate[0]), float(members.forcing_period[0]))
    return Shooting(members, free, kind, segments, phase)


@pytest.mark.parametrize("reference", REGULAR, ids=[r["key"] for r in REGULAR])
def test_certified_orbit_and_multipliers(reference):
    members = ConeModel(**reference["parameters"]).members()
    repeats = reference["period_in_drive_repeats"]
    state = np.array(reference["orbit_state_at_phase_0"])
    wanted = np.array(reference["multipliers_of_that_map"])[:, 0]
    beside = 1e-4 / max(abs(wanted[0]), 1.0)
    segments = segments_for(float(members.rate[0]), float(members.forcing_period[0]))
    *_, last = newton(members, state[None] * (1.0 + beside), repeats, segments, [1e-15] * 5)
    point = last.point + last.step
    np.testing.assert_allclose(point[0], state, atol=1e-11)
    np.testing.assert_allclose(np.exp(last.log_multipliers[0]), np.abs(wanted), rtol=1e-8)
    shooting = shooting_of(members, Kind(repeats))
    nodes = np.concatenate([point, last.path[0, :-1]])
    multipliers = shooting.multipliers(shooting.run(nodes, [members.voltage[0]]).tangents, [members.voltage[0]])
    np.testing.assert_allclose(multipliers.real, wanted, rtol=1e-9)


def test_orbit_does_not_depend_on_its_neighbours():
    volts = np.array([1.0012791591929, 1.25, 1.1])
    states = np.array([[0.1266, 0.0056], [0.3004, -0.0338], [0.2, 0.0]])
    base, once = REGULAR[0]["parameters"], np.ones(3, dtype=int)
    whole = find_cycles(ConeModel(**base | {"voltage": volts}).members(), states, once, threads=2)
    for k in range(3):
        own = slice(k, k + 1)
        alone = find_cycles(ConeModel(**base | {"voltage": volts[own]}).members(), states[own], once[own])
        for name in ("point", "exponents", "distance"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(whole, name)[k])


def test_symmetric_orbit_closes_at_its_mirror_image():
    model = ConeModel(spring_stiffness=0.9, damping_ratio=0.01, voltage=0.6, drive_frequency=0.9)
    members = model.members()
    settled = integrate(members, [1.0, 0.0], [400.0 * members.forcing_period[0]]).states[:, -1]
    found = find_cycles(members, settled, np.array([2]))
    assert found.found.all()
    assert found.symmetric.all()
    assert found.extent[0] > 0.1
    period = members.forcing_period[0]
    run = integrate(members, found.point[0], [period, 2.0 * period])
    np.testing.assert_allclose(run.states[0, 0], -found.point[0], atol=1e-11)
    np.testing.assert_allclose(run.states[0, 1], found.point[0], atol=1e-11)


@pytest.mark.parametrize("name", ["voltage", "drive_frequency", "prestretch", "stretch_limit", "damping_ratio"])
def test_slopes_are_those_of_differences(name):
    model = ConeModel(damping_ratio=0.02, voltage=1.1, voltage_bias=0.2, drive_frequency=0.4, rest_height=0.1)
    members = model.members()
    shooting, value, change = shooting_of(members, Kind(1), (name,)), float(members.values[name][0]), 1e-5
    nodes = np.tile([0.4, -0.2], (shooting.count, 1))
    ends = [shooting.run(nodes, [value + sign * change]).ends.copy() for sign in (1.0, -1.0)]
    slopes = shooting.run(nodes, [value]).slopes[..., 0]
    scale = np.abs(slopes).max()
    np.testing.assert_allclose(slopes, (ends[0] - ends[1]) / (2.0 * change), atol=3e-7 * max(scale, 1.0))


def test_map_in_phase_is_the_map_in_time():
    model = ConeModel(damping_ratio=0.02, voltage=1.1, voltage_bias=0.2, drive_frequency=0.4, rest_height=0.1)
    members = model.members()
    shooting = shooting_of(members, Kind(1))
    times = members.forcing_period[0] * np.arange(1, shooting.count + 1) / shooting.count
    run = integrate(members, [0.4, -0.2], times, keep="tangents")
    nodes = np.concatenate([[[0.4, -0.2]], run.states[0, :-1]])
    found = shooting.run(nodes, [1.1])
    np.testing.assert_allclose(found.ends, run.states[0], atol=1e-13)
    np.testing.assert_allclose(found.tangents, run.tangents[0], rtol=1e-10, atol=1e-10)


def test_multipliers_of_a_map_that_grows_beyond_doubles():
    product = np.array([[1.0, 0.5], [0.0, 0.0]])
    with np.errstate(over="ignore"):
        multipliers = multipliers_of(product, 50.0, -0.6)
    assert multipliers[0].real == pytest.approx(np.exp(50.0))
    assert multipliers[1].real == pytest.approx(np.exp(-50.6))


@pytest.mark.parametrize(
    "values",
    [
        (-0.9, -0.2),
        (1.4, 0.3),
        (0.5 + 0.6j, 0.5 - 0.6j),
    ],
)
@pytest.mark.parametrize("scale", [0.0, 2.0])
def test_multipliers_are_the_eigenvalues_with_their_signs(values, scale):
    """Of a map with such eigenvalues, scaled; the modulus of the smallest is known from the determinant."""
    size, turned = 2, np.random.default_rng(1).normal(size=(2, 2))
    blocks = np.diag(np.real(values)).astype(float)
    if np.iscomplex(values[0]):
        blocks[0, 1], blocks[1, 0] = values[0].imag, -values[0].imag
    product = turned @ blocks @ np.linalg.inv(turned)
    determinant = size * scale + float(np.log(np.abs(np.prod(values))))
    found = multipliers_of(product, scale, determinant)
    np.testing.assert_allclose(np.sort_complex(found / np.exp(scale)), np.sort_complex(np.array(values)), atol=1e-12)
    assert (np.diff(np.abs(found)) <= 1e-12 * np.abs(found[0])).all()


def test_what_is_no_orbit_is_not_found():
    # undamped and far from resonance from a point that never returns within reach
    members = ConeModel(voltage=1.3, drive_frequency=0.1, damping_ratio=0.01, spring_stiffness=0.9, stretch_limit=5.0)
    found = find_cycles(members.members(), np.array([[2.6, 5.0]]), np.array([1]))
    assert not found.found.any()


def test_orbit_of_a_wrinkling_film_crosses_its_borders():
    model = ConeModel(
        film="wrinkling", damping_ratio=0.05, spring_stiffness=1.0, rest_height=0.3, voltage=0.5, drive_frequency=0.4
    )
    members = model.members()
    period = members.forcing_period[0]
    settled = integrate(members, [0.3, 0.0], [200.0 * period]).states[:, -1]
    found = find_cycles(members, settled, np.array([1]))
    assert found.found.all()
    run = integrate(members, found.point, [period], keep="tangents")
    np.testing.assert_allclose(run.states[0, 0], found.point[0], atol=1e-12)
    shooting = shooting_of(members, Kind(1))
    times = period * np.arange(1, shooting.count) / shooting.count
    nodes = np.concatenate([found.point, integrate(members, found.point, times).states[0]])
    product = np.eye(2)
    for tangent in shooting.run(nodes, [0.5]).tangents:
        product = tangent @ product
    np.testing.assert_allclose(product, run.tangents[0, 0], atol=1e-11)


def test_two_states_with_a_film_that_drags_have_the_determinant_of_their_tangents():
    """Of a branch without states, which damps the disc as much as the disc's own damping does and more: the product of
    the multipliers is the integrated trace, and both are those of the full model."""
    numbers = {"relaxation_time_1": 0.01, "viscous_modulus_1": 2.0}
    full = ConeModel(voltage=0.3, voltage_bias=0.5, drive_frequency=0.6, rest_height=0.8, damping_ratio=0.02, **numbers)
    found = []
    for model in (full.replace(reduced="relaxation_time_1"), full):
        members = model.members()
        period = members.forcing_period[0]
        end = integrate(members, members.start_states((0.5, 0.0))[0], [60.0 * period]).states[:, -1]
        cycle = find_cycles(members, end, np.array([1]))
        run = integrate(members, cycle.point[0], [period], keep="tangents")
        segments = segments_for(float(members.rate[0]), float(period))
        *_, turn = newton(members, cycle.point, 1, segments, [1e-15] * 3)
        nodes = np.concatenate([turn.point, turn.path[0, :-1]])
        shooting = shooting_of(members, Kind())
        multipliers = shooting.multipliers(shooting.run(nodes, [0.3]).tangents, [0.3])
        found.append(np.log(np.abs(multipliers[:2])).sum())
        if model.reduced:
            assert found[0] == pytest.approx(run.divergence[0, -1], abs=1e-9)
    assert found[0] == pytest.approx(found[1], rel=2e-3)
    assert found[0] < 1.2 * -2.0 * 0.02 * period


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_another_map_of_the_same_orbit_has_the_same_settings_around_the_same_values():
    """Of what is free is no parameter itself, but stands for twice the voltage."""
    members = ConeModel(damping_ratio=0.02, voltage=1.1, drive_frequency=0.4).members()
    own = Shooting(
        members, ("half",), Kind(1), 4, np.pi, 2e-15, lambda values: {"voltage": 2.0 * np.asarray(values[0])}, (0.55,)
    )
    other = own.of_kind(Kind(2, True))
    assert (other.kind, other.free, other.segments, other.phase, other.tolerance) == (
        Kind(2, True),
        ("half",),
        4,
        np.pi,
        2e-15,
    )
    for shooting in (own, other):
        assert shooting.numbers_at((0.3,))["voltage"] == pytest.approx(0.6)
        assert shooting.members_at((np.array([0.3, 0.4]),)).number("voltage").tolist() == [0.6, 0.8]
    assert other.of_kind(Kind(1)) is own
    nodes = np.tile([0.4, -0.2], (8, 1))
    once, twice = own.run(nodes[:4], (0.5,)).ends.copy(), other.run(nodes, (0.5,)).ends
    np.testing.assert_allclose(twice, [*once, *once], rtol=1e-14)  # each repeat begins at phase 0


@pytest.mark.parametrize("kind", [Kind(1), Kind(2), Kind(1, True)])
def test_the_determinant_of_a_map_is_that_of_its_tangents(kind):
    """Over half a period of an orbit that is its own mirror image."""
    members = ConeModel(damping_ratio=0.02, voltage=1.1, drive_frequency=0.4).members()
    shooting = shooting_of(members, kind)
    nodes = np.tile([0.4, -0.2], (shooting.count, 1))
    tangents = shooting.run(nodes, [1.1]).tangents
    found = shooting.log_determinant([1.1])
    assert found == pytest.approx(np.linalg.slogdet(tangents)[1].sum(), rel=1e-9)
    assert found == pytest.approx(-2.0 * 0.02 * kind.repeats * np.pi / 0.4)


def test_newton_runs_the_motion_itself_first_and_then_each_segment_from_its_own_phase(monkeypatch):
    """With the next tolerance each time; a step leads each node to where the segments would close."""
    members = ConeModel(damping_ratio=[0.02, 0.1], voltage=[1.1, 0.5], drive_frequency=0.4).members()
    states, period = np.array([[0.4, -0.2], [0.3, 0.1]]), np.pi / 0.4
    asked = record(monkeypatch, module, integrate=integrate)
    turns = list(newton(members, states, 2, 2, [1e-8, 1e-10, 1e-12], threads=1))
    first, second, third = asked["integrate"]
    assert [call["tolerance"] for call in (first, second, third)] == [1e-8, 1e-10, 1e-12]
    assert {call["threads"] for call in (first, second, third)} == {1}
    assert {call["keep"] for call in (first, second, third)} == {"tangents"}
    at = 0.5 * period * np.arange(5)
    np.testing.assert_array_equal(first["initial"], states)
    np.testing.assert_allclose(first["times"], [at[1:]] * 2)
    assert first["start"] == 0.0
    for call in (second, third):
        np.testing.assert_allclose(call["start"], np.tile(at[:-1], 2))
        np.testing.assert_allclose(call["times"][:, 0], np.tile(at[1:], 2))
        assert call["model"].number("voltage").tolist() == [1.1] * 4 + [0.5] * 4
    np.testing.assert_array_equal(turns[0].point, states)
    np.testing.assert_allclose(turns[1].point, states + turns[0].step)
    np.testing.assert_allclose(turns[2].point, turns[1].point + turns[1].step)
    np.testing.assert_allclose(turns[0].contraction, -2.0 * np.array([0.02, 0.1]) * 2.0 * period)
    np.testing.assert_allclose(turns[0].log_multipliers.sum(axis=1), turns[0].contraction)
    run = integrate(members, states, first["times"], tolerance=1e-8)
    np.testing.assert_allclose(turns[0].path, run.states)


def test_derivatives_are_taken_along_a_tenth_of_a_value_of_either_sign():
    assert module._steps([-5.0, 0.0, 0.002, 3.0]) == pytest.approx([0.5, 1e-3, 1e-3, 0.3])


def test_small_multipliers_of_an_orbit_with_a_circuit_are_those_of_its_cycle():
    """Behind a filter and a resistance they are exp(-160) and exp(-390), of which the product of the maps, as a
    matrix, holds nothing."""
    model = ConeModel(
        film="taut", filter_time=0.02, series_resistance=0.05, voltage=0.5, voltage_bias=0.3, drive_frequency=0.8,
        damping_ratio=0.1, spring_stiffness=0.5, rest_height=0.8,
    )  # fmt: skip
    members = model.members()
    period, phase = float(members.forcing_period[0]), repeat_phase(members)
    states, _ = settle(members, members.start_states((0.9, 0.0)), 30)
    cycle = find_cycles(members, states, np.array([1]))
    segments = segments_for(float(members.fastest[0]), period)
    shooting = Shooting(members, ("voltage",), Kind(1), segments, phase)
    run = integrate(members, cycle.point, period * np.arange(1, segments) / segments)
    nodes = np.concatenate([cycle.point, run.states[0]])
    found = shooting.multipliers(shooting.run(nodes, [0.5]).tangents, [0.5])
    np.testing.assert_allclose(np.log(np.abs(found)) / period, cycle.exponents[0], rtol=1e-7)
    assert found[3].real == pytest.approx(np.exp(-50.0 * period), rel=1e-5)


def test_an_orbit_is_outside_of_the_stretch_limit_where_either_side_of_it_is():
    members = ConeModel(voltage=0.5, rest_height=0.4).members()
    shooting = shooting_of(members, Kind(1))
    nodes = np.tile([0.1, 0.0], (shooting.count, 1))
    reach = float(members.system.film.reach(members.numbers_at(0))[1])
    for farthest, inside in ((0.99 * reach, True), (1.01 * reach, False)):
        for sign in (1.0, -1.0):
            nodes[1, 0] = sign * farthest
            assert shooting.inside(nodes, (0.5,)) is inside


def test_an_orbit_of_a_double_cone_is_outside_of_the_stretch_limit_of_either_film():
    """The second film is flat at the height 0.3: seen from there it reaches as far as the first from 0."""
    pair = {"film": "taut", "second_film": "taut", "second_flat_height": 0.3, "second_drive": "same"}
    members = ConeModel(voltage=0.5, rest_height=0.15, **pair).members()
    shooting = shooting_of(members, Kind(1))
    first, second = (float(film.film.reach(members.numbers_at(0))[1]) for film in members.system.films)
    assert first == second
    nodes = np.tile([0.1, 0.0], (shooting.count, 1))
    for end, side in ((first, 1.0), (0.3 - first, -1.0)):
        for by, inside in ((-1e-3, True), (1e-3, False)):
            nodes[1, 0] = end + side * by
            assert shooting.inside(nodes, (0.5,)) is inside
