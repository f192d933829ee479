"""Circuits between the commanded voltage and the film: the ideal source, an amplifier with its limits, charge control.

The `Amplifier` commands y through a low-pass filter, drives the film through a series resistance, and the film leaks:

    y' = clip((v_s - y)/t_f, +-S),    i = clip((y - v)/rho, +-i_max),    (C v)' = i - C f(v)/tau_e,

with f = v, or E_b sinh(E/E_b)/sqrt(C) of the true field E = v sqrt(C) where ions hop (Mott and Gurney, Electronic
Processes in Ionic Crystals (1940)). The film's voltage is the state, so that any film will do whose charge is known
while a motion is computed: C v' = i - leak - v C'.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from typing import Any

import numpy as np

from gelcone.errors import InputError, unknown_name
from gelcone.physics.component import Component, Numbers, State
from gelcone.physics.differentiate import derivatives, gradients
from gelcone.physics.film.film import Border
from gelcone.physics.implicit import root, traced
from gelcone.physics.placed import PlacedFilm
from gelcone.quantity import Quantity

LOSSES = ("resistor", "leak", "dielectric")
"""Where a circuit may lose power: behind the source, through the film, and in a permittivity that follows late."""


@dataclass(frozen=True)
class Port:
    """The connections of a circuit: the command, and the films on which it puts a voltage, in parallel.

    All values are over the scales of the model; a capacitance over that of the flat film (C0 = eps pi (b^2 - a^2)/H), a
    current over C0 Phi0 Omega0.

    Parameters
    ----------
    command : the commanded voltage.
    displacement, velocity : those of the disc.
    rate_of_command : gives the rate of the commanded voltage, see `command_rate`.
    films : each film with its states.
    n : the numbers of the system, by name.
    xp : the functions that formulas take.

    Examples
    --------
    >>> import gelcone
    >>> port = gelcone.Port(0.5, 0.2, 0.0, lambda: 0.1, (), {}, None)  # made by gelcone for each evaluation
    >>> port.command, port.command_rate
    (0.5, 0.1)
    """

    command: Any
    displacement: Any
    velocity: Any
    rate_of_command: Callable[[], Any]
    films: tuple[tuple[PlacedFilm, list[Any]], ...]
    n: Numbers
    xp: Any

    @cached_property
    def command_rate(self) -> Any:
        """Rate of the commanded voltage."""
        return self.rate_of_command()

    def capacitances(self, voltage: Any) -> list[Any]:
        """The capacitance of each film at a voltage."""
        return [film.capacitance(self.displacement, voltage * voltage, y, self.n, self.xp) for film, y in self.films]

    def capacitance(self, voltage: Any) -> Any:
        """The films' capacitance at a voltage."""
        parts = self.capacitances(voltage)
        return sum(parts[1:], parts[0])

    def charge(self, voltage: Any) -> Any:
        """The films' charge at a voltage."""
        return voltage * self.capacitance(voltage)

    def voltage(self, charge: Any) -> Any:
        """The voltage at which the films hold a charge."""
        unlike = [film.film for film, _ in self.films if not film.film.linear_charge]
        if traced(self.xp) and any(film.borders for film in unlike):  # the width of a wrinkled film is a root itself
            raise InputError(
                f"film {unlike[0].name!r}: its voltage does not follow from its charge while a motion is computed; "
                "take a circuit whose state is the film's voltage (Port.voltage_rate), or the taut film"
            )
        flat = charge / self.capacitance(0.0 * charge)
        if not unlike:
            return flat

        def residual(v: Any, charge: Any, xp: Any) -> Any:
            return replace(self, xp=xp).charge(v) - charge

        name = f"voltage of a charge on {', '.join(film.words for film, _ in self.films)}"
        return root(self.xp, name, residual, (charge,), lambda charge, xp: flat)

    def voltage_rate(self, voltage: Any, current: Any) -> Any:
        """Rate of the voltage while a current charges the films and the disc moves; the voltage must be a state."""
        by_voltage, *by_others = self._slopes(voltage)
        for slope, rate in zip(by_others, self._moving(voltage), strict=True):
            current = current - slope * rate
        return current / by_voltage

    def _moving(self, voltage: Any) -> list[Any]:
        """Rates of displacement and films' states at a voltage."""
        found = [self.velocity]
        for film, y in self.films:
            found += film.rates(self.displacement, self.velocity, voltage * voltage, y, self.n, self.xp)
        return found

    def charge_rate(self, voltage: Any, rate: Any) -> Any:
        """Rate of the charge at a voltage and its rate while the disc moves, of films whose capacitance does not depend
        on the voltage, which must not depend on the disc or on the films' states."""
        found = self.capacitance(voltage) * rate
        for slope, change in zip(self._slopes(voltage, False), self._moving(voltage), strict=True):
            found = found + slope * change
        return found

    def slope(self, voltage: Any) -> Any:
        """Derivative of the films' charge by the voltage, which must be a state; it has a pole where the minimum of a
        film's energy ends."""
        return self._slopes(voltage)[0]

    def _slopes(self, voltage: Any, by_voltage: bool = True) -> list[Any]:
        """Derivatives of the charge ``by_voltage``, displacement and the films' states."""
        at = [voltage, self.displacement, *(value for _, y in self.films for value in y)]

        def charge(at: list[Any], xp: Any) -> list[Any]:
            left, films = iter(at[2:]), []
            for film, y in self.films:
                films.append((film, [next(left) for _ in y]))
            port = replace(self, displacement=at[1], films=tuple(films), xp=xp)
            return [port.charge(at[0])]

        if not traced(self.xp):
            return gradients(charge, at)[0][0 if by_voltage else 1 :]
        (found,) = charge(at, self.xp)
        return [derivatives([self.xp.node(found)], leaf)[0] for leaf in at[0 if by_voltage else 1 :]]


class Circuit(Component):
    """A circuit turns the commanded voltage into that on the film.

    A new one supplies `voltage`, and `rates` for the ``states`` that it adds; `gain` where it is linear and its gain is
    not 1. A state may be the film's charge, whose rate is the current (`Port.voltage` gives the voltage), or its
    voltage, whose rate is `Port.voltage_rate` of what `charging` gives; then it is the last one, and
    ``carries_voltage`` is True. Where its law changes, as at a limit, it lists ``borders``: the value of
    each is ``value(port, y, n, xp)``, and its switch, one of the circuit's `numbers`, has the sign of the side (see
    `Border`). A circuit with states or borders has the period of the voltage itself, since these follow the voltage's
    sign.

    Examples
    --------
    >>> import gelcone
    >>> class Filter(gelcone.Circuit):
    ...     name = "filter"
    ...     states = (gelcone.State("film_voltage", "voltage on the film", "voltage"),)
    ...     parameters = {"filter_constant": gelcone.Quantity("t", "time constant", 0.3, positive=True, scale="time")}
    ...
    ...     def voltage(self, port, y, n, xp=None):
    ...         return y[0]
    ...
    ...     def rates(self, port, y, n, xp=None):
    ...         return [(port.command - y[0]) / n["filter_constant"]]
    ...
    ...     def time_constant(self, n):
    ...         return n["filter_constant"]
    >>> model = gelcone.ConeModel(circuit=Filter(), voltage=0.5)
    >>> gelcone.settled(model.replace(rest_height=0.8)).stroke.round(5).item()
    0.09453
    """

    borders: tuple[Border, ...] = ()
    carries_voltage: bool = False

    @abstractmethod
    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film, given the circuit's own states ``y``."""

    def rates(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the circuit's states."""
        return []

    def charging(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Rate of the films' charge, of a circuit that carries their voltage."""
        raise NotImplementedError

    def switches(self, port: Port, y: list[Any], n: Numbers) -> dict[str, Any]:
        """The switches of its borders at the start of a motion, 1 or -1: default the sign of each border's value."""
        found: dict[str, Any] = {}
        for border in self.borders:
            one = {**n, str(border.switch): 1.0}
            found[str(border.switch)] = np.where(np.asarray(border.value(port, y, one, np)) < 0.0, -1.0, 1.0)
        return found

    def gain(self, frequency: Any, n: Numbers) -> Any:
        """Complex ratio of the film's voltage to the commanded one at an angular frequency (0: a constant voltage)."""
        return 1.0 + 0.0j

    @property
    def losses(self) -> tuple[str, ...]:
        """Those of `LOSSES` that it has. Default: the first two where it has `powers` of its own."""
        return () if type(self).powers is Circuit.powers else LOSSES[:2]

    @property
    def held(self) -> Circuit:
        """The circuit of a film at a constant voltage of its own. Default: the ideal source."""
        return CIRCUITS["ideal"]

    def powers(self, port: Port, current: Any, y: list[Any], n: Numbers, xp: Any = np) -> Mapping[str, Any]:
        """Power of the ``source``, and what of it is lost where (`LOSSES`), while ``current`` charges the films.
        Default: a source that has the film's voltage, and no losses."""
        return {"source": self.voltage(port, y, n, xp) * current}

    def source_voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage at the output of the source, before what lies between it and the film. Default: the film's."""
        return self.voltage(port, y, n, xp)

    def leaks(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Current that leaks through each film. Default: none."""
        return [0.0] * len(port.films)

    def squared(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """The squared voltage with which the field pulls on the films. Default: that of the ``voltage`` on them."""
        return voltage * voltage

    def stored(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """The charge on the films at a ``voltage`` on them."""
        return port.charge(voltage)

    @property
    def delays(self) -> bool:
        """Whether a share of the permittivity follows the field with a delay."""
        return False

    @property
    def jumps(self) -> bool:
        """Whether the voltage on the films jumps where the command does. Default: where it has no states."""
        return not self.states

    def saturations(self, port: Port, y: list[Any], n: Numbers) -> Mapping[str, Any]:
        """By the name of each limit the excess over it that the circuit does not allow. Default: no limits."""
        return {}

    def describe(self) -> str:
        """A line about the circuit for those who read a result; empty (default) if there is nothing to say."""
        return ""

    def check(self) -> None:
        """`InputError` for borders that cannot be followed."""
        if any(border.switch is None for border in self.borders):
            raise InputError(f"circuit {self.name!r}: a border has no switch; name the number whose sign changes there")


class IdealSource(Circuit):
    """The film has the commanded voltage.

    Examples
    --------
    >>> import gelcone
    >>> gelcone.ConeModel().system.circuit == gelcone.IdealSource(), gelcone.IdealSource().time_constant({})
    (True, 0.0)
    """

    name = "ideal"

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return port.command


ELECTRICS: Mapping[str, Quantity] = {
    "filter_time": Quantity("tf", "time constant of the amplifier", 0.1, positive=True, scale="time"),
    "slew_rate": Quantity("S", "fastest change of the amplifier's voltage", 1.0, positive=True, scale="slew rate"),
    "series_resistance": Quantity(
        "rho", "resistance between amplifier and film times C0 Omega0", 0.03, positive=True, scale="resistance"
    ),
    "current_limit": Quantity(
        "im", "largest current of the amplifier over C0 Phi0 Omega0", 1.0, positive=True, scale="current"
    ),
    "leakage_time": Quantity(
        "te", "charge relaxation time of the gel, permittivity times resistivity", 30.0, positive=True, infinite=True,
        scale="time",
    ),
    "leakage_field": Quantity(
        "Ee", "true field over sqrt(mu/eps) above which a film leaks more than its resistivity says", 1.0,
        positive=True, scale="field",
    ),
    "dielectric_share": Quantity("chi", "share of the permittivity that follows with a delay", 0.3, positive=True),
    "dielectric_time": Quantity(
        "td", "time constant of that share", 3.0, positive=True, infinite=True, scale="time"
    ),
}  # fmt: skip
"""The parameters of an `Amplifier`, of which each has some."""
NEEDS = {
    "slew_rate": "filter_time", "current_limit": "series_resistance", "leakage_field": "leakage_time",
    "dielectric_share": "dielectric_time", "dielectric_time": "dielectric_share",
}  # fmt: skip
"""Parameters that need another."""
ABSENT = {"filter_time": 0.0, "series_resistance": 0.0, "dielectric_share": 0.0}
"""Values that stand for none; of the others infinity does."""


SLOW = ("filter_time", "series_resistance", "dielectric_time")
"""Parameters that are time constants of states."""
REDUCED_RESISTANCE = 0.01
"""Series resistances below which one may do without a state; the error, of second order, is 7.5e-4 there."""


@dataclass(frozen=True)
class Amplifier(Circuit):
    """An amplifier with a filter and a slew rate, a resistance and a current limit behind it, and a film that leaks and
    whose permittivity follows the field with a delay.

    A small resistance makes the voltage on the film a stiff state. ``reduced`` leaves it out, to second order in the
    resistance: v = y - rho ((C y)' + leak), all at the voltage y of the amplifier, of films whose capacitance does not
    depend on the voltage.

    Parameters
    ----------
    takes : names of `ELECTRICS` that it has. Default the series resistance alone.
    reduced : whether the series resistance, below `REDUCED_RESISTANCE`, has no state. Default no.
    """

    takes: tuple[str, ...] = ("series_resistance",)
    reduced: bool = False

    name = "amplifier"

    def __post_init__(self) -> None:
        for name in self.takes:
            if name not in ELECTRICS:
                raise unknown_name("parameter of an amplifier", str(name), ELECTRICS)
            if (owner := NEEDS.get(name)) and owner not in self.takes:
                raise InputError(f"{name}: there is no {owner}; give {owner}, or leave {name} out")
        object.__setattr__(self, "takes", tuple(name for name in ELECTRICS if name in self.takes))
        if self.reduced and "series_resistance" not in self.takes:
            raise InputError("reduced: there is no series_resistance; give one, or leave reduced out")
        for name in ("current_limit", "dielectric_share"):
            if self.reduced and name in self.takes:
                raise InputError(f"{name}: takes the voltage on the film as a state; leave it or reduced out")

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        own = {name: ELECTRICS[name] for name in self.takes}
        if self.reduced:
            own["series_resistance"] = replace(own["series_resistance"], default=0.3 * REDUCED_RESISTANCE)
        return own

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values of all parameters, checked; the share of the permittivity that follows late is below 1."""
        own = super().complete(given)
        if self.delays and np.any(np.asarray(own["dielectric_share"]) >= 1.0):
            raise InputError(f"dielectric_share = {np.max(own['dielectric_share']):g}: must be below 1; lower it")
        if self.reduced and np.any(np.asarray(own["series_resistance"]) >= REDUCED_RESISTANCE):
            raise InputError(
                f"series_resistance = {np.max(own['series_resistance']):g} (times C0 Omega0): without a state it must "
                f"be below {REDUCED_RESISTANCE:g}; leave it out of reduced"
            )
        return own

    @cached_property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        """The voltages of amplifier and film, where a filter or a resistance makes them states."""
        own = {
            "filter_time": State("amplifier_voltage", "voltage of the amplifier", "voltage"),
            "dielectric_time": State("slow_charge", "charge that follows late, over its share", "charge"),
            "series_resistance": State("film_voltage", "voltage on the film", "voltage"),
        }
        without = {"series_resistance"} if self.reduced else set()
        return tuple(state for name, state in own.items() if name in self.takes and name not in without)

    @property
    def _limits(self) -> dict[str, tuple[str, str]]:
        """The limits that it has, and the switches of either side of each."""
        return {
            name: (f"{name}_above", f"{name}_below") for name in ("slew_rate", "current_limit") if name in self.takes
        }

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        own = super().numbers(parameters)
        switches = [name for pair in self._limits.values() for name in pair]
        return own | {name: np.ones(np.shape(own[name.rpartition("_")[0]])) for name in switches}

    def time_constant(self, n: Numbers) -> Any:
        of_states = SLOW if not self.reduced else SLOW[:1]
        own = [np.asarray(n[name], dtype=float) for name in of_states if name in self.takes]
        return reduce(np.maximum, own, np.asarray(0.0))

    def gain(self, frequency: Any, n: Numbers) -> Any:
        """Complex ratio of the flat film's voltage to the commanded one, for small voltages."""
        s = 1j * np.asarray(frequency)
        leak = 1.0 / np.asarray(n["leakage_time"]) if "leakage_time" in self.takes else 0.0
        if self.delays:
            late = s * n["dielectric_time"]
            s = s * (1.0 - n["dielectric_share"] * late / (1.0 + late))
        share = n["series_resistance"] * (s + leak) if "series_resistance" in self.takes else 0.0
        behind = 1.0 / (1.0 - share) if self.reduced else 1.0 + share
        return 1.0 / (
            behind * (1.0 + 1j * np.asarray(frequency) * n["filter_time"] if "filter_time" in self.takes else 1.0)
        )

    def describe(self) -> str:
        bound = f"below {REDUCED_RESISTANCE:g} (times C0 Omega0)"
        return f"reduced: the series resistance, {bound}, has no state; right to second order" if self.reduced else ""

    # --- voltages and currents ---------------------------------------------------------------------------------------

    def source_voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return y[0] if "filter_time" in self.takes else port.command

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        source = y[-1] if self.carries_voltage else self.source_voltage(port, y, n, xp)
        if not self.reduced:
            return source
        rate = self.rates(port, y, n, xp)[0] if "filter_time" in self.takes else port.command_rate
        leak = sum(self._leaking(source, port, n, xp))
        return source - n["series_resistance"] * (port.charge_rate(source, rate) + leak)

    def rates(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        found = []
        if "filter_time" in self.takes:
            found.append(self._clipped("slew_rate", self._wanted("slew_rate", port, y, n), n))
        if self.delays:
            found.append(self._following(port, y, n, xp))
        if self.carries_voltage:
            found.append(port.voltage_rate(y[-1], self.charging(port, y, n, xp)))
        return found

    # --- a permittivity that follows late ----------------------------------------------------------------------------

    @property
    def delays(self) -> bool:
        return "dielectric_time" in self.takes

    @property
    def jumps(self) -> bool:
        return "filter_time" not in self.takes and not self.carries_voltage

    def _slow(self, y: list[Any]) -> Any:
        """The charge C w of the share that follows late, over the share."""
        return y[1 if "filter_time" in self.takes else 0]

    def _following(self, port: Port, y: list[Any], n: Numbers, xp: Any) -> Any:
        """Its rate, (C v - C w)/tau_d."""
        return (port.charge(self.voltage(port, y, n, xp)) - self._slow(y)) / n["dielectric_time"]

    def squared(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """(1 - chi) v^2 + chi w^2."""
        if not self.delays:
            return super().squared(port, voltage, y, n)
        late, share = self._slow(y) / port.capacitance(voltage), n["dielectric_share"]
        return (1.0 - share) * (voltage * voltage) + share * (late * late)

    def stored(self, port: Port, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """(1 - chi) C v + chi C w."""
        if not self.delays:
            return super().stored(port, voltage, y, n)
        return (1.0 - n["dielectric_share"]) * port.charge(voltage) + n["dielectric_share"] * self._slow(y)

    @property
    def carries_voltage(self) -> bool:  # type: ignore[override]
        """Whether the last state is the film's voltage: behind a resistance that is not reduced."""
        return "series_resistance" in self.takes and not self.reduced

    def charging(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Rate of C v; where a share of the charge follows late, what is left to the other."""
        charging = self._through(port, y, n) - sum(self.leaks(port, y, n, xp))
        if not self.delays:
            return charging
        share = n["dielectric_share"]
        return (charging - share * self._following(port, y, n, xp)) / (1.0 - share)

    def _wanted(self, limit: str, port: Port, y: list[Any], n: Numbers) -> Any:
        """The rate of the amplifier's voltage, or the current behind it, without their limits."""
        if limit == "slew_rate":
            return (port.command - y[0]) / n["filter_time"]
        return (self.source_voltage(port, y, n) - y[-1]) / n["series_resistance"]

    def _through(self, port: Port, y: list[Any], n: Numbers) -> Any:
        """Current through the resistance."""
        return self._clipped("current_limit", self._wanted("current_limit", port, y, n), n)

    def _clipped(self, limit: str, value: Any, n: Numbers) -> Any:
        """A value within the sides of its limit that the switches say."""
        if limit not in self.takes:
            return value
        above, below = (0.5 - 0.5 * n[name] for name in self._limits[limit])
        return (1.0 - above - below) * value + (above - below) * n[limit]

    def leaks(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        return self._leaking(self.voltage(port, y, n, xp) if "leakage_time" in self.takes else 0.0, port, n, xp)

    def _leaking(self, v: Any, port: Port, n: Numbers, xp: Any) -> list[Any]:
        """Current that leaks through each film at a voltage on them."""
        if "leakage_time" not in self.takes:
            return [0.0] * len(port.films)
        rate = 1.0 / n["leakage_time"]
        if "leakage_field" not in self.takes:
            return [rate * (area * v) for area in port.capacitances(v)]
        found = []
        for area in port.capacitances(v):
            root = xp.sqrt(area)
            share = root * v / n["leakage_field"]
            found.append((rate * n["leakage_field"]) * (root * (0.5 * (xp.exp(share) - xp.exp(-share)))))
        return found

    # --- limits ------------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """Where the slew rate and the current limit are met, on either side."""
        return tuple(
            Border(partial(self._border, limit, switch, side), switch)
            for limit, switches in self._limits.items()
            for switch, side in zip(switches, (1.0, -1.0), strict=True)
        )

    def _border(self, limit: str, switch: str, side: float, port: Port, y: list[Any], n: Numbers, xp: Any) -> Any:
        scale = n["filter_time" if limit == "slew_rate" else "series_resistance"]
        return n[switch] * (scale * (n[limit] - side * self._wanted(limit, port, y, n)))

    def saturations(self, port: Port, y: list[Any], n: Numbers) -> Mapping[str, Any]:
        return {limit: np.abs(self._wanted(limit, port, y, n)) - n[limit] for limit in self._limits}

    # --- powers ------------------------------------------------------------------------------------------------------

    @property
    def losses(self) -> tuple[str, ...]:
        own = {"resistor": "series_resistance", "leak": "leakage_time", "dielectric": "dielectric_time"}
        return tuple(loss for loss, name in own.items() if name in self.takes)

    @property
    def held(self) -> Circuit:
        leaks = tuple(name for name in ("leakage_time", "leakage_field") if name in self.takes)
        return Amplifier(leaks) if leaks else super().held

    def powers(self, port: Port, current: Any, y: list[Any], n: Numbers, xp: Any = np) -> Mapping[str, Any]:
        source, v, leak = (
            self.source_voltage(port, y, n, xp),
            self.voltage(port, y, n, xp),
            sum(self.leaks(port, y, n, xp)),
        )
        through = self._through(port, y, n) if self.carries_voltage else current + leak
        lost = {"resistor": (source - v) * through, "leak": v * leak}
        if self.delays:
            rate = self._following(port, y, n, xp)
            lost["dielectric"] = n["dielectric_share"] * n["dielectric_time"] * (rate * rate) / port.capacitance(v)
        return {"source": source * through} | {loss: lost[loss] for loss in self.losses}


class ChargeControl(Circuit):
    """The charge on the film is commanded, by the voltage that it gives the flat film."""

    name = "charge"

    def voltage(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return port.voltage(port.command)


CIRCUITS: dict[str, Circuit] = {circuit.name: circuit for circuit in (IdealSource(), Amplifier(), ChargeControl())}


def with_electrics(
    given: Any, parameters: Mapping[str, Any], reduced: bool | None = None
) -> tuple[Any, dict[str, Any]]:
    """A circuit that ships with the `ELECTRICS` among the ``parameters`` of a model, and the parameters without those
    whose values stand for none; any other circuit as it is. ``reduced``: see `Amplifier`; None: as it is given."""
    named = given if isinstance(given, str) else given.get("component") if isinstance(given, Mapping) else given.name
    if named not in ("ideal", "amplifier") or not isinstance(given, str | Mapping | IdealSource | Amplifier):
        if reduced:
            raise InputError(f"reduced: the circuit {named!r} has no series_resistance; leave it out")
        return given, dict(parameters)
    if reduced is None:
        reduced = given.get("reduced", False) if isinstance(given, Mapping) else getattr(given, "reduced", False)
    taken = (
        given.takes if isinstance(given, Amplifier) else given.get("takes", ()) if isinstance(given, Mapping) else ()
    )
    stated = {name for name in ELECTRICS if parameters.get(name) is not None}
    absent = {name for name in stated if _absent(name, parameters[name])}
    takes = tuple(name for name in {**dict.fromkeys(taken), **dict.fromkeys(stated)} if name not in absent)
    rest = {name: value for name, value in parameters.items() if name not in ELECTRICS or name in takes}
    if not takes and given == "amplifier" and not absent:
        takes = Amplifier().takes
    if reduced and "series_resistance" in absent:
        reduced = False
    return (Amplifier(takes, reduced) if takes or reduced else CIRCUITS["ideal"]), rest


def _absent(name: str, value: Any) -> bool:
    """Whether a value stands for none."""
    numbers = isinstance(value, int | float | np.ndarray | list | tuple)
    return numbers and bool(np.all(np.asarray(value) == ABSENT.get(name, np.inf)))
