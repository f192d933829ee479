"""The film as a membrane that wrinkles: its innermost ring is stretched most, and localises first.

The relaxed axisymmetric membrane (tension field, with a voltage; see `gelcone.membrane`) on a disc of the radius a
inside a ring of the radius b. A ring of it obeys the law of the wrinkling cone at its own lengths. The innermost one,
whose hoop the disc holds, tells the film's state: with its squared meridional length 1 + z and tension s1/q,

    x^2 = S(z, V),    F = x (s1/q) P(z, V),

so that z is a root in a program. A slack film is the cone's. The film localises where S has its maximum over z: it
pulls in there at a held height, or when the voltage rises further.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.membrane.made import numbers_of
from gelcone.membrane.table import MAIN, RIM, coefficients, lowering, place, polynomials, total
from gelcone.physics.component import Numbers
from gelcone.physics.differentiate import derivatives
from gelcone.physics.film.film import Border, Film, FilmState
from gelcone.physics.film.wrinkling import ROUNDING, STEEP, Local, WrinklingCone
from gelcone.physics.implicit import known, traced
from gelcone.physics.quadrature import POINTS
from gelcone.quantity import Quantity

MOST_STEPS = 80
SMALL = 1e-6
"""Of z: steps of differences, and the z below which they do not shrink."""
FOLD = 0.01
"""Slope dS/dz at which a film has localised: before its maximum, where z would turn infinitely fast. S differs there by
less than 1e-4 of itself."""
BISECTIONS = 44
RINGS = 160
"""Innermost rings at whose localisation the border of pull-in is found."""
RADIUS_RATIO = {"radius_ratio": Quantity("a/b", "radius of the disc over that of the ring", 0.2, positive=True)}


class _Solved(NamedTuple):
    """Innermost rings of numbers: z, (s1/q) P, the slopes by z of S and of that, what is positive where the hoop at the
    rim is taut; whether the film pulls, and whether it has pulled in."""

    z: Any
    pull: Any
    turn: Any
    rise: Any
    rim: Any
    pulls: Any
    gone: Any


class _Ring(NamedTuple):
    """The innermost ring of a program: its lengthening z, S - x^2, s1/q times P, and what is positive where the hoop
    at the rim is taut."""

    z: Any
    equation: Any
    pull: Any
    rim: Any


@dataclass(frozen=True)
class MembraneFilm(WrinklingCone):
    """The membrane that wrinkles, for films whose meridian and hoop are stretched alike.

    Parameters
    ----------
    law, prestretch_mode : as for the taut cone.
    """

    name = "membrane"
    ending = Outcome.STRETCH_LIMIT
    linear_charge = traced_charge = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pull_in != "first":
            raise InputError(
                f"pull_in = {self.pull_in}: is a study of the wrinkling cone; leave it out, or film = wrinkling"
            )

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        return dict(super().parameters) | RADIUS_RATIO

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        own = dict(given)
        ratio = RADIUS_RATIO["radius_ratio"]
        values = {"radius_ratio": ratio.check("radius_ratio", own.pop("radius_ratio", ratio.default))}
        return super().complete(own) | values

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """Beside those of the wrinkling cone, those of the film's table and two switches."""
        own = super().numbers(parameters)
        law = {name: own[name] for name in own.keys() & self.law.numbers(parameters).keys()}
        table = numbers_of(self.law, law, parameters["radius_ratio"], own["A"], own["B"])
        one = np.ones(np.shape(own["pulls"]))
        return own | table | {"rim_taut": one, "disc_taut": one}

    # --- the innermost ring --------------------------------------------------------------------------------------

    def _ring(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> _Ring:
        """By expressions of a graph."""

        def slant(z: Any, xx: Any, squared: Any, xp: Any) -> Any:
            at, p, u, kinks = self._sums(z, squared, n, xp)
            own = self._sum("slant", n, p, u, kinks)
            share = lowering(at, n["anchor"], n["corner"])
            return z * (n["anchor"] - share * own) - xx

        def first(xx: Any, squared: Any, xp: Any) -> Any:
            """S is less than z."""
            return xx + 0.0 * squared

        z = xp.root(f"innermost ring, {getattr(n['crumpled'], 'value', '')}", slant, (xx, squared), first)
        _, p, u, kinks = self._sums(z, squared, n, xp)
        own, tension, _, _ = super()._at(z, squared, n, xp)
        pull = tension / own.compliance * self._sum("pull", n, p, u, kinks)
        return _Ring(z, slant(z, xx, squared, xp), pull, self._rim(z, squared, n, xp))

    def _sums(self, z: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Any, list[Any], list[Any], tuple[Any, Any]]:
        """A ring's place, the polynomials over it, and the factors of the sums behind the kinks."""
        at = self._place(z, squared, n, xp)
        p = polynomials((at.flatness - n["flatness_begin"]) * n["flatness_scale"] - 1.0, MAIN[0] + 1)
        u = polynomials(1.0 - 2.0 * at.share, MAIN[1] + 1)
        rim = total([[n[f"rim_{i}"]] for i in range(RIM + 1)], p, [1.0]) - at.share
        slack, wide = 0.5 - 0.5 * n["rim_taut"], 0.5 - 0.5 * n["disc_taut"]
        return at, p, u, (slack * (rim * rim), wide * (at.taut * at.taut))

    def _place(self, z: Any, squared: Any, n: Numbers, xp: Any) -> Any:
        def compliance(strain: Any) -> Any:
            return self.law.compliance(strain, n, xp)

        return place(z, squared, n["A"], n["B"], n["G"], n["low_squared"], compliance)

    def _sum(self, name: str, n: Numbers, p: list[Any], u: list[Any], kinks: tuple[Any, Any]) -> Any:
        found = total(coefficients(name, n), p, u)
        for kink, factor in zip(("rim", "disc"), kinks, strict=True):
            if known(factor) != 0.0:
                found = found + factor * total(coefficients(f"{name}_{kink}", n), p, u)
        return found

    def _rim(self, z: Any, squared: Any, n: Numbers, xp: Any) -> Any:
        at = self._place(z, squared, n, xp)
        p = polynomials((at.flatness - n["flatness_begin"]) * n["flatness_scale"] - 1.0, RIM + 1)
        return at.share - total([[n[f"rim_{i}"]] for i in range(RIM + 1)], p, [1.0])

    # --- force ---------------------------------------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x (s1/q) P and its slope; 0 where the film is slack, NaN where it has pulled in."""
        if not traced(xp):
            return self._force(x, squared, n)
        _, pulls = self._switches(x * x, squared, n, xp)
        if known(pulls) == 0.0:
            return super().force(x, squared, y, n, xp)
        ring = self._ring(x * x, squared, n, xp)
        (rise,), (turn,) = derivatives([ring.pull], ring.z), derivatives([ring.equation], ring.z)
        return x * (pulls * ring.pull), pulls * (ring.pull + (2.0 * (x * x)) * (rise / turn))

    def _force(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Of numbers."""
        found = self._solved(x, squared, n)
        with np.errstate(all="ignore"):
            slope = found.pull + 2.0 * np.square(x) * found.rise / found.turn
        pulls = np.where(found.gone, np.nan, np.where(found.pulls, 1.0, 0.0))
        force = np.where(found.pulls, x * found.pull, 0.0) * pulls
        return force[()], (np.where(found.pulls, slope, 0.0) * pulls)[()]

    def _solved(self, x: Any, squared: Any, n: Numbers) -> _Solved:
        """The innermost ring of numbers."""
        x, squared = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(squared, dtype=float))
        xx, cone = np.square(x), self._cone
        with np.errstate(all="ignore"):
            _, tension, _, _ = cone._at(xx, squared, n, np)
            flat = (squared < n["crumpling_squared"]) & (n["A"] > 1.0)
            pulls = flat | ((tension > 0.0) & (xx > n["shortest"]))
            z = self._lengthening(xx, squared, n)
            step = SMALL * (z + SMALL)
            square, pull = self._values(np.stack([z, z - step, z + step]), squared, n)
            turn, rise = ((values[2] - values[1]) / (2.0 * step) for values in (square, pull))
            ring, _, held, _ = cone._at(z, squared, n, np)
            firm = np.where(held > 0.0, 1.0, self._ellipticity(ring, n, np))
            off = np.abs(square[0] - xx) > 1e-9 * (1e-6 + xx)
            lost = off | (turn <= FOLD) | (firm <= 0.0) | (z > 1.001 * n["longest"])
            gone = np.where(pulls, lost, cone._gone(xx, squared, n)) | np.isnan(xx)
            rim = self._rim(z, squared, n, np)
        return _Solved(np.where(pulls, z, xx), pull[0], turn, rise, rim, pulls, gone)

    def _lengthening(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """z of numbers, on the rising part of S from its start: Newton's method, kept between bounds."""
        z, low, high = np.array(xx), np.array(xx), np.zeros(xx.shape) + n["longest"]
        for _ in range(MOST_STEPS):
            step = SMALL * (z + SMALL)
            square = self._square(np.stack([z, z + step]), squared, n)
            turn = (square[1] - square[0]) / step
            below = (square[0] < xx) & (turn > 0.0)
            low, high = np.where(below, z, low), np.where(below, high, z)
            after = z - (square[0] - xx) / turn
            inside = (after >= low) & (after <= high) & (turn > 0.0)
            after = np.where(inside, after, 0.5 * (low + high))
            if np.all(np.abs(after - z) <= ROUNDING * np.abs(z)):
                break
            z = after
        return z

    def _square(self, z: Any, squared: Any, n: Numbers) -> Any:
        """S of numbers."""
        at, p, u, kinks = self._sums(z, squared, self._law_at(z, squared, n), np)
        share = lowering(at, n["anchor"], n["corner"])
        return z * (n["anchor"] - share * self._sum("slant", n, p, u, kinks))

    def _values(self, z: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """S and (s1/q) P of numbers."""
        _, p, u, kinks = self._sums(z, squared, self._law_at(z, squared, n), np)
        own, tension, _, _ = self._cone._at(z, squared, n, np)
        return self._square(z, squared, n), tension / own.compliance * self._sum("pull", n, p, u, kinks)

    def _law_at(self, z: Any, squared: Any, n: Numbers) -> Numbers:
        """The numbers with the switches that tell what the innermost rings of numbers obey."""
        held, _ = self._switches(z, squared, n, np)
        rim = self._rim(z, squared, n, np)
        return {**n, "disc_taut": 2.0 * held - 1.0, "rim_taut": np.where(rim > 0.0, 1.0, -1.0)}

    @cached_property
    def _cone(self) -> WrinklingCone:
        return WrinklingCone(self.law, self.prestretch_mode)

    # --- borders -------------------------------------------------------------------------------------------------

    def _at(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Local, Any, Any, Any]:
        """The innermost ring's own state; a slack film's is the cone's."""
        if not traced(xp):
            found = self._solved(np.sqrt(xx), squared, n)
            own, pull, held, _ = super()._at(found.z, squared, n, np)
            return own, pull, held, np.where(found.pulls, 1.0, 0.0)
        _, pulls = self._switches(xx, squared, n, xp)
        if known(pulls) == 0.0:
            return super()._at(xx, squared, n, xp)
        return super()._at(self._ring(xx, squared, n, xp).z, squared, n, xp)

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """The wrinkling cone's, of the innermost ring; ``rim_taut`` and ``disc_taut`` tell where the hoop is.
        The latter changes with ``width_held``, but tells no laws apart, so that the root is one and the same. The last
        border ends the film where S has its maximum over z."""
        return (
            *super().borders,
            Border(self._rim_border, "rim_taut"),
            Border(self._disc_border, "disc_taut"),
            Border(self._fold_border),
        )

    def _rim_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._switches(x * x, squared, n, xp)
        if known(pulls) == 0.0:
            return 1.0 + 0.0 * x
        return n["rim_taut"] * self._ring(x * x, squared, n, xp).rim

    def _disc_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._switches(x * x, squared, n, xp)
        if known(pulls) == 0.0:
            return 1.0 + 0.0 * x
        return n["disc_taut"] * self._place(self._ring(x * x, squared, n, xp).z, squared, n, xp).taut

    def _fold_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._switches(x * x, squared, n, xp)
        if known(pulls) == 0.0:
            return 1.0 + 0.0 * x
        ring = self._ring(x * x, squared, n, xp)
        (turn,) = derivatives([ring.equation], ring.z)
        return turn - FOLD

    def switches(self, x: Any, squared: Any, n: Numbers) -> dict[str, Any]:
        found = self._solved(x, squared, n)
        own = super().switches(x, squared, n)
        taut = np.where(found.pulls, found.rim > 0.0, False)
        own["disc_taut"] = np.where(found.pulls, own["width_held"], -1.0)
        return own | {"rim_taut": np.where(taut, 1.0, -1.0), "pulls": np.where(found.pulls & ~found.gone, 1.0, -1.0)}

    # --- statics -------------------------------------------------------------------------------------------------

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        """Also at the very border of pull-in, where statics look for the folds of its voltage."""
        found = self._solved(x, squared, n)
        with np.errstate(all="ignore"):
            turning = 2.0 * x * x * x * found.rise / np.maximum(found.turn, FOLD)
        return np.where(found.pulls, turning, 0.0)[()]

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        """By differences of the force in z and V, at a held height."""
        found = self._solved(x, squared, n)
        squared = np.broadcast_to(squared, found.z.shape)
        step = SMALL * (1e-3 + np.abs(squared))
        with np.errstate(all="ignore"):
            square, pull = self._values(found.z, np.stack([squared + step, squared - step]), n)
            by_v, lower = ((values[0] - values[1]) / (2.0 * step) for values in (pull, square))
            gain = -x * (by_v - found.rise * lower / found.turn)
        return np.where(found.gone, np.nan, np.where(found.pulls, gain, 0.0))[()]

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """By bisection, as the force falls while the voltage rises; no voltage makes the film push, and a pull less
        than that with which it pulls in is not reached."""
        x, pull = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(pull, dtype=float))
        nearby, wanted = np.where(x == 0.0, 1e-6, np.abs(x)), np.maximum(pull, 0.0)
        highest = np.minimum(self.highest_squared(nearby, n), 10.0 * (1.0 + n["A"]) ** 3)
        low, high = np.zeros(x.shape), np.array(highest * (1.0 - 1e-9))

        def secant(V: Any) -> Any:
            found = self.force(nearby, V, [], n)[0] / nearby
            return np.where(np.isnan(found), 0.0, found)

        weakest, strongest = secant(high), secant(low)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            above = secant(middle) > wanted
            low, high = np.where(above, middle, low), np.where(above, high, middle)
        found = np.where(weakest > wanted, highest + STEEP * (weakest - wanted), 0.5 * (low + high))
        found = np.where(wanted > strongest, strongest - wanted, found)
        return (found - STEEP * np.minimum(pull, 0.0))[()]

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V at which it pulls in at x while the voltage rises from 0: the lowest V of the border, which may bend
        back to stable states above."""
        x = np.abs(np.asarray(x, dtype=float))
        slack = n["limit_squared"] + 0.0 * x
        shares = np.linspace(0.0, 1.0, RINGS).reshape(-1, *[1] * np.ndim(x + 0.0 * slack))
        heights, voltages = self._localisations(shares, n)
        with np.errstate(all="ignore"):
            low, high = heights[:-1], heights[1:]
            between = (low - x) * (high - x) <= 0.0
            there = voltages[:-1] + (voltages[1:] - voltages[:-1]) * (x - low) / (high - low)
            lowest = np.where(between, there, np.inf).min(axis=0)
            lowest = np.where(x > heights[-1], voltages[-1], lowest)
        found = np.minimum(lowest, np.where(slack >= 1e29, np.inf, np.maximum(slack, 0.0)))
        return np.where(x * x >= n["reach_squared"], 0.0, found)[()]

    def _localisations(self, shares: Any, n: Numbers) -> tuple[Any, Any]:
        """Heights and V at which innermost rings localise, from the shortest to the longest that does."""
        first = np.maximum(np.minimum(n["hump"], 1e6) / n["A"] - 1.0, 1e-7)
        z = first + (np.maximum(n["longest"], first) - first) * shares
        V = self._cone._localising(z, n)
        V = np.minimum(
            V, np.where(n["A"] * (1.0 + z) < n["end_of_slack"], V, self._crumpling(n["A"] * (1.0 + z), n) / n["G"])
        )
        with np.errstate(all="ignore"):
            square = self._square(z, np.where(np.isfinite(V), V * (1.0 - 1e-9), np.nan), n)
        return np.where(np.isfinite(V) & (square >= 0.0), np.sqrt(np.maximum(square, 0.0)), np.inf), V

    # --- where it has a state --------------------------------------------------------------------------------------

    def strain(self, x: Any, n: Numbers) -> Any:
        return np.square(x)

    def strain_limit(self, n: Numbers) -> Any:
        """The x^2 without voltage at which the innermost ring is as long as that which localises at the lowest voltage
        of all, or has 90 % of its stretch limit: what the table covers."""
        return np.asarray(n["reach_squared"])

    def reach(self, n: Numbers) -> tuple[float, float]:
        return 0.0, float(np.sqrt(n["reach_squared"]))

    def outside(self, x: float, n: Numbers) -> str:
        reach = self.reach(n)[1]
        return f"initial displacement {x:g}: must be less than {reach:.4g} either way for this membrane; start lower"

    def unreachable(self, n: Numbers) -> str:
        return "the membrane has no state at any displacement; change its parameters"

    # --- energies and lengths --------------------------------------------------------------------------------------

    def lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Of the innermost ring; those of the cone where the film is slack."""
        found = self._solved(x, squared, n)
        m, width = self._cone.lengths(np.sqrt(found.z), np.broadcast_to(squared, found.z.shape), n)
        return np.where(found.gone, np.nan, m)[()], np.where(found.gone, np.nan, width)[()]

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """That of the flat film, which is uniform, and the integral of what the voltage takes from the force."""
        if traced(xp):
            return Film.capacitance(self, x, squared, y, n, xp)
        begin, end = self._tightens(x, squared, n)
        flat = self._cone.capacitance(np.zeros_like(end), squared, y, n)
        return flat + 2.0 * _between(lambda at: self.voltage_gain(at, squared, n), begin, end)

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        begin, end = self._tightens(x, squared, n)
        flat = self._cone.work(np.zeros_like(end), squared, y, n)
        return flat + _between(lambda at: self.force(at, squared, y, n)[0], begin, end)

    def _tightens(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """The height up to |x| at which the film begins to pull, and |x|."""
        end, V = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), np.asarray(squared, dtype=float))
        with np.errstate(all="ignore"):
            t = self._cone._natural(np.zeros_like(end), V, n)
            slack = n["crumpling_squared"] <= V
            begin = np.where(slack, np.sqrt(np.maximum(t / n["A"] - 1.0, 0.0)), 0.0)
        return np.minimum(begin, end), end

    def state(self, x: Any, voltage: Any, n: Numbers) -> FilmState:
        """Of the innermost ring, which is stretched most; NaN once the film has pulled in."""
        squared = np.square(voltage)
        found = self._solved(x, squared, n)
        own = self._cone.state(np.sqrt(found.z), np.broadcast_to(voltage, found.z.shape), n)
        return FilmState(
            *(np.where(found.gone, -1 if name == "kind" else np.nan, v)[()] for name, v in own._asdict().items())
        )

    def describe(self) -> str:
        return "film as a membrane that wrinkles; stretches, stresses and field are those of its innermost ring"


def _between(function: Any, low: Any, high: Any) -> Any:
    """The integral from ``low`` to ``high``, all places at once."""
    places, weights = np.polynomial.legendre.leggauss(POINTS)
    length, shape = high - low, (POINTS, *[1] * np.ndim(high))
    values = function(low + (0.5 * (places + 1.0)).reshape(shape) * length)
    return length * np.sum((0.5 * weights).reshape(shape) * values, axis=0)
