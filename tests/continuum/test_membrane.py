"""The film as a continuum: against exact states, an independent shooting solution, and the cone it should become."""

import itertools
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

pytest.importorskip("skfem")

from gelcone.continuum import density
from gelcone.continuum.compare import compare, limit_displacements, mesh_convergence
from gelcone.continuum.membrane import WRINKLES, membrane
from gelcone.continuum.mesh import BAND, derivatives, electric_forces, energy, forces, mesh_film, stretches, tangent
from gelcone.continuum.path import FREE, Ending, arc, cone, newton, reach
from gelcone.continuum.solid import assembled, mesh_solid, solid
from gelcone.errors import InputError
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel

MODELS = {
    "gent": ConeModel(),
    "soft limit": ConeModel(stretch_limit=4.0, meridional_prestretch=1.1, hoop_prestretch=1.2),
    "neo-hookean": ConeModel(law="neo-hookean", prestretch=1.2, prestretch_mode="equibiaxial"),
    "yeoh": ConeModel(law="yeoh", **{"yeoh_c2": 0.1, "yeoh_c3": 0.02}, prestretch=1.1),
}
EQUIBIAXIAL = {"prestretch": 1.2, "prestretch_mode": "equibiaxial"}
NEO_HOOKEAN = ConeModel(law="neo-hookean")


def alone(model):
    """The cone model's film without its spring."""
    return model.replace(spring_stiffness=0.0)


def some_position(film, height=0.6):
    """A smooth state that is no equilibrium."""
    position = cone(film, height)
    s = film.place
    position[0::2] = 0.06 * np.sin(np.pi * s)
    position[1::2] -= 0.05 * np.sin(np.pi * s) * s
    return position


def dense(band):
    """The full matrix of a band matrix."""
    size = band.shape[1]
    full = np.zeros((size, size))
    for k in range(2 * BAND + 1):
        for column in range(size):
            row = column + k - BAND
            if 0 <= row < size:
                full[row, column] = band[k, column]
    return full


# --- energy, forces, tangent -----------------------------------------------------------------------------------------


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
    by_voltage = (forces(film, position, squared + 1e-3).internal - forces(film, position, squared).internal) / 1e-3
    np.testing.assert_allclose(electric_forces(film, position, squared), by_voltage, rtol=1e-9, atol=1e-12)


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


# --- exact states ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.7])
def test_flat_equibiaxial_state_is_exact(ratio):
    """Neo-Hookean: s = l^2 - l^-4 - v^2 in both directions. Green and Adkins, Large Elastic Deformations (1960)."""
    stretch, v = 1.3, 0.4
    model = NEO_HOOKEAN.replace(prestretch=stretch, prestretch_mode="equibiaxial")
    result = membrane(model, ratio, displacements=0.0, voltages=v, elements=20).squeeze()
    for name in ("meridional_stress", "hoop_stress"):
        np.testing.assert_allclose(result[name], stretch**2 - stretch**-4 - v**2, rtol=1e-12)
    np.testing.assert_allclose(result["radius"], result["mounted_radius"], rtol=1e-13)
    assert float(result["force"]) == 0.0


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


@pytest.mark.parametrize("v", [0.0, 0.5])
def test_a_narrow_film_is_in_pure_shear(v):
    """a/b -> 1: the hoop is held, s1 = l^2 - l^-2 - v^2 l^2, s2 = 1 - l^-2 - v^2 l^2 and l = sqrt(q)."""
    result = membrane(NEO_HOOKEAN, 1.0 - 1e-8, displacements=[0.5, 1.0, 2.0], voltages=v, elements=20).squeeze()
    q = 1.0 + result["displacement"] ** 2
    for name, exact in (("meridional_stress", q - 1 / q - v**2 * q), ("hoop_stress", 1.0 - 1 / q - v**2 * q)):
        np.testing.assert_allclose(result[name], exact.broadcast_like(result[name]), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("prestretch", [{}, EQUIBIAXIAL, {"prestretch": 1.2}])
def test_a_narrow_film_is_the_cone(prestretch):
    model = ConeModel(**prestretch)
    x = np.array([-0.6, 0.3, 0.6, 1.5, 3.0])
    deviation = {
        ratio: np.abs(membrane(model, ratio, displacements=x, voltages=0.5).force[0] / alone(model).force(x, 0.5) - 1)
        for ratio in (0.99, 0.999)
    }
    assert deviation[0.999].max() < 2e-6
    np.testing.assert_allclose(deviation[0.99] / deviation[0.999], 100.0, rtol=0.02)


@pytest.mark.parametrize(("ratio", "v"), [(0.05, 0.0), (0.2, 0.0), (0.2, 0.6), (0.8, 0.0)])
def test_a_shallow_film_under_prestress_is_the_classical_drumhead(ratio, v):
    """F = 2 pi T h/ln(b/a) with the profile h ln(b/R)/ln(b/a), to the order h^2. Timoshenko, Theory of Plates."""
    model = NEO_HOOKEAN.replace(**EQUIBIAXIAL)
    tension = 1.2**2 - 1.2**-4 - v**2
    x = np.array([1e-3, 2e-3])
    result = membrane(model, ratio, displacements=x, voltages=v, elements=400).squeeze()
    exact = 2.0 * tension * (1.0 - ratio) / ((1.0 + ratio) * np.log(1.0 / ratio)) * x
    error = np.abs(result["force"].values / exact - 1.0)
    assert error.max() < 1e-4
    # what is left is of the order h^2, so that the extrapolated stiffness is exact
    stiffness = result["force"].values / x
    assert (4.0 * stiffness[0] - stiffness[1]) / 3.0 == pytest.approx(exact[0] / x[0], rel=1e-7)
    profile = np.log(1.0 / (ratio * result["mounted_radius"] * (1.0 - ratio) / ratio)) / np.log(1.0 / ratio)
    np.testing.assert_allclose(result["height"][0] / 1e-3, profile, atol=1e-5)


# --- an independent route --------------------------------------------------------------------------------------------


def shot(model, ratio, x, v):
    """The force on the disc by shooting: the equilibrium of rings as an initial-value problem, integrated from the disc
    outwards; unknown are the vertical and the radial force on it."""
    film, squared = mesh_film(model, ratio, 4), v * v
    disc, span = film.disc, (film.disc, film.disc + 1.0)

    def along(n, pull):
        """The stretch along the meridian that carries the nominal pull."""
        c = film.coefficients
        highest = min(0.999 * np.sqrt((model.strain_limit() + 3.0 - c.B * n) / c.A), 20.0)
        return brentq(lambda s: 2.0 * s * derivatives(film, s * s, n, squared).m - pull, 0.5, highest, xtol=1e-14)

    def slope(radius, state, force):
        r, _, radial = state
        n = (r / radius) ** 2
        pull = np.hypot(force, radial)
        s = along(n, pull / radius)
        hoop = 2.0 * np.sqrt(n) * derivatives(film, s * s, n, squared).n
        return [s * radial / pull, -s * force / pull, hoop]

    def miss(unknown):
        begin = [disc, x, unknown[1]]
        end = solve_ivp(slope, span, begin, args=(unknown[0],), rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
        return end[:2] - [span[1], 0.0]

    coarse = mesh_film(model, ratio, 8)
    rough = reach(coarse, newton(coarse, cone(coarse, x), 0.0), "squared", squared)[0]
    scale = (2.0 * disc + 1.0) / 2.0
    vertical, _ = fsolve(miss, scale * rough.forces.internal[[1, 0]] * [1.0, -1.0], xtol=1e-12)
    return vertical / scale


@pytest.mark.parametrize(
    ("parameters", "ratio", "x", "v"),
    [
        ({}, 0.2, 1.0, 0.0),
        ({}, 0.2, 2.0, 0.3),
        (EQUIBIAXIAL, 0.1, 0.7, 0.5),
        ({"prestretch": 1.2}, 0.3, 1.5, 0.2),
        ({"law": "neo-hookean"}, 0.5, 0.8, 0.4),
    ],
)
def test_the_force_agrees_with_shooting(parameters, ratio, x, v):
    model = ConeModel(**parameters)
    found = membrane(model, ratio, displacements=x, voltages=v)
    assert found.ending.item() == Ending.CONVERGED
    assert found.force.item() == pytest.approx(shot(model, ratio, x, v), rel=1e-8)


@pytest.mark.parametrize("x", [0.3, 1.0, 3.0])
def test_the_vertical_force_is_the_same_on_every_ring(x):
    """2 R N sin(slope)/(b^2 - a^2) = F along the whole film, N the nominal pull along the meridian."""
    result = membrane(ConeModel(), 0.2, displacements=x).squeeze()
    thickness = 1.0 / (result["meridional_stretch"] * result["hoop_stretch"])
    edge = np.gradient(result["height"], result["radius"])
    sine = -edge / np.hypot(1.0, edge)
    force = 2.0 * result["radius"] * result["meridional_stress"] * thickness * sine / (2.0 * 0.25 + 1.0)
    np.testing.assert_allclose(force[2:-2], float(result["force"]), rtol=2e-4)


# --- the mesh --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("prestretch", [{}, EQUIBIAXIAL])
@pytest.mark.parametrize("v", [0.0, 0.4])
def test_the_mesh_converges_as_quadratic_elements_promise(prestretch, v):
    table = mesh_convergence(ConeModel(**prestretch), 0.2, displacement=1.0, voltage=v)
    np.testing.assert_allclose(table["force_order"][1:], 4.0, atol=0.1)
    np.testing.assert_allclose(table["shape_order"][1:], 3.0, atol=0.1)
    assert float(table["force_error"][-1]) < 1e-8


# --- voltage, folds, slack -------------------------------------------------------------------------------------------


def test_a_film_in_tension_never_pushes_the_disc():
    """The sign of the meridional force is that of the force on the disc; where the cone pushes, no tension is left."""
    x = np.linspace(0.1, 2.0, 8)
    result = membrane(ConeModel(), 0.2, displacements=x, voltages=[0.3, 0.6, 1.0], elements=60)
    held = result["ending"] == Ending.CONVERGED
    assert (result["force"].where(held, 1.0) > 0.0).all()
    assert not (result["meridional_slack"] & held).any()
    compressed = result["ending"] == Ending.COMPRESSED
    assert compressed.any()
    assert (result["force"].where(compressed, -1.0) < 0.0).all()
    assert (result["meridional_slack"] | ~compressed).all()
    assert not (result["stable"] & compressed).any()


def test_every_point_that_did_not_converge_is_nan_and_tells_its_load():
    result = membrane(ConeModel(), 0.2, displacements=np.linspace(0.1, 1.5, 8), voltages=[0.0, 1.0], elements=40)
    failed = result["ending"].isin([Ending.TENSION_LOST, Ending.PULLED_IN, Ending.NOT_CONVERGED])
    assert failed.any()
    assert not failed.sel(constant_voltage=0.0).any()
    assert (np.isnan(result["force"]) == failed).all()
    assert (np.isnan(result["radius"]).all("ring") == failed).all()
    reached = result["reached_voltage"]
    assert ((reached < 1.0) & (reached > 0.0) | ~failed).sel(constant_voltage=1.0).all()


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


def test_lowering_the_disc_finds_the_same_pulled_in_film_as_the_arc():
    single = membrane(ConeModel(), 0.2, displacements=1.9, voltages=0.6, elements=60)
    beside = membrane(ConeModel(), 0.2, displacements=[1.9, 2.0, 2.1], voltages=0.6, elements=60)
    assert single.force.item() == pytest.approx(beside.force[0, 0].item(), rel=1e-9)


@pytest.mark.parametrize("v", [0.3, 0.6])
def test_a_curve_holds_the_points_that_single_runs_find(v):
    x = np.array([0.4, 0.8, 1.2, 1.6])
    curve = membrane(ConeModel(), 0.2, displacements=x, voltages=v, elements=60).squeeze()
    for k, place in enumerate(x):
        point = membrane(ConeModel(), 0.2, displacements=place, voltages=v, elements=60)
        assert point.ending.item() == curve["ending"][k]
        np.testing.assert_allclose(point.force.item(), curve["force"][k], rtol=1e-9)


def test_fifty_points_on_two_hundred_elements_take_less_than_five_seconds_of_one_core():
    begin = time.process_time()
    curve = membrane(ConeModel(), 0.2, displacements=np.linspace(0.04, 2.0, 50), elements=200)
    assert time.process_time() - begin < 5.0
    assert (curve["ending"] == Ending.CONVERGED).all()


def test_hoop_slack_is_marked():
    """Without pre-stretch, any voltage compresses the clamped hoop of a low disc."""
    result = membrane(ConeModel(), 0.2, displacements=0.5, voltages=[0.0, 0.4], elements=40).squeeze()
    assert result["hoop_slack"].values.tolist() == [False, True]
    assert (result["hoop_stress"].min("ring") < 0.0).values.tolist() == [False, True]


def test_radial_prestretch_leaves_the_flat_film_compressed_beside_the_disc():
    """Hoop tension alone draws the rings inwards: below some height no film in tension exists."""
    result = membrane(ConeModel(prestretch=1.2), 0.2, displacements=[0.05, 0.5], elements=60).squeeze()
    assert result["ending"].values.tolist() == [Ending.TENSION_LOST, Ending.CONVERGED]


def test_a_lowered_disc_mirrors_a_raised_one():
    result = membrane(ConeModel(), 0.2, displacements=[-0.7, 0.0, 0.7], voltages=0.3, elements=30).squeeze()
    assert result["force"][0] == -result["force"][2]
    assert result["force"][1] == 0.0
    np.testing.assert_array_equal(result["height"][0], -result["height"][2])
    np.testing.assert_array_equal(result["hoop_stress"][0], result["hoop_stress"][2])


# --- wrinkles --------------------------------------------------------------------------------------------------------


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


# --- the comparison --------------------------------------------------------------------------------------------------


def test_compare_puts_the_cone_beside_the_continuum():
    model = ConeModel(spring_stiffness=7.0, prestretch=[1.1, 1.2], prestretch_mode="equibiaxial")
    x, levels = np.array([0.5, 1.0]), np.array([0.0, 0.3])
    result = compare(model, 0.2, displacements=x, voltages=levels, elements=40)
    assert result["cone_force"].dims == ("member", "constant_voltage", "displacement")
    for k, level in enumerate(levels):
        exact = alone(model).force(np.broadcast_to(x, (2, 2)), level)
        np.testing.assert_allclose(result["cone_force"][:, k], exact, rtol=1e-14)
    ratio = result["cone_force"] / result["continuum_force"] - 1.0
    np.testing.assert_allclose(result["deviation"], ratio, rtol=1e-12)
    assert (result["deviation"] > 0.0).all()
    assert (result["limit_displacement"] < result["cone_limit_displacement"]).all()


def test_the_continuum_reaches_its_limit_sooner_and_beside_the_disc():
    film = mesh_film(ConeModel(), 0.2, 80)
    found = limit_displacements(film, (0.1, 0.5))
    result = membrane(ConeModel(), 0.2, displacements=found, elements=80).squeeze()
    np.testing.assert_allclose(result["limit_share"], [0.1, 0.5], rtol=1e-6)
    np.testing.assert_allclose(result["limit_radius"], film.disc)
    assert np.isnan(limit_displacements(mesh_film(NEO_HOOKEAN, 0.2, 4))).all()


def test_radius_ratios_make_an_ensemble_equal_to_single_runs():
    together = membrane(ConeModel(), [0.2, 0.5], displacements=[0.5, 1.0], elements=20)
    for i, ratio in enumerate((0.2, 0.5)):
        apart = membrane(ConeModel(), ratio, displacements=[0.5, 1.0], elements=20)
        np.testing.assert_array_equal(together["force"][i], apart["force"])
    np.testing.assert_array_equal(together["radius_ratio"], [0.2, 0.5])


def test_results_save_and_load(tmp_path):
    from gelcone.dataset import load, save

    result = compare(ConeModel(), 0.2, displacements=[0.5, 1.0], voltages=[0.0, 1.0], elements=20)
    save(result, tmp_path / "compared.nc")
    assert load(tmp_path / "compared.nc").identical(result)


# --- the solid -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_tangent_of_the_solid_is_the_gradient_of_its_forces(model):
    body = mesh_solid(model, 0.3, 0.1, (3, 1))
    size = body.unknowns.max() + 1
    position = 0.01 * np.random.default_rng(5).standard_normal(size)
    _, _, (values, places) = assembled(body, position)
    stiffness = np.zeros((size, size))
    np.add.at(stiffness, places, values)
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-12)
    step = 1e-6 * np.random.default_rng(6).standard_normal(size)
    change = assembled(body, position + step)[0] - assembled(body, position - step)[0]
    np.testing.assert_allclose(2.0 * stiffness @ step, change, atol=1e-6 * np.abs(change).max())


@pytest.mark.parametrize("parameters", [{}, EQUIBIAXIAL, {"law": "neo-hookean"}])
def test_the_thin_solid_is_the_membrane(parameters):
    x = [-1.0, 0.5, 1.0, 2.0]
    result = solid(ConeModel(**parameters), 0.2, displacements=x, thickness=[0.008, 0.004])
    assert (result["ending"] == Ending.CONVERGED).all()
    deviation = result["deviation"].values
    assert np.abs(deviation).max() < 0.01
    assert deviation[0, 0] == pytest.approx(deviation[0, 2], rel=1e-9)
    # bending and the held faces add stiffness in proportion to the thickness
    np.testing.assert_allclose(deviation[0] / deviation[1], 2.0, rtol=0.08)
    assert (deviation < 0.0).all()


def test_the_solid_refuses_what_it_cannot_solve():
    for options, told in (
        ({"displacements": 1.0, "thickness": 0.0}, "thickness = 0: must be greater than 0"),
        ({"displacements": 0.0}, "0 needs no force"),
        ({"displacements": 1.0, "elements": (3, 0)}, "must be two whole numbers"),
        ({"displacements": 1.0, "radius_ratio": 1.1}, "must lie between 0 and 1"),
    ):
        with pytest.raises(InputError, match=told):
            solid(ConeModel(), **options)
    with pytest.raises(InputError, match="one actuator is solved at a time"):
        solid(ConeModel(prestretch=[1.0, 1.1]), displacements=1.0)


# --- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.0, 1.0, 1.5, -0.1, np.nan])
def test_a_disc_larger_than_the_film_is_refused(ratio):
    with pytest.raises(InputError, match=r"radius_ratio = .* must lie between 0 and 1"):
        membrane(ConeModel(), ratio, displacements=1.0)


def test_a_height_beyond_the_stretch_limit_is_refused_or_marked():
    with pytest.raises(InputError, match=r"no film spans them within its stretch limit; give \|x\| below"):
        membrane(ConeModel(stretch_limit=2.0), 0.2, displacements=[3.0, -4.0])
    result = membrane(ConeModel(stretch_limit=2.0), 0.2, displacements=[0.5, 3.0], elements=40).squeeze()
    assert result["ending"].values.tolist() == [Ending.CONVERGED, Ending.BEYOND_LIMIT]
    assert np.isnan(result["force"][1])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"displacements": [0.5, 0.5]}, "each given once"),
        ({"displacements": [np.inf]}, "must be finite"),
        ({"displacements": "high"}, "must be numbers"),
        ({"displacements": 1.0, "voltages": -1.0}, "voltages = -1: must be at least 0"),
        ({"displacements": 1.0, "elements": 1}, "elements = 1: must be a whole number, at least 2"),
        ({"displacements": 1.0, "radius_ratio": [0.1, 0.2, 0.3]}, None),
    ],
)
def test_input_that_cannot_be_used(options, told):
    if told is None:
        with pytest.raises(InputError, match="must be a number or of the shape"):
            membrane(ConeModel(prestretch=[1.0, 1.1]), **options)
        return
    with pytest.raises(InputError, match=told):
        membrane(ConeModel(), **options)


def test_a_prestretch_beyond_the_limit_is_refused():
    with pytest.raises(InputError, match="the pre-stretch alone"):
        membrane(ConeModel(stretch_limit=0.3, **EQUIBIAXIAL), displacements=0.5)


def test_a_mesh_table_needs_a_film_in_tension():
    with pytest.raises(InputError, match="choose one at which the film is in tension"):
        mesh_convergence(ConeModel(), displacement=1.0, voltage=1.0)
    with pytest.raises(InputError, match="each a multiple of the one before"):
        mesh_convergence(ConeModel(), elements=[4, 6])
