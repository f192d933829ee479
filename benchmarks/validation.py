"""Every certified number against gelcone's: the table of the page Validation.

    python benchmarks/validation.py            (writes docs/validation.csv)
    python benchmarks/validation.py --check    (ends with 1 where a number of the table is not met any more)

References are those of tests/reference, which other programs computed, mostly in 34-digit arithmetic. A row states the
last number of a case and the largest error over the case.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import gelcone  # noqa: E402
from gelcone.motion.flow import integrate  # noqa: E402
from gelcone.physics.model import ConeModel  # noqa: E402
from tests.atlas.branches.test_continuation import BASE  # noqa: E402
from tests.membrane.test_elements import CERTIFIED as MEMBRANES  # noqa: E402
from tests.membrane.test_elements import found as membrane  # noqa: E402
from tests.motion import test_flow, test_wrinkling  # noqa: E402
from tests.motion.test_orbit import REGULAR  # noqa: E402
from tests.physics.film import test_branches  # noqa: E402

TABLE = ROOT / "docs" / "validation.csv"
HEADS = ("subject", "number", "reference", "found", "error", "source", "version", "date")
Row = tuple[str, str, float, float, float, str]


def worst(found: Any, wanted: Any) -> float:
    """The largest difference."""
    return float(np.abs(np.asarray(found, dtype=float) - np.asarray(wanted, dtype=float)).max())


def motions() -> Iterator[Row]:
    """Trajectories of cones: taut, wrinkling and creeping."""
    for k, case in enumerate(test_flow.REFERENCE, 1):
        model, initial, times, states = test_flow.certified(case)
        run = integrate(model, initial, times).states[0]
        name = f"taut cone {k}: displacement at time {times[-1]:g}"
        yield "Motions", name, states[-1, 0], run[-1, 0], worst(run, states), "trajectories.json"
    for case in test_wrinkling.REFERENCE["trajectories"]:
        times = [state["tau"] for state in case["states"]]
        run = integrate(test_wrinkling.model_of(case), case["start"], times).states[0]
        wanted = np.array([[state["x"], state["velocity"]] for state in case["states"]])
        name = f"wrinkling cone {case['case']}: displacement at time {times[-1]:g}"
        yield "Motions", name, wanted[-1, 0], run[-1, 0], worst(run, wanted), "wrinkling.json"
    for case in test_branches.TAUT:
        rows = case["rows"]
        run = gelcone.simulate(test_branches.model_of(case), case["start"], times=[row["tau"] for row in rows])
        wanted, own = [row["x"] for row in rows], run["displacement"].values
        name = f"creeping cone {case['name']}: displacement at time {rows[-1]['tau']:g}"
        yield "Motions", name, wanted[-1], own[-1], worst(own, wanted), "viscous.json"
        works, own = [row["source"] for row in rows], run["supplied_energy"].values
        name = f"creeping cone {case['name']}: work of the source"
        yield "Motions", name, works[-1], own[-1], worst(own, works), "viscous.json"


def orbits() -> Iterator[Row]:
    """Periodic orbits, and bifurcations on the branches of the base set."""
    for one in REGULAR:
        model = ConeModel(**one["parameters"])
        period = one["period_in_drive_repeats"] * float(model.members().forcing_period[0])
        state = np.array(one["orbit_state_at_phase_0"])
        back = integrate(model, state, [period]).states[0, 0]
        expansion = max(1.0, float(np.abs(np.array(one["multipliers_of_that_map"])[:, 0]).max()))
        name = f"{one['key']}: displacement at phase 0, back after a period"
        yield "Periodic orbits", name, state[0], back[0], worst(back, state) / expansion, "continuation.json"
    found = gelcone.continue_branch(BASE, "voltage", 0.9, 1.6, switch=0, checks=2)
    values = found.event_value.values
    for one in bifurcations_of_the_base_set():
        nearest = float(values[np.abs(values - one["value"]).argmin()])
        if abs(nearest - one["value"]) < 1e-6:
            name = f"{one['key']}: {one['free_parameter']}"
            yield "Bifurcations", name, one["value"], nearest, abs(nearest - one["value"]), "continuation.json"


def bifurcations_of_the_base_set() -> list[dict[str, Any]]:
    """Certified bifurcations of the base set over the voltage."""
    path = ROOT / "tests" / "reference" / "continuation.json"
    every = json.loads(path.read_text(encoding="utf-8"))["references"]
    return [one for one in every if one.get("free_parameter") == "voltage" and one["key"].startswith("base")]


def films() -> Iterator[Row]:
    """Pull-in of films, and states of the membrane (relative errors)."""
    for case in test_wrinkling.REFERENCE["pull_in_times_from_x1"]:
        if case["tau_pull_in"] is None:
            continue
        kappa, omega = test_wrinkling.SETS[case["set"]]
        lm, lh = test_wrinkling.PRESTRETCHES[case["pre"]]
        given = {"kappa": kappa, "omega": omega, "v": case["v"], "lm": lm, "lh": lh, "J": 50, "x0": 0.0, "zeta": 0.01}
        run = integrate(test_wrinkling.model_of(given, pull_in="minimum"), (1.0, 0.0), [200.0])
        wanted, own = float(case["tau_pull_in"]), float(run.end_times[0])
        name = f"time of pull-in, {case['set']}, {case['pre']}, v = {case['v']}"
        yield "Films", name, wanted, own, abs(own - wanted), "wrinkling.json"
    for state in MEMBRANES:
        own, at = membrane(state, 120)
        force = float(own.measures(at).force[0])
        name = (
            f"membrane a/b = {state['radius_ratio']}, hoop {state['hoop_prestretch']}, x = {state['x']}, "
            f"v = {state['v']}: force, relative error"
        )
        yield "Films", name, state["force"], force, abs(force / state["force"] - 1.0), "membrane.json"


def rows() -> Iterator[Row]:
    """All rows of the table."""
    for part in (motions, orbits, films):
        yield from part()


def main(arguments: list[str]) -> int:
    """Writes the table, or compares with the existing one: no error may be more than three times as large."""
    found = list(rows())
    if "--check" in arguments:
        with TABLE.open(encoding="utf-8", newline="") as file:
            before = {(row["subject"], row["number"]): float(row["error"]) for row in csv.DictReader(file)}
        worse = [row for row in found if not row[4] <= 3.0 * before.get((row[0], row[1]), 0.0) + 1e-13]
        lost = set(before) - {(row[0], row[1]) for row in found}
        print("\n".join([*map(str, worse), *map(str, lost)]) or f"{len(found)} numbers are met")
        return int(bool(worse or lost))
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADS)
        made = (gelcone.__version__, f"{datetime.now(UTC):%Y-%m-%d}")
        for subject, number, reference, own, error, source in found:
            writer.writerow([subject, number, f"{reference:.12g}", f"{own:.12g}", f"{error:.1e}", source, *made])
    print(f"{len(found)} numbers in {TABLE.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
