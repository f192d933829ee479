"""The table of profiles from which the page draws a membrane, against the analysis that shows one."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.request import read_subject
from gelcone.studio import profiles

SUBJECT = read_subject("paper-table1", settings=["film=membrane"])


@pytest.fixture(scope="module")
def table():
    return profiles.table(SUBJECT, 0)


def rows(table, name):
    return np.reshape(table.arrays[name], (profiles.HEIGHTS, len(profiles.SHARES), profiles.RINGS))


def test_it_is_the_membrane_at_those_heights_and_voltages(table):
    height, top = (table.arrays[name] for name in ("height", "top"))
    i, j = 5, 2
    voltage = top[i] * np.sqrt(profiles.SHARES[j])
    found = gelcone.film(SUBJECT.device, height[i] * 1e-3, voltage).isel(height=0, constant_voltage=0)
    some = np.linspace(0, found.sizes["ring"] - 1, profiles.RINGS).round().astype(int)
    np.testing.assert_allclose(rows(table, "radius")[i, j], found["ring_radius"][some], rtol=1e-6)
    np.testing.assert_allclose(rows(table, "rise")[i, j], found["ring_height"][some] / height[i], atol=1e-6)
    np.testing.assert_allclose(rows(table, "stretch")[i, j], 0.5 / found["thickness"][some], rtol=1e-6)
    np.testing.assert_array_equal(rows(table, "wrinkled")[i, j], found["wrinkle_excess"][some] > 0.0)


def test_its_heights_reach_from_flat_to_where_the_film_is_known(table):
    (film,) = SUBJECT.model.system.films
    known = film.film.reach(film.own(SUBJECT.model.members().numbers_at(0)))[1]
    scale = 1e3 * SUBJECT.device.scales.length
    height = table.arrays["height"]
    assert (height[0], height[-1]) == (0.0, pytest.approx(known * scale))
    steps = np.diff(height)
    assert (np.diff(steps) > 0.0).all()  # closest where the film is flat
    at_rest = gelcone.film(SUBJECT.device, height[5] * 1e-3, 0.0).isel(height=0, constant_voltage=0)
    assert table.arrays["top"][5] <= float(at_rest["pull_in_film_voltage"]) * (1.0 + 1e-6)


def test_every_profile_leads_from_the_disc_to_the_rim(table):
    for name in ("radius", "rise", "stretch"):
        assert np.isfinite(table.arrays[name]).all()
    np.testing.assert_allclose(rows(table, "radius")[:, :, [0, -1]], np.broadcast_to([10.0, 50.0], (12, 6, 2)))
    np.testing.assert_allclose(rows(table, "rise")[:, :, [0, -1]], np.broadcast_to([1.0, 0.0], (12, 6, 2)), atol=1e-12)
    assert rows(table, "stretch")[1:].max() > 1.2


def test_films_of_one_gel_and_ring_share_a_table_whatever_their_drive():
    (name,) = profiles.names(SUBJECT.model)
    assert name
    assert profiles.names(SUBJECT.model.replace(voltage=0.1, spring_stiffness=0.3)) == [name]
    others = [{"prestretch": 0.9}, {"radius_ratio": 0.3}, {"stretch_limit": 60.0}, {"law": "neo-hookean"}]
    assert len({name, *(profiles.names(SUBJECT.model.replace(**other))[0] for other in others)}) == 1 + len(others)
    assert profiles.names(SUBJECT.model.replace(film="wrinkling")) == [""]
    double = SUBJECT.model.replace(second_film="membrane")
    assert profiles.names(double) == [name, name]
    assert profiles.names(double.replace(second_drive="opposite")) == [name, ""]


def test_tables_are_made_once_and_only_so_many_are_held(monkeypatch):
    """Each by its name alone; with one more all of the older ones go."""
    made = []
    monkeypatch.setattr(profiles, "_tables", {})
    monkeypatch.setattr(profiles, "MOST", 3)
    monkeypatch.setattr(profiles, "_profiles", lambda film, n, ratio: made.append(ratio) or (len(made),))
    model = gelcone.find_device("biased-pump").to_model()
    for name in ("a", "b", "a", "c", "b"):
        profiles._made(name, model, 0)
    assert len(made) == len(profiles._tables) == 3
    assert profiles._made("d", model, 0) == (4,)
    assert list(profiles._tables) == ["d"]
    assert profiles._made("a", model, 0) == (5,)
    assert made == [pytest.approx(8 / 30)] * 5
