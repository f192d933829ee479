"""Systems of one film without states and an ideal source, whose force or capacitance can be inverted."""

from __future__ import annotations

from typing import Any

from gelcone.devices.analysis import check_one
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel


def single_film(model: ConeModel, name: str) -> Any:
    """The system of a single model with one film without states and an ideal source, or an `InputError`."""
    system = model.system
    check_one(model, name)
    if len(system.films) > 1:
        raise InputError(f"{name}: takes one film, and here are two; leave second_film out")
    if not system.planar or system.circuit.borders or system.circuit.name != "ideal":
        state_names = ", ".join(state.name for state in system.states[2:]) or system.circuit.name
        raise InputError(
            f"{name}: film, bias and circuit must have no states of their own, and have {state_names}; leave them out"
        )
    return system
