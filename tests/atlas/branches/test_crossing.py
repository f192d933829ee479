"""With more than two states a pair of multipliers can leave the unit circle: a torus is born, and is reported."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses.branches import continue_branch_words
from gelcone.analyses.request import Subject
from gelcone.atlas.branches import crossing
from gelcone.atlas.branches.branch import Walk
from gelcone.atlas.branches.event import DOUBLE
from gelcone.atlas.branches.point import Direction, Metric, Point, at_value
from gelcone.atlas.branches.varied import vary
from gelcone.motion.orbit import Kind, Shooting
from gelcone.presets import find_preset
from tests.atlas.branches import maps
from tests.atlas.branches.events import events_of
from tests.toys import FilteredVoltage, TurningBias

MODEL = gelcone.ConeModel(bias=TurningBias(), damping_ratio=0.1, voltage=0.3, drive_frequency=0.8)


@pytest.fixture(scope="module")
def result():
    # brute force starts with the wheel moving: one at rest stays so
    start = (0.4, 0.0, 0.1, 0.0)
    return gelcone.continue_branch(MODEL, "wheel_growth", -0.11, 0.07, start, start="settled", checks=3)


def test_a_torus_is_born_where_the_wheel_begins_to_grow(result):
    """The wheel's deviations grow as exp((g + i w) t), whatever the disc does: at g = 0 they pass the unit circle."""
    (event,) = events_of(result)
    assert event["kind"] == "torus"
    assert abs(event["value"]) <= event["value_error"] < 1e-10
    assert event["born_branch"] is None
    assert event["supercritical"] is None
    period = np.pi / 0.8
    pair = np.exp(0.618j * period)
    found = [complex(*m) for m in event["multipliers"]]
    np.testing.assert_allclose(sorted(found, key=abs)[-2:], [pair, pair.conjugate()], atol=1e-9)
    # those of the disc shrink areas by exp(-2 zeta T)
    assert abs(np.prod(sorted(found, key=abs)[:2])) == pytest.approx(np.exp(-0.2 * period), rel=1e-9)


CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "continuation.json").read_text())["references"]
SPRING = find_preset("spring").model.replace(damping_ratio=0.01)


@pytest.mark.parametrize(
    ("low", "high", "names", "within"),
    [(0.9, 1.2, ("pd1", "pd2"), 1e-9), (0.5, 0.56, ("fold1", "fold2"), 1e-3)],
)
def test_where_newtons_method_fails_ever_narrower_brackets_find_the_event(monkeypatch, low, high, names, within):
    monkeypatch.setattr(crossing, "locate", lambda *_, **__: None)
    found = gelcone.continue_branch(SPRING, "drive_frequency", low, high, start="settled", switch=0, checks=2)
    certified = {r["key"]: r.get("value") for r in CERTIFIED}
    values = sorted(certified[f"frequency/spring_zeta0.01/{name}"] for name in names)
    events = sorted(events_of(found), key=lambda event: event["value"])
    assert len(events) == len(values)
    for event, value in zip(events, values, strict=True):
        assert abs(event["value"] - value) <= 3.0 * event["value_error"] < within


@pytest.mark.parametrize("exact", [crossing.FOLD, DOUBLE])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_event_exactly_at_a_point_is_found_once(monkeypatch, exact, sign):
    tests = [(0.5, own) if exact == DOUBLE else (own, 0.5) for own in (sign, sign, 0.0, -sign, -sign)]
    points = [
        SimpleNamespace(
            tests={crossing.FOLD: f, DOUBLE: d}, nodes=np.full((1, 2), 0.1 * k), value=0.1 * k, tangent=None
        )
        for k, (f, d) in enumerate(tests)
    ]
    asked = []
    monkeypatch.setattr(crossing, "_event", lambda *given: asked.append(given[3]))
    for a, b in pairwise(points):
        crossing.events_between(SimpleNamespace(size=2), a, b, 0, Walk(0.0, 1.0), False)
    assert asked == [exact]


@pytest.mark.parametrize("width", [0.3, 1e-2, 1e-5])
def test_the_error_of_a_torus_holds_the_bracket(monkeypatch, width):
    """However early the search ends, the true value, 0, lies within the error."""
    monkeypatch.setattr(crossing, "TORUS_WIDTH", width)
    start = (0.4, 0.0, 0.1, 0.0)
    found = gelcone.continue_branch(MODEL, "wheel_growth", -0.11, 0.07, start, start="settled", checks=2, switch=0)
    (event,) = events_of(found)
    assert abs(event["value"]) <= event["value_error"] <= max(width, 0.2) * 0.18 + 1e-12


def test_the_orbit_is_stable_before_and_unstable_behind(result):
    own = result.isel(branch=0)
    np.testing.assert_array_equal(own["stable"], own["value"] < 0.0)
    assert result.sizes["flag"] == 0


def test_text_and_figure_tell_it(result):
    assert "torus at" in continue_branch_words(result, Subject(MODEL))
    assert "torus" in [handle.get_label() for handle in gelcone.plot(result).axes[0].get_legend().legend_handles]


def pair(*multipliers, value=0.0):
    """A point with these multipliers."""
    nodes = np.zeros((1, len(multipliers)))
    return Point(nodes, value, np.array(sorted(multipliers, key=abs, reverse=True), complex), Direction(nodes, 1.0))


@pytest.mark.parametrize(
    ("inner", "outer", "at"), [((0.5, 0.2), (1.5, 0.2), crossing.FOLD), ((-0.5, 0.2), (-1.5, 0.2), DOUBLE)]
)
def test_the_unstable_side_is_that_of_the_point_beyond_the_multiplier(inner, outer, at):
    for low, high, side in ((inner, outer, 1.0), (outer, inner, -1.0)):
        a, b = pair(*low, value=0.2), pair(*high, value=0.7)
        assert crossing._unstable_side(a, b, at) == side
        assert crossing._unstable_side(b, a, at) == side


def test_a_torus_lies_where_the_modulus_of_the_pair_nearest_to_the_circle_passes_one():
    """A little beyond, towards the middle; real multipliers do not count."""

    def ring(modulus):
        return modulus * np.exp(0.7j), modulus * np.exp(-0.7j)

    inside, outside = pair(*ring(np.exp(-0.3)), 3.0), pair(*ring(np.exp(0.1)), 0.1)
    assert (crossing._pairs_outside(inside), crossing._pairs_outside(outside)) == (0, 2)
    assert crossing._crossing(inside, outside) == pytest.approx(0.75 - 0.025)
    assert crossing._crossing(outside, inside) == pytest.approx(0.25 + 0.025)
    assert crossing._crossing(pair(0.5, 0.2, 0.1), outside) == 0.5
    far = pair(*ring(np.exp(-0.3)), *ring(np.exp(-2.0)))  # the pair nearest to the circle counts
    assert crossing._crossing(far, outside) == pytest.approx(0.75 - 0.025)
    assert crossing._crossing(outside, outside) == 0.5


def test_rest_with_a_state_of_a_circuit_is_lost_where_theory_says():
    model = gelcone.ConeModel(
        circuit=FilteredVoltage(), filter_time=0.3, spring_stiffness=0.5, drive_frequency=0.5, damping_ratio=0.1
    )
    shooting = vary(model, {"voltage": (0.6, 0.75)}, (0.0, 0.0)).shooting(1e-9)
    nodes = np.zeros((shooting.count, 3))
    ends = [at_value(shooting, nodes, value, Metric.of(nodes, 1.0)).point for value in (0.64, 0.7)]
    (at,) = (at for at, test in ends[0].tests.items() if test * ends[1].tests[at] < 0.0)
    found = crossing._at_rest(shooting, *ends, at)
    onset = gelcone.onset_voltage(model)
    assert float(found.values[0]) == pytest.approx(float(onset["onset_voltage"]), abs=1e-6)
    assert np.abs(found.nodes[:, :2]).max() < 1e-12
    assert np.abs(found.nodes[:, 2]).max() > 0.3  # the filter swings with its voltage


def test_the_value_at_which_rest_is_lost_is_known_to_within_its_error():
    """However many segments and whatever bracket rounding comes from."""
    model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5, damping_ratio=0.1)
    phase, found = vary(model, {"voltage": (0.6, 0.75)}, (0.0, 0.0)).shooting().phase, []
    for segments in (4, 8, 20):
        shooting = Shooting(model.members(), ("voltage",), Kind(1), segments, phase, 1e-15)
        nodes = np.zeros((shooting.count, 2))
        for bracket in ((0.62, 0.7), (0.6, 0.75), (0.65, 0.66)):
            ends = [at_value(shooting, nodes, value, Metric.of(nodes, 1.0)).point for value in bracket]
            at = crossing.FOLD if ends[0].tests[crossing.FOLD] * ends[1].tests[crossing.FOLD] < 0.0 else DOUBLE
            found.append(crossing._at_rest(shooting, *ends, at))
    values, errors = np.array([[orbit.values[0], orbit.errors[0]] for orbit in found]).T
    assert max(np.ptp(values), np.spacing(values[0])) <= errors.min() <= errors.max() < 1e-13
    onset = float(gelcone.onset_voltage(model)["onset_voltage"])
    assert np.abs(values - onset).max() <= errors.min()


# --- made-up maps -----------------------------------------------------------------------------------------------------

WALK = Walk(-3.0, 3.0)


def two_orbits(first, second):
    """Orbits of the S-curve at two places, their tangents going from the first to the second."""
    world = maps.Maps(maps.s_curve)
    points = [maps.orbit_at(world, maps.value_of(s), s + maps.AWAY) for s in (first, second)]
    way = np.sign(second - first)
    return world, *(
        point if way * point.tangent.nodes[0, 0] > 0.0 else replace(point, tangent=-point.tangent) for point in points
    )


@pytest.mark.parametrize("newton", [True, False])
@pytest.mark.parametrize(
    ("ends", "kinds"),
    [
        ((1.4, 0.9), ["PERIOD_DOUBLING", "FOLD"]), ((0.9, 1.4), ["FOLD", "PERIOD_DOUBLING"]),
        ((-0.9, -1.4), ["FOLD", "PERIOD_DOUBLING"]), ((0.9, -0.8), []), ((1.2, 0.8), ["FOLD"]),
    ],
)  # fmt: skip
def test_events_between_two_points_come_in_the_order_of_the_branch(monkeypatch, newton, ends, kinds):
    """With the side on which the branch is less stable; brackets hold the same values, but no branch that is born."""
    world, a, b = two_orbits(*ends)
    if not newton:
        monkeypatch.setattr(crossing, "locate", lambda *_, **__: None)
    found = crossing.events_between(world, a, b, 17, WALK, False)
    assert [event.kind.name for event in found] == kinds
    for event in found:
        fold, sign = event.kind.name == "FOLD", np.sign(ends[0])
        value = sign * maps.value_of(1.0 if fold else maps.DOUBLES_AT)
        assert abs(event.value - value) <= 3.0 * event.orbit.errors[0] < (1e-12 if newton else 1e-8)
        assert event.unstable == (0.0 if fold else sign)
        assert (event.after, event.map, event.resolved, event.born is not None) == (17, Kind(1), newton, newton)


def test_a_mirrored_orbit_breaks_its_symmetry():
    """At p = 2, above which it is less stable."""
    world = maps.Maps(maps.mirrored_pitchfork, Kind(1, True), symmetric=True)

    def at(p):
        x = np.sqrt(p)
        nodes = np.array([[x, -x], [0.5 * x, -0.25 * x]])
        return at_value(world, nodes, p, Metric.of(nodes, 1.0)).point

    (event,) = crossing.events_between(world, at(1.9), at(2.1), 0, WALK, False)
    assert (event.kind.name, event.unstable, event.supercritical) == ("SYMMETRY_BREAKING", 1.0, True)
    assert event.value == pytest.approx(2.0, abs=1e-12)


def points(*pairs):
    return [Point(np.ones((1, 2)), 0.1 * k, np.array(two, complex), None) for k, two in enumerate(pairs)]


def test_a_pair_passes_the_unit_circle_where_its_modulus_does():
    """By the logarithm of the pair nearest to the circle, a little beyond; halfway where no pair is on both sides."""
    inside, outside, real = points((0.9j, -0.9j, 0.2j, -0.2j), (1.2j, -1.2j, 0.1j, -0.1j), (0.9, 0.5, 0.2, 0.1))
    assert crossing._pairs_outside(inside) == 0
    assert crossing._pairs_outside(outside) == 2
    assert crossing._crossing(inside, real) == crossing._crossing(inside, inside) == 0.5
    share = np.log(0.9) / (np.log(0.9) - np.log(1.2))
    assert share < crossing._crossing(inside, outside) < share + 0.06
    assert 1.0 - share - 0.06 < crossing._crossing(outside, inside) < 1.0 - share


@pytest.mark.parametrize("ends", [(0.1, 0.3), (0.3, 0.1)])
@pytest.mark.parametrize("grows", [True, False])
def test_a_torus_is_born_on_the_side_where_its_pair_is_outside(monkeypatch, ends, grows):
    """Known as well as its bracket where no orbit is found inside."""
    monkeypatch.setattr(crossing, "point_between", lambda *_: None)
    pairs = [(0.9j, -0.9j), (1.2j, -1.2j)]
    tangent = Direction(np.ones((1, 2)), 1.0)
    a, b = (
        Point(np.full((1, 2), value), value, np.array(pairs[(value > 0.2) == grows], complex), tangent)
        for value in ends
    )
    event = crossing._torus(SimpleNamespace(kind=Kind(2)), a, b, 5, WALK)
    assert (event.unstable, event.after, event.map) == (1.0 if grows else -1.0, 5, Kind(2))
    assert event.value == pytest.approx(0.2)
    assert event.orbit.errors[0] == pytest.approx(0.2)
    assert event.born is None
