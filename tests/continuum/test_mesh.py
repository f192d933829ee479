"""The mesh of the film: energy, forces and tangent belong together."""

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum.mesh import (
    check_radius_ratio,
    electric_forces,
    energy,
    forces,
    interpolated,
    mesh_film,
    reachable,
    tangent,
)
from gelcone.continuum.path import cone
from gelcone.errors import InputError
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from tests.continuum.films import MODELS, alone, dense, some_position


def test_all_laws_are_tested():
    assert {model.law.name for model in MODELS.values()} == set(LAWS)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_homogeneous_cone_has_the_energy_of_the_model(model):
    """The definition of the scales: at m = q and n = 1 the film's energy is the cone's, voltage included."""
    film = mesh_film(model, 0.3, 8)
    for x, v in ((0.0, 0.0), (0.4, 0.7), (0.9, 1.3)):
        expected = float(alone(model).energy(x)) - 0.5 * v * v * (1.0 + x * x)
        assert energy(film, cone(film, x), v * v) == pytest.approx(expected, rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_forces_are_the_gradient_of_the_energy(model):
    film, squared = mesh_film(model, 0.2, 6), 0.3
    position = some_position(film)
    found = forces(film, position, squared).internal

    def slope(shift):
        return (energy(film, position + shift, squared) - energy(film, position - shift, squared)) / (2.0 * shift.max())

    for i in range(film.size):
        shift = np.zeros(film.size)
        shift[i] = 1e-3
        # Richardson's extrapolation of central differences, of the order 6
        expected = (64.0 * slope(0.5 * shift) - 20.0 * slope(shift) + slope(2.0 * shift)) / 45.0
        assert found[i] == pytest.approx(expected, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_tangent_is_the_gradient_of_the_forces(model):
    film, squared, step = mesh_film(model, 0.2, 5), 0.3, 3e-6
    position = some_position(film)
    found = dense(tangent(film, position, squared))
    np.testing.assert_allclose(found, found.T, atol=1e-13)
    columns = [
        (forces(film, position + e, squared).internal - forces(film, position - e, squared).internal) / (2 * step)
        for e in step * np.eye(film.size)
    ]
    np.testing.assert_allclose(found, np.array(columns).T, rtol=1e-6, atol=1e-6)
    now = forces(film, position, squared)
    by_voltage = (forces(film, position, squared + 1e-3).internal - now.internal) / 1e-3
    np.testing.assert_allclose(electric_forces(film, position, squared, now), by_voltage, rtol=1e-9, atol=1e-12)


def test_a_state_is_reachable_within_the_stretch_limit_and_with_no_ring_turned_inside_out():
    film = mesh_film(ConeModel(stretch_limit=20.0), 0.2, 6)
    own = cone(film, 0.8)
    assert reachable(film, own)
    assert not reachable(film, cone(film, 8.0))
    for node, turned in ((1, 1.05), (film.place.size - 2, 1.05), (3, 3.0)):
        inside_out = own.copy()
        inside_out[2 * node] = -turned * film.radius[node]
        assert not reachable(film, inside_out)
    broken = own.copy()
    broken[5] = np.nan
    assert not reachable(film, broken)
    free = mesh_film(ConeModel(law="neo-hookean"), 0.2, 6)
    assert reachable(free, cone(free, 8.0))
    lower = cone(free, 8.0)
    lower[2] = -2.0 * free.radius[1]  # some rings alone, of a film without limit
    assert not reachable(free, lower)


def test_the_meridional_force_of_a_cone_is_that_of_its_stretches_everywhere():
    """Least and most are the extremes along the meridian, whatever the hoop bears; a film that is bulged has two."""
    model = ConeModel(law="neo-hookean", meridional_prestretch=1.3, hoop_prestretch=0.8)
    film, squared = mesh_film(model, 0.2, 6), 0.2
    a, g, m = 1.3**2, 1.0 / (1.3**2 * 0.8**2), 1.0 + 0.5**2
    now = forces(film, cone(film, 0.5), squared)
    pull = 0.5 * (a - g / m**2) - 0.5 * squared
    assert (now.least, now.most) == (pytest.approx(pull), pytest.approx(pull))
    assert 0.5 * (0.8**2 - g / m) < 0.0  # the hoop is compressed
    bulged = forces(film, some_position(film), squared)
    assert bulged.least == bulged.density.m.min() < bulged.density.m.max() == bulged.most


@pytest.mark.parametrize("ratio", [0.0, 1.0, 1e-10, 1.0 - 1e-10, -0.2, 1.2, np.nan])
def test_a_disc_without_a_size_or_a_film_without_width_is_refused(ratio):
    with pytest.raises(InputError, match=r"radius_ratio = .*: must lie between 0 and 1"):
        check_radius_ratio(ratio)


@pytest.mark.parametrize("elements", [1, 0, -3, 8.0, True, "8"])
def test_a_film_is_cut_into_two_elements_at_least(elements):
    with pytest.raises(InputError, match=f"elements = {elements!r}: must be a whole number, at least 2"):
        mesh_film(ConeModel(), 0.2, elements)
    assert len(mesh_film(ConeModel(), 0.2, 2).weight) == len(mesh_film(ConeModel(), 0.2, np.int64(2)).weight) == 2


@pytest.mark.parametrize("ratio", ["0.2", True, [0.2], None, 0.2j])
def test_a_radius_ratio_is_one_number(ratio):
    with pytest.raises(InputError, match="must be one number, the disc's radius over the film's"):
        check_radius_ratio(ratio)


def test_the_radii_of_a_narrow_film_stay_apart():
    for ratio in (1e-8, np.float32(0.5), 1.0 - 1e-8):
        assert check_radius_ratio(ratio) == ratio
        assert (np.diff(mesh_film(ConeModel(), ratio, 4).place) > 0.0).all()


def test_between_nodes_values_are_those_of_the_parabola_through_them():
    film = mesh_film(ConeModel(), 0.2, 5)
    places = np.linspace(0.0, 1.0, 41)
    for coefficients in ([1.0, -2.0, 0.5], [0.0, 1.0, 0.0], [0.3, 0.0, 0.0]):
        of = np.polynomial.Polynomial(coefficients)
        np.testing.assert_allclose(interpolated(film, of(film.place), places), of(places), atol=1e-14)
    bump = np.zeros(film.place.size)
    bump[3] = 1.0  # the middle of the second element
    low, high = film.place[2], film.place[4]
    share = (places - low) / (high - low)
    expected = np.where((share > 0.0) & (share < 1.0), 4.0 * share * (1.0 - share), 0.0)
    np.testing.assert_allclose(interpolated(film, bump, places), expected, atol=1e-14)
