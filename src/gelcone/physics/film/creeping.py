"""A wrinkling film that creeps: the states of tension of `gelcone.physics.film.wrinkling` with Maxwell branches.

The energy is psi = W(A m + B n + G/(m n) - 3) + branches - V m n/2 at the states of the branches, and the film takes
its minimum over m >= q and n >= 1, followed in time. With the true stresses s1 = 2 m psi_m and s2 = 2 n psi_n, sums of
law, branches and field,

    taut              s1, s2 >= 0 at m = q, n = 1
    hoop-slack        m = q, and n > 1 so that s2 = 0
    meridional slack  n = 1, and m > q so that s1 = 0
    crumpled          s1 = s2 = 0: both lengths are found together, for the branches flow at them

The stresses say which border comes first, unlike in the elastic film: a film that has crept while it was wrinkled stays
slack longer, and its meridian may be slack before its hoops. psi_nn > 0, so that the width is unique.

The minimum ends where the Hessian of psi by (ln m, ln n) at the held states is singular (crumpled; meridional slack:
its first entry), and a hoop-slack film localises where 2 (h11 - h12^2/h22) - s1 < 0 with h_ij = d s_i/d ln(m, n): the
instant at which the runaway is faster than creep. Towards the end of a minimum its length grows like the root of the
time that is left, so that the run ends where the Hessian is `NEARLY` singular, less than 1e-6 before. Behind a series
resistance the length passes that end smoothly, and the charge says where it is (`gelcone.physics.system`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gelcone.bracket import rise
from gelcone.physics.component import Numbers
from gelcone.physics.film.film import Border
from gelcone.physics.film.taut import TautCone
from gelcone.physics.implicit import known, root, traced
from gelcone.quantity import Array, taken

NEARLY = 3e-4
"""The Hessian over the modulus, and over its square in two dimensions, at which a minimum counts as ended."""
MOST_STEPS = 200
ENOUGH = 1e-9
"""Newton's method squares its error: a correction by this share of a length leaves none that doubles hold."""
LONGEST_STEP = 0.1
"""Longest step of Newton's method, of a squared length over itself: behind the end of the minimum a film near its
stretch limit has a second one, at twice the length or more, to which a voltage that jumps does not lead."""
MOST_HALVINGS, ENERGY_ROUNDING = 60, 1e-14
"""Halvings of a step along which the energy does not fall, and the share of the energy that counts as rounding."""
UNREACHED = 1e6
"""The V of a film that does not pull in; the largest at which the end of a film is searched."""
LEVELS = 32
"""Number of widths, and of lengths at a time, between which the end of a film is bracketed."""
LEVEL, MOST_LEVELS = 1.02, 480
"""Ratio of neighbouring lengths, from 1 on, and their largest number."""


class Tension(NamedTuple):
    """Stresses at lengths m and n: ``along`` = K s1 and ``across`` = K s2 with the ``compliance`` K of the law; the
    ``strain`` I1 - 3, ``meridian`` = A m, ``hoop`` = B n, r = G/(m n), and ``field`` = K V m n."""

    along: Any
    across: Any
    compliance: Any
    strain: Any
    meridian: Any
    hoop: Any
    r: Any
    field: Any


class Creeping:
    """The formulas of a wrinkling ``film`` whose branches have states; ``localises``: localisation ends it, too."""

    def __init__(self, film: TautCone, localises: bool) -> None:
        self.film, self.localises = film, localises

    # --- stresses ----------------------------------------------------------------------------------------------------

    def tension(self, m: Any, squared: Any, width: Any, y: list[Any], n: Numbers, xp: Any = np) -> Tension:
        """The stresses at the lengths m and n = ``width``."""
        area = m * width
        meridian, hoop, r = n["A"] * m, n["B"] * width, n["G"] / area
        strain = (meridian + hoop) + (r - 3.0)
        compliance = self.film.law.compliance(strain, n, xp)
        t1, t2 = self.film.viscous.stresses(m, width, y, n)
        field = compliance * (squared * area)
        along, across = meridian - r + compliance * t1, hoop - r + compliance * t2
        return Tension(along - field, across - field, compliance, strain, meridian, hoop, r, field)

    def slopes(self, at: Tension, m: Any, width: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any, Any]:
        """K h11, K h12 and K h22."""
        bend = self.film.law.stiffening(at.strain, n, xp) / at.compliance
        a, b, k = at.meridian - at.r, at.hoop - at.r, at.compliance
        v11, v12, v22 = self.film.viscous.slopes(m, width, y, n)
        return (
            at.meridian + at.r + bend * (a * a) - at.field + k * v11,
            at.r + bend * (a * b) - at.field + k * v12,
            at.hoop + at.r + bend * (b * b) - at.field + k * v22,
        )

    # --- lengths -----------------------------------------------------------------------------------------------------

    def lengths(self, q: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> tuple[Any, Any, Any, Any]:
        """m and n, and 1 where the meridian and where the width are held, else 0."""
        if not traced(xp):
            m, width = self.solved(q, squared, y, n)
            return m, width, np.where(m > q, 0.0, 1.0), np.where(width > 1.0, 0.0, 1.0)
        held, narrow = 0.5 + 0.5 * n["meridian_held"], 0.5 + 0.5 * n["width_held"]
        film = getattr(n["crumpled"], "value", "")
        name = f"{film}, {xp.node(squared).index}, {known(held)}, {known(narrow)}"

        def width_at(m: Any, squared: Any, y: Sequence[Any]) -> Any:
            if known(narrow) == 1.0:
                return 1.0

            def residual(width: Any, m: Any, squared: Any, *others: Any) -> Any:
                *y, xp = others
                slack = self.tension(m, squared, width, y, n, xp).across
                return slack if known(narrow) == 0.0 else narrow * (width - 1.0) + (1.0 - narrow) * slack

            return root(xp, f"crept width, {name}", residual, (m, squared, *y), lambda *at: 1.0, LONGEST_STEP)

        def residual(m: Any, q: Any, squared: Any, *others: Any) -> Any:
            *y, xp = others
            slack = self.tension(m, squared, width_at(m, squared, y), y, n, xp).along
            return slack if known(held) == 0.0 else held * (m - q) + (1.0 - held) * slack

        m = q
        if known(held) != 1.0:
            m = root(xp, f"crept length, {name}", residual, (q, squared, *y), lambda q, *at: q, LONGEST_STEP)
        return m, width_at(m, squared, y), held, narrow

    def solved(self, q: Any, squared: Any, y: list[Any], n: Numbers) -> tuple[Array, Array]:
        """Compute m and n of the energy minimum that continues the held film, of arrays; NaN where it has ended.

        Newton's method approaches the minimum from below, since the residuals of the law are concave in the form used
        here. Those of a branch near its limit are convex: where a step passes the limit, or the Hessian is not
        positive, although the minimum exists, descent of the energy finds it.
        """
        q, squared, *y = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (q, squared, *y)))
        m, width, moving = q.copy(), np.ones(q.shape), np.ones(q.shape, dtype=bool)
        with np.errstate(all="ignore"):
            for _ in range(MOST_STEPS):
                at = self.tension(m, squared, width, y, n)
                h11, h12, h22 = self.slopes(at, m, width, y, n)
                stiff = self.film.law.stiffening(at.strain, n) / at.compliance
                a, b, s1, s2 = stiff * (at.meridian - at.r), stiff * (at.hoop - at.r), at.along, at.across
                free1, free2 = (m > q) | (s1 < 0.0), (width > 1.0) | (s2 < 0.0)
                j11, j12 = h11 - s1 - a * s1, h12 - b * s1
                j21, j22 = h12 - s2 - a * s2, h22 - s2 - b * s2
                det = j11 * j22 - j12 * j21
                both1, both2 = (j12 * s2 - j22 * s1) / det, (j21 * s1 - j11 * s2) / det
                step1 = np.where(free1, np.where(free2, both1, -s1 / j11), 0.0)
                step2 = np.where(free2, np.where(free1, both2, -s2 / j22), 0.0)
                lost = (free1 & free2 & ~((det > 0.0) & (j11 > 0.0))) | (free1 & ~free2 & ~(j11 > 0.0))
                step1, step2 = np.where(lost, np.nan, step1), np.where(lost, np.nan, step2)
                step1, step2 = (np.where(moving, np.clip(s, -LONGEST_STEP, LONGEST_STEP), 0.0) for s in (step1, step2))
                before = m, width
                m, width = np.maximum(m + m * step1, q), np.maximum(width + width * step2, 1.0)
                change = np.fmax(np.abs(m - before[0]) / m, np.abs(width - before[1]) / width)
                moving = moving & (change > ENOUGH)
                if not moving.any():
                    break
            whole = self._whole(self.tension(m, squared, width, y, n), m, width, y, n)
            missed = np.asarray(~np.broadcast_to(whole, m.shape) | moving)
            m, width = np.where(missed, np.nan, m), np.where(missed, np.nan, width)
            missed &= np.isfinite(sum((q, squared, *y)))
            if missed.any():
                arguments = _chosen(missed, q, squared, y, n)
                highest = Creeping(self.film, localises=False).highest_squared(
                    np.sqrt(arguments[0] - 1.0), *arguments[2:]
                )
                missed[missed] = (arguments[1] < highest) | (highest >= UNREACHED)
                m[missed], width[missed] = self._descended(*_chosen(missed, q, squared, y, n))
        return m, width

    def _whole(self, own: Tension, m: Any, width: Any, y: list[Any], n: Numbers) -> Any:
        """Whether neither the law nor a branch is at a stretch limit."""
        return (self.film.viscous.limit_share(m, width, y, n) < 1.0) & (own.compliance > 0.0)

    def _descended(self, q: Array, squared: Array, y: list[Any], n: Numbers) -> tuple[Array, Array]:
        """Find the minimum of films that have one, by Newton's method with a line search on the energy."""

        def energy(m: Any, width: Any) -> Any:
            tension = self.tension(m, squared, width, y, n)
            stored = self.film.law.energy(tension.strain, n) + self.film.viscous.energy(m, width, y, n)
            return np.where(self._whole(tension, m, width, y, n), stored - 0.5 * squared * m * width, np.inf)

        m, width, least = q.copy(), np.ones(q.shape), NEARLY * (1.0 + self.film.viscous.modulus(n))
        for _ in range(MOST_STEPS):
            at = self.tension(m, squared, width, y, n)
            h11, h12, h22 = (h / at.compliance for h in self.slopes(at, m, width, y, n))
            s1, s2 = at.along / at.compliance, at.across / at.compliance
            free1, free2 = (m > q) | (s1 < 0.0), (width > 1.0) | (s2 < 0.0)
            h12 = np.where(free1 & free2, h12, 0.0)
            lift = np.maximum(least - 0.5 * (h11 + h22) + np.hypot(0.5 * (h11 - h22), h12), 0.0)
            h11, h22 = h11 + lift, h22 + lift
            det = h11 * h22 - h12 * h12
            step1 = np.where(free1, (h12 * s2 - h22 * s1) / det, 0.0)
            step2 = np.where(free2, (h12 * s1 - h11 * s2) / det, 0.0)
            before = energy(m, width)
            share = LONGEST_STEP / np.maximum(np.fmax(np.abs(step1), np.abs(step2)), LONGEST_STEP)
            for _ in range(MOST_HALVINGS):
                long, wide = np.maximum(m * np.exp(share * step1), q), np.maximum(width * np.exp(share * step2), 1.0)
                falls = energy(long, wide) <= before + ENERGY_ROUNDING * (1.0 + np.abs(before))
                if falls.all():
                    break
                share = np.where(falls, share, 0.5 * share)
            change = np.maximum(np.abs(long - m) / m, np.abs(wide - width) / width)
            m, width = long, wide
            if not (change > ENOUGH).any():
                break
        return m, width

    # --- what a film gives -------------------------------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> tuple[Any, Any]:
        """x s1/q where the meridian is held, else 0, and its slope by x; in a program the second is s1/q, since
        programs differentiate the first."""
        q = 1.0 + x * x
        _, width, held, narrow = self.lengths(q, squared, y, n, xp)
        if known(held) == 0.0:
            return 0.0 * x, 0.0 * x
        tension = self.tension(q, squared, width, y, n, xp)
        pull = held * (tension.along / (tension.compliance * q))
        if traced(xp):
            return x * pull, pull
        h11, h12, h22 = self.slopes(tension, q, width, y, n)
        stiff = (h11 - (1.0 - narrow) * (h12 * h12 / h22) - tension.along) / (tension.compliance * q)
        return x * pull, pull + held * (2.0 * x * x / q) * stiff

    # --- held at its states ------------------------------------------------------------------------------------------

    def _slack(self, q: Any, width: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """V and s1 of a hoop-slack film of the length q at a ``width``; V is infinite beyond a stretch limit."""
        tension = self.tension(q, 0.0, width, y, n)
        whole = self._whole(tension, q, width, y, n)
        squared, along = (
            tension.across / (tension.compliance * q * width),
            (tension.along - tension.across) / tension.compliance,
        )
        return np.where(whole, squared, np.inf), along

    def _margin(self, q: Any, squared: Any, width: Any, y: list[Any], n: Numbers) -> Any:
        """The margin of a hoop-slack film before localisation, K (2 (h11 - h12^2/h22) - s1)."""
        at = self.tension(q, squared, width, y, n)
        h11, h12, h22 = self.slopes(at, q, width, y, n)
        return 2.0 * (h11 - h12 * h12 / h22) - at.along

    def _widest(self, q: Any, y: list[Any], n: Numbers) -> Any:
        """A width at which neither the law nor a branch is stretched more along than across."""
        size = len(y) // self.film.branches
        ratios = [n["A"] * q / n["B"], *(y[k * size] * q / y[k * size + 1] for k in range(self.film.branches))]
        return np.maximum.reduce(np.broadcast_arrays(1.0, *ratios))

    def balancing(self, x: Any, pull: Any, y: list[Any], n: Numbers) -> Any:
        """The V at which s1/q equals ``pull`` >= 0, also where the film would have localised."""
        q, pull = np.broadcast_arrays(1.0 + np.square(np.asarray(x, dtype=float)), np.asarray(pull, dtype=float))

        def weakness(width: Any) -> Any:
            squared, along = self._slack(q, width, y, n)
            return np.where(np.isinf(squared), -1.0, pull * q - along)

        with np.errstate(all="ignore"):
            tension = self.tension(q, 0.0, 1.0, y, n)
            taut = tension.along / (tension.compliance * q) - pull
            slack = self._slack(q, rise(weakness, np.ones_like(q), self._widest(q, y, n)), y, n)[0]
            return np.where(tension.across >= taut * tension.compliance * q, taut, slack)[()]

    def highest_squared(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """The V at which a film held at x localises or its minimum ends, whichever comes first; `UNREACHED` if neither
        happens."""
        q = 1.0 + np.square(np.asarray(x, dtype=float))

        def weakness(width: Any) -> Any:
            squared, along = self._slack(q, width, y, n)
            return np.where(np.isinf(squared), -1.0, -along)

        def localisation(width: Any) -> Any:
            squared = self._slack(q, width, y, n)[0]
            return np.where(np.isinf(squared), np.inf, -self._margin(q, squared, width, y, n))

        with np.errstate(all="ignore"):
            widest = rise(weakness, np.ones_like(q), self._widest(q, y, n))
            step = (widest - 1.0) / LEVELS
            levels = np.reshape(np.arange(1.0, LEVELS + 1.0), (-1,) + (1,) * q.ndim)
            beyond = localisation(1.0 + levels * step) > 0.0
            first = 1.0 + np.argmax(beyond, axis=0) * step
            ends = (widest > 1.0) & beyond.any(axis=0) & self.localises
            end_width = np.where(ends, rise(localisation, first, first + np.where(ends, step, 0.0)), 1.0)
            lost = self._slack(q, widest, y, n)[0]
            at = self.tension(q, lost, widest, y, n)
            h11, h12, h22 = self.slopes(at, q, widest, y, n)
            firm = np.where(widest > 1.0, h11 * h22 > h12 * h12, h11 > 0.0)
            squared, longest = self._free_end(y, n)
            slack = np.where(firm, np.where(q < longest, squared, UNREACHED), np.minimum(lost, UNREACHED))
            return np.where(ends, np.minimum(self._slack(q, end_width, y, n)[0], UNREACHED), slack)[()]

    def free_width(self, m: Any, y: list[Any], n: Numbers) -> Any:
        """The width of a free film of the length m, at the V at which it has that length."""

        def slender(width: Any) -> Any:
            tension = self.tension(m, 0.0, width, y, n)
            whole = self._whole(tension, m, width, y, n)
            surplus = tension.across - tension.along
            return np.where(whole & np.isfinite(surplus), surplus, np.inf)  # at the limit itself both may be infinite

        return rise(slender, np.ones_like(m), self._widest(m, y, n))

    def softness(self, m: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """Minus the Hessian of a free film of the length m, positive where its minimum has ended; and a mask of films
        below all stretch limits."""
        width = self.free_width(m, y, n)
        tension = self.tension(m, 0.0, width, y, n)
        whole = self._whole(tension, m, width, y, n)
        at = self.tension(m, tension.along / (tension.compliance * m * width), width, y, n)
        h11, h12, h22 = self.slopes(at, m, width, y, n)
        return -np.where(width > 1.0, h11 * h22 - h12 * h12, h11), np.broadcast_to(whole, np.shape(width))

    def _free_end(self, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """The V at which the minimum of a free film ends, and its m there; infinite if it does not end."""
        names = tuple(name for name in n if not name.startswith("held_"))
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (*y, *(n[name] for name in names))))
        rows = np.stack([array.ravel() for array in arrays])
        ends = _free_end_of(self.film, names, rows.tobytes(), rows.shape[1])
        return ends[0].reshape(arrays[0].shape), ends[1].reshape(arrays[0].shape)

    # --- borders -----------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:
        """``meridian_held`` and ``width_held`` distinguish the states; the others end the film."""
        ends = [Border(self._localisation_border, seldom=True)] if self.localises else []
        return (
            Border(self._width_border, "width_held", divides=True),
            Border(self._meridian_border, "meridian_held", divides=True),
            *ends,
            Border(self._minimum_border, seldom=True, folds=True),
        )

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of the borders, -1 or 1, at a state; NaN where the film has no length."""
        q = 1.0 + np.square(x)
        m, width = self.solved(q, squared, y, n)
        tight, narrow = np.where(m <= q, 1.0, -1.0), np.where(width <= 1.0, 1.0, -1.0)
        gone = np.isnan(m) | np.isnan(width)
        return {"meridian_held": np.where(gone, np.nan, tight), "width_held": np.where(gone, np.nan, narrow)}

    def combinations(self, negative: Mapping[str, Any]) -> list[Any]:
        """Masks over the combinations of switches, one for each state of the film; ``negative`` is True where a switch
        is -1."""
        tight, narrow = ~negative["meridian_held"], ~negative["width_held"]
        return [tight & narrow, tight & ~narrow, ~tight & narrow, ~tight & ~narrow]

    def _width_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        m, width, _, narrow = self.lengths(1.0 + x * x, squared, y, n, xp)
        side = n["width_held"]
        if known(narrow) == 0.0:
            return -side * (width - 1.0)
        tight = side * narrow * self.tension(m, squared, 1.0, y, n, xp).across
        return tight - side * (1.0 - narrow) * (width - 1.0)

    def _meridian_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        q = 1.0 + x * x
        m, width, held, _ = self.lengths(q, squared, y, n, xp)
        side = n["meridian_held"]
        if known(held) == 0.0:
            return -side * (m - q)
        tight = side * held * self.tension(q, squared, width, y, n, xp).along
        return tight - side * (1.0 - held) * (m - q)

    def _localisation_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        q = 1.0 + x * x
        _, width, held, narrow = self.lengths(q, squared, y, n, xp)
        if known(held) == 0.0 or known(narrow) == 1.0:
            return 1.0 + 0.0 * x
        at = self.tension(q, squared, width, y, n, xp)
        h11, h12, h22 = self.slopes(at, q, width, y, n, xp)
        localising = 2.0 * (h11 * h22 - h12 * h12) - at.along * h22
        free = held * (1.0 - narrow)
        return (1.0 - free) + free * localising

    def _minimum_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        m, width, held, narrow = self.lengths(1.0 + x * x, squared, y, n, xp)
        if known(held) == 1.0:
            return 1.0 + 0.0 * x
        at = self.tension(m, squared, width, y, n, xp)
        h11, h12, h22 = self.slopes(at, m, width, y, n, xp)
        stiff = 1.0 + self.film.viscous.modulus(n)
        slack = narrow * (h11 - NEARLY * stiff) + (1.0 - narrow) * (h11 * h22 - h12 * h12 - NEARLY * stiff * stiff)
        return held + (1.0 - held) * slack


def _chosen(which: Any, q: Any, squared: Any, y: list[Any], n: Numbers) -> tuple[Any, Any, list[Any], dict[str, Any]]:
    """The arguments of the formulas, reduced to the elements in the mask ``which``."""
    numbers = {name: taken(value, which) for name, value in n.items()}
    q, squared, *y = (np.broadcast_to(value, which.shape)[which] for value in (q, squared, *y))
    return q, squared, y, numbers


@lru_cache(maxsize=256)
def _free_end_of(film: TautCone, names: tuple[str, ...], rows: bytes, count: int) -> tuple[Array, Array]:
    """`Creeping._free_end`, (count,), for the states and numbers in ``rows``; cached.

    The V of a free film rises with its length m, level by level, until its minimum ends.
    """
    values = np.frombuffer(rows).reshape(-1, count)
    y, n = list(values[: len(film.states)]), dict(zip(names, values[len(film.states) :], strict=True))
    creeping, first = Creeping(film, localises=False), np.full(count, np.nan)
    with np.errstate(all="ignore"):
        open_, number = np.ones(count, dtype=bool), 0
        while open_.any() and number < MOST_LEVELS:
            levels = LEVEL ** (number + 1.0 + np.arange(LEVELS))[:, None] + np.zeros(count)
            softness, whole = creeping.softness(levels, y, n)
            ended = (softness > 0.0) | ~whole
            at = np.argmax(ended, axis=0)
            met = open_ & ended.any(axis=0)
            inside = whole[at, np.arange(count)]
            first = np.where(met & inside, levels[at, np.arange(count)], first)
            open_, number = open_ & ~met, number + LEVELS
        ends = ~np.isnan(first)
        high = np.where(ends, first, LEVEL)
        longest = rise(lambda m: creeping.softness(m, y, n)[0], high / LEVEL, high)
        width = creeping.free_width(longest, y, n)
        tension = creeping.tension(longest, 0.0, width, y, n)
        squared = tension.along / (tension.compliance * longest * width)
    ends &= squared < UNREACHED  # else it is next to its stretch limit
    return np.where(ends, squared, np.inf), np.where(ends, longest, np.inf)
