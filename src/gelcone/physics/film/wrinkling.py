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

In a program the natural width n - 1 is the root of s2 = 0, solved inside of each step, and switches distinguish the
states. Force and stiffness come from one energy, so that the force is continuous across the borders, and tangent maps
have no jump there (no saltation matrix): the difference of the rates on both sides of a border, which would be in it,
is zero. These formulas are in `gelcone.physics.film.elastic`, those of a film with branches in
`gelcone.physics.film.creeping`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from gelcone.codes import FilmPullIn
from gelcone.errors import InputError, check_name
from gelcone.membrane.crumpling import SAME_STRETCH, crumpling, turnings
from gelcone.membrane.force import NEVER
from gelcone.physics.component import Numbers
from gelcone.physics.film.creeping import Creeping
from gelcone.physics.film.elastic import Elastic
from gelcone.physics.film.film import Border, Film, FilmState, TracedState
from gelcone.physics.film.taut import TautCone
from gelcone.physics.implicit import traced
from gelcone.quantity import Array

STATES = ("taut", "hoop_slack", "meridional_slack", "crumpled")
"""The states of the film, in the order in which results list their shares of time."""
SWITCHES = ("width_held", "pulls", "crumpled", "long", "below_hump")
PULL_IN = ("first", "minimum", "memoryless", "snap")
FAILED = "pulled_in"
"""The state of a film whose run continues after it has pulled in."""

_STUDIES = {
    "first": "",
    "minimum": "; its localisation is left out (study)",
    "memoryless": "; after pull-in it has failed; the run continues without its force until there is a minimum (study)",
    "snap": "; after pull-in it has failed; the run continues without its force until it snaps back (study)",
}


@dataclass(frozen=True)
class WrinklingCone(TautCone):
    """The cone that wrinkles.

    Parameters
    ----------
    law, prestretch_mode : as for the taut cone.
    pull_in : what happens where the film pulls in. ``"first"`` (default): the run ends, by localisation or by the end
        of the energy's minimum, whichever comes first. The others are for study. ``"minimum"``: the run ends by the end
        of the minimum alone. After that end the film has failed, but the run continues without its force:
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
        """False where a run continues after pull-in: the charge of a film that has failed is unknown."""
        return not self.elastic.continues

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name("pull_in", self.pull_in, PULL_IN)
        if self.branches and self.elastic.continues:
            raise InputError(f"pull_in = {self.pull_in}: a film with branches ends there; take first or minimum")

    def resting_lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        return self.lengths(x, squared, n)

    def shortest_lengths(self, x: Any, n: Numbers) -> tuple[Any, Any]:
        """The squared lengths of the taut film."""
        return super().resting_lengths(x, 0.0, n)

    @cached_property
    def creeping(self) -> Creeping:
        """The formulas of a film whose branches have states."""
        return Creeping(self, localises=self.pull_in != "minimum")

    @cached_property
    def elastic(self) -> Elastic:
        """The formulas of a film without branches, and of statics."""
        return Elastic(self, self.pull_in)

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """The numbers of the taut cone, and ``hump``, the t of the first maximum of Vb; ``valley``, that of the minimum
        behind it; ``limit_squared``, the V at which a film without tension pulls in; ``crumpling_squared``, the V above
        which it is slack in both directions; ``end_of_slack``, the A q above which no film loses its tension without
        pulling in; ``edge``, the A x^2 at which A q = B, negative if there is none; ``shortest``, the x^2 below which a
        film is so short that evenly compressed it would be beyond its stretch limit, negative if there is none; and the
        switches."""
        numbers = super().numbers(parameters)
        A, B, G = np.broadcast_arrays(numbers["A"], numbers["B"], numbers["G"])
        law = {name: numbers[name] for name in numbers.keys() - {"A", "B", "G"}}
        hump, valley = turnings(self.law, law)
        with np.errstate(all="ignore"):
            turning = np.maximum(hump, B)
            limit = np.where(np.isinf(hump) | (valley <= B), NEVER, crumpling(self.law, turning, law) / G)
            crumpled = crumpling(self.law, B, law) / G
        ones = np.ones(np.broadcast_shapes(A.shape, hump.shape))
        numbers |= {
            "limit_squared": limit,
            "crumpling_squared": np.where(B > 1.0, crumpled, -1.0) * ones,
            "end_of_slack": np.minimum(turning, NEVER),
            "hump": np.minimum(hump, NEVER) * ones,
            "valley": np.minimum(valley, NEVER) * ones,
            "edge": np.where(B > A, B - A, -1.0),
            "shortest": self._shortest(A, B, G, law) * ones,
        }
        switches = (*SWITCHES, *(("meridian_held",) if self.branches else ()))
        after = self._numbers_after(G, valley, law, ones) if self.elastic.continues else {}
        return numbers | dict.fromkeys(switches, ones) | after

    def _numbers_after(self, G: Any, valley: Any, law: Numbers, one: Any) -> dict[str, Any]:
        """``valley_squared``, the V at the valley, and a switch."""
        with np.errstate(all="ignore"):
            squared = np.where(np.isinf(valley), 0.0, crumpling(self.law, valley, law) / G)
        return {"valley_squared": squared * one, "whole": one}

    def _shortest(self, A: Any, B: Any, G: Any, law: Numbers) -> Any:
        """The x^2 at which the film is as long as its gel, at m = q and A n = B or, if that is shorter, n = 1."""
        hoop = np.maximum(A, B)
        strain = A + hoop + 1.0 / (A * hoop) - 3.0
        short = 1.0 / (A * np.sqrt(np.maximum(B, 1.0))) - 1.0
        return np.where((short > 0.0) & (strain >= self.law.strain_limit(law)), short, -1.0)

    @property
    def kinds(self) -> tuple[str, ...]:  # type: ignore[override]
        """The states whose shares of time results report."""
        return (*STATES, FAILED) if self.elastic.continues else STATES

    # --- force ---------------------------------------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x s1/q and its slope by x; NaN where the energy no longer has a minimum."""
        if self.branches and y:
            return self.creeping.force(x, squared, y, n, xp)
        return self.elastic.force(x, squared, n, xp)

    # --- borders -------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """The borders of the film with branches, or without."""
        return self.creeping.borders if self.branches else self.elastic.borders

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        if self.branches and y:
            return self.creeping.switches(x, squared, y, n)
        return self.elastic.switches(x, squared, n)

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        index = np.arange(dwell.shape[1])
        negative = {name: (index >> k) & 1 == 1 for k, name in enumerate(switches)}
        combinations = self.creeping.combinations(negative) if self.branches else self.elastic.combinations(negative)
        return np.stack([dwell[:, which].sum(axis=1) for which in combinations], axis=1)

    def pull_in_kind(self, switches: Numbers) -> Any:
        pulls = switches["meridian_held" if self.branches else "pulls"] > 0.0
        return np.where(pulls, FilmPullIn.LOCALISATION, FilmPullIn.MINIMUM)

    # --- its own lengths -------------------------------------------------------------------------------------------

    def lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Squared true meridional and hoop length of the elastic film over the mounted ones, m and n; NaN once it has
        pulled in, and where x is NaN."""
        return self.elastic.lengths(x, squared, n)

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
        return self.elastic.capacitance(x * x, squared, n, xp)

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """W - V (m n - 1)/2, plus the energy of the branches."""
        m, width = self._lengths_at(x, squared, y, n)
        strain = n["A"] * m + n["B"] * width + n["G"] / (m * width) - 3.0
        energy = self.law.energy(strain, n) - 0.5 * squared * (m * width - 1.0)
        return energy + self.viscous.energy(m, width, y, n) if self.branches and y else energy

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
        share = self.state_of_lengths(m, width, voltage, n).limit_share
        return np.fmax(share, self.viscous.limit_share(m, width, y, n))

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return Film.voltage_force(self, x, squared, y, n, xp)

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        return self.elastic.voltage_gain(x, squared, n)

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """Stretches, stresses and field at the film's lengths, without negative stresses; NaN once it has pulled
        in."""
        m, width = self._lengths_at(x, np.square(voltage), y, n)
        kind = np.where(np.isnan(m), len(STATES) if self.elastic.continues else -1, _place(x, m, width))
        branch_stress = (0.0, 0.0) if not (self.branches and y) else self.viscous.stresses(m, width, y, n)
        return self.state_of_lengths(m, width, voltage, n, branch_stress)._replace(kind=kind)

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        """The stresses are those at the film's lengths; its share of the limit is that without voltage."""
        if self.elastic.continues:
            return None
        xx = x * x
        creeps = self.branches and y
        if creeps:
            m, width = self.branch_lengths(x, squared, y, n, xp)
        else:
            m, width = self.elastic.traced_lengths(xx, squared, n, xp)
        branch_stress = self.viscous.stresses(m, width, y, n) if creeps else (0.0, 0.0)
        ring = without_push(self.traced_ring(m, width, squared, n, xp, branch_stress), xp)
        if creeps:
            share = xp.maximum(ring.limit_share, self.viscous.limit_share(m, width, y, n, xp))
        else:
            long = xp.maximum(1.0 + xx, 1.0 / (n["A"] * xp.sqrt(xp.maximum(n["B"], 1.0))))
            wide = xp.maximum(xp.sqrt(n["G"] / (n["B"] * long)), 1.0)
            share = self.traced_ring(long, wide, 0.0, n, xp).limit_share
        return ring._replace(limit_share=share)

    def state_of_lengths(
        self, m: Any, width: Any, voltage: Any, n: Numbers, more: tuple[Any, Any] = (0.0, 0.0)
    ) -> FilmState:
        """The state of a ring of the squared lengths m and ``width`` over the mounted ones, without negative stresses;
        ``more`` holds stresses that are added to the law's."""
        return without_push(self.ring_state(m, width, voltage, n, more))

    def describe(self) -> str:
        ends = _STUDIES[self.pull_in] + self.viscous.words
        return (
            "wrinkling film: a homogeneous cone without compression, which pulls in at a higher voltage than the "
            f"membrane that it stands for{ends}"
        )

    # --- statics -----------------------------------------------------------------------------------------------------

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        return Film.turning(self, x, squared, n)

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        return self.elastic.balancing(x, pull, n)

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        return self.elastic.highest_squared(x, n)

    def highest_squared_held(self, x: Any, y: list[Any], n: Numbers) -> Any:
        return self.creeping.highest_squared(x, y, n) if self.branches and y else self.highest_squared(x, n)

    # --- where it has a state --------------------------------------------------------------------------------------

    def strain(self, x: Any, n: Numbers) -> Any:
        """I1 - 3 at the lengths of the film without voltage; a film that is too short for its gap wrinkles, and is not
        compressed to its stretch limit."""
        A, B, G = (n[name] for name in "ABG")
        q = 1.0 + np.square(x)
        with np.errstate(all="ignore"):
            m = np.maximum(q, np.sqrt(G / A))
            wide = A * q + 2.0 * np.sqrt(G * B / q) - 3.0
            wrinkled = np.where(A * q >= np.sqrt(G * B / q), wide, 0.0)
            return np.where(B * m >= G, A * m + B + G / m - 3.0, wrinkled)[()]


S = TypeVar("S", FilmState, TracedState)


def without_push(state: S, xp: Any = np) -> S:
    """The state of a ring, of arrays or in a program, without negative stresses."""
    along, across = xp.maximum(state.meridional_stress, 0.0), xp.maximum(state.hoop_stress, 0.0)
    return state._replace(meridional_stress=along, hoop_stress=across)


def _place(x: Any, m: Any, width: Any) -> Any:
    """The index in `STATES` of a film of these lengths; -1 where it has pulled in."""
    with np.errstate(invalid="ignore"):
        longer = m > (1.0 + np.square(x)) * (1.0 + SAME_STRETCH)
        place = 2 * longer + (width > 1.0 + SAME_STRETCH)
    return np.where(np.isnan(m), -1, place)
