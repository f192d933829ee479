"""Search for physically valid chaos in devices: random, then local, and resumable; with the draws that it finds.

    python benchmarks/whole_chaos.py [DRAWS [FOLDER]]      (default 4,000 and whole-chaos)

Whole means: a film that wrinkles where it would be compressed, and does not pull in, break down or come near its
stretch limit. What holds the disc is a family: a linear spring and a weight; a buckled beam (a spring of negative rate)
beside them; or a second film on the other side, in opposite phase. Each family is drawn at random within `RANGES`, then
around its best draws: those that are chaotic and whole, or where there are none, whole with the largest exponents.
FOLDER keeps every search as a store (``gelcone show FOLDER/NAME``) and goes on with what it holds, and
``whole-chaos.csv``: shares with 95 % intervals (Wilson), and of every family the best draws with their evidence;
``docs/whole-chaos.csv`` is that of 4,000 draws.
"""

from __future__ import annotations

import csv
import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from gelcone import ConeModel, Plan, sweep
from gelcone.codes import Outcome, Regime
from gelcone.motion.flow import integrate
from gelcone.statistics import wilson

RANGES = {
    "meridional_prestretch": (1.0, 1.6),
    "hoop_prestretch": (1.0, 1.6),
    "stretch_limit": (10.0, 150.0),
    "damping_ratio": (0.01, 0.2),
    "drive_frequency": (0.1, 2.5),
    "voltage": (0.05, 0.9),
    "voltage_bias": (0.0, 0.9),
    "spring_stiffness": (0.01, 3.0),
    "rest_height": (-0.3, 0.8),
    "weight": (-0.2, 0.2),
    "beam_stiffness": (-6.0, -0.5),
    "beam_cubic": (0.3, 10.0),
    "beam_height": (-0.2, 0.2),
    "second_flat_height": (0.0, 1.5),
}
EVENLY_IN_LOGARITHM = ("stretch_limit", "damping_ratio", "drive_frequency", "spring_stiffness", "beam_cubic")
STRENGTH = 1.6
"""20 kV/mm on the softest shipped gel but one, PVC-DBA 6:1; assumed, as in the devices that ship."""
FAMILIES: dict[str, dict[str, Any]] = {
    "spring": {"bias": "spring+weight"},
    "beam": {"bias": "spring+beam+weight"},
    "double": {"bias": "spring+weight", "second_film": "wrinkling", "second_drive": "opposite"},
}
START = (0.4, 0.0)
OPTIONS = {"patience": 2000.0, "budget": 4000.0}
CENTRES, NEARBY = 8, 0.1
"""Best draws around which is searched, and the share of its range by which a parameter differs there."""
KEPT = 12
"""Draws of a family in the table."""
FOLLOWED = 2000.0
"""Time over which is measured how long the film is taut."""
ALL = 1.0 - 1e-9
EVIDENCE = ("exponent", "standard_error", "chaotic_until", "lifetime_low", "share_chaotic", "taut_share")
Draws = dict[str, np.ndarray]


def model_of(family: str) -> ConeModel:
    return ConeModel(film="wrinkling", dielectric_strength=STRENGTH, hoop_prestretch=1.0, **FAMILIES[family])


def drawn(family: str, count: int) -> Draws:
    """Random values of the family's parameters, always the same."""
    rng = np.random.default_rng(list(FAMILIES).index(family))
    known = model_of(family).values
    shares = {name: rng.random(count) for name in RANGES if name in known}
    return {name: _value(name, share) for name, share in shares.items()}


def _value(name: str, share: np.ndarray) -> np.ndarray:
    low, high = RANGES[name]
    if name in EVENLY_IN_LOGARITHM:
        return np.asarray(low * (high / low) ** share)
    return low + (high - low) * share


def _share(name: str, value: np.ndarray) -> np.ndarray:
    low, high = RANGES[name]
    if name in EVENLY_IN_LOGARITHM:
        return np.asarray(np.log(value / low) / np.log(high / low))
    return (value - low) / (high - low)


def around(draws: Draws, centres: np.ndarray, count: int) -> Draws:
    """Values near those of some draws, within the ranges."""
    rng = np.random.default_rng(count)
    at = np.resize(centres, count)
    return {
        name: _value(name, np.clip(_share(name, values[at]) + rng.uniform(-NEARBY, NEARBY, count), 0.0, 1.0))
        for name, values in draws.items()
    }


def searched(family: str, draws: Draws, store: Path) -> xr.Dataset:
    """The regime of every draw, kept in the store."""
    reported = -1

    def watch(tally: Any) -> None:
        nonlocal reported
        tenth = 10 * tally.computed // tally.cells
        if tenth > reported:
            reported = tenth
            print(f"  {store.name}: {tally.computed} of {tally.cells}, {tally.chaotic} chaotic", file=sys.stderr)

    plan = Plan(model_of(family), {}, START, draws, OPTIONS)
    return sweep(plan, "regime", store=store, resume=store.exists(), watch=watch)


def is_whole(found: xr.Dataset) -> np.ndarray:
    """Mask of draws whose film never pulls in, breaks down or comes near its stretch limit."""
    fails = found.validity_breakdown + found.validity_near_limit + found.validity_pulled_in
    return np.asarray((found.outcome == Outcome.OK) & (fails == 0.0))


def is_chaotic(found: xr.Dataset) -> np.ndarray:
    """Mask of draws with chaos that outlasts the patience from every nearby start, with agreeing evidence."""
    lasting = (found.regime == Regime.CHAOTIC) & (found.doubtful == 0)
    return np.asarray(lasting & (found.share_chaotic == 1.0))


def best(found: xr.Dataset, count: int) -> np.ndarray:
    """The chaotic and whole draws, or else the whole ones, of the largest exponents."""
    wanted = is_whole(found) & is_chaotic(found)
    rows = np.flatnonzero(wanted if wanted.any() else is_whole(found))
    exponent = np.nan_to_num(found.lyapunov.values[rows, 0], nan=-np.inf)
    return rows[np.argsort(-exponent, kind="stable")][:count]


def taut_shares(family: str, draws: Draws, rows: np.ndarray) -> np.ndarray:
    """Share of the time in which the film is taut, (rows,); for a double cone that of the less taut one."""
    model = model_of(family).replace(**{name: values[rows] for name, values in draws.items()})
    run = integrate(model, START, [FOLLOWED])
    taut = run.film_times[:, :, 0].min(axis=1)
    return np.asarray(taut / FOLLOWED)


def table(family: str, search: str, draws: Draws, found: xr.Dataset) -> tuple[str, list[dict[str, Any]]]:
    """The result of a search in a line, and its best draws with their evidence."""
    whole, chaotic = is_whole(found), is_chaotic(found)
    hits = np.flatnonzero(whole & chaotic)
    taut = taut_shares(family, draws, hits) if hits.size else np.empty(0)
    low, high = wilson(hits.size / whole.size, whole.size)
    line = (
        f"{family}, {search}: {whole.size} draws, {whole.sum()} whole, {hits.size} of them chaotic "
        f"({100 * hits.size / whole.size:.2f} %, 95 % interval {100 * low:.2f} to {100 * high:.2f} %), "
        f"{(taut > ALL).sum()} taut all the time"
    )
    rows = []
    for row in best(found, KEPT) if hits.size else ():
        values = (
            found.lyapunov.values[row, 0],
            found.standard_error.values[row, 0],
            *(float(found[name][row]) for name in EVIDENCE[2:5]),
            taut[hits == row][0],
        )
        own = {name: f"{draws[name][row]:.17g}" for name in draws}
        evidence = {name: f"{value:.5g}" for name, value in zip(EVIDENCE, values, strict=True)}
        rows.append({"family": family, "search": search} | own | evidence)
    return line, rows


def main(count: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    lines, rows = [], []
    for family in FAMILIES:
        draws = drawn(family, count)
        found = searched(family, draws, folder / f"{family}-{count}")
        nearby = around(draws, best(found, CENTRES), count // 4)
        near = searched(family, nearby, folder / f"{family}-{count}-local")
        for search, values, result in (("random", draws, found), ("local", nearby, near)):
            line, own = table(family, search, values, result)
            print(line)
            lines.append(line)
            rows += own
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in lines)
    writer = csv.DictWriter(text, ["family", "search", *RANGES, *EVIDENCE], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    (folder / "whole-chaos.csv").write_text(text.getvalue(), encoding="utf-8")


if __name__ == "__main__":
    arguments = sys.argv[1:]
    main(int(arguments[0]) if arguments else 4000, Path(arguments[1] if arguments[1:] else "whole-chaos"))
