"""Equilibria of the film: Newton's method, steps along a load, the arc past folds."""

import itertools
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum import path
from gelcone.continuum.membrane import membrane
from gelcone.continuum.mesh import energy, forces, mesh_film, tangent
from gelcone.continuum.path import FREE, arc, cone, flat, newton, reach
from gelcone.physics.model import ConeModel
from tests.continuum.films import EQUIBIAXIAL, NEO_HOOKEAN, dense


def test_newton_converges_quadratically():
    film = mesh_film(ConeModel(), 0.2, 40)
    position, residuals = cone(film, 1.0), []
    for _ in range(6):
        now = forces(film, position, 0.1).internal
        residuals.append(np.abs(now[FREE]).max())
        position[FREE] -= np.linalg.solve(dense(tangent(film, position, 0.1))[FREE, FREE], now[FREE])
    late = [r for r in residuals if 1e-13 < r < 1e-2]
    assert residuals[-1] < 1e-13
    assert len(late) >= 2
    assert all(after < 100.0 * before**2 for before, after in itertools.pairwise(late))


@pytest.mark.parametrize("v", [0.0, 0.4, 0.6])
@pytest.mark.parametrize("prestretch", [{}, EQUIBIAXIAL])
def test_reaction_is_the_slope_of_the_energy_along_the_path(prestretch, v):
    film = mesh_film(ConeModel(**prestretch), 0.2, 20)
    start = reach(film, newton(film, cone(film, 0.8), 0.0), "squared", v * v)[0]
    step = 2e-3
    stored = {k: energy(film, reach(film, start, "height", 0.8 + k * step)[0].position, v * v) for k in (-2, -1, 1, 2)}
    slope = (8.0 * (stored[1] - stored[-1]) - (stored[2] - stored[-2])) / (12.0 * step)
    assert start.force == pytest.approx(slope, rel=1e-8)


def test_stretching_disc_and_rim_alike_is_equibiaxial():
    """Disc and rim drawn outwards by the same factor 1.3: every ring is, a state that is not the initial one."""
    film, stretch = mesh_film(NEO_HOOKEAN, 0.2, 30), 1.3
    position = np.zeros(film.size)
    position[[0, -2]] = (stretch - 1.0) * film.radius[[0, -1]]
    position[2:-2:2] = np.interp(film.place[1:-1], [0.0, 0.3, 1.0], [position[0], 0.2, position[-2]])
    point = newton(film, position, 0.09)
    np.testing.assert_allclose(point.position[0::2], (stretch - 1.0) * film.radius, rtol=1e-6)
    # nominal pull of the rim: l (1 - l^-6) - v^2 l^3 per unit of mounted length, 2 b/(b^2 - a^2) of it per mu Vol
    pull = (stretch - stretch**-5 - 0.09 * stretch**3) * 2.0 * film.radius[-1] / (2.0 * film.radius[0] + 1.0)
    assert point.forces.internal[-2] == pytest.approx(pull, rel=1e-6)


def test_the_arc_passes_both_folds_and_meets_the_film_that_pulled_in():
    """At x = 2 the film of Table 1 pulls in just below v = 0.49 and is stable again, thin and bulged, at lower v."""
    film = mesh_film(ConeModel(), 0.2, 60)
    start = newton(film, cone(film, 2.0), 0.0)
    assert reach(film, start, "squared", 0.25)[0] is None
    passed = list(arc(film, start))
    folds = [here.folds for here in passed]
    assert sorted(folds) == folds
    assert folds[-1] == 2
    assert all(here.point.stable == (here.folds != 1) for here in passed if here.squared**2 > 1e-4)
    first = max(here.point.squared for here in passed if here.folds < 2 and here.point.squared < 0.26)
    assert np.sqrt(first) == pytest.approx(0.490, abs=0.001)
    beyond = membrane(ConeModel(), 0.2, displacements=[1.9, 2.0], voltages=0.5, elements=60).squeeze()
    assert (beyond["folds"] == 2).all()
    assert beyond["overhangs"].all()
    assert beyond["stable"].all()


def test_a_flat_film_is_stable_as_long_as_its_tangent_is_positive():
    """Its voltage takes the tension of the pre-stretch: beyond, the flat film buckles."""
    film, stable = mesh_film(ConeModel(**EQUIBIAXIAL), 0.2, 12), []
    for squared in (0.0, 0.3, 1.0, 1.3):
        point = flat(film, squared)
        least = np.linalg.eigvalsh(dense(tangent(film, point.position, squared))[FREE, FREE]).min()
        assert point.stable == (least > 0.0)
        assert np.abs(point.position).max() < 1e-9
        stable.append(point.stable)
    assert stable[0]
    assert not stable[-1]


@pytest.mark.parametrize("load", ["height", "squared"])
def test_the_rate_along_a_load_is_that_of_neighbouring_equilibria(load):
    film = mesh_film(ConeModel(hoop_prestretch=1.2), 0.2, 8)
    here = reach(film, newton(film, cone(film, 0.8), 0.0), "squared", 0.1)[0]
    step = 1e-4
    value = here.height if load == "height" else here.squared
    ahead, behind = (reach(film, here, load, value + way * step)[0].position for way in (1.0, -1.0))
    np.testing.assert_allclose(path._rate(film, here, load), (ahead - behind) / (2.0 * step), rtol=1e-4, atol=1e-6)


def made(height=0.5, stable=True, least=0.1, squared=0.2):
    position = np.zeros(8)
    position[path.DISC_HEIGHT] = height
    return path.Point(position, squared, SimpleNamespace(least=least, internal=position), stable)


@pytest.mark.parametrize(
    ("start", "found", "taken"),
    [
        (made(), made(0.55), True),
        (made(), None, False),
        (made(), made(0.55, stable=False), False),
        (made(stable=False), made(0.55, stable=False), True),
        (made(0.0), made(0.0, stable=False), True),  # flat, symmetry carries it through
        (made(), made(0.55, least=-0.1), False),
        (made(least=-0.1), made(0.55, least=-0.1), True),
    ],
)
def test_a_step_leads_to_a_film_as_stable_and_as_tense_as_before_or_nowhere(monkeypatch, start, found, taken):
    asked = []
    monkeypatch.setattr(path, "_rate", lambda film, point, load: np.full(8, 0.4))
    monkeypatch.setattr(
        path, "newton", lambda film, guess, squared, within: asked.append((guess, squared, within)) or found
    )
    assert path.step(None, start, "squared", 0.3) is (found if taken else None)
    ((guess, squared, within),) = asked
    np.testing.assert_allclose(guess, start.position + 0.04)
    assert (squared, within) == (0.3, pytest.approx(0.3 * 0.04, rel=1e-6))
    assert path.step(None, start, "squared", 0.2 + 1.26) is None  # by more than half of b - a
    assert len(asked) == 1


@pytest.mark.parametrize(
    ("found", "given"),
    [
        ([made(squared=0.2), made(squared=0.1), made(squared=-0.1), made(squared=0.3)], [0.2, 0.1]),
        (
            [made(squared=0.2), None, made(squared=0.3), made(squared=0.4, least=-0.1), made(squared=0.5)],
            [0.2, 0.3, 0.4],
        ),
    ],
)
def test_an_arc_ends_where_the_voltage_is_back_at_0_and_with_the_first_point_without_tension(monkeypatch, found, given):
    """Where no point is found half of the step is tried, of the next twice that."""
    points, lengths = iter(found), []
    monkeypatch.setattr(path, "_arc", lambda film, point, before: path.Arc(point, point.position, 1.0, 0))
    monkeypatch.setattr(path, "_corrected", lambda film, here, length: lengths.append(length) or next(points))
    assert [here.point.squared for here in path.arc(None, made(squared=0.0))] == given
    assert lengths[:2] == pytest.approx([path.ARC_LENGTH, 2.0 * path.ARC_LENGTH])
    if None in found:
        assert lengths[2:] == pytest.approx([path.ARC_LENGTH, 2.0 * path.ARC_LENGTH])


@dataclass(frozen=True)
class Netted:
    """A film that may wrinkle, as far as `settled` sees it."""

    net: float = 0.0
    relaxed: bool = True


def test_a_slack_film_comes_to_rest_on_ever_weaker_nets_each_from_the_rest_on_the_last(monkeypatch):
    """First from a weak net on; where a rest is lost or unstable from the strongest on; None where neither leads on."""
    asked, lost = [], set()

    def newton(film, start, square, within):
        k = path.NETS.index(film.net)
        asked.append((k, float(start[0]), square, within))
        return None if (k, len(asked)) in lost else path.Point(start + 1.0, square, None, (k, "unstable") not in lost)

    monkeypatch.setattr(path, "newton", newton)
    guess = np.full(4, 5.0)
    point = path.settled(Netted(), guess, 0.3, 0.7)
    assert asked == [(4, 5.0, 0.3, 0.7), (5, 6.0, 0.3, 0.7)]
    assert point.position[0] == 7.0
    asked.clear()
    lost.add((5, 2))
    point = path.settled(Netted(), guess, 0.3)
    assert [k for k, *_ in asked] == [4, 5, 0, 1, 2, 3, 4, 5]
    assert [start for _, start, *_ in asked] == [5.0, 6.0, *np.arange(5.0, 11.0)]
    assert point.position[0] == 11.0
    asked.clear()
    lost.clear()
    lost.add((4, "unstable"))
    assert path.settled(Netted(), guess, 0.3) is None
    assert [k for k, *_ in asked] == [4, 0, 1, 2, 3, 4]
    assert path.settled(Netted(relaxed=False), guess, 0.3) is None
    assert list(path.NETS) == sorted(path.NETS, reverse=True)


@pytest.mark.parametrize(("begin", "target"), [(0.0, 1.0), (1.0, 0.0)])
def test_a_load_is_reached_in_steps_that_are_halved_where_one_fails_and_doubled_after_one_that_does_not(
    monkeypatch, begin, target
):
    """A made-up path, of which no step is longer than 0.3; and one that ends at 0.6 of the way."""
    way, end = np.sign(target - begin), [np.inf]

    def step(film, point, load, to):
        far = abs(to - point.squared) > 0.3 + 1e-12 or (to - begin) * way > end[0]
        return None if far else made(squared=to)

    monkeypatch.setattr(path, "step", step)
    found, last = path.reach(None, made(squared=begin), "squared", target)
    assert found is last
    assert found.squared == target
    end[0] = 0.6
    found, last = path.reach(None, made(squared=begin), "squared", target)
    assert found is None
    assert 0.6 - 2.0 * path.SMALLEST_STEP["squared"] < (last.squared - begin) * way <= 0.6
    assert path.reach(None, made(squared=begin), "squared", begin)[0].squared == begin


def test_a_guess_is_the_cone_with_the_radii_of_another_state():
    film = mesh_film(ConeModel(), 0.2, 4)
    plain = cone(film, 0.7)
    np.testing.assert_array_equal(plain[0::2], 0.0)
    np.testing.assert_allclose(plain[1::2], 0.7 * (1.0 - film.place))
    below = path.Point(np.arange(float(film.size)), 0.0, None, True)
    found = cone(film, 0.7, below)
    np.testing.assert_array_equal(found[0::2], below.position[0::2])
    np.testing.assert_array_equal(found[1::2], plain[1::2])
    assert below.position[1] == 1.0  # the state itself stays


@pytest.mark.parametrize("relaxed", [False, True])
def test_a_lower_energy_will_do_for_a_film_that_may_wrinkle_alone(monkeypatch, relaxed):
    """Of a world in which no step lessens the forces, and the energy is lower within a quarter of the step."""
    monkeypatch.setattr(path, "reachable", lambda film, position: bool(position[0] < 0.9))
    monkeypatch.setattr(path, "forces", lambda film, position, squared: ("forces", float(position[0])))
    monkeypatch.setattr(path, "_residual", lambda now: 3.0)
    monkeypatch.setattr(path, "energy", lambda film, position, squared: 0.0 if 0.0 < position[0] <= 0.25 else 1.0)
    film, step = SimpleNamespace(relaxed=relaxed), np.ones(4)
    found = path._damped(film, np.zeros(4), step, 0.1, 2.0, 6)
    if relaxed:
        np.testing.assert_array_equal(found[0], 0.25)
        assert found[1] == ("forces", 0.25)
    else:
        assert found is None
    assert path._damped(film, np.zeros(4), step, 0.1, 2.0, 2) is None
    np.testing.assert_array_equal(path._damped(film, np.zeros(4), step, 0.1, 3.1, 6)[0], 0.5)  # less than allowed
