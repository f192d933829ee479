"""Records of a system's components, plain data for files and results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from gelcone.errors import InputError, check_name
from gelcone.physics.amplifier import ELECTRICS, Amplifier
from gelcone.physics.bias import BIASES, Bias, Together
from gelcone.physics.circuit import ChargeControl, Circuit, IdealSource
from gelcone.physics.component import find_component, to_record
from gelcone.physics.drive import Waveform
from gelcone.physics.film.film import Film
from gelcone.physics.film.gel import GelFilm
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.physics.system import ConeSystem
from gelcone.physics.waveforms import WAVEFORMS

FILMS: dict[str, Film] = {film.name: film for film in (TautCone(), WrinklingCone(), MembraneFilm())}
CIRCUITS: dict[str, Circuit] = {circuit.name: circuit for circuit in (IdealSource(), Amplifier(), ChargeControl())}
COMPONENTS: Mapping[str, tuple[str, Mapping[str, Any], type[Any]]] = {
    "law": ("strain-energy law", LAWS, StrainEnergyLaw),
    "film": ("film", FILMS, Film),
    "bias": ("bias", BIASES, Bias),
    "waveform": ("waveform", WAVEFORMS, Waveform),
    "circuit": ("circuit", CIRCUITS, Circuit),
}
"""Name of a component in a model -> words for its kind, the components of that kind that ship, and their base class."""
_SHIPPED = {name: to_record(film, FILMS) for name, film in FILMS.items()}


def system_record(system: ConeSystem) -> dict[str, Any]:
    """The record of each component by its kind, and the film's ``law`` and ``prestretch_mode`` if it has them."""
    film = system.film
    record: dict[str, Any] = {}
    if isinstance(film, GelFilm):
        record |= {"prestretch_mode": film.prestretch_mode, "law": to_record(film.law, LAWS)}
    record |= {
        "film": film_record(film),
        "bias": bias_record(system.bias),
        "waveform": to_record(system.waveform, WAVEFORMS),
        "circuit": to_record(system.circuit, CIRCUITS),
    }
    for second in system.films[1:]:
        record |= {"second_film": film_record(second.film), "second_drive": second.drive}
    return record


def film_record(film: Film) -> Any:
    """The record of a film: its name, with the fields that differ from the default, if it ships."""
    record = to_record(film, FILMS)
    if type(FILMS.get(film.name)) is not type(film):
        return record
    differences = {name: value for name, value in record.items() if value != _SHIPPED[film.name][name]}
    differences = {name: value for name, value in differences.items() if name not in ("law", "prestretch_mode")}
    return {"component": film.name} | differences if differences else film.name


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


def find_part(name: str, given: Any) -> Any:
    """Make the component, one of `COMPONENTS`, that a record describes; `InputError` for one that is not known."""
    finder = {"film": find_film, "bias": find_bias}.get(name)
    kind, shipped, base = COMPONENTS[name]
    return find_component(kind, given, shipped, base) if finder is None else finder(given)


def with_numbers(given: Mapping[str, Any]) -> dict[str, Any]:
    """Move the numbers in the tables of components to a model's parameters.

    Raises `InputError` for a name that a table does not take, and for a number that is given twice.
    """
    parameters = dict(given)
    for kind in (kind for kind in COMPONENTS if kind in given and kind != "law"):
        parts = given[kind]
        if isinstance(parts, list | tuple):
            parameters[kind] = [_without_numbers(kind, part, parameters) for part in parts]
        else:
            parameters[kind] = _without_numbers(kind, parts, parameters)
    return parameters


def _without_numbers(kind: str, table: Any, found: dict[str, Any]) -> Any:
    """Return a component's table without its numbers, which are added to ``found``; other components unchanged."""
    if not isinstance(table, Mapping):
        return table
    component = find_part(kind, table)
    data: list[str] = [field.name for field in fields(component)] if is_dataclass(component) else []
    numbers = [*component.parameters, *(ELECTRICS if isinstance(component, Amplifier) else ())]
    for name in (name for name in table if name not in ("component", *data)):
        check_name(f"field of the {kind} {component.name!r}", name, [*data, *numbers])
        if found.get(name) is not None:
            raise InputError(f"{name}: stands in the table of the {kind} and as a parameter; give it once")
        found[name] = table[name]
    return {name: value for name, value in table.items() if name in ("component", *data)}
