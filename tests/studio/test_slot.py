"""A slot does the newest request of each side, one after the other; what runs has its grace. No time passes here: the
clock of the loop advances by itself wherever all wait."""

import asyncio

import numpy as np
import pytest

from gelcone.studio import slot as slots
from gelcone.studio.slot import GRACE, Slot


class Loop(asyncio.SelectorEventLoop):
    """A loop with a clock of its own."""

    def __init__(self):
        super().__init__()
        self.now, select = 0.0, self._selector.select

        def selected(timeout):
            found = select(0)
            self.now += 0.0 if found else timeout
            return found

        self._selector.select = selected

    def time(self):
        return self.now


@pytest.fixture
def ran(monkeypatch):
    """Runs a story next to a slot whose work takes some seconds, unless it is stopped: side, request, end and moment of
    each."""

    def of(story, *, patient=False, work=None, seconds=0.0):
        loop, done = Loop(), []
        monkeypatch.setattr(slots.time, "monotonic", loop.time)

        async def usual(side, request):
            end = loop.time() + (10.0 if request == "long" else seconds)
            while loop.time() < end:
                await asyncio.sleep(1e-3)
                if own.watch.stop.is_set():
                    done.append((side, request, "stopped", loop.time()))
                    raise slots.Stopped
            done.append((side, request, "done", loop.time()))

        async def main():
            running = asyncio.create_task(own.run())
            await story(own, *([] if work is None else [done]))
            own.end()
            running.cancel()

        own = Slot(usual if work is None else lambda side, request: work(own, done, side, request), patient=patient)
        loop.run_until_complete(main())
        loop.close()
        return [entry[:3] for entry in done], [entry[3] for entry in done]

    return of


def test_what_waits_is_replaced_by_what_is_newer_of_its_side(ran):
    async def story(own):
        for side, request in (("a", 1), ("a", 2), ("b", 3), ("a", 4)):
            own.give(side, request)
        await asyncio.sleep(0.05)

    assert ran(story)[0] == [("a", 4, "done"), ("b", 3, "done")]


def test_what_runs_is_stopped_once_its_grace_is_over_and_not_before(ran):
    async def story(own):
        own.give("a", "long")
        await asyncio.sleep(0.4 * GRACE)
        own.give("a", 2)
        await asyncio.sleep(0.5 * GRACE)
        assert not own.overtaken
        assert not own.watch.stop.is_set()
        await asyncio.sleep(GRACE)

    found, moments = ran(story)
    assert found == [("a", "long", "stopped"), ("a", 2, "done")]
    assert moments[0] == pytest.approx(GRACE, abs=2e-3)


def test_what_has_had_its_grace_is_stopped_at_once(ran):
    async def story(own):
        own.give("a", "long")
        await asyncio.sleep(2.5 * GRACE)
        assert not own.overtaken
        own.give("a", 2)
        assert own.overtaken
        await asyncio.sleep(0.5 * GRACE)

    found, moments = ran(story)
    assert found == [("a", "long", "stopped"), ("a", 2, "done")]
    assert moments[0] == pytest.approx(2.5 * GRACE, abs=2e-3)


def test_the_grace_is_that_of_what_runs_and_not_of_what_ran_before(ran):
    """What came while the first ran would have stopped it at the end of its grace, but it ended before."""

    async def story(own):
        own.give("a", 1)
        await asyncio.sleep(0.4 * GRACE)
        own.give("a", "long")
        await asyncio.sleep(0.3 * GRACE)
        own.give("a", 3)
        await asyncio.sleep(4.0 * GRACE)

    found, moments = ran(story, seconds=0.6 * GRACE)
    assert found == [("a", 1, "done"), ("a", "long", "stopped"), ("a", 3, "done")]
    np.testing.assert_allclose(moments, np.array([0.6, 1.6, 2.2]) * GRACE, atol=5e-3)


def test_another_side_waits_for_what_runs(ran):
    async def story(own):
        own.give("a", 1)
        await asyncio.sleep(0.1 * GRACE)
        own.give("b", 2)
        await asyncio.sleep(5.0 * GRACE)

    assert ran(story, seconds=2.0 * GRACE)[0] == [("a", 1, "done"), ("b", 2, "done")]


@pytest.mark.parametrize(
    ("patient", "ends"), [(True, ["stopped", "done", "done"]), (False, ["stopped", "stopped", "done"])]
)
def test_a_patient_slot_lets_what_follows_a_stopped_one_end(patient, ends, ran):
    async def story(own):
        for request in (1, 2, 3):
            own.give("a", request)
            await asyncio.sleep(1.5 * GRACE)
        await asyncio.sleep(5.0 * GRACE)

    found = ran(story, patient=patient, seconds=2.0 * GRACE)[0]
    assert found == [("a", request, end) for request, end in zip((1, 2, 3), ends, strict=True)]


def test_once_a_side_is_answered_a_patient_slot_stops_what_runs_again(ran):
    async def story(own):
        for request in (1, 2, 3, 4, 5):
            own.give("a", request)
            await asyncio.sleep(1.6 * GRACE)
        await asyncio.sleep(5.0 * GRACE)

    found = ran(story, patient=True, seconds=2.0 * GRACE)[0]
    assert [end for *_, end in found[:4]] == ["stopped", "done", "stopped", "done"]


@pytest.mark.parametrize(("refines", "side", "stopped"), [(True, "a", True), (False, "a", False), (True, "b", False)])
def test_what_only_refines_a_picture_of_a_side_is_put_off_at_once(refines, side, stopped, ran):
    async def story(own):
        own.give("a", 1)
        await asyncio.sleep(0.1 * GRACE)
        own.refines = refines
        own.put_off(side)
        assert own.watch.stop.is_set() == stopped
        await asyncio.sleep(2.0 * GRACE)

    assert ran(story, seconds=GRACE)[0] == [("a", 1, "stopped" if stopped else "done")]


def test_each_request_begins_with_a_watch_and_a_cost_of_its_own(ran):
    seen = []

    async def work(own, done, side, request):
        seen.append((own.watch, own.refines, own.cost))
        own.refines, own.cost = True, 5.0

    async def story(own, done):
        for request in (1, 2):
            own.give("a", request)
            await asyncio.sleep(0.01)

    ran(story, work=work)
    assert [entry[1:] for entry in seen] == [(False, 0.0)] * 2
    assert seen[0][0] is not seen[1][0]


@pytest.mark.parametrize(("side", "waits"), [("a", False), ("b", True)])
def test_waiting_ends_at_its_moment_or_with_something_newer_of_the_side(side, waits, ran):
    async def work(own, done, own_side, request):
        loop = asyncio.get_running_loop()
        begun = loop.time()
        try:
            await own.until(begun + GRACE)
        except slots.Stopped:
            done.append((own_side, request, "stopped", loop.time() - begun))
            raise
        done.append((own_side, request, "waited", loop.time() - begun))

    async def story(own, done):
        own.give("a", 1)
        await asyncio.sleep(0.5 * GRACE)
        own.give(side, 2)
        await asyncio.sleep(3.0 * GRACE)

    found, taken = ran(story, work=work)
    assert found == [("a", 1, "waited" if waits else "stopped"), (side, 2, "waited")]
    assert taken == pytest.approx([GRACE if waits else 0.5 * GRACE, GRACE], abs=0.011)
