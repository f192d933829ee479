"""Static balance of one actuator: the cone's closed forms, wells of a cubic bias by hand, and each kind of pull-in."""

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from gelcone.errors import InputError
from gelcone.physics import statics
from gelcone.physics.balance import (
    SEARCH_RANGE,
    PullIn,
    _film_lost,
    rest_of,
)
from gelcone.physics.bias import Bias
from gelcone.physics.film.film import Film
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import balances_of, every_balance, rest_displacement, rest_displacements
from gelcone.quantity import Quantity
from tests.toys import CubicBias, PowerFilm

X = np.array([-1.3, -0.4, 0.2, 0.9, 1.6])


@dataclass(frozen=True)
class Quintic(Bias):
    """F = k1 x + k3 x^3 - k5 x^5."""

    name = "quintic"
    parameters = {name: Quantity(name, name, 1.0) for name in ("k1", "k3", "k5")}

    def force(self, x, y, n, xp=np):
        s = x * x
        return x * (n["k1"] + s * (n["k3"] - s * n["k5"])), n["k1"] + s * (3.0 * n["k3"] - 5.0 * s * n["k5"])


class Wavy(Bias):
    """F = x (s - 0.5 + 0.6 sin 4 s) with s = x^2: stretches that are stable follow each other as the voltage rises."""

    name = "wavy"

    def force(self, x, y, n, xp=np):
        s = x * x
        sine, cosine = xp.sin(4.0 * s), xp.cos(4.0 * s)
        return x * (s - 0.5 + 0.6 * sine), s - 0.5 + 0.6 * sine + 2.0 * s * (1.0 + 2.4 * cosine)


class NoStateAbove(PowerFilm):
    """A power film that pulls in at V = 2, at every displacement."""

    def highest_squared(self, x, n):
        return np.full(np.shape(x), 2.0)[()]


def one(model):
    (balance,) = balances_of(model)
    return balance


def displacements(balance, squared):
    return [e.displacement for e in balance.equilibria(np.array([squared]))[0]]


# --- the closed forms of the cone with a spring -----------------------------------------------------------------------


@pytest.mark.parametrize("rest_height", [0.0, 0.3])
@pytest.mark.parametrize(
    "law", [{"stretch_limit": 9.0}, {"law": "neo-hookean"}, {"law": "yeoh", "yeoh_c2": 0.1, "yeoh_c3": 0.01}]
)
def test_force_slope_voltage_and_turning_of_the_cone(rest_height, law):
    """F = x (kappa + h - V) - kappa x0, w = kappa (1 - x0/x) + h, x F' - F = 2 x^3 dh/dq + kappa x0."""
    kappa = 1.3
    model = ConeModel(spring_stiffness=kappa, rest_height=rest_height, hoop_prestretch=1.2, **law)
    balance, n = one(model), model.own_numbers
    h, h_slope = model.law.film_stiffness(1.0 + X**2, n["A"], n["B"], n["G"], n)
    push = kappa * rest_height
    for squared in (0.0, 0.8):
        np.testing.assert_allclose(balance.force(X, squared), X * (kappa + h - squared) - push, rtol=1e-12, atol=1e-14)
        slope = kappa + h - squared + 2.0 * X**2 * h_slope
        np.testing.assert_allclose(balance.slope(X, squared), slope, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(balance.voltage_force(X, squared), squared * X, rtol=1e-14)
    np.testing.assert_allclose(balance.squared(X), kappa * (1.0 - rest_height / X) + h, rtol=1e-12)
    np.testing.assert_allclose(balance.turning(X), 2.0 * X**3 * h_slope + push, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(balance.excess(X), -np.ones(5))
    assert balance.lifted == (rest_height > 0.0)
    assert balance.flat == (rest_height == 0.0)
    assert balance.free_height == rest_height
    at_flat = balance.squared(0.0)
    assert at_flat == (pytest.approx(model.stiffness(0.0)) if rest_height == 0.0 else -math.inf)


def test_the_turning_has_the_sign_of_the_slope_of_the_voltage():
    """x F' - F = x^2 dw/dx at the voltage of equilibrium."""
    balance = one(ConeModel(rest_height=0.3, law="yeoh", yeoh_c2=-0.05, prestretch=1.2))
    h = 1e-6
    slope = (balance.squared(X + h) - balance.squared(X - h)) / (2.0 * h)
    np.testing.assert_allclose(balance.turning(X), X**2 * slope, rtol=1e-7, atol=1e-8)


def test_the_wells_of_a_neo_hookean_cone_by_hand():
    """kappa + 1 - 1/q^2 = V: x = +-sqrt(1/sqrt(1 + kappa - V) - 1) for kappa < V < kappa + 1, and the flat film."""
    balance = one(ConeModel(law="neo-hookean", spring_stiffness=0.7))
    for squared in (0.0, 0.5, 0.7 * (1.0 - 1e-9)):
        (flat,) = balance.equilibria(np.array([squared]))[0]
        assert flat.displacement == 0.0
        assert flat.stable
        assert flat.slope == pytest.approx(0.7 - squared, abs=1e-15)
    for squared in (0.71, 1.2, 1.69):
        lower, flat, upper = balance.equilibria(np.array([squared]))[0]
        well = math.sqrt(1.0 / math.sqrt(1.7 - squared) - 1.0)
        assert (lower.displacement, upper.displacement) == pytest.approx((-well, well), rel=1e-12)
        assert (lower.stable, flat.stable, upper.stable) == (True, False, True)
        q = 1.0 + well**2
        assert upper.slope == pytest.approx(4.0 * well**2 / q**3, rel=1e-9)
    assert displacements(balance, 1.71) == [0.0]


def test_what_is_reached_ends_before_the_stretch_limit_or_with_the_search():
    gent = one(ConeModel(stretch_limit=4.0))
    assert gent.wall
    assert ConeModel().strain(gent.highest) == pytest.approx(4.0, rel=1e-10)
    assert ConeModel().strain(gent.highest) < 4.0
    free = one(ConeModel(law="neo-hookean"))
    assert (free.lowest, free.highest, free.wall) == (0.0, SEARCH_RANGE, False)
    np.testing.assert_array_equal(free.inside(np.array([-1001.0, -999.0, 0.0, 999.0])), [False, True, True, True])


def test_an_ensemble_has_a_balance_for_each_member_in_its_order():
    model = ConeModel(spring_stiffness=[[0.5], [2.0]], stretch_limit=[4.0, np.inf])
    found = balances_of(model)
    assert [b.n["spring_stiffness"] for b in found] == [0.5, 0.5, 2.0, 2.0]
    assert [b.wall for b in found] == [True, False, True, False]


def test_members_that_reach_nothing_are_refused_only_together():
    model = ConeModel(prestretch=[1.0, 2.0], stretch_limit=0.5)
    assert [b.reachable for b in balances_of(model)] == [True, False]
    assert balances_of(model)[1].equilibria(np.array([0.1]))[0] == []
    with pytest.raises(InputError, match="must exceed the smallest I1 - 3"):
        balances_of(model.take([1]))
    assert not every_balance(model.take([1]))[0].reachable


# --- a bias with two wells --------------------------------------------------------------------------------------------


def wells(k1=-0.8, k3=0.5):
    return ConeModel(film=PowerFilm(), film_modulus=0.0, bias=CubicBias(), bias_stiffness=k1, bias_cubic=k3)


@pytest.mark.parametrize("squared", [0.0, 0.3, 2.5])
def test_the_wells_of_a_cubic_bias_by_hand(squared):
    """x (k1 - V + k3 x^2) = 0, on a film that resists nothing: 0 and +-sqrt((V - k1)/k3)."""
    lower, flat, upper = one(wells()).equilibria(np.array([squared]))[0]
    well = math.sqrt((squared + 0.8) / 0.5)
    assert (lower.displacement, flat.displacement, upper.displacement) == pytest.approx((-well, 0.0, well), rel=1e-12)
    assert (lower.stable, flat.stable, upper.stable) == (True, False, True)
    assert flat.slope == pytest.approx(-0.8 - squared)
    assert upper.slope == pytest.approx(2.0 * (squared + 0.8), rel=1e-12)
    assert rest_displacement(wells()) == pytest.approx(math.sqrt(1.6), rel=1e-12)
    assert rest_of(one(wells()), -0.1) == pytest.approx(-math.sqrt(1.6), rel=1e-12)


def test_an_equilibrium_on_its_pitchfork_counts_once():
    balance = one(wells(k1=0.6))
    (flat,) = balance.equilibria(np.array([0.6]))[0]
    assert flat.displacement == 0.0
    assert flat.stable  # the cubic stiffness holds it
    assert displacements(balance, 0.6 + 1e-6) == pytest.approx([-math.sqrt(2e-6), 0.0, math.sqrt(2e-6)], rel=1e-6)


# --- how a slow ramp ends ---------------------------------------------------------------------------------------------


def quintic(k1=0.5, k3=1.0, k5=0.25):
    """w = k1 + k3 x^2 - k5 x^4: a pitchfork at V = k1, folds at x^2 = k3/(2 k5), V = k1 + k3^2/(4 k5)."""
    return ConeModel(film=PowerFilm(), film_modulus=0.0, bias=Quintic(), k1=k1, k3=k3, k5=k5)


def test_a_fold_by_hand():
    balance = one(quintic(k1=-0.5))
    rest = rest_of(balance, None)
    assert rest**2 == pytest.approx(2.0 - math.sqrt(2.0), rel=1e-12)  # -0.5 + s - s^2/4 = 0
    voltage, kind, before, beyond = balance.losses(rest)[0]
    assert kind == PullIn.FOLD
    assert voltage == pytest.approx(math.sqrt(0.5), rel=1e-12)
    assert before == pytest.approx(math.sqrt(2.0), rel=1e-7)
    assert beyond == math.inf
    inner = [e for e in balance.equilibria(np.array([0.25]))[0] if e.displacement > 0.0]
    assert [e.displacement**2 for e in inner] == pytest.approx([1.0, 3.0], rel=1e-12)  # -0.5 + s - s^2/4 = 0.25
    assert [e.stable for e in inner] == [True, False]
    (left,) = {abs(x) for x in displacements(balance, 0.5) if x != 0.0}
    assert left == pytest.approx(math.sqrt(2.0), rel=1e-7)
    assert displacements(balance, 0.51) == [0.0]


def test_a_ramp_jumps_to_the_nearest_stable_stretch_beyond():
    """Of three stable stretches the first loses its stability; there are equilibria on both of the others."""
    balance = replace(one(ConeModel(film=PowerFilm(), film_modulus=0.0, bias=Wavy())), highest=3.0)
    rest = rest_of(balance, None)
    voltage, kind, before, beyond = balance.losses(rest)[0]

    def squared(s):
        return s - 0.5 + 0.6 * math.sin(4.0 * s)

    lost = (math.pi - math.acos(1.0 / 2.4)) / 4.0  # where 1 + 2.4 cos 4 s = 0
    assert (kind, voltage) == (PullIn.FOLD, pytest.approx(math.sqrt(squared(lost)), rel=1e-9))
    assert before == pytest.approx(math.sqrt(lost), rel=1e-7)
    bottom, top = math.pi / 2.0 - lost, lost + math.pi / 2.0  # the next minimum and maximum of that
    assert beyond**2 == pytest.approx(brentq(lambda s: squared(s) - squared(lost), bottom, top), rel=1e-9)
    place, losses = balance.along_ramp(rest, np.array([0.9, 1.1]) * squared(lost))
    np.testing.assert_array_equal(losses, [0, 1])
    assert beyond < place[1] < math.sqrt(top)


def test_a_pitchfork_by_hand_and_the_fold_behind_it():
    balance = one(quintic())
    voltage, kind, before, beyond = balance.losses(0.0)[0]
    assert kind == PullIn.PITCHFORK
    assert voltage == pytest.approx(math.sqrt(0.5), rel=1e-12)
    assert (before, beyond) == (0.0, 0.0)
    jump = balance.jump(0.0)
    assert (jump.voltage, jump.kind) == (pytest.approx(math.sqrt(1.5), rel=1e-12), PullIn.FOLD)
    squared = np.array([0.2, 0.4999, 0.75, 1.25, 1.4999, 1.51])
    place, losses = balance.along_ramp(0.0, squared)
    np.testing.assert_array_equal(losses, [0, 0, 1, 1, 1, 2])
    expected = [0.0, 0.0, *np.sqrt(2.0 - np.sqrt(4.0 - 4.0 * (squared[2:5] - 0.5)))]
    np.testing.assert_allclose(place[:5], expected, rtol=1e-9)
    assert np.isnan(place[5])


def test_a_bias_that_stiffens_holds_the_disc_up_to_the_end_of_the_search():
    balance = one(wells())
    voltage, kind, before, beyond = balance.losses(rest_of(balance, None))[0]
    assert kind == PullIn.SEARCH_RANGE
    assert voltage == math.inf
    assert np.isnan([before, beyond]).all()


def test_a_lifted_film_with_a_limit_is_never_lost():
    balance = one(ConeModel(rest_height=0.3, stretch_limit=9.0))
    rest = rest_of(balance, None)
    assert 0.0 < rest < 0.3
    voltage, kind, before, beyond = balance.losses(rest)[0]
    assert (voltage, kind) == (math.inf, PullIn.NEVER)
    assert math.isnan(before)
    assert math.isnan(beyond)
    place, losses = balance.along_ramp(rest, np.array([0.0, 1.0, 25.0, 900.0]))
    assert place[0] == pytest.approx(rest, rel=1e-12)
    assert (np.diff(place) > 0.0).all()
    assert (losses == 0).all()
    np.testing.assert_allclose(balance.force(place, 0.0) - np.array([0.0, 1.0, 25.0, 900.0]) * place, 0.0, atol=1e-8)


@pytest.mark.parametrize(("highest", "fails"), [(2.0, True), (np.nan, True), (np.inf, False)])
def test_only_an_infinite_voltage_says_that_a_film_cannot_pull_in(highest, fails, monkeypatch):
    balance = one(ConeModel(film=NoStateAbove(), bias=CubicBias()))
    monkeypatch.setattr(NoStateAbove, "highest_squared", lambda self, x, n: np.full(np.shape(x), highest)[()])
    assert balance.film_fails is fails


@pytest.mark.parametrize(("k1", "kind", "squared"), [(3.0, PullIn.FILM, 2.0), (1.2, PullIn.PITCHFORK, 1.2)])
def test_a_film_that_has_no_state_above_a_voltage_pulls_in_there(k1, kind, squared):
    model = ConeModel(film=NoStateAbove(), bias=CubicBias(), bias_stiffness=k1)
    balance = one(model)
    assert balance.film_fails
    assert balance.highest_squared == 2.0
    voltage, found, before, _ = balance.losses(0.0)[0]
    assert found == kind
    assert voltage == pytest.approx(math.sqrt(squared), rel=1e-12)
    assert before == 0.0
    assert displacements(balance, 2.1) == []
    _, losses = balance.along_ramp(0.0, np.array([1.0, 1.9, 2.1]))
    np.testing.assert_array_equal(losses, [0, 0, 1] if kind == PullIn.FILM else [0, 1, 2])


class Pushed(Film):
    """F = 0.5 x - 0.1 - V x: a film that is not flat where nothing pulls."""

    name = "pushed"

    def odd(self, n):
        return False

    def force(self, x, squared, y, n, xp=np):
        return 0.5 * x - 0.1 - squared * x, 0.5 - squared + 0.0 * x


def test_a_film_that_pushes_the_disc_by_itself_is_not_flat_at_any_voltage():
    """x = 0.1/(0.5 - V): above the flat film and stable below V = 0.5, below it and unstable beyond."""
    balance = one(ConeModel(film=Pushed(), spring_stiffness=0.0))
    assert not balance.flat
    assert balance.lifted
    for squared, x, stable in ((0.0, 0.2, True), (0.1, 0.25, True), (0.7, -0.5, False)):
        (found,) = balance.equilibria(np.array([squared]))[0]
        assert found.displacement == pytest.approx(x, rel=1e-12)
        assert found.stable == stable
    assert rest_of(balance, None) == pytest.approx(0.2, rel=1e-12)


def test_every_kind_has_a_meaning_of_one_line():
    for kind in PullIn:
        assert kind.meaning
        assert "\n" not in kind.meaning


def test_a_rest_is_searched_once_for_each_film_and_bias(monkeypatch):
    searched = []
    monkeypatch.setattr(statics, "_rests", {})
    monkeypatch.setattr(
        statics, "single_rests", lambda _, chosen: [searched.append(k) or float(len(searched)) for k in chosen]
    )
    model = ConeModel(spring_stiffness=1.5, rest_height=0.1)
    found = [rest_displacements(model.replace(**change)) for change in ({}, {"voltage": 2.0}, {"rest_height": 0.2})]
    assert found == [1.0, 1.0, 2.0]
    assert rest_displacements(model.replace(rest_height=[0.2, 0.3, 0.1])).tolist() == [2.0, 3.0, 1.0]
    monkeypatch.setattr(statics, "MOST_RESTS", 3)
    assert rest_displacements(model.replace(rest_height=[0.4, 0.1])).tolist() == [4.0, 1.0]
    assert len(statics._rests) == 4
    rest_displacements(model)
    assert len(statics._rests) == 1


def test_without_a_spring_a_film_that_loses_its_tension_behind_the_valley_is_stable():
    """There w rises with |x|; just where it balances the film neither pulls nor has a slope."""
    balance = one(ConeModel(film="wrinkling", stretch_limit=8.0, spring_stiffness=0.0, rest_height=0.0))
    levels = np.linspace(0.75, 1.5, 16) ** 2
    for level, found in zip(levels, balance.equilibria(levels), strict=True):
        outer = found[-1]
        assert outer.displacement > 1.5
        assert balance.squared(outer.displacement + 1e-4) > level > balance.squared(outer.displacement - 1e-4)
        assert outer.stable


def test_a_pitchfork_from_which_the_disc_jumps_is_a_jump_of_single_and_double_cones():
    """w = 0.5 - s + s^2 falls from the pitchfork at V = 0.5: the disc jumps to s = 1; two films halve that V."""
    numbers = {"film_modulus": 0.0, "bias": Quintic(), "k1": 0.5, "k3": -1.0, "k5": -1.0}
    single = one(ConeModel(film=PowerFilm(), **numbers)).jump(0.0)
    second = {"second_film": PowerFilm(), "second_film_modulus": 0.0}
    (pair,) = every_balance(ConeModel(film=PowerFilm(), **numbers, **second))
    double = pair.jump(0.0)
    for jump, squared in ((single, 0.5), (double, 0.25)):
        assert (jump.kind, jump.before) == (PullIn.PITCHFORK, pytest.approx(0.0, abs=1e-9))
        assert jump.voltage == pytest.approx(math.sqrt(squared), rel=1e-6)
        assert abs(jump.after) == pytest.approx(1.0, abs=1e-4)


def test_a_film_is_lost_where_the_voltage_turns_steep() -> None:
    """Beyond pull-in v^2 rises 1e16 times as fast as before it: no pole."""
    lost = 2.2787552613198194

    def excess(x: np.ndarray) -> np.ndarray:
        return np.where(x < lost, x - lost, 1e16 * (x - lost))

    balance = SimpleNamespace(film_fails=True, excess=excess, segments={1: [(1.3, 3.0)]})
    assert _film_lost(balance, balance.segments[1][0], balance.segments[1][0][0]) == pytest.approx(lost, rel=4e-16)


def test_pull_in_where_the_voltage_turns_steep_is_that_of_the_film() -> None:
    """A displacement by one part in 1e16 changes the balancing voltage by a millionth there."""
    parts = {"film": "wrinkling", "radius_ratio": 0.34253421415350344, "hoop_prestretch": 1.4762083882902615}
    loads = {"bias": "spring+weight+force", "weight": 0.14244054224312025, "push": -0.11365382273162336}
    balance = one(ConeModel(**parts, **loads, spring_stiffness=1.371309248940185, rest_height=0.7210984336375977))
    (loss,) = balance.losses(0.3623747830)
    assert loss.kind == PullIn.FILM
    assert loss.voltage**2 == pytest.approx(float(balance.highest_at(loss.before)), rel=1e-12)
    here, ahead = (float(balance.squared(loss.before * (1.0 + change))) for change in (0.0, 1e-12))
    assert ahead > 1.01 * here


@pytest.mark.parametrize("side", [-1, 1])
def test_a_film_that_fails_ends_with_the_outermost_stretch_of_its_side_and_no_other(side: int) -> None:
    """Where it has a state all along: to the left the stretches may be fewer than to the right."""
    right, left = [(0.1, 0.5), (0.7, 1.0), (1.2, 1.6)], [(-0.2, -0.6), (-0.9, -1.3)]
    balance = SimpleNamespace(
        film_fails=True, excess=lambda x: np.full(np.shape(x), -0.1), segments={1: right, -1: left}
    )
    ends = [_film_lost(balance, segment, segment[0]) for segment in balance.segments[side]]
    assert ends == [None] * (len(ends) - 1) + [side * (1.6 if side > 0 else 1.3)]
    balance.excess = lambda x: np.abs(x) - 0.4
    assert _film_lost(balance, balance.segments[side][0], balance.segments[side][0][0]) == pytest.approx(0.4 * side)
    assert _film_lost(balance, balance.segments[side][0], 0.45 * side) == 0.45 * side
    balance.film_fails = False
    assert _film_lost(balance, balance.segments[side][-1], balance.segments[side][-1][0]) is None


def test_a_flat_film_that_pulls_in_before_its_pitchfork_ends_there():
    """The pitchfork is at V = k1, the film has no state from V = 2 on."""
    balance = one(ConeModel(film=NoStateAbove(), bias=CubicBias(), bias_stiffness=3.0))
    assert balance.pitchfork() == pytest.approx(3.0, rel=1e-9)
    x, voltage, slope = balance.curves(5.0)[-1]
    assert not x.any()
    np.testing.assert_allclose(voltage, np.linspace(0.0, math.sqrt(2.0), voltage.size), rtol=1e-14)
    assert slope[0] == pytest.approx(3.0, rel=1e-9)
    x, voltage, slope = one(ConeModel(film=NoStateAbove(), bias=CubicBias(), bias_stiffness=1.5)).curves(5.0)[-1]
    assert (voltage[0], voltage[-1]) == (0.0, pytest.approx(math.sqrt(2.0), rel=1e-14))
    assert np.abs(voltage - math.sqrt(1.5)).min() < 1e-9
    np.testing.assert_allclose(slope, 1.5 - voltage**2, atol=1e-9)


@pytest.mark.parametrize("off", [0.0, -5e-15, 5e-15])
def test_at_a_fold_up_to_rounding_both_equilibria_are_one_that_is_not_stable_and_a_ramp_is_there(off):
    balance = one(quintic())
    rest = 0.0
    fold = balance.segments[1][0][1]
    level = float(balance.squared(fold)) * (1.0 + off)
    at = [e for e in balance.equilibria(np.array([level]))[0] if e.displacement > 0.5]
    assert [(e.displacement, e.stable) for e in at] == [(fold, False)]
    place, losses = balance.along_ramp(rest, np.array([level]))
    assert losses[0] == 1  # the pitchfork
    assert abs(place[0]) == pytest.approx(fold, rel=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_disc_that_leaves_all_displacements_does_so_on_its_own_side(side):
    balance = one(ConeModel(law="neo-hookean", film="taut", rest_height=side * 0.5))
    last = balance.losses(rest_of(balance, None))[-1]
    assert (last.kind, last.after) == (PullIn.RUNAWAY, side * math.inf)


@pytest.mark.parametrize(("stiffening", "kind"), [(0.0, PullIn.RUNAWAY), (1e-3, PullIn.SEARCH_RANGE)])
def test_a_ramp_runs_away_only_where_the_film_pulls_no_more_the_farther_the_disc_is(stiffening, kind):
    """Far away w is k + 1 + 4 c x^2 of the law with c times (I1 - 3)^2."""
    balance = one(
        ConeModel(law="yeoh", yeoh_c2=stiffening, yeoh_c3=0.0, spring_stiffness=0.7, film="taut", rest_height=0.5)
    )
    loss = balance.losses(rest_of(balance, None))[-1]
    assert loss.kind == kind
    assert loss.voltage == (pytest.approx(math.sqrt(1.7), rel=1e-3) if kind == PullIn.RUNAWAY else math.inf)


def test_a_film_that_only_stiffens_loses_nothing_however_high_the_voltage():
    balance = one(ConeModel(film="taut", rest_height=0.5))
    _, losses = balance.along_ramp(rest_of(balance, None), np.array([1.0, 1e15, 1e40]))
    np.testing.assert_array_equal(losses, 0)


class Unyielding(NoStateAbove):
    """F = (1 - V) x^3, held by the film at any voltage."""

    name = "unyielding"

    def force(self, x, squared, y, n, xp=np):
        return (1.0 - squared) * x * x * x, 3.0 * (1.0 - squared) * x * x

    def balancing(self, x, pull, n):
        return np.full(np.shape(x), np.inf)


def test_where_no_voltage_balances_a_film_its_turning_is_that_without_voltage():
    """x dF/dx - F of x^3 + k3 x^3."""
    balance = one(ConeModel(film=Unyielding(), bias=CubicBias(), bias_cubic=0.25))
    np.testing.assert_allclose(balance.turning(X), 2.0 * X**3 + 2.0 * 0.25 * X**3, rtol=1e-12)


def test_the_turning_next_to_pull_in_is_that_of_the_voltage_of_equilibrium():
    """x F' = -x dF/dV dw/dx also where w is most of what the wrinkled film withstands."""
    balance = one(ConeModel(film="wrinkling", prestretch=1.1, spring_stiffness=1.0, rest_height=1.0))
    x, h = np.linspace(0.7, 0.9, 80), 1e-5
    share = 1.0 + balance.excess(x)
    x = x[(share > 0.6) & (share < 0.99)]
    assert x.size > 5
    slope = (balance.squared(x + h) - balance.squared(x - h)) / (2.0 * h)
    gain = balance.system.film.voltage_gain(x, balance.squared(x), balance.n)
    assert (np.abs(gain / x - 1.0) > 0.1).sum() > 5
    np.testing.assert_allclose(balance.turning(x), x * gain * slope, rtol=1e-5, atol=1e-7)


def test_a_flat_film_at_a_pitchfork_from_which_it_jumps_is_not_stable():
    """w = 0.5 - s + s^2 falls from the pitchfork; w = 0.5 + s - s^2/4 rises from it."""
    for k3, k5, stable in ((-1.0, -1.0, False), (1.0, 0.25, True)):
        found = one(quintic(k3=k3, k5=k5)).equilibria(np.array([0.5]))[0]
        (flat,) = [e for e in found if e.displacement == 0.0]
        assert flat.stable == stable


def test_a_fold_at_a_voltage_that_the_film_does_not_withstand_is_none():
    """w = k1 + s - s^2/4 has its fold at V = k1 + 1, of a film that pulls in at 2."""
    numbers = {"film": NoStateAbove(), "film_modulus": 0.0, "bias": Quintic(), "k3": 1.0, "k5": 0.25}
    folds = one(ConeModel(**numbers, k1=0.9)).folds()
    assert [round(x, 6) for _, x in folds] == [round(-math.sqrt(2.0), 6), round(math.sqrt(2.0), 6)]
    assert one(ConeModel(**numbers, k1=1.1)).folds() == []


def test_what_is_reached_begins_inside_the_stretch_limit_and_a_wall_counts_as_far_as_the_search():
    wide = ConeModel(prestretch=0.5, prestretch_mode="equibiaxial", stretch_limit=8.0)
    balance = one(wide)
    assert balance.lowest > 0.5
    assert wide.strain(balance.lowest) < 8.0
    assert np.isfinite(balance.force(balance.lowest, 0.0))
    far = one(ConeModel(stretch_limit=5e5))  # x = 707
    assert (far.wall, far.highest) == (True, pytest.approx(math.sqrt(5e5), rel=1e-4))


class Waning(Bias):
    """w = 0.3 - 0.2 s + 0.6 sin 4 s, s = x^2: stretches rise again behind the first, each less high."""

    name = "waning"

    def force(self, x, y, n, xp=np):
        s = x * x
        w, slope = 0.3 - 0.2 * s + 0.6 * xp.sin(4.0 * s), -0.2 + 2.4 * xp.cos(4.0 * s)
        return x * w, w + 2.0 * s * slope


def test_a_ramp_does_not_fall_back_to_a_stretch_that_its_voltage_has_left_behind():
    balance = replace(one(ConeModel(film=PowerFilm(), film_modulus=0.0, bias=Waning())), highest=2.5)
    pitchfork, fold = balance.losses(0.0)
    top = math.acos(0.2 / 2.4) / 4.0
    assert (pitchfork.kind, pitchfork.voltage) == (PullIn.PITCHFORK, pytest.approx(math.sqrt(0.3)))
    squared = 0.3 - 0.2 * top + 0.6 * math.sin(4.0 * top)
    assert (fold.kind, fold.voltage, fold.after) == (PullIn.FOLD, pytest.approx(math.sqrt(squared)), math.inf)


def test_curves_of_equilibria_have_the_slope_of_the_force_along_them_to_the_end_of_the_search():
    balance = one(ConeModel(law="neo-hookean", spring_stiffness=0.7, rest_height=0.2))
    for x, voltage, slope in balance.curves(2.0):
        np.testing.assert_allclose(balance.force(x, voltage**2), 0.0, atol=1e-9)
        inner = slope != 0.0
        assert inner.sum() >= x.size - 2  # in folds it is 0
        near = np.abs(x) < 50.0
        np.testing.assert_allclose(slope[inner & near], balance.slope(x, voltage**2)[inner & near], rtol=1e-6)
    x, _, slope = one(ConeModel(law="neo-hookean", spring_stiffness=0.7)).curves(2.0)[1]
    assert x[-1] == SEARCH_RANGE
    assert slope[-1] == pytest.approx(4.0 * x[-1] ** 2 / (1.0 + x[-1] ** 2) ** 3, rel=1e-6)


def test_of_two_rests_the_one_near_where_the_bias_is_free_is_taken():
    """A weak spring that is free at 0.3 moves both wells up: the lower one is nearer to the flat film."""
    model = ConeModel(meridional_prestretch=0.7, hoop_prestretch=1.0, spring_stiffness=0.05, rest_height=0.3)
    balance = one(model)
    lower, upper = (e.displacement for e in balance.equilibria(np.zeros(1))[0] if e.stable)
    assert -lower < upper
    assert upper - 0.3 < 0.3 - lower
    assert rest_of(balance, None) == upper == pytest.approx(rest_displacement(model))
    assert rest_of(balance, 0.0) == lower


def test_a_film_that_has_pulled_in_or_is_beyond_its_limit_is_not_whole():
    balance = one(ConeModel(film=NoStateAbove(), bias=CubicBias()))
    assert balance.whole(np.array([0.1, 0.1, 1001.0]), np.array([1.9, 2.1, 1.0])).tolist() == [True, False, False]
    wide = one(ConeModel(prestretch=0.5, prestretch_mode="equibiaxial", stretch_limit=8.0))
    x = np.array([-1.0, -1.0 - 1e-6, 0.0, 1.0 - 1e-6, 1.0 + 1e-6]) * wide.lowest
    assert wide.inside(x).tolist() == [True, True, False, False, True]


@pytest.mark.parametrize("film", ["wrinkling", "taut"])
def test_a_disc_that_hangs_below_has_the_mirror_image_of_the_equilibria_of_one_above(film):
    """Also where the film has pulled in between two of them, and where a ramp ends."""
    up, down = (one(ConeModel(film=film, prestretch=1.1, spring_stiffness=0.5, rest_height=x)) for x in (0.9, -0.9))
    levels = np.linspace(0.0, 1.2, 25)
    for above, below in zip(up.equilibria(levels), down.equilibria(levels), strict=True):
        assert [(e.displacement, e.stable) for e in above] == [
            (pytest.approx(-e.displacement, rel=1e-12), e.stable) for e in below[::-1]
        ]
    for lost, same in zip(up.losses(rest_of(up, None)), down.losses(rest_of(down, None)), strict=True):
        assert (lost.kind, same.voltage) == (same.kind, pytest.approx(lost.voltage, rel=1e-12))
        assert same.before == pytest.approx(-lost.before, nan_ok=True)


def test_a_ramp_begins_where_the_disc_rests_also_beyond_other_stretches():
    balance = replace(one(ConeModel(film=PowerFilm(), film_modulus=0.0, bias=Falling())), highest=1.6)
    rests = [e.displacement for e in balance.equilibria(np.zeros(1))[0] if e.stable and e.displacement > 0.0]
    assert len(rests) == 2
    for rest in rests:
        place, losses = balance.along_ramp(rest, np.array([0.0, 1e-4]))
        assert losses.tolist() == [0, 0]
        assert place[0] == pytest.approx(rest, rel=1e-9)
        assert rest < place[1] < rest + 0.01


class Falling(Bias):
    """w = 0.2 sin 4 s - 0.05, s = x^2: it rises through 0 where the sine does."""

    name = "falling"

    def force(self, x, y, n, xp=np):
        s = x * x
        w = 0.2 * xp.sin(4.0 * s) - 0.05
        return x * w, w + 1.6 * s * xp.cos(4.0 * s)


def test_curves_reach_the_highest_voltage_that_is_asked_for():
    for highest in (0.4, 1.7):
        curves = one(ConeModel(rest_height=0.4)).curves(highest)
        assert max(voltage.max() for _, voltage, _ in curves) == pytest.approx(highest, rel=1e-9)


def test_a_curve_has_no_points_where_the_film_would_have_pulled_in():
    """w = k1 + k3 x^2 of a film that withstands V = 2."""
    balance = one(
        ConeModel(film=NoStateAbove(), film_modulus=0.0, bias=CubicBias(), bias_stiffness=0.5, bias_cubic=1.0)
    )
    for x, voltage, slope in balance.curves(3.0):
        known = np.isfinite(x)
        np.testing.assert_array_equal(np.isfinite([voltage, slope]), [known, known])
        assert np.nanmax(voltage) <= math.sqrt(2.0) * (1.0 + 1e-12)
        assert known.sum() > 2
    assert any(np.nanmax(np.abs(x)) > 1.2 for x, _, _ in balance.curves(3.0))


def test_a_film_that_is_pushed_while_flat_has_no_pitchfork():
    assert math.isnan(one(ConeModel(rest_height=0.3)).pitchfork())
    assert math.isnan(one(ConeModel(film=Pushed(), spring_stiffness=0.7)).pitchfork())
    assert one(ConeModel(spring_stiffness=0.7)).pitchfork() == pytest.approx(0.7)
