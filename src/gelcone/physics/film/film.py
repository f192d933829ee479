"""The contract of a film: the force with which film and field pull on the disc, and what it does to the film."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gelcone.codes import FilmPullIn, Outcome
from gelcone.errors import InputError
from gelcone.physics.component import Component, Numbers
from gelcone.physics.contract import (
    DEFAULTS,
    GRID,
    NAMED,
    NUMBERS,
    ONE_EACH,
    PAIR,
    PLACES,
    TEXT,
    Trial,
    check_formulas,
    check_rates,
    check_slope,
    listed,
    numbers_of,
    wrong,
)
from gelcone.physics.differentiate import derivative
from gelcone.physics.implicit import traced
from gelcone.physics.quadrature import integral
from gelcone.quantity import Array

SMALL = 1e-6
"""A displacement at which limits at the flat film are taken: forces are odd in x, so the error is its square."""

TRIAL_SQUARED = 0.04
"""Squared voltage at which the formulas of a user-defined film are called when its class is read."""

DIFFERENCE = 1e-5
"""Relative step of the central difference of the capacitance."""


class FilmState(NamedTuple):
    """True stretches, true stresses over mu, true field over sqrt(mu/eps), and (I1 - 3) over the stretch limit, NaN if
    unknown; ``kind`` is the index of the state of tension among the film's ``kinds``, -1 for none."""

    meridional_stretch: Any
    hoop_stretch: Any
    thickness_stretch: Any
    meridional_stress: Any
    hoop_stress: Any
    true_field: Any
    limit_share: Any
    kind: Any = -1


class TracedState(NamedTuple):
    """Formulas of a `FilmState` in a program: true stresses over mu, the squared true field over mu/eps, and the share
    of the stretch limit."""

    meridional_stress: Any
    hoop_stress: Any
    field_squared: Any
    limit_share: Any


@dataclass(frozen=True)
class Border:
    """A border at which the law of a film or circuit changes, or at which the film ends.

    Parameters
    ----------
    value : function (x, squared, y, n, xp), of a circuit (port, y, n, xp), that is positive on the current side of the
        border and falls through zero at a crossing.
    switch : name of the number, 1 or -1, that is a factor of the value and changes its sign there. Default: none, the
        film ends there.
    seldom : motions rarely come near, and the value costs more than the force.
    jumps : the force jumps there.
    divides : the force and other borders have another formula with each sign of the switch.
    gentle : the force is continuous and leads no motion back, so that a switch that flips without end does so by
        rounding, which does not end the film.
    folds : the minimum of the energy ends there at a constant voltage; behind a resistance the slope of the charge
        replaces this border.

    Examples
    --------
    >>> import gelcone
    >>> limit = gelcone.Border(lambda port, y, n, xp: n["below"] * (0.5 - port.command), "below")
    >>> from types import SimpleNamespace
    >>> limit.value(SimpleNamespace(command=0.3), [], {"below": 1.0}, None)
    0.2
    """

    value: Callable[..., Any]
    switch: str | None = None
    seldom: bool = False
    jumps: bool = False
    divides: bool = False
    gentle: bool = False
    folds: bool = False


class Film(Component):
    """The action of film and electric field on the disc, per mu Vol/(b-a), at the displacement x and squared voltage V.

    A new one supplies `force`, and `rates` for the ``states`` that it adds. The rest follows numerically from the
    force, and is overridden where a closed form is known. The force must be odd in x unless `odd` says otherwise, and
    must not grow with V for x > 0.

    Examples
    --------
    >>> import gelcone
    >>> class Straight(gelcone.Film):
    ...     name = "straight"
    ...     parameters = {"film_modulus": gelcone.Quantity("c", "modulus of the film", 2.0, positive=True)}
    ...
    ...     def force(self, x, squared, y, n, xp=None):
    ...         stiffness = n["film_modulus"] - squared
    ...         return stiffness * x, stiffness + 0.0 * x
    >>> model = gelcone.ConeModel(film=Straight(), film_modulus=3.0, spring_stiffness=1.0, rest_height=0.8)
    >>> round(gelcone.static(model, [0.0]).equilibrium_displacement.values.item(), 6)
    0.2
    """

    ending: ClassVar[Outcome] = Outcome.STRETCH_LIMIT
    """Outcome of a run that leaves the displacements and voltages for which the film has a state."""
    borders: tuple[Border, ...] = ()
    """Borders at which its law changes, and at which it pulls in; see `Border`."""
    linear_charge: ClassVar[bool] = False
    """Whether the charge is proportional to the voltage at every displacement."""
    traced_charge: ClassVar[bool] = False
    """Whether `capacitance` runs in a program too. A circuit that uses the charge needs that, and so does an energy
    balance that does not rest on the film's energy; the current then follows from it."""
    fitted_charge: ClassVar[bool] = False
    """Whether programs take the charge from a fit; behind an ideal source the energy balance then uses the energy."""
    folds: ClassVar[bool] = False
    """Whether the slope of its charge over the voltage has a pole where the minimum of its energy ends."""
    kinds: tuple[str, ...] = ()
    """Names of its states of tension, whose shares of time results report."""

    # --- what the equation of motion takes ---------------------------------------------------------------------------

    @abstractmethod
    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """Force that pulls the disc back, and its derivative by x. ``y`` holds the film's states; it is empty in
        statics, which use the settled film."""

    def prove(self, given: Numbers = DEFAULTS) -> None:
        """Compare the stated slope of the force with its derivative, too."""
        super().prove(given)
        n, many = numbers_of(self, given)
        x, squared = GRID, TRIAL_SQUARED
        y = [np.broadcast_to(start, x.shape) for start in self.starts(x, many)]
        check_formulas(self, [Trial("switches", (x, squared, y, many), NAMED)])
        here, at_places = {**many, **self.switches(x, squared, y, many)}, {**n, **self.switches(PLACES, squared, [], n)}
        of_place = ("strain", "drag")
        of_voltage = ("voltage_gain", "turning", "balancing")
        of_states = ("voltage_force", "work", "capacitance")
        fits, words = listed(len(self.states))
        check_formulas(
            self,
            [
                *(Trial("force", (x, squared, states, here), PAIR) for states in ([], y)),
                Trial("rates", (x, x, squared, y, here), (fits, words)),
                Trial(
                    "relaxed", (x, squared, here), (lambda states: states is None or fits(states), f"None, or {words}")
                ),
                Trial("dissipation", (x, x, squared, y, here), NUMBERS),
                *(Trial(name, (x, here), NUMBERS) for name in (*of_place, "highest_squared")),
                *(Trial(name, (x, squared, here), NUMBERS) for name in of_voltage),
                *(Trial(name, (x, squared, y, here), NUMBERS) for name in of_states),
                *(Trial(name, (x, y, here), NUMBERS) for name in ("overstretched", "highest_squared_held")),
                Trial("limit_share", (x, squared, y, here), NUMBERS),
                Trial("state", (x, squared, y, here), listed(len(FilmState._fields), "fields of a FilmState")),
                Trial("current", (x, x, squared, squared, here), NUMBERS),
                *(Trial(name, (many,), ONE_EACH) for name in ("odd", "strain_limit", "stiffness_scale")),
                Trial("reach", (n,), listed(2, "ends")),
                Trial("outside", (1.0, n), TEXT),
                Trial("unreachable", (n,), TEXT),
                Trial("describe", (), TEXT),
            ],
        )
        if np.isnan(self.highest_squared(0.0, n)):
            raise wrong(self, "highest_squared", "is NaN at x = 0", "return infinity if no voltage is too high")
        held, borders = [start[0] for start in y], bool(self.borders)
        check_slope(
            self, lambda x, states, xp: self.force(x, squared, states, at_places, xp), held, bool(self.odd(n)), borders
        )
        check_rates(self, len(self.states), lambda z, xp: self.rates(z[0], z[1], squared, z[2:], at_places, xp))

    def rates(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the film's states."""
        return []

    def relaxed(self, x: Any, squared: Any, n: Numbers) -> list[Any] | None:
        """The film's states at rest at x and V. Default None: Newton's method on the `rates` finds them."""
        return None

    @property
    def dissipates(self) -> bool:
        """True if the film has a `dissipation`."""
        return type(self).dissipation is not Film.dissipation

    @property
    def drags(self) -> bool:
        """True if the film has a `drag`. Default False."""
        return False

    def drag(self, x: Any, n: Numbers) -> Any:
        """Damping coefficient of the disc by the film, force over velocity. Default 0."""
        return 0.0 * x

    def dissipation(self, x: Any, velocity: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Power that the film dissipates. Default 0."""
        return 0.0

    def odd(self, n: Numbers) -> Any:
        """Whether the force is odd in x. Default True."""
        return True

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The reduction of the force by the voltage."""
        return self.force(x, 0.0, y, n, xp)[0] - self.force(x, squared, y, n, xp)[0]

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of its borders at the start of a motion, 1 or -1; NaN where the film has pulled in."""
        return {}

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        """Sum the time in each of its ``kinds``, (members, kinds), from ``dwell``, (members, 2^switches): the time in
        each combination of signs of the ``switches``, where bit k of the index is set if the k-th is negative."""
        return np.zeros((len(dwell), 0))

    def pull_in_kind(self, switches: Numbers) -> Any:
        """The `gelcone.codes.FilmPullIn` of a run that ended at a border without switch, from the switches."""
        return np.array(FilmPullIn.MINIMUM)

    # --- where it has a state ----------------------------------------------------------------------------------------

    def strain(self, x: Any, n: Numbers) -> Any:
        """A measure that grows with |x| and reaches `strain_limit` where the film's states end. Default x^2."""
        return x * x

    def strain_limit(self, n: Numbers) -> Any:
        """Default infinity."""
        return np.asarray(np.inf)

    def overstretched(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """Whether its states exceed their limit at x. Default False."""
        return np.zeros(np.shape(x), dtype=bool)

    def reach(self, n: Numbers) -> tuple[float, float]:
        """The smallest and largest |x| with a state, of one actuator; NaN if none. Default 0 and infinity."""
        return 0.0, np.inf

    def outside(self, x: float, n: Numbers) -> str:
        """The message for a start at which a single film has no state, with the remedy."""
        return f"initial displacement {x:g}: the film has no state there; start lower"

    def unreachable(self, n: Numbers) -> str:
        """The message for a single film without a state at any displacement, with the remedy."""
        return "the film has no state at any displacement; change its parameters"

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V above which the film has no state. Default infinity."""
        return np.full(np.shape(x), np.inf)[()]

    def highest_squared_held(self, x: Any, y: list[Any], n: Numbers) -> Any:
        """The V above which the film has no state while its states are ``y``. Default `highest_squared`."""
        return self.highest_squared(x, n)

    # --- statics -----------------------------------------------------------------------------------------------------

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        """-dF/dV, the rate at which the squared voltage reduces the force."""
        numbers = {**n, **self.switches(x, squared, [], n)}
        gain = -derivative(lambda at, xp: self.force(x, at, [], numbers, xp)[0], squared)
        return np.where(np.isnan(self.force(x, squared, [], n)[0]), np.nan, gain)[()]

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        """x dF/dx - F of the force F."""
        force, slope = self.force(x, squared, [], n)
        return x * slope - force

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """The V at which the force at x is ``pull`` times x, at x = 0 its limit.

        The default takes a force that is linear in V.
        """
        nearby = np.where(np.asarray(x) == 0.0, SMALL, x)
        with np.errstate(all="ignore"):
            squared = (self.force(nearby, 0.0, [], n)[0] - pull * nearby) / self.voltage_gain(nearby, 0.0, n)
        return squared[()]

    def stiffness_scale(self, n: Numbers) -> Any:
        """A typical stiffness, which bounds the rate of the motion. Default: that at the flat film."""
        return np.abs(self.force(0.0, 0.0, [], n)[1])

    # --- energies ----------------------------------------------------------------------------------------------------

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """Energy of film and field less the charge times the voltage, at the film's states ``y``; 0 for the flat
        film, up to a constant. Default: the integral of the force over x; NaN (unknown) with states."""
        if y:
            return np.full(np.shape(x), np.nan)
        return integral(lambda at: self.force(at, squared, [], n)[0], np.asarray(x, dtype=float))

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Capacitance over that of the flat film: mean square of the deformed over the mounted area, -2 dE/dV of the
        energy E. The charge on the film is the voltage times this, and the energy of the field V/2 times this."""
        if traced(xp):
            raise InputError(
                f"film {self.name!r}: its charge is not known while a motion is computed, which the circuit needs; "
                "take the taut film or the ideal source"
            )
        return 1.0 + 2.0 * integral(lambda at: self.voltage_gain(at, squared, n), np.asarray(x, dtype=float))

    def fitted_capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """The `capacitance` that programs have, of arrays. Default: the capacitance itself."""
        return self.capacitance(x, squared, y, n)

    def current(self, x: Any, velocity: Any, voltage: Any, rate: Any, n: Numbers) -> Any:
        """Rate of the charge while displacement and ``voltage`` change at a ``velocity`` and a ``rate``; NaN (unknown)
        for a film with states.

        The capacitance grows with x as fast as the voltage weakens the force, both from one energy; its slope over V is
        a central difference.
        """
        squared = voltage * voltage
        shares = (1.0, 1.0 + DIFFERENCE, 1.0 - DIFFERENCE)
        area, above, below = (self.capacitance(x, share * squared, [], n) for share in shares)
        by_voltage = area if self.linear_charge else area + (above - below) / DIFFERENCE
        charge_rate = rate * by_voltage + 2.0 * voltage * velocity * self.voltage_gain(x, squared, n)
        return charge_rate * np.nan if self.states else charge_rate

    # --- state and description ---------------------------------------------------------------------------------------

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """Stretches, stresses and field of the film at x and the voltage. Default: unknown."""
        unknown = np.full(np.broadcast_shapes(np.shape(x), np.shape(voltage)), np.nan)
        return FilmState(*[unknown] * (len(FilmState._fields) - 1))

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        """The formulas of `state` for a program; None (default) where none are known."""
        return None

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        """The share of its strain limit that the film has reached, 1 at the limit. ``state`` is its own, if known."""
        return self.strain(x, n) / self.strain_limit(n)

    def describe(self) -> str:
        """A note about the film for readers of a result. Default: empty."""
        return ""
