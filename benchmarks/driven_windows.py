"""Is a recommended window safe? Random devices driven in it for 600 periods by an integrator of its own.

    OMP_NUM_THREADS=1 python benchmarks/driven_windows.py [DEVICES] [SEED]      (default 20, 20261124)

Each device has a film of Gent's law as a membrane (a/b from 0.1 to 0.6, pre-stretches 1 to 1.8, half of them equal),
a spring, and a drive of twice its static pull-in. `gelcone.envelope` recommends a peak voltage at two drive
frequencies, 0.3 to 1.6 times the natural one. The motion is then integrated by the classical Runge-Kutta method with
400 steps a period, in which the film's force is interpolated in a dense table of states of one-dimensional finite
elements (`gelcone.membrane.elements`). The fitted pieces that gelcone runs have no part in it, nor has its engine.

A film has pulled in or is slack where the voltage exceeds the one at which the column of states of that height ends.
Its hoop is slack where any ring is. At the recommended peak neither may happen that the envelope excludes, switched
on from rest or raised over 200 periods; at 1.05 times the limit that it reports from rest, that limit is to be met.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

import gelcone
from gelcone.errors import InputError
from gelcone.membrane import force
from gelcone.membrane.columns import columns
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.motion.natural import natural_frequency
from gelcone.physics.laws import LAWS

Array = np.ndarray

ELEMENTS = 200
HEIGHTS, LEVELS, STEPS = 70, 160, 24
"""Heights at which states are computed, places of the table in V over its highest value, and steps of a column."""
FINE = 400
"""Places of the table in the height."""
LOWEST, HIGHEST = 0.03, 2.2
PERIODS, RISING, STEPS_A_PERIOD = 600, 200, 400
BEYOND = 1.05


@dataclass(frozen=True)
class Table:
    """The film's force over height and V, F[height, V over its highest]; at each height the highest V, and the one at
    which the first hoop falls slack."""

    heights: Array
    top: Array
    hoop: Array
    force: Array


class Case(NamedTuple):
    """A device at a drive frequency: recommended peak voltage, and limits from rest (NaN: not applicable)."""

    model: gelcone.ConeModel
    table: Table
    omega: float
    peak: float
    pull_in: float
    hoop_slack: float


Run = tuple[Case, float, float, float]
"""Case, displacement at first, peak voltage, and the periods over which it rises."""


def random_model(rng: np.random.Generator) -> gelcone.ConeModel:
    meridional = rng.uniform(1.0, 1.8)
    hoop = meridional if rng.random() < 0.5 else meridional * rng.uniform(0.85, 1.2)
    share = rng.uniform(0.0, 1.0)
    return gelcone.ConeModel(
        film="membrane",
        radius_ratio=rng.uniform(0.1, 0.6),
        meridional_prestretch=meridional,
        hoop_prestretch=hoop,
        stretch_limit=float(np.exp(rng.uniform(np.log(15.0), np.log(200.0)))),
        spring_stiffness=float(np.exp(rng.uniform(np.log(0.3), np.log(4.0)))),
        rest_height=rng.uniform(0.4, 1.2),
        damping_ratio=float(np.exp(rng.uniform(np.log(0.02), np.log(0.2)))),
        voltage=0.5 * share,
        voltage_bias=0.5 * (1.0 - share),
    )


def table_of(model: gelcone.ConeModel) -> Table:
    """The table of a model's film."""
    law = LAWS["gent"]
    gel = Gel(
        law,
        law.numbers({"stretch_limit": float(model.stretch_limit)}),
        float(model.meridional_prestretch) ** 2,
        float(model.hoop_prestretch) ** 2,
    )
    n = {name: float(values[0]) for name, values in model.members().numbers().items()}
    x = np.geomspace(LOWEST, min(HIGHEST, n["reach_squared"] ** 0.5), HEIGHTS)
    elements = Elements(gel, float(model.radius_ratio), ELEMENTS)
    with np.errstate(invalid="ignore"):
        first = np.where(x * x < n["cut_squared"], force.tension(x * x, 0.0, n), force.pull_in(x * x, n))
    found = columns(elements, x, first, 1.5 * first, STEPS, finest=1e-4)
    level = np.linspace(0.0, 1.0, LEVELS)
    top, rows = np.zeros(HEIGHTS), np.zeros((HEIGHTS, LEVELS))
    for k in range(HEIGHTS):
        V, own = found.along(k, found.measures.force)
        top[k] = found.end[k]
        rows[k] = PchipInterpolator(V, own)(level * V[-1])
    tension = found.measures.least_hoop
    at_first = np.array([found.along(k, tension)[1][0] for k in range(HEIGHTS)])
    hoop = np.where(at_first <= 0.0, 0.0, np.fmin(found.falls(tension), top))
    fine = np.linspace(x[0], x[-1], FINE)
    rest = (PchipInterpolator(x, top)(fine), np.interp(fine, x, hoop), PchipInterpolator(x, rows)(fine))
    return Table(fine, *rest)


def driven(runs: list[Run]) -> tuple[Array, Array]:
    """The drive period in which each run pulls in or falls slack, and its first hoop does; infinity if never."""
    cases, *rest = zip(*runs, strict=True)
    model, tables_of = [case.model for case in cases], [case.table for case in cases]
    low, spacing = np.array([(table.heights[0], table.heights[1] - table.heights[0]) for table in tables_of]).T
    tops, hoops, tables = (np.array([getattr(table, name) for table in tables_of]) for name in ("top", "hoop", "force"))
    omega, (x, peak, rising) = np.array([case.omega for case in cases]), np.array(rest)
    zeta, kappa, free = (
        np.array([float(getattr(one, name)) for one in model])
        for name in ("damping_ratio", "spring_stiffness", "rest_height")
    )
    own = np.array([float(one.voltage) + float(one.voltage_bias) for one in model])
    amplitude, bias = (
        np.array([float(getattr(one, name)) for one in model]) / own for name in ("voltage", "voltage_bias")
    )
    member = np.arange(len(runs))

    def look(x: Array, V: Array) -> tuple[Array, Array, Array]:
        """Force, V over its highest, and whether a hoop is slack."""
        place = np.maximum(np.abs(x) - low, 0.0) / spacing
        i = np.minimum(place.astype(int), FINE - 2)
        share = place - i
        top = tops[member, i] * (1.0 - share) + tops[member, i + 1] * share
        level, hoop = V / top, hoops[member, i] * (1.0 - share) + hoops[member, i + 1] * share
        along = np.clip(level, 0.0, 1.0) * (LEVELS - 1)
        j = np.minimum(along.astype(int), LEVELS - 2)
        part = along - j
        below = tables[member, i, j] * (1.0 - part) + tables[member, i, j + 1] * part
        above = tables[member, i + 1, j] * (1.0 - part) + tables[member, i + 1, j + 1] * part
        found = below * (1.0 - share) + above * share
        flat = np.minimum(np.abs(x) / low, 1.0)
        return np.sign(x) * flat * found, np.where(place > FINE - 1, np.inf, level), hoop < V

    u, (left, slack) = np.zeros(len(runs)), np.full((2, len(runs)), np.inf)
    h = 2.0 * np.pi / omega / STEPS_A_PERIOD

    def rates(t: Array, x: Array, u: Array) -> tuple[Array, Array, Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.where(rising > 0.0, np.minimum(t * omega / (2.0 * np.pi) / rising, 1.0), 1.0)
        v = peak * rise * (bias + amplitude * np.sin(omega * t))
        pull, level, loose = look(x, v * v)
        return u, -2.0 * zeta * u - kappa * (x - free) - pull, level, loose

    periods = PERIODS + RISING * int(np.any(rising > 0.0))
    for k in range(periods * STEPS_A_PERIOD):
        t = k * h
        a1, b1, level, loose = rates(t, x, u)
        out = np.isinf(left) & ~(level <= 1.0)
        left[out] = k / STEPS_A_PERIOD
        slack[np.isinf(slack) & np.isinf(left) & loose] = k / STEPS_A_PERIOD
        a2, b2, *_ = rates(t + 0.5 * h, x + 0.5 * h * a1, u + 0.5 * h * b1)
        a3, b3, *_ = rates(t + 0.5 * h, x + 0.5 * h * a2, u + 0.5 * h * b2)
        a4, b4, *_ = rates(t + h, x + h * a3, u + h * b3)
        live = np.isinf(left)
        x = np.where(live, x + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4), x)
        u = np.where(live, u + h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4), u)
    return left, slack


def at_rest(model: gelcone.ConeModel, table: Table) -> float:
    """The displacement of rest without voltage."""
    net = float(model.spring_stiffness) * (table.heights - float(model.rest_height)) + table.force[:, 0]
    return float(np.interp(0.0, net, table.heights))


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    rng = np.random.default_rng(int(sys.argv[2]) if len(sys.argv) > 2 else 20261124)
    cases, refused = [], 0
    while len(cases) < 2 * count:
        model = random_model(rng)
        shares = rng.uniform((0.3, 0.9), (0.9, 1.6))
        begin = time.process_time()
        try:
            pull_in = float(gelcone.limits(model).pull_in_voltage)
            model = model.replace(
                voltage=2.0 * pull_in * model.voltage, voltage_bias=2.0 * pull_in * model.voltage_bias
            )
            found = gelcone.envelope(model, frequencies=shares * float(natural_frequency(model, 0.0)))
        except InputError as error:
            refused += 1
            print(f"refused: {error}", flush=True)
            continue
        seconds, table = time.process_time() - begin, table_of(model)
        print(
            f"device {len(cases) // 2 + 1}: a/b {model.radius_ratio:.3f}, {model.meridional_prestretch:.3f} x "
            f"{model.hoop_prestretch:.3f}, limit {model.stretch_limit:.3g}, force known to {found.pull_in_error:.1e}; "
            f"envelope {seconds:.1f} s of processor",
            flush=True,
        )
        limits = found.limit_high.sel(driven_limit=["pull-in", "hoop slack"]).values
        for k in range(2):
            peak, own = float(found.recommended_peak[k]), limits[:, k]
            cases.append(Case(model, table, float(found.drive_frequency[k]), peak, float(own[0]), float(own[1])))
            print(f"  at {found.drive_frequency[k]:.3f}: pull-in at {own[0]:.4f}, a slack hoop at {own[1]:.4f}")
    print(f"{refused} devices refused")
    judge(cases)


def judge(cases: list[Case]) -> None:
    """Drive every case and print what its windows and limits are worth."""
    rest = [at_rest(case.model, case.table) for case in cases]
    inside = [(case, x, case.peak, rise) for case, x in zip(cases, rest, strict=True) for rise in (0.0, float(RISING))]
    for name in ("pull_in", "hoop_slack"):
        own = [(case, x, BEYOND * getattr(case, name), 0.0) for case, x in zip(cases, rest, strict=True)]
        beyond = [run for run in own if np.isfinite(run[2])]
        if beyond:
            found = driven(beyond)[0 if name == "pull_in" else 1]
            met = sum(np.isfinite(found))
            print(f"{BEYOND} times the limit {name!r} from rest: met by {met} of {len(beyond)}")
            report(beyond, ~np.isfinite(found))
    left, slack = driven([run for run in inside if np.isfinite(run[2])])
    excluded = np.array([not np.isnan(run[0].hoop_slack) for run in inside])
    print(f"in {len(inside) // 2} windows, from rest and raised: {np.sum(np.isfinite(left))} pulled in or fell slack")
    print(
        f"  a hoop fell slack in {np.sum(np.isfinite(slack) & excluded)} of {np.sum(excluded)} where that is excluded"
    )
    report(inside, np.isfinite(left) | (np.isfinite(slack) & excluded))


def report(runs: list[Run], which: Array) -> None:
    """The runs that are not as they should be."""
    for (case, _, peak, rise), wrong in zip(runs, which, strict=True):
        if wrong:
            print(f"  not so: a/b {case.model.radius_ratio:.3f} at {case.omega:.3f}, {peak:.4f}, raised over {rise:g}")


if __name__ == "__main__":
    main()
