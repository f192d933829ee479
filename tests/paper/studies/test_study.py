"""Every study is computed with the film that it is asked for."""

from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from gelcone.dataset import model_of
from gelcone.motion.attractor.search import default_transient
from gelcone.paper.claims import CLAIMS
from gelcone.paper.effort import QUICK
from gelcone.paper.films import OTHER_FILMS, film_of_device
from gelcone.paper.run import _judged_with
from gelcone.paper.studies import STUDIES, practical, study
from gelcone.paper.studies.triples import TRIPLES
from gelcone.physics.model import ConeModel


@pytest.mark.parametrize("film", ["taut", "wrinkling", "membrane"])
@pytest.mark.parametrize("name", ["static", "linear-limit"])
def test_the_film_is_the_one_that_was_asked_for(name, film):
    result = STUDIES[name].compute(replace(QUICK, film=film), lambda share: None)
    assert model_of(result).film.name == film


@pytest.mark.parametrize("film", ["taut", *OTHER_FILMS])
def test_the_device_has_the_film_that_was_asked_for(film, monkeypatch):
    class Seen(Exception):
        pass

    def stop(device, *_):
        raise Seen(device)

    monkeypatch.setattr(practical, "_practical", stop)
    with pytest.raises(Seen) as seen:
        practical.practical(replace(QUICK, film=film), lambda share: None)
    (device,) = seen.value.args
    assert device.film == ("wrinkling" if film == "creeping" else film)
    assert device.series_resistance == film_of_device(film).series_resistance
    assert (device.series_resistance is None) == (film != "creeping")


JUDGED_WITH = {
    "wrinkling": set(CLAIMS) - {"limit-tiny-negative"},
    "membrane": {"static-bistable", "fem-agreement", "linear-limit", "practical-voltage"},
    "creeping": {
        "damping-never-chaotic", "practical-voltage", "prestretch-order", "voltage-amplitude", "voltage-spectra",
        "voltage-threshold",
    },
}  # fmt: skip
"""Films and the claims that are judged with them: the membrane is a film of claims about force and pull-in, and only
few motions of the film that creeps are computed at an acceptable cost."""


@pytest.mark.parametrize("film", OTHER_FILMS)
def test_a_claim_is_judged_with_the_films_of_all_its_studies(film):
    paper = SimpleNamespace(studies=STUDIES)
    assert {name for name, claim in CLAIMS.items() if _judged_with(claim, film, paper)} == JUDGED_WITH[film]


def test_the_studies_of_figures_alone_have_films_as_well():
    claimed = {name for claim in CLAIMS.values() for name in claim.studies}
    found = {name: study.films for name, study in STUDIES.items() if name not in claimed}
    assert found.pop("chaos-counts") == ()  # of the taut film alone
    assert found
    assert set(found.values()) == {("wrinkling",)}


NUMBERS = {
    "claims.agreement": {"CLOSE": 0.05, "NEARLY_ALL": 0.95, "SURVIVES": 0.2},
    "claims.damping": {"SMALLEST_ERROR": 1e-6},
    "claims.limit": {"TINY": 0.5},
    "claims.maps": {"SURE": 0.01, "CHANCE": 0.05, "WIDEST": 0.1},
    "claims.statics": {"LINEAR": 0.01},
    "claims.voltage": {"ROUNDED": (1.035, 1.045)},
    "reading": {"LIMIT_THRESHOLD": 1.5, "SAME": 0.05, "SIX": (5.5, 6.5)},
    "studies.continuum": {"RADIUS_RATIOS": (0.2, 0.5), "FARTHEST": 1.3, "CHAOS": (0.9, 1.1), "SOFT": 0.1},
    "studies.limits": {"LARGE": (100.0, 300.0, 1000.0), "OWN_VOLTAGE": 1.005},
    "studies.maps": {"STACKED": (0.6, 0.8, 1.0, 1.2, 1.5)},
    "studies.practical": {"VOLTS": (10, 15, 20, 25, 30, 35, 40, 45, 50), "HEIGHTS": (0.0, 0.02)},
    "studies.resonance": {"STIFFNESSES": (0.1, 0.5, 1.0, 5.0, 10.0, 20.0), "BAND": (0.05, 6.0)},
    "studies.samples": {"FACTOR": 1.25, "ABOUT": 1.2},
    "studies.spectra": {"SETS": ("base", "fast")},
    "studies.statics": {
        "STATIC_VOLTAGES": (0.0, 1.0, 1.5), "LIMITS": (1.0, 1.5, 2.0, 5.0, 10.0, 50.0, 100.0), "SURFACES": (1.0, 100.0),
    },
    "verdicts": {"NEARLY_ALL": 0.9, "WIDE": 0.5},
}  # fmt: skip
"""What the paper's text, its figures as far as known, and the rules of the report state in numbers."""


@pytest.mark.parametrize("place", NUMBERS)
def test_studies_and_rules_have_the_numbers_of_the_text(place):
    module = import_module(f"gelcone.paper.{place}")
    for name, value in NUMBERS[place].items():
        assert tuple(np.ravel(getattr(module, name)).tolist()) == tuple(np.ravel(value).tolist()), name


def test_motions_side_by_side_have_the_values_of_their_figures():
    assert TRIPLES == {
        "damping": ("base", "damping_ratio", (0.001, 0.05, 0.5), {"voltage": 0.5}),
        "limit": ("fast", "stretch_limit", (1.0, 10.0, 100.0), {"voltage": 1.005}),
        "voltage": ("base", "voltage", (0.5, 1.04, 1.7), {}),
        "prestretch": ("base", "prestretch", (0.8, 1.0, 1.5), {"voltage": 1.0}),
        "spring": ("spring", "spring_stiffness", (1.0, 5.0, 10.0), {}),
    }


@pytest.mark.parametrize(("damping", "frequency"), [([0.5, 0.001], 1.0), ([0.5, 0.4], 1e-3)])
def test_kinds_wait_for_the_least_damped_motion_or_the_usual_transient_whichever_is_longer(
    monkeypatch, damping, frequency
):
    model = ConeModel(damping_ratio=damping, drive_frequency=frequency)
    asked = {}

    def classify(members, states, **options):
        asked.update(options, states=states)
        return "evidence"

    monkeypatch.setattr(study, "classify", classify)
    monkeypatch.setattr(study, "label_evidence", lambda *given: given)
    _, evidence, options, _ = study.kinds_of(model, (0.3, 0.1), replace(QUICK, patience=777.0))
    usual, decays = float(default_transient(model.members()).max()), 20.0 / min(damping)
    assert asked["transient"] == options["transient"] == max(usual, decays)
    assert (usual > decays, usual < decays) == (frequency < 0.1, frequency == 1.0)
    assert asked["patience"] == options["patience"] == 777.0
    np.testing.assert_array_equal(asked["states"], [[0.3, 0.1]] * 2)
    assert evidence == "evidence"


def test_a_study_says_what_it_is_of_and_has_the_model_of_another():
    own = xr.Dataset({"x": 1.0}, attrs={"old": 1})
    source = xr.Dataset(attrs={"model": "{}", "title": "another", "options": "{}"})
    result = study.about(own, source, "base", "voltage", replace(QUICK, window=40.0), {"a": 2}, "a title")
    assert result.attrs == {
        "model": "{}", "title": "a title", "options": '{"a": 2}', "preset": "base", "parameter": "voltage",
        "window": 40.0,
    }  # fmt: skip
    assert source.attrs["title"] == "another"
    both = study.merged(xr.Dataset({"x": 1.0}, attrs={"of": "first"}), xr.Dataset({"y": 2.0}, attrs={"of": "second"}))
    assert (dict(both.attrs), set(both.data_vars)) == ({"of": "first"}, {"x", "y"})
    with pytest.raises(ValueError, match="exact"):
        study.merged(xr.Dataset(coords={"t": [1.0]}), xr.Dataset(coords={"t": [2.0]}))
