"""The film as a continuum: against exact states, an independent shooting solution, and the cone it should become."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

pytest.importorskip("skfem")

from gelcone.codes import Outcome
from gelcone.continuum import membrane as module
from gelcone.continuum.membrane import State, highest_span, membrane
from gelcone.continuum.mesh import derivatives, mesh_film
from gelcone.continuum.path import Ending, cone, newton, reach
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from tests.continuum.films import EQUIBIAXIAL, NEO_HOOKEAN, alone


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


def shot(model, ratio, x, v):
    """The force on the disc by shooting: the equilibrium of rings as an initial-value problem, integrated from the disc
    outwards; unknown are the vertical and the radial force on it."""
    film, squared = mesh_film(model, ratio, 4), v * v
    disc, span = film.disc, (film.disc, film.disc + 1.0)

    def along(n, pull):
        """The stretch along the meridian that carries the nominal pull."""
        lm, lh = model.stretches
        highest = min(0.999 * np.sqrt((model.strain_limit() + 3.0 - lh * lh * n) / (lm * lm)), 20.0)
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


def test_lowering_the_disc_finds_the_same_pulled_in_film_as_the_arc():
    single = membrane(ConeModel(), 0.2, displacements=1.9, voltages=0.6, elements=60)
    beside = membrane(ConeModel(), 0.2, displacements=[1.9, 2.0, 2.1], voltages=0.6, elements=60)
    assert single.force.item() == pytest.approx(beside.force[0, 0].item(), rel=1e-9)
    assert (beside["folds"] == 2).all()
    assert (beside["radius"].diff("ring") < 0.0).any("ring").all()  # a vertical line meets the film twice
    assert beside["overhangs"].all()


@pytest.mark.parametrize("v", [0.3, 0.6])
def test_a_curve_holds_the_points_that_single_runs_find(v):
    x = np.array([0.4, 0.8, 1.2, 1.6])
    curve = membrane(ConeModel(), 0.2, displacements=x, voltages=v, elements=60).squeeze()
    for k, place in enumerate(x):
        point = membrane(ConeModel(), 0.2, displacements=place, voltages=v, elements=60)
        assert point.ending.item() == curve["ending"][k]
        np.testing.assert_allclose(point.force.item(), curve["force"][k], rtol=1e-9)
    back = (curve["radius"].diff("ring") < 0.0).any("ring")
    np.testing.assert_array_equal(curve["overhangs"], back)


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


def test_radius_ratios_make_an_ensemble_equal_to_single_runs():
    together = membrane(ConeModel(), [0.2, 0.5], displacements=[0.5, 1.0], elements=20)
    for i, ratio in enumerate((0.2, 0.5)):
        apart = membrane(ConeModel(), ratio, displacements=[0.5, 1.0], elements=20)
        np.testing.assert_array_equal(together["force"][i], apart["force"])
    np.testing.assert_array_equal(together["radius_ratio"], [0.2, 0.5])


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
        ({"displacements": 1.0, "voltages": [0.2, 0.2]}, "voltages = .* each given once"),
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
    two = ConeModel(stretch_limit=0.3, meridional_prestretch=[1.4, 1.3], hoop_prestretch=[1.4, 1.3])
    least = 2.0 * 1.3**2 + 1.3**-4 - 3.0  # I1 - 3 of the film that is stretched less
    with pytest.raises(InputError, match=f"I1 - 3 = {least:.4g}, which must be less"):
        membrane(two, displacements=0.5)


@pytest.mark.parametrize(
    ("parameters", "x", "v"), [({}, 1.0, 0.0), (EQUIBIAXIAL, 0.7, 0.4), ({"law": "neo-hookean"}, 1.5, 0.2)]
)
def test_the_estimated_error_of_the_mesh_is_that_against_a_fine_one(parameters, x, v):
    model = ConeModel(**parameters)
    coarse, fine = (membrane(model, 0.2, displacements=x, voltages=v, elements=n) for n in (8, 128))
    true = abs(coarse["force"].item() - fine["force"].item())
    assert true > 1e-10
    assert 0.4 * true < coarse["force_error"].item() < 2.5 * true


def test_a_member_that_cannot_be_reached_is_outside_and_the_other_is_not():
    model = ConeModel(stretch_limit=[2.0, 50.0])
    found = membrane(model, 0.2, displacements=[3.0, 4.0], elements=20)
    assert found["outcome"].values.tolist() == [Outcome.OUTSIDE, Outcome.OK]
    assert (found["ending"][0] == Ending.BEYOND_LIMIT).all()
    assert np.isnan(found["force"][0]).all()
    assert np.isfinite(found["force"][1]).all()
    assert found["limit_share"].values[1].max() < 1.0


def test_progress_adds_up_to_one():
    told = []
    membrane(ConeModel(), [0.2, 0.5], displacements=[0.5, 1.0], voltages=[0.0, 0.2], elements=10, progress=told.append)
    assert sum(told) == pytest.approx(1.0)


def test_stresses_and_stretches_follow_from_the_shape():
    """At the disc the hoop keeps its mounted length; the largest share of the limit lies where it is said to."""
    found = membrane(ConeModel(**EQUIBIAXIAL), 0.2, displacements=1.0, voltages=0.2, elements=40).squeeze()
    np.testing.assert_allclose(found["hoop_stretch"], 1.2 * found["radius"] / found["mounted_radius"], rtol=1e-9)
    l1, l2 = found["meridional_stretch"], found["hoop_stretch"]
    strain = l1**2 + l2**2 + (l1 * l2) ** -2 - 3.0
    place = int(np.argmax(strain.values))
    assert float(found["limit_share"]) == pytest.approx(float(strain[place]) / 50.0, rel=1e-9)
    assert float(found["limit_radius"]) == float(found["mounted_radius"][place])
    response = 1.0 / (1.0 - strain / 50.0)
    # the true field squared is v^2 over the deformed thickness squared, from the mounted one on: v^2 (l1 l2/1.44)^2
    field = 0.04 * (l1 * l2 / 1.44) ** 2
    np.testing.assert_allclose(found["meridional_stress"], response * (l1**2 - (l1 * l2) ** -2) - field, rtol=1e-9)
    np.testing.assert_allclose(found["hoop_stress"], response * (l2**2 - (l1 * l2) ** -2) - field, rtol=1e-9)


@pytest.mark.parametrize("wrinkles", ["mark", "relax"])
def test_stretches_count_from_the_gel_at_rest_with_unequal_prestretches(wrinkles):
    """Flat they are the pre-stretches where these are equal; the hoop's is lh r/R wherever a ring has gone, and the
    meridian's lm times how much longer it has become."""
    lm, lh = 1.15, 1.3
    model = ConeModel(meridional_prestretch=lm, hoop_prestretch=lh)
    found = membrane(model, 0.2, displacements=[0.0, 0.8, -0.8], voltages=0.2, wrinkles=wrinkles, elements=16).squeeze()
    assert (found["ending"] == Ending.CONVERGED).all()
    np.testing.assert_allclose(found["hoop_stretch"], lh * found["radius"] / found["mounted_radius"], rtol=1e-12)
    radius, height, mounted = (found[name].values for name in ("radius", "height", "mounted_radius"))
    length = np.hypot(np.diff(radius, axis=-1), np.diff(height, axis=-1)).sum(axis=-1)
    along = found["meridional_stretch"].values
    mean = (0.5 * (along[:, 1:] + along[:, :-1]) * np.diff(mounted)).sum(axis=-1)
    np.testing.assert_allclose(mean, lm * length, rtol=3e-3)


@pytest.mark.parametrize(("error", "ending"), [(9e-4, Ending.CONVERGED), (1.2e-3, Ending.UNRESOLVED)])
def test_a_force_that_the_mesh_does_not_resolve_to_a_thousandth_is_not_reported(monkeypatch, error, ending):
    monkeypatch.setattr("gelcone.continuum.membrane.force_error", lambda film, point, coarse: error * abs(point.force))
    found = membrane(ConeModel(), 0.2, displacements=0.8, voltages=0.0, elements=8).squeeze()
    assert found["ending"] == ending
    assert bool(np.isfinite(found["force"])) == (ending == Ending.CONVERGED)


def test_the_highest_span_is_that_of_a_ring_that_contracts_freely():
    """Stretched twice, a free strip has I1 - 3 = 4 + 2/2 - 3: with that limit no film is longer."""
    film = mesh_film(ConeModel(stretch_limit=2.0, meridional_prestretch=1.25), 0.2, 4)
    assert highest_span(film) == pytest.approx(np.sqrt(4.0 / 1.25**2 - 1.0), rel=1e-12)


# --- the search, on made-up paths -------------------------------------------------------------------------------------


def made(height=0.5, squared=0.2, stable=True, tense=True, most=-0.1):
    """A point that no film has; without tension it ``slackens``."""
    return SimpleNamespace(
        height=height, squared=squared, stable=stable, tense=tense, forces=SimpleNamespace(most=most, least=most - 1.0)
    )


@pytest.fixture
def paths(monkeypatch):
    """The search along arcs that a test gives, where a load is reached unless the test says how far."""
    given = SimpleNamespace(arcs=[], most={}, asked=[], ends=None)

    def arcs(film, start):
        return iter([SimpleNamespace(point=p, folds=folds, squared=p.squared) for p, folds in given.arcs])

    def to(film, start, load, value):
        given.asked.append((start, load, value))
        changed = SimpleNamespace(**(vars(start) | {load: value}))
        lost = load in given.most and value > given.most[load]
        return (None if lost else changed), start

    def raised_in_voltage(film, start, square, step):
        given.asked.append((start, square, step))
        ending, end = given.ends if given.ends and given.ends[1] < square else (Ending.CONVERGED, square)
        return SimpleNamespace(points=[start, made(start.height, min(square, end))], ending=ending, end=end)

    for name, value in {
        "arc": arcs, "reach": to, "slackens": lambda point: not point.tense, "charged": raised_in_voltage,
        "slack_limit": lambda model: 0.4,
    }.items():  # fmt: skip
        monkeypatch.setattr(module, name, value)
    return given


FILM = SimpleNamespace(relaxed=False, model=None)


@pytest.mark.parametrize(
    ("arcs", "ending", "reached"),
    [
        ([(made(squared=0.30), 0), (made(squared=0.36), 0), (made(squared=0.31), 1)], Ending.PULLED_IN, 0.36),
        ([(made(squared=0.30), 0), (made(squared=0.33, tense=False), 0)], Ending.TENSION_LOST, 0.33),
        ([(made(squared=0.25), 0), (made(squared=0.24), 0)], Ending.NOT_CONVERGED, 0.25),
        ([(made(squared=0.2 + 0.01 * k), int(k == 12)) for k in range(13)], Ending.NOT_CONVERGED, 0.31),
        ([(made(squared=0.2 + 0.01 * k), int(k == 11)) for k in range(13)], Ending.PULLED_IN, 0.31),
        ([], Ending.NOT_CONVERGED, 0.2),
    ],
)
def test_a_voltage_that_cannot_be_raised_ends_as_the_arc_behind_it_says(paths, arcs, ending, reached):
    """Within twelve steps; the voltage that was reached is the highest on the way."""
    paths.arcs, last = arcs, made()
    found = module._ended(FILM, last)
    assert (found.ending, found.folds, found.point) == (ending, 0, last)
    assert found.reached == pytest.approx(reached)


def test_behind_a_fold_the_first_stable_point_that_rises_through_the_voltage_counts(paths):
    start = made(squared=0.2)
    turn = [(made(squared=0.5), 0), (made(squared=0.1, stable=False), 1)]
    paths.arcs = [*turn, (made(squared=0.35, stable=False), 1), (made(squared=0.25), 2), (made(squared=0.4), 2)]
    found = module._along_arc(FILM, made(squared=0.45), 0.3)
    assert (found.squared, found.stable) == (0.3, True)
    assert [(asked[0].squared, *asked[1:]) for asked in paths.asked] == [(0.25, "squared", 0.3)]
    paths.arcs = [*turn, (made(squared=0.2, tense=False), 2), (made(squared=0.4), 2)]
    assert module._along_arc(FILM, made(squared=0.45), 0.3) is None
    paths.arcs = [*turn, (made(squared=0.2, stable=False), 1), (made(squared=0.4), 2)]
    paths.asked.clear()
    assert module._along_arc(FILM, made(squared=0.45), 0.3).squared == 0.3
    assert [asked[0].squared for asked in paths.asked] == [0.4]  # not from the one before, which is unstable
    paths.arcs = [(made(squared=0.35, stable=False), 1), (made(squared=0.1, stable=False), 1), (made(squared=0.4), 2)]
    paths.asked.clear()
    assert module._along_arc(FILM, start, 0.3).squared == 0.3
    assert [asked[0].squared for asked in paths.asked] == [0.4]  # not past an unstable point, although it began stable
    paths.arcs = [(made(squared=0.3), 0)]
    assert module._along_arc(FILM, start, 0.3).squared == 0.3


def test_films_that_pulled_in_are_found_from_the_highest_disc_down(paths):
    """By lowering the disc from the one above, else along the arc; below the first that is lost none is sought."""
    lost = State(made(0.9, 0.2), Ending.PULLED_IN, 0, 0.25)
    states = {
        0.9: lost,
        0.6: State(made(0.6), Ending.NOT_CONVERGED, 0, 0.2),
        0.3: State(made(0.3), Ending.SLACK, 0, 0.1),
    }
    states[1.2] = State(made(1.2, 0.3), Ending.CONVERGED, 0, 0.3)
    found = module._pulled_in(FILM, states, 0.3)
    assert {h: (s.point.height, s.ending, s.folds, s.reached) for h, s in found.items()} == {
        0.9: (0.9, Ending.CONVERGED, 2, 0.3),
        0.6: (0.6, Ending.CONVERGED, 2, 0.3),
    }
    assert [(asked[0].height, *asked[1:]) for asked in paths.asked] == [(1.2, "height", 0.9), (0.9, "height", 0.6)]
    del states[1.2]
    assert module._pulled_in(FILM, states, 0.3) == {}
    paths.arcs = [(made(0.9, 0.1), 2), (made(0.9, 0.4), 2)]
    assert sorted(module._pulled_in(FILM, states, 0.3)) == [0.6, 0.9]


def test_a_compressed_film_is_raised_as_far_as_all_of_it_stays_compressed(paths, monkeypatch):
    monkeypatch.setattr(module, "flat", lambda film, square: made(0.0, square))
    monkeypatch.setattr(module, "cone", lambda film, height, below=None: height)
    monkeypatch.setattr(module, "newton", lambda film, guess, square, within=np.inf: made(guess, square))
    states = {h: State(made(h), Ending.TENSION_LOST, 0, 0.1) for h in (0.2, 0.4)}
    states |= {0.3: State(made(0.3), Ending.CONVERGED, 0, 0.1), 0.6: State(made(0.6), Ending.PULLED_IN, 0, 0.1)}
    found = module._compressed(FILM, states, 0.3)
    assert {h: (s.point.height, s.ending, s.folds, s.reached) for h, s in found.items()} == {
        h: (h, Ending.COMPRESSED, 0, 0.3) for h in (0.2, 0.4, 0.6)
    }
    paths.most = {"height": 0.5}
    assert sorted(module._compressed(FILM, states, 0.3)) == [0.2, 0.4]
    for where in ("flat", "newton"):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, where, lambda film, *_: made(0.1, 0.3, most=0.1))
            assert module._compressed(FILM, states, 0.3) == {}


def test_a_film_that_wrinkles_ends_once_and_a_slack_one_pulls_in_at_the_voltage_of_a_free_film(paths):
    start, squares = made(0.5, 0.0), [0.0, 0.1, 0.25, 0.35, 0.45]
    assert [s.ending for s in module._relaxed_states(FILM, start, squares)] == [Ending.CONVERGED] * 5
    assert [asked[1:] for asked in paths.asked] == [
        (0.0, 0.0), (0.1, 0.1), (0.25, pytest.approx(0.15)), (0.35, pytest.approx(0.1)), (0.45, pytest.approx(0.1))
    ]  # fmt: skip
    paths.ends = (Ending.SLACK, 0.3)
    found = module._relaxed_states(FILM, start, squares)
    assert [s.ending for s in found] == [*[Ending.CONVERGED] * 3, Ending.SLACK, Ending.PULLED_IN]
    assert [s.reached for s in found] == [0.0, 0.1, 0.25, 0.3, 0.4]
    paths.ends = (Ending.PULLED_IN, 0.2)
    found = module._relaxed_states(FILM, start, squares)
    assert [s.ending for s in found] == [Ending.CONVERGED] * 2 + [Ending.PULLED_IN] * 3
    assert [s.reached for s in found] == [0.0, 0.1, 0.2, 0.2, 0.2]


def test_a_voltage_is_reached_from_a_lower_disc_sooner_and_else_from_a_lower_voltage(paths):
    start, below = made(0.5, 0.1), State(made(0.4, 0.3), Ending.CONVERGED, 0, 0.3)
    found = module._charged_to(FILM, start, 0.3, below)
    assert (found.point.height, found.point.squared, found.ending, found.reached) == (0.5, 0.3, Ending.CONVERGED, 0.3)
    assert [asked[1:] for asked in paths.asked] == [("height", 0.5)]
    for lower in (None, State(made(0.0, 0.3), Ending.CONVERGED, 0, 0.3), State(made(0.4), Ending.PULLED_IN, 0, 0.3)):
        paths.asked.clear()
        assert module._charged_to(FILM, start, 0.3, lower).ending == Ending.CONVERGED
        assert [asked[1:] for asked in paths.asked] == [("squared", 0.3)]
    paths.most = {"squared": 0.2, "height": 0.45}
    assert module._charged_to(FILM, start, 0.3, below).ending == Ending.NOT_CONVERGED
