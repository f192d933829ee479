"""The reduced form of a membrane that creeps against branches in every ring.

Films are held at a height and a voltage, from branches that have rested on the film where it begins to be raised, and
relax. In the check every element of the membrane has branches of its own (logarithmic flow, no limit), and states are
found anew in each step; `gelcone.physics.film.creeping_membrane` stretches all branches by one mean length.

    python benchmarks/creeping_membrane.py [FILMS]

prints for random films, moduli and heights the largest difference of the force during the relaxation, over the force
without voltage at once; voltages go up to 98 % of that at which the relaxed film pulls in.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gelcone.errors import InputError
from gelcone.membrane.elements import Chains, Elements
from gelcone.membrane.gel import Gel, Ring
from gelcone.physics.film.branches import Branches
from gelcone.physics.film.membrane import MembraneFilm

COUNT, STEP = 80, 0.05
"""Elements; and the step over the relaxation time."""
TIMES = (0.0, 0.3, 1.0, 3.0)
"""Over the relaxation time."""


@dataclass(frozen=True)
class CreepingGel(Gel):
    """Rings with a branch each: ``modulus`` over mu, and its states at the middles of the elements."""

    modulus: float = 0.0
    states: list[Any] = field(default_factory=lambda: [1.0, 1.0])

    def _slopes(self, m: Any, n: Any, V: Any) -> tuple[Any, ...]:
        """First and second derivatives of a ring's energy by m and n."""
        r = self.G / (m * n)
        strain, along, across = self.A * m + self.B * n + r - 3.0, self.A - r / m, self.B - r / n
        response = 1.0 / self.law.compliance(strain, self.numbers)
        rise = 0.5 * self.law.stiffening(strain, self.numbers) * response * response
        g, (p1, p2) = self.modulus, self.states
        own, firm = 1.0 / (p1 * p2 * m * n), response * r
        return (
            0.5 * (response * along - V * n + g * (p1 - own / m)),
            0.5 * (response * across - V * m + g * (p2 - own / n)),
            rise * along * along + (firm + g * own) / (m * m),
            rise * along * across + 0.5 * ((firm + g * own) / (m * n) - V),
            rise * across * across + (firm + g * own) / (n * n),
        )

    def hoop(self, l1: Any, l2: Any, V: Any) -> Any:
        return self._slopes(l1 * l1, l2 * l2, V)[1]

    def natural(self, m: Any, V: Any, guess: Any, steps: int = 40) -> Any:
        n = np.array(guess, dtype=float)
        for _ in range(max(steps, 25)):
            _, by_n, _, _, by_nn = self._slopes(m, n, V)
            n = np.clip(n - by_n / by_nn, 0.5 * n, 2.0 * n)
        return n

    def width(self, l1: Any, l2: Any, V: Any) -> Any:
        m, n = l1 * l1, l2 * l2
        return np.where(self.hoop(l1, l2, V) < 0.0, self.natural(m, V, n), n)

    def ring(self, l1: Any, l2: Any, V: Any, slack: Any, guess: Any, steps: int = 3) -> Ring:
        m = l1 * l1
        n = np.where(slack, self.natural(m, V, np.fmax(guess, l2 * l2)), l2 * l2)
        by_m, by_n, by_mm, by_mn, by_nn = self._slopes(m, n, V)
        softer, held = np.where(slack, by_mn * by_mn / by_nn, 0.0), ~slack
        return Ring(
            2.0 * l1 * by_m,
            held * (2.0 * l2 * by_n),
            2.0 * by_m + 4.0 * m * (by_mm - softer),
            held * (4.0 * l1 * l2 * by_mn),
            held * (2.0 * by_n + 4.0 * n * by_nn),
            n,
        )


def relaxation(gel: Gel, ratio: float, x: float, V: float, modulus: float) -> tuple[list[float], list[float]]:
    """The forces at `TIMES`, with branches in every ring and in the reduced form, of a film with the relaxation time 1;
    NaN where a state is not found."""
    film = MembraneFilm(law=gel.law, branches=1)
    own = {"stretch_limit": 1.0 / gel.numbers["inverse_stretch_limit"], "radius_ratio": ratio}
    own |= {"meridional_prestretch": gel.A**0.5, "hoop_prestretch": gel.B**0.5}
    n = film.numbers(film.complete(own | {"viscous_modulus_1": modulus, "relaxation_time_1": 1.0}))
    rings = Branches(1, "log", 1, taut=False)
    flow = {name: n[name] for name in rings.numbers(dict.fromkeys(rings.parameters, 1.0))}
    state, y = [np.ones((1, COUNT)), np.ones((1, COUNT))], [1.0, 1.0]
    begin, _, lengths = _state(gel, ratio, np.sqrt(n["mean_begin"] + 1e-4), 0.0, 0.0, state, None)
    at, now, full, reduced = begin, 0.0, list[float](), list[float]()
    reference = lengths
    for time in TIMES:
        for _ in range(round((time - now) / STEP)):
            at, _, (m, width) = _state(gel, ratio, x, V, modulus, _over(state, reference), at)
            along = m / reference[0], width / reference[1]
            state = _flown(lambda own, at=along: rings.rates(*at, own, flow), state)
            y = _flown(lambda own: film.rates(x, 0.0, V, own, n), y)
        now = time
        at, force, _ = _state(gel, ratio, x, V, modulus, _over(state, reference), at)
        full.append(force)
        reduced.append(float(film.force(x, V, y, n)[0]))
    return full, reduced


def _over(state: list[Any], reference: tuple[Any, Any]) -> list[Any]:
    """States relative to the mounted lengths, of those relative to ``reference``."""
    return [own / length for own, length in zip(state, reference, strict=True)]


def _flown(rates: Any, state: list[Any]) -> list[Any]:
    """Runge and Kutta's step."""

    def moved(by: list[Any], share: float) -> list[Any]:
        return [own + share * STEP * rate for own, rate in zip(state, by, strict=True)]

    first = rates(state)
    second = rates(moved(first, 0.5))
    third = rates(moved(second, 0.5))
    fourth = rates(moved(third, 1.0))
    every = zip(first, second, third, fourth, strict=True)
    return moved([(a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in every], 1.0)


def _state(
    gel: Gel, ratio: float, x: float, V: float, modulus: float, states: list[Any], start: Chains | None
) -> tuple[Chains, float, tuple[Any, Any]]:
    """The state at a height and a voltage, its force, and the squared lengths of its rings."""
    film = Elements(CreepingGel(gel.law, gel.numbers, gel.A, gel.B, modulus, states), ratio, COUNT)
    squared = np.array([V])
    if start is None or not np.isclose(start.z[0, 0], x):
        start = film.cones(np.array([x]), squared)
    at = film.found(start._replace(V=squared))
    l1, l2, _, sine = film.stretches(at)
    volts = np.full_like(l1, V)
    ring = film.gel.ring(l1, l2, volts, film.gel.hoop(l1, l2, volts) < 0.0, l2 * l2)
    force = -(film.weights * ring.meridional * sine / film.lengths)[0, 0] if at.found[0] else np.nan
    return at, float(force), (l1 * l1, ring.width)


def random_case(random: np.random.Generator) -> tuple[Gel, float, float, float, float]:
    """A gel, a/b, a height, a voltage up to 98 % of pull-in, and a modulus."""
    law = MembraneFilm().law
    limit = random.uniform(20.0, 120.0)
    hoop = random.uniform(1.0, 2.0)
    meridional = hoop if random.random() < 0.5 else hoop * random.uniform(0.8, 1.0)
    numbers = law.numbers({"stretch_limit": limit})
    gel, ratio = Gel(law, numbers, meridional**2, hoop**2), random.uniform(0.1, 0.5)
    film = MembraneFilm(law=law)
    own = {"stretch_limit": limit, "radius_ratio": ratio, "meridional_prestretch": meridional, "hoop_prestretch": hoop}
    try:
        n = film.numbers(film.complete(own))
    except InputError:  # stretched too near its limit: no membrane is made
        return random_case(random)
    x = random.uniform(0.2, 1.0)
    V = random.uniform(0.0, 0.98) ** 2 * min(float(film.highest_squared(x, n)), 5.0)
    return gel, ratio, x, V, 10.0 ** random.uniform(-1.0, 0.6)


def main(count: int) -> None:
    random, errors = np.random.default_rng(20261126), []
    print("  a/b    lm    lh      x      V    g  largest difference, % of the force without voltage at once")
    for _ in range(count):
        gel, ratio, x, V, modulus = random_case(random)
        without = relaxation(gel, ratio, x, 0.0, modulus)[0][0]
        full, reduced = relaxation(gel, ratio, x, V, modulus)
        error = float(np.max(np.abs(np.subtract(full, reduced)))) / without
        errors.append(error)
        words = f"{ratio:5.2f} {gel.A**0.5:5.2f} {gel.B**0.5:5.2f} {x:6.2f} {V:6.3f} {modulus:4.2f}"
        print(f"{words}  {100.0 * error:.2f}", flush=True)
    known = np.array(errors)[np.isfinite(errors)]
    print(f"{known.size} of {count} found: median {100 * np.median(known):.2f} %, largest {100 * known.max():.2f} %")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
