"""Biases: closed forms against the contract's numerical defaults, several together, and what each does to a disc."""

import json

import numpy as np
import pytest

from gelcone import simulate
from gelcone.errors import InputError
from gelcone.physics.bias import BIASES, Bias, BuckledBeam, ConstantForce, LinearSpring, Together, Weight
from gelcone.physics.component import State
from gelcone.physics.model import ConeModel
from gelcone.physics.records import bias_record, find_bias
from gelcone.physics.statics import balances_of, rest_displacement
from tests.physics.test_system import Lagging
from tests.toys import CubicBias, PowerFilm, TurningBias

SPRING = LinearSpring()
X = np.array([-2.0, -0.3, 0.1, 0.7, 3.0])
NUMBERS = [{"spring_stiffness": kappa, "rest_height": x0} for kappa in (0.0, 1.7) for x0 in (0.0, 0.4, -0.2)]
every_spring = pytest.mark.parametrize("n", NUMBERS, ids=[f"{n}" for n in NUMBERS])


@every_spring
def test_the_springs_force_is_the_slope_of_its_energy(n):
    h = 1e-30
    force, slope = SPRING.force(X, [], n)
    np.testing.assert_allclose(force, np.imag(SPRING.energy(X + 1j * h, n)) / h, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(np.broadcast_to(slope, X.shape), np.imag(SPRING.force(X + 1j * h, [], n)[0]) / h)


@every_spring
def test_the_springs_closed_forms_are_the_defaults_of_the_contract(n):
    own, rest = SPRING.energy(X, n), SPRING.energy(0.0, n)
    np.testing.assert_allclose(own - rest, Bias.energy(SPRING, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(SPRING.turning(X, n), Bias.turning(SPRING, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(SPRING.secant(X, n), Bias.secant(SPRING, X, n), rtol=1e-12, atol=1e-14)
    assert SPRING.stiffness_scale(n) == Bias.stiffness_scale(SPRING, n)


@every_spring
def test_at_the_flat_film_the_secant_is_its_limit(n):
    push = n["spring_stiffness"] * n["rest_height"]
    for bias in (SPRING.secant, lambda x, n: Bias.secant(SPRING, x, n)):
        found = bias(0.0, n)
        assert found == (n["spring_stiffness"] if push == 0.0 else -np.copysign(np.inf, push))


@every_spring
def test_at_its_free_height_a_bias_does_not_pull(n):
    assert SPRING.force(SPRING.free_height(n), [], n)[0] == 0.0
    assert SPRING.energy(n["rest_height"], n) == 0.0


def test_the_spring_pulls_the_disc_down_where_it_is_above_its_free_height():
    n = {"spring_stiffness": 2.0, "rest_height": 0.5}
    assert SPRING.force(0.75, [], n) == (0.5, 2.0)
    assert SPRING.energy(0.75, n) == 0.0625
    assert SPRING.turning(3.0, n) == 1.0
    assert SPRING.secant(2.0, n) == 1.5


def test_one_member_at_rest_height_zero_among_others_has_its_own_secant():
    n = {"spring_stiffness": np.array([1.0, 1.0]), "rest_height": np.array([0.0, 0.5])}
    np.testing.assert_array_equal(SPRING.secant(np.array([2.0, 2.0]), n), [1.0, 0.75])


def test_a_cubic_bias_by_hand():
    """F = k1 x + k3 x^3 from its force alone: E = k1 x^2/2 + k3 x^4/4, x F' - F = 2 k3 x^3, F/x = k1 + k3 x^2."""
    bias, n = CubicBias(), {"bias_stiffness": -0.8, "bias_cubic": 0.5}
    np.testing.assert_allclose(bias.energy(X, n), -0.4 * X**2 + 0.125 * X**4, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(bias.turning(X, n), X**3, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(bias.secant(X, n), -0.8 + 0.5 * X**2, rtol=1e-13)
    assert bias.secant(0.0, n) == -0.8
    assert bias.free_height(n) == 0.0
    assert bias.stiffness_scale(n) == 0.8
    assert bias.rates(0.1, 0.2, [], n) == []
    assert bias.states == ()


def test_the_stiffness_scale_of_a_buckled_beam_adds_what_buckling_takes():
    bias = BIASES["beam"]
    n = {"beam_stiffness": -0.5, "beam_cubic": 0.8, "beam_height": 0.3}
    assert float(bias.stiffness_scale(n)) == pytest.approx(0.5 + 3.0 * 0.8 * 0.7**2, rel=1e-14)


@pytest.mark.parametrize("height", [0.2, 0.7, -0.4])
def test_the_stiffness_scale_of_a_beam_covers_its_slope_over_the_width_and_is_met_at_its_end(height):
    bias = BIASES["beam"]
    n = {"beam_stiffness": 0.3, "beam_cubic": 0.8, "beam_height": height}
    _, slope = bias.force(np.linspace(0.0, 1.0, 201), [], n)
    assert np.abs(slope).max() == pytest.approx(float(bias.stiffness_scale(n)), rel=1e-12)


def test_the_table_of_biases():
    assert all(bias.name == name for name, bias in BIASES.items())
    assert isinstance(BIASES["spring"], LinearSpring)


# --- all that ship, and several together ------------------------------------------------------------------------------

CASES = {
    "beam": {"beam_stiffness": -0.7, "beam_cubic": 1.3, "beam_height": 0.25},
    "weight": {"weight": 0.3},
    "force": {"push": 0.2},
    "spring+weight": {"spring_stiffness": 1.7, "rest_height": 0.4, "weight": -0.3},
    "beam+weight+force": {
        "beam_stiffness": -0.7,
        "beam_cubic": 1.3,
        "beam_height": 0.0,
        "weight": 0.3,
        "push": 0.3,
    },
}
every_bias = pytest.mark.parametrize("name", CASES)


@every_bias
def test_force_energy_and_slope_belong_together(name):
    bias, n, h = find_bias(name), CASES[name], 1e-30
    force, slope = bias.force(X, [], n)
    np.testing.assert_allclose(force, np.imag(bias.energy(X + 1j * h, n)) / h, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(np.broadcast_to(slope, X.shape), np.imag(bias.force(X + 1j * h, [], n)[0]) / h)
    energy = bias.energy(X, n) - bias.energy(0.0, n)
    np.testing.assert_allclose(energy, Bias.energy(bias, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(bias.turning(X, n), Bias.turning(bias, X, n), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(bias.secant(X, n), force / X, rtol=1e-13)


@every_bias
def test_an_odd_bias_is_one_whose_mirror_image_it_is(name):
    bias = find_bias(name)
    for n in (CASES[name], dict.fromkeys(CASES[name], 0.0), CASES[name] | {"weight": 0.0, "push": 0.0}):
        mirrored = np.allclose(bias.force(-X, [], n)[0], -bias.force(X, [], n)[0], rtol=0.0, atol=1e-15)
        # equal weight and constant force cancel; that they do is not looked for
        assert bool(bias.odd(n)) == (mirrored and not n.get("weight", 0.0))


def test_a_beam_that_is_free_at_the_flat_film_is_no_mirror_image():
    """It does not push the flat film, but the mirror image of a motion is none."""
    n = {"beam_stiffness": -1.0, "beam_cubic": 4.0, "beam_height": 0.5}
    model = ConeModel(bias="beam", **n)
    assert BuckledBeam().force(0.0, [], n)[0] == 0.0
    assert BuckledBeam().free_height(n) == 1.0
    assert not model.members().symmetric[0]
    assert ConeModel(bias="beam").members().symmetric[0]


@pytest.mark.parametrize(("name", "height"), [("beam", 0.25 + np.sqrt(0.7 / 1.3)), ("spring+weight", 0.4 + 0.3 / 1.7)])
def test_where_a_buckled_beam_and_a_loaded_spring_are_free(name, height):
    bias, n = find_bias(name), CASES[name]
    assert bias.free_height(n) == pytest.approx(height, rel=1e-15)
    assert bias.force(bias.free_height(n), [], n)[0] == pytest.approx(0.0, abs=1e-15)


def test_a_beam_that_is_not_buckled_is_free_where_it_is_straight():
    for stiffness, cubic in [(0.5, 1.0), (0.0, 1.0), (-0.5, 0.0), (0.0, 0.0)]:
        n = {"beam_stiffness": stiffness, "beam_cubic": cubic, "beam_height": 0.3}
        assert BuckledBeam().free_height(n) == 0.3


def test_weight_pulls_down_and_a_constant_force_pushes_up():
    assert Weight().force(0.7, [], {"weight": 0.2})[0] == 0.2
    assert ConstantForce().force(0.7, [], {"push": 0.2})[0] == -0.2
    assert Weight().stiffness_scale({"weight": 0.2}) == 0.0


# --- records ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bias", "record"),
    [
        (Together((LinearSpring(), Weight())), "spring+weight"),
        (Together((BuckledBeam(), CubicBias())), "beam+tests.toys:CubicBias"),
        (Weight(), "weight"),
    ],
)
def test_several_are_written_as_their_names_with_a_plus(bias, record):
    assert bias_record(bias) == record
    assert find_bias(json.loads(json.dumps(bias_record(bias)))) == bias
    assert find_bias(record.replace("+", " + ")) == bias


def test_several_may_be_given_in_a_list():
    assert find_bias(["spring", Weight()]) == find_bias("spring+weight")
    assert ConeModel(bias=("spring", "weight"), weight=0.3).system == ConeModel(bias="spring+weight").system


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("spring+spring", "bias = spring+spring: must be at least two different ones; name each once"),
        ("spring+wieght", "'wieght' is not a bias; did you mean 'weight'?"),
        (["spring"], "bias = spring: must be at least two different ones; name each once"),
    ],
)
def test_what_cannot_go_together_is_refused(given, message):
    with pytest.raises(InputError) as error:
        ConeModel(bias=given)
    assert str(error.value) == message


# --- what they do to a disc -------------------------------------------------------------------------------------------


def without_film(bias, **parameters):
    return ConeModel(film=PowerFilm(), film_modulus=0.0, bias=bias, **parameters)


def test_a_weight_lowers_a_sprung_disc_by_m_g_over_k():
    """Exactly without a film, and to the third order with one that has no stiffness where it is flat."""
    model = without_film("spring+weight", spring_stiffness=1.7, rest_height=0.4, weight=0.3)
    assert rest_displacement(model) == pytest.approx(0.4 - 0.3 / 1.7, rel=1e-14)
    film = ConeModel(bias="spring+weight", spring_stiffness=1.5, weight=1e-3)
    assert rest_displacement(film) == pytest.approx(-1e-3 / 1.5, rel=1e-5)
    assert rest_displacement(film) != pytest.approx(-1e-3 / 1.5, rel=1e-9)


def test_a_buckled_beam_alone_has_two_wells():
    model = without_film("beam", beam_stiffness=-0.8, beam_cubic=0.5, beam_height=0.3)
    (balance,) = balances_of(model)
    found = balance.equilibria(np.array([0.0]))[0]
    well = np.sqrt(0.8 / 0.5)
    np.testing.assert_allclose([e.displacement for e in found], [0.3 - well, 0.3, 0.3 + well], rtol=1e-13)
    np.testing.assert_allclose([e.slope for e in found], [1.6, -0.8, 1.6], rtol=1e-12)
    assert [e.stable for e in found] == [True, False, True]
    assert rest_displacement(model) == pytest.approx(0.3 + well, rel=1e-13)


@pytest.mark.parametrize("name", ["beam", "beam+weight+force"])
def test_the_energy_balance_closes(name):
    result = simulate(ConeModel(bias=name, voltage=0.8, prestretch=1.2, **CASES[name]), (0.5, 0.2), periods=3.0)
    assert abs(result["energy_residual"]).max() < 1e-13
    n = CASES[name]
    x = result["displacement"].values
    np.testing.assert_allclose(result["spring_energy"], find_bias(name).energy(x, n), rtol=1e-13, atol=1e-15)


def test_several_biases_are_as_slow_as_the_slowest():
    class Slow(Weight):
        name = "slow"

        def time_constant(self, n):
            return 7.0

    both = Together((Slow(), ConstantForce()))
    assert float(both.time_constant({})) == 7.0


def test_a_bias_whose_slope_is_not_that_of_its_force_is_refused():
    class Leaning(CubicBias):
        def force(self, x, y, n, xp=np):
            return n["bias_stiffness"] * x, 2.0 * n["bias_stiffness"]

    with pytest.raises(InputError, match=r"Leaning.force, its slope at a displacement: it is 2.4 at -1.5, and m"):
        ConeModel(bias=Together((LinearSpring(), Leaning())))


@pytest.mark.parametrize("turned", [False, True])
def test_biases_together_keep_their_states_apart(turned):
    """Forces add up, and the states of each change as they do alone, whichever comes first; in statics none has any."""
    parts = (Lagging(), TurningBias())
    own = ([0.7], [0.2, -0.3])
    alone = [{**part.complete({}), "bias_stiffness": 1.2} for part in parts]
    order = (1, 0) if turned else (0, 1)
    both = Together(tuple(parts[k] for k in order))
    n = {**alone[0], **alone[1]}
    y = [value for k in order for value in own[k]]
    assert [state.name for state in both.states] == [state.name for k in order for state in parts[k].states]
    rates = [rate for k in order for rate in parts[k].rates(0.4, 0.9, own[k], n)]
    assert both.rates(0.4, 0.9, y, n) == rates
    for states, each in ((y, own), ([], ([], []))):
        pulls = [part.force(0.4, one, n) for part, one in zip(parts, each, strict=True)]
        np.testing.assert_allclose(both.force(0.4, states, n), np.sum(pulls, axis=0), rtol=1e-14)


def test_the_stiffness_of_several_is_the_sum_of_theirs():
    both = Together((BIASES["spring"], BIASES["beam"]))
    n = both.numbers(both.complete({"spring_stiffness": 0.7, "beam_stiffness": 0.4, "beam_cubic": 1.5}))
    alone = [float(part.stiffness_scale(n)) for part in both.parts]
    assert min(alone) > 0.1
    assert float(both.stiffness_scale(n)) == pytest.approx(sum(alone), rel=1e-12)


class Lagged(Bias):
    """Springs of ``stiffness``, each to a state that follows the disc at the rate ``speed`` times their distance."""

    def __init__(self, stiffness, speed, count):
        self.stiffness, self.speed = stiffness, speed
        self.name = f"lagged at {speed:g}"
        self.states = tuple(State(f"lag_{speed:g}_{k}", "lag", "length") for k in range(count))

    name, parameters = "lagged", {}

    def force(self, x, y, n, xp=np):
        own = y or [0.0] * len(self.states)
        return sum(self.stiffness * (x - lag) for lag in own), self.stiffness * len(own) + 0.0 * x

    def rates(self, x, velocity, y, n, xp=np):
        return [self.speed * (x - lag) for lag in y]


def test_three_biases_take_one_another_s_states_in_turn():
    parts = Lagged(1.0, 0.1, 2), Lagged(2.0, 0.2, 1), LinearSpring(), Lagged(3.0, 0.3, 2)
    both, n = Together(parts), {"spring_stiffness": 0.7, "rest_height": 0.4}
    y = [0.1, 0.2, 0.3, 0.4, 0.5]
    force = (0.9 + 0.8) + 2.0 * 0.7 + 3.0 * (0.6 + 0.5) + 0.7 * 0.6
    assert both.force(1.0, y, n)[0] == pytest.approx(force)
    assert both.rates(1.0, 0.0, y, n) == pytest.approx([0.09, 0.08, 0.14, 0.18, 0.15])


class Following(Lagging):
    """The mass point begins half as high as the disc."""

    def starts(self, x, n):
        return [0.5 * x]


def test_several_biases_begin_each_where_it_would_alone():
    both = Together((TurningBias(), Following()))
    assert both.starts(0.8, {}) == [0.0, 0.0, 0.4]


def test_several_are_free_where_the_first_is_unless_it_is_stable_there():
    """From there as far as the other's pull shifts it: -(w)/k1."""
    both = Together((CubicBias(), Weight()))
    n = {"bias_stiffness": 2.0, "bias_cubic": 0.3, "weight": 0.1}
    assert both.free_height(n) == pytest.approx(-0.05, rel=1e-14)
    for stiffness in (-2.0, 0.0):
        assert both.free_height(n | {"bias_stiffness": stiffness}) == 0.0
    assert bool(Together((CubicBias(), BuckledBeam())).odd(n | {"beam_height": 0.0}))
    assert not Together((CubicBias(), BuckledBeam())).odd(n | {"beam_height": 0.2})
