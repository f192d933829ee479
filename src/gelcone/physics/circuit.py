"""Circuits between the commanded voltage and the film: the ideal source, or one with states of its own."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from gelcone.physics.component import Component, Numbers


class Circuit(Component):
    """What turns the commanded voltage into that on the film.

    A new one supplies `voltage` and, for the ``states`` that it adds, `rates`; `gain` where it is linear and its gain
    is not 1. A circuit with states has the period of the voltage itself, since its states follow the voltage's sign.
    """

    @abstractmethod
    def voltage(self, commanded: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Voltage on the film, given the commanded one and the circuit's own states ``y``."""

    def rates(self, commanded: Any, y: list[Any], n: Numbers, xp: Any = np) -> list[Any]:
        """Rates of change of the circuit's states."""
        return []

    def gain(self, frequency: Any, n: Numbers) -> Any:
        """Complex ratio of the film's voltage to the commanded one at an angular frequency (0: a constant voltage)."""
        return 1.0 + 0.0j


class IdealSource(Circuit):
    """The film has the commanded voltage."""

    name = "ideal"

    def voltage(self, commanded: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return commanded


CIRCUITS: dict[str, Circuit] = {circuit.name: circuit for circuit in (IdealSource(),)}
