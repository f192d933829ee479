"""The amplifier with its limits, and a film that leaks or polarizes with a delay.

The amplifier follows its command v_s with the voltage y of a low-pass filter, drives the film through a series
resistance, and the film leaks:

    y' = clip((v_s - y)/t_f, +-S),    i = clip((y - v)/rho, +-i_max),    (C v)' = i - C f(v)/tau_e,

with f = v, or E_b sinh(E/E_b)/sqrt(C) of the true field E = v sqrt(C) where ions hop (Mott and Gurney, Electronic
Processes in Ionic Crystals (1940)). The film's voltage is the state, C v' = i - leak - v C', for any film whose charge
is known while a motion is computed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from typing import Any

import numpy as np

from gelcone.errors import InputError, check_name
from gelcone.physics.circuit import Circuit, IdealSource, Port
from gelcone.physics.component import Numbers, State
from gelcone.physics.film.film import Border
from gelcone.quantity import Quantity

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
"""The parameters that an `Amplifier` may take."""
NEEDS = {
    "slew_rate": "filter_time", "current_limit": "series_resistance", "leakage_field": "leakage_time",
    "dielectric_share": "dielectric_time", "dielectric_time": "dielectric_share",
}  # fmt: skip
"""Parameters -> the parameter that they need."""
ABSENT = {"filter_time": 0.0, "series_resistance": 0.0, "dielectric_share": 0.0}
"""Parameters -> the value that stands for an absent one; infinity for all others."""


SLOW = ("filter_time", "series_resistance", "dielectric_time")
"""Parameters that are time constants of states."""
MOST_TURNS, SAME = 60, 1e-15
"""Most fixed-point iterations for the voltage of a source behind a resistance without a state, and the change that ends
them."""
REDUCED_RESISTANCE = 0.01
"""Series resistance below which it may have no state; the error, of second order, is 7.5e-4 there."""


@dataclass(frozen=True)
class Amplifier(Circuit):
    """An amplifier with a filter and a slew rate, a resistance and a current limit behind it, and a film that leaks and
    whose permittivity follows the field with a delay.

    A small resistance makes the voltage on the film a stiff state. ``reduced`` replaces the state, to second order in
    the resistance, by v = y - rho ((C y)' + leak) at the voltage y of the amplifier. The capacitance of the films must
    not depend on the voltage.

    Parameters
    ----------
    takes : names of its parameters, of `ELECTRICS`. Default the series resistance alone.
    reduced : whether the series resistance, below `REDUCED_RESISTANCE`, has no state. Default no.
    """

    takes: tuple[str, ...] = ("series_resistance",)
    reduced: bool = False

    name = "amplifier"

    def __post_init__(self) -> None:
        for name in self.takes:
            check_name("parameter of an amplifier", name, ELECTRICS)
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
        parameters = {name: ELECTRICS[name] for name in self.takes}
        if self.reduced:
            parameters["series_resistance"] = replace(parameters["series_resistance"], default=0.3 * REDUCED_RESISTANCE)
        return parameters

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check the parameters and fill in their defaults; the delayed share of the permittivity is below 1."""
        full = super().complete(given)
        if self.delays and np.any(np.asarray(full["dielectric_share"]) >= 1.0):
            raise InputError(f"dielectric_share = {np.max(full['dielectric_share']):g}: must be below 1; lower it")
        if self.reduced and np.any(np.asarray(full["series_resistance"]) >= REDUCED_RESISTANCE):
            raise InputError(
                f"series_resistance = {np.max(full['series_resistance']):g} (times C0 Omega0): without a state it must "
                f"be below {REDUCED_RESISTANCE:g}; leave it out of reduced"
            )
        return full

    @cached_property
    def states(self) -> tuple[State, ...]:  # type: ignore[override]
        """The voltage of the amplifier, the delayed charge and the voltage on the film, where each is a state."""
        states = {
            "filter_time": State("amplifier_voltage", "voltage of the amplifier", "voltage"),
            "dielectric_time": State("slow_charge", "charge that follows late, over its share", "charge"),
            "series_resistance": State("film_voltage", "voltage on the film", "voltage"),
        }
        without = {"series_resistance"} if self.reduced else set()
        return tuple(state for name, state in states.items() if name in self.takes and name not in without)

    @property
    def _limits(self) -> dict[str, tuple[str, str]]:
        """Names of its limits -> names of the switches of the upper and the lower side."""
        return {
            name: (f"{name}_above", f"{name}_below") for name in ("slew_rate", "current_limit") if name in self.takes
        }

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        numbers = super().numbers(parameters)
        switches = [name for pair in self._limits.values() for name in pair]
        return numbers | {name: np.ones(np.shape(numbers[name.rpartition("_")[0]])) for name in switches}

    def time_constant(self, n: Numbers) -> Any:
        of_states = SLOW if not self.reduced else SLOW[:1]
        time_constants = [np.asarray(n[name], dtype=float) for name in of_states if name in self.takes]
        return reduce(np.maximum, time_constants, np.asarray(0.0))

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

    def commanded(self, port: Port, voltage: Any, n: Numbers) -> Any:
        """The command under which the leak flows through the resistance; infinite where the leak exceeds the limit of
        the current."""
        if not {"series_resistance", "leakage_time"} <= set(self.takes):
            return voltage
        rho = n["series_resistance"]
        if self.reduced:  # the leak is that at the source's voltage
            source = voltage
            for _ in range(MOST_TURNS):
                before, source = source, voltage + rho * sum(self._leaking(source, port, n, np))
                if np.all(np.abs(source - before) <= SAME * np.abs(source)):
                    break
            return source
        through = sum(self._leaking(voltage, port, n, np))
        command = voltage + rho * through
        return np.where(through > n["current_limit"], np.inf, command) if "current_limit" in self.takes else command

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
        rates = []
        if "filter_time" in self.takes:
            rates.append(self._limited("slew_rate", port, y, n))
        if self.delays:
            rates.append(self._following(port, y, n, xp))
        if self.carries_voltage:
            rates.append(port.voltage_rate(y[-1], self.charging(port, y, n, xp)))
        return rates

    # --- a permittivity that follows with a delay --------------------------------------------------------------------

    @property
    def delays(self) -> bool:
        return "dielectric_time" in self.takes

    @property
    def jumps(self) -> bool:
        return "filter_time" not in self.takes and not self.carries_voltage

    def _slow(self, y: list[Any]) -> Any:
        """The delayed charge C w, over its share."""
        return y[1 if "filter_time" in self.takes else 0]

    def _following(self, port: Port, y: list[Any], n: Numbers, xp: Any) -> Any:
        """The rate of the delayed charge, (C v - C w)/tau_d."""
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
        """Rate of C v; with a delayed share of the charge, the rate of the rest."""
        charging = self._limited("current_limit", port, y, n) - sum(self.leaks(port, y, n, xp))
        if not self.delays:
            return charging
        share = n["dielectric_share"]
        return (charging - share * self._following(port, y, n, xp)) / (1.0 - share)

    def _wanted(self, limit: str, port: Port, y: list[Any], n: Numbers) -> Any:
        """The rate of the amplifier's voltage, or the current behind it, without its ``limit``."""
        if limit == "slew_rate":
            return (port.command - y[0]) / n["filter_time"]
        return (self.source_voltage(port, y, n) - y[-1]) / n["series_resistance"]

    def _limited(self, limit: str, port: Port, y: list[Any], n: Numbers) -> Any:
        """The rate, or the current, clipped at its ``limit`` on the side that the switches state."""
        value = self._wanted(limit, port, y, n)
        if limit not in self.takes:
            return value
        above, below = (0.5 - 0.5 * n[name] for name in self._limits[limit])
        return (1.0 - above - below) * value + (above - below) * n[limit]

    def leaks(self, port: Port, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        return self._leaking(self.voltage(port, y, n, xp) if "leakage_time" in self.takes else 0.0, port, n, xp)

    def _leaking(self, v: Any, port: Port, n: Numbers, xp: Any) -> list[Any]:
        """Current that leaks through each film at the voltage v."""
        if "leakage_time" not in self.takes:
            return [0.0] * len(port.films)
        rate = 1.0 / n["leakage_time"]
        if "leakage_field" not in self.takes:
            return [rate * (area * v) for area in port.capacitances(v)]
        leaks = []
        for area in port.capacitances(v):
            root = xp.sqrt(area)
            share = root * v / n["leakage_field"]
            leaks.append((rate * n["leakage_field"]) * (root * (0.5 * (xp.exp(share) - xp.exp(-share)))))
        return leaks

    # --- limits ------------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """Borders at the slew rate and the current limit, on either side."""
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
        parameters = {"resistor": "series_resistance", "leak": "leakage_time", "dielectric": "dielectric_time"}
        return tuple(loss for loss, name in parameters.items() if name in self.takes)

    @property
    def held(self) -> Circuit:
        leaks = tuple(name for name in ("leakage_time", "leakage_field") if name in self.takes)
        return Amplifier(leaks) if leaks else super().held

    def powers(self, port: Port, current: Any, y: list[Any], n: Numbers, xp: Any = np) -> Mapping[str, Any]:
        source, v = self.source_voltage(port, y, n, xp), self.voltage(port, y, n, xp)
        leak = sum(self.leaks(port, y, n, xp))
        through = self._limited("current_limit", port, y, n) if self.carries_voltage else current + leak
        lost = {"resistor": (source - v) * through, "leak": v * leak}
        if self.delays:
            rate = self._following(port, y, n, xp)
            lost["dielectric"] = n["dielectric_share"] * n["dielectric_time"] * (rate * rate) / port.capacitance(v)
        return {"source": source * through} | {loss: lost[loss] for loss in self.losses}


def with_electrics(
    given: Any, parameters: Mapping[str, Any], reduced: bool | None = None
) -> tuple[Any, dict[str, Any]]:
    """Return the ideal source, or the amplifier with the `ELECTRICS` among the ``parameters`` of a model, and the
    parameters without absent ones; any other circuit stays unchanged. ``reduced``: see `Amplifier`; None: as given."""
    record: Mapping[str, Any] = {"component": given} if isinstance(given, str) else given
    if not isinstance(record, Mapping):
        record = {"component": given.name, **vars(given)}
    named = record.get("component")
    if named not in ("ideal", "amplifier") or not isinstance(given, str | Mapping | IdealSource | Amplifier):
        if reduced:
            raise InputError(f"reduced: the circuit {named!r} has no series_resistance; leave it out")
        return given, dict(parameters)
    reduced = record.get("reduced", False) if reduced is None else reduced
    taken = record.get("takes", ())
    stated = {name for name in ELECTRICS if parameters.get(name) is not None}
    absent = {name for name in stated if _absent(name, parameters[name])}
    takes = tuple(name for name in {**dict.fromkeys(taken), **dict.fromkeys(stated)} if name not in absent)
    rest = {name: value for name, value in parameters.items() if name not in ELECTRICS or name in takes}
    if not takes and given == "amplifier" and not absent:
        takes = Amplifier().takes
    if reduced and "series_resistance" in absent:
        reduced = False
    return (Amplifier(takes, reduced) if takes or reduced else IdealSource()), rest


def _absent(name: str, value: Any) -> bool:
    """Whether a value stands for an absent parameter."""
    numbers = isinstance(value, int | float | np.ndarray | list | tuple)
    return numbers and bool(np.all(np.asarray(value) == ABSENT.get(name, np.inf)))
