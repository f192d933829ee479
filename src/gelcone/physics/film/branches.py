"""Maxwell branches of a film: springs that relax, each parallel to the equilibrium law.

A branch k has the modulus g over the long-term shear modulus, the relaxation time tau and, with the logarithmic flow
rule, a Gent limit J. With m and n the squared true lengths of the film over the mounted ones (m = q and n = 1 where it
is taut) its true stresses over mu are t1 and t2, and it dissipates D.

Logarithmic flow (Reese and Govindjee, Int. J. Solids Struct. 35 (1998) 3455; Foo et al., J. Appl. Phys. 111 (2012)
034102): the states p1 and p2 are the squared mounted lengths over those at which the branch is free, 1 where it has
rested on the mounted film, and with E1 = p1 m, E2 = p2 n, E3 = 1/(E1 E2), R = 1/(1 - (E1 + E2 + E3 - 3)/J)

    t1 = g R (E1 - E3),  t2 = g R (E2 - E3),  D = (t1^2 - t1 t2 + t2^2)/(3 g tau),
    p1' = -2 p1 (t1 - t2/2)/(3 g tau),  p2' = -2 p2 (t2 - t1/2)/(3 g tau).

With a flow exponent c (Bergstrom and Boyce, J. Mech. Phys. Solids 46 (1998) 931) both rates and D take the factor
((t1^2 - t1 t2 + t2^2)/s^2)^((c - 1)/2) with the flow stress s.

Linear flow (Linder, Tkachuk and Miehe, J. Mech. Phys. Solids 59 (2011) 2134): three states a, and with
c = (m, n, 1/(m n)) and E = a c

    a' = (1/c - a)/tau,  t1 = g (E1 - E3),  t2 = g (E2 - E3),  D = g/(2 tau) sum (E - 1)^2/E;

where n = 1 the second stays 1 and is left out. Parameters of one rule are not those of the other.

A branch that relaxes fast is stiff. To second order in its time either rule without an exponent is a damper (Kelvin and
Voigt): the taut film pulls the disc with 4 g tau x^2 x'/q^2 more, and no state is left of the branch (``reduced``).
The order is that of the motion: force and dissipation contain the damper, while the film's stresses leave out those of
the branch, which are of first order.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gelcone.errors import InputError, check_name
from gelcone.physics.component import Numbers, State
from gelcone.physics.laws import LAWS
from gelcone.quantity import Quantity

MOST_BRANCHES = 3
REDUCED_TIME = 0.02
"""Relaxation times below which a branch may do without states; the error, of second order, is 1e-3 there."""
FLOWS = ("log", "linear")
"""Flow rules: logarithmic and linear."""
RESTED = ("flat", "raised")
"""Where branches have rested before a run: on the mounted, flat film, or where the run starts, without voltage."""
FLOW_STRESS = Quantity(
    "s0", "stress at which the branches flow as fast as with the exponent 1, over mu", 1.0, positive=True
)


_NAME = re.compile(r"(?:viscous_modulus|relaxation_time|viscous_limit)_([1-9])")


def branches_of(names: Iterable[str]) -> int:
    """The number of branches that have a parameter among ``names``."""
    return max((int(match[1]) for name in names if (match := _NAME.fullmatch(name))), default=0)


class Strained(NamedTuple):
    """The state of a branch: its true stresses over g, ``along`` = R (E1 - E3) and ``across`` = R (E2 - E3), ``thin`` =
    R E3, and its stretches ``first`` = E1 and ``second`` = E2."""

    along: Any
    across: Any
    thin: Any
    first: Any
    second: Any


@dataclass(frozen=True)
class Branches:
    """The ``count`` branches of a film with their ``flow`` rule and its ``exponent``. ``taut``: n is always 1.
    ``reduced``: numbers, from 1, of the branches without states."""

    count: int
    flow: str
    exponent: int
    taut: bool
    reduced: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_name("flow", self.flow, FLOWS)
        if not (isinstance(self.count, int) and 0 <= self.count <= MOST_BRANCHES):
            raise InputError(f"branches = {self.count}: must be a whole number from 0 to {MOST_BRANCHES}")
        if not (isinstance(self.exponent, int) and self.exponent >= 1 and self.exponent % 2):
            raise InputError(
                f"flow_exponent = {self.exponent}: must be an odd whole number, or the flow is not smooth where the "
                "film rests; take 1, 3 or 5"
            )
        if self.exponent > 1 and self.flow != "log":
            raise InputError(f"flow_exponent = {self.exponent}: only the logarithmic flow takes one; take flow = 'log'")
        for k in self.reduced:
            if not 1 <= k <= self.count:
                raise InputError(f"reduced: there is no relaxation_time_{k}; give one, or leave it out of reduced")
        if self.reduced and (not self.taut or self.exponent > 1):
            raise InputError(
                f"reduced: relaxation_time_{self.reduced[0]} takes its states in a film that wrinkles or flows with an "
                "exponent; take the taut film with flow_exponent 1, or leave it out of reduced"
            )

    @cached_property
    def with_states(self) -> tuple[int, ...]:
        """The branches that have states, by their numbers from 1."""
        return tuple(k for k in range(1, self.count + 1) if k not in self.reduced)

    def check(self, values: Mapping[str, Any]) -> None:
        """`InputError` for a reduced branch that relaxes too slowly."""
        for k in self.reduced:
            slowest = np.max(values[f"relaxation_time_{k}"])
            if slowest >= REDUCED_TIME:
                raise InputError(
                    f"relaxation_time_{k} = {slowest:g} (times Omega0): without states it must be below "
                    f"{REDUCED_TIME:g}; leave it out of reduced"
                )

    @cached_property
    def parameters(self) -> Mapping[str, Quantity]:
        """The parameters, by name."""
        parameters: dict[str, Quantity] = {}
        for k in range(1, self.count + 1):
            parameters |= {
                f"viscous_modulus_{k}": Quantity(
                    f"g{k}", f"modulus of Maxwell branch {k} over the long-term shear modulus", 0.5, lower=0.0
                ),
                f"relaxation_time_{k}": Quantity(
                    f"tau{k}",
                    f"relaxation time of Maxwell branch {k}",
                    0.5 * REDUCED_TIME if k in self.reduced else 10.0,
                    positive=True,
                    scale="time",
                ),
            }
            if self.flow == "log":
                parameters[f"viscous_limit_{k}"] = Quantity(
                    f"Jv{k}", f"stretch limit of Maxwell branch {k}", np.inf, positive=True, infinite=True
                )
        return parameters | ({"flow_stress": FLOW_STRESS} if self.exponent > 1 and self.count else {})

    @cached_property
    def states(self) -> tuple[State, ...]:
        """The states: of each branch along the meridian, across it, and with the linear rule through the thickness."""
        along = ("meridional", "hoop") if self.flow == "log" else ("meridional", "hoop", "thickness")
        of = "squared mounted length over that at which the branch is free"
        return tuple(
            State(f"viscous_{name}_{k}", f"Maxwell branch {k}, {name}: {of}", "share", 1.0)
            for k in self.with_states
            for name in along
            if not (self.flow == "linear" and self.taut and name == "hoop")
        )

    @property
    def words(self) -> str:
        """The part of a film's description that says how it creeps; empty without branches."""
        several = f"{self.count} Maxwell branch{'es' if self.count > 1 else ''}"
        rule = "linear" if self.flow == "linear" else "logarithmic"
        dampers = f", {len(self.reduced)} of them without states as damper" if self.reduced else ""
        return f"; it creeps: {several}, {rule} flow{dampers}" if self.count else ""

    def relaxed(self, m: Any, width: Any) -> list[Any]:
        """The states at which nothing flows at the lengths m and n = ``width``."""
        states = [1.0 / m, 1.0 / width]
        if self.flow == "linear":
            states = [1.0 / m, m * width] if self.taut else [*states, m * width]
        return states * len(self.with_states)

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """The numbers that the formulas take."""
        numbers: dict[str, Any] = {}
        for k in range(1, self.count + 1):
            numbers[f"viscous_modulus_{k}"] = parameters[f"viscous_modulus_{k}"]
            numbers[f"flow_rate_{k}"] = 1.0 / np.asarray(parameters[f"relaxation_time_{k}"])
            if self.flow == "log":
                numbers[f"inverse_viscous_limit_{k}"] = 1.0 / np.asarray(parameters[f"viscous_limit_{k}"])
        if self.exponent > 1 and self.count:
            numbers["inverse_flow_stress"] = 1.0 / np.asarray(parameters["flow_stress"])
        return numbers

    def time_constant(self, n: Numbers) -> Any:
        """The slowest time constant of creep, (1 + g) tau: a branch that carries load creeps more slowly than it
        relaxes."""
        each = [(1.0 + n[f"viscous_modulus_{k}"]) / n[f"flow_rate_{k}"] for k in self.with_states]
        return np.maximum.reduce(each) if each else 0.0

    def modulus(self, n: Numbers) -> Any:
        """The sum of the moduli of branches with states."""
        return sum(n[f"viscous_modulus_{k}"] for k in self.with_states)

    def drag(self, x: Any, n: Numbers) -> Any:
        """The damping of the disc by the branches without states: 4 g tau x^2/q^2 of each."""
        viscosity = sum(n[f"viscous_modulus_{k}"] / n[f"flow_rate_{k}"] for k in self.reduced)
        share = x / (1.0 + x * x)
        return (4.0 * viscosity) * (share * share)

    def free_length(self, y: list[Any], xp: Any = np) -> Any:
        """The largest m at which a branch is free along the meridian, at n = 1."""
        longest: Any = 0.0
        for k in self.with_states:
            states = self._own(k, y)
            free = 1.0 / (states[0] * xp.sqrt(states[1])) if self.flow == "log" else xp.sqrt(states[2] / states[0])
            longest = xp.maximum(longest, free)
        return longest

    # --- one branch --------------------------------------------------------------------------------------------------

    def _own(self, k: int, y: list[Any]) -> list[Any]:
        size, place = len(self.states) // len(self.with_states), self.with_states.index(k)
        states = y[place * size : (place + 1) * size]
        return states if self.flow == "log" or not self.taut else [states[0], 1.0, states[1]]

    def _strained(self, k: int, m: Any, width: Any, y: list[Any], n: Numbers) -> Strained:
        states = self._own(k, y)
        first, second = states[0] * m, states[1] * width
        if self.flow == "linear":
            third = states[2] / (m * width)
            return Strained(first - third, second - third, third, first, second)
        # with P = E1 E2, R E3 = 1/(P (1 + 3/J - (E1 + E2)/J) - 1/J) and R = P R E3: one division
        s, product = n[f"inverse_viscous_limit_{k}"], first * second
        thin = 1.0 / (product * ((1.0 + 3.0 * s) - s * (first + second)) - s)
        response = product * thin
        return Strained(response * first - thin, response * second - thin, thin, first, second)

    def _each(self, m: Any, width: Any, y: list[Any], n: Numbers) -> list[tuple[int, Any, Strained]]:
        """Number, modulus and stretches of each branch with states."""
        return [
            (k, n[f"viscous_modulus_{k}"], self._strained(k, m, width, y, n)) for k in (self.with_states if y else ())
        ]

    # --- all of them -------------------------------------------------------------------------------------------------

    def stresses(self, m: Any, width: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """Sums of t1 and t2; 0 without states, as in statics."""
        along, across = 0.0, 0.0
        for _, g, branch in self._each(m, width, y, n):
            along, across = along + g * branch.along, across + g * branch.across
        return along, across

    def slopes(self, m: Any, width: Any, y: list[Any], n: Numbers) -> tuple[Any, Any, Any]:
        """Sums of the derivatives of t1 by ln m, of t1 by ln n (and of t2 by ln m), and of t2 by ln n."""
        h11, h12, h22 = 0.0, 0.0, 0.0
        for k, g, branch in self._each(m, width, y, n):
            s = n[f"inverse_viscous_limit_{k}"] if self.flow == "log" else 0.0
            h11 = h11 + g * (branch.along + 2.0 * branch.thin + s * (branch.along * branch.along))
            h12 = h12 + g * (branch.thin + s * (branch.along * branch.across))
            h22 = h22 + g * (branch.across + 2.0 * branch.thin + s * (branch.across * branch.across))
        return h11, h12, h22

    def pull(self, m: Any, y: list[Any], n: Numbers) -> tuple[Any, Any]:
        """t1/m of a taut film, and its derivative by m at fixed states."""
        if self.flow == "log":
            along = self.stresses(m, 1.0, y, n)[0]
            return along / m, (self.slopes(m, 1.0, y, n)[0] - along) / (m * m)
        r, value, slope = 1.0 / m, 0.0, 0.0
        for k in self.with_states if y else ():
            g, (first, _, third) = n[f"viscous_modulus_{k}"], self._own(k, y)
            value, slope = value + g * (first - third * (r * r)), slope + 2.0 * g * third * (r * r * r)
        return value, slope

    def rates(self, m: Any, width: Any, y: list[Any], n: Numbers) -> list[Any]:
        """Rates of change of the states."""
        rates: list[Any] = []
        for k, g, branch in self._each(m, width, y, n):
            rate, p = n[f"flow_rate_{k}"], self._own(k, y)
            if self.flow == "log":
                speed = (-2.0 / 3.0) * rate * self._flow_factor(g, branch, n)
                rates += [
                    speed * p[0] * (branch.along - 0.5 * branch.across),
                    speed * p[1] * (branch.across - 0.5 * branch.along),
                ]
            else:
                relaxed = [1.0 / m, 1.0 / width, m * width]
                changes = [rate * (a - b) for a, b in zip(relaxed, p, strict=True)]
                rates += [changes[0], changes[2]] if self.taut else changes
        return rates

    def _flow_factor(self, g: Any, own: Strained, n: Numbers) -> Any:
        """The factor ((t1^2 - t1 t2 + t2^2)/s^2)^((c - 1)/2) of flow rates and dissipation."""
        if self.exponent == 1:
            return 1.0
        share = g * n["inverse_flow_stress"]
        squared = share * share * _equivalent(own)
        factor = squared
        for _ in range((self.exponent - 1) // 2 - 1):
            factor = factor * squared
        return factor

    def dissipation(self, m: Any, width: Any, y: list[Any], n: Numbers) -> Any:
        """The sum of D."""
        dissipated: Any = 0.0
        for k, g, branch in self._each(m, width, y, n):
            rate = g * n[f"flow_rate_{k}"]
            if self.flow == "log":
                dissipated = dissipated + (rate * self._flow_factor(g, branch, n) / 3.0) * _equivalent(branch)
            else:
                lost: Any = 0.0
                for stretch in (branch.first, branch.second, branch.thin):
                    lost = lost + (stretch - 1.0) * (stretch - 1.0) / stretch
                dissipated = dissipated + 0.5 * rate * lost
        return dissipated

    def energy(self, m: Any, width: Any, y: list[Any], n: Numbers) -> Any:
        """The energy stored in the branches, of arrays."""
        energy: Any = 0.0
        for k, g, branch in self._each(m, width, y, n):
            first, second = branch.first, branch.second
            if self.flow == "log":
                limit = {"inverse_stretch_limit": n[f"inverse_viscous_limit_{k}"]}
                energy = energy + g * LAWS["gent"].energy(first + second + 1.0 / (first * second) - 3.0, limit)
            else:
                every = (first, second, branch.thin)
                energy = energy + 0.5 * g * sum(stretch - 1.0 - np.log(stretch) for stretch in every)
        return energy

    def limit_share(self, m: Any, width: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The largest share of its stretch limit that a branch has reached."""
        largest: Any = 0.0
        for k, _, branch in self._each(m, width, y, n) if self.flow == "log" else ():
            first, second = branch.first, branch.second
            share = (first + second + 1.0 / (first * second) - 3.0) * n[f"inverse_viscous_limit_{k}"]
            largest = xp.maximum(largest, share)
        return largest


def _equivalent(own: Strained) -> Any:
    """The squared equivalent stress over g^2."""
    return own.along * own.along - own.along * own.across + own.across * own.across
