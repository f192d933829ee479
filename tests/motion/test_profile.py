"""The membrane from disc to rim: one truth with the film that runs, cells, and what cannot be held."""

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel
from gelcone.errors import InputError
from gelcone.motion.profile import Held
from gelcone.physics.film.membrane import KINDS

MODEL = ConeModel(
    film="membrane",
    radius_ratio=0.2,
    stretch_limit=50.0,
    dielectric_strength=1.0,
    rest_height=0.8,
    spring_stiffness=0.5,
    voltage=0.5,
)
HEIGHTS, VOLTAGES = [-0.5, 0.0, 0.2, 0.5, 0.75, 3.0, 9.0], [0.0, 0.5, 0.6, 0.65, 0.9]


@pytest.fixture(scope="module")
def cells():
    return gelcone.film(MODEL, HEIGHTS, VOLTAGES)


def test_force_and_capacitance_are_those_of_certified_states(cells):
    one = cells.sel(height=0.75, constant_voltage=0.5)
    assert float(one["force"]) == pytest.approx(0.213183373611006, rel=1e-4)
    assert float(one["capacitance"]) == pytest.approx(1.5744649783967708, rel=2e-5)
    assert float(one["charge"]) == pytest.approx(0.5 * 1.5744649783967708, rel=2e-5)


def test_force_and_charge_are_those_of_the_film_that_runs_within_its_stated_error(cells):
    n = MODEL.members().numbers_at(0)
    x, v = (np.broadcast_to(cells[name], (7, 5)) if name != "height" else cells["height"].values[:, None] + np.zeros(5)
            for name in ("height", "constant_voltage"))  # fmt: skip
    own, without = MODEL.film.force(x, v**2, [], n)[0], MODEL.film.force(x, 0.0 * v, [], n)[0]
    area = MODEL.film.capacitance(x, v**2, [], n)
    held = cells["held"].values == Held.HELD
    assert held.sum() == 10
    error, error_area = (
        np.abs(cells[name].values - other)[held] for name, other in (("force", own), ("capacitance", area))
    )
    assert np.all(error <= n["film_error"] * (np.abs(own) + 0.1 * np.abs(without))[held] + 1e-12)
    assert np.all(error_area < n["film_error"] * area[held])
    slack = cells["held"].values == Held.SLACK
    np.testing.assert_array_equal(cells["capacitance"].values[slack], area[slack])
    assert not cells["force"].values[slack].any()


def test_each_height_and_voltage_says_whether_and_why_not_it_is_held(cells):
    H, S, L, M, J = (Held[name] for name in ("HELD", "SLACK", "LOCALISED", "MINIMUM", "STRETCH_LIMIT"))
    assert cells["held"].values.tolist() == [
        [H, H, H, S, M], [S, S, S, S, M], [H, S, S, S, M], [H, H, H, S, M], [H, H, L, L, L], [H, L, L, L, L],
        [J, J, J, J, J],
    ]  # fmt: skip
    assert cells["held"].attrs["flag_meanings"].split()[:3] == ["held", "slack", "localised"]
    assert all(one.meaning for one in Held)
    assert np.isnan(cells["ring_radius"].values[cells["held"].values != Held.HELD]).all()
    wrinkled = cells["wrinkled_share"].sel(height=0.75).values
    assert wrinkled[0] == 0.0
    assert 0.4 < wrinkled[1] < 0.6
    assert KINDS[int(cells["film_state"].sel(height=0.75, constant_voltage=0.5))] == "partly_wrinkled"


def test_a_depressed_disc_is_the_mirror_image(cells):
    below, above = (cells.sel(height=x, constant_voltage=0.6) for x in (-0.5, 0.5))
    for name in ("ring_height", "force"):
        np.testing.assert_allclose(below[name], -above[name], rtol=1e-9)
    for name in ("ring_radius", "true_field", "firmness", "capacitance"):
        np.testing.assert_allclose(below[name], above[name], rtol=1e-9)


def test_what_is_largest_is_that_of_the_rings(cells):
    one = cells.sel(height=0.75, constant_voltage=0.5)
    assert float(one["largest_field"]) == float(one["true_field"].max()) == float(one["breakdown_share"])
    assert float(one["largest_field_radius"]) == pytest.approx(0.25)
    assert float(one["least_firmness"]) == float(one["firmness"].min())
    assert float(one["largest_limit_share"]) == float(one["limit_share"].max())
    np.testing.assert_allclose(one["thickness"] * one["meridional_stretch"] * one["hoop_stretch"], 1.0, rtol=1e-12)


def test_the_wrinkled_share_is_that_of_areas(cells):
    """Wrinkled next to the disc and next to the rim: rings of the mounted film, as rotation weighs them."""
    one = cells.sel(height=0.75, constant_voltage=0.5)
    square, slack = one["mounted_radius"].values ** 2, one["wrinkle_excess"].values > 1e-9
    first, last = np.flatnonzero(~slack)[[0, -1]]
    assert 0 < first < last < slack.size - 1
    wrinkled = square[first] - square[0] + square[-1] - square[last]
    assert float(one["wrinkled_share"]) == pytest.approx(wrinkled / (square[-1] - square[0]), abs=0.02)


def test_at_disc_and_rim_a_taut_hoop_has_its_own_prestretch():
    found = gelcone.film(gelcone.find_device("biased-pump"), ["14 mm"], ["0 V"]).isel(height=0, constant_voltage=0)
    np.testing.assert_allclose(found["hoop_stretch"][[0, -1]], 1.4, rtol=1e-9)
    assert (found["meridional_stretch"] > 1.1).all()
    volume = found["thickness"] * found["meridional_stretch"] * found["hoop_stretch"]
    np.testing.assert_allclose(volume, volume[0], rtol=1e-12)


def test_without_a_height_the_disc_rests_as_on_a_slow_ramp():
    found = gelcone.film(MODEL, voltage=[0.0, 0.3, 0.5])
    ramp = gelcone.stroke_and_blocked_force(MODEL, [0.0, 0.3, 0.5])
    np.testing.assert_array_equal(found["displacement"][0], ramp["displacement"])
    rest = found["force"][0] + 0.5 * (found["displacement"][0] - 0.8)
    assert np.abs(rest).max() < 2e-3  # film and spring balance, as well as the film that runs is known
    assert gelcone.film(MODEL)["constant_voltage"].values.tolist() == [0.5]


def test_a_voltage_at_which_the_disc_does_not_rest_says_so():
    found = gelcone.film(MODEL, voltage=2.0)
    assert found["held"].item() == Held.NO_REST
    assert np.isnan(found["displacement"].item())


def test_members_are_computed_as_alone():
    several = MODEL.replace(radius_ratio=[0.2, 0.3])
    found = gelcone.film(several, [0.3, 0.5], [0.2])
    for k in range(2):
        alone = gelcone.film(several.take([k]), [0.3, 0.5], [0.2])
        for name in ("force", "capacitance", "ring_radius", "mounted_radius", "true_field"):
            np.testing.assert_allclose(found[name][k], alone[name][0], rtol=1e-9, err_msg=name)


def test_the_second_film_of_a_double_cone_is_held_at_its_own_height():
    double = MODEL.replace(second_film="membrane", second_flat_height=1.0, second_drive="constant", second_voltage=0.3)
    found = gelcone.film(double, 0.4, 0.0)
    alone = gelcone.film(MODEL, [0.6], [0.3])
    for name in ("force", "capacitance", "ring_height", "true_field"):
        np.testing.assert_allclose(found[f"second_{name}"], alone[name], rtol=1e-9, err_msg=name)
    assert "second film" in found["second_force"].attrs["long_name"]


def test_a_device_answers_in_its_units():
    device = gelcone.find_device("paper-table1").replace(film="membrane")
    found = gelcone.film(device, "20 mm", "3 kV")
    model = gelcone.film(device.to_model(), 0.02 / 0.04, 3000.0 / device.scales.voltage)
    assert {name: found[name].units for name in ("force", "capacitance", "thickness", "true_field", "firmness")} == {
        "force": "N", "capacitance": "nF", "thickness": "mm", "true_field": "V/um", "firmness": "kPa",
    }  # fmt: skip
    # C = eps A/H of the flat film times the mean square of the deformed over the mounted area
    eps, area = device.material.relative_permittivity * 8.8541878188e-12, np.pi * (0.05**2 - 0.01**2)
    flat = eps * area / 5e-4
    assert found["capacitance"].item() * 1e-9 == pytest.approx(flat * model["capacitance"].item(), rel=1e-9)
    assert found["charge"].item() * 1e-6 == pytest.approx(found["capacitance"].item() * 1e-9 * 3000.0, rel=1e-9)
    np.testing.assert_allclose(found["thickness"], 0.5 * model["thickness"], rtol=1e-9)
    assert float(found["mounted_radius"][0]) == pytest.approx(10.0)


def test_it_is_saved_and_read_back_equal(cells, tmp_path):
    gelcone.save(cells, tmp_path / "film.nc")
    assert gelcone.load(tmp_path / "film.nc").identical(cells)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"height": float("nan")}, r"height = nan: must be one finite number or a list"),
        ({"height": "high"}, "height: must be a number"),
        ({"height": []}, r"height = \[\]: must be"),
        ({"voltage": -1.0}, "voltages = -1: must be at least 0"),
        ({"height": np.linspace(0.0, 1.0, 100), "voltage": np.linspace(0.0, 1.0, 100)}, "10000 states; take at most"),
    ],
)
def test_what_cannot_be_asked_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        gelcone.film(MODEL, **arguments)


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_cone_has_no_rings_to_show(film):
    with pytest.raises(InputError, match=f"film = {film}: does not vary from disc to rim; take film = membrane"):
        gelcone.film(ConeModel(film=film))
