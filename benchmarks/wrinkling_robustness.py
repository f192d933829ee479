"""No wrinkling film is silently wrong: random parameter sets against the same motion by other formulas and library.

    python benchmarks/wrinkling_robustness.py [MEMBERS] [FILE]      (default 100,000; FILE keeps what is done)

The members are those of `benchmarks/robustness.py` with the wrinkling film, blocks of 1,000 from seeds of their own.
The reference is heyoka's scalar integrator in doubles: a program for each law, the natural width carried as a state by
its differential equation, explicit border functions as terminal events, stresses as derivatives of the energy. It
shares with the engine the two stretches between which the voltage barrier falls, and nothing else.

A member is right when its end agrees with the reference to 1e-9 of its size, times the factor by which its own tangent
map says that errors grow; and when it ends in the same way, pull-in times within 1e-6. A member that is not is run
again from starts 1e-12 to 1e-9 apart: where these part by as much as it differs, or end in different ways, it lies on
the edge of two motions, and no integrator can tell; it is counted as sensitive. For the rest SciPy decides, with the
force of the statics: the reference errs for films that would be beyond their stretch limit without wrinkles. All
others are wrong, and printed.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from heyoka_backend import import_heyoka
from robustness import LONGEST, SAMPLES, random_ensemble
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from gelcone.codes import Outcome
from gelcone.motion.flow import integrate
from gelcone.physics.model import ConeModel

BLOCK = 1000
ALLOWED = 1e-9
ALLOWED_TIME = 1e-6
SCIPY_ALLOWED = 1e-8
SCIPY_STEPS = 2000
APART = (1e-12, -1e-11, 1e-10, -1e-9)
MOST_BORDERS = 20_000
LONGEST_STEPS = (0.2, 0.01)
"""Of the reference; the second where it does not agree with the first: near its stretch limit it errs."""
NAMES = ("zeta", "kappa", "rest", "A", "B", "G", "s", "v", "v0", "w", "limit", "valley")
TAUT, WIDE, SLACK, PULLED_IN, FAILED = range(5)


@cache
def integrators() -> tuple[list[tuple[Any, list[str]]], Any]:
    """heyoka's integrators of the taut, the hoop-slack and the slack film, with the names of their events; and the
    function whose sign tells whether the hoop-slack film is strongly elliptic."""
    hk = import_heyoka()
    x, u, y, m, n, V = hk.make_vars("x", "u", "y", "m", "n", "V")
    p = {name: hk.par[i] for i, name in enumerate(NAMES)}
    A, B, G, s = (p[name] for name in "ABGs")
    voltage = p["v0"] + p["v"] * hk.sin(p["w"] * hk.time)
    squared = voltage * voltage
    rate = 2.0 * voltage * p["v"] * p["w"] * hk.cos(p["w"] * hk.time)
    q = 1.0 + x * x
    compliance = 1.0 - s * (A * m + B * n + G / (m * n) - 3.0)
    by_m = 0.5 * (A - G / (m * m * n)) / compliance - 0.5 * V * n
    by_n = 0.5 * (B - G / (m * n * n)) / compliance - 0.5 * V * m

    def at(expression: Any, width: Any) -> Any:
        return hk.subs(expression, {"m": q, "n": width, "V": squared})

    wide = 1.0 + y
    mm, mn, nn = (at(hk.diff(of, by), wide) for of, by in ((by_m, m), (by_m, n), (by_n, n)))
    nV = at(hk.diff(by_n, V), wide)
    width_rate = -(2.0 * x * u * mn + nV * rate + 0.1 * at(by_n, wide)) / nn
    free = -2.0 * p["zeta"] * u - p["kappa"] * (x - p["rest"])
    stiffness = 2.0 * at(by_m, wide)
    elliptic = (stiffness + 2.0 * q * 2.0 * (mm - mn * mn / nn)) * nn
    xx = x * x
    M = q * (1.0 + (3.0 - B) * s) - A * s * q * q - G * s
    t = A * q
    gA = (B - G) + B * xx - squared * q * M
    gB = (A - G) + A * xx * (2.0 + xx) - squared * q * M
    gC = (t * t * t - 1.0) - squared * G * t * t * (t * t * (1.0 + 3.0 * s) - 2.0 * s * t * t * t - s)
    laws = [
        ([free - x * 2.0 * at(by_m, hk.expression(1.0)), 0.0 * y], {"gA": (gA, -1), "gB": (gB, -1)}),
        ([free - x * stiffness, width_rate], {"gA": (gA, 1), "gC": (gC, -1), "local": (elliptic, -1)}),
        (
            [free, 0.0 * y],
            {"gB": (gB, 1), "gC": (gC, 1), "limit": (p["limit"] - squared, -1), "valley": (t - p["valley"], -1)},
        ),
    ]
    made = []
    directions = {-1: hk.event_direction.negative, 1: hk.event_direction.positive}
    for (force, width), events in laws:
        found = [hk.t_event(value, direction=directions[way]) for value, way in events.values()]
        system = [(x, u), (u, force), (y, width)]
        made.append((hk.taylor_adaptive(system, [0.0, 0.0, 0.0], t_events=found), list(events)))
    return made, hk.cfunc([elliptic], [x, y])


class Film:
    """One member's film by explicit formulas."""

    def __init__(self, p: dict[str, float], hump: float) -> None:
        self.p, self.hump = p, hump

    def law(self, x: float, squared: float) -> int:
        A, B, G, s = (self.p[name] for name in "ABGs")
        q = 1.0 + x * x
        compliance = 1.0 - s * (A * q + B + G / q - 3.0)
        hoop, meridian = B - G / q - squared * q * compliance, A * q - G / q - squared * q * compliance
        if A * q < B:
            return TAUT if meridian > 0.0 and A * q > G / q else self.slack(x, squared)
        if hoop >= 0.0 and G / q <= B:
            return TAUT
        t = A * q
        slack = t <= 1.0 or (1.0 - t**-3) - squared * G * t * (1.0 - s * (2.0 * t + t**-2 - 3.0)) <= 0.0
        return self.slack(x, squared) if slack else WIDE

    def slack(self, x: float, squared: float) -> int:
        """A slack film, unless it has pulled in."""
        t = max(self.p["A"] * (1.0 + x * x), self.p["B"])
        if t >= self.p["valley"]:
            return SLACK
        return PULLED_IN if t > max(self.hump, self.p["B"]) or squared > self.p["limit"] else SLACK

    def width(self, x: float, squared: float) -> float:
        A, B, G, s = (self.p[name] for name in "ABGs")
        q = 1.0 + x * x

        def stress(n: float) -> float:
            return (B - G / (q * n * n)) - squared * q * (1.0 - s * (A * q + B * n + G / (q * n) - 3.0))

        least, most = max(1.0, np.sqrt(G / (B * q))), A * q / B
        return (least if stress(least) >= 0.0 else float(brentq(stress, least, most, xtol=1e-15, rtol=1e-15))) - 1.0


def reference(
    p: dict[str, float], hump: float, start: np.ndarray, end: float, longest: float
) -> tuple[int, float, np.ndarray]:
    """The end of the motion, its time and place."""
    film = Film(p, hump)
    state, now = np.array([*start, 0.0]), 0.0
    squared = p["v0"] ** 2
    law = film.law(state[0], squared)
    if law == WIDE:
        state[2] = film.width(state[0], squared)
        if not _elliptic(p, now, state):
            law = PULLED_IN
    hk = import_heyoka()
    fresh, longest = True, longest / max(1.0, p["w"])  # borders are found on polynomials in time
    for _ in range(MOST_BORDERS):
        if law in (PULLED_IN, FAILED):
            return law, now, state[:2]
        integrator, names = integrators()[0][law]
        if fresh:
            integrator.reset_cooldowns()
        integrator.pars[:] = [p[name] for name in NAMES[: len(integrator.pars)]]
        integrator.time, integrator.state[:] = now, state
        outcome = integrator.propagate_until(end, max_delta_t=longest, max_steps=200_000)[0]
        now, state = float(integrator.time), integrator.state.copy()
        if outcome == hk.taylor_outcome.time_limit:
            return law, now, state[:2]
        if outcome in (hk.taylor_outcome.err_nf_state, hk.taylor_outcome.step_limit) or not np.isfinite(state).all():
            return FAILED, now, state[:2]
        name = names[-int(outcome) - 1]
        squared = (p["v0"] + p["v"] * np.sin(p["w"] * now)) ** 2
        before, law = law, _after(law, name, film, state[0], squared, p)
        fresh = law != before
        if fresh:
            state[2] = p["A"] * (1.0 + state[0] ** 2) / p["B"] - 1.0 if before == SLACK and law == WIDE else 0.0
        if fresh and law == WIDE and not _elliptic(p, now, state):
            law = PULLED_IN
    return FAILED, now, state[:2]


def _elliptic(p: dict[str, float], now: float, state: np.ndarray) -> bool:
    pars = np.array([p[name] for name in NAMES[:10]])
    return bool(integrators()[1](state[[0, 2]], pars=pars, time=now)[0] > 0.0)


def _after(law: int, name: str, film: Film, x: float, squared: float, p: dict[str, float]) -> int:
    """The law behind a border, or the same where that means nothing."""
    q = 1.0 + x * x
    steep = p["A"] * q >= p["B"]
    if law == TAUT:
        return (WIDE if name == "gA" else TAUT) if steep else (SLACK if name == "gB" else TAUT)
    if law == WIDE:
        return {"gA": TAUT, "gC": film.slack(x, squared), "local": PULLED_IN}[name]
    if name == "gC" and steep and p["A"] * q > 1.0:
        return WIDE
    if name == "gB" and not steep and p["A"] * q * q > p["G"]:
        return TAUT
    near = p["A"] * q <= max(film.hump, p["B"])
    ends = (name == "limit" and near) or (name == "valley" and not near)
    return PULLED_IN if ends else SLACK


def check(number: int) -> dict[str, Any]:
    """Counts of a block, and its members that are wrong."""
    taut, initial = random_ensemble(BLOCK, 2026 + number)
    model = taut.replace(film="wrinkling")
    horizon = np.minimum(LONGEST, 4 * model.drive_period)
    run = integrate(model, initial, horizon[:, None], threads=1)
    times = horizon[:, None] * np.arange(1, SAMPLES + 1) / SAMPLES
    tangents = np.nan_to_num(integrate(model, initial, times, keep="tangents", threads=1).tangents, nan=np.inf)
    growth, product = np.ones(BLOCK), np.eye(2)
    for k in range(SAMPLES):
        with np.errstate(all="ignore"):
            product = tangents[:, k] @ product
            growth = np.fmax(growth, np.linalg.norm(product, axis=(1, 2)))
    n = {name: np.broadcast_to(model.members().number(name), (BLOCK,)) for name in model.members().system.numbers}
    columns = {
        "zeta": n["damping_ratio"], "kappa": n["spring_stiffness"], "rest": n["rest_height"], "A": n["A"], "B": n["B"],
        "G": n["G"], "s": n["inverse_stretch_limit"], "v": n["voltage"], "v0": n["voltage_bias"],
        "w": n["drive_frequency"], "limit": n["limit_squared"], "valley": n["valley"],
    }  # fmt: skip
    counts: Counter[str] = Counter()
    wrong, worst = [], 0.0
    for i in range(BLOCK):
        outcome = Outcome(int(run.outcome[i]))
        counts[outcome.name.lower()] += 1
        if outcome not in (Outcome.OK, Outcome.PULLED_IN):
            continue  # it says that it has no result
        p = {name: float(column[i]) for name, column in columns.items()}
        counts["slack or wrinkled for a part"] += bool(run.film_times[i, 0, 1:].sum() > 0.0)
        for longest in LONGEST_STEPS:
            law, end, state = reference(p, float(n["hump"][i]), initial[i], float(horizon[i]), longest)
            if outcome == Outcome.PULLED_IN:
                error, allowed = abs(end - run.end_times[i]) + (law != PULLED_IN), ALLOWED_TIME * (1.0 + end)
            else:
                apart = float(np.abs(run.states[i, -1] - state).max()) + (law in (PULLED_IN, FAILED))
                error, allowed = apart / ((1.0 + np.abs(state).max()) * growth[i]), ALLOWED
            if error <= allowed:
                break
        if error <= allowed:
            worst = max(worst, error / allowed)
            counts["right"] += 1
        elif _sensitive(model.take(np.array([i])), initial[i], float(horizon[i]), run, i, state, end):
            counts["sensitive"] += 1
        elif outcome == Outcome.OK and _scipy_agrees(model, i, initial[i], float(horizon[i]), run, float(growth[i])):
            counts["right by SciPy, against the reference"] += 1
        elif law == FAILED:
            counts["without a reference"] += 1
        else:
            counts["wrong"] += 1
            said = [law, end, *state.tolist(), outcome.name, float(run.end_times[i]), *run.end_states[i].tolist()]
            wrong.append({"block": number, "member": i, "error": error, "ends": said})
    return {"block": number, "counts": dict(counts), "worst": worst, "wrong": wrong}


def _scipy_agrees(model: ConeModel, i: int, start: np.ndarray, horizon: float, run: Any, growth: float) -> bool:
    """Whether DOP853 with the force of the statics, which knows nothing of borders, comes to the same end."""
    members = model.take(np.array([i])).members()
    n = members.numbers_at(0)
    rates = members.system.rates
    for longest in (np.inf, horizon / SCIPY_STEPS):  # the first may step over a short time in which the film pulls
        way = solve_ivp(
            lambda t, z: rates(t, z, n), (0.0, horizon), start, "DOP853", rtol=1e-11, atol=1e-13, max_step=longest
        )
        apart = np.abs(way.y[:, -1] - run.states[i, -1]).max()
        if apart <= SCIPY_ALLOWED * (1.0 + np.abs(way.y[:, -1]).max()) * growth:
            return True
    return False


def _sensitive(
    model: ConeModel, start: np.ndarray, horizon: float, run: Any, i: int, state: np.ndarray, end: float
) -> bool:
    """Whether starts beside that one part by a tenth as much as the run and the reference do, or end otherwise."""
    many = model.take(np.zeros(len(APART), dtype=int))
    starts = start + np.stack([np.array(APART), np.zeros(len(APART))], axis=1)
    again = integrate(many, starts, np.full((len(APART), 1), horizon), threads=1)
    if (again.outcome != run.outcome[i]).any():
        return True
    apart = np.abs(again.end_states - run.end_states[i]).max() + np.ptp(again.end_times)
    return bool(apart > 0.1 * (np.abs(state - run.end_states[i]).max() + abs(end - run.end_times[i])))


def main(members: int, file: Path | None) -> int:
    done = [json.loads(line) for line in file.read_text().splitlines()] if file is not None and file.exists() else []
    known = {record["block"] for record in done}
    begin = time.perf_counter()
    for number in range(members // BLOCK):
        if number in known:
            continue
        record = check(number)
        done.append(record)
        if file is not None:
            with file.open("a") as out:
                out.write(json.dumps(record) + "\n")
        for each in record["wrong"]:
            print("wrong:", each, flush=True)
    total: Counter[str] = Counter()
    for record in done:
        total.update(record["counts"])
    print(f"{len(done) * BLOCK} members, {time.perf_counter() - begin:.0f} s; worst of those that are right: "
          f"{max((record['worst'] for record in done), default=0.0):.2f} of what is allowed")  # fmt: skip
    for name, count in total.items():
        print(f"  {name:30s} {count}")
    return int(total["wrong"] > 0)


if __name__ == "__main__":
    given = sys.argv[1:]
    sys.exit(main(int(given[0]) if given else 100_000, Path(given[1]) if len(given) > 1 else None))
