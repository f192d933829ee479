"""Components of one's own for devices: with data, and with parameters that have SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone import Bias, Circuit, Film, Port, Quantity, State, Waveform
from gelcone.physics.drive import VOLTAGE


@dataclass(frozen=True)
class Harmonics(Waveform):
    """v0 + v (sum of a_k sin k), k from 1."""

    shares: tuple[float, ...]

    name = "harmonics"
    parameters = VOLTAGE | {"second": Quantity("h2", "second harmonic over the first", 0.1)}

    def shape(self, phase: Any, n: Any, xp: Any = np) -> Any:
        parts = [share * xp.sin((k + 1.0) * phase) for k, share in enumerate(self.shares)]
        return sum(parts[1:], parts[0]) + n["second"] * xp.sin(2.0 * phase)

    def shape_rate(self, phase: Any, n: Any, xp: Any = np) -> Any:
        parts = [share * (k + 1.0) * xp.cos((k + 1.0) * phase) for k, share in enumerate(self.shares)]
        return sum(parts[1:], parts[0]) + 2.0 * n["second"] * xp.cos(2.0 * phase)


class Filter(Circuit):
    """The film's voltage follows the commanded one: y' = (v - y)/t."""

    name = "filter"
    states = (State("film_voltage", "voltage on the film", "voltage"),)
    parameters = {"filter_time": Quantity("t", "time constant", 0.3, positive=True, scale="time")}

    def voltage(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> Any:
        return y[0]

    def rates(self, port: Port, y: list[Any], n: Any, xp: Any = np) -> list[Any]:
        return [(port.command - y[0]) / n["filter_time"]]

    def gain(self, frequency: Any, n: Any) -> Any:
        return 1.0 / (1.0 + 1j * frequency * n["filter_time"])


class Band(Bias):
    """A rubber band across the disc: F = k1 (x - b) + k3 (x - b)^3."""

    name = "band"
    parameters = {
        "band_rate": Quantity("k1", "stiffness of the band", 0.1, lower=0.0, scale="stiffness"),
        "band_cubic": Quantity("k3", "its cubic stiffness", 0.0, lower=0.0, scale="cubic stiffness"),
        "band_height": Quantity("b", "height at which it is straight", 0.0, scale="length"),
    }

    def force(self, x: Any, y: list[Any], n: Any, xp: Any = np) -> tuple[Any, Any]:
        d = x - n["band_height"]
        return d * (n["band_rate"] + n["band_cubic"] * d * d), n["band_rate"] + 3.0 * n["band_cubic"] * d * d

    def free_height(self, n: Any) -> Any:
        return n["band_height"]


@dataclass(frozen=True)
class PowerFilm(Film):
    """F = c x ((1 + x^2)^p - 1) - V x, with a modulus c over that of the material."""

    exponent: float = 1.5

    name = "power film"
    parameters = {"film_modulus": Quantity("c", "modulus of the film", 0.8, lower=0.0, scale="stress")}

    def force(self, x: Any, squared: Any, y: list[Any], n: Any, xp: Any = np) -> tuple[Any, Any]:
        s = x * x
        stiffness = n["film_modulus"] * ((1.0 + s) ** self.exponent - 1.0)
        slope = n["film_modulus"] * self.exponent * (1.0 + s) ** (self.exponent - 1.0)
        return x * (stiffness - squared), stiffness - squared + 2.0 * s * slope
