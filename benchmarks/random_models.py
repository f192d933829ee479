"""Random cones, their circuits and drives, and a device of two sizes, for `benchmarks/twins.py`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import gelcone
from gelcone.physics.waveforms import Harmonics, Samples, Staircase, Trapezoid

SAME = 4
"""Cases in a row with the same parts."""
UNITS = {
    "length": "l", "time": "t", "velocity": "l/t", "force": "e/l", "stiffness": "e/l**2", "energy": "e", "power": "e/t",
    "apparent power": "e/t", "voltage": "v", "current": "e/t/v", "charge": "e/v", "capacitance": "e/v**2", "field": "f",
    "stress": "e/c", "frequency": "1/t", "rate": "1/t", "gain": "l/v", "admittance": "e/t/v**2", "heating": "e/c/t",
    "energy density": "e/c", "power density": "e/c/t", "specific energy": "l**2/t**2", "slew rate": "v/t",
    "specific power": "l**2/t**3",
}  # fmt: skip
"""Quantities in units of length l, time t, energy e, voltage v, film volume c and field f."""
FIELDS = dict.fromkeys(("disc_radius", "film_radius", "initial_height", "second_flat_height"), "l") | {
    "film_thickness": "h", "spring_rate": "e/l**2", "moving_mass": "e*t**2/l**2", "payload": "e*t**2/l**2",
    "damping_coefficient": "e*t/l**2", "voltage_amplitude": "v", "voltage_offset": "v", "second_voltage": "v",
    "frequency": "1/t", "filter_frequency": "1/t", "dielectric_strength": "f", "gravity": "l/t**2",
    "constant_force": "e/l", "series_resistance": "v**2*t/e", "slew_rate": "v/t", "current_limit": "e/t/v",
    "shear_modulus": "e/c", "relative_permittivity": "e/c/f**2", "resistivity": "t*c*f**2/e", "resistivity_field": "f",
    "viscous_modulus_1": "e/c", "relaxation_time_1": "t",
}  # fmt: skip
"""Fields of a device in these units, and thicknesses h."""


def size(formula: str, units: Mapping[str, float]) -> float:
    """The value of a formula of units."""
    return float(eval(formula, {}, dict(units)))


class Draw:
    """Random choices of parts, the same for `SAME` numbers in a row, since each choice is a program to be compiled, and
    random numbers."""

    def __init__(self, number: int) -> None:
        parts = np.random.default_rng(number // SAME)
        self.choice, self.integers, self._share = parts.choice, parts.integers, parts.random
        self.uniform = np.random.default_rng(number).uniform

    def chance(self, share: float) -> bool:
        """Whether something of that share of cases is there."""
        return bool(self._share() < share)


def cone(draw: Draw, **fixed: Any) -> dict[str, Any]:
    """Parameters of a single cone with a spring and a sine, and ``fixed`` ones."""
    own: dict[str, Any] = {
        "film": str(draw.choice(["taut", "wrinkling", "membrane"], p=[0.85, 0.12, 0.03])),
        "hoop_prestretch": draw.uniform(1.1, 1.6), "meridional_prestretch": draw.uniform(1.0, 1.3),
        "rest_height": draw.uniform(-1.2, 1.2), "spring_stiffness": draw.uniform(0.3, 3.0),
        "damping_ratio": draw.uniform(0.1, 0.5), "dielectric_strength": draw.uniform(0.4, 2.0),
        "voltage": draw.uniform(0.02, 0.4), "voltage_bias": draw.choice([0.0, 1.0, 1.0]) * draw.uniform(-0.5, 0.5),
        "drive_frequency": draw.uniform(0.3, 3.0),
    }  # fmt: skip
    yeoh = {"law": "yeoh", "yeoh_c2": draw.uniform(0.0, 0.02), "yeoh_c3": 1e-3}
    return own | [{"law": "neo-hookean"}, yeoh, {"law": "gent"}][int(draw.integers(3))] | fixed


def circuit(draw: Draw, film: str, single: bool = False) -> dict[str, Any]:
    """Parameters of a circuit: none, charge control, or an amplifier; before a film that wrinkles none."""
    kind = draw.integers(5) if film == "taut" else 0
    if kind < 2:
        return [{}, {"circuit": "charge"}][int(kind)]
    own: dict[str, Any] = {"series_resistance": draw.uniform(0.05, 1.0)}
    if draw.chance(0.5):
        own |= {"leakage_time": draw.uniform(5.0, 50.0)} | ({"leakage_field": 0.4} if draw.chance(0.5) else {})
    if draw.chance(0.4):
        own |= {"filter_time": draw.uniform(0.05, 0.5)} | ({"slew_rate": 0.3} if draw.chance(0.5) else {})
    if draw.chance(0.3):
        own |= {"current_limit": draw.uniform(0.05, 0.5)}
    if single and draw.chance(0.3):
        own |= {"dielectric_share": 0.3, "dielectric_time": draw.uniform(0.5, 4.0)}
    return own


def second(draw: Draw, film: str) -> dict[str, Any]:
    """Parameters of a second film."""
    return {
        "second_film": film, "second_flat_height": draw.uniform(0.0, 1.6),
        "second_hoop_prestretch": draw.uniform(1.1, 1.6), "second_meridional_prestretch": draw.uniform(1.0, 1.3),
        "second_drive": str(draw.choice(["same", "opposite"])),
    }  # fmt: skip


def creep(draw: Draw) -> dict[str, Any]:
    """Parameters of a Maxwell branch, or none."""
    return {"viscous_modulus_1": 0.4, "relaxation_time_1": draw.uniform(0.5, 5.0)} if draw.chance(0.3) else {}


def actuator(draw: Draw, double: float = 0.5, **fixed: Any) -> dict[str, Any]:
    """Parameters of a single cone or, in that share of cases, a double one, with creep and circuit."""
    own = cone(draw, **fixed)
    own |= creep(draw) | circuit(draw, own["film"], single=not double)
    return own | (second(draw, own["film"]) if draw.chance(double) else {})


def terms(draw: Draw) -> tuple[tuple[float, float, float], ...]:
    """One to three harmonics of a voltage."""
    return tuple((k, draw.uniform(0.2, 1.0), draw.uniform(0.0, 6.0)) for k in range(1, int(draw.integers(2, 5))))


def waves_of_both_signs(draw: Draw) -> tuple[Any, Any]:
    """A waveform and its negative."""
    kind, drawn, levels = draw.integers(3), terms(draw), tuple(draw.uniform(-1.0, 1.0, 4))
    if kind == 0:
        return Harmonics(drawn), Harmonics(tuple((k, -a, phi) for k, a, phi in drawn))
    opposite = tuple(-level for level in levels)
    if kind == 1:
        return Staircase(levels, 0.3), Staircase(opposite, 0.3)
    shares = (0.0, *np.sort(draw.uniform(0.05, 0.95, 3)), 1.0)
    return tuple(Samples(shares, (*own, own[0]), repeat=True) for own in (levels, opposite))


def one_wave_twice(draw: Draw) -> tuple[dict[str, Any], dict[str, Any]]:
    """A waveform with its numbers in two forms."""
    rise, high, fall = draw.uniform(0.05, 0.3, 3)
    edges = (0.0, 0.5 * rise, 0.5 * rise + high, 0.5 * rise + high + fall, 1.0 - 0.5 * rise, 1.0)
    trapezoid = Samples(edges, (0.0, 1.0, 1.0, -1.0, -1.0, 0.0), repeat=True)
    triangle = Samples((0.0, 0.25, 0.75, 1.0), (0.0, 1.0, -1.0, 0.0), repeat=True)
    square = {"waveform": "square", "duty": 0.4, "rise": 0.1}
    forms: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({"waveform": "triangle"}, {"waveform": triangle}),
        ({"waveform": "trapezoid", "rise": rise, "high": high, "fall": fall}, {"waveform": trapezoid}),
        (square, {"waveform": Trapezoid(), "rise": 0.1, "high": 0.3, "fall": 0.1}),
        ({"waveform": "sine"}, {"waveform": Harmonics(((1, 1.0, 0.0),))}),
    ]
    return forms[int(draw.integers(len(forms)))]


def devices_of_two_sizes(draw: Draw) -> tuple[gelcone.Device, gelcone.Device, dict[str, float]]:
    """Two devices with the same dimensionless numbers, and the units of the second over those of the first."""
    gel: dict[str, Any] = {"shear_modulus": draw.uniform(5e3, 2e4), "relative_permittivity": 50.0, "heat_capacity": 2e6}
    own: dict[str, Any] = {
        "disc_radius": draw.uniform(5e-3, 9e-3), "film_radius": draw.uniform(25e-3, 35e-3), "film_thickness": 2e-4,
        "film": str(draw.choice(["taut", "wrinkling"], p=[0.8, 0.2])), "hoop_prestretch": draw.uniform(1.2, 1.6),
        "spring_rate": draw.uniform(5.0, 30.0), "initial_height": draw.uniform(0.005, 0.02), "moving_mass": 4e-3,
        "damping_coefficient": draw.uniform(0.05, 0.2), "voltage_amplitude": draw.uniform(50.0, 300.0),
        "voltage_offset": draw.uniform(-700.0, 700.0), "frequency": draw.uniform(3.0, 15.0), "dielectric_strength": 1e7,
    }  # fmt: skip
    if draw.chance(0.5):
        own |= {"gravity": 9.81, "payload": 1e-3, "constant_force": draw.uniform(-0.05, 0.05)}
    if draw.chance(0.5) and own["film"] == "taut":
        own |= {"series_resistance": 1e7 * draw.uniform(0.1, 2.0), "filter_frequency": 300.0, "slew_rate": 1e5}
        own |= {"current_limit": 1e-4 * draw.uniform(0.5, 2.0)}
        gel |= {"resistivity": draw.uniform(1e9, 1e10), "resistivity_field": 5e6}
    if draw.chance(0.3) and own["film"] == "taut":
        gel |= {"viscous_modulus_1": 4e3, "relaxation_time_1": draw.uniform(0.005, 0.05)}
    if draw.chance(0.5):
        own |= {"second_film": own["film"], "second_flat_height": 0.025, "second_drive": "constant"}
        own |= {"second_voltage": draw.uniform(100.0, 500.0)}
    units = {unit: draw.uniform(0.3, 3.0) for unit in "lteh"} | {"v": draw.uniform(0.5, 2.0)}
    units |= {"c": units["l"] ** 2 * units["h"], "f": units["v"] / units["h"]}

    def scaled(given: dict[str, Any]) -> dict[str, Any]:
        return given | {name: given[name] * size(unit, units) for name, unit in FIELDS.items() if name in given}

    return gelcone.Device(**own, material=gel), gelcone.Device(**scaled(own), material=scaled(gel)), units
