"""The fit of the film as a continuum that wrinkles: its error, and under what name a film is kept."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone import disk_cache
from gelcone.continuum import fit
from gelcone.continuum.charged import slack_limit
from gelcone.continuum.fit import FLOOR, cached_film, find_film, fit_film, write_film
from gelcone.continuum.membrane import membrane, raised_film
from gelcone.continuum.mesh import mesh_film
from gelcone.continuum.path import Ending
from gelcone.errors import InputError
from gelcone.paper.unwrinkled import fit_unwrinkled
from gelcone.physics.film.stored import read_film
from gelcone.physics.model import ConeModel

KEPT = Path(__file__).parents[1] / "reference" / "continuum-film.json"
"""`fit_film(ConeModel())`, which takes too long for a test."""


PACKAGE = Path(fit.__file__).parents[1]


@cache
def film():
    return read_film(KEPT)


# --- the error --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("v", [0.0, 0.13, 0.37])
def test_the_force_is_that_of_the_membrane_between_what_was_fitted(v):
    """Within what the film states of itself, which is 2 % at most."""
    x = np.array([0.29, 0.71, 1.06])
    found = membrane(ConeModel(), 0.2, displacements=x, voltages=[0.0, v] if v else 0.0, wrinkles="relax", elements=16)
    force, ending = (found[name].values.reshape(-1, 3) for name in ("force", "ending"))
    assert (ending == Ending.CONVERGED).all()
    own = film().force(x, v * v, [], {})[0]
    error = np.abs(own - force[-1]) / (force[-1] + FLOOR * force[0])
    stated = dict(film().errors)["force"]
    assert error.max() < 1.2 * stated
    assert stated < 0.02


def test_it_pulls_in_where_the_membrane_does_and_falls_slack_where_it_does():
    """The membrane's own of the finest mesh."""
    x = np.array([0.75, 1.0, 1.25])
    np.testing.assert_allclose(np.sqrt(film().highest_squared(x, {})), [0.5445, 0.4377, 0.3730], rtol=0.02)
    assert np.sqrt(film().highest_squared(0.5, {})) == pytest.approx(0.691433, abs=1e-6)
    assert film().slack_first == pytest.approx(0.667**2, rel=0.01)
    numbers = film().numbers(film().complete({}))
    assert np.sqrt(film().balancing(0.5, 0.0, numbers)) == pytest.approx(0.62476, rel=2e-3)


def test_the_error_is_of_states_that_were_not_fitted():
    assert set(dict(film().errors)) == {"force", "pull-in voltage"}
    assert dict(film().errors)["pull-in voltage"] < 0.02


@pytest.mark.parametrize(("hoop", "margin"), [(1.0, 1.5), (1.2, 2.2)])
def test_the_stated_error_is_that_of_the_states_with_a_margin(monkeypatch, hoop, margin):
    """A film that hangs loose is fitted less evenly."""
    monkeypatch.setattr(fit, "_columns", lambda *given: [])
    monkeypatch.setattr(fit, "_fitted", lambda *given: film())
    monkeypatch.setattr(fit, "_errors", lambda *given: {"force": 0.01, "pull-in voltage": 0.02})
    found = fit_film(ConeModel(meridional_prestretch=1.0, hoop_prestretch=hoop))
    assert dict(found.errors) == pytest.approx({"force": 0.01 * margin, "pull-in voltage": 0.02 * margin})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "most"),
    [({}, 0.02), ({"law": "neo-hookean"}, 0.03), ({"prestretch": 1.2, "prestretch_mode": "equibiaxial"}, 0.03)],
)
def test_films_are_fitted_within_their_error(change, most):
    found = fit_film(ConeModel(**change))
    assert dict(found.errors)["force"] < most
    if not change:
        x = np.linspace(0.1, 3.0, 30)
        np.testing.assert_allclose(found.force(x, 0.05, [], {})[0], film().force(x, 0.05, [], {})[0], rtol=0.02)


def test_what_is_fitted_is_the_force_of_the_film():
    """The columns of the least squares and the film's own law are written down twice."""
    own = film()
    shape = fit._Shape(own.variable, own.rounding, own.flat_tension, own.reach_squared, own.wall)
    s, squared = np.array([0.01, 0.2, 0.9, 6.0]), np.array([0.005, 0.1, 0.2, 0.02])
    rows = fit._Rows(s, squared, s, s, s > 0.0)
    terms = tuple(map(len, own.stiffness))
    values = np.concatenate([*map(np.array, own.stiffness), [own.wall_strength]])
    fitted = fit._faded_basis(rows, shape, own.slack_above, terms) @ values
    np.testing.assert_allclose(fitted, own.pull(s, squared), rtol=1e-9)


def test_heights_are_densest_near_the_lowest_and_the_largest():
    model = ConeModel(stretch_limit=5.0, spring_stiffness=0.0)
    found = fit.mesh_film(model, 0.2, 8, relaxed=True)
    heights, checks = fit._heights(found)
    gaps = np.diff(heights)
    assert gaps[0] < 0.5 * gaps.max() > gaps[-1]
    top = fit.raised_film(found, heights[-3:])
    assert fit.limit_shares(found, top[heights[-1]].position).max() == pytest.approx(fit.LIMIT_SHARE, abs=2e-3)
    assert not set(heights) & set(checks)
    assert heights[0] < min(checks) < heights[1]
    assert heights[-2] < max(checks) < heights[-1]


# --- what is kept -----------------------------------------------------------------------------------------------------


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Finds a film with a fit that takes no time; the number of fits and of files so far."""
    fits = []
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))

    def fitting(model, ratio):
        fits.append((model, ratio))
        return film()

    monkeypatch.setattr(fit, "fit_film", fitting)

    def find(model, ratio=0.2):
        assert find_film("continuum", model, ratio) == film()
        files = list((tmp_path / "films").iterdir())
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
    monkeypatch.setattr(disk_cache, "digest_of", lambda sources: "another")
    assert kept(ConeModel()) == 2


OWN_LAW = """
from gelcone.physics.laws import NeoHookean

class Own(NeoHookean):
    name = "own"
"""


def test_a_film_of_a_law_whose_source_has_changed_is_fitted_again(kept, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    for number, text in enumerate((OWN_LAW, OWN_LAW + "    # edited\n", OWN_LAW), start=1):
        (tmp_path / "own_law.py").write_text(text)
        disk_cache.digest_of.cache_clear()
        assert kept(ConeModel(law="own_law:Own")) == min(number, 2)


def test_a_film_of_a_law_without_a_source_is_not_stored(tmp_path, monkeypatch):
    session: dict = {"__name__": "__main__"}
    exec(OWN_LAW, session)
    monkeypatch.setattr(
        disk_cache.inspect, "getfile", lambda own: (_ for _ in ()).throw(TypeError("a class of a session"))
    )
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    monkeypatch.setattr(fit, "fit_film", lambda model, ratio: film())
    assert find_film("continuum", ConeModel(law=session["Own"]())) == film()
    assert not (tmp_path / "films").exists()


def test_a_change_of_any_source_of_a_fit_fits_again(monkeypatch):
    """Films, laws, models and the continuum are sources, and each file changes the key."""
    files = ["continuum/path.py", "physics/film/wrinkling.py", "physics/film/continuum.py", "physics/laws.py"]
    files += ["physics/model.py", "paper/unwrinkled.py"]
    digests, read = set(), Path.read_bytes
    for changed in [None, *(PACKAGE / name for name in files)]:
        monkeypatch.setattr(Path, "read_bytes", lambda path, at=changed: read(path) + b"#" * (path == at))
        digests.add(disk_cache.digest_of.__wrapped__(fit.SOURCES))
    assert len(digests) == len(files) + 1


def test_a_kept_file_that_cannot_be_read_is_fitted_again(kept, tmp_path):
    kept(ConeModel())
    (path,) = (tmp_path / "films").iterdir()
    whole = path.read_bytes()
    path.write_text("{}")
    find_film("continuum", ConeModel())
    assert len(kept.fits) == 2
    assert path.read_bytes() == whole


def test_a_sweep_over_what_a_film_is_fitted_for_is_refused():
    for change, name in (({"prestretch": [1.0, 1.1]}, "prestretch"), ({"stretch_limit": [5.0, 6.0]}, "law")):
        with pytest.raises(InputError, match=f"{name}: .* fitted for one {name}; sweep it with --film taut"):
            find_film("continuum", ConeModel(**change))
    with pytest.raises(InputError, match="one film is fitted at a time"):
        fit_film(ConeModel(voltage=[0.1, 0.2]))


def test_the_taut_cone_is_no_continuum_film_and_a_file_is_read(tmp_path):
    assert [find_film(name, ConeModel()) for name in ("taut", "wrinkling")] == ["taut", "wrinkling"]
    write_film(film(), tmp_path / "film.json")
    assert find_film(str(tmp_path / "film.json"), ConeModel()) == film() == read_film(tmp_path / "film.json")


def test_a_place_where_nothing_can_be_kept_does_not_keep_from_fitting(tmp_path, monkeypatch):
    (tmp_path / "films").write_text("a file where a folder should be")
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    monkeypatch.setattr(fit, "fit_film", lambda model, ratio: film())
    started = []
    assert find_film("continuum", ConeModel(), starting=lambda: started.append(1)) == film()
    assert started == [1]


def test_films_of_another_fit_have_their_own_file(kept, monkeypatch):
    kept(ConeModel())
    fits = []
    monkeypatch.setattr(fit, "import_skfem", lambda: None)

    def fit_another(model, ratio):
        fits.append(model)
        return film()

    assert cached_film(fit_another, ConeModel(), 0.2) == film()
    assert len(fits) == 1
    assert fit_unwrinkled.__name__ != fit_film.__name__


STRETCHED = ConeModel(prestretch=1.2, prestretch_mode="equibiaxial", spring_stiffness=0.0)


@pytest.mark.parametrize("check", [False, True])
def test_states_are_dense_where_a_film_falls_slack(check):
    """The force bends towards zero there: a gap between the last states hid errors of 3.5 %."""
    film = mesh_film(
        ConeModel(prestretch=1.2, prestretch_mode="equibiaxial", spring_stiffness=0.0), 0.2, 12, relaxed=True
    )
    column = fit._column(film, raised_film(film, [0.1])[0.1], slack_limit(film.model), 0.0, check=check)
    shares = column.squared / column.charged.end
    assert column.slackens
    assert shares[-1] == pytest.approx(0.995)
    assert np.diff(shares).max() < 0.07
    assert np.diff(shares[shares > 0.93]).max() < 0.025
    assert (np.diff(column.stiffness) < 0.0).all()
