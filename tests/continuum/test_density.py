"""A film that may wrinkle: its relaxed energy, and the tension fields that it gives."""

import numpy as np
import pytest
from scipy.optimize import brentq

pytest.importorskip("skfem")

from gelcone.continuum import density
from gelcone.continuum.membrane import WRINKLES, membrane
from gelcone.continuum.mesh import energy, forces, mesh_film, stretches
from gelcone.errors import InputError
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from tests.continuum.films import EQUIBIAXIAL, MODELS, NEO_HOOKEAN, some_position


@pytest.mark.parametrize("v", [0.0, 0.4])
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_relaxed_forces_are_the_gradient_of_the_relaxed_energy(model, v):
    """In a state whose rings are taut, wrinkled along the hoop and slack."""
    film = mesh_film(model.replace(meridional_prestretch=0.95, hoop_prestretch=0.9), 0.2, 6, relaxed=True)
    position, squared = some_position(film, 0.5), v * v
    found = forces(film, position, squared).internal
    along, up, hoop = stretches(film, position)
    assert density.derivatives(film.model.law, film.coefficients, along**2 + up**2, hoop**2, squared).n.min() < 0.0
    for i in range(film.size):
        shift = np.zeros(film.size)
        shift[i] = 1e-5
        rise = energy(film, position + shift, squared) - energy(film, position - shift, squared)
        assert found[i] == pytest.approx(rise / 2e-5, rel=1e-5, abs=2e-7)


def test_a_taut_film_is_the_same_when_it_may_wrinkle():
    x, options = [0.5, 1.0], {"voltages": [0.0, 0.2], "elements": 40}
    marked, relaxed = (
        membrane(ConeModel(**EQUIBIAXIAL), 0.2, displacements=x, wrinkles=w, **options) for w in WRINKLES
    )
    assert not marked["hoop_slack"].any()
    np.testing.assert_allclose(relaxed["force"], marked["force"], atol=3e-6)


@pytest.mark.parametrize("x", [0.4, 1.0])
def test_a_film_wrinkled_all_over_is_a_field_of_uniaxial_threads(x):
    """A hoop with far too much length: meridians are straight, each ring in uniaxial tension l - l^-2 = C/R."""
    model = NEO_HOOKEAN.replace(hoop_prestretch=0.3, meridional_prestretch=1.0)
    found = membrane(model, 0.3, displacements=x, wrinkles="relax", elements=100).squeeze()
    places, weights = np.polynomial.legendre.leggauss(40)
    radius = found["mounted_radius"].values[0] + 0.5 * (places + 1.0)

    def stretch(pull):
        return brentq(lambda s: s - s**-2 - pull, 1.0, 50.0, xtol=1e-14)

    def length(constant):
        return 0.5 * weights @ [stretch(constant / r) for r in radius]

    slant = np.hypot(1.0, x)
    constant = brentq(lambda c: length(c) - slant, 1e-6, 20.0, xtol=1e-13)
    width = 2.0 * found["mounted_radius"].values[0] + 1.0
    assert found["hoop_slack"].item()
    assert found["force"].item() == pytest.approx(2.0 * constant * x / slant / width, rel=1e-5)
    assert np.abs(found["hoop_stress"]).max() < 1e-5


def test_a_film_with_too_much_length_both_ways_hangs_slack():
    model = ConeModel(prestretch=0.8, prestretch_mode="equibiaxial")
    found = membrane(model, 0.2, displacements=[0.05, 0.2, 0.9], wrinkles="relax", elements=40).squeeze()
    np.testing.assert_allclose(found["force"][:2], 0.0, atol=1e-6)
    assert found["force"][2] > 0.01
    assert found["hoop_slack"].all()


def test_an_unknown_way_to_treat_wrinkles_is_refused():
    with pytest.raises(InputError, match="did you mean 'relax'"):
        membrane(ConeModel(), displacements=1.0, wrinkles="relaxed")


@pytest.mark.parametrize("squared", [0.25, 0.36])
def test_a_film_that_rests_only_shorter_than_its_gap_has_pulled_in(squared):
    """Beyond its limit a film has no width; before it the natural one is no shorter than the gap."""
    law, c = LAWS["gent"], {"A": 1.0, "B": 1.0, "G": 1.0, "inverse_stretch_limit": 0.02}
    x = np.linspace(0.05, 3.0, 60)
    m, n = density.natural(law, c, 1.0 + x * x, 1.0, squared)
    cone = WrinklingCone(pull_in="minimum")
    highest = cone.highest_squared(x, cone.numbers(cone.complete({})))
    kept = ~np.isnan(m + n)
    np.testing.assert_array_equal(kept, squared < highest)
    assert 10 < kept.sum() < 50
    assert (m[kept] >= (1.0 + x * x)[kept]).all()
    assert (n[kept] >= 1.0).all()
    lost = density.relaxed_derivatives(law, c, 1.0 + x * x, np.ones(60), squared, 1e-6)
    for part in lost:
        np.testing.assert_array_equal(np.isnan(part), ~kept)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(("m", "n", "squared"), [(1.5, 1.2, 0.2), (0.8, 1.6, 0.0), (1.6, 0.4, 0.1), (0.5, 1.7, 0.2)])
def test_derivatives_are_those_of_the_density_and_of_the_relaxed_one(name, m, n, squared):
    model = MODELS[name]
    law, c, h = model.gel_law(), model.numbers(), 1e-4
    plain = (lambda m, n: density.value(law, c, m, n, squared), density.derivatives(law, c, m, n, squared))
    relaxed = (
        lambda m, n: density.relaxed_value(law, c, m, n, squared, 0.01),
        density.relaxed_derivatives(law, c, np.array([m]), np.array([n]), squared, 0.01),
    )
    for value, found in (plain, relaxed):
        at = lambda i, j, value=value: float(np.ravel(value(m + i * h, n + j * h))[0])  # noqa: E731
        expected = {
            "m": (at(1, 0) - at(-1, 0)) / (2 * h),
            "n": (at(0, 1) - at(0, -1)) / (2 * h),
            "mm": (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / h**2,
            "nn": (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / h**2,
            "mn": (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * h**2),
        }
        for which, number in expected.items():
            own = float(np.ravel(getattr(found, which))[0])
            assert own == pytest.approx(number, rel=1e-4, abs=3e-5), which


@pytest.mark.parametrize("squared", [0.0, 0.1])
def test_a_film_takes_the_widths_of_least_energy_that_are_not_shorter_than_its_gap(squared):
    model = MODELS["gent"]
    law, c = model.gel_law(), model.numbers()
    for m, n in ((1.6, 0.4), (0.5, 1.7), (0.6, 0.7), (1.3, 1.3)):
        free = [float(np.ravel(one)[0]) for one in density.natural(law, c, np.array([m]), np.array([n]), squared)]
        assert free[0] >= m * (1.0 - 1e-9)
        assert free[1] >= n * (1.0 - 1e-9)
        least = density.value(law, c, *free, squared)
        for i, j in ((1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)):
            other = max(free[0] + i, m), max(free[1] + j, n)
            assert density.value(law, c, *other, squared) >= least - 1e-12
