"""The cone model beside the continuum: forces, stretch limits and what the mesh leaves."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

pytest.importorskip("skfem")

import gelcone
from gelcone.continuum import compare as module
from gelcone.continuum.compare import (
    LIMIT_SHARES,
    MESHES,
    compare,
    limit_displacements,
    mesh_convergence,
    with_mesh_table,
)
from gelcone.continuum.membrane import membrane
from gelcone.continuum.mesh import mesh_film
from gelcone.continuum.path import Ending
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from tests.continuum.films import EQUIBIAXIAL, NEO_HOOKEAN, alone


@pytest.mark.parametrize("prestretch", [{}, EQUIBIAXIAL])
@pytest.mark.parametrize("v", [0.0, 0.4])
def test_the_mesh_converges_as_quadratic_elements_promise(prestretch, v):
    table = mesh_convergence(ConeModel(**prestretch), 0.2, displacement=1.0, voltage=v)
    np.testing.assert_allclose(table["force_order"][1:], 4.0, atol=0.1)
    np.testing.assert_allclose(table["shape_order"][1:], 3.0, atol=0.1)
    assert float(table["force_error"][-1]) < 1e-8


def test_meshes_of_other_ratios_have_the_same_orders_and_errors_against_one_four_times_as_fine():
    model, ratio, elements = ConeModel(prestretch=1.1), 0.3, [4, 8, 24]
    table = mesh_convergence(model, ratio, displacement=0.8, voltage=0.3, elements=elements)
    np.testing.assert_allclose(table["force_order"], [np.nan, 4.0, 4.0], atol=0.1)
    np.testing.assert_allclose(table["shape_order"], [np.nan, 3.0, 3.0], atol=0.1)
    force = [
        membrane(model, ratio, displacements=0.8, voltages=0.3, elements=n).force.item() for n in (*elements, 4 * 24)
    ]
    np.testing.assert_allclose(table["force"], force[:-1], rtol=1e-12)
    np.testing.assert_allclose(table["force_error"], np.abs(np.array(force[:-1]) - force[-1]), rtol=1e-5)


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


def test_results_save_and_load(tmp_path):
    from gelcone.dataset import load, save

    result = compare(ConeModel(), 0.2, displacements=[0.5, 1.0], voltages=[0.0, 1.0], elements=20)
    save(result, tmp_path / "compared.nc")
    assert load(tmp_path / "compared.nc").identical(result)


def test_a_mesh_table_needs_a_film_in_tension():
    with pytest.raises(InputError, match="choose one at which the film is in tension"):
        mesh_convergence(ConeModel(), displacement=1.0, voltage=1.0)
    with pytest.raises(InputError, match="each a multiple of the one before"):
        mesh_convergence(ConeModel(), elements=[4, 6])


def test_the_deviation_is_that_of_films_in_tension_alone():
    """At x = 2 and v = 0.5 the film has pulled in: thin and bulged, it says nothing about the cone."""
    found = compare(ConeModel(), 0.2, displacements=[0.5, 2.0], voltages=[0.0, 0.5], elements=60).squeeze()
    pulled = found["folds"] > 0
    assert pulled.values.tolist() == [[False, False], [False, True]]
    assert np.isfinite(found["continuum_force"].values[1, 1])
    compressed = found["ending"] != Ending.CONVERGED
    assert (np.isnan(found["deviation"]) == (pulled | compressed)).all()
    assert np.isfinite(found["deviation"].values[0]).all()


def test_a_lowered_disc_deviates_like_a_raised_one():
    found = compare(ConeModel(), 0.2, displacements=[-1.0, 1.0], elements=20).squeeze()
    assert float(found["deviation"][0]) == pytest.approx(float(found["deviation"][1]), rel=1e-9)
    assert float(found["cone_force"][0]) < 0.0


def test_the_cone_has_its_share_of_the_stretch_limit_and_its_stretch():
    model = ConeModel(stretch_limit=[10.0, 40.0], meridional_prestretch=1.1, hoop_prestretch=1.0)
    x = np.array([0.5, 1.0])
    found = compare(model, 0.2, displacements=x, voltages=[0.0, 0.2], elements=10)
    q = 1.0 + x**2
    strain = 1.21 * q + 1.0 + 1.0 / (1.21 * q) - 3.0
    for i, limit in enumerate((10.0, 40.0)):
        for k in (0, 1):
            np.testing.assert_allclose(found["cone_limit_share"][i, k], strain / limit)
        np.testing.assert_allclose(found["cone_stretch"][i], 1.1 * np.sqrt(q))
        for share, place in zip(LIMIT_SHARES, found["cone_limit_displacement"].values[i], strict=True):
            q_there = 1.0 + place**2
            assert 1.21 * q_there + 1.0 + 1.0 / (1.21 * q_there) - 3.0 == pytest.approx(share * limit)
    assert found["share"].values.tolist() == list(LIMIT_SHARES) == [0.1, 0.5, 0.9]


def test_a_law_without_limit_has_no_limit_displacement():
    found = compare(NEO_HOOKEAN, 0.2, displacements=0.5, elements=10)
    for name in ("limit_displacement", "cone_limit_displacement"):
        assert np.isnan(found[name]).all()
    assert (found["cone_limit_share"] == 0.0).all()


def test_a_mesh_table_is_taken_where_the_film_is_in_tension():
    model = ConeModel(prestretch=[1.0, 1.2])
    found = compare(model, 0.2, displacements=[0.05, 0.5, 0.9], voltages=[0.0, 1.0], elements=10)
    table = with_mesh_table(found, 0.2)
    assert table["mesh_elements"].values.tolist() == list(MESHES)
    assert table["mesh_voltage"].values.tolist() == [0.0, 0.0]
    assert table["mesh_displacement"].values.tolist() == [0.5, 0.9]
    own = mesh_convergence(ConeModel(), 0.2, displacement=0.5)
    for name in ("force", "force_error", "force_order", "shape_error", "shape_order"):
        np.testing.assert_array_equal(table[f"mesh_{name}"][0], own[name])
    nowhere = compare(ConeModel(), 0.2, displacements=[0.5], voltages=[1.0], elements=10)
    lost = with_mesh_table(nowhere)
    assert np.isnan(lost["mesh_force"]).all()
    assert np.isnan(lost["mesh_displacement"])


def test_the_pull_in_voltage_is_unknown_where_no_voltage_was_that_high():
    model, ratio = ConeModel(meridional_prestretch=1.1, hoop_prestretch=1.4), 8.0 / 30.0
    found = compare(model, ratio, displacements=[0.5, 0.8], voltages=[0.0, 0.1], wrinkles="relax", elements=12)
    assert np.isnan(found["pull_in_film_voltage"]).all()
    assert np.isfinite(found["cone_pull_in_film_voltage"]).all()
    held = gelcone.film(model.replace(film="membrane", radius_ratio=ratio), [0.5, 0.8], [0.0, 0.1])
    np.testing.assert_allclose(found["membrane_pull_in_film_voltage"], held["pull_in_film_voltage"][:, 0], rtol=1e-9)
    share = found["membrane_force"] / found["continuum_force"] - 1.0
    np.testing.assert_allclose(found["membrane_deviation"], share, rtol=1e-9)
    assert np.abs(share).max() < 0.02


def made_up(monkeypatch, model=None, **changes):
    """`compare` on results that no continuum gave: two voltages and two displacements, forces of 2."""
    at = ("constant_voltage", "displacement")
    values = {
        "force": np.full((2, 2), 2.0), "ending": np.full((2, 2), Ending.CONVERGED), "folds": np.zeros((2, 2), int),
        "reached_voltage": np.full((2, 2), 0.5),
    } | changes  # fmt: skip
    coords = {"constant_voltage": [0.1, 0.6], "displacement": [0.3, 0.5]}
    result = xr.Dataset({name: (at, value) for name, value in values.items()}, coords=coords)
    monkeypatch.setattr(module, "membrane", lambda *_, **__: result)
    monkeypatch.setattr(module, "limit_displacements", lambda film: np.full(len(module.LIMIT_SHARES), np.nan))
    given = {"displacements": [0.3, 0.5], "voltages": [0.1, 0.6], "wrinkles": "relax", "elements": 4}
    return module.compare(model or ConeModel(), 0.2, **given)


def test_the_continuum_has_pulled_in_above_the_lowest_of_its_voltages(monkeypatch):
    ending = np.array([[Ending.PULLED_IN, Ending.CONVERGED], [Ending.PULLED_IN, Ending.SLACK]])
    reached = np.array([[0.42, 0.1], [0.45, 0.2]])
    found = made_up(monkeypatch, ending=ending, reached_voltage=reached)
    np.testing.assert_array_equal(found["pull_in_film_voltage"].values.squeeze(), [0.42, np.nan])


def test_the_cone_is_compared_where_the_continuum_pulls_back_without_folds(monkeypatch):
    folds, ending = np.array([[0, 1], [0, 0]]), np.array([[Ending.CONVERGED] * 2, [Ending.SLACK, Ending.CONVERGED]])
    force = np.array([[2.0, 2.0], [2.0, -2.0]])
    found = made_up(monkeypatch, folds=folds, ending=ending, force=force)
    deviation = found["deviation"].values.squeeze()
    np.testing.assert_array_equal(np.isfinite(deviation), [[True, False], [False, False]])
    assert deviation[0, 0] == pytest.approx(found["cone_force"].values.squeeze()[0, 0] / 2.0 - 1.0)
    assert found["membrane_deviation"].values.squeeze()[0, 0] == pytest.approx(
        found["membrane_force"].values.squeeze()[0, 0] / 2.0 - 1.0
    )


def test_a_mesh_table_is_taken_in_the_middle_of_those_in_tension_at_the_lowest_voltage(monkeypatch):
    asked = []
    blank = {name: np.zeros(len(module.MESHES)) for name in module.MESH_VARIABLES}

    def table(model, ratio, *, displacement, voltage):
        asked.append((displacement, voltage))
        return xr.Dataset({name: ("elements", values) for name, values in blank.items()})

    ending = np.array(
        [[Ending.SLACK, Ending.SLACK, Ending.SLACK], [Ending.CONVERGED] * 3, [Ending.CONVERGED] + [Ending.SLACK] * 2]
    )
    at, coords = (
        ("constant_voltage", "displacement"),
        {"constant_voltage": [0.1, 0.3, 0.6], "displacement": [0.3, -0.5, 0.7]},
    )
    force = np.tile([2.0, -2.0, 2.0], (3, 1))
    values = {"force": force, "ending": ending, "folds": 0 * ending, "reached_voltage": 0.0 * force}
    result = xr.Dataset({name: (at, value) for name, value in values.items()}, coords=coords)
    monkeypatch.setattr(module, "membrane", lambda *_, **__: result)
    monkeypatch.setattr(module, "limit_displacements", lambda film: np.full(len(module.LIMIT_SHARES), np.nan))
    monkeypatch.setattr(module, "mesh_convergence", table)
    found = module.validate(ConeModel(), [0.3, -0.5, 0.7], [0.1, 0.3, 0.6], wrinkles="relax")
    assert asked == [(0.5, 0.3)]
    assert float(found["mesh_displacement"].squeeze()) == -0.5
    assert float(found["mesh_voltage"].squeeze()) == 0.3


def test_the_continuum_reaches_its_limit_on_the_mesh_that_was_asked_for():
    coarse = limit_displacements(mesh_film(ConeModel(), 0.2, 4))
    assert (np.abs(limit_displacements(mesh_film(ConeModel(), 0.2, 40)) / coarse - 1.0) > 1e-6).all()
    given = {"displacements": [0.3], "elements": 4}
    np.testing.assert_array_equal(compare(ConeModel(), 0.2, **given)["limit_displacement"].squeeze(), coarse)


def test_the_distance_of_shapes_is_that_by_which_one_is_moved():
    """As a whole by (0.03, 0.04), and linearly, whose root mean square is the largest over sqrt(3)."""
    film, fine = mesh_film(ConeModel(), 0.2, 4), mesh_film(ConeModel(), 0.2, 16)
    flat = SimpleNamespace(position=np.zeros(film.size))
    moved = SimpleNamespace(position=np.tile([0.03, 0.04], fine.place.size))
    assert module._distance(film, flat, fine, moved) == pytest.approx(0.05)
    finest = mesh_film(ConeModel(), 0.2, 400)
    tilted = np.stack([0.3 * finest.place, 0.0 * finest.place], axis=1).ravel()
    found = module._distance(film, flat, finest, SimpleNamespace(position=tilted))
    assert found == pytest.approx(0.3 / np.sqrt(3.0), rel=1e-4)


def test_pull_in_of_cone_and_membrane_is_that_of_the_films_themselves(monkeypatch):
    """Their localisation counts, unlike in the force of the cone, which is that of states beyond, too."""
    model = ConeModel(prestretch=1.5, prestretch_mode="equibiaxial")
    found = made_up(monkeypatch, model)
    x = np.array([0.3, 0.5])
    for name, film in (("cone", "wrinkling"), ("membrane", "membrane")):
        own = model.replace(film=film, **({"radius_ratio": 0.2} if film == "membrane" else {}))
        right = np.sqrt(own.film.highest_squared(x, own.numbers()))
        np.testing.assert_allclose(found[f"{name}_pull_in_film_voltage"].values.squeeze(), right, rtol=1e-12)
    own = alone(model.replace(film="membrane", radius_ratio=0.2))
    np.testing.assert_allclose(
        found["membrane_force"].values.squeeze(), [own.force(x, v) for v in (0.1, 0.6)], rtol=1e-12
    )
    held = alone(model.replace(film="wrinkling", pull_in="minimum"))
    assert (
        held.film.highest_squared(x, held.numbers()) > 1.01 * found["cone_pull_in_film_voltage"].values.squeeze() ** 2
    ).all()
    np.testing.assert_allclose(found["cone_force"].values.squeeze(), [held.force(x, v) for v in (0.1, 0.6)], rtol=1e-12)


@pytest.mark.parametrize("device", ["weight-cone", "beam-cone"])
def test_the_biases_of_a_device_have_no_part_in_the_comparison_of_films(device):
    model = gelcone.find_device(device).to_model()
    bare = model.replace(bias="spring", spring_stiffness=0.0)
    options = {"voltages": [0.0, 0.3], "wrinkles": "relax", "elements": 20}
    own, other = (gelcone.validate(of, [0.3, 0.8], **options) for of in (model, bare))
    for name in ("cone_force", "deviation", "membrane_force", "membrane_deviation", "continuum_force"):
        np.testing.assert_array_equal(own[name], other[name], err_msg=name)
    assert np.nanmax(np.abs(own["membrane_deviation"])) < 0.05
