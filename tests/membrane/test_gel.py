"""A ring of gel: its tensions and tangent stiffness are slopes of one energy, which wrinkles make least."""

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from gelcone.membrane.crumpling import crumpling
from gelcone.membrane.gel import ENOUGH, Gel
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS

NUMBERS = {"gent": {"stretch_limit": 20.0}, "neo-hookean": {}, "yeoh": {"yeoh_c2": 0.05, "yeoh_c3": 0.002}}
TENSE = [(1.3, 1.1, 0.1), (0.9, 1.2, 0.0), (1.6, 0.95, 0.2)]
SLACK = [(1.5, 0.6, 0.1), (1.8, 0.5, 0.0), (1.4, 0.7, 0.25)]


def gel_of(law, A=1.2, B=1.5):
    return Gel(LAWS[law], LAWS[law].numbers(NUMBERS[law]), A, B)


def energy(gel, m, n, V):
    """W/mu - V m n/2, of squared lengths, by the law's own energy."""
    return gel.law.energy(gel.A * m + gel.B * n + 1.0 / (gel.A * gel.B * m * n) - 3.0, gel.numbers) - 0.5 * V * m * n


def relaxed(gel, l1, l2, V):
    """The energy of a ring that may wrinkle: the least over all widths from the span on."""
    m, span = l1 * l1, l2 * l2
    found = minimize_scalar(
        lambda n: energy(gel, m, n, V), bounds=(span, 4.0), options={"xatol": 1e-12}, method="bounded"
    )
    return min(found.fun, energy(gel, m, span, V))


@pytest.mark.parametrize("law", NUMBERS)
@pytest.mark.parametrize("place", TENSE + SLACK)
def test_tensions_and_firmness_are_the_slopes_of_the_relaxed_energy(law, place):
    gel, h, (l1, l2, V) = gel_of(law), 2e-3, place
    ring = Gel.at(gel, *(np.array([value]) for value in place))
    assert (gel.hoop(*(np.array([value]) for value in place)) < 0.0) == (place in SLACK)

    def E(i, j):
        return relaxed(gel, l1 + i * h, l2 + j * h, V)

    def slope(i, j):
        return (8.0 * (E(i, j) - E(-i, -j)) - (E(2 * i, 2 * j) - E(-2 * i, -2 * j))) / (12.0 * h)

    cross = (E(1, 1) - E(1, -1) - E(-1, 1) + E(-1, -1)) / (4.0 * h * h)
    curve = [(E(i, j) - 2.0 * E(0, 0) + E(-i, -j)) / (h * h) for i, j in ((1, 0), (0, 1))]
    assert ring.meridional[0] == pytest.approx(slope(1, 0), abs=2e-7)
    assert ring.hoop[0] == pytest.approx(slope(0, 1), abs=2e-7)
    for own, other in (
        (ring.tangent_stiffness, curve[0]),
        (ring.hoop_tangent_stiffness, curve[1]),
        (ring.coupling, cross),
    ):
        assert own[0] == pytest.approx(other, rel=2e-4, abs=1e-4)


@pytest.mark.parametrize("law", NUMBERS)
def test_the_width_of_a_slack_ring_is_the_one_of_least_energy_and_of_a_tense_one_its_span(law):
    gel = gel_of(law)
    for l1, l2, V in SLACK:
        n = float(gel.width(np.array([l1]), np.array([l2]), np.array([V]))[0])
        assert n > l2 * l2
        assert energy(gel, l1 * l1, n, V) < min(energy(gel, l1 * l1, n * share, V) for share in (0.99, 1.01))
        assert gel.natural(np.array([l1 * l1]), np.array([V]), np.array([1.0]))[0] == pytest.approx(n, rel=1e-12)
    for l1, l2, V in TENSE:
        assert gel.width(np.array([l1]), np.array([l2]), np.array([V]))[0] == l2 * l2


@pytest.mark.parametrize("law", NUMBERS)
def test_widths_have_the_bits_of_all_steps_also_where_the_numbers_differ_between_places(law):
    rng = np.random.default_rng(3)
    m, V, n = rng.uniform(1.0, 4.0, (3, 4000)) * np.array([[1.0], [0.05], [0.2]])
    A, B = rng.uniform(1.0, 1.6, (2, 4000))
    gel = Gel(LAWS[law], {k: v * rng.uniform(0.9, 1.1, 4000) for k, v in gel_of(law).numbers.items()}, A, B)
    found, least = n, np.sqrt(gel.G / (B * m))
    with np.errstate(all="ignore"):
        for _ in range(ENOUGH):
            r = gel.G / (m * found)
            strain, thin = A * m + B * found + r - 3.0, B - r / found
            excess = thin - V * m * gel.law.compliance(strain, gel.numbers)
            slope = 2.0 * r / (found * found) + V * m * gel.law.stiffening(strain, gel.numbers) * thin
            found = np.clip(found - excess / slope, np.maximum(least, 0.4 * found), 3.0 * found)
        np.testing.assert_array_equal(gel.natural(m, V, n), found)
        slack = gel.hoop(np.sqrt(m), np.sqrt(n), V) < 0.0
        assert 400 < slack.sum() < 3600
        given = np.sqrt(m), np.sqrt(n), V
        one = [Gel(gel.law, {k: v[i] for k, v in gel.numbers.items()}, A[i], B[i]) for i in range(40)]
        alone = [own.width(*(value[i] for value in given)) for i, own in enumerate(one)]
        np.testing.assert_array_equal(gel.width(*given)[:40], alone)


@pytest.mark.parametrize("law", NUMBERS)
def test_the_crumpling_voltage_leaves_a_film_stretched_alike_without_stress(law):
    gel, t = gel_of(law), np.array([1.1, 1.3, 1.5])
    V = gel.crumpling(t) / gel.G
    m, n = t / gel.A, t / gel.B
    for k in range(t.size):
        for one, other in ((1e-5, 0.0), (0.0, 1e-5)):
            change = energy(gel, m[k] + one, n[k] + other, V[k]) - energy(gel, m[k] - one, n[k] - other, V[k])
            assert change / 2e-5 == pytest.approx(0.0, abs=1e-8)
    below = float(gel.crumpling(gel.hump())) / gel.G > V if np.isfinite(gel.hump()) else V > 0.0
    np.testing.assert_allclose(gel.natural_stretch(V)[below], t[below], rtol=1e-12)
    if gel.hump() < 10.0:
        beyond = np.array([1.01, 3.0]) * float(gel.crumpling(gel.hump())) / gel.G
        np.testing.assert_array_equal(gel.natural_stretch(beyond), gel.hump())


@pytest.mark.parametrize("limit", [3.0, 8.0, 50.0])
def test_no_voltage_crumples_a_film_at_its_limit(limit):
    """2 t + t^-2 - 3 = J: just before, the voltage is beyond all others, and there it is infinite."""
    law = LAWS["gent"]
    n = law.numbers({"stretch_limit": limit})
    t = np.roots([2.0, -(limit + 3.0), 0.0, 1.0]).real.max()
    before, there = crumpling(law, np.array([t * (1.0 - 1e-7), t * (1.0 + 1e-12)]), n)
    assert 1e5 < before < np.inf
    assert there == np.inf
    assert float(crumpling(law, 0.9 * t, n)) < 10.0


@pytest.mark.parametrize("law", NUMBERS)
def test_the_crumpling_voltage_has_no_error_but_rounding(law):
    """Against 40 digits of the stress R (t - t^-2) of the law's own energy over the squared area ratio t^2."""
    numbers, t = gel_of(law).numbers, 1.0 + np.geomspace(1e-9, 5.0, 60)
    found = crumpling(LAWS[law], t, numbers)
    with mpmath.workdps(60):
        n = {name: mpmath.mpf(float(value)) for name, value in numbers.items()}
        for value, at in zip(found.tolist(), map(mpmath.mpf, t.tolist()), strict=True):
            response = 2 * mpmath.diff(lambda strain: LAWS[law].energy(strain, n, mpmath), 2 * at + at**-2 - 3)
            exact = response * (at - at**-2) / at**2
            assert abs(value / exact - 1) < 8e-16 / min(at - 1, 1)


@pytest.mark.parametrize("law", NUMBERS)
def test_the_film_that_wrinkles_crumples_at_the_voltage_of_its_gel_bit_for_bit(law):
    film, gel = WrinklingCone(law=LAWS[law]), gel_of(law)
    n = film.numbers(
        film.complete({**NUMBERS[law], "meridional_prestretch": gel.A**0.5, "hoop_prestretch": gel.B**0.5})
    )
    own = Gel(gel.law, gel.numbers, float(n["A"]), float(n["B"]))
    assert float(n["crumpling_squared"]) == float(own.crumpling(own.B)) / float(n["G"])


def test_the_hump_of_a_neo_hookean_gel_and_of_one_with_a_low_limit():
    """(1 - t^-3)/t is largest where t^3 = 4; a gel with a low limit stiffens before."""
    assert gel_of("neo-hookean").hump() == pytest.approx(4.0 ** (1.0 / 3.0), rel=1e-15)
    stiff = Gel(LAWS["gent"], LAWS["gent"].numbers({"stretch_limit": 1.0}), 1.0, 1.0)
    assert stiff.hump() == np.inf
    assert stiff.crumpling(2.1) == np.inf
    assert np.isfinite(stiff.crumpling(1.5))


@pytest.mark.parametrize(
    ("A", "B", "rims"),
    [
        (1.0, 1.5, True), (1.2, 1.2 + 1e-9, True), (1.2, 1.2, False), (1.4, 1.1, False), (0.8, 0.9, False),
        (0.8, 1.0, False), (0.8, 1.0 + 1e-9, True),
    ],
)  # fmt: skip
def test_a_film_has_rims_where_its_hoop_is_stretched_and_more_than_its_meridian(A, B, rims):
    gel = gel_of("neo-hookean", A, B)
    assert gel.has_rims is rims
    assert pytest.approx(1.0 / gel.G, rel=1e-15) == A * B
