"""The wrinkling membrane under voltage: forces of an own quadrature, where it falls slack and where it pulls in."""

import numpy as np
import pytest

pytest.importorskip("skfem")

from scipy.optimize import brentq

from gelcone.continuum import charged as charged_module
from gelcone.continuum import density
from gelcone.continuum.charged import charged, slack_limit, tangent_stiffness
from gelcone.continuum.membrane import membrane, raised_film
from gelcone.continuum.mesh import mesh_film
from gelcone.continuum.path import Ending, Point
from gelcone.physics.model import ConeModel
from tests.continuum.films import NEO_HOOKEAN

GENT = {"A": 1.0, "B": 1.0, "G": 1.0, "inverse_stretch_limit": 0.02}
TABLE = [
    # v, x, force, ending: `wrinkling.md`'s table for lp = 1, stretch limit 50, a/b = 0.2
    (0.0, 1.0, 0.6310, Ending.CONVERGED),
    (0.25, 0.25, 0.01219, Ending.CONVERGED),
    (0.4, 0.25, 0.0, Ending.SLACK),
    (0.5, 0.5, 0.0562, Ending.CONVERGED),
    (0.5, 0.75, 0.2132, Ending.CONVERGED),
    (0.6, 0.5, 0.0149, Ending.CONVERGED),
]


def column(x, model=None, elements=20):
    film = mesh_film(model or ConeModel(spring_stiffness=0.0), 0.2, elements, relaxed=True)
    return film, raised_film(film, [x])[x]


def straight_meridian(squared, x, ratio=0.2):
    """Force of a film that wrinkles along all of its meridian, which is then straight: the tension of each ring is
    C/R, from 2 sqrt(m) phi_m = C/R at the natural hoop, and the lengths add up to the slant."""
    law, disc = ConeModel().gel_law(), ratio / (1.0 - ratio)
    places, weights = np.polynomial.legendre.leggauss(24)
    radius, weights = disc + 0.5 * (places + 1.0), 0.5 * weights

    def tension(m):
        n = density._free(law, GENT, np.array([m]), squared, hoop=True)
        return 2.0 * np.sqrt(m) * float(density.derivatives(law, GENT, np.array([m]), n, squared).m[0])

    def length(constant):
        meridians = [brentq(lambda m, r=r: tension(m) - constant / r, 1.0, longest, xtol=1e-12) for r in radius]
        return float(weights @ np.sqrt(meridians))

    slant = np.hypot(1.0, x)
    tried = np.linspace(1.0, 3.0, 101)  # the tension rises up to where a ring pulls in
    strongest, longest = max((tension(m), m) for m in tried)
    constant = brentq(lambda c: length(c) - slant, 1e-6, 0.999 * radius[0] * strongest, xtol=1e-10)
    return 2.0 * constant * (x / slant) / (2.0 * disc + 1.0)


@pytest.mark.parametrize(("v", "x", "force", "ending"), TABLE)
def test_forces_of_the_wrinkling_membrane(v, x, force, ending):
    found = membrane(ConeModel(), 0.2, displacements=x, voltages=v, wrinkles="relax", elements=20).squeeze()
    assert found["force"].item() == pytest.approx(force, abs=5.1e-5 if force > 0.02 else 6e-6 if v < 0.6 else 5.1e-5)
    assert found["ending"].item() == ending


@pytest.mark.slow
@pytest.mark.parametrize(("v", "force"), [(0.5, 0.05622), (0.6, 0.01492)])
def test_forces_of_a_film_that_wrinkles_everywhere_are_those_of_its_quadrature(v, force):
    own = straight_meridian(v * v, 0.5)
    assert own == pytest.approx(force, abs=5e-6)
    found = membrane(ConeModel(), 0.2, displacements=0.5, voltages=v, wrinkles="relax", elements=40).squeeze()
    assert found["force"].item() == pytest.approx(own, abs=5e-6)


@pytest.mark.parametrize(("x", "v"), [(0.75, 0.5445), (1.0, 0.4377)])
def test_the_membrane_pulls_in_far_earlier_than_the_cone(x, v):
    """Voltages of 200 elements; the homogeneous cone's are 0.69 and 0.63."""
    film, start = column(x)
    found = charged(film, start, 0.5, 0.05)
    assert found.ending == Ending.PULLED_IN
    assert np.sqrt(found.end) == pytest.approx(v, rel=0.01)
    assert 0.0 < found.error < 1e-3 * found.end
    last = found.points[-1]
    assert last.squared == pytest.approx(found.end - found.error, rel=1e-12)  # the bracket begins there
    assert tangent_stiffness(film, last, last.squared) < 0.1 < tangent_stiffness(film, start, 0.0)


def test_pull_in_is_told_apart_from_slackness_and_from_what_was_not_found():
    voltages = [0.3, 0.65, 0.7]
    found = membrane(
        ConeModel(), 0.2, displacements=[0.3, 1.0], voltages=voltages, wrinkles="relax", elements=12
    ).squeeze()
    assert found["ending"].values.T.tolist() == [
        [Ending.CONVERGED, Ending.SLACK, Ending.PULLED_IN],
        [Ending.CONVERGED, Ending.PULLED_IN, Ending.PULLED_IN],
    ]
    assert found["force"].values[1:, 0].tolist()[0] == 0.0
    assert np.isnan(found["force"].values[2]).all()
    reached = found["reached_voltage"].values[2]
    assert reached[0] == pytest.approx(0.691433, abs=2e-6)
    assert reached[1] == pytest.approx(0.4377, rel=0.02)


def test_rings_alike_fall_slack_where_the_cone_does():
    film, start = column(0.4)
    found = charged(film, start, slack_limit(film.model), 0.04)
    assert found.ending == Ending.SLACK
    cone = ConeModel(film="wrinkling")
    assert found.end == pytest.approx(float(cone.film.balancing(0.4, 0.0, cone.numbers())), rel=5e-3)


def test_a_film_longer_than_its_slant_is_slack_from_no_voltage_on():
    """Released, its meridian is 1/0.8 long, which is the slant at x = 0.75; above it bears a force, below it none."""
    model = ConeModel(prestretch=0.8, prestretch_mode="equibiaxial")
    found = membrane(model, 0.2, displacements=[0.3, 0.74, 0.76], voltages=[0.0, 0.1], wrinkles="relax", elements=8)
    assert found["ending"].values.squeeze().tolist() == [[Ending.SLACK, Ending.SLACK, Ending.CONVERGED]] * 2
    np.testing.assert_array_equal(found["force"].values.squeeze() > 0.0, [[False, False, True]] * 2)
    np.testing.assert_array_equal(found["reached_voltage"].values.squeeze(), [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]])
    for name in ("hoop_slack", "meridional_slack"):
        assert found[name].values.squeeze()[:, :2].all()


def test_voltages_of_slack_films():
    assert np.sqrt(slack_limit(ConeModel())) == pytest.approx(0.691433, abs=1e-6)
    assert np.sqrt(slack_limit(NEO_HOOKEAN)) == pytest.approx(0.687365, abs=1e-6)


def test_a_ring_between_two_nodes_pulls_in_too():
    """At a stretch limit of 8 a ring beside the disc that has pulled in comes to rest again, firm, and its neighbours
    too: lengths between them are not."""
    film, start = column(0.85, ConeModel(stretch_limit=8.0, spring_stiffness=0.0), 16)
    found = charged(film, start, slack_limit(film.model), 0.05)
    assert found.ending == Ending.PULLED_IN
    assert found.end == pytest.approx(0.493, abs=2e-3)


def test_a_film_whose_rings_move_inwards_falls_slack_without_pulling_in():
    """Hoops stretched more than meridians; heights near the disc's are the hardest to follow."""
    film, start = column(0.15, ConeModel(prestretch=1.2, spring_stiffness=0.0), 16)
    found = charged(film, start, slack_limit(film.model), 0.05, tolerance=0.02)
    assert found.ending == Ending.SLACK
    assert found.end == pytest.approx(0.41, abs=0.02)
    assert found.points[-1].force < 0.01 * start.force


def test_the_cone_of_a_film_has_its_prestretches_and_law():
    model = ConeModel(meridional_prestretch=1.1, hoop_prestretch=1.4, stretch_limit=20.0)
    numbers, cone = charged_module._numbers(model), model.replace(film="wrinkling").members().own_numbers
    for name, value in numbers.items():
        assert float(value) == pytest.approx(float(np.ravel(cone[name])[0]), nan_ok=True), name
    assert (float(numbers["A"]), float(numbers["B"])) == pytest.approx((1.21, 1.96))


def test_the_least_firmness_lies_between_the_nodes_too(monkeypatch):
    """Of two elements, one short and one long; the ring in between is the softest."""
    film, squared = mesh_film(ConeModel(), 0.2, 2, relaxed=True), 0.05
    m, n = np.array([1.1, 1.2, 1.3, 1.3, 3.0, 3.3]) ** 2, 1.05

    def slopes(m):
        own = film.model.gel_law(), film.coefficients, m, np.full(m.shape, n), squared, 0.0
        d = density.relaxed_derivatives(*own)
        return 2.0 * d.m + 4.0 * m * d.mm

    monkeypatch.setattr(charged_module, "_lengths", lambda film, point: (m, np.full(m.shape, n)))
    exact, at_nodes = slopes(np.linspace(m[0], m[-1], 20_001)).min(), slopes(m).min()
    assert exact < 0.85 * at_nodes
    assert exact <= tangent_stiffness(film, None, squared) < 1.02 * exact


def test_rings_without_a_natural_width_have_pulled_in(monkeypatch):
    """Above the voltage at which a slack film does; their tension is not a number."""
    film, m = mesh_film(ConeModel(), 0.2, 2, relaxed=True), np.full(6, 1.2)
    squared = 1.01 * slack_limit(film.model)
    monkeypatch.setattr(charged_module, "_lengths", lambda film, point: (m, m))
    own = film.model.gel_law(), film.coefficients, m, m, squared, 0.0
    assert np.isnan(density.relaxed_derivatives(*own).m).all()
    assert tangent_stiffness(film, None, squared) == -np.inf


def test_lengths_follow_one_another_along_the_film():
    """Rings that moved by u = R - a, at the ends of each element and between them."""
    film = mesh_film(ConeModel(), 0.2, 3, relaxed=True)
    position = np.zeros(film.size)
    position[0::2], position[1::2] = film.place, 0.5 * film.place
    m, n = charged_module._lengths(film, Point(position, 0.0, None, True))
    nodes = [node for element in range(3) for node in range(2 * element, 2 * element + 3)]
    np.testing.assert_allclose(n, (1.0 + (film.place / film.radius)[nodes]) ** 2, rtol=1e-12)
    np.testing.assert_allclose(m, 4.0 + 0.25, rtol=1e-12)
