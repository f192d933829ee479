"""Lanes that are served one by one: samples, corners, borders, the queue, and how members end."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from engine_systems import Decay, Riccati

from gelcone.motion.engine.events import Event
from gelcone.motion.engine.plan import (
    ARRIVED,
    MOST_IN_PLACE,
    NOT_FINITE,
    STEP_TOO_SMALL,
    TERMINAL_EVENT,
    TOO_MANY_STEPS,
)
from gelcone.motion.engine.program import Program

# --- members take turns -----------------------------------------------------------------------------------------------
from gelcone.motion.engine.service import PAST


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("count", [1, 7, 50])
def test_each_member_has_its_own_numbers_start_and_times_however_many_wait(count, threads):
    rng = np.random.default_rng(2)
    rate, first, size = rng.uniform(0.1, 3.0, count), rng.uniform(-2.0, 2.0, count), rng.uniform(0.1, 9.0, count)
    times = first[:, None] + np.sort(rng.uniform(0.0, 4.0, (count, 5)), axis=1)
    raw = Program(Decay(), "states", 1e-15, width=2).run({"rate": rate}, size[:, None], first, times, threads=threads)
    exact = size[:, None] * np.exp(-rate[:, None] * (times - first[:, None]))
    np.testing.assert_allclose(raw.states[..., 0], exact, rtol=1e-13)
    assert (raw.status == ARRIVED).all()
    np.testing.assert_array_equal(raw.end_state[:, 0], raw.states[:, -1, 0])
    np.testing.assert_array_equal(raw.end_time, times[:, -1])
    assert (raw.steps > 0).all()
    assert (raw.smallest_step > 0.0).all()


# --- samples ----------------------------------------------------------------------------------------------------------


def test_all_samples_within_a_step_and_at_its_ends_are_taken():
    program = Program(Decay(), "states", 1e-15)
    times = np.array([0.0, 1e-9, 0.1, 0.2, 0.2 + 1e-14, 0.21, 3.0])
    raw = program.run({"rate": 1.0}, [[2.0]], 0.0, times[None])
    np.testing.assert_allclose(raw.states[0, :, 0], 2.0 * np.exp(-times), rtol=2e-15)
    assert raw.states[0, 0, 0] == 2.0
    assert raw.end_state[0, 0] == raw.states[0, -1, 0]


def test_tangent_maps_begin_anew_at_each_sample_and_the_divergence_too():
    times = np.array([[0.5, 0.9, 2.4]])
    raw = Program(Decay(), "tangents", 1e-13).run({"rate": 0.7}, [[1.0]], 0.0, times)
    gaps = np.diff(times[0], prepend=0.0)
    np.testing.assert_allclose(raw.tangents[0, :, 0, 0], np.exp(-0.7 * gaps), rtol=1e-12)


# --- corners and pieces -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Driven:
    """x' = p0 + p1 (t - begin)."""

    states = ("x",)
    numbers = ("begin", "p0", "p1")

    def rates(self, time, state, n, xp):
        return [n["p0"] + n["p1"] * (time - n["begin"]) + 0.0 * state[0]]


def test_pieces_are_loaded_at_their_corners_in_turn_and_again_from_the_first():
    """Two members with corners of their own, one of them of no length; the last piece is followed by the first."""
    corners = np.array([[0.5, 1.25, 1.25, 2.0, np.inf], [0.25, 0.75, 1.5, 2.5, 3.5]])
    terms = np.array([[[1.0, 2.0], [-1.0, 0.5], [3.0, -2.0]], [[0.5, 0.0], [2.0, 1.0], [-4.0, 0.25]]])
    first, began = np.array([1, 2]), np.array([[0.0, 0.3, -0.2], [-0.5, 1.0, 1.0]])
    times = np.array([[0.4, 0.6, 1.25, 1.9, 3.0], [0.2, 0.8, 1.6, 2.6, 4.0]])

    def right(member):
        begin, p0, p1 = began[member]
        at, x, found = 0.0, 1.0, []
        number = first[member]
        ends = [*((corner, True) for corner in corners[member]), *((time, False) for time in times[member])]
        for end, corner in sorted(ends, key=lambda pair: (pair[0], not pair[1])):
            if end > times[member, -1]:
                continue
            x += p0 * (end - at) + 0.5 * p1 * ((end - begin) ** 2 - (at - begin) ** 2)
            at = end
            if corner:
                begin, (p0, p1) = end, terms[member, number % 3]
                number += 1
            else:
                found.append(x)
        return found

    numbers = {"begin": began[:, 0], "p0": began[:, 1], "p1": began[:, 2]}
    for keep_width in (1, 4):
        raw = Program(Driven(), "states", 1e-6, pieces=("begin", "p0", "p1"), width=keep_width).run(
            numbers, [[1.0], [1.0]], 0.0, times, corners=corners, terms=(terms, first)
        )
        np.testing.assert_allclose(raw.states[..., 0], [right(0), right(1)], rtol=1e-13)
        np.testing.assert_allclose(raw.switches["begin"], [2.0, 3.5], rtol=1e-15)
        np.testing.assert_allclose(raw.switches["p0"], [terms[0, (1 + 3) % 3, 0], terms[1, (2 + 4) % 3, 0]])
        np.testing.assert_allclose(raw.switches["p1"], [terms[0, (1 + 3) % 3, 1], terms[1, (2 + 4) % 3, 1]])


# --- borders ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("divides", [False, True])
def test_a_border_flips_its_switch_and_the_time_on_each_side_is_counted(divides):
    """Many members, few lanes: those of one law wait while the others' run."""
    events = [
        Event(lambda t, z, n, xp: n["high"] * (1.0 - z[0]), -1, "high", divides=divides),
    ]

    @dataclass(frozen=True)
    class Held:
        """x' = v, and v/3 beyond 1."""

        states = ("x",)
        numbers = ("v", "high")

        def rates(self, time, state, n, xp):
            return [n["v"] * (2.0 / 3.0 + n["high"] / 3.0) + 0.0 * state[0]]

    speeds, first = np.linspace(0.1, 2.0, 40), np.linspace(-2.0, 3.0, 40)
    program = Program(Held(), "states", 1e-6, events, width=2)
    assert len(program._plan(2).laws) == (2 if divides else 1)
    after = np.array([0.6, 1.7, 5.0])
    raw = program.run({"v": speeds, "high": 1.0}, np.zeros((40, 1)), first, first[:, None] + after)
    meets = 1.0 / speeds[:, None]
    exact = np.where(after < meets, speeds[:, None] * after, 1.0 + (after - meets) * speeds[:, None] / 3.0)
    np.testing.assert_allclose(raw.states[..., 0], exact, rtol=1e-13)
    before = np.minimum(meets[:, 0], 5.0)
    np.testing.assert_allclose(raw.dwell, np.stack([before, 5.0 - before], axis=1), rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(raw.switches["high"], np.where(meets[:, 0] < 5.0, -1.0, 1.0))


def test_places_of_the_dwell_are_the_signs_of_the_switches():
    """Switch k negative sets bit k; the clock's switches fall at times of their own, and one of them rises again."""

    @dataclass(frozen=True)
    class Clock:
        states = ("x",)
        numbers = ("a", "b")

        def rates(self, time, state, n, xp):
            return [n["a"] + 10.0 * n["b"] + 0.0 * state[0]]

    events = [
        Event(lambda t, z, n, xp: n["a"] * (1.0 - t) * (4.0 - t), -1, "a", inside=True),
        Event(lambda t, z, n, xp: n["b"] * (2.0 - t), -1, "b", inside=True),
    ]
    raw = Program(Clock(), "states", 1e-6, events).run({"a": 1.0, "b": 1.0}, [[0.0]], 0.0, [[1.5, 7.0]])
    np.testing.assert_allclose(raw.dwell[0], [1.0, 1.0, 3.0, 2.0], rtol=1e-13)  # none, a, b, both
    np.testing.assert_allclose(raw.states[0, :, 0], [11.0 + 0.5 * 9.0, 11.0 + 9.0 - 2.0 * 11.0 - 3.0 * 9.0], rtol=1e-13)
    assert (raw.switches["a"][0], raw.switches["b"][0]) == (1.0, -1.0)


def test_a_law_is_that_of_the_switches_that_divide_laws_wherever_they_stand_among_all():
    """The first border only marks its side, beyond the second one a member is half as fast."""

    @dataclass(frozen=True)
    class Slowed:
        states = ("x",)
        numbers = ("mark", "way")

        def rates(self, time, state, n, xp):
            return [0.75 + 0.25 * n["way"] + 0.0 * state[0]]

    events = [
        Event(lambda t, z, n, xp: n["mark"] * (0.5 - z[0]), -1, "mark"),
        Event(lambda t, z, n, xp: n["way"] * (1.0 - z[0]), -1, "way", divides=True),
    ]
    program = Program(Slowed(), "states", 1e-6, events)
    raw = program.run({"mark": 1.0, "way": 1.0}, [[0.0], [0.2]], 0.0, [[0.7, 1.1]] * 2)
    np.testing.assert_allclose(raw.states[..., 0], [[0.7, 1.05], [0.9, 1.15]], rtol=1e-12)
    assert program._plan(2).telling == (1,)


def test_a_member_that_starts_on_a_border_at_rest_goes_to_where_it_bends():
    """g = x - 1 = -+ t^2/2 where x' = -+ t."""
    for direction, bend in ((-1, -1.0), (-1, 1.0), (0, -1.0)):
        event = Event(lambda t, z, n, xp: z[0] - 1.0, direction)
        raw = Program(Driven(), "states", 1e-6, [event]).run(
            {"begin": 0.0, "p0": 0.0, "p1": bend}, [[1.0]], 0.0, [[2.0]]
        )
        assert raw.status[0] == ARRIVED
        assert raw.states[0, 0, 0] == pytest.approx(1.0 + 2.0 * bend, rel=1e-12)


def test_of_borders_in_one_step_the_first_counts_and_the_member_goes_on_from_there():
    raw = Program(Driven(), "states", 1e-6, [
        Event(lambda t, z, n, xp: 2.0 - z[0], -1),
        Event(lambda t, z, n, xp: 0.5 - z[0], -1),
        Event(lambda t, z, n, xp: z[0] - 1.0, 1),
    ]).run({"begin": 0.0, "p0": 1.0, "p1": [0.0, 0.0]}, [[0.0], [0.7]], 0.0, [[0.1, 9.0]] * 2)  # fmt: skip
    np.testing.assert_array_equal(raw.status, [TERMINAL_EVENT + 1, TERMINAL_EVENT + 2])
    np.testing.assert_allclose(raw.end_time, [0.5, 0.3], rtol=1e-14)
    np.testing.assert_allclose(raw.end_state[:, 0], [0.5, 1.0], rtol=1e-14)
    np.testing.assert_allclose(raw.states[:, 0, 0], [0.1, 0.8], rtol=1e-14)
    assert np.isnan(raw.states[:, 1]).all()


def test_a_border_met_at_the_time_of_another_counts_for_the_first_of_them_and_then_for_the_other():
    """Both switches flip at t = 1."""

    @dataclass(frozen=True)
    class Both:
        states = ("x",)
        numbers = ("a", "b")

        def rates(self, time, state, n, xp):
            return [n["a"] + 10.0 * n["b"] + 0.0 * state[0]]

    events = [Event(lambda t, z, n, xp, name=name: n[name] * (1.0 - t), -1, name, inside=True) for name in "ab"]
    raw = Program(Both(), "states", 1e-6, events).run({"a": 1.0, "b": 1.0}, [[0.0]], 0.0, [[3.0]])
    assert raw.states[0, 0, 0] == pytest.approx(11.0 - 22.0, rel=1e-13)
    np.testing.assert_allclose(raw.dwell[0], [1.0, 0.0, 0.0, 2.0], atol=1e-13)


@dataclass(frozen=True)
class Sliding:
    """x' = -s: s drives x back to 0 from either side."""

    states = ("x",)
    numbers = ("s",)

    def rates(self, time, state, n, xp):
        return [-n["s"] + 0.0 * state[0]]


def test_a_member_that_switches_on_and_on_in_place_ends_there():
    event = Event(lambda t, z, n, xp: n["s"] * z[0], -1, "s", inside=True)
    raw = Program(Sliding(), "states", 1e-6, [event]).run({"s": 1.0}, [[0.7]], 0.0, [[2.0]])
    assert raw.status[0] == TERMINAL_EVENT
    assert raw.end_time[0] == pytest.approx(0.7, rel=1e-12)
    assert MOST_IN_PLACE < raw.steps[0] < 2 * MOST_IN_PLACE


def test_many_switches_with_time_between_them_end_nothing():
    """More than may be in place."""

    @dataclass(frozen=True)
    class Turning:
        states = ("x", "u", "w")
        numbers = ("s",)

        def rates(self, time, state, n, xp):
            return [state[1], -state[0], n["s"]]

    event = Event(lambda t, z, n, xp: n["s"] * z[0], -1, "s", inside=True)
    turns = 2 * MOST_IN_PLACE
    raw = Program(Turning(), "states", 1e-12, [event]).run({"s": 1.0}, [[1.0, 0.0, 0.0]], 0.0, [[turns * math.pi]])
    assert raw.status[0] == ARRIVED
    assert raw.states[0, 0, 2] == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(raw.dwell[0], 0.5 * turns * math.pi, rtol=1e-8)


def test_a_member_that_starts_on_a_border_has_crossed_it_or_crosses_it_as_its_motion_leads():
    program = Program(Driven(), "states", 1e-6, [Event(lambda t, z, n, xp: z[0] - 1.0, -1)])
    numbers = {"begin": 0.0, "p0": [1.0, -1.0, 1.0], "p1": [0.0, 0.0, -1.0]}
    raw = program.run(numbers, [[1.0]] * 3, 0.0, [[5.0]] * 3)
    np.testing.assert_array_equal(raw.status, [ARRIVED, ARRIVED, TERMINAL_EVENT])
    assert raw.end_time[2] == pytest.approx(2.0, rel=1e-14)  # t - t^2/2 = 0


@pytest.mark.parametrize(("direction", "ends"), [(-1, 1.5), (1, 0.5), (0, 0.5)])
def test_a_border_in_the_direction_that_does_not_count_is_passed(direction, ends):
    """g = -(t - 1/2)(t - 3/2): rises at 1/2, falls at 3/2."""
    event = Event(lambda t, z, n, xp: -(t - 0.5) * (t - 1.5), direction)
    raw = Program(Decay(), "states", 1e-10, [event]).run({"rate": 0.1}, [[1.0]], 0.0, [[5.0]])
    assert raw.end_time[0] == pytest.approx(ends, rel=1e-13)
    assert raw.end_state[0, 0] == pytest.approx(math.exp(-0.1 * ends), rel=1e-10)


@dataclass(frozen=True)
class Rooted:
    """x' = y with y = sqrt(1 - t): no root beyond t = 1."""

    states = ("x",)
    numbers = ()

    def root(self, time, xp, name="y"):
        return xp.root(name, lambda y, t, xp: y - xp.sqrt(1.0 - t), [time], lambda t, xp: 1.0 + 0.0 * t)

    def rates(self, time, state, n, xp):
        return [self.root(time, xp) + 0.0 * state[0]]


def test_a_member_whose_rates_are_lost_with_a_root_ends_by_the_first_border_that_is_made_of_it():
    """Before it, steps grow ever shorter; where it is lost from the start on, the member stays there."""
    system = Rooted()
    far = Event(lambda t, z, n, xp: 9.0 + z[0], -1, inside=True)
    borders = [Event(lambda t, z, n, xp, k=k: k + system.root(t, xp), -1, inside=True) for k in (1.0, 2.0)]
    for events, status in (([far, *borders], TERMINAL_EVENT + 1), ([borders[1], far], TERMINAL_EVENT)):
        raw = Program(system, "states", 1e-10, events).run({}, [[1.0]], 2.0, [[5.0]])
        assert raw.status[0] == status
        assert (raw.end_time[0], raw.end_state[0, 0]) == (2.0, 1.0)
    raw = Program(system, "states", 1e-10, [far]).run({}, [[1.0]], 2.0, [[5.0]])
    assert raw.status[0] == NOT_FINITE
    raw = Program(system, "states", 1e-10, borders).run({}, [[1.0]], 0.0, [[5.0]], smallest_step=1e-9)
    assert raw.status[0] == STEP_TOO_SMALL
    assert raw.end_time[0] == pytest.approx(1.0, abs=1e-6)
    assert raw.end_state[0, 0] == pytest.approx(1.0 + 2.0 / 3.0, abs=1e-6)


# --- how members end --------------------------------------------------------------------------------------------------


def test_what_ends_a_member_is_told_apart():
    """x' = x^2 from 1 is infinite at t = 1."""
    program = Program(Riccati(), "states", 1e-10)
    given = {}, [[1.0]], 0.0, [[0.5, 2.0]]
    small = program.run(*given, smallest_step=1e-3)
    assert small.status[0] == STEP_TOO_SMALL
    assert small.smallest_step[0] < 1e-3
    few = program.run(*given, smallest_step=1e-3, most_steps=5)
    assert few.status[0] == TOO_MANY_STEPS
    assert few.steps[0] == 5
    lost = program.run({}, [[np.nan]], 0.0, [[0.5, 2.0]], smallest_step=1e-3)
    assert lost.status[0] == NOT_FINITE
    assert lost.end_time[0] == 0.0
    # a step that is too short does not count: the member is where it began
    before = program.run({}, [[1.0]], 0.0, [small.end_time])
    assert small.end_state[0, 0] == pytest.approx(before.states[0, 0, 0], rel=1e-12)
    wanted = program.label ** (1.0 / (program.order - 1))  # x_k = x_0^(k + 1), so that h = c/x_0
    assert small.smallest_step[0] == pytest.approx(wanted / small.end_state[0, 0], rel=1e-3)


def test_the_last_step_may_be_short_and_one_that_arrives_has_not_spent_its_steps():
    program = Program(Decay(), "states", 1e-10)
    raw = program.run({"rate": 1.0}, [[1.0]], 0.0, [[1e-12]], smallest_step=1e-6, most_steps=1)
    assert raw.status[0] == ARRIVED
    assert raw.steps[0] == 1
    assert raw.smallest_step[0] > 0.1


def test_a_border_met_in_the_last_step_that_is_allowed_counts():
    event = Event(lambda t, z, n, xp: 0.5 - t, -1)
    program = Program(Decay(), "states", 1e-10, [event])
    raw = program.run({"rate": 0.1}, [[1.0]], 0.0, [[5.0]], most_steps=1)
    assert (raw.status[0], raw.steps[0]) == (TERMINAL_EVENT, 1)
    assert raw.end_time[0] == pytest.approx(0.5, rel=1e-14)


def test_roots_begin_anew_under_another_law():
    """Beyond x = 1 the root of another equation counts, which has no value near the last one's."""

    @dataclass(frozen=True)
    class Sided:
        states = ("x",)
        numbers = ("s",)

        def rates(self, time, state, n, xp):
            beyond = 0.5 - 0.5 * n["s"]
            y = xp.root(
                "y",
                lambda y, x, xp: (y - 2.0 - x) * (1.0 + y * y),
                [state[0]],
                lambda x, xp: 2.0 + 0.0 * x,
            )
            z = xp.root("z", lambda z, x, xp: z * z * z - x, [state[0]], lambda x, xp: 1.0 + 0.0 * x)
            return [(1.0 - beyond) * y + beyond * z]

    event = Event(lambda t, z, n, xp: n["s"] * (1.0 - z[0]), -1, "s", inside=True)
    for divides in (False, True):
        program = Program(Sided(), "states", 1e-10, [replace(event, divides=divides)])
        raw = program.run({"s": 1.0}, [[0.1]], 0.0, [[2.0]])
        meets = math.log(3.0 / 2.1)  # x' = x + 2
        # then x' = x^(1/3): x^(2/3) = 1 + 2 (t - meets)/3
        assert raw.states[0, 0, 0] == pytest.approx((1.0 + 2.0 * (2.0 - meets) / 3.0) ** 1.5, rel=1e-9)


def test_members_that_fail_make_room_for_others():
    """x' = x^2 is infinite at 1/x_0."""
    start = np.where(np.arange(30) % 3 == 0, 0.7, 0.4)
    program = Program(Riccati(), "states", 1e-10, width=2)
    raw = program.run({}, start[:, None], 0.0, np.full((30, 1), 2.0), smallest_step=1e-3)
    np.testing.assert_array_equal(raw.status, np.where(start == 0.7, STEP_TOO_SMALL, ARRIVED))
    np.testing.assert_allclose(raw.states[start == 0.4, 0, 0], 0.4 / (1.0 - 0.8), rtol=1e-8)


@pytest.mark.parametrize("divides", [False, True])
def test_a_member_passes_a_gentle_border_whose_switch_flips_by_rounding(divides):
    """x' = v; within 1e-9 of 1 the function, which is rounded badly there, is beyond the border with either sign."""

    @dataclass(frozen=True)
    class Steady:
        states = ("x",)
        numbers = ("v", "s")

        def rates(self, time, state, n, xp):
            return [n["v"] + 0.0 * state[0]]

    def border(time, state, n, xp):
        return n["s"] * (1.0 - state[0]) - 1e-9

    found = {}
    for gentle in (False, True):
        event = Event(border, -1, "s", inside=True, divides=divides, gentle=gentle)
        program = Program(Steady(), "states", 1e-6, [event])
        found[gentle] = program.run({"v": [0.5, 1.0], "s": 1.0}, [[0.0], [0.0]], 0.0, [[0.5, 3.0]] * 2)
    ends, passes = found[False], found[True]
    np.testing.assert_array_equal(ends.status, TERMINAL_EVENT)
    np.testing.assert_allclose(ends.end_time, [2.0, 1.0], rtol=1e-8)
    np.testing.assert_array_equal(passes.status, ARRIVED)
    np.testing.assert_allclose(passes.states[..., 0], [[0.25, 1.5], [0.5, 3.0]], rtol=1e-14)
    np.testing.assert_array_equal(passes.switches["s"], -1.0)
    longest = 2.0
    np.testing.assert_allclose(passes.dwell, [[2.0, 1.0], [1.0, 2.0]], rtol=0.0, atol=1.01 * PAST * longest)
    assert passes.steps.max() < 3 * MOST_IN_PLACE
