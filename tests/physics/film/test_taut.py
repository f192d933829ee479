"""The taut cone: its closed forms against what the contract of a film computes from the force alone, and by hand."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.physics.film.film import Film
from gelcone.physics.film.taut import TautCone
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from tests.physics.film.programs import in_program

CASES = {
    "gent": ConeModel(stretch_limit=9.0, meridional_prestretch=1.1, hoop_prestretch=1.3),
    "no limit": ConeModel(stretch_limit=np.inf),
    "compressed": ConeModel(prestretch=0.8, prestretch_mode="equibiaxial"),
    "neo-hookean": ConeModel(law="neo-hookean", prestretch=1.2),
    "yeoh": ConeModel(law="yeoh", yeoh_c2=0.1, yeoh_c3=0.02, prestretch=1.1, prestretch_mode="equibiaxial"),
}
X = np.array([-1.4, -0.3, 0.05, 0.6, 1.5])
every_case = pytest.mark.parametrize("name", CASES)
every_voltage = pytest.mark.parametrize("squared", [0.0, 0.6])


def film_and_numbers(name):
    model = CASES[name]
    return model.film, model.own_numbers


# --- closed forms against the defaults of the contract ----------------------------------------------------------------


@every_case
@every_voltage
def test_work_area_gain_and_turning_are_what_the_force_alone_gives(name, squared):
    film, n = film_and_numbers(name)
    rest = film.work(0.0, squared, [], n)
    np.testing.assert_allclose(
        film.work(X, squared, [], n) - rest, Film.work(film, X, squared, [], n), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(
        film.capacitance(X, squared, [], n), Film.capacitance(film, X, squared, [], n), rtol=1e-12
    )
    np.testing.assert_allclose(film.voltage_gain(X, squared, n), Film.voltage_gain(film, X, squared, n), rtol=1e-13)
    turning = film.turning(X, squared, n), Film.turning(film, X, squared, n)
    np.testing.assert_allclose(*turning, rtol=1e-10, atol=1e-13)
    volts = film.voltage_force(X, squared, [], n), Film.voltage_force(film, X, squared, [], n)
    np.testing.assert_allclose(*volts, rtol=1e-10, atol=1e-13)


@every_case
def test_balancing_is_the_voltage_at_which_the_force_is_the_pull(name):
    film, n = film_and_numbers(name)
    for pull in (-1.5, 0.0, 0.2, np.linspace(-1.0, 1.0, X.size)):
        squared = film.balancing(X, pull, n)
        np.testing.assert_allclose(film.force(X, squared, [], n)[0], pull * X, atol=1e-13)
        np.testing.assert_allclose(squared, Film.balancing(film, X, pull, n), rtol=1e-10, atol=1e-12)
    assert film.balancing(0.0, 0.3, n) == pytest.approx(Film.balancing(film, 0.0, 0.3, n), abs=1e-9)
    assert film.balancing(0.0, 0.3, n) == pytest.approx(film.force(0.0, 0.0, [], n)[1] - 0.3, rel=1e-13)


@every_case
@every_voltage
def test_the_slope_of_the_force_is_its_derivative(name, squared):
    film, n = film_and_numbers(name)
    step = 1e-30
    force, slope = film.force(X, squared, [], n)
    np.testing.assert_allclose(slope, np.imag(film.force(X + 1j * step, squared, [], n)[0]) / step, rtol=1e-12)
    np.testing.assert_array_equal(film.force(-X, squared, [], n)[0], -force)


def test_the_current_is_the_rate_of_the_charge():
    """d/dt (v (1 + x^2)) by hand; also of a film that does not say that its charge is linear."""
    film, n = film_and_numbers("gent")
    t = np.linspace(0.0, 6.0, 6001)[None]
    x, velocity = 0.4 * np.sin(t) + 0.2, 0.4 * np.cos(t)
    voltage, rate = 0.3 + 0.5 * np.sin(2.0 * t), np.cos(2.0 * t)
    by_hand = rate * (1.0 + x**2) + 2.0 * voltage * x * velocity
    np.testing.assert_allclose(film.current(x, velocity, voltage, rate, n), by_hand, rtol=1e-14, atol=1e-15)
    unsaid = type("Unsaid", (TautCone,), {"linear_charge": False})(film.law)
    np.testing.assert_allclose(unsaid.current(x, velocity, voltage, rate, n), by_hand, atol=1e-9)


# --- where it has a state ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_the_reach_ends_where_the_strain_is_the_limit(seed):
    rng = np.random.default_rng(seed)
    lm, lh = rng.uniform(0.6, 1.4, 2)
    flat = ConeModel(law="neo-hookean", meridional_prestretch=lm, hoop_prestretch=lh)
    limit = float(flat.strain(0.0)) * rng.uniform(1.05, 2.0) + 0.1
    model = flat.replace(law="gent", stretch_limit=limit)
    lowest, highest = model.film.reach(model.own_numbers)
    assert lowest == 0.0
    assert model.strain(highest) == pytest.approx(limit, rel=1e-12)
    x = np.linspace(-1.5 * highest, 1.5 * highest, 401)
    np.testing.assert_array_equal(np.abs(x) < highest, model.strain(x) < model.strain_limit())


def test_a_film_wider_than_its_frame_begins_only_above_the_flat_cone():
    """lm = lh = 0.5: mounted flat, I1 - 3 = 13.5 is beyond J = 8; the strain first falls as the disc rises."""
    model = ConeModel(prestretch=0.5, prestretch_mode="equibiaxial", stretch_limit=8.0)
    lowest, highest = model.film.reach(model.own_numbers)
    assert 0.0 < lowest < highest
    np.testing.assert_allclose(model.strain(np.array([lowest, highest])), 8.0, rtol=1e-12)
    assert model.strain(0.5 * (lowest + highest)) < 8.0 < model.strain(0.0)


def test_a_film_with_no_room_at_all_says_how_much_it_needs():
    model = ConeModel(prestretch=2.0, stretch_limit=0.5)
    n = model.own_numbers
    assert np.isnan(model.film.reach(n)).all()
    assert f"must exceed the smallest I1 - 3 = {1 + 4 + 0.25 - 3:.4g}" in model.film.unreachable(n)
    narrow = ConeModel(prestretch=0.5, prestretch_mode="equibiaxial", stretch_limit=0.5)
    least = narrow.strain(np.linspace(0.0, 20.0, 100_001)).min()
    assert np.isnan(narrow.film.reach(narrow.own_numbers)).all()
    assert f"= {least:.4g} " in narrow.film.unreachable(narrow.own_numbers)


def test_without_a_limit_it_reaches_everything():
    for name in ("no limit", "neo-hookean", "yeoh"):
        film, n = film_and_numbers(name)
        assert film.reach(n) == (0.0, np.inf)
    assert film.outside(1e200, n).startswith("initial displacement 1e+200: its strain is beyond what doubles hold")


def test_a_start_outside_says_its_strain():
    model = ConeModel(stretch_limit=2.0)
    text = model.film.outside(3.0, model.own_numbers)
    assert text == "stretch_limit = 2: must exceed I1 - 3 = 8.1 at the initial displacement 3; start lower or raise it"


# --- the film itself --------------------------------------------------------------------------------------------------


@every_case
@pytest.mark.parametrize("voltage", [0.0, 0.7, -0.7])
def test_the_state_is_that_of_the_stretches(name, voltage):
    """l1 = lm sqrt(q), l2 = lh, l1 l2 l3 = 1; true stress differences from the law less Maxwell's stress."""
    model = CASES[name]
    film, n = film_and_numbers(name)
    lm, lh = model.stretches
    state, q = film.state(X, voltage, [], n), 1.0 + X**2
    l1, l2 = lm * np.sqrt(q), np.broadcast_to(lh, X.shape)
    l3 = 1.0 / (l1 * l2)
    strain = l1**2 + l2**2 + l3**2 - 3.0
    response = film.law.response(strain, n)
    for found, expected in zip(
        state[:-1],
        (
            l1,
            l2,
            l3,
            (l1**2 - l3**2) * response - voltage**2 * q,
            (l2**2 - l3**2) * response - voltage**2 * q,
            abs(voltage) * np.sqrt(q),
            strain / float(film.strain_limit(n)),
        ),
        strict=True,
    ):
        np.testing.assert_allclose(np.broadcast_to(found, X.shape), expected, rtol=1e-12, atol=1e-14)


@every_case
@every_voltage
def test_the_force_does_the_work_of_the_meridional_stress(name, squared):
    """dE/dx = sigma_1 d(ln l1)/dx per film volume, at fixed hoop stretch: F = sigma_1 x/q."""
    film, n = film_and_numbers(name)
    stress = film.state(X, np.sqrt(squared), [], n).meridional_stress
    force = film.force(X, squared, [], n)[0]
    np.testing.assert_allclose(force, stress * X / (1.0 + X**2), rtol=1e-10, atol=1e-14)


def test_near_the_limit_is_beyond_its_share_of_strain():
    model = ConeModel(stretch_limit=4.0)
    x = np.linspace(0.0, model.film.reach(model.own_numbers)[1], 50)
    near = model.film.limit_share(x, 0.3, [], model.own_numbers) >= 0.8
    np.testing.assert_array_equal(near, model.strain(x) >= 3.2)
    assert near.any()
    assert not near.all()
    unlimited = ConeModel(law="neo-hookean")
    assert not unlimited.film.limit_share(x, 0.3, [], unlimited.own_numbers).any()


# --- what it takes ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_its_parameters_are_the_pre_stretches_and_those_of_its_law(law):
    film = TautCone(law)
    stretches = ["prestretch", "meridional_prestretch", "hoop_prestretch"]
    assert list(film.parameters) == [*stretches, *law.parameters, "radius_ratio"]
    assert film.complete({}) == {"prestretch": 1.0} | law.complete({})
    assert film.complete({"hoop_prestretch": 1.2}).keys() == {
        "meridional_prestretch",
        "hoop_prestretch",
        *law.parameters,
    }


def test_film_force_strain_and_limits_of_an_ensemble_are_those_of_its_members():
    model = ConeModel(stretch_limit=[4.0, np.inf, 9.0], prestretch=[[1.0], [1.2]])
    x = np.full((2, 3), 0.8)
    together = model.film_state(x, 0.4)
    for index in np.ndindex(2, 3):
        alone = model.take(np.ravel_multi_index(index, (2, 3)))
        for one, other in zip(together, alone.film_state(0.8, 0.4), strict=True):
            assert np.broadcast_to(one, (2, 3))[index] == pytest.approx(float(other), rel=1e-14)


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_a_program_has_the_stresses_and_the_force_of_a_film_with_branches(flow):
    film = TautCone(branches=1, flow=flow)
    given = {"viscous_modulus_1": 0.7, "relaxation_time_1": 3.0, "hoop_prestretch": 1.2, "stretch_limit": 30.0}
    n = film.numbers(film.complete(given | ({"viscous_limit_1": 1.5} if flow == "log" else {})))
    x, voltage, y = (
        np.linspace(0.1, 1.1, 7),
        np.linspace(0.0, 0.8, 7),
        [np.linspace(0.8, 1.1, 7), np.linspace(1.1, 0.9, 7)],
    )
    state = film.state(x, voltage, y, n)
    along, across, field, share = in_program(film.traced_state, n, {}, x, voltage**2, y)
    np.testing.assert_allclose(along, state.meridional_stress, rtol=1e-12)
    np.testing.assert_allclose(across, state.hoop_stress, rtol=1e-12)
    np.testing.assert_allclose(field, state.true_field**2, rtol=1e-12)
    np.testing.assert_allclose(share, film.limit_share(x, voltage, y, n), rtol=1e-9)
    np.testing.assert_allclose(
        in_program(film.force, n, {}, x, voltage**2, y), film.force(x, voltage**2, y, n), rtol=1e-12
    )
    assert np.abs(along - film.state(x, voltage, [], n).meridional_stress).max() > 0.1


def test_a_film_that_is_too_wide_while_flat_reaches_nothing_and_says_what_it_needs():
    """I1 - 3 is least at q = (G/A)^(1/2), which is below 1 for a film that is stretched along its meridian."""
    for lm, lh, limit in ((1.2, 1.0, 0.1), (1.3, 0.7, 0.3)):
        model = ConeModel(meridional_prestretch=lm, hoop_prestretch=lh, stretch_limit=limit)
        assert np.isnan(model.film.reach(model.own_numbers)).all()
        least = lm**2 + lh**2 + 1.0 / (lm * lh) ** 2 - 3.0
        assert least == pytest.approx(model.strain(np.linspace(0.0, 3.0, 1001)).min(), rel=1e-12)
        assert f"smallest I1 - 3 = {least:.4g} " in model.film.unreachable(model.own_numbers)


def test_a_voltage_gives_a_flat_film_no_energy_that_moves_it():
    """-2 dE/dV is the change of the capacitance: 0 while the film is flat."""
    film, n = film_and_numbers("gent")
    assert film.work(0.0, 0.7, [], n) == film.work(0.0, 0.0, [], n)
    change = -2.0 * (film.work(X, 0.7, [], n) - film.work(X, 0.0, [], n)) / 0.7
    np.testing.assert_allclose(change, film.capacitance(X, 0.3, [], n) - 1.0, rtol=1e-12)


def test_it_rests_as_long_as_its_gap_and_says_how_it_creeps():
    film = TautCone(branches=2, flow="linear")
    lengths = film.resting_lengths(X, 0.0, {})
    np.testing.assert_allclose(lengths[0], 1.0 + X**2)
    assert lengths[1] == 1.0
    assert film.describe().endswith("bears compression; it creeps: 2 Maxwell branches, linear flow")
    with pytest.raises(InputError, match="radius_ratio"):
        film.complete({"radius_ratio": 0.0})
    assert film.complete({"radius_ratio": 0.3})["radius_ratio"] == 0.3


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_the_force_of_a_film_with_branches_is_the_slope_of_what_film_and_branches_store(flow):
    film, h = TautCone(branches=1, flow=flow), 1e-5
    n = film.numbers(film.complete({"viscous_modulus_1": 0.7, "hoop_prestretch": 1.2, "stretch_limit": 30.0}))
    y = [0.8, 1.1]
    energy = [film.work(X + d, 0.3, y, n) for d in (h, -h)]
    np.testing.assert_allclose(film.force(X, 0.3, y, n)[0], (energy[0] - energy[1]) / (2.0 * h), rtol=1e-7, atol=1e-9)
    assert (np.abs(film.force(X, 0.3, y, n)[0] - film.force(X, 0.3, [], n)[0]) > 1e-3).any()
