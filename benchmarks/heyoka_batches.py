"""Members in batches of equal plans, and batches over threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone.codes import CALL_SPAN
from gelcone.motion.job import Job
from gelcone.progress import Progress, Stopped, Watch
from gelcone.quantity import Array


@dataclass(frozen=True)
class Batch:
    """Members that are advanced alike.

    ``pieces`` (samples,) says into how many stretches each gap between samples is cut (none for a first sample at the
    start); ``call`` how many stretches go into one call of the integrator.
    """

    members: npt.NDArray[np.intp]
    pieces: npt.NDArray[np.int64]
    call: int


def batches(job: Job, lanes: int) -> Iterator[Batch]:
    """Batches of up to ``lanes`` members with the same plan of calls: a plan depends on the member alone, so its
    numbers do too.

    Pieces and calls are powers of 2, so that there are few plans and the batches are full.
    """
    members, gaps = np.flatnonzero(job.runs), job.gaps
    span, samples = CALL_SPAN / job.members.rate, gaps.shape[1]
    widest = np.maximum(gaps.max(axis=1), 1e-12)
    most = min(2.0 ** np.ceil(np.log2(samples)), 4096.0)
    call = 2 ** np.floor(np.log2(np.clip(span / widest, 1.0, most))).astype(int)
    pieces = np.where(gaps > 0.0, 2 ** np.ceil(np.log2(np.maximum(gaps / span[:, None], 1.0))).astype(np.int64), 0)
    plans: dict[tuple[int, bytes], list[int]] = {}
    for member in members[np.argsort((gaps.sum(axis=1) / span)[members], kind="stable")].tolist():
        plans.setdefault((int(call[member]), pieces[member].tobytes()), []).append(member)
    for (call_size, pieces_bytes), plan in plans.items():
        for first in range(0, len(plan), lanes):
            yield Batch(np.array(plan[first : first + lanes]), np.frombuffer(pieces_bytes, dtype=np.int64), call_size)


def stretches(
    job: Job, members: npt.NDArray[np.intp], pieces: npt.NDArray[np.int64]
) -> tuple[Array, npt.NDArray[np.int64]]:
    """The end of each of a batch's stretches, (stretches, members), and the sample that it gives, or -1."""
    ends = np.concatenate([job.start[members][None], job.times[members].T])
    samples = np.repeat(np.arange(pieces.size), pieces)
    left = np.cumsum(pieces)[samples] - np.arange(1, samples.size + 1)
    share = (1.0 - left / pieces[samples])[:, None]
    between = ends[samples] + (ends[samples + 1] - ends[samples]) * share
    return np.where(share == 1.0, ends[samples + 1], between), np.where(left == 0, samples, -1)


def run_batches(
    plans: list[Batch],
    advance: Callable[[Batch], Iterator[float]],
    *,
    threads: int,
    progress: Progress,
    watch: Watch | None,
) -> None:
    """Advances every batch to its end over some threads; ``advance`` yields the share of a batch that is done."""
    stop = threading.Event()
    lock = threading.Lock()

    def report(share: float) -> None:
        if progress is not None:
            with lock:
                progress(share / len(plans))

    def work(batch: Batch) -> None:
        if stop.is_set():
            return
        for share in advance(batch):
            if stop.is_set():
                return
            if watch is not None and watch.stop.is_set():
                raise Stopped
            report(share)

    if threads == 1 or len(plans) <= 1:
        for batch in plans:
            work(batch)
        return
    with ThreadPoolExecutor(threads) as executor:
        futures = [executor.submit(work, batch) for batch in plans]
        try:
            for future in as_completed(futures):
                future.result()
        except BaseException:
            stop.set()
            executor.shutdown(wait=True, cancel_futures=True)
            raise
