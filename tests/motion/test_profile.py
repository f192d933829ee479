"""The membrane from disc to rim: one truth with the film that runs, cells, and what cannot be held."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel
from gelcone.errors import InputError
from gelcone.membrane.profile import Profile
from gelcone.motion.profile import Held
from gelcone.physics.film.membrane import KINDS
from tests.recorded import numbers, record

module = importlib.import_module("gelcone.motion.profile")
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


def test_what_a_voltage_takes_from_the_force_is_that_of_the_film_that_runs():
    """So that strokes and blocked forces of statics are those of `film`, also at small voltages."""
    device = gelcone.find_device("biased-pump")
    volts = np.array([0.0, 150.0, 300.0, 600.0, 1200.0])
    statics = gelcone.static(device, displacements=["12 mm"], voltages=volts)
    states = gelcone.film(device, ["12 mm"], volts)
    fitted, exact = (own["force"].values.ravel() for own in (statics, states))
    taken = (exact[0] - exact)[1:]
    assert np.all(taken > 0.0)
    gain_error = device.to_model().own_numbers["gain_error"]
    assert np.all(np.abs((fitted[0] - fitted)[1:] / taken - 1.0) < min(gain_error, 0.03))


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
    for name in ("ring_radius", "true_field", "tangent_stiffness", "capacitance"):
        np.testing.assert_allclose(below[name], above[name], rtol=1e-9)


def test_what_is_largest_is_that_of_the_rings(cells):
    one = cells.sel(height=0.75, constant_voltage=0.5)
    assert float(one["largest_field"]) == float(one["true_field"].max()) == float(one["breakdown_share"])
    assert float(one["largest_field_radius"]) == pytest.approx(0.25)
    assert float(one["least_tangent_stiffness"]) == float(one["tangent_stiffness"].min())
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
    assert {name: found[name].units for name in ("force", "capacitance", "thickness", "true_field",
    "tangent_stiffness")} == {
        "force": "N", "capacitance": "nF", "thickness": "mm", "true_field": "MV/m", "tangent_stiffness": "kPa",
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


# --- what is handed on ------------------------------------------------------------------------------------------------


def rings(count, points=4, at=0.0):
    """Made-up rings of some states: all numbers different, and the second ring of each without a hoop in wrinkles."""
    radius = np.array([1.0, 2.0, 3.0, 5.0])[:points]
    fields = {name: numbers(count, points, at=at + k) for k, name in enumerate(Profile._fields[1:])}
    fields["span"] = fields["width"] * (1.0 - 0.25 * (np.arange(points) != 1))
    return Profile(radius, **fields)


def test_each_variable_is_that_of_its_own_state_and_ring(monkeypatch):
    """Of two members of another strength, two heights (below the rim and above) and two voltages of the command."""
    members = MODEL.replace(radius_ratio=[0.2, 0.3], dielectric_strength=[2.0, 4.0]).members()
    (placed,) = members.system.films
    x, levels, made = np.broadcast_to([[-0.25], [0.5]], (2, 2, 2)), np.array([0.25, 0.75]), []
    squares = {"A": np.full((2, 1, 1), 1.44), "B": np.full((2, 1, 1), 1.96)}  # of the pre-stretches

    balances = [SimpleNamespace(films=lambda x, squared: [squared]) for _ in range(2)]
    each = iter(range(2))

    def cells(own, placed, at, squares):
        k = next(each)  # the members come in order
        return module._Cells(np.ravel(at), np.sqrt(np.ravel(squares)) + 0.125, *(numbers(4,
        at=50.0 + 10.0 * k + j) for j in range(3)),
                             np.arange(4, dtype=np.int8), np.array([0, 1, 0, 6], dtype=np.int8))  # fmt: skip

    def ringed(members, placed, k, known):
        made.append(known)
        return known, rings(4, at=100.0 * k)

    record(monkeypatch, module, _cells=cells, _with_rings=ringed)
    own_numbers = type(placed).own
    monkeypatch.setattr(type(placed), "own", lambda film, n: {**own_numbers(film, n), **squares})
    found = {name: variable[1] for name, variable in module._variables(members, balances, placed, x, levels).items()}
    shape = (2, 2, 2)
    voltage = np.broadcast_to(levels + 0.125, shape)
    own = [rings(4, at=100.0 * k) for k in range(2)]

    def of(name):
        return np.stack([getattr(one, name) for one in own]).reshape(*shape, 4)

    def cell(j):
        return np.stack([numbers(4, at=50.0 + 10.0 * k + j) for k in range(2)]).reshape(shape)

    field, strength = voltage[..., None] * of("field"), np.array([2.0, 4.0])[:, None, None]
    up = np.array([-1.0, 1.0])[None, :, None, None]
    expected = {
        "force": cell(0), "capacitance": cell(1), "charge": cell(1) * voltage, "pull_in_film_voltage": cell(2),
        "largest_field": field.max(axis=-1), "breakdown_share": field.max(axis=-1) / strength,
        "largest_limit_share": of("limit_share").max(axis=-1),
        "least_tangent_stiffness": of("tangent_stiffness").min(axis=-1),
        "true_field": field, "ring_radius": of("r"), "ring_height": up * of("z"), "thickness": of("thickness"),
        "meridional_stretch": 1.2 * of("l1"), "hoop_stretch": 1.4 * of("width"), "wrinkle_excess": of("excess"),
        "limit_share": of("limit_share"), "tangent_stiffness": of("tangent_stiffness"),
        "largest_field_radius": np.full(shape, 5.0),
        "least_tangent_stiffness_radius": np.full(shape, 1.0), "held": np.tile([[0, 1], [0, 6]], (2, 1, 1)),
        "film_state": np.arange(4).reshape(2, 2) + np.zeros(shape), "wrinkled_share": np.full(shape,
        (1.5 + 2.5 + 16.0) / 24.0),
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, err_msg=name)
    np.testing.assert_array_equal(found["mounted_radius"], [[1.0, 2.0, 3.0, 5.0]] * 2)
    assert [one.voltage.tolist() for one in made] == [[0.375, 0.875] * 2] * 2
    del members.values["dielectric_strength"]
    each = iter(range(2))
    assert np.isnan(module._variables(members, balances, placed, x, levels)["breakdown_share"][1]).all()


def test_states_that_are_held_have_the_force_of_their_rings_and_those_that_are_not_found_say_so(monkeypatch):
    """Some at a time; a disc below the rim is pulled up. Of four states the second is slack, the last unresolved."""
    monkeypatch.setattr(module, "MOST_AT_ONCE", 2)
    given = []

    class Gels:
        def __init__(self, gel, ratio):
            given.append((gel, ratio))

        def measures(self, at):
            return SimpleNamespace(force=at.x + 10.0, area=at.x + 20.0)

    def held(own, x, squared):
        given.append((x.tolist(), squared.tolist()))
        return SimpleNamespace(x=x, found=x < 0.7)

    def profiled(own, at):
        return rings(at.x.size, at=10.0 * len(given))

    record(monkeypatch, module, held=held, profile=profiled, Elements=Gels, Gel=lambda law, n, lm, lh: (law, lm, lh))
    members = MODEL.replace(radius_ratio=[0.2, 0.3]).members()
    (placed,) = members.system.films
    own_numbers = type(placed).own
    monkeypatch.setattr(type(placed), "own", lambda film, n: {**own_numbers(film, n), "A": 1.44, "B": 1.96})
    x, as_held = np.array([-0.5, 0.1, 0.25, 0.75]), np.array([0, int(Held.SLACK), 0, 0], dtype=np.int8)
    cells = module._Cells(x, numbers(4), *(numbers(4, at=k) for k in (50.0, 60.0, 70.0)), as_held, as_held)
    found, profile = module._with_rings(members, placed, 1, cells)
    (gel, ratio), first, second = given
    assert ratio == 0.3
    assert (gel[1], gel[2]) == (pytest.approx(1.44), pytest.approx(1.96))
    assert first == ([0.5, 0.25], (numbers(4)[[0, 2]] ** 2).tolist())
    assert second == ([0.75], (numbers(4)[[3]] ** 2).tolist())
    np.testing.assert_allclose(found.force, [-10.5, numbers(4, at=50.0)[1], 10.25, 10.75])
    np.testing.assert_allclose(found.capacitance, [20.5, numbers(4, at=60.0)[1], 20.25, 20.75])
    assert found.held.tolist() == [0, Held.SLACK, 0, Held.UNRESOLVED]
    assert np.isnan(profile.r[1]).all()
    np.testing.assert_array_equal(profile.r[[0, 2]], rings(2, at=20.0).r)
    np.testing.assert_array_equal(profile.r[3], rings(1, at=30.0).r[0])
