"""The wrinkling film: a homogeneous cone without compression, because it wrinkles where it would be compressed.

Symbols as in `gelcone.physics.film.taut`; m and n are the squared true meridional and hoop length over the mounted one,
m = q and n = 1 where the film is taut. A wrinkled film may be longer than the gap that it spans, never shorter, so
that at the squared voltage V it takes the energy

    min over m >= q, n >= 1 of W(A m + B n + G/(m n) - 3) - V m n/2,

followed from V = 0 (tension-field theory: Pipkin, IMA J. Appl. Math. 36 (1986) 85; with a voltage: De Tommasi, Puglisi,
Zurlo, arXiv 1012.1462; Greaney, Meere, Zurlo, J. Mech. Phys. Solids 122 (2019) 84). With the response R(I1) of the
law and r = G/(m n), the true stresses over mu are s1 = R (A m - r) - V m n and s2 = R (B n - r) - V m n, and

    taut              s1, s2 >= 0 at m = q, n = 1
    hoop-slack        m = q, and n > 1 so that s2 = 0: wrinkles along the meridians
    meridional slack  n = 1, and m > q so that s1 = 0
    crumpled          s1 = s2 = 0, A m = B n

The disc is pulled back with x s1/q, which is 0 in the last two. The energy's minimum, and with it the film, ends where
a crumpled film pulls in: V G above Vb(t) = R (t - t^-2)/t^2 at t = max(A q, B), or above the first maximum of Vb, its
hump, where t lies before that. A film that the disc stretches beyond the valley behind the hump does not: without
tension it stays on the rising part of Vb behind it. A hoop-slack film localises even earlier: where its meridional
force falls as a ring of it lengthens, the strain runs into one ring (loss of strong ellipticity).

In a program the natural width n - 1 is the root of s2 = 0, solved inside of each step, and switches tell the states
apart. Force and stiffness come from one energy, so that the force is continuous across the borders, and tangent maps
have no jump there (no saltation matrix): the difference of the rates on both sides of a border, which would be in it,
is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from gelcone.codes import FilmPullIn
from gelcone.errors import InputError, unknown_name
from gelcone.membrane.gel import MOST_STRETCHED
from gelcone.membrane.table import NEVER
from gelcone.physics.bracket import rise
from gelcone.physics.component import Numbers
from gelcone.physics.film.creeping import UNREACHED, Creeping
from gelcone.physics.film.film import Border, Film, FilmState, TracedState
from gelcone.physics.film.taut import TautCone
from gelcone.physics.implicit import known, root, traced
from gelcone.physics.laws import StrainEnergyLaw
from gelcone.quantity import Array

STATES = ("taut", "hoop_slack", "meridional_slack", "crumpled")
"""The states of the film, in which order results carry their shares of time."""
PULL_IN = ("first", "minimum", "memoryless", "snap")
FAILED = "pulled_in"
"""The state of a film that goes on after it has pulled in."""
STEEP = 1e10
"""How fast the V that would make a film push grows with the push: no voltage does, it is above `UNREACHED`."""
ROUNDING = 1e-12
"""Lengths that exceed those of the taut film by less are its own."""
GRID = 2000
GOLDEN, GOLDEN_STEPS = 0.6180339887498949, 40


_STUDIES = {
    "first": "",
    "minimum": "; its localisation is left out (study)",
    "memoryless": "; after pull-in it has failed; the run goes on without its force until there is a minimum (study)",
    "snap": "; after pull-in it has failed; the run goes on without its force until it snaps back (study)",
}


class Local(NamedTuple):
    """What a point of the film obeys, at m = q and n = 1 + y: see the module for the symbols.

    ``meridian`` is A q, ``hoop`` B n, ``excess`` s2/(R q n): at n = 1 it is positive where the hoop is taut. ``lead``
    is (A q - B n)/q, so that K s1/q = lead + n ``excess`` with the compliance K = 1/R.
    """

    y: Any
    flatness: Any
    r: Any
    compliance: Any
    strain: Any
    meridian: Any
    hoop: Any
    lead: Any
    excess: Any


@dataclass(frozen=True)
class WrinklingCone(TautCone):
    """The cone that wrinkles.

    Parameters
    ----------
    law, prestretch_mode : as for the taut cone.
    pull_in : what happens where the film pulls in. ``"first"`` (default): the run ends, by localisation or by the end
        of the energy's minimum, whichever comes first. The others are for study. ``"minimum"``: the run ends by the end
        of the minimum alone. After that end the film has failed, but the run goes on without its force:
        ``"memoryless"``, as long as the energy has no minimum; ``"snap"``, the film stays thin until V falls below
        the valley of Vb behind the hump, or until the disc stretches it beyond. At a snap back the force jumps, so
        that tangent maps and exponents across it lack the jump.
    """

    pull_in: str = "first"

    name = "wrinkling"
    linear_charge = False
    held_width = False
    folds = True

    @property
    def traced_charge(self) -> bool:  # type: ignore[override]
        """False where a run goes on after pull-in: the charge of a film that has failed is unknown."""
        return not self.goes_on

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pull_in not in PULL_IN:
            raise unknown_name("pull_in", str(self.pull_in), PULL_IN)
        if self.branches and self.goes_on:
            raise InputError(f"pull_in = {self.pull_in}: a film with branches ends there; take first or minimum")

    def resting_lengths(self, x: Any, n: Numbers) -> tuple[Any, Any]:
        return self.lengths(x, 0.0, n)

    def shortest_lengths(self, x: Any, n: Numbers) -> tuple[Any, Any]:
        """Those of the taut film."""
        return super().resting_lengths(x, n)

    @cached_property
    def creeping(self) -> Creeping:
        """The formulas of a film with branches, away from statics."""
        return Creeping(self, localises=self.pull_in != "minimum")

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """Beside those of the taut cone: ``hump``, the t of the first maximum of Vb; ``valley``, that of the minimum
        behind it; ``limit_squared``, the V at which a film without tension pulls in; ``crumpling_squared``, the V above
        which it is slack in both directions; ``end_of_slack``, the A q above which no film loses its tension without
        pulling in; ``edge``, the A x^2 at which A q = B, negative if there is none; ``shortest``, the x^2 below which a
        film is so short that evenly compressed it would be beyond its stretch limit, negative if there is none; and the
        switches."""
        own = super().numbers(parameters)
        A, B, G = np.broadcast_arrays(own["A"], own["B"], own["G"])
        law = {name: own[name] for name in own.keys() - {"A", "B", "G"}}
        hump, valley = _turnings(self.law, law)
        with np.errstate(all="ignore"):
            turning = np.maximum(hump, B)
            limit = np.where(np.isinf(hump) | (valley <= B), NEVER, self.crumpling(turning, law) / G)
            crumpling = self.crumpling(B, law) / G
        one = np.ones(np.broadcast_shapes(A.shape, hump.shape))
        return (
            own
            | {
                "limit_squared": limit,
                "crumpling_squared": np.where(B > 1.0, crumpling, -1.0) * one,
                "end_of_slack": np.minimum(turning, NEVER),
                "hump": np.minimum(hump, NEVER) * one,
                "valley": np.minimum(valley, NEVER) * one,
                "edge": np.where(B > A, B - A, -1.0),
                "shortest": self._shortest(A, B, G, law) * one,
                "width_held": one,
                "pulls": one,
                "crumpled": one,
                "long": one,
                "below_hump": one,
            }
            | ({"meridian_held": one} if self.branches else {})
            | (self._numbers_after(G, valley, law, one) if self.goes_on else {})
        )

    @property
    def goes_on(self) -> bool:
        """Whether a run goes on after the film has pulled in."""
        return self.pull_in in ("memoryless", "snap")

    def _numbers_after(self, G: Any, valley: Any, law: Numbers, one: Any) -> dict[str, Any]:
        """``valley_squared``, the V at the valley, and a switch."""
        with np.errstate(all="ignore"):
            squared = np.where(np.isinf(valley), 0.0, _crumpling(self.law, valley, law) / G)
        return {
            "valley_squared": squared * one,
            "whole": one,
        }

    def _shortest(self, A: Any, B: Any, G: Any, law: Numbers) -> Any:
        """The x^2 at which the film is as long as its gel, at m = q and A n = B or, if that is shorter, n = 1."""
        hoop = np.maximum(A, B)
        strain = A + hoop + 1.0 / (A * hoop) - 3.0
        short = 1.0 / (A * np.sqrt(np.maximum(B, 1.0))) - 1.0
        return np.where((short > 0.0) & (strain >= self.law.strain_limit(law)), short, -1.0)

    def crumpling(self, t: Any, n: Numbers) -> Any:
        """Vb(t), the V G at which the film is slack in both directions at the squared stretch t; infinite at and beyond
        the stretch limit."""
        t = np.asarray(t, dtype=float)
        beyond = 2.0 * t + np.square(1.0 / t) - 3.0 >= self.law.strain_limit(n)
        return np.where(beyond, np.inf, _crumpling(self.law, t, n))

    @property
    def kinds(self) -> tuple[str, ...]:  # type: ignore[override]
        return (*STATES, FAILED) if self.goes_on else STATES

    # --- force ---------------------------------------------------------------------------------------------------

    def local(self, xx: Any, squared: Any, y: Any, n: Numbers, xp: Any = np) -> Local:
        """At x^2, V and y = n - 1; differences of nearly equal numbers are taken where they are exact."""
        A, B, G = (n[name] for name in "ABG")
        flatness = xx / (1.0 + xx)  # 1 - 1/q
        larger = xx + (y + y * xx)  # q n - 1
        thinning = larger / (1.0 + larger)  # 1 - 1/(q n)
        strain = (A + B + G - 3.0) + A * xx + B * y - G * thinning
        compliance = self.law.compliance(strain, n, xp)
        # (B n - r)/(q n), r = G (1 - thinning)
        own = (B - G) + (2.0 * G - B) * thinning - G * (thinning * thinning) + (B * y) * (1.0 - thinning)
        lead = (A - B) + B * (flatness - y + y * flatness)
        excess = own - squared * compliance
        return Local(y, flatness, G - G * thinning, compliance, strain, A + A * xx, B + B * y, lead, excess)

    def tension(self, own: Local) -> Any:
        """s1/q."""
        return (own.lead + (1.0 + own.y) * own.excess) / own.compliance

    def _switches(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Any, Any]:
        """1 and 0: whether the width is held, and whether the film pulls; the latter unknown (None) for numbers."""
        if traced(xp):
            return 0.5 + 0.5 * n["width_held"], 0.5 + 0.5 * n["pulls"]
        own = self.local(xx, squared, 0.0, n)
        return np.where((own.excess >= 0.0) & (own.hoop >= own.r), 1.0, 0.0), None

    def _at(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Local, Any, Any, Any]:
        """The film's own state, K s1/q (beyond the border of the force what has its sign), 1 where its width is held,
        and 1 where it pulls."""
        held, pulls = self._switches(xx, squared, n, xp)
        mixed = pulls is not None and known(pulls) != 1.0  # also without force, where s2 = 0 may have no root

        def free(xx: Any) -> Any:
            """The width at A q = B n: where its hoop is taut there, a film without force begins to pull."""
            return (n["A"] - n["B"]) / n["B"] + (n["A"] / n["B"]) * xx

        def residual(y: Any, xx: Any, squared: Any, xp: Any) -> Any:
            wide = self.local(xx, squared, y, n, xp).excess
            if mixed:
                wide = pulls * wide + (1.0 - pulls) * (y - free(xx))
            return held * y + (1.0 - held) * wide

        def first(xx: Any, squared: Any, xp: Any) -> Any:
            """The larger one of 1 and the n at which the hoop is stress-free without voltage, less 1: Newton's method
            comes to the root from below, where a film that is too short has no second one."""
            wide = xp.sqrt(n["G"] / (n["B"] * (1.0 + xx))) - 1.0
            return 0.5 * (wide + xp.sqrt(wide * wide))

        y: Any
        if xp is np and np.all(held):  # the root of all is 0
            y = np.zeros(np.broadcast_shapes(np.shape(xx), np.shape(squared)))[()]
        elif known(held) == 1.0:
            y = 0.0
        elif known(held) == known(pulls) == 0.0:
            own = self.local(xx, squared, free(xx), n, xp)
            return own, own.excess, held, pulls
        else:
            y = root(xp, _root_name("width", squared, n, xp), residual, (xx, squared), first)
        own = self.local(xx, squared, y, n, xp)
        # where the width is held n = 1, without force A q = B n; elsewhere the excess is zero
        share = held + (1.0 - held) * (1.0 - pulls) if mixed else held
        pull = own.lead + share * own.excess
        if pulls is None:
            pulls = np.where((pull > 0.0) & (xx > n["shortest"]), 1.0, 0.0)
        return own, pull, held, pulls

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x s1/q and its slope; NaN where the energy has no minimum any more."""
        if self.branches and y:
            return self.creeping.force(x, squared, y, n, xp)
        xx = x * x
        own, pull, held, pulls = self._at(xx, squared, n, xp)
        if traced(xp):
            pulls = pulls * self._whole(n)
        elif not self.goes_on:
            pulls = np.where(self._gone(xx, squared, n), np.nan, pulls)
        tension = pull / own.compliance
        stiffening = self.law.stiffening(own.strain, n, xp)
        a, b = own.meridian - own.r, own.hoop - own.r
        firm = own.compliance * own.r
        along = 2.0 * firm + stiffening * (a * a)
        across = 2.0 * firm + stiffening * (b * b)
        mixed = firm - own.compliance * b + stiffening * (a * b)  # with s2 = 0
        unit = (1.0 - own.flatness) / own.compliance
        slope = (along - (1.0 - held) * (mixed * mixed / across)) * (unit * unit)
        return x * (pulls * tension), pulls * (tension + 2.0 * xx * slope)

    # --- borders -------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """``width_held`` tells taut from hoop-slack, and without force A q < B from A q > B; ``pulls`` tells with from
        without force; ``crumpled`` tells meridional slack from crumpled there, ``long`` a film that
        may begin to pull from one that is too short, ``below_hump`` one before the hump from one beyond the valley. The
        last border ends the film; where a run goes on, ``whole`` tells whether it has failed instead."""
        if self.branches:
            return self.creeping.borders
        return (
            Border(self._width_border, "width_held", divides=True),
            Border(self._force_border, "pulls", divides=True),
            Border(self._crumpling_border, "crumpled"),
            Border(self._length_border, "long", seldom=True),
            Border(self._hump_border, "below_hump", seldom=not self.goes_on),
            Border(self._failure_border, "whole", jumps=True)
            if self.goes_on
            else Border(self._end_border, seldom=self.pull_in != "minimum"),
        )

    def _width_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        own, _, held, pulls = self._at(x * x, squared, n, xp)
        side = n["width_held"]
        stretched, wider, slack = side * (pulls * held), side * (pulls * (1.0 - held)), side * (1.0 - pulls)
        return stretched * own.excess - wider * own.y + slack * (n["edge"] - n["A"] * (x * x))

    def _force_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pull, _, pulls = self._at(x * x, squared, n, xp)
        value, long = n["pulls"] * pull, 0.5 + 0.5 * n["long"]
        return pulls * value + (1.0 - pulls) * (long * value + (1.0 - long))

    def _length_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._switches(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * (n["long"] * (x * x - n["shortest"]))

    def _crumpling_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._switches(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * (n["crumpled"] * (squared - n["crumpling_squared"]))

    def _end_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        own, _, held, pulls = self._at(x * x, squared, n, xp)
        below = 0.5 + 0.5 * n["below_hump"]
        slack = below * (n["limit_squared"] - squared) + (1.0 - below) * self._beyond_valley(x, n)
        if self.pull_in == "minimum":
            return pulls + (1.0 - pulls) * slack
        with_force = held + (1.0 - held) * self._ellipticity(own, n, xp)
        return pulls * with_force + (1.0 - pulls) * slack

    def _beyond_valley(self, x: Any, n: Numbers) -> Any:
        """Positive where the disc stretches the film beyond the valley."""
        return n["A"] * (1.0 + x * x) - n["valley"]

    def _whole(self, n: Numbers) -> Any:
        """1, or 0 once the film has failed and does not pull."""
        return 0.5 + 0.5 * n["whole"] if self.pull_in == "snap" else 1.0

    def _hump_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        before = n["below_hump"] * (n["end_of_slack"] - n["A"] * (1.0 + x * x))
        if self.goes_on:
            return before
        _, pulls = self._switches(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * before

    def _failure_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, _, _, pulls = self._at(x * x, squared, n, xp)
        whole, below = 0.5 + 0.5 * n["whole"], 0.5 + 0.5 * n["below_hump"]
        above = squared - n["limit_squared"]
        lost = below * above - (1.0 - below) * self._beyond_valley(x, n)
        fails = pulls - (1.0 - pulls) * lost
        if self.pull_in == "memoryless":
            returns = (1.0 - pulls) * lost - pulls
        else:
            held = pulls * (n["valley"] - n["A"] * (1.0 + x * x))
            returns = (squared - n["valley_squared"]) * (1.0 - pulls + held)
        return whole * fails + (1.0 - whole) * returns

    def _ellipticity(self, own: Local, n: Numbers, xp: Any) -> Any:
        """Positive as long as the meridional force of the hoop-slack film grows with a ring's length: h + 2 q dh/dq."""
        stiffening = self.law.stiffening(own.strain, n, xp)
        a, b, r = own.meridian, own.hoop, own.r
        thin = b - r
        soft = r * (a + 3.0 * b) - b * b
        stiff = (thin * thin) * (5.0 * a - b) + 4.0 * (r * ((a - r) * (a - b)))
        return 2.0 * (own.compliance * soft) + stiffening * stiff

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        xx = np.square(x)
        if self.branches and y:
            m, width = self.creeping.solved(1.0 + xx, squared, y, n)
            tight, narrow = np.where(m <= 1.0 + xx, 1.0, -1.0), np.where(width <= 1.0, 1.0, -1.0)
            gone = np.isnan(m) | np.isnan(width)
            return {"meridian_held": np.where(gone, np.nan, tight), "width_held": np.where(gone, np.nan, narrow)}
        with np.errstate(all="ignore"):
            _, _, held, pulls = self._at(xx, squared, n, np)
        gone = self._gone(xx, squared, n)
        pulls = np.where(gone, 0.0, pulls)  # where s2 = 0 has no root, Newton's method ends anywhere
        slack_side = np.where(n["A"] * xx <= n["edge"], 1.0, 0.0)
        return {
            "width_held": np.where(np.where(pulls > 0.0, held, slack_side) > 0.0, 1.0, -1.0),
            "pulls": np.where(pulls > 0.0, 1.0, -1.0),
            "crumpled": np.where(squared > n["crumpling_squared"], 1.0, -1.0),
            "long": np.where(xx > n["shortest"], 1.0, -1.0),
            "below_hump": np.where(n["A"] * (1.0 + xx) < n["end_of_slack"], 1.0, -1.0),
        } | ({"whole": np.where(gone, -1.0, 1.0)} if self.goes_on else {})

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        place = np.arange(dwell.shape[1])
        negative = {name: (place >> k) & 1 == 1 for k, name in enumerate(switches)}
        if self.branches:
            tight, narrow = ~negative["meridian_held"], ~negative["width_held"]
            own = [tight & narrow, tight & ~narrow, ~tight & narrow, ~tight & ~narrow]
            return np.stack([dwell[:, which].sum(axis=1) for which in own], axis=1)
        held, pulls, crumpled = (~negative[name] for name in ("width_held", "pulls", "crumpled"))
        places = [pulls & held, pulls & ~held, ~pulls & ~crumpled, ~pulls & crumpled]
        if self.goes_on:
            places = [where & ~negative["whole"] for where in places] + [negative["whole"]]
        return np.stack([dwell[:, which].sum(axis=1) for which in places], axis=1)

    def pull_in_kind(self, switches: Numbers) -> Any:
        return np.where(
            switches["meridian_held" if self.branches else "pulls"] > 0.0, FilmPullIn.LOCALISATION, FilmPullIn.MINIMUM
        )

    # --- its own lengths -------------------------------------------------------------------------------------------

    def lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Squared true meridional and hoop length of the film over the mounted ones, m and n; NaN once it has pulled
        in, and where x is unknown."""
        xx, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(squared, dtype=float))
        with np.errstate(all="ignore"):
            own, _, _, pulls = self._at(xx, squared, n, np)
            m, width = np.array(1.0 + xx), np.array(np.broadcast_to(1.0 + own.y, xx.shape))
            gone, slack = np.isnan(xx) | self._gone(xx, squared, n), pulls == 0.0
            crumpled = slack & ~gone & (squared > n["crumpling_squared"])
            if crumpled.any():
                there = _taken(n, crumpled)
                t = self._natural(xx[crumpled], squared[crumpled], there)
                m[crumpled], width[crumpled] = t / there["A"], t / there["B"]
            held = slack & ~gone & ~crumpled
            if held.any():
                m[held], width[held] = self._natural_meridian(xx[held], squared[held], _taken(n, held)), 1.0
        return np.where(gone, np.nan, m)[()], np.where(gone, np.nan, width)[()]

    def _natural(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """The squared stretch t of a crumpled film, V G = Vb(t), before the hump or behind the valley."""
        least = np.maximum(n["A"] * (1.0 + xx), n["B"])
        behind = least >= n["valley"]
        low = np.where(behind, least, 1.0)
        most = 0.5 * (self.strain_limit(n) + 3.0)
        high = np.minimum(np.where((n["hump"] < NEVER) & ~behind, n["hump"], most), MOST_STRETCHED)
        return rise(lambda t: self.crumpling(t, n) - squared * n["G"], low, high)

    def _natural_meridian(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """The m of a meridionally slack film, s1 = 0 at n = 1."""
        longest = np.maximum(n["B"] / n["A"] - 1.0, xx)

        def pull(at: Any) -> Any:
            own = self.local(at, squared, 0.0, n)
            return own.lead + own.excess  # unlike the stress itself without a pole at the stretch limit

        return 1.0 + rise(pull, xx, longest)

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """m n."""
        if self.branches and y:
            m, width, _, _ = self.creeping.lengths(1.0 + x * x, squared, y, n, xp)
            return m * width
        if not traced(xp):
            m, width = self.lengths(x, squared, n)
            return m * width
        if not self.traced_charge:
            return Film.capacitance(self, x, squared, y, n, xp)
        own, _, _, pulls = self._at(x * x, squared, n, xp)
        with_force = (1.0 + x * x) * (1.0 + own.y)
        if known(pulls) == 1.0:
            return with_force
        m = self._slack_meridian(x * x, squared, pulls, n, xp)
        return pulls * with_force + (1.0 - pulls) * (m * self._slack_width(m, n))

    def _slack_width(self, m: Any, n: Numbers) -> Any:
        """The n of a film without force in a program: 1, or that at which A m = B n where it is crumpled."""
        crumpled = 0.5 + 0.5 * n["crumpled"]
        return (1.0 - crumpled) + crumpled * (n["A"] / n["B"]) * m

    def _slack_meridian(self, xx: Any, squared: Any, pulls: Any, n: Numbers, xp: Any) -> Any:
        """The m of a film without force in a program, the root of s1 = 0; q where it ``pulls``."""
        A, B, G = (n[name] for name in "ABG")

        def residual(m: Any, xx: Any, squared: Any, xp: Any) -> Any:
            width = self._slack_width(m, n)
            thickness = G / (m * width)
            compliance = self.law.compliance(A * m + B * width + thickness - 3.0, n, xp)
            slack = (A - thickness / m) / width - squared * compliance
            return slack if known(pulls) == 0.0 else pulls * (m - 1.0 - xx) + (1.0 - pulls) * slack

        def first(xx: Any, squared: Any, xp: Any) -> Any:
            """The larger one of q and the m without voltage, or where it is crumpled that of A m = B: Newton's method
            comes to the root from below."""
            crumpled = 0.5 + 0.5 * n["crumpled"]
            more = crumpled * (B / A) + (1.0 - crumpled) * xp.sqrt(G / A) - 1.0 - xx
            return 1.0 + xx + 0.5 * (more + xp.sqrt(more * more))

        return root(xp, _root_name("length", squared, n, xp), residual, (xx, squared), first)

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """W - V (m n - 1)/2, and what the branches store."""
        m, width = self._lengths_at(x, squared, y, n)
        strain = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
        own = self.law.energy(strain, n) - 0.5 * squared * (m * width - 1.0)
        return own + self.viscous.energy(m, width, y, n) if self.branches and y else own

    def _lengths_at(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """`lengths` at the states of the branches."""
        if not (self.branches and y):
            return self.lengths(x, squared, n)
        return self.creeping.solved(1.0 + np.square(x), squared, y, n)

    def branch_lengths(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return self.creeping.lengths(1.0 + x * x, squared, y, n, xp)[:2]

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        if not (self.branches and y):
            return super().limit_share(x, voltage, y, n)
        m, width = self._lengths_at(x, np.square(voltage), y, n)
        own = self.state_of_lengths(m, width, voltage, n).limit_share
        return np.fmax(own, self.viscous.limit_share(m, width, y, n))

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return Film.voltage_force(self, x, squared, y, n, xp)

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        return Film.voltage_gain(self, x, squared, n)

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """Of the film at its own lengths: no stress is negative; NaN once it has pulled in."""
        m, width = self._lengths_at(x, np.square(voltage), y, n)
        kind = np.where(np.isnan(m), len(STATES) if self.goes_on else -1, _place(x, m, width))
        own = (0.0, 0.0) if not (self.branches and y) else self.viscous.stresses(m, width, y, n)
        return self.state_of_lengths(m, width, voltage, n, own)._replace(kind=kind)

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        """The stresses are those at the film's own lengths; its share of the limit is that without voltage."""
        if self.goes_on:
            return None
        xx = x * x
        m, width = self._traced_lengths(xx, squared, y, n, xp)
        creeps = self.branches and y
        found = self.traced_ring(
            m, width, squared, n, xp, self.viscous.stresses(m, width, y, n) if creeps else (0.0, 0.0)
        )
        stresses = [xp.maximum(stress, 0.0) for stress in found[:2]]
        if creeps:
            share = xp.maximum(found.limit_share, self.viscous.limit_share(m, width, y, n, xp))
        else:
            long = xp.maximum(1.0 + xx, 1.0 / (n["A"] * xp.sqrt(xp.maximum(n["B"], 1.0))))
            wide = xp.maximum(xp.sqrt(n["G"] / (n["B"] * long)), 1.0)
            share = self.traced_ring(long, wide, 0.0, n, xp).limit_share
        return found._replace(meridional_stress=stresses[0], hoop_stress=stresses[1], limit_share=share)

    def _traced_lengths(self, xx: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> tuple[Any, Any]:
        """`lengths` in a program."""
        if self.branches and y:
            return self.creeping.lengths(1.0 + xx, squared, y, n, xp)[:2]
        own, _, _, pulls = self._at(xx, squared, n, xp)
        if known(pulls) == 1.0:
            return 1.0 + xx, 1.0 + own.y
        m = self._slack_meridian(xx, squared, pulls, n, xp)
        slack = self._slack_width(m, n)
        return pulls * (1.0 + xx) + (1.0 - pulls) * m, pulls * (1.0 + own.y) + (1.0 - pulls) * slack

    def state_of_lengths(
        self, m: Any, width: Any, voltage: Any, n: Numbers, more: tuple[Any, Any] = (0.0, 0.0)
    ) -> FilmState:
        """Of a ring of those squared lengths, over the mounted ones; ``more`` are stresses besides the law's."""
        squared = np.square(voltage)
        l1, l2 = np.sqrt(n["A"] * m), np.sqrt(n["B"] * width)
        l3 = 1.0 / (l1 * l2)
        strain = l1 * l1 + l2 * l2 + l3 * l3 - 3.0
        response, field = self.law.response(strain, n), squared * (m * width)

        def stress(stretch: Any, own: Any) -> Any:
            tension = (stretch * stretch - l3 * l3) * response - field + own
            return np.where(np.isnan(tension), np.nan, np.maximum(tension, 0.0))[()]

        return FilmState(
            meridional_stretch=l1,
            hoop_stretch=l2,
            thickness_stretch=l3,
            meridional_stress=stress(l1, more[0]),
            hoop_stress=stress(l2, more[1]),
            true_field=np.abs(voltage) * np.sqrt(m * width),
            limit_share=strain / self.law.strain_limit(n),
        )

    def describe(self) -> str:
        ends = _STUDIES[self.pull_in] + self.viscous.words
        return f"wrinkling film: a homogeneous cone without compression; pull-in voltages are upper bounds{ends}"

    # --- statics -----------------------------------------------------------------------------------------------------

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        return Film.turning(self, x, squared, n)

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """Where the film is taut h - pull, else the V of the width at which it pulls so. No voltage makes a film push:
        a negative ``pull`` takes a V that rises too steeply to be reached, so that the result stays monotone."""
        xx, pull = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(pull, dtype=float))
        wanted = np.maximum(pull, 0.0)
        with np.errstate(all="ignore"):
            taut = super().balancing(x, wanted, n)
            widest = np.maximum(n["A"] * (1.0 + xx) / n["B"] - 1.0, 0.0)

            def weakness(y: Any) -> Any:
                own = self.local(xx, 0.0, y, n)
                return np.where(own.compliance > 0.0, wanted * own.compliance - own.lead, -1.0)

            own = self.local(xx, 0.0, rise(weakness, np.zeros_like(widest), widest), n)
            held = self.local(xx, taut, 0.0, n).excess >= 0.0
            # no voltage slackens a film that would be beyond its stretch limit without tension
            wrinkled = np.where(own.compliance > 0.0, own.excess / own.compliance, np.inf)
        return (np.where(held, taut, wrinkled) - STEEP * np.minimum(pull, 0.0))[()]

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V at which it pulls in at x; behind the valley, where it does not, `UNREACHED`."""
        xx = np.square(np.asarray(x, dtype=float))
        with np.errstate(all="ignore"):
            t = n["A"] * (1.0 + xx)
            limit = np.where(t > n["end_of_slack"], self.crumpling(t, n) / n["G"], n["limit_squared"])
            limit = np.where(t >= n["valley"], UNREACHED, limit)
            if self.pull_in == "first":
                limit = np.minimum(limit, self._localising(xx, n))
        return np.where(limit >= NEVER, np.inf, limit)[()]

    def highest_squared_held(self, x: Any, y: list[Any], n: Numbers) -> Any:
        return self.creeping.highest_squared(x, y, n) if self.branches and y else self.highest_squared(x, n)

    def _localising(self, xx: Any, n: Numbers) -> Any:
        """The V at which a film held at x localises; infinite where it does not."""
        widest = np.maximum((n["A"] * (1.0 + xx)) / n["B"] - 1.0, 0.0)

        def at(y: Any) -> Local:
            return self.local(xx, 0.0, y, n)

        def localisation(y: Any) -> Any:
            own = at(y)
            return np.where(own.compliance > 0.0, -self._ellipticity(own, n, np), np.inf)

        # behind the valley a film that has localised would be stable again before it loses its tension
        behind = n["A"] * (1.0 + xx) >= n["valley"]
        least = np.where(behind, _highest(localisation, widest), widest) if np.any(behind) else widest
        own = at(rise(localisation, np.zeros_like(widest), least))
        found = (widest > 0.0) & (localisation(least) > 0.0) & (own.compliance > 0.0)
        return np.where(found, own.excess / own.compliance, np.inf)  # the V that makes the hoop stress 0

    # --- where it has a state --------------------------------------------------------------------------------------

    def strain(self, x: Any, n: Numbers) -> Any:
        """I1 - 3 at the lengths that the film takes without voltage: one that is too short for its gap wrinkles instead
        of being compressed to its stretch limit."""
        A, B, G = (n[name] for name in "ABG")
        q = 1.0 + np.square(x)
        with np.errstate(all="ignore"):
            m = np.maximum(q, np.sqrt(G / A))
            wide = A * q + 2.0 * np.sqrt(G * B / q) - 3.0
            wrinkled = np.where(A * q >= np.sqrt(G * B / q), wide, 0.0)
            return np.where(B * m >= G, A * m + B + G / m - 3.0, wrinkled)[()]

    def _gone(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """Whether the energy's minimum has ended."""
        with np.errstate(all="ignore"):
            t = n["A"] * (1.0 + xx)
            limit = np.where(t > n["end_of_slack"], self.crumpling(t, n) / n["G"], n["limit_squared"])
            return (squared > limit) & (t < n["valley"])


def _root_name(of: str, squared: Any, n: Numbers, xp: Any) -> str:
    """Name of a root in a program, of either film of a double cone and at whichever voltage a circuit asks for."""
    film = getattr(n["crumpled"], "value", "")
    return f"natural {of}, {film}, {xp.node(squared).index}" if traced(xp) else of


def _place(x: Any, m: Any, width: Any) -> Any:
    """The place in `STATES` of a film of these lengths; -1 where it has pulled in."""
    with np.errstate(invalid="ignore"):
        longer = m > (1.0 + np.square(x)) * (1.0 + ROUNDING)
        place = 2 * longer + (width > 1.0 + ROUNDING)
    return np.where(np.isnan(m), -1, place)


def _highest(function: Callable[[Any], Any], end: Any) -> Any:
    """Where between 0 and ``end`` a function of an array is largest, with one maximum inside or at the end: by golden
    sections, each of which leaves 0.62 of the range."""
    low, high = np.zeros_like(end), np.array(end, dtype=float)
    for _ in range(GOLDEN_STEPS):
        first, second = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        left = function(first) > function(second)
        low, high = np.where(left, low, first), np.where(left, second, high)
    middle = 0.5 * (low + high)
    return np.where(function(end) >= function(middle), end, middle)


def _taken(n: Numbers, where: Any) -> dict[str, Any]:
    """The numbers at those of many places."""
    return {name: np.broadcast_to(value, where.shape)[where] for name, value in n.items()}


def _crumpling(law: StrainEnergyLaw, t: Any, n: Numbers) -> Any:
    """Vb(t) = R (1 - t^-3)/t."""
    inverse = 1.0 / t
    square = inverse * inverse
    return law.response(2.0 * t + square - 3.0, n) * (inverse - square * square)


def _crumpling_slope(law: StrainEnergyLaw, t: Any, n: Numbers) -> Any:
    """Derivative of Vb(t)."""
    inverse = 1.0 / t
    square = inverse * inverse
    strain, strain_slope = 2.0 * t + square - 3.0, 2.0 - 2.0 * square * inverse
    shape, shape_slope = inverse - square * square, 4.0 * square * square * inverse - square
    return law.response_slope(strain, n) * strain_slope * shape + law.response(strain, n) * shape_slope


def _turnings(law: StrainEnergyLaw, n: Numbers) -> tuple[Array, Array]:
    """The t of the first maximum of Vb and of the minimum behind it; infinity where there is none. In the shape of the
    law's numbers."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in n.values())) if n else [np.zeros(())]
    rows, place = np.unique(np.stack([array.ravel() for array in arrays]), axis=1, return_inverse=True)
    hump, valley = _turnings_of(law, tuple(n), rows.tobytes(), rows.shape[1])
    return hump[place].reshape(arrays[0].shape), valley[place].reshape(arrays[0].shape)


@lru_cache(maxsize=256)
def _turnings_of(law: StrainEnergyLaw, names: tuple[str, ...], rows: bytes, count: int) -> tuple[Array, Array]:
    """Those of films of one law, (count,); ``rows`` holds the law's numbers, (names, count). Kept, since they change
    with the gel alone and take longer than many a motion."""
    values = np.frombuffer(rows).reshape(-1, count)
    numbers = {name: row[:, None] for name, row in zip(names, values, strict=False)}

    def slope(t: Any) -> Any:
        return _crumpling_slope(law, t[:, None], numbers)[:, 0]

    with np.errstate(all="ignore"):
        limit = np.broadcast_to(law.strain_limit(numbers), (count, 1))
        most = np.minimum(0.5 * (limit + 3.0), MOST_STRETCHED)
        t = np.exp(np.log(most) * np.linspace(0.0, 1.0, GRID)[1:-1])
        falls = _crumpling_slope(law, t, numbers) < 0.0
        first = np.argmax(falls, axis=1)
        low = np.where(first > 0, np.take_along_axis(t, np.maximum(first - 1, 0)[:, None], 1)[:, 0], 1.0)
        high = np.take_along_axis(t, first[:, None], 1)[:, 0]
        hump = rise(lambda t: -slope(t), low, high)
        # Vb falls from the hump to the valley and rises from there to the stretch limit
        end = most[:, 0]
        valley = rise(slope, hump * (1.0 + ROUNDING), end)
    turns = falls.any(axis=1)
    hump = np.where(turns, hump, np.inf)
    valley = np.where(turns & (valley < end * (1.0 - ROUNDING)), valley, np.inf)
    hump.flags.writeable = valley.flags.writeable = False
    return hump, valley
