"""A map by one and by two dask workers: the bytes of the store, the processor time, and what the second one gains.

    python benchmarks/cluster.py [VOLTAGES] [PRESTRETCHES] [--turns N]

The uniform map of `cells.py`, default 41 by 33 cells, by clusters of this machine with one and with two workers of one
thread each, which take turns after a first one that counts nothing, and without dask. The stores must hold equal bytes.
Processor time is the sum over the workers: where two take no more of it than one, two free cores gain a factor of two.
The gain itself is one of wall time and needs free cores. Stated are medians of the turns.
"""

from __future__ import annotations

import argparse
import logging
import tempfile
import time
from pathlib import Path

import distributed
import numpy as np
from cells import plan_of

import gelcone
from gelcone.atlas.plan import Plan


def content(folder: Path) -> dict[str, bytes]:
    """The files of a store, by their names in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class Workers:
    """A cluster of this machine with a number of workers."""

    def __init__(self, count: int) -> None:
        self.cluster = distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            dashboard_address=None,
            worker_dashboard_address=None,
            silence_logs=logging.ERROR,
        )
        self.client = distributed.Client(self.cluster)

    def map(self, plan: Plan, store: Path) -> tuple[float, float]:
        """Seconds of a map and processor seconds of its workers."""
        before, begin = self.client.run(time.process_time), time.perf_counter()
        gelcone.sweep(plan, store=store, workers=gelcone.cluster(scheduler=self.cluster.scheduler_address))
        took, after = time.perf_counter() - begin, self.client.run(time.process_time)
        return took, sum(after.values()) - sum(before.values())

    def close(self) -> None:
        """Ends them."""
        self.client.close()
        self.cluster.close()


def main() -> None:
    """Prints the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("size", nargs="*", type=int, default=[41, 33])
    parser.add_argument("--turns", type=int, default=3)
    given = parser.parse_args()
    plan = plan_of(*given.size)
    logging.getLogger("distributed").setLevel(logging.ERROR)
    teams = [Workers(count) for count in (1, 2)]
    with tempfile.TemporaryDirectory() as place:
        gelcone.sweep(plan, store=Path(place, "alone"), threads=1)
        alone, taken, equal = content(Path(place, "alone")), [], True
        for turn in range(1 + given.turns):
            stores = [Path(place, f"{turn}-{k}") for k in range(len(teams))]
            taken.append([team.map(plan, store) for team, store in zip(teams, stores, strict=True)])
            equal &= all(content(store) == alone for store in stores)
    for team in teams:
        team.close()
    (one, own), (two, both) = np.moveaxis(np.array(taken[1:]), 0, -1)
    total = sum(map(len, alone.values()))
    same = "equal to" if equal else "NOT equal to"
    print(f"map of {plan.size} cells by dask workers: stores {same} the one without dask in all {total:,} bytes")
    print(f"processor time, two dask workers against one: {np.median(both / own):.2f}")
    print(f"map, two dask workers over one: {np.median(one / two):.2f} ({np.median(two):.2f} s)")


if __name__ == "__main__":
    main()
