"""No viscous device is silently wrong: random films, circuits and waveforms against the same motion by other formulas.

    python benchmarks/creeping.py [DEVICES] [FILE]      (default 10,000; FILE stores what is done)

Blocks of `BLOCK` devices, each block with components of its own - films taut and wrinkling, all laws, 0 to 3 branches
of both flow rules, all biases, circuits and waveforms - and each device with numbers of its own, from fixed seeds. The
reference is `creeping_reference.py`: SciPy on equations in other states, which shares no formula with gelcone.

Compared are displacement, velocity, the states of branches and circuit, voltage and charge at four times, and the works
of source, damper, film and circuit until then. A device is right where they agree to `ALLOWED` of their size, and where
it ends in the same way, pull-in times within `ALLOWED_TIME`: gelcone's own steps err by 1e-15, and what is allowed is
what the reference may err by, whose two tolerances differ by less than a tenth of it in most runs, and twice the 1e-6
by which gelcone ends a minimum early. A device that is not right is run again by the reference at a closer tolerance,
and then from starts 1e-9 away, which says how errors grow: it is counted as sensitive where errors of 1e-12, those of
the reference, grow to the difference, or where these starts end in different ways. One that ends with an outcome other
than ok is not silent: until the last time before its end it must agree, too.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from creeping_reference import CAUSES, FAILED, PULLED_IN, RELATIVE, Device, Motion, Run

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.response import simulate
from gelcone.physics.model import ConeModel

BLOCK = 100
SEED = 20261126
SAMPLES = 4
ALLOWED = 1e-9
ALLOWED_TIME = 3e-6
EARLY = 2e-5
"""That behind a resistance, where a minimum counts as ended somewhat earlier (`gelcone.physics.system`)."""
APART = (1e-9, -1e-9)
"""Starts of the reference beside one that disagrees, in displacement."""
GROWN = 1e-3
"""Share of what these starts part by that errors may have grown to."""
CLOSER, SHORTER = 3e-14, 1 / 400
"""Tolerance of the reference for one that disagrees, and the share of the time that its steps then have at most: where
a current meets its limit within a longer one the tolerance says nothing of its error."""
BIASES = ("spring", "beam", "spring+weight", "spring+force", "beam+weight")
AMPLIFIER = (
    ("filter_time", "slew_rate"),
    ("series_resistance", "current_limit"),
    ("leakage_time", "leakage_field"),
)


# --- random devices ---------------------------------------------------------------------------------------------------


def components(rng: np.random.Generator) -> dict[str, Any]:
    """The components of a block."""
    film = str(rng.choice(["taut", "wrinkling"]))
    found: dict[str, Any] = {
        "film": film,
        "law": str(rng.choice(["gent", "gent", "neo-hookean", "yeoh"])),
        "branches": int(rng.choice(4, p=[0.1, 0.45, 0.3, 0.15])),
        "flow": str(rng.choice(["log", "log", "linear"])),
        "rested": str(rng.choice(["flat", "flat", "raised"])),
        "bias": str(rng.choice(BIASES)),
        "waveform": waveform(rng),
        "circuit": "ideal",
        "takes": (),
        "flow_exponent": 1,
    }
    if film == "wrinkling":
        found["pull_in"] = str(rng.choice(["first", "first", "first", "minimum"]))
    if found["flow"] == "log" and found["branches"]:
        found["flow_exponent"] = int(rng.choice([1, 1, 3, 5]))
    kind = rng.choice(["ideal", "amplifier", "charge"], p=[0.25, 0.6, 0.15])
    if kind == "charge" and film == "taut":
        found["circuit"] = "charge"
    elif kind == "amplifier":
        found["takes"] = _takes(rng, film)
        found["circuit"] = "amplifier" if found["takes"] else "ideal"
    return found


def _takes(rng: np.random.Generator, film: str) -> tuple[str, ...]:
    takes: list[str] = []
    for share, (first, second) in zip((0.4, 0.75, 0.5), AMPLIFIER, strict=True):
        if rng.random() < share:
            takes += [first, second] if rng.random() < 0.45 else [first]
    if film == "taut" and rng.random() < 0.35:
        takes += ["dielectric_share", "dielectric_time"]
    return tuple(takes)


def waveform(rng: np.random.Generator) -> dict[str, Any]:
    """The record of a waveform."""
    kind = str(
        rng.choice(
            ["sine", "triangle", "square", "trapezoid", "ramp", "half_wave", "burst", "chirp", "harmonics", "staircase",
             "samples"]
        )
    )  # fmt: skip
    repeat, found = bool(rng.random() < 0.5), {"component": kind}
    if kind == "burst":
        cycles = int(rng.integers(1, 4))
        found |= {"cycles": cycles, "period_in_cycles": cycles + int(rng.integers(1, 4))}
    elif kind == "chirp":
        found |= {"sweep": str(rng.choice(["linear", "logarithmic"])), "repeat": repeat}
    elif kind == "harmonics":
        orders = 1 + rng.permutation(5)[:3]
        found["terms"] = tuple((int(k), float(rng.uniform(-0.7, 0.7)), float(rng.uniform(0, 6))) for k in orders)
    elif kind == "staircase":
        levels = tuple(float(level) for level in rng.uniform(-1, 1, 5))
        found |= {"levels": levels, "rise": float(rng.choice([0.0, 0.2])), "repeat": repeat}
    elif kind == "samples":
        shares = np.unique(np.concatenate([[0.0, 1.0], rng.uniform(0.02, 0.98, int(rng.integers(2, 30)))]))
        values = rng.uniform(-1, 1, shares.size)
        values[-1] = values[0]
        found |= {"shares": tuple(shares.tolist()), "values": tuple(values.tolist()), "repeat": repeat}
        found["interpolation"] = str(rng.choice(["linear", "pchip"]))
    return found


def numbers(rng: np.random.Generator, structure: dict[str, Any], count: int) -> dict[str, np.ndarray]:
    """Parameters of all devices of a block, for the components that have them."""

    def powers(low: float, high: float) -> np.ndarray:
        return np.asarray(10.0 ** rng.uniform(low, high, count))

    found = {
        "damping_ratio": np.where(rng.random(count) < 0.2, 0.0, powers(-2.5, -0.3)),
        "voltage": rng.uniform(0.05, 1.0, count),
        "voltage_bias": np.where(rng.random(count) < 0.5, 0.0, rng.uniform(-0.8, 0.8, count)),
        "drive_frequency": powers(-0.5, 0.6),
        "lm": rng.uniform(0.8, 1.6, count),
        "lh": rng.uniform(0.8, 1.6, count),
        "spring_stiffness": powers(-0.5, 0.8),
        "rest_height": rng.uniform(-0.3, 1.0, count),
        "beam_stiffness": rng.uniform(-1.0, 2.0, count),
        "beam_cubic": rng.uniform(0.2, 2.5, count),
        "beam_height": rng.uniform(-0.3, 1.0, count),
        "weight": rng.uniform(-0.3, 0.3, count),
        "push": rng.uniform(-0.3, 0.3, count),
        "stretch_limit": powers(0.9, 2.3),
        "yeoh_c2": rng.uniform(-0.02, 0.05, count),
        "yeoh_c3": rng.uniform(0.0, 0.01, count),
        "flow_stress": powers(-0.7, 0.7),
        "filter_time": powers(-1.5, 0.3),
        "slew_rate": powers(-0.7, 0.7),
        "series_resistance": powers(-2.0, 0.3),
        "current_limit": powers(-1.3, 0.3),
        "leakage_time": powers(0.0, 2.0),
        "leakage_field": powers(-0.5, 0.5),
        "dielectric_share": rng.uniform(0.05, 0.8, count),
        "dielectric_time": powers(-1.0, 1.3),
        "start_frequency": powers(-0.3, 0.5),
        "end_frequency": powers(0.0, 0.8),
        "duty": rng.uniform(0.2, 0.8, count),
        "high": rng.uniform(0.0, 0.5, count),
        "rise": np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.01, 0.2, count)),
        "fall": np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.01, 0.2, count)),
    }
    for k in range(1, structure["branches"] + 1):
        found[f"viscous_modulus_{k}"] = powers(-1.3, 0.5)
        found[f"relaxation_time_{k}"] = powers(-1.5, 2.0)
        found[f"viscous_limit_{k}"] = np.where(rng.random(count) < 0.3, np.inf, powers(0.9, 2.0))
    if rng.random() < 0.5:
        found["lm"] = np.ones(count) if rng.random() < 0.5 else found["lh"]
    return found


def model_of(structure: dict[str, Any], values: dict[str, np.ndarray]) -> ConeModel:
    """The model of a block; those of the ``values`` that its components have."""
    own = {name: value for name, value in structure.items() if name not in ("takes", "circuit", "waveform")}
    own["waveform"] = dict(structure["waveform"])
    film = {"meridional_prestretch": values["lm"], "hoop_prestretch": values["lh"]}
    electrics = {name: values[name] for name in structure["takes"]}
    bare = ConeModel(**own, circuit=structure["circuit"], **film, **electrics)
    rest = {name: value for name, value in values.items() if name in bare.values}
    return ConeModel(**own, circuit=structure["circuit"], **{**film, **rest})


def block(number: int, count: int) -> tuple[dict[str, Any], ConeModel, list[dict[str, float]], np.ndarray, np.ndarray]:
    """Components, model, the numbers of each device, starts and sample times of a block."""
    rng = np.random.default_rng([SEED, number])
    structure = components(rng)
    values = numbers(rng, structure, count)
    model = model_of(structure, values)
    farthest = np.where(model.strain(np.full(count, 1.2)) < 0.8 * model.strain_limit(), 1.2, 0.4)
    initial = np.stack([farthest * rng.uniform(-1, 1, count), rng.uniform(-0.5, 0.5, count)], axis=1)
    times = rng.uniform(2.0, 8.0, count)[:, None] * np.arange(1, SAMPLES + 1) / SAMPLES
    devices = [{name: float(value[i]) for name, value in values.items() if name in model.values or name in ("lm", "lh")}
               for i in range(count)]  # fmt: skip
    return structure, model, devices, initial, times


# --- comparison -------------------------------------------------------------------------------------------------------


def observed(model: ConeModel, run: Trajectories) -> np.ndarray:
    """All compared values, (devices, samples, values): states, charge, voltage, works; NaN for unknown works."""
    members = model.members()
    n, z = members.numbers(trailing=1), list(np.moveaxis(run.states, -1, 0))
    with np.errstate(all="ignore"):
        charge = np.broadcast_to(members.system.stored(run.times, z, n), run.times.shape)
        voltage = np.broadcast_to(members.system.voltages(run.times, z, n)[0], run.times.shape)
    assert run.work is not None
    known = dict(zip(members.system.causes, np.moveaxis(run.work, -1, 0), strict=True))
    works = [known.get(cause, np.full(run.times.shape, np.nan)) for cause in CAUSES]
    return np.concatenate([run.states, np.stack([charge, voltage, *works], axis=-1)], axis=-1)


def difference(own: np.ndarray, rows: Sequence[Sequence[float]]) -> float:
    """The largest difference over 1 and the size of what is compared; unknown works, and samples just before a jump of
    the voltage, are not."""
    if not rows:
        return 0.0
    other = np.array(rows)
    apart = np.abs(own[: len(rows)] - other) / (1.0 + np.abs(other))
    return float(np.nanmax(apart))


def judge(
    structure: dict[str, Any], device: dict[str, float], start: np.ndarray, times: np.ndarray, own: np.ndarray,
    outcome: Outcome, ended: float,
) -> tuple[str, float, Motion]:  # fmt: skip
    """The class of a device, its error over the allowed one, and the reference's motion."""

    def follow(shift: float = 0.0, **options: float) -> Motion:
        return Run(Device(structure, device), [start[0] + shift, start[1]], **options).follow(times.tolist())

    def far(other: Motion) -> float:
        """The error over the allowed one."""
        reached = int(np.isfinite(own[:, 0]).sum())
        error = difference(own[:reached], other.rows[:reached]) / ALLOWED
        if (outcome == Outcome.PULLED_IN) != (other.end == PULLED_IN) and other.end != FAILED:
            return math.inf
        return max(error, abs(ended - other.time) / allowed_time) if outcome == Outcome.PULLED_IN else error

    said = outcome.name.lower()
    allowed_time = EARLY if "series_resistance" in structure["takes"] else ALLOWED_TIME
    closer: list[dict[str, float]] = [
        {"relative": CLOSER, "longest": share * float(times[-1])} for share in (SHORTER, 0.1 * SHORTER)
    ]
    for options in ({"relative": RELATIVE}, *closer):
        other = follow(**options)
        error = far(other)
        if outcome in (Outcome.OK, Outcome.PULLED_IN) and other.end == FAILED:
            continue
        if error <= 1.0:
            return ("right" if outcome == Outcome.OK else said), error, other
    if other.end == FAILED:
        return ("" if outcome == Outcome.OK else f"{said}, ") + "without a reference", error, other
    beside = [follow(shift) for shift in APART]
    if len({motion.end for motion in (*beside, other)}) > 1:
        return "sensitive", error, other
    shared = min(len(motion.rows) for motion in (*beside, other))
    spread = max(difference(np.array(motion.rows[:shared]), other.rows[:shared]) for motion in beside)
    late = max(abs(motion.time - other.time) for motion in beside)
    if math.isfinite(error) and error <= GROWN * max(spread / ALLOWED, late / allowed_time):
        return "sensitive", error, other
    return "wrong" if outcome == Outcome.OK else f"wrong, {said}", error, other


def check(number: int, count: int = BLOCK) -> dict[str, Any]:
    """The outcome of a block: counts, the largest share of what is allowed, and the devices that are wrong."""
    structure, model, devices, initial, times = block(number, count)
    begin = time.process_time()
    run = integrate(model, initial, times, keep="work", threads=1)
    spent = [time.process_time() - begin]
    own = observed(model, run)
    counts, worst, wrong = Counter[str](), 0.0, []
    for i, device in enumerate(devices):
        outcome = Outcome(int(run.outcome[i]))
        if outcome == Outcome.OUTSIDE:
            counts["outside"] += 1
            continue
        kind, error, other = judge(structure, device, initial[i], times[i], own[i], outcome, float(run.end_times[i]))
        counts[kind] += 1
        if kind in ("right", "pulled_in"):
            worst = max(worst, error)
        if kind.startswith("wrong") or "without" in kind:
            wrong.append([i, kind, error, outcome.name, float(run.end_times[i]), other.end, other.time])
    spent.append(time.process_time() - begin - spent[0])
    return {
        "block": number,
        "components": json.dumps(structure)[:400],
        "counts": dict(counts),
        "worst": worst,
        "wrong": wrong,
        "seconds": spent,
    }


# --- long runs --------------------------------------------------------------------------------------------------------

LONG, BALANCED = 1000.0, 20
"""Time of a run whose energies are balanced, and of how many devices of each kind."""


def balance(count: int = BALANCED) -> dict[str, float]:
    """Largest energy residual over `LONG` units of time of random wrinkling films that neither pull in nor end, elastic
    and with a branch, behind the ideal source and behind a resistance."""
    found = {}
    for branch, behind in ((False, False), (True, False), (False, True), (True, True)):
        rng, worst, done = np.random.default_rng(SEED), 0.0, 0
        while done < count:
            given = {name: rng.uniform(*between) for name, between in _LONG_RUNS.items()}
            given |= {"viscous_modulus_1": rng.uniform(0.1, 1.0), "relaxation_time_1": 10.0 ** rng.uniform(0.0, 2.5)}
            given |= {"series_resistance": 10.0 ** rng.uniform(-1.5, -0.3)}
            left_out = (() if branch else ("viscous_modulus_1", "relaxation_time_1")) + (
                () if behind else ("series_resistance",)
            )
            model = ConeModel(film="wrinkling", **{k: v for k, v in given.items() if k not in left_out})
            run = simulate(model, (rng.uniform(0.1, 1.0), 0.0), times=np.linspace(0.0, LONG, 1001))
            if int(run["outcome"]) == Outcome.OK:
                done, worst = done + 1, max(worst, float(abs(run["energy_residual"]).max()))
        found[f"{'creeping' if branch else 'elastic'}, {'resistance' if behind else 'ideal source'}"] = worst
    return found


_LONG_RUNS = {
    "damping_ratio": (0.02, 0.3),
    "spring_stiffness": (0.8, 3.0),
    "rest_height": (0.0, 1.2),
    "hoop_prestretch": (1.0, 1.4),
    "meridional_prestretch": (1.0, 1.4),
    "voltage": (0.05, 0.35),
    "voltage_bias": (0.0, 0.25),
    "drive_frequency": (0.3, 2.0),
}


def main(devices: int, file: Path | None) -> int:
    """Runs the unfinished blocks, and prints all results."""
    done = [json.loads(line) for line in file.read_text().splitlines()] if file is not None and file.exists() else []
    known = {record["block"] for record in done}
    for number in range(devices // BLOCK):
        if number in known:
            continue
        record = check(number)
        done.append(record)
        if file is not None:
            with file.open("a") as out:
                out.write(json.dumps(record) + "\n")
        for each in record["wrong"]:
            print(f"block {number}, device {each}\n    {record['components']}", flush=True)
    total = Counter[str]()
    for record in done:
        total.update(record["counts"])
    own, other = (sum(record["seconds"][k] for record in done) for k in (0, 1))
    print(
        f"{sum(total.values())} devices in {len(done)} structures; gelcone {own:.0f} s, the reference {other:.0f} s of "
        f"processor time; worst of those that are right: {max(record['worst'] for record in done):.2f} of ALLOWED"
    )
    for kind, count in total.most_common():
        print(f"  {kind:22s} {count}")
    residuals = balance()
    for kind, worst in residuals.items():
        print(f"energy over {LONG:g} units, wrinkling, {kind:24s} residual at most {worst:.1e}")
    return int(any(kind.startswith("wrong") for kind in total) or max(residuals.values()) > ALLOWED)


if __name__ == "__main__":
    given = sys.argv[1:]
    sys.exit(main(int(given[0]) if given else 10_000, Path(given[1]) if len(given) > 1 else None))
