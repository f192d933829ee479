"""Batches: each running member once, stretches that end on its samples, and threads that stop when asked."""

import threading
import time

import heyoka_batches as batches
import numpy as np
import pytest
from heyoka_batches import Batch, run_batches, stretches

from gelcone.codes import CALL_SPAN
from gelcone.motion.job import Job, Trajectories
from gelcone.physics.model import ConeModel
from gelcone.progress import Stopped, Watch


def job_of(model, times, runs=None, start=0.0):
    members = model.members()
    times = np.broadcast_to(np.asarray(times, dtype=float), (members.size, np.shape(times)[-1]))
    begin = np.full(members.size, start)
    gaps = np.diff(times, axis=1, prepend=begin[:, None])
    runs = np.ones(members.size, dtype=bool) if runs is None else runs
    outcome = np.zeros(members.size, dtype=np.int8)
    result = Trajectories.blank(times, members.system, "states", outcome)
    return Job(members, runs, np.zeros((members.size, 2)), begin, times, gaps, "states", 1e-15, result)


def varied(count):
    return ConeModel(spring_stiffness=np.geomspace(0.1, 1e6, count))


# --- plans ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lanes", [1, 8])
def test_every_member_that_runs_is_in_one_batch(lanes):
    runs = np.arange(53) % 5 != 2
    job = job_of(varied(53), np.linspace(0.0, 4000.0, 7), runs)
    found = list(batches.batches(job, lanes))
    members = np.concatenate([batch.members for batch in found])
    np.testing.assert_array_equal(np.sort(members), np.flatnonzero(runs))
    assert max(batch.members.size for batch in found) <= lanes


def test_members_of_a_batch_are_advanced_alike_and_within_the_span_of_a_call():
    job = job_of(varied(40), np.linspace(0.0, 9000.0, 5))
    plans = {}
    for batch in batches.batches(job, 8):
        assert (np.log2(batch.pieces[batch.pieces > 0]) % 1.0 == 0.0).all()
        assert np.log2(batch.call) % 1.0 == 0.0
        for member in batch.members:
            length = job.gaps[member, 1:] / batch.pieces[1:]
            assert (length <= CALL_SPAN / job.members.rate[member] * (1.0 + 1e-12)).all()
            plans[int(member)] = (batch.call, batch.pieces.tobytes())
    assert len(set(plans.values())) > 2
    for member in (0, 17, 39):
        alone = job_of(varied(40).take([member]), job.times[member])
        (single,) = batches.batches(alone, 8)
        assert (single.call, single.pieces.tobytes()) == plans[member]


def test_a_sample_at_the_start_takes_no_stretch():
    (batch,) = batches.batches(job_of(ConeModel(), [0.0, 1.0, 3.0]), 8)
    np.testing.assert_array_equal(batch.pieces, [0, 1, 1])


def test_stretches_end_on_the_samples_exactly():
    times = np.array([0.1, 0.7, 1.0 / 3.0 + 1.0, 9.0])
    job = job_of(ConeModel(voltage=[0.1, 0.2]), times, start=0.05)
    ends, samples = stretches(job, np.array([1, 0]), np.array([1, 4, 2, 8]))
    assert ends.shape == (15, 2)
    np.testing.assert_array_equal(samples[samples >= 0], np.arange(4))
    np.testing.assert_array_equal(ends[samples >= 0], np.repeat(times[:, None], 2, axis=1))
    np.testing.assert_array_equal(np.flatnonzero(samples >= 0), [0, 4, 6, 14])
    assert (np.diff(ends, axis=0) > 0.0).all()
    np.testing.assert_allclose(np.diff(ends[:5, 0]), 0.15, rtol=1e-13)


# --- threads ----------------------------------------------------------------------------------------------------------


def plans(count):
    return [Batch(np.array([k]), np.array([1]), 1) for k in range(count)]


@pytest.mark.parametrize("threads", [1, 3])
def test_every_batch_is_advanced_once_and_progress_adds_up_to_one(threads):
    done, shares, lock = [], [], threading.Lock()

    def advance(batch):
        for _ in range(4):
            yield 0.25
        with lock:
            done.append(int(batch.members[0]))

    run_batches(plans(11), advance, threads=threads, progress=shares.append, watch=None)
    assert sorted(done) == list(range(11))
    assert len(shares) == 44
    assert sum(shares) == pytest.approx(1.0)


@pytest.mark.parametrize("threads", [1, 3])
def test_an_error_in_one_batch_ends_the_others_and_is_raised(threads):
    advanced = []

    def advance(batch):
        advanced.append(int(batch.members[0]))
        if batch.members[0] == 2:
            raise ZeroDivisionError
        time.sleep(0.002)
        yield 1.0

    with pytest.raises(ZeroDivisionError):
        run_batches(plans(500), advance, threads=threads, progress=None, watch=None)
    assert len(advanced) < 500


@pytest.mark.parametrize("threads", [1, 3])
def test_a_watch_that_says_stop_is_heard_between_two_calls(threads):
    watch = Watch()
    shares = []

    def advance(batch):
        for step in range(1000):
            if batch.members[0] == 0 and step == 3:
                watch.stop.set()
            yield 0.001

    with pytest.raises(Stopped):
        run_batches(plans(4), advance, threads=threads, progress=shares.append, watch=watch)
    assert sum(shares) < 1.0
    if threads == 1:
        assert len(shares) == 3
