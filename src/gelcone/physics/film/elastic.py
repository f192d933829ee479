"""A wrinkling film without branches: force, lengths and borders, in closed form but for one root.

Symbols and states of tension as in `gelcone.physics.film.wrinkling`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from gelcone.bracket import rise
from gelcone.membrane.crumpling import MOST_STRETCHED, SAME_STRETCH, crumpling
from gelcone.membrane.force import NEVER
from gelcone.physics.component import Numbers
from gelcone.physics.film.creeping import UNREACHED
from gelcone.physics.film.film import Border
from gelcone.physics.film.taut import TautCone
from gelcone.physics.implicit import known, root, traced
from gelcone.quantity import taken

STEEP = 1e10
"""Slope, over a push, of the V that stands for it: no voltage makes a film push, so that V exceeds `UNREACHED`."""
GOLDEN, GOLDEN_STEPS = 0.6180339887498949, 40


class Local(NamedTuple):
    """Quantities at a point of the film, at m = q and n = 1 + y: symbols as in `gelcone.physics.film.wrinkling`.

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


class Elastic:
    """The formulas of a wrinkling ``film`` without branches; ``pull_in`` as in `WrinklingCone`."""

    def __init__(self, film: TautCone, pull_in: str) -> None:
        self.film, self.law, self.pull_in = film, film.law, pull_in

    @property
    def continues(self) -> bool:
        """Whether a run continues after the film has pulled in."""
        return self.pull_in in ("memoryless", "snap")

    # --- force ---------------------------------------------------------------------------------------------------

    def local(self, xx: Any, squared: Any, y: Any, n: Numbers, xp: Any = np) -> Local:
        """Quantities at x^2, V and y = n - 1, in a form without cancellation."""
        A, B, G = (n[name] for name in "ABG")
        flatness = xx / (1.0 + xx)  # 1 - 1/q
        larger = xx + (y + y * xx)  # q n - 1
        thinning = larger / (1.0 + larger)  # 1 - 1/(q n)
        strain = (A + B + G - 3.0) + A * xx + B * y - G * thinning
        compliance = self.law.compliance(strain, n, xp)
        # (B n - r)/(q n), r = G (1 - thinning)
        elastic = (B - G) + (2.0 * G - B) * thinning - G * (thinning * thinning) + (B * y) * (1.0 - thinning)
        lead = (A - B) + B * (flatness - y + y * flatness)
        excess = elastic - squared * compliance
        return Local(y, flatness, G - G * thinning, compliance, strain, A + A * xx, B + B * y, lead, excess)

    def _excess_slope(self, xx: Any, squared: Any, y: Any, n: Numbers) -> Any:
        """The derivative of the `local` excess by y."""
        local, wide = self.local(xx, squared, y, n), 1.0 + y
        thin = local.r / wide
        stiffening = self.law.stiffening(local.strain, n)
        return 2.0 * thin / ((1.0 + xx) * wide) + squared * stiffening * (n["B"] - thin)

    def _held_and_pulling(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Any, Any]:
        """Flags, 1 or 0, of a held width and of a film that pulls; the second is None, not known yet, for arrays."""
        if traced(xp):
            return 0.5 + 0.5 * n["width_held"], 0.5 + 0.5 * n["pulls"]
        local = self.local(xx, squared, 0.0, n)
        return np.where((local.excess >= 0.0) & (local.hoop >= local.r), 1.0, 0.0), None

    def tension(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Local, Any, Any, Any]:
        """Local quantities; K s1/q, or where the film does not pull a value of its sign; and flags, 1 or 0, of a held
        width and of a film that pulls."""
        held, pulls = self._held_and_pulling(xx, squared, n, xp)
        mixed = pulls is not None and known(pulls) != 1.0  # also without force, where s2 = 0 may have no root

        def free(xx: Any) -> Any:
            """The width at A q = B n, at which a film without force begins to pull if its hoop is taut."""
            return (n["A"] - n["B"]) / n["B"] + (n["A"] / n["B"]) * xx

        def residual(y: Any, xx: Any, squared: Any, xp: Any) -> Any:
            wide = self.local(xx, squared, y, n, xp).excess
            if mixed:
                wide = pulls * wide + (1.0 - pulls) * (y - free(xx))
            return held * y + (1.0 - held) * wide

        def slope(y: Any, xx: Any, squared: Any) -> Any:
            return held + (1.0 - held) * self._excess_slope(xx, squared, y, n)

        def first(xx: Any, squared: Any, xp: Any) -> Any:
            """The larger of 1 and the stress-free n without voltage, less 1: Newton's method approaches the root from
            below, where a film that is too short has no second root."""
            wide = xp.sqrt(n["G"] / (n["B"] * (1.0 + xx))) - 1.0
            return 0.5 * (wide + xp.sqrt(wide * wide))

        y: Any
        if xp is np and np.all(held):  # the root of all is 0
            y = np.zeros(np.broadcast_shapes(np.shape(xx), np.shape(squared)))[()]
        elif known(held) == 1.0:
            y = 0.0
        elif known(held) == known(pulls) == 0.0:
            local = self.local(xx, squared, free(xx), n, xp)
            return local, local.excess, held, pulls
        else:
            y = root(xp, _root_name("width", squared, n, xp), residual, (xx, squared), first, slope=slope)
        local = self.local(xx, squared, y, n, xp)
        # where the width is held n = 1, without force A q = B n; elsewhere the excess is zero
        share = held + (1.0 - held) * (1.0 - pulls) if mixed else held
        pull = local.lead + share * local.excess
        if pulls is None:
            pulls = np.where((pull > 0.0) & (xx > n["shortest"]), 1.0, 0.0)
        return local, pull, held, pulls

    def force(self, x: Any, squared: Any, n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x s1/q and its slope by x; NaN where the energy no longer has a minimum."""
        xx = x * x
        local, pull, held, pulls = self.tension(xx, squared, n, xp)
        if traced(xp):
            pulls = pulls * self._whole(n)
        elif not self.continues:
            pulls = np.where(self._gone(xx, squared, n), np.nan, pulls)
        tension = pull / local.compliance
        along, mixed, across = self._slopes(local, n, xp)
        unit = (1.0 - local.flatness) / local.compliance
        slope = (along - (1.0 - held) * (mixed * mixed / across)) * (unit * unit)
        return x * (pulls * tension), pulls * (tension + 2.0 * xx * slope)

    def _slopes(self, own: Local, n: Numbers, xp: Any) -> tuple[Any, Any, Any]:
        """The slopes of s1 by ln q and by ln n, and of s2 by ln n, times K^2, where s2 = 0."""
        stiffening = self.law.stiffening(own.strain, n, xp)
        a, b = own.meridian - own.r, own.hoop - own.r
        firm = own.compliance * own.r
        along = 2.0 * firm + stiffening * (a * a)
        across = 2.0 * firm + stiffening * (b * b)
        mixed = firm - own.compliance * b + stiffening * (a * b)
        return along, mixed, across

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        """-dF/dV, of arrays: x n (1 + d ln n/d ln q), half the slope of the charge over the voltage by x."""
        xx = np.square(x)
        local, _, held, pulls = self.tension(xx, squared, n, np)
        if not self.continues:
            pulls = np.where(self._gone(xx, squared, n), np.nan, pulls)
        _, mixed, across = self._slopes(local, n, np)
        return (x * (pulls * ((1.0 + local.y) * (1.0 - (1.0 - held) * (mixed / across)))))[()]

    # --- borders -----------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:
        """Borders with their switches: ``width_held`` (taut or hoop-slack; without force A q < B or A q > B), ``pulls``
        (with or without force), ``crumpled`` (crumpled or meridional slack), ``long`` (may begin to pull, or too
        short), ``below_hump`` (before the hump, or beyond the valley). The film ends at the last border; where a run
        continues, that border has the switch ``whole`` (intact or failed)."""
        return (
            Border(self._width_border, "width_held", divides=True, gentle=self.pull_in == "first"),
            Border(self._force_border, "pulls", divides=True, gentle=self.pull_in == "first"),
            Border(self._crumpling_border, "crumpled"),
            Border(self._length_border, "long", seldom=True),
            Border(self._hump_border, "below_hump", seldom=not self.continues),
            Border(self._failure_border, "whole", jumps=True)
            if self.continues
            else Border(self._end_border, seldom=self.pull_in != "minimum"),
        )

    def _width_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        local, _, held, pulls = self.tension(x * x, squared, n, xp)
        side = n["width_held"]
        stretched, wider, slack = side * (pulls * held), side * (pulls * (1.0 - held)), side * (1.0 - pulls)
        return stretched * local.excess - wider * local.y + slack * (n["edge"] - n["A"] * (x * x))

    def _force_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pull, _, pulls = self.tension(x * x, squared, n, xp)
        value, long = n["pulls"] * pull, 0.5 + 0.5 * n["long"]
        return pulls * value + (1.0 - pulls) * (long * value + (1.0 - long))

    def _length_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._held_and_pulling(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * (n["long"] * (x * x - n["shortest"]))

    def _crumpling_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, pulls = self._held_and_pulling(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * (n["crumpled"] * (squared - n["crumpling_squared"]))

    def _end_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        local, _, held, pulls = self.tension(x * x, squared, n, xp)
        below = 0.5 + 0.5 * n["below_hump"]
        slack = below * (n["limit_squared"] - squared) + (1.0 - below) * self._beyond_valley(x, n)
        if self.pull_in == "minimum":
            return pulls + (1.0 - pulls) * slack
        with_force = held + (1.0 - held) * self._ellipticity(local, n, xp)
        return pulls * with_force + (1.0 - pulls) * slack

    def _hump_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        before = n["below_hump"] * (n["end_of_slack"] - n["A"] * (1.0 + x * x))
        if self.continues:
            return before
        _, pulls = self._held_and_pulling(x * x, squared, n, xp)
        return pulls + (1.0 - pulls) * before

    def _failure_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        _, _, _, pulls = self.tension(x * x, squared, n, xp)
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

    def _beyond_valley(self, x: Any, n: Numbers) -> Any:
        """Positive where the disc stretches the film beyond the valley."""
        return n["A"] * (1.0 + x * x) - n["valley"]

    def _whole(self, n: Numbers) -> Any:
        """1, or 0 once the film has failed and does not pull."""
        return 0.5 + 0.5 * n["whole"] if self.pull_in == "snap" else 1.0

    def _ellipticity(self, own: Local, n: Numbers, xp: Any) -> Any:
        """Positive while the meridional force of the hoop-slack film grows with a ring's length: h + 2 q dh/dq."""
        stiffening = self.law.stiffening(own.strain, n, xp)
        a, b, r = own.meridian, own.hoop, own.r
        thin = b - r
        soft = r * (a + 3.0 * b) - b * b
        stiff = (thin * thin) * (5.0 * a - b) + 4.0 * (r * ((a - r) * (a - b)))
        return 2.0 * (own.compliance * soft) + stiffening * stiff

    def switches(self, x: Any, squared: Any, n: Numbers) -> dict[str, Any]:
        """The switches of the borders, -1 or 1, at a state."""
        xx = np.square(x)
        with np.errstate(all="ignore"):
            _, _, held, pulls = self.tension(xx, squared, n, np)
        gone = self._gone(xx, squared, n)
        pulls = np.where(gone, 0.0, pulls)  # where s2 = 0 has no root, Newton's method ends anywhere
        slack_side = np.where(n["A"] * xx <= n["edge"], 1.0, 0.0)
        return {
            "width_held": np.where(np.where(pulls > 0.0, held, slack_side) > 0.0, 1.0, -1.0),
            "pulls": np.where(pulls > 0.0, 1.0, -1.0),
            "crumpled": np.where(squared > n["crumpling_squared"], 1.0, -1.0),
            "long": np.where(xx > n["shortest"], 1.0, -1.0),
            "below_hump": np.where(n["A"] * (1.0 + xx) < n["end_of_slack"], 1.0, -1.0),
        } | ({"whole": np.where(gone, -1.0, 1.0)} if self.continues else {})

    def combinations(self, negative: Mapping[str, Any]) -> list[Any]:
        """Masks over the combinations of switches, one for each state of the film; ``negative`` is True where a switch
        is -1."""
        held, pulls, crumpled = (~negative[name] for name in ("width_held", "pulls", "crumpled"))
        places = [pulls & held, pulls & ~held, ~pulls & ~crumpled, ~pulls & crumpled]
        return [where & ~negative["whole"] for where in places] + [negative["whole"]] if self.continues else places

    # --- lengths -----------------------------------------------------------------------------------------------------

    def lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Squared true meridional and hoop length of the film over the mounted ones, m and n; NaN once it has pulled
        in, and where x is NaN."""
        xx, squared = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(squared, dtype=float))
        with np.errstate(all="ignore"):
            local, _, _, pulls = self.tension(xx, squared, n, np)
            m, width = np.array(1.0 + xx), np.array(np.broadcast_to(1.0 + local.y, xx.shape))
            gone, slack = np.isnan(xx) | self._gone(xx, squared, n), pulls == 0.0
            crumpled = slack & ~gone & (squared > n["crumpling_squared"])
            if crumpled.any():
                numbers = _taken(n, crumpled)
                t = self._natural(xx[crumpled], squared[crumpled], numbers)
                m[crumpled], width[crumpled] = t / numbers["A"], t / numbers["B"]
            held = slack & ~gone & ~crumpled
            if held.any():
                m[held], width[held] = self._natural_meridian(xx[held], squared[held], _taken(n, held)), 1.0
        return np.where(gone, np.nan, m)[()], np.where(gone, np.nan, width)[()]

    def _natural(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """The squared stretch t of a crumpled film, V G = Vb(t), before the hump or behind the valley."""
        least = np.maximum(n["A"] * (1.0 + xx), n["B"])
        behind = least >= n["valley"]
        low = np.where(behind, least, 1.0)
        most = 0.5 * (self.law.strain_limit(n) + 3.0)
        high = np.minimum(np.where((n["hump"] < NEVER) & ~behind, n["hump"], most), MOST_STRETCHED)
        return rise(lambda t: crumpling(self.law, t, n) - squared * n["G"], low, high)

    def _natural_meridian(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """The m of a meridionally slack film, s1 = 0 at n = 1."""
        longest = np.maximum(n["B"] / n["A"] - 1.0, xx)

        def pull(at: Any) -> Any:
            local = self.local(at, squared, 0.0, n)
            return local.lead + local.excess  # unlike the stress itself without a pole at the stretch limit

        return 1.0 + rise(pull, xx, longest)

    def traced_lengths(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> tuple[Any, Any]:
        """`lengths` in a program."""
        local, _, _, pulls = self.tension(xx, squared, n, xp)
        if known(pulls) == 1.0:
            return 1.0 + xx, 1.0 + local.y
        m = self._slack_meridian(xx, squared, pulls, n, xp)
        slack = self._slack_width(m, n)
        return pulls * (1.0 + xx) + (1.0 - pulls) * m, pulls * (1.0 + local.y) + (1.0 - pulls) * slack

    def capacitance(self, xx: Any, squared: Any, n: Numbers, xp: Any) -> Any:
        """m n in a program."""
        local, _, _, pulls = self.tension(xx, squared, n, xp)
        with_force = (1.0 + xx) * (1.0 + local.y)
        if known(pulls) == 1.0:
            return with_force
        m = self._slack_meridian(xx, squared, pulls, n, xp)
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
            """The larger of q and the m without voltage, or where it is crumpled of A m = B: Newton's method approaches
            the root from below."""
            crumpled = 0.5 + 0.5 * n["crumpled"]
            more = crumpled * (B / A) + (1.0 - crumpled) * xp.sqrt(G / A) - 1.0 - xx
            return 1.0 + xx + 0.5 * (more + xp.sqrt(more * more))

        return root(xp, _root_name("length", squared, n, xp), residual, (xx, squared), first)

    # --- statics -----------------------------------------------------------------------------------------------------

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """Solve s1/q = ``pull`` for V: h - pull where the film is taut, else from its width.

        A film cannot push: for a negative ``pull`` V rises too steeply to be reached, and the result stays monotone.
        """
        xx, pull = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(pull, dtype=float))
        target = np.maximum(pull, 0.0)
        with np.errstate(all="ignore"):
            taut = TautCone.balancing(self.film, x, target, n)
            widest = np.maximum(n["A"] * (1.0 + xx) / n["B"] - 1.0, 0.0)

            def weakness(y: Any) -> Any:
                local = self.local(xx, 0.0, y, n)
                return np.where(local.compliance > 0.0, target * local.compliance - local.lead, -1.0)

            local = self.local(xx, 0.0, rise(weakness, np.zeros_like(widest), widest), n)
            held = self.local(xx, taut, 0.0, n).excess >= 0.0
            # no voltage slackens a film that would be beyond its stretch limit without tension
            wrinkled = np.where(local.compliance > 0.0, local.excess / local.compliance, np.inf)
        return (np.where(held, taut, wrinkled) - STEEP * np.minimum(pull, 0.0))[()]

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V at which the film pulls in at x; `UNREACHED` beyond the valley, where it does not."""
        xx = np.square(np.asarray(x, dtype=float))
        with np.errstate(all="ignore"):
            t = n["A"] * (1.0 + xx)
            limit = np.where(t > n["end_of_slack"], crumpling(self.law, t, n) / n["G"], n["limit_squared"])
            limit = np.where(t >= n["valley"], UNREACHED, limit)
            if self.pull_in == "first":
                limit = np.minimum(limit, self._localising(xx, n))
        return np.where(limit >= NEVER, np.inf, limit)[()]

    def _localising(self, xx: Any, n: Numbers) -> Any:
        """The V at which a film held at x localises; infinite where it does not."""
        xx = xx + np.zeros(np.broadcast_shapes(*map(np.shape, (xx, n["A"], n["B"], n["valley"]))))
        widest = np.asarray(np.maximum((n["A"] * (1.0 + xx)) / n["B"] - 1.0, 0.0))

        def localisation(y: Any, xx: Any = xx, n: Numbers = n) -> Any:
            local = self.local(xx, 0.0, y, n)
            return np.where(local.compliance > 0.0, -self._ellipticity(local, n, np), np.inf)

        # behind the valley a film that has localised would be stable again before it loses its tension
        behind, least = n["A"] * (1.0 + xx) >= n["valley"], np.array(np.fmin(widest, self._most_stretched(xx, n)))
        if np.any(behind):
            softness = partial(localisation, xx=xx[behind], n=_taken(n, behind))
            least[behind] = _highest(softness, least[behind])
        local = self.local(xx, 0.0, rise(localisation, np.zeros_like(widest), least), n)
        localises = (widest > 0.0) & (localisation(least) > 0.0) & (local.compliance > 0.0)
        return np.where(localises, local.excess / local.compliance, np.inf)  # the V that makes the hoop stress 0

    def _most_stretched(self, xx: Any, n: Numbers) -> Any:
        """The y next to the stretch limit of the film; 0 where it is beyond at every width."""
        sides, q = self.law.strain_limit(n) + 3.0 - n["A"] * (1.0 + xx), 1.0 + xx  # B n + G/(q n) at the limit
        root_of = np.sqrt(np.maximum(np.square(sides) - 4.0 * n["B"] * n["G"] / q, 0.0))
        wide = (sides + root_of) / (2.0 * n["B"])
        return np.fmax(wide * (1.0 - SAME_STRETCH) - 1.0, 0.0)

    def _gone(self, xx: Any, squared: Any, n: Numbers) -> Any:
        """Whether the energy's minimum has ended."""
        with np.errstate(all="ignore"):
            t = n["A"] * (1.0 + xx)
            limit = np.where(t > n["end_of_slack"], crumpling(self.law, t, n) / n["G"], n["limit_squared"])
            return (squared > limit) & (t < n["valley"])


def _root_name(of: str, squared: Any, n: Numbers, xp: Any) -> str:
    """The name of a root in a program, which differs between the films of a double cone and the voltages of a
    circuit."""
    film = getattr(n["crumpled"], "value", "")
    return f"natural {of}, {film}, {xp.node(squared).index}" if traced(xp) else of


def _highest(function: Callable[[Any], Any], end: Any) -> Any:
    """The maximum between 0 and ``end`` of a function of an array that has one, by golden-section search."""
    low, high = np.zeros_like(end), np.array(end, dtype=float)
    for _ in range(GOLDEN_STEPS):
        first, second = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        left = function(first) > function(second)
        low, high = np.where(left, low, first), np.where(left, second, high)
    middle = 0.5 * (low + high)
    return np.where(function(end) >= function(middle), end, middle)


def _taken(n: Numbers, where: Any) -> dict[str, Any]:
    """The numbers at the places in a mask."""
    return {name: taken(value, where) for name, value in n.items()}
