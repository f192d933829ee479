"""One branch: the same whatever its steps, its events between its points, its exponents those of its multipliers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import gelcone
from gelcone.atlas.branches import follow
from gelcone.atlas.branches.branch import Ending, EventKind, Walk
from gelcone.atlas.branches.checkpoint import Checkpoint
from gelcone.atlas.branches.point import Metric
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.orbit import Kind
from gelcone.presets import find_preset
from tests.atlas.branches import maps
from tests.atlas.branches.events import events_of
from tests.recorded import numbers

BASE = find_preset("base").model
SPRING = find_preset("spring").model.replace(damping_ratio=0.01)


def branches(**changes):
    """Rest of the base set and the orbits born where it loses stability; a resonance of the spring set with two folds.
    ``changes`` are those of the constants of the module."""
    with pytest.MonkeyPatch.context() as patched:
        for name, value in changes.items():
            patched.setattr(follow, name, value)
        return [
            gelcone.continue_branch(BASE, "voltage", 0.95, 1.03, switch=1, checks=2),
            gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 0.8, start="settled", switch=0, checks=2),
        ]


@pytest.fixture(scope="module")
def usual():
    return branches()


@pytest.fixture(scope="module")
def voltages():
    """Branches of the base set, some of which begin within their interval."""
    diagram = gelcone.bifurcation(BASE, "voltage", [1.005, 1.015], sweeps=(), bisections=0)
    return gelcone.continue_branch(BASE, "voltage", 0.98, 1.03, start=diagram, switch=0, checks=2)


@pytest.fixture(scope="module")
def frequencies():
    """A branch that begins within its interval, with two events on the way forward and two on the way back."""
    diagram = gelcone.bifurcation(SPRING, "drive_frequency", [0.7, 0.75], sweeps=(), bisections=0)
    return gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 1.2, start=diagram, switch=0, checks=2)


def facts(result):
    """What a branch is, without its points: events with their errors, and ends."""
    events = sorted((e["kind"], e["period"], e["value"], e["value_error"]) for e in events_of(result))
    return events, sorted(map(tuple, np.sort(result["ended"].values).tolist()))


@pytest.mark.parametrize(
    "steps",
    [{"LONGEST_STEP": 0.01}, {"FIRST_STEP": 0.05}, {"FIRST_STEP": 3.0, "LONGEST_STEP": 3.0, "AIM": 10.0}],
    ids=["a quarter of the longest", "ten times the first", "so long that they must be refused"],
)
def test_a_branch_does_not_depend_on_its_steps(usual, steps):
    for one, other in zip(usual, branches(**steps), strict=True):
        (events, ends), (others, their_ends) = facts(one), facts(other)
        assert len(events) >= 2
        assert [event[:2] for event in others] == [event[:2] for event in events]
        for (*_, value, error), (*_, found, its_error) in zip(events, others, strict=True):
            assert abs(value - found) <= 3.0 * (error + its_error)
        assert their_ends == ends


def test_the_curvature_of_an_event_is_that_of_the_branch_that_leaves_it(usual):
    """The value changes by the curvature times the squared amplitude: of the branch itself at a fold, else of the one
    that is born. Nearby, the next power of the amplitude is a few per cent of that."""
    kinds = set()
    for result in usual:
        for k, event in enumerate(events_of(result)):
            leaving = event["branch"] if event["kind"] == "fold" else event["born_branch"]
            if leaving is None:
                continue
            orbit = result["event_orbit"].values[k]
            count = int(np.isfinite(orbit[:, 0]).sum())
            apart = np.abs(result["orbit"].values[leaving, :, :count] - orbit[:count]).max(axis=(1, 2))
            near = np.nanargmin(np.where(apart > 1e-3, apart, np.nan))
            change = float(result["value"][leaving, near]) - event["value"]
            assert change / apart[near] ** 2 == pytest.approx(float(result["event_curvature"][k]), rel=0.05)
            kinds.add(event["kind"])
    assert kinds == {"fold", "loss of rest", "symmetry breaking", "period doubling"}


def outside(result, branch, point):
    multipliers = result["multiplier_real"].values[branch, point] + 1j * result["multiplier_imag"].values[branch, point]
    return int((np.abs(multipliers) > 1.0).sum())


@pytest.mark.parametrize("which", ["voltages", "frequencies"])
def test_each_event_lies_between_its_points_and_nothing_changes_elsewhere(which, request):
    """From one point to the next as many multipliers pass the unit circle, modulo 2, as there are events."""
    result = request.getfixturevalue(which)
    value = result["value"].values
    at = list(zip(result["event_branch"].values, result["event_point"].values, strict=True))
    assert len(at) >= 3
    for k, (branch, point) in enumerate(at):
        ends = np.sort(value[branch, point : point + 2])
        if result["event_kind"].values[k] != EventKind.FOLD:
            assert ends[0] <= result["event_value"].values[k] <= ends[1]
        near = result["orbit"].values[branch, [point, point + 1], 0]
        assert np.isfinite(near).all()
    for branch in range(result.sizes["branch"]):
        count = int(np.isfinite(value[branch]).sum())
        changes = [outside(result, branch, k) - outside(result, branch, k + 1) for k in range(count - 1)]
        events = [at.count((branch, k)) for k in range(count - 1)]
        # the ends of a branch lie on the event where it is born or merges
        np.testing.assert_array_equal(np.array(changes)[1:-1] % 2, np.array(events)[1:-1] % 2)


@pytest.mark.parametrize("which", ["voltages", "frequencies"])
def test_the_exponent_is_that_of_the_largest_multiplier_over_the_period(which, request):
    """ln |multiplier| / period at each point; without bias the forcing has half the period of the voltage."""
    result = request.getfixturevalue(which)
    over_frequency = which == "frequencies"
    for branch in range(result.sizes["branch"]):
        own = result.isel(branch=branch)
        drive = own["value"] if over_frequency else BASE.drive_frequency
        largest = np.hypot(own["multiplier_real"], own["multiplier_imag"]).max("multiplier")
        period = int(own["period"]) * np.pi / drive
        np.testing.assert_allclose(own["lyapunov"], np.log(largest) / period, rtol=1e-12)


def test_a_time_average_gives_the_same_exponent(frequencies):
    """Where a stable orbit does not lose half of what damping takes."""
    own = frequencies.isel(branch=0)
    rate = own["lyapunov"].where(own["stable"] == 1).values
    at = int(np.nanargmin(np.abs(rate + 0.004)))
    model = SPRING.replace(drive_frequency=float(own["value"][at]))
    average = gelcone.lyapunov(model, own["orbit"].values[at, 0], transient=50.0)
    assert abs(rate[at] + 0.01) > 0.003
    assert abs(rate[at] - float(average["lyapunov"].max())) < 3.0 * float(average["standard_error"].max()) + 1e-6


def test_multipliers_of_rest_are_those_of_the_linearised_equation(voltages):
    (rest,) = np.flatnonzero(voltages["resting"].values)
    for point in (5, 60, 120):
        own = voltages.isel(branch=int(rest), point=point)
        found = own["multiplier_real"].values + 1j * own["multiplier_imag"].values
        expected = gelcone.floquet_multipliers(BASE.replace(voltage=float(own["value"])))
        expected = expected["multiplier_real"].values + 1j * expected["multiplier_imag"].values
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("highest", [2.4, 2.45])
def test_two_doublings_within_one_step_are_found(highest):
    """A multiplier is beyond -1 over 0.8 % of the drive frequency only, narrower than the usual steps."""
    model = gelcone.ConeModel(
        damping_ratio=0.15045,
        spring_stiffness=0.6356,
        rest_height=0.2152,
        voltage=0.7115,
        voltage_bias=0.4025,
        prestretch=1.5782,
        stretch_limit=20.0,
        drive_frequency=1.7,
    )
    found = gelcone.continue_branch(model, "drive_frequency", 0.9, highest, start="settled", switch=0, checks=2)
    assert [event["kind"] for event in events_of(found)] == ["period doubling"] * 2
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(follow, "LONGEST_STEP", 0.004)
        fine = gelcone.continue_branch(model, "drive_frequency", 1.8, 1.95, start="settled", switch=0, checks=2)
    for one, other in zip(events_of(found), events_of(fine), strict=True):
        assert one["value"] == pytest.approx(other["value"], abs=1e-9)


def test_folds_of_a_film_that_drags_have_the_trace_of_their_orbit():
    """Two states, whose areas shrink by more than the disc's damping: by what is integrated along the orbit."""
    own = {"relaxation_time_1": 0.001, "viscous_modulus_1": 0.5, "reduced": "relaxation_time_1"}
    model = SPRING.replace(**own)
    found = gelcone.continue_branch(model, "drive_frequency", 0.45, 0.8, start="settled", switch=0, checks=2)
    events = events_of(found)
    assert [event["kind"] for event in events] == ["fold", "fold"]
    for k, event in enumerate(events):
        at = model.replace(drive_frequency=event["value"])
        run = integrate(at, found["event_orbit"].values[k, 0], at.members().forcing_period, keep="tangents")
        product = np.prod(np.array(event["multipliers"])[:, 0])
        assert product == pytest.approx(np.exp(run.divergence[0, -1]), rel=1e-8)


# --- made-up maps: a branch is a curve that is known by a formula -----------------------------------------------------


def s_of(branch):
    return np.array([point.nodes[0, 0] for point in branch.points]) - maps.AWAY


def s_branch(s=1.2, low=-3.0, high=3.0, turned=False, most=2000, **own):
    world = maps.Maps(maps.s_curve, **own)
    start = maps.orbit_at(world, maps.value_of(s), s + maps.AWAY)
    start = replace(start, tangent=-start.tangent) if turned else start
    return follow.follow(world, start, Walk(low, high, most))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("s", [1.2, 0.4, -1.5])
def test_a_branch_goes_through_its_folds_from_one_end_of_the_interval_to_the_other(s, turned):
    """Wherever and whichever way it begins: orbits, multipliers and tangents are those of the formula."""
    branch = s_branch(s, turned=turned)
    at, way = s_of(branch), np.sign(s_of(branch)[-1] - s_of(branch)[0])
    assert (way * np.diff(at) > 0.0).all()
    np.testing.assert_allclose(branch.values, maps.value_of(at), atol=1e-12)
    assert sorted((branch.points[0].value, branch.points[-1].value)) == [-3.0, 3.0]
    assert branch.ended == (Ending.LIMIT, Ending.LIMIT)
    for point, own in zip(branch.points, at, strict=True):
        found = sorted(point.multipliers, key=abs, reverse=True)
        np.testing.assert_allclose(np.abs(found), np.abs(maps.multipliers_at(1.0 - (3.0 * own**2 - 3.0))), rtol=1e-5)
        tangent = way * point.tangent.nodes[0]
        assert tangent[0] == pytest.approx(tangent[1], rel=1e-9)
        assert tangent[0] > 0.0
        assert way * point.tangent.value / tangent[0] == pytest.approx(3.0 * own**2 - 3.0, abs=1e-5)
    assert np.diff(branch.values).min() < 0.0 < np.diff(branch.values).max()


def test_events_of_a_branch_are_where_the_formula_has_them():
    """Each between the points on either side of it, in the order of the branch, with errors that hold; both ways."""
    for turned in (False, True):
        branch = s_branch(turned=turned)
        at, way = s_of(branch), np.sign(s_of(branch)[-1] - s_of(branch)[0])
        expected = [(EventKind.PERIOD_DOUBLING, maps.DOUBLES_AT), (EventKind.FOLD, 1.0)]
        expected += [(kind, -s) for kind, s in reversed(expected)]
        assert [event.kind for event in branch.events] == [kind for kind, _ in expected]
        for event, (kind, s) in zip(branch.events, expected if way < 0.0 else expected[::-1], strict=True):
            assert abs(event.value - maps.value_of(s)) <= 3.0 * event.orbit.errors[0] < 1e-12
            assert event.orbit.nodes[0, 0] == pytest.approx(s + maps.AWAY, abs=1e-9)
            assert way * at[event.after] <= way * s <= way * at[event.after + 1]
            doubles = kind == EventKind.PERIOD_DOUBLING
            assert event.unstable == (np.sign(s) if doubles else 0.0)
            assert event.supercritical == (True if doubles else None)
            curvature = 3.0 * s - 1.0 / (3.0 * s) if doubles else 3.0 * s
            assert event.born.curvature == pytest.approx(curvature, rel=1e-7)


def test_a_closed_branch_ends_where_it_began():
    world = maps.Maps(maps.isola)
    branch = follow.follow(world, maps.orbit_at(world, 0.1, maps.AWAY + 0.995), Walk(-3.0, 3.0))
    assert branch.ended == (Ending.CLOSED, Ending.CLOSED)
    np.testing.assert_allclose(s_of(branch) ** 2 + branch.values**2, 1.0, atol=1e-12)
    angles = np.unwrap(np.arctan2(branch.values, s_of(branch)))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi)
    assert branch.points[-1] is branch.points[0]
    assert sorted(event.value for event in branch.events) == pytest.approx([-1.0, 1.0])


@pytest.mark.parametrize(("pulled_in", "ended"), [(False, Ending.WALL), (True, Ending.PULLED_IN)])
def test_a_branch_ends_where_the_film_has_no_state(monkeypatch, pulled_in, ended):
    monkeypatch.setattr(maps.Maps, "pulled_in", pulled_in)
    branch = s_branch(reach=maps.AWAY + 1.8)
    assert set(branch.ended) == {ended, Ending.LIMIT}
    assert s_of(branch).max() == pytest.approx(1.8, abs=1e-6)


def test_a_branch_ends_where_its_values_make_no_actuator(monkeypatch):
    def run(self, nodes, values):
        if values[0] > 0.37:
            raise InputError("there is none")
        return own(self, nodes, values)

    own = maps.Maps.run
    world = maps.Maps(maps.pitchfork, symmetric=True)
    start = maps.orbit_at(world, 0.2, np.sqrt(0.2))
    monkeypatch.setattr(maps.Maps, "run", run)
    branch = follow.follow(world, start, Walk(-1.0, 1.0))
    assert branch.ended == (Ending.REST, Ending.IMPOSSIBLE)
    assert branch.values.max() == pytest.approx(0.37, abs=1e-6)


def test_a_branch_has_at_most_so_many_points_each_way():
    branch = s_branch(most=7)
    assert branch.ended == (Ending.POINTS, Ending.POINTS)
    assert len(branch.points) == 13


def test_a_branch_that_is_born_at_rest_ends_there():
    """x^2 = p; beyond it would be its own mirror image."""
    world = maps.Maps(maps.pitchfork, symmetric=True)
    branch = follow.follow(world, maps.orbit_at(world, 0.5, np.sqrt(0.5)), Walk(-1.0, 1.0))
    assert branch.ended == (Ending.REST, Ending.LIMIT)
    np.testing.assert_allclose(branch.values, np.array([p.nodes[0, 0] for p in branch.points]) ** 2, atol=1e-12)
    assert 0.0 < branch.values[0] < 0.02
    assert branch.events == []


def test_a_branch_of_cycles_of_two_merges_where_they_were_born():
    x, value = maps.cycle_of(0.3)
    world = maps.Maps(maps.s_curve, Kind(2))
    branch = follow.follow(world, maps.orbit_at(world, value, *x), Walk(-1.9, 0.0))
    assert branch.ended == (Ending.MERGED, Ending.LIMIT)
    ((kind, merge),) = branch.merges
    doubling = maps.value_of(maps.DOUBLES_AT)
    assert kind == Kind(1)
    assert merge.values[0] == pytest.approx(doubling, abs=1e-11)
    assert branch.points[0].value == pytest.approx(doubling, abs=1e-11)
    np.testing.assert_allclose(branch.points[0].nodes, maps.nodes_of(*2 * [maps.AWAY + maps.DOUBLES_AT]), atol=1e-9)
    for point in branch.points:
        h = 0.5 * abs(point.nodes[0, 0] - point.nodes[2, 0])
        assert point.value == pytest.approx(maps.cycle_of(h)[1], abs=1e-9)
    slope = [lambda h, sign=sign: 1.0 - (3.0 * (maps.cycle_of(h)[0][sign] - maps.AWAY) ** 2 - 3.0) for sign in (0, 1)]
    even = (1.0 - maps.SHRINKS) / (1.0 + maps.SHRINKS)
    h = brentq(lambda h: slope[0](h) * slope[1](h) + even**2, 0.01, 0.5)
    (event,) = branch.events
    assert (event.kind, event.unstable) == (EventKind.PERIOD_DOUBLING, 1.0)
    assert event.value == pytest.approx(maps.cycle_of(h)[1], abs=1e-11)


def test_rest_is_followed_in_small_steps_to_where_it_loses_its_stability():
    for rule, at in ((maps.pitchfork, 1.0), (maps.mirrored_pitchfork, -1.0)):
        world = maps.Maps(rule, symmetric=True)
        branch = follow.follow(world, maps.orbit_at(world, -1.0, 0.0), Walk(-1.0, 1.0), both_ways=False, resting=True)
        assert branch.resting
        assert not np.any([point.nodes for point in branch.points])
        (event,) = branch.events
        assert (event.kind, event.unstable, event.orbit.at) == (EventKind.LOSS_OF_REST, 1.0, at)
        assert abs(event.value) <= event.orbit.errors[0] < 1e-12
        assert event.born.curvature == pytest.approx(1.0, rel=1e-6)
        assert event.supercritical
        assert np.diff(branch.values).max() < 0.03


def test_a_guess_at_the_border_that_is_far_off_is_not_trusted(monkeypatch):
    """It may have led to another branch; one that is near is the end of the branch, going the same way."""
    world, walk = maps.Maps(maps.s_curve), Walk(-3.0, 2.5)
    here, beyond = (maps.orbit_at(world, maps.value_of(s), maps.AWAY + s) for s in (2.08, 2.12))
    metric = Metric.of(here.nodes, walk.scale)
    for sign in (1.0, -1.0):
        ahead = replace(beyond, tangent=beyond.tangent if sign > 0.0 else -beyond.tangent)
        last = follow._at_border(world, here, ahead, walk, metric)
        assert last.value == 2.5
        assert np.sign(last.tangent.value) == sign
    found = follow.at_value(world, beyond.nodes, 2.5, metric)
    monkeypatch.setattr(follow, "at_value", lambda *_: replace(found, step=2.0 * follow.LARGEST_GUESS_ERROR))
    assert follow._at_border(world, here, beyond, walk, metric) is None


@pytest.mark.parametrize("turned", [False, True])
def test_a_branch_that_starts_on_the_end_of_the_interval_goes_one_way_alone(turned):
    """Inwards it is followed, outwards it has ended already."""
    world, walk = maps.Maps(maps.s_curve), Walk(maps.value_of(2.08), 3.0)
    start = maps.orbit_at(world, maps.value_of(2.08), maps.AWAY + 2.08)
    start = replace(start, value=walk.low, tangent=-start.tangent if turned else start.tangent)
    branch = follow.follow(world, start, walk)
    assert branch.ended == (Ending.LIMIT, Ending.LIMIT)
    assert branch.values[-1 if turned else 0] == walk.low
    assert branch.values[0 if turned else -1] == pytest.approx(3.0)
    assert (np.diff(branch.values) > 0.0).all() != turned


@pytest.mark.parametrize(("off", "longer"), [(0.5, 2.0**0.25), (4.0, 0.5**0.5), (1e-6, 1.7)])
def test_steps_are_made_so_long_that_the_next_guess_is_as_far_off_as_it_should_be(monkeypatch, off, longer):
    """What is left of a cubic grows with the fourth power of the step."""
    world, correct = maps.Maps(maps.s_curve), follow.correct
    way = Checkpoint([maps.orbit_at(world, maps.value_of(1.5), maps.AWAY + 1.5)], 0.01)
    monkeypatch.setattr(follow, "correct", lambda *given: replace(correct(*given), step=off * follow.AIM))
    follow._take_step(world, way, Walk(-3.0, 3.0), False)
    assert (len(way.points), way.step) == (2, pytest.approx(0.01 * longer))


def test_the_guess_at_the_border_lies_where_the_step_passes_it(monkeypatch):
    world, guesses = maps.Maps(maps.s_curve), []
    here, beyond = (maps.orbit_at(world, maps.value_of(s), maps.AWAY + s) for s in (2.0, 2.1))
    monkeypatch.setattr(
        follow, "at_value", lambda shooting, nodes, *rest: guesses.append(nodes) or follow.Corrected(None)
    )
    border = maps.value_of(2.02)
    assert follow._at_border(world, here, beyond, Walk(-3.0, border), Metric.of(here.nodes, 6.0)) is None
    assert guesses[0][0, 0] - maps.AWAY == pytest.approx(2.02, abs=1e-3)


@pytest.mark.parametrize("same_way", [True, False])
def test_a_branch_closes_only_where_it_goes_the_same_way_as_it_began(same_way):
    """It may cross itself."""
    world, places = maps.Maps(maps.s_curve), (1.5, 1.4, 1.495, 1.505)
    points = [maps.orbit_at(world, maps.value_of(s), maps.AWAY + s) for s in places]
    if not same_way:
        points[-1] = replace(points[-1], tangent=-points[-1].tangent)
    assert follow._closes(points, Metric.of(points[0].nodes, 6.0), 0.04) == same_way


def test_how_far_the_halves_of_an_orbit_are_apart_for_each_map_of_half_its_repeats():
    half = numbers(2, 2)
    for kind, symmetric in ((Kind(2), True), (Kind(2), False)):
        found = dict(follow.halves_apart(maps.Maps(maps.s_curve, kind, symmetric=symmetric), np.vstack([half, -half])))
        np.testing.assert_array_equal(found.pop(Kind(1)), -2.0 * half)
        assert [(own, apart.any()) for own, apart in found.items()] == ([(Kind(1, True), False)] if symmetric else [])
    for kind in (Kind(3), Kind(2, True)):
        assert follow.halves_apart(maps.Maps(maps.s_curve, kind, symmetric=True), numbers(6, 2)) == []
