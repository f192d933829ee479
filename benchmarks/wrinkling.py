"""Cost of the wrinkling film relative to the taut one: processor time per unit time over the cells of the base map.

    python benchmarks/wrinkling.py [TURNS]      (default 5)

Both films integrate the same cells, in turns, on one thread, events included; the shortest of TURNS counts. Printed for
each tolerance and for what is kept: processor time per unit time, and the ratio of both films; first over all cells,
where a film that pulls in counts with the time that it lasts, then over the cells whose wrinkling film lasts.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset

CELLS = {"voltage": np.linspace(0.0, 2.0, 21), "prestretch": np.linspace(0.4, 2.0, 17)}
PERIODS = 64
KINDS = (
    *((tolerance, "states") for tolerance in (1e-6, 1e-9, 1e-12, 1e-15)),
    *((tolerance, "tangents") for tolerance in (1e-9, 1e-15)),
)
FILMS = ("taut", "wrinkling")


def cells(film: str, chosen: np.ndarray | None = None) -> ConeModel:
    """The cells of the map with that film, or those at the places ``chosen``."""
    grid = (axis.ravel() for axis in np.meshgrid(*CELLS.values(), indexing="ij"))
    values = {name: axis if chosen is None else axis[chosen] for name, axis in zip(CELLS, grid, strict=True)}
    return find_preset("base").model.replace(film=film, **values)


def lasting() -> np.ndarray:
    """Places of the cells whose wrinkling film does not pull in."""
    model = cells("wrinkling")
    run = integrate(model, find_preset("base").initial, [float(model.drive_period) * PERIODS], tolerance=1e-9)
    return np.flatnonzero(run.outcome == Outcome.OK)


def cost(model: ConeModel, tolerance: float, keep: str) -> tuple[float, float]:
    """Processor microseconds and steps per unit time."""
    times = float(model.drive_period) * np.arange(PERIODS + 1)
    before = time.process_time()
    run = integrate(model, find_preset("base").initial, times, keep=keep, tolerance=tolerance, threads=1)
    spent = time.process_time() - before
    lasted = np.nansum(run.end_times)
    return 1e6 * spent / lasted, float(run.steps.sum() / lasted)


def main() -> None:
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    whole = lasting()
    sets = {"all cells": None, "cells that last": whole}
    print(f"{cells('taut').size} cells, of which {whole.size} last; {PERIODS} periods; microseconds per unit time")
    for tolerance, keep in KINDS:
        for name, chosen in sets.items():
            models = {film: cells(film, chosen) for film in FILMS}
            best = dict.fromkeys(FILMS, (np.inf, 0.0))
            for _ in range(turns + 1):  # the first one compiles
                for film, model in models.items():
                    best[film] = min(best[film], cost(model, tolerance, keep))
            (taut, few), (wrinkling, many) = best.values()
            print(
                f"{keep:8} {tolerance:.0e}, {name:15}: taut {taut:6.3f}, wrinkling {wrinkling:6.3f}, "
                f"ratio {wrinkling / taut:.2f}; steps {many / few:.2f}"
            )


if __name__ == "__main__":
    main()
