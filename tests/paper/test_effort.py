"""Sizes of a run, the films that it takes, and the stamp of what its data depend on."""

from dataclasses import fields, replace

import pytest

from gelcone.motion.attractor.search import PATIENCE
from gelcone.paper import stamp as module
from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.films import CREEPING, PAPERS, WRINKLING, film_of_model
from gelcone.paper.sampling import FIRST, SIGN_BUDGET
from gelcone.paper.stamp import SHOWING, sources, stamp
from gelcone.paper.studies.study import DECAYS
from gelcone.presets import find_preset


def test_a_set_is_the_papers_and_with_another_film_that_of_the_film():
    paper, other = FULL.preset("base"), replace(FULL, film=WRINKLING).preset("base")
    assert paper == find_preset("base")
    assert (paper.model.film.name, other.model.film.name) == ("taut", "wrinkling")
    assert film_of_model(WRINKLING).items() <= other.model.parameters().items()
    assert paper.model.values.items() <= other.model.values.items()
    assert other.initial == paper.initial


def test_the_film_that_creeps_has_the_sizes_of_a_quick_run_and_others_keep_theirs():
    creeping, wrinkling = FULL.with_film(CREEPING), FULL.with_film(WRINKLING)
    assert (creeping.name, creeping.film, wrinkling.film) == ("full", CREEPING, WRINKLING)
    assert replace(creeping, name="quick", film=PAPERS) == QUICK
    assert replace(wrinkling, film=PAPERS) == FULL


@pytest.mark.parametrize("size", [f.name for f in fields(FULL) if f.name != "name"])
def test_each_size_is_in_the_stamp_and_the_name_is_not_a_size(size):
    changed = replace(FULL, **{size: "another"})
    assert stamp(changed)["effort_sizes"] != stamp(FULL)["effort_sizes"]
    assert stamp(replace(FULL, name="mine"))["effort_sizes"] == stamp(FULL)["effort_sizes"]


def test_the_program_is_all_that_computes_and_changes_with_it(monkeypatch, tmp_path):
    listed = dict(sources())
    assert list(listed) == sorted(listed)
    assert {"physics/system.py", "paper/studies/maps.py", "devices/biased-pump.toml", "presets.py"} <= set(listed)
    assert not [name for name in listed if name.startswith(tuple(f"{part}/" for part in SHOWING)) or name in SHOWING]
    digests = set()
    for name, text, versions in (("a.py", "1", "1"), ("b.py", "1", "1"), ("a.py", "2", "1"), ("a.py", "1", "2")):
        path = tmp_path / "source"
        path.write_text(text)
        monkeypatch.setattr(module, "sources", lambda name=name, path=path: iter([(name, path)]))
        monkeypatch.setattr(module, "version", lambda library, versions=versions: versions)
        digests.add(module.program.__wrapped__())
    assert len(digests) == 4


def test_a_quick_run_is_smaller_and_still_patient_enough_for_what_it_reads():
    """Rest at the sets' damping ratio decays within it, and a sign is averaged ten times over."""
    for name in ("diagram_values", "section_points", "frequencies", "spectrum_periods", "bisections", "samples"):
        assert getattr(QUICK, name) < getattr(FULL, name)
    assert QUICK.costly_samples <= QUICK.samples
    assert (FULL.patience, QUICK.window) == (None, FULL.window)  # None is `PATIENCE`; the paper's window is one
    decay = DECAYS / min(float(find_preset(name).model.damping_ratio) for name in ("base", "fast", "spring"))
    assert max(10.0 * SIGN_BUDGET, 10.0 * decay) <= QUICK.patience < PATIENCE
    for effort in (QUICK, FULL):
        assert min(effort.samples, effort.costly_samples) >= FIRST
        assert all(size & (size - 1) == 0 for size in (effort.samples, effort.costly_samples))
