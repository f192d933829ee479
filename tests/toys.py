"""Components of a user's own, which no file of gelcone knows: a film, a waveform, a bias and a circuit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone import Bias, Circuit, Film, Port, Quantity, State, StrainEnergyLaw, Waveform
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.film.film import Border
from gelcone.physics.film.wrinkling import WrinklingCone


@dataclass(frozen=True)
class PowerFilm(Film):
    """F = c x (x^2)^p - V x: the film stiffens with a power of its displacement."""

    exponent: float = 1.5

    name = "power film"
    parameters = {"film_modulus": Quantity("c", "modulus of the film", 0.8, lower=0.0)}

    def force(self, x: Any, squared: Any, y: list[Any], n: Any, xp: Any = np) -> tuple[Any, Any]:
        s = x * x
        # a power of x^2 that is smooth at 0, so that the Taylor integrator may pass there
        stiffness = n["film_modulus"] * ((1.0 + s) ** self.exponent - 1.0)
        slope = n["film_modulus"] * self.exponent * (1.0 + s) ** (self.exponent - 1.0)
        return x * (stiffness - squared), stiffness - squared + 2.0 * s * slope


class StatedCone(WrinklingCone):
    """A cone with the stated errors of a film that is fitted to states, which takes seconds."""

    name = "stated"

    def numbers(self, parameters: Any) -> dict[str, Any]:
        return super().numbers(parameters) | STATED


STATED = {"film_error": 0.03, "gain_error": 0.07, "capacitance_error": 0.02}


class ThreeHarmonics(Waveform):
    """v0 + v (sin + h2 sin 2 + h3 sin 3)."""

    name = "three harmonics"
    parameters = VOLTAGE | {
        "second_harmonic": Quantity("h2", "second harmonic over the first", 0.2),
        "third_harmonic": Quantity("h3", "third harmonic over the first", -0.1),
    }

    def shape(self, phase: Any, n: Any, xp: Any = np) -> Any:
        second, third = n["second_harmonic"] * xp.sin(2.0 * phase), n["third_harmonic"] * xp.sin(3.0 * phase)
        return xp.sin(phase) + second + third

    def shape_rate(self, phase: Any, n: Any, xp: Any = np) -> Any:
        second, third = (
            2.0 * n["second_harmonic"] * xp.cos(2.0 * phase),
            3.0 * n["third_harmonic"] * xp.cos(3.0 * phase),
        )
        return xp.cos(phase) + second + third


class CubicBias(Bias):
    """F = k1 x + k3 x^3."""

    name = "cubic"
    parameters = {
        "bias_stiffness": Quantity("k1", "stiffness at the flat film", 1.2),
        "bias_cubic": Quantity("k3", "cubic stiffness", 0.3, lower=0.0),
    }

    def force(self, x: Any, y: list[Any], n: Any, xp: Any = np) -> tuple[Any, Any]:
        k1, k3 = n["bias_stiffness"], n["bias_cubic"]
        return k1 * x + k3 * x * x * x, k1 + 3.0 * k3 * x * x


class Plate(CubicBias):
    """The same force; a device states its numbers in SI units."""

    name = "plate"
    parameters = {
        "bias_stiffness": Quantity("k1", "stiffness at the flat film", 1.2, scale="stiffness"),
        "bias_cubic": Quantity("k3", "cubic stiffness", 0.3, lower=0.0, scale="cubic stiffness"),
    }


class Quadratic(StrainEnergyLaw):
    """W = s/2 + a s^2/2."""

    name = "quadratic"
    parameters = {"law_growth": Quantity("a", "growth of the response with the strain", 0.1, lower=0.0)}

    def energy(self, strain: Any, n: Any, xp: Any = np) -> Any:
        return 0.5 * strain * (1.0 + n["law_growth"] * strain)

    def response(self, strain: Any, n: Any, xp: Any = np) -> Any:
        return 1.0 + 2.0 * n["law_growth"] * strain

    def response_slope(self, strain: Any, n: Any, xp: Any = np) -> Any:
        return 2.0 * n["law_growth"] + 0.0 * strain


class TurningBias(Bias):
    """A spring, and beside it a wheel of its own that turns by w and grows by g up to a circle: its rest loses its
    stability at g = 0, whatever the disc does."""

    name = "turning"
    states = (State("wheel_along", "wheel, first part"), State("wheel_across", "wheel, second part"))
    parameters = {
        "bias_stiffness": Quantity("k1", "stiffness", 1.2, lower=0.0),
        "bias_height": Quantity("x0", "height at which it does not pull", 0.4),
        "wheel_growth": Quantity("g", "growth rate of the wheel", -0.1),
        "wheel_turning": Quantity("w", "turning rate of the wheel", 0.618),
    }

    def force(self, x: Any, y: list[Any], n: Any, xp: Any = np) -> tuple[Any, Any]:
        return n["bias_stiffness"] * (x - n["bias_height"]), n["bias_stiffness"]

    def rates(self, x: Any, velocity: Any, y: list[Any], n: Any, xp: Any = np) -> list[Any]:
        a, b = y
        growth = n["wheel_growth"] - a * a - b * b
        return [growth * a - n["wheel_turning"] * b, growth * b + n["wheel_turning"] * a]

    def free_height(self, n: Any) -> Any:
        return n["bias_height"]


class FilteredVoltage(Circuit):
    """The film's voltage y follows the commanded one: y' = (v - y)/t."""

    name = "filter"
    states = (State("film_voltage", "voltage on the film", "voltage"),)
    parameters = {"filter_time": Quantity("t", "time constant of the filter", 0.3, positive=True)}

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        return y[0]

    def rates(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> list[Any]:
        return [(port.command - y[0]) / n["filter_time"]]

    def time_constant(self, n: Any) -> Any:
        return n["filter_time"]

    def gain(self, frequency: Any, n: Any) -> Any:
        return 1.0 / (1.0 + 1j * frequency * n["filter_time"])


class SeriesResistor(Circuit):
    """A film that leaks behind a resistance: Q' = (v_s - v)/rho - C v/tau_e, with the film's charge Q as state."""

    name = "series resistor"
    states = (State("charge", "charge on the film", "charge"),)
    parameters = {
        "series_resistance": Quantity("rho", "resistance times C0 Omega0", 0.8, positive=True),
        "leakage_time": Quantity("tau_e", "charge relaxation time of the gel", np.inf, positive=True, infinite=True),
    }

    def numbers(self, parameters: Any) -> dict[str, Any]:
        return {
            "conductance": 1.0 / np.asarray(parameters["series_resistance"]),
            "leak": 1.0 / np.asarray(parameters["leakage_time"]),
        }

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        return port.voltage(y[0])

    def rests_at_command(self, n: Any) -> bool:
        return bool(np.all(n["leak"] == 0.0))

    def commanded(self, port: Port, voltage: Any, n: Any) -> Any:
        return voltage + port.charge(voltage) * n["leak"] / n["conductance"]

    def rates(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> list[Any]:
        return [(port.command - port.voltage(y[0])) * n["conductance"] - y[0] * n["leak"]]

    def powers(self, port: Port, current: Any, y: list[Any], n: Any, xp: Any = np) -> dict[str, Any]:
        v = port.voltage(y[0])
        through = (port.command - v) * n["conductance"]
        return {
            "source": port.command * through,
            "resistor": (port.command - v) * through,
            "leak": v * y[0] * n["leak"],
        }


class VoltageBehindResistor(SeriesResistor):
    """The same with the film's voltage as state: C v' = i - v C' - leak."""

    name = "voltage behind resistor"
    states = (State("voltage_on_film", "voltage on the film", "voltage"),)
    carries_voltage = True

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        return y[0]

    def rates(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> list[Any]:
        return [port.voltage_rate(y[0], self.charging(port, y, n, xp))]

    def charging(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        return (port.command - y[0]) * n["conductance"] - n["leak"] * port.charge(y[0])

    def powers(self, port: Port, current: Any, y: list[Any], n: Any, xp: Any = np) -> dict[str, Any]:
        through = (port.command - y[0]) * n["conductance"]
        lost = (port.command - y[0]) * through
        return {"source": port.command * through, "resistor": lost, "leak": y[0] * port.charge(y[0]) * n["leak"]}


class QuickResistor(Circuit):
    """A resistance without a state, exact to first order in rho: v = v_s - rho d(C v_s)/dtau."""

    name = "quick resistor"
    parameters = {"series_resistance": Quantity("rho", "resistance times C0 Omega0", 0.01, lower=0.0)}

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        x, c = port.displacement, port.capacitance(port.command)
        current = c * port.command_rate + 2.0 * x * port.velocity * port.command
        return port.command - n["series_resistance"] * current


class SaturatingAmplifier(Circuit):
    """The commanded voltage, but no more than +-limit."""

    name = "saturating"
    parameters = {"voltage_limit": Quantity("v_m", "highest voltage of the amplifier", 0.3, positive=True)}

    def numbers(self, parameters: Any) -> dict[str, Any]:
        one = np.ones(np.shape(parameters["voltage_limit"]))
        return {"voltage_limit": parameters["voltage_limit"], "below_top": one, "above_bottom": one}

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        return Border(self._top, "below_top"), Border(self._bottom, "above_bottom")

    def _top(self, port: Port, y: list[Any], n: Any, xp: Any) -> Any:
        return n["below_top"] * (n["voltage_limit"] - port.command)

    def _bottom(self, port: Port, y: list[Any], n: Any, xp: Any) -> Any:
        return n["above_bottom"] * (n["voltage_limit"] + port.command)

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        top, bottom = 0.5 - 0.5 * n["below_top"], 0.5 - 0.5 * n["above_bottom"]
        return (1.0 - top - bottom) * port.command + (top - bottom) * n["voltage_limit"]

    def saturations(self, port: Port, y: list[Any], n: Any) -> dict[str, Any]:
        return {"top_voltage": abs(port.command) - n["voltage_limit"]}


TOYS: dict[str, dict[str, Any]] = {
    "film": {"film": PowerFilm()},
    "waveform": {"waveform": ThreeHarmonics()},
    "bias": {"bias": CubicBias()},
    "circuit": {"circuit": FilteredVoltage()},
}
"""What a model takes to have one of them."""
