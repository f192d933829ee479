"""Accuracy of the fitted membrane: random films against finer elements at random states.

    OMP_NUM_THREADS=1 python benchmarks/membrane_film.py [FILMS]      (default 200)

Films of Gent's law with a/b from 0.05 to 0.8, pre-stretches from 0.8 to 3, half of them equal, else the hoop's 0.7 to
1.4 of the other, and stretch limits from 8 to infinity. For each: processor time of the table; its stated error, over
the force and a tenth of that without voltage; the largest that is found at eight random heights up to x = 2 on finer
elements; over itself, that of forces above a tenth of that without voltage, there or at the height 0.1; the stated and
the largest relative error of what voltages take from the force; and the largest one found of the capacitance up to 0.8
of the V at which the film falls slack or localises. At the end how many films were refused, how many errors the stated
ones cover, and the quantiles.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from gelcone.errors import InputError
from gelcone.membrane import force
from gelcone.membrane.columns import columns
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.piece import LOW
from gelcone.membrane.table import table
from gelcone.physics.film.membrane_energy import energy_and_area
from gelcone.physics.laws import LAWS

SEED = 20261123
FINE = 250
HEIGHTS = 8
LOWEST, HIGHEST = 0.03, 2.0
STEPS = 7
LEAST = 0.1
AWAY = 0.8
"""Share of the voltage at which a film ends up to which the capacitance is compared; there it changes fast."""


def random_film(rng: np.random.Generator) -> tuple[Gel, float, str]:
    """A gel, a/b, and both in words."""
    law = LAWS["gent"]
    limit = np.inf if rng.random() < 0.15 else float(np.exp(rng.uniform(np.log(8.0), np.log(200.0))))
    ratio, meridional = float(np.exp(rng.uniform(np.log(0.05), np.log(0.8)))), float(rng.uniform(0.8, 3.0))
    kind, other = rng.random(), float(rng.uniform(0.7, 1.4))
    hoop = meridional if kind < 0.5 else max(0.8, meridional * other)
    gel = Gel(law, law.numbers({"stretch_limit": limit}), meridional**2, hoop**2)
    return gel, ratio, f"a/b {ratio:.3f}, lm {meridional:.3f}, lh {hoop:.3f}, limit {limit:.3g}"


def errors(gel: Gel, ratio: float, n: dict[str, float], rng: np.random.Generator) -> tuple[float, ...]:
    """The largest error as it is stated, that of forces that are not weak over themselves, that of what voltages take
    from forces, and that of capacitances."""
    x = np.sort(rng.uniform(LOWEST, min(HIGHEST, n["reach_squared"] ** 0.5), HEIGHTS))
    near = x * x < n["cut_squared"]
    with np.errstate(invalid="ignore"):
        end = np.where(near, force.tension(x * x, 0.0, n), force.pull_in(x * x, n))
    elements = Elements(gel, ratio, FINE)
    found = columns(elements, x, end, 0.995 * end, STEPS)
    weak = elements.measures(elements.unloaded(LOW * np.geomspace(1.0, 4.0, 5))).force[0]
    own, first = found.measures.force, np.fmax(found.first[found.column], weak)
    at = x[found.column]

    def fitted(V: np.ndarray) -> np.ndarray:
        pulls = [force.pull(piece, at * at, V, n).k for piece in force.PIECES]
        return np.where(at * at < n["begin_squared"], 0.0, np.where(near[found.column], *pulls) * at)

    held = fitted(found.V)
    wrong = np.abs(held - own)
    inside = end[found.column] >= found.V
    strong = inside & (own > LEAST * first)
    loaded = inside & (found.V > 0.0) & (at >= LOW)
    taken, of_fit = found.first[found.column] - own, fitted(np.zeros_like(found.V)) - held
    gain = np.max(np.abs(of_fit / taken - 1.0)[loaded], initial=0.0)
    numbers = gel.numbers | n | {"A": gel.A, "B": gel.B, "G": gel.G, "hump": gel.hump()}
    with np.errstate(all="ignore"):
        area = energy_and_area(gel.law, at * at, found.V, numbers)[1]
    return (
        float(np.max(wrong[inside] / (own + LEAST * first)[inside])),
        float(np.max(wrong[strong] / own[strong])),
        float(gain),
        float(np.max(np.abs(area / found.measures.area - 1.0)[inside & (AWAY * end[found.column] > found.V)])),
    )


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    rng = np.random.default_rng(SEED)
    rows, refused = [], 0
    for _ in range(count):
        gel, ratio, words = random_film(rng)
        begin = time.process_time()
        try:
            n = table(gel, ratio)
        except InputError as error:
            refused += 1
            print(f"{words}: {error}", flush=True)
            continue
        seconds = time.process_time() - begin
        found, strong, gain, area = errors(gel, ratio, n, rng)
        rows.append((seconds, n["film_error"], found, strong, n["gain_error"], gain, area))
        mark = "  NOT COVERED" * (found > n["film_error"] or gain > n["gain_error"])
        stated = f"stated {n['film_error']:.1e}, found {found:.1e}, {strong:.1e}"
        gains = f"of gains stated {n['gain_error']:.1e}, found {gain:.1e}"
        print(f"{words}: {seconds:.2f} s, {stated}; {gains}; of capacitance {area:.1e}{mark}", flush=True)
    seconds, stated, found, strong, stated_gain, gain, area = np.array(rows).T
    print(f"{count} films, {refused} refused; {np.sum(found <= stated)} of {found.size} covered by the stated error")
    print(f"{np.sum(gain <= stated_gain)} of {gain.size} errors of gains covered")
    named = {"seconds": seconds, "stated": stated, "found": found, "strong forces": strong}
    named |= {"stated of gains": stated_gain, "found of gains": gain, "found of capacitances": area}
    for name, values in named.items():
        print(
            f"  {name}: median {np.median(values):.2g}, 90 % {np.quantile(values, 0.9):.2g}, largest {values.max():.2g}"
        )


if __name__ == "__main__":
    main()
