"""Members: an ensemble flattened once, its numbers by name, and what follows from them."""

import numpy as np
import pytest

from gelcone.motion.flow import integrate
from gelcone.motion.start import start_states
from gelcone.physics.bias import Together, Weight
from gelcone.physics.film.taut import TautCone
from gelcone.physics.members import Rows
from gelcone.physics.model import ConeModel
from tests.physics.test_at_rest import NoStateAbove
from tests.physics.test_system import ViscousFilm
from tests.toys import CubicBias, FilteredVoltage, PowerFilm, ThreeHarmonics


def grid(**more):
    """An ensemble of shape (2, 3) in which each parameter varies along one axis or not at all."""
    parameters = {
        "spring_stiffness": np.array([[0.5], [2.0]]),
        "stretch_limit": np.array([5.0, 20.0, np.inf]),
        "prestretch": np.array([[1.0], [1.1]]),
        "rest_height": 0.2,
        "voltage": np.array([0.1, 0.2, 0.3]),
        "damping_ratio": np.array([[0.0], [0.1]]),
    }
    return ConeModel(**parameters | more)


def test_numbers_of_members_are_held_by_blocks_with_their_bits():
    values = {"all": 0.3, "each": np.array([1.0, 2.0, 3.0]), "sign": np.array([0.0, -0.0, 0.0]), "none": np.nan}
    rows = Rows.of(values, (3,))
    assert list(rows) == list(values)
    assert "each" in rows
    assert "other" not in rows
    for name, value in values.items():
        assert rows[name].tobytes() == np.broadcast_to(value, 3).tobytes()
        assert rows.take([2, 1])[name].tobytes() == np.broadcast_to(value, 3)[[2, 1]].tobytes()
        assert rows.trailing(2)[name].shape == (3, 1, 1)
    other = rows | {"each": np.array([7.0, 8.0, 9.0])}
    assert other.missing(["each", "other"]) == ["other"]
    matrix = np.empty((3, 3))
    other.fill(["each", "sign", "all"], matrix)
    np.testing.assert_array_equal(matrix, [[7.0, 8.0, 9.0], [0.0, -0.0, 0.0], [0.3] * 3])
    np.testing.assert_array_equal(rows["each"], values["each"])
    np.testing.assert_array_equal(other.take([False, True, True])["each"], [8.0, 9.0])
    assert not Rows.of({}, (2,)).take([0])


class Lopsided(TautCone):
    """A film that is not odd in x."""

    def odd(self, n):
        return False


# --- numbers by name --------------------------------------------------------------------------------------------------


def test_members_are_the_ensemble_in_c_order():
    members = grid().members()
    assert (members.shape, members.size) == ((6,), 6)
    np.testing.assert_array_equal(members.values["spring_stiffness"], [0.5, 0.5, 0.5, 2.0, 2.0, 2.0])
    np.testing.assert_array_equal(members.number("voltage"), [0.1, 0.2, 0.3, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(members.number("rest_height"), np.full(6, 0.2))
    np.testing.assert_allclose(members.number("B"), np.repeat([1.0, 1.21], 3), rtol=1e-15)
    np.testing.assert_allclose(members.number("G"), 1.0 / members.number("B"), rtol=1e-15)
    np.testing.assert_allclose(members.number("inverse_stretch_limit"), [0.2, 0.05, 0.0] * 2, rtol=1e-15)
    assert members.prestretch.shape == (6,)
    assert ConeModel().members().size == 1


def test_the_numbers_of_one_member_are_those_of_the_model_of_that_member():
    model = grid()
    for member in range(6):
        alone = model.take(member)
        assert model.members().numbers_at(member) == pytest.approx(
            {name: float(value) for name, value in alone.own_numbers.items()}, rel=1e-15
        )
        assert list(model.members().numbers_at(member)) == list(model.system.numbers)


@pytest.mark.parametrize("index", [[4, 0, 4], slice(1, 5, 2), np.arange(6) % 3 == 1])
def test_take_gives_the_same_numbers_as_the_whole(index):
    members = grid().members()
    chosen = members.take(index)
    positions = np.arange(6)[index]
    assert chosen.size == len(positions)
    for name in members.system.numbers:
        np.testing.assert_array_equal(chosen.number(name), members.number(name)[positions])
    for name, value in members.values.items():
        np.testing.assert_array_equal(chosen.values[name], value[positions])
    np.testing.assert_array_equal(chosen.rate, members.rate[positions])
    x = np.full(chosen.size, 0.3)
    np.testing.assert_array_equal(chosen.force(x), members.force(np.full(6, 0.3))[positions])


def test_replace_changes_one_parameter_and_its_numbers():
    members = grid().members()
    changed = members.replace(prestretch=1.3, voltage=np.arange(6.0))
    np.testing.assert_allclose(changed.number("B"), np.full(6, 1.69), rtol=1e-15)
    np.testing.assert_allclose(members.number("B"), np.repeat([1.0, 1.21], 3), rtol=1e-15)
    np.testing.assert_array_equal(changed.number("voltage"), np.arange(6.0))
    np.testing.assert_array_equal(changed.number("spring_stiffness"), members.number("spring_stiffness"))
    taken = members.take([0, 1]).replace(prestretch=1.3)
    np.testing.assert_allclose(taken.number("B"), [1.69, 1.69], rtol=1e-15)


# --- what follows from them -------------------------------------------------------------------------------------------


def test_damped_is_where_the_damping_is_positive():
    np.testing.assert_array_equal(grid().members().damped, [False] * 3 + [True] * 3)


@pytest.mark.parametrize(
    "model",
    [grid(), grid(film=PowerFilm(), stretch_limit=None, prestretch=None), ConeModel(bias=CubicBias())],
    ids=["cone", "power film", "cubic"],
)
def test_with_two_states_the_trace_of_the_jacobian_is_twice_the_damping(model):
    members = model.members()
    states = np.random.default_rng(4).uniform(-0.5, 0.5, (members.size, 7, 2))
    _, jacobian = members.flow(np.zeros((members.size, 7)), states)
    trace = np.broadcast_to(jacobian[0][0] + jacobian[1][1], (members.size, 7))
    np.testing.assert_allclose(
        trace, np.broadcast_to(-2.0 * members.values["damping_ratio"][:, None], trace.shape), atol=1e-15
    )


def test_the_mirror_image_is_a_motion_where_nothing_pushes_the_flat_film():
    model = ConeModel(rest_height=[0.0, 0.1, 0.0], spring_stiffness=[1.0, 1.0, 0.0], voltage_bias=0.3)
    np.testing.assert_array_equal(model.members().symmetric, [True, False, True])
    assert ConeModel(rest_height=0.1, spring_stiffness=0.0).members().symmetric.all()
    assert ConeModel(bias=CubicBias(), waveform=ThreeHarmonics()).members().symmetric.all()
    assert not ConeModel(film=Lopsided()).members().symmetric.any()


@pytest.mark.parametrize(
    "model",
    [ConeModel(voltage_bias=0.2), ConeModel(film=ViscousFilm(), circuit=FilteredVoltage(), bias=CubicBias())],
    ids=["cone", "four states"],
)
def test_symmetric_members_have_mirrored_rates(model):
    members = model.members()
    assert members.symmetric.all()
    states = np.random.default_rng(5).uniform(-0.5, 0.5, (1, 9, len(model.system.states)))
    times = np.linspace(0.0, 3.0, 9)[None]
    rates, mirrored = (np.array(members.flow(times, s)[0]) for s in (states, states * model.system.mirror))
    np.testing.assert_allclose(mirrored, rates * model.system.mirror[:, None, None], atol=1e-15)


def test_starts_have_displacement_and_velocity_and_what_the_components_say():
    np.testing.assert_array_equal(grid().members().start_states((0.3, -0.1)), np.tile([0.3, -0.1], (6, 1)))
    model = ConeModel(film=ViscousFilm(), circuit=FilteredVoltage(), voltage=[0.1, 0.2])
    np.testing.assert_array_equal(model.members().start_states((0.3, 0.0)), np.tile([0.3, 0.0, 0.1, 0.0], (2, 1)))


class Rested(ViscousFilm):
    """Its dashpot has followed the disc."""

    def starts(self, x, n):
        return [x * n["branch"]]


def test_the_start_of_a_state_may_follow_from_displacement_and_parameters():
    model = ConeModel(film=Rested(), second_film=Rested(), bias=Together((CubicBias(), Weight())), branch=[0.4, 0.5])
    model = model.replace(second_flat_height=0.2)
    expected = [[0.3, 0.1, 0.12, -0.04], [-0.4, 0.0, -0.2, 0.3]]
    np.testing.assert_allclose(model.members().start_states([[0.3, 0.1], [-0.4, 0.0]]), expected, atol=1e-15)
    for states in (start_states(model, [[0.3, 0.1], [-0.4, 0.0]]), integrate_at_once(model)):
        np.testing.assert_allclose(states, expected, atol=1e-15)


def integrate_at_once(model):
    """The states with which the integrator begins."""
    return integrate(model, [[0.3, 0.1], [-0.4, 0.0]], [0.0]).states[:, 0]


@pytest.mark.parametrize("samples", [(), (5,)])
def test_the_flow_of_members_is_that_of_each_alone(samples):
    model = grid(circuit=FilteredVoltage(), filter_time=[[0.2], [0.5]])
    members, rng = model.members(), np.random.default_rng(6)
    times, states = rng.uniform(0.0, 5.0, (6, *samples)), rng.uniform(-0.4, 0.4, (6, *samples, 3))
    rates, jacobian = members.flow(times, states)
    volts = members.voltages(times, states)[0]
    assert volts.shape == times.shape
    for member in range(6):
        n = members.numbers_at(member)
        for at in np.ndindex(samples):
            one, rows = model.system.flow(times[(member, *at)], states[(member, *at)], n)
            for i in range(3):
                assert np.broadcast_to(rates[i], times.shape)[(member, *at)] == pytest.approx(one[i], rel=1e-12)
                for j in range(3):
                    got = np.broadcast_to(jacobian[i][j], times.shape)[(member, *at)]
                    assert got == pytest.approx(rows[i][j], rel=1e-12, abs=1e-15)
            assert volts[(member, *at)] == states[(member, *at, 2)]


FILMS = {
    "wrinkling": {"film": "wrinkling"},
    "membrane": {"film": "membrane", "stretch_limit": 50.0},
    "creeping": {"film": "wrinkling", "viscous_modulus_1": 0.6, "relaxation_time_1": 2.0},
    "two": {
        "film": "wrinkling",
        "second_film": "wrinkling",
        "second_flat_height": 1.0,
        "second_drive": "constant",
        "second_voltage": 0.4,
    },
}
CIRCUITS = {
    "resistance": {"series_resistance": 0.5},
    "leak": {"series_resistance": 0.5, "leakage_time": 4.0},
    "limit": {"series_resistance": 0.3, "filter_time": 0.2, "current_limit": 0.5},
}
RATED = [
    *((film, "resistance") for film in FILMS),
    *(
        pytest.param(film, other, marks=pytest.mark.slow)
        for film in ("wrinkling", "creeping", "two")
        for other in CIRCUITS
    ),
]


@pytest.mark.parametrize(("film", "circuit"), RATED)
def test_the_rates_of_a_motion_are_those_with_which_its_states_change(film, circuit):
    """By central differences of the integrator's states, of a film that goes slack behind a resistance."""
    drive = {"voltage": 0.3, "voltage_bias": 0.4, "drive_frequency": 0.9, "damping_ratio": 0.2, "hoop_prestretch": 1.1}
    model, h = ConeModel(**FILMS[film], **CIRCUITS[circuit], **drive, rest_height=0.6), 1e-5
    members, at = model.members(), np.array([[0.7, 2.1, 3.3, 5.2, 6.4]])
    times = np.sort(np.concatenate([at - h, at, at + h], axis=1))
    states = integrate(members, [0.7, 0.1], times, tolerance=1e-14).states
    changes = (states[:, 2::3] - states[:, ::3]) / (2.0 * h)
    rates = np.stack(np.broadcast_arrays(*members.flow(at, states[:, 1::3])[0]), axis=-1)
    np.testing.assert_allclose(rates, changes, atol=2e-9)
    n = members.numbers(1)
    borders = members.system.switches(at, list(np.moveaxis(states[:, 1::3], -1, 0)), n)
    assert any((side != n[name]).any() for name, side in borders.items())


def test_the_rate_bounds_how_fast_deviations_move():
    """No eigenvalue of the Jacobian is larger, over displacements up to half the width of the film."""
    model = grid(voltage_bias=0.4)
    members = model.members()
    x = np.linspace(-0.5, 0.5, 21)
    states = np.stack(np.broadcast_arrays(x, 0.0), axis=-1)
    _, jacobian = members.flow(np.full((6, 21), 1.3), np.broadcast_to(states, (6, 21, 2)))
    slope = np.broadcast_to(jacobian[1][0], (6, 21))
    fastest = np.sqrt(np.abs(slope)).max(axis=1)
    assert (members.rate >= fastest).all()
    assert members.rate.shape == (6,)
    np.testing.assert_allclose(
        members.rate,
        2.0 * members.values["damping_ratio"]
        + np.sqrt(1.0 + members.number("spring_stiffness") + 1.0 + (members.number("voltage") + 0.4) ** 2),
        rtol=1e-14,
    )


def test_a_parameter_has_its_name_and_another_name_is_none():
    members = grid().members()
    assert members.meridional_prestretch is None
    with pytest.raises(AttributeError, match="has no parameter 'volage'"):
        _ = members.volage


@pytest.mark.parametrize(
    ("drive", "more", "squares"), [("same", {}, 2 * 0.9), ("constant", {"second_voltage": 0.7}, 0.9 + 0.49)]
)
def test_the_rate_counts_the_fields_of_all_films_at_their_peaks(drive, more, squares):
    pair = ConeModel(film="taut", second_film="taut", second_flat_height=0.5, second_drive=drive, **more)
    volts = np.sqrt(0.9)
    rates = [
        float(pair.replace(voltage=amplitude * volts, voltage_bias=bias * volts, damping_ratio=0.1).members().rate[0])
        - 0.2
        for amplitude, bias in ((0.3, 0.7), (0.0, 0.0))
    ]
    second = more.get("second_voltage", 0.0) ** 2
    assert rates[0] ** 2 - rates[1] ** 2 == pytest.approx(squares - second, rel=1e-12)


@pytest.mark.parametrize("more", [{"hoop_prestretch": 1.2}, {"film": "taut", "second_film": "taut"}])
def test_the_energy_is_the_integral_of_the_static_force_of_films_and_bias(more):
    model = ConeModel(rest_height=0.4, **more)
    x = np.linspace(0.1, 0.8, 2001)
    force = np.array([float(model.force(place)) for place in x])
    energies = [float(np.ravel(model.members().energy(place))[0]) for place in (0.1, 0.8)]
    assert energies[1] - energies[0] == pytest.approx(np.trapezoid(force, x), rel=1e-6)
    assert energies == [float(model.energy(place)) for place in (0.1, 0.8)]


def test_force_and_stiffness_are_known_up_to_the_voltage_at_which_a_film_pulls_in():
    """And within the stretch limit; above either they are NaN."""
    model = ConeModel(film="wrinkling", stretch_limit=[50.0, 20.0], prestretch=1.1, spring_stiffness=0.7)
    x = np.array([0.6, 0.7])
    highest = np.sqrt(model.film.highest_squared(x, model.numbers()))
    for share, known in ((0.0, True), (0.7, True), (0.999, True), (1.001, False)):
        for found in (model.force(x, share * highest), model.stiffness(x, share * highest)):
            np.testing.assert_array_equal(np.isfinite(found), known)
    assert np.isnan(model.force(np.array([0.6, 9.0]))).tolist() == [False, True]


def test_a_pair_whose_second_film_has_pulled_in_has_no_force_also_without_voltage_on_the_first():
    pair = ConeModel(film="wrinkling", second_film="wrinkling", second_drive="constant", second_voltage=[0.1, 5.0])
    assert np.isfinite(pair.force(np.array([0.3, 0.3]))).tolist() == [True, False]
    pair = ConeModel(film=PowerFilm(), second_film=NoStateAbove(), second_drive="constant", second_voltage=[1.4, 1.42])
    assert np.isfinite(pair.force(np.array([0.3, 0.3]))).tolist() == [True, False]


def test_a_fast_circuit_bounds_how_fast_deviations_move_and_a_slow_part_how_long_they_last():
    """A film behind a resistance follows within rho (1 + x^2); the slowest of film, bias and circuit counts."""
    model = ConeModel(film="taut", series_resistance=[0.02, 0.001], voltage=0.3)
    np.testing.assert_allclose(model.members().fastest, [50.0, 1000.0], rtol=1e-12)
    slow = ConeModel(
        film="taut", filter_time=[0.5, 30.0], viscous_modulus_1=0.5, relaxation_time_1=6.0, voltage=0.3
    ).members()
    np.testing.assert_allclose(slow.time_constant, [9.0, 30.0], rtol=1e-14)
    saturated = ConeModel(film="taut", filter_time=0.01, slew_rate=0.1, voltage_bias=1.0, voltage=[0.1, 0.3])
    np.testing.assert_allclose(saturated.members().fastest, [100.0, 100.0], rtol=1e-12)
    turning = ConeModel(film="taut", bias=Slow(), filter_time=0.5).members()
    np.testing.assert_allclose(turning.time_constant, [70.0])


class Slow(CubicBias):
    """A bias that takes long to settle."""

    name = "slow"

    def time_constant(self, n):
        return 70.0


def test_a_field_that_follows_late_presses_the_film_by_what_of_it_is_there():
    """Stresses are those of the square (1 - chi) v^2 + chi w^2, the true field that of v."""
    model = ConeModel(film="taut", dielectric_share=0.4, dielectric_time=2.0, voltage=0.5, hoop_prestretch=1.2)
    members = model.members()
    x, late, v = 0.6, 0.2, np.array([[0.7]])
    area = 1.0 + x * x
    assert [state.name for state in model.system.states[2:]] == ["slow_charge"]
    (found,) = members.film_states(np.array([[[x, 0.1, area * late]]]), [v])
    squared = 0.6 * 0.49 + 0.4 * late**2
    held = members.system.film.state(x, np.sqrt(squared), [], members.numbers_at(0))
    for name in ("meridional_stress", "hoop_stress"):
        assert getattr(found, name).item() == pytest.approx(float(getattr(held, name)), rel=1e-12)
    assert found.true_field.item() == pytest.approx(0.7 * np.sqrt(area), rel=1e-12)


def test_the_state_of_an_ensembles_film_takes_samples_of_each_member():
    model = ConeModel(hoop_prestretch=[1.1, 1.3])
    x = np.array([[0.1, 0.4, 0.9], [0.2, 0.5, 1.0]])
    found = model.film_state(x, 0.3)
    for k, row in enumerate(x):
        own = model.take(k).film_state(row, 0.3)
        for name in ("hoop_stretch", "meridional_stress", "limit_share"):
            together = np.broadcast_to(getattr(found, name), x.shape)[k]
            np.testing.assert_allclose(together, np.broadcast_to(getattr(own, name), 3), rtol=1e-14)


def test_the_rate_counts_the_stiffness_of_a_flat_film_that_is_close_to_its_limit():
    """h + kappa at the flat film, where that is more than A + kappa."""
    model = ConeModel(hoop_prestretch=1.9, stretch_limit=2.0, spring_stiffness=0.5, voltage=0.0, damping_ratio=0.0)
    stiffness = float(model.stiffness(0.0))
    assert stiffness > 3.0
    assert model.members().rate[0] == pytest.approx(np.sqrt(1.0 + stiffness), rel=1e-12)


def test_each_film_of_a_pair_has_the_state_of_its_own_place_voltage_and_branches():
    pair = ConeModel(
        film="taut", second_film="taut", second_flat_height=0.9, second_hoop_prestretch=1.3, viscous_modulus_1=0.5,
        relaxation_time_1=3.0, viscous_limit_1=9.0,
    )  # fmt: skip
    members, z = pair.members(), np.array([[[0.2, 0.0, 0.9, 1.0, 0.7, 1.1]]])
    first, second = members.film_states(z, [np.array([[0.3]]), np.array([[0.6]])])
    n = members.numbers_at(0)
    own = {name.removeprefix("second_"): value for name, value in n.items() if name.startswith("second_")}
    film = pair.film
    for found, right in ((first, film.state(0.2, 0.3, [0.9, 1.0], n)), (second, film.state(0.7, 0.6, [0.7, 1.1], own))):
        for value, exact in zip(found[:-1], right[:-1], strict=True):
            assert np.ravel(value)[0] == pytest.approx(float(np.ravel(exact)[0]), rel=1e-13)


@pytest.mark.parametrize("samples", [10, 3, 1])
def test_what_is_evaluated_along_motions_in_blocks_has_the_bits_of_the_whole(monkeypatch, samples):
    """No more samples than a block are evaluated at once, so that the memory of long runs is bounded."""
    members, times = grid().members(), np.linspace(0.0, 9.0, 60).reshape(6, 10)
    states = np.stack([0.5 + 0.1 * np.sin(times), 0.1 * np.cos(times)], axis=-1)
    whole, sizes, currents = members.along(members.system.currents, times, states), [], members.system.currents
    monkeypatch.setattr("gelcone.physics.members.SAMPLES", samples)

    def observed(tau, z, n):
        sizes.append((tau.shape, z[1].shape))
        return currents(tau, z, n)

    in_blocks = members.along(observed, times, states)
    assert [part[0] for part in sizes] == [part[1] for part in sizes]
    assert [part[0][-1] for part in sizes] == [min(samples, 10 - begin) for begin in range(0, 10, samples)]
    for one, other in zip(in_blocks, whole, strict=True):
        assert one.tobytes() == other.tobytes()
    assert members.along(currents, times[:, :0], states[:, :0])[0].shape == (6, 0)
