"""The fit of the continuum film: its error, its free limit, and under what name a film is kept."""

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum import fit
from gelcone.continuum.fit import (
    CEILING_MARGIN,
    FLAT,
    KINDS,
    LIMIT_SHARE,
    TAUT,
    find_film,
    fit_film,
    free_film_limit,
    write_film,
)
from gelcone.continuum.membrane import membrane
from gelcone.errors import InputError
from gelcone.physics.film.continuum import read_film
from gelcone.physics.model import ConeModel
from tests.continuum.films import fitted_with_states

# --- the error --------------------------------------------------------------------------------------------------------


def misses():
    """What the fit misses at every state, relative as the weights are, and the kinds of the states."""
    film, states = fitted_with_states()
    s, squared, stiffness, kind = states.T
    inside = squared / film.highest_squared_at(s) < CEILING_MARGIN
    s, squared, stiffness, kind = (values[inside] for values in (s, squared, stiffness, kind))
    off = film.stiffness(s, squared)[0] - squared - stiffness
    return np.abs(off) / (np.abs(stiffness) + 0.3 * squared + 0.02), kind


@pytest.mark.slow
def test_the_error_of_a_fit_is_the_largest_of_each_kind_of_state():
    film, _ = fitted_with_states()
    miss, kind = misses()
    own = {name: miss[kind == k].max() for k, name in enumerate(KINDS) if (kind == k).any()}
    assert dict(film.errors) == pytest.approx(own, rel=1e-6)
    # the mean would be smaller by far
    assert miss[kind == TAUT].mean() < 0.5 * own["taut"]


@pytest.mark.slow
def test_the_fit_is_best_where_the_film_does_not_wrinkle():
    miss, kind = misses()
    assert miss[kind == TAUT].max() < 0.02
    assert miss[kind == FLAT].max(initial=0.0) < 0.05


@pytest.mark.slow
def test_the_fit_agrees_with_the_membrane_between_its_states():
    film, _ = fitted_with_states()
    x, levels = np.array([0.33, 1.21, 2.9]), np.array([0.0, 0.3])
    found = membrane(ConeModel(), 0.2, displacements=x, voltages=levels, elements=60)["force"].values
    own = x * (film.stiffness(x**2, levels[:, None] ** 2)[0] - levels[:, None] ** 2)
    taut = np.isfinite(found)
    np.testing.assert_allclose(own[taut], found[taut], rtol=0.05)
    assert taut[0].all()


def test_states_reach_up_to_the_stretch_limit_and_the_pull_in():
    film, states = fitted_with_states()
    s, squared = states[:, 0], states[:, 1]
    assert film.largest == pytest.approx(np.sqrt(s.max()))
    assert film.wall > s.max()
    at_reach = membrane(ConeModel(), 0.2, displacements=film.largest, elements=40)
    assert LIMIT_SHARE - 0.2 < float(at_reach["limit_share"].squeeze()) <= LIMIT_SHARE + 0.01
    assert squared.max() <= free_film_limit(ConeModel()) * (1.0 + 1e-9)


def test_a_flat_film_of_even_tension_has_the_stiffness_of_theory():
    """2 (1 - r) N/((1 + r) ln(1/r)) with N = (A - G) response - V; none without pre-stretch and voltage."""
    film, _ = fitted_with_states()
    share = 2.0 * 0.8 / (1.2 * np.log(5.0))
    for squared in (0.0, 0.1):
        assert film.stiffness(0.0, squared)[0] - squared == pytest.approx(-share * squared, abs=1e-10)


# --- the free film ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stretch", [1.0, 1.2])
def test_a_prestretched_free_film_runs_away_at_a_higher_voltage(stretch):
    """The voltage refers to the mounted thickness: V G = (1 - t^-3)/t with G = stretch^-4, largest at t^3 = 4."""
    model = ConeModel(law="neo-hookean", prestretch=stretch, prestretch_mode="equibiaxial")
    assert free_film_limit(model) == pytest.approx(0.75 / 4.0 ** (1 / 3) * stretch**4, rel=1e-5)


def test_a_film_that_the_stretch_limit_holds_ends_at_one_over_g():
    model = ConeModel(stretch_limit=0.2, prestretch=1.05, prestretch_mode="equibiaxial")
    assert free_film_limit(model) == pytest.approx(1.05**4, rel=1e-9)


# --- what is kept -----------------------------------------------------------------------------------------------------


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Finds a film with a fit that takes no time; the number of fits and of files so far."""
    film, _ = fitted_with_states()
    fits = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(fit, "fit_film", lambda model, ratio: (fits.append((model, ratio)), film)[1])

    def find(model, ratio=0.2):
        assert find_film("continuum", model, ratio) == film
        files = list((tmp_path / "gelcone" / "films").glob("*.json"))
        assert len(files) == len(fits)
        return len(files)

    find.fits = fits
    return find


def test_the_same_film_is_fitted_once_whatever_it_is_driven_and_loaded_by(kept):
    assert kept(ConeModel()) == 1
    assert kept(ConeModel()) == 1
    assert kept(ConeModel(voltage=1.3, drive_frequency=2.0, spring_stiffness=9.0, damping_ratio=0.5)) == 1
    model, ratio = kept.fits[0]
    assert ratio == 0.2
    assert float(model.spring_stiffness) == 0.0


@pytest.mark.parametrize(
    ("change", "ratio"),
    [
        ({}, 0.3),
        ({"stretch_limit": 40.0}, 0.2),
        ({"law": "neo-hookean"}, 0.2),
        ({"prestretch": 1.1}, 0.2),
        ({"prestretch": 1.1, "prestretch_mode": "equibiaxial"}, 0.2),
    ],
)
def test_a_film_of_another_law_prestretch_or_radius_ratio_is_another_file(kept, change, ratio):
    kept(ConeModel())
    assert kept(ConeModel(**change), ratio) == 2


def test_parameters_of_a_law_tell_films_apart(kept):
    for second in (0.1, 0.2):
        kept(ConeModel(law="yeoh", yeoh_c2=second, yeoh_c3=0.0))
    assert len(kept.fits) == 2


def test_a_film_of_another_program_is_fitted_again(kept, monkeypatch):
    kept(ConeModel())
    monkeypatch.setattr(fit, "_program", lambda: "another")
    assert kept(ConeModel()) == 2


def test_a_kept_file_that_cannot_be_read_is_fitted_again(kept, tmp_path):
    kept(ConeModel())
    (path,) = tmp_path.rglob("*.json")
    path.write_text("{}")
    find_film("continuum", ConeModel())
    assert len(kept.fits) == 2
    assert read_film(path) == fitted_with_states()[0]


def test_a_sweep_over_what_a_film_is_fitted_for_is_refused():
    for change, name in (({"prestretch": [1.0, 1.1]}, "prestretch"), ({"stretch_limit": [5.0, 6.0]}, "law")):
        with pytest.raises(InputError, match=f"{name}: .* fitted for one {name}; sweep it with --film taut"):
            find_film("continuum", ConeModel(**change))
    with pytest.raises(InputError, match="one film is fitted at a time"):
        fit_film(ConeModel(voltage=[0.1, 0.2]))


def test_the_taut_cone_is_no_continuum_film_and_a_file_is_read(tmp_path):
    film, _ = fitted_with_states()
    assert [find_film(name, ConeModel()) for name in ("taut", "wrinkling")] == ["taut", "wrinkling"]
    write_film(film, tmp_path / "film.json")
    assert find_film(str(tmp_path / "film.json"), ConeModel()) == film == read_film(tmp_path / "film.json")


def test_a_place_where_nothing_can_be_kept_does_not_keep_from_fitting(tmp_path, monkeypatch):
    film, _ = fitted_with_states()
    (tmp_path / "gelcone").write_text("a file where a folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(fit, "fit_film", lambda model, ratio: film)
    started = []
    assert find_film("continuum", ConeModel(), starting=lambda: started.append(1)) == film
    assert started == [1]
