"""The samples behind claims: the ranges that the words of paper and claims state, and when a sample is enough."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.codes import Regime
from gelcone.motion.attractor.classification import Evidence
from gelcone.paper.claims import CLAIMS
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import samples
from gelcone.paper.studies.samples import SAMPLES
from gelcone.paper.truths import share
from gelcone.presets import find_preset

RANGES = {
    ("share-voltage", "below"): ("base", {"voltage": (0.0, 1.04)}, {}, {}),
    ("share-voltage", "above"): ("base", {"voltage": (1.04, 2.0)}, {}, {}),
    ("share-limit", "below"): ("fast", {"stretch_limit": (0.52, 1.25)}, {"voltage": 1.005}, {}),
    ("share-limit", "above"): ("fast", {"stretch_limit": (1.8, 100.0)}, {"voltage": 1.005}, {}),
    ("share-damping", "damping ratio"): ("base", {"damping_ratio": (0.0, 2.0)}, {"voltage": 0.5}, {}),
    ("other-voltages-damping", "voltage"): ("base", {"voltage": (0.5, 2.0)}, {}, {"damping_ratio": (0.02, 2.0, 8)}),
    ("other-voltages-limit", "voltage"): ("fast", {"voltage": (0.7, 1.6)}, {}, {"stretch_limit": (0.52, 100.0, 8)}),
}
for mode in ("radial", "equibiaxial"):
    for low, high in ((0.4, 0.8), (0.8, 1.2), (1.2, 1.6), (1.6, 2.0)):
        drawn = {"voltage": (1.6, 2.0), "prestretch": (low, high)}
        name = f"{mode}, pre-stretch {low:g} to {high:g}"
        RANGES["share-high-voltage", name] = ("base", drawn, {"prestretch_mode": mode}, {})
    for size, ends in (("small", (0.4, 0.8)), ("large", (1.2, 2.0))):
        inner = {"voltage": (1.04 / 11.0, 10.4 / 11.0, 10)}
        RANGES["share-prestretch", f"{mode}, {size}"] = (
            "base", {"prestretch": ends}, {"prestretch_mode": mode}, inner
        )  # fmt: skip
"""Study and part -> parameter set, drawn ranges, what else differs, and the first and last of inner values and their
number: in the words of the claims."""


def test_every_sample_has_its_ranges_here():
    assert set(RANGES) == {(study, sample.name) for study, parts in SAMPLES.items() for sample in parts}


@pytest.mark.parametrize("place", RANGES, ids=": ".join)
def test_a_sample_is_drawn_from_the_ranges_of_the_words(place):
    preset, drawn, changes, inner = RANGES[place]
    (own,) = (sample for sample in SAMPLES[place[0]] if sample.name == place[1])
    assert own.preset == preset
    assert dict(own.changes) == changes
    assert {name: tuple(map(float, ends)) for name, ends in own.drawn.items()} == {
        name: pytest.approx(ends, rel=1e-12) for name, ends in drawn.items()
    }
    assert {name: (np.min(v), np.max(v), len(v)) for name, v in own.inner.items()} == {
        name: pytest.approx(ends, rel=1e-12) for name, ends in inner.items()
    }


def test_inner_stretch_limits_lie_on_both_sides_of_the_threshold():
    """Four up to 1.25, where chaos is claimed, and four from 1.8 on, where there is none; none next to 1.5."""
    (own,) = SAMPLES["other-voltages-limit"]
    limits = np.asarray(own.inner["stretch_limit"])
    assert (np.diff(limits) > 0.0).all()
    assert ((limits < 1.25).sum(), (limits > 1.8).sum()) == (4, 4)


def test_what_claims_call_small_and_large_is_what_is_drawn():
    """A claim states the ranges of its samples in words, which nothing else ties to them."""
    words = {name: claim.statement for name, claim in CLAIMS.items()}
    assert "1.04" in words["voltage-threshold"]
    assert "about 1.5" in words["limit-threshold"]
    assert (samples.VOLTAGE_THRESHOLD, samples.LIMIT_THRESHOLD) == (1.04, 1.5)


@pytest.mark.parametrize(
    ("long", "window", "answered"),
    [
        (True, None, True), (True, True, True), (False, True, True), (False, False, True), (False, None, False),
        (None, True, False), (None, None, False),
    ],
)  # fmt: skip
def test_a_sample_has_its_answer_where_the_window_is_known_too_or_plays_no_part(long, window, answered):
    read, answers = lambda points: points["at"].values, iter((long, window))
    points = xr.Dataset({"at": ("point", [1.0])})
    assert samples.decided(lambda found: next(answers), read, read, points) is answered


@pytest.mark.parametrize(
    ("truths", "throughout", "known_half"),
    [([1] * 512, True, True), ([1] * 10, None, True), ([0] * 60, False, True), ([1] * 59 + [0], False, True),
     ([1] * 30 + [0] * 30, False, False)],
)  # fmt: skip
def test_what_holds_throughout_fails_at_no_point_of_enough_and_a_half_is_known_on_either_side(
    truths, throughout, known_half
):
    points = np.array(truths, dtype=float)
    assert samples.holds_throughout(share(points)) is throughout
    known = xr.Dataset({"at": ("point", points)})
    assert samples.half(lambda points: points["at"].values, known) is known_half
    assert samples.half(lambda points: points["at"].values, lambda points: np.ones(512), known) is known_half


def test_neighbours_of_the_base_set_are_drawn_around_it_and_it_is_followed_from_nearby_starts(monkeypatch):
    asked, shares = {}, []
    voltages = np.linspace(1.04, 2.0, 5)

    def sampled(given, effort, progress, read):
        asked.update(given=given, read=read)
        progress(1.0)
        return xr.Dataset()

    def classified(members, states, **options):
        asked.update(members=members, states=states, options=options)
        found = Evidence.blank(members.size)
        found.lowest[:] = -np.arange(members.size)
        found.highest[:] = 3.5
        found.regime[:] = np.arange(members.size) % 7
        return found

    monkeypatch.setattr(samples, "sampled", sampled)
    monkeypatch.setattr(samples, "classify", classified)
    effort = replace(QUICK, patience=77.0)
    found = samples.neighbours(effort, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    (sample,), base = asked["given"], find_preset("base").model
    for name in ("drive_frequency", "spring_stiffness", "damping_ratio"):
        value = float(getattr(base, name))
        assert sample.drawn[name] == pytest.approx((value / 1.25, value * 1.25))
    assert (len(sample.drawn), sample.logarithmic, sample.preset) == (3, True, "base")
    np.testing.assert_allclose(sample.inner["voltage"], voltages)
    assert sample.answered.args == (samples.rows_positive, samples.rows_about_six, samples.rows_ordered)
    assert asked["read"] is samples._of_sets
    offsets = samples.NEARBY * np.linspace(-1.0, 1.0, samples.STARTS)
    initial = np.array(effort.preset("base").initial)
    np.testing.assert_allclose(asked["states"], initial + np.repeat(offsets, 5)[:, None], rtol=1e-15)
    np.testing.assert_allclose(asked["members"].values["voltage"], np.tile(voltages, samples.STARTS))
    assert asked["options"] == {"patience": 77.0, "budget": samples.SIGN_BUDGET}
    count = 5 * samples.STARTS
    np.testing.assert_array_equal(found["own_extent"].values.ravel(), np.fmax(np.arange(count), 3.5))
    np.testing.assert_array_equal(found["own_regime"].values.ravel(), np.arange(count) % 7)
    assert found["own_extent"].dims == ("start", "inner")


def test_a_set_has_the_kinds_of_motion_at_the_pre_stretches_of_their_figure(monkeypatch):
    asked = {}

    def classified(members, states, **options):
        asked.update(members=members, states=states, options=options)
        found = Evidence.blank(members.size)
        found.regime[:] = np.arange(members.size)
        return found

    monkeypatch.setattr(samples, "classify", classified)
    monkeypatch.setattr(samples, "observed", lambda model, initial, effort: (model, initial))
    monkeypatch.setattr(samples, "over_points", lambda own: xr.Dataset(attrs={"voltage": own[0].voltage.tolist()}))
    model = find_preset("base").model.replace(damping_ratio=np.array([[0.1], [0.2]]), voltage=np.array([1.2, 1.3]))
    found = samples._of_sets(model, (0.5, 0.25), replace(QUICK, patience=77.0))
    n = asked["members"].values
    np.testing.assert_array_equal(np.broadcast_to(n["voltage"], 6), [1.0] * 6)
    np.testing.assert_array_equal(n["damping_ratio"], np.repeat([0.1, 0.2], 3))
    np.testing.assert_array_equal(n["prestretch"], [0.8, 1.0, 1.5] * 2)
    np.testing.assert_array_equal(asked["states"], [(0.5, 0.25)] * 6)
    assert asked["options"] == {"patience": 77.0, "budget": samples.SIGN_BUDGET}
    np.testing.assert_array_equal(found["prestretch_kind"], [[0, 1, 2], [3, 4, 5]])
    assert found.attrs == {"voltage": [1.2, 1.3]}


def test_voltages_whose_runs_all_end_leave_open_whether_damping_ratios_are_without_chaos():
    (own,) = SAMPLES["other-voltages-damping"]
    for kind, answered in ((Regime.PERIODIC, True), (Regime.CHAOTIC, True), (Regime.LEFT_THE_DOMAIN, False)):
        points = xr.Dataset({"regime": (("point", "damping_ratio"), np.full((64, 8), int(kind)))})
        assert own.answered(points) is answered
