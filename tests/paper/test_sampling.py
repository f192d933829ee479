"""Samples: where they lie, when they stop, and that their numbers are those of the analysis itself."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.motion.attractor.classification import Evidence, classify
from gelcone.paper import sampling
from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.reading import finite_not_positive
from gelcone.paper.sampling import FIRST, SIGN_BUDGET, Sample, part, sampled, share_of
from gelcone.paper.studies import samples
from gelcone.paper.studies.samples import BANDS, DRAWN, FACTOR, SAMPLES, neighbours
from gelcone.presets import find_preset
from tests.paper.worlds import World, made_up

TINY = replace(QUICK, name="tiny", samples=16, costly_samples=16, patience=300.0, window=40.0)


def drawn(sample, effort=FULL, world=None):
    shares = []
    with made_up(world or World(lambda n: n["voltage"] > 9.0)):
        found = sampled((sample,), effort, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    return found


def test_a_sample_has_one_point_in_each_even_part_of_its_range_at_every_look():
    for logarithmic in (False, True):
        sample = Sample("v", "base", {"voltage": (0.5, 2.0)}, lambda points: False, logarithmic=logarithmic)
        found = drawn(sample)["voltage"].values
        assert found.size == FULL.samples
        even = np.log(found / 0.5) / np.log(4.0) if logarithmic else (found - 0.5) / 1.5
        for count in (16, 64, 512):
            assert sorted(np.floor(even[:count] * count)) == list(range(count))


@pytest.mark.parametrize("answered_at", [16, 32, 256])
def test_a_sample_stops_once_it_has_its_answer_or_its_budget_is_spent(answered_at):
    seen = []

    def answered(points):
        seen.append(points.sizes["point"])
        return points.sizes["point"] >= answered_at

    sample = Sample("v", "base", {"voltage": (0.5, 2.0)}, answered)
    assert drawn(sample).sizes["point"] == answered_at
    assert seen == [FIRST * 2**k for k in range(len(seen))]
    assert drawn(sample, replace(QUICK, samples=32)).sizes["point"] == min(answered_at, 32)
    assert drawn(replace(sample, costly=True), replace(QUICK, costly_samples=16)).sizes["point"] == 16


@pytest.mark.parametrize("sample", [own for several in SAMPLES.values() for own in several], ids=lambda own: own.name)
def test_a_sample_has_the_numbers_of_its_set_but_for_those_that_it_varies(sample):
    seen = []

    def kind(n):
        seen.append(n)
        return n["voltage"] > 9.0

    drawn(sample, replace(QUICK, samples=FIRST, costly_samples=FIRST), World(kind))
    for name, value in find_preset(sample.preset).model.replace(**sample.changes).values.items():
        if name in sample.drawn:
            assert sample.drawn[name][0] <= seen[0][name].min() < seen[0][name].max() <= sample.drawn[name][1]
        elif name in sample.inner:
            assert set(seen[0][name]) == set(np.ravel(sample.inner[name]))
        else:
            assert set(seen[0][name]) == {float(value)}


ENDS = {"low": (0.0, 1.0), "high": (1.0, 2.0)}


def test_the_parts_of_a_study_are_told_apart():
    samples = tuple(Sample(name, "base", {"voltage": ends}, lambda points: True) for name, ends in ENDS.items())
    with made_up(World(lambda n: n["voltage"] > 1.0)):
        found = sampled(samples, QUICK, lambda share: None)
    for name, chaos in (("low", 0.0), ("high", 1.0)):
        own = part(found, name)
        assert share_of(own, (own["regime"] == 3).values).value == chaos


def test_a_point_has_the_numbers_of_the_analysis_itself():
    sample = Sample(
        "v", "base", {"voltage": (0.5, 2.0)}, lambda points: True, inner={"damping_ratio": np.array([0.1, 0.3])}
    )
    found = sampled((sample,), TINY, lambda share: None)
    assert dict(found.sizes) == {"point": 16, "inner": 2, "exponent": 2}
    base = find_preset("base")
    one = base.model.replace(voltage=found["voltage"].values[3, 1], damping_ratio=np.array([0.3]))
    alone = classify(one.members(), np.array([base.initial]), patience=300.0, budget=SIGN_BUDGET)
    at = found.isel(point=3, inner=1)
    assert int(at["regime"]) == alone.regime[0]
    np.testing.assert_array_equal(at["lyapunov"].values, alone.exponents[0])
    assert float(at["extent"]) == max(abs(alone.lowest[0]), abs(alone.highest[0]))


def test_sets_near_the_base_set_are_within_a_factor_and_keep_their_other_parameters():
    with made_up(World(lambda n: n["voltage"] > 9.0)):
        found = neighbours(FULL, lambda share: None)
    base = find_preset("base").model
    for name in DRAWN:
        values = found[name].values[:, 0]
        ratio = values / float(getattr(base, name))
        assert 1.0 / FACTOR <= ratio.min() < 0.85
        assert 1.18 < ratio.max() <= FACTOR
        assert np.mean(ratio > 1.0) == pytest.approx(0.5, abs=0.1)
    assert found.sizes["inner"] == 5
    np.testing.assert_allclose(found["voltage"].values[0, [0, -1]], [1.04, 2.0])
    assert found["prestretch_kind"].dims == ("point", "prestretch")
    assert found["own_extent"].dims == ("start", "inner")


def test_the_studies_of_the_real_device_hold_what_their_claims_read():
    """At the lowest voltages of the base set rest attracts every motion."""
    sample = replace(SAMPLES["share-voltage"][0], drawn={"voltage": (0.1, 0.3)})
    found = sampled((sample,), TINY, lambda share: None)
    assert (found["outcome"] == 0).all()
    assert (finite_not_positive(found) == 1.0).all()
    assert found.attrs["window"] == 40.0


def test_quarters_of_the_prestretches_meet_and_cover_the_range():
    own = [s.drawn["prestretch"] for s in SAMPLES["share-high-voltage"] if s.changes["prestretch_mode"] == "radial"]
    assert len(own) == BANDS
    np.testing.assert_allclose(own, [(0.4, 0.8), (0.8, 1.2), (1.2, 1.6), (1.6, 2.0)])


def test_a_sample_of_two_parameters_counts_as_independent_draws():
    two = Sample("both", "base", {"voltage": (0.0, 2.0), "prestretch": (0.5, 1.5)}, lambda points: True)
    found = drawn(two, world=World(lambda n: n["voltage"] > 1.0))
    assert share_of(found, (found["regime"] == 3).values).apart is None
    one = drawn(replace(two, drawn={"voltage": (0.0, 2.0)}), world=World(lambda n: n["voltage"] > 1.0))
    assert share_of(one, (one["regime"] == 3).values).apart == 0


def test_the_extent_of_the_base_set_is_its_farthest_on_either_side(monkeypatch):
    """For each of the nearby starts, in order, at each voltage."""

    def made(members, states, **options):
        evidence = Evidence.blank(members.size)
        evidence.lowest[:], evidence.highest[:] = -members.values["voltage"], states[:, 0]
        evidence.regime[:] = np.arange(members.size) % 3
        return evidence

    monkeypatch.setattr(samples, "sampled", lambda *_: xr.Dataset())
    monkeypatch.setattr(samples, "classify", made)
    found = neighbours(QUICK, lambda share: None)
    voltages = np.linspace(samples.VOLTAGE_THRESHOLD, samples.HIGHEST, samples.SET_VOLTAGES)
    starts = QUICK.preset("base").initial[0] + samples.NEARBY * np.linspace(-1.0, 1.0, samples.STARTS)
    np.testing.assert_allclose(found["own_extent"], np.maximum(voltages, starts[:, None]), rtol=1e-12)
    np.testing.assert_array_equal(found["own_regime"].values.ravel(), np.arange(found["own_regime"].size) % 3)


def test_what_is_observed_is_asked_of_each_part_and_named_as_it_is(monkeypatch):
    asked = {}
    values = np.arange(1.0, 4.0)

    def classified(members, states, **options):
        asked.update(states=states, options=options)
        found = Evidence.blank(members.size)
        for k, name in enumerate(("regime", "share_chaotic", "lifetime_high", "lowest", "highest", "outcome")):
            getattr(found, name)[:] = values + 10.0 * k
        found.lowest[:], found.highest[:] = [-5.0, 1.0, -2.0], [3.0, 4.0, 1.0]
        found.exponents[:], found.standard_error[:] = values[:, None] * [1, -1], values[:, None] * [0.1, 0.2]
        return found

    def finite(members, states, window, options):
        asked.update(window=window, more=options, again=states)
        return values[:, None] * [5, -5], "running"

    monkeypatch.setattr(sampling, "classify", classified)
    monkeypatch.setattr(sampling, "finite_exponents", finite)
    model = find_preset("base").model.replace(voltage=np.array([0.5, 0.6, 0.7]))
    found = sampling.observed(model, (0.25, 0.5), TINY)
    np.testing.assert_array_equal(asked["states"], [[0.25, 0.5]] * 3)
    np.testing.assert_array_equal(asked["again"], asked["states"])
    assert asked["options"] == {"patience": 300.0, "budget": SIGN_BUDGET}
    assert (asked["window"], asked["more"]) == (40.0, {})
    np.testing.assert_array_equal(found["extent"], [5.0, 4.0, 2.0])
    np.testing.assert_array_equal(found["share_chaotic"], values + 10.0)
    np.testing.assert_array_equal(found["lifetime_high"], values + 20.0)
    np.testing.assert_array_equal(found["regime"], values)
    np.testing.assert_array_equal(found["outcome"], values + 50.0)
    np.testing.assert_array_equal(found["lyapunov"], values[:, None] * [1, -1])
    np.testing.assert_array_equal(found["standard_error"], values[:, None] * [0.1, 0.2])
    np.testing.assert_array_equal(found["finite"], values[:, None] * [5, -5])


def test_later_looks_take_further_points_of_one_sequence_and_each_knows_what_was_drawn():
    ends = {"voltage": (0.5, 2.0), "prestretch": (0.4, 0.8)}
    one = Sample("one", "base", ends, lambda points: points.sizes["point"] > 20, {"damping_ratio": 0.3}, costly=True)
    found = drawn(one, replace(QUICK, costly_samples=32, samples=512, window=41.0))
    assert found.sizes["point"] == 32
    assert np.unique(found["drawn_voltage"]).size == 32
    np.testing.assert_array_equal(found["drawn_voltage"], found["voltage"])
    assert ((found["drawn_prestretch"] > 0.4) & (found["drawn_prestretch"] < 0.8)).all()
    assert (found.attrs["preset"], found.attrs["window"]) == ("base", 41.0)
    assert set(found["part"].values) == {"one"}
    assert '"damping_ratio": 0.3' in found.attrs["model"]
