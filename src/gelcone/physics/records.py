"""Records of a system's components, plain data for files and results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from gelcone.errors import InputError, check_name
from gelcone.physics.amplifier import ELECTRICS, Amplifier
from gelcone.physics.bias import BIASES, Bias, Together
from gelcone.physics.circuit import ChargeControl, Circuit, IdealSource
from gelcone.physics.component import Component, find_component, to_record
from gelcone.physics.drive import Waveform
from gelcone.physics.film.film import Film
from gelcone.physics.film.gel import GelFilm
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS
from gelcone.physics.system import ConeSystem
from gelcone.physics.waveforms import WAVEFORMS

FILMS: dict[str, Film] = {film.name: film for film in (TautCone(), WrinklingCone(), MembraneFilm())}
CIRCUITS: dict[str, Circuit] = {circuit.name: circuit for circuit in (IdealSource(), Amplifier(), ChargeControl())}
_SHIPPED = {name: to_record(film, FILMS) for name, film in FILMS.items()}


def system_record(system: ConeSystem) -> dict[str, Any]:
    """The record of each component by its kind, and the film's ``law`` and ``prestretch_mode`` if it has them."""
    film = system.film
    own = (
        {"prestretch_mode": film.prestretch_mode, "law": to_record(film.law, LAWS)} if isinstance(film, GelFilm) else {}
    )
    return (
        own
        | {
            "film": film_record(film),
            "bias": bias_record(system.bias),
            "waveform": to_record(system.waveform, WAVEFORMS),
            "circuit": to_record(system.circuit, CIRCUITS),
        }
        | {
            name: value
            for second in system.films[1:]
            for name, value in (("second_film", film_record(second.film)), ("second_drive", second.drive))
        }
    )


def film_record(film: Film) -> Any:
    """The record of a film: its name, with the fields that differ from the default, if it ships."""
    record = to_record(film, FILMS)
    if type(FILMS.get(film.name)) is not type(film):
        return record
    own = {name: value for name, value in record.items() if value != _SHIPPED[film.name][name]}
    own = {name: value for name, value in own.items() if name not in ("law", "prestretch_mode")}
    return {"component": film.name} | own if own else film.name


def find_film(given: Any) -> Film:
    """Make the film that a record describes.

    Raises `InputError` for an unknown name, and for the fitted films of gelcone 0.1 and 0.2 and their files.
    """
    if isinstance(given, str) and (given == "continuum" or given.lstrip().startswith("{") or given.endswith(".json")):
        raise InputError(
            f"{given[:60]!r} is a fitted film of gelcone 0.1 or 0.2, which is not read any more; take film = membrane, "
            "the same membrane without a fit"
        )
    return find_component("film", given, FILMS, Film)  # type: ignore[type-abstract]


def bias_record(bias: Bias) -> Any:
    """The record of a bias; of several their names joined by a plus, or a list where a name is not enough."""
    if not isinstance(bias, Together):
        return to_record(bias, BIASES)
    parts = [to_record(part, BIASES) for part in bias.parts]
    return "+".join(parts) if all(isinstance(part, str) for part in parts) else parts


def find_bias(given: Any) -> Bias:
    """Make the bias of a record, or of several records in a list or joined by a plus.

    Raises `InputError` for an unknown name.
    """
    names = given.split("+") if isinstance(given, str) and "+" in given else given
    if isinstance(names, list | tuple):
        return Together(tuple(find_bias(name.strip() if isinstance(name, str) else name) for name in names))
    return find_component("bias", given, BIASES, Bias)  # type: ignore[type-abstract]


def find_waveform(given: Any) -> Waveform:
    """Make the waveform of a record; `InputError` for an unknown name."""
    return find_component("waveform", given, WAVEFORMS, Waveform)  # type: ignore[type-abstract]


def find_circuit(given: Any) -> Circuit:
    """Make the circuit of a record; `InputError` for an unknown name."""
    return find_component("circuit", given, CIRCUITS, Circuit)  # type: ignore[type-abstract]


_FINDERS: dict[str, Callable[[Any], Component]] = {
    "film": find_film,
    "bias": find_bias,
    "waveform": find_waveform,
    "circuit": find_circuit,
}


def with_numbers(given: Mapping[str, Any]) -> dict[str, Any]:
    """Move the numbers in the tables of components to a model's parameters.

    Raises `InputError` for a name that a table does not take, and for a number that is given twice.
    """
    found = dict(given)
    for kind, find in _FINDERS.items():
        parts = given.get(kind)
        if isinstance(parts, list | tuple):
            found[kind] = [_without_numbers(kind, find, part, found) for part in parts]
        else:
            found[kind] = _without_numbers(kind, find, parts, found)
    return {name: value for name, value in found.items() if name in given or name not in _FINDERS}


def _without_numbers(kind: str, find: Callable[[Any], Component], table: Any, found: dict[str, Any]) -> Any:
    """Return a component's table without its numbers, which are added to ``found``; other components unchanged."""
    if not isinstance(table, Mapping):
        return table
    component = find(table)
    data: list[str] = [field.name for field in fields(component)] if is_dataclass(component) else []
    numbers = [*component.parameters, *(ELECTRICS if isinstance(component, Amplifier) else ())]
    for name in (name for name in table if name not in ("component", *data)):
        check_name(f"field of the {kind} {component.name!r}", name, [*data, *numbers])
        if found.get(name) is not None:
            raise InputError(f"{name}: stands in the table of the {kind} and as a parameter; give it once")
        found[name] = table[name]
    return {name: value for name, value in table.items() if name in ("component", *data)}
