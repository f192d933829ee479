"""The samples behind claims: the ranges that the words of paper and claims state, and when a sample is enough."""

import numpy as np
import pytest

from gelcone.paper.claims import CLAIMS
from gelcone.paper.studies import samples
from gelcone.paper.studies.samples import SAMPLES

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
    assert samples._answered(long, window) is answered
